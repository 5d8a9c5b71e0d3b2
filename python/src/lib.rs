//! The native part of the Python package `tumblenet`: the library's public interface as Python's classes and numpy's
//! arrays, and nothing of its own but the thrust of `controls`.
//!
//! | module | subject |
//! |---|---|
//! | `errors`, `json`, `arrays`, `body` | what travels between both languages |
//! | `interrupt` | long work without the interpreter's lock, which Ctrl-C ends |
//! | `scene`, `result` | a checked scene; a finished run |
//! | `controls`, `simulation` | a run under way |
//! | `batch`, `members` | many runs |
//! | `episodes` | many runs under way, for who learns when to close |

mod arrays;
mod batch;
mod body;
mod controls;
mod episodes;
mod errors;
mod interrupt;
mod json;
mod members;
mod result;
mod scene;
mod simulation;

use pyo3::prelude::*;
use tumblenet::assets::Kind;

/// Names of the built-in scenes, sorted.
#[pyfunction]
fn scenes() -> Vec<&'static str> {
    Kind::Scene.names()
}

/// The native part of `tumblenet`.
#[pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::batch::{ensemble, rollout, sweep};
    #[pymodule_export]
    use super::body::Body;
    #[pymodule_export]
    use super::episodes::Episodes;
    #[pymodule_export]
    use super::members::Members;
    #[pymodule_export]
    use super::result::{RunResult, run};
    #[pymodule_export]
    use super::scene::{Scene, unpickled};
    #[pymodule_export]
    use super::scenes;
    #[pymodule_export]
    use super::simulation::Simulation;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
