//! A map of the probability of an outcome: `map.json`, `map.svg`, `map.html`.

use std::io::Write as _;
use std::path::Path;

use super::columns::NumberColumns;
use super::files::{self, WriteError};
use super::page::{self, Figure, ResultPage};
use super::plots::{Axis, Dot, INK, Key, MUTED, Mark, Panel, Swatch, colour};
use super::results;
use super::rows::KeptRows;
use super::sweep::share_words;
use crate::problems::Problems;
use crate::study::Z;
use crate::study::sweep::SweepPlan;
use crate::study::sweep::map::{CaptureMap, LETTERS, MapBox, MapInput, MapSample, PublishedSample};
use crate::study::sweep::outcome::MapOutcome;
use crate::study::sweep::refine::{Refined, Refinement};

/// Most members that are drawn as points.
const MOST_DRAWN: usize = 1000;

/// Tiles along each axis of the drawn regression.
const TILES: usize = 40;

/// Probabilities that have a line, and how wide it is [px].
const LINES: [(f64, u32); 3] = [(0.1, 1), (0.5, 3), (0.9, 1)];

/// Tiles along each axis of a slice.
const SLICE_TILES: usize = 24;

/// Slices along each input beyond the second.
const SLICES: usize = 3;

const WORDS: &str = "Above, the regression: the darker, the more likely; lines at 10, 50 (thick) and 90 %; a full dot is a \
    member of whom it is so, a ring one of whom it is not. Below, raw shares with their 95 % intervals: exact ones, or \
    confidence sequences where members were put where the map was least certain.";

const PUBLISHED: &str = " Squares: captures of others, full where captured.";

const SLICED: &str =
    " Each pair of panels is a slice: the regression at the middle of it, the members within it.";

/// What a member of a sweep answers.
#[derive(Clone, Debug)]
pub struct MemberAnswer {
    /// Its number.
    pub member: u64,
    /// Its point.
    pub point: u64,
    /// Its inputs.
    pub at: Vec<f64>,
    /// Whether it has a verdict at all: one that failed has none.
    pub has_verdict: bool,
    /// Whether the outcome came; none where it is undecided.
    pub came: Option<bool>,
}

/// The answers of the members among `kept`, in their order, with their numbers in the columns `over`; columns that are not
/// there or hold no numbers are faults.
pub fn answers(
    plan: &SweepPlan,
    kept: &KeptRows,
    (over, outcome): (&[String], MapOutcome),
    problems: &mut Problems,
) -> Vec<MemberAnswer> {
    let told = outcome.needed(plan, "--outcome", problems);
    let names: Vec<&str> = over.iter().chain(&told).map(String::as_str).chain(["point"]).collect();
    let columns = NumberColumns::find(plan, &names, "--over", problems);
    let mut answers = Vec::new();
    for (&member, row) in &kept.rows {
        if !problems.list.is_empty() {
            break;
        }
        let Some(values) = columns.of(kept, row, problems) else { break };
        let (at, rest) = values.split_at(over.len());
        let (ends, point) = rest.split_at(told.len());
        let named = at.iter().zip(over);
        let mut number = |(value, name): (&Option<f64>, &String)| {
            value.unwrap_or_else(|| {
                problems.add("--over", format!("{name} of member {member}"), "a column of numbers");
                0.0
            })
        };
        let at = named.map(&mut number).collect();
        let point = point[0].map_or(member, |point| point as u64);
        let came = outcome.of_row(row, ends, plan);
        answers.push(MemberAnswer { member, point, at, has_verdict: row.captured.is_some(), came });
    }
    answers
}

/// The fault of `place` in `input` that its numbers are none that a regression can be made of.
pub fn no_regression(input: &str, place: &str) -> Problems {
    let mut problems = Problems::new(input);
    problems.add(place, "numbers too large or too small", "numbers that a regression can be made of");
    problems
}

/// What a map is asked for.
#[derive(Clone, Debug)]
pub struct MapRequest {
    /// Columns of the table, one to four.
    pub over: Vec<String>,
    /// What it is the probability of.
    pub outcome: MapOutcome,
    /// Boxes along each input.
    pub n_boxes: usize,
}

