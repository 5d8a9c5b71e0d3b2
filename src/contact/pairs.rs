//! Contact of the net with itself: cables against cables, bullets against both.
//!
//! Two strands (a cable is a segment with the radius of its cable, a bullet a ball) touch at their
//! closest points p and q, at shares s and t of the segments:
//!
//!   gap = n · (p − q) − r₁ − r₂,  n = (p − q) / |p − q|,
//!
//! and a row of [`super::sequential`] keeps n · (ṗ − q̇) from closing it: weights 1 − s, s, −(1 − t), −t.
//! The impulse acts along p − q, so linear and angular momentum of the net are kept exactly. What
//! a knot ties together is no pair.
//!
//! **No passing.** A row acts before the strands touch, when the gap would close within the
//! (sub-)step, so thin strands do not step over each other. Where cables press them into each other
//! all the same, the normal keeps its side: p − q that has turned by more than 90 degrees since it was
//! last looked at has gone through the other strand, and is pushed back through it. While a pair is
//! not looked at it cannot have turned: a pair with gap g sleeps until any two knots can have
//! come g nearer.
//!
//! Strands that overlap in the folded net are let be until they have parted once.
//!
//! Frictionless, and strands have no bending: nearly parallel ones touch at one place at a time.

use nalgebra::{UnitQuaternion, Vector3};
use parry3d::math::Vector as ParryVector;
use parry3d::query::details::closest_points_segment_segment_with_locations_nD as closest_points;

use super::Mobility;
use super::sequential::{self, Bearers, Effort, Row};
use crate::net::Net;
use crate::state::{Body, Knots, Posting};
use crate::world::capsules::{SelfDetector, Strand};

/// Time in which an overlap is undone [s], at least a step.
const PUSH_OUT: f64 = 1e-3;

/// How far detection sees, in ways that a bullet flies within a step.
const REACH: f64 = 8.0;

/// Density of steel [kg/m^3].
const STEEL: f64 = 7850.0;

/// Radius of a steel ball of the bullets' mass [m].
pub fn bullet_radius(net: &Net) -> f64 {
    let mass = net.bullets.iter().map(|&bullet| net.mass[bullet]).fold(0.0, f64::max);
    (0.75 * mass / (std::f64::consts::PI * STEEL)).cbrt()
}

/// The pairs of strands that are near, and their contacts.
pub struct PairWatch {
    detector: Option<SelfDetector>,
    net: Net,
    bullet_radius: f64,
    restitution: f64,
    inverse_mass: Vec<f64>,
    reach: f64,
    /// How much nearer any two knots can have come since the start [m].
    travelled: f64,
    /// The same at the last detection [m].
    detected_at: f64,
    pairs: Vec<Pair>,
    found: Vec<[Strand; 2]>,
    /// Pairs that act in this sub-step, and their rows; kept for their memory.
    acting: Vec<usize>,
    rows: Vec<Row>,
    /// Impulses within the step, a knot each [N s].
    impulses: Vec<Vector3<f64>>,
    /// Contacts with an impulse within the step, counted in every sub-step.
    n_acted: u64,
    /// Deepest overlap since the start [m].
    pub deepest: f64,
    /// Times the engine looked for pairs.
    pub n_detections: u64,
}

/// Two strands.
struct Pair {
    strands: [Strand; 2],
    /// End knots of both; a bullet's twice.
    ends: [[usize; 2]; 2],
    /// r₁ + r₂ [m]
    touching: f64,
    /// From the second to the first when last looked at.
    normal: Vector3<f64>,
    /// When to look again, as a distance travelled [m].
    wake: f64,
    /// Impulse within the last sub-step [N s].
    impulse: f64,
    /// Whether it overlaps since the net was folded.
    folded_into: bool,
}

/// A pair as it lies now.
struct Near {
    shares: [f64; 2],
    normal: Vector3<f64>,
    gap: f64,
}

impl Pair {
    fn place(&self, knots: &Knots) -> Near {
        let [a, b] = self.ends.map(|ends| ends.map(|knot| parrys(&knots.position[knot])));
        let (on_a, on_b) = closest_points((&a[0], &a[1]), (&b[0], &b[1]));
        let shares = [on_a, on_b].map(|place| place.barycentric_coordinates()[1]);
        let point = |side: usize| {
            let [from, to] = self.ends[side].map(|knot| knots.position[knot]);
            from + shares[side] * (to - from)
        };
        let apart = point(0) - point(1);
        let distance = apart.norm();
        if distance < 1e-3 * self.touching {
            return Near { shares, normal: self.normal, gap: -self.touching };
        }
        let through = apart.dot(&self.normal) < 0.0;
        let side = if through { -1.0 } else { 1.0 };
        Near { shares, normal: apart * (side / distance), gap: side * distance - self.touching }
    }
}

impl PairWatch {
    /// Watches `net`, whose bullets have `bullet_radius` [m].
    pub fn new(net: &Net, bullet_radius: f64, restitution: f64) -> PairWatch {
        PairWatch {
            detector: None,
            net: net.clone(),
            bullet_radius,
            restitution,
            inverse_mass: net.mass.iter().map(|mass| 1.0 / mass).collect(),
            reach: 0.0,
            travelled: 0.0,
            detected_at: f64::NEG_INFINITY,
            pairs: Vec::new(),
            found: Vec::new(),
            acting: Vec::new(),
            rows: Vec::new(),
            impulses: vec![Vector3::zeros(); net.n_knots()],
            n_acted: 0,
            deepest: 0.0,
            n_detections: 0,
        }
    }

