//! Episodes of closing control: members of an ensemble whose winches are told from outside, stepped at once without the
//! interpreter's lock.

use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Vector3;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::ThreadPool;
use rayon::prelude::*;
use tumblenet::case::Case;
use tumblenet::metrics::capture::Curves;
use tumblenet::metrics::mouth;
use tumblenet::metrics::verdict::Capture;
use tumblenet::problems::Problems;
use tumblenet::run::Recorder;
use tumblenet::simulation::Simulation;
use tumblenet::state::WinchCommand;
use tumblenet::study::ensemble::{self, EnsembleRequest};
use tumblenet::study::settle;

use crate::result::{Recorded, RunResult};
use crate::scene::Scene;
use crate::simulation::{Readings, TENSION};
use crate::{arrays, batch, errors};

/// What is seen of an episode, in this order.
const OBSERVATION: [&str; 11] = [
    "time_s",
    "area_m2",
    "mouth",
    "distance_m",
    "bullets_past_m",
    "approach_m_s",
    "target_rate_rad_s",
    "has_met",
    "is_closing",
    "off_reels_m",
    "tension_n",
];

/// How an episode ended.
#[derive(Clone)]
enum Ended {
    /// Running on would change nothing.
    Decided,
    OutOfTime,
    Failed(String),
}

/// A member under way.
struct Episode {
    case: Case,
    simulation: Simulation,
    recorder: Recorder,
    curves: Curves,
    readings: Readings,
    seed: u64,
    is_closing: bool,
    /// What is seen of it, as [`OBSERVATION`].
    seen: [f64; OBSERVATION.len()],
    /// Work of the winches up to now [J].
    work: f64,
    ended: Option<Ended>,
}

impl Episode {
    /// The start of member 0 of the ensemble of `case` with this seed.
    fn start(case: &Case, perturb_m: f64, seed: u64, at_most: f64) -> Result<Episode, Problems> {
        let request = EnsembleRequest { members: 1, perturb_m, seed, at_most_s: Some(at_most) };
        let case = ensemble::member(case, &request, 0)?;
        let mut simulation = Simulation::new(&case);
        let mut episode = Episode {
            recorder: Recorder::start(&case, &mut simulation, at_most),
            readings: Readings::of(&mut simulation),
            curves: Curves::default(),
            seed,
            is_closing: false,
            seen: [0.0; OBSERVATION.len()],
            work: 0.0,
            ended: None,
            case,
            simulation,
        };
        episode.observe();
        Ok(episode)
    }

    /// Tells the winches, and goes on by `n_steps`, or to the end.
    fn go_on(&mut self, n_steps: u64, command: WinchCommand) {
        self.is_closing |= command.start;
        self.simulation.state.winch = Some(command);
        for _ in 0..n_steps {
            if self.ended.is_some() {
                break;
            }
            self.ended = self.step();
        }
        self.observe();
    }

    /// A step; how it ended the episode, if it did.
    fn step(&mut self) -> Option<Ended> {
        let Episode { case, simulation, recorder, curves, .. } = self;
        if let Err(failure) = simulation.step() {
            return Some(Ended::Failed(failure.to_string()));
        }
        let is_frame = recorder.record(case, simulation);
        let is_decided = is_frame
            && recorder.has_passed_end()
            && settle::is_decided(case, recorder.frames(), recorder.has_met(), curves);
        if is_decided { Some(Ended::Decided) } else { recorder.is_full().then_some(Ended::OutOfTime) }
    }

