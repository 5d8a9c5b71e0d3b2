//! What effects cost a step: none compiled into the loop, none named, and each by itself.

#[path = "../tests/common/bare.rs"]
mod bare;

use std::hint::black_box;

use bare::Bare;
use criterion::{Criterion, criterion_group, criterion_main};
use tumblenet::case::Case;
use tumblenet::simulation::Simulation;

/// The Cubesat's net on its way, with `effects` as JSON.
fn case(effects: &str) -> Case {
    let changes = ["duration_s=1000", "expect=null", "target.distance_m=5000"].map(str::to_owned);
    let changes: Vec<String> = changes.into_iter().chain([format!("effects={effects}")]).collect();
    Case::load("cubesat-free", &changes).expect("a sound scene")
}

fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("a step of 121 knots");
    let bare_case = case("{}");
    let mut bare = Bare::new(&bare_case);
    group.bench_function("no hook", |bencher| bencher.iter(|| black_box(&mut bare).step()));
    for (name, effects) in [
        ("no effect", "{}"),
        ("friction", r#"{"friction":{"coefficient":0.3}}"#),
        ("orbit", r#"{"orbit":{"altitude_m":700000}}"#),
        ("orbit, elliptic", r#"{"orbit":{"elements":{"semi_major_axis_m":1e7,"eccentricity":0.3}}}"#),
        ("cabin", r#"{"cabin":{"profile":"parabola"}}"#),
        ("chaser", r#"{"chaser":{"mass_kg":50,"inertia_kg_m2":[2,2,2]}}"#),
    ] {
        let mut simulation = Simulation::new(&case(effects));
        group.bench_function(name, |bencher| {
            bencher.iter(|| black_box(&mut simulation).step().expect("numbers"));
        });
    }
    group.finish();
}

criterion_group!(benches, steps);
criterion_main!(benches);
