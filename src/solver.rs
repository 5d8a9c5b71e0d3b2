//! The numerical method as a user writes it: which cables, which contact, which step.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::quantity::Positive;

/// The numerical method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// How cable tension acts.
    pub cables: CableModel,
    /// How a contact is answered.
    pub contact: ContactModel,
    /// Time step [s].
    pub step_s: Positive,
    /// Sub-steps of the engine within a step, at which cables and contacts act; contacts are found once a step.
    #[schemars(range(min = 1, max = 1000))]
    pub substeps: u32,
    /// Gauss-Seidel sweeps over all cable and contact rows in each sub-step: at least so many.
    #[schemars(range(min = 1, max = 1000))]
    pub sweeps: u32,
    /// At most so many, while a step gains energy (see `world::sweeps`).
    #[schemars(range(min = 1, max = 1000))]
    pub sweeps_max: u32,
    /// Gauss-Seidel passes over the cables that snap taut within a step; 0: snaps are left to the engine.
    #[schemars(range(max = 1000))]
    pub snap_passes: u32,
    /// Coefficient of restitution e of a contact (Eq. 4.11) [-].
    #[schemars(range(min = 0, max = 1))]
    pub restitution: f64,
    /// Width of the engine's numbers.
    pub precision: Precision,
}

impl Default for Solver {
    /// Measured on the free-floating Cubesat (wall time for 3 s; angular momentum residual) and the
    /// Table 3.2 net (bullets against RK4 at 0.5 s): one sub-step of 0.5 ms 0.48 s, 3e-7, 0.9 mm;
    /// two of 1 ms 0.40 s, 5e-5, 0.8 mm; four of 1 ms 0.50 s, 1e-4, 0.8 mm. The engine freezes the
    /// lever arms of contacts over a step, so sub-steps lose angular momentum where knots slide.
    fn default() -> Self {
        Solver {
            cables: CableModel::Joints,
            contact: ContactModel::Rapier,
            step_s: Positive(0.0005),
            substeps: 1,
            sweeps: 2,
            sweeps_max: 64,
            // Passes end when nothing snaps any more, so more cost nothing where 4 suffice. A 2 x 3
            // mesh net of undamped Kevlar gains 64 % of its launch energy with 4, nothing with 16.
            snap_passes: 16,
            restitution: 0.0,
            precision: Precision::F64,
        }
    }
}

/// How cable tension acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CableModel {
    /// Tension-only spring joints of the engine.
    Joints,
}

/// How a contact is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactModel {
    /// The engine's own solver.
    Rapier,
}

/// Width of the engine's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// 64 bits.
    F64,
}
