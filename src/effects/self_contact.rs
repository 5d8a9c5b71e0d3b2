//! Contact of the net with itself (Section 6.3, item 5): cables and bullets against each other.
//!
//! The physics stands in [`crate::contact::pairs`]. It is frictionless: a cable of ours cannot bear the
//! moment that friction between two of them would put on it. Internal to the net: it takes energy
//! out and moves momentum between knots.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Effect;
use crate::contact::pairs::{PairWatch, bullet_radius};
use crate::net::Net;
use crate::plan::Setting;
use crate::quantity::Positive;
use crate::state::{Knots, Posting, State};

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

impl SelfContact {
    /// The effect.
    pub fn build(&self, net: &Net) -> Box<dyn Effect> {
        let bullet = self.bullet_radius_m.map_or_else(|| bullet_radius(net), |radius| radius.0);
        Box::new(Active {
            watch: PairWatch::new(net, bullet, self.restitution),
            n_cables: net.cables.len(),
            bullet_radius: bullet,
            step: 0.0,
        })
    }
}

struct Active {
    watch: PairWatch,
    n_cables: usize,
    bullet_radius: f64,
    step: f64,
}

impl Effect for Active {
    fn name(&self) -> &'static str {
        "self_contact"
    }

    fn prepare(&mut self, setting: &Setting<'_>) {
        self.step = setting.plan.step;
    }

    fn installs(&self) -> String {
        format!(
            "a capsule for each of {} cables and a ball of {:.1} mm for each bullet, to detect with",
            self.n_cables,
            1e3 * self.bullet_radius
        )
    }

    fn pulls(&self) -> bool {
        true
    }

    fn watch(&mut self, state: &State) {
        self.watch.look(&state.knots, self.step);
    }

    fn pull(&mut self, knots: &mut Knots, step: f64, touched: &mut [bool]) {
        self.watch.answer(knots, step, touched);
    }

    fn detection(&self) -> (usize, u64) {
        (self.watch.n_colliders(), self.watch.n_detections)
    }

    fn account(&mut self, before: &State, after: &State) -> Posting {
        self.watch.account(&before.knots, &after.knots)
    }
}
