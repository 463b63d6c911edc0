//! Computes the position of panels, axes, labels and legend in a picture.

use super::annotate::Mark;
use super::axis::{self, Axis};
use super::curve::{Curve, edges};
use super::geometry::{Point, Rect};
use super::legend::{self, Placed};
use super::paint::MIDDLE;
use super::palette::{Look, looks};
use super::{Annotation, Figure, Heat, Panel, Scale, Series, Style, text};

/// Font sizes, px.
pub(super) const TITLE: u32 = 16;
pub(super) const PANEL_TITLE: u32 = 13;
pub(super) const LABEL: u32 = 13;
pub(super) const TICK_LABEL: u32 = 12;
pub(super) const STRIP_TEXT: u32 = 11;
/// Height of the strip.
const STRIP: f64 = 16.0;

/// Length of a tick.
pub(super) const TICK: f64 = 4.0;
/// Between a tick and its label, and between tick labels and the axis label.
pub(super) const GAP: f64 = 4.0;

/// Around the sheet.
const EDGE: f64 = 10.0;
/// To the right of a frame, for half a tick label.
const OVERHANG: f64 = 16.0;
/// Between panels side by side.
const COLUMN_GAP: f64 = 14.0;
/// Between panels above each other.
const ROW_GAP: f64 = 12.0;
/// Coordinates further off the sheet than this are drawn at this distance, because renderers overflow.
const FAR: f64 = 20_000.0;

/// The sheet with its contents.
pub(super) struct Sheet {
    pub width: f64,
    pub height: f64,
    pub title: Vec<String>,
    pub cells: Vec<Cell>,
}

/// One panel, placed.
pub(super) struct Cell {
    pub view: View,
    pub looks: Vec<Look>,
    pub legend: Option<Placed>,
    pub title: Vec<String>,
    pub x_label: Vec<String>,
    pub y_label: Vec<String>,
    /// Left edge of the column, where the y label begins.
    pub left: f64,
    /// Whether the x axis has labels. If not, the panel below has the same axis.
    pub lettered: bool,
    has_strip: bool,
}

/// A frame with its axes, which converts data to paper.
pub(super) struct View {
    pub frame: Rect,
    pub x: Axis,
    pub y: Axis,
}

impl View {
    /// The position on paper of a point in data coordinates.
    pub fn place(&self, (x, y): (f64, f64)) -> Point {
        let px = self.frame.x + self.x.fraction(x) * self.frame.w;
        let py = self.frame.bottom() - self.y.fraction(y) * self.frame.h;
        Point::new(px.clamp(-FAR, FAR), py.clamp(-FAR, FAR))
    }
}

/// Ends of one panel's axes, and whether its x axis has labels.
#[derive(Clone, Copy)]
struct Ends {
    x: (f64, f64),
    y: (f64, f64),
    lettered: bool,
}

