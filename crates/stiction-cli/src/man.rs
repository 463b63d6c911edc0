//! `stiction man`: manual pages of the command and its subcommands.

use crate::files::Out;
use crate::{Cli, output};
use anyhow::Result;
use clap::{CommandFactory, Parser};
use clap_mangen::Man;

/// Write the manual pages to a folder: stiction.1, stiction-diagnose.1 and so on.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction man ~/.local/share/man/man1
  stiction man pages && man pages/stiction-diagnose.1")]
pub struct Args {
    /// The folder; created if missing
    #[arg(value_name = "FOLDER")]
    folder: Out,
}

pub fn run(args: Args) -> Result<()> {
    args.folder.make_folder()?;
    let mut command = Cli::command();
    // Names of subcommands, each with the command before it.
    command.build();
    page(&args.folder, &command)?;
    command
        .get_subcommands()
        .filter(|each| each.get_name() != "help")
        .try_for_each(|each| page(&args.folder, each))
}

fn page(folder: &Out, command: &clap::Command) -> Result<()> {
    let man = Man::new(command.clone());
    let mut text = vec![];
    man.render(&mut text)?;
    output::write(Some(&folder.inside(man.get_filename())?), &text)
}
