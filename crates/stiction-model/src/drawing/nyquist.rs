//! The Nyquist figure of a loop with a sticking valve, which shows the cycles found by harmonic balance.

use crate::Bands;
use crate::error::Result;
use crate::limit_cycle::{
    ContinuousLoop, Cycle, DescribingFunction, FrequencyResponse, harmonic_balance,
};
use stiction_figure::figure::{Annotation, Figure, Legend, Panel, Series, colour};

/// Maximum number of slips per stroke that are drawn.
const SLIPS: usize = 3;
/// Points of a curve.
const POINTS: usize = 400;

/// The frequency response `L(jw)` of `continuous` and `-1/N(X)` of its valve for several ratios `J/S`, with `S` of
/// the loop. Cycles are marked at the intersections, with their periods.
///
/// A valve that moves in steps has a curve for each number of slips per stroke. The first three are drawn.
///
/// # Errors
/// If the loop has no frequency response, or the valve model does not allow a ratio.
pub fn nyquist(title: &str, continuous: &ContinuousLoop, ratios: &[f64]) -> Result<Figure> {
    let response = FrequencyResponse::of(continuous)?;
    let s = continuous.bands.s();
    let mut cycles: Vec<(f64, f64, Cycle)> = vec![];
    let mut valves = vec![];
    for ratio in ratios {
        let bands = Bands::from_s_j(s, ratio * s)?;
        let valve = DescribingFunction::new(continuous.model, bands)?;
        let with = ContinuousLoop { bands, ..continuous.clone() };
        for cycle in harmonic_balance(&with)?.cycles() {
            let at = response.at(2.0 * std::f64::consts::PI / cycle.period_s);
            cycles.push((at.re, at.im, cycle.clone()));
        }
        valves.push((ratio, valve));
    }

    let window = Window::of(&cycles);
    let mut panel = Panel::new("real part", "imaginary part")
        .x_range(window.x.0, window.x.1)
        .y_range(window.y.0, window.y.1)
        .legend(Legend::Above)
        .note(Annotation::horizontal_line(0.0, ""))
        .note(Annotation::vertical_line(0.0, ""));
    let (x, y, breaks) = window.shown(frequencies(&response, &window).into_iter().map(|w| {
        let value = response.at(w);
        Some((value.re, value.im))
    }));
    panel = panel.with(Series::line("L(j\u{3c9})", x, y).colour(colour::BLACK).breaks(breaks));
    for (ratio, valve) in valves {
        let points = (1..=SLIPS).flat_map(|slips| minus_inverse(&valve, slips));
        let (x, y, breaks) = window.shown(points);
        if !x.is_empty() {
            let label = format!("\u{2212}1/N(X), J/S = {ratio}");
            panel = panel.with(Series::line(label, x, y).breaks(breaks));
        }
    }
    panel = panel.with(Series::points("\u{2212}1", [-1.0], [0.0]).colour(colour::BLACK));
    for (stable, label, colour) in
        [(true, "stable cycle", colour::VERMILION), (false, "unstable cycle", colour::BLUE)]
    {
        let of: Vec<_> = cycles.iter().filter(|cycle| cycle.2.stable == stable).collect();
        if of.is_empty() {
            continue;
        }
        let (x, y): (Vec<f64>, Vec<f64>) = of.iter().map(|cycle| (cycle.0, cycle.1)).unzip();
        panel = panel.with(Series::points(label, x, y).colour(colour));
    }
    let aside = 0.09 * (window.x.1 - window.x.0);
    for (x, y, cycle) in &cycles {
        let text = format!("T = {:.3} s", cycle.period_s);
        panel = panel.note(Annotation::text(text, (x - aside, *y)));
    }
    let caption = format!(
        "Frequency response of the loop, and -1/N of its valve ({}, S = {s} %), where N is the describing function. \
         The amplitude X of the OP grows from the value at which the valve begins to move, towards -1. An \
         intersection predicts a limit cycle.",
        continuous.model.describe().name
    );
    Ok(Figure::new(title).caption(caption).panel_height(480.0).with(panel))
}

