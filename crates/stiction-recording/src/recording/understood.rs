//! How a recording was interpreted, as one small table: a row for the times and one for each signal.
//!
//! Terminal, report and lab show these rows, and nothing else on the same subject.

use super::{Channel, Columns, Grid, GridRepair, Masked, Mode, Modes, Quality, Range, Recording};
use crate::spoken::{counted, set};

#[cfg(feature = "serde")]
use {schemars::JsonSchema, serde::Serialize};

/// What was understood of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Understood {
    columns: Columns,
    /// The earliest and the latest time of the OP, s on the recording's clock.
    span: (f64, f64),
    dated: bool,
    signals: Vec<Signal>,
    modes: Option<Vec<(&'static str, usize)>>,
    /// Time between samples, s, with the numbers of segments and of their samples; `None` without a grid.
    grid: Option<(f64, usize, usize)>,
    repairs: Vec<GridRepair>,
}

/// What was understood of a signal.
#[derive(Debug, Clone, PartialEq)]
struct Signal {
    name: &'static str,
    column: Option<String>,
    unit: Option<String>,
    range: Option<Range>,
    /// Smallest and its largest value.
    values: Option<(f64, f64)>,
    samples: usize,
    usable: usize,
    /// Samples that are not good, by their quality.
    others: Vec<(&'static str, usize)>,
    /// Values that are no measurements.
    masked: Vec<Masked>,
}

/// A row of the table.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, JsonSchema))]
pub struct Row {
    /// The column of the file, or the tag; empty if unknown.
    pub column: String,
    /// What it is: `time`, `OP`, `PV`, `SP`, `VP` or `mode`.
    pub signal: &'static str,
    /// Unit; for times, the notation.
    pub unit: String,
    /// The smallest and the largest value.
    pub values: String,
    /// The values at 0 % and 100 % with the reason; for times their zone.
    pub range: String,
    /// The number of samples; for times the sample time and the segments.
    pub samples: String,
    /// What was masked, left out or repaired, a sentence each.
    pub changes: Vec<String>,
}

impl Row {
    /// The titles of the columns of the table.
    pub const TITLES: [&str; 7] =
        ["column", "signal", "unit", "values", "range or zone", "samples", "left out or repaired"];

    /// The cells of the row, one for each title.
    pub fn cells(&self) -> [String; 7] {
        let cells =
            [&self.column, self.signal, &self.unit, &self.values, &self.range, &self.samples];
        let [column, signal, unit, values, range, samples] = cells.map(|cell: &str| match cell {
            "" => "–".to_owned(),
            cell => cell.to_owned(),
        });
        let changes = match self.changes.is_empty() {
            true => "nothing".to_owned(),
            false => self.changes.join("; "),
        };
        [column, signal, unit, values, range, samples, changes]
    }
}

impl Understood {
    /// How a recording was interpreted, and how its grid was made, if it has one.
    pub fn of(recording: &Recording, grid: Option<&Grid>) -> Self {
        let columns = &recording.columns;
        let signals = [
            ("OP", &columns.op, Some(&recording.op)),
            ("PV", &columns.pv, recording.pv.as_ref()),
            ("SP", &columns.sp, recording.sp.as_ref()),
            ("VP", &columns.vp, recording.vp.as_ref()),
        ];
        let signals = signals
            .into_iter()
            .filter_map(|(name, column, of)| Some(Signal::of(name, column, of?)));
        Self {
            span: ends(&recording.op.time).unwrap_or_default(),
            dated: recording.start.is_some(),
            signals: signals.collect(),
            modes: recording.mode.as_ref().map(modes),
            grid: grid.map(|grid| {
                let samples = grid.segments.iter().map(super::Segment::len).sum();
                (grid.sample_time, grid.segments.len(), samples)
            }),
            repairs: grid.map_or(vec![], |grid| grid.repairs.clone()),
            columns: columns.clone(),
        }
    }

