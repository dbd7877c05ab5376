//! What a double shows: a recording or a made-up scene that begins again behind its end.

use std::path::Path;

use super::DoubleError;
use crate::frame::GrayFrame;
use crate::live::camera::SceneSource;
use crate::source::{FrameSource, Period};
use crate::synth::{Scene, builtin};

/// Bytes of pictures that are kept. Chosen: some hundred of a common camera.
const MOST_KEPT: usize = 1 << 26;
/// A recording or a scene that begins again behind its end; a short one is kept in memory then.
pub struct Reel {
    source: Box<dyn FrameSource>,
    kept: Vec<GrayFrame>,
    /// Whether all is kept, and which comes next.
    is_whole: bool,
    next: usize,
}

impl Reel {
    /// `file:PATH` or `scene:NAME`.
    pub fn open(shows: &str) -> Result<Self, DoubleError> {
        let unknown = || DoubleError::Shows(shows.to_owned());
        let (kind, place) = shows.split_once(':').ok_or_else(unknown)?;
        let source: Box<dyn FrameSource> = match kind {
            "file" => crate::source::open(Path::new(place), Period::OwnOr(1.0))?,
            "scene" => {
                let scenario = builtin::scenario(place)?;
                Box::new(SceneSource::new(Scene::new(&scenario, scenario.seed)?))
            }
            _ => return Err(unknown()),
        };
        Ok(Self { source, kept: vec![], is_whole: false, next: 0 })
    }

    /// The next picture that can be read.
    pub fn next(&mut self) -> Option<GrayFrame> {
        if self.is_whole {
            let picture = self.kept.get(self.next % self.kept.len().max(1)).cloned();
            self.next += 1;
            return picture;
        }
        while let Some(frame) = self.source.next_frame() {
            let Ok(picture) = frame.picture else { continue };
            self.next += 1;
            let is_kept = self.kept.len() + 1 == self.next;
            if is_kept && self.next * picture.pixels().len() <= MOST_KEPT {
                self.kept.push(picture.clone());
            } else {
                self.kept.clear();
            }
            return Some(picture);
        }
        let (read, kept) = (std::mem::take(&mut self.next), self.kept.len());
        self.is_whole = kept > 0 && kept == read;
        if !self.is_whole {
            self.source = self.source.again().ok()?;
        }
        // A recording without a picture has no next one.
        if read == 0 { None } else { self.next() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::{SourceError, SourceFrame};

    /// Pictures of one pixel, from the first grey up to the second.
    struct Counter(u8, u8);

    impl FrameSource for Counter {
        fn next_frame(&mut self) -> Option<SourceFrame> {
            let grey = self.0;
            self.0 += 1;
            let picture = || GrayFrame::new(1, 1, vec![grey]).unwrap();
            (grey < self.1).then(|| SourceFrame { file: String::new(), time_s: 0.0, picture: Ok(picture()) })
        }

        fn frame_count(&self) -> Option<usize> {
            None
        }

        fn kind(&self) -> &'static str {
            "counter"
        }

        fn period_s(&self) -> f64 {
            1.0
        }

        fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
            Ok(Box::new(Self(0, self.1)))
        }
    }

    #[test]
    fn it_begins_again_and_one_without_pictures_ends() {
        let mut reel = reel_of(3);
        let greys: Vec<u8> = (0..7).map(|_| reel.next().unwrap().pixels()[0]).collect();
        assert!(greys == [0, 1, 2, 0, 1, 2, 0] && reel.is_whole);
        assert_eq!(reel_of(0).next(), None);
        assert!(Reel::open("nothing").is_err() && Reel::open("scene:nothing").is_err());
    }

    fn reel_of(pictures: u8) -> Reel {
        Reel { source: Box::new(Counter(0, pictures)), kept: vec![], is_whole: false, next: 0 }
    }
}
