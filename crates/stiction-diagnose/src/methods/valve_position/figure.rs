//! Figure of the method: the valve position over time and over the OP.

use super::{MeasuredValve, Rest};
use crate::drawing::{Scene, dashed, dotted, sheet};
use crate::methods::shared::drawn_rests::{Follower, overlaps, rests};
use crate::series::{max, min};
use crate::spoken::number;
use stiction_figure::figure::{Figure, Series, colour};

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &MeasuredValve) -> Option<Figure> {
    let vp = scene.segment.vp.as_deref()?;
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
        "Valve position over time and over the OP, at the end of the segment. During a rest the OP travels and the \
         valve does not; a slip ends the rest."
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
            " The straight lines, a dead band of {} % apart, show the position of the moving valve.",
            number(band.median)
        ));
    }
    Some(sheet(caption).columns(2).panel_height(280.0).with(trend).with(map))
}
