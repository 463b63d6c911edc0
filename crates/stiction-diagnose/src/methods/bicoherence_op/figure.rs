//! Figure of the method: the bicoherence of the OP.

use crate::drawing::{Scene, sheet};
use crate::methods::bicoherence::BicoherencePlane;
use crate::methods::bicoherence::figure::plane;
use stiction_figure::figure::Figure;

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &BicoherencePlane) -> Option<Figure> {
    let (panel, caption) = plane(scene, found, "OP")?;
    Some(sheet(caption).width(480.0).panel_height(300.0).with(panel))
}
