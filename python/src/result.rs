//! A finished run.

use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::Vector3;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tumblenet::audit::Ledger;
use tumblenet::case::Case;
use tumblenet::failure::Failure;
use tumblenet::metrics::capture::Curves;
use tumblenet::metrics::conservation::CREATED;
use tumblenet::metrics::summary::Summary;
use tumblenet::problems::Problems;
use tumblenet::report::results;
use tumblenet::run::{Recorder, Run};
use tumblenet::simulation::Simulation;
use tumblenet::study::settle;

use crate::body::Body;
use crate::interrupt::{self, Stop};
use crate::scene::Scene;
use crate::{arrays, errors, json};

/// A run and what is made of it.
pub struct Recorded {
    pub case: Case,
    pub run: Run,
    pub curves: Curves,
    pub summary: Summary,
}

impl Recorded {
    /// Runs `case` to its end, or on for `at_most` [s] until its verdict is decided.
    pub fn of(case: Case, at_most: Option<f64>, stop: &Stop) -> Result<Recorded, Failure> {
        let (run, curves) = settle::run(&case, at_most, |_| stop.flow())?;
        Ok(Recorded::with(case, run, curves))
    }

    /// The run of `case` that ends with `simulation` as it is now; `curves` of none or some of its frames.
    pub fn up_to_now(
        case: Case,
        recorder: Recorder,
        simulation: &mut Simulation,
        mut curves: Curves,
    ) -> Recorded {
        let run = recorder.finish(&case, simulation);
        curves.extend(&case, &run.frames);
        Recorded::with(case, run, curves)
    }

    fn with(case: Case, run: Run, curves: Curves) -> Recorded {
        let summary = Summary::of(&case, &run, &curves);
        Recorded { case, run, curves, summary }
    }
}

/// For how long at most a run of `case` goes on until its verdict is decided [s]; nothing: to the scene's end.
pub fn at_most(case: &Case, until_settled: bool, at_most: Option<f64>) -> PyResult<Option<f64>> {
    match (until_settled, at_most) {
        (false, None) => return Ok(None),
        (false, Some(_)) => {
            return Err(errors::argument("at_most", "a time", "with until_settled=True only"));
        }
        (true, Some(time)) if !(time.is_finite() && time > 0.0) => {
            return Err(errors::argument("at_most", time, "a number above 0, in seconds"));
        }
        (true, _) => {}
    }
    let time = at_most.unwrap_or(settle::TIMES * case.scene().duration_s.0);
    let mut problems = Problems::new(case.name());
    settle::check(case, time, "at_most", &mut problems);
    problems.into_result(Some(Some(time))).map_err(errors::scene)
}

/// Runs `scene`, a `Scene` or what one is made of, to its end; other Python threads run meanwhile, and Ctrl-C ends it.
///
/// `until_settled`: runs on beyond the scene's end until the verdict is decided, for `at_most` seconds (left out: ten
/// times the scene's duration).
///
/// Raises `RunError` where the method fails; warns (`RuntimeWarning`) where it made more than 1 % of the energy.
#[pyfunction]
#[pyo3(signature = (scene, *, until_settled=false, at_most=None))]
pub fn run(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    until_settled: bool,
    at_most: Option<f64>,
) -> PyResult<RunResult> {
    let case = Scene::of(scene)?.get().case.clone();
    let at_most = self::at_most(&case, until_settled, at_most)?;
    let recorded = interrupt::beside(py, |stop| Recorded::of(case, at_most, stop))?;
    let recorded = recorded.map_err(|failure| errors::run(&failure))?;
    recorded.summary.clone().sound().map_err(errors::unsound)?;
    if recorded.summary.conservation.is_broken() {
        let created = recorded.summary.conservation.energy_created;
        let text = format!(
            "the method created {created:.1e} of the energy, more than {CREATED}: not to be believed"
        );
        let text = std::ffi::CString::new(text)?;
        PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)?;
    }
    Ok(RunResult::new(py, Arc::new(recorded)))
}

/// A finished run: T frames of K knots and C cables, in the local frame, SI units.
///
/// Arrays are made when they are first asked for, kept, and not to be written to.
#[pyclass(frozen, name = "Result", module = "tumblenet")]
pub struct RunResult {
    recorded: Arc<Recorded>,
    kept: Py<PyDict>,
}

