//! Results of many kinds in one page: `report.html`.
//!
//! What was found stands first: a row a run with its verdict, a line for every other result, and survival. Then each result
//! with its figures and the command that made it. [`part`] says what each kind of result brings.

pub mod part;

use std::collections::HashSet;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::files::{self, WriteError};
use super::page::{self, Figure, ResultPage, escape};
use super::plots::MOST_PENS;
use super::survival::{self, Named};
use super::table::number;
use crate::metrics::summary::Summary;
use crate::problems::Problems;
use crate::provenance::Provenance;
use part::{CollectedPart, ResultKind};

/// Folders within folders that are looked into.
const DEEPEST: usize = 6;

/// Most results of a page.
const MOST_PARTS: usize = 500;

/// The results in `folders`, in the order of the page: of a folder without any those of the folders in it. A result that
/// cannot be read is a fault, and so is a folder with none. `out` is where the page will be, for its links.
///
/// # Errors
/// All faults.
pub fn collect(folders: &[PathBuf], out: &Path) -> Result<Vec<CollectedPart>, Problems> {
    let mut problems = Problems::new("report");
    let mut found: Vec<(ResultKind, PathBuf)> = Vec::new();
    for folder in folders {
        let before = found.len();
        look(folder, DEEPEST, &mut found);
        if found.len() == before {
            let allowed = "a folder with results, or with folders of results in it";
            problems.add("DIR", folder.display(), allowed);
        }
    }
    if found.len() > MOST_PARTS {
        problems.add("DIR", format!("{} results", found.len()), format!("at most {MOST_PARTS} in a page"));
        return Err(problems);
    }
    // Of a kind in the order in which they were given; a folder that was named twice, or above another, stands once.
    let mut known = HashSet::new();
    found.retain(|(kind, folder)| {
        known.insert((*kind, folder.canonicalize().unwrap_or_else(|_| folder.clone())))
    });
    found.sort_by_key(|(kind, _)| *kind);
    let mut parts = Vec::new();
    for (kind, folder) in found {
        match CollectedPart::read(kind, &folder, out) {
            Ok(part) => parts.push(part),
            Err(faults) => problems.add_below(&folder.display().to_string(), faults),
        }
    }
    problems.into_result(Some(parts))
}

/// Adds the results in `folder` to those `found`, or where it has none those in its folders, `deep` folders down.
fn look(folder: &Path, deep: usize, found: &mut Vec<(ResultKind, PathBuf)>) {
    files::recover(folder);
    let here = ResultKind::ALL.into_iter().filter(|kind| kind.is_in(folder));
    let before = found.len();
    found.extend(here.map(|kind| (kind, folder.to_owned())));
    if found.len() > before || deep == 0 {
        return;
    }
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut below: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    below.retain(|path| path.is_dir());
    below.sort();
    for folder in below {
        look(&folder, deep - 1, found);
    }
}

/// Writes `report.html` with all `parts` to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, title: &str, parts: &[CollectedPart]) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let mut files = files::Together::begin();
    let drawn = page::draw(&mut files, out, vec![together(parts)])?;
    let tables = format!("{}{}", runs(parts), others(parts));
    let page = ResultPage {
        title,
        kind: "report",
        lead: &lead(parts),
        tables,
        notes: String::new(),
        drawn: &drawn,
        provenance: &Provenance::here(),
        seed: None,
    };
    let page = page.html_with(&sections(parts));
    files.write(&out.join("report.html"), |file| file.write_all(page.as_bytes()))?;
    files.appear()
}

/// What the page is made of, in a sentence: `3 runs, 1 sweep.`
pub fn lead(parts: &[CollectedPart]) -> String {
    let count = |kind: ResultKind| parts.iter().filter(|part| part.kind == kind).count();
    let words = ResultKind::ALL.into_iter().filter(|&kind| count(kind) > 0);
    let words: Vec<String> = words.map(|kind| kind.counted(count(kind))).collect();
    format!("{}.", words.join(", "))
}

/// A row a run: its verdict before everything else.
fn runs(parts: &[CollectedPart]) -> String {
    let mut rows = String::new();
    for (n, part) in parts.iter().enumerate() {
        let Some(summary) = &part.summary else { continue };
        let _ = writeln!(
            rows,
            "<tr><td><a href=\"#{}\">{}</a></td><td class=\"words\">{}</td>{}</tr>",
            anchor(n),
            escape(&part.name),
            page::prose(&part.finding),
            facts(summary)
        );
    }
    if rows.is_empty() {
        return rows;
    }
    let heads = [("solver", ""), ("first held", "s"), ("settled", "s"), ("lost", "s"), ("watched to", "s")];
    let heads = heads.into_iter().chain([("cables inside", ""), ("energy created", "%")]);
    let heads: String = heads.map(|(name, unit)| format!("<th>{name} <small>{unit}</small></th>")).collect();
    page::table(&format!("<th>run</th><th class=\"words\">verdict</th>{heads}"), &rows)
}

/// Numbers of a run, as cells of its row.
fn facts(summary: &Summary) -> String {
    let shown = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.2}"));
    let capture = summary.capture.as_ref();
    let cells = [
        summary.solver.pair().to_owned(),
        shown(capture.and_then(|capture| capture.enclosed_at_s)),
        shown(capture.and_then(|capture| capture.settled_at_s)),
        shown(capture.and_then(|capture| capture.lost_at_s)),
        shown(Some(summary.simulated_s)),
        summary.contact.map_or_else(|| "–".to_owned(), |contact| contact.cables_inside.to_string()),
        number(100.0 * summary.conservation.energy_created),
    ];
    cells.map(|cell| format!("<td>{}</td>", escape(&cell))).concat()
}

/// A row for every result but runs: what it found.
fn others(parts: &[CollectedPart]) -> String {
    let mut rows = String::new();
    for (n, part) in parts.iter().enumerate().filter(|(_, part)| part.summary.is_none()) {
        let _ = writeln!(
            rows,
            "<tr><td><a href=\"#{}\">{}</a></td><td>{}</td><td class=\"words\">{}</td></tr>",
            anchor(n),
            escape(&part.name),
            part.kind.name(),
            page::prose(&part.finding)
        );
    }
    if rows.is_empty() {
        return rows;
    }
    page::table("<th>result</th><th>of</th><th class=\"words\">found</th>", &rows)
}

/// Survival of ensembles in the same axes, as many as are told apart; no panel where there are not two.
fn together(parts: &[CollectedPart]) -> Figure {
    let curves = parts.iter().filter_map(|part| Some((part, part.survival.as_ref()?)));
    let curves: Vec<Named> = curves
        .take(MOST_PENS)
        .enumerate()
        .map(|(series, (part, survival))| Named { name: part.name.clone(), series, survival })
        .collect();
    survival::figure(if curves.len() < 2 { &[] } else { &curves })
}

/// Every result, one below the other.
fn sections(parts: &[CollectedPart]) -> String {
    let mut text = String::new();
    for (n, part) in parts.iter().enumerate() {
        let _ = writeln!(
            text,
            "<article id=\"{0}\">\n<h2>{1}</h2>\n<p class=\"where\">{2} in {3}</p>\n{4}\n</article>",
            anchor(n),
            escape(&part.title),
            part.kind.name(),
            part.link,
            part.body(&anchor(n))
        );
    }
    text
}

/// Where in the page result `n` is.
fn anchor(n: usize) -> String {
    format!("result-{}", n + 1)
}