impl Sheet {
    /// Lays out a checked figure.
    pub fn new(figure: &Figure) -> Self {
        let columns = figure.columns.min(figure.panels.len());
        let rows = figure.panels.len().div_ceil(columns);
        let height = figure.panel_height.unwrap_or(match rows {
            1 => 340.0,
            2 => 230.0,
            _ => 160.0,
        });
        let cell_width =
            (figure.width - 2.0 * EDGE - (columns - 1) as f64 * COLUMN_GAP) / columns as f64;
        let ends = ends(&figure.panels, columns);

        // Columns have equal left margins, so that frames above each other align.
        let mut cells: Vec<Cell> = Vec::with_capacity(figure.panels.len());
        let mut margins = vec![0.0_f64; columns];
        for (i, (panel, ends)) in figure.panels.iter().zip(&ends).enumerate() {
            let height = panel.height.unwrap_or(height);
            let y = y_axis(ends.y, height, panel.y_scale);
            let y_label = text::wrap(&panel.y_label, f64::from(LABEL), 1.1 * height);
            let lettering = y_label.len() as f64 * f64::from(LABEL) * text::LINE;
            let strip = panel.strip.as_ref();
            let name = strip.map_or(0.0, |s| text::width(&s.name, f64::from(STRIP_TEXT)));
            let margin = (lettering + GAP + widest(&y)).max(name) + GAP + TICK;
            margins[i % columns] = margins[i % columns].max(margin);
        }
        let mut widths = vec![0.0_f64; columns];
        let mut beside = vec![OVERHANG; columns];
        for (i, panel) in figure.panels.iter().enumerate() {
            let room = panel.heat.as_ref().map_or(0.0, Heat::room);
            beside[i % columns] = beside[i % columns].max(room);
        }
        for (i, (panel, ends)) in figure.panels.iter().zip(&ends).enumerate() {
            let room = (cell_width - margins[i % columns] - beside[i % columns]).max(80.0);
            let cell = cell(panel, ends, room, panel.height.unwrap_or(height));
            widths[i % columns] = widths[i % columns].max(cell.view.frame.w);
            cells.push(cell);
        }
        let mut left = EDGE;
        for column in 0..columns {
            for cell in cells.iter_mut().skip(column).step_by(columns) {
                cell.left = left;
                cell.view.frame.x =
                    left + margins[column] + (widths[column] - cell.view.frame.w) / 2.0;
            }
            left += margins[column] + widths[column] + beside[column] + COLUMN_GAP;
        }
        let width = left - COLUMN_GAP + EDGE;
        let title = text::wrap(&figure.title, f64::from(TITLE) * text::BOLD, width - 2.0 * EDGE);

        // Rows align frames side by side at the top.
        let mut top = EDGE + title.len() as f64 * f64::from(TITLE) * text::LINE;
        top += if title.is_empty() { 0.0 } else { GAP };
        for row in cells.chunks_mut(columns) {
            let head = row.iter().map(Cell::head).fold(0.0, f64::max);
            let frame = row.iter().map(|c| c.view.frame.h).fold(0.0, f64::max);
            let foot = row.iter().map(Cell::foot).fold(0.0, f64::max);
            for cell in row {
                cell.view.frame.y = top + head;
            }
            top += head + frame + foot + ROW_GAP;
        }
        Self { width, height: top - ROW_GAP + EDGE, title, cells }
    }
}

impl Cell {
    /// Height above the frame.
    fn head(&self) -> f64 {
        self.title_height()
            + self.legend.as_ref().map_or(0.0, Placed::head)
            + self.note_height()
            + self.strip_height()
            + f64::from(TICK_LABEL) / 2.0
    }

    /// Height of the note on the y labels.
    pub fn note_height(&self) -> f64 {
        if self.view.y.note.is_empty() { 0.0 } else { f64::from(TICK_LABEL) + GAP }
    }

    /// Height of the strip with the room below it.
    pub fn strip_height(&self) -> f64 {
        if self.has_strip { STRIP + GAP } else { 0.0 }
    }

    /// The rectangle of the strip.
    pub fn strip_rect(&self) -> Rect {
        let frame = &self.view.frame;
        let bottom = frame.y - self.note_height() - GAP;
        Rect::new(frame.x, bottom - STRIP, frame.w, STRIP)
    }

    /// The base line of the words of the strip.
    pub fn strip_base(&self) -> f64 {
        self.strip_rect().centre().y + MIDDLE * f64::from(STRIP_TEXT)
    }

    /// Height of the heading.
    pub fn title_height(&self) -> f64 {
        self.title.len() as f64 * f64::from(PANEL_TITLE) * text::LINE
    }

    /// Height below the frame.
    fn foot(&self) -> f64 {
        if self.lettered {
            TICK + GAP
                + f64::from(TICK_LABEL)
                + GAP
                + self.x_label.len() as f64 * f64::from(LABEL) * text::LINE
        } else {
            TICK
        }
    }
}

