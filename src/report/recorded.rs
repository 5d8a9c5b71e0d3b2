//! A run, read back from its folder: where its knots were, or all of it.

use std::fs::File;
use std::path::Path;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use ndarray::{Array1, Array2, Array3, Dimension, Ix1, Ix2, Ix3, OwnedRepr};
use ndarray_npy::{NpzReader, ReadableElement};

use super::files;
use crate::limits;
use crate::metrics::summary::Summary;
use crate::problems::Problems;
use crate::study::experiment::paths::{KnotNames, KnotPaths};

/// Most bytes of `summary.json` and of `series.csv`.
const MOST_BYTES: u64 = 1 << 30;

/// A run as its folder has it: T frames of K knots and C cables.
pub struct RecordedRun {
    /// What it has to say in numbers.
    pub summary: Summary,
    /// Its curves.
    pub series: RecordedSeries,
    /// Where its knots were.
    pub paths: KnotPaths,
    /// Sum of the contact impulses on each knot since the frame before [N s], T × K × 3.
    pub contact_impulses: Array3<f64>,
    /// Largest tension of each cable since the frame before [N], T × C.
    pub tensions: Array2<f64>,
    /// Its net.
    pub net: RecordedNet,
    /// Its target, where it has one.
    pub target: Option<RecordedBody>,
    /// Bodies that effects brought, such as a free chaser.
    pub brought: Vec<RecordedBody>,
    /// Where threads end outside the net [m], T; empty where none does.
    pub ports: Vec<Vector3<f64>>,
}

/// What the net of a run is made of.
pub struct RecordedNet {
    /// The two knots of each cable.
    pub cables: Vec<[usize; 2]>,
    /// Rest length of each cable [m].
    pub rest_lengths: Vec<f64>,
    /// Breaking tension of each cable [N].
    pub breaking_tensions: Vec<f64>,
    /// Mass of each knot [kg].
    pub masses: Vec<f64>,
    /// The knots that are bullets.
    pub bullets: Vec<usize>,
    /// Knots round the mouth, in order.
    pub edge: Vec<usize>,
    /// The knots that each closing thread passes, in order; none: outside of the net.
    pub threads: Vec<Vec<Option<usize>>>,
}

/// The target of a run, or a body that an effect brought.
pub struct RecordedBody {
    /// How its arrays begin.
    pub name: String,
    /// Centre of mass [m], T.
    pub position: Vec<Vector3<f64>>,
    /// Local frame from body frame, T.
    pub attitude: Vec<UnitQuaternion<f64>>,
    /// Corners of its hulls, body frame [m].
    pub points: Vec<Vector3<f64>>,
    /// Three of them each, counter-clockwise from outside.
    pub triangles: Vec<[usize; 3]>,
}

/// The columns of `series.csv`, each T long.
pub struct RecordedSeries {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl RecordedSeries {
    /// The column called `name`, where the run has it.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let place = self.names.iter().position(|known| known == name)?;
        Some(&self.columns[place])
    }

    /// Names and columns of all for which `is_meant` is true.
    pub fn columns<'a>(
        &'a self,
        is_meant: impl Fn(&str) -> bool + 'a,
    ) -> impl Iterator<Item = (&'a str, &'a [f64])> {
        let all = self.names.iter().zip(&self.columns);
        all.filter(move |(name, _)| is_meant(name)).map(|(name, column)| (name.as_str(), column.as_slice()))
    }

    fn read(path: &Path, n_frames: usize, problems: &mut Problems) -> Option<RecordedSeries> {
        let mut told = Problems::new("");
        let series =
            read_plain(path, &mut told).and_then(|text| RecordedSeries::parse(&text, n_frames, &mut told));
        problems.add_below("series.csv", told);
        series
    }

    fn parse(text: &[u8], n_frames: usize, problems: &mut Problems) -> Option<RecordedSeries> {
        let mut reader = csv::Reader::from_reader(text);
        let names: Vec<String> = match reader.headers() {
            Ok(names) => names.iter().map(str::to_owned).collect(),
            Err(error) => {
                problems.add("", error, "a table with a heading");
                return None;
            }
        };
        let mut columns = vec![Vec::new(); names.len()];
        for (row, record) in reader.records().enumerate() {
            let numbers: Option<Vec<f64>> =
                record.ok().and_then(|record| record.iter().map(|cell| cell.parse().ok()).collect());
            let Some(numbers) = numbers.filter(|numbers| numbers.len() == names.len()) else {
                problems.add(format!("line {}", row + 2), "no row of numbers", "a number a column");
                return None;
            };
            columns.iter_mut().zip(numbers).for_each(|(column, number)| column.push(number));
        }
        let n_rows = columns.first().map_or(0, Vec::len);
        if n_rows != n_frames {
            problems.add("", format!("{n_rows} rows"), format!("the {n_frames} frames of trajectory.npz"));
            return None;
        }
        Some(RecordedSeries { names, columns })
    }
}

