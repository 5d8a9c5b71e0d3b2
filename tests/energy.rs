//! What undamped and damped nets do with their energy, at the step that each method takes by itself.

use crate::common;

use crate::common::{below, case_of, within};
use serde_json::json;
use tumblenet::case::Case;
use tumblenet::metrics::capture::Curves;
use tumblenet::metrics::conservation::Conservation;
use tumblenet::metrics::warnings;
use tumblenet::run::Run;

/// `n` x `n` meshes of 1 m Kevlar (Table 3.2), shot at `speed`; the net is open after some 0.9 of the path.
fn net(cables: &str, n: u32, damping: f64, speed: f64, duration: f64) -> Case {
    case_of(json!({
        "title": "net", "duration_s": duration,
        "net": { "meshes": [n, n], "mesh_length_m": 1.0, "bullet_mass_kg": 1.0,
                 "cable": { "material": "kevlar", "diameter_m": 0.001, "damping_ratio": damping },
                 "fold": { "scheme": "scaled", "ratio": 0.05 } },
        "launch": { "speed_m_s": speed, "angle_deg": 55.0 },
        "solver": { "cables": cables, "contact": if cables == "joints" { "rapier" } else { "impulse" } }
    }))
}

fn kept(case: &Case) -> Conservation {
    Conservation::of(case, &common::run(case))
}

/// Meshes, damping ratio and launch speed [m/s]; every net is flown until it has opened and been shaken.
const NETS: [(u32, f64, f64); 12] = [
    (1, 0.0, 1.0),
    (1, 0.1, 60.0),
    (1, 5.0, 10.0),
    (2, 0.0, 60.0),
    (2, 0.003, 10.0),
    (5, 0.0, 10.0),
    (5, 0.1, 1.0),
    (5, 1.0, 60.0),
    (10, 0.0, 10.0),
    (10, 0.003, 10.0),
    (10, 0.1, 10.0),
    (20, 0.0, 60.0),
];

fn opens(n: u32, speed: f64) -> f64 {
    1.2 * f64::from(n.max(2)) / speed
}

/// With the integrator that the damping chooses. Measured: created at most 6.1e-4, made or destroyed beside the law at most
/// 2.7e-4 with the secant force and 3e-3 by semi-implicit Euler, momenta to rounding.
#[test]
fn explicit_cables_make_no_energy_whatever_their_damping() {
    for (n, damping, speed) in NETS {
        let kept = kept(&net("explicit", n, damping, speed, opens(n, speed)));
        let name = format!("{n} x {n}, damping {damping}, {speed} m/s");
        below(&format!("{name}: created"), kept.energy_created, 1e-3);
        below(&format!("{name}: residual"), kept.energy_residual, 1e-2);
        below(&format!("{name}: momentum"), kept.momentum_residual, 1e-9);
        below(&format!("{name}: angular momentum"), kept.angular_momentum_residual, 1e-9);
    }
}

/// A bullet that pulls out a net eight times as heavy is stopped by single cables, which hold what they overshoot by. Semi-implicit Euler made
/// 1.9e-2, 6.7e-4, 4.4e-4 and 2.3e-4; measured: 1.3e-4 at most.
#[test]
fn light_bullets_before_a_heavy_net_make_no_energy() {
    for bullet_mass in [0.005, 0.01, 0.02, 0.05] {
        let case = case_of(json!({
            "title": "heavy net", "duration_s": 1.2,
            "net": { "meshes": [8, 8], "mesh_length_m": 0.3125, "bullet_mass_kg": bullet_mass,
                     "cable": { "material": "nylon", "diameter_m": 0.002 }, "fold": { "scheme": "scaled", "ratio": 0.3 } },
            "launch": { "speed_m_s": 4.0, "angle_deg": 25.0 },
            "solver": { "cables": "explicit", "contact": "impulse" }
        }));
        below(&format!("bullets of {bullet_mass} kg: created"), kept(&case).energy_created, 1e-3);
    }
}

/// Measured: 0, 1.5e-4, 2.3e-4. Overdamped cables are known to make more than 1e-3: 1.3e-3 at damping 5 on 10 x 10.
#[test]
fn joints_make_no_energy_in_flight_whatever_their_damping() {
    for (n, damping, speed) in [(5, 0.003, 10.0), (5, 0.1, 10.0), (2, 1.0, 60.0)] {
        let kept = kept(&net("joints", n, damping, speed, opens(n, speed)));
        below(&format!("{n} x {n}, damping {damping}: created"), kept.energy_created, 1e-3);
    }
}

/// From the first contact on semi-implicit Euler takes over, in finer sub-steps; kept at its own it made 1.9e-2 here with 0.003. And with half
/// a kick: with a whole one the undamped net made 4.1e-3. Measured, the largest of eight: 4.0e-4, 5.6e-4, 5.8e-4.
#[test]
fn undamped_cables_in_contact_create_little_whatever_the_bounce() {
    for (damping, restitution) in [(0.003, 0.0), (0.0, 0.0), (0.0, 1.0)] {
        let changes = [
            "solver.cables=explicit".to_owned(),
            "solver.contact=impulse".to_owned(),
            format!("solver.restitution={restitution}"),
            format!("net.cable.damping_ratio={damping}"),
            "duration_s=1.2".to_owned(),
        ];
        let case = common::scene("cube-fixed", &changes.each_ref().map(String::as_str));
        let members = common::ensemble(&case, 8);
        let [_, _, largest] = common::spread(&members, "conservation.energy_created");
        println!("damping {damping}, restitution {restitution}: {largest:.1e}");
        below("created", largest, 2e-3);
        assert!(members.iter().all(|member| !member.conservation.is_broken()));
    }
}

