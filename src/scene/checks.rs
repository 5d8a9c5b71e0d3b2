//! Faults that no single value shows: limits between sections of a scene.

use super::schema::Scene;
use crate::case;
use crate::closing::trigger::Trigger;
use crate::metrics::summary::Summary;
use crate::net::Net;
use crate::problems::Problems;
use crate::solver::{CableModel, ContactModel, JOINTS_STEP};
use crate::target::Target;
use crate::target::spec::Motion;

/// Most steps of a run.
pub const MAX_STEPS: f64 = 1e8;

/// Most recorded knot positions of a run (24 bytes each).
pub const MAX_RECORDED: f64 = 1e8;

/// Largest turn of a target within a step [rad]; the engine clips rotation at 45 degrees a step.
const MAX_TURN: f64 = 0.25 * std::f64::consts::PI;

/// Checks time, output and expectations of a scene.
pub fn check_scene(scene: &Scene, problems: &mut Problems) {
    let duration = scene.duration_s.0;
    let step = scene.solver.step_s.map_or(JOINTS_STEP.min(duration), |step| step.0);
    if step > duration {
        problems.add("solver.step_s", step, format!("at most duration_s, {duration}"));
    } else if duration / step > MAX_STEPS {
        problems.add(
            "duration_s",
            format!("{duration}, {:.3e} steps", duration / step),
            format!("at most {MAX_STEPS:.0e} steps: shorten it or lengthen solver.step_s"),
        );
    }
    if scene.output.sample_s.0 > duration {
        problems.add("output.sample_s", scene.output.sample_s.0, format!("at most duration_s, {duration}"));
    }
    if scene.target.is_some() && scene.capture.hold_s > duration {
        problems.add("capture.hold_s", scene.capture.hold_s, format!("at most duration_s, {duration}"));
    }
    if scene.target.is_none() && scene.expect.captured.is_some() {
        problems.add("expect.captured", "a verdict without a target", "a scene with a target");
    }
    check_solver(scene, problems);
    let needs_target = |trigger: Option<Trigger>| trigger.is_some_and(|trigger| trigger.needs_target());
    for (place, trigger) in [
        ("effects.closing.trigger.on", scene.effects.closing.map(|closing| closing.trigger)),
        ("effects.tug.start.on", scene.effects.tug.map(|tug| tug.start)),
    ] {
        if scene.target.is_none() && needs_target(trigger) {
            problems.add(
                place,
                "a trigger that waits for a target",
                "\"time\" or \"mouth\" without a target",
            );
        }
    }
    if scene.effects.tug.is_some_and(|tug| tug.direction == [0.0; 3]) {
        problems.add("effects.tug.direction", "[0, 0, 0]", "a direction of any length but 0");
    }
    let known = Summary::scalar_names();
    for (name, [low, high]) in &scene.expect.within {
        let place = format!("expect.within.{name}");
        if !known.contains(name) {
            problems.add(&place, "no number of the summary", known.join(", "));
        }
        if low > high {
            problems.add(&place, format!("[{low}, {high}]"), "a band [low, high] with low at most high");
        }
    }
}

/// Checks that the parts of the method go together.
fn check_solver(scene: &Scene, problems: &mut Problems) {
    let solver = &scene.solver;
    let own_contact = solver.contact != ContactModel::Rapier;
    if solver.cables == CableModel::Explicit && !own_contact {
        problems.add(
            "solver.contact",
            "\"rapier\" with explicit cables",
            "\"impulse\" or \"penalty\": the engine answers contacts only of bodies that it moves itself",
        );
    }
    if solver.cables == CableModel::Joints && own_contact && solver.substeps > 1 {
        problems.add(
            "solver.substeps",
            format!("{} with a contact response of our own", solver.substeps),
            "1: such a response acts once a step of the engine; shorten solver.step_s instead",
        );
    }
    if solver.contact == ContactModel::Penalty && solver.restitution > 0.0 {
        problems.add(
            "solver.restitution",
            format!("{} with \"penalty\"", solver.restitution),
            "0: a penalty force bounces by solver.penalty.alpha_s_m",
        );
    }
}

/// Checks what net and target allow the solver, whose steps take `step` seconds.
pub fn check_built(scene: &Scene, net: &Net, target: Option<&Target>, step: f64, problems: &mut Problems) {
    let stable = case::stable_step(scene, net, target);
    if let Some(given) = scene.solver.step_s.filter(|given| given.0 > stable) {
        problems.add(
            "solver.step_s",
            given.0,
            format!("at most {stable:.3e} s, the stable step of this net and contact; left out, a safe one is chosen"),
        );
    }
    let n_frames = scene.duration_s.0 / scene.output.sample_s.0.max(step);
    if n_frames * net.n_knots() as f64 > MAX_RECORDED {
        problems.add(
            "output.sample_s",
            format!("{}, {n_frames:.0} frames of {} knots", scene.output.sample_s.0, net.n_knots()),
            format!("at most {MAX_RECORDED:.0e} recorded positions: sample less often"),
        );
    }
    let Some(target) = target else { return };
    let turn = target.spin.norm() * step;
    if target.motion != Motion::Fixed && turn > MAX_TURN {
        problems.add(
            "target.spin_rad_s",
            format!("{:.4} rad/s, {turn:.3} rad a step", target.spin.norm()),
            format!(
                "at most {MAX_TURN:.3} rad a step: a step of at most {:.3e} s",
                MAX_TURN / target.spin.norm()
            ),
        );
    }
    // A knot past the middle of a part is pushed out on its far side.
    let speed = scene.launch.speed_m_s + target.spin.norm() * target.bounding_radius;
    if speed * step > 0.5 * target.thinnest {
        problems.add(
            "solver.step_s",
            format!("{step}: at {speed:.3} m/s a knot moves {:.3e} m within it", speed * step),
            format!(
                "at most {:.3e} s: half the thinnest part of the target, {:.3e} m, in a step",
                0.5 * target.thinnest / speed,
                target.thinnest
            ),
        );
    }
}
