//! What accuracy costs in time, on one's own scene and machine.
//!
//! Every dial that trades accuracy for time is turned, one at a time, and each setting is set against
//! a reference made on the spot: before contact by the paths of the knots, after it by what must be
//! kept and by the distribution of verdicts. A budget bounds the study, in work that is counted; what it does
//! not cover is left out.
//!
//! | stage | does |
//! |---|---|
//! | [`budget`] | what the study may spend, and what a run costs |
//! | [`first`] | the scene as written: what follows from it for all others |
//! | [`dials`] | the settings |
//! | [`reference`] | the free flight, known far better than any run, and where chaos ends that |
//! | [`bench`], [`errors`], [`timing`] | what a run is worth, and what it costs |
//! | [`front`] | the settings worth their time; the order of convergence |
//! | [`verdicts`] | after contact: distributions |
//! | [`map`] | where a method is stable |
//! | [`advice`] | what to use, in a sentence |
//! | [`calibration`], [`accuracy`] | a setting that reaches an accuracy, for `run --accuracy` |

pub mod accuracy;
pub mod advice;
pub mod bench;
pub mod budget;
pub mod calibration;
pub mod dials;
pub mod errors;
pub mod first;
pub mod front;
pub mod map;
pub mod reference;
pub mod timing;
pub mod verdicts;

use std::time::Instant;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::failure::Failure;
use crate::limits::Limit;
use crate::problems::Problems;
use crate::provenance::Provenance;
use crate::scene::Source;

use advice::Advice;
use bench::BenchmarkRunner;
use budget::Extent;
use dials::DialKind;
use errors::Evaluation;
use first::FirstRun;
use front::Order;
use map::Map;
use reference::{Quality, Reference, Window};
use timing::Cost;
use verdicts::Verdicts;

/// Frames of a run: time between them where a run lasts long enough [s].
const SAMPLE: f64 = 0.01;

/// What a study is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StudyRequest {
    /// What it may spend: processor time of a quiet core, counted (see [`budget`]) [s].
    pub budget_s: f64,
    /// Seed of the perturbations.
    pub seed: u64,
    /// Time up to which errors are quoted, beside those before chaos [s]; null: as far as the floor allows.
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
    pub request: StudyRequest,
    /// What it took [s].
    pub took_s: f64,
    /// Side of the net [m].
    pub side_m: f64,
    /// Largest radius of a knot [m].
    pub knot_radius_m: f64,
    /// How well the reference is known; null where there is none.
    pub reference: Option<Quality>,
    /// How far settings were run, where runs to the scene's end were too dear [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured_until_s: Option<f64>,
    /// What the scene as written costs to its end [s/s]; null where that was too dear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub written_cost: Option<f64>,
    /// Every setting.
    pub settings: Vec<MeasuredSetting>,
    /// Labels of those on the front of each window of the reference, from the cheapest to the most accurate.
    pub fronts: Vec<Vec<String>>,
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
pub struct MeasuredSetting {
    /// What it changes.
    pub kind: DialKind,
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
    pub worth: Option<Evaluation>,
    /// What is wrong with it.
    pub warnings: Vec<String>,
    /// Numbers of the windows on whose front it is.
    pub fronts: Vec<usize>,
}

impl MeasuredSetting {
    /// Its error within window number `window`: the largest distance of a bullet [m].
    pub fn error(&self, window: usize) -> Option<f64> {
        Some(self.worth.as_ref()?.apart.get(window)?.as_ref()?.bullets.max_m)
    }

    /// Its place in the diagram of a window, if it belongs there: cost [s/s] and error [m].
    pub fn point(&self, window: usize) -> Option<(f64, f64)> {
        (self.kind != DialKind::Model).then_some((self.cost?.median, self.error(window)?))
    }
}

impl Study {
    /// The windows in which errors are quoted; none without a reference.
    pub fn windows(&self) -> &[Window] {
        self.reference.as_ref().map_or(&[], |quality| &quality.windows)
    }

    /// Number of the longest window whose floor is below `accuracy` metres.
    pub fn window_for(&self, accuracy: f64) -> Option<usize> {
        self.windows().iter().rposition(|window| window.floor_m <= accuracy)
    }
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
    request: &StudyRequest,
    store: &impl Store,
    mut progress: impl FnMut(&str, f64),
) -> Result<Study, Error> {
    let started = Instant::now();
    let whole = request.budget_s;
    let mut tell = |what: &str, spent: f64| progress(what, spent / whole);

    tell("the scene as written", 0.0);
    let written = Case::build(source)?;
    let source = &studied(source, &written)?;
    let base = Case::build(source)?;
    let first = FirstRun::of(&base, whole)?;
    let shares = Shares::of(&base);
    let mut spent = budget::price(&base, &first.run.work);

    tell("the reference", spent);
    let asked = shares.reference * whole;
    let reference = reference::reference(source, &base, &flight(&base, &first, request, asked));
    spent += asked;

    let settings = dials::settings(source, &base);
    let survey = (shares.survey * whole).min(whole - spent);
    let cut = first.flight_only(source, &base, &settings, survey, reference.as_ref());
    let in_flight = cut.as_ref().map(|(source, base)| dials::settings(source, base));
    let extent = if cut.is_some() { Extent::Flight } else { Extent::Whole(&first.run.work) };
    let mut bench =
        BenchmarkRunner::new(in_flight.as_ref().unwrap_or(&settings), reference.as_ref(), store, extent);
    if cut.is_none() {
        bench.take_over(&first.run, first.seconds);
    }
    let before = spent;
    spent += bench.measure_all(survey, shares.repeats * whole, |what, since| tell(what, before + since));
    let measured = bench.measured();
    let prices = first.prices(&settings, &bench, extent);

    tell("stability", spent);
    let opened = crate::metrics::deployment::Deployment::of(&base, &first.run).deployment_time_s;
    let maps = map::maps(&base, opened.max(base.time_step().step), shares.maps * whole)?;
    spent += shares.maps * whole;

    let mut study = Study {
        title: base.scene().title.clone(),
        scene: base.name().to_owned(),
        scene_hash: written.hash().to_owned(),
        request: *request,
        took_s: 0.0,
        side_m: base.net().designed_area.sqrt(),
        knot_radius_m: knot_radius(&base),
        measured_until_s: cut.as_ref().map(|(_, case)| case.scene().duration_s.0),
        written_cost: first.is_whole.then(|| first.seconds / base.scene().duration_s.0),
        fronts: fronts(&measured, reference.as_ref()),
        orders: orders(&measured, reference.as_ref()),
        reference: reference.map(|reference| reference.quality),
        settings: measured,
        verdicts: Vec::new(),
        maps,
        advice: Advice::default(),
        provenance: Provenance::here(),
    };
    if base.target().is_some() {
        let seed = request.seed;
        let asked = verdicts::Asked { seed, seconds: whole - spent, work: &first.run.work, prices: &prices };
        study.verdicts =
            verdicts::distributions(source, &base, &settings, &asked, store, &mut |what| tell(what, spent));
    }
    study.advice = Advice::of(&study);
    study.took_s = started.elapsed().as_secs_f64();
    Ok(study)
}

