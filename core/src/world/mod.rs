//! The engine's world behind our words: knots, target, cable joints, contacts.
//!
//! No type of the engine leaves this module. A step writes velocities that snaps changed and forces
//! of effects, lets the engine advance, and reads positions, velocities and contacts back.
//!
//! Two levels of detection (Section 4.5.1): while the box of the net and the box of the target are
//! apart, the knots' colliders are off and the engine detects nothing.
//!
//! The engine comes in two builds, with numbers of 64 and of 32 bits, and the same files (`engine.rs`
//! and those it names) are compiled against both; [`World`] and [`Detector`] hold either. Our side
//! is of 64 bits throughout and converts at the border. 32 bits are for measuring, not for results:
//! a net that flies at 0.05 m/s stands still 1 km from the origin, where a step is less than the last
//! digit (`tests/precision.rs`).

mod double;
#[cfg(feature = "f32")]
mod single;
// Without the feature no scene asks for the narrow build (`scene::checks`).
#[cfg(not(feature = "f32"))]
use double as single;

use nalgebra::Vector3;

use crate::friction::Law;
use crate::net::Net;
use crate::solver::Precision;
use crate::state::{Body, Contact, State};
use crate::target::Target;

pub use double::engine::settings;

/// What the engine's closest points may err [m].
pub const POINT_ERROR: f64 = 1e-5;

/// How the world is set up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setup {
    /// Time step [s].
    pub step: f64,
    /// Friction of contacts, where there is any.
    pub friction: Option<Law>,
    /// Whether the engine finds and answers contacts.
    pub has_contacts: bool,
    /// Width of the engine's numbers.
    pub precision: Precision,
}

/// A spring with a dashpot, in the engine's terms: of its own two ends alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness {
    /// Natural frequency [Hz].
    pub frequency: f64,
    /// Damping ratio [-].
    pub damping_ratio: f64,
}

/// What the world consists of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Census {
    /// Rigid bodies: knots and target.
    pub bodies: usize,
    /// Colliders: of knots (only where there is a target) and of the target's parts.
    pub colliders: usize,
    /// Cable joints.
    pub joints: usize,
}

/// The engine's world.
pub struct World(Engine);

enum Engine {
    Double(Box<double::engine::World>),
    Single(Box<single::engine::World>),
}

/// The same call to whichever build there is.
macro_rules! either {
    ($engines:ident, $holder:expr, $engine:ident => $call:expr) => {
        match $holder {
            $engines::Double($engine) => $call,
            $engines::Single($engine) => $call,
        }
    };
}

impl World {
    /// Knots of `net`, and `target` where the scene has one.
    pub fn new(net: &Net, target: Option<&Target>, setup: &Setup) -> World {
        World(match setup.precision {
            Precision::F64 => Engine::Double(Box::new(double::engine::World::new(net, target, setup))),
            Precision::F32 => Engine::Single(Box::new(single::engine::World::new(net, target, setup))),
        })
    }

    /// Ties two knots by a joint that pulls them together beyond `rest_length` [m] like a spring of
    /// that `softness`, and never pushes.
    ///
    /// Returns its index.
    pub fn tie(&mut self, knots: [usize; 2], rest_length: f64, softness: Softness) -> usize {
        either!(Engine, &mut self.0, engine => engine.tie(knots, rest_length, softness))
    }

    /// Makes joint `index` as soft as that.
    pub fn set_softness(&mut self, index: usize, softness: Softness) {
        either!(Engine, &mut self.0, engine => engine.set_softness(index, softness));
    }

    /// Lets joint `index` pull beyond `rest_length` [m].
    pub fn set_rest_length(&mut self, index: usize, rest_length: f64) {
        either!(Engine, &mut self.0, engine => engine.set_rest_length(index, rest_length));
    }

    /// Lets joint `index` act, or rest.
    pub fn set_acting(&mut self, index: usize, acts: bool) {
        either!(Engine, &mut self.0, engine => engine.set_acting(index, acts));
    }

    /// Impulse with which joint `index` pulled in the last step [N s].
    pub fn impulse_of_joint(&self, index: usize) -> f64 {
        either!(Engine, &self.0, engine => engine.impulse_of_joint(index))
    }

    /// Gives knot `index` a new velocity [m/s].
    pub fn set_velocity(&mut self, index: usize, velocity: &Vector3<f64>) {
        either!(Engine, &mut self.0, engine => engine.set_velocity(index, velocity));
    }

    /// Puts knot `index` elsewhere [m].
    pub fn set_position(&mut self, index: usize, position: &Vector3<f64>) {
        either!(Engine, &mut self.0, engine => engine.set_position(index, position));
    }

    /// Gives the target a new pose and motion.
    pub fn set_target(&mut self, body: &Body) {
        either!(Engine, &mut self.0, engine => engine.set_target(body));
    }

    /// Takes over all positions and velocities of `state`.
    pub fn write(&mut self, state: &State) {
        either!(Engine, &mut self.0, engine => engine.write(state));
    }

