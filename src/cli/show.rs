//! `tumblenet show`: the resolved scene, and what a run of it consists of.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::Value;
use tumblenet::case::Case;
use tumblenet::limits;
use tumblenet::problems::Problems;
use tumblenet::report::files;
use tumblenet::report::table::number;
use tumblenet::report::text_table::TextTable;
use tumblenet::simulation::Simulation;

use super::members::MOST_KEPT;
use super::reading::Reading;
use super::run::default_folder;
use super::{Error, json, print};

/// Arguments of `show`.
#[derive(Args)]
pub struct Arguments {
    /// Scene file, or name of a built-in scene.
    scene: String,
    /// Changes a value first, as `run` does.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    changes: Vec<String>,
    /// Folder of the results of a run of this scene, for the share of time of each effect; left out:
    /// results/NAME.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Prints the scene alone, as JSON that can be read again.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    reading: Reading,
}

/// Prints scene, net, target, effects and what the engine gets.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    let case = Case::load_changed(&arguments.scene, &arguments.changes, arguments.reading.limits()?)?;
    if arguments.json {
        return print(&json(case.scene()));
    }
    let mut simulation = Simulation::new(&case);
    let census = simulation.census();
    let mut facts = TextTable::new(&["a run consists of", ""]);
    let mut fact = |name: &str, value: String| {
        facts.add_row(vec![name.to_owned(), value]);
    };
    fact("steps", format!("{} of {} s", case.n_steps(), number(case.time_step().step)));
    fact("knots, cables", format!("{}, {}", case.net().n_knots(), case.net().cables.len()));
    fact("net mass with bullets", format!("{} kg", number(case.net().total_mass())));
    fact("launch energy", format!("{} J", number(case.net().launch_energy())));
    if let Some(target) = case.target() {
        fact("target", format!("{} parts, {} kg", target.parts.len(), number(target.mass)));
        let inertia = target.inertia.symmetric_eigenvalues();
        let mut principal: Vec<f64> = inertia.iter().copied().collect();
        principal.sort_by(f64::total_cmp);
        let principal: Vec<String> = principal.into_iter().map(number).collect();
        fact("target's principal inertias", format!("{} kg m²", principal.join(", ")));
        fact("thinnest part", format!("{} m", number(target.thinnest)));
    } else {
        fact("target", "none: no collider, no detection".to_owned());
    }
    fact("bodies", census.bodies.to_string());
    fact("colliders", census.colliders.to_string());
    fact("cable joints", census.joints.to_string());
    if simulation.effect_names().is_empty() {
        fact("active effects", "none: no body, collider, joint or call of any".to_owned());
        return print(&format!("{}\n{facts}", json(case.scene())));
    }
    let effects = effects(&case, &mut simulation, &folder(arguments, &case))?;
    print(&format!("{}\n{facts}\n{effects}", json(case.scene())))
}

/// A row an effect: what the engine gets for it, what else it installs, its share of a run's time.
fn effects(case: &Case, simulation: &mut Simulation, results: &Path) -> Result<TextTable, Problems> {
    let with = simulation.census();
    let shares = time_shares(results, case);
    let mut rows = TextTable::new(&[
        "active effect",
        "bodies",
        "colliders",
        "joints",
        "installs",
        "share of the run's time",
    ]);
    for (name, installs) in simulation.effect_installs() {
        // Counted, not claimed: what the engine has less without it.
        let less = case.clone().with_scene(|scene| scene.effects = scene.effects.without(name))?;
        let without = Simulation::new(&less).census();
        let share = match &shares {
            Some(shares) => {
                shares[format!("effects.{name}")].as_f64().map(|share| format!("{} %", number(100.0 * share)))
            }
            None => None,
        };
        rows.add_row([
            name.to_owned(),
            format!("{:+}", with.bodies as i64 - without.bodies as i64),
            format!("{:+}", with.colliders as i64 - without.colliders as i64),
            format!("{:+}", with.joints as i64 - without.joints as i64),
            installs,
            share.unwrap_or_else(|| "known after `tumblenet run`".to_owned()),
        ]);
    }
    Ok(rows)
}

/// The folder of the results of `run`.
fn folder(arguments: &Arguments, case: &Case) -> PathBuf {
    arguments.out.clone().unwrap_or_else(|| default_folder(case))
}

/// Shares of the wall time in the summary of a finished run of the same scene, if there is one.
fn time_shares(results: &Path, case: &Case) -> Option<Value> {
    files::recover(results);
    let text = limits::read_file(&results.join("summary.json"), MOST_KEPT).ok()?;
    let summary: Value = serde_json::from_slice(&text).ok()?;
    (summary["scene_hash"] == case.hash()).then(|| summary["time_shares"].clone())
}
