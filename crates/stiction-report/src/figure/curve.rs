//! A series as strokes on paper.

use super::geometry::{Point, Rect};
use super::layout::View;
use super::palette::{Look, Marker};
use super::{Series, Style, reduce};

/// Radius of the markers of a cloud, px.
pub(super) const RADIUS: f64 = 2.2;

/// What there is to paint of a series.
pub(super) enum Curve {
    /// Runs of joined points.
    Lines(Vec<Vec<Point>>),
    /// Markers.
    Points(Vec<Point>, Marker),
}

impl Curve {
    /// The visible part of `series`, reduced to what can be seen.
    pub fn new(series: &Series, look: &Look, view: &View) -> Self {
        let mut points: Vec<Point> =
            series.x.iter().zip(&series.y).map(|(&x, &y)| view.place((x, y))).collect();
        if let Some(marker) = look.marker {
            return Self::Points(reduce::cloud(&points, &view.frame, RADIUS), marker);
        }
        if series.style == Style::Steps {
            points = held(&points);
        }
        Self::Lines(if series.is_trend() {
            vec![reduce::trend(&points, &view.frame)]
        } else {
            reduce::map(&points, &view.frame)
        })
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
        }
    }
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
