//! What solver and effects ask for before anything is built.

use crate::contact::friction::Law;
use crate::solver::Precision;
use crate::world::Setup;

/// What solver and effects ask for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
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
    /// Width of the engine's numbers.
    pub precision: Precision,
}

impl Plan {
    /// How the engine's world is set up for it. The engine knows Coulomb's law alone; the checks
    /// have refused another.
    pub fn setup(&self) -> Setup {
        Setup {
            step: self.step,
            substeps: self.substeps,
            friction: self.friction.map_or(0.0, |law| law.coefficient(f64::INFINITY)),
            has_contacts: self.contact_by_engine,
            precision: self.precision,
        }
    }
}
