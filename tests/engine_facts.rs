//! What the engine gets wrong unless it is told otherwise (`core/src/world/settings.rs`), and what our
//! words promise of it. Each test is named after the symptom or the law.

use crate::common::{below, case_of, changed, knots, small_scene, tie, within};
use nalgebra::Vector3;
use serde_json::{Value, json};
use tumblenet::case::Case;
use tumblenet::contact::engine::EngineContacts;
use tumblenet::failure::{Culprit, Failure};
use tumblenet::friction::Law;
use tumblenet::net::Net;
use tumblenet::simulation::Simulation;
use tumblenet::state::{Contact, State};
use tumblenet::target::Target;
use tumblenet::world::{Setup, World};

/// `net` in place of the small scene's, with `changes` to the scene.
fn case_with(net: Net, changes: Value) -> Case {
    let mut scene = small_scene();
    for (key, value) in changes.as_object().unwrap() {
        scene[key] = value.clone();
    }
    changed(case_of(scene), |built| built.net = net)
}

/// A target from one part, at the origin.
fn target(part: Value, motion: &str) -> Target {
    let mut scene = small_scene();
    // A scene must not start inside its net; these nets are put elsewhere.
    scene["target"] =
        json!({ "shape": { "parts": [part] }, "distance_m": 9.0, "mass_kg": 2.0, "motion": motion });
    let mut target = case_of(scene).target().cloned().unwrap();
    target.position.x = 0.0;
    target
}

/// A plate of 1 m x 1 m across X, its near face at x = 0, and with friction or restitution.
fn plate(motion: &str) -> Target {
    let mut plate = target(json!({ "cuboid": [0.2, 1.0, 1.0] }), motion);
    plate.position.x = 0.1;
    plate
}

const STEP: f64 = 5e-4;

fn setup() -> Setup {
    Setup { step: STEP, friction: None, has_contacts: true, ..Setup::default() }
}

/// A state with this target.
fn with(target: &Target) -> State {
    State::default().with_bodies([(target.model(), target.start())])
}

/// Steps a world of free knots and a target; returns the last state and all contacts.
fn advance(net: &Net, target: &Target, setup: &Setup, n_steps: u32) -> (State, Vec<Contact>) {
    let mut world = World::new(net, Some(target), setup);
    let (mut state, mut contacts, mut all) = (with(target), Vec::new(), Vec::new());
    world.read(&mut state);
    for _ in 0..n_steps {
        world.advance(&mut state, setup.step, 8);
        world.contacts(&mut contacts);
        all.extend(contacts.iter().copied());
    }
    (state, all)
}

/// Without the gyroscopic term the body turns on about its middle axis for ever; in f32 its energy
/// drifts by 4 to 46 %.
#[test]
fn a_body_spun_about_its_middle_axis_flips() {
    let mut scene = small_scene();
    scene["net"]["meshes"] = json!([1, 1]);
    scene["launch"]["speed_m_s"] = json!(0.0);
    scene["solver"] = json!({ "step_s": 0.001 });
    scene["target"] = json!({ "shape": { "parts": [{ "cuboid": [2.5, 10.0, 5.0] }] },
        "mass_kg": 8000.0, "distance_m": 100.0, "spin_rad_s": [0.001, 0.0, 0.2] });
    let case = case_of(scene);
    let inertia = case.target().unwrap().inertia;
    let mut simulation = Simulation::new(&case);
    let start = *simulation.state.target().unwrap();
    let (momentum, energy) = (start.angular_momentum(&inertia), start.kinetic_energy(8000.0, &inertia));
    let (mut least, mut momentum_error, mut energy_error) = (0.2_f64, 0.0_f64, 0.0_f64);
    for _ in 0..300_000 {
        simulation.step().unwrap();
        let body = simulation.state.target().unwrap();
        least = least.min(body.spin().z);
        momentum_error =
            momentum_error.max((body.angular_momentum(&inertia) - momentum).norm() / momentum.norm());
        energy_error = energy_error.max((body.kinetic_energy(8000.0, &inertia) / energy - 1.0).abs());
    }
    within("spin about the middle axis after a flip, rad/s", least, [-0.21, -0.19]);
    below("angular momentum", momentum_error, 2e-4); // measured 1.4e-4
    below("energy", energy_error, 1e-5); // measured 2.2e-8
}

