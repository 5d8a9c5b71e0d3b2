//! The dials of the program: what may be turned, and how far.
//!
//! A *method* dial changes how the same equations are solved, so it has an error. A *model* dial
//! changes the equations (middle knots, effects), so it has no error, only a difference. Each setting
//! turns one dial of one family and is checked like any scene; what the checks refuse stays in the
//! list with their reason.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::case::Case;
use crate::effects::Effects;
use crate::problems::Problems;
use crate::read;
use crate::scene::Source;
use crate::solver::{CableModel, ContactModel, ELEMENT_PAIRS, Integrator, JOINTS_STEP, PAIRS, Precision};
use crate::step::mass_spring::stability::stable_step;

/// Steps of the engine that are tried [s].
const STEPS: [f64; 8] = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5];

/// Steps and sub-steps that are tried: beside one sub-step of the same length.
const SUBSTEPS: [(f64, u32); 5] = [(2e-3, 3), (2e-3, 4), (1e-3, 2), (1e-3, 4), (1e-3, 8)];

/// Fixed numbers of sweeps that are tried.
const SWEEPS: [u32; 5] = [1, 2, 4, 8, 16];

/// Passes over the snaps that are tried.
const SNAP_PASSES: [u32; 4] = [0, 1, 4, 64];

/// What rows may take that is tried, over the launch energy.
const LOSSES: [f64; 3] = [1.0, 0.05, 0.01];

/// Steps of the explicit net, over its stable step.
const SHARES: [f64; 6] = [0.95, 0.6, 0.3, 0.1, 0.03, 0.01];

/// Tolerances of the located flight, over the net's side.
const TOLERANCES: [f64; 4] = [1e-6, 1e-8, 1e-10, 1e-12];

/// What a setting changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DialKind {
    /// How the equations are solved: it has an error.
    Method,
    /// How contact is answered: alike before contact, another distribution after it.
    Contact,
    /// The equations: it has a difference.
    Model,
}

/// One position of one dial.
#[derive(Clone)]
pub struct DialSetting {
    /// What it changes.
    pub kind: DialKind,
    /// The dial, and what else stands fixed: a line of the diagram.
    pub family: &'static str,
    /// Its name, short enough for a diagram.
    pub label: String,
    /// Its position, where the family turns a number: a step [s], a share of the stable step, a count.
    pub value: Option<f64>,
    /// What it changes in the scene, as for [`Source::set`].
    pub changes: Vec<String>,
    /// The checked scene, or why it cannot be run.
    pub case: Result<Case, Problems>,
}

/// The scene as written; the setting that the others are compared with in cost.
pub const AS_WRITTEN: &str = "as written";

/// Families of the diagram, in the order of their colours.
pub const FAMILIES: [&str; 14] = [
    AS_WRITTEN,
    "joints, step",
    "joints, sub-steps",
    "joints, sweeps",
    "joints, snap passes",
    "joints, loss",
    "joints, flight explicit",
    "joints, precision",
    "explicit, symplectic",
    "explicit, secant",
    "explicit, Runge-Kutta",
    "explicit, located",
    "other cables",
    "contact",
];

/// A list of settings that grows.
struct Dials<'a> {
    source: &'a Source,
    list: Vec<DialSetting>,
}

impl Dials<'_> {
    fn add(
        &mut self,
        kind: DialKind,
        family: &'static str,
        label: String,
        value: Option<f64>,
        changes: &[String],
    ) {
        let mut source = self.source.clone();
        let case = source.set(changes).and_then(|()| Case::build(&source));
        self.list.push(DialSetting { kind, family, label, value, changes: changes.to_vec(), case });
    }
}

/// Every position of every dial that the scene `source`, built as `base`, has.
pub fn settings(source: &Source, base: &Case) -> Vec<DialSetting> {
    let mut dials = Dials { source, list: Vec::new() };
    dials.add(DialKind::Method, AS_WRITTEN, AS_WRITTEN.to_owned(), None, &[]);
    joints(&mut dials, base);
    explicit(&mut dials, base);
    located(&mut dials, base);
    others(&mut dials);
    if base.target().is_some() {
        contacts(&mut dials, base);
    }
    models(&mut dials, source, base);
    dials.list
}

/// The engine's cables and contact, nothing else turned.
fn engine(changes: &[String]) -> Vec<String> {
    let plain =
        ["solver.cables=joints", "solver.contact=rapier", "solver.flight=cables", "solver.substeps=1"];
    plain.into_iter().map(str::to_owned).chain(changes.iter().cloned()).collect()
}

