//! Sighting the seam by the stripe's geometry: joints with edges or a corner.

use super::filter::COLOUR_VARIANCE_PX2;
use super::judge::Judge;
use super::noise;
use super::part::{Part, Parts};
use super::sighting::{Sighting, Unsighted};
use crate::imgproc::Pixels;
use crate::imgproc::geometry::{JointFit, JointModel, Line, Refusal, is_plain};
use crate::imgproc::stripe_path;
use crate::tracker::estimate::{CrossSection, Evidence, KcfReading, Side};
use crate::tracker::profile::Profile;
use crate::units::PixelPoint;

use super::following::LEAST_PSR_RATIO;

/// Search range along the stripe \[px\]: at rest, and what an unsure prediction adds at most. Prototype.
const SEARCH_PX: f64 = 12.0;
const MOST_EXTRA_PX: f64 = 18.0;
const EXTRA_PER_STD: f64 = 2.5;
/// A KCF peak this far from the prediction is looked at as another place \[px\].
const OTHER_PLACE_PX: f64 = 4.0;
/// The KCF's row is not believed when it is this far from the model's \[px\].
const LARGEST_DV_PX: f64 = 25.0;
/// What a pixel of distance from the prediction costs, while the prediction is fresh.
const COST_PER_PX: f64 = 0.002;
/// Time unseen after which the prediction is not fresh \[beats\].
const FRESH_BEATS: f64 = 5.0;
/// The whole-frame search: step along the stripe and shifts across it \[px\], margin at the border \[px\].
const SEARCH_STEP_PX: usize = 12;
const SEARCH_SHIFTS_PX: [f64; 3] = [-8.0, 0.0, 8.0];
const SEARCH_BORDER_PX: usize = 10;
/// Columns of the whole-frame search that are looked at in one frame: the search goes on in the next. Chosen: so a frame
/// costs a bounded time, however large it is.
const SEARCH_COLUMNS_A_FRAME: usize = 16;

/// The joint's model at work.
#[derive(Debug, Clone)]
pub struct GeometryEye {
    model: JointModel,
    parts: Parts,
    /// Columns of the whole-frame search that were looked at since the seam was lost.
    searched: usize,
}

impl GeometryEye {
    /// Sees with `model`.
    pub const fn new(model: JointModel, parts: Parts) -> Self {
        Self { model, parts, searched: 0 }
    }

    /// The best fit near the prediction, or near the KCF's peak where that is elsewhere.
    pub fn look(&mut self, frame: &mut impl Pixels, judge: &Judge, kcf: &KcfReading) -> Result<Sighting, Unsighted> {
        self.searched = 0;
        let predicted = (judge.position().0, 0.0);
        self.near(frame, judge, std::iter::once(predicted).chain(self.by_peak(judge, kcf)))
    }

    /// The best fit where the KCF has its peak; none where that is not believed.
    pub fn look_at_peak(
        &self,
        frame: &mut impl Pixels,
        judge: &Judge,
        kcf: &KcfReading,
    ) -> Result<Sighting, Unsighted> {
        self.near(frame, judge, self.by_peak(judge, kcf))
    }

    /// The best fit in a part of the whole frame, or where the last sightings were.
    pub fn search(&mut self, frame: &mut impl Pixels, judge: &Judge) -> Result<Sighting, Unsighted> {
        let (u_px, _) = judge.position();
        let mut columns: Vec<f64> = (SEARCH_BORDER_PX..frame.size_px().0.saturating_sub(SEARCH_BORDER_PX))
            .step_by(SEARCH_STEP_PX)
            .map(|u| u as f64)
            .collect();
        // From the prediction outwards, and round again.
        columns.sort_by(|a, b| (a - u_px).abs().total_cmp(&(b - u_px).abs()));
        let next = columns
            .iter()
            .cycle()
            .skip(self.searched % columns.len().max(1))
            .take(SEARCH_COLUMNS_A_FRAME.min(columns.len()));
        let places: Vec<f64> = judge.refused_px().take(2).chain([u_px]).chain(next.copied()).collect();
        self.searched += SEARCH_COLUMNS_A_FRAME;
        let badness = |fit: &JointFit| fit.edges.map_or(fit.residual_px, |edges| edges.cost) - 0.2 * fit.support;
        let places = places.into_iter().flat_map(|u_px| SEARCH_SHIFTS_PX.map(|dv_px| (u_px, dv_px)));
        self.best(frame, places, SEARCH_PX, badness).map(|fit| self.sighting(fit))
    }

    /// What a fit shows.
    pub fn sighting(&self, fit: JointFit) -> Sighting {
        Sighting {
            centre: fit.centre,
            variance_px2: noise::of_fit(&fit),
            across_variance_px2: across_variance_px2(&fit),
            clear: fit.is_clear(),
            evidence: evidence(&fit),
            section: Some(section(&fit, &self.model)),
            fit: Some(fit),
        }
    }

    /// Whether the stripe goes straight through at `place`, or in its column wherever the stripe is: where a corner has
    /// ended, plates may lie far from where it was.
    pub fn sees_plain_stripe(&self, frame: &mut impl Pixels, place: PixelPoint) -> bool {
        let (half_window_px, stripe_sd_px) = (self.model.half_window_px, self.model.stripe_sd_px);
        if is_plain(&mut *frame, place, half_window_px, stripe_sd_px) {
            return true;
        }
        let column = place.u_px.round().max(0.0) as usize;
        let row = stripe_path(frame.whole()).and_then(|path| path.get(column).copied());
        row.is_some_and(|row| is_plain(frame, PixelPoint::new(place.u_px, row as f64), half_window_px, stripe_sd_px))
    }

