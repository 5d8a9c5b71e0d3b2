//! What to use: the cheapest setting for each accuracy, and for the verdict alone.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Study;
use super::dials::AS_WRITTEN;
use super::verdicts::{Agreement, Verdicts};

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
    /// Until when that holds [s].
    pub until_s: f64,
    /// Its error [m].
    pub error_m: f64,
    /// Its cost [s/s].
    pub cost: f64,
}

impl Level {
    /// The cheapest setting of a study for `accuracy`, in the longest window that can tell.
    fn of(study: &Study, accuracy: f64) -> Option<Level> {
        let window = study.window_for(accuracy)?;
        let front = study.settings.iter().filter(|one| one.fronts.contains(&window));
        let points = front.filter_map(|one| Some((one, one.point(window)?)));
        let enough = points.filter(|(_, (_, error))| *error <= accuracy);
        let (one, (cost, error_m)) = enough.min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
        let until_s = study.windows()[window].end_s;
        Some(Level { accuracy_m: accuracy, label: one.label.clone(), until_s, error_m, cost })
    }
}

impl Advice {
    /// That of a study, whose front and distributions are there.
    pub fn of(study: &Study) -> Advice {
        let levels: Vec<Level> =
            LEVELS.into_iter().filter_map(|accuracy| Level::of(study, accuracy)).collect();
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
            one.label == verdicts.label
                && one.kind != super::dials::DialKind::Model
                && one.warnings.is_empty()
        })
    };
    let agreeing =
        study.verdicts.iter().filter(|verdicts| verdicts.agreement == Agreement::Agrees).filter(sound);
    agreeing.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

fn sentence(study: &Study, levels: &[Level], verdict: Option<&Verdicts>) -> String {
    let mut parts = Vec::new();
    // The accuracy asked for, or the nearest that is reached.
    let level = levels.iter().find(|level| level.accuracy_m <= ASKED * 1.001).or(levels.last());
    if let Some(level) = level {
        parts.push(format!(
            "for {} before contact (known until {:.2} s) use {}: it costs {} of processor time per simulated second",
            length(level.accuracy_m),
            level.until_s,
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
        None if study.verdicts.iter().any(|verdicts| verdicts.agreement == Agreement::TooFew) => {
            parts.push("for the verdict alone a longer budget is needed: too few members".to_owned());
        }
        None if !study.verdicts.is_empty() => parts.push(
            "for the verdict no cheaper setting agrees with the finest: keep the scene as written".to_owned(),
        ),
        None => {}
    }
    if let Some(written) = study.settings.iter().find(|one| one.family == AS_WRITTEN)
        && let (Some(cost), Some(error)) =
            (written.cost, study.windows().len().checked_sub(1).and_then(|last| written.error(last)))
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
