//! The thresholds of the verdict, chosen by their risk on loops that were not used for learning, and the cost and
//! benefit of each additional rule.
//!
//! Thresholds are tried from [`Decision::CAUTIOUS`] outwards, by a hundredth on each side in turn. A side that violates
//! a constraint stays at its last value. So the chance that the final thresholds violate a constraint is the chance of
//! a single test, for any number of tries (fixed sequence testing, as in A. Angelopoulos et al., "Learn then test",
//! 2021; recalled, not read). Tests of shares of all decisions are exact: the upper end of a one-sided binomial
//! interval of [`DOUBT`] must be within the bound. The thresholds hold for loops like the simulated ones. Kinds of
//! loops left out of training have a constraint of their own.

use crate::dataset::Dataset;
use crate::families::Families;
use crate::learn::fault;
use crate::measure::Share;
use anyhow::Result;
use rayon::prelude::*;
use statrs::distribution::{Beta, ContinuousCDF};
use std::collections::BTreeMap;
use std::fmt::Write;
use stiction_diagnose::diagnose::{DEAD_ZONE_BELOW, Ruling, Signs, VerdictClass};
use stiction_diagnose::evidence::Line;
use stiction_diagnose::fusion::{Bundle, Cause, Decision, Weighed};

/// The chance that a bound does not hold.
const DOUBT: f64 = 0.1;
/// Largest share of wrong decisions on loops that are healthy, or visibly faulty.
const WRONG: f64 = 0.04;
/// Largest share of accused loops, among all healthy loops and among the loops of each kind.
const ACCUSED: f64 = 0.01;
const ACCUSED_OF_KIND: f64 = 0.03;
/// Largest share of cleared sticking loops whose S exceeds the reported limit.
const BROKEN: f64 = 0.05;
/// Largest share of wrong decisions on families that training has not seen: the share of wrong decisions, plus its
/// increase when a family is left out.
const LEFT_OUT: f64 = 0.05;
/// End of the search.
const ENDS: Decision = Decision { accuse: 0.6, clear: 0.4 };
/// Smallest number of loops of a share that can stop the search.
const FEWEST: usize = 200;

/// A loop to decide.
struct Case<'a> {
    says: Weighed,
    signs: Signs,
    /// Standard errors by which a sticking valve predicts the PV better.
    z: f64,
    kind: &'a str,
    fault: Option<bool>,
    /// For a valve that sticks, percent of span.
    s: Option<f64>,
}

/// A rule that prevents a decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rule {
    /// Unlike the training.
    Strange,
    /// A dead zone elsewhere is likely.
    DeadZone,
    /// S is too small to be a fault.
    Harmless,
    /// No limit below twice the range of the OP.
    NoLimit,
    /// Two lines of evidence that are sure of opposites.
    Contradiction,
    /// No line alone gives 80 %.
    Unsupported,
    /// A sticking valve predicts the PV better by three standard errors.
    Veto,
}

impl Rule {
    /// The rules of the verdict, which can be left out, and former rules, which can be added.
    const KEPT: [Self; 3] = [Self::Strange, Self::Harmless, Self::NoLimit];
    const DROPPED: [Self; 4] = [Self::DeadZone, Self::Contradiction, Self::Unsupported, Self::Veto];

    fn name(self) -> &'static str {
        match self {
            Self::Strange => "unlike the training loops",
            Self::DeadZone => "accused only if play or a dead zone elsewhere is below 3 %",
            Self::Harmless => "S up to 0.25 % is no fault",
            Self::NoLimit => "cleared only with a limit up to twice the OP's range",
            Self::Contradiction => "undecided if two lines of evidence are sure of opposites",
            Self::Unsupported => "accused only if one line alone gives 80 %",
            Self::Veto => "not cleared if a sticking valve predicts better by 3 standard errors",
        }
    }

    /// The inputs without the inputs of a current rule.
    fn silenced(self, signs: Signs) -> Signs {
        match self {
            Self::Strange => Signs { distance: 0.0, ..signs },
            Self::Harmless => Signs { s: f64::INFINITY, ..signs },
            Self::NoLimit => Signs {
                limit: Some(signs.limit.unwrap_or(f64::INFINITY)),
                op_range: f64::INFINITY,
                ..signs
            },
            Self::DeadZone | Self::Contradiction | Self::Unsupported | Self::Veto => signs,
        }
    }

    /// Whether a former rule would prevent this decision.
    fn forbids(self, case: &Case<'_>, class: VerdictClass) -> bool {
        let lines = || case.says.lines.iter().map(|(_, p): &(Line, f64)| *p);
        match self {
            Self::DeadZone => {
                let accuses = matches!(class, VerdictClass::Sticks | VerdictClass::DoesNotRespond);
                accuses && case.says.of(Cause::DeadZoneElsewhere) >= DEAD_ZONE_BELOW
            }
            Self::Contradiction => lines().any(|p| p < 0.05) && lines().any(|p| p > 0.95),
            Self::Unsupported => class == VerdictClass::Sticks && !lines().any(|p| p >= 0.8),
            Self::Veto => class == VerdictClass::DoesNotStick && case.z >= 3.0,
            _ => false,
        }
    }
}

