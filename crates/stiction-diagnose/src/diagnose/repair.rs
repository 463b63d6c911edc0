//! Whether a repair changed a valve: a comparison of the observations before and after the repair.
//!
//! Two contrasts: the log-odds of the probability that it sticks, and ln S. Each is tested by
//! [`difference_of_means`], two-sided, at half of [`SIGNIFICANT`], because there are two. With fewer than
//! [`FEWEST`] observations on a side a contrast is not tested, because chance alone could look like a repair.
//! Windows with common errors make p-values too small, so choose windows before and after from days of like
//! operation.

use super::by_evidence::thresholds;
use super::history::{SIGNIFICANT, checked, combined_probability, p_value};
use super::observation::Observation;
use super::weighing::log_odds;
use crate::error::{Result, finite};
use crate::series::{cliffs_delta, difference_of_means, mean};
use stiction_model::named;

/// Smallest number of observations on each side. With five, a random exchange gives as clear a difference in 2 of 252
/// cases; ours.
pub const FEWEST: usize = 5;

named! {
    /// The effect of a repair.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum RepairOutcome {
        /// It no longer sticks, or the remaining S hardly matters.
        Worked = "worked",
        /// It sticks less, but it still sticks.
        Helped = "helped",
        /// No difference can be shown.
        NoChange = "no change",
        /// It sticks more.
        Worse = "worse",
        /// There are too few observations on a side.
        CannotTell = "cannot tell",
    }
}

/// A quantity before and after a repair.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Contrast {
    /// Number of observations of the quantity before the repair.
    pub before_count: usize,
    /// Number of observations of the quantity after the repair.
    pub after_count: usize,
    /// Typical value before the repair.
    pub before: f64,
    /// Typical value after the repair.
    pub after: f64,
    /// Two-sided p-value: the probability of a difference of this size or more by chance.
    pub p_value: f64,
    /// Cliff's delta: from -1 (all fell) to 1 (all rose).
    pub delta: f64,
    /// Whether the difference is significant, with a correction for two tests.
    pub significant: bool,
}

/// The effect of a repair on a valve.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Repair {
    /// Time of the repair, s on the clock of the observations.
    #[cfg_attr(feature = "serde", serde(rename = "time_s"))]
    pub time: f64,
    /// Number of observations before the repair.
    pub before: usize,
    /// Number of observations after the repair.
    pub after: usize,
    /// The probability that the valve sticks before and after the repair, by mean log-odds; `None` with too few
    /// observations.
    pub probability: Option<Contrast>,
    /// S before and after the repair, percent of span, by geometric means; `None` with too few observations.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Contrast>,
    /// The outcome.
    pub outcome: RepairOutcome,
    /// The outcome of the repair in a sentence.
    pub words: String,
}

/// Compares observations of one valve before and after a repair at `time`. Observations at exactly that time count as
/// after.
///
/// # Errors
/// If `time` is not finite, or as for [`combine`](super::combine).
pub fn repair(observations: &[Observation], time: f64) -> Result<Repair> {
    finite("the time of the repair", time)?;
    let observations = checked(observations)?;
    let (before, after) =
        observations.split_at(observations.partition_point(|each| each.time < time));
    let odds = |side: &[Observation]| -> Vec<f64> {
        side.iter().filter_map(|o| o.probability.map(log_odds)).collect()
    };
    let logarithms = |side: &[Observation]| -> Vec<f64> {
        side.iter().filter_map(|o| o.s.filter(|s| s.value > 0.0).map(|s| s.value.ln())).collect()
    };
    let probability = contrast(&odds(before), &odds(after), |l| 1.0 / (1.0 + (-l).exp()));
    let s = contrast(&logarithms(before), &logarithms(after), f64::exp);
    let still = combined_probability(after);
    let outcome = outcome(probability, s, still);
    let words = words(outcome, probability, s, before.len(), after.len());
    Ok(Repair { time, before: before.len(), after: after.len(), probability, s, outcome, words })
}

fn contrast(before: &[f64], after: &[f64], back: fn(f64) -> f64) -> Option<Contrast> {
    if before.len() < FEWEST || after.len() < FEWEST {
        return None;
    }
    let p_value = difference_of_means(before, after)?;
    Some(Contrast {
        before_count: before.len(),
        after_count: after.len(),
        before: back(mean(before)),
        after: back(mean(after)),
        p_value,
        delta: cliffs_delta(before, after),
        significant: p_value < SIGNIFICANT / 2.0,
    })
}

/// A fall of S is not enough if the valve still certainly sticks. A fall of the probability is not enough if S is
/// unchanged. But either may be the only one available.
fn outcome(
    probability: Option<Contrast>,
    s: Option<Contrast>,
    still: Option<f64>,
) -> RepairOutcome {
    let known: Vec<Contrast> = [probability, s].into_iter().flatten().collect();
    if known.is_empty() {
        return RepairOutcome::CannotTell;
    }
    let moved =
        |sign: f64| known.iter().any(|c| c.significant && sign * (c.after - c.before) > 0.0);
    match (moved(-1.0), moved(1.0)) {
        (true, false) if still.is_some_and(|p| p >= thresholds().accuse) => RepairOutcome::Helped,
        // Half the old S, with no known probability of sticking, is an improvement, not a cure.
        (true, false) if still.is_none_or(|p| p > thresholds().clear) && !s.is_some_and(cured) => {
            RepairOutcome::Helped
        }
        (true, false) => RepairOutcome::Worked,
        (false, true) => RepairOutcome::Worse,
        _ => RepairOutcome::NoChange,
    }
}

