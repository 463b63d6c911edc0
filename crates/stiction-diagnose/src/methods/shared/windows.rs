//! Common parts of the windowed methods: moments of a window, and OP travel in sticky runs.

use crate::series::quantile;

/// Number, sum and squared deviation of a window's samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Arithmetic mean.
    pub mean: f64,
    /// Sum of the squared distances from the mean; exactly zero for equal samples.
    pub squares: f64,
}

impl Moments {
    /// The moments of `x`, which is not empty.
    pub fn of(x: &[f64]) -> Self {
        // Relative to the first sample, so that a constant window has no spread by rounding.
        let n = x.len() as f64;
        let (mut sum, mut squares) = (0.0, 0.0);
        for v in x {
            let d = v - x[0];
            sum += d;
            squares += d * d;
        }
        Self { mean: x[0] + sum / n, squares: (squares - sum * sum / n).max(0.0) }
    }
}

/// OP travel, `|first - last|`, in each run of neighbouring marked windows of `window` samples.
pub fn op_travel(op: &[f64], marked: &[bool], window: usize) -> Vec<f64> {
    let mut travels = vec![];
    let mut from = None;
    for i in 0..=marked.len() {
        let here = marked.get(i).copied().unwrap_or(false);
        match (from, here) {
            (None, true) => from = Some(i * window),
            (Some(first), false) => {
                travels.push((op[first] - op[i * window - 1]).abs());
                from = None;
            }
            _ => {}
        }
    }
    travels
}

/// The 95 % quantile of `travels`; `None` for an empty list.
pub fn percentile_95(travels: &[f64]) -> Option<f64> {
    (!travels.is_empty()).then(|| quantile(travels, 0.95))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_measured_from_their_first_sample_to_their_last() {
        let op: Vec<f64> = (0..10).map(f64::from).collect();
        assert_eq!(op_travel(&op, &[true, true, false, false, true], 2), [3.0, 1.0]);
        assert!(op_travel(&op, &[false; 5], 2).is_empty());
        assert_eq!(percentile_95(&[]), None);
        let m = Moments::of(&[0.1; 8]);
        assert_eq!((m.mean, m.squares), (0.1, 0.0));
    }
}
