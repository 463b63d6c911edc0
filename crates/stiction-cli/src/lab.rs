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

/// Open the lab in the browser, to try out valves and loops, open recordings, or monitor a plant.
///
/// The command serves the page only to browsers on this machine, until Ctrl-C. No data leave the machine. The
/// first line of the output is the address, with the token that gives access. Recordings are never changed. The lab writes
/// mappings, overrides and the notes of a plant to the same files as the other commands.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction lab
  stiction lab samples/FIC101-sticky.csv
  stiction lab samples/ --type flow
  stiction lab --plant north
  stiction lab --no-open --port 8787")]
pub struct Args {
    /// Recordings to open: CSV, Parquet, Excel or MATLAB files, or folders of them
    #[arg(value_name = "FILE|FOLDER")]
    files: Vec<In>,
    /// The folder of a plant, with its plant.toml
    #[arg(long, value_name = "PLANT")]
    // Read and written under the guard of the store, so not a file of a run.
    plant: Option<String>,
    /// The port to listen on; 0 for any free one [default: 8642, so that bookmarks stay valid, or any free one if 8642
    /// is in use]
    #[arg(long)]
    port: Option<u16>,
    /// Print the address without opening a browser
    #[arg(long)]
    no_open: bool,
    /// The address to listen on. Connections from other machines are not encrypted, and anyone with the token has
    /// access
    #[arg(long, value_name = "IP", default_value = "127.0.0.1")]
    host: IpAddr,
    // Must be last, because its heading applies to all that follows.
    #[command(flatten)]
    reading: Reading,
}

/// The default port of the lab.
const PORT: u16 = 8642;

pub fn run(args: Args) -> Result<()> {
    for file in &args.files {
        if file.is_standard() || !file.exists() {
            bail!("{}: no such file or folder", file.origin());
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
        output::note("other machines can reach this lab, and the connection is not encrypted");
    }
    if !args.no_open && open::that(server.address()).is_err() {
        output::note("no browser could be opened; open the address above");
    }
    output::note("Ctrl-C ends the lab");
    server.serve_until_interrupted()?;
    Ok(())
}

/// A figure of the paper, for the page.
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
