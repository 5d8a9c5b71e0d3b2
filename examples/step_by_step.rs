//! A loop of one's own: it reads the state after every step and commands the winches while it runs.
//!
//! `cargo run --release --example step_by_step`

use tumblenet::case::Case;
use tumblenet::simulation::Simulation;
use tumblenet::state::WinchCommand;

/// What the loop saw.
#[derive(Debug)]
pub struct Seen {
    /// When the winches were told to start [s].
    pub started: Option<f64>,
    /// Thread off the reels of the first thread: at the start, and at the end [m].
    pub off_reels: [f64; 2],
    /// Largest tension of the first thread between two looks [N].
    pub tension: f64,
}

/// Closes the net when its bullets are past the target, gently at first.
pub fn run(seconds: f64) -> Result<Seen, Box<dyn std::error::Error>> {
    let changes = ["expect=null", r#"effects.closing.trigger={"on":"time","at_s":1e9}"#].map(str::to_owned);
    let case = Case::load("cubesat-spin-x-2.0-tube", &changes)?;
    let mut simulation = Simulation::new(&case);
    let column = |simulation: &mut Simulation, name: &str| -> Option<f64> {
        let at = simulation.columns().iter().position(|known| known == name)?;
        simulation.values().get(at).copied()
    };
    let first = column(&mut simulation, "thread_1_off_reels_m").ok_or("a scene with a thread")?;
    let mut seen = Seen { started: None, off_reels: [first, first], tension: 0.0 };
    while simulation.state.time < seconds {
        simulation.step()?;
        let state = &mut simulation.state;
        let target = state.target().map_or(0.0, |target| target.position.x);
        let past = case.net().bullets.iter().all(|&bullet| state.knots.position[bullet].x > target);
        if past && seen.started.is_none() {
            seen.started = Some(state.time);
        }
        // A tenth of a newton at first, half of one once the threads have run for a while.
        state.winch = seen.started.map(|start| WinchCommand {
            start: true,
            reel_speed: 0.5,
            max_tension: if state.time < start + 0.1 { 0.1 } else { 0.5 },
        });
        if let Some(tension) = column(&mut simulation, "thread_1_tension_n") {
            seen.tension = seen.tension.max(tension);
        }
    }
    seen.off_reels[1] = column(&mut simulation, "thread_1_off_reels_m").unwrap_or(first);
    Ok(seen)
}

#[allow(dead_code)] // a test runs the function above
fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{:?}", run(1.5)?);
    Ok(())
}
