//! The gradient-deficient cable element (Eq. 3.7 to 3.14), and a cable of several of them.
//!
//! r(ξ) = S₁ r₀ + S₂ σ₀ + S₃ r₁ + S₄ σ₁, 0 ≤ ξ ≤ 1 (Eq. 3.7, 3.9)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | l | unstretched length of an element | m |
//! | r₀, r₁ | positions of its two nodes | m |
//! | σ₀, σ₁ | l times the slopes ∂r/∂x there (Eq. 3.8): the factor l of S₂ and S₄ is in the coordinate | m |
//! | μ = ρ A l | its mass | kg |
//!
//! With slopes times l all matrices of an element are those of one of unit length and mass times a number of its
//! own: M = μ `MASS` (Eq. 3.11), and cables of any length and material share one factorisation.

use nalgebra::DMatrix;

pub use crate::state::elements::COORDINATES;
use crate::state::elements::NodeList;

/// A matrix of an element, the same for each of the three axes.
pub type ElementMatrix = [[f64; COORDINATES]; COORDINATES];

/// ∫ S Sᵀ dξ (Eq. 3.11).
pub const MASS: ElementMatrix = scaled(
    [
        [156.0, 22.0, 54.0, -13.0],
        [22.0, 4.0, 13.0, -3.0],
        [54.0, 13.0, 156.0, -22.0],
        [-13.0, -3.0, -22.0, 4.0],
    ],
    1.0 / 420.0,
);

/// ∫ S′ S′ᵀ dξ: the stiffness along a straight, taut element.
pub const STRETCH: ElementMatrix = scaled(
    [[36.0, 3.0, -36.0, 3.0], [3.0, 4.0, -3.0, -1.0], [-36.0, -3.0, 36.0, -3.0], [3.0, -1.0, -3.0, 4.0]],
    1.0 / 30.0,
);

/// ∫ S″ S″ᵀ dξ: the stiffness against bending.
pub const BEND: ElementMatrix =
    [[12.0, 6.0, -12.0, 6.0], [6.0, 4.0, -6.0, 2.0], [-12.0, -6.0, 12.0, -6.0], [6.0, 2.0, -6.0, 4.0]];

const fn scaled(mut matrix: ElementMatrix, factor: f64) -> ElementMatrix {
    let mut i = 0;
    while i < COORDINATES * COORDINATES {
        matrix[i / COORDINATES][i % COORDINATES] *= factor;
        i += 1;
    }
    matrix
}

/// Points of Gauss's quadrature: five integrate the force of a wholly taut element, of degree eight, exactly.
pub const POINTS: usize = 5;

/// A point of the quadrature: its weight, and what r′ is made of there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GaussPoint {
    /// Share of the element that it stands for [-].
    pub weight: f64,
    /// S₃′ = −S₁′, the factor of r₁ − r₀.
    pub chord: f64,
    /// S₂′ and S₄′.
    pub slopes: [f64; 2],
}

/// The points of the quadrature on [0, 1].
pub fn gauss() -> [GaussPoint; POINTS] {
    let root = (10.0_f64 / 7.0).sqrt();
    let [near, far] = [5.0 - 2.0 * root, 5.0 + 2.0 * root].map(|square| square.sqrt() / 3.0);
    let spread = 13.0 * 70.0_f64.sqrt();
    let [of_near, of_far] = [322.0 + spread, 322.0 - spread].map(|weight| weight / 900.0);
    [(-far, of_far), (-near, of_near), (0.0, 128.0 / 225.0), (near, of_near), (far, of_far)].map(
        |(place, weight)| {
            let [_, first, chord, second] = derivatives(0.5 * (1.0 + place));
            GaussPoint { weight: 0.5 * weight, chord, slopes: [first, second] }
        },
    )
}

/// dS/dξ.
pub fn derivatives(xi: f64) -> [f64; COORDINATES] {
    let chord = 6.0 * xi * (1.0 - xi);
    [-chord, 1.0 - 4.0 * xi + 3.0 * xi * xi, chord, -2.0 * xi + 3.0 * xi * xi]
}

/// A cable's matrix, of elements that all have `matrix`.
fn assemble(layout: NodeList, matrix: &ElementMatrix) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(layout.size(), layout.size());
    for element in 0..layout.elements {
        for (i, row) in matrix.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                all[(2 * element + i, 2 * element + j)] += value;
            }
        }
    }
    all
}

/// The mass matrix of a cable of elements of unit mass, with the cable's own coordinates eliminated:
/// what is left couples its two ends only.
///
/// M = [A B; Bᵀ C] with the own coordinates first. M a = f is solved by (C − Bᵀ W) a_ends = f_ends − Wᵀ f_own with
/// W = A⁻¹ B, then a_own = A⁻¹ f_own − W a_ends.
pub struct Condensation {
    /// A⁻¹, row by row.
    pub inverse: Vec<Vec<f64>>,
    /// W: of each own coordinate, that of either end.
    pub share: Vec<[f64; 2]>,
    /// C − Bᵀ W.
    pub ends: [[f64; 2]; 2],
}

