//! The convex hull of a cloud of points.

use nalgebra::Vector3;
use parry3d::query::PointQuery;

use super::growth::{Growth, Lattice, NONE};

/// A point counts as inside the hull up to this share of its box's longest side beyond a face.
const CONTAINS_SLACK: f64 = 1e-9;

/// Convex hull of a cloud of points.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    /// Corners [m]: points of the cloud, unmoved; some may lie within a face or an edge.
    pub vertices: Vec<Vector3<f64>>,
    /// Faces, counter-clockwise seen from outside, as places in `vertices`.
    pub triangles: Vec<[u32; 3]>,
    /// Plane of each triangle.
    pub planes: Vec<Plane>,
    /// Slack of [`Hull::contains`] [m].
    slack: f64,
}

/// A plane of a hull: outside is where normal · p > offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal, outward.
    pub normal: Vector3<f64>,
    /// normal · p of every point p of the plane [m].
    pub offset: f64,
}

impl Plane {
    /// How far outside of it `point` is [m]; negative inside.
    pub fn height(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// Half spaces of some planes of a hull.
#[derive(Clone, Debug)]
pub struct HalfSpaces {
    planes: Vec<Plane>,
    slack: f64,
}

impl HalfSpaces {
    /// Whether `point` is in all of them, with the slack of the hull.
    pub fn contain(&self, point: &Vector3<f64>) -> bool {
        self.planes.iter().all(|plane| plane.normal.dot(point) <= plane.offset + self.slack)
    }
}

impl Hull {
    /// Hull of `points`; `None` where there is none to speak of: fewer than four points, a
    /// coordinate that is not finite, or all points in one plane (to 1.5e-11 of their extent).
    pub fn of(points: &[Vector3<f64>]) -> Option<Hull> {
        let lattice = Lattice::around(points)?;
        let cloud: Vec<[i64; 3]> = points.iter().map(|point| lattice.snap(point)).collect();
        let mut growth = Growth::start(&cloud)?;
        growth.finish();

        let mut place = vec![NONE; points.len()];
        let mut hull = Hull {
            vertices: Vec::new(),
            triangles: Vec::new(),
            planes: Vec::new(),
            slack: CONTAINS_SLACK * lattice.extent,
        };
        for face in growth.faces.iter().filter(|face| face.alive) {
            let corners = face.corners.map(|corner| {
                let corner = corner as usize;
                if place[corner] == NONE {
                    place[corner] = hull.vertices.len() as u32;
                    hull.vertices.push(points[corner]);
                }
                place[corner]
            });
            // The normal from the lattice is right even for a sliver, where one from the rounded
            // points would be noise.
            let normal = Vector3::from(face.normal).normalize();
            hull.triangles.push(corners);
            hull.planes.push(Plane { normal, offset: normal.dot(&points[face.corners[0] as usize]) });
        }
        Some(hull)
    }

    /// Volume [m^3].
    ///
    /// V = 1/6 Σ a · (b × c) over the faces, corners relative to one point of the hull.
    pub fn volume(&self) -> f64 {
        let origin = self.vertices[0];
        let six_fold: f64 = self
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|corner| self.vertices[corner as usize] - origin);
                a.dot(&b.cross(&c))
            })
            .sum();
        six_fold / 6.0
    }

    /// Surface [m^2].
    pub fn surface(&self) -> f64 {
        let two_fold: f64 = self
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|corner| self.vertices[corner as usize]);
                (b - a).cross(&(c - a)).norm()
            })
            .sum();
        two_fold / 2.0
    }

    /// Least width across a face [m].
    pub fn thickness(&self) -> f64 {
        let mut walk = Walk::new(self);
        let width = |plane: &Plane| plane.offset - walk.lowest(&plane.normal);
        self.planes.iter().map(width).fold(f64::MAX, f64::min)
    }

    /// The half spaces that tell which points of a ball are inside, those that do not hold all of it; `None` where one
    /// holds nothing of it.
    pub fn cutting(&self, centre: &Vector3<f64>, radius: f64) -> Option<HalfSpaces> {
        if self.planes.iter().any(|plane| plane.height(centre) > radius + 2.0 * self.slack) {
            return None;
        }
        let planes = self.planes.iter().filter(|plane| plane.height(centre) > -radius).copied().collect();
        Some(HalfSpaces { planes, slack: self.slack })
    }

    /// Whether `point` is inside, a slack of 1e-9 of the box's longest side included.
    pub fn contains(&self, point: &Vector3<f64>) -> bool {
        self.planes.iter().all(|plane| plane.normal.dot(point) <= plane.offset + self.slack)
    }

    /// Whether all of the line between two points is outside of one face, and by more than the slack.
    pub fn has_face_below(&self, ends: [&Vector3<f64>; 2]) -> bool {
        let is_below =
            |plane: &Plane| ends.iter().all(|end| plane.normal.dot(end) > plane.offset + self.slack);
        self.planes.iter().any(is_below)
    }

    /// How far outside of the face `point` is that it is farthest from [m]: at most its distance, and negative inside.
    pub fn farthest_height(&self, point: &Vector3<f64>) -> f64 {
        self.planes.iter().map(|plane| plane.height(point)).fold(f64::MIN, f64::max)
    }

    /// How deep `point` is inside: the distance to the surface, negative outside [m].
    pub fn depth(&self, point: &Vector3<f64>) -> f64 {
        let inside = -self.farthest_height(point);
        if inside >= 0.0 {
            return inside;
        }
        // Near an edge the surface is farther than the planes that meet there.
        let corner = |i: u32| {
            let vertex = &self.vertices[i as usize];
            parry3d::math::Vector::new(vertex.x, vertex.y, vertex.z)
        };
        let distance = |&[a, b, c]: &[u32; 3]| {
            let triangle = parry3d::shape::Triangle::new(corner(a), corner(b), corner(c));
            triangle.distance_to_local_point(parry3d::math::Vector::new(point.x, point.y, point.z), true)
        };
        -self.triangles.iter().map(distance).fold(f64::MAX, f64::min)
    }
}

