//! Faults and failures as exceptions.

use pyo3::exceptions::{PyOSError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use tumblenet::failure::Failure;
use tumblenet::problems::Problems;
use tumblenet::report::files::WriteError;

pyo3::import_exception!(tumblenet._errors, SceneError);
pyo3::import_exception!(tumblenet._errors, ControlError);
pyo3::import_exception!(tumblenet._errors, RunError);

/// Place, found, allowed, of each fault.
type Faults = Vec<(String, String, String)>;

fn faults(problems: Problems) -> (String, Faults) {
    let list = problems.list.into_iter().map(|problem| (problem.place, problem.found, problem.allowed));
    (problems.input, list.collect())
}

/// Every fault of a scene or a study.
pub fn scene(problems: Problems) -> PyErr {
    SceneError::new_err(faults(problems))
}

/// Every fault of controls.
pub fn controls(problems: Problems) -> PyErr {
    ControlError::new_err(faults(problems))
}

/// A run that failed.
pub fn run(failure: &Failure) -> PyErr {
    RunError::new_err(failure.to_string())
}

/// A run whose results are not to be used, and why.
pub fn unsound(why: String) -> PyErr {
    RunError::new_err(why)
}

/// A file that could not be written.
pub fn write(error: &WriteError) -> PyErr {
    PyOSError::new_err(error.to_string())
}

/// An argument that is none.
pub fn argument(name: &str, found: impl std::fmt::Display, allowed: &str) -> PyErr {
    PyValueError::new_err(format!("{name}: found {found}; allowed: {allowed}"))
}

/// Something that is not pickled, and what to send instead.
pub fn not_pickled(what: &str, instead: &str) -> PyErr {
    PyTypeError::new_err(format!("a {what} is not pickled; {instead}"))
}
