//! What a viewer far away sees of net, target and other bodies at one time: faces from back to front, and the parts of lines that no
//! face hides.
//!
//! Faces are sorted by the distance of their middles (the painter's way); those of several parts are cut small first, so that
//! the order of middles is that of faces. A line is cut into pieces, and a piece is seen if no face lies
//! between its middle and the viewer.

use std::collections::BTreeMap;

use nalgebra::{UnitQuaternion, Vector3};

use crate::report::recorded::{RecordedBody, RecordedRun};

/// A direction to look from, far away: what is seen is as large as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// How it is called.
    pub name: &'static str,
    /// About Z, from X on [deg].
    yaw: f64,
    /// Above the plane of X and Y [deg].
    pitch: f64,
}

/// The views, as the replay has them.
const VIEWS: [View; 4] = [
    View { name: "side", yaw: -90.0, pitch: 0.0 },
    View { name: "front", yaw: 0.0, pitch: 0.0 },
    View { name: "top", yaw: -90.0, pitch: 90.0 },
    View { name: "oblique", yaw: -64.0, pitch: 20.0 },
];

impl View {
    /// The view called `name`.
    pub fn named(name: &str) -> Option<View> {
        VIEWS.into_iter().find(|view| view.name == name)
    }

    /// How the views are called.
    pub fn names() -> impl Iterator<Item = &'static str> + Clone {
        VIEWS.iter().map(|view| view.name)
    }

    /// To the right, up, and towards the viewer.
    fn basis(&self) -> [Vector3<f64>; 3] {
        let (sin_yaw, cos_yaw) = self.yaw.to_radians().sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.to_radians().sin_cos();
        [
            Vector3::new(-sin_yaw, cos_yaw, 0.0),
            Vector3::new(-sin_pitch * cos_yaw, -sin_pitch * sin_yaw, cos_pitch),
            Vector3::new(cos_pitch * cos_yaw, cos_pitch * sin_yaw, sin_pitch),
        ]
    }

    /// `point` as seen: to the right, up, towards the viewer [m].
    fn project(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let basis = self.basis();
        Vector3::new(basis[0].dot(point), basis[1].dot(point), basis[2].dot(point))
    }
}

/// What a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeenLine {
    /// An edge of the target, or of a body that an effect brought.
    BodyEdge,
    /// A cable.
    Cable,
    /// A cable of the net's edge.
    NetEdge,
    /// A closing thread.
    Thread,
}

/// Part of a line that is seen, to the right and up [m].
#[derive(Clone, Debug)]
pub struct SeenStroke {
    /// What it is.
    pub line: SeenLine,
    /// Its ends.
    pub ends: [[f64; 2]; 2],
    /// How near it is: 0 the farthest of the net, 1 the nearest.
    pub near: f64,
}

/// A face of the target, or of a body that an effect brought.
#[derive(Clone, Debug)]
pub struct SeenFace {
    /// Its corners, to the right and up [m].
    pub corners: [[f64; 2]; 3],
    /// How bright it is, from 0 to 1.
    pub light: f64,
}

/// Net, target and other bodies as seen.
#[derive(Clone, Debug, Default)]
pub struct SeenPicture {
    /// Faces, from back to front.
    pub faces: Vec<SeenFace>,
    /// What is seen of lines.
    pub strokes: Vec<SeenStroke>,
    /// Bullets that are seen.
    pub bullets: Vec<[f64; 2]>,
    /// Lowest and highest of what is in the picture, to the right and up [m].
    pub bounds: [[f64; 2]; 2],
}

/// Pieces that a line is cut into.
const PIECES: usize = 6;

/// Sides of the small faces of several parts, over the size of the smallest body.
const SMALL: f64 = 0.1;

/// A body is in the picture while the gap to it is no larger than this, over the size of the larger of net and body.
const GAP: f64 = 0.5;

