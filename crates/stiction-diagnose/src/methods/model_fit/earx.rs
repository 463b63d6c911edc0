//! An extended ARMAX model: a linear process with a disturbance that wanders.
//!
//! # What it measures
//! How much of a PV is explained by the input, and how much by a possibly non-stationary disturbance.
//!
//! # Assumptions
//! A linear process of low order; a disturbance that wanders slowly, or as fast as `walk` allows.
//!
//! # Equations
//! ```text
//! y(k) = a1 y(k-1) + a2 y(k-2) + b1 x(k-d) + b2 x(k-d-1) + c1 e(k-1) + h(k) + e(k)
//! h(k+1) = h(k) + n(k),    var n = walk var e
//! ```
//! The coefficients and h are estimated together, sample by sample: a Kalman filter whose state is (h, a, b, c), of
//! which only h moves (recursive extended least squares). With the coefficients of the last sample, h is then smoothed
//! over the whole series. The PV is the sum of two parts, both through `1/A`: the part of the input and the part of h.
//! ```text
//! ln L = -1/2 (m ln(mean v^2 / s) + sum ln s)     innovations v, their variances s in units of var e
//! ```
//!
//! # Parameters
//! `walk`, the ratio of variances, 0 for a disturbance that is constant.
//!
//! # Limits
//! A disturbance at the frequency of the oscillation differs from the input's part only by its shape. The first
//! samples, in which the coefficients are learnt, do not count in the likelihood.
//!
//! # Deviations from the paper
//! Recalled, not read. The model is theirs, and the estimation by one Kalman filter and a smoother is ours.
//!
//! # References
//! S. Karra, M. N. Karim, Comprehensive methodology for detection and diagnosis of oscillatory control
//! loops, Control Engineering Practice 17 (2009) 939-956 (recalled, not read).

/// Numbers in the state: h, two of the past, two taps, one error.
const STATES: usize = 6;
/// Variance of the coefficients before the first sample.
const UNKNOWN: f64 = 1e3;
/// Number of samples in which the coefficients are learnt.
const LEARNING: usize = 4 * STATES;

/// A process with its disturbance.
#[derive(Debug, Clone, PartialEq)]
pub struct Earx {
    /// `a1`, `a2`.
    pub past: [f64; 2],
    /// `b1`, `b2`.
    pub taps: [f64; 2],
    /// `c1`.
    pub error: f64,
    /// Variance of the innovations.
    pub variance: f64,
    /// Logarithm of the likelihood, except for a constant.
    pub log_likelihood: f64,
    /// Innovations that count in the estimate.
    pub samples: usize,
    /// The part of the input in the PV.
    pub process: Vec<f64>,
    /// The part of the disturbance in the PV.
    pub disturbance: Vec<f64>,
    /// The PV less the innovations.
    pub predicted: Vec<f64>,
}

