//! Every setting of the engine, with its value and its reason, in one place.
//!
//! The engine is made for games; several of its defaults make this simulation wrong. What each
//! does, with numbers, was measured on small probes and whole captures. Those that matter are held
//! by a test named after the symptom (`tests/engine_facts.rs`).

use super::convert::real;
use super::rapier::dynamics::{FrictionModel, IntegrationParameters, SpringCoefficients};
use super::rapier::math::Real;

/// Contact stiffness as a natural frequency [Hz].
///
/// The default of 30 Hz lets taut cables press knots 26 mm into a target, and a whole net through
/// a Cubesat. Largest penetration of a Cubesat capture: 8.4 mm at 300 Hz, 1.2 mm at 1 kHz, 0.35 mm
/// at 2 kHz, 0.1 mm from 5 kHz to 1 MHz, stable at 1 ms with 1, 2 and 4 sub-steps.
const CONTACT_FREQUENCY: f64 = 1e6;

/// Engine parameters for a step of `step` seconds.
///
/// `prediction` is how far apart a knot and a part may be to be in contact within the step [m]; `rubs`: whether net and
/// target have friction.
pub fn parameters(step: f64, prediction: f64, rubs: bool) -> IntegrationParameters {
    let rigid = SpringCoefficients::new(real(CONTACT_FREQUENCY), 1.0);
    IntegrationParameters {
        dt: real(step),
        // Sub-steps of ours are whole steps of the engine. Its own keep the lever arms and gaps that they began with:
        // four of them on the default scene made twice the launch energy, and 1e-4 of angular momentum.
        num_solver_iterations: 1,
        // Set anew for every step: see `step::iterations`.
        num_internal_pgs_iterations: 1,
        // The bias-free pass drops the spring of a joint's limit: a soft rope would barely pull
        // and never rebound.
        num_internal_stabilization_iterations: 0,
        contact_softness: rigid,
        static_contact_softness: rigid,
        // A cap on the corrective speed weakens a stiff limit, hence a cable, without a word.
        normalized_max_corrective_velocity: Real::MAX,
        // No cap on speed: the engine would clip it in silence. `scene::checks` bounds what may
        // be asked for.
        normalized_max_linear_velocity: Real::MAX,
        normalized_prediction_distance: real(prediction),
        length_unit: 1.0,
        // Recycled contacts are stale: a knot sliding off a 10 cm cube floated 5 cm past its edge,
        // and 10 of 371 knots went through a 2 mm panel.
        contact_recycling: false,
        // Merging contacts of one plane is for piles of bodies; a knot has one contact a part.
        contact_clustering: false,
        // Sub-steps with fresh contacts need no sweep, and the sweep has an open fault between
        // two dynamic bodies (rapier#984).
        max_ccd_substeps: 0,
        // Without friction the two give the same bits, and Coulomb's rows, two a contact, are laid out and cleared all the same:
        // 14 % of the instructions of a free Cubesat. With friction the simplified model takes contacts of one part together.
        friction_model: if rubs { FrictionModel::Coulomb } else { FrictionModel::Simplified },
        ..IntegrationParameters::default()
    }
}
