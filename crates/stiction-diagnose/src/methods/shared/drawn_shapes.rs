//! Half waves over time and overlaid, with their fits.

use crate::drawing::{Scene, sheet};
use crate::series::HalfWave;
use std::ops::Range;
use stiction_figure::figure::{Annotation, Figure, Legend, Panel, Series, colour};

/// Half waves shown over time.
pub const SHOWN: usize = 6;

/// Most overlaid half waves.
const OVERLAID: usize = 12;

/// Number of averaged points in a half wave.
const PLACES: usize = 49;

/// A shape fitted to every half wave.
pub struct Shape<'a> {
    pub name: &'static str,
    pub series: fn(&str, Vec<f64>, Vec<f64>) -> Series,
    pub colour: usize,
    /// Value in the half wave of that index, at a position in samples.
    pub at: &'a dyn Fn(usize, f64) -> f64,
}

/// A half sine over a half wave.
pub fn sine(wave: &HalfWave, amplitude: f64, k: f64) -> f64 {
    let phase = (k - wave.from) / wave.length();
    amplitude * (std::f64::consts::PI * phase).sin()
}

/// Begin and end of this many neighbours from the middle of a list.
pub fn middle(count: usize, wanted: usize) -> Range<usize> {
    let shown = count.min(wanted);
    let first = (count - shown) / 2;
    first..first + shown
}

/// A few half waves over time with their fits, and all overlaid.
pub fn fits(
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
        "{lead} Above: the middle {} of {} half waves. Below: {} half waves turned upright and overlaid, with the \
         means of all.",
        shown.len(),
        waves.len(),
        overlaid
    );
    Some(sheet(caption).with(trend).with(overlay))
}

/// The value between samples; before the first and beyond the last, theirs.
fn between(values: &[f64], place: f64) -> f64 {
    let last = values.len().saturating_sub(1);
    let place = place.clamp(0.0, last as f64);
    let k = (place as usize).min(last);
    let (a, b) = (values.get(k).copied().unwrap_or(0.0), values.get(k + 1).copied());
    a + (place - k as f64) * (b.unwrap_or(a) - a)
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
