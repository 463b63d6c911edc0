//! The answer of any detector about a loop, and all that is measured of many answers.

use super::auc::{Interval, recall_at, threshold_at};
use super::board::SEED;
use super::paired::{
    AucDifference, Discordant, auc_of_all, compare_auc, compare_decisions, is_called,
};
use super::{
    Auc, Band, Calibration, Counts, Errors, Member, Outcomes, Quantification, Ranked, RiskCoverage,
    SURE, Scored, Share, Truth, auc, logit, roc,
};
use rayon::prelude::*;
use std::collections::BTreeMap;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, Diagnosis, Estimate, diagnose};
use stiction_diagnose::finding::Decision;
use stiction_diagnose::methods::MethodId;
use stiction_diagnose::recording::Recording;
use stiction_model::error::Result;

/// Share of false alarms at which recall is compared.
pub const FEW_ALARMS: f64 = 0.01;

/// Lower ends of the bands of the gain, nats. Below 15.6 nats, a record does not show its valve to an observer who has
/// to find the stem, so these loops count as masked.
const NATS: [f64; 9] = [0.0, 2.0, 5.0, 10.0, 15.6, 25.0, 50.0, 100.0, 200.0];
/// Largest number of points of a receiver operating characteristic.
const POINTS: usize = 200;

/// What a detector answers about a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Larger values indicate sticking.
    pub score: Option<f64>,
    /// The probability that the valve sticks. Without a score, it ranks.
    pub probability: Option<f64>,
    /// Sticks, does not stick, or abstains.
    pub decision: Decision,
    /// The estimate of S, percent of span; ends that are NaN are unknown.
    pub s: Option<Estimate>,
    /// The estimate of J, percent of span.
    pub j: Option<Estimate>,
    /// Time for the answer, s; NaN if it was not measured alone.
    pub time_s: f64,
    /// The reason if there is no answer. It counts as an abstention.
    pub failure: Option<String>,
}

impl Answer {
    /// No answer, for this reason.
    pub fn none(reason: impl Into<String>, time_s: f64) -> Self {
        Self { failure: Some(reason.into()), ..Self::decided(Decision::Abstains, time_s) }
    }

    /// A decision alone: sticks, does not stick, or abstains.
    fn decided(decision: Decision, time_s: f64) -> Self {
        let decision = match decision {
            Decision::Sticks | Decision::Nonlinear => Decision::Sticks,
            Decision::DoesNotStick | Decision::Linear => Decision::DoesNotStick,
            Decision::Undecided | Decision::Abstains => Decision::Abstains,
        };
        Self { score: None, probability: None, decision, s: None, j: None, time_s, failure: None }
    }

    /// The number that ranks loops: the score, or else the logit of the probability.
    pub fn rank(&self) -> Option<f64> {
        self.score.or(self.probability.map(logit))
    }
}

/// The answer of the verdict, or of a method, about a recording.
///
/// # Errors
/// As [`diagnose`], for example if the OP has no usable sample.
pub fn answer_of(recording: &Recording, method: Option<MethodId>) -> Result<Answer> {
    let detectors = method.map_or(Detectors::None, |method| Detectors::Only(vec![method]));
    let options = DiagnoseOptions { detectors, plan: false, ..DiagnoseOptions::default() };
    let answers = answers_of(&diagnose(recording, &options)?, 0.0);
    let wanted = method.map_or(super::VERDICT, |method| method.name());
    let found = answers.into_iter().find(|(name, _)| *name == wanted);
    Ok(found.map_or_else(|| Answer::none("it has not answered", 0.0), |(_, answer)| answer))
}

