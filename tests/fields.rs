//! OrbitMotion and cabin against closed forms, and against equations written in the inertial frame.

use crate::common;

use std::f64::consts::TAU;

use crate::common::{below, case_of, run, scene, summary, within};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde_json::json;
use tumblenet::field::orbit::{EARTH_PARAMETER, EARTH_RADIUS, OrbitMotion};
use tumblenet::field::profile::{CabinMotion, ProfileRow, Values};
use tumblenet::field::{self, Field};
use tumblenet::interaction::Half;
use tumblenet::state::{Body, BodyModel, Knots, State};
use tumblenet::target::Motion;

const AXIS: f64 = EARTH_RADIUS + 700e3;

/// One knot of 1 kg.
fn knot(position: Vector3<f64>, velocity: Vector3<f64>) -> State {
    State { knots: Knots { position: vec![position], velocity: vec![velocity] }, ..State::default() }
}

/// Knots and bodies free in `field` for `n_steps` steps of `step` seconds, as a simulation takes them;
/// `each` sees the state after every step.
fn fly(field: &impl Field, state: &mut State, step: f64, n_steps: u64, mut each: impl FnMut(&State)) {
    let masses = vec![1.0; state.knots.position.len()];
    for i in 0..n_steps {
        let [start, end] = [i, i + 1].map(|n| n as f64 * step);
        let middle = start + 0.5 * step;
        field::kick(&field.over(start, middle), Half::First, state, &masses);
        for (position, velocity) in state.knots.position.iter_mut().zip(&state.knots.velocity) {
            *position += step * velocity;
        }
        state.drift_bodies(false, step);
        field::kick(&field.over(middle, end), Half::Second, state, &masses);
        state.time = end;
        each(state);
    }
}

/// Clohessy and Wiltshire in the local frame of a V-bar approach: X along the flight, Y along the normal,
/// Z up.
fn clohessy_wiltshire(n: f64, r: Vector3<f64>, v: Vector3<f64>, t: f64) -> Vector3<f64> {
    let (s, c) = (n * t).sin_cos();
    let (up, along, beside) = (r.z, r.x, r.y);
    let (up_v, along_v, beside_v) = (v.z, v.x, v.y);
    Vector3::new(
        along + 6.0 * (s - n * t) * up - 2.0 / n * (1.0 - c) * up_v + (4.0 * s - 3.0 * n * t) / n * along_v,
        beside * c + beside_v / n * s,
        (4.0 - 3.0 * c) * up + s / n * up_v + 2.0 / n * (1.0 - c) * along_v,
    )
}

#[test]
fn a_knot_on_a_relative_orbit_follows_clohessy_and_wiltshire_for_a_period() {
    let orbit = OrbitMotion::new(AXIS, 0.0, 0.0, &Vector3::y());
    let n = orbit.mean_motion;
    // Centimetres: what the linear solution leaves out grows as r / R, 1e-7 at a metre.
    for (r, v) in [
        (Vector3::new(0.0, 0.0, 0.01), Vector3::zeros()),
        (Vector3::new(0.01, 0.005, -0.003), Vector3::new(1e-6, 4e-6, -3e-6)),
        (Vector3::new(0.02, 0.0, 0.005), Vector3::new(-0.01 * n, 0.0, 0.0)), // a closed ellipse
    ] {
        let mut state = knot(r, v);
        let (mut worst, mut reach) = (0.0_f64, 0.0_f64);
        let n_steps = 60_000;
        fly(&orbit, &mut state, orbit.period() / n_steps as f64, n_steps, |state| {
            let expected = clohessy_wiltshire(n, r, v, state.time);
            worst = worst.max((state.knots.position[0] - expected).norm());
            reach = reach.max(expected.norm());
        });
        below("largest error over the way", worst / reach, 1e-6); // measured 1e-9 to 3e-8
    }
}