/// The engine puts bodies slower than 0.05 m/s to sleep: 0.04 m/s moved 0.02 m in 10 s.
#[test]
fn slow_knots_do_not_fall_asleep() {
    let mut scene = small_scene();
    scene["launch"] = json!({ "speed_m_s": 0.04, "angle_deg": 0.0 });
    scene["target"] = json!({ "shape": { "parts": [{ "ball": { "radius_m": 0.1 } }] },
        "mass_kg": 1.0, "distance_m": 0.5, "offset_m": [0.0, 0.4], "spin_rad_s": [0.0, 0.0, 0.01] });
    let net = knots(&[(0.01, [0.0; 3], [0.04, 0.0, 0.0])]);
    let mut simulation = Simulation::new(&changed(case_of(scene), |built| built.net = net));
    for _ in 0..20_000 {
        simulation.step().unwrap();
    }
    within("way in 10 s, m", simulation.state.knots.position[0].x, [0.4 - 1e-9, 0.4 + 1e-9]);
    within("slow spin", simulation.state.target().unwrap().spin().z, [0.01 - 1e-12, 0.01 + 1e-12]);
}

/// With recycled contacts a knot floats up to 5 cm past the edge it slid over.
#[test]
fn a_knot_sliding_off_an_edge_does_not_float() {
    let cube = target(json!({ "cuboid": [0.1, 0.1, 0.1] }), "fixed");
    let radius = 5e-4;
    let net = knots(&[(0.01, [0.0, 0.0, 0.05 + radius], [0.2, 0.0, 0.0])]);
    let mut world = World::new(&net, Some(&cube), &setup());
    let (mut state, mut contacts) = (with(&cube), Vec::new());
    world.read(&mut state);
    let pressed = Vector3::new(0.0, 0.0, -0.01 * STEP / net.mass[0]);
    let mut furthest = 0.0_f64;
    for _ in 0..1200 {
        world.set_velocity(0, &(state.knots.velocity[0] + pressed));
        world.advance(&mut state, STEP, 8);
        world.contacts(&mut contacts);
        if contacts.iter().any(|contact| contact.impulse > 0.0) {
            furthest = furthest.max(state.knots.position[0].x);
        }
    }
    // At most a radius past the edge, as a ball rolls over it; then it falls.
    within("last held at x, m", furthest, [0.0499, 0.05 + radius]); // measured 0.0501
    assert!(state.knots.position[0].z < 0.04, "it fell: {}", state.knots.position[0]);
}

/// 10 of 371 knots went through a 2 mm panel with recycled contacts.
#[test]
fn no_knot_goes_through_a_thin_panel() {
    let mut panel = target(json!({ "cuboid": [0.002, 1.0, 1.0] }), "fixed");
    panel.position.x = 0.0;
    let rows: Vec<_> = (0..400)
        .map(|i| {
            let share = f64::from(i) / 400.0;
            // Up to the speed that the checks allow: half the thickness in a step.
            let speed = (0.1 + 0.9 * share) * 0.001 / STEP;
            let [y, z] = [f64::from(i % 20) - 9.5, f64::from(i / 20) - 9.5].map(|n| 0.04 * n);
            (0.001, [-0.02 - 0.01 * share, y, z], [speed, 0.3, 0.2 * share])
        })
        .collect();
    let (state, _) = advance(&knots(&rows), &panel, &setup(), 400);
    let through = state.knots.position.iter().filter(|position| position.x > 0.0).count();
    assert_eq!(through, 0, "of {}", rows.len());
}

