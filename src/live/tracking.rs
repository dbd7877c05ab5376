//! The tracker's thread: pictures in, sightings and the record out.

use std::sync::mpsc::{SyncSender, TrySendError};
use std::time::{Duration, Instant};

use super::camera::{LiveClock, Picture};
use super::config::LiveConfig;
use super::guide::{Offset, Sighting};
#[cfg(feature = "page")]
use super::page::{Seen, Shown, View};
use super::recorder::Entry;
use super::robot::Shared;
use super::run::{LiveError, LiveReport};
use super::slot::{Fetched, Slot};
use crate::calib::{KnownSensor, Ruler};
use crate::report::results::PathRow;
use crate::run::{expect_calibrated_size, marks, row, session_settings};
use crate::tracker::{Estimate, Observation, Session, SessionSettings, Status};
use crate::units::PixelPoint;

/// How often somebody looks whether the run is to end. Chosen.
const WAIT: Duration = Duration::from_millis(50);

/// The tracker at work.
pub struct Tracking {
    session: Session,
    known: KnownSensor,
    torch: Option<PixelPoint>,
    mirrored: bool,
    first_ns: Option<u64>,
    ruler: Option<Ruler>,
    report: LiveReport,
    #[cfg(feature = "page")]
    view: Option<std::sync::Arc<View>>,
}

impl Tracking {
    /// Before the first picture.
    pub fn new(config: &LiveConfig) -> Result<Self, LiveError> {
        let track = &config.track;
        let known = config.calibration.as_deref().map_or_else(|| Ok(track.sensor()), KnownSensor::read)?;
        if !known.sensor.has_millimetres() {
            return Err(LiveError::NoMillimetres);
        }
        let settings = SessionSettings { lag: None, ..session_settings(track, &known)? };
        Ok(Self {
            session: Session::new(&settings)?,
            known,
            torch: config.torch_px.map(|[u_px, v_px]| PixelPoint::new(u_px, v_px)),
            mirrored: config.mirrored,
            first_ns: None,
            ruler: None,
            report: LiveReport::default(),
            #[cfg(feature = "page")]
            view: None,
        })
    }

    /// Leaves what it sees where the page looks.
    #[cfg(feature = "page")]
    pub fn shown_on(self, view: Option<std::sync::Arc<View>>) -> Self {
        Self { view, ..self }
    }

    /// Tracks until no picture comes any more.
    pub fn run(
        mut self,
        slot: &Slot<Picture>,
        clock: LiveClock,
        shared: &Shared,
        saw: &SyncSender<Sighting>,
        to_log: Option<&SyncSender<Entry>>,
    ) -> Result<LiveReport, LiveError> {
        loop {
            let picture = match slot.fetch(WAIT) {
                Fetched::Newest(picture) => picture,
                Fetched::Nothing if !shared.is_ending() => continue,
                Fetched::Nothing | Fetched::Closed => return Ok(self.report),
            };
            let exposed_s = picture.exposed_s;
            expect_calibrated_size(&self.known, (picture.frame.width_px(), picture.frame.height_px()))?;
            let began = Instant::now();
            // Counted from the first one, as `track` counts those of the log.
            let first_ns = *self.first_ns.get_or_insert(picture.stamp_ns);
            let time_s = picture.stamp_ns.saturating_sub(first_ns) as f64 * 1e-9;
            let estimate = self.session.step(&picture.frame, time_s)?;
            self.report.step_ms.push(began.elapsed().as_secs_f64() * 1e3);
            self.lay_ruler(&picture);
            let sighting = self.sighting(&estimate, exposed_s);
            if saw.try_send(sighting).is_err() {
                self.report.sightings_lost += 1;
            }
            let latency_ms = (clock.now_s() - exposed_s) * 1e3;
            self.report.exposure_to_estimate_ms.push(latency_ms);
            self.report.by_status[status_number(estimate.status)] += 1;
            #[cfg(feature = "page")]
            self.show(&picture, &estimate, (time_s, latency_ms, began), slot.passed_over());
            if let Some(to_log) = to_log {
                self.record(picture, time_s, &estimate, shared, to_log);
            }
        }
    }

    fn lay_ruler(&mut self, picture: &Picture) {
        let Some(axis) = self.session.axis() else { return };
        if self.ruler.as_ref().is_some_and(|ruler| ruler.axis == axis) {
            return;
        }
        let (width, height) = (picture.frame.width_px() as f64, picture.frame.height_px() as f64);
        let middle = PixelPoint::new((width - 1.0) / 2.0, (height - 1.0) / 2.0);
        let origin = self.torch.unwrap_or(middle);
        self.ruler = Some(Ruler { sensor: self.known.sensor.clone(), axis, origin });
    }

    /// What the robot's thread needs to know of a frame.
    fn sighting(&self, estimate: &Estimate, exposed_s: f64) -> Sighting {
        let is_live = !matches!(estimate.observation, Observation::Frozen | Observation::BadStamp);
        let seen = estimate.seam.filter(|_| estimate.status == Status::Tracked && !estimate.repeated);
        let seam = self.ruler.as_ref().zip(seen).and_then(|(ruler, seam)| {
            let lateral_mm = ruler.position_mm(seam.centre)?;
            let std_mm = ruler.noise_mm2(seam.centre, seam.std_px, seam.std_across_px)?[(0, 0)].sqrt();
            Some(Offset { lateral_mm: if self.mirrored { -lateral_mm } else { lateral_mm }, std_mm })
        });
        Sighting { exposed_s, is_live, seam }
    }

    /// What `track` would write of the frame.
    fn row(&self, time_s: f64, estimate: &Estimate) -> PathRow {
        let number = self.report.by_status.iter().sum::<u64>() as usize - 1;
        row(number, format!("live[{number}]"), time_s, Some(estimate), self.ruler.as_ref())
    }

    fn record(
        &mut self,
        picture: Picture,
        time_s: f64,
        estimate: &Estimate,
        shared: &Shared,
        to_log: &SyncSender<Entry>,
    ) {
        let entry = Entry {
            picture: picture.frame,
            row: self.row(time_s, estimate),
            marks: marks(Some(estimate)),
            answer: shared.last().map(|told| told.answer),
        };
        if let Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) = to_log.try_send(entry) {
            self.report.record_holes += 1;
        }
    }

    /// Leaves the frame for the page; a copy of the picture only if somebody waits for one.
    #[cfg(feature = "page")]
    fn show(&self, picture: &Picture, estimate: &Estimate, times: (f64, f64, Instant), passed_over: u64) {
        let Some(view) = &self.view else { return };
        let (time_s, latency_ms, began) = times;
        let row = self.row(time_s, estimate);
        view.tell(Seen {
            by_status: self.report.by_status,
            gap_mm: row.gap_mm,
            latency_ms: Some(latency_ms),
            step_ms: Some(began.elapsed().as_secs_f64() * 1e3),
            passed_over,
            holes: self.report.record_holes,
        });
        if view.is_wanted() {
            view.show(Shown { picture: picture.frame.clone(), row, marks: marks(Some(estimate)) });
        }
    }
}

const fn status_number(status: Status) -> usize {
    match status {
        Status::Seeking => 0,
        Status::Tracked => 1,
        Status::Coasting => 2,
        Status::Lost => 3,
    }
}
