//! Figure of the method: half waves with square wave and sine.

use super::SquareWaveResult;
use crate::drawing::{Scene, dashed, solid};
use crate::methods::shared::drawn_shapes::{Shape, fits, sine};
use crate::series::HalfWave;
use stiction_figure::figure::{Figure, colour};

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &SquareWaveResult) -> Option<Figure> {
    let waves: Vec<HalfWave> = found.waves.iter().map(|each| each.wave).collect();
    let sine = |i: usize, k: f64| sine(&waves[i], found.waves[i].sine, k);
    let shapes = [
        Shape {
            name: "square wave",
            series: solid,
            colour: colour::VERMILION,
            at: &|i, _| found.waves[i].square,
        },
        Shape { name: "sine", series: dashed, colour: colour::BLACK, at: &sine },
    ];
    let lead = "Half waves of the control error with the best square wave and the best sine.";
    let label = scene.context.pv_label("error about its mean");
    fits(scene, lead, &label, &found.error, &waves, &shapes)
}
