//! The result files of a run: `summary.json`, `series.csv`, `trajectory.npz`, `replay.html`.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

use nalgebra::Vector3;
use ndarray::{Array1, Array2, Array3};
use ndarray_npy::NpzWriter;
use serde_json::{Map, Value};

use super::files::{self, WriteError};
use super::packed;
use super::replay;
use crate::audit::Ledger;
use crate::case::Case;
use crate::geometry::Hull;
use crate::interaction::DrawnThread;
use crate::metrics::capture::Curves;
use crate::metrics::summary::Summary;
use crate::metrics::verdict::{self, Capture, Verdict};
use crate::net::Net;
use crate::run::{BodyTrack, Frames, Run};
use crate::state::Body;
use crate::target::parts::ConvexPart;

/// Names of the result files of a run. A summary, the last, says that the others are there.
const NAMES: [&str; 4] = ["series.csv", "trajectory.npz", "replay.html", "summary.json"];

/// Makes the folder `out` for the result files of a run.
///
/// # Errors
/// It cannot be made, or a folder has the name of a result file.
pub fn make_place(out: &Path) -> Result<(), WriteError> {
    files::make_folder(out)?;
    NAMES.iter().try_for_each(|name| files::is_free(&out.join(name)))
}

/// Writes all result files of `run` to the folder `out`, in place of those of an earlier run.
///
/// # Errors
/// The first file that cannot be written; an earlier run's are then as they were.
pub fn write(
    out: &Path,
    case: &Case,
    run: &Run,
    curves: &Curves,
    summary: &Summary,
) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let mut files = files::Together::begin();
    let [table, arrays, replay, last] = NAMES.map(|name| out.join(name));
    files.write(&table, |file| series(file, run, curves))?;
    files.write(&arrays, |file| {
        let mut patient = Patient::new(file);
        let written = trajectory(&mut patient, case, run);
        patient.first_fault().and(written.map_err(std::io::Error::other))
    })?;
    files.write(&replay, |file| file.write_all(page(case, run, curves, summary).as_bytes()))?;
    files.write(&last, |file| as_json(file, summary))?;
    files.appear()
}

/// A file that after a fault takes everything: the writer of zip files would print a message of its own when it
/// is dropped and cannot end the file.
struct Patient<W> {
    file: W,
    fault: Option<std::io::Error>,
}

impl<W> Patient<W> {
    fn new(file: W) -> Patient<W> {
        Patient { file, fault: None }
    }

    /// What went wrong first.
    fn first_fault(self) -> std::io::Result<()> {
        self.fault.map_or(Ok(()), Err)
    }

    /// `done`, or `instead` once something has gone wrong.
    fn keep<T>(&mut self, done: impl FnOnce(&mut W) -> std::io::Result<T>, instead: T) -> std::io::Result<T> {
        if self.fault.is_none() {
            match done(&mut self.file) {
                Ok(value) => return Ok(value),
                Err(fault) => self.fault = Some(fault),
            }
        }
        Ok(instead)
    }
}

impl<W: Write> Write for Patient<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.keep(|file| file.write(bytes), bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.keep(Write::flush, ())
    }
}

impl<W: std::io::Seek> std::io::Seek for Patient<W> {
    fn seek(&mut self, place: std::io::SeekFrom) -> std::io::Result<u64> {
        self.keep(|file| file.seek(place), 0)
    }
}

/// Writes `value` as JSON.
///
/// # Errors
/// The file cannot be written.
pub fn json(path: &Path, value: &impl serde::Serialize) -> Result<(), WriteError> {
    files::write(path, |file| as_json(file, value))
}

/// The same into a file that is being written.
///
/// # Errors
/// The file cannot be written.
pub fn as_json(mut file: impl Write, value: &impl serde::Serialize) -> std::io::Result<()> {
    serde_json::to_writer_pretty(&mut file, value)?;
    file.write_all(b"\n")
}

