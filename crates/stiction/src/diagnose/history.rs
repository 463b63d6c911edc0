//! Several recordings, or windows, of one valve together: what they say as a whole, and whether it gets
//! worse.
//!
//! # How probabilities are combined
//!
//! Windows of one valve are no independent witnesses: they share the valve, the loop and whatever the
//! model has wrong about both. With log-odds `l_i` of weights `w_i`,
//!
//! ```text
//! l = n_e * sum(w_i l_i)/sum(w_i),   n_e = n/(1 + (n - 1) rho),   n = (sum w_i)^2/sum(w_i^2)
//! ```
//!
//! where `n` is Kish's effective number of windows and `rho` the correlation of their errors
//! ([`CORRELATION`]). One window keeps its probability; however many agree, they count for no more than
//! `1/rho` independent ones; and windows that disagree leave the question open. Log-odds are limited to
//! those of [`SUREST`], so that no window decides alone. The rule is ours, and its `rho` was fitted to
//! nothing; that of effective sizes is L. Kish, "Survey Sampling", Wiley, 1965 (recalled, not read).
//!
//! # Drift of S
//!
//! A line of weighted least squares through `ln S` over time, because stiction grows by a share of itself;
//! the weight of a window is one over the squared width of its interval in `ln S`, which no window has
//! narrower than [`NARROWEST`]. Called significant only if its p-value and that of Mann and Kendall's test,
//! which minds neither outliers nor the shape of the trend, are both below [`SIGNIFICANT`], and the median
//! of all slopes (Theil and Sen) has the same sign. Both tests assume that windows err independently; where
//! they do not, p-values are too small.

use super::verdict::{ACCUSED_FROM, CLEARED_UP_TO, VerdictClass};
use crate::error::{Result, finite, non_negative, require};
use crate::fusion::Estimate;
use crate::series::{mann_kendall, theil_sen, weighted_trend};

/// Assumed correlation of the errors of two windows of one valve; ours.
pub const CORRELATION: f64 = 0.5;
/// The surest a window may be, as a probability; ours.
pub const SUREST: f64 = 0.99;
/// Smallest half-width that an interval of S is believed to have, relative to S; ours.
pub const NARROWEST: f64 = 0.05;
/// Windows with an S below which no drift is told; ours.
pub const FEWEST_FOR_DRIFT: usize = 5;
/// Level below which a p-value is called significant.
pub const SIGNIFICANT: f64 = 0.05;

/// What one recording, or one window, said of a valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// When, s on a clock that all observations share.
    pub time: f64,
    /// The conclusion.
    pub class: VerdictClass,
    /// The probability that the valve sticks, where there is one.
    pub probability: Option<f64>,
    /// Stick band plus dead band, percent of span, where it was quantified.
    pub s: Option<Estimate>,
    /// Slip jump, percent of span, where it was quantified.
    pub j: Option<Estimate>,
    /// How much it counts in the combination, such as its number of cycles; 1 for all alike.
    pub weight: f64,
}

/// What observations of one valve say together.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    /// How many observations there are.
    pub observations: usize,
    /// How many of them decided, or have a probability.
    pub decided: usize,
    /// The combined probability that the valve sticks; `None` if no observation has one.
    pub probability: Option<f64>,
    /// The conclusion: by the combined probability, else that of more than half of the weight of those
    /// that decided.
    pub class: VerdictClass,
    /// Whether S drifts; `None` with too few observations of S.
    pub drift: Option<Drift>,
    /// What there is to say of the drift, a sentence.
    pub trend: String,
}

/// The drift of S.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Growth of S as a share of itself, 1/day: 0.01 is 1 % a day.
    pub per_day: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// Probability of as much if there were no drift, two-sided.
    pub p_value: f64,
    /// The same by the median of the slopes of all pairs, 1/day.
    pub robust_per_day: f64,
    /// p-value of Mann and Kendall's test.
    pub robust_p_value: f64,
}

