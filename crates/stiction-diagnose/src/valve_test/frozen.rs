//! A signal with noise that is exactly the same for long: a frozen transmitter, or values that were not archived.

use super::weigh::Manual;
use crate::series::noise_std;

/// Fewest equal samples, and the least noise of the other samples in steps of the signal. A coarse signal rests by its
/// steps.
const FEWEST: usize = 20;
const NOISE: f64 = 2.0;

/// The number of samples for which the signal is frozen; `None` for a signal that is not frozen.
pub(super) fn frozen(spells: &[Manual]) -> Option<usize> {
    let values: Vec<f64> = spells.iter().flat_map(|spell| spell.pv.iter().copied()).collect();
    let mut from = 0;
    let runs = values.chunk_by(|a, b| a == b).map(|run| {
        from += run.len();
        (run.len(), from)
    });
    let (longest, end) = runs.max()?;
    let others = [&values[..end - longest], &values[end..]].concat();
    let steps = others.windows(2).map(|two| (two[1] - two[0]).abs()).filter(|step| *step > 0.0);
    let least = steps.fold(f64::INFINITY, f64::min);
    (longest >= FEWEST && others.len() >= FEWEST && noise_std(&others) >= NOISE * least)
        .then_some(longest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;

    #[test]
    fn noise_that_stops_is_frozen_and_coarse_or_noiseless_rest_is_not() {
        let mut noise = NormalStream::new(3);
        let noisy: Vec<f64> = (0..200).map(|_| noise.draw()).collect();
        let of = |pv: Vec<f64>| frozen(&[Manual { pv, before: 0.0, turns: vec![] }]);
        let mut stopped = noisy.clone();
        stopped[50..90].fill(0.3);
        assert_eq!(of(stopped), Some(40));
        assert_eq!(of(noisy.clone()), None);
        assert_eq!(of(noisy.iter().map(|x| (0.4 * x).round()).collect()), None);
        // A valve that does not move, then a step response without noise.
        let answer = |k: i32| if k < 100 { 0.0 } else { 1.0 - (0.02 * f64::from(100 - k)).exp() };
        assert_eq!(of((0..200).map(answer).collect()), None);
    }
}