/// A row a frame.
fn series(file: impl Write, run: &Run, curves: &Curves) -> Result<(), csv::Error> {
    let frames = &run.frames;
    let mut table = csv::Writer::from_writer(file);
    let has_target = !frames.target.is_empty();
    let mut head = vec!["t_s", "area_m2"];
    if has_target {
        head.extend(["enclosed", "mouth", "separation", "cqi", "cables_inside"]);
        head.extend(["mouth_hull", "gather", "coverage", "relative_energy", "turns"]);
        head.extend(["target_x_m", "target_y_m", "target_z_m"]);
        head.extend(["target_qw", "target_qx", "target_qy", "target_qz"]);
        head.extend(["spin_x_rad_s", "spin_y_rad_s", "spin_z_rad_s"]);
    }
    head.extend(["momentum_x_kg_m_s", "momentum_y_kg_m_s", "momentum_z_kg_m_s"]);
    head.extend(["angular_momentum_x_kg_m2_s", "angular_momentum_y_kg_m2_s", "angular_momentum_z_kg_m2_s"]);
    let mut head: Vec<String> = head.into_iter().map(str::to_owned).collect();
    // The residual stands after the works of effects; what was created is no part of the sum.
    let [parts @ .., _, _] = Ledger::default().parts();
    head.extend(parts.map(|(name, _)| format!("{name}_j")));
    head.extend(run.effects.iter().map(|(name, _)| format!("work_of_{name}_j")));
    head.extend(["residual_j", "max_tension_n", "max_impulse_n_s"].map(str::to_owned));
    head.extend(run.reading_names.iter().cloned());
    table.write_record(&head)?;

    for (i, &time) in frames.time.iter().enumerate() {
        let step = (time / run.step).round() as usize;
        let mut row = vec![time, run.mouth_area[step]];
        if has_target {
            let body = &frames.target[i];
            row.extend([curves.enclosed[i], curves.mouth[i], curves.separation[i], curves.cqi[i]]);
            row.push(curves.cables_inside[i] as f64);
            row.extend([curves.mouth_hull[i], curves.gather[i], curves.coverage[i]]);
            row.extend([curves.relative_energy[i], curves.turns[i]]);
            row.extend(body.position.iter());
            row.extend(body.quaternion());
            row.extend(body.spin().iter());
        }
        row.extend(frames.momentum[i].iter());
        row.extend(frames.angular_momentum[i].iter());
        let ledger = &frames.ledger[i];
        let [parts @ .., _, _] = ledger.parts();
        row.extend(parts.map(|(_, energy)| energy));
        row.extend(&ledger.effects);
        row.extend([ledger.residual(), frames.tension[i], frames.impulse[i]]);
        row.extend(&frames.readings[i]);
        table.write_record(row.iter().map(f64::to_string))?;
    }
    table.flush()?;
    Ok(())
}

/// What `units` says of each array, as JSON.
const UNITS: &str = r#"{"t": "s", "knots": "m", "velocities": "m/s", "tensions": "N, largest since the frame before",
"contact_impulses": "N s, on each knot since the frame before", "cables": "the two knots of each",
"rest_lengths": "m", "breaking_tensions": "N, of each cable", "masses": "kg, of each knot",
"bullets": "the four knots that are bullets", "edge": "knots round the mouth, in order",
"grid": "knots along Y and along Z, numbered row by row, those in the middle of cables after them",
"target_points": "m, body frame", "target_triangles": "three points each, outside of one convex part",
"target_parts": "the part of each triangle", "thread_way": "thread and the knot it passes, in order; -1: outside the net",
"target_position": "m", "target_attitude": "w, x, y, z: local frame from body frame", "target_velocity": "m/s",
"target_rate": "rad/s, local frame",
"thread_port": "m, where threads outside the net end, of those that have such an end",
"threads": "the columns that series.csv has of the threads, by the same names in thread_names"}"#;

/// The same with the bodies that effects brought, whose arrays have the units of the target's.
fn units(frames: &Frames) -> String {
    let mut units: Map<String, Value> = serde_json::from_str(UNITS).unwrap_or_default();
    for BodyTrack { model, .. } in &frames.brought {
        for part in ["position", "attitude", "velocity", "rate", "points", "triangles", "parts"] {
            let unit = units[&format!("target_{part}")].clone();
            units.insert(format!("{}_{part}", model.name), unit);
        }
    }
    Value::Object(units).to_string()
}

