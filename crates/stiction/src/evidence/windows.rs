//! The windows in which a long stretch is looked at.
//!
//! A long stretch is not one experiment: sticking comes and goes. It is looked at in up to
//! [`MOST_WINDOWS`] windows, evenly spread, each long enough for many cycles. The model that weighs
//! evidence was trained on such windows.

use crate::recording::Stretch;

/// Windows that are looked at, at most.
const MOST_WINDOWS: usize = 6;
/// Samples of a window, unless its cycles are long.
const WINDOW_SAMPLES: usize = 2_000;
/// Cycles of a window, if they are long.
const WINDOW_CYCLES: f64 = 25.0;

/// The windows of a stretch: itself if it is short, else evenly spread ones, in order of time.
pub fn windows(stretch: &Stretch) -> Vec<Stretch> {
    let n = stretch.len();
    if n <= WINDOW_SAMPLES {
        return vec![stretch.clone()];
    }
    let period = super::recorded_period(stretch).unwrap_or(0.0);
    let length = WINDOW_SAMPLES.max((WINDOW_CYCLES * period).round() as usize).min(n);
    let count = n.div_ceil(length).min(MOST_WINDOWS);
    let last = n - length;
    (0..count)
        .map(|k| {
            let from = if count == 1 { 0 } else { last * k / (count - 1) };
            stretch.part(from, length)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stretch(n: usize, period: f64) -> Stretch {
        let wave = |k: usize| (std::f64::consts::TAU * k as f64 / period).sin();
        Stretch {
            from: 100.0,
            sample_time: 2.0,
            op: (0..n).map(|k| 50.0 + wave(k)).collect(),
            pv: Some((0..n).map(|k| wave(k + 3)).collect()),
            sp: None,
            vp: None,
            bridged: 0,
        }
    }

    #[test]
    fn windows_are_spread_over_the_stretch() {
        assert_eq!(windows(&stretch(2_000, 40.0)).len(), 1);
        let of_long = windows(&stretch(30_000, 40.0));
        assert_eq!(of_long.len(), MOST_WINDOWS);
        assert!(of_long.iter().all(|window| window.len() == WINDOW_SAMPLES));
        assert_eq!(of_long[0].from, 100.0);
        assert_eq!(of_long[5].from, 100.0 + 2.0 * 28_000.0);
        // Long cycles make long windows.
        let of_slow = windows(&stretch(30_000, 500.0));
        assert!(of_slow.len() == 3 && of_slow[0].len() > 12_000, "{}", of_slow[0].len());
    }
}
