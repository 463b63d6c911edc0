//! Drawings as SVG text: small, scaling, with a text alternative.
//!
//! * Paths are written in tenths of px, relatively, at half the size.
//! * Clip paths are named after their geometry. So names are the same in every run, and two pictures in one HTML
//!   document cannot conflict.
//! * On a live page, parts that move or are replaced when a reader zooms are grouped and named.

use std::fmt::Write;

use maud::{PreEscaped, html};

use super::canvas::{Anchor, Lettering, Stroke, Surface, corners};
use super::geometry::{Point, Rect};
use super::palette::Rgb;
use super::text;

/// Fonts in order of preference. The layout reserves room for the widest, the first.
const FONTS: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";
/// The size of most texts.
const SIZE: u32 = 12;

/// A drawing as SVG text.
pub(super) struct Svg {
    width: f64,
    height: f64,
    /// On a live page, the prefix of the names of its clip paths.
    page: Option<String>,
    clips: String,
    body: String,
}

impl Svg {
    pub fn new(width: f64, height: f64, page: Option<String>) -> Self {
        Self { width, height, page, clips: String::new(), body: String::new() }
    }

    /// The drawing as a document, with a text alternative.
    pub fn into_document(self, title: &str, description: &str) -> String {
        let (width, height) = (self.width, self.height);
        let twice = title.is_empty() && self.is_page();
        let name = text::printable(if title.is_empty() { description } else { title });
        let document = html! {
            svg xmlns="http://www.w3.org/2000/svg" width=(width) height=(height)
                viewBox={ "0 0 " (width) " " (height) } role="img" aria-label=(name)
                font-family=(FONTS) font-size=(SIZE) text-anchor="middle" {
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

    fn filled(&mut self, path: &str, colour: Rgb, opacity: Option<f64>) {
        let fill = hex(colour);
        self.put(format_args!(r#"<path d="{path}" stroke="none" stroke-width="0" fill="{fill}""#));
        if let Some(opacity) = opacity {
            self.put(format_args!(r#" fill-opacity="{}""#, hundredths(opacity)));
        }
        self.body.push_str(" />");
    }
}

impl Surface for Svg {
    fn is_page(&self) -> bool {
        self.page.is_some()
    }

    fn lines(&mut self, runs: &[Vec<Point>], stroke: &Stroke) {
        let (colour, width) = (hex(stroke.colour), hundredths(stroke.width));
        self.put(format_args!(
            r#"<path d="{}" stroke="{colour}" stroke-width="{width}" fill="none""#,
            path(runs)
        ));
        if !stroke.dash.is_empty() {
            let dash: Vec<String> = stroke.dash.iter().map(f64::to_string).collect();
            self.put(format_args!(r#" stroke-dasharray="{}""#, dash.join(" ")));
        }
        self.body.push_str(" />");
    }

    fn polygon(&mut self, corners: &[Point], colour: Rgb) {
        self.filled(&(path(&[corners.to_vec()]) + "z"), colour, None);
    }

    fn polygons(&mut self, outlines: &[Vec<Point>], colour: Rgb, opacity: f64) {
        self.filled(&path(outlines), colour, Some(opacity));
    }

    fn tiles(&mut self, tiles: &[Rect], colour: Rgb) {
        // Overlap that prevents the background from showing between two of them, px.
        const OVERLAP: f64 = 0.1;
        let outlines: Vec<Vec<Point>> =
            tiles.iter().map(|tile| corners(&tile.grown(OVERLAP), 4)).collect();
        self.filled(&path(&outlines), colour, None);
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
        // The document states the common properties of most texts once.
        let usual = lettering.size == SIZE && lettering.anchor != Anchor::Start;
        if !usual {
            self.put(format_args!(r#" font-size="{}""#, lettering.size));
        }
        if !usual || lettering.anchor != Anchor::Middle {
            self.put(format_args!(r#" text-anchor="{anchor}""#));
        }
        self.put(format_args!(r#" fill="{}""#, hex(lettering.colour)));
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
        let owner = self.page.as_ref().map_or(String::new(), |page| format!("{page}-"));
        let id = format!("{owner}clip-{x}-{y}-{w}-{h}");
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
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The number rounded to hundredths, never `-0`.
fn hundredths(v: f64) -> f64 {
    (v * 100.0).round() * 0.01 + 0.0
}

fn tenths(v: f64) -> i64 {
    (v * 10.0).round() as i64
}

/// Path data of runs of points, in tenths of px.
fn path(runs: &[Vec<Point>]) -> String {
    let mut d = String::new();
    // Differences of rounded coordinates, so that rounding does not add up.
    let mut pen = (0, 0);
    for run in runs {
        // The command that continues without being named again.
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
                // The first move of a path starts from the corner of the sheet in both notations.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::palette::INK;

    #[test]
    fn paths_are_short_and_exact() {
        let run = vec![Point::new(1.0, 2.04), Point::new(1.5, -0.31), Point::new(1.5, 10.0)];
        assert_eq!(path(&[run]), "M1 2l.5-2.3v10.3");
        let dots = [vec![Point::new(3.0, 4.0)], vec![Point::new(3.5, 2.0)]];
        assert_eq!(path(&dots), "M3 4h0m.5-2h0");
    }

    #[test]
    fn text_is_escaped_and_what_is_usual_is_left_out() {
        let set = |lettering: &Lettering| {
            let mut svg = Svg::new(9.0, 9.0, None);
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
        assert_eq!(
            set(&usual),
            format!(r##"<text x="1.5" y="0" fill="#222222">{content}</text>"##)
        );
        let turned = Lettering { size: 9, bold: true, upright: true, ..usual };
        assert_eq!(
            set(&turned),
            format!(
                r##"<text x="1.5" y="0" font-size="9" text-anchor="middle" fill="#222222" transform="rotate(-90,1.5,0)"><tspan font-weight="bold">{content}</tspan></text>"##
            )
        );
    }
}
