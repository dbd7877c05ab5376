//! The second pass over a recording: backwards, through the frames that the first one left without a value.
//!
//! A recording has no future that is unknown. A joint that is found late is followed back to where it first shows, and what
//! was lost is followed back from where it was found again. The two passes are one smoothed path; the causal columns stay
//! what they were.

use std::ops::Range;

use super::RunError;
use crate::source::{FrameSource, SizeCheck, SourceFrame};
use crate::tracker::{SeamEstimate, SeamPath, Session, SessionSettings, Status};
use crate::units::StripeAxis;

/// Frames behind a gap from which the second pass sets out. Chosen: a hairline is found within 70 frames of where it
/// shows, joints with edges within ten.
const RUN_UP_FRAMES: usize = 100;
/// Bytes of pictures that are kept to be gone through backwards; sixteen frames always are. Chosen.
const MOST_BYTES: usize = 256_000_000;
const LEAST_FRAMES: usize = 16;
/// A picture that comes again more often than this is old, but for its first frame: backwards nothing else would tell.
/// Chosen: recorders of real robots repeat pictures once, twice.
const USUAL_REPEATS: usize = 2;
/// Frames on which both passes must have a value, and agree, for the second to be believed. Chosen.
const LEAST_SHARED_FRAMES: usize = 3;
/// How far apart the passes may be in the middle of those \[σ of both\].
const AGREEMENT_SIGMAS: f64 = 3.0;
/// Frames that a seam is followed after it is no longer there. Measured on a made-up hairline, of which the last frames were up
/// to 5 px off; joints with edges are noticed at once.
const UNNOTICED_FRAMES: usize = 6;
/// Frames over which one pass goes over into the other. Chosen: no step shows.
const BLEND_FRAMES: usize = 10;

/// Fills the gaps of `smoothed`, the first pass's path, by a second one. `settings` are those of the first pass, with the
/// axis that it found.
pub fn fill(
    smoothed: &mut [Option<SeamEstimate>],
    settings: &SessionSettings,
    size_px: (usize, usize),
    source: &dyn FrameSource,
) -> Result<(), RunError> {
    let Some(axis) = settings.axis else { return Ok(()) };
    for gap in gaps(smoothed) {
        let frames = gap.start..(gap.end + RUN_UP_FRAMES).min(smoothed.len());
        let backwards = follow_back(frames.clone(), settings, size_px, source)?;
        join(&mut smoothed[frames], &backwards, gap.len(), axis);
    }
    Ok(())
}

/// The stretches without a value that have one behind them.
fn gaps(smoothed: &[Option<SeamEstimate>]) -> Vec<Range<usize>> {
    let mut gaps = vec![];
    let mut start = None;
    for (frame, seam) in smoothed.iter().enumerate() {
        match (seam, start) {
            (None, None) => start = Some(frame),
            (Some(_), Some(first)) => {
                gaps.push(first..frame);
                start = None;
            }
            _ => {}
        }
    }
    gaps
}

/// The smoothed path of a session that runs through `frames` from the last to the first; in the order of the recording.
fn follow_back(
    frames: Range<usize>,
    settings: &SessionSettings,
    size_px: (usize, usize),
    source: &dyn FrameSource,
) -> Result<Vec<Option<SeamEstimate>>, RunError> {
    let mut session = Session::new(settings)?;
    let mut path = SeamPath::default();
    let mut is_seen = Vec::with_capacity(frames.len());
    let at_a_time = (MOST_BYTES / (size_px.0 * size_px.1).max(1)).max(LEAST_FRAMES);
    let mut end = frames.end;
    while end > frames.start {
        let start = end.saturating_sub(at_a_time).max(frames.start);
        let read = read(start..end, size_px, source)?;
        let is_old = old(&read);
        for (frame, is_old) in read.into_iter().zip(is_old).rev() {
            let estimate = match &frame.picture {
                Ok(picture) if !is_old => session.step(picture, -frame.time_s)?,
                _ => session.miss(-frame.time_s)?,
            };
            path.push(&estimate);
            is_seen.push(estimate.status == Status::Tracked);
        }
        end = start;
    }
    let mut smoothed = path.smoothed()?;
    drop_ends(&mut smoothed, &is_seen);
    smoothed.reverse();
    smoothed.resize(frames.len(), None);
    Ok(smoothed)
}

