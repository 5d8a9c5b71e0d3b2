//! What is best in a study: `optimised.json`, `optimised.svg`, `optimised.html`.

use std::io::Write as _;
use std::path::Path;

use super::files::{self, WriteError};
use super::grid::Grid;
use super::page::{self, Figure, ResultPage};
use super::plots::{Axis, Dot, Key, Mark, Panel, Swatch, colour};
use super::results;
use super::sweep::share_words;
use super::table::number;
use crate::study::sweep::map::MapSample;
use crate::study::sweep::optimise::{Optimised, SearchRound};

const WORDS: &str = "Members of each round, first below: a full dot is one for whom the outcome came, a ring one for whom it \
    did not; the line is the box of the round.";

/// Writes all files of `optimised` to the folder `out`; `rounds` are the members of each round.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(
    out: &Path,
    optimised: &Optimised,
    rounds: &[Vec<MapSample>],
    seed: u64,
) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let figure = Figure {
        name: "optimised".into(),
        title: "The search".into(),
        words: WORDS.to_owned(),
        panels: (0..optimised.parameters.len()).map(|axis| panel(optimised, rounds, axis)).collect(),
    };
    let mut files = files::Together::begin();
    let drawn = page::draw(&mut files, out, vec![figure])?;
    let page = ResultPage {
        title: &optimised.title,
        kind: "optimisation",
        lead: &lead(optimised),
        tables: tables(optimised).iter().map(Grid::page).collect(),
        notes: String::new(),
        drawn: &drawn,
        provenance: &optimised.provenance,
        seed: Some(seed),
    }
    .html();
    files.write(&out.join("optimised.html"), |file| file.write_all(page.as_bytes()))?;
    // Last: it says that the rest is there.
    files.write(&out.join("optimised.json"), |file| results::as_json(file, optimised))?;
    files.appear()
}

/// What was found, as text.
pub fn text(optimised: &Optimised) -> String {
    let tables = tables(optimised).into_iter().map(|table| format!("\n{}\n{}", table.title, table.text()));
    format!("{}\n{}{}", optimised.title, lead(optimised), tables.collect::<String>())
}

/// Whether the gain is above zero beyond chance, and by how much.
fn lead(optimised: &Optimised) -> String {
    let gain = &optimised.gain;
    let [low, high] = gain.interval_95.map(|bound| 100.0 * bound);
    let said = match (low > 0.0, high < 0.0) {
        (true, _) => "A gain",
        (_, true) => "A loss",
        _ => "No gain beyond chance",
    };
    format!(
        "{} of fresh members of the scene as it is; {} at the best point. {said}: {:+.1} points (95 % interval {low:+.1} to \
         {high:+.1}); in pairs with the same draws {} are better, {} worse.",
        share_words(&optimised.outcome, &optimised.of_scene),
        share_words(&optimised.outcome, &optimised.of_best),
        100.0 * gain.value,
        gain.better,
        gain.worse
    )
}

fn tables(optimised: &Optimised) -> Vec<Grid> {
    let strings = |cells: &[&str]| cells.iter().map(|cell| (*cell).to_owned()).collect::<Vec<_>>();
    let between = |ends: [f64; 2]| format!("{} to {}", number(ends[0]), number(ends[1]));
    let values = optimised.parameters.iter().map(|parameter| {
        vec![
            parameter.path.clone(),
            between(parameter.within),
            number(parameter.scene),
            number(parameter.best),
        ]
    });
    let round = |(index, round): (usize, &SearchRound)| {
        let mut cells = vec![format!("{}", index + 1)];
        cells.extend(round.within.iter().map(|ends| between(*ends)));
        cells.push(format!("{} of {}", round.came.captured, round.came.of));
        cells.push(round.best.iter().map(|value| number(*value)).collect::<Vec<_>>().join(", "));
        let [low, high] = round.probability.interval_95.map(|bound| 100.0 * bound);
        cells.push(format!("{:.0} ({low:.0} to {high:.0})", 100.0 * round.probability.value));
        cells
    };
    let paths = optimised.parameters.iter().map(|parameter| parameter.path.clone());
    let mut head = strings(&["round"]);
    head.extend(paths);
    head.extend([optimised.outcome.clone(), "best".to_owned(), "there [%]".to_owned()]);
    vec![
        Grid {
            title: "Best values",
            n_words: 2,
            head: strings(&["parameter", "looked for in", "scene", "best"]),
            rows: values.collect(),
        },
        Grid {
            title: "Rounds",
            n_words: 1,
            head,
            rows: optimised.rounds.iter().enumerate().map(round).collect(),
        },
    ]
}

/// The members of all rounds along one parameter.
fn panel(optimised: &Optimised, rounds: &[Vec<MapSample>], axis: usize) -> Panel {
    let parameter = &optimised.parameters[axis];
    let mut marks = Vec::new();
    for (index, (round, samples)) in optimised.rounds.iter().zip(rounds).enumerate() {
        let base = index as f64;
        let points = round.within[axis].map(|end| (end, base)).to_vec();
        marks.push(Mark::Line { points, colour: colour(2), width: 2, dashed: false });
        for (number, sample) in samples.iter().enumerate() {
            // Side by side: dots of one height would hide each other.
            let height = base + 0.15 + 0.6 * (number % 16) as f64 / 15.0;
            let (colour, shape) = if sample.came { (colour(0), Dot::Full) } else { (colour(1), Dot::Ring) };
            marks.push(Mark::Dot { at: (sample.at[axis], height), colour, shape });
        }
    }
    marks.push(Mark::Line {
        points: vec![(parameter.best, 0.0), (parameter.best, optimised.rounds.len() as f64)],
        colour: colour(2),
        width: 1,
        dashed: true,
    });
    let keys = vec![
        Key { words: optimised.outcome.clone(), colour: colour(0), swatch: Swatch::Field },
        Key { words: format!("not {}", optimised.outcome), colour: colour(1), swatch: Swatch::Line },
    ];
    let [low, high] = parameter.within;
    let y = Axis::fixed("round", 0.0, optimised.rounds.len() as f64);
    Panel { keys, ..Panel::of_curves(Axis::fixed(&parameter.path, low, high), y, 300, marks) }
}
