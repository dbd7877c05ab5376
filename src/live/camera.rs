//! Where live pictures come from.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::frame::GrayFrame;
use crate::source::{FrameSource, SourceError, SourceFrame};
use crate::synth::Scene;

/// Longest that a camera is waited for before somebody looks whether the run is to end. Chosen.
const WAIT: Duration = Duration::from_millis(50);

/// The clock of one run \[s\].
#[derive(Debug, Clone, Copy)]
pub struct LiveClock(Instant);

impl LiveClock {
    /// A clock that begins now.
    #[must_use]
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Since its beginning \[s\].
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

/// One picture of a camera.
#[derive(Debug)]
pub struct Picture {
    /// What it shows.
    pub frame: GrayFrame,
    /// The camera's own stamp \[ns\].
    pub stamp_ns: u64,
    /// The same by the run's clock \[s\].
    pub exposed_s: f64,
}

/// What a camera gave.
#[derive(Debug)]
pub enum Taken {
    /// A picture.
    Picture(Picture),
    /// None came in a moment; ask again.
    Nothing,
    /// The recording is over.
    End,
}

/// Something that gives pictures. A call waits for a moment at most, so that whoever calls can be told to end.
pub trait Camera: Send {
    /// The next picture.
    fn next(&mut self, clock: &LiveClock) -> Taken;
    /// What happened that a user should know: how often pictures were unreadable, or the camera was opened anew.
    fn troubles(&self) -> u64;
    /// What a user should read now, once.
    fn news(&mut self) -> Option<String> {
        None
    }
}

/// A recording, played at its own speed.
pub struct Player {
    source: Box<dyn FrameSource>,
    /// How much faster than it was recorded.
    rate: f64,
    began: Option<(f64, f64)>,
    ahead: Option<SourceFrame>,
    unreadable: u64,
}

impl Player {
    /// Plays `source` `rate` times as fast as it was recorded.
    #[must_use]
    pub fn new(source: Box<dyn FrameSource>, rate: f64) -> Self {
        Self { source, rate, began: None, ahead: None, unreadable: 0 }
    }
}

impl Camera for Player {
    fn next(&mut self, clock: &LiveClock) -> Taken {
        let Some(frame) = self.ahead.take().or_else(|| self.source.next_frame()) else { return Taken::End };
        let (from_s, first_s) = *self.began.get_or_insert_with(|| (clock.now_s(), frame.time_s));
        let due_s = from_s + (frame.time_s - first_s) / self.rate;
        let left_s = due_s - clock.now_s();
        if left_s > 0.0 {
            std::thread::sleep(WAIT.min(Duration::from_secs_f64(left_s)));
            if left_s > WAIT.as_secs_f64() {
                self.ahead = Some(frame);
                return Taken::Nothing;
            }
        }
        match frame.picture {
            Ok(picture) => {
                let stamp_ns = (frame.time_s.max(0.0) * 1e9).round() as u64;
                Taken::Picture(Picture { frame: picture, stamp_ns, exposed_s: due_s })
            }
            Err(_) => {
                self.unreadable += 1;
                Taken::Nothing
            }
        }
    }

    fn troubles(&self) -> u64 {
        self.unreadable
    }
}

/// A made-up scene as a recording.
pub struct SceneSource {
    scene: Arc<Scene>,
    next: usize,
}

impl SceneSource {
    /// All frames of `scene`.
    #[must_use]
    pub fn new(scene: Scene) -> Self {
        Self { scene: Arc::new(scene), next: 0 }
    }
}

impl FrameSource for SceneSource {
    fn next_frame(&mut self) -> Option<SourceFrame> {
        let frame = self.next;
        if frame >= self.scene.frame_count() {
            return None;
        }
        self.next += 1;
        let time_s = self.scene.timestamp_s(frame);
        Some(SourceFrame { file: format!("scene[{frame}]"), time_s, picture: Ok(self.scene.render(frame)) })
    }

    fn frame_count(&self) -> Option<usize> {
        Some(self.scene.frame_count())
    }

    fn kind(&self) -> &'static str {
        "scene"
    }

    fn period_s(&self) -> f64 {
        self.scene.drawn_scenario().period_s
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        Ok(Box::new(Self { scene: Arc::clone(&self.scene), next: 0 }))
    }
}
