//! The closing mechanism of Section 5.4: threads that winches reel in to shut the net's mouth.
//!
//! The physics stands in [`crate::closing`]. This effect starts it, hands its impulses to the
//! knots, and posts to the ledger:
//!
//! - work: what the threads did to the knots, Σ J · (v⁻ + v⁺) / 2 over the knots' impulses J, plus what
//!   the reels gained in kinetic energy. Impulse times mean velocity is exactly the share of the
//!   threads in the change of the knots' energy.
//! - beside it, for the summary: the winches' work T (−dL/dt), and the loss, which is that less the
//!   posted work: going taut against moving knots, friction at the knots, latches.
//! - impulse and moment from outside: the pull of the tether to the chaser (layout `cinch`); every
//!   other thread is internal. Where the scene has a `chaser`, its body takes the opposite at the end of
//!   the step, and the tether ends where the body is; until then it is as good as held, so its mass must
//!   be well above a knot's.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Effect, Parameters};
use crate::closing::layouts::Layout;
use crate::closing::lock::Lock;
use crate::closing::trigger::{Trigger, Watch};
use crate::closing::winch::Drive;
use crate::closing::{Line, Mechanism, Outside};
use crate::net::Net;
use crate::options::Setting;
use crate::quantity::Positive;
use crate::solver::CableModel;
use crate::state::{EffectWork, State};
use crate::target::Target;

/// What is read of each thread in every frame, in this order: columns `thread_1_length_m` and so on.
pub const THREAD_READINGS: [&str; 3] = ["length_m", "off_reels_m", "tension_n"];

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
    fn build(&self, net: &Net, _target: Option<&Target>) -> Box<dyn Effect> {
        let drive = Drive {
            winches: 1.0, // each route says its own
            speed: self.reel_speed_m_s.0,
            tension: self.max_tension_n.0,
            reel_mass: self.reel_mass_kg,
            stop_share: self.stop_share,
        };
        let routes = self.layout.routes(net);
        let lines = routes.iter().map(|route| Line::new(route, drive, self.thread_friction)).collect();
        let n_meshes = net.grid.map(|n| (n - 1) as f64);
        let mesh = (net.designed_area / (n_meshes[0] * n_meshes[1])).sqrt();
        let distance = self.lock_distance_m.map_or(0.1 * mesh, |distance| distance.0);
        let lock = self.lock.then(|| Lock::new(&net.perimeter, distance));
        Box::new(Active {
            parameters: *self,
            watch: Watch::new(self.trigger, net),
            mechanism: Mechanism::new(lines, lock, &net.mass),
            stops: routes.iter().map(|route| self.stop_share * route.full_length).collect(),
            triggered: None,
            length_start: 0.0,
            passed_on: 0.0,
            has_chaser: false,
            from_chaser: Outside::default(),
        })
    }
}

/// What a closing mechanism did in a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// When the winches started [s].
    pub triggered: Option<f64>,
    /// Length of all threads off the reels when they started [m].
    pub length_start: f64,
    /// The same now [m].
    pub length_end: f64,
    /// Largest tension [N].
    pub tension: f64,
    /// Time at the tension limit, summed over the threads [s].
    pub time_at_limit: f64,
    /// Work of the winches [J].
    pub work: f64,
    /// What of it did not reach the knots [J].
    pub loss: f64,
    /// Largest length of a thread beyond what was off its reels, over its full length, below its
    /// largest tension [-].
    pub excess: f64,
    /// The same at its largest tension [-].
    pub drag: f64,
    /// Latched pairs of knots.
    pub latches: usize,
    /// The knots of each thread in order; `None`: the chaser.
    pub ways: Vec<Vec<Option<usize>>>,
    /// What is off the reels of each thread where winding ends [m].
    pub stops: Vec<f64>,
}

struct Active {
    parameters: Closing,
    watch: Watch,
    mechanism: Mechanism,
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

impl Effect for Active {
    fn name(&self) -> &'static str {
        "closing"
    }

    fn installs(&self) -> String {
        let Closing { reel_speed_m_s, max_tension_n, layout, .. } = self.parameters;
        format!(
            "{} thread(s) of layout {layout:?}, {} m/s a winch, at most {} N",
            self.mechanism.n_threads(),
            reel_speed_m_s.0,
            max_tension_n.0
        )
    }

    fn prepare(&mut self, setting: &Setting<'_>) {
        self.has_chaser = setting.plan.free_chaser && self.parameters.layout == Layout::Cinch;
        if setting.solver.cables == CableModel::Explicit {
            self.mechanism.in_substeps();
        }
    }

    fn threads(&self) -> Option<&Mechanism> {
        Some(&self.mechanism)
    }

    fn threads_mut(&mut self) -> Option<&mut Mechanism> {
        Some(&mut self.mechanism)
    }

    fn watch(&mut self, state: &State) {
        if let Some(chaser) = state.chaser.filter(|_| self.has_chaser) {
            self.mechanism.anchor(chaser.port());
        }
        if self.triggered.is_none() && self.watch.fires(state) {
            self.mechanism.start(&state.knots);
            self.triggered = Some(state.time);
            self.length_start = self.mechanism.length();
        }
    }

    fn stored_energy(&self, _state: &State) -> f64 {
        self.mechanism.stored()
    }

    fn account(&mut self, _before: &State, after: &State) -> EffectWork {
        let mut posting = self.mechanism.account(&after.knots);
        self.passed_on += posting.work;
        if self.has_chaser {
            self.from_chaser = Outside {
                impulse: std::mem::take(&mut posting.impulse),
                angular_impulse: std::mem::take(&mut posting.angular_impulse),
            };
        }
        posting
    }

    fn brackets(&self) -> bool {
        self.has_chaser
    }

    /// The chaser takes what the net got from it.
    fn close(&mut self, state: &mut State, _step: f64) -> EffectWork {
        let Outside { impulse, angular_impulse } = std::mem::take(&mut self.from_chaser);
        let Some(chaser) = &mut state.chaser else { return EffectWork::default() };
        let before = chaser.kinetic_energy();
        chaser.push(&-impulse, &-angular_impulse);
        let work = chaser.kinetic_energy() - before;
        self.passed_on += work;
        EffectWork { work, ..EffectWork::default() }
    }

    fn reading_names(&self) -> Vec<String> {
        let threads = 1..=self.mechanism.n_threads();
        let of_threads = threads.flat_map(|n| THREAD_READINGS.map(|reading| format!("thread_{n}_{reading}")));
        of_threads.chain(["winch_work_j".to_owned()]).collect()
    }

    fn readings(&mut self, state: &State) -> Vec<f64> {
        let work = self.mechanism.tally().work;
        let readings = self.mechanism.read(&state.knots);
        let threads = readings.flat_map(|reading| [reading.length, reading.off_reels, reading.tension]);
        threads.chain([work]).collect()
    }

    fn closing(&self) -> Option<Report> {
        let tally = self.mechanism.tally();
        Some(Report {
            triggered: self.triggered,
            length_start: self.length_start,
            length_end: self.mechanism.length(),
            tension: tally.tension,
            time_at_limit: tally.time_at_limit,
            work: tally.work,
            loss: tally.work - self.passed_on,
            excess: tally.excess,
            drag: tally.drag,
            latches: self.mechanism.n_latches(),
            ways: self.mechanism.ways().collect(),
            stops: self.stops.clone(),
        })
    }
}