    /// Before a step of `step` seconds: finds the pairs anew where they are due.
    pub fn look(&mut self, knots: &Knots, step: f64) {
        // Half the reach is left for what snaps and contacts add to speeds within the step.
        if self.travelled + step * closing_speed(knots) - self.detected_at <= 0.5 * self.reach {
            return;
        }
        let thickest = self.net.radius.iter().copied().fold(self.bullet_radius, f64::max);
        let fastest = self.net.launch_velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        self.reach = (REACH * fastest * step).max(thickest);
        let detector =
            self.detector.get_or_insert_with(|| SelfDetector::new(&self.net, self.bullet_radius, self.reach));
        detector.detect(knots, &mut self.found);
        let is_first = self.n_detections == 0;
        self.n_detections += 1;
        self.detected_at = self.travelled;
        let mut before = std::mem::take(&mut self.pairs).into_iter().peekable();
        for strands in self.found.drain(..) {
            while before.next_if(|pair| pair.strands < strands).is_some() {}
            let pair = before.next_if(|pair| pair.strands == strands).unwrap_or_else(|| {
                let ends = strands.map(|strand| match strand {
                    Strand::Cable(cable) => [self.net.cables[cable].a, self.net.cables[cable].b],
                    Strand::Bullet(knot) => [knot, knot],
                });
                let radius = strands.map(|strand| match strand {
                    Strand::Cable(cable) => self.net.cable_radius(cable),
                    Strand::Bullet(_) => self.bullet_radius,
                });
                let touching = radius[0] + radius[1];
                let (normal, wake) = (Vector3::zeros(), f64::NEG_INFINITY);
                let mut pair =
                    Pair { strands, ends, touching, normal, wake, impulse: 0.0, folded_into: false };
                let near = pair.place(knots);
                pair.normal = near.normal;
                pair.folded_into = is_first && near.gap < 0.0;
                pair
            });
            self.pairs.push(pair);
        }
    }

    /// Answers the contacts of a (sub-)step of `step` seconds: changes velocities of knots, and marks
    /// them.
    pub fn answer(&mut self, knots: &mut Knots, step: f64, touched: &mut [bool]) {
        let way = step * closing_speed(knots);
        self.find_acting(knots, step, way);
        self.travelled += way;
        if self.rows.is_empty() {
            return;
        }
        // The target has no part in it: no row names one.
        let mut nobody = Body {
            position: Vector3::zeros(),
            attitude: UnitQuaternion::identity(),
            velocity: Vector3::zeros(),
            rate: Vector3::zeros(),
        };
        let mobility = Mobility::default();
        sequential::settle(
            &mut self.rows,
            &mut knots.velocity,
            &self.inverse_mass,
            &mut nobody,
            &mobility,
            Effort::WHOLE,
        );
        for (row, &index) in self.rows.iter().zip(&self.acting) {
            self.pairs[index].impulse = row.impulse;
            if row.impulse > 0.0 {
                self.n_acted += 1;
                for (knot, weight) in row.knots.all().iter().copied() {
                    self.impulses[knot] += weight * row.impulse * row.normal;
                    touched[knot] = true;
                }
            }
        }
    }

    /// Rows of the pairs that would touch while any two knots come nearer by `way` [m].
    fn find_acting(&mut self, knots: &Knots, step: f64, way: f64) {
        self.acting.clear();
        self.rows.clear();
        for (index, pair) in self.pairs.iter_mut().enumerate() {
            // Twice the way, since contacts can add to speeds in this sub-step.
            if self.travelled + 2.0 * way < pair.wake {
                continue;
            }
            let Near { shares: [s, t], normal, gap } = pair.place(knots);
            pair.normal = normal;
            pair.wake = self.travelled + gap;
            if pair.folded_into {
                pair.folded_into = gap < 0.0;
                continue;
            }
            let [[a, b], [c, d]] = pair.ends;
            let row = Row {
                knots: Bearers::Four([(a, 1.0 - s), (b, s), (c, t - 1.0), (d, -t)]),
                normal,
                arm: None,
                least: 0.0,
                softness: 0.0,
                impulse: pair.impulse,
            };
            let speed = normal.dot(&row.velocity_of_knots(&knots.velocity));
            if gap >= 0.0 && gap + step * speed >= 0.0 {
                pair.impulse = 0.0;
                continue;
            }
            self.deepest = self.deepest.max(-gap);
            let least = match self.restitution {
                e if e > 0.0 && speed < 0.0 => -e * speed,
                _ if gap >= 0.0 => -gap / step,
                _ => -gap / PUSH_OUT.max(step),
            };
            self.rows.push(Row { least, ..row });
            self.acting.push(index);
        }
    }

    /// What it did since the last time, within a step from `before` to `after`.
    ///
    /// Work on the knots: Σ J · (v⁻ + v⁺) / 2 over their impulses J, exactly its share in the change
    /// of their energy.
    pub fn account(&mut self, before: &Knots, after: &Knots) -> Posting {
        let count = std::mem::take(&mut self.n_acted);
        if count == 0 {
            return Posting::default();
        }
        let mut work = 0.0;
        for (knot, impulse) in self.impulses.iter_mut().enumerate() {
            let impulse = std::mem::take(impulse);
            work += 0.5 * impulse.dot(&(before.velocity[knot] + after.velocity[knot]));
        }
        Posting { work, on_knots: work, count, ..Posting::default() }
    }

    /// Number of colliders of the detector.
    pub fn n_colliders(&self) -> usize {
        self.net.cables.len() + self.net.bullets.len()
    }
}

/// Largest speed at which any two knots can come nearer [m/s].
fn closing_speed(knots: &Knots) -> f64 {
    let mean = knots.velocity.iter().sum::<Vector3<f64>>() / knots.velocity.len() as f64;
    2.0 * knots.velocity.iter().map(|v| (v - mean).norm_squared()).fold(0.0, f64::max).sqrt()
}

fn parrys(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}
