//! Mass, centre of mass and inertia of a target from its parts.
//!
//! A part is of uniform density; where parts overlap, each counts in full. With parts of mass mᵢ,
//! centroid rᵢ and inertia Jᵢ (per density) of volume Vᵢ:
//!
//! m = Σ mᵢ,  r = Σ mᵢ rᵢ / m,  I = Σ (mᵢ / Vᵢ Jᵢ + mᵢ (|dᵢ|² 1 − dᵢ dᵢᵀ)),  dᵢ = rᵢ − r

use nalgebra::{Matrix3, Vector3};

use super::moments::parallel_axis;
use super::parts::Solid;
use super::spec::Motion;
use crate::problems::Problems;
use crate::read::join;

/// Density of parts without any mass, of a target whose motion does not depend on it [kg/m^3].
pub const DEFAULT_DENSITY: f64 = 1000.0;

/// Slack of the checks on masses and inertias, relative: what writing seven digits may lose.
const SLACK: f64 = 1e-6;

/// Mass of each solid [kg]: its own, or its share by volume of what the own ones leave of `total`.
///
/// Without `total`, every solid needs its own mass, unless the motion is prescribed.
pub fn share(
    solids: &[Solid],
    total: Option<f64>,
    motion: Motion,
    place: &str,
    problems: &mut Problems,
) -> Option<Vec<f64>> {
    let own: f64 = solids.iter().filter_map(|solid| solid.own_mass).sum();
    let massless = solids.iter().filter(|solid| solid.own_mass.is_none());
    let (n_massless, volume) = massless.fold((0, 0.0), |(n, v), solid| (n + 1, v + solid.moments.volume));
    let place = join(place, "mass_kg");
    let density = match total {
        Some(total) if n_massless == 0 => {
            if (own - total).abs() > SLACK * total {
                let allowed = format!("the sum of the parts' own masses, {own} kg, or nothing");
                problems.add(place, total, allowed);
                return None;
            }
            0.0
        }
        Some(total) => {
            if total <= own {
                let allowed =
                    format!("more than the parts' own {own} kg: those without mass_kg share the rest");
                problems.add(place, total, allowed);
                return None;
            }
            (total - own) / volume
        }
        None if n_massless == 0 || motion != Motion::Free => DEFAULT_DENSITY,
        None => {
            let found = format!("nothing, and {n_massless} of {} parts without mass_kg", solids.len());
            problems.add(place, found, "the mass of the target, or mass_kg in every part");
            return None;
        }
    };
    Some(solids.iter().map(|solid| solid.own_mass.unwrap_or(density * solid.moments.volume)).collect())
}

/// Centre of mass in the frame of the shape [m].
pub fn centre(solids: &[Solid], masses: &[f64]) -> Vector3<f64> {
    let weighted = solids.iter().zip(masses).map(|(solid, &mass)| mass * solid.moments.centroid);
    weighted.sum::<Vector3<f64>>() / masses.iter().sum::<f64>()
}

/// Inertia about the centre of mass [kg m^2].
pub fn inertia(solids: &[Solid], masses: &[f64], centre: Vector3<f64>) -> Matrix3<f64> {
    let about_centre = |(solid, &mass): (&Solid, &f64)| {
        let moments = solid.moments;
        mass / moments.volume * moments.inertia + parallel_axis(mass, moments.centroid - centre)
    };
    solids.iter().zip(masses).map(about_centre).sum()
}

/// A given inertia, when a body of this mass within `radius` of its centre of mass can have it.
pub fn check_inertia(
    given: [[f64; 3]; 3],
    mass: f64,
    radius: f64,
    place: &str,
    problems: &mut Problems,
) -> Option<Matrix3<f64>> {
    let place = join(place, "inertia_kg_m2");
    let given = Matrix3::from_fn(|row, column| given[row][column]);
    if !given.iter().all(|entry| entry.is_finite()) {
        problems.add(place, "an entry that is not finite", "nine finite numbers");
        return None;
    }
    let skew = (given - given.transpose()).amax();
    if skew > SLACK * given.amax() {
        let found = format!("entries across the diagonal that differ by {skew} kg m^2");
        problems.add(place, found, "a symmetric matrix");
        return None;
    }
    let inertia = 0.5 * (given + given.transpose());
    let mut principal = inertia.symmetric_eigenvalues();
    principal.as_mut_slice().sort_by(f64::total_cmp);
    let [least, middle, most] = principal.into();
    let found = format!("principal moments {least:.6e}, {middle:.6e}, {most:.6e} kg m^2");
    // A body of points mᵢ at xᵢ has I₁ = Σ mᵢ (y² + z²) and so on, whence all three rules.
    let rule = if least <= 0.0 {
        "positive principal moments".to_owned()
    } else if most > (least + middle) * (1.0 + SLACK) {
        "principal moments of which none exceeds the sum of the other two".to_owned()
    } else if most > mass * radius * radius * (1.0 + SLACK) {
        format!(
            "at most {:.6e} kg m^2: {mass} kg within {radius:.4} m of the centre of mass",
            mass * radius * radius
        )
    } else {
        return Some(inertia);
    };
    problems.add(place, found, rule);
    None
}
