//! Raw pictures over TCP: how a simulated cell shows what its camera sees. For loopback and tests; real cameras speak GigE
//! Vision or USB3 Vision.
//!
//! A picture is `SEAM`, columns and rows (`u32`), stamp in ns (`u64`), all little-endian, and its grey bytes row by row.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use super::camera::{Camera, LiveClock, Picture, Taken};
use super::stamps::StampMap;
use crate::frame::GrayFrame;

const MAGIC: &[u8; 4] = b"SEAM";
const HEADER: usize = 20;
/// Most pixels that are believed. Chosen: 16 million, 5 × a large stripe camera.
const MOST_PIXELS: usize = 1 << 24;
/// How long a connection may take and be silent, and how long is waited before the next \[ms\]. Chosen: a dead camera that
/// returns is seen within two seconds.
const CONNECT: Duration = Duration::from_millis(200);
const SILENT: Duration = Duration::from_millis(1000);
const WAIT: Duration = Duration::from_millis(50);

/// Writes one picture.
///
/// # Errors
/// When the other side has gone.
pub fn write_picture(to: &mut impl Write, frame: &GrayFrame, stamp_ns: u64) -> std::io::Result<()> {
    let mut message = Vec::with_capacity(HEADER + frame.pixels().len());
    message.extend_from_slice(MAGIC);
    message.extend_from_slice(&(frame.width_px() as u32).to_le_bytes());
    message.extend_from_slice(&(frame.height_px() as u32).to_le_bytes());
    message.extend_from_slice(&stamp_ns.to_le_bytes());
    message.extend_from_slice(frame.pixels());
    to.write_all(&message)
}

/// Pictures from the bytes of a stream, in whatever pieces they come.
#[derive(Debug, Default)]
struct Unpacker {
    bytes: Vec<u8>,
}

/// The stream holds something else than pictures.
#[derive(Debug, PartialEq, Eq)]
struct NotPictures;

impl Unpacker {
    fn picture(&mut self) -> Result<Option<(GrayFrame, u64)>, NotPictures> {
        let Some((header, rest)) = self.bytes.split_at_checked(HEADER) else { return Ok(None) };
        let number = |at: usize| header.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
        let stamp = header.get(12..20).and_then(|b| b.try_into().ok()).map(u64::from_le_bytes);
        let (Some(width), Some(height), Some(stamp_ns)) = (number(4), number(8), stamp) else {
            return Err(NotPictures);
        };
        let pixels = (width as usize).saturating_mul(height as usize);
        if !header.starts_with(MAGIC) || !(1..=MOST_PIXELS).contains(&pixels) {
            return Err(NotPictures);
        }
        if rest.len() < pixels {
            return Ok(None);
        }
        let frame =
            GrayFrame::new(width as usize, height as usize, rest[..pixels].to_vec()).map_err(|_| NotPictures)?;
        self.bytes.drain(..HEADER + pixels);
        Ok(Some((frame, stamp_ns)))
    }
}

/// A camera behind a stream; opened anew whenever it is gone or silent.
pub struct StreamCamera {
    address: SocketAddr,
    /// Least time from the exposure to the arrival \[s\].
    lag_s: f64,
    open: Option<Open>,
    stamps: StampMap,
    next_try: Instant,
    reopened: u64,
    buffer: Vec<u8>,
}

struct Open {
    stream: TcpStream,
    unpacker: Unpacker,
    heard: Instant,
}

impl StreamCamera {
    /// The camera at `address`, which need not be there yet. Its quickest picture comes `lag_s` after the exposure.
    #[must_use]
    pub fn new(address: SocketAddr, lag_s: f64) -> Self {
        let now = Instant::now();
        Self {
            address,
            lag_s,
            open: None,
            stamps: StampMap::default(),
            next_try: now,
            reopened: 0,
            buffer: vec![0; 1 << 18],
        }
    }

    fn close(&mut self) {
        self.open = None;
        self.reopened += 1;
        self.stamps.clear();
        self.next_try = Instant::now() + WAIT;
    }
}

impl Camera for StreamCamera {
    fn next(&mut self, clock: &LiveClock) -> Taken {
        let Some(open) = &mut self.open else {
            std::thread::sleep(self.next_try.saturating_duration_since(Instant::now()));
            self.next_try = Instant::now() + WAIT;
            let connected = TcpStream::connect_timeout(&self.address, CONNECT);
            self.open = connected
                .ok()
                .filter(|stream| stream.set_read_timeout(Some(WAIT)).is_ok())
                .map(|stream| Open { stream, unpacker: Unpacker::default(), heard: Instant::now() });
            return Taken::Nothing;
        };
        match open.unpacker.picture() {
            Ok(None) => {}
            Ok(Some((frame, stamp_ns))) => {
                let exposed_s = self.stamps.map(stamp_ns as f64 * 1e-9, clock.now_s()) - self.lag_s;
                return Taken::Picture(Picture { frame, stamp_ns, exposed_s });
            }
            Err(NotPictures) => {
                self.close();
                return Taken::Nothing;
            }
        }
        match open.stream.read(&mut self.buffer) {
            Ok(0) => self.close(),
            Ok(count) => {
                open.heard = Instant::now();
                open.unpacker.bytes.extend_from_slice(&self.buffer[..count]);
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                if open.heard.elapsed() > SILENT {
                    self.close();
                }
            }
            Err(_) => self.close(),
        }
        Taken::Nothing
    }

    fn troubles(&self) -> u64 {
        self.reopened
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_whole_out_of_whatever_pieces() {
        let frame = GrayFrame::new(3, 2, vec![1, 2, 3, 4, 5, 6]).unwrap();
        let mut bytes = vec![];
        (0..3).for_each(|i| write_picture(&mut bytes, &frame, i).unwrap());
        let (mut unpacker, mut got) = (Unpacker::default(), vec![]);
        for piece in bytes.chunks(7) {
            unpacker.bytes.extend_from_slice(piece);
            got.extend(unpacker.picture().unwrap());
        }
        assert_eq!(got, (0..3).map(|i| (frame.clone(), i)).collect::<Vec<_>>());
    }

    #[test]
    fn what_is_no_picture_is_refused_before_memory_is_taken() {
        for bytes in [
            b"HTTP/1.1 400 Bad Request\r\n".to_vec(),
            [&MAGIC[..], &[255; 16]].concat(),
            [&MAGIC[..], &[0; 16]].concat(),
        ] {
            assert_eq!(Unpacker { bytes }.picture(), Err(NotPictures));
        }
    }
}
