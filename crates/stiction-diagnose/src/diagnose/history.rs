//! Several recordings or windows of one valve together: their joint verdict, and whether the valve gets worse.
//!
//! The evidence of all windows together forms one [`Pool`], which the model of [`Valves`] weighs like that of one
//! recording. So a week gives the same result as one recording or as seven recordings. The log-odds of recordings
//! without a pool, such as those of a recorded position or of an OP alone, are averaged.
//!
//! # Drift of S
//!
//! A weighted least-squares line through `ln S` over time, because stiction grows by a share of itself. The weight of a
//! window is one over the squared width of its interval in `ln S`, which is at least [`NARROWEST`]. The drift is
//! significant only if two p-values are below [`SIGNIFICANT`]: the p-value of the line, and that of Mann and Kendall's
//! test, which is robust to outliers and to the shape of the trend. The median of all slopes (Theil and Sen) must also
//! have the same sign. Both tests assume that the errors of windows are independent; otherwise p-values are too small.

use super::by_evidence::{thresholds, thresholds_of_several};
use super::change::{Event, Seen, events, present_since};
use super::grade::PROBABLY_FROM;
use super::observation::Observation;
use super::verdict::{Grade, VerdictClass};
use super::weighing::mean_log_odds;
use crate::error::{Result, finite, non_negative, require};
use crate::fusion::{Estimate, Pool, Valves};
use crate::series::{mann_kendall, theil_sen, weighted_trend};
use crate::spoken::counted;
use std::collections::BTreeMap;

/// Smallest half-width of an interval of S, relative to S; ours.
pub const NARROWEST: f64 = 0.05;
/// Smallest number of windows with an S for a drift; ours.
pub const FEWEST_FOR_DRIFT: usize = 5;
/// Level below which a p-value is significant.
pub const SIGNIFICANT: f64 = 0.05;

/// The combined observations of one valve in its present state.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct History {
    /// The conclusion by the combined probability; without a combined probability, the conclusion with more than half
    /// of the weight of all decisions.
    pub class: VerdictClass,
    /// The grade of the conclusion, as in `Verdict`.
    pub grade: Grade,
    /// The combined probability that the valve sticks; `None` if no observation has one.
    pub probability: Option<f64>,
    /// Number of observations since the last change of the valve.
    #[cfg_attr(feature = "serde", serde(rename = "windows"))]
    pub observations: usize,
    /// Number of observations since the last change of the valve that decided or have a probability.
    pub decided: usize,
    /// The changes of the valve. Observations before the valve last began or ceased to stick do not count.
    pub changes: Vec<Event>,
    /// The drift of S; `None` with too few observations of S.
    pub drift: Option<Drift>,
    /// The drift of S in a sentence.
    pub trend: String,
}

/// The drift of S.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Drift {
    /// Growth of S as a share of S, 1/day; 0.01 is 1 % a day.
    pub per_day: f64,
    /// Lower end of the 95 % interval of the growth, 1/day.
    pub low: f64,
    /// Upper end of the 95 % interval of the growth, 1/day.
    pub high: f64,
    /// Two-sided p-value of the growth: the probability of a growth of this size or more if S does not drift.
    pub p_value: f64,
    /// Growth of S by the median of the slopes of all pairs of observations, 1/day.
    pub robust_per_day: f64,
    /// p-value of Mann and Kendall's test.
    pub robust_p_value: f64,
    /// Whether both tests and both slopes show that S drifts.
    pub significant: bool,
}

impl History {
    /// Since when the observations count, s, if the valve began or ceased to stick.
    pub fn since(&self) -> Option<f64> {
        Some(present_since(&self.changes)).filter(|since| since.is_finite())
    }
}

/// Combines observations of one valve, in any order. Only those since the valve began or ceased to stick count.
///
/// # Errors
/// As for [`together`].
pub fn combine(observations: &[Observation]) -> Result<History> {
    let observations = checked(observations)?;
    let of = |valve: &Observation| Seen { valve: valve.clone(), days: 0.0, moves: [None; 4] };
    let changes = events(&observations.iter().map(of).collect::<Vec<_>>(), &[]);
    let first = observations.partition_point(|seen| seen.time < present_since(&changes));
    Ok(History { changes, ..together(&observations[first..])? })
}

