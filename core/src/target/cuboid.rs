//! Where a straight cable is near a box: by formula.
//!
//! The engine goes from simplex to simplex until the two are nearest, and then clips feature against feature, for any two convex
//! solids: half of what whole cables cost around a Cubesat. Between a line and a box all of it has a formula.
//!
//! Along the line the square of its distance to the box is convex, and its slope is a straight line between the shares at which it
//! crosses the planes of the faces: the zero is found by halving at those six. A line that comes inside has the shortest way out along
//! the normal of a face, or square to itself and to an edge.

use nalgebra::Vector3;

/// What stands out by less than this beyond a plane is behind it [m].
const FLAT: f64 = 1e-5;

/// A line nearer than this touches [m]: the way between the two has no direction.
const TOUCHING: f64 = 1e-9;

/// Sine of the angle up to which a line has the direction of an edge: their common normal is none [-].
const PARALLEL: f64 = 1e-6;

/// Sine of the angle up to which a line that rises over a face may tilt back onto the edge there before it is looked at again [-].
pub const LEANS: f64 = 0.05;

/// A place nearer to a knot than this share of the cable is left to the knot. Not more: a knot that
/// rests on a face a little beyond an edge leaves its cable to cut into that edge.
pub const AT_KNOT: f64 = 1e-3;

/// Two places of a line nearer than this share of its way are one [-].
pub const SAME_PLACE: f64 = 0.02;

/// At which ends of the two sides across them the four edges along a side are.
pub const EDGE_ENDS: [[f64; 2]; 4] = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];

/// A box around the origin of its frame, along its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Half its sides [m].
    pub half: [f64; 3],
}

/// A straight line in the frame of a box [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSegment {
    /// Where it begins.
    pub from: Vector3<f64>,
    /// From there to its end.
    pub along: Vector3<f64>,
}

/// A place of a line that is above the surface of a box, or below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearPlace {
    /// As a share of the line's way.
    pub share: f64,
    /// Outward normal of the surface there.
    pub normal: Vector3<f64>,
    /// How far above it is; negative below [m].
    pub height: f64,
}

/// What of a box a line is nearest to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum NearFeature {
    /// The face at that end of a side.
    Face { side: usize, end: f64 },
    /// An edge or a corner, at one place of the line.
    Edge(NearPlace),
}

/// The two sides of a box across another: those of a face with its normal along that one, and those that an edge along it is at the ends of.
pub fn sides_across(side: usize) -> [usize; 2] {
    [(side + 1) % 3, (side + 2) % 3]
}

impl LineSegment {
    /// Where it is at a share of its way [m].
    pub fn at(&self, share: f64) -> Vector3<f64> {
        self.from + share * self.along
    }
}

impl Cuboid {
    /// The places at which `line` is within `reach` [m] of it, and whether it comes inside: the two ends of its way over a face or
    /// along an edge; or the one place that is nearest to an edge or a corner, and the next edge that it passes outside.
    pub fn places(&self, line: &LineSegment, reach: f64) -> ([Option<NearPlace>; 2], bool) {
        let nearest = self.above(line, self.nearest_share(line));
        if nearest.height > reach {
            return ([None; 2], false);
        }
        let is_inside = nearest.height < TOUCHING;
        let feature = if is_inside { self.way_out(line) } else { self.feature(nearest) };
        let places = match feature {
            NearFeature::Face { side, end } => self.over_face(line, side, end),
            NearFeature::Edge(place) if is_inside => [Some(place), None],
            NearFeature::Edge(place) => self.along_edge(line, &place, reach),
        };
        (places.map(|place| place.filter(|place| place.height <= reach)), is_inside)
    }

    /// The place outside at a share of a line's way.
    fn above(&self, line: &LineSegment, share: f64) -> NearPlace {
        let at = line.at(share);
        let away = Vector3::from_fn(|side, _| at[side] - at[side].clamp(-self.half[side], self.half[side]));
        let height = away.norm();
        NearPlace { share, normal: away / height, height }
    }

