//! Videos are decoded in a process of their own.
//!
//! A decoder is a large library that reads a stranger's file: it may wait for ever, break off or crash, and a thread in
//! which it does so cannot be ended. So the program runs itself once more ([`serve`]) and reads the frames from a pipe; what
//! does not come in time is ended and named. Programs that use the library decode in their own process unless they say
//! who decodes for them ([`decode_videos_by`]).
//!
//! On the pipe, little endian: frames that are counted and promised, the period; then each frame after its tag.

use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use super::gray::{check_size, file_name};
use super::video::{MOST_MISSING, Video};
use super::{FrameError, FrameSource, Period, SourceError, SourceFrame};
use crate::frame::GrayFrame;

/// Longest message of a decoder \[characters, bytes\]. Chosen: a path and a reason.
const LONGEST_REASON: usize = 1000;
const LONGEST_MESSAGE: usize = 4 * LONGEST_REASON;
const NO_COUNT: u64 = u64::MAX;

const PICTURE: u8 = 1;
const FAILED: u8 = 2;
const TOO_LARGE: u8 = 3;
const END: u8 = 4;

/// Who decodes videos.
#[derive(Debug)]
struct Decoder {
    program: PathBuf,
    patience: Duration,
}

static DECODER: OnceLock<Decoder> = OnceLock::new();

/// From now on videos are decoded by `PROGRAM decode-video FILE PERIOD`, which does [`serve`]; when nothing comes from it for
/// `patience` it is ended. Only the first call counts.
pub fn decode_videos_by(program: PathBuf, patience: Duration) {
    let _first_counts = DECODER.set(Decoder { program, patience });
}

/// Opens a video, in another process if one was named.
pub fn open(path: &Path, period: Period) -> Result<Box<dyn FrameSource>, SourceError> {
    let Some(decoder) = DECODER.get() else { return Ok(Box::new(Video::open(path, period)?)) };
    let (kind, period_s) = match period {
        Period::Given(period_s) => ("--period", period_s),
        Period::OwnOr(period_s) => ("--period-unless-own", period_s),
    };
    let mut command = Command::new(&decoder.program);
    command.arg("decode-video").arg(kind).arg(period_s.to_string()).arg("--").arg(path);
    Ok(Box::new(Watched::open(path, command, decoder.patience)?))
}

/// Decodes a video onto a pipe.
///
/// # Errors
/// When the video cannot be opened, or nobody reads the pipe.
pub fn serve(path: &Path, period: Period, out: impl Write) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let mut video = Video::open(path, period)?;
    let mut out = BufWriter::new(out);
    let count = video.frame_count().map_or(NO_COUNT, |count| count as u64);
    out.write_all(&count.to_le_bytes())?;
    out.write_all(&(video.promised() as u64).to_le_bytes())?;
    out.write_all(&video.period_s().to_le_bytes())?;
    out.flush()?;
    while let Some(frame) = video.next_frame() {
        write_frame(&frame.picture, &mut out)?;
    }
    out.write_all(&[END])?;
    Ok(out.flush()?)
}

fn write_frame(picture: &Result<GrayFrame, FrameError>, out: &mut impl Write) -> io::Result<()> {
    match picture {
        Ok(picture) => {
            out.write_all(&[PICTURE])?;
            write_size(picture.width_px() as u32, picture.height_px() as u32, out)?;
            out.write_all(picture.pixels())?;
        }
        Err(FrameError::TooLarge { width_px, height_px, .. }) => {
            out.write_all(&[TOO_LARGE])?;
            write_size(*width_px, *height_px, out)?;
        }
        Err(error) => {
            let reason = std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string);
            let reason: String = reason.chars().take(LONGEST_REASON).collect();
            out.write_all(&[FAILED])?;
            out.write_all(&(reason.len() as u32).to_le_bytes())?;
            out.write_all(reason.as_bytes())?;
        }
    }
    out.flush()
}

fn write_size(width_px: u32, height_px: u32, out: &mut impl Write) -> io::Result<()> {
    out.write_all(&width_px.to_le_bytes())?;
    out.write_all(&height_px.to_le_bytes())
}

/// What comes from a decoder.
enum Message {
    Begins { count: Option<usize>, promised: usize, period_s: f64 },
    Picture(GrayFrame),
    TooLarge { width_px: u32, height_px: u32 },
    Failed(String),
    End,
}

fn number<const N: usize>(pipe: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    pipe.read_exact(&mut bytes)?;
    Ok(bytes)
}

fn read_beginning(pipe: &mut impl Read) -> io::Result<Message> {
    let (count, promised) = (u64::from_le_bytes(number(pipe)?), u64::from_le_bytes(number(pipe)?));
    let whole = |number: u64| usize::try_from(number).unwrap_or(usize::MAX);
    let count = (count != NO_COUNT).then(|| whole(count));
    Ok(Message::Begins { count, promised: whole(promised), period_s: f64::from_le_bytes(number(pipe)?) })
}

