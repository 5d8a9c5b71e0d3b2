//! Friction between net and target (Section 4.2.2).
//!
//! |f_t| ≤ μ f_n, against the sliding velocity, by Coulomb's law or Hollars' (Eq. 4.6), at contacts of
//! knots and, where the scene has them, of cables. The engine solves it as two rows a contact,
//! bounded by μ times the normal impulse of the same sub-step, with Hollars' μ taken at the speed
//! of sliding at the start of the step; ours apply it after the normal impulses.
//!
//! Friction is internal to net and target: it takes energy out and moves momentum between them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Parameters;
use crate::friction;
use crate::interaction::{Effect, Interaction, StepObserver};
use crate::options::{BuildContext, BuildOptions};
use crate::quantity::Positive;
use crate::state::{EffectWork, State};

/// Parameters of friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// The law.
    #[serde(default)]
    pub law: FrictionLaw,
    /// Coefficient of friction μ; of sliding, μ_k, with `hollars` [-].
    #[schemars(range(min = 0, max = 10))]
    pub coefficient: f64,
    /// `hollars`: coefficient of sticking μ_s; left out: that of sliding [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 10))]
    pub static_coefficient: Option<f64>,
    /// `hollars`: transition speed v_t0 [m/s].
    #[serde(default = "Friction::default_transition_speed")]
    pub transition_speed_m_s: Positive,
}

/// Friction laws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FrictionLaw {
    /// One coefficient for sticking and sliding.
    #[default]
    Coulomb,
    /// Eq. 4.6.
    Hollars,
}

impl Friction {
    fn default_transition_speed() -> Positive {
        Positive(0.01)
    }

    /// The law that a contact response applies.
    pub fn contact_law(&self) -> friction::Law {
        match self.law {
            FrictionLaw::Coulomb => friction::Law::Coulomb { coefficient: self.coefficient },
            FrictionLaw::Hollars => friction::Law::Hollars {
                kinetic: self.coefficient,
                static_: self.static_coefficient.unwrap_or(self.coefficient),
                transition_speed: self.transition_speed_m_s.0,
            },
        }
    }
}

impl Parameters for Friction {
    fn ask(&self, options: &mut BuildOptions) {
        // One that never acts is as good as none, and leaves the engine as it is.
        options.friction = Some(self.contact_law()).filter(friction::Law::acts);
    }

    fn build(&self, _context: &BuildContext<'_>) -> Interaction {
        let about = format!("friction at every contact, coefficient {}", self.coefficient);
        Interaction::new("friction", about, *self).internal()
    }
}

impl Effect for Friction {
    fn observer(&mut self) -> Option<&mut dyn StepObserver> {
        Some(self)
    }
}

impl StepObserver for Friction {
    fn end_of_step(&mut self, _before: &State, after: &State) -> EffectWork {
        let rubbing = after.contacts.iter().filter(|contact| contact.friction.norm_squared() > 0.0);
        EffectWork {
            work: -after.contacts.iter().map(|contact| contact.friction_loss).sum::<f64>(),
            count: rubbing.count() as u64,
            ..EffectWork::default()
        }
    }
}