/// Counts of decisions.
#[derive(Debug, Clone, Default)]
struct Counts {
    decided: Share,
    wrong: Share,
    accused_wrong: Share,
    found: Share,
    cleared: Share,
    accused: Share,
    of_kinds: BTreeMap<String, Share>,
    broken: Share,
}

fn cases<'a>(bundle: &Bundle, data: &'a Dataset, rows: &[u32]) -> Result<Vec<Case<'a>>> {
    let place = |name: &str| data.columns.iter().position(|column| column.name == name);
    let (z, range) = (place("info_z"), place("info_range"));
    let of = |k: &u32| -> Result<Case<'a>> {
        let (k, truth) = (*k as usize, &data.truth[*k as usize]);
        let says = bundle.weigh(&data.row(k), truth.op_span, false)?;
        let value = |place: Option<usize>| place.map_or(f64::NAN, |c| f64::from(data.values[c][k]));
        let op_range = value(range).exp() * truth.op_span;
        let signs = Signs {
            probability: says.probability,
            distance: says.distance,
            mismatch: says.mismatch,
            idle: says.of(Cause::NoResponse) > says.of(Cause::StickingValve),
            s: says.s.value,
            limit: says.limit,
            op_range: if op_range.is_nan() { 0.0 } else { op_range },
        };
        Ok(Case {
            signs,
            z: if value(z).is_nan() { 0.0 } else { value(z) },
            kind: &truth.kind,
            fault: fault(truth),
            s: (truth.cause.is_fault() && truth.s > 0.0).then_some(truth.s),
            says,
        })
    };
    rows.par_iter().map(of).collect()
}

fn count(
    cases: &[Case<'_>],
    decision: &Decision,
    left_out: Option<Rule>,
    put_in: Option<Rule>,
) -> Counts {
    let mut counts = Counts::default();
    let add = |share: &mut Share, hit: bool| {
        share.n += 1;
        share.k += usize::from(hit);
    };
    for case in cases {
        let signs = left_out.map_or(case.signs, |rule| rule.silenced(case.signs));
        let class = match Ruling::of_signs(&signs, decision).class() {
            class if put_in.is_some_and(|rule| rule.forbids(case, class)) => {
                VerdictClass::CannotTell
            }
            class => class,
        };
        let clears = class == VerdictClass::DoesNotStick;
        if let Some(s) = case.s.filter(|_| clears) {
            add(&mut counts.broken, case.signs.limit.is_none_or(|limit| s > limit));
        }
        let Some(fault) = case.fault else { continue };
        let decided = class != VerdictClass::CannotTell;
        let accuses = decided && !clears;
        add(&mut counts.decided, decided);
        if decided {
            add(&mut counts.wrong, fault == clears);
        }
        if accuses {
            add(&mut counts.accused_wrong, !fault);
        }
        if fault {
            add(&mut counts.found, accuses);
        } else {
            add(&mut counts.accused, accuses);
            add(&mut counts.cleared, clears);
            add(counts.of_kinds.entry(case.kind.to_owned()).or_default(), accuses);
        }
    }
    counts
}

/// The upper end of the exact one-sided interval of a share (C. Clopper, E. Pearson, Biometrika 26 (1934) 404;
/// recalled, not read).
fn at_most(share: Share) -> f64 {
    let (k, n) = (share.k as f64, share.n as f64);
    match Beta::new(k + 1.0, n - k) {
        Ok(beta) if share.n > 0 && share.k < share.n => beta.inverse_cdf(1.0 - DOUBT),
        _ => 1.0,
    }
}

/// The quantity of a constraint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Constraint {
    Wrong,
    AccusedWrong,
    Accused,
    OfKind,
    Broken,
    LeftOut,
}

