//! The method of Du 2022: centreline seed, KCF with PSR-gated template, augmented Kalman filter.
//!
//! It is right for one straight seam with edges. Its gate does not notice a template that slides along the stripe, so
//! "tracked" means here only that the KCF answered.

use super::TrackerError;
use super::clock::Tick;
use super::estimate::{Estimate, JointDecision, KcfReading, Observation, SeamEstimate, Status};
use super::lag::Links;
use super::path::Memory;
use super::picture::Picture;
use super::session::{Follow, unseen};
use super::view::{Field, View};
use crate::frame::GrayFrame;
use crate::imgproc::{
    CentrelineSettings, MedianKernel, Raster, SeedSettings, extract_centreline, find_seam_features, median,
};
use crate::kalman::{ColouredMeasurement, Gaussian};
use crate::kcf::{Kcf, KcfSettings, Response};
use crate::units::{PixelPoint, StripeAxis};

/// One σ of a KCF peak across the stripe \[px\]: it is given as it is. Chosen: a whole pixel, as the peak is.
const PEAK_STD_PX: f64 = 1.0;

/// The numbers of the paper's method.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperSettings {
    /// Median before everything.
    pub median: MedianKernel,
    /// What counts as stripe in the seed frame.
    pub centreline: CentrelineSettings,
    /// What counts as seam in the seed frame.
    pub seed: SeedSettings,
    /// The correlation filter.
    pub kcf: KcfSettings,
    /// T: the template is updated at this PSR or above (Du 2022, section 3.3).
    pub psr_threshold: f64,
    /// η of eq. 8.
    pub learning_rate: f64,
    /// The filter's noise model.
    pub kalman: ColouredMeasurement,
    /// Variance of the seed's position \[px²\].
    pub seed_variance_px2: f64,
}

impl Default for PaperSettings {
    fn default() -> Self {
        Self {
            median: MedianKernel::Five,
            centreline: CentrelineSettings::default(),
            seed: SeedSettings::default(),
            kcf: KcfSettings::du_2022(),
            psr_threshold: 8.0,
            learning_rate: 0.03,
            kalman: ColouredMeasurement::printed(),
            seed_variance_px2: ColouredMeasurement::CLEAN_VARIANCE_PX2,
        }
    }
}

/// The paper's tracker, on frames of which the stripe is horizontal.
pub struct PaperTracker {
    settings: PaperSettings,
    kcf: Kcf,
    seed_at: Option<PixelPoint>,
    joint: Option<JointDecision>,
    frame_number: usize,
    field: Field,
    state: State,
}

/// Where the method is on its way.
enum State {
    Seeking,
    Following { filter: Gaussian<3>, peak: PixelPoint },
    Lost,
}

impl PaperTracker {
    /// A tracker that looks for its seed.
    ///
    /// # Errors
    /// When a KCF setting is out of range.
    pub fn new(settings: &PaperSettings) -> Result<Self, TrackerError> {
        Ok(Self {
            kcf: Kcf::new(settings.kcf)?,
            settings: settings.clone(),
            seed_at: None,
            joint: None,
            frame_number: 0,
            field: Field::whole(StripeAxis::Horizontal),
            state: State::Seeking,
        })
    }

    /// Looks for the seam in the whole frame and starts the filter there.
    fn seed(&mut self, frame: &GrayFrame, was_lost: bool) -> Result<Estimate, TrackerError> {
        let line = extract_centreline(frame, &self.settings.centreline);
        let asked = self.seed_at.take();
        let Some(centre) = asked.or_else(|| find_seam_features(&line, &self.settings.seed).map(|f| f.centre())) else {
            let seen = line.extent(self.settings.seed.widest_joint_px).is_some();
            let observation = if seen { Observation::NoSeam } else { Observation::NoStripe };
            let status = if was_lost { Status::Lost } else { Status::Seeking };
            return Ok(Estimate { status, ..Estimate::seeking(observation) });
        };
        self.kcf.train(frame, centre);
        self.joint.get_or_insert_with(|| JointDecision {
            kind: "butt-or-lap",
            frame: self.frame_number - 1,
            reason: "the centreline jumps or breaks at one place".into(),
            doubt: None,
            contradicted_by: None,
        });
        let filter = self.settings.kalman.start_from_clean(centre.u_px, self.settings.seed_variance_px2)?;
        let seam = seam(&filter, centre.v_px);
        self.state = State::Following { filter, peak: centre };
        Ok(Estimate { status: Status::Tracked, seam: Some(seam), ..Estimate::seeking(Observation::Seed) })
    }

