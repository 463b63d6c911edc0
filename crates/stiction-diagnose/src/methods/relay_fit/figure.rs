//! Figure of the method: half waves with the response to a relay, triangle and sine.

use super::RelayFitResult;
use crate::drawing::{Scene, dashed, dotted, solid};
use crate::methods::shared::drawn_shapes::{Shape, fits, sine};
use crate::series::HalfWave;
use stiction_figure::figure::{Figure, colour};

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &RelayFitResult) -> Option<Figure> {
    let waves: Vec<HalfWave> = found.waves.iter().map(|each| each.wave).collect();
    let sine = |i: usize, k: f64| sine(&waves[i], found.waves[i].sine, k);
    let shapes = [
        Shape {
            name: "relay response",
            series: solid,
            colour: colour::VERMILION,
            at: &|i, k| found.waves[i].relay.at(&waves[i], k),
        },
        Shape {
            name: "triangle",
            series: dotted,
            colour: colour::PURPLE,
            at: &|i, k| found.waves[i].triangle.at(&waves[i], k),
        },
        Shape { name: "sine", series: dashed, colour: colour::BLACK, at: &sine },
    ];
    let lead = "Half waves of the PV with the best response of a process to a relay, the best triangle \
                and the best sine.";
    let label = scene.context.pv_label("PV about its mean");
    fits(scene, lead, &label, &found.values, &waves, &shapes)
}
