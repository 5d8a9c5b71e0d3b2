//! Cost of a sub-step of the explicit net, per cable.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use tumblenet::case::Case;
use tumblenet::solver::Integrator;
use tumblenet::step::mass_spring::kernel::ExplicitNet;
use tumblenet::step::mass_spring::stability::{SAFE, stable_step};

fn substep(bench: &mut Criterion) {
    let mut group = bench.benchmark_group("explicit sub-step");
    for meshes in [10, 20, 100] {
        let changes = [
            format!("net.meshes=[{meshes},{meshes}]"),
            "duration_s=0.1".to_owned(),
            "expect=null".to_owned(),
        ];
        let Ok(case) = Case::load("deployment-kevlar", &changes) else { continue };
        let mut net = ExplicitNet::new(case.net(), Integrator::Symplectic, 1e-9);
        let step = SAFE * stable_step(case.net());
        for _ in 0..1000 {
            net.kick(step);
            net.drift(step);
        }
        group.throughput(Throughput::Elements(case.net().cables.len() as u64));
        group.bench_function(format!("{0} x {0} knots, per cable", meshes + 1), |bencher| {
            bencher.iter(|| {
                net.kick(black_box(step));
                net.drift(black_box(step));
            });
        });
    }
    group.finish();
}

criterion_group!(benches, substep);
criterion_main!(benches);
