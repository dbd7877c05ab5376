//! Decoding ahead of whoever uses the frames, on threads of its own.

use std::num::NonZero;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::source::{NextFrame, SourceFrame};

/// Most frames that wait. Chosen: enough to ride over a slow one.
const FRAMES_AHEAD: usize = 8;
/// Most bytes that wait or are used; one frame may always. Chosen: eight frames of 12 megapixels.
const BYTES_AHEAD: usize = 100_000_000;

/// Hands each frame that `next` gives, and how long decoding it took, to `take`, in order. The next ones are decoded meanwhile, on as
/// many threads as [`decoders`] says; the result does not depend on it.
pub fn decode_ahead<P: Send, E>(
    mut next: impl FnMut() -> Option<NextFrame<P>> + Send,
    bytes: impl Fn(&P) -> usize + Sync,
    mut take: impl FnMut(SourceFrame<P>, Duration) -> Result<(), E>,
) -> Result<(), E> {
    let waiting = Waiting::default();
    let size = |frame: &SourceFrame<P>| frame.picture.as_ref().map_or(0, &bytes);
    std::thread::scope(|scope| {
        let (waiting, size) = (&waiting, &size);
        let (give, tasks) = sync_channel::<(Box<dyn FnOnce() -> SourceFrame<P> + Send>, Promise<P>)>(FRAMES_AHEAD);
        let tasks = Arc::new(Mutex::new(tasks));
        let decoded = move |frame: SourceFrame<P>, began: Instant, promise: &Promise<P>| {
            let took = began.elapsed();
            waiting.came(size(&frame));
            // Who no longer waits for it has had enough.
            let _ = promise.send((frame, took));
        };
        for _ in 0..decoders() {
            let tasks = Arc::clone(&tasks);
            scope.spawn(move || {
                let next_task = || tasks.lock().unwrap_or_else(PoisonError::into_inner).recv();
                while let Ok((task, promise)) = next_task() {
                    let began = Instant::now();
                    decoded(task(), began, &promise);
                }
            });
        }
        let (send, receive) = sync_channel(FRAMES_AHEAD);
        scope.spawn(move || {
            while waiting.enter() {
                let began = Instant::now();
                let Some(frame) = next() else { break };
                let (promise, promised) = sync_channel(1);
                match frame {
                    NextFrame::Decoded(frame) => decoded(frame, began, &promise),
                    NextFrame::Encoded(task) => {
                        if give.send((task, promise)).is_err() {
                            break;
                        }
                    }
                }
                if send.send(promised).is_err() {
                    break;
                }
            }
        });
        let mut done = Ok(());
        for promised in receive {
            let Ok((frame, took)) = promised.recv() else { break };
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

/// Where a decoded frame goes, with the time that it took.
type Promise<P> = SyncSender<(SourceFrame<P>, Duration)>;

/// Threads that decode: as many as there are processors, but one where the recording is one of a batch, which has its own.
fn decoders() -> usize {
    let is_one_of_many = rayon::current_thread_index().is_some();
    if is_one_of_many { 1 } else { std::thread::available_parallelism().map_or(1, NonZero::get) }
}

/// The bytes that wait or are used.
#[derive(Debug, Default)]
struct Waiting {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    /// Bytes of the frames that are decoded and not yet done with.
    bytes: usize,
    /// Frames that are being decoded, and the bytes of the largest so far, which each may have.
    under_way: usize,
    largest: Option<usize>,
    closed: bool,
}

impl State {
    /// Whether there is no room for another frame. The first one goes alone: it tells how large they are.
    fn is_full(&self) -> bool {
        match self.largest {
            None => self.under_way > 0,
            Some(largest) => {
                let held = self.bytes + self.under_way * largest;
                held > 0 && held + largest > BYTES_AHEAD
            }
        }
    }
}

impl Waiting {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until there is room for a frame; false when nobody takes frames any more.
    fn enter(&self) -> bool {
        let full = |state: &mut State| !state.closed && state.is_full();
        let mut state = self.changed.wait_while(self.state(), full).unwrap_or_else(PoisonError::into_inner);
        state.under_way += 1;
        !state.closed
    }

    /// A frame was decoded.
    fn came(&self, bytes: usize) {
        let mut state = self.state();
        state.under_way = state.under_way.saturating_sub(1);
        state.bytes += bytes;
        state.largest = Some(bytes.max(state.largest.unwrap_or(0)));
        drop(state);
        self.changed.notify_one();
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
    fn an_error_ends_the_decoding() {
        let done = decode_ahead(|| Some(NextFrame::Decoded(frame(1))), |_| BYTES_AHEAD, |_, _| Err("enough"));
        assert_eq!(done, Err("enough"));
    }
}
