//! Figure of the method: the areas of half waves before and after their peaks.

use super::AreaRatioResult;
use crate::drawing::{Scene, dashed, dotted, histogram, line_at, sheet, solid};
use crate::methods::shared::drawn_shapes::{SHOWN, middle};
use crate::series::{max, span};
use crate::spoken::number;
use stiction_figure::figure::{Annotation, Figure, Legend, Panel, Series, colour};

/// Largest number of bars in a half wave.
const BARS: usize = 48;

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &AreaRatioResult) -> Option<Figure> {
    let shown = &found.areas[middle(found.areas.len(), SHOWN)];
    let (first, last) = (shown.first()?.wave.first, shown.last()?.wave.end);
    let range = first.saturating_sub(1)..(last + 1).min(found.error.len());
    let mut trend = scene
        .trend(scene.context.pv_label("error"))
        .height(170.0)
        .legend(Legend::Above)
        .note(Annotation::horizontal_line(0.0, ""))
        .with(scene.samples("error", &found.error, range, false).colour(colour::BLACK));
    for (name, colour, before) in [
        ("area before the peak", colour::VERMILION, true),
        ("area after the peak", colour::SKY, false),
    ] {
        // Bars reach half-way to their neighbours, so they fill a half wave.
        let mut label = name;
        for each in shown {
            let wave = &each.wave;
            let stride = (wave.end - wave.first).div_ceil(BARS).max(1);
            let side = |k: &usize| (*k < each.peak) == before;
            let samples: Vec<usize> = (wave.first..wave.end).step_by(stride).filter(side).collect();
            if samples.len() > 1 {
                let x = scene.times(samples.iter().map(|k| *k as f64));
                let y: Vec<f64> = samples.iter().map(|k| found.error[*k]).collect();
                trend = trend.with(Series::bars(label, x, y).colour(colour));
                label = "";
            }
        }
    }
    let peaks: Vec<f64> = shown.iter().map(|each| found.error[each.peak]).collect();
    trend = trend.with(
        Series::points("peaks", scene.times(shown.iter().map(|each| each.peak as f64)), peaks)
            .colour(colour::BLACK),
    );

    // Ratios of tiny areas have no bounds.
    let most = (2.0 * found.statistic).clamp(4.0, 40.0).ceil();
    let ratios: Vec<f64> = found
        .areas
        .iter()
        .map(|each| (each.before / each.after).min(most))
        .filter(|ratio| ratio.is_finite())
        .collect();
    let mut figure = sheet("").with(trend);
    if span(&ratios) > 0.0 {
        let (x, shares) = histogram(&ratios);
        let top = max(&shares);
        figure = figure.with(
            Panel::new("area before the peak over area after it", "share of the half waves (%)")
                .height(120.0)
                .with(Series::bars("half waves", x, shares).colour(colour::BLUE))
                .with(line_at(dotted, "1 (a sine)", 1.0, top).colour(colour::BLACK))
                .with(line_at(dashed, "threshold", found.threshold, top).colour(colour::BLACK))
                .with(
                    line_at(solid, "mean", found.statistic.min(most), top)
                        .colour(colour::VERMILION),
                )
                .legend(Legend::Above),
        );
    }
    let caption = format!(
        "Areas of the control error before and after its peaks, in the middle {} of {} half waves, and the ratios \
         of all half waves. Ratios above {most} are drawn at {most}. The mean is {}.",
        shown.len(),
        found.areas.len(),
        number(found.statistic)
    );
    Some(figure.caption(caption))
}
