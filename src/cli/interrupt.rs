//! An interrupted program says what it leaves behind, and leaves nothing half-written.

use std::sync::{Mutex, PoisonError};

use tumblenet::report::files;

/// Exit status of an interrupted program: 128 and the number of the signal that the keyboard sends.
const STATUS: i32 = 130;

static LEFT_BEHIND: Mutex<String> = Mutex::new(String::new());

/// From now on a signal to end (the keyboard's, or another program's) ends the program once the
/// file that is being written is whole, and says what [`leaves`] told.
pub fn listen() {
    let handler = || {
        // Held until the program is gone: nothing begins to be written any more.
        let _idle = files::when_idle();
        let words = LEFT_BEHIND.lock().unwrap_or_else(PoisonError::into_inner);
        eprintln!("interrupted{}{words}", if words.is_empty() { "" } else { ": " });
        std::process::exit(STATUS);
    };
    // Where there is no way to listen, the system ends the program as it would any other.
    ctrlc::set_handler(handler).ok();
}

/// What is left behind from now on, if the program is interrupted.
pub fn leaves(words: impl Into<String>) {
    *LEFT_BEHIND.lock().unwrap_or_else(PoisonError::into_inner) = words.into();
}
