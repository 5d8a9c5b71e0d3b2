//! Dependencies on parameters (Eq. 3.17) as a table, as curves and as a page: `dependency.json`, `dependency.csv`,
//! `dependency.html`, and an SVG a parameter.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;

use super::columns::{self, NumberColumns};
use super::files::{self, WriteError};
use super::grid::Grid;
use super::page::{self, Figure, ResultPage};
use super::plots::{Axis, Dot, Key, Mark, Panel, Swatch, colour, dashed};
use super::results;
use super::rows::{KeptRows, line};
use crate::problems::Problems;
use crate::study::sweep::SweepPlan;
use crate::study::sweep::dependency::{
    DEPLOYMENT, Dependencies, Dependency, Observed, OverParameter, last_key, words,
};

/// The columns that are asked for: those of deployment where none is.
pub fn names(of: Option<&[String]>) -> Vec<String> {
    of.map_or_else(|| DEPLOYMENT.map(str::to_owned).to_vec(), <[String]>::to_vec)
}

/// The members among `kept` that did not fail, with their numbers in the columns `names`.
///
/// # Errors
/// A column that is not there or without numbers; no member at all; a file that cannot be read.
pub fn observed(plan: &SweepPlan, kept: &KeptRows, names: &[String]) -> Result<Vec<Observed>, Problems> {
    let mut problems = Problems::new("--of");
    let asked: Vec<&str> = names.iter().map(String::as_str).chain(["point"]).collect();
    let columns = NumberColumns::find(plan, &asked, "", &mut problems);
    let mut observed = Vec::new();
    for (&member, row) in &kept.rows {
        if row.failed || !problems.list.is_empty() {
            continue;
        }
        let Some(cells) = columns.cells(kept, row, &mut problems) else { break };
        let numbers: Vec<Option<f64>> = cells.iter().map(|text| columns::number(text)).collect();
        let (numbers, point) = numbers.split_at(names.len());
        for ((name, text), number) in names.iter().zip(&cells).zip(numbers) {
            if number.is_none() && !text.is_empty() {
                problems.add(name, format!("{text:?} of member {member}"), "a column of numbers");
            }
        }
        let point = point[0].map_or(member / plan.study.members, |point| point as u64);
        observed.push(Observed { point, numbers: numbers.to_vec() });
    }
    if problems.list.is_empty() && observed.is_empty() {
        problems.add("", "no member that was finished", "a sweep of which something is finished");
    }
    problems.into_result(Some(observed))
}

/// Writes all files of `all` to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, all: &Dependencies, seed: u64) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let mut files = files::Together::begin();
    let drawn = page::draw(&mut files, out, figures(all))?;
    let page = ResultPage {
        title: &all.title,
        kind: "dependencies",
        lead: &lead(all),
        tables: tables(all).iter().map(Grid::page).collect(),
        notes: String::new(),
        drawn: &drawn,
        provenance: &all.provenance,
        seed: Some(seed),
    }
    .html();
    files.write(&out.join("dependency.html"), |file| file.write_all(page.as_bytes()))?;
    files.write(&out.join("dependency.csv"), |file| file.write_all(&csv(all)))?;
    // Last: it says that the rest is there.
    files.write(&out.join("dependency.json"), |file| results::as_json(file, all))?;
    files.appear()
}

/// Dependencies and differences as text.
pub fn text(all: &Dependencies) -> String {
    let tables = tables(all).into_iter().map(|table| format!("\n{}\n{}", table.title, table.text()));
    format!("{}\n{}{}", all.title, lead(all), tables.collect::<String>())
}

fn lead(all: &Dependencies) -> String {
    let [finished, of] = all.members;
    let chaos = match all.dependencies.iter().flat_map(|row| &row.found).flatten().any(has_interval) {
        true => " ±: half the 95 % interval, where both values have several members.",
        false => "",
    };
    format!(
        "{finished} of {of} members. D = (change of a number / its start) / (change of the parameter / its start), in \
         percent (Eq. 3.17, 3.18).{chaos}"
    )
}

fn has_interval(dependency: &Dependency) -> bool {
    dependency.half_width_95.is_some()
}

/// The first three cells of a row are words.
const N_WORDS: usize = 3;

fn tables(all: &Dependencies) -> Vec<Grid> {
    let head = |words: [&str; N_WORDS]| {
        let names = all.numbers.iter().map(|name| last_key(name).to_owned());
        words.map(str::to_owned).into_iter().chain(names).collect()
    };
    let mut tables = vec![Grid {
        title: "Dependency [%]",
        n_words: N_WORDS,
        head: head(["parameter", "from, to", "at"]),
        rows: dependency_rows(all),
    }];
    if !all.differences.is_empty() {
        tables.push(Grid {
            title: "Largest difference over the values [%]",
            n_words: N_WORDS,
            head: head(["parameter", "of", "from"]),
            rows: difference_rows(all),
        });
    }
    tables
}

fn dependency_rows(all: &Dependencies) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for row in &all.dependencies {
        let found = row.found.iter().map(|found| match found {
            Some(Dependency { percent, half_width_95: Some(half) }) => format!("{percent:.2} ± {half:.2}"),
            Some(found) => format!("{:.2}", found.percent),
            None => "–".to_owned(),
        });
        let group = words(&all.groups[row.group]);
        let words = [row.path.clone(), format!("{}, {}", row.from, row.to), group];
        rows.push(words.into_iter().chain(found).collect());
        let percents: Vec<Option<f64>> =
            row.found.iter().map(|found| Some(found.as_ref()?.percent)).collect();
        rows.extend(beside(row.source.as_deref(), &percents, &row.published));
    }
    rows
}