impl RunResult {
    /// `recorded` with nothing made of it yet.
    pub fn new(py: Python<'_>, recorded: Arc<Recorded>) -> RunResult {
        RunResult { recorded, kept: PyDict::new(py).unbind() }
    }

    /// What is kept under `name`, made if it is not there yet.
    fn keep<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        make: impl FnOnce(&Recorded) -> PyResult<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        if let Some(known) = self.kept.bind(py).get_item(name)? {
            return Ok(known);
        }
        let made = make(&self.recorded)?;
        self.kept.bind(py).set_item(name, &made)?;
        Ok(made)
    }

    /// Vectors of every knot in every frame: [T, K, 3].
    fn knots<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        frames: fn(&Run) -> &[Vec<Vector3<f64>>],
    ) -> PyResult<Bound<'py, PyAny>> {
        self.keep(py, name, |recorded| {
            let frames = frames(&recorded.run);
            let shape = [frames.len(), recorded.case.net().n_knots(), 3];
            let numbers = frames.iter().flatten().flat_map(|vector| [vector.x, vector.y, vector.z]);
            arrays::read_only(arrays::shaped(py, numbers.collect(), shape)?)
        })
    }

    /// A dict of curves: [T] each.
    fn dict<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        curves: impl FnOnce(&Recorded) -> Vec<(String, Vec<f64>)>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.keep(py, name, |recorded| {
            let dict = PyDict::new(py);
            for (name, curve) in curves(recorded) {
                dict.set_item(name, arrays::read_only(arrays::numbers(py, curve))?)?;
            }
            Ok(dict.into_any())
        })
    }
}

/// Energies of `ledger` by name [J], those of the effects `names` too.
pub fn energies<'a>(ledger: &Ledger, names: impl Iterator<Item = &'a str>) -> Vec<(String, f64)> {
    let own = ledger.parts().map(|(name, energy)| (name.to_owned(), energy)).into_iter();
    own.chain(names.zip(&ledger.effects).map(|(name, work)| (format!("work_of_{name}"), *work))).collect()
}

