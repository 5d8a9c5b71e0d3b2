//! A map of capture probability: `map.json`, `map.svg`, `map.html`.

use std::io::Write as _;
use std::path::Path;

use super::files::{self, WriteError};
use super::page::{self, Figure};
use super::plots::{Axis, Dot, INK, Key, MUTED, Mark, Panel, Swatch, colour};
use super::results;
use super::rows::{KeptRows, fields};
use super::sweep::share_words;
use crate::problems::{Problems, did_you_mean};
use crate::study::Z;
use crate::study::sweep::SweepPlan;
use crate::study::sweep::map::{CaptureMap, MapSample};

/// Most members that are drawn as points.
const MOST_DRAWN: usize = 1000;

/// Tiles along each axis of the drawn regression.
const TILES: usize = 40;

/// Probabilities that have a line, and how wide it is [px].
const LINES: [(f64, u32); 3] = [(0.1, 1), (0.5, 3), (0.9, 1)];

const WORDS: &str = "Above, the regression: the darker, the more likely a capture; lines at 10, 50 (thick) and 90 %; a full \
    dot is a member that was captured, a ring one that was not. Below, raw shares with their exact 95 % intervals.";

/// The members with a verdict among `kept`, at the columns `names`.
///
/// # Errors
/// A column that is not there or holds no numbers; a file that cannot be read.
pub fn samples(plan: &SweepPlan, kept: &mut KeptRows, names: &[String]) -> Result<Vec<MapSample>, Problems> {
    let mut problems = Problems::new("--over");
    let column = |name: &str| plan.columns.iter().position(|known| known == name);
    let mut columns = Vec::new();
    for name in names {
        let Some(column) = column(name) else {
            let meant = did_you_mean(name, plan.columns.iter().map(String::as_str));
            problems.add("", name, format!("{meant}Columns of the table: {}", plan.columns.join(", ")));
            continue;
        };
        columns.push(column);
    }
    let point = column("point").unwrap_or_default();
    let mut samples = Vec::new();
    for (member, row) in kept.rows.clone() {
        let Some(captured) = row.captured else { continue };
        let line = match kept.line_of(&row) {
            Ok(line) => fields(&line),
            Err(error) => {
                problems.add("", error.to_string(), "rows that can be read");
                break;
            }
        };
        let text = |column: usize| String::from_utf8_lossy(line.get(column).unwrap_or_default()).into_owned();
        let mut at = Vec::new();
        for (name, &column) in names.iter().zip(&columns) {
            match text(column).parse::<f64>().ok().filter(|value| value.is_finite()) {
                Some(value) => at.push(value),
                None => problems.add(
                    name,
                    format!("{:?} of member {member}", text(column)),
                    "a column of numbers",
                ),
            }
        }
        if at.len() == names.len() {
            samples.push(MapSample { point: text(point).parse().unwrap_or(member), at, captured });
        }
    }
    if problems.list.is_empty() && samples.is_empty() {
        problems.add(
            "",
            "no member with a verdict",
            "a sweep of a scene with a target, of which something is finished",
        );
    }
    problems.into_result(Some(samples))
}

/// Writes all files of `map`, which `samples` are drawn into, to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, map: &CaptureMap, samples: &[MapSample], seed: u64) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let panels = if map.inputs.len() == 1 { over_one(map, samples) } else { over_two(map, samples) };
    let figure = Figure { name: "map", title: "Probability of capture", words: WORDS.to_owned(), panels };
    let mut files = files::Together::begin();
    let drawn = page::draw(&mut files, out, vec![figure])?;
    let page = page::fill(&[
        ("title", page::escape(&map.title)),
        ("kind", "map".to_owned()),
        ("lead", format!("<p class=\"lead\">{}</p>\n", page::escape(&words(map)))),
        ("tables", foretold(map)),
        ("notes", String::new()),
        ("figures", page::drawings(&drawn)),
        ("made", page::made(&map.provenance, seed)),
    ]);
    files.write(&out.join("map.html"), |file| file.write_all(page.as_bytes()))?;
    // Last: it says that the rest is there.
    files.write(&out.join("map.json"), |file| results::as_json(file, map))?;
    files.appear()
}

