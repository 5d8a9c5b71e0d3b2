//! The nouns that travel in a step, grouped by the stage that writes them.
//!
//! Everything is in the local frame O-XYZ, SI units.

pub mod elements;

use std::sync::Arc;

use data_encoding::HEXLOWER;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use sha2::{Digest, Sha256};

use elements::ElementNet;

/// Positions and velocities of the knots, K entries each.
#[derive(Debug, Default, PartialEq)]
pub struct Knots {
    /// [m]
    pub position: Vec<Vector3<f64>>,
    /// [m/s]
    pub velocity: Vec<Vector3<f64>>,
}

impl Clone for Knots {
    fn clone(&self) -> Knots {
        Knots { position: self.position.clone(), velocity: self.velocity.clone() }
    }

    /// A derived one would ask for new memory.
    fn clone_from(&mut self, from: &Knots) {
        self.position.clone_from(&from.position);
        self.velocity.clone_from(&from.velocity);
    }
}

impl Knots {
    /// Whether their box is farther than `reach` [m] from the body's centre along some axis.
    pub fn apart_from(&self, body: &Body, reach: f64) -> bool {
        (0..3).any(|axis| {
            let along = || self.position.iter().map(|p| p[axis]);
            along().fold(f64::INFINITY, f64::min) > body.position[axis] + reach
                || along().fold(f64::NEG_INFINITY, f64::max) < body.position[axis] - reach
        })
    }
}

/// Energies and momenta of a net whose cables have more coordinates than their knots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NetTotals {
    /// Kinetic energy [J].
    pub kinetic: f64,
    /// Elastic energy [J].
    pub elastic: f64,
    /// Linear momentum [kg m/s].
    pub momentum: Vector3<f64>,
    /// Angular momentum about the origin [kg m^2/s].
    pub angular_momentum: Vector3<f64>,
}

/// Pose and motion of the target.
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
}

/// A free body that brings its own mass along: the chaser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeBody {
    /// Pose and motion.
    pub body: Body,
    /// Mass [kg].
    pub mass: f64,
    /// Inertia about the centre of mass, body frame [kg m^2].
    pub inertia: Matrix3<f64>,
    /// Where a tether leaves it, body frame [m].
    pub port: Vector3<f64>,
}

impl FreeBody {
    /// Where a tether leaves it [m].
    pub fn port(&self) -> Vector3<f64> {
        self.body.position + self.body.attitude * self.port
    }

    /// Corners of the solid block that has its mass and inertia, at the pose of `body` [m]: corner 1 beside
    /// corner 0 along x, 2 along y, 4 along z.
    pub fn corners(&self, body: &Body) -> [Vector3<f64>; 8] {
        // I_x = m (b² + c²) / 12, so b² + c² − … = 6 (I_y + I_z − I_x) / m is the square of a.
        let moments = self.inertia.diagonal();
        let half = moments
            .map(|moment| (0.5 * moments.sum() - moment).max(0.0) * 12.0 / self.mass)
            .map(|square| 0.5 * square.sqrt());
        std::array::from_fn(|corner| {
            let side = |axis: usize| if corner >> axis & 1 == 1 { half[axis] } else { -half[axis] };
            body.position + body.attitude * Vector3::new(side(0), side(1), side(2))
        })
    }

    /// Takes an impulse [N s] and its moment about the origin [N m s].
    pub fn push(&mut self, impulse: &Vector3<f64>, moment: &Vector3<f64>) {
        let about_centre =
            self.body.attitude.inverse_transform_vector(&(moment - self.body.position.cross(impulse)));
        self.body.velocity += impulse / self.mass;
        // A checked inertia is positive definite.
        let change = self.inertia.try_inverse().unwrap_or_default() * about_centre;
        self.body.rate += self.body.attitude * change;
    }

    /// Kinetic energy [J].
    pub fn kinetic_energy(&self) -> f64 {
        self.body.kinetic_energy(self.mass, &self.inertia)
    }

    /// Linear momentum [kg m/s].
    pub fn momentum(&self) -> Vector3<f64> {
        self.mass * self.body.velocity
    }

