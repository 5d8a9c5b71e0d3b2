//! What is uncertain in a scene: drawn for each member, shown, checked, and nothing where it is not asked for.

use std::path::Path;

use crate::common::program::{folder_with, printed, tiny_capture, tumblenet, write_json};
use crate::common::{below, case_of, small_scene, source_of, within};
use nalgebra::Vector3;
use serde_json::{Value, json};
use tumblenet::case::Case;
use tumblenet::study::ensemble::{self, EnsembleRequest};

/// A tiny net that meets a box within a few steps.
fn scene(uncertain: Value) -> Value {
    let mut scene = tiny_capture();
    scene["solver"] = json!({ "cables": "explicit", "contact": "impulse" });
    scene["uncertain"] = uncertain;
    scene
}

fn many() -> Value {
    json!([
        { "path": "launch.speed_m_s", "normal": { "relative": 0.05 } },
        { "path": "launch.bullets.speed_m_s", "normal": { "sigma": 0.03 } },
        { "path": "launch.bullets.aside_deg", "normal": { "sigma": 1 } },
        { "path": "launch.bullets.delay_s", "uniform": [0, 1e-3] },
        { "path": "target.offset_m.0", "uniform": [-0.01, 0.01] },
        { "path": "target.attitude_deg", "attitude": { "within_deg": 5 } },
        { "path": "target.spin_rad_s", "direction": { "within_deg": 20 } },
        { "path": "target.mass_kg", "log_uniform": [0.5, 2] },
        { "path": "effects.friction", "values": [null, { "coefficient": 0.3 }], "labels": ["none", "0.3"] },
        { "path": "net.cable.damping_ratio", "normal": { "mean": 0.1, "sigma": 0.01 } }
    ])
}

fn request(members: usize) -> EnsembleRequest {
    EnsembleRequest { members, perturb_m: 1e-6, seed: 3, at_most_s: None }
}

/// What is drawn at `path` for so many members.
fn drawn(case: &Case, members: u64, path: &str) -> Vec<Value> {
    let uncertain = case.uncertain().unwrap();
    let number = uncertain.parameters().iter().position(|parameter| parameter.path == path).unwrap();
    (0..members).map(|member| uncertain.draw(3, member)[number].value.clone()).collect()
}

fn numbers(case: &Case, members: u64, path: &str) -> Vec<f64> {
    drawn(case, members, path).iter().map(|value| value.as_f64().unwrap()).collect()
}

fn mean_and_deviation(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    [mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n).sqrt()]
}

#[test]
fn each_member_has_what_was_drawn_for_it() {
    let case = case_of(scene(many()));
    let [first, again] = [0, 1].map(|_| ensemble::member(&case, &request(0), 7).unwrap());
    assert_eq!(first.hash(), again.hash());
    assert_eq!(first.net().launch_velocity, again.net().launch_velocity);
    let other = ensemble::member(&case, &request(0), 8).unwrap();
    for (one, other) in [
        (first.scene().launch.speed_m_s, other.scene().launch.speed_m_s),
        (first.scene().net.cable.damping_ratio, other.scene().net.cable.damping_ratio),
        (first.target().unwrap().mass, other.target().unwrap().mass),
        (first.target().unwrap().position.y, other.target().unwrap().position.y),
        (first.target().unwrap().attitude.angle(), other.target().unwrap().attitude.angle()),
    ] {
        assert_ne!(one, other);
    }
    let speeds = first.net().bullets.map(|bullet| first.net().launch_velocity[bullet].norm());
    assert!((0..4).all(|i| (0..i).all(|j| speeds[i] != speeds[j])), "each bullet by itself: {speeds:?}");
    // A scene as it stands is that of a single run.
    assert_eq!(case.scene().launch.speed_m_s, 2.0);
    assert!(case.scene().launch.bullets.is_zero());
    // It has what the table says it has.
    let picks = case.uncertain().unwrap().draw(3, 7);
    assert_eq!(picks[0].value, json!(first.scene().launch.speed_m_s));
    assert_eq!(picks[1].value, json!(first.scene().launch.bullets.speed_m_s));
    let n_shown: usize = picks.iter().map(|pick| pick.shown.len()).sum();
    assert_eq!(case.uncertain().unwrap().columns().len(), n_shown);
}

