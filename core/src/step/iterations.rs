//! How many sweeps over all rows a sub-step takes: few, and more while they do not suffice.
//!
//! When the whole net goes taut, few Gauss–Seidel sweeps cannot carry a bullet's pull along ten
//! cables of knots a hundred or a thousand times lighter. What they miss turns up as stretch, that
//! is as energy from nowhere, growing over tens of steps: on the Table 3.2 net (4 sub-steps of 1 ms)
//! it reaches 27 % of the launch energy with 1 sweep, 1 % with 4, 0.1 % with 8, nothing with 12.
//! Twelve sweeps throughout would double the time of a capture, so the energy ledger decides: a
//! step that gains more than a hundred-thousandth of the launch energy doubles the sweeps of the
//! next, one that does not lets them fall by an eighth. On the Cubesat's capture that is 5 sweeps a
//! sub-step on average, and a rise of at most 2e-4 of the launch energy between frames.

/// Energy a step may gain before the next takes more sweeps, over the launch energy.
const TOLERANCE: f64 = 1e-5;

/// The number of sweeps, between its bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SolverIterations {
    least: u32,
    most: u32,
    now: u32,
}

impl SolverIterations {
    /// Starts at `least`; `most` is at least that.
    pub fn new(least: u32, most: u32) -> SolverIterations {
        SolverIterations { least, most: most.max(least), now: least }
    }

    /// SolverIterations for the coming step.
    pub fn now(&self) -> u32 {
        self.now
    }

    /// Hears what energy the last step gained, over the launch energy.
    pub fn adapt(&mut self, gain: f64) {
        self.now = if gain > TOLERANCE {
            (2 * self.now).min(self.most)
        } else {
            (self.now - (self.now / 8).max(1)).max(self.least)
        };
    }
}
