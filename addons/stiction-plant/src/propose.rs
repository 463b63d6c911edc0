//! A first plant file from the data alone, with its doubts as comments.
//!
//! It reads the [beginning](HEAD) of each text file, or the whole file if the tags may be below each other. In each
//! folder of other files it reads the first and last file, because files of one export are alike. Of Parquet it reads
//! the beginning of each loop.

use crate::error::{Error, Result, file};
use crate::plant_file::WORDING;
use crate::scan::inputs::APART;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::io::Read;
use std::path::Path;
use stiction_diagnose::recording::LoopType;
use stiction_io::ReadOptions;
use stiction_io::layout::Layout;
use stiction_io::parted::PartedFile;
use stiction_io::reading::{self, Reading};
use stiction_io::role::Role;
use stiction_io::timestamp::Clock;

/// Number of bytes that are read from a text file.
pub const HEAD: u64 = 256 * 1024;

const TEXT: [&str; 3] = ["csv", "txt", "tsv"];
const OTHER: [&str; 2] = ["parquet", "mat"];

/// A proposed plant file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Proposal {
    /// The text of the file.
    pub text: String,
    /// Loops in it.
    pub loops: usize,
    /// Files that were examined.
    pub files: usize,
    /// Doubts, which are in the text, too.
    pub doubts: Vec<String>,
}

/// Proposes a plant file for the files and folders `data`, relative to `folder`.
///
/// # Errors
/// If a file or folder does not exist, or no file contains a loop.
pub fn propose(folder: &Path, name: &str, data: &[String]) -> Result<Proposal> {
    let mut patterns: Vec<String> = vec![];
    let mut files: BTreeMap<(String, String), BTreeSet<String>> = BTreeMap::new();
    for own in data {
        let path = folder.join(own);
        let known = path.metadata().map_err(file(&path))?;
        let found = if known.is_dir() { list(folder, own)? } else { vec![own.clone()] };
        for each in found {
            let path = Path::new(&each);
            let extension =
                path.extension().map_or(String::new(), |e| e.to_string_lossy().into_owned());
            let parent = path.parent().map_or(String::new(), |p| p.display().to_string());
            if known.is_dir() {
                let pattern = format!("{}/**/*.{extension}", own.trim_end_matches('/'));
                if !patterns.contains(&pattern) {
                    patterns.push(pattern);
                }
            } else {
                patterns.push(each.clone());
            }
            files.entry((parent, extension)).or_default().insert(each);
        }
    }
    let mut looked: Vec<(String, bool)> = vec![];
    for ((_, extension), files) in &files {
        let is_text = TEXT.contains(&&*extension.to_lowercase());
        let ends = [files.first(), files.last()].into_iter().flatten().collect::<BTreeSet<_>>();
        let chosen: Vec<&String> =
            if is_text { files.iter().collect() } else { ends.into_iter().collect() };
        looked.extend(chosen.into_iter().map(|path| (path.clone(), is_text)));
    }

    let mut doubts: Vec<String> = vec![];
    let mut loops: BTreeMap<String, (LoopType, Vec<String>)> = BTreeMap::new();
    let (mut local, mut no_recordings) = (false, vec![]);
    for (path, is_text) in &looked {
        let looked = look(&folder.join(path), path, *is_text, |reading| {
            local |= reading.time.clock == Clock::Local;
            for recording in &reading.recordings {
                if recording.start.is_none() {
                    doubts.push(format!(
                        "{path}: {} has no dates, so its days are unknown",
                        recording.name
                    ));
                }
                if recording.pv.is_none() {
                    doubts.push(format!(
                        "{}: no PV was found; if the file has the PV of this loop, give pv = \"TAG\", {APART}",
                        recording.name
                    ));
                }
                let tags = tags(&reading, &recording.name);
                loops.insert(recording.name.clone(), (recording.loop_type, tags));
            }
            doubts.extend(reading.notes.iter().map(|note| format!("{path}: {note}")));
        });
        match looked {
            Err(NotRead::NoRecording(why)) => no_recordings.push(why),
            Err(NotRead::Refused(why)) => doubts.push(why),
            Ok(()) => {}
        }
    }
    if loops.is_empty() {
        let why = doubts
            .first()
            .or(no_recordings.first())
            .map_or("there are no data files".to_owned(), Clone::clone);
        return Err(Error::Option(format!("found no loop: {why}")));
    }
    if local {
        doubts.push("the times have no zone; if the clock is not UTC, correct the zone".to_owned());
    }
    let mut seen = BTreeSet::new();
    doubts.retain(|doubt| seen.insert(doubt.clone()));

    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "name = {}\nzone = \"UTC\"", quoted(name));
    let list: Vec<String> = patterns.iter().map(|pattern| quoted(pattern)).collect();
    let _ = writeln!(text, "data = [{}]", list.join(", "));
    for doubt in &doubts {
        let _ = writeln!(text, "# ? {}", doubt.replace(['\n', '\r'], " "));
    }
    for why in &no_recordings {
        let _ = writeln!(text, "# no recording: {}", why.replace(['\n', '\r'], " "));
    }
    for (name, (loop_type, tags)) in &loops {
        let _ = writeln!(text, "\n[loop.{}]", quoted(name));
        match loop_type {
            LoopType::Unknown => text += "# type = \"flow\"\n",
            known => {
                let named = LoopType::NAMES.iter().find(|(_, each)| each == known);
                let _ =
                    writeln!(text, "type = {}", quoted(named.map_or("unknown", |(name, _)| name)));
            }
        }
        for tag in tags {
            let _ = writeln!(text, "# {tag}");
        }
    }
    Ok(Proposal { text, loops: loops.len(), files: looked.len(), doubts })
}