/// The answers of the verdict and of each method that was run, with their names; the verdict first. The verdict abstains
/// where it cannot tell, and a method where it is undecided.
pub fn answers_of(diagnosis: &Diagnosis, time_s: f64) -> Vec<(&'static str, Answer)> {
    let scored = Scored::new(diagnosis, Truth::unknown());
    let (probability, s, j) = (scored.probability, scored.s, scored.j);
    let verdict = Answer { probability, s, j, ..Answer::decided(scored.decision(), time_s) };
    let methods = scored.methods.iter().map(|said| {
        let answer = Answer { score: said.score(), ..Answer::decided(said.decision, time_s) };
        (said.method.name, answer)
    });
    std::iter::once((super::VERDICT, verdict)).chain(methods).collect()
}

/// A property of a loop by which loops are grouped: the property, and its value.
pub type Group = (&'static str, String);

/// A loop of known truth, with its groups.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownLoop {
    /// Name.
    pub id: String,
    /// Truth.
    pub truth: Truth,
    /// Groups.
    pub groups: Vec<Group>,
}

impl KnownLoop {
    /// Whether it belongs to a class: masked stiction does not.
    pub fn counts(&self) -> bool {
        self.truth.visible || !self.truth.sticks
    }
}

/// All measures of a detector on some loops.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Measures {
    /// Loops that visibly stick.
    pub sticky: usize,
    /// Loops that do not stick.
    pub healthy: usize,
    /// Loops with masked stiction. They count in the measures by nats only.
    pub masked: usize,
    /// Loops with an answer.
    pub answered: Share,
    /// Reasons for missing answers, each with its number of loops, the most frequent first.
    pub failures: Vec<Failure>,
    /// Decisions.
    pub decisions: Outcomes,
    /// How well the score ranks loops.
    pub auc: Option<Auc>,
    /// Recall at the threshold with 1 % false alarms.
    pub recall_at_1_percent: Option<Interval>,
    /// Risk against coverage.
    pub risk: Option<RiskCoverage>,
    /// Loops by kind, those that stick first.
    pub kinds: Vec<KindMeasure>,
    /// Loops by other properties.
    pub groups: Vec<GroupMeasure>,
    /// Sticking loops by how clearly they show, masked ones too.
    pub nats: Vec<NatsMeasure>,
    /// Loops with a probability up to 2 % or from 98 %, and the wrong ones among these.
    pub sure: Option<Sure>,
    /// Accuracy of the probability.
    pub calibration: Option<Calibration>,
    /// Accuracy of the estimates of S.
    #[serde(rename = "S")]
    pub s: Option<Quantification>,
    /// Accuracy of the estimates of J.
    #[serde(rename = "J")]
    pub j: Option<Quantification>,
    /// False-alarm rate and recall at thresholds, over loops with a score.
    pub roc: Vec<[f64; 2]>,
}

/// A reason for missing answers.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct Failure {
    /// The reason.
    pub reason: String,
    /// How many loops have it.
    pub loops: usize,
    /// The first of them.
    pub first: String,
}

/// Decisions on one kind of loop.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct KindMeasure {
    /// The kind.
    pub kind: String,
    /// Whether its valves stick.
    pub sticks: bool,
    /// Decisions.
    pub decisions: Counts,
    /// Share of the loops called sticking: false alarms of a healthy kind, recall of a sticking one.
    pub called: Share,
    /// This share at the threshold with 1 % false alarms over all loops.
    pub at_1_percent: Share,
}

/// Measures of loops that share a property.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct GroupMeasure {
    /// The property.
    pub property: &'static str,
    /// Value.
    pub value: String,
    /// Decisions.
    pub decisions: Outcomes,
    /// AUC over all of them, with the interval of DeLong; a pair with a loop without a score counts half.
    pub auc: Option<Interval>,
}

/// Sticking loops with a similar gain of an observer who knows the stem.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct NatsMeasure {
    /// The band, nats.
    #[serde(flatten)]
    pub band: Band,
    /// Loops called sticking.
    pub called: Share,
    /// Loops above the threshold with 1 % false alarms.
    pub at_1_percent: Share,
    /// Recall at 1 % false alarms of the observer who knows the stem, the ceiling; null without loops.
    pub observer: Option<f64>,
}

