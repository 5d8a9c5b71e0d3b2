//! Faults that no single value shows: limits between sections of a scene.

use super::schema::Scene;
use super::{clear, estimate};
use crate::closing::trigger::Trigger;
use crate::effects::chaser;
use crate::limits::{Limit, Limits};
use crate::net::{Net, spec};
use crate::options::TimeStep;
use crate::problems::Problems;
use crate::solver::{CableModel, ContactModel, Integrator, JOINTS_STEP, Precision};
use crate::step::limits::{Demands, StepLimits};
use crate::step::mass_spring::stability::{self, RESOLVES};
use crate::target::Target;
use crate::target::spec::Motion;

/// Names of all numbers of a summary, as its own test writes them: a scene may expect any of them.
pub const SUMMARY_NAMES: &str = include_str!("summary_names.txt");

/// Most explicit sub-steps within a step of the engine; real nets have some hundred.
const MAX_PARTS: f64 = 1e5;

/// Largest turn of a target within a step [rad]; the engine clips rotation at 45 degrees a step.
const MAX_TURN: f64 = 0.25 * std::f64::consts::PI;

/// Checks time, output and expectations of a scene.
pub fn check_scene(scene: &Scene, limits: &Limits, problems: &mut Problems) {
    let duration = scene.duration_s.0;
    let step = scene.solver.step_s.map_or(JOINTS_STEP.min(duration), |step| step.0);
    if step > duration {
        problems.add("solver.step_s", step, format!("at most duration_s, {duration}"));
    } else {
        check_steps(duration, step, limits, problems);
    }
    if scene.output.sample_s.0 > duration {
        problems.add("output.sample_s", scene.output.sample_s.0, format!("at most duration_s, {duration}"));
    }
    if scene.target.is_some() && scene.capture.hold_s > duration {
        problems.add("capture.hold_s", scene.capture.hold_s, format!("at most duration_s, {duration}"));
    }
    for (place, is_asked) in [
        ("expect.captured", scene.expect.captured.is_some()),
        ("expect.verdict", scene.expect.verdict.is_some()),
    ] {
        if scene.target.is_none() && is_asked {
            problems.add(place, "a verdict without a target", "a scene with a target");
        }
    }
    check_solver(scene, problems);
    check_elements(scene, problems);
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
    check_frame(scene, problems);
    if scene.effects.tug.is_some_and(|tug| tug.direction == [0.0; 3]) {
        problems.add("effects.tug.direction", "[0, 0, 0]", "a direction of any length but 0");
    }
    let known: Vec<&str> = SUMMARY_NAMES.lines().collect();
    for (name, [low, high]) in &scene.expect.within {
        let place = format!("expect.within.{name}");
        if !known.contains(&name.as_str()) {
            problems.add(&place, "no number of the summary", known.join(", "));
        }
        if low > high {
            problems.add(&place, format!("[{low}, {high}]"), "a band [low, high] with low at most high");
        }
    }
}

/// Checks the number of steps; a fault that is known already is not told again.
fn check_steps(duration: f64, step: f64, limits: &Limits, problems: &mut Problems) {
    let n_steps = duration / step;
    if limits.exceeded(Limit::Steps, n_steps) && !problems.list.iter().any(|p| p.place == "duration_s") {
        let found = format!("{duration}, {n_steps:.3e} steps of {step:.3e} s");
        problems.add("duration_s", found, limits.allowed(Limit::Steps));
    }
}

/// Whether a net has as few knots as it may, before it is built.
pub fn check_knots(net: &spec::NetSpec, limits: &Limits, problems: &mut Problems) -> bool {
    let n_knots = net.n_knots();
    let too_many = limits.exceeded(Limit::Knots, n_knots as f64);
    if too_many {
        let found = format!("a net of {n_knots} knots");
        let allowed = format!("{}; use fewer meshes or middle knots", limits.allowed(Limit::Knots));
        problems.add("net.meshes", found, allowed);
    }
    !too_many
}

