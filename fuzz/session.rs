//! Any frames with any stamps through a session.

use seamtrack::config::{Config, Preset};
use seamtrack::{GrayFrame, MmPerPx, Sensor, Session, SessionSettings, Status, StripeAxis};

/// Most frames of an input.
const MOST_FRAMES: usize = 12;
/// Smallest and largest side of the frames \[px\].
const SIDES_PX: (usize, usize) = (1, 160);

/// The bytes, one after the other, then zeros.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn next(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    fn side_px(&mut self) -> usize {
        (SIDES_PX.0 + usize::from(self.next())).min(SIDES_PX.1)
    }

    fn number(&mut self) -> f64 {
        f64::from_le_bytes(std::array::from_fn(|_| self.next()))
    }
}

/// A session says of every frame where the seam is, with a finite value and σ, or that it cannot tell; whatever it is shown.
pub fn run(input: &[u8]) {
    let mut bytes = Bytes(input);
    let (width, height, options) = (bytes.side_px(), bytes.side_px(), bytes.next());
    let config = Config { preset: if options & 1 == 0 { Preset::Robust } else { Preset::Paper }, ..Config::default() };
    let axis = [None, Some(StripeAxis::Horizontal), Some(StripeAxis::Vertical), None][usize::from(options >> 1 & 3)];
    let sensor = if options & 8 == 0 { Sensor::Pixels } else { Sensor::Scale(MmPerPx::DU_2022) };
    let method = config.method().expect("the defaults are a method");
    let settings = SessionSettings { axis, sensor, ..SessionSettings::new(method) };
    let mut session = Session::new(&settings).expect("the defaults make a session");
    let mut stamp_s = 0.0;
    let mut frame = stripe(width, height, 0, 0);
    for _ in 0..MOST_FRAMES {
        if bytes.0.is_empty() {
            break;
        }
        stamp_s = stamp(&mut bytes, stamp_s);
        let seen = match bytes.next() % 8 {
            0 => session.miss(stamp_s),
            1 => session.step(&stripe(height, width, 1, 2), stamp_s),
            2 => session.step(&frame, stamp_s),
            what => {
                frame = picture(what, width, height, &mut bytes);
                session.step(&frame, stamp_s)
            }
        };
        let Ok(estimate) = seen else { continue };
        assert_eq!(estimate.seam.is_some(), matches!(estimate.status, Status::Tracked | Status::Coasting));
        if let Some(seam) = estimate.seam {
            let numbers = [seam.centre.u_px, seam.centre.v_px, seam.std_px, seam.std_across_px];
            assert!(numbers.iter().all(|number| number.is_finite()) && seam.std_px > 0.0, "{estimate:?}");
        }
    }
}

fn stamp(bytes: &mut Bytes<'_>, before_s: f64) -> f64 {
    match bytes.next() % 10 {
        0..=4 => before_s + 0.2,
        5 => before_s,
        6 => before_s - 1.0,
        7 => before_s + 3600.0,
        8 => f64::NAN,
        _ => bytes.number(),
    }
}

fn picture(what: u8, width: usize, height: usize, bytes: &mut Bytes<'_>) -> GrayFrame {
    match what {
        3 => GrayFrame::filled(width, height, bytes.next()).expect("it has pixels"),
        // The rest of the input, over and over.
        4 if !bytes.0.is_empty() => {
            let pixels = bytes.0.iter().copied().cycle().take(width * height).collect();
            bytes.next();
            GrayFrame::new(width, height, pixels).expect("it has pixels")
        }
        5 => {
            let mut noise = u32::from(bytes.next()).wrapping_mul(2_654_435_761) | 1;
            let pixels = (0..width * height).map(|_| {
                noise ^= noise << 13;
                noise ^= noise >> 17;
                noise ^= noise << 5;
                noise as u8
            });
            GrayFrame::new(width, height, pixels.collect()).expect("it has pixels")
        }
        _ => stripe(width, height, bytes.next(), bytes.next()),
    }
}

/// A stripe with a step, a kink or a gap at `at`.
fn stripe(width: usize, height: usize, at: u8, kind: u8) -> GrayFrame {
    let (at, depth) = (width as f64 * f64::from(at) / 255.0, f64::from(kind >> 2) / 2.0);
    let middle = height as f64 / 2.0;
    let pixels = (0..width * height).map(|i| {
        let (u, v) = ((i % width) as f64, (i / width) as f64);
        let beside = u - at;
        let row = match kind & 3 {
            0 if beside > 0.0 => middle + depth,
            1 => middle + depth * (1.0 - beside.abs() / 20.0).max(0.0),
            2 => middle + 0.3 * beside.abs(),
            _ => middle,
        };
        let is_gap = kind & 3 == 3 && beside.abs() < depth;
        let light = if is_gap { 0.0 } else { 200.0 * (-0.5 * ((v - row) / 2.0).powi(2)).exp() };
        (8.0 + light) as u8
    });
    GrayFrame::new(width, height, pixels.collect()).expect("it has pixels")
}
