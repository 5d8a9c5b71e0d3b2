//! A run under way, step by step.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use nalgebra::Vector3;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use tumblenet::case::Case;
use tumblenet::failure::Failure;
use tumblenet::metrics::capture::Curves;
use tumblenet::run::Recorder;
use tumblenet::simulation;
use tumblenet::state::{Contact, State};
use tumblenet::study::settle;

use crate::body::Body;
use crate::controls::{Thrust, Told};
use crate::interrupt::LOOK;
use crate::result::{Recorded, RunResult, energies};
use crate::scene::Scene;
use crate::{arrays, errors};

/// What effects of a simulation have to say, and which frames of its record were looked at.
pub struct Readings {
    pub columns: Vec<String>,
    seen: usize,
}

impl Readings {
    /// Nothing looked at yet.
    pub fn of(simulation: &mut simulation::Simulation) -> Readings {
        Readings { columns: simulation.columns(), seen: 0 }
    }

    /// The values now. Tensions are the largest since the last look here: a frame of the record is a look as well.
    pub fn now(&mut self, simulation: &mut simulation::Simulation, recorder: Option<&Recorder>) -> Vec<f64> {
        let mut values = simulation.values();
        let frames = recorder.map_or(&[][..], |recorder| &recorder.frames().readings);
        for (i, value) in values.iter_mut().enumerate().filter(|(i, _)| self.columns[*i].ends_with(TENSION)) {
            *value = frames[self.seen..].iter().map(|frame| frame[i]).fold(*value, f64::max);
        }
        self.seen = frames.len();
        values
    }
}

/// How columns end that are the largest since the last look.
pub const TENSION: &str = "_tension_n";

/// A run under way: K knots, C cables, in the local frame, SI units. Arrays are copies of the state as it is now.
///
/// `scene`: a `Scene`, or what one is made of. `thrust`: whether it can be told forces on target and chaser; without,
/// its bits are those of `run`. `record`: keeps frames, for `result`.
#[pyclass(module = "tumblenet")]
pub struct Simulation {
    // For the compiler alone: whoever has `&mut` needs no lock.
    simulation: Mutex<simulation::Simulation>,
    case: Case,
    told: Told,
    thrust: Thrust,
    failed: Option<Failure>,
    recorder: Option<Recorder>,
    readings: Readings,
    /// Names of the effects' columns.
    columns: Vec<Py<PyString>>,
}

impl Simulation {
    fn simulation(&mut self) -> &mut simulation::Simulation {
        self.simulation.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    fn state(&mut self) -> &State {
        &self.simulation().state
    }

    /// `n_steps` steps, or as many as are done before it is time to look for signals; how many.
    fn steps(&mut self, n_steps: u64) -> Result<u64, Failure> {
        if let Some(failed) = &self.failed {
            return Err(failed.clone());
        }
        let began = Instant::now();
        for done in 1..=n_steps {
            if let Err(failure) = self.simulation().step() {
                self.failed = Some(failure.clone());
                return Err(failure);
            }
            if let Some(recorder) = &mut self.recorder {
                recorder
                    .record(&self.case, self.simulation.get_mut().unwrap_or_else(PoisonError::into_inner));
            }
            if began.elapsed() > LOOK {
                return Ok(done);
            }
        }
        Ok(n_steps)
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (scene, *, thrust=false, record=false))]
    fn new(scene: &Bound<'_, PyAny>, thrust: bool, record: bool) -> PyResult<Simulation> {
        let scene = Scene::of(scene)?;
        let case = scene.get().case.clone();
        let (told, thrusters) = (Told::of(&case, thrust), Thrust::default());
        let effects = if thrust { vec![thrusters.effect()] } else { Vec::new() };
        let mut simulation = scene.py().detach(|| simulation::Simulation::with(&case, effects));
        let at_most = settle::TIMES * case.scene().duration_s.0;
        let recorder = record.then(|| Recorder::start(&case, &mut simulation, at_most));
        let readings = Readings::of(&mut simulation);
        let columns =
            readings.columns.iter().map(|name| PyString::intern(scene.py(), name).unbind()).collect();
        Ok(Simulation {
            simulation: Mutex::new(simulation),
            case,
            told,
            thrust: thrusters,
            failed: None,
            recorder,
            readings,
            columns,
        })
    }

