//! `tumblenet figure`: figures of one run, or of several in the same axes, for print.

use std::path::{Path, PathBuf};

use clap::Args;
use tumblenet::case::Case;
use tumblenet::limits::Limits;
use tumblenet::problems::Problems;
use tumblenet::report::figure::FigureWords;
use tumblenet::report::recorded::RecordedRun;

use super::reading::Reading;
use super::run::{default_folder, one};
use super::terminal::stage;
use super::{Error, say};

/// Arguments of `figure`.
#[derive(Args)]
pub struct Arguments {
    /// Folders of runs' results; or scenes, which are run first. Several are drawn in the same axes.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<String>,
    /// Which figures: strip, deployment, momentum, energy, motion, impulses, closing, tension; left out: all that the runs
    /// have data for.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    of: Vec<String>,
    /// Times of the strip's pictures [s]: `0.5,1,1.5,2`; left out: first contact, held, settled, the end.
    #[arg(long, value_name = "T1,T2", value_delimiter = ',', allow_hyphen_values = true)]
    at: Vec<String>,
    /// Where the strip is seen from: side, front, top, oblique; several make a row each; left out: side.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    view: Vec<String>,
    /// Width on paper: `85mm` for a column; left out: 170mm.
    #[arg(long, value_name = "WIDTH")]
    width: Option<String>,
    /// Kinds of files: svg, png (of a program built with `--features png`); left out: svg.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    format: Vec<String>,
    /// Dots an inch of png; left out: 300.
    #[arg(long, value_name = "DOTS")]
    dpi: Option<f64>,
    /// What the runs are called; left out: what varies between their folders.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    label: Vec<String>,
    /// Changes a value of the scenes first, as `run` does.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    changes: Vec<String>,
    #[command(flatten)]
    reading: Reading,
    /// Folder for the figures; left out: that of the run, of several results/figures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// What a RUN is: a folder that has been read, or a scene that is run.
enum Given {
    Folder(PathBuf, Box<RecordedRun>),
    Scene(Box<Case>),
}

/// Draws the figures.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading and checking");
    let limits = arguments.reading.limits()?;
    let mut problems = Problems::new("figure");
    let words = FigureWords {
        of: arguments.of.clone(),
        at: arguments.at.clone(),
        view: arguments.view.clone(),
        width: arguments.width.clone(),
        format: arguments.format.clone(),
        dpi: arguments.dpi,
    };
    let request = words.read(&mut problems);
    let given = given(&arguments.runs, &arguments.changes, limits, &mut problems);
    let (Some(request), Some(given)) = (request, given) else { return Err(problems.into()) };
    let mut runs = Vec::new();
    for given in given {
        runs.push(match given {
            Given::Folder(folder, run) => (folder, *run),
            Given::Scene(case) => {
                let folder = default_folder(&case);
                one(&case, None, &folder, &[])?;
                let run = RecordedRun::read(&folder)?;
                (folder, run)
            }
        });
    }
    let out = arguments.out.clone().unwrap_or_else(|| match &runs[..] {
        [(folder, _)] => folder.clone(),
        _ => Path::new("results").join("figures"),
    });
    let Some(runs) = request.shown(runs, &arguments.label, &mut problems) else {
        return Err(problems.into());
    };
    stage("drawing and writing");
    for place in request.write(&runs, &out)? {
        say(&place.display().to_string())?;
    }
    Ok(())
}

/// The runs that are read, and the scenes that are to be run; none with a fault of any.
fn given(runs: &[String], changes: &[String], limits: Limits, problems: &mut Problems) -> Option<Vec<Given>> {
    let known = problems.list.len();
    let mut given = Vec::new();
    let mut fault = |run: &str, faults: Problems| problems.add_below(run, faults);
    for run in runs {
        let folder = Path::new(run);
        if folder.is_dir() {
            match RecordedRun::read(folder) {
                Ok(read) => given.push(Given::Folder(folder.to_owned(), Box::new(read))),
                Err(faults) => fault(run, faults),
            }
        } else {
            match Case::load_changed(run, changes, limits) {
                Ok(case) => given.push(Given::Scene(Box::new(case))),
                Err(faults) => fault(run, faults),
            }
        }
    }
    let all_over = given.iter().all(|given| matches!(given, Given::Folder(..)));
    if all_over && !changes.is_empty() && problems.list.len() == known {
        problems.add("--set", "runs that are over", "changes of a scene that is run now");
    }
    (problems.list.len() == known).then_some(given)
}
