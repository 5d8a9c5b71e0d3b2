//! How a step is taken: one folder a method, chosen here and nowhere else.
//!
//! | | contact by the engine | contact by our own response |
//! |---|---|---|
//! | [`rapier_joints`] | yes, the default | yes: the same cables, another answer |
//! | [`mass_spring`] | no: the engine solves contacts of bodies that it moves itself | yes: the source's solver |
//! | [`ancf`] | no, likewise | yes: on knots, and on spheres along the cables |

pub mod adaptive;
pub mod ancf;
pub mod iterations;
pub mod limits;
pub mod mass_spring;
pub mod rapier_joints;
pub mod stepper;
pub mod together;

use crate::options::{BuildContext, TimeStep};
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

/// Mass with which each knot of `context` answers an impulse [kg].
pub fn answering_mass(context: &BuildContext<'_>) -> Vec<f64> {
    let elements = method(context.solver).elements(context.net, context.solver);
    elements.map_or_else(|| context.net.mass.clone(), |elements| elements.answering_mass)
}

/// The step that suits a scene, whatever its own.
pub fn chosen(demands: &Demands<'_>) -> TimeStep {
    method(demands.solver).limits(demands).chosen
}
