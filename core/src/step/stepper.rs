//! What every method owes: limits before it is built, a step, and what the step says of itself.

use crate::failure::Failure;
use crate::interaction::Interactions;
use crate::net::Net;
use crate::options::{BuildContext, TimeStep};
use crate::solver::Solver;
use crate::state::State;
use crate::state::elements::ElementNet;
use crate::step::limits::{Demands, StepLimits};
use crate::work::Work;
use crate::world::Census;

/// A method of advancing the net and the bodies.
pub trait Stepper: Send {
    /// Adds to the state of the start what the method has beyond knots and bodies.
    fn start(&mut self, _state: &mut State) {}

    /// One step from `before`, which `state` equals but for the forces and velocities changed since.
    ///
    /// # Errors
    /// A state that is not a number.
    fn step(
        &mut self,
        before: &State,
        state: &mut State,
        with: &mut Interactions,
        work: &mut Work,
    ) -> Result<StepReport, Failure>;

    /// Takes over velocities that effects changed since the last step.
    fn take_velocities(&mut self, _state: &State) {}

    /// What the engine consists of.
    fn census(&self) -> Census;
}

/// What a step says of itself: what a method that adapts itself decides from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Energy that came from nowhere [J]; negative what was lost, to contact or to the method. None where a
    /// method does not adapt and so does not look.
    pub energy_error: Option<f64>,
    /// Times the step was taken back and cut.
    pub cuts: u32,
    /// What of the energy that is missing cables took.
    pub cable_loss: CableLoss,
    /// How long before the time of the positions that of the velocities is [s].
    pub velocity_lag: f64,
}

/// What cables took in a step, as far as the method knows [J].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CableLoss {
    /// All that is missing: the method does not know.
    #[default]
    Missing,
    /// So much by their own law; what else is missing the method made or destroyed.
    ByLaw(f64),
    /// So much by their own law, among contacts; what else is missing the method took, or made where that is below zero.
    BesideContact(f64),
    /// So much by their own law; what else is missing rows took that are solved implicitly.
    WithRows(f64),
}

/// A method before it is built.
pub trait Method: Sync {
    /// What steps suit it on a scene.
    fn limits(&self, demands: &Demands<'_>) -> StepLimits;

    /// Whether constraints and contacts of effects act in every sub-step.
    fn acts_in_substeps(&self) -> bool;

    /// Counts of `n_steps` steps of a net of `n_cables` cables that meets nothing, about: for forecasts only.
    fn forecast(&self, n_cables: usize, n_steps: u64, time_step: TimeStep) -> Work;

    /// Processor time of the cables and knots in `work`, on a quiet core of an AMD EPYC [s]: what contact and audit
    /// take is the same for all methods, and not in it.
    fn price(&self, solver: &Solver, n_knots: usize, n_cables: usize, work: &Work) -> f64;

    /// The elements that it makes of a net, where it makes any.
    fn elements(&self, _net: &Net, _solver: &Solver) -> Option<ElementNet> {
        None
    }

    /// Builds it.
    fn build(&self, context: &BuildContext<'_>) -> Box<dyn Stepper>;
}