/// A net that has bounced off flies as before: in the sub-steps of its flight, for semi-implicit Euler lets the energy of undamped cables wander. Of
/// drawn nets it made up to 3.8e-3 within 6 s. What pushes at it is booked for whole steps: half a sub-step more at the change was 9e-9 of the momentum.
#[test]
fn an_undamped_net_that_bounced_off_flies_as_before() {
    let case = |duration: f64| {
        case_of(json!({
            "title": "bounces off", "duration_s": duration,
            "net": { "meshes": [4, 4], "mesh_length_m": 0.3, "bullet_mass_kg": 0.05,
                     "cable": { "material": "nylon", "diameter_m": 0.001, "damping_ratio": 0.0 },
                     "fold": { "scheme": "scaled", "ratio": 0.5 } },
            "launch": { "speed_m_s": 4.0, "angle_deg": 15.0 },
            "target": { "shape": "ball-0.12", "mass_kg": 0.5, "distance_m": 1.2, "offset_m": [0.09, -0.05] },
            "effects": { "drag": { "density_kg_m3": 0.01 } }, "capture": { "hold_s": 0.0 },
            "solver": { "cables": "explicit", "contact": "impulse" }
        }))
    };
    let flown = |duration| common::run(&case(duration));
    let (flight, bounced, away) = (flown(0.1), flown(3.0), flown(4.0));
    assert!(flight.extremes.first_contact.is_none() && bounced.extremes.first_contact.is_some());
    let steps = away.work.steps - bounced.work.steps;
    assert_eq!(away.work.substeps - bounced.work.substeps, steps * flight.work.substeps / flight.work.steps);
    let kept = Conservation::of(&case(4.0), &away);
    below("created", kept.energy_created, 1e-3);
    below("momentum", kept.momentum_residual, 1e-9);
    below("angular momentum", kept.angular_momentum_residual, 1e-9);
}

/// A knot at the deepest point of a penalty contact has its speed in the contact: that it comes back makes nothing.
#[test]
fn a_bounce_off_a_penalty_force_creates_no_energy() {
    // 5e-2 while what the force holds was in no row.
    let changes = ["solver.cables=explicit", "solver.contact=penalty", "duration_s=1.0"];
    let case = common::scene("cube-fixed", &changes);
    let run = common::run(&case);
    assert!(run.extremes.first_contact.is_some());
    below("created", Conservation::of(&case, &run).energy_created, 1e-3);
}

/// A line of n pieces has n times the damping in each. Measured: explicit 0.665, 0.662 (eight pieces 0.663, in 9 s); joints 0.638, 0.640,
/// 0.643, 0.642 at 0.1, where eight pieces had 0.697, and 0.915, 0.907, 0.912, 0.913 at 0.02, where they had 0.875.
#[test]
fn a_line_that_is_cut_rebounds_as_the_whole_one() {
    for (cables, damping, cuts) in
        [("explicit", 0.1, &[1][..]), ("joints", 0.1, &[1, 2, 3, 7]), ("joints", 0.02, &[1, 2, 3, 7])]
    {
        let whole = rebound(cables, damping, 0, OWN_STEP);
        for &middle_knots in cuts {
            let cut = rebound(cables, damping, middle_knots, OWN_STEP);
            within(&format!("{cables}, {damping}, {middle_knots}"), cut / whole, [0.97, 1.03]);
        }
    }
}

/// A joint that is implicit damps by itself; that is taken off its own damping, so that finer steps come to Eq. 3.3. Measured at 0.1 ms 0.661
/// and 0.915, where Eq. 3.3 has 0.665 and 0.917; 0.623 and 0.855 with the damping left as it was.
#[test]
fn joints_that_resolve_a_snap_damp_it_as_eq_3_3_does() {
    for damping in [0.1, 0.02] {
        let (joints, explicit) =
            (rebound("joints", damping, 0, Some(1e-4)), rebound("explicit", damping, 0, OWN_STEP));
        within(&format!("at {damping}"), joints / explicit, [0.985, 1.015]);
    }
}

/// How far `run` is from its own mirror images about Y = 0, Z = 0 and Y = Z at its end [m].
fn mirror_error(case: &Case, run: &Run) -> f64 {
    let [rows, columns] = case.net().grid;
    let knots = run.frames.knots.last().unwrap();
    let at = |row: usize, column: usize| knots[row * columns + column];
    let mut worst = 0.0_f64;
    for row in 0..rows {
        for column in 0..columns {
            let here = at(row, column);
            let (y, z) = (at(rows - 1 - row, column), at(row, columns - 1 - column));
            worst = worst.max((here.x - y.x).abs().max((here.y + y.y).abs()).max((here.z - y.z).abs()));
            worst = worst.max((here.x - z.x).abs().max((here.y - z.y).abs()).max((here.z + z.z).abs()));
            let turned = at(column, row);
            worst = worst.max((here.y - turned.z).abs().max((here.z - turned.y).abs()));
        }
    }
    worst
}

/// A net with three planes of symmetry, flown for `duration` seconds.
fn mirrored(duration: f64, damping: f64, solver: &serde_json::Value) -> f64 {
    let case = case_of(json!({
        "title": "mirrored", "duration_s": duration,
        "net": { "meshes": [10, 10], "mesh_length_m": 1.0, "bullet_mass_kg": 1.0,
                 "cable": { "material": "kevlar", "diameter_m": 0.001, "damping_ratio": damping },
                 "fold": { "scheme": "scaled", "ratio": 0.05 } },
        "launch": { "speed_m_s": 10.0, "angle_deg": 55.0 },
        "solver": solver
    }));
    mirror_error(&case, &common::run(&case))
}

/// Forces are added up so that a mirrored net is one to the last bit.
#[test]
fn an_explicit_net_that_mirrors_itself_does_so_to_the_last_bit() {
    // With semi-implicit Euler and forces added up cable by cable it was 1 cm off at 0.94 s.
    let explicit = json!({ "cables": "explicit", "contact": "impulse", "integrator": "secant" });
    assert_eq!(mirrored(1.0, 0.1, &explicit), 0.0);
}

