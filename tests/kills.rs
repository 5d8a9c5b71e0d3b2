//! Programs that are killed at any moment: no file is half, no set is mixed, and what was finished is kept.
//!
//! A short seeded round runs with the tests. The long one: `KILLS=500 cargo test --test suite kills:: -- --nocapture`; of so
//! many kills each of the six commands gets a sixth.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::program::{self, files};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

/// A command, where its results go, and the last file of its set.
struct Killed {
    arguments: &'static [&'static str],
    results: &'static str,
    last: &'static str,
}

const COMMANDS: [Killed; 5] = [
    Killed { arguments: &["run", "scene.json"], results: "results/scene", last: "summary.json" },
    Killed {
        arguments: &["run", "scene.json", "--ensemble", "4"],
        results: "results/scene",
        last: "ensemble.json",
    },
    Killed {
        arguments: &[
            "compare",
            "scene.json",
            "--members",
            "2",
            "--solvers",
            "joints+rapier,explicit+impulse",
        ],
        results: "results/scene/compare",
        last: "compare.json",
    },
    Killed {
        arguments: &["cost", "scene.json", "--budget", "1s"],
        results: "results/scene/cost",
        last: "cost.json",
    },
    Killed {
        arguments: &["stress", "e-0.4", "--pairs", "explicit+impulse"],
        results: "results/stress",
        last: "stress.json",
    },
];

/// How kills went.
#[derive(Default, Debug)]
struct Counts {
    /// Of all.
    kills: usize,
    /// After which the set was not there, or not whole, until the next command looked.
    in_the_switch: usize,
    /// After which there was a set.
    with_set: usize,
    /// After which something was kept that the next run took over.
    kept: usize,
    /// Programs that had ended before.
    too_late: usize,
}

/// The scene: its title says which of the runs it is of, in every file of a set.
fn write_scene(folder: &Path, title: &str) {
    program::write_scene(folder, |scene| {
        scene["title"] = json!(title);
        scene["output"] = json!({ "sample_s": 0.005 });
    });
}

