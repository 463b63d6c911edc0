//! A map of a quantity over the plane in colours, with a colour bar.

use super::axis::{self, Axis};
use super::canvas::{Anchor, Canvas, Lettering};
use super::curve::edges;
use super::geometry::{Point, Rect};
use super::layout::{GAP, LABEL, TICK, TICK_LABEL, View};
use super::paint::{FRAME, MIDDLE, lettering};
use super::palette::{EMPTY, Rgb, STEPS, UNKNOWN, shade};
use super::{Scale, drawable, text};

/// A quantity over the plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Heat {
    /// Quantity and unit, such as `period (s)`.
    pub label: String,
    /// Centres of the columns, ascending. Each column extends halfway to its neighbours.
    pub x: Vec<f64>,
    /// Centres of the rows, ascending.
    pub y: Vec<f64>,
    /// The tiles, row by row, beginning with the smallest `y`.
    pub tiles: Vec<Tile>,
    /// The scale of the colours, [`Scale::Linear`] or [`Scale::Log`].
    pub scale: Scale,
    /// The meaning of an empty tile.
    pub empty: String,
    /// The meaning of an unknown tile.
    pub unknown: String,
}

/// The content of a tile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tile {
    /// The value.
    Value(f64),
    /// There is no value.
    Empty,
    /// The value is unknown.
    Unknown,
}

/// Between frame and bar, px.
const ASIDE: f64 = 14.0;
/// Width of the bar, px.
const BAR: f64 = 14.0;
/// Side of the key of a tile without value, px.
const KEY: f64 = 10.0;
/// Distance between the lines of the keys, px.
const KEY_LINE: f64 = 17.0;

impl Heat {
    pub(super) fn check(&self) -> Result<(), String> {
        for (axis, values) in [("x", &self.x), ("y", &self.y)] {
            if values.is_empty() {
                return Err(format!("has no {axis} values"));
            }
            if let Some(value) = values.iter().find(|v| !drawable(**v)) {
                return Err(format!("has the {axis} value {value}, which cannot be drawn"));
            }
            if let Some(pair) = values.windows(2).find(|pair| !(pair[0] < pair[1])) {
                return Err(format!(
                    "has {axis} values that must ascend, but {} comes after {}",
                    pair[1], pair[0]
                ));
            }
            let (low, high) = ends(values);
            if axis::is_constant(low, high) {
                return Err(format!("has {axis} values too close to each other"));
            }
        }
        let (wanted, found) = (self.x.len() * self.y.len(), self.tiles.len());
        if wanted != found {
            return Err(format!("needs {wanted} tiles, but has {found}"));
        }
        let placed = |v: f64| drawable(v) && (self.scale != Scale::Log || v > 0.0);
        match self.values().find(|v| !placed(*v)) {
            Some(value) => Err(format!(
                "has the value {value}, but values must be finite, and above zero on a logarithmic scale"
            )),
            None => Ok(()),
        }
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        self.tiles.iter().filter_map(|tile| match tile {
            Tile::Value(value) => Some(*value),
            _ => None,
        })
    }

    /// The scale of the colours; `None` if there is no value.
    fn axis(&self, height: f64) -> Option<Axis> {
        let (low, high) = axis::extent(self.values());
        (low <= high).then(|| {
            let (low, high) = match self.scale {
                Scale::Log if !axis::is_constant(low, high) => (low, high),
                Scale::Log => (0.9 * low, 1.1 * high),
                _ => axis::widened((low, high), 0.0),
            };
            Axis::new((low, high), (height / 26.0).clamp(2.0, 9.0) as usize, self.scale)
        })
    }

    pub(super) fn x_ends(&self) -> (f64, f64) {
        ends(&self.x)
    }

    pub(super) fn y_ends(&self) -> (f64, f64) {
        ends(&self.y)
    }

    /// Meanings and colours of tiles without value, if there are any.
    fn keys(&self) -> Vec<(&str, Rgb)> {
        [(Tile::Empty, &self.empty, EMPTY), (Tile::Unknown, &self.unknown, UNKNOWN)]
            .into_iter()
            .filter(|(tile, ..)| self.tiles.contains(tile))
            .map(|(_, name, colour)| (name.as_str(), colour))
            .collect()
    }

