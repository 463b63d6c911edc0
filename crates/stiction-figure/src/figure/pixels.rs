//! Drawings as pixels, and as PNG files.

use std::ops::Range;

use super::canvas::{Anchor, Lettering, Stroke, Surface, corners};
use super::coverage::Coverage;
use super::font;
use super::geometry::{Point, Rect};
use super::palette::{Dash, Rgb};
use crate::error::Error;

/// Pixels per px.
const SCALE: f64 = 2.0;
/// CSS px per metre, from 96 per inch.
const PX_PER_METRE: f64 = 96.0 / 0.0254;

/// An opaque drawing, white at first.
pub(super) struct Pixels {
    width: usize,
    height: usize,
    /// Three bytes per pixel, row by row.
    rgb: Vec<u8>,
    /// The clip rectangles, in pixels. The last one applies.
    clips: Vec<Rect>,
}

impl Pixels {
    pub fn new(width: f64, height: f64) -> Self {
        let (width, height) = ((width * SCALE).ceil() as usize, (height * SCALE).ceil() as usize);
        let sheet = Rect::new(0.0, 0.0, width as f64, height as f64);
        Self { width, height, rgb: vec![255; 3 * width * height], clips: vec![sheet] }
    }

    /// The drawing as a PNG file.
    pub fn into_png(self) -> Result<Vec<u8>, Error> {
        self.encoded().map_err(|e| Error::Png(e.to_string()))
    }

    fn encoded(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.add_text_chunk("Software".to_owned(), "stiction".to_owned())?;
        let per_metre = (SCALE * PX_PER_METRE).round() as u32;
        encoder.set_pixel_dims(Some(png::PixelDimensions {
            xppu: per_metre,
            yppu: per_metre,
            unit: png::Unit::Meter,
        }));
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()?;
        Ok(bytes)
    }

    fn clipped(&self) -> Rect {
        self.clips.last().copied().unwrap_or(Rect::new(0.0, 0.0, 0.0, 0.0))
    }

    /// The pixels that the clip covers at least partly.
    fn window(&self) -> (Range<usize>, Range<usize>) {
        let clip = self.clipped();
        let between = |from: f64, to: f64, count: usize| {
            from.floor() as usize..(to.ceil() as usize).min(count)
        };
        (between(clip.x, clip.right(), self.width), between(clip.y, clip.bottom(), self.height))
    }

    /// Fills polygons that are given in pixels.
    fn fill(&mut self, outlines: &[Vec<Point>], colour: Rgb, opacity: f64) {
        let (columns, rows) = self.window();
        self.print(&Coverage::of_polygons(outlines, columns, rows), colour, opacity);
    }

    /// Applies a colour to the covered pixels.
    fn print(&mut self, coverage: &Coverage, (r, g, b): Rgb, opacity: f64) {
        let clip = self.clipped();
        // How much of a pixel lies within the clip.
        let share = |from: f64, to: f64, pixel: usize| {
            let pixel = pixel as f64;
            (to.min(pixel + 1.0) - from.max(pixel)).clamp(0.0, 1.0)
        };
        let columns = coverage.columns.clone();
        let across: Vec<f32> =
            columns.clone().map(|column| share(clip.x, clip.right(), column) as f32).collect();
        for row in coverage.rows.clone() {
            let down = (opacity * share(clip.y, clip.bottom(), row)) as f32;
            let start = 3 * (row * self.width + columns.start);
            let pixels = self.rgb[start..].chunks_exact_mut(3);
            for ((pixel, covered), across) in pixels.zip(coverage.row(row)).zip(&across) {
                let part = covered * across * down;
                if part > 0.0 {
                    for (old, new) in pixel.iter_mut().zip([r, g, b]) {
                        let (from, to) = (f32::from(*old), f32::from(new));
                        *old = (from + part * (to - from)).round() as u8;
                    }
                }
            }
        }
    }
}

