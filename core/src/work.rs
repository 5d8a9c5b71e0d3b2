//! Work done by a run: in counts, which are exact, and in wall time, which is not.

use std::time::{Duration, Instant};

/// Work done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Work {
    /// Steps.
    pub steps: u64,
    /// Sub-steps.
    pub substeps: u64,
    /// Times the engine looked for contacts.
    pub detections: u64,
    /// Contacts, summed over the steps.
    pub contacts: u64,
    /// Cable rows given to the engine, summed over the steps.
    pub cable_rows: u64,
    /// Cables that snapped within a step.
    pub snaps: u64,
    /// SolverIterations over all rows, summed over the sub-steps.
    pub sweeps: u64,
    /// Wall time of the stages.
    pub stages: Stages,
    /// Wall time of each effect, in the order of the list.
    pub effects: Vec<Duration>,
}

/// Wall time by stage of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stages {
    /// Cables outside the engine: snaps, rest, tension; the explicit net.
    pub cables: Duration,
    /// The engine's step: detection, contact and cable rows, motion.
    pub world: Duration,
    /// Contacts outside the engine's step: detection, response, reading.
    pub contact: Duration,
    /// Energy ledger.
    pub observe: Duration,
}

/// Wall time from lap to lap.
pub struct Clock(Instant);

impl Clock {
    /// Starts now.
    pub fn start() -> Self {
        Clock(Instant::now())
    }

    /// Adds the time since the last lap to `total`.
    pub fn lap(&mut self, total: &mut Duration) {
        let now = Instant::now();
        *total += now - self.0;
        self.0 = now;
    }
}