impl MapRequest {
    /// Checks how many columns it is over.
    ///
    /// # Errors
    /// Too many, or none.
    pub fn check(&self) -> Result<(), Problems> {
        let mut problems = Problems::new("map");
        let most = LETTERS.len();
        if !(1..=most).contains(&self.over.len()) {
            problems.add("--over", self.over.join(","), format!("one to {most} columns"));
        }
        problems.into_result(Some(()))
    }

    /// The map of the members among `kept`, who are all, or were asked for by a refinement to a half width; and the members
    /// that are in it.
    ///
    /// # Errors
    /// Columns that are not there or hold no numbers; nothing that is decided; a file that cannot be read.
    pub fn fill(
        &self,
        plan: &SweepPlan,
        kept: &KeptRows,
        refinement: Option<(&Refinement, f64)>,
    ) -> Result<(CaptureMap, Vec<MapSample>), Problems> {
        self.check()?;
        let mut problems = Problems::new("map");
        let answers = answers(plan, kept, (&self.over, self.outcome), &mut problems);
        let (mut samples, mut undecided) = (Vec::new(), 0);
        for MemberAnswer { point, at, came, .. } in answers.into_iter().filter(|answer| answer.has_verdict) {
            match came {
                Some(came) => samples.push(MapSample { point, at, came }),
                None => undecided += 1,
            }
        }
        if problems.list.is_empty() && samples.is_empty() {
            let found = format!("no member with a verdict on it, {undecided} undecided");
            problems.add("", found, "a sweep of a scene with a target, of which something is finished");
        }
        let samples = problems.into_result(Some(samples))?;
        let of_samples = |(axis, name): (usize, &String)| {
            MapInput::of(name, samples.iter().map(|sample: &MapSample| sample.at[axis]))
        };
        let inputs = match refinement {
            Some((refinement, _)) => refinement.inputs().to_vec(),
            None => self.over.iter().enumerate().map(of_samples).collect(),
        };
        let map = CaptureMap::of(&plan.title, (self.outcome, undecided), &inputs, &samples, self.n_boxes);
        let map = map.ok_or_else(|| no_regression("map", "--over"))?.beside(&plan.study.published_outcomes);
        let map = match refinement {
            Some((refinement, half_width)) => map.refined(refinement, half_width),
            None => map,
        };
        Ok((map, samples))
    }
}

/// Writes all files of `map`, which `samples` are drawn into with so many boxes along an input of a slice, to the folder
/// `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(
    out: &Path,
    map: &CaptureMap,
    samples: &[MapSample],
    n_boxes: usize,
    seed: u64,
) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let (panels, sliced) = match map.inputs.len() {
        1 => (over_one(map, samples), ""),
        2 => (over_two(map, samples), ""),
        _ => (slices(map, samples, n_boxes), SLICED),
    };
    let published = if map.published.is_empty() || map.inputs.len() != 2 { "" } else { PUBLISHED };
    let words = format!("Probability: {}. {WORDS}{published}{sliced}", map.outcome);
    let figure = Figure { name: "map".into(), title: "Probability".into(), words, panels };
    let mut files = files::Together::begin();
    let drawn = page::draw(&mut files, out, vec![figure])?;
    let page = ResultPage {
        title: &map.title,
        kind: "map",
        lead: &self::words(map),
        tables: foretold(map) + &published_table(map),
        notes: String::new(),
        drawn: &drawn,
        provenance: &map.provenance,
        seed: Some(seed),
    }
    .html();
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
    let letters = LETTERS.iter().zip(&map.inputs);
    let inputs: Vec<String> = letters
        .map(|(letter, input)| {
            format!("{letter}: {}, {:.4} to {:.4} as -1 to 1", input.name, input.range[0], input.range[1])
        })
        .collect();
    let undecided = match map.undecided {
        0 => String::new(),
        n => {
            let [low, high] = map.bounds().map(|share| 100.0 * share);
            format!(
                " {n} members ended before it could be told and are left out: with them between {low:.0} and {high:.0} %."
            )
        }
    };
    let overall = match &map.refined {
        Some(refined) => refined_words(&map.outcome, refined),
        None => format!("Over all {}.", share_words(&format!("{}:", map.outcome), &map.captured)),
    };
    format!(
        "{overall}{undecided} ln(p / (1 - p)) = {}; {}. Brier score on points not seen {:.3}, of the overall share {:.3}.",
        terms.join(" "),
        inputs.join("; "),
        map.brier,
        map.brier_of_share
    )
}

