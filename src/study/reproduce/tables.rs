//! The rows of published tables that a study brings along: dependencies (Table 3.3) and differences of models (Table 3.4).

use std::collections::BTreeMap;

use super::finding::{ClaimAgreement, ClaimMeasure, Finding};
use super::spec::{SourceSays, TableReason};
use super::{ReproducedRow, why};
use crate::study::sweep::dependency::{Dependencies, last_key, words};

/// Furthest that a dependency may be from the source's and agree [percentage points], beside half of its own interval: that
/// of the effective period, and of all others. The source's own numbers are of single runs.
const POINTS: [f64; 2] = [2.0, 0.7];

/// Below it two models agree, the source says of its Table 3.4 [%].
const MODELS_AGREE: f64 = 10.0;

/// A number of a table.
struct TableCell<'a> {
    source: &'a Option<String>,
    path: &'a str,
    at: &'a BTreeMap<String, String>,
    says: String,
    published: f64,
    /// Ours with half of its interval [%], and whether it agrees.
    found: Option<(f64, Option<f64>, bool)>,
}

/// Those of the study of `all`, which `command` runs; `missing` says why a number is not there.
pub fn rows(all: &Dependencies, reasons: &[TableReason], command: &str, missing: &str) -> Vec<ReproducedRow> {
    let row = |cell: TableCell<'_>| {
        let place = cell.source.clone().unwrap_or_default();
        let finding = match cell.found {
            Some((value, half_width_95, agrees)) => Finding {
                measured: ClaimMeasure::Percent { value, half_width_95 },
                agreement: ClaimAgreement::of(Some(agrees)),
            },
            None => Finding::nothing(missing),
        };
        let known = reasons.iter().find(|reason| reason.is_of(&place, cell.path, cell.at));
        ReproducedRow {
            says: cell.says,
            source: SourceSays::About { value: cell.published, unit: "%".to_owned() },
            why: why(&finding, known.map(|reason| reason.why.as_str())),
            command: command.to_owned(),
            finding,
            place,
        }
    };
    dependencies(all).into_iter().chain(differences(all)).map(row).collect()
}

fn dependencies(all: &Dependencies) -> Vec<TableCell<'_>> {
    let mut cells = Vec::new();
    for row in &all.dependencies {
        let at = &all.groups[row.group];
        for (number, name) in all.numbers.iter().enumerate() {
            let Some(published) = row.published.get(number).copied().flatten() else { continue };
            let allowed = POINTS[usize::from(!name.contains("period"))];
            let found = row.found[number].map(|found| {
                let allowed = allowed.max(found.half_width_95.unwrap_or(0.0));
                (found.percent, found.half_width_95, (found.percent - published).abs() <= allowed)
            });
            let says = format!(
                "{} from {} to {}, {}: {}",
                last_key(&row.path),
                row.from,
                row.to,
                words(at),
                last_key(name)
            );
            cells.push(TableCell { source: &row.source, path: &row.path, at, says, published, found });
        }
    }
    cells
}

fn differences(all: &Dependencies) -> Vec<TableCell<'_>> {
    let mut cells = Vec::new();
    for row in &all.differences {
        let at = &all.groups[row.group];
        for (number, name) in all.numbers.iter().enumerate() {
            let Some(published) = row.published.get(number).copied().flatten() else { continue };
            let found = row.percent[number].map(|found| (found, None, found <= MODELS_AGREE.max(published)));
            let [of, from] = [at, &all.groups[0]].map(words);
            let says = format!("{of} against {from} over {}: {}", last_key(&row.path), last_key(name));
            cells.push(TableCell { source: &row.source, path: &row.path, at, says, published, found });
        }
    }
    cells
}
