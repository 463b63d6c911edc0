//! A series as strokes on paper.

use super::geometry::{Point, Rect};
use super::layout::View;
use super::palette::{Look, Marker};
use super::{Series, Style, reduce};

/// Radius of the markers of a cloud, px.
pub(super) const RADIUS: f64 = 2.2;

/// The shapes of a series.
pub(super) enum Curve {
    /// Runs of joined points.
    Lines(Vec<Vec<Point>>),
    /// Markers.
    Points(Vec<Point>, Marker),
    /// Bars.
    Bars(Vec<Rect>),
}

impl Curve {
    /// The visible part of `series`, reduced to the visible resolution.
    pub fn new(series: &Series, look: &Look, view: &View) -> Self {
        if series.style == Style::Bars {
            let bars = edges(&series.x).into_iter().zip(&series.y);
            return Self::Bars(bars.map(|((from, to), &y)| bar(from, to, y, view)).collect());
        }
        let points: Vec<Point> =
            series.x.iter().zip(&series.y).map(|(&x, &y)| view.place((x, y))).collect();
        if let Some(marker) = look.marker {
            return Self::Points(reduce::cloud(&points, &view.frame, RADIUS), marker);
        }
        let draw = |run: &[Point]| {
            let run = if series.style == Style::Steps { &held(run)[..] } else { run };
            if series.is_trend() {
                vec![reduce::slim(&reduce::trend(run, &view.frame))]
            } else {
                reduce::map(run, &view.frame)
            }
        };
        Self::Lines(runs(&points, &series.breaks).into_iter().flat_map(draw).collect())
    }

    /// Whether anything of the curve lies in `rect`.
    pub fn touches(&self, rect: &Rect) -> bool {
        match self {
            Self::Lines(runs) => {
                runs.iter().flat_map(|run| run.windows(2)).any(|p| rect.cut(p[0], p[1]).is_some())
            }
            Self::Points(points, _) => {
                let reach = rect.grown(RADIUS);
                points.iter().any(|p| reach.cut(*p, *p).is_some())
            }
            Self::Bars(bars) => bars.iter().any(|bar| bar.overlaps(rect)),
        }
    }
}

/// `points`, cut before each index of `breaks`. No run is empty.
fn runs<'a>(points: &'a [Point], breaks: &[usize]) -> Vec<&'a [Point]> {
    let mut runs = Vec::new();
    let mut from = 0;
    for to in breaks.iter().copied().chain([points.len()]) {
        if from < to && to <= points.len() {
            runs.push(&points[from..to]);
            from = to;
        }
    }
    runs
}

/// Beginnings and ends of bars at `x`, half-way to their neighbours. The first and the last bar are symmetric.
pub(super) fn edges(x: &[f64]) -> Vec<(f64, f64)> {
    let half = |i: usize, j: usize| (x[j] - x[i]).abs() / 2.0;
    let last = x.len().saturating_sub(1);
    let edge = |i: usize| {
        let before = (i > 0).then(|| half(i - 1, i));
        let after = (i < last).then(|| half(i, i + 1));
        let (left, right) = match (before, after) {
            (Some(left), Some(right)) => (left, right),
            (Some(same), None) | (None, Some(same)) => (same, same),
            (None, None) => (0.5, 0.5),
        };
        (x[i] - left, x[i] + right)
    };
    (0..x.len()).map(edge).collect()
}

/// The bar from zero to `y`.
fn bar(from: f64, to: f64, y: f64, view: &View) -> Rect {
    let (a, b) = (view.place((from, 0.0)), view.place((to, y)));
    Rect::new(a.x.min(b.x), a.y.min(b.y), (a.x - b.x).abs(), (a.y - b.y).abs())
}

/// The corners of a staircase through `points`.
fn held(points: &[Point]) -> Vec<Point> {
    let mut corners: Vec<Point> = points.first().copied().into_iter().collect();
    for pair in points.windows(2) {
        corners.push(Point::new(pair[1].x, pair[0].y));
        corners.push(pair[1]);
    }
    corners
}