#[test]
fn members_follow_their_distributions() {
    let case = case_of(scene(many()));
    let n = 2000;
    let [mean, deviation] = mean_and_deviation(&numbers(&case, n, "launch.speed_m_s"));
    // A normal distribution cut at three standard deviations has 0.987 of them; 2000 tell 1.6 % (one standard deviation).
    within("mean speed", mean, [1.99, 2.01]);
    within("standard deviation of the speed", deviation, [0.093, 0.104]);
    let masses: Vec<f64> = numbers(&case, n, "target.mass_kg").into_iter().map(f64::ln).collect();
    let [mean, deviation] = mean_and_deviation(&masses);
    within("mean logarithm of the mass", mean, [-0.03, 0.03]);
    within("its standard deviation", deviation, [0.385, 0.415]); // ln 4 / √12 = 0.400
    let own: Vector3<f64> = Vector3::new(0.5, 0.2, 0.0);
    let angle = |value: Value| {
        let spin: Vector3<f64> = serde_json::from_value::<[f64; 3]>(value).unwrap().into();
        assert!((spin.norm() - own.norm()).abs() < 1e-9, "length of the spin");
        spin.angle(&own).to_degrees()
    };
    let angles: Vec<f64> = drawn(&case, n, "target.spin_rad_s").into_iter().map(angle).collect();
    within("largest angle of the spin [deg]", angles.iter().copied().fold(0.0, f64::max), [19.5, 20.0]);
    let frictions = drawn(&case, n, "effects.friction");
    let with = frictions.iter().filter(|value| !value.is_null()).count();
    within("share with friction", with as f64 / n as f64, [0.46, 0.54]);
}

/// The same bits whatever the number of threads, of members, or the order.
#[test]
fn a_member_is_the_same_in_any_ensemble() {
    let case = case_of(scene(many()));
    let run = |threads: usize, members: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let all = pool.install(|| ensemble::run(&case, &request(members), Vec::new(), |_| {}));
        all.into_iter().map(|member| {
            let capture = member.outcome.unwrap_or_else(|why| panic!("{why}")).capture.unwrap();
            [capture.separation, capture.cqi, capture.mouth]
        })
    };
    let one: Vec<_> = run(1, 6).collect();
    assert_eq!(one, run(2, 6).collect::<Vec<_>>());
    assert_eq!(one[..3], run(2, 3).collect::<Vec<_>>());
    let differ = |member: usize| (0..3).any(|number| (one[member][number] - one[0][number]).abs() > 1e-3);
    assert!((1..6).all(differ), "more than chance: {one:?}");
}

#[test]
fn every_fault_of_what_is_uncertain_is_told_with_those_of_the_scene() {
    let bad = json!([
        { "path": "launch.speed_m_s", "normal": { "relative": 0.5 } },
        { "path": "launch.sped_m_s", "uniform": [1, 2] },
        { "path": "target.mass_kg", "uniform": [3, 1] },
        { "path": "target.mass_kg", "values": [1] },
        { "path": "target.spin_rad_s.2", "normal": { "relative": 0.1 } },
        { "path": "target.distance_m", "normal": { "sigma": 1, "relative": 1 } },
        { "path": "target.offset_m", "direction": { "within_deg": 5 } },
        { "path": "net.fold.ratio", "uniform": [0.1, 0.2], "normal": { "sigma": 0.1 } },
        { "path": "title", "normal": { "sigma": 1 } }
    ]);
    let told = Case::build(&source_of(scene(bad.clone()))).err().expect("refused").to_string();
    for fault in [
        "uncertain[2].uniform: found [3, 1]; allowed: the least first",
        "uncertain[3].path: found \"target.mass_kg\" beside \"target.mass_kg\"",
        "uncertain[4].normal.relative: found a share of a mean of 0",
        "uncertain[5].normal: found sigma and relative; allowed: one of them",
        "uncertain[6].direction: found no direction there",
        "uncertain[7]: found 2 of them; allowed: exactly one of values",
        "uncertain[8].normal.mean: found nothing, and no number in the scene",
    ] {
        assert!(told.contains(fault), "{fault} not in {told}");
    }
    let far = json!([{ "path": "target.attitude_deg", "attitude": { "within_deg": 181 } }]);
    let told = Case::build(&source_of(scene(far))).err().expect("refused").to_string();
    assert!(told.contains("uncertain[0].attitude.within_deg: found 181"), "{told}");
    let mut also = scene(json!([{ "path": "target.mass_kg", "uniform": [3, 1] }]));
    also["net"]["bullet_mass_kg"] = json!(-1);
    also["launch"]["bullets"] = json!({ "speed_m_s": [0, 0, -3, 0] });
    let told = Case::build(&source_of(also)).err().expect("refused").to_string();
    for place in ["uncertain[0].uniform", "net.bullet_mass_kg", "launch.bullets.speed_m_s[2]"] {
        assert!(told.contains(place), "{place} not in {told}");
    }
    // What the scene does not allow at the ends.
    let told = Case::build(&source_of(scene(json!([bad[0], bad[1]])))).err().expect("refused").to_string();
    for fault in [
        "uncertain[0].normal: found -1.0, with which launch.speed_m_s is -1",
        "uncertain[1].uniform[0]: found 1.0, with which launch.sped_m_s is an unknown key; allowed: did you mean speed_m_s?",
    ] {
        assert!(told.contains(fault), "{fault} not in {told}");
    }
}

