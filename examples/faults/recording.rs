//! A made-up recording, wider than the camera sees: where the camera looks is a window in it.

use anyhow::Result;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use seamtrack::frame::GrayFrame;
use seamtrack::synth::scenario::{Extent, Joint, Recorder, Rivals, SecondSeam};
use seamtrack::synth::{Scenario, Scene, builtin};
use seamtrack::units::{PixelPoint, StripeAxis};

/// The joints, each by its plain scene.
pub const JOINTS: [&str; 5] = ["A-butt", "B-lap", "D-vgroove-sine", "E-fillet", "hairline"];
/// Length \[frames\].
pub const FRAMES: usize = 170;
/// The camera's picture along the stripe and across it \[px\], but for the hairline, whose stripe ends in its picture.
const WINDOW_PX: (usize, usize) = (400, 360);
/// What is rendered beyond it on each side \[px\].
const MARGINS_PX: (usize, usize) = (280, 20);
const HAIRLINE_MARGINS_PX: (usize, usize) = (40, 20);

/// Frames of one scene, wider than the camera's picture.
pub struct Recording {
    /// Name of the joint's scene.
    pub joint: &'static str,
    /// Seed of the campaign, number among the recordings of the joint.
    pub seed: u64,
    pub number: u64,
    /// The scene.
    pub scene: Scene,
    frames: Vec<GrayFrame>,
    margins_px: (usize, usize),
}

/// Where the camera looks: its window's place from the middle one, along the stripe and across it \[px\].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Look {
    pub along_px: i32,
    pub across_px: i32,
}

impl Recording {
    /// Renders the recording; the same for the same numbers.
    pub fn render(joint: &'static str, seed: u64, number: u64) -> Result<Self> {
        let (scenario, margins_px) = scenario(joint)?;
        let scene = Scene::new(&scenario, 1000 * seed + number)?;
        let frames = (0..scene.frame_count()).map(|frame| scene.render(frame)).collect();
        Ok(Self { joint, seed, number, scene, frames, margins_px })
    }

    /// Random numbers for a use of this recording.
    pub fn random(&self, what: u64) -> Pcg64Mcg {
        let joint = JOINTS.iter().position(|joint| *joint == self.joint).unwrap_or(0) as u64;
        Pcg64Mcg::seed_from_u64(self.seed << 32 | self.number << 24 | joint << 16 | what)
    }

    /// What the camera sees of a frame.
    pub fn picture(&self, frame: usize, look: Look) -> Result<GrayFrame> {
        self.through_window(&self.frames[frame], look)
    }

    /// The same of another scene of the same size.
    pub fn picture_of(&self, scene: &Scene, frame: usize, look: Look) -> Result<GrayFrame> {
        self.through_window(&scene.render(frame), look)
    }

    fn through_window(&self, wide: &GrayFrame, look: Look) -> Result<GrayFrame> {
        let (left, top) = self.corner(look);
        let (width, height) = self.window_px();
        let rows = top..top + height;
        let pixels = rows.flat_map(|v| wide.row(v)[left..left + width].iter().copied()).collect();
        Ok(GrayFrame::new(width, height, pixels)?)
    }

    /// Column and row where the window begins.
    fn corner(&self, look: Look) -> (usize, usize) {
        let place = |margin: usize, by: i32| margin.saturating_add_signed(by as isize).min(2 * margin);
        let (along, across) = (place(self.margins_px.0, look.along_px), place(self.margins_px.1, look.across_px));
        match self.scene.axis() {
            StripeAxis::Horizontal => (along, across),
            StripeAxis::Vertical => (across, along),
        }
    }

    /// Columns and rows of the camera's picture.
    pub fn window_px(&self) -> (usize, usize) {
        let image = &self.scene.drawn_scenario().image;
        let (along, across) = match self.scene.axis() {
            StripeAxis::Horizontal => (self.margins_px.0, self.margins_px.1),
            StripeAxis::Vertical => (self.margins_px.1, self.margins_px.0),
        };
        (image.width_px - 2 * along, image.height_px - 2 * across)
    }

    /// Farthest that the camera can be moved along the stripe \[px\].
    pub const fn reach_px(&self) -> usize {
        self.margins_px.0
    }

    /// Where the seam of `scene` is in the camera's picture, or beside it; none where there is no seam.
    pub fn seam(&self, scene: &Scene, frame: usize, look: Look) -> Option<PixelPoint> {
        let (left, top) = self.corner(look);
        let seam = scene.truth(frame).seam?;
        Some(PixelPoint::new(seam.u_px - left as f64, seam.v_px - top as f64))
    }

    /// Whether a point is in the camera's picture.
    pub fn shows(&self, point: PixelPoint) -> bool {
        let (width, height) = self.window_px();
        let within = |px: f64, size: usize| px >= 0.0 && px < size as f64;
        within(point.u_px, width) && within(point.v_px, height)
    }

    /// The same recording with its laser off.
    pub fn without_stripe(&self) -> Result<Scene> {
        self.changed(|scenario| scenario.stripe.amplitude_grey = 1.0)
    }

    /// The same with a second seam `beside_px` from the first; none where the joint can have no second.
    pub fn with_second_seam(&self, beside_px: f64) -> Result<Option<Scene>> {
        if matches!(self.scene.drawn_scenario().joint, Joint::Fillet(_)) {
            return Ok(None);
        }
        let rivals = Rivals { second_seam: Some(SecondSeam { beside_px }), ..Rivals::default() };
        self.changed(|scenario| scenario.rivals = rivals).map(Some)
    }

    /// The same plates with no joint.
    pub fn without_joint(&self) -> Result<Scene> {
        self.changed(|scenario| scenario.joint = Joint::Flat)
    }

    /// Another joint on plates of the same size, somewhere else.
    pub fn another_joint(&self, joint: &str) -> Result<Scene> {
        let (mut scenario, _) = scenario(joint)?;
        scenario.image = self.scene.drawn_scenario().image.clone();
        Ok(Scene::new(&scenario, 1000 * self.seed + self.number + 500)?)
    }

    /// The scene as drawn, changed in one thing.
    fn changed(&self, change: impl FnOnce(&mut Scenario)) -> Result<Scene> {
        let (mut scenario, _) = scenario(self.joint)?;
        change(&mut scenario);
        Ok(Scene::new(&scenario, 1000 * self.seed + self.number)?)
    }
}

/// The scenario of a joint, and what of its picture lies beyond the camera's.
fn scenario(joint: &str) -> Result<(Scenario, (usize, usize))> {
    let mut scenario = builtin::scenario(joint)?;
    (scenario.frames, scenario.extent, scenario.recorder) = (FRAMES, Extent::default(), Recorder::default());
    let margins_px = if joint == "hairline" { HAIRLINE_MARGINS_PX } else { MARGINS_PX };
    let image = &mut scenario.image;
    if joint == "hairline" {
        (image.width_px, image.height_px) = (image.width_px + 2 * margins_px.1, image.height_px + 2 * margins_px.0);
    } else {
        (image.width_px, image.height_px) = (WINDOW_PX.0 + 2 * margins_px.0, WINDOW_PX.1 + 2 * margins_px.1);
    }
    Ok((scenario, margins_px))
}
