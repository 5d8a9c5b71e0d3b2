use tumblenet::case::Case;
use tumblenet::study::cost::oracle::fly;
fn main() {
    let case = Case::load("deployment-kevlar", &["expect=null".into()]).unwrap();
    let times: Vec<f64> = (0..=100).map(|i| 0.01 * i as f64).collect();
    let mut fl = vec![];
    for tol in [1e-13, 1e-12, 1e-11] {
        let t = std::time::Instant::now();
        let f = fly(&case.net, &times, tol, || true);
        println!("{tol:e} {:?} steps {} switches {}", t.elapsed(), f.steps, f.switches);
        fl.push(f);
    }
    let mut net = case.net.clone();
    for (i, p) in net.folded.iter_mut().enumerate() {
        p.x += 1e-9 * ((i as f64) * 12.9898).sin();
        p.y += 1e-9 * ((i as f64) * 78.233).sin();
        p.z += 1e-9 * ((i as f64) * 3.77).sin();
    }
    fl.push(fly(&net, &times, 1e-12, || true));
    let mut runs = vec![];
    for (integ, step) in [("symplectic", "1e-6"), ("symplectic", "2e-6"), ("rk4", "2e-6")] {
        let t = std::time::Instant::now();
        let c = Case::load(
            "deployment-kevlar",
            &[
                "expect=null".into(),
                "solver.cables=explicit".into(),
                "solver.contact=impulse".into(),
                format!("solver.integrator={integ}"),
                format!("solver.step_s={step}"),
                "duration_s=1".into(),
            ],
        )
        .unwrap();
        let r = tumblenet::run::Run::of(&c, |_| {}).unwrap();
        println!("{integ} {step} {:?}", t.elapsed());
        runs.push(r);
    }
    let d = |a: &Vec<nalgebra::Vector3<f64>>, b: &Vec<nalgebra::Vector3<f64>>| {
        case.net.bullets.iter().map(|&k| (a[k] - b[k]).norm()).fold(0.0, f64::max)
    };
    let da = |a: &Vec<nalgebra::Vector3<f64>>, b: &Vec<nalgebra::Vector3<f64>>| {
        a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    };
    for i in (10..=100).step_by(10) {
        println!(
            "{:.2} tol12 {:.1e} tol11 {:.1e} pert {:.1e} all {:.1e} | symp1us {:.1e} symp2 {:.1e} rk4_2us {:.1e}",
            times[i],
            d(&fl[0].knots[i], &fl[1].knots[i]),
            d(&fl[0].knots[i], &fl[2].knots[i]),
            d(&fl[1].knots[i], &fl[3].knots[i]),
            da(&fl[1].knots[i], &fl[3].knots[i]),
            d(&fl[0].knots[i], &runs[0].frames.knots[i]),
            d(&fl[0].knots[i], &runs[1].frames.knots[i]),
            d(&fl[0].knots[i], &runs[2].frames.knots[i])
        );
    }
}
