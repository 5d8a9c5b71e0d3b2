//! Contact of whole cables with the target, not of knots alone.
//!
//! Without it a cable goes through the target wherever no knot stops it: over edges, and where
//! the target is smaller than a mesh. The physics stands in [`crate::contact::cables`]. Contacts are
//! answered as the solver's `contact` says, impulses shared by the two end knots:
//!
//! | solver | how |
//! |---|---|
//! | `explicit+impulse`, `explicit+penalty` | in every sub-step, after the cables' pull |
//! | `joints+impulse`, `joints+penalty` | before every step, as threads do |
//! | `joints+rapier` | the same, by our impulses: the engine has no row for two knots and a target |
//!
//! Friction and restitution are those of the knots' contacts. Contact is internal to net and target:
//! what the normal impulses take goes to this effect's row of the ledger, what friction takes to that
//! of friction.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Parameters;
use crate::contact::cables::{CableWatch, Response};
use crate::contact::penalty::Penalty;
use crate::interaction::{ContactLaw, Effect, Interaction, StepObserver};
use crate::options::BuildContext;
use crate::solver::ContactModel;
use crate::state::{Body, Contact, EffectWork, Knots, State};

/// Contact of cables has no parameters of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CableContact {}

impl Parameters for CableContact {
    fn build(&self, context: &BuildContext<'_>) -> Interaction {
        let BuildContext { net, target, solver, options, contact_margin, .. } = *context;
        let response = match solver.contact {
            ContactModel::Penalty => Response::Penalty {
                force: Penalty::new(net, &solver.penalty, None),
                speed: context.contact_speed,
            },
            ContactModel::Rapier | ContactModel::Impulse => {
                Response::Impulse { restitution: solver.restitution }
            }
        };
        let watch = target
            .map(|target| CableWatch::new(net, target, contact_margin, response, options.friction, solver));
        let about = match watch {
            Some(_) => format!("a capsule for each of {} cables, to detect with", net.cables.len()),
            None => "nothing: the scene has no target".to_owned(),
        };
        let step = context.time_step.step;
        Interaction::new("cable_contact", about, Capsules { watch, step, stored: 0.0 }).internal()
    }
}

/// The cables under way.
struct Capsules {
    /// None without a target.
    watch: Option<CableWatch>,
    step: f64,
    /// Energy that it held after the last step [J].
    stored: f64,
}

impl Effect for Capsules {
    fn contacts(&mut self) -> Option<&mut dyn ContactLaw> {
        if self.watch.is_some() { Some(self) } else { None }
    }

    fn observer(&mut self) -> Option<&mut dyn StepObserver> {
        Some(self)
    }
}

impl ContactLaw for Capsules {
    fn solve(&mut self, knots: &mut Knots, target: &mut Option<Body>, step: f64, touched: &mut [bool]) {
        if let (Some(watch), Some(body)) = (&mut self.watch, target) {
            watch.answer(knots, body, step, touched);
        }
    }

    fn report(&self, before: &Knots, after: &Knots, contacts: &mut Vec<Contact>) {
        if let Some(watch) = &self.watch {
            watch.report(before, after, contacts);
        }
    }

    fn detection(&self) -> (usize, u64) {
        self.watch.as_ref().map_or((0, 0), |watch| (watch.n_colliders(), watch.n_detections))
    }
}

impl StepObserver for Capsules {
    fn start_of_step(&mut self, state: &State) {
        if let (Some(watch), Some(body)) = (&mut self.watch, &state.target) {
            watch.look(state, body, self.step);
        }
    }

    fn stored_energy(&self, state: &State) -> f64 {
        let bodies = self.watch.as_ref().zip(state.target.as_ref());
        bodies.map_or(0.0, |(watch, body)| watch.stored_energy(&state.knots, body))
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
