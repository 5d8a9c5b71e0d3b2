//! Contact of the net with itself (Section 6.3, item 5): cables and bullets against each other.
//!
//! The physics stands in [`crate::contact::pairs`]. It is frictionless: a cable of ours cannot bear the
//! moment that friction between two of them would put on it. Internal to the net: it takes energy
//! out and moves momentum between knots.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Effect, Parameters};
use crate::contact::pairs::{PairWatch, bullet_radius};
use crate::net::Net;
use crate::quantity::Positive;
use crate::state::{Body, EffectWork, Knots, State};
use crate::target::Target;

/// Parameters of self contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SelfContact {
    /// Coefficient of restitution [-].
    #[serde(default)]
    #[schemars(range(min = 0, max = 1))]
    pub restitution: f64,
    /// Radius of a bullet [m]; left out: that of a steel ball of its mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bullet_radius_m: Option<Positive>,
}

impl Parameters for SelfContact {
    fn build(&self, net: &Net, _target: Option<&Target>) -> Box<dyn Effect> {
        let bullet_radius = self.bullet_radius_m.map_or_else(|| bullet_radius(net), |radius| radius.0);
        Box::new(Active { watch: PairWatch::new(net, bullet_radius, self.restitution), bullet_radius })
    }
}

struct Active {
    watch: PairWatch,
    bullet_radius: f64,
}

impl Effect for Active {
    fn name(&self) -> &'static str {
        "self_contact"
    }

    fn is_internal(&self) -> bool {
        true
    }

    fn installs(&self) -> String {
        let millimetres = 1e3 * self.bullet_radius;
        format!(
            "{} pairs of cables and bullets, which are balls of {millimetres:.1} mm",
            self.watch.n_pairs()
        )
    }

    fn presses(&self) -> bool {
        true
    }

    fn press(&mut self, knots: &mut Knots, _: &mut Option<Body>, step: f64, touched: &mut [bool]) {
        self.watch.answer(knots, step, touched);
    }

    fn account(&mut self, before: &State, after: &State) -> EffectWork {
        self.watch.account(&before.knots, &after.knots)
    }
}
