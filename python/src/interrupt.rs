//! Long work without the interpreter's lock, which Ctrl-C ends.

use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

/// How long Ctrl-C waits to be heard.
pub const LOOK: Duration = Duration::from_millis(50);

/// Tells work under way to end.
#[derive(Default)]
pub struct Stop(AtomicBool);

impl Stop {
    /// Whether the work goes on.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.0.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Does `work` beside the interpreter. A signal that raises (Ctrl-C) stops it; what it made is then dropped.
pub fn beside<T: Send>(py: Python<'_>, work: impl FnOnce(&Stop) -> T + Send) -> PyResult<T> {
    let stop = Stop::default();
    py.detach(|| {
        thread::scope(|scope| {
            let (ended, waiting) = mpsc::channel::<()>();
            let stop = &stop;
            let worker = scope.spawn(move || {
                let _ended_when_dropped = ended;
                work(stop)
            });
            let mut signals = Ok(());
            while let Err(RecvTimeoutError::Timeout) = waiting.recv_timeout(LOOK) {
                if signals.is_ok() {
                    signals = Python::attach(|py| py.check_signals());
                    stop.0.store(signals.is_err(), Ordering::Relaxed);
                }
            }
            let done = worker.join().unwrap_or_else(|panic| resume_unwind(panic));
            signals.map(|()| done)
        })
    })
}
