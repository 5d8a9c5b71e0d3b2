//! A run, read back from its folder.

use std::fs::File;
use std::path::Path;

use nalgebra::Vector3;
use ndarray::{Array1, Array3, Dimension, OwnedRepr};
use ndarray_npy::{NpzReader, ReadableElement};

use super::files;
use crate::problems::Problems;
use crate::study::experiment::paths::{KnotNames, KnotPaths};

/// Where a run's knots were, from `trajectory.npz` in its `folder`.
///
/// # Errors
/// Faults of that file.
pub fn paths(folder: &Path) -> Result<KnotPaths, Problems> {
    files::recover(folder);
    let path = folder.join("trajectory.npz");
    let mut problems = Problems::new(path.display().to_string());
    let file = match File::open(&path) {
        Ok(file) if file.metadata().is_ok_and(|told| told.is_file()) => NpzReader::new(file),
        _ => {
            problems.add("", "no such file", "the folder of a run's results");
            return Err(problems);
        }
    };
    let mut npz = match file {
        Ok(npz) => npz,
        Err(error) => {
            problems.add("", error, "what `tumblenet run` wrote");
            return Err(problems);
        }
    };
    let time = array::<f64, ndarray::Ix1>(&mut npz, "t", &mut problems);
    let knots = array::<f64, ndarray::Ix3>(&mut npz, "knots", &mut problems);
    let velocities = array::<f64, ndarray::Ix3>(&mut npz, "velocities", &mut problems);
    let grid = array::<i64, ndarray::Ix1>(&mut npz, "grid", &mut problems);
    let all = (|| Some((time?, knots?, velocities?, grid?)))();
    let paths = all.and_then(|(time, knots, velocities, grid)| {
        check(&time, &knots, &velocities, &grid, &mut problems);
        problems.list.is_empty().then(|| KnotPaths {
            names: KnotNames { grid: [grid[0] as usize, grid[1] as usize], n_knots: knots.shape()[1] },
            time: time.to_vec(),
            position: vectors(&knots),
            velocity: vectors(&velocities),
        })
    });
    problems.into_result(paths)
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
