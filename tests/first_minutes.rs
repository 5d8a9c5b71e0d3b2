//! The first ten minutes: what a new user types, and sees. Named after what went wrong.

use crate::common;

use std::path::Path;
use std::process::Command;

use crate::common::program::{command, err, out, printed, tumblenet, with_scene, write_scene};
use serde_json::{Value, json};

/// What is told of bad input.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = tumblenet(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", err(&output));
    err(&output)
}

/// `RENEW=1 cargo test --test suite first_minutes` writes them anew, as `tumblenet schema` prints them.
#[test]
fn an_editor_finds_the_schemas_as_they_are() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    for kind in ["scene", "study", "fit"] {
        let schema = printed(Path::new("."), &["schema", kind]);
        let path = folder.join(format!("{kind}.schema.json"));
        if std::env::var_os("RENEW").is_some() {
            std::fs::write(&path, &schema).unwrap();
        }
        let published = std::fs::read_to_string(&path).unwrap();
        assert!(
            published == schema,
            "{kind}: RENEW=1 cargo test --test suite first_minutes, if its format has changed"
        );
    }
}

#[test]
fn a_change_is_checked_before_it_is_run() {
    let folder = tempfile::tempdir().unwrap();
    let check = ["check", "cubesat-free", "cube-fixed", "--set"];
    let told = printed(folder.path(), &[&check[..], &["net.middle_knots=1"]].concat());
    assert!(told.contains("cubesat-free: ok") && told.contains("cube-fixed: ok"), "{told}");
    let told = refused(folder.path(), &[&check[..], &["net.midle_knots=1"]].concat());
    assert_eq!(told.matches("did you mean middle_knots").count(), 2, "{told}");
}

#[test]
fn a_scene_of_ones_own_begins_with_one_that_runs() {
    let folder = tempfile::tempdir().unwrap();
    let told = printed(folder.path(), &["new", "my-scene.json"]);
    assert!(
        told.contains("tumblenet check my-scene.json") && told.contains("tumblenet run my-scene.json"),
        "{told}"
    );
    let checked = tumblenet(folder.path(), &["check", "my-scene.json"]);
    assert_eq!(
        (checked.status.code(), err(&checked)),
        (Some(0), String::new()),
        "no fault, and nothing to warn of"
    );
    let scene: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("my-scene.json")).unwrap()).unwrap();
    for place in ["", "/net", "/launch", "/target", "/effects"] {
        assert!(scene.pointer(place).unwrap().get("note").is_some(), "{place} explains itself");
    }
    // What is built in and what the notes name is there.
    let schema = printed(folder.path(), &["schema"]);
    for name in
        ["friction", "self_contact", "orbit", "cabin", "drag", "chaser", "tug", "spin_deg_s", "attitude_wxyz"]
    {
        assert!(schema.contains(&format!("\"{name}\"")), "{name}");
    }
    let short = ["run", "my-scene.json", "--set", "duration_s=0.3", "--set", "title=short"];
    assert!(printed(folder.path(), &short).contains("results/my-scene"));
}

#[test]
fn a_new_scene_overwrites_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mine.json"), "mine").unwrap();
    let told = refused(folder.path(), &["new", "mine.json"]);
    assert!(told.contains("mine.json: 1 fault") && told.contains("nothing is overwritten"), "{told}");
    assert_eq!(std::fs::read(folder.path().join("mine.json")).unwrap(), b"mine");
    let nowhere = tumblenet(folder.path(), &["new", "nowhere/mine.json"]);
    assert_eq!(nowhere.status.code(), Some(1));
    assert!(err(&nowhere).starts_with("error: cannot write nowhere/mine.json: "), "{}", err(&nowhere));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn notes_change_nothing_and_are_texts() {
    let folder = with_scene(|_| {});
    let hash = || {
        let text = printed(folder.path(), &["run", "scene.json", "--format", "json"]);
        serde_json::from_str::<Value>(&text).unwrap()["scene_hash"].clone()
    };
    let plain = hash();
    write_scene(folder.path(), |scene| {
        scene["note"] = json!("why");
        scene["net"]["cable"]["note"] = json!(["two", "lines"]);
        scene["target"]["shape"]["parts"][0]["note"] = json!("a box");
        scene["solver"] = json!({ "note": "as it comes" });
    });
    assert_eq!(hash(), plain);
    write_scene(folder.path(), |scene| scene["net"]["note"] = json!(3));
    assert!(
        refused(folder.path(), &["check", "scene.json"])
            .contains("net.note: found 3; allowed: a text or a list")
    );
}

