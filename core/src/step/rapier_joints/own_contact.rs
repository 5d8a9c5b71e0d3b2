//! Forces of contact after the engine has moved net and target without them.

use nalgebra::{UnitQuaternion, Vector3};

use crate::contact::{ContactManager, NetMotion};
use crate::state::{Body, Knots, State, TARGET};
use crate::world::World;

/// Applies them: the impulse acts at the start of the step, where the planes are, so it changes velocity by Δv and
/// position by Δv h.
pub fn solve(
    contacts: &mut ContactManager,
    world: &mut World,
    inverse_mass: &[f64],
    step: f64,
    before: &State,
    state: &mut State,
) {
    let (Some(start), Some(end)) = (before.target(), state.bodies.get_mut(TARGET)) else { return };
    // The pose of the start with the velocities of the end.
    let mut body = Body { velocity: end.velocity, rate: end.rate, ..*start };
    let mut knots =
        MovedKnots { start: &before.knots, end: &mut state.knots, inverse_mass, step, touched: Vec::new() };
    contacts.solve(&mut knots, std::slice::from_mut(&mut body), step);
    for knot in knots.touched {
        world.set_velocity(knot, &state.knots.velocity[knot]);
        world.set_position(knot, &state.knots.position[knot]);
    }
    if body.velocity != end.velocity || body.rate != end.rate {
        end.position += step * (body.velocity - end.velocity);
        end.attitude = UnitQuaternion::from_scaled_axis(step * (body.rate - end.rate)) * end.attitude;
        end.velocity = body.velocity;
        end.rate = body.rate;
        world.set_target(end);
    }
}

/// Knots at the positions of the start of the step, with the velocities of its end.
struct MovedKnots<'a> {
    start: &'a Knots,
    end: &'a mut Knots,
    inverse_mass: &'a [f64],
    step: f64,
    touched: Vec<usize>,
}

impl NetMotion for MovedKnots<'_> {
    fn position(&self, knot: usize) -> Vector3<f64> {
        self.start.position[knot]
    }

    fn velocity(&self, knot: usize) -> Vector3<f64> {
        self.end.velocity[knot]
    }

    fn velocity_before(&self, knot: usize) -> Vector3<f64> {
        self.start.velocity[knot]
    }

    fn inverse_mass(&self, knot: usize) -> f64 {
        self.inverse_mass[knot]
    }

    fn push(&mut self, knot: usize, impulse: &Vector3<f64>, weight: f64) {
        let change = impulse * (weight * self.inverse_mass[knot]);
        self.end.velocity[knot] += change;
        self.end.position[knot] += change * self.step;
    }

    fn mark(&mut self, knot: usize) {
        self.touched.push(knot);
    }
}
