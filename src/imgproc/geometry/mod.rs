//! Stripe geometry: the joint's centre from the stripe on its two sides, near a prediction.
//!
//! Along each side's predicted line the stripe's ridge is sought across the stripe, a line is fitted
//! robustly through it, and the centre is where the two lines meet (V-groove, fillet) or the
//! middle between the ends of the stripe on them (butt, lap).

mod corner;
#[cfg(test)]
mod drawn;
mod edge_pair;
mod edges;
mod groove;
mod learn;
mod line;
mod peaks;
mod relief;
mod ridge;
mod second;

pub use corner::CORNER_VARIANCE_PX2;
pub use learn::{Learned, PLAIN_REACH_PX, is_plain, learn};
pub use line::{FrameLine, Knowledge, Line};
pub use relief::{GapShows, gap_shows, step_shows};

use std::ops::Range;

use nalgebra::Matrix2;

use crate::imgproc::Pixels;
use crate::units::PixelPoint;

/// The kind of a joint, by how its centre is defined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Middle between the two gap edges.
    Butt,
    /// Middle between the end of the upper plate's stripe and the start of the lower one's.
    Lap,
    /// Where the two flanks meet.
    VGroove,
    /// Where the two legs meet.
    Fillet,
}

impl JointKind {
    /// The name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Butt => "butt",
            Self::Lap => "lap",
            Self::VGroove => "vgroove",
            Self::Fillet => "fillet",
        }
    }

    /// Whether the centre lies between two edges, not at a corner.
    #[must_use]
    pub const fn has_edges(self) -> bool {
        matches!(self, Self::Butt | Self::Lap)
    }
}

/// Half the stretch along the stripe that a fit looks at \[px\]. Prototype: 80. A V-groove that is wider takes a larger
/// one.
pub const HALF_WINDOW_PX: f64 = 80.0;

/// What is known of the joint's cross-section; lines are given relative to the seam's column.
#[derive(Debug, Clone, PartialEq)]
pub struct JointModel {
    /// Its kind.
    pub kind: JointKind,
    /// SD of the stripe's cross-section \[px\].
    pub stripe_sd_px: f64,
    /// The stripe before the seam.
    pub left: Line,
    /// The stripe behind the seam.
    pub right: Line,
    /// Distance of the two edges along the stripe \[px\] (butt, lap).
    pub gap_px: Option<f64>,
    /// SD of that distance from fit to fit \[px\].
    pub gap_sd_px: f64,
    /// From the root to the nearer shoulder \[px\] (V-groove), where it is within the window.
    pub half_width_px: Option<f64>,
    /// The plates beside the shoulders (V-groove), where they are within the window.
    pub plates: Option<[Line; 2]>,
    /// Half the stretch along the stripe that a fit looks at \[px\].
    pub half_window_px: f64,
    /// From where to where each side is seen, as distances from the corner \[px\]: its rounded toe, open root or bead is
    /// not part of the flanks.
    pub flanks_px: [Range<f64>; 2],
    /// How surely the slope and curvature of each side are known.
    pub known: [Knowledge; 2],
    /// Fits that went into the model.
    pub fits: u32,
}

/// One frame's fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointFit {
    /// The joint's centre.
    pub centre: PixelPoint,
    /// The stripe before the seam, relative to the centre's column.
    pub left: Line,
    /// The stripe behind the seam.
    pub right: Line,
    /// Each side by this frame alone, relative to the centre's column.
    pub in_frame: [FrameLine; 2],
    /// The information that the columns of each side by themselves have on its slope and curvature, as [`Knowledge`] has it.
    pub shown: [Matrix2<f64>; 2],
    /// Share of each side's columns that lie on its line, the lesser of the two, 0 to 1.
    pub support: f64,
    /// Weighted RMS distance of the ridge from its line, the larger of the two sides \[px\].
    pub residual_px: f64,
    /// Variance of the centre's place along the stripe \[px²\]: what the stripe leaves open, not how ragged edges are.
    pub along_variance_px2: f64,
    /// Variance of the centre's place along the stripe that is the same from frame to frame, so that no filter averages it
    /// away \[px²\]: of a corner beside whose legs a second line runs.
    pub lasting_px2: f64,
    /// Over most of a leg a second line runs that may be the leg itself (V-groove, fillet).
    pub has_rival: bool,
    /// Variance of the centre's row, as far as the ridge's scatter makes it \[px²\].
    pub across_variance_px2: f64,
    /// How well the two edges explain the stripe's presence (butt, lap).
    pub edges: Option<EdgeQuality>,
    /// The plates beside the shoulders, relative to the centre's column, each where it was seen (V-groove).
    pub plates: [Option<Line>; 2],
    /// The plates by this frame alone.
    pub plates_in_frame: [Option<FrameLine>; 2],
}

