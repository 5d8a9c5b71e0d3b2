//! Contacts solved by the engine itself, read back.
//!
//! Within each sub-step the engine solves a non-penetration row a contact (and two friction rows
//! where an effect asks for them) after all cable rows. Contacts are stiff (see
//! [`crate::world::settings`]). Three things are put right after it:
//!
//! 1. **Restitution.** The engine applies it contact by contact, each spoiling the one before: 81 knots
//!    that hit a free plate at once with e = 1 gained 4 % of their energy. So the engine knows no
//!    restitution; contacts that were closing and felt an impulse get the rest of Eq. 4.26 at once, by
//!    the simultaneous impulses of [`super::woodbury`].
//! 2. **Place of friction.** The engine lets friction act where ball and part touch, a radius beside
//!    the centre of the ball. A knot cannot turn, so the moment of that lever was lost: 4e-3 of all
//!    angular momentum on a box that winds the net up. Here all impulses act at the centre of the knot, and
//!    contacts with friction are moved there before the step ([`crate::world`]): what sticks must stick there, too.
//! 3. **Spin.** The engine's gyroscopic term loses angular momentum: 5e-4 of it within a second at
//!    30 rad/s. The impulses say what it must be, and the body turns on with it as
//!    [`BodyModel::drift`] has it: to set the rate alone, in the engine's attitude, cost 1e-3 of the energy
//!    of a body that tumbles about its middle axis for 300 s.

use nalgebra::Vector3;

use super::InverseInertia;
use super::row::{ContactRow, JacobianWeights};
use super::woodbury::Woodbury;
use crate::net::Net;
use crate::state::{Body, BodyModel, Contact, Knots, State, TARGET};
use crate::target::Target;
use crate::world::World;

/// What the engine's contacts need beside the engine.
pub struct EngineContacts {
    /// In the body frame.
    inverse_inertia: InverseInertia,
    target: BodyModel,
    restitution: f64,
    inverse_mass: Vec<f64>,
    radius: Vec<f64>,
    /// Contacts of the step; kept for its memory.
    found: Vec<Contact>,
}

impl EngineContacts {
    /// Contacts of `net` with `target` that bounce with the coefficient `restitution` [-].
    pub fn new(net: &Net, target: &Target, restitution: f64) -> EngineContacts {
        let target = target.model();
        EngineContacts {
            inverse_inertia: InverseInertia::of(&target),
            target,
            restitution,
            inverse_mass: net.mass.iter().map(|mass| 1.0 / mass).collect(),
            radius: net.radius.clone(),
            found: Vec::new(),
        }
    }

    /// After the world moved from `before` to `state` in `step` seconds: what happened at each contact,
    /// added to what happened before within the step, and what the engine left undone.
    pub fn observe(&mut self, world: &mut World, before: &State, state: &mut State, step: f64) {
        let mut found = std::mem::take(&mut self.found);
        world.contacts(&mut found);
        for contact in &mut found {
            contact.point = before.knots.position[contact.knot];
            contact.moment = contact.point.cross(&contact.impulse_on_knot());
        }
        self.settle_spin(world, before, state, &found, step);
        if self.restitution > 0.0 {
            self.bounce(world, before, state, &mut found);
        }
        for contact in &mut found {
            settle_work(contact, before, state);
        }
        state.contacts.extend_from_slice(&found);
        self.found = found;
    }

    /// Gives a free target the angular momentum that impulses left it.
    fn settle_spin(&self, world: &mut World, before: &State, state: &mut State, new: &[Contact], step: f64) {
        if !self.target.is_free() {
            return;
        }
        let (start, body) = (&before.bodies[TARGET], &mut state.bodies[TARGET]);
        let mut momentum = start.angular_momentum(self.target.inertia());
        for contact in new {
            momentum -= (contact.point - start.position).cross(&contact.impulse_on_knot());
        }
        if momentum != Vector3::zeros() {
            // The impulses act at the start of the step; from there the body turns on its own.
            let mut turned =
                Body { rate: self.inverse_inertia.at(start).inverse_inertia * momentum, ..*start };
            self.target.drift(&mut turned, step);
            body.attitude = turned.attitude;
            body.rate = turned.rate;
            world.set_target(body);
        }
    }

