//! `tumblenet compare`: one scene in several variants, or several scenes, side by side.

use std::path::{Path, PathBuf};

use clap::Args;
use tumblenet::metrics::conservation::SCALAR;
use tumblenet::report::{compare as report, files};
use tumblenet::scene::Source;
use tumblenet::study::compare::track::TrackMember;
use tumblenet::study::compare::variants::{Variant, of_scenes};
use tumblenet::study::compare::{self, CompareRequest, Comparison};
use tumblenet::study::{ensemble, settle};

use super::members::Kept;
use super::reading::Reading;
use super::run::{Until, believed, duration};
use super::terminal::{Progress, stage};
use super::{Error, Format, interrupt, json, print, say};

/// Arguments of `compare`.
#[derive(Args)]
pub struct Arguments {
    /// Scene files, or names of built-in scenes; several are set side by side as they are written.
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<String>,
    /// Solver pairs, `joints+rapier,joints+impulse`; left out: all that the scene allows, or its own with `--vary`.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    solvers: Option<Vec<String>>,
    /// A variant for each value of a key: `solver.step_s=0.0005,0.001`, or of a range of so many:
    /// `target.spin_rad_s.0=0:2:9`; several are combined.
    #[arg(long, value_name = "PATH=V1,V2")]
    vary: Vec<String>,
    /// Changes a value of the scene first, as `run` does.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    changes: Vec<String>,
    #[command(flatten)]
    reading: Reading,
    /// Runs of each variant, whose folded knots differ by up to `--perturb` metres.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=200))]
    members: u32,
    /// Largest displacement of a knot along each axis [m].
    #[arg(long, value_name = "METRES", default_value_t = 1e-6, value_parser = at_least_zero)]
    perturb: f64,
    /// Seed of the perturbations.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Runs agree while their largest bullet difference is below this [m]; left out: 1 % of the net's side.
    #[arg(long, allow_hyphen_values = true, value_name = "METRES", value_parser = at_least_zero)]
    trust_distance: Option<f64>,
    /// Runs on beyond the scene's end until the verdict is decided: settled, or the net has gone.
    #[arg(long, value_enum, value_name = "WHAT")]
    until: Option<Until>,
    /// With `--until`: for so long at most [s]; left out: ten times the longest scene's duration.
    #[arg(long, value_name = "S", requires = "until", value_parser = duration)]
    at_most: Option<f64>,
    /// One run after another: wall times that can be compared.
    #[arg(long)]
    serial: bool,
    /// Folder for the results; left out: results/NAME/compare.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

fn at_least_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("a number of metres of at least 0, as in 1e-6".to_owned()),
    }
}

/// Runs the variants and writes the comparison.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading and checking");
    let limits = arguments.reading.limits()?;
    let mut sources = Vec::new();
    for scene in &arguments.scenes {
        let mut source = Source::find_within(scene, limits)?;
        source.change(&arguments.changes)?;
        sources.push(source);
    }
    let variants = of_scenes(&sources, arguments.solvers.as_deref(), &arguments.vary)?;
    let name = if let [source] = &sources[..] { source.name.as_str() } else { "compare" };
    let out = arguments.out.clone().unwrap_or_else(|| match &sources[..] {
        [source] => Path::new("results").join(&source.name).join("compare"),
        _ => Path::new("results").join("compare"),
    });
    // Before the runs, not after: an unwritable folder should cost no run.
    files::make_folder(&out)?;

    // One of them can be run, or `variants` would have said so.
    let Some(base) = variants.iter().find_map(|variant| variant.case.as_ref().ok()) else { return Ok(()) };
    let cases = || variants.iter().filter_map(|variant| variant.case.as_ref().ok());
    let longest = cases().map(|case| case.scene().duration_s.0).fold(0.0, f64::max);
    let at_most = arguments.until.map(|_| arguments.at_most.unwrap_or(settle::TIMES * longest));
    let request = CompareRequest {
        ensemble: ensemble::EnsembleRequest {
            members: arguments.members as usize,
            perturb_m: arguments.perturb,
            seed: arguments.seed,
            at_most_s: at_most,
        },
        trust_distance_m: arguments.trust_distance.unwrap_or_else(|| compare::trust_distance(base)),
        serial: arguments.serial,
    };
    request.ensemble.check(base)?;
    let title = match &sources[..] {
        [_] => base.scene().title.clone(),
        _ => arguments.scenes.join(", "),
    };
    interrupt::leaves(format!(
        "finished members are kept in {}; the same command goes on from them",
        out.display()
    ));
    stage("running");
    let members = members(name, &variants, &request, &out)?;
    stage("comparing and writing");
    let mut comparison = Comparison::of(&title, &variants, &request, &members);
    for (compared, variant) in comparison.variants.iter_mut().zip(&variants) {
        let changes = arguments.changes.iter().chain(&variant.changes);
        compared.again = ensemble::again(&arguments.scenes[variant.scene], changes, &request.ensemble);
    }
    report::write(&out, &comparison)?;
    match arguments.format {
        Format::Json => print(&json(&comparison))?,
        Format::Text => {
            say(&report::text(&comparison))?;
            say(&format!("Results: {}", out.join("compare.html").display()))?;
        }
    }
    all_finished(&comparison)
}

/// The members of every variant: those kept before, and those run now.
fn members(
    name: &str,
    variants: &[Variant],
    request: &CompareRequest,
    out: &Path,
) -> Result<Vec<Vec<TrackMember>>, Error> {
    let mut kept: Vec<Option<Kept>> = Vec::new();
    for variant in variants {
        let case = variant.case.as_ref().ok();
        kept.push(case.map(|case| Kept::open(out, "runs", case, &request.ensemble)).transpose()?);
    }
    // A run that shared the machine has no fair wall time.
    let fair = |member: &TrackMember| !request.serial || member.at_once == 1;
    let known: Vec<Vec<TrackMember>> = kept
        .iter()
        .map(|kept| {
            kept.as_ref().map_or_else(Vec::new, |kept| {
                kept.known(request.ensemble.members, |member: &TrackMember| member.member)
            })
        })
        .map(|members: Vec<TrackMember>| members.into_iter().filter(fair).collect())
        .collect();
    let bar = Progress::new((request.ensemble.members * kept.iter().flatten().count()) as u64, name);
    bar.set(known.iter().map(Vec::len).sum::<usize>() as u64);
    let members = compare::run(variants, request, known, |variant, member| {
        if let Some(kept) = &kept[variant] {
            kept.keep(member.member, member);
        }
        bar.one_more();
    });
    drop(bar);
    for kept in kept.into_iter().flatten() {
        kept.finish()?;
    }
    Ok(members)
}

/// A variant of which nothing was finished is a failed run.
fn all_finished(comparison: &Comparison) -> Result<(), Error> {
    let failed = |variant: &&compare::Compared| variant.outcome.is_none() && variant.refused.is_empty();
    let labels: Vec<&str> =
        comparison.variants.iter().filter(failed).map(|variant| variant.label.as_str()).collect();
    if !labels.is_empty() {
        return Err(Error::Expectation(format!("no member was finished of {}", labels.join(", "))));
    }
    let created = |outcome: &compare::Outcome| Some(outcome.scalars.get(SCALAR)?.max);
    let all = comparison.ran().filter_map(|(_, variant, outcome)| Some((variant, created(outcome)?)));
    let worst = all.max_by(|one, other| one.1.total_cmp(&other.1));
    worst.map_or(Ok(()), |(variant, created)| {
        believed(&format!("{}, its worst member", variant.label), created)
    })
}