    fn observe(&mut self) {
        let values = self.readings.now(&mut self.simulation, Some(&self.recorder));
        let most = |ending: &str| {
            let column = self.readings.columns.iter().zip(&values).filter(|(name, _)| name.ends_with(ending));
            column.map(|(_, value)| *value).fold(0.0, f64::max)
        };
        let (state, net) = (&self.simulation.state, self.case.net());
        let Some(target) = state.target() else { return };
        let bullets = net.bullets.map(|bullet| state.knots.position[bullet]);
        let total: f64 = net.mass.iter().sum();
        let mean = |values: &[Vector3<f64>]| {
            net.mass.iter().zip(values).map(|(mass, value)| mass * value.x).sum::<f64>() / total
        };
        self.work = most("winch_work_j");
        self.seen = [
            state.time,
            self.recorder.area(&state.knots.position),
            mouth::vector_area_share(net, &state.knots.position),
            target.position.x - mean(&state.knots.position),
            bullets.iter().map(|bullet| bullet.x).fold(f64::INFINITY, f64::min) - target.position.x,
            mean(&state.knots.velocity) - target.velocity.x,
            target.rate.norm(),
            f64::from(u8::from(self.recorder.has_met())),
            f64::from(u8::from(self.is_closing)),
            most("_off_reels_m"),
            most(TENSION),
        ];
    }

    /// Whether the target is held now, and the word of the verdict.
    fn verdict(&mut self) -> Option<Capture> {
        self.curves.extend(&self.case, self.recorder.frames());
        let frames = self.recorder.frames();
        Capture::of(&self.case, self.recorder.has_met(), &frames.time, &self.curves)
    }
}

/// B episodes of a scene with closing threads, each of them member 0 of the scene's ensemble with a seed of its own.
#[pyclass(module = "tumblenet._native")]
pub struct Episodes {
    case: Case,
    perturb_m: f64,
    at_most: f64,
    n_steps: u64,
    pool: ThreadPool,
    // For the compiler alone: whoever has `&mut` needs no lock.
    running: Mutex<Vec<Option<Episode>>>,
}

impl Episodes {
    fn running(&mut self) -> &mut Vec<Option<Episode>> {
        self.running.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    fn episode(&mut self, number: usize) -> PyResult<&mut Episode> {
        let known = self.running().get_mut(number).and_then(Option::as_mut);
        known.ok_or_else(|| errors::argument("episode", number, "one that was reset"))
    }

    /// A number of each episode: [B], zero where none was reset.
    fn each<'py>(&mut self, py: Python<'py>, number: impl Fn(&Episode) -> f64) -> Bound<'py, PyAny> {
        let numbers = self.running().iter().map(|episode| episode.as_ref().map_or(0.0, &number));
        arrays::numbers(py, numbers.collect())
    }
}

#[pymethods]
impl Episodes {
    /// `n` of them, in steps of `dt` [s], each until it is decided, for at most `at_most` [s].
    #[new]
    fn new(
        scene: &Bound<'_, PyAny>,
        n: usize,
        dt: f64,
        at_most: f64,
        perturb_m: f64,
        threads: Option<usize>,
    ) -> PyResult<Episodes> {
        let scene = Scene::of(scene)?;
        let case = scene.get().case.clone();
        if case.scene().effects.closing.is_none() || case.target().is_none() {
            return Err(errors::argument("scene", case.name(), "one with a target and effects.closing"));
        }
        if !(dt.is_finite() && dt > 0.0) {
            return Err(errors::argument("dt", dt, "a number above 0, in seconds"));
        }
        let mut problems = Problems::new(case.name());
        settle::check(&case, at_most, "at_most", &mut problems);
        problems.into_result(Some(())).map_err(errors::scene)?;
        let request = EnsembleRequest { members: 1, perturb_m, seed: 0, at_most_s: Some(at_most) };
        request.check(&case).map_err(errors::scene)?;
        let n_steps = (dt / case.time_step().step).round().max(1.0) as u64;
        let pool = batch::pool(threads)?;
        let running = Mutex::new((0..n).map(|_| None).collect());
        Ok(Episodes { case, perturb_m, at_most, n_steps, pool, running })
    }