/// Whether the remaining S hardly matters: less than a quarter, or less than 1 % of span.
fn cured(s: Contrast) -> bool {
    s.significant && s.after < s.before && (s.after < 0.25 * s.before || s.after < 1.0)
}

fn words(
    outcome: RepairOutcome,
    probability: Option<Contrast>,
    s: Option<Contrast>,
    before: usize,
    after: usize,
) -> String {
    if outcome == RepairOutcome::CannotTell {
        return format!(
            "The effect of the repair needs at least {FEWEST} windows with a probability or an S on each side; there \
             are {before} before and {after} after."
        );
    }
    let say = |what: &str, c: Contrast, factor: f64, digits: usize| {
        let verb = match c.after.total_cmp(&c.before) {
            _ if !c.significant => "went",
            std::cmp::Ordering::Less => "fell",
            _ => "rose",
        };
        format!(
            "{what} {verb} from {:.digits$} to {:.digits$} % ({})",
            factor * c.before,
            factor * c.after,
            p_value(c.p_value)
        )
    };
    let parts: Vec<String> = [
        s.map(|c| say("S", c, 1.0, 1)),
        probability.map(|c| say("probability of sticking", c, 100.0, 0)),
    ]
    .into_iter()
    .flatten()
    .collect();
    let end = match outcome {
        RepairOutcome::Worked => "the repair worked",
        RepairOutcome::Helped => "the repair helped, but the valve may still stick",
        RepairOutcome::Worse => "the valve sticks more than before the repair",
        _ => "no effect of the repair can be shown",
    };
    let text = format!("{}; {end}.", parts.join(", "));
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |c| c.to_uppercase().chain(chars).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::{Estimate, VerdictClass};

    fn seen(time: f64, p: f64, s: Option<f64>) -> Observation {
        Observation {
            grade: None,
            time,
            class: VerdictClass::CannotTell,
            probability: Some(p),
            s: s.map(|value| Estimate { value, low: 0.9 * value, high: 1.1 * value }),
            j: None,
            weight: 1.0,
            windows: 1.0,
            pool: None,
        }
    }

    fn series(before: &[(f64, f64)], after: &[(f64, f64)]) -> Vec<Observation> {
        let all = before.iter().chain(after).enumerate();
        all.map(|(k, (p, s))| seen(k as f64, *p, Some(*s))).collect()
    }

    const BAD: [(f64, f64); 5] = [(0.9, 4.0), (0.95, 4.2), (0.85, 4.1), (0.92, 3.9), (0.9, 4.3)];
    const GOOD: [(f64, f64); 5] =
        [(0.06, 0.6), (0.03, 0.5), (0.12, 0.7), (0.06, 0.6), (0.09, 0.65)];

    #[test]
    fn a_repair_that_works_is_reported_with_the_exact_p_value() {
        let found = repair(&series(&BAD, &GOOD), 5.0).unwrap();
        assert_eq!((found.before, found.after, found.outcome), (5, 5, RepairOutcome::Worked));
        let s = found.s.unwrap();
        assert_eq!((s.p_value, s.delta), (2.0 / 252.0, -1.0));
        // The geometric mean.
        let product: f64 = BAD.iter().map(|(_, s)| s).product();
        assert!((s.before - product.powf(0.2)).abs() < 1e-12);
        assert!(found.words.starts_with("S fell from 4.1 to 0.6 % (p = 0.008), probability"));
        assert!(found.words.ends_with("the repair worked."), "{}", found.words);
    }

    #[test]
    fn time_reversed_it_is_worse_and_alike_it_is_nothing() {
        let worse = repair(&series(&GOOD, &BAD), 5.0).unwrap();
        assert_eq!(worse.outcome, RepairOutcome::Worse);
        assert!(worse.words.contains("S rose from 0.6 to 4.1 %"), "{}", worse.words);
        let alike = repair(&series(&BAD, &BAD), 5.0).unwrap();
        assert_eq!(alike.outcome, RepairOutcome::NoChange);
        assert_eq!(alike.s.unwrap().p_value, 1.0);
    }

    #[test]
    fn a_smaller_s_of_a_valve_that_still_sticks_is_help() {
        let half: Vec<(f64, f64)> = BAD.iter().map(|(p, s)| (*p, s / 2.0)).collect();
        let found = repair(&series(&BAD, &half), 5.0).unwrap();
        assert_eq!(found.outcome, RepairOutcome::Helped, "{}", found.words);
    }

    #[test]
    fn too_few_cannot_tell() {
        let all = series(&BAD, &GOOD);
        for at in [4.0, 6.0, -1.0, 99.0] {
            let found = repair(&all, at).unwrap();
            assert_eq!(found.outcome, RepairOutcome::CannotTell, "{at}");
            assert!(found.words.contains("needs at least 5 windows"), "{}", found.words);
            assert_eq!(found.before + found.after, 10);
        }
        assert!(repair(&all, f64::NAN).is_err());
        // Without any S after, the probability alone speaks.
        let cured: Vec<Observation> = all
            .iter()
            .map(|o| if o.time < 5.0 { o.clone() } else { Observation { s: None, ..o.clone() } })
            .collect();
        let found = repair(&cured, 5.0).unwrap();
        assert_eq!((found.outcome, found.s), (RepairOutcome::Worked, None));
    }

    #[test]
    fn order_does_not_matter() {
        let mut all = series(&BAD, &GOOD);
        let found = repair(&all, 5.0).unwrap();
        all.reverse();
        assert_eq!(found, repair(&all, 5.0).unwrap());
    }
}
