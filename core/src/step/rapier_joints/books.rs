//! What effects gave to net and target within a step, and what the step made beyond it.

use nalgebra::Vector3;

use crate::state::{Body, Contact, Knots, State, TARGET};

/// StepBooks of a step.
#[derive(Default)]
pub struct StepBooks {
    /// Impulse of contacts of effects on each knot [N s]; none where no effect acts.
    given: Vec<Vector3<f64>>,
    /// Impulse of constraints on each knot within a part of the step [N s]; none where no effect acts.
    pulled: Vec<Vector3<f64>>,
    /// Velocities at the start of that part, where constraints act [m/s].
    part_start: Vec<Vector3<f64>>,
    /// Whether contacts of effects gave any.
    pub gave: bool,
    /// Work of contacts of effects on the target [J].
    given_to_target: f64,
    /// Work of its surface on knots in them, as if these were part of it [J].
    given_by_surface: f64,
    /// Work of constraints and forces on the net [J].
    work_of_effects: f64,
}

impl StepBooks {
    /// Room for what effects give to `n_knots` knots.
    pub fn open(&mut self, n_knots: usize) {
        self.given.resize(n_knots, Vector3::zeros());
        self.pulled.resize(n_knots, Vector3::zeros());
    }

    /// A step begins, or begins again.
    pub fn begin(&mut self) {
        (self.work_of_effects, self.given_to_target, self.given_by_surface) = (0.0, 0.0, 0.0);
        self.given.fill(Vector3::zeros());
        self.gave = false;
    }

    /// A part of it begins with `velocity` of the knots, and constraints.
    pub fn begin_part(&mut self, velocity: &[Vector3<f64>]) {
        self.pulled.fill(Vector3::zeros());
        self.part_start.clear();
        self.part_start.extend_from_slice(velocity);
    }

    /// Constraints gave `impulse` to `knot`.
    pub fn pull(&mut self, knot: usize, impulse: Vector3<f64>) {
        self.pulled[knot] += impulse;
    }

    /// A contact of an effect gave `impulse` to `knot` at `position`, with bodies as they were before.
    pub fn give(&mut self, knot: usize, impulse: Vector3<f64>, position: &Vector3<f64>, bodies: &[Body]) {
        if let Some(body) = bodies.get(TARGET) {
            self.given_by_surface += impulse.dot(&body.velocity_at(*position));
        }
        self.given[knot] += impulse;
        self.gave = true;
    }

    /// Contacts of effects did `work` on the target.
    pub fn give_to_target(&mut self, work: f64) {
        self.given_to_target += work;
    }

    /// Work of constraints within the part that ended with `velocity` [J]: with the mean velocity over the part, which
    /// is their share in the change of energy. With that at the kick, what a thread gives to light knots and cables
    /// take back at once would count as put in, and hide what these make: with a thread of 10 N 0.06 of the
    /// energy at hand.
    pub fn work_of_constraints(&mut self, velocity: &[Vector3<f64>]) -> f64 {
        let ends = self.part_start.iter().zip(velocity);
        let work = self.pulled.iter().zip(ends).map(|(pulled, (v, w))| 0.5 * pulled.dot(&(v + w))).sum();
        self.work_of_effects += work;
        work
    }

    /// Work of `forces` on knots that moved [J].
    pub fn work_of_forces(&mut self, forces: &[Vector3<f64>], from: &Knots, to: &Knots) -> f64 {
        let moved = from.position.iter().zip(&to.position);
        let work = forces.iter().zip(moved).map(|(force, (from, to))| force.dot(&(to - from))).sum();
        self.work_of_effects += work;
        work
    }

    /// By how much the energy of net and bodies rose in a step that began with `start`, beyond what constraints, forces
    /// and the surface of a target that is held or driven put in [J]; `of_net`: the net's share of it.
    pub fn rise(&self, of_net: f64, start: &State, state: &State) -> f64 {
        let is_held = state.each_body().any(|(model, _)| model.has_shape() && !model.is_free());
        let of_bodies = state.energy_of_bodies(true) - start.energy_of_bodies(true);
        let by_drive = match is_held {
            true => state.contacts.iter().map(Contact::work_of_surface).sum::<f64>() + self.given_by_surface,
            false => 0.0,
        };
        of_net + of_bodies - self.work_of_effects - by_drive
    }

    /// Energy that net and target gained in the step beyond what was put in [J]; `gain`: all that they gained.
    ///
    /// What contact takes along its normals counts as lost, what friction takes does not: it is an effect,
    /// and meant to take it. Impulses of contacts on knots are weighed with the mean velocity over the step: kick by
    /// kick, what a contact pushes out and cables press back would count as lost, and hide what they make. A small
    /// net whose cables touch a box gained so 0.19 of its launch energy. `knots_are_given`: contacts of knots, too, are answered before the
    /// engine moves the net, and stand in the books.
    pub fn error(&self, mut gain: f64, before: &State, state: &State, knots_are_given: bool) -> f64 {
        gain -= self.work_of_effects + self.given_to_target;
        let ends = before.knots.velocity.iter().zip(&state.knots.velocity);
        gain -= self.given.iter().zip(ends).map(|(given, (v, w))| 0.5 * given.dot(&(v + w))).sum::<f64>();
        if knots_are_given {
            return gain;
        }
        for contact in state.contacts.iter().filter(|contact| contact.along.is_none()) {
            gain += contact.friction_loss;
            if !state.body_models[contact.body].is_free() {
                // The work of the moving surface comes from what drives it.
                gain -= contact.work_of_surface();
            }
        }
        gain
    }
}
