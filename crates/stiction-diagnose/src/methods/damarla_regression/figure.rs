//! Figure of the method: windows by the slopes of OP and PV.

use super::DamarlaRegressionResult;
use crate::drawing::Scene;
use crate::methods::shared::drawn_windows::marked;
use crate::spoken::number;
use stiction_figure::figure::Figure;

pub(in crate::methods) fn draw(
    scene: &Scene<'_>,
    found: &DamarlaRegressionResult,
) -> Option<Figure> {
    let lead = format!(
        "In the shaded windows of {} samples, the OP's slope is at least {} times the PV's slope, both in standard \
         deviations",
        found.window,
        number(found.eta)
    );
    marked(scene, &lead, &found.sticky, found.window)
}
