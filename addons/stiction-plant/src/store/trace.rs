//! The stored signal of a window, to compare loops on one clock without reading the data again.
//!
//! Each loop of a plant has its own sample times. A trace is the control error, or the OP, as means of [`STEP_S`] seconds
//! on the clock of the plant. Each value holds until the next, for [`HELD_S`] at most. A trace is stored in steps of a
//! hundredth of its standard deviation, in some 12 kB a day. It is for spectra: periods below [`SHORTEST_S`] are lost.

use crate::store::table::{MISSING, columns};
use sha2::{Digest, Sha256};
use stiction_diagnose::diagnose::Diagnosis;
use stiction_diagnose::oscillation::Oscillation;
use stiction_diagnose::recording::{Channel, Recording};
use stiction_model::{always_written_by_name, named};

/// Time between two values, s. Cells count from 1970-01-01 UTC.
pub const STEP_S: i64 = 10;
/// The longest time for which a value holds, s.
pub const HELD_S: f64 = 3600.0;
/// The shortest period that a trace can show, s: four values.
pub const SHORTEST_S: f64 = 4.0 * STEP_S as f64;
/// Steps in a standard deviation.
const FINE: f64 = 100.0;

named! {
    /// The signal of a trace.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
    pub enum TraceSignal {
        /// PV less SP, or the PV if no SP is recorded.
        #[default]
        Error = "error",
        /// The OP.
        Op = "OP",
    }
}

impl TraceSignal {
    /// The signal in which a loop oscillates: the error, or the OP if only that does.
    pub fn of(diagnosis: &Diagnosis) -> Self {
        let found = |of: &Option<Oscillation>| of.as_ref().is_some_and(|found| found.found);
        let oscillations = &diagnosis.oscillations;
        match !found(&oscillations.error) && found(&oscillations.op) {
            true => Self::Op,
            false => Self::Error,
        }
    }
}

always_written_by_name!(TraceSignal);

columns! {
    /// A window's signal in means on the clock of the plant.
    pub struct Trace;
    /// Tag of the loop.
    "loop" [""] name: String;
    /// Begin of the first value, since 1970-01-01 UTC.
    "start" ["s"] start: i64;
    /// Which signal it is: error or OP.
    "signal" [""] signal: TraceSignal;
    /// What a step is in the units of the signal.
    "unit" [""] unit: f64;
    /// Steps about the mean, one each 10 s.
    "values" [""] values: Vec<i16>;
}

impl Trace {
    /// The trace of a window that begins at `start`, s since 1970-01-01 UTC, and lasts `duration_s`; the recording's
    /// clock begins with it. `None` if the signal is missing or never moves.
    pub fn of(
        recording: &Recording,
        start: i64,
        duration_s: i64,
        signal: TraceSignal,
    ) -> Option<Self> {
        let first = start.div_euclid(STEP_S) * STEP_S;
        let cells = (duration_s.max(0) as u64).div_ceil(STEP_S as u64) as usize;
        let means = |channel: &Channel| means(channel, (first - start) as f64, cells);
        let values = match (signal, &recording.pv) {
            (TraceSignal::Op, _) | (_, None) => means(&recording.op),
            (TraceSignal::Error, Some(pv)) => {
                let mut values = means(pv);
                if let Some(sp) = &recording.sp {
                    values.iter_mut().zip(means(sp)).for_each(|(value, sp)| *value -= sp);
                }
                values
            }
        };
        let signal = if recording.pv.is_none() { TraceSignal::Op } else { signal };
        let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        let mean = stiction_diagnose::series::mean(&known);
        let unit = stiction_diagnose::series::std(&known) / FINE;
        let moves = known.len() > 1 && unit > 1e-9 * mean.abs();
        let step = |value: f64| match value.is_finite() {
            // A spike beyond 327 standard deviations ends there.
            true => ((value - mean) / unit).round().clamp(-32_767.0, 32_767.0) as i16,
            false => MISSING,
        };
        moves.then(|| Self {
            name: recording.name.clone(),
            start: first,
            signal,
            unit,
            values: values.into_iter().map(step).collect(),
        })
    }

