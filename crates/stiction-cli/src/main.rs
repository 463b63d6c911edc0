//! The `stiction` command: diagnoses and simulates sticking control valves.
#![forbid(unsafe_code)]

mod actions;
mod bare;
mod bench;
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
mod replaced;
mod schema;
mod shift;
mod shown;
mod simulate;
mod stem;
mod text;
mod together;
mod valve;
mod valve_test;
mod watch;
mod what_if;

use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::ffi::OsString;
use std::process::ExitCode;

/// Diagnose sticking control valves from recorded loops, simulate valves and loops, and draw the figures of the
/// underlying paper.
///
/// Exit code 0: success. Exit code 1: a result that --fail-on or --fail names, or no collector for watch --status. Exit
/// code 2: failure, and the message says why.
#[derive(Parser)]
#[command(name = "stiction", version = VERSION, max_term_width = 100, subcommand_required = true)]
#[command(arg_required_else_help = true)]
struct Cli {
    /// Print only results and errors, without notes and progress
    #[arg(short, long, global = true)]
    quiet: bool,
    /// Colour terminal output
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    color: Colour,
    /// Ignore settings in stiction.toml and in the user's configuration
    #[arg(long, global = true)]
    no_config: bool,
    /// Overwrite files with other data, and write to folders that are not empty
    #[arg(long, global = true)]
    force: bool,
    #[command(subcommand)]
    command: Command,
}

/// The version, with the commit it was built from if that is known.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), env!("STICTION_COMMIT"));

/// When to use colour.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Colour {
    /// On terminals that support colour.
    Auto,
    Always,
    Never,
}

/// The subcommands with their modules, in the order of the help.
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
    Watch: watch,
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

/// The result of a subcommand: nothing, or an exit code for the shell.
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
    let command = Cli::command();
    let names: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
    let asked = bare::launch(std::env::args_os().collect(), &names);
    let code = run(asked.command);
    if asked.waits {
        bare::wait();
    }
    code
}

/// Runs a command.
fn run(arguments: Vec<OsString>) -> ExitCode {
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
    let noted = files::note(&Cli::command(), &matches);
    match noted.and_then(|()| cli.command.run()) {
        Ok(code) => code,
        // A reader that closes the pipe early, such as `head`, is no failure.
        Err(error) if output::is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            output::complain(&error);
            ExitCode::from(2)
        }
    }
}

/// Prints help, the version, or a message on wrong arguments, which it quotes.
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
