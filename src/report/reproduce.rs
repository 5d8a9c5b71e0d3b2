//! What the source says beside what was found, as a table, as a page, and as files: `reproduce.json`, `reproduce.md`,
//! `reproduce.html`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use super::columns::{self, NumberColumns};
use super::files::{self, WriteError};
use super::page::{self, Figure, ResultPage};
use super::results;
use super::rows::KeptRows;
use crate::problems::Problems;
use crate::study::compare::Comparison;
use crate::study::ensemble::Quartiles;
use crate::study::reproduce::finding::{ClaimAgreement, ClaimMeasure, Finding};
use crate::study::reproduce::spec::{Claim, Question, SourceSays};
use crate::study::reproduce::{ReproducedRow, Reproduction};
use crate::study::sweep::outcome::MapOutcome;
use crate::study::sweep::{INPUT, SweepPlan};

/// The rows of a study, as claims ask them.
pub struct StudyRows {
    /// What they were made from.
    pub plan: SweepPlan,
    /// They.
    pub kept: KeptRows,
}

impl StudyRows {
    /// What was found of `claim`, whose study this is.
    ///
    /// # Errors
    /// A parameter, number or outcome that the table has not; a file that cannot be read.
    pub fn answer(&self, claim: &Claim) -> Result<Finding, Problems> {
        match &claim.of {
            Question::Outcome { is, at, .. } => {
                Ok(Finding::of_answers(&self.outcomes(is, at)?, &claim.source))
            }
            Question::Number { name, unit, at, .. } => {
                Ok(Finding::of_numbers(self.numbers(name, at)?, unit, &claim.source))
            }
            Question::Trend { name, unit, over, values, at, .. } => {
                let mut medians = Vec::new();
                for value in values {
                    let mut at = at.clone();
                    at.insert(over.clone(), value.clone());
                    let numbers = self.numbers(name, &at)?;
                    medians.push((!numbers.is_empty()).then(|| Quartiles::of(numbers).median));
                }
                Ok(Finding::of_trend(values, medians, unit, &claim.source))
            }
            Question::Difference { .. } | Question::Cannot { .. } => {
                Ok(Finding::nothing("no study is asked"))
            }
        }
    }

    /// Cells of the columns `names` of every member that did not fail and is at one of the points `at`.
    fn cells(
        &self,
        names: &[String],
        at: &BTreeMap<String, String>,
    ) -> Result<Vec<(u64, Vec<String>)>, Problems> {
        let mut problems = Problems::new(&self.plan.title);
        let inputs = at.keys().map(|path| format!("{INPUT}{path}"));
        let asked: Vec<String> = names.iter().cloned().chain(inputs).collect();
        let asked: Vec<&str> = asked.iter().map(String::as_str).collect();
        let columns = NumberColumns::find(&self.plan, &asked, "claim", &mut problems);
        let mut found = Vec::new();
        for (&member, row) in self.kept.rows.iter().filter(|(_, row)| !row.failed) {
            if !problems.list.is_empty() {
                break;
            }
            let Some(mut cells) = columns.cells(&self.kept, row, &mut problems) else { break };
            if cells.split_off(names.len()).iter().eq(at.values()) {
                found.push((member, cells));
            }
        }
        problems.into_result(Some(found))
    }

    fn numbers(&self, name: &str, at: &BTreeMap<String, String>) -> Result<Vec<f64>, Problems> {
        let cells = self.cells(&[name.to_owned()], at)?;
        Ok(cells.iter().filter_map(|(_, cells)| columns::number(&cells[0])).collect())
    }

    fn outcomes(&self, is: &str, at: &BTreeMap<String, String>) -> Result<Vec<Option<bool>>, Problems> {
        let mut problems = Problems::new(&self.plan.title);
        let outcome: Option<MapOutcome> =
            is.parse().map_err(|allowed: String| problems.add("claim", is, allowed)).ok();
        let needed =
            outcome.map_or_else(Vec::new, |outcome| outcome.needed(&self.plan, "claim", &mut problems));
        let outcome = problems.into_result(outcome)?;
        let answer = |(member, cells): &(u64, Vec<String>)| {
            let ends: Vec<Option<f64>> = cells.iter().map(|text| columns::number(text)).collect();
            outcome.of_row(&self.kept.rows[member], &ends, &self.plan)
        };
        Ok(self.cells(&needed, at)?.iter().map(answer).collect())
    }
}

