use tumblenet::{case::Case, simulation::Simulation};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let mut changes = vec!["expect=null".to_owned()];
    changes.extend(args[2..].iter().cloned());
    let case = Case::load(&args[1], &changes).unwrap_or_else(|p| panic!("{p}"));
    let mut sim = Simulation::new(&case);
    let mut last = sim.books.ledger.own();
    let mut shown = 0;
    let mut deepest = 0.0;
    for _ in 0..case.n_steps() {
        if let Err(e) = sim.step() {
            println!("{e}");
            return;
        }
        let own = sim.books.ledger.own();
        let worst = sim.state.contacts.iter().min_by(|a, b| a.gap.total_cmp(&b.gap)).copied();
        let w = worst.unwrap_or_default();
        let vmax = sim.state.knots.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        if (own - last > 5e-4 || -w.gap > deepest * 1.2 + 2e-4) && shown < 24 {
            shown += 1;
            println!(
                "t {:.4} own {:+.5} d {:+.2e} vmax {:.2} worst gap {:.2e} knot {} along {:?} imp {:.2e} n {:?}",
                sim.state.time,
                own,
                own - last,
                vmax,
                w.gap,
                w.knot,
                w.along.map(|a| (a.cable, a.end, (a.share * 1e3).round() / 1e3)),
                w.impulse,
                w.normal.as_slice().iter().map(|x| (x * 100.0).round() / 100.0).collect::<Vec<_>>()
            );
            if -w.gap > deepest {
                deepest = -w.gap;
            }
        }
        last = own;
    }
}
