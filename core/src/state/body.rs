//! Rigid bodies: [`BodyModel`] is what does not change in a run, [`Body`] what does.
//!
//! A run has one list of each, in the same order: `State::body_models` and `State::bodies`. A body with a shape is one that
//! the net can touch, and the method of the run moves it within its step: the target, which comes first. All others move
//! on by themselves, and whatever pulls at them does so between these motions.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the target is in the list of bodies, in a run that has one.
pub const TARGET: usize = 0;

/// What the motion of a target answers to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// A free rigid body.
    #[default]
    Free,
    /// Held where it is.
    Fixed,
    /// Held in place, turning at the given rate whatever touches it.
    Spinning,
}

/// Pose and motion of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Centre of mass [m].
    pub position: Vector3<f64>,
    /// Local frame from body frame.
    pub attitude: UnitQuaternion<f64>,
    /// Velocity of the centre of mass [m/s].
    pub velocity: Vector3<f64>,
    /// Angular velocity in the local frame [rad/s].
    pub rate: Vector3<f64>,
}

impl Body {
    /// At rest in the local frame's origin, unturned.
    pub fn at_rest() -> Body {
        let zero = Vector3::zeros();
        Body { position: zero, attitude: UnitQuaternion::identity(), velocity: zero, rate: zero }
    }

    /// The attitude as w, x, y, z.
    pub fn quaternion(&self) -> [f64; 4] {
        let q = self.attitude.quaternion();
        [q.w, q.i, q.j, q.k]
    }

    /// Angular velocity in the body frame [rad/s].
    pub fn spin(&self) -> Vector3<f64> {
        self.attitude.inverse_transform_vector(&self.rate)
    }

    /// `point` in the body frame [m].
    #[inline]
    pub fn to_body(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.attitude.inverse_transform_vector(&(point - self.position))
    }

    /// The same of many points: the turn is made a matrix once.
    pub fn all_to_body(&self) -> impl Fn(&Vector3<f64>) -> Vector3<f64> + use<> {
        let (turn, position) = (self.attitude.to_rotation_matrix(), self.position);
        move |point| turn.inverse_transform_vector(&(point - position))
    }

    /// A point of the body frame, where it is now [m].
    #[inline]
    pub fn to_local(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.position + self.attitude * point
    }

    /// Velocity of the material point at `point` [m/s].
    #[inline]
    pub fn velocity_at(&self, point: Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.rate.cross(&(point - self.position))
    }

    /// Angular momentum about the centre of mass, local frame [kg m^2/s].
    ///
    /// `inertia` is in the body frame [kg m^2].
    pub fn angular_momentum(&self, inertia: &Matrix3<f64>) -> Vector3<f64> {
        self.attitude * (inertia * self.spin())
    }

    /// Kinetic energy [J].
    pub fn kinetic_energy(&self, mass: f64, inertia: &Matrix3<f64>) -> f64 {
        let spin = self.spin();
        0.5 * mass * self.velocity.norm_squared() + 0.5 * spin.dot(&(inertia * spin))
    }

    /// Whether pose and motion are numbers.
    pub fn is_sound(&self) -> bool {
        let numbers = self.position.iter().chain(self.velocity.iter()).chain(self.rate.iter());
        numbers.chain(self.attitude.coords.iter()).all(|x| x.is_finite())
    }
}

/// What of a body does not change in a run.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyModel {
    /// Its name, which no other in the run has.
    pub name: String,
    /// What its motion answers to.
    pub motion: Motion,
    /// Mass [kg].
    pub mass: f64,
    inertia: Matrix3<f64>,
    inverse_inertia: Matrix3<f64>,
    /// Where a tether leaves it, body frame [m].
    pub port: Vector3<f64>,
    has_shape: bool,
}

impl BodyModel {
    /// A body that moves as `motion` says, of `mass` [kg] and of `inertia` in its own frame [kg m^2], positive definite;
    /// without a shape.
    pub fn new(name: impl Into<String>, motion: Motion, mass: f64, inertia: Matrix3<f64>) -> BodyModel {
        BodyModel {
            name: name.into(),
            motion,
            mass,
            inertia,
            inverse_inertia: inertia.try_inverse().unwrap_or_default(),
            port: Vector3::zeros(),
            has_shape: false,
        }
    }

    /// The same where a tether leaves it at `port`, in the body frame [m].
    #[must_use]
    pub fn with_port(self, port: Vector3<f64>) -> BodyModel {
        BodyModel { port, ..self }
    }

