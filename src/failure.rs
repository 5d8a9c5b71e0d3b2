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
    /// The engine set a body aside.
    #[error("at {time:.6} s the engine set a body aside whose state is not a number (stage `world`)")]
    Quarantine {
        /// Simulated time [s].
        time: f64,
    },
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
