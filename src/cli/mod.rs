//! The commands, one file each.

mod array_job;
mod check;
mod compare;
mod cost;
mod dependency;
mod figure;
mod fingerprint;
mod fit;
mod interrupt;
mod list;
mod manual;
mod map;
mod members;
mod new;
mod optimise;
mod reading;
mod replay;
mod report;
mod reported;
mod reproduce;
mod residual;
mod run;
mod schema;
mod sensitivity;
mod show;
mod stress;
mod sweep;
mod terminal;

use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};
use tumblenet::failure::Failure;
use tumblenet::problems::{Problems, visible};
use tumblenet::report::files::WriteError;

/// Where to begin.
const FIRST_STEPS: &str = "\
Without a command the default scene runs: a tumbling
Cubesat, caught and held.

First steps:
  tumblenet               the default scene, where to look
  tumblenet list          what is built in
  tumblenet new my.json   a scene of your own to begin with
  tumblenet run my.json   runs it; then open, in a browser,
                          results/my/replay.html
  tumblenet run --help    everything that a run takes
";

const GLOSSARY: &str = include_str!("glossary.txt");

/// Tether-net capture of tumbling space debris, on the Rapier rigid-body engine.
#[derive(Parser)]
#[command(version, about, after_help = FIRST_STEPS, after_long_help = format!("{FIRST_STEPS}\n{GLOSSARY}"))]
struct Program {
    #[command(flatten)]
    common: terminal::Common,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Writes a scene of your own to begin with, with notes.
    New(new::Arguments),
    /// Runs one scene, or an ensemble of it.
    #[command(after_long_help = GLOSSARY)]
    Run(run::Arguments),
    /// Runs one scene in several variants and sets them side by side.
    Compare(compare::Arguments),
    /// Measures what accuracy costs in time: every dial, on one scene.
    Cost(cost::Arguments),
    /// Runs the catalogue of hard cases: what must hold, and what does.
    Stress(stress::Arguments),
    /// Runs one scene at many points of its parameters: a row of a table for each member.
    Sweep(sweep::Arguments),
    /// Draws the probability of capture, or of another outcome, over one to four inputs of a sweep.
    Map(map::Arguments),
    /// Finds the values of a study's parameters that make a capture likeliest to hold.
    Optimise(optimise::Arguments),
    /// Finds which input of a sweep the spread of its numbers comes from.
    Sensitivity(sensitivity::Arguments),
    /// Says how strongly results depend on each parameter of a sweep, beside published numbers.
    Dependency(dependency::Arguments),
    /// Draws figures of a run for print, or of several runs in the same axes.
    Figure(figure::Arguments),
    /// Makes one replay page of several runs, in step with each other.
    Replay(replay::Arguments),
    /// Collects results of many kinds in one page: what was found first, then each with its figures and command.
    Report(report::Arguments),
    /// Says how far a run is from measured tracks of markers, or from another run.
    Residual(residual::Arguments),
    /// Finds which parameters make a scene meet measured tracks, and how well they are known.
    Fit(fit::Arguments),
    /// Sets every claim of the source beside what is found here.
    Reproduce(reproduce::Arguments),
    /// Reads and checks scenes, without running them.
    Check(check::Arguments),
    /// Lists what is built in: scenes, shapes, materials.
    List(list::Arguments),
    /// Shows a scene with every default filled in, and what a run of it consists of.
    Show(show::Arguments),
    /// Prints the JSON Schema of a kind of files: what is read, or a result.
    Schema {
        /// Of which kind of file.
        #[arg(value_enum, default_value = "scene")]
        of: schema::SchemaOf,
    },
    /// Prints completions of commands and options for a shell.
    Completions(manual::Completions),
    /// Prints the manual page.
    Man,
}

/// How results are printed.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A table for a person.
    Text,
    /// JSON for a program.
    Json,
}

/// Why a command ends without success.
#[derive(Debug, thiserror::Error)]
enum Error {
    #[error("{0}")]
    Input(#[from] Problems),
    #[error("{0}")]
    Run(#[from] Failure),
    #[error("{0}")]
    Write(#[from] WriteError),
    /// Results were written, but are not what the scene expects.
    #[error("{0}")]
    Expectation(String),
}

impl From<tumblenet::study::cost::Error> for Error {
    fn from(error: tumblenet::study::cost::Error) -> Error {
        match error {
            tumblenet::study::cost::Error::Input(problems) => Error::Input(problems),
            tumblenet::study::cost::Error::Run(failure) => Error::Run(failure),
        }
    }
}

impl Error {
    fn status(&self) -> u8 {
        match self {
            Error::Input(_) => 2,
            Error::Run(_) | Error::Write(_) | Error::Expectation(_) => 1,
        }
    }
}

/// Runs the command of the command line.
pub fn main() -> ExitCode {
    let program = Program::parse();
    interrupt::listen();
    let done = program.common.take_effect().map_err(Error::from).and_then(|()| obey(program.command));
    terminal::last_stage_ended();
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell(&format!("error: {error}"));
            ExitCode::from(error.status())
        }
    }
}

fn obey(command: Option<Command>) -> Result<(), Error> {
    match command {
        None => run::default_scene(),
        Some(Command::Run(arguments)) => run::main(&arguments),
        Some(Command::Compare(arguments)) => compare::main(&arguments),
        Some(Command::Cost(arguments)) => cost::main(&arguments),
        Some(Command::Stress(arguments)) => stress::main(&arguments),
        Some(Command::Check(arguments)) => check::main(&arguments),
        Some(Command::List(arguments)) => list::main(&arguments),
        Some(Command::Show(arguments)) => show::main(&arguments),
        Some(Command::New(arguments)) => new::main(&arguments),
        Some(Command::Sweep(arguments)) => sweep::main(&arguments),
        Some(Command::Map(arguments)) => map::main(&arguments),
        Some(Command::Optimise(arguments)) => optimise::main(&arguments),
        Some(Command::Sensitivity(arguments)) => sensitivity::main(&arguments),
        Some(Command::Dependency(arguments)) => dependency::main(&arguments),
        Some(Command::Figure(arguments)) => figure::main(&arguments),
        Some(Command::Replay(arguments)) => replay::main(&arguments),
        Some(Command::Report(arguments)) => report::main(&arguments),
        Some(Command::Residual(arguments)) => residual::main(&arguments),
        Some(Command::Fit(arguments)) => fit::main(&arguments),
        Some(Command::Reproduce(arguments)) => reproduce::main(&arguments),
        Some(Command::Schema { of }) => print(&json(&schema::of(of))),
        Some(Command::Completions(arguments)) => manual::completions(&arguments),
        Some(Command::Man) => manual::page(),
    }
}

/// Prints `text` for a person, who may not want to see it.
fn say(text: &str) -> Result<(), Error> {
    if terminal::is_quiet() { Ok(()) } else { print(text) }
}

/// Prints `text` to standard output; a reader that has gone away (`| head`) is no error.
fn print(text: &str) -> Result<(), Error> {
    use std::io::Write;
    match writeln!(std::io::stdout(), "{}", visible(text, true)) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(WriteError::new(std::path::Path::new("standard output"), error).into())
        }
        _ => Ok(()),
    }
}

/// Tells `text` on standard error. Where that is gone there is nobody to tell.
fn tell(text: &str) {
    use std::io::Write;
    writeln!(std::io::stderr(), "{}", visible(text, true)).ok();
}

/// `value` as JSON; what the program prints is plain data and always becomes JSON.
fn json(value: &impl serde::Serialize) -> String {
    serde_json::to_string_pretty(value).unwrap_or_default()
}
