//! What to use: the cheapest setting for each accuracy, and for the verdict alone.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::dials::AS_WRITTEN;
use super::verdicts::Verdicts;
use super::{Measured, Study};

/// Accuracies that advice is given for [m].
const LEVELS: [f64; 7] = [1e-2, 5e-3, 1e-3, 5e-4, 1e-4, 1e-5, 1e-6];

/// The accuracy of the sentence [m].
const ASKED: f64 = 1e-3;

/// What to use.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Advice {
    /// In a sentence.
    pub sentence: String,
    /// The cheapest setting for each accuracy that one reaches.
    pub levels: Vec<Level>,
    /// The cheapest setting whose verdicts nothing tells apart from the finest's.
    pub for_verdict: Option<String>,
    /// What is wrong with which setting.
    pub warnings: Vec<String>,
}

/// The cheapest setting for an accuracy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Level {
    /// Largest error of a bullet before contact [m].
    pub accuracy_m: f64,
    /// The setting.
    pub label: String,
    /// Its error [m].
    pub error_m: f64,
    /// Its cost [s/s].
    pub cost: f64,
}

impl Advice {
    /// That of a study, whose front and distributions are there.
    pub fn of(study: &Study) -> Advice {
        let front: Vec<&Measured> = study.settings.iter().filter(|one| one.on_front).collect();
        let cheapest = |accuracy: f64| {
            let enough = front.iter().filter_map(|one| Some((*one, one.point()?)));
            let enough = enough.filter(|(_, (_, error))| *error <= accuracy);
            let best = enough.min_by(|a, b| a.1.0.total_cmp(&b.1.0));
            best.map(|(one, (cost, error_m))| Level {
                accuracy_m: accuracy,
                label: one.label.clone(),
                error_m,
                cost,
            })
        };
        let known = |accuracy: &f64| *accuracy >= study.floor_m;
        let levels: Vec<Level> = LEVELS.into_iter().filter(known).filter_map(cheapest).collect();
        let for_verdict = verdict(study);
        let warnings = study.settings.iter().filter(|one| !one.warnings.is_empty());
        Advice {
            sentence: sentence(study, &levels, for_verdict),
            for_verdict: for_verdict.map(|verdicts| verdicts.label.clone()),
            levels,
            warnings: warnings.map(|one| format!("{}: {}", one.label, one.warnings.join("; "))).collect(),
        }
    }
}

/// The cheapest setting of the same equations whose distribution agrees with the finest's.
fn verdict(study: &Study) -> Option<&Verdicts> {
    let sound = |verdicts: &&Verdicts| {
        study.settings.iter().any(|one| {
            one.label == verdicts.label && one.kind != super::dials::Kind::Model && one.warnings.is_empty()
        })
    };
    let agreeing = study.verdicts.iter().filter(|verdicts| verdicts.agrees == Some(true)).filter(sound);
    agreeing.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

fn sentence(study: &Study, levels: &[Level], verdict: Option<&Verdicts>) -> String {
    let mut parts = Vec::new();
    // The accuracy asked for, or the nearest that is reached.
    let level = levels.iter().find(|level| level.accuracy_m <= ASKED * 1.001).or(levels.last());
    if let Some(level) = level {
        parts.push(format!(
            "for {} before contact use {}: it costs {} of processor time per simulated second",
            length(level.accuracy_m),
            level.label,
            seconds(level.cost)
        ));
    }
    match verdict {
        Some(verdict) => parts.push(format!(
            "for the verdict alone use {}: {} per simulated second",
            verdict.label,
            seconds(verdict.cost)
        )),
        None if !study.verdicts.is_empty() => {
            parts.push(
                "for the verdict no cheaper setting agrees with the finest: keep the scene as written"
                    .to_owned(),
            );
        }
        None => {}
    }
    if let Some(written) = study.settings.iter().find(|one| one.family == AS_WRITTEN)
        && let (Some(cost), Some(error)) = (written.cost, written.error())
    {
        parts.push(format!(
            "as written the scene costs {} and errs by {}",
            seconds(cost.median),
            length(error)
        ));
    }
    let text = parts.join("; ");
    let mut letters = text.chars();
    letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect::<String>() + ".")
}

/// A length in words, with two digits.
pub fn length(metres: f64) -> String {
    let (value, unit) = match metres {
        m if m >= 1.0 => (m, "m"),
        m if m >= 1e-3 * 0.9995 => (1e3 * m, "mm"),
        m if m >= 1e-6 * 0.9995 => (1e6 * m, "µm"),
        m => (1e9 * m, "nm"),
    };
    format!("{} {unit}", two(value))
}

/// A time in words, with two digits.
pub fn seconds(seconds: f64) -> String {
    if seconds >= 0.9995 { format!("{} s", two(seconds)) } else { format!("{} ms", two(1e3 * seconds)) }
}

fn two(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = (1.0 - value.abs().log10().floor()).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_times_are_said_in_two_digits() {
        assert_eq!(
            [1e-3, 5e-4, 2.5, 1.23e-5, 4e-8].map(length),
            ["1 mm", "500 µm", "2.5 m", "12 µm", "40 nm"]
        );
        assert_eq!([0.0123, 1.0, 12.34, 0.0].map(seconds), ["12 ms", "1 s", "12 s", "0 ms"]);
    }
}
