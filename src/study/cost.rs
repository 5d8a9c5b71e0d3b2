//! What accuracy costs in time, on one's own scene and machine.
//!
//! Every dial that trades accuracy for time is turned, one at a time, and each setting is set against
//! a reference made on the spot: before contact by the paths of the knots, after it by what must be
//! kept and by the distribution of verdicts. A budget bounds the study; what it does not cover is
//! listed as left out.
//!
//! | stage | does |
//! |---|---|
//! | [`dials`] | the settings |
//! | [`reference`], [`oracle`] | the free flight, known far better than any run, and where chaos ends that |
//! | [`errors`], [`timing`] | what a run is worth, and what it costs |
//! | [`front`] | the settings worth their time; the order of convergence |
//! | [`verdicts`] | after contact: distributions |
//! | [`map`] | where a method is stable |
//! | [`advice`] | what to use, in a sentence |
//! | [`accuracy`] | settings measured on built-in scenes, for `run --accuracy` |

pub mod accuracy;
pub mod advice;
pub mod dials;
pub mod errors;
pub mod front;
pub mod map;
pub mod oracle;
pub mod reference;
pub mod timing;
pub mod verdicts;

use std::time::{Duration, Instant};

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::ensemble;
use crate::case::Case;
use crate::failure::Failure;
use crate::problems::{Problem, Problems};
use crate::provenance::Provenance;
use crate::scene::Source;
use advice::Advice;
use dials::{Kind, Setting};
use errors::Worth;
use front::Order;
use map::Map;
use reference::{Quality, Reference};
use timing::{Cost, timed};
use verdicts::Verdicts;

/// Most repeats of a setting.
const REPEATS: usize = 9;

/// Settings off the front that are repeated: those within this factor of its cost at their error [-].
const NEAR: f64 = 1.5;

/// Frames of a run: time between them where a run lasts long enough [s].
const SAMPLE: f64 = 0.01;

/// Perturbation of an ensemble [m], as that of `run --ensemble`.
const PERTURB: f64 = 1e-6;

/// What a study is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Request {
    /// Time that it may take [s].
    pub budget_s: f64,
    /// Seed of the perturbations.
    pub seed: u64,
    /// Time up to which errors are quoted [s]; null: as far as the floor allows.
    pub at_s: Option<f64>,
}

/// Where finished measurements are kept, so that a killed study loses none.
pub trait Store: Sync {
    /// What was kept of `case` as number `number` of its kind.
    fn known<T: DeserializeOwned>(&self, case: &Case, kind: &str, number: usize) -> Option<T>;
    /// Keeps it.
    fn keep<T: Serialize>(&self, case: &Case, kind: &str, number: usize, value: &T);
}

/// `cost.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Study {
    /// The scene's title.
    pub title: String,
    /// Its name.
    pub scene: String,
    /// Hash of scene and target as written.
    pub scene_hash: String,
    /// What was asked for.
    pub request: Request,
    /// What it took [s].
    pub took_s: f64,
    /// Side of the net [m].
    pub side_m: f64,
    /// Largest radius of a knot [m].
    pub knot_radius_m: f64,
    /// How well the reference is known; null where there is none.
    pub reference: Option<Quality>,
    /// The floor of the errors [m].
    pub floor_m: f64,
    /// Every setting.
    pub settings: Vec<Measured>,
    /// Labels of those on the front, from the cheapest to the most accurate.
    pub front: Vec<String>,
    /// Observed orders of convergence.
    pub orders: Vec<Order>,
    /// Distributions after contact, the reference ensemble first; empty without a target.
    pub verdicts: Vec<Verdicts>,
    /// Stability over step and stiffness.
    pub maps: Vec<Map>,
    /// What to use.
    pub advice: Advice,
    /// What made these numbers.
    pub provenance: Provenance,
}

/// One setting and what was measured of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Measured {
    /// What it changes.
    pub kind: Kind,
    /// The dial.
    pub family: String,
    /// Its name.
    pub label: String,
    /// Its position, where the family turns a number.
    pub value: Option<f64>,
    /// What it changes in the scene, as for `--set`.
    pub changes: Vec<String>,
    /// Step, of the engine or of the explicit net [s]; null where refused.
    pub step_s: Option<f64>,
    /// Why there is nothing more: refused by the checks, failed, or left out for lack of time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without: Option<String>,
    /// What it costs.
    pub cost: Option<Cost>,
    /// What it is worth.
    pub worth: Option<Worth>,
    /// What is wrong with it.
    pub warnings: Vec<String>,
    /// Whether it is on the front.
    pub on_front: bool,
}

impl Measured {
    /// Its error: the largest distance of a bullet within the window [m].
    pub fn error(&self) -> Option<f64> {
        Some(self.worth.as_ref()?.bullets?.max_m)
    }