/// Angle between faces from which the edge between them is drawn, as a cosine: 30 deg.
const STEEP: f64 = 0.866;

/// A face in the frame of the view, with its outward normal.
struct HullFace {
    corners: [Vector3<f64>; 3],
    normal: Vector3<f64>,
}

impl SeenPicture {
    /// What is seen of `run` at `time` [s] from `view`.
    pub fn of(run: &RecordedRun, time: f64, view: View) -> SeenPicture {
        let knots: Vec<Vector3<f64>> = (0..run.paths.names.n_knots)
            .map(|knot| view.project(&run.paths.at(knot, time).position))
            .collect();
        let net = bounds(&knots);
        let (mut faces, mut all, mut size) = (Vec::new(), net.to_vec(), f64::INFINITY);
        for body in run.target.iter().chain(&run.brought) {
            let of_body = faces_of(run, body, time, view);
            let corners: Vec<Vector3<f64>> = of_body.iter().flat_map(|face| face.corners).collect();
            let [low, high] = bounds(&corners);
            if !corners.is_empty() && near(&net, &[low, high]) {
                all.extend([low, high]);
                size = size.min((high - low).norm());
                faces.extend(of_body);
            }
        }
        let box_of_all = bounds(&all);
        let mut seen =
            SeenPicture { bounds: box_of_all.map(|corner| flat(&corner)), ..SeenPicture::default() };
        let facing: Vec<&HullFace> = faces.iter().filter(|face| face.normal.z > 1e-9).collect();
        let cover = Cover::of(&facing);
        let depths = [net[0].z, net[1].z];
        let mut draw = |line: SeenLine, ends: [Vector3<f64>; 2], lift: f64| {
            seen.strokes.extend(cover.strokes(line, ends, lift, depths));
        };
        for ends in edges(&faces) {
            draw(SeenLine::BodyEdge, ends, 1e-3 * size);
        }
        // Cables between knots on the surface cut through its corners: they are seen from a little further out.
        let mut lengths = run.net.rest_lengths.clone();
        lengths.sort_by(f64::total_cmp);
        let lift = 0.08 * lengths.get(lengths.len() / 2).copied().unwrap_or(0.0);
        let mut on_edge = vec![false; knots.len()];
        run.net.edge.iter().for_each(|&knot| on_edge[knot] = true);
        for &[a, b] in &run.net.cables {
            let line = if on_edge[a] && on_edge[b] { SeenLine::NetEdge } else { SeenLine::Cable };
            draw(line, [knots[a], knots[b]], lift);
        }
        for pair in run.net.threads.iter().flat_map(|way| way.windows(2)) {
            let ends = match *pair {
                [Some(a), Some(b)] => [knots[a], knots[b]],
                // A tether is seen as far as the picture goes.
                [Some(knot), None] | [None, Some(knot)] => {
                    within(knots[knot], view.project(&port(run, time)), &box_of_all)
                }
                _ => continue,
            };
            draw(SeenLine::Thread, ends, 1.4 * lift);
        }
        let is_seen = |bullet: &&usize| !cover.hides(&knots[**bullet], 2.0 * lift);
        seen.bullets = run.net.bullets.iter().filter(is_seen).map(|&bullet| flat(&knots[bullet])).collect();
        seen.faces = painted(&facing, &cover, SMALL * size);
        seen
    }
}

fn flat(point: &Vector3<f64>) -> [f64; 2] {
    [point.x, point.y]
}

/// Lowest and highest coordinates.
fn bounds(points: &[Vector3<f64>]) -> [Vector3<f64>; 2] {
    let first = points.first().copied().unwrap_or_default();
    points.iter().fold([first, first], |[low, high], point| [low.inf(point), high.sup(point)])
}

/// Whether two boxes are near each other.
fn near(one: &[Vector3<f64>; 2], other: &[Vector3<f64>; 2]) -> bool {
    let gap = (one[0] - other[1]).sup(&(other[0] - one[1])).sup(&Vector3::zeros()).norm();
    let size = (one[1] - one[0]).norm().max((other[1] - other[0]).norm());
    gap <= GAP * size
}

