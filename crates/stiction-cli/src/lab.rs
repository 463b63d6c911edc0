//! `stiction lab`: the browser lab.

use crate::files::In;
use crate::reading_args::Reading;
use crate::{output, paper};
use anyhow::{Context, Result, bail};
use clap::Parser;
use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;
use stiction_lab::paper::{Paper, PaperFigure};
use stiction_lab::{Options, bind};

/// Open the lab in the browser: a valve and its loop to play with, recordings, a plant.
///
/// The page is served by this program, on this machine and for its browser only, until Ctrl-C; nothing leaves the
/// machine. The first line that is printed is its address, with the token that lets one in. Of recordings nothing is
/// changed; mappings, overrides and a plant's notes are written where the other commands keep them.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction lab
  stiction lab samples/FIC101-sticky.csv
  stiction lab samples/ --type flow
  stiction lab --plant north
  stiction lab --no-open --port 8787")]
pub struct Args {
    /// Recordings to open: CSV, Parquet or MATLAB files, or folders of them
    #[arg(value_name = "FILE|FOLDER")]
    files: Vec<In>,
    /// The folder of a plant, with its plant.toml
    #[arg(long, value_name = "PLANT")]
    // Read and written, within what the store guards: no file of a run.
    plant: Option<String>,
    /// The port to listen on; 0 for any that is free [default: 8642, so that bookmarks last, or any if that is taken]
    #[arg(long)]
    port: Option<u16>,
    /// Print the address only, and open no browser
    #[arg(long)]
    no_open: bool,
    /// The address to listen on. Beyond this machine what is sent is not encrypted, and who has the token is let in
    #[arg(long, value_name = "IP", default_value = "127.0.0.1")]
    host: IpAddr,
    // Last, because its heading stands above all that follows.
    #[command(flatten)]
    reading: Reading,
}

/// Where the lab is unless another port is asked for.
const PORT: u16 = 8642;

pub fn run(args: Args) -> Result<()> {
    for file in &args.files {
        if file.is_standard() || !file.exists() {
            bail!("{}: there is no such file or folder", file.origin());
        }
    }
    let options = Options {
        reading: args.reading.options()?,
        files: args.files.iter().map(|file| file.to_path_buf()).collect(),
        plant: args.plant.map(PathBuf::from),
        paper: Paper(Arc::new(|number| {
            paper::FIGURES.get(number).map(|make| figure(*make).map_err(|e| e.to_string()))
        })),
        host: args.host,
        port: args.port.unwrap_or(PORT),
        ..Options::new(output::TOOL)
    };
    let server = match bind(&options) {
        Err(_) if args.port.is_none() => bind(&Options { port: 0, ..options }),
        bound => bound,
    };
    let server =
        server.with_context(|| format!("{}:{}", args.host, args.port.unwrap_or_default()))?;
    output::line(server.address())?;
    if !args.host.is_loopback() {
        output::note(
            "this lab can be asked from other machines, and what is sent is not encrypted",
        );
    }
    if !args.no_open && open::that(server.address()).is_err() {
        output::note("no browser could be opened; open the address above");
    }
    output::note("Ctrl-C ends the lab");
    server.serve_until_interrupted()?;
    Ok(())
}

/// A figure of the paper for the page.
fn figure(make: paper::Make) -> Result<PaperFigure> {
    let drawn = make()?;
    let (scenario, set) = drawn.moving;
    let mut state = format!("scenario={scenario}");
    for each in set {
        state += &match each.as_str() {
            "stem" => "&stem=1".to_owned(),
            set => {
                format!("&set={}", set.replace('%', "%25").replace('&', "%26").replace('+', "%2B"))
            }
        };
    }
    Ok(PaperFigure {
        heading: drawn.heading,
        svg: drawn.figure.svg()?,
        caption: drawn.figure.caption,
        parameters: drawn
            .parameters
            .into_iter()
            .map(|(name, value, unit)| [name, value, unit])
            .collect(),
        command: drawn.command,
        state,
    })
}