/// Through the whole simulation: a net whose cables stay slack is four free knots.
#[test]
fn the_knots_of_a_slack_net_follow_clohessy_and_wiltshire_for_a_period() {
    let period = TAU / (EARTH_PARAMETER / AXIS.powi(3)).sqrt();
    let case = case_of(json!({
        "title": "free knots", "duration_s": period,
        "net": { "meshes": [1, 1], "mesh_length_m": 10.0, "bullet_mass_kg": 1.0,
                 "fold": { "scheme": "scaled", "ratio": 0.002 },
                 "cable": { "diameter_m": 0.001, "material": { "young_modulus_pa": 1e3, "density_kg_m3": 1.0,
                     "tensile_strength_pa": 1e9, "elongation_at_break": 1.0 } } },
        "launch": { "speed_m_s": 1e-5, "angle_deg": 60.0 },
        "effects": { "orbit": { "altitude_m": 700e3 } },
        "solver": { "cables": "explicit", "contact": "impulse", "step_s": period / 60_000.0 },
        "output": { "sample_s": period / 100.0 }
    }));
    let run = run(&case);
    assert_eq!(run.extremes.tension, 0.0, "slack");
    let n = TAU / period;
    let (mut worst, mut reach) = (0.0_f64, 0.0_f64);
    for (time, knots) in run.frames.time.iter().zip(&run.frames.knots) {
        for (knot, position) in knots.iter().enumerate() {
            let expected =
                clohessy_wiltshire(n, case.net().folded[knot], case.net().launch_velocity[knot], *time);
            worst = worst.max((position - expected).norm());
            reach = reach.max(expected.norm());
        }
    }
    below("largest error over the way", worst / reach, 1e-6);
    let ledger = &run.frames.ledger;
    let [first, last] = [&ledger[0], &ledger[ledger.len() - 1]];
    let scale = ledger.iter().map(|row| row.kinetic_net).fold(0.0, f64::max);
    below("change of kinetic energy + stored", (last.mechanical() - first.mechanical()).abs() / scale, 1e-6);
    below("energy residual", ledger.iter().map(|row| row.residual().abs()).fold(0.0, f64::max) / scale, 1e-9);
    let momentum = run.frames.momentum.last().unwrap() - run.frames.momentum[0] - run.outside_impulse;
    below("momentum residual", momentum.norm() / (4.0 * first.kinetic_net).sqrt(), 1e-9);
}

/// A kilometre away, on a circle and on an ellipse: energy and angular momentum about the Earth.
#[test]
fn a_free_knot_keeps_energy_and_angular_momentum_about_the_earth() {
    for eccentricity in [0.0, 0.3] {
        let axis = AXIS / (1.0 - eccentricity);
        let orbit = OrbitMotion::new(axis, eccentricity, 0.4, &Vector3::y());
        let mut state = knot(Vector3::new(1000.0, 300.0, -500.0), Vector3::new(0.2, -0.1, 0.3));
        // Per unit mass, inertial; the origin moves along the radius, too: e sin f √(μ / p).
        let p = axis * (1.0 - eccentricity * eccentricity);
        let climb = eccentricity * f64::sin(0.4) * (EARTH_PARAMETER / p).sqrt();
        let invariants = |state: &State| {
            let frame = orbit.at(state.time);
            let field::Gravity::Tidal { radius, .. } = frame.gravity else { panic!("a tidal field") };
            let (r, v) = (radius + state.knots.position[0], state.knots.velocity[0]);
            let velocity = climb * radius.normalize() + v + frame.rate.cross(&r);
            (r.cross(&velocity).norm(), 0.5 * velocity.norm_squared() - EARTH_PARAMETER / r.norm())
        };
        let (momentum, energy) = invariants(&state);
        let jacobi = |state: &State| {
            0.5 * state.knots.velocity[0].norm_squared()
                + orbit.at(state.time).potential(&state.knots.position[0])
        };
        let start = jacobi(&state);
        // After a whole turn the origin climbs as at the start.
        let n_steps = 60_000;
        fly(&orbit, &mut state, orbit.period() / n_steps as f64, n_steps, |_| {});
        let (momentum_end, energy_end) = invariants(&state);
        // Measured 1e-15 on the circle; on the ellipse 2e-11, the error of steps of 0.1 to 0.3 s.
        let bound = if eccentricity == 0.0 { 1e-13 } else { 1e-10 };
        below("angular momentum", (momentum_end / momentum - 1.0).abs(), bound);
        below("energy", (energy_end / energy - 1.0).abs(), bound);
        if eccentricity == 0.0 {
            below("Jacobi integral", (jacobi(&state) / start - 1.0).abs(), 1e-8);
        }
    }
}

