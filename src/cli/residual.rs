//! `tumblenet residual`: how far a run is from an experiment, or from another run.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use tumblenet::case::Case;
use tumblenet::limits::{self, Limit, Limits};
use tumblenet::problems::Problems;
use tumblenet::report::{recorded, residual as report};
use tumblenet::run::Run;
use tumblenet::study::experiment::align::Align;
use tumblenet::study::experiment::paths::KnotPaths;
use tumblenet::study::experiment::residual::ResidualRequest;
use tumblenet::study::experiment::tracks::{MarkerTracks, Matching};

use super::Error;
use super::reading::Reading;
use super::reported::Told;
use super::terminal::{Progress, stage};

/// Arguments of `residual`.
#[derive(Args)]
pub struct Arguments {
    /// Folder of a run's results; or a scene, which is run.
    #[arg(value_name = "RUN")]
    run: String,
    /// Tracks of markers as CSV, under the heading `time_s,marker,x_m,y_m,z_m`; or the folder of another run.
    #[arg(value_name = "EXPERIMENT")]
    experiment: PathBuf,
    /// What is fitted first: clock and frame of the experiment; left out: both for tracks, nothing for a run.
    #[arg(long, value_enum, value_name = "WHAT")]
    align: Option<AlignWhat>,
    /// How markers find their knots: by name (`bullet-1`, `knot-5-5`, `knot-60`), or the nearest where first seen.
    #[arg(long, value_enum, value_name = "HOW", default_value = "name")]
    matching: MatchingHow,
    /// Changes a value of the scene first, as `run` does.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    changes: Vec<String>,
    #[command(flatten)]
    reading: Reading,
    /// Folder for the result; left out: results/NAME/residual.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    told: Told,
}

/// What is fitted first.
#[derive(Clone, Copy, ValueEnum)]
enum AlignWhat {
    /// Nothing.
    None,
    /// The clock.
    Time,
    /// The frame.
    Pose,
    /// Clock and frame.
    Both,
}

/// How markers find their knots.
#[derive(Clone, Copy, ValueEnum)]
enum MatchingHow {
    /// By their names.
    Name,
    /// By the place where they were seen first.
    Nearest,
}

/// Sets run and experiment side by side.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading and checking");
    let limits = arguments.reading.limits()?;
    let is_run = arguments.experiment.is_dir();
    let tracks = if is_run { None } else { Some(tracks(&arguments.experiment, &limits)?) };
    let (name, paths) = run(arguments, limits)?;
    let tracks = match tracks {
        Some(tracks) => tracks,
        None => markers(&recorded::paths(&arguments.experiment)?, &paths),
    };
    stage("comparing");
    let align = match arguments.align {
        Some(AlignWhat::None) => Align::None,
        Some(AlignWhat::Time) => Align::Time,
        Some(AlignWhat::Pose) => Align::Pose,
        Some(AlignWhat::Both) => Align::Both,
        None if is_run => Align::None,
        None => Align::Both,
    };
    let matching = match arguments.matching {
        MatchingHow::Name => Matching::Name,
        MatchingHow::Nearest => Matching::Nearest,
    };
    let experiment = arguments.experiment.display().to_string();
    let request = ResidualRequest { matching, align };
    let residuals = request.residuals((&arguments.run, &paths), (&experiment, &tracks))?;
    stage("writing");
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join(name).join("residual"));
    report::write(&out, &residuals)?;
    arguments.told.tell(&residuals, &report::text(&residuals), &out.join("residual.html"))
}

/// The run's name, and where its knots were: read from its folder, or run now.
fn run(arguments: &Arguments, limits: Limits) -> Result<(String, KnotPaths), Error> {
    let folder = Path::new(&arguments.run);
    if folder.is_dir() {
        if !arguments.changes.is_empty() {
            let mut problems = Problems::new("--set");
            problems.add("", "a run that is over", "changes of a scene that is run now");
            return Err(problems.into());
        }
        let name =
            folder.file_name().map_or_else(|| "run".to_owned(), |name| name.to_string_lossy().into_owned());
        return Ok((name, recorded::paths(folder)?));
    }
    let case = Case::load_changed(&arguments.run, &arguments.changes, limits)?;
    stage("running");
    let bar = Progress::new(1000, case.name());
    let run = Run::of(&case, |share| bar.set((1000.0 * share) as u64))?;
    Ok((case.name().to_owned(), KnotPaths::of(&case, run)))
}

/// The knots of the run `other` as markers: all of a net of the same knots as `paths`, else its bullets.
fn markers(other: &KnotPaths, paths: &KnotPaths) -> MarkerTracks {
    let tracks = MarkerTracks::of(other);
    if other.names == paths.names { tracks } else { tracks.bullets() }
}

/// The tracks in the file `path`.
fn tracks(path: &Path, limits: &Limits) -> Result<MarkerTracks, Problems> {
    let mut problems = Problems::new(path.display().to_string());
    let text = limits::read_file(path, limits.of(Limit::Text));
    let text = text.map_err(|error| {
        problems.add(
            "",
            error,
            format!("a folder of a run, or tracks as CSV of {}", limits.allowed(Limit::Text)),
        );
    });
    let tracks = text.ok().and_then(|text| MarkerTracks::read(&text, &mut problems));
    problems.into_result(tracks)
}
