//! A run that goes on until its verdict is decided.

use crate::case::Case;
use crate::failure::Failure;
use crate::limits::Limit;
use crate::metrics::capture::Curves;
use crate::metrics::verdict::Capture;
use crate::problems::Problems;
use crate::run::{Frames, Heard, Run};

/// How many times the scene's duration a run goes on for where nobody says how long.
pub const TIMES: f64 = 10.0;

/// Adds to `place` why `case` cannot run on for `at_most` [s].
pub fn check(case: &Case, at_most: f64, place: &str, problems: &mut Problems) {
    if case.target().is_none() {
        problems.add(place, "a scene without a target", "a scene with a target");
    }
    let steps = at_most / case.time_step().step * f64::from(case.time_step().substeps);
    if case.limits().exceeded(Limit::Steps, steps) {
        problems.add(place, format!("{at_most} s, {steps:.3e} steps"), case.limits().allowed(Limit::Steps));
    }
}

/// Runs `case` to its end, or with `at_most` [s] on until the verdict is decided; returns its curves too.
///
/// # Errors
/// A state that is not a number; `progress` ended it.
pub fn run<H: Heard>(
    case: &Case,
    at_most: Option<f64>,
    progress: impl FnMut(f64) -> H,
) -> Result<(Run, Curves), Failure> {
    let mut curves = Curves::default();
    let Some(at_most) = at_most else {
        let run = Run::of(case, progress)?;
        curves.extend(case, &run.frames);
        return Ok((run, curves));
    };
    let run = Run::until(case, at_most, |frames, met| is_decided(case, frames, met, &mut curves), progress)?;
    curves.extend(case, &run.frames);
    Ok((run, curves))
}

/// Whether the verdict on `frames` of a run under way, in which net and target have `met` or not, is decided; `curves` are
/// brought up to them.
pub fn is_decided(case: &Case, frames: &Frames, met: bool, curves: &mut Curves) -> bool {
    curves.extend(case, frames);
    let capture = Capture::of(case, met, &frames.time, curves);
    capture.is_none_or(|capture| capture.is_decided(case, &frames.time, curves))
}
