//! A scene: found, changed, checked.

use std::collections::BTreeMap;
use std::path::PathBuf;

use numpy::PyArray1;
use numpy::PyArrayMethods;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use tumblenet::case::Case;
use tumblenet::json::parse;
use tumblenet::limits::Limits;
use tumblenet::metrics::warnings;
use tumblenet::problems::Problems;
use tumblenet::scene::Source;

use crate::{arrays, errors, json};

/// A scene that was found, changed and checked.
///
/// `scene`: the name of a built-in scene (`tumblenet.scenes()`), the path of a scene file, a dict as such a file has it
/// (its paths are relative to the working folder), or another `Scene`.
///
/// `changes`: values by path, `{"target.mass_kg": 5, "target.spin_rad_s.0": 2}`; as keywords with `__` for the dot,
/// `target__mass_kg=5`. `None` removes a key. A changed scene expects nothing any more.
///
/// `limits`: how much the scene may ask for, by name, `{"knots": 1e6}`, as `--limit` of the program; what is left out stays
/// as it is. `allow_outside`: it may name files outside of its folder.
///
/// Raises `SceneError` with every fault at once.
#[pyclass(frozen, module = "tumblenet")]
pub struct Scene {
    pub source: Source,
    pub case: Case,
}

impl Scene {
    /// The scene of `source`, checked.
    fn build(py: Python<'_>, source: Source) -> PyResult<Scene> {
        let case = py.detach(|| Case::build(&source)).map_err(errors::scene)?;
        Ok(Scene { source, case })
    }

    /// `scene` itself, or the scene that is made of it without changes.
    pub fn of<'py>(scene: &Bound<'py, PyAny>) -> PyResult<Bound<'py, Scene>> {
        match scene.cast::<Scene>() {
            Ok(scene) => Ok(scene.clone()),
            Err(_) => Bound::new(scene.py(), Scene::new(scene, None, None, false, None)?),
        }
    }
}

