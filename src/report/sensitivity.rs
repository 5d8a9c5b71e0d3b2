//! What matters in a sweep: `sensitivity.json`, `sensitivity.svg`, `sensitivity.html`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use super::columns::NumberColumns;
use super::files::{self, WriteError};
use super::page::{self, Figure, ResultPage};
use super::plots::{Axis, INK, Mark, Panel, colour};
use super::results;
use super::rows::KeptRows;
use super::table::number;
use super::text_table::TextTable;
use crate::problems::Problems;
use crate::study::sweep::outcome::MapOutcome;
use crate::study::sweep::sensitivity::{OutputShares, Sensitivity, VarianceShare};
use crate::study::sweep::spec::Design;
use crate::study::sweep::{DRAWN, INPUT, SweepPlan};

const WORDS: &str = "Total share of the variance (bar, with its 95 % interval): what would stay if all other inputs were known. \
    Beside it the share from the input alone.";

const NOTES: &str = "<p>Shares of the variance, alone / total with its 95 % interval, by Jansen's sums over blocks. What \
    chance makes of the smallest change of an input, in a chaotic run, counts as that input's.</p>\n";

/// What matters for `outcome` and for every number of the members among `kept`.
///
/// # Errors
/// A design without blocks; columns that are not there; a file that cannot be read.
pub fn find(plan: &SweepPlan, kept: &KeptRows, outcome: MapOutcome) -> Result<Sensitivity, Problems> {
    let mut problems = Problems::new("sensitivity");
    if !matches!(plan.study.design, Design::Saltelli { .. }) {
        problems.add("design.kind", "a design without blocks", "\"saltelli\"");
    }
    let told = outcome.needed(plan, "--outcome", &mut problems);
    let fixed = ["member", "point", "seed", "captured", "verdict", "reason", "failure"];
    let is_scalar = |name: &&String| {
        !(fixed.contains(&name.as_str()) || name.starts_with(INPUT) || name.starts_with(DRAWN))
    };
    let scalars: Vec<&String> = plan.columns.iter().filter(is_scalar).collect();
    let names: Vec<&str> = told.iter().chain(scalars.iter().copied()).map(String::as_str).collect();
    let columns = NumberColumns::find(plan, &names, "--outcome", &mut problems);
    let mut came = BTreeMap::new();
    let mut values: BTreeMap<String, BTreeMap<u64, f64>> = BTreeMap::new();
    for (&member, row) in &kept.rows {
        if row.failed || !problems.list.is_empty() {
            continue;
        }
        let Some(numbers) = columns.of(kept, row, &mut problems) else { break };
        let (ends, numbers) = numbers.split_at(told.len());
        if let Some(is_so) = outcome.of_row(row, ends, plan) {
            came.insert(member, f64::from(u8::from(is_so)));
        }
        for (name, value) in scalars.iter().zip(numbers) {
            if let Some(value) = value {
                values.entry((*name).clone()).or_default().insert(member, *value);
            }
        }
    }
    problems.into_result(Some(()))?;
    let (copies, seed) = (plan.study.members, plan.study.seed);
    Ok(Sensitivity::of(&plan.title, inputs(plan), copies, seed, (outcome.to_string(), came), values))
}

/// The inputs of a design of blocks: the study's parameters, then what is uncertain in its scene.
fn inputs(plan: &SweepPlan) -> Vec<String> {
    let of_study = plan.study.parameters.iter().map(|varied| varied.path.clone());
    let uncertain = plan.scene["uncertain"].as_array().into_iter().flatten();
    of_study.chain(uncertain.filter_map(|varied| Some(varied["path"].as_str()?.to_owned()))).collect()
}

/// Writes all files of `sensitivity` to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, sensitivity: &Sensitivity, seed: u64) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let figure = Figure {
        name: "sensitivity".into(),
        title: "What matters".into(),
        words: format!("{}: {WORDS}", sensitivity.outcome),
        panels: sensitivity.of_outcome.iter().map(|shares| panel(&sensitivity.inputs, shares)).collect(),
    };
    let mut files = files::Together::begin();
    let drawn = page::draw(&mut files, out, vec![figure])?;
    let page = ResultPage {
        title: &sensitivity.title,
        kind: "sensitivity",
        lead: &lead(sensitivity),
        tables: tables(sensitivity),
        notes: NOTES.to_owned(),
        drawn: &drawn,
        provenance: &sensitivity.provenance,
        seed: Some(seed),
    }
    .html();
    files.write(&out.join("sensitivity.html"), |file| file.write_all(page.as_bytes()))?;
    // Last: it says that the rest is there.
    files.write(&out.join("sensitivity.json"), |file| results::as_json(file, sensitivity))?;
    files.appear()
}

