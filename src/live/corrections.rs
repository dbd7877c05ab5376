//! Corrections that were sent: what of them is under way, and how much more may be.

use std::collections::VecDeque;

use super::GuideSettings;

/// What a robot's protocol resolves \[mm\]: four decimals of RSI. Steps are rounded towards zero, so that caps hold.
const RESOLUTION_MM: f64 = 1e-4;
/// Most corrections under way: a second of the shortest cycle, 1 ms; beyond them the oldest counts as executed.
const MOST: usize = 1024;

/// The corrections of one seam.
#[derive(Debug, Clone, Default)]
pub struct Corrections {
    under_way: VecDeque<(f64, f64)>,
    total_mm: f64,
}

impl Corrections {
    /// Sum of the corrections sent and not yet executed at `now_s` \[mm\].
    pub fn under_way_mm(&mut self, now_s: f64, delay_s: f64) -> f64 {
        while self.under_way.front().is_some_and(|(sent_s, _)| now_s - sent_s >= delay_s) {
            self.under_way.pop_front();
        }
        self.under_way.iter().map(|(_, step_mm)| step_mm).sum()
    }

    /// Sum of all corrections sent \[mm\].
    #[must_use]
    pub const fn total_mm(&self) -> f64 {
        self.total_mm
    }

    /// What may be sent of `wanted_mm` at `now_s`, `since_s` after the cycle before; it counts as sent.
    pub fn send(&mut self, wanted_mm: f64, (now_s, since_s): (f64, f64), settings: &GuideSettings) -> f64 {
        let most_mm = settings.step_mm.min(settings.speed_mm_s * since_s.max(0.0));
        let step_mm = wanted_mm.clamp(-most_mm, most_mm);
        let step_mm = (self.total_mm + step_mm).clamp(-settings.total_mm, settings.total_mm) - self.total_mm;
        let step_mm = (step_mm / RESOLUTION_MM).trunc() * RESOLUTION_MM;
        if step_mm != 0.0 {
            if self.under_way.len() == MOST {
                self.under_way.pop_front();
            }
            self.under_way.push_back((now_s, step_mm));
            self.total_mm += step_mm;
        }
        step_mm
    }
}