    /// Names of what is seen, with units.
    #[staticmethod]
    fn names() -> Vec<&'static str> {
        OBSERVATION.to_vec()
    }

    /// Begins those anew that have a seed in `seeds`, of all B.
    fn reset(&mut self, py: Python<'_>, seeds: Vec<Option<u64>>) -> PyResult<()> {
        let Episodes { case, perturb_m, at_most, pool, running, .. } = self;
        let running = running.get_mut().unwrap_or_else(PoisonError::into_inner);
        let begun: Result<Vec<()>, Problems> = py.detach(|| {
            pool.install(|| {
                let begin = |(episode, seed): (&mut Option<Episode>, &Option<u64>)| {
                    if let Some(seed) = seed {
                        *episode = Some(Episode::start(case, *perturb_m, *seed, *at_most)?);
                    }
                    Ok(())
                };
                running.par_iter_mut().zip(&seeds).map(begin).collect()
            })
        });
        begun.map(drop).map_err(errors::scene)
    }

    /// Goes on with those that `goes_on` names, [B] each: whether winches start, at most how fast they reel in [m/s], how
    /// hard [N]. Those that have ended stay as they are.
    fn step(
        &mut self,
        py: Python<'_>,
        goes_on: Vec<bool>,
        start: Vec<bool>,
        reel_speed: Vec<f64>,
        max_tension: f64,
    ) -> PyResult<()> {
        let Episodes { n_steps, pool, running, .. } = self;
        let running = running.get_mut().unwrap_or_else(PoisonError::into_inner);
        py.detach(|| {
            pool.install(|| {
                running.par_iter_mut().enumerate().for_each(|(number, episode)| {
                    if let Some(episode) = episode.as_mut().filter(|_| goes_on[number]) {
                        let (start, reel_speed) = (start[number], reel_speed[number]);
                        episode.go_on(*n_steps, WinchCommand { start, reel_speed, max_tension });
                    }
                });
            });
        });
        py.check_signals()
    }

    /// What is seen of each: [B, O].
    fn observation<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.running().iter();
        let seen = rows.flat_map(|episode| episode.as_ref().map_or([0.0; OBSERVATION.len()], |e| e.seen));
        let seen: Vec<f64> = seen.collect();
        let shape = [seen.len() / OBSERVATION.len(), OBSERVATION.len()];
        arrays::shaped(py, seen, shape)
    }

    /// Work of the winches of each up to now [J]: [B].
    fn work<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyAny> {
        self.each(py, |episode| episode.work)
    }

    /// Whether each is decided, or has failed; whether it is out of time: [B] each.
    fn ended<'py>(&mut self, py: Python<'py>) -> [Bound<'py, PyArray1<bool>>; 2] {
        let running = self.running();
        [false, true].map(|is_out_of_time| {
            let has_ended = |episode: &Option<Episode>| {
                let ended = episode.as_ref().and_then(|episode| episode.ended.as_ref());
                ended.is_some_and(|ended| matches!(ended, Ended::OutOfTime) == is_out_of_time)
            };
            PyArray1::from_vec(py, running.iter().map(has_ended).collect())
        })
    }

    /// Whether the target of one is held now, the verdict in a word, and why its run failed, if it did.
    fn verdict(&mut self, number: usize) -> PyResult<(bool, &'static str, Option<String>)> {
        let episode = self.episode(number)?;
        if let Some(Ended::Failed(why)) = &episode.ended {
            return Ok((false, "failed", Some(why.clone())));
        }
        let capture = episode.verdict();
        let word = capture.map_or("never_met", |capture| capture.verdict.name());
        Ok((capture.is_some_and(|capture| capture.captured), word, None))
    }

    /// What was drawn for one, as text by the name of a column; and its seed.
    fn drawn<'py>(&mut self, py: Python<'py>, number: usize) -> PyResult<(u64, Bound<'py, PyDict>)> {
        let seed = self.episode(number)?.seed;
        let dict = PyDict::new(py);
        if let Some(uncertain) = self.case.uncertain() {
            let shown = uncertain.draw(seed, 0).into_iter().flat_map(|pick| pick.shown);
            for (name, shown) in uncertain.columns().into_iter().zip(shown) {
                dict.set_item(name, shown)?;
            }
        }
        Ok((seed, dict))
    }

    /// The run of one up to now.
    fn result(&mut self, py: Python<'_>, number: usize) -> PyResult<RunResult> {
        let Episode { case, simulation, recorder, curves, .. } = self.episode(number)?;
        let (case, recorder, curves) = (case.clone(), recorder.clone(), curves.clone());
        let recorded = py.detach(|| Recorded::up_to_now(case, recorder, simulation, curves));
        Ok(RunResult::new(py, Arc::new(recorded)))
    }
}
