//! `run --accuracy`: the cheapest setting that reaches an accuracy, found on the flight of the scene itself.
//!
//! What a step errs by depends on the net's material, damping, speed and size, so a table made on other scenes says
//! little. The scene's own flight, from the fold to the first contact, is short: it is flown finely, with all its effects,
//! then by the scene's own method with its own step and with halves of it, from the cheapest on, until one of them has
//! its bullets near enough. Contact, effects and whatever else the scene says stay as they are. What a calibration may
//! cost is counted in work (see [`budget`]), so the same setting is found on every machine.
//!
//! The fine flight is that of the secant integrator, the finest that the calibration can pay. How well it is known
//! say a coarser one and one that starts a nanometre aside. Measured against the located integrator on the Table 3.2 net:
//! the secant step of 1e-5 s errs by 2e-6 m at 0.3 s and 1e-5 m at 0.4 s, symplectic steps of 4.4e-6 s by 4e-5 and
//! 1e-4 m; the located integrator itself costs ten times as much, more than a calibration may, and is changed by 1e-5 m
//! at 0.5 s and by 1e-3 m at 0.8 s where its start is changed by rounding.

use serde_json::Value;

use super::accuracy::Accuracy;
use super::budget::{self, Budget};
use super::dials::{explicit_changes, name, two_digits};
use super::reference::{COARSER, KnotFrames, PERTURB, at_times, bullets_apart, largest};
use super::{Error, advice, flight_times, studied};
use crate::case::Case;
use crate::failure::Failure;
use crate::problems::Problems;
use crate::run::Run;
use crate::scene::Source;
use crate::simulation::Simulation;
use crate::solver::{Flight, Integrator, Solver};
use crate::step;
use crate::step::mass_spring::stability::stable_step;
use crate::study::ensemble::{EnsembleRequest, moved};
use crate::work::Work;

/// What a calibration may cost, over the run that it is for [-].
const SHARE: f64 = 0.1;

/// What it may cost however short the run is, of a quiet core [s].
const LEAST: f64 = 1.0;

/// Share of that for the reference.
const REFERENCE: f64 = 0.6;

/// Times that a step is halved, at most.
const HALVINGS: i32 = 7;

/// The shortest step of the fine flight over the stable step [-]: beyond, chaos decides.
const FINEST: f64 = 0.05;

/// The longest step that is still fine, over the stable step [-].
const FINE: f64 = 0.4;

/// How well the fine flight must be known, over the accuracy that it is to tell [-].
const TELLS: f64 = 0.3;

/// Share of the flight for which it must be able to tell it [-].
const ENOUGH: f64 = 0.2;

/// A setting that reaches an accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// What it changes in the scene, as for `--set`; empty where the scene as written will do.
    pub changes: Vec<String>,
    /// Largest distance of a bullet from the fine flight until then, and how well that is known [m].
    pub error_m: f64,
    /// Until when the fine flight can tell [s].
    pub until_s: f64,
    /// End of the flight: first contact, or the end of the run [s].
    pub flight_s: f64,
    /// Settings that were measured.
    pub measured: usize,
    /// What the calibration cost, counted in work of a quiet core [s].
    pub spent_s: f64,
    /// What the run will cost, counted, without its contacts [s].
    pub run_s: f64,
}

impl Calibration {
    /// The calibration in a sentence.
    pub fn words(&self) -> String {
        let what =
            if self.changes.is_empty() { "the scene as written".to_owned() } else { self.changes.join(" ") };
        let until = if self.until_s < self.flight_s {
            format!(
                "until {:.3} s of a flight of {:.3} s, beyond which fine flights differ by as much",
                self.until_s, self.flight_s
            )
        } else {
            format!("in all the flight of {:.3} s", self.flight_s)
        };
        format!(
            "{what}: bullets within {} {until} (measured on this scene, {} tried; {} of processor time, for a run of {})",
            advice::length(self.error_m),
            self.measured,
            advice::seconds(self.spent_s),
            advice::seconds(self.run_s),
        )
    }
}

