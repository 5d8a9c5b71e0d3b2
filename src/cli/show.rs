//! `tumblenet show`: the resolved scene, and what a run of it consists of.

use clap::Args;
use tumblenet::case::Case;
use tumblenet::report::table::{number, table};
use tumblenet::simulation::Simulation;

use super::reading::Reading;
use super::{Error, json, print};

/// Arguments of `show`.
#[derive(Args)]
pub struct Arguments {
    /// Scene file, or name of a built-in scene.
    scene: String,
    /// Changes a value first, as `run` does.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    changes: Vec<String>,
    #[command(flatten)]
    reading: Reading,
}

/// Prints scene, net, target, effects and what the engine gets.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    let case = Case::load_within(&arguments.scene, &arguments.changes, arguments.reading.limits()?)?;
    let simulation = Simulation::new(&case);
    let census = simulation.census();
    let mut facts = table(&["a run consists of", ""]);
    let mut fact = |name: &str, value: String| {
        facts.add_row(vec![name.to_owned(), value]);
    };
    fact("steps", format!("{} of {} s", case.n_steps(), number(case.pace.step)));
    fact("knots, cables", format!("{}, {}", case.net.n_knots(), case.net.cables.len()));
    fact("net mass with bullets", format!("{} kg", number(case.net.total_mass())));
    fact("launch energy", format!("{} J", number(case.net.launch_energy())));
    if let Some(target) = &case.target {
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
    let effects = simulation.effect_names();
    fact("active effects", if effects.is_empty() { "none".to_owned() } else { effects.join(", ") });
    for (name, installs) in simulation.effect_installs() {
        fact(&format!("  {name} installs"), installs);
    }
    print(&format!("{}\n{facts}", json(&case.scene)))
}
