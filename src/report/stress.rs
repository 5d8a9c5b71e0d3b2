//! The catalogue of hard cases as a table, as a page for the README, and as files: `stress.json`, `stress.csv`.

use std::path::Path;

use comfy_table::{Cell, CellAlignment};

use super::files::{self, WriteError};
use super::page::{self, escape};
use super::results;
use super::text_table::TextTable;
use crate::study::stress::hard::StressCase;
use crate::study::stress::measure::{Measured, Numbers};
use crate::study::stress::{Stress, StressRow, StressVerdict};

/// A verdict in a word or two.
pub fn word(verdict: StressVerdict) -> &'static str {
    match verdict {
        StressVerdict::Holds => "holds",
        StressVerdict::Refused => "refused",
        StressVerdict::HoldsFrom => "holds from",
        StressVerdict::DoesNotHold => "does not hold",
        StressVerdict::NotRun => "not run",
        StressVerdict::Breaks => "BREAKS",
    }
}

/// Writes `stress.csv`, `stress.md` and, last, `stress.json` to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, stress: &Stress) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let mut files = files::Together::begin();
    files.write(&out.join("stress.csv"), |file| csv(stress, file))?;
    let page = markdown(stress);
    files.write(&out.join("stress.md"), |file| std::io::Write::write_all(file, page.as_bytes()))?;
    files.write(&out.join("stress.json"), |file| results::as_json(file, stress))?;
    files.appear()
}

fn csv(stress: &Stress, file: impl std::io::Write) -> csv::Result<()> {
    let mut rows = csv::Writer::from_writer(file);
    let names = Numbers::BOUNDS.each().map(|(name, _)| name.replace(' ', "_"));
    let mut head = vec!["theme".to_owned(), "case".into(), "pair".into(), "verdict".into(), "run".into()];
    head.extend(["step_s", "steps", "contacts", "wall_s"].map(str::to_owned));
    head.extend(names.iter().cloned());
    head.extend(names.iter().map(|name| format!("{name}_bound")));
    head.extend(["failure", "notes"].map(str::to_owned));
    rows.write_record(&head)?;
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:e}"));
    for row in &stress.rows {
        let as_it_is = row.as_it_is().map(|run| ("as it is", Some(run)));
        let others = [("half step", row.halved.as_ref()), ("at limit", row.at_limit.as_ref())];
        let ran: Vec<(&str, Option<&Measured>)> =
            as_it_is.chain(others.into_iter().filter(|(_, run)| run.is_some())).collect();
        // What did not run has a line, too.
        for (name, run) in if ran.is_empty() { vec![("", None)] } else { ran } {
            let mut line = vec![row.theme.clone(), row.case.clone(), row.pair.clone()];
            line.extend([word(row.verdict).to_owned(), name.to_owned()]);
            line.extend([
                number(run.map(|run| run.step_s)),
                run.map_or(String::new(), |run| run.steps.to_string()),
                run.map_or(String::new(), |run| run.contacts.to_string()),
                number(run.map(|run| run.wall_s)),
            ]);
            let numbers = run.map_or(Numbers::default(), |run| run.numbers);
            line.extend(numbers.each().map(|(_, value)| number(value)));
            line.extend(row.bounds.each().map(|(_, value)| number(value)));
            line.push(run.and_then(|run| run.failure.clone()).unwrap_or_default());
            line.push(row.notes.join("; "));
            rows.write_record(&line)?;
        }
    }
    rows.flush()?;
    Ok(())
}

/// Cases by pairs, with every number of every run.
pub fn text(stress: &Stress) -> String {
    let names = Numbers::BOUNDS.each().map(|(name, _)| name);
    let heads = [&["case", "pair", "verdict", "step\ns"], &names[..], &["time\ns"]].concat();
    let heads: Vec<String> = heads.iter().map(|head| head.replace("angular ", "angular\n")).collect();
    let mut rows = TextTable::new(&heads.iter().map(String::as_str).collect::<Vec<_>>());
    for row in &stress.rows {
        let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
        let mut cells = vec![Cell::new(&row.case), Cell::new(&row.pair), Cell::new(word(row.verdict))];
        cells.push(right(row.measured.as_ref().map_or(String::new(), |run| format!("{:.1e}", run.step_s))));
        let worst = worst(row);
        cells.extend(worst.each().map(|(_, value)| right(value.map_or(String::new(), short))));
        cells.push(right(format!("{:.1}", row.wall())));
        rows.add_row(cells);
    }
    format!("{rows}\n{}\n{}", bounds(stress), notes(stress).join("\n"))
}

/// The largest of each number over a row's runs and the one at half the step.
fn worst(row: &StressRow) -> Numbers {
    row.as_it_is().chain(&row.halved).map(|run| run.numbers).reduce(Numbers::worst).unwrap_or_default()
}

fn short(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}") }
}

/// What must hold, where a case says nothing else.
fn bounds(stress: &Stress) -> String {
    let words = |(name, bound): (&str, Option<f64>)| bound.map(|bound| format!("{name} {}", short(bound)));
    let common: Vec<String> = Numbers::BOUNDS.each().into_iter().filter_map(words).collect();
    let others: Vec<String> = stress
        .rows
        .iter()
        .filter(|row| {
            Some(&row.pair) == stress.rows.first().map(|first| &first.pair) && row.bounds != Numbers::BOUNDS
        })
        .map(|row| {
            let own = row.bounds.each().into_iter().zip(Numbers::BOUNDS.each());
            let own: Vec<String> =
                own.filter(|(own, common)| own != common).filter_map(|(own, _)| words(own)).collect();
            format!("{}: {}", row.case, own.join(", "))
        })
        .collect();
    let others = if others.is_empty() { String::new() } else { format!(" ({})", others.join("; ")) };
    format!("At most: {}{others}. No state that is not a number, no body set aside.", common.join(", "))
}

