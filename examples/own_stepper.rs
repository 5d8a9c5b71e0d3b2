//! A method written outside of the crate: the net as point masses on springs, nothing vectorised.
//!
//! `cargo run --release --example own_stepper`

use nalgebra::Vector3;
use tumblenet::case::Case;
use tumblenet::failure::{self, Failure};
use tumblenet::interaction::Interactions;
use tumblenet::net::Net;
use tumblenet::options::TimeStep;
use tumblenet::simulation::Simulation;
use tumblenet::state::State;
use tumblenet::step::stepper::{StepReport, Stepper};
use tumblenet::work::Work;
use tumblenet::world::Census;

/// Semi-implicit Euler on Eq. 3.5, for a net that meets nothing.
pub struct PointMasses {
    net: Net,
    time_step: TimeStep,
}

impl PointMasses {
    fn substep(&self, state: &mut State, forces: &mut [Vector3<f64>], step: f64) {
        forces.fill(Vector3::zeros());
        let knots = &mut state.knots;
        for (cable, largest) in self.net.cables.iter().zip(&mut state.tension) {
            let across = knots.position[cable.b] - knots.position[cable.a];
            let length = across.norm();
            let rate = across.dot(&(knots.velocity[cable.b] - knots.velocity[cable.a])) / length;
            let tension = cable.tension(length, rate);
            *largest = largest.max(tension);
            forces[cable.a] += tension / length * across;
            forces[cable.b] -= tension / length * across;
        }
        for (knot, force) in forces.iter().enumerate() {
            let held = state.forces.on_knots.get(knot).copied().unwrap_or_default();
            knots.velocity[knot] += step / self.net.mass[knot] * (force + held);
        }
    }
}

impl Stepper for PointMasses {
    fn step(
        &mut self,
        _before: &State,
        state: &mut State,
        with: &mut Interactions,
        work: &mut Work,
    ) -> Result<StepReport, Failure> {
        let step = self.time_step.step / f64::from(self.time_step.substeps);
        let mut forces = vec![Vector3::zeros(); self.net.n_knots()];
        let mut touched = vec![false; self.net.n_knots()];
        state.tension.fill(0.0);
        for _ in 0..self.time_step.substeps {
            self.substep(state, &mut forces, step);
            // Threads and the like hold the knots of every sub-step.
            with.solve_constraints(&mut state.knots, step, &mut touched);
            for (position, velocity) in state.knots.position.iter_mut().zip(&state.knots.velocity) {
                *position += step * velocity;
            }
        }
        work.substeps += u64::from(self.time_step.substeps);
        failure::check(state, "point masses")?;
        Ok(StepReport::default())
    }

    fn census(&self) -> Census {
        Census::default()
    }
}

/// A net that opens, with explicit cables of the crate and with those above; how far apart its knots end [m].
pub fn apart(duration_s: f64) -> Result<f64, Box<dyn std::error::Error>> {
    let changes = ["expect=null", "solver.cables=explicit", "solver.contact=impulse"].map(str::to_owned);
    let duration = format!("duration_s={duration_s}");
    let case = Case::load("deployment-kevlar", &changes.into_iter().chain([duration]).collect::<Vec<_>>())?;
    let own = PointMasses { net: case.net().clone(), time_step: case.time_step() };
    let mut pair = [Simulation::new(&case), Simulation::stepped_by(&case, Box::new(own), Vec::new())];
    for _ in 0..case.n_steps() {
        for simulation in &mut pair {
            simulation.step()?;
        }
    }
    let [theirs, own] = pair.map(|simulation| simulation.state.knots.position);
    Ok(theirs.iter().zip(&own).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max))
}

#[allow(dead_code)] // a test runs the function above
fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("largest distance between the two methods after 0.2 s: {:.1e} m", apart(0.2)?);
    Ok(())
}
