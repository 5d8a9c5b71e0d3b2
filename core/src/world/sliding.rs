//! A friction coefficient that depends on the sliding speed, in the engine.
//!
//! The engine has one coefficient a contact, but asks before every step whether it is to be
//! changed. It becomes that of the law at the speed the knot slides with at the start of the step;
//! within the step the engine's two friction rows stop a slip at most, and never turn it.

use super::convert::{number, real};
use super::rapier::prelude::{ContactModificationContext, PhysicsHooks};

use crate::friction::Law;

/// Sets the coefficient of every contact of a step.
pub struct Sliding {
    pub law: Law,
}

impl PhysicsHooks for Sliding {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let bodies = [context.rigid_body1, context.rigid_body2].map(|body| Some(&context.bodies[body?]));
        let [Some(first), Some(second)] = bodies else { return };
        let Some(manifold) = context.rigid_mut() else { return };
        let Some(contact) = manifold.solver_contacts.first() else { return };
        let velocity = first.velocity_at_point(contact.anchor1) - second.velocity_at_point(contact.anchor2);
        let normal = *manifold.normal;
        let slip = velocity - normal * velocity.dot(normal);
        *manifold.friction = real(self.law.coefficient(number(slip.length())));
    }
}
