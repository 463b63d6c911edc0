//! Reduces points without changing the picture.

use super::geometry::{Point, Rect};

/// Finest detail of a trend, px.
const COLUMN: f64 = 1.0;
/// Maximum distance along y of a dropped sample of a trend from the stroke that replaces it, px.
const FLAT: f64 = 0.15;
/// Samples of a map closer than this to the last one kept are dropped, px.
const NEAR: f64 = 0.3;
/// Maximum distance of a dropped sample of a map from the stroke that replaces it, px.
const STRAIGHT: f64 = 0.08;
/// Largest number of samples that one stroke of a map replaces.
const WINDOW: usize = 64;
/// Side of the cells in which ink is accounted for, px.
const CELL: f64 = 0.5;

/// The visible samples of a trend: the lowest and the highest in each pixel column, the first and the last of all, and
/// one neighbour beyond either side of the frame.
pub(super) fn trend(points: &[Point], frame: &Rect) -> Vec<Point> {
    seen(points, frame, COLUMN).into_iter().map(|i| points[i]).collect()
}

/// A trend without the samples that lie on the stroke between their neighbours, to within [`FLAT`].
pub(super) fn slim(points: &[Point]) -> Vec<Point> {
    let mut kept: Vec<Point> = points.first().copied().into_iter().collect();
    // Slopes from the last sample kept that pass all samples since.
    let mut slopes = (f64::NEG_INFINITY, f64::INFINITY);
    for pair in points.windows(2) {
        let (from, to) = (kept[kept.len() - 1], pair[1]);
        let slope = |y: f64| (y - from.y) / (to.x - from.x);
        if !(slopes.0..=slopes.1).contains(&slope(to.y)) {
            kept.push(pair[0]);
            slopes = (f64::NEG_INFINITY, f64::INFINITY);
        }
        let from = kept[kept.len() - 1];
        let slope = |y: f64| (y - from.y) / (to.x - from.x);
        slopes = (slopes.0.max(slope(to.y - FLAT)), slopes.1.min(slope(to.y + FLAT)));
    }
    if points.len() > 1 {
        kept.extend(points.last());
    }
    kept
}

/// Indices of the samples that [`trend`] keeps, with columns of the given width.
pub(super) fn seen(points: &[Point], frame: &Rect, width: f64) -> Vec<usize> {
    let from = points.partition_point(|p| p.x < frame.x).saturating_sub(1);
    let to = (points.partition_point(|p| p.x <= frame.right()) + 1).min(points.len());
    let mut kept = Vec::new();
    let column = |p: &Point| ((p.x - frame.x) / width).floor();
    let mut start = from;
    for run in points[from..to].chunk_by(|a, b| column(a) == column(b)) {
        let by_height = |a: &&usize, b: &&usize| run[**a].y.total_cmp(&run[**b].y);
        let indices: Vec<usize> = (0..run.len()).collect();
        let low = indices.iter().min_by(by_height).copied().unwrap_or(0);
        let high = indices.iter().max_by(by_height).copied().unwrap_or(0);
        kept.extend([low.min(high), low.max(high)].map(|index| start + index));
        start += run.len();
    }
    kept.insert(0, from);
    kept.push(to.saturating_sub(1));
    kept.dedup();
    kept.retain(|index| *index < points.len());
    kept
}

/// The visible strokes of a map, in runs of joined points.
///
/// Besides near and collinear samples this drops strokes that the same map has already painted, so a limit cycle of
/// fifty turns is drawn about once.
pub(super) fn map(points: &[Point], frame: &Rect) -> Vec<Vec<Point>> {
    let path = straightened(&spaced(points));
    if path.len() == 1 {
        return vec![path];
    }
    let mut ink = Ink::new(frame);
    let mut runs: Vec<Vec<Point>> = Vec::new();
    let mut joined = false;
    for pair in path.windows(2) {
        if !ink.stroke(pair[0], pair[1]) {
            joined = false;
            continue;
        }
        match runs.last_mut() {
            Some(run) if joined => run.push(pair[1]),
            _ => runs.push(pair.to_vec()),
        }
        joined = true;
    }
    runs
}

