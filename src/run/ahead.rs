//! Decoding ahead of whoever uses the frames: on the thread that uses them, and on others.

use std::collections::VecDeque;
use std::num::NonZero;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::source::{NextFrame, SourceFrame};

/// Most frames that wait or are being decoded. Chosen: enough to ride over a slow one.
const FRAMES_AHEAD: usize = 8;
/// Most bytes that wait or are used; one frame may always. Chosen: eight frames of 12 megapixels.
const BYTES_AHEAD: usize = 100_000_000;

/// Hands each frame that `next` gives, and how long decoding it took, to `take`, in order, on the calling thread. The next ones are
/// decoded meanwhile, on as many other threads as [`helpers`] says, and on the calling one where it would wait: so no more threads
/// have work than there are processors. The result does not depend on them.
pub fn decode_ahead<P: Send, E>(
    next: impl FnMut() -> Option<NextFrame<P>> + Send,
    bytes: impl Fn(&P) -> usize + Sync,
    mut take: impl FnMut(SourceFrame<P>, Duration) -> Result<(), E>,
) -> Result<(), E> {
    let line = Line { next: Mutex::new(next), bytes, state: Mutex::default(), changed: Condvar::new() };
    std::thread::scope(|scope| {
        for _ in 0..helpers() {
            scope.spawn(|| {
                while line.enter() {
                    line.decode();
                }
            });
        }
        let mut done = Ok(());
        while let Some((frame, took)) = line.first() {
            let size = line.size(&frame);
            done = take(frame, took);
            line.leave(size);
            if done.is_err() {
                break;
            }
        }
        line.close();
        done
    })
}

/// Threads that decode beside the one that uses the frames: one for each other processor; where the recording is one of a batch, its
/// share of them.
fn helpers() -> usize {
    let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
    let at_a_time = if rayon::current_thread_index().is_some() { rayon::current_num_threads() } else { 1 };
    (processors / at_a_time.max(1)).saturating_sub(1)
}

/// Frames on their way from `next` to whoever uses them.
struct Line<P, N, B> {
    next: Mutex<N>,
    bytes: B,
    state: Mutex<State<P>>,
    changed: Condvar,
}

/// A frame and how long decoding it took.
type Decoded<P> = (SourceFrame<P>, Duration);

struct State<P> {
    /// The frames that were begun and not taken yet, in order: `None` while one is being decoded.
    frames: VecDeque<Option<Decoded<P>>>,
    /// How many were taken: the number of the first of `frames`.
    taken: usize,
    /// Bytes of the frames that are decoded and not yet done with.
    bytes: usize,
    /// Threads that have room for a frame and have not brought it yet, and the bytes of the largest so far, which each may have.
    under_way: usize,
    largest: Option<usize>,
    /// `next` has no more.
    is_at_end: bool,
    /// Nobody takes frames any more.
    is_closed: bool,
}

impl<P> Default for State<P> {
    fn default() -> Self {
        Self {
            frames: VecDeque::new(),
            taken: 0,
            bytes: 0,
            under_way: 0,
            largest: None,
            is_at_end: false,
            is_closed: false,
        }
    }
}

impl<P> State<P> {
    /// Whether there is no room for another frame. The first one goes alone: it tells how large they are.
    fn is_full(&self) -> bool {
        let waiting = self.frames.iter().flatten().count();
        waiting + self.under_way >= FRAMES_AHEAD
            || match self.largest {
                None => self.under_way > 0,
                Some(largest) => {
                    let held = self.bytes + self.under_way * largest;
                    held > 0 && held + largest > BYTES_AHEAD
                }
            }
    }

    fn is_over(&self) -> bool {
        self.is_at_end || self.is_closed
    }
}

