//! Pose and motion of a rigid body.

use pyo3::prelude::*;
use tumblenet::state;

use crate::arrays;

/// Pose and motion of a rigid body: the target, or the chaser. Of a simulation now, of a result in every frame.
#[pyclass(frozen, module = "tumblenet")]
pub struct Body {
    /// Centre of mass [m]: [3], of a result [T, 3].
    #[pyo3(get)]
    position: Py<PyAny>,
    /// Local frame from body frame, quaternion w, x, y, z: [4], of a result [T, 4].
    #[pyo3(get)]
    attitude: Py<PyAny>,
    /// Velocity of the centre of mass [m/s]: [3], of a result [T, 3].
    #[pyo3(get)]
    velocity: Py<PyAny>,
    /// Angular velocity in the local frame [rad/s]: [3], of a result [T, 3].
    #[pyo3(get)]
    rate: Py<PyAny>,
}

#[pymethods]
impl Body {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let Body { position, attitude, velocity, rate } = self;
        let [position, attitude, velocity, rate] = [position, attitude, velocity, rate]
            .map(|array| Ok::<_, PyErr>(array.bind(py).repr()?.to_string()));
        let (position, attitude, velocity, rate) = (position?, attitude?, velocity?, rate?);
        Ok(format!("Body(position={position}, attitude={attitude}, velocity={velocity}, rate={rate})"))
    }
}

impl Body {
    /// `body` now.
    pub fn now(py: Python<'_>, body: &state::Body) -> Body {
        let array = |values: &[f64]| arrays::numbers(py, values.to_vec()).unbind();
        Body {
            position: array(body.position.as_slice()),
            attitude: array(&body.quaternion()),
            velocity: array(body.velocity.as_slice()),
            rate: array(body.rate.as_slice()),
        }
    }

    /// A body in every one of `frames`; nothing where there is none.
    pub fn over_time(py: Python<'_>, frames: &[state::Body]) -> PyResult<Option<Body>> {
        if frames.is_empty() {
            return Ok(None);
        }
        let attitude = arrays::shaped(
            py,
            frames.iter().flat_map(|body| body.quaternion()).collect(),
            [frames.len(), 4],
        )?;
        let kept = |array| PyResult::Ok(arrays::read_only(array)?.unbind());
        Ok(Some(Body {
            position: kept(arrays::vectors(py, frames.iter().map(|body| &body.position))?)?,
            attitude: kept(attitude)?,
            velocity: kept(arrays::vectors(py, frames.iter().map(|body| &body.velocity))?)?,
            rate: kept(arrays::vectors(py, frames.iter().map(|body| &body.rate))?)?,
        }))
    }
}
