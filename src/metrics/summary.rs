//! The summary of a run: `summary.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::capture::Curves;
use super::conservation::Conservation;
use super::deployment::Deployment;
use super::retention::Retention;
use super::verdict::Capture;
use super::warnings;
use crate::case::Case;
use crate::effects::Effects;
use crate::effects::blocks::Blocks;
use crate::provenance::Provenance;
use crate::read;
use crate::run::Run;
use crate::scene::schema::Expect;
use crate::solver::Solver;
use crate::target::spec::Motion;

/// Everything a run has to say in numbers; a block that does not apply is absent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Summary {
    /// The scene's title.
    pub title: String,
    /// Hash of scene and target.
    pub scene_hash: String,
    /// Hash of the last state, to the last bit: equal for equal runs.
    pub state_hash: String,
    /// Version of the program.
    pub version: String,
    /// The method.
    pub solver: Solver,
    /// The active effects.
    pub effects: Vec<String>,
    /// Wall time of the simulation [s].
    pub wall_s: f64,
    /// Simulated time [s].
    pub simulated_s: f64,
    /// When not to believe the numbers; see `metrics::warnings`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// How the net opened.
    pub deployment: Deployment,
    /// How net and target touched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact: Option<ContactSummary>,
    /// The verdict.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capture: Option<Capture>,
    /// What became of the target.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<TargetSummary>,
    /// What effects had to say, a block each under the effect's name.
    #[serde(flatten)]
    pub effect_blocks: Blocks,
    /// Whether the capture held when put to the test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub retention: Option<Retention>,
    /// What the cables bore.
    pub cables: CableSummary,
    /// What was kept.
    pub conservation: Conservation,
    /// Time until which the run agrees with a finer or perturbed one [s]; null where not studied.
    pub trust_horizon_s: Option<f64>,
    /// Work done, in counts: exact, whatever the machine.
    pub work: WorkSummary,
    /// Share of the wall time by stage and effect [-].
    pub time_shares: std::collections::BTreeMap<String, f64>,
    /// What made these numbers.
    pub provenance: Provenance,
}

/// How net and target touched.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContactSummary {
    /// End of the step with the first impulse [s]; null without any.
    pub first_contact_s: Option<f64>,
    /// Largest impulse of one contact within a millisecond, or a step where that is longer: a hit that falls into
    /// two steps is one [N s].
    pub max_impulse_n_s: f64,
    /// Largest force [N]: with `penalty` the force itself, with impulses that impulse over the same time.
    pub max_force_n: f64,
    /// Deepest overlap [m].
    pub max_penetration_m: f64,
    /// Steps in which contacts were looked for.
    pub detections: u64,
    /// Contacts, summed over the steps.
    pub contacts: u64,
    /// Cables whose middle line goes through the target, at the end.
    pub cables_inside: usize,
    /// The most of them in any frame.
    pub max_cables_inside: usize,
}

/// What became of the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TargetSummary {
    /// Displacement of the centre of mass [m].
    pub displacement_m: [f64; 3],
    /// Angular velocity at the end, body frame [rad/s].
    pub spin_rad_s: [f64; 3],
    /// Largest change of the angular velocity by contact and fields: the change of the angular momentum over the
    /// inertia, so that a tumble that nothing touches has none [rad/s]; null for a held target.
    pub max_rate_change_rad_s: Option<f64>,
}

/// What the cables bore.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CableSummary {
    /// Largest tension [N].
    pub max_tension_n: f64,
    /// Largest strain, tension over E A [-].
    pub max_strain: f64,
    /// Least breaking tension over tension [-]; null when no cable was ever taut.
    pub safety_factor: Option<f64>,
}

/// Work done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct WorkSummary {
    /// Rigid bodies.
    pub bodies: usize,
    /// Colliders.
    pub colliders: usize,
    /// Cable joints.
    pub joints: usize,
    /// Steps.
    pub steps: u64,
    /// Sub-steps: of the engine, or of the explicit net.
    pub substeps: u64,
    /// Cable rows, summed over the steps.
    pub cable_rows: u64,
    /// Cables that snapped taut within a step.
    pub snaps: u64,
    /// SolverIterations over all rows, summed over the sub-steps.
    pub sweeps: u64,
}

