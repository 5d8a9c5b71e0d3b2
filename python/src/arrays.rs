//! The program's numbers as numpy's arrays.

use nalgebra::Vector3;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

/// `values` in the shape of `shape`, whose vector the array takes over.
pub fn shaped<'py, const D: usize>(
    py: Python<'py>,
    values: Vec<f64>,
    shape: [usize; D],
) -> PyResult<Bound<'py, PyAny>>
where
    [usize; D]: numpy::ndarray::IntoDimension<Dim: numpy::ndarray::Dimension>,
{
    Ok(PyArray1::from_vec(py, values).reshape(shape)?.into_any())
}

/// A vector of three for each of `values`: [n, 3].
pub fn vectors<'a, 'py>(
    py: Python<'py>,
    values: impl ExactSizeIterator<Item = &'a Vector3<f64>>,
) -> PyResult<Bound<'py, PyAny>> {
    let n = values.len();
    shaped(py, values.flat_map(|vector| [vector.x, vector.y, vector.z]).collect(), [n, 3])
}

/// A number for each of `values`: [n].
pub fn numbers<'py>(py: Python<'py>, values: Vec<f64>) -> Bound<'py, PyAny> {
    PyArray1::from_vec(py, values).into_any()
}

/// A whole number for each of `values`: [n].
pub fn whole<'py>(py: Python<'py>, values: impl Iterator<Item = usize>) -> Bound<'py, PyAny> {
    PyArray1::from_vec(py, values.map(|value| value as i64).collect()).into_any()
}

/// The same, not to be written to.
pub fn read_only<'py>(array: Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    array.call_method1("setflags", (false,))?;
    Ok(array)
}
