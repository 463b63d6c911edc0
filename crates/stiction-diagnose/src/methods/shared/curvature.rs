//! The second derivative of the PV of an integrating loop, in which a triangle wave shows its corners.

use crate::finding::Abstention;
use crate::methods::subject::Subject;
use crate::series::median;

/// Lag of the second difference, as a share of the period: ours. The corners of a triangle wave then fill a third
/// of the time, and noise is averaged over a twelfth of the period.
pub const LAG_SHARE: f64 = 1.0 / 12.0;

/// The axis of second differences.
#[cfg(feature = "figure")]
pub const LABEL: &str = "second difference of the PV (standard deviations)";

/// Smallest number of lags in a segment: two periods. Ours.
const LEAST_LAGS: usize = 24;

/// Second differences of a PV.
#[derive(Debug, Clone, PartialEq)]
pub struct Curvature {
    /// `p(k - lag) - 2 p(k) + p(k + lag)` of the PV averaged over `lag` samples.
    pub values: Vec<f64>,
    /// The lag, samples.
    pub lag: usize,
    /// Standard deviation of the values from white noise of the PV.
    pub noise: f64,
}

/// Standard deviation of the white noise on a smooth signal: from the median size of its third differences, which
/// corners and jumps do not affect.
fn noise(x: &[f64]) -> f64 {
    let thirds: Vec<f64> =
        x.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs()).collect();
    if thirds.is_empty() { 0.0 } else { 1.4826 * median(&thirds) / 20f64.sqrt() }
}

/// The curvature of a PV without its mean, over a share of the subject's period. Without a period there is none:
/// noise and random walks have any curvature.
pub fn curvature(subject: &Subject<'_>, pv: &[f64]) -> Result<Curvature, Abstention> {
    let period = subject.period.filter(|period| *period > 0.0 && period.is_finite());
    let Some(period) = period else {
        return Err(Abstention("needs an oscillation, and none was detected".to_owned()));
    };
    let lag = ((period * LAG_SHARE).round() as usize).max(1);
    if pv.len() / lag < LEAST_LAGS {
        return Err(Abstention(format!(
            "spans {:.1} periods, but needs {:.0}",
            pv.len() as f64 / period,
            LEAST_LAGS as f64 * LAG_SHARE
        )));
    }
    // Sums of the samples before each.
    let mut sum = 0.0;
    let sums = std::iter::once(0.0).chain(pv.iter().map(|v| {
        sum += v;
        sum
    }));
    let sums: Vec<f64> = sums.collect();
    let average: Vec<f64> =
        sums.iter().zip(&sums[lag..]).map(|(from, to)| (to - from) / lag as f64).collect();
    let (middle, last) = (&average[lag..], &average[2 * lag..]);
    let values = average.iter().zip(middle).zip(last).map(|((a, b), c)| a - 2.0 * b + c).collect();
    // The three averages share no sample.
    Ok(Curvature { values, lag, noise: (6.0 / lag as f64).sqrt() * noise(pv) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{LoopType, Segment};
    use crate::series::std;

    #[test]
    fn noise_is_known_by_itself() {
        let mut stream = crate::closed_loop::NormalStream::new(1);
        let pv: Vec<f64> =
            (0..20_000).map(|k| (f64::from(k) * 0.05).sin() * 1e-3 + 0.1 * stream.draw()).collect();
        assert!((noise(&pv) / 0.1 - 1.0).abs() < 0.03);
        let segment = Segment {
            from: 0.0,
            sample_time: 1.0,
            op: pv.clone(),
            pv: None,
            sp: None,
            vp: None,
            bridged: 0,
        };
        let subject = Subject::new(&segment, LoopType::Level, Some(120.0));
        let found = curvature(&subject, &pv).unwrap();
        assert_eq!(found.lag, 10);
        assert!((std(&found.values) / found.noise - 1.0).abs() < 0.05);
    }
}
