//! A study of cost as a table, as rows and as a page: `cost.csv`, `cost.json`, `cost.html`, an SVG a figure.

pub mod figures;
mod others;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use comfy_table::{Cell, CellAlignment};

use super::files::{self, WriteError};
use super::page::{self, Figure, ResultPage};
use super::results;
use super::survival;
use super::table::number;
use super::text_table::TextTable;
use crate::study::cost::advice::{length, seconds};
use crate::study::cost::bench::LEFT_OUT;
use crate::study::cost::dials::{AS_WRITTEN, DialKind};
use crate::study::cost::errors::{Counts, Evaluation};
use crate::study::cost::verdicts::{Agreement, Verdicts};
use crate::study::cost::{MeasuredSetting, Study};

/// Columns of the page's table: name and unit.
const COLUMNS: [(&str, &str); 19] = [
    ("setting", ""),
    ("error of bullets", "before chaos"),
    ("", "to the horizon"),
    ("", "rms"),
    ("of knots", "rms"),
    ("time", "ms a second"),
    ("spread", "ms"),
    ("over as written", "×"),
    ("opening off by", "%"),
    ("tension off by", "%"),
    ("energy created", "of launch and work"),
    ("momentum", "of launch"),
    ("angular", "of scale"),
    ("pene\u{ad}tration", "µm"),
    ("cables through", ""),
    ("sub-steps", ""),
    ("rows", ""),
    ("detec\u{ad}tions", ""),
    ("contacts", ""),
];

/// What the test of survival is, for the page.
const HOLDING: &str = "How long it holds is compared by the log-rank test, a setting at a time against the finest, by dealing \
    members out anew 9999 times; a member that was never held counts as lost at once. p is the chance of a difference at \
    least as large were both alike; adjusted (Holm) it is that for all settings of the study together, and from 0.05 down a \
    setting is told apart. One that is not may still differ by less than so many members can tell.";

/// Writes all files of `study` to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, study: &Study) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let mut files = files::Together::begin();
    let drawn = page::draw(&mut files, out, figures::all(study))?;
    files.write(&out.join("cost.csv"), |file| rows(file, study))?;
    let page = whole_page(study, &drawn);
    files.write(&out.join("cost.html"), |file| file.write_all(page.as_bytes()))?;
    // Last: it says that the rest is there.
    files.write(&out.join("cost.json"), |file| results::as_json(file, study))?;
    files.appear()
}

/// A row a setting.
fn rows(file: impl std::io::Write, study: &Study) -> Result<(), csv::Error> {
    let mut rows = csv::Writer::from_writer(file);
    rows.write_record(CSV_COLUMNS.map(|(head, _)| head))?;
    for one in &study.settings {
        rows.write_record(CSV_COLUMNS.map(|(_, text)| text(one)))?;
    }
    rows.flush()?;
    Ok(())
}