/// `t` [T], `knots`, `velocities` and `contact_impulses` [T, K, 3], `tensions` [T, C], `cables` [C, 2], `grid` [2]; of a target
/// and of bodies that effects brought, such as a free chaser, `_position`, `_velocity` and `_rate` [T, 3] and `_attitude` [T, 4]; of threads
/// `threads` [T, N] and `thread_way` [W, 2]. What does not change: `rest_lengths` and `breaking_tensions` [C],
/// `masses` [K], `bullets` [4], `edge` [E], the hulls of all bodies as `_points` [P, 3], `_triangles` [H, 3] and `_parts` [H].
/// `thread_port` [T, 3] is where threads end outside the net. `units` and `thread_names` are text, a byte an entry.
fn trajectory(
    file: impl Write + std::io::Seek,
    case: &Case,
    run: &Run,
) -> Result<(), ndarray_npy::WriteNpzError> {
    let frames = &run.frames;
    let n_frames = frames.time.len();
    let mut npz = NpzWriter::new(file);
    npz.add_array("t", &Array1::from(frames.time.clone()))?;
    npz.add_array("knots", &of_knots(&frames.knots))?;
    npz.add_array("velocities", &of_knots(&frames.velocities))?;
    npz.add_array("contact_impulses", &of_knots(&frames.contact_impulses))?;
    npz.add_array("tensions", &of_numbers(&frames.tensions))?;
    let target = Some(("target", &frames.target)).filter(|(_, bodies)| !bodies.is_empty());
    let brought = frames.brought.iter().map(|track| (track.model.name.as_str(), &track.frames));
    for (name, bodies) in target.into_iter().chain(brought) {
        for part in ["position", "velocity", "rate"] {
            let of = |body: &Body| match part {
                "position" => body.position,
                "velocity" => body.velocity,
                _ => body.rate,
            };
            let vectors = Array2::from_shape_fn((n_frames, 3), |(frame, axis)| of(&bodies[frame])[axis]);
            npz.add_array(format!("{name}_{part}"), &vectors)?;
        }
        let attitude = Array2::from_shape_fn((n_frames, 4), |(frame, part)| bodies[frame].quaternion()[part]);
        npz.add_array(format!("{name}_attitude"), &attitude)?;
    }
    net_as_built(&mut npz, case.net())?;
    if let Some(target) = case.target() {
        hulls(&mut npz, "target", target.parts.iter().map(ConvexPart::hull))?;
    }
    for BodyTrack { model, .. } in &frames.brought {
        hulls(&mut npz, &model.name, std::iter::once(Hull::of(&model.corners())))?;
    }
    let text = |text: &str| Array1::from(text.as_bytes().to_vec());
    if !run.reading_names.is_empty() {
        npz.add_array("threads", &of_numbers(&frames.readings))?;
        npz.add_array("thread_names", &text(&run.reading_names.join(",")))?;
    }
    let knot = |knot: &Option<usize>| knot.map_or(-1, |knot| knot as i64);
    let ways = run.threads().enumerate();
    let ways = ways.flat_map(|(number, thread)| thread.way.iter().map(move |at| [number as i64, knot(at)]));
    let ways: Vec<[i64; 2]> = ways.collect();
    if !ways.is_empty() {
        npz.add_array("thread_way", &rows(&ways))?;
    }
    if let Some(thread) = run.threads().find(|thread| thread.way.contains(&None)) {
        npz.add_array("thread_port", &rows(&ports(thread.port_of, frames)))?;
    }
    npz.add_array("units", &text(&units(frames)))?;
    npz.finish()?;
    Ok(())
}

/// Where threads end outside the net: on the body of that name, or at the middle of the net's container, T [m].
fn ports(port_of: Option<&str>, frames: &Frames) -> Vec<[f64; 3]> {
    let track = port_of.and_then(|name| frames.body(name));
    let at = |frame: usize| track.map(|track| track.frames[frame].to_local(&track.model.port).into());
    (0..frames.time.len()).map(|frame| at(frame).unwrap_or_default()).collect()
}

/// What a net is made of.
fn net_as_built<W: Write + std::io::Seek>(
    npz: &mut NpzWriter<W>,
    net: &Net,
) -> Result<(), ndarray_npy::WriteNpzError> {
    let indices = |indices: &[usize]| Array1::from_iter(indices.iter().map(|&index| index as i64));
    let ends: Vec<[i64; 2]> = net.cables.iter().map(|cable| [cable.a as i64, cable.b as i64]).collect();
    npz.add_array("cables", &rows(&ends))?;
    npz.add_array("rest_lengths", &Array1::from_iter(net.cables.iter().map(|cable| cable.rest_length)))?;
    let breaking = net.cables.iter().map(|cable| cable.breaking_tension);
    npz.add_array("breaking_tensions", &Array1::from_iter(breaking))?;
    npz.add_array("masses", &Array1::from(net.mass.clone()))?;
    npz.add_array("bullets", &indices(&net.bullets))?;
    npz.add_array("edge", &indices(&net.perimeter))?;
    npz.add_array("grid", &indices(&net.grid))
}

