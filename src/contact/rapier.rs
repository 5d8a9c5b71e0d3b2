//! Contacts answered by the engine's own solver.
//!
//! Within each sub-step the engine solves a non-penetration row a contact (and two friction rows
//! where an effect asks for them) after all cable rows. Contacts are stiff (see
//! [`crate::world::settings`]), without restitution in the sub-steps: the engine applies
//! restitution once at the end of a step, contact by contact, not to all contacts at once as
//! Eq. 4.25 does.

use nalgebra::Vector3;

use crate::state::{Contact, Knots, State};
use crate::world::World;

/// After the world moved from `before` to `state`: what happened at each contact, and at those that
/// `others` adds.
pub fn observe(
    world: &World,
    before: &State,
    state: &mut State,
    others: impl FnOnce(&mut Vec<Contact>, &Knots),
) {
    let mut contacts = std::mem::take(&mut state.contacts);
    world.contacts(&mut contacts);
    others(&mut contacts, &state.knots);
    for contact in &mut contacts {
        weigh(contact, before, state);
    }
    state.contacts = contacts;
}

/// Work and losses of a contact's impulses. With velocities averaged over the step, impulse times
/// velocity is exactly the change of a knot's kinetic energy.
fn weigh(contact: &mut Contact, before: &State, after: &State) {
    let surface =
        |state: &State| state.target.map_or(Vector3::zeros(), |body| body.velocity_at(contact.point));
    let knot = 0.5 * (contact.at_place(&before.knots.velocity) + contact.at_place(&after.knots.velocity));
    let sliding = knot - 0.5 * (surface(before) + surface(after));
    contact.work_on_knot = contact.impulse_on_knot().dot(&knot);
    contact.loss = -contact.impulse * contact.normal.dot(&sliding);
    contact.friction_loss = -contact.friction.dot(&sliding);
}
