//! Test oracles and helpers, independent of the code they test.

#![allow(dead_code)] // each test binary uses its own part

use nalgebra::Vector3;
use tumblenet::net::Net;

/// The net of `net` as Eq. 3.1 to 3.5 state it, integrated by classical RK4 with a fixed step.
///
/// Written from the equations, sharing no code with the solvers: the tension law, the assembly and
/// the integration are its own. Returns positions of all knots at each of `times` [s].
///
/// Eq. 3.3 jumps by c ṙ where a cable goes taut, so the method is of first order across a switch;
/// at 5 us its bullets agree with those at 2.5 us to 1e-5 m at 0.5 s on the Table 3.2 net.
pub fn rk4_net(net: &Net, step: f64, times: &[f64]) -> Vec<Vec<Vector3<f64>>> {
    let n = net.n_knots();
    let mut x = net.folded.clone();
    let mut v = net.launch_velocity.clone();
    let mut frames = Vec::new();
    let mut k: Vec<[Vec<Vector3<f64>>; 2]> = vec![[vec![Vector3::zeros(); n], vec![Vector3::zeros(); n]]; 4];
    let (mut xs, mut vs) = (x.clone(), v.clone());
    let n_steps = (times.last().copied().unwrap_or(0.0) / step).round() as u64;
    for i in 0..=n_steps {
        if times.iter().any(|t| (t / step).round() as u64 == i) {
            frames.push(x.clone());
        }
        for stage in 0..4 {
            if stage == 0 {
                xs.clone_from(&x);
                vs.clone_from(&v);
            } else {
                let h = if stage == 3 { step } else { 0.5 * step };
                for j in 0..n {
                    xs[j] = x[j] + h * k[stage - 1][0][j];
                    vs[j] = v[j] + h * k[stage - 1][1][j];
                }
            }
            k[stage][0].clone_from(&vs);
            accelerations(net, &xs, &vs, &mut k[stage][1]);
        }
        for j in 0..n {
            let sum = |d: usize| k[0][d][j] + 2.0 * k[1][d][j] + 2.0 * k[2][d][j] + k[3][d][j];
            x[j] += step / 6.0 * sum(0);
            v[j] += step / 6.0 * sum(1);
        }
    }
    frames
}

fn accelerations(net: &Net, x: &[Vector3<f64>], v: &[Vector3<f64>], a: &mut [Vector3<f64>]) {
    a.iter_mut().for_each(|a| *a = Vector3::zeros());
    for c in &net.cables {
        let d = x[c.b] - x[c.a];
        let r = d.norm();
        if r > c.rest_length {
            let n = d / r;
            let f = c.stiffness * (r - c.rest_length) + c.damping * n.dot(&(v[c.b] - v[c.a]));
            if f > 0.0 {
                a[c.a] += n * (f / net.mass[c.a]);
                a[c.b] -= n * (f / net.mass[c.b]);
            }
        }
    }
}
