//! The parts of the robust method that an ablation takes away, one at a time.

/// A part of the method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The 3 × 3 median before everything.
    Median,
    /// The stripe as a path through the frame; without it, each column's brightest pixel.
    StripePath,
    /// Refusing fits by support, residual, cost and margin.
    FitGates,
    /// The correlation filter standing in for a few frames.
    KcfStandIn,
    /// The correlation filter vouching for sightings that the innovation speaks against.
    Witness,
    /// Learning the template only where the sighting was accepted.
    LearningGate,
    /// The coloured part of the measurement noise; without it, all of it is white.
    ColouredNoise,
    /// Measuring on the recording how noisy the sightings are.
    NoiseScale,
    /// The lasting acceleration of the middle model.
    Bends,
    /// Bends that grow with the seam's speed.
    FastBends,
    /// The model for sharp corners.
    Corners,
    /// Refusing and inflating by the innovation.
    InnovationGate,
    /// Starting anew from refused sightings that agree.
    Reacquisition,
    /// The smoother's process noise by likelihood.
    #[cfg(feature = "ablation")]
    SmootherFit,
}

#[cfg(feature = "ablation")]
impl Part {
    /// All parts.
    pub const ALL: [Self; 14] = [
        Self::Median,
        Self::StripePath,
        Self::FitGates,
        Self::KcfStandIn,
        Self::Witness,
        Self::LearningGate,
        Self::ColouredNoise,
        Self::NoiseScale,
        Self::Bends,
        Self::FastBends,
        Self::Corners,
        Self::InnovationGate,
        Self::Reacquisition,
        Self::SmootherFit,
    ];

    /// Its name in the ablation's table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Median => "median",
            Self::StripePath => "stripe path",
            Self::FitGates => "fit gates",
            Self::KcfStandIn => "KCF stand-in",
            Self::Witness => "witness",
            Self::LearningGate => "learning gate",
            Self::ColouredNoise => "coloured noise",
            Self::NoiseScale => "noise scale",
            Self::Bends => "bends",
            Self::FastBends => "fast bends",
            Self::Corners => "corners",
            Self::InnovationGate => "innovation gate",
            Self::Reacquisition => "re-acquisition",
            Self::SmootherFit => "smoother's fit",
        }
    }
}

/// All parts but one, or all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Parts {
    /// The part that is taken away.
    pub without: Option<Part>,
}

impl Parts {
    /// Whether the method has `part`.
    #[must_use]
    pub fn has(self, part: Part) -> bool {
        self.without != Some(part)
    }
}
