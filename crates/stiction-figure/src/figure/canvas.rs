//! The drawing surface. This is the only file that knows the drawing crate, `kuva`.
//!
//! Of that crate it uses the lower half: primitives, the SVG writer, and the rasteriser with its
//! bundled font. What that half lacks is added here:
//!
//! * SVG documents get a `viewBox`, so that they scale, and a text alternative;
//! * on a live page, what moves or is replaced when a reader zooms is grouped and named;
//! * paths are written in tenths of px, relatively, at half the size;
//! * clip paths are named after their geometry: names are the same in every run, and two pictures
//!   in one HTML document cannot spoil each other;
//! * the rasteriser restarts a dash pattern at every vertex, so dashes are cut here;
//! * its edges are smooth in one direction only, so it draws at twice the size and the picture is
//!   averaged down;
//! * its turned letters are too bold, so upright text is drawn level and turned afterwards.

use std::collections::BTreeMap;
use std::fmt::Write;

use kuva::RasterBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor, TextSpan};
use maud::{PreEscaped, html};

use super::geometry::{Point, Rect};
use super::palette::{Dash, Marker, Rgb};
use super::pixels::Pixels;
use super::text;
use crate::error::Error;

/// Fonts in the order of preference; layout reserves room for the widest, the first.
const FONTS: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";
/// Pixels to the px in a PNG.
const PNG_SCALE: usize = 2;
/// Rasterised pixels to the PNG pixel, in each direction.
const OVERSAMPLING: usize = 2;
/// Rasterised pixels to the px.
const RASTER: f64 = (PNG_SCALE * OVERSAMPLING) as f64;

/// What the drawing will become: the two need lines in different forms.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Target {
    Svg,
    Png,
    /// An SVG whose parts a script can find; `id` begins the names of its clip paths.
    Page {
        id: String,
    },
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke {
    pub colour: Rgb,
    pub width: f64,
    pub dash: Dash,
}

/// Which part of a text stands at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text is set.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lettering {
    pub size: u32,
    pub anchor: Anchor,
    pub bold: bool,
    /// Turned to read upwards; not together with bold.
    pub upright: bool,
    pub colour: Rgb,
}

/// A sheet to draw on, px, y downwards.
pub(super) struct Canvas {
    scene: Scene,
    target: Target,
    /// Text that a PNG gets last.
    upright: Vec<(Point, String, Lettering)>,
}

