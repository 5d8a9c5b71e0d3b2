//! No input makes the program panic, hang or eat the memory: valid scenes, shapes, meshes and
//! arguments, spoilt at random, and bytes of no meaning. What passes the checks takes a few steps.
//!
//! Readers: scene, shape, mesh, profile, the arguments `--set` and `--vary`, a kept member of an ensemble and of a
//! comparison, a study of costs; the study of a sweep, its plan, and its rows with all that is made of them; measured
//! tracks, a fit to them, and the trajectory of a run. Inputs that once went wrong are kept in `tests/corpus/`, a folder a
//! reader; they are read as they are, and spoilt with the others.
//!
//! A short seeded round runs with the tests. The long one, of a night:
//! `FUZZ=200000 cargo test --release --test fuzz -- --nocapture`; `FUZZ_FROM=N` starts at input N.

#[path = "common/mutate.rs"]
mod mutate;

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use mutate::{noise, pick, spoil, spoil_bytes};
use ndarray::{Array1, Array3};
use ndarray_npy::NpzWriter;
use peak_alloc::PeakAlloc;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use tumblenet::assets::Kind;
use tumblenet::case::Case;
use tumblenet::limits::Limits;
use tumblenet::problems::Problems;
use tumblenet::report::map::MapRequest;
use tumblenet::report::rows::{KeptRows, line};
use tumblenet::report::{dependency, recorded, sensitivity, sweep};
use tumblenet::scene::Source;
use tumblenet::simulation::Simulation;
use tumblenet::study::compare::track;
use tumblenet::study::compare::variants::variants;
use tumblenet::study::experiment::checked::FitStudy;
use tumblenet::study::experiment::tracks::MarkerTracks;
use tumblenet::study::sweep::outcome::MapOutcome;
use tumblenet::study::sweep::{Sweep, SweepPlan};
use tumblenet::study::{cost, ensemble};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Most memory that an input may take [MiB].
const MOST_MEMORY: f32 = 1024.0;

/// Longest that an input may take, in processor time; checked in the long round.
const LONGEST: Duration = Duration::from_secs(2);

/// What the inputs are made of.
struct Stock {
    /// Valid scenes, as written and with every default filled in.
    scenes: Vec<Value>,
    /// Valid shapes.
    shapes: Vec<Value>,
    /// Valid meshes and the endings of their names.
    meshes: Vec<(Vec<u8>, String)>,
    /// Valid studies of sweeps.
    studies: Vec<Value>,
    /// The plan of a sweep, and rows of it.
    plan: SweepPlan,
    rows: Vec<u8>,
    /// A fit, its scene, and the tracks that it is of.
    fit: Value,
    fit_scene: Value,
    tracks: Vec<u8>,
    /// `trajectory.npz` of a run.
    trajectory: Vec<u8>,
    /// The corpus: reader, ending of the name, bytes.
    corpus: Vec<(String, String, Vec<u8>)>,
}

/// All files of `tests/corpus/`, in the order of their names.
fn corpus() -> Vec<(String, String, Vec<u8>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus");
    let mut files = Vec::new();
    for folder in std::fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path()) {
        for file in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let of = |part: Option<&std::ffi::OsStr>| part.unwrap().to_string_lossy().into_owned();
            let (reader, ending) = (of(folder.file_name()), of(file.extension()));
            files.push((file.clone(), (reader, ending, std::fs::read(file).unwrap())));
        }
    }
    files.sort();
    files.into_iter().map(|(_, file)| file).collect()
}

