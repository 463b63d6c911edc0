//! Probability and S of windows over time.

use stiction_diagnose::diagnose::Estimate;
use stiction_diagnose::drawing::{TimeAxis, WIDTH};
use stiction_diagnose::recording::PlantTime;
use stiction_figure::figure::{Annotation, Figure, Panel, Series, colour};

/// The results of one window, for the figure.
pub(super) struct Point {
    /// Beginning, s.
    pub from: f64,
    /// Duration, s.
    pub duration: f64,
    pub probability: Option<f64>,
    pub s: Option<Estimate>,
}

/// The figure of some windows on a clock that begins at `start`. `marks` are times with names, such as a repair.
/// `None` if no window has a number.
pub(super) fn figure(
    points: &[Point],
    start: Option<f64>,
    clock: &PlantTime,
    marks: &[(f64, &str)],
) -> Option<Figure> {
    let last = points.iter().map(|p| p.from + p.duration).fold(0.0, f64::max);
    let axis = TimeAxis::of_times(start, clock, last);
    let mut panels = vec![];
    let probabilities: Vec<(&Point, f64)> =
        points.iter().filter_map(|p| Some((p, 100.0 * p.probability?))).collect();
    if !probabilities.is_empty() {
        let panel = panel(&axis, "probability of sticking (%)").y_range(0.0, 100.0);
        // Each value spans its whole window.
        let (mut x, mut y) = (vec![], vec![]);
        for (point, value) in &probabilities {
            x.extend([axis.at(point.from), axis.at(point.from + point.duration)]);
            y.extend([*value; 2]);
        }
        panels.push(panel.with(runs("probability", x, y)));
    }
    let sizes: Vec<(&Point, Estimate)> = points.iter().filter_map(|p| Some((p, p.s?))).collect();
    if !sizes.is_empty() {
        let middle = |p: &Point| axis.at(p.from + p.duration / 2.0);
        let (mut x, mut y) = (vec![], vec![]);
        for (point, s) in &sizes {
            x.extend([middle(point); 2]);
            y.extend([s.low, s.high]);
        }
        let top = sizes.iter().map(|(_, s)| s.high.max(s.value)).fold(1.0, f64::max);
        let values = sizes.iter().map(|(_, s)| s.value).collect::<Vec<_>>();
        let places = sizes.iter().map(|(p, _)| middle(p)).collect::<Vec<_>>();
        let panel = panel(&axis, "S (% of span)")
            .y_range(0.0, 1.1 * top)
            .with(runs("interval", x, y))
            .with(Series::points("S", places, values).colour(colour::VERMILION));
        panels.push(panel);
    }
    if panels.is_empty() {
        return None;
    }
    let first = points.iter().map(|p| p.from).fold(f64::INFINITY, f64::min);
    for panel in &mut panels {
        for (at, name) in marks {
            panel.annotations.push(Annotation::vertical_line(axis.at(*at), *name));
        }
        let ends = marks.iter().map(|(at, _)| *at);
        let from = ends.clone().fold(first, f64::min);
        let to = ends.fold(last, f64::max);
        if to > from {
            let margin = 0.02 * (to - from);
            panel.x_range = Some((axis.at(from - margin), axis.at(to + margin)));
        }
    }
    let figure = Figure::new("")
        .caption("Probability of sticking, and S with its interval, of each window on its own.")
        .width(WIDTH);
    Some(panels.into_iter().fold(figure, Figure::with)).filter(|figure| figure.check().is_ok())
}

fn panel(axis: &TimeAxis, y_label: &str) -> Panel {
    Panel::new(axis.label.clone(), y_label).x_scale(axis.scale).group("windows").height(130.0)
}

/// Pairs of points. The points of a pair are joined, and pairs are separate.
pub(super) fn runs(name: &str, x: Vec<f64>, y: Vec<f64>) -> Series {
    let breaks: Vec<usize> = (0..x.len()).step_by(2).collect();
    Series::line(name, x, y).breaks(breaks).colour(colour::BLUE)
}