impl Summary {
    /// The summary of `run`, with the capture curves worked out before.
    pub fn of(case: &Case, run: &Run, curves: &Curves) -> Summary {
        let has_target = case.target().is_some();
        let step = case.time_step().step;
        let extremes = &run.extremes;
        Summary {
            title: case.scene().title.clone(),
            scene_hash: case.hash().to_owned(),
            state_hash: run.state_hash.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            solver: case.scene().solver,
            effects: run.effects.iter().map(|(name, _)| (*name).to_owned()).collect(),
            wall_s: run.wall.as_secs_f64(),
            simulated_s: run.work.steps as f64 * step,
            warnings: warnings::after(case, run, curves),
            deployment: Deployment::of(case, run),
            contact: has_target.then_some(ContactSummary {
                first_contact_s: extremes.first_contact,
                max_impulse_n_s: extremes.impulse,
                max_force_n: extremes.force,
                max_penetration_m: extremes.penetration,
                detections: run.work.detections,
                contacts: run.work.contacts,
                cables_inside: curves.cables_inside.last().copied().unwrap_or(0),
                max_cables_inside: curves.cables_inside.iter().copied().max().unwrap_or(0),
            }),
            capture: Capture::of(case, extremes.first_contact.is_some(), &run.frames.time, curves),
            target: target_summary(case, run),
            effect_blocks: effect_blocks(case, run, curves),
            retention: Retention::of(case, run, curves),
            cables: CableSummary {
                max_tension_n: extremes.tension,
                max_strain: extremes.strain,
                safety_factor: (extremes.utilisation > 0.0).then(|| 1.0 / extremes.utilisation),
            },
            conservation: Conservation::of(case, run),
            trust_horizon_s: None,
            work: WorkSummary {
                bodies: run.census.bodies,
                colliders: run.census.colliders,
                joints: run.census.joints,
                steps: run.work.steps,
                substeps: run.work.substeps,
                cable_rows: run.work.cable_rows,
                snaps: run.work.snaps,
                sweeps: run.work.sweeps,
            },
            time_shares: time_shares(run),
            provenance: Provenance::here(),
        }
    }

    /// Every number of the summary as `block.name`, in the order of the schema.
    pub fn scalars(&self) -> Vec<(String, f64)> {
        let mut scalars = Vec::new();
        // A summary is plain data: it always becomes JSON.
        collect_scalars("", &serde_json::to_value(self).unwrap_or_default(), &mut scalars);
        scalars
    }

    /// The same, when every number in it is one; JSON has no words for others, and would write null.
    ///
    /// # Errors
    /// Names of the numbers that are none.
    pub fn sound(self) -> Result<Summary, String> {
        let value = serde_json::to_value(&self).unwrap_or_default();
        // What is null where a number must be is not read back; what is null where nothing may be is not equal.
        if serde_json::from_value::<Summary>(value.clone()).is_ok_and(|back| back == self) {
            return Ok(self);
        }
        let schema = read::schema::<Summary>();
        let mut gaps = Vec::new();
        collect_gaps("", &schema, &schema, &value, &mut gaps);
        Err(format!("not a finite number in the summary: {}", gaps.join(", ")))
    }

    /// What of `expect` does not hold, in words.
    pub fn missed(&self, expect: &Expect) -> Vec<String> {
        let mut missed = Vec::new();
        let captured = self.capture.map(|capture| capture.captured);
        if let (Some(expected), Some(found)) = (expect.captured, captured)
            && expected != found
        {
            missed.push(format!("capture.captured: expected {expected}, found {found}"));
        }
        let verdict = self.capture.map(|capture| capture.verdict);
        if let (Some(expected), Some(found)) = (expect.verdict, verdict)
            && expected != found
        {
            let (expected, found) = (expected.name(), found.name());
            missed.push(format!("capture.verdict: expected {expected}, found {found}"));
        }
        let scalars = self.scalars();
        for (name, [low, high]) in &expect.within {
            match scalars.iter().find(|(known, _)| known == name) {
                Some((_, value)) if (*low..=*high).contains(value) => {}
                Some((_, value)) => missed.push(format!("{name}: expected {low} to {high}, found {value}")),
                None => missed.push(format!("{name}: expected {low} to {high}, found nothing")),
            }
        }
        missed
    }

