//! The decay of a signal's autocorrelation.

use crate::series::{autocorrelation, max, min, zero_crossings};

/// The decay ratio from which a signal oscillates excessively: Miao & Seborg 1999.
pub const OSCILLATES: f64 = 0.5;

/// The decay ratio of the autocorrelation: near 1 for a lasting oscillation, near 0 for one that ends after a
/// period.
///
/// `R = a / b`: a is the height of the first maximum over the line through the minima beside it, b the depth of the
/// first minimum under the line from lag zero to the first maximum, both measured vertically. For a damped sine it
/// is the decay over half a period. `None` if the autocorrelation has no two minima below zero with a maximum above
/// zero between. The extremes are those between zero crossings, so that noise on the autocorrelation does not count
/// as waves.
///
/// Miao & Seborg 1999, "Automatic detection of excessively oscillatory feedback control loops", IEEE
/// Conference on Control Applications (recalled, not read).
pub fn decay_ratio(x: &[f64]) -> Option<f64> {
    of_autocorrelation(&autocorrelation(x, x.len().saturating_sub(1))?)
}

/// The decay ratio of an autocorrelation from lag zero on.
pub fn of_autocorrelation(lags: &[f64]) -> Option<f64> {
    let crossings = zero_crossings(lags);
    // An incomplete fourth half wave would end before its minimum.
    let [first, second, third, fourth] = crossings.get(..4)? else { return None };
    let lowest = |from: usize, to: usize| extreme(lags, from, to, min);
    let (low, low_value) = lowest(first.next, second.next)?;
    let (high, high_value) = extreme(lags, second.next, third.next, max)?;
    let (next_low, next_value) = lowest(third.next, fourth.next)?;
    let between = |from: (f64, f64), to: (f64, f64), at: f64| {
        from.1 + (to.1 - from.1) * (at - from.0) / (to.0 - from.0)
    };
    let a = high_value - between((low, low_value), (next_low, next_value), high);
    let b = between((0.0, *lags.first()?), (high, high_value), low) - low_value;
    (b > 0.0).then(|| a / b)
}

/// Lag and value of an extreme.
fn extreme(x: &[f64], from: usize, to: usize, of: fn(&[f64]) -> f64) -> Option<(f64, f64)> {
    let part = x.get(from..to)?;
    let value = of(part);
    let place = part.iter().position(|v| *v == value)?;
    Some(((from + place) as f64, value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_sine_keeps_on_and_a_damped_one_decays() {
        let sine: Vec<f64> = (0..4000).map(|k| (TAU * f64::from(k) / 40.0).sin()).collect();
        assert!((decay_ratio(&sine).unwrap() - 1.0).abs() < 0.02);
        // exp(-d lag) cos(lag): half waves shrink by q = exp(-d pi).
        let q: f64 = 0.5;
        let lags: Vec<f64> = (0..2000)
            .map(|k| {
                let angle = f64::from(k) * TAU / 400.0;
                q.powf(angle / (TAU / 2.0)) * angle.cos()
            })
            .collect();
        // a = (q / 2)(1 + q)^2 and b = (1 + q)^2 / 2; the extremes lie a little before their places.
        assert!((of_autocorrelation(&lags).unwrap() - q).abs() < 0.02);
    }

    #[test]
    fn too_short_or_still_has_none() {
        for x in [&[][..], &[1.0, 2.0, 1.0], &[3.0; 50]] {
            assert_eq!(decay_ratio(x), None);
        }
    }
}
