//! A NumPy stack of frames: an array (frames, rows, columns) in a `.npy` file, read frame by frame.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

use npyz::{DType, Deserialize, NpyFile, NpyHeader, NpyReader, Order, TypeChar};

use super::gray::{LARGEST_FRAME_PIXELS, SixteenBitScale, file_name};
use super::intensity::{IntensityScale, IntensitySource};
use super::{FrameError, SourceError, SourceFrame};
use crate::frame::IntensityFrame;

/// Frames, spread evenly over the stack, that its scale is taken from. Chosen: they meet the pool wherever it burns.
const SCALE_FRAMES: u64 = 64;
/// Part of the sampled floating-point pixels that may lie below black, and above white. Chosen: hot pixels are fewer.
const BEYOND_SCALE: f64 = 0.001;
/// Longest header that is read \[bytes\]: NumPy's own are below 1000.
const LONGEST_HEADER: u64 = 65_536;
/// Most digits of all dimensions together: their product still fits into 64 bits.
const MOST_DIGITS: usize = 18;

/// What one line must say of a file that is no stack of frames.
const WANTED: &str = "save an array (frames, rows, columns) of uint8, uint16, float16 or float32 with numpy.save";

/// The frames of a NumPy file.
pub struct NpyStack {
    name: String,
    values: Values,
    frames: u64,
    size_px: (usize, usize),
    next: u64,
    period_s: f64,
    scale: IntensityScale,
}

/// The file's numbers by their type.
enum Values {
    U8(NpyReader<u8, BufReader<File>>),
    U16(NpyReader<u16, BufReader<File>>),
    F16(NpyReader<half::f16, BufReader<File>>),
    F32(NpyReader<f32, BufReader<File>>),
    F64(NpyReader<f64, BufReader<File>>),
}

impl NpyStack {
    /// Opens the file, checks its shape and length, and finds its scale.
    pub fn open(path: &Path, period_s: f64) -> Result<Self, SourceError> {
        let io_failed = |source| SourceError::Open { path: path.to_owned(), source };
        let wrong = |problem: String| SourceError::NumPy { path: PathBuf::from(path), problem };
        let mut file = BufReader::new(File::open(path).map_err(io_failed)?);
        check_header(&mut file).map_err(|problem| wrong(format!("{problem}: {WANTED}")))?;
        let header = NpyHeader::from_reader(&mut file)
            .map_err(|error| wrong(format!("its header cannot be read ({error}): {WANTED}")))?;
        let &[frames, rows, columns] = header.shape() else {
            let got = header.shape().len();
            return Err(wrong(format!("it has {got} dimensions where a stack of frames has 3: {WANTED}")));
        };
        if frames == 0 || rows == 0 || columns == 0 {
            return Err(wrong(format!("its shape ({frames}, {rows}, {columns}) has no pixel: {WANTED}")));
        }
        if rows.checked_mul(columns).is_none_or(|pixels| pixels > LARGEST_FRAME_PIXELS) {
            return Err(wrong(format!("its frames have {columns} x {rows} pixels, more than any camera's: {WANTED}")));
        }
        if header.order() == Order::Fortran && frames * rows * columns > 1 {
            return Err(wrong("it is in Fortran order: save numpy.ascontiguousarray(stack) instead".into()));
        }
        let Some((item_bytes, name)) = kind(&header.dtype()) else {
            return Err(wrong(format!("its numbers are {}, which is not read: {WANTED}", header.dtype().descr())));
        };
        let data_bytes = frames * rows * columns * item_bytes;
        let begins = file.stream_position().map_err(io_failed)?;
        let holds = file.get_ref().metadata().map_err(io_failed)?.len().saturating_sub(begins);
        if holds < data_bytes {
            let whole = holds / (rows * columns * item_bytes);
            return Err(wrong(format!(
                "it is cut short: its header promises {frames} frames, it holds {whole}; copy it again"
            )));
        }
        let mut values = Values::of(NpyFile::with_header(header, file), name)
            .ok_or_else(|| wrong(format!("its numbers cannot be read: {WANTED}")))?;
        let size_px = (columns as usize, rows as usize);
        let sample = sample(&mut values, frames, rows * columns).map_err(io_failed)?;
        let scale = scale(name, sample);
        Ok(Self { name: file_name(path), values, frames, size_px, next: 0, period_s, scale })
    }

    fn read(&mut self, file: &str) -> Result<IntensityFrame, FrameError> {
        let failed =
            |source: Box<dyn std::error::Error + Send + Sync>| FrameError::Decode { file: file.to_owned(), source };
        let (width_px, height_px) = self.size_px;
        let scale = self.scale;
        let mut pixels = Vec::with_capacity(width_px * height_px);
        self.values
            .read(width_px * height_px, |value| pixels.push(scale.intensity(value)))
            .map_err(|error| failed(Box::new(error)))?;
        if !pixels.iter().all(|value| value.is_finite()) {
            return Err(FrameError::NotFinite { file: file.to_owned() });
        }
        IntensityFrame::new(width_px, height_px, pixels).map_err(|error| failed(Box::new(error)))
    }
}

impl IntensitySource for NpyStack {
    fn next_frame(&mut self) -> Option<SourceFrame<IntensityFrame>> {
        if self.next == self.frames {
            return None;
        }
        let frame = self.next;
        self.next += 1;
        let file = format!("{}[{frame}]", self.name);
        let picture = self.read(&file);
        Some(SourceFrame { file, time_s: frame as f64 * self.period_s, picture })
    }