    /// From edge to edge as it is known; none of joints without edges \[px\].
    pub const fn gap_px(&self) -> Option<f64> {
        self.model.gap_px
    }

    /// Takes over what an accepted fit says.
    pub fn learn(&mut self, fit: &JointFit) {
        self.model.learn(fit);
    }

    /// Places along the stripe that the KCF's peak speaks for, and by how much the sides lie lower there.
    fn by_peak(&self, judge: &Judge, kcf: &KcfReading) -> impl Iterator<Item = (f64, f64)> + use<> {
        let (u_px, _) = judge.position();
        let dv_px = kcf.peak.v_px - self.model.seam_v_px();
        let dv_px = if dv_px.abs() > LARGEST_DV_PX { 0.0 } else { dv_px };
        let kcf_believable = kcf.psr_ratio >= LEAST_PSR_RATIO;
        let kcf_elsewhere = (kcf.peak.u_px - u_px).abs() > OTHER_PLACE_PX || judge.unseen_beats() > 0.0;
        let places = [
            (kcf_believable && kcf_elsewhere).then_some((kcf.peak.u_px, dv_px)),
            (kcf_believable && judge.unseen_beats() > 1.0).then_some((u_px, dv_px)),
        ];
        places.into_iter().flatten()
    }

    /// The best fit at `places`, those near the prediction preferred.
    fn near(
        &self,
        frame: &mut impl Pixels,
        judge: &Judge,
        places: impl Iterator<Item = (f64, f64)>,
    ) -> Result<Sighting, Unsighted> {
        let (u_px, variance_px2) = judge.position();
        let extra_px = EXTRA_PER_STD * (variance_px2 - 1.0).max(0.0).sqrt();
        let search_px = SEARCH_PX + extra_px.min(MOST_EXTRA_PX);
        let badness = |fit: &JointFit| {
            let away_px = if judge.unseen_beats() < FRESH_BEATS { (fit.centre.u_px - u_px).abs() } else { 0.0 };
            fit.edges.map_or(fit.residual_px, |edges| edges.cost) + COST_PER_PX * away_px
        };
        self.best(frame, places, search_px, badness).map(|fit| self.sighting(fit))
    }

    /// The least bad of the trustworthy fits; else why the first place had none.
    fn best(
        &self,
        frame: &mut impl Pixels,
        places: impl Iterator<Item = (f64, f64)>,
        search_px: f64,
        badness: impl Fn(&JointFit) -> f64,
    ) -> Result<JointFit, Unsighted> {
        let mut best: Option<JointFit> = None;
        let mut first_unsighted = None;
        for (u_px, dv_px) in places {
            let unsighted = match self.model.fit(&mut *frame, u_px, dv_px, search_px) {
                Err(refusal) => refusal.into(),
                Ok(fit) => match fit.refusal().filter(|_| self.parts.has(Part::FitGates)) {
                    Some(refusal) => Unsighted { refusal, evidence: evidence(&fit) },
                    None => {
                        if best.is_none_or(|other| badness(&fit) < badness(&other)) {
                            best = Some(fit);
                        }
                        continue;
                    }
                },
            };
            first_unsighted.get_or_insert(unsighted);
        }
        best.ok_or(first_unsighted.unwrap_or(Refusal::NoLine.into()))
    }
}

/// R of a fit across the stripe \[px²\]: the scatter of its lines, and what ragged flanks move a corner by.
fn across_variance_px2(fit: &JointFit) -> f64 {
    let slope = if fit.edges.is_some() { 0.0 } else { 0.5 * (fit.left.slope.abs() + fit.right.slope.abs()) };
    fit.across_variance_px2 + slope * slope * COLOUR_VARIANCE_PX2
}

fn evidence(fit: &JointFit) -> Evidence {
    Evidence {
        along_px: Some(fit.centre.u_px),
        support: Some(fit.support),
        residual_px: Some(fit.residual_px),
        cost: fit.edges.map(|edges| edges.cost),
        margin: fit.edges.map(|edges| edges.margin),
        presence: None,
    }
}

/// The joint as it was fitted, out to the window's ends.
fn section(fit: &JointFit, model: &JointModel) -> CrossSection {
    let half_gap_px = fit.edges.map_or(0.0, |edges| 0.5 * edges.gap_px);
    let [left_shoulder, right_shoulder] = fit.shoulders();
    let side = |flank: Line, plate: Option<Line>, shoulder: Option<PixelPoint>, sign: f64| {
        let point = |line: Line, du: f64| PixelPoint::new(fit.centre.u_px + sign * du, line.at(sign * du));
        let outer = if shoulder.is_some() { plate.unwrap_or(flank) } else { flank };
        Side { outer: point(outer, model.half_window_px), shoulder, inner: point(flank, half_gap_px) }
    };
    // The share of an even stripe is not in the distance of two edges, which is held by what is known of it.
    let along_px2 = noise::of_fit(fit) - noise::WHITE_VARIANCE_PX2 + COLOUR_VARIANCE_PX2;
    let profile = Profile::of(fit, model.kind, along_px2, COLOUR_VARIANCE_PX2);
    CrossSection {
        sides: [
            side(fit.left, fit.plates[0], left_shoulder, -1.0),
            side(fit.right, fit.plates[1], right_shoulder, 1.0),
        ],
        gap_px: profile.gap_px,
        mismatch_px: fit.mismatch_px(),
        profile,
    }
}
