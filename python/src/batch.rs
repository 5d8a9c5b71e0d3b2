//! Many runs at once, on as many threads as there are processors, without the interpreter's lock.

use std::sync::Arc;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use rayon::ThreadPool;
use rayon::prelude::*;
use serde_json::Value;
use tumblenet::case::Case;
use tumblenet::json::parse;
use tumblenet::limits::{Limit, Limits};
use tumblenet::problems::Problems;
use tumblenet::study::caught;
use tumblenet::study::ensemble::{self as study, Ensemble, EnsembleRequest, Member};
use tumblenet::study::sweep::{DRAWN, Sweep};

use crate::interrupt::{self, Stop};
use crate::members::{Members, Outcome};
use crate::result::{Recorded, at_most};
use crate::scene::{Scene, limits_of};
use crate::{errors, json};

/// `threads` threads, or as many as there are processors; a pool of its own: that of the process would not outlive a fork.
pub fn pool(threads: Option<usize>) -> PyResult<ThreadPool> {
    if threads == Some(0) {
        return Err(errors::argument(
            "threads",
            0,
            "at least 1, or None for as many as there are processors",
        ));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
    pool.map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// `work` on every number below `n`, in parallel: with any number of threads the same, in the same order.
fn in_parallel<T: Send>(
    py: Python<'_>,
    n: usize,
    threads: Option<usize>,
    work: impl Fn(usize, &Stop) -> T + Sync,
) -> PyResult<Vec<T>> {
    let pool = pool(threads)?;
    interrupt::beside(py, |stop| pool.install(|| (0..n).into_par_iter().map(|i| work(i, stop)).collect()))
}

/// Runs the scene that `case` makes; whatever becomes of it, it has an outcome.
fn outcome(
    case: impl FnOnce() -> Result<Case, Problems>,
    at_most: Option<f64>,
    frames: bool,
    stop: &Stop,
) -> Outcome {
    let run = || {
        if stop.flow().is_break() {
            return Err("interrupted".to_owned());
        }
        let case = case().map_err(|problems| problems.in_a_line())?;
        let recorded = Recorded::of(case, at_most, stop).map_err(|failure| failure.to_string())?;
        recorded.summary.clone().sound()?;
        Ok(recorded)
    };
    Outcome::of(caught(run).map(Arc::new), frames)
}

/// A fault of more members than a study may have.
fn check_count(n: usize, limits: Limits) -> PyResult<()> {
    let mut problems = Problems::new("members");
    if limits.exceeded(Limit::Members, n as f64) {
        problems.add("", n, limits.allowed(Limit::Members));
    }
    problems.into_result(Some(())).map_err(errors::scene)
}

/// See `tumblenet.rollout`: `changes` are those of each member, as `path=value`; `inputs` the same as columns.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "one for each of Python's `rollout`, which hands them on")]
pub fn rollout(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    changes: Vec<Vec<String>>,
    inputs: Bound<'_, PyDict>,
    until_settled: bool,
    at_most_s: Option<f64>,
    threads: Option<usize>,
    frames: bool,
) -> PyResult<Members> {
    let scene = Scene::of(scene)?;
    let scene = scene.get();
    let at_most = at_most(&scene.case, until_settled, at_most_s)?;
    check_count(changes.len(), scene.case.limits())?;
    let outcomes = in_parallel(py, changes.len(), threads, |member, stop| {
        let case = || {
            let mut source = scene.source.clone();
            source.change(&changes[member])?;
            Case::build(&source)
        };
        outcome(case, at_most, frames, stop)
    })?;
    Ok(Members::new(outcomes, inputs))
}

/// See `tumblenet.ensemble`; the members, and `ensemble.json`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "one for each of Python's `ensemble`, which hands them on")]
pub fn ensemble<'py>(
    py: Python<'py>,
    scene: &Bound<'_, PyAny>,
    members: usize,
    perturb_m: f64,
    seed: u64,
    until_settled: bool,
    at_most_s: Option<f64>,
    threads: Option<usize>,
    frames: bool,
) -> PyResult<(Members, Bound<'py, PyAny>)> {
    let scene = Scene::of(scene)?;
    let case = &scene.get().case;
    if !(perturb_m.is_finite() && perturb_m >= 0.0) {
        return Err(errors::argument("perturb_m", perturb_m, "a number of at least 0, in metres"));
    }
    check_count(members, case.limits())?;
    let at_most_s = at_most(case, until_settled, at_most_s)?;
    let request = EnsembleRequest { members, perturb_m, seed, at_most_s };
    request.check(case).map_err(errors::scene)?;
    let outcomes = in_parallel(py, members, threads, |member, stop| {
        outcome(|| study::member(case, &request, member), at_most_s, frames, stop)
    })?;
    let all: Vec<Member> = outcomes
        .iter()
        .enumerate()
        .map(|(member, outcome)| Member {
            member,
            outcome: outcome.summary().cloned().map_err(str::to_owned),
        })
        .collect();
    let ensemble = Ensemble::of(case, &request, &all);
    let inputs = PyDict::new(py);
    for (column, name) in ensemble.drawn.iter().flat_map(|drawn| drawn.columns.iter().enumerate()) {
        let texts: Vec<&str> =
            ensemble.drawn.iter().flat_map(|drawn| &drawn.members).map(|row| row[column].as_str()).collect();
        inputs.set_item(format!("{DRAWN}{name}"), texts)?;
    }
    Ok((Members::new(outcomes, inputs), json::object(py, &ensemble)?))
}

/// See `tumblenet.sweep`; columns and rows, as text. Ctrl-C waits for the members under way.
#[pyfunction]
#[pyo3(signature = (study, threads, limits=None))]
pub fn sweep(
    py: Python<'_>,
    study: &Bound<'_, PyAny>,
    threads: Option<usize>,
    limits: Option<&Bound<'_, PyMapping>>,
) -> PyResult<(Vec<String>, Vec<Vec<String>>)> {
    let limits = limits_of(Limits::default(), limits)?;
    let sweep = if study.cast::<PyMapping>().is_ok() {
        let mut problems = Problems::new("study");
        let written: Option<Value> = parse(&json::text(study)?, "", &mut problems);
        problems.into_result(written).and_then(|study| Sweep::of(&study, "study", limits))
    } else {
        let path: String = py.import("os")?.call_method1("fspath", (study,))?.extract()?;
        Sweep::load(&path, limits)
    };
    let sweep = sweep.map_err(errors::scene)?;
    let rows = in_parallel(py, sweep.n_members() as usize, threads, |member, stop| {
        if stop.flow().is_break() { Vec::new() } else { sweep.run(member as u64).fields }
    })?;
    Ok((sweep.columns(), rows))
}
