//! Maps of one signal against another: OP and what follows it, cycles, wings, a sigmoid.

use super::{Scene, dashed, dotted, sheet, thinned};
use crate::report::layout::number;
use crate::report::views::outline;
use std::ops::Range;
use stiction_diagnose::detect::{
    ButterflyResult, DamarlaSigmoidResult, KanoResult, MeasuredValve, Rest, SharpCornerCycle,
    SharpCornerResult, StuckSpan,
};
use stiction_diagnose::series::{max, min, span};
use stiction_figure::figure::{Annotation, Figure, Legend, Panel, Series, colour};

/// Points of a map at most.
const MOST: usize = 1_500;
/// Cycles drawn at most.
const CYCLES: usize = 3;

/// A signal that follows the valve, and where it rests.
struct Follower<'a> {
    name: &'static str,
    label: String,
    values: &'a [f64],
    rests: Vec<StuckSpan>,
}

pub fn direct(scene: &Scene<'_>, found: &MeasuredValve) -> Option<Figure> {
    let vp = scene.subject.segment.vp.as_deref()?;
    let range = scene.end();
    let inside = |rest: &&Rest| overlaps(&rest.span, &range);
    let follower = Follower {
        name: "VP",
        label: "VP (% of span)".to_owned(),
        values: vp,
        rests: found.rests.iter().map(|rest| rest.span).collect(),
    };
    let (trend, mut map) = rests(scene, &follower, &range)?;
    let slips: Vec<&Rest> =
        found.rests.iter().filter(inside).filter(|rest| rest.op_slip.is_some()).collect();
    if !slips.is_empty() {
        let x: Vec<f64> = slips.iter().filter_map(|rest| rest.op_slip).collect();
        let y: Vec<f64> = slips.iter().map(|rest| rest.span.level).collect();
        map = map.with(Series::points("slips", x, y).colour(colour::BLACK));
    }
    let mut caption =
        "Valve position over time and over the OP, at the end of the segment. A rest is where \
                       the OP travels and the valve does not; a slip is where it ends."
            .to_owned();
    if let (Ok(band), Ok(offset)) = (&found.dead_band, &found.offset) {
        // VP = OP - offset -+ half of the dead band, while it moves.
        let reached = vp.get(range.clone()).unwrap_or_default();
        let ends = [min(reached), max(reached)];
        let half = 0.5 * band.median;
        for (name, half, series) in [
            ("moving up", half, dashed as fn(&str, Vec<f64>, Vec<f64>) -> Series),
            ("moving down", -half, dotted),
        ] {
            let op = ends.map(|vp| vp + offset.median + half);
            map = map.with(series(name, op.to_vec(), ends.to_vec()).colour(colour::BLACK));
        }
        caption.push_str(&format!(
            " The straight lines lie a dead band of {} % apart: where the moving valve stands.",
            number(band.median)
        ));
    }
    Some(sheet(caption).columns(2).panel_height(280.0).with(trend).with(map))
}

pub fn kano(scene: &Scene<'_>, found: &KanoResult) -> Option<Figure> {
    let (label, values) = match found.follower {
        "VP" => ("VP (% of span)".to_owned(), scene.subject.segment.vp.as_deref()?),
        _ => (scene.context.pv_label("PV"), scene.pv()),
    };
    let follower = Follower { name: found.follower, label, values, rests: found.rests.clone() };
    let (trend, map) = rests(scene, &follower, &scene.end())?;
    let caption = format!(
        "{} over time and over the OP, at the end of the segment, with its rests while the OP travels; over \
         the whole segment they are {} of all samples. A parallelogram {} % of OP wide explains {} % of \
         its variance, none at all {} %.",
        follower.name,
        number(found.statistic),
        number(found.width),
        number(100.0 * found.explained),
        number(100.0 * found.explained_without)
    );
    Some(sheet(caption).columns(2).panel_height(280.0).with(trend).with(map))
}

fn overlaps(rest: &StuckSpan, range: &Range<usize>) -> bool {
    rest.first < range.end && rest.end > range.start
}

/// A follower over time and over the OP in some samples, its rests marked.
fn rests(
    scene: &Scene<'_>,
    follower: &Follower<'_>,
    range: &Range<usize>,
) -> Option<(Panel, Panel)> {
    let op = scene.op().get(range.clone())?;
    let values = follower.values.get(range.clone())?;
    if op.is_empty() || span(op) == 0.0 {
        return None;
    }
    let ((x, _), (y, _)) = (thinned(op, MOST), thinned(values, MOST));
    let mut trend = scene.trend(&follower.label).height(280.0).legend(Legend::Above).with(
        scene.samples(follower.name, follower.values, range.clone(), false).colour(colour::SKY),
    );
    let mut map = Panel::new("OP (% of span)", &follower.label)
        .height(280.0)
        .legend(Legend::Above)
        .with(Series::line(follower.name, x, y).colour(colour::SKY));
    let (mut times, mut along, mut levels, mut breaks) = (vec![], vec![], vec![], vec![]);
    for rest in follower.rests.iter().filter(|rest| overlaps(rest, range)) {
        let (first, last) = (rest.first.max(range.start), (rest.end - 1).min(range.end - 1));
        breaks.push(levels.len());
        times.extend(scene.times([first as f64, last as f64]));
        along.extend([scene.op()[first], scene.op()[last]]);
        levels.extend([rest.level; 2]);
    }
    if !levels.is_empty() {
        let rests =
            |x| Series::line("rests", x, &levels[..]).colour(colour::VERMILION).breaks(&breaks[..]);
        trend = trend.with(rests(times));
        map = map.with(rests(along));
    }
    Some((trend, map))
}

