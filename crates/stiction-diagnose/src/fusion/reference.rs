//! The features of the training loops, and the distance of a recording from them.

use super::{row, sigmoid};
use crate::error::{Error, Result};

/// Number of quantiles that are kept of every feature.
pub const QUANTILES: usize = 65;

/// Log-odds of the share of loops below the largest quantile: 99.95 %.
const OUTERMOST: f64 = 7.6;

/// The standard deviation of a logistic variable: pi / sqrt 3.
const LOGISTIC: f64 = 1.813_799_364_234_217_8;

/// The largest score.
const MOST: f64 = 6.0;

/// Log-odds of the share of loops below each quantile, at equal distances.
pub fn level(k: usize) -> f64 {
    OUTERMOST * (2.0 * k as f64 / (QUANTILES - 1) as f64 - 1.0)
}

/// One feature in the training loops.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Index among the features.
    pub feature: u16,
    /// The share of loops in which it could not be measured.
    pub missing: f32,
    /// Quantiles, ascending; [`level`] gives the share of loops below each. NaN if it could never be measured.
    pub quantiles: Vec<f32>,
}

/// The training loops: the spread of every feature, and the correlations of features.
///
/// Every feature becomes a score of mean 0 and variance 1: the log-odds of its place among the training loops, over
/// pi / sqrt 3. It is 0 where it cannot be measured. Beyond the outermost quantiles it grows with the logarithm of
/// the excess. The *distance* of a recording is the Mahalanobis distance of its scores, `sqrt(z' (R + ridge)^-1 z)`
/// with their correlations R, in units of a threshold that few training loops exceed. It shows values, and
/// combinations of values, that no training loop had. Above 1 the recording is unlike the training loops.
///
/// Source: P. C. Mahalanobis, Proc. Natl. Inst. Sci. India 2 (1936) 49-55 (recalled, not read).
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The features in use.
    pub spreads: Vec<Spread>,
    /// The lower triangle, row by row, of the inverse of the Cholesky factor of `R + ridge`.
    pub whitening: Vec<f32>,
    /// The distance that corresponds to 1.
    pub threshold: f64,
}

/// An unusual feature of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unlike {
    /// Index among the features.
    pub feature: usize,
    /// Value.
    pub value: f64,
    /// The range of 99 % of the training loops.
    pub range: (f64, f64),
    /// The size of its score.
    pub score: f64,
}

impl Spread {
    /// Log-odds of the share of loops below a value, ties counting half.
    fn log_odds(&self, value: f32) -> f64 {
        let below = self.quantiles.partition_point(|q| *q < value);
        let up_to = self.quantiles.partition_point(|q| *q <= value);
        let last = QUANTILES - 1;
        if below < up_to {
            return 0.5 * (level(below) + level(up_to - 1));
        }
        let between = |a: f32, b: f32| f64::from(value - a) / f64::from(b - a);
        match below {
            0 => -OUTERMOST - self.beyond(self.quantiles[0] - value),
            _ if below > last => OUTERMOST + self.beyond(value - self.quantiles[last]),
            k => {
                let (a, b) = (self.quantiles[k - 1], self.quantiles[k]);
                level(k - 1) + (level(k) - level(k - 1)) * between(a, b)
            }
        }
    }

    /// Addition for an excess over the outermost quantile: its logarithm, in widths of the whole range.
    fn beyond(&self, excess: f32) -> f64 {
        let width = f64::from(self.quantiles[QUANTILES - 1] - self.quantiles[0]);
        let width = width.max(1e-6 * f64::from(self.quantiles[0].abs())).max(1e-12);
        2.0 * (1.0 + 8.0 * f64::from(excess) / width).ln()
    }

    /// Score; 0 where the feature cannot be measured.
    pub fn score(&self, value: f32) -> f64 {
        if !value.is_finite() || self.is_empty() {
            return 0.0;
        }
        (self.log_odds(value) / LOGISTIC).clamp(-MOST, MOST)
    }

    /// Share of the training loops with a value below this one, among loops in which the feature could be measured.
    /// Ties count half. It is `None` without a value.
    pub fn place(&self, value: f64) -> Option<f64> {
        let value = value as f32;
        (value.is_finite() && !self.is_empty()).then(|| sigmoid(self.log_odds(value)))
    }

    /// The value above this share of the loops; NaN without loops.
    pub fn quantile(&self, share: f64) -> f64 {
        let at = (super::confidence::logit(share) / OUTERMOST + 1.0) * 0.5 * (QUANTILES - 1) as f64;
        let at = at.clamp(0.0, (QUANTILES - 1) as f64);
        let k = (at as usize).min(QUANTILES - 2);
        let [a, b] = [k, k + 1].map(|k| f64::from(self.quantiles[k]));
        a + (at - k as f64) * (b - a)
    }

    fn is_empty(&self) -> bool {
        self.quantiles[0].is_nan()
    }

    /// Whether it is valid.
    fn is_sound(&self) -> bool {
        let ascends = self.quantiles.windows(2).all(|two| two[0] <= two[1]);
        let finite = self.quantiles.iter().all(|q| q.is_finite());
        let none = self.quantiles.iter().all(|q| q.is_nan());
        self.quantiles.len() == QUANTILES
            && (none || (ascends && finite))
            && (0.0..=1.0).contains(&self.missing)
    }
}

impl Reference {
    /// Accepts valid references.
    ///
    /// # Errors
    /// If quantiles do not ascend, or have a wrong number, or the numbers of the distance are not finite or have a
    /// wrong number.
    pub fn checked(self) -> Result<Self> {
        let n = self.spreads.len();
        let sound = self.spreads.iter().all(Spread::is_sound)
            && self.whitening.len() == n * (n + 1) / 2
            && self.whitening.iter().all(|v| v.is_finite())
            && self.threshold > 0.0
            && self.threshold.is_finite();
        if sound { Ok(self) } else { Err(Error::Bundle("the training loops are damaged".into())) }
    }