/// Corners up to which all are looked at: a walk is no faster.
const FEW_CORNERS: usize = 256;

/// Finds lowest corners along one direction after another by walking down the edges from the last: a hull is
/// convex, so a corner that has no lower neighbour is the lowest. Looking at all corners of a ball of 100 000
/// for each of its faces took two minutes.
struct Walk<'a> {
    hull: &'a Hull,
    /// Neighbours of corner i: from `first[i]` to `first[i + 1]` in `neighbours`; none for few corners.
    first: Vec<u32>,
    neighbours: Vec<u32>,
    at: u32,
}

impl<'a> Walk<'a> {
    fn new(hull: &'a Hull) -> Walk<'a> {
        let mut walk = Walk { hull, first: Vec::new(), neighbours: Vec::new(), at: 0 };
        if hull.vertices.len() > FEW_CORNERS {
            // Every edge has two faces, which name it once each way.
            let mut edges: Vec<(u32, u32)> =
                hull.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
            edges.sort_unstable();
            let corners = 0..=hull.vertices.len() as u32;
            walk.first = corners.map(|corner| edges.partition_point(|edge| edge.0 < corner) as u32).collect();
            walk.neighbours = edges.into_iter().map(|edge| edge.1).collect();
        }
        walk
    }

    /// Least height of a corner along `direction`.
    fn lowest(&mut self, direction: &Vector3<f64>) -> f64 {
        let height = |corner: u32| direction.dot(&self.hull.vertices[corner as usize]);
        if self.first.is_empty() {
            return self.hull.vertices.iter().map(|v| direction.dot(v)).fold(f64::MAX, f64::min);
        }
        let mut lowest = height(self.at);
        loop {
            let [from, to] = [self.at, self.at + 1].map(|corner| self.first[corner as usize] as usize);
            let before = lowest;
            for &neighbour in &self.neighbours[from..to] {
                let of_neighbour = height(neighbour);
                if of_neighbour < lowest {
                    (self.at, lowest) = (neighbour, of_neighbour);
                }
            }
            if lowest >= before {
                return lowest;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::collections::HashMap;

    fn random_point(rng: &mut ChaCha8Rng) -> Vector3<f64> {
        Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0))
    }

    /// What makes a hull a hull: it holds every point, it is closed and a ball in kind
    /// (V − E + F = 2), its planes face outward, and its volume and surface are numbers.
    fn assert_hull(hull: &Hull, points: &[Vector3<f64>]) {
        for point in points {
            assert!(hull.contains(point), "{point:?} is outside");
        }
        let mut edges = HashMap::new();
        for triangle in &hull.triangles {
            for side in 0..3 {
                *edges.entry((triangle[side], triangle[(side + 1) % 3])).or_insert(0) += 1;
            }
        }
        for (&(from, to), &count) in &edges {
            assert_eq!(count, 1);
            assert!(edges.contains_key(&(to, from)), "an open edge");
        }
        assert_eq!(hull.vertices.len() + hull.triangles.len(), edges.len() / 2 + 2);
        assert!(hull.volume() >= 0.0 && hull.surface() > 0.0);
        for plane in &hull.planes {
            assert!((plane.normal.norm() - 1.0).abs() < 1e-12);
        }
    }

    /// Nodes of a flat square net, `n` to a side, spacing 1, moved by up to `noise` and turned.
    fn net(n: usize, noise: f64, rng: &mut ChaCha8Rng) -> Vec<Vector3<f64>> {
        let turn = nalgebra::UnitQuaternion::from_euler_angles(0.3, -1.1, 2.0);
        let mut points = Vec::new();
        for row in 0..n {
            for column in 0..n {
                let flat = Vector3::new(0.0, row as f64, column as f64);
                points.push(turn * (flat + noise * random_point(rng)));
            }
        }
        points
    }

    #[test]
    fn hull_of_a_cube() {
        let mut points: Vec<Vector3<f64>> = Vec::new();
        for i in 0..27 {
            points.push(Vector3::new((i % 3) as f64, (i / 3 % 3) as f64, (i / 9) as f64));
        }
        let hull = Hull::of(&points).unwrap();
        assert_hull(&hull, &points);
        assert!((hull.volume() - 8.0).abs() < 1e-12);
        assert!((hull.surface() - 24.0).abs() < 1e-12);
        assert!(hull.contains(&Vector3::new(2.0, 1.0, 1.0)), "a face is inside");
        assert!(!hull.contains(&Vector3::new(2.0 + 1e-8, 1.0, 1.0)));
        assert!(!hull.contains(&Vector3::new(f64::NAN, 1.0, 1.0)));
    }

    /// Faces that hold all of a ball, or nothing of it, tell the same of its points as all do; and a line outside of one
    /// face has no point inside.
    #[test]
    fn faces_that_cut_a_ball_tell_what_is_inside() {
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let hull = Hull::of(&(0..40).map(|_| random_point(&mut rng)).collect::<Vec<_>>()).unwrap();
        let (mut none, mut below) = (0, 0);
        for _ in 0..300 {
            let (centre, radius) = (1.5 * random_point(&mut rng), rng.random_range(0.05..0.5));
            let cutting = hull.cutting(&centre, radius);
            none += usize::from(cutting.is_none());
            for _ in 0..10 {
                let point = centre + radius * random_point(&mut rng).normalize();
                assert_eq!(cutting.as_ref().is_some_and(|some| some.contain(&point)), hull.contains(&point));
            }
            let [from, to] = [(); 2].map(|()| 1.5 * random_point(&mut rng));
            if hull.has_face_below([&from, &to]) {
                below += 1;
                assert!((0..=20).all(|i| !hull.contains(&from.lerp(&to, f64::from(i) / 20.0))));
            }
        }
        assert!(none > 20 && below > 20, "{none} {below}");
    }

    #[test]
    fn no_hull_without_volume() {
        let p = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
        let none = |points: &[Vector3<f64>]| assert_eq!(Hull::of(points), None);
        none(&[]);
        none(&[p(0., 0., 0.), p(1., 0., 0.), p(0., 1., 0.)]);
        none(&[p(3., 3., 3.); 50]);
        none(&(0..50).map(|i| p(i as f64, 0.5 * i as f64, 7.0)).collect::<Vec<_>>());
        none(&(0..441).map(|i| p(2.0, (i / 21) as f64, (i % 21) as f64)).collect::<Vec<_>>());
        none(&[p(0., 0., 0.), p(1., 0., 0.), p(0., 1., 0.), p(0., 0., f64::NAN)]);
        none(&[p(0., 0., 0.), p(1., 0., 0.), p(0., f64::INFINITY, 0.), p(0., 0., 1.)]);
        none(&[p(-1e308, 0., 0.), p(1e308, 0., 0.), p(0., 1e308, 0.), p(0., 0., 1e308)]);
    }

    #[test]
    fn extreme_scales_neither_panic_nor_lie() {
        for scale in [1e-320, 1e-300, 1e-12, 1.0, 1e12, 1e100, 1e300] {
            let points: Vec<_> = (0..8)
                .map(|i| scale * Vector3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64))
                .collect();
            if let Some(hull) = Hull::of(&points) {
                let relative = hull.volume() / (scale * scale * scale);
                assert!((relative - 1.0).abs() < 1e-9 || !relative.is_normal(), "{scale}: {relative}");
            }
        }
    }

    #[test]
    fn folded_nets_of_every_thickness() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for n in [2, 3, 11, 21] {
            for exponent in -16..=0 {
                for _ in 0..20 {
                    let noise = 10f64.powi(exponent);
                    let points = net(n, noise, &mut rng);
                    let Some(hull) = Hull::of(&points) else {
                        assert!(noise < 1e-10 * n as f64, "noise {noise} taken for flat");
                        continue;
                    };
                    assert_hull(&hull, &points);
                    assert!(hull.volume() < 2.5 * noise * (n * n) as f64 + 30.0 * noise * noise + 1e-9);
                }
            }
        }
    }

