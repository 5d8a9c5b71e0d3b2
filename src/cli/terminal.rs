//! What the program says while it works: a bar on a terminal, a line now and then where there is none, with `--verbose`
//! how long each stage took, with `--quiet` nothing.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use tumblenet::problems::Problems;

use super::reading::time;
use super::tell;

/// Name of the variable that says how often a line of progress is told where there is no terminal.
const EVERY: &str = "TUMBLENET_PROGRESS";

/// How often it is where that does not say.
const USUALLY: Duration = Duration::from_secs(10);

/// What every command takes.
#[derive(Args)]
pub struct Common {
    /// Says nothing but what goes wrong, and what is asked for as JSON.
    #[arg(long, short, global = true, conflicts_with = "verbose", help_heading = "Everywhere")]
    quiet: bool,
    /// Says how long each stage took.
    #[arg(long, short, global = true, help_heading = "Everywhere")]
    verbose: bool,
    /// Most threads that run at once; left out: one a processor. The results are the same.
    #[arg(long, global = true, value_name = "N", help_heading = "Everywhere",
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
}

static QUIET: AtomicBool = AtomicBool::new(false);
static VERBOSE: AtomicBool = AtomicBool::new(false);

/// The stage that is on, and since when.
static STAGE: Mutex<Option<(&str, Instant)>> = Mutex::new(None);

impl Common {
    /// From now on all is as the user wants it.
    ///
    /// # Errors
    /// So many threads cannot be had.
    pub fn take_effect(&self) -> Result<(), Problems> {
        QUIET.store(self.quiet, Ordering::Relaxed);
        VERBOSE.store(self.verbose, Ordering::Relaxed);
        let Some(jobs) = self.jobs else { return Ok(()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs.into()).build_global();
        pool.map_err(|error| {
            let mut problems = Problems::new("--jobs");
            problems.add("", format!("{jobs} ({error})"), "as many threads as the system gives");
            problems
        })
    }
}

/// Whether the user wants to hear nothing but faults.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Whether the user wants to hear how long everything took.
pub fn is_verbose() -> bool {
    VERBOSE.load(Ordering::Relaxed)
}

/// Tells `text` on standard error to who wants to hear it.
pub fn remark(text: &str) {
    if !is_quiet() {
        tell(text);
    }
}

/// The stage called `name` begins, and the one before has ended.
pub fn stage(name: &'static str) {
    let before = STAGE.lock().unwrap_or_else(PoisonError::into_inner).replace((name, Instant::now()));
    tell_stage(before);
}

/// The last stage has ended.
pub fn last_stage_ended() {
    let last = STAGE.lock().unwrap_or_else(PoisonError::into_inner).take();
    tell_stage(last);
}

fn tell_stage(stage: Option<(&str, Instant)>) {
    if let Some((name, since)) = stage.filter(|_| is_verbose()) {
        tell(&format!("{name}: {:.3} s", since.elapsed().as_secs_f64()));
    }
}

/// How far a piece of long work is.
pub struct Progress {
    bar: ProgressBar,
    /// Ends the thread that tells lines, when it is dropped.
    _lines: Option<Sender<()>>,
}

impl Progress {
    /// Of `length` pieces none is done of what is called `name`.
    pub fn new(length: u64, name: &str) -> Progress {
        let is_shown = std::io::stderr().is_terminal();
        let bar = if is_shown && !is_quiet() { ProgressBar::new(length) } else { ProgressBar::hidden() };
        bar.set_length(length);
        let bar = bar.with_message(name.to_owned());
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent} % {eta} left") {
            bar.set_style(style);
        }
        if is_shown {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        let every = std::env::var(EVERY).ok().and_then(|text| time(&text).ok()).unwrap_or(USUALLY);
        let tells = !is_shown && !is_quiet() && !every.is_zero();
        let lines = tells.then(|| tell_lines(bar.clone(), every));
        Progress { bar, _lines: lines }
    }

    /// So many pieces are done.
    pub fn set(&self, done: u64) {
        self.bar.set_position(done);
    }

    /// One more piece is done.
    pub fn one_more(&self) {
        self.bar.inc(1);
    }

    /// What is being done.
    pub fn name(&self, name: String) {
        self.bar.set_message(name);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Tells a line every so often, until what is returned is dropped.
fn tell_lines(bar: ProgressBar, every: Duration) -> Sender<()> {
    let (sender, ended) = mpsc::channel();
    let since = Instant::now();
    thread::spawn(move || {
        while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(every) {
            let (done, length) = (bar.position(), bar.length().unwrap_or(0));
            tell(&line(&bar.message(), done, length, since.elapsed()));
        }
    });
    sender
}

/// `cubesat-free: 40 %, 20 s so far, 30 s to go`.
fn line(name: &str, done: u64, length: u64, so_far: Duration) -> String {
    let seconds = so_far.as_secs_f64();
    let share = done as f64 / length.max(1) as f64;
    let to_go = match share {
        share if share > 0.0 => format!(", {:.0} s to go", seconds / share - seconds),
        _ => String::new(),
    };
    format!("{name}: {:.0} %, {seconds:.0} s so far{to_go}", 100.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_how_far_and_how_long() {
        let line = |done| line("scene", done, 50, Duration::from_secs(20));
        assert_eq!(line(20), "scene: 40 %, 20 s so far, 30 s to go");
        assert_eq!(line(0), "scene: 0 %, 20 s so far");
    }
}
