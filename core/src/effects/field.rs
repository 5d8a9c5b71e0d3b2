//! What `orbit` and `cabin` have in common: a field that kicks everything free at both ends of a step.
//!
//! The physics stands in [`crate::field`]. To the ledger goes the work of the kicks plus the rise of
//! the stored energy Φ: nothing for a steady field, but for what the step's error is; for one that
//! changes, what the change puts in.

use crate::field::{self, Field};
use crate::interaction::{Effect, Half, HalfKick, Interaction, StepObserver};
use crate::options::BuildContext;
use crate::state::{EffectWork, State};

/// An active field.
pub struct Active<F> {
    field: F,
    /// Of the knots [kg].
    net_mass: Vec<f64>,
    /// Φ as last posted [J].
    stored: Option<f64>,
    /// Where the first half of the step ended [s].
    middle: f64,
    /// Whether there is anything to feel: a cabin at rest without gravity is as good as none.
    acts: bool,
}

impl<F: Field + 'static> Active<F> {
    /// `field` at work on the knots of the net and on free bodies.
    pub fn on(context: &BuildContext<'_>, name: &'static str, about: String, field: F) -> Interaction {
        let net_mass = context.net.mass.clone();
        let acts = context.options.has_fields;
        Interaction::new(name, about, Active { field, net_mass, stored: None, middle: 0.0, acts })
    }
}

impl<F: Field> Effect for Active<F> {
    fn half_kick(&mut self) -> Option<&mut dyn HalfKick> {
        Some(self)
    }

    fn observer(&mut self) -> Option<&mut dyn StepObserver> {
        Some(self)
    }
}

impl<F: Field> HalfKick for Active<F> {
    fn kick(&mut self, state: &mut State, step: f64, half: Half) -> EffectWork {
        let span = match half {
            Half::First => {
                self.stored.get_or_insert_with(|| {
                    field::stored_energy(&self.field.at(state.time), state, &self.net_mass)
                });
                self.middle = state.time + 0.5 * step;
                self.field.over(state.time, self.middle)
            }
            Half::Second => self.field.over(self.middle, state.time),
        };
        let work = field::kick(&span, half, state, &self.net_mass);
        match half {
            Half::First => work,
            Half::Second => EffectWork { count: self.net_mass.len() as u64, ..work },
        }
    }

    fn kicks_knots(&self) -> bool {
        self.acts
    }

    fn kicks_elements(&self) -> bool {
        true
    }
}

impl<F: Field> StepObserver for Active<F> {
    fn stored_energy(&self, state: &State) -> f64 {
        field::stored_energy(&self.field.at(state.time), state, &self.net_mass)
    }

    fn end_of_step(&mut self, _before: &State, after: &State) -> EffectWork {
        let now = self.stored_energy(after);
        let rise = now - self.stored.replace(now).unwrap_or(now);
        EffectWork { work: rise, ..EffectWork::default() }
    }
}
