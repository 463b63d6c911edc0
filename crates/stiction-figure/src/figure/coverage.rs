//! Computes the covered share of each pixel, for smooth edges.
//!
//! Only plain arithmetic and square roots are used, so that every machine draws the same bytes.

use std::ops::Range;

use super::geometry::Point;

/// Limit of coordinates, in pixels, far beyond any sheet and within the precision of the arithmetic.
const FAR: f64 = 1e6;

/// Covered shares of the pixels of a window, row by row.
pub(super) struct Coverage {
    pub columns: Range<usize>,
    pub rows: Range<usize>,
    shares: Vec<f32>,
}

impl Coverage {
    /// The coverage of a stroke of `radius` along runs of joined points. A single point is a dot.
    ///
    /// The edge of a stroke is a pixel wide, centred on its true place. So a horizontal or vertical stroke has
    /// exactly the share of each pixel that it covers.
    pub fn of_lines(
        runs: &[Vec<Point>],
        radius: f64,
        columns: Range<usize>,
        rows: Range<usize>,
    ) -> Self {
        let mut coverage = Self::window(runs, radius + 1.0, columns, rows);
        for run in runs {
            if let [dot] = run[..] {
                coverage.add_stroke(near(dot), near(dot), radius);
            }
            for pair in run.windows(2) {
                coverage.add_stroke(near(pair[0]), near(pair[1]), radius);
            }
        }
        coverage
    }

    /// The coverage of polygons, with overlaps counted once.
    pub fn of_polygons(outlines: &[Vec<Point>], columns: Range<usize>, rows: Range<usize>) -> Self {
        let mut coverage = Self::window(outlines, 0.0, columns, rows);
        for outline in outlines {
            for (i, corner) in outline.iter().enumerate() {
                coverage.add_edge(near(*corner), near(outline[(i + 1) % outline.len()]));
            }
        }
        for row in coverage.shares.chunks_exact_mut(coverage.columns.len().max(1)) {
            let mut sum = 0.0;
            for share in row {
                sum += *share;
                *share = sum.abs().min(1.0);
            }
        }
        coverage
    }

    /// The covered shares of the pixels of a row of the window.
    pub fn row(&self, row: usize) -> &[f32] {
        let width = self.columns.len();
        &self.shares[(row - self.rows.start) * width..][..width]
    }

