//! A fit that was read and checked: its scene, what of it may vary, and what was seen of which knot.

use std::path::Path;

use super::paths::KnotPaths;
use super::spec::FitSpec;
use super::tracks::{MarkerTracks, Matching, Paired};
use crate::case::Case;
use crate::case::uncertain::check_ends;
use crate::limits::{Limit, Limits};
use crate::parameter::{self, Own, Parameter};
use crate::problems::{Problems, join};
use crate::run::Run;
use crate::scene::Source;
use crate::study;
use crate::study::sweep::{SceneOf, built};
use crate::target::files::Files;

/// A fit that was checked.
pub struct FitStudy {
    /// As written.
    pub spec: FitSpec,
    /// The scene, method and step as all flights have them.
    source: Source,
    /// The scene as it is.
    pub case: Case,
    /// What is fitted.
    pub axes: Vec<FitAxis>,
    /// What was measured.
    pub tracks: MarkerTracks,
    /// What of it is compared with which knots.
    pub(super) seen: Vec<Paired>,
}

/// A parameter that is fitted.
#[derive(Clone, Debug)]
pub struct FitAxis {
    /// Its place in the study.
    place: String,
    /// The parameter.
    pub parameter: Parameter,
    /// Its least and largest value.
    pub ends: [f64; 2],
    /// Whether equal shares of its range are equal ratios.
    pub is_log: bool,
    /// What the scene says; nothing where that is no number within the range.
    pub own: Option<f64>,
}

impl FitAxis {
    /// The value at the share `unit` of the range, also beyond its ends.
    pub fn value(&self, unit: f64) -> f64 {
        let [low, high] = self.ends;
        if self.is_log { low * (high / low).powf(unit) } else { low + unit * (high - low) }
    }

    /// The share of the range at `value`.
    pub(super) fn unit(&self, value: f64) -> f64 {
        let [low, high] = self.ends;
        if self.is_log { (value / low).ln() / (high / low).ln() } else { (value - low) / (high - low) }
    }

    /// The change of a scene at the share `unit`.
    pub(super) fn change(&self, unit: f64) -> String {
        self.parameter.change(&self.parameter.drawn(&[unit]))
    }
}

impl FitStudy {
    /// Finds, reads and checks the fit in the file `path`.
    ///
    /// # Errors
    /// Every fault at once: of the fit, its scene, its tracks, and of the scene at the ends of the ranges.
    pub fn load(path: &str, limits: Limits) -> Result<FitStudy, Problems> {
        study::load(path, None, "the path of a fit", limits, FitStudy::check)
    }

    fn check(spec: FitSpec, file: &Path, limits: Limits, problems: &mut Problems) -> Option<FitStudy> {
        let scene = SceneOf { scene: &spec.scene, set: &spec.set, solver: spec.solver.as_deref() };
        let source = scene.source(file, limits, problems);
        let tracks = tracks(&spec.track, file, limits, problems);
        let axes = axes(&spec, source.as_ref(), problems);
        let source = source?;
        let case = built(&source, "scene", problems)?;
        for axis in &axes {
            check_ends(&source, &axis.parameter, &axis.place, problems);
        }
        let tracks = tracks?;
        let seen = seen(&tracks, &case, spec.matching, problems)?;
        if !problems.list.is_empty() {
            return None;
        }
        let source = held(source, &axes, problems)?;
        Some(FitStudy { spec, source, case, axes, tracks, seen })
    }

    /// Name for results and messages.
    pub fn name(&self) -> &str {
        &self.source.name
    }

    /// The changes of the scene at `units`.
    pub fn changes(&self, units: &[f64]) -> Vec<String> {
        self.axes.iter().zip(units).map(|(axis, unit)| axis.change(*unit)).collect()
    }

    /// The scene at `units`.
    pub(super) fn case_at(&self, units: &[f64]) -> Result<Case, String> {
        let mut source = self.source.clone();
        source.set(&self.changes(units)).map_err(|faults| faults.in_a_line())?;
        Case::build_point(&source).map_err(|faults| faults.in_a_line())
    }