/// Impulses were over-reported by earlier engines. Σ J = m Δv for knot and target alike.
#[test]
fn a_contact_impulse_is_the_momentum_it_changes() {
    for (motion, mass) in [("fixed", f64::INFINITY), ("free", 2.0)] {
        let net = knots(&[(0.01, [-0.01, 0.0, 0.0], [1.5, 0.0, 0.0])]);
        let (state, contacts) = advance(&net, &plate(motion), &setup(), 100);
        let impulse: Vector3<f64> = contacts.iter().map(Contact::impulse_on_knot).sum();
        let change = 0.01 * (state.knots.velocity[0] - Vector3::new(1.5, 0.0, 0.0));
        // Both move on together, e = 0.
        let together = if mass.is_finite() { 0.01 * 1.5 / (mass + 0.01) } else { 0.0 };
        let [of_knot, of_target] = [state.knots.velocity[0].x, state.target().unwrap().velocity.x];
        below("impulse less m dv, N s", (impulse - change).norm(), 1e-12); // measured 2e-18
        below("speed of the knot", (of_knot - together).abs(), 1e-6); // measured 3e-14
        below("speed of the target", (of_target - together).abs(), 1e-6);
    }
}

#[test]
fn a_knot_bounces_as_the_restitution_says() {
    for restitution in [0.0, 0.5, 1.0] {
        let net = knots(&[(0.01, [-0.01, 0.0, 0.0], [1.0, 0.4, 0.0])]);
        let plate = plate("fixed");
        let mut world = World::new(&net, Some(&plate), &setup());
        let mut answer = EngineContacts::new(&net, &plate, restitution);
        let mut state = with(&plate);
        world.read(&mut state);
        for _ in 0..100 {
            let before = state.clone();
            world.advance(&mut state, STEP, 8);
            answer.observe(&mut world, &before, &mut state, STEP);
        }
        let velocity = state.knots.velocity[0];
        below("normal speed less -e v", (velocity.x + restitution).abs(), 1e-6); // measured 3e-14
        below("speed across", (velocity.y - 0.4).abs(), 1e-12); // frictionless
    }
}

/// |J_t| = μ J_n against the motion, and never past the standstill.
#[test]
fn friction_slows_a_sliding_knot_by_mu_times_the_normal_impulse() {
    // Normal speed 1 m/s, so J_n / m = 1 m/s.
    for (mu, across, left) in [(0.1, 0.5, 0.4), (0.3, 0.5, 0.2), (0.3, -0.5, -0.2), (0.8, 0.5, 0.0)] {
        let net = knots(&[(0.01, [-0.01, 0.0, 0.0], [1.0, 0.0, across])]);
        let (state, contacts) = advance(
            &net,
            &plate("fixed"),
            &Setup { friction: Some(Law::Coulomb { coefficient: mu }), ..setup() },
            100,
        );
        below("speed left", (state.knots.velocity[0].z - left).abs(), 1e-6); // measured 8e-15
        let friction: Vector3<f64> = contacts.iter().map(|contact| contact.friction).sum();
        below("friction less m dv", (friction.z - 0.01 * (left - across)).abs(), 1e-8);
        below("friction off its line", friction.x.hypot(friction.y), 1e-12);
    }
}

/// Friction's row of the ledger is the loss of kinetic energy across the normal, contact's the loss
/// along it.
#[test]
fn friction_and_contact_each_post_what_they_took() {
    let net = knots(&[(0.01, [-0.01, 0.0, 0.0], [1.0, 0.0, 0.5])]);
    let case = case_with(net, json!({ "effects": { "friction": { "coefficient": 0.3 } } }));
    let case = changed(case, |built| built.target = Some(plate("fixed")));
    let mut simulation = Simulation::new(&case);
    for _ in 0..100 {
        simulation.step().unwrap();
    }
    let ledger = &simulation.audit.ledger;
    let work = 0.5 * 0.01 * (0.2 * 0.2 - 0.5 * 0.5);
    below("work of friction less the change, J", (ledger.effects[0] - work).abs(), 1e-12);
    below("taken by contact less the loss, J", (ledger.contact - 0.5 * 0.01).abs(), 1e-12);
    below("residual, J", ledger.residual().abs(), 1e-12);
}

