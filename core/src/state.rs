//! The nouns that travel in a step, grouped by the stage that writes them.
//!
//! Everything is in the local frame O-XYZ, SI units.

pub mod body;
pub mod elements;

use std::sync::Arc;

use data_encoding::HEXLOWER;
use nalgebra::Vector3;
use sha2::{Digest, Sha256};

pub use body::{Body, BodyModel, Motion, TARGET, Wrench};
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
            // The first that is not beyond ends it: mostly the first of all.
            let mut along = self.position.iter().map(|p| p[axis]);
            let (low, high) = (body.position[axis] - reach, body.position[axis] + reach);
            along.clone().all(|x| x > high) || along.all(|x| x < low)
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

/// One contact between the net and a part of a body, the same record for every response.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// The knot; where `along` is named, the one at the first end of that cable.
    pub knot: usize,
    /// The place on a cable, where it is not the knot itself that touches.
    pub along: Option<Along>,
    /// The body: [`TARGET`].
    pub body: usize,
    /// Its part.
    pub part: usize,
    /// Where its impulses act: the centre of the knot, which is a point and cannot turn [m].
    pub point: Vector3<f64>,
    /// Unit normal, from the body to the net.
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
    /// Energy that the normal impulse took from net and body [J].
    pub loss: f64,
    /// Energy that friction took from net and body [J].
    pub friction_loss: f64,
}

impl Contact {
    /// Work of the other side's surface [J]: what the net got, and what was lost on the way.
    #[inline]
    pub fn work_of_surface(&self) -> f64 {
        self.work_on_knot + self.loss + self.friction_loss
    }

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
    /// On each body; none where no effect applies any.
    pub on_bodies: Vec<Wrench>,
    /// Where each knot was as its force acted within the step, in the mean [m]; none: in the middle of its way.
    pub acted_at: Vec<Vector3<f64>>,
}

impl Forces {
    /// No force on any of the knots and bodies of `state`.
    pub fn clear(&mut self, state: &State) {
        self.on_knots.clear();
        self.on_knots.resize(state.knots.position.len(), Vector3::zeros());
        self.on_bodies.clear();
        self.on_bodies.resize(state.bodies.len(), Wrench::default());
        self.acted_at.clear();
    }

    /// Hears that for a `share` of the step forces act where knots are now, at `positions` [m]; one below zero takes back.
    pub fn act_at(&mut self, positions: impl ExactSizeIterator<Item = Vector3<f64>>, share: f64) {
        self.acted_at.resize(positions.len(), Vector3::zeros());
        self.acted_at.iter_mut().zip(positions).for_each(|(mean, position)| *mean += share * position);
    }
}

/// What an effect did within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EffectWork {
    /// Work it put into net and target, beyond what it stores [J]; negative when it took energy out.
    pub work: f64,
    /// Of that work, what it cannot have put in, but its method made [J]: counts as created.
    pub made: f64,
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

    /// Written by `cables` (snaps), by `world`, and by effects that bracket a step.
    pub knots: Knots,
    /// Written by `cables` at the start: the elements of the net, where cables are such.
    pub elements: Option<Arc<ElementNet>>,
    /// Written by `cables`, and by effects that kick: the elements' coordinates beyond the knots; a slope times a
    /// length [m].
    pub inner: Knots,
    /// Written by `cables` where there are such: what all coordinates have together.
    pub totals: Option<NetTotals>,
    /// Written by the method where they have a shape, by the simulation where they have none, and by effects that bracket a
    /// step: the target first, where there is one.
    pub bodies: Vec<Body>,
    /// Written at the start: what of them does not change, in the same order.
    pub body_models: Arc<[BodyModel]>,

    /// Written by the method, where it holds them together for a constraint: pairs of knots.
    pub ties: Vec<Tie>,

    /// Written by `contact`: the contacts within the step.
    pub contacts: Vec<Contact>,

    /// Written by `cables`: largest tension of each cable within the step [N].
    pub tension: Vec<f64>,
}