    /// The scores of a [`row`] of features.
    pub fn scores(&self, row: &[f32]) -> Vec<f64> {
        let value = |spread: &Spread| row.get(usize::from(spread.feature)).copied();
        self.spreads.iter().map(|s| s.score(value(s).unwrap_or(f32::NAN))).collect()
    }

    /// The distance of a [`row`] of features from the training loops; above 1 it is unlike them.
    pub fn distance(&self, row: &[f32]) -> f64 {
        let scores = self.scores(row);
        let mut from = &self.whitening[..];
        let mut square = 0.0;
        for k in 0..scores.len() {
            let (weights, rest) = from.split_at(k + 1);
            let white: f64 = weights.iter().zip(&scores).map(|(w, z)| f64::from(*w) * z).sum();
            square += white * white;
            from = rest;
        }
        square.sqrt() / self.threshold
    }

    /// The spread of a feature; `None` if it is not in use.
    pub fn spread(&self, feature: usize) -> Option<&Spread> {
        self.spreads.iter().find(|spread| usize::from(spread.feature) == feature)
    }

    /// The features of a recording outside the range of 99 % of the training loops, the farthest first.
    pub fn unlike(&self, values: &[f64]) -> Vec<Unlike> {
        let row = row(values);
        let mut found: Vec<Unlike> = self
            .spreads
            .iter()
            .zip(self.scores(&row))
            .filter_map(|(spread, score)| {
                let feature = usize::from(spread.feature);
                let value = f64::from(*row.get(feature)?);
                let range = (spread.quantile(0.005), spread.quantile(0.995));
                let out = value < range.0 || value > range.1;
                out.then_some(Unlike { feature, value, range, score: score.abs() })
            })
            .collect();
        found.sort_by(|a, b| b.score.total_cmp(&a.score));
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A feature whose log-odds of place are its value.
    fn logistic(feature: u16) -> Spread {
        let quantiles = (0..QUANTILES).map(|k| level(k) as f32).collect();
        Spread { feature, missing: 0.25, quantiles }
    }

    /// Two that go together with a correlation of 0.6.
    fn pair() -> Reference {
        let spreads = vec![logistic(0), logistic(1)];
        Reference { spreads, whitening: vec![1.0, -0.75, 1.25], threshold: 2.0 }.checked().unwrap()
    }

    #[test]
    fn places_quantiles_and_scores() {
        let spread = logistic(0);
        for x in [-5.0, -0.3, 0.0, 1.7] {
            assert!((spread.place(x).unwrap() - sigmoid(x)).abs() < 1e-6);
            assert!((spread.quantile(sigmoid(x)) - x).abs() < 1e-5);
            assert!((spread.score(x as f32) - x / LOGISTIC).abs() < 1e-6);
        }
        assert_eq!((spread.place(f64::NAN), spread.score(f32::NAN)), (None, 0.0));
        assert!(spread.score(9.0) > OUTERMOST / LOGISTIC && spread.score(1e30) <= MOST);
        // Of values that all tie, one has half of them below it.
        let constant = Spread { quantiles: vec![3.0; QUANTILES], ..spread };
        assert_eq!((constant.place(3.0), constant.quantile(0.3)), (Some(0.5), 3.0));
        assert!(constant.score(3.1) > 4.0 && constant.score(2.9) < -4.0);
    }

    #[test]
    fn a_distance_is_mahalanobis() {
        let unit = |a: f64, b: f64| row(&[a * LOGISTIC, b * LOGISTIC]);
        let expected = |a: f64, b: f64| ((a * a - 1.2 * a * b + b * b) / 0.64).sqrt() / 2.0;
        for (a, b) in [(1.0, 1.0), (1.0, -1.0), (0.0, 2.0)] {
            let found = pair().distance(&unit(a, b));
            assert!((found - expected(a, b)).abs() < 1e-5, "{found}");
        }
        // A combination that none had is further than one of larger values that go together.
        assert!(pair().distance(&unit(1.5, -1.5)) > pair().distance(&unit(2.5, 2.5)));
        assert_eq!(pair().distance(&[f32::NAN, f32::NAN]), 0.0);
    }

    #[test]
    fn what_is_out_of_range_is_named_furthest_first() {
        let found = pair().unlike(&[6.0, -40.0]);
        assert_eq!(found.iter().map(|unlike| unlike.feature).collect::<Vec<_>>(), [1, 0]);
        assert!(found[0].range.0 > -40.0 && found[0].value == -40.0);
        assert!(pair().unlike(&[0.0, f64::NAN]).is_empty());
    }

    #[test]
    fn invalid_requests_are_refused() {
        let damaged = |change: &dyn Fn(&mut Reference)| {
            let mut reference = pair();
            change(&mut reference);
            reference.checked().is_err()
        };
        assert!(damaged(&|r| r.threshold = 0.0));
        assert!(damaged(&|r| r.whitening[1] = f32::NAN));
        assert!(damaged(&|r| r.whitening.truncate(2)));
        assert!(damaged(&|r| r.spreads[0].quantiles[3] = 9.0));
        assert!(damaged(&|r| r.spreads[1].quantiles.truncate(3)));
        assert!(damaged(&|r| r.spreads[1].quantiles[0] = f32::NAN));
        assert!(!damaged(&|r| r.spreads[1].quantiles.fill(f32::NAN)));
    }
}