/// The cheapest setting of the scene `source` that reaches `accuracy` before contact; `own` changes of the user go on
/// top of every setting.
///
/// # Errors
/// Faults of the scene; an accuracy that nobody can tell on it, or that no setting reaches, with the reason; a
/// flight that fails.
pub fn calibrate(source: &Source, own: &[String], accuracy: Accuracy) -> Result<Calibration, Error> {
    let written = Case::build(source)?;
    let source = studied(source, &written)?;
    let base = Case::build(&source)?;
    let wanted = accuracy.length(base.net().designed_area.sqrt());
    let run_s = budget::forecast(&base, &Work::default());
    let allowed = (SHARE * run_s).max(LEAST);

    let mut budget = Budget::new(allowed);
    let fine = FineFlight::of(&source, &base, wanted, REFERENCE * allowed)?;
    budget.spend(fine.cost);
    let until = fine.tells(wanted)?;
    let flight_s = fine.times[fine.times.len() - 1];
    let (mut measured, mut finest, mut unpaid) = (0, f64::INFINITY, 0);
    for Candidate { changes, case, cost, .. } in candidates(&source, own, &base, flight_s) {
        if !budget.covers(cost) {
            unpaid += 1;
            continue;
        }
        budget.spend(cost);
        let Ok(run) = Run::of(&case, |_| {}) else { continue };
        let apart = bullets_apart(&run, &fine.times, &fine.knots, &fine.bullets);
        // A step that has no frames at these times cannot be compared.
        let Some(apart) = apart.get(..until) else { continue };
        measured += 1;
        let error_m = fine.floor[until - 1] + apart.iter().copied().fold(0.0, f64::max);
        finest = finest.min(error_m);
        if error_m <= wanted {
            let until_s = fine.times[until - 1];
            let spent_s = allowed - budget.left();
            return Ok(Calibration { changes, error_m, until_s, flight_s, measured, spent_s, run_s });
        }
    }
    let may = advice::seconds(allowed);
    let best = || {
        let least = advice::length(finest);
        format!("at least {least}, the best of {measured} settings measured on this scene")
    };
    let rule = match (measured, unpaid) {
        (0, 0) => "no accuracy: no flight of this scene can be set against a fine one".to_owned(),
        (0, _) => format!("no accuracy: each of {unpaid} settings costs more than a calibration may, {may}"),
        (_, 0) => best(),
        _ => format!("{}; {unpaid} finer ones cost more than a calibration may, {may}", best()),
    };
    Err(refused(wanted, rule))
}

fn refused(wanted: f64, rule: String) -> Error {
    let mut problems = Problems::new("--accuracy");
    problems.add("", advice::length(wanted), rule);
    problems.into()
}

/// The flight, known better than a run.
struct FineFlight {
    /// Times of its frames [s].
    times: Vec<f64>,
    bullets: [usize; 4],
    /// Positions of all knots, frame by frame [m].
    knots: KnotFrames,
    /// How well the bullets are known so far, frame by frame [m].
    floor: Vec<f64>,
    /// What it cost [s].
    cost: f64,
}

