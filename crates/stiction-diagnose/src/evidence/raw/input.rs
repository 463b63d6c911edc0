//! The input of the net for a window: signals without units, offsets and directions, at their own rate.

use crate::evidence::Prepared;
use crate::identify::information::{AddedStem, traces};
use crate::series::{max, mean, min, std};

/// Most samples.
pub const LENGTH: usize = 1024;
/// Values per sample.
pub const CHANNELS: usize = 8;
/// Number of values of the whole window.
pub const SCALARS: usize = 8;
/// Fewest samples per period after thinning, if there are as many.
const SAMPLES_PER_PERIOD: f64 = 16.0;
/// Larger values are clipped.
const LARGEST: f64 = 16.0;
/// Amplification of small moves.
const SPREAD: f64 = 20.0;

/// Signals and scalars.
///
/// The window is thinned to at most [`LENGTH`] samples, with at least 16 per period. Of a longer window, the middle is
/// kept. A loop and its mirror image, with OP and PV inverted, are the same loop. So the OP is inverted if its third
/// moment is negative, and the PV if opening the valve lowers it.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// For each sample: OP, PV and PV less SP, and the moves of OP and PV. OP and PV are less their means. Each signal
    /// is divided by its standard deviation. Moves are signed logarithms. Then come the residuals of the PV with valves
    /// that follow and that stick, in standard deviations of the former, and the OP less the likeliest stem, in units
    /// of its S.
    pub values: Vec<[f32; CHANNELS]>,
    /// Logarithms of the standard deviations of the moves of OP and PV, relative to the signals; shares of samples at
    /// rest and at the ends; logarithms of thinning and periods.
    pub scalars: [f32; SCALARS],
}

impl Input {
    /// The input for a window in which stems were searched; `None` if too little can be predicted.
    pub fn of(prepared: &Prepared<'_>, beside: &AddedStem) -> Option<Self> {
        let segment = prepared.segment;
        let pv = segment.pv.as_deref()?;
        let n = pv.len();
        let period = prepared.period * prepared.factor as f64;
        let coarsest = ((period / SAMPLES_PER_PERIOD) as usize).max(1);
        let factor = n.div_ceil(LENGTH).min(coarsest);
        let kept = n.min(LENGTH * factor + 1);
        let part = (n - kept) / 2..(n - kept) / 2 + kept;
        let (op, pv) = (&segment.op[part.clone()], &pv[part.clone()]);
        let net_input = traces(op, pv, factor, beside)?;
        let samples = net_input.op.len();
        let sp = segment.sp.as_ref().map(|sp| &sp[part]);
        let error: Vec<f64> = (0..samples)
            .map(|k| sp.map_or(0.0, |sp| net_input.pv[k] - sp[(k + 1) * factor]))
            .collect();

        let (op_scale, pv_scale) = (std(&net_input.op), std(&net_input.pv));
        if !(op_scale > 0.0 && pv_scale > 0.0) {
            return None;
        }
        let level = mean(&net_input.op);
        let third: f64 = net_input.op.iter().map(|u| ((u - level) / op_scale).powi(3)).sum();
        let of_op = if third < 0.0 { -1.0 } else { 1.0 };
        let of_pv = of_op * prepared.gain_sign;
        let standard = |x: &[f64], scale: f64, sign: f64| -> Vec<f64> {
            let level = mean(x);
            x.iter().map(|v| sign * (v - level) / scale).collect()
        };
        let moves = |x: &[f64]| -> Vec<f64> {
            let spread = |d: f64| d.signum() * (SPREAD * d.abs()).ln_1p();
            let first = std::iter::once(0.0);
            first.chain(x.windows(2).map(|two| spread(two[1] - two[0]))).collect()
        };
        let scaled = |x: &[f64], scale: f64, sign: f64| -> Vec<f64> {
            x.iter().map(|v| sign * v / scale).collect()
        };
        let op = standard(&net_input.op, op_scale, of_op);
        let pv = standard(&net_input.pv, pv_scale, of_pv);
        let left = std(&net_input.follows).max(1e-9);
        let channels: [Vec<f64>; CHANNELS] = [
            scaled(&error, pv_scale, of_pv),
            moves(&op),
            moves(&pv),
            scaled(&net_input.follows, left, of_pv),
            scaled(&net_input.sticks, left, of_pv),
            scaled(&net_input.behind, 1.0, of_op),
            op.clone(),
            pv.clone(),
        ];
        let at = |k: usize| channels.each_ref().map(|c| c[k].clamp(-LARGEST, LARGEST) as f32);
        let scalars = [
            (roughness(&op) + 1e-6).ln(),
            (roughness(&pv) + 1e-6).ln(),
            at_rest(&op),
            at_rest(&pv),
            at_end(&op, min(&op)),
            at_end(&op, max(&op)),
            (factor as f64).ln(),
            (kept as f64 / period).ln(),
        ];
        Some(Self {
            values: (0..samples).map(at).collect(),
            scalars: scalars.map(|v| v.clamp(-LARGEST, LARGEST) as f32),
        })
    }
}

