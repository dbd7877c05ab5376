//! One run of the program on a recording with a fault, and what it claimed.

use anyhow::Result;
use seamtrack::config::Config;
use seamtrack::eval::WRONG_MM;
use seamtrack::report::results::{PathRow, Status};
use seamtrack::units::PixelPoint;

use crate::apply::{Struck, struck};
use crate::kinds::Kind;
use crate::recording::Recording;
use crate::replay::{Shot, replay};

/// Values that should not be there, and how far off the farthest is \[mm\].
#[derive(Debug, Clone, Copy, Default)]
pub struct Claims {
    /// Off by over 1 mm.
    pub wrong: usize,
    /// Given where there is no seam.
    pub invented: usize,
    pub largest_mm: f64,
}

/// What became of a run.
pub struct Run {
    pub kind: Kind,
    pub joint: &'static str,
    pub number: u64,
    pub repeat: u64,
    pub first: usize,
    /// The seam was tracked when the fault struck.
    pub was_tracked: bool,
    /// Values in frames in which the seam is said to be seen, and in which it is said to be predicted.
    pub tracked: Claims,
    pub coasting: Claims,
    pub smoothed: Claims,
    /// Frames until the status says that the seam is not seen; none where it never did, or was not hidden.
    pub is_hidden: bool,
    pub noticed: Option<usize>,
    /// Frames from the seam's return until it is tracked and not wrong.
    pub comes_back: bool,
    pub again: Option<usize>,
    pub rows: Vec<PathRow>,
    pub seams_px: Vec<Option<f64>>,
    pub mm_per_px: f64,
}

impl Run {
    /// Whether nothing wrong was said.
    pub const fn is_right(&self) -> bool {
        self.tracked.wrong + self.coasting.wrong + self.smoothed.wrong + self.tracked.invented == 0
    }
}

fn drawn(recording: &Recording, kind: Kind, repeat: u64) -> Result<Option<Struck>> {
    let number = Kind::ALL.iter().position(|known| *known == kind).unwrap_or(0) as u64;
    struck(recording, kind, &mut recording.random(number << 8 | repeat))
}

/// The frames of a run.
pub fn shots(recording: &Recording, kind: Kind, repeat: u64) -> Result<Option<Vec<Shot>>> {
    Ok(drawn(recording, kind, repeat)?.map(|struck| struck.shots))
}

/// Runs the program on the recording with the fault; none where it cannot strike.
pub fn run(recording: &Recording, kind: Kind, repeat: u64) -> Result<Option<Run>> {
    let Some(struck) = drawn(recording, kind, repeat)? else { return Ok(None) };
    let Struck { shots, seams, first, hidden, returns } = struck;
    let scale = recording.scene.drawn_scenario().mm_per_px;
    let config = Config { mm_per_px: Some(scale), ..Config::default() };
    let rows = replay(shots, &config)?.rows;

    let axis = recording.scene.axis();
    let seams_px: Vec<Option<f64>> = seams.iter().map(|seam| seam.map(|seam| axis.along_px(seam))).collect();
    let off_mm = |along_px: f64, frame: usize| seams_px[frame].map(|seam| scale.get() * (along_px - seam).abs());
    let along = |u: Option<f64>, v: Option<f64>| Some(axis.along_px(PixelPoint::new(u?, v?)));
    // What was said before the fault is not its doing; the smoother may have known of it.
    let claims = |from: usize, of: &dyn Fn(&PathRow) -> Option<f64>| {
        let mut claims = Claims::default();
        for (frame, row) in rows.iter().enumerate().skip(from) {
            let Some(along_px) = of(row) else { continue };
            match off_mm(along_px, frame) {
                None => claims.invented += 1,
                Some(mm) => {
                    claims.wrong += usize::from(mm > WRONG_MM);
                    claims.largest_mm = claims.largest_mm.max(mm);
                }
            }
        }
        claims
    };
    let causal = |status: Status| claims(first, &|row| along(row.u_px, row.v_px).filter(|_| row.status == status));
    let is_seen = |frame: usize| rows[frame].status == Status::Tracked;
    let is_right = |frame: usize| {
        let value = along(rows[frame].u_px, rows[frame].v_px);
        is_seen(frame) && value.and_then(|px| off_mm(px, frame)).is_some_and(|mm| mm <= WRONG_MM)
    };
    let after = |from: usize, is: &dyn Fn(usize) -> bool| (from..rows.len()).position(is);
    Ok(Some(Run {
        kind,
        joint: recording.joint,
        number: recording.number,
        repeat,
        first,
        was_tracked: is_right(first - 1),
        tracked: causal(Status::Tracked),
        coasting: causal(Status::Coasting),
        smoothed: claims(0, &|row| along(row.smooth_u_px, row.smooth_v_px)),
        is_hidden: hidden.is_some(),
        noticed: hidden.and_then(|hidden| after(hidden, &|frame| !is_seen(frame))),
        comes_back: returns.is_some(),
        again: returns.and_then(|returns| after(returns, &is_right)),
        seams_px,
        mm_per_px: scale.get(),
        rows,
    }))
}