impl RecordedRun {
    /// The run whose results are in `folder`.
    ///
    /// # Errors
    /// Faults of its files.
    pub fn read(folder: &Path) -> Result<RecordedRun, Problems> {
        files::recover(folder);
        let mut problems = Problems::new(folder.display().to_string());
        let summary = summary(&folder.join("summary.json"), &mut problems);
        let mut npz = open(&folder.join("trajectory.npz"), "trajectory.npz", &mut problems);
        let run = npz.as_mut().and_then(|npz| {
            let mut told = Problems::new("");
            let arrays = arrays(npz, &mut told);
            problems.add_below("trajectory.npz", told);
            let Arrays { paths, contact_impulses, tensions, net, target, brought, ports } = arrays?;
            let series = RecordedSeries::read(&folder.join("series.csv"), paths.time.len(), &mut problems)?;
            let summary = summary?;
            Some(RecordedRun {
                summary,
                series,
                paths,
                contact_impulses,
                tensions,
                net,
                target,
                brought,
                ports,
            })
        });
        problems.into_result(run)
    }

    /// Time of the last frame [s].
    pub fn end(&self) -> f64 {
        self.paths.end()
    }
}

fn summary(path: &Path, problems: &mut Problems) -> Option<Summary> {
    let mut told = Problems::new("");
    let summary = read_plain(path, &mut told).and_then(|text| {
        let read = serde_json::from_slice(&text);
        read.map_err(|error| told.add("", error, "the summary of a run by this version of the program")).ok()
    });
    problems.add_below("summary.json", told);
    summary
}

fn read_plain(path: &Path, problems: &mut Problems) -> Option<Vec<u8>> {
    let text = limits::read_file(path, MOST_BYTES);
    text.map_err(|error| problems.add("", error, "a file in the folder of a run's results")).ok()
}

/// Where a run's knots were, from `trajectory.npz` in its `folder`.
///
/// # Errors
/// Faults of that file.
pub fn paths(folder: &Path) -> Result<KnotPaths, Problems> {
    files::recover(folder);
    let path = folder.join("trajectory.npz");
    let mut problems = Problems::new(path.display().to_string());
    let mut npz = open(&path, "", &mut problems);
    let paths = npz.as_mut().and_then(|npz| knot_paths(npz, &mut problems));
    problems.into_result(paths)
}

fn open(path: &Path, place: &str, problems: &mut Problems) -> Option<NpzReader<File>> {
    match File::open(path) {
        Ok(file) if file.metadata().is_ok_and(|told| told.is_file()) => {
            let npz = NpzReader::new(file);
            npz.map_err(|error| problems.add(place, error, "what `tumblenet run` wrote")).ok()
        }
        _ => {
            problems.add(place, "no such file", "the folder of a run's results");
            None
        }
    }
}

fn knot_paths(npz: &mut NpzReader<File>, problems: &mut Problems) -> Option<KnotPaths> {
    let time = array::<f64, Ix1>(npz, "t", problems);
    let knots = array::<f64, Ix3>(npz, "knots", problems);
    let velocities = array::<f64, Ix3>(npz, "velocities", problems);
    let grid = array::<i64, Ix1>(npz, "grid", problems);
    let (time, knots, velocities, grid) = (time?, knots?, velocities?, grid?);
    check(&time, &knots, &velocities, &grid, problems);
    problems.list.is_empty().then(|| KnotPaths {
        names: KnotNames { grid: [grid[0] as usize, grid[1] as usize], n_knots: knots.shape()[1] },
        time: time.to_vec(),
        position: vectors(&knots),
        velocity: vectors(&velocities),
    })
}

/// What `trajectory.npz` brings to a [`RecordedRun`].
struct Arrays {
    paths: KnotPaths,
    contact_impulses: Array3<f64>,
    tensions: Array2<f64>,
    net: RecordedNet,
    target: Option<RecordedBody>,
    brought: Vec<RecordedBody>,
    ports: Vec<Vector3<f64>>,
}

