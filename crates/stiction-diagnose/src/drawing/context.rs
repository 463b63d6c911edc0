//! Information for a figure of a loop beside its samples.

use super::time_axis::TimeAxis;
use crate::recording::{Modes, PlantTime, Segment};
use crate::series::{centred, periodogram, span};
use stiction_figure::figure::instant;

/// Information about a loop beside its samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Context<'a> {
    /// Time zero of the clock as seconds since 1970-01-01 UTC, if it is known.
    pub start: Option<f64>,
    /// The clock of the plant; UTC by default.
    pub plant_time: Option<&'a PlantTime>,
    /// Unit of PV and SP; `None` if it is not known.
    pub pv_unit: Option<&'a str>,
    /// The controller's mode.
    pub modes: Option<&'a Modes>,
    /// Period of the dominant oscillation, s; by default the period of the highest peak of the spectrum.
    pub period_s: Option<f64>,
}

impl Context<'_> {
    /// A time on the recording's clock as date and time of the plant, if known.
    pub fn date(&self, at: f64) -> Option<String> {
        let utc = PlantTime::default();
        let clock = self.plant_time.unwrap_or(&utc);
        instant(clock.shows(self.start? + at), &clock.name)
    }

    /// The axis of a recording that ends after `longest` s.
    pub fn time_axis(&self, longest: f64) -> TimeAxis {
        match self.plant_time {
            Some(clock) => TimeAxis::of_times(self.start, clock, longest),
            None => TimeAxis::of_times(self.start, &PlantTime::default(), longest),
        }
    }

    /// The label of an axis of the PV, or of a quantity in its unit.
    pub fn pv_label(&self, names: &str) -> String {
        format!("{names} ({})", self.pv_unit.unwrap_or("units of the PV"))
    }

    /// The period of the dominant oscillation, s; by default the period of the highest peak of the spectrum.
    pub fn period_of(&self, segment: &Segment) -> Option<f64> {
        self.period_s.filter(|p| *p > 0.0 && p.is_finite()).or_else(|| dominant_period(segment))
    }

    /// Where the last four periods of a segment begin; without a period, its last 1,000 samples.
    pub fn last_periods(&self, segment: &Segment) -> usize {
        let period = self.period_of(segment);
        let samples = period.map_or(1_000, |p| (4.0 * p / segment.sample_time).ceil() as usize);
        segment.len() - samples.max(50).min(segment.len())
    }
}

/// The period of the highest peak of the spectrum of the OP, s, if the segment holds two of them.
fn dominant_period(segment: &Segment) -> Option<f64> {
    if segment.len() < 16 || span(&segment.op) == 0.0 {
        return None;
    }
    let lines = periodogram(&centred(&segment.op));
    let twice = 2.0 / segment.len() as f64;
    let bins = (1..lines.power.len()).filter(|bin| lines.frequency[*bin] >= twice);
    let top = bins.max_by(|a, b| lines.power[*a].total_cmp(&lines.power[*b]))?;
    (lines.power[top] > 0.0).then(|| segment.sample_time / lines.frequency[top])
}
