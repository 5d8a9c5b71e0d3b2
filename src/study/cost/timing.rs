//! What a run costs: processor time of its thread, which other programs on the machine do not lengthen
//! as they do wall time.

use cpu_time::ThreadTime;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::failure::Failure;
use crate::run::Run;
use crate::study::ensemble::Quartiles;

/// Runs `case` on this thread; the run, and its processor time [s].
///
/// Building the simulation counts, its metrics and files do not.
pub fn timed(case: &Case) -> (Result<Run, Failure>, f64) {
    let clock = ThreadTime::now();
    let run = Run::of(case, |_| {});
    (run, clock.elapsed().as_secs_f64())
}

/// Processor time per simulated second over repeats.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Cost {
    /// Median [s/s].
    pub median: f64,
    /// Least [s/s].
    pub least: f64,
    /// Largest [s/s].
    pub most: f64,
    /// Runs.
    pub repeats: usize,
}

impl Cost {
    /// That of `times` [s/s]; nothing without any.
    pub fn of(times: Vec<f64>) -> Option<Cost> {
        (!times.is_empty()).then(|| {
            let Quartiles { min, median, max, count, .. } = Quartiles::of(times);
            Cost { median, least: min, most: max, repeats: count }
        })
    }
}
