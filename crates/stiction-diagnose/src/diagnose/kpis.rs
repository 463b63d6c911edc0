//! Key figures of a loop.

use crate::recording::fitness::share_at_limit;
use crate::recording::{Grid, Recording, Segment};
use crate::series::{
    autocorrelation, correlation, mean, noise_std, reversals, skewness, std, zero_crossings,
};

/// One key figure of a loop.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Kpi {
    /// Name, such as `OP travel`.
    pub name: &'static str,
    /// Value; `None` if the data do not determine the value.
    pub value: Option<f64>,
    /// Unit; empty for a ratio, `PV` for the units of the process value.
    pub unit: &'static str,
    /// Meaning of the key figure, in a sentence.
    pub meaning: &'static str,
    /// The reason for a missing value, or the assumption behind a value.
    pub note: Option<String>,
}

/// Settings of the key figures.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct KpiOptions {
    /// Dead time of process and valve together, s, for the Harris index. Without this value, one sample is assumed,
    /// which gives the smallest possible index.
    pub dead_time: Option<f64>,
}

/// Numbers about a segment of a recording, in a fixed order.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct Kpis {
    /// The numbers.
    pub numbers: Vec<Kpi>,
}

/// Order of the autoregressive model of the Harris index: 30 covers the dynamics of a well-sampled loop. It is
/// limited to a tenth of the samples.
const AR_ORDER: usize = 30;

/// A noise band extends by this many standard deviations to either side, and contains 99.7 % of Gaussian noise.
const NOISE_BAND: f64 = 3.0;

const NO_PV: &str = "the PV is not recorded";

impl Kpis {
    /// The key figures of a segment. Without a PV, the key figures of the PV have no value.
    ///
    /// | name | equation |
    /// |---|---|
    /// | service factor | time in command over all time, % |
    /// | good values | usable samples over all, the worse of OP and PV, % |
    /// | OP at a limit | share of the samples in which OP rests at 0, 100 or its extremes, % |
    /// | OP travel | `sum abs(u_k - u_(k-1))` an hour, % |
    /// | OP reversals | turns of the OP by more than its noise band, an hour |
    /// | OP noise band | `3 s`, s the standard deviation of the noise by second differences |
    /// | error mean, std, skewness | moments of e = SP - PV (divisor n); without SP, of mean PV - PV |
    /// | mean absolute error | `mean abs(e)` |
    /// | IAE | `3600 mean abs(e)`: integral of the absolute error an hour, PV s |
    /// | variability | `2 std(PV) / abs(mean PV)`, % |
    /// | variability of range | `2 std(PV) / (range of the PV)`, % |
    /// | set-point crossings | changes of sign of e, an hour |
    /// | PV noise band | as for the OP |
    /// | Harris index | see [`harris_index`] |
    /// | ellipse axis ratio | `sqrt((1 - abs(rho)) / (1 + abs(rho)))`, rho the correlation of OP and PV |
    /// | ellipse OP width | `2 sqrt(2) std(OP) sqrt(1 - rho^2)`, % |
    ///
    /// The two ellipses are ellipses of the covariance, not a fit to the outline of the cloud. The axis ratio describes
    /// the standardised cloud: 1 for a circle and 0 for a line. The width is measured along OP through the centre. For
    /// two sines of one frequency it is exactly `2 A abs(sin phase)`.
    pub fn of(recording: &Recording, grid: &Grid, segment: &Segment, options: &KpiOptions) -> Self {
        let mut kpis = Self::default();
        let hours = segment.duration() / 3600.0;
        kpis.value(
            "service factor",
            100.0 * grid.closed_share,
            "%",
            "share of the time in which the controller was in command",
        );
        let good = [Some(&recording.op), recording.pv.as_ref()]
            .into_iter()
            .flatten()
            .map(|c| 100.0 * c.usable_share());
        kpis.value(
            "good values",
            good.fold(100.0, f64::min),
            "%",
            "share of usable samples, the worse of OP and PV",
        );
        kpis.of_op(&segment.op, hours);
        kpis.of_pv(recording, segment, hours, options);
        kpis
    }

    /// The number of that name, if there is one.
    pub fn get(&self, name: &str) -> Option<&Kpi> {
        self.numbers.iter().find(|kpi| kpi.name == name)
    }

    fn add(
        &mut self,
        name: &'static str,
        value: Result<f64, &str>,
        unit: &'static str,
        meaning: &'static str,
    ) {
        let note = match value {
            Err(why) => Some(why.to_owned()),
            Ok(value) if !value.is_finite() => Some("the signal does not move".to_owned()),
            Ok(_) => None,
        };
        let value = value.ok().filter(|value| value.is_finite());
        self.numbers.push(Kpi { name, value, unit, meaning, note });
    }

