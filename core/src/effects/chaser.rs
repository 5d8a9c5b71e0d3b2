//! The chaser: a free body that takes the recoil of the shot (Section 6.3, item 2).
//!
//! Bullets of mass mᵢ leave at xᵢ with velocities vᵢ; the chaser, at rest until then, of mass M, inertia
//! I and centre of mass c, gets
//!
//! V = −Σ mᵢ vᵢ / M,  ω = −I⁻¹ Σ (xᵢ − c) × mᵢ vᵢ.
//!
//! Each bullet's speed and direction may deviate: speed by a normal distribution, direction by one
//! about each of two axes across it, all cut at three standard deviations and drawn from a seeded
//! stream, one a member of an ensemble. With equal shots from the middle of a symmetric net the
//! chaser does not turn; it does when they differ. Since then `launch.bullets` among what is uncertain in a scene says the
//! same with any distribution, and shows what was drawn.
//!
//! Its kinetic energy counts as stored, its momenta with those of net and target.
//! A closing thread to it (layout `cinch`) leaves it at the middle of the net's container and pulls at it.
//!
//! Limits: it touches nothing; a `tug` is the thrust of its engines handed on by a tether, and comes
//! from outside.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

use super::Parameters;
use super::blocks::SummaryRow;
use crate::interaction::{Effect, EffectOutput, Interaction, Report, StepObserver};
use crate::net::Net;
use crate::options::{BuildContext, BuildOptions};
use crate::problems::Problems;
use crate::quantity::Positive;
use crate::read::join;
use crate::state::elements::ElementNet;
use crate::state::{Body, BodyModel, EffectWork, Knots, Motion, NetTotals, State};
use crate::step;
use crate::target::files::Files;

/// Its name among the bodies.
const NAME: &str = "chaser";

/// Deviations beyond so many standard deviations are not drawn.
pub const CUT: f64 = 3.0;

/// Parameters of the chaser.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Chaser {
    /// Mass after the shot [kg].
    pub mass_kg: Positive,
    /// Moments of inertia about axes through its centre of mass along X, Y and Z [kg m^2].
    pub inertia_kg_m2: [Positive; 3],
    /// Its centre of mass; the origin is the middle of the net's container [m].
    #[serde(default)]
    pub centre_m: [f64; 3],
    /// Standard deviation of a bullet's speed [m/s].
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub speed_sigma_m_s: f64,
    /// Standard deviation of a bullet's direction, about each of two axes across it [deg].
    #[serde(default)]
    #[schemars(range(min = 0, max = 30))]
    pub angle_sigma_deg: f64,
    /// Seed of the deviations.
    #[serde(default)]
    pub seed: u64,
}

/// How the chaser recoiled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChaserSummary {
    /// Velocity just after the shot [m/s].
    pub recoil_m_s: [f64; 3],
    /// Angular velocity just after the shot, body frame [rad/s].
    pub recoil_rad_s: [f64; 3],
    /// Displacement of its centre of mass at the end [m].
    pub displacement_m: [f64; 3],
    /// Angle it has turned through at the end, about one axis [rad].
    pub turned_rad: f64,
}

impl Chaser {
    /// The chaser just after the shot of `net`.
    pub fn recoiled(&self, net: &Net) -> Body {
        let centre = Vector3::from(self.centre_m);
        let shots = net.mass.iter().zip(&net.launch_velocity).zip(&net.folded);
        let (mut impulse, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for ((mass, velocity), position) in shots {
            impulse -= *mass * velocity;
            moment -= (position - centre).cross(&(*mass * velocity));
        }
        self.recoiled_by(impulse, moment)
    }

    /// The same of elements, between whose knots the shot moves all in a line.
    fn recoiled_of_elements(&self, net: &Net, elements: &ElementNet) -> Body {
        let knots = Knots { position: net.folded.clone(), velocity: net.launch_velocity.clone() };
        let NetTotals { momentum, angular_momentum, .. } =
            elements.motion(&knots, &elements.straight(&knots));
        self.recoiled_by(-momentum, Vector3::from(self.centre_m).cross(&momentum) - angular_momentum)
    }

    /// The chaser after an impulse [N s] and a moment about its centre of mass [N m s].
    fn recoiled_by(&self, impulse: Vector3<f64>, moment: Vector3<f64>) -> Body {
        Body {
            position: self.centre_m.into(),
            attitude: UnitQuaternion::identity(),
            velocity: impulse / self.mass_kg.0,
            rate: moment.component_div(&self.inertia().diagonal()),
        }
    }

    /// About its centre of mass [kg m^2].
    fn inertia(&self) -> Matrix3<f64> {
        Matrix3::from_diagonal(&self.inertia_kg_m2.map(|moment| moment.0).into())
    }
}

/// The axis that `along` lies least along.
fn least_axis(along: &Vector3<f64>) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[along.abs().imin()] = 1.0;
    axis
}

