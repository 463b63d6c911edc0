//! Periods and amplitudes of simulated cycles.

use crate::error::{Error, Result, all_finite, non_negative, positive};
use crate::simd::Lane;

/// Counts the upward crossings of a level, in `N` signals side by side.
///
/// A crossing counts once the signal rises above `level + band` after it was at or below `level - band`. Its time
/// is interpolated between the two samples around the threshold.
#[derive(Debug, Clone)]
pub(super) struct Crossings<const N: usize> {
    low: Lane<N>,
    high: Lane<N>,
    previous: Lane<N>,
    /// 1 once the signal was at or below `low` since the last crossing, else 0.
    armed: Lane<N>,
    /// On the heap, because it is rarely touched and must not keep the rest from registers.
    counts: Box<Counts<N>>,
}

#[derive(Debug, Clone)]
struct Counts<const N: usize> {
    count: [u32; N],
    first: Lane<N>,
    last: Lane<N>,
}

impl<const N: usize> Crossings<N> {
    pub(super) fn new(level: Lane<N>, band: Lane<N>) -> Self {
        Self {
            low: Lane::from_fn(|l| level[l] - band[l]),
            high: Lane::from_fn(|l| level[l] + band[l]),
            previous: Lane::splat(f64::NAN),
            armed: Lane::splat(0.0),
            counts: Box::new(Counts {
                count: [0; N],
                first: Lane::splat(0.0),
                last: Lane::splat(0.0),
            }),
        }
    }

    /// Records some consecutive samples, the first of which is number `k`. `value` gives the value in a lane.
    #[inline(always)]
    pub(super) fn take<S>(&mut self, k: usize, samples: &[S], value: impl Fn(&S, usize) -> f64) {
        let (mut armed, mut previous) = (self.armed, self.previous);
        for (i, sample) in samples.iter().enumerate() {
            let value: Lane<N> = Lane::from_fn(|l| value(sample, l));
            let crosses: Lane<N> =
                Lane::from_fn(|l| if value[l] > self.high[l] { armed[l] } else { 0.0 });
            let any = crosses.iter().fold(0, |bits, crosses| bits | crosses.to_bits());
            if any != 0 {
                self.counts.add(k + i, crosses.0, previous.0, value.0, self.high.0);
            }
            armed =
                Lane::from_fn(
                    |l| if value[l] <= self.low[l] { 1.0 } else { armed[l] - crosses[l] },
                );
            previous = value;
        }
        (self.armed, self.previous) = (armed, previous);
    }

    /// The mean period in samples, if there were at least three crossings.
    pub(super) fn period(&self, lane: usize) -> Option<f64> {
        let Counts { count, first, last } = &*self.counts;
        let count = count[lane];
        (count >= 3).then(|| (last[lane] - first[lane]) / f64::from(count - 1))
    }
}

impl<const N: usize> Counts<N> {
    /// Notes a crossing of `level` between the samples `k - 1` and `k` where `crosses` is not 0.
    #[cold]
    #[inline(never)]
    fn add(
        &mut self,
        k: usize,
        crosses: [f64; N],
        previous: [f64; N],
        value: [f64; N],
        level: [f64; N],
    ) {
        for l in (0..N).filter(|l| crosses[*l] != 0.0) {
            let part = (level[l] - previous[l]) / (value[l] - previous[l]);
            self.last[l] = k as f64 - 1.0 + part;
            if self.count[l] == 0 {
                self.first[l] = self.last[l];
            }
            self.count[l] += 1;
        }
    }
}

/// Smallest and largest value; both NaN if any value is.
pub(super) fn range(signal: &[f64]) -> (f64, f64) {
    if signal.iter().any(|v| v.is_nan()) {
        return (f64::NAN, f64::NAN);
    }
    signal
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
}

/// Half the peak-to-peak value of `signal` over its last half; NaN if that half contains a NaN.
pub(super) fn half_pp_of_last_half(signal: &[f64]) -> f64 {
    let (low, high) = range(&signal[signal.len() / 2..]);
    if signal.is_empty() { 0.0 } else { (high - low) / 2.0 }
}

/// The mean period of `signal`, sampled every `sample_time` seconds: the mean time between upward
/// crossings of the middle of its range. `None` if there are fewer than three.
///
/// `noise_band` is the distance by which the signal must fall below and rise above the middle for a crossing to count
/// (in the signal's units, 0 for a clean signal). Three standard deviations of the noise are a good choice.
///
/// # Errors
/// If the signal is empty or not finite, `sample_time` not positive, or `noise_band` negative.
pub fn period(signal: &[f64], sample_time: f64, noise_band: f64) -> Result<Option<f64>> {
    positive("sample time", sample_time)?;
    non_negative("noise band", noise_band)?;
    all_finite("signal", signal)?;
    if signal.is_empty() {
        return Err(Error::Length { name: "signal", found: 0, expected: 1 });
    }
    let (low, high) = range(signal);
    let mut crossings = Crossings::new(Lane([(low + high) / 2.0]), Lane([noise_band]));
    crossings.take(0, signal, |value, _| *value);
    Ok(crossings.period(0).map(|samples| samples * sample_time))
}
