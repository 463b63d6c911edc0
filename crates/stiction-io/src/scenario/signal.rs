//! Signals for set points, loads, noise and test inputs.

use super::clock::Clock;
use super::keys;
use crate::fields::{Fields, Wrong};
use crate::table::Table;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use stiction_model::closed_loop::{Signal, Wave};

type Built<T> = std::result::Result<T, Wrong>;

/// Builds signals from their fields.
pub struct Signals<'p> {
    /// Folder of files with signals, if they can be read.
    pub folder: Option<&'p Path>,
    /// Files from which signals were read.
    pub files: RefCell<Vec<PathBuf>>,
}

impl Signals<'_> {
    /// All signals in the list at `key`.
    pub fn all(&self, top: &Fields<'_, '_>, key: &'static str, clock: Clock) -> Built<Vec<Signal>> {
        top.tables(key, keys::SIGNAL)?.into_iter().map(|fields| self.one(fields, clock)).collect()
    }

    /// The signal in a table.
    pub fn one(&self, fields: Fields<'_, '_>, clock: Clock) -> Built<Signal> {
        let wave = |wave| -> Built<Signal> {
            Ok(Signal::Periodic {
                wave,
                mean: fields.number_or("mean", 0.0)?,
                amplitude: fields.required_number("amplitude")?,
                period_s: fields.required_number("period")?,
                phase: fields.number_or("phase", 0.0)?,
            })
        };
        let signal = match fields.choice("signal", SIGNALS)? {
            Kind::Constant => Signal::Constant(fields.required_number("value")?),
            Kind::Wave(shape) => wave(shape)?,
            Kind::Steps => {
                let missing = || fields.wrong("steps", "is missing; list [time, value] pairs");
                Signal::Steps(fields.pairs("steps")?.ok_or_else(missing)?)
            }
            Kind::Line => Signal::Line {
                start: fields.number_or("start", 0.0)?,
                slope_per_s: fields.required_number("slope")?,
                from_s: fields.number_or("from", 0.0)?,
            },
            Kind::Staircase => Signal::Staircase {
                start: fields.number_or("start", 0.0)?,
                step: fields.required_number("step")?,
                dwell_s: fields.required_number("dwell")?,
                steps: u32::try_from(fields.count("stairs")?.unwrap_or(10))
                    .map_err(|_| fields.wrong("stairs", "is too large"))?,
            },
            Kind::Noise => noise(&fields)?,
            Kind::RandomWalk => Signal::RandomWalk {
                sd_per_sqrt_s: fields.required_number("sd")?,
                seed: fields.count("seed")?.unwrap_or(1),
            },
            Kind::File => Signal::Samples(self.file(&fields)?),
        };
        signal.source(clock.sample_time, clock.samples).map_err(|e| fields.refused(e))?;
        fields.finish()?;
        Ok(signal)
    }

    /// The column of a CSV file with one value per sample.
    fn file(&self, fields: &Fields<'_, '_>) -> Built<Vec<f64>> {
        let path = fields.text("file")?;
        let path = path.ok_or_else(|| fields.wrong("file", "is missing; name a CSV file"))?;
        let column = fields.text("column")?;
        let column = column.ok_or_else(|| fields.wrong("column", "is missing; name a column"))?;
        let Some(folder) = self.folder else {
            return Err(fields.wrong("file", "only scenarios in files can read signals"));
        };
        let path = folder.join(path);
        self.files.borrow_mut().push(path.clone());
        Table::read(&path)
            .and_then(|table| table.column(&column))
            .map_err(|e| fields.wrong("file", e))
    }
}

/// Kinds of signal, by their names in a scenario.
#[derive(Clone, Copy)]
enum Kind {
    Constant,
    Wave(Wave),
    Steps,
    Line,
    Staircase,
    Noise,
    RandomWalk,
    File,
}

const SIGNALS: &[(&str, Kind)] = &[
    ("constant", Kind::Constant),
    ("sine", Kind::Wave(Wave::Sine)),
    ("ramp", Kind::Wave(Wave::Ramp)),
    ("square", Kind::Wave(Wave::Square)),
    ("steps", Kind::Steps),
    ("line", Kind::Line),
    ("staircase", Kind::Staircase),
    ("noise", Kind::Noise),
    ("random-walk", Kind::RandomWalk),
    ("file", Kind::File),
];

/// `[noise]`, or a signal of that kind.
pub fn noise(fields: &Fields<'_, '_>) -> Built<Signal> {
    Ok(Signal::Noise {
        sd: fields.required_number("sd")?,
        tau_s: fields.number_or("tau", 0.0)?,
        seed: fields.count("seed")?.unwrap_or(1),
    })
}