/// Loops with a sure probability.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Sure {
    /// Share of the loops with a sure probability.
    pub sure: Share,
    /// Share of the sure loops whose probability is wrong.
    pub wrong: Share,
}

/// The comparison of two detectors on the same loops.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Comparison {
    /// Difference of the AUCs, by DeLong; null with fewer than two loops of a class.
    pub auc: Option<AucDifference>,
    /// Sticking loops that only one calls sticking, by McNemar.
    pub recall: Discordant,
    /// Healthy loops that only one calls sticking.
    pub false_alarms: Discordant,
}

impl Measures {
    /// Of loops with their answers.
    pub fn of(loops: &[(&KnownLoop, &Answer)]) -> Self {
        let seen: Vec<(&KnownLoop, &Answer)> =
            loops.iter().copied().filter(|(asked, _)| asked.counts()).collect();
        let ranked = ranked(&seen);
        let threshold = threshold_at(&ranked, FEW_ALARMS);
        let above = |answer: &Answer| match (answer.rank(), threshold) {
            (Some(score), Some(threshold)) => score >= threshold,
            _ => false,
        };
        let mut decisions = Outcomes::default();
        seen.iter().for_each(|(asked, answer)| decisions.add(asked.truth.sticks, answer.decision));
        let sure: Vec<(f64, bool)> = seen
            .iter()
            .filter_map(|(asked, answer)| Some((answer.probability?, asked.truth.sticks)))
            .collect();
        let estimated = |truth: fn(&Truth) -> Option<f64>,
                         said: fn(&Answer) -> Option<Estimate>| {
            let sticking = seen.iter().filter(|(asked, _)| asked.truth.sticks);
            let known: Vec<_> = sticking
                .filter_map(|(asked, answer)| Some((truth(&asked.truth)?, said(answer))))
                .collect();
            (!known.is_empty()).then(|| Quantification::of(known))
        };
        let curve = roc(&ranked);
        let every = curve.len().div_ceil(POINTS).max(1);
        let last = curve.len().saturating_sub(1);
        Self {
            sticky: decisions.sticky.all(),
            healthy: decisions.healthy.all(),
            masked: loops.len() - seen.len(),
            answered: Share::of(loops, |(_, answer)| answer.failure.is_none()),
            failures: failures(loops),
            decisions,
            auc: auc(&ranked, SEED),
            recall_at_1_percent: recall_at(&ranked, FEW_ALARMS, SEED),
            risk: RiskCoverage::of(&ranked, SEED),
            kinds: kinds(&seen, &above),
            groups: groups(&seen),
            nats: nats(loops, &above),
            sure: (!sure.is_empty()).then(|| {
                let is_sure = |p: f64| p <= SURE.0 || p >= SURE.1;
                let of: Vec<_> = sure.iter().filter(|(p, _)| is_sure(*p)).collect();
                Sure {
                    sure: Share { k: of.len(), n: seen.len() },
                    wrong: Share::of(&of, |(p, sticks)| (*p > 0.5) != *sticks),
                }
            }),
            calibration: Calibration::of(sure),
            s: estimated(|truth| truth.s, |answer| answer.s),
            j: estimated(|truth| truth.j, |answer| answer.j),
            roc: curve
                .into_iter()
                .enumerate()
                .filter(|(k, _)| k % every == 0 || *k == last)
                .map(|(_, (alarms, recall))| [alarms, recall])
                .collect(),
        }
    }
}

impl Comparison {
    /// Of the answers of two detectors to the same loops.
    pub fn of(loops: &[&KnownLoop], first: &[&Answer], second: &[&Answer]) -> Self {
        let both = |answers: &[&Answer]| -> Vec<Ranked> {
            let pairs: Vec<_> = loops.iter().copied().zip(answers.iter().copied()).collect();
            let seen: Vec<_> = pairs.into_iter().filter(|(asked, _)| asked.counts()).collect();
            ranked(&seen)
        };
        let discordant = |sticks: bool| {
            let answers = first.iter().zip(second).zip(loops);
            let of = answers.filter(|(_, asked)| asked.counts() && asked.truth.sticks == sticks);
            compare_decisions(of.map(|((a, b), _)| (a.decision, b.decision)))
        };
        Self {
            auc: compare_auc(&both(first), &both(second)),
            recall: discordant(true),
            false_alarms: discordant(false),
        }
    }
}

