//! The summary of a file of recordings that `stiction inspect` shows.

use crate::columns::layout::Recognised;
use crate::reading::{Format, Reading};
use crate::timestamp::Clock;
use std::collections::BTreeMap;
use stiction_recording::recording::understood::Row;
use stiction_recording::recording::{
    Channel, Grid, GridOptions, Masked, Mode, Modes, Quality, Recording, Understood,
};

#[cfg(feature = "serde")]
use {schemars::JsonSchema, serde::Serialize};

/// Counts of each occurring kind, by name.
pub type Counts = Vec<(&'static str, usize)>;

/// The content of a file, as interpreted.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Summary {
    /// Name of the file, as given.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Format.
    pub format: &'static str,
    /// Encoding; `None` except for CSV.
    pub encoding: Option<&'static str>,
    /// Delimiter; `None` except for CSV.
    pub delimiter: Option<char>,
    /// Decimal mark; `None` except for CSV.
    pub decimal_mark: Option<char>,
    /// The arrangement of loops and signals.
    pub layout: &'static str,
    /// Times.
    pub times: Times,
    /// Every column with its role.
    pub columns: Vec<Column>,
    /// The loops.
    pub loops: Vec<Loop>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// The notation of times.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Times {
    /// Column of the times, if they have one.
    pub column: Option<String>,
    /// Their notation.
    pub format: String,
    /// Their zone.
    pub zone: String,
}

/// The role of a column.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Column {
    /// The part of the file that contains the loop, such as a sheet; empty if the file has only one part.
    pub part: String,
    /// Name.
    pub column: String,
    /// Role.
    pub role: String,
    /// The loop it belongs to.
    #[cfg_attr(feature = "serde", serde(rename = "loop"))]
    pub loop_name: Option<String>,
    /// The reason for this role.
    pub why: String,
}

/// One loop.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Loop {
    /// Tag.
    pub name: String,
    /// Type.
    #[cfg_attr(feature = "serde", serde(rename = "type"))]
    pub loop_type: &'static str,
    /// Beginning of its clock, s since 1970 UTC; `None` if unknown.
    pub start_s: Option<f64>,
    /// Earliest time.
    pub first: String,
    /// Latest time.
    pub last: String,
    /// Duration between them, s.
    #[cfg_attr(feature = "serde", serde(with = "stiction_model::finite::Finite"))]
    pub duration_s: f64,
    /// Signals of the loop among `op`, `pv`, `sp` and `vp`.
    pub signals: BTreeMap<&'static str, Signal>,
    /// Number of samples in each mode; `None` if modes are not recorded.
    #[cfg_attr(feature = "serde", serde(serialize_with = "option_of_counts"))]
    #[cfg_attr(feature = "serde", schemars(with = "Option<BTreeMap<String, usize>>"))]
    pub modes: Option<Counts>,
    /// How the file was interpreted, as the table that terminal, report and lab show.
    pub understood: Vec<Row>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// One signal.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Signal {
    /// Number of samples.
    pub samples: usize,
    /// Number of samples of each quality.
    #[cfg_attr(feature = "serde", serde(serialize_with = "counts_as_map"))]
    #[cfg_attr(feature = "serde", schemars(with = "BTreeMap<String, usize>"))]
    pub quality: Counts,
    /// The values among the bad ones that are no measurements, such as -9999.
    pub masked: Vec<Masked>,
    /// Smallest value; `None` without values.
    pub lowest: Option<f64>,
    /// Largest value; `None` without values.
    pub highest: Option<f64>,
    /// Unit, if known.
    pub unit: Option<String>,
    /// Range, if known.
    pub range: Option<Span>,
}

/// A range and its source.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Span {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Source.
    pub source: &'static str,
}

#[cfg(feature = "serde")]
fn counts_as_map<S: serde::Serializer>(counts: &Counts, to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(counts.iter().copied())
}

#[cfg(feature = "serde")]
fn option_of_counts<S: serde::Serializer>(
    counts: &Option<Counts>,
    to: S,
) -> Result<S::Ok, S::Error> {
    match counts {
        Some(counts) => counts_as_map(counts, to),
        None => to.serialize_none(),
    }
}

