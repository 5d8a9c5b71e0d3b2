//! What became of the members of a batch, with a leading batch dimension.

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::Vector3;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use tumblenet::metrics::summary::Summary;
use tumblenet::metrics::verdict::Capture;
use tumblenet::state::Body;

use crate::result::{Recorded, RunResult};
use crate::{arrays, errors, json};

/// The end of a member.
struct End {
    summary: Summary,
    position: Vec<Vector3<f64>>,
    velocity: Vec<Vector3<f64>>,
    target: Option<Body>,
    /// The whole of it, where frames are kept.
    recorded: Option<Arc<Recorded>>,
}

/// How a member ended, or why it failed.
pub struct Outcome(Result<Box<End>, String>);

impl Outcome {
    /// That of a run, of which all is kept if `frames` are.
    pub fn of(recorded: Result<Arc<Recorded>, String>, frames: bool) -> Outcome {
        Outcome(recorded.map(|recorded| {
            let run = &recorded.run.frames;
            Box::new(End {
                summary: recorded.summary.clone(),
                position: run.knots.last().cloned().unwrap_or_default(),
                velocity: run.velocities.last().cloned().unwrap_or_default(),
                target: run.target.last().copied(),
                recorded: frames.then_some(recorded),
            })
        }))
    }

    /// Its summary, or why it failed.
    pub fn summary(&self) -> Result<&Summary, &str> {
        self.0.as_ref().map(|end| &end.summary).map_err(String::as_str)
    }

    fn end(&self) -> Option<&End> {
        self.0.as_ref().ok().map(Box::as_ref)
    }

    fn capture(&self) -> Option<Capture> {
        self.end()?.summary.capture
    }
}

/// B members that were run, in their order. Where one failed, arrays have NaN and lists have None.
#[pyclass(frozen, name = "Rollout", module = "tumblenet")]
pub struct Members {
    outcomes: Vec<Outcome>,
    /// What each was given, by the name of a column: lists of B values.
    #[pyo3(get)]
    inputs: Py<PyDict>,
}

impl Members {
    /// Those with these outcomes, and what they were given.
    pub fn new(outcomes: Vec<Outcome>, inputs: Bound<'_, PyDict>) -> Members {
        Members { outcomes, inputs: inputs.unbind() }
    }

    fn ends(&self) -> impl ExactSizeIterator<Item = Option<&End>> {
        self.outcomes.iter().map(Outcome::end)
    }

    /// A vector for each member: [B, 3], or of every knot [B, K, 3].
    fn of_knots<'py>(
        &self,
        py: Python<'py>,
        vectors: fn(&End) -> &[Vector3<f64>],
    ) -> PyResult<Bound<'py, PyAny>> {
        let rows: Vec<Option<&[Vector3<f64>]>> = self.ends().map(|end| end.map(vectors)).collect();
        let shape = [rows.len(), one_size(rows.iter().flatten().map(|row| row.len()))?, 3];
        let none = vec![Vector3::repeat(f64::NAN); shape[1]];
        let numbers = rows.iter().flat_map(|row| row.unwrap_or(&none)).flat_map(|v| [v.x, v.y, v.z]);
        arrays::shaped(py, numbers.collect(), shape)
    }

    /// `N` numbers of the target at the end of each member: [B, N].
    fn of_target<'py, const N: usize>(
        &self,
        py: Python<'py>,
        numbers: fn(&Body) -> [f64; N],
    ) -> PyResult<Bound<'py, PyAny>> {
        let row =
            |end: Option<&End>| end.and_then(|end| end.target).map_or([f64::NAN; N], |body| numbers(&body));
        arrays::shaped(py, self.ends().flat_map(row).collect(), [self.outcomes.len(), N])
    }
}

/// The one size of all nets.
fn one_size(mut sizes: impl Iterator<Item = usize>) -> PyResult<usize> {
    let first = sizes.next().unwrap_or(0);
    match sizes.find(|size| *size != first) {
        None => Ok(first),
        Some(other) => Err(errors::argument(
            "members",
            format!("nets of {first} and {other} knots"),
            "one size for one array",
        )),
    }
}

#[pymethods]
impl Members {
    fn __len__(&self) -> usize {
        self.outcomes.len()
    }

    /// Why each member failed; None where it did not.
    #[getter]
    fn failures(&self) -> Vec<Option<&str>> {
        self.outcomes.iter().map(|outcome| outcome.summary().err()).collect()
    }