/// Combines observations of one valve, in any order, which is in one state all the time.
///
/// # Errors
/// If a time or an S is not finite, a probability not between 0 and 1, or a weight or number below 0. No
/// observations are not an error: they give `cannot tell`.
pub fn together(observations: &[Observation]) -> Result<History> {
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
    let pooled: f64 = observations.iter().filter(|o| o.pool.is_some()).map(|o| o.windows).sum();
    let limits = if pooled > 1.0 { thresholds_of_several() } else { thresholds() };
    let class = match (majority, probability) {
        // The cause is not stiction, at any probability.
        (Some(VerdictClass::DoesNotRespond), _) => VerdictClass::DoesNotRespond,
        (_, Some(p)) if p >= limits.accuse && bear_out(&observations, VerdictClass::Sticks) => {
            VerdictClass::Sticks
        }
        (_, Some(p))
            if p <= limits.clear && bear_out(&observations, VerdictClass::DoesNotStick) =>
        {
            VerdictClass::DoesNotStick
        }
        (_, Some(_)) => VerdictClass::CannotTell,
        (majority, None) => majority.unwrap_or(VerdictClass::CannotTell),
    };
    let (drift, trend) = drift(&observations);
    Ok(History {
        observations: observations.len(),
        decided: decided.len(),
        probability,
        class,
        grade: borne_out(class, probability, &observations),
        changes: vec![],
        drift,
        trend,
    })
}

/// Whether most of the observations with a probability of this class have the class themselves. An observation with
/// masked stiction, or unlike all training loops, does not become certain by repetition. Several observations that are
/// each too weak may accuse the valve together. They do not if most of the observations that are probable enough were
/// withheld for a different reason.
fn bear_out(observations: &[Observation], class: VerdictClass) -> bool {
    let share = |would: &dyn Fn(f64) -> bool, agrees: &dyn Fn(&Observation) -> bool| {
        let (mut borne_out, mut all) = (0.0, 0.0);
        for each in observations.iter().filter(|o| o.probability.is_some_and(would)) {
            all += each.weight;
            borne_out += if agrees(each) { each.weight } else { 0.0 };
        }
        (all > 0.0).then_some(borne_out / all)
    };
    let sticks = class == VerdictClass::Sticks;
    let decides = |p: f64| match sticks {
        true => p >= thresholds().accuse,
        false => p <= thresholds().clear,
    };
    match share(&decides, &|each| each.class == class) {
        Some(share) => share > 0.5,
        None if sticks => {
            let accuses = |o: &Observation| o.grade.is_none_or(Grade::accuses);
            share(&|p| p >= PROBABLY_FROM, &accuses).is_none_or(|share| share > 0.5)
        }
        None => false,
    }
}

/// The grade of several, if most observations that alone would give it have it themselves, else theirs. An observation
/// in which S is too small to be a fault, or which is unlike all training loops, does not accuse or clear the valve by
/// repetition.
fn borne_out(class: VerdictClass, probability: Option<f64>, observations: &[Observation]) -> Grade {
    let grade = Grade::of_several(class, probability);
    let is_open = class == VerdictClass::CannotTell && probability.is_some();
    let mut weights: BTreeMap<Grade, f64> = BTreeMap::new();
    for each in observations {
        let by = if is_open { VerdictClass::CannotTell } else { each.class };
        if Grade::of_several(by, each.probability) == grade {
            let own = each.grade.unwrap_or_else(|| Grade::of_several(each.class, each.probability));
            let own = match own {
                Grade::Fine | Grade::NoneVisible if is_open => Grade::ProbablyFine,
                own if is_open && own.accuses() => Grade::ProbablySticks,
                own => own,
            };
            *weights.entry(own).or_default() += each.weight;
        }
    }
    let agree = weights.remove(&grade).unwrap_or(0.0);
    let others = weights.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    others.filter(|(_, weight)| *weight >= agree).map_or(grade, |(other, _)| other)
}

