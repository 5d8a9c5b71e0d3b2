//! Friction in the engine: where it acts, and a coefficient that depends on the sliding speed.
//!
//! A knot is a point that cannot turn, and all impulses on it act at its centre. The engine has friction act where
//! ball and part touch, a radius beside: two surfaces that stick there slide past each other at ω r in the
//! centre, where ω is the target's rate, and friction does work at that speed for as long as it holds. A target of
//! 3.3 kg at 2 rad/s, held by knots of 1 mm with up to 25 N, made 1.2e-2 of the energy at hand within a second, whatever the
//! step. So before every step both sides of a contact are moved to the centre of the ball, along the normal, where
//! neither gap nor normal impulse knows of it.
//!
//! The engine has one coefficient a contact. It becomes that of the law at the speed the knot slides with at the start
//! of the step; within the step the engine's two friction rows stop a slip at most, and never turn it.

use super::KNOTS;
use super::convert::{number, real};
use super::rapier::prelude::{ContactModificationContext, PhysicsHooks};

use crate::friction::Law;

/// Sets place and coefficient of every contact of a step.
pub struct Sliding {
    pub law: Law,
}

impl PhysicsHooks for Sliding {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let bodies = [context.rigid_body1, context.rigid_body2].map(|body| Some(&context.bodies[body?]));
        let [Some(first), Some(second)] = bodies else { return };
        let knot_is_first = context.colliders[context.collider1].collision_groups().memberships == KNOTS;
        let centre = if knot_is_first { first } else { second }.translation();
        let Some(manifold) = context.rigid_mut() else { return };
        for contact in &mut *manifold.solver_contacts {
            let to_centre = centre - if knot_is_first { contact.anchor1 } else { contact.anchor2 };
            contact.anchor1 += to_centre;
            contact.anchor2 += to_centre;
        }
        if let Law::Hollars { .. } = self.law
            && let Some(contact) = manifold.solver_contacts.first()
        {
            let velocity =
                first.velocity_at_point(contact.anchor1) - second.velocity_at_point(contact.anchor2);
            let normal = *manifold.normal;
            let slip = velocity - normal * velocity.dot(normal);
            *manifold.friction = real(self.law.coefficient(number(slip.length())));
        }
    }
}