/// How well two edges explain where the stripe is and where not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeQuality {
    /// Distance of the two edges along the stripe \[px\].
    pub gap_px: f64,
    /// Truncated squared mismatch per column, 0 to 2.
    pub cost: f64,
    /// By how much the next-best place over 3 px away is worse.
    pub margin: f64,
    /// The sides' lines are so far apart that the seam is sure to lie between the edges, if not just where.
    pub distinct: bool,
}

/// Why a frame has no fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refusal {
    /// The prediction is too close to the image's border.
    Border,
    /// A side has no ridge that a line goes through.
    NoLine,
    /// The sides are parallel, or meet too far from the prediction.
    NoCorner,
    /// Too few columns lie on the lines.
    Support,
    /// The edges explain the stripe badly: it is covered, or the seam is not here.
    Cost,
    /// Another place explains the stripe as well.
    Margin,
    /// The ridge scatters about its line.
    Residual,
    /// It is open whether there is a seam here at all (hairline).
    Presence,
    /// The stripe goes straight through: the joint has ended, or is filled.
    Plain,
}

impl Refusal {
    /// The word that the trace writes.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Border => "border",
            Self::NoLine => "no-line",
            Self::NoCorner => "no-corner",
            Self::Support => "support",
            Self::Cost => "cost",
            Self::Margin => "margin",
            Self::Residual => "residual",
            Self::Presence => "presence",
            Self::Plain => "plain",
        }
    }
}

/// Least support of a fit with edges, and of one with a corner. Prototype.
const LEAST_SUPPORT_EDGES: f64 = 0.20;
const LEAST_SUPPORT_CORNER: f64 = 0.25;
/// Largest residual \[px\]. Prototype.
const LARGEST_RESIDUAL_PX: f64 = 1.6;
/// Largest edge cost: covered frames have .3 and more, a tack weld .15. Tuned; the prototype's was .2.
const LARGEST_COST: f64 = 0.1;
/// Least margin over the next-best place. Prototype.
const LEAST_MARGIN: f64 = 1.0;

/// SD of the gap from fit to fit before it is known, and its least \[px\]. Prototype.
const LEAST_GAP_SD_PX: f64 = 1.6;
/// Rates at which the gap and its SD are learned, a fit. Prototype; chosen.
const GAP_RATE: f64 = 0.15;
const GAP_SD_RATE: f64 = 0.06;
/// Variance along the stripe of a fit on an even stripe \[px²\]. Prototype.
pub const EVEN_VARIANCE_PX2: f64 = 0.1;

/// What a fit must show to be believed by itself. Chosen between clean and disturbed frames.
const CLEAR_SUPPORT: f64 = 0.5;
const CLEAR_RESIDUAL_PX: f64 = 0.8;

impl JointFit {
    /// Whether the fit is so good that no second frame need confirm it.
    #[must_use]
    pub fn is_clear(&self) -> bool {
        self.support > CLEAR_SUPPORT
            && self.residual_px < CLEAR_RESIDUAL_PX
            && self.edges.is_none_or(|edges| edges.cost < LARGEST_COST && edges.margin > LEAST_MARGIN)
    }