impl FineFlight {
    /// The flight of `base`, the case of `source`, with the finest step that `seconds` pay for.
    fn of(source: &Source, base: &Case, wanted: f64, seconds: f64) -> Result<FineFlight, Error> {
        let times = flight_times(base, first_contact(source, base)?);
        let end = times[times.len() - 1];
        let solver =
            Solver { integrator: Integrator::Secant, ..base.scene().solver.with_pair("explicit+impulse") };
        // What the cables of one flight cost [s]; three cost as much as this many of the finest.
        let of_cables = |step: f64| budget::shortest_step(base.net(), end, &solver, 1.0) / step;
        let as_finest = 2.0 + 1.0 / COARSER;
        let stable = stable_step(base.net());
        let paid = |seconds: f64| (of_cables(1.0) * as_finest / seconds).max(FINEST * stable);
        let flight = |step: f64| {
            candidate(source, &[], explicit_changes(Integrator::Secant, two_digits(step)), base, end)
        };
        // What it costs beside them does not depend on the step.
        let first = paid(seconds);
        let beside = flight(first).map_or(0.0, |flight| flight.cost - of_cables(first));
        let step = paid((seconds - 3.0 * beside).max(f64::MIN_POSITIVE));
        let unpaid = || {
            let rule = format!(
                "no accuracy: {} of processor time do not pay for a flight of this scene that is known better than a run",
                advice::seconds(seconds)
            );
            refused(wanted, rule)
        };
        if step > FINE * stable {
            return Err(unpaid());
        }
        let of = |step: f64, member: usize| {
            let candidate = flight(step)?;
            let request = EnsembleRequest { members: 2, perturb_m: PERTURB, seed: 1, at_most_s: None };
            let case = if member == 0 { candidate.case } else { moved(&candidate.case, &request, member) };
            Some((at_times(&Run::of(&case, |_| {}).ok()?, &times), candidate.cost))
        };
        let flights = [(step, 0), (step, 1), (COARSER * step, 0)].map(|(step, member)| of(step, member));
        let all: Vec<_> = flights.into_iter().flatten().collect();
        let frames = all.iter().map(|(knots, _)| knots.len()).min().unwrap_or(0);
        if all.len() < 3 || frames < times.len() {
            return Err(unpaid());
        }
        let bullets = base.net().bullets;
        let mut so_far = 0.0_f64;
        let floor = (0..frames).map(|frame| {
            let far = all[1..].iter().map(|(knots, _)| largest(&all[0].0[frame], &knots[frame], &bullets));
            so_far = far.fold(so_far, f64::max);
            so_far
        });
        let floor = floor.collect();
        let cost = all.iter().map(|(_, cost)| cost).sum();
        let knots = all.into_iter().next().map(|(knots, _)| knots).unwrap_or_default();
        Ok(FineFlight { times, bullets, knots, floor, cost })
    }

    /// In how many of its frames it can tell `wanted` metres.
    fn tells(&self, wanted: f64) -> Result<usize, Error> {
        let until = self.floor.partition_point(|floor| *floor <= TELLS * wanted);
        if until as f64 >= ENOUGH * self.times.len() as f64 && until > 1 {
            return Ok(until);
        }
        let enough = (ENOUGH * self.times.len() as f64) as usize;
        let rule = format!(
            "at least {}: from {:.3} s on fine flights differ by more than can be told apart",
            advice::length(self.floor[enough.max(1)] / TELLS),
            self.times[until.min(self.times.len() - 1)]
        );
        Err(refused(wanted, rule))
    }
}

/// When net and target touch first [s]; nothing without contact.
fn first_contact(source: &Source, base: &Case) -> Result<Option<f64>, Failure> {
    if base.target().is_none() {
        return Ok(None);
    }
    let quick = with_explicit_cables(source);
    let mut simulation = Simulation::new(quick.as_ref().unwrap_or(base));
    while simulation.state.time < base.scene().duration_s.0 {
        simulation.step()?;
        if simulation.state.contacts.iter().any(|contact| contact.impulse > 0.0) {
            return Ok(Some(simulation.state.time));
        }
    }
    Ok(None)
}

/// The scene with explicit cables at their own step; nothing where that is refused.
fn with_explicit_cables(source: &Source) -> Option<Case> {
    let mut explicit = source.clone();
    let changes =
        ["solver.cables=explicit", "solver.contact=impulse", "solver.step_s=null", "solver.substeps=1"];
    explicit.set(&changes.map(str::to_owned)).ok()?;
    Case::build_point(&explicit).ok()
}

/// A setting to try.
struct Candidate {
    changes: Vec<String>,
    /// Its flight.
    case: Case,
    /// What that costs [s].
    cost: f64,
    /// What the whole run will cost with it [s].
    run: f64,
}

