//! Whether the folded net is clear of the target.

use nalgebra::Vector3;

use crate::net::Net;
use crate::problems::Problems;
use crate::target::Target;
use crate::target::parts::ConvexPart;

/// Deepest overlap of a knot with the target at the start, over its radius [-]: more is no touch. A
/// response would push it out within a step, hence shoot it off.
const MAX_OVERLAP: f64 = 0.01;

/// Overlaps after which no deeper one is looked for.
const ENOUGH: usize = 1000;

/// The parts of a target, to be asked which are near: a large net asks some hundred million times.
struct PartsNear<'a> {
    target: &'a Target,
    /// One a part: centre and radius [m].
    balls: Vec<(Vector3<f64>, f64)>,
}

impl<'a> PartsNear<'a> {
    fn of(target: &'a Target) -> PartsNear<'a> {
        PartsNear { target, balls: target.parts.iter().map(ConvexPart::bounding_ball).collect() }
    }

    /// Those that are not surely farther than `distance` from `point`, with their numbers.
    fn within(&self, point: Vector3<f64>, distance: f64) -> impl Iterator<Item = (usize, &ConvexPart)> {
        let is_near = point.norm() <= self.target.bounding_radius + distance;
        let balls = if is_near { &self.balls[..] } else { &[] };
        let all = balls.iter().zip(&self.target.parts).enumerate();
        all.filter(move |(_, ((centre, radius), _))| {
            (point - centre).norm_squared() <= (radius + distance).powi(2)
        })
        .map(|(number, (_, part))| (number, part))
        .filter(move |(_, part)| !part.is_farther(&point, distance))
    }
}

/// Checks that the cables of the folded net are clear of the target, where they touch it: the way out of a part that a
/// cable lies through is no one's to say.
pub(super) fn cables(net: &Net, target: &Target, problems: &mut Problems) {
    let folded =
        |knot: usize| target.attitude.inverse_transform_vector(&(net.folded[knot] - target.position));
    let parts = PartsNear::of(target);
    let mut deepest: Option<(usize, usize, f64)> = None;
    for (index, cable) in net.cables.iter().enumerate() {
        let (from, to, radius) = (folded(cable.a), folded(cable.b), net.cable_radius(index));
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from).norm());
        for (number, part) in parts.within(middle, radius + half) {
            let overlap = part.deepest_between(&from, &to) + radius;
            if overlap > MAX_OVERLAP * radius && deepest.is_none_or(|(_, _, known)| overlap > known) {
                deepest = Some((index, number, overlap));
            }
        }
    }
    if let Some((cable, part, overlap)) = deepest {
        problems.add(
            "target.distance_m",
            format!("cable {cable} of the folded net {overlap:.3e} m inside part {part} of the target"),
            "a target clear of the folded net's cables, which touch it with effects.cable_contact: farther away, or a \
             smaller net.fold.ratio",
        );
    }
}

/// Checks that the folded net is clear of the target.
pub(super) fn knots(net: &Net, target: &Target, problems: &mut Problems) {
    let parts = PartsNear::of(target);
    let mut deepest: Option<(usize, usize, f64)> = None;
    let mut n_inside = 0;
    for (knot, (position, radius)) in net.folded.iter().zip(&net.radius).enumerate() {
        let point = target.attitude.inverse_transform_vector(&(position - target.position));
        for (index, part) in parts.within(point, *radius) {
            let overlap = part.depth(&point) + radius;
            if overlap > MAX_OVERLAP * radius {
                n_inside += 1;
                if deepest.is_none_or(|(_, _, known)| overlap > known) {
                    deepest = Some((knot, index, overlap));
                }
            }
        }
        if n_inside > ENOUGH {
            break;
        }
    }
    if let Some((knot, part, overlap)) = deepest {
        problems.add(
            "target.distance_m",
            format!("knot {knot} of the folded net {overlap:.3e} m inside part {part} of the target"),
            "a target clear of the folded net: farther away, or a smaller net.fold.ratio",
        );
    }
}
