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
//!   the step, and the tether ends at the body's port; until then it is as good as held, so its mass must
//!   be well above a knot's.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};

use super::Parameters;
use super::blocks::SummaryRow;
use crate::closing::layouts::Layout;
use crate::closing::lock::Lock;
use crate::closing::thread::Anchor;
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

/// How the mouth was closed. A run's threads add up, except where it says the largest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClosingSummary {
    /// Start of the winches [s]; null: they never started.
    pub triggered_s: Option<f64>,
    /// From then until the mouth was first below `capture.mouth_max` [s]; null: it never was.
    pub time_to_close_s: Option<f64>,
    /// Thread off the reels when the winches started [m].
    pub length_start_m: f64,
    /// Thread off the reels at the end [m].
    pub length_end_m: f64,
    /// Largest length of a thread beyond what was off its reels while its tension was below the
    /// limit, over its full length: an error of the method [-].
    pub max_excess: f64,
    /// The same at the tension limit: knots that pulled harder drew the thread out [-]; `max_drag` in older
    /// summaries.
    #[serde(alias = "max_drag")]
    pub max_limit_overshoot: f64,
    /// Largest tension of a thread [N].
    pub max_tension_n: f64,
    /// Time at the tension limit, of the thread that was longest there [s].
    pub time_at_limit_s: f64,
    /// Work of the winches, tension times length reeled in [J].
    pub winch_work_j: f64,
    /// What of it was lost between thread and knots [J].
    pub lost_j: f64,
    /// Latched pairs of knots.
    pub latches: usize,
}

impl Closing {
    /// Closes the mouth to about 2 % of the net: side of 0.15 by side of 0.15.
    fn default_stop_share() -> f64 {
        0.15
    }
}

impl Parameters for Closing {
    const ROWS: &'static [SummaryRow] = &[
        SummaryRow::new("triggered_s", "winches start", "s").compared("winches\nstart").or("never"),
        SummaryRow::new("time_to_close_s", "time to close", "s").compared("time to\nclose").or("not closed"),
        SummaryRow::new("length_end_m", "thread off the reels", "m").compared("thread\nleft"),
        SummaryRow::new("max_tension_n", "largest tension of a thread", "N").compared("largest\ntension"),
        SummaryRow::new("time_at_limit_s", "time at the tension limit", "s").compared("at its\nlimit"),
        SummaryRow::new("winch_work_j", "winch work", "J").compared("winch\nwork"),
        SummaryRow::new("lost_j", "of it lost at the knots", "J").compared("lost at\nthe knots"),
    ];

    fn summary(generator: &mut SchemaGenerator) -> Option<Schema> {
        Some(generator.subschema_for::<ClosingSummary>())
    }

    fn ask(&self, options: &mut BuildOptions) {
        options.has_constraints = true;
        options.is_drawn_along |= self.layout == Layout::Cinch;
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
                port_of: context.options.port_of.filter(|_| self.layout == Layout::Cinch),
                from_port: Outside::default(),
                step: context.time_step.step,
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
    /// The body at the other end of a tether.
    port_of: Option<&'static str>,
    /// What it gave to the net within the step.
    from_port: Outside,
    /// Of the run [s].
    step: f64,
}

impl Effect for ClosingThreads {
    fn half_kick(&mut self) -> Option<&mut dyn HalfKick> {
        if self.port_of.is_some() { Some(self) } else { None }
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
    /// At the end of the step the body at the other end of a tether takes what the net got from it.
    fn kick(&mut self, state: &mut State, _step: f64, half: Half) -> EffectWork {
        if half == Half::First {
            return EffectWork::default();
        }
        let Outside { impulse, angular_impulse } = std::mem::take(&mut self.from_port);
        let Some(index) = self.port_of.and_then(|name| state.find_body(name)) else {
            return EffectWork::default();
        };
        let body = &mut state.bodies[index];
        let about_centre = -angular_impulse - body.position.cross(&-impulse);
        let work = state.body_models[index].push(body, &-impulse, &about_centre);
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
        if let Some(index) = self.port_of.and_then(|name| state.find_body(name)) {
            // What nothing touches is where it will be at the end of the step.
            let port = state.bodies[index].to_local(&state.body_models[index].port);
            let velocity = state.bodies[index].velocity_at(port);
            self.mechanism.anchor(Anchor { position: port - self.step * velocity, velocity });
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
        if self.port_of.is_some() {
            self.from_port = Outside {
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
            start: self.triggered,
            way,
            stop,
            limit: self.limit,
            port_of: self.port_of,
            columns: thread_columns(number),
        };
        let told = Report {
            start: Some(("winches start", self.triggered)),
            threads: self.mechanism.ways().zip(&self.stops).enumerate().map(thread).collect(),
            work: Some(WORK_COLUMN),
            curves: vec![("winch work", "J", WORK_COLUMN)],
            ..Report::default()
        };
        told.with_numbers(&ClosingSummary {
            triggered_s: self.triggered,
            time_to_close_s: None, // who sees the mouth over time says
            length_start_m: self.length_start,
            length_end_m: self.mechanism.length(),
            max_excess: tally.excess,
            max_limit_overshoot: tally.limit_overshoot,
            max_tension_n: tally.tension,
            time_at_limit_s: tally.time_at_limit,
            winch_work_j: tally.work,
            // What of it did not reach the knots.
            lost_j: tally.work - self.passed_on,
            latches: self.mechanism.n_latches(),
        })
    }
}