fn name(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

/// Files of a set, and what is kept of single runs.
fn is_of_set(path: &Path, results: &Path) -> bool {
    path.parent() == Some(results) && !name(path).starts_with('.')
}

/// Every file that has its name is whole.
fn all_whole(all: &BTreeMap<PathBuf, Vec<u8>>, what: &str) {
    for (path, bytes) in all.iter().filter(|(path, _)| !name(path).starts_with('.')) {
        let whole = match path.extension().and_then(|ending| ending.to_str()) {
            Some("json") => serde_json::from_slice::<Value>(bytes).is_ok(),
            Some("html") => bytes.trim_ascii_end().ends_with(b"</html>"),
            Some("svg") => bytes.trim_ascii_end().ends_with(b"</svg>"),
            Some("csv" | "md") => bytes.ends_with(b"\n"),
            // The record that ends an archive.
            Some("npz") => bytes.len() > 22 && bytes[bytes.len() - 22..].starts_with(b"PK\x05\x06"),
            other => panic!("{what}: {path:?} of {other:?}"),
        };
        assert!(whole, "{what}: {path:?} is half a file of {} bytes", bytes.len());
    }
}

fn run(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tumblenet"));
    command.args(arguments).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// Kills `command` once at a moment that `random` chooses: any, or soon after files begin to appear.
fn kill(command: &Killed, folder: &Path, whole: Duration, random: &mut ChaCha8Rng, counts: &mut Counts) {
    let mut child = run(folder, command.arguments).spawn().unwrap();
    let results = folder.join(command.results);
    if random.random_bool(0.5) {
        std::thread::sleep(whole.mul_f64(random.random_range(0.0..1.1)));
    } else {
        // Where a set is being written: so many unfinished files are beside it.
        let (until, n_files) = (Instant::now() + whole * 4, random.random_range(1..=6));
        let writes = || {
            let entries = std::fs::read_dir(&results).into_iter().flatten().flatten();
            entries.map(|entry| name(&entry.path())).filter(|name| name.starts_with('.')).count() >= n_files
        };
        while Instant::now() < until && !writes() && child.try_wait().unwrap().is_none() {}
        if random.random_bool(0.5) {
            std::thread::sleep(Duration::from_micros(random.random_range(0..1500)));
        }
    }
    counts.kills += 1;
    counts.too_late += usize::from(child.try_wait().unwrap().is_some());
    child.kill().ok();
    child.wait().unwrap();
}

/// The titles that the files of a set name; more than one is a mixed set.
fn titles(set: &BTreeMap<PathBuf, Vec<u8>>, titles: &[String]) -> Vec<String> {
    let named = |title: &&String| {
        set.values().any(|bytes| bytes.windows(title.len()).any(|window| window == title.as_bytes()))
    };
    titles.iter().filter(named).cloned().collect()
}

/// `n` kills of `command` in one folder, each of another run than the one before.
fn kills(command: &Killed, n: usize, seed: u64) -> Counts {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let results = folder.join(command.results);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut counts = Counts::default();
    let mut all_titles = vec!["take 0 of this".to_owned()];
    write_scene(folder, &all_titles[0]);
    let begun = Instant::now();
    assert!(run(folder, command.arguments).status().unwrap().success(), "{:?}", command.arguments);
    let whole = begun.elapsed();
    for number in 1..=n {
        let what = format!("{:?}, kill {number} of seed {seed}", command.arguments);
        // Every third of the same scene again: what was finished is kept.
        if number % 3 != 0 {
            all_titles.push(format!("take {number} of this"));
            write_scene(folder, &all_titles[all_titles.len() - 1]);
        }
        let before = files(folder);
        kill(command, folder, whole, &mut random, &mut counts);
        let left = files(folder);
        all_whole(&left, &what);
        let is_switching = left.contains_key(&results.join(".switching"));
        counts.in_the_switch += usize::from(is_switching);
        // A set whose last file is there is one set, even before anybody looks.
        let set = |all: &BTreeMap<PathBuf, Vec<u8>>| -> BTreeMap<PathBuf, Vec<u8>> {
            all.iter()
                .filter(|(path, _)| is_of_set(path, &results))
                .map(|(p, b)| (p.clone(), b.clone()))
                .collect()
        };
        let last = results.join(command.last);
        if left.contains_key(&last) && !is_switching {
            assert!(titles(&set(&left), &all_titles).len() <= 1, "{what}: a mixed set");
            counts.with_set += 1;
        }
        // The next that looks there ends what was begun.
        tumblenet::report::files::make_folder(&results).unwrap();
        let settled = files(folder);
        let hidden: Vec<&PathBuf> = settled.keys().filter(|path| name(path).starts_with('.')).collect();
        let beside = hidden.iter().filter(|path| path.parent() == Some(&results)).count();
        assert_eq!(beside, 0, "{what}: {hidden:?}");
        assert!(settled.contains_key(&last), "{what}: a set without its last file");
        assert!(titles(&set(&settled), &all_titles).len() <= 1, "{what}: a mixed set");
        // What was finished before is there still.
        let is_kept = |path: &PathBuf| path.starts_with(&results) && path.parent() != Some(&results);
        for (path, bytes) in before.iter().filter(|(path, _)| is_kept(path) && !name(path).starts_with('.')) {
            assert_eq!(settled.get(path), Some(bytes), "{what}: {path:?} was finished, and is another");
        }
        counts.kept +=
            usize::from(settled.keys().filter(|path| is_kept(path)).any(|path| !before.contains_key(path)));
    }
    // Left alone it ends, over what all the kills left, and nothing unfinished stays.
    assert!(run(folder, command.arguments).status().unwrap().success());
    let end = files(folder);
    all_whole(&end, "at the end");
    let title = all_titles.pop().unwrap();
    let found = serde_json::from_slice::<Value>(&end[&results.join(command.last)]).unwrap();
    if command.arguments[0] != "stress" {
        assert_eq!(found["title"], json!(title));
    }
    let current = |path: &&PathBuf| path.parent() == Some(&results) && name(path).starts_with('.');
    assert_eq!(end.keys().filter(current).count(), 0, "{:?}", end.keys().collect::<Vec<_>>());
    counts
}

#[test]
fn a_kill_at_any_moment_leaves_no_half_file_and_no_mixed_set() {
    for (number, command) in COMMANDS.iter().enumerate() {
        let counts = kills(command, each(), number as u64);
        println!("{}: {counts:?}", command.arguments.join(" "));
    }
}

/// Kills of each command; a sweep is one more.
fn each() -> usize {
    let n: usize = std::env::var("KILLS").map_or(6, |text| text.parse().unwrap());
    n / (COMMANDS.len() + 1)
}

/// Rows are added as members end, so a sweep has no set that is switched: what is finished stays, and the table of
/// all is that of a sweep that nobody killed.
#[test]
fn a_sweep_killed_at_any_moment_loses_no_row() {
    let study = json!({ "title": "killed", "scene": "scene.json", "solver": "explicit+impulse", "members": 2,
        "parameters": [{ "path": "launch.speed_m_s", "uniform": [1.8, 2.2] }],
        "design": { "kind": "random", "points": 15 } });
    let folder = program::folder_with(&[("scene.json", &program::tiny_capture()), ("study.json", &study)]);
    let folder = folder.path();
    let command = Killed {
        arguments: &["sweep", "study.json", "--out", "results/killed", "--jobs", "2"],
        results: "results/killed",
        last: "sweep.json",
    };
    let results = folder.join(command.results);
    let begun = Instant::now();
    program::printed(folder, command.arguments);
    let (whole, table) = (begun.elapsed(), std::fs::read(results.join("table.csv")).unwrap());
    let finished = || {
        let told = program::printed(folder, &["sweep", "status", "results/killed", "--format", "json"]);
        let told: Value = serde_json::from_str(&told).unwrap();
        // Left out where there is none.
        assert_eq!(told.get("damaged"), None);
        told["finished"].as_u64().unwrap()
    };
    let (mut random, mut counts, mut before) = (ChaCha8Rng::seed_from_u64(9), Counts::default(), 0);
    for number in 0..each() {
        // Anew now and then: over what is finished there is little left to kill.
        if number % 6 == 0 {
            std::fs::remove_dir_all(&results).unwrap();
            before = 0;
        }
        kill(&command, folder, whole, &mut random, &mut counts);
        let what = format!("kill {number}");
        all_whole(&files(folder), &what);
        if !results.join("study.json").is_file() {
            continue;
        }
        let after = finished();
        assert!(after >= before, "{what}: {before} rows were finished, {after} are");
        counts.with_set += usize::from(results.join(command.last).is_file());
        counts.kept += usize::from(after > before);
        before = after;
    }
    println!("{}: {counts:?}", command.arguments.join(" "));
    program::printed(folder, command.arguments);
    assert!(std::fs::read(results.join("table.csv")).unwrap() == table);
    let left = files(folder);
    let beside: Vec<&PathBuf> = left.keys().filter(|path| name(path).starts_with('.')).collect();
    assert!(beside.is_empty(), "{beside:?}");
}