    /// Whether it belongs into the diagram: it has a cost and an error.
    pub fn point(&self) -> Option<(f64, f64)> {
        (self.kind != Kind::Model).then_some((self.cost?.median, self.error()?))
    }
}

/// One measurement of one setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Sample {
    /// The window it was measured in [s], and the frames of the reference: another reference, another error.
    window: (f64, usize),
    /// Processor time per simulated second [s/s].
    cost: f64,
    /// What the run was worth, or why it failed.
    outcome: Result<Worth, String>,
}

/// Why there is no study.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene.
    #[error("{0}")]
    Input(#[from] Problems),
    /// The scene as written cannot be run.
    #[error("{0}")]
    Run(#[from] Failure),
}

/// Studies the scene `source`; `progress` hears what is being done and the share of the budget used.
///
/// # Errors
/// Faults of the scene, or a run of it as written that fails.
pub fn run(
    source: &Source,
    request: &Request,
    store: &impl Store,
    mut progress: impl FnMut(&str, f64),
) -> Result<Study, Error> {
    let started = Instant::now();
    let by = |share: f64| started + Duration::from_secs_f64(share * request.budget_s);
    let mut tell = |what: &str| progress(what, started.elapsed().as_secs_f64() / request.budget_s);

    tell("the scene as written");
    let written = Case::build(source)?;
    let common = common(&written);
    let mut changed = source.clone();
    changed.set(&common)?;
    let base = Case::build(&changed)?;
    let (first, base_seconds) = timed(&base);
    let first = first?;
    let shares = Shares::of(&base);

    tell("the reference");
    let flight = flight(&base, first.extremes.first_contact, request, by(shares.reference));
    let reference = reference::reference(source, &base, &common, &flight);

    let settings = dials::settings(source, &base, &common);
    let mut bench = Bench {
        reference: reference.as_ref(),
        store,
        samples: vec![Vec::new(); settings.len()],
        left_out: vec![None; settings.len()],
        settings: &settings,
        second_per_unit: base_seconds / units(&base),
    };
    bench.survey(by(shares.survey), &mut tell);
    bench.repeat(by(shares.repeats), &mut tell);
    let measured = bench.measured();

    tell("stability");
    let opened = crate::metrics::deployment::Deployment::of(&base, &first).deployment_time_s;
    let maps = map::maps(&base, opened.max(base.pace.step), by(shares.maps));

    let mut study = Study {
        title: base.scene.title.clone(),
        scene: base.name.clone(),
        scene_hash: written.hash.clone(),
        request: *request,
        took_s: 0.0,
        side_m: base.net.designed_area.sqrt(),
        knot_radius_m: knot_radius(&base),
        floor_m: reference.as_ref().map_or(0.0, Reference::floor),
        front: front_of(&measured, reference.as_ref()).iter().map(|&i| measured[i].label.clone()).collect(),
        orders: orders(&measured, reference.as_ref()),
        reference: reference.map(|reference| reference.quality),
        settings: measured,
        verdicts: Vec::new(),
        maps,
        advice: Advice::default(),
        provenance: Provenance::here(),
    };
    if base.target.is_some() {
        study.verdicts = distributions(source, &base, &common, &settings, request, by(1.0), store, &mut tell);
    }
    study.advice = Advice::of(&study);
    study.took_s = started.elapsed().as_secs_f64();
    Ok(study)
}

/// Shares of the budget after which each stage ends.
struct Shares {
    reference: f64,
    survey: f64,
    repeats: f64,
    maps: f64,
}

impl Shares {
    /// A scene with a target needs time for its ensembles.
    fn of(base: &Case) -> Shares {
        match base.target {
            Some(_) => Shares { reference: 0.15, survey: 0.4, repeats: 0.55, maps: 0.6 },
            None => Shares { reference: 0.35, survey: 0.65, repeats: 0.9, maps: 1.0 },
        }
    }
}

/// What is set in every run of the study: no expectation, frames at times that all steps meet.
fn common(written: &Case) -> Vec<String> {
    let duration = written.scene.duration_s.0;
    let sample = if duration >= 10.0 * SAMPLE { SAMPLE } else { duration };
    vec!["expect=null".to_owned(), format!("output.sample_s={sample}")]
}

/// The flight that the reference is asked for: up to the frame before first contact.
fn flight(
    base: &Case,
    first_contact: Option<f64>,
    request: &Request,
    deadline: Instant,
) -> reference::Request {
    let sample = base.scene.output.sample_s.0;
    let duration = base.scene.duration_s.0;
    let end = first_contact.map_or(duration, |contact| (contact - sample).max(sample));
    let frames = (end / sample + 1e-6).floor() as usize;
    reference::Request {
        times: (0..=frames).map(|frame| frame as f64 * sample).collect(),
        whole: first_contact.is_none() && base.target.is_none(),
        first_contact,
        seed: request.seed,
        deadline,
        at: request.at_s,
    }
}

/// The settings under measurement.
struct Bench<'a, S> {
    settings: &'a [Setting],
    reference: Option<&'a Reference>,
    store: &'a S,
    samples: Vec<Vec<Sample>>,
    left_out: Vec<Option<String>>,
    /// Processor time of a unit of work, for guesses [s].
    second_per_unit: f64,
}

