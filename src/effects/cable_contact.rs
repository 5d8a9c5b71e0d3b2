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

use super::{Effect, Parameters};
use crate::contact::cables::{CableWatch, Response};
use crate::contact::penalty::Penalty;
use crate::net::Net;
use crate::options::Setting;
use crate::solver::ContactModel;
use crate::state::{Body, Contact, EffectWork, Knots, State};
use crate::target::Target;

/// Contact of cables has no parameters of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CableContact {}

impl Parameters for CableContact {
    fn build(&self, net: &Net, _target: Option<&Target>) -> Box<dyn Effect> {
        Box::new(Active { watch: None, n_cables: net.cables.len(), step: 0.0, stored: 0.0 })
    }
}

struct Active {
    /// None without a target.
    watch: Option<CableWatch>,
    n_cables: usize,
    step: f64,
    /// Energy that it held after the last step [J].
    stored: f64,
}

impl Effect for Active {
    fn name(&self) -> &'static str {
        "cable_contact"
    }

    fn is_internal(&self) -> bool {
        true
    }

    fn prepare(&mut self, setting: &Setting<'_>) {
        let Setting { net, target, solver, plan, reach, .. } = *setting;
        let Some(target) = target else { return };
        let response = match solver.contact {
            ContactModel::Penalty => Response::Penalty {
                force: Penalty::new(net, &solver.penalty, None),
                speed: setting.contact_speed,
            },
            ContactModel::Rapier | ContactModel::Impulse => {
                Response::Impulse { restitution: plan.restitution }
            }
        };
        self.step = plan.step;
        self.watch = Some(CableWatch::new(net, target, reach, response, plan.friction, solver));
    }

    fn installs(&self) -> String {
        match self.watch {
            Some(_) => format!("a capsule for each of {} cables, to detect with", self.n_cables),
            None => "nothing: the scene has no target".to_owned(),
        }
    }

    fn presses(&self) -> bool {
        self.watch.is_some()
    }

    fn watch(&mut self, state: &State) {
        if let (Some(watch), Some(body)) = (&mut self.watch, &state.target) {
            watch.look(state, body, self.step);
        }
    }

    fn press(&mut self, knots: &mut Knots, target: &mut Option<Body>, step: f64, touched: &mut [bool]) {
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

    fn stored_energy(&self, state: &State) -> f64 {
        let bodies = self.watch.as_ref().zip(state.target.as_ref());
        bodies.map_or(0.0, |(watch, body)| watch.stored_energy(&state.knots, body))
    }

    /// Impulses and moments that a held target passes to the outside are booked with all contacts.
    fn account(&mut self, _before: &State, after: &State) -> EffectWork {
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
