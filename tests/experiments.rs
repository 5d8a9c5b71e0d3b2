//! A run beside an experiment, and a scene fitted to one: made tracks whose truth is known.

use crate::common;

use std::fmt::Write as _;
use std::path::Path;

use crate::common::program::{err, printed, tumblenet};
use crate::common::{below, within};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use statrs::distribution::{ContinuousCDF, Normal};
use tumblenet::limits::Limits;
use tumblenet::scene::Source;
use tumblenet::study::experiment::checked::FitStudy;
use tumblenet::study::experiment::found::Fit;
use tumblenet::study::experiment::paths::KnotPaths;

/// What the made experiments were made with: damping ratio and launch speed [m/s].
const TRUTH: [f64; 2] = [0.1, 2.1];

/// Noise of a coordinate [m].
const NOISE: f64 = 0.003;

/// A small net of a soft cord, until it has opened, with `damping` and `speed`: long steps do, 0.05 mm from short ones. Later
/// its light knots, which snap, are chaotic, and no parameters meet them.
fn scene([damping, speed]: [f64; 2]) -> Value {
    let mut scene = common::small_scene();
    scene["duration_s"] = json!(0.25);
    scene["net"]["cable"] = json!({ "diameter_m": 0.001, "damping_ratio": damping, "material": {
        "young_modulus_pa": 2e7, "density_kg_m3": 1150, "tensile_strength_pa": 1e8, "elongation_at_break": 5 } });
    scene["launch"]["speed_m_s"] = json!(speed);
    scene["solver"] =
        json!({ "cables": "explicit", "contact": "impulse", "integrator": "secant", "step_s": 1e-4 });
    scene["output"] = json!({ "sample_s": 0.005 });
    scene
}

/// Where the knots were after a flight of `scene` by steps ten times finer than its own.
fn finer(mut scene: Value) -> KnotPaths {
    let own = common::case_of(scene.clone()).time_step();
    scene["solver"]["integrator"] = json!("secant");
    scene["solver"]["step_s"] = json!(own.step / f64::from(own.substeps) / 10.0);
    let case = common::case_of(scene);
    let run = common::run(&case);
    KnotPaths::of(&case, run)
}

/// How a made camera sees.
struct Camera {
    /// Pictures a second [Hz].
    rate: f64,
    pictures: u32,
    /// The knots that have markers.
    knots: Vec<usize>,
    seed: u64,
}

impl Camera {
    /// What it sees of `truth` from a place of its own, with a clock that began 40 ms late: a third of all is missing, the rest
    /// has noise of [`NOISE`].
    fn track(&self, truth: &KnotPaths) -> String {
        let turn = UnitQuaternion::from_euler_angles(0.4, -0.2, 1.0);
        let offset = Vector3::new(0.5, -1.0, 0.2);
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let mut unit = move || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let mut text = "time_ms,marker,x_mm,y_mm,z_mm\n".to_owned();
        for picture in 0..self.pictures {
            let time = f64::from(picture) / self.rate;
            for &knot in &self.knots {
                let place = turn.inverse() * (truth.at(knot, time + 0.04).position - offset);
                let noise = [(); 3].map(|()| NOISE * Normal::standard().inverse_cdf(unit()));
                let missing = unit() < 1.0 / 3.0;
                let [x, y, z] = [0, 1, 2].map(|axis| 1e3 * (place[axis] + noise[axis]));
                let (time, name) = (1e3 * time, truth.names.name(knot));
                match missing {
                    true => writeln!(text, "{time:.3},{name},,,").unwrap(),
                    false => writeln!(text, "{time:.3},{name},{x:.2},{y:.2},{z:.2}").unwrap(),
                }
            }
        }
        text
    }
}

/// What a camera sees of the small net: all knots, from 0.04 to 0.24 s.
fn track(truth: &KnotPaths, seed: u64) -> String {
    Camera { rate: 80.0, pictures: 17, knots: (0..16).collect(), seed }.track(truth)
}

