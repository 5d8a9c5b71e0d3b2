//! Sweeps: faults of a study, the table, and that nothing but the study is in it: no thread, no shard, no kill.

use std::collections::BTreeSet;
use std::path::Path;

use crate::common::program::{command, folder_with, printed, tiny_capture, tumblenet};
use serde_json::{Value, json};
use tumblenet::limits::Limits;
use tumblenet::study::sweep::Sweep;

/// A study of a tiny net that meets a box within a few steps, in a folder of its own.
fn folder(change: impl FnOnce(&mut Value)) -> tempfile::TempDir {
    let mut study = json!({
        "title": "a small study", "note": "nothing comes of it", "scene": "scene.json",
        "solver": "explicit+impulse",
        "parameters": [
            { "path": "target.spin_rad_s", "direction": { "length": [0, 3] } },
            { "path": "launch.speed_m_s", "normal": { "mean": 2, "sigma": 0.1 } },
            { "path": "effects.friction", "values": [null, { "coefficient": 0.3 }], "labels": ["none", "0.3"] }
        ],
        "design": { "kind": "sobol", "points": 7 },
        "members": 2, "seed": 5
    });
    change(&mut study);
    folder_with(&[("scene.json", &tiny_capture()), ("study.json", &study)])
}

fn table(folder: &Path, out: &str) -> String {
    std::fs::read_to_string(folder.join(out).join("table.csv")).unwrap()
}

/// Files of rows below `out`.
fn files_of_rows(folder: &Path, out: &str) -> Vec<std::path::PathBuf> {
    let keys = std::fs::read_dir(folder.join(out).join("rows")).unwrap().map(|entry| entry.unwrap().path());
    keys.flat_map(|key| std::fs::read_dir(key).unwrap().map(|entry| entry.unwrap().path())).collect()
}

#[test]
fn the_table_has_a_row_for_each_member_whatever_runs_it() {
    let folder = folder(|_| {});
    let folder = folder.path();
    printed(folder, &["sweep", "study.json", "--out", "one", "--jobs", "1"]);
    let whole = table(folder, "one");
    let mut reader = csv::Reader::from_reader(whole.as_bytes());
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    for name in [
        "member",
        "point",
        "input.target.spin_rad_s.tilt_deg",
        "input.launch.speed_m_s",
        "input.effects.friction",
        "verdict",
        "capture.enclosed",
    ] {
        assert!(header.iter().any(|known| known == name), "{name} not in {header:?}");
    }
    let machine =
        |name: &String| name.contains("wall_s") || name.contains("share") || name.contains("provenance");
    assert!(!header.iter().any(machine), "{header:?}");
    let column = |name: &str| header.iter().position(|known| known == name).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let of = |name: &str| rows.iter().map(|row| row[column(name)].to_owned()).collect::<Vec<_>>();
    assert_eq!(of("member"), (0..14).map(|member| member.to_string()).collect::<Vec<_>>());
    assert_eq!(of("point"), (0..14).map(|member| (member / 2).to_string()).collect::<Vec<_>>());
    assert_eq!(
        of("input.effects.friction").into_iter().collect::<BTreeSet<_>>(),
        BTreeSet::from(["0.3".into(), "none".into()])
    );
    assert_eq!(
        of("input.launch.speed_m_s").into_iter().collect::<BTreeSet<_>>().len(),
        7,
        "members of a point share it"
    );
    let numbers = of("capture.separation").into_iter().collect::<BTreeSet<_>>();
    assert_eq!(numbers.len(), 14, "members of a point differ in their fold");
    assert!(!header.contains(&"failure".to_owned()), "nothing failed");

    // Two threads; three shards in another order, one of them twice; again, with nothing left to do.
    printed(folder, &["sweep", "study.json", "--out", "two", "--jobs", "2"]);
    assert!(table(folder, "two") == whole, "one thread and two");
    for shard in ["3/3", "1/3", "3/3", "2/3"] {
        printed(folder, &["sweep", "study.json", "--out", "three", "--shard", shard, "--jobs", "1"]);
    }
    assert_eq!(printed(folder, &["sweep", "missing", "three"]), "\n");
    printed(folder, &["sweep", "merge", "three"]);
    assert!(table(folder, "three") == whole, "one shard and three");
    let before = files_of_rows(folder, "one");
    printed(folder, &["sweep", "study.json", "--out", "one"]);
    assert!(table(folder, "one") == whole && files_of_rows(folder, "one") == before, "run again");
}