impl Drift {
    /// Whether both tests and both slopes say that S drifts.
    pub fn is_significant(&self) -> bool {
        self.p_value < SIGNIFICANT
            && self.robust_p_value < SIGNIFICANT
            && self.per_day * self.robust_per_day > 0.0
    }
}

/// Combines observations of one valve, in any order.
///
/// # Errors
/// If a time or an S is not finite, a probability not between 0 and 1, or a weight below 0. No
/// observations at all are no error: they cannot tell.
pub fn combine(observations: &[Observation]) -> Result<History> {
    let observations = checked(observations)?;
    let decided: Vec<&Observation> = observations
        .iter()
        .filter(|o| o.probability.is_some() || o.class != VerdictClass::CannotTell)
        .collect();
    let probability = combined_probability(&observations);
    let mut weights = [0.0; VerdictClass::ALL.len()];
    for each in &decided {
        let place = VerdictClass::ALL.iter().position(|class| *class == each.class);
        weights[place.unwrap_or_default()] += each.weight;
    }
    let total: f64 = weights.iter().sum();
    let majority = VerdictClass::ALL
        .into_iter()
        .zip(weights)
        .find_map(|(class, weight)| (2.0 * weight > total).then_some(class));
    let class = match (majority, probability) {
        // Its cause is another one than stiction, whatever the probability of that.
        (Some(VerdictClass::DoesNotRespond), _) => VerdictClass::DoesNotRespond,
        (_, Some(p)) if p >= ACCUSED_FROM => VerdictClass::Sticks,
        (_, Some(p)) if p <= CLEARED_UP_TO => VerdictClass::DoesNotStick,
        (_, Some(_)) => VerdictClass::CannotTell,
        (majority, None) => majority.unwrap_or(VerdictClass::CannotTell),
    };
    let (drift, trend) = drift(&observations);
    Ok(History {
        observations: observations.len(),
        decided: decided.len(),
        probability,
        class,
        drift,
        trend,
    })
}

/// The observations in order of time, if all their numbers make sense.
pub(super) fn checked(observations: &[Observation]) -> Result<Vec<Observation>> {
    for each in observations {
        finite("the time of an observation", each.time)?;
        non_negative("the weight of an observation", each.weight)?;
        if let Some(p) = each.probability {
            require("a probability", p, (0.0..=1.0).contains(&p), "between 0 and 1")?;
        }
        for estimate in [each.s, each.j].into_iter().flatten() {
            for value in [estimate.value, estimate.low, estimate.high] {
                finite("an estimate of S or J", value)?;
            }
        }
    }
    let mut ordered = observations.to_vec();
    ordered.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(ordered)
}

/// Log-odds, those of [`SUREST`] at most.
pub(super) fn log_odds(probability: f64) -> f64 {
    let p = probability.clamp(1.0 - SUREST, SUREST);
    (p / (1.0 - p)).ln()
}

pub(super) fn combined_probability(observations: &[Observation]) -> Option<f64> {
    let parts: Vec<(f64, f64)> = observations
        .iter()
        .filter(|o| o.weight > 0.0)
        .filter_map(|o| Some((o.weight, log_odds(o.probability?))))
        .collect();
    let total: f64 = parts.iter().map(|(w, _)| w).sum();
    let squares: f64 = parts.iter().map(|(w, _)| w * w).sum();
    if parts.is_empty() {
        return None;
    }
    let n = total * total / squares;
    let effective = n / (1.0 + (n - 1.0) * CORRELATION);
    let mean = parts.iter().map(|(w, l)| w * l).sum::<f64>() / total;
    Some(1.0 / (1.0 + (-effective * mean).exp()))
}

const DAY: f64 = 86_400.0;

