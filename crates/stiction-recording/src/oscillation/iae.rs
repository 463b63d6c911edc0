//! Oscillation as frequent load disturbances: Hägglund's supervision.

use crate::series::half_waves;
use std::f64::consts::PI;

/// Settings of the supervision of a control error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Supervision {
    /// Smallest unacceptable amplitude of an oscillation, a, in units of the error.
    pub amplitude: f64,
    /// Ultimate period of the loop, s: `2 pi / w_i`. If it is not known, the integral time replaces `1 / w_i`.
    pub ultimate_period: f64,
    /// Number of disturbances within the supervision time from which the loop oscillates.
    pub limit: f64,
    /// Supervision time, in half periods.
    pub half_periods: f64,
}

impl Supervision {
    /// With Hägglund's 10 disturbances in 50 half periods.
    pub fn new(amplitude: f64, ultimate_period: f64) -> Self {
        Self { amplitude, ultimate_period, limit: 10.0, half_periods: 50.0 }
    }
}

/// The result of the supervision of half waves (Hägglund, 1995).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Supervised {
    /// The smallest integral of the absolute error of a half wave that counts as a load disturbance, in units of the
    /// error times s.
    pub threshold: f64,
    /// Number of half waves that count as load disturbances.
    pub disturbances: usize,
    /// Number of all half waves.
    pub half_waves: usize,
    /// The largest value of the forgetting counter.
    pub counter: f64,
    /// Time when the counter first exceeded the limit, s from the first sample; `None` if the counter stayed below the
    /// limit.
    pub alarm_s: Option<f64>,
    /// Whether the loop oscillates, which means that the counter exceeded the limit.
    pub oscillates: bool,
}

/// Supervises a control error.
///
/// A half wave is a load disturbance if its integral of the absolute error exceeds `2 a / w_i`, that of half a sine
/// of amplitude a at the ultimate frequency. A counter increases by one at each and decays with the supervision
/// time `T_s` by `exp(-t / T_s)` in between. It raises the alarm when it exceeds the limit.
///
/// Hägglund 1995, Control Engineering Practice 3, 1543-1551 (recalled, not read): a is 1 % of the range.
pub fn supervise(error: &[f64], sample_time: f64, supervision: &Supervision) -> Supervised {
    let omega = 2.0 * PI / supervision.ultimate_period;
    let threshold = 2.0 * supervision.amplitude / omega;
    let forget = supervision.half_periods * supervision.ultimate_period / 2.0;
    let mut found = Supervised {
        threshold,
        disturbances: 0,
        half_waves: 0,
        counter: 0.0,
        alarm_s: None,
        oscillates: false,
    };
    let (mut counter, mut last) = (0.0, 0.0);
    for wave in half_waves(error) {
        found.half_waves += 1;
        let area: f64 = error[wave.first..wave.end].iter().map(|v| v.abs()).sum::<f64>();
        if area * sample_time <= threshold {
            continue;
        }
        let time = wave.to * sample_time;
        counter = counter * (-(time - last) / forget).exp() + 1.0;
        last = time;
        found.disturbances += 1;
        found.counter = counter.max(found.counter);
        if counter > supervision.limit && found.alarm_s.is_none() {
            found.alarm_s = Some(time);
            found.oscillates = true;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_above_the_amplitude_alarms_and_one_below_does_not() {
        let period = 20.0;
        for (amplitude, alarms) in [(1.1, true), (0.9, false)] {
            let error: Vec<f64> = (0..20_000)
                .map(|k| amplitude * (2.0 * PI * f64::from(k) * 0.1 / period + 0.1).sin())
                .collect();
            let found = supervise(&error, 0.1, &Supervision::new(1.0, period));
            assert_eq!(found.oscillates, alarms, "{found:?}");
            assert!((found.threshold - period / PI).abs() < 1e-12);
        }
    }

    #[test]
    fn single_disturbances_do_not_alarm() {
        let error: Vec<f64> = (0..10_000)
            .map(|k| {
                if k % 2000 < 100 {
                    5.0
                } else if k % 2 == 0 {
                    0.01
                } else {
                    -0.01
                }
            })
            .collect();
        let found = supervise(&error, 1.0, &Supervision::new(1.0, 20.0));
        assert!(found.disturbances >= 4 && !found.oscillates, "{found:?}");
    }
}
