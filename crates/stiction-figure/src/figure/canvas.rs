//! The drawing surface, with shapes that both SVG and pixels support.

use std::collections::BTreeMap;

use super::geometry::{Point, Rect};
use super::palette::{Dash, Marker, Rgb};
use super::text;

/// The properties of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke {
    pub colour: Rgb,
    pub width: f64,
    pub dash: Dash,
}

/// The part of a text that is at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// The properties of a text.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lettering {
    pub size: u32,
    pub anchor: Anchor,
    pub bold: bool,
    /// Rotated to read upwards.
    pub upright: bool,
    pub colour: Rgb,
}

/// The target of a drawing. Ends and joints of lines are round, so that noise peaks have no spikes. Dots are strokes
/// of zero length.
pub(super) trait Surface {
    /// Whether a script can find the parts of the drawing.
    fn is_page(&self) -> bool {
        false
    }

    /// Draws runs of joined points.
    fn lines(&mut self, runs: &[Vec<Point>], stroke: &Stroke);

    /// Fills a polygon.
    fn polygon(&mut self, corners: &[Point], colour: Rgb);

    /// Fills polygons as one shape, with an opacity.
    fn polygons(&mut self, outlines: &[Vec<Point>], colour: Rgb, opacity: f64);

    /// Fills rectangles that adjoin others in other colours without a gap.
    fn tiles(&mut self, tiles: &[Rect], colour: Rgb);

    /// Fills a rectangle.
    fn rect(&mut self, rect: &Rect, colour: Rgb, opacity: f64);

    /// Sets one line of printable text with its base line at `at`.
    fn text(&mut self, at: Point, content: &str, lettering: &Lettering);

    /// Restricts drawing to a rectangle until [`Surface::unclip`].
    fn clip(&mut self, rect: &Rect);

    fn unclip(&mut self);

    /// Begins a part of a page.
    fn begin(&mut self, _attributes: &str) {}

    /// Ends a part of a page.
    fn end(&mut self) {}
}

/// A sheet to draw on, px, y downwards.
pub(super) struct Canvas<'a> {
    surface: &'a mut dyn Surface,
}

impl<'a> Canvas<'a> {
    pub fn on(surface: &'a mut dyn Surface) -> Self {
        Self { surface }
    }

    /// Draws runs of joined points.
    pub fn lines(&mut self, runs: &[Vec<Point>], stroke: &Stroke) {
        self.surface.lines(runs, stroke);
    }

    /// Draws one straight line.
    pub fn line(&mut self, from: Point, to: Point, stroke: &Stroke) {
        self.lines(&[vec![from, to]], stroke);
    }

    /// Fills a polygon.
    pub fn polygon(&mut self, corners: &[Point], colour: Rgb) {
        self.surface.polygon(corners, colour);
    }

    /// Fills a rectangle with an opacity.
    pub fn fill(&mut self, rect: &Rect, colour: Rgb, opacity: f64) {
        self.surface.rect(rect, colour, opacity);
    }

    /// Fills and outlines rectangles, all as one path each.
    pub fn bars(&mut self, bars: &[Rect], opacity: f64, edge: &Stroke) {
        let outlines: Vec<Vec<Point>> = bars.iter().map(|bar| corners(bar, 5)).collect();
        self.surface.polygons(&outlines, edge.colour, opacity);
        self.lines(&outlines, edge);
    }

    /// Fills adjacent rectangles, each in its colour.
    pub fn tiles(&mut self, tiles: &[(Rect, Rgb)]) {
        let mut colours: BTreeMap<Rgb, Vec<Rect>> = BTreeMap::new();
        for (rect, colour) in tiles {
            colours.entry(*colour).or_default().push(*rect);
        }
        for (colour, tiles) in colours {
            self.surface.tiles(&tiles, colour);
        }
    }

    /// Outlines a rectangle.
    pub fn outline(&mut self, rect: &Rect, stroke: &Stroke) {
        self.lines(&[corners(rect, 5)], stroke);
    }

    /// Draws a marker of about the given radius at each point.
    pub fn markers(&mut self, points: &[Point], marker: Marker, radius: f64, colour: Rgb) {
        if marker == Marker::Circle {
            let dots: Vec<Vec<Point>> = points.iter().map(|p| vec![*p]).collect();
            return self.lines(&dots, &Stroke { colour, width: 2.0 * radius, dash: &[] });
        }
        let shape: &[(f64, f64)] = match marker {
            Marker::Circle => &[],
            Marker::Square => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
            Marker::Triangle => &[(0.0, -1.3), (1.15, 0.8), (-1.15, 0.8)],
            Marker::Diamond => &[(0.0, -1.35), (1.35, 0.0), (0.0, 1.35), (-1.35, 0.0)],
        };
        for p in points {
            let corner = |(x, y): &(f64, f64)| Point::new(p.x + x * radius, p.y + y * radius);
            self.polygon(&shape.iter().map(corner).collect::<Vec<_>>(), colour);
        }
    }

    /// Sets one line of text with its base line at `at`.
    pub fn text(&mut self, at: Point, content: &str, lettering: &Lettering) {
        // With the precision of paths.
        let tenths = |v: f64| (v * 10.0).round() / 10.0;
        let at = Point::new(tenths(at.x), tenths(at.y));
        self.surface.text(at, &text::printable(content), lettering);
    }

    /// Restricts drawing to a rectangle until [`Canvas::unclip`].
    pub fn clip(&mut self, rect: &Rect) {
        self.surface.clip(rect);
    }

    pub fn unclip(&mut self) {
        self.surface.unclip();
    }

    /// Whether a script can distinguish the parts of the drawing.
    pub fn is_page(&self) -> bool {
        self.surface.is_page()
    }

    /// Draws a part that a script can find by its class. Without a page, it only draws.
    pub fn part(&mut self, class: &str, draw: impl FnOnce(&mut Self)) {
        self.group(&format!("class=\"{class}\""), draw);
    }

    /// Draws a part that a script can find by its class, with its abscissa. Without a page, it only draws.
    pub fn part_at(&mut self, class: &str, x: f64, draw: impl FnOnce(&mut Self)) {
        self.group(&format!("class=\"{class}\" data-x=\"{x:.1}\""), draw);
    }

    fn group(&mut self, attributes: &str, draw: impl FnOnce(&mut Self)) {
        self.surface.begin(attributes);
        draw(self);
        self.surface.end();
    }
}

/// The first corners of a rectangle, clockwise; the fifth is the first again.
pub(super) fn corners(rect: &Rect, count: usize) -> Vec<Point> {
    let (right, bottom) = (rect.right(), rect.bottom());
    let all = [(rect.x, rect.y), (right, rect.y), (right, bottom), (rect.x, bottom)];
    all.iter().cycle().take(count).map(|(x, y)| Point::new(*x, *y)).collect()
}