/// The map in a few lines.
pub fn words(map: &CaptureMap) -> String {
    let coefficients = map.terms.iter().zip(&map.fit.coefficients).enumerate();
    let terms: Vec<String> = coefficients
        .map(|(i, (term, value))| {
            format!("{value:+.2} ± {:.2} ({term})", Z * map.fit.covariance[i][i].sqrt())
        })
        .collect();
    let letters = ["u", "v"].iter().zip(&map.inputs);
    let inputs: Vec<String> = letters
        .map(|(letter, input)| {
            format!("{letter}: {}, {:.4} to {:.4} as -1 to 1", input.name, input.range[0], input.range[1])
        })
        .collect();
    format!(
        "Over all {}. ln(p / (1 - p)) = {}; {}. Brier score on points not seen {:.3}, of the overall share {:.3}.",
        share_words(&map.captured),
        terms.join(" "),
        inputs.join("; "),
        map.brier,
        map.brier_of_share
    )
}

/// What was foretold of points that were not seen, and what came.
fn foretold(map: &CaptureMap) -> String {
    let row = |class: &crate::study::sweep::map::Foretold| {
        let came = page::escape(&share_words(&class.captured));
        format!("<tr><td>{:.0} %</td><td>{came}</td></tr>\n", 100.0 * class.probability)
    };
    page::table(
        "<th>foretold of points not seen</th><th>came</th>",
        &map.foretold.iter().map(row).collect::<String>(),
    )
}

fn keys() -> Vec<Key> {
    vec![
        Key { words: "captured".to_owned(), colour: colour(0), swatch: Swatch::Field },
        Key { words: "not captured".to_owned(), colour: colour(1), swatch: Swatch::Line },
    ]
}

/// Members as points; of many the first.
fn dots(samples: &[MapSample], at: impl Fn(&MapSample) -> (f64, f64)) -> impl Iterator<Item = Mark> {
    samples.iter().take(MOST_DRAWN).map(move |sample| {
        let (colour, shape) = if sample.captured { (colour(0), Dot::Full) } else { (colour(1), Dot::Ring) };
        Mark::Dot { at: at(sample), colour, shape }
    })
}

fn over_one(map: &CaptureMap, samples: &[MapSample]) -> Vec<Panel> {
    let input = &map.inputs[0];
    let [low, high] = widened(input.range);
    let x: Vec<f64> = (0..=100).map(|i| low + 0.01 * f64::from(i) * (high - low)).collect();
    let fitted: Vec<_> = x.iter().map(|&x| map.at(&[x])).collect();
    let edge = |side: usize| fitted.iter().map(|p| 100.0 * p.interval_95[side]).collect();
    let mut marks = vec![
        Mark::Band { x: x.clone(), lower: edge(0), upper: edge(1), colour: colour(0), opacity: 0.15 },
        Mark::Line {
            points: x.iter().zip(&fitted).map(|(&x, p)| (x, 100.0 * p.value)).collect(),
            colour: colour(0),
            width: 2,
            dashed: false,
        },
    ];
    for one in &map.boxes {
        let middle = 0.5 * (one.from[0] + one.to[0]);
        let points = one.captured.interval_95.map(|bound| (middle, 100.0 * bound)).to_vec();
        marks.push(Mark::Line { points, colour: INK, width: 1, dashed: false });
        marks.push(Mark::Dot { at: (middle, 100.0 * one.captured.share), colour: INK, shape: Dot::Diamond });
    }
    marks.extend(dots(samples, |sample| (sample.at[0], if sample.captured { 104.0 } else { -4.0 })));
    let y = Axis::fixed("captured [%]", -8.0, 108.0);
    vec![Panel { keys: keys(), ..Panel::of_curves(Axis::fixed(&input.name, low, high), y, 420, marks) }]
}

