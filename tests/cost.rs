//! What accuracy costs: the study as a library and as a user runs it.

use crate::common;

use std::path::Path;
use std::process::{Command, Output};

use crate::common::below;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use tumblenet::case::Case;
use tumblenet::metrics::verdict::Capture;
use tumblenet::scene::Source;
use tumblenet::step::mass_spring::dopri5;
use tumblenet::study::cost::accuracy::Accuracy;
use tumblenet::study::cost::calibration::calibrate;
use tumblenet::study::cost::dials::DialKind;
use tumblenet::study::cost::reference::{ReferenceRequest, reference};
use tumblenet::study::cost::{self, Store, Study, StudyRequest};
use tumblenet::study::ensemble::{self, EnsembleRequest};
use tumblenet::study::log_rank::{self, LogRank};

/// Keeps nothing.
struct Forgetful;

impl Store for Forgetful {
    fn known<T: DeserializeOwned>(&self, _: &Case, _: &str, _: usize) -> Option<T> {
        None
    }
    fn keep<T: Serialize>(&self, _: &Case, _: &str, _: usize, _: &T) {}
}

fn study(scene: Value, budget_s: f64) -> Study {
    let request = StudyRequest { budget_s, seed: 1, at_s: None };
    cost::run(&common::source_of(scene), &request, &Forgetful, |_, _| {}).unwrap()
}

/// The oracle of the study against the one of the tests, which share no code.
#[test]
fn the_reference_flies_as_the_equations_say() {
    let case = common::scene("deployment-kevlar", &[]);
    let times: Vec<f64> = (0..=6).map(|i| 0.05 * f64::from(i)).collect();
    let located = dopri5::fly(case.net(), &times, 1e-12, |_| true);
    let stepped = common::rk4_net(case.net(), 5e-6, &times);
    assert_eq!(located.knots.len(), times.len());
    for (bound, frame) in [(1e-6, 2), (2e-5, 4), (5e-5, 6)] {
        let apart = |&bullet: &usize| (located.knots[frame][bullet] - stepped[frame][bullet]).norm();
        let worst = case.net().bullets.iter().map(apart).fold(0.0, f64::max);
        below(&format!("bullets at {} s, m", times[frame]), worst, bound); // measured 5e-8, 1e-6, 5e-6
    }
    // A tolerance a hundred times coarser moves no bullet by more than the coarser one's share.
    let coarse = dopri5::fly(case.net(), &times, 1e-10, |_| true);
    let apart = |&bullet: &usize| (located.knots[4][bullet] - coarse.knots[4][bullet]).norm();
    below("tolerance, m", case.net().bullets.iter().map(apart).fold(0.0, f64::max), 1e-7);
    assert!(
        coarse.steps < located.steps && located.switches > 20,
        "{} {} {}",
        coarse.steps,
        located.steps,
        located.switches
    );
}

/// Where a study cannot pay for located switches its reference is of steps, and the floor tells what these err by, too: not only how far
/// two starts part.
#[test]
fn the_floor_tells_what_the_steps_of_a_reference_err_by() {
    let case = common::scene("deployment-kevlar", &[]);
    let times: Vec<f64> = (0..=6).map(|i| 0.05 * f64::from(i)).collect();
    let located = dopri5::fly(case.net(), &times, 1e-12, |_| true);
    let mut source = Source::find("deployment-kevlar").unwrap();
    source.set(&["expect=null".to_owned()]).unwrap();
    let request = ReferenceRequest {
        times: times.clone(),
        whole: false,
        first_contact: None,
        seed: 1,
        seconds: 1.0,
        at: None,
    };
    let found = reference(&source, &case, &request).unwrap();
    assert!(found.quality.methods[0] == "secant" && found.knots.len() == times.len(), "{:?}", found.quality);
    for (frame, time) in times.iter().enumerate().skip(2) {
        let apart = |&bullet: &usize| (located.knots[frame][bullet] - found.knots[frame][bullet]).norm();
        let worst = case.net().bullets.iter().map(apart).fold(0.0, f64::max);
        let floor = found.quality.floor_m[frame];
        below(&format!("error of the reference at {time} s over its floor"), worst / floor, 3.0);
    }
}