    fn value(&mut self, name: &'static str, value: f64, unit: &'static str, meaning: &'static str) {
        self.add(name, Ok(value), unit, meaning);
    }

    fn of_op(&mut self, op: &[f64], hours: f64) {
        let band = NOISE_BAND * noise_std(op);
        self.value(
            "OP at a limit",
            100.0 * share_at_limit(op),
            "%",
            "share of the time in which the OP rests at a limit",
        );
        self.value(
            "OP travel",
            op.windows(2).map(|w| (w[1] - w[0]).abs()).sum::<f64>() / hours,
            "%/h",
            "OP travel per hour, up and down; the travel wears the valve",
        );
        self.value(
            "OP reversals",
            reversals(op, band) as f64 / hours,
            "1/h",
            "OP reversals per hour that exceed the OP noise",
        );
        self.value(
            "OP noise band",
            band,
            "%",
            "three standard deviations of the OP's noise between successive samples",
        );
    }

    fn of_pv(
        &mut self,
        recording: &Recording,
        segment: &Segment,
        hours: f64,
        options: &KpiOptions,
    ) {
        let pv = segment.pv.as_deref();
        let error: Option<Vec<f64>> = pv.map(|pv| match &segment.sp {
            Some(sp) => sp.iter().zip(pv).map(|(sp, pv)| sp - pv).collect(),
            None => {
                let m = mean(pv);
                pv.iter().map(|v| m - v).collect()
            }
        });
        let e = |of: &dyn Fn(&[f64]) -> f64| error.as_deref().map(of).ok_or(NO_PV);
        let p = |of: &dyn Fn(&[f64]) -> f64| pv.map(of).ok_or(NO_PV);
        let absolute = |e: &[f64]| e.iter().map(|v| v.abs()).sum::<f64>() / e.len() as f64;
        // Without an SP the mean of the PV replaces it, and the offset is unknown.
        let offset = match (pv, &segment.sp) {
            (Some(_), None) => Err("the SP is not recorded"),
            _ => e(&mean),
        };
        self.add("error mean", offset, "PV", "mean of SP less PV: the remaining offset");
        self.add("error std", e(&std), "PV", "standard deviation of the control error");
        self.add("error skewness", e(&skewness), "", "0 if positive and negative errors are alike");
        if segment.sp.is_none() && pv.is_some() {
            let note = "the SP is not recorded; the mean of the PV replaces it";
            self.numbers
                .iter_mut()
                .filter(|k| k.name.starts_with("error") && k.value.is_some())
                .for_each(|k| {
                    k.note = Some(
                        k.note.take().map_or(note.to_owned(), |other| format!("{other}; {note}")),
                    );
                });
        }
        self.add("mean absolute error", e(&absolute), "PV", "mean size of the control error");
        self.add(
            "IAE",
            e(&|e| 3600.0 * absolute(e)),
            "PV s/h",
            "integral of the absolute control error per hour",
        );
        let spread = |pv: &[f64]| 200.0 * std(pv);
        self.add(
            "variability",
            p(&|pv| spread(pv) / mean(pv).abs()),
            "%",
            "two standard deviations of the PV, divided by its mean",
        );
        let range = recording.pv.as_ref().and_then(|pv| pv.range);
        self.add(
            "variability of range",
            match (pv, range) {
                (None, _) => Err(NO_PV),
                (_, None) => Err("the range of the PV is not known"),
                (Some(pv), Some(range)) => Ok(spread(pv) / (range.high - range.low)),
            },
            "%",
            "two standard deviations of the PV, divided by its range",
        );
        self.add(
            "set-point crossings",
            e(&|e| zero_crossings(e).len() as f64 / hours),
            "1/h",
            "how often per hour the PV crosses the set point",
        );
        self.add(
            "PV noise band",
            p(&|pv| NOISE_BAND * noise_std(pv)),
            "PV",
            "three standard deviations of the PV's noise between successive samples",
        );
        self.harris(error.as_deref(), segment.sample_time, options.dead_time);
        let cloud = pv
            .ok_or(NO_PV)
            .and_then(|pv| correlation(&segment.op, pv).ok_or("OP or PV does not move"));
        self.add(
            "ellipse axis ratio",
            cloud.map(|rho| ((1.0 - rho.abs()) / (1.0 + rho.abs())).sqrt()),
            "",
            "minor over major axis of the cloud of OP and PV, both standardised (covariance ellipse)",
        );
        self.add(
            "ellipse OP width",
            cloud.map(|rho| 8f64.sqrt() * std(&segment.op) * (1.0 - rho * rho).max(0.0).sqrt()),
            "%",
            "width along OP through the centre of the cloud of OP and PV (covariance ellipse)",
        );
    }

