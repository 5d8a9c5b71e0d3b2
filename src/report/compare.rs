//! A comparison as a table, as figures and as a page: `compare.json`, `compare.html` and an SVG a figure.

pub mod figures;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use comfy_table::{Cell, CellAlignment};

use super::files::{self, WriteError};
use super::page::{self, Figure, ResultPage};
use super::results;
use super::table::number;
use super::text_table::TextTable;
use crate::effects::Effects;
use crate::effects::blocks::SummaryRow;
use crate::study::compare::{Comparison, Outcome};
use crate::study::ensemble::Share;
use crate::study::survival::Survival;
use crate::study::sweep::dependency::DEPLOYMENT;
use figures::timing;

/// A column: name, in two lines for a terminal, and unit.
type Column = (&'static str, &'static str);

/// Columns of the table.
const COLUMNS: [Column; 14] = [
    ("variant", ""),
    ("captured", ""),
    ("settled,\nlost", ""),
    ("still\nheld", "%"),
    ("first\ncontact", "s"),
    ("push", "mm"),
    ("largest\nimpulse", "mN s"),
    ("pene-\ntration", "µm"),
    ("bullet\ndifference", "mm"),
    ("of\ntravel", "%"),
    ("over\nchaos", "×"),
    ("trusted\nuntil", "s"),
    ("wall\ntime", "s"),
    ("over\nbase", "×"),
];

/// Columns of the table of an effect, before its own; the first is headed by its name.
const EFFECT_COLUMNS: [Column; 4] =
    [("captured", "95 %"), ("held\none turn", ""), ("held when\ntested", ""), ("mouth at\nthe end", "%")];

/// Columns of the table of nets that fly free (Section 3.2.3), and of what a sub-step costs (Table 3.5).
const FLIGHT_COLUMNS: [Column; 8] = [
    ("deployment", ""),
    ("largest\narea", "m²"),
    ("deployment\ntime", "s"),
    ("travelling\ndistance", "m"),
    ("effective\nperiod", "s"),
    ("sub-steps", ""),
    ("wall time of\na sub-step", "µs"),
    ("over\nbase", "×"),
];

/// Writes all files of `comparison` to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, comparison: &Comparison) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let mut files = files::Together::begin();
    let drawn = page::draw(&mut files, out, figures::all(comparison))?;
    let page = whole_page(comparison, &drawn);
    files.write(&out.join("compare.html"), |file| file.write_all(page.as_bytes()))?;
    // Last: it says that the rest is there.
    files.write(&out.join("compare.json"), |file| results::as_json(file, comparison))?;
    files.appear()
}

/// The comparison as text.
pub fn text(comparison: &Comparison) -> String {
    let mut text = format!("{}\n{}", comparison.title, text_table(&COLUMNS, cells(comparison)));
    for (columns, cells) in more_tables(comparison) {
        text.push_str(&format!("\n{}", text_table(&columns, cells)));
    }
    for note in notes(comparison) {
        text.push('\n');
        text.push_str(&note);
    }
    text
}

fn text_table(columns: &[Column], cells: Vec<Vec<String>>) -> TextTable {
    // Units in one line, below names of one or two.
    let head =
        |(name, unit): &Column| format!("{name}{}{unit}", if name.contains('\n') { "\n" } else { "\n\n" });
    let heads: Vec<String> = columns.iter().map(|column| head(column).trim_end().to_owned()).collect();
    let mut rows = TextTable::new(&heads.iter().map(String::as_str).collect::<Vec<_>>());
    for row in cells {
        rows.add_row(row.into_iter().enumerate().map(|(column, text)| {
            let alignment = if column == 0 { CellAlignment::Left } else { CellAlignment::Right };
            Cell::new(text).set_alignment(alignment)
        }));
    }
    rows
}

