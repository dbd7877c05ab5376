//! The correlation filters: one in a small window, which errs least, asked in each frame; and one in a window of twice its sides,
//! which reaches farther, asked where the small one's frame shows no seam. A camera that is knocked is elsewhere at once.

use crate::imgproc::Pixels;
use crate::kcf::{Kcf, KcfError, KcfSettings};
use crate::tracker::estimate::KcfReading;
use crate::units::PixelPoint;

/// Updates of the small window's template for one of the wide one's. Chosen: so a step costs little more.
const WIDE_EVERY: u32 = 8;
/// Label SD of the wide window relative to the small one's: 3.5 px were the best in 160 × 96 px.
const WIDER_LABEL: f64 = 1.4;

/// Both filters.
pub struct Correlation {
    near: Kcf,
    wide: Kcf,
    updates: u32,
}

impl Correlation {
    /// By the settings of the small window.
    ///
    /// # Errors
    /// When one of them is out of range.
    pub fn new(near: KcfSettings) -> Result<Self, KcfError> {
        let wide = KcfSettings {
            window_width_px: 2 * near.window_width_px,
            window_height_px: 2 * near.window_height_px,
            label_sd_px: WIDER_LABEL * near.label_sd_px,
            ..near
        };
        Ok(Self { near: Kcf::new(near)?, wide: Kcf::new(wide)?, updates: 0 })
    }

    /// Learns the seam at `centre`, forgetting all before.
    pub fn train(&mut self, frame: &mut impl Pixels, centre: PixelPoint) {
        self.near.train(&mut *frame, centre);
        self.wide.train(frame, centre);
        self.updates = 0;
    }

    /// What the small window shows round `around`.
    pub fn near(&mut self, frame: &mut impl Pixels, around: PixelPoint) -> KcfReading {
        self.near.detect(frame, around).into()
    }

    /// What the wide window shows round `around`.
    pub fn wide(&mut self, frame: &mut impl Pixels, around: PixelPoint) -> KcfReading {
        self.wide.detect(frame, around).into()
    }

    /// Learns a little of how the seam at `centre` looks now.
    pub fn update(&mut self, frame: &mut impl Pixels, centre: PixelPoint, learning_rate: f64) {
        self.near.update(&mut *frame, centre, learning_rate);
        self.updates += 1;
        if self.updates.is_multiple_of(WIDE_EVERY) {
            let kept = (1.0 - learning_rate).powi(WIDE_EVERY as i32);
            self.wide.update(frame, centre, 1.0 - kept);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{Scene, builtin};
    use crate::tracker::RobustSettings;

    #[test]
    fn a_seam_that_a_knock_takes_out_of_the_small_window_is_found_in_the_wide_one() {
        let mut scenario = builtin::scenario("butt-clean").unwrap();
        scenario.frames = 1;
        let scene = Scene::new(&scenario, 1).unwrap();
        let (frame, seam) = (scene.render(0), scene.truth(0).seam.unwrap());
        let mut correlation = Correlation::new(RobustSettings::default().kcf).unwrap();
        correlation.train(&mut &frame, seam);
        let knocked = PixelPoint::new(seam.u_px - 38.0, seam.v_px + 20.0);
        let off_px = |reading: KcfReading| (reading.peak.u_px - seam.u_px).abs();
        assert!(off_px(correlation.wide(&mut &frame, knocked)) < 3.0);
        assert!(off_px(correlation.near(&mut &frame, knocked)) > 10.0);
        let near = PixelPoint::new(seam.u_px - 5.0, seam.v_px + 3.0);
        assert!(off_px(correlation.near(&mut &frame, near)) < 1.0);
    }
}