fn read_frame(pipe: &mut impl Read) -> io::Result<Message> {
    let [tag] = number(pipe)?;
    let wrong = |what: &str| io::Error::new(io::ErrorKind::InvalidData, what.to_owned());
    match tag {
        PICTURE | TOO_LARGE => {
            let (width_px, height_px) = (u32::from_le_bytes(number(pipe)?), u32::from_le_bytes(number(pipe)?));
            if tag == TOO_LARGE || check_size("", width_px, height_px).is_err() {
                return Ok(Message::TooLarge { width_px, height_px });
            }
            let mut pixels = vec![0; width_px as usize * height_px as usize];
            pipe.read_exact(&mut pixels)?;
            let picture = GrayFrame::new(width_px as usize, height_px as usize, pixels);
            picture.map(Message::Picture).map_err(|error| wrong(&error.to_string()))
        }
        FAILED => {
            let length = u32::from_le_bytes(number(pipe)?) as usize;
            if length > LONGEST_MESSAGE {
                return Err(wrong("its message is too long"));
            }
            let mut reason = vec![0; length];
            pipe.read_exact(&mut reason)?;
            Ok(Message::Failed(String::from_utf8_lossy(&reason).into_owned()))
        }
        END => Ok(Message::End),
        _ => Err(wrong("it sends what is no frame")),
    }
}

/// Hands on what comes until nobody takes it or nothing comes.
fn listen(pipe: impl Read, messages: &SyncSender<io::Result<Message>>) {
    let mut pipe = BufReader::new(pipe);
    let mut message = read_beginning(&mut pipe);
    loop {
        let is_last = matches!(message, Err(_) | Ok(Message::End));
        if messages.send(message).is_err() || is_last {
            return;
        }
        message = read_frame(&mut pipe);
    }
}

/// A video that another process decodes, and that is watched.
struct Watched {
    path: PathBuf,
    process: Child,
    messages: Receiver<io::Result<Message>>,
    patience: Duration,
    number: usize,
    count: Option<usize>,
    promised: usize,
    period_s: f64,
    /// Why nothing more comes.
    broken: Option<String>,
    ended: bool,
}

impl Watched {
    fn open(path: &Path, mut command: Command, patience: Duration) -> Result<Self, SourceError> {
        let failed = |problem: String| SourceError::Decoder { path: path.to_owned(), problem };
        // Its standard input ends when this program does, and then so does the decoder.
        let process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        let mut process = process.map_err(|error| failed(format!("the decoder cannot be started: {error}")))?;
        let (send, messages) = sync_channel(1);
        if let Some(pipe) = process.stdout.take() {
            std::thread::spawn(move || listen(pipe, &send));
        }
        let mut video = Self {
            path: path.to_owned(),
            process,
            messages,
            patience,
            number: 0,
            count: None,
            promised: 0,
            period_s: 0.0,
            broken: None,
            ended: false,
        };
        match video.next_message() {
            Ok(Message::Begins { count, promised, period_s }) => {
                (video.count, video.promised, video.period_s) = (count, promised, period_s);
                Ok(video)
            }
            // It says by its exit code that it can make nothing of the file.
            _ if video.exit_code() == Some(1) => Err(SourceError::UnknownKind(path.to_owned())),
            Ok(_) => Err(failed("the decoder sends what is no video".to_owned())),
            Err(problem) => Err(failed(problem)),
        }
    }

    /// The next message, or why there is none; then the decoder has ended.
    fn next_message(&mut self) -> Result<Message, String> {
        let problem = match self.messages.recv_timeout(self.patience) {
            Ok(Ok(message)) => return Ok(message),
            Err(RecvTimeoutError::Timeout) => format!(
                "the decoder gave nothing for {} s and was ended: copy the file to a local disk, or convert it",
                self.patience.as_secs_f64()
            ),
            Ok(Err(error)) if error.kind() == io::ErrorKind::InvalidData => {
                format!("the decoder was ended, as {error}: convert the file")
            }
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => "the decoder broke off: convert the file".to_owned(),
        };
        self.end();
        Err(problem)
    }

    fn end(&mut self) {
        let _gone = self.process.kill();
        let _status = self.process.wait();
    }

    fn exit_code(&mut self) -> Option<i32> {
        self.process.try_wait().ok().flatten().and_then(|status| status.code())
    }

    /// The next picture, or why it is missing; none at the end.
    fn next_picture(&mut self, file: &str) -> Option<Result<GrayFrame, FrameError>> {
        let failed = |reason: String| FrameError::decode(file, reason);
        if self.ended {
            return None;
        }
        if let Some(reason) = &self.broken {
            return (self.number < self.promised).then(|| Err(failed(reason.clone())));
        }
        match self.next_message() {
            Ok(Message::Picture(picture)) => Some(Ok(picture)),
            Ok(Message::TooLarge { width_px, height_px }) => {
                Some(Err(FrameError::TooLarge { file: file.to_owned(), width_px, height_px }))
            }
            Ok(Message::Failed(reason)) => Some(Err(failed(reason))),
            Ok(Message::End | Message::Begins { .. }) => {
                self.ended = true;
                None
            }
            Err(reason) => {
                self.promised = self.promised.min(self.number.saturating_add(MOST_MISSING));
                self.broken = Some(reason.clone());
                // One frame names the reason, however many were promised.
                Some(Err(failed(reason)))
            }
        }
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        self.end();
    }
}

