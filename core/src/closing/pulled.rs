//! The knots that a mechanism pulls, and its work on them.
//!
//! Work within a (sub-)step: Σ J · (v⁻ + v⁺) / 2 over the impulses J on the knots, with their velocities at
//! its start and its end; exactly the share of J in the change of their energy, whatever else acts. It is
//! summed sub-step by sub-step: within a whole step a light knot swings to and fro, and its mean
//! velocity tells nothing (closing a Cubesat's net, energy seemed to rise by 0.5 % of the launch energy).

use nalgebra::Vector3;

use crate::state::Knots;

/// Knots that may be pulled.
#[derive(Clone, Debug)]
pub struct PulledKnots {
    knots: Vec<Pulled>,
    /// The (sub-)step whose end is not known yet [s].
    open: Option<f64>,
    done: Done,
}

/// What was done to them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Done {
    /// Work [J].
    pub work: f64,
    /// Number of knots, over the (sub-)steps.
    pub count: u64,
}

#[derive(Clone, Copy, Debug)]
struct Pulled {
    knot: usize,
    /// At the start of the (sub-)step [m].
    start: Vector3<f64>,
    /// At the end of the one before [m/s].
    velocity: Vector3<f64>,
    /// Before the pull [m/s].
    unpulled: Vector3<f64>,
    /// [N s]
    impulse: Vector3<f64>,
}

impl PulledKnots {
    /// For `knots`, each once.
    pub fn new(knots: Vec<usize>) -> PulledKnots {
        let zeros = Vector3::zeros();
        let pulled = |knot| Pulled { knot, start: zeros, velocity: zeros, unpulled: zeros, impulse: zeros };
        PulledKnots { knots: knots.into_iter().map(pulled).collect(), open: None, done: Done::default() }
    }

    /// The knots.
    pub fn knots(&self) -> impl Iterator<Item = usize> {
        self.knots.iter().map(|pulled| pulled.knot)
    }

    /// Hears how fast they are before the first pull.
    pub fn begin(&mut self, knots: &Knots) {
        for pulled in &mut self.knots {
            pulled.velocity = knots.velocity[pulled.knot];
        }
    }

    /// Hears where they are before the pull in a (sub-)step of `step` seconds.
    pub fn before_pull(&mut self, knots: &Knots, step: f64) {
        // Cables have changed the velocities since the last one; how far a knot has come tells what it was.
        self.close(|pulled, step| (knots.position[pulled.knot] - pulled.start) / step);
        for pulled in &mut self.knots {
            pulled.start = knots.position[pulled.knot];
            pulled.unpulled = knots.velocity[pulled.knot];
        }
        self.open = Some(step);
    }

    /// Hears how fast they are after it, and marks those that it changed.
    pub fn after_pull(&mut self, knots: &Knots, inverse_mass: &[f64], touched: &mut [bool]) {
        for pulled in &mut self.knots {
            let change = knots.velocity[pulled.knot] - pulled.unpulled;
            pulled.impulse = change / inverse_mass[pulled.knot];
            touched[pulled.knot] |= change != Vector3::zeros();
        }
    }

    /// Hears how fast they are at the end of the step.
    pub fn end_step(&mut self, knots: &Knots) {
        self.close(|pulled, _| knots.velocity[pulled.knot]);
    }

    fn close(&mut self, velocity_at_end: impl Fn(&Pulled, f64) -> Vector3<f64>) {
        let Some(step) = self.open.take() else { return };
        for pulled in &mut self.knots {
            let after = velocity_at_end(pulled, step);
            let before = std::mem::replace(&mut pulled.velocity, after);
            self.done.work += 0.5 * pulled.impulse.dot(&(before + after));
            self.done.count += u64::from(pulled.impulse != Vector3::zeros());
        }
    }

    /// Work on them since it was last taken [J].
    pub fn work(&self) -> f64 {
        self.done.work
    }

    /// What was done to them since this was last asked.
    pub fn take_done(&mut self) -> Done {
        std::mem::take(&mut self.done)
    }
}