impl<S: Store> Bench<'_, S> {
    /// Each setting once, the cheapest first, as far as time allows.
    fn survey(&mut self, deadline: Instant, tell: &mut impl FnMut(&str)) {
        let guess =
            |setting: &Setting| setting.case.as_ref().map_or(0.0, |case| self.second_per_unit * units(case));
        let mut order: Vec<(f64, usize)> =
            self.settings.iter().enumerate().map(|(i, setting)| (guess(setting), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (guess, place) in order {
            // The scene as written always: the others are set against it.
            let left = deadline.saturating_duration_since(Instant::now()).as_secs_f64();
            if place != 0 && guess > left && !self.is_known(place, 0) {
                let words = format!("left out: about {guess:.1} s, with {left:.1} s left for it");
                self.left_out[place] = Some(words);
                continue;
            }
            tell(&self.settings[place].label);
            self.measure(place);
        }
    }

    /// The front and what is near it again and again, one after the other, so that a machine that
    /// slows down slows all of them.
    fn repeat(&mut self, deadline: Instant, tell: &mut impl FnMut(&str)) {
        for repeat in 1..REPEATS {
            for place in self.near_front() {
                let last = self.samples[place].iter().map(|sample| sample.cost).fold(0.0, f64::max);
                let duration = self.settings[place].case.as_ref().map_or(0.0, |c| c.scene.duration_s.0);
                let left = deadline.saturating_duration_since(Instant::now()).as_secs_f64();
                if self.samples[place].len() == repeat
                    && (last * duration < left || self.is_known(place, repeat))
                {
                    tell(&format!("{}, repeat {}", self.settings[place].label, repeat + 1));
                    self.measure(place);
                }
            }
        }
    }

    fn window(&self) -> (f64, usize) {
        self.reference.map_or((0.0, 0), |reference| (reference.quality.window_s, reference.times.len()))
    }

    fn known(&self, place: usize, number: usize) -> Option<Sample> {
        let case = self.settings[place].case.as_ref().ok()?;
        self.store.known(case, "measured", number).filter(|sample: &Sample| sample.window == self.window())
    }

    fn is_known(&self, place: usize, number: usize) -> bool {
        self.known(place, number).is_some()
    }

    fn measure(&mut self, place: usize) {
        let Ok(case) = &self.settings[place].case else { return };
        let number = self.samples[place].len();
        let sample = self.known(place, number).unwrap_or_else(|| {
            let (run, seconds) = timed(case);
            let outcome = run.map(|run| Worth::of(case, &run, self.reference));
            let sample = Sample {
                window: self.window(),
                cost: seconds / case.scene.duration_s.0,
                outcome: outcome.map_err(|failure| failure.to_string()),
            };
            self.store.keep(case, "measured", number, &sample);
            sample
        });
        self.samples[place].push(sample);
    }

    /// Places of the front, and of settings not much dearer than what it offers at their error.
    fn near_front(&self) -> Vec<usize> {
        let measured = self.measured();
        let front = front_of(&measured, self.reference);
        let floor = self.reference.map_or(0.0, Reference::floor);
        let worth_it = |(cost, error): (f64, f64)| {
            let same = front.iter().filter_map(|&i| measured[i].point()).filter(|p| p.1 <= error.max(floor));
            same.map(|p| p.0).fold(f64::INFINITY, f64::min) * NEAR >= cost
        };
        (0..measured.len()).filter(|&i| i == 0 || measured[i].point().is_some_and(worth_it)).collect()
    }

    fn measured(&self) -> Vec<Measured> {
        let floor = self.reference;
        let mut measured: Vec<Measured> = self
            .settings
            .iter()
            .zip(&self.samples)
            .zip(&self.left_out)
            .map(|((setting, samples), left_out)| Measured::of(setting, samples, left_out.clone()))
            .collect();
        for place in front_of(&measured, floor) {
            measured[place].on_front = true;
        }
        measured
    }
}

impl Measured {
    fn of(setting: &Setting, samples: &[Sample], left_out: Option<String>) -> Measured {
        let worth = samples.first().and_then(|sample| sample.outcome.as_ref().ok());
        let failure = samples.first().and_then(|sample| sample.outcome.as_ref().err());
        let case = setting.case.as_ref();
        let refused = case.err().map(|problems| {
            let words = |p: &Problem| format!("{}: found {}; allowed: {}", p.place, p.found, p.allowed);
            format!("refused: {}", problems.list.iter().map(words).collect::<Vec<_>>().join("; "))
        });
        Measured {
            kind: setting.kind,
            family: setting.family.to_owned(),
            label: setting.label.clone(),
            value: setting.value,
            changes: setting.changes.clone(),
            step_s: case.ok().and_then(|case| case.scene.solver.step_s).map(|step| step.0),
            without: refused.or_else(|| failure.map(|why| format!("failed: {why}"))).or(left_out),
            cost: Cost::of(samples.iter().filter(|s| s.outcome.is_ok()).map(|s| s.cost).collect()),
            worth: worth.cloned(),
            warnings: match (worth, case) {
                (Some(worth), Ok(case)) => worth.warnings(knot_radius(case)),
                _ => Vec::new(),
            },
            on_front: false,
        }
    }
}

fn knot_radius(case: &Case) -> f64 {
    case.net.radius.iter().copied().fold(0.0, f64::max)
}

/// Places of the front: settings of the same equations without a warning.
fn front_of(measured: &[Measured], reference: Option<&Reference>) -> Vec<usize> {
    let points: Vec<(f64, f64)> = measured
        .iter()
        .map(|one| one.point().filter(|_| one.warnings.is_empty()).unwrap_or((f64::NAN, f64::NAN)))
        .collect();
    front::front(&points, reference.map_or(0.0, Reference::floor))
}

fn orders(measured: &[Measured], reference: Option<&Reference>) -> Vec<Order> {
    let floor = reference.map_or(0.0, Reference::floor);
    ["joints, step", "explicit, symplectic", "explicit, Runge-Kutta"]
        .into_iter()
        .filter_map(|family| {
            let of = measured.iter().filter(|one| one.family == family);
            let points: Vec<(f64, f64)> = of.filter_map(|one| Some((one.step_s?, one.error()?))).collect();
            front::order(family, &points, floor)
        })
        .collect()
}

/// Work of a run in units that are about alike, for guesses of its time only.
fn units(case: &Case) -> f64 {
    use crate::solver::{CableModel, Integrator};
    let n_steps = case.n_steps() as f64;
    let n_substeps = n_steps * f64::from(case.pace.substeps);
    let n_cables = case.net.cables.len() as f64;
    match case.scene.solver.cables {
        // A cable and sub-step of the explicit net is about a fiftieth of one of the engine.
        CableModel::Explicit => {
            let stages = if case.scene.solver.integrator == Integrator::Rk4 { 5.0 } else { 1.0 };
            n_cables * (0.02 * stages * n_substeps + 0.1 * n_steps)
        }
        _ => n_cables * (0.5 * n_steps + 0.5 * n_substeps),
    }
}

/// Distributions after contact, of the settings that make a difference there.
#[allow(clippy::too_many_arguments)] // what a stage of the study needs, named once
fn distributions(
    source: &Source,
    base: &Case,
    common: &[String],
    settings: &[Setting],
    request: &Request,
    deadline: Instant,
    store: &impl Store,
    tell: &mut impl FnMut(&str),
) -> Vec<Verdicts> {
    // The finest: the scene's own method with half the step.
    let half = base.scene.solver.step_s.map_or(base.pace.step, |step| step.0) / 2.0;
    let mut finer = source.clone();
    let changes: Vec<String> = common.iter().cloned().chain([format!("solver.step_s={half:e}")]).collect();
    let finer = finer.set(&changes).and_then(|()| Case::build(&finer));
    let chosen = ["joints 2 ms", "joints 1 ms"];
    let mut cases: Vec<(&str, &Case)> =
        finer.as_ref().map(|case| ("as written, half the step", case)).into_iter().collect();
    cases.extend(settings.iter().filter_map(|setting| {
        let case = setting.case.as_ref().ok()?;
        let asked = setting.kind != Kind::Method
            || setting.family == dials::AS_WRITTEN
            || setting.family == "joints, precision"
            || setting.family == "joints, flight explicit"
            || setting.family == "other cables"
            || chosen.contains(&setting.label.as_str());
        asked.then_some((setting.label.as_str(), case))
    }));
    let ensemble =
        ensemble::Request { members: verdicts::MAX_MEMBERS, perturb_m: PERTURB, seed: request.seed };
    let mut round = 0;
    let members = verdicts::run(&cases, &ensemble, deadline, store, || {
        round += 1;
        tell(&format!("ensembles, member {round}"));
    });
    let mut verdicts: Vec<Verdicts> =
        cases.iter().zip(&members).filter_map(|((label, _), members)| Verdicts::of(label, members)).collect();
    if let Some((finest, others)) = verdicts.split_first_mut() {
        for other in others {
            other.agrees = Some(other.overlaps(finest));
        }
    }
    verdicts
}
