//! All counts of some loops.

use super::auc::{Auc, Ranked, auc, by_valve, logit, roc};
use super::{
    Calibration, Counts, Found, Outcomes, Quantification, Scored, Share, Sureness, Undecided,
};
use rayon::prelude::*;
use std::collections::BTreeMap;
use stiction_diagnose::finding::{Decision, Method};

/// The name of the verdict among the methods.
pub const VERDICT: &str = "verdict";

/// Seed of the bootstrap. A different seed changes the last digit of an interval.
pub(super) const SEED: u64 = 20_260_101;

/// Accuracy of the verdict and the methods on some loops.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Board {
    /// Sticking loops. Loops with masked stiction are in neither class.
    pub sticky: usize,
    /// Loops that do not stick.
    pub healthy: usize,
    /// Loops that stick invisibly.
    #[serde(serialize_with = "counted")]
    #[schemars(with = "usize")]
    pub hidden: Share,
    /// Valves that stick.
    pub sticky_valves: usize,
    /// Valves that do not.
    pub healthy_valves: usize,
    /// The verdict, then the methods.
    pub methods: Vec<MethodRow>,
    /// Loops by kind; empty if no kind is known.
    pub kinds: Vec<KindRow>,
    /// Accuracy of the verdict's probability; null if no loop has one.
    pub calibration: Option<Calibration>,
    /// Accuracy of the estimates of S; null if no S is known.
    #[serde(rename = "S")]
    pub s: Option<Quantification>,
    /// Accuracy of the estimates of J; null if no J is known.
    #[serde(rename = "J")]
    pub j: Option<Quantification>,
    /// Accuracy of limits of S and sure probabilities; null if none exist.
    pub sureness: Option<Sureness>,
    /// Detected sticking valves by how clearly they show; null if no loop is a member of a mixed population.
    pub found: Option<Found>,
    /// Reasons for undecided loops; null if no loop is a member of a mixed population.
    pub undecided: Option<Undecided>,
}

/// Accuracy of a method.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct MethodRow {
    /// Name in commands and files.
    pub name: &'static str,
    /// Title.
    pub title: &'static str,
    /// The method; `None` is the verdict.
    #[serde(skip)]
    pub method: Option<&'static Method>,
    /// Decisions on recordings.
    pub recordings: Outcomes,
    /// Decisions on valves.
    pub valves: Outcomes,
    /// How well its statistic ranks recordings.
    pub auc: Option<Auc>,
    /// How well its mean ranks valves.
    pub auc_of_valves: Option<Auc>,
    /// False-alarm rate and recall at every threshold, over recordings with a score.
    #[serde(skip)]
    pub roc: Vec<(f64, f64)>,
}

/// The loops of one kind.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct KindRow {
    /// Name.
    pub kind: String,
    /// Whether its valves stick.
    pub sticks: bool,
    /// How many loops there are, less those that stick invisibly.
    pub loops: usize,
    /// Decisions of the verdict and each method on them, by name.
    #[serde(rename = "methods")]
    pub counts: BTreeMap<&'static str, Counts>,
}

fn counted<S: serde::Serializer>(share: &Share, to: S) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&share.k, to)
}

impl MethodRow {
    /// Name in commands and files.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Title.
    pub fn title(&self) -> &'static str {
        self.title
    }
}