/// A wall of two parts side by side, its near face at x = 0.
fn wall_with_a_seam() -> Target {
    let mut scene = small_scene();
    scene["target"] = json!({ "shape": { "parts": [
        { "cuboid": [0.2, 0.5, 1.0], "position_m": [0.0, -0.25, 0.0] },
        { "cuboid": [0.2, 0.5, 1.0], "position_m": [0.0, 0.25, 0.0] } ] },
        "distance_m": 9.1, "motion": "fixed" });
    let mut target = case_of(scene).target().cloned().unwrap();
    target.position.x -= 9.0;
    target
}

#[test]
fn a_knot_that_hits_a_seam_of_two_parts_is_stopped_once() {
    let net = knots(&[(0.01, [-0.01, 0.0, 0.0], [1.5, 0.0, 0.0])]);
    let (_, contacts) = advance(&net, &wall_with_a_seam(), &setup(), 100);
    let impulse: f64 = contacts.iter().map(|contact| contact.impulse).sum();
    below("impulse less m v, N s", (impulse - 0.015).abs(), 1e-9); // measured 3e-16
}

/// Known to be wrong, asserted as it is: a knot that slides over a seam bumps. The engine stops a
/// knot at the plane through the nearest point of a part that is still ahead, so a knot that comes
/// a step's way (here its own radius) before the next part meets a ramp that is not there. The loss
/// falls with the square of the step.
#[test]
fn a_knot_that_slides_over_a_seam_loses_speed_with_the_square_of_the_step() {
    let lost = |step: f64| {
        let net = knots(&[(0.01, [-0.01, -0.1, 0.3], [0.5, 1.0, 0.0])]);
        let n_steps = (0.3 / step) as u32;
        let (state, _) = advance(&net, &wall_with_a_seam(), &Setup { step, ..setup() }, n_steps);
        1.0 - state.knots.velocity[0].y
    };
    within("lost of 1 m/s, step 0.5 ms", lost(STEP), [0.1, 0.25]); // measured 0.207
    within("lost of 1 m/s, step 0.1 ms", lost(1e-4), [0.01, 0.025]); // measured 0.019
    below("lost of 1 m/s, step 0.01 ms", lost(1e-5), 3e-4); // measured 2e-4
}

/// A pull of two bullets around a ball presses the knot between them: with the default contact
/// stiffness (30 Hz) taut cables press knots 26 mm into a target.
#[test]
fn taut_cables_do_not_press_a_knot_into_the_target() {
    let ball = target(json!({ "ball": { "radius_m": 0.1 } }), "fixed");
    let mut net = knots(&[
        (0.0005, [-0.11, 0.0, 0.0], [0.0; 3]),
        (0.05, [-0.11, 0.15, 0.0], [3.0, 0.0, 0.0]),
        (0.05, [-0.11, -0.15, 0.0], [3.0, 0.0, 0.0]),
    ]);
    tie(&mut net, [0, 1], 0.16, 2000.0, 0.1);
    tie(&mut net, [0, 2], 0.16, 2000.0, 0.1);
    let case = changed(case_with(net, json!({})), |built| built.target = Some(ball));
    let mut simulation = Simulation::new(&case);
    let (mut deepest, mut pressed) = (0.0_f64, 0.0_f64);
    for _ in 0..200 {
        simulation.step().unwrap();
        for contact in &simulation.state.contacts {
            deepest = deepest.max(-contact.gap);
            pressed += contact.impulse;
        }
    }
    assert!(pressed > 0.1, "{pressed}"); // the bullets' pull went through it
    below("penetration, m", deepest, 2e-4); // measured 0
}

/// Two knots on a cable, parted by `stretch` and at rest.
fn pair(stretch: f64, parting: f64, omega: f64, zeta: f64) -> Net {
    let half = 0.5 * (1.0 + stretch);
    let mut net = knots(&[
        (0.02, [0.0, -half, 0.0], [0.0, -0.5 * parting, 0.0]),
        (0.02, [0.0, half, 0.0], [0.0, 0.5 * parting, 0.0]),
    ]);
    tie(&mut net, [0, 1], 1.0, omega, zeta);
    net
}

