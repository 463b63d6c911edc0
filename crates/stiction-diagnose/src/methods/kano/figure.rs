//! Figure of the method: the signal behind the valve over time and over the OP, with its rests.

use super::KanoResult;
use crate::drawing::{Scene, sheet};
use crate::methods::shared::drawn_rests::{Follower, rests};
use crate::spoken::number;
use stiction_figure::figure::Figure;

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &KanoResult) -> Option<Figure> {
    let (label, values) = match found.follower {
        "VP" => ("VP (% of span)".to_owned(), scene.segment.vp.as_deref()?),
        _ => (scene.context.pv_label("PV"), scene.pv()),
    };
    let follower = Follower { name: found.follower, label, values, rests: found.rests.clone() };
    let (trend, map) = rests(scene, &follower, &scene.end())?;
    let caption = format!(
        "{} over time and over the OP, at the end of the segment, with its rests while the OP travels. Over the \
         whole segment, the rests are {} of all samples. A parallelogram {} % of OP wide explains {} % of the \
         variance, and a straight line {} %.",
        follower.name,
        number(found.statistic),
        number(found.width),
        number(100.0 * found.explained),
        number(100.0 * found.explained_without)
    );
    Some(sheet(caption).columns(2).panel_height(280.0).with(trend).with(map))
}
