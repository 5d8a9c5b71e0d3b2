//! The cabin of an aeroplane on a parabola (Section 3.5.2): residual gravity and rotation.
//!
//! The physics stands in [`crate::field`] and [`crate::field::profile`]. The local frame is fixed in
//! the cabin, which turns at Ω; the residual gravity is what an accelerometer at `centre_m` reads,
//! turned round: the acceleration of a free thing there, relative to the cabin. Both are constant, or
//! come from a CSV file, or the one on top of the other. A target that is held is fixed in the cabin.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Parameters;
use super::field::Active;
use crate::assets::Kind;
use crate::field::profile::{self, ProfileRow, Values};
use crate::interaction::Interaction;
use crate::limits::Limit;
use crate::options::{BuildContext, BuildOptions};
use crate::problems::Problems;
use crate::read::join;
use crate::target::files::Files;

/// Parameters of the cabin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Cabin {
    /// Residual gravity [m/s^2].
    pub gravity_m_s2: [f64; 3],
    /// Angular velocity of the cabin [rad/s].
    #[schemars(inner(range(min = -10, max = 10)))]
    pub rate_rad_s: [f64; 3],
    /// Both over time, added to the constant values: name of a built-in profile, or path of a CSV file
    /// relative to the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<String>,
    /// Which of the two acts.
    pub acts: Disturbance,
    /// Where the gravity was recorded, about which the cabin turns [m].
    pub centre_m: [f64; 3],
    /// The rows of the profile.
    #[serde(skip)]
    pub rows: Vec<ProfileRow>,
}

/// Which disturbance acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Disturbance {
    /// Residual gravity and rotation.
    #[default]
    Both,
    /// Residual gravity alone.
    Gravity,
    /// Rotation alone.
    Rotation,
}

impl Cabin {
    fn motion(&self) -> profile::CabinMotion {
        let of = |acts: bool| if acts { 1.0 } else { 0.0 };
        let gravity = of(self.acts != Disturbance::Rotation);
        let rate = of(self.acts != Disturbance::Gravity);
        let rows = self.rows.iter().map(|row| ProfileRow {
            t_s: row.t_s,
            gravity_x_m_s2: gravity * row.gravity_x_m_s2,
            gravity_y_m_s2: gravity * row.gravity_y_m_s2,
            gravity_z_m_s2: gravity * row.gravity_z_m_s2,
            rate_x_rad_s: rate * row.rate_x_rad_s,
            rate_y_rad_s: rate * row.rate_y_rad_s,
            rate_z_rad_s: rate * row.rate_z_rad_s,
        });
        profile::CabinMotion {
            constant: Values {
                gravity: gravity * Vector3::from(self.gravity_m_s2),
                rate: rate * Vector3::from(self.rate_rad_s),
            },
            rows: rows.collect(),
            centre: self.centre_m.into(),
        }
    }
}

impl Parameters for Cabin {
    fn load(&mut self, files: &Files, place: &str, problems: &mut Problems) {
        let Some(name) = &self.profile else { return };
        let place = join(place, "profile");
        let rows = if let Some(text) = Kind::Cabin.text(name) {
            profile::read(text.as_bytes(), &place, problems)
        } else if name.ends_with(".csv") {
            files
                .read(name, Limit::Text, &place, problems)
                .and_then(|(bytes, _)| profile::read(&bytes, &place, problems))
        } else {
            let allowed = format!("{}, or the path of a CSV file (.csv)", Kind::Cabin.instead_of(name));
            problems.add(place, format!("{name:?}"), allowed);
            None
        };
        self.rows = rows.unwrap_or_default();
    }

    fn loaded(&self) -> Vec<f64> {
        self.rows.iter().flat_map(ProfileRow::numbers).collect()
    }

    fn ask(&self, options: &mut BuildOptions) {
        let profile::CabinMotion { constant, rows, .. } = self.motion();
        // A cabin at rest without gravity is as good as none.
        options.has_fields |= !rows.is_empty() || constant != Values::default();
        let of_row = |row: &ProfileRow| {
            Vector3::new(row.gravity_x_m_s2, row.gravity_y_m_s2, row.gravity_z_m_s2).norm()
        };
        options.gravity = constant.gravity.norm() + rows.iter().map(of_row).fold(0.0, f64::max);
    }

    fn build(&self, context: &BuildContext<'_>) -> Interaction {
        let course = match self.rows.len() {
            0 => "constant".to_owned(),
            n => format!("a profile of {n} rows"),
        };
        let installs =
            format!("two kicks a step on {} knots and every free body; {course}", context.net.n_knots());
        Active::on(context, "cabin", installs, self.motion())
    }
}