/// How far a map was refined.
fn refined_words(outcome: &str, refined: &Refined) -> String {
    let [low, high] = refined.interval_95.map(|end| 100.0 * end);
    let to = if refined.widest > refined.half_width {
        format!("no more members of the study where a box is still known to ±{:.2}", refined.widest)
    } else {
        format!("every box known to ±{:.2}, whenever one looks", refined.widest)
    };
    format!(
        "Over the whole study {outcome}: {:.0} % ({low:.0} to {high:.0} %), from {} of its {} members in {} rounds, each where \
         the map was least certain; {to}.",
        100.0 * refined.share,
        refined.members,
        refined.of_members,
        refined.rounds
    )
}

/// What was foretold of points that were not seen, and what came.
fn foretold(map: &CaptureMap) -> String {
    let row = |class: &crate::study::sweep::map::Foretold| {
        let came = page::escape(&share_words(&format!("{}:", map.outcome), &class.captured));
        format!("<tr><td>{:.0} %</td><td>{came}</td></tr>\n", 100.0 * class.probability)
    };
    page::table(
        "<th>foretold of points not seen</th><th>came</th>",
        &map.foretold.iter().map(row).collect::<String>(),
    )
}

/// What others found, beside the regression.
fn published_table(map: &CaptureMap) -> String {
    if map.published.is_empty() {
        return String::new();
    }
    let row = |one: &PublishedSample| {
        let at: Vec<String> = one.at.iter().map(|value| format!("<td>{value}</td>")).collect();
        let [low, high] = one.fitted.interval_95.map(|bound| 100.0 * bound);
        format!(
            "<tr><td>{}</td>{}<td>{}</td><td>{:.0} % ({low:.0} to {high:.0} %)</td></tr>\n",
            page::escape(&one.source),
            at.concat(),
            if one.captured { "captured" } else { "not captured" },
            100.0 * one.fitted.value
        )
    };
    let inputs: Vec<String> =
        map.inputs.iter().map(|input| format!("<th>{}</th>", page::escape(&input.name))).collect();
    let head = format!(
        "<th>source</th>{}<th>found there</th><th>{} here, by the regression</th>",
        inputs.concat(),
        page::escape(&map.outcome)
    );
    page::table(&head, &map.published.iter().map(row).collect::<String>())
}

/// What others found, in a map over two inputs.
fn squares(map: &CaptureMap) -> impl Iterator<Item = Mark> + '_ {
    map.published.iter().map(|one| {
        let shape = if one.captured { Dot::Square } else { Dot::OpenSquare };
        Mark::Dot { at: (one.at[0], one.at[1]), colour: INK, shape }
    })
}

fn keys(map: &CaptureMap) -> Vec<Key> {
    vec![
        Key { words: map.outcome.clone(), colour: colour(0), swatch: Swatch::Field },
        Key { words: format!("not {}", map.outcome), colour: colour(1), swatch: Swatch::Line },
    ]
}

