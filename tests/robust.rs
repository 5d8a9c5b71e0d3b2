//! What goes wrong around a run: too much is asked for, files outside, a full disk, an end before
//! its time. Each ends in words, and nothing that was finished is lost.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use crate::common::program::{command, err, files, tumblenet, with_scene};
use serde_json::{Value, json};

#[test]
fn every_limit_is_told_with_its_name_and_can_be_changed() {
    let points: Vec<_> =
        (0..20).map(|i| [f64::from(i % 2), f64::from(i / 2 % 2), 0.01 * f64::from(i)]).collect();
    let folder = with_scene(|scene| {
        scene["target"]["shape"]["parts"] = json!([{ "convex": { "points_m": points } },
            { "mesh": { "file": "mesh.obj" }, "position_m": [2, 0, 0] }]);
    });
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    std::fs::write(folder.path().join("mesh.obj"), mesh).unwrap();
    let sound = tumblenet(folder.path(), &["check", "scene.json"]);
    assert_eq!(sound.status.code(), Some(0), "{}", err(&sound));
    for (limit, place) in [
        ("text", "(top level)"),
        ("mesh", "target.shape.parts[1].mesh.file"),
        ("knots", "net.meshes"),
        ("steps", "duration_s"),
        ("positions", "output.sample_s"),
        ("parts", "target.shape.parts"),
        ("points", "target.shape.parts[0].convex"),
        ("triangles", "target.shape.parts[1].mesh.file"),
        ("memory", "net.meshes"),
        ("work", "duration_s"),
    ] {
        let lowered = tumblenet(folder.path(), &["check", "scene.json", "--limit", &format!("{limit}=1")]);
        assert_eq!(lowered.status.code(), Some(2), "{limit}");
        let told = err(&lowered);
        assert!(told.contains(&format!("--limit {limit}=N raises it")), "{limit}: {told}");
        assert!(told.contains(&format!("  {place}: found")), "{limit}: {told}");
    }
    let members = ["run", "scene.json", "--ensemble", "3", "--limit", "members=2"];
    let refused = tumblenet(folder.path(), &members);
    assert_eq!(refused.status.code(), Some(2));
    assert!(err(&refused).contains("at most 2 members (--limit members=N raises it)"), "{}", err(&refused));
    let unknown = tumblenet(folder.path(), &["check", "scene.json", "--limit", "wishes=3"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(err(&unknown).contains("knots=250000"), "{}", err(&unknown));
    assert_eq!(files(folder.path()).len(), 2, "nothing was written");
}

#[test]
fn a_scene_reads_outside_of_its_folder_only_when_the_user_says_so() {
    let folder = with_scene(|scene| scene["target"]["shape"] = json!("../shape.json"));
    let below = folder.path().join("below");
    std::fs::create_dir(&below).unwrap();
    std::fs::rename(folder.path().join("scene.json"), below.join("scene.json")).unwrap();
    let shape = json!({ "parts": [{ "cuboid": [0.08, 0.25, 0.15] }] });
    std::fs::write(folder.path().join("shape.json"), shape.to_string()).unwrap();
    for (folder, scene) in [(folder.path(), "below/scene.json"), (&below, "scene.json")] {
        let refused = tumblenet(folder, &["check", scene]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(
            err(&refused).contains("target.shape: found \"../shape.json\", outside"),
            "{}",
            err(&refused)
        );
        let read = tumblenet(folder, &["check", scene, "--allow-outside"]);
        assert_eq!(read.status.code(), Some(0), "{}", err(&read));
    }
}

#[test]
fn a_second_run_replaces_the_first_and_says_so() {
    let folder = with_scene(|_| {});
    let printed = |changes: &[&str]| {
        let output = tumblenet(folder.path(), &[&["run", "scene.json"], changes].concat());
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(!printed(&[]).contains("in place of"));
    let first = files(&folder.path().join("results"));
    assert!(printed(&["--set", "duration_s=0.2"]).contains("in place of an earlier run's"));
    let second = files(&folder.path().join("results"));
    assert!(first.keys().eq(second.keys()));
    assert!(first.values().zip(second.values()).all(|(one, other)| one != other), "all files are new");
}

/// Linux tells a full disk through this file.
#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_told() {
    let folder = with_scene(|_| {});
    let full = || Stdio::from(std::fs::File::options().write(true).open("/dev/full").unwrap());
    for arguments in [&["schema"][..], &["list"], &["check", "scene.json"], &["run", "scene.json"]] {
        let output = command(folder.path(), arguments).stdout(full()).stderr(Stdio::piped()).spawn().unwrap();
        let output = output.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(err(&output).contains("cannot write standard output: No space left"), "{}", err(&output));
    }
}

/// A limit on the size of files stands for a disk that fills up while a file is written.
#[cfg(unix)]
#[test]
fn a_disk_that_fills_up_leaves_the_earlier_results_whole() {
    let folder = with_scene(|_| {});
    assert_eq!(tumblenet(folder.path(), &["run", "scene.json"]).status.code(), Some(0));
    let before = files(folder.path());
    let script = format!(
        "trap '' XFSZ; ulimit -f 16; exec '{}' run scene.json --set duration_s=0.25",
        env!("CARGO_BIN_EXE_tumblenet")
    );
    let output = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", err(&output));
    assert!(err(&output).starts_with("error: cannot write results/scene/"), "{}", err(&output));
    assert_eq!(output.stdout, b"");
    assert_eq!(err(&output).lines().count(), 1, "one fault, told once: {}", err(&output));
    assert_eq!(files(folder.path()), before, "whole, and nothing half-written beside");
}

/// Starts the program and waits until `ready`.
#[cfg(unix)]
fn start(folder: &Path, arguments: &[&str], ready: impl Fn() -> bool) -> Child {
    let mut child = command(folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    while !ready() {
        assert_eq!(child.try_wait().unwrap(), None, "ended before its time");
        std::thread::sleep(Duration::from_millis(5));
    }
    child
}

#[cfg(unix)]
fn signal(child: Child, name: &str) -> Output {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_writes_nothing_and_says_so() {
    for name in ["-INT", "-TERM"] {
        let folder = with_scene(|scene| scene["duration_s"] = json!(5000.0));
        let results = folder.path().join("results/scene");
        let arguments = ["run", "scene.json", "--set", "output.sample_s=1"];
        let output = signal(start(folder.path(), &arguments, || results.exists()), name);
        assert_eq!(output.status.code(), Some(130), "{}", err(&output));
        assert_eq!(err(&output), "interrupted: nothing of this run was written\n");
        assert_eq!(files(&results), BTreeMap::new());
    }
}

/// Interrupted or killed: what was finished is kept, whole, and is not run again.
#[cfg(unix)]
#[test]
fn an_ensemble_that_ends_before_its_time_keeps_what_was_finished() {
    for name in ["-INT", "-KILL"] {
        let folder = with_scene(|_| {});
        let kept = || files(&folder.path().join("results/scene/members"));
        let arguments = ["run", "scene.json", "--ensemble", "100000"];
        // What is being written has no name yet that a member has.
        let finished =
            || kept().keys().filter(|path| path.extension().is_some_and(|ending| ending == "json")).count();
        let output = signal(start(folder.path(), &arguments, || finished() >= 3), name);
        if name == "-INT" {
            assert_eq!(output.status.code(), Some(130), "{}", err(&output));
            let told = "interrupted: finished members are kept in results/scene; the same command goes on";
            assert!(err(&output).starts_with(told), "{}", err(&output));
        }
        let mut members = kept();
        if name == "-KILL" {
            members.retain(|path, _| path.extension().is_some_and(|ending| ending == "json"));
        }
        assert!(members.len() >= 3);
        for (path, bytes) in &members {
            let member: Value = serde_json::from_slice(bytes).unwrap_or_else(|why| panic!("{path:?}: {why}"));
            assert!(member["outcome"]["Ok"]["capture"].is_object(), "{path:?}");
        }
        let again = tumblenet(folder.path(), &["run", "scene.json", "--ensemble", "3", "--format", "json"]);
        assert_eq!(again.status.code(), Some(0), "{}", err(&again));
        let ensemble: Value = serde_json::from_slice(&again.stdout).unwrap();
        assert_eq!(ensemble["captured"]["of"], json!(3));
        let after = kept();
        assert!(members.iter().all(|(path, bytes)| after[path] == *bytes), "a finished member ran again");
    }
}

// What follows is named after a symptom that was found by trying.

/// `check` of the scene ends with status 2 and tells all of `words`.
fn refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let output = tumblenet(folder, arguments);
    let told = err(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
    for word in words {
        assert!(told.contains(word), "{word:?} not in {told}");
    }
    assert!(!told.contains("panicked") && output.stdout.is_empty(), "{told}");
}

#[test]
fn ten_thousand_knots_with_self_contact_do_not_take_three_gigabytes() {
    let folder = with_scene(|scene| {
        scene["net"]["meshes"] = json!([100, 100]);
        scene["target"]["distance_m"] = json!(2.0);
        scene["effects"] = json!({ "self_contact": {} });
    });
    let words = [
        "effects.self_contact: found what takes 3.3 GB",
        "2147483648 bytes of memory (--limit memory=N raises it)",
    ];
    refused(folder.path(), &["check", "scene.json"], &words);
    let raised = tumblenet(folder.path(), &["check", "scene.json", "--limit", "memory=4e9"]);
    assert_eq!(raised.status.code(), Some(0), "{}", err(&raised));
}

#[test]
fn forty_thousand_knots_with_cable_contact_do_not_take_sixteen_gigabytes() {
    let folder = with_scene(|scene| {
        scene["net"]["meshes"] = json!([199, 199]);
        scene["net"]["mesh_length_m"] = json!(0.02);
        scene["target"] =
            json!({ "shape": { "parts": [{ "cuboid": [5, 5, 5] }] }, "distance_m": 2.8, "mass_kg": 1000 });
        scene["effects"] = json!({ "cable_contact": {} });
    });
    refused(
        folder.path(),
        &["check", "scene.json"],
        &["effects.cable_contact: found what takes", "--limit memory=N raises it"],
    );
}

#[test]
fn work_without_end_is_refused_before_it_begins() {
    let folder = with_scene(|scene| {
        scene["duration_s"] = json!(40_000.0);
        scene["output"] = json!({ "sample_s": 1000 });
    });
    refused(
        folder.path(),
        &["check", "scene.json", "--limit", "work=1e8"],
        &["duration_s: found 40000", "cable steps (--limit work=N"],
    );
}

#[test]
fn points_triangles_and_splits_count_over_all_parts() {
    // An L, which is not convex, and a tetrahedron.
    let l = "v 0 0 0\nv 3 0 0\nv 3 0 1\nv 1 0 1\nv 1 0 3\nv 0 0 3\nv 0 1 0\nv 3 1 0\nv 3 1 1\nv 1 1 1\nv 1 1 3\nv 0 1 3\n\
             f 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n\
             f 4 3 2 1\nf 6 5 4 1\nf 7 8 9 10\nf 7 10 11 12\n";
    let l_part = |x: f64| json!({ "mesh": { "file": "l.obj", "unit_m": 0.01 }, "position_m": [x, 0, 0] });
    let points = json!({ "points_m": [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]] });
    let folder = with_scene(|scene| {
        scene["target"]["distance_m"] = json!(1.0);
        scene["target"]["shape"]["parts"] =
            json!([l_part(0.0), l_part(0.1), { "convex": points }, { "convex": points }]);
    });
    std::fs::write(folder.path().join("l.obj"), l).unwrap();
    let sound = tumblenet(folder.path(), &["check", "scene.json"]);
    assert_eq!(sound.status.code(), Some(0), "{}", err(&sound));
    let with = |limit: &str, words: &[&str]| {
        refused(folder.path(), &["check", "scene.json", "--limit", limit], words)
    };
    with(
        "splits=1",
        &["parts[1].mesh.file: found \"l.obj\", not convex, after 1 of others", "--limit splits=N"],
    );
    with(
        "triangles=30",
        &["parts[1].mesh.file: found \"l.obj\" with too many triangles", "after 20 of others"],
    );
    with("mesh=300", &["parts[1].mesh.file", "of others", "--limit mesh=N"]);
    with("points=7", &["target.shape.parts: found 8 points in all", "--limit points=N"]);
}

/// A net of 2 x 2 whose integrator is asked for more than numbers can hold.
fn cut_without_end(scene: &mut Value) {
    scene["net"]["meshes"] = json!([2, 2]);
    scene["duration_s"] = json!(0.1);
    scene["solver"] =
        json!({ "cables": "explicit", "contact": "impulse", "integrator": "located", "tolerance_m": 1e-30 });
}

#[test]
fn steps_that_are_cut_inside_do_not_run_for_ever() {
    let folder = with_scene(cut_without_end);
    let output = tumblenet(folder.path(), &["run", "scene.json", "--limit", "cuts=100"]);
    assert_eq!(output.status.code(), Some(1), "{}", err(&output));
    assert!(
        err(&output).contains("parts on average, of at most 100 (--limit cuts=N raises it)"),
        "{}",
        err(&output)
    );
}

#[test]
fn an_ensemble_whose_members_all_failed_is_no_success() {
    let folder = with_scene(cut_without_end);
    let arguments = ["run", "scene.json", "--limit", "cuts=1", "--ensemble", "2"];
    for _ in 0..2 {
        let output = tumblenet(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(1), "{}", err(&output));
        assert!(err(&output).contains("no member was finished; member 0: at "), "{}", err(&output));
    }
}

#[test]
fn a_time_limit_ends_the_program_in_words() {
    let folder = with_scene(|_| {});
    for command in [&["run", "scene.json"][..], &["check", "scene.json"], &["compare", "scene.json"]] {
        let over = tumblenet(folder.path(), &[command, &["--time-limit", "0s"]].concat());
        assert_eq!(over.status.code(), Some(1), "{command:?}");
        assert_eq!(err(&over), "error: the time limit of 0 s is over\n", "{command:?}");
    }
    assert_eq!(files(folder.path()).len(), 1, "nothing was written");
    let within = tumblenet(folder.path(), &["run", "scene.json", "--time-limit", "1000h"]);
    assert_eq!(within.status.code(), Some(0), "{}", err(&within));
    refused(folder.path(), &["check", "scene.json", "--time-limit=-1s"], &["a time of at least 0 s"]);
}

#[test]
fn a_start_beyond_all_numbers_is_bad_input() {
    for (pointer, values, place) in [
        ("/net/mesh_length_m", [2e-308, 1e300], "net."),
        ("/net/cable/diameter_m", [1e-160, 1e160], "net."),
        ("/net/bullet_mass_kg", [2e-308, 1e300], "net.cable"),
        ("/target/mass_kg", [2e-308, 1e300], "target.mass_kg"),
        ("/target/distance_m", [1e160, 1e300], "target.distance_m"),
    ] {
        for value in values {
            let folder = with_scene(|scene| *scene.pointer_mut(pointer).unwrap() = json!(value));
            refused(folder.path(), &["run", "scene.json"], &[place]);
        }
    }
}

#[test]
fn a_perturbation_that_throws_the_net_is_refused() {
    let folder = with_scene(|_| {});
    for arguments in
        [&["run", "scene.json", "--ensemble", "2"][..], &["compare", "scene.json", "--members", "2"]]
    {
        refused(
            folder.path(),
            &[arguments, &["--perturb", "1"]].concat(),
            &["--perturb: 1 fault", "at most"],
        );
    }
}

#[test]
fn a_whole_number_with_a_point_a_mark_at_the_head_and_a_key_twice() {
    let folder = with_scene(|scene| {
        scene["net"]["meshes"] = json!([3.0, 3]);
        scene["net"]["middle_knots"] = json!(-0.0);
    });
    assert_eq!(tumblenet(folder.path(), &["check", "scene.json"]).status.code(), Some(0));
    let text = std::fs::read_to_string(folder.path().join("scene.json")).unwrap();
    std::fs::write(folder.path().join("scene.json"), format!("\u{feff}{text}")).unwrap();
    assert_eq!(tumblenet(folder.path(), &["check", "scene.json"]).status.code(), Some(0));
    let twice = text.replacen("\"duration_s\"", "\"duration_s\":1,\"duration_s\"", 1);
    std::fs::write(folder.path().join("scene.json"), twice).unwrap();
    refused(folder.path(), &["check", "scene.json"], &["duration_s: found this key twice"]);
}

#[test]
fn a_key_where_none_may_stand_is_told_in_words() {
    let folder = with_scene(|scene| {
        scene["effects"] = json!({ "cable_contact": { "x": 1 }, "closing": { "trigger": 3 } })
    });
    let told = err(&tumblenet(folder.path(), &["check", "scene.json"]));
    assert!(
        told.contains("effects.cable_contact.x: found an unknown key; allowed: note")
            && !told.contains("False schema"),
        "{told}"
    );
    assert!(told.contains("effects.closing.trigger: found 3; allowed: an object\n"), "{told}");
}

#[test]
fn a_path_of_sixty_thousand_levels_does_not_overflow_the_stack() {
    let folder = with_scene(|_| {});
    let path = vec!["a"; 60_000].join(".");
    let set = format!("{path}=1");
    refused(folder.path(), &["run", "scene.json", "--set", &set], &["60000 levels"]);
    refused(folder.path(), &["compare", "scene.json", "--vary", &set], &["60000 levels"]);
}

/// Pipes, devices and files of the kernel.
#[cfg(target_os = "linux")]
#[test]
fn endless_inputs_are_not_read() {
    let folder = with_scene(|_| {});
    let at = |name: &str| folder.path().join(name);
    assert!(Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
    std::os::unix::fs::symlink("/dev/zero", at("zero")).unwrap();
    for input in ["pipe", "zero"] {
        refused(folder.path(), &["check", input], &["no file"]);
    }
    refused(folder.path(), &["check", "/proc/kmsg"], &["no "]);

    assert_eq!(tumblenet(folder.path(), &["run", "scene.json", "--ensemble", "2"]).status.code(), Some(0));
    let member = files(&at("results/scene/members")).into_keys().next().unwrap();
    std::fs::create_dir_all(at("results/scene/cost")).unwrap();
    for endless in ["pipe", "zero"] {
        for place in [&member, &at("results/scene/summary.json"), &at("results/scene/cost/cost.json")] {
            std::fs::remove_file(place).ok();
            std::os::unix::fs::symlink(at(endless), place).unwrap();
        }
        assert_eq!(tumblenet(folder.path(), &["show", "scene.json"]).status.code(), Some(0));
        let again = tumblenet(folder.path(), &["run", "scene.json", "--ensemble", "2", "--format", "json"]);
        assert_eq!(again.status.code(), Some(0), "{}", err(&again));
        let ensemble: Value = serde_json::from_slice(&again.stdout).unwrap();
        assert_eq!(ensemble["captured"]["of"], json!(2));
    }
}

#[test]
fn a_member_copied_by_hand_is_not_counted() {
    let folder = with_scene(|_| {});
    let arguments = ["run", "scene.json", "--ensemble", "2", "--format", "json"];
    let first = tumblenet(folder.path(), &arguments);
    assert_eq!(first.status.code(), Some(0), "{}", err(&first));
    let members: Vec<PathBuf> = files(&folder.path().join("results/scene/members")).into_keys().collect();
    std::fs::copy(&members[0], &members[1]).unwrap();
    std::fs::copy(&members[0], members[0].with_file_name("000007.json")).unwrap();
    let again = tumblenet(folder.path(), &arguments);
    let ensemble: Value = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!(ensemble["captured"]["of"], json!(2));
    let member: Value = serde_json::from_slice(&std::fs::read(&members[1]).unwrap()).unwrap();
    assert_eq!(member["member"], json!(1), "run again");
}

#[test]
fn a_folder_in_the_place_of_a_result_costs_no_run_and_mixes_nothing() {
    let folder = with_scene(|_| {});
    assert_eq!(tumblenet(folder.path(), &["run", "scene.json"]).status.code(), Some(0));
    let results = folder.path().join("results/scene");
    std::fs::remove_file(results.join("trajectory.npz")).unwrap();
    std::fs::create_dir(results.join("trajectory.npz")).unwrap();
    let before = files(&results);
    let output = tumblenet(folder.path(), &["run", "scene.json", "--set", "duration_s=0.2"]);
    assert_eq!(output.status.code(), Some(1));
    let told = "error: cannot write results/scene/trajectory.npz: a folder has that name\n";
    assert_eq!(err(&output), told);
    assert_eq!(files(&results), before);
}

#[test]
fn a_scene_named_by_dots_does_not_write_beside_itself() {
    let folder = with_scene(|_| {});
    std::fs::rename(folder.path().join("scene.json"), folder.path().join("...json")).unwrap();
    let output = tumblenet(folder.path(), &["run", "...json"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert_eq!(files(folder.path()).len(), 5);
    assert!(folder.path().join("results/scene/summary.json").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_error_is_no_panic() {
    let full = || Stdio::from(std::fs::File::options().write(true).open("/dev/full").unwrap());
    let folder = with_scene(|_| {});
    for (arguments, status) in [
        (&["check", "nope"][..], 2),
        (&["check", "nope", "nowhere"], 2),
        (&["run", "scene.json", "--time-limit", "0"], 1),
    ] {
        let status_of =
            command(folder.path(), arguments).stderr(full()).stdout(Stdio::null()).status().unwrap();
        assert_eq!(status_of.code(), Some(status), "{arguments:?}");
    }
}

#[test]
fn control_characters_do_not_reach_the_terminal() {
    let folder = with_scene(|scene| {
        scene["title"] = json!("harmless\u{1b}[2J\u{9b}31m\rerror: none\n\u{202e}");
        scene["duration_s"] = json!(0.05);
        scene["capture"] = json!({ "hold_s": 0 });
    });
    std::fs::write(folder.path().join("rows.csv"), "t_s\u{1b}]0;x\u{7},a\u{1b}[31m\n1,\u{1b}[2Jx\n").unwrap();
    let cabin = "effects.cabin={\"profile\":\"rows.csv\"}";
    for arguments in [
        &["run", "scene.json"][..],
        &["check", "scene.json"],
        &["show", "scene.json"],
        &["run", "scene.json", "--ensemble", "1"],
        &["check", "no\u{1b}[31mpe"],
        &["run", "scene.json", "--set", cabin],
        &["run", "scene.json", "--set", "net.\u{1b}[31m=1"],
    ] {
        let output = tumblenet(folder.path(), arguments);
        let all = [output.stdout, output.stderr].concat();
        let text = String::from_utf8(all).unwrap();
        let obeyed: Vec<char> =
            text.chars().filter(|c| c.is_control() && *c != '\n' || *c == '\u{202e}').collect();
        assert!(obeyed.is_empty(), "{arguments:?}: {obeyed:?} in {text:?}");
    }
}

/// What a killed program leaves is no result: the next one removes it.
#[cfg(unix)]
#[test]
fn a_kill_while_writing_leaves_nothing_that_stays() {
    let folder = with_scene(|_| {});
    let results = folder.path().join("results/scene");
    std::fs::create_dir_all(&results).unwrap();
    std::fs::write(results.join(".unfinished-abc123"), "half").unwrap();
    let output = tumblenet(folder.path(), &["run", "scene.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let names: Vec<PathBuf> = files(&results).into_keys().collect();
    assert_eq!(names.len(), 4, "{names:?}");
}

/// Runs of the catalogue of hard cases are kept as they end, and not run again.
#[cfg(unix)]
#[test]
fn an_interrupted_stress_keeps_what_was_finished() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["stress", "e-0.4", "--pairs", "joints+rapier", "--format", "json"];
    let kept = || files(&folder.path().join("results/stress/runs"));
    let is_member = |path: &Path| path.extension().is_some_and(|ending| ending == "json");
    signal(start(folder.path(), &arguments, || kept().keys().any(|path| is_member(path))), "-KILL");
    let mut before = kept();
    before.retain(|path, _| is_member(path));
    let again = tumblenet(folder.path(), &arguments);
    assert_eq!(again.status.code(), Some(0), "{}", err(&again));
    let after = kept();
    assert!(before.iter().all(|(path, bytes)| after[path] == *bytes), "a finished run was run again");
    assert!(after.keys().all(|path| is_member(path)), "nothing unfinished stays");
}
