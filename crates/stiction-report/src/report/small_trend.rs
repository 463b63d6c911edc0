//! A small trend with the last periods of a signal as a line, for a row of a table or a card.

use crate::words::spoken;
use maud::html;
use std::fmt::Write as _;
use stiction_diagnose::diagnose::Diagnosis;
use stiction_diagnose::recording::Segment;
use stiction_diagnose::series::{max, min};

/// Height, px.
const HEIGHT: f64 = 24.0;
/// Columns per px of width.
const COLUMNS: f64 = 0.4;
/// Number of periods shown.
const PERIODS: f64 = 6.0;

/// The signal of a small trend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Small {
    /// The process value.
    Pv,
    /// The controller output.
    Op,
}

/// The last periods of a signal as an SVG of this width in px and of the class `small`. The page may change its width.
///
/// `None` if the signal is not recorded or does not move.
pub fn small_trend(diagnosis: &Diagnosis, signal: Small, width: f64) -> Option<String> {
    let segment = diagnosis.segment()?;
    let (name, values) = match signal {
        Small::Pv => ("PV", segment.pv.as_ref()?),
        Small::Op => ("OP", &segment.op),
    };
    let samples = samples_shown(diagnosis, segment);
    let shown = &values[values.len() - samples..];
    let (low, high) = (min(shown), max(shown));
    if !(high > low) {
        return None;
    }
    let label = format!("{name}, last {}", spoken(samples as f64 * segment.sample_time));
    let svg = html! {
        svg.small viewBox={ "0 0 " (width) " " (HEIGHT) } preserveAspectRatio="none" role="img"
            aria-label=(label) {
            path d=(line(shown, low, high, width)) {}
        }
    };
    Some(svg.into_string())
}

fn samples_shown(diagnosis: &Diagnosis, segment: &Segment) -> usize {
    let period = diagnosis.oscillation().and_then(|(_, found)| found.period_s);
    let samples =
        period.map_or(segment.len(), |p| (PERIODS * p / segment.sample_time).ceil() as usize);
    samples.clamp(1, segment.len())
}

/// Path data of a line, with the extremes of each column.
fn line(x: &[f64], low: f64, high: f64, width: f64) -> String {
    let columns = ((COLUMNS * width) as usize).clamp(1, x.len());
    let mut d = String::new();
    let mut put = |at: f64, v: f64| {
        let y = 1.0 + (HEIGHT - 2.0) * (1.0 - (v - low) / (high - low));
        // Writing to a string cannot fail.
        let _ = write!(d, "{}{:.0} {y:.0}", if d.is_empty() { "M" } else { "L" }, at);
    };
    for column in 0..columns {
        let part = &x[column * x.len() / columns..(column + 1) * x.len() / columns];
        let at = width * (column as f64 + 0.5) / columns as f64;
        let (least, most) = (min(part), max(part));
        // In their original order.
        let rising = part.first() <= part.last();
        put(at, if rising { least } else { most });
        if most > least {
            put(at + 0.5, if rising { most } else { least });
        }
    }
    d
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_trend_is_small() {
        let x: Vec<f64> = (0..5_000).map(|k| (0.01 * f64::from(k)).sin()).collect();
        let d = line(&x, -1.0, 1.0, 120.0);
        assert!(d.starts_with('M') && d.len() < 700, "{}", d.len());
    }
}
