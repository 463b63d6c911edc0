//! Figure of the method: the wings of PV and OP.

use super::ButterflyResult;
use crate::drawing::{Scene, sheet, thinned};
use crate::spoken::number;
use stiction_figure::figure::{Annotation, Figure, Panel, Series, colour};

/// Largest number of points of a map.
const MOST: usize = 1_500;

pub(in crate::methods) fn draw(_: &Scene<'_>, found: &ButterflyResult) -> Option<Figure> {
    let ((pv, stride), (distance, _)) = (thinned(&found.pv, MOST), thinned(&found.distance, MOST));
    let panel = Panel::new(
        "PV (standard deviations)",
        "distance of the OP from the previous PV (standard deviations)",
    )
    .with(Series::points("samples", pv, distance).colour(colour::BLUE))
    .note(Annotation::x_band(-0.5, 0.5, "body"));
    let mut caption = format!(
        "A butterfly has two open wings and an empty body between them (shaded), which the PV crosses quickly while \
         the valve slips. The emptiness of the body is W = {}. The wings open by {} and {} standard deviations.",
        number(found.emptiness),
        number(found.openings[0]),
        number(found.openings[1])
    );
    if stride > 1 {
        caption.push_str(&format!(" One sample in {stride} is drawn."));
    }
    Some(sheet(caption).width(620.0).panel_height(300.0).with(panel))
}
