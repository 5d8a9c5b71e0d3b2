//! The target as a user writes it: a shape of convex parts, where it is and how it moves.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::quantity::Positive;
pub use crate::state::Motion;

/// The debris.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetSpec {
    /// Name of a shape (`tumblenet list` names them), path of a shape file, or the shape itself.
    pub shape: ShapeChoice,
    /// Distance of its centre of mass along X [m].
    pub distance_m: f64,
    /// Offset of its centre of mass along Y and Z [m].
    #[serde(default)]
    pub offset_m: [f64; 2],
    /// Mass [kg]; absent: the sum of the parts' own masses. A target that is not free needs none:
    /// its parts without mass then count 1000 kg/m^3, which its motion does not depend on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<Positive>,
    /// Turns about the body's own x, then y, then z [deg].
    #[serde(default)]
    pub attitude_deg: [f64; 3],
    /// Angular velocity in the body frame [rad/s].
    #[serde(default)]
    pub spin_rad_s: [f64; 3],
    /// Velocity of its centre of mass at the start [m/s]; of a free target only. What is caught is seldom at rest
    /// before the chaser.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub velocity_m_s: [f64; 3],
    /// What its motion answers to.
    #[serde(default)]
    pub motion: Motion,
}

/// A target at rest says nothing of it, so the hash of its scene is as ever.
fn is_zero(velocity: &[f64; 3]) -> bool {
    *velocity == [0.0; 3]
}

/// A shape by name or path, or the shape itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ShapeChoice {
    /// Name of a built-in shape, or path of a shape file relative to the scene.
    Named(String),
    /// The shape itself.
    Inline(Shape),
}

/// A rigid body of convex parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shape {
    /// What it is, in a line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Where its dimensions come from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// The parts, placed relative to one another.
    #[schemars(length(min = 1))]
    pub parts: Vec<Part>,
    /// Inertia about the centre of mass in the body frame [kg m^2]; absent: from the parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia_kg_m2: Option<[[f64; 3]; 3]>,
}

/// One part of a shape: exactly one of `cuboid`, `cylinder`, `capsule`, `ball`, `convex`, `mesh`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// What it is, in a word or two, with the source of its dimensions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Box: full sides along x, y, z [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cuboid: Option<[Positive; 3]>,
    /// Cylinder along the part's y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cylinder: Option<Round>,
    /// Cylinder along the part's y with half balls beyond both ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capsule: Option<Round>,
    /// Ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ball: Option<Ball>,
    /// Convex hull of points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub convex: Option<Convex>,
    /// Closed surface from a file, split into convex parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshFile>,
    /// Position of the part's origin [m]: its centre, or the origin of its points or file.
    #[serde(default)]
    pub position_m: [f64; 3],
    /// Turns about the part's own x, then y, then z [deg].
    #[serde(default)]
    pub attitude_deg: [f64; 3],
    /// Mass of this part [kg]; absent: its share of the target's mass by volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<Positive>,
}

/// A round part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Round {
    /// Radius [m].
    pub radius_m: Positive,
    /// Length of the cylindrical piece [m].
    pub length_m: Positive,
}

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ball {
    /// Radius [m].
    pub radius_m: Positive,
}

/// Convex hull of points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Convex {
    /// The points [m].
    #[schemars(length(min = 4))]
    pub points_m: Vec<[f64; 3]>,
}

/// A surface from a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// Path of an OBJ or STL file, relative to the file that names it.
    pub file: String,
    /// Length of one unit of the file [m].
    #[serde(default = "MeshFile::default_unit")]
    pub unit_m: Positive,
}

impl MeshFile {
    fn default_unit() -> Positive {
        Positive(1.0)
    }
}
