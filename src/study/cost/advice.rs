//! What to use: the cheapest setting for each accuracy, and for the verdict alone.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Study;
use super::dials::AS_WRITTEN;
use super::verdicts::{Agreement, Verdicts};
use crate::study::log_rank::LogRank;

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
    /// From which setting on curves of survival cannot be told apart; absent where nothing is held.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_holding: Option<Holding>,
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

/// From which setting on, by cost, nothing tells how long a target is held from the finest's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Holding {
    /// The cheapest setting such that neither it nor a dearer one is told apart; null when the dearest is, or too few
    /// members could tell.
    pub from: Option<String>,
    /// Labels of those that are told apart.
    pub told_apart: Vec<String>,
    /// Comparisons that the chances are adjusted for.
    pub comparisons: usize,
    /// Members of each setting, the fewest.
    pub members: usize,
    /// Whether so few could tell anything apart.
    pub can_tell: bool,
}

impl Holding {
    /// That of a study; nothing where no curve was compared.
    fn of(study: &Study) -> Option<Holding> {
        let compared = || study.verdicts.iter().filter_map(|one| Some((one, one.holding.as_ref()?)));
        let comparisons = compared().count();
        let members = compared().flat_map(|(_, test)| test.members).min()?;
        let told_apart = compared().filter(|(_, test)| test.told_apart());
        let told_apart: Vec<String> = told_apart.map(|(one, _)| one.label.clone()).collect();
        let can_tell = compared().all(|(_, test)| test.can_tell(comparisons));
        let mut by_cost: Vec<(&Verdicts, &LogRank)> =
            compared().filter(|(one, _)| is_sound(study, one)).collect();
        by_cost.sort_by(|a, b| b.0.cost.total_cmp(&a.0.cost));
        let alike = by_cost.into_iter().take_while(|(_, test)| !test.told_apart());
        let from = alike.last().filter(|_| can_tell).map(|(one, _)| one.label.clone());
        Some(Holding { from, told_apart, comparisons, members, can_tell })
    }

    /// In a sentence, with neither capital nor full stop.
    fn words(&self) -> String {
        let Holding { members, comparisons, .. } = self;
        match &self.from {
            Some(from) => format!(
                "how long it holds: from {from} on, by cost, no setting is told apart from the finest (log-rank, \
                 {members} members each, adjusted for {comparisons} comparisons)"
            ),
            None if !self.can_tell => format!(
                "how long it holds: {members} members a setting are too few to tell anything apart, a longer budget can"
            ),
            None => "how long it holds: even the dearest setting is told apart from the finest".to_owned(),
        }
    }
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
        let for_holding = Holding::of(study);
        let warnings = study.settings.iter().filter(|one| !one.warnings.is_empty());
        Advice {
            sentence: sentence(study, &levels, for_verdict, for_holding.as_ref()),
            for_verdict: for_verdict.map(|verdicts| verdicts.label.clone()),
            for_holding,
            levels,
            warnings: warnings.map(|one| format!("{}: {}", one.label, one.warnings.join("; "))).collect(),
        }
    }
}

/// The cheapest setting of the same equations whose distribution agrees with the finest's.
fn verdict(study: &Study) -> Option<&Verdicts> {
    let agreeing = study.verdicts.iter().filter(|verdicts| verdicts.agreement == Agreement::Agrees);
    let agreeing = agreeing.filter(|verdicts| is_sound(study, verdicts));
    agreeing.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Whether these are of the same equations, and nothing is wrong with the setting.
fn is_sound(study: &Study, verdicts: &Verdicts) -> bool {
    study.settings.iter().any(|one| {
        one.label == verdicts.label && one.kind != super::dials::DialKind::Model && one.warnings.is_empty()
    })
}

fn sentence(
    study: &Study,
    levels: &[Level],
    verdict: Option<&Verdicts>,
    holding: Option<&Holding>,
) -> String {
    let mut parts = Vec::new();
    let of_flight = if study.measured_until_s.is_some() { " of flight" } else { "" };
    // The accuracy asked for, or the nearest that is reached.
    let level = levels.iter().find(|level| level.accuracy_m <= ASKED * 1.001).or(levels.last());
    if let Some(level) = level {
        parts.push(format!(
            "for {} before contact (known until {:.2} s) use {}: it costs {} of processor time per simulated second{of_flight}",
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
    parts.extend(holding.map(Holding::words));
    if let Some(written) = study.settings.iter().find(|one| one.family == AS_WRITTEN)
        && let (Some(cost), Some(error)) =
            (written.cost, study.windows().len().checked_sub(1).and_then(|last| written.error(last)))
    {
        parts.push(format!(
            "as written the scene costs {}{of_flight} and errs by {}",
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