    /// The same with a shape; only methods that know it touch and move it.
    pub(crate) fn with_shape(self) -> BodyModel {
        BodyModel { has_shape: true, ..self }
    }

    /// Inertia about the centre of mass, body frame [kg m^2].
    pub fn inertia(&self) -> &Matrix3<f64> {
        &self.inertia
    }

    /// Whether the net can touch it: then the method of the run moves it.
    pub fn has_shape(&self) -> bool {
        self.has_shape
    }

    /// Whether it answers impulses.
    pub fn is_free(&self) -> bool {
        self.motion == Motion::Free
    }

    /// Moves `body` on for `step` seconds, in which nothing acts on it.
    ///
    /// Free: momentum and angular momentum L are constant and ω = I⁻¹ L follows the attitude. The turn R(t+h) = exp(θ) R(t) of a step is
    /// that of the Runge-Kutta method of fourth order on rotations (Munthe-Kaas 1999), with L kept to rounding. With ω at the middle of
    /// the step instead, of second order, a target that tumbles at 17 rad/s made 1e-3 of its energy in 1.2 s of steps of 0.5 ms.
    pub fn drift(&self, body: &mut Body, step: f64) {
        if self.motion == Motion::Fixed {
            return;
        }
        body.position += step * body.velocity;
        if body.rate.norm_squared() == 0.0 {
            return;
        }
        if self.motion == Motion::Spinning {
            body.attitude = UnitQuaternion::from_scaled_axis(step * body.rate) * body.attitude;
            return;
        }
        let momentum = body.angular_momentum(&self.inertia);
        let rate_at = |attitude: &UnitQuaternion<f64>| {
            attitude * (self.inverse_inertia * attitude.inverse_transform_vector(&momentum))
        };
        let start = body.attitude;
        let turned = |turn: Vector3<f64>| UnitQuaternion::from_scaled_axis(turn) * start;
        let first = step * body.rate;
        let second = step * rate_at(&turned(0.5 * first));
        let third = step * rate_at(&turned(0.5 * second - 0.125 * first.cross(&second)));
        let fourth = step * rate_at(&turned(third));
        let turned = turned((first + 2.0 * (second + third) + fourth - 0.5 * first.cross(&fourth)) / 6.0);
        body.attitude = UnitQuaternion::new_normalize(turned.into_inner());
        body.rate = rate_at(&body.attitude);
    }

    /// Gives a free `body` an impulse [N s] and an angular impulse about its centre of mass [N m s]; the change of its
    /// energy [J]. One that is held takes none.
    pub fn push(&self, body: &mut Body, impulse: &Vector3<f64>, angular_impulse: &Vector3<f64>) -> f64 {
        if !self.is_free() {
            return 0.0;
        }
        let before = self.kinetic_energy(body);
        body.velocity += impulse / self.mass;
        let in_body = body.attitude.inverse_transform_vector(angular_impulse);
        body.rate += body.attitude * (self.inverse_inertia * in_body);
        self.kinetic_energy(body) - before
    }

    /// Kinetic energy of `body` [J]; none where it is held: that is its drive's business.
    pub fn kinetic_energy(&self, body: &Body) -> f64 {
        if self.is_free() { body.kinetic_energy(self.mass, &self.inertia) } else { 0.0 }
    }

    /// Linear momentum of a free `body` [kg m/s].
    pub fn momentum(&self, body: &Body) -> Vector3<f64> {
        if self.is_free() { self.mass * body.velocity } else { Vector3::zeros() }
    }

    /// Angular momentum of a free `body` about the origin [kg m^2/s].
    pub fn angular_momentum(&self, body: &Body) -> Vector3<f64> {
        if !self.is_free() {
            return Vector3::zeros();
        }
        self.mass * body.position.cross(&body.velocity) + body.angular_momentum(&self.inertia)
    }

    /// Corners of the solid block that has its mass and inertia, in the body frame [m]: corner 1 beside corner 0 along x,
    /// 2 along y, 4 along z.
    pub fn corners(&self) -> [Vector3<f64>; 8] {
        // I_x = m (b² + c²) / 12, so b² + c² − … = 6 (I_y + I_z − I_x) / m is the square of a.
        let moments = self.inertia.diagonal();
        let half = moments
            .map(|moment| (0.5 * moments.sum() - moment).max(0.0) * 12.0 / self.mass)
            .map(|square| 0.5 * square.sqrt());
        std::array::from_fn(|corner| {
            let side = |axis: usize| if corner >> axis & 1 == 1 { half[axis] } else { -half[axis] };
            Vector3::new(side(0), side(1), side(2))
        })
    }
}