/// r − l₀ = x₀ e^(−ζωt) (cos ω_d t + ζ / √(1 − ζ²) sin ω_d t) until the cable goes slack.
///
/// The closing speed of 13 m/s also shows that no cap on the corrective speed (3 m/s by default)
/// weakens the cable, and the acceleration that no bias-free pass (on by default) drops its spring.
#[test]
fn two_knots_on_a_cable_swing_as_kelvin_and_voigt_say() {
    let (stretch, omega, zeta) = (0.5, 30.0, 0.1);
    let root = (1.0_f64 - zeta * zeta).sqrt();
    let exact = |t: f64| {
        let phase = omega * root * t;
        stretch * (-zeta * omega * t).exp() * (phase.cos() + zeta / root * phase.sin())
    };
    let error = |step: f64| {
        let mut simulation = Simulation::new(&case_with(
            pair(stretch, 0.0, omega, zeta),
            json!({ "solver": { "step_s": step } }),
        ));
        let mut largest = 0.0_f64;
        // Up to a quarter of the period, where it is still taut.
        for i in 1..=(0.05 / step).round() as u32 {
            simulation.step().unwrap();
            let [a, b] = [simulation.state.knots.position[0], simulation.state.knots.position[1]];
            largest = largest.max(((b - a).norm() - 1.0 - exact(f64::from(i) * step)).abs());
        }
        largest / stretch
    };
    let (coarse, fine) = (error(5e-4), error(2.5e-4));
    below("error over the first stretch", coarse, 1e-2); // measured 3.4e-3
    within("order: error over that of half the step", coarse / fine, [1.8, 2.2]); // measured 1.985
}

/// A cable stiffer than the step can resolve passes on (1 + e) mₑ ṙ with the closed form's e.
#[test]
fn a_stiff_cable_snaps_back_with_its_restitution() {
    for zeta in [0.01, 0.1, 0.5] {
        let net = pair(-0.1, 2.0, 2e4, zeta);
        let expected = net.cables[0].half_cycle(net.cables[0].reduced_mass).restitution();
        let mut simulation = Simulation::new(&case_with(net, json!({})));
        for _ in 0..200 {
            simulation.step().unwrap();
        }
        let velocity = &simulation.state.knots.velocity;
        let closing = velocity[0].y - velocity[1].y;
        below("closing speed less e times parting speed", (closing / 2.0 - expected).abs(), 1e-9);
        assert_eq!(simulation.work.snaps, 1);
    }
}

#[test]
fn a_cable_never_pushes() {
    let net = pair(-0.2, -1.0, 200.0, 0.3); // slack, its ends closing
    let mut simulation = Simulation::new(&case_with(net, json!({})));
    for _ in 0..1000 {
        simulation.step().unwrap();
        let [a, b] = [simulation.state.knots.velocity[0].y, simulation.state.knots.velocity[1].y];
        assert_eq!([a, b], [0.5, -0.5], "at {} s", simulation.state.time);
    }
}

