//! A line that lies through a part with its ends outside: the shortest way out across it.
//!
//! The least translation that parts two convex solids takes a short line out along a face, by a whole end: of a cable
//! through a panel, whose knots lie before opposite faces, that is a knot back through the panel. Across the line it
//! comes out over an edge, as it went in.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::parts::{Primitive, deepest, least};

/// Directions across the line that are tried first. A part of two thousand faces has more; from the best of these one the
/// nearest minimum is found.
const DIRECTIONS: usize = 32;

/// How a line comes out of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Unit vector across the line, out of the part.
    pub normal: Vector3<f64>,
    /// How far it has to go [m].
    pub depth: f64,
    /// Where on the line it leaves the part, from 0 to 1.
    pub share: f64,
}

impl Primitive {
    /// The shortest way out, across it, of the line between two points of its frame; `None` where it does not come
    /// deeper inside than `depth` [m] or ends there.
    pub fn crossing(&self, from: &Vector3<f64>, to: &Vector3<f64>, depth: f64) -> Option<Crossing> {
        let along = to - from;
        let ends_inside = [from, to].into_iter().any(|end| self.depth(end) >= 0.0);
        if ends_inside || self.deepest_at(from, to).1 <= depth {
            return None;
        }
        let across = along.cross(&Vector3::ith(along.iamin(), 1.0)).try_normalize(0.0)?;
        let other = along.cross(&across).try_normalize(0.0)?;
        let normal = |angle: f64| angle.cos() * across + angle.sin() * other;
        let depth = |angle: f64| {
            let normal = normal(angle);
            normal.dot(&(self.support(&normal) - from))
        };
        let step = TAU / DIRECTIONS as f64;
        let angles = (0..DIRECTIONS).map(|index| index as f64 * step);
        let first = angles.min_by(|one, other| depth(*one).total_cmp(&depth(*other)))?;
        let angle = least([first - step, first + step], depth);
        let (normal, depth) = (normal(angle), depth(angle));
        // Moved so far it only touches.
        let out = depth * normal;
        let share = deepest(|share| self.depth(&(from + share * along + out)));
        Some(Crossing { normal, depth, share })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;

    fn panel() -> Primitive {
        Primitive::Cuboid { half: [0.15, 0.4, 0.01] }
    }

    /// Straight through a panel, 3 cm from its edge: the engine's way is along the face, 2 cm and the lesser end.
    #[test]
    fn through_a_panel_the_way_is_over_the_nearest_edge() {
        let [from, to] = [vector![0.12, 0.1, 0.015], vector![0.12, 0.1, -0.2]];
        let found = panel().crossing(&from, &to, 1e-6).unwrap();
        assert!((found.depth - 0.03).abs() < 1e-9, "{found:?}");
        assert!((found.normal - Vector3::x()).norm() < 1e-6, "{found:?}");
        let height = 0.015 - found.share * 0.215;
        assert!(height.abs() < 0.01 + 1e-6, "{height}");
    }

    /// Aslant across an edge it is perpendicular to both.
    #[test]
    fn across_an_edge_the_way_is_square_to_both() {
        // Over the corner of x and z, 5 mm below it, half along y.
        let [from, to] = [vector![0.05, 0.05, 0.105], vector![0.245, -0.05, -0.095]];
        let found = panel().crossing(&from, &to, 1e-6).unwrap();
        let edge = Vector3::y();
        let expected = edge.cross(&(to - from)).normalize();
        let local = found.normal;
        assert!(local.dot(&expected).abs() > 1.0 - 1e-9 && local.x > 0.0, "{local} {expected}");
        // Moved by that it touches the edge, at that place.
        let place = from + found.share * (to - from) + found.depth * local;
        assert!((place.x - 0.15).abs() < 1e-6 && (place.z - 0.01).abs() < 1e-6, "{place}");
    }

    #[test]
    fn what_ends_inside_or_passes_by_has_none() {
        let to = vector![0.12, 0.1, -0.2];
        assert!(panel().crossing(&vector![0.12, 0.1, 0.005], &to, 0.0).is_none());
        assert!(panel().crossing(&vector![0.2, 0.1, 0.1], &to, 0.0).is_none());
    }
}