    /// The KCF's answer round its own last peak; the template learns if the PSR allows it.
    fn locate(&mut self, frame: &GrayFrame, around: PixelPoint) -> (Response, KcfReading) {
        let response = self.kcf.detect(frame, nearest_pixel(around));
        let mut reading = KcfReading::from(response);
        reading.template_updated = reading.psr >= self.settings.psr_threshold;
        if reading.template_updated {
            self.kcf.update(frame, nearest_pixel(response.peak), self.settings.learning_rate);
        }
        (response, reading)
    }
}

/// Windows lie on whole pixels, as in the paper: a template that learns between pixels drifts along the stripe, since
/// no rounding holds its small errors back.
fn nearest_pixel(point: PixelPoint) -> PixelPoint {
    PixelPoint::new(point.u_px.round(), point.v_px.round())
}

fn seam(filter: &Gaussian<3>, v_px: f64) -> SeamEstimate {
    let std_px = filter.P[(0, 0)].max(0.0).sqrt();
    SeamEstimate { centre: PixelPoint::new(filter.x[0], v_px), std_px, std_across_px: PEAK_STD_PX }
}

fn inside(frame: &GrayFrame, point: PixelPoint) -> bool {
    (0.0..frame.width_px() as f64).contains(&point.u_px) && (0.0..frame.height_px() as f64).contains(&point.v_px)
}

impl PaperTracker {
    fn follow(&mut self, frame: &GrayFrame, tick: Tick) -> Result<Estimate, TrackerError> {
        let frame = &median(frame, self.settings.median);
        let (filter, around) = match self.state {
            State::Seeking => return self.seed(frame, false),
            State::Lost => return self.seed(frame, true),
            State::Following { filter, peak } => (filter, peak),
        };
        let (response, reading) = self.locate(frame, around);
        if !inside(frame, response.peak) {
            self.state = State::Lost;
            let lost = Estimate::seeking(Observation::PeakOutside);
            return Ok(Estimate { status: Status::Lost, kcf: Some(reading), ..lost });
        }
        let space = self.settings.kalman.state_space(tick.seconds)?;
        let update = filter.predict(&space).update(&space, &[Some(response.peak.u_px)], None)?;
        self.state = State::Following { filter: update.posterior, peak: response.peak };
        let seeking = Estimate::seeking(Observation::Kcf);
        let seam = Some(seam(&update.posterior, response.peak.v_px));
        Ok(Estimate { status: Status::Tracked, seam, kcf: Some(reading), nis: update.nis, ..seeking })
    }
}

impl Follow for PaperTracker {
    fn seed_at(&mut self, centre: PixelPoint) {
        self.seed_at = Some(centre);
    }

    fn step(&mut self, picture: Picture<'_>, tick: Tick) -> Result<Estimate, TrackerError> {
        self.frame_number += 1;
        let field = picture.field();
        self.field = field;
        let estimate = self.follow(&picture.whole(), tick)?;
        let memory = Memory { beats: tick.beats, ..Memory::NOTHING };
        Ok(Estimate { memory, ..estimate }.in_picture(&View::new(field, Raster::PICTURE)))
    }

    fn miss(&mut self, tick: Tick, why: Observation) -> Result<Estimate, TrackerError> {
        self.frame_number += 1;
        let memory = Memory { beats: tick.beats, ..Memory::NOTHING };
        let missed = Estimate { memory, ..Estimate::seeking(why) };
        Ok(match &mut self.state {
            State::Seeking => missed,
            State::Lost => Estimate { status: unseen(true), ..missed },
            State::Following { filter, peak } => {
                *filter = filter.predict(&self.settings.kalman.state_space(tick.seconds)?);
                let seam = Some(seam(filter, peak.v_px));
                Estimate { status: unseen(false), seam, ..missed }.in_picture(&View::new(self.field, Raster::PICTURE))
            }
        })
    }

    fn looks_at_repeats(&self) -> bool {
        true
    }

    fn outlasts(&self, _: f64) -> bool {
        true
    }

    fn pass_over(&mut self) {
        self.frame_number += 1;
    }

    fn start_anew(&mut self) {}

    fn links(&self) -> Option<Links> {
        None
    }

    fn joint(&self) -> Option<&JointDecision> {
        self.joint.as_ref()
    }
}