/// Two knots that may not part beyond a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tie {
    /// They.
    pub knots: [usize; 2],
    /// The distance [m].
    pub distance: f64,
}

impl Tie {
    /// How far they are apart [m].
    pub fn apart(&self, knots: &Knots) -> f64 {
        (knots.position[self.knots[1]] - knots.position[self.knots[0]]).norm()
    }

    /// Where it holds them now [m]: what it gave way by it does not take back, and where they come nearer it follows.
    pub fn holds_at(&self, knots: &Knots) -> f64 {
        self.apart(knots).max(self.distance)
    }
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
            knots,
            elements,
            inner,
            totals,
            bodies,
            body_models,
            ties,
            contacts,
            tension,
        } = from;
        (self.step, self.time, self.winch, self.totals) = (*step, *time, *winch, *totals);
        self.forces.on_knots.clone_from(&forces.on_knots);
        self.forces.on_bodies.clone_from(&forces.on_bodies);
        self.knots.clone_from(knots);
        self.elements.clone_from(elements);
        self.inner.clone_from(inner);
        self.bodies.clone_from(bodies);
        self.body_models.clone_from(body_models);
        self.ties.clone_from(ties);
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

    /// The same state with `bodies`, the target first where there is one.
    #[must_use]
    pub fn with_bodies(self, bodies: impl IntoIterator<Item = (BodyModel, Body)>) -> State {
        let (models, bodies): (Vec<BodyModel>, Vec<Body>) = bodies.into_iter().unzip();
        State { bodies, body_models: models.into(), ..self }
    }

    /// The target, where there is one.
    pub fn target(&self) -> Option<&Body> {
        self.body_models.get(TARGET).filter(|model| model.has_shape()).and(self.bodies.get(TARGET))
    }

    /// Where the body of this name is in the list.
    pub fn find_body(&self, name: &str) -> Option<usize> {
        self.body_models.iter().position(|model| model.name == name)
    }

    /// Each body with what does not change of it.
    pub fn each_body(&self) -> impl Iterator<Item = (&BodyModel, &Body)> {
        self.body_models.iter().zip(&self.bodies)
    }

    /// The same, to be moved.
    pub fn each_body_mut(&mut self) -> impl Iterator<Item = (&BodyModel, &mut Body)> {
        self.body_models.iter().zip(&mut self.bodies)
    }

    /// Moves on bodies for `step` seconds: those that have a shape, or those that have none.
    pub fn drift_bodies(&mut self, have_shape: bool, step: f64) {
        for (model, body) in self.each_body_mut().filter(|(model, _)| model.has_shape() == have_shape) {
            model.drift(body, step);
        }
    }

    /// Kinetic energy of those free bodies that have a shape, or of those that have none [J].
    pub fn energy_of_bodies(&self, have_shape: bool) -> f64 {
        let mut energy = 0.0;
        for (model, body) in self.each_body().filter(|(model, _)| model.has_shape() == have_shape) {
            energy += model.kinetic_energy(body);
        }
        energy
    }

    /// First 16 digits of a SHA-256 over time, knots and bodies, to the last bit.
    pub fn hash(&self) -> String {
        let mut hasher = Sha256::new();
        let mut add = |x: &f64| hasher.update(x.to_le_bytes());
        add(&self.time);
        self.knots.position.iter().chain(&self.knots.velocity).for_each(|v| v.iter().for_each(&mut add));
        for Body { position, attitude, velocity, rate } in &self.bodies {
            [position, velocity, rate].iter().for_each(|v| v.iter().for_each(&mut add));
            attitude.coords.iter().for_each(&mut add);
        }
        HEXLOWER.encode(&hasher.finalize()[..8])
    }

    /// The first knot whose position or velocity is not a number.
    pub fn first_bad_knot(&self) -> Option<usize> {
        let mut pairs = self.knots.position.iter().zip(&self.knots.velocity);
        // A sum is a number only of numbers.
        pairs.position(|(position, velocity)| !(position + velocity).sum().is_finite())
    }
}