/// Times of answers, s; `None` if none was measured.
pub fn times<'a>(answers: impl IntoIterator<Item = &'a Answer>) -> Option<Errors> {
    let times = answers.into_iter().map(|answer| answer.time_s);
    let times: Vec<f64> = times.filter(|time_s| time_s.is_finite()).collect();
    Errors::of(&times)
}

fn ranked(loops: &[(&KnownLoop, &Answer)]) -> Vec<Ranked> {
    let mut numbers = BTreeMap::new();
    let one = |(asked, answer): &(&KnownLoop, &Answer)| {
        let next = numbers.len();
        let valve = *numbers.entry(asked.truth.valve.clone()).or_insert(next);
        Ranked { sticks: asked.truth.sticks, score: answer.rank(), valve }
    };
    loops.iter().map(one).collect()
}

fn failures(loops: &[(&KnownLoop, &Answer)]) -> Vec<Failure> {
    let mut found: Vec<Failure> = vec![];
    for (asked, answer) in loops {
        let Some(reason) = &answer.failure else { continue };
        match found.iter_mut().find(|each| each.reason == *reason) {
            Some(known) => known.loops += 1,
            None => {
                let first = asked.id.clone();
                found.push(Failure { reason: reason.clone(), loops: 1, first });
            }
        }
    }
    found.sort_by_key(|each| std::cmp::Reverse(each.loops));
    found
}

fn kinds(loops: &[(&KnownLoop, &Answer)], above: &dyn Fn(&Answer) -> bool) -> Vec<KindMeasure> {
    let mut found: BTreeMap<(bool, &str), (Counts, usize)> = BTreeMap::new();
    for (asked, answer) in loops.iter().filter(|(asked, _)| !asked.truth.kind.is_empty()) {
        // Those that stick come first.
        let row = found.entry((!asked.truth.sticks, &asked.truth.kind)).or_default();
        row.0.add(answer.decision);
        row.1 += usize::from(above(answer));
    }
    let row =
        |((healthy, kind), (decisions, above)): ((bool, &str), (Counts, usize))| KindMeasure {
            kind: kind.to_owned(),
            sticks: !healthy,
            decisions,
            called: Share { k: decisions.positive, n: decisions.all() },
            at_1_percent: Share { k: above, n: decisions.all() },
        };
    found.into_iter().map(row).collect()
}

