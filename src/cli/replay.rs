//! `tumblenet replay`: one page of several runs, in step with each other.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::Value;
use tumblenet::limits;
use tumblenet::problems::Problems;
use tumblenet::report::figure::labels;
use tumblenet::report::{files, replay};

use super::terminal::stage;
use super::{Error, say};

/// Arguments of `replay`.
#[derive(Args)]
pub struct Arguments {
    /// Folders of runs' results: the first as in its own page, the others as ghosts within it or beside it.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// What the runs are called; left out: what varies between their folders.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    label: Vec<String>,
    /// Folder for the page; left out: results/replay.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Most bytes of a page that is read.
const MOST_BYTES: u64 = 256 << 20;

/// Most runs of a page: more have no colours left.
const MOST_RUNS: usize = 10;

/// Makes the page.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading");
    let mut problems = Problems::new("replay");
    let folders: Vec<&Path> = arguments.runs.iter().map(PathBuf::as_path).collect();
    let labels = labels::given_or_of(&arguments.label, &folders, (MOST_RUNS, ""), &mut problems);
    let data: Vec<Value> = arguments.runs.iter().filter_map(|run| data(run, &mut problems)).collect();
    problems.into_result(Some(()))?;
    stage("writing");
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join("replay"));
    files::make_folder(&out)?;
    let place = out.join("replay.html");
    let page = replay::together(labels.into_iter().zip(data).collect());
    files::write(&place, |file| file.write_all(page.as_bytes()))?;
    say(&place.display().to_string())
}

/// What the page of `run` shows.
fn data(run: &Path, problems: &mut Problems) -> Option<Value> {
    files::recover(run);
    let place = run.join("replay.html");
    let text = limits::read_file(&place, MOST_BYTES);
    let text =
        text.map_err(|error| problems.add(run.display().to_string(), error, "the folder of a run's results"));
    let data = replay::data(&String::from_utf8_lossy(&text.ok()?));
    if data.is_none() {
        problems.add(place.display().to_string(), "a page of another kind", "what `tumblenet run` wrote");
    }
    data
}
