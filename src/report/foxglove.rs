//! A run as an MCAP log for Foxglove: pictures, marks and path in JSON, on the time axis of `path.csv`.
//!
//! * `/camera/image`: `foxglove.CompressedImage`, PNG, so that nothing of the picture is lost;
//! * `/seam/marks`: `foxglove.ImageAnnotations`, for the image panel;
//! * `/seam/path`: one message a frame with the columns that a plot shows;
//! * `/live/state`, of a live run: what the robot was told last.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use image::{ExtendedColorType, ImageEncoder};
use mcap::records::MessageHeader;
use mcap::{Compression, McapError, WriteOptions, Writer};
use serde_json::{Value, json};

use super::marks::FrameMarks;
use super::overlay::{FILTERED, KCF, Rgb, SMOOTHED, STRIPE};
use super::results::{Estimator, PathRow};
use crate::frame::GrayFrame;
use crate::units::PixelPoint;

/// Diameter of the circle round the filtered centre, and half the diagonal of the smoothed one's diamond \[px\].
const CIRCLE_PX: f64 = 18.0;
const DIAMOND_PX: f64 = 6.0;
/// Kinds of `foxglove.PointsAnnotation`.
const LOOP: u8 = 2;
const STRIP: u8 = 3;
const LIST: u8 = 4;

/// Writes a log frame by frame.
pub struct FoxgloveLog<'a> {
    writer: Writer<BufWriter<&'a mut File>>,
    image: u16,
    marks: u16,
    path: u16,
    state: Option<u16>,
}

impl<'a> FoxgloveLog<'a> {
    /// Begins a log in `file`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn begin(file: &'a mut File) -> Result<Self, McapError> {
        // No compression: PNG has done it, and any reader opens it.
        let options = WriteOptions::new()
            .compression(None::<Compression>)
            .library(format!("seamtrack {}", env!("CARGO_PKG_VERSION")));
        let mut writer = options.create(BufWriter::new(file))?;
        let mut channel = |topic: &str, name: &str, schema: Value| {
            let id = writer.add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
            writer.add_channel(id, topic, "json", &BTreeMap::new())
        };
        let image = channel("/camera/image", "foxglove.CompressedImage", image_schema())?;
        let marks = channel("/seam/marks", "foxglove.ImageAnnotations", marks_schema())?;
        let path = channel("/seam/path", "seamtrack.PathRow", path_schema())?;
        Ok(Self { writer, image, marks, path, state: None })
    }

    /// Writes one frame: its row, and where it could be read its picture and marks.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn add(&mut self, row: &PathRow, picture: Option<(&GrayFrame, &FrameMarks)>) -> Result<(), McapError> {
        let ns = (row.time_s.max(0.0) * 1e9).round() as u64;
        if let Some((picture, marks)) = picture {
            let png = png(picture).map_err(std::io::Error::other)?;
            let message = json!({
                "timestamp": stamp(ns), "frame_id": "camera", "format": "png", "data": BASE64_STANDARD.encode(png),
            });
            self.write(self.image, row.frame, ns, &message)?;
            self.write(self.marks, row.frame, ns, &annotations(row, marks, ns))?;
        }
        self.write(self.path, row.frame, ns, &path_message(row, ns))
    }

    /// Writes what a live run told its robot last, at the time of a frame.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn add_state(&mut self, row: &PathRow, state: &Value) -> Result<(), McapError> {
        let channel = match self.state {
            Some(channel) => channel,
            None => {
                let schema = object(json!({})).to_string();
                let id = self.writer.add_schema("seamtrack.LiveState", "jsonschema", schema.as_bytes())?;
                *self.state.insert(self.writer.add_channel(id, "/live/state", "json", &BTreeMap::new())?)
            }
        };
        let ns = (row.time_s.max(0.0) * 1e9).round() as u64;
        self.write(channel, row.frame, ns, state)
    }

    fn write(&mut self, channel_id: u16, frame: usize, ns: u64, message: &Value) -> Result<(), McapError> {
        let header = MessageHeader { channel_id, sequence: frame as u32, log_time: ns, publish_time: ns };
        self.writer.write_to_known_channel(&header, message.to_string().as_bytes())
    }

    /// Writes the log's end.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<(), McapError> {
        self.writer.finish().map(|_| ())
    }
}

fn png(picture: &GrayFrame) -> image::ImageResult<Vec<u8>> {
    let mut png = vec![];
    let (width, height) = (picture.width_px() as u32, picture.height_px() as u32);
    image::codecs::png::PngEncoder::new(&mut png).write_image(
        picture.pixels(),
        width,
        height,
        ExtendedColorType::L8,
    )?;
    Ok(png)
}

fn stamp(ns: u64) -> Value {
    json!({ "sec": ns / 1_000_000_000, "nsec": ns % 1_000_000_000 })
}

fn colour([red, green, blue]: Rgb) -> Value {
    let share = |value: u8| f64::from(value) / 255.0;
    json!({ "r": share(red), "g": share(green), "b": share(blue), "a": 1.0 })
}

