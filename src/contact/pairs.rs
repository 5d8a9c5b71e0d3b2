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
//! **Waking.** A pair with gap g sleeps until any two knots can have come g nearer; a queue of all
//! pairs, the next to wake first, is the whole of detection. On the Cubesat's net of 224 strands it
//! takes a tenth of the time of the engine's narrow phase, which looked at every near pair anew.
//!
//! **No passing.** A row acts before the strands touch, when the gap would close within the
//! (sub-)step, so thin strands do not step over each other. Where cables press them into each other
//! all the same, the normal keeps its side: p − q that has turned by more than 90 degrees since it was
//! last looked at has gone through the other strand, and is pushed back through it. (It cannot have
//! turned so far without: the least distance of two convex bodies keeps its side while they move by
//! less than it.)
//!
//! Strands that overlap in the folded net are let be until they have parted once.
//!
//! Frictionless, and strands have no bending: nearly parallel ones touch at one place at a time. Memory
//! is 16 bytes for every two strands.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::{UnitQuaternion, Vector3};
use parry3d::math::Vector as ParryVector;
use parry3d::query::details::closest_points_segment_segment_with_locations_nD as closest_points;

use super::Mobility;
use super::sequential::{self, Bearers, Effort, Row};
use crate::net::Net;
use crate::state::{Body, EffectWork, Knots};

/// Time in which an overlap is undone [s], at least a step.
const PUSH_OUT: f64 = 1e-3;

/// A pair is awake while its gap is less than so many ways that two knots can come nearer in a
/// (sub-)step: contacts can add to their speeds.
const AWAKE: f64 = 2.0;

/// Density of steel [kg/m^3].
const STEEL: f64 = 7850.0;

/// Radius of a steel ball of the bullets' mass [m].
pub fn bullet_radius(net: &Net) -> f64 {
    let mass = net.bullets.iter().map(|&bullet| net.mass[bullet]).fold(0.0, f64::max);
    (0.75 * mass / (std::f64::consts::PI * STEEL)).cbrt()
}

/// Memory that the strands of `net` take when they are watched [bytes].
pub fn memory(net: &Net) -> f64 {
    let n_strands = (net.cables.len() + net.bullets.len()) as f64;
    0.5 * n_strands * n_strands * size_of::<Sleeper>() as f64
}

/// The strands of a net, and their contacts.
pub struct PairWatch {
    strands: Vec<Strand>,
    restitution: f64,
    inverse_mass: Vec<f64>,
    /// How much nearer any two knots can have come since the start [m].
    travelled: f64,
    asleep: BinaryHeap<Reverse<Sleeper>>,
    awake: Vec<Pair>,
    /// Rows of the pairs that act in this sub-step; kept for its memory.
    rows: Vec<Row>,
    /// Impulses within the step, a knot each [N s].
    impulses: Vec<Vector3<f64>>,
    /// Contacts with an impulse within the step, counted in every sub-step.
    n_acted: u64,
    /// Deepest overlap since the start [m].
    pub deepest: f64,
}

/// A cable, or the ball of a bullet.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Strand {
    /// End knots; a bullet's twice.
    ends: [usize; 2],
    radius: f64,
}

/// Two strands far from each other.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sleeper {
    /// When to look again, as a distance travelled [m].
    wake: f64,
    strands: [u32; 2],
}

impl Eq for Sleeper {}

impl Ord for Sleeper {
    fn cmp(&self, other: &Sleeper) -> std::cmp::Ordering {
        self.wake.total_cmp(&other.wake).then(self.strands.cmp(&other.strands))
    }
}

