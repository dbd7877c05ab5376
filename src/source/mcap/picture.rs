//! From a message's bytes to grey: the layouts of `sensor_msgs/image_encodings` that hold grey or colour.

use std::io::Cursor;

use image::{DynamicImage, ImageReader, RgbImage};

use super::wire::Picture;
use crate::frame::GrayFrame;
use crate::source::FrameError;
use crate::source::gray::{Decoded, check_size, decode_image};

/// Decodes a picture: raw pixels, or a compressed file where no layout is named.
pub fn decode(picture: Picture, file: &str) -> Result<Decoded, FrameError> {
    let failed = |problem: String| FrameError::decode(file, problem);
    if picture.encoding.is_empty() {
        let reader = ImageReader::new(Cursor::new(picture.data)).with_guessed_format();
        return decode_image(reader.map_err(|error| failed(error.to_string()))?, file);
    }
    check_size(file, picture.width_px, picture.height_px)?;
    let (width_px, height_px) = (picture.width_px as usize, picture.height_px as usize);
    let bytes_a_pixel = match picture.encoding.as_str() {
        "mono8" | "8UC1" => 1,
        "mono16" | "16UC1" => 2,
        "rgb8" | "bgr8" | "8UC3" => 3,
        "rgba8" | "bgra8" | "8UC4" => 4,
        other => {
            return Err(failed(format!(
                "pixels of the layout {other:?} are not read: publish mono8, mono16, rgb8 or bgr8"
            )));
        }
    };
    let row = width_px * bytes_a_pixel;
    let step = if picture.step == 0 { row } else { picture.step as usize };
    let needed = if height_px == 0 { 0 } else { step.saturating_mul(height_px - 1) + row };
    if row == 0 || height_px == 0 || step < row || picture.data.len() < needed {
        return Err(failed(format!("its {} bytes are not {width_px} x {height_px} pixels", picture.data.len())));
    }
    let pixels = picture.data.chunks(step).take(height_px).flat_map(|line| line[..row].chunks_exact(bytes_a_pixel));
    let none = || failed("it has no pixel".into());
    match bytes_a_pixel {
        1 => GrayFrame::new(width_px, height_px, pixels.flatten().copied().collect())
            .map(Decoded::Gray8)
            .map_err(|error| failed(error.to_string())),
        2 => {
            let grey = |pair: &[u8]| match picture.is_big_endian {
                true => u16::from_be_bytes([pair[0], pair[1]]),
                false => u16::from_le_bytes([pair[0], pair[1]]),
            };
            Ok(Decoded::Gray16 { width_px, height_px, pixels: pixels.map(grey).collect() })
        }
        _ => {
            let is_red_first = picture.encoding.starts_with("rgb");
            let rgb = |p: &[u8]| if is_red_first { [p[0], p[1], p[2]] } else { [p[2], p[1], p[0]] };
            let pixels = pixels.flat_map(rgb).collect();
            let image = RgbImage::from_raw(picture.width_px, picture.height_px, pixels).ok_or_else(none)?;
            Decoded::from_image(DynamicImage::ImageRgb8(image)).ok_or_else(none)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raw(encoding: &str, step: u32, data: &[u8]) -> Result<Decoded, FrameError> {
        let picture = Picture {
            width_px: 2,
            height_px: 2,
            encoding: encoding.into(),
            is_big_endian: true,
            step,
            data: data.to_vec(),
        };
        decode(picture, "log[0]")
    }

    #[test]
    fn rows_may_be_padded_and_sixteen_bits_come_in_either_order() {
        let Ok(Decoded::Gray8(gray)) = raw("mono8", 3, &[1, 2, 99, 3, 4]) else { panic!("grey") };
        assert_eq!(gray.pixels(), [1, 2, 3, 4]);
        let Ok(Decoded::Gray16 { pixels, .. }) = raw("16UC1", 0, &[1, 0, 2, 0, 3, 0, 4, 1]) else { panic!("grey") };
        assert_eq!(pixels, [256, 512, 768, 1025]);
    }

    #[test]
    fn colours_become_grey_and_what_does_not_fit_is_refused() {
        let grey = |encoding, pixel: &[u8]| match raw(encoding, 0, &pixel.repeat(4)) {
            Ok(Decoded::Gray8(gray)) => gray.pixels()[0],
            other => panic!("{other:?}"),
        };
        assert_eq!(grey("rgb8", &[200, 0, 10]), grey("bgra8", &[10, 0, 200, 255]));
        for (encoding, step, data) in
            [("mono8", 0, &[1u8, 2, 3][..]), ("mono8", 1, &[1, 2, 3, 4]), ("bayer_rggb8", 0, &[0; 4])]
        {
            assert!(raw(encoding, step, data).is_err(), "{encoding} {step}");
        }
    }
}
