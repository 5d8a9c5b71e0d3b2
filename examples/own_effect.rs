//! An effect written outside of the crate: a thin wind, added to a built-in scene.
//!
//! `cargo run --release --example own_effect`

use nalgebra::Vector3;
use tumblenet::case::Case;
use tumblenet::interaction::{ForceElement, Interaction};
use tumblenet::run::Run;
use tumblenet::state::{Forces, State, TARGET};

/// Linear drag towards a wind: F = c (w − v) on every knot and on the target's centre of mass.
pub struct Wind {
    /// Velocity of the wind w [m/s].
    pub velocity: Vector3<f64>,
    /// Drag coefficient of a knot [N s/m].
    pub on_knot: f64,
    /// Drag coefficient of the target [N s/m].
    pub on_target: f64,
}

impl ForceElement for Wind {
    fn add_forces(&mut self, state: &State, forces: &mut Forces) {
        for (force, velocity) in forces.on_knots.iter_mut().zip(&state.knots.velocity) {
            *force += self.on_knot * (self.velocity - velocity);
        }
        if let Some(target) = state.target() {
            forces.on_bodies[TARGET].force += self.on_target * (self.velocity - target.velocity);
        }
    }
}

/// A built-in scene in the wind, under a pair of `tumblenet compare` such as `joints+rapier`.
pub fn run(pair: &str, wind: Wind) -> Result<(Case, Run), Box<dyn std::error::Error>> {
    let (cables, contact) = pair.split_once('+').ok_or("a pair is written cables+contact")?;
    let changes = ["expect=null", "duration_s=0.3"].map(str::to_owned).into_iter();
    let solver = [format!("solver.cables={cables}"), format!("solver.contact={contact}")];
    let case = Case::load("cubesat-free", &changes.chain(solver).collect::<Vec<_>>())?;
    let effect = Interaction::force("wind", "drag on every knot and on the target", wind);
    let run = Run::with(&case, vec![effect], |_| {})?;
    Ok((case, run))
}

#[allow(dead_code)] // a test runs the function above
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let wind = Wind { velocity: Vector3::new(-0.5, 0.0, 0.0), on_knot: 1e-4, on_target: 0.2 };
    let (_, run) = run("joints+rapier", wind)?;
    if let (Some(target), Some(energy)) = (run.frames.target.last(), run.frames.ledger.last()) {
        println!("the target drifts at {:.4} m/s", target.velocity.x);
        println!("the wind put in {:+.3e} J", energy.effects[0]);
    }
    Ok(())
}