/// The outsides of a body's parts.
fn hulls<W: Write + std::io::Seek>(
    npz: &mut NpzWriter<W>,
    body: &str,
    parts: impl Iterator<Item = Option<Hull>>,
) -> Result<(), ndarray_npy::WriteNpzError> {
    let (mut points, mut triangles, mut of_part) = (Vec::new(), Vec::new(), Vec::new());
    for (number, hull) in parts.enumerate().filter_map(|(number, hull)| Some((number, hull?))) {
        let first = points.len() as i64;
        points.extend(hull.vertices.iter().map(|point| [point.x, point.y, point.z]));
        triangles
            .extend(hull.triangles.iter().map(|corners| corners.map(|corner| first + i64::from(corner))));
        of_part.extend(hull.triangles.iter().map(|_| number as i64));
    }
    npz.add_array(format!("{body}_points"), &rows(&points))?;
    npz.add_array(format!("{body}_triangles"), &rows(&triangles))?;
    npz.add_array(format!("{body}_parts"), &Array1::from(of_part))
}

/// A row each.
fn rows<T: Copy, const N: usize>(rows: &[[T; N]]) -> Array2<T> {
    Array2::from_shape_fn((rows.len(), N), |(row, column)| rows[row][column])
}

/// Vectors of every knot in every frame.
fn of_knots(frames: &[Vec<Vector3<f64>>]) -> Array3<f64> {
    let n_knots = frames.first().map_or(0, Vec::len);
    let numbers: Vec<Vec<f64>> = frames.iter().map(|knots| packed::components(knots)).collect();
    Array3::from_shape_vec((frames.len(), n_knots, 3), numbers.concat())
        .expect("as many knots in every frame")
}

/// As many numbers in every frame.
fn of_numbers(frames: &[Vec<f64>]) -> Array2<f64> {
    let n = frames.first().map_or(0, Vec::len);
    Array2::from_shape_vec((frames.len(), n), frames.concat()).expect("as many numbers in every frame")
}

/// The run in motion: `replay.html`.
pub fn page(case: &Case, run: &Run, curves: &Curves, summary: &Summary) -> String {
    let frames = &run.frames;
    let cables: Vec<(usize, usize)> = case.net().cables.iter().map(|cable| (cable.a, cable.b)).collect();
    let rest_lengths: Vec<f64> = case.net().cables.iter().map(|cable| cable.rest_length).collect();
    let positions: Vec<Vector3<f64>> = frames.target.iter().map(|body| body.position).collect();
    let attitudes: Vec<_> = frames.target.iter().map(|body| body.attitude).collect();
    let threads: Vec<replay::ReplayThread> = run.threads().map(|drawn| thread(run, drawn)).collect();
    let breaking: Vec<f64> = case.net().cables.iter().map(|cable| cable.breaking_tension).collect();
    let mut shown = shown_curves(case, run, curves);
    if !threads.is_empty() {
        shown.push(curve("pull of the threads", "", pull(&threads, frames.time.len()), true));
    }
    for (name, unit, column) in run.reports.iter().flat_map(|(_, report)| &report.curves) {
        shown.push(curve(name, unit, run.reading(column), false));
    }
    let starts = run.reports.iter().filter_map(|(_, report)| report.start);
    let starts = starts.filter_map(|(what, time)| Some((time?, what.to_owned())));
    let first_contact = run.extremes.first_contact.map(|time| (time, "first contact".to_owned()));
    let changes = match case.target() {
        Some(_) => verdict::changes(case, &frames.time, curves),
        None => Vec::new(),
    };
    replay::html(&replay::Replay {
        title: &case.scene().title,
        source: case.scene().source.as_deref(),
        warnings: &summary.warnings,
        verdicts: summary.capture.map(|capture| verdicts(&capture, &changes, &frames.time)),
        times: &frames.time,
        knots: &frames.knots,
        cables: &cables,
        rest_lengths: &rest_lengths,
        bullets: case.net().bullets,
        perimeter: &case.net().perimeter,
        target: case.target().map(|target| replay::ReplayTarget {
            parts: target.parts.iter().map(outline).collect(),
            positions: &positions,
            attitudes: &attitudes,
        }),
        blocks: frames.brought.iter().map(block).collect(),
        curves: shown,
        threads,
        loads: Some(replay::ReplayLoads {
            tensions: &frames.tensions,
            breaking: &breaking,
            impulses: &frames.contact_impulses,
        }),
        marks: first_contact
            .into_iter()
            .chain(starts)
            .chain(changes.iter().map(|change| (change.at_s, mark(change.state).to_owned())))
            .collect(),
    })
}