/// Snaps that overlap are one problem, whose solution does not depend on the order of the cables: one after another they
/// left it 95 mm off at 0.5 s, and over a metre at the end of the undamped one.
#[test]
fn a_net_of_joints_that_mirrors_itself_stays_mirrored_while_cables_snap() {
    let joints = json!({ "cables": "joints", "contact": "rapier" });
    below("at 0.5 s, m", mirrored(0.5, 0.1, &joints), 1e-10); // measured 1.1e-11
    below("undamped, at 1.2 s, m", mirrored(1.2, 0.0, &joints), 5e-6); // measured 4.7e-7
}

/// The step that a method takes by itself.
const OWN_STEP: Option<f64> = None;

/// Speed of the bullets outward, after the first snap over before it, of one mesh.
fn rebound(cables: &str, damping: f64, middle_knots: u32, step: Option<f64>) -> f64 {
    let mut scene = json!({
        "title": "one mesh", "duration_s": 0.25,
        "net": { "meshes": [1, 1], "mesh_length_m": 1.0, "bullet_mass_kg": 1.0, "middle_knots": middle_knots,
                 "cable": { "material": "kevlar", "diameter_m": 0.001, "damping_ratio": damping },
                 "fold": { "scheme": "scaled", "ratio": 0.05 } },
        "launch": { "speed_m_s": 10.0, "angle_deg": 55.0 },
        "output": { "sample_s": 0.001 }
    });
    scene["solver"] = json!({ "cables": cables,
                    "contact": if cables == "joints" { "rapier" } else { "impulse" } });
    if let Some(step) = step {
        scene["solver"]["step_s"] = json!(step);
    }
    let case = case_of(scene);
    let run = common::run(&case);
    let outward: Vec<f64> = run.frames.knots.iter().map(|knots| -knots[0].y).collect();
    // The snap is over well within 20 ms of the widest opening; the first crossing is 0.17 s later.
    let widest = (0..outward.len()).max_by(|a, b| outward[*a].total_cmp(&outward[*b])).unwrap();
    let speed = |from: usize| {
        (outward[from + 10] - outward[from]) / (run.frames.time[from + 10] - run.frames.time[from])
    };
    -speed(widest + 20) / speed(10)
}

/// e = exp(−π ζ / √(1 − ζ²)) with ζ = √2 ξ, of a cable whose dashpot may push at the end of the half cycle;
/// Eq. 3.3 ends the tension before, at ω_d t = π − 2 arcsin ζ, so that e is 0.917 and 0.665.
#[test]
fn four_bullets_rebound_as_the_damping_ratio_says() {
    for cables in ["explicit", "joints"] {
        for (damping, expected) in [(0.02, 0.914), (0.1, 0.638)] {
            let found = rebound(cables, damping, 0, OWN_STEP);
            // Measured: explicit 1.003 and 1.042 (Eq. 3.3 ends the tension before), joints 1.001 and 1.001.
            let band = if cables == "explicit" { [0.99, 1.05] } else { [0.98, 1.02] };
            within(&format!("{cables}, {damping}"), found / expected, band);
        }
    }
}

/// What comes from outside is the winches' work and no more: a thread that gives the net more than that, and more than what
/// drew it out beyond its reels took, has created energy. A pull for heavy ends on light knots gave 7 mW for a minute after the
/// reels stopped, and at ten times the tension twice what the winches put in, which the ledger took for work from outside.
#[test]
fn a_thread_gives_no_more_than_its_winches() {
    for (cables, contact) in [("explicit", "impulse"), ("joints", "rapier")] {
        for tension in [1.0, 10.0] {
            let changes = ["duration_s=2.5", "expect=null"].map(str::to_owned);
            let of_run = [
                format!("effects.closing.max_tension_n={tension}"),
                format!("solver.cables={cables}"),
                format!("solver.contact={contact}"),
            ];
            let case = Case::load("cubesat-spin-x-2.0-tube", &[&changes[..], &of_run].concat()).unwrap();
            let run = common::run(&case);
            let lost = closing_number(&run, "lost_j");
            let created = Conservation::of(&case, &run).energy_created;
            // Measured within 12 s: 0.10 to 0.16 J of 0.4 to 0.9 J lost, 4e-5 to 3.3e-3 created.
            within(&format!("{cables}, {tension} N, created"), created, [0.0, 9e-3]);
            within(
                &format!("{cables}, {tension} N, lost over put in"),
                lost / closing_number(&run, "winch_work_j"),
                [0.0, 0.9],
            );
        }
    }
}

fn closing_number(run: &Run, name: &str) -> f64 {
    let closing = run.reports.iter().find(|(effect, _)| *effect == "closing").unwrap();
    closing.1.numbers.as_ref().unwrap()[name].as_f64().unwrap()
}

/// Knots of 1 mm are wound around a satellite of 3.3 kg at 2 rad/s, whose friction holds them: the engine had it act where ball and
/// part touch, where these come along, and its work at the knots' centres made up to 1.2e-2, half of the members more than
/// 8e-4.
#[test]
fn friction_that_holds_does_no_work() {
    let case = common::case_of(json!({
        "title": "friction holds a net on a satellite that turns", "duration_s": 2.0,
        "net": { "meshes": [7, 6], "mesh_length_m": 0.114, "cable": { "material": "nylon", "diameter_m": 0.002 },
                 "bullet_mass_kg": 0.05, "fold": { "scheme": "scaled", "ratio": 0.5 } },
        "launch": { "speed_m_s": 2.0, "angle_deg": 25.0 },
        "target": { "shape": { "parts": [{ "cuboid": [0.2, 0.2, 0.2], "mass_kg": 3.0 },
                        { "cuboid": [0.02, 0.5, 0.2], "position_m": [0.0, 0.34, 0.0], "mass_kg": 0.3 }] },
                    "distance_m": 1.0, "spin_rad_s": [-2.1, 0.0, 0.0], "offset_m": [0.117, 0.015],
                    "attitude_deg": [50.0, -36.0, -67.0] },
        "effects": { "friction": { "coefficient": 0.6 } },
        "solver": { "cables": "joints", "contact": "rapier" }
    }));
    let [_, median, largest] = common::spread(&common::ensemble(&case, 8), "conservation.energy_created");
    // Measured 1.6e-4 and 2.0e-4.
    assert!(median < 4e-4 && largest < 2e-3, "{median:.1e}, {largest:.1e}");
}