/// Shots that deviate from member to member are no error of a method: the runs of a reference are shot alike. They were not, and a floor of
/// 3 mm at 0.05 s left nothing to say.
#[test]
fn a_reference_knows_one_shot_however_shots_are_dispersed() {
    let mut source = Source::find("cubesat-chaser").unwrap();
    source.set(&["expect=null".to_owned()]).unwrap();
    let times = (0..=5).map(|i| 0.01 * f64::from(i)).collect();
    let request =
        ReferenceRequest { times, whole: false, first_contact: None, seed: 1, seconds: 1.0, at: None };
    let found = reference(&source, &Case::build(&source).unwrap(), &request).unwrap();
    below("floor at 0.05 s, m", *found.quality.floor_m.last().unwrap(), 1e-6);
}

/// Errors, front, counters and advice of a small deployment.
#[test]
fn a_study_measures_every_dial_against_the_reference() {
    let found = study(common::small_scene(), 8.0);
    let quality = found.reference.as_ref().expect("a small net has a reference");
    assert!(
        quality.windows.iter().all(|window| (0.0..=quality.horizon_s).contains(&window.end_s)),
        "{quality:?}"
    );
    assert!(quality.runs.iter().all(|runs| *runs > 1), "{:?}", quality.runs);
    assert!(quality.floor_m.windows(2).all(|pair| pair[0] <= pair[1]), "the floor only rises");

    let written = &found.settings[0];
    assert!(written.cost.is_some() && written.error(0).is_some(), "{written:?}");
    // The front falls: dearer is more accurate.
    let on_front = |label: &String| found.settings.iter().find(|one| one.label == *label).unwrap();
    for (window, front) in found.fronts.iter().enumerate() {
        let points: Vec<(f64, f64)> =
            front.iter().map(|label| on_front(label).point(window).unwrap()).collect();
        assert!(!points.is_empty());
        assert!(points.windows(2).all(|pair| pair[0].0 <= pair[1].0 && pair[0].1 > pair[1].1), "{points:?}");
        assert!(front.iter().all(|label| on_front(label).warnings.is_empty()));
    }
    assert!(found.advice.sentence.contains("before contact (known until"), "{}", found.advice.sentence);

    // The same again, however busy the machine is: the budget is counted.
    let again = study(common::small_scene(), 8.0);
    for (one, other) in found.settings.iter().zip(&again.settings) {
        assert_eq!((&one.label, &one.without, &one.worth), (&other.label, &other.without, &other.worth));
        assert_eq!(one.cost.is_some(), other.cost.is_some(), "{}", one.label);
    }
    let measured = found.settings.iter().filter(|one| one.worth.is_some()).count();
    assert!(measured >= 12, "{measured} settings");
}

