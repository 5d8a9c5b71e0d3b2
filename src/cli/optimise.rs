//! `tumblenet optimise`: the values of a study's parameters that make an outcome likeliest.

use std::path::{Path, PathBuf};

use clap::Args;
use tumblenet::limits::Limits;
use tumblenet::problems::Problems;
use tumblenet::provenance::Provenance;
use tumblenet::report::map::{MemberAnswer, answers, no_regression};
use tumblenet::report::rows::KeptRows;
use tumblenet::report::{files, optimise as report};
use tumblenet::study::ensemble::Share;
use tumblenet::study::sweep::Sweep;
use tumblenet::study::sweep::map::MapSample;
use tumblenet::study::sweep::optimise::{Gain, Optimised, Search, SearchRound};
use tumblenet::study::sweep::outcome::MapOutcome;
use tumblenet::study::sweep::spec::SweepSpec;

use super::reading::Reading;
use super::reported::Told;
use super::terminal::stage;
use super::{Error, sweep};

/// Arguments of `optimise`.
#[derive(Args)]
pub struct Arguments {
    /// A study file, or a built-in study, of design "sobol": each round has its points, its parameters are looked for.
    #[arg(value_name = "STUDY")]
    study: String,
    /// The probability of what is made large: captured at a run's end, settled, or held@T, first held by then and not lost
    /// until the time T [s]. Undecided and failed members count as not.
    #[arg(long, value_name = "WHAT", default_value = "settled")]
    outcome: MapOutcome,
    /// Rounds, each in a box half as wide as the one before.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..=20))]
    rounds: u64,
    /// Fresh members of the best point, and of the scene as it is, that confirm the gain.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(2..=100_000))]
    confirm: u64,
    #[command(flatten)]
    reading: Reading,
    /// Folder for the results; left out: results/STUDY-optimised.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    told: Told,
}

/// Runs the rounds that are missing, and confirms what they find.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading and checking");
    let limits = arguments.reading.limits()?;
    let study = Sweep::load(&arguments.study, limits)?;
    let search = Search::of(&study)?;
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| Path::new("results").join(format!("{}-optimised", study.name())));
    files::make_folder(&out)?;
    let asked =
        Asked { study: &arguments.study, outcome: arguments.outcome, limits, columns: search.columns() };
    let (mut rounds, mut members) = (Vec::<SearchRound>::new(), Vec::new());
    let mut within = search.whole().clone();
    for number in 0..arguments.rounds {
        let folder = out.join(format!("round-{}", number + 1));
        let answered = asked.run(&folder, |spec| search.round(spec, number, &within))?;
        members.push(answered);
        let (best, probability, next) = search
            .told(&within, &members.concat())
            .ok_or_else(|| no_regression(&arguments.study, "parameters"))?;
        let came = share(members.last().into_iter().flatten().map(|sample| sample.came));
        rounds.push(SearchRound { within: search.ends(&within), came, best, probability });
        within = next;
    }
    let best = rounds.last().map(|round| round.best.clone()).unwrap_or_default();
    let fresh = |name: &str, at: Option<&[f64]>| {
        let change =
            |spec: &mut SweepSpec| search.confirmation(spec, arguments.rounds, arguments.confirm, at);
        asked.run(&out.join(name), change)
    };
    let [of_scene, of_best] = [fresh("scene", None)?, fresh("best", Some(&best))?];
    let pairs: Vec<(bool, bool)> = of_scene.iter().zip(&of_best).map(|(a, b)| (a.came, b.came)).collect();
    stage("writing");
    let optimised = Optimised {
        title: study.spec().title.clone(),
        outcome: arguments.outcome.to_string(),
        parameters: search.values(&best),
        rounds,
        of_scene: share(of_scene.iter().map(|sample| sample.came)),
        of_best: share(of_best.iter().map(|sample| sample.came)),
        gain: Gain::of(&pairs),
        provenance: Provenance::here(),
    };
    report::write(&out, &optimised, &members, study.spec().seed)?;
    arguments.told.tell(&optimised, &report::text(&optimised), &out.join("optimised.html"))
}

/// What every part of a search is asked.
struct Asked<'a> {
    study: &'a str,
    outcome: MapOutcome,
    limits: Limits,
    columns: Vec<String>,
}

impl Asked<'_> {
    /// The members of the study as `change` changes it, whose rows are kept in `folder`.
    fn run(&self, folder: &Path, change: impl FnOnce(&mut SweepSpec)) -> Result<Vec<MapSample>, Error> {
        let study = Sweep::load_with(self.study, self.limits, change)?;
        let (plan, _) = sweep::run_in(&study, |_| true, folder)?;
        let kept = KeptRows::read(folder, &plan);
        let mut problems = Problems::new(self.study);
        let all = answers(&plan, &kept, (&self.columns, self.outcome), &mut problems);
        if problems.list.is_empty() && !all.iter().any(|answer| answer.has_verdict) {
            problems.add(
                "scene",
                "no member with a verdict",
                "a scene with a target, of which something is finished",
            );
        }
        let all = problems.into_result(Some(all))?;
        let sample = |MemberAnswer { point, at, came, .. }| MapSample { point, at, came: came == Some(true) };
        Ok(all.into_iter().map(sample).collect())
    }
}

fn share(came: impl Iterator<Item = bool>) -> Share {
    let all: Vec<bool> = came.collect();
    Share::of(all.iter().filter(|came| **came).count(), all.len())
}
