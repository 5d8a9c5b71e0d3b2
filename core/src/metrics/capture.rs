//! How well the target is captured, frame by frame.
//!
//! | curve | definition |
//! |---|---|
//! | enclosed | share of the target's volume inside the convex hull of the knots, by fixed quasi-random points in its parts |
//! | mouth | vector area of the perimeter polygon over the designed area |
//! | mouth hull, gather, coverage | see [`super::mouth`] |
//! | separation | distance of the centres of mass of net and target over the target's characteristic length |
//! | cqi | capture quality index, w₁ \|Vₙ − Vₜ\| / Vₜ + w₂ \|Sₙ − Sₜ\| / Sₜ + w₃ \|qₙ\| / L, with volume V and surface S of the convex hulls of net and target and qₙ the distance of their centres of mass; 0 is ideal (Barnes and Botta 2020; the weights are from memory, hence parameters) |
//! | relative energy | kinetic energy of the net in the frame that moves and turns with the target, over the launch energy |
//! | turns | angle that the target has turned through since the start, ∫ \|ω\| dt / 2π |
//!
//! The characteristic length L is the longest side of the target's box in its body axes. The source
//! calls a target captured when the net closes and fully embraces it (Section 5.2), without a
//! number; ours are those of the scene's `capture`, and what is made of them is [`super::verdict`]'s.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::inside::Inside;
use super::mouth;
use crate::case::Case;
use crate::geometry::Hull;
use crate::run::{Frames, Run};
use crate::state::Body;
use crate::target::Target;

/// The curves, a value a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    /// [-]
    pub enclosed: Vec<f64>,
    /// [-]
    pub mouth: Vec<f64>,
    /// [-]
    pub mouth_hull: Vec<f64>,
    /// [-]
    pub gather: Vec<f64>,
    /// [-]
    pub coverage: Vec<f64>,
    /// [-]
    pub separation: Vec<f64>,
    /// [-]
    pub cqi: Vec<f64>,
    /// [-]
    pub relative_energy: Vec<f64>,
    /// [-]
    pub turns: Vec<f64>,
    /// Distance of the nearest knot from the target's bounding sphere; negative within it [m].
    pub clearance: Vec<f64>,
    /// Cables that go through the target; see [`super::inside`].
    pub cables_inside: Vec<usize>,
}

impl Curves {
    /// The curves of `run`; empty without a target.
    pub fn of(case: &Case, run: &Run) -> Curves {
        let mut curves = Curves::default();
        curves.extend(case, &run.frames);
        curves
    }

    /// Adds the values of those of `frames` that have none yet.
    pub fn extend(&mut self, case: &Case, frames: &Frames) {
        let Some(target) = case.target() else { return };
        let inside = Inside::of(target);
        // A net that is not shot has no scale: its energy in J stands for itself.
        let energy_scale = Some(case.net().launch_energy()).filter(|energy| *energy > 0.0).unwrap_or(1.0);
        for frame in self.enclosed.len()..frames.target.len() {
            let (knots, body) = (&frames.knots[frame], &frames.target[frame]);
            let hull = Hull::of(knots);
            let distance = (centre_of_mass(&case.net().mass, knots) - body.position).norm();
            let separation = distance / target.characteristic_length;
            let (volume, surface) = hull.as_ref().map_or((0.0, 0.0), |hull| (hull.volume(), hull.surface()));
            let [w_volume, w_surface, w_distance] = case.scene().capture.cqi_weights;
            self.enclosed.push(hull.map_or(0.0, |hull| enclosed(target, body, &hull)));
            self.mouth.push(mouth::vector_area_share(case.net(), knots));
            self.mouth_hull.push(mouth::planar_hull_share(case.net(), knots));
            self.gather.push(mouth::gather(case.net(), knots));
            self.coverage.push(mouth::coverage(&body.position, knots));
            self.cables_inside.push(match frames.lines.get(frame) {
                Some(lines) => inside.count_lines(lines, body),
                None => inside.count(&case.net().cables, knots, body),
            });
            self.separation.push(separation);
            self.cqi.push(
                w_volume * (volume - target.hull_volume).abs() / target.hull_volume
                    + w_surface * (surface - target.hull_surface).abs() / target.hull_surface
                    + w_distance * separation,
            );
            self.relative_energy.push(frames.relative_energy[frame] / energy_scale);
            self.turns.push(turned(self.turns.last(), frames, frame));
            let nearest = knots.iter().map(|knot| (knot - body.position).norm()).fold(f64::MAX, f64::min);
            self.clearance.push(nearest - target.bounding_radius);
        }
    }
}

/// Turns of the target up to `frame`, after `before` at the frame before [-].
fn turned(before: Option<&f64>, frames: &Frames, frame: usize) -> f64 {
    before.map_or(0.0, |before| {
        let rate = 0.5 * (frames.target[frame - 1].rate.norm() + frames.target[frame].rate.norm());
        before + rate * (frames.time[frame] - frames.time[frame - 1]) / TAU
    })
}

/// Share of the target inside the hull of the knots [-].
fn enclosed(target: &Target, body: &Body, hull: &Hull) -> f64 {
    // Many faces have all of the target behind them, and one before it all is in front of most of a flying net.
    let Some(hull) = hull.cutting(&body.position, target.bounding_radius) else { return 0.0 };
    let inside = |sample: &&Vector3<f64>| hull.contain(&(body.position + body.attitude * *sample));
    target.samples.iter().filter(inside).count() as f64 / target.samples.len() as f64
}

fn centre_of_mass(mass: &[f64], knots: &[Vector3<f64>]) -> Vector3<f64> {
    let weighted: Vector3<f64> = mass.iter().zip(knots).map(|(mass, x)| *mass * x).sum();
    weighted / mass.iter().sum::<f64>()
}