/// The visible points of a cloud: discs of which others cover less than nine tenths.
pub(super) fn cloud(points: &[Point], frame: &Rect, radius: f64) -> Vec<Point> {
    let mut ink = Ink::new(frame);
    points.iter().copied().filter(|p| ink.disc(*p, radius) > 0.1).collect()
}

/// Drops points near the last one kept. The end is kept.
fn spaced(points: &[Point]) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::new();
    for &p in points {
        if kept.last().is_none_or(|last| last.distance(p) >= NEAR) {
            kept.push(p);
        }
    }
    if let Some(&end) = points.last()
        && kept.last() != Some(&end)
    {
        kept.push(end);
    }
    kept
}

/// Replaces nearly straight segments by one stroke.
fn straightened(points: &[Point]) -> Vec<Point> {
    let mut kept = Vec::new();
    let mut anchor = 0;
    kept.extend(points.first());
    while anchor + 1 < points.len() {
        let mut end = anchor + 1;
        while end + 1 < points.len()
            && end - anchor < WINDOW
            && (anchor + 1..=end)
                .all(|i| distance(points[i], points[anchor], points[end + 1]) <= STRAIGHT)
        {
            end += 1;
        }
        kept.push(points[end]);
        anchor = end;
    }
    kept
}

/// Distance of `p` from the segment `a`-`b`.
fn distance(p: Point, a: Point, b: Point) -> f64 {
    let length = a.distance(b);
    if length == 0.0 {
        return p.distance(a);
    }
    let (dx, dy) = a.direction(b);
    let along = ((p.x - a.x) * dx + (p.y - a.y) * dy).clamp(0.0, length);
    p.distance(a.along((dx, dy), along))
}

/// The cells of the frame that a series has painted.
struct Ink {
    frame: Rect,
    columns: usize,
    rows: usize,
    cells: Vec<bool>,
}

impl Ink {
    fn new(frame: &Rect) -> Self {
        let columns = (frame.w / CELL).ceil() as usize + 1;
        let rows = (frame.h / CELL).ceil() as usize + 1;
        Self { frame: *frame, columns, rows, cells: vec![false; columns * rows] }
    }

