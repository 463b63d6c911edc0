//! `stiction docs`: the documentation as a site for reading offline.

mod cases;
mod columns;
mod commands;
mod figures;
mod gallery;

use crate::files::{self, Out};
use crate::{Cli, output, progress, schema};
use anyhow::{Context, Result, bail};
use clap::{CommandFactory, Parser};
use rayon::prelude::*;
use stiction_docs::markdown::literal;
use stiction_docs::{Page, Site, contents};

/// Write the documentation as a site of pages that need no network, and print the path of its first page.
///
/// The site has a gallery of twelve loops with known truth, which are simulated and diagnosed while the site is written.
/// The pages explain every command, key and column, state how often the verdict is right, and show the paper's figures.
/// All pages can be searched. The same version writes the same bytes.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction docs --open
  stiction docs -o site")]
pub struct Args {
    /// Folder to write to; created if missing [default: a folder in the user's cache]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<Out>,
    /// Open the first page in the browser
    #[arg(long)]
    open: bool,
}

/// A file that marks a folder as such a site, so that no other folder is overwritten.
const MARK: &str = ".stiction-docs";

pub fn run(args: Args) -> Result<()> {
    let folder = match args.output {
        Some(folder) => folder,
        None => Out::also(
            dirs::cache_dir()
                .context("this user has no cache folder; name a folder with -o")?
                .join(concat!("stiction/docs-", env!("CARGO_PKG_VERSION"))),
        )?,
    };
    claim(&folder)?;
    let files = site()?.files()?;
    for file in &files {
        let path = folder.inside(&file.path)?;
        if let Some(above) = path.parent() {
            files::make_folder(above)?;
        }
        output::write(Some(&path), &file.bytes)?;
    }
    let index = folder.join("index.html");
    output::line(index.display())?;
    if args.open {
        open::that(&index).with_context(|| index.display().to_string())?;
    }
    Ok(())
}

/// Creates the folder and marks it as a site. Refuses a folder with other contents.
fn claim(folder: &Out) -> Result<()> {
    let named = || folder.display().to_string();
    folder.make_folder()?;
    let mark = folder.inside(MARK)?;
    let empty = std::fs::read_dir(&**folder).with_context(named)?.next().is_none();
    if !empty && !mark.is_file() {
        bail!(
            "{} is not empty, and is not a site written by stiction; name an empty or a new folder with -o",
            named()
        );
    }
    output::write(Some(&mark), b"Written by stiction docs, which overwrites its own files.\n")
}

/// The whole site, with hand-written and generated pages.
fn site() -> Result<Site> {
    let mut site = Site::new(output::TOOL);
    let progress =
        progress::bar("writing the site", cases::CASES.len() + crate::paper::FIGURES.len());
    let shown: Vec<gallery::Shown> = cases::CASES
        .par_iter()
        .map(|case| {
            let shown = gallery::Shown::of(case).with_context(|| format!("case {}", case.tag));
            progress.inc(1);
            shown
        })
        .collect::<Result<_>>()?;
    site.add(gallery::page(&shown));
    for each in &shown {
        site.add(each.page()?);
        each.files()?.into_iter().for_each(|file| site.file(file));
    }
    let (page, drawn) = figures::page(|| progress.inc(1))?;
    site.add(page);
    drawn.into_iter().for_each(|file| site.file(file));
    progress.finish_and_clear();

    site.add(commands::page(Cli::command()));
    site.add(columns::page(&shown)?);
    schemas(&mut site)?;
    Ok(site)
}

/// A page for each JSON document, and a list of them.
fn schemas(site: &mut Site) -> Result<()> {
    let mut list = "# JSON documents\n\nThe documents that commands print with `--json`, field by field. `stiction \
        schema NAME` prints the same as a JSON schema, for programs.\n\n"
        .to_owned();
    for (name, schema) in schema::SCHEMAS {
        let schema: serde_json::Value = serde_json::from_str(&schema())?;
        let about = schema["description"].as_str().map_or(String::new(), literal);
        list += &format!("* [{name}](schemas/{name}.html): {about}\n");
        let text = format!(
            "# The document “{name}”\n\n{}\n\n```sh\nstiction schema {name}\n```\n",
            stiction_docs::schema::tables(&schema)
        );
        let page = Page::new(format!("schemas/{name}.html"), format!("JSON: {name}"), text);
        site.add(page.under(contents::SCHEMAS));
    }
    site.add(Page::new(contents::SCHEMAS, "JSON documents", list));
    Ok(())
}
