//! Wall time of a step: a net that opens, one that wraps a Cubesat, one that wraps a rocket stage.
//!
//! A run is brought to its moment once and stepped on from there; it starts anew before it has moved
//! on to another phase.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use tumblenet::case::Case;
use tumblenet::simulation::Simulation;

/// Steps a run takes before it starts anew: half a second.
const STRETCH: u64 = 1000;

fn at(case: &Case, time: f64) -> Simulation {
    let mut simulation = Simulation::new(case);
    while simulation.state.time < time {
        simulation.step().expect("a built-in scene runs");
    }
    simulation
}

fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step");
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    for (name, scene, time) in [
        ("opening, 121 knots", "deployment-kevlar", 0.5),
        ("wrapping a Cubesat, 121 knots", "cubesat-free", 1.0),
        ("on its way to a stage, 441 knots", "stage-free", 4.0),
        ("wrapping a stage, 441 knots", "stage-free", 6.2),
    ] {
        let case = Case::load(scene, &["duration_s=100".to_owned(), "expect=null".to_owned()])
            .expect("a built-in scene is sound");
        let mut simulation = at(&case, time);
        let end = simulation.state.step + STRETCH;
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|iterations| {
                let mut total = Duration::ZERO;
                for _ in 0..iterations {
                    if simulation.state.step == end {
                        simulation = at(&case, time);
                    }
                    let start = Instant::now();
                    black_box(simulation.step()).expect("a built-in scene runs");
                    total += start.elapsed();
                }
                total
            });
        });
    }
    group.finish();
}

criterion_group!(benches, steps);
criterion_main!(benches);