impl Surface for Pixels {
    fn lines(&mut self, runs: &[Vec<Point>], stroke: &Stroke) {
        let strokes: Vec<Vec<Point>> =
            runs.iter().flat_map(|run| dashes(run, stroke.dash)).map(|run| scaled(&run)).collect();
        let (columns, rows) = self.window();
        let radius = SCALE * stroke.width / 2.0;
        let coverage = Coverage::of_lines(&strokes, radius, columns, rows);
        self.print(&coverage, stroke.colour, 1.0);
    }

    fn polygon(&mut self, corners: &[Point], colour: Rgb) {
        self.fill(&[scaled(corners)], colour, 1.0);
    }

    fn polygons(&mut self, outlines: &[Vec<Point>], colour: Rgb, opacity: f64) {
        let outlines: Vec<Vec<Point>> = outlines.iter().map(|outline| scaled(outline)).collect();
        self.fill(&outlines, colour, opacity);
    }

    fn tiles(&mut self, tiles: &[Rect], colour: Rgb) {
        // The background would show where two of them share a pixel.
        let whole = |p: Point| Point::new(p.x.round(), p.y.round());
        let outline = |tile| scaled(&corners(tile, 4)).into_iter().map(whole).collect();
        self.fill(&tiles.iter().map(outline).collect::<Vec<_>>(), colour, 1.0);
    }

    fn rect(&mut self, rect: &Rect, colour: Rgb, opacity: f64) {
        self.fill(&[scaled(&corners(rect, 4))], colour, opacity);
    }

    fn text(&mut self, at: Point, content: &str, lettering: &Lettering) {
        let mut outlines = Vec::new();
        let width = font::set(content, lettering.bold, &mut |line| outlines.push(line));
        let start = match lettering.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -width / 2.0,
            Anchor::End => -width,
        };
        let size = SCALE * f64::from(lettering.size);
        let (x, y) = (SCALE * at.x, SCALE * at.y);
        for p in outlines.iter_mut().flatten() {
            let (along, below) = ((start + p.x) * size, p.y * size);
            // Letters are sharp on a base line between two rows of pixels.
            *p = if lettering.upright {
                Point::new(x.round() + below, y - along)
            } else {
                Point::new(x + along, y.round() + below)
            };
        }
        self.fill(&outlines, lettering.colour, 1.0);
    }

    fn clip(&mut self, rect: &Rect) {
        let outer = self.clipped();
        let (x, y) = ((SCALE * rect.x).max(outer.x), (SCALE * rect.y).max(outer.y));
        let right = (SCALE * rect.right()).min(outer.right());
        let bottom = (SCALE * rect.bottom()).min(outer.bottom());
        self.clips.push(Rect::new(x, y, (right - x).max(0.0), (bottom - y).max(0.0)));
    }

    fn unclip(&mut self) {
        self.clips.pop();
    }
}

