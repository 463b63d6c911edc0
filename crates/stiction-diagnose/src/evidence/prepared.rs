//! A window prepared for measurement: one resolution per period, no units, no slow part.

use crate::finding::Abstention;
use crate::recording::Segment;
use crate::series::{
    Periodogram, correlation, decimated, detrended, max, min, periodogram, quantile, running_sums,
    span, standardised, std,
};

/// Fewest samples per period after averaging, if there are as many.
const SAMPLES_PER_PERIOD: f64 = 36.0;

/// Ratio of the fine resolution. Averaging hides corners.
const FINE: usize = 3;

/// Largest number of samples of the dense resolution.
const DENSE_SAMPLES: usize = 1200;

/// Smallest number of times by which it must be denser to be used.
const DENSER: usize = 2;

/// Fewest periods of a frequency in the window; slower ones cannot be distinguished from drift.
const FEWEST_PERIODS: f64 = 3.0;

/// Width of the moving mean that is the slow part, in periods.
const SLOW_PERIODS: f64 = 2.0;

/// Smallest number of samples for a measurement.
const FEWEST_SAMPLES: usize = 16;

/// A signal is constant if it moves by less than this share of its largest sample, as by rounding.
const ROUNDING: f64 = 1e-12;

/// A signal at the resolution of [`Prepared`].
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Averaged over blocks, less its mean, in standard deviations.
    pub values: Vec<f64>,
    /// That standard deviation, in the signal's units: percent for the OP.
    pub scale: f64,
    /// The values less their moving mean over two periods.
    pub high: Vec<f64>,
    /// From the 1st to the 99th percentile of `high`.
    pub span: f64,
}

/// OP and PV averaged over blocks so that at most 1,200 samples remain. Each signal has mean 0 and standard deviation
/// 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Dense {
    /// The OP.
    pub op: Vec<f64>,
    /// The PV, opening the valve raising it.
    pub pv: Vec<f64>,
    /// Dominant period, in these samples.
    pub period: f64,
}

/// A prepared window of a recording.
///
/// * The dominant period P is at the largest value of the mean of two Hann periodograms, of OP and control error.
///   Without a PV, only the OP counts. Each is computed without straight trend, at unit power and smoothed by (1/4,
///   1/2, 1/4), over the frequencies with three periods or more in the window. The control error is PV less SP, or the
///   PV without SP.
/// * Signals are averaged over blocks of `floor(P / 36)` samples and brought to mean zero and standard deviation
///   one. A period then has 36 to 72 samples, or fewer if it was recorded with fewer.
/// * PV and error are inverted if opening the valve lowers the PV. The sign follows from the controller, which responds
///   to the error e by `dOP = a de + b e`, with a and b of the sign opposite to the process. It is the sign of the sum
///   of the correlations of dOP with de and with e.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared<'a> {
    /// The recorded segment.
    pub segment: &'a Segment,
    /// Recorded samples per sample of a trace.
    pub factor: usize,
    /// Dominant period, in samples of the traces.
    pub period: f64,
    /// The OP.
    pub op: Trace,
    /// The PV, opening the valve raising it; `None` if it is not recorded or never moves.
    pub pv: Option<Trace>,
    /// PV less SP, opening the valve raising it; `None` if no PV is recorded or it never moves. Without
    /// an SP it is the PV.
    pub error: Option<Trace>,
    /// 1 if opening the valve raises the PV as recorded, -1 if it lowers it. A guess.
    pub gain_sign: f64,
    /// The OP averaged over a third of the blocks, less its mean, in its standard deviations.
    pub fine_op: Vec<f64>,
    /// The PV in the same form, opening the valve raising it.
    pub fine_pv: Option<Vec<f64>>,
    /// OP and PV at a resolution that does not depend on the period, if it is much denser: the process may be much
    /// faster than the dominant period of the record, for example a drift.
    pub dense: Option<Dense>,
    /// Spectrum of the recorded OP without its straight trend.
    pub op_spectrum: Periodogram,
    /// Spectrum of the recorded control error without its straight trend.
    pub error_spectrum: Option<Periodogram>,
}