fn drift(observations: &[Observation]) -> (Option<Drift>, String) {
    // The logarithm has no place for a valve of no stiction at all.
    let known: Vec<(f64, Estimate)> = observations
        .iter()
        .filter_map(|o| Some((o.time / DAY, o.s.filter(|s| s.value > 0.0)?)))
        .collect();
    if known.len() < FEWEST_FOR_DRIFT {
        let why = format!(
            "Whether S drifts cannot be told: {} of the {FEWEST_FOR_DRIFT} windows with an S that it takes.",
            known.len()
        );
        return (None, why);
    }
    let days: Vec<f64> = known.iter().map(|(t, _)| t - known[0].0).collect();
    let logarithms: Vec<f64> = known.iter().map(|(_, s)| s.value.ln()).collect();
    let weight = |s: &Estimate| {
        let half = (s.high - s.low) / 2.0 / s.value;
        half.max(NARROWEST).powi(-2)
    };
    let weights: Vec<f64> = known.iter().map(|(_, s)| weight(s)).collect();
    let line = weighted_trend(&days, &logarithms, &weights);
    let Some((line, robust)) = line.zip(theil_sen(&days, &logarithms)) else {
        return (None, "Whether S drifts cannot be told: all windows are of one time.".to_owned());
    };
    let drift = Drift {
        per_day: line.slope,
        low: line.low,
        high: line.high,
        p_value: line.p_value,
        robust_per_day: robust,
        robust_p_value: mann_kendall(&logarithms),
    };
    (Some(drift), trend(&drift))
}

fn trend(drift: &Drift) -> String {
    let figures = format!(
        "{:+.2} % a day, 95 % interval {:+.2} to {:+.2}; {}, by Mann and Kendall {}",
        100.0 * drift.per_day,
        100.0 * drift.low,
        100.0 * drift.high,
        p_value(drift.p_value),
        p_value(drift.robust_p_value)
    );
    let verb = if drift.per_day > 0.0 { "grows" } else { "shrinks" };
    if drift.is_significant() {
        format!("S {verb}: {figures}.")
    } else {
        format!("S does not drift significantly: {figures}.")
    }
}

