//! Pictures in an MCAP log: `sensor_msgs/Image` and `CompressedImage` of ROS 1 and 2, `foxglove.RawImage` and
//! `CompressedImage` in Protobuf, JSON or ROS encoding (<https://mcap.dev/spec/registry>). Stamps are the log's.

mod extent;
mod messages;
mod picture;
mod wire;

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use self::messages::{Log, LogError, Message, Messages};
use super::gray::{Decoded, DecodedSource, SixteenBitScale, file_name, scale_frames};
use super::{FrameError, FrameSource, Period, SourceError, SourceFrame};

/// The pictures of one topic, in the order of the log.
pub struct Mcap {
    pictures: Pictures,
    messages: Messages,
    next: usize,
    last_s: f64,
    ended: bool,
}

/// What is known of them once the log was looked through.
#[derive(Clone)]
struct Pictures {
    log: Log,
    topic: String,
    count: usize,
    first_ns: u64,
    scale: Option<SixteenBitScale>,
    period_s: f64,
    notes: Vec<String>,
}

impl Mcap {
    /// Looks the log through, which takes reading it once: the topic with the most pictures, their number and stamps, and the
    /// scale of 16-bit ones.
    pub fn open(path: &Path, period: Period) -> Result<Self, SourceError> {
        let wrong = |problem: String| SourceError::Frames { path: path.to_owned(), problem };
        let failed = |source| SourceError::Open { path: path.to_owned(), source };
        let log = Log::open(path).map_err(failed)?;
        let mut stamps: BTreeMap<String, Vec<u64>> = BTreeMap::new();
        let mut broken: Option<LogError> = None;
        for message in log.messages().map_err(failed)? {
            match message {
                Ok(message) if is_picture(&message) => {
                    stamps.entry(message.channel.topic.clone()).or_default().push(message.log_time);
                }
                Ok(_) => {}
                Err(error) => broken = Some(error),
            }
        }
        // Of topics with equally many the first by name.
        let most = stamps.iter().max_by_key(|(topic, stamps)| (stamps.len(), std::cmp::Reverse(*topic)));
        let Some((topic, of_topic)) = most.map(|(topic, stamps)| (topic.clone(), stamps.clone())) else {
            let why = broken.map_or_else(String::new, |error| format!(" ({error})"));
            return Err(wrong(format!(
                "it has no pictures of a kind that is read{why}: sensor_msgs/Image, CompressedImage, foxglove.RawImage, CompressedImage"
            )));
        };
        let mut notes = vec![];
        if stamps.len() > 1 {
            let others: Vec<&str> = stamps.keys().map(String::as_str).filter(|other| *other != topic).collect();
            notes.push(format!("pictures of {topic} are used; there are also {}", others.join(", ")));
        }
        if let Some(error) = broken {
            notes.push(format!("the log ends early: {error}"));
        }
        let not_later = of_topic.windows(2).filter(|pair| pair[1] <= pair[0]).count();
        if not_later > 0 {
            notes.push(format!("frames that are not later than the one before: {not_later}; used as they are"));
        }
        let first_ns = of_topic.iter().copied().min().unwrap_or(0);
        let sample: Vec<usize> = scale_frames(of_topic.len()).collect();
        let name = file_name(path);
        let pictures =
            log.messages().map_err(failed)?.filter_map(Result::ok).filter(|message| is_from(message, &topic));
        let sampled = pictures.enumerate().filter(|(number, _)| sample.binary_search(number).is_ok());
        let scale = SixteenBitScale::of_frames(sampled.filter_map(|(_, message)| decode(&message, &name).ok()));
        let period_s = match period {
            Period::OwnOr(default_s) => median_step_s(&of_topic).unwrap_or(default_s),
            Period::Given(period_s) => period_s,
        };
        Self::of(Pictures { log, topic, count: of_topic.len(), first_ns, scale, period_s, notes }).map_err(failed)
    }

    fn of(pictures: Pictures) -> io::Result<Self> {
        Ok(Self { messages: pictures.log.messages()?, pictures, next: 0, last_s: 0.0, ended: false })
    }
}

fn is_picture(message: &Message) -> bool {
    message.channel.schema.as_deref().is_some_and(|schema| wire::Kind::of(schema).is_some())
}

fn is_from(message: &Message, topic: &str) -> bool {
    message.channel.topic == topic && is_picture(message)
}

fn decode(message: &Message, file: &str) -> Result<Decoded, FrameError> {
    let kind = message.channel.schema.as_deref().and_then(wire::Kind::of);
    let kind = kind.ok_or_else(|| FrameError::decode(file, "its schema is unknown"))?;
    let read = wire::read(kind, &message.channel.encoding, &message.data);
    picture::decode(read.map_err(|error| FrameError::decode(file, error))?, file)
}

/// The median time from picture to picture \[s\], if it is above zero.
fn median_step_s(stamps_ns: &[u64]) -> Option<f64> {
    let mut steps: Vec<u64> = stamps_ns.windows(2).map(|pair| pair[1].saturating_sub(pair[0])).collect();
    steps.sort_unstable();
    steps.get(steps.len() / 2).map(|&step_ns| step_ns as f64 * 1e-9).filter(|step_s| *step_s > 0.0)
}

impl Mcap {
    /// The next message of the topic, or the error that ends the log.
    fn next_message(&mut self) -> Option<Result<Message, LogError>> {
        let topic = &self.pictures.topic;
        let is_wanted =
            |message: &Result<Message, LogError>| message.as_ref().map_or(true, |message| is_from(message, topic));
        self.messages.find(is_wanted)
    }
}

impl DecodedSource for Mcap {
    fn next_decoded(&mut self) -> Option<SourceFrame<Decoded>> {
        if self.ended {
            return None;
        }
        let file = format!("{}[{}]", file_name(&self.pictures.log.path), self.next);
        let message = self.next_message()?;
        self.next += 1;
        let (time_s, picture) = match message {
            Ok(message) => {
                self.last_s = message.log_time.saturating_sub(self.pictures.first_ns) as f64 * 1e-9;
                (self.last_s, decode(&message, &file))
            }
            Err(error) => {
                // What was behind it nobody knows; one frame stands for it.
                self.ended = true;
                (self.last_s + self.pictures.period_s, Err(FrameError::decode(&file, error)))
            }
        };
        Some(SourceFrame { file, time_s, picture })
    }

    fn rewound(&self) -> Result<Self, SourceError> {
        let failed = |source| SourceError::Open { path: self.pictures.log.path.clone(), source };
        Self::of(self.pictures.clone()).map_err(failed)
    }
}

impl FrameSource for Mcap {
    fn next_frame(&mut self) -> Option<SourceFrame> {
        let scale = self.pictures.scale;
        self.next_decoded().map(|frame| frame.in_gray(scale))
    }

    fn skip(&mut self, frames: usize) {
        for _ in 0..frames {
            match self.next_message() {
                Some(Ok(message)) => {
                    self.last_s = message.log_time.saturating_sub(self.pictures.first_ns) as f64 * 1e-9
                }
                Some(Err(_)) => self.ended = true,
                None => break,
            }
            self.next += 1;
        }
    }

    fn frame_count(&self) -> Option<usize> {
        Some(self.pictures.count)
    }

    fn kind(&self) -> &'static str {
        "mcap"
    }

    fn period_s(&self) -> f64 {
        self.pictures.period_s
    }

    fn notes(&self) -> &[String] {
        &self.pictures.notes
    }

    fn sixteen_bit_scale(&self) -> Option<SixteenBitScale> {
        self.pictures.scale
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        Ok(Box::new(self.rewound()?))
    }
}