pub fn sharp_corner(scene: &Scene<'_>, found: &SharpCornerResult) -> Option<Figure> {
    let count = found.cycles.len();
    let shown = count.min(CYCLES);
    // The first, the middle and the last.
    let chosen = (0..shown)
        .map(|i| &found.cycles[if shown > 1 { i * (count - 1) / (shown - 1) } else { 0 }]);
    let caption = format!(
        "{shown} of the {count} cycles that resemble an ellipse. A corner is sharp if two straight strokes \
         describe it; {} % of all corners are.",
        number(100.0 * found.share)
    );
    let figure = chosen
        .fold(sheet(caption).columns(shown.max(1)).panel_height(230.0), |figure, cycle| {
            figure.with(corners(scene, cycle))
        });
    (shown > 0).then_some(figure)
}

/// A cycle with the strokes that describe its corners.
fn corners(scene: &Scene<'_>, cycle: &SharpCornerCycle) -> Panel {
    let closed = |x: &[f64]| -> Vec<f64> { x.iter().chain(x.first()).copied().collect() };
    let (x, y) = outline(&cycle.ellipse);
    let mut panel = Panel::new("OP (% of span)", scene.context.pv_label("error"))
        .legend(Legend::Above)
        .with(Series::line("cycle", closed(&cycle.op), closed(&cycle.error)).colour(colour::SKY))
        .with(Series::dotted("ellipse", x, y).colour(colour::BLACK));
    for (name, colour, wanted) in
        [("sharp corner", colour::VERMILION, true), ("round corner", colour::GREEN, false)]
    {
        let (mut x, mut y, mut breaks) = (vec![], vec![], vec![]);
        for points in cycle.corners.iter().filter(|points| (points.len() == 3) == wanted) {
            breaks.push(x.len());
            x.extend(points.iter().filter_map(|k| cycle.op.get(*k)));
            y.extend(points.iter().filter_map(|k| cycle.error.get(*k)));
        }
        if !x.is_empty() && x.len() == y.len() {
            panel = panel.with(Series::line(name, x, y).colour(colour).breaks(breaks));
        }
    }
    panel
}

pub fn butterfly(found: &ButterflyResult) -> Option<Figure> {
    let ((pv, stride), (distance, _)) = (thinned(&found.pv, MOST), thinned(&found.distance, MOST));
    let panel = Panel::new(
        "PV (standard deviations)",
        "distance of the OP from the PV before (standard deviations)",
    )
    .with(Series::points("samples", pv, distance).colour(colour::BLUE))
    .note(Annotation::x_band(-0.5, 0.5, "body"));
    let mut caption = format!(
        "A butterfly: two open wings and between them, shaded, an empty body, where the PV passes quickly \
         while the valve slips. The body is empty by W = {}, the wings are open by {} and {}.",
        number(found.emptiness),
        number(found.openings[0]),
        number(found.openings[1])
    );
    if stride > 1 {
        caption.push_str(&format!(" One sample in {stride} is drawn."));
    }
    Some(sheet(caption).width(620.0).panel_height(300.0).with(panel))
}

pub fn sigmoid(found: &DamarlaSigmoidResult) -> Option<Figure> {
    let ((x, stride), (y, _)) = (thinned(&found.increment, MOST), thinned(&found.op, MOST));
    let (low, high) = (min(&found.increment), max(&found.increment));
    let along: Vec<f64> = (0..=200).map(|i| low + (high - low) * f64::from(i) / 200.0).collect();
    let fitted: Vec<f64> = along.iter().map(|x| found.sigmoid(*x)).collect();
    let panel = Panel::new("increment of the PV (standard deviations)", "OP (share of its range)")
        .legend(Legend::Above)
        .with(Series::points("pairs", x, y).colour(colour::SKY))
        .with(Series::line("fitted sigmoid", along, fitted).colour(colour::VERMILION));
    let mut caption = format!(
        "OP over the increments of the PV, with the sigmoid of least squares; their correlation R is {}.",
        number(found.r)
    );
    if stride > 1 {
        caption.push_str(&format!(" One pair in {stride} is drawn."));
    }
    Some(sheet(caption).width(620.0).panel_height(300.0).with(panel))
}