/// From px to pixels.
fn scaled(points: &[Point]) -> Vec<Point> {
    points.iter().map(|p| Point::new(SCALE * p.x, SCALE * p.y)).collect()
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
    use crate::figure::palette::INK;

    const BLACK: Rgb = (0, 0, 0);

    fn at(pixels: &Pixels, column: usize, row: usize) -> Rgb {
        let start = 3 * (row * pixels.width + column);
        (pixels.rgb[start], pixels.rgb[start + 1], pixels.rgb[start + 2])
    }

    /// First and last column, then first and last row, that have ink.
    fn ink(pixels: &Pixels) -> [usize; 4] {
        let inked = |column: usize, row: usize| at(pixels, column, row) != (255, 255, 255);
        let columns: Vec<usize> = (0..pixels.width)
            .filter(|column| (0..pixels.height).any(|row| inked(*column, row)))
            .collect();
        let rows: Vec<usize> = (0..pixels.height)
            .filter(|row| (0..pixels.width).any(|column| inked(column, *row)))
            .collect();
        [columns[0], columns[columns.len() - 1], rows[0], rows[rows.len() - 1]]
    }

    fn lettering(anchor: Anchor, upright: bool) -> Lettering {
        Lettering { size: 10, anchor, bold: false, upright, colour: INK }
    }

    #[test]
    fn dashes_run_on_around_corners() {
        let corner = [Point::new(0.0, 0.0), Point::new(4.0, 0.0), Point::new(4.0, 10.0)];
        let strokes = dashes(&corner, &[6.0, 5.0]);
        assert_eq!(strokes.len(), 2);
        assert_eq!(strokes[0], [corner[0], corner[1], Point::new(4.0, 2.0)]);
        assert_eq!(strokes[1], [Point::new(4.0, 7.0), corner[2]]);
    }

    #[test]
    fn lines_have_their_colour_where_they_are() {
        let mut pixels = Pixels::new(20.0, 10.0);
        assert_eq!((pixels.width, pixels.height), (40, 20));
        let red = (200, 0, 0);
        let line = vec![Point::new(2.0, 5.0), Point::new(18.0, 5.0)];
        pixels.lines(&[line], &Stroke { colour: red, width: 2.0, dash: &[] });
        assert_eq!([at(&pixels, 20, 8), at(&pixels, 20, 11)], [red, red]);
        // Ends are round.
        assert_eq!(ink(&pixels), [2, 37, 8, 11]);
        assert_eq!(at(&pixels, 2, 7), (255, 255, 255));
        pixels.lines(
            &[vec![], vec![Point::new(5.0, 1.0)]],
            &Stroke { colour: BLACK, width: 2.0, dash: &[] },
        );
        assert_eq!(at(&pixels, 10, 2), BLACK);
    }

    #[test]
    fn what_is_transparent_or_clipped_is_mixed() {
        let mut pixels = Pixels::new(10.0, 10.0);
        pixels.clip(&Rect::new(0.0, 0.0, 5.25, 5.0));
        pixels.clip(&Rect::new(-3.0, 2.0, 30.0, 30.0));
        pixels.rect(&Rect::new(0.0, 0.0, 10.0, 10.0), BLACK, 0.6);
        pixels.unclip();
        pixels.unclip();
        assert_eq!(ink(&pixels), [0, 10, 4, 9]);
        assert_eq!((at(&pixels, 0, 4), at(&pixels, 10, 4)), ((102, 102, 102), (179, 179, 179)));
        pixels.clip(&Rect::new(20.0, 20.0, 5.0, -1.0));
        pixels.rect(&Rect::new(0.0, 0.0, 10.0, 10.0), BLACK, 1.0);
        assert_eq!(ink(&pixels), [0, 10, 4, 9]);
    }

    #[test]
    fn tiles_meet_without_a_seam() {
        let mut pixels = Pixels::new(10.0, 10.0);
        let halves = [Rect::new(0.0, 0.0, 4.2, 10.0), Rect::new(4.2, 0.0, 5.8, 10.0)];
        pixels.tiles(&halves[..1], (10, 0, 0));
        pixels.tiles(&halves[1..], (20, 0, 0));
        assert!((0..20).all(|column| at(&pixels, column, 3).1 == 0));
    }

    #[test]
    fn text_stands_at_its_point() {
        let set = |anchor, upright| {
            let mut pixels = Pixels::new(100.0, 100.0);
            pixels.text(Point::new(50.0, 50.0), "HHH", &lettering(anchor, upright));
            ink(&pixels)
        };
        // Three letters of 0.752 em each, 0.729 em high, on a base line between two rows.
        let [left, right, top, bottom] = set(Anchor::Middle, false);
        assert!(left.abs_diff(100 - 22) <= 2 && right.abs_diff(100 + 22) <= 2, "{left} {right}");
        assert_eq!((top, bottom), (100 - 15, 99));
        let [start, ..] = set(Anchor::Start, false);
        let [_, end, ..] = set(Anchor::End, false);
        assert!(start.abs_diff(102) <= 1 && end.abs_diff(98) <= 1, "{start} {end}");
        // The same, read upwards.
        let [left, right, top, bottom] = set(Anchor::Middle, true);
        assert_eq!((left, right), (100 - 15, 99));
        assert!(top.abs_diff(100 - 22) <= 2 && bottom.abs_diff(100 + 22) <= 2, "{top} {bottom}");
        let [.., bottom] = set(Anchor::Start, true);
        assert!(bottom.abs_diff(98) <= 1, "{bottom}");
    }
}