fn difference_rows(all: &Dependencies) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for row in &all.differences {
        let [of, from] = [row.group, 0].map(|group| words(&all.groups[group]));
        let found = row.percent.iter().map(|percent| number(*percent));
        rows.push([row.path.clone(), of, from].into_iter().chain(found).collect());
        rows.extend(beside(row.source.as_deref(), &row.percent, &row.published));
    }
    rows
}

/// What others published, and how far ours is from it [percentage points].
fn beside(source: Option<&str>, ours: &[Option<f64>], published: &[Option<f64>]) -> Vec<Vec<String>> {
    let Some(source) = source else { return Vec::new() };
    let row = |name: &str, cells: Vec<String>| {
        let words = [format!("  {name}"), String::new(), String::new()];
        words.into_iter().chain(cells).collect()
    };
    let apart = |(ours, theirs): (&Option<f64>, &Option<f64>)| {
        ours.zip(*theirs).map_or_else(|| "–".to_owned(), |(ours, theirs)| format!("{:+.2}", ours - theirs))
    };
    vec![
        row(source, published.iter().map(|percent| number(*percent)).collect()),
        row("apart, in points", ours.iter().zip(published).map(apart).collect()),
    ]
}

fn number(percent: Option<f64>) -> String {
    percent.map_or_else(|| "–".to_owned(), |percent| format!("{percent:.2}"))
}

/// A line for each dependency and each difference.
fn csv(all: &Dependencies) -> Vec<u8> {
    let crossed: Vec<&String> = all.groups.first().into_iter().flat_map(BTreeMap::keys).collect();
    let group = |group: usize| crossed.iter().map(move |path| all.groups[group][*path].clone());
    let text = |number: Option<f64>| number.map_or_else(String::new, |number| number.to_string());
    let head = ["kind", "parameter", "from", "to", "number"].map(str::to_owned).into_iter();
    let head = head.chain(crossed.iter().map(|path| (*path).clone()));
    let rest = ["against", "percent", "half_width_95", "source", "published_percent"].map(str::to_owned);
    let mut lines = line(&head.chain(rest).collect::<Vec<_>>());
    for row in &all.dependencies {
        for (number, name) in all.numbers.iter().enumerate() {
            let found = row.found[number];
            let first = ["dependency", &row.path, &row.from.to_string(), &row.to.to_string(), name];
            let rest = [
                String::new(),
                text(found.map(|found| found.percent)),
                text(found.and_then(|found| found.half_width_95)),
                row.source.clone().unwrap_or_default(),
                text(row.published.get(number).copied().flatten()),
            ];
            let first = first.map(str::to_owned).into_iter();
            lines.extend(line(&first.chain(group(row.group)).chain(rest).collect::<Vec<_>>()));
        }
    }
    for row in &all.differences {
        for (number, name) in all.numbers.iter().enumerate() {
            let first = ["difference", &row.path, "", "", name].map(str::to_owned).into_iter();
            let source = row.source.clone().unwrap_or_default();
            let published = text(row.published.get(number).copied().flatten());
            let rest = [words(&all.groups[0]), text(row.percent[number]), String::new(), source, published];
            lines.extend(line(&first.chain(group(row.group)).chain(rest).collect::<Vec<_>>()));
        }
    }
    lines
}

/// A figure for each parameter: a panel for each number, a curve for each group.
fn figures(all: &Dependencies) -> Vec<Figure> {
    let mut paths: Vec<&str> = all.curves.iter().map(|curve| curve.path.as_str()).collect();
    paths.dedup();
    let figure = |path: &&str| {
        let curves: Vec<&OverParameter> = all.curves.iter().filter(|curve| curve.path == **path).collect();
        let panels = all.numbers.iter().enumerate();
        Figure {
            name: format!("dependency-{}", file_name(path)).into(),
            title: format!("Over {path}").into(),
            words: "Means of the members at a value, all other parameters as the scene has them; bars: one standard \
                    deviation, where there are several."
                .to_owned(),
            panels: panels.map(|(number, name)| panel(all, &curves, path, number, name)).collect(),
        }
    };
    paths.iter().map(figure).collect()
}

fn panel(all: &Dependencies, curves: &[&OverParameter], path: &str, number: usize, name: &str) -> Panel {
    let means = |curve: &OverParameter| -> Vec<(f64, f64)> {
        curve.values.iter().filter_map(|at| Some((at.value, at.numbers[number]?.mean))).collect()
    };
    let points: Vec<(f64, f64)> = curves.iter().flat_map(|curve| means(curve)).collect();
    let x = Axis::linear(path, points.iter().map(|point| point.0));
    let y = Axis::linear(last_key(name), points.iter().map(|point| point.1));
    let mut marks = Vec::new();
    for curve in curves {
        let (colour, dashed) = (colour(curve.group), dashed(curve.group));
        marks.push(Mark::Line { points: means(curve), colour, width: 2, dashed });
        for at in &curve.values {
            let Some(found) = at.numbers[number] else { continue };
            if let Some(deviation) = found.deviation {
                let ends = [-deviation, deviation].map(|off| (at.value, found.mean + off));
                marks.push(Mark::Line { points: ends.to_vec(), colour, width: 1, dashed: false });
            }
            marks.push(Mark::Dot { at: (at.value, found.mean), colour, shape: Dot::Full });
        }
    }
    let key = |curve: &&OverParameter| Key {
        words: words(&all.groups[curve.group]),
        colour: colour(curve.group),
        swatch: if dashed(curve.group) { Swatch::Dashed } else { Swatch::Line },
    };
    // Once, above the first panel; one curve needs no name.
    let keys = if number == 0 && curves.len() > 1 { curves.iter().map(key).collect() } else { Vec::new() };
    Panel { keys, ..Panel::of_curves(x, y, 260, marks) }
}

/// A path as part of the name of a file.
fn file_name(path: &str) -> String {
    path.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect()
}