    /// Width of the area to the right of the frame.
    pub(super) fn room(&self) -> f64 {
        let small = f64::from(TICK_LABEL);
        let widest = |axis: &Axis| {
            axis.ticks.iter().map(|t| text::width(&t.label, small)).fold(0.0, f64::max)
        };
        // The height is not known yet. The largest number of ticks has the widest labels.
        let bar = self.axis(f64::INFINITY).map_or(0.0, |axis| {
            let note = text::width(&axis.note, small);
            (BAR + TICK + GAP + widest(&axis) + 2.0 * GAP + f64::from(LABEL)).max(note)
        });
        let key = |(name, _): &(&str, Rgb)| KEY + GAP + text::width(name, small);
        ASIDE + self.keys().iter().map(key).fold(bar, f64::max) + GAP
    }

    /// Paints the map.
    pub(super) fn paint_tiles(&self, canvas: &mut Canvas<'_>, view: &View) {
        let axis = self.axis(view.frame.h);
        let colour = |tile: &Tile| match (tile, &axis) {
            (Tile::Value(value), Some(axis)) => shade(axis.fraction(*value)),
            (Tile::Unknown, _) => UNKNOWN,
            _ => EMPTY,
        };
        let (columns, rows) = (edges(&self.x), edges(&self.y));
        let mut tiles: Vec<(Rect, Rgb)> = vec![];
        for (row, (low, high)) in self.tiles.chunks(columns.len()).zip(rows) {
            let colours: Vec<Rgb> = row.iter().map(colour).collect();
            let mut first = 0;
            for run in colours.chunk_by(|a, b| a == b) {
                let last = first + run.len() - 1;
                let a = view.place((columns[first].0, high));
                let b = view.place((columns[last].1, low));
                tiles.push((Rect::new(a.x, a.y, b.x - a.x, b.y - a.y), run[0]));
                first = last + 1;
            }
        }
        canvas.clip(&view.frame);
        canvas.tiles(&tiles);
        canvas.unclip();
    }

    /// Paints the bar and the keys, to the right of the frame.
    pub(super) fn paint_key(&self, canvas: &mut Canvas<'_>, frame: &Rect) {
        let small = f64::from(TICK_LABEL);
        let left = frame.right() + ASIDE;
        let keys = self.keys();
        for (i, (name, colour)) in keys.iter().rev().enumerate() {
            let bottom = frame.bottom() - i as f64 * KEY_LINE;
            let square = Rect::new(left, bottom - KEY, KEY, KEY);
            canvas.fill(&square, *colour, 1.0);
            canvas.outline(&square, &FRAME);
            let at = Point::new(left + KEY + GAP, square.centre().y + MIDDLE * small);
            canvas.text(at, name, &lettering(TICK_LABEL, Anchor::Start));
        }
        let below = if keys.is_empty() { 0.0 } else { keys.len() as f64 * KEY_LINE + GAP };
        let bar = Rect::new(left, frame.y, BAR, (frame.h - below).max(40.0));
        let Some(axis) = self.axis(bar.h) else { return };
        let shades: Vec<(Rect, Rgb)> = (0..=STEPS)
            .map(|k| {
                // A value has the nearest shade, so that the first and the last are half as high.
                let fraction = |k: f64| (k / STEPS as f64).clamp(0.0, 1.0);
                let at = |k: f64| bar.bottom() - bar.h * fraction(k);
                let k = k as f64;
                let (top, bottom) = (at(k + 0.5), at(k - 0.5));
                (Rect::new(bar.x, top, bar.w, bottom - top), shade(fraction(k)))
            })
            .collect();
        canvas.tiles(&shades);
        canvas.outline(&bar, &FRAME);
        let mut widest: f64 = 0.0;
        for tick in &axis.ticks {
            let y = bar.bottom() - bar.h * axis.fraction(tick.at);
            canvas.line(Point::new(bar.right(), y), Point::new(bar.right() + TICK, y), &FRAME);
            let at = Point::new(bar.right() + TICK + GAP, y + MIDDLE * small);
            canvas.text(at, &tick.label, &lettering(TICK_LABEL, Anchor::Start));
            widest = widest.max(text::width(&tick.label, small));
        }
        if !axis.note.is_empty() {
            let at = Point::new(bar.x, bar.y - GAP - 1.0);
            canvas.text(at, &axis.note, &lettering(TICK_LABEL, Anchor::Start));
        }
        let x = bar.right() + TICK + GAP + widest + GAP + f64::from(LABEL);
        let upright = Lettering { upright: true, ..lettering(LABEL, Anchor::Middle) };
        canvas.text(Point::new(x, bar.centre().y), &self.label, &upright);
    }
}

/// Edges of tiles with these centres.
fn ends(values: &[f64]) -> (f64, f64) {
    let edges = edges(values);
    (edges[0].0, edges[edges.len() - 1].1)
}