/// How far the bullets of the two variants of `comparison` are apart over the way of the net.
pub fn difference(comparison: &Comparison, source: &SourceSays) -> Finding {
    let against = comparison.ran().find_map(|(_, _, outcome)| outcome.against_base.as_ref());
    let share = against.and_then(|against| against.separation.whole.mean_over_travel);
    let Some(share) = share else { return Finding::nothing("the runs cannot be set side by side") };
    Finding::of_numbers(vec![100.0 * share], "%", source)
}

/// Writes all files of `all`, with figures of the source that were `drawn` anew, to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, all: &Reproduction, drawn: &[(Figure, String)]) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let mut files = files::Together::begin();
    let page = ResultPage {
        title: "What the source says, and what is found here",
        kind: "reproduction",
        lead: &lead(all),
        tables: tables(all),
        notes: format!("<p>{}</p>\n", page::prose(RULES)),
        drawn,
        provenance: &all.provenance,
        seed: None,
    }
    .html();
    files.write(&out.join("reproduce.html"), |file| file.write_all(page.as_bytes()))?;
    for (figure, svg) in drawn {
        files.write(&out.join(format!("{}.svg", figure.name)), |file| file.write_all(svg.as_bytes()))?;
    }
    files.write(&out.join("reproduce.md"), |file| file.write_all(summary(all).as_bytes()))?;
    // Last: it says that the rest is there.
    files.write(&out.join("reproduce.json"), |file| results::as_json(file, all))?;
    files.appear()
}

const RULES: &str = "A share agrees with yes where most of the members that are decided have it; in brackets its 95 % \
    interval (Clopper and Pearson). A number is the median of the members, in brackets the least and the largest; it \
    agrees where it keeps the stated bound, is within a tenth of the source's number, or has that among the members. A \
    dependency agrees within 0.7 points, of the effective period within 2, or within its own interval; two models \
    where they are no further apart than 10 % or than the source's are.";

/// What there is in all, in words.
pub fn lead(all: &Reproduction) -> String {
    let [agree, differ, open] = counts(&all.rows);
    let left_out = if all.quick { ", are left out of the short form" } else { "" };
    let quick = if all.quick { " In short: few members, and no dear study." } else { "" };
    format!(
        "{} claims: {agree} agree, {differ} differ, {open} are not asked by the source{left_out} or cannot be measured.{quick}",
        all.rows.len()
    )
}

/// The rows of `all` as text, one below the other, and what there is in all.
pub fn text(all: &Reproduction) -> String {
    let mut text = String::new();
    let mut place = "";
    for row in &all.rows {
        if row.place != place {
            let _ = writeln!(text, "{}", row.place);
            place = &row.place;
        }
        let _ = writeln!(
            text,
            "  {:7} {}: {} (source: {})",
            word(row.finding.agreement),
            row.says,
            ours(&row.finding.measured),
            theirs(&row.source)
        );
    }
    text + &lead(all)
}

/// What stands in a README: how many claims of each chapter agree.
pub fn summary(all: &Reproduction) -> String {
    let mut text =
        "| | claims | agree | differ | not asked, or not measured |\n|---|---|---|---|---|\n".to_owned();
    for (chapter, rows) in chapters(all) {
        let [agree, differ, open] = counts(rows.iter().copied());
        let _ = writeln!(text, "| {chapter} | {} | {agree} | {differ} | {open} |", rows.len());
    }
    text
}

/// The rows by chapter, in the order of the source; last what is asked beyond it.
fn chapters(all: &Reproduction) -> BTreeMap<&'static str, Vec<&ReproducedRow>> {
    let mut chapters: BTreeMap<&str, Vec<&ReproducedRow>> = BTreeMap::new();
    for row in &all.rows {
        let digit = row.place.chars().find(char::is_ascii_digit);
        let chapter = match digit {
            Some('3') => "3, deployment",
            Some('4') => "4, contact",
            Some('5') => "5, capture",
            Some('6') => "6.3, what it leaves open",
            _ => "beyond the source: what lasts",
        };
        chapters.entry(chapter).or_default().push(row);
    }
    chapters
}