impl Constraint {
    const ALL: [Self; 6] =
        [Self::Wrong, Self::AccusedWrong, Self::Accused, Self::OfKind, Self::Broken, Self::LeftOut];

    fn name(self) -> &'static str {
        match self {
            Self::Wrong => "wrong decisions",
            Self::AccusedWrong => "wrong accusations",
            Self::Accused => "healthy accused",
            Self::OfKind => "worst kind accused",
            Self::Broken => "cleared above their limit",
            Self::LeftOut => "wrong decisions, plus the increase for left-out families",
        }
    }

    fn bound(self) -> f64 {
        match self {
            Self::Wrong | Self::AccusedWrong => WRONG,
            Self::Accused => ACCUSED,
            Self::OfKind => ACCUSED_OF_KIND,
            Self::Broken => BROKEN,
            Self::LeftOut => LEFT_OUT,
        }
    }

    /// The constrained value.
    fn value(self, counts: &Counts, left_out: f64) -> f64 {
        let told = |share: &&Share| share.n >= FEWEST;
        match self {
            Self::Wrong => at_most(counts.wrong),
            Self::AccusedWrong => at_most(counts.accused_wrong),
            Self::Accused => at_most(counts.accused),
            Self::OfKind => {
                counts.of_kinds.values().filter(told).map(|share| share.value()).fold(0.0, f64::max)
            }
            Self::Broken => Some(&counts.broken).filter(told).map_or(0.0, |share| share.value()),
            Self::LeftOut => counts.wrong.value() + left_out,
        }
    }
}

/// Tried thresholds, and the constraints that they violate.
struct Step {
    tried: Decision,
    values: [f64; Constraint::ALL.len()],
}

impl Step {
    /// Whether all constraints hold, except that on the limit. The limit is shifted after the search to keep its
    /// coverage.
    fn holds(&self) -> bool {
        let mut all = Constraint::ALL.into_iter().zip(self.values);
        all.all(|(each, value)| each == Constraint::Broken || value <= each.bound())
    }
}

/// The final thresholds, and the search.
pub struct Choice {
    pub decision: Decision,
    steps: Vec<Step>,
}

/// The thresholds within the constraints.
///
/// # Errors
/// If evidence cannot be weighed.
pub fn choose(
    bundle: &Bundle,
    data: &Dataset,
    rows: &[u32],
    families: Option<&Families>,
) -> Result<Choice> {
    let cases = cases(bundle, data, rows)?;
    let tried = |tried: Decision| {
        let counts = count(&cases, &tried, None, None);
        let left_out = families.map_or(0.0, |known| known.excess_beyond(tried.clear, tried.accuse));
        Step { tried, values: Constraint::ALL.map(|each| each.value(&counts, left_out)) }
    };
    // Hundredths, so that the tried values do not depend on the path.
    let outwards = |value: f64, by: f64| ((value + by) * 100.0).round() / 100.0;
    let mut decision = Decision::CAUTIOUS;
    let mut steps = vec![tried(decision)];
    let (mut accusing, mut clearing) = (steps[0].holds(), steps[0].holds());
    while accusing || clearing {
        accusing &= decision.accuse > ENDS.accuse;
        if accusing {
            let step = tried(Decision { accuse: outwards(decision.accuse, -0.01), ..decision });
            accusing = step.holds();
            decision = if accusing { step.tried } else { decision };
            steps.push(step);
        }
        clearing &= decision.clear < ENDS.clear;
        if clearing {
            let step = tried(Decision { clear: outwards(decision.clear, 0.01), ..decision });
            clearing = step.holds();
            decision = if clearing { step.tried } else { decision };
            steps.push(step);
        }
    }
    Ok(Choice { decision, steps })
}

impl Choice {
    /// The search, as Markdown; a value in bold violates its bound.
    pub fn table(&self) -> String {
        let mut out = String::from("| accused from | cleared up to |");
        for each in Constraint::ALL {
            let _ = write!(out, " {} (at most {:.0} %) |", each.name(), 100.0 * each.bound());
        }
        let _ = writeln!(out, "\n|---|---|{}", "---|".repeat(Constraint::ALL.len()));
        for Step { tried, values } in &self.steps {
            let _ = write!(out, "| {:.0} % | {:.0} % |", 100.0 * tried.accuse, 100.0 * tried.clear);
            for (each, value) in Constraint::ALL.into_iter().zip(values) {
                let mark = if *value > each.bound() { "**" } else { "" };
                let _ = write!(out, " {mark}{:.1} %{mark} |", 100.0 * value);
            }
            out.push('\n');
        }
        out
    }
}

