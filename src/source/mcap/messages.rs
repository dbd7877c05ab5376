//! The messages of a log, each with its channel. The records are taken apart here: the crate's own reading of them takes the
//! memory that a length within a record claims, whatever the record's size.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Take};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::extent::readable_bytes;

/// Longest record that is read \[bytes\]: a compressed log may claim any length, and memory is taken before its content is
/// there, some three times as much. Chosen: a grey picture of the most pixels that are read, in 16 bits.
const LONGEST_RECORD: usize = 1 << 27;

/// Why a log ends early.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The reader refuses it.
    #[error(transparent)]
    Log(#[from] McapError),
    /// A record is shorter than it says.
    #[error("a record is cut short")]
    Short,
    /// A message of a channel that was not announced.
    #[error("a message belongs to no channel")]
    NoChannel,
}

/// Where messages come from.
#[derive(Debug, PartialEq, Eq)]
pub struct Channel {
    pub topic: String,
    /// How its messages are written.
    pub encoding: String,
    /// What its messages are, where that is said.
    pub schema: Option<String>,
}

/// A message of a channel.
pub struct Message {
    pub channel: Arc<Channel>,
    /// When it was recorded \[ns\].
    pub log_time: u64,
    pub data: Vec<u8>,
}

/// A log, and how far it can be read.
#[derive(Clone)]
pub struct Log {
    pub path: PathBuf,
    bytes: u64,
}

impl Log {
    pub fn open(path: &Path) -> io::Result<Self> {
        Ok(Self { path: path.to_owned(), bytes: readable_bytes(File::open(path)?)? })
    }

    /// Its messages from the first one on.
    pub fn messages(&self) -> io::Result<Messages> {
        let options = LinearReaderOptions::default().with_record_length_limit(LONGEST_RECORD);
        Ok(Messages {
            file: BufReader::new(File::open(&self.path)?.take(self.bytes)),
            reader: LinearReader::new_with_options(options),
            schemas: HashMap::new(),
            channels: HashMap::new(),
            ended: false,
        })
    }
}

/// The messages one after another; an error ends them.
pub struct Messages {
    file: BufReader<Take<File>>,
    reader: LinearReader,
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, Arc<Channel>>,
    ended: bool,
}

impl Iterator for Messages {
    type Item = Result<Message, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let next = self.next_message().transpose();
        self.ended = !matches!(next, Some(Ok(_)));
        next
    }
}

impl Messages {
    fn next_message(&mut self) -> Result<Option<Message>, LogError> {
        // What stands behind the data repeats it.
        let mut is_past_data = false;
        while let Some(event) = self.reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(bytes) => {
                    let read = self.file.read(self.reader.insert(bytes))?;
                    self.reader.notify_read(read);
                }
                LinearReadEvent::Record { opcode: op::DATA_END, .. } => is_past_data = true,
                LinearReadEvent::Record { .. } if is_past_data => {}
                LinearReadEvent::Record { opcode: op::SCHEMA, data } => {
                    let mut fields = Fields(data);
                    let (id, name) = (fields.u16()?, fields.text()?);
                    self.schemas.insert(id, name);
                }
                LinearReadEvent::Record { opcode: op::CHANNEL, data } => {
                    let mut fields = Fields(data);
                    let (id, schema) = (fields.u16()?, fields.u16()?);
                    let (topic, encoding) = (fields.text()?, fields.text()?);
                    let channel = Channel { topic, encoding, schema: self.schemas.get(&schema).cloned() };
                    // Announced again it is the same.
                    if self.channels.get(&id).is_none_or(|known| **known != channel) {
                        self.channels.insert(id, Arc::new(channel));
                    }
                }
                LinearReadEvent::Record { opcode: op::MESSAGE, data } => {
                    let mut fields = Fields(data);
                    let id = fields.u16()?;
                    let _sequence: [u8; 4] = fields.array()?;
                    let log_time = u64::from_le_bytes(fields.array()?);
                    let _publish_time: [u8; 8] = fields.array()?;
                    let channel = self.channels.get(&id).ok_or(LogError::NoChannel)?;
                    return Ok(Some(Message { channel: Arc::clone(channel), log_time, data: fields.0.to_vec() }));
                }
                LinearReadEvent::Record { .. } => {}
            }
        }
        Ok(None)
    }
}

/// What is left of a record (<https://mcap.dev/spec>: little endian, texts after their lengths).
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn array<const N: usize>(&mut self) -> Result<[u8; N], LogError> {
        let (array, rest) = self.0.split_first_chunk().ok_or(LogError::Short)?;
        self.0 = rest;
        Ok(*array)
    }

    fn u16(&mut self) -> Result<u16, LogError> {
        self.array().map(u16::from_le_bytes)
    }

    fn text(&mut self) -> Result<String, LogError> {
        let bytes = u32::from_le_bytes(self.array()?) as usize;
        let (text, rest): (&'a [u8], _) = self.0.split_at_checked(bytes).ok_or(LogError::Short)?;
        self.0 = rest;
        Ok(String::from_utf8_lossy(text).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_within_a_record_that_is_longer_than_the_record_is_an_error() {
        let mut fields = Fields(&[7, 0, 255, 255, 255, 255, b'a']);
        assert_eq!(fields.u16().unwrap(), 7);
        assert!(matches!(fields.text(), Err(LogError::Short)));
        assert_eq!(Fields(&[2, 0, 0, 0, b'a', b'b']).text().unwrap(), "ab");
    }
}
