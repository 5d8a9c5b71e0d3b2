//! The four deployment parameters of Section 3.2.3, of the first opening.
//!
//! The area is that of the four bullets, projected on the plane normal to the travelling direction.
//! A net re-opens on the far side of its axis, so the first opening ends once the area has fallen
//! to half its running maximum.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::run::Run;

/// Share of the designed area above which the net can capture (Section 3.2.3).
const EFFECTIVE: f64 = 0.8;

/// Fall from the running maximum that ends the first opening.
const OPENING_ENDS: f64 = 0.5;

/// The deployment parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Deployment {
    /// Largest area [m^2].
    pub max_area_m2: f64,
    /// When it was reached [s].
    pub deployment_time_s: f64,
    /// How far the centre of mass of net and bullets had come by then [m].
    pub travelling_distance_m: f64,
    /// How long the area was above 80 % of the designed area [s].
    pub effective_period_s: f64,
    /// Largest deviation of the net's middle knot along Y and Z, up to the first contact or the end of
    /// the first opening (Fig. 3.23) [m].
    pub middle_deviation_m: [f64; 2],
}

impl Deployment {
    /// The deployment parameters of `run`.
    pub fn of(case: &Case, run: &Run) -> Deployment {
        let opening = first_opening(&run.mouth_area);
        let peak = (0..opening.len()).fold(0, |best, i| if opening[i] > opening[best] { i } else { best });
        let deployment_time = peak as f64 * run.step;
        let centre_of_mass = |knots: &[Vector3<f64>]| {
            let weighted: Vector3<f64> = case.net().mass.iter().zip(knots).map(|(mass, x)| *mass * x).sum();
            weighted / case.net().total_mass()
        };
        let centres: Vec<Vector3<f64>> = run.frames.knots.iter().map(|knots| centre_of_mass(knots)).collect();
        let travelled = interpolate(&run.frames.time, &centres, deployment_time) - centres[0];
        Deployment {
            max_area_m2: opening[peak],
            deployment_time_s: deployment_time,
            travelling_distance_m: travelled.norm(),
            effective_period_s: time_above(opening, EFFECTIVE * case.net().designed_area) * run.step,
            middle_deviation_m: middle_deviation(case, run, opening.len() as f64 * run.step),
        }
    }
}

fn middle_deviation(case: &Case, run: &Run, opening: f64) -> [f64; 2] {
    let middle = case.net().middle_knot();
    let end = run.extremes.first_contact.unwrap_or(opening);
    let frames = run.frames.time.iter().zip(&run.frames.knots).take_while(|(time, _)| **time <= end);
    let moved = frames.map(|(_, knots)| (knots[middle] - run.frames.knots[0][middle]).abs());
    let largest = moved.fold(Vector3::zeros(), |largest: Vector3<f64>, now| largest.sup(&now));
    [largest.y, largest.z]
}

/// The areas up to the end of the first opening.
fn first_opening(areas: &[f64]) -> &[f64] {
    let mut largest = 0.0_f64;
    for (i, &area) in areas.iter().enumerate() {
        largest = largest.max(area);
        if area < OPENING_ENDS * largest {
            return &areas[..i];
        }
    }
    areas
}

/// How long, in steps, a curve of straight pieces is above `level`.
fn time_above(values: &[f64], level: f64) -> f64 {
    values
        .windows(2)
        .map(|pair| match (pair[0] > level, pair[1] > level) {
            (true, true) => 1.0,
            (false, false) => 0.0,
            (true, false) => (pair[0] - level) / (pair[0] - pair[1]),
            (false, true) => (pair[1] - level) / (pair[1] - pair[0]),
        })
        .sum()
}

/// Value at `time` of a curve of straight pieces.
fn interpolate(times: &[f64], values: &[Vector3<f64>], time: f64) -> Vector3<f64> {
    let after = times.partition_point(|&t| t < time).clamp(1, times.len() - 1);
    let share = (time - times[after - 1]) / (times[after] - times[after - 1]);
    values[after - 1].lerp(&values[after], share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_opening_does_not_count() {
        let areas = [0.0, 4.0, 10.0, 8.0, 6.0, 4.9, 20.0];
        assert_eq!(first_opening(&areas), &areas[..5]);
    }

    #[test]
    fn time_above_a_level_counts_parts_of_steps() {
        // Up through 8 after 0.75 of the second step, down through it at half of the fourth.
        let above = time_above(&[0.0, 2.0, 10.0, 10.0, 6.0, 0.0], 8.0);
        assert!((above - (0.25 + 1.0 + 0.5)).abs() < 1e-12, "{above}");
    }
}
