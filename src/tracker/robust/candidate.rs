//! A seed that may be the joint, and what it shows in its one frame.

use super::classify;
use super::seed::Seed;
use crate::frame::GrayFrame;
use crate::imgproc::geometry::{GapShows, JointKind, gap_shows, step_shows};

/// How alike in gap and in the height of one side over the other \[px\], and in the slope of each. Chosen: at a stripe's
/// end one side is always the same, the other any spatter.
const GAP_AGREEMENT_PX: f64 = 5.0;
const STEP_AGREEMENT_PX: f64 = 5.0;
const SLOPE_AGREEMENT: f64 = 0.2;

/// What a gap without relief may be.
pub const FLAT_DOUBT: &str = "the gap shows neither a bottom nor bent edges: it may be a mark on the plate (paint, slag) or a gap in the laser's line";

/// What a step may be beside which a plate goes on.
pub const STEP_DOUBT: &str = "one of the two stripes goes on past the step: it may be a second stripe, or a reflection";

/// What a joint among its like may be.
pub const TWIN_DOUBT: &str =
    "another joint like it shows beside it: there are two seams, of which one is followed, or a corrugated sheet";

/// What a gap in which the light falls on something may be.
pub const LEDGE_DOUBT: &str =
    "something level and bright lies between the edges: a bar under a gap, or a rib or a clamp on a plate without one";

/// What a gap that is too wide to be welded may be.
pub const WIDE_DOUBT: &str =
    "the gap is wider than 8 mm: what hides the stripe may be a clamp, or the plates' ends at a cut-out";

/// What a joint may be beside one of another sort.
pub const OTHER_DOUBT: &str =
    "another edge or corner shows beside it, which may be the one that is meant (--seed-at and --roi choose)";

/// What a leg beside a second line may be.
pub const SECOND_LINE_DOUBT: &str =
    "a second line, about as bright, runs beside one of its legs: one of the two may be a reflection";

/// What a dip may be.
pub const DIP_DOUBT: &str =
    "the stripe goes through it unbroken: it may be a scratch, the toe of a weld, or what lies on the plate";

/// A seed, and what it shows beside two sides that end.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Where it is.
    pub seed: Seed,
    /// What it shows.
    pub shows: Shows,
}

/// In the order of what it is worth before time has told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shows {
    /// A place where the stripe is dark.
    Dark,
    /// Something level and bright between two edges.
    Ledge,
    /// A dip in an unbroken stripe.
    Dip,
    /// A step between two plates: a lap joint, or the end of any plate, a clamp, a ledge.
    Step,
    /// A joint with relief on both sides of which a plate goes on.
    Relief,
    /// A groove with both its shoulders, or what the user asked for.
    Whole,
}

impl Shows {
    /// The order, in which a step is worth as much as any relief, and a ledge as a dark place: which of them is meant, the place tells.
    pub fn rank(self) -> Self {
        match self {
            Self::Step => Self::Relief,
            Self::Ledge => Self::Dark,
            other => other,
        }
    }

    /// Whether it is relief, or more.
    pub fn is_more_than_step(self) -> bool {
        self > Self::Step
    }
}

impl Candidate {
    /// None when what should be a gap or a step is a mark on the plate; what the user asked for is not doubted.
    pub fn of(frame: &GrayFrame, seed: Seed, asked: Option<JointKind>) -> Option<Self> {
        if seed.certain {
            return Some(Self { seed, shows: Shows::Whole });
        }
        let look = match seed.model.kind {
            JointKind::Butt => gap_shows,
            JointKind::Lap => step_shows,
            JointKind::VGroove | JointKind::Fillet => return Some(Self { seed, shows: Shows::Relief }),
        };
        if asked == Some(seed.model.kind) {
            return Some(Self { seed, shows: Shows::Relief });
        }
        let shows = match look(frame, &seed.fit, seed.model.stripe_sd_px) {
            GapShows::Plate | GapShows::Bump | GapShows::Groove | GapShows::Flank => return None,
            GapShows::Relief if seed.model.kind == JointKind::Lap => Shows::Step,
            GapShows::Relief => Shows::Relief,
            GapShows::Dip => Shows::Dip,
            GapShows::Ledge => Shows::Ledge,
            // Of a low step all must speak for one: where a stripe and a reflection part there are many.
            GapShows::Nothing if seed.model.kind == JointKind::Lap && !classify::is_high(&seed) => return None,
            GapShows::Nothing => Shows::Dark,
        };
        Some(Self { seed, shows })
    }
}

/// Whether two seeds may be of one joint, wherever they are.
pub fn are_alike(seed: &Seed, other: &Seed) -> bool {
    let slopes = [seed.fit.left.slope - other.fit.left.slope, seed.fit.right.slope - other.fit.right.slope];
    seed.model.kind == other.model.kind
        && (seed.gap_px() - other.gap_px()).abs() < GAP_AGREEMENT_PX
        && (classify::step_px(seed) - classify::step_px(other)).abs() < STEP_AGREEMENT_PX
        && slopes.iter().all(|difference| difference.abs() < SLOPE_AGREEMENT)
}

/// Whether what `seed` takes for its gap is a groove between its edges, as `other` has it.
pub fn is_groove_between(seed: &Seed, other: &Seed) -> bool {
    let Some(edges) = seed.fit.edges else { return false };
    other.model.plates.is_some() && seed.away_px(other) < edges.gap_px.max(GAP_AGREEMENT_PX)
}