impl Board {
    /// Counts loops. All loops must have the same methods. Methods that the first loop lacks are ignored.
    pub fn of(loops: &[Scored]) -> Self {
        let seen: Vec<&Scored> =
            loops.iter().filter(|each| each.truth.visible || !each.truth.sticks).collect();
        let sticking = loops.iter().filter(|each| each.truth.sticks).count();
        let mut numbers = BTreeMap::new();
        for each in &seen {
            let next = numbers.len();
            numbers.entry(each.truth.valve.as_str()).or_insert(next);
        }
        let valves: Vec<usize> =
            seen.iter().map(|each| numbers[each.truth.valve.as_str()]).collect();
        let asked: Vec<Option<&'static Method>> = std::iter::once(None)
            .chain(
                loops.iter().take(1).flat_map(|first| first.methods.iter().map(|m| Some(m.method))),
            )
            .collect();
        let methods: Vec<MethodRow> =
            asked.par_iter().map(|method| row(*method, &seen, &valves)).collect();
        let count = |sticks: bool| seen.iter().filter(|each| each.truth.sticks == sticks).count();
        let of_valves = methods[0].valves;
        let estimated =
            |of: fn(&Scored) -> (Option<f64>, Option<stiction_diagnose::diagnose::Estimate>)| {
                let known: Vec<_> = seen
                    .iter()
                    .filter(|each| each.truth.sticks)
                    .filter_map(|each| {
                        let (truth, estimate) = of(each);
                        Some((truth?, estimate))
                    })
                    .collect();
                (!known.is_empty()).then(|| Quantification::of(known))
            };
        Self {
            sticky: count(true),
            healthy: count(false),
            hidden: Share { k: loops.len() - seen.len(), n: sticking },
            sticky_valves: of_valves.sticky.all(),
            healthy_valves: of_valves.healthy.all(),
            kinds: kinds(&seen, &asked),
            calibration: Calibration::of(
                seen.iter().filter_map(|each| Some((each.probability?, each.truth.sticks))),
            ),
            s: estimated(|each| (each.truth.s, each.s)),
            j: estimated(|each| (each.truth.j, each.j)),
            sureness: Sureness::of(loops),
            found: Found::of(loops),
            undecided: Undecided::of(loops),
            methods,
        }
    }
}

/// The decision of a method, or of the verdict, on a loop, with its score.
fn decision_of(loop_: &Scored, method: Option<&'static Method>) -> (Decision, Option<f64>) {
    match method {
        None => (loop_.decision(), loop_.probability.map(logit)),
        Some(method) => {
            let said = loop_.methods.iter().find(|said| said.method == method);
            said.map_or((Decision::Abstains, None), |said| (said.decision, said.score()))
        }
    }
}

fn row(method: Option<&'static Method>, loops: &[&Scored], valves: &[usize]) -> MethodRow {
    let mut recordings = Outcomes::default();
    let mut votes: BTreeMap<usize, (bool, Counts)> = BTreeMap::new();
    let mut ranked = Vec::with_capacity(loops.len());
    for (each, valve) in loops.iter().zip(valves) {
        let (decision, score) = decision_of(each, method);
        let sticks = each.truth.sticks;
        recordings.add(sticks, decision);
        let (valve_sticks, counts) = votes.entry(*valve).or_default();
        *valve_sticks |= sticks;
        counts.add(decision);
        ranked.push(Ranked { sticks, score, valve: *valve });
    }
    let mut of_valves = Outcomes::default();
    for (sticks, counts) in votes.values() {
        of_valves.add(*sticks, counts.majority());
    }
    let of_recordings = auc(&ranked, SEED);
    // If every valve has one recording, both are the same.
    let single = votes.len() == loops.len();
    MethodRow {
        name: method.map_or(VERDICT, |method| method.name),
        title: method.map_or("Verdict", |method| method.title),
        method,
        recordings,
        valves: of_valves,
        auc: of_recordings,
        auc_of_valves: if single { of_recordings } else { auc(&by_valve(&ranked), SEED) },
        roc: roc(&ranked),
    }
}