    fn harris(&mut self, error: Option<&[f64]>, sample_time: f64, dead_time: Option<f64>) {
        let delay = dead_time
            .filter(|t| *t >= 0.0 && t.is_finite())
            .map_or(1, |t| ((t / sample_time).round() as usize).max(1));
        let index = error.ok_or(NO_PV).and_then(|e| {
            harris_index(e, delay).ok_or("the control error is constant or too short")
        });
        self.add(
            "Harris index",
            index,
            "",
            "smallest variance that feedback could reach, over the actual variance: 1 is the best",
        );
        if let (Ok(_), Some(last)) = (index, self.numbers.last_mut()) {
            last.note = Some(match dead_time {
                Some(_) => format!("with a dead time of {delay} samples"),
                None => {
                    "needs the dead time; one sample is assumed, which gives the smallest possible index"
                        .to_owned()
                }
            });
        }
    }
}

/// The Harris index of a control error: `eta = s^2 sum_(i < b) h_i^2 / var(e)`, with the innovations' variance s^2
/// and the impulse response h of an autoregressive model of e, and the dead time b in samples. It is 1 at minimum
/// variance, 0 if control could remove everything; it rises with b. `None` if e is constant or has fewer than 20
/// samples.
///
/// Harris 1989, Canadian J. Chemical Engineering 67, 856-861 (recalled, not read). The model's order is 30, or a
/// tenth of the samples; its coefficients solve the Yule-Walker equations by the recursion of Levinson and Durbin.
/// It rates tight loops higher than lively ones. It has no meaning for averaging level loops.
pub fn harris_index(error: &[f64], dead_time: usize) -> Option<f64> {
    let order = AR_ORDER.min(error.len() / 10);
    if order < 2 {
        return None;
    }
    let lags = autocorrelation(error, order)?;
    let (model, innovations) = levinson_durbin(&lags);
    // Impulse response of 1 / (1 - a_1 q^-1 - ...).
    let mut h: Vec<f64> = vec![];
    let mut sum = 0.0;
    for i in 0..dead_time.clamp(1, error.len()) {
        let next =
            if i == 0 { 1.0 } else { model.iter().zip(h.iter().rev()).map(|(a, h)| a * h).sum() };
        sum += next * next;
        h.push(next);
    }
    Some((innovations * sum).clamp(0.0, 1.0))
}