/// A column of the table: its head, and what stands in it for a setting.
type CsvColumn = (&'static str, fn(&MeasuredSetting) -> String);

/// The columns of `cost.csv`; a number that was not measured is left empty.
#[rustfmt::skip] // a line a column
const CSV_COLUMNS: [CsvColumn; 37] = [
    ("family", |one| one.family.clone()),
    ("label", |one| one.label.clone()),
    ("value", |one| decimal(one.value)),
    ("step_s", |one| decimal(one.step_s)),
    ("on_front", |one| (!one.fronts.is_empty()).to_string()),
    ("cpu_s_per_s", |one| decimal(one.cost.map(|cost| cost.median))),
    ("cpu_least", |one| decimal(one.cost.map(|cost| cost.least))),
    ("cpu_most", |one| decimal(one.cost.map(|cost| cost.most))),
    ("repeats", |one| one.cost.map_or_else(String::new, |cost| cost.repeats.to_string())),
    ("bullets_rms_before_chaos_m", |one| of(one, |worth| Some(worth.apart.first()?.as_ref()?.bullets.rms_m))),
    ("bullets_max_before_chaos_m", |one| of(one, |worth| Some(worth.apart.first()?.as_ref()?.bullets.max_m))),
    ("bullets_rms_m", |one| of(one, |worth| Some(worth.apart.last()?.as_ref()?.bullets.rms_m))),
    ("bullets_max_m", |one| of(one, |worth| Some(worth.apart.last()?.as_ref()?.bullets.max_m))),
    ("knots_rms_m", |one| of(one, |worth| Some(worth.apart.last()?.as_ref()?.knots.rms_m))),
    ("knots_max_m", |one| of(one, |worth| Some(worth.apart.last()?.as_ref()?.knots.max_m))),
    ("max_area_m2", |one| of(one, |worth| Some(worth.deployment.max_area_m2))),
    ("deployment_time_s", |one| of(one, |worth| Some(worth.deployment.deployment_time_s))),
    ("travelling_distance_m", |one| of(one, |worth| Some(worth.deployment.travelling_distance_m))),
    ("effective_period_s", |one| of(one, |worth| Some(worth.deployment.effective_period_s))),
    ("max_tension_n", |one| of(one, |worth| Some(worth.max_tension_n))),
    ("momentum_residual", |one| of(one, |worth| Some(worth.conservation.momentum_residual))),
    ("angular_momentum_residual", |one| of(one, |worth| Some(worth.conservation.angular_momentum_residual))),
    ("energy_residual", |one| of(one, |worth| Some(worth.conservation.energy_residual))),
    ("energy_taken_by_solver", |one| of(one, |worth| worth.conservation.energy_taken_by_solver)),
    ("energy_created", |one| of(one, |worth| Some(worth.conservation.energy_created))),
    ("max_penetration_m", |one| of(one, |worth| Some(worth.ending?.max_penetration_m))),
    ("cables_through_target", |one| of(one, |worth| Some(worth.ending?.through as f64))),
    ("steps", |one| count(one, |counts| counts.steps)),
    ("substeps", |one| count(one, |counts| counts.substeps)),
    ("sweeps", |one| count(one, |counts| counts.sweeps)),
    ("rows", |one| count(one, |counts| counts.rows)),
    ("snaps", |one| count(one, |counts| counts.snaps)),
    ("detections", |one| count(one, |counts| counts.detections)),
    ("contacts", |one| count(one, |counts| counts.contacts)),
    ("without", |one| one.without.clone().unwrap_or_default()),
    ("warnings", |one| one.warnings.join("; ")),
    ("changes", |one| one.changes.join(" ")),
];

fn decimal(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| format!("{value:e}"))
}

fn of(one: &MeasuredSetting, value: fn(&Evaluation) -> Option<f64>) -> String {
    decimal(one.worth.as_ref().and_then(value))
}

fn count(one: &MeasuredSetting, value: fn(&Counts) -> u64) -> String {
    one.worth.as_ref().map_or_else(String::new, |worth| value(&worth.counts).to_string())
}