/// A line for each row that does not simply hold, and one that counts.
fn notes(stress: &Stress) -> Vec<String> {
    let mut notes: Vec<String> = stress
        .rows
        .iter()
        .filter(|row| row.verdict != StressVerdict::Holds)
        .map(|row| format!("{} {}: {}: {}", row.case, row.pair, word(row.verdict), row.notes.join("; ")))
        .collect();
    notes.push(count(stress));
    notes
}

/// The pairs, in the order of the rows.
fn pairs(stress: &Stress) -> Vec<&str> {
    let mut pairs: Vec<&str> = Vec::new();
    for row in &stress.rows {
        if !pairs.contains(&row.pair.as_str()) {
            pairs.push(&row.pair);
        }
    }
    pairs
}

/// Verdicts by pairs, and what does not hold with its reason, as HTML.
pub fn html(stress: &Stress) -> String {
    let pairs = pairs(stress);
    let head = KINDS.map(|kind| format!("<th>{}</th>", word(kind))).concat();
    let mut rows = String::new();
    for pair in pairs {
        let of = |kind| stress.rows.iter().filter(|row| row.pair == pair && row.verdict == kind).count();
        let cells = KINDS.map(|kind| format!("<td>{}</td>", of(kind))).concat();
        rows += &format!("<tr><td>{}</td>{cells}</tr>\n", escape(pair));
    }
    let mut html = page::table(&format!("<th>pair</th>{head}"), &rows);
    let fails = |row: &&StressRow| matches!(row.verdict, StressVerdict::DoesNotHold | StressVerdict::Breaks);
    let mut failing = String::new();
    for row in stress.rows.iter().filter(fails) {
        let cells = [&row.case, &row.pair].map(|text| format!("<td>{}</td>", escape(text))).concat();
        let why = escape(&row.notes.join("; "));
        failing += &format!("<tr>{cells}<td>{}</td><td class=\"words\">{why}</td></tr>\n", word(row.verdict));
    }
    if !failing.is_empty() {
        html +=
            &page::table("<th>case</th><th>pair</th><th>verdict</th><th class=\"words\">why</th>", &failing);
    }
    html + &format!("<div class=\"notes\"><p>{}</p></div>\n", escape(&bounds(stress)))
}

/// Verdicts, the best first.
const KINDS: [StressVerdict; 6] = [
    StressVerdict::Holds,
    StressVerdict::Refused,
    StressVerdict::HoldsFrom,
    StressVerdict::DoesNotHold,
    StressVerdict::NotRun,
    StressVerdict::Breaks,
];

/// How many of each verdict, and the time.
pub fn count(stress: &Stress) -> String {
    let of = |verdict: StressVerdict| stress.rows.iter().filter(|row| row.verdict == verdict).count();
    let counts: Vec<String> = KINDS
        .into_iter()
        .filter(|&kind| of(kind) > 0)
        .map(|kind| format!("{} {}", of(kind), word(kind)))
        .collect();
    let wall: f64 = stress.rows.iter().map(StressRow::wall).sum();
    format!("{} rows: {}; {wall:.0} s of one core.", stress.rows.len(), counts.join(", "))
}

/// A table for the README: cases by pairs.
pub fn markdown(stress: &Stress) -> String {
    let pairs = pairs(stress);
    let mut text =
        format!("| theme | case | {} |\n|---|---|{}\n", pairs.join(" | "), "---|".repeat(pairs.len()));
    let mut reasons: Vec<String> = Vec::new();
    for rows in stress.rows.chunk_by(|a, b| a.case == b.case) {
        let cells: Vec<String> = rows.iter().map(|row| cell(row, &mut reasons)).collect();
        text += &format!("| {} | {} | {} |\n", rows[0].theme, rows[0].case, cells.join(" | "));
    }
    text += "\n";
    for (number, reason) in reasons.iter().enumerate() {
        text += &format!("{}. {reason}\n", number + 1);
    }
    text += &format!("\n{}\n{}\n", bounds(stress), count(stress));
    text
}

/// A verdict with the number of its reason, which several cells may share.
fn cell(row: &StressRow, reasons: &mut Vec<String>) -> String {
    let word = word(row.verdict);
    if row.verdict == StressVerdict::Holds {
        return word.to_owned();
    }
    let reason = match (row.verdict, row.notes.as_slice()) {
        // The reason that the case gives, and the limit at the end.
        (StressVerdict::HoldsFrom, [why, .., limit]) => format!("{why}; {limit}"),
        (_, [why, ..]) => why.clone(),
        (_, []) => return word.to_owned(),
    };
    let number = reasons.iter().position(|known| *known == reason).unwrap_or_else(|| {
        reasons.push(reason);
        reasons.len() - 1
    });
    format!("{word} ({})", number + 1)
}

/// The cases and why each is hard.
pub fn list(cases: &[StressCase]) -> String {
    let mut rows = TextTable::new(&["theme", "case", "why it is hard"]);
    for case in cases {
        rows.add_row([case.theme.title(), case.name, case.why]);
    }
    rows.to_string()
}