/// (v + δv) [cos ψ (cos(θ + δθ) X + sin(θ + δθ) n) + sin ψ X × n], worked out by hand for one bullet.
#[test]
fn a_bullet_flies_as_it_deviates() {
    let mut deviating = small_scene();
    deviating["launch"]["bullets"] =
        json!({ "speed_m_s": [0, 0.5, 0, 0], "angle_deg": [0, 0, 5, 0], "aside_deg": [0, 0, 0, 90e-1] });
    let case = case_of(deviating);
    let shots = case.net().bullets.map(|bullet| case.net().launch_velocity[bullet]);
    let plain = case_of(small_scene());
    let plain = plain.net().bullets.map(|bullet| plain.net().launch_velocity[bullet]);
    below("the first as ever", (shots[0] - plain[0]).norm(), 1e-15);
    below("the second faster", (shots[1] - 1.25 * plain[1]).norm(), 1e-15);
    let at = |degrees: f64| 2.0 * degrees.to_radians().cos();
    below("the third wider", (shots[2].x - at(30.0)).abs(), 1e-15);
    below("the third in its plane", (shots[2].y - shots[2].z).abs(), 1e-15);
    // n = (0, −1, 1)/√2, X × n = (0, −1, −1)/√2.
    let aside = 2.0 * 9_f64.to_radians().sin();
    let along = 9_f64.to_radians().cos() * plain[3];
    let expected = along + aside * Vector3::new(0.0, -1.0, -1.0) / 2_f64.sqrt();
    below("the fourth aside", (shots[3] - expected).norm(), 1e-15);
}

/// All of them as late: the same deployment later, to rounding. One late: it is in its place, with its speed, at that time.
#[test]
fn a_bullet_that_is_shot_late_is_on_its_way_until_then() {
    let late = |delay: [f64; 4], duration: f64| {
        let mut scene = small_scene();
        scene["solver"] = json!({ "cables": "explicit", "contact": "impulse", "step_s": 1e-5 });
        scene["output"] = json!({ "sample_s": 0.01 });
        scene["duration_s"] = json!(duration);
        scene["launch"]["bullets"] = json!({ "delay_s": delay });
        case_of(scene)
    };
    let [plain, all] = [([0.0; 4], 0.2), ([0.01; 4], 0.21)].map(|(delay, duration)| {
        let run = crate::common::run(&late(delay, duration));
        run.frames.knots.last().unwrap().clone()
    });
    let apart = plain.iter().zip(&all).map(|(one, other)| (one - other).norm()).fold(0.0, f64::max);
    below("all late", apart, 1e-9);

    let one = late([0.0, 0.01, 0.0, 0.0], 0.01);
    let folded = one.net().folded[one.net().bullets[0]];
    let run = crate::common::run(&one);
    let bullet = run.frames.knots.last().unwrap()[one.net().bullets[1]];
    let place = Vector3::new(folded.x, -folded.y, folded.z);
    below("one late", (bullet - place).norm(), 1e-12);

    let mut scene = small_scene();
    scene["launch"]["bullets"] = json!({ "delay_s": [0, 0, 9, 0] });
    let told = Case::build(&source_of(scene)).err().unwrap().to_string();
    assert!(
        told.contains("launch.bullets.delay_s[2]: found 9: the bullet would be 1.800e1 m behind"),
        "{told}"
    );
    assert!(told.contains("stay slack"), "{told}");
}

/// Written into a folder of its own.
fn folder(scene: &Value) -> tempfile::TempDir {
    folder_with(&[("scene.json", scene)])
}

