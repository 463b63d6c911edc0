//! The steady OP, from the cycle of a sticking valve.

use super::Instant;

/// Estimates the OP at which the loop would rest.
///
/// In a cycle under integral action the mean control error is 0, so the mean valve position is the position that holds
/// the set point. Over whole periods the OP has the same mean as the valve position if the cycle is as long above as
/// below. A period lasts from one upward crossing of the control error to the next. A crossing counts when the error
/// rises from below a quarter of its recent peak to above it. The estimate is valid once the means of two consecutive
/// periods agree.
#[derive(Debug, Clone)]
pub(super) struct SteadyOp {
    /// Largest difference between the means of two periods, percent of span.
    agree: f64,
    /// Memory of the peak, s.
    memory_s: f64,
    /// Time of the last sample.
    time_s: Option<f64>,
    peak: f64,
    /// Whether the error was below since the last crossing.
    armed: bool,
    /// Sum and number of the OP since the last crossing, once there was one.
    period: Option<(f64, f64)>,
    /// Mean of the period before.
    before: Option<f64>,
    value: Option<f64>,
}

impl SteadyOp {
    /// Without any sample.
    pub(super) fn new(agree: f64, memory_s: f64) -> Self {
        Self {
            agree,
            memory_s,
            time_s: None,
            peak: 0.0,
            armed: false,
            period: None,
            before: None,
            value: None,
        }
    }

    pub(super) fn reset(&mut self) {
        *self = Self::new(self.agree, self.memory_s);
    }

    /// Processes a sample at which the OP went to the valve.
    pub(super) fn take(&mut self, now: &Instant) {
        let e = now.error();
        let passed = self.time_s.map_or(0.0, |before| now.time_s - before);
        self.time_s = Some(now.time_s);
        self.peak = (self.peak * (-passed / self.memory_s).exp()).max(e.abs());
        if e < -0.25 * self.peak {
            self.armed = true;
        } else if self.armed && e > 0.25 * self.peak {
            self.armed = false;
            let mean = self.period.map(|(sum, count)| sum / count);
            let pair = mean.zip(self.before).filter(|(a, b)| (a - b).abs() <= self.agree);
            self.value = pair.map(|(a, b)| 0.5 * (a + b));
            (self.before, self.period) = (mean, Some((0.0, 0.0)));
        }
        if let Some((sum, count)) = &mut self.period {
            *sum += now.op;
            *count += 1.0;
        }
    }

    /// The estimate, if it is valid.
    pub(super) fn value(&self) -> Option<f64> {
        self.value
    }

    /// The largest recent control error.
    pub(super) fn peak(&self) -> f64 {
        self.peak
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_over_whole_periods_is_found_and_a_drift_is_not() {
        let seen = |drift: f64| {
            let mut steady = SteadyOp::new(0.5, 60.0);
            for k in 0..2_000 {
                let (t, pv) = (0.1 * k as f64, (0.05 * k as f64).sin());
                let op = 42.0 - 3.0 * (0.05 * k as f64 + 0.7).cos() + drift * t;
                steady.take(&Instant { time_s: t, sp: 0.0, pv, op });
            }
            steady.value()
        };
        assert!(seen(0.0).is_some_and(|op| (op - 42.0).abs() < 0.1));
        assert_eq!(seen(0.2), None);
    }
}