    /// Paints the stroke, and returns whether that changed anything.
    fn stroke(&mut self, a: Point, b: Point) -> bool {
        let Some((enter, leave)) = self.frame.cut(a, b) else { return false };
        let length = a.distance(b);
        let steps = ((leave - enter) * length / CELL).ceil().max(1.0) as usize;
        let mut changed = false;
        for i in 0..=steps {
            let t = enter + (leave - enter) * i as f64 / steps as f64;
            changed |= self.cell(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y));
        }
        changed
    }

    /// Paints the disc, and returns the share of it that was not yet painted.
    fn disc(&mut self, centre: Point, radius: f64) -> f64 {
        let reach = (radius / CELL).floor() as i32;
        let (mut changed, mut all) = (0, 0);
        for i in -reach..=reach {
            for j in -reach..=reach {
                let (dx, dy) = (f64::from(i) * CELL, f64::from(j) * CELL);
                if dx.hypot(dy) <= radius {
                    changed += i32::from(self.cell(centre.x + dx, centre.y + dy));
                    all += 1;
                }
            }
        }
        f64::from(changed) / f64::from(all.max(1))
    }

    fn cell(&mut self, x: f64, y: f64) -> bool {
        let (column, row) = ((x - self.frame.x) / CELL, (y - self.frame.y) / CELL);
        if column < 0.0 || row < 0.0 {
            return false;
        }
        let (column, row) = (column as usize, row as usize);
        if column >= self.columns || row >= self.rows {
            return false;
        }
        !std::mem::replace(&mut self.cells[row * self.columns + column], true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Rect = Rect { x: 10.0, y: 20.0, w: 600.0, h: 200.0 };

    /// A reproducible scatter of 0 to 1.
    fn scatter(count: usize) -> impl Iterator<Item = f64> {
        (0..count).map(|i| ((i as f64 * 12.9898).sin() * 43_758.545_3).fract().abs())
    }

    fn noise(count: usize) -> Vec<Point> {
        let x = |i: usize| 10.0 + 600.0 * i as f64 / (count - 1) as f64;
        scatter(count).enumerate().map(|(i, r)| Point::new(x(i), 20.0 + 200.0 * r)).collect()
    }

    #[test]
    fn a_trend_keeps_every_extreme_of_every_column() {
        let all = noise(60_000);
        let kept = trend(&all, &FRAME);
        assert!(kept.len() <= 2 * 602, "{}", kept.len());
        let heights = |points: &[Point], column: f64| {
            points
                .iter()
                .filter(|p| ((p.x - FRAME.x) / COLUMN).floor() == column)
                .fold((f64::MAX, f64::MIN), |(lo, hi), p| (lo.min(p.y), hi.max(p.y)))
        };
        for column in 0..600 {
            assert_eq!(heights(&all, column as f64), heights(&kept, column as f64));
        }
        assert_eq!((all.first(), all.last()), (kept.first(), kept.last()));
    }

    #[test]
    fn a_slim_trend_is_where_it_was() {
        let wave: Vec<Point> = (0..3000)
            .map(|i| f64::from(i) / 5.0)
            .map(|x| Point::new(x, 100.0 + 80.0 * (x / 40.0).sin() + 3.0 * (x / 100.0).floor()))
            .collect();
        let stairs = [(0.0, 5.0), (3.0, 5.0), (3.0, 5.0), (3.0, 9.0), (4.0, 9.0), (4.0, 2.0)];
        let stairs = stairs.map(|(x, y)| Point::new(x, y)).to_vec();
        for all in [wave, noise(2000), stairs.clone(), vec![stairs[0]], vec![]] {
            let slim = slim(&all);
            assert_eq!((all.first(), all.last()), (slim.first(), slim.last()));
            for p in &all {
                let strokes = slim.windows(2).map(|pair| distance(*p, pair[0], pair[1]));
                let nearest = strokes.fold(f64::MAX, f64::min);
                assert!(nearest <= FLAT + 1e-9 || slim.len() < 2, "{p:?} is {nearest} px off");
            }
        }
        let sine: Vec<Point> = (0..1000)
            .map(|i| Point::new(f64::from(i), 50.0 * (f64::from(i) / 50.0).sin()))
            .collect();
        assert!(slim(&sine).len() < 300, "{}", slim(&sine).len());
    }

    #[test]
    fn a_short_trend_is_left_alone() {
        let all = noise(300);
        assert_eq!(trend(&all, &FRAME), all);
    }

    #[test]
    fn a_trend_beyond_the_frame_keeps_one_neighbour_on_each_side() {
        let all: Vec<Point> = (-50..150).map(|i| Point::new(10.0 * f64::from(i), 50.0)).collect();
        let kept = trend(&all, &FRAME);
        assert_eq!((kept[0].x, kept[kept.len() - 1].x), (0.0, 620.0));
    }

    #[test]
    fn a_map_drawn_fifty_times_is_drawn_about_once() {
        let turn = |i: usize| {
            let angle = i as f64 / 1000.0 * std::f64::consts::TAU;
            Point::new(300.0 + 80.0 * angle.cos(), 120.0 + 60.0 * angle.sin())
        };
        let once: usize =
            map(&(0..=1000).map(turn).collect::<Vec<_>>(), &FRAME).iter().map(Vec::len).sum();
        let many: usize =
            map(&(0..=50_000).map(turn).collect::<Vec<_>>(), &FRAME).iter().map(Vec::len).sum();
        assert!(many < 4 * once, "{many} against {once}");
    }

    #[test]
    fn a_map_stays_where_it_was() {
        let all: Vec<Point> = scatter(800)
            .zip(scatter(900).skip(100))
            .map(|(a, b)| Point::new(10.0 + 600.0 * a, 20.0 + 200.0 * b))
            .collect();
        let runs = map(&all, &FRAME);
        for p in &all {
            let nearest = runs
                .iter()
                .flat_map(|run| run.windows(2))
                .map(|pair| distance(*p, pair[0], pair[1]))
                .fold(f64::MAX, f64::min);
            assert!(nearest <= NEAR + STRAIGHT, "{p:?} is {nearest} px off");
        }
    }

    #[test]
    fn a_cloud_keeps_what_can_be_seen() {
        let far = Point::new(100.0, 100.0);
        let cloud = cloud(&[far, Point::new(200.0, 100.0), far, far], &FRAME, 2.0);
        assert_eq!(cloud.len(), 2);
    }
}
