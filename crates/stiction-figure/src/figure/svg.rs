//! Drawings as SVG text: small, scaling, with a text alternative.
//!
//! * Paths are written in tenths of px, relatively, at half the size. On a page that does not zoom, long ones are scaled,
//!   so that they need no decimal points.
//! * Clip paths are named after their geometry. So names are the same in every run, and two pictures in one HTML
//!   document cannot conflict.
//! * What most texts have in common is stated once, by the document; the font, by the style of the page.
//! * On a live page, parts that move or are replaced when a reader zooms are grouped and named.

use std::fmt::Write;

use maud::{PreEscaped, html};

use super::canvas::{Anchor, Lettering, Stroke, Surface, corners};
use super::geometry::{Point, Rect};
use super::palette::{INK, Rgb};
use super::text;

/// Fonts in order of preference. The layout reserves room for the widest, the first.
/// The fonts of a drawing in a file of its own.
pub const FONTS: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";
/// The attribute of paths in tenths of px.
const SCALED: &str = r#" transform="scale(.1)""#;
/// The size of most texts.
const SIZE: u32 = 12;

/// Place where a drawing is shown. On a page, its name is the prefix of the names of its clip paths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place<'a> {
    /// In a separate file.
    File,
    /// On a page, for reading.
    Still(&'a str),
    /// On a page whose script finds its parts.
    Live(&'a str),
}

/// The id of the caption of a picture on a page.
pub(super) fn caption_id(page: &str) -> String {
    format!("{page}-caption")
}

/// A drawing as SVG text.
pub(super) struct Svg<'a> {
    width: f64,
    height: f64,
    place: Place<'a>,
    clips: String,
    body: String,
}

impl<'a> Svg<'a> {
    pub fn new(width: f64, height: f64, place: Place<'a>) -> Self {
        Self { width, height, place, clips: String::new(), body: String::new() }
    }

    /// The drawing as a document, with a text alternative.
    pub fn into_document(self, title: &str, description: &str) -> String {
        let (width, height) = (self.width, self.height);
        let twice = title.is_empty() && self.place != Place::File;
        let name = text::printable(if title.is_empty() { description } else { title });
        // On a page, the caption stands below.
        let (label, caption) = match self.place {
            Place::Still(page) | Place::Live(page) if title.is_empty() => {
                (None, Some(caption_id(page)))
            }
            _ => (Some(name), None),
        };
        let document = html! {
            svg xmlns="http://www.w3.org/2000/svg" width=(width) height=(height)
                viewBox={ "0 0 " (width) " " (height) } role="img" aria-label=[label] aria-labelledby=[caption]
                font-family=[(self.place == Place::File).then_some(FONTS)] font-size=(SIZE) text-anchor="middle"
                fill=(hex(INK)) {
                @if !twice { desc { (text::printable(description)) } }
                (PreEscaped("<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\" />"))
                @if !self.clips.is_empty() { defs { (PreEscaped(self.clips)) } }
                g stroke-linejoin="round" stroke-linecap="round" { (PreEscaped(self.body)) }
            }
        };
        document.into_string()
    }

