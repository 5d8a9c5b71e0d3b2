//! A step with the explicit net: sub-steps of cables and contact, the engine asked for contacts only.

pub mod dopri5;
pub mod kernel;
pub mod secant;
pub mod stability;

use nalgebra::Vector3;

use crate::contact::{ContactManager, NetMotion};
use crate::failure::{self, Cuts, Failure};
use crate::interaction::Interactions;
use crate::limits::Limit;
use crate::options::{BuildContext, TimeStep};
use crate::solver::{Integrator, JOINTS_STEP, Solver};
use crate::state::State;
use crate::step::limits::{Demands, StepLimits};
use crate::step::stepper::{Method, StepReport, Stepper};
use crate::target::motion::RigidMotion;
use crate::work::{Clock, Work};
use crate::world::Census;
use kernel::ExplicitNet;
use stability::{RESOLVES, SAFE, stable_step};

/// Cables as an explicit net.
pub struct Explicit;

impl Method for Explicit {
    fn limits(&self, demands: &Demands<'_>) -> StepLimits {
        let stable = stable_step(demands.net).min(demands.stable_contact_step());
        let takes_turns = demands.has_contact_force() || demands.has_constraints;
        let safe = if takes_turns { RESOLVES } else { SAFE } * stable;
        let substep = demands.solver.step_s.map_or(safe, |step| step.0);
        // Contacts are found once a step: no knot may come from beyond the margin within it, nor
        // one at twice the speed after a snap.
        // Without a target there is nothing to find: a tenth of the steps sufficed for Table 3.2.
        let found = demands.target.map_or(f64::INFINITY, |_| {
            0.5 * demands.contact_margin() / demands.fastest().max(f64::MIN_POSITIVE)
        });
        let step = JOINTS_STEP.min(demands.sample).min(demands.thin_step()).min(found).max(substep);
        let chosen = TimeStep { step, substeps: (step / substep).ceil().max(1.0) as u32 };
        StepLimits { stable, safe, chosen }
    }

    fn acts_in_substeps(&self) -> bool {
        true
    }

    /// Contacts are looked for every few steps.
    fn forecast(&self, _n_cables: usize, n_steps: u64, time_step: TimeStep) -> Work {
        Work {
            steps: n_steps,
            substeps: n_steps * u64::from(time_step.substeps),
            detections: n_steps / 5,
            ..Work::default()
        }
    }

    /// 5 ns a cable and sub-step, with the motion of its knots.
    fn price(&self, solver: &Solver, _n_knots: usize, n_cables: usize, work: &Work) -> f64 {
        let evaluations = match solver.integrator {
            // Two passes over the cables for one.
            Integrator::Secant => 2.0,
            Integrator::Symplectic => 1.0,
            Integrator::Rk4 => 5.0,
            Integrator::Located => 50.0,
        };
        5e-9 * evaluations * n_cables as f64 * work.substeps as f64
    }

    fn build(&self, context: &BuildContext<'_>) -> Box<dyn Stepper> {
        Box::new(MassSpring {
            contacts: ContactManager::new(context.contact_settings().as_ref()),
            ..MassSpring::new(context, context.time_step)
        })
    }
}

/// Cables as an explicit net, at work.
pub struct MassSpring {
    net: ExplicitNet,
    motion: Option<RigidMotion>,
    contacts: ContactManager,
    /// Knots that effects may change in this step, and whether one changed their velocity in this sub-step.
    reached: Vec<usize>,
    touched: Vec<bool>,
    substep: f64,
    n_substeps: u32,
    cuts: Cuts,
}

impl MassSpring {
    /// The explicit net that flies a run with joints until the boxes meet: no contact.
    pub fn flight(context: &BuildContext<'_>) -> MassSpring {
        let step = context.time_step.step;
        let substeps = (step / (SAFE * stable_step(context.net))).ceil().max(1.0) as u32;
        MassSpring::new(context, TimeStep { step, substeps })
    }

