//! The seam of a simulated cell, and the picture of it from any place.

use std::str::FromStr;

use super::CellSettings;
use crate::frame::GrayFrame;
use crate::synth::scenario::{PathTerm, Severity, Tack};
use crate::synth::{Scenario, ScenarioError, Scene, builtin};

/// From one frame of the scene to the next \[mm\]. Chosen: half of what the torch travels between two pictures.
const STEP_MM: f64 = 0.25;
/// Amplitude and length of the sine \[mm\].
const SINE_MM: f64 = 3.0;
const SINE_LENGTH_MM: f64 = 200.0;
/// Slope of the corners' sides, and how many there are. Chosen: within 5 mm of the taught line.
const CORNER_SLOPE: f64 = 0.04;
const CORNER_SIDES: usize = 6;
/// Drift of a seam with tack welds, their length and distance \[mm\].
const TACK_SLOPE: f64 = 0.005;
const TACK_MM: f64 = 8.0;
const TACK_EVERY_MM: f64 = 100.0;
/// What is seen behind the end of the weld \[mm\].
const BEYOND_MM: f64 = 30.0;

/// A butt joint's course and light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellScene {
    /// ± 3 mm, 200 mm long, no arc.
    Sine,
    /// Sharp corners of 4.6°, no arc.
    Corner,
    /// A slight drift with tack welds of 8 mm each 100 mm, no arc.
    Tack,
    /// The sine under medium arc and spatter.
    Arc,
}

impl FromStr for CellScene {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "sine" => Ok(Self::Sine),
            "corner" => Ok(Self::Corner),
            "tack" => Ok(Self::Tack),
            "arc" => Ok(Self::Arc),
            _ => Err("expected sine, corner, tack or arc".into()),
        }
    }
}

/// The seam, and pictures of it.
pub struct Seam {
    scene: Scene,
    ahead_mm: f64,
    mm_per_px: f64,
    /// The seam's column in each frame of the scene, from that of the first \[px\].
    columns_px: Vec<f64>,
    /// By how much pictures are moved so that the seam's start is in their middle \[px\].
    to_middle_px: f64,
}

impl Seam {
    pub fn new(settings: &CellSettings) -> Result<Self, ScenarioError> {
        let mut scenario = builtin::scenario("A-butt")?;
        let span_mm = settings.length_mm + settings.ahead_mm + BEYOND_MM;
        scenario.frames = (span_mm / STEP_MM).ceil() as usize;
        scenario.variation = 0.0;
        scenario.seed = settings.seed;
        scenario.severity = Severity::Clean;
        lay(&mut scenario, settings.scene);
        let scene = Scene::new(&scenario, settings.seed)?;
        let mut columns_px: Vec<f64> = vec![];
        for frame in 0..scene.frame_count() {
            let last = columns_px.last().copied().unwrap_or(0.0);
            columns_px.push(scene.truth(frame).seam.map_or(last, |seam| seam.u_px));
        }
        let start_px = columns_px.first().copied().unwrap_or(0.0);
        columns_px.iter_mut().for_each(|column_px| *column_px -= start_px);
        let middle_px = (scenario.image.width_px as f64 - 1.0) / 2.0;
        Ok(Self {
            scene,
            ahead_mm: settings.ahead_mm,
            mm_per_px: scenario.mm_per_px.get(),
            columns_px,
            to_middle_px: middle_px - start_px,
        })
    }

    /// The seam at a place of the path, from the taught line \[mm\].
    pub fn lateral_mm(&self, path_mm: f64) -> f64 {
        let place = (path_mm / STEP_MM).clamp(0.0, (self.columns_px.len() - 2) as f64);
        let (before, share) = (place as usize, place.fract());
        let (a, b) = (self.columns_px[before], self.columns_px[before + 1]);
        (a + share * (b - a)) * self.mm_per_px
    }

    /// What the camera sees when the torch stands at `path_mm`, `lateral_mm` beside the taught line.
    pub fn picture(&self, path_mm: f64, lateral_mm: f64) -> GrayFrame {
        let place_mm = (path_mm + self.ahead_mm).max(0.0);
        let frame = ((place_mm / STEP_MM).round() as usize).min(self.scene.frame_count() - 1);
        // The frame stands for its own place; the seam's way from there to here is little.
        let on_px = self.lateral_mm(place_mm) / self.mm_per_px - self.columns_px[frame];
        moved(&self.scene.render(frame), self.to_middle_px + on_px - lateral_mm / self.mm_per_px)
    }
}

fn lay(scenario: &mut Scenario, scene: CellScene) {
    let px = |mm: f64| mm / scenario.mm_per_px.get();
    let frames = |mm: f64| mm / STEP_MM;
    let sine = || PathTerm::Sine { amplitude_px: px(SINE_MM), period_frames: frames(SINE_LENGTH_MM), phase_deg: 0.0 };
    let path = match scene {
        CellScene::Sine | CellScene::Arc => sine(),
        CellScene::Corner => {
            let slope = px(CORNER_SLOPE * STEP_MM);
            PathTerm::Polyline {
                px_per_frame: (0..CORNER_SIDES).map(|i| if i % 2 == 0 { slope } else { -slope }).collect(),
            }
        }
        CellScene::Tack => PathTerm::Straight { px_per_frame: px(TACK_SLOPE * STEP_MM) },
    };
    if scene == CellScene::Tack {
        let tacks = scenario.frames as f64 * STEP_MM / TACK_EVERY_MM;
        scenario.tacks = (1..tacks as usize)
            .map(|i| {
                let from_mm = i as f64 * TACK_EVERY_MM;
                let (from_frame, to_frame) = (frames(from_mm) as usize, frames(from_mm + TACK_MM) as usize);
                Tack { from_frame, to_frame, height_px: 7.0, half_width_px: 26.0 }
            })
            .collect();
    }
    scenario.path = vec![path];
    if scene == CellScene::Arc {
        scenario.severity = Severity::Medium;
    }
}

/// The picture moved along its rows; what comes in at a border is the border's pixel.
fn moved(picture: &GrayFrame, by_px: f64) -> GrayFrame {
    let (whole, share) = (by_px.floor() as isize, (by_px - by_px.floor()) as f32);
    let last = picture.width_px() as isize - 1;
    let mut out = picture.clone();
    let width = picture.width_px();
    for (v, to) in out.pixels_mut().chunks_exact_mut(width).enumerate() {
        let row = picture.row(v);
        let at = |u: isize| f32::from(row[u.clamp(0, last) as usize]);
        for (u, grey) in to.iter_mut().enumerate() {
            let from = u as isize - whole;
            *grey = (at(from) + share * (at(from - 1) - at(from))).round() as u8;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_moves_by_parts_of_a_pixel() {
        let picture = GrayFrame::new(4, 1, vec![0, 100, 0, 0]).unwrap();
        assert_eq!(moved(&picture, 1.0).pixels(), [0, 0, 100, 0]);
        assert_eq!(moved(&picture, 0.25).pixels(), [0, 75, 25, 0]);
        assert_eq!(moved(&picture, -0.25).pixels(), [25, 75, 0, 0]);
    }

    #[test]
    fn the_seam_begins_on_the_taught_line_and_the_camera_sees_its_start_in_the_middle() {
        let settings = CellSettings { length_mm: 50.0, ..CellSettings::default() };
        let seam = Seam::new(&settings).unwrap();
        assert!(seam.lateral_mm(0.0).abs() < 1e-9 && (seam.lateral_mm(50.0) - 3.0).abs() < 0.01);
    }
}