/// Takes away what lies beyond the last frame in which the seam was seen before the path ends: a gap between two sightings is
/// bridged, what has but one of them is a guess.
///
/// A path that ends within the recording was followed too far before that was noticed: its last frames go too.
fn drop_ends(path: &mut [Option<SeamEstimate>], is_seen: &[bool]) {
    let ends: Vec<usize> = (1..path.len()).filter(|&i| path[i - 1].is_some() && path[i].is_none()).collect();
    for end in ends {
        path[end.saturating_sub(UNNOTICED_FRAMES)..end].fill(None);
    }
    let mut was_seen = false;
    let mut next_is_there = false;
    for (seam, &is_seen) in path.iter_mut().zip(is_seen).rev() {
        was_seen = is_seen || (was_seen && next_is_there);
        next_is_there = seam.is_some();
        if !was_seen {
            *seam = None;
        }
    }
}

/// For each frame whether its picture is one from before that was repeated too often.
fn old(frames: &[SourceFrame]) -> Vec<bool> {
    let is_same = |a: &SourceFrame, b: &SourceFrame| matches!((&a.picture, &b.picture), (Ok(a), Ok(b)) if a == b);
    frames
        .chunk_by(is_same)
        .flat_map(|same| (0..same.len()).map(|place| place > 0 && same.len() > USUAL_REPEATS + 1))
        .collect()
}

fn read(frames: Range<usize>, size_px: (usize, usize), source: &dyn FrameSource) -> Result<Vec<SourceFrame>, RunError> {
    let mut source = source.again()?;
    source.skip(frames.start);
    let mut sizes = SizeCheck::of(size_px);
    let mut kept = Vec::with_capacity(frames.len());
    while kept.len() < frames.len()
        && let Some(frame) = source.next_frame()
    {
        kept.push(sizes.admit(frame));
    }
    Ok(kept)
}

/// Puts the second pass's values into the first `gap` frames and blends them into the first pass's behind, if both agree
/// there.
fn join(first: &mut [Option<SeamEstimate>], second: &[Option<SeamEstimate>], gap: usize, axis: StripeAxis) {
    let shared: Vec<(usize, SeamEstimate, SeamEstimate)> = (gap..first.len())
        .map_while(|frame| Some((frame, first[frame]?)))
        .filter_map(|(frame, there)| Some((frame, there, second[frame]?)))
        .collect();
    let apart = |there: &SeamEstimate, back: &SeamEstimate| {
        let px = axis.along_px(there.centre) - axis.along_px(back.centre);
        px.abs() / there.std_px.hypot(back.std_px).max(f64::MIN_POSITIVE)
    };
    let mut sigmas: Vec<f64> = shared.iter().map(|(_, there, back)| apart(there, back)).collect();
    if sigmas.len() < LEAST_SHARED_FRAMES {
        return;
    }
    let middle = sigmas.len() / 2;
    if *sigmas.select_nth_unstable_by(middle, f64::total_cmp).1 > AGREEMENT_SIGMAS {
        return;
    }
    // What the second pass holds without a break from where both agree.
    for frame in (0..gap).rev() {
        let Some(back) = second[frame] else { break };
        first[frame] = Some(back);
    }
    for (frame, there, back) in shared.into_iter().filter(|(frame, ..)| *frame < gap + BLEND_FRAMES) {
        let weight = (frame - gap + 1) as f64 / (BLEND_FRAMES + 1) as f64;
        first[frame] = Some(back.blended(&there, weight));
    }
}
