//! What no filter averages out of the seam's place along the stripe: a second line beside a leg draws the corner aside by the
//! same in every frame, and a vibration comes and goes faster than any filter follows. It belongs to σ alone.

use super::filter::{COLOUR_COEFFICIENT, COLOUR_VARIANCE_PX2, VIBRATION_VARIANCE_PX2};
use super::height::SHAKING_COEFFICIENT;
use super::noise::WHITE_VARIANCE_PX2;
use super::roughness::{Roughness, third_difference_gain};
use crate::imgproc::geometry::{CORNER_VARIANCE_PX2, JointFit, JointKind};

/// Plates that shake across the stripe by an SD of 1 shake along it by at least so much, and by no more. The first is that of
/// the built-in scenes, .12 of .65 px, whose numbers are a robot's; the second chosen: arms swing up and down most.
const LEAST_ALONG: f64 = 0.18;
const MOST_ALONG: f64 = 0.5;
/// Third differences that count as much as what is expected before them. As in `noise.rs`.
const PRIOR_COUNT: f64 = 8.0;
/// How fast what the fits say of themselves is learned, a frame. Chosen: over some ten frames, as far as the filter remembers.
const RATE: f64 = 0.1;
/// A rival line is one when it shows in this share of the fits. Chosen.
const RIVAL_SHARE: f64 = 0.5;

/// Two edges that stay where they are this much better than plates that shake can hold them, as a share of the least variance, over
/// so many third differences, are fixed to the picture: a dead block of the sensor. Measured: .001 px where the edges of plates
/// leave .3 px and more. Chosen: a sixteenth of the SD, and half of what the seam must be seen for to be believed when it is lost.
const FIXED_SHARE: f64 = 1.0 / 256.0;
const FIXED_COUNT: usize = 12;

/// What is known of it of one joint.
#[derive(Debug, Clone)]
pub struct Lasting {
    kind: Option<JointKind>,
    expected_scale: f64,
    roughness: Roughness,
    /// Means over the last fits: what each leaves open in every frame alike, its lines' own variance \[px²\], and whether a rival
    /// line shows.
    of_fit_px2: f64,
    lines_px2: f64,
    rival: f64,
}

impl Lasting {
    /// Of a joint of `kind`, or of a hairline, on plates that are `expected_scale` times as ragged as the nominal ones.
    pub fn new(kind: Option<JointKind>, expected_scale: f64, first: Option<&JointFit>) -> Self {
        let of_fit_px2 = first.map_or(0.0, |fit| fit.lasting_px2);
        let rival = first.map_or(0.0, |fit| f64::from(u8::from(fit.has_rival)));
        Self { kind, expected_scale, roughness: Roughness::default(), of_fit_px2, lines_px2: 0.0, rival }
    }

    /// The joint goes on as one of another kind.
    pub fn becomes(&mut self, kind: JointKind) {
        *self = Self::new(Some(kind), self.expected_scale, None);
    }

    /// Takes in the fit of the next frame; none breaks the succession.
    pub fn push(&mut self, fit: Option<&JointFit>) {
        self.roughness.push(fit.map(|fit| fit.centre.u_px));
        let Some(fit) = fit else { return };
        self.of_fit_px2 += RATE * (fit.lasting_px2 - self.of_fit_px2);
        self.lines_px2 += RATE * (fit.along_variance_px2 - CORNER_VARIANCE_PX2 - self.lines_px2);
        self.rival += RATE * (f64::from(u8::from(fit.has_rival)) - self.rival);
    }

    /// Whether most of the fits had a line beside a leg that may be the leg itself.
    pub fn has_rival(&self) -> bool {
        self.rival >= RIVAL_SHARE
    }

    /// The variance that goes into σ beside the filter's and the usual vibration's \[px²\], on plates that shake across the stripe
    /// with a variance of `shaking_px2`.
    pub fn variance_px2(&self, shaking_px2: f64) -> f64 {
        let Some(kind) = self.kind else { return 0.0 };
        self.of_fit_px2 + (self.vibration_px2(kind, shaking_px2) - VIBRATION_VARIANCE_PX2).max(0.0)
    }

    /// Whether the newest sightings are those of something fixed to the picture, on plates that shake across the stripe with a
    /// variance of `shaking_px2`: a seam shakes with them. Only of edges, which are ragged, too.
    pub fn is_fixed(&self, shaking_px2: f64) -> bool {
        let least_px2 = third_difference_gain(SHAKING_COEFFICIENT) * LEAST_ALONG.powi(2) * shaking_px2;
        self.kind.is_some_and(JointKind::has_edges)
            && self.roughness.newest_px2(FIXED_COUNT).is_some_and(|jumps_px2| jumps_px2 < FIXED_SHARE * least_px2)
    }

