//! When the mechanism starts.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::geometry::vector_area;
use crate::net::Net;
use crate::quantity::Positive;
use crate::state::State;

/// What starts it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "on", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Trigger {
    /// The first contact of net and target (Section 5.4.1).
    Contact {
        /// Time from the event to the start [s].
        #[serde(default)]
        #[schemars(range(min = 0))]
        delay_s: f64,
    },
    /// A time.
    Time {
        /// Since the shot [s].
        #[schemars(range(min = 0))]
        at_s: f64,
    },
    /// The mouth, once it has been wider, is narrower than a share of the designed area.
    Mouth {
        /// The share [-].
        below: Positive,
        /// Time from the event to the start [s].
        #[serde(default)]
        #[schemars(range(min = 0))]
        delay_s: f64,
    },
    /// All bullets are past the target's centre of mass along X.
    Past {
        /// By so much [m]; negative: still before it.
        #[serde(default)]
        distance_m: f64,
        /// Time from the event to the start [s].
        #[serde(default)]
        #[schemars(range(min = 0))]
        delay_s: f64,
    },
}

impl Trigger {
    /// Whether it can only happen with a target.
    pub fn needs_target(&self) -> bool {
        matches!(self, Trigger::Contact { .. } | Trigger::Past { .. })
    }
}

/// Waits for a trigger.
#[derive(Clone, Debug)]
pub struct TriggerWatch {
    trigger: Trigger,
    bullets: [usize; 4],
    perimeter: Vec<usize>,
    designed_area: f64,
    /// Whether the mouth has been wide.
    was_wide: bool,
    /// Time of the start, once the event has happened [s].
    due: Option<f64>,
}

impl TriggerWatch {
    /// Waits for `trigger` on `net`.
    pub fn new(trigger: Trigger, net: &Net) -> TriggerWatch {
        let due = match trigger {
            Trigger::Time { at_s } => Some(at_s),
            _ => None,
        };
        TriggerWatch {
            trigger,
            bullets: net.bullets,
            perimeter: net.perimeter.clone(),
            designed_area: net.designed_area,
            was_wide: false,
            due,
        }
    }

    /// Whether it is time, at the start of the step from `state`.
    pub fn fires(&mut self, state: &State) -> bool {
        if self.due.is_none() {
            self.due = self.event(state).map(|delay| state.time + delay);
        }
        // Times are multiples of the step up to rounding.
        self.due.is_some_and(|due| state.time >= due * (1.0 - 1e-12))
    }

    /// The delay, if the event has just happened.
    fn event(&mut self, state: &State) -> Option<f64> {
        let (happened, delay) = match self.trigger {
            Trigger::Contact { delay_s } => {
                (state.contacts.iter().any(|contact| contact.impulse > 0.0), delay_s)
            }
            Trigger::Time { at_s } => (state.time >= at_s, 0.0),
            Trigger::Mouth { below, delay_s } => {
                let position = |&knot: &usize| -> Vector3<f64> { state.knots.position[knot] };
                let mouth = vector_area(self.perimeter.iter().map(position)).norm() / self.designed_area;
                self.was_wide |= mouth > below.0;
                (self.was_wide && mouth < below.0, delay_s)
            }
            Trigger::Past { distance_m, delay_s } => {
                let past = |body: &crate::state::Body| {
                    let line = body.position.x + distance_m;
                    self.bullets.iter().all(|&bullet| state.knots.position[bullet].x > line)
                };
                (state.target().is_some_and(past), delay_s)
            }
        };
        happened.then_some(delay)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::net::spec::Launch;
    use crate::problems::Problems;
    use crate::state::{Body, BodyModel, Contact, Knots, Motion};
    use nalgebra::Matrix3;
    use serde_json::json;

    fn net() -> Net {
        let spec = json!({ "meshes": [2, 2], "mesh_length_m": 0.5, "bullet_mass_kg": 1.0,
            "cable": { "material": "kevlar", "diameter_m": 0.001 } });
        let launch = Launch { speed_m_s: 10.0, angle_deg: 30.0, bullets: Default::default() };
        Net::build(&serde_json::from_value(spec).unwrap(), &launch, &mut Problems::new("test")).unwrap()
    }

    /// The net flat at `x`, as wide as `width` of its full side.
    fn state(net: &Net, time: f64, x: f64, width: f64) -> State {
        let flat = |p: &Vector3<f64>| Vector3::new(x, p.y, p.z) * width / net.folded[0].y.abs() / 2.0;
        let position: Vec<_> = net
            .folded
            .iter()
            .map(|p| flat(p) + (1.0 - width / net.folded[0].y.abs() / 2.0) * x * Vector3::x())
            .collect();
        let target = Body { position: Vector3::x(), ..Body::at_rest() };
        let model = BodyModel::new("target", Motion::Free, 1.0, Matrix3::identity()).with_shape();
        let velocity = vec![Vector3::zeros(); position.len()];
        let state = State { time, knots: Knots { position, velocity }, ..State::default() };
        state.with_bodies([(model, target)])
    }

    #[test]
    fn contact_starts_after_its_delay_and_needs_an_impulse() {
        let net = net();
        let mut watch = TriggerWatch::new(Trigger::Contact { delay_s: 0.1 }, &net);
        let mut near = state(&net, 1.0, 0.0, 1.0);
        let contact = Contact {
            knot: 0,
            part: 0,
            point: Vector3::zeros(),
            normal: Vector3::x(),
            gap: 1e-3,
            impulse: 0.0,
            friction: Vector3::zeros(),
            ..Contact::default()
        };
        near.contacts = vec![contact];
        assert!(!watch.fires(&near));
        near.contacts = vec![Contact { impulse: 1e-6, ..contact }];
        near.time = 1.05;
        assert!(!watch.fires(&near));
        assert!(!watch.fires(&state(&net, 1.14, 0.0, 1.0)));
        assert!(watch.fires(&state(&net, 1.15, 0.0, 1.0)));
    }

    #[test]
    fn time_starts_at_its_time() {
        let net = net();
        let mut watch = TriggerWatch::new(Trigger::Time { at_s: 0.3 }, &net);
        assert!(!watch.fires(&state(&net, 0.2, 0.0, 1.0)));
        assert!(watch.fires(&state(&net, 0.1 + 0.2, 0.0, 1.0)));
    }

    /// In the container the mouth is small and has never been wide.
    #[test]
    fn a_mouth_must_have_been_wide_before_it_is_narrow() {
        let net = net();
        let mut watch = TriggerWatch::new(Trigger::Mouth { below: Positive(0.5), delay_s: 0.0 }, &net);
        assert!(!watch.fires(&state(&net, 0.0, 0.0, 0.3)));
        assert!(!watch.fires(&state(&net, 0.5, 0.0, 1.0)));
        assert!(watch.fires(&state(&net, 1.0, 0.0, 0.3)));
    }

    #[test]
    fn past_waits_for_all_bullets() {
        let net = net();
        let mut watch = TriggerWatch::new(Trigger::Past { distance_m: 0.2, delay_s: 0.0 }, &net);
        let mut late = state(&net, 1.0, 1.3, 1.0);
        late.knots.position[net.bullets[2]].x = 1.1;
        assert!(!watch.fires(&late));
        assert!(watch.fires(&state(&net, 1.1, 1.3, 1.0)));
    }
}