    /// Step of all flights [s].
    pub(super) fn step(&self) -> Option<f64> {
        self.source.json["solver"]["step_s"].as_f64()
    }
}

/// The tracks in the file `name` beside the study `file`.
fn tracks(name: &str, file: &Path, limits: Limits, problems: &mut Problems) -> Option<MarkerTracks> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let (bytes, _) = Files::of(Some(folder), &limits).read(name, Limit::Text, "track", problems)?;
    let mut faults = Problems::new("");
    let tracks = MarkerTracks::read(&bytes, &mut faults);
    problems.add_below("track", faults);
    tracks
}

/// Which knot of `case` is seen where. By place, that of a flight of the scene as it is.
fn seen(
    tracks: &MarkerTracks,
    case: &Case,
    matching: Matching,
    problems: &mut Problems,
) -> Option<Vec<Paired>> {
    // Not before all else is right.
    let flown = matching == Matching::Nearest && problems.list.is_empty();
    let paths = match flown.then(|| Run::of(case, |_| {})) {
        None => KnotPaths::folded(case),
        Some(Ok(run)) => KnotPaths::of(case, run),
        Some(Err(failure)) => {
            problems.add("scene", failure, "a scene that flies");
            return None;
        }
    };
    let mut faults = Problems::new("");
    let knots = tracks.knots(&paths, matching, &mut faults);
    problems.add_below("track", faults);
    knots.map(|knots| tracks.paired(&knots))
}

/// The parameters of `spec`, those without a fault.
fn axes(spec: &FitSpec, source: Option<&Source>, problems: &mut Problems) -> Vec<FitAxis> {
    parameter::check_apart(&spec.parameters, "parameters", problems);
    let mut axes = Vec::new();
    for (number, varied) in spec.parameters.iter().enumerate() {
        let place = format!("parameters[{number}]");
        let own = source.map_or(Own::Unknown, |source| source.own(&varied.path));
        let Some(parameter) = Parameter::read(varied, &own, &place, problems) else { continue };
        let between = parameter.number_between().filter(|([low, high], _)| low < high);
        let Some((ends, is_log)) = between else {
            problems.add(
                &*place,
                "no range of one number",
                "uniform or log_uniform: [least, largest] of a number",
            );
            continue;
        };
        if parameter.crossed {
            problems.add(join(&place, "crossed"), true, "a parameter of a `one-at-a-time` study");
        }
        let own = match own {
            Own::Value(value) => value.as_f64().filter(|own| (ends[0]..=ends[1]).contains(own)),
            Own::Nothing | Own::Unknown => None,
        };
        axes.push(FitAxis { place, parameter, ends, is_log, own });
    }
    axes
}

/// `source` with method and step of the corner of the ranges that asks for the shortest step; corners that the scene does
/// not allow are faults.
fn held(mut source: Source, axes: &[FitAxis], problems: &mut Problems) -> Option<Source> {
    let mut shortest: Option<(f64, serde_json::Value)> = None;
    for corner in 0..1_u32 << axes.len() {
        let units = (0..axes.len()).map(|axis| f64::from(corner >> axis & 1));
        let changes: Vec<String> = axes.iter().zip(units).map(|(axis, unit)| axis.change(unit)).collect();
        let mut changed = source.clone();
        let case = changed.set(&changes).and_then(|()| Case::build_point(&changed));
        match case {
            Ok(case) => {
                let solver = case.scene().solver;
                let step = solver.step_s.map_or(f64::INFINITY, |step| step.0);
                if shortest.as_ref().is_none_or(|(least, _)| step < *least) {
                    shortest = Some((step, serde_json::json!(solver)));
                }
            }
            Err(faults) => {
                for fault in faults.list {
                    let found =
                        format!("{}, with which {} is {}", changes.join(", "), fault.place, fault.found);
                    problems.add("parameters", found, fault.allowed);
                }
            }
        }
    }
    let (_, solver) = shortest.filter(|_| problems.list.is_empty())?;
    source.json["solver"] = solver;
    Some(source)
}
