//! A second line beside a leg: the light of one leg mirrored in the other, a reflection of the stripe.
//!
//! Within the matched filter's reach it draws the ridge to itself, by the same in every frame: no residual, no innovation shows
//! that. What shows is the cross-section, which the stripe alone makes as bright above its ridge as below. So the columns
//! beside a corner are looked at in stretches, each straightened along its leg, as the median of some columns, for a spatter or
//! a speckle must not decide; and where a second line shows the ridge is left out of the leg.

use arrayvec::ArrayVec;

use super::ridge::{Ridge, RidgePoint};
use crate::imgproc::Pixels;

/// Stretches of a leg, at most, and the columns of each that are looked at.
const STRETCHES: usize = 10;
const COLUMNS: usize = 8;
/// Most rows of a stretch's cross-section \[px\]. Chosen: stripes of SD 6 px have 85.
const MOST_ROWS: usize = 128;
/// From where to where beside the ridge a second line is looked for, in SDs of the stripe. Chosen: nearer the stripe's own slope
/// and its speckle are in it; beyond, a line of 1.5 times the stripe's width no longer lies in the matched filter (2.6 SD).
const BESIDE_SDS: std::ops::Range<f64> = 2.2..6.0;
/// A second line is brighter than its mirror image on the other side of the ridge by this share of the ridge. Measured on
/// rendered fillets under a medium arc: the stripe alone has .1 at most in 105 of 108 stretches, the faintest reflections .12 to .3.
const LEAST_SHARE: f64 = 0.12;
/// One on each side, or one that has merged with the leg: so bright at the nearest distance on both sides. Measured likewise: .28 at
/// most.
const MERGED_SHARE: f64 = 0.33;
/// The ridge of a stretch is the balance of its light within so many SDs of the stripe: its brightest row is a speckle's.
const CORE_SDS: f64 = 2.0;
const BALANCE_ROUNDS: usize = 3;
/// How far from the leg's line that may be \[px\].
const RIDGE_PX: f64 = 2.5;
/// Fainter stretches say nothing \[grey\].
const LEAST_GREY: f64 = 15.0;
/// Which percentile of a stretch's cross-section is its background: the stripe and a second line fill less than half of it.
const BACKGROUND_SHARE: f64 = 0.25;
/// Share of a leg's columns that must be left when those with a second line are left out. Chosen: fewer do not hold its slope.
const LEAST_LEFT: f64 = 0.4;
/// From this brightness relative to the leg on either of the two may be the leg. Chosen: aluminium mirrors half.
const RIVAL_SHARE: f64 = 0.5;
/// So much of the way from the leg to a second line, times its brightness, may be in the leg's row. Chosen: a rival is the leg with a
/// chance of a quarter; a fainter one has drawn the ridge aside: measured, by .3 to .4 of that way.
const RIVAL_DOUBT: f64 = 0.5;
const DRAWN_ASIDE: f64 = 0.35;

/// What a leg's columns show beside the leg.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Beside {
    /// SD of what a second line that could not be left out leaves of the leg's row \[px\].
    pub row_sd_px: f64,
    /// Over most of the leg a second line runs that may be the leg itself.
    pub is_rival: bool,
}

/// A second line: its distance from the ridge \[px\] and its brightness relative to it.
#[derive(Debug, Clone, Copy)]
struct Second {
    away_px: f64,
    share: f64,
}

/// Leaves the columns in which a second line shows out of a leg's ridge; `row` is the leg's line.
pub fn leave_out(mut pixels: impl Pixels, points: &mut Ridge, row: impl Fn(f64) -> f64, stripe_sd_px: f64) -> Beside {
    let count = points.len();
    let length = count.div_ceil(STRETCHES).max(COLUMNS);
    let seconds: ArrayVec<Option<Second>, STRETCHES> =
        points.chunks(length).map(|stretch| second(&mut pixels, stretch, &row, stripe_sd_px)).collect();
    let shown: ArrayVec<Second, STRETCHES> = seconds.iter().flatten().copied().collect();
    if shown.is_empty() {
        return Beside::default();
    }
    let rivals = shown.iter().filter(|second| second.share >= RIVAL_SHARE).count();
    let is_rival = 2 * rivals > seconds.len();
    let left: Ridge = points
        .chunks(length)
        .zip(&seconds)
        .filter(|(_, second)| second.is_none())
        .flat_map(|(stretch, _)| stretch.iter().copied())
        .collect();
    if left.len() as f64 >= LEAST_LEFT * count as f64 && !is_rival {
        *points = left;
        return Beside::default();
    }
    let doubt = |second: &Second| {
        let share = if second.share >= RIVAL_SHARE { RIVAL_DOUBT } else { DRAWN_ASIDE };
        (share * second.share.min(1.0) * second.away_px).powi(2)
    };
    let mean_px2 = shown.iter().map(doubt).sum::<f64>() / shown.len() as f64;
    Beside { row_sd_px: mean_px2.sqrt(), is_rival }
}

