//! What a run costs: processor time of its thread, which other programs on the machine do not lengthen
//! as they do wall time.

use cpu_time::ThreadTime;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::failure::Failure;
use crate::run::{Recorder, Run};
use crate::simulation::Simulation;
use crate::study::ensemble::Quartiles;
use crate::work::Work;

/// Runs `case` on this thread; the run, and its processor time [s].
///
/// Building the simulation counts, its metrics and files do not.
pub fn timed(case: &Case) -> (Result<Run, Failure>, f64) {
    clocked(|| Run::of(case, |_| {}))
}

/// The same while what it counted is `covered`, as it is asked at every frame; and whether it went to its end.
pub fn timed_while(case: &Case, covered: impl Fn(&Work) -> bool) -> (Result<(Run, bool), Failure>, f64) {
    clocked(|| while_covered(case, covered))
}

fn clocked<T>(act: impl FnOnce() -> T) -> (T, f64) {
    let clock = ThreadTime::now();
    let done = act();
    (done, clock.elapsed().as_secs_f64())
}

fn while_covered(case: &Case, covered: impl Fn(&Work) -> bool) -> Result<(Run, bool), Failure> {
    let mut simulation = Simulation::new(case);
    let mut recorder = Recorder::start(case, &mut simulation, case.scene().duration_s.0);
    let mut goes_on = true;
    while goes_on && !recorder.is_full() {
        simulation.step()?;
        goes_on = !recorder.record(case, &mut simulation) || covered(&simulation.work);
    }
    let is_whole = recorder.is_full();
    Ok((recorder.finish(case, &mut simulation), is_whole))
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