/// The study as text: the fronts, the distributions, the advice.
pub fn text(study: &Study) -> String {
    let windows = study.windows();
    let heads: Vec<String> = windows.iter().map(|window| format!("error to {:.2} s", window.end_s)).collect();
    let head = ["on a front"].into_iter().chain(heads.iter().map(String::as_str));
    let mut rows = TextTable::new(&head.chain(["time / s", "of as written"]).collect::<Vec<_>>());
    let written = study.settings.iter().find(|one| one.family == AS_WRITTEN);
    let written_cost = written.and_then(|one| one.cost).map_or(f64::NAN, |cost| cost.median);
    let mut shown: Vec<&MeasuredSetting> =
        study.settings.iter().filter(|one| !one.fronts.is_empty()).collect();
    shown.extend(written.filter(|one| one.fronts.is_empty()));
    shown.sort_by(|a, b| a.cost.map_or(0.0, |c| c.median).total_cmp(&b.cost.map_or(0.0, |c| c.median)));
    for one in shown {
        let cost = one.cost.map_or(f64::NAN, |cost| cost.median);
        let mut cells =
            vec![if one.fronts.is_empty() { format!("({})", one.label) } else { one.label.clone() }];
        cells.extend(windows.iter().enumerate().map(|(number, window)| {
            one.error(number).map_or_else(String::new, |error| at_least(error, window.floor_m))
        }));
        cells.extend([seconds(cost), number(cost / written_cost)]);
        let aligned = |(column, text): (usize, String)| {
            let alignment = if column == 0 { CellAlignment::Left } else { CellAlignment::Right };
            Cell::new(text).set_alignment(alignment)
        };
        rows.add_row(cells.into_iter().enumerate().map(aligned));
    }
    let mut text = format!("{}\n{rows}", study.title);
    for note in notes(study) {
        let _ = write!(text, "\n{note}");
    }
    if !study.verdicts.is_empty() {
        let _ = write!(text, "\n{}", after_contact(study));
    }
    let _ = write!(text, "\n{}", study.advice.sentence);
    text
}

/// The distributions after contact, a row a setting.
fn after_contact(study: &Study) -> TextTable {
    let has_curves = study.verdicts.iter().any(|one| one.survival.is_some());
    let mut head = vec!["after contact", "captured", "quality", "time / s", "agrees"];
    if has_curves {
        head.extend(["still held", "p of log-rank"]);
    }
    let mut rows = TextTable::new(&head);
    for verdicts in &study.verdicts {
        let agrees = match verdicts.agreement {
            Agreement::Finest => "the finest",
            Agreement::Agrees => "yes",
            Agreement::Differs => "no",
            Agreement::TooFew => "too few to tell",
        };
        let mut cells = vec![
            verdicts.label.clone(),
            format!("{} of {}", verdicts.captured.captured, verdicts.captured.of),
            number(verdicts.cqi[1].value),
            seconds(verdicts.cost),
            agrees.to_owned(),
        ];
        if has_curves {
            cells.extend([still_held(verdicts), test_in_words(verdicts)]);
        }
        rows.add_row(cells);
    }
    rows
}

/// Share still held at the end of the curve.
fn still_held(verdicts: &Verdicts) -> String {
    let curve = verdicts.survival.as_ref().and_then(|curve| Some((curve, curve.steps.last()?)));
    curve.map_or_else(
        || "never held".to_owned(),
        |(curve, last)| format!("{:.0} % after {:.1} s", 100.0 * last.share, curve.until_s),
    )
}

/// What the test says of a curve and the finest's.
fn test_in_words(verdicts: &Verdicts) -> String {
    verdicts.holding.map_or_else(
        || "–".to_owned(),
        |test| {
            let apart = if test.told_apart() { ": another" } else { "" };
            let [members, _] = test.members;
            format!("{} (n = {members}, adjusted {}{apart})", number(test.p), number(test.adjusted_p))
        },
    )
}

/// The curves of survival as rows of the page; nothing where there are none.
fn curves_table(study: &Study) -> String {
    if study.verdicts.iter().all(|one| one.survival.is_none()) {
        return String::new();
    }
    let heads = ["setting", "how long it holds", "log-rank against the finest"];
    let head: String = heads.iter().map(|name| format!("<th>{name}</th>")).collect();
    let mut rows = String::new();
    for one in &study.verdicts {
        let curve = one.survival.as_ref().map_or_else(|| "never held".to_owned(), survival::words);
        let cells = [one.label.clone(), curve, test_in_words(one)];
        let cells: String = cells.iter().map(|cell| format!("<td>{}</td>", page::escape(cell))).collect();
        let _ = writeln!(rows, "<tr>{cells}</tr>");
    }
    page::table(&head, &rows)
}