/// Standard deviation of the moves of a signal.
fn roughness(x: &[f64]) -> f64 {
    std(&x.windows(2).map(|two| two[1] - two[0]).collect::<Vec<_>>())
}

/// Share of samples in which a signal does not move.
fn at_rest(x: &[f64]) -> f64 {
    let still = x.windows(2).filter(|two| (two[1] - two[0]).abs() < 1e-9).count();
    still as f64 / x.len().max(1) as f64
}

/// Share of samples at one end of the range.
fn at_end(x: &[f64], end: f64) -> f64 {
    x.iter().filter(|v| (**v - end).abs() < 1e-9).count() as f64 / x.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;
    use crate::evidence::information;
    use crate::recording::Segment;

    /// A wandering OP in short steps, and a PV that lags behind it.
    fn segment(n: usize) -> Segment {
        let mut draws = NormalStream::new(3);
        let (mut slow, mut y) = (0.0, 0.0);
        let op: Vec<f64> = (0..n)
            .map(|k| {
                slow = 0.97 * slow + 0.3 * draws.draw();
                40.0 + slow + 4.0 * (0.1 * k as f64).sin().powi(3).max(-0.3)
            })
            .collect();
        let pv = op.iter().map(|u| {
            y += 0.2 * (u - y);
            y + 0.05 * draws.draw()
        });
        let pv: Vec<f64> = pv.collect();
        Segment {
            from: 0.0,
            sample_time: 1.0,
            sp: Some(vec![38.0; n]),
            pv: Some(pv),
            op,
            vp: None,
            bridged: 0,
        }
    }

    fn net_input(segment: &Segment) -> Input {
        let prepared = Prepared::of(segment).unwrap();
        let period = prepared.period * prepared.factor as f64;
        let told = information::of(&segment.op, segment.pv.as_ref().unwrap(), period).unwrap();
        Input::of(&prepared, &told.added_stem).unwrap()
    }

    #[test]
    fn units_offsets_and_directions_are_ignored() {
        let one = segment(900);
        let turned =
            |x: &Option<Vec<f64>>| x.as_ref().map(|x| x.iter().map(|v| 7.0 - 3.0 * v).collect());
        let others = [
            Segment { pv: turned(&one.pv), sp: turned(&one.sp), ..one.clone() },
            Segment { op: one.op.iter().map(|u| 100.0 - u).collect(), ..one.clone() },
            Segment { sample_time: 30.0, ..one.clone() },
        ];
        let one = net_input(&one);
        for other in others.iter().map(net_input) {
            for (a, b) in one.values.iter().flatten().zip(other.values.iter().flatten()) {
                assert!((a - b).abs() < 2e-3 * a.abs().max(1.0), "{a} {b}");
            }
            assert!(one.scalars.iter().zip(other.scalars).all(|(a, b)| (a - b).abs() < 1e-3));
        }
    }

    #[test]
    fn long_windows_are_thinned_as_far_as_their_period_allows() {
        // A period of 63 samples: up to three in one.
        for (n, factor) in [(900, 1), (1_800, 2), (3_900, 3)] {
            let net_input = net_input(&segment(n));
            assert!(
                (net_input.scalars[6] - (factor as f32).ln()).abs() < 1e-6,
                "{n}: {:?}",
                net_input.scalars
            );
            assert!(
                net_input.values.len() <= LENGTH
                    && net_input.values.len() + 2 >= (n / factor).min(LENGTH)
            );
            assert!(net_input.values.iter().flatten().all(|v| v.abs() <= LARGEST as f32));
        }
    }
}
