//! A NumPy stack of frames: an array (frames, rows, columns) in a `.npy` file, read frame by frame.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use npyz::{DType, Endianness, NpyHeader, Order, TypeChar};

use super::gray::{LONGEST_SIDE_PX, MOST_PIXELS, SixteenBitScale, file_name};
use super::intensity::{IntensityScale, IntensitySource};
use super::{FrameError, Period, SourceError, SourceFrame};
use crate::frame::IntensityFrame;

/// Frames, spread evenly over the stack, that its scale is taken from. Chosen: they meet the pool wherever it burns.
const SCALE_FRAMES: u64 = 64;
/// Most pixels of them: of larger frames every second, third … pixel is taken. Chosen: 32 MB, twice.
const SCALE_PIXELS: u64 = 1 << 22;
/// Part of the sampled floating-point pixels that may lie below black, and above white. Chosen: hot pixels are fewer.
const BEYOND_SCALE: f64 = 0.001;
/// Longest header that is read \[bytes\]: NumPy's own are below 1000.
const LONGEST_HEADER: u64 = 4096;
/// Deepest brackets of a header: a shape within the dictionary, and one more. The header's reader tries every reading of
/// deeper ones, which takes twice as long for each.
const DEEPEST_BRACKETS: usize = 3;
/// Most digits of all dimensions together: their product still fits into 64 bits.
const MOST_DIGITS: usize = 18;
/// Bytes read at a time.
const BLOCK_BYTES: usize = 1 << 16;

/// What one line must say of a file that is no stack of frames.
const WANTED: &str = "save an array (frames, rows, columns) of uint8, uint16, float16 or float32 with numpy.save";

/// The frames of a NumPy file.
pub struct NpyStack {
    path: PathBuf,
    file: File,
    /// Where the numbers begin \[bytes\].
    begins: u64,
    number: Number,
    frames: u64,
    size_px: (usize, usize),
    next: u64,
    period_s: f64,
    scale: IntensityScale,
}

/// How the file writes a number.
#[derive(Debug, Clone, Copy)]
struct Number {
    kind: NumberKind,
    is_big_endian: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NumberKind {
    U8,
    U16,
    F16,
    F32,
    F64,
}

impl NpyStack {
    /// Opens the file, checks its shape and length, and finds its scale.
    pub fn open(path: &Path, period: Period) -> Result<Self, SourceError> {
        let io_failed = |source| SourceError::Open { path: path.to_owned(), source };
        let wrong = |problem: String| SourceError::NumPy { path: path.to_owned(), problem };
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
        let is_long = rows.max(columns) > u64::from(LONGEST_SIDE_PX);
        if is_long || rows.checked_mul(columns).is_none_or(|pixels| pixels > MOST_PIXELS) {
            return Err(wrong(format!("its frames have {columns} x {rows} pixels, more than any camera's: {WANTED}")));
        }
        if header.order() == Order::Fortran && frames * rows * columns > 1 {
            return Err(wrong("it is in Fortran order: save numpy.ascontiguousarray(stack) instead".into()));
        }
        let Some(number) = Number::of(&header.dtype()) else {
            return Err(wrong(format!("its numbers are {}, which is not read: {WANTED}", header.dtype().descr())));
        };
        let frame_bytes = rows * columns * number.bytes() as u64;
        let begins = file.stream_position().map_err(io_failed)?;
        let file = file.into_inner();
        let holds = file.metadata().map_err(io_failed)?.len().saturating_sub(begins);
        if holds / frame_bytes < frames {
            let whole = holds / frame_bytes;
            return Err(wrong(format!(
                "it is cut short: its header promises {frames} frames, it holds {whole}; copy it again"
            )));
        }
        let size_px = (columns as usize, rows as usize);
        let (path, period_s) = (path.to_owned(), period.without_own_s());
        let scale = IntensityScale::EIGHT_BITS;
        let mut stack = Self { path, file, begins, number, frames, size_px, next: 0, period_s, scale };
        let sample = stack.sample().map_err(io_failed)?;
        stack.scale = scale_of(number.kind, sample);
        Ok(stack)
    }

    /// Hands the numbers of a frame to `take`, row by row.
    fn each(&self, frame: u64, mut take: impl FnMut(f64)) -> io::Result<()> {
        let pixels = self.size_px.0 * self.size_px.1;
        let mut left = pixels * self.number.bytes();
        let mut file = &self.file;
        file.seek(SeekFrom::Start(self.begins + frame * left as u64))?;
        let mut block = vec![0; BLOCK_BYTES.min(left)];
        while left > 0 {
            let read = left.min(block.len());
            file.read_exact(&mut block[..read])?;
            block[..read].chunks_exact(self.number.bytes()).for_each(|bytes| take(self.number.value(bytes)));
            left -= read;
        }
        Ok(())
    }

