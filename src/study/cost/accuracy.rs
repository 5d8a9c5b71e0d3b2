//! `run --accuracy`: a setting that is known to reach it.
//!
//! What is known comes from studies of built-in scenes (`assets/accuracy.json`, made by
//! `tumblenet cost --collect`) or from a study of one's own scene. Errors travel from net to net as
//! shares of the net's side, explicit steps as shares of the stable step. A setting of the table is
//! only as good as on the worst of the scenes it was measured on.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::dials::{DialKind, explicit_changes, two_digits};
use super::{MeasuredSetting, Study};
use crate::case::Case;
use crate::provenance::Provenance;
use crate::solver::{ContactModel, Integrator, Solver};
use crate::step;
use crate::step::limits::Demands;
use crate::step::mass_spring::stability::stable_step;

/// The table that travels inside the program.
const TABLE: &str = include_str!("../../../assets/accuracy.json");

/// Families that the table knows.
const FAMILIES: [&str; 3] = ["joints, step", "joints, flight explicit", "explicit, symplectic"];

/// An accuracy as a user asks for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// Largest error of a bullet before contact [m].
    Length(f64),
    /// The same over the side of the net [-].
    Share(f64),
}

impl std::str::FromStr for Accuracy {
    type Err = String;

    /// `1mm`, `50um`, `0.001m`; or `fast`, `standard`, `fine`: a thousandth, a ten-thousandth, a
    /// hundred-thousandth of the net's side.
    fn from_str(text: &str) -> Result<Accuracy, String> {
        match text {
            "fast" => return Ok(Accuracy::Share(1e-3)),
            "standard" => return Ok(Accuracy::Share(1e-4)),
            "fine" => return Ok(Accuracy::Share(1e-5)),
            _ => {}
        }
        let units = [("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6), ("cm", 1e-2), ("m", 1.0)];
        let length = units
            .into_iter()
            .find_map(|(unit, factor)| Some(factor * text.strip_suffix(unit)?.trim().parse::<f64>().ok()?));
        match length {
            Some(length) if length.is_finite() && length > 0.0 => Ok(Accuracy::Length(length)),
            _ => Err("fast, standard, fine, or a length above 0 with its unit, as in 1mm or 50um".to_owned()),
        }
    }
}

impl Accuracy {
    /// For a net of side `side` metres [m].
    pub fn length(self, side: f64) -> f64 {
        match self {
            Accuracy::Length(length) => length,
            Accuracy::Share(share) => share * side,
        }
    }
}

/// `assets/accuracy.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Table {
    /// What the numbers are.
    pub about: String,
    /// The settings, each with what it was measured at.
    pub entries: Vec<Entry>,
    /// What made the studies, one a scene.
    pub provenance: Vec<(String, Provenance)>,
}

/// One setting of the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Entry {
    /// The dial.
    pub family: String,
    /// Its position: a step [s], or a share of the stable step.
    pub value: f64,
    /// What it was on each scene.
    pub measured: Vec<OnScene>,
}

/// What a setting was on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OnScene {
    /// The scene.
    pub scene: String,
    /// Window by window, the longest last: floor, and largest error of a bullet before contact, both over
    /// the side of the net [-].
    pub errors: Vec<[f64; 2]>,
    /// Processor time per simulated second [s/s].
    pub cost: f64,
    /// Whether nothing was wrong with the run.
    pub sound: bool,
}

/// A setting that was found for an accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundSetting {
    /// What it changes in the scene, as for `--set`.
    pub changes: Vec<String>,
    /// Which it is and where it was measured, in words.
    pub words: String,
}

impl Table {
    /// The table that travels inside the program.
    pub fn built_in() -> Table {
        match serde_json::from_str(TABLE) {
            Ok(table) => table,
            // Held by the test below.
            Err(error) => unreachable!("assets/accuracy.json: {error}"),
        }
    }

