//! A scene with sound parts in the place of those that the schema refuses, so that what the rest means is checked
//! all the same: every fault is told at once.

use serde_json::{Map, Value, json};

use super::schema::Scene;
use crate::problems::{Problem, Problems};
use crate::read;
use crate::target::repair::{self as shape, related};

/// A scene that was made readable.
pub struct Repaired {
    /// The scene.
    pub scene: Scene,
    /// What was replaced or left out, as `section` or `section.key`.
    places: Vec<String>,
}

/// Makes the scene `json` readable, in which the schema found `faults`; none where that does not succeed.
pub fn repaired(json: &Value, faults: &[Problem]) -> Option<Repaired> {
    let sound = sound();
    // Cables, parts of a shape and other sections key by key; then cables as a whole; then all of the shape; then whole sections.
    [(3, true), (2, true), (2, false), (1, false)].into_iter().find_map(|(depth, in_shape)| {
        let mut json = json.clone();
        let below = |fault: &&Problem| in_shape && fault.place.starts_with(SHAPE);
        let (in_shape, others): (Vec<&Problem>, Vec<&Problem>) = faults.iter().partition(below);
        let deep = |place: &str| if related(place, "net") { depth } else { depth.min(2) };
        let mut places: Vec<String> =
            others.iter().map(|fault| above(&fault.place, deep(&fault.place)).to_owned()).collect();
        let scene = json.as_object_mut()?;
        places.iter().for_each(|place| repair(scene, &sound, place));
        if !in_shape.is_empty() {
            let of_target = json.pointer_mut("/target/shape")?;
            let parts = shape::repair(of_target, in_shape.iter().map(|fault| &fault.place[SHAPE.len()..]))?;
            places.extend(parts.into_iter().map(|part| format!("{SHAPE}{part}")));
        }
        let scene = read::typed(&json, "", &mut Problems::new(""))?;
        Some(Repaired { scene, places })
    })
}

/// How places in a shape begin that stands in the scene itself.
const SHAPE: &str = "target.shape.";

/// Where the step stands, and what it is chosen by.
const STEP: &str = "solver.step_s";
const OF_THE_STEP: [&str; 8] =
    ["duration_s", "net", "launch", "target", "solver", "output", "effects.closing", "effects.tug"];

impl Repaired {
    /// Whether all that the step is chosen by stands as it was written.
    pub fn is_stepped_as_written(&self) -> bool {
        self.is_genuine(STEP)
    }

    /// Whether a fault that was found at `place` is one of the scene as it was written.
    pub fn is_genuine(&self, place: &str) -> bool {
        let own = [place];
        let needed = own.iter().chain(needs(place));
        needed.copied().all(|needed| !self.places.iter().any(|repaired| related(repaired, needed)))
    }
}

/// What else a fault at `place` may come from.
fn needs(place: &str) -> &'static [&'static str] {
    match place.split(['.', '[', '(']).next().unwrap_or_default() {
        "duration_s" => &OF_THE_STEP,
        "solver" if place == STEP => &OF_THE_STEP,
        // How the parts of a method go together.
        "solver" => &["solver"],
        "output" => &["duration_s", "net"],
        "capture" => &["duration_s", "target"],
        "expect" => &["target"],
        "effects" if place.contains(".trigger.") || place.contains(".start.") => &["target"],
        "effects" if place.starts_with("effects.chaser") => &["launch"],
        "effects" if place.ends_with("_contact") => &["solver"],
        "net" if place.starts_with("net.meshes") || place.starts_with("net.fold") => {
            &["net.meshes", "net.middle_knots", "net.fold"]
        }
        "target" if place.ends_with("inertia_kg_m2") || place.starts_with("target.mass_kg") => {
            &["target.shape", "target.mass_kg", "target.motion"]
        }
        _ => &[],
    }
}

/// The first `depth` keys of `place`.
fn above(place: &str, depth: usize) -> &str {
    let ends = place.match_indices(['.', '[', '(']).map(|(index, _)| index).chain([place.len()]);
    let mut end = place.len();
    for (n_keys, index) in (1..).zip(ends) {
        if n_keys == depth || !place[index..].starts_with('.') {
            end = index;
            break;
        }
    }
    &place[..end]
}

/// A scene in which nothing is wrong.
fn sound() -> Value {
    json!({
        "title": "", "duration_s": 1.0,
        "net": { "meshes": [1, 1], "mesh_length_m": 1.0, "bullet_mass_kg": 1.0,
                 "cable": { "material": "nylon", "diameter_m": 1e-3 } },
        "launch": { "speed_m_s": 1.0, "angle_deg": 0.0 },
        "target": { "shape": "ball-0.08", "distance_m": 1.0, "mass_kg": 1.0 }
    })
}

