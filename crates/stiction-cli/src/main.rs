//! The `stiction` command: sticking control valves, diagnosed and simulated.

mod actions;
mod bench;
mod closed;
mod compensate;
mod completions;
mod diagnose;
mod docs;
mod figures;
mod files;
mod fit;
mod fmu;
mod history;
mod input;
mod inspect;
mod lab;
mod limit_cycle;
mod loops;
mod man;
mod output;
mod overrule;
mod paper;
mod plant;
mod population;
mod progress;
mod reading_args;
mod renamed;
mod replaced;
mod schema;
mod shift;
mod shown;
mod simulate;
mod stem;
mod text;
mod valve;
mod valve_test;
mod what_if;

use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::process::ExitCode;

/// Sticking control valves: diagnosis of recorded loops, models, simulated loops, the paper's figures.
///
/// Exit codes: 0, it ran; 1, it ran and found what --fail-on names; 2, it could not run, and the message
/// says why.
#[derive(Parser)]
#[command(name = "stiction", version = VERSION, max_term_width = 100, subcommand_required = true)]
#[command(arg_required_else_help = true)]
struct Cli {
    /// Tell results and errors only: no notes, no progress
    #[arg(short, long, global = true)]
    quiet: bool,
    /// Colour what is written to a terminal
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    color: Colour,
    /// Look for no settings in stiction.toml, nor in the user's
    #[arg(long, global = true)]
    no_config: bool,
    /// Write over files that hold other data, and to folders that are not empty
    #[arg(long, global = true)]
    force: bool,
    #[command(subcommand)]
    command: Command,
}

/// The version, and the commit that it was built from where that is known.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), env!("STICTION_COMMIT"));

/// When to colour.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Colour {
    /// On a terminal that wants it.
    Auto,
    Always,
    Never,
}

/// The subcommands: the name and the module of each, in the order of the help.
macro_rules! commands {
    ($($name:ident: $module:ident),+ $(,)?) => {
        #[derive(Subcommand)]
        enum Command {
            $($name($module::Args)),+
        }

        impl Command {
            fn run(self) -> anyhow::Result<ExitCode> {
                match self {
                    $(Self::$name(args) => $module::run(args).map(Done::code)),+
                }
            }
        }
    };
}

commands! {
    Diagnose: diagnose,
    History: history,
    Plant: plant,
    Lab: lab,
    Override: overrule,
    Inspect: inspect,
    Fit: fit,
    Bench: bench,
    Valve: valve,
    Stem: stem,
    Simulate: simulate,
    Compensate: compensate,
    WhatIf: what_if,
    Test: valve_test,
    LimitCycle: limit_cycle,
    Population: population,
    Fmu: fmu,
    Shift: shift,
    Figures: figures,
    Docs: docs,
    Schema: schema,
    Completions: completions,
    Man: man,
}

/// What a subcommand that ran gives back: nothing, or what to tell the shell.
trait Done {
    fn code(self) -> ExitCode;
}

impl Done for () {
    fn code(self) -> ExitCode {
        ExitCode::SUCCESS
    }
}

impl Done for ExitCode {
    fn code(self) -> ExitCode {
        self
    }
}

fn main() -> ExitCode {
    let (arguments, renamed) = renamed::present(std::env::args_os());
    let asked = Cli::command().try_get_matches_from(arguments);
    let asked = asked.and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, matches)));
    let (cli, matches) = match asked {
        Ok(asked) => asked,
        Err(error) => return unasked(&error),
    };
    output::set_quiet(cli.quiet);
    match cli.color {
        Colour::Auto => anstream::ColorChoice::Auto,
        Colour::Always => anstream::ColorChoice::Always,
        Colour::Never => anstream::ColorChoice::Never,
    }
    .write_global();
    if cli.no_config {
        reading_args::ignore_settings();
    }
    if cli.force {
        replaced::force();
    }
    renamed.into_iter().for_each(output::note);
    let noted = closed::refuse().and_then(|()| files::note(&Cli::command(), &matches));
    match noted.and_then(|()| cli.command.run()) {
        Ok(code) => code,
        // A reader that has seen enough, such as `head`, is no failure.
        Err(error) if output::is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            output::complain(&error);
            ExitCode::from(2)
        }
    }
}

/// Prints help or the version, or what is wrong with the arguments, which are quoted there.
fn unasked(error: &clap::Error) -> ExitCode {
    match error.kind() {
        ErrorKind::DisplayHelp
        | ErrorKind::DisplayVersion
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
        }
        _ => output::usage(&error.render().to_string()),
    }
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}