/// All of `trajectory.npz` that says what a run looked like.
fn arrays(npz: &mut NpzReader<File>, problems: &mut Problems) -> Option<Arrays> {
    let paths = knot_paths(npz, problems)?;
    let n_frames = paths.time.len();
    let impulses = array::<f64, Ix3>(npz, "contact_impulses", problems)?;
    let tensions = array::<f64, Ix2>(npz, "tensions", problems)?;
    let net = net(npz, paths.names.n_knots, problems)?;
    let [n_knots, n_cables] = [paths.names.n_knots, net.cables.len()];
    for (name, found, wanted) in [
        ("contact_impulses", impulses.shape(), &[n_frames, n_knots, 3][..]),
        ("tensions", tensions.shape(), &[n_frames, n_cables][..]),
    ] {
        if found != wanted {
            problems.add(name, format!("{found:?}"), format!("{wanted:?}"));
        }
    }
    let names = npz.names().unwrap_or_default();
    let (mut target, mut brought) = (None, Vec::new());
    for name in names.iter().filter_map(|name| name.strip_suffix("_points")) {
        let body = body(npz, name, n_frames, problems)?;
        if name == "target" { target = Some(body) } else { brought.push(body) }
    }
    let mut ports = Vec::new();
    if names.iter().any(|name| name == "thread_port") {
        ports = vectors_of(&table(npz, "thread_port", [Some(n_frames), Some(3)], problems)?);
    }
    let contact_impulses = impulses;
    let arrays = Arrays { paths, contact_impulses, tensions, net, target, brought, ports };
    problems.list.is_empty().then_some(arrays)
}

fn net(npz: &mut NpzReader<File>, n_knots: usize, problems: &mut Problems) -> Option<RecordedNet> {
    let cables = array::<i64, Ix2>(npz, "cables", problems)?;
    let mut numbers = |name: &str| array::<f64, Ix1>(npz, name, problems).map(|array| array.to_vec());
    let (rest_lengths, breaking_tensions) = (numbers("rest_lengths")?, numbers("breaking_tensions")?);
    let masses = numbers("masses")?;
    let bullets = array::<i64, Ix1>(npz, "bullets", problems)?;
    let edge = array::<i64, Ix1>(npz, "edge", problems)?;
    let has_threads = npz.names().is_ok_and(|names| names.iter().any(|name| name == "thread_way"));
    let way = if has_threads { Some(array::<i64, Ix2>(npz, "thread_way", problems)?) } else { None };
    let knot = |index: &i64| usize::try_from(*index).ok().filter(|index| *index < n_knots);
    let cables = match cables.shape() {
        [_, 2] => cables.outer_iter().map(|ends| Some([knot(&ends[0])?, knot(&ends[1])?])).collect(),
        _ => None,
    };
    let knots = |list: &Array1<i64>| list.iter().map(knot).collect::<Option<Vec<usize>>>();
    let net = (|| {
        let cables: Vec<[usize; 2]> = cables?;
        let fit = rest_lengths.len() == cables.len()
            && breaking_tensions.len() == cables.len()
            && masses.len() == n_knots;
        fit.then_some(())?;
        Some(RecordedNet {
            cables,
            rest_lengths,
            breaking_tensions,
            masses,
            bullets: knots(&bullets)?,
            edge: knots(&edge)?,
            threads: way.map_or_else(Vec::new, |way| ways(&way, n_knots)),
        })
    })();
    if net.is_none() {
        problems.add(
            "cables",
            "arrays that do not go together",
            format!("those of a net of {n_knots} knots"),
        );
    }
    net
}

/// The knots that each thread passes, from rows of thread and knot.
fn ways(rows: &Array2<i64>, n_knots: usize) -> Vec<Vec<Option<usize>>> {
    let mut ways: Vec<Vec<Option<usize>>> = Vec::new();
    let mut last = None;
    for row in rows.outer_iter().filter(|row| row.len() == 2) {
        if last != Some(row[0]) {
            ways.push(Vec::new());
            last = Some(row[0]);
        }
        let knot = usize::try_from(row[1]).ok().filter(|knot| *knot < n_knots);
        ways.last_mut().into_iter().for_each(|way| way.push(knot));
    }
    ways
}