/// Fits `y` as the response to `x` of the same length, with orders of one and a delay of at least one sample. It is
/// `None` if the samples are too few or the result is not finite.
pub fn fit(x: &[f64], y: &[f64], delay: usize, walk: f64) -> Option<Earx> {
    let n = y.len();
    let first = (delay + 1).max(2);
    if x.len() != n || n < first + 2 * LEARNING || delay == 0 || !(walk >= 0.0) {
        return None;
    }
    let mut state = [0.0; STATES];
    let mut spread = [[0.0; STATES]; STATES];
    for (i, row) in spread.iter_mut().enumerate() {
        row[i] = UNKNOWN;
    }
    let mut predicted = y.to_vec();
    let (mut error, mut squares, mut logarithms) = (0.0, 0.0, 0.0);
    for k in first..n {
        let known = [1.0, y[k - 1], y[k - 2], x[k - delay], x[k - delay - 1], error];
        let mut toward = [0.0; STATES];
        for (toward, row) in toward.iter_mut().zip(&spread) {
            *toward = row.iter().zip(&known).map(|(p, v)| p * v).sum();
        }
        let s = 1.0 + known.iter().zip(&toward).map(|(v, p)| v * p).sum::<f64>();
        let innovation = y[k] - known.iter().zip(&state).map(|(v, t)| v * t).sum::<f64>();
        for i in 0..STATES {
            state[i] += toward[i] * innovation / s;
            for j in 0..STATES {
                spread[i][j] -= toward[i] * toward[j] / s;
            }
        }
        spread[0][0] += walk;
        error = y[k] - known.iter().zip(&state).map(|(v, t)| v * t).sum::<f64>();
        predicted[k] = y[k] - innovation;
        if k >= first + LEARNING {
            squares += innovation * innovation / s;
            logarithms += s.ln();
        }
    }
    let samples = n - first - LEARNING;
    let variance = squares / samples as f64;
    let [_, a1, a2, b1, b2, c1] = state;

    let mut left = vec![0.0; n];
    for k in first..n {
        left[k] = y[k] - a1 * y[k - 1] - a2 * y[k - 2] - b1 * x[k - delay] - b2 * x[k - delay - 1];
    }
    let wandering = smoothed(&left[first..], walk);
    let (mut process, mut disturbance) = (vec![0.0; n], vec![0.0; n]);
    for k in first..n {
        process[k] =
            a1 * process[k - 1] + a2 * process[k - 2] + b1 * x[k - delay] + b2 * x[k - delay - 1];
        disturbance[k] = a1 * disturbance[k - 1] + a2 * disturbance[k - 2] + wandering[k - first];
    }
    let log_likelihood = -0.5 * (samples as f64 * variance.max(1e-12).ln() + logarithms);
    let all = process.iter().chain(&disturbance).chain(&predicted);
    (log_likelihood.is_finite() && all.clone().all(|v| v.is_finite())).then_some(Earx {
        past: [a1, a2],
        taps: [b1, b2],
        error: c1,
        variance,
        log_likelihood,
        samples,
        process,
        disturbance,
        predicted,
    })
}

/// A random walk in noise of variance one, steps of variance `walk`; a constant if that is 0.
fn smoothed(seen: &[f64], walk: f64) -> Vec<f64> {
    let (mut level, mut variance) = (0.0, UNKNOWN);
    let mut filtered = Vec::with_capacity(seen.len());
    for v in seen {
        let share = variance / (variance + 1.0);
        level += share * (v - level);
        filtered.push((level, share));
        variance = share + walk;
    }
    let mut after = level;
    let mut result: Vec<f64> = (filtered.iter().rev())
        .map(|&(level, variance)| {
            after = level + variance / (variance + walk) * (after - level);
            after
        })
        .collect();
    result.reverse();
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;
    use crate::series::correlation;

    /// PV, input, and the walk added to the process.
    fn wandering(step: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let mut noise = NormalStream::new(4);
        let x: Vec<f64> = (0..1500).map(|k| (0.11 * f64::from(k)).sin() + noise.draw()).collect();
        let (mut y, mut h) = (vec![0.0; 1500], vec![0.0; 1500]);
        for k in 3..1500 {
            h[k] = h[k - 1] + step * noise.draw();
            y[k] = 1.1 * y[k - 1] - 0.3 * y[k - 2]
                + 0.4 * x[k - 2]
                + 0.1 * x[k - 3]
                + h[k]
                + 0.1 * noise.draw();
        }
        (x, y, h)
    }

    #[test]
    fn process_and_walk_are_distinguished() {
        let (x, y, h) = wandering(0.02);
        let found = fit(&x, &y, 2, 0.04).unwrap();
        for (found, known) in found.past.iter().chain(&found.taps).zip([1.1, -0.3, 0.4, 0.1]) {
            assert!((found - known).abs() < 0.06, "{found} {known}");
        }
        let through: Vec<f64> = {
            let mut z = vec![0.0; h.len()];
            for k in 2..h.len() {
                z[k] = 1.1 * z[k - 1] - 0.3 * z[k - 2] + h[k];
            }
            z
        };
        assert!(correlation(&found.disturbance, &through).unwrap() > 0.9);
        assert!((found.variance / 0.01 - 1.0).abs() < 0.2, "{}", found.variance);
    }

    #[test]
    fn the_likelihood_knows_whether_it_wanders() {
        for (step, walks) in [(0.05, true), (0.0, false)] {
            let (x, y, _) = wandering(step);
            let [still, wandering] = [0.0, 0.1].map(|walk| fit(&x, &y, 2, walk).unwrap());
            assert_eq!(wandering.log_likelihood > still.log_likelihood, walks, "{step}");
        }
        assert!(fit(&[1.0; 10], &[1.0; 10], 1, 0.0).is_none());
        assert!(fit(&[1.0; 100], &[1.0; 100], 0, 0.0).is_none());
    }
}