impl FrameSource for Watched {
    fn next_frame(&mut self) -> Option<SourceFrame> {
        let file = format!("{}[{}]", file_name(&self.path), self.number);
        let picture = self.next_picture(&file)?;
        let time_s = self.number as f64 * self.period_s;
        self.number += 1;
        Some(SourceFrame { file, time_s, picture })
    }

    fn frame_count(&self) -> Option<usize> {
        self.count
    }

    fn kind(&self) -> &'static str {
        "video"
    }

    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        open(&self.path, Period::Given(self.period_s))
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    /// A decoder that sends these bytes and then does `then`.
    fn decoder(bytes: &[u8], then: &str, patience_s: f64) -> (tempfile::TempDir, Result<Watched, SourceError>) {
        let folder = tempfile::tempdir().unwrap();
        let sent = folder.path().join("sent");
        std::fs::write(&sent, bytes).unwrap();
        let mut command = Command::new("sh");
        command.arg("-c").arg(format!("cat \"$0\"; {then}")).arg(&sent);
        let patience = Duration::from_secs_f64(patience_s);
        (folder, Watched::open(Path::new("films/a.mp4"), command, patience))
    }

    /// The beginning of a video of five frames, and the first `frames` of them.
    fn bytes(frames: u8) -> Vec<u8> {
        let mut bytes = [5u64.to_le_bytes(), 5u64.to_le_bytes(), 0.04f64.to_le_bytes()].concat();
        (0..frames).for_each(|grey| write_frame(&Ok(GrayFrame::filled(4, 3, grey).unwrap()), &mut bytes).unwrap());
        bytes
    }

    /// What is said of each frame.
    fn frames(video: &mut Watched) -> Vec<String> {
        let said = |frame: SourceFrame| match frame.picture {
            Ok(picture) => format!("{} {:.2} {}", frame.file, frame.time_s, picture.pixels()[0]),
            Err(error) => std::error::Error::source(&error).unwrap().to_string(),
        };
        std::iter::from_fn(|| video.next_frame()).map(said).collect()
    }

    #[test]
    fn frames_come_through_the_pipe_as_they_are() {
        let mut sent = bytes(2);
        let failed = FrameError::decode("", "damaged");
        write_frame(&Err(failed), &mut sent).unwrap();
        sent.push(END);
        let mut video = decoder(&sent, "true", 30.0).1.unwrap();
        assert_eq!((video.frame_count(), video.period_s()), (Some(5), 0.04));
        assert_eq!(frames(&mut video), ["a.mp4[0] 0.00 0", "a.mp4[1] 0.04 1", "damaged"]);
    }

    #[test]
    fn a_decoder_that_hangs_is_ended_and_the_frames_that_were_promised_say_why() {
        let (_folder, video) = decoder(&bytes(2), "exec sleep 600", 0.3);
        let mut video = video.unwrap();
        let said = frames(&mut video);
        assert_eq!((said.len(), said[1].as_str()), (5, "a.mp4[1] 0.04 1"));
        let why = "the decoder gave nothing for 0.3 s and was ended: copy the file to a local disk, or convert it";
        assert!(said[2..].iter().all(|said| said == why), "{said:?}");
        assert!(video.process.try_wait().unwrap().is_some(), "the process is gone");
    }

    #[test]
    fn a_decoder_that_hangs_at_once_is_an_error_that_names_the_file() {
        let error = decoder(&[], "exec sleep 600", 0.3).1.err().unwrap().to_string();
        assert!(error.starts_with("films/a.mp4: the decoder gave nothing for 0.3 s"), "{error}");
    }

    #[test]
    fn a_decoder_that_crashes_or_sends_nonsense_is_named_and_one_that_knows_no_such_file_says_so() {
        let said = frames(&mut decoder(&bytes(1), "kill -SEGV $$", 30.0).1.unwrap());
        assert!(said.len() == 5 && said[4] == "the decoder broke off: convert the file", "{said:?}");
        let said = frames(&mut decoder(&[bytes(1), vec![9; 40]].concat(), "true", 30.0).1.unwrap());
        assert!(said[1].contains("what is no frame"), "{said:?}");
        let error = decoder(&[], "exit 1", 30.0).1.err().unwrap();
        assert!(matches!(error, SourceError::UnknownKind(_)), "{error}");
    }

    #[test]
    fn a_picture_that_is_too_large_takes_no_memory() {
        let mut sent = bytes(0);
        sent.extend([PICTURE]);
        write_size(u32::MAX, u32::MAX, &mut sent).unwrap();
        let mut video = decoder(&sent, "true", 30.0).1.unwrap();
        let error = video.next_frame().unwrap().picture.unwrap_err();
        assert!(matches!(error, FrameError::TooLarge { width_px: u32::MAX, .. }), "{error}");
    }
}
