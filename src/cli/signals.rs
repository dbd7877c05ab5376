//! SIGINT and SIGTERM end the program as they always do, and leave nothing unfinished behind.

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

/// Waits if the program is being ended: what goes wrong because of that is no error to tell.
pub fn wait_if_ending() {
    unfinished::undisturbed(|| ());
}