    /// Why the fit cannot be trusted, if so: the first of support, residual, cost and margin that fails.
    #[must_use]
    pub fn refusal(&self) -> Option<Refusal> {
        let least_support = if self.edges.is_some() { LEAST_SUPPORT_EDGES } else { LEAST_SUPPORT_CORNER };
        if self.support < least_support {
            return Some(Refusal::Support);
        }
        if self.residual_px > LARGEST_RESIDUAL_PX {
            return Some(Refusal::Residual);
        }
        match self.edges {
            Some(edges) if edges.cost > LARGEST_COST => Some(Refusal::Cost),
            Some(edges) if edges.margin < LEAST_MARGIN && !edges.distinct => Some(Refusal::Margin),
            _ => None,
        }
    }

    /// By how much the stripe behind the seam lies lower in the image than that before it, at the seam \[px\]: the
    /// mismatch of the plates. A corner has none.
    #[must_use]
    pub fn mismatch_px(&self) -> Option<f64> {
        self.edges.map(|_| self.right.v_px - self.left.v_px)
    }

    /// Where a flank meets its plate, for each side where the plate was seen (V-groove).
    #[must_use]
    pub fn shoulders(&self) -> [Option<PixelPoint>; 2] {
        let shoulder = |flank: Line, plate: Option<Line>| {
            let (du, v_px) = flank.meets(plate?)?;
            Some(PixelPoint::new(self.centre.u_px + du, v_px))
        };
        [shoulder(self.left, self.plates[0]), shoulder(self.right, self.plates[1])]
    }
}

impl JointModel {
    /// Fits the joint within `search_px` of column `u_px`, the sides' lines shifted by `dv_px`. The fit is not judged
    /// yet: [`JointFit::refusal`].
    ///
    /// # Errors
    /// When there is nothing to fit.
    pub fn fit(&self, mut pixels: impl Pixels, u_px: f64, dv_px: f64, search_px: f64) -> Result<JointFit, Refusal> {
        let near_border = 6.0;
        if !(near_border..=pixels.size_px().0 as f64 - 1.0 - near_border).contains(&u_px) {
            return Err(Refusal::Border);
        }
        if self.kind.has_edges() {
            edges::fit(self, &mut pixels, u_px, dv_px, search_px)
        } else {
            corner::fit(self, &mut pixels, u_px, dv_px, search_px)
        }
    }

    /// Where the seam's row is expected \[px\].
    #[must_use]
    pub fn seam_v_px(&self) -> f64 {
        0.5 * (self.left.v_px + self.right.v_px)
    }

    /// Takes over what an accepted fit says: the lines, which hold what was known before, at once, the gap slowly.
    pub fn learn(&mut self, fit: &JointFit) {
        self.fits += 1;
        let seam_v_px = self.seam_v_px();
        let early = 1.0 / f64::from(self.fits + 1);
        (self.left, self.right) = (fit.left, fit.right);
        for ((known, shown), line) in self.known.iter_mut().zip(fit.shown).zip([fit.left, fit.right]) {
            *known = known.with(shown, line.curvature_per_px);
        }
        for (plate, seen) in self.plates.iter_mut().flatten().zip(fit.plates) {
            let drop_px = 0.5 * (fit.left.v_px + fit.right.v_px) - seam_v_px;
            plate.v_px += drop_px;
            if let Some(seen) = seen {
                *plate = seen;
            }
        }
        if let Some(edges) = fit.edges {
            let known_px = self.gap_px.unwrap_or(edges.gap_px);
            let off_px = edges.gap_px - known_px;
            self.gap_px = Some(known_px + early.max(GAP_RATE) * off_px);
            let variance_px2 = self.gap_sd_px.powi(2) + GAP_SD_RATE * (off_px.powi(2) - self.gap_sd_px.powi(2));
            self.gap_sd_px = variance_px2.sqrt().max(LEAST_GAP_SD_PX);
        }
    }
}

/// The integer columns within `half_px` of `u_px` that lie in the frame; none where that is beside it.
fn columns(frame: &impl Pixels, u_px: f64, half_px: f64) -> Range<usize> {
    let first = (u_px.round() - half_px).max(0.0) as usize;
    let end = ((u_px.round() + half_px).min(frame.size_px().0 as f64 - 1.0) + 1.0).max(0.0) as usize;
    first.min(end)..end
}