fn over_two(map: &CaptureMap, samples: &[MapSample]) -> Vec<Panel> {
    let [x, y] = [0, 1].map(|axis| widened(map.inputs[axis].range));
    let axes =
        || (Axis::fixed(&map.inputs[0].name, x[0], x[1]), Axis::fixed(&map.inputs[1].name, y[0], y[1]));
    let corner = |i: usize, j: usize| {
        let along = |[low, high]: [f64; 2], number: usize| low + number as f64 / TILES as f64 * (high - low);
        (along(x, i), along(y, j))
    };
    let value = |at: (f64, f64)| map.at(&[at.0, at.1]).value;
    let mut marks = Vec::new();
    for (i, j) in (0..TILES * TILES).map(|k| (k / TILES, k % TILES)) {
        let (from, to) = (corner(i, j), corner(i + 1, j + 1));
        let middle = value((0.5 * (from.0 + to.0), 0.5 * (from.1 + to.1)));
        marks.push(tile(from, to, middle));
    }
    for (level, width) in LINES {
        for (i, j) in (0..TILES * TILES).map(|k| (k / TILES, k % TILES)) {
            let corners = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            let crossed = crossings(corners.map(|at| (at, value(at) - level)));
            marks.extend(crossed.chunks_exact(2).map(|pair| Mark::Line {
                points: pair.to_vec(),
                colour: INK,
                width,
                dashed: false,
            }));
        }
    }
    marks.extend(dots(samples, |sample| (sample.at[0], sample.at[1])));
    let (ax, ay) = axes();
    let fitted =
        Panel { title: "Regression".to_owned(), keys: keys(), ..Panel::of_curves(ax, ay, 520, marks) };
    let (ax, ay) = axes();
    let raw = Panel { title: "Raw shares".to_owned(), ..Panel::of_curves(ax, ay, 520, raw(map)) };
    vec![fitted, raw]
}

fn tile(from: (f64, f64), to: (f64, f64), probability: f64) -> Mark {
    Mark::Bar { from, to, colour: colour(0), opacity: 0.6 * probability, edge: false }
}

/// Boxes with their counts and intervals.
fn raw(map: &CaptureMap) -> Vec<Mark> {
    let mut marks = Vec::new();
    for one in &map.boxes {
        let (from, to) = ((one.from[0], one.from[1]), (one.to[0], one.to[1]));
        marks.push(tile(from, to, one.captured.share));
        let [low, high] = one.captured.interval_95.map(|bound| 100.0 * bound);
        let left = from.0 + 0.06 * (to.0 - from.0);
        let at = |height: f64| (left, from.1 + height * (to.1 - from.1));
        let share = format!("{} of {}", one.captured.captured, one.captured.of);
        marks.push(Mark::Words { at: at(0.65), text: share, colour: INK, ends: false });
        let interval = format!("{low:.0}-{high:.0} %");
        marks.push(Mark::Words { at: at(0.3), text: interval, colour: MUTED, ends: false });
    }
    marks
}

/// Where a function that has `values` at the corners of a tile is zero on its edges: none, two or four points.
fn crossings(values: [((f64, f64), f64); 4]) -> Vec<(f64, f64)> {
    let edges = (0..4).map(|i| (values[i], values[(i + 1) % 4]));
    let crossed = edges.filter(|(one, other)| (one.1 > 0.0) != (other.1 > 0.0));
    crossed
        .map(|((a, one), (b, other))| {
            let share = one / (one - other);
            (a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1))
        })
        .collect()
}

/// Room for inputs that are all alike.
fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    if high > low { [low, high] } else { [low - 0.5, high + 0.5] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_crosses_a_tile_where_the_function_is_zero() {
        let at = |x: f64, y: f64| ((x, y), x - 0.25);
        let crossed = crossings([at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]);
        assert_eq!(crossed, [(0.25, 0.0), (0.25, 1.0)]);
        let none = |x: f64, y: f64| ((x, y), 1.0);
        assert!(crossings([none(0.0, 0.0), none(1.0, 0.0), none(1.0, 1.0), none(0.0, 1.0)]).is_empty());
    }
}
