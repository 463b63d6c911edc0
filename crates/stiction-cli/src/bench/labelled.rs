//! Recordings of real loops with labels.

use super::About;
use super::measure::{Known, Measured, Plan};
use crate::files::In;
use crate::input;
use anyhow::{Context, Result, anyhow, bail};
use std::path::{Component, Path};
use stiction::recording::{Channel, Grid, GridOptions, LoopType, Recording};
use stiction::score::bench::results::Label;
use stiction::scoreboard::Truth;
use stiction_io::ReadOptions;
use stiction_io::options::Mapped;
use stiction_report::document::Source;

/// A row of the index.
pub struct Entry {
    /// Place in the index, for messages.
    place: String,
    name: String,
    file: In,
    loop_type: Option<LoopType>,
    valve: String,
    sticks: bool,
    source: String,
    licence: String,
    columns: Vec<Mapped>,
}

impl Entry {
    /// What results say about it.
    pub fn label(&self) -> Label {
        Label {
            id: self.name.clone(),
            valve: self.valve.clone(),
            sticks: self.sticks,
            source: self.source.clone(),
            licence: self.licence.clone(),
        }
    }
}

/// Measures all labelled recordings of an index.
pub fn measure(index: &In, allow_outside: bool, plan: &Plan<'_>) -> Result<(About, Measured)> {
    let (entries, unlabelled) = entries(index, allow_outside)?;
    let mut measured = Measured::default();
    measured.add(&entries, load, plan)?;
    let passed = match unlabelled {
        0 => String::new(),
        n => format!(" Loops skipped for lack of a label: {n}."),
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
pub fn entries(index: &In, allow_outside: bool) -> Result<(Vec<Entry>, usize)> {
    let table = input::table(index)?;
    let folder = index.parent().unwrap_or(Path::new(""));
    let (names, labels) = (table.texts("loop")?, table.texts("label")?);
    let optional = |column: &str| table.texts(column).ok();
    let (types, guesses) = (optional("loop_type"), optional("loop_type_unverified"));
    let (tags, files) = (optional("tag"), optional("file"));
    let (sources, licences) = (optional("source"), optional("licence"));
    let maps = optional("columns");
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
            bail!("{place}: the loop has no name; write the name in the column loop");
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
        let map = cell(&maps).unwrap_or_default();
        let columns = map.split(';').map(str::trim).filter(|each| !each.is_empty()).map(str::parse);
        let columns = columns
            .collect::<std::result::Result<_, String>>()
            .map_err(|e| anyhow!("{place}, columns of {name}: {e}"))?;
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
            source: cell(&sources).unwrap_or_default(),
            licence: cell(&licences).unwrap_or_default(),
            columns,
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

pub fn load(entry: &Entry) -> Result<Known> {
    let remedy = || {
        format!(
            "{}: the recording of {} cannot be read; put LOOP.csv beside the index, or name the file in the column file",
            entry.place, entry.name
        )
    };
    let options = ReadOptions { map: entry.columns.clone(), ..ReadOptions::default() };
    let reading = input::recordings(&entry.file, &options).with_context(remedy)?;
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

/// The longest segment of a recording on a grid, which begins at 0.
pub fn even(recording: &Recording) -> Result<Recording> {
    let grid = Grid::of(recording, &GridOptions::default())?;
    let of = grid.longest().context("it has no samples")?;
    let (pv, sp) = (of.pv.as_deref(), of.sp.as_deref());
    let mut even = Recording::regular(&recording.name, of.sample_time, &of.op, pv, sp)?;
    even.loop_type = recording.loop_type;
    let vp = of.vp.clone().map(|vp| Channel::new("VP", even.op.time.clone(), vp));
    even.vp = vp.transpose()?;
    Ok(even)
}
