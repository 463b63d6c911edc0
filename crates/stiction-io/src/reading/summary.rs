//! What a file of recordings holds, in short: what `stiction inspect` shows.

use crate::columns::layout::Recognised;
use crate::reading::{Format, Reading};
use crate::timestamp::Clock;
use std::collections::BTreeMap;
use stiction_diagnose::recording::{Channel, Mode, Modes, Quality, RangeSource, Recording};

#[cfg(feature = "serde")]
use {schemars::JsonSchema, serde::Serialize};

/// How many there are of each sort that occurs, by name.
pub type Counts = Vec<(&'static str, usize)>;

/// What a file holds, as it is understood.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Summary {
    /// The file as it was named.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Its format.
    pub format: &'static str,
    /// Its encoding; `None` but of CSV.
    pub encoding: Option<&'static str>,
    /// What stands between its columns; `None` but of CSV.
    pub delimiter: Option<char>,
    /// What stands before decimals; `None` but of CSV.
    pub decimal_mark: Option<char>,
    /// How loops and signals are laid out.
    pub layout: &'static str,
    /// Its times.
    pub times: Times,
    /// Every column with what it is taken to be.
    pub columns: Vec<Column>,
    /// The loops.
    pub loops: Vec<Loop>,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// How times are written.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Times {
    /// Their column, if they have one.
    pub column: Option<String>,
    /// Their form.
    pub format: String,
    /// Their zone.
    pub zone: String,
}

/// What a column is taken to be.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Column {
    /// The part of the file that it stands in, such as a sheet; empty for the only one.
    pub part: String,
    /// Its name.
    pub column: String,
    /// What it is taken to be.
    pub role: String,
    /// The loop it belongs to.
    #[cfg_attr(feature = "serde", serde(rename = "loop"))]
    pub loop_name: Option<String>,
    /// Why.
    pub why: String,
}

/// One loop.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Loop {
    /// Its tag.
    pub name: String,
    /// What it controls.
    #[cfg_attr(feature = "serde", serde(rename = "type"))]
    pub loop_type: &'static str,
    /// Where its clock begins, s since 1970 UTC; `None` where that is not known.
    pub start_s: Option<f64>,
    /// Its earliest time.
    pub first: String,
    /// Its latest time.
    pub last: String,
    /// Between them, s.
    #[cfg_attr(feature = "serde", serde(with = "stiction_model::finite::Finite"))]
    pub duration_s: f64,
    /// Its signals, `op`, `pv`, `sp` and `vp`, those that there are.
    pub signals: BTreeMap<&'static str, Signal>,
    /// How many samples are in each mode; `None` where modes are not recorded.
    #[cfg_attr(feature = "serde", serde(serialize_with = "option_of_counts"))]
    #[cfg_attr(feature = "serde", schemars(with = "Option<BTreeMap<String, usize>>"))]
    pub modes: Option<Counts>,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// One signal.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Signal {
    /// How many samples it has.
    pub samples: usize,
    /// How many are of each quality.
    #[cfg_attr(feature = "serde", serde(serialize_with = "counts_as_map"))]
    #[cfg_attr(feature = "serde", schemars(with = "BTreeMap<String, usize>"))]
    pub quality: Counts,
    /// Its least value; `None` without any.
    pub lowest: Option<f64>,
    /// Its largest value; `None` without any.
    pub highest: Option<f64>,
    /// Its unit, where it is known.
    pub unit: Option<String>,
    /// Its range, where it is known.
    pub range: Option<Span>,
}

/// A range and where it comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Span {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
    /// Where it comes from.
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
                zone: zone(&time.clock),
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
    fn of(recording: &Recording, clock: &Clock) -> Self {
        let (first, last) = ends(&recording.op.time);
        let signals = [
            ("op", Some(&recording.op)),
            ("pv", recording.pv.as_ref()),
            ("sp", recording.sp.as_ref()),
            ("vp", recording.vp.as_ref()),
        ];
        let signals = signals.into_iter().filter_map(|(name, of)| Some((name, of?.into())));
        Self {
            name: recording.name.clone(),
            loop_type: recording.loop_type.name(),
            start_s: recording.start,
            first: clock.show(recording.start, first),
            last: clock.show(recording.start, last),
            duration_s: last - first,
            signals: signals.collect(),
            modes: recording.mode.as_ref().map(modes),
            notes: recording.notes.clone(),
        }
    }
}

impl From<&Channel> for Signal {
    fn from(channel: &Channel) -> Self {
        let (low, high) = ends(&channel.values);
        let range = channel.range.map(|range| Span {
            low: range.low,
            high: range.high,
            source: match range.source {
                RangeSource::Given => "given",
                RangeSource::Metadata => "from the file",
                RangeSource::Estimated => "estimated",
            },
        });
        Self {
            samples: channel.values.len(),
            quality: qualities(channel),
            lowest: low.is_finite().then_some(low),
            highest: high.is_finite().then_some(high),
            unit: channel.unit.clone(),
            range,
        }
    }
}

/// The least and the largest finite value; the wrong way round without any.
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

fn zone(clock: &Clock) -> String {
    match clock {
        Clock::Utc => "UTC".to_owned(),
        Clock::Zone(zone) => zone.clone(),
        Clock::Local => "no zone".to_owned(),
        Clock::Elapsed => "from an unknown start".to_owned(),
    }
}
