//! `stiction figures`: every figure of the paper.

use crate::files::Out;
use crate::output;
use crate::paper;
use anyhow::Result;
use clap::Parser;
use indicatif::ProgressBar;
use stiction_figure::{Entry, Page, Picture};

/// Draw every figure of the paper that has a plot, and one that the paper lacks.
///
/// Writes each figure as SVG and PNG, and index.html, which shows them in order with their captions and parameters.
#[derive(Parser)]
#[command(after_help = "Example:\n  stiction figures -o figures")]
pub struct Args {
    /// Folder to write to; created if missing
    #[arg(short, long, default_value = "figures", value_name = "DIR")]
    output: Out,
}

pub fn run(args: Args) -> Result<()> {
    args.output.make_folder()?;
    let mut page = Page::new(paper::TITLE, paper::INTRODUCTION, output::TOOL);
    let progress = ProgressBar::new(paper::FIGURES.len() as u64);
    for make in paper::FIGURES {
        let drawn = make()?;
        let (svg, png) = (format!("{}.svg", drawn.name), format!("{}.png", drawn.name));
        output::write(Some(&args.output.inside(&svg)?), drawn.figure.svg()?.as_bytes())?;
        output::write(Some(&args.output.inside(&png)?), &drawn.figure.png()?)?;
        let mut entry = Entry::new(&drawn.heading, Picture::File(svg), &drawn.figure.caption);
        for (name, value, unit) in &drawn.parameters {
            entry = entry.parameter(name, value, unit);
        }
        page = page.with(entry);
        progress.inc(1);
    }
    progress.finish_and_clear();
    let index = args.output.inside("index.html")?;
    output::write(Some(&index), page.html().as_bytes())?;
    output::line(format!("{} figures; see {}", paper::FIGURES.len(), index.display()))
}
