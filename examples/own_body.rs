//! A body written outside of the crate: a drogue on a spring, towed by the chaser or by a bullet of its net.
//!
//! `cargo run --release --example own_body`

use nalgebra::{Matrix3, Vector3};
use tumblenet::case::Case;
use tumblenet::interaction::{ForceElement, Interaction};
use tumblenet::run::Run;
use tumblenet::state::{Body, BodyModel, Forces, Motion, State};

/// What tows the drogue.
#[derive(Clone, Copy, Debug)]
pub enum Tow {
    /// The port of the chaser.
    Chaser,
    /// This knot.
    Knot(usize),
}

/// A spring that pulls and pushes between a drogue and what tows it: F = k (r − l₀) towards each other.
pub struct Spring {
    /// At its other end.
    pub tow: Tow,
    /// Stiffness k [N/m].
    pub stiffness: f64,
    /// Rest length l₀ [m].
    pub rest_length: f64,
}

/// Name of the body.
pub const DROGUE: &str = "drogue";

impl Spring {
    /// From the drogue to the other end [m]; none where that is not there.
    fn across(&self, state: &State) -> Option<Vector3<f64>> {
        let end = match self.tow {
            Tow::Knot(knot) => state.knots.position[knot],
            Tow::Chaser => {
                let chaser = state.find_body("chaser")?;
                state.bodies[chaser].to_local(&state.body_models[chaser].port)
            }
        };
        Some(end - state.bodies[state.find_body(DROGUE)?].position)
    }
}

impl ForceElement for Spring {
    fn add_forces(&mut self, state: &State, forces: &mut Forces) {
        let (Some(drogue), Some(across)) = (state.find_body(DROGUE), self.across(state)) else { return };
        let force = self.stiffness * (across.norm() - self.rest_length) * across.normalize();
        forces.on_bodies[drogue].force += force;
        match (self.tow, state.find_body("chaser")) {
            (Tow::Knot(knot), _) => forces.on_knots[knot] -= force,
            (Tow::Chaser, Some(chaser)) => {
                let arm = state.bodies[chaser].attitude * state.body_models[chaser].port;
                forces.on_bodies[chaser].add_at(&-force, &arm);
            }
            (Tow::Chaser, None) => {}
        }
    }

    fn energy(&self, state: &State) -> f64 {
        let stretch = self.across(state).map_or(0.0, |across| across.norm() - self.rest_length);
        0.5 * self.stiffness * stretch * stretch
    }
}

/// Mass of the drogue [kg].
pub const MASS: f64 = 0.5;

/// The spring with its drogue, which starts at `place` [m], at rest.
pub fn drogue(spring: Spring, place: Vector3<f64>) -> Interaction {
    let ball = Matrix3::from_diagonal_element(0.4 * MASS * 0.05 * 0.05); // of 5 cm
    let model = BodyModel::new(DROGUE, Motion::Free, MASS, ball);
    let start = Body { position: place, ..Body::at_rest() };
    // It acts between bodies, and puts nothing in.
    Interaction::force(DROGUE, "a drogue on a spring", spring).internal().with_body(model, start)
}

/// A built-in scene with a chaser and a drogue, under a pair of `tumblenet compare` such as `joints+rapier`, with `more`
/// changed in the scene.
pub fn case(pair: &str, more: &[&str]) -> Result<Case, Box<dyn std::error::Error>> {
    let (cables, contact) = pair.split_once('+').ok_or("a pair is written cables+contact")?;
    let solver = [format!("solver.cables={cables}"), format!("solver.contact={contact}")];
    let changes = ["expect=null"].iter().chain(more).map(|change| (*change).to_owned());
    Ok(Case::load("cubesat-chaser", &changes.chain(solver).collect::<Vec<_>>())?)
}

#[allow(dead_code)] // a test runs the functions above
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let case = case("joints+rapier", &["duration_s=1.0"])?;
    let spring = Spring { tow: Tow::Chaser, stiffness: 50.0, rest_length: 0.5 };
    let run = Run::with(&case, vec![drogue(spring, Vector3::new(-0.6, 0.1, 0.0))], |_| {})?;
    let track = run.frames.body(DROGUE).ok_or("a drogue that was recorded")?;
    for (time, body) in run.frames.time.iter().zip(&track.frames).step_by(10) {
        println!("{time:.2} s: the drogue is at x = {:+.4} m", body.position.x);
    }
    let momentum = run.frames.momentum.last().copied().unwrap_or_default() - run.frames.momentum[0];
    println!("momentum of net, target, chaser and drogue changed by {:.1e} N s", momentum.norm());
    Ok(())
}
