//! What the tracker says of one frame.

use crate::imgproc::geometry::Refusal;
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

/// The filtered seam centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeamEstimate {
    /// The seam centre.
    pub centre: PixelPoint,
    /// One σ of the position along the stripe \[px\].
    pub std_px: f64,
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

    fn transposed(self) -> Self {
        Self {
            outer: self.outer.transposed(),
            shoulder: self.shoulder.map(PixelPoint::transposed),
            inner: self.inner.transposed(),
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
}

impl CrossSection {
    fn transposed(self) -> Self {
        Self { sides: self.sides.map(Side::transposed), ..self }
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
        }
    }

    /// The estimate in the transposed image.
    #[must_use]
    pub fn transposed(self) -> Self {
        Self {
            seam: self.seam.map(|seam| SeamEstimate { centre: seam.centre.transposed(), ..seam }),
            section: self.section.map(CrossSection::transposed),
            kcf: self.kcf.map(|kcf| KcfReading { peak: kcf.peak.transposed(), ..kcf }),
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
}
