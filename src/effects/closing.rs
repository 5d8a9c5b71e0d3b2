//! The closing mechanism of Section 5.4: threads that winches reel in to shut the net's mouth.
//!
//! The physics stands in [`crate::closing`]. This effect starts it, hands its impulses to the
//! knots, and posts to the ledger:
//!
//! - work: what the threads did to the knots, Σ J · (v⁻ + v⁺) / 2 over the knots' impulses J, plus what
//!   reels gained in kinetic energy. Impulse times mean velocity is exactly the share of the threads in the change
//!   of the knots' energy.
//! - loss: the winches' work T (−dL/dt) less that: going taut against moving knots, friction at the knots,
//!   latches. The winches' work is what comes from outside, so a thread that gives more creates energy,
//!   but for what drew it out beyond its reels: at most its largest tension times that length.
//! - impulse and moment from outside: the pull of the tether to the chaser (layout `cinch`); every
//!   other thread is internal. Where the scene has a `chaser`, its body takes the opposite at the end of
//!   the step, and the tether ends where the body is; until then it is as good as held, so its mass must
//!   be well above a knot's.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Parameters;
use crate::closing::layouts::Layout;
use crate::closing::lock::Lock;
use crate::closing::trigger::{Trigger, TriggerWatch};
use crate::closing::winch::Drive;
use crate::closing::{Line, Mechanism, Outside};
use crate::interaction::{
    DrawnThread, Effect, EffectOutput, Half, HalfKick, Interaction, Report, StepObserver, SubstepConstraint,
};
use crate::options::{BuildContext, BuildOptions};
use crate::quantity::Positive;
use crate::state::{EffectWork, State};
use crate::step;
use crate::step::limits::THROW;

/// The columns of thread `number`, from 0: its length, what is off its reels, its tension.
fn thread_columns(number: usize) -> [String; 3] {
    ["length_m", "off_reels_m", "tension_n"].map(|column| format!("thread_{}_{column}", number + 1))
}

/// The column of the winches' work.
const WORK_COLUMN: &str = "winch_work_j";

/// Parameters of the closing mechanism.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Closing {
    /// The way of the thread.
    #[serde(default)]
    pub layout: Layout,
    /// When the winches start.
    pub trigger: Trigger,
    /// Speed at which each winch reels in, at most [m/s].
    pub reel_speed_m_s: Positive,
    /// Largest tension of a thread [N].
    pub max_tension_n: Positive,
    /// Share of its full length at which a thread is wound no further [-]: its knots, and the tube
    /// bunched between them, take room.
    #[serde(default = "Closing::default_stop_share")]
    #[schemars(range(min = 0, max = 1))]
    pub stop_share: f64,
    /// Inertia of a reel over its radius squared [kg].
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub reel_mass_kg: f64,
    /// Capstan friction coefficient between thread and knots [-].
    #[serde(default)]
    #[schemars(range(min = 0, max = 10))]
    pub thread_friction: f64,
    /// Whether perimeter knots that come close latch onto each other.
    #[serde(default)]
    pub lock: bool,
    /// How close that is [m]; left out: a tenth of a mesh side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lock_distance_m: Option<Positive>,
}

impl Closing {
    /// Closes the mouth to about 2 % of the net: side of 0.15 by side of 0.15.
    fn default_stop_share() -> f64 {
        0.15
    }
}

impl Parameters for Closing {
    fn ask(&self, options: &mut BuildOptions) {
        options.has_constraints = true;
        options.pull = options.pull.max(self.max_tension_n.0);
    }

    fn build(&self, context: &BuildContext<'_>) -> Interaction {
        let net = context.net;
        let drive = Drive {
            winches: 1.0, // each route says its own
            speed: self.reel_speed_m_s.0,
            tension: self.max_tension_n.0,
            reel_mass: self.reel_mass_kg,
            stop_share: self.stop_share,
        };
        let routes = self.layout.routes(net);
        let knot_size = 2.0 * net.radius.iter().copied().fold(f64::INFINITY, f64::min);
        let lines =
            routes.iter().map(|route| Line::new(route, drive, self.thread_friction, knot_size)).collect();
        let n_meshes = net.grid.map(|n| (n - 1) as f64);
        let mesh = (net.designed_area / (n_meshes[0] * n_meshes[1])).sqrt();
        let distance = self.lock_distance_m.map_or(0.1 * mesh, |distance| distance.0);
        let lock = self.lock.then(|| Lock::new(&net.perimeter, distance));
        let mut mechanism = Mechanism::new(lines, lock, &step::answering_mass(context));
        if context.acts_in_substeps {
            mechanism.in_substeps();
        }
        if context.target.is_some() {
            mechanism.throws_at_most(THROW * context.contact_speed);
        }
        let about = format!(
            "{} thread(s) of layout {:?}, {} m/s a winch, at most {} N",
            mechanism.n_threads(),
            self.layout,
            self.reel_speed_m_s.0,
            self.max_tension_n.0
        );
        Interaction::new(
            "closing",
            about,
            ClosingThreads {
                trigger: TriggerWatch::new(self.trigger, net),
                mechanism,
                limit: self.max_tension_n.0,
                stops: routes.iter().map(|route| self.stop_share * route.full_length).collect(),
                triggered: None,
                length_start: 0.0,
                passed_on: 0.0,
                has_chaser: context.options.free_chaser && self.layout == Layout::Cinch,
                from_chaser: Outside::default(),
            },
        )
    }
}

