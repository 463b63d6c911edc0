//! Draws a laid-out figure.

use super::annotate::{self, Mark};
use super::canvas::{Anchor, Canvas, Lettering, Stroke, Surface};
use super::curve::{Curve, RADIUS};
use super::geometry::{Point, Rect};
use super::layout::{Cell, GAP, LABEL, PANEL_TITLE, STRIP_TEXT, Sheet, TICK, TICK_LABEL, TITLE};
use super::legend::{self, Placed};
use super::palette::{BAND, DOTTED, GRID, INK, Look, PAPER, SOLID};
use super::{Figure, Panel, Span, Strip, text};

/// Width of the strokes of a series, px.
const PEN: f64 = 1.6;

pub(super) const FRAME: Stroke = Stroke { colour: INK, width: 0.8, dash: SOLID };
const GRID_LINE: Stroke = Stroke { colour: GRID, width: 0.7, dash: SOLID };

const THIN: Stroke = Stroke { colour: INK, width: 0.5, dash: SOLID };

/// Classes of parts that the script of a live page moves or replaces when a reader zooms.
const MOVING: &str = "moving";
const NOTE: &str = "note";
const WORDS: &str = "words";
const X_GRID: &str = "x-grid";
const X_TICKS: &str = "x-ticks";

/// Half the height of a capital letter, in units of the font size.
pub(super) const MIDDLE: f64 = 0.365;

/// Draws a checked figure on a surface made for its width and height.
pub(super) fn paint<S: Surface>(
    figure: &Figure,
    sheet: &Sheet,
    surface: impl FnOnce(f64, f64) -> S,
) -> S {
    let mut surface = surface(sheet.width.ceil(), sheet.height.ceil());
    paint_sheet(&mut Canvas::on(&mut surface), figure, sheet);
    surface
}

fn paint_sheet(canvas: &mut Canvas<'_>, figure: &Figure, sheet: &Sheet) {
    let title = Lettering { bold: true, ..lettering(TITLE, Anchor::Middle) };
    let mut base = 10.0 + f64::from(TITLE);
    for line in &sheet.title {
        canvas.text(Point::new(sheet.width / 2.0, base), line, &title);
        base += f64::from(TITLE) * text::LINE;
    }
    for (panel, cell) in figure.panels.iter().zip(&sheet.cells) {
        canvas.part("panel", |canvas| paint_panel(canvas, panel, cell));
    }
}

pub(super) fn lettering(size: u32, anchor: Anchor) -> Lettering {
    Lettering { size, anchor, bold: false, upright: false, colour: INK }
}

fn paint_panel(canvas: &mut Canvas<'_>, panel: &Panel, cell: &Cell) {
    let view = &cell.view;
    let frame = &view.frame;
    let series = panel.series.iter().zip(&cell.looks);
    let curves: Vec<Curve> = series.map(|(s, look)| Curve::new(s, look, view)).collect();
    let marks: Vec<Mark> = panel.annotations.iter().map(|a| Mark::new(a, view, &curves)).collect();

    let bands: Vec<Rect> = marks.iter().filter_map(|m| m.band).collect();
    if !bands.is_empty() {
        paint_moving(canvas, frame, |canvas| {
            bands.iter().for_each(|band| canvas.fill(band, BAND, 0.22));
        });
    }
    match &panel.heat {
        // A grid could be mistaken for lines of the map.
        Some(heat) => heat.paint_tiles(canvas, view),
        None => paint_grid(canvas, cell),
    }
    // The pen is wider than the edge it may follow.
    canvas.clip(&frame.grown(PEN / 2.0));
    canvas.part(MOVING, |canvas| {
        for (curve, look) in curves.iter().zip(&cell.looks) {
            paint_curve(canvas, curve, look);
        }
    });
    // The background of a text covers curves, but no other annotation.
    let notes: Vec<&annotate::Note> = marks.iter().filter_map(|m| m.note.as_ref()).collect();
    for note in &notes {
        paint_anchored(canvas, note, |canvas| canvas.fill(&note.rect.grown(1.0), PAPER, 0.8));
    }
    canvas.part(MOVING, |canvas| {
        for mark in &marks {
            for (from, to, stroke) in &mark.lines {
                canvas.line(*from, *to, stroke);
            }
            for head in &mark.heads {
                canvas.polygon(head, INK);
            }
        }
    });
    canvas.unclip();
    canvas.outline(frame, &FRAME);
    for note in &notes {
        paint_anchored(canvas, note, |canvas| paint_note(canvas, note));
    }
    if let Some(strip) = &panel.strip {
        paint_strip(canvas, strip, cell);
    }
    paint_axes(canvas, cell);
    if let Some(heat) = &panel.heat {
        heat.paint_key(canvas, frame);
    }
    if let Some(legend) = &cell.legend {
        paint_legend(canvas, legend, cell);
    }
    let mut base = frame.y
        - cell.legend.as_ref().map_or(0.0, Placed::head)
        - cell.note_height()
        - cell.strip_height()
        - cell.title_height()
        - GAP
        + f64::from(PANEL_TITLE);
    let title = Lettering { bold: true, ..lettering(PANEL_TITLE, Anchor::Middle) };
    for line in &cell.title {
        canvas.text(Point::new(frame.centre().x, base), line, &title);
        base += f64::from(PANEL_TITLE) * text::LINE;
    }
}

