//! The evidence of a stretch, window by window, weighed by the frozen model.
//!
//! A long stretch is looked at in [`windows`]. The probability is that of the mean log-odds of the windows. S is
//! that of the windows in which it is known, on average of their logarithms, and so are the ends of its interval:
//! windows of one valve share what is wrong with the model, so more of them do not make the interval
//! narrower.

use super::diagnosis::Window;
use crate::detect::Abstention;
use crate::evidence::{Evidence, Line, windows};
use crate::fusion::{self, Cause, Estimate, Weighed};
use crate::recording::Stretch;

/// An S is a number, and no mere bound, if its interval reaches at most this share of it to either side
/// on average.
pub const WIDEST: f64 = 0.35;
/// J is known if its interval is at most this wide, in S.
pub const WIDEST_J: f64 = 0.5;
/// Log-odds of one window, at most: none is more than that sure.
const MOST_LOG_ODDS: f64 = 6.0;

/// What the windows of a stretch come to.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighing {
    /// The windows, in order of time.
    pub windows: Vec<Window>,
    /// The evidence of each window.
    pub evidence: Vec<Evidence>,
    /// The probability that the valve is at fault: that it sticks or does not respond.
    pub probability: f64,
    /// What each line of evidence says by itself: the probability that it gives.
    pub lines: Vec<(Line, f64)>,
    /// The probability of every cause; they add up to one.
    pub causes: Vec<(Cause, f64)>,
    /// S if the valve sticks, percent of span, with its 90 % interval, however wide.
    pub s: Estimate,
    /// J over S if the valve sticks, with its 90 % interval, however wide.
    pub j_over_s: Estimate,
}

impl Weighing {
    /// Weighs a stretch; without a PV, by the shape of its OP alone.
    ///
    /// # Errors
    /// If nothing can be measured in any window, or the frozen model does not fit the evidence.
    pub fn of(stretch: &Stretch) -> Result<Self, Abstention> {
        let op_only = stretch.pv.is_none();
        let bundle = fusion::shipped().map_err(|error| Abstention(error.to_string()))?;
        let mut weighed: Vec<(Window, Evidence, Weighed)> = vec![];
        let mut why = None;
        for part in windows(stretch) {
            let evidence = match Evidence::of(&part) {
                Ok(evidence) => evidence,
                Err(abstention) => {
                    why = why.or(Some(abstention));
                    continue;
                }
            };
            let says = bundle
                .weigh(&evidence.values, evidence.op_span, op_only)
                .map_err(|error| Abstention(error.to_string()))?;
            let window = Window {
                from: part.from,
                duration: part.duration(),
                probability: says.probability,
                s: quantified(says.s),
                j: jump(says.s, says.j_over_s),
            };
            weighed.push((window, evidence, says));
        }
        if weighed.is_empty() {
            return Err(why.unwrap_or(Abstention("there is nothing to weigh".to_owned())));
        }
        let says: Vec<&Weighed> = weighed.iter().map(|(.., says)| says).collect();
        let probability = pooled(says.iter().map(|says| says.probability));
        let lines = (0..says[0].lines.len())
            .map(|k| (says[0].lines[k].0, pooled(says.iter().map(|says| says.lines[k].1))))
            .collect();
        // Of every window the shares among faults, and among the rest.
        let share = |cause: Cause| {
            let of = |says: &&Weighed| {
                let whole =
                    if cause.is_fault() { says.probability } else { 1.0 - says.probability };
                if whole > 0.0 { says.of(cause) / whole } else { 0.0 }
            };
            let mean = says.iter().map(of).sum::<f64>() / says.len() as f64;
            mean * if cause.is_fault() { probability } else { 1.0 - probability }
        };
        let causes = Cause::ALL.map(|cause| (cause, share(cause))).to_vec();
        // Where some windows quantify S, the others do not blur it.
        let known: Vec<&&Weighed> =
            says.iter().filter(|says| quantified(says.s).is_some()).collect();
        let counted: Vec<&Weighed> = match known.len() {
            0 => says.clone(),
            _ => known.into_iter().copied().collect(),
        };
        let mean = |of: &dyn Fn(&Weighed) -> f64| {
            counted.iter().map(|says| of(says)).sum::<f64>() / counted.len() as f64
        };
        let geometric = |of: &dyn Fn(&Weighed) -> f64| mean(&|says| of(says).ln()).exp();
        let s = Estimate {
            value: geometric(&|says| says.s.value),
            low: geometric(&|says| says.s.low),
            high: geometric(&|says| says.s.high),
        };
        let j_over_s = Estimate {
            value: mean(&|says| says.j_over_s.value),
            low: mean(&|says| says.j_over_s.low),
            high: mean(&|says| says.j_over_s.high),
        };
        let (windows, evidence) =
            weighed.into_iter().map(|(window, evidence, _)| (window, evidence)).unzip();
        Ok(Self { windows, evidence, probability, lines, causes, s, j_over_s })
    }

