//! A run that cannot go on: what is not a number or has left all bounds, when, and after which stage.

use std::fmt;

use nalgebra::Vector3;

use crate::state::State;

/// What of the state a failure is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Culprit {
    /// A knot.
    Knot(usize),
    /// The body of this name.
    Body(String),
}

impl fmt::Display for Culprit {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Culprit::Knot(knot) => write!(to, "knot {knot}"),
            Culprit::Body(name) => write!(to, "the {name}"),
        }
    }
}

/// A run that cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// Place or motion of a knot or a body is not a number.
    #[error("at {time:.6} s {culprit} is not a number after stage `{stage}`")]
    NotANumber {
        /// Simulated time [s].
        time: f64,
        /// What it is.
        culprit: Culprit,
        /// The stage after which it was found.
        stage: &'static str,
    },
    /// The method has no answer to what it is given.
    #[error("{what} in a run whose method has no answer to it")]
    Refused {
        /// What it is given.
        what: &'static str,
    },
    /// Two effects or two bodies cannot be told apart.
    #[error(
        "two {what} of this run are called {name:?}, which only one may be: the second is to have another name"
    )]
    NamedTwice {
        /// What they are.
        what: &'static str,
        /// What both are called.
        name: String,
    },
    /// The equations of an implicit step were not solved, however short.
    #[error("at {time:.6} s an implicit step of {step:.3e} s is not solved, and no part of it")]
    Implicit {
        /// Simulated time [s].
        time: f64,
        /// The step [s].
        step: f64,
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
    /// A knot or a body has left all bounds.
    #[error(
        "at {time:.6} s {culprit} has {what} {value:.3e}, at most {allowed:e} is allowed (stage `{stage}`): the method has failed, a smaller solver.step_s may help"
    )]
    Bound {
        /// Simulated time [s].
        time: f64,
        /// What has left them.
        culprit: Culprit,
        /// What is too large, with its unit.
        what: &'static str,
        /// Its size.
        value: f64,
        /// Its bound.
        allowed: f64,
        /// The stage after which it was found.
        stage: &'static str,
    },
    /// The method made too much energy.
    #[error(
        "at {time:.6} s the method has created {created:.3e} of the energy at the start and the work put in, at most {allowed} is allowed; knot {knot} is the fastest (stage `{stage}`): a smaller solver.step_s may help"
    )]
    Energy {
        /// Simulated time [s].
        time: f64,
        /// The fastest knot.
        knot: usize,
        /// Energy created [-].
        created: f64,
        /// Its bound.
        allowed: f64,
        /// The stage after which it was found.
        stage: &'static str,
    },
    /// The engine set a body aside.
    #[error("at {time:.6} s the engine set a body aside whose state is not a number (stage `world`)")]
    Quarantine {
        /// Simulated time [s].
        time: f64,
    },
    /// Who heard of its progress ended it.
    #[error("interrupted at {time:.6} s")]
    Interrupted {
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

/// Fastest that a knot or a body may be [m/s]: a hundred times what any scene is shot with.
const SPEED: f64 = 1e5;

/// Farthest that one may be from the origin [m].
const DISTANCE: f64 = 1e8;

/// Largest strain of a cable [-]: rubber bears 10.
const STRAIN: f64 = 100.0;

/// Energy that the method may have created, over the energy at the start and the work put in [-]: known failures of
/// hard cases make some thousands, and are to be seen to their end.
const CREATED: f64 = 1e6;

/// Checks at the end of a step that speeds, distances, the largest strain (`strained`, with its knot) and
/// `created` energy (over its scale) are within bounds that no sound run comes near.
///
/// # Errors
/// The first that is not.
pub fn check_bounds(state: &State, strained: (f64, usize), created: f64) -> Result<(), Failure> {
    let (time, stage) = (state.time, "step");
    let bound =
        |culprit, (what, value, allowed)| Failure::Bound { time, culprit, what, value, allowed, stage };
    for (knot, (position, velocity)) in state.knots.position.iter().zip(&state.knots.velocity).enumerate() {
        if let Some(found) = beyond(position, velocity) {
            return Err(bound(Culprit::Knot(knot), found));
        }
    }
    for (model, body) in state.each_body() {
        if let Some(found) = beyond(&body.position, &body.velocity) {
            return Err(bound(Culprit::Body(model.name.clone()), found));
        }
    }
    let (value, knot) = strained;
    if value > STRAIN {
        return Err(bound(Culprit::Knot(knot), ("a cable of strain", value, STRAIN)));
    }
    if created > CREATED {
        let speeds = state.knots.velocity.iter().map(|v| v.norm_squared()).enumerate();
        let knot = speeds.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(knot, _)| knot);
        return Err(Failure::Energy { time, knot, created, allowed: CREATED, stage });
    }
    Ok(())
}

/// What of a place and a velocity is out of bounds, if anything is: its name, its size and its bound.
fn beyond(position: &Vector3<f64>, velocity: &Vector3<f64>) -> Option<(&'static str, f64, f64)> {
    if velocity.norm_squared() > SPEED * SPEED {
        return Some(("the speed [m/s]", velocity.norm(), SPEED));
    }
    let is_far = position.norm_squared() > DISTANCE * DISTANCE;
    is_far.then(|| ("the distance from the origin [m]", position.norm(), DISTANCE))
}

/// Checks `state` after `stage`.
///
/// # Errors
/// The first thing in it that is not a number.
pub fn check(state: &State, stage: &'static str) -> Result<(), Failure> {
    let time = state.time;
    if let Some(knot) = state.first_bad_knot() {
        return Err(Failure::NotANumber { time, culprit: Culprit::Knot(knot), stage });
    }
    for (model, body) in state.each_body() {
        if !body.is_sound() {
            return Err(Failure::NotANumber { time, culprit: Culprit::Body(model.name.clone()), stage });
        }
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