/// Two bodies in the inertial frame, by RK4; their difference, turned into the local frame.
#[test]
fn a_kilometre_away_the_motion_is_that_of_two_bodies_in_the_inertial_frame() {
    for (eccentricity, anomaly) in [(0.0, 0.0), (0.3, 2.0)] {
        let axis = AXIS / (1.0 - eccentricity);
        let orbit = OrbitMotion::new(axis, eccentricity, anomaly, &Vector3::y());
        let (r, v) = (Vector3::new(1000.0, 300.0, -500.0), Vector3::new(0.2, -0.1, 0.3));
        let frame = orbit.at(0.0);
        let field::Gravity::Tidal { radius, .. } = frame.gravity else { panic!("a tidal field") };
        // r dot of the reference orbit: e sin f √(μ / p) along the radius.
        let p = axis * (1.0 - eccentricity * eccentricity);
        let outward = eccentricity * f64::sin(anomaly) * (EARTH_PARAMETER / p).sqrt() * radius.normalize();
        let mut origin = (radius, outward + frame.rate.cross(&radius));
        let mut other = (radius + r, origin.1 + v + frame.rate.cross(&r));
        let time = 0.5 * orbit.period();
        let n_steps = 20_000;
        for _ in 0..n_steps {
            origin = kepler_rk4(origin, time / n_steps as f64);
            other = kepler_rk4(other, time / n_steps as f64);
        }
        let up = origin.0.normalize();
        let beside = origin.0.cross(&origin.1).normalize();
        let along = beside.cross(&up);
        let apart = other.0 - origin.0;
        let expected = Vector3::new(apart.dot(&along), apart.dot(&beside), apart.dot(&up));
        let mut state = knot(r, v);
        fly(&orbit, &mut state, time / 60_000.0, 60_000, |_| {});
        let error = (state.knots.position[0] - expected).norm() / expected.norm();
        below("error over the way", error, 1e-6);
    }
}

fn kepler_rk4((r, v): (Vector3<f64>, Vector3<f64>), h: f64) -> (Vector3<f64>, Vector3<f64>) {
    let gravity = |r: Vector3<f64>| -EARTH_PARAMETER / r.norm().powi(3) * r;
    let (r1, v1) = (v, gravity(r));
    let (r2, v2) = (v + 0.5 * h * v1, gravity(r + 0.5 * h * r1));
    let (r3, v3) = (v + 0.5 * h * v2, gravity(r + 0.5 * h * r2));
    let (r4, v4) = (v + h * v3, gravity(r + h * r3));
    (r + h / 6.0 * (r1 + 2.0 * r2 + 2.0 * r3 + r4), v + h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4))
}