    /// Angular momentum about the origin [kg m^2/s].
    pub fn angular_momentum(&self) -> Vector3<f64> {
        self.body.position.cross(&self.momentum()) + self.body.angular_momentum(&self.inertia)
    }
}

/// A place along a cable.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Along {
    /// The cable.
    pub cable: usize,
    /// The knot at its other end.
    pub end: usize,
    /// Share of the way to that end [-].
    pub share: f64,
}

/// One contact between the net and a part of the target, the same record for every response.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// The knot; where `along` is named, the one at the first end of that cable.
    pub knot: usize,
    /// The place on a cable, where it is not the knot itself that touches.
    pub along: Option<Along>,
    /// The part of the target.
    pub part: usize,
    /// Where its impulses act: the centre of the knot, which is a point and cannot turn [m].
    pub point: Vector3<f64>,
    /// Unit normal, from the target to the net.
    pub normal: Vector3<f64>,
    /// Least distance of their surfaces at the start of the step and its sub-steps; negative when they
    /// overlap [m].
    pub gap: f64,
    /// Impulse on the net along the normal within the step [N s].
    pub impulse: f64,
    /// Impulse on the net across the normal within the step [N s].
    pub friction: Vector3<f64>,
    /// Largest normal force within the step, where contact is a force [N]; 0 where it is an impulse.
    pub force: f64,
    /// Energy that a contact force holds at the end of the step [J].
    pub stored: f64,
    /// Moment of both about the origin [N m s].
    pub moment: Vector3<f64>,
    /// Work of both on the net [J].
    pub work_on_knot: f64,
    /// Energy that the normal impulse took from net and target [J].
    pub loss: f64,
    /// Energy that friction took from net and target [J].
    pub friction_loss: f64,
}

impl Contact {
    /// Knots that bear it, each with its weight: of a place on a cable both ends.
    #[inline]
    pub fn bearers(&self) -> [(usize, f64); 2] {
        match self.along {
            None => [(self.knot, 1.0), (self.knot, 0.0)],
            Some(Along { end, share, .. }) => [(self.knot, 1.0 - share), (end, share)],
        }
    }

    /// What the knots' `values` are at the place of contact, as a weighted mean.
    #[inline]
    pub fn at_place(&self, values: &[Vector3<f64>]) -> Vector3<f64> {
        match self.along {
            None => values[self.knot],
            Some(Along { end, share, .. }) => (1.0 - share) * values[self.knot] + share * values[end],
        }
    }

    /// Whole impulse on the knot, or on both ends of the cable together [N s].
    pub fn impulse_on_knot(&self) -> Vector3<f64> {
        self.impulse * self.normal + self.friction
    }
}

/// Forces that effects apply over a step: on knots as they are, in every sub-step; on bodies as an impulse at
/// its start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces {
    /// On each knot [N]; none where no effect applies any.
    pub on_knots: Vec<Vector3<f64>>,
    /// On the target.
    pub on_target: Wrench,
    /// On a free chaser.
    pub on_chaser: Wrench,
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

impl Forces {
    /// No force on any of `n_knots` knots, nor on a body.
    pub fn clear(&mut self, n_knots: usize) {
        self.on_knots.clear();
        self.on_knots.resize(n_knots, Vector3::zeros());
        (self.on_target, self.on_chaser) = Default::default();
    }
}

/// What an effect did within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EffectWork {
    /// Work it put into net and target, beyond what it stores [J]; negative when it took energy out.
    pub work: f64,
    /// What its drives put in and it kept for good [J]: its own friction. With the work that is what came from outside.
    pub lost: f64,
    /// Work of the impulses that it gave to knots by pulling [J]; that of its forces is known.
    pub on_knots: f64,
    /// Impulse from outside of net and target [N s].
    pub impulse: Vector3<f64>,
    /// Angular impulse from outside, about the origin [N m s].
    pub angular_impulse: Vector3<f64>,
    /// Times it acted: contacts, knots or whatever it works on.
    pub count: u64,
}

/// What winches are told from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WinchCommand {
    /// Whether they start now, if nothing has started them yet.
    pub start: bool,
    /// Speed at which each reels in, at most [m/s].
    pub reel_speed: f64,
    /// Largest tension of a thread [N].
    pub max_tension: f64,
}