impl Condensation {
    /// That of `layout`.
    pub fn new(layout: NodeList) -> Condensation {
        let mass = assemble(layout, &MASS);
        let inner: Vec<usize> = layout.inner().collect();
        let own = DMatrix::from_fn(inner.len(), inner.len(), |i, j| mass[(inner[i], inner[j])]);
        let coupling = DMatrix::from_fn(inner.len(), 2, |i, end| mass[(inner[i], layout.ends()[end])]);
        // A part of a positive definite matrix is one.
        let inverse = own.try_inverse().unwrap_or_default();
        let share = &inverse * &coupling;
        let taken = coupling.transpose() * &share;
        let left = |i: usize, j: usize| mass[(layout.ends()[i], layout.ends()[j])] - taken[(i, j)];
        Condensation {
            inverse: inverse.row_iter().map(|row| row.iter().copied().collect()).collect(),
            share: share.row_iter().map(|row| [row[0], row[1]]).collect(),
            ends: [[left(0, 0), left(0, 1)], [left(1, 0), left(1, 1)]],
        }
    }
}

/// Largest eigenvalue of M⁻¹ K for an element of unit mass and stiffness K, symmetric: no cable and no net of such
/// elements has a larger one.
pub fn largest_eigenvalue(stiffness: &ElementMatrix) -> f64 {
    let matrix = |of: &ElementMatrix| DMatrix::from_fn(COORDINATES, COORDINATES, |i, j| of[i][j]);
    // The mass of an element is positive definite.
    let Some(mass) = matrix(&MASS).cholesky() else { return 0.0 };
    let half = mass.l().solve_lower_triangular(&matrix(stiffness)).unwrap_or_default();
    let whole = mass.l().solve_lower_triangular(&half.transpose()).unwrap_or_default();
    whole.symmetric_eigenvalues().max()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ of products of two rows of derivatives by the quadrature itself.
    #[test]
    fn quadrature_and_matrices_agree() {
        let weights: f64 = gauss().iter().map(|point| point.weight).sum();
        assert!((weights - 1.0).abs() < 1e-15);
        for i in 0..COORDINATES {
            for j in 0..COORDINATES {
                let sum: f64 = gauss()
                    .iter()
                    .map(|GaussPoint { weight, chord, slopes: [a, b] }| {
                        let rows = [-chord, *a, *chord, *b];
                        weight * rows[i] * rows[j]
                    })
                    .sum();
                assert!((sum - STRETCH[i][j]).abs() < 1e-14, "{i} {j}");
            }
        }
    }

    /// A rigid element has its whole mass, and neither stiffness resists rigid motion.
    #[test]
    fn rigid_motion_has_the_mass_of_the_element_and_no_stiffness() {
        let times = |matrix: &ElementMatrix, mode: [f64; 4]| {
            matrix.map(|row| row.iter().zip(mode).map(|(a, b)| a * b).sum::<f64>())
        };
        let shift = [1.0, 0.0, 1.0, 0.0];
        let turn = [0.0, 1.0, 1.0, 1.0];
        let dot = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((dot(shift, times(&MASS, shift)) - 1.0).abs() < 1e-15);
        // ∫ ξ² dξ.
        assert!((dot(turn, times(&MASS, turn)) - 1.0 / 3.0).abs() < 1e-15);
        for force in [times(&STRETCH, shift), times(&BEND, shift), times(&BEND, turn)] {
            assert!(force.iter().all(|f| f.abs() < 1e-15));
        }
    }

    /// The condensed solution is that of the whole matrix.
    #[test]
    fn condensation_solves_the_whole_mass_matrix() {
        for elements in [1, 2, 3, 5] {
            let layout = NodeList { elements };
            let force: Vec<f64> = (0..layout.size()).map(|i| (1.7 * i as f64).sin()).collect();
            let whole = assemble(layout, &MASS)
                .lu()
                .solve(&DMatrix::from_column_slice(force.len(), 1, &force))
                .unwrap();
            let Condensation { inverse, share, ends } = Condensation::new(layout);
            let inner: Vec<usize> = layout.inner().collect();
            let reduced = layout.ends().map(|end| force[end]);
            let taken = |end: usize| -> f64 {
                inner.iter().zip(&share).map(|(&place, share)| share[end] * force[place]).sum()
            };
            let rhs = [reduced[0] - taken(0), reduced[1] - taken(1)];
            let determinant = ends[0][0] * ends[1][1] - ends[0][1] * ends[1][0];
            let at_ends = [
                (ends[1][1] * rhs[0] - ends[0][1] * rhs[1]) / determinant,
                (ends[0][0] * rhs[1] - ends[1][0] * rhs[0]) / determinant,
            ];
            for (row, (&place, share)) in inverse.iter().zip(inner.iter().zip(&share)) {
                let own: f64 = row.iter().zip(&inner).map(|(a, &place)| a * force[place]).sum();
                let found = own - share[0] * at_ends[0] - share[1] * at_ends[1];
                assert!((found - whole[place]).abs() < 1e-9 * whole.norm(), "{elements} {place}");
            }
        }
    }
}