/// The same motion, whichever way the local frame lies in the orbital one.
#[test]
fn the_approach_turns_the_frame_and_not_the_physics() {
    let (r, v) = (Vector3::new(3.0, 100.0, -20.0), Vector3::new(0.1, 0.2, -0.3)); // in (R, V, H)
    let ends: Vec<Vector3<f64>> = [
        Vector3::y(),
        -Vector3::y(),
        Vector3::x(),
        -Vector3::x(),
        Vector3::z(),
        Vector3::new(1.0, 2.0, -0.5),
    ]
    .into_iter()
    .map(|approach| {
        let orbit = OrbitMotion::new(AXIS, 0.1, 1.0, &approach);
        let turn = orbit.local_from_orbital;
        below("a rotation", (turn * turn.transpose() - Matrix3::identity()).norm(), 1e-14);
        below("right-handed", (turn.determinant() - 1.0).abs(), 1e-14);
        let mut state = knot(turn * r, turn * v);
        fly(&orbit, &mut state, 0.5, 2000, |_| {});
        turn.transpose() * state.knots.position[0]
    })
    .collect();
    for end in &ends {
        below("difference", (end - ends[0]).norm() / ends[0].norm(), 1e-12);
    }
    // Fig. 3.7: X along the flight, Z up.
    let turn = OrbitMotion::new(AXIS, 0.0, 0.0, &Vector3::y()).local_from_orbital;
    assert_eq!((turn * Vector3::y(), turn * Vector3::x()), (Vector3::x(), Vector3::z()));
}

/// A free body of 1 kg.
fn body(inertia: Matrix3<f64>, attitude: UnitQuaternion<f64>, rate: Vector3<f64>) -> State {
    let body = Body { attitude, rate, ..Body::at_rest() };
    State::default().with_bodies([(BodyModel::new("body", Motion::Free, 1.0, inertia), body)])
}

/// Without torque a body turns in a turning frame as in the inertial one, seen from the frame.
#[test]
fn a_tumbling_body_does_not_feel_that_the_frame_turns() {
    let inertia = Matrix3::new(1.0, 0.1, -0.2, 0.1, 2.0, 0.05, -0.2, 0.05, 2.5);
    let frame_rate = Vector3::new(0.1, -0.3, 0.2);
    let field = CabinMotion {
        constant: Values { gravity: Vector3::zeros(), rate: frame_rate },
        rows: Vec::new(),
        centre: Vector3::zeros(),
    };
    let attitude = UnitQuaternion::from_euler_angles(0.3, -0.5, 1.0);
    let rate = Vector3::new(0.2, 1.0, -0.4);
    let (step, n_steps) = (5e-4, 20_000);
    let mut state = body(inertia, attitude, rate - frame_rate);
    fly(&field, &mut state, step, n_steps, |_| {});

    let mut inertial = body(inertia, attitude, rate);
    for _ in 0..n_steps {
        inertial.drift_bodies(false, step);
    }
    let inertial = inertial.bodies[0];
    let back = UnitQuaternion::from_scaled_axis(-frame_rate * (step * n_steps as f64));
    let seen = state.bodies[0];
    below("attitude", seen.attitude.angle_to(&(back * inertial.attitude)), 1e-6);
    let expected = back * (inertial.rate - frame_rate);
    below("rate", (seen.rate - expected).norm() / expected.norm(), 1e-6);
}

/// A long body that points at the Earth librates: pitch at n √(3 (I_roll − I_yaw) / I_pitch).
#[test]
fn the_gravity_gradient_holds_a_long_body_upright() {
    let orbit = OrbitMotion::new(AXIS, 0.0, 0.0, &Vector3::y());
    // Local frame: X (roll) along the flight, Y (pitch) along the normal, Z (yaw) up: long along Z.
    let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 0.9, 0.2));
    let mut upright = body(inertia, UnitQuaternion::identity(), Vector3::zeros());
    fly(&orbit, &mut upright, 0.5, 2000, |_| {});
    below("turn of an upright body", upright.bodies[0].attitude.angle(), 1e-12);

    let amplitude = 1e-4;
    let turned = UnitQuaternion::from_scaled_axis(amplitude * Vector3::y());
    let mut state = body(inertia, turned, Vector3::zeros());
    let frequency = orbit.mean_motion * f64::sqrt(3.0 * (1.0 - 0.2) / 0.9);
    let mut worst = 0.0_f64;
    fly(&orbit, &mut state, 0.5, 12_000, |state| {
        let pitch = state.bodies[0].attitude.scaled_axis().y;
        worst = worst.max((pitch - amplitude * (frequency * state.time).cos()).abs());
    });
    below("pitch over its amplitude", worst / amplitude, 1e-5);
}