impl Stock {
    fn new() -> Stock {
        let parsed = |text: &str| serde_json::from_str::<Value>(text).unwrap();
        let mut scenes: Vec<Value> =
            Kind::Scene.names().iter().filter_map(|name| Kind::Scene.text(name)).map(parsed).collect();
        for (name, changes) in [
            ("cubesat-spin-x-2.0-tube", vec!["effects.friction.coefficient=0.3"]),
            ("cubesat-free", vec!["solver.cables=explicit", "solver.contact=penalty"]),
            ("stage-spin-x-1.1-tube", vec!["effects.closing.layout=cinch", "solver.flight=explicit"]),
            ("ball-fixed", vec!["solver.contact=impulse", "solver.restitution=0.5", "net.middle_knots=1"]),
        ] {
            let changes: Vec<String> = changes.into_iter().map(str::to_owned).collect();
            let case = Case::load(name, &changes).unwrap_or_else(|problems| panic!("{problems}"));
            scenes.push(serde_json::to_value(case.scene()).unwrap());
        }
        let mut shapes: Vec<Value> =
            Kind::Shape.names().iter().filter_map(|name| Kind::Shape.text(name)).map(parsed).collect();
        let round = json!({ "radius_m": 0.1, "length_m": 0.3 });
        shapes.push(json!({ "parts": [
            { "cuboid": [0.1, 0.2, 0.3], "mass_kg": 1.0, "attitude_deg": [10, 20, 30] },
            { "cylinder": round, "position_m": [0.3, 0, 0] }, { "capsule": round, "position_m": [0, 0, 0.4] },
            { "ball": { "radius_m": 0.1 } },
            { "convex": { "points_m": [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]] } },
            { "mesh": { "file": "mesh.obj", "unit_m": 0.1 }, "position_m": [1, 0, 0] }
        ], "inertia_kg_m2": [[0.5, 0, 0], [0, 0.5, 0], [0, 0, 0.5]] }));
        for shape in &shapes {
            let mut scene = scenes[1].clone();
            scene["target"]["shape"] = shape.clone();
            scenes.push(scene);
        }
        let corpus = corpus();
        let of_corpus = corpus.iter().filter(|file| file.0 == "mesh");
        let of_corpus = of_corpus.map(|(_, ending, bytes)| (bytes.clone(), ending.clone()));
        let meshes = meshes().into_iter().map(|(bytes, ending)| (bytes, ending.to_owned()));
        let (studies, plan) = studies();
        let rows = rows(&plan);
        let fits = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/fits");
        let fit = |name: &str| std::fs::read(fits.join(name)).unwrap();
        Stock {
            scenes,
            shapes,
            meshes: meshes.chain(of_corpus).collect(),
            studies,
            plan,
            rows,
            fit: serde_json::from_slice(&fit("cord.json")).unwrap(),
            fit_scene: serde_json::from_slice(&fit("cord-net.json")).unwrap(),
            tracks: fit("cord.csv"),
            trajectory: trajectory(),
            corpus,
        }
    }
}

/// The studies of the examples, and the plan of one.
fn studies() -> (Vec<Value>, SweepPlan) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/studies");
    let mut files: Vec<_> = std::fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let study = |file: &std::path::PathBuf| serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let planned = files.iter().find(|file| file.ends_with("cubesat-tumble.json")).unwrap();
    let sweep = Sweep::load(&planned.to_string_lossy(), Limits::default());
    let plan = sweep.unwrap_or_else(|problems| panic!("{problems}")).plan("fuzz");
    (files.iter().map(study).collect(), plan)
}

/// Rows of `plan` with a number in every column of numbers.
fn rows(plan: &SweepPlan) -> Vec<u8> {
    let mut text = line(&plan.columns);
    for member in 0..40_u64 {
        let cell = |name: &String| match name.as_str() {
            "member" | "point" => member.to_string(),
            "captured" => (member % 3 == 0).to_string(),
            "verdict" => if member % 3 == 0 { "held_so_far" } else { "lost" }.to_owned(),
            "failure" | "reason" => String::new(),
            _ => (0.25 * (member % 7) as f64).to_string(),
        };
        text.extend(line(&plan.columns.iter().map(cell).collect::<Vec<_>>()));
    }
    text
}

