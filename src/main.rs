//! The program `tumblenet`: parse, call the library, print, exit.
//!
//! Exit status: 0 done; 1 the run failed or an expectation does not hold; 2 bad input.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
