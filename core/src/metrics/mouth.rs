//! How wide the mouth is, by measures that a crossed perimeter cannot fool.
//!
//! | measure | definition |
//! |---|---|
//! | vector area | of the perimeter polygon, over the designed area; the two halves of a perimeter crossed like an eight cancel |
//! | planar hull | area of the convex hull of the perimeter knots, projected on the plane that fits them best, over the designed area; a crossing cannot cancel it |
//! | gather | mean distance of the four bullets from their centre, over the side of the net (the root of the designed area): 0.71 as designed, 0 where they have met |
//! | coverage | share of 200 even directions from the target's centre of mass that have a knot within 30° |

use std::sync::LazyLock;

use nalgebra::{Matrix3, Vector3};

use crate::geometry::vector_area;
use crate::net::Net;

/// Directions in which coverage looks.
const N_DIRECTIONS: usize = 200;

/// Cosine of the angle within which a knot covers a direction, 30°.
const COVERS: f64 = 0.866_025_403_784_438_6;

/// Vector area of the perimeter over the designed area [-].
pub fn vector_area_share(net: &Net, knots: &[Vector3<f64>]) -> f64 {
    vector_area(net.perimeter.iter().map(|&knot| knots[knot])).norm() / net.designed_area
}

/// Planar hull of the perimeter over the designed area [-].
pub fn planar_hull_share(net: &Net, knots: &[Vector3<f64>]) -> f64 {
    let points: Vec<Vector3<f64>> = net.perimeter.iter().map(|&knot| knots[knot]).collect();
    planar_hull(&points) / net.designed_area
}

/// Mean distance of the bullets from their centre over the side of the net [-].
pub fn gather(net: &Net, knots: &[Vector3<f64>]) -> f64 {
    let bullets = net.bullets.map(|bullet| knots[bullet]);
    let centre = bullets.iter().sum::<Vector3<f64>>() / 4.0;
    let mean = bullets.iter().map(|bullet| (bullet - centre).norm()).sum::<f64>() / 4.0;
    mean / net.designed_area.sqrt()
}

/// Share of all directions from `centre` that have a knot within 30° [-].
pub fn coverage(centre: &Vector3<f64>, knots: &[Vector3<f64>]) -> f64 {
    static DIRECTIONS: LazyLock<Vec<Vector3<f64>>> = LazyLock::new(|| directions().collect());
    let towards: Vec<Vector3<f64>> =
        knots.iter().filter_map(|knot| (knot - centre).try_normalize(0.0)).collect();
    let covers = |towards: &Vector3<f64>, direction: &Vector3<f64>| towards.dot(direction) >= COVERS;
    // A direction is looked at with all of eight knots at a time: without branches the processor does it in vectors.
    let covered = |direction: &&Vector3<f64>| {
        towards.chunks(8).any(|some| some.iter().fold(false, |any, one| any | covers(one, direction)))
    };
    DIRECTIONS.iter().filter(covered).count() as f64 / N_DIRECTIONS as f64
}

/// Even directions: equal steps along the axis, each turned by the golden angle.
fn directions() -> impl Iterator<Item = Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..N_DIRECTIONS).map(move |index| {
        let z = 1.0 - (2 * index + 1) as f64 / N_DIRECTIONS as f64;
        let (sin, cos) = (golden * index as f64).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        Vector3::new(radius * cos, radius * sin, z)
    })
}

/// Area of the convex hull of `points`, projected on the plane that fits them best [m^2].
fn planar_hull(points: &[Vector3<f64>]) -> f64 {
    let centre = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let spread: Matrix3<f64> = points.iter().map(|p| (p - centre) * (p - centre).transpose()).sum();
    let axes = spread.symmetric_eigen();
    // The normal is the axis of least spread; the plane is that of the other two.
    let normal = axes.eigenvalues.imin();
    let [u, v] = [1, 2].map(|k| axes.eigenvectors.column((normal + k) % 3).into_owned());
    let flat: Vec<[f64; 2]> = points.iter().map(|p| [(p - centre).dot(&u), (p - centre).dot(&v)]).collect();
    flat_hull_area(flat)
}

/// Area of the convex hull of points in a plane: monotone chains over the points in order of x.
fn flat_hull_area(mut points: Vec<[f64; 2]>) -> f64 {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turn =
        |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while chain.len() >= 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], point) <= 0.0 {
                chain.pop();
            }
            chain.push(point);
        }
        chain
    };
    let lower = chain(&mut points.iter().copied());
    let upper = chain(&mut points.iter().rev().copied());
    let outline: Vec<Vector3<f64>> =
        lower.iter().chain(&upper).map(|p| Vector3::new(p[0], p[1], 0.0)).collect();
    vector_area(outline).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(flat: &[[f64; 2]]) -> Vec<Vector3<f64>> {
        let turn = nalgebra::UnitQuaternion::from_euler_angles(0.3, -1.1, 0.7);
        flat.iter().map(|p| Vector3::new(1.0, 2.0, 3.0) + turn * Vector3::new(p[0], p[1], 0.0)).collect()
    }

    #[test]
    fn a_crossed_perimeter_cancels_the_vector_area_and_not_the_planar_hull() {
        let eight = turned(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
        assert!(vector_area(eight.iter().copied()).norm() < 1e-12);
        assert!((planar_hull(&eight) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn points_inside_and_on_the_outline_do_not_count() {
        let square = turned(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, 0.7]]);
        assert!((planar_hull(&square) - 4.0).abs() < 1e-12);
        assert_eq!(planar_hull(&[]), 0.0);
        assert!(planar_hull(&turned(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])) < 1e-12);
    }

    #[test]
    fn coverage_is_that_of_the_half_space_the_knots_are_in() {
        let centre = Vector3::new(0.1, 0.2, 0.3);
        let sphere: Vec<Vector3<f64>> = directions().map(|d| centre + 2.0 * d).collect();
        assert_eq!(coverage(&centre, &sphere), 1.0);
        let one = [centre + Vector3::x()];
        // A cap of half angle 30° has (1 − cos 30°) / 2 = 0.067 of the sphere. Measured: 0.070.
        assert!((coverage(&centre, &one) - 0.067).abs() < 0.01);
        assert_eq!(coverage(&centre, &[centre]), 0.0);
    }
}