/// A panel whose frame has its size, but not yet its position.
fn cell(panel: &Panel, ends: &Ends, room: f64, height: f64) -> Cell {
    let (mut w, mut h) = (room, height);
    if panel.equal_aspect {
        let (xs, ys) = (ends.x.1 - ends.x.0, ends.y.1 - ends.y.0);
        let scale = (room / xs).min(height / ys);
        (w, h) = (xs * scale, ys * scale);
    }
    let frame = Rect::new(0.0, 0.0, w, h);
    let view =
        View { frame, x: x_axis(ends.x, w, panel.x_scale), y: y_axis(ends.y, h, panel.y_scale) };
    let looks = looks(panel);
    let curves: Vec<Curve> =
        panel.series.iter().zip(&looks).map(|(s, look)| Curve::new(s, look, &view)).collect();
    let marks: Vec<Mark> = panel.annotations.iter().map(|a| Mark::new(a, &view, &curves)).collect();
    let note = 2.0 * (text::width(&view.x.note, f64::from(TICK_LABEL)) + GAP);
    Cell {
        legend: legend::place(panel, &frame, &curves, &marks),
        looks,
        title: text::wrap(&panel.title, f64::from(PANEL_TITLE) * text::BOLD, w),
        x_label: text::wrap(&panel.x_label, f64::from(LABEL), (w - note).max(60.0)),
        y_label: text::wrap(&panel.y_label, f64::from(LABEL), 1.1 * h),
        left: 0.0,
        lettered: ends.lettered,
        has_strip: panel.strip.is_some(),
        view,
    }
}

/// An x axis with as many ticks as its labels leave room for.
fn x_axis(ends: (f64, f64), width: f64, scale: Scale) -> Axis {
    let fits = |axis: &Axis| {
        let apart = axis.ticks.windows(2).map(|t| axis.fraction(t[1].at) - axis.fraction(t[0].at));
        let room = apart.fold(1.0, f64::min) * width;
        let label = |t: &axis::Tick| text::width(&t.label, f64::from(TICK_LABEL));
        axis.ticks.iter().map(label).fold(0.0, f64::max) + 14.0 <= room
    };
    let most = (width / 48.0).clamp(2.0, 10.0) as usize;
    let mut axes = (1..=most).rev().map(|count| Axis::new(ends, count, scale));
    axes.find(fits).unwrap_or_else(|| Axis::new(ends, 1, scale))
}

fn y_axis(ends: (f64, f64), height: f64, scale: Scale) -> Axis {
    Axis::new(ends, (height / 26.0).clamp(2.0, 9.0) as usize, scale)
}

fn widest(axis: &Axis) -> f64 {
    axis.ticks.iter().map(|t| text::width(&t.label, f64::from(TICK_LABEL))).fold(0.0, f64::max)
}

/// Ends of all axes. Panels above each other that share an x axis get the same ends.
fn ends(panels: &[Panel], columns: usize) -> Vec<Ends> {
    let mut all: Vec<Ends> = panels
        .iter()
        .map(|panel| Ends { x: (0.0, 1.0), y: y_ends(panel), lettered: true })
        .collect();
    for column in 0..columns {
        let stack: Vec<usize> = (column..panels.len()).step_by(columns).collect();
        for group in stack.chunk_by(|a, b| share_x(&panels[*a], &panels[*b])) {
            let members: Vec<&Panel> = group.iter().map(|i| &panels[*i]).collect();
            let x = x_ends(&members);
            for (place, &i) in group.iter().enumerate() {
                all[i].x = x;
                all[i].lettered = place + 1 == group.len();
            }
        }
    }
    for (panel, ends) in panels.iter().zip(&mut all) {
        if panel.equal_aspect {
            // A frame would become too thin.
            let (xs, ys) = (ends.x.1 - ends.x.0, ends.y.1 - ends.y.0);
            ends.x = at_least(ends.x, ys / 4.0);
            ends.y = at_least(ends.y, xs / 4.0);
        }
    }
    all
}