/// A p-value as it is written.
pub(super) fn p_value(p: f64) -> String {
    if p < 0.001 { "p < 0.001".to_owned() } else { format!("p = {p:.3}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(day: f64, probability: Option<f64>, s: Option<f64>) -> Observation {
        Observation {
            time: day * DAY,
            class: VerdictClass::CannotTell,
            probability,
            s: s.map(|value| Estimate { value, low: 0.8 * value, high: 1.2 * value }),
            j: None,
            weight: 1.0,
        }
    }

    fn of(probabilities: &[f64]) -> History {
        let all: Vec<Observation> =
            probabilities.iter().enumerate().map(|(k, p)| seen(k as f64, Some(*p), None)).collect();
        combine(&all).unwrap()
    }

    #[test]
    fn one_window_keeps_its_probability_and_many_do_not_run_away() {
        assert!((of(&[0.8]).probability.unwrap() - 0.8).abs() < 1e-12);
        // Two of 0.8 count as 2/(1 + 0.5) = 4/3: odds 4^(4/3).
        let odds = 4f64.powf(4.0 / 3.0);
        assert!((of(&[0.8, 0.8]).probability.unwrap() - odds / (1.0 + odds)).abs() < 1e-12);
        // However many: no more than two independent ones, odds 16.
        let many = of(&[0.8; 500]).probability.unwrap();
        assert!(many < 16.0 / 17.0 && many > 15.5 / 16.5, "{many}");
    }

    #[test]
    fn disagreement_stays_open_and_mirror_images_mirror() {
        let open = of(&[0.9, 0.1, 0.9, 0.1]);
        assert!((open.probability.unwrap() - 0.5).abs() < 1e-12);
        assert_eq!(open.class, VerdictClass::CannotTell);
        let (up, down) = (of(&[0.98, 0.9, 0.95]), of(&[0.02, 0.1, 0.05]));
        assert!((up.probability.unwrap() + down.probability.unwrap() - 1.0).abs() < 1e-12);
        assert_eq!((up.class, down.class), (VerdictClass::Sticks, VerdictClass::DoesNotStick));
        // No window decides alone, however sure it says it is.
        assert_eq!(of(&[1.0, 0.2, 0.2, 0.2, 0.2, 0.2]).class, VerdictClass::CannotTell);
    }

    #[test]
    fn weights_and_order() {
        let mut all = vec![seen(0.0, Some(0.9), None), seen(1.0, Some(0.2), None)];
        all[1].weight = 0.0;
        assert!((combine(&all).unwrap().probability.unwrap() - 0.9).abs() < 1e-12);
        all[1].weight = 3.0;
        let history = combine(&all).unwrap();
        all.reverse();
        assert_eq!(history, combine(&all).unwrap());
        assert!(history.probability.unwrap() < 0.5);
    }

    #[test]
    fn without_probabilities_the_majority_of_those_that_decide_wins() {
        let of = |classes: &[VerdictClass]| {
            let each =
                |class: &VerdictClass| Observation { class: *class, ..seen(0.0, None, None) };
            combine(&classes.iter().map(each).collect::<Vec<_>>()).unwrap()
        };
        use VerdictClass::{CannotTell, DoesNotRespond, DoesNotStick, Sticks};
        let history = of(&[Sticks, CannotTell, Sticks, DoesNotStick, CannotTell]);
        assert_eq!((history.class, history.decided, history.probability), (Sticks, 3, None));
        assert_eq!(of(&[Sticks, DoesNotStick]).class, CannotTell);
        assert_eq!(of(&[DoesNotRespond; 2]).class, DoesNotRespond);
        assert_eq!(of(&[]).class, CannotTell);
    }

    #[test]
    fn exponential_growth_is_found_as_it_is() {
        let all: Vec<Observation> = (0..20)
            .map(|k| {
                let day = f64::from(k);
                let wobble = if k % 2 == 0 { 1.02 } else { 0.98 };
                seen(day, None, Some(2.0 * (0.03 * day).exp() * wobble))
            })
            .collect();
        let history = combine(&all).unwrap();
        let drift = history.drift.unwrap();
        assert!((drift.per_day - 0.03).abs() < 1e-3 && drift.low < 0.03 && drift.high > 0.03);
        assert!((drift.robust_per_day - 0.03).abs() < 2e-3);
        assert!(drift.is_significant() && history.trend.starts_with("S grows"));
        // Percent or parts per thousand: the drift is the same.
        let scaled: Vec<Observation> = all
            .iter()
            .map(|o| {
                let ten = |e: Estimate| Estimate {
                    value: 10.0 * e.value,
                    low: 10.0 * e.low,
                    high: 10.0 * e.high,
                };
                Observation { s: o.s.map(ten), ..*o }
            })
            .collect();
        let other = combine(&scaled).unwrap().drift.unwrap();
        assert!((other.per_day - drift.per_day).abs() < 1e-12);
    }

    #[test]
    fn chance_and_one_outlier_are_no_drift() {
        let values = [4.0, 4.4, 3.9, 4.2, 4.1, 3.8, 4.3, 4.0];
        let flat: Vec<Observation> =
            values.iter().enumerate().map(|(k, s)| seen(k as f64, None, Some(*s))).collect();
        let history = combine(&flat).unwrap();
        assert!(!history.drift.unwrap().is_significant(), "{}", history.trend);
        assert!(history.trend.contains("does not drift significantly"));
        let few = combine(&flat[..4]).unwrap();
        assert_eq!(few.drift, None);
        assert!(few.trend.contains("4 of the 5"), "{}", few.trend);
        let same: Vec<Observation> = flat.iter().map(|o| Observation { time: 0.0, ..*o }).collect();
        assert_eq!(combine(&same).unwrap().drift, None);
    }

    #[test]
    fn nonsense_is_refused() {
        for wrong in [
            Observation { time: f64::NAN, ..seen(0.0, None, None) },
            Observation { weight: -1.0, ..seen(0.0, None, None) },
            seen(0.0, Some(1.5), None),
            seen(0.0, Some(f64::NAN), None),
            seen(0.0, None, Some(f64::INFINITY)),
        ] {
            assert!(combine(&[wrong]).is_err());
        }
    }
}