    /// Whether the number `name` is the machine's or the program's, and so no outcome of the scene.
    pub fn is_of_machine(name: &str) -> bool {
        ["wall_s", "trust_horizon_s", "time_shares.", "provenance."]
            .iter()
            .any(|block| name.starts_with(block))
    }

    /// Whether `name` is a key of every summary's own.
    fn has_key(name: &str) -> bool {
        read::schema::<Summary>()["properties"].get(name).is_some()
    }

    /// Names of all numbers that a summary may hold, but for those of effects from outside.
    pub fn scalar_names() -> Vec<String> {
        let schema = read::schema::<Summary>();
        let mut names = Vec::new();
        collect_names("", &schema, &schema, &mut names);
        names
    }
}

fn target_summary(case: &Case, run: &Run) -> Option<TargetSummary> {
    let target = case.target()?;
    let (first, last) = (run.frames.target.first()?, run.frames.target.last()?);
    // By the change of angular momentum: a body that tumbles freely changes its rate, and nothing turned it.
    let start = first.angular_momentum(&target.inertia);
    let inverse = target.inertia.try_inverse().unwrap_or_default();
    let change = |body: &crate::state::Body| {
        let moment = body.angular_momentum(&target.inertia) - start;
        (inverse * body.attitude.inverse_transform_vector(&moment)).norm()
    };
    Some(TargetSummary {
        displacement_m: (last.position - first.position).into(),
        spin_rad_s: last.spin().into(),
        max_rate_change_rad_s: (target.motion == Motion::Free)
            .then(|| run.frames.target.iter().map(change).fold(0.0, f64::max)),
    })
}

/// What each effect had to say; that of one which began to act says how long the mouth then took to close, where it has a
/// place for it.
fn effect_blocks(case: &Case, run: &Run, curves: &Curves) -> Blocks {
    let mut blocks = Blocks::default();
    for (name, report) in &run.reports {
        let Some(Value::Object(mut block)) = report.numbers.clone() else { continue };
        if report.start.is_some()
            && let Some(place) = block.get_mut("time_to_close_s")
        {
            *place = time_to_close(case, run, curves).into();
        }
        // One from outside may be called as another part of the summary is.
        let is_taken = !Effects::NAMES.contains(name) && Summary::has_key(name);
        let key = if is_taken { format!("effects.{name}") } else { (*name).to_owned() };
        blocks.0.insert(key, Value::Object(block));
    }
    blocks
}

/// From the start of what closes the mouth until that was first below `capture.mouth_max` [s].
fn time_to_close(case: &Case, run: &Run, curves: &Curves) -> Option<f64> {
    let start = run.reports.iter().find_map(|(_, report)| report.start?.1)?;
    let mut mouths = run.frames.time.iter().zip(&curves.mouth);
    let closed = mouths.find(|&(&t, &mouth)| t >= start && mouth <= case.scene().capture.mouth_max);
    closed.map(|(t, _)| t - start)
}

fn time_shares(run: &Run) -> std::collections::BTreeMap<String, f64> {
    let stages = &run.work.stages;
    let total = run.wall.as_secs_f64().max(f64::MIN_POSITIVE);
    let mut shares: std::collections::BTreeMap<String, f64> = [
        ("cables", stages.cables),
        ("world", stages.world),
        ("contact", stages.contact),
        ("observe", stages.observe),
    ]
    .into_iter()
    .map(|(name, time)| (name.to_owned(), time.as_secs_f64() / total))
    .collect();
    for ((name, _), time) in run.effects.iter().zip(&run.work.effects) {
        shares.insert(format!("effects.{name}"), time.as_secs_f64() / total);
    }
    shares
}

