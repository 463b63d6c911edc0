//! Figure of the method: OP over increments of the PV, with the sigmoid.

use super::DamarlaSigmoidResult;
use crate::drawing::{Scene, sheet, thinned};
use crate::series::{max, min};
use crate::spoken::number;
use stiction_figure::figure::{Figure, Legend, Panel, Series, colour};

/// Largest number of points of a map.
const MOST: usize = 1_500;

pub(in crate::methods) fn draw(_: &Scene<'_>, found: &DamarlaSigmoidResult) -> Option<Figure> {
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