    /// Contacts that were closing and felt an impulse part at e times the speed (Eq. 4.11), all at once.
    fn bounce(&self, world: &mut World, before: &State, state: &mut State, new: &mut [Contact]) {
        let (start, mut body) = (&before.bodies[TARGET], state.bodies[TARGET]);
        let (mut rows, of) = self.bouncing(before, start, state, &body, new);
        if rows.is_empty() {
            return;
        }
        let target = self.inverse_inertia.at(&body);
        Woodbury::default().solve(&mut rows, &target, |row| row.wanted_speed - row.speed);
        for (row, index) in rows.iter().zip(of) {
            let (knot, impulse) = (row.weights.first(), row.whole_impulse());
            state.knots.velocity[knot] += row.inverse_mass * impulse;
            target.take(&mut body, &impulse, &row.arm.unwrap_or_default().cross(&impulse));
            world.set_velocity(knot, &state.knots.velocity[knot]);
            let contact = &mut new[index];
            contact.impulse += row.impulse;
            contact.moment += state.knots.position[knot].cross(&impulse);
            contact.point += (row.impulse / contact.impulse) * (state.knots.position[knot] - contact.point);
        }
        if self.target.is_free() {
            world.set_target(&body);
            state.bodies[TARGET] = body;
        }
    }

    /// Rows of the contacts that are to part faster than they do, and which contacts these are.
    fn bouncing(
        &self,
        before: &State,
        start: &Body,
        state: &State,
        body: &Body,
        new: &[Contact],
    ) -> (Vec<ContactRow>, Vec<usize>) {
        let (mut rows, mut of) = (Vec::<ContactRow>::new(), Vec::<usize>::new());
        for (index, contact) in new.iter().enumerate() {
            let knot = contact.knot;
            let speed = |knots: &Knots, body: &Body| {
                contact.normal.dot(&(knots.velocity[knot] - body.velocity_at(knots.position[knot])))
            };
            let (closing, parting) = (speed(&before.knots, start), speed(&state.knots, body));
            let wanted_speed = -self.restitution * closing;
            if contact.impulse <= 0.0 || closing >= 0.0 || wanted_speed - parting <= 0.0 {
                continue;
            }
            let row = ContactRow {
                weights: JacobianWeights::of_knot(knot),
                inverse_mass: self.inverse_mass[knot],
                radius: self.radius[knot],
                normal: contact.normal,
                arm: Some(state.knots.position[knot] - body.position),
                gap: contact.gap,
                velocity: parting * contact.normal,
                speed: parting,
                wanted_speed,
                bounces: true,
                softness: 0.0,
                impulse: 0.0,
                friction: Vector3::zeros(),
            };
            // A knot between two parts: the one it hits harder.
            if let (Some(last), Some(last_of)) = (rows.last_mut(), of.last_mut())
                && row.is_of_the_knot_of(last)
            {
                if wanted_speed - parting > last.wanted_speed - last.speed {
                    (*last, *last_of) = (row, index);
                }
                continue;
            }
            rows.push(row);
            of.push(index);
        }
        (rows, of)
    }
}

/// Work and losses of a contact's impulses. With velocities averaged over the step, impulse times
/// velocity is exactly the change of a knot's kinetic energy.
fn settle_work(contact: &mut Contact, before: &State, after: &State) {
    let surface = |state: &State| state.bodies[contact.body].velocity_at(contact.point);
    let knot = 0.5 * (before.knots.velocity[contact.knot] + after.knots.velocity[contact.knot]);
    let sliding = knot - 0.5 * (surface(before) + surface(after));
    contact.work_on_knot = contact.impulse_on_knot().dot(&knot);
    contact.loss = -contact.impulse * contact.normal.dot(&sliding);
    contact.friction_loss = -contact.friction.dot(&sliding);
}