/// Whether two panels above each other can share one x axis, because they have the same quantity over about the same
/// range.
fn share_x(a: &Panel, b: &Panel) -> bool {
    let same = a.x_label == b.x_label && a.x_range == b.x_range && a.x_scale == b.x_scale;
    let span = |panels: &[&Panel]| {
        let (lo, hi) = x_ends(panels);
        hi - lo
    };
    same && a.heat.is_none()
        && b.heat.is_none()
        && !a.equal_aspect
        && !b.equal_aspect
        && span(&[a, b]) <= 1.5 * span(&[a]).min(span(&[b]))
}

fn x_ends(panels: &[&Panel]) -> (f64, f64) {
    if let Some(range) = panels[0].x_range {
        return range;
    }
    if let Some(heat) = &panels[0].heat {
        return heat.x_ends();
    }
    let series = || panels.iter().flat_map(|p| &p.series);
    let samples = series().flat_map(|s| s.x.iter().copied());
    let marks = panels.iter().flat_map(|p| &p.annotations).flat_map(|a| points(a).0);
    let bars = series().filter(|s| s.style == Style::Bars);
    let bars = bars.flat_map(|s| edges(&s.x)).flat_map(|(from, to)| [from, to]);
    // Time runs from edge to edge. Maps and markers need a margin.
    let line = |s: &Series| s.is_trend() && !matches!(s.style, Style::Points | Style::Bars);
    let edge_to_edge = series().all(line);
    let extent = axis::extent(samples.chain(marks).chain(bars));
    match panels[0].x_scale {
        Scale::Log => log_widened(extent, if edge_to_edge { 0.0 } else { 0.05 }),
        Scale::Clock if extent.1 - extent.0 < 10.0 => (extent.0 - 5.0, extent.1 + 5.0),
        Scale::Clock => extent,
        Scale::Linear if edge_to_edge => axis::snapped(axis::widened(extent, 0.0)),
        Scale::Linear | Scale::Names(_) => axis::widened(extent, 0.05),
    }
}

fn y_ends(panel: &Panel) -> (f64, f64) {
    let heat = panel.heat.as_ref().map(Heat::y_ends);
    panel.y_range.or(heat).unwrap_or_else(|| {
        let samples = panel.series.iter().flat_map(|s| s.y.iter().copied());
        let marks = panel.annotations.iter().flat_map(|a| points(a).1);
        let bars = panel.series.iter().any(|s| s.style == Style::Bars);
        let extent = axis::extent(samples.chain(marks).chain(bars.then_some(0.0)));
        match panel.y_scale {
            Scale::Log => log_widened(extent, 0.06),
            _ if bars && extent.0 == 0.0 => (0.0, axis::widened(extent, 0.06).1),
            _ => axis::widened(extent, 0.06),
        }
    })
}

/// Like [`axis::widened`], in decades.
fn log_widened((lo, hi): (f64, f64), pad: f64) -> (f64, f64) {
    let (lo, hi) = (axis::logarithm(lo), axis::logarithm(hi));
    let margin = if hi - lo < 1e-6 { 0.5 } else { pad * (hi - lo) };
    (10f64.powf((lo - margin).max(-300.0)), 10f64.powf((hi + margin).min(300.0)))
}

/// Coordinates of an annotation that axes should include.
fn points(annotation: &Annotation) -> (Vec<f64>, Vec<f64>) {
    match *annotation {
        Annotation::Text { at, .. } => (vec![at.0], vec![at.1]),
        Annotation::Arrow { from, to, .. } | Annotation::Dimension { from, to, .. } => {
            (vec![from.0, to.0], vec![from.1, to.1])
        }
        Annotation::HorizontalLine { y, .. } => (vec![], vec![y]),
        Annotation::VerticalLine { x, .. } => (vec![x], vec![]),
        Annotation::XBand { .. } => (vec![], vec![]),
    }
}

/// `ends`, widened around their middle to a range of `span` if they are closer.
fn at_least((lo, hi): (f64, f64), span: f64) -> (f64, f64) {
    let missing = (span - (hi - lo)).max(0.0);
    (lo - missing / 2.0, hi + missing / 2.0)
}
