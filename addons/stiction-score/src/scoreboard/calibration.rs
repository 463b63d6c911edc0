//! Accuracy of probabilities.

use super::Share;

/// Number of equal parts of the range of probabilities.
const BINS: usize = 10;

/// Probabilities against outcomes.
///
/// Sources: G. W. Brier, Mon. Weather Rev. 78 (1950) 1-3; M. P. Naeini, G. F. Cooper, M. Hauskrecht, Proc.
/// AAAI 29 (2015) 2901-2907 (both recalled, not read).
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Calibration {
    /// Tenths of the range of probabilities, in order; the upper end belongs to the next one.
    pub bins: Vec<Bin>,
    /// Brier score: the mean of `(p - y)^2`, with y = 1 for sticking valves and 0 else. 0 is perfect; a constant
    /// one half gets 0.25.
    pub brier: f64,
    /// Expected calibration error: the mean distance of the observed share from the mean probability of a bin,
    /// weighted by the number in it.
    #[serde(rename = "expected_error")]
    pub error: f64,
    /// How many probabilities there are.
    pub n: usize,
}

/// One tenth of the range of probabilities.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Bin {
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Mean probability in the bin; `None` for an empty bin.
    pub predicted: Option<f64>,
    /// How many of them came true.
    pub observed: Share,
}

impl Calibration {
    /// Calibration of probabilities that a valve sticks, each with the truth; `None` without probabilities. Values
    /// outside 0 to 1 are left out.
    pub fn of(said: impl IntoIterator<Item = (f64, bool)>) -> Option<Self> {
        let mut sums = [(0.0, Share::default()); BINS];
        let (mut squares, mut n) = (0.0, 0);
        for (p, sticks) in said {
            if !(0.0..=1.0).contains(&p) {
                continue;
            }
            let (sum, observed) = &mut sums[((p * BINS as f64) as usize).min(BINS - 1)];
            *sum += p;
            observed.n += 1;
            observed.k += usize::from(sticks);
            squares += (p - f64::from(u8::from(sticks))).powi(2);
            n += 1;
        }
        if n == 0 {
            return None;
        }
        let bins: Vec<Bin> = sums
            .iter()
            .enumerate()
            .map(|(k, (sum, observed))| Bin {
                from: k as f64 / BINS as f64,
                to: (k + 1) as f64 / BINS as f64,
                predicted: (observed.n > 0).then(|| sum / observed.n as f64),
                observed: *observed,
            })
            .collect();
        let distance = |bin: &Bin| {
            Some((bin.predicted? - bin.observed.value()?).abs() * bin.observed.n as f64)
        };
        let error = bins.iter().filter_map(distance).sum::<f64>() / n as f64;
        Some(Self { bins, brier: squares / n as f64, error, n })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_true_as_often_as_was_reported_is_calibrated() {
        // Of each probability k/20 twenty, of which k come true.
        let said = (0..=20).flat_map(|k| (0..20).map(move |i| (f64::from(k) / 20.0, i < k)));
        let found = Calibration::of(said).unwrap();
        assert_eq!((found.n, found.bins.len()), (21 * 20, 10));
        assert!(found.error < 1e-12, "{}", found.error);
        // The mean of p (1 - p).
        let want = (0..=20).map(|k| f64::from(k * (20 - k)) / 400.0).sum::<f64>() / 21.0;
        assert!((found.brier - want).abs() < 1e-12);
        // 1 belongs to the last bin, 0.1 to the second.
        let counts: Vec<usize> = found.bins.iter().map(|bin| bin.observed.n).collect();
        assert_eq!(counts, [40, 40, 40, 40, 40, 40, 40, 40, 40, 60]);
    }

    #[test]
    fn certainty_that_is_right_or_wrong() {
        let right = Calibration::of([(1.0, true), (0.0, false)]).unwrap();
        assert_eq!((right.brier, right.error), (0.0, 0.0));
        let wrong = Calibration::of([(1.0, false), (0.0, true)]).unwrap();
        assert_eq!((wrong.brier, wrong.error), (1.0, 1.0));
        let half = Calibration::of([(0.5, false), (0.5, true)]).unwrap();
        assert_eq!((half.brier, half.error), (0.25, 0.0));
        assert_eq!(half.bins[5].predicted, Some(0.5));
        assert_eq!(half.bins[4].predicted, None);
    }

    #[test]
    fn what_is_no_probability_is_left_out() {
        assert_eq!(Calibration::of([]), None);
        assert_eq!(Calibration::of([(f64::NAN, true), (1.1, false), (-0.1, true)]), None);
    }
}
