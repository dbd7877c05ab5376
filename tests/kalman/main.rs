//! The filters against references that share no code with them.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

mod consistency;
mod dense;
mod fit;
mod imm;
mod parameters;
mod simulation;
mod smoothers;
mod vectors;
