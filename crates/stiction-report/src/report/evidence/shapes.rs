//! Shapes of half waves, and their areas.

use super::{Scene, dashed, dotted, line_at, sheet, solid};
use crate::report::layout::number;
use crate::report::views::histogram;
use stiction_diagnose::detect::{
    AreaRatioResult, CurveFitResult, RelayFitResult, SquareWaveResult,
};
use stiction_diagnose::series::{HalfWave, max, span};
use stiction_figure::figure::{Annotation, Figure, Legend, Panel, Series, colour};

/// Half waves shown over time.
const SHOWN: usize = 6;
/// Half waves laid over each other at most.
const OVERLAID: usize = 12;
/// Places within a half wave at which it is averaged.
const PLACES: usize = 49;
/// Bars that fill a half wave at most.
const BARS: usize = 48;

/// A shape that was fitted to every half wave.
struct Shape<'a> {
    name: &'static str,
    series: fn(&str, Vec<f64>, Vec<f64>) -> Series,
    colour: usize,
    /// Its value in the half wave of that index at a place, in samples.
    at: &'a dyn Fn(usize, f64) -> f64,
}

pub fn curve_fit(scene: &Scene<'_>, found: &CurveFitResult) -> Option<Figure> {
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

pub fn relay_fit(scene: &Scene<'_>, found: &RelayFitResult) -> Option<Figure> {
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

pub fn square_wave(scene: &Scene<'_>, found: &SquareWaveResult) -> Option<Figure> {
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

fn sine(wave: &HalfWave, amplitude: f64, k: f64) -> f64 {
    let phase = (k - wave.from) / wave.length();
    amplitude * (std::f64::consts::PI * phase).sin()
}

/// So many neighbours from the middle of a list: where they begin and end.
fn middle(count: usize, wanted: usize) -> std::ops::Range<usize> {
    let shown = count.min(wanted);
    let first = (count - shown) / 2;
    first..first + shown
}

/// A few half waves over time with what was fitted to them, and all laid over each other.
fn fits(
    scene: &Scene<'_>,
    lead: &str,
    label: &str,
    values: &[f64],
    waves: &[HalfWave],
    shapes: &[Shape<'_>],
) -> Option<Figure> {
    let shown = middle(waves.len(), SHOWN);
    let (first, last) = (waves.get(shown.start)?.first, waves.get(shown.end.checked_sub(1)?)?.end);
    let signal = scene.samples(
        "recorded",
        values,
        first.saturating_sub(1)..(last + 1).min(values.len()),
        false,
    );
    let mut trend = scene
        .trend(label)
        .height(170.0)
        .legend(Legend::Above)
        .with(signal.colour(colour::SKY))
        .note(Annotation::horizontal_line(0.0, ""));
    for shape in shapes {
        let (mut x, mut y, mut breaks) = (vec![], vec![], vec![]);
        for i in shown.clone() {
            let wave = &waves[i];
            breaks.push(x.len());
            // From crossing to crossing.
            let samples = (wave.first..wave.end).map(|k| k as f64);
            let places: Vec<f64> =
                [wave.from].into_iter().chain(samples).chain([wave.to]).collect();
            y.extend(places.iter().map(|k| (shape.at)(i, *k)));
            x.extend(scene.times(places));
        }
        trend = trend.with((shape.series)(shape.name, x, y).colour(shape.colour).breaks(breaks));
    }

    let overlaid = waves.len().min(OVERLAID);
    let chosen: Vec<usize> = (0..overlaid).map(|i| i * waves.len() / overlaid).collect();
    let share = |place: usize| place as f64 / (PLACES - 1) as f64;
    let upright = |wave: &HalfWave| if wave.above { 1.0 } else { -1.0 };
    let (mut x, mut y, mut breaks) = (vec![], vec![], vec![]);
    let mut average = vec![0.0; PLACES];
    for (i, wave) in waves.iter().enumerate() {
        let drawn = chosen.contains(&i);
        if drawn {
            breaks.push(x.len());
        }
        for (place, sum) in average.iter_mut().enumerate() {
            let value = upright(wave) * between(values, wave.from + share(place) * wave.length());
            *sum += value / waves.len() as f64;
            if drawn {
                x.push(share(place));
                y.push(value);
            }
        }
    }
    let places: Vec<f64> = (0..PLACES).map(share).collect();
    let mut overlay = Panel::new("share of the half wave", label)
        .height(170.0)
        .legend(Legend::Above)
        .with(Series::dotted("half waves", x, y).colour(colour::SKY).breaks(breaks))
        .with(Series::line("their mean", &places[..], average).colour(colour::BLUE));
    for shape in shapes {
        let mut average = vec![0.0; PLACES];
        for (i, wave) in waves.iter().enumerate() {
            for (place, sum) in average.iter_mut().enumerate() {
                let at = wave.from + share(place) * wave.length();
                *sum += upright(wave) * (shape.at)(i, at) / waves.len() as f64;
            }
        }
        let name = format!("mean {}", shape.name);
        overlay = overlay.with((shape.series)(&name, places.clone(), average).colour(shape.colour));
    }
    let caption = format!(
        "{lead} Above: the middle {} of {} half waves. Below: {} half waves turned upright and laid over \
         each other; the means are over all.",
        shown.len(),
        waves.len(),
        overlaid
    );
    Some(sheet(caption).with(trend).with(overlay))
}

/// The value at a place between samples; before the first and beyond the last, theirs.
fn between(values: &[f64], place: f64) -> f64 {
    let last = values.len().saturating_sub(1);
    let place = place.clamp(0.0, last as f64);
    let k = (place as usize).min(last);
    let (a, b) = (values.get(k).copied().unwrap_or(0.0), values.get(k + 1).copied());
    a + (place - k as f64) * (b.unwrap_or(a) - a)
}

pub fn area_ratio(scene: &Scene<'_>, found: &AreaRatioResult) -> Option<Figure> {
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
        // Bars a half wave, since bars reach half-way to their neighbours.
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

    // Ratios of tiny areas know no bounds.
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
                .with(line_at(dotted, "1, as of a sine", 1.0, top).colour(colour::BLACK))
                .with(line_at(dashed, "threshold", found.threshold, top).colour(colour::BLACK))
                .with(
                    line_at(solid, "mean", found.statistic.min(most), top)
                        .colour(colour::VERMILION),
                )
                .legend(Legend::Above),
        );
    }
    let caption = format!(
        "Areas of the control error before and after its peaks, in the middle {} of {} half waves; their \
         ratios in all of them, those above {most} counted there. The mean is {}.",
        shown.len(),
        found.areas.len(),
        number(found.statistic)
    );
    Some(figure.caption(caption))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_samples() {
        let y = [0.0, 2.0, 4.0];
        for (place, want) in [(-1.0, 0.0), (0.5, 1.0), (2.0, 4.0), (9.0, 4.0)] {
            assert_eq!(between(&y, place), want, "{place}");
        }
        assert_eq!(between(&[], 1.0), 0.0);
        assert_eq!((middle(10, 6), middle(3, 6), middle(0, 6)), (2..8, 0..3, 0..0));
    }
}
