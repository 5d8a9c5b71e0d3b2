//! A program that is interrupted, or whose time is over, says what it leaves behind, and leaves nothing half-written.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use tumblenet::report::files;

use super::tell;

/// Exit status of an interrupted program: 128 and the number of the signal that the keyboard sends.
const STATUS: i32 = 130;

static LEFT_BEHIND: Mutex<String> = Mutex::new(String::new());

/// What is to be saved before the program ends.
static UNSAVED: Mutex<Option<Box<dyn FnOnce() + Send>>> = Mutex::new(None);

/// From now on a signal to end (the keyboard's, or another program's) ends the program once the
/// file that is being written is whole, and says what [`leaves`] told.
pub fn listen() {
    let handler = || {
        save();
        // Held until the program is gone: nothing begins to be written any more.
        let _idle = files::when_idle();
        end("interrupted", STATUS)
    };
    // Where there is no way to listen, the system ends the program as it would any other.
    ctrlc::set_handler(handler).ok();
}

/// Ends the program in the same way, with status 1, when it has run for `limit`.
pub fn after(limit: Duration) {
    let over = move || {
        save();
        let _idle = files::when_idle();
        end(&format!("error: the time limit of {} s is over", limit.as_secs_f64()), 1)
    };
    if limit.is_zero() {
        over();
    }
    // A limit that the clock cannot count is none.
    std::thread::spawn(move || {
        std::thread::sleep(limit);
        over()
    });
}

/// From now on `save` is called before the program ends in such a way.
pub fn saves(save: impl FnOnce() + Send + 'static) {
    *UNSAVED.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(save));
}

fn save() {
    let unsaved = UNSAVED.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(save) = unsaved {
        save();
    }
}

fn end(why: &str, status: i32) -> ! {
    let words = LEFT_BEHIND.lock().unwrap_or_else(PoisonError::into_inner);
    tell(&format!("{why}{}{words}", if words.is_empty() { "" } else { ": " }));
    std::process::exit(status);
}

/// What is left behind from now on, if the program is interrupted.
pub fn leaves(words: impl Into<String>) {
    *LEFT_BEHIND.lock().unwrap_or_else(PoisonError::into_inner) = words.into();
}