/// All that is made of the rows `text` of `plan`, whatever they are.
fn read_rows(plan: &SweepPlan, text: &[u8], folder: &Path) -> Outcome {
    // What a file is called gives a damaged one away: here each has its own name.
    let name = Sha256::digest(text)[..8].iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let place = folder.join("rows").join(&plan.key);
    std::fs::create_dir_all(&place).unwrap();
    let file = place.join(format!("{name}.csv"));
    std::fs::write(&file, text).unwrap();
    let kept = KeptRows::read(folder, plan);
    drop(sweep::words(&sweep::SweepResult::of(plan, &kept)));
    let over = ["input.target.spin_rad_s.length", "input.target.spin_rad_s.tilt_deg"].map(str::to_owned);
    let request = MapRequest { over: over.into(), outcome: MapOutcome::Captured, n_boxes: 4 };
    outcome(dependency::observed(plan, &kept, &dependency::names(None)), |_| {});
    outcome(sensitivity::find(plan, &kept, MapOutcome::Captured), |_| {});
    let mapped = outcome(request.fill(plan, &kept, None), |_| {});
    std::fs::remove_file(file).unwrap();
    mapped
}

/// A tetrahedron, an L and a rough ball as OBJ, the tetrahedron as both kinds of STL.
fn meshes() -> Vec<(Vec<u8>, &'static str)> {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f32]];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let mut obj = String::from("# tetrahedron\no body\n");
    corners.iter().for_each(|[x, y, z]| obj += &format!("v {x} {y} {z}\n"));
    faces.iter().for_each(|[a, b, c]| obj += &format!("f {}/1/1 {}//2 {}\n", a + 1, b + 1, c + 1));
    let mut text = String::from("solid body\n");
    let mut binary = vec![0; 80];
    binary.extend(4_u32.to_le_bytes());
    for face in faces {
        text += "facet normal 0 0 0\nouter loop\n";
        binary.extend([0; 12]);
        for corner in face {
            let [x, y, z] = corners[corner];
            text += &format!("vertex {x} {y} {z}\n");
            corners[corner].iter().for_each(|x| binary.extend(x.to_le_bytes()));
        }
        text += "endloop\nendfacet\n";
        binary.extend([0; 2]);
    }
    text += "endsolid body\n";

    let outline = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]];
    let mut l_shape = String::new();
    for y in 0..2 {
        outline.iter().for_each(|[x, z]| l_shape += &format!("v {x} {y} {z}\n"));
    }
    l_shape += "f 1 2 3 4 5 6\nf 12 11 10 9 8 7\n";
    for i in 0..6 {
        let next = (i + 1) % 6;
        l_shape += &format!("f {} {} {} {}\n", i + 1, i + 7, next + 7, next + 1);
    }

    let (rows, columns) = (8, 12);
    let mut ball = String::from("v 0 -1 0\nv 0 1 0\n");
    for row in 1..rows {
        for column in 0..columns {
            let (sin, cos) = (std::f32::consts::PI * row as f32 / rows as f32).sin_cos();
            let turn = std::f32::consts::TAU * column as f32 / columns as f32;
            let radius = if (row + column) % 3 == 0 { 0.7 } else { 1.0 };
            let (x, y, z) = (radius * sin * turn.cos(), -radius * cos, radius * sin * turn.sin());
            ball += &format!("v {x} {y} {z}\n");
        }
    }
    let at = |row: usize, column: usize| 3 + (row - 1) * columns + column % columns;
    for column in 0..columns {
        ball += &format!("f 1 {} {}\n", at(1, column), at(1, column + 1));
        ball += &format!("f 2 {} {}\n", at(rows - 1, column + 1), at(rows - 1, column));
        for row in 1..rows - 1 {
            let [a, b, c, d] =
                [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
            ball += &format!("f {a} {b} {c} {d}\n");
        }
    }
    vec![
        (obj.into_bytes(), "obj"),
        (l_shape.into_bytes(), "obj"),
        (ball.into_bytes(), "obj"),
        (text.into_bytes(), "stl"),
        (binary, "stl"),
    ]
}