/// All of it.
#[derive(Debug, Default, PartialEq)]
pub struct State {
    /// Steps done.
    pub step: u64,
    /// Simulated time [s].
    pub time: f64,

    /// Written by `effects`.
    pub forces: Forces,
    /// Written from outside, between two steps; none: winches do what the scene says.
    pub winch: Option<WinchCommand>,
    /// Written by the effect `chaser`.
    pub chaser: Option<FreeBody>,

    /// Written by `cables` (snaps), by `world`, and by effects that bracket a step.
    pub knots: Knots,
    /// Written by `cables` at the start: the elements of the net, where cables are such.
    pub elements: Option<Arc<ElementNet>>,
    /// Written by `cables`, and by effects that kick: the elements' coordinates beyond the knots; a slope times a
    /// length [m].
    pub inner: Knots,
    /// Written by `cables` where there are such: what all coordinates have together.
    pub totals: Option<NetTotals>,
    /// Written by `world`.
    pub target: Option<Body>,

    /// Written by `contact`: the contacts within the step.
    pub contacts: Vec<Contact>,

    /// Written by `cables`: largest tension of each cable within the step [N].
    pub tension: Vec<f64>,
}

impl Clone for State {
    fn clone(&self) -> State {
        let mut copy = State::default();
        copy.clone_from(self);
        copy
    }

    /// In place: it is called at every step, and a derived one would ask for new memory.
    fn clone_from(&mut self, from: &State) {
        let State {
            step,
            time,
            forces,
            winch,
            chaser,
            knots,
            elements,
            inner,
            totals,
            target,
            contacts,
            tension,
        } = from;
        (self.step, self.time, self.winch, self.chaser) = (*step, *time, *winch, *chaser);
        (self.totals, self.target) = (*totals, *target);
        self.forces.on_knots.clone_from(&forces.on_knots);
        (self.forces.on_target, self.forces.on_chaser) = (forces.on_target, forces.on_chaser);
        self.knots.clone_from(knots);
        self.elements.clone_from(elements);
        self.inner.clone_from(inner);
        self.contacts.clone_from(contacts);
        self.tension.clone_from(tension);
    }
}

impl State {
    /// Kinetic energy and momenta of the elements anew, where the net has any, after their velocities changed.
    pub fn renew_totals(&mut self) {
        if let Some(elements) = &self.elements {
            let elastic = self.totals.map_or(0.0, |totals| totals.elastic);
            self.totals = Some(NetTotals { elastic, ..elements.motion(&self.knots, &self.inner) });
        }
    }

    /// First 16 digits of a SHA-256 over time, knots and target, to the last bit.
    pub fn hash(&self) -> String {
        let mut hasher = Sha256::new();
        let mut add = |x: &f64| hasher.update(x.to_le_bytes());
        add(&self.time);
        self.knots.position.iter().chain(&self.knots.velocity).for_each(|v| v.iter().for_each(&mut add));
        if let Some(Body { position, attitude, velocity, rate }) = &self.target {
            [position, velocity, rate].iter().for_each(|v| v.iter().for_each(&mut add));
            attitude.coords.iter().for_each(&mut add);
        }
        HEXLOWER.encode(&hasher.finalize()[..8])
    }

    /// The first knot whose position or velocity is not a number.
    pub fn first_bad_knot(&self) -> Option<usize> {
        let sound = |v: &Vector3<f64>| v.iter().all(|x| x.is_finite());
        let mut pairs = self.knots.position.iter().zip(&self.knots.velocity);
        pairs.position(|(position, velocity)| !sound(position) || !sound(velocity))
    }

    /// Whether pose and motion of target and chaser are numbers.
    pub fn bodies_are_sound(&self) -> bool {
        let chaser = self.chaser.map(|chaser| chaser.body);
        self.target.iter().chain(&chaser).all(|body| {
            let numbers = body.position.iter().chain(body.velocity.iter()).chain(body.rate.iter());
            numbers.chain(body.attitude.coords.iter()).all(|x| x.is_finite())
        })
    }
}
