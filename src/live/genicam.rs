//! GigE Vision and USB3 Vision cameras through aravis: opened by address or name, and anew whenever they are gone or silent.
//!
//! The default socket buffer loses packets: it is asked for large, which the system grants up to `net.core.rmem_max`. Packets that
//! are lost are asked for again; a picture that stays incomplete is none, and counted. Handles of a dead camera block when they
//! are let go of (1.7 s measured): that is left to another thread.

use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use aravis::glib::prelude::Cast;
use aravis::prelude::{CameraExt, CameraExtManual, StreamExt};
use aravis::{Aravis, Buffer, BufferStatus, GvStream, GvStreamOption, GvStreamSocketBuffer, PixelFormat};

use super::camera::{Camera, LiveClock, Picture, Taken};
use super::config::GenicamConfig;
use super::stamps::StampMap;
use crate::frame::GrayFrame;

/// Longest that a picture is waited for before somebody looks whether the run is to end \[µs\]. Chosen.
const WAIT_US: u64 = 50_000;
/// How long is waited before a camera is looked for again, and for its answer. Chosen: it is seen soon after it returns.
const BETWEEN: Duration = Duration::from_millis(150);
const ANSWER: Duration = Duration::from_millis(100);
/// Pictures that may be under way. Chosen: an eighth of a second at 60 a second.
const BUFFERS: usize = 8;
/// A packet that is late by so much is asked for again; a picture is given up after so long, and those behind it wait for it
/// \[µs\]. Chosen: less than what makes a picture old (`fresh_s`), and enough for several requests on a busy machine.
const PACKET_LATE_US: u32 = 3_000;
const PICTURE_LATE_US: u32 = 40_000;
/// GVCP's port, and a request for who is there.
const GVCP: u16 = 3956;
const DISCOVERY: [u8; 8] = [0x42, 0x01, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01];

/// A camera behind aravis.
pub struct GenicamCamera {
    /// As aravis knows it: an address, or a name.
    name: String,
    settings: GenicamConfig,
    /// Least time from the exposure to the arrival \[s\].
    lag_s: f64,
    open: Option<Open>,
    stamps: StampMap,
    next_try: Instant,
    reopened: u64,
    incomplete: u64,
    /// What is to be told, and what was told last.
    news: Option<String>,
    told: String,
}

struct Open {
    camera: aravis::Camera,
    stream: aravis::Stream,
    heard: Instant,
}

impl GenicamCamera {
    /// The camera `name`, which need not be there yet. Its quickest picture comes `lag_s` after the exposure.
    pub fn new(name: &str, settings: GenicamConfig, lag_s: f64) -> Self {
        // Once for all cameras of the program.
        let _known = Aravis::initialize();
        Self {
            name: name.to_owned(),
            settings,
            lag_s,
            open: None,
            stamps: StampMap::default(),
            next_try: Instant::now(),
            reopened: 0,
            incomplete: 0,
            news: None,
            told: String::new(),
        }
    }

    fn tell(&mut self, words: String) {
        if words != self.told {
            self.told.clone_from(&words);
            self.news = Some(format!("camera {}: {words}", self.name));
        }
    }

    fn try_to_open(&mut self) {
        std::thread::sleep(self.next_try.saturating_duration_since(Instant::now()).min(ANSWER));
        if self.next_try > Instant::now() {
            return;
        }
        self.next_try = Instant::now() + BETWEEN;
        // To open what is not there blocks for a second.
        if self.name.parse::<IpAddr>().is_ok_and(|address| !is_there(address)) {
            self.tell("does not answer".into());
            return;
        }
        match open(&self.name, &self.settings) {
            Ok(open) => {
                self.open = Some(open);
                self.tell("is there".into());
            }
            Err(error) => self.tell(error.message().to_owned()),
        }
    }

    fn close(&mut self) {
        if let Some(Open { camera, stream, .. }) = self.open.take() {
            std::thread::spawn(move || drop((stream, camera)));
        }
        self.reopened += 1;
        self.stamps.clear();
        self.next_try = Instant::now();
        self.tell("is silent".into());
    }

