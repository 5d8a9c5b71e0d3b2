//! What solver and effects ask for before anything is built.

use crate::friction::Law;
use crate::net::Net;
use crate::solver::{Precision, Solver};
use crate::target::Target;
use crate::world::Setup;

/// What solver and effects ask for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildOptions {
    /// Time step [s].
    pub step: f64,
    /// Sub-steps within a step.
    pub substeps: u32,
    /// Coefficient of restitution of contacts [-].
    pub restitution: f64,
    /// Friction of contacts, where an effect asks for it.
    pub friction: Option<Law>,
    /// Whether the engine answers contacts.
    pub contact_by_engine: bool,
    /// Whether the chaser is a free body.
    pub free_chaser: bool,
    /// Width of the engine's numbers.
    pub precision: Precision,
}

/// What is simulated, for effects that depend on one another's wishes.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    /// The net.
    pub net: &'a Net,
    /// The target, where the scene has one.
    pub target: Option<&'a Target>,
    /// The numerical method.
    pub solver: &'a Solver,
    /// What all effects ask for.
    pub plan: &'a BuildOptions,
    /// Distance from which responses of our own watch the net [m].
    pub reach: f64,
    /// Speed of contact that steps are chosen for [m/s].
    pub contact_speed: f64,
}

impl BuildOptions {
    /// How the engine's world is set up for it.
    pub fn setup(&self) -> Setup {
        Setup {
            step: self.step,
            substeps: self.substeps,
            friction: self.friction,
            has_contacts: self.contact_by_engine,
            precision: self.precision,
        }
    }
}
