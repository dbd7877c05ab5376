//! The newest of what one thread makes and another takes.

use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Holds one value: a newer one takes the place of one that nobody has fetched. So who takes is never behind by more than one.
#[derive(Debug)]
pub struct Slot<T> {
    inner: Mutex<Inner<T>>,
    changed: Condvar,
}

#[derive(Debug)]
struct Inner<T> {
    newest: Option<T>,
    passed_over: u64,
    is_closed: bool,
}

/// What a slot gave.
#[derive(Debug, PartialEq, Eq)]
pub enum Fetched<T> {
    /// The newest value.
    Newest(T),
    /// None came in time.
    Nothing,
    /// None will come.
    Closed,
}

impl<T> Default for Slot<T> {
    fn default() -> Self {
        Self { inner: Mutex::new(Inner { newest: None, passed_over: 0, is_closed: false }), changed: Condvar::new() }
    }
}

impl<T> Slot<T> {
    /// Puts a value; what was not fetched is passed over.
    pub fn put(&self, value: T) {
        let mut inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        inner.passed_over += u64::from(inner.newest.replace(value).is_some());
        drop(inner);
        self.changed.notify_one();
    }

    /// Says that no value will come.
    pub fn close(&self) {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner).is_closed = true;
        self.changed.notify_all();
    }

    /// Waits for the newest value.
    pub fn fetch(&self, wait: Duration) -> Fetched<T> {
        let inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        let is_waiting = |inner: &mut Inner<T>| inner.newest.is_none() && !inner.is_closed;
        let waited = self.changed.wait_timeout_while(inner, wait, is_waiting);
        let (mut inner, _) = waited.unwrap_or_else(PoisonError::into_inner);
        match inner.newest.take() {
            Some(newest) => Fetched::Newest(newest),
            None if inner.is_closed => Fetched::Closed,
            None => Fetched::Nothing,
        }
    }

    /// Values that nobody fetched in time.
    pub fn passed_over(&self) -> u64 {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner).passed_over
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_newest_is_fetched_and_the_last_also_after_the_end() {
        let slot = Slot::default();
        (0..3).for_each(|value| slot.put(value));
        assert_eq!((slot.fetch(Duration::ZERO), slot.passed_over()), (Fetched::Newest(2), 2));
        assert_eq!(slot.fetch(Duration::ZERO), Fetched::Nothing);
        slot.put(3);
        slot.close();
        assert_eq!((slot.fetch(Duration::ZERO), slot.fetch(Duration::ZERO)), (Fetched::Newest(3), Fetched::Closed));
    }
}
