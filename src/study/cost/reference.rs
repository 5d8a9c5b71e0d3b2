//! What the errors are measured against: the free flight of the net, known far better than any run.
//!
//! Two integrators that share no code, several runs each: the `located` one, which locates every cable
//! that goes taut or slack, with two tolerances; and the secant force with a step far below its
//! limit, and with twice that. Further runs of both start a nanometre aside. A net that opens is chaotic: its inner knots
//! forget their start within tenths of a second, and from then on no run, however fine, has a
//! bullet nearer to the truth than those nanometres allow. So
//!
//! - the reference is the mean of the located integrator's runs,
//! - the floor is the largest distance of one of them from it, of another tolerance or step or from another start: no error
//!   below it means anything,
//! - the horizon is when the mean of the other integrator's runs leaves it by more than the trust
//!   distance,
//! - errors are quoted in two windows: before chaos, where the floor is tiny, and up to the horizon.
//!
//! Effects that act in flight are not in the located flight; then the two are the secant force and the symplectic one. At the
//! same price the secant force knows the Cubesat's bullets at 0.15 s to 1e-7 m, the source's Runge-Kutta steps to 2e-5 m.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::budget;
use super::dials::{explicit_changes, name};
use crate::case::Case;
use crate::interaction::Interactions;
use crate::metrics::deployment::Deployment;
use crate::run::Run;
use crate::scene::Source;
use crate::solver::{Integrator, Solver};
use crate::step::mass_spring::dopri5;
use crate::step::mass_spring::stability::stable_step;
use crate::study::ensemble::{self, Quartiles, moved};

/// Perturbation of the start [m].
pub const PERTURB: f64 = 1e-9;

/// Runs of each integrator.
const RUNS: usize = 6;

/// Fewest, where more cannot be paid: one, a coarser one, and one from another start.
const FEWEST_RUNS: usize = 3;

/// Local error of the located integrator over the net's side [-]: of its first run, and of the others.
const TOLERANCES: [f64; 2] = [1e-14, 1e-13];

/// Step of the fine runs of the explicit net over the stable step [-].
const FINE: f64 = 0.015;

/// The longest step of such a run that is still fine, over the stable step [-].
const ROUGH: f64 = 0.2;

/// Step of their second run over that of the others [-]: by as much as the two differ the finer one errs, where the order is the
/// first, as it is once cables go taut and slack.
pub const COARSER: f64 = 2.0;

/// Trust distance over the net's side [-].
pub const TRUST: f64 = 1e-4;

/// Before chaos the floor is below this share of the net's side [-].
const CLEAN: f64 = 1e-8;

/// Positions of all knots, frame by frame [m].
pub type KnotFrames = Vec<Vec<Vector3<f64>>>;

/// The reference.
pub struct Reference {
    /// Times of its frames [s].
    pub times: Vec<f64>,
    /// Where the knots are.
    pub knots: KnotFrames,
    /// The four bullets.
    pub bullets: [usize; 4],
    /// How well it is known.
    pub quality: Quality,
}

/// How well a reference is known; a value a frame in the lists.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quality {
    /// Times [s].
    pub time_s: Vec<f64>,
    /// Largest distance of a bullet between a run of the reference and their mean, so far [m]: the floor.
    pub floor_m: Vec<f64>,
    /// The same of any knot [m].
    pub floor_knots_m: Vec<f64>,
    /// Largest distance of a bullet between the means of the two integrators [m]; the floor where there is one.
    pub means_apart_m: Vec<f64>,
    /// Pairs of single runs.
    pub pairs: Vec<RunPair>,
    /// Distance up to which runs agree [m].
    pub trust_distance_m: f64,
    /// Until when the two means agree [s].
    pub horizon_s: f64,
    /// Until when the largest difference of single runs that start a nanometre apart stays below it [s].
    pub single_run_horizon_s: f64,
    /// Up to where errors are quoted: before chaos, and to the horizon.
    pub windows: Vec<Window>,
    /// First contact of the scene as written [s]: the flight ends before it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_contact_s: Option<f64>,
    /// The two integrators, in words.
    pub methods: [String; 2],
    /// Runs of each.
    pub runs: [usize; 2],
    /// What the second integrator's runs say of the whole run, by the summary's names: only where the
    /// flight lasts to its end.
    pub scalars: BTreeMap<String, Quartiles>,
}

/// A time up to which errors are quoted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Window {
    /// Its name.
    pub name: String,
    /// Its end [s].
    pub end_s: f64,
    /// The floor of the bullets within it [m].
    pub floor_m: f64,
}