/// The inputs of the outcome with most of its variance first.
fn ranked<'a>(
    inputs: &'a [String],
    shares: &'a OutputShares,
) -> Vec<(&'a str, VarianceShare, VarianceShare)> {
    let all = inputs.iter().zip(&shares.inputs);
    let mut all: Vec<_> = all.map(|(name, input)| (name.as_str(), input.alone, input.total)).collect();
    all.sort_by(|one, other| other.2.value.total_cmp(&one.2.value));
    all
}

fn interval(share: &VarianceShare) -> String {
    format!("{:.2} ({:.2} to {:.2})", share.value, share.interval_95[0], share.interval_95[1])
}

fn lead(sensitivity: &Sensitivity) -> String {
    let said = match &sensitivity.of_outcome {
        Some(shares) => format!("{}: {:.1} % of the members", sensitivity.outcome, 100.0 * shares.mean),
        None => format!("{}: the same for all, or too few blocks to tell", sensitivity.outcome),
    };
    format!("{} finished blocks of {} points. {said}.", sensitivity.blocks, sensitivity.inputs.len() + 2)
}

/// What matters, as text: the outcome, then numbers in which one input or another does something.
pub fn text(sensitivity: &Sensitivity) -> String {
    let mut text = format!("{}\n{}", sensitivity.title, lead(sensitivity));
    if let Some(shares) = &sensitivity.of_outcome {
        let mut rows = TextTable::new(&["input", "total share of the variance", "alone"]);
        for (name, alone, total) in ranked(&sensitivity.inputs, shares) {
            rows.add_row([name.to_owned(), interval(&total), interval(&alone)]);
        }
        let _ = write!(text, "\n{rows}");
    }
    text
}

fn panel(inputs: &[String], shares: &OutputShares) -> Panel {
    let ranked = ranked(inputs, shares);
    let mut marks = Vec::new();
    for (row, (_, _, total)) in ranked.iter().enumerate() {
        let (y, [low, high]) = (row as f64, total.interval_95);
        let (from, to) = ((0.0, y - 0.25), (total.value.max(0.0), y + 0.25));
        marks.push(Mark::Bar { from, to, colour: colour(0), opacity: 0.75, edge: true });
        for points in [
            vec![(low, y), (high, y)],
            vec![(low, y - 0.12), (low, y + 0.12)],
            vec![(high, y - 0.12), (high, y + 0.12)],
        ] {
            marks.push(Mark::Line { points, colour: INK, width: 1, dashed: false });
        }
    }
    let largest = ranked.iter().map(|(_, _, total)| total.interval_95[1]).fold(1.0, f64::max);
    let least = ranked.iter().map(|(_, _, total)| total.interval_95[0]).fold(0.0, f64::min);
    let names = ranked.iter().map(|(name, ..)| (*name).to_owned()).collect();
    let notes = ranked.iter().map(|(_, alone, _)| format!("alone {}", interval(alone))).collect();
    let x = Axis::fixed("share of the variance", least, 1.02 * largest);
    Panel { notes, ..Panel::of_rows("", names, x, 40, marks) }
}

/// A row a number, a column an input.
fn tables(sensitivity: &Sensitivity) -> String {
    let mut rows = String::new();
    let outcome = sensitivity.of_outcome.iter().map(|shares| (&sensitivity.outcome, shares));
    for (name, shares) in outcome.chain(&sensitivity.scalars) {
        let cells = shares
            .inputs
            .iter()
            .map(|input| format!("<td>{:.2} / {}</td>", input.alone.value, interval(&input.total)));
        let _ = writeln!(
            rows,
            "<tr><td>{}</td><td>{}</td><td>{} ± {}</td>{}</tr>",
            page::escape(name),
            shares.blocks,
            number(shares.mean),
            number(shares.deviation),
            cells.collect::<String>()
        );
    }
    let heads: String =
        sensitivity.inputs.iter().map(|name| format!("<th>{}</th>", page::escape(name))).collect();
    page::table(&format!("<th>number</th><th>blocks</th><th>mean ± deviation</th>{heads}"), &rows)
}