/// Position and velocity in a cabin that turns at a constant rate, with constant gravity in it.
fn in_cabin(
    rate: Vector3<f64>,
    gravity: Vector3<f64>,
    r: Vector3<f64>,
    v: Vector3<f64>,
    t: f64,
) -> (Vector3<f64>, Vector3<f64>) {
    let w = rate.norm();
    let axis = rate / w;
    let along = axis.dot(&gravity) * axis;
    let across = gravity - along;
    let turned = axis.cross(&across);
    let (s, c) = (w * t).sin_cos();
    // Inertial: the gravity turns with the cabin.
    let velocity = v + rate.cross(&r) + along * t + across * (s / w) + turned * ((1.0 - c) / w);
    let position = r
        + (v + rate.cross(&r)) * t
        + along * (0.5 * t * t)
        + across * ((1.0 - c) / (w * w))
        + turned * (t / w - s / (w * w));
    let back = Rotation3::from_scaled_axis(-rate * t);
    let position = back * position;
    (position, back * velocity - rate.cross(&position))
}

fn row(t_s: f64, gravity: [f64; 3], rate: [f64; 3]) -> ProfileRow {
    ProfileRow {
        t_s,
        gravity_x_m_s2: gravity[0],
        gravity_y_m_s2: gravity[1],
        gravity_z_m_s2: gravity[2],
        rate_x_rad_s: rate[0],
        rate_y_rad_s: rate[1],
        rate_z_rad_s: rate[2],
    }
}

/// Angular momentum about X, seen from outside, of a ring of four cables that rests in a cabin at 5 rad/s, after 2 s
/// over that at the start.
fn ring_keeps(step: Option<f64>, contact: [&str; 2]) -> f64 {
    let mut scene = json!({
        "title": "ring", "duration_s": 2.0,
        "net": { "meshes": [1, 1], "mesh_length_m": 1.0, "bullet_mass_kg": 0.1,
                 "cable": { "material": "nylon", "diameter_m": 0.001 }, "fold": { "scheme": "scaled", "ratio": 1.0 } },
        "launch": { "speed_m_s": 0.0, "angle_deg": 0.0 },
        "effects": { "cabin": { "rate_rad_s": [5.0, 0.0, 0.0] } },
        "solver": { "cables": contact[0], "contact": contact[1], "integrator": "symplectic" }
    });
    if let Some(step) = step {
        scene["solver"]["step_s"] = json!(step);
    }
    let case = case_of(scene);
    let frames = run(&case).frames;
    let turning = |knots: &[Vector3<f64>], velocities: &[Vector3<f64>]| -> f64 {
        let rate = Vector3::new(5.0, 0.0, 0.0);
        knots.iter().zip(velocities).map(|(x, v)| x.cross(&(v + rate.cross(x))).x).sum()
    };
    let last = frames.knots.len() - 1;
    let of = |frame: usize| turning(&frames.knots[frame], &frames.velocities[frame]);
    of(last) / of(0)
}

/// Semi-implicit Euler has its velocities half a sub-step before its positions; turned as they were, they lost 65 % of
/// this in 6 s. Measured: 7e-5 at its own step; 8e-3 and 1.2e-3, a seventh, at 2 and 1 ms.
#[test]
fn a_field_turns_taut_cables_to_second_order() {
    let explicit = ["explicit", "impulse"];
    below("own step: lost", (1.0 - ring_keeps(None, explicit)).abs(), 1e-3);
    let [coarse, fine] = [2e-3, 1e-3].map(|step| (1.0 - ring_keeps(Some(step), explicit)).abs());
    below("half the step: lost over a third of", fine, coarse / 3.0);
}

