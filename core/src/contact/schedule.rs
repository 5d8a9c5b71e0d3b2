//! When to look for contacts anew: two levels of detection (Section 4.5.1).
//!
//! While the box of the net and the ball around the target are apart nothing is detected. A detection
//! sees as far as `margin`, and as far as a snap can throw a knot within a step. The next is due
//! before a knot that it did not see may touch, and when one that it saw has moved along the surface by
//! some share of the margin: its plane may then stand for an edge that it has passed. All motion is as seen from
//! the target, so a net that lies on a target and turns with it needs no detection.

use nalgebra::Vector3;

use crate::state::{Body, Knots};
use crate::target::parts::ConvexPart;

/// How far knots have moved since the last detection.
#[derive(Clone, Debug)]
pub struct DetectionSchedule {
    margin: f64,
    solids: Vec<BoundedPart>,
    /// Of a ball around all of them and what touches them [m].
    bounding_radius: f64,
    stale: Stale,
    /// How far a knot may come within the step [m].
    thrown: f64,
    /// Every knot; none before the first detection, and while net and target are apart.
    seen: Vec<Seen>,
    /// Those last renewed; kept for its memory.
    renewed: Vec<(usize, Vector3<f64>)>,
}

/// When what was found is looked at again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stale {
    /// Share of the margin by which a knot may move along the surface, and what was found stands [-].
    pub holds: f64,
    /// A detection looks again at every knot that has used up this share of its way, so that fewer follow [-].
    pub renews: f64,
}

/// A part of the target, and a ball around it in the body frame [m].
#[derive(Clone, Debug)]
struct BoundedPart {
    part: ConvexPart,
    centre: Vector3<f64>,
    radius: f64,
}

/// A knot when it was last looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    /// In the body frame [m].
    at: Vector3<f64>,
    /// How far from there the surface is at least, but for what was found [m].
    clear: f64,
    found: Found,
}

/// What was found near a knot.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Found {
    Nothing,
    /// A plane of this normal in the body frame: it holds while the knot moves along it by no more than its
    /// share of the margin.
    Plane(Vector3<f64>),
    /// Several, or cables at it: they hold while it moves by no more than that.
    Several,
}

/// What is to be done before a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Detection {
    /// Nothing can touch: forget what was found.
    Separated,
    /// What was found still stands.
    Cached,
    /// Detect, as far as so many metres.
    Stale(f64),
}

impl DetectionSchedule {
    /// For detections that see as far as `margin` [m], around a target of these `parts` that knots touch within a `bounding_radius` [m], and look
    /// again at what is `stale`.
    pub fn new(margin: f64, parts: &[ConvexPart], bounding_radius: f64, stale: Stale) -> DetectionSchedule {
        let solid = |part: &ConvexPart| {
            let (centre, radius) = part.bounding_ball();
            BoundedPart { part: part.clone(), centre, radius }
        };
        DetectionSchedule {
            margin,
            solids: parts.iter().map(solid).collect(),
            bounding_radius,
            stale,
            thrown: 0.0,
            seen: Vec::new(),
            renewed: Vec::new(),
        }
    }

    /// Before a step of `step` seconds. After `Stale` a detection has to follow, with `renew`.
    pub fn update(&mut self, knots: &Knots, body: &Body, step: f64) -> Detection {
        let speed_squared =
            |(x, v): (&Vector3<f64>, &Vector3<f64>)| (v - body.velocity_at(*x)).norm_squared();
        let fastest =
            knots.position.iter().zip(&knots.velocity).map(speed_squared).fold(0.0, f64::max).sqrt();
        // A snap may double a knot's speed.
        self.thrown = 2.0 * step * fastest;
        let margin = self.margin + self.thrown;
        if knots.apart_from(body, self.bounding_radius + margin) {
            self.seen.clear();
            return Detection::Separated;
        }
        let to_body = body.all_to_body();
        let mut seen = knots.position.iter().zip(&self.seen);
        if self.seen.is_empty() || seen.any(|(x, seen)| self.has_used(1.0, seen, &to_body(x))) {
            return Detection::Stale(margin);
        }
        Detection::Cached
    }

    /// Whether net and target were apart at the last update, as they are before any.
    pub fn is_separated(&self) -> bool {
        self.seen.is_empty()
    }

    /// How far a knot may come within the step, as seen from the target [m].
    pub fn thrown(&self) -> f64 {
        self.thrown
    }

    /// Whether a knot has used up more than a `share` of the way that it may move before the next detection, at `at` in the
    /// body frame.
    fn has_used(&self, share: f64, seen: &Seen, at: &Vector3<f64>) -> bool {
        let moved = at - seen.at;
        let squared = moved.norm_squared();
        let left = seen.clear - self.thrown;
        let held = share * self.stale.holds * self.margin;
        let slid = match seen.found {
            Found::Nothing => 0.0,
            Found::Plane(normal) => squared - normal.dot(&moved).powi(2),
            Found::Several => squared,
        };
        // A knot may have nothing left without having moved, where others have become fast.
        left <= 0.0 || squared > (share * left).powi(2) || slid > held * held
    }

    /// For a detection as far as `margin` [m]: the knots that have to be looked at again, and where they are
    /// in the body frame. What was found of others stands. What may touch at a knot is within its `reach` [m].
    pub fn renew(
        &mut self,
        knots: &Knots,
        body: &Body,
        margin: f64,
        reach: impl Fn(usize) -> f64,
    ) -> &[(usize, Vector3<f64>)] {
        self.renewed.clear();
        let (is_first, to_body) = (self.seen.is_empty(), body.all_to_body());
        for (knot, position) in knots.position.iter().enumerate() {
            let at = to_body(position);
            if !is_first && !self.has_used(self.stale.renews, &self.seen[knot], &at) {
                continue;
            }
            // One that is far away may move by more.
            let clear = margin.max(self.distance(&at) - reach(knot));
            let fresh = Seen { at, clear, found: Found::Nothing };
            if is_first {
                self.seen.push(fresh);
            } else {
                self.seen[knot] = fresh;
            }
            self.renewed.push((knot, at));
        }
        &self.renewed
    }