/// What `residual` and `fit` read of a run: three frames of a net of one mesh.
fn trajectory() -> Vec<u8> {
    let mut npz = NpzWriter::new(Cursor::new(Vec::new()));
    npz.add_array("t", &Array1::from_vec(vec![0.0, 0.1, 0.2])).unwrap();
    let of = |offset: f64| Array3::from_shape_fn([3, 8, 3], |(i, j, k)| offset + (i + 2 * j + 3 * k) as f64);
    npz.add_array("knots", &of(0.0)).unwrap();
    npz.add_array("velocities", &of(0.5)).unwrap();
    npz.add_array("grid", &Array1::from_vec(vec![2_i64, 2])).unwrap();
    npz.finish().unwrap().into_inner()
}

/// What became of an input.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outcome {
    /// Refused in words.
    Refused,
    /// Passed the checks, and took its steps.
    Passed,
}

fn outcome<T>(result: Result<T, Problems>, go_on: impl FnOnce(T)) -> Outcome {
    match result {
        Ok(value) => {
            go_on(value);
            Outcome::Passed
        }
        Err(problems) => {
            assert!(!problems.list.is_empty());
            let told = problems.to_string();
            assert!(told.len() < 1 << 20);
            assert!(!told.contains("the schema lets pass") && !told.contains("False schema"), "{told}");
            Outcome::Refused
        }
    }
}

/// A few steps of what passed the checks, where they are not dear.
fn steps(case: Case) {
    let solver = &case.scene().solver;
    let rounds = u64::from(solver.sweeps_max.max(solver.snap_passes)) * u64::from(case.time_step().substeps);
    // In flight, or where a step makes energy.
    let cut = (case.time_step().step / case.resolving_step()).clamp(1.0, 1e9) as u64;
    let parts = case.target().map_or(0, |target| target.parts.len());
    if rounds.saturating_mul(cut).saturating_mul(case.net().n_knots() as u64) > 1_000_000 || parts > 100 {
        return;
    }
    let mut simulation = Simulation::new(&case);
    for _ in 0..5.min(case.n_steps()) {
        if simulation.step().is_err() {
            break; // told with time and stage
        }
    }
}

/// A file of `bytes` through its reader.
fn read(stock: &Stock, reader: &str, ending: &str, bytes: Vec<u8>, folder: &Path) -> Outcome {
    let name = format!("{reader}.{ending}");
    std::fs::write(folder.join(&name), &bytes).unwrap();
    let with = |pointer: &str, value: Value| {
        let mut json = stock.scenes[1].clone();
        json["effects"] = json!({});
        let (above, key) = pointer.rsplit_once('/').unwrap();
        json.pointer_mut(above).unwrap()[key] = value;
        let folder = Some(folder.to_path_buf());
        Case::build(&Source {
            name: "fuzz".into(),
            input: "fuzz".into(),
            folder,
            json,
            limits: Limits::default(),
        })
    };
    let known = |is_known: bool| if is_known { Outcome::Passed } else { Outcome::Refused };
    match reader {
        "scene" => outcome(Case::load(&folder.join(&name).to_string_lossy(), &[]), steps),
        "shape" => outcome(with("/target/shape", json!(name)), steps),
        "mesh" => outcome(with("/target/shape", json!({ "parts": [{ "mesh": { "file": name } }] })), steps),
        "profile" => outcome(with("/effects/cabin", json!({ "profile": name })), steps),
        "member" => known(
            serde_json::from_slice::<ensemble::Member>(&bytes).is_ok()
                | serde_json::from_slice::<track::TrackMember>(&bytes).is_ok(),
        ),
        "study" => {
            outcome(
                Sweep::load(&folder.join(&name).to_string_lossy(), Limits::default()),
                |sweep| match sweep.member(0) {
                    Ok(case) => steps(case),
                    Err(problems) => assert!(!problems.list.is_empty()),
                },
            )
        }
        "plan" => match serde_json::from_slice::<SweepPlan>(&bytes) {
            Ok(plan) if plan.check().is_ok() => read_rows(&plan, &stock.rows, folder),
            _ => Outcome::Refused,
        },
        "rows" => read_rows(&stock.plan, &bytes, folder),
        "tracks" => {
            let mut problems = Problems::new("fuzz");
            let tracks = MarkerTracks::read(&bytes, &mut problems);
            outcome(problems.into_result(tracks), |_| {})
        }
        "fit" => {
            std::fs::write(folder.join("cord-net.json"), stock.fit_scene.to_string()).unwrap();
            std::fs::write(folder.join("cord.csv"), &stock.tracks).unwrap();
            outcome(FitStudy::load(&folder.join(&name).to_string_lossy(), Limits::default()), |_| {})
        }
        "trajectory" => {
            std::fs::rename(folder.join(&name), folder.join("trajectory.npz")).unwrap();
            outcome(recorded::paths(folder), |_| {})
        }
        "cost" => known(serde_json::from_slice::<cost::Study>(&bytes).is_ok()),
        other => panic!("tests/corpus/{other} has no reader"),
    }
}

