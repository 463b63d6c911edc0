//! The content of a panel's legend, and its position.

use super::annotate::Mark;
use super::curve::Curve;
use super::geometry::{Point, Rect};
use super::{Legend, Panel, text};

/// Font size, px.
pub(super) const SIZE: u32 = 12;
/// Length of the sample of a line, px.
pub(super) const KEY: f64 = 30.0;
/// Room between sample and label.
pub(super) const KEY_GAP: f64 = 6.0;

const LINE: f64 = SIZE as f64 * 1.3;
/// Between the box and its content.
const PAD: f64 = 5.0;
/// Between the box and the frame.
const MARGIN: f64 = 7.0;
/// Between entries side by side.
const GAP: f64 = 20.0;

/// A legend, placed.
pub(super) struct Placed {
    pub entries: Vec<Entry>,
    /// Upper left corner and size; relative to the corner of the frame.
    pub rect: Rect,
    pub inside: bool,
}

/// One line of the legend.
pub(super) struct Entry {
    /// Index of the series.
    pub series: usize,
    /// Upper left corner, relative to the legend's corner.
    pub at: Point,
    pub lines: Vec<String>,
}

impl Placed {
    /// Height that the legend needs above the frame.
    pub fn head(&self) -> f64 {
        if self.inside { 0.0 } else { self.rect.h }
    }
}

/// The legend of `panel`, if it has one.
pub(super) fn place(
    panel: &Panel,
    frame: &Rect,
    curves: &[Curve],
    marks: &[Mark],
) -> Option<Placed> {
    let named = panel.series.iter().filter(|s| !s.label.trim().is_empty()).count();
    let fewest = if panel.legend == Legend::Auto { 2 } else { 1 };
    if panel.legend == Legend::Hidden || named < fewest {
        return None;
    }
    let column = column(panel, 0.5 * frame.w);
    let corner = |legend: Legend| {
        let (w, h) = (column.rect.w, column.rect.h);
        let left = MARGIN;
        let right = frame.w - w - MARGIN;
        let (top, bottom) = (MARGIN, frame.h - h - MARGIN);
        match legend {
            Legend::TopLeft => Some(Rect::new(left, top, w, h)),
            Legend::TopRight => Some(Rect::new(right, top, w, h)),
            Legend::BottomLeft => Some(Rect::new(left, bottom, w, h)),
            Legend::BottomRight => Some(Rect::new(right, bottom, w, h)),
            _ => None,
        }
    };
    let free = |rect: &Rect| {
        let fits = rect.w + 2.0 * MARGIN < frame.w && rect.h + 2.0 * MARGIN < frame.h;
        let there = Rect { x: rect.x + frame.x, y: rect.y + frame.y, ..*rect }.grown(3.0);
        fits && !curves.iter().any(|c| c.touches(&there))
            && !marks.iter().any(|m| m.touches(&there))
    };
    let rect = match panel.legend {
        Legend::Auto => {
            [Legend::TopRight, Legend::TopLeft, Legend::BottomRight, Legend::BottomLeft]
                .into_iter()
                .filter_map(corner)
                .find(free)
        }
        chosen => corner(chosen),
    };
    Some(match rect {
        Some(rect) => Placed { rect, ..column },
        None => rows(panel, frame.w),
    })
}

/// Entries below each other, in a box.
fn column(panel: &Panel, room: f64) -> Placed {
    let mut entries = Vec::new();
    let (mut y, mut width) = (PAD, 0.0_f64);
    for (series, lines) in labels(panel, room) {
        width = width.max(lines_width(&lines));
        let height = lines.len() as f64 * LINE;
        entries.push(Entry { series, at: Point::new(PAD, y), lines });
        y += height;
    }
    let rect = Rect::new(0.0, 0.0, width + KEY + KEY_GAP + 2.0 * PAD, y + PAD);
    Placed { entries, rect, inside: true }
}

/// Entries side by side above the frame, in as many rows as it takes.
fn rows(panel: &Panel, width: f64) -> Placed {
    let mut entries = Vec::new();
    let (mut x, mut y, mut height) = (0.0, 0.0, 0.0_f64);
    for (series, lines) in labels(panel, width - KEY - KEY_GAP) {
        let own = KEY + KEY_GAP + lines_width(&lines);
        if x > 0.0 && x + own > width {
            (x, y, height) = (0.0, y + height, 0.0);
        }
        height = height.max(lines.len() as f64 * LINE);
        entries.push(Entry { series, at: Point::new(x, y), lines });
        x += own + GAP;
    }
    let h = y + height + PAD;
    Placed { entries, rect: Rect::new(0.0, -h, width, h), inside: false }
}

fn labels(panel: &Panel, room: f64) -> impl Iterator<Item = (usize, Vec<String>)> {
    let wrapped =
        move |label: &str| text::wrap(label, f64::from(SIZE), room.max(8.0 * f64::from(SIZE)));
    let lines = panel.series.iter().map(move |s| wrapped(&s.label));
    lines.enumerate().filter(|(_, lines)| !lines.is_empty())
}

fn lines_width(lines: &[String]) -> f64 {
    lines.iter().map(|line| text::width(line, f64::from(SIZE))).fold(0.0, f64::max)
}

/// Distance of the base line of an entry's first line from its upper edge.
pub(super) const BASE: f64 = LINE * 0.5 + SIZE as f64 * 0.36;
/// Distance of base lines.
pub(super) const STEP: f64 = LINE;
