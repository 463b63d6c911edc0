//! `stiction man`: manual pages of the command and its subcommands.

use crate::{Cli, output};
use anyhow::{Context, Result};
use clap::{CommandFactory, Parser};
use clap_mangen::Man;
use std::path::{Path, PathBuf};

/// Write the manual pages to a folder: stiction.1, stiction-diagnose.1 and so on.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction man ~/.local/share/man/man1
  stiction man pages && man pages/stiction-diagnose.1")]
pub struct Args {
    /// The folder; made if it is not there
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

pub fn run(args: Args) -> Result<()> {
    std::fs::create_dir_all(&args.folder).with_context(|| args.folder.display().to_string())?;
    let mut command = Cli::command();
    // Names of subcommands with that of the command before them.
    command.build();
    page(&args.folder, &command)?;
    command
        .get_subcommands()
        .filter(|each| each.get_name() != "help")
        .try_for_each(|each| page(&args.folder, each))
}

fn page(folder: &Path, command: &clap::Command) -> Result<()> {
    let man = Man::new(command.clone());
    let mut text = vec![];
    man.render(&mut text)?;
    output::write(Some(&folder.join(man.get_filename())), &text)
}