impl<'a> Prepared<'a> {
    /// Prepares a window.
    ///
    /// # Errors
    /// If the window has fewer than 16 samples, a sample is not finite, or the OP never moves.
    pub fn of(segment: &'a Segment) -> Result<Self, Abstention> {
        let n = segment.len();
        if n < FEWEST_SAMPLES {
            return Err(Abstention(format!(
                "needs at least {FEWEST_SAMPLES} samples; there are {n}"
            )));
        }
        let signals =
            [Some(&segment.op), segment.pv.as_ref(), segment.sp.as_ref()].into_iter().flatten();
        for signal in signals {
            if signal.len() != n || signal.iter().any(|v| !v.is_finite()) {
                return Err(Abstention(
                    "signals differ in length, or a sample is not a number".to_owned(),
                ));
            }
        }
        let op = Scaled::of(&segment.op)
            .ok_or_else(|| Abstention("the OP never moves in this window".to_owned()))?;
        let pv = segment.pv.as_deref().and_then(Scaled::of);
        let error = segment.pv.as_deref().and_then(|pv| {
            let less_sp = |sp: &Vec<f64>| pv.iter().zip(sp).map(|(pv, sp)| pv - sp).collect();
            Scaled::of(&segment.sp.as_ref().map_or_else(|| pv.to_vec(), less_sp))
        });
        let op_spectrum = periodogram(&detrended(&op.values));
        let error_spectrum = error.as_ref().map(|error| periodogram(&detrended(&error.values)));
        let spectra: Vec<&Periodogram> =
            [Some(&op_spectrum), error_spectrum.as_ref()].into_iter().flatten().collect();
        let recorded_period = dominant_period(n, &spectra)
            .ok_or_else(|| Abstention("the OP follows a straight line".to_owned()))?;

        let factor = ((recorded_period / SAMPLES_PER_PERIOD) as usize).max(1);
        let period = recorded_period / factor as f64;
        let trace = |signal: &Scaled| Trace::of(signal, factor, period);
        let op_trace = trace(&op).ok_or_else(|| {
            Abstention("the OP moves only much faster than the period".to_owned())
        })?;
        let (mut pv_trace, mut error_trace) =
            (pv.as_ref().and_then(trace), error.as_ref().and_then(trace));
        let gain_sign = error_trace.as_ref().map_or(1.0, |error| gain_sign(&op_trace, error));
        let turned = [&mut pv_trace, &mut error_trace].into_iter().flatten();
        turned.for_each(|trace| trace.turn(gain_sign));

        let fine =
            |signal: &Scaled| standardised(&decimated(&signal.values, (factor / FINE).max(1)));
        let dense_factor = n.div_ceil(DENSE_SAMPLES);
        let dense = pv.as_ref().filter(|_| factor >= DENSER * dense_factor).and_then(|pv| {
            let [op, mut pv] = [op.values.as_slice(), &pv.values]
                .map(|x| standardised(&decimated(x, dense_factor)));
            pv.iter_mut().flatten().for_each(|v| *v *= gain_sign);
            Some(Dense { op: op?, pv: pv?, period: recorded_period / dense_factor as f64 })
        });
        Ok(Self {
            segment,
            factor,
            period,
            dense,
            fine_op: fine(&op).unwrap_or_default(),
            fine_pv: pv.as_ref().and_then(fine).map(|mut pv| {
                pv.iter_mut().for_each(|v| *v *= gain_sign);
                pv
            }),
            op: op_trace,
            pv: pv_trace,
            error: error_trace,
            gain_sign,
            op_spectrum,
            error_spectrum,
        })
    }

    /// Span of the OP without its slow part, percent: the scale of S.
    pub fn op_span(&self) -> f64 {
        self.op.span * self.op.scale
    }

    /// Dominant period, s.
    pub fn period_s(&self) -> f64 {
        self.period * self.factor as f64 * self.segment.sample_time
    }

    /// Number of periods in the window.
    pub fn cycles(&self) -> f64 {
        self.segment.len() as f64 / (self.period * self.factor as f64)
    }

    /// A share of the period in samples of the traces, at least one.
    pub fn lag(&self, share: f64) -> usize {
        ((self.period * share).round() as usize).max(1)
    }
}

/// A recorded signal relative to the middle of its range, in ranges, so that no square overflows or vanishes.
struct Scaled {
    values: Vec<f64>,
    range: f64,
}

impl Scaled {
    /// `None` if the signal does not move, or its range cannot be represented.
    fn of(x: &[f64]) -> Option<Self> {
        let (range, middle) = (span(x), 0.5 * min(x) + 0.5 * max(x));
        let largest = x.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let moves = range > ROUNDING * largest && range.is_finite() && range.recip().is_finite();
        moves.then(|| Self { values: x.iter().map(|v| (v - middle) / range).collect(), range })
    }
}

impl Trace {
    /// `None` if nothing remains of the signal after averaging.
    fn of(signal: &Scaled, factor: usize, period: f64) -> Option<Self> {
        let averaged = decimated(&signal.values, factor);
        // Rounding in a signal that averages out counts as nothing.
        let deviation = Some(std(&averaged)).filter(|std| *std > ROUNDING)?;
        let values = standardised(&averaged)?;
        let high = high_passed(&values, SLOW_PERIODS * period);
        let span = quantile(&high, 0.99) - quantile(&high, 0.01);
        (span > ROUNDING).then_some(Self { values, scale: deviation * signal.range, high, span })
    }

    /// Inverts it if `sign` is negative.
    fn turn(&mut self, sign: f64) {
        self.values.iter_mut().chain(&mut self.high).for_each(|v| *v *= sign);
    }
}

/// `x` less its centred moving mean over `width` samples, or fewer near the ends.
pub fn high_passed(x: &[f64], width: f64) -> Vec<f64> {
    let half = (0.5 * width).round().max(0.0) as usize;
    let sums = running_sums(x);
    let about = |k: usize| (k.saturating_sub(half), (k + half + 1).min(x.len()));
    let without = |(k, v): (usize, &f64)| {
        let (from, to) = about(k);
        v - (sums[to] - sums[from]) / (to - from) as f64
    };
    x.iter().enumerate().map(without).collect()
}