fn kinds(loops: &[&Scored], asked: &[Option<&'static Method>]) -> Vec<KindRow> {
    let mut rows: Vec<KindRow> = vec![];
    for each in loops.iter().filter(|each| !each.truth.kind.is_empty()) {
        let truth = &each.truth;
        let place = rows.iter().position(|row| row.kind == truth.kind).unwrap_or_else(|| {
            rows.push(KindRow {
                kind: truth.kind.clone(),
                sticks: truth.sticks,
                loops: 0,
                counts: BTreeMap::new(),
            });
            rows.len() - 1
        });
        rows[place].loops += 1;
        for method in asked {
            let name = method.map_or(VERDICT, |method| method.name);
            rows[place].counts.entry(name).or_default().add(decision_of(each, *method).0);
        }
    }
    rows.sort_by(|a, b| b.sticks.cmp(&a.sticks).then_with(|| a.kind.cmp(&b.kind)));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoreboard::{MethodResult, Truth};
    use stiction_diagnose::diagnose::{Estimate, VerdictClass};
    use stiction_diagnose::methods;

    /// A loop of which one method and the verdict say the same.
    fn scored(valve: &str, sticks: bool, visible: bool, p: Option<f64>) -> Scored {
        let detectors = methods::all();
        let class = match p {
            Some(p) if p > 0.8 => VerdictClass::Sticks,
            Some(p) if p < 0.2 => VerdictClass::DoesNotStick,
            _ => VerdictClass::CannotTell,
        };
        let decision = match class {
            VerdictClass::Sticks => Decision::Sticks,
            VerdictClass::DoesNotStick => Decision::DoesNotStick,
            _ => Decision::Abstains,
        };
        Scored {
            name: valve.to_owned(),
            truth: Truth {
                valve: valve.to_owned(),
                kind: if sticks { "sticky" } else { "calm" }.to_owned(),
                sticks,
                visible,
                s: sticks.then_some(2.0),
                j: None,
                member: None,
            },
            methods: vec![MethodResult {
                method: detectors[0].method(),
                statistic: p,
                threshold: Some(0.8),
                decision,
            }],
            verdict: class,
            undecided_by: None,
            probability: p,
            s: p.map(|p| Estimate { value: 2.0 * p, low: p, high: 2.0 }),
            j: None,
            s_below: None,
        }
    }

    #[test]
    fn loops_are_counted_by_recording_valve_and_kind() {
        let loops = [
            scored("a", true, true, Some(0.9)),
            scored("a", true, true, Some(0.95)),
            scored("b", true, true, None),
            scored("c", false, true, Some(0.1)),
            scored("d", false, true, Some(0.85)),
            scored("e", true, false, Some(0.1)),
        ];
        let board = Board::of(&loops);
        assert_eq!((board.sticky, board.healthy), (3, 2));
        assert_eq!(board.hidden, Share { k: 1, n: 4 });
        assert_eq!((board.sticky_valves, board.healthy_valves), (2, 2));
        let [verdict, method] = &board.methods[..] else { panic!("a verdict and a method") };
        assert_eq!((verdict.name(), method.name()), (VERDICT, "direct"));
        for row in [verdict, method] {
            assert_eq!(row.recordings.recall(), Share { k: 2, n: 3 });
            assert_eq!(row.valves.recall(), Share { k: 1, n: 2 });
            assert_eq!(row.recordings.false_alarms(), Share { k: 1, n: 2 });
            let found = row.auc.unwrap();
            assert_eq!((found.value, found.sticky, found.healthy), (1.0, 2, 2));
            assert_eq!(row.auc_of_valves.unwrap().sticky, 1);
            assert_eq!(row.roc.len(), 5);
        }
        // Four of six pairs are scored, and all of them in order.
        assert!((verdict.auc.unwrap().of_all - (4.0 + 1.0) / 6.0).abs() < 1e-12);
        let kinds: Vec<_> = board.kinds.iter().map(|k| (k.kind.as_str(), k.loops)).collect();
        assert_eq!(kinds, [("sticky", 3), ("calm", 2)]);
        assert_eq!(board.kinds[1].counts[VERDICT].positive, 1);
        assert_eq!(board.calibration.unwrap().n, 4);
        let s = board.s.unwrap();
        assert_eq!((s.quantified, s.covered), (Share { k: 2, n: 3 }, Share { k: 2, n: 2 }));
        assert_eq!(board.j, None);
    }

    #[test]
    fn a_board_of_nothing_has_no_measures() {
        let board = Board::of(&[]);
        assert_eq!(board.methods.len(), 1);
        assert_eq!((board.methods[0].auc, board.calibration, board.s), (None, None, None));
        assert_eq!((board.found, board.undecided), (None, None));
        assert!(board.kinds.is_empty());
    }
}