    /// What `studies` say.
    pub fn of(studies: &[Study]) -> Table {
        let mut entries: Vec<Entry> = Vec::new();
        for study in studies {
            let known = |one: &&MeasuredSetting| FAMILIES.contains(&one.family.as_str());
            for one in study.settings.iter().filter(known) {
                let (Some(value), Some(cost)) = (one.value, one.cost) else { continue };
                let windows = study.windows().iter().enumerate();
                let errors = windows.filter_map(|(number, window)| {
                    let error = one.error(number)?.max(window.floor_m);
                    Some([window.floor_m / study.side_m, error / study.side_m])
                });
                let measured = OnScene {
                    scene: study.scene.clone(),
                    errors: errors.collect(),
                    cost: cost.median,
                    sound: one.warnings.is_empty(),
                };
                let same = |entry: &&mut Entry| entry.family == one.family && entry.value == value;
                match entries.iter_mut().find(same) {
                    Some(entry) => entry.measured.push(measured),
                    None => {
                        entries.push(Entry { family: one.family.clone(), value, measured: vec![measured] })
                    }
                }
            }
        }
        Table {
            about: "Made by `tumblenet cost --collect` from studies of built-in scenes; read by `run --accuracy`."
                .to_owned(),
            entries,
            provenance: studies.iter().map(|s| (s.scene.clone(), s.provenance.clone())).collect(),
        }
    }

    /// The cheapest setting for `accuracy` on `case`, which keeps how its contacts are answered.
    ///
    /// # Errors
    /// The finest that is known for such a scene [m].
    pub fn find(&self, case: &Case, accuracy: Accuracy) -> Result<FoundSetting, f64> {
        let side = case.net().designed_area.sqrt();
        let wanted = accuracy.length(side);
        let families: &[&str] = match (case.target(), case.scene().solver.contact) {
            (None, _) => &FAMILIES,
            (Some(_), ContactModel::Rapier) => &["joints, step", "joints, flight explicit"],
            (Some(_), _) => &["explicit, symplectic"],
        };
        // The engine's flight is explicit anyway where there is nothing to meet.
        let usable = |entry: &&Entry| {
            families.contains(&entry.family.as_str())
                && (case.target().is_some() || entry.family != "joints, flight explicit")
                && entry.measured.iter().all(|on| on.sound)
        };
        let mut finest = f64::INFINITY;
        let mut best: Option<(&Entry, f64)> = None;
        for entry in self.entries.iter().filter(usable) {
            let worst = entry.measured.iter().map(|on| on.error(wanted / side)).fold(0.0, f64::max);
            let error = side * worst;
            finest = finest.min(error);
            let cost = |entry: &Entry| entry.measured.iter().map(|on| on.cost).fold(0.0, f64::max);
            if error <= wanted && best.is_none_or(|(known, _)| cost(entry) < cost(known)) {
                best = Some((entry, error));
            }
        }
        let (entry, error) = best.ok_or(finest)?;
        let scenes: Vec<&str> = entry.measured.iter().map(|on| on.scene.as_str()).collect();
        let changes = entry.changes(case);
        Ok(FoundSetting {
            words: format!(
                "{} (measured on {}: at most {} before contact on a net of this size)",
                changes.join(" "),
                scenes.join(" and "),
                super::advice::length(error)
            ),
            changes,
        })
    }
}

impl OnScene {
    /// The error over the net's side in the longest window that can tell it from `wanted`, else in the shortest.
    fn error(&self, wanted: f64) -> f64 {
        let longest = self.errors.iter().rev().find(|[floor, _]| *floor <= wanted);
        longest.or(self.errors.first()).map_or(f64::INFINITY, |[_, error]| *error)
    }
}

impl Entry {
    /// What it changes in the scene of `case`.
    fn changes(&self, case: &Case) -> Vec<String> {
        if self.family == "explicit, symplectic" {
            // A stiff penalty may need a shorter step than the cables do.
            let solver = &case.scene().solver;
            let explicit = Solver { contact: solver.contact, ..solver.with_pair("explicit+impulse") };
            let demands = Demands { solver: &explicit, ..case.demands() };
            let safe = step::method(&explicit).limits(&demands).safe;
            let wanted = self.value * stable_step(case.net());
            let step = two_digits(if wanted > safe && case.target().is_some() { safe } else { wanted });
            let mut changes = explicit_changes(Integrator::Symplectic, step);
            // A response of its own stays what the scene says.
            changes.retain(|change| {
                case.scene().solver.contact == ContactModel::Rapier || !change.starts_with("solver.contact=")
            });
            return changes;
        }
        let flight = if self.family == "joints, step" { "cables" } else { "explicit" };
        vec![
            "solver.cables=joints".to_owned(),
            format!("solver.flight={flight}"),
            "solver.substeps=1".to_owned(),
            format!("solver.step_s={}", self.value),
        ]
    }
}

