//! Figure of the method: half waves with triangle and sine.

use super::CurveFitResult;
use crate::drawing::{Scene, dashed, solid};
use crate::methods::shared::drawn_shapes::{Shape, fits};
use crate::series::HalfWave;
use stiction_figure::figure::{Figure, colour};

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &CurveFitResult) -> Option<Figure> {
    let waves: Vec<HalfWave> = found.waves.iter().map(|each| each.wave).collect();
    let unit = if found.signal == "PV" { scene.unit() } else { "%" };
    let label = format!("{} about its mean ({unit})", found.signal);
    let shapes = [
        Shape {
            name: "triangle",
            series: solid,
            colour: colour::VERMILION,
            at: &|i, k| found.waves[i].triangle_at(k),
        },
        Shape {
            name: "sine",
            series: dashed,
            colour: colour::BLACK,
            at: &|i, k| found.waves[i].sine_at(k),
        },
    ];
    let lead =
        format!("Half waves of the {} with the best triangle and the best sine.", found.signal);
    fits(scene, &lead, &label, &found.values, &waves, &shapes)
}