/// Shares of the budget, stage by stage; what is left is for the ensembles.
struct Shares {
    reference: f64,
    survey: f64,
    repeats: f64,
    maps: f64,
}

impl Shares {
    /// A scene with a target needs time for its ensembles.
    fn of(base: &Case) -> Shares {
        match base.target() {
            Some(_) => Shares { reference: 0.15, survey: 0.3, repeats: 0.15, maps: 0.05 },
            None => Shares { reference: 0.35, survey: 0.3, repeats: 0.25, maps: 0.1 },
        }
    }
}

/// The scene as all runs of the study have it: no expectation, frames at times that all steps meet.
fn studied(source: &Source, written: &Case) -> Result<Source, Problems> {
    let duration = written.scene().duration_s.0;
    // Fewer frames of a large net: what is recorded has a limit.
    let least = 2.0 * duration * written.net().n_knots() as f64 / source.limits.of(Limit::Positions) as f64;
    let sample = SAMPLE * (least / SAMPLE).ceil().max(1.0);
    let sample = if duration >= 10.0 * sample { sample } else { duration };
    let mut source = source.clone();
    source.set(&["expect=null".to_owned(), format!("output.sample_s={sample}")])?;
    Ok(source)
}

/// The flight that the reference is asked for: up to the frame before first contact.
fn flight(
    base: &Case,
    first: &FirstRun,
    request: &StudyRequest,
    seconds: f64,
) -> reference::ReferenceRequest {
    let end = first.end_of_flight();
    reference::ReferenceRequest {
        times: flight_times(base, end),
        whole: end.is_none() && base.target().is_none(),
        first_contact: first.run.extremes.first_contact,
        seed: request.seed,
        seconds,
        at: request.at_s,
    }
}

/// Times of the frames before `first_contact` [s]; of all where there is none.
fn flight_times(base: &Case, first_contact: Option<f64>) -> Vec<f64> {
    let sample = base.scene().output.sample_s.0;
    let duration = base.scene().duration_s.0;
    let end = first_contact.map_or(duration, |contact| (contact - sample).max(sample));
    let frames = (end / sample + 1e-6).floor() as usize;
    (0..=frames).map(|frame| frame as f64 * sample).collect()
}

fn knot_radius(case: &Case) -> f64 {
    case.net().radius.iter().copied().fold(0.0, f64::max)
}

/// Places of the front of a window: settings of the method, without a warning. Another answer to
/// contact changes nothing before it.
fn front_of(measured: &[MeasuredSetting], window: usize, floor: f64) -> Vec<usize> {
    let points: Vec<(f64, f64)> = measured
        .iter()
        .map(|one| {
            let sound = one.kind == DialKind::Method && one.warnings.is_empty();
            one.point(window).filter(|_| sound).unwrap_or((f64::NAN, f64::NAN))
        })
        .collect();
    front::front(&points, floor)
}

/// Labels of the fronts, window by window.
fn fronts(measured: &[MeasuredSetting], reference: Option<&Reference>) -> Vec<Vec<String>> {
    let windows = reference.iter().flat_map(|reference| &reference.quality.windows).enumerate();
    windows
        .map(|(window, Window { floor_m, .. })| {
            let front = front_of(measured, window, *floor_m);
            front.into_iter().map(|place| measured[place].label.clone()).collect()
        })
        .collect()
}

/// Observed orders in the first window: later chaos hides them.
fn orders(measured: &[MeasuredSetting], reference: Option<&Reference>) -> Vec<Order> {
    let first = reference.and_then(|reference| reference.quality.windows.first());
    let floor = first.map_or(0.0, |window| window.floor_m);
    ["joints, step", "explicit, symplectic", "explicit, secant", "explicit, Runge-Kutta"]
        .into_iter()
        .filter_map(|family| {
            let of = measured.iter().filter(|one| one.family == family);
            let points: Vec<(f64, f64)> = of.filter_map(|one| Some((one.step_s?, one.error(0)?))).collect();
            front::order(family, &points, floor)
        })
        .collect()
}
