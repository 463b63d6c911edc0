//! Recordings of real loops with labels.

use super::About;
use super::measure::{Known, Measured, Plan};
use crate::files::In;
use crate::input;
use anyhow::{Context, Result, bail};
use std::path::{Component, Path};
use stiction::recording::LoopType;
use stiction::scoreboard::Truth;
use stiction_io::ReadOptions;
use stiction_report::document::Source;

/// A row of the index.
struct Entry {
    /// Its place in the index, for messages.
    place: String,
    name: String,
    file: In,
    loop_type: Option<LoopType>,
    valve: String,
    sticks: bool,
}

/// Measures all labelled recordings of an index.
pub fn measure(index: &In, allow_outside: bool, plan: &Plan<'_>) -> Result<(About, Measured)> {
    let (entries, unlabelled) = entries(index, allow_outside)?;
    let mut measured = Measured::default();
    measured.add(&entries, load, plan)?;
    let passed = match unlabelled {
        0 => String::new(),
        n => format!(" Skipped, without a label: {n}."),
    };
    let about = About {
        title: format!("{} labelled recordings", entries.len()),
        origin: format!(
            "Index: {}.{passed} Labels are opinions of the people who gave them.",
            index.file_name().unwrap_or_default().to_string_lossy()
        ),
    };
    Ok((about, measured.finish(plan)?))
}

/// The labelled rows, and the number of rows without a label.
fn entries(index: &In, allow_outside: bool) -> Result<(Vec<Entry>, usize)> {
    let table = input::table(index)?;
    let folder = index.parent().unwrap_or(Path::new(""));
    let (names, labels) = (table.texts("loop")?, table.texts("label")?);
    let optional = |column: &str| table.texts(column).ok();
    let (types, guesses) = (optional("loop_type"), optional("loop_type_unverified"));
    let (tags, files) = (optional("tag"), optional("file"));
    let mut entries = vec![];
    for (k, name) in names.iter().enumerate() {
        let place = format!("{}, row {}", index.origin(), table.line(k));
        let sticks = match &labels[k][..] {
            "stiction" => true,
            "no stiction" => false,
            // Loops without a label are skipped.
            "" => continue,
            other => bail!(
                "{place}: the label of {name} is \"{other}\", but must be stiction or no stiction, or empty to skip \
                 the loop"
            ),
        };
        if name.is_empty() {
            bail!("{place}: the loop has no name; write one in the column loop");
        }
        let cell = |column: &Option<Vec<String>>| {
            column.as_ref().map(|cells| cells[k].clone()).filter(|cell| !cell.is_empty())
        };
        let loop_type = match (cell(&types), cell(&guesses)) {
            (Some(word), _) => Some(LoopType::by_name(&word).with_context(|| place.clone())?),
            // An unverified type may be an unknown word.
            (None, Some(word)) => LoopType::by_name(&word).ok(),
            (None, None) => None,
        };
        let file = folder.join(cell(&files).unwrap_or_else(|| format!("{name}.csv")));
        if !allow_outside && is_outside(&file, folder) {
            bail!(
                "{place}: the recording of {name}, {}, lies outside the folder of the index; give --allow-outside to \
                 permit this",
                file.display()
            );
        }
        entries.push(Entry {
            place,
            file: In::also(file)?,
            loop_type,
            valve: cell(&tags).unwrap_or_else(|| name.clone()),
            sticks,
            name: name.clone(),
        });
    }
    if entries.is_empty() {
        bail!("{}: no loop has a label; write stiction or no stiction", index.origin());
    }
    let unlabelled = names.len() - entries.len();
    Ok((entries, unlabelled))
}

/// Whether a file lies outside a folder and all its folders, after following links.
fn is_outside(file: &Path, folder: &Path) -> bool {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match (file.canonicalize(), folder.canonicalize()) {
        (Ok(file), Ok(folder)) => !file.starts_with(folder),
        // A missing file is judged by its path alone.
        _ => {
            let inside = file.strip_prefix(folder).unwrap_or(file);
            inside
                .components()
                .any(|part| !matches!(part, Component::Normal(_) | Component::CurDir))
        }
    }
}

fn load(entry: &Entry) -> Result<Known> {
    let remedy = || {
        format!(
            "{}: the recording of {} cannot be read; put it there, or give its name in a column file",
            entry.place, entry.name
        )
    };
    let reading = input::recordings(&entry.file, &ReadOptions::default()).with_context(remedy)?;
    let source = Source { file: reading.origin, sha256: reading.sha256 };
    let Some(mut recording) = reading.recordings.into_iter().next() else {
        bail!("{}: {} holds no recording", entry.place, entry.file.display());
    };
    recording.name = entry.name.clone();
    if let Some(loop_type) = entry.loop_type {
        recording.loop_type = loop_type;
    }
    let truth = Truth {
        valve: entry.valve.clone(),
        kind: String::new(),
        sticks: entry.sticks,
        visible: true,
        s: None,
        j: None,
        member: None,
    };
    Ok(Known { recording, source, truth })
}