/// Ten light knots between two bullets a thousand times heavier, flying apart at 10 m/s: the cables
/// must not stretch away, and no energy may come from it.
///
/// A step of 0.5 ms spans 7 / ω of the light knots, and the rows of a chain that goes taut at once
/// cannot carry it all: such a step is done in parts.
#[test]
fn heavy_bullets_do_not_stretch_a_chain_of_light_knots() {
    let n_cables = 11;
    let rows: Vec<_> = (0..=n_cables)
        .map(|i| {
            let y = 0.09 * (i as f64 - 5.5);
            let (mass, speed) = match i {
                0 => (1.0, -5.0),
                11 => (1.0, 5.0),
                _ => (1e-3, 0.0),
            };
            (mass, [0.0, y, 0.0], [0.0, speed, 0.0])
        })
        .collect();
    let mut net = knots(&rows);
    let stiffness = 1e5_f64;
    for i in 0..n_cables {
        let omega = (stiffness * (1.0 / net.mass[i] + 1.0 / net.mass[i + 1])).sqrt();
        tie(&mut net, [i, i + 1], 0.1, omega, 0.1);
    }
    let energy = net.launch_energy();
    // All energy in the chain as one massless spring.
    let exact = (2.0 * energy * n_cables as f64 / stiffness).sqrt();
    let worst = |step: f64| {
        let mut simulation =
            Simulation::new(&case_with(net.clone(), json!({ "solver": { "step_s": step } })));
        let (mut longest, mut most) = (0.0_f64, 0.0_f64);
        for _ in 0..(0.1 / step) as u32 {
            simulation.step().unwrap();
            let position = &simulation.state.knots.position;
            longest = longest.max((position[n_cables] - position[0]).norm() - 0.1 * n_cables as f64);
            most = most.max(simulation.audit.ledger.own() / energy);
        }
        [longest / exact, most]
    };
    let [stretch, most] = worst(1e-4);
    within("stretch over a massless chain's, step 0.1 ms", stretch, [0.9, 1.0]); // measured 0.989
    below("energy over the launch energy, step 0.1 ms", most, 1.0 + 1e-6); // measured 1.0
    let [stretch, most] = worst(STEP);
    within("stretch over a massless chain's, step 0.5 ms", stretch, [0.9, 1.05]); // measured 1.022
    // 1.066 before steps whose cables make energy were done again in more parts.
    below("energy over the launch energy, step 0.5 ms", most, 1.0 + 1e-3);
}

/// The engine clips speeds at 400 m/s unless told otherwise.
#[test]
fn a_fast_knot_keeps_its_speed() {
    let net = knots(&[(0.5, [0.0; 3], [2000.0, 0.0, 0.0])]);
    let mut world = World::new(&net, None, &setup());
    let mut state = State::default();
    for _ in 0..100 {
        world.advance(&mut state, STEP, 1);
    }
    assert_eq!(state.knots.velocity[0].x, 2000.0);
    below("way less v t", (state.knots.position[0].x - 2000.0 * 100.0 * STEP).abs(), 1e-9);
}

#[test]
fn a_held_target_does_not_move_and_a_driven_one_keeps_its_rate() {
    for (motion, rate) in [("fixed", 0.0), ("spinning", 1.5)] {
        let mut plate = plate(motion);
        plate.spin = Vector3::new(1.5, 0.0, 0.0);
        let net = knots(&[(5.0, [-0.01, 0.3, 0.0], [2.0, 0.0, 0.0])]);
        let (state, contacts) = advance(
            &net,
            &plate,
            &Setup { friction: Some(Law::Coulomb { coefficient: 0.5 }), ..setup() },
            200,
        );
        let body = state.target().unwrap();
        assert!(contacts.iter().any(|contact| contact.impulse > 1.0), "{motion}");
        assert_eq!(body.position, plate.position, "{motion}");
        assert_eq!(body.rate, Vector3::new(rate, 0.0, 0.0), "{motion}");
        let turned = body.attitude.scaled_axis();
        below("angle less rate times time", (turned - body.rate * 200.0 * STEP).norm(), 1e-6);
    }
}

/// The engine disables a body that is not a number and says nothing.
#[test]
fn a_state_that_is_not_a_number_ends_the_run_with_time_knot_and_stage() {
    let net = knots(&[(0.5, [0.0; 3], [0.0; 3]), (0.5, [1.0, 0.0, 0.0], [0.0; 3])]);
    let mut simulation = Simulation::new(&case_with(net, json!({})));
    simulation.step().unwrap();
    simulation.state.knots.velocity[1].x = f64::NAN;
    let failure = (0..3).find_map(|_| simulation.step().err());
    match failure {
        Some(Failure::NotANumber { time, culprit: Culprit::Knot(1), .. }) => assert!(time <= 3.0 * STEP),
        Some(Failure::Quarantine { time }) => assert!(time <= 3.0 * STEP),
        other => panic!("{other:?}"),
    }
}