/// Paints within `rect` the parts that a reader's zoom moves along x.
fn paint_moving(canvas: &mut Canvas<'_>, rect: &Rect, draw: impl FnOnce(&mut Canvas<'_>)) {
    if !canvas.is_page() {
        return draw(canvas);
    }
    canvas.clip(rect);
    canvas.part(MOVING, draw);
    canvas.unclip();
}

/// Paints the parts that move with the anchor of a note.
fn paint_anchored(
    canvas: &mut Canvas<'_>,
    note: &annotate::Note,
    draw: impl FnOnce(&mut Canvas<'_>),
) {
    match note.anchor {
        Some(x) => canvas.part_at(NOTE, x, draw),
        None => draw(canvas),
    }
}

fn paint_curve(canvas: &mut Canvas<'_>, curve: &Curve, look: &Look) {
    match curve {
        Curve::Lines(runs) => canvas.lines(runs, &pen(look)),
        Curve::Points(points, marker) => canvas.markers(points, *marker, RADIUS, look.colour),
        Curve::Bars(bars) => {
            let edge = Stroke { colour: look.colour, width: 0.8, dash: SOLID };
            canvas.bars(bars, 0.35, &edge);
        }
    }
}

/// The strip above the frame, with the words that fit.
fn paint_strip(canvas: &mut Canvas<'_>, strip: &Strip, cell: &Cell) {
    let rect = cell.strip_rect();
    let at = |x: f64| {
        let x = cell.view.place((x, cell.view.y.lo)).x;
        x.clamp(rect.x, rect.right())
    };
    let spans: Vec<(Rect, &Span)> = strip
        .spans
        .iter()
        .map(|span| {
            let (a, b) = (at(span.from.min(span.to)), at(span.from.max(span.to)));
            (Rect::new(a, rect.y, b - a, rect.h), span)
        })
        .filter(|(rect, _)| rect.w > 0.0)
        .collect();
    paint_moving(canvas, &rect, |canvas| {
        for (rect, span) in &spans {
            canvas.fill(rect, BAND, 0.6 * span.shade.clamp(0.0, 1.0));
            canvas.line(Point::new(rect.x, rect.y), Point::new(rect.x, rect.bottom()), &THIN);
        }
    });
    canvas.outline(&rect, &THIN);
    let small = f64::from(STRIP_TEXT);
    let base = cell.strip_base();
    canvas.part(WORDS, |canvas| {
        for (rect, span) in &spans {
            if text::width(&span.word, small) + 2.0 * GAP <= rect.w {
                let at = Point::new(rect.centre().x, base);
                canvas.text(at, &span.word, &lettering(STRIP_TEXT, Anchor::Middle));
            }
        }
    });
    let at = Point::new(rect.x - TICK - GAP, base);
    canvas.text(at, &strip.name, &lettering(STRIP_TEXT, Anchor::End));
}

fn pen(look: &Look) -> Stroke {
    // Dots as wide as the strokes of other lines look thinner.
    let width = if look.dash == DOTTED { 1.15 * PEN } else { PEN };
    Stroke { colour: look.colour, width, dash: look.dash }
}

fn paint_grid(canvas: &mut Canvas<'_>, cell: &Cell) {
    let (view, frame) = (&cell.view, &cell.view.frame);
    let vertical = view.x.ticks.iter().map(|tick| {
        let x = view.place((tick.at, view.y.lo)).x;
        vec![Point::new(x, frame.y), Point::new(x, frame.bottom())]
    });
    let horizontal = view.y.ticks.iter().map(|tick| {
        let y = view.place((view.x.lo, tick.at)).y;
        vec![Point::new(frame.x, y), Point::new(frame.right(), y)]
    });
    if canvas.is_page() {
        canvas.lines(&horizontal.collect::<Vec<_>>(), &GRID_LINE);
        let vertical: Vec<_> = vertical.collect();
        canvas.part(X_GRID, |canvas| canvas.lines(&vertical, &GRID_LINE));
    } else {
        canvas.lines(&vertical.chain(horizontal).collect::<Vec<_>>(), &GRID_LINE);
    }
}

fn paint_axes(canvas: &mut Canvas<'_>, cell: &Cell) {
    let (view, frame) = (&cell.view, &cell.view.frame);
    let small = f64::from(TICK_LABEL);
    let mut ticks = Vec::new();

    for tick in &view.y.ticks {
        let y = view.place((view.x.lo, tick.at)).y;
        ticks.push(vec![Point::new(frame.x - TICK, y), Point::new(frame.x, y)]);
        let at = Point::new(frame.x - TICK - GAP, y + MIDDLE * small);
        canvas.text(at, &tick.label, &lettering(TICK_LABEL, Anchor::End));
    }
    if !view.y.note.is_empty() {
        let at = Point::new(frame.x, frame.y - GAP - 1.0);
        canvas.text(at, &view.y.note, &lettering(TICK_LABEL, Anchor::Start));
    }
    let upright = Lettering { upright: true, ..lettering(LABEL, Anchor::Middle) };
    for (i, line) in cell.y_label.iter().enumerate() {
        let x = cell.left + f64::from(LABEL) * (1.0 + i as f64 * text::LINE);
        canvas.text(Point::new(x, frame.centre().y), line, &upright);
    }

    canvas.part(X_TICKS, |canvas| {
        let mut own = Vec::new();
        for tick in &view.x.ticks {
            let x = view.place((tick.at, view.y.lo)).x;
            own.push(vec![Point::new(x, frame.bottom()), Point::new(x, frame.bottom() + TICK)]);
            if cell.lettered {
                let at = Point::new(x, frame.bottom() + TICK + GAP + 0.8 * small);
                canvas.text(at, &tick.label, &lettering(TICK_LABEL, Anchor::Middle));
            }
        }
        if canvas.is_page() {
            canvas.lines(&own, &FRAME);
        } else {
            ticks.append(&mut own);
        }
    });
    if cell.lettered {
        let mut base = frame.bottom() + TICK + GAP + small + GAP + f64::from(LABEL);
        if !view.x.note.is_empty() {
            let at = Point::new(frame.right(), base);
            canvas.text(at, &view.x.note, &lettering(TICK_LABEL, Anchor::End));
        }
        for line in &cell.x_label {
            let at = Point::new(frame.centre().x, base);
            canvas.text(at, line, &lettering(LABEL, Anchor::Middle));
            base += f64::from(LABEL) * text::LINE;
        }
    }
    canvas.lines(&ticks, &FRAME);
}

fn paint_note(canvas: &mut Canvas<'_>, note: &annotate::Note) {
    let size = f64::from(annotate::SIZE);
    for (i, line) in note.lines.iter().enumerate() {
        let y = note.rect.y + (i as f64 + 0.5) * size * text::LINE + MIDDLE * size;
        let at = Point::new(note.rect.centre().x, y);
        canvas.text(at, line, &lettering(annotate::SIZE, Anchor::Middle));
    }
}

fn paint_legend(canvas: &mut Canvas<'_>, legend: &Placed, cell: &Cell) {
    let frame = &cell.view.frame;
    let raised = if legend.inside { 0.0 } else { cell.note_height() + cell.strip_height() };
    let corner = Point::new(frame.x + legend.rect.x, frame.y + legend.rect.y - raised);
    if legend.inside {
        let rect = Rect { x: corner.x, y: corner.y, ..legend.rect };
        canvas.fill(&rect, PAPER, 0.9);
        canvas.outline(&rect, &GRID_LINE);
    }
    for entry in &legend.entries {
        let look = &cell.looks[entry.series];
        let at = Point::new(corner.x + entry.at.x, corner.y + entry.at.y);
        let middle = at.y + legend::STEP / 2.0;
        match look.marker {
            Some(marker) => {
                let centre = Point::new(at.x + legend::KEY / 2.0, middle);
                canvas.markers(&[centre], marker, RADIUS * 1.3, look.colour);
            }
            None => canvas.line(
                Point::new(at.x, middle),
                Point::new(at.x + legend::KEY, middle),
                &pen(look),
            ),
        }
        for (i, line) in entry.lines.iter().enumerate() {
            let base = at.y + legend::BASE + i as f64 * legend::STEP;
            let start = Point::new(at.x + legend::KEY + legend::KEY_GAP, base);
            canvas.text(start, line, &lettering(legend::SIZE, Anchor::Start));
        }
    }
}
