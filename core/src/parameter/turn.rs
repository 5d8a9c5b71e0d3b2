//! Directions and attitudes that are all as likely, anywhere or near one that is given.

use std::f64::consts::{PI, TAU};

use nalgebra::{Unit, UnitQuaternion, Vector3};

/// A direction that `units`, numbers from 0 to below 1, stand for.
pub fn direction(units: [f64; 2]) -> Vector3<f64> {
    // Archimedes: heights on a sphere are as likely all.
    cap(2.0 * units[0] - 1.0, units[1])
}

/// A direction at most `within` [rad] from `own`, a vector of any length above 0.
pub fn direction_near(own: &Vector3<f64>, within: f64, units: [f64; 2]) -> Vector3<f64> {
    let lean = cap(1.0 - units[0] * (1.0 - within.cos()), units[1]);
    let along = own.normalize();
    // Any turn that takes X there: the cap is round.
    let turn = UnitQuaternion::rotation_between(&Vector3::x(), &along)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), PI));
    turn * lean
}

/// The point of the unit sphere at the height `x` along X, turned by a share of a turn about it.
fn cap(x: f64, turn: f64) -> Vector3<f64> {
    let (beside, turn) = ((1.0 - x * x).max(0.0).sqrt(), TAU * turn);
    Vector3::new(x, beside * turn.cos(), beside * turn.sin())
}

/// A turn by at most `within` [rad] that `units` stand for: all attitudes within it are as likely, and with π all there
/// are.
///
/// Axes are anywhere on the sphere; angles θ have the density 1 − cos θ, hence (θ − sin θ) / (w − sin w) is uniform.
pub fn turn(within: f64, units: [f64; 3]) -> UnitQuaternion<f64> {
    let share = units[2] * (within - within.sin());
    let (mut low, mut high) = (0.0, within);
    // Halved down to the last bits.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if middle - middle.sin() < share { low = middle } else { high = middle }
    }
    let axis = Unit::new_normalize(direction([units[0], units[1]]));
    UnitQuaternion::from_axis_angle(&axis, 0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points that fill the cube evenly: middles of its cells.
    fn cells(n: u32) -> impl Iterator<Item = [f64; 3]> {
        let middle = move |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        (0..n * n * n).map(move |k| [middle(k % n), middle(k / n % n), middle(k / n / n)])
    }

    /// A cap's mean height is (1 + cos w) / 2, and nothing lies beyond it.
    #[test]
    fn directions_near_one_fill_a_cap_evenly() {
        let within = 0.4_f64;
        for own in [Vector3::new(0.0, -2.0, 1.0), Vector3::new(-3.0, 0.0, 0.0)] {
            let along = own.normalize();
            let all: Vec<Vector3<f64>> =
                cells(20).map(|[a, b, _]| direction_near(&own, within, [a, b])).collect();
            let mean = all.iter().sum::<Vector3<f64>>() / all.len() as f64;
            let expected = 0.5 * (1.0 + within.cos()) * along;
            assert!((mean - expected).norm() < 1e-12, "{mean} {expected}"); // measured: 1e-15
            assert!(all.iter().all(|d| d.angle(&along) <= within && (d.norm() - 1.0).abs() < 1e-12));
        }
    }

    /// Attitudes that are all as likely carry any axis evenly over the sphere: mean 0, mean square 1/3.
    #[test]
    fn any_attitude_is_as_likely() {
        for body in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let all: Vec<Vector3<f64>> = cells(24).map(|units| turn(PI, units) * body).collect();
            let n = all.len() as f64;
            let mean = all.iter().sum::<Vector3<f64>>() / n;
            let squares = all.iter().map(|v| v.component_mul(v)).sum::<Vector3<f64>>() / n;
            // Measured: 3e-4 and 5e-4.
            assert!(mean.norm() < 3e-3, "{body}: {mean}");
            assert!(squares.add_scalar(-1.0 / 3.0).norm() < 5e-3, "{body}: {squares}");
        }
    }

    /// Within a small angle w rotation vectors fill a ball: the mean angle is 3 w / 4.
    #[test]
    fn small_turns_fill_a_ball() {
        let within = 0.01;
        let angles: Vec<f64> = cells(24).map(|units| turn(within, units).angle()).collect();
        let mean = angles.iter().sum::<f64>() / angles.len() as f64;
        assert!((mean / within - 0.75).abs() < 5e-3, "{mean}"); // measured: 2e-4
        assert!(angles.iter().all(|angle| *angle <= within * (1.0 + 1e-6)));
    }
}