/// The line from a point in a box towards another, as far as it is within the box to the right and up.
fn within(from: Vector3<f64>, to: Vector3<f64>, [low, high]: &[Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    let share = |axis: usize| {
        let way = to[axis] - from[axis];
        let room = if way < 0.0 { low[axis] - from[axis] } else { high[axis] - from[axis] };
        if way == 0.0 { 1.0 } else { (room / way).clamp(0.0, 1.0) }
    };
    [from, from.lerp(&to, share(0).min(share(1)))]
}

/// Where threads end outside the net at `time` [s].
fn port(run: &RecordedRun, time: f64) -> Vector3<f64> {
    let (after, share) = between(run, time);
    match &run.ports[..] {
        [] => Vector3::zeros(),
        [only] => *only,
        ports => ports[after - 1].lerp(&ports[after], share),
    }
}

/// All faces of `body` at `time` [s].
fn faces_of(run: &RecordedRun, body: &RecordedBody, time: f64, view: View) -> Vec<HullFace> {
    let (at, turn) = pose(run, body, time);
    let points: Vec<Vector3<f64>> =
        body.points.iter().map(|point| view.project(&(at + turn * point))).collect();
    let face = |corners: &[usize; 3]| {
        let corners = corners.map(|corner| points[corner]);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let length = normal.norm();
        (length > 0.0).then(|| HullFace { corners, normal: normal / length })
    };
    body.triangles.iter().filter_map(face).collect()
}

/// The frame after `time` [s], and how far it is from the one before, from 0 to 1.
fn between(run: &RecordedRun, time: f64) -> (usize, f64) {
    let times = &run.paths.time;
    let after = times.partition_point(|&t| t <= time).clamp(1, times.len().max(2) - 1);
    let Some(next) = times.get(after) else { return (after, 0.0) };
    (after, ((time - times[after - 1]) / (next - times[after - 1])).clamp(0.0, 1.0))
}

/// Where `body` is at `time` [s], and how it is turned, between two frames.
fn pose(run: &RecordedRun, body: &RecordedBody, time: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let (after, share) = between(run, time);
    if body.position.len() < 2 {
        return (body.position[0], body.attitude[0]);
    }
    let [from, to] = [body.attitude[after - 1], body.attitude[after]];
    let turn = from.try_slerp(&to, share, 1e-9).unwrap_or(to);
    (body.position[after - 1].lerp(&body.position[after], share), turn)
}

/// A side of a face: the number of the face, and its ends.
type FaceSide = (usize, [Vector3<f64>; 2]);

/// Edges between steep faces, with a side that is turned to the viewer.
fn edges(faces: &[HullFace]) -> Vec<[Vector3<f64>; 2]> {
    let key = |point: &Vector3<f64>| [point.x, point.y, point.z].map(f64::to_bits);
    let mut sides: BTreeMap<[[u64; 3]; 2], Vec<FaceSide>> = BTreeMap::new();
    for (number, face) in faces.iter().enumerate() {
        for side in 0..3 {
            let ends = [face.corners[side], face.corners[(side + 1) % 3]];
            let [a, b] = [key(&ends[0]), key(&ends[1])];
            sides.entry(if a < b { [a, b] } else { [b, a] }).or_default().push((number, ends));
        }
    }
    let is_drawn = |sides: &[FaceSide]| {
        let normals = sides.iter().map(|(number, _)| faces[*number].normal);
        let steep = sides.len() < 2 || faces[sides[0].0].normal.dot(&faces[sides[1].0].normal) < STEEP;
        steep && normals.into_iter().any(|normal| normal.z > 0.0)
    };
    sides.values().filter(|sides| is_drawn(sides)).map(|sides| sides[0].1).collect()
}

/// The faces turned to the viewer, which hide what is behind them.
struct Cover<'a> {
    faces: Vec<(&'a HullFace, [[f64; 2]; 2])>,
}

impl<'a> Cover<'a> {
    fn of(faces: &[&'a HullFace]) -> Cover<'a> {
        let boxed = |face: &&'a HullFace| {
            let [low, high] = bounds(&face.corners);
            (*face, [flat(&low), flat(&high)])
        };
        Cover { faces: faces.iter().map(boxed).collect() }
    }

    /// Whether a face lies more than `lift` [m] before `point`.
    fn hides(&self, point: &Vector3<f64>, lift: f64) -> bool {
        self.faces.iter().any(|(face, [low, high])| {
            let within = (low[0]..=high[0]).contains(&point.x) && (low[1]..=high[1]).contains(&point.y);
            within && depth_at(face, point).is_some_and(|depth| depth > point.z + lift)
        })
    }

    /// The pieces of a line that are seen, neighbours as one.
    fn strokes(
        &self,
        line: SeenLine,
        ends: [Vector3<f64>; 2],
        lift: f64,
        depths: [f64; 2],
    ) -> Vec<SeenStroke> {
        let at = |piece: f64| ends[0].lerp(&ends[1], piece / PIECES as f64);
        let mut strokes: Vec<(usize, usize)> = Vec::new();
        for piece in (0..PIECES).filter(|&piece| !self.hides(&at(piece as f64 + 0.5), lift)) {
            match strokes.last_mut() {
                Some((_, end)) if *end == piece => *end += 1,
                _ => strokes.push((piece, piece + 1)),
            }
        }
        let depth = 0.5 * (ends[0].z + ends[1].z);
        let near = ((depth - depths[0]) / (depths[1] - depths[0]).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let stroke = |(from, to): (usize, usize)| SeenStroke {
            line,
            ends: [from, to].map(|place| flat(&at(place as f64))),
            near,
        };
        strokes.into_iter().map(stroke).collect()
    }
}

/// How near a face is where it covers `point`; none where it does not.
fn depth_at(face: &HullFace, point: &Vector3<f64>) -> Option<f64> {
    let [a, b, c] = &face.corners;
    // SeenPicture from the viewer the corners run counter-clockwise: twice the area, and of the parts opposite each corner.
    let area = |p: &Vector3<f64>, q: &Vector3<f64>, r: &Vector3<f64>| {
        (q.x - p.x) * (r.y - p.y) - (r.x - p.x) * (q.y - p.y)
    };
    let whole = area(a, b, c);
    let shares = [area(point, b, c), area(a, point, c), area(a, b, point)].map(|part| part / whole);
    let inside = whole > 0.0 && shares.iter().all(|share| *share >= 0.0);
    inside.then(|| shares[0] * a.z + shares[1] * b.z + shares[2] * c.z)
}

/// Faces from back to front; those that others hide are left out.
fn painted(facing: &[&HullFace], cover: &Cover, side: f64) -> Vec<SeenFace> {
    // Faces of one convex part never hide each other: small ones are for several.
    let overlap = facing.iter().any(|face| cover.hides(&middle(&face.corners), 1e-3 * side));
    let mut small: Vec<([Vector3<f64>; 3], f64)> = Vec::new();
    for face in facing {
        let light = light(&face.normal);
        cut(face.corners, if overlap { side } else { f64::INFINITY }, &mut |corners| {
            small.push((corners, light))
        });
    }
    small.retain(|(corners, _)| {
        let middle = middle(corners);
        !corners.iter().chain([&middle]).all(|point| cover.hides(&point.lerp(&middle, 0.01), 1e-3 * side))
    });
    small.sort_by(|(one, _), (other, _)| middle(one).z.total_cmp(&middle(other).z));
    let face = |(corners, light): ([Vector3<f64>; 3], f64)| SeenFace {
        corners: corners.each_ref().map(flat),
        light,
    };
    small.into_iter().map(face).collect()
}

fn middle(corners: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (corners[0] + corners[1] + corners[2]) / 3.0
}

/// How bright a face is: light comes from the upper left of the viewer, whatever the view.
fn light(normal: &Vector3<f64>) -> f64 {
    let from = Vector3::new(-0.35, 0.70, 0.62).normalize();
    0.25 + 0.75 * normal.dot(&from).max(0.0)
}

/// Cuts a triangle at the middle of its longest side until no side is longer than `side`.
fn cut(corners: [Vector3<f64>; 3], side: f64, found: &mut impl FnMut([Vector3<f64>; 3])) {
    let [a, b, c] = corners;
    let lengths = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
    let longest = (0..3).fold(0, |best, i| if lengths[i] > lengths[best] { i } else { best });
    if lengths[longest] <= side {
        return found(corners);
    }
    let [from, to, across] = [0, 1, 2].map(|i| corners[(longest + i) % 3]);
    let middle = 0.5 * (from + to);
    cut([from, middle, across], side, found);
    cut([middle, to, across], side, found);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(z: f64) -> HullFace {
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| Vector3::new(x, y, z));
        HullFace { corners, normal: Vector3::z() }
    }

    #[test]
    fn a_line_behind_a_face_is_seen_beside_it_alone() {
        let face = triangle(0.0);
        let cover = Cover::of(&[&face]);
        let strokes = |z: f64| {
            let ends = [Vector3::new(0.2, 0.2, z), Vector3::new(2.0, 0.2, z)];
            cover.strokes(SeenLine::Cable, ends, 0.01, [-1.0, 1.0])
        };
        let before = strokes(0.5);
        assert_eq!(before.len(), 1);
        assert_eq!(before[0].ends, [[0.2, 0.2], [2.0, 0.2]]);
        let behind = strokes(-0.5);
        assert_eq!(behind.len(), 1);
        assert!((behind[0].ends[0][0] - 0.8).abs() < 1e-12, "hidden up to the face's side: {behind:?}");
        // On the face, as an edge of it is: seen.
        assert_eq!(strokes(0.0)[0].ends, [[0.2, 0.2], [2.0, 0.2]]);
    }

    #[test]
    fn a_tether_ends_at_the_side_of_the_picture() {
        let frame = [Vector3::new(-1.0, -1.0, -1.0), Vector3::new(1.0, 1.0, 1.0)];
        let ends = |to: [f64; 3]| within(Vector3::new(0.5, 0.0, 0.2), to.into(), &frame)[1];
        assert!((ends([-5.5, 2.0, 0.2]) - Vector3::new(-1.0, 0.5, 0.2)).norm() < 1e-12);
        assert_eq!(ends([0.5, 0.9, 7.0]), Vector3::new(0.5, 0.9, 7.0), "depth has no side");
    }

    #[test]
    fn the_side_view_has_x_to_the_right_and_z_up() {
        let seen = View::named("side").unwrap().project(&Vector3::new(1.0, 2.0, 3.0));
        assert!((seen - Vector3::new(1.0, 3.0, -2.0)).norm() < 1e-12, "{seen}");
        let front = View::named("front").unwrap().project(&Vector3::new(1.0, 2.0, 3.0));
        assert!((front - Vector3::new(2.0, 3.0, 1.0)).norm() < 1e-12, "{front}");
    }

    #[test]
    fn small_faces_cover_what_the_large_one_did() {
        let mut area = 0.0;
        let mut n_faces = 0;
        cut(triangle(0.0).corners, 0.2, &mut |[a, b, c]| {
            area += 0.5 * (b - a).cross(&(c - a)).z;
            n_faces += 1;
        });
        assert!((area - 0.5).abs() < 1e-12 && n_faces > 50, "{area} of {n_faces}");
    }
}
