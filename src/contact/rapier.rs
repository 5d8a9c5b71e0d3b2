//! Contacts answered by the engine's own solver.
//!
//! Within each sub-step the engine solves a non-penetration row a contact (and two friction rows
//! where an effect asks for them) after all cable rows. Contacts are stiff (see
//! [`crate::world::settings`]), without restitution in the sub-steps: the engine applies
//! restitution once at the end of a step, contact by contact, not to all contacts at once as
//! Eq. 4.25 does.

use crate::state::State;
use crate::world::World;

/// After the world moved: what happened at each contact.
pub fn observe(world: &World, state: &mut State) {
    world.contacts(&mut state.contacts);
}
