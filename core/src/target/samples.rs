//! Fixed points that stand for the volume of a target, for the share of it that a net encloses.
//!
//! They are spread evenly over the union of the parts: a part is drawn in proportion to its volume,
//! a point within it from its own Halton sequence, and a point that an earlier part holds already
//! is passed over, so that an overlap counts once.

use nalgebra::Vector3;

use super::parts::{ConvexPart, Primitive};
use crate::geometry::{Hull, halton, radical_inverse};

/// Number of points: the share is then good to about 1 %.
pub const N_SAMPLES: usize = 512;

/// Draws per point before one settles for fewer points; only a pile of parts in one place gets
/// there.
const DRAWS_PER_SAMPLE: usize = 64;

/// Points in the parts, in the frame of their poses [m].
pub fn spread(parts: &[ConvexPart]) -> Vec<Vector3<f64>> {
    let sources: Vec<Sampler> = parts.iter().map(Sampler::new).collect();
    let (ends, total) = running_sum(parts.iter().map(ConvexPart::volume));
    let mut n_drawn = vec![0; parts.len()];
    let mut samples = Vec::with_capacity(N_SAMPLES);
    for draw in 0..N_SAMPLES * DRAWS_PER_SAMPLE {
        // Base 7: the bases 2, 3 and 5 place the point within the part.
        let which = slot(&ends, radical_inverse(7, draw) * total);
        let point = parts[which].to_body(&sources[which].point(&mut n_drawn[which]));
        if !parts[..which].iter().any(|earlier| earlier.contains(&point)) {
            samples.push(point);
            if samples.len() == N_SAMPLES {
                break;
            }
        }
    }
    samples
}

/// Where the points of one part come from.
enum Sampler<'a> {
    /// A box around a solid that fills at least half of it (π/6 for a ball).
    Box { half: Vector3<f64>, solid: &'a Primitive },
    /// Tetrahedra from the middle of a hull to its faces, by volume: a box around a hull may be
    /// almost empty.
    Tetrahedra { hull: &'a Hull, middle: Vector3<f64>, ends: Vec<f64>, total: f64 },
}

impl<'a> Sampler<'a> {
    fn new(part: &'a ConvexPart) -> Sampler<'a> {
        let solid = &part.primitive;
        let half = match solid {
            Primitive::Cuboid { half } => Vector3::from(*half),
            Primitive::Cylinder { radius, half_length } => Vector3::new(*radius, *half_length, *radius),
            Primitive::Capsule { radius, half_length } => {
                Vector3::new(*radius, half_length + radius, *radius)
            }
            Primitive::Ball { radius } => Vector3::repeat(*radius),
            Primitive::Convex { hull, .. } => {
                let middle = hull.vertices.iter().sum::<Vector3<f64>>() / hull.vertices.len() as f64;
                let volumes = hull.triangles.iter().map(|triangle| {
                    let [a, b, c] = triangle.map(|corner| hull.vertices[corner as usize] - middle);
                    a.dot(&b.cross(&c)).max(0.0)
                });
                let (ends, total) = running_sum(volumes);
                return Sampler::Tetrahedra { hull, middle, ends, total };
            }
        };
        Sampler::Box { half, solid }
    }

    /// The next point, in the frame of the part; `drawn` counts the Halton points used up.
    fn point(&self, drawn: &mut usize) -> Vector3<f64> {
        loop {
            let unit = halton(*drawn);
            *drawn += 1;
            match self {
                Sampler::Box { half, solid } => {
                    let point = (2.0 * unit - Vector3::repeat(1.0)).component_mul(half);
                    if solid.contains(&point) {
                        return point;
                    }
                }
                Sampler::Tetrahedra { hull, middle, ends, total } => {
                    let which = slot(ends, radical_inverse(11, *drawn) * total);
                    let [a, b, c] = hull.triangles[which].map(|v| hull.vertices[v as usize] - middle);
                    let [u, v, w] = fold_into_tetrahedron(unit);
                    return middle + u * a + v * b + w * c;
                }
            }
        }
    }
}

/// Folds the unit cube into its corner u + v + w ≤ 1, evenly (Rocchini and Cignoni 2000).
fn fold_into_tetrahedron(unit: Vector3<f64>) -> [f64; 3] {
    let [mut u, mut v, mut w]: [f64; 3] = unit.into();
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    if v + w > 1.0 {
        (v, w) = (1.0 - w, 1.0 - u - v);
    } else if u + v + w > 1.0 {
        (u, w) = (1.0 - v - w, u + v + w - 1.0);
    }
    [u, v, w]
}

fn running_sum(values: impl Iterator<Item = f64>) -> (Vec<f64>, f64) {
    let mut sum = 0.0;
    let ends: Vec<f64> = values
        .map(|value| {
            sum += value;
            sum
        })
        .collect();
    (ends, sum)
}

/// The slot that `value` falls into, when slot i ends at `ends[i]`.
fn slot(ends: &[f64], value: f64) -> usize {
    ends.partition_point(|&end| end <= value).min(ends.len() - 1)
}