/// `changes` as `path=value`, the values as JSON.
pub fn changes_of(changes: &Bound<'_, PyMapping>, is_keyword: bool) -> PyResult<Vec<String>> {
    let mut list = Vec::new();
    for item in changes.items()?.iter() {
        let (path, value): (String, Bound<'_, PyAny>) = item.extract()?;
        let path = if is_keyword { path.replace("__", ".") } else { path };
        list.push(format!("{path}={}", json::text(&value)?));
    }
    Ok(list)
}

/// `limits` with the changes of a dict, `{"knots": 1e6}`.
pub fn limits_of(mut limits: Limits, changes: Option<&Bound<'_, PyMapping>>) -> PyResult<Limits> {
    let changes = changes.map_or_else(|| Ok(Vec::new()), |changes| changes_of(changes, false))?;
    limits
        .set(&changes)
        .map_err(|problems| errors::scene(Problems { input: "limits".to_owned(), ..problems }))?;
    Ok(limits)
}

/// The scene before it is changed and checked.
fn source_of(scene: &Bound<'_, PyAny>, limits: Option<&Bound<'_, PyMapping>>) -> PyResult<Source> {
    if let Ok(scene) = scene.cast::<Scene>() {
        let source = scene.get().source.clone();
        return Ok(Source { limits: limits_of(source.limits, limits)?, ..source });
    }
    let limits = limits_of(Limits::default(), limits)?;
    if scene.cast::<PyMapping>().is_ok() {
        let name = "scene".to_owned();
        return read(&json::text(scene)?, name.clone(), name, Some(".".into()), limits);
    }
    let path: String = scene.py().import("os")?.call_method1("fspath", (scene,))?.extract()?;
    Source::find_within(&path, limits).map_err(errors::scene)
}

/// The scene that is written as `text`.
fn read(
    text: &str,
    name: String,
    input: String,
    folder: Option<PathBuf>,
    limits: Limits,
) -> PyResult<Source> {
    let mut problems = Problems::new(&input);
    let source = parse(text, "", &mut problems).map(|json| Source { name, input, folder, json, limits });
    problems.into_result(source).map_err(errors::scene)
}

/// What a scene is pickled as: name, input, folder, JSON, limits, whether files may be outside.
type Pickled = (String, String, Option<PathBuf>, String, Vec<String>, bool);

/// The scene that was pickled as this.
#[pyfunction]
#[pyo3(name = "_unpickled_scene")]
pub fn unpickled(
    py: Python<'_>,
    name: String,
    input: String,
    folder: Option<PathBuf>,
    json: &str,
    limits: Vec<String>,
    allow_outside: bool,
) -> PyResult<Scene> {
    let mut known = Limits::default().allowing_outside(allow_outside);
    known.set(&limits).map_err(errors::scene)?;
    Scene::build(py, read(json, name, input, folder, known)?)
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (scene, changes=None, *, limits=None, allow_outside=false, **more))]
    fn new(
        scene: &Bound<'_, PyAny>,
        changes: Option<&Bound<'_, PyMapping>>,
        limits: Option<&Bound<'_, PyMapping>>,
        allow_outside: bool,
        more: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Scene> {
        let mut source = source_of(scene, limits)?;
        source.limits = source.limits.allowing_outside(source.limits.allow_outside || allow_outside);
        let mut all = changes.map_or_else(|| Ok(Vec::new()), |changes| changes_of(changes, false))?;
        if let Some(more) = more {
            all.extend(changes_of(more.as_mapping(), true)?);
        }
        source.change(&all).map_err(errors::scene)?;
        Scene::build(scene.py(), source)
    }

    /// As what it was made of: files that it names are read again where it is unpickled.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Pickled)> {
        let Source { name, input, folder, json, limits } = &self.source;
        let folder = folder.as_deref().map(std::path::absolute).transpose()?;
        let counts = limits.all().map(|(name, count)| format!("{name}={count}")).collect();
        let pickled = (name.clone(), input.clone(), folder, json.to_string(), counts, limits.allow_outside);
        Ok((py.import("tumblenet._native")?.getattr("_unpickled_scene")?, pickled))
    }

    /// How much it may ask for, by name.
    #[getter]
    fn limits(&self) -> BTreeMap<&'static str, u64> {
        self.source.limits.all().collect()
    }

    /// Name for messages: that of a built-in scene, or of its file without the ending.
    #[getter]
    fn name(&self) -> &str {
        self.case.name()
    }

    /// What the scene says that it is.
    #[getter]
    fn title(&self) -> &str {
        &self.case.scene().title
    }

    /// First 16 digits of a SHA-256 over the scene, every default filled in, and the built target: `scene_hash` of
    /// summaries.
    #[getter]
    fn hash(&self) -> &str {
        self.case.hash()
    }

    /// The scene as JSON, every default filled in.
    #[getter]
    fn json(&self) -> String {
        serde_json::to_string_pretty(self.case.scene()).unwrap_or_default()
    }

    /// The scene as a dict, every default filled in.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::object(py, self.case.scene())
    }

    /// For how long it runs [s].
    #[getter]
    fn duration(&self) -> f64 {
        self.case.scene().duration_s.0
    }

    /// The step, chosen where the scene leaves it out [s].
    #[getter]
    fn time_step(&self) -> f64 {
        self.case.time_step().step
    }

    /// Number of knots K.
    #[getter]
    fn n_knots(&self) -> usize {
        self.case.net().n_knots()
    }

    /// The two knots of each cable: int64 [C, 2].
    #[getter]
    fn cables<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let cables = &self.case.net().cables;
        let ends = cables.iter().flat_map(|cable| [cable.a as i64, cable.b as i64]).collect();
        Ok(PyArray1::from_vec(py, ends).reshape([cables.len(), 2])?.into_any())
    }

    /// The knots that are bullets: int64 [4].
    #[getter]
    fn bullets<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        arrays::whole(py, self.case.net().bullets.into_iter())
    }

    /// Mass of each knot [kg]: [K].
    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        arrays::numbers(py, self.case.net().mass.clone())
    }

    /// What the model is too coarse for, known before the scene runs.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        warnings::before(&self.case)
    }

    fn __repr__(&self) -> String {
        format!("Scene({:?}, hash={:?})", self.case.name(), self.case.hash())
    }
}
