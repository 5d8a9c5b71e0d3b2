//! When to look for contacts anew: two levels of detection (Section 4.5.1).
//!
//! While the box of the net and the ball around the target are apart nothing is detected. A detection
//! sees as far as `reach`, and as a snap can throw a knot within a step. The next is due
//! before a knot that it did not see may touch, and when one that it saw has moved along the surface by
//! half the reach: its plane may then stand for an edge that it has passed. All motion is as seen from
//! the target, so a net that lies on a target and turns with it needs no detection.

use nalgebra::Vector3;

use crate::state::{Body, Knots};

/// How far knots have moved since the last detection.
#[derive(Clone, Debug, PartialEq)]
pub struct Approach {
    reach: f64,
    bounding_radius: f64,
    /// Every knot at the last detection; none before the first, and while net and target are apart.
    seen: Vec<Seen>,
}

/// A knot at the last detection.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    /// In the body frame [m].
    at: Vector3<f64>,
    leash: Leash,
}

/// How far a knot may move from where it was at the last detection.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Leash {
    /// As far from where it was as the surface was at least [m].
    Clear(f64),
    /// Half the reach along its plane of this normal in the body frame.
    Plane(Vector3<f64>),
    /// Half the reach: it is near several parts, or cables at it may be near at other places than those
    /// found.
    Short,
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
        Approach { reach, bounding_radius, seen: Vec::new() }
    }

    /// Before a step of `step` seconds. After `Due` one of `saw_knots` and `saw_cables` has to follow.
    pub fn look(&mut self, knots: &Knots, body: &Body, step: f64) -> Look {
        let speed_squared = |(x, v): (&Vector3<f64>, &Vector3<f64>)| {
            (v - body.velocity - body.rate.cross(&(x - body.position))).norm_squared()
        };
        let fastest =
            knots.position.iter().zip(&knots.velocity).map(speed_squared).fold(0.0, f64::max).sqrt();
        // A snap may double a knot's speed.
        let thrown = 2.0 * step * fastest;
        let reach = self.reach + thrown;
        if knots.apart_from(body, self.bounding_radius + reach) {
            self.seen.clear();
            return Look::Apart;
        }
        let strays = |(position, seen): (&Vector3<f64>, &Seen)| {
            let moved = in_body(position, body) - seen.at;
            match seen.leash {
                Leash::Clear(clear) => moved.norm() + thrown > clear,
                Leash::Plane(normal) => (moved - normal * normal.dot(&moved)).norm() > 0.5 * self.reach,
                Leash::Short => moved.norm() > 0.5 * self.reach,
            }
        };
        if self.seen.is_empty() || knots.position.iter().zip(&self.seen).any(strays) {
            return Look::Due(reach);
        }
        Look::Known
    }

    /// Hears that a detection as far as `reach` [m] saw knots near planes of these normals in the body frame.
    pub fn saw_knots(
        &mut self,
        knots: &Knots,
        body: &Body,
        reach: f64,
        planes: impl Iterator<Item = (usize, Vector3<f64>)>,
    ) {
        self.seen.clear();
        self.seen.extend(knots.position.iter().map(|position| {
            let at = in_body(position, body);
            // One that is far away may move by more.
            Seen { at, leash: Leash::Clear(reach.max(at.norm() - self.bounding_radius)) }
        }));
        for (knot, normal) in planes {
            let leash = &mut self.seen[knot].leash;
            *leash = if matches!(leash, Leash::Clear(_)) { Leash::Plane(normal) } else { Leash::Short };
        }
    }

    /// Hears that a detection saw the cables between `knots`.
    pub fn saw_cables(&mut self, knots: &Knots, body: &Body) {
        self.seen.clear();
        let seen = |position| Seen { at: in_body(position, body), leash: Leash::Short };
        self.seen.extend(knots.position.iter().map(seen));
    }

    /// Whether contacts are being looked for.
    pub fn near(&self) -> bool {
        !self.seen.is_empty()
    }
}

fn in_body(position: &Vector3<f64>, body: &Body) -> Vector3<f64> {
    body.attitude.inverse_transform_vector(&(position - body.position))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{UnitQuaternion, vector};

    const STEP: f64 = 1e-3;

    /// A wheel of radius 1 m that turns about Z.
    fn wheel(rate: f64, time: f64) -> Body {
        Body {
            attitude: UnitQuaternion::from_scaled_axis(vector![0.0, 0.0, rate * time]),
            rate: vector![0.0, 0.0, rate],
            position: Vector3::zeros(),
            velocity: Vector3::zeros(),
        }
    }

    fn one_knot(position: Vector3<f64>, velocity: Vector3<f64>) -> Knots {
        Knots { position: vec![position], velocity: vec![velocity] }
    }

    /// Number of detections in a second of a knot that the last one saw near a plane across X.
    fn detections(approach: &mut Approach, knot: impl Fn(f64) -> Knots, rate: f64) -> usize {
        let mut n = 0;
        for step in 0..1000 {
            let time = f64::from(step) * STEP;
            let (knots, body) = (knot(time), wheel(rate, time));
            if let Look::Due(reach) = approach.look(&knots, &body, STEP) {
                approach.saw_knots(&knots, &body, reach, [(0, Vector3::x())].into_iter());
                n += 1;
            }
        }
        n
    }

    #[test]
    fn a_knot_that_turns_with_the_target_is_looked_for_once() {
        let rate = 2.0;
        let turning = |time: f64| {
            let at = wheel(rate, time).attitude * Vector3::x();
            one_knot(at, wheel(rate, time).rate.cross(&at))
        };
        assert_eq!(detections(&mut Approach::new(0.01, 1.0), turning, rate), 1);
    }

    #[test]
    fn one_that_slides_is_looked_for_every_half_reach() {
        let sliding = |time: f64| one_knot(vector![1.0, 0.101 * time, 0.0], vector![0.0, 0.101, 0.0]);
        // 0.101 m in steps of 0.1 mm, with a detection after every 5 mm: 50 steps.
        assert_eq!(detections(&mut Approach::new(0.01, 1.0), sliding, 0.0), 20);
        let sinking = |time: f64| one_knot(vector![1.0 - 0.101 * time, 0.0, 0.0], vector![-0.101, 0.0, 0.0]);
        assert_eq!(detections(&mut Approach::new(0.01, 1.0), sinking, 0.0), 1, "its plane stays");
    }

    /// Whatever its speed, a knot from afar is seen before it touches, and in few detections.
    #[test]
    fn one_that_comes_from_afar_is_seen_before_it_touches() {
        for speed in [0.01, 1.0, 30.0, 3e3] {
            let mut approach = Approach::new(0.01, 1.0);
            let (mut x, mut n, mut found) = (5.0, 0, false);
            while x > 1.0 {
                let (knots, body) =
                    (one_knot(vector![x, 0.0, 0.0], vector![-speed, 0.0, 0.0]), wheel(0.0, 0.0));
                if let Look::Due(reach) = approach.look(&knots, &body, STEP) {
                    found = x - 1.0 <= reach;
                    approach.saw_knots(&knots, &body, reach, found.then(|| (0, Vector3::x())).into_iter());
                    n += 1;
                }
                x -= speed * STEP;
            }
            assert!(found, "at {speed} m/s");
            assert!(n <= 3, "{n} detections at {speed} m/s");
        }
    }
}
