//! Numbers of a sweep's rows, column by column, and what the rows say of an outcome.

use super::rows::{KeptRow, KeptRows, fields};
use crate::problems::{Problems, did_you_mean};
use crate::study::sweep::SweepPlan;
use crate::study::sweep::outcome::{MapOutcome, MemberEnd};

/// Columns of a table that numbers are read from.
pub struct NumberColumns {
    columns: Vec<usize>,
}

impl NumberColumns {
    /// The columns `names` of `plan`, in their order; those that are not there are faults of `place`.
    pub fn find(plan: &SweepPlan, names: &[&str], place: &str, problems: &mut Problems) -> NumberColumns {
        let mut found = Vec::new();
        for &name in names {
            match plan.columns.iter().position(|known| known == name) {
                Some(column) => found.push(column),
                None => {
                    let meant = did_you_mean(name, plan.columns.iter().map(String::as_str));
                    let columns = plan.columns.join(", ");
                    problems.add(place, name, format!("{meant}Columns of the table: {columns}"));
                }
            }
        }
        NumberColumns { columns: found }
    }

    /// The numbers of `row`, none where there is no number; nothing where it cannot be read, which is a fault.
    pub fn of(&self, kept: &KeptRows, row: &KeptRow, problems: &mut Problems) -> Option<Vec<Option<f64>>> {
        Some(self.cells(kept, row, problems)?.iter().map(|text| number(text)).collect())
    }

    /// The texts of `row` in these columns; nothing where it cannot be read, which is a fault.
    pub fn cells(&self, kept: &KeptRows, row: &KeptRow, problems: &mut Problems) -> Option<Vec<String>> {
        let line = match kept.line_of(row) {
            Ok(line) => fields(&line),
            Err(error) => {
                problems.add("", error.to_string(), "rows that can be read");
                return None;
            }
        };
        let text =
            |&column: &usize| String::from_utf8_lossy(line.get(column).unwrap_or_default()).into_owned();
        Some(self.columns.iter().map(text).collect())
    }
}

/// The number that a cell of a table holds.
pub fn number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|value| value.is_finite())
}

impl MapOutcome {
    /// The columns that it is told by, beside the verdict; where the table of `plan` has left them out, that is a fault.
    pub fn needed(self, plan: &SweepPlan, place: &str, problems: &mut Problems) -> Vec<String> {
        let MapOutcome::HeldAt(_) = self else { return Vec::new() };
        let is_there = |name: &&str| plan.columns.iter().any(|known| known == name);
        if !MapOutcome::COLUMNS.iter().all(is_there) {
            let allowed = format!("a study that collects {}", MapOutcome::COLUMNS.join(", "));
            problems.add(place, "a table without the columns that tell it", allowed);
            return Vec::new();
        }
        MapOutcome::COLUMNS.map(str::to_owned).into()
    }

    /// The answer of `row`, whose numbers in the columns of [`MapOutcome::needed`] are `ends`; none where it is
    /// undecided, or has no verdict.
    pub fn of_row(self, row: &KeptRow, ends: &[Option<f64>], plan: &SweepPlan) -> Option<bool> {
        let verdict = serde_json::from_value(row.verdict.as_ref().into()).ok()?;
        let at = |column: usize| ends.get(column).copied().flatten();
        let at_most = plan
            .study
            .at_most_s
            .map_or_else(|| plan.scene["duration_s"].as_f64().unwrap_or(f64::INFINITY), |time| time.0);
        // Without the columns nothing asks for the times.
        let simulated = at(2).unwrap_or(at_most);
        self.of(&MemberEnd { verdict, enclosed_at: at(0), first_lost_at: at(1), simulated, at_most })
    }
}
