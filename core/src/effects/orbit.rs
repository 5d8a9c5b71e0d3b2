//! The orbit: two-body gravity and the turn of the local frame (Eq. 3.5, 3.6, Fig. 3.7).
//!
//! The physics stands in [`crate::field`] and [`crate::field::orbit`]. The origin of the local frame
//! falls along the orbit; pose, velocity and spin of net and target at the start are relative to
//! the turning frame. Only what differs from the origin's fall acts, exact for each knot and body,
//! with the torque of the gravity gradient on a free target. A target that is held keeps its place in
//! the frame.
//!
//! Inclination, node and argument of perigee do not enter: the field of two bodies is a sphere's.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Parameters;
use super::field::Active;
use crate::field::orbit::{EARTH_RADIUS, OrbitMotion};
use crate::interaction::Interaction;
use crate::options::{BuildContext, BuildOptions};
use crate::problems::Problems;
use crate::quantity::Positive;
use crate::read::join;
use crate::target::files::Files;

/// Parameters of the orbit: `altitude_m` or `elements`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Orbit {
    /// Height of a circular orbit above the equatorial radius of the Earth [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub altitude_m: Option<Positive>,
    /// An elliptic orbit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elements: Option<Elements>,
    /// Direction of the shot in the orbital frame: `v-bar`, or a vector.
    #[serde(default)]
    pub approach: ShotDirection,
}

/// Size and shape of an orbit, and where on it the net is shot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Elements {
    /// Semi-major axis [m].
    pub semi_major_axis_m: Positive,
    /// Eccentricity [-].
    #[serde(default)]
    #[schemars(range(min = 0, max = 0.99))]
    pub eccentricity: f64,
    /// True anomaly at the shot [deg].
    #[serde(default)]
    pub true_anomaly_deg: f64,
}

/// Direction of the shot, X of the local frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ShotDirection {
    /// One of the axes.
    Along(Bar),
    /// Radially out, along the flight, along the orbit's normal; of any length but 0 [-].
    Vector([f64; 3]),
}

/// An axis of the orbital frame, by where the target is as seen from the chaser.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Bar {
    /// Ahead on the orbit (Fig. 3.7).
    VBar,
    /// Behind on the orbit.
    VBarBehind,
    /// Above.
    RBarAbove,
    /// Below.
    RBarBelow,
    /// Beside the orbit, along its normal.
    HBar,
}

impl Default for ShotDirection {
    fn default() -> Self {
        ShotDirection::Along(Bar::VBar)
    }
}

impl ShotDirection {
    /// Direction in the frame (R, V, H) [-].
    fn direction(&self) -> Vector3<f64> {
        match self {
            ShotDirection::Along(Bar::VBar) => Vector3::y(),
            ShotDirection::Along(Bar::VBarBehind) => -Vector3::y(),
            ShotDirection::Along(Bar::RBarAbove) => Vector3::x(),
            ShotDirection::Along(Bar::RBarBelow) => -Vector3::x(),
            ShotDirection::Along(Bar::HBar) => Vector3::z(),
            ShotDirection::Vector(direction) => Vector3::from(*direction),
        }
    }
}

impl Orbit {
    /// The orbit of the local frame's origin.
    pub fn motion(&self) -> OrbitMotion {
        let (axis, eccentricity, anomaly) = match (self.elements, self.altitude_m) {
            (Some(elements), _) => {
                (elements.semi_major_axis_m.0, elements.eccentricity, elements.true_anomaly_deg)
            }
            (None, altitude) => (EARTH_RADIUS + altitude.map_or(0.0, |altitude| altitude.0), 0.0, 0.0),
        };
        OrbitMotion::new(axis, eccentricity, anomaly.to_radians(), &self.approach.direction())
    }
}

impl Parameters for Orbit {
    fn ask(&self, options: &mut BuildOptions) {
        options.has_fields = true;
    }

    fn load(&mut self, _files: &Files, place: &str, problems: &mut Problems) {
        match (self.altitude_m, self.elements) {
            (None, None) => problems.add(place, "no orbit", "altitude_m or elements"),
            (Some(_), Some(_)) => {
                problems.add(place, "altitude_m and elements", "one of them: they might contradict");
            }
            (None, Some(elements)) => {
                let perigee = elements.semi_major_axis_m.0 * (1.0 - elements.eccentricity);
                if perigee <= EARTH_RADIUS {
                    let found = format!("a perigee at {perigee:.0} m from the Earth's centre");
                    problems.add(
                        join(place, "elements"),
                        found,
                        format!(
                            "one above the Earth's {EARTH_RADIUS:.0} m: semi_major_axis_m (1 - eccentricity)"
                        ),
                    );
                }
            }
            (Some(_), None) => {}
        }
        if self.approach.direction() == Vector3::zeros() {
            problems.add(join(place, "approach"), "[0, 0, 0]", "a direction of any length but 0");
        }
    }

    fn build(&self, context: &BuildContext<'_>) -> Interaction {
        let motion = self.motion();
        let installs = format!(
            "two kicks a step on {} knots and every free body; the frame turns once in {:.0} s",
            context.net.n_knots(),
            motion.period()
        );
        Active::on(context, "orbit", installs, motion)
    }
}
