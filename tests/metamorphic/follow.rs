//! The tracker, behind what these tests need of it: a change of its interface touches this file only.

use seamtrack::calib::Sensor;
use seamtrack::config::Config;
use seamtrack::frame::GrayFrame;
use seamtrack::tracker::{SeamEstimate, SeamPath, Session, SessionSettings, Status};
use seamtrack::units::MmPerPx;

/// What is said of the seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Says {
    /// No value.
    Nothing,
    /// Seen in this frame.
    Seen,
    /// Not seen: a prediction.
    Predicted,
}

/// A position along the stripe \[mm\], from the middle of the first pixel, and its σ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    pub mm: f64,
    pub std_mm: f64,
}

/// What the tracker says of a recording, frame by frame.
#[derive(Debug, Clone)]
pub struct Path {
    pub says: Vec<Says>,
    pub causal: Vec<Option<Value>>,
    pub smoothed: Vec<Option<Value>>,
}

impl Path {
    /// The path in other coordinates of the same scale.
    pub fn map_mm(self, map: impl Fn(f64) -> f64) -> Self {
        let mapped = |values: Vec<Option<Value>>| {
            values.into_iter().map(|value| value.map(|v| Value { mm: map(v.mm), ..v })).collect()
        };
        Self { says: self.says, causal: mapped(self.causal), smoothed: mapped(self.smoothed) }
    }

    /// Only the frames 0, 2, 4 and so on.
    pub fn every_second(self) -> Self {
        let half = |values: Vec<Option<Value>>| values.into_iter().step_by(2).collect();
        let says = self.says.into_iter().step_by(2).collect();
        Self { says, causal: half(self.causal), smoothed: half(self.smoothed) }
    }
}

/// Tracks frames `period_s` apart at a known scale; joint, direction and seam are found.
pub fn follow(frames: &[GrayFrame], period_s: f64, mm_per_px: f64) -> Path {
    let config = Config { period_s, ..Config::default() };
    let sensor = Sensor::Scale(MmPerPx::new(mm_per_px).unwrap());
    let mut session =
        Session::new(&SessionSettings { sensor, ..SessionSettings::new(config.method().unwrap()) }).unwrap();
    let mut path = SeamPath::default();
    let value = |px: f64, std_px: f64| Value { mm: mm_per_px * px, std_mm: mm_per_px * std_px };
    let (mut says, mut causal) = (vec![], vec![]);
    for (i, frame) in frames.iter().enumerate() {
        let estimate = session.step(frame, i as f64 * period_s).unwrap();
        says.push(match estimate.status {
            Status::Tracked => Says::Seen,
            Status::Coasting => Says::Predicted,
            Status::Seeking | Status::Lost => Says::Nothing,
        });
        path.push(&estimate);
        let seam = estimate.seam.zip(session.axis());
        causal.push(seam.map(|(seam, axis)| value(axis.along_px(seam.centre), seam.std_px)));
    }
    let along = |seam: SeamEstimate| value(session.axis().unwrap().along_px(seam.centre), seam.std_px);
    let smoothed = path.smoothed().unwrap().into_iter().map(|seam| seam.map(along)).collect();
    Path { says, causal, smoothed }
}
