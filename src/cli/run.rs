//! `tumblenet run`: one scene, or an ensemble of it.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, ValueEnum};
use tumblenet::case::Case;
use tumblenet::limits::{Limit, Limits};
use tumblenet::metrics::conservation::{CREATED, SCALAR, is_too_much};
use tumblenet::metrics::summary::Summary;
use tumblenet::metrics::verdict::Verdict;
use tumblenet::metrics::warnings;
use tumblenet::problems::Problems;
use tumblenet::report::{ensemble as report, files, gltf, results, table, vtk};
use tumblenet::scene::{self, Source};
use tumblenet::study::cost::accuracy::Accuracy;
use tumblenet::study::cost::calibration;
use tumblenet::study::ensemble::{self, Ensemble, EnsembleRequest, Member};
use tumblenet::study::settle;

use super::members::Kept;
use super::reading::Reading;
use super::terminal::{self, Progress, remark, stage};
use super::{Error, Format, interrupt, json, print, say};

/// Arguments of `run`.
#[derive(Args)]
#[command(group = ArgGroup::new("perturbed").args(["ensemble", "member"]))]
pub struct Arguments {
    /// Scene file, or name of a built-in scene.
    scene: String,
    /// Folder for the results; left out: results/NAME.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Changes a value of the scene first: `solver.step_s=0.0005`, `target.spin_rad_s.0=2`; `null` removes a key.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    changes: Vec<String>,
    /// Takes a solver setting that is known to reach an accuracy before contact: `1mm`, or `fast`, `standard`, `fine`
    /// (a thousandth, a ten-thousandth, a hundred-thousandth of the net's side).
    #[arg(long, value_name = "LENGTH", value_parser = |text: &str| text.parse::<Accuracy>())]
    accuracy: Option<Accuracy>,
    #[command(flatten)]
    reading: Reading,
    /// Runs on beyond the scene's end until the verdict is decided: settled, or the net has gone.
    #[arg(long, value_enum, value_name = "WHAT")]
    until: Option<Until>,
    /// With `--until`: for so long at most [s]; left out: ten times the scene's duration.
    #[arg(long, value_name = "S", requires = "until", value_parser = duration)]
    at_most: Option<f64>,
    /// Writes the run for other programs too: for ParaView (vtk/run.pvd), for Blender (run.glb).
    #[arg(long, value_enum, value_name = "KIND", value_delimiter = ',')]
    export: Vec<Export>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
    /// Runs N copies whose folded knots differ by up to `--perturb` metres; what the scene calls uncertain is drawn for each.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    ensemble: Option<u32>,
    /// Runs one member of such an ensemble, to be watched: the same bits as there.
    #[arg(long, value_name = "N", conflicts_with = "ensemble")]
    member: Option<u32>,
    /// After an ensemble: runs the first member of this kind again and writes its replay.
    #[arg(long, value_enum, value_name = "WHICH", requires = "ensemble")]
    replay: Option<Which>,
    /// Largest displacement of a knot along each axis [m].
    #[arg(long, value_name = "METRES", default_value_t = 1e-6, requires = "perturbed", value_parser = length)]
    perturb: f64,
    /// Seed of the perturbations, and of what is drawn.
    #[arg(long, value_name = "S", default_value_t = 1, requires = "perturbed")]
    seed: u64,
}

/// What a run goes on for.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Until {
    /// Until the verdict is decided.
    Settled,
}

/// What else a run is written as.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Export {
    /// VTK: a file for each body and frame, and a list of them.
    Vtk,
    /// glTF 2.0: one animated file.
    Gltf,
}

/// A member worth watching.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Which {
    /// The first that was lost.
    #[value(name = "first-lost")]
    Lost,
    /// The first that is held.
    #[value(name = "first-held")]
    Held,
    /// The first that was never held.
    #[value(name = "first-missed")]
    Missed,
}

impl Which {
    fn is(self, verdict: Verdict) -> bool {
        match self {
            Which::Lost => verdict == Verdict::Lost,
            Which::Held => verdict.is_held(),
            Which::Missed => matches!(verdict, Verdict::Missed | Verdict::NeverMet),
        }
    }
}

/// A time above zero [s].
pub(super) fn duration(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(time) if time.is_finite() && time > 0.0 => Ok(time),
        _ => Err("a number above 0, in seconds".to_owned()),
    }
}

/// A length of at least zero [m].
fn length(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(length) if length.is_finite() && length >= 0.0 => Ok(length),
        _ => Err("a number of at least 0, in metres".to_owned()),
    }
}

