//! Whether the PV responds to the OP at all.

use super::op_shape::steps;
use super::prepared::{Prepared, Trace, of_pair};
use super::turns::spread;
use super::waves::{coherence, components};
use super::{Feature, Line};
use crate::methods::{Subject, kano::Kano};
use crate::recording::LoopType;
use crate::series::{centred, correlation, max, mean, median, noise_std, span, std};

const fn feature(name: &'static str, meaning: &'static str) -> Feature {
    Feature { name, meaning, line: Line::Response, monotone: 0 }
}

/// Features.
pub const FEATURES: [Feature; 19] = [
    feature("pv_constant", "1 if the PV never moves while the OP does"),
    feature("silent_eighth", "share of moves over an eighth of a period that only the OP makes"),
    feature("silent_quarter", "share of moves over a quarter of a period that only the OP makes"),
    feature(
        "rest_share",
        "share of the time in which the OP travels and the PV stays in its noise",
    ),
    feature("rest_travel", "largest OP travel during a rest of the PV, in OP spans"),
    feature("rest_travel_spread", "relative spread of the OP travel during rests"),
    feature("band_width", "dead band with which the OP explains the PV best, in OP spans"),
    feature("band_gain", "gain of the best dead band over no dead band, logarithm"),
    feature("answer_r2", "share of the PV's moves that earlier moves of the OP explain"),
    feature("answer_lag", "lead of the OP's moves over the PV's, in periods"),
    feature("gain_small_large", "process gain for small OP moves over gain for large OP moves"),
    feature("coherence", "squared coherence of OP and PV at the dominant frequency"),
    feature("coherence_3", "squared coherence at three times the dominant frequency"),
    feature("phase", "phase of the PV after the OP at the dominant frequency, in half turns"),
    feature("slow_correlation", "correlation of the slow parts of OP and PV"),
    feature(
        "way_ratio",
        "ratio of PV moves over half a period to PV moves over a 24th, divided by the same ratio of the OP, logarithm",
    ),
    feature("pv_noise", "noise of the PV over the PV's standard deviation, logarithm"),
    feature("offset", "size of the mean error over the error's standard deviation, ln(1 + x)"),
    feature("one_sided", "longest time on one side of the SP, in periods, ln(1 + x)"),
];

/// Index of the features that do not need a moving PV.
const ENDS: usize = FEATURES.len() - 2;

/// Smaller ratios count as zero.
const LEAST_RATIO: f64 = 1e-6;

/// Measures them.
pub fn measure(prepared: &Prepared<'_>, out: &mut Vec<f64>) {
    let op = &prepared.op;
    let Some(recorded) = &prepared.segment.pv else {
        out.extend([f64::NAN; FEATURES.len()]);
        return;
    };
    let [offset, one_sided] = of_error(prepared, recorded);
    let range = span(&op.values);
    let Some(pv) = &prepared.pv else {
        // No response: a rest from the first sample to the last.
        let mut values = [f64::NAN; FEATURES.len()];
        values[..5].copy_from_slice(&[1.0, 1.0, 1.0, 1.0, range / op.span]);
        [values[ENDS], values[ENDS + 1]] = [offset, one_sided];
        out.extend(values);
        return;
    };
    let segment = of_pair(&op.values, &pv.values);
    let kano = Kano::default().run(&Subject::new(&segment, LoopType::Unknown, None)).ok();
    let travels: Vec<f64> = kano.as_ref().map_or(vec![], |kano| {
        kano.rests.iter().map(|rest| span(&op.values[rest.first..rest.end])).collect()
    });
    let farthest = if kano.is_some() { max(&travels).max(0.0) } else { f64::NAN };
    let answers = Answers::of(prepared, op, pv);
    let part = |x: &Trace, harmonic: f64| components(&x.high, prepared.period, harmonic);
    let at_peak = coherence(&part(op, 1.0), &part(pv, 1.0));
    let at_third = coherence(&part(op, 3.0), &part(pv, 3.0));
    let values: [f64; FEATURES.len()] = [
        0.0,
        silent(&op.high, &pv.high, prepared.lag(1.0 / 8.0)),
        silent(&op.high, &pv.high, prepared.lag(1.0 / 4.0)),
        kano.as_ref().map_or(f64::NAN, |kano| kano.statistic),
        farthest / op.span,
        spread(&travels),
        kano.as_ref().map_or(f64::NAN, |kano| kano.width / op.span),
        kano.as_ref().map_or(f64::NAN, |kano| {
            let left = |explained: f64| (1.0 - explained).max(LEAST_RATIO).ln();
            left(kano.explained_without) - left(kano.explained)
        }),
        answers.r2,
        answers.lag,
        answers.small_large,
        at_peak.norm_sqr(),
        at_third.norm_sqr(),
        at_peak.arg().abs() / std::f64::consts::PI,
        correlation(&slow(op), &slow(pv)).unwrap_or(f64::NAN),
        (typical_travel(prepared, &pv.values) / typical_travel(prepared, &op.values)).ln(),
        noise_std(&pv.values).max(LEAST_RATIO).ln(),
        offset,
        one_sided,
    ];
    out.extend(values);
}

