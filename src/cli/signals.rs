//! SIGINT and SIGTERM end the program as they always do, and leave nothing unfinished behind; what runs live is told to end.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seamtrack::output::unfinished;

/// From now on, what is unfinished is removed when the program is told to end.
pub fn end_without_leftovers() {
    #[cfg(unix)]
    if let Ok(mut signals) =
        signal_hook::iterator::Signals::new([signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM])
    {
        std::thread::spawn(move || {
            if let Some(signal) = signals.forever().next() {
                let _nothing_more = unfinished::remove_all();
                super::say::tell("ended before it was done; results that were complete stay");
                // The status that a shell expects: 130 or 143. The line after it is for a signal that does not end us.
                let _ = signal_hook::low_level::emulate_default_handler(signal);
                std::process::exit(128 + signal);
            }
        });
    }
}

/// A flag that is set when the program is told to end.
///
/// # Errors
/// When the system does not let signals be handled.
pub fn asked_to_end() -> std::io::Result<Arc<AtomicBool>> {
    let asked = Arc::new(AtomicBool::new(false));
    #[cfg(unix)]
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&asked))?;
    }
    Ok(asked)
}

/// Waits if the program is being ended: what goes wrong because of that is no error to tell.
pub fn wait_if_ending() {
    unfinished::undisturbed(|| ());
}
