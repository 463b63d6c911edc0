//! Figures of a segment of a recording: the common parts of all methods.

mod context;
mod time_axis;

pub use context::Context;
pub use time_axis::TimeAxis;

use crate::recording::Segment;
use crate::series::{min, quantile, span};
use std::ops::Range;
use stiction_figure::figure::{Figure, Panel, Series};

/// Width of the page, px.
pub const WIDTH: f64 = 860.0;

/// The input of a figure.
pub(crate) struct Scene<'a> {
    /// The signals.
    pub segment: &'a Segment,
    /// Period of the dominant oscillation, in samples, if there is one.
    pub period: Option<f64>,
    /// Other information about the loop.
    pub context: &'a Context<'a>,
    /// Name of the method, for panels that share their time axis.
    pub group: &'static str,
}

impl Scene<'_> {
    pub fn op(&self) -> &[f64] {
        &self.segment.op
    }

    /// The PV; empty if it is not recorded.
    pub fn pv(&self) -> &[f64] {
        self.segment.pv.as_deref().unwrap_or_default()
    }

    pub fn unit(&self) -> &str {
        self.context.pv_unit.unwrap_or("units of the PV")
    }

    pub fn time(&self) -> TimeAxis {
        let segment = self.segment;
        self.context.time_axis(segment.from + segment.duration())
    }

    /// Times of some samples along [`Scene::time`].
    pub fn times(&self, places: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let (axis, segment) = (self.time(), self.segment);
        let at = |k: f64| axis.at(segment.from + k * segment.sample_time);
        places.into_iter().map(at).collect()
    }

    /// The last few periods of the segment.
    pub fn end(&self) -> Range<usize> {
        let segment = self.segment;
        self.context.last_periods(segment)..segment.len()
    }

    /// A panel along time that zooms together with the other panels of its figure.
    pub fn trend(&self, y_label: impl Into<String>) -> Panel {
        let axis = self.time();
        Panel::new(axis.label, y_label).x_scale(axis.scale).group(self.group).height(130.0)
    }

    /// Samples of a signal over time, each held until the next if `held`.
    pub fn samples(&self, name: &str, values: &[f64], range: Range<usize>, held: bool) -> Series {
        let y = values.get(range.clone()).unwrap_or_default();
        let x = self.times(range.map(|k| k as f64));
        if held { Series::steps(name, x, y) } else { Series::line(name, x, y) }
    }
}

/// At most `most` samples, evenly spaced, and the number that each one represents.
pub(crate) fn thinned(values: &[f64], most: usize) -> (Vec<f64>, usize) {
    let stride = values.len().div_ceil(most).max(1);
    (values.iter().copied().step_by(stride).collect(), stride)
}

/// A vertical line up to a height, with its name in the legend, where names cannot overlap.
pub(crate) fn line_at(
    series: fn(&str, Vec<f64>, Vec<f64>) -> Series,
    name: &str,
    x: f64,
    top: f64,
) -> Series {
    series(name, vec![x; 2], vec![0.0, top])
}

pub(crate) fn solid(name: &str, x: Vec<f64>, y: Vec<f64>) -> Series {
    Series::line(name, x, y)
}

pub(crate) fn dashed(name: &str, x: Vec<f64>, y: Vec<f64>) -> Series {
    Series::dashed(name, x, y)
}

pub(crate) fn dotted(name: &str, x: Vec<f64>, y: Vec<f64>) -> Series {
    Series::dotted(name, x, y)
}

/// A sheet as wide as the page, with a caption.
pub(crate) fn sheet(caption: impl Into<String>) -> Figure {
    Figure::new("").caption(caption).width(WIDTH).panel_height(200.0)
}

/// Centres of bins and percent of the values in each; bins by the rule of Freedman and Diaconis.
pub fn histogram(values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let spread = quantile(values, 0.75) - quantile(values, 0.25);
    let (low, range) = (min(values), span(values));
    let width = 2.0 * spread / (values.len() as f64).cbrt();
    let wanted = (range / width).ceil();
    let count = if wanted.is_finite() { wanted.clamp(8.0, 50.0) as usize } else { 20 };
    let mut bins = vec![0.0; count];
    for value in values {
        let bin = (count as f64 * (value - low) / range) as usize;
        bins[bin.min(count - 1)] += 100.0 / values.len() as f64;
    }
    let centre = |bin: usize| low + range * (bin as f64 + 0.5) / count as f64;
    ((0..count).map(centre).collect(), bins)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histograms_add_up() {
        let values: Vec<f64> = (0..999).map(|k| (0.1 * f64::from(k)).sin()).collect();
        let (centres, shares) = histogram(&values);
        assert_eq!(centres.len(), shares.len());
        assert!((shares.iter().sum::<f64>() - 100.0).abs() < 1e-9);
    }
}