    /// What the sightings jump by and their own noise does not explain: one stripe cannot tell a vibration from ragged edges, but a
    /// fillet has none, and a machine that vibrates does so across the stripe too.
    fn vibration_px2(&self, kind: JointKind, shaking_px2: f64) -> f64 {
        let least_px2 = LEAST_ALONG.powi(2) * shaking_px2;
        let Some((jumps_px2, count)) = self.roughness.variance() else { return least_px2 };
        let edges_px2 = third_difference_gain(0.0) * WHITE_VARIANCE_PX2
            + third_difference_gain(COLOUR_COEFFICIENT) * COLOUR_VARIANCE_PX2;
        let (own_px2, most) = match kind {
            JointKind::Fillet => (third_difference_gain(0.0) * self.lines_px2.max(0.0), 1.0),
            JointKind::Butt | JointKind::Lap | JointKind::VGroove => (self.expected_scale * edges_px2, MOST_ALONG),
        };
        let shown_px2 = (jumps_px2 - own_px2) / third_difference_gain(SHAKING_COEFFICIENT);
        let trust = count as f64 / (count as f64 + PRIOR_COUNT);
        let most_px2 = most.powi(2) * shaking_px2;
        (trust * shown_px2 + (1.0 - trust) * least_px2).clamp(least_px2, most_px2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::GrayFrame;
    use crate::imgproc::geometry::learn;
    use crate::units::PixelPoint;

    /// A fillet's fit.
    fn fit() -> JointFit {
        let mut frame = GrayFrame::filled(200, 160, 12).unwrap();
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = ((i % 200) as f64, (i / 200) as f64);
            let off_px = v - 80.0 + 0.4 * (u - 100.0).abs();
            *pixel += (180.0 * (-0.5 * (off_px / 2.0).powi(2)).exp()).round() as u8;
        }
        let model = learn(&frame, PixelPoint::new(100.0, 80.0), JointKind::Fillet).unwrap().model;
        model.fit(&frame, 100.0, 0.0, 12.0).unwrap()
    }

    /// What is left to σ of a joint that is seen to jump to and fro by `jump_px`.
    fn shaken(kind: JointKind, jump_px: f64, shaking_px2: f64) -> f64 {
        let fit = fit();
        let mut lasting = Lasting::new(Some(kind), 1.0, Some(&fit));
        for t in 0..60 {
            // Three values that come round in seven frames: no path, and no period of the third difference.
            let by_px = jump_px * [1.0, -1.0, 0.2, 1.2, -0.8, -1.1, 0.5][t % 7];
            lasting.push(Some(&JointFit { centre: PixelPoint::new(100.0 + by_px, 80.0), ..fit }));
        }
        lasting.variance_px2(shaking_px2)
    }

    #[test]
    fn a_fillet_that_jumps_vibrates_and_so_does_a_gap_on_plates_that_shake() {
        assert!(shaken(JointKind::Fillet, 0.0, 0.42) < 1e-9);
        assert!((0.15..1.5).contains(&shaken(JointKind::Fillet, 0.5, 2.0)));
        assert!(shaken(JointKind::Butt, 1.0, 4.0) > 0.3);
        assert!(shaken(JointKind::Butt, 1.0, 0.1) < 0.05, "edges that are ragged on plates at rest");
    }

    #[test]
    fn edges_that_hold_still_on_plates_that_shake_are_fixed_to_the_picture() {
        let fit = fit();
        let is_fixed = |kind: JointKind, jump_px: f64, shaking_px2: f64| {
            let mut lasting = Lasting::new(Some(kind), 1.0, Some(&fit));
            for t in 0..FIXED_COUNT + 3 {
                let by_px = jump_px * [1.0, -1.0, 0.2, 1.2, -0.8, -1.1, 0.5][t % 7];
                lasting.push(Some(&JointFit { centre: PixelPoint::new(100.0 + by_px, 80.0), ..fit }));
            }
            lasting.is_fixed(shaking_px2)
        };
        assert!(is_fixed(JointKind::Butt, 0.001, 0.42) && is_fixed(JointKind::Lap, 0.001, 0.42));
        assert!(!is_fixed(JointKind::Butt, 0.12, 0.42), "as much as plates shake at least");
        assert!(!is_fixed(JointKind::Butt, 0.0, 0.0), "plates at rest");
        assert!(!is_fixed(JointKind::Fillet, 0.001, 0.42), "legs are not ragged");
    }

    #[test]
    fn what_the_fits_leave_open_in_every_frame_alike_stays_in_sigma() {
        let fit = JointFit { lasting_px2: 2.0, has_rival: true, ..fit() };
        let mut lasting = Lasting::new(Some(JointKind::Fillet), 1.0, Some(&fit));
        (0..30).for_each(|_| lasting.push(Some(&fit)));
        assert!(lasting.variance_px2(0.1) > 1.9 && lasting.has_rival());
        (0..30).for_each(|_| lasting.push(Some(&JointFit { lasting_px2: 0.0, has_rival: false, ..fit })));
        assert!(lasting.variance_px2(0.1) < 0.2 && !lasting.has_rival());
    }
}