    /// The share of its way at which a line is nearest.
    fn nearest_share(&self, line: &LineSegment) -> f64 {
        // Of half the square of the distance.
        let slope = |share: f64| {
            let at = line.at(share);
            let of_side = |side: usize| {
                line.along[side] * (at[side] - at[side].clamp(-self.half[side], self.half[side]))
            };
            of_side(0) + of_side(1) + of_side(2)
        };
        let [mut low, mut high] = [0.0, 1.0].map(|share| (share, slope(share)));
        if low.1 >= 0.0 {
            return low.0;
        }
        if high.1 <= 0.0 {
            return high.0;
        }
        for side in 0..3 {
            for end in [-self.half[side], self.half[side]] {
                let share = (end - line.from[side]) / line.along[side];
                if low.0 < share && share < high.0 {
                    let here = (share, slope(share));
                    if here.1 < 0.0 { low = here } else { high = here }
                }
            }
        }
        low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1)
    }

    /// What the nearest place of a line outside is nearest to. A face, where all of it is behind a plane across the way there.
    fn feature(&self, place: NearPlace) -> NearFeature {
        let side = place.normal.iamax();
        let [one, other] = sides_across(side).map(|other| 2.0 * self.half[other] * place.normal[other].abs());
        if one + other <= FLAT {
            NearFeature::Face { side, end: place.normal[side].signum() }
        } else {
            NearFeature::Edge(place)
        }
    }

    /// The ends of a line's way along the edge that it is nearest to, where it is as near there as at its nearest `place`; else
    /// that, and the next edge within `reach` [m].
    fn along_edge(&self, line: &LineSegment, place: &NearPlace, reach: f64) -> [Option<NearPlace>; 2] {
        let edge = place.normal.iamin();
        let [enters, leaves] = self.crosses(line, edge);
        let both = [enters.max(0.0), leaves.min(1.0)].map(|share| self.above(line, share));
        let is_along =
            both[0].share < both[1].share && both.iter().all(|end| end.height <= place.height + FLAT);
        if is_along { both.map(Some) } else { [Some(*place), self.next_edge(line, place, reach)] }
    }

    /// The lowest place of a line outside, within `reach` [m], above another edge than that of its `nearest` place: a line that hardly
    /// tilts over a face, or passes a corner, meets that one next, before its nearest place is another.
    fn next_edge(&self, line: &LineSegment, nearest: &NearPlace, reach: f64) -> Option<NearPlace> {
        let mut next: Option<NearPlace> = None;
        self.each_edge_near(line, reach, |edge, ends| {
            if let Some(place) = self.above_edge(line, edge, ends, 0.0)
                && (place.share - nearest.share).abs() > SAME_PLACE
                && next.is_none_or(|next| place.height < next.height)
            {
                next = Some(place);
            }
        });
        next
    }

    /// Above which edges a `line` that does not yet pass them is lowest, before its beginning, along it and behind its end: those that it would
    /// pass were it longer by `reach` [m] at both, or turned as far as an end moves by that. A knot may swing round them, and take the line across
    /// within a step. The share is below 0 before the beginning, and above 1 behind the end; just within both the line's end has the place.
    pub fn edges_ahead(&self, line: &LineSegment, reach: f64) -> [Option<NearPlace>; 3] {
        let more = reach / line.along.norm();
        let longer = LineSegment { from: line.at(-more), along: (1.0 + 2.0 * more) * line.along };
        let mut lowest: [Option<NearPlace>; 3] = [None; 3];
        self.each_edge_near(&longer, reach, |edge, ends| {
            let Some(place) = self.above_edge(&longer, edge, ends, reach) else { return };
            let place = NearPlace { share: (1.0 + 2.0 * more) * place.share - more, ..place };
            let where_to = match place.share {
                share if share < AT_KNOT => 0,
                share if share <= 1.0 - AT_KNOT => 1,
                _ => 2,
            };
            let is_ahead = where_to != 1 || self.above_edge(line, edge, ends, 0.0).is_none();
            let lowest = &mut lowest[where_to];
            if is_ahead && place.height <= reach && lowest.is_none_or(|lowest| place.height < lowest.height) {
                *lowest = Some(place);
            }
        });
        lowest
    }

    /// Calls for each edge that a line may be within `reach` [m] of: the side it is along, and its ends of the sides across that.
    fn each_edge_near(&self, line: &LineSegment, reach: f64, mut act: impl FnMut(usize, [f64; 2])) {
        let to = line.at(1.0);
        // Most edges are beside all of the line.
        let is_near = |side: usize, end: f64| {
            let (face, begin, to) = (end * self.half[side], line.from[side], to[side]);
            begin.min(to) <= face + reach && face - reach <= begin.max(to)
        };
        for edge in 0..3 {
            let [one, other] = sides_across(edge);
            for ends in EDGE_ENDS {
                if is_near(one, ends[0]) && is_near(other, ends[1]) {
                    act(edge, ends);
                }
            }
        }
    }

    /// The place of a line outside above the edge along a side, at these `ends` of the sides across it: where the line is nearest to
    /// it, or where it leaves a face that it hardly tilts over, or over which it goes by no more than a `rise` [m]. None beyond the ends of either.
    fn above_edge(&self, line: &LineSegment, edge: usize, ends: [f64; 2], rise: f64) -> Option<NearPlace> {
        let sides = sides_across(edge);
        let across = line.along.cross(&Vector3::ith(edge, 1.0));
        let square = across.try_normalize(PARALLEL * line.along.norm())?;
        let outwards = [0, 1].map(|of| ends[of] * square[sides[of]]);
        let face = usize::from(outwards[1].abs() > outwards[0].abs());
        let tilt = outwards[1 - face] * outwards[face].signum();
        let place = if tilt > 0.0 {
            let normal = outwards[face].signum() * square;
            let height = normal.dot(&line.from) - self.support(&normal);
            NearPlace { share: self.share_at_edge(line, edge, &normal, -height), normal, height }
        } else if tilt > -LEANS.max(rise / across.norm()) {
            let [upper, across] = [sides[face], sides[1 - face]];
            let share = (ends[1 - face] * self.half[across] - line.from[across]) / line.along[across];
            let height = ends[face] * line.at(share)[upper] - self.half[upper];
            NearPlace { share, normal: Vector3::ith(upper, ends[face]), height }
        } else {
            return None;
        };
        let is_there = (0.0..=1.0).contains(&place.share)
            && place.height > TOUCHING
            && (line.at(place.share) - place.height * place.normal)[edge].abs() <= self.half[edge];
        is_there.then_some(place)
    }

    /// The shortest way out of it of a line inside: along a normal of a face, or of an edge and the line.
    fn way_out(&self, line: &LineSegment) -> NearFeature {
        let to = line.at(1.0);
        let mut least = f64::INFINITY;
        let mut out = NearFeature::Face { side: 0, end: 1.0 };
        for side in 0..3 {
            let (lowest, highest) = (line.from[side].min(to[side]), line.from[side].max(to[side]));
            for (end, depth) in [(1.0, self.half[side] - lowest), (-1.0, self.half[side] + highest)] {
                if depth < least {
                    (least, out) = (depth, NearFeature::Face { side, end });
                }
            }
        }
        for edge in 0..3 {
            let across = line.along.cross(&Vector3::ith(edge, 1.0));
            let length = across.norm();
            if length <= PARALLEL * line.along.norm() {
                continue;
            }
            let across = across / length;
            let (out_there, from) = (self.support(&across), across.dot(&line.from));
            for (normal, depth) in [(across, out_there - from), (-across, out_there + from)] {
                if depth < least {
                    let share = self.share_at_edge(line, edge, &normal, depth);
                    (least, out) = (depth, NearFeature::Edge(NearPlace { share, normal, height: -depth }));
                }
            }
        }
        out
    }

    /// How far it reaches in a direction [m].
    fn support(&self, direction: &Vector3<f64>) -> f64 {
        (0..3).map(|side| self.half[side] * direction[side].abs()).sum()
    }

    /// The share of its way at which a line, moved out by `depth` along `normal`, crosses the edge along a side that is there.
    fn share_at_edge(&self, line: &LineSegment, edge: usize, normal: &Vector3<f64>, depth: f64) -> f64 {
        let [one, other] = sides_across(edge);
        let side = if line.along[one].abs() > line.along[other].abs() { one } else { other };
        let corner = self.half[side].copysign(normal[side]);
        (corner - depth * normal[side] - line.from[side]) / line.along[side]
    }

    /// From which share to which of its way a line is over or below the faces across a side; none where it is beside them.
    pub fn way_over(&self, line: &LineSegment, face: usize) -> Option<[f64; 2]> {
        let [mut first, mut last] = [0.0_f64, 1.0_f64];
        for side in sides_across(face) {
            if line.along[side] != 0.0 {
                let [enters, leaves] = self.crosses(line, side);
                first = first.max(enters);
                last = last.min(leaves);
            } else if line.from[side].abs() > self.half[side] {
                return None;
            }
        }
        (first <= last).then_some([first, last])
    }

    /// At which shares of its way a line enters and leaves what is between the two faces across a side.
    fn crosses(&self, line: &LineSegment, side: usize) -> [f64; 2] {
        let [one, other] =
            [-self.half[side], self.half[side]].map(|end| (end - line.from[side]) / line.along[side]);
        [one.min(other), one.max(other)]
    }

    /// The ends of a line's way over or below a face; none where it is beside it.
    fn over_face(&self, line: &LineSegment, face: usize, end: f64) -> [Option<NearPlace>; 2] {
        let place = |share: f64| {
            let height = end * line.at(share)[face] - self.half[face];
            NearPlace { share, normal: Vector3::ith(face, end), height }
        };
        self.way_over(line, face).map_or([None; 2], |ends| ends.map(|share| Some(place(share))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::halton;
    use nalgebra::vector;
    use parry3d::math::{Pose, Vector as ParryVector};
    use parry3d::query;
    use parry3d::shape::{Cuboid as ParryCuboid, Segment};

    const HALF: [f64; 3] = [0.05, 0.15, 0.02];

    fn lines() -> impl Iterator<Item = LineSegment> {
        let spread = |index| 0.6 * (halton(index) - Vector3::repeat(0.5));
        (0..4000).map(move |index| {
            let from = spread(index);
            LineSegment { from, along: 0.8 * spread(7 * index + 3) - from }
        })
    }

    /// As far away as the engine finds by another way, and what is found lies on the surface.
    #[test]
    fn lines_outside_are_as_near_as_the_engine_finds() {
        let (cuboid, solid, here) = (Cuboid { half: HALF }, ParryCuboid::new(HALF.into()), Pose::IDENTITY);
        let mut n_outside = 0;
        for line in lines() {
            let [from, to] =
                [0.0, 1.0].map(|share| line.at(share)).map(|at| ParryVector::new(at.x, at.y, at.z));
            let (places, is_inside) = cuboid.places(&line, 1.0);
            if is_inside {
                continue;
            }
            n_outside += 1;
            let distance = query::distance(&here, &solid, &here, &Segment::new(from, to)).unwrap().distance;
            let nearest = cuboid.above(&line, cuboid.nearest_share(&line)).height;
            assert!((nearest - distance).abs() < 1e-6, "{line:?} {nearest} {distance}");
            for NearPlace { share, normal, height } in places.into_iter().flatten() {
                let foot = line.at(share) - height * normal;
                let beyond = (0..3).map(|side| foot[side].abs() - HALF[side]).fold(f64::MIN, f64::max);
                assert!(beyond.abs() < 1e-9 && (0.0..=1.0).contains(&share), "{line:?} {foot}");
                assert!((normal.norm() - 1.0).abs() < 1e-9 && height >= nearest - 1e-9, "{line:?}");
            }
        }
        assert!(n_outside > 1000, "{n_outside}");
    }

    /// A line over a face that tilts a little to either side is near both edges, whichever is the nearer; beyond a corner, the edges on
    /// both sides of it. All of the box is behind the planes of such places.
    #[test]
    fn a_line_that_may_tilt_is_near_the_next_edge_too() {
        let cuboid = Cuboid { half: HALF };
        for tilt in [-0.04, -1e-3, 1e-3, 0.04] {
            for turn in [0.0, 0.3] {
                let along = vector![0.14, 0.14 * turn, 0.14 * tilt];
                let line = LineSegment { from: vector![0.0, 0.02, HALF[2] + 3e-3] - 0.5 * along, along };
                let shares = cuboid.places(&line, 1e-2).0.map(|place| place.unwrap().share);
                let low = shares[0].min(shares[1]);
                assert!((low - 0.5 + 0.05 / 0.14).abs() < 2e-3, "{tilt} {turn}: {shares:?}");
                assert!((shares[0] + shares[1] - 1.0).abs() < 2e-3, "{tilt} {turn}: {shares:?}");
            }
        }
        let steep = LineSegment { from: vector![-0.1, 0.0, 0.021], along: vector![0.2, 0.0, 0.02] };
        assert_eq!(cuboid.places(&steep, 1.0).0.iter().flatten().count(), 1);
        let mut n_next = 0;
        for line in lines() {
            let ([first, next], is_inside) = cuboid.places(&line, 1.0);
            let (Some(first), Some(next)) = (first, next) else { continue };
            if is_inside || first.height > next.height {
                continue;
            }
            n_next += 1;
            let foot = line.at(next.share) - next.height * next.normal;
            assert!(cuboid.support(&next.normal) - next.normal.dot(&foot) < 1e-9, "{line:?} {next:?}");
        }
        assert!(n_next > 100, "{n_next}");
    }

    /// A line over a face that ends before the edge, or just beyond it beside the other face, would meet it were it longer, and one that
    /// rises over the edge were it turned; one that is long enough and flat does not wait for it. The box is behind the planes there.
    #[test]
    fn a_line_that_ends_before_an_edge_waits_for_it() {
        let cuboid = Cuboid { half: HALF };
        let along = vector![0.07, 0.01, -1e-3];
        for (short_by, waits) in [(2e-3, true), (4e-3, false), (-1e-3, false)] {
            let to = vector![HALF[0] - short_by, 0.0, HALF[2] + 1e-3];
            let ahead = cuboid.edges_ahead(&LineSegment { from: to - along, along }, 3e-3);
            assert!(ahead[..2] == [None; 2] && ahead[2].is_some() == waits, "{short_by}: {ahead:?}");
            let turned = cuboid.edges_ahead(&LineSegment { from: to, along: -along }, 3e-3);
            assert_eq!(turned[0].map(|place| place.share < 0.0), ahead[2].map(|place| place.share > 1.0));
        }
        // Rising, by 3 and by 14 degrees, and across within its length.
        for (rise, reach, waits) in [(4e-3, 5e-3, true), (4e-3, 2e-3, false), (18e-3, 10e-3, false)] {
            let from = vector![HALF[0] - 0.065, 0.0, HALF[2] + 1e-4];
            let line = LineSegment { from, along: vector![0.07, 0.01, rise] };
            let ahead = cuboid.edges_ahead(&line, reach);
            assert!(ahead[1].is_some() == waits, "{rise} {reach}: {ahead:?}");
        }
        let mut n_waiting = 0;
        for line in lines() {
            for (where_to, place) in cuboid.edges_ahead(&line, 0.1).into_iter().enumerate() {
                let Some(place) = place else { continue };
                n_waiting += 1;
                let foot = line.at(place.share) - place.height * place.normal;
                assert!(cuboid.support(&place.normal) - place.normal.dot(&foot) < 1e-9, "{line:?} {place:?}");
                let (share, first, last) = (place.share, AT_KNOT, 1.0 - AT_KNOT);
                let is_there = [share < first, (first..=last).contains(&share), share > last];
                assert!(is_there[where_to] && (0.0..=0.1).contains(&place.height), "{place:?}");
            }
        }
        assert!(n_waiting > 100, "{n_waiting}");
    }

    /// Moved out so far a line touches, and in no direction less would do. (The engine's penetration is none such for some lines: 7.6 mm
    /// along the normal of an edge on the other side, for 24.9 mm.)
    #[test]
    fn the_way_out_is_the_shortest() {
        let cuboid = Cuboid { half: HALF };
        let directions: Vec<_> = (0..2000)
            .filter_map(|index| (halton(index) - Vector3::repeat(0.5)).try_normalize(1e-3))
            .collect();
        let [mut n_faces, mut n_edges] = [0; 2];
        for line in lines().filter(|line| cuboid.places(line, 0.0).1) {
            let depth_along = |normal: &Vector3<f64>| {
                cuboid.support(normal) - normal.dot(&line.from).min(normal.dot(&line.at(1.0)))
            };
            let (normal, depth) = match cuboid.way_out(&line) {
                NearFeature::Face { side, end } => {
                    n_faces += 1;
                    let normal = Vector3::ith(side, end);
                    (normal, depth_along(&normal))
                }
                NearFeature::Edge(place) => {
                    n_edges += 1;
                    let foot = line.at(place.share) - place.height * place.normal;
                    let at_ends = (0..3).filter(|side| (foot[*side].abs() - HALF[*side]).abs() < 1e-9);
                    assert!(at_ends.count() >= 2, "{line:?} {place:?} {foot}");
                    (place.normal, -place.height)
                }
            };
            assert!((depth_along(&normal) - depth).abs() < 1e-9, "{line:?} {normal} {depth}");
            assert!(
                directions.iter().all(|other| depth_along(other) > depth - 1e-9),
                "{line:?} {normal} {depth}"
            );
        }
        assert!(n_faces > 50 && n_edges > 50, "{n_faces} {n_edges}");
    }

    fn found(from: Vector3<f64>, to: Vector3<f64>, reach: f64) -> Vec<NearPlace> {
        let (places, _) = Cuboid { half: HALF }.places(&LineSegment { from, along: to - from }, reach);
        places.into_iter().flatten().collect()
    }

    fn assert_places(found: &[NearPlace], expected: &[(f64, Vector3<f64>, f64)]) {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (place, (share, normal, height)) in found.iter().zip(expected) {
            let is_that = (place.share - share).abs() < 1e-9
                && (place.normal - normal).norm() < 1e-9
                && (place.height - height).abs() < 1e-9;
            assert!(is_that, "{place:?} for {share} {normal} {height}");
        }
    }

    /// A line that lies over a face, along an edge, or across one; and what is out of reach.
    #[test]
    fn faces_and_edges_along_a_line_have_two_places_and_others_one() {
        let z = Vector3::z();
        // Over the face and beyond both of its edges.
        let over = found(vector![-0.1, 0.0, 0.021], vector![0.1, 0.0, 0.021], 2e-3);
        assert_places(&over, &[(0.25, z, 1e-3), (0.75, z, 1e-3)]);
        // Below it: as deep, and still out through it.
        let below = found(vector![-0.1, 0.0, 0.019], vector![0.1, 0.0, 0.019], 2e-3);
        assert_places(&below, &[(0.25, z, -1e-3), (0.75, z, -1e-3)]);
        // Along an edge, diagonally above it, and beyond one end.
        let diagonal = vector![1.0, 0.0, 1.0].normalize();
        let from = vector![0.05, 0.0, 0.02] + 1e-3 * diagonal;
        let along = found(from, from + vector![0.0, 0.3, 0.0], 2e-3);
        assert_places(&along, &[(0.0, diagonal, 1e-3), (0.5, diagonal, 1e-3)]);
        // Across it.
        let across = vector![1.0, 0.5, -1.0];
        let normal = across.cross(&Vector3::y()).normalize();
        let middle = vector![0.05, 0.0, 0.02] + 1e-3 * normal;
        let crossing = found(middle - 0.02 * across, middle + 0.02 * across, 2e-3);
        assert_places(&crossing, &[(0.5, normal, 1e-3)]);
        // Rising from a face: its far end is out of reach.
        let rising = found(vector![0.0, 0.0, 0.021], vector![0.04, 0.0, 0.04], 2e-3);
        assert_places(&rising, &[(0.0, z, 1e-3)]);
        assert_places(&found(vector![-0.1, 0.0, 0.023], vector![0.1, 0.0, 0.023], 2e-3), &[]);
    }
}