/// Coefficients of the autoregressive model with these autocorrelations (1 at lag zero), and the share of the
/// variance that is innovation.
fn levinson_durbin(lags: &[f64]) -> (Vec<f64>, f64) {
    let mut a: Vec<f64> = vec![];
    let mut left = 1.0;
    for k in 1..lags.len() {
        let explained: f64 = a.iter().zip(lags[1..k].iter().rev()).map(|(a, r)| a * r).sum();
        let reflection = (lags[k] - explained) / left;
        // Rounding can exceed 1 when nothing is left to explain.
        if !(reflection.abs() < 1.0) {
            break;
        }
        let reversed: Vec<f64> = a.iter().rev().copied().collect();
        a.iter_mut().zip(&reversed).for_each(|(a, b)| *a -= reflection * b);
        a.push(reflection);
        left *= 1.0 - reflection * reflection;
    }
    (a, left)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{GridOptions, Range, RangeSource};
    use crate::test_signals::noise;
    use std::f64::consts::TAU;

    const N: usize = 3600;

    fn wave(period: f64, phase: f64) -> Vec<f64> {
        (0..N).map(|k| (TAU * k as f64 / period + phase).sin()).collect()
    }

    fn of(recording: &Recording, options: &KpiOptions) -> Kpis {
        let grid = Grid::of(recording, &GridOptions::default()).unwrap();
        Kpis::of(recording, &grid, grid.longest().unwrap(), options)
    }

    #[test]
    fn sines_have_closed_forms() {
        let op: Vec<f64> = wave(120.0, 0.1).iter().map(|v| 50.0 + 4.0 * v).collect();
        let pv: Vec<f64> = wave(120.0, 0.7).iter().map(|v| 20.0 + 2.0 * v).collect();
        let mut recording = Recording::regular("x", 1.0, &op, Some(&pv), Some(&[20.0; N])).unwrap();
        recording.pv.as_mut().unwrap().range =
            Some(Range::new(0.0, 40.0, RangeSource::Given).unwrap());
        let kpis = of(&recording, &KpiOptions::default());
        let close = |name: &str, expected: f64, tolerance: f64| {
            let found = kpis.get(name).unwrap().value.unwrap();
            assert!(
                (found - expected).abs() <= tolerance * expected.abs().max(1e-6),
                "{name}: {found}"
            );
        };
        close("service factor", 100.0, 0.0);
        close("good values", 100.0, 0.0);
        close("OP at a limit", 0.0, 0.0);
        close("OP travel", 16.0 * 30.0, 0.01);
        close("OP reversals", 60.0, 0.02);
        close("error std", 2f64.sqrt(), 1e-6);
        close("error mean", 0.0, 1e-6);
        close("mean absolute error", 4.0 / std::f64::consts::PI, 1e-3);
        close("IAE", 3600.0 * 4.0 / std::f64::consts::PI, 1e-3);
        close("variability", 200.0 * 2f64.sqrt() / 20.0, 1e-6);
        close("variability of range", 200.0 * 2f64.sqrt() / 40.0, 1e-6);
        close("set-point crossings", 60.0, 0.02);
        // Phase 0.6: rho = cos 0.6.
        close("ellipse axis ratio", 0.3f64.tan(), 1e-9);
        close("ellipse OP width", 8.0 * 0.6f64.sin(), 1e-9);
    }

    #[test]
    fn harris_of_a_moving_average_is_known() {
        // e = a_k + 0.8 a_(k-1) + 0.6 a_(k-2): the first b terms cannot be controlled.
        let a = noise(40_000, 4);
        let e: Vec<f64> = a.windows(3).map(|w| w[2] + 0.8 * w[1] + 0.6 * w[0]).collect();
        for (b, expected) in [(1, 1.0 / 2.0), (2, 1.64 / 2.0), (3, 1.0)] {
            let found = harris_index(&e, b).unwrap();
            assert!((found - expected).abs() < 0.02, "{b}: {found}");
        }
        assert_eq!(harris_index(&[1.0; 100], 1), None);
        assert_eq!(harris_index(&[1.0, 2.0], 1), None);
        let recording = Recording::regular("x", 2.0, &e, Some(&e), None).unwrap();
        let with = of(&recording, &KpiOptions { dead_time: Some(4.0) });
        let harris = with.get("Harris index").unwrap();
        assert!((harris.value.unwrap() - 0.82).abs() < 0.02);
        assert_eq!(harris.note.as_deref(), Some("with a dead time of 2 samples"));
        let without = of(&recording, &KpiOptions::default());
        assert!(without.get("Harris index").unwrap().note.as_ref().unwrap().contains("assumed"));
    }

    #[test]
    fn scale_and_offset() {
        let (op, pv) = (noise(N, 1), noise(N, 2));
        let pv2: Vec<f64> = pv.iter().map(|v| 300.0 - 5.0 * v).collect();
        let kpis = |pv: &[f64]| {
            of(&Recording::regular("x", 1.0, &op, Some(pv), None).unwrap(), &KpiOptions::default())
        };
        let (a, b) = (kpis(&pv), kpis(&pv2));
        for (name, factor) in [
            ("error std", 5.0),
            ("error skewness", -1.0),
            ("IAE", 5.0),
            ("PV noise band", 5.0),
            ("set-point crossings", 1.0),
            ("Harris index", 1.0),
            ("ellipse axis ratio", 1.0),
            ("ellipse OP width", 1.0),
            ("OP travel", 1.0),
        ] {
            let value = |kpis: &Kpis| kpis.get(name).unwrap().value.unwrap();
            assert!((value(&a) * factor / value(&b) - 1.0).abs() < 1e-8, "{name}");
        }
        // White noise of unit variance.
        assert!((a.get("PV noise band").unwrap().value.unwrap() - 3.0).abs() < 0.2);
    }

    #[test]
    fn without_pv_or_movement_there_are_reasons() {
        let recording = Recording::regular("x", 1.0, &noise(100, 1), None, None).unwrap();
        let kpis = of(&recording, &KpiOptions::default());
        let iae = kpis.get("IAE").unwrap();
        assert_eq!((iae.value, iae.note.as_deref()), (None, Some(NO_PV)));
        assert!(kpis.get("OP travel").unwrap().value.is_some());
        let still = Recording::regular("x", 1.0, &[5.0; 50], Some(&[0.0; 50]), None).unwrap();
        for kpi in of(&still, &KpiOptions::default()).numbers {
            assert!(
                kpi.value.is_some() != kpi.note.is_some() || kpi.name.starts_with("error"),
                "{kpi:?}"
            );
        }
    }
}
