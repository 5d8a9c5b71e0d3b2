//! A run that cannot go on: what is not a number, when, and after which stage.

use crate::state::State;

/// A run that cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// A knot's position or velocity is not a number.
    #[error("at {time:.6} s knot {knot} is not a number after stage `{stage}`")]
    Knot {
        /// Simulated time [s].
        time: f64,
        /// The knot.
        knot: usize,
        /// The stage after which it was found.
        stage: &'static str,
    },
    /// Pose or motion of the target or the chaser is not a number.
    #[error("at {time:.6} s the target or the chaser is not a number after stage `{stage}`")]
    Target {
        /// Simulated time [s].
        time: f64,
        /// The stage after which it was found.
        stage: &'static str,
    },
    /// Steps were cut into ever more parts.
    #[error(
        "at {time:.6} s a step is cut into {parts:.0} parts on average, of at most {most} (--limit cuts=N raises it): \
         the method does not get on; softer cables, heavier knots, a shorter step or a wider tolerance do"
    )]
    Cuts {
        /// Simulated time [s].
        time: f64,
        /// Parts a step, on average over the run so far.
        parts: f64,
        /// The most there may be.
        most: u64,
    },
    /// The engine set a body aside.
    #[error("at {time:.6} s the engine set a body aside whose state is not a number (stage `world`)")]
    Quarantine {
        /// Simulated time [s].
        time: f64,
    },
}

/// Counts the parts that steps are cut into, which nobody foresees: a run that goes on for ever ends.
#[derive(Clone, Copy, Debug)]
pub struct Cuts {
    most: u64,
    steps: u64,
    parts: u64,
}

/// Parts that a run may take before they are held against it: a shot takes some hundred at once.
const GRACE: u64 = 10_000;

impl Cuts {
    /// At most `most` parts a step, on average over the run so far.
    pub fn new(most: u64) -> Cuts {
        Cuts { most, steps: 0, parts: 0 }
    }

    /// A step begins; how many parts it may be cut into.
    pub fn begin(&mut self) -> u64 {
        self.steps += 1;
        self.left()
    }

    fn left(&self) -> u64 {
        self.most.saturating_mul(self.steps).saturating_add(GRACE).saturating_sub(self.parts)
    }

    /// Hears of parts that were taken at `time` [s].
    ///
    /// # Errors
    /// There were too many.
    pub fn count(&mut self, parts: u64, time: f64) -> Result<(), Failure> {
        if parts > self.left() {
            let parts = (self.parts + parts) as f64 / self.steps.max(1) as f64;
            return Err(Failure::Cuts { time, parts, most: self.most });
        }
        self.parts += parts;
        Ok(())
    }
}

/// Checks `state` after `stage`.
///
/// # Errors
/// The first thing in it that is not a number.
pub fn check(state: &State, stage: &'static str) -> Result<(), Failure> {
    let time = state.time;
    if let Some(knot) = state.first_bad_knot() {
        return Err(Failure::Knot { time, knot, stage });
    }
    if !state.bodies_are_sound() {
        return Err(Failure::Target { time, stage });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_are_cut_without_end_end_the_run_in_words() {
        let mut cuts = Cuts::new(10);
        let mut ended = None;
        for step in 0..10_000 {
            let left = cuts.begin();
            assert!(left > 0);
            if let Err(failure) = cuts.count(20, 1e-3 * f64::from(step)) {
                ended = Some((step, failure.to_string()));
                break;
            }
        }
        // 20 of 10 a step, beside the first ten thousand.
        let (step, told) = ended.unwrap();
        assert_eq!(step, 1000);
        assert!(
            told.contains("cut into 20 parts on average, of at most 10 (--limit cuts=N raises it)"),
            "{told}"
        );
        let mut enough = Cuts::new(20);
        for _ in 0..10_000 {
            enough.begin();
            enough.count(20, 0.0).unwrap();
        }
    }
}
