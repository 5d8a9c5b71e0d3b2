//! Cables as the source's gradient-deficient elements (Eq. 3.7 to 3.16): absolute nodal coordinates, a constant
//! mass matrix, explicit sub-steps.
//!
//! | file | subject |
//! |---|---|
//! | [`element`] | shape functions, matrices of an element, quadrature; a cable condensed to its ends |
//! | [`mass`] | the mass matrix of the knots, factorised once |
//! | `motion`, `law` | coordinates as arrays; forces, energy and loss of an element |
//! | [`kernel`] | accelerations and motion of the whole net |
//! | [`stability`] | the largest stable step |
//!
//! Coordinates: a position is shared by all cables that meet at a knot; slopes there are each cable's own. Cables
//! of a net cross and end at its knots in all directions and are tied, not clamped: one slope for all of them has no
//! meaning, and one along a line through a knot would resist the kink that every folded and every pulled net has
//! there. Within a cable elements share position and slope. The elements' inner coordinates are not knots: a frame,
//! a contact or a thread does not see them.
//!
//! Sub-step: half a drift, a kick by all forces, half a drift (leap-frog): of second order without damping, of first
//! with it.
//!
//! Beside the source: a point of the quadrature that is shortened gives no force, as Section 3.3.1 says of cables;
//! Eq. 3.12 alone would press. The source's elements are undamped; the net's own damping ratio acts between the
//! nodes of an element as Eq. 3.3 has it, and 0 is the source's case. Bending, where it is asked for, takes |r″| for
//! the curvature. The shot moves what lies between two knots as a straight line between them.

pub mod element;
pub mod kernel;
mod law;
pub mod mass;
mod motion;
pub mod stability;

use crate::failure::{self, Failure};
use crate::interaction::Interactions;
use crate::net::Net;
use crate::options::{BuildContext, TimeStep};
use crate::solver::{Ancf, JOINTS_STEP, Solver};
use crate::state::State;
use crate::step::limits::{Demands, StepLimits};
use crate::step::stepper::{Method, StepReport, Stepper};
use crate::work::{Clock, Work};
use crate::world::Census;
use kernel::AncfNet;
use stability::{SAFE, stable_step};

/// Cables as elements.
pub struct CableElements;

/// Bytes of an element: four arrays for each of its coordinates, and the state's two copies [bytes].
const ELEMENT: f64 = 1000.0;

/// Memory of the elements of `net` [bytes]: the mass matrix has a band of about the shorter side of the net, and
/// as much again for each line of middle knots beside it.
pub fn memory(net: &Net, ancf: &Ancf) -> f64 {
    let lines = net.n_knots() as f64 / (net.grid[0] * net.grid[1]).max(1) as f64;
    let band = net.grid[0].min(net.grid[1]) as f64 * lines;
    ELEMENT * f64::from(ancf.elements + 1) * net.cables.len() as f64
        + 3.0 * size_of::<f64>() as f64 * band * net.n_knots() as f64
}

impl Method for CableElements {
    fn limits(&self, demands: &Demands<'_>) -> StepLimits {
        let stable = stable_step(demands.net, &demands.solver.ancf.unwrap_or_default());
        let safe = SAFE * stable;
        let substep = demands.solver.step_s.map_or(safe, |step| step.0);
        let step = JOINTS_STEP.min(demands.sample).max(substep);
        let chosen = TimeStep { step, substeps: (step / substep).ceil().max(1.0) as u32 };
        StepLimits { stable, safe, chosen }
    }

    fn acts_in_substeps(&self) -> bool {
        true
    }

    fn forecast(&self, _n_cables: usize, n_steps: u64, time_step: TimeStep) -> Work {
        let substeps = n_steps * u64::from(time_step.substeps);
        Work { steps: n_steps, substeps, ..Work::default() }
    }

    fn price(&self, solver: &Solver, _n_knots: usize, n_cables: usize, work: &Work) -> f64 {
        let elements = f64::from(solver.ancf.unwrap_or_default().elements);
        60e-9 * elements * n_cables as f64 * work.substeps as f64
    }

    fn build(&self, context: &BuildContext<'_>) -> Box<dyn Stepper> {
        let BuildContext { net, solver, time_step, .. } = *context;
        Box::new(AncfFlight {
            elements: AncfNet::new(net, &solver.ancf.unwrap_or_default()),
            substep: time_step.step / f64::from(time_step.substeps),
            n_substeps: time_step.substeps,
        })
    }
}

/// Cables as elements, in free flight.
struct AncfFlight {
    elements: AncfNet,
    substep: f64,
    n_substeps: u32,
}

/// What a scene with elements is refused for, where it comes from elsewhere than a scene.
fn refusal(state: &State, with: &Interactions) -> Option<&'static str> {
    let all = [
        (state.target.is_some(), "a target"),
        (with.kick(), "an effect that kicks"),
        (with.act_within(), "an effect that acts within a step"),
    ];
    all.into_iter().find(|(is_there, _)| *is_there).map(|(_, what)| what)
}

impl Stepper for AncfFlight {
    fn start(&mut self, state: &mut State) {
        state.inner = self.elements.straight(&state.knots);
        self.elements.load(&state.knots, &state.inner, &[]);
        state.totals = Some(self.elements.totals());
    }

    fn step(
        &mut self,
        _before: &State,
        state: &mut State,
        with: &mut Interactions,
        work: &mut Work,
    ) -> Result<StepReport, Failure> {
        if let Some(what) = refusal(state, with) {
            return Err(Failure::Refused { what });
        }
        let mut clock = Clock::start();
        self.elements.load(&state.knots, &state.inner, &state.forces.on_knots);
        self.elements.drift(0.5 * self.substep);
        for left in (0..self.n_substeps).rev() {
            self.elements.kick(self.substep);
            self.elements.drift(if left == 0 { 0.5 } else { 1.0 } * self.substep);
        }
        self.elements.store(&mut state.knots, &mut state.inner);
        self.elements.take_tension(&mut state.tension);
        state.totals = Some(self.elements.totals());
        failure::check(state, "cables")?;
        work.substeps += u64::from(self.n_substeps);
        clock.lap(&mut work.stages.cables);
        Ok(StepReport { cable_loss: Some(self.elements.take_dissipated()), ..StepReport::default() })
    }

    /// No body, no joint, no collider.
    fn census(&self) -> Census {
        Census::default()
    }
}