fn program(arguments: &[&str], folder: &Path) -> Output {
    let program = env!("CARGO_BIN_EXE_tumblenet");
    Command::new(program).args(arguments).current_dir(folder).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A capture of half a second, so that all stages of the study have something to do.
fn quick_capture() -> Value {
    let mut scene = common::small_scene();
    scene["duration_s"] = json!(0.3);
    scene["target"] = json!({
        "shape": { "parts": [{ "cuboid": [0.08, 0.25, 0.15] }] },
        "distance_m": 0.3, "mass_kg": 1.0, "spin_rad_s": [0.5, 0.2, 0.0]
    });
    scene["effects"] = json!({ "friction": { "coefficient": 0.2 } });
    // Any enclosure counts, so that the short flight is held at times.
    scene["capture"] = json!({ "hold_s": 0.02, "enclosed_min": 0.01, "mouth_max": 10.0 });
    scene
}

/// In `cost.json` every setting but the finest is set against its curve, and the advice counts the members.
fn assert_curves_are_compared(study: &Value) {
    let verdicts = study["verdicts"].as_array().unwrap();
    assert!(verdicts[0]["holding"].is_null() && verdicts[0]["survival"]["members"].as_u64().unwrap() > 0);
    for other in &verdicts[1..] {
        let [p, adjusted] = ["p", "adjusted_p"].map(|key| other["holding"][key].as_f64().unwrap());
        assert!(0.0 < p && p <= adjusted && adjusted <= 1.0, "{other}");
    }
    let holding = &study["advice"]["for_holding"];
    assert_eq!(holding["comparisons"].as_u64().unwrap() as usize, verdicts.len() - 1);
    assert_eq!(holding["members"], verdicts[1]["holding"]["members"][0]);
}

/// A target out of reach is never held: the study says nothing of how long.
#[test]
fn without_contact_nothing_is_said_of_how_long_it_holds() {
    let mut scene = quick_capture();
    scene["target"]["distance_m"] = json!(9.0);
    let study = study(scene, 2.0);
    assert!(!study.verdicts.is_empty());
    assert!(study.verdicts.iter().all(|one| one.survival.is_none() && one.holding.is_none()));
    assert!(study.advice.for_holding.is_none() && !study.advice.sentence.contains("how long"));
}

/// Where runs to the scene's end are too dear, settings are measured in flight, and there is a front all the same.
#[test]
fn a_dear_scene_is_measured_until_contact_and_has_a_front() {
    let mut scene = quick_capture();
    scene["duration_s"] = json!(60.0);
    let found = study(scene.clone(), 4.0);
    let contact = found.reference.as_ref().and_then(|quality| quality.first_contact_s).unwrap();
    let until = found.measured_until_s.expect("60 s are too dear");
    assert!(0.0 < until && until < contact, "{until} {contact}");
    assert!(found.written_cost.is_none() && found.verdicts.is_empty());
    assert!(!found.fronts.is_empty() && found.fronts.iter().all(|front| !front.is_empty()));
    assert!(found.settings[0].fronts.is_empty() || found.settings[0].error(0).is_some());
    let measured: Vec<_> = found.settings.iter().filter(|one| one.worth.is_some()).collect();
    assert!(measured.len() >= 12, "{} settings", measured.len());
    assert!(measured.iter().all(|one| one.worth.as_ref().unwrap().ending.is_none()));
    let of_contact = found.settings.iter().filter(|one| one.kind == DialKind::Contact);
    assert!(of_contact.into_iter().all(|one| one.without.is_some()));

    // Counts say what is too dear: with more to spend runs go to the end again.
    scene["duration_s"] = json!(0.3);
    let whole = study(scene, 10.0);
    assert!(whole.measured_until_s.is_none() && whole.written_cost.is_some());
    assert!(whole.settings[0].worth.as_ref().unwrap().ending.is_some());
}

/// Two settings that differ, a thread and none, and two that do not, one scene with other seeds.
#[test]
fn survival_tells_a_thread_from_none_and_not_a_seed_from_another() {
    let members = |name: &str, seed: u64| -> Vec<(Capture, f64)> {
        let changes =
            ["solver.cables=explicit", "solver.contact=impulse", "output.sample_s=0.01", "expect=null"];
        let case = Case::load(name, &changes.map(str::to_owned)).unwrap();
        let request = EnsembleRequest { members: 6, perturb_m: 1e-6, seed, at_most_s: None };
        let members = ensemble::run(&case, &request, Vec::new(), |_| {});
        let ends = members.into_iter().map(|member| member.outcome.unwrap());
        ends.map(|summary| (summary.capture.unwrap(), summary.simulated_s)).collect()
    };
    let without = members("cubesat-spin-x-2.0", 1);
    let mut tests = [
        LogRank::of(&members("cubesat-spin-x-2.0-tube", 1), &without, 1),
        LogRank::of(&members("cubesat-spin-x-2.0", 2), &without, 1),
    ];
    log_rank::adjust(&mut tests.each_mut());
    let [thread, seed] = tests;
    println!("thread {thread:?}, seed {seed:?}");
    assert!(thread.told_apart() && thread.excess < 0.0 && thread.can_tell(2), "{thread:?}");
    assert!(!seed.told_apart(), "{seed:?}");
}

#[test]
fn a_study_is_written_whole_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("quick.json");
    std::fs::write(&scene, quick_capture().to_string()).unwrap();
    let arguments = ["cost", "quick.json", "--budget", "10s", "--out", "out"];
    let done = program(&arguments, folder.path());
    assert!(done.status.success(), "{}", said(&done));
    assert!(String::from_utf8_lossy(&done.stdout).contains("use"), "{done:?}");

    let out = folder.path().join("out");
    let read =
        || -> Value { serde_json::from_slice(&std::fs::read(out.join("cost.json")).unwrap()).unwrap() };
    let first = read();
    assert!(first["reference"]["first_contact_s"].as_f64().unwrap() > 0.0);
    assert!(first["verdicts"][0]["captured"]["of"].as_u64().unwrap() >= 2);
    assert_curves_are_compared(&first);
    assert!(first["provenance"]["command"].as_str().unwrap().contains("cost quick.json"));
    let refused = first["settings"].as_array().unwrap().iter().find(|one| one["label"] == "explicit+rapier");
    assert!(refused.unwrap()["without"].as_str().unwrap().starts_with("refused"));

    let mut rows = csv::Reader::from_path(out.join("cost.csv")).unwrap();
    assert_eq!(rows.records().count(), first["settings"].as_array().unwrap().len());
    let page = std::fs::read_to_string(out.join("cost.html")).unwrap();
    assert!(!page.contains("{{") && page.contains("The engine is built with"));
    assert!(page.contains("log-rank against the finest"));
    assert!(String::from_utf8_lossy(&done.stdout).contains("how long it holds: "), "{done:?}");
    for name in ["work-precision", "trust", "verdicts", "survival", "stability"] {
        let svg = std::fs::read_to_string(out.join(name).with_extension("svg")).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf\""), "{name}");
        assert!(page.contains(&svg), "{name} stands in the page");
    }

    // What was measured is not measured again: times and all.
    assert!(program(&arguments, folder.path()).status.success());
    let again = read();
    assert_eq!(again["settings"][0]["cost"]["least"], first["settings"][0]["cost"]["least"]);
    assert_eq!(again["settings"][0]["worth"]["counts"], first["settings"][0]["worth"]["counts"]);
}

