//! The local frame on an orbit (Fig. 3.7): two-body gravity (Eq. 3.6), less that of the origin.
//!
//! The origin of the local frame falls along a Kepler orbit and the frame turns with it: radial R
//! away from the Earth, transverse V along the flight, normal H = R × V. A circular orbit turns at
//! n = √(μ / a³); on an elliptic one, with r = a (1 − e cos E) and M = E − e sin E,
//! Ω = √(μ a (1 − e²)) / r².
//!
//! To first order in r / R and for e = 0 this is the Clohessy–Wiltshire motion. The source writes the
//! same motion in the inertial frame; there a metre is the seventh digit of a position.

use nalgebra::{Matrix3, Vector3};

use super::{Field, Frame, Gravity, Span};

/// Gravitational parameter of the Earth [m^3/s^2] (WGS 84).
pub const EARTH_PARAMETER: f64 = 3.986_004_418e14;

/// Equatorial radius of the Earth [m] (WGS 84).
pub const EARTH_RADIUS: f64 = 6_378_137.0;

/// A Kepler orbit around the Earth, and how the local frame lies in its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitMotion {
    semi_major_axis: f64,
    eccentricity: f64,
    /// Mean anomaly at time 0 [rad].
    mean_anomaly: f64,
    /// √(μ / a³) [rad/s].
    pub mean_motion: f64,
    /// Local frame from the frame (R, V, H).
    pub local_from_orbital: Matrix3<f64>,
}

impl OrbitMotion {
    /// The orbit of semi-major axis `semi_major_axis` [m] and `eccentricity` below 1, at
    /// `true_anomaly` [rad] when the net is shot, along `approach` in the frame (R, V, H).
    pub fn new(
        semi_major_axis: f64,
        eccentricity: f64,
        true_anomaly: f64,
        approach: &Vector3<f64>,
    ) -> OrbitMotion {
        let (sin, cos) = true_anomaly.sin_cos();
        let eccentric = f64::atan2((1.0 - eccentricity * eccentricity).sqrt() * sin, eccentricity + cos);
        OrbitMotion {
            semi_major_axis,
            eccentricity,
            mean_anomaly: eccentric - eccentricity * eccentric.sin(),
            mean_motion: (EARTH_PARAMETER / semi_major_axis.powi(3)).sqrt(),
            local_from_orbital: axes(approach),
        }
    }

    /// Time of a revolution [s].
    pub fn period(&self) -> f64 {
        std::f64::consts::TAU / self.mean_motion
    }

    /// Distance from the Earth's centre [m] at `time` [s].
    fn distance(&self, time: f64) -> f64 {
        let (a, e) = (self.semi_major_axis, self.eccentricity);
        if e == 0.0 {
            return a;
        }
        let mean = self.mean_anomaly + self.mean_motion * time;
        a * (1.0 - e * eccentric_anomaly(mean, e).cos())
    }

    /// Turn of the frame at that distance [rad/s].
    fn turn(&self, distance: f64) -> Vector3<f64> {
        let (a, e) = (self.semi_major_axis, self.eccentricity);
        let rate = (EARTH_PARAMETER * a * (1.0 - e * e)).sqrt() / (distance * distance);
        self.local_from_orbital * Vector3::new(0.0, 0.0, rate)
    }
}

impl Field for OrbitMotion {
    fn at(&self, time: f64) -> Frame {
        let distance = self.distance(time);
        let radius = self.local_from_orbital * Vector3::new(distance, 0.0, 0.0);
        Frame {
            rate: self.turn(distance),
            centre: Vector3::zeros(),
            gravity: Gravity::Tidal { strength: EARTH_PARAMETER / distance.powi(3), radius },
        }
    }

    fn over(&self, start: f64, end: f64) -> Span {
        let rate_change = match self.eccentricity == 0.0 {
            true => Vector3::zeros(),
            false => self.turn(self.distance(end)) - self.turn(self.distance(start)),
        };
        Span { length: end - start, mean: self.at(0.5 * (start + end)), rate_change }
    }
}

/// E of M = E − e sin E [rad], by Newton's method.
fn eccentric_anomaly(mean: f64, eccentricity: f64) -> f64 {
    let mean = mean.rem_euclid(std::f64::consts::TAU);
    // From here the iterates come down monotonically, for every e below 1 (the left side is convex).
    let mut anomaly = if mean < std::f64::consts::PI { mean + eccentricity } else { mean };
    for _ in 0..50 {
        let (sin, cos) = anomaly.sin_cos();
        let change = (anomaly - eccentricity * sin - mean) / (1.0 - eccentricity * cos);
        anomaly -= change;
        if change.abs() < 1e-15 * (1.0 + anomaly) {
            break;
        }
    }
    anomaly
}

/// Local frame from (R, V, H): X along `approach`; Z as far up (R) as X lets it be, and where X is
/// up or down itself, along −V or V, so that Y is H as it is for a V-bar approach; Y = Z × X.
fn axes(approach: &Vector3<f64>) -> Matrix3<f64> {
    let x = approach.normalize();
    let up = Vector3::x();
    let across = up - x.dot(&up) * x;
    let z = match across.norm() > 1e-9 {
        true => across.normalize(),
        false => -x.x.signum() * Vector3::y(),
    };
    let y = z.cross(&x);
    Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()])
}