/// The table's cells, a row a variant.
fn cells(comparison: &Comparison) -> Vec<Vec<String>> {
    let row = |variant: &crate::study::compare::Compared| {
        let mut row = vec![variant.label.clone()];
        match &variant.outcome {
            Some(outcome) => row.extend(outcome_cells(outcome)),
            None if variant.refused.is_empty() => row.push("failed".to_owned()),
            None => row.push("refused".to_owned()),
        }
        row.resize(COLUMNS.len(), String::new());
        row
    };
    comparison.variants.iter().map(row).collect()
}

/// Tables beside the first, those that say anything.
fn more_tables(comparison: &Comparison) -> Vec<(Vec<Column>, Vec<Vec<String>>)> {
    let flight = (FLIGHT_COLUMNS.to_vec(), flight_cells(comparison));
    let effects = Effects::NAMES.iter().map(|name| effect_table(comparison, name));
    std::iter::once(flight).chain(effects).filter(|(_, cells)| !cells.is_empty()).collect()
}

/// The cells of the table of free flights; none where a variant has a target.
fn flight_cells(comparison: &Comparison) -> Vec<Vec<String>> {
    if comparison.ran().any(|(_, _, outcome)| outcome.captured.is_some()) {
        return Vec::new();
    }
    let cost = |outcome: &Outcome| Some(outcome.median("wall_s")? / outcome.median("work.substeps")?);
    let of_base = comparison.base().and_then(cost);
    let row = |(_, variant, outcome): (usize, &crate::study::compare::Compared, &Outcome)| {
        let shown = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), number);
        let cost = cost(outcome);
        let parameters = DEPLOYMENT.map(|name| shown(outcome.median(name)));
        let over_base = cost.zip(of_base).map(|(cost, base)| cost / base);
        let short = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), short);
        let costs = [shown(outcome.median("work.substeps")), short(cost.map(|s| 1e6 * s)), short(over_base)];
        std::iter::once(variant.label.clone()).chain(parameters).chain(costs).collect()
    };
    comparison.ran().map(row).collect()
}

/// How captures fared beside what the effect called `name` says of them; no cells when it says nothing in any variant.
fn effect_table(comparison: &Comparison, name: &'static str) -> (Vec<Column>, Vec<Vec<String>>) {
    let own: Vec<&SummaryRow> = Effects::rows(name).iter().filter(|row| !row.head.is_empty()).collect();
    let row = |(_, variant, outcome): (usize, &crate::study::compare::Compared, &Outcome)| {
        let median = |name: &str, factor: f64| {
            outcome.median(name).map_or_else(|| "–".to_owned(), |value| short(factor * value))
        };
        let counted = |share: Option<Share>| {
            share.map_or_else(|| "–".to_owned(), |share| format!("{} of {}", share.captured, share.of))
        };
        let captured = outcome.captured.map_or_else(
            || "–".to_owned(),
            |share| {
                let [low, high] = share.interval_95.map(|bound| 100.0 * bound);
                format!("{} of {} ({low:.0}–{high:.0})", share.captured, share.of)
            },
        );
        let [held_turn, held_trial] = [outcome.held_turn, outcome.held_trial].map(counted);
        let first = [variant.label.clone(), captured, held_turn, held_trial, median("capture.mouth", 100.0)];
        first
            .into_iter()
            .chain(own.iter().map(|row| median(&format!("{name}.{}", row.key), row.scale)))
            .collect::<Vec<String>>()
    };
    let says =
        |outcome: &Outcome| own.iter().any(|row| outcome.median(&format!("{name}.{}", row.key)).is_some());
    let has_any = comparison.ran().any(|(_, _, outcome)| says(outcome));
    let columns =
        std::iter::once((name, "")).chain(EFFECT_COLUMNS).chain(own.iter().map(|row| (row.head, row.unit)));
    (columns.collect(), if has_any { comparison.ran().map(row).collect() } else { Vec::new() })
}

