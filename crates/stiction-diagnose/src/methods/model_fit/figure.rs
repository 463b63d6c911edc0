//! Figure of the method: PV and OP, and PV and OP of the fitted model.

use super::ModelFitResult;
use crate::drawing::{Scene, sheet};
use crate::spoken::number;
use stiction_figure::figure::{Figure, Legend, Series, colour};

/// The figures of all fits zoom together.
const FITS: &str = "model-fit";

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &ModelFitResult) -> Option<Figure> {
    let found = &found.fit;
    let end = scene.end();
    // A sample of the fit is the mean of several recorded ones, and is drawn in their middle.
    let middle = 0.5 * (found.factor as f64 - 1.0);
    let at = |k: usize| (found.from + k * found.factor) as f64 + middle;
    let shown: Vec<usize> = (0..found.op.len()).filter(|k| at(*k) >= end.start as f64).collect();
    let x = scene.times(shown.iter().map(|k| at(*k)));
    let of = |values: &[f64]| -> Vec<f64> { shown.iter().map(|k| values[*k]).collect() };
    let pv = scene
        .trend("PV (standard deviations)")
        .group(FITS)
        .legend(Legend::Above)
        .with(Series::line("PV", x.clone(), of(&found.pv)).colour(colour::PV))
        .with(Series::line("fitted", x.clone(), of(&found.fitted)).colour(colour::VERMILION));
    let op = scene
        .trend("% of span")
        .group(FITS)
        .legend(Legend::Above)
        .with(Series::line("OP", x.clone(), of(&found.op)).colour(colour::OP))
        .with(Series::steps("valve of the model", x, of(&found.vp)).colour(colour::VP));
    let caption = format!(
        "The PV with the PV of the fitted model, and the OP with the position of its valve: S = {} %, J = {} %.",
        number(found.s),
        number(found.j)
    );
    Some(sheet(caption).with(pv).with(op))
}