/// The fit of damping ratio and launch speed to `track.csv`.
fn study() -> Value {
    json!({
        "title": "a small fit", "scene": "scene.json", "track": "track.csv", "align": "both",
        "parameters": [
            { "path": "net.cable.damping_ratio", "log_uniform": [0.01, 0.5] },
            { "path": "launch.speed_m_s", "uniform": [1.5, 3] }
        ],
        "scan": 7
    })
}

/// The scene that fits begin with.
fn known_nothing() -> Value {
    scene([0.2, 2.0])
}

/// A folder with a scene that knows nothing of a truth, a track, and the fit.
fn folder(scene: &Value, track: &str, study: &Value) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("scene.json", &scene.to_string());
    write("track.csv", track);
    write("fit.json", &study.to_string());
    folder
}

fn fit(folder: &Path) -> Fit {
    fit_of(&folder.join("fit.json"))
}

fn fit_of(path: &Path) -> Fit {
    let study = FitStudy::load(path.to_str().unwrap(), Limits::default());
    study.unwrap_or_else(|faults| panic!("{faults}")).find(&|| ()).unwrap_or_else(|why| panic!("{why}"))
}

/// Twenty experiments of one truth, made by a finer model, with noise and missing markers, clock and frame unknown: how often
/// each of `sought` is within its own interval of 95 %, of `scene` and the fit `study`.
fn inside_of_twenty(scene: &Value, truth: &Value, study: &Value, sought: [f64; 2]) -> [usize; 2] {
    let truth = finer(truth.clone());
    let mut inside = [0, 0];
    for seed in 1..=20 {
        let folder = folder(scene, &track(&truth, seed), study);
        let fit = fit(folder.path());
        for (number, parameter) in fit.parameters.iter().enumerate() {
            let [low, high] = parameter.interval_95.unwrap();
            inside[number] += usize::from((low..=high).contains(&sought[number]));
            println!(
                "{seed}, {}: {:.5} in {low:.5} to {high:.5}; noise {:.5} m, correlation {:.3}, {} flights",
                parameter.path, parameter.found, fit.noise_left_m, fit.correlation, fit.flights
            );
        }
    }
    println!("{inside:?} of 20");
    inside
}

/// Of such intervals 19 of 20 are to be expected, and 18 or fewer in one round of four; measured: 19 and 18. The two that the
/// speed misses are 2.8 and 3.0 standard errors off.
#[test]
fn what_a_track_was_made_with_is_within_its_own_interval() {
    let inside = inside_of_twenty(&known_nothing(), &scene(TRUTH), &study(), TRUTH);
    assert!(inside[0] >= 19 && inside[1] >= 18, "{inside:?} of 20");
}

/// The same of the drag of the air.
#[test]
fn the_drag_that_a_track_was_made_with_is_within_its_own_interval() {
    let in_air = |damping: f64, coefficient: f64| {
        let mut scene = scene([damping, TRUTH[1]]);
        scene["effects"] = json!({ "drag": { "density_kg_m3": 1.2, "cable_coefficient": coefficient } });
        scene
    };
    let mut study = study();
    study["parameters"][1] = json!({ "path": "effects.drag.cable_coefficient", "uniform": [0, 4] });
    let inside = inside_of_twenty(&in_air(0.2, 2.0), &in_air(TRUTH[0], 1.3), &study, [TRUTH[0], 1.3]);
    assert!(inside[0] >= 19 && inside[1] >= 19, "{inside:?} of 20");
}

