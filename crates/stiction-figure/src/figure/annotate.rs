//! Annotations as lines, arrowheads and texts on paper.

use super::Annotation;
use super::canvas::Stroke;
use super::curve::Curve;
use super::geometry::{Point, Rect};
use super::layout::View;
use super::palette::{DASHED, INK, REFERENCE, SOLID};
use super::text;

/// Font size of annotations, px.
pub(super) const SIZE: u32 = 12;

const HEAD_LENGTH: f64 = 8.0;
const HEAD_WIDTH: f64 = 5.6;
/// Room between a text and its object, px.
const GAP: f64 = 4.0;

const THIN: Stroke = Stroke { colour: REFERENCE, width: 0.6, dash: SOLID };
const ARROW: Stroke = Stroke { colour: INK, width: 1.0, dash: SOLID };
const LINE: Stroke = Stroke { colour: REFERENCE, width: 1.0, dash: DASHED };

/// An annotation, placed.
#[derive(Default)]
pub(super) struct Mark {
    pub band: Option<Rect>,
    pub lines: Vec<(Point, Point, Stroke)>,
    pub heads: Vec<[Point; 3]>,
    pub note: Option<Note>,
}

/// A block of centred lines of text.
pub(super) struct Note {
    pub rect: Rect,
    /// Abscissa of the annotated object, which moves when a reader zooms along x; `None` for a fixed text.
    pub anchor: Option<f64>,
    pub lines: Vec<String>,
}

impl Mark {
    /// Places `annotation` on the panel. Names of lines and bands avoid the curves if possible.
    pub fn new(annotation: &Annotation, view: &View, curves: &[Curve]) -> Self {
        let frame = &view.frame;
        let at_x = |x: f64| view.place((x, view.y.lo)).x;
        let at_y = |y: f64| view.place((view.x.lo, y)).y;
        let mut mark = Self::default();
        match annotation {
            Annotation::Text { text, at } => mark.write(text, view.place(*at), frame),
            Annotation::Arrow { text, from, to } => {
                mark.arrow(text, view.place(*from), view.place(*to), frame);
            }
            Annotation::HorizontalLine { y, label } => {
                let y = at_y(*y);
                mark.lines.push((Point::new(frame.x, y), Point::new(frame.right(), y), LINE));
                let (w, h) = block(label);
                let xs = across(frame, w);
                let ys = [y - h / 2.0 - 2.0, y + h / 2.0 + 2.0];
                mark.write_free(label, &grid(&xs, &ys), frame, curves);
                mark.anchor(None);
            }
            Annotation::VerticalLine { x, label } => {
                let x = at_x(*x);
                mark.lines.push((Point::new(x, frame.y), Point::new(x, frame.bottom()), LINE));
                let (w, h) = block(label);
                let xs = [x + GAP + w / 2.0, x - GAP - w / 2.0];
                mark.write_free(label, &grid(&xs, &ends(frame, h)), frame, curves);
                mark.anchor(Some(x));
            }
            Annotation::XBand { from, to, label } => {
                let (a, b) = (at_x(*from), at_x(*to));
                let (a, b) = (a.min(b).max(frame.x), a.max(b).min(frame.right()));
                if b > a {
                    mark.band = Some(Rect::new(a, frame.y, b - a, frame.h));
                    let places = grid(&[(a + b) / 2.0], &ends(frame, block(label).1));
                    mark.write_free(label, &places, frame, curves);
                }
            }
            Annotation::Dimension { from, to, label, offset } => {
                mark.dimension(view.place(*from), view.place(*to), label, *offset, frame);
            }
        }
        mark
    }

    /// Whether anything except a band lies in `rect`.
    pub fn touches(&self, rect: &Rect) -> bool {
        self.lines.iter().any(|(a, b, _)| rect.cut(*a, *b).is_some())
            || self.note.as_ref().is_some_and(|note| note.rect.overlaps(rect))
    }

    /// Sets the object of the text.
    fn anchor(&mut self, x: Option<f64>) {
        if let Some(note) = &mut self.note {
            note.anchor = x;
        }
    }

    /// Puts a text near `centre`, within the frame.
    fn write(&mut self, text: &str, centre: Point, frame: &Rect) {
        if text.trim().is_empty() {
            return;
        }
        let (w, h) = block(text);
        let rect = Rect::around(centre, w, h).shifted_into(&frame.grown(-2.0));
        let anchor = Some(rect.centre().x);
        self.note = Some(Note { rect, anchor, lines: text.lines().map(str::to_owned).collect() });
    }