/// The results of the thresholds on some loops, and the effect of each rule, as Markdown.
///
/// # Errors
/// If evidence cannot be weighed.
pub fn table(bundle: &Bundle, data: &Dataset) -> Result<String> {
    let rows: Vec<u32> = (0..data.truth.len() as u32).collect();
    let cases = cases(bundle, data, &rows)?;
    let decision = &bundle.decision;
    let mut out = format!(
        "A valve is accused from {:.0} % and cleared up to {:.0} %.\n\n\
         | rules | decided | right | faults found | healthy cleared | healthy accused | worst kind | cleared above their limit |\n\
         |---|---|---|---|---|---|---|---|\n",
        100.0 * decision.accuse,
        100.0 * decision.clear
    );
    let mut row = |name: &str, counts: &Counts| {
        let percent = |share: Share| format!("{:.1} %", 100.0 * share.value());
        let right = Share { k: counts.wrong.n - counts.wrong.k, n: counts.wrong.n };
        let worst = counts.of_kinds.iter().max_by(|a, b| a.1.value().total_cmp(&b.1.value()));
        let worst =
            worst.map_or(String::new(), |(kind, share)| format!("{kind} {}", percent(*share)));
        let Counts { decided, found, cleared, accused, broken, .. } = counts;
        let _ = writeln!(
            out,
            "| {name} | {} | {} | {} | {} | {} | {worst} | {} of {} |",
            percent(*decided),
            percent(right),
            percent(*found),
            percent(*cleared),
            percent(*accused),
            percent(*broken),
            broken.n
        );
    };
    row("those of the verdict", &count(&cases, decision, None, None));
    for rule in Rule::KEPT {
        row(&format!("without: {}", rule.name()), &count(&cases, decision, Some(rule), None));
    }
    for rule in Rule::DROPPED {
        row(&format!("with: {}", rule.name()), &count(&cases, decision, None, Some(rule)));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::tests::learned_from;
    use crate::members::Both;
    use crate::synthetic;

    #[test]
    fn bounds_are_exact() {
        // None of n: the interval ends where (1 - p)^n = DOUBT.
        for n in [10, 100, 1000] {
            let expected = 1.0 - DOUBT.powf(1.0 / n as f64);
            assert!((at_most(Share { k: 0, n }) - expected).abs() < 1e-9);
        }
        assert_eq!(at_most(Share { k: 5, n: 5 }), 1.0);
        assert_eq!(at_most(Share::default()), 1.0);
        assert!(at_most(Share { k: 30, n: 1000 }) > 0.03);
    }

    #[test]
    fn thresholds_keep_the_constraints_and_go_as_far_as_they_allow() {
        let data = synthetic::dataset(1, 8000);
        let both = Both { full: data.clone(), alone: data, mistaken: Dataset::default() };
        let bundle = learned_from(&both, false).bundle;
        let fresh = synthetic::dataset(2, 8000);
        let rows: Vec<u32> = (0..8000).collect();
        let choice = choose(&bundle, &fresh, &rows, None).unwrap();
        let decision = choice.decision;
        let cases = cases(&bundle, &fresh, &rows).unwrap();
        let counts = count(&cases, &decision, None, None);
        assert!(counts.accused.value() <= ACCUSED && counts.wrong.value() <= WRONG);
        assert!(choice.steps.iter().any(|step| step.tried == decision && step.holds()));
        // Each side was pushed until a constraint broke, or to the end.
        let broken = choice.steps.iter().filter(|step| !step.holds());
        let ended = usize::from(decision.accuse <= 0.6) + usize::from(decision.clear >= 0.4);
        assert_eq!(broken.count() + ended, 2);
        assert_eq!(choice.table().lines().count(), 2 + choice.steps.len());
        let told = table(&bundle, &fresh).unwrap();
        let rules = Rule::KEPT.into_iter().chain(Rule::DROPPED);
        assert!(rules.into_iter().all(|rule| told.contains(rule.name())));
    }
}
