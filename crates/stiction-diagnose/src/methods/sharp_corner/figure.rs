//! Figure of the method: cycles of OP and error with their corners.

use super::{SharpCornerCycle, SharpCornerResult};
use crate::drawing::{Scene, sheet};
use crate::spoken::number;
use stiction_figure::figure::{Figure, Legend, Panel, Series, colour};

/// Most drawn cycles.
const CYCLES: usize = 3;

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &SharpCornerResult) -> Option<Figure> {
    let count = found.cycles.len();
    let shown = count.min(CYCLES);
    // The first, the middle and the last.
    let chosen = (0..shown)
        .map(|i| &found.cycles[if shown > 1 { i * (count - 1) / (shown - 1) } else { 0 }]);
    let caption = format!(
        "{shown} of the {count} cycles that resemble an ellipse. A corner is sharp if two straight lines describe \
         it; {} % of all corners are sharp.",
        number(100.0 * found.share)
    );
    let figure = chosen
        .fold(sheet(caption).columns(shown.max(1)).panel_height(230.0), |figure, cycle| {
            figure.with(corners(scene, cycle))
        });
    (shown > 0).then_some(figure)
}

/// A cycle with the lines that describe its corners.
fn corners(scene: &Scene<'_>, cycle: &SharpCornerCycle) -> Panel {
    let closed = |x: &[f64]| -> Vec<f64> { x.iter().chain(x.first()).copied().collect() };
    let (x, y) = cycle.ellipse.closed_outline();
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
