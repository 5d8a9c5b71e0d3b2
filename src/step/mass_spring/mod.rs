//! A step with the explicit net: sub-steps of cables and contact, the engine asked for contacts only.

pub mod dopri5;
pub mod kernel;
pub mod stability;

use nalgebra::Vector3;

use crate::case::Case;
use crate::contact::watch::{Movable, Watch};
use crate::failure::{self, Cuts, Failure};
use crate::limits::Limit;
use crate::options::BuildOptions;
use crate::state::State;
use crate::step::Pull;
use crate::target::motion::RigidMotion;
use crate::work::{Clock, Work};
use crate::world::Census;
use kernel::ExplicitNet;

/// Cables as an explicit net.
pub struct MassSpring {
    net: ExplicitNet,
    motion: Option<RigidMotion>,
    watch: Option<Watch>,
    /// Knots that effects may reach in this step, and whether one changed their velocity in this sub-step.
    reached: Vec<usize>,
    touched: Vec<bool>,
    substep: f64,
    n_substeps: u32,
    cuts: Cuts,
}

impl MassSpring {
    /// The method for `case`.
    pub fn new(case: &Case, plan: &BuildOptions) -> MassSpring {
        MassSpring {
            watch: crate::step::watch(case, plan),
            ..MassSpring::with_substeps(case, plan.step, plan.substeps)
        }
    }

    /// The explicit net that flies a run with joints until the boxes meet: no contact.
    pub fn flight(case: &Case) -> MassSpring {
        let n_substeps = (case.time_step.step / case.safe_substep()).ceil().max(1.0) as u32;
        MassSpring::with_substeps(case, case.time_step.step, n_substeps)
    }

    fn with_substeps(case: &Case, step: f64, n_substeps: u32) -> MassSpring {
        let solver = &case.scene.solver;
        MassSpring {
            net: ExplicitNet::new(&case.net, solver.integrator, solver.tolerance_m.0),
            motion: case.target.as_ref().map(RigidMotion::of),
            watch: None,
            reached: Vec::new(),
            touched: vec![false; case.net.n_knots()],
            substep: step / f64::from(n_substeps),
            n_substeps,
            cuts: Cuts::new(case.limits.of(Limit::Cuts)),
        }
    }

    /// One step from `before`.
    pub fn advance(
        &mut self,
        before: &State,
        state: &mut State,
        work: &mut Work,
        pull: &mut dyn Pull,
    ) -> Result<(), Failure> {
        let mut clock = Clock::start();
        let step = self.substep * f64::from(self.n_substeps);
        if let (Some(watch), Some(body)) = (&mut self.watch, &state.target) {
            watch.look(state, body, step);
        }
        clock.lap(&mut work.stages.contact);

        if pull.presses() {
            self.reached.clear();
            self.reached.extend(0..state.knots.position.len());
        } else {
            pull.reach(&mut self.reached);
        }
        self.net.load(&state.knots, &state.loads.on_knots);
        // One more than may be: those end it.
        let tried = self.net.tried();
        self.net.allow(self.cuts.begin().saturating_add(1));
        for _ in 0..self.n_substeps {
            self.net.kick(self.substep);
            if !self.reached.is_empty() {
                self.pull(state, pull);
            }
            if let Some(body) = &mut state.target {
                if let Some(watch) = &mut self.watch {
                    watch.answer(&mut self.net, body, self.substep, |_| {});
                }
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

        if let Some(watch) = &self.watch {
            watch.report(&before.knots, &state.knots, &mut state.contacts);
            work.detections = watch.n_detections;
        }
        pull.report(&before.knots, &state.knots, &mut state.contacts);
        work.substeps += u64::from(self.n_substeps);
        clock.lap(&mut work.stages.contact);
        Ok(())
    }

    /// Threads pull and contacts press sub-step by sub-step. As impulses of two sub-steps at a time threads
    /// put 8 to 10 % of the launch energy into the cables, of ten 64 %; as forces held over ten they turn with
    /// their segments too late, and a quarter of the angular momentum is lost.
    fn pull(&mut self, state: &mut State, pull: &mut dyn Pull) {
        self.net.store_some(&mut state.knots, self.reached.iter().copied());
        if pull.pulls() {
            pull.pull(&mut state.knots, self.substep, &mut self.touched);
        }
        if pull.presses() {
            pull.press(&mut state.knots, &mut state.target, self.substep, &mut self.touched);
        }
        for &knot in &self.reached {
            if std::mem::take(&mut self.touched[knot]) {
                self.net.set_velocity(knot, &state.knots.velocity[knot]);
            }
        }
    }

    /// What the engine consists of: no body, no joint, and colliders where there is a target.
    pub fn census(&self) -> Census {
        Census { colliders: self.watch.as_ref().map_or(0, Watch::n_colliders), ..Census::default() }
    }
}

impl Movable for ExplicitNet {
    fn position(&self, knot: usize) -> Vector3<f64> {
        ExplicitNet::position(self, knot)
    }

    fn velocity(&self, knot: usize) -> Vector3<f64> {
        ExplicitNet::velocity(self, knot)
    }

    fn inverse_mass(&self, knot: usize) -> f64 {
        ExplicitNet::inverse_mass(self, knot)
    }

    fn push(&mut self, knot: usize, impulse: &Vector3<f64>) {
        ExplicitNet::push(self, knot, impulse);
    }
}
