//! What the tracker says of one frame.

use super::path::Memory;
use super::profile::Profile;
use super::view::View;
use crate::imgproc::geometry::Refusal;
use crate::kcf::Response;
use crate::units::PixelPoint;

/// What the tracker knows about the seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The seam has not been found yet.
    Seeking,
    /// The seam was seen in this frame.
    Tracked,
    /// The seam was not seen in this frame; the value is a prediction with a growing σ.
    Coasting,
    /// The seam was lost; no value is given.
    Lost,
}

/// The KCF's own answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KcfReading {
    /// Peak of the response.
    pub peak: PixelPoint,
    /// Raw peak-to-sidelobe ratio.
    pub psr: f64,
    /// PSR over the ceiling of its window and label.
    pub psr_ratio: f64,
    /// The template learned from this frame.
    pub template_updated: bool,
}

impl From<Response> for KcfReading {
    fn from(response: Response) -> Self {
        Self {
            peak: response.peak,
            psr: response.psr.into(),
            psr_ratio: response.psr_ratio().into(),
            template_updated: false,
        }
    }
}

/// The filtered seam centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeamEstimate {
    /// The seam centre.
    pub centre: PixelPoint,
    /// One σ of the position along the stripe \[px\].
    pub std_px: f64,
    /// One σ of the position across the stripe \[px\].
    pub std_across_px: f64,
}

impl SeamEstimate {
    /// The estimate of a view, in the picture.
    pub(super) fn in_picture(self, view: &View) -> Self {
        Self {
            centre: view.picture_from_view(self.centre),
            std_px: self.std_px * view.picture_px(),
            std_across_px: self.std_across_px * view.picture_px(),
        }
    }

    /// Between this estimate of the seam and `other`, `weight` of the way. Both may rest on the same frames, so that their
    /// mean is no surer than they are.
    #[must_use]
    pub fn blended(&self, other: &Self, weight: f64) -> Self {
        let mean = |a: f64, b: f64| a + weight * (b - a);
        Self {
            centre: PixelPoint::new(
                mean(self.centre.u_px, other.centre.u_px),
                mean(self.centre.v_px, other.centre.v_px),
            ),
            std_px: mean(self.std_px, other.std_px),
            std_across_px: mean(self.std_across_px, other.std_across_px),
        }
    }
}

/// What became of the frame's measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Observation {
    /// No stripe was seen.
    NoStripe,
    /// A stripe, but no seam in it.
    NoSeam,
    /// The seam was found in the whole frame: the filter starts here.
    Seed,
    /// The KCF's peak went into the filter.
    Kcf,
    /// The KCF's peak left the image.
    PeakOutside,
    /// The seam as sighted by the stripe's geometry, or by a hairline's evidence, went into the filter.
    Geometry,
    /// The sighting was too far from the prediction.
    Refused,
    /// Refused sightings agreed over several frames: the filter started anew.
    Reacquired,
    /// The frame showed no seam that can be trusted; the filter predicted.
    SightingRefused(Refusal),
    /// The picture has not changed for so long that the camera must have stopped, or it is that from before a miss:
    /// whatever it shows is not now.
    Frozen,
    /// The frame's stamp is no number, or not later than the one before: when it was taken is not known.
    BadStamp,
    /// The frame could not be read.
    Unreadable,
}

impl Observation {
    /// The word that `--trace` writes.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoStripe => "no-stripe",
            Self::NoSeam => "no-seam",
            Self::Seed => "seed",
            Self::Kcf => "kcf",
            Self::PeakOutside => "kcf-peak-outside-image",
            Self::Geometry => "sighted",
            Self::Refused => "too-far",
            Self::Reacquired => "reacquired",
            Self::SightingRefused(refusal) => refusal.name(),
            Self::Frozen => "frozen",
            Self::BadStamp => "bad-stamp",
            Self::Unreadable => "unreadable",
        }
    }
}

/// What a measurement rests on, as far as its kind has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Position along the stripe as this frame alone shows it \[px\].
    pub along_px: Option<f64>,
    /// Share of the stripe's columns that lie on its lines, 0 to 1.
    pub support: Option<f64>,
    /// RMS distance of the stripe from its lines \[px\].
    pub residual_px: Option<f64>,
    /// How badly two edges explain where the stripe is and where not, 0 to 2.
    pub cost: Option<f64>,
    /// By how much the next-best place is worse.
    pub margin: Option<f64>,
    /// Probability that there is a seam (hairline), 0 to 1.
    pub presence: Option<f64>,
}