    fn new(context: &BuildContext<'_>, time_step: TimeStep) -> MassSpring {
        let BuildContext { net, target, solver, .. } = *context;
        MassSpring {
            net: ExplicitNet::new(net, solver.integrator, solver.tolerance_m.0),
            motion: target.map(RigidMotion::of),
            contacts: ContactManager::Absent,
            reached: Vec::new(),
            touched: vec![false; net.n_knots()],
            substep: time_step.step / f64::from(time_step.substeps),
            n_substeps: time_step.substeps,
            cuts: Cuts::new(context.limits.of(Limit::Cuts)),
        }
    }

    /// Constraints and contacts of effects act sub-step by sub-step. As impulses of two sub-steps at a time
    /// threads put 8 to 10 % of the launch energy into the cables, of ten 64 %; as forces held over ten they
    /// turn with their segments too late, and a quarter of the angular momentum is lost.
    fn interact(&mut self, state: &mut State, with: &mut Interactions) {
        self.net.store_some(&mut state.knots, self.reached.iter().copied());
        if with.constrain() {
            with.solve_constraints(&mut state.knots, self.substep, &mut self.touched);
        }
        if with.touch() {
            with.solve_contacts(&mut state.knots, &mut state.target, self.substep, &mut self.touched);
        }
        for &knot in &self.reached {
            if std::mem::take(&mut self.touched[knot]) {
                self.net.set_velocity(knot, &state.knots.velocity[knot]);
            }
        }
    }
}

impl Stepper for MassSpring {
    fn step(
        &mut self,
        before: &State,
        state: &mut State,
        with: &mut Interactions,
        work: &mut Work,
    ) -> Result<StepReport, Failure> {
        let mut clock = Clock::start();
        let step = self.substep * f64::from(self.n_substeps);
        self.contacts.begin(state);
        self.contacts.update(state, step);
        clock.lap(&mut work.stages.contact);

        if with.touch() {
            self.reached.clear();
            self.reached.extend(0..state.knots.position.len());
        } else {
            with.constrained_knots(&mut self.reached);
        }
        self.net.load(&state.knots, &state.forces.on_knots);
        // One more than may be: those end it.
        let tried = self.net.tried();
        self.net.allow(self.cuts.begin().saturating_add(1));
        for _ in 0..self.n_substeps {
            self.net.kick(self.substep);
            if !self.reached.is_empty() {
                self.interact(state, with);
            }
            if let Some(body) = &mut state.target {
                self.contacts.solve(&mut self.net, body, self.substep);
                if let Some(motion) = &self.motion {
                    motion.drift(body, self.substep);
                }
            }
            self.net.drift(self.substep);
        }
        self.net.store(&mut state.knots);
        self.net.take_tension(&mut state.tension);
        self.cuts.count(self.net.tried() - tried, state.time)?;
        failure::check(state, "cables")?;
        clock.lap(&mut work.stages.cables);

        self.contacts.report(&before.knots, state, |from, to, list| with.report_contacts(from, to, list));
        work.detections = self.contacts.n_detections().unwrap_or(work.detections);
        work.substeps += u64::from(self.n_substeps);
        clock.lap(&mut work.stages.contact);
        Ok(StepReport { cable_loss: self.net.take_dissipated(), ..StepReport::default() })
    }

    /// No body, no joint, and colliders where there is a target.
    fn census(&self) -> Census {
        Census { colliders: self.contacts.n_colliders(), ..Census::default() }
    }
}

impl NetMotion for ExplicitNet {
    fn position(&self, knot: usize) -> Vector3<f64> {
        ExplicitNet::position(self, knot)
    }

    fn velocity(&self, knot: usize) -> Vector3<f64> {
        ExplicitNet::velocity(self, knot)
    }

    fn inverse_mass(&self, knot: usize) -> f64 {
        ExplicitNet::inverse_mass(self, knot)
    }

    fn push(&mut self, knot: usize, impulse: &Vector3<f64>, weight: f64) {
        ExplicitNet::push(self, knot, &(weight * impulse));
    }
}