#[test]
fn a_slip_of_the_pen_is_asked_about() {
    let folder = with_scene(|scene| {
        scene["net"]["bulet_mass_kg"] = json!(1);
        scene["net"]["cable"]["material"] = json!("kelvar");
        scene["target"]["shape"] = json!("cubesat-u3");
    });
    let told = refused(folder.path(), &["check", "scene.json"]);
    for words in [
        "net.bulet_mass_kg: found an unknown key; allowed: did you mean bullet_mass_kg? Keys here: meshes, ",
        "net.cable.material: found \"kelvar\"; allowed: did you mean \"kevlar\"?",
        "target.shape: found \"cubesat-u3\"; allowed: did you mean \"cubesat-3u\"?",
    ] {
        assert!(told.contains(words), "{words} in {told}");
    }
    let told = refused(folder.path(), &["run", "cubesat-fre"]);
    assert!(told.contains("did you mean \"cubesat-free\"? (`tumblenet list` names all)"), "{told}");
    let told = refused(folder.path(), &["stress", "e-0.4", "chater"]);
    assert!(told.contains("did you mean chatter?"), "{told}");
    let told = refused(folder.path(), &["chek", "scene.json"]);
    assert!(told.contains("check"), "{told}");
}

#[test]
fn list_is_a_table_and_not_a_paragraph_a_scene() {
    let text = printed(Path::new("."), &["list"]);
    let line = |start: &str| {
        let line = text.lines().find(|line| line.trim_start().starts_with(start));
        line.unwrap_or_else(|| panic!("no {start} in {text}"))
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
    };
    assert_eq!(line("cubesat-free "), "cubesat-free free-floating 3U Cubesat captured");
    assert!(line("cubesat-spin-x-1.5 ").ends_with("not captured"));
    assert!(line("cubesat-spin-x-2.0-tube-settled").ends_with("settled"));
    assert!(line("deployment-kevlar").ends_with(" -"));
    assert_eq!(line("kevlar"), "kevlar 130 1440 3600 2.8");
    assert_eq!(line("envisat "), "envisat Envisat, coarse, long axis along y 3");
    // A line a name: what it says of itself is as long as it is, but the prose of sources is not there.
    assert!(!text.contains("Left open by the source"), "{text}");
}

/// A program reads there what the tables show, and every scene by its name.
#[test]
fn list_as_json_has_every_name_of_the_tables() {
    let folder = Path::new(".");
    let listed: Value = serde_json::from_str(&printed(folder, &["list", "--json"])).unwrap();
    let text = printed(folder, &["list"]);
    let mut n_names = 0;
    for (kind, rows) in listed.as_object().unwrap() {
        for row in rows.as_array().unwrap() {
            let name = row["name"].as_str().unwrap();
            assert!(text.lines().any(|line| line.split_whitespace().next() == Some(name)), "{kind} {name}");
            n_names += 1;
        }
    }
    let kinds = listed.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(kinds, ["scenes", "shapes", "materials", "cabins", "studies"]);
    // Heads of one line each but for the materials', which have two; a sentence at the end.
    let n_lines = text.lines().filter(|line| line.starts_with(' ')).count();
    assert_eq!(n_lines, n_names + 6, "{text}");
    assert_eq!(listed["materials"][0]["young_modulus_pa"], 230e9);
    assert_eq!(listed["scenes"].as_array().unwrap().len(), tumblenet::assets::Kind::Scene.names().len());
}

#[test]
fn the_help_says_what_happens_without_a_command_and_what_the_words_mean() {
    let folder = Path::new(".");
    for arguments in [&["--help"][..], &["-h"]] {
        let text = printed(folder, arguments);
        let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains("Without a command the default scene runs"), "{text}");
    }
    let glossary = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/glossary.md")).unwrap();
    let (of_program, of_run) = (printed(folder, &["--help"]), printed(folder, &["run", "--help"]));
    for word in ["enclosed", "mouth", "separation", "quality index", "residual", "trust horizon", "settled"] {
        let line = format!("\n  {word} ");
        assert!(of_program.contains(&line) && of_run.contains(&line), "{word}");
        assert!(glossary.contains(&format!("**{word}**")), "{word} in docs/glossary.md");
    }
}

