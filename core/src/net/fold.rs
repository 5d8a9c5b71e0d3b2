//! How the net lies in its container when it is shot (Section 3.2.2).
//!
//! `scaled`: flat in the plane X = 0, uniformly shrunk about its centre by `ratio`; middle knots
//! straight between their ends. Every cable is slack, every knot at rest.
//!
//! `inwards`: the source's scheme. Every cable is folded at its middle, and the knots of the grid
//! come together as in `scaled`; the two straight halves of a cable hang into the container, along
//! −X, so that each cable keeps its unstretched length. The depth of the fold is
//! √((l₀/2)² − (ratio l₀/2)²). The source draws the sequence but gives no coordinates (its figures
//! are not in the text we have); that the halves hang along −X, and not sideways, is our choice,
//! since the space between the drawn-in knots is too small for them.
//!
//! Middle knots lie where they are on the folded cable. With an odd number one is at the fold, and every piece has its
//! length. With an even number, none among them, the fold is within a piece: a spring is straight and slack there, so
//! that without middle knots the net is that of `scaled`; elements are folded in that piece (`ElementNet::folded`).

use nalgebra::Vector3;

use super::GridLine;
use super::spec::{self, FoldScheme};

/// Positions of all knots in the container [m].
pub(crate) fn folded(spec: &spec::NetSpec, grid: [usize; 2], lines: &[GridLine]) -> Vec<Vector3<f64>> {
    let sides = spec.mesh_length_m.sides();
    let ratio = spec.fold.ratio;
    let mut positions: Vec<Vector3<f64>> = Vec::new();
    for row in 0..grid[0] {
        for column in 0..grid[1] {
            // Twice the offset from the centre is a whole number of meshes: the two halves of
            // the net mirror each other to the last bit.
            let y = (2.0 * row as f64 - (grid[0] - 1) as f64) * (0.5 * ratio * sides[0]);
            let z = (2.0 * column as f64 - (grid[1] - 1) as f64) * (0.5 * ratio * sides[1]);
            positions.push(Vector3::new(0.0, y, z));
        }
    }
    for line in lines {
        let (start, end) = (positions[line.ends[0]], positions[line.ends[1]]);
        let side = sides[line.along];
        let depth = match spec.fold.scheme {
            FoldScheme::Scaled => 0.0,
            FoldScheme::Inwards => 0.5 * side * (1.0 - ratio * ratio).sqrt(),
        };
        let n_middle = line.middle.len();
        for i in 1..=n_middle {
            let share = i as f64 / (n_middle + 1) as f64;
            let into = depth * (1.0 - (2.0 * share - 1.0).abs());
            positions.push(start + (end - start) * share - into * Vector3::x());
        }
    }
    positions
}

#[cfg(test)]
mod tests {
    use crate::net::Net;
    use crate::net::spec::{self, Launch};
    use crate::problems::Problems;
    use serde_json::json;

    fn build(middle: u32, scheme: &str) -> (Option<Net>, Problems) {
        let spec: spec::NetSpec = serde_json::from_value(json!({
            "meshes": [4, 3], "mesh_length_m": 0.5, "bullet_mass_kg": 1.0, "middle_knots": middle,
            "cable": { "material": "kevlar", "diameter_m": 0.001 },
            "fold": { "scheme": scheme, "ratio": 0.2 } }))
        .unwrap();
        let mut problems = Problems::new("test");
        let net = Net::build(
            &spec,
            &Launch { speed_m_s: 1.0, angle_deg: 30.0, bullets: Default::default() },
            &mut problems,
        );
        (net, problems)
    }

    fn lengths(net: &Net) -> impl Iterator<Item = (f64, f64)> + '_ {
        net.cables.iter().map(|c| ((net.folded[c.a] - net.folded[c.b]).norm(), c.rest_length))
    }

    #[test]
    fn scaled_leaves_every_cable_slack_by_the_ratio() {
        for middle in [0, 1, 2] {
            let net = build(middle, "scaled").0.unwrap();
            assert!(lengths(&net).all(|(length, rest)| (length - 0.2 * rest).abs() < 1e-12));
        }
    }

    #[test]
    fn inwards_keeps_every_cable_at_its_length() {
        for middle in [1, 3] {
            let (net, problems) = build(middle, "inwards");
            assert_eq!(problems.list, vec![]);
            assert!(lengths(&net.unwrap()).all(|(length, rest)| (length - rest).abs() < 1e-12));
        }
    }

    /// Two middle knots of three pieces: the outer ones have their length, the one with the fold is drawn in as the net is.
    /// None: there is nothing to hang.
    #[test]
    fn inwards_with_the_fold_within_a_piece_leaves_that_piece_slack() {
        let net = build(2, "inwards").0.unwrap();
        for (piece, (length, rest)) in lengths(&net).enumerate() {
            let share = if piece % 3 == 1 { 0.2 } else { 1.0 };
            assert!((length - share * rest).abs() < 1e-12, "{piece}");
        }
        let [inwards, scaled] = ["inwards", "scaled"].map(|scheme| build(0, scheme).0.unwrap());
        assert_eq!(inwards.folded, scaled.folded);
        assert!(inwards.folded_inwards && !scaled.folded_inwards);
    }
}