/// Whole cables that bounce off a thin disc, in a cabin that hardly turns. Where contacts answered each half of a step's kick by itself, a bounce
/// was one off what cables had pressed in the half before: 5e-2 to 0.23.
#[test]
fn what_bounces_in_a_field_bounces_once_a_step() {
    let case = common::case_of(json!({
        "title": "wide meshes on a disc", "duration_s": 1.0,
        "net": { "meshes": [3, 3], "mesh_length_m": 0.267, "cable": { "material": "nylon", "diameter_m": 0.001 },
                 "bullet_mass_kg": 0.05, "fold": { "scheme": "scaled", "ratio": 0.5 } },
        "launch": { "speed_m_s": 4.0, "angle_deg": 15.0 },
        "target": { "shape": { "parts": [{ "cylinder": { "radius_m": 0.1, "length_m": 0.3 }, "mass_kg": 3.0 },
                        { "cylinder": { "radius_m": 0.2, "length_m": 0.02 }, "position_m": [0.0, 0.18, 0.0],
                          "mass_kg": 0.3 }] },
                    "distance_m": 1.0, "spin_rad_s": [1.04, 0.0, 0.0], "offset_m": [0.085, -0.12],
                    "attitude_deg": [4.0, 10.0, -78.0] },
        "effects": { "cable_contact": {}, "cabin": { "gravity_m_s2": [0.0, 0.0, 0.0], "rate_rad_s": [0.0, 1e-9, 0.0] } },
        "solver": { "cables": "explicit", "contact": "impulse", "restitution": 0.7 }
    }));
    let [_, median, _] = common::spread(&common::ensemble(&case, 8), "conservation.energy_created");
    assert!(median < 5e-3, "{median:.1e}"); // measured 7e-4
}

/// A satellite with a panel of 20 mm.
fn with_a_panel() -> serde_json::Value {
    json!({ "parts": [{ "cuboid": [0.2, 0.2, 0.2], "mass_kg": 3.0 },
                        { "cuboid": [0.02, 0.5, 0.2], "position_m": [0.0, 0.34, 0.0], "mass_kg": 0.3 }] })
}

/// A thin net with heavy bullets that comes into the corner between them.
fn thin_net() -> serde_json::Value {
    json!({
        "title": "heavy bullets", "duration_s": 2.0,
        "net": { "meshes": [3, 9], "mesh_length_m": 0.167, "cable": { "material": "nylon", "diameter_m": 0.0005 },
                 "bullet_mass_kg": 0.2, "fold": { "scheme": "scaled", "ratio": 0.1 } },
        "launch": { "speed_m_s": 2.0, "angle_deg": 15.0 },
        "target": { "shape": with_a_panel(), "distance_m": 1.0, "spin_rad_s": [0.0, -0.19, 0.76], "offset_m": [0.091, -0.1],
                    "attitude_deg": [-72.0, 24.0, 45.0] },
        "solver": { "cables": "explicit", "contact": "impulse" }
    })
}

/// A knot that is drawn into the corner between a satellite and its panel touches both. Held by the one it was deeper in alone, it
/// came millimetres into the other in a step, and was pushed out against its cables: 4e-3 in the middle, 3e-2 at most. Friction
/// across the corner, where each face holds already, made 4e-2 of bounces.
#[test]
fn a_knot_in_a_corner_is_held_by_both_faces() {
    let pulled_in = common::case_of(thin_net());
    let bouncing = common::case_of(json!({
        "title": "bounces and friction", "duration_s": 2.0,
        "net": { "meshes": [4, 6], "mesh_length_m": 0.133, "cable": { "material": "kevlar", "diameter_m": 0.001 },
                 "bullet_mass_kg": 0.02, "fold": { "scheme": "scaled", "ratio": 0.1 } },
        "launch": { "speed_m_s": 4.0, "angle_deg": 25.0 },
        "target": { "shape": with_a_panel(), "distance_m": 1.0, "spin_rad_s": [1.32, 0.05, 0.0], "offset_m": [0.007, 0.133],
                    "attitude_deg": [30.0, 4.0, 63.0] },
        "effects": { "friction": { "coefficient": 0.3 } },
        "solver": { "cables": "explicit", "contact": "impulse", "restitution": 1.0, "substeps": 2 }
    }));
    // Measured: 3.9e-4, 1.8e-3; 7.7e-5, 4.9e-4.
    for (case, bounds) in [(pulled_in, [1.5e-3, 1e-2]), (bouncing, [5e-4, 2e-3])] {
        let [_, median, largest] =
            common::spread(&common::ensemble(&case, 16), "conservation.energy_created");
        println!("{}: {median:.1e}, {largest:.1e}", case.scene().title);
        assert!(median < bounds[0] && largest < bounds[1], "{median:.1e}, {largest:.1e}");
    }
}

/// Cables that lie below a face between two of its edges are held at both. One place was lost where it came to a knot, or was less deep
/// than the other, and the cable sank, to be pushed out against 7 N and more: 6.7e-3, 3.9e-2 with explicit cables, 2.5e-3, 2.8e-2 with
/// the engine's.
#[test]
fn a_cable_below_a_face_is_held_at_both_edges() {
    // Measured: 1.9e-4, 5.4e-3; 2.0e-4, 6.3e-4.
    for (cables, contact, bounds) in
        [("explicit", "impulse", [1.4e-3, 2e-2]), ("joints", "rapier", [2e-3, 5e-3])]
    {
        let mut scene = thin_net();
        scene["effects"] = json!({ "cable_contact": {} });
        scene["solver"] = json!({ "cables": cables, "contact": contact });
        let members = common::ensemble(&common::case_of(scene), 16);
        let [_, median, largest] = common::spread(&members, "conservation.energy_created");
        println!("{cables}: {median:.1e}, {largest:.1e}");
        assert!(median < bounds[0] && largest < bounds[1], "{cables}: {median:.1e}, {largest:.1e}");
    }
}