impl PartialOrd for Sleeper {
    fn partial_cmp(&self, other: &Sleeper) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Two strands near each other.
#[derive(Clone, Copy, Debug)]
struct Pair {
    strands: [u32; 2],
    /// From the second to the first when last looked at; 0 before.
    normal: Vector3<f64>,
    /// Whether it overlaps since the net was folded.
    folded_into: bool,
}

/// A pair as it lies now.
struct Near {
    shares: [f64; 2],
    normal: Vector3<f64>,
    gap: f64,
}

impl Near {
    /// `normal`: that of the last look, 0 for a pair that was apart.
    fn of(strands: [&Strand; 2], normal: &Vector3<f64>, knots: &Knots) -> Near {
        let [a, b] = strands.map(|strand| strand.ends.map(|knot| parrys(&knots.position[knot])));
        let (on_a, on_b) = closest_points((&a[0], &a[1]), (&b[0], &b[1]));
        let shares = [on_a, on_b].map(|place| place.barycentric_coordinates()[1]);
        let point = |side: usize| {
            let [from, to] = strands[side].ends.map(|knot| knots.position[knot]);
            from + shares[side] * (to - from)
        };
        let apart = point(0) - point(1);
        let (distance, touching) = (apart.norm(), strands[0].radius + strands[1].radius);
        if distance < 1e-6 * touching {
            return Near { shares, normal: *normal, gap: -touching };
        }
        let side = if apart.dot(normal) < 0.0 { -1.0 } else { 1.0 };
        Near { shares, normal: apart * (side / distance), gap: side * distance - touching }
    }
}

impl PairWatch {
    /// Watches `net`, whose bullets have `bullet_radius` [m].
    pub fn new(net: &Net, bullet_radius: f64, restitution: f64) -> PairWatch {
        let cable = |index: usize| {
            let cable = &net.cables[index];
            Strand { ends: [cable.a, cable.b], radius: net.cable_radius(index) }
        };
        let bullets = net.bullets.iter().map(|&knot| Strand { ends: [knot; 2], radius: bullet_radius });
        let strands: Vec<Strand> = (0..net.cables.len()).map(cable).chain(bullets).collect();
        let folded = Knots { position: net.folded.clone(), velocity: Vec::new() };
        let (mut asleep, mut awake) = (BinaryHeap::new(), Vec::new());
        for (i, one) in strands.iter().enumerate() {
            for (j, other) in strands.iter().enumerate().skip(i + 1) {
                if one.ends.iter().any(|knot| other.ends.contains(knot)) {
                    continue; // tied together
                }
                let Near { normal, gap, .. } = Near::of([one, other], &Vector3::zeros(), &folded);
                let strands = [i as u32, j as u32];
                if gap < 0.0 {
                    awake.push(Pair { strands, normal, folded_into: true });
                } else {
                    asleep.push(Reverse(Sleeper { wake: gap, strands }));
                }
            }
        }
        PairWatch {
            strands,
            restitution,
            inverse_mass: net.mass.iter().map(|mass| 1.0 / mass).collect(),
            travelled: 0.0,
            asleep,
            awake,
            rows: Vec::new(),
            impulses: vec![Vector3::zeros(); net.n_knots()],
            n_acted: 0,
            deepest: 0.0,
        }
    }

    /// Answers the contacts of a (sub-)step of `step` seconds: changes velocities of knots, and marks
    /// them.
    pub fn answer(&mut self, knots: &mut Knots, step: f64, touched: &mut [bool]) {
        let way = step * closing_speed(knots);
        self.rouse(knots, AWAKE * way);
        self.find_acting(knots, step, AWAKE * way);
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
        let (velocity, mobility) = (&mut knots.velocity, Mobility::default());
        sequential::settle(
            &mut self.rows,
            velocity,
            &self.inverse_mass,
            &mut nobody,
            &mobility,
            Effort::WHOLE,
        );
        for row in &self.rows {
            if row.impulse > 0.0 {
                self.n_acted += 1;
                for &(knot, weight) in row.knots.all() {
                    self.impulses[knot] += weight * row.impulse * row.normal;
                    touched[knot] = true;
                }
            }
        }
    }

