//! What the page shows: left here by the tracker, which never waits for whoever looks.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::frame::GrayFrame;
use crate::report::marks::FrameMarks;
use crate::report::overlay::draw_overlay;
use crate::report::results::PathRow;

/// Widest picture that is sent \[px\]. Chosen: half a screen, and some 30 kB.
const WIDEST_PX: u32 = 960;
/// Quality of the JPEG, 0 to 100. Chosen: stripes stay sharp.
const QUALITY: u8 = 75;

/// A frame's numbers.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seen {
    /// Frames by the tracker's status: seeking, tracked, coasting, lost.
    pub by_status: [u64; 4],
    /// Gap at the stripe \[mm\].
    pub gap_mm: Option<f64>,
    /// From the middle of the exposure to the estimate \[ms\].
    pub latency_ms: Option<f64>,
    /// One step of the tracker \[ms\].
    pub step_ms: Option<f64>,
    /// Pictures passed over since a newer one was there.
    pub passed_over: u64,
    /// Frames that the record lacks.
    pub holes: u64,
}

/// A picture and what was found in it.
pub struct Shown {
    /// The picture.
    pub picture: GrayFrame,
    /// What was found.
    pub row: PathRow,
    /// What is drawn over it.
    pub marks: FrameMarks,
}

/// The newest of both.
#[derive(Default)]
pub struct View {
    seen: Mutex<Seen>,
    shown: Mutex<Option<Shown>>,
    is_wanted: AtomicBool,
}

impl View {
    /// Leaves a frame's numbers; not while somebody reads them.
    pub fn tell(&self, seen: Seen) {
        if let Ok(mut place) = self.seen.try_lock() {
            *place = seen;
        }
    }

    /// Whether somebody waits for a picture: else none need be copied.
    pub fn is_wanted(&self) -> bool {
        self.is_wanted.load(Ordering::Relaxed)
    }

    /// Leaves a picture.
    pub fn show(&self, shown: Shown) {
        if let Ok(mut place) = self.shown.try_lock() {
            *place = Some(shown);
            self.is_wanted.store(false, Ordering::Relaxed);
        }
    }

    /// The newest numbers.
    pub fn seen(&self) -> Seen {
        *self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks for a picture.
    pub fn want(&self) {
        self.is_wanted.store(true, Ordering::Relaxed);
    }

    /// Takes the picture that was left.
    pub fn take(&self) -> Option<Shown> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Shown {
    /// The picture with its marks as JPEG; none when it cannot be drawn, which takes a lack of memory.
    pub fn jpeg(&self) -> Option<Vec<u8>> {
        let drawn = draw_overlay(&self.picture, &self.row, &self.marks).ok()?;
        let (width, height) = drawn.dimensions();
        let drawn = if width > WIDEST_PX {
            image::imageops::thumbnail(&drawn, WIDEST_PX, (height * WIDEST_PX / width).max(1))
        } else {
            drawn
        };
        let mut bytes = vec![];
        image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, QUALITY).encode_image(&drawn).ok()?;
        Some(bytes)
    }
}