/// The body whose arrays begin with `name`.
fn body(
    npz: &mut NpzReader<File>,
    name: &str,
    n_frames: usize,
    problems: &mut Problems,
) -> Option<RecordedBody> {
    let mut table =
        |part: &str, size: [Option<usize>; 2]| table(npz, &format!("{name}_{part}"), size, problems);
    let position = table("position", [Some(n_frames), Some(3)])?;
    let attitude = table("attitude", [Some(n_frames), Some(4)])?;
    let points = table("points", [None, Some(3)])?;
    let triangles = array::<i64, Ix2>(npz, &format!("{name}_triangles"), problems)?;
    let corner = |index: i64| usize::try_from(index).ok().filter(|index| *index < points.nrows());
    let triangles: Option<Vec<[usize; 3]>> = match triangles.ncols() {
        3 => triangles.outer_iter().map(|t| Some([corner(t[0])?, corner(t[1])?, corner(t[2])?])).collect(),
        _ => None,
    };
    let Some(triangles) = triangles else {
        let place = format!("{name}_triangles");
        problems.add(place, "corners that are no points", format!("three points of {name}_points each"));
        return None;
    };
    let turn = |q: ndarray::ArrayView1<f64>| {
        UnitQuaternion::try_new(Quaternion::new(q[0], q[1], q[2], q[3]), 0.5).unwrap_or_default()
    };
    Some(RecordedBody {
        name: name.to_owned(),
        position: vectors_of(&position),
        attitude: attitude.outer_iter().map(turn).collect(),
        points: vectors_of(&points),
        triangles,
    })
}

/// The table called `name`, of so many rows and columns where that is known, and of finite numbers.
fn table(
    npz: &mut NpzReader<File>,
    name: &str,
    size: [Option<usize>; 2],
    problems: &mut Problems,
) -> Option<Array2<f64>> {
    let table = array::<f64, Ix2>(npz, name, problems)?;
    let fits =
        table.shape().iter().zip(size).all(|(found, wanted)| wanted.is_none_or(|wanted| *found == wanted));
    let is_finite = table.iter().all(|number| number.is_finite());
    if !fits || !is_finite {
        problems.add(
            name,
            format!("{:?}", table.shape()),
            format!("rows of {} finite numbers", size[1].unwrap_or(0)),
        );
    }
    (fits && is_finite).then_some(table)
}

/// Rows of three numbers.
fn vectors_of(table: &Array2<f64>) -> Vec<Vector3<f64>> {
    table.outer_iter().map(|row| Vector3::new(row[0], row[1], row[2])).collect()
}

/// The array called `name`.
fn array<T: ReadableElement, D: Dimension>(
    npz: &mut NpzReader<File>,
    name: &str,
    problems: &mut Problems,
) -> Option<ndarray::ArrayBase<OwnedRepr<T>, D, T>> {
    let found = npz.by_name::<OwnedRepr<T>, D>(name);
    found.map_err(|error| problems.add(name, error, "an array of a run by this version of the program")).ok()
}

/// Adds arrays that do not go together, and numbers that are none.
fn check(
    time: &Array1<f64>,
    knots: &Array3<f64>,
    velocities: &Array3<f64>,
    grid: &Array1<i64>,
    problems: &mut Problems,
) {
    let [n_frames, n_knots] = [time.len(), knots.shape()[1]];
    for (name, array) in [("knots", knots), ("velocities", velocities)] {
        if array.shape() != [n_frames, n_knots, 3] {
            problems.add(
                name,
                format!("{:?}", array.shape()),
                format!("{n_frames} frames of {n_knots} knots"),
            );
        }
        if !array.iter().all(|number| number.is_finite()) {
            problems.add(name, "a number that is not finite", "finite numbers");
        }
    }
    let rises = time.iter().zip(time.iter().skip(1)).all(|(one, next)| one < next);
    if n_frames == 0 || !rises || !time.iter().all(|time| time.is_finite()) {
        problems.add("t", format!("{n_frames} times"), "at least one, rising");
    }
    let is_grid = grid.len() == 2
        && grid.iter().all(|&n| n > 0)
        && grid[0].checked_mul(grid[1]).is_some_and(|n| n <= n_knots as i64);
    if !is_grid {
        problems.add(
            "grid",
            format!("{:?}", grid.to_vec()),
            format!("two numbers of knots, of {n_knots} in all"),
        );
    }
}

fn vectors(array: &Array3<f64>) -> Vec<Vec<Vector3<f64>>> {
    let frame = |frame: ndarray::ArrayView2<f64>| {
        frame.outer_iter().map(|knot| Vector3::new(knot[0], knot[1], knot[2])).collect()
    };
    array.outer_iter().map(frame).collect()
}
