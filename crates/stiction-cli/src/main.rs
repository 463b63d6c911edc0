//! The `stiction` command: sticking control valves, diagnosed and simulated.
#![forbid(unsafe_code)]

mod actions;
mod bench;
mod compensate;
mod diagnose;
mod figures;
mod fmu;
mod history;
mod inspect;
mod limit_cycle;
mod output;
mod overrule;
mod paper;
mod population;
mod progress;
mod reading_args;
mod schema;
mod shift;
mod simulate;
mod stem;
mod text;
mod valve;
mod what_if;

use clap::{Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;

/// Sticking control valves: diagnosis of recorded loops, models, simulated loops, the paper's figures.
///
/// Exit codes: 0, it ran; 1, it ran and found what --fail-on names; 2, it could not run, and the message
/// says why.
#[derive(Parser)]
#[command(name = "stiction", version, max_term_width = 100, subcommand_required = true)]
#[command(arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Diagnose(diagnose::Args),
    History(history::Args),
    Override(overrule::Args),
    Inspect(inspect::Args),
    Bench(bench::Args),
    Valve(valve::Args),
    Stem(stem::Args),
    Simulate(simulate::Args),
    Compensate(compensate::Args),
    WhatIf(what_if::Args),
    LimitCycle(limit_cycle::Args),
    Population(population::Args),
    Fmu(fmu::Args),
    Shift(shift::Args),
    Figures(figures::Args),
    Schema(schema::Args),
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Diagnose(args) => diagnose::run(args),
        Command::History(args) => history::run(args).map(|()| ExitCode::SUCCESS),
        Command::Override(args) => overrule::run(args).map(|()| ExitCode::SUCCESS),
        Command::Bench(args) => bench::run(args).map(|()| ExitCode::SUCCESS),
        Command::Valve(args) => valve::run(args).map(|()| ExitCode::SUCCESS),
        Command::Stem(args) => stem::run(args).map(|()| ExitCode::SUCCESS),
        Command::Simulate(args) => simulate::run(args).map(|()| ExitCode::SUCCESS),
        Command::Compensate(args) => compensate::run(args).map(|()| ExitCode::SUCCESS),
        Command::WhatIf(args) => what_if::run(args).map(|()| ExitCode::SUCCESS),
        Command::LimitCycle(args) => limit_cycle::run(args).map(|()| ExitCode::SUCCESS),
        Command::Figures(args) => figures::run(args).map(|()| ExitCode::SUCCESS),
        Command::Schema(args) => schema::run(args).map(|()| ExitCode::SUCCESS),
        Command::Inspect(args) => inspect::run(args).map(|()| ExitCode::SUCCESS),
        Command::Shift(args) => shift::run(args).map(|()| ExitCode::SUCCESS),
        Command::Fmu(args) => fmu::run(args).map(|()| ExitCode::SUCCESS),
        Command::Population(args) => population::run(args).map(|()| ExitCode::SUCCESS),
    };
    match result {
        Ok(code) => code,
        // A reader that has seen enough, such as `head`, is no failure.
        Err(error) if output::is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            // Not eprintln!, which panics where standard error is closed.
            let _ = writeln!(std::io::stderr(), "stiction: {}", output::failure(&error));
            ExitCode::from(2)
        }
    }
}