/// A step whose contacts make energy is cut, and that was not asked where a body is held or driven and whole cables touch it: what its
/// surface gives to them was not known. Eight of eight members made more than 1e-3, up to 3.5e-2 on a cube that is held and 9e-3 on one
/// that turns.
#[test]
fn whole_cables_on_what_is_held_or_driven_create_little() {
    let whole = "effects.cable_contact={}";
    let joints = ["solver.cables=joints", "solver.contact=rapier", whole];
    let held = ("ball-fixed", &["duration_s=1.5"][..]);
    let driven = ("cubesat-spin-x-2.0", &["duration_s=1.5", "target.motion=spinning"][..]);
    for (scene, changes) in [held, driven] {
        let case = common::scene(scene, &[&joints[..], changes].concat());
        let [_, median, largest] = common::spread(&common::ensemble(&case, 8), "conservation.energy_created");
        println!("{scene}: {median:.1e}, {largest:.1e}");
        below(scene, largest, 1e-3);
    }
}

/// A penalty force on whole cables: the one between a bullet and a light knot was pressed in with a force made for the bullet, what was
/// found deep in was pushed out at metres a second against what held it, friction on one side of a panel was against what that on the
/// other took at once, and a knot that a thread had whipped to 40 m/s was found so deep in that it left at 200. In 48 members 2.2e-6, 1.1 and
/// three states that were no numbers; 2.6e-3, 0.14; 3.4e-3, 0.34.
#[test]
fn a_penalty_force_on_whole_cables_makes_little() {
    let net = |meshes: [u32; 2], mesh: f64, bullet: f64, cable: serde_json::Value, fold: f64| {
        json!({ "meshes": meshes, "mesh_length_m": mesh, "bullet_mass_kg": bullet, "cable": cable,
                "fold": { "scheme": "scaled", "ratio": fold } })
    };
    let whipped = json!({
        "title": "whipped by a thread",
        "net": net([5, 4], 0.16, 0.2, json!({ "material": "spectra", "diameter_m": 0.0005 }), 0.5),
        "launch": { "speed_m_s": 2.0, "angle_deg": 40.0 },
        "target": { "shape": with_a_panel(), "distance_m": 0.8, "spin_rad_s": [0.528, -0.778, 0.754], "offset_m": [-0.021, 0.027],
                    "attitude_deg": [26.093, -10.753, -88.798] },
        "effects": { "cable_contact": {}, "closing": { "layout": "interlaced", "trigger": { "on": "contact", "delay_s": 0.05 },
                     "reel_speed_m_s": 2.0, "max_tension_n": 2.0 } }
    });
    let pushed_out = json!({
        "title": "soft cables around a light cube",
        "net": net([6, 6], 0.133, 0.2, json!({ "material": "nylon", "diameter_m": 0.0005, "damping_ratio": 0.5 }), 0.1),
        "launch": { "speed_m_s": 4.0, "angle_deg": 25.0 },
        "target": { "shape": "cube-0.16", "mass_kg": 0.5, "distance_m": 1.2, "spin_rad_s": [1.184, -1.566, 0.133],
                    "offset_m": [0.073, -0.085], "attitude_deg": [45.359, -69.611, 38.073] },
        "effects": { "cable_contact": {} }
    });
    let rubbing = json!({
        "title": "friction on both sides of a panel",
        "net": net([3, 3], 0.267, 0.2, json!({ "material": "spectra", "diameter_m": 0.001 }), 0.3),
        "launch": { "speed_m_s": 4.0, "angle_deg": 15.0 },
        "target": { "shape": { "parts": [{ "cuboid": [0.2, 0.2, 0.2], "mass_kg": 4.0 },
                        { "cuboid": [0.15, 0.4, 0.01], "position_m": [0.0, 0.325, 0.0], "mass_kg": 0.3 },
                        { "cuboid": [0.15, 0.4, 0.01], "position_m": [0.0, -0.325, 0.0], "mass_kg": 0.3 },
                        { "cylinder": { "radius_m": 0.075, "length_m": 0.025 }, "position_m": [0.1125, 0.0, 0.0],
                          "attitude_deg": [0.0, 0.0, 90.0], "mass_kg": 0.1 }] },
                    "distance_m": 1.2, "spin_rad_s": [-1.404, 2.001, 1.496], "offset_m": [-0.027, 0.042],
                    "attitude_deg": [49.118, 2.115, 1.788] },
        "effects": { "cable_contact": {}, "friction": { "coefficient": 1.0 } }
    });
    // Measured: 2.3e-6, 4.3e-6; 8.9e-15, 1.3e-5 (4.1e-9, 5.1e-4 of others); 1.0e-5, 1.5e-4.
    for mut scene in [whipped, pushed_out, rubbing] {
        scene["duration_s"] = json!(1.2);
        scene["solver"] = json!({ "cables": "explicit", "contact": "penalty" });
        let case = common::case_of(scene);
        let [_, median, largest] = common::spread(&common::ensemble(&case, 8), "conservation.energy_created");
        println!("{}: {median:.1e}, {largest:.1e}", case.scene().title);
        assert!(median < 1e-4 && largest < 5e-3, "{}: {median:.1e}, {largest:.1e}", case.scene().title);
    }
}