impl Parameters for Chaser {
    const ROWS: &'static [SummaryRow] = &[
        SummaryRow::new("recoil_m_s", "recoil", "mm/s").scaled(1e3),
        SummaryRow::new("recoil_rad_s", "spin by the shot (body)", "mrad/s").scaled(1e3),
        SummaryRow::new("turned_rad", "turned through", "rad"),
    ];

    fn summary(generator: &mut SchemaGenerator) -> Option<Schema> {
        Some(generator.subschema_for::<ChaserSummary>())
    }

    fn load(&mut self, _files: &Files, place: &str, problems: &mut Problems) {
        let [x, y, z] = self.inertia_kg_m2.map(|moment| moment.0);
        let largest = x.max(y).max(z);
        if largest > (x + y + z - largest) * (1.0 + 1e-6) {
            let found = format!("[{x}, {y}, {z}]");
            problems.add(join(place, "inertia_kg_m2"), found, "none above the sum of the other two");
        }
    }

    fn ask(&self, options: &mut BuildOptions) {
        options.port_of = Some(NAME);
    }

    fn disperse(&self, shots: [Vector3<f64>; 4], member: u64) -> [Vector3<f64>; 4] {
        if self.speed_sigma_m_s == 0.0 && self.angle_sigma_deg == 0.0 {
            return shots;
        }
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(member);
        let normal = Normal::standard();
        let (low, high) = (normal.cdf(-CUT), normal.cdf(CUT));
        // The same draws whichever deviations are zero, so that one can be changed alone.
        let mut deviation = || normal.inverse_cdf(random.random_range(low..high));
        shots.map(|shot| {
            let speed = shot.norm();
            let along = if speed > 0.0 { shot / speed } else { Vector3::x() };
            let across = along.cross(&least_axis(&along)).normalize();
            let faster = self.speed_sigma_m_s * deviation();
            let turn = self.angle_sigma_deg.to_radians()
                * (deviation() * across + deviation() * along.cross(&across));
            (speed + faster) * (UnitQuaternion::from_scaled_axis(turn) * along)
        })
    }

    fn build(&self, context: &BuildContext<'_>) -> Interaction {
        let elements = step::method(context.solver).elements(context.net, context.solver);
        let start = match elements {
            Some(elements) => self.recoiled_of_elements(context.net, &elements),
            None => self.recoiled(context.net),
        };
        let about = format!("a free body of {} kg outside the engine", self.mass_kg.0);
        let model = BodyModel::new(NAME, Motion::Free, self.mass_kg.0, self.inertia());
        let model = model.with_port(-Vector3::from(self.centre_m));
        Interaction::new(NAME, about, Recoiling { start }).with_body(model, start)
    }
}

/// The chaser under way.
struct Recoiling {
    start: Body,
}

impl Recoiling {
    fn body(state: &State) -> Option<&Body> {
        state.find_body(NAME).map(|index| &state.bodies[index])
    }
}

impl Effect for Recoiling {
    fn observer(&mut self) -> Option<&mut dyn StepObserver> {
        Some(self)
    }

    fn output(&mut self) -> Option<&mut dyn EffectOutput> {
        Some(self)
    }
}

impl StepObserver for Recoiling {
    /// The simulation moves it, and the audit counts what it has.
    fn end_of_step(&mut self, _before: &State, _after: &State) -> EffectWork {
        EffectWork { count: 1, ..EffectWork::default() }
    }
}

impl EffectOutput for Recoiling {
    fn columns(&self) -> Vec<String> {
        ["x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s", "spin_x_rad_s", "spin_y_rad_s", "spin_z_rad_s"]
            .map(|name| format!("chaser_{name}"))
            .into()
    }

    fn values(&mut self, state: &State) -> Vec<f64> {
        let vectors =
            Recoiling::body(state).into_iter().flat_map(|body| [body.position, body.velocity, body.spin()]);
        vectors.flat_map(|vector| [vector.x, vector.y, vector.z]).collect()
    }

    fn report(&self, end: &State) -> Report {
        let (Some(end), start) = (Recoiling::body(end), &self.start) else { return Report::default() };
        Report::default().with_numbers(&ChaserSummary {
            recoil_m_s: start.velocity.into(),
            recoil_rad_s: start.spin().into(),
            displacement_m: (end.position - start.position).into(),
            turned_rad: end.attitude.angle(),
        })
    }
}