    fn read(&self, frame: u64, file: &str) -> Result<IntensityFrame, FrameError> {
        let (width_px, height_px) = self.size_px;
        let mut pixels = Vec::with_capacity(width_px * height_px);
        self.each(frame, |value| pixels.push(self.scale.intensity(value)))
            .map_err(|error| FrameError::decode(file, error))?;
        if !pixels.iter().all(|value| value.is_finite()) {
            return Err(FrameError::NotFinite { file: file.to_owned() });
        }
        IntensityFrame::new(width_px, height_px, pixels).map_err(|error| FrameError::decode(file, error))
    }

    /// Finite pixels of frames spread over the stack, frame by frame.
    fn sample(&self) -> io::Result<Vec<Vec<f64>>> {
        let (count, pixels) = (self.frames.min(SCALE_FRAMES), (self.size_px.0 * self.size_px.1) as u64);
        let every = (count * pixels).div_ceil(SCALE_PIXELS) as usize;
        let of_frame = |i: u64| {
            let mut sample = Vec::with_capacity((pixels as usize).div_ceil(every));
            let mut pixel = 0_usize;
            self.each(i * self.frames / count, |value| {
                if pixel.is_multiple_of(every) && value.is_finite() {
                    sample.push(value);
                }
                pixel += 1;
            })?;
            Ok(sample)
        };
        (0..count).map(of_frame).collect()
    }
}

impl IntensitySource for NpyStack {
    fn next_frame(&mut self) -> Option<SourceFrame<IntensityFrame>> {
        if self.next == self.frames {
            return None;
        }
        let frame = self.next;
        self.next += 1;
        let file = format!("{}[{frame}]", file_name(&self.path));
        let picture = self.read(frame, &file);
        Some(SourceFrame { file, time_s: frame as f64 * self.period_s, picture })
    }

    fn frame_count(&self) -> Option<usize> {
        usize::try_from(self.frames).ok()
    }

    fn kind(&self) -> &'static str {
        "NumPy stack"
    }

    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn notes(&self) -> &[String] {
        &[]
    }

    fn scale(&self) -> IntensityScale {
        self.scale
    }

    fn again(&self) -> Result<Box<dyn IntensitySource>, SourceError> {
        let path = self.path.clone();
        let file = File::open(&path).map_err(|source| SourceError::Open { path: path.clone(), source })?;
        Ok(Box::new(Self { path, file, next: 0, ..*self }))
    }
}

impl Number {
    /// None for a type that is not read.
    fn of(dtype: &DType) -> Option<Self> {
        let DType::Plain(plain) = dtype else { return None };
        let kind = match (plain.type_char(), plain.size_field()) {
            (TypeChar::Uint, 1) => NumberKind::U8,
            (TypeChar::Uint, 2) => NumberKind::U16,
            (TypeChar::Float, 2) => NumberKind::F16,
            (TypeChar::Float, 4) => NumberKind::F32,
            (TypeChar::Float, 8) => NumberKind::F64,
            _ => return None,
        };
        Some(Self { kind, is_big_endian: plain.endianness() == Endianness::Big })
    }

    const fn bytes(self) -> usize {
        match self.kind {
            NumberKind::U8 => 1,
            NumberKind::U16 | NumberKind::F16 => 2,
            NumberKind::F32 => 4,
            NumberKind::F64 => 8,
        }
    }

    /// The value of [`Self::bytes`] bytes.
    fn value(self, bytes: &[u8]) -> f64 {
        let mut little = [0; 8];
        little[..bytes.len()].copy_from_slice(bytes);
        if self.is_big_endian {
            little[..bytes.len()].reverse();
        }
        let bits = u64::from_le_bytes(little);
        match self.kind {
            NumberKind::U8 | NumberKind::U16 => bits as f64,
            NumberKind::F16 => half::f16::from_bits(bits as u16).to_f64(),
            NumberKind::F32 => f64::from(f32::from_bits(bits as u32)),
            NumberKind::F64 => f64::from_bits(bits),
        }
    }
}