    /// Takes over all velocities of `state`.
    pub fn write_velocities(&mut self, state: &State) {
        either!(Engine, &mut self.0, engine => engine.write_velocities(state));
    }

    /// How far from each other the engine sees a knot and a part [m]; 0 without contacts.
    pub fn look_ahead(&self) -> f64 {
        either!(Engine, &self.0, engine => engine.look_ahead())
    }

    /// Whether net and target are out of reach of each other.
    pub fn apart(&self, state: &State) -> bool {
        either!(Engine, &self.0, engine => engine.apart(state))
    }

    /// One step of the engine of `step` seconds from `state`, with `sweeps` sweeps over all rows in each
    /// sub-step; knots and target are then read back.
    pub fn advance(&mut self, state: &mut State, step: f64, sweeps: u32) {
        either!(Engine, &mut self.0, engine => engine.advance(state, step, sweeps));
    }

    /// Copies positions and velocities of knots and target to `state`.
    pub fn read(&self, state: &mut State) {
        either!(Engine, &self.0, engine => engine.read(state));
    }

    /// The contacts of the last step, in the order of knots and parts.
    pub fn contacts(&self, contacts: &mut Vec<Contact>) {
        either!(Engine, &self.0, engine => engine.contacts(contacts));
    }

    /// Whether the engine detects contacts now.
    pub fn detecting(&self) -> bool {
        either!(Engine, &self.0, engine => engine.detecting())
    }

    /// Whether the engine set a body aside because its state is not a number.
    pub fn has_quarantined(&self) -> bool {
        either!(Engine, &self.0, engine => engine.has_quarantined())
    }

    /// What the world consists of.
    pub fn census(&self) -> Census {
        either!(Engine, &self.0, engine => engine.census())
    }
}

/// Contacts from the engine's narrow phase, without its dynamics.
///
/// The solvers of our own ([`crate::contact`]) ask for the contacts at the pose just set; the
/// engine's full step would report gaps at the start of the step, and answer them itself.
pub struct Detector(Finder);

enum Finder {
    Double(Box<double::engine::detector::Detector>),
    Single(Box<single::engine::detector::Detector>),
}

impl Detector {
    /// Finds contacts of `net` with `target`.
    pub fn new(net: &Net, target: &Target, precision: Precision) -> Detector {
        Detector(match precision {
            Precision::F64 => Finder::Double(Box::new(double::engine::detector::Detector::new(net, target))),
            Precision::F32 => Finder::Single(Box::new(single::engine::detector::Detector::new(net, target))),
        })
    }

    /// Contacts whose gap is at most `margin` [m], in the body frame and in the order of knots and parts; the
    /// `renewed` knots, in order, are at new places in that frame [m]. The engine looks at no other again.
    pub fn detect(&mut self, renewed: &[(usize, Vector3<f64>)], margin: f64) -> &[Contact] {
        either!(Finder, &mut self.0, engine => engine.detect(renewed, margin))
    }

    /// Number of colliders.
    pub fn n_colliders(&self) -> usize {
        either!(Finder, &self.0, engine => engine.n_colliders())
    }
}

/// What is found of one cable.
#[derive(Default)]
pub struct CableContacts {
    /// In the order of parts and places; what touches at an end is the knot's business.
    pub touching: Vec<Contact>,
    /// With edges that it may be turned onto within a step: the share of its way is below 0 or above 1 where it would have to be longer.
    pub waiting: Vec<Contact>,
}

impl CableContacts {
    /// Forgets what was found of another.
    pub fn clear(&mut self) {
        self.touching.clear();
        self.waiting.clear();
    }
}

/// Contacts of whole cables: with boxes by formula, in 64 bits, with all else from the same narrow phase.
pub struct CableDetector(CableFinder);

enum CableFinder {
    Double(Box<double::engine::capsules::CableDetector>),
    Single(Box<single::engine::capsules::CableDetector>),
}

impl CableDetector {
    /// Finds contacts of the cables of `net` with `target`.
    pub fn new(net: &Net, target: &Target, precision: Precision) -> CableDetector {
        use {
            double::engine::capsules::CableDetector as Double,
            single::engine::capsules::CableDetector as Single,
        };
        CableDetector(match precision {
            Precision::F64 => CableFinder::Double(Box::new(Double::new(net, target))),
            Precision::F32 => CableFinder::Single(Box::new(Single::new(net, target))),
        })
    }

    /// What is `found` of a cable from one end to another [m] whose gap is at most `margin` [m], all in the body frame.
    pub fn look(&mut self, cable: usize, ends: [Vector3<f64>; 2], margin: f64, found: &mut CableContacts) {
        either!(CableFinder, &mut self.0, engine => engine.look(cable, ends, margin, found));
    }

    /// Number of colliders.
    pub fn n_colliders(&self) -> usize {
        either!(CableFinder, &self.0, engine => engine.n_colliders())
    }
}
