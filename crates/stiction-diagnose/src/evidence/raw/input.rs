//! What the net hears of a window: signals without units, offsets and directions, at their own pace.

use crate::evidence::Prepared;
use crate::identify::information::{Beside, traces};
use crate::series::{max, mean, min, std};

/// Samples, at most.
pub const LENGTH: usize = 1024;
/// Numbers a sample.
pub const CHANNELS: usize = 8;
/// Numbers of the whole.
pub const SCALARS: usize = 8;
/// Samples that thinning leaves a period, where there are so many.
const SAMPLES_PER_PERIOD: f64 = 16.0;
/// Larger values are cut.
const LARGEST: f64 = 16.0;
/// How strongly small moves are spread.
const SPREAD: f64 = 20.0;

/// Signals and what stands beside them.
///
/// The window is thinned to at most [`LENGTH`] samples, but not so far that a period keeps fewer than 16; of what
/// is longer still the middle is kept. A loop and its mirror image, OP and PV turned over, are the same loop: the OP
/// is turned so that its third moment is not below zero, the PV so that opening the valve raises it.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// Sample by sample: OP and PV about their means in standard deviations, PV less SP in those of the PV, signed
    /// logarithms of the moves of OP and PV, what valves that follow and that stick leave of the PV, in standard
    /// deviations of the former, and the OP less the likeliest stem, in units of its S.
    pub values: Vec<[f32; CHANNELS]>,
    /// Logarithms of the standard deviations of the moves of OP and PV in those of the signals, shares of samples at
    /// rest and at the ends, logarithms of thinning and periods.
    pub scalars: [f32; SCALARS],
}

impl Input {
    /// What is heard of a window in which stems were searched; `None` where too little can be predicted.
    pub fn of(prepared: &Prepared<'_>, beside: &Beside) -> Option<Self> {
        let segment = prepared.segment;
        let pv = segment.pv.as_deref()?;
        let n = pv.len();
        let period = prepared.period * prepared.factor as f64;
        let coarsest = ((period / SAMPLES_PER_PERIOD) as usize).max(1);
        let factor = n.div_ceil(LENGTH).min(coarsest);
        let kept = n.min(LENGTH * factor + 1);
        let part = (n - kept) / 2..(n - kept) / 2 + kept;
        let (op, pv) = (&segment.op[part.clone()], &pv[part.clone()]);
        let heard = traces(op, pv, factor, beside)?;
        let samples = heard.op.len();
        let sp = segment.sp.as_ref().map(|sp| &sp[part]);
        let error: Vec<f64> =
            (0..samples).map(|k| sp.map_or(0.0, |sp| heard.pv[k] - sp[(k + 1) * factor])).collect();

        let (op_scale, pv_scale) = (std(&heard.op), std(&heard.pv));
        if !(op_scale > 0.0 && pv_scale > 0.0) {
            return None;
        }
        let level = mean(&heard.op);
        let third: f64 = heard.op.iter().map(|u| ((u - level) / op_scale).powi(3)).sum();
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
        let op = standard(&heard.op, op_scale, of_op);
        let pv = standard(&heard.pv, pv_scale, of_pv);
        let left = std(&heard.follows).max(1e-9);
        let channels: [Vec<f64>; CHANNELS] = [
            scaled(&error, pv_scale, of_pv),
            moves(&op),
            moves(&pv),
            scaled(&heard.follows, left, of_pv),
            scaled(&heard.sticks, left, of_pv),
            scaled(&heard.behind, 1.0, of_op),
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