    /// The rows of the table: times first, then signals and mode. `show` writes a time on the recording's clock.
    pub fn rows(&self, show: &dyn Fn(f64) -> String) -> Vec<Row> {
        let mut rows = vec![self.times(show)];
        rows.extend(self.signals.iter().map(|signal| Row {
            changes: signal.left_out().chain(self.repaired(signal.name, show)).collect(),
            ..signal.row()
        }));
        rows.extend(self.modes.as_ref().map(|modes| Row {
            column: self.columns.mode.clone().unwrap_or_default(),
            signal: "mode",
            unit: String::new(),
            values: listed(modes),
            range: String::new(),
            samples: modes.iter().map(|(_, count)| count).sum::<usize>().to_string(),
            changes: vec![],
        }));
        rows
    }

    fn times(&self, show: &dyn Fn(f64) -> String) -> Row {
        let samples = self.grid.map_or(String::new(), |(step, segments, samples)| {
            let segments = match segments {
                0 => "no segment in automatic".to_owned(),
                number => format!("{} of {samples}", counted(number, "segment")),
            };
            format!("every {} s, {segments}", set(step))
        });
        let (first, last) = self.span;
        Row {
            column: self.columns.time.clone().unwrap_or_default(),
            signal: "time",
            unit: self.columns.time_format.clone(),
            values: format!("{} to {}", show(first), show(last)),
            range: match &*self.columns.zone {
                "" if self.dated => "UTC".to_owned(),
                "" => "no date".to_owned(),
                zone => zone.to_owned(),
            },
            samples,
            changes: self.repaired("time", show).collect(),
        }
    }

    /// The repairs of a signal.
    fn repaired(&self, signal: &str, show: &dyn Fn(f64) -> String) -> impl Iterator<Item = String> {
        let of_it = self.repairs.iter().filter(move |repair| repair.signal == signal);
        of_it.map(|repair| {
            format!("{} from {} on: {}", repair.count, show(repair.first_s), repair.done)
        })
    }
}

impl Signal {
    fn of(name: &'static str, column: &Option<String>, channel: &Channel) -> Self {
        let of = |quality| channel.quality.iter().filter(|each| **each == quality).count();
        let others = [
            ("uncertain, but used", Quality::Uncertain),
            ("bad", Quality::Bad),
            ("missing", Quality::Missing),
        ];
        Self {
            name,
            column: column.clone(),
            unit: channel.unit.clone(),
            range: channel.range,
            values: ends(&channel.values),
            samples: channel.values.len(),
            usable: channel.quality.iter().filter(|quality| quality.is_usable()).count(),
            others: present(others.map(|(name, quality)| (name, of(quality)))),
            masked: channel.masked_values(name),
        }
    }

    fn row(&self) -> Row {
        let values = |(low, high)| match low == high {
            true => format!("always {}", short(low)),
            false => format!("{} to {}", short(low), short(high)),
        };
        Row {
            column: self.column.clone().unwrap_or_default(),
            signal: self.name,
            unit: self.unit.clone().unwrap_or_default(),
            values: self.values.map_or("none".to_owned(), values),
            range: self.range(),
            samples: match self.usable == self.samples {
                true => self.samples.to_string(),
                false => format!("{} of {}", self.usable, self.samples),
            },
            changes: vec![],
        }
    }

    /// The range with its reason.
    fn range(&self) -> String {
        match self.range {
            Some(Range { low, high, source, spans }) => {
                let (span, [narrow, wide]) = (high - low, spans);
                let other = match narrow < span || wide > span {
                    true => format!("; {} to {} wide is plausible", short(narrow), short(wide)),
                    false => String::new(),
                };
                format!("{} to {}, {}{other}", short(low), short(high), source.name())
            }
            // Without a range the diagnosis takes these for percent.
            None if matches!(self.name, "OP" | "VP") => "0 to 100, taken as percent".to_owned(),
            None => String::new(),
        }
    }

