//! Episodes of a signal's oscillation.

use crate::series::{half_waves, max, median, quantile};

/// Largest deviation of a half wave from half a period, as a share.
pub const TOLERATED: f64 = 0.5;

/// Smallest peak of a half wave, as a share of the large peaks.
pub const LEAST_PEAK: f64 = 0.4;

/// Fewest half waves of an episode: three periods; fewer are a decaying disturbance.
pub const FEWEST_HALF_WAVES: usize = 6;

/// A time span with oscillation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Episode {
    /// Beginning, s from the first sample.
    pub from_s: f64,
    /// End, s from the first sample.
    pub to_s: f64,
    /// Number of half waves in the time span.
    pub half_waves: usize,
    /// Median height of the half waves, in the signal's units.
    pub amplitude: f64,
}

/// The episodes of an oscillation of that period, in samples, in a series without other frequencies, such as a
/// band-passed one.
///
/// A half wave belongs to the oscillation if its length is within 50 % of half the period. Its height must be at least
/// 40 % of the 0.9 quantile of all heights. Six or more such half waves make an episode, with at most two other
/// consecutive half waves in between. The shares are ours.
pub fn episodes(x: &[f64], period: f64, sample_time: f64) -> Vec<Episode> {
    let waves = half_waves(x);
    let heights: Vec<f64> = waves
        .iter()
        .map(|w| max(&x[w.first..w.end].iter().map(|v| v.abs()).collect::<Vec<_>>()))
        .collect();
    let least = LEAST_PEAK * quantile(&heights, 0.9);
    let belongs: Vec<usize> = (0..waves.len())
        .filter(|&i| {
            (waves[i].length() / (0.5 * period) - 1.0).abs() <= TOLERATED && heights[i] >= least
        })
        .collect();
    let mut found = vec![];
    let mut from = 0;
    for i in 1..=belongs.len() {
        if i < belongs.len() && belongs[i] - belongs[i - 1] <= 3 {
            continue;
        }
        let group = &belongs[from..i];
        from = i;
        if group.len() < FEWEST_HALF_WAVES {
            continue;
        }
        let of_group: Vec<f64> = group.iter().map(|&i| heights[i]).collect();
        found.push(Episode {
            from_s: waves[group[0]].from * sample_time,
            to_s: waves[group[group.len() - 1]].to * sample_time,
            half_waves: group.len(),
            amplitude: median(&of_group),
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oscillation::test_signals::sine;

    #[test]
    fn begin_and_end_of_two_bursts() {
        let mut x = sine(3000, 50.0);
        for (k, v) in x.iter_mut().enumerate() {
            *v *= if (500..1000).contains(&k) || k >= 2000 { 2.0 } else { 0.1 };
        }
        let found = episodes(&x, 50.0, 2.0);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!((found[0].from_s - 1000.0).abs() <= 50.0 && (found[0].to_s - 2000.0).abs() <= 50.0);
        assert!(
            (found[1].from_s - 4000.0).abs() <= 50.0 && (found[1].to_s - 6000.0).abs() <= 100.0
        );
        assert!((found[0].amplitude - 2.0).abs() < 0.01);
        assert!(episodes(&x, 10.0, 1.0).is_empty());
        assert!(episodes(&[], 10.0, 1.0).is_empty());
    }
}
