//! Which settings are worth their time: none is cheaper and as accurate, none more accurate and as cheap.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Places of the points (cost, error) that none of the others beats, from the cheapest to the most accurate.
///
/// Errors at the floor are all alike: of those the cheapest stays.
pub fn front(points: &[(f64, f64)], floor: f64) -> Vec<usize> {
    let error = |place: &usize| points[*place].1.max(floor);
    let mut order: Vec<usize> =
        (0..points.len()).filter(|i| points[*i].0.is_finite() && points[*i].1.is_finite()).collect();
    order.sort_by(|a, b| points[*a].0.total_cmp(&points[*b].0).then(error(a).total_cmp(&error(b))));
    let mut best = f64::INFINITY;
    order.retain(|place| {
        let better = error(place) < best;
        best = best.min(error(place));
        better
    });
    order
}

/// An observed order of convergence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Order {
    /// The family whose step was varied.
    pub family: String,
    /// Slope of log error over log step, by least squares [-].
    pub order: f64,
    /// Steps that it rests on.
    pub steps: usize,
}

/// The order at which errors fall with the step, from points (step, error) that are at least three
/// times above the floor; nothing with fewer than three.
pub fn order(family: &str, points: &[(f64, f64)], floor: f64) -> Option<Order> {
    let logs: Vec<(f64, f64)> = points
        .iter()
        .filter(|(_, error)| error.is_finite() && *error > 3.0 * floor)
        .map(|(step, error)| (step.ln(), error.ln()))
        .collect();
    let n = logs.len() as f64;
    if logs.len() < 3 {
        return None;
    }
    let (mean_x, mean_y) =
        (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let across: f64 = logs.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let along: f64 = logs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    (along > 0.0).then(|| Order { family: family.to_owned(), order: across / along, steps: logs.len() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        // 2 is beaten by 1, 4 is as good as 3 by the floor and dearer, 5 is no number.
        let points = [(1.0, 1.0), (2.0, 0.1), (2.5, 0.2), (3.0, 1e-9), (4.0, 1e-12), (0.1, f64::NAN)];
        assert_eq!(front(&points, 1e-6), [0, 1, 3]);
        assert_eq!(front(&points, 0.0), [0, 1, 3, 4]);
        assert!(front(&[], 1.0).is_empty());
    }

    #[test]
    fn the_order_of_a_power_law_is_its_power() {
        let points: Vec<(f64, f64)> = [1.0_f64, 0.5, 0.25, 0.125].map(|h| (h, 3.0 * h.powi(2))).to_vec();
        assert!((order("", &points, 0.0).unwrap().order - 2.0).abs() < 1e-12);
        // Points at the floor say nothing.
        assert_eq!(order("", &points, 0.05).unwrap().steps, 3);
        assert!(order("", &points, 0.5).is_none());
    }
}