/// Period of the strongest frequency of some spectra of a series of `n` samples, with equal weights, in samples;
/// `None` without power.
pub(super) fn dominant_period(n: usize, spectra: &[&Periodogram]) -> Option<f64> {
    let weighed = spectra.iter().map(|p| (*p, p.power.iter().sum::<f64>()));
    let spectra: Vec<(&Periodogram, f64)> = weighed.filter(|(_, total)| *total > 0.0).collect();
    let last = spectra.first()?.0.power.len() - 1;
    let joint: Vec<f64> = (0..=last)
        .map(|i| spectra.iter().map(|(p, total)| p.power[i] / total).sum::<f64>())
        .collect();
    let at = |i: usize| 0.25 * joint[i - 1] + 0.5 * joint[i] + 0.25 * joint[(i + 1).min(last)];
    let bins = 2.0 * last as f64;
    let first = ((FEWEST_PERIODS / n as f64 * bins).ceil() as usize).clamp(1, last);
    let best = (first..=last).fold(first, |a, b| if at(b) > at(a) { b } else { a });
    // Between the bins, by the centre of power of the three around it, as far as the limit allows.
    let (mut moment, mut power) = (0.0, 0.0);
    for i in (best - 1).max(1)..=(best + 1).min(last) {
        moment += i as f64 * joint[i];
        power += joint[i];
    }
    let bin = if power > 0.0 { moment / power } else { best as f64 };
    Some((bins / bin).min(n as f64 / FEWEST_PERIODS))
}

/// A segment of a pair of signals of one length, for methods that need segments.
pub(super) fn of_pair(op: &[f64], pv: &[f64]) -> Segment {
    Segment {
        from: 0.0,
        sample_time: 1.0,
        op: op.to_vec(),
        pv: Some(pv.to_vec()),
        sp: None,
        vp: None,
        bridged: 0,
    }
}

/// The sign of the process gain from the controller's response to the error; 1 if there is none.
fn gain_sign(op: &Trace, error: &Trace) -> f64 {
    let step = |x: &[f64]| -> Vec<f64> { x.windows(2).map(|w| w[1] - w[0]).collect() };
    let between: Vec<f64> = error.high.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
    let (of_op, of_error) = (step(&op.high), step(&error.high));
    let together = |x: &[f64]| correlation(&of_op, x).unwrap_or(0.0);
    if together(&of_error) + together(&between) > 0.0 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::{ClosedLoop, Controller, Process, Signal};
    use crate::valve::{Assembly, Model};

    fn wave(n: usize, period: f64) -> Vec<f64> {
        (0..n).map(|k| 50.0 + (std::f64::consts::TAU * k as f64 / period).sin()).collect()
    }

    #[test]
    fn a_period_keeps_36_to_72_samples_where_it_has_them() {
        for (period, factor) in [(20.0, 1), (71.0, 1), (110.0, 3), (400.0, 11)] {
            let wave = wave(4000, period);
            let segment = of_pair(&wave, &wave);
            let prepared = Prepared::of(&segment).unwrap();
            assert_eq!(prepared.factor, factor, "{period}");
            assert!((prepared.period_s() / period - 1.0).abs() < 0.01, "{}", prepared.period_s());
            assert_eq!(prepared.op.values.len(), 4000 / factor);
            // The blocks take little of the wave, whose standard deviation is sqrt(1/2).
            assert!((prepared.op.scale - 0.5f64.sqrt()).abs() < 0.01);
        }
    }

    #[test]
    fn the_high_pass_takes_lines_and_keeps_waves() {
        let line: Vec<f64> = (0..200).map(f64::from).collect();
        let high = high_passed(&line, 20.0);
        assert!(high[10..190].iter().all(|v| v.abs() < 1e-9));
        // Half a window at the end: 0 to 10 about 0.
        assert_eq!(high[0], -5.0);
        assert!(high_passed(&[], 20.0).is_empty());
    }

    #[test]
    fn the_sign_of_the_gain_is_seen_from_the_controller() {
        for (gain, ti) in [(1.2, 12.0), (-1.2, 12.0), (2.0, 60.0), (-0.7, 3.0)] {
            let mut system = ClosedLoop::new(
                Controller::pi(0.4 / gain, ti).unwrap(),
                Assembly::new(
                    Model::Ideal.build(crate::Bands::from_s_j(0.0, 0.0).unwrap()).unwrap(),
                ),
                Process::first_order(gain, 8.0, 3.0).unwrap(),
            );
            system.sample_time = 1.0;
            system.samples = 1000;
            system.load = vec![Signal::Noise { sd: 2.0, tau_s: 40.0, seed: 3 }];
            system.measurement = vec![Signal::Noise { sd: 0.3, tau_s: 0.0, seed: 4 }];
            let run = system.run().unwrap();
            let segment = of_pair(&run.op, &run.pv);
            assert_eq!(Prepared::of(&segment).unwrap().gain_sign, gain.signum(), "{gain} {ti}");
        }
    }
}
