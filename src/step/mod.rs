//! How a step is taken: with cables as joints of the engine, or as an explicit net.
//!
//! | | contact by the engine | contact by our own response |
//! |---|---|---|
//! | [`rapier_joints`] | yes, the default | yes: the same cables, another answer |
//! | [`mass_spring`] | no: the engine solves contacts of bodies that it moves itself | yes: the source's solver |

pub mod adaptive;
pub mod iterations;
pub mod mass_spring;
pub mod rapier_joints;

use crate::case::Case;
use crate::contact::impulse::Impulse;
use crate::contact::penalty::Penalty;
use crate::contact::watch::{Response, Watch};
use crate::failure::Failure;
use crate::options::BuildOptions;
use crate::solver::{CableModel, ContactModel};
use crate::state::{Body, Contact, Knots, State};
use crate::work::Work;
use crate::world::Census;

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

    /// What the engine consists of.
    pub fn census(&self) -> Census {
        match self {
            Method::Joints(method) => method.census(),
            Method::Explicit(method) => method.census(),
        }
    }
}

/// What effects do within a step: their threads pull, and their contacts press.
pub trait Pull {
    /// Whether anything pulls.
    fn pulls(&self) -> bool;

    /// The knots that threads may pull within the step; they read no other.
    fn reach(&self, knots: &mut Vec<usize>);

    /// Threads change velocities of `knots` for the coming part of a step, of `step` seconds, and mark the
    /// knots.
    fn pull(&mut self, knots: &mut Knots, step: f64, touched: &mut [bool]);

    /// Threads keep themselves as they are at the start of a step that may be done again.
    fn keep(&mut self);

    /// Whether they ended so far off that the step is to be cut; `knots` are those at its end.
    fn overran(&mut self, knots: &Knots) -> bool;

    /// Threads take back what they did since they were kept.
    fn take_back(&mut self);

    /// Whether anything presses.
    fn presses(&self) -> bool;

    /// Contacts change velocities of `knots` and of the target for the coming (sub-)step of `step`
    /// seconds, and mark the knots. After all pulls: nothing then moves the net into the target.
    fn press(&mut self, knots: &mut Knots, target: &mut Option<Body>, step: f64, touched: &mut [bool]);

    /// Adds the contacts it answered within the step from `before` to `after`.
    fn report(&self, before: &Knots, after: &Knots, contacts: &mut Vec<Contact>);
}

/// The watch over the target for a response of our own; none for the engine's, or without a target.
fn watch(case: &Case, plan: &BuildOptions) -> Option<Watch> {
    let target = case.target.as_ref()?;
    let response = match case.scene.solver.contact {
        ContactModel::Rapier => return None,
        ContactModel::Impulse => Response::Impulse(Impulse::new(plan.restitution, plan.friction)),
        ContactModel::Penalty => {
            Response::Penalty(Penalty::new(&case.net, &case.scene.solver.penalty, plan.friction))
        }
    };
    Some(Watch::new(&case.net, target, case.reach(), response, case.scene.solver.precision))
}