/// A force and a torque on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Force at its centre of mass [N].
    pub force: Vector3<f64>,
    /// Torque about its centre of mass [N m].
    pub torque: Vector3<f64>,
}

impl Wrench {
    /// Adds a force [N] that acts at `arm` from the centre of mass [m].
    pub fn add_at(&mut self, force: &Vector3<f64>, arm: &Vector3<f64>) {
        self.force += force;
        self.torque += arm.cross(force);
    }
}

impl std::ops::AddAssign for Wrench {
    fn add_assign(&mut self, other: Wrench) {
        self.force += other.force;
        self.torque += other.torque;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body tumbling about its middle axis flips, with momentum to rounding and energy to the step's order.
    #[test]
    fn a_body_tumbling_about_its_middle_axis_flips() {
        let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0));
        let model = BodyModel::new("body", Motion::Free, 1.0, inertia);
        let mut body = Body { rate: Vector3::new(1e-3, 1.0, 0.0), ..Body::at_rest() };
        let (momentum, energy) = (model.angular_momentum(&body), model.kinetic_energy(&body));
        let mut flipped = false;
        for _ in 0..300_000 {
            model.drift(&mut body, 1e-3);
            flipped |= body.spin().y < -0.9;
        }
        assert!(flipped);
        let drift = (model.angular_momentum(&body) - momentum).norm() / momentum.norm();
        assert!(drift < 1e-9, "{drift:e}"); // measured 1.2e-10, rounding of 300 000 steps
        let gain = (model.kinetic_energy(&body) / energy - 1.0).abs();
        assert!(gain < 1e-9, "{gain:e}");
    }

    /// Half the step, a sixteenth of the error; and little energy is made by a fast tumble.
    #[test]
    fn a_tumble_is_of_fourth_order() {
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.02, 0.05, 0.06));
        let model = BodyModel::new("body", Motion::Free, 1.0, inertia);
        let start = Body { rate: Vector3::new(4.5, -7.3, -15.5), ..Body::at_rest() };
        let end = |n: u32| {
            let mut body = start;
            (0..n).for_each(|_| model.drift(&mut body, 1.2 / f64::from(n)));
            body
        };
        let fine = end(50_000);
        let errors = [300, 600, 1200].map(|n| end(n).attitude.angle_to(&fine.attitude));
        println!("{errors:?}");
        for pair in errors.windows(2) {
            assert!((12.0..20.0).contains(&(pair[0] / pair[1])), "{errors:?}");
        }
        let gain = (model.kinetic_energy(&end(2400)) / model.kinetic_energy(&start) - 1.0).abs();
        assert!(gain < 1e-7, "{gain:e}");
    }

    /// A push gives the energy it says, and nothing to what is held.
    #[test]
    fn a_push_gives_momentum_and_energy_to_what_is_free() {
        let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0));
        let start = Body {
            position: Vector3::new(1.0, -2.0, 0.5),
            attitude: UnitQuaternion::from_euler_angles(0.3, -0.5, 1.0),
            velocity: Vector3::new(0.1, 0.2, -0.3),
            rate: Vector3::new(0.4, -0.1, 0.2),
        };
        let (impulse, turn) = (Vector3::new(0.3, -1.0, 0.2), Vector3::new(-0.2, 0.1, 0.7));
        let free = BodyModel::new("free", Motion::Free, 4.0, inertia);
        let mut body = start;
        let work = free.push(&mut body, &impulse, &turn);
        let gain = free.kinetic_energy(&body) - free.kinetic_energy(&start);
        assert!((work - gain).abs() < 1e-15, "{work} {gain}");
        assert!((free.momentum(&body) - free.momentum(&start) - impulse).norm() < 1e-15);
        let moment = start.position.cross(&impulse) + turn;
        let change = free.angular_momentum(&body) - free.angular_momentum(&start);
        assert!((change - moment).norm() < 1e-14, "{change} {moment}");
        for motion in [Motion::Fixed, Motion::Spinning] {
            let held = BodyModel::new("held", motion, 4.0, inertia);
            let mut body = start;
            assert_eq!((held.push(&mut body, &impulse, &turn), body), (0.0, start));
        }
    }
}
