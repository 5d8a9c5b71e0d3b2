//! A sweep as files and words: `study.json`, the merged `table.csv`, `sweep.json`.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::files::{self, Together, WriteError};
use super::results;
use super::rows::{KeptRows, MOST_BYTES, fields, line, ranges};
use super::table::verdict_words;
use crate::limits;
use crate::study::ensemble::Share;
use crate::study::sweep::{Shard, SweepPlan};

/// What says which sweep a folder has rows of.
pub const PLAN: &str = "study.json";
const TABLE: &str = "table.csv";
const RESULT: &str = "sweep.json";

/// What a sweep has come to: `sweep.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepResult {
    /// What the study asks.
    pub title: String,
    /// All members.
    pub members: u64,
    /// Members that have a row.
    pub finished: u64,
    /// Members that failed; their rows say why.
    pub failed: u64,
    /// Share captured of those with a verdict, over all points; absent without any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub captured: Option<Share>,
    /// How often each verdict was given.
    pub verdict_counts: BTreeMap<String, usize>,
    /// Files whose rows do not count, since they are not what they were when they were written.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub damaged: Vec<PathBuf>,
    /// What the rows were made from.
    pub plan: SweepPlan,
}

impl SweepResult {
    /// What `kept` has come to.
    pub fn of(plan: &SweepPlan, kept: &KeptRows) -> SweepResult {
        let mut verdict_counts = BTreeMap::new();
        let (mut captured, mut of, mut failed) = (0, 0, 0);
        for row in kept.rows.values() {
            failed += u64::from(row.failed);
            if let Some(is_captured) = row.captured {
                captured += usize::from(is_captured);
                of += 1;
                *verdict_counts.entry(row.verdict.to_string()).or_insert(0) += 1;
            }
        }
        SweepResult {
            title: plan.title.clone(),
            members: plan.members,
            finished: kept.rows.len() as u64,
            failed,
            captured: (of > 0).then(|| Share::of(captured, of)),
            verdict_counts,
            damaged: kept.damaged.clone(),
            plan: plan.clone(),
        }
    }
}

/// Says in the folder `out` what rows are made from; rows of the same key are found by it.
///
/// # Errors
/// Folder or file cannot be written.
pub fn write_plan(out: &Path, plan: &SweepPlan) -> Result<(), WriteError> {
    files::make_folder(out)?;
    // As it is where nothing but the machine is another: shards of one study begin at the same time.
    let same = |known: SweepPlan| SweepPlan { provenance: plan.provenance.clone(), ..known } == *plan;
    if read_plan(out).is_ok_and(same) {
        return Ok(());
    }
    results::json(&out.join(PLAN), plan)
}

/// The plan in the folder `out`.
///
/// # Errors
/// Why there is none, in words.
pub fn read_plan(out: &Path) -> Result<SweepPlan, String> {
    let bytes = limits::read_file(&out.join(PLAN), MOST_BYTES).map_err(|error| error.to_string())?;
    let plan: SweepPlan = serde_json::from_slice(&bytes).map_err(|error| error.to_string())?;
    plan.check().map(|()| plan)
}

/// Writes the table of all rows, in the order of the members and without columns that none of them fills, and what they
/// come to.
///
/// # Errors
/// Two rows of a member differ; a file cannot be read or written.
pub fn merge(out: &Path, plan: &SweepPlan, kept: &KeptRows) -> Result<SweepResult, WriteError> {
    if let Some((member, path)) = kept.contradicted.first() {
        let reason =
            format!("its row of member {member} is not that of another file: remove the wrong one of them");
        return Err(WriteError::new(path, reason));
    }
    let mut is_filled = vec![false; plan.columns.len()];
    for row in kept.rows.values() {
        let line = kept.line_of(row)?;
        for (filled, field) in is_filled.iter_mut().zip(&fields(&line)) {
            *filled |= !field.is_empty();
        }
    }
    let chosen = |fields: &csv::ByteRecord| -> Vec<Vec<u8>> {
        let filled = fields.iter().zip(&is_filled).filter(|(_, filled)| **filled);
        filled.map(|(field, _)| field.to_vec()).collect()
    };
    let mut files = Together::begin();
    let place = out.join(TABLE);
    files.write(&place, |file| {
        let header = csv::ByteRecord::from(plan.columns.iter().map(String::as_bytes).collect::<Vec<_>>());
        let told = |error: std::io::Error| error.to_string();
        file.write_all(&line(&chosen(&header))).map_err(told)?;
        for row in kept.rows.values() {
            let row = kept.line_of(row).map_err(|error| error.to_string())?;
            file.write_all(&line(&chosen(&fields(&row)))).map_err(told)?;
        }
        Ok::<(), String>(())
    })?;
    let result = SweepResult::of(plan, kept);
    // Last: it says that the rest is there.
    files.write(&out.join(RESULT), |file| results::as_json(file, &result))?;
    files.appear()?;
    Ok(result)
}

/// The path of the merged table in the folder `out`.
pub fn table(out: &Path) -> PathBuf {
    out.join(TABLE)
}

/// What a sweep has come to, in a few lines.
pub fn words(result: &SweepResult) -> String {
    let mut text = format!("{}\n{} of {} members finished", result.title, result.finished, result.members);
    if result.failed > 0 {
        text.push_str(&format!(", {} of them failed: the column `failure` says why", result.failed));
    }
    text.push('.');
    if let Some(share) = &result.captured {
        let counts = verdict_words(&result.verdict_counts);
        text.push_str(&format!("\nOver all points {}: {counts}.", share_words("captured", share)));
    }
    for path in &result.damaged {
        text.push_str(&format!("\nDamaged, its rows do not count: {}", path.display()));
    }
    text
}

/// A share of members of whom something is so, with its interval: `captured 12 of 16 (75.0 %; 95 % interval 48 to 93 %)`.
pub fn share_words(what: &str, share: &Share) -> String {
    let [low, high] = share.interval_95.map(|bound| 100.0 * bound);
    let percent = 100.0 * share.share;
    format!(
        "{what} {} of {} ({percent:.1} %; 95 % interval {low:.0} to {high:.0} %)",
        share.captured, share.of
    )
}

/// What is missing: members, or with `shards` the shards of so many that have a missing member.
pub fn missing(plan: &SweepPlan, kept: &KeptRows, shards: Option<u64>) -> String {
    let members = kept.missing(plan);
    let Some(of) = shards else { return ranges(&members) };
    let numbers: BTreeSet<u64> = members.iter().map(|&member| Shard::with(member, of).number).collect();
    ranges(&Vec::from_iter(numbers))
}