/// What `run --accuracy` promises, asked of the located integrator, on nets that differ in material, damping, speed and
/// size, with and without a target.
#[test]
fn an_accuracy_is_reached_on_every_scene_or_refused() {
    let small = |change: &dyn Fn(&mut Value)| {
        let mut scene = common::small_scene();
        scene["solver"] = json!({ "cables": "explicit", "contact": "impulse" });
        change(&mut scene);
        scene
    };
    let kevlar = json!({ "material": "kevlar", "diameter_m": 0.001, "damping_ratio": 0.1 });
    let scenes = [
        small(&|_| {}),
        small(&|scene| scene["net"]["cable"] = kevlar.clone()),
        small(&|scene| scene["net"]["cable"]["damping_ratio"] = json!(0.003)),
        small(&|scene| scene["launch"]["speed_m_s"] = json!(8.0)),
        small(&|scene| scene["net"]["mesh_length_m"] = json!(0.4)),
        small(&|scene| scene["solver"] = json!({})),
        small(&|scene| {
            scene["target"] = json!({ "shape": { "parts": [{ "cuboid": [0.11, 0.25, 0.15] }] }, "distance_m": 0.4, "mass_kg": 1.0 });
            scene["solver"] = json!({});
        }),
        // Steps follow from a thin part, and from the cable: as they are none divides the time between frames, and both were refused.
        small(&|scene| {
            scene["target"] = json!({ "shape": { "parts": [{ "ball": { "radius_m": 0.03 } }] }, "distance_m": 0.9, "mass_kg": 1.0 });
            scene["launch"]["speed_m_s"] = json!(3.1);
            scene["net"]["mesh_length_m"] = json!(0.13);
            scene["net"]["cable"] = json!({ "material": "nylon", "diameter_m": 0.0005 });
        }),
        small(&|scene| {
            scene["target"] = json!({ "shape": { "parts": [{ "cuboid": [0.02, 0.2, 0.1] }] }, "distance_m": 0.9, "mass_kg": 1.0 });
            scene["launch"]["speed_m_s"] = json!(3.7);
            scene["net"]["cable"] =
                json!({ "material": "spectra", "diameter_m": 0.0007, "damping_ratio": 0.05 });
        }),
    ];
    let mut reached = 0;
    for (number, scene) in scenes.into_iter().enumerate() {
        let mut source = common::source_of(scene);
        let side = Case::build(&source).unwrap().net().designed_area.sqrt();
        let found = match calibrate(&source, &[], Accuracy::Share(3e-4)) {
            Ok(found) => found,
            Err(refused) => {
                assert!(refused.to_string().contains("at least"), "{number}: {refused}");
                continue;
            }
        };
        println!("{number}: {}", found.words());
        reached += 1;
        source.set(&found.changes).unwrap();
        source.set(&["output.sample_s=0.01".to_owned()]).unwrap();
        let case = Case::build(&source).unwrap();
        let run = common::run(&case);
        let frames = run.frames.time.partition_point(|time| *time <= found.until_s + 1e-9);
        let truth = dopri5::fly(case.net(), &run.frames.time[..frames], 1e-12 * side, |_| true).knots;
        for (frame, truth) in truth.iter().enumerate() {
            let apart = |&bullet: &usize| (run.frames.knots[frame][bullet] - truth[bullet]).norm();
            let error = case.net().bullets.iter().map(apart).fold(0.0, f64::max);
            below(
                &format!("{number}: error at {} s over the accuracy", run.frames.time[frame]),
                error / (3e-4 * side),
                1.0,
            );
        }
    }
    assert!(reached >= 8, "{reached} of 9"); // measured 9 of 9
}