impl<P, N: FnMut() -> Option<NextFrame<P>>, B: Fn(&P) -> usize> Line<P, N, B> {
    fn state(&self) -> MutexGuard<'_, State<P>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn size(&self, frame: &SourceFrame<P>) -> usize {
        frame.picture.as_ref().map_or(0, &self.bytes)
    }

    /// Waits until there is room for a frame; false when no more are wanted.
    fn enter(&self) -> bool {
        let full = |state: &mut State<P>| !state.is_over() && state.is_full();
        let mut state = self.changed.wait_while(self.state(), full).unwrap_or_else(PoisonError::into_inner);
        state.under_way += usize::from(!state.is_over());
        !state.is_over()
    }

    /// Decodes the next frame, where there is one, into the room that was made for it.
    fn decode(&self) {
        let _closing = CloseOnPanic(self);
        let mut next = self.next.lock().unwrap_or_else(PoisonError::into_inner);
        let began = Instant::now();
        let frame = next();
        let mut state = self.state();
        let number = state.taken + state.frames.len();
        match &frame {
            Some(_) => state.frames.push_back(None),
            None => {
                state.is_at_end = true;
                state.under_way -= 1;
            }
        }
        drop((state, next));
        if let Some(frame) = frame {
            let frame = frame.decoded();
            let took = began.elapsed();
            let size = self.size(&frame);
            let mut state = self.state();
            state.under_way -= 1;
            state.bytes += size;
            state.largest = Some(size.max(state.largest.unwrap_or(0)));
            // Whoever no longer waits for it has had enough.
            let place = number.checked_sub(state.taken);
            if let Some(place) = place.and_then(|place| state.frames.get_mut(place)) {
                *place = Some((frame, took));
            }
        }
        self.changed.notify_all();
    }

    /// The first frame of the line, as soon as it is decoded; further ones are decoded here meanwhile.
    fn first(&self) -> Option<Decoded<P>> {
        loop {
            let mut state = self.state();
            if state.frames.front().is_some_and(Option::is_some) {
                state.taken += 1;
                return state.frames.pop_front().flatten();
            }
            if state.is_closed || (state.is_at_end && state.frames.is_empty() && state.under_way == 0) {
                return None;
            }
            if state.is_at_end || state.is_full() {
                drop(self.changed.wait(state));
            } else {
                state.under_way += 1;
                drop(state);
                self.decode();
            }
        }
    }

    /// A frame that was taken is done with.
    fn leave(&self, size: usize) {
        self.state().bytes -= size;
        self.changed.notify_all();
    }

    fn close(&self) {
        self.state().is_closed = true;
        self.changed.notify_all();
    }
}

/// A decoder that panics brings no frame: nobody may wait for it. The panic goes on where the threads are joined.
struct CloseOnPanic<'a, P, N: FnMut() -> Option<NextFrame<P>>, B: Fn(&P) -> usize>(&'a Line<P, N, B>);

impl<P, N: FnMut() -> Option<NextFrame<P>>, B: Fn(&P) -> usize> Drop for CloseOnPanic<'_, P, N, B> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.close();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    fn frame(number: usize) -> SourceFrame<usize> {
        SourceFrame { file: String::new(), time_s: 0.0, picture: Ok(number) }
    }

    #[test]
    fn frames_come_in_order_and_large_ones_wait_one_at_a_time() {
        let decoded = Arc::new(AtomicUsize::new(0));
        let mut numbers = 0..40;
        let mut taken = vec![];
        let done: Result<(), ()> = decode_ahead(
            || {
                let number = numbers.next()?;
                let decoded = Arc::clone(&decoded);
                Some(NextFrame::Encoded(Box::new(move || {
                    decoded.fetch_add(1, Ordering::SeqCst);
                    frame(number)
                })))
            },
            |_| BYTES_AHEAD,
            |frame, _| {
                // None is decoded while this one is used.
                assert!(decoded.load(Ordering::SeqCst) <= taken.len() + 1);
                taken.push(frame.picture.unwrap());
                Ok(())
            },
        );
        assert!(done.is_ok() && taken == (0..40).collect::<Vec<_>>());
    }

    #[test]
    fn no_more_threads_decode_than_there_are_processors_and_none_waits_for_a_panic() {
        let threads = Mutex::new(std::collections::HashSet::new());
        let mut numbers = 0..400;
        let next = || {
            let number = numbers.next()?;
            let threads = &threads;
            Some(NextFrame::Decoded({
                threads.lock().unwrap().insert(std::thread::current().id());
                frame(number)
            }))
        };
        let done: Result<(), ()> = decode_ahead(next, |_| 1, |_, _| Ok(()));
        assert!(done.is_ok() && threads.lock().unwrap().len() <= helpers() + 1);

        let panicking = std::panic::catch_unwind(|| {
            let mut numbers = 0..40;
            let next = || {
                let number = numbers.next()?;
                Some(NextFrame::Encoded(Box::new(move || if number == 9 { panic!("broken") } else { frame(number) })))
            };
            decode_ahead(next, |_| 1, |_, _| Ok::<(), ()>(()))
        });
        assert!(panicking.is_err());
    }

    #[test]
    fn an_error_ends_the_decoding() {
        let done = decode_ahead(|| Some(NextFrame::Decoded(frame(1))), |_| BYTES_AHEAD, |_, _| Err("enough"));
        assert_eq!(done, Err("enough"));
    }
}