/// Members as points; of many the first.
fn dots<'a>(
    samples: impl Iterator<Item = &'a MapSample>,
    at: impl Fn(&MapSample) -> (f64, f64),
) -> impl Iterator<Item = Mark> {
    samples.take(MOST_DRAWN).map(move |sample| {
        let (colour, shape) = if sample.came { (colour(0), Dot::Full) } else { (colour(1), Dot::Ring) };
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
    marks.extend(dots(samples.iter(), |sample| (sample.at[0], if sample.came { 104.0 } else { -4.0 })));
    let y = Axis::fixed(&format!("{} [%]", map.outcome), -8.0, 108.0);
    vec![Panel { keys: keys(map), ..Panel::of_curves(Axis::fixed(&input.name, low, high), y, 420, marks) }]
}

fn over_two(map: &CaptureMap, samples: &[MapSample]) -> Vec<Panel> {
    let fitted = Panel {
        title: "Regression".to_owned(),
        keys: keys(map),
        ..panel(map, 520, fitted(map, samples.iter(), &[], TILES).into_iter().chain(squares(map)).collect())
    };
    vec![fitted, Panel { title: "Raw shares".to_owned(), ..panel(map, 520, raw(&map.boxes)) }]
}

/// A pair of panels over the first two inputs for each third of each other input.
fn slices(map: &CaptureMap, samples: &[MapSample], n_boxes: usize) -> Vec<Panel> {
    let others = &map.inputs[2..];
    let n_slices = SLICES.pow(others.len() as u32);
    let mut panels = Vec::new();
    for number in 0..n_slices {
        // The last input changes fastest.
        let third = |input: usize| number / SLICES.pow((others.len() - 1 - input) as u32) % SLICES;
        let bounds = |input: usize| {
            let [low, high] = others[input].range;
            let at = |share: f64| low + (third(input) as f64 + share) / SLICES as f64 * (high - low);
            [at(0.0), at(0.5), at(1.0)]
        };
        let all: Vec<[f64; 3]> = (0..others.len()).map(bounds).collect();
        let is_near = |sample: &&MapSample| {
            all.iter().zip(&sample.at[2..]).all(|([low, _, high], value)| (low..=high).contains(&value))
        };
        let near = || samples.iter().filter(is_near);
        let middle: Vec<f64> = all.iter().map(|bounds| bounds[1]).collect();
        let said = others.iter().zip(&all);
        let said: Vec<String> =
            said.map(|(input, [low, _, high])| format!("{} {low:.4} to {high:.4}", input.name)).collect();
        let keys = if number == 0 { keys(map) } else { Vec::new() };
        let marks = fitted(map, near(), &middle, SLICE_TILES);
        panels.push(Panel { title: said.join(", "), keys, ..panel(map, 300, marks) });
        panels.push(panel(map, 300, raw(&map.boxes_of_slice(near(), &middle, n_boxes))));
    }
    panels
}

/// A panel over the first two inputs.
fn panel(map: &CaptureMap, height: u32, marks: Vec<Mark>) -> Panel {
    let axis = |input: usize| {
        let [low, high] = widened(map.inputs[input].range);
        Axis::fixed(&map.inputs[input].name, low, high)
    };
    Panel::of_curves(axis(0), axis(1), height, marks)
}

/// The regression over the first two inputs where all others are `others`, with its lines and the members `samples`.
fn fitted<'a>(
    map: &CaptureMap,
    samples: impl Iterator<Item = &'a MapSample>,
    others: &[f64],
    n_tiles: usize,
) -> Vec<Mark> {
    let [x, y] = [0, 1].map(|axis| widened(map.inputs[axis].range));
    let corner = |i: usize, j: usize| {
        let along =
            |[low, high]: [f64; 2], number: usize| low + number as f64 / n_tiles as f64 * (high - low);
        (along(x, i), along(y, j))
    };
    let tiles = || (0..n_tiles * n_tiles).map(|k| (k / n_tiles, k % n_tiles));
    let value = |at: (f64, f64)| map.at(&[&[at.0, at.1], others].concat()).value;
    let mut marks = Vec::new();
    for (i, j) in tiles() {
        let (from, to) = (corner(i, j), corner(i + 1, j + 1));
        marks.push(tile(from, to, value((0.5 * (from.0 + to.0), 0.5 * (from.1 + to.1)))));
    }
    for (level, width) in LINES {
        for (i, j) in tiles() {
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
    marks
}

fn tile(from: (f64, f64), to: (f64, f64), probability: f64) -> Mark {
    Mark::Bar { from, to, colour: colour(0), opacity: 0.6 * probability, edge: false }
}

/// Boxes with their counts and intervals.
fn raw(boxes: &[MapBox]) -> Vec<Mark> {
    let mut marks = Vec::new();
    for one in boxes {
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
