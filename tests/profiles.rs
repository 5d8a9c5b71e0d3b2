//! Files of a cabin, and scenes whose effects do not go together: what is read, and what is refused.

use std::path::Path;

use crate::common::{run, small_scene, source_of};
use serde_json::{Value, json};
use tumblenet::case::Case;
use tumblenet::problems::Problems;

const HEADING: &str =
    "t_s,gravity_x_m_s2,gravity_y_m_s2,gravity_z_m_s2,rate_x_rad_s,rate_y_rad_s,rate_z_rad_s";

fn with(effects: Value, folder: Option<&Path>) -> Result<Case, Problems> {
    let mut scene = small_scene();
    scene["effects"] = effects;
    Case::build(&tumblenet::scene::Source { folder: folder.map(Path::to_path_buf), ..source_of(scene) })
}

/// Words of the faults of the effects.
fn refused(effects: Value, folder: Option<&Path>) -> String {
    with(effects, folder).err().expect("refused").to_string()
}

fn profile(rows: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("flight.csv"), rows).unwrap();
    folder
}

#[test]
fn a_profile_beside_the_scene_is_read_and_acts() {
    let rows = format!("# my flight\n{HEADING}\n0,0,0,0.1,0,0,0\n0.5, 0, 0, 0.1, 0, 0, 0\n");
    let folder = profile(&rows);
    let effects = json!({ "cabin": { "profile": "flight.csv" } });
    let case = with(effects.clone(), Some(folder.path())).unwrap();
    assert_eq!(case.scene().effects.cabin.as_ref().unwrap().rows.len(), 2);
    // A slack knot in the middle of the net falls: the profile's 0.1 m/s² for 0.5 s.
    let constant = with(json!({ "cabin": { "gravity_m_s2": [0.0, 0.0, 0.1] } }), None).unwrap();
    let (by_file, by_hand) = (run(&case), run(&constant));
    assert!(by_file.frames.knots == by_hand.frames.knots, "a profile of equal rows is a constant");
    let mass = case.net().total_mass();
    let gained = by_file.frames.momentum.last().unwrap().z / mass;
    assert!((gained - 0.1 * 0.5).abs() < 1e-12, "{gained}");
    // The scene's hash knows the file's numbers.
    let other = profile(&rows.replace("0.1", "0.2"));
    assert_ne!(with(effects, Some(other.path())).unwrap().hash(), case.hash());
}

#[test]
fn a_bad_profile_is_refused_with_its_line() {
    let effects = || json!({ "cabin": { "profile": "flight.csv" } });
    let told = |rows: &str| {
        let folder = profile(rows);
        let told = refused(effects(), Some(folder.path()));
        assert!(told.contains("effects.cabin.profile"), "{told}");
        told
    };
    let rows = format!(
        "# a comment\n{HEADING}\n0,0,0,0.1,0,0,0\n1,0,0,down,0,0,0\n0.5,0,0,0.1,0,0,0\n-1,0,0,NaN,0,0,0\n"
    );
    let several = told(&rows);
    for words in ["line 4", "line 6", "not finite", "seven finite numbers"] {
        assert!(several.contains(words), "{words:?} not in {several}");
    }
    assert!(
        told(&format!("{HEADING}\n1,0,0,0,0,0,0\n0,0,0,0,0,0,0\n"))
            .contains("line 3: time 0 after a later one")
    );
    assert!(told(&format!("{HEADING}\n1,0,0\n")).contains("line 2"));
    assert!(told("t_s,g\n0,1\n").contains("gravity_x_m_s2"));
    assert!(told(HEADING).contains("no row"));
    assert!(told("").contains("no row"));
}

#[test]
fn a_profile_that_is_nowhere_is_refused() {
    let cabin = |name: &str| json!({ "cabin": { "profile": name } });
    assert!(refused(cabin("parabel"), None).contains("\"parabola\""));
    assert!(refused(cabin("mine.csv"), None).contains("no folder"));
    let folder = tempfile::tempdir().unwrap();
    assert!(refused(cabin("mine.csv"), Some(folder.path())).contains("readable file"));
}

#[test]
fn what_does_not_go_together_is_refused_in_words() {
    let orbit = json!({ "altitude_m": 7e5 });
    let elements = json!({ "semi_major_axis_m": 7e6 });
    let chaser = json!({ "mass_kg": 10.0, "inertia_kg_m2": [1.0, 1.0, 1.0], "speed_sigma_m_s": 1.0 });
    for (effects, words) in [
        (json!({ "orbit": orbit, "cabin": {} }), "effects.cabin"),
        (json!({ "orbit": {} }), "altitude_m or elements"),
        (json!({ "orbit": { "altitude_m": 7e5, "elements": elements } }), "contradict"),
        (json!({ "orbit": { "elements": { "semi_major_axis_m": 7e6, "eccentricity": 0.2 } } }), "perigee"),
        (json!({ "orbit": { "altitude_m": 7e5, "approach": [0, 0, 0] } }), "effects.orbit.approach"),
        (json!({ "orbit": { "altitude_m": 7e5, "approach": "sideways" } }), "effects.orbit.approach"),
        (json!({ "orbit": { "altitude_m": -1 } }), "effects.orbit.altitude_m"),
        (json!({ "chaser": chaser }), "effects.chaser.speed_sigma_m_s"),
        (json!({ "chaser": { "mass_kg": 0, "inertia_kg_m2": [1, 1] } }), "effects.chaser.mass_kg"),
    ] {
        let told = refused(effects, None);
        assert!(told.contains(words), "{words:?} not in {told}");
    }
}
