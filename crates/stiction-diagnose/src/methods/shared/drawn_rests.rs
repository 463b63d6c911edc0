//! Rests over time, and in the plot of a follower over the OP.

use super::stuck::StuckSpan;
use crate::drawing::{Scene, thinned};
use crate::series::span;
use std::ops::Range;
use stiction_figure::figure::{Legend, Panel, Series, colour};

/// Largest number of points of a map.
const MOST: usize = 1_500;

/// A signal that follows the valve, with its rests.
pub struct Follower<'a> {
    pub name: &'static str,
    pub label: String,
    pub values: &'a [f64],
    pub rests: Vec<StuckSpan>,
}

/// Whether a rest overlaps some samples.
pub fn overlaps(rest: &StuckSpan, range: &Range<usize>) -> bool {
    rest.first < range.end && rest.end > range.start
}

/// A follower over time and over the OP in some samples, its rests marked.
pub fn rests(
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
