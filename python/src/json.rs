//! Python's plain data as JSON, and back.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde::Serialize;

/// `value` as JSON; arrays and numbers of numpy as lists and numbers.
pub fn text(value: &Bound<'_, PyAny>) -> PyResult<String> {
    value.py().import("tumblenet._json")?.call_method1("dumps", (value,))?.extract()
}

/// `value` as Python's dicts, lists and numbers.
pub fn object<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(|error| PyValueError::new_err(error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}