/// The second line of a stretch of a leg, if it shows one.
fn second(
    mut pixels: impl Pixels,
    stretch: &[RidgePoint],
    row: &impl Fn(f64) -> f64,
    stripe_sd_px: f64,
) -> Option<Second> {
    let reach = ((BESIDE_SDS.end * stripe_sd_px + RIDGE_PX).ceil() as isize + 2).min(MOST_ROWS as isize / 2 - 1);
    let stride = (stretch.len() / COLUMNS).max(1);
    let columns: ArrayVec<(isize, isize), { 2 * COLUMNS }> =
        stretch.iter().step_by(stride).map(|p| (p.u_px as isize, row(p.u_px).round() as isize)).collect();
    let rows = columns.iter().fold((isize::MAX, 0), |(least, most), (_, v)| (least.min(*v), most.max(*v)));
    let inside = |v: isize| v.clamp(0, pixels.size_px().1 as isize - 1) as usize;
    let rows = inside(rows.0 - reach)..inside(rows.1 + reach) + 1;
    let ends = columns.first().zip(columns.last())?;
    let frame = pixels.region(ends.0.0 as usize..ends.1.0 as usize + 1, rows);
    let mut greys: ArrayVec<u8, { 2 * COLUMNS }> = columns.iter().map(|_| 0).collect();
    let mut profile: ArrayVec<f64, MOST_ROWS> = ArrayVec::new();
    for dv in -reach..=reach {
        for (grey, (u, v)) in greys.iter_mut().zip(&columns) {
            *grey = frame.at_clamped(*u, v + dv);
        }
        let middle = greys.len() / 2;
        profile.push(f64::from(*greys.select_nth_unstable(middle).1));
    }
    let mut sorted = profile.clone();
    let rank = (BACKGROUND_SHARE * sorted.len() as f64) as usize;
    let (_, &mut background, _) = sorted.select_nth_unstable_by(rank, f64::total_cmp);
    let light = |i: usize| (profile[i] - background).max(0.0);
    let mut ridge = reach as f64;
    for _ in 0..BALANCE_ROUNDS {
        let core = (ridge - CORE_SDS * stripe_sd_px).ceil().max(0.0) as usize
            ..((ridge + CORE_SDS * stripe_sd_px) as usize + 1).min(profile.len());
        let (sum, moment) = core.fold((0.0, 0.0), |(sum, moment), i| (sum + light(i), moment + light(i) * i as f64));
        let balance = moment / sum;
        if !balance.is_finite() || (balance - reach as f64).abs() > RIDGE_PX {
            break;
        }
        ridge = balance;
    }
    let at = |place: f64| {
        let place = place.clamp(0.0, (profile.len() - 2) as f64);
        let (first, rest) = (place as usize, place.fract());
        (1.0 - rest) * profile[first] + rest * profile[first + 1] - background
    };
    let grey = [-0.5, -0.25, 0.0, 0.25, 0.5].map(|sds| at(ridge + sds * stripe_sd_px)).iter().sum::<f64>() / 5.0;
    if grey < LEAST_GREY {
        return None;
    }
    // Means over an SD: the grain of a speckled stripe is finer.
    let beside = |away_px: f64| {
        [-0.5, 0.0, 0.5].map(|by| at(ridge + away_px + by * stripe_sd_px)).iter().sum::<f64>() / (3.0 * grey)
    };
    let steps = (BESIDE_SDS.start * stripe_sd_px) as usize..=(BESIDE_SDS.end * stripe_sd_px) as usize;
    let sides = steps.map(|away| away as f64).map(|away_px| {
        let share = (beside(away_px) - beside(-away_px)).abs();
        Second { away_px, share }
    });
    let brightest = sides.max_by(|a, b| a.share.total_cmp(&b.share)).filter(|second| second.share >= LEAST_SHARE);
    let merged_px = BESIDE_SDS.start * stripe_sd_px;
    let merged = at(ridge + merged_px).min(at(ridge - merged_px)) / grey;
    brightest.or_else(|| (merged >= MERGED_SHARE).then_some(Second { away_px: merged_px, share: merged }))
}

#[cfg(test)]
mod tests {
    use super::super::drawn::STRIPE_SD_PX;
    use super::super::ridge::{CrossSection, Search, ridge};
    use super::*;
    use crate::frame::GrayFrame;

    /// A level stripe in row 60.3, and beside it what `second(u)` says: how far below, and how bright.
    fn looked_at(second: impl Fn(f64) -> Option<(f64, f64)>) -> (usize, Beside) {
        let mut frame = GrayFrame::filled(120, 120, 12).unwrap();
        let light = |off_px: f64| (-0.5 * (off_px / STRIPE_SD_PX).powi(2)).exp();
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = ((i % 120) as f64, (i / 120) as f64);
            let other = second(u).map_or(0.0, |(below_px, share)| share * light(v - 60.3 - below_px));
            *pixel = (12.0 + 150.0 * light(v - 60.3) + 90.0 * other + 1.5 * (7.3 * u + 3.1 * v).sin()).round() as u8;
        }
        let search = Search { half_band_px: 14, prior_sd_px: 8.0 };
        let mut points = ridge(&frame, 20..100, |_| 60.0, &CrossSection::new(STRIPE_SD_PX), search);
        let beside = leave_out(&frame, &mut points, |_| 60.3, STRIPE_SD_PX);
        (points.len(), beside)
    }

    #[test]
    fn a_stripe_by_itself_is_kept_whole() {
        assert_eq!(looked_at(|_| None), (80, Beside::default()));
        assert_eq!(
            looked_at(|u| (u as usize).is_multiple_of(9).then_some((7.0, 1.5))),
            (80, Beside::default()),
            "spatter"
        );
    }

    #[test]
    fn the_columns_into_which_a_second_line_runs_are_left_out() {
        let (left, beside) = looked_at(|u| (u < 50.0).then_some((0.25 * u, 0.8)));
        assert!((40..66).contains(&left), "{left}");
        assert_eq!(beside, Beside::default());
    }

    #[test]
    fn a_line_beside_all_of_the_leg_is_a_doubt_and_a_bright_one_a_rival() {
        let (left, faint) = looked_at(|_| Some((6.0, 0.5)));
        assert!(left == 80 && !faint.is_rival && (0.4..2.0).contains(&faint.row_sd_px), "{faint:?}");
        let (_, bright) = looked_at(|_| Some((9.0, 1.3)));
        assert!(bright.is_rival && bright.row_sd_px > 2.5, "{bright:?}");
    }
}