#[test]
fn a_free_knot_in_a_cabin_follows_the_closed_form() {
    let (r, v) = (Vector3::new(0.3, -0.2, 0.5), Vector3::new(1.8, 0.1, -0.2));
    let gravity = [[0.01, -0.02, 0.098], [-0.03, 0.01, 0.05]];
    let rate = [[0.02, 0.3, -0.1], [-0.05, 0.1, 0.2]];
    let constant = Values { gravity: gravity[0].into(), rate: rate[0].into() };
    let cabin = CabinMotion { constant, rows: Vec::new(), centre: Vector3::zeros() };
    let mut state = knot(r, v);
    fly(&cabin, &mut state, 5e-4, 6000, |_| {});
    let (position, velocity) = in_cabin(constant.rate, constant.gravity, r, v, 3.0);
    below("constant: position", (state.knots.position[0] - position).norm() / position.norm(), 1e-6);
    below("constant: velocity", (state.knots.velocity[0] - velocity).norm() / velocity.norm(), 1e-6);

    // A step at 1 s: the inertial velocity goes on, the one relative to the cabin jumps.
    let rows = vec![
        row(0.0, gravity[0], rate[0]),
        row(1.0, gravity[0], rate[0]),
        row(1.0, gravity[1], rate[1]),
        row(3.0, gravity[1], rate[1]),
    ];
    let cabin = CabinMotion { constant: Values::default(), rows, centre: Vector3::zeros() };
    let mut state = knot(r, v);
    fly(&cabin, &mut state, 5e-4, 6000, |_| {});
    let (first, second) = (Vector3::from(rate[0]), Vector3::from(rate[1]));
    let (position, velocity) = in_cabin(first, gravity[0].into(), r, v, 1.0);
    let velocity = velocity - (second - first).cross(&position);
    let (position, velocity) = in_cabin(second, gravity[1].into(), position, velocity, 2.0);
    below("step: position", (state.knots.position[0] - position).norm() / position.norm(), 1e-6);
    below("step: velocity", (state.knots.velocity[0] - velocity).norm() / velocity.norm(), 1e-6);
}

/// A cabin that speeds up, about a point of its own: seen from outside, a free knot flies straight.
#[test]
fn a_free_knot_flies_straight_while_the_cabin_speeds_up() {
    let centre = Vector3::new(-2.0, 0.5, 1.0);
    let rows = vec![row(0.0, [0.0; 3], [0.0, 0.1, 0.0]), row(2.0, [0.0; 3], [0.0, 0.5, 0.0])];
    let cabin = CabinMotion { constant: Values::default(), rows, centre };
    let (r, v) = (Vector3::new(0.3, -0.2, 0.5), Vector3::new(1.8, 0.1, -0.2));
    let mut state = knot(r, v);
    fly(&cabin, &mut state, 5e-4, 4000, |_| {});
    let arm = r - centre;
    let straight = arm + 2.0 * (v + Vector3::new(0.0, 0.1, 0.0).cross(&arm));
    let turned = 0.5 * (0.1 + 0.5) * 2.0;
    let expected = centre + Rotation3::from_scaled_axis(-turned * Vector3::y()) * straight;
    below("position", (state.knots.position[0] - expected).norm() / expected.norm(), 1e-6);
}

/// Second order: half the step, a quarter of the error.
#[test]
fn finer_steps_converge() {
    let constant = Values { gravity: Vector3::new(0.1, 0.0, 0.3), rate: Vector3::new(0.5, 1.0, -0.2) };
    let cabin = CabinMotion { constant, rows: Vec::new(), centre: Vector3::zeros() };
    let (r, v) = (Vector3::new(0.3, -0.2, 0.5), Vector3::new(1.8, 0.1, -0.2));
    let (expected, _) = in_cabin(constant.rate, constant.gravity, r, v, 2.0);
    let error = |n_steps: u64| {
        let mut state = knot(r, v);
        fly(&cabin, &mut state, 2.0 / n_steps as f64, n_steps, |_| {});
        (state.knots.position[0] - expected).norm()
    };
    within("error at 40 ms over that at 20 ms", error(50) / error(100), [3.9, 4.1]);
}

