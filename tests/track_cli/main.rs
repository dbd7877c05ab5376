//! `seamtrack track` as a user meets it, on the demonstration's recording.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bad_config;
mod bad_frames;
mod batch;
mod broken_recordings;
mod contract;
mod exit_codes;
mod full_disk;
mod golden;
mod kinds;
mod limits;
mod mcap_logs;
mod messages;
mod outputs;
mod program;
mod same_bytes;
mod seed_at;
mod tolerance;
mod users_files;
mod videos;
mod where_to_look;
mod whole_or_absent;