fn counts<'a>(rows: impl IntoIterator<Item = &'a ReproducedRow>) -> [usize; 3] {
    let mut counts = [0; 3];
    for row in rows {
        counts[match row.finding.agreement {
            ClaimAgreement::Agrees => 0,
            ClaimAgreement::Differs => 1,
            ClaimAgreement::Open => 2,
        }] += 1;
    }
    counts
}

fn word(agreement: ClaimAgreement) -> &'static str {
    match agreement {
        ClaimAgreement::Agrees => "agrees",
        ClaimAgreement::Differs => "differs",
        ClaimAgreement::Open => "–",
    }
}

/// A table for each chapter.
fn tables(all: &Reproduction) -> String {
    let mut text = String::new();
    for (chapter, rows) in chapters(all) {
        let _ = writeln!(text, "<h2>{}</h2>", page::escape(chapter));
        let head = "<th>claim</th><th class=\"words\">source</th><th class=\"words\">here</th><th></th>";
        let lines: String = rows.into_iter().map(line).collect();
        text += &page::table(head, &lines);
    }
    text
}

fn line(row: &ReproducedRow) -> String {
    let why = match row.why.as_str() {
        "" => String::new(),
        why => format!("<br><small>{}</small>", page::prose(why)),
    };
    format!(
        "<tr class=\"claim\"><td><small>{}</small><br>{}{why}<br><code><small>{}</small></code></td><td class=\"words\">{}</td><td \
         class=\"words\">{}</td><td class=\"{}\">{}</td></tr>\n",
        page::escape(&row.place),
        page::escape(&row.says),
        page::escape(&row.command),
        page::prose(&theirs(&row.source)).replace(" %", "&nbsp;%"),
        page::prose(&ours(&row.finding.measured)).replace(" %", "&nbsp;%"),
        word(row.finding.agreement).replace('–', "open"),
        word(row.finding.agreement)
    )
}

/// A number with its unit, in three digits.
fn short(value: f64, unit: &str) -> String {
    let text = match value.abs() {
        size if size != 0.0 && !(1e-3..1e5).contains(&size) => format!("{value:.2e}"),
        size => {
            let digits = 2 - size.log10().floor().clamp(-3.0, 2.0) as i32;
            format!("{value:.*}", if size == 0.0 { 0 } else { digits as usize })
        }
    };
    if unit.is_empty() { text } else { format!("{text} {unit}") }
}

fn theirs(source: &SourceSays) -> String {
    match source {
        SourceSays::Yes => "yes".to_owned(),
        SourceSays::No => "no".to_owned(),
        SourceSays::About { value, unit } => format!("{value} {unit}"),
        SourceSays::AtMost { value, unit } => format!("at most {value} {unit}"),
        SourceSays::Above { value, unit } => format!("more than {value} {unit}"),
        SourceSays::Rises => "rises".to_owned(),
        SourceSays::Falls => "falls".to_owned(),
        SourceSays::NotAsked => "not asked".to_owned(),
    }
}

fn ours(measured: &ClaimMeasure) -> String {
    match measured {
        ClaimMeasure::Share { share, undecided } => {
            let [low, high] = share.interval_95.map(|bound| 100.0 * bound);
            let undecided = match undecided {
                0 => String::new(),
                n => format!(", {n} undecided"),
            };
            format!("{} of {} ({low:.0} to {high:.0} %){undecided}", share.captured, share.of)
        }
        ClaimMeasure::Number { quartiles: Quartiles { min, median, max, .. }, unit } if min == max => {
            short(*median, unit)
        }
        ClaimMeasure::Number { quartiles: Quartiles { min, median, max, .. }, unit } => {
            format!("{} ({} to {})", short(*median, unit), short(*min, ""), short(*max, ""))
        }
        ClaimMeasure::Trend { medians, unit, .. } => {
            let medians = medians
                .iter()
                .map(|median| median.map_or_else(|| "–".to_owned(), |median| short(median, "")));
            format!("{} {unit}", medians.collect::<Vec<_>>().join(", "))
        }
        ClaimMeasure::Percent { value, half_width_95: None } => format!("{value:.2} %"),
        ClaimMeasure::Percent { value, half_width_95: Some(half) } => format!("{value:.2} ± {half:.2} %"),
        ClaimMeasure::Nothing { because } => because.clone(),
    }
}