    fn picture(&mut self, buffer: &Buffer, now_s: f64) -> Option<Picture> {
        // Of an incomplete picture nothing may be asked.
        let is_whole = buffer.status() == BufferStatus::Success && buffer.image_pixel_format() == PixelFormat::MONO_8;
        let frame = is_whole.then(|| {
            let [width_px, height_px] =
                [buffer.image_width(), buffer.image_height()].map(|size| usize::try_from(size).unwrap_or(0));
            GrayFrame::new(width_px, height_px, buffer.image_data()).ok()
        });
        let Some(frame) = frame.flatten() else {
            self.incomplete += 1;
            return None;
        };
        let stamp_ns = buffer.timestamp();
        let exposed_s = match stamp_ns {
            // A camera without a clock.
            0 => now_s,
            _ => self.stamps.map(stamp_ns as f64 * 1e-9, now_s),
        };
        Some(Picture { frame, stamp_ns, exposed_s: exposed_s - self.lag_s })
    }
}

impl Camera for GenicamCamera {
    fn next(&mut self, clock: &LiveClock) -> Taken {
        let Some(open) = &mut self.open else {
            self.try_to_open();
            return Taken::Nothing;
        };
        let Some(buffer) = open.stream.timeout_pop_buffer(WAIT_US) else {
            if open.heard.elapsed().as_secs_f64() > self.settings.silent_s {
                self.close();
            }
            return Taken::Nothing;
        };
        open.heard = Instant::now();
        let now_s = clock.now_s();
        let picture = self.picture(&buffer, now_s);
        if let Some(open) = &self.open {
            open.stream.push_buffer(buffer);
        }
        picture.map_or(Taken::Nothing, Taken::Picture)
    }

    fn troubles(&self) -> u64 {
        self.reopened + self.incomplete
    }

    fn news(&mut self) -> Option<String> {
        self.news.take()
    }
}

impl Drop for GenicamCamera {
    fn drop(&mut self) {
        if let Some(open) = &self.open {
            // A camera that does not answer any more stops by its heartbeat.
            let _stopped = open.camera.stop_acquisition();
        }
    }
}

/// Whether a GigE Vision camera answers.
fn is_there(address: IpAddr) -> bool {
    let any: SocketAddr = if address.is_ipv4() { ([0, 0, 0, 0], 0).into() } else { ([0; 16], 0).into() };
    let asked = UdpSocket::bind(any).and_then(|socket| {
        socket.connect((address, GVCP))?;
        socket.set_read_timeout(Some(ANSWER))?;
        socket.send(&DISCOVERY)?;
        socket.recv(&mut [0; 576])
    });
    asked.is_ok()
}

fn open(name: &str, settings: &GenicamConfig) -> Result<Open, aravis::glib::Error> {
    let camera = aravis::Camera::new(Some(name))?;
    if camera.is_gv_device() {
        camera.gv_set_stream_options(GvStreamOption::PACKET_SOCKET_DISABLED);
        match settings.packet_bytes {
            Some(bytes) => camera.gv_set_packet_size(i32::from(bytes))?,
            None => camera.gv_auto_packet_size()?,
        }
    }
    camera.set_pixel_format(PixelFormat::MONO_8)?;
    if let Some(frames_per_s) = settings.frames_per_s {
        camera.set_frame_rate(frames_per_s)?;
    }
    if let Some(exposure_us) = settings.exposure_us {
        camera.set_exposure_time(exposure_us)?;
    }
    let bytes = camera.payload()? as usize;
    let stream = camera.create_stream()?;
    if let Some(stream) = stream.downcast_ref::<GvStream>() {
        stream.set_socket_buffer(GvStreamSocketBuffer::Fixed);
        stream.set_socket_buffer_size(i32::try_from(settings.socket_bytes).unwrap_or(i32::MAX));
        stream.set_packet_timeout(PACKET_LATE_US);
        stream.set_frame_retention(PICTURE_LATE_US);
    }
    (0..BUFFERS).for_each(|_| stream.push_buffer(Buffer::new_allocate(bytes)));
    camera.start_acquisition()?;
    Ok(Open { camera, stream, heard: Instant::now() })
}
