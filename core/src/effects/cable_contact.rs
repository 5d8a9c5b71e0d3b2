//! Contact of whole cables with the target, not of knots alone.
//!
//! Without it a cable goes through the target wherever no knot stops it: over edges, and where
//! the target is smaller than a mesh. The physics stands in [`crate::contact::cable_planes`]. Contacts are
//! answered as the solver's `contact` says, impulses shared by the two end knots:
//!
//! | solver | how |
//! |---|---|
//! | `explicit+impulse` | in every sub-step, after the cables' pull, together with those of the knots |
//! | `explicit+penalty` | in every sub-step, after the cables' pull |
//! | `joints+impulse` | before every part of a step, together with those of the knots |
//! | `joints+penalty` | before every step |
//! | `joints+rapier` | before every part of a step, by our impulses: the engine has no row for two knots and a target |
//!
//! Friction and restitution are those of the knots' contacts. Contact is internal to net and target:
//! what the normal impulses take goes to this effect's row of the ledger, what friction takes to that
//! of friction.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Parameters;
use crate::contact::row::{MarkedKnots, RowSource};
use crate::contact::surface::SurfaceContacts;
use crate::interaction::{ContactLaw, Effect, Interaction, StepObserver};
use crate::options::{BuildContext, BuildOptions};
use crate::state::{Body, Contact, EffectWork, Knots, State, TARGET};

/// Contact of cables has no parameters of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CableContact {}

impl Parameters for CableContact {
    fn ask(&self, options: &mut BuildOptions) {
        options.cables_touch = true;
    }

    fn build(&self, context: &BuildContext<'_>) -> Interaction {
        let settings = context.contact_settings();
        let contacts = settings.map(|settings| settings.of_cables());
        let about = match contacts {
            Some(_) => format!("a capsule for each of {} cables, to detect with", context.net.cables.len()),
            None => "nothing: the scene has no target".to_owned(),
        };
        let inverse_mass = context.net.mass.iter().map(|mass| 1.0 / mass).collect();
        let bounces = context.solver.restitution > 0.0;
        let step = context.time_step.step;
        let cables = TouchingCables { contacts, inverse_mass, step, stored: 0.0 };
        Interaction::new("cable_contact", about, cables)
            .internal()
            .bouncing(bounces)
            .sharing_rows(context.cables_share_rows())
    }
}

/// The cables under way.
struct TouchingCables {
    /// None without a target.
    contacts: Option<SurfaceContacts>,
    /// Of each knot [1/kg].
    inverse_mass: Vec<f64>,
    step: f64,
    /// Energy that it held after the last step [J].
    stored: f64,
}

impl Effect for TouchingCables {
    fn contacts(&mut self) -> Option<&mut dyn ContactLaw> {
        if self.contacts.is_some() { Some(self) } else { None }
    }

    fn observer(&mut self) -> Option<&mut dyn StepObserver> {
        Some(self)
    }
}

impl ContactLaw for TouchingCables {
    /// Those of the planes, which stand for the whole step.
    fn knots(&self, _n_knots: usize, knots: &mut Vec<usize>) {
        let bearers = self.contacts.iter().flat_map(SurfaceContacts::bearers);
        knots.extend(bearers);
    }

    fn solve(
        &mut self,
        knots: &mut Knots,
        before: &[Vector3<f64>],
        bodies: &mut [Body],
        step: f64,
        touched: &mut [bool],
    ) {
        let Some(contacts) = &mut self.contacts else { return };
        let mut net = MarkedKnots { knots, before, inverse_mass: &self.inverse_mass, touched };
        contacts.solve(&mut net, &mut bodies[TARGET], step);
    }

    fn rows(&mut self) -> Option<&mut dyn RowSource> {
        self.contacts
            .as_mut()
            .filter(|contacts| !contacts.is_force())
            .map(|contacts| contacts as &mut dyn RowSource)
    }

    fn rollback(&mut self) {
        self.contacts.iter_mut().for_each(SurfaceContacts::forget);
    }

    fn report(&mut self, before: &Knots, after: &Knots, contacts: &mut Vec<Contact>) {
        if let Some(own) = &mut self.contacts {
            own.report(before, after, None, contacts);
        }
    }

    fn detection(&self) -> (usize, u64) {
        self.contacts.as_ref().map_or((0, 0), |own| (own.n_colliders(), own.n_detections))
    }
}

impl StepObserver for TouchingCables {
    fn start_of_step(&mut self, state: &State) {
        if let Some(contacts) = &mut self.contacts {
            contacts.update(state, &state.bodies[TARGET], self.step);
        }
    }

    fn stored_energy(&self, state: &State) -> f64 {
        let contacts = self.contacts.as_ref();
        contacts.map_or(0.0, |contacts| contacts.stored_energy(&state.knots, &state.bodies[TARGET]))
    }

    /// Impulses and moments that a held target passes to the outside are booked with all contacts.
    fn end_of_step(&mut self, _before: &State, after: &State) -> EffectWork {
        let before = self.stored;
        self.stored = self.stored_energy(after);
        let own = || after.contacts.iter().filter(|contact| contact.along.is_some());
        EffectWork {
            work: self.stored - before - own().map(|contact| contact.loss).sum::<f64>(),
            count: own().filter(|contact| contact.impulse > 0.0).count() as u64,
            ..EffectWork::default()
        }
    }
}
