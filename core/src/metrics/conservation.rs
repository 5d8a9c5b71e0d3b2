//! What must be kept, and how well it was.
//!
//! Residuals are relative to the scene's own scale and account for what effects, a held target and
//! a driven target put in or took out.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::run::Run;

/// Conservation residuals of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Conservation {
    /// Largest change of linear momentum that nothing outside explains, over the launch momentum [-].
    pub momentum_residual: f64,
    /// The same of the angular momentum about the origin, over what the target had at the start plus
    /// launch momentum times the distance to the target (or the net's half diagonal) [-].
    pub angular_momentum_residual: f64,
    /// Energy in no row of the ledger: in flight what the method made or destroyed against the cables' own law; over the launch energy [-].
    pub energy_residual: f64,
    /// What the method took beyond what cables take by their law; over the launch energy [-]. Under joints what rows of the engine took by
    /// being solved implicitly, at least. Under others what is missing once contacts or threads have acted, below zero what is too much;
    /// absent before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_taken_by_solver: Option<f64>,
    /// Largest rise of all energy above any earlier minimum, looked at after every step, less the work from
    /// outside; over the launch energy and the work put in, by fields on the net too [-].
    pub energy_created: f64,
    /// Kinetic, elastic and stored energy at the start [J].
    pub energy_start_j: f64,
    /// The same at the end [J].
    pub energy_end_j: f64,
}

/// Energy created from which a run is not to be believed [-].
pub const CREATED: f64 = 1e-2;

/// Its name among the numbers of a summary.
pub const SCALAR: &str = "conservation.energy_created";

/// Whether so much `created` energy [-] is not to be believed.
pub fn is_too_much(created: f64) -> bool {
    created.is_nan() || created > CREATED
}

impl Conservation {
    /// Whether the method created so much energy that the run is not to be believed.
    pub fn is_broken(&self) -> bool {
        is_too_much(self.energy_created)
    }

    /// The residuals of `run`.
    pub fn of(case: &Case, run: &Run) -> Conservation {
        let frames = &run.frames;
        let last = frames.time.len() - 1;
        let momentum_scale = case.net().launch_momentum().norm();
        let arm = case.target().map_or(0.5 * case.net().designed_area.sqrt(), |t| t.position.norm());
        let angular_scale = frames.angular_momentum[0].norm() + momentum_scale * arm;
        let energy_scale = case.net().launch_energy();

        // What came from outside is known at the end only, so the end is compared with it.
        let momentum = (frames.momentum[last] - frames.momentum[0] - run.outside_impulse).norm();
        let angular = frames.angular_momentum[last] - frames.angular_momentum[0];
        let angular = (angular - run.outside_angular_impulse).norm();
        let residual = largest(frames.ledger.iter().map(|l| l.residual().abs()));
        let ledger = &frames.ledger[last];
        Conservation {
            momentum_residual: relative(momentum, momentum_scale),
            angular_momentum_residual: relative(angular, angular_scale),
            energy_residual: relative(residual, energy_scale),
            energy_taken_by_solver: ledger.solver.map(|taken| relative(taken, energy_scale)),
            energy_created: relative(ledger.created, energy_scale + ledger.all_put_in()),
            energy_start_j: frames.ledger[0].mechanical(),
            energy_end_j: frames.ledger[last].mechanical(),
        }
    }
}

/// The largest of `values` and 0; not a number when one of them is none, which `f64::max` would hide.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |largest: f64, value| if largest.is_nan() || value <= largest { largest } else { value })
}

/// `value` over `scale`; a scene that has no scale (a net at rest) reports the value itself.
fn relative(value: f64, scale: f64) -> f64 {
    if scale > 0.0 { value / scale } else { value }
}