    /// Puts a text at the first place that is within the frame and free of curves, else at the first place.
    fn write_free(&mut self, text: &str, places: &[Point], frame: &Rect, curves: &[Curve]) {
        let (w, h) = block(text);
        let free = |place: &&Point| {
            let rect = Rect::around(**place, w, h);
            rect.shifted_into(frame) == rect && !curves.iter().any(|c| c.touches(&rect))
        };
        if let Some(place) = places.iter().find(free).or(places.first()) {
            self.write(text, *place, frame);
        }
    }

    fn arrow(&mut self, text: &str, from: Point, to: Point, frame: &Rect) {
        self.write(text, from, frame);
        let start = match &self.note {
            None => from,
            Some(note) => {
                // The arrow starts at the edge of the text. A tip inside the text needs no arrow.
                let centre = note.rect.centre();
                match note.rect.grown(2.0).cut(centre, to) {
                    Some((_, leave)) if leave < 1.0 => {
                        centre.along(centre.direction(to), leave * centre.distance(to))
                    }
                    _ => return,
                }
            }
        };
        self.pointer(start, to);
    }

    /// A line with a head at its end.
    fn pointer(&mut self, from: Point, to: Point) {
        let back = to.direction(from);
        let neck = to.along(back, HEAD_LENGTH);
        let side = (-back.1, back.0);
        let half = HEAD_WIDTH / 2.0;
        self.lines.push((from, to.along(back, HEAD_LENGTH.min(from.distance(to)) * 0.8), ARROW));
        self.heads.push([to, neck.along(side, half), neck.along(side, -half)]);
    }

    fn dimension(&mut self, from: Point, to: Point, label: &str, offset: f64, frame: &Rect) {
        let direction = from.direction(to);
        // The side of positive offsets: upwards, or to the right of a vertical arrow.
        let left = (direction.1, -direction.0);
        let upwards = left.1 < -1e-9 || (left.1.abs() <= 1e-9 && left.0 > 0.0);
        let sign = if offset < 0.0 { -1.0 } else { 1.0 };
        let flip = if upwards { sign } else { -sign };
        let away = (left.0 * flip, left.1 * flip);

        let (a, b) = (from.along(away, offset.abs()), to.along(away, offset.abs()));
        if offset.abs() > GAP {
            for (point, end) in [(from, a), (to, b)] {
                self.lines.push((point.along(away, 2.0), end.along(away, GAP), THIN));
            }
        }
        let middle = a.middle(b);
        if a.distance(b) > 2.5 * HEAD_LENGTH {
            self.pointer(middle, a);
            self.pointer(middle, b);
        } else {
            // Too narrow for inner arrowheads, so they point inwards from outside.
            self.pointer(a.along(direction, -2.0 * HEAD_LENGTH), a);
            self.pointer(b.along(direction, 2.0 * HEAD_LENGTH), b);
        }
        let (w, h) = block(label);
        let reach = (away.0.abs() * w + away.1.abs() * h) / 2.0 + GAP;
        self.write(label, middle.along(away, reach), frame);
    }
}

/// Every pair of an abscissa and an ordinate, by ordinate.
fn grid(xs: &[f64], ys: &[f64]) -> Vec<Point> {
    ys.iter().flat_map(|y| xs.iter().map(|x| Point::new(*x, *y))).collect()
}

/// Abscissae of the middle of a text of width `w`, from the right end of the frame to the left.
fn across(frame: &Rect, w: f64) -> Vec<f64> {
    let (first, last) = (frame.right() - GAP - w / 2.0, frame.x + GAP + w / 2.0);
    let steps = ((first - last) / 10.0).ceil().max(1.0);
    (0..=steps as usize).map(|i| first - (first - last) * i as f64 / steps).collect()
}

/// Heights of the middle of a text at the top and at the bottom of the frame.
fn ends(frame: &Rect, h: f64) -> [f64; 2] {
    [frame.y + GAP + h / 2.0, frame.bottom() - GAP - h / 2.0]
}

/// Width and height of a text with its line breaks, px.
fn block(text: &str) -> (f64, f64) {
    let size = f64::from(SIZE);
    let width = text.lines().map(|line| text::width(line, size)).fold(0.0, f64::max);
    (width, text.lines().count() as f64 * size * text::LINE)
}
