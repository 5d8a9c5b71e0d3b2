//! How a step is taken: one folder a method, chosen here and nowhere else.
//!
//! | | contact by the engine | contact by our own response |
//! |---|---|---|
//! | [`rapier_joints`] | yes, the default | yes: the same cables, another answer |
//! | [`mass_spring`] | no: the engine solves contacts of bodies that it moves itself | yes: the source's solver |

pub mod adaptive;
pub mod iterations;
pub mod limits;
pub mod mass_spring;
pub mod rapier_joints;
pub mod stepper;

use crate::options::TimeStep;
use crate::solver::{CableModel, Solver};
use limits::Demands;
use stepper::Method;

<<<<<<< HEAD
/// The method that a scene asks for.
pub fn method(solver: &Solver) -> &'static dyn Method {
    match solver.cables {
        CableModel::Joints => &rapier_joints::Joints,
        CableModel::Explicit => &mass_spring::Explicit,
=======
/// The method of a run.
pub enum Method {
    /// Cables as joints of the engine.
    Joints(Box<rapier_joints::RapierJoints>),
    /// Cables as an explicit net.
    Explicit(Box<mass_spring::MassSpring>),
}

impl Method {
    /// The method that `case` asks for; `plan` holds what effects ask of it.
    pub fn new(case: &Case, plan: &BuildOptions) -> Method {
        match case.scene.solver.cables {
            CableModel::Joints => Method::Joints(Box::new(rapier_joints::RapierJoints::new(case, plan))),
            CableModel::Explicit => Method::Explicit(Box::new(mass_spring::MassSpring::new(case, plan))),
        }
    }

    /// One step from `before`, which `state` equals but for the loads and velocities changed since.
    ///
    /// # Errors
    /// A state that is not a number.
    pub fn advance(
        &mut self,
        before: &State,
        state: &mut State,
        work: &mut Work,
        pull: &mut dyn Pull,
    ) -> Result<(), Failure> {
        match self {
            Method::Joints(method) => method.advance(before, state, work, pull),
            Method::Explicit(method) => method.advance(before, state, work, pull),
        }
    }

    /// Takes over velocities that effects changed since the last step.
    pub fn take_velocities(&mut self, state: &State) {
        // The explicit net takes over the whole state at the start of every step.
        if let Method::Joints(method) = self {
            method.take_velocities(state);
        }
    }

    /// Hears what energy the step gained, over the launch energy.
    pub fn hear_gain(&mut self, gain: f64) {
        if let Method::Joints(method) = self {
            method.iterations.adapt(gain);
        }
    }

    /// What cables took by their own law since the last call [J], where the method knows.
    pub fn take_cable_loss(&mut self) -> Option<f64> {
        match self {
            Method::Joints(_) => None,
            Method::Explicit(method) => method.take_cable_loss(),
        }
    }

    /// What the engine consists of.
    pub fn census(&self) -> Census {
        match self {
            Method::Joints(method) => method.census(),
            Method::Explicit(method) => method.census(),
        }
>>>>>>> 6ba536d (Look for created energy after every step, name it before the verdict, end a run that leaves all bounds)
    }
}

/// The step that suits a scene, whatever its own.
pub fn chosen(demands: &Demands<'_>) -> TimeStep {
    method(demands.solver).limits(demands).chosen
}