#[test]
fn a_spin_in_degrees_and_a_turn_as_a_quaternion_are_the_same_scene() {
    let shown = |change: fn(&mut Value)| {
        let folder = with_scene(change);
        serde_json::from_str::<Value>(&printed(folder.path(), &["show", "scene.json", "--json"])).unwrap()
    };
    let radians = shown(|scene| {
        scene["target"]["spin_rad_s"] = json!([0, std::f64::consts::PI / 2.0, 0]);
        scene["target"]["attitude_deg"] = json!([0, 0, 90]);
        scene["effects"] = json!({ "cabin": { "rate_rad_s": [0, std::f64::consts::PI, 0] } });
    });
    let mut degrees = shown(|scene| {
        let target = scene["target"].as_object_mut().unwrap();
        target.remove("spin_rad_s");
        target.insert("spin_deg_s".into(), json!([0, 90, 0]));
        target.insert("attitude_wxyz".into(), json!([0.5f64.sqrt(), 0, 0, 0.5f64.sqrt()]));
        scene["effects"] = json!({ "cabin": { "rate_deg_s": [0, 180, 0] } });
    });
    let turns = &mut degrees["target"]["attitude_deg"];
    assert!((turns[2].as_f64().unwrap() - 90.0).abs() < 1e-12, "{turns}");
    *turns = radians["target"]["attitude_deg"].clone();
    assert_eq!(degrees, radians);
}

#[test]
fn what_is_said_in_two_ways_is_a_fault() {
    let folder = with_scene(|scene| {
        scene["target"]["spin_deg_s"] = json!([1, 0, 0]);
        scene["target"]["attitude_deg"] = json!([1, 0, 0]);
        scene["target"]["attitude_wxyz"] = json!([1, 0, 0, 0]);
        scene["target"]["shape"]["parts"][0]["attitude_wxyz"] = json!([1, 1, 0, 0]);
        scene["launch"]["angle_deg"] = json!(-5);
    });
    let told = refused(folder.path(), &["check", "scene.json"]);
    for words in [
        "target.spin_deg_s: found both spin_rad_s and spin_deg_s; allowed: one of them",
        "target.attitude_wxyz: found both attitude_deg and attitude_wxyz; allowed: one of them",
        "launch.angle_deg: found -5",
    ] {
        assert!(told.contains(words), "{words} in {told}");
    }
    // A length is no matter of the schema.
    write_scene(folder.path(), |scene| {
        scene["target"]["shape"]["parts"][0]["attitude_wxyz"] = json!([1, 1, 0, 0]);
        scene["launch"]["angle_deg"] = json!(30);
    });
    let told = refused(folder.path(), &["check", "scene.json"]);
    assert!(told.contains("target.shape.parts[0].attitude_wxyz: found [1,1,0,0], of length 1.41"), "{told}");
    // What the command line sets stands in the place of what the scene says.
    let set = ["show", "scene.json", "--json", "--set", "target.shape.parts.0.attitude_wxyz=[1,0,0,0]"];
    let degrees = ["--set", "target.spin_deg_s.0=180"];
    let shown: Value = serde_json::from_str(&printed(folder.path(), &[&set[..], &degrees].concat())).unwrap();
    assert_eq!(shown["target"]["spin_rad_s"][0], json!(std::f64::consts::PI));
}