/// Puts the value that is `sound` at `place` of a `map` where one must stand, and nothing where none must.
fn repair(map: &mut Map<String, Value>, sound: &Value, place: &str) {
    if let Some((section, key)) = place.split_once('.') {
        return match map.get_mut(section).and_then(Value::as_object_mut) {
            Some(inner) => repair(inner, &sound[section], key),
            None => repair(map, sound, section),
        };
    }
    match sound.get(place) {
        // A target that is left out is no fault; one that is no target needs not be there.
        Some(value) if place != "target" => drop(map.insert(place.to_owned(), value.clone())),
        _ => drop(map.shift_remove(place)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Case;
    use crate::limits::Limits;
    use crate::scene::Source;

    fn places(json: Value) -> Vec<String> {
        let source =
            Source { name: "t".into(), input: "t".into(), folder: None, json, limits: Limits::default() };
        let Err(problems) = Case::build(&source) else { return Vec::new() };
        problems.list.into_iter().map(|problem| problem.place).collect()
    }

    fn scene() -> Value {
        json!({
            "title": "t", "duration_s": 1.0,
            "net": { "meshes": [2, 2], "mesh_length_m": 1.0, "bullet_mass_kg": 1.0,
                     "cable": { "material": "kevlar", "diameter_m": 0.001 } },
            "launch": { "speed_m_s": 1.0, "angle_deg": 30.0 },
            "target": { "shape": { "parts": [{ "cuboid": [1, 1, 1] }] }, "distance_m": 5.0, "mass_kg": 1.0 }
        })
    }

    #[test]
    fn a_fault_of_the_schema_hides_none_of_meaning() {
        assert_eq!(places(scene()), Vec::<String>::new());
        let mut bad = scene();
        bad["launch"]["angle_deg"] = json!(-5);
        bad["colour"] = json!("red");
        bad["net"]["cable"]["material"] = json!("wood");
        bad["target"]["shape"] = json!("moon");
        bad["expect"] = json!({ "within": { "no.such": [1, 0] } });
        bad["capture"] = json!({ "hold_s": 9 });
        let found = places(bad);
        for place in [
            "launch.angle_deg",
            "colour",
            "net.cable.material",
            "target.shape",
            "expect.within.no.such",
            "capture.hold_s",
        ] {
            assert!(found.iter().any(|known| known == place), "{place} not in {found:?}");
        }
        assert_eq!(found.len(), 7, "{found:?}"); // the band is none, besides

        let mut bad = scene();
        bad["net"]["cable"] =
            json!({ "material": "wood", "diameter_m": 1e-3, "damping_ratio": -1, "colour": "red" });
        bad["net"]["edge_cable"] = json!({ "material": "stone", "diameter_m": 0 });
        assert_eq!(
            places(bad),
            [
                "net.cable.damping_ratio",
                "net.cable.colour",
                "net.edge_cable.diameter_m",
                "net.cable.material",
                "net.edge_cable.material"
            ]
        );
    }

    #[test]
    fn a_fault_elsewhere_hides_none_of_the_method_nor_of_its_step() {
        let mut bad = scene();
        bad["effects"] = json!({ "frictoin": {} });
        bad["solver"] =
            json!({ "step_s": 0.9, "cables": "explicit", "contact": "penalty", "restitution": 0.5 });
        bad["target"]["distance_m"] = json!(0.1);
        assert_eq!(
            places(bad.clone()),
            ["effects.frictoin", "solver.restitution", "solver.step_s", "target.distance_m", "solver.step_s"]
        );
        // With another net another step might do.
        bad["net"]["bullet_mass_kg"] = json!(-1);
        assert_eq!(places(bad), ["net.bullet_mass_kg", "effects.frictoin", "solver.restitution"]);
    }

    #[test]
    fn a_faulty_part_hides_no_fault_of_another() {
        let parts = json!([
            { "cuboid": [0, 1, 1] }, { "mesh": { "file": "nowhere.obj" } }, { "ball": { "radius_m": 0.1 } },
            { "ball": { "radius_m": 0.1 }, "cuboid": [1, 1, 1] }
        ]);
        let mut bad = scene();
        bad["target"]["shape"] = json!({ "parts": parts, "inertia_kg_m2": 3 });
        let part = |i: usize, below: &str| format!("target.shape.parts[{i}]{below}");
        let inertia = "target.shape.inertia_kg_m2".to_owned();
        assert_eq!(places(bad.clone()), [part(0, ".cuboid[0]"), inertia, part(1, ".mesh.file"), part(3, "")]);

        // The same in a file.
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("shape.json"), bad["target"]["shape"].to_string()).unwrap();
        bad["target"]["shape"] = json!("shape.json");
        let of_file = |place: String| place.replace("target.shape.", "target.shape(shape.json).");
        let source = Source {
            name: "t".into(),
            input: "t".into(),
            folder: Some(folder.path().to_path_buf()),
            json: bad,
            limits: Limits::default(),
        };
        let problems = Case::build(&source).err().unwrap();
        let found: Vec<&str> = problems.list.iter().map(|problem| problem.place.as_str()).collect();
        let inertia = "target.shape(shape.json).inertia_kg_m2".to_owned();
        assert_eq!(
            found,
            [of_file(part(0, ".cuboid[0]")), inertia, of_file(part(1, ".mesh.file")), of_file(part(3, ""))]
        );
    }

    #[test]
    fn what_stands_in_for_a_fault_brings_none() {
        for (pointer, value) in [
            ("/duration_s", json!("long")),
            ("/net", json!(3)),
            ("/net/meshes", json!([0, 2.5])),
            ("/net/cable", json!({ "diameter_m": 3 })),
            ("/net/cable/diameter_m", json!(-3)),
            ("/launch", json!([])),
            ("/target", json!(7)),
            ("/target/shape", json!({ "parts": [{ "cuboid": [0, 1, 1] }] })),
            ("/target/mass_kg", json!(-1)),
            ("/solver", json!({ "substeps": 0 })),
            ("/effects", json!({ "closing": 3, "wind": {} })),
        ] {
            let mut bad = scene();
            bad["capture"] = json!({ "hold_s": 0.9 });
            bad["output"] = json!({ "sample_s": 0.9 });
            bad["expect"] = json!({ "captured": true });
            let (above, key) = pointer.rsplit_once('/').unwrap();
            bad.pointer_mut(above).unwrap()[key] = value;
            let found = places(bad);
            let own = pointer[1..].replace('/', ".");
            assert!(
                !found.is_empty() && found.iter().all(|place| place.starts_with(&own)),
                "{pointer}: {found:?}"
            );
        }
    }
}