    /// An empty window for the points and a `margin` around them, within the requested area.
    fn window(runs: &[Vec<Point>], margin: f64, columns: Range<usize>, rows: Range<usize>) -> Self {
        let reach = |of: fn(&Point) -> f64, wanted: Range<usize>| {
            let (low, high) = (runs.iter().flatten().map(of))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (v.min(a), v.max(b)));
            pixels(low - margin, high + margin, &wanted)
        };
        let (columns, rows) = (reach(|p| p.x, columns), reach(|p| p.y, rows));
        let shares = vec![0.0; columns.len() * rows.len()];
        Self { columns, rows, shares }
    }

    /// Adds a stroke of `radius`.
    fn add_stroke(&mut self, from: Point, to: Point, radius: f64) {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let squared = dx * dx + dy * dy;
        let reach = radius + 0.5;
        let width = self.columns.len();
        for row in pixels(from.y.min(to.y) - reach, from.y.max(to.y) + reach, &self.rows) {
            let y = row as f64 + 0.5;
            // Only a part of the stroke is near this row.
            let at = |y: f64| {
                let part = if dy == 0.0 { 0.0 } else { ((y - from.y) / dy).clamp(0.0, 1.0) };
                from.x + part * dx
            };
            let (a, b) = if dy == 0.0 { (from.x, to.x) } else { (at(y - reach), at(y + reach)) };
            let start = (row - self.rows.start) * width;
            for column in pixels(a.min(b) - reach, a.max(b) + reach, &self.columns) {
                let (x, y) = (column as f64 + 0.5 - from.x, y - from.y);
                let part =
                    if squared > 0.0 { ((x * dx + y * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
                let (x, y) = (x - part * dx, y - part * dy);
                let share = (reach - (x * x + y * y).sqrt()).min(2.0 * radius).clamp(0.0, 1.0);
                let old = &mut self.shares[start + column - self.columns.start];
                *old = old.max(share as f32);
            }
        }
    }

    /// Adds the edge of a polygon, as changes from each pixel to the next in its rows.
    fn add_edge(&mut self, from: Point, to: Point) {
        if from.y == to.y {
            return;
        }
        let (left, right) = (self.columns.start as f64, self.columns.end as f64);
        for side in [left, right] {
            if (from.x < side && to.x > side) || (from.x > side && to.x < side) {
                let part = (side - from.x) / (to.x - from.x);
                let middle = Point::new(side, from.y + part * (to.y - from.y));
                self.add_edge(from, middle);
                return self.add_edge(middle, to);
            }
        }
        let (sign, top, bottom) = if from.y < to.y { (1.0, from, to) } else { (-1.0, to, from) };
        let slope = (bottom.x - top.x) / (bottom.y - top.y);
        for row in pixels(top.y, bottom.y, &self.rows) {
            let y = row as f64;
            let (upper, lower) = (top.y.max(y), bottom.y.min(y + 1.0));
            let height = sign * (lower - upper);
            let at = |y: f64| (top.x + (y - top.y) * slope).clamp(left, right) - left;
            let (a, b) = (at(upper), at(lower));
            self.add_crossing(row, a.min(b), a.max(b), height);
        }
    }

    /// Adds an edge that crosses a row, from `a` to `b` in pixels of the window.
    fn add_crossing(&mut self, row: usize, a: f64, b: f64, height: f64) {
        let width = self.columns.len();
        let start = (row - self.rows.start) * width;
        // To the right of `x`, this share of the height is inside, summed over all columns so far.
        let mut before = 0.0;
        for column in a as usize..width {
            let x = column as f64 + 1.0;
            // The mean over the pixel of the part of the edge that lies to the left.
            let after = if b - a > 1e-9 { area(x, a, b) - area(x - 1.0, a, b) } else { x - a };
            let after = if x - 1.0 >= b { 1.0 } else { after.clamp(0.0, 1.0) };
            self.shares[start + column] += (height * (after - before)) as f32;
            before = after;
            if x - 1.0 >= b {
                break;
            }
        }
    }
}

/// The integral up to `x` of the part of `a` to `b` that lies to the left.
fn area(x: f64, a: f64, b: f64) -> f64 {
    if x <= a {
        0.0
    } else if x < b {
        (x - a) * (x - a) / (2.0 * (b - a))
    } else {
        x - (a + b) / 2.0
    }
}

/// The requested pixels that lie at least partly between two places.
fn pixels(from: f64, to: f64, wanted: &Range<usize>) -> Range<usize> {
    // Negative values become zero, and so does NaN.
    let start = (from.floor() as usize).max(wanted.start);
    start..(to.ceil() as usize).min(wanted.end).max(start)
}

fn near(p: Point) -> Point {
    Point::new(p.x.clamp(-FAR, FAR), p.y.clamp(-FAR, FAR))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(of: &[(f64, f64)]) -> Vec<Vec<Point>> {
        vec![of.iter().map(|(x, y)| Point::new(*x, *y)).collect()]
    }

    fn total(coverage: &Coverage) -> f32 {
        coverage.shares.iter().sum()
    }

    #[test]
    fn polygons_cover_their_area() {
        let of = |corners: &[(f64, f64)]| Coverage::of_polygons(&points(corners), 0..50, 0..50);
        let rectangle = of(&[(1.25, 2.0), (3.5, 2.0), (3.5, 3.5), (1.25, 3.5)]);
        assert_eq!(rectangle.columns, 1..4);
        assert_eq!(rectangle.row(2), [0.75, 1.0, 0.5]);
        assert_eq!(rectangle.row(3), [0.375, 0.5, 0.25]);
        let triangle = of(&[(3.3, 2.2), (40.1, 17.3), (8.7, 31.9)]);
        let (a, b) = ((40.1 - 3.3, 17.3 - 2.2), (8.7 - 3.3, 31.9 - 2.2));
        assert!((total(&triangle) - ((a.0 * b.1 - a.1 * b.0) / 2.0) as f32).abs() < 1e-2);
    }

    #[test]
    fn what_is_outside_of_the_window_is_left_out() {
        let diamond = [(10.0, -10.0), (30.0, 10.0), (10.0, 30.0), (-10.0, 10.0)];
        let whole = Coverage::of_polygons(&points(&diamond), 5..15, 5..15);
        assert_eq!(total(&whole), 100.0);
        let corner = Coverage::of_polygons(&points(&diamond), 0..10, 0..10);
        assert!((total(&corner) - 100.0).abs() < 1e-4);
        let half = [(-1e300, 5.5), (1e300, 5.5), (1e300, 1e300), (-1e300, 1e300)];
        assert_eq!(total(&Coverage::of_polygons(&points(&half), 0..10, 0..10)), 45.0);
        assert_eq!(total(&Coverage::of_lines(&points(&half), 1.0, 0..10, 0..10)), 20.0);
        assert_eq!(total(&Coverage::of_polygons(&[], 0..10, 0..10)), 0.0);
        assert_eq!(total(&Coverage::of_polygons(&[vec![]], 0..10, 0..0)), 0.0);
    }

    #[test]
    fn strokes_are_as_wide_as_they_should_be() {
        let level = Coverage::of_lines(&points(&[(10.0, 10.3), (40.0, 10.3)]), 0.7, 20..30, 0..50);
        assert!((total(&level) - 14.0).abs() < 1e-4);
        let hair = Coverage::of_lines(&points(&[(10.0, 10.5), (40.0, 10.5)]), 0.1, 20..30, 0..50);
        assert!((total(&hair) - 2.0).abs() < 1e-4);
        let slanted = Coverage::of_lines(&points(&[(10.0, 10.2), (40.0, 32.7)]), 1.6, 0..50, 0..50);
        let exact = 3.2 * 37.5 + std::f64::consts::PI * 1.6 * 1.6;
        assert!((f64::from(total(&slanted)) / exact - 1.0).abs() < 0.01);
        let dot = Coverage::of_lines(&points(&[(25.2, 25.7)]), 5.0, 0..50, 0..50);
        assert!((f64::from(total(&dot)) / (25.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
    }
}