#[test]
fn shells_complete_and_man_has_a_page() {
    let folder = Path::new(".");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = printed(folder, &["completions", shell]);
        for word in ["tumblenet", "stress", "ensemble"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    let page = printed(folder, &["man"]);
    assert!(page.starts_with(".ie") || page.starts_with(".TH"), "{}", &page[..100]);
    for word in ["tumblenet", "\\-\\-ensemble", "\\-\\-until", "\\-\\-budget", "\\-\\-quiet"] {
        assert!(page.contains(word), "{word}");
    }
}

#[test]
fn quiet_says_nothing_but_what_is_asked_for() {
    let folder = with_scene(|scene| scene["target"]["shape"]["parts"][0]["cuboid"][0] = json!(0.01));
    let loud = tumblenet(folder.path(), &["run", "scene.json"]);
    assert!(err(&loud).contains("warning:") && out(&loud).contains("Results:"), "{}", err(&loud));
    for arguments in [&["run", "scene.json", "--quiet"][..], &["-q", "check", "scene.json"]] {
        let quiet = tumblenet(folder.path(), arguments);
        assert_eq!((quiet.status.code(), out(&quiet), err(&quiet)), (Some(0), String::new(), String::new()));
    }
    let asked = tumblenet(folder.path(), &["run", "scene.json", "--quiet", "--format", "json"]);
    assert!(serde_json::from_slice::<Value>(&asked.stdout).unwrap()["scene_hash"].is_string());
    assert!(refused(folder.path(), &["-q", "check", "nope"]).contains("nope: 1 fault"), "a fault is told");
}

#[test]
fn verbose_says_how_long_each_stage_took() {
    let folder = with_scene(|_| {});
    let output = tumblenet(folder.path(), &["run", "scene.json", "--verbose"]);
    let told = err(&output);
    for stage in ["reading and checking: ", "running: ", "writing: "] {
        let is_timed = |rest: &str| rest.starts_with(|first: char| first.is_ascii_digit());
        assert!(told.lines().any(|line| line.strip_prefix(stage).is_some_and(is_timed)), "{stage} in {told}");
    }
    assert!(told.lines().any(|line| line.starts_with("  of running, ")), "{told}");
    let output = tumblenet(folder.path(), &["run", "scene.json", "--verbose", "--ensemble", "2"]);
    assert!(err(&output).contains("running the members: "), "{}", err(&output));
}

/// Members that run one after another say so: none began before the one before had ended.
#[test]
fn jobs_bounds_the_threads_and_changes_no_result() {
    let folder = with_scene(|_| {});
    let members = |jobs: &str, out: &str| {
        let arguments =
            ["run", "scene.json", "--ensemble", "3", "--jobs", jobs, "--out", out, "--format", "json"];
        let mut all: Value = serde_json::from_str(&printed(folder.path(), &arguments)).unwrap();
        let scalars = all["scalars"].as_object_mut().unwrap();
        scalars.retain(|name, _| name != "wall_s" && !name.starts_with("time_shares"));
        all
    };
    assert_eq!(members("1", "one"), members("2", "two"));
    assert!(refused(folder.path(), &["run", "scene.json", "--jobs", "0"]).contains("1..=1024"));
}

#[test]
fn long_work_without_a_terminal_says_now_and_then_how_far_it_is() {
    let folder = with_scene(|scene| scene["duration_s"] = json!(3.0));
    let run = |every: &str, more: &[&str]| {
        let arguments = [&["run", "scene.json", "--ensemble", "4", "--out", every], more].concat();
        let output = command(folder.path(), &arguments).env("TUMBLENET_PROGRESS", every).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        err(&output)
    };
    let told = run("0.01s", &[]);
    let is_line =
        |line: &str| line.starts_with("scene: ") && line.contains(" %, ") && line.contains(" s so far");
    assert!(told.lines().any(is_line), "{told}");
    assert!(!told.contains('\u{1b}') && !told.contains('\r'), "{told:?}");
    assert!(!run("0.02s", &["--quiet"]).contains("so far"));
    assert!(!run("1000s", &[]).contains("so far"));
}

#[test]
fn nothing_that_is_printed_has_a_colour() {
    let folder = with_scene(|_| {});
    for arguments in
        [&["--help"][..], &["list"], &["run", "scene.json"], &["show", "scene.json"], &["check", "nope"]]
    {
        let output =
            command(folder.path(), arguments).env("NO_COLOR", "1").env("TERM", "xterm-256color").output();
        let output = output.unwrap();
        let text = [output.stdout, output.stderr].concat();
        assert!(!text.contains(&0x1b), "{arguments:?}");
        assert!(!String::from_utf8(text).unwrap().contains("\\u001b"), "{arguments:?}");
    }
}

/// Once the heads of blocks were bold, and what makes them bold was written out as text.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_shows_no_codes_and_no_empty_header() {
    let found = Command::new("script").arg("--version").output().ok();
    if common::tool("script", found).is_none() {
        return;
    }
    let folder = with_scene(|_| {});
    let program = env!("CARGO_BIN_EXE_tumblenet");
    let line = format!("stty cols 60; '{program}' run scene.json");
    let output =
        Command::new("script").args(["-qec", &line, "/dev/null"]).current_dir(folder.path()).output();
    let text = String::from_utf8_lossy(&output.unwrap().stdout).replace('\r', "\n");
    assert!(text.contains("deployment") && !text.contains("\\u001b"), "{text}");
    let table: Vec<&str> = text.lines().filter(|line| line.starts_with(['┌', '│', '└', '╞'])).collect();
    assert!(table.len() > 20 && table.iter().all(|line| line.chars().count() <= 60), "{text}");
    assert!(!table[1].trim_matches(['│', ' ']).is_empty(), "{text}");
}

#[test]
fn tables_survive_sixty_columns() {
    let folder = with_scene(|_| {});
    for arguments in [
        &["list"][..],
        &["run", "scene.json"],
        &["run", "scene.json", "--ensemble", "2"],
        &["compare", "scene.json", "--members", "1", "--solvers", "joints+rapier,explicit+impulse"],
        &["stress", "--list"],
        &["show", "scene.json"],
    ] {
        let output = command(folder.path(), arguments).env("COLUMNS", "60").output().unwrap();
        let text = out(&output);
        let words = |line: &str| line.contains("  ") || line.starts_with(['┌', '│', '└', '╞']);
        let long: Vec<&str> = text.lines().filter(|line| words(line) && line.chars().count() > 60).collect();
        assert!(long.is_empty(), "{arguments:?}: {long:#?}");
        assert!(text.lines().count() > 5, "{arguments:?}: {text} {}", err(&output));
    }
}