    /// The probability of a cause.
    pub fn likelihood(&self, cause: Cause) -> f64 {
        self.causes.iter().find(|(each, _)| *each == cause).map_or(0.0, |(_, share)| *share)
    }

    /// The window that says most of what all of them say: the one whose probability is the median's.
    pub fn typical(&self) -> &Evidence {
        let mut order: Vec<usize> = (0..self.windows.len()).collect();
        order.sort_by(|a, b| self.windows[*a].probability.total_cmp(&self.windows[*b].probability));
        &self.evidence[order[order.len() / 2]]
    }
}

/// The probability of the mean log-odds.
fn pooled(probabilities: impl Iterator<Item = f64>) -> f64 {
    let log_odds = |p: f64| (p / (1.0 - p)).ln().clamp(-MOST_LOG_ODDS, MOST_LOG_ODDS);
    let (sum, n, only) =
        probabilities.fold((0.0, 0, 0.5), |(sum, n, _), p| (sum + log_odds(p), n + 1, p));
    // One window says what it says, to the bit.
    if n == 1 { only } else { fusion::sigmoid(sum / n.max(1) as f64) }
}

/// An S that is a number.
pub(super) fn quantified(s: Estimate) -> Option<Estimate> {
    (s.high - s.low <= 2.0 * WIDEST * s.value).then_some(s)
}

/// A J that is a number, percent of span.
pub(super) fn jump(s: Estimate, j_over_s: Estimate) -> Option<Estimate> {
    quantified(s)?;
    let known = j_over_s.high - j_over_s.low <= WIDEST_J;
    known.then_some(Estimate {
        value: j_over_s.value * s.value,
        low: j_over_s.low * s.low,
        high: j_over_s.high * s.high,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_pool_their_log_odds() {
        assert_eq!(pooled([0.3].into_iter()), 0.3);
        assert!((pooled([0.2, 0.8].into_iter()) - 0.5).abs() < 1e-12);
        assert!(pooled([0.9, 0.8].into_iter()) < 0.9);
        // One sure window is no certainty.
        assert!(pooled([1.0, 0.01].into_iter()) < 0.85);
    }

    #[test]
    fn only_narrow_intervals_are_numbers() {
        let of = |low, high| Estimate { value: 4.0, low, high };
        assert!(quantified(of(3.0, 5.7)).is_some() && quantified(of(3.0, 5.9)).is_none());
        let j_over_s = Estimate { value: 0.5, low: 0.3, high: 0.7 };
        let j = jump(of(3.5, 4.5), j_over_s).unwrap();
        assert!((j.value - 2.0).abs() < 1e-12 && (j.low - 1.05).abs() < 1e-12);
        assert_eq!(jump(of(1.0, 9.0), j_over_s), None);
        assert_eq!(jump(of(3.5, 4.5), Estimate { low: 0.1, ..j_over_s }), None);
    }
}
