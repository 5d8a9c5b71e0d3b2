//! The net as a user writes it: meshes, cables, bullets, fold and launch.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::quantity::Positive;

/// A net of rectangular meshes, lying in the plane X = 0 around the origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NetSpec {
    /// Number of meshes along Y and along Z.
    #[schemars(inner(range(min = 1, max = 10000)))]
    pub meshes: [u32; 2],
    /// Unstretched length of a mesh side [m]: one number, or one along Y and one along Z.
    pub mesh_length_m: MeshLength,
    /// The cables of the net.
    pub cable: CableSpec,
    /// The cables along the perimeter; absent: like the others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge_cable: Option<EdgeCable>,
    /// Knots added along every cable, so that it bends and touches between its ends.
    #[serde(default)]
    #[schemars(range(max = 63))]
    pub middle_knots: u32,
    /// Mass of each of the four bullets at the corners [kg].
    pub bullet_mass_kg: Positive,
    /// How the net lies in its container.
    #[serde(default)]
    pub fold: Fold,
}

impl NetSpec {
    /// Number of cables before middle knots divide them.
    pub fn n_lines(&self) -> u64 {
        let [along_y, along_z] = self.meshes.map(u64::from);
        along_y * (along_z + 1) + along_z * (along_y + 1)
    }

    /// Number of knots.
    pub fn n_knots(&self) -> u64 {
        let [along_y, along_z] = self.meshes.map(u64::from);
        (along_y + 1) * (along_z + 1) + self.n_lines() * u64::from(self.middle_knots)
    }
}

/// Side of a mesh [m].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum MeshLength {
    /// Square meshes.
    Square(Positive),
    /// Rectangular meshes: side along Y, side along Z.
    Rectangular([Positive; 2]),
}

impl MeshLength {
    /// Sides along Y and Z [m].
    pub fn sides(self) -> [f64; 2] {
        match self {
            MeshLength::Square(side) => [side.0, side.0],
            MeshLength::Rectangular([y, z]) => [y.0, z.0],
        }
    }
}

/// A cable of round cross-section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CableSpec {
    /// Name of a material (`tumblenet list` names them) or its numbers.
    pub material: MaterialChoice,
    /// Diameter [m].
    pub diameter_m: Positive,
    /// Damping ratio xi of Eq. 3.4 [-].
    #[serde(default = "CableSpec::default_damping_ratio")]
    #[schemars(range(min = 0, max = 10))]
    pub damping_ratio: f64,
}

impl CableSpec {
    /// Table 3.2.
    fn default_damping_ratio() -> f64 {
        0.1
    }
}

/// What differs along the perimeter; a member left out is that of the inner cables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EdgeCable {
    /// Name of a material or its numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<MaterialChoice>,
    /// Diameter [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameter_m: Option<Positive>,
    /// Damping ratio xi of Eq. 3.4 [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 10))]
    pub damping_ratio: Option<f64>,
}

/// A material by name, or its numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum MaterialChoice {
    /// Name of a built-in material.
    Named(String),
    /// The numbers themselves.
    Inline(Material),
}

/// Properties of a cable material (Table 3.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Where the numbers come from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Young's modulus E [Pa].
    pub young_modulus_pa: Positive,
    /// Density rho [kg/m^3].
    pub density_kg_m3: Positive,
    /// Tensile strength sigma [Pa].
    pub tensile_strength_pa: Positive,
    /// Elongation at break [-].
    pub elongation_at_break: Positive,
}

/// How the net lies in its container (Section 3.2.2).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fold {
    /// The scheme.
    pub scheme: FoldScheme,
    /// Side of the folded net over the side of the deployed one [-].
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0))]
    pub ratio: f64,
}

impl Default for Fold {
    fn default() -> Self {
        Fold { scheme: FoldScheme::Scaled, ratio: 0.1 }
    }
}

/// Folding schemes; each is defined in `net::fold`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FoldScheme {
    /// Flat, uniformly shrunk about its centre, cables slack.
    Scaled,
    /// The source's scheme: every cable folded inwards at its middle.
    Inwards,
}

/// The shot: four bullets, one speed and one angle, from which each may deviate; all else at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Launch {
    /// Speed of each bullet [m/s].
    #[schemars(range(min = 0))]
    pub speed_m_s: f64,
    /// Shooting angle between a bullet's velocity and the travelling direction X [deg].
    #[schemars(range(min = 0, max = 90))]
    pub angle_deg: f64,
    /// How each bullet's shot deviates from that. In the order of the corners at (−Y, −Z), (+Y, −Z), (+Y, +Z), (−Y, +Z).
    #[serde(default, skip_serializing_if = "BulletDeviations::is_zero")]
    pub bullets: BulletDeviations,
}

impl Launch {
    /// Speed of the fastest bullet [m/s].
    pub fn top_speed(&self) -> f64 {
        self.speed_m_s + self.bullets.speed_m_s.into_iter().fold(0.0, f64::max)
    }
}

/// How the shots of the four bullets deviate from the common one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BulletDeviations {
    /// Faster by [m/s].
    pub speed_m_s: [f64; 4],
    /// Shooting angle wider by [deg].
    #[schemars(inner(range(min = -30, max = 30)))]
    pub angle_deg: [f64; 4],
    /// Aside, out of the plane of X and the net's diagonal, by [deg]; positive turns from Y towards Z.
    #[schemars(inner(range(min = -30, max = 30)))]
    pub aside_deg: [f64; 4],
    /// Shot later than time 0 by [s]. Until its shot a bullet is taken to be on its way in the barrel, behind its place in the
    /// folded net, where it is at that time with its whole speed.
    #[schemars(inner(range(min = 0)))]
    #[serde(skip_serializing_if = "BulletDeviations::is_at_once")]
    pub delay_s: [f64; 4],
}

impl BulletDeviations {
    /// Whether no shot deviates: nothing is said of it, so the hash of such a scene is as ever.
    pub fn is_zero(&self) -> bool {
        *self == BulletDeviations::default()
    }

    fn is_at_once(delay_s: &[f64; 4]) -> bool {
        *delay_s == [0.0; 4]
    }
}