fn curve<'a>(
    name: &'a str,
    unit: &'a str,
    values: impl Into<Cow<'a, [f64]>>,
    along_slider: bool,
) -> replay::Curve<'a> {
    replay::Curve { name, unit, values: values.into(), along_slider }
}

/// What a run without effects shows.
fn shown_curves<'a>(case: &Case, run: &'a Run, curves: &'a Curves) -> Vec<replay::Curve<'a>> {
    let frames = &run.frames;
    let area = |time: &f64| run.mouth_area[(time / run.step).round() as usize];
    let areas: Vec<f64> = frames.time.iter().map(area).collect();
    let mut shown = vec![curve("area of the bullets", "m²", areas, frames.target.is_empty())];
    if case.target().is_some() {
        let rates: Vec<f64> = frames.target.iter().map(|body| body.rate.norm()).collect();
        shown.extend([
            curve("enclosed", "", &curves.enclosed, true),
            curve("mouth", "", &curves.mouth, true),
            curve("gather", "", &curves.gather, true),
            curve("mouth hull", "", &curves.mouth_hull, false),
            curve("coverage", "", &curves.coverage, false),
            curve("separation", "target lengths", &curves.separation, false),
            curve("quality index", "0 is ideal", &curves.cqi, false),
            curve("target's rate", "rad/s", rates, false),
        ]);
    }
    shown.push(curve("largest tension", "N", &frames.tension, false));
    let energies: Vec<f64> = frames.ledger.iter().map(Ledger::mechanical).collect();
    shown.push(curve("mechanical energy", "J", energies, false));
    shown
}

/// The most of any thread's tension over its limit, in each of `n` frames.
fn pull(threads: &[replay::ReplayThread], n: usize) -> Vec<f64> {
    let mut most = vec![0.0_f64; n];
    for thread in threads {
        let over_limit = thread.tension_n.iter().map(|tension| tension / thread.limit_n);
        most.iter_mut().zip(over_limit).for_each(|(most, tension)| *most = most.max(tension));
    }
    most
}

/// The verdict at every time, for the badge.
fn verdicts(
    capture: &Capture,
    changes: &[verdict::Change],
    times: &[f64],
) -> Vec<replay::ReplayVerdict<'static>> {
    let before = replay::ReplayVerdict { from_s: times[0], words: "not held yet", held: None };
    let at = |state: Verdict, from_s| replay::ReplayVerdict {
        from_s,
        words: state.words(),
        held: Some(state.is_held()),
    };
    let never = changes.is_empty().then(|| at(capture.verdict, times[times.len() - 1]));
    let changes = changes.iter().map(|change| at(change.state, change.at_s));
    [before].into_iter().chain(changes).chain(never).collect()
}

/// What a change of the verdict is called along the time slider.
fn mark(state: Verdict) -> &'static str {
    match state {
        Verdict::HeldSoFar => "held",
        Verdict::HeldSettled => "settled",
        Verdict::Lost | Verdict::Missed | Verdict::NeverMet => "lost",
    }
}

/// A thread as the replay shows it.
fn thread(run: &Run, drawn: &DrawnThread) -> replay::ReplayThread {
    let [length_m, off_reels_m, tension_n] = drawn.columns.each_ref().map(|name| run.reading(name));
    replay::ReplayThread {
        start_s: drawn.start,
        limit_n: drawn.limit,
        way: drawn.way.clone(),
        anchor_m: [0.0; 3], // where a chaser that is held stays
        port_of: drawn.port_of,
        stop_m: drawn.stop,
        length_m,
        off_reels_m,
        tension_n,
    }
}

/// A body without a shape as a block, and its port.
fn block(track: &BodyTrack) -> replay::ReplayBlock<'_> {
    let (corners, port) = (track.model.corners(), track.model.port);
    let places = |body: &Body| std::array::from_fn(|i| body.to_local(corners.get(i).unwrap_or(&port)));
    replay::ReplayBlock { name: &track.model.name, places: track.frames.iter().map(places).collect() }
}

/// A part as triangles in the body frame: the hull of its outline.
fn outline(part: &ConvexPart) -> replay::ReplayMesh {
    let Some(hull) = part.hull() else {
        return replay::ReplayMesh { vertices: Vec::new(), triangles: Vec::new() };
    };
    replay::ReplayMesh {
        vertices: hull.vertices.iter().map(|v| [v.x as f32, v.y as f32, v.z as f32]).collect(),
        triangles: hull.triangles,
    }
}