/// -1/N along the amplitudes of a branch; `None` ends it.
fn minus_inverse(valve: &DescribingFunction, slips: usize) -> Vec<Option<(f64, f64)>> {
    let Some(branch) = valve.branch(slips) else { return vec![] };
    let amplitude = |k: usize| {
        let t = k as f64 / POINTS as f64;
        if branch.to.is_finite() {
            branch.from + (branch.to - branch.from) * t * t
        } else {
            let ratio = t / (1.01 - t);
            branch.from.max(1e-3) * (1.0 + ratio * ratio)
        }
    };
    let point = |k: usize| {
        let value = -1.0 / valve.with_slips(slips, amplitude(k)).ok()?;
        Some((value.re, value.im))
    };
    (1..=POINTS).map(point).chain([None]).collect()
}

/// Frequencies at which L passes through `window`.
fn frequencies(response: &FrequencyResponse, window: &Window) -> Vec<f64> {
    let size = window.x.0.hypot(window.y.0);
    let of = |gain: f64| response.crossovers(gain).unwrap_or_default();
    let low = of(2.0 * size).first().copied().unwrap_or(1e-3);
    let high = of(0.02).last().copied().unwrap_or(1e3 * low).max(10.0 * low);
    let last = (4 * POINTS) as f64;
    (0..=4 * POINTS).map(|k| low * (high / low).powf(k as f64 / last)).collect()
}

/// The visible part of the plane.
struct Window {
    x: (f64, f64),
    y: (f64, f64),
}

impl Window {
    /// A window with -1, the origin and all cycles, and a margin.
    fn of(cycles: &[(f64, f64, Cycle)]) -> Self {
        let (mut x, mut y) = ((-1.0_f64, 0.0_f64), (-1.0_f64, 0.0_f64));
        for (re, im, _) in cycles {
            (x.0, x.1) = (x.0.min(*re), x.1.max(*re));
            (y.0, y.1) = (y.0.min(*im), y.1.max(*im));
        }
        let (wide, high) = (x.1 - x.0, y.1 - y.0);
        Self {
            x: (x.0 - 0.35 * wide, x.1 + 0.15 * wide),
            y: (y.0 - 0.15 * high, y.1 + 0.12 * high),
        }
    }

    /// The points within the window and slightly beyond, with the interruptions of the line.
    fn shown(
        &self,
        points: impl IntoIterator<Item = Option<(f64, f64)>>,
    ) -> (Vec<f64>, Vec<f64>, Vec<usize>) {
        let near = |value: f64, range: (f64, f64)| {
            let room = 0.5 * (range.1 - range.0);
            value >= range.0 - room && value <= range.1 + room
        };
        let (mut x, mut y, mut breaks) = (vec![], vec![], vec![]);
        let mut apart = false;
        for point in points {
            match point {
                Some(point) if near(point.0, self.x) && near(point.1, self.y) => {
                    if apart && !x.is_empty() {
                        breaks.push(x.len());
                    }
                    apart = false;
                    x.push(point.0);
                    y.push(point.1);
                }
                _ => apart = true,
            }
        }
        (x, y, breaks)
    }
}

#[cfg(test)]
mod tests {
    use super::nyquist;
    use crate::Bands;
    use crate::closed_loop::{Controller, Process};
    use crate::limit_cycle::ContinuousLoop;
    use crate::valve::Model;

    fn paper(model: Model) -> ContinuousLoop {
        let controller = Controller::pi(1.1, 2.5).unwrap();
        let process = Process::first_order(1.5, 5.93, 1.07).unwrap();
        ContinuousLoop::new(controller, process, model, Bands::from_s_j(5.0, 3.0).unwrap())
    }

    #[test]
    fn cycles_are_marked_with_their_periods() {
        let ratios = [0.0, 0.2, 0.6, 1.0];
        let svg = nyquist("Nyquist", &paper(Model::TwoPhase), &ratios).unwrap().svg().unwrap();
        for wanted in ["T = 35.093 s", "T = 19.229 s", "T = 14.231 s", "J/S = 0.6", "stable cycle"]
        {
            assert!(svg.contains(wanted), "{wanted}");
        }
        assert!(!svg.contains("unstable cycle"));
    }

    #[test]
    fn a_loop_without_cycles_is_drawn_too() {
        assert!(nyquist("", &paper(Model::Ideal), &[0.0]).unwrap().svg().is_ok());
        assert!(nyquist("", &paper(Model::He), &[0.4]).unwrap().svg().is_ok());
        assert!(nyquist("", &paper(Model::TwoPhase), &[-1.0]).is_err());
    }
}