fn json_of(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn an_ensemble_shows_what_it_drew_and_any_member_is_run_again() {
    let folder = folder(&scene(many()));
    let folder = folder.path();
    let told = printed(folder, &["run", "scene.json", "--ensemble", "4", "--seed", "3", "--out", "o"]);
    assert!(told.contains("Drawn for each member: launch.speed_m_s, launch.bullets.speed_m_s.0"), "{told}");
    let ensemble = json_of(&folder.join("o/ensemble.json"));
    let drawn = &ensemble["drawn"];
    assert_eq!(drawn["members"].as_array().unwrap().len(), 4);
    let page = std::fs::read_to_string(folder.join("o/ensemble.html")).unwrap();
    assert!(page.contains("<th>target.spin_rad_s.tilt_deg</th>"));
    printed(folder, &["run", "scene.json", "--member", "2", "--seed", "3", "--out", "m"]);
    let summary = json_of(&folder.join("m/summary.json"));
    let quartiles = &ensemble["scalars"]["capture.separation"];
    let separation = summary["capture"]["separation"].as_f64().unwrap();
    let [least, largest] = ["min", "max"].map(|key| quartiles[key].as_f64().unwrap());
    assert!((least..=largest).contains(&separation) && least < largest);
    let case = Case::load(folder.join("scene.json").to_str().unwrap(), &[]).unwrap();
    let same = ensemble::run(&case, &request(4), Vec::new(), |_| {}).remove(2).outcome.unwrap();
    assert_eq!(same.capture.unwrap().separation, separation, "the same bits");
}

/// What is uncertain about the scene's own value moves with the point of a study.
#[test]
fn a_sweep_draws_what_is_uncertain_about_each_of_its_points() {
    let folder = folder(&scene(json!([
        { "path": "launch.speed_m_s", "normal": { "relative": 0.01 } },
        { "path": "target.mass_kg", "uniform": [0.5, 2] }
    ])));
    let folder = folder.path();
    let mut study = json!({ "title": "t", "scene": "scene.json", "members": 3, "seed": 5,
        "parameters": [{ "path": "launch.speed_m_s", "values": [1, 3] }],
        "design": { "kind": "grid" } });
    write_json(folder, "study.json", &study);
    printed(folder, &["sweep", "study.json", "--out", "one", "--jobs", "1"]);
    let table = std::fs::read_to_string(folder.join("one/table.csv")).unwrap();
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let header = reader.headers().unwrap().clone();
    let column =
        |name: &str| header.iter().position(|known| known == name).unwrap_or_else(|| panic!("{name}"));
    let [input, speed, mass] =
        ["input.launch.speed_m_s", "drawn.launch.speed_m_s", "drawn.target.mass_kg"].map(column);
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let number = |row: &csv::StringRecord, column: usize| row[column].parse::<f64>().unwrap();
    assert_eq!(rows.len(), 6);
    for row in &rows {
        within("speed over that of the point", number(row, speed) / number(row, input), [0.97, 1.03]);
        assert!(number(row, speed) != number(row, input));
        within("mass", number(row, mass), [0.5, 2.0]);
    }
    assert!(rows.windows(2).all(|pair| number(&pair[0], mass) != number(&pair[1], mass)));
    for shard in ["2/2", "1/2"] {
        printed(folder, &["sweep", "study.json", "--out", "two", "--shard", shard, "--jobs", "2"]);
    }
    printed(folder, &["sweep", "merge", "two"]);
    assert!(std::fs::read_to_string(folder.join("two/table.csv")).unwrap() == table, "threads and shards");
    printed(folder, &["sweep", "study.json", "--out", "one", "--member", "4"]);
    let summary = json_of(&folder.join("one/member-4/summary.json"));
    let separation = summary["capture"]["separation"].as_f64().unwrap();
    assert_eq!(number(&rows[4], column("capture.separation")), separation, "the same bits");

    // A parameter that would be drawn over, and nothing that varies.
    study["parameters"] = json!([{ "path": "target.mass_kg", "values": [1] }]);
    write_json(folder, "study.json", &study);
    let refused = tumblenet(folder, &["sweep", "study.json"]);
    let told = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{told}");
    assert!(
        told.contains("parameters[0].path: found \"target.mass_kg\", which the scene draws anew"),
        "{told}"
    );
    study["parameters"] = json!([]);
    study["design"] = json!({ "kind": "random", "points": 2 });
    write_json(folder, "study.json", &study);
    printed(folder, &["sweep", "study.json", "--out", "three"]);
    study["set"] = json!({ "uncertain": null });
    write_json(folder, "study.json", &study);
    let refused = tumblenet(folder, &["sweep", "study.json"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("parameters: found none"));
}

/// A scene in which nothing is uncertain says nothing of it, and reads as the same.
#[test]
fn a_scene_without_it_is_as_ever() {
    let plain = case_of(small_scene());
    let json = serde_json::to_value(plain.scene()).unwrap();
    assert!(json.get("uncertain").is_none() && json["launch"].get("bullets").is_none(), "{json}");
    let mut written_out = small_scene();
    written_out["uncertain"] = json!([]);
    written_out["launch"]["bullets"] = json!({ "speed_m_s": [0, 0, 0, 0] });
    assert_eq!(case_of(written_out).hash(), plain.hash());
    assert!(plain.uncertain().is_none());
}
