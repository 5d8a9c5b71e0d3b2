use tumblenet::{
    case::Case,
    metrics::{capture::Curves, summary::Summary},
    run::Run,
};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let mut changes = vec!["expect=null".to_owned()];
    changes.extend(args[2..].iter().cloned());
    let case = Case::load(&args[1], &changes).unwrap_or_else(|p| panic!("{p}"));
    let run = match Run::of(&case, |_| {}) {
        Ok(r) => r,
        Err(e) => {
            println!("FAIL {e}");
            return;
        }
    };
    let curves = Curves::of(&case, &run);
    let s = Summary::of(&case, &run, &curves);
    let c = s.contact.unwrap();
    let k = s.conservation;
    println!(
        "inside {}/{} pen {:.3}mm imp {:.2e} cap {:?} | wall {:.2} det {} contacts {} | mom {:.1e} ang {:.1e} res {:.1e} rise {:.1e} end {:.3e}/{:.3e}",
        c.cables_inside,
        c.max_cables_inside,
        c.max_penetration_m * 1e3,
        c.max_impulse_n_s,
        s.capture.map(|c| (c.captured, c.enclosed)),
        s.wall_s,
        c.detections,
        c.contacts,
        k.momentum_residual,
        k.angular_momentum_residual,
        k.energy_residual,
        k.energy_rise,
        k.energy_end_j,
        k.energy_start_j
    );
    println!(
        "   effects {:?} ledger {:?} shares {:?}",
        run.effects,
        run.frames.ledger.last().map(|l| (l.contact, l.cables, l.effects.clone())),
        s.time_shares
    );
    let n = curves.cables_inside.len();
    println!(
        "   inside: {:?}",
        (0..n).step_by((n / 25).max(1)).map(|i| curves.cables_inside[i]).collect::<Vec<_>>()
    );
}