    /// Appends to the body.
    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.body.write_fmt(text);
    }

    fn put_escaped(&mut self, text: &str) {
        for c in text.chars() {
            match c {
                '&' => self.body.push_str("&amp;"),
                '<' => self.body.push_str("&lt;"),
                '>' => self.body.push_str("&gt;"),
                '"' => self.body.push_str("&quot;"),
                '\'' => self.body.push_str("&apos;"),
                c => self.body.push(c),
            }
        }
    }

    /// Path data with its scale: of a still picture in tenths of px, if that is shorter. When a live figure zooms, its
    /// strokes keep their width. The strokes of scaled path data would not.
    fn scaled(&self, runs: &[Vec<Point>]) -> (String, f64) {
        let d = path(runs, Digits::Tenths);
        if matches!(self.place, Place::Still(_)) {
            let whole = path(runs, Digits::Whole);
            if whole.len() + SCALED.len() < d.len() {
                return (whole, 10.0);
            }
        }
        (d, 1.0)
    }

    fn filled(&mut self, outlines: &[Vec<Point>], end: &str, colour: Rgb, opacity: Option<f64>) {
        let (path, scale) = self.scaled(outlines);
        let fill = hex(colour);
        self.put(format_args!(r#"<path d="{path}{end}" fill="{fill}""#));
        if scale > 1.0 {
            self.body.push_str(SCALED);
        }
        if let Some(opacity) = opacity {
            self.put(format_args!(r#" fill-opacity="{}""#, hundredths(opacity)));
        }
        self.body.push_str(" />");
    }
}

impl Surface for Svg<'_> {
    fn is_page(&self) -> bool {
        matches!(self.place, Place::Live(_))
    }

    fn lines(&mut self, runs: &[Vec<Point>], stroke: &Stroke) {
        let (d, scale) = self.scaled(runs);
        let (colour, width) = (hex(stroke.colour), hundredths(scale * stroke.width));
        self.put(format_args!(
            r#"<path d="{d}" stroke="{colour}" stroke-width="{width}" fill="none""#
        ));
        if scale > 1.0 {
            self.body.push_str(SCALED);
        }
        if !stroke.dash.is_empty() {
            let dash: Vec<String> = stroke.dash.iter().map(|v| (scale * v).to_string()).collect();
            self.put(format_args!(r#" stroke-dasharray="{}""#, dash.join(" ")));
        }
        self.body.push_str(" />");
    }

    fn polygon(&mut self, corners: &[Point], colour: Rgb) {
        self.filled(&[corners.to_vec()], "z", colour, None);
    }

    fn polygons(&mut self, outlines: &[Vec<Point>], colour: Rgb, opacity: f64) {
        self.filled(outlines, "", colour, Some(opacity));
    }

    fn tiles(&mut self, tiles: &[Rect], colour: Rgb) {
        // Overlap that prevents the background from showing between two of them, px.
        const OVERLAP: f64 = 0.1;
        let outlines: Vec<Vec<Point>> =
            tiles.iter().map(|tile| corners(&tile.grown(OVERLAP), 4)).collect();
        self.filled(&outlines, "", colour, None);
    }

    fn rect(&mut self, rect: &Rect, colour: Rgb, opacity: f64) {
        let [x, y, w, h] = [rect.x, rect.y, rect.w, rect.h].map(hundredths);
        let (fill, opacity) = (hex(colour), hundredths(opacity));
        self.put(format_args!(
            r#"<rect x="{x}" y="{y}" width="{w}" height="{h}" fill="{fill}" fill-opacity="{opacity}" />"#
        ));
    }

    fn text(&mut self, at: Point, content: &str, lettering: &Lettering) {
        let (x, y) = (hundredths(at.x), hundredths(at.y));
        let anchor = match lettering.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.put(format_args!(r#"<text x="{x}" y="{y}""#));
        if lettering.size != SIZE {
            self.put(format_args!(r#" font-size="{}""#, lettering.size));
        }
        if lettering.anchor != Anchor::Middle {
            self.put(format_args!(r#" text-anchor="{anchor}""#));
        }
        if lettering.colour != INK {
            self.put(format_args!(r#" fill="{}""#, hex(lettering.colour)));
        }
        if lettering.upright {
            self.put(format_args!(r#" transform="rotate(-90,{x},{y})""#));
        }
        self.body.push('>');
        let (before, after) =
            if lettering.bold { (r#"<tspan font-weight="bold">"#, "</tspan>") } else { ("", "") };
        self.body.push_str(before);
        self.put_escaped(content);
        self.body.push_str(after);
        self.body.push_str("</text>");
    }

    fn clip(&mut self, rect: &Rect) {
        let [x, y, w, h] = [rect.x, rect.y, rect.w, rect.h].map(tenths);
        let owner = match self.place {
            Place::File => "clip-".to_owned(),
            Place::Still(page) | Place::Live(page) => format!("{page}-"),
        };
        let id = format!("{owner}{x}-{y}-{w}-{h}");
        let definition = format!(
            r#"<clipPath id="{id}"><rect x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}"/></clipPath>"#,
            rect.x, rect.y, rect.w, rect.h
        );
        if !self.clips.contains(&definition) {
            self.clips.push_str(&definition);
        }
        self.put(format_args!(r##"<g clip-path="url(#{id})">"##));
    }

    fn unclip(&mut self) {
        self.body.push_str("</g>");
    }

    fn begin(&mut self, attributes: &str) {
        if self.is_page() {
            self.put(format_args!("<g {attributes}>"));
        }
    }

    fn end(&mut self) {
        if self.is_page() {
            self.body.push_str("</g>");
        }
    }
}

fn hex((r, g, b): Rgb) -> String {
    // Equal pairs of digits are written once.
    match [r, g, b].iter().all(|v| v % 17 == 0) {
        true => format!("#{:x}{:x}{:x}", r / 17, g / 17, b / 17),
        false => format!("#{r:02x}{g:02x}{b:02x}"),
    }
}

/// The number rounded to hundredths, never `-0`.
fn hundredths(v: f64) -> f64 {
    (v * 100.0).round() / 100.0 + 0.0
}

fn tenths(v: f64) -> i64 {
    (v * 10.0).round() as i64
}

/// How numbers of tenths are written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Digits {
    /// In px.
    Tenths,
    /// In tenths of px.
    Whole,
}

/// Path data of runs of points, to tenths of px. Strokes along an axis are joined.
fn path(runs: &[Vec<Point>], digits: Digits) -> String {
    let mut d = String::new();
    // Differences of rounded coordinates, so that rounding does not add up.
    let mut pen = (0, 0);
    for run in runs {
        // The command that continues without being named again.
        let mut command = ' ';
        let places = joined(run);
        for (i, &(x, y)) in places.iter().enumerate() {
            let (right, down) = (x - pen.0, y - pen.1);
            let next = match (i, right, down) {
                (0, ..) => 'm',
                (_, _, 0) => 'h',
                (_, 0, _) => 'v',
                _ => 'l',
            };
            let mut separate = command == next;
            if !separate {
                // The first move of a path starts from the corner of the sheet in both notations.
                d.push(if d.is_empty() { 'M' } else { next });
            }
            if next != 'v' {
                push_tenths(&mut d, right, separate, digits);
                separate = true;
            }
            if next != 'h' {
                push_tenths(&mut d, down, separate, digits);
            }
            (pen, command) = ((x, y), next);
        }
        if places.len() == 1 {
            d.push_str("h0");
        }
    }
    d
}

/// The places of a run in tenths of px, without those that are passed on the way along an axis.
fn joined(run: &[Point]) -> Vec<(i64, i64)> {
    let mut places: Vec<(i64, i64)> = vec![];
    for p in run {
        let next = (tenths(p.x), tenths(p.y));
        match places[..] {
            [.., last] if last == next => continue,
            [.., (a, b), (c, d)] if on_the_way(a, c, next.0) && b == d && d == next.1 => {
                places.pop();
            }
            [.., (a, b), (c, d)] if on_the_way(b, d, next.1) && a == c && c == next.0 => {
                places.pop();
            }
            _ => {}
        }
        places.push(next);
    }
    places
}

fn on_the_way(from: i64, at: i64, to: i64) -> bool {
    (from..=to).contains(&at) || (to..=from).contains(&at)
}

/// Appends a number of tenths in as few characters as SVG allows.
fn push_tenths(d: &mut String, tenths: i64, separate: bool, digits: Digits) {
    if tenths < 0 {
        d.push('-');
    } else if separate {
        d.push(' ');
    }
    let (whole, tenth) = match digits {
        Digits::Tenths => (tenths.abs() / 10, tenths.abs() % 10),
        Digits::Whole => (tenths.abs(), 0),
    };
    // Writing to a string cannot fail.
    let _ = match (whole, tenth) {
        (_, 0) => write!(d, "{whole}"),
        (0, _) => write!(d, ".{tenth}"),
        _ => write!(d, "{whole}.{tenth}"),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_short_and_exact() {
        let run = vec![Point::new(1.0, 2.04), Point::new(1.5, -0.31), Point::new(1.5, 10.0)];
        assert_eq!(path(std::slice::from_ref(&run), Digits::Tenths), "M1 2l.5-2.3v10.3");
        assert_eq!(path(&[run], Digits::Whole), "M10 20l5-23v103");
        let dots = [vec![Point::new(3.0, 4.0)], vec![Point::new(3.5, 2.0)]];
        assert_eq!(path(&dots, Digits::Tenths), "M3 4h0m.5-2h0");
        // Strokes along an axis are joined, but where they turn back.
        let stairs =
            [(0.0, 0.0), (1.0, 0.0), (1.01, 0.0), (3.0, 0.0), (3.0, 2.0), (3.0, 1.0), (3.0, 4.0)];
        let stairs = vec![stairs.map(|(x, y)| Point::new(x, y)).to_vec()];
        assert_eq!(path(&stairs, Digits::Tenths), "M0 0h3v2-1 3");
        let rest = vec![vec![Point::new(1.0, 1.0), Point::new(1.01, 1.02)]];
        assert_eq!(path(&rest, Digits::Tenths), "M1 1h0");
    }

    #[test]
    fn text_is_escaped_and_what_is_usual_is_left_out() {
        let set = |lettering: &Lettering| {
            let mut svg = Svg::new(9.0, 9.0, Place::File);
            svg.text(Point::new(1.5, -0.001), "a<b>&\"'$", lettering);
            svg.body
        };
        let usual = Lettering {
            size: SIZE,
            anchor: Anchor::Middle,
            bold: false,
            upright: false,
            colour: INK,
        };
        let content = "a&lt;b&gt;&amp;&quot;&apos;$";
        assert_eq!(set(&usual), format!(r#"<text x="1.5" y="0">{content}</text>"#));
        let turned = Lettering { size: 9, bold: true, upright: true, ..usual };
        assert_eq!(
            set(&turned),
            format!(
                r#"<text x="1.5" y="0" font-size="9" transform="rotate(-90,1.5,0)"><tspan font-weight="bold">{content}</tspan></text>"#
            )
        );
    }
}
