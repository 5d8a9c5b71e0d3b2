//! Drag of the air that a net is tried in: a cabin on a parabola, a hall, thin air.
//!
//! Cables are cylinders in cross flow (Hoerner, Fluid-Dynamic Drag, 1965, chapter III): only the part w⟂ of the air's
//! velocity relative to the cable that is across it drags,
//!
//! F = ½ ρ C d l₀ |w⟂| w⟂,
//!
//! shared by the cable's ends; a slack cable is taken to hang in the flow with all its length, along the line between its
//! ends. Bullets are balls, F = ½ ρ C (π D² / 4) |w| w; a target is a drag area C A at its centre of mass. Nothing shades
//! another, and no air is carried along.
//!
//! Forces are held over a step. What quadratic drag does to a free body within one, v / (1 + κ v h), makes its mean
//! force that at the start over 1 + κ v h, which holds for any step; so each knot's is taken.

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Parameters;
use crate::cable::Cable;
use crate::interaction::{ForceElement, Interaction};
use crate::options::{BuildContext, BuildOptions};
use crate::quantity::Positive;
use crate::state::{Forces, State, TARGET};

/// Density of the steel that a bullet without a diameter is a ball of [kg/m^3].
const STEEL: f64 = 7850.0;

/// Parameters of drag.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drag {
    /// Density of the air [kg/m^3].
    pub density_kg_m3: Positive,
    /// Drag coefficient of cables in cross flow [-].
    #[serde(default = "Drag::of_a_cylinder")]
    #[schemars(range(min = 0, max = 10))]
    pub cable_coefficient: f64,
    /// Drag coefficient of bullets [-].
    #[serde(default = "Drag::of_a_ball")]
    #[schemars(range(min = 0, max = 10))]
    pub bullet_coefficient: f64,
    /// Diameter of bullets; left out: that of a ball of steel with their mass [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bullet_diameter_m: Option<Positive>,
    /// Drag coefficient of the target times its area across the flow [m^2].
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub target_drag_area_m2: f64,
    /// Velocity of the air in the local frame [m/s].
    #[serde(default)]
    pub wind_m_s: [f64; 3],
}

impl Drag {
    fn of_a_cylinder() -> f64 {
        1.1
    }

    fn of_a_ball() -> f64 {
        0.47
    }
}

impl Parameters for Drag {
    fn ask(&self, options: &mut BuildOptions) {
        options.drags = true;
    }

    fn build(&self, context: &BuildContext<'_>) -> Interaction {
        let net = context.net;
        let half_density = 0.5 * self.density_kg_m3.0;
        let of_cable = |(index, cable): (usize, &Cable)| {
            half_density * self.cable_coefficient * 2.0 * net.cable_radius(index) * cable.rest_length
        };
        let of_bullet = |knot: usize| {
            let steel = (6.0 * net.mass[knot] / (PI * STEEL)).cbrt();
            let diameter = self.bullet_diameter_m.map_or(steel, |diameter| diameter.0);
            half_density * self.bullet_coefficient * 0.25 * PI * diameter * diameter
        };
        let about = format!("drag of air on {} cables and 4 bullets", net.cables.len());
        Interaction::force(
            "drag",
            about,
            Air {
                wind: self.wind_m_s.into(),
                of_cables: net.cables.iter().enumerate().map(of_cable).collect(),
                cables: Arc::clone(&net.cables),
                mass: net.mass.clone(),
                bullets: net.bullets.map(|knot| (knot, of_bullet(knot))),
                delay: net.delay,
                of_target: half_density * self.target_drag_area_m2,
                step: context.time_step.step,
                rate: vec![0.0; net.n_knots()],
            },
        )
    }
}

/// Air at work: force over |w| w of each thing it drags [kg/m].
struct Air {
    /// Its velocity [m/s].
    wind: Vector3<f64>,
    cables: Arc<[Cable]>,
    of_cables: Vec<f64>,
    /// Of each knot [kg].
    mass: Vec<f64>,
    /// Knots of the bullets.
    bullets: [(usize, f64); 4],
    /// When each bullet leaves its barrel [s].
    delay: [f64; 4],
    of_target: f64,
    /// Step that forces are held over [s].
    step: f64,
    /// Of each knot: force over speed relative to the air and mass [1/s]; kept for its memory.
    rate: Vec<f64>,
}

impl ForceElement for Air {
    fn add_forces(&mut self, state: &State, forces: &mut Forces) {
        let (position, velocity) = (&state.knots.position, &state.knots.velocity);
        self.rate.fill(0.0);
        for (cable, of_cable) in self.cables.iter().zip(&self.of_cables) {
            let (a, b) = (cable.a, cable.b);
            let relative = self.wind - 0.5 * (velocity[a] + velocity[b]);
            let along = (position[b] - position[a]).try_normalize(0.0).unwrap_or_default();
            let across = relative - along.dot(&relative) * along;
            let half = 0.5 * of_cable * across.norm();
            for knot in [a, b] {
                forces.on_knots[knot] += half * across;
                self.rate[knot] += half / self.mass[knot];
            }
        }
        for (&(knot, of_bullet), delay) in self.bullets.iter().zip(self.delay) {
            if state.time >= delay {
                let relative = self.wind - velocity[knot];
                let size = of_bullet * relative.norm();
                forces.on_knots[knot] += size * relative;
                self.rate[knot] += size / self.mass[knot];
            }
        }
        for (force, rate) in forces.on_knots.iter_mut().zip(&self.rate) {
            *force /= 1.0 + self.step * rate;
        }
        if let (Some(body), Some(model)) = (state.target(), state.body_models.get(TARGET)) {
            let relative = self.wind - body.velocity;
            let size = self.of_target * relative.norm();
            forces.on_bodies[TARGET].force += size / (1.0 + self.step * size / model.mass) * relative;
        }
    }

    fn resists_in(&self) -> Option<Vector3<f64>> {
        Some(self.wind)
    }
}
