//! `tumblenet map`: the probability of capture, or of another outcome, over inputs of a sweep.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use tumblenet::problems::Problems;
use tumblenet::report::map::{self as report, MapRequest};
use tumblenet::report::rows::KeptRows;
use tumblenet::study::sweep::Sweep;
use tumblenet::study::sweep::outcome::MapOutcome;
use tumblenet::study::sweep::refine::Refinement;

use super::reading::Reading;
use super::reported::Told;
use super::terminal::stage;
use super::{Error, sweep};

/// Arguments of `map`.
#[derive(Args)]
pub struct Arguments {
    /// Folder of a sweep's results, of which all rows that are there count; with --refine a study, whose members are run.
    #[arg(value_name = "DIR|STUDY")]
    of: String,
    /// One to four columns of its table; more than two are drawn in slices.
    #[arg(long, value_name = "A,B", value_delimiter = ',', required = true)]
    over: Vec<String>,
    /// The probability of what: captured at a run's end, settled, or held@T, first held by then and not lost until the
    /// time T [s].
    #[arg(long, value_name = "WHAT", default_value = "captured")]
    outcome: MapOutcome,
    /// Boxes along each input, for the raw shares; left out: 6, or 3 of more than two inputs.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=100))]
    boxes: Option<u16>,
    /// Runs members of the study, round after round where the map is least certain, until the share of every box is known to
    /// so much, by bounds that hold whenever one looks.
    #[arg(long, value_name = "HALF-WIDTH", value_parser = half_width)]
    refine: Option<f64>,
    /// Members of a round.
    #[arg(long, value_name = "N", requires = "refine", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    batch: u32,
    #[command(flatten)]
    reading: Reading,
    /// Folder for the result; left out: that of the sweep, or results/NAME of a study.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    told: Told,
}

/// Half the width of a share's bounds.
fn half_width(text: &str) -> Result<f64, String> {
    let allowed = || "allowed: a number from 0.01 to 0.5".to_owned();
    text.parse().ok().filter(|width| (0.01..=0.5).contains(width)).ok_or_else(allowed)
}

/// Draws the map of the arguments.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    let n_boxes = arguments.boxes.unwrap_or(if arguments.over.len() > 2 { 3 } else { 6 }).into();
    let request = MapRequest { over: arguments.over.clone(), outcome: arguments.outcome, n_boxes };
    match arguments.refine {
        Some(half_width) => refine(arguments, &request, half_width),
        None => {
            stage("reading the rows");
            let folder = Path::new(&arguments.of);
            let (plan, kept) = sweep::kept(folder)?;
            let (map, samples) = request.fill(&plan, &kept, None)?;
            let out = arguments.out.as_deref().unwrap_or(folder);
            tell(arguments, out, &map, &samples, plan.study.seed)
        }
    }
}

/// Runs members where the map is least certain. Each round is chosen from the answers of those before alone, so that a run
/// that was interrupted, or begun in a folder with more rows, asks for the same.
fn refine(arguments: &Arguments, request: &MapRequest, half_width: f64) -> Result<(), Error> {
    stage("reading and checking");
    request.check()?;
    let study = Sweep::load(&arguments.of, arguments.reading.limits()?)?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join(study.name()));
    let at = study.inputs(&request.over, "--over")?;
    let n_boxes = request.n_boxes.saturating_pow(request.over.len() as u32);
    if n_boxes > at.len() {
        let mut problems = Problems::new(study.name());
        let found = format!("{n_boxes} boxes");
        problems.add("--boxes", found, format!("no more boxes than the study has members: {}", at.len()));
        return Err(problems.into());
    }
    let mut refinement = Refinement::of(&request.over, &at, request.n_boxes);
    let mut asked = BTreeSet::new();
    loop {
        let chosen: BTreeSet<u64> =
            refinement.next(half_width, arguments.batch as usize).into_iter().collect();
        let (plan, _) = sweep::run_in(&study, |member| chosen.contains(&member), &out)?;
        let mut kept = KeptRows::read(&out, &plan);
        if chosen.is_empty() {
            kept.rows.retain(|member, _| asked.contains(member));
            let (map, samples) = request.fill(&plan, &kept, Some((&refinement, half_width)))?;
            return tell(arguments, &out, &map, &samples, plan.study.seed);
        }
        kept.rows.retain(|member, _| chosen.contains(member));
        let mut problems = Problems::new(&arguments.of);
        let answers = report::answers(&plan, &kept, (&request.over, request.outcome), &mut problems);
        for answer in problems.into_result(Some(answers))? {
            if let Some(came) = answer.came.filter(|_| answer.has_verdict) {
                refinement.answer(answer.member, came);
            }
        }
        asked.extend(chosen);
    }
}

fn tell(
    arguments: &Arguments,
    out: &Path,
    map: &tumblenet::study::sweep::map::CaptureMap,
    samples: &[tumblenet::study::sweep::map::MapSample],
    seed: u64,
) -> Result<(), Error> {
    stage("writing");
    let n_boxes = arguments.boxes.unwrap_or(3).into();
    report::write(out, map, samples, n_boxes, seed)?;
    arguments.told.tell(map, &format!("{}\n{}", map.title, report::words(map)), &out.join("map.html"))
}