/// Two single runs from the same start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunPair {
    /// Which.
    pub names: [String; 2],
    /// Until when they agree [s].
    pub horizon_s: f64,
}

/// One run of a reference.
struct ReferenceRun {
    name: String,
    knots: KnotFrames,
    /// What it says of the whole run.
    scalars: Vec<(&'static str, f64)>,
}

/// What a reference is asked for.
#[derive(Clone)]
pub struct ReferenceRequest {
    /// Times of its frames [s], from 0.
    pub times: Vec<f64>,
    /// Whether they last to the end of the run.
    pub whole: bool,
    /// First contact of the scene as written [s].
    pub first_contact: Option<f64>,
    /// Seed of the perturbations.
    pub seed: u64,
    /// What it may cost (see [`budget`]) [s].
    pub seconds: f64,
    /// Where errors are to be quoted [s], if not where the floor says.
    pub at: Option<f64>,
}

/// The reference for `base`, the case of `source`.
///
/// Nothing when no two runs of one integrator reached two frames for what it may cost.
pub fn reference(source: &Source, base: &Case, request: &ReferenceRequest) -> Option<Reference> {
    let quiet = !Interactions::new(base.scene().effects.build(&base.context())).act();
    let (runs, request) = &affordable(base, request, quiet);
    let mut groups = flown(source, base, request, quiet, *runs);
    let mut methods = integrators(quiet).map(|integrator| match integrator {
        Integrator::Located => "Dormand-Prince 5(4), switches located".to_owned(),
        stepped => name(stepped),
    });
    // An integrator that the scene refuses, or that was too slow, leaves the other one. One run alone has
    // no spread, hence no floor.
    if groups[0].len() < 2 {
        groups.swap(0, 1);
        methods.swap(0, 1);
    }
    if groups[0].len() < 2 {
        return None;
    }
    Reference::of(base, groups, methods, request)
}

/// The integrators of the reference and of what it is trusted by: a `quiet` flight has nothing but the net in it.
fn integrators(quiet: bool) -> [Integrator; 2] {
    if quiet {
        [Integrator::Located, Integrator::Secant]
    } else {
        [Integrator::Secant, Integrator::Symplectic]
    }
}

/// Runs of each integrator, and of the flight of `request` as much, that can be fine for what it may cost: a large net that flies for
/// long is known for a part of its flight, by fewer runs.
fn affordable(base: &Case, request: &ReferenceRequest, quiet: bool) -> (usize, ReferenceRequest) {
    let Some(&end) = request.times.last() else { return (FEWEST_RUNS, request.clone()) };
    let rough = ROUGH * stable_step(base.net());
    // Of a step that is rough, over that what a run may cost.
    let dear = |runs: usize| {
        let stepped = integrators(quiet).into_iter().filter(|one| *one != Integrator::Located);
        let shortest = stepped.map(|one| shortest_step(base, end, one, request.seconds / (2 * runs) as f64));
        shortest.fold(0.0, f64::max) / rough
    };
    let runs = (FEWEST_RUNS..=RUNS).rev().find(|&runs| dear(runs) <= 1.0);
    let runs = runs.unwrap_or(FEWEST_RUNS);
    let until = end / dear(runs).max(1.0);
    let mut request = request.clone();
    request.times.retain(|time| *time <= until + 1e-9);
    request.whole &= until >= end;
    (runs, request)
}

/// The shortest step of a flight of the net of `base` until `end` [s] with an `integrator` of the explicit net that `allowed` seconds
/// pay for [s].
fn shortest_step(base: &Case, end: f64, integrator: Integrator, allowed: f64) -> f64 {
    let solver = Solver { integrator, ..base.scene().solver.with_pair("explicit+impulse") };
    budget::shortest_step(base.net(), end, &solver, allowed)
}

/// The runs of the two integrators, so many of each.
fn flown(
    source: &Source,
    base: &Case,
    request: &ReferenceRequest,
    quiet: bool,
    runs: usize,
) -> [Vec<ReferenceRun>; 2] {
    // A fair share for each run, so that one does not starve the others.
    let allowed = request.seconds / (2 * runs) as f64;
    let fly = |index: usize| {
        let member = index / 2;
        match integrators(quiet)[index % 2] {
            Integrator::Located => Some(located(base, member, request, allowed)),
            integrator => stepped(source, base, integrator, member, request, allowed),
        }
    };
    let all: Vec<Option<ReferenceRun>> = (0..2 * runs).into_par_iter().with_max_len(1).map(fly).collect();
    // A run that was stopped early would shorten all of them.
    let longest = all.iter().flatten().map(|run| run.knots.len()).max().unwrap_or(0);
    let mut groups = [Vec::new(), Vec::new()];
    for (index, run) in all.into_iter().enumerate() {
        groups[index % 2].extend(run.filter(|run| 2 * run.knots.len() > longest));
    }
    groups
}

/// A run of the located integrator up to the last time of the request, with the steps that the `allowed` seconds
/// pay for.
fn located(base: &Case, member: usize, request: &ReferenceRequest, allowed: f64) -> ReferenceRun {
    let tolerance = TOLERANCES[member.min(1)] * base.net().designed_area.sqrt();
    let case = start(base, member, request.seed);
    let most = budget::located_steps(case.net(), allowed);
    let knots = dopri5::fly(case.net(), &request.times, tolerance, |steps| steps < most).knots;
    ReferenceRun { name: format!("located, {tolerance:.0e} m a step"), knots, scalars: Vec::new() }
}

/// `case` for a run of a reference: the second, which is coarser, starts where the first does; the others are perturbed.
fn start(case: &Case, member: usize, seed: u64) -> Case {
    let request = ensemble::EnsembleRequest { members: RUNS, perturb_m: PERTURB, seed, at_most_s: None };
    if member < 2 { case.clone() } else { moved(case, &request, member - 1) }
}

/// A run of the explicit net up to the last time of the request: with the finest step that the `allowed` seconds
/// pay for.
fn stepped(
    source: &Source,
    base: &Case,
    integrator: Integrator,
    member: usize,
    request: &ReferenceRequest,
    allowed: f64,
) -> Option<ReferenceRun> {
    let end = *request.times.last()?;
    let shortest = shortest_step(base, end, integrator, allowed);
    let stable = stable_step(base.net());
    let step = (FINE * stable).max(shortest);
    if step > ROUGH * stable {
        return None;
    }
    let step = if member == 1 { COARSER * step } else { step };
    let mut changes = explicit_changes(integrator, step);
    changes.extend([format!("duration_s={end}"), "capture.hold_s=0".to_owned()]);
    let mut source = source.clone();
    source.set(&changes).ok()?;
    let case = start(&Case::build(&source).ok()?, member, request.seed);
    let name = format!("{} {:.2} µs", name(integrator), 1e6 * step);
    let run = Run::of(&case, |_| {}).ok()?;
    let scalars = if request.whole { scalars(&case, &run) } else { Vec::new() };
    Some(ReferenceRun { name, knots: at_times(&run, &request.times), scalars })
}

/// Up to where errors are quoted, of a flight whose bullets are known to `floor` [m] at `times` [s] and whose
/// integrators agree until `horizon` [s]: before chaos, and to the horizon or to `at` [s].
fn windows(times: &[f64], floor: &[f64], side: f64, horizon: f64, at: Option<f64>) -> Vec<Window> {
    let below = |share: f64| floor.partition_point(|floor| *floor <= share * side).max(2) - 1;
    let asked = at.map(|at| times.partition_point(|time| *time <= at + 1e-9).max(2) - 1);
    let trusted = times.partition_point(|time| *time <= horizon) - 1;
    let ends = [
        ("before chaos", below(CLEAN)),
        (
            if asked.is_some() { "as asked for" } else { "to the horizon" },
            asked.unwrap_or_else(|| below(TRUST)).min(trusted).max(1),
        ),
    ];
    let window =
        |(name, end): (&str, usize)| Window { name: name.to_owned(), end_s: times[end], floor_m: floor[end] };
    let mut windows: Vec<Window> = ends.into_iter().map(window).collect();
    // A flight that ends before chaos begins has one window.
    if windows[0].end_s >= windows[1].end_s {
        windows.remove(0);
    }
    windows
}

/// The frames of `run` at `times`, as many as it has.
pub fn at_times(run: &Run, times: &[f64]) -> KnotFrames {
    let found = |time: &f64| {
        let frame = run.frames.time.partition_point(|t| *t < time - 1e-9);
        let there = run.frames.time.get(frame).is_some_and(|t| (t - time).abs() < 1e-9);
        there.then(|| run.frames.knots[frame].clone())
    };
    times.iter().map_while(found).collect()
}

impl Reference {
    fn of(
        base: &Case,
        groups: [Vec<ReferenceRun>; 2],
        methods: [String; 2],
        request: &ReferenceRequest,
    ) -> Option<Reference> {
        let members = groups.iter().flatten();
        let frames = members.map(|member| member.knots.len()).min().filter(|&frames| frames > 1)?;
        let bullets = base.net().bullets;
        let times = request.times[..frames].to_vec();
        let knots = mean(&groups[0], frames);
        let trust_distance = TRUST * base.net().designed_area.sqrt();
        let until = |curve: &[f64]| {
            times[curve.iter().position(|apart| *apart > trust_distance).unwrap_or(frames).max(1) - 1]
        };

        let all: Vec<usize> = (0..base.net().n_knots()).collect();
        let spread = |knots_of: &[usize]| -> Vec<f64> {
            let mut so_far = 0.0_f64;
            (0..frames)
                .map(|frame| {
                    let far = groups[0].iter().map(|run| largest(&run.knots[frame], &knots[frame], knots_of));
                    so_far = far.fold(so_far, f64::max);
                    so_far
                })
                .collect()
        };
        let (floor, floor_knots) = (spread(&bullets), spread(&all));
        // Without a second integrator there is nothing but its own spread to trust the first one by.
        let means_apart: Vec<f64> = if groups[1].is_empty() {
            floor.clone()
        } else {
            let other = mean(&groups[1], frames);
            (0..frames).map(|frame| largest(&knots[frame], &other[frame], &bullets)).collect()
        };
        let horizon = until(&means_apart);

        let unperturbed: Vec<&ReferenceRun> = groups[0].iter().take(2).chain(groups[1].first()).collect();
        let pair = |one: &ReferenceRun, other: &ReferenceRun| {
            let apart = |frame: usize| largest(&one.knots[frame], &other.knots[frame], &bullets);
            let names = [one.name.clone(), other.name.clone()];
            RunPair { names, horizon_s: until(&(0..frames).map(apart).collect::<Vec<_>>()) }
        };
        let pairs = (0..unperturbed.len())
            .flat_map(|i| (0..i).map(move |before| (before, i)))
            .map(|(before, i)| pair(unperturbed[before], unperturbed[i]))
            .collect();
        let windows = windows(&times, &floor, base.net().designed_area.sqrt(), horizon, request.at);
        Some(Reference {
            bullets,
            quality: Quality {
                time_s: times.clone(),
                single_run_horizon_s: until(&floor),
                floor_m: floor,
                floor_knots_m: floor_knots,
                means_apart_m: means_apart,
                pairs,
                trust_distance_m: trust_distance,
                horizon_s: horizon,
                windows,
                first_contact_s: request.first_contact,
                runs: [groups[0].len(), groups[1].len()],
                scalars: quartiles(&groups[1]),
                methods,
            },
            times,
            knots,
        })
    }

