//! What a fit found as a table and a page, with what is left: `fit.json`, `fit.csv`, `fit.html`, `residual.svg`.

use std::io::Write as _;
use std::path::Path;

use super::files::{self, WriteError};
use super::grid::Grid;
use super::page::{self, ResultPage};
use super::residual;
use super::results;
use super::rows::line;
use super::table::number;
use crate::study::experiment::found::{Fit, FittedParameter};

/// Writes all files of `fit` to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, fit: &Fit) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let mut files = files::Together::begin();
    let drawn = page::draw(&mut files, out, vec![residual::figure(&fit.residual)])?;
    let notes: Vec<String> =
        notes(fit).iter().map(|note| format!("<p>{}</p>\n", page::escape(note))).collect();
    let page = ResultPage {
        title: &fit.title,
        kind: "fit",
        lead: &residual::lead(&fit.residual),
        tables: grid(fit).page(),
        notes: notes.concat(),
        drawn: &drawn,
        provenance: &fit.residual.provenance,
        seed: None,
    }
    .html();
    files.write(&out.join("fit.html"), |file| file.write_all(page.as_bytes()))?;
    files.write(&out.join("fit.csv"), |file| file.write_all(&csv(fit)))?;
    // Last: it says that the rest is there.
    files.write(&out.join("fit.json"), |file| results::as_json(file, fit))?;
    files.appear()
}

/// What was found, as text.
pub fn text(fit: &Fit) -> String {
    format!(
        "{}\n{}\n{}\n{}",
        fit.title,
        residual::lead(&fit.residual),
        grid(fit).text(),
        notes(fit).join("\n")
    )
}

fn grid(fit: &Fit) -> Grid {
    let row = |one: &FittedParameter| {
        let [low, high] = one.between;
        let interval = one
            .interval_95
            .map_or_else(|| "–".to_owned(), |[low, high]| format!("{} to {}", number(low), number(high)));
        let range =
            format!("{} to {}{}", number(low), number(high), if one.logarithmic { ", log" } else { "" });
        vec![one.path.clone(), range, number(one.start), number(one.found), interval]
    };
    Grid {
        title: "What was found",
        n_words: 2,
        head: ["parameter", "range", "start", "found", "interval of 95 %"].map(str::to_owned).into(),
        rows: fit.parameters.iter().map(row).collect(),
    }
}

/// How well it is known, what stands against it, and how to fly it.
fn notes(fit: &Fit) -> Vec<String> {
    let known = match fit.noise_known_m {
        Some(known) => format!("as known, {} mm", number(1e3 * known)),
        None => "estimated from it".to_owned(),
    };
    let mut notes = vec![format!(
        "What is left: {} mm a coordinate, noise {known}; correlation from one sighting to the next {:.3}, for which \
         variances are {:.2} times larger. Markers and axes are taken for independent, the scene for right.",
        number(1e3 * fit.noise_left_m),
        fit.correlation,
        fit.fewer
    )];
    let correlations = fit.correlations.iter().flat_map(|all| {
        let pairs = (0..all.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
        pairs.map(|(j, i)| {
            let names = [j, i].map(|number| fit.parameters[number].path.as_str());
            format!("{} and {}: {:+.2}", names[0], names[1], all[j][i])
        })
    });
    let correlations: Vec<String> = correlations.collect();
    if !correlations.is_empty() {
        notes.push(format!("Correlation of {}.", correlations.join("; ")));
    }
    let step = fit.step_s.map_or_else(String::new, |step| format!(", all in steps of {step:e} s"));
    notes.push(format!("{} flights{step}; {} steps of the descent.", fit.flights, fit.steps));
    notes.extend(fit.warnings.iter().map(|warning| format!("warning: {warning}.")));
    notes.push(format!("To fly it: {}", fit.again));
    notes
}

/// A line for each parameter.
fn csv(fit: &Fit) -> Vec<u8> {
    let mut lines = line(&["parameter", "least", "largest", "start", "found", "low_95", "high_95", "at_end"]);
    for one in &fit.parameters {
        let [low, high] = one
            .interval_95
            .map_or_else(|| [String::new(), String::new()], |ends| ends.map(|end| end.to_string()));
        let numbers = [one.between[0], one.between[1], one.start, one.found].map(|number| number.to_string());
        let rest = [low, high, one.at_end.to_string()];
        lines.extend(line(&std::iter::once(one.path.clone()).chain(numbers).chain(rest).collect::<Vec<_>>()));
    }
    lines
}
