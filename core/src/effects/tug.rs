//! The tug: after the capture the chaser pulls the net's centre along a direction. Does it hold?
//!
//! The pull is a thread of one segment (see [`crate::closing`]) from the net's centre knot to a
//! winch so far away that its direction hardly turns. Without `speed_m_s` the winch keeps the
//! tension at `force_n`; with it, it reels in at that speed, at a tension of `force_n` at most,
//! and slack while the net comes along by itself.
//!
//! Whether the target stays enclosed while it pulls is told by `retention.tug` of the summary.
//!
//! The pull comes from outside: its impulse, its moment about the origin and its work are posted.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Parameters;
use crate::closing::layouts::Route;
use crate::closing::thread::{Anchor, Ends, Node};
use crate::closing::trigger::{Trigger, TriggerWatch};
use crate::closing::winch::Drive;
use crate::closing::{Line, Mechanism};
use crate::interaction::{Effect, EffectOutput, Interaction, Report, StepObserver, SubstepConstraint};
use crate::options::{BuildContext, BuildOptions};
use crate::quantity::Positive;
use crate::state::{EffectWork, State};
use crate::step;
use crate::step::limits::THROW;

/// Distance of the winch over the side of the net, at least.
const FAR: f64 = 100.0;

/// The column of its force.
const COLUMN: &str = "tug_force_n";

/// Parameters of the tug.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tug {
    /// When it starts.
    pub start: Trigger,
    /// For how long it pulls [s].
    pub time_s: Positive,
    /// Where to, in the local frame, of any length but 0 [-].
    pub direction: [f64; 3],
    /// Force; the largest, where there is a speed [N].
    pub force_n: Positive,
    /// Speed [m/s]; left out: as the force makes it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<Positive>,
}

impl Parameters for Tug {
    fn ask(&self, options: &mut BuildOptions) {
        options.has_constraints = true;
        options.pull = options.pull.max(self.force_n.0);
    }

    fn build(&self, context: &BuildContext<'_>) -> Interaction {
        let net = context.net;
        let centre = net.middle_knot();
        let route = Route {
            nodes: vec![Node::Anchor, Node::Knot(centre)],
            ends: Ends::First,
            winches: 1,
            full_length: 0.0,
        };
        let drive = Drive {
            winches: 1.0,
            speed: self.speed_m_s.map_or(f64::INFINITY, |speed| speed.0),
            tension: self.force_n.0,
            reel_mass: 0.0,
            stop_share: 0.0,
        };
        let distance = self.speed_m_s.map_or(0.0, |speed| 2.0 * speed.0 * self.time_s.0);
        let reach = distance.max(FAR * net.designed_area.sqrt());
        let mut mechanism =
            Mechanism::new(vec![Line::new(&route, drive, 0.0, 0.0)], None, &step::answering_mass(context));
        if context.target.is_some() {
            mechanism.throws_at_most(THROW * context.contact_speed);
        }
        let about = format!("a tether at the centre knot, {} N", self.force_n.0);
        Interaction::new(
            "tug",
            about,
            Tether {
                parameters: *self,
                trigger: TriggerWatch::new(self.start, net),
                mechanism,
                centre,
                to_winch: reach * Vector3::from(self.direction).normalize(),
                started: None,
            },
        )
    }
}

/// The tether under way.
struct Tether {
    parameters: Tug,
    trigger: TriggerWatch,
    mechanism: Mechanism,
    centre: usize,
    /// From the centre knot to the winch at the start [m].
    to_winch: Vector3<f64>,
    started: Option<f64>,
}

impl Effect for Tether {
    fn constraint(&mut self) -> Option<&mut dyn SubstepConstraint> {
        Some(&mut self.mechanism)
    }

    fn observer(&mut self) -> Option<&mut dyn StepObserver> {
        Some(self)
    }

    fn output(&mut self) -> Option<&mut dyn EffectOutput> {
        Some(self)
    }
}

impl StepObserver for Tether {
    fn start_of_step(&mut self, state: &State) {
        match self.started {
            None if self.trigger.fires(state) => {
                let position = state.knots.position[self.centre] + self.to_winch;
                self.mechanism.anchor(Anchor { position, ..Anchor::default() });
                self.mechanism.start(&state.knots);
                self.started = Some(state.time);
            }
            Some(start) if state.time >= start + self.parameters.time_s.0 => self.mechanism.stop(),
            _ => {}
        }
    }

    fn may_hold(&self) -> f64 {
        self.mechanism.drawn_out()
    }

    fn end_of_step(&mut self, _before: &State, after: &State) -> EffectWork {
        self.mechanism.account(&after.knots)
    }
}

impl EffectOutput for Tether {
    fn columns(&self) -> Vec<String> {
        vec![COLUMN.to_owned()]
    }

    fn values(&mut self, state: &State) -> Vec<f64> {
        self.mechanism.read(&state.knots).map(|reading| reading.tension).collect()
    }

    fn report(&self, _end: &State) -> Report {
        Report {
            trial: self.started.map(|start| [start, start + self.parameters.time_s.0]),
            curves: vec![("tug", "N", COLUMN)],
            ..Report::default()
        }
    }
}
