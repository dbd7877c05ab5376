//! NumPy stacks made for tests.

use std::path::{Path, PathBuf};

/// A `.npy` file of that header and data.
pub fn write(path: &Path, descr: &str, fortran: bool, shape: &str, data: &[u8]) -> PathBuf {
    let order = if fortran { "True" } else { "False" };
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    std::fs::write(path, bytes).unwrap();
    path.to_owned()
}

/// A disc that grows from frame to frame, 40 × 32 pixels, dark 100, bright 1100.
pub fn discs(frames: usize) -> Vec<f32> {
    let pixel = |i: usize| {
        let (frame, v, u) = (i / (40 * 32), i / 40 % 32, i % 40);
        let distance = (u as f32 - 19.5).hypot(v as f32 - 15.5) - (8.0 + 0.02 * frame as f32);
        100.0 + 1000.0 * (0.5 - distance).clamp(0.0, 1.0)
    };
    (0..frames * 40 * 32).map(pixel).collect()
}

pub fn float32(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Half precision of numbers that it holds: 0 and 1024 to 2047 exactly.
pub fn float16(values: &[f32]) -> Vec<u8> {
    let half = |value: f32| if value < 1024.0 { 0_u16 } else { (25 << 10) | (value as u16 - 1024) };
    values.iter().flat_map(|&value| half(value).to_le_bytes()).collect()
}
