//! The probability that a valve sticks, from a test and from the operation before it.
//!
//! # Equations
//! ```text
//! t = logit(p_valve + p_elsewhere / 2)
//! u = m tanh(t / m)                         m = ln(1 / (1 - r)) if t > 0, 8 otherwise
//! logit p_test = a + b u                    logit p = a + b u + c logit p_operation
//! ```
//! `p_valve` and `p_elsewhere` are the posterior probabilities of a dead band in the valve and downstream of it. A test
//! hardly separates the two, so half of the second counts. The likelihoods assume a linear process and a load that goes
//! on as before. So the certainty of sticking is limited by the correlation `r` of the responses with the responses of
//! the likeliest valve. Operation misses more sticking valves than its probability says, because this is the
//! probability of sticking that a recording can show. So the weight of this probability is below 1. No probability is
//! below 1 % or above 99 %, because no more tests bear it out (docs/accuracy-tests.md).
//!
//! # Source
//! Ours. `a`, `b` and `c` are a logistic regression of 2,658 simulated tests of the population (`stiction-train --n 2400
//! --seed 41000 tests`).

use super::weigh::Weighed;
use crate::fusion::{logit, sigmoid};

/// The largest log-odds of a valve that follows, before calibration.
const MOST: f64 = 8.0;
/// Bounds of the correlation `r`.
const AGREEMENT: (f64, f64) = (0.2, 0.9999);
/// Bounds of every probability.
pub(super) const BORNE_OUT: [f64; 2] = [0.01, 0.99];
/// The share of a dead band downstream of the valve that counts as one in the valve.
const SHARED: f64 = 0.5;
/// `a` and `b` of a test without operation before it.
const ALONE: [f64; 2] = [0.164, 0.998];
/// `a`, `b` and `c` of a test with operation before it.
const JOINED: [f64; 3] = [0.99, 0.894, 0.648];

/// Log-odds `u` of a test before calibration.
pub(super) fn log_odds(test: &Weighed) -> f64 {
    limited(test.sticks + SHARED * test.elsewhere, test.sticking_seen.fits)
}

fn limited(p: f64, agreement: f64) -> f64 {
    let t = odds(p);
    let most = match t > 0.0 {
        true => -(1.0 - agreement.clamp(AGREEMENT.0, AGREEMENT.1)).ln(),
        false => MOST,
    };
    most * (t / most).tanh()
}

/// The probability that the valve sticks, from the log-odds `u` of a test alone.
pub(super) fn of_test(u: f64) -> f64 {
    let [a, b] = ALONE;
    borne_out(a + b * u)
}

/// The probability from the test and, if known, the probability from operation.
pub(super) fn joined(u: f64, operation: Option<f64>) -> f64 {
    let [a, b, c] = JOINED;
    operation.map_or_else(|| of_test(u), |p| borne_out(a + b * u + c * odds(p)))
}

fn borne_out(log_odds: f64) -> f64 {
    sigmoid(log_odds).clamp(BORNE_OUT[0], BORNE_OUT[1])
}

/// Log-odds of a probability, limited to finite values.
fn odds(p: f64) -> f64 {
    logit(p.clamp(1e-9, 1.0 - 1e-9))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_is_as_certain_as_its_answers_agree() {
        for (agreement, most) in [(0.5, 0.75), (0.9, 0.95), (0.95, 0.97), (1.0, 0.99)] {
            let p = of_test(limited(1.0, agreement));
            assert!(most - 0.1 < p && p <= most, "{agreement}: {p}");
        }
        assert_eq!(of_test(limited(0.0, 0.9)), BORNE_OUT[0]);
        // A dead band that is surely elsewhere leaves the valve open.
        assert!((0.3..0.7).contains(&of_test(limited(SHARED, 0.99))));
    }

    #[test]
    fn more_evidence_for_sticking_is_a_higher_probability() {
        let shares: Vec<f64> = (0..=20).map(|k| f64::from(k) / 20.0).collect();
        let rises = |of: &dyn Fn(f64) -> f64| {
            let all: Vec<f64> = shares.iter().map(|p| of(*p)).collect();
            assert!(all.windows(2).all(|two| two[0] < two[1]), "{all:?}");
        };
        rises(&|p| limited(p, 0.95));
        rises(&|p| joined(limited(0.3 + 0.4 * p, 0.95), Some(0.4)));
        rises(&|p| joined(limited(0.5, 0.95), Some(0.02 + 0.96 * p)));
    }

    /// Operation whose probability is low counts for less than a test that is as sure of the opposite.
    #[test]
    fn a_test_outvotes_operation() {
        let (yes, no) = (limited(0.98, 0.99), limited(0.02, 0.5));
        assert!(joined(yes, Some(0.02)) > 0.5 && joined(no, Some(0.98)) < 0.8);
    }
}