/// A mesh of Kevlar that has come over a ball is drawn tight around it by heavy bullets. Planes fixed to the ball let a cable that
/// rocks about its place come in beside it, and pushed it out again: 2.6e-2 in the middle, 4.3e-2 at most.
#[test]
fn a_cable_that_rocks_on_a_ball_is_held_where_it_is_nearest() {
    let case = common::case_of(json!({
        "title": "a mesh around a ball", "duration_s": 1.2,
        "net": { "meshes": [5, 5], "mesh_length_m": 0.24, "bullet_mass_kg": 0.2,
                 "cable": { "material": "kevlar", "diameter_m": 0.001, "damping_ratio": 0.1 },
                 "fold": { "scheme": "scaled", "ratio": 0.5 } },
        "launch": { "speed_m_s": 2.0, "angle_deg": 40.0 },
        "target": { "shape": "ball-0.12", "mass_kg": 3.5, "distance_m": 0.8, "spin_rad_s": [-1.621, -1.554, -0.234],
                    "offset_m": [-0.002, 0.012] },
        "effects": { "cable_contact": {} },
        "solver": { "cables": "explicit", "contact": "impulse" }
    }));
    let members = common::ensemble(&case, 8);
    let [_, median, largest] = common::spread(&members, "conservation.energy_created");
    assert!(
        members.iter().all(|member| member.contact.is_some_and(|contact| contact.max_impulse_n_s > 0.01))
    );
    assert!(median < 5e-5 && largest < 2e-4, "{median:.1e}, {largest:.1e}"); // measured 2.8e-6, 5.8e-6
}