impl Study {
    /// The cheapest setting of the studied scene for `accuracy`, which keeps how its contacts are
    /// answered.
    ///
    /// # Errors
    /// The finest that was measured [m].
    pub fn find(&self, case: &Case, accuracy: Accuracy) -> Result<FoundSetting, f64> {
        let wanted = accuracy.length(self.side_m);
        let keeps = |one: &&MeasuredSetting| {
            let explicit = one.family.starts_with("explicit");
            let engine = case.scene().solver.contact == ContactModel::Rapier;
            one.kind == DialKind::Method
                && one.warnings.is_empty()
                && (case.target().is_none() || explicit != engine)
        };
        // Below every floor the first window, which has the lowest.
        let window = self.window_for(wanted).unwrap_or(0);
        let floor = self.windows().get(window).map_or(f64::INFINITY, |window| window.floor_m);
        let point = |one: &MeasuredSetting| one.point(window).map(|(cost, error)| (cost, error.max(floor)));
        let sound: Vec<(&MeasuredSetting, (f64, f64))> =
            self.settings.iter().filter(keeps).filter_map(|one| Some((one, point(one)?))).collect();
        let enough = sound.iter().filter(|(_, (_, error))| *error <= wanted);
        let (one, (cost, error)) = enough
            .min_by(|a, b| a.1.0.total_cmp(&b.1.0))
            .ok_or_else(|| sound.iter().map(|(_, (_, error))| *error).fold(f64::INFINITY, f64::min))?;
        Ok(FoundSetting {
            changes: one.changes.clone(),
            words: format!(
                "{} (measured on this scene: {} before contact, {} of processor time per simulated second)",
                one.label,
                super::advice::length(*error),
                super::advice::seconds(*cost)
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(scene: &str, changes: &[&str]) -> Case {
        Case::load(scene, &changes.iter().map(|change| (*change).to_owned()).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn accuracies_are_read_with_their_units() {
        let read = |text: &str| text.parse::<Accuracy>();
        assert_eq!(read("1mm"), Ok(Accuracy::Length(1e-3)));
        assert_eq!(read("50um").unwrap().length(3.0), 50.0 * 1e-6);
        assert_eq!(read("standard").unwrap().length(10.0), 1e-3);
        for bad in ["", "1", "-1mm", "mm", "0m", "NaNm", "finest"] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }

    /// Every name that the program offers leads to a setting that the checks accept, on a deployment
    /// and on captures by either contact.
    #[test]
    fn every_name_leads_to_a_setting_that_can_be_run() {
        let table = Table::built_in();
        let own = ["solver.cables=explicit", "solver.contact=penalty"];
        for (scene, changes) in [
            ("deployment-kevlar", &[][..]),
            ("cubesat-free", &[]),
            ("stage-free", &[]),
            ("cubesat-free", &own),
        ] {
            for name in ["fast", "standard"] {
                let found = table.find(&case(scene, changes), name.parse().unwrap());
                let found = found.unwrap_or_else(|finest| panic!("{scene} {changes:?} {name}: {finest:e}"));
                let all: Vec<&str> =
                    changes.iter().copied().chain(found.changes.iter().map(String::as_str)).collect();
                let set = case(scene, &all);
                // Contact stays as it was.
                let before = case(scene, changes);
                assert!(
                    before.target().is_none() || set.scene().solver.contact == before.scene().solver.contact,
                    "{found:?}"
                );
                assert!(found.words.contains("measured on"), "{found:?}");
            }
        }
    }

    #[test]
    fn what_no_setting_reaches_is_refused_with_the_finest() {
        let finest = Table::built_in().find(&case("deployment-kevlar", &[]), Accuracy::Length(1e-12));
        assert!(finest.unwrap_err() > 1e-12);
    }
}