impl From<&Reading> for Summary {
    fn from(reading: &Reading) -> Self {
        let dialect = match reading.format {
            Format::Csv(dialect) => Some(dialect),
            _ => None,
        };
        let time = &reading.time;
        Self {
            file: reading.origin.clone(),
            sha256: reading.sha256.clone(),
            format: reading.format.name(),
            encoding: dialect.map(|d| d.encoding),
            delimiter: dialect.map(|d| d.delimiter),
            decimal_mark: dialect.map(|d| d.decimal_mark.mark()),
            layout: reading.layout.name(),
            times: Times {
                column: time.column.clone(),
                format: time.format.to_string(),
                zone: time.clock.name().to_owned(),
            },
            columns: reading.recognised.iter().map(Column::from).collect(),
            loops: reading.recordings.iter().map(|each| Loop::of(each, &time.clock)).collect(),
            notes: reading.notes.clone(),
        }
    }
}

impl From<&Recognised> for Column {
    fn from(each: &Recognised) -> Self {
        Self {
            part: each.part.to_string(),
            column: each.column.clone(),
            role: each.role.to_string(),
            loop_name: each.loop_name.clone(),
            why: each.why.to_string(),
        }
    }
}

impl Loop {
    /// The summary of a recording whose file has this clock.
    pub fn of(recording: &Recording, clock: &Clock) -> Self {
        let (first, last) = ends(&recording.op.time);
        let signals = [
            ("op", Some(&recording.op)),
            ("pv", recording.pv.as_ref()),
            ("sp", recording.sp.as_ref()),
            ("vp", recording.vp.as_ref()),
        ];
        let signals =
            signals.into_iter().filter_map(|(name, of)| Some((name, Signal::of(name, of?))));
        Self {
            name: recording.name.clone(),
            loop_type: recording.loop_type.name(),
            start_s: recording.start,
            first: clock.show(recording.start, first),
            last: clock.show(recording.start, last),
            duration_s: last - first,
            signals: signals.collect(),
            modes: recording.mode.as_ref().map(modes),
            understood: understood(recording, clock),
            notes: recording.notes.clone(),
        }
    }
}

/// How a recording was interpreted. One that fits on no grid, such as a single sample, is shown without.
pub(super) fn understood(recording: &Recording, clock: &Clock) -> Vec<Row> {
    let grid = Grid::of(recording, &GridOptions::default()).ok();
    let show = |at: f64| clock.show(recording.start, at).replacen('T', " ", 1);
    Understood::of(recording, grid.as_ref()).rows(&show)
}

impl Signal {
    fn of(name: &'static str, channel: &Channel) -> Self {
        let (low, high) = ends(&channel.values);
        let range = channel.range.map(|range| Span {
            low: range.low,
            high: range.high,
            source: range.source.name(),
        });
        Self {
            samples: channel.values.len(),
            quality: qualities(channel),
            masked: channel.masked_values(name),
            lowest: low.is_finite().then_some(low),
            highest: high.is_finite().then_some(high),
            unit: channel.unit.clone(),
            range,
        }
    }
}

/// The smallest and the largest finite value; in reverse order without values.
fn ends(values: &[f64]) -> (f64, f64) {
    let known = values.iter().filter(|value| value.is_finite());
    known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
}

fn qualities(channel: &Channel) -> Counts {
    counted(
        [
            ("good", Quality::Good),
            ("uncertain", Quality::Uncertain),
            ("bad", Quality::Bad),
            ("missing", Quality::Missing),
        ],
        &channel.quality,
    )
}

fn modes(modes: &Modes) -> Counts {
    counted(
        [
            ("automatic", Mode::Automatic),
            ("cascade", Mode::Cascade),
            ("manual", Mode::Manual),
            ("other", Mode::Other),
        ],
        &modes.modes,
    )
}

fn counted<T: PartialEq>(sorts: [(&'static str, T); 4], all: &[T]) -> Counts {
    let count = |(name, sort)| (name, all.iter().filter(|each| **each == sort).count());
    sorts.into_iter().map(count).filter(|(_, count)| *count > 0).collect()
}