    /// Whether each captured the target; None without a verdict.
    #[getter]
    fn captured(&self) -> Vec<Option<bool>> {
        self.outcomes.iter().map(|outcome| Some(outcome.capture()?.captured)).collect()
    }

    /// The verdict of each, in a word.
    #[getter]
    fn verdicts(&self) -> Vec<Option<&'static str>> {
        self.outcomes.iter().map(|outcome| Some(outcome.capture()?.verdict.name())).collect()
    }

    /// The reason of each verdict, in a word.
    #[getter]
    fn reasons(&self) -> Vec<Option<&'static str>> {
        self.outcomes.iter().map(|outcome| Some(outcome.capture()?.reason.name())).collect()
    }

    /// First 16 digits of a SHA-256 over the last state of each.
    #[getter]
    fn state_hashes(&self) -> Vec<Option<&str>> {
        self.ends().map(|end| Some(end?.summary.state_hash.as_str())).collect()
    }

    /// What `summary.json` has of each, as dicts.
    #[getter]
    fn summaries<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let of = |end: Option<&End>| end.map(|end| json::object(py, &end.summary)).transpose();
        PyList::new(py, self.ends().map(of).collect::<PyResult<Vec<_>>>()?)
    }

    /// Every number of the summaries that a member has, by name: [B] each. Times of the machine are left out.
    #[getter]
    fn numbers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let scalars = |end: Option<&End>| end.map(|end| end.summary.scalars()).unwrap_or_default();
        let rows: Vec<HashMap<String, f64>> =
            self.ends().map(|end| scalars(end).into_iter().collect()).collect();
        let dict = PyDict::new(py);
        for name in Summary::scalar_names() {
            if !Summary::is_of_machine(&name) && rows.iter().any(|row| row.contains_key(&name)) {
                let column = rows.iter().map(|row| row.get(&name).copied().unwrap_or(f64::NAN));
                dict.set_item(&name, PyArray1::from_vec(py, column.collect()))?;
            }
        }
        Ok(dict)
    }

    /// Positions of the knots at the end [m]: [B, K, 3].
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_knots(py, |end| &end.position)
    }

    /// Velocities of the knots at the end [m/s]: [B, K, 3].
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_knots(py, |end| &end.velocity)
    }

    /// Centre of mass of the target at the end [m]: [B, 3].
    #[getter]
    fn target_positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_target(py, |body| body.position.into())
    }

    /// Attitude of the target at the end, quaternion w, x, y, z, local frame from body frame: [B, 4].
    #[getter]
    fn target_attitudes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_target(py, |body| body.quaternion())
    }

    /// Velocity of the target's centre of mass at the end [m/s]: [B, 3].
    #[getter]
    fn target_velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_target(py, |body| body.velocity.into())
    }

    /// Angular velocity of the target at the end, local frame [rad/s]: [B, 3].
    #[getter]
    fn target_rates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_target(py, |body| body.rate.into())
    }

    /// The whole run of each, where it was called with `frames=True`; else None.
    #[getter]
    fn results(&self, py: Python<'_>) -> Vec<Option<RunResult>> {
        let of = |end: Option<&End>| Some(RunResult::new(py, Arc::clone(end?.recorded.as_ref()?)));
        self.ends().map(of).collect()
    }

    /// A row a member: a dict of columns, arrays of [B]. Inputs, `captured`, `verdict`, `reason`, `failure`, `state_hash`,
    /// then `numbers`.
    fn table<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tumblenet._table")?.call_method1("of_members", (slf,))
    }

    /// The table as a data frame of `library`, `"pandas"` or `"polars"`; left out: of the one that is installed, or the
    /// dict of columns.
    #[pyo3(signature = (library=None))]
    fn frame<'py>(slf: &Bound<'py, Self>, library: Option<&str>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tumblenet._table")?.call_method1("frame", (Self::table(slf)?, library))
    }

    /// An array of `Result` by name (`positions`, `time`, `tensions`) of all members, where frames were kept:
    /// [B, T, ...], with NaN after the last frame of those that ended earlier.
    fn stack<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tumblenet._table")?.call_method1("stack", (slf, name))
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(errors::not_pickled("Rollout", "send its arrays or table(), which are numpy's"))
    }

    fn __repr__(&self) -> String {
        let failed = self.outcomes.iter().filter(|outcome| outcome.end().is_none()).count();
        format!("Rollout({} members, {failed} failed)", self.outcomes.len())
    }
}
