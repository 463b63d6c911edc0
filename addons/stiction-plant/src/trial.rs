//! The accuracy of groups, on networks of loops whose truth is known.
//!
//! Each network of the [population](stiction_population::network) is simulated for some days. Every loop is judged by its first
//! day, and groups are found from the traces of all loops. [`NetworkTruth`] defines what is true.

use crate::error::{Error, Result};
use crate::groups::{self, Group, GroupOptions, LoopOfWeek, Source};
use crate::store::trace::{Trace, TraceSignal};
use rayon::prelude::*;
use std::collections::BTreeMap;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, diagnose};
use stiction_population::network::{Cause, Network, NetworkTruth};
use stiction_score::scoreboard::Share;

/// Counts on networks.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, schemars::JsonSchema)]
pub struct Trial {
    /// Networks that were simulated.
    pub networks: usize,
    /// Loops in these networks.
    pub loops: usize,
    /// Share of the valves whose oscillation reaches another loop that are in a group with such a loop.
    pub sources: Share,
    /// Share of the pairs of such a valve's loop and a loop that it reaches that are in a group.
    pub recall: Share,
    /// Share of the pairs in a group without a common cause, among all pairs in a group.
    pub false_pairs: Share,
    /// Share of the sources in a group that are the first candidate.
    pub first: Share,
    /// Sources among the first three candidates.
    pub first_three: Share,
    /// Share of the groups without a sticking valve whose source is reported as not recorded.
    pub not_recorded: Share,
    /// Share of the groups with a source whose source is reported as not recorded.
    pub wrongly_not_recorded: Share,
    /// Share of the networks without any common cause that have a group.
    pub unrelated: Share,
}

/// Start of the record, s since 1970-01-01 UTC.
const START: i64 = crate::demo::FIRST_DAY * 86_400;

impl Trial {
    /// Counts on the first `n` networks of `seed`, with this number of days each. `seen` is called after each.
    ///
    /// # Errors
    /// None is known: if a network cannot be simulated or a loop not be judged.
    pub fn run(seed: u64, n: u64, days: u32, seen: impl Fn() + Sync) -> Result<Self> {
        let each: Vec<Self> = (0..n)
            .into_par_iter()
            .map(|k| {
                let own = Self::of(seed.wrapping_mul(1_000_003).wrapping_add(k), days);
                seen();
                own
            })
            .collect::<Result<_>>()?;
        Ok(each.into_iter().fold(Self::default(), Self::and))
    }

    /// Counts on one network.
    fn of(seed: u64, days: u32) -> Result<Self> {
        let network = Network::draw(seed)?;
        let duration = f64::from(days) * 86_400.0;
        let samples = network.run(None)?.record(duration)?;
        let names: Vec<String> = (0..samples.len()).map(|k| format!("L{k:02}")).collect();
        let detectors = Detectors::None;
        let options = DiagnoseOptions { detectors, plan: false, ..DiagnoseOptions::default() };
        let (mut traces, mut loops) = (vec![], vec![]);
        for ((own, each), name) in samples.iter().zip(&network.loops).zip(&names) {
            let whole = own.recording(name, each)?;
            let day = whole
                .part(0.0, 86_400.0, 0.0)
                .ok_or_else(|| Error::Option(format!("{name} is empty")))?;
            let found = diagnose(&day, &options)?;
            let signal = TraceSignal::of(&found);
            traces.extend(Trace::of(&whole, START, duration as i64, signal));
            let swing = found.oscillation().filter(|(_, swing)| swing.found);
            loops.push(LoopOfWeek {
                name: name.clone(),
                probability: found.verdict.probability,
                period_s: swing.and_then(|(_, swing)| swing.period_s),
            });
        }
        let groups = groups::find(&traces, &loops, &BTreeMap::new(), &GroupOptions::default());
        Ok(Self::counted(&network.truth(&samples)?, &groups, samples.len(), &names))
    }

    fn counted(truth: &NetworkTruth, groups: &[Group], n: usize, names: &[String]) -> Self {
        let mut trial = Self { networks: 1, loops: n, ..Self::default() };
        let place = |group: &Group, k: usize| group.members.iter().position(|m| m.name == names[k]);
        let together = |a: usize, b: usize| {
            groups.iter().find(|group| place(group, a).is_some() && place(group, b).is_some())
        };
        let add = |share: &mut Share, is: bool| {
            share.k += usize::from(is);
            share.n += 1;
        };
        let mut sources = vec![];
        for reach in &truth.causes {
            let Cause::Valve(source) = reach.cause else { continue };
            let reached: Vec<usize> = (0..n).filter(|k| *k != source && reach.swings[*k]).collect();
            if !reach.swings[source] || reached.is_empty() {
                continue;
            }
            sources.push(source);
            let group = reached.iter().find_map(|k| together(source, *k));
            add(&mut trial.sources, group.is_some());
            for k in &reached {
                add(&mut trial.recall, together(source, *k).is_some());
            }
            if let Some(group) = group {
                let rank = place(group, source).and_then(|at| group.members[at].candidate_rank);
                add(&mut trial.first, rank == Some(1));
                add(&mut trial.first_three, rank.is_some_and(|rank| rank <= 3));
            }
        }
        for group in groups {
            let members: Vec<usize> = (0..n).filter(|k| place(group, *k).is_some()).collect();
            for (at, a) in members.iter().enumerate() {
                for b in &members[..at] {
                    add(&mut trial.false_pairs, truth.apart(*a, *b));
                }
            }
            let sticks =
                |k: &usize| truth.causes.iter().any(|reach| reach.cause == Cause::Valve(*k));
            let unknown = group.source == Source::NotRecorded;
            if !members.iter().any(sticks) {
                add(&mut trial.not_recorded, unknown);
            } else if members.iter().any(|k| sources.contains(k)) {
                add(&mut trial.wrongly_not_recorded, unknown);
            }
        }
        let unrelated = (0..n).all(|a| (0..a).all(|b| truth.apart(a, b)));
        if unrelated {
            add(&mut trial.unrelated, !groups.is_empty());
        }
        trial
    }

    fn and(self, other: Self) -> Self {
        let sum = |a: Share, b: Share| Share { k: a.k + b.k, n: a.n + b.n };
        Self {
            networks: self.networks + other.networks,
            loops: self.loops + other.loops,
            sources: sum(self.sources, other.sources),
            recall: sum(self.recall, other.recall),
            false_pairs: sum(self.false_pairs, other.false_pairs),
            first: sum(self.first, other.first),
            first_three: sum(self.first_three, other.first_three),
            not_recorded: sum(self.not_recorded, other.not_recorded),
            wrongly_not_recorded: sum(self.wrongly_not_recorded, other.wrongly_not_recorded),
            unrelated: sum(self.unrelated, other.unrelated),
        }
    }
}