/// Nets that threads draw around the edges of a Cubesat. Cables that slid over an edge and turned meanwhile were pushed out of it
/// again: 1.1e-3 and 1.7e-3 with a cinch, 5.9e-3 at most with a free thread. And a cinch whose bunched segments were not settled
/// pulled with no winch behind it: 3.8e-3 and 1.1e-2 with friction. One that pushed for what was foreseen to press it gave 5e-3 in one of
/// eight tubes. Segments that began each step from nothing and told each other in two passes, all in one direction, gave 1.6e-2 in one of 48, and a strong
/// winch on a cinch, whose 46 segments need more than ten passes, up to 7.8e-3. A thread that was pulled without the latches that act after it pushed into
/// them: 5.4e-3 and 1.4e-2. Friction on knots as if the thread slid towards its winch wherever they went: 0.10, 0.26.
#[test]
fn what_threads_draw_around_edges_makes_little() {
    let (cables, friction) = ("effects.cable_contact={}", r#"effects.friction={"coefficient":0.3}"#);
    let (latches, capstan) = ("effects.closing.lock=true", "effects.closing.thread_friction=0.2");
    // Median and largest of four; of eight were measured 9.6e-6 and 2.1e-5, 3.0e-5 and 1.1e-4, 1.7e-5 and 2.4e-4, 9.6e-6 and 2.4e-5, 1.5e-5 and 2.9e-5,
    // 2.5e-5 and 3.9e-5, 1.1e-8 and 1.5e-6.
    for (name, effects, bounds) in [
        ("cubesat-spin-x-2.0-cinch", vec![cables], [1e-4, 3e-4]),
        ("cubesat-spin-z-2.0-free", vec![cables], [1e-4, 3e-4]),
        ("cubesat-spin-z-2.0-cinch", vec![friction], [2e-4, 1e-3]),
        ("cubesat-spin-z-2.0-tube", vec![cables, friction], [1e-4, 5e-4]),
        ("cubesat-spin-z-2.0-cinch", vec!["effects.closing.max_tension_n=5"], [1e-4, 5e-4]),
        ("cubesat-spin-x-2.0-tube", vec![latches], [2e-4, 1e-3]),
        ("cubesat-spin-z-2.0-cinch", vec![capstan], [1e-5, 2e-4]),
    ] {
        let mut changes = vec!["solver.cables=explicit", "solver.contact=impulse", "duration_s=3"];
        changes.extend(effects);
        let members = common::ensemble(&common::scene(name, &changes), 4);
        let [_, median, largest] = common::spread(&members, "conservation.energy_created");
        println!("{name}: {median:.1e}, {largest:.1e}");
        assert!(median < bounds[0] && largest < bounds[1], "{name}: {median:.1e}, {largest:.1e}");
    }
}

/// Under joints a step that makes energy is cut, and that has to hear of all that may make it. A driven surface was not heard of: a
/// coefficient of 10 at 20 rad/s made 1.0e-2 in the middle and 0.11 at most. What a thread gave was asked of each step alone: 1.0e-3, 5.8e-3. And
/// strands that had gone through each other were pushed back, some this way and some that: 1.9e-4, 3e-2. Latches took back what the engine's cables had
/// parted: 0.2, 8e2; a strong thread that did not know of those that the engine holds 1.1e-3, 1.4e-2.
#[test]
fn what_rubs_winds_and_jams_under_joints_makes_little() {
    // Median and largest of three; of eight were measured 1.2e-4 and 1.5e-4, 1.3e-4 and 2.0e-4, 1.9e-4 and 2.0e-4, of six 1.8e-4 and 4.6e-4.
    for (name, changes) in [
        (
            "cubesat-free",
            vec![
                r#"effects.friction={"coefficient":10}"#,
                "target.motion=spinning",
                "target.spin_rad_s=[0,20,0]",
                "duration_s=1.5",
            ],
        ),
        ("cubesat-spin-x-2.0-cinch", vec![r#"effects.friction={"coefficient":0.3}"#, "duration_s=2.4"]),
        ("cubesat-free", vec!["effects.self_contact={}", "duration_s=3"]),
        (
            "cubesat-spin-x-2.0-tube",
            vec!["effects.closing.lock=true", "effects.closing.max_tension_n=20", "duration_s=1.6"],
        ),
    ] {
        let mut all = vec!["solver.cables=joints", "solver.contact=rapier"];
        all.extend(&changes);
        let members = common::ensemble(&common::scene(name, &all), 3);
        let [_, median, largest] = common::spread(&members, "conservation.energy_created");
        println!("{changes:?}: {median:.1e}, {largest:.1e}");
        assert!(median < 4e-4 && largest < 1.5e-3, "{changes:?}: {median:.1e}, {largest:.1e}");
    }
}

/// Energy at the end that cables took by their law, and what rows took beyond it, over the launch energy [-].
fn taken(case: &Case, run: &Run) -> (f64, Option<f64>) {
    let ledger = run.frames.ledger.last().expect("a run has frames");
    let launch = case.net().launch_energy();
    (ledger.cables / launch, ledger.solver.map(|taken| taken / launch))
}

/// Weighed with the velocities of the whole step, impulses of a contact and of the cables that press on it were told apart wrongly: these undamped
/// cables took 0.04 to 0.14 of the launch energy, however short the sub-steps. Measured: 2.7e-4 at most.
#[test]
fn undamped_explicit_cables_take_nothing_whatever_they_meet() {
    let meets: [&[&str]; 6] = [
        &["solver.contact=impulse"],
        &["solver.contact=penalty"],
        &["solver.contact=impulse", "solver.restitution=0.7"],
        &["solver.contact=impulse", "effects.friction={\"coefficient\":0.5}"],
        &["solver.contact=impulse", "effects.cable_contact={}"],
        &["solver.contact=impulse", "effects.self_contact={}"],
    ];
    for changes in meets {
        let case = common::scene(
            "cubesat-free",
            &[&["solver.cables=explicit", "net.cable.damping_ratio=0", "duration_s=2"], changes].concat(),
        );
        let (cables, solver) = taken(&case, &common::run(&case));
        let method = solver.expect("it has met something");
        println!("{changes:?}: {cables:.1e}, beside the law {method:.1e}");
        below(&format!("{changes:?}: by law"), cables.abs(), 1e-12);
        below(&format!("{changes:?}"), (cables + method).abs(), 5e-3);
    }
}

/// What cables take is found by their law, so what a method makes or destroys in a flight is in no row, and cannot hide among it. Measured of
/// the launch energy: symplectic 0.31 (made 0.32) undamped and 2e-3 at 0.1; rk4 0.26 undamped, which creates nothing; located 9e-6.
#[test]
fn what_a_method_makes_or_destroys_in_flight_is_told() {
    let flown = |integrator: &str, damping: &str| {
        let damping = format!("net.cable.damping_ratio={damping}");
        let integrator = format!("solver.integrator={integrator}");
        let changes =
            ["solver.cables=explicit", "solver.contact=impulse", "duration_s=1", &integrator, &damping];
        let found = kept(&common::scene("deployment-kevlar", &changes));
        println!(
            "{integrator}, {damping}: {:.1e}, created {:.1e}",
            found.energy_residual, found.energy_created
        );
        found
    };
    let makes = flown("symplectic", "0");
    assert!(makes.energy_created > 0.1 && makes.energy_residual > 0.9 * makes.energy_created, "{makes:?}");
    let destroys = flown("rk4", "0");
    assert!(destroys.energy_residual > 0.1 && destroys.energy_created < 0.01, "{destroys:?}");
    for (integrator, damping, most) in [
        ("symplectic", "0.1", 1e-2),
        ("rk4", "0.1", 3e-3),
        ("located", "0", 1e-4),
        ("located", "0.1", 1e-5),
        ("located", "1", 1e-6),
    ] {
        below(&format!("{integrator} at {damping}"), flown(integrator, damping).energy_residual, most);
    }
}

/// The same once something is met: what is missing beside the cables' law, contacts and effects is the method's. What forces on knots and cables gave was weighed
/// before strands had acted on them, and of the launch energy 0.05 to 0.62 was in the wrong rows. Under `rk4` and `located` contacts gave cables 1.7 to 3.4 of it
/// and took as much again, in rows that read minus 1.7 and 2.3. Measured: at most 0.010.
#[test]
fn explicit_methods_take_little_beside_the_law_whatever_they_meet() {
    let meets: [(&str, &[&str]); 12] = [
        ("cubesat-free", &["solver.contact=impulse", "solver.integrator=rk4"]),
        ("cubesat-free", &["solver.contact=penalty", "solver.integrator=rk4"]),
        ("cubesat-spin-x-2.0-tube", &["solver.contact=impulse", "solver.integrator=rk4"]),
        ("cubesat-free", &["solver.contact=impulse", "solver.integrator=located"]),
        ("cubesat-free", &["solver.contact=impulse"]),
        ("cubesat-free", &["solver.contact=penalty"]),
        ("cubesat-free", &["solver.contact=penalty", "effects.self_contact={}"]),
        ("cubesat-free", &["solver.contact=impulse", "solver.restitution=0.8"]),
        (
            "cubesat-free",
            &["solver.contact=impulse", "effects.cable_contact={}", "effects.friction={\"coefficient\":0.5}"],
        ),
        (
            "cubesat-spin-x-2.0-tube",
            &["solver.contact=penalty", "effects.self_contact={}", "effects.friction={\"coefficient\":0.5}"],
        ),
        ("cubesat-spin-x-2.0-tube", &["solver.contact=impulse"]),
        (
            "cubesat-free",
            &[
                "solver.contact=penalty",
                "effects.self_contact={}",
                "effects.cable_contact={}",
                "effects.friction={\"coefficient\":0.5}",
            ],
        ),
    ];
    for (name, changes) in meets {
        let case = common::scene(name, &[&["solver.cables=explicit", "duration_s=2"], changes].concat());
        let run = common::run(&case);
        let (cables, method) = taken(&case, &run);
        let method = method.expect("it has met something");
        println!("{name}, {changes:?}: by law {cables:.3}, beside it {method:.4}");
        assert!(cables > 0.1, "{name}, {changes:?}: cables took {cables}");
        below(&format!("{name}, {changes:?}"), method.abs(), 0.05);
        let contacts =
            run.frames.ledger.last().map_or(0.0, |ledger| ledger.contact) / case.net().launch_energy();
        assert!((0.0..1.5).contains(&contacts), "{name}, {changes:?}: contacts took {contacts}");
    }
}

/// A net of 2 g between bullets of 0.2 kg, whose cables are drawn taut again and again.
fn light_net(cables: &str, damping: f64, loss_tolerance: f64) -> Case {
    case_of(json!({
        "title": "light net", "duration_s": 0.6,
        "net": { "meshes": [2, 6], "mesh_length_m": 0.2, "bullet_mass_kg": 0.2,
                 "cable": { "material": "zylon", "diameter_m": 0.0005, "damping_ratio": damping },
                 "fold": { "scheme": "scaled", "ratio": 0.5 } },
        "launch": { "speed_m_s": 8.0, "angle_deg": 40.0 },
        "solver": { "cables": cables, "contact": if cables == "joints" { "rapier" } else { "impulse" },
                    "loss_tolerance": loss_tolerance }
    }))
}

/// What rows take by being solved implicitly is not the cables'. Where they may take what they like, these took by their law, as joints and as
/// explicit ones, 0 and 0 of the launch energy undamped, 0.061 and 0.049 at 0.3; rows 0.17 and 0 beyond it.
#[test]
fn what_implicit_rows_take_is_told_from_what_cables_take() {
    for damping in [0.0, 0.3] {
        let [(case, run), (other, flown)] = ["joints", "explicit"].map(|cables| {
            let case = light_net(cables, damping, 100.0);
            let run = common::run(&case);
            (case, run)
        });
        let ((by_law, by_rows), (explicit, none)) = (taken(&case, &run), taken(&other, &flown));
        println!("damping {damping}: by law {by_law:.3}, explicit {explicit:.3}, beyond it {by_rows:?}");
        below(&format!("damping {damping}: by law, apart"), (by_law - explicit).abs(), 0.03);
        assert_eq!(by_rows.expect("joints are rows") > 0.1, damping == 0.0, "damping {damping}");
        assert!(none.is_none(), "explicit cables are no rows");
        below(&format!("damping {damping}: in no row"), Conservation::of(&case, &run).energy_residual, 1e-9);
        let curves = Curves::of(&case, &run);
        let said =
            warnings::after(&case, &run, &curves).iter().any(|warning| warning.contains("implicit rows"));
        assert_eq!(said, damping == 0.0, "damping {damping}: a warning where rows took more than 0.1");
    }
}

/// Steps in which rows would take more are cut, and what cables take then is what explicit ones do. Measured: by rows at most
/// 8.1e-3, by law at most 1.2e-2 apart.
#[test]
fn rows_take_no_more_in_flight_than_they_may() {
    for damping in [0.0, 0.3] {
        let [joints, explicit] = ["joints", "explicit"].map(|cables| {
            let case = light_net(cables, damping, 0.15);
            taken(&case, &common::run(&case))
        });
        println!("damping {damping}: {joints:?}, explicit {explicit:?}");
        below(&format!("damping {damping}: by rows"), joints.1.expect("joints are rows"), 1e-2);
        below(&format!("damping {damping}: apart"), (joints.0 - explicit.0).abs(), 0.03);
    }
}

/// Over the launch energy, at the own step: meshes, damping ratio and launch speed [m/s]. Measured: at most 9.2e-3 (created 3e-4), and nothing
/// where cables only snap.
#[test]
fn implicit_rows_take_little_of_a_net_in_flight() {
    let nets =
        [1, 2, 4, 10].into_iter().flat_map(|n| [0.0, 0.003, 0.1, 1.0, 5.0].map(|damping| (n, damping)));
    let slow = nets.map(|(n, damping)| (n, damping, 10.0));
    let fast = [2, 4, 10].into_iter().flat_map(|n| [0.0, 0.003, 0.03, 0.1].map(|damping| (n, damping, 60.0)));
    let others = [(4, 0.1, 1.0), (2, 0.0, 30.0), (4, 0.1, 30.0), (10, 0.0, 30.0), (20, 0.1, 60.0)];
    for (n, damping, speed) in slow.chain(fast).chain(others) {
        let case = net("joints", n, damping, speed, if speed > 30.0 { 0.3 } else { 10.0 / speed });
        let run = common::run(&case);
        let (_, by_rows) = taken(&case, &run);
        let name = format!("{n} x {n}, damping {damping}, {speed} m/s");
        let most = if damping < 0.01 && speed == 10.0 { 1e-9 } else { 1e-2 };
        below(&format!("{name}: by rows"), by_rows.expect("joints are rows"), most);
        below(&format!("{name}: created"), Conservation::of(&case, &run).energy_created, 1e-3);
    }
}

/// Knots that move by the mean of their velocities, in steps of a thirtieth of a cable's half cycle; bullets are shot one after another. Measured: knots
/// 0.05 mm apart (24 by the engine's own motion), rows take 1e-7 of the launch energy (3e-4).
#[test]
fn a_net_that_steps_resolve_flies_as_an_explicit_one() {
    let fly = |method: &[&str]| {
        let shot =
            ["net.cable.damping_ratio=0.003", "launch.bullets.delay_s=[0,0.01,0,0.005]", "duration_s=0.15"];
        let case = common::scene("deployment-kevlar", &[method, &shot].concat());
        let run = common::run(&case);
        (case, run)
    };
    let (case, joints) = fly(&["solver.step_s=1e-5"]);
    let (_, explicit) = fly(&["solver.cables=explicit", "solver.contact=impulse", "solver.step_s=2e-6"]);
    let [end, other] = [&joints, &explicit].map(|run| run.frames.knots.last().expect("a frame"));
    let apart = end.iter().zip(other).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let (_, by_rows) = taken(&case, &joints);
    let by_rows = by_rows.expect("joints are rows");
    let kept = Conservation::of(&case, &joints);
    println!("{apart} m apart, by rows {by_rows}, {kept:?}");
    below("apart", apart, 5e-4);
    below("by rows", by_rows.abs(), 1e-6);
    below("created", kept.energy_created, 1e-7);
    below("angular momentum", kept.angular_momentum_residual, 1e-12);
}

/// Around a free Cubesat rows took 0.11 of the launch energy in 3 s with nothing asked of them. Measured: 0.010 in 2 s.
#[test]
fn rows_take_no_more_around_a_target_than_they_may() {
    let case = common::scene("cubesat-free", &["solver.loss_tolerance=0.01", "duration_s=2"]);
    let (_, by_rows) = taken(&case, &common::run(&case));
    println!("by rows {by_rows:?}");
    below("by rows", by_rows.expect("joints are rows"), 2e-2);
}
