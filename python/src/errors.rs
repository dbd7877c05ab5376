//! The library's errors as Python's exceptions, in the program's words.

use std::error::Error;
use std::io;

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

/// An `OSError` (`FileNotFoundError` and the like) where the system is the cause, else a `ValueError`.
pub fn raised(error: &(dyn Error + 'static)) -> PyErr {
    let causes = || std::iter::successors(Some(error), |error| (**error).source());
    let text = one_line(error);
    match causes().find_map(|cause| cause.downcast_ref::<io::Error>()).and_then(io::Error::raw_os_error) {
        Some(_) if is_missing(causes()) => io::Error::new(io::ErrorKind::NotFound, text).into(),
        Some(_) => io::Error::other(text).into(),
        None => PyValueError::new_err(text),
    }
}

fn is_missing<'a>(mut causes: impl Iterator<Item = &'a (dyn Error + 'static)>) -> bool {
    causes.any(|cause| cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::NotFound))
}

/// An error and its causes, none said twice.
pub fn one_line(error: &(dyn Error + 'static)) -> String {
    std::iter::successors(error.source(), |error| (**error).source()).fold(error.to_string(), |text, cause| {
        let cause = cause.to_string();
        if text.contains(&cause) { text } else { format!("{text}: {cause}") }
    })
}
