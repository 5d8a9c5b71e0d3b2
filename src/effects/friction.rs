//! Coulomb friction between net and target.
//!
//! |f_t| ≤ μ f_n, against the sliding velocity (Section 4.2.2). Solved by the engine as two rows a
//! contact, bounded by μ times the normal impulse of the same sub-step.
//!
//! Friction is internal to net and target: it takes energy out and moves momentum between them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Effect, Posting};
use crate::state::{State, relative_velocity};
use crate::world::Plan;

/// Parameters of friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// The law.
    #[serde(default)]
    pub law: Law,
    /// Coefficient of friction μ [-].
    #[schemars(range(min = 0, max = 10))]
    pub coefficient: f64,
}

/// Friction laws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// One coefficient for sticking and sliding.
    #[default]
    Coulomb,
}

impl Friction {
    /// The effect.
    pub fn build(&self) -> Box<dyn Effect> {
        Box::new(*self)
    }
}

impl Effect for Friction {
    fn name(&self) -> &'static str {
        "friction"
    }

    fn install(&self, plan: &mut Plan) {
        plan.friction = self.coefficient;
    }

    fn installs(&self) -> String {
        format!("two friction rows a contact, coefficient {}", self.coefficient)
    }

    /// W = Σ f_t · (v_knot − v_surface), with velocities averaged over the step: exact for the
    /// knots, whose momentum changes by the impulses of the step.
    fn account(&mut self, before: &State, after: &State) -> Posting {
        let mut posting = Posting::default();
        for contact in &after.contacts {
            posting.work += contact.friction.dot(&relative_velocity(contact, before, after));
            posting.count += u64::from(contact.friction.norm_squared() > 0.0);
        }
        posting
    }
}