    /// Number of values, including unknown ones.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether it has no values.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Values relative to their mean, in the units of the signal; NaN for unknown values.
    pub fn values(&self) -> impl Iterator<Item = f64> {
        let value = |v: &i16| if *v == MISSING { f64::NAN } else { f64::from(*v) * self.unit };
        self.values.iter().map(value)
    }

    /// SHA-256 of its values, little-endian whole numbers of two bytes.
    pub fn digest(&self) -> String {
        let bytes: Vec<u8> = self.values.iter().flat_map(|value| value.to_le_bytes()).collect();
        format!("{:x}", Sha256::digest(bytes))
    }

    /// The end of its last value, s since 1970-01-01 UTC.
    pub fn end(&self) -> i64 {
        self.start + STEP_S * self.values.len() as i64
    }
}

/// The means of a channel in cells of [`STEP_S`] from `from` on, s on its clock; NaN if less than half of a cell is known.
fn means(channel: &Channel, from: f64, cells: usize) -> Vec<f64> {
    let step = STEP_S as f64;
    let (mut sums, mut known) = (vec![0.0; cells], vec![0.0; cells]);
    for (k, value) in channel.values.iter().enumerate() {
        if !(value.is_finite() && channel.quality[k].is_usable()) {
            continue;
        }
        let begin = channel.time[k] - from;
        let next = channel.time.get(k + 1).map_or(begin + step, |next| next - from);
        let end = next.min(begin + HELD_S).min(step * cells as f64);
        let mut at = begin.max(0.0);
        while at < end {
            let cell = (at / step) as usize;
            if cell >= cells {
                break;
            }
            let until = end.min(step * (cell + 1) as f64);
            // Rounding must not keep it where it is.
            let held = (until - at).max(1e-9 * step);
            sums[cell] += held * value;
            known[cell] += held;
            at += held;
        }
    }
    let mean = |(sum, known): (f64, f64)| if known >= 0.5 * step { sum / known } else { f64::NAN };
    sums.into_iter().zip(known).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::table::Row;

    #[test]
    fn means_hold_what_was_stored_and_know_what_is_missing() {
        // A value at 0, 5, 20 and, after a gap, 4000 s.
        let pv =
            Channel::new("PV", vec![0.0, 5.0, 20.0, 4000.0], vec![1.0, 3.0, 5.0, 9.0]).unwrap();
        let means = means(&pv, 0.0, 402);
        assert_eq!(means[..4], [2.0, 3.0, 5.0, 5.0]);
        assert_eq!((means[361], means[400]), (5.0, 9.0));
        assert!(means[362].is_nan() && means[401].is_nan());
    }

    #[test]
    fn traces_go_to_a_table_and_back() {
        let sp: Vec<f64> = (0..2000).map(|k| if k < 1000 { 50.0 } else { 60.0 }).collect();
        let pv: Vec<f64> = (0..2000).map(|k| sp[k] + (0.1 * k as f64).sin()).collect();
        let recording = Recording::regular("A", 5.0, &pv, Some(&pv), Some(&sp)).unwrap();
        let error = Trace::of(&recording, 1000, 10_000, TraceSignal::Error).unwrap();
        let op = Trace::of(&recording, 1003, 10_000, TraceSignal::Op).unwrap();
        assert_eq!((error.len(), error.start, op.start, error.end()), (1000, 1000, 1000, 11_000));
        // The set point moved, the error did not.
        let want = 0.5 * ((10.0f64).sin() + (10.1f64).sin());
        let got = error.values().nth(50).unwrap();
        assert!((got - want).abs() < 0.02, "{got} {want}");
        let both = [error, op];
        let mut table = Trace::table(&both);
        assert_eq!(Trace::rows(&table).unwrap(), both);
        table.columns.truncate(1);
        assert!(Trace::rows(&table).unwrap_err().contains("start"));
        let flat = Recording::regular("B", 5.0, &[7.0; 100], None, None).unwrap();
        assert_eq!(Trace::of(&flat, 0, 500, TraceSignal::Error), None);
    }
}