fn joints(dials: &mut Dials<'_>, base: &Case) {
    let ms = |step: f64| format!("{} ms", plain(1e3 * step));
    let step = |step: f64| format!("solver.step_s={step}");
    let mut add = |family, label, value: f64, changes: &[String]| {
        dials.add(DialKind::Method, family, label, Some(value), &engine(changes));
    };
    for h in STEPS {
        add("joints, step", format!("joints {}", ms(h)), h, &[step(h)]);
    }
    for (h, substeps) in SUBSTEPS {
        let changes = [step(h), format!("solver.substeps={substeps}")];
        add("joints, sub-steps", format!("joints {} / {substeps}", ms(h)), h / f64::from(substeps), &changes);
    }
    for sweeps in SWEEPS {
        let changes =
            [step(JOINTS_STEP), format!("solver.sweeps={sweeps}"), format!("solver.sweeps_max={sweeps}")];
        add("joints, sweeps", format!("{sweeps} sweeps"), f64::from(sweeps), &changes);
    }
    for passes in SNAP_PASSES {
        let changes = [step(JOINTS_STEP), format!("solver.snap_passes={passes}")];
        add("joints, snap passes", format!("{passes} snap passes"), f64::from(passes), &changes);
    }
    for loss in LOSSES {
        let changes = [step(JOINTS_STEP), format!("solver.loss_tolerance={loss}")];
        add("joints, loss", format!("loss of {loss}"), loss, &changes);
    }
    if base.target().is_some() {
        for h in [1e-3, JOINTS_STEP, 2e-4] {
            let changes = [step(h), "solver.flight=explicit".to_owned()];
            add("joints, flight explicit", format!("flight explicit, joints {}", ms(h)), h, &changes);
        }
    }
    // Whatever widths the engine has beside the default one, where they were built.
    let widths = if cfg!(feature = "f32") { names::<Precision>() } else { Vec::new() };
    for precision in widths.iter().filter(|name| *name != "f64") {
        for h in [1e-3, JOINTS_STEP, 1e-4] {
            let changes = [step(h), format!("solver.precision={precision}")];
            add("joints, precision", format!("{precision} {}", ms(h)), h, &changes);
        }
    }
}

/// The explicit net with the source's contact.
pub fn explicit_changes(integrator: Integrator, step: f64) -> Vec<String> {
    let integrator = name(integrator);
    let fixed = ["solver.cables=explicit", "solver.contact=impulse", "solver.substeps=1"].map(str::to_owned);
    let own = [format!("solver.integrator={integrator}"), format!("solver.step_s={step:e}")];
    fixed.into_iter().chain(own).collect()
}

fn explicit(dials: &mut Dials<'_>, base: &Case) {
    let stable = stable_step(base.net());
    for (integrator, family, name) in [
        (Integrator::Symplectic, "explicit, symplectic", "explicit"),
        (Integrator::Secant, "explicit, secant", "secant"),
        (Integrator::Rk4, "explicit, Runge-Kutta", "RK4"),
    ] {
        for share in SHARES {
            // Two digits: a step that a person would write.
            let step = two_digits(share * stable);
            let label = format!("{name} {} µs", plain(1e6 * step));
            dials.add(DialKind::Method, family, label, Some(share), &explicit_changes(integrator, step));
        }
    }
}

/// Switches located, by tolerance: the step only says how often contact acts.
fn located(dials: &mut Dials<'_>, base: &Case) {
    let step = two_digits(SHARES[0] * stable_step(base.net()));
    for share in TOLERANCES {
        let tolerance = two_digits(share * base.net().designed_area.sqrt());
        let mut changes = explicit_changes(Integrator::Located, step);
        changes.push(format!("solver.tolerance_m={tolerance:e}"));
        let label = format!("located {tolerance:.0e} m");
        dials.add(DialKind::Method, "explicit, located", label, Some(share), &changes);
    }
}

/// Cable models that this file does not know by name; not elements, which are no setting of one accuracy but
/// another model: what they differ by is no error of a step.
fn others(dials: &mut Dials<'_>) {
    let known: Vec<String> = PAIRS.iter().chain(&ELEMENT_PAIRS).map(|(cables, ..)| name(cables)).collect();
    for cables in names::<CableModel>().into_iter().filter(|cables| !known.contains(cables)) {
        let changes = [format!("solver.cables={cables}"), "solver.contact=impulse".to_owned()];
        dials.add(DialKind::Method, "other cables", cables, None, &changes);
    }
}

