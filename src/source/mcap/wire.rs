//! Picture messages as they stand in a log: CDR (ROS 2), ROS 1, Protobuf and JSON.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

/// What a schema describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `sensor_msgs/Image`.
    RosImage,
    /// `sensor_msgs/CompressedImage`.
    RosCompressed,
    /// `foxglove.RawImage`.
    FoxgloveImage,
    /// `foxglove.CompressedImage`.
    FoxgloveCompressed,
}

impl Kind {
    /// The kind that a schema of this name describes, if it is one that is read.
    pub fn of(schema: &str) -> Option<Self> {
        Some(match schema.replace("/msg/", "/").as_str() {
            "sensor_msgs/Image" => Self::RosImage,
            "sensor_msgs/CompressedImage" => Self::RosCompressed,
            "foxglove.RawImage" | "foxglove_msgs/RawImage" => Self::FoxgloveImage,
            "foxglove.CompressedImage" | "foxglove_msgs/CompressedImage" => Self::FoxgloveCompressed,
            _ => return None,
        })
    }
}

/// A picture as it was sent.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Picture {
    pub width_px: u32,
    pub height_px: u32,
    /// Names the layout of the pixels; empty for a compressed picture.
    pub encoding: String,
    pub is_big_endian: bool,
    /// Bytes from row to row; 0 where they follow without a gap.
    pub step: u32,
    pub data: Vec<u8>,
}

/// A message that is not what its schema says.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// It ends before its content.
    #[error("the message ends before its content")]
    Short,
    /// Its encoding is not read.
    #[error("messages encoded as {0:?} are not read")]
    Encoding(String),
    /// Its content is wrong.
    #[error("the message is no {0}")]
    Malformed(&'static str),
}

/// Reads a message.
pub fn read(kind: Kind, encoding: &str, data: &[u8]) -> Result<Picture, WireError> {
    match encoding {
        "cdr" => {
            let is_little_endian = data.get(1).ok_or(WireError::Short)? % 2 == 1;
            Serial { data: data.get(4..).ok_or(WireError::Short)?, at: 0, is_little_endian, is_cdr: true }.picture(kind)
        }
        "ros1" => Serial { data, at: 0, is_little_endian: true, is_cdr: false }.picture(kind),
        "protobuf" => protobuf(kind, data),
        "json" => json(data),
        other => Err(WireError::Encoding(other.to_owned())),
    }
}

/// A message whose fields follow one another: CDR aligns numbers and ends text with a zero, ROS 1 does not.
struct Serial<'a> {
    data: &'a [u8],
    at: usize,
    is_little_endian: bool,
    is_cdr: bool,
}

impl<'a> Serial<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], WireError> {
        let end = self.at.checked_add(count).ok_or(WireError::Short)?;
        let taken = self.data.get(self.at..end).ok_or(WireError::Short)?;
        self.at = end;
        Ok(taken)
    }

    fn number(&mut self) -> Result<u32, WireError> {
        if self.is_cdr {
            self.at = self.at.next_multiple_of(4);
        }
        let bytes: [u8; 4] = self.take(4)?.try_into().map_err(|_| WireError::Short)?;
        Ok(if self.is_little_endian { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    }

    fn bytes(&mut self) -> Result<&'a [u8], WireError> {
        let count = self.number()?;
        self.take(count as usize)
    }

    fn text(&mut self) -> Result<String, WireError> {
        let text = String::from_utf8_lossy(self.bytes()?).into_owned();
        Ok(text.trim_end_matches('\0').to_owned())
    }

    fn picture(mut self, kind: Kind) -> Result<Picture, WireError> {
        let is_ros = matches!(kind, Kind::RosImage | Kind::RosCompressed);
        // A header: in ROS 1 with a running number; the stamp; the frame of reference.
        if is_ros && !self.is_cdr {
            self.number()?;
        }
        self.number()?;
        self.number()?;
        self.text()?;
        let mut picture = Picture::default();
        match kind {
            Kind::RosImage => {
                picture.height_px = self.number()?;
                picture.width_px = self.number()?;
                picture.encoding = self.text()?;
                picture.is_big_endian = self.take(1)? != [0];
                picture.step = self.number()?;
            }
            Kind::FoxgloveImage => {
                picture.width_px = self.number()?;
                picture.height_px = self.number()?;
                picture.encoding = self.text()?;
                picture.step = self.number()?;
            }
            Kind::RosCompressed => _ = self.text()?,
            Kind::FoxgloveCompressed => {}
        }
        picture.data = self.bytes()?.to_vec();
        Ok(picture)
    }
}