/// An error in words, or that it is at the floor.
fn at_least(error: f64, floor: f64) -> String {
    if error > floor { length(error) } else { format!("below {}", length(floor)) }
}

/// What the tables leave out, a line each.
fn notes(study: &Study) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(quality) = &study.reference {
        let contact =
            quality.first_contact_s.map_or_else(String::new, |t| format!(" (first contact at {t:.3} s)"));
        let ends: Vec<String> = quality
            .windows
            .iter()
            .map(|window| {
                format!(
                    "to {:.2} s ({}; below {} chaos hides them)",
                    window.end_s,
                    window.name,
                    length(window.floor_m)
                )
            })
            .collect();
        notes.push(format!(
            "Errors are the largest distance of a bullet from the reference, {}{contact}. The references agree within {} \
             until {:.2} s.",
            ends.join(" and "),
            length(quality.trust_distance_m),
            quality.horizon_s
        ));
    } else {
        notes.push(
            "No reference: the budget did not suffice for one, so there are times and no errors.".to_owned(),
        );
    }
    notes.extend(beyond_the_budget(study));
    for order in &study.orders {
        notes.push(format!(
            "Observed order of convergence, {}: {:.1} over {} steps.",
            order.family, order.order, order.steps
        ));
    }
    notes.extend(study.advice.warnings.iter().map(|warning| format!("Turned the wrong way: {warning}.")));
    notes.extend(without(study));
    notes
}

/// What of the study the budget did not pay for as a whole, a line each.
fn beyond_the_budget(study: &Study) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(until) = study.measured_until_s {
        let written = study.written_cost.map_or_else(
            || "one of the scene as written was ended, too".to_owned(),
            |cost| format!("as written one costs {} per simulated second", seconds(cost)),
        );
        notes.push(format!(
            "Settings are run until {until:.2} s only, and times are those of that flight: a budget of {} does not pay for \
             enough runs to the scene's end ({written}).",
            seconds(study.request.budget_s)
        ));
    }
    if study.verdicts.is_empty() && study.settings.iter().any(|one| one.kind == DialKind::Contact) {
        notes.push(
            "No distributions after contact: what was left does not pay for two members of two settings."
                .to_owned(),
        );
    }
    notes
}

/// What has no numbers: each refusal and failure in a line, what the budget did not cover in one for all.
fn without(study: &Study) -> Vec<String> {
    let without = study.settings.iter().filter_map(|one| Some((one, one.without.as_ref()?)));
    let (left_out, others): (Vec<_>, Vec<_>) = without.partition(|(_, why)| why.starts_with(LEFT_OUT));
    let mut lines: Vec<String> = others.iter().map(|(one, why)| format!("{} {why}.", one.label)).collect();
    if !left_out.is_empty() {
        let labels: Vec<&str> = left_out.iter().map(|(one, _)| one.label.as_str()).collect();
        lines.push(format!(
            "Left out, beyond a budget of {}: {}.",
            seconds(study.request.budget_s),
            labels.join(", ")
        ));
    }
    lines
}

