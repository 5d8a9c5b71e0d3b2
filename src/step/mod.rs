//! How a step is taken: one folder a method, chosen here and nowhere else.
//!
//! | | contact by the engine | contact by our own response |
//! |---|---|---|
//! | [`rapier_joints`] | yes, the default | yes: the same cables, another answer |
//! | [`mass_spring`] | no: the engine solves contacts of bodies that it moves itself | yes: the source's solver |
//! | [`ancf`] | no, likewise | not yet: free flight |

pub mod adaptive;
pub mod ancf;
pub mod iterations;
pub mod limits;
pub mod mass_spring;
pub mod rapier_joints;
pub mod stepper;

use crate::options::TimeStep;
use crate::solver::{CableModel, Solver};
use limits::Demands;
use stepper::Method;

/// The method that a scene asks for.
pub fn method(solver: &Solver) -> &'static dyn Method {
    match solver.cables {
        CableModel::Joints => &rapier_joints::Joints,
        CableModel::Explicit => &mass_spring::Explicit,
        CableModel::Ancf => &ancf::CableElements,
    }
}

/// The step that suits a scene, whatever its own.
pub fn chosen(demands: &Demands<'_>) -> TimeStep {
    method(demands.solver).limits(demands).chosen
}
