//! Decoding ahead of whoever uses the frames, on a second thread.

use std::sync::mpsc::sync_channel;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::source::SourceFrame;

/// Most frames that wait. Chosen: enough to ride over a slow one.
const FRAMES_AHEAD: usize = 8;
/// Most bytes that wait or are used; one frame may always. Chosen: eight frames of 12 megapixels.
const BYTES_AHEAD: usize = 100_000_000;

/// Hands each frame that `next` gives, and how long that took, to `take`, in order. The next ones are decoded meanwhile;
/// the result does not depend on it.
pub fn decode_ahead<P: Send, E>(
    mut next: impl FnMut() -> Option<SourceFrame<P>> + Send,
    bytes: impl Fn(&P) -> usize + Sync,
    mut take: impl FnMut(SourceFrame<P>, Duration) -> Result<(), E>,
) -> Result<(), E> {
    let waiting = Waiting::default();
    let size = |frame: &SourceFrame<P>| frame.picture.as_ref().map_or(0, &bytes);
    std::thread::scope(|scope| {
        let (send, receive) = sync_channel(FRAMES_AHEAD);
        let (waiting, size) = (&waiting, &size);
        scope.spawn(move || {
            // Room is made before a frame is decoded, as much as the one before it took.
            let mut expected = 0;
            while waiting.enter(expected) {
                let began = Instant::now();
                let Some(frame) = next() else { break };
                let took = began.elapsed();
                let bytes = size(&frame);
                waiting.correct(expected, bytes);
                expected = bytes;
                if send.send((frame, took)).is_err() {
                    break;
                }
            }
        });
        let mut done = Ok(());
        for (frame, took) in receive {
            let bytes = size(&frame);
            done = take(frame, took);
            waiting.leave(bytes);
            if done.is_err() {
                break;
            }
        }
        waiting.close();
        done
    })
}

/// The bytes that wait or are used.
#[derive(Debug, Default)]
struct Waiting {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    bytes: usize,
    closed: bool,
}

impl Waiting {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until there is room for a frame; false when nobody takes frames any more.
    fn enter(&self, bytes: usize) -> bool {
        let full = |state: &mut State| !state.closed && state.bytes > 0 && state.bytes + bytes > BYTES_AHEAD;
        let mut state = self.changed.wait_while(self.state(), full).unwrap_or_else(PoisonError::into_inner);
        state.bytes += bytes;
        !state.closed
    }

    /// A frame took other room than was made for it.
    fn correct(&self, expected: usize, bytes: usize) {
        let mut state = self.state();
        state.bytes = state.bytes - expected + bytes;
    }

    fn leave(&self, bytes: usize) {
        self.state().bytes -= bytes;
        self.changed.notify_one();
    }

    fn close(&self) {
        self.state().closed = true;
        self.changed.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    fn frame(number: usize) -> SourceFrame<usize> {
        SourceFrame { file: String::new(), time_s: 0.0, picture: Ok(number) }
    }

    #[test]
    fn frames_come_in_order_and_large_ones_wait_one_at_a_time() {
        let decoded = AtomicUsize::new(0);
        let mut numbers = 0..40;
        let mut taken = vec![];
        let done: Result<(), ()> = decode_ahead(
            || numbers.next().inspect(|_| _ = decoded.fetch_add(1, Ordering::SeqCst)).map(frame),
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
    fn an_error_ends_the_decoding() {
        let done = decode_ahead(|| Some(frame(1)), |_| BYTES_AHEAD, |_, _| Err("enough"));
        assert_eq!(done, Err("enough"));
    }
}