/// The part that the high pass removes.
fn slow(trace: &Trace) -> Vec<f64> {
    trace.values.iter().zip(&trace.high).map(|(all, high)| all - high).collect()
}

/// Ratio of the travel in steps of half a period to the travel in steps of a 24th.
fn typical_travel(prepared: &Prepared<'_>, x: &[f64]) -> f64 {
    let travel = |lag: usize| mean(&steps(x, lag).iter().map(|d| d.abs()).collect::<Vec<_>>());
    travel(prepared.lag(0.5)) / travel(prepared.lag(1.0 / 24.0))
}

/// Of the times at which OP or PV has moved over `lag` samples, the share at which only the OP has. A move is more than
/// half of the typical travel for the OP and a quarter for the PV.
fn silent(op: &[f64], pv: &[f64], lag: usize) -> f64 {
    let (u, y) = (steps(op, lag), steps(pv, lag));
    let (of_u, of_y) = (0.5 * std(&u), 0.25 * std(&y));
    let moves = |x: f64, least: f64| x.abs() > least;
    let (mut moving, mut silent) = (0usize, 0usize);
    for (u, y) in u.iter().zip(&y) {
        let (u, y) = (moves(*u, of_u), moves(*y, of_y));
        moving += usize::from(u || y);
        silent += usize::from(u && !y);
    }
    silent as f64 / moving as f64
}

/// Offset and longest time on one side of the SP; without an SP, of the mean.
fn of_error(prepared: &Prepared<'_>, pv: &[f64]) -> [f64; 2] {
    let (offset, error): (f64, Vec<f64>) = match &prepared.segment.sp {
        Some(sp) => {
            let error: Vec<f64> = sp.iter().zip(pv).map(|(sp, pv)| sp - pv).collect();
            ((mean(&error).abs() / std(&error)).ln_1p(), error)
        }
        None => (f64::NAN, centred(pv)),
    };
    if prepared.error.is_none() {
        return [f64::NAN; 2];
    }
    let longest = error.chunk_by(|a, b| (*a > 0.0) == (*b > 0.0)).map(<[f64]>::len).max();
    let periods = longest.unwrap_or(0) as f64 / (prepared.period * prepared.factor as f64);
    [offset, periods.ln_1p()]
}

/// Correlation of moves of the PV with earlier moves of the OP, all over an eighth of a period.
struct Answers {
    r2: f64,
    lag: f64,
    small_large: f64,
}

impl Answers {
    /// The delay with the largest positive correlation, from one sample to half a period. Without a delay, or with
    /// a negative correlation, it is the controller that responds.
    fn of(prepared: &Prepared<'_>, op: &Trace, pv: &Trace) -> Self {
        let (u, y) = (steps(&op.high, prepared.lag(0.125)), steps(&pv.high, prepared.lag(0.125)));
        let norm = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>().sqrt();
        let scale = norm(&u) * norm(&y);
        let together =
            |d: usize| u.iter().zip(y.iter().skip(d)).map(|(u, y)| u * y).sum::<f64>() / scale;
        let mut best = (1, together(1));
        for d in (1..=prepared.lag(0.5).min(u.len() / 2)).step_by(prepared.lag(1.0 / 36.0)) {
            let r = together(d);
            if r > best.1 {
                best = (d, r);
            }
        }
        let (delay, r) = best;
        let sizes: Vec<f64> = u.iter().map(|u| u.abs()).collect();
        let middle = median(&sizes);
        let gain = |counts: &dyn Fn(f64) -> bool| {
            let (mut uy, mut uu) = (0.0, 0.0);
            for (u, y) in u.iter().zip(y.iter().skip(delay)).filter(|(u, _)| counts(**u)) {
                uy += u * y;
                uu += u * u;
            }
            uy / uu
        };
        let (small, large) = (gain(&|u| u.abs() <= middle), gain(&|u| u.abs() > middle));
        Self {
            r2: r.max(0.0).powi(2),
            lag: delay as f64 / prepared.period,
            small_large: (small / large).clamp(-2.0, 4.0),
        }
    }
}
