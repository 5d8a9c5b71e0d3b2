//! `tumblenet sweep template`: a sweep as an array job, for the schedulers that clusters have.

use clap::{Args, ValueEnum};
use tumblenet::problems::Problems;
use tumblenet::report::template::fill;

use super::{Error, print};

/// Arguments of `sweep template`.
#[derive(Args)]
pub struct Arguments {
    /// What starts the jobs.
    #[arg(value_enum)]
    scheduler: Scheduler,
    /// Study file, as the jobs find it.
    study: String,
    /// Folder for the results, which all jobs see.
    #[arg(long, value_name = "DIR")]
    out: String,
    /// In how many parts; several for each processor, so that none waits for the last.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    shards: u64,
    /// The longest that a part may take [min].
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    minutes: u64,
}

/// Programs that run array jobs.
#[derive(Clone, Copy, ValueEnum)]
enum Scheduler {
    /// Slurm: `sbatch`.
    Slurm,
    /// PBS Professional, OpenPBS: `qsub`.
    Pbs,
    /// HyperQueue: `hq submit`.
    Hq,
    /// GNU Parallel, on one machine or over ssh.
    Parallel,
}

/// What is the same for all of them.
const REST: &str = "\
# Then the table:         tumblenet sweep merge {{out}}
# Rows are kept as members end: a job that is killed, or run twice, changes no byte of the table.
set -eu";

/// Prints the script of the arguments.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    let template = match arguments.scheduler {
        Scheduler::Slurm => include_str!("schedulers/slurm.sh"),
        Scheduler::Pbs => include_str!("schedulers/pbs.sh"),
        Scheduler::Hq => include_str!("schedulers/hq.sh"),
        Scheduler::Parallel => include_str!("schedulers/parallel.sh"),
    };
    let mut problems = Problems::new("sweep template");
    for (name, text) in [("STUDY", &arguments.study), ("--out", &arguments.out)] {
        // It would end the comment or the directive that it stands in.
        if text.is_empty() || text.chars().any(char::is_control) {
            problems.add(name, format!("{text:?}"), "a path without control characters");
        }
    }
    problems.into_result(Some(()))?;
    let [study, out] = [&arguments.study, &arguments.out].map(|path| quoted(path));
    let minutes = arguments.minutes;
    let script = fill(
        template,
        &[
            ("name", &name(&arguments.study)),
            ("shards", &arguments.shards.to_string()),
            ("minutes", &minutes.to_string()),
            ("seconds", &(60 * minutes).to_string()),
            ("clock", &format!("{:02}:{:02}:00", minutes / 60, minutes % 60)),
            ("rest", &fill(REST, &[("out", &out)])),
            // GNU Parallel hands its arguments to a shell once more.
            ("study_again", &quoted(&study)),
            ("out_again", &quoted(&out)),
            ("study", &study),
            ("out", &out),
        ],
    );
    print(script.trim_end())
}

/// `text` as a word of a shell.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+,=@%".contains(c);
    if text.chars().all(plain) { text.to_owned() } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

/// The name of a job: that of the study's file.
fn name(study: &str) -> String {
    let file = std::path::Path::new(study).file_stem().unwrap_or_default().to_string_lossy();
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '_' || c == '-' { c } else { '-' };
    file.chars().map(plain).collect()
}