fn collect_scalars(path: &str, value: &Value, scalars: &mut Vec<(String, f64)>) {
    match value {
        Value::Number(number) => scalars.extend(number.as_f64().map(|number| (path.to_owned(), number))),
        Value::Object(map) => {
            for (key, value) in map {
                collect_scalars(&read::join(path, key), value, scalars);
            }
        }
        Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                collect_scalars(&format!("{path}.{index}"), value, scalars);
            }
        }
        _ => {}
    }
}

/// Walks the schema as `collect_scalars` walks the value.
fn collect_names(path: &str, schema: &Value, root: &Value, names: &mut Vec<String>) {
    if let Some(reference) = schema["$ref"].as_str() {
        if let Some(target) = root.pointer(reference.trim_start_matches('#')) {
            collect_names(path, target, root, names);
        }
        return;
    }
    for form in schema["anyOf"].as_array().into_iter().flatten() {
        collect_names(path, form, root, names);
    }
    for (key, below) in schema["properties"].as_object().into_iter().flatten() {
        collect_names(&read::join(path, key), below, root, names);
    }
    let is = |name: &str| {
        schema["type"] == name || schema["type"].as_array().is_some_and(|t| t.contains(&name.into()))
    };
    if is("number") || is("integer") {
        names.push(path.to_owned());
    } else if is("array") {
        for index in 0..schema["maxItems"].as_u64().unwrap_or(0) {
            collect_names(&format!("{path}.{index}"), &schema["items"], root, names);
        }
    }
}

/// Places where the schema asks for a number and the value has none.
fn collect_gaps(path: &str, schema: &Value, root: &Value, value: &Value, gaps: &mut Vec<String>) {
    if let Some(target) = schema["$ref"].as_str().and_then(|name| root.pointer(name.trim_start_matches('#')))
    {
        return collect_gaps(path, target, root, value, gaps);
    }
    match value {
        Value::Null if schema["type"] == "number" => gaps.push(path.to_owned()),
        Value::Object(map) => {
            for (key, inner) in map {
                collect_gaps(&read::join(path, key), &schema["properties"][key], root, inner, gaps);
            }
            for form in schema["anyOf"].as_array().into_iter().flatten().filter(|form| form["type"] != "null")
            {
                collect_gaps(path, form, root, value, gaps);
            }
        }
        Value::Array(list) => {
            for (index, inner) in list.iter().enumerate() {
                collect_gaps(&format!("{path}.{index}"), &schema["items"], root, inner, gaps);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::checks::SUMMARY_NAMES;

    /// `RENEW=1 cargo test --lib names_that_a_scene_may_expect` writes them anew.
    #[test]
    fn names_that_a_scene_may_expect_are_those_of_the_summary() {
        let names = Summary::scalar_names().join("\n") + "\n";
        if std::env::var_os("RENEW").is_some() {
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/core/src/scene/summary_names.txt");
            std::fs::write(path, &names).unwrap();
        } else {
            assert_eq!(names, SUMMARY_NAMES);
        }
    }

    #[test]
    fn a_summary_with_a_number_that_is_none_is_not_sound() {
        let case = Case::load("deployment-kevlar", &["duration_s=0.01".to_owned(), "expect=null".to_owned()]);
        let case = case.unwrap_or_else(|problems| panic!("{problems}"));
        let run = Run::of(&case, |_| {}).unwrap();
        let summary = Summary::of(&case, &run, &Curves::of(&case, &run));
        assert!(summary.clone().sound().is_ok());
        let mut broken = summary.clone();
        broken.cables.max_strain = f64::INFINITY;
        broken.deployment.max_area_m2 = f64::NAN;
        let told = broken.sound().unwrap_err();
        assert!(told.contains("deployment.max_area_m2") && told.contains("cables.max_strain"), "{told}");
        let mut broken = summary;
        broken.trust_horizon_s = Some(f64::NAN);
        assert!(broken.sound().is_err());
    }

    #[test]
    fn names_of_the_contract_are_known() {
        let names = Summary::scalar_names();
        for name in
            ["deployment.max_area_m2", "contact.first_contact_s", "target.displacement_m.0", "capture.cqi"]
        {
            assert!(names.iter().any(|known| known == name), "{name} not in {names:?}");
        }
    }
}
