//! `tumblenet completions` and `tumblenet man`: what the command line takes, for a shell and for `man`.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{Error, Program, print};

/// Arguments of `completions`.
#[derive(Args)]
#[command(
    after_help = "For bash: tumblenet completions bash > ~/.local/share/bash-completion/completions/tumblenet"
)]
pub struct Completions {
    /// The shell that is to complete.
    shell: Shell,
}

/// Prints the completions for a shell.
pub fn completions(arguments: &Completions) -> Result<(), Error> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Program::command(), "tumblenet", &mut script);
    print(String::from_utf8_lossy(&script).trim_end())
}

/// Prints the manual page: the program, and below it every command.
pub fn page() -> Result<(), Error> {
    let mut program = Program::command();
    // What is said everywhere, in every command.
    program.build();
    let mut page = Vec::new();
    let mut write = |man: clap_mangen::Man| man.render(&mut page).map_err(cannot);
    write(clap_mangen::Man::new(program.clone()))?;
    for command in program.get_subcommands().filter(|command| command.get_name() != "help") {
        write(clap_mangen::Man::new(command.clone()))?;
    }
    print(String::from_utf8_lossy(&page).trim_end())
}

fn cannot(error: std::io::Error) -> Error {
    tumblenet::report::files::WriteError::new(std::path::Path::new("standard output"), error).into()
}