impl Canvas {
    pub fn new(target: Target, width: f64, height: f64) -> Self {
        let mut scene = Scene::new(width.ceil(), height.ceil()).with_background(Some("#ffffff"));
        // Peaks of noise must not grow spikes, and dots are strokes of no length.
        scene.add(Primitive::GroupStart {
            transform: None,
            title: None,
            extra_attrs: Some(r#"stroke-linejoin="round" stroke-linecap="round""#.to_owned()),
        });
        Self { scene, target, upright: Vec::new() }
    }

    /// Draws runs of joined points.
    pub fn lines(&mut self, runs: &[Vec<Point>], stroke: &Stroke) {
        match self.target {
            Target::Svg | Target::Page { .. } => {
                let dash: Vec<String> = stroke.dash.iter().map(f64::to_string).collect();
                self.scene.add(Primitive::Path(Box::new(PathData {
                    d: path(runs),
                    fill: None,
                    stroke: paint(stroke.colour),
                    stroke_width: stroke.width,
                    opacity: None,
                    stroke_dasharray: (!dash.is_empty()).then(|| dash.join(" ")),
                })));
            }
            Target::Png => {
                for run in runs.iter().flat_map(|run| dashes(run, stroke.dash)) {
                    let mut points: Vec<(f64, f64)> = run.iter().map(|p| (p.x, p.y)).collect();
                    if let [dot] = points[..] {
                        points.push(dot);
                    }
                    self.scene.add(Primitive::PolyLine {
                        points,
                        stroke: paint(stroke.colour),
                        stroke_width: stroke.width,
                        stroke_dasharray: None,
                    });
                }
            }
        }
    }

    /// Draws one straight line.
    pub fn line(&mut self, from: Point, to: Point, stroke: &Stroke) {
        self.lines(&[vec![from, to]], stroke);
    }

    /// Fills a polygon.
    pub fn polygon(&mut self, corners: &[Point], colour: Rgb) {
        self.scene.add(Primitive::Path(Box::new(PathData {
            d: path(&[corners.to_vec()]) + "z",
            fill: Some(paint(colour)),
            stroke: Color::None,
            stroke_width: 0.0,
            opacity: None,
            stroke_dasharray: None,
        })));
    }

    /// Fills a rectangle, more or less transparently.
    pub fn fill(&mut self, rect: &Rect, colour: Rgb, opacity: f64) {
        self.scene.add(Primitive::Rect {
            x: rect.x,
            y: rect.y,
            width: rect.w,
            height: rect.h,
            fill: paint(colour),
            stroke: None,
            stroke_width: None,
            opacity: Some(opacity),
        });
    }

    /// Fills and outlines rectangles, all as one path each.
    pub fn bars(&mut self, bars: &[Rect], opacity: f64, edge: &Stroke) {
        let outlines: Vec<Vec<Point>> = bars.iter().map(|bar| corners(bar, 5)).collect();
        self.scene.add(Primitive::Path(Box::new(PathData {
            d: path(&outlines),
            fill: Some(paint(edge.colour)),
            stroke: Color::None,
            stroke_width: 0.0,
            opacity: Some(opacity),
            stroke_dasharray: None,
        })));
        self.lines(&outlines, edge);
    }

    /// Fills rectangles that lie side by side, each in its colour.
    pub fn tiles(&mut self, tiles: &[(Rect, Rgb)]) {
        // As much as paper would otherwise shine through between two of them, px.
        const OVERLAP: f64 = 0.1;
        let mut colours: BTreeMap<Rgb, Vec<Vec<Point>>> = BTreeMap::new();
        for (rect, colour) in tiles {
            let rect = rect.grown(OVERLAP);
            colours.entry(*colour).or_default().push(corners(&rect, 4));
        }
        for (colour, corners) in colours {
            self.scene.add(Primitive::Path(Box::new(PathData {
                d: path(&corners),
                fill: Some(paint(colour)),
                stroke: Color::None,
                stroke_width: 0.0,
                opacity: None,
                stroke_dasharray: None,
            })));
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
        let content = printable(content);
        // As fine as paths.
        let tenths = |v: f64| (v * 10.0).round() / 10.0;
        let at = Point::new(tenths(at.x), tenths(at.y));
        if lettering.upright && self.target == Target::Png {
            self.upright.push((at, content, Lettering { upright: false, ..*lettering }));
            return;
        }
        let anchor = match lettering.anchor {
            Anchor::Start => TextAnchor::Start,
            Anchor::Middle => TextAnchor::Middle,
            Anchor::End => TextAnchor::End,
        };
        let color = Some(paint(lettering.colour));
        // The rasteriser knows bold only in spans, and spans cannot be turned.
        self.scene.add(if lettering.bold {
            let span = TextSpan { bold: true, ..TextSpan::plain(content) };
            let size = lettering.size;
            Primitive::RichText { x: at.x, y: at.y, spans: vec![span], size, anchor, color }
        } else {
            Primitive::Text {
                x: at.x,
                y: at.y,
                // A pair of dollars would be read as mathematics.
                content: content.replace('$', "\\$"),
                size: lettering.size,
                anchor,
                rotate: lettering.upright.then_some(-90.0),
                bold: false,
                color,
            }
        });
    }

    /// Restricts drawing to a rectangle until [`Canvas::unclip`].
    pub fn clip(&mut self, rect: &Rect) {
        let tenths = |v: f64| (v * 10.0).round() as i64;
        let owner = match &self.target {
            Target::Page { id } => format!("{id}-"),
            _ => String::new(),
        };
        let id = format!(
            "{owner}clip-{}-{}-{}-{}",
            tenths(rect.x),
            tenths(rect.y),
            tenths(rect.w),
            tenths(rect.h)
        );
        let (x, y, width, height) = (rect.x, rect.y, rect.w, rect.h);
        let definition = format!(
            r#"<clipPath id="{id}"><rect x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}"/></clipPath>"#
        );
        if !self.scene.defs.contains(&definition) {
            self.scene.defs.push(definition);
        }
        self.scene.add(Primitive::ClipStart { x, y, width, height, id });
    }

    /// Whether the parts of the drawing can be told apart by a script.
    pub fn is_page(&self) -> bool {
        matches!(self.target, Target::Page { .. })
    }

    /// Draws what a script can find by its class; elsewhere, just draws.
    pub fn part(&mut self, class: &str, draw: impl FnOnce(&mut Self)) {
        self.group(format!("class=\"{class}\""), draw);
    }

    /// Draws what a script can find by its class, with the abscissa to which it belongs; elsewhere,
    /// just draws.
    pub fn part_at(&mut self, class: &str, x: f64, draw: impl FnOnce(&mut Self)) {
        self.group(format!("class=\"{class}\" data-x=\"{x:.1}\""), draw);
    }

    fn group(&mut self, attributes: String, draw: impl FnOnce(&mut Self)) {
        if !self.is_page() {
            return draw(self);
        }
        let extra_attrs = Some(attributes);
        self.scene.add(Primitive::GroupStart { transform: None, title: None, extra_attrs });
        draw(self);
        self.scene.add(Primitive::GroupEnd);
    }

    pub fn unclip(&mut self) {
        self.scene.add(Primitive::ClipEnd);
    }

    /// The drawing as an SVG document, with a text alternative.
    pub fn into_svg(mut self, title: &str, description: &str) -> String {
        self.scene.add(Primitive::GroupEnd);
        let (width, height) = (self.scene.width, self.scene.height);
        let svg = SvgBackend::new().render_scene(&self.scene);
        // The writer's opening tag and generator comment end at the arrow; its closing tag goes too.
        let body = svg.split_once("-->").map_or(svg.as_str(), |(_, body)| body);
        let body = body.trim_end().trim_end_matches("</svg>");
        // What most texts are like is said once.
        let body = body
            .replace(r#" font-size="12" text-anchor="middle""#, "")
            .replace(r#" font-size="12" text-anchor="end""#, r#" text-anchor="end""#);
        let twice = title.is_empty() && self.is_page();
        let document = html! {
            svg xmlns="http://www.w3.org/2000/svg" width=(width) height=(height)
                viewBox={ "0 0 " (width) " " (height) } role="img" aria-label=(printable(if title.is_empty() { description } else { title }))
                font-family=(FONTS) font-size="12" text-anchor="middle" {
                @if !twice { desc { (printable(description)) } }
                (PreEscaped(body))
            }
        };
        document.into_string()
    }

    /// The drawing as a PNG file.
    pub fn into_png(mut self) -> Result<Vec<u8>, Error> {
        self.scene.add(Primitive::GroupEnd);
        let mut pixels = self.rasterised()?;
        for (at, content, lettering) in &self.upright {
            let size = f64::from(lettering.size);
            let base = Point::new((text::width(content, size) / 2.0).ceil() + size, 2.0 * size);
            let mut strip = Self::new(Target::Png, 2.0 * base.x, 3.0 * size);
            strip.text(base, content, lettering);
            strip.scene.add(Primitive::GroupEnd);
            let pixel = |p: &Point| ((p.x * RASTER).round() as i64, (p.y * RASTER).round() as i64);
            pixels.print_upright(&strip.rasterised()?, pixel(&base), pixel(at));
        }
        let png = pixels.shrunk(OVERSAMPLING).to_png(PNG_SCALE as f64);
        png.map_err(|e| Error::Png(e.to_string()))
    }

    /// The drawing in pixels, larger than wanted.
    fn rasterised(&self) -> Result<Pixels, Error> {
        let backend = RasterBackend::new().with_scale(RASTER as f32);
        let png = backend.render_scene(&self.scene).map_err(Error::Png)?;
        Pixels::from_png(&png).map_err(|e| Error::Png(e.to_string()))
    }
}

fn paint((r, g, b): Rgb) -> Color {
    Color::Rgb(r, g, b)
}

/// `text` without characters that XML forbids.
fn printable(text: &str) -> String {
    let clean =
        |c: char| if c.is_control() || c == '\u{fffe}' || c == '\u{ffff}' { ' ' } else { c };
    text.chars().map(clean).collect()
}

/// The first corners of a rectangle, clockwise; the fifth is the first again.
fn corners(rect: &Rect, count: usize) -> Vec<Point> {
    let (right, bottom) = (rect.right(), rect.bottom());
    let all = [(rect.x, rect.y), (right, rect.y), (right, bottom), (rect.x, bottom)];
    all.iter().cycle().take(count).map(|(x, y)| Point::new(*x, *y)).collect()
}

/// SVG path data of runs of points, in tenths of px.
fn path(runs: &[Vec<Point>]) -> String {
    let mut d = String::new();
    let tenths = |v: f64| (v * 10.0).round() as i64;
    // Differences of rounded coordinates, so that rounding does not add up.
    let mut pen = (0, 0);
    for run in runs {
        // The command that goes on without being named again.
        let mut command = ' ';
        for (i, p) in run.iter().enumerate() {
            let (x, y) = (tenths(p.x), tenths(p.y));
            let (right, down) = (x - pen.0, y - pen.1);
            let next = match (i, right, down) {
                (0, ..) => 'm',
                (_, _, 0) => 'h',
                (_, 0, _) => 'v',
                _ => 'l',
            };
            let mut separate = command == next;
            if !separate {
                // The first move of a path is from the corner of the sheet either way.
                d.push(if d.is_empty() { 'M' } else { next });
            }
            if next != 'v' {
                push_tenths(&mut d, right, separate);
                separate = true;
            }
            if next != 'h' {
                push_tenths(&mut d, down, separate);
            }
            (pen, command) = ((x, y), next);
        }
        if run.len() == 1 {
            d.push_str("h0");
        }
    }
    d
}

/// Appends a number of tenths in as few characters as SVG allows.
fn push_tenths(d: &mut String, tenths: i64, separate: bool) {
    if tenths < 0 {
        d.push('-');
    } else if separate {
        d.push(' ');
    }
    let (whole, tenth) = (tenths.abs() / 10, tenths.abs() % 10);
    // Writing to a string cannot fail.
    let _ = match (whole, tenth) {
        (_, 0) => write!(d, "{whole}"),
        (0, _) => write!(d, ".{tenth}"),
        _ => write!(d, "{whole}.{tenth}"),
    };
}

/// Cuts a run of joined points into the strokes of a dash pattern.
fn dashes(run: &[Point], pattern: Dash) -> Vec<Vec<Point>> {
    if pattern.is_empty() || run.len() < 2 {
        return vec![run.to_vec()];
    }
    let mut strokes = Vec::new();
    let mut stroke = vec![run[0]];
    let (mut index, mut left) = (0, pattern[0]);
    for pair in run.windows(2) {
        let length = pair[0].distance(pair[1]);
        let direction = pair[0].direction(pair[1]);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let p = pair[0].along(direction, done);
            if index % 2 == 0 {
                stroke.push(p);
                strokes.push(std::mem::take(&mut stroke));
            } else {
                stroke = vec![p];
            }
            index += 1;
            left = pattern[index % pattern.len()];
        }
        left -= length - done;
        if index % 2 == 0 {
            stroke.push(pair[1]);
        }
    }
    if stroke.len() > 1 {
        strokes.push(stroke);
    }
    strokes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_short_and_exact() {
        let run = vec![Point::new(1.0, 2.04), Point::new(1.5, -0.31), Point::new(1.5, 10.0)];
        assert_eq!(path(&[run]), "M1 2l.5-2.3v10.3");
        let dots = [vec![Point::new(3.0, 4.0)], vec![Point::new(3.5, 2.0)]];
        assert_eq!(path(&dots), "M3 4h0m.5-2h0");
    }

    #[test]
    fn dashes_run_on_around_corners() {
        let corner = [Point::new(0.0, 0.0), Point::new(4.0, 0.0), Point::new(4.0, 10.0)];
        let strokes = dashes(&corner, &[6.0, 5.0]);
        assert_eq!(strokes.len(), 2);
        assert_eq!(strokes[0], [corner[0], corner[1], Point::new(4.0, 2.0)]);
        assert_eq!(strokes[1], [Point::new(4.0, 7.0), corner[2]]);
    }
}