    /// Wakes the pairs that may be `near` [m] or nearer.
    fn rouse(&mut self, knots: &Knots, near: f64) {
        while let Some(&Reverse(Sleeper { wake, strands })) = self.asleep.peek() {
            if wake > self.travelled + near {
                break;
            }
            self.asleep.pop();
            let Near { normal, gap, .. } = self.look(strands, &Vector3::zeros(), knots);
            if gap > near {
                self.asleep.push(Reverse(Sleeper { wake: self.travelled + gap, strands }));
            } else {
                self.awake.push(Pair { strands, normal, folded_into: false });
            }
        }
    }

    /// Rows of the awake pairs that would touch within the step; those farther than `near` [m] go to
    /// sleep.
    fn find_acting(&mut self, knots: &Knots, step: f64, near: f64) {
        self.rows.clear();
        let mut kept = 0;
        for index in 0..self.awake.len() {
            let mut pair = self.awake[index];
            let place = self.look(pair.strands, &pair.normal, knots);
            if place.gap > near {
                let wake = self.travelled + place.gap;
                self.asleep.push(Reverse(Sleeper { wake, strands: pair.strands }));
                continue;
            }
            pair.normal = place.normal;
            pair.folded_into &= place.gap < 0.0;
            if let Some(row) = self.row(&pair, &place, knots, step) {
                self.rows.push(row);
                self.deepest = self.deepest.max(-place.gap);
            }
            self.awake[kept] = pair;
            kept += 1;
        }
        self.awake.truncate(kept);
    }

    fn look(&self, strands: [u32; 2], normal: &Vector3<f64>, knots: &Knots) -> Near {
        Near::of(strands.map(|strand| &self.strands[strand as usize]), normal, knots)
    }

    /// The row of a pair, if it would touch.
    fn row(&self, pair: &Pair, place: &Near, knots: &Knots, step: f64) -> Option<Row> {
        let [[a, b], [c, d]] = pair.strands.map(|strand| self.strands[strand as usize].ends);
        let Near { shares: [s, t], normal, gap } = *place;
        let bearers = Bearers::Four([(a, 1.0 - s), (b, s), (c, t - 1.0), (d, -t)]);
        let velocity: Vector3<f64> =
            bearers.all().iter().map(|&(knot, weight)| weight * knots.velocity[knot]).sum();
        let speed = normal.dot(&velocity);
        if pair.folded_into || (gap >= 0.0 && gap + step * speed >= 0.0) {
            return None;
        }
        // No faster than the thinner strand's radius in that time: a strand that went through another
        // would be shot off.
        let [one, other] = pair.strands.map(|strand| self.strands[strand as usize].radius);
        let thinner = one.min(other);
        let least = match self.restitution {
            e if e > 0.0 && speed < 0.0 => -e * speed,
            _ if gap >= 0.0 => -gap / step,
            _ => (-gap).min(thinner) / PUSH_OUT.max(step),
        };
        // From nothing: in a wad the impulses of the step before are no guess, and passes that end
        // before they have taken a bad one back leave its energy behind.
        Some(Row { knots: bearers, normal, arm: None, least, softness: 0.0, impulse: 0.0 })
    }

    /// What it did since the last time, within a step from `before` to `after`.
    ///
    /// Work on the knots: Σ J · (v⁻ + v⁺) / 2 over their impulses J, exactly its share in the change
    /// of their energy.
    pub fn account(&mut self, before: &Knots, after: &Knots) -> EffectWork {
        let count = std::mem::take(&mut self.n_acted);
        if count == 0 {
            return EffectWork::default();
        }
        let mut work = 0.0;
        for (knot, impulse) in self.impulses.iter_mut().enumerate() {
            let impulse = std::mem::take(impulse);
            work += 0.5 * impulse.dot(&(before.velocity[knot] + after.velocity[knot]));
        }
        EffectWork { work, on_knots: work, count, ..EffectWork::default() }
    }

    /// Number of pairs.
    pub fn n_pairs(&self) -> usize {
        self.asleep.len() + self.awake.len()
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
