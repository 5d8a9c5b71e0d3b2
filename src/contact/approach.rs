//! When to look for contacts anew: two levels of detection (Section 4.5.1).
//!
//! While the box of the net and the ball around the target are apart nothing is detected. After a
//! detection that saw as far as `reach`, the next is due before anything can have come half of it
//! nearer; it sees as far as the fastest knot may come within a step.

use crate::state::{Body, Knots};

/// How near net and target may have come since the last detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    reach: f64,
    bounding_radius: f64,
    /// How much nearer a knot may have come since the last detection [m].
    nearer: f64,
}

/// What is to be done before a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// Nothing can touch: forget what was found.
    Apart,
    /// What was found still stands.
    Known,
    /// Detect, as far as so many metres.
    Due(f64),
}

impl Approach {
    /// For detections that see as far as `reach` [m], around a target of `bounding_radius` [m].
    pub fn new(reach: f64, bounding_radius: f64) -> Approach {
        Approach { reach, bounding_radius, nearer: f64::INFINITY }
    }

    /// Before a step of `step` seconds. After `Due` the detection is taken as done.
    pub fn look(&mut self, knots: &Knots, body: &Body, step: f64) -> Look {
        let speed_squared = |v: &nalgebra::Vector3<f64>| (v - body.velocity).norm_squared();
        let fastest = knots.velocity.iter().map(speed_squared).fold(0.0, f64::max).sqrt();
        let nearer = step * (fastest + body.rate.norm() * self.bounding_radius);
        // A snap within the step may double a knot's speed; half the reach is left for that. A knot
        // so fast that it comes past half the reach in one step would be in the target unseen.
        let reach = self.reach.max(2.0 * nearer);
        if knots.apart_from(body, self.bounding_radius + reach) {
            self.nearer = f64::INFINITY;
            return Look::Apart;
        }
        self.nearer += nearer;
        if self.nearer > 0.5 * self.reach {
            self.nearer = 0.0;
            return Look::Due(reach);
        }
        Look::Known
    }

    /// Whether contacts are being looked for.
    pub fn near(&self) -> bool {
        self.nearer.is_finite()
    }
}