/// The page: advice, table and figures, everything within one file.
fn whole_page(study: &Study, drawn: &[(Figure, String)]) -> String {
    let mut head = String::new();
    for (name, unit) in COLUMNS {
        let _ = write!(head, "<th>{name} <small>{unit}</small></th>");
    }
    let mut rows = String::new();
    let mut family = "";
    for one in study.settings.iter().filter(|one| one.cost.is_some()) {
        if one.family != family {
            family = &one.family;
            let head = page::escape(family);
            let _ = writeln!(rows, "<tr class=\"family\"><td colspan=\"{}\">{head}</td></tr>", COLUMNS.len());
        }
        let cells: String =
            cells(study, one).iter().map(|cell| format!("<td>{}</td>", page::escape(cell))).collect();
        let class = if !one.fronts.is_empty() { " class=\"front\"" } else { "" };
        let _ = writeln!(rows, "<tr{class}>{cells}</tr>");
    }
    let mut said = vec![
        "Bold: on a front. Time is processor time of one thread per simulated second, median over the repeats; counts \
         are exact and the same on every machine. A change of the model (middle knots, effects) has a difference \
         from the reference, not an error."
            .to_owned(),
        "The engine is built with `enhanced-determinism`, so that a run has the same bits on every platform. That is \
         decided when the program is compiled and is in all of these times; it costs 0.1 % (1.956e9 instructions \
         against 1.953e9 without, over the first 0.95 s of `cubesat-free`)."
            .to_owned(),
    ];
    if study.advice.for_holding.is_some() {
        said.push(HOLDING.to_owned());
    }
    said.extend(notes(study));
    ResultPage {
        title: &study.title,
        kind: "what accuracy costs",
        lead: &study.advice.sentence,
        tables: page::table(&head, &rows) + &curves_table(study),
        notes: said.iter().map(|note| format!("<p>{}</p>\n", page::escape(note))).collect(),
        drawn,
        provenance: &study.provenance,
        seed: Some(study.request.seed),
    }
    .html()
}

/// The cells of a setting that was measured.
fn cells(study: &Study, one: &MeasuredSetting) -> Vec<String> {
    let none = || "–".to_owned();
    let written = study.settings.iter().find(|one| one.family == AS_WRITTEN).and_then(|one| one.cost);
    let (Some(cost), Some(worth)) = (one.cost, &one.worth) else { return vec![one.label.clone()] };
    let off = |name: &str, value: f64| {
        let quartiles = study.reference.as_ref()?.scalars.get(name)?;
        (quartiles.median != 0.0).then(|| 100.0 * (value / quartiles.median - 1.0).abs())
    };
    let opening = [
        off("max_area_m2", worth.deployment.max_area_m2),
        off("deployment_time_s", worth.deployment.deployment_time_s),
        off("travelling_distance_m", worth.deployment.travelling_distance_m),
        off("effective_period_s", worth.deployment.effective_period_s),
    ];
    let opening = opening
        .into_iter()
        .flatten()
        .fold(None, |most: Option<f64>, off| Some(most.map_or(off, |m| m.max(off))));
    let shown = |error: f64, floor: f64| {
        if one.kind == DialKind::Model { length(error) } else { at_least(error, floor) }
    };
    let windows = study.windows();
    let last = windows.len().wrapping_sub(1);
    let bullets = |window: usize| -> String {
        let floor = windows.get(window).map_or(0.0, |window| window.floor_m);
        one.error(window).map_or_else(none, |error| shown(error, floor))
    };
    let apart = worth.apart.last().copied().flatten();
    let short = |value: f64| if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}") };
    let percent = |value: Option<f64>| value.map_or_else(none, |value| format!("{value:.2}"));
    let kept = &worth.conservation;
    let counts = &worth.counts;
    let ending = worth.ending;
    vec![
        one.label.clone(),
        bullets(0),
        bullets(last),
        apart.map_or_else(none, |apart| length(apart.bullets.rms_m)),
        apart.map_or_else(none, |apart| length(apart.knots.rms_m)),
        number(1e3 * cost.median),
        if cost.repeats > 1 {
            format!("{} to {}", number(1e3 * cost.least), number(1e3 * cost.most))
        } else {
            "one run".to_owned()
        },
        written.map_or_else(none, |written| format!("{:.2}", cost.median / written.median)),
        percent(opening),
        percent(off("max_tension_n", worth.max_tension_n)),
        short(kept.energy_created),
        short(kept.momentum_residual),
        short(kept.angular_momentum_residual),
        ending.map_or_else(none, |ending| format!("{:.1}", 1e6 * ending.max_penetration_m)),
        ending.map_or_else(none, |ending| ending.through.to_string()),
        counts.substeps.to_string(),
        counts.rows.to_string(),
        counts.detections.to_string(),
        counts.contacts.to_string(),
    ]
}