/// The observations in order of time, if all their numbers are valid. Data that cannot answer have no share in a probability.
pub(super) fn checked(observations: &[Observation]) -> Result<Vec<Observation>> {
    for each in observations {
        finite("the time of an observation", each.time)?;
        non_negative("the weight of an observation", each.weight)?;
        non_negative("the number of windows of an observation", each.windows)?;
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
    for each in ordered.iter_mut().filter(|each| each.grade == Some(Grade::CannotAnswer)) {
        (each.probability, each.pool) = (None, None);
    }
    Ok(ordered)
}

/// The probability of all windows together. A single observation keeps its own bit for bit.
pub(super) fn combined_probability(observations: &[Observation]) -> Option<f64> {
    let known = observations.iter().filter(|o| o.weight > 0.0);
    let known: Vec<(&Observation, f64)> = known.filter_map(|o| Some((o, o.probability?))).collect();
    if let [(_, only)] = known[..] {
        return Some(only);
    }
    let pool = Pool::merged(known.iter().filter_map(|(o, _)| o.pool.as_ref()));
    let pooled = pool
        .and_then(|pool| Some((Valves::shipped().ok()?.weigh(&pool).probability, pool.windows())));
    let others = known.iter().filter(|(o, _)| o.pool.is_none());
    let others: Vec<(f64, f64)> =
        others.map(|(o, p)| (*p, o.weight * o.windows.max(1.0))).collect();
    match (pooled, &others[..]) {
        (None, []) => None,
        (Some((only, _)), []) => Some(only),
        _ => Some(mean_log_odds(pooled.into_iter().chain(others))),
    }
}

const DAY: f64 = 86_400.0;

fn drift(observations: &[Observation]) -> (Option<Drift>, String) {
    // The logarithm excludes a valve without stiction.
    let known: Vec<(f64, Estimate)> = observations
        .iter()
        .filter_map(|o| Some((o.time / DAY, o.s.filter(|s| s.value > 0.0)?)))
        .collect();
    if known.len() < FEWEST_FOR_DRIFT {
        let windows = counted(known.len(), "window");
        return (
            None,
            format!("S is known in {windows}, but a drift needs {FEWEST_FOR_DRIFT} windows."),
        );
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
        return (
            None,
            "The drift of S is unknown, because all windows have the same time.".to_owned(),
        );
    };
    let robust_p_value = mann_kendall(&logarithms);
    let drift = Drift {
        per_day: line.slope,
        low: line.low,
        high: line.high,
        p_value: line.p_value,
        robust_per_day: robust,
        robust_p_value,
        significant: line.p_value < SIGNIFICANT
            && robust_p_value < SIGNIFICANT
            && line.slope * robust > 0.0,
    };
    (Some(drift), trend(&drift))
}

fn trend(drift: &Drift) -> String {
    let figures = format!(
        "{:+.2} % a day (95 % interval {:+.2} to {:+.2}); {}, Mann-Kendall {}",
        100.0 * drift.per_day,
        100.0 * drift.low,
        100.0 * drift.high,
        p_value(drift.p_value),
        p_value(drift.robust_p_value)
    );
    let verb = if drift.per_day > 0.0 { "grows" } else { "shrinks" };
    if drift.significant {
        format!("S {verb}: {figures}.")
    } else {
        format!("S does not drift significantly: {figures}.")
    }
}

/// A p-value as text.
pub(super) fn p_value(p: f64) -> String {
    if p < 0.001 { "p < 0.001".to_owned() } else { format!("p = {p:.3}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::change::Change;

    fn seen(day: f64, probability: Option<f64>, s: Option<f64>) -> Observation {
        Observation {
            grade: None,
            time: day * DAY,
            class: match probability {
                Some(p) if p <= thresholds().clear => VerdictClass::DoesNotStick,
                Some(p) if p >= thresholds().accuse => VerdictClass::Sticks,
                _ => VerdictClass::CannotTell,
            },
            probability,
            s: s.map(|value| Estimate { value, low: 0.8 * value, high: 1.2 * value }),
            j: None,
            weight: 1.0,
            windows: 1.0,
            pool: None,
        }
    }

    fn of(probabilities: &[f64]) -> History {
        let all: Vec<Observation> =
            probabilities.iter().enumerate().map(|(k, p)| seen(k as f64, Some(*p), None)).collect();
        combine(&all).unwrap()
    }

    #[test]
    fn one_keeps_its_probability_and_none_decides_alone() {
        assert_eq!(of(&[0.8]).probability, Some(0.8));
        assert_eq!(of(&[0.9, 0.1, 0.9, 0.1]).class, VerdictClass::CannotTell);
        assert_eq!(of(&[0.98, 0.9, 0.95]).class, VerdictClass::Sticks);
        assert_eq!(of(&[0.02, 0.1, 0.05]).class, VerdictClass::DoesNotStick);
        // However sure it says it is.
        assert_eq!(of(&[1.0, 0.2, 0.2, 0.2, 0.2, 0.2]).class, VerdictClass::CannotTell);
    }

    #[test]
    fn data_that_cannot_answer_have_no_share() {
        let mut all = vec![seen(0.0, Some(0.3), None), seen(1.0, Some(0.4), None)];
        let without = combine(&all).unwrap();
        all.push(Observation {
            class: VerdictClass::CannotTell,
            grade: Some(Grade::CannotAnswer),
            ..seen(2.0, Some(0.97), None)
        });
        let with = combine(&all).unwrap();
        assert_eq!((with.probability, with.decided), (without.probability, without.decided));
        assert_eq!(with.observations, 3);
    }

    #[test]
    fn a_day_is_not_accused_or_cleared_by_repetition() {
        let day = |k: i32, p: f64, grade: Grade| Observation {
            class: VerdictClass::CannotTell,
            grade: Some(grade),
            ..seen(f64::from(k), Some(p), None)
        };
        let week = |days: &[(f64, Grade)]| {
            let all: Vec<_> = (0..).zip(days).map(|(k, (p, grade))| day(k, *p, *grade)).collect();
            combine(&all).unwrap().grade
        };
        // S is too small to be a fault, on one day and on all.
        let small = (0.92, Grade::TooLittle);
        assert_eq!(week(&[small]), Grade::TooLittle);
        assert_eq!(week(&[small; 5]), Grade::TooLittle);
        assert_eq!(week(&[small, (0.82, Grade::ProbablySticks)]), Grade::TooLittle);
        let accused = (0.88, Grade::ProbablySticks);
        assert_eq!(week(&[small, accused, accused]), Grade::ProbablySticks);
        // Unlike the training.
        assert_eq!(week(&[(0.9, Grade::Unclear); 3]), Grade::Unclear);
        assert_eq!(week(&[(0.1, Grade::Unclear); 3]), Grade::Unclear);
        // By votes of the methods alone, or by data that cannot answer.
        let voted = |k: i32, grade: Grade| Observation { probability: None, ..day(k, 0.5, grade) };
        let sticks = [0, 1].map(|k| Observation {
            class: VerdictClass::Sticks,
            ..voted(k, Grade::ProbablySticks)
        });
        assert_eq!(combine(&sticks).unwrap().grade, Grade::ProbablySticks);
        assert_eq!(week(&[(0.5, Grade::CannotAnswer)]), Grade::CannotAnswer);
        // Without what their windows say together, the agreement of days adds nothing.
        assert_eq!(week(&[(0.75, Grade::Unclear); 5]), Grade::Unclear);
    }

    #[test]
    fn the_verdict_is_of_the_present_valve() {
        let p = |k: usize| if k < 6 { 0.95 } else { 0.05 };
        let all: Vec<Observation> = (0..12).map(|k| seen(k as f64, Some(p(k)), None)).collect();
        let found = combine(&all).unwrap();
        assert_eq!((found.class, found.since()), (VerdictClass::DoesNotStick, Some(6.0 * DAY)));
        assert_eq!((found.observations, found.changes[0].change), (6, Change::Gone));
        // Those of the last state alone say the same.
        assert_eq!(found.probability, combine(&all[6..]).unwrap().probability);
        let onset: Vec<Observation> =
            all.iter().map(|o| Observation { time: -o.time, ..o.clone() }).collect();
        let found = combine(&onset).unwrap();
        assert_eq!((found.class, found.since()), (VerdictClass::Sticks, Some(-5.0 * DAY)));
        // Each side needs five.
        assert_eq!(combine(&all[..9]).unwrap().since(), None);
        assert_eq!(combine(&all[3..]).unwrap().since(), None);
    }

    #[test]
    fn days_too_weak_alone_may_accuse_together() {
        let days = |p: f64, grade: Grade| -> Vec<Observation> {
            let each =
                |k: i32| Observation { grade: Some(grade), ..seen(f64::from(k), Some(p), None) };
            (0..5).map(each).collect()
        };
        let sticks = |days: &[Observation]| bear_out(days, VerdictClass::Sticks);
        assert!(sticks(&days(0.85, Grade::ProbablySticks)) && sticks(&days(0.6, Grade::Unclear)));
        // What holds back each day holds back all.
        assert!(!sticks(&days(0.85, Grade::TooLittle)) && !sticks(&days(0.85, Grade::Unclear)));
        // They never clear it.
        assert!(!bear_out(&days(0.15, Grade::ProbablyFine), VerdictClass::DoesNotStick));
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
        assert!(drift.significant && history.trend.starts_with("S grows"));
        // Percent or parts per thousand: the drift is the same.
        let scaled: Vec<Observation> = all
            .iter()
            .map(|o| {
                let ten = |e: Estimate| Estimate {
                    value: 10.0 * e.value,
                    low: 10.0 * e.low,
                    high: 10.0 * e.high,
                };
                Observation { s: o.s.map(ten), ..o.clone() }
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
        assert!(!history.drift.unwrap().significant, "{}", history.trend);
        assert!(history.trend.contains("does not drift significantly"));
        let few = combine(&flat[..4]).unwrap();
        assert_eq!(few.drift, None);
        assert!(
            few.trend.contains("S is known in 4 windows, but a drift needs 5 windows."),
            "{}",
            few.trend
        );
        let same: Vec<Observation> =
            flat.iter().map(|o| Observation { time: 0.0, ..o.clone() }).collect();
        assert_eq!(combine(&same).unwrap().drift, None);
    }

    #[test]
    fn what_was_not_cleared_once_is_not_cleared_by_being_repeated() {
        let mut all: Vec<Observation> =
            (0..5).map(|k| seen(f64::from(k), Some(0.05), None)).collect();
        assert_eq!(combine(&all).unwrap().class, VerdictClass::DoesNotStick);
        // Blind: the probability is low, and nothing was concluded of it.
        all.iter_mut().take(3).for_each(|each| each.class = VerdictClass::CannotTell);
        assert_eq!(combine(&all).unwrap().class, VerdictClass::CannotTell);
    }

    #[test]
    fn what_was_not_accused_once_is_not_accused_by_being_repeated() {
        let mut all: Vec<Observation> =
            (0..5).map(|k| seen(f64::from(k), Some(0.95), None)).collect();
        assert_eq!(combine(&all).unwrap().class, VerdictClass::Sticks);
        // A dead zone elsewhere is as likely: the probability is high, and nothing was concluded of it.
        all.iter_mut().take(3).for_each(|each| each.class = VerdictClass::CannotTell);
        let history = combine(&all).unwrap();
        assert_eq!(
            (history.class, history.grade),
            (VerdictClass::CannotTell, Grade::ProbablySticks)
        );
    }

    #[test]
    fn nonsense_is_refused() {
        for wrong in [
            Observation { time: f64::NAN, ..seen(0.0, None, None) },
            Observation { weight: -1.0, ..seen(0.0, None, None) },
            Observation { windows: f64::NAN, ..seen(0.0, None, None) },
            seen(0.0, Some(1.5), None),
            seen(0.0, Some(f64::NAN), None),
            seen(0.0, None, Some(f64::INFINITY)),
        ] {
            assert!(combine(&[wrong]).is_err());
        }
    }
}
