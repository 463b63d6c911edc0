//! The fit windows of a long recording, or of one in several segments.
//!
//! One hour of saturation, one frozen morning or one afternoon of set-point changes makes some windows unfit, but not
//! the whole week. Unfit windows are left out and the others are judged. The program reports both numbers.

use super::oscillations::Oscillations;
use super::steps::Stops;
use crate::evidence::{windows, windows_of_all};
use crate::parallel::*;
use crate::recording::fitness::{self, Class, Fitness, Measure, MeasureId};
use crate::recording::{Grid, Recording, Segment};

/// A measure of the whole recording, unknown to a part of a segment.
const OF_ALL: MeasureId = MeasureId::BridgedSamples;

/// The windows to judge, and the fitness of all of them. They are the fit windows of all segments if there are any,
/// else all windows of the longest segment. `whole` is the fitness of this undivided segment. With one window the
/// result is that window and `whole`.
pub(super) fn fit_windows(
    recording: &Recording,
    grid: &Grid,
    segment: &Segment,
    whole: Fitness,
    stops: Stops<'_>,
) -> (Vec<Segment>, Fitness) {
    let all = windows_of_all(&grid.segments);
    if all.len() < 2 {
        return (all, whole);
    }
    let is_fit = |window: &Segment| {
        if stops() {
            return false;
        }
        let period = Oscillations::of(window).period(window);
        fitness::assess(recording, grid, window, period).class != Class::Unfit
    };
    let fit: Vec<bool> = all.par_iter().map(is_fit).collect();
    let n = all.len();
    let judged: Vec<Segment> =
        all.iter().zip(&fit).filter(|(_, fit)| **fit).map(|(window, _)| window.clone()).collect();
    if judged.is_empty() {
        return (windows(segment), whole);
    }
    let k = judged.len();
    let mut measures = whole.measures;
    for measure in &mut measures {
        if measure.class == Class::Unfit && measure.id != OF_ALL {
            measure.class = Class::Caveats;
            measure.reason += &format!("; {k} of {n} windows are fit");
        }
    }
    let share = 100.0 * k as f64 / n as f64;
    measures.push(Measure {
        id: MeasureId::FitWindows,
        value: Some(share),
        unit: "%",
        caveat_at: Some(100.0),
        unfit_at: None,
        class: if k < n { Class::Caveats } else { Class::Fit },
        reason: match k == n {
            true => format!("all {n} windows are fit"),
            false => format!("{k} of {n} windows are fit, and only these are judged"),
        },
    });
    (judged, Fitness::of(measures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::GridOptions;
    use crate::test_signals::{noise, sine};

    const N: usize = 24_000;

    fn judged(op: &[f64], pv: &[f64]) -> (Fitness, Vec<Segment>, Fitness) {
        let recording = Recording::regular("loop", 1.0, op, Some(pv), None).unwrap();
        let grid = Grid::of(&recording, &GridOptions::default()).unwrap();
        let segment = grid.longest().unwrap();
        let whole = fitness::assess(&recording, &grid, segment, Some(40.0));
        let (windows, fitness) = fit_windows(&recording, &grid, segment, whole.clone(), &|| false);
        (whole, windows, fitness)
    }

    fn signals() -> [Vec<f64>; 2] {
        [1, 2].map(|seed| {
            let noise = noise(N, seed);
            sine(N, 40.0).iter().zip(noise).map(|(s, e)| 50.0 + 5.0 * s + 0.2 * e).collect()
        })
    }

    #[test]
    fn a_sound_record_is_judged_in_all_its_windows() {
        let [op, pv] = signals();
        let (whole, windows, fitness) = judged(&op, &pv);
        assert_eq!((windows.len(), fitness.class), (16, whole.class));
        assert_eq!(fitness.measures.len(), whole.measures.len() + 1);
        assert!(fitness.measures.last().unwrap().reason.starts_with("all 16 windows"));
    }

    #[test]
    fn frozen_hours_cost_their_windows_and_no_more() {
        let [op, mut pv] = signals();
        let held = pv[9_000];
        pv[9_000..22_000].fill(held);
        let (whole, windows, fitness) = judged(&op, &pv);
        assert_eq!((whole.class, fitness.class), (Class::Unfit, Class::Caveats));
        let from: Vec<f64> = windows.iter().map(|window| window.from).collect();
        assert_eq!(from, [0.0, 1_500.0, 3_000.0, 4_500.0, 6_000.0, 7_500.0, 22_500.0]);
        assert!(fitness.reasons.iter().any(|why| why.starts_with("7 of 16 windows")));
    }

    #[test]
    fn without_a_fit_window_nothing_gets_better() {
        let [op, mut pv] = signals();
        pv.fill(20.0);
        let (whole, windows, fitness) = judged(&op, &pv);
        assert_eq!((windows.len(), fitness), (16, whole));
    }

    #[test]
    fn a_short_one_is_its_only_window() {
        let [op, pv] = signals();
        let (whole, windows, fitness) = judged(&op[..2_000], &pv[..2_000]);
        assert_eq!((windows.len(), fitness), (1, whole));
    }
}