fn groups(loops: &[(&KnownLoop, &Answer)]) -> Vec<GroupMeasure> {
    // In the order in which properties and values first occur in a sorted list of loops.
    let mut found: BTreeMap<(&'static str, &str), Vec<(&KnownLoop, &Answer)>> = BTreeMap::new();
    for (asked, answer) in loops {
        for (property, value) in &asked.groups {
            found.entry((property, value)).or_default().push((asked, answer));
        }
    }
    let measured =
        |((property, value), of): &((&'static str, &str), Vec<(&KnownLoop, &Answer)>)| {
            let mut decisions = Outcomes::default();
            of.iter()
                .for_each(|(asked, answer)| decisions.add(asked.truth.sticks, answer.decision));
            let auc = auc_of_all(&ranked(of));
            GroupMeasure { property, value: (*value).to_owned(), decisions, auc }
        };
    found.into_iter().collect::<Vec<_>>().par_iter().map(measured).collect()
}

fn nats(loops: &[(&KnownLoop, &Answer)], above: &dyn Fn(&Answer) -> bool) -> Vec<NatsMeasure> {
    // Valves that never slip, and those of a loop below, have no gain.
    let shown: Vec<(Member, &Answer)> = loops
        .iter()
        .filter(|(asked, _)| asked.truth.sticks)
        .filter_map(|(asked, answer)| Some((asked.truth.member?, *answer)))
        .filter(|(member, _)| member.slips > 0)
        .collect();
    if shown.is_empty() {
        return vec![];
    }
    let measured = |band: Band| {
        let of: Vec<_> = shown.iter().filter(|(m, _)| band.holds(m.gain.max(0.0))).collect();
        let share = |is: &dyn Fn(&Answer) -> bool| Share::of(&of, |(_, answer)| is(answer));
        let sum: f64 = of.iter().map(|(member, _)| observed(member.gain)).sum();
        NatsMeasure {
            band,
            called: share(&|answer| is_called(answer.decision)),
            at_1_percent: share(above),
            observer: (!of.is_empty()).then(|| sum / of.len() as f64),
        }
    };
    Band::beginning_at(&NATS).into_iter().map(measured).collect()
}

/// Recall at 1 % false alarms of an observer whose log-likelihood ratio gains this many nats. The ratio is normal with
/// the mean plus or minus `G` and the variance `2 G`, so the recall is `Phi(sqrt(2 G) - 2.326)`.
///
/// Source: W. W. Peterson, T. G. Birdsall, W. C. Fox, IRE Trans. PGIT-4 (1954) 171-212 (recalled, not read).
fn observed(gain: f64) -> f64 {
    /// The normal quantile below the top 1 %.
    const Z: f64 = 2.326_347_874_040_841;
    let z = (2.0 * gain.max(0.0)).sqrt() - Z;
    0.5 * statrs::function::erf::erfc(-z / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoreboard::scored::tests as blank;

    fn known_loop(k: usize, sticks: bool, gain: Option<f64>) -> KnownLoop {
        let truth = Truth {
            valve: k.to_string(),
            kind: if sticks { "sticky valve" } else { "saturation" }.to_owned(),
            sticks,
            visible: sticks && gain.is_none_or(|gain| gain >= 15.6),
            s: sticks.then_some(2.0),
            member: gain.map(|gain| Member { gain, slips: 3 }),
            ..blank::truth()
        };
        KnownLoop { id: format!("loop {k}"), truth, groups: vec![("half", (k % 2).to_string())] }
    }

    fn answer(score: f64, decision: Decision) -> Answer {
        Answer { score: Some(score), decision, failure: None, ..Answer::none("", 0.5) }
    }

    #[test]
    fn an_abstention_costs_recall_and_a_failure_is_listed() {
        use Decision::{Abstains, DoesNotStick, Sticks};
        let loops: Vec<KnownLoop> = (0..8).map(|k| known_loop(k, k < 4, None)).collect();
        let mut answers = vec![
            answer(5.0, Sticks),
            answer(4.0, Abstains),
            answer(1.0, DoesNotStick),
            Answer::none("it ended with exit code 1", 0.1),
            answer(3.0, Sticks),
            answer(0.0, DoesNotStick),
            answer(0.5, DoesNotStick),
            Answer::none("it ended with exit code 1", 0.1),
        ];
        answers[0].probability = Some(0.99);
        answers[4].probability = Some(0.985);
        answers[0].s = Some(Estimate { value: 2.5, low: f64::NAN, high: f64::NAN });
        let pairs: Vec<_> = loops.iter().zip(&answers).collect();
        let found = Measures::of(&pairs);
        assert_eq!((found.sticky, found.healthy, found.masked), (4, 4, 0));
        assert_eq!(found.decisions.recall(), Share { k: 1, n: 4 });
        assert_eq!(found.decisions.false_alarms(), Share { k: 1, n: 4 });
        assert_eq!(found.answered, Share { k: 6, n: 8 });
        assert_eq!((found.failures.len(), found.failures[0].loops), (1, 2));
        assert_eq!(found.failures[0].first, "loop 3");
        // No healthy loop may be called, so two remain above the threshold.
        assert_eq!(found.recall_at_1_percent.map(|r| r.value), Some(0.5));
        assert_eq!(found.kinds[0].at_1_percent, Share { k: 2, n: 4 });
        assert_eq!(found.sure.map(|sure| (sure.sure.k, sure.wrong.k)), Some((2, 1)));
        // An estimate without an interval is not covered, and not missed.
        let s = found.s.unwrap();
        assert_eq!((s.quantified, s.covered), (Share { k: 1, n: 4 }, Share { k: 0, n: 0 }));
        assert_eq!(found.groups.iter().map(|g| g.decisions.all()).collect::<Vec<_>>(), [4, 4]);
    }

    #[test]
    fn masked_stiction_counts_by_nats_only() {
        let loops = [
            known_loop(0, true, Some(1.0)),
            known_loop(1, true, Some(30.0)),
            known_loop(2, false, None),
        ];
        let answers = [
            answer(9.0, Decision::Sticks),
            answer(8.0, Decision::Sticks),
            answer(1.0, Decision::DoesNotStick),
        ];
        let found = Measures::of(&loops.iter().zip(&answers).collect::<Vec<_>>());
        assert_eq!((found.sticky, found.masked), (1, 1));
        let of = |from: f64| found.nats.iter().find(|row| row.band.from == from).unwrap();
        assert_eq!((of(0.0).called.k, of(25.0).called.k, of(50.0).called.n), (1, 1, 0));
        assert_eq!(of(50.0).observer, None);
        assert!(of(25.0).observer.unwrap() > 0.999);
    }

    #[test]
    fn the_measures_of_our_own_answers_are_those_of_the_board() {
        use crate::scoreboard::Board;
        let suite = crate::suite::Suite::by_name("v1-trial", None).unwrap();
        let horch: MethodId = "horch".parse().unwrap();
        let detectors = Detectors::Only(vec![horch]);
        let options = DiagnoseOptions { detectors, evidence: false, ..DiagnoseOptions::default() };
        let mut scored = vec![];
        let mut asked = vec![];
        let mut answers: BTreeMap<&str, Vec<Answer>> = BTreeMap::new();
        for k in 0..60 {
            let known = suite.known(k).unwrap();
            let diagnosis = diagnose(&known.recording, &options).unwrap();
            for (name, answer) in answers_of(&diagnosis, 0.1) {
                answers.entry(name).or_default().push(answer);
            }
            // Asked alone, the verdict answers the same.
            let alone = answer_of(&known.recording, None).unwrap();
            assert_eq!(Answer { time_s: 0.1, ..alone }, answers["verdict"][k]);
            scored.push(Scored::new(&diagnosis, known.asked.truth.clone()));
            asked.push(known.asked);
        }
        let board = Board::of(&scored);
        for row in &board.methods {
            let pairs: Vec<_> = asked.iter().zip(&answers[row.name()]).collect();
            let found = Measures::of(&pairs);
            assert_eq!(found.auc, row.auc, "{}", row.name());
            assert_eq!(found.decisions.recall(), row.recordings.recall());
            assert_eq!(found.decisions.false_alarms(), row.recordings.false_alarms());
            assert_eq!(found.decisions.accuracy(), row.recordings.accuracy());
            assert_eq!((found.sticky, found.healthy), (board.sticky, board.healthy));
            assert_eq!(found.masked, board.hidden.k);
            if row.method.is_none() {
                assert_eq!((found.s, found.j), (board.s, board.j));
                assert_eq!(found.calibration, board.calibration);
                assert_eq!(found.sure.map(|s| s.wrong), board.sureness.map(|s| s.wrong));
            }
        }
    }

    #[test]
    fn the_observer_is_the_ceiling_of_signal_detection() {
        // Without information it has the 1 % of its false alarms; at d' = 2.326 one half.
        assert!((observed(0.0) - 0.01).abs() < 1e-9);
        assert!((observed(2.326_347_874_040_841f64.powi(2) / 2.0) - 0.5).abs() < 1e-9);
        assert!(observed(15.6) > 0.999);
    }
}
