//! What `orbit` and `cabin` have in common: a field that kicks everything free at both ends of a step.
//!
//! The physics stands in [`crate::field`]. To the ledger goes the work of the kicks plus the rise of
//! the stored energy Φ: nothing for a steady field, but for what the step's error is; for one that
//! changes, what the change puts in.

use crate::field::{self, Field, Half, Masses};
use crate::net::Net;
use crate::state::{EffectWork, State};
use crate::target::{Motion, Target};

use super::Effect;

/// An active field.
pub struct Active<F> {
    name: &'static str,
    installs: String,
    field: F,
    masses: Masses,
    /// Φ as last posted [J].
    stored: Option<f64>,
    /// Where the first half of the step ended [s].
    middle: f64,
}

impl<F: Field> Active<F> {
    /// `field` at work on the knots of `net` and on a free `target`.
    pub fn new(
        name: &'static str,
        installs: String,
        field: F,
        net: &Net,
        target: Option<&Target>,
    ) -> Active<F> {
        let free = target.filter(|target| target.motion == Motion::Free);
        let target = free.map(|target| (target.mass, target.inertia));
        let masses = Masses { knots: net.mass.clone(), target };
        Active { name, installs, field, masses, stored: None, middle: 0.0 }
    }
}

impl<F: Field> Effect for Active<F> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn installs(&self) -> String {
        self.installs.clone()
    }

    fn brackets(&self) -> bool {
        true
    }

    fn open(&mut self, state: &mut State, step: f64) -> EffectWork {
        self.stored
            .get_or_insert_with(|| field::stored_energy(&self.field.at(state.time), state, &self.masses));
        self.middle = state.time + 0.5 * step;
        field::kick(&self.field.over(state.time, self.middle), Half::First, state, &self.masses)
    }

    fn close(&mut self, state: &mut State, _step: f64) -> EffectWork {
        let posting =
            field::kick(&self.field.over(self.middle, state.time), Half::Second, state, &self.masses);
        EffectWork { count: self.masses.knots.len() as u64, ..posting }
    }

    fn stored_energy(&self, state: &State) -> f64 {
        field::stored_energy(&self.field.at(state.time), state, &self.masses)
    }

    fn account(&mut self, _before: &State, after: &State) -> EffectWork {
        let now = self.stored_energy(after);
        let rise = now - self.stored.replace(now).unwrap_or(now);
        EffectWork { work: rise, ..EffectWork::default() }
    }
}