fn contacts(dials: &mut Dials<'_>, base: &Case) {
    let mut add = |label: &str, changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
        dials.add(DialKind::Contact, "contact", label.to_owned(), None, &changes);
    };
    let mut known = PAIRS.map(|(cables, ..)| name(cables)).to_vec();
    known.dedup();
    for cables in known {
        for contact in [ContactModel::Rapier, ContactModel::Impulse, ContactModel::Penalty].map(name) {
            let [cables, contact] = [format!("solver.cables={cables}"), format!("solver.contact={contact}")];
            let label = format!("{}+{}", &cables[14..], &contact[15..]);
            add(&label, &[&cables, &contact, "solver.step_s=null"]);
        }
    }
    // The interval of detection follows from how far off a knot is watched.
    for (name, factor) in [("a quarter of", 0.25), ("four times", 4.0)] {
        let reach = format!("solver.reach_m={:e}", two_digits(factor * base.demands().contact_margin()));
        let changes = ["solver.cables=explicit", "solver.contact=impulse", "solver.step_s=null", &reach];
        add(&format!("explicit+impulse, {name} the reach"), &changes);
    }
}

fn models(dials: &mut Dials<'_>, source: &Source, base: &Case) {
    for middle in [0, 1, 3].into_iter().filter(|middle| *middle != base.scene().net.middle_knots) {
        let changes = [format!("net.middle_knots={middle}")];
        dials.add(
            DialKind::Model,
            "middle knots",
            format!("{middle} middle knots"),
            Some(f64::from(middle)),
            &changes,
        );
    }
    let named = source.json.get("effects").and_then(Value::as_object);
    let named = named.into_iter().flat_map(|effects| effects.keys());
    for effect in named.filter(|key| Effects::NAMES.contains(&key.as_str())) {
        let changes = [format!("effects.{effect}=null")];
        dials.add(DialKind::Model, "effects", format!("without {effect}"), None, &changes);
    }
}

/// The names that a choice of the scene format allows, from its schema: a new one is found by itself.
fn names<T: JsonSchema>() -> Vec<String> {
    let schema = read::schema::<T>();
    let listed = schema["enum"].as_array().into_iter().flatten();
    let described = schema["oneOf"].as_array().into_iter().flatten().map(|form| &form["const"]);
    listed.chain(described).filter_map(|name| Some(name.as_str()?.to_owned())).collect()
}

/// The name of a choice as a scene writes it.
pub fn name(choice: impl Serialize) -> String {
    // A choice of the format is always a text.
    serde_json::to_value(choice).ok().and_then(|name| Some(name.as_str()?.to_owned())).unwrap_or_default()
}

/// `value` with two significant digits, rounded down: a share of a limit stays below it.
pub fn two_digits(value: f64) -> f64 {
    let unit = 10_f64.powf(value.log10().floor() - 1.0);
    // Through decimal text, so that the number is the one a person would write.
    format!("{:e}", (value / unit).floor() * unit)
        .parse::<f64>()
        .ok()
        .and_then(|value| format!("{value:.1e}").parse().ok())
        .unwrap_or(value)
}

/// A number without zeros that say nothing.
fn plain(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dials(scene: &str) -> Vec<DialSetting> {
        let mut source = Source::find(scene).unwrap();
        source.set(&["expect=null".to_owned()]).unwrap();
        settings(&source, &Case::build(&source).unwrap())
    }

    #[test]
    fn every_dial_of_a_capture_is_there_and_refusals_have_reasons() {
        let list = dials("cubesat-spin-x-2.0-tube");
        for family in FAMILIES.iter().filter(|family| !["other cables", "joints, precision"].contains(family))
        {
            assert!(list.iter().any(|setting| setting.family == *family), "{family}");
        }
        for setting in list.iter().filter(|setting| setting.kind != DialKind::Model) {
            assert!(FAMILIES.contains(&setting.family), "{} has no colour", setting.family);
        }
        assert!(list.iter().any(|setting| setting.label == "without closing"));
        assert!(list.iter().any(|setting| setting.label == "3 middle knots"));
        let refused = list.iter().find(|setting| setting.label == "explicit+rapier").unwrap();
        assert!(!refused.case.as_ref().err().unwrap().list.is_empty());
        let labels: std::collections::BTreeSet<&str> = list.iter().map(|s| s.label.as_str()).collect();
        assert_eq!(labels.len(), list.len(), "each label once");
    }

    #[test]
    fn a_deployment_has_no_contact_dial_and_its_explicit_steps_are_stable() {
        let list = dials("deployment-kevlar");
        assert!(list.iter().all(|setting| setting.kind != DialKind::Contact));
        assert!(list.iter().all(|setting| setting.case.is_ok()));
    }

    #[test]
    fn choices_of_the_format_are_found_by_their_names() {
        assert_eq!(names::<ContactModel>(), ["rapier", "impulse", "penalty"]);
        assert_eq!(name(ContactModel::Impulse), "impulse");
        assert_eq!([1.237e-4, 9.99e-5, 5e-5].map(two_digits), [1.2e-4, 9.9e-5, 5e-5]);
    }
}