impl Evidence {
    /// Nothing was seen.
    pub const NONE: Self =
        Self { along_px: None, support: None, residual_px: None, cost: None, margin: None, presence: None };
}

/// One side of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// The end of the fitted stripe away from the seam.
    pub outer: PixelPoint,
    /// Where the flank meets its plate (V-groove).
    pub shoulder: Option<PixelPoint>,
    /// The end next to the seam.
    pub inner: PixelPoint,
}

impl Side {
    /// Its points, going towards the seam.
    pub fn points(self) -> impl DoubleEndedIterator<Item = PixelPoint> {
        [Some(self.outer), self.shoulder, Some(self.inner)].into_iter().flatten()
    }

    fn in_picture(self, view: &View) -> Self {
        Self {
            outer: view.picture_from_view(self.outer),
            shoulder: self.shoulder.map(|point| view.picture_from_view(point)),
            inner: view.picture_from_view(self.inner),
        }
    }
}

/// The joint in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossSection {
    /// The stripe before and behind the seam.
    pub sides: [Side; 2],
    /// Distance of the two edges along the stripe \[px\]: the gap of a butt joint, the shadow of a lap joint.
    pub gap_px: Option<f64>,
    /// By how much the stripe behind the seam has the larger coordinate across it \[px\]: the plates' mismatch.
    pub mismatch_px: Option<f64>,
    /// Its lines, for what is measured on them.
    pub profile: Profile,
}

impl CrossSection {
    /// The same under noise of which the variance is `scale` times the nominal one.
    pub(super) fn with_noise(self, scale: f64) -> Self {
        Self { profile: self.profile.with_noise(scale), ..self }
    }

    fn in_picture(self, view: &View) -> Self {
        Self {
            sides: self.sides.map(|side| side.in_picture(view)),
            gap_px: self.gap_px.map(|px| px * view.picture_px()),
            mismatch_px: self.mismatch_px.map(|px| px * view.picture_px()),
            profile: self.profile.in_picture(view),
        }
    }
}

/// What the tracker says of one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// What it knows.
    pub status: Status,
    /// The seam centre; only when tracked or coasting.
    pub seam: Option<SeamEstimate>,
    /// The KCF's answer, when it was asked.
    pub kcf: Option<KcfReading>,
    /// What was measured.
    pub observation: Observation,
    /// Normalised innovation squared of the measurement.
    pub nis: Option<f64>,
    /// What the measurement rests on, also that of a refused one.
    pub evidence: Evidence,
    /// The joint as it was seen in this frame, when the measurement was accepted.
    pub section: Option<CrossSection>,
    /// The frame equals its predecessor byte for byte.
    pub repeated: bool,
    /// What the smoother is to know of it.
    pub(super) memory: Memory,
}

impl Estimate {
    /// No seam yet, because of `observation`.
    #[must_use]
    pub const fn seeking(observation: Observation) -> Self {
        Self {
            status: Status::Seeking,
            seam: None,
            kcf: None,
            observation,
            nis: None,
            evidence: Evidence::NONE,
            section: None,
            repeated: false,
            memory: Memory::NOTHING,
        }
    }

    /// The estimate of a view, in the picture.
    pub(super) fn in_picture(self, view: &View) -> Self {
        let along_px = |px| view.axis().along_px(view.picture_from_view(PixelPoint::new(px, 0.0)));
        Self {
            seam: self.seam.map(|seam| seam.in_picture(view)),
            section: self.section.map(|section| section.in_picture(view)),
            kcf: self.kcf.map(|kcf| KcfReading { peak: view.picture_from_view(kcf.peak), ..kcf }),
            evidence: Evidence {
                along_px: self.evidence.along_px.map(along_px),
                residual_px: self.evidence.residual_px.map(|px| px * view.picture_px()),
                ..self.evidence
            },
            ..self
        }
    }
}

/// The kind of joint, and how it was decided.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JointDecision {
    /// butt, lap, vgroove or fillet; butt-or-lap by the paper's method, which does not tell them apart.
    pub kind: &'static str,
    /// Number of the frame, from 0.
    pub frame: usize,
    /// Why, in one sentence.
    pub reason: String,
    /// What else it may be: something that frames and time cannot tell from it.
    pub doubt: Option<&'static str>,
    /// The kind that the frames show by themselves, where another was asked for.
    pub contradicted_by: Option<&'static str>,
}