#[pymethods]
impl RunResult {
    /// What `summary.json` has, as a dict.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.keep(py, "summary", |recorded| json::object(py, &recorded.summary))
    }

    /// How well energy and momenta were kept: the block `conservation` of the summary.
    #[getter]
    fn audit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.summary(py)?.get_item("conservation")
    }

    /// What to know before the run is believed.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.recorded.summary.warnings.clone()
    }

    /// First 16 digits of a SHA-256 over the last state: the same bits, the same hash.
    #[getter]
    fn state_hash(&self) -> &str {
        &self.recorded.run.state_hash
    }

    /// Whether the target was captured; None without a target.
    #[getter]
    fn captured(&self) -> Option<bool> {
        self.recorded.summary.capture.map(|capture| capture.captured)
    }

    /// The verdict in a word (`held_settled`, `held_so_far`, `lost`, `missed`, `never_met`); None without a target.
    #[getter]
    fn verdict(&self) -> Option<&'static str> {
        self.recorded.summary.capture.map(|capture| capture.verdict.name())
    }

    /// Time of each frame [s]: [T].
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.keep(py, "time", |recorded| {
            arrays::read_only(arrays::numbers(py, recorded.run.frames.time.clone()))
        })
    }

    /// Positions of the knots [m]: [T, K, 3].
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.knots(py, "positions", |run| &run.frames.knots)
    }

    /// Velocities of the knots [m/s]: [T, K, 3].
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.knots(py, "velocities", |run| &run.frames.velocities)
    }

    /// Sum of the contact impulses on each knot since the frame before [N s]: [T, K, 3].
    #[getter]
    fn contact_impulses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.knots(py, "contact_impulses", |run| &run.frames.contact_impulses)
    }

    /// Largest tension of each cable since the frame before [N]: [T, C].
    #[getter]
    fn tensions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.keep(py, "tensions", |recorded| {
            let frames = &recorded.run.frames.tensions;
            let shape = [frames.len(), recorded.case.net().cables.len()];
            arrays::read_only(arrays::shaped(py, frames.concat(), shape)?)
        })
    }

    /// The target in every frame; None without one.
    #[getter]
    fn target<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.keep(py, "target", |recorded| {
            Body::over_time(py, &recorded.run.frames.target)?.into_bound_py_any(py)
        })
    }

    /// The chaser in every frame; None where it is not free.
    #[getter]
    fn chaser<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.keep(py, "chaser", |recorded| {
            let chaser = recorded.run.frames.body("chaser").map_or(&[][..], |track| &track.frames);
            Body::over_time(py, chaser)?.into_bound_py_any(py)
        })
    }

    /// The energy ledger by name [J]: [T] each.
    #[getter]
    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.dict(py, "energy", |recorded| {
            let names = || recorded.run.effects.iter().map(|(name, _)| *name);
            let rows: Vec<_> =
                recorded.run.frames.ledger.iter().map(|ledger| energies(ledger, names())).collect();
            let columns = rows.first().into_iter().flatten().enumerate();
            columns.map(|(i, (name, _))| (name.clone(), rows.iter().map(|row| row[i].1).collect())).collect()
        })
    }

    /// Linear momentum of net, free target and chaser [kg m/s]: [T, 3].
    #[getter]
    fn momentum<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.keep(py, "momentum", |recorded| {
            arrays::read_only(arrays::vectors(py, recorded.run.frames.momentum.iter())?)
        })
    }

    /// Angular momentum of the same about the origin [kg m^2/s]: [T, 3].
    #[getter]
    fn angular_momentum<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.keep(py, "angular_momentum", |recorded| {
            arrays::read_only(arrays::vectors(py, recorded.run.frames.angular_momentum.iter())?)
        })
    }

    /// How well the target is captured, by name: [T] each; empty without a target.
    #[getter]
    fn curves<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.dict(py, "curves", |Recorded { curves, .. }| {
            let inside = curves.cables_inside.iter().map(|&count| count as f64).collect();
            let curves = [
                ("enclosed", curves.enclosed.clone()),
                ("mouth", curves.mouth.clone()),
                ("mouth_hull", curves.mouth_hull.clone()),
                ("gather", curves.gather.clone()),
                ("coverage", curves.coverage.clone()),
                ("separation", curves.separation.clone()),
                ("cqi", curves.cqi.clone()),
                ("relative_energy", curves.relative_energy.clone()),
                ("turns", curves.turns.clone()),
                ("cables_inside", inside),
            ];
            let filled = curves.into_iter().filter(|(_, curve)| !curve.is_empty());
            filled.map(|(name, curve)| (name.to_owned(), curve)).collect()
        })
    }

    /// What effects have to say in every frame (threads, winches, tugs), by the names of the columns of `series.csv`:
    /// [T] each.
    #[getter]
    fn readings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.dict(py, "readings", |Recorded { run, .. }| {
            run.reading_names.iter().map(|name| (name.clone(), run.reading(name))).collect()
        })
    }

    /// The page `replay.html`: the run in motion.
    #[getter]
    fn replay_html(&self, py: Python<'_>) -> String {
        let Recorded { case, run, curves, summary } = &*self.recorded;
        py.detach(|| results::page(case, run, curves, summary))
    }

    /// Writes `summary.json`, `series.csv`, `trajectory.npz` and `replay.html` to `folder`, as the program does.
    ///
    /// Raises `OSError`.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        let Recorded { case, run, curves, summary } = &*self.recorded;
        let write = || {
            results::make_place(&folder)?;
            results::write(&folder, case, run, curves, summary)
        };
        py.detach(write).map_err(|error| errors::write(&error))
    }

    fn __reduce__(&self) -> PyResult<()> {
        let instead =
            "send its scene, which makes the same bits again; or its summary and arrays; or save(folder)";
        Err(errors::not_pickled("Result", instead))
    }

    /// The replay in a notebook.
    fn _repr_html_(&self, py: Python<'_>) -> String {
        let page = self.replay_html(py).replace('&', "&amp;").replace('"', "&quot;");
        format!(r#"<iframe srcdoc="{page}" style="width: 100%; height: 640px; border: 0"></iframe>"#)
    }

    fn __repr__(&self) -> String {
        let Recorded { case, run, .. } = &*self.recorded;
        let verdict = self.verdict().map_or(String::new(), |verdict| format!("verdict={verdict:?}, "));
        format!("Result({:?}, {verdict}state_hash={:?})", case.name(), run.state_hash)
    }
}