/// Share still held at the end of the curve, of those ever held, with its band [%].
fn still_held(survival: &Survival) -> String {
    survival.steps.last().map_or_else(String::new, |step| {
        let [low, high] = step.band_95.map(|bound| 100.0 * bound);
        format!("{:.0} ({low:.0}–{high:.0})", 100.0 * step.share)
    })
}

fn outcome_cells(outcome: &Outcome) -> Vec<String> {
    let none = || "–".to_owned();
    let median =
        |name: &str, factor: f64| outcome.median(name).map_or_else(none, |value| short(factor * value));
    let mut cells = vec![
        outcome.captured.map_or_else(none, |share| format!("{} of {}", share.captured, share.of)),
        outcome.survival.as_ref().map_or_else(none, |s| format!("{}, {}", s.settled, s.lost)),
        outcome.survival.as_ref().map_or_else(none, still_held),
        median("contact.first_contact_s", 1.0),
        median("target.displacement_m.0", 1e3),
        median("contact.max_impulse_n_s", 1e3),
        median("contact.max_penetration_m", 1e6),
    ];
    // The base in brackets: its members among themselves.
    let against = outcome.against_base.as_ref();
    let separation = against.map(|against| &against.separation).or(outcome.own.as_ref());
    let bracket = |text: String| if against.is_some() { text } else { format!("({text})") };
    match separation {
        Some(separation) => {
            let whole = &separation.whole;
            let horizon = &separation.trust_horizon;
            cells.push(bracket(short(1e3 * whole.all_m.mean)));
            cells.push(whole.mean_over_travel.map_or_else(none, |share| bracket(short(100.0 * share))));
            cells.push(against.and_then(|against| against.over_chaos).map_or_else(none, short));
            cells.push(bracket(if horizon.to_the_end {
                "the end".to_owned()
            } else {
                short(horizon.time_s)
            }));
        }
        None => cells.extend([none(), none(), none(), none()]),
    }
    cells.push(median("wall_s", 1.0));
    cells.push(against.map_or_else(|| "1".to_owned(), |against| short(against.wall_over_base)));
    cells
}

/// Four digits at most, and no zeros that say nothing: for numbers within a sentence.
fn plain(value: f64) -> String {
    let text = number(value);
    let (digits, power) = text.split_at(text.find('e').unwrap_or(text.len()));
    if !digits.contains('.') {
        return text;
    }
    digits.trim_end_matches('0').trim_end_matches('.').to_owned() + power
}

/// Three digits: a table of medians over a few members has no more.
fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !(1e-3..1e6).contains(&size) {
        return number(value);
    }
    format!("{value:.*}", (2.0 - size.log10().floor()).max(0.0) as usize)
}

/// What the table leaves out, a line each.
fn notes(comparison: &Comparison) -> Vec<String> {
    let request = &comparison.request;
    let plural = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
    let mut notes = vec![format!(
        "Medians of {} whose folded knots differ by up to {} m. Differences are from {}, member by member; in brackets \
         its own members among themselves: chaos. Trusted while the largest bullet difference stays below {} mm. {}",
        plural(request.ensemble.members, "member"),
        plain(request.ensemble.perturb_m),
        comparison.base,
        plain(1e3 * request.trust_distance_m),
        timing(comparison)
    )];
    notes.push(
        "Still held: of the members ever held, by Kaplan and Meier with the 95 % band, where the longest of them ended; \
         a member that settled counts as held, one that ended undecided as neither."
            .to_owned(),
    );
    for variant in &comparison.variants {
        notes.extend(variant.refused.iter().map(|reason| format!("{} is refused: {reason}", variant.label)));
        // One failure says what is wrong, and all alike are one.
        if let Some((member, failure)) = variant.failures.iter().next() {
            let count = plural(variant.failures.len(), "member");
            notes.push(format!("{}: {count} failed; member {member}: {failure}", variant.label));
        }
    }
    notes
}