/// Checks what says where the local frame is, and who shoots.
fn check_frame(scene: &Scene, problems: &mut Problems) {
    let effects = &scene.effects;
    if effects.orbit.is_some() && effects.cabin.is_some() {
        problems.add(
            "effects.cabin",
            "a cabin and an orbit",
            "one of them: the local frame is fixed either in a cabin or on an orbit",
        );
    }
    for (bullet, faster) in scene.launch.bullets.speed_m_s.into_iter().enumerate() {
        if scene.launch.speed_m_s + faster < 0.0 {
            let place = format!("launch.bullets.speed_m_s[{bullet}]");
            problems.add(
                place,
                faster,
                format!("at least -{}: none flies backwards", scene.launch.speed_m_s),
            );
        }
    }
    let Some(chaser) = &effects.chaser else { return };
    let slowest = scene.launch.speed_m_s - chaser::CUT * chaser.speed_sigma_m_s;
    if slowest < 0.0 {
        problems.add(
            "effects.chaser.speed_sigma_m_s",
            format!("{} at launch.speed_m_s {}", chaser.speed_sigma_m_s, scene.launch.speed_m_s),
            format!("at most 1/{} of the speed: deviations go that far", chaser::CUT),
        );
    }
}

/// Checks that the parts of the method go together.
fn check_solver(scene: &Scene, problems: &mut Problems) {
    let solver = &scene.solver;
    let own_contact = solver.contact != ContactModel::Rapier;
    if solver.precision == Precision::F32 && !cfg!(feature = "f32") {
        problems.add(
            "solver.precision",
            "\"f32\"",
            "\"f64\": this program was built without the engine in 32 bits; build it with `--features f32`",
        );
    }
    if solver.cables != CableModel::Joints && !own_contact {
        problems.add(
            "solver.contact",
            "\"rapier\" with cables that the engine does not move",
            "\"impulse\" or \"penalty\": the engine answers contacts only of bodies that it moves itself",
        );
    }
    let by_force = solver.contact == ContactModel::Penalty;
    if solver.cables == CableModel::Joints && by_force && solver.substeps > 1 {
        problems.add(
            "solver.substeps",
            format!("{} with contact by a force of our own", solver.substeps),
            "1: such a force acts once a step of the engine; shorten solver.step_s instead",
        );
    }
    if solver.integrator == Integrator::Implicit && solver.cables != CableModel::Ancf {
        problems.add(
            "solver.integrator",
            "\"implicit\" with cables that are no elements",
            "another, or \"ancf\" cables: \"joints\" are implicit by themselves, and \"explicit\" ones are not",
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

/// Checks that cable elements are not asked for contacts of straight cables: these keep a place between two knots apart, borne by
/// both by the lever rule and their masses. A place of an element is borne by coordinates that are no knots, through the whole
/// mass matrix; its rows are those of the spheres.
fn check_elements(scene: &Scene, problems: &mut Problems) {
    if scene.solver.cables != CableModel::Ancf {
        return;
    }
    let found = "contact of straight cables with \"ancf\" cables, which bend";
    if scene.effects.cable_contact.is_some() {
        problems.add("effects.cable_contact", found, "none: they touch with solver.ancf.spheres on each");
    }
    if scene.effects.self_contact.is_some() {
        problems.add("effects.self_contact", found, "none; use \"joints\" or \"explicit\" cables");
    }
}

/// Checks how many explicit sub-steps the net would take within a step of the engine: a flight takes
/// them, and a step that makes energy is cut into as many parts.
fn check_parts(scene: &Scene, net: &Net, step: f64, problems: &mut Problems) {
    let shortest = step / MAX_PARTS;
    let stable = RESOLVES * stability::stable_step(net);
    if scene.solver.cables == CableModel::Joints && stable < shortest {
        problems.add(
            "solver.step_s",
            format!("{step}, with cables that swing within {stable:.3e} s"),
            format!(
                "a step of at most {MAX_PARTS:.0e} times that: softer cables, heavier knots or a shorter step"
            ),
        );
    }
}

/// Checks what net and target allow the solver, which takes these `steps`.
pub fn check_built(
    scene: &Scene,
    demands: &Demands<'_>,
    steps: &StepLimits,
    limits: &Limits,
    problems: &mut Problems,
) {
    let Demands { net, target, .. } = *demands;
    let (step, stable) = (steps.chosen.step, steps.stable);
    if let Some(given) = scene.solver.step_s.filter(|given| given.0 > stable) {
        problems.add(
            "solver.step_s",
            given.0,
            format!("at most {stable:.3e} s, the stable step of this net and contact; left out, a safe one is chosen"),
        );
    }
    let n_frames = scene.duration_s.0 / scene.output.sample_s.0.max(step);
    let n_positions = n_frames * estimate::positions(scene, net);
    if limits.exceeded(Limit::Positions, n_positions) {
        problems.add(
            "output.sample_s",
            format!("{}, {n_frames:.0} frames of {} knots", scene.output.sample_s.0, net.n_knots()),
            format!("{}: sample less often", limits.allowed(Limit::Positions)),
        );
    }
    // The step that was chosen, where the scene leaves it out.
    let substeps = if scene.solver.cables != CableModel::Joints { steps.chosen.substeps } else { 1 };
    check_steps(scene.duration_s.0, step / f64::from(substeps), limits, problems);
    check_parts(scene, net, step, problems);
    check_ranges(net, target, problems);
    check_estimate(scene, demands, steps.chosen, limits, problems);
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
    clear::knots(net, target, problems);
    if scene.effects.cable_contact.is_some()
        && !problems.list.iter().any(|known| known.place == "target.distance_m")
    {
        clear::cables(net, target, problems);
    }
    check_thin_parts(demands, target, step, problems);
}

/// Checks that no knot crosses half of a part within a step of `step` seconds, by its own speed or as a thread pulls it.
fn check_thin_parts(demands: &Demands<'_>, target: &Target, step: f64, problems: &mut Problems) {
    let (speed, of_pull) = (demands.fastest(), demands.pulled_step());
    // A hair above the limit is the rounding of a step that was chosen by it.
    let exceeds = |limit: f64| step > limit * (1.0 + 1e-9);
    if exceeds(of_pull) {
        problems.add(
            "solver.step_s",
            format!("{step}: a pull of {} N moves the lightest knot through a part within it", demands.options.pull),
            format!(
                "at most {of_pull:.3e} s, in which it moves by half the thinnest part of the target, {:.3e} m",
                target.thinnest
            ),
        );
    }
    if exceeds(demands.thin_step()) {
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

/// Lengths, masses and stiffnesses whose squares and quotients are numbers still [m, kg, N/m].
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-12..=1e12;
const MASSES: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

/// Checks that a run would not begin with what is no number.
fn check_ranges(net: &Net, target: Option<&Target>, problems: &mut Problems) {
    let mut check = |place: &str, what: &str, value: Option<f64>, range: std::ops::RangeInclusive<f64>| {
        if let Some(value) = value {
            let allowed = format!("numbers from {:e} to {:e}", range.start(), range.end());
            problems.add(place, format!("{what} of {value:e}"), allowed);
        }
    };
    let cables = || net.cables.iter();
    let length = cables().map(|cable| cable.rest_length).find(|length| !LENGTHS.contains(length));
    check("net.mesh_length_m", "a cable's length [m]", length, LENGTHS);
    let mass = net.mass.iter().copied().find(|mass| !MASSES.contains(mass));
    check("net.cable", "a knot's mass [kg]", mass, MASSES);
    let stiffness = cables().map(|cable| cable.stiffness).find(|stiffness| !MASSES.contains(stiffness));
    check("net.cable", "a cable's stiffness [N/m]", stiffness, MASSES);
    let Some(target) = target else { return };
    let mass = Some(target.mass).filter(|mass| !MASSES.contains(mass));
    check("target.mass_kg", "a mass [kg]", mass, MASSES);
    let distance = Some(target.position.norm()).filter(|distance| *distance > *LENGTHS.end());
    check("target.distance_m", "a distance [m]", distance, 0.0..=*LENGTHS.end());
}

/// Checks what a run will take.
fn check_estimate(
    scene: &Scene,
    demands: &Demands<'_>,
    time_step: TimeStep,
    limits: &Limits,
    problems: &mut Problems,
) {
    let net = demands.net;
    let memory = estimate::memory(scene, demands, time_step);
    let all: f64 = memory.iter().map(|(_, bytes)| bytes).sum();
    if limits.exceeded(Limit::Memory, all)
        && let Some((place, most)) = memory.iter().max_by(|one, other| one.1.total_cmp(&other.1))
        && !problems.list.iter().any(|known| known.place == *place)
    {
        let [all, most] = [all, *most].map(estimate::in_words);
        let found = format!("what takes {most} of an estimated {all}");
        problems.add(*place, found, limits.allowed(Limit::Memory));
    }
    let work = estimate::cable_steps(scene, net, time_step);
    if limits.exceeded(Limit::Work, work) && !problems.list.iter().any(|known| known.place == "duration_s") {
        let found = format!("{}, {work:.3e} cable steps of {} cables", scene.duration_s.0, net.cables.len());
        problems.add("duration_s", found, limits.allowed(Limit::Work));
    }
}
