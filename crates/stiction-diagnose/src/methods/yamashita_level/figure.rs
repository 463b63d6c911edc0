//! Figure of the method: the density of the PV's second derivative.

use super::YamashitaLevelResult;
use crate::drawing::{Scene, histogram, sheet};
use crate::methods::shared::curvature::LABEL;
use crate::series::standardised;
use crate::spoken::number;
use std::f64::consts::{PI, TAU};
use stiction_figure::figure::{Figure, Legend, Panel, Series, colour};

pub(in crate::methods) fn draw(_: &Scene<'_>, found: &YamashitaLevelResult) -> Option<Figure> {
    let values = standardised(&found.curvature)?;
    // Values beyond the axis are counted at its ends.
    let reach = 6.0;
    let inside: Vec<f64> = values.iter().map(|v| v.clamp(-reach, reach)).collect();
    let (x, shares) = histogram(&inside);
    let (first, second) = (*x.first()?, *x.get(1)?);
    let width = second - first;
    let density: Vec<f64> = shares.iter().map(|share| share / 100.0 / width).collect();
    let steps = || (0..=120).map(|i| -4.0 + 8.0 * f64::from(i) / 120.0);
    let gaussian: Vec<f64> = steps().map(|z| (-0.5 * z * z).exp() / TAU.sqrt()).collect();
    // For a sinusoid with standard deviation 1, except for the ends, where it is infinite.
    let sine_x: Vec<f64> = steps().map(|z| 0.245 * z).map(|share| share * 2f64.sqrt()).collect();
    let sine: Vec<f64> = sine_x.iter().map(|z| 1.0 / (PI * (2.0 - z * z).sqrt())).collect();
    let panel = Panel::new(LABEL, "density (per standard deviation)")
        .legend(Legend::Above)
        .with(Series::bars("found", x, density).colour(colour::SKY))
        .with(
            Series::line("Gaussian, excess kurtosis 0", steps().collect::<Vec<_>>(), gaussian)
                .colour(colour::BLACK),
        )
        .with(
            Series::dashed("sinusoid, excess kurtosis −1.5", sine_x, sine)
                .colour(colour::VERMILION),
        );
    let caption = format!(
        "Density of the PV's second derivative. A triangle wave from a sticking valve bends only at the corners, \
         which gives a high middle and long tails, with an excess kurtosis above 0. Here the excess kurtosis is {}. \
         Values beyond six standard deviations are counted at the ends.",
        number(found.statistic)
    );
    Some(sheet(caption).with(panel))
}