/// Threads change no bit, and the program says what the library finds.
#[test]
fn a_fit_is_the_same_with_any_number_of_threads() {
    let folder = folder(&known_nothing(), &track(&finer(scene(TRUTH)), 1), &study());
    let of = |jobs: &str| {
        let told =
            printed(folder.path(), &["fit", "fit.json", "--out", "o", "--format", "json", "--jobs", jobs]);
        let mut fit: Value = serde_json::from_str(&told).unwrap();
        fit["residual"]["provenance"] = Value::Null;
        fit
    };
    let one = of("1");
    assert_eq!(one, of("3"));
    let library = fit(folder.path());
    assert_eq!(json!(library.parameters), one["parameters"]);
    assert_eq!(json!(library.flights), one["flights"]);
    assert_eq!(library.warnings, [""; 0]);
    for name in ["fit.html", "fit.csv", "fit.json", "residual.svg"] {
        assert!(folder.path().join("o").join(name).exists(), "{name}");
    }
    // The command that it names flies what it found.
    let again: Vec<String> =
        library.again.split(" --set ").skip(1).map(|set| set.replace('\'', "")).collect();
    let mut flown = Source::find(folder.path().join("scene.json").to_str().unwrap()).unwrap();
    flown.set(&again).unwrap();
    for (pointer, parameter) in
        ["/net/cable/damping_ratio", "/launch/speed_m_s"].into_iter().zip(&library.parameters)
    {
        let found = flown.json.pointer(pointer).unwrap().as_f64().unwrap();
        below("what is flown again", (found / parameter.found - 1.0).abs(), 1e-10);
    }
    let text = printed(folder.path(), &["fit", "fit.json", "--out", "o"]);
    for words in ["launch.speed_m_s", "interval of 95 %", "flights", "aligned in time and pose"] {
        assert!(text.contains(words), "{words:?} not in {text}");
    }
}