    fn left_out(&self) -> impl Iterator<Item = String> {
        let masked = self.masked.iter().map(|masked| {
            format!("{} masked: {}, {}", masked.count, masked.written(), masked.kind.name())
        });
        self.others.iter().map(|(quality, count)| format!("{count} {quality}")).chain(masked)
    }
}

/// Counts of what occurs.
fn present<const N: usize>(counts: [(&'static str, usize); N]) -> Vec<(&'static str, usize)> {
    counts.into_iter().filter(|(_, count)| *count > 0).collect()
}

fn listed(counts: &[(&'static str, usize)]) -> String {
    counts.iter().map(|(name, count)| format!("{count} {name}")).collect::<Vec<_>>().join(", ")
}

fn modes(modes: &Modes) -> Vec<(&'static str, usize)> {
    let of = |mode| modes.modes.iter().filter(|each| **each == mode).count();
    present([
        ("automatic", of(Mode::Automatic)),
        ("cascade", of(Mode::Cascade)),
        ("manual", of(Mode::Manual)),
        ("other", of(Mode::Other)),
    ])
}

/// The smallest and the largest finite value; `None` without values.
fn ends(values: &[f64]) -> Option<(f64, f64)> {
    let known = values.iter().copied().filter(|value| value.is_finite());
    known.map(|v| (v, v)).reduce(|(low, high), (v, _)| (low.min(v), high.max(v)))
}

/// A number with at most six digits. The JSON has all digits.
fn short(number: f64) -> String {
    let decade = number.abs().log10().floor();
    match decade {
        -4.0..9.0 => {
            let unit = 10f64.powi(5 - decade as i32);
            ((number * unit).round() / unit).to_string()
        }
        _ if number == 0.0 => "0".to_owned(),
        _ => format!("{number:.5e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{GridOptions, RangeSource};
    use super::*;

    #[test]
    fn a_row_for_times_and_for_each_signal() {
        let mut op: Vec<f64> = (0..100).map(|k| 40.0 + f64::from(k % 7)).collect();
        (op[10], op[11]) = (f64::NAN, f64::NAN);
        let sp = [50.0; 100];
        let mut recording = Recording::regular("a", 2.0, &op, Some(&op), Some(&sp)).unwrap();
        recording.op.quality[20] = Quality::Uncertain;
        recording.columns.op = Some("a.OUT".to_owned());
        recording.columns.zone = "no date".to_owned();
        recording.pv.as_mut().unwrap().range =
            Some(Range::new(0.0, 60.0, RangeSource::Metadata).unwrap());
        recording.mode = Some(Modes { time: vec![0.0], modes: vec![Mode::Automatic] });
        let grid = Grid::of(&recording, &GridOptions::default()).unwrap();
        let show = |at: f64| format!("{at} s");
        let rows = Understood::of(&recording, Some(&grid)).rows(&show);
        let cells: Vec<String> = rows.iter().map(|row| row.cells().join(" | ")).collect();
        let bridged = "2 from 20 s on: runs of up to 3 missing samples were bridged";
        let expected = [
            "– | time | – | 0 s to 198 s | no date | every 2 s, 1 segment of 100 | nothing"
                .to_owned(),
            format!(
                "a.OUT | OP | – | 40 to 46 | 0 to 100, taken as percent | 98 of 100 | \
                 1 uncertain, but used; 2 missing; {bridged}"
            ),
            format!(
                "– | PV | – | 40 to 46 | 0 to 60, from the file | 98 of 100 | 2 missing; {bridged}"
            ),
            "– | SP | – | always 50 | – | 100 | nothing".to_owned(),
            "– | mode | – | 1 automatic | – | 1 | nothing".to_owned(),
        ];
        assert_eq!(cells, expected);
        // Without a grid the file is still shown.
        assert_eq!(Understood::of(&recording, None).rows(&show)[0].samples, "");
    }
}