/// The Cubesat scene at 700 km, left to itself for 100 s: net, target and their difference drift as the
/// linear solution says.
#[test]
fn after_100_s_of_free_drift_the_cubesat_scene_matches_the_linear_solution() {
    // Beside and above the way of the net, so that they never meet.
    let case = scene(
        "cubesat-orbit-700km",
        &[
            "duration_s=100",
            "target.offset_m=[5,20]",
            "net.meshes=[4,4]",
            "output.sample_s=1",
            "launch.angle_deg=5",
            "solver.cables=explicit",
            "solver.contact=impulse",
        ],
    );
    let run = run(&case);
    assert_eq!(run.extremes.first_contact, None);
    let n = (EARTH_PARAMETER / AXIS.powi(3)).sqrt();
    let last = run.frames.time.len() - 1;
    let time = run.frames.time[last];
    let centre = |of: &[Vector3<f64>]| {
        of.iter().zip(&case.net().mass).map(|(x, m)| *m * x).sum::<Vector3<f64>>() / case.net().total_mass()
    };
    let target = run.frames.target[0].position;
    let still = Vector3::zeros();
    let expected = clohessy_wiltshire(n, target, still, time);
    let drift = (expected - target).norm();
    below("target, over its drift", (run.frames.target[last].position - expected).norm() / drift, 1e-4);
    within("its drift", drift, [0.1, 1.0]);

    let (start, velocity) = (centre(&case.net().folded), centre(&case.net().launch_velocity));
    let expected = clohessy_wiltshire(n, start, velocity, time);
    let straight = start + time * velocity;
    let found = centre(&run.frames.knots[last]);
    within("net, off its straight line", (expected - straight).norm(), [5.0, 50.0]);
    below("net, over that", (found - expected).norm() / (expected - straight).norm(), 1e-4);
}

/// What orbit does to a capture of three seconds: the push changes by less than an ensemble spreads.
#[test]
fn the_orbit_leaves_the_cubesats_capture_as_it_is() {
    let members = common::ensemble(&scene("cubesat-orbit-700km", &[]), 4);
    let without = common::ensemble(&scene("cubesat-free", &[]), 4);
    let push = |members: &[_]| common::spread(members, "target.displacement_m.0");
    println!("push {:?} on the orbit, {:?} without", push(&members), push(&without));
    assert_eq!((common::captured(&members), common::captured(&without)), (4, 4));
    let [low, median, high] = push(&without);
    // Tides move nothing by more than 3 n² x t² / 2 = 2e-5 m, Coriolis by n v t² = 0.02 m.
    below("change of the median push", (push(&members)[1] - median).abs(), high - low + 0.02);
}

/// Fig. 3.23: across the way the middle knot moves with the cabin's disturbances, mainly along z.
#[test]
fn the_cabin_carries_the_middle_knot_along_z() {
    let of = |name: &str| summary(&scene(name, &[])).deployment.middle_deviation_m;
    let [both, gravity, rotation, none] = [
        "envisat-mockup-cabin",
        "envisat-mockup-cabin-gravity",
        "envisat-mockup-cabin-rotation",
        "envisat-mockup-fixed",
    ]
    .map(of);
    println!("both {both:?}, gravity {gravity:?}, rotation {rotation:?}, none {none:?}");
    // Measured 0.126, 0.040, 0.086 and 0.015 m along z, at most 0.027 m along y; source: order of 0.15 m,
    // and less than 0.04 m.
    within("both, z", both[1], [0.1, 0.2]);
    for [y, _] in [both, gravity, rotation, none] {
        below("y", y, 0.04);
    }
    assert!(both[1] > gravity[1].max(rotation[1]) && gravity[1].min(rotation[1]) > none[1]);
}