/// Settings of the flight until `end` [s], from that of the cheapest run on: the scene as written, its own step and halves of it;
/// with cables of the engine the same with an explicit flight, or without a target with explicit cables. Explicit cables by the
/// secant force, which keeps energy best, unless the scene chooses another: trying both spends on the coarser one what a
/// calibration may cost.
fn candidates(source: &Source, own: &[String], base: &Case, end: f64) -> Vec<Candidate> {
    let solver = &base.scene().solver;
    let (time_step, sample) = (base.time_step(), base.scene().output.sample_s.0);
    let halves = |step: f64| (0..=HALVINGS).map(move |n| two_digits(step / 2_f64.powi(n)));
    let chosen = source.json.pointer("/solver/integrator").and_then(Value::as_str);
    // Elements have no such force.
    let is_open = chosen.is_none_or(|chosen| chosen == name(Integrator::Auto)) && solver.spheres().is_none();
    let secant = || is_open.then(|| "solver.integrator=secant".to_owned()).into_iter().collect::<Vec<_>>();
    // The scene as written first.
    let mut settings: Vec<Vec<String>> = vec![Vec::new()];
    if step::method(solver).acts_in_substeps() {
        let step = time_step.step / f64::from(time_step.substeps);
        settings.extend(halves(step).map(|step| {
            [vec!["solver.substeps=1".to_owned(), format!("solver.step_s={step:e}")], secant()].concat()
        }));
    } else {
        for step in halves(time_step.step).map(|step| fitting(step, sample)) {
            let flown =
                |flight: &str| vec![format!("solver.flight={flight}"), format!("solver.step_s={step:e}")];
            settings.push(flown("cables"));
            // Without a target there is no contact at which the engine could take over.
            if base.target().is_some() {
                settings.push([flown("explicit"), secant()].concat());
            }
        }
        if base.target().is_none()
            && let Some(case) = with_explicit_cables(source)
        {
            let step = case.time_step().step / f64::from(case.time_step().substeps);
            settings.extend(halves(step).map(|step| explicit_changes(Integrator::Secant, step)));
        }
    }
    let mut all: Vec<Candidate> =
        settings.into_iter().filter_map(|changes| candidate(source, own, changes, base, end)).collect();
    all.sort_by(|a, b| a.run.total_cmp(&b.run).then(a.cost.total_cmp(&b.cost)));
    // The user's own step makes all settings one.
    all.dedup_by(|b, a| a.case.scene() == b.case.scene());
    all
}

/// The longest step of at most `step` that meets every multiple of `sample` [s], and that a person would write.
fn fitting(step: f64, sample: f64) -> f64 {
    let least = sample / step * (1.0 - 1e-9);
    let decades = (0..12).map(|n| 10_f64.powi(n));
    let round =
        decades.flat_map(|decade| [1.0, 2.0, 2.5, 4.0, 5.0].map(|n| n * decade)).filter(|n| n.fract() == 0.0);
    sample / round.into_iter().find(|n| *n >= least).unwrap_or_else(|| least.ceil())
}

/// The setting `changes` with the user's `own` on top, for a flight until `end` [s] of the run of `base`; nothing where it is
/// refused.
fn candidate(
    source: &Source,
    own: &[String],
    changes: Vec<String>,
    base: &Case,
    end: f64,
) -> Option<Candidate> {
    let mut flown = source.clone();
    flown.set(&changes).ok()?;
    flown.set(own).ok()?;
    flown
        .set(&["expect=null".to_owned(), format!("duration_s={end}"), "capture.hold_s=0".to_owned()])
        .ok()?;
    let sample = source.json.pointer("/output/sample_s").cloned();
    if let Some(sample) = sample {
        flown.set(&[format!("output.sample_s={sample}")]).ok()?;
    }
    let case = Case::build_point(&flown).ok()?;
    let later = budget::forecast_flight(&case);
    let cost = if case.scene().solver.flight == Flight::Explicit {
        // Until the first contact that is all there is, in steps of its own where the engine's are longer.
        flown.set(&["solver.flight=cables".to_owned()]).ok()?;
        let mut flight = with_explicit_cables(&flown)?;
        let step = case.time_step().step;
        if step * f64::from(flight.time_step().substeps) < flight.time_step().step {
            flown.set(&explicit_changes(case.scene().solver.integrator, step)).ok()?;
            flight = Case::build_point(&flown).ok()?;
        }
        budget::forecast_flight(&flight)
    } else {
        later
    };
    let run = cost + later * (base.scene().duration_s.0 / end - 1.0).max(0.0);
    Some(Candidate { changes, case, cost, run })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fitting_steps_meet_every_frame() {
        let found = [5e-4, 4.6e-4, 1.3e-3, 0.02, 1e-6].map(|step| fitting(step, 0.01));
        assert_eq!(found, [5e-4, 4e-4, 1e-3, 0.01, 1e-6]);
    }
}
