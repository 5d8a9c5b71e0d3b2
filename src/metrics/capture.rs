//! Is it captured? Four curves and a verdict.
//!
//! | curve | definition |
//! |---|---|
//! | enclosed | share of the target's volume inside the convex hull of the knots, by fixed quasi-random points in its parts |
//! | mouth | vector area of the perimeter polygon over the designed area |
//! | separation | distance of the centres of mass of net and target over the target's characteristic length |
//! | cqi | capture quality index, w₁ \|Vₙ − Vₜ\| / Vₜ + w₂ \|Sₙ − Sₜ\| / Sₜ + w₃ \|qₙ\| / L, with volume V and surface S of the convex hulls of net and target and qₙ the distance of their centres of mass; 0 is ideal (Barnes and Botta 2020; the weights are from memory, hence parameters) |
//!
//! The characteristic length L is the longest side of the target's box in its body axes. The source
//! calls a target captured when the net closes and fully embraces it (Section 5.2), without a
//! number; ours are those of the scene's `capture`.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::inside::Inside;
use crate::case::Case;
use crate::geometry::{Hull, vector_area};
use crate::run::Run;
use crate::scene::schema::CaptureRule;
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
    pub separation: Vec<f64>,
    /// [-]
    pub cqi: Vec<f64>,
    /// Cables that go through the target; see [`super::inside`].
    pub cables_inside: Vec<usize>,
}

/// Why a target counts as captured or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// Enclosed behind a closed mouth to the end.
    Held,
    /// Never enclosed.
    Missed,
    /// Enclosed, then lost.
    Slipped,
    /// Enclosed, but the mouth is too wide.
    Open,
}

/// The verdict and the curves' values at the end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Capture {
    /// The verdict.
    pub captured: bool,
    /// Why.
    pub reason: Reason,
    /// From when on both conditions held to the end [s]; null when they do not.
    pub captured_at_s: Option<f64>,
    /// Enclosed share of the target [-].
    pub enclosed: f64,
    /// Mouth over designed area [-].
    pub mouth: f64,
    /// Separation over the target's characteristic length [-].
    pub separation: f64,
    /// Capture quality index [-].
    pub cqi: f64,
}

impl Curves {
    /// The curves of `run`; empty without a target.
    pub fn of(case: &Case, run: &Run) -> Curves {
        let mut curves = Curves::default();
        let Some(target) = &case.target else { return curves };
        let inside = Inside::of(target);
        for (knots, body) in run.frames.knots.iter().zip(&run.frames.target) {
            let hull = Hull::of(knots);
            let distance = (centre_of_mass(&case.net.mass, knots) - body.position).norm();
            let separation = distance / target.characteristic_length;
            let (volume, surface) = hull.as_ref().map_or((0.0, 0.0), |hull| (hull.volume(), hull.surface()));
            let [w_volume, w_surface, w_distance] = case.scene.capture.cqi_weights;
            curves.enclosed.push(hull.map_or(0.0, |hull| enclosed(target, body, &hull)));
            curves.mouth.push(mouth(case, knots));
            curves.cables_inside.push(inside.count(&case.net.cables, knots, body));
            curves.separation.push(separation);
            curves.cqi.push(
                w_volume * (volume - target.hull_volume).abs() / target.hull_volume
                    + w_surface * (surface - target.hull_surface).abs() / target.hull_surface
                    + w_distance * separation,
            );
        }
        curves
    }
}

/// Share of the target inside the hull of the knots [-].
fn enclosed(target: &Target, body: &Body, hull: &Hull) -> f64 {
    let inside = |sample: &&Vector3<f64>| hull.contains(&(body.position + body.attitude * *sample));
    target.samples.iter().filter(inside).count() as f64 / target.samples.len() as f64
}

/// Mouth over designed area [-].
fn mouth(case: &Case, knots: &[Vector3<f64>]) -> f64 {
    vector_area(case.net.perimeter.iter().map(|&knot| knots[knot])).norm() / case.net.designed_area
}

fn centre_of_mass(mass: &[f64], knots: &[Vector3<f64>]) -> Vector3<f64> {
    let weighted: Vector3<f64> = mass.iter().zip(knots).map(|(mass, x)| *mass * x).sum();
    weighted / mass.iter().sum::<f64>()
}

impl Capture {
    /// The verdict on `curves`, whose frames are at `times` [s]; nothing without a target.
    pub fn of(rule: &CaptureRule, times: &[f64], curves: &Curves) -> Option<Capture> {
        let last = curves.enclosed.len().checked_sub(1)?;
        let enclosed = |i: usize| curves.enclosed[i] >= rule.enclosed_min;
        let holds = |i: usize| enclosed(i) && curves.mouth[i] <= rule.mouth_max;
        // The frames that must hold: the last one, and all since `hold_s` before it.
        let hold_from = times.partition_point(|&t| t < times[last] - rule.hold_s - 1e-9).min(last);
        let captured = (hold_from..=last).all(holds);
        let reason = if captured {
            Reason::Held
        } else if !(0..=last).any(enclosed) {
            Reason::Missed
        } else if !(hold_from..=last).all(enclosed) {
            Reason::Slipped
        } else {
            Reason::Open
        };
        let held_since = (0..=last).rev().take_while(|&i| holds(i)).last();
        Some(Capture {
            captured,
            reason,
            captured_at_s: held_since.filter(|_| captured).map(|i| times[i]),
            enclosed: curves.enclosed[last],
            mouth: curves.mouth[last],
            separation: curves.separation[last],
            cqi: curves.cqi[last],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(enclosed: &[f64], mouth: &[f64]) -> Capture {
        let n = enclosed.len();
        let curves = Curves {
            enclosed: enclosed.to_vec(),
            mouth: mouth.to_vec(),
            separation: vec![0.0; n],
            cqi: vec![0.0; n],
            cables_inside: vec![0; n],
        };
        let times: Vec<f64> = (0..n).map(|i| 0.1 * i as f64).collect();
        Capture::of(&CaptureRule { hold_s: 0.2, ..CaptureRule::default() }, &times, &curves).unwrap()
    }

    #[test]
    fn each_reason_has_its_case() {
        let held = verdict(&[0.0, 0.9, 0.9, 0.9], &[1.0, 0.1, 0.1, 0.1]);
        assert_eq!((held.captured, held.reason, held.captured_at_s), (true, Reason::Held, Some(0.1)));
        assert_eq!(verdict(&[0.0, 0.1, 0.2, 0.3], &[1.0, 0.1, 0.1, 0.1]).reason, Reason::Missed);
        assert_eq!(verdict(&[0.0, 0.9, 0.9, 0.3], &[1.0, 0.1, 0.1, 0.1]).reason, Reason::Slipped);
        let open = verdict(&[0.0, 0.9, 0.9, 0.9], &[1.0, 0.1, 0.3, 0.1]);
        assert_eq!((open.captured, open.reason, open.captured_at_s), (false, Reason::Open, None));
    }
}