/// The data files below `own`, relative to `folder`.
fn list(folder: &Path, own: &str) -> Result<Vec<String>> {
    let (mut found, mut open) = (vec![], vec![folder.join(own)]);
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(&next).map_err(file(&next))? {
            let path = entry.map_err(file(&next))?.path();
            let extension =
                path.extension().map_or(String::new(), |e| e.to_string_lossy().to_lowercase());
            let is_hidden = path.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
            if is_hidden {
                // Such as the store, which is no data.
            } else if path.is_dir() {
                open.push(path);
            } else if TEXT.contains(&&*extension) || OTHER.contains(&&*extension) {
                found.push(path.strip_prefix(folder).unwrap_or(&path).display().to_string());
            }
        }
    }
    Ok(found)
}

/// Why a file gives no loop, a sentence.
enum NotRead {
    NoRecording(String),
    Refused(String),
}

impl From<stiction_io::Error> for NotRead {
    fn from(error: stiction_io::Error) -> Self {
        match error {
            stiction_io::Error::NoOp { has_times: true, .. } => {
                Self::NoRecording(format!("{error}, {APART}"))
            }
            stiction_io::Error::NoOp { .. } => Self::NoRecording(error.to_string()),
            _ => Self::Refused(error.to_string()),
        }
    }
}

fn look(
    path: &Path,
    own: &str,
    is_text: bool,
    mut visit: impl FnMut(Reading),
) -> Result<(), NotRead> {
    let options = ReadOptions { wording: WORDING, ..ReadOptions::default() };
    if !is_text {
        return Ok(head(path, &options, visit)?);
    }
    let open = || -> std::io::Result<Vec<u8>> {
        let mut bytes = vec![];
        std::fs::File::open(path)?.take(HEAD).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let mut bytes = open().map_err(|e| NotRead::Refused(format!("{own}: {e}")))?;
    let is_whole = (bytes.len() as u64) < HEAD;
    if !is_whole {
        // Not half a row.
        bytes.truncate(bytes.iter().rposition(|b| *b == b'\n').map_or(bytes.len(), |at| at + 1));
    }
    visit(match reading::parse(&bytes, own, &options) {
        Ok(read) if is_whole || read.layout != Layout::Long => read,
        Err(error) if is_whole => return Err(error.into()),
        // Its other tags, or what the beginning lacks, may be below.
        _ => reading::read(path, &options)?,
    });
    Ok(())
}

/// Passes the content of a file to `visit`: of Parquet the beginning of each loop, some loops at a time.
pub(crate) fn head(
    path: &Path,
    options: &ReadOptions,
    mut visit: impl FnMut(Reading),
) -> stiction_io::Result<()> {
    match PartedFile::open(path, options)? {
        Some(parted) => parted.heads(options, visit),
        None => {
            visit(reading::read(path, options)?);
            Ok(())
        }
    }
}

/// The tags of a loop, as the plant file would name them.
pub(crate) fn tags(reading: &Reading, name: &str) -> Vec<String> {
    let own = reading.recognised.iter().filter(|each| each.loop_name.as_deref() == Some(name));
    own.filter_map(|each| match each.role {
        Role::Signal(signal) => {
            Some(format!("{} = {}", signal.name().to_lowercase(), quoted(&each.column)))
        }
        _ => None,
    })
    .collect()
}

/// A text in quotes, as in TOML.
pub(crate) fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