/// The threads under way.
struct ClosingThreads {
    trigger: TriggerWatch,
    mechanism: Mechanism,
    /// Largest tension [N].
    limit: f64,
    /// What is off the reels of each thread where winding ends [m].
    stops: Vec<f64>,
    triggered: Option<f64>,
    length_start: f64,
    /// Work posted so far [J].
    passed_on: f64,
    /// Whether a free chaser is at the other end of a tether.
    has_chaser: bool,
    /// What the chaser gave to the net within the step.
    from_chaser: Outside,
}

impl Effect for ClosingThreads {
    fn half_kick(&mut self) -> Option<&mut dyn HalfKick> {
        if self.has_chaser { Some(self) } else { None }
    }

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

impl HalfKick for ClosingThreads {
    /// At the end of the step the chaser takes what the net got from it.
    fn kick(&mut self, state: &mut State, _step: f64, half: Half) -> EffectWork {
        if half == Half::First {
            return EffectWork::default();
        }
        let Outside { impulse, angular_impulse } = std::mem::take(&mut self.from_chaser);
        let Some(chaser) = &mut state.chaser else { return EffectWork::default() };
        let before = chaser.kinetic_energy();
        chaser.push(&-impulse, &-angular_impulse);
        let work = chaser.kinetic_energy() - before;
        self.passed_on += work;
        // The winch has put it in already.
        EffectWork { work, lost: -work, ..EffectWork::default() }
    }

    fn kicks_knots(&self) -> bool {
        false
    }
}

impl StepObserver for ClosingThreads {
    fn start_of_step(&mut self, state: &State) {
        if let Some(chaser) = state.chaser.filter(|_| self.has_chaser) {
            self.mechanism.anchor(chaser.port());
        }
        if let Some(command) = state.winch {
            self.mechanism.command(command.reel_speed, command.max_tension);
        }
        let is_told = state.winch.is_some_and(|command| command.start);
        if self.triggered.is_none() && (is_told || self.trigger.fires(state)) {
            self.mechanism.start(&state.knots);
            self.triggered = Some(state.time);
            self.length_start = self.mechanism.length();
        }
    }

    fn stored_energy(&self, _state: &State) -> f64 {
        self.mechanism.stored()
    }

    fn may_hold(&self) -> f64 {
        self.mechanism.drawn_out()
    }

    fn end_of_step(&mut self, _before: &State, after: &State) -> EffectWork {
        let mut work = self.mechanism.account(&after.knots);
        self.passed_on += work.work;
        if self.has_chaser {
            self.from_chaser = Outside {
                impulse: std::mem::take(&mut work.impulse),
                angular_impulse: std::mem::take(&mut work.angular_impulse),
            };
        }
        work
    }
}

impl EffectOutput for ClosingThreads {
    fn columns(&self) -> Vec<String> {
        let of_threads = (0..self.mechanism.n_threads()).flat_map(thread_columns);
        of_threads.chain([WORK_COLUMN.to_owned()]).collect()
    }

    fn values(&mut self, state: &State) -> Vec<f64> {
        let work = self.mechanism.tally().work;
        let readings = self.mechanism.read(&state.knots);
        let threads = readings.flat_map(|reading| [reading.length, reading.off_reels, reading.tension]);
        threads.chain([work]).collect()
    }

    fn report(&self, _end: &State) -> Report {
        let tally = self.mechanism.tally();
        let thread = |(number, (way, &stop)): (usize, (Vec<Option<usize>>, &f64))| DrawnThread {
            way,
            stop,
            limit: self.limit,
            columns: thread_columns(number),
        };
        Report {
            numbers: vec![
                ("triggered_s", json!(self.triggered)),
                ("length_start_m", json!(self.length_start)),
                ("length_end_m", json!(self.mechanism.length())),
                ("max_excess", json!(tally.excess)),
                ("max_limit_overshoot", json!(tally.limit_overshoot)),
                ("max_tension_n", json!(tally.tension)),
                ("time_at_limit_s", json!(tally.time_at_limit)),
                ("winch_work_j", json!(tally.work)),
                // What of it did not reach the knots.
                ("lost_j", json!(tally.work - self.passed_on)),
                ("latches", json!(self.mechanism.n_latches())),
            ],
            start: Some(("winches start", self.triggered)),
            trial: None,
            threads: self.mechanism.ways().zip(&self.stops).enumerate().map(thread).collect(),
            curves: vec![("winch work", "J", WORK_COLUMN)],
        }
    }
}
