//! Cables as the source's gradient-deficient elements (Eq. 3.7 to 3.16): absolute nodal coordinates, a constant
//! mass matrix, explicit sub-steps, or implicit steps in flight.
//!
//! | file | subject |
//! |---|---|
//! | [`element`] | shape functions, matrices of an element, quadrature; a cable condensed to its ends |
//! | [`mass`], `band` | the mass matrix of the knots, factorised once |
//! | `motion`, `law` | coordinates as arrays; forces, energy and loss of an element |
//! | [`kernel`], `impulse` | accelerations and motion of the whole net; what impulses do to it |
//! | [`points`] | knots and spheres that touch, and how they answer |
//! | [`stability`] | the largest stable step |
//! | `implicit`, `over_step`, `block` | a step of any length in flight: its equations, mean forces, cables eliminated |
//! | `march` | a step: sub-steps of cables, threads and contact, or an implicit one |
//!
//! Coordinates: a position is shared by all cables that meet at a knot; slopes there are each cable's own. Cables
//! of a net cross and end at its knots in all directions and are tied, not clamped: one slope for all of them has no
//! meaning, and one along a line through a knot would resist the kink that every folded and every pulled net has
//! there. Within a cable elements share position and slope. The elements' inner coordinates are not knots: a frame
//! and a thread do not see them; contacts act on spheres along them, fields on all of them.
//!
//! Sub-step: half a drift, a kick by all forces, then threads and contacts as impulses, half a drift (leap-frog): of second
//! order without damping, of first with it. Target and net drift together.
//!
//! `implicit` steps stand in for all sub-steps of a step in which nothing touches and no thread pulls. A contact's row asks how
//! its point answers an impulse, which within an implicit step of stiff cables is not by the mass alone: as the points touch
//! or do not, that matrix would be another in every correction. In contact, steps have to follow the lightest points anyway.
//!
//! Beside the source: a point of the quadrature that is shortened gives no force, as Section 3.3.1 says of cables;
//! Eq. 3.12 alone would press. The source's elements are undamped; the net's own damping ratio acts between the
//! nodes of an element as Eq. 3.3 has it, and 0 is the source's case. Bending, where it is asked for, takes |r″| for
//! the curvature. The shot moves what lies between two knots as a straight line between them.

mod band;
mod block;
pub mod element;
mod implicit;
mod impulse;
pub mod kernel;
mod law;
mod march;
pub mod mass;
mod motion;
mod over_step;
pub mod points;
pub mod stability;

use crate::net::Net;
use crate::options::{BuildContext, TimeStep};
use crate::solver::{Integrator, JOINTS_STEP, Solver};
use crate::state::elements::ElementNet;
use crate::step::limits::{Demands, StepLimits};
use crate::step::stepper::{Method, Stepper};
use crate::work::Work;
use kernel::element_net;
use march::AncfMarch;
use stability::{safe_share, stable_step, stable_with_contact, throwing_step};

/// Cables as elements.
pub struct CableElements;

/// Implicit step that is chosen [s].
const IMPLICIT_STEP: f64 = 1e-4;

/// Longest step over the stable one where air drags, ω h < π: an end of an element answers with a tenth of the mass that is lumped on it, and one
/// whose vibration turns within the step is driven by the force of its start. At half a millisecond air of 20 kg/m³ without a wind put
/// 8e4 J into a net of 26 J, of 100 kg/m³ 5e5 J; at implicit steps of 0.1 ms that 3e6 J.
const DRAGGED: f64 = 1.5;

/// Bytes of an element: four arrays for each of its coordinates, and the state's two copies [bytes].
const ELEMENT: f64 = 1000.0;

/// Memory of the elements of `net` [bytes]: the mass matrix has a band of about the shorter side of the net, and
/// as much again for each line of middle knots beside it.
pub fn memory(net: &Net, solver: &Solver) -> f64 {
    let ancf = solver.ancf.unwrap_or_default();
    let lines = net.n_knots() as f64 / (net.grid[0] * net.grid[1]).max(1) as f64;
    let band = net.grid[0].min(net.grid[1]) as f64 * lines;
    // An implicit step has equations along three axes together, for the knots and for each cable.
    let (element, bands) = match solver.integrator {
        Integrator::Implicit => (3.0 * ELEMENT, 12.0),
        _ => (ELEMENT, 3.0),
    };
    element * f64::from(ancf.elements + 1) * net.cables.len() as f64
        + bands * size_of::<f64>() as f64 * band * net.n_knots() as f64
}

impl Method for CableElements {
    fn limits(&self, demands: &Demands<'_>) -> StepLimits {
        let ancf = demands.solver.ancf.unwrap_or_default();
        let of_cables = stable_step(demands.net, &ancf);
        let stable = stable_with_contact(of_cables, demands, &ancf);
        let safe = safe_share(demands.net) * stable;
        let own = safe.min(demands.pulled_step()).min(throwing_step(demands, &ancf));
        let given = demands.solver.step_s.map(|step| step.0);
        let is_implicit = demands.solver.integrator == Integrator::Implicit;
        let substep = given.filter(|_| !is_implicit).unwrap_or(own);
        // Contacts are found once a step: no point may come from beyond the margin within it, nor one at twice the speed
        // after a snap.
        let found = demands.target.map_or(f64::INFINITY, |_| {
            0.5 * demands.contact_margin() / demands.fastest().max(f64::MIN_POSITIVE)
        });
        let found = found.min(demands.thin_step()).min(demands.pulled_step());
        let found = if demands.options.drags { found.min(DRAGGED * of_cables) } else { found };
        if is_implicit {
            let step =
                given.unwrap_or_else(|| demands.in_frames(IMPLICIT_STEP.min(demands.sample).min(found)));
            // Sub-steps for contacts and threads, where there may be any.
            let acts = demands.target.is_some() || demands.options.has_constraints;
            let substeps = if acts { (step / own).ceil().max(1.0) as u32 } else { 1 };
            return StepLimits {
                stable: f64::INFINITY,
                safe,
                chosen: TimeStep { step, substeps },
                written: step,
            };
        }
        let step = demands.in_frames(JOINTS_STEP.min(demands.sample).min(found).max(substep));
        let chosen = TimeStep { step, substeps: (step / substep).ceil().max(1.0) as u32 };
        StepLimits { stable, safe, chosen, written: step / f64::from(chosen.substeps) }
    }

    fn acts_in_substeps(&self) -> bool {
        true
    }

    fn forecast(&self, _n_cables: usize, n_steps: u64, time_step: TimeStep) -> Work {
        let substeps = n_steps * u64::from(time_step.substeps);
        Work { steps: n_steps, substeps, detections: n_steps / 5, ..Work::default() }
    }

    fn price(&self, solver: &Solver, _n_knots: usize, n_cables: usize, work: &Work) -> f64 {
        let elements = f64::from(solver.ancf.unwrap_or_default().elements);
        // Flown implicitly: some corrections a step.
        let each = if solver.integrator == Integrator::Implicit && work.substeps == work.steps {
            5e-6
        } else {
            60e-9
        };
        each * elements * n_cables as f64 * work.substeps as f64
    }

    fn elements(&self, net: &Net, solver: &Solver) -> Option<ElementNet> {
        Some(element_net(net, &solver.ancf.unwrap_or_default()))
    }

    fn build(&self, context: &BuildContext<'_>) -> Box<dyn Stepper> {
        Box::new(AncfMarch::new(context))
    }
}