/// Runs the built-in default scene.
pub fn default_scene() -> Result<(), Error> {
    let case = Case::load(scene::DEFAULT, &[])?;
    let out = default_folder(&case);
    let summary = one(&case, None, &out, &[])?;
    say(&table::summary(&summary))?;
    say(&format!(
        "\nLook at it: open {} in a browser.\nMore scenes: `tumblenet list`; another run: `tumblenet run NAME`.",
        out.join("replay.html").display()
    ))?;
    met(&case, &summary)
}

/// Runs the scene of the arguments.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading and checking");
    let limits = arguments.reading.limits()?;
    let case = match arguments.accuracy {
        None => Case::load_changed(&arguments.scene, &arguments.changes, limits)?,
        Some(accuracy) => with_accuracy(&arguments.scene, &arguments.changes, limits, accuracy)?,
    };
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(&case));
    let at_most = at_most(&case, arguments)?;
    let request = |members: u32| EnsembleRequest {
        members: members as usize,
        perturb_m: arguments.perturb,
        seed: arguments.seed,
        at_most_s: at_most,
    };
    for warning in warnings::before(&case) {
        remark(&format!("warning: {warning}"));
    }
    if let Some(members) = arguments.ensemble {
        if limits.exceeded(Limit::Members, f64::from(members)) {
            let mut problems = Problems::new("--ensemble");
            problems.add("", members, limits.allowed(Limit::Members));
            return Err(problems.into());
        }
        let request = request(members);
        request.check(&case)?;
        return many(&case, &request, &out, arguments);
    }
    let (case, out) = match arguments.member {
        None => (case, out),
        Some(member) => {
            let case = ensemble::member(&case, &request(0), member as usize)?;
            let out = arguments.out.clone().unwrap_or_else(|| watched(&out, member as usize));
            (case, out)
        }
    };
    files::recover(&out);
    let earlier = out.join("summary.json").exists();
    let summary = one(&case, at_most, &out, &arguments.export)?;
    match arguments.format {
        Format::Json => print(&json(&summary))?,
        Format::Text => {
            say(&table::summary(&summary))?;
            let instead = if earlier { ", in place of an earlier run's" } else { "" };
            say(&format!("Results: {}{instead}", out.display()))?;
        }
    }
    met(&case, &summary)
}

/// The scene with a setting that reaches `accuracy` on its own flight. Which it is goes to standard error.
fn with_accuracy(scene: &str, changes: &[String], limits: Limits, accuracy: Accuracy) -> Result<Case, Error> {
    stage("calibrating");
    let mut source = Source::find_within(scene, limits)?;
    source.change(changes)?;
    let found = calibration::calibrate(&source, changes, accuracy)?;
    remark(&format!("accuracy: {}", found.words()));
    // The user's own word last: what is set by hand stays.
    source.set(&found.changes)?;
    source.set(changes)?;
    Ok(Case::build(&source)?)
}

/// Where the results go when no folder is named.
pub(super) fn default_folder(case: &Case) -> PathBuf {
    Path::new("results").join(case.name())
}

/// For how long at most a run goes on beyond the scene's end [s]; none: it ends there.
fn at_most(case: &Case, arguments: &Arguments) -> Result<Option<f64>, Problems> {
    let Some(Until::Settled) = arguments.until else { return Ok(None) };
    let mut problems = Problems::new("--until settled");
    let at_most = arguments.at_most.unwrap_or(settle::TIMES * case.scene().duration_s.0);
    settle::check(case, at_most, "--at-most", &mut problems);
    problems.into_result(Some(Some(at_most)))
}

/// Runs `case` and writes all its results to the folder `out`, with all `exports`.
pub(super) fn one(
    case: &Case,
    at_most: Option<f64>,
    out: &Path,
    exports: &[Export],
) -> Result<Summary, Error> {
    interrupt::leaves("nothing of this run was written");
    // Before the run, not after: an unwritable folder should cost no run.
    results::make_place(out)?;
    stage("running");
    let bar = Progress::new(1000, case.name());
    let (run, curves) = settle::run(case, at_most, |share| bar.set((1000.0 * share) as u64))?;
    drop(bar);
    let summary = Summary::of(case, &run, &curves);
    terminal::last_stage_ended();
    tell_shares(&summary);
    stage("writing");
    results::write(out, case, &run, &curves, &summary)?;
    for export in exports {
        let place = match export {
            Export::Vtk => vtk::write(out, case, &run)?,
            Export::Gltf => gltf::write(out, case, &run)?,
        };
        remark(&format!("written too: {}", place.display()));
    }
    interrupt::leaves(format!("the results are in {}", out.display()));
    if let Some(time) = run.first_not_finite() {
        return Err(Error::Expectation(format!(
            "{}: not a finite number in the series at {time} s",
            case.name()
        )));
    }
    summary.sound().map_err(|why| Error::Expectation(format!("{}: {why}", case.name())))
}