#[test]
fn a_member_is_run_alone_with_the_bits_of_its_row() {
    let folder = folder(|study| study["design"]["points"] = json!(2));
    let folder = folder.path();
    printed(folder, &["sweep", "study.json", "--out", "o"]);
    printed(folder, &["sweep", "study.json", "--out", "o", "--member", "3"]);
    let summary = std::fs::read(folder.join("o/member-3/summary.json")).unwrap();
    let summary: Value = serde_json::from_slice(&summary).unwrap();
    let mut reader = csv::Reader::from_reader(std::fs::File::open(folder.join("o/table.csv")).unwrap());
    let column = reader.headers().unwrap().iter().position(|name| name == "capture.separation").unwrap();
    let row = reader.records().nth(3).unwrap().unwrap();
    assert_eq!(row[column].parse::<f64>().unwrap(), summary["capture"]["separation"].as_f64().unwrap());
}

#[test]
fn what_is_missing_damaged_or_twice_is_told_and_mended() {
    let folder = folder(|_| {});
    let folder = folder.path();
    printed(folder, &["sweep", "study.json", "--out", "o", "--shard", "2/7"]);
    assert_eq!(printed(folder, &["sweep", "missing", "o"]), "0,2-7,9-13\n");
    assert_eq!(printed(folder, &["sweep", "missing", "o", "--shards", "7"]), "1,3-7\n");
    assert!(printed(folder, &["sweep", "status", "o"]).contains("2 of 14 members finished"));
    let refused = tumblenet(folder, &["sweep", "merge", "o"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("no rows of members 0,2-7,9-13"));
    printed(folder, &["sweep", "merge", "o", "--partial"]);
    assert_eq!(table(folder, "o").lines().count(), 3);
    printed(folder, &["sweep", "study.json", "--out", "o"]);
    let whole = table(folder, "o");

    // A bit of one file turns.
    let shard =
        files_of_rows(folder, "o").into_iter().min_by_key(|path| std::fs::read(path).unwrap().len()).unwrap();
    let sound = std::fs::read(&shard).unwrap();
    let mut damaged = sound.clone();
    *damaged.last_mut().unwrap() ^= 1;
    std::fs::write(&shard, &damaged).unwrap();
    assert_eq!(printed(folder, &["sweep", "missing", "o"]), "1,8\n");
    let told = tumblenet(folder, &["sweep", "study.json", "--out", "o"]);
    assert!(String::from_utf8_lossy(&told.stderr).contains("is damaged"));
    assert!(table(folder, "o") == whole);

    // Another row of a member, in a file that is whole.
    let text = String::from_utf8(sound).unwrap();
    let other = text.replacen("\n1,", "\n2,", 1);
    use sha2::{Digest, Sha256};
    let name: String = Sha256::digest(&other).iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    std::fs::write(shard.with_file_name(format!("{name}.csv")), other).unwrap();
    let refused = tumblenet(folder, &["sweep", "merge", "o"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("row of member 2"), "{refused:?}");
}

#[test]
fn a_longer_sobol_study_goes_on_from_the_shorter() {
    let folder = folder(|study| study["design"]["points"] = json!(3));
    let folder = folder.path();
    printed(folder, &["sweep", "study.json", "--out", "o"]);
    let short = table(folder, "o");
    let study = std::fs::read_to_string(folder.join("study.json")).unwrap();
    std::fs::write(folder.join("study.json"), study.replace("\"points\":3", "\"points\":5")).unwrap();
    let told = tumblenet(folder, &["sweep", "study.json", "--out", "o", "--shard", "1/1"]);
    assert!(String::from_utf8_lossy(&told.stderr).contains("4 members more"), "{told:?}");
    printed(folder, &["sweep", "merge", "o"]);
    assert!(table(folder, "o").starts_with(&short));
    assert_eq!(table(folder, "o").lines().count(), 11);
}

#[cfg(unix)]
#[test]
fn a_sweep_that_is_killed_or_interrupted_goes_on_where_it_was() {
    use std::process::Stdio;
    use std::time::{Duration, Instant};
    let folder = folder(|study| study["design"]["points"] = json!(30));
    let folder = folder.path();
    let arguments = ["sweep", "study.json", "--out", "o", "--jobs", "1"];
    let n_rows = |at_least: usize| {
        // The most that a slow machine may take; a quick one ends at once.
        let until = Instant::now() + Duration::from_secs(60);
        loop {
            let told = tumblenet(folder, &["sweep", "status", "o", "--format", "json"]);
            let finished =
                serde_json::from_slice::<Value>(&told.stdout).map_or(0, |v| v["finished"].as_u64().unwrap());
            if finished as usize >= at_least || Instant::now() > until {
                break finished as usize;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    let mut before = 0;
    for signal in ["-KILL", "-INT", "-KILL"] {
        let mut child =
            command(folder, &arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        n_rows(before + 1);
        assert!(
            std::process::Command::new("kill")
                .args([signal, &child.id().to_string()])
                .status()
                .unwrap()
                .success()
        );
        child.wait().unwrap();
        let after = n_rows(0);
        assert!(after > before, "{signal}: {before} rows, then {after}");
        before = after;
    }
    printed(folder, &arguments);
    let killed = table(folder, "o");
    printed(folder, &["sweep", "study.json", "--out", "fresh"]);
    assert!(killed == table(folder, "fresh") && killed.lines().count() == 61);
}

/// Of the schedulers only those that are installed are asked for more than a script; `.ci/run` asks a whole Slurm.
#[cfg(unix)]
#[test]
fn a_template_runs_every_shard_whatever_the_paths_are_called() {
    let folder = folder(|_| {});
    let folder = folder.path();
    std::fs::copy(folder.join("study.json"), folder.join("a study's.json")).unwrap();
    for scheduler in ["slurm", "pbs", "hq", "parallel"] {
        let script = printed(
            folder,
            &["sweep", "template", scheduler, "a study's.json", "--out", "my out", "--shards", "3"],
        );
        std::fs::write(folder.join("sweep.sh"), &script).unwrap();
        let bash = |arguments: &[&str], shard: &str| {
            let program = Path::new(env!("CARGO_BIN_EXE_tumblenet")).parent().unwrap().display().to_string();
            let path = format!("{program}:{}", std::env::var("PATH").unwrap());
            let mut bash = std::process::Command::new("bash");
            bash.args(arguments).current_dir(folder).env("PATH", path).env("PBS_O_WORKDIR", folder);
            for name in ["SLURM_ARRAY_TASK_ID", "PBS_ARRAY_INDEX", "HQ_TASK_ID"] {
                bash.env(name, shard);
            }
            bash.output().unwrap()
        };
        assert!(!script.contains("{{"), "{script}");
        let has_parallel = bash(&["-c", "command -v parallel"], "1").status.success();
        if scheduler == "parallel" && !has_parallel {
            assert!(std::env::var_os("CI").is_none(), "GNU Parallel is not installed");
            println!("skipped: GNU Parallel is not installed");
            assert!(bash(&["-n", "sweep.sh"], "1").status.success());
            continue;
        }
        let shards = if scheduler == "parallel" { &["1"][..] } else { &["1", "2", "3"] };
        for shard in shards {
            let ended = bash(&["sweep.sh"], shard);
            assert!(ended.status.success(), "{scheduler}: {}", String::from_utf8_lossy(&ended.stderr));
        }
        assert_eq!(
            printed(folder, &["sweep", "missing", "my out", "--shards", "3"]).trim(),
            "",
            "{scheduler}"
        );
        std::fs::remove_dir_all(folder.join("my out")).unwrap();
    }
    let refused = tumblenet(folder, &["sweep", "template", "slurm", "a\nb", "--out", "", "--shards", "0"]);
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn a_member_that_cannot_be_run_has_a_row_that_says_why() {
    // Each parameter alone is within what the scene allows; both together the target begins within the net.
    let folder = folder(|study| {
        study["set"] = json!({ "target.offset_m": [0.5, 0.5] });
        study["parameters"] = json!([
            { "path": "target.distance_m", "values": [0.15, 0.02] },
            { "path": "target.offset_m", "values": [[0.5, 0.5], [0, 0]] }
        ]);
        study["design"] = json!({ "kind": "grid" });
        study["members"] = json!(1);
        study["collect"] = json!(["deployment"]);
    });
    let folder = folder.path();
    let told = printed(folder, &["sweep", "study.json", "--out", "o"]);
    assert!(told.contains("1 of them failed"), "{told}");
    let table = table(folder, "o");
    let last = table.lines().last().unwrap();
    assert!(
        last.starts_with("3,3,5,0.02,\"[0,0]\",,,,") && last.contains("inside part 0 of the target"),
        "{table}"
    );
}

#[test]
fn every_fault_of_a_study_is_told_at_once() {
    let folder = folder(|study| {
        study["parameters"][0]["direction"]["length"] = json!([3, -1]);
        study["parameters"][1]["path"] = json!("launch.sped_m_s");
        study["parameters"][2]["labels"] = json!(["none"]);
        study["collect"] = json!(["captur"]);
        study["perturb_m"] = json!(9);
    });
    let output = tumblenet(folder.path(), &["sweep", "study.json"]);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{told}");
    for fault in [
        "study.json: ",
        "parameters[0].direction.length: found [3, -1]; allowed: the least first",
        "parameters[2].labels: found 1 labels of 2 values",
        "collect[0]: found \"captur\"; allowed: did you mean capture?",
        "perturb_m: found 9 m",
    ] {
        assert!(told.contains(fault), "{fault} not in {told}");
    }
    assert!(!folder.path().join("results").exists(), "nothing is written");
    let folder = self::folder(|study| {
        study["published_outcomes"] =
            json!([{ "source": "Table 1", "at": { "input.launch.sped_m_s": 2 }, "captured": true }]);
    });
    let output = tumblenet(folder.path(), &["sweep", "study.json"]);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    let fault = "published_outcomes[0].at: found \"input.launch.sped_m_s\"; allowed: did you mean input.launch.speed_m_s?";
    assert!(output.status.code() == Some(2) && told.contains(fault), "{told}");
    // As whole to the schema as 3, and beyond what a whole number of the program may be.
    let folder = self::folder(|study| study["seed"] = json!(1e19));
    let output = tumblenet(folder.path(), &["sweep", "study.json"]);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("seed: found 1e+19; allowed: ") && !told.contains("schema"), "{told}");
}

#[test]
fn what_the_scene_does_not_allow_at_the_ends_is_told_before_anything_runs() {
    let folder = folder(|study| {
        study["parameters"][1] = json!({ "path": "launch.speed_m_s", "uniform": [-1, 2] });
        study["parameters"].as_array_mut().unwrap().push(json!({ "path": "targt.mass_kg", "values": [1] }));
    });
    let output = tumblenet(folder.path(), &["sweep", "study.json"]);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(
        told.contains("parameters[1].uniform[0]: found -1.0, with which launch.speed_m_s is -1"),
        "{told}"
    );
    assert!(told.contains("parameters[3].values[0]: found 1, with which targt is an unknown key; allowed: did you mean target?"), "{told}");
    for (study, fault) in [
        (json!({ "title": "t" }), "scene: found nothing"),
        (
            json!({ "title": "t", "scene": "nowhere.json", "parameters": [{ "path": "a", "values": [1] }], "design": { "kind": "grid" } }),
            "scene: found \"nowhere.json\"",
        ),
        (
            json!({ "title": "t", "scene": "../x.json", "parameters": [{ "path": "a", "values": [1] }], "design": { "kind": "grid" } }),
            "outside of the scene's folder",
        ),
        (
            json!({ "title": "t", "scene": "cubesat-free", "parameters": [{ "path": "launch.speed_m_s", "values": [1] }], "design": { "kind": "grid" }, "members": 1e9 }),
            "design: found 1000000000 members",
        ),
    ] {
        std::fs::write(folder.path().join("bad.json"), study.to_string()).unwrap();
        let problems = Sweep::load(folder.path().join("bad.json").to_str().unwrap(), Limits::default())
            .err()
            .unwrap()
            .to_string();
        assert!(problems.contains(fault), "{fault} not in {problems}");
    }
}

#[test]
fn a_map_says_what_the_rows_say_and_refuses_what_is_no_number() {
    let folder = folder(|study| {
        study["parameters"] = json!([{ "path": "launch.speed_m_s", "uniform": [0.5, 4] },
            { "path": "effects.friction", "values": [null, { "coefficient": 0.1 }], "labels": ["none", "some"] }]);
        study["design"] = json!({ "kind": "random", "points": 24 });
        study["members"] = json!(1);
    });
    let folder = folder.path();
    printed(folder, &["sweep", "study.json", "--out", "o"]);
    let map: Value = serde_json::from_str(&printed(
        folder,
        &["map", "o", "--over", "input.launch.speed_m_s", "--format", "json"],
    ))
    .unwrap();
    let table = table(folder, "o");
    let captured = table.lines().skip(1).filter(|line| line.split(',').nth(5) == Some("true")).count();
    assert_eq!(map["captured"]["captured"], json!(captured));
    assert_eq!(map["captured"]["of"], json!(24));
    let boxes = map["boxes"].as_array().unwrap();
    assert_eq!(boxes.iter().map(|one| one["captured"]["of"].as_u64().unwrap()).sum::<u64>(), 24);
    for name in ["map.html", "map.svg", "map.json"] {
        assert!(folder.join("o").join(name).exists(), "{name}");
    }
    printed(folder, &["map", "o", "--over", "input.launch.speed_m_s,deployment.max_area_m2", "--out", "two"]);
    assert!(folder.join("two/map.svg").exists());
    let four = "input.launch.speed_m_s,deployment.max_area_m2,capture.mouth,capture.cqi";
    printed(folder, &["map", "o", "--over", four, "--out", "four"]);
    let svg = std::fs::read_to_string(folder.join("four/map.svg")).unwrap();
    assert!(svg.contains("capture.mouth") && svg.contains("capture.cqi"), "slices are named");
    assert!(!svg.contains("NaN"));
    for (over, fault) in [
        ("input.launch.speed", "did you mean input.launch.speed_m_s?"),
        ("input.effects.friction", "allowed: a column of numbers"),
        ("point,seed,member,point,seed", "one to 4 columns"),
    ] {
        let refused = tumblenet(folder, &["map", "o", "--over", over]);
        let told = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{told}");
        assert!(told.contains(fault), "{fault} not in {told}");
    }
    assert_eq!(tumblenet(folder, &["map", "nowhere", "--over", "point"]).status.code(), Some(2));
}

/// The members that it asks for follow from the answers alone: begun anew, or in a folder where others have run, it is the same
/// map; it asks for few of many.
#[test]
fn a_map_that_is_refined_asks_for_the_same_members_whatever_has_run() {
    let folder = folder(|study| {
        study["parameters"] = json!([{ "path": "launch.speed_m_s", "uniform": [0.5, 4] }]);
        study["design"] = json!({ "kind": "sobol", "points": 96 });
        study["members"] = json!(1);
        study["published_outcomes"] = json!([
            { "source": "Table 1", "at": { "input.launch.speed_m_s": 2 }, "captured": true }]);
    });
    let folder = folder.path();
    let refine = |out: &str, study: &str| -> Value {
        let over = ["--over", "input.launch.speed_m_s", "--boxes", "2", "--batch", "4", "--refine", "0.35"];
        let arguments = [&["map", study, "--out", out, "--format", "json"], &over[..]].concat();
        let mut map: Value = serde_json::from_str(&printed(folder, &arguments)).unwrap();
        map.as_object_mut().unwrap().remove("provenance");
        map
    };
    let whole = refine("whole", "study.json");
    let refined = &whole["refined"];
    let asked = refined["members"].as_u64().unwrap();
    assert!((4..96).contains(&asked) && refined["of_members"] == json!(96), "{refined}");
    assert!(refined["widest"].as_f64().unwrap() <= 0.35, "{refined}");
    assert_eq!(refined["rounds"].as_u64().unwrap(), asked.div_ceil(4));
    let [low, high] = [0, 1].map(|end| whole["boxes"][0]["captured"]["interval_95"][end].as_f64().unwrap());
    assert!(high - low <= 0.7 && low >= 0.0 && high <= 1.0);
    assert_eq!(whole["published"][0]["source"], "Table 1");
    let page = std::fs::read_to_string(folder.join("whole/map.html")).unwrap();
    assert!(page.contains("Table 1") && page.contains("whenever one looks"));

    printed(folder, &["sweep", "study.json", "--out", "part", "--shard", "2/9"]);
    assert_eq!(refine("part", "study.json"), whole);
    assert_eq!(refine("part", "study.json"), whole, "again, with nothing to run");

    for (column, boxes, fault) in [
        ("input.launch.speed", "2", "columns of parameters: input.launch.speed_m_s"),
        ("deployment.max_area_m2", "2", "columns of parameters: input.launch.speed_m_s"),
        ("input.launch.speed_m_s", "97", "no more boxes than the study has members: 96"),
    ] {
        let refused =
            tumblenet(folder, &["map", "study.json", "--over", column, "--boxes", boxes, "--refine", "0.2"]);
        assert_eq!(refused.status.code(), Some(2));
        let told = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(told.contains(fault), "{fault} not in {told}");
    }
}

/// What is held at a time is read from when it was held first and lost; who ended before is undecided, and told.
#[test]
fn a_map_of_an_outcome_in_time_leaves_the_undecided_out() {
    let folder = folder(|study| {
        study["parameters"] = json!([{ "path": "launch.speed_m_s", "uniform": [0.5, 4] }]);
        study["design"] = json!({ "kind": "random", "points": 24 });
        study["members"] = json!(1);
    });
    let folder = folder.path();
    printed(folder, &["sweep", "study.json", "--out", "o"]);
    let table = table(folder, "o");
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let header = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let text = |row: &csv::StringRecord, name: &str| {
        header
            .iter()
            .position(|known| known == name)
            .map_or_else(String::new, |column| row[column].to_owned())
    };
    let time = |row: &csv::StringRecord, name: &str| text(row, name).parse::<f64>().ok();
    let map = |outcome: &str| -> Value {
        let arguments =
            ["map", "o", "--over", "input.launch.speed_m_s", "--outcome", outcome, "--format", "json"];
        serde_json::from_str(&printed(folder, &arguments)).unwrap()
    };
    for at in [0.08, 0.1, 0.12] {
        let held = |row: &&csv::StringRecord| {
            time(row, "capture.enclosed_at_s").is_some_and(|from| from <= at)
                && time(row, "capture.first_lost_at_s").is_none_or(|lost| lost > at)
        };
        let found = map(&format!("held@{at}"));
        assert_eq!(found["captured"]["captured"], json!(rows.iter().filter(held).count()), "{at} s");
        assert_eq!((&found["captured"]["of"], &found["undecided"]), (&json!(24), &json!(0)), "{at} s");
        assert_eq!(found["outcome"], json!(format!("held at {at} s")));
    }
    let so_far = rows.iter().filter(|row| text(row, "verdict") == "held_so_far").count();
    let settled = rows.iter().filter(|row| text(row, "verdict") == "held_settled").count();
    let found = map("settled");
    assert_eq!(found["undecided"], json!(so_far));
    assert_eq!(found["captured"]["captured"], json!(settled));
    // Later nobody looked: only a loss, or that it settled, tells.
    let decided = rows.iter().filter(|row| time(row, "capture.first_lost_at_s").is_some()).count() + settled;
    if decided > 0 {
        assert_eq!(map("held@99")["undecided"], json!(24 - decided));
    }
    for (outcome, fault) in [("held", "held@T with a time"), ("lost", "held@T"), ("held@0", "held@T")] {
        let refused =
            tumblenet(folder, &["map", "o", "--over", "input.launch.speed_m_s", "--outcome", outcome]);
        let told = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{told}");
        assert!(told.contains(fault), "{fault} not in {told}");
    }
}

/// The studies of the examples are sound.
#[test]
fn every_study_of_the_examples_is_without_a_fault() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/studies");
    let studies = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let sound = studies.map(|path| {
        Sweep::load(path.to_str().unwrap(), Limits::default()).unwrap_or_else(|problems| panic!("{problems}"))
    });
    assert!(sound.count() >= 2);
}