/// With what it was made with out of reach, a parameter stays at the end of its range and says so; what is left is no noise.
#[test]
fn a_fit_that_cannot_meet_its_track_says_so() {
    let mut study = study();
    study["parameters"] = json!([{ "path": "launch.speed_m_s", "uniform": [2.6, 3] }]);
    study["noise_m"] = json!(NOISE);
    let folder = folder(&known_nothing(), &track(&finer(scene(TRUTH)), 1), &study);
    let fit = fit(folder.path());
    assert!(fit.parameters[0].at_end && (fit.parameters[0].found - 2.6).abs() < 1e-6, "{:?}", fit.parameters);
    for words in ["at an end of its range", "times the noise is left", "it is no noise"] {
        assert!(fit.warnings.iter().any(|warning| warning.contains(words)), "{words:?}: {:?}", fit.warnings);
    }
    study["most_flights"] = json!(9);
    std::fs::write(folder.path().join("fit.json"), study.to_string()).unwrap();
    let output = tumblenet(folder.path(), &["fit", "fit.json"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(err(&output).contains("no least after 9 flights"), "{}", err(&output));
}

#[test]
fn all_faults_of_a_fit_are_told_at_once() {
    let mut study = study();
    study["parameters"] = json!([
        { "path": "launch.speed_m_s", "uniform": [3, 1] },
        { "path": "launch.speed_m_s", "normal": { "sigma": 0.1 } },
        { "path": "net.cable.damping_ratio", "uniform": [-1, 0.1] },
    ]);
    let bad =
        "time_s,marker,x_m,y_m,z_m\n0,bullet-1,0,0,0\n0,bullet-1,1,0,0\n1,knot-9-9,,,\n1,bullet-2,a,0,0\n";
    let folder = folder(&known_nothing(), bad, &study);
    let output = tumblenet(folder.path(), &["fit", "fit.json"]);
    let told = err(&output);
    assert_eq!(output.status.code(), Some(2), "{told}");
    for fault in [
        "parameters[0].uniform: found [3, 1]",
        "parameters[1].path",
        "parameters[1]: found no range of one number",
        "parameters[2].uniform[0]",
        "track.line 3: found \"bullet-1\" at 0 s, as in line 2",
        "track.line 5: found \"a\"",
    ] {
        assert!(told.contains(fault), "{fault:?} not in {told}");
    }
    assert!(!folder.path().join("results").exists());
}

/// A run beside itself leaves nothing, read from its folder or run anew; beside a track, the noise that was put in.
#[test]
fn residuals_are_what_was_put_in() {
    let paths = finer(scene(TRUTH));
    let folder = folder(&known_nothing(), &track(&paths, 3), &study());
    let folder = folder.path();
    printed(folder, &["run", "scene.json", "--out", "a"]);
    let residual = |arguments: &[&str]| -> Value {
        let all = [&["residual"], arguments, &["--out", "o", "--format", "json"]].concat();
        serde_json::from_str(&printed(folder, &all)).unwrap()
    };
    for run in ["a", "scene.json"] {
        let none = residual(&[run, "a"]);
        assert_eq!((&none["rms_m"], none["markers"].as_array().unwrap().len()), (&json!(0.0), 16));
        assert_eq!(none["align"], "none");
    }
    for name in ["residual.html", "residual.csv", "residual.svg", "residual.json"] {
        assert!(folder.join("o").join(name).exists(), "{name}");
    }

    std::fs::write(folder.join("true.json"), scene(TRUTH).to_string()).unwrap();
    let noise = residual(&["true.json", "track.csv"]);
    let [rms, shift] = [&noise["rms_m"], &noise["alignment"]["shift_s"]].map(|n| n.as_f64().unwrap());
    within("what is left over the noise of three coordinates", rms / (NOISE * 3_f64.sqrt()), [0.9, 1.1]);
    below("clock", (shift - 0.04).abs(), 3e-3);
    let groups = noise["groups"].as_array().unwrap();
    assert_eq!(groups.len(), 4, "bullets, edge, inner, all");
    for group in groups {
        for axis in group["relative_percent"].as_array().unwrap() {
            // A mean of |noise| over ways of 10 cm to 1 m.
            assert!((0.05..20.0).contains(&axis.as_f64().unwrap()), "{group}");
        }
    }

    // Nets of other meshes have their bullets in common.
    let mut finer_mesh = scene(TRUTH);
    finer_mesh["net"]["meshes"] = json!([6, 6]);
    finer_mesh["net"]["mesh_length_m"] = json!(0.05);
    std::fs::write(folder.join("mesh.json"), finer_mesh.to_string()).unwrap();
    let bullets = residual(&["mesh.json", "a"]);
    assert_eq!(bullets["markers"].as_array().unwrap().len(), 4);

    for (arguments, fault) in [
        (&["a", "nowhere.csv"][..], "nowhere.csv"),
        (&["nowhere", "track.csv"], "nowhere"),
        (&["a", "track.csv", "--set", "duration_s=1"], "a run that is over"),
        (&["a", "o"], "trajectory.npz"),
        (&["mesh.json", "scene.json"], "no column of time"),
    ] {
        let output = tumblenet(folder, &[&["residual"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", err(&output));
        assert!(err(&output).contains(fault), "{fault:?} not in {}", err(&output));
    }
}

/// The example's tracks are of seed 1, and its net is that of these tests; `RENEW=1` makes them anew.
#[test]
fn the_example_is_made_as_the_book_says() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/fits");
    let made = track(&finer(scene(TRUTH)), 1);
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(folder.join("cord.csv"), &made).unwrap();
    }
    let published = std::fs::read_to_string(folder.join("cord.csv")).unwrap();
    assert!(published == made, "RENEW=1 cargo test --test suite experiments");
    let mut net = Source::find(folder.join("cord-net.json").to_str().unwrap()).unwrap();
    let truth = ["net.cable.damping_ratio=0.1", "launch.speed_m_s=2.1", "launch.angle_deg=25"];
    net.set(&truth.map(str::to_owned)).unwrap();
    let hash = |json: Value| common::case_of(json).hash().to_owned();
    let title = net.json["title"].clone();
    let same = |mut json: Value| {
        json["title"] = title.clone();
        json.as_object_mut().unwrap().shift_remove("$schema");
        hash(json)
    };
    assert_eq!(same(net.json.clone()), same(scene(TRUTH)));
    let fit = fit_of(&folder.join("cord.json"));
    for (parameter, truth) in fit.parameters.iter().zip([0.1, 2.1, 25.0]) {
        let [low, high] = parameter.interval_95.unwrap();
        assert!((low..=high).contains(&truth), "{parameter:?}");
    }
}
