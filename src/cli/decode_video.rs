//! `seamtrack decode-video`: what the program runs to decode a video, so that a decoder that hangs or crashes can be ended
//! and takes nothing with it. Not for people.

use std::io::Read;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use seamtrack::source::{Period, decode_videos_by, serve_video};

/// For how long a decoder may give nothing \[s\]. Chosen: a frame from a slow network takes a second.
const PATIENCE_S: f64 = 30.0;
/// The environment variable that changes it.
const PATIENCE: &str = "SEAMTRACK_VIDEO_PATIENCE_S";
const LONGEST_PATIENCE_S: f64 = 86_400.0;

/// Decode a video onto standard output, for the program itself
#[derive(Debug, Args)]
pub struct DecodeVideo {
    /// Time from frame to frame [s]
    #[arg(long, required_unless_present = "period_unless_own")]
    period: Option<f64>,
    /// The same, where the video has none
    #[arg(long, conflicts_with = "period")]
    period_unless_own: Option<f64>,
    /// The video
    file: PathBuf,
}

impl DecodeVideo {
    /// Decodes until the video or this program's standard input ends.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        // Whoever waits for the frames holds the other end: without it there is nothing to do, whatever the decoder does.
        std::thread::spawn(|| {
            let _ended = std::io::stdin().lock().read_to_end(&mut vec![]);
            signal_hook::low_level::exit(1);
        });
        let period = match (self.period, self.period_unless_own) {
            (Some(period_s), _) => Period::Given(period_s),
            (None, own) => Period::OwnOr(own.unwrap_or(1.0)),
        };
        let decoded = serve_video(&self.file, period, std::io::stdout().lock());
        Ok(if decoded.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}

/// From now on videos are decoded by this program, run once more.
pub fn in_another_process() {
    let asked = std::env::var(PATIENCE).ok().and_then(|text| text.parse::<f64>().ok());
    let patience_s = asked.filter(|s| *s > 0.0 && *s <= LONGEST_PATIENCE_S).unwrap_or(PATIENCE_S);
    if let Ok(program) = std::env::current_exe() {
        decode_videos_by(program, Duration::from_secs_f64(patience_s));
    }
}