/// Field numbers of `foxglove.RawImage` and `foxglove.CompressedImage`, from their published definitions.
fn protobuf(kind: Kind, mut data: &[u8]) -> Result<Picture, WireError> {
    let mut picture = Picture::default();
    while !data.is_empty() {
        let key = varint(&mut data)?;
        let (field, wire) = (key >> 3, key & 7);
        let content = match wire {
            0 => {
                varint(&mut data)?;
                continue;
            }
            1 => split(&mut data, 8)?,
            2 => {
                let count = varint(&mut data)?;
                split(&mut data, usize::try_from(count).map_err(|_| WireError::Short)?)?
            }
            5 => split(&mut data, 4)?,
            _ => return Err(WireError::Malformed("Protobuf")),
        };
        let number =
            || content.try_into().map(u32::from_le_bytes).map_err(|_| WireError::Malformed("foxglove.RawImage"));
        match (kind, field) {
            (Kind::FoxgloveCompressed, 2) | (Kind::FoxgloveImage, 6) => picture.data = content.to_vec(),
            (Kind::FoxgloveImage, 2) => picture.width_px = number()?,
            (Kind::FoxgloveImage, 3) => picture.height_px = number()?,
            (Kind::FoxgloveImage, 4) => picture.encoding = String::from_utf8_lossy(content).into_owned(),
            (Kind::FoxgloveImage, 5) => picture.step = number()?,
            _ => {}
        }
    }
    Ok(picture)
}

fn split<'a>(data: &mut &'a [u8], count: usize) -> Result<&'a [u8], WireError> {
    let (taken, rest) = data.split_at_checked(count).ok_or(WireError::Short)?;
    *data = rest;
    Ok(taken)
}

fn varint(data: &mut &[u8]) -> Result<u64, WireError> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let byte = split(data, 1)?[0];
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err(WireError::Malformed("Protobuf"))
}

fn json(data: &[u8]) -> Result<Picture, WireError> {
    let wrong = WireError::Malformed("picture in JSON");
    let value: serde_json::Value = serde_json::from_slice(data).map_err(|_| wrong.clone())?;
    let number =
        |key: &str| value.get(key).and_then(serde_json::Value::as_u64).and_then(|n| u32::try_from(n).ok()).unwrap_or(0);
    let text = |key: &str| value.get(key).and_then(serde_json::Value::as_str);
    Ok(Picture {
        width_px: number("width"),
        height_px: number("height"),
        encoding: text("encoding").unwrap_or_default().to_owned(),
        is_big_endian: false,
        step: number("step"),
        data: BASE64_STANDARD.decode(text("data").ok_or(wrong.clone())?).map_err(|_| wrong)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expected() -> Picture {
        let data = vec![1, 2, 3, 4, 5, 6];
        Picture { width_px: 3, height_px: 2, encoding: "mono8".into(), is_big_endian: false, step: 3, data }
    }

    /// `sensor_msgs/Image`, written by hand: CDR pads before numbers, ROS 1 has a running number and no zeros.
    fn ros_image(is_cdr: bool) -> Vec<u8> {
        let mut bytes = if is_cdr { vec![0, 1, 0, 0] } else { vec![9, 0, 0, 0] };
        let start = bytes.len();
        let number = |bytes: &mut Vec<u8>, n: u32| {
            while is_cdr && !(bytes.len() - start).is_multiple_of(4) {
                bytes.push(0);
            }
            bytes.extend(n.to_le_bytes());
        };
        let text = |bytes: &mut Vec<u8>, text: &str| {
            number(bytes, text.len() as u32 + u32::from(is_cdr));
            bytes.extend(text.as_bytes());
            bytes.extend(is_cdr.then_some(0));
        };
        number(&mut bytes, 7);
        number(&mut bytes, 8);
        text(&mut bytes, "laser");
        number(&mut bytes, 2);
        number(&mut bytes, 3);
        text(&mut bytes, "mono8");
        bytes.push(0);
        number(&mut bytes, 3);
        number(&mut bytes, 6);
        bytes.extend([1, 2, 3, 4, 5, 6]);
        bytes
    }

    #[test]
    fn pictures_of_ros_1_and_2_are_read_and_short_ones_refused() {
        for (encoding, bytes) in [("cdr", ros_image(true)), ("ros1", ros_image(false))] {
            assert_eq!(read(Kind::RosImage, encoding, &bytes), Ok(expected()), "{encoding}");
            for length in 0..bytes.len() {
                assert_eq!(read(Kind::RosImage, encoding, &bytes[..length]), Err(WireError::Short), "{length}");
            }
        }
    }

    #[test]
    fn pictures_in_protobuf_and_json_are_read() {
        let mut bytes = vec![0x0a, 2, 8, 1, 0x15, 3, 0, 0, 0, 0x1d, 2, 0, 0, 0, 0x22, 5];
        bytes.extend(b"mono8");
        bytes.extend([0x2d, 3, 0, 0, 0, 0x32, 6, 1, 2, 3, 4, 5, 6, 0x3a, 1, b'f']);
        assert_eq!(read(Kind::FoxgloveImage, "protobuf", &bytes), Ok(expected()));
        let text =
            br#"{"timestamp":{"sec":1,"nsec":2},"width":3,"height":2,"encoding":"mono8","step":3,"data":"AQIDBAUG"}"#;
        assert_eq!(read(Kind::FoxgloveImage, "json", text), Ok(expected()));
        let compressed = read(Kind::FoxgloveCompressed, "protobuf", &[0x12, 2, 9, 9, 0x1a, 1, b'p']).unwrap();
        assert_eq!(compressed.data, [9, 9]);
        assert!(read(Kind::FoxgloveImage, "json", b"{}").is_err() && read(Kind::FoxgloveImage, "xml", b"").is_err());
        assert!(read(Kind::FoxgloveImage, "protobuf", &[0xff; 20]).is_err());
    }
}