/// What once went wrong.
#[test]
fn the_corpus_ends_in_words() {
    let stock = Stock::new();
    let folder = tempfile::tempdir().unwrap();
    for (reader, ending, bytes) in &stock.corpus {
        read(&stock, reader, ending, bytes.clone(), folder.path());
    }
    assert!(stock.corpus.len() > 30);
}

/// Input number `number`: made, read, checked.
fn feed(stock: &Stock, number: u64, folder: &Path) -> Outcome {
    let mut random = ChaCha8Rng::seed_from_u64(number);
    let random = &mut random;
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    let source = |json: Value| Source {
        name: "fuzz".into(),
        input: "fuzz".into(),
        folder: Some(folder.to_path_buf()),
        json,
        limits: Limits::default(),
    };
    let with_shape = |shape: Value| {
        let mut scene = stock.scenes[1].clone();
        scene["target"]["shape"] = shape;
        source(scene)
    };
    let (mesh, ending) = pick(&stock.meshes, random);
    write("mesh.obj", &stock.meshes[0].0);
    write("mesh.stl", &stock.meshes[4].0);
    match random.random_range(0..30) {
        26 => {
            let mut fit = stock.fit.clone();
            spoil(&mut fit, &stock.studies, random);
            read(stock, "fit", "json", fit.to_string().into_bytes(), folder)
        }
        27 | 28 => {
            let mut tracks = stock.tracks.clone();
            spoil_bytes(&mut tracks, random);
            read(stock, "tracks", "csv", tracks, folder)
        }
        29 => {
            let mut trajectory = stock.trajectory.clone();
            spoil_bytes(&mut trajectory, random);
            read(stock, "trajectory", "npz", trajectory, folder)
        }
        22 | 23 => {
            let mut study = pick(&stock.studies, random).clone();
            spoil(&mut study, &stock.studies, random);
            read(stock, "study", "json", study.to_string().into_bytes(), folder)
        }
        24 => {
            let mut plan = serde_json::to_value(&stock.plan).unwrap();
            let donor = [plan.clone()];
            spoil(&mut plan, &donor, random);
            read(stock, "plan", "json", plan.to_string().into_bytes(), folder)
        }
        25 => {
            let mut rows = stock.rows.clone();
            spoil_bytes(&mut rows, random);
            read(stock, "rows", "csv", rows, folder)
        }
        20 | 21 => {
            let (reader, ending, bytes) = pick(&stock.corpus, random);
            let mut bytes = bytes.clone();
            spoil_bytes(&mut bytes, random);
            read(stock, reader, ending, bytes, folder)
        }
        0..=8 => {
            let mut scene = pick(&stock.scenes, random).clone();
            spoil(&mut scene, &stock.scenes, random);
            outcome(Case::build(&source(scene)), steps)
        }
        9..=11 => {
            let mut shape = pick(&stock.shapes, random).clone();
            spoil(&mut shape, &stock.shapes, random);
            outcome(Case::build(&with_shape(shape)), steps)
        }
        12 | 13 => {
            let mut bytes = pick(&stock.shapes, random).to_string().into_bytes();
            spoil_bytes(&mut bytes, random);
            write("shape.json", &bytes);
            outcome(Case::build(&with_shape(json!("shape.json"))), steps)
        }
        14 | 15 => {
            let mut bytes = mesh.clone();
            spoil_bytes(&mut bytes, random);
            write(&format!("mesh.{ending}"), &bytes);
            let file = format!("mesh.{}", if random.random_bool(0.9) { ending } else { "obj" });
            outcome(Case::build(&with_shape(json!({ "parts": [{ "mesh": { "file": file } }] }))), steps)
        }
        16 | 17 => {
            let mut bytes = pick(&stock.scenes, random).to_string().into_bytes();
            if random.random_bool(0.5) {
                spoil_bytes(&mut bytes, random);
            } else {
                bytes = noise(random);
            }
            write("scene.json", &bytes);
            outcome(Case::load(&folder.join("scene.json").to_string_lossy(), &[]), steps)
        }
        18 => {
            let mut change =
                pick(&["solver.step_s=1e-4", "net.meshes.0=3", "target=null"], random).as_bytes().to_vec();
            spoil_bytes(&mut change, random);
            outcome(Case::load("cubesat-free", &[String::from_utf8_lossy(&change).into_owned()]), steps)
        }
        _ => {
            let mut vary = pick(&["solver.substeps=1,2", "target.spin_rad_s=[0,0,1],[1,0,0]"], random)
                .as_bytes()
                .to_vec();
            let mut solvers = b"joints+rapier".to_vec();
            spoil_bytes(if random.random_bool(0.5) { &mut vary } else { &mut solvers }, random);
            let [vary, solvers] = [vary, solvers].map(|bytes| [String::from_utf8_lossy(&bytes).into_owned()]);
            outcome(variants(&source(stock.scenes[1].clone()), Some(&solvers), &vary), |_| {})
        }
    }
}