/// Refuses headers that the reader would not survive: endless ones, deep brackets, and shapes whose product overflows.
/// Afterwards the file stands at its beginning.
fn check_header(file: &mut BufReader<File>) -> Result<(), String> {
    let begin = |error: io::Error| format!("it cannot be read ({error})");
    let mut start = Vec::new();
    file.by_ref().take(LONGEST_HEADER).read_to_end(&mut start).map_err(begin)?;
    file.rewind().map_err(begin)?;
    if !start.starts_with(b"\x93NUMPY") {
        return Err("it is no NumPy file".into());
    }
    let byte = |place: usize| u64::from(start.get(place).copied().unwrap_or_default());
    let (begins, length) = match byte(6) {
        0 | 1 => (10, byte(8) + (byte(9) << 8)),
        _ => (12, byte(8) + (byte(9) << 8) + (byte(10) << 16) + (byte(11) << 24)),
    };
    if begins + length > LONGEST_HEADER {
        return Err("its header is longer than any NumPy writes".into());
    }
    let end = start.len().min((begins + length) as usize);
    let text = String::from_utf8_lossy(start.get(begins as usize..end).unwrap_or_default());
    let mut depth = 0_usize;
    for character in text.chars() {
        match character {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > DEEPEST_BRACKETS {
            return Err("its header has more brackets than any NumPy writes".into());
        }
    }
    let shape = text.split("shape").nth(1).unwrap_or_default().split(')').next().unwrap_or_default();
    if shape.bytes().filter(u8::is_ascii_digit).count() > MOST_DIGITS {
        return Err("its shape is larger than any file".into());
    }
    Ok(())
}

fn scale_of(kind: NumberKind, sample: Vec<Vec<f64>>) -> IntensityScale {
    match kind {
        NumberKind::U8 => IntensityScale::EIGHT_BITS,
        NumberKind::U16 => {
            let greys = |frame: Vec<f64>| frame.into_iter().map(|value| value as u16).collect::<Vec<_>>();
            let scales = sample.into_iter().filter_map(|frame| SixteenBitScale::from_greys(&greys(frame)));
            let scale = scales.max_by_key(|scale| scale.white).unwrap_or(SixteenBitScale { white: u16::MAX });
            IntensityScale::of_sixteen_bits(scale)
        }
        _ => {
            let mut sample = sample.concat();
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A stack of frames of 4 x 2 pixels.
    fn stack(folder: &Path, descr: &str, frames: usize, data: &[u8]) -> NpyStack {
        let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({frames}, 2, 4), }}");
        header += &" ".repeat(63 - (10 + header.len()) % 64);
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        let path = folder.join("stack.npy");
        std::fs::write(&path, bytes).unwrap();
        NpyStack::open(&path, Period::Given(0.5)).unwrap()
    }

    fn values(stack: &NpyStack, frame: u64) -> Vec<f64> {
        let mut values = vec![];
        stack.each(frame, |value| values.push(value)).unwrap();
        values
    }

    #[test]
    fn numbers_of_either_byte_order_and_every_type_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let numbers: [f64; 16] = std::array::from_fn(|i| 3.0 * i as f64 + 1.0);
        let bytes = |of: &dyn Fn(f64) -> Vec<u8>| numbers.iter().flat_map(|&number| of(number)).collect::<Vec<u8>>();
        let cases = [
            ("|u1", bytes(&|x| vec![x as u8])),
            ("<u2", bytes(&|x| (x as u16).to_le_bytes().into())),
            (">u2", bytes(&|x| (x as u16).to_be_bytes().into())),
            (">f2", bytes(&|x| half::f16::from_f64(x).to_be_bytes().into())),
            ("<f4", bytes(&|x| (x as f32).to_le_bytes().into())),
            (">f4", bytes(&|x| (x as f32).to_be_bytes().into())),
            (">f8", bytes(&|x| x.to_be_bytes().into())),
        ];
        for (descr, data) in cases {
            let stack = stack(folder.path(), descr, 2, &data);
            assert_eq!(values(&stack, 1), numbers[8..], "{descr}");
            assert_eq!(values(&stack, 0), numbers[..8], "{descr}");
        }
    }

    #[test]
    fn one_lit_frame_among_dark_ones_gives_the_scale_of_sixteen_bits() {
        let folder = tempfile::tempdir().unwrap();
        let grey = |frame: usize| if frame == 40 { 4000_u16 } else { 5 };
        let data: Vec<u8> = (0..64 * 8).flat_map(|i| grey(i / 8).to_le_bytes()).collect();
        assert_eq!(stack(folder.path(), "<u2", 64, &data).scale().white, 4095.0);
    }
}