#[test]
fn an_accuracy_chooses_the_setting_and_a_word_of_ones_own_stays() {
    let folder = common::program::with_scene(|scene| {
        scene.as_object_mut().unwrap().remove("target");
        scene.as_object_mut().unwrap().remove("capture");
    });
    let run = |more: &[&str]| {
        let all: Vec<&str> = ["run", "scene.json", "--format", "json"].iter().chain(more).copied().collect();
        program(&all, folder.path())
    };
    let done = run(&["--accuracy", "standard"]);
    assert!(done.status.success(), "{}", said(&done));
    assert!(said(&done).contains("measured on this scene"), "{}", said(&done));
    let summary: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(summary["solver"]["cables"], "explicit");

    let own = run(&["--accuracy", "2cm", "--set", "solver.snap_passes=7", "--set", "solver.cables=joints"]);
    let summary: Value = serde_json::from_slice(&own.stdout).unwrap();
    assert_eq!(
        (&summary["solver"]["snap_passes"], &summary["solver"]["cables"]),
        (&json!(7), &json!("joints"))
    );

    let refused = run(&["--accuracy", "1e-9mm"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(said(&refused).contains("at least"), "{}", said(&refused));
}

#[test]
fn bad_arguments_end_with_status_2_and_say_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&[&str], &str); 6] = [
        (&["cost", "nowhere"], "a built-in scene"),
        (&["cost"], "required"),
        (&["cost", "deployment-kevlar", "--budget", "soon"], "as in 60s"),
        (&["cost", "deployment-kevlar", "--budget", "0s"], "at least 1 s"),
        (&["cost", "deployment-kevlar", "--at", "-1"], "--at"),
        (&["run", "cubesat-free", "--accuracy", "very"], "fast, standard, fine"),
    ];
    for (arguments, words) in cases {
        let done = program(arguments, folder.path());
        assert_eq!(done.status.code(), Some(2), "{arguments:?}");
        assert!(said(&done).contains(words), "{words:?} not in {:?}", said(&done));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written");
}
