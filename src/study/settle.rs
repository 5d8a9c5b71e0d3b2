//! A run that goes on until its verdict is decided.

use crate::case::Case;
use crate::failure::Failure;
use crate::metrics::capture::Curves;
use crate::metrics::verdict::Capture;
use crate::run::Run;

/// How many times the scene's duration a run goes on for where nobody says how long.
pub const TIMES: f64 = 10.0;

/// Runs `case` to its end, or with `at_most` [s] on until the verdict is decided; returns its curves too.
///
/// # Errors
/// A state that is not a number.
pub fn run(case: &Case, at_most: Option<f64>, progress: impl FnMut(f64)) -> Result<(Run, Curves), Failure> {
    let mut curves = Curves::default();
    let Some(at_most) = at_most else {
        let run = Run::of(case, progress)?;
        curves.extend(case, &run.frames);
        return Ok((run, curves));
    };
    let run = Run::until(
        case,
        at_most,
        |frames, met| {
            curves.extend(case, frames);
            Capture::of(case, met, &frames.time, &curves)
                .is_none_or(|capture| capture.is_decided(case, &frames.time, &curves))
        },
        progress,
    )?;
    curves.extend(case, &run.frames);
    Ok((run, curves))
}