    /// How far a place in the body frame is from the target at least [m]; not above zero where it may be inside.
    fn distance(&self, at: &Vector3<f64>) -> f64 {
        let mut nearest = f64::INFINITY;
        for BoundedPart { part, centre, radius } in &self.solids {
            let from_ball = (at - centre).norm() - radius;
            if from_ball < nearest {
                nearest = nearest.min(from_ball.max(part.clearance(at)));
            }
        }
        nearest
    }

    /// Where a knot was when it was last looked at, in the body frame [m].
    pub fn at(&self, knot: usize) -> Vector3<f64> {
        self.seen[knot].at
    }

    /// Hears that the detection found a plane near a knot, of this normal in the body frame.
    pub fn found(&mut self, knot: usize, normal: Vector3<f64>) {
        if self.renewed.binary_search_by_key(&knot, |(renewed, _)| *renewed).is_err() {
            return; // what was found of it stands
        }
        let found = &mut self.seen[knot].found;
        *found = if *found == Found::Nothing { Found::Plane(normal) } else { Found::Several };
    }

    /// Hears that the detection found a cable at a knot to be near the target.
    pub fn found_cable(&mut self, knot: usize) {
        self.seen[knot].found = Found::Several;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::target::parts::Primitive;
    use nalgebra::{Isometry3, UnitQuaternion, vector};

    const STEP: f64 = 1e-3;

    /// For a ball of 1 m.
    fn around_a_ball() -> DetectionSchedule {
        for_knots_of(0.0)
    }

    /// The same for knots of a radius [m].
    fn for_knots_of(radius: f64) -> DetectionSchedule {
        let primitive = Primitive::Ball { radius: 1.0 };
        let ball = ConvexPart { name: None, primitive, pose: Isometry3::identity(), mass: 1.0 };
        DetectionSchedule::new(0.01, &[ball], 1.0 + radius, Stale { holds: 0.5, renews: 0.25 })
    }

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
    fn detections(schedule: &mut DetectionSchedule, knot: impl Fn(f64) -> Knots, rate: f64) -> usize {
        let mut n = 0;
        for step in 0..1000 {
            let time = f64::from(step) * STEP;
            let (knots, body) = (knot(time), wheel(rate, time));
            if let Detection::Stale(margin) = schedule.update(&knots, &body, STEP) {
                schedule.renew(&knots, &body, margin, |_| 0.0);
                schedule.found(0, Vector3::x());
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
        assert_eq!(detections(&mut around_a_ball(), turning, rate), 1);
    }

    #[test]
    fn one_that_slides_is_looked_for_every_half_margin_and_one_that_sinks_every_margin() {
        let sliding = |time: f64| one_knot(vector![1.0, 0.101 * time, 0.0], vector![0.0, 0.101, 0.0]);
        // 0.101 m in steps of 0.1 mm, with a detection after every 5 mm: 50 steps.
        assert_eq!(detections(&mut around_a_ball(), sliding, 0.0), 20);
        let sinking = |time: f64| one_knot(vector![1.0 - 0.101 * time, 0.0, 0.0], vector![-0.101, 0.0, 0.0]);
        assert_eq!(detections(&mut around_a_ball(), sinking, 0.0), 10, "its plane stays");
    }

    /// Whatever its speed and its radius, a knot from afar is seen before it touches, and in few detections.
    #[test]
    fn one_that_comes_from_afar_is_seen_before_it_touches() {
        for (speed, radius) in
            [0.01, 1.0, 30.0, 3e3].into_iter().flat_map(|speed| [(speed, 0.0), (speed, 0.1)])
        {
            let mut schedule = for_knots_of(radius);
            let (mut x, mut n, mut found) = (5.0, 0, false);
            while x > 1.0 + radius {
                let (knots, body) =
                    (one_knot(vector![x, 0.0, 0.0], vector![-speed, 0.0, 0.0]), wheel(0.0, 0.0));
                if let Detection::Stale(margin) = schedule.update(&knots, &body, STEP) {
                    found = x - 1.0 - radius <= margin;
                    schedule.renew(&knots, &body, margin, |_| radius);
                    if found {
                        schedule.found(0, Vector3::x());
                    }
                    n += 1;
                }
                x -= speed * STEP;
            }
            assert!(found, "at {speed} m/s, radius {radius} m");
            assert!(n <= 3, "{n} detections at {speed} m/s, radius {radius} m");
        }
    }

    /// What it may be thrown by counts, and not only how far it has come.
    #[test]
    fn one_at_rest_is_looked_for_when_another_becomes_fast() {
        let two = |speed: f64| Knots {
            position: vec![vector![1.02, 0.0, 0.0], vector![9.0, 0.0, 0.0]],
            velocity: vec![Vector3::zeros(), vector![speed, 0.0, 0.0]],
        };
        let (mut schedule, body) = (around_a_ball(), wheel(0.0, 0.0));
        assert!(matches!(schedule.update(&two(6.0), &body, STEP), Detection::Stale(_)));
        schedule.renew(&two(6.0), &body, 0.022, |_| 0.0);
        assert_eq!(schedule.update(&two(6.0), &body, STEP), Detection::Cached);
        assert!(matches!(schedule.update(&two(20.0), &body, STEP), Detection::Stale(_)));
    }
}