    fn frame_count(&self) -> Option<usize> {
        usize::try_from(self.frames).ok()
    }

    fn kind(&self) -> &'static str {
        "NumPy stack"
    }

    fn scale(&self) -> IntensityScale {
        self.scale
    }
}

impl Values {
    fn of(file: NpyFile<BufReader<File>>, name: &str) -> Option<Self> {
        Some(match name {
            "uint8" => Self::U8(file.data().ok()?),
            "uint16" => Self::U16(file.data().ok()?),
            "float16" => Self::F16(file.data().ok()?),
            "float32" => Self::F32(file.data().ok()?),
            _ => Self::F64(file.data().ok()?),
        })
    }

    /// Hands the next `count` numbers to `take`.
    fn read(&mut self, count: usize, take: impl FnMut(f64)) -> io::Result<()> {
        match self {
            Self::U8(values) => each(values, count, f64::from, take),
            Self::U16(values) => each(values, count, f64::from, take),
            Self::F16(values) => each(values, count, half::f16::to_f64, take),
            Self::F32(values) => each(values, count, f64::from, take),
            Self::F64(values) => each(values, count, |value| value, take),
        }
    }

    fn seek_to(&mut self, index: u64) -> io::Result<()> {
        match self {
            Self::U8(values) => values.seek_to(index),
            Self::U16(values) => values.seek_to(index),
            Self::F16(values) => values.seek_to(index),
            Self::F32(values) => values.seek_to(index),
            Self::F64(values) => values.seek_to(index),
        }
    }
}

fn each<T: Deserialize, R: Read>(
    values: &mut NpyReader<T, R>,
    count: usize,
    number: impl Fn(T) -> f64,
    mut take: impl FnMut(f64),
) -> io::Result<()> {
    for _ in 0..count {
        let value = values.next().ok_or(io::ErrorKind::UnexpectedEof)??;
        take(number(value));
    }
    Ok(())
}

/// The number type: bytes an item and its NumPy name; none for one that is not read.
fn kind(dtype: &DType) -> Option<(u64, &'static str)> {
    let DType::Plain(plain) = dtype else { return None };
    let name = match (plain.type_char(), plain.size_field()) {
        (TypeChar::Uint, 1) => "uint8",
        (TypeChar::Uint, 2) => "uint16",
        (TypeChar::Float, 2) => "float16",
        (TypeChar::Float, 4) => "float32",
        (TypeChar::Float, 8) => "float64",
        _ => return None,
    };
    Some((plain.size_field(), name))
}

/// Refuses headers that the reader would not survive: endless ones, and shapes whose product overflows.
fn check_header(file: &mut BufReader<File>) -> Result<(), String> {
    let begin = |error: io::Error| format!("it cannot be read ({error})");
    let mut start = Vec::new();
    file.by_ref().take(LONGEST_HEADER).read_to_end(&mut start).map_err(begin)?;
    file.rewind().map_err(begin)?;
    if !start.starts_with(b"\x93NUMPY") {
        return Err("it is no NumPy file".into());
    }
    if start.get(6).is_some_and(|&major| major >= 2) && start.get(10..12).is_some_and(|high| high != [0, 0]) {
        return Err("its header is longer than any NumPy writes".into());
    }
    let text = String::from_utf8_lossy(&start);
    let shape = text.split("shape").nth(1).unwrap_or_default().split(')').next().unwrap_or_default();
    if shape.bytes().filter(u8::is_ascii_digit).count() > MOST_DIGITS {
        return Err("its shape is larger than any file".into());
    }
    Ok(())
}

/// The finite pixels of frames spread over the stack; the reader stands at its beginning again.
fn sample(values: &mut Values, frames: u64, pixels: u64) -> io::Result<Vec<f64>> {
    let count = frames.min(SCALE_FRAMES);
    let mut sample = Vec::with_capacity((count * pixels) as usize);
    for i in 0..count {
        values.seek_to(i * frames / count * pixels)?;
        values.read(pixels as usize, |value| sample.extend(Some(value).filter(|value| value.is_finite())))?;
    }
    values.seek_to(0)?;
    Ok(sample)
}

fn scale(name: &str, mut sample: Vec<f64>) -> IntensityScale {
    match name {
        "uint8" => IntensityScale::EIGHT_BITS,
        "uint16" => {
            let mut greys: Vec<u16> = sample.iter().map(|&value| value as u16).collect();
            let scale = SixteenBitScale::from_greys(&mut greys).unwrap_or(SixteenBitScale { white: u16::MAX });
            IntensityScale::of_sixteen_bits(scale)
        }
        _ => {
            let mut at = |share: f64| {
                let rank = (share * sample.len().saturating_sub(1) as f64).round() as usize;
                (!sample.is_empty()).then(|| *sample.select_nth_unstable_by(rank, f64::total_cmp).1)
            };
            let (black, white) = (at(BEYOND_SCALE).unwrap_or(0.0), at(1.0 - BEYOND_SCALE).unwrap_or(1.0));
            // A stack of one value everywhere: any scale will do, and this one has a white above its black.
            let white = if white > black { white } else { black + 1.0 };
            let rule =
                "floating point: black and white are the 0.1 % and 99.9 % points of 64 frames spread over the stack";
            IntensityScale { black, white, saturates: false, rule }
        }
    }
}