/// What of the time of a run was spent on what, for who wants to hear it.
fn tell_shares(summary: &Summary) {
    if terminal::is_verbose() {
        for (name, share) in &summary.time_shares {
            remark(&format!("  of running, {name}: {:.3} s", share * summary.wall_s));
        }
    }
}

/// Whether the run is to be believed, and the summary what the scene expects.
fn met(case: &Case, summary: &Summary) -> Result<(), Error> {
    believed(case.name(), summary.conservation.energy_created)?;
    let missed = summary.missed(&case.scene().expect);
    if missed.is_empty() {
        return Ok(());
    }
    Err(Error::Expectation(format!("{} is not what it expects:\n  {}", case.name(), missed.join("\n  "))))
}

/// Whether a run, or the worst of several, that `created` so much energy [-] is to be believed.
pub(super) fn believed(name: &str, created: f64) -> Result<(), Error> {
    if !is_too_much(created) {
        return Ok(());
    }
    Err(Error::Expectation(format!(
        "{name}: the method created {created:.1e} of the launch energy and the work put in, more than {CREATED}: not to be believed"
    )))
}

/// Where a member's results go, below those of its ensemble.
fn watched(out: &Path, member: usize) -> PathBuf {
    out.join(format!("member-{member}"))
}

fn many(case: &Case, request: &EnsembleRequest, out: &Path, arguments: &Arguments) -> Result<(), Error> {
    let kept = Kept::open(out, "members", case, request)?;
    let place = out.display();
    interrupt::leaves(format!("finished members are kept in {place}; the same command goes on from them"));
    let known: Vec<Member> = kept.known(request.members, |member: &Member| member.member);
    stage("running the members");
    let bar = Progress::new(request.members as u64, case.name());
    bar.set(known.len() as u64);
    let members = ensemble::run(case, request, known, |member| {
        kept.keep(member.member, member);
        bar.one_more();
    });
    drop(bar);
    stage("writing");
    kept.finish()?;
    let ensemble = Ensemble::of(case, request, &members);
    if let Some(which) = arguments.replay {
        watch(case, request, &ensemble, which, out, arguments)?;
    }
    report::write(out, &arguments.scene, &arguments.changes, &ensemble)?;
    match arguments.format {
        Format::Json => print(&json(&ensemble))?,
        Format::Text => {
            say(&table::ensemble(&ensemble))?;
            say(&format!("Results: {}", out.join("ensemble.html").display()))?;
        }
    }
    any_finished(case.name(), &ensemble)
}

/// An ensemble of which no member was finished is a failed run. A member that failed is left out of all numbers; one
/// that is not to be believed is in them.
fn any_finished(name: &str, ensemble: &Ensemble) -> Result<(), Error> {
    match ensemble.failures.first_key_value() {
        Some((member, why)) if ensemble.failures.len() == ensemble.request.members => {
            Err(Error::Expectation(format!("no member was finished; member {member}: {why}")))
        }
        _ => ensemble
            .scalars
            .get(SCALAR)
            .map_or(Ok(()), |created| believed(&format!("{name}, its worst member"), created.max)),
    }
}

/// Runs the first member of the kind `which` again and writes all its results.
fn watch(
    case: &Case,
    request: &EnsembleRequest,
    ensemble: &Ensemble,
    which: Which,
    out: &Path,
    arguments: &Arguments,
) -> Result<(), Error> {
    let found = ensemble.verdicts.iter().find(|ended| which.is(ended.verdict));
    let Some(ended) = found else {
        remark(&format!("--replay: no member of this kind among {}", ensemble.verdicts.len()));
        return Ok(());
    };
    let folder = watched(out, ended.member);
    let member = ensemble::member(case, request, ended.member)?;
    one(&member, request.at_most_s, &folder, &arguments.export)?;
    remark(&format!("member {}: {}", ended.member, folder.join("replay.html").display()));
    Ok(())
}