/// The centre of a pixel lies half a pixel behind its corner, from which Foxglove counts.
fn place(point: PixelPoint) -> Value {
    json!({ "x": point.u_px + 0.5, "y": point.v_px + 0.5 })
}

fn annotations(row: &PathRow, marks: &FrameMarks, ns: u64) -> Value {
    let lines = |kind: u8, points: Vec<PixelPoint>, rgb: Rgb| {
        let points: Vec<Value> = points.into_iter().map(place).collect();
        json!({
            "timestamp": stamp(ns), "type": kind, "points": points, "outline_color": colour(rgb), "outline_colors": [],
            "fill_color": { "r": 0.0, "g": 0.0, "b": 0.0, "a": 0.0 }, "thickness": 1.5,
        })
    };
    let around = |centre: PixelPoint, offsets: &[(f64, f64)]| {
        offsets.iter().map(|(u, v)| PixelPoint::new(centre.u_px + u, centre.v_px + v)).collect::<Vec<_>>()
    };
    let d = DIAMOND_PX;
    let mut points = vec![];
    if marks.stripe.len() > 1 {
        points.push(lines(STRIP, marks.stripe.clone(), STRIPE));
    }
    if let Some(peak) = row.point(Estimator::Kcf) {
        points.push(lines(LIST, around(peak, &[(-d, -d), (d, d), (-d, d), (d, -d)]), KCF));
    }
    if let Some(centre) = row.point(Estimator::Smoothed) {
        points.push(lines(LOOP, around(centre, &[(0.0, -d), (d, 0.0), (0.0, d), (-d, 0.0)]), SMOOTHED));
    }
    let circle = |centre: PixelPoint| {
        json!({
            "timestamp": stamp(ns), "position": place(centre), "diameter": CIRCLE_PX, "thickness": 1.5,
            "outline_color": colour(FILTERED), "fill_color": { "r": 0.0, "g": 0.0, "b": 0.0, "a": 0.0 },
        })
    };
    let circles: Vec<Value> = row.point(Estimator::Filtered).into_iter().map(circle).collect();
    json!({ "circles": circles, "points": points, "texts": [] })
}

fn path_message(row: &PathRow, ns: u64) -> Value {
    json!({
        "timestamp": stamp(ns), "frame": row.frame, "file": row.file, "status": row.status.name(),
        "u_px": row.u_px, "v_px": row.v_px, "x_mm": row.x_mm, "x_std_mm": row.x_std_mm,
        "smooth_u_px": row.smooth_u_px, "smooth_v_px": row.smooth_v_px,
        "smooth_x_mm": row.smooth_x_mm, "smooth_x_std_mm": row.smooth_x_std_mm,
        "nis": row.nis, "psr": row.psr, "gap_px": row.gap_px, "mismatch_px": row.mismatch_px,
    })
}

fn object(properties: Value) -> Value {
    json!({ "type": "object", "properties": properties })
}

fn time_schema() -> Value {
    object(json!({ "sec": { "type": "integer" }, "nsec": { "type": "integer" } }))
}

fn image_schema() -> Value {
    let mut schema = object(json!({
        "timestamp": time_schema(), "frame_id": { "type": "string" },
        "data": { "type": "string", "contentEncoding": "base64" }, "format": { "type": "string" },
    }));
    schema["title"] = json!("foxglove.CompressedImage");
    schema
}

fn marks_schema() -> Value {
    let number = json!({ "type": "number" });
    let colour = object(json!({ "r": number, "g": number, "b": number, "a": number }));
    let point = object(json!({ "x": number, "y": number }));
    let list = |items: Value| json!({ "type": "array", "items": items });
    let circle = object(json!({
        "timestamp": time_schema(), "position": point, "diameter": number, "thickness": number,
        "fill_color": colour, "outline_color": colour,
    }));
    let points = object(json!({
        "timestamp": time_schema(), "type": { "type": "integer" }, "points": list(point.clone()), "outline_color": colour,
        "outline_colors": list(colour.clone()), "fill_color": colour, "thickness": number,
    }));
    let text = object(json!({
        "timestamp": time_schema(), "position": point, "text": { "type": "string" }, "font_size": number,
        "text_color": colour, "background_color": colour,
    }));
    let mut schema = object(json!({ "circles": list(circle), "points": list(points), "texts": list(text) }));
    schema["title"] = json!("foxglove.ImageAnnotations");
    schema
}

fn path_schema() -> Value {
    let mut properties = serde_json::Map::new();
    if let Value::Object(message) =
        path_message(&PathRow::empty(0, String::new(), 0.0, super::results::Status::Lost), 0)
    {
        for (key, value) in message {
            let kind = match value {
                Value::String(_) => json!({ "type": "string" }),
                Value::Object(_) => time_schema(),
                _ => json!({ "type": ["number", "null"] }),
            };
            properties.insert(key, kind);
        }
    }
    object(Value::Object(properties))
}