#[test]
fn spoilt_inputs_end_in_words() {
    let asked = |name: &str| std::env::var(name).ok().map(|value| value.parse::<u64>().unwrap());
    let (long, from) = (asked("FUZZ"), asked("FUZZ_FROM").unwrap_or(0));
    let count = long.unwrap_or(2000);
    let stock = Stock::new();
    let folder = tempfile::tempdir().unwrap();
    let (mut passed, mut faults) = (0, Vec::new());
    let (mut slowest, mut largest) = ((Duration::ZERO, 0), (0.0, 0));
    let started = Instant::now();
    for number in from..from + count {
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage_as_mb();
        // Processor time: a busy machine is no hang.
        let begun = ProcessTime::now();
        let fed = catch_unwind(AssertUnwindSafe(|| feed(&stock, number, folder.path())));
        let (time, memory) = (begun.elapsed(), MEMORY.peak_usage_as_mb() - before);
        match fed {
            Ok(outcome) => passed += u64::from(outcome == Outcome::Passed),
            Err(_) => faults.push(format!("input {number} panics")),
        }
        if long.is_some() && time > LONGEST {
            faults.push(format!("input {number} takes {time:.1?}"));
        }
        if memory > MOST_MEMORY {
            faults.push(format!("input {number} takes {memory} MiB"));
        }
        slowest = slowest.max((time, number));
        if memory > largest.0 {
            largest = (memory, number);
        }
    }
    println!(
        "{count} inputs from {from} in {:.0?}: {passed} passed the checks; slowest {:.2?} (input {}), \
         most memory {:.0} MiB (input {})",
        started.elapsed(),
        slowest.0,
        slowest.1,
        largest.0,
        largest.1
    );
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    // Both sides of the checks are visited.
    assert!(passed > count / 50 && passed < count, "{passed} of {count}");
}