    #[test]
    fn grids_duplicates_and_lines_in_a_cloud() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for round in 0..300 {
            let mut points: Vec<_> =
                (0..40).map(|_| random_point(&mut rng).map(|x| (x * 3.0).round() / 3.0)).collect();
            points.extend_from_within(0..20);
            points.extend((0..20).map(|i| Vector3::new(i as f64 * 0.1 - 1.0, 0.3, 0.3)));
            if round % 2 == 0 {
                points.iter_mut().for_each(|point| *point += 1e-13 * random_point(&mut rng));
            }
            assert_hull(&Hull::of(&points).unwrap(), &points);
        }
    }

    /// Volume by trying every triple of points as a face, for clouds in general position.
    fn volume_by_force(points: &[Vector3<f64>]) -> (f64, usize) {
        let centre = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let (mut volume, mut faces) = (0.0, 0);
        for i in 0..points.len() {
            for j in i + 1..points.len() {
                for k in j + 1..points.len() {
                    let normal = (points[j] - points[i]).cross(&(points[k] - points[i]));
                    let above = points.iter().filter(|&p| normal.dot(&(p - points[i])) > 1e-12).count();
                    let below = points.iter().filter(|&p| normal.dot(&(p - points[i])) < -1e-12).count();
                    if above == 0 || below == 0 {
                        volume += (normal.dot(&(points[i] - centre)) / 6.0).abs();
                        faces += 1;
                    }
                }
            }
        }
        (volume, faces)
    }

    #[test]
    fn random_clouds_agree_with_trying_every_face() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for n in [4, 5, 8, 20, 40] {
            for _ in 0..10 {
                let points: Vec<_> = (0..n).map(|_| random_point(&mut rng)).collect();
                let hull = Hull::of(&points).unwrap();
                assert_hull(&hull, &points);
                let (volume, faces) = volume_by_force(&points);
                assert_eq!(hull.triangles.len(), faces);
                assert!((hull.volume() - volume).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_thickness_of_many_corners_is_what_looking_at_all_of_them_finds() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for flat in [1.0, 0.1, 1e-3] {
            let points: Vec<_> = (0..1000)
                .map(|_| random_point(&mut rng).normalize().component_mul(&Vector3::new(1.0, 1.0, flat)))
                .collect();
            let hull = Hull::of(&points).unwrap();
            let width = |plane: &Plane| {
                let heights = hull.vertices.iter().map(|v| plane.normal.dot(v));
                plane.offset - heights.fold(f64::MAX, f64::min)
            };
            let by_force = hull.planes.iter().map(width).fold(f64::MAX, f64::min);
            assert!((hull.thickness() / by_force - 1.0).abs() < 1e-12, "{flat}");
        }
    }

    #[test]
    fn every_point_of_a_ball_is_a_corner() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let points: Vec<_> = (0..2000).map(|_| random_point(&mut rng).normalize()).collect();
        let hull = Hull::of(&points).unwrap();
        assert_hull(&hull, &points);
        assert_eq!(hull.vertices.len(), points.len());
        assert!((hull.volume() / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
    }
}
