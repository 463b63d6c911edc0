//! `stiction override`: the conclusions of people about a valve, kept beside the recordings.

use crate::files::{In, Out, STANDARD_INPUT};
use crate::loops::{Diagnosed, read_all};
use crate::output;
use crate::reading_args::Reading;
use anyhow::{Result, bail};
use clap::Parser;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use stiction::diagnose::VerdictClass;
use stiction::spoken::counted;
use stiction_plant::overrides::{self, Date, FILE_NAME, Override, Overrides, Scope};

/// Store a person's verdict on a valve, to show beside the computed verdict.
///
/// The override is kept in the folder of the recording, in stiction-overrides.toml, which you can edit by hand. By
/// default the override holds only for this loop in this unchanged file. With --all-recordings the override holds for
/// the tag in all files of the folder, and needs --until. The computed verdict is always shown beside the override.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction override FIC101.csv --verdict \"does not stick\" --reason \"new packing, stroked\" \\
    --by \"J. Miller\"
  stiction override plant.csv --loop FIC102 --verdict sticks --reason \"seen at the stem\" \\
    --all-recordings --until 2026-06-30
  stiction override FIC101.csv --list
  stiction override FIC101.csv --loop FIC101 --remove")]
pub struct Args {
    /// The recording; with --list also a folder
    #[arg(value_name = "FILE")]
    file: In,
    /// The loop; may be left out if the file has only one loop
    #[arg(long = "loop", value_name = "TAG")]
    tag: Option<String>,
    /// The verdict: sticks, does not stick, does not respond, or cannot tell
    #[arg(long, value_parser = VerdictClass::by_name, requires = "reason",
          required_unless_present_any = ["list", "remove"])]
    verdict: Option<VerdictClass>,
    /// The reason, in words
    #[arg(long, value_parser = not_empty)]
    reason: Option<String>,
    /// The name of the person [default: the user of this system]
    #[arg(long, value_name = "NAME", value_parser = not_empty)]
    by: Option<String>,
    /// The first day on which the override holds, UTC, such as 2026-03-01
    #[arg(long, value_name = "DATE")]
    from: Option<Date>,
    /// The last day on which the override holds, UTC
    #[arg(long, value_name = "DATE")]
    until: Option<Date>,
    /// The day of the entry, instead of today
    #[arg(long, value_name = "DATE")]
    entered: Option<Date>,
    /// Apply to the loop in all recordings of this folder
    #[arg(long)]
    all_recordings: bool,
    /// List the overrides of the folder
    #[arg(long, conflicts_with_all = ["verdict", "remove", "all_recordings"])]
    list: bool,
    /// Remove the override of the loop in this file, or with --all-recordings in all files
    #[arg(long, conflicts_with = "verdict")]
    remove: bool,
    #[command(flatten)]
    reading: Reading,
}

fn not_empty(text: &str) -> Result<String, String> {
    match text.trim() {
        "" => Err("must not be empty".to_owned()),
        text => Ok(text.to_owned()),
    }
}

pub fn run(args: Args) -> Result<()> {
    if args.file.is_standard() {
        bail!(
            "an override is kept beside a file, so standard input cannot have an override; name the file"
        );
    }
    let path = Overrides::path_for(&args.file);
    let origin = path.display().to_string();
    if args.list {
        if !args.file.exists() {
            bail!("{}: no such file or folder", args.file.display());
        }
        let kept = Overrides::read(&path)?;
        let wanted = |each: &&Override| args.tag.as_ref().is_none_or(|tag| *tag == each.loop_name);
        kept.complaints().for_each(output::note);
        return output::text(&list(kept.all.iter().filter(wanted)));
    }
    // A link could point to the recording.
    let path = Out::also(path)?;
    let file_name = args.file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if args.remove {
        let Some(tag) = &args.tag else {
            bail!("--remove needs --loop with the tag that --list shows");
        };
        let removed =
            overrides::remove(&path, |each| each.is_of(tag, &file_name, args.all_recordings))?;
        if removed == 0 {
            bail!("{origin}: no override of {tag} matches these options; see --list");
        }
        let told = format!("removed {} of {tag} from {origin}", counted(removed, "override"));
        return output::entered(output::name(&told));
    }
    let (Some(verdict), Some(reason)) = (args.verdict, args.reason.clone()) else {
        bail!("--verdict and --reason are needed");
    };
    if args.all_recordings && args.until.is_none() {
        bail!(
            "--all-recordings needs --until, the last day on which the override holds, such as 2026-12-31"
        );
    }
    if args.from.zip(args.until).is_some_and(|(from, until)| from > until) {
        bail!("--until is before --from");
    }
    let wanted: Vec<String> = args.tag.iter().cloned().collect();
    let (recordings, mut failures) =
        read_all(std::slice::from_ref(&args.file), &wanted, &args.reading)?;
    if let Some(failure) = failures.pop() {
        return Err(failure);
    }
    let [(source, recording)] = &recordings[..] else {
        let known: Vec<&str> = recordings.iter().map(|(_, r)| r.name.as_str()).collect();
        bail!("{}: choose a loop with --loop; there are {}", args.file.display(), known.join(", "));
    };
    let scope = match args.all_recordings {
        true => Scope::All,
        false => Scope::File { name: file_name, sha256: source.sha256.clone() },
    };
    let one = Override {
        loop_name: recording.name.clone(),
        verdict,
        reason,
        by: args.by.or_else(|| whoami::username().ok()),
        entered: Some(args.entered.unwrap_or_else(overrides::today)),
        tool: Some(output::TOOL.to_owned()),
        scope,
        from: args.from,
        until: args.until,
    };
    overrides::enter(&path, &one)?;
    Overrides::read(&path)?.complaints().for_each(output::note);
    let told = format!(
        "{} {}, by override, for {}; kept in {origin}",
        one.loop_name,
        one.verdict.name(),
        one.scope_in_words()
    );
    output::entered(output::name(&told))
}

fn list<'a>(kept: impl Iterator<Item = &'a Override>) -> String {
    let lines: Vec<String> = kept
        .map(|each| {
            let mut line = format!("{}: {} ({})", each.loop_name, each.verdict.name(), each.reason);
            if let Some(by) = &each.by {
                line += &format!("; by {by}");
            }
            if let Some(day) = each.entered {
                line += &format!("; entered {day}");
            }
            if let Some(tool) = &each.tool {
                line += &format!(" with {tool}");
            }
            format!("{}\n", output::name(&format!("{line}; for {}", each.scope_in_words())))
        })
        .collect();
    if lines.is_empty() { format!("no overrides in {FILE_NAME}\n") } else { lines.concat() }
}

/// Adds to each diagnosis the conclusion of a person from the file beside its recording. Overrides that do not apply
/// are noted with the reason.
pub fn apply(loops: &mut [Diagnosed]) -> Result<()> {
    let mut folders: BTreeMap<PathBuf, Overrides> = BTreeMap::new();
    for each in loops {
        // Standard input has no file beside it.
        if each.source.file == STANDARD_INPUT {
            continue;
        }
        let file = Path::new(&each.source.file);
        let path = file.with_file_name(FILE_NAME);
        let kept = match folders.entry(path) {
            std::collections::btree_map::Entry::Occupied(known) => known.into_mut(),
            std::collections::btree_map::Entry::Vacant(place) => {
                let kept = Overrides::read(place.key())?;
                kept.complaints().for_each(output::note);
                place.insert(kept)
            }
        };
        kept.overrule(&mut each.diagnosis, file, &each.source.sha256);
    }
    Ok(())
}