/// How many members captured, variants that are alike together; empty where nothing is captured or missed.
fn lead(comparison: &Comparison) -> String {
    let mut alike: Vec<(String, Vec<&str>)> = Vec::new();
    for (label, captured) in comparison
        .variants
        .iter()
        .filter_map(|variant| Some((variant.label.as_str(), variant.outcome.as_ref()?.captured?)))
    {
        let share = format!("{} of {}", captured.captured, captured.of);
        match alike.iter_mut().find(|(known, _)| *known == share) {
            Some((_, labels)) => labels.push(label),
            None => alike.push((share, vec![label])),
        }
    }
    match &alike[..] {
        [] => String::new(),
        [(share, labels)] if labels.len() > 1 => {
            format!("Captured {share} in each of {} variants.", labels.len())
        }
        _ => {
            let words = alike.iter().map(|(share, labels)| format!("{share} with {}", labels.join(", ")));
            format!("Captured {}.", words.collect::<Vec<_>>().join("; "))
        }
    }
}

/// The page: table and figures, everything within one file.
fn whole_page(comparison: &Comparison, drawn: &[(Figure, String)]) -> String {
    let tables = std::iter::once((COLUMNS.to_vec(), cells(comparison))).chain(more_tables(comparison));
    let tables: String = tables.map(|(columns, cells)| page_table(&columns, &cells)).collect();
    let notes: String =
        notes(comparison).iter().map(|note| format!("<p>{}</p>\n", page::prose(note))).collect();
    ResultPage {
        title: &comparison.title,
        kind: "comparison",
        lead: &lead(comparison),
        tables,
        notes: notes + &watching(comparison),
        drawn,
        provenance: &comparison.provenance,
        seed: Some(comparison.request.ensemble.seed),
    }
    .html()
}

/// How each variant's members ended, by number, and the command that shows one.
fn watching(comparison: &Comparison) -> String {
    let mut rows = String::new();
    for (_, variant, outcome) in comparison.ran().filter(|(_, variant, _)| !variant.again.is_empty()) {
        let mut members: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for ended in &outcome.verdicts {
            members.entry(ended.verdict.words()).or_default().push(ended.member.to_string());
        }
        let ended: Vec<String> =
            members.iter().map(|(words, members)| format!("{words}: {}", members.join(", "))).collect();
        let [label, ended, again] =
            [&variant.label, &ended.join("; "), &variant.again].map(|text| page::escape(text));
        let _ = writeln!(
            rows,
            "<tr><td>{label}</td><td>{ended}</td><td><code>{again} --member N</code></td></tr>"
        );
    }
    if rows.is_empty() {
        return rows;
    }
    page::table("<th>variant</th><th>members</th><th>to watch one</th>", &rows)
}

fn page_table(columns: &[Column], cells: &[Vec<String>]) -> String {
    let mut head = String::new();
    for (name, unit) in columns {
        let unit = if unit.is_empty() { String::new() } else { format!("<small>{unit}</small>") };
        let name = name.replace("-\n", "\u{ad}").replace('\n', " ");
        let _ = write!(head, "<th>{name} {unit}</th>");
    }
    let mut rows = String::new();
    for row in cells {
        // A long label breaks between its keys.
        let label = page::escape(&row[0]).replace('.', ".<wbr>");
        let cells: String = row[1..].iter().map(|cell| format!("<td>{}</td>", page::escape(cell))).collect();
        let cells = format!("<td>{label}</td>{cells}");
        let _ = writeln!(rows, "<tr>{cells}</tr>");
    }
    page::table(&head, &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_the_table_are_short() {
        assert_eq!([0.12345, 12.345, 1234.5, 1e-7].map(short), ["0.123", "12.3", "1234", "1.000e-7"]);
        assert_eq!([7.0, 1e-6, 1.25e-5, 120.0, 0.0].map(plain), ["7", "1e-6", "1.25e-5", "120", "0"]);
    }
}
