//! `stiction completions`: completion scripts for shells.

use crate::{Cli, output};
use anyhow::Result;
use clap::{CommandFactory, Parser};
use clap_complete::Shell;

/// Print the completion script of a shell.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction completions bash > ~/.local/share/bash-completion/completions/stiction
  stiction completions zsh > ~/.zfunc/_stiction
  stiction completions fish > ~/.config/fish/completions/stiction.fish")]
pub struct Args {
    /// The shell
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

pub fn run(args: Args) -> Result<()> {
    let mut script = vec![];
    clap_complete::generate(args.shell, &mut Cli::command(), "stiction", &mut script);
    output::write(None, &script)
}