    /// Goes on by `dt` seconds, in the whole number of steps that is nearest, and at least one; left out: one step.
    ///
    /// `controls` are told before: `{"winch": {"start": True, "reel_speed_m_s": 0.5, "max_tension_n": 0.5}}`; with
    /// `thrust=True` also `"target"` and `"chaser"`: `{"force_n": [0, 0, 1], "torque_n_m": [0, 0, 0], "frame": "body"}`
    /// at the centre of mass, `"local"` where the frame is left out, `None` for no thrust. They hold until they are told
    /// anew; what is not named stays as it is.
    ///
    /// Other Python threads run meanwhile. Raises `ControlError` with every fault, and nothing is done; `RunError` where
    /// the method fails.
    #[pyo3(signature = (dt=None, controls=None))]
    fn step(&mut self, py: Python<'_>, dt: Option<f64>, controls: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let mut left = match dt {
            None => 1,
            Some(dt) if dt.is_finite() && dt > 0.0 => (dt / self.time_step()).round().max(1.0) as u64,
            Some(dt) => return Err(errors::argument("dt", dt, "a number above 0, in seconds")),
        };
        if let Some(controls) = controls {
            let (told, thrust) = (self.told, self.thrust.clone());
            told.take(controls, &thrust, &mut self.simulation().state)?;
        }
        while left > 0 {
            left -= py.detach(|| self.steps(left)).map_err(|failure| errors::run(&failure))?;
            py.check_signals()?;
        }
        Ok(())
    }

    /// The step of the method [s].
    #[getter]
    fn time_step(&self) -> f64 {
        self.case.time_step().step
    }

    /// Simulated time [s].
    #[getter]
    fn time(&mut self) -> f64 {
        self.state().time
    }

    /// Positions of the knots [m]: [K, 3].
    #[getter]
    fn positions<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::vectors(py, self.state().knots.position.iter())
    }

    /// Velocities of the knots [m/s]: [K, 3].
    #[getter]
    fn velocities<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::vectors(py, self.state().knots.velocity.iter())
    }

    /// Largest tension of each cable within the last step [N]: [C].
    #[getter]
    fn tension<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyAny> {
        arrays::numbers(py, self.state().tension.clone())
    }

    /// The target; None without one.
    #[getter]
    fn target(&mut self, py: Python<'_>) -> Option<Body> {
        self.state().target().map(|body| Body::now(py, body))
    }

    /// The chaser; None where it is not free.
    #[getter]
    fn chaser(&mut self, py: Python<'_>) -> Option<Body> {
        let state = self.state();
        state.find_body("chaser").map(|index| Body::now(py, &state.bodies[index]))
    }

    /// The energy ledger by name [J], as of results.
    #[getter]
    fn energy<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let simulation = self.simulation();
        let dict = PyDict::new(py);
        for (name, energy) in energies(&simulation.audit.ledger, simulation.effect_names().into_iter()) {
            dict.set_item(name, energy)?;
        }
        Ok(dict)
    }

    /// The M contacts of net and target within the last step: `knot` and `part`, int64 [M]; `point` [m], `normal` (from
    /// target to net) and `friction`, the impulse across it on the net [N s], [M, 3]; `gap`, negative where they overlap
    /// [m], and `impulse`, along the normal [N s], [M].
    #[getter]
    fn contacts<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let contacts = &self.state().contacts;
        let vectors = |of: fn(&Contact) -> &Vector3<f64>| arrays::vectors(py, contacts.iter().map(of));
        let numbers = |of: fn(&Contact) -> f64| arrays::numbers(py, contacts.iter().map(of).collect());
        let dict = PyDict::new(py);
        dict.set_item("knot", arrays::whole(py, contacts.iter().map(|contact| contact.knot)))?;
        dict.set_item("part", arrays::whole(py, contacts.iter().map(|contact| contact.part)))?;
        dict.set_item("point", vectors(|contact| &contact.point)?)?;
        dict.set_item("normal", vectors(|contact| &contact.normal)?)?;
        dict.set_item("friction", vectors(|contact| &contact.friction)?)?;
        dict.set_item("gap", numbers(|contact| contact.gap))?;
        dict.set_item("impulse", numbers(|contact| contact.impulse))?;
        Ok(dict)
    }

    /// What effects have to say (threads, winches, tugs), by the names of the columns of `series.csv`; tensions are the
    /// largest since the last look.
    #[getter]
    fn readings<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let simulation = self.simulation.get_mut().unwrap_or_else(PoisonError::into_inner);
        let values = self.readings.now(simulation, self.recorder.as_ref());
        let dict = PyDict::new(py);
        for (name, value) in self.columns.iter().zip(values) {
            dict.set_item(name, value)?;
        }
        Ok(dict)
    }

    /// The run up to now, as `run` returns one: with its frames, verdict and replay. Only with `record=True`.
    ///
    /// Its summary names the scene, and not what the simulation was told. Where `readings` was looked at, tensions of
    /// threads in its frames are the largest since that look.
    fn result(&mut self, py: Python<'_>) -> PyResult<RunResult> {
        let Some(recorder) = self.recorder.clone() else {
            return Err(errors::argument("record", "False", "True where a result is asked for"));
        };
        let (case, simulation) = (self.case.clone(), self.simulation());
        let recorded = py.detach(|| Recorded::up_to_now(case, recorder, simulation, Curves::default()));
        Ok(RunResult::new(py, Arc::new(recorded)))
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(errors::not_pickled("Simulation", "send its scene, and step that"))
    }

    /// First 16 digits of a SHA-256 over the state: the same bits, the same hash.
    #[getter]
    fn state_hash(&mut self) -> String {
        self.state().hash()
    }

    fn __repr__(&mut self) -> String {
        format!("Simulation({:?}, time={})", self.case.name().to_owned(), self.time())
    }
}
