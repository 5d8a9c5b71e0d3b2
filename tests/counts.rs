//! A scene pays only for what it lists.

use crate::common;

use crate::common::{run, scene, small_scene};
use serde_json::{Value, json};
use tumblenet::assets::Kind;
use tumblenet::case::Case;
use tumblenet::run::Run;
use tumblenet::simulation::Simulation;
use tumblenet::world::Census;

/// Knots, cables and parts of each built-in scene, by hand: (n + 1)² knots and 2 n (n + 1) cables.
#[test]
fn bodies_colliders_and_joints_are_what_the_scene_lists() {
    for name in Kind::Scene.names() {
        let case = scene(name, &["effects=null"]);
        let (n_knots, n_cables) = match name.split('-').next().unwrap() {
            "deployment" | "cubesat" => (121, 220),
            "envisat" if name.contains("mockup") => (121, 220),
            "cube" | "ball" | "cylinder" => (81, 144),
            "panel" => (441, 840),
            "stage" | "envisat" => (441, 840),
            other => panic!("count the net of {other} by hand"),
        };
        let n_parts = case.target().map_or(0, |target| target.parts.len());
        let expected = match n_parts {
            0 => Census { bodies: n_knots, colliders: 0, joints: n_cables },
            _ => Census { bodies: n_knots + 1, colliders: n_knots + n_parts, joints: n_cables },
        };
        assert_eq!(Simulation::new(&case).census(), expected, "{name}");
        assert_eq!(n_parts == 0, name.starts_with("deployment"), "{name}");
    }
}

#[test]
fn without_a_target_nothing_is_detected() {
    let run = run(&scene("deployment-kevlar", &["duration_s=0.05"]));
    assert_eq!((run.census.colliders, run.work.detections, run.work.contacts), (0, 0, 0));
}

/// First level of detection: the boxes of net and target are apart for the first 0.7 s.
#[test]
fn a_net_on_its_way_detects_nothing() {
    let run = run(&scene("cubesat-free", &["duration_s=0.7"]));
    assert_eq!(run.work.detections, 0);
}

/// The positions of every recorded frame, to the last bit.
fn bits(run: &Run) -> Vec<u64> {
    let coordinates = run.frames.knots.iter().flatten().flat_map(|knot| [knot.x, knot.y, knot.z]);
    coordinates.map(f64::to_bits).collect()
}

/// A small net around a box that tumbles.
fn small_capture(changes: Value) -> Value {
    let mut scene = small_scene();
    scene["target"] = json!({
        "shape": { "parts": [{ "cuboid": [0.08, 0.25, 0.15] }] },
        "distance_m": 0.3, "mass_kg": 1.0, "spin_rad_s": [0.5, 0.2, 0.0]
    });
    for (key, value) in changes.as_object().unwrap() {
        scene[key] = value.clone();
    }
    scene
}

#[test]
fn friction_of_coefficient_zero_changes_no_bit() {
    let absent = run(&common::case_of(small_capture(json!({}))));
    let zero =
        run(&common::case_of(small_capture(json!({ "effects": { "friction": { "coefficient": 0.0 } } }))));
    let some =
        run(&common::case_of(small_capture(json!({ "effects": { "friction": { "coefficient": 0.3 } } }))));
    assert!(absent.work.contacts > 100, "{:?}", absent.work);
    assert_eq!(bits(&absent), bits(&zero));
    assert_ne!(bits(&absent), bits(&some), "friction acts");
    assert!(absent.effects.is_empty());
    assert_eq!(zero.effects, [("friction", 0)]);
}

/// The same value with the keys of every object in reverse order.
fn reversed(value: &Value) -> Value {
    match value {
        Value::Object(map) => map.iter().rev().map(|(key, below)| (key.clone(), reversed(below))).collect(),
        Value::Array(list) => list.iter().map(reversed).collect(),
        other => other.clone(),
    }
}

#[test]
fn the_order_of_keys_in_a_file_changes_nothing() {
    let forward = small_capture(json!({ "effects": { "friction": { "coefficient": 0.3 } } }));
    let backward = reversed(&forward);
    assert_ne!(forward.to_string(), backward.to_string());
    let build = |json| -> Case { common::case_of(json) };
    let (forward, backward) = (build(forward), build(backward));
    assert_eq!(forward.hash(), backward.hash());
    assert_eq!(bits(&run(&forward)), bits(&run(&backward)));
}

#[test]
fn a_hash_tells_scenes_and_shapes_apart() {
    let hash = |changes| common::case_of(small_capture(changes)).hash().to_owned();
    let plain = hash(json!({}));
    assert_ne!(plain, hash(json!({ "duration_s": 0.6 })));
    assert_ne!(plain, hash(json!({ "solver": { "restitution": 0.5 } })));
    // A default written out is the same scene.
    assert_eq!(plain, hash(json!({ "solver": { "restitution": 0.0 }, "effects": {} })));
}