    /// Frames up to the end of each window.
    pub fn window_frames(&self) -> Vec<usize> {
        let frames = |window: &Window| self.times.partition_point(|time| *time <= window.end_s + 1e-9);
        self.quality.windows.iter().map(frames).collect()
    }
}

fn mean(members: &[ReferenceRun], frames: usize) -> KnotFrames {
    let share = 1.0 / members.len() as f64;
    (0..frames)
        .map(|frame| {
            let n_knots = members[0].knots[frame].len();
            (0..n_knots).map(|knot| members.iter().map(|m| share * m.knots[frame][knot]).sum()).collect()
        })
        .collect()
}

/// Largest distance of one of the `bullets` of `run` from where the `knots` were at `times`, frame by frame [m]; as
/// many as `run` has.
pub fn bullets_apart(run: &Run, times: &[f64], knots: &KnotFrames, bullets: &[usize; 4]) -> Vec<f64> {
    let found = at_times(run, times);
    found.iter().zip(knots).map(|(found, there)| largest(found, there, bullets)).collect()
}

/// Largest distance between two places of the same knot, of those listed [m].
pub fn largest(one: &[Vector3<f64>], other: &[Vector3<f64>], knots: &[usize]) -> f64 {
    knots.iter().map(|&knot| (one[knot] - other[knot]).norm()).fold(0.0, f64::max)
}

/// Numbers of a whole flight, by the names of the summary.
pub fn scalars(case: &Case, run: &Run) -> Vec<(&'static str, f64)> {
    let opened = Deployment::of(case, run);
    vec![
        ("max_area_m2", opened.max_area_m2),
        ("deployment_time_s", opened.deployment_time_s),
        ("travelling_distance_m", opened.travelling_distance_m),
        ("effective_period_s", opened.effective_period_s),
        ("max_tension_n", run.extremes.tension),
    ]
}

fn quartiles(members: &[ReferenceRun]) -> BTreeMap<String, Quartiles> {
    let mut values: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (name, value) in members.iter().flat_map(|member| &member.scalars) {
        values.entry((*name).to_owned()).or_default().push(*value);
    }
    values.into_iter().map(|(name, values)| (name, Quartiles::of(values))).collect()
}
