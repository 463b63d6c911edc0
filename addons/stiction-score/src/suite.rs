//! Suites: frozen lists of loops with known truth, on which detectors are compared.
//!
//! ```text
//! name, key ──> seeds ──> jobs in a drawn order ──> loop k: recording, truth, groups
//! ```
//!
//! A [`Suite`] is a list of jobs. Each loop depends only on its job, so it can be made on any machine at any time. The
//! order is drawn, so that neither the name nor the place of a loop indicates its kind. A suite never changes after its
//! publication. Another list of loops, or another population, is a new suite.

mod job;

use crate::scoreboard::KnownLoop;
use job::Job;
pub use job::Part;
use stiction_diagnose::recording::Recording;
use stiction_model::error::{Error, Result};
use stiction_population::Draw;

/// A list of loops with known truth.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Suite {
    plan: &'static Plan,
    hidden: bool,
    jobs: Vec<(Part, Job)>,
}

/// A loop of a suite.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// Recording, with the name of the loop.
    pub recording: Recording,
    /// Truth and its groups.
    pub asked: KnownLoop,
}

/// The content of a suite.
#[derive(Debug, PartialEq, Eq)]
struct Plan {
    name: &'static str,
    about: &'static str,
    /// The number that its seeds are derived from.
    number: u64,
    parts: &'static [(Part, u64)],
    /// Whether there is a hidden half.
    has_hidden: bool,
}

const PLANS: [Plan; 3] = [
    Plan {
        name: "v1",
        about: "the suite on which detectors are compared",
        number: 0x7631,
        parts: &[
            (Part::Population, 2000),
            (Part::Kinds, 760),
            (Part::Long, 200),
            (Part::Invented, 640),
            (Part::Positions, 200),
            (Part::Networks, 200),
        ],
        has_hidden: true,
    },
    Plan {
        name: "v1-trial",
        about: "a small suite for trying a detector",
        number: 0x7632,
        parts: &[
            (Part::Population, 60),
            (Part::Kinds, 19),
            (Part::Long, 5),
            (Part::Invented, 16),
            (Part::Positions, 10),
            (Part::Networks, 10),
        ],
        has_hidden: true,
    },
    Plan {
        name: "v1-training",
        about: "loops to train a detector on, none of which is in another suite",
        number: 0x7633,
        parts: &[(Part::Population, 10_000)],
        has_hidden: false,
    },
];

impl Suite {
    /// Names of all suites, with their descriptions.
    pub fn all() -> impl Iterator<Item = (&'static str, &'static str)> {
        PLANS.iter().map(|plan| (plan.name, plan.about))
    }

    /// The suite of this name. With a key, the suite is the hidden half: loops of the same kinds and numbers, whose
    /// seeds are derived from the key.
    ///
    /// # Errors
    /// If no suite has this name, or the suite has no hidden half.
    pub fn by_name(name: &str, key: Option<[u64; 4]>) -> Result<Self> {
        let found = PLANS.iter().find(|plan| plan.name == name);
        let plan = found.ok_or_else(|| Error::UnknownName {
            family: "suite",
            name: name.to_owned(),
            known: PLANS.map(|plan| plan.name).join(", "),
        })?;
        if key.is_some() && !plan.has_hidden {
            return Err(Error::UnknownName {
                family: "suite with a hidden half",
                name: name.to_owned(),
                known: PLANS
                    .iter()
                    .filter(|p| p.has_hidden)
                    .map(|p| p.name)
                    .collect::<Vec<_>>()
                    .join(", "),
            });
        }
        let mut numbers = vec![plan.number];
        numbers.extend(key.into_iter().flatten());
        let mut jobs: Vec<(Part, Job)> = vec![];
        for (part, n) in plan.parts {
            let mut draw = Draw::of(&[&numbers[..], &[*part as u64]].concat());
            jobs.extend(job::jobs(*part, *n, &mut draw).into_iter().map(|job| (*part, job)));
        }
        let mut draw = Draw::of(&[&numbers[..], &[u64::MAX]].concat());
        for k in (1..jobs.len()).rev() {
            jobs.swap(k, draw.count(0, k));
        }
        Ok(Self { plan, hidden: key.is_some(), jobs })
    }

    /// Name.
    pub fn name(&self) -> &'static str {
        self.plan.name
    }

    /// Description.
    pub fn about(&self) -> &'static str {
        self.plan.about
    }

    /// Whether it is the hidden half.
    pub fn is_hidden(&self) -> bool {
        self.hidden
    }

    /// Number of loops.
    #[expect(clippy::len_without_is_empty, reason = "no suite is empty")]
    pub fn len(&self) -> usize {
        self.jobs.len()
    }

    /// Parts, with their numbers of loops.
    pub fn parts(&self) -> &'static [(Part, u64)] {
        self.plan.parts
    }

    /// The name of a loop.
    pub fn id(&self, index: usize) -> String {
        let half = if self.hidden { "-hidden" } else { "" };
        format!("{}{half}-{index:05}", self.plan.name)
    }

    /// Simulates a loop.
    ///
    /// # Errors
    /// If there is no such loop. No loop fails to simulate, as far as is known.
    pub fn known(&self, index: usize) -> Result<Known> {
        let (part, job) = self.jobs.get(index).ok_or_else(|| Error::UnknownName {
            family: "loop",
            name: index.to_string(),
            known: format!("0 to {}", self.jobs.len() - 1),
        })?;
        job.known(*part, self.id(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::{BTreeMap, BTreeSet};

    fn suite(name: &str, key: Option<[u64; 4]>) -> Suite {
        Suite::by_name(name, key).unwrap()
    }

    #[test]
    fn no_suite_shares_a_loop_with_another() {
        let keys = [[1, 2, 3, 4], [1, 2, 3, 5]];
        let mut suites =
            vec![suite("v1", None), suite("v1-trial", None), suite("v1-training", None)];
        suites.extend(keys.map(|key| suite("v1", Some(key))));
        let mut seen = BTreeSet::new();
        let mut all = 0;
        for each in &suites {
            seen.extend(each.jobs.iter().map(|(_, job)| format!("{job:?}")));
            all += each.len();
        }
        assert_eq!((seen.len(), all), (all, 4000 + 120 + 10_000 + 8000));
        // Different jobs are different loops.
        let mut signals = BTreeSet::new();
        for each in &suites {
            for k in 0..20 {
                let op = each.known(k).unwrap().recording.op.values;
                signals.insert(op.iter().map(|v| v.to_bits()).collect::<Vec<_>>());
            }
        }
        assert_eq!(signals.len(), 100);
        // Their members are not those that the verdict was trained on or measured with, whose seeds are small numbers.
        for (_, job) in suites.iter().flat_map(|each| &each.jobs) {
            if let Job::Member(seed, _) = job {
                assert!(*seed > 1 << 40, "{seed}");
            }
        }
    }

    #[test]
    fn a_suite_has_its_parts_in_a_drawn_order() {
        let each = suite("v1-trial", None);
        let mut counts: BTreeMap<Part, u64> = BTreeMap::new();
        each.jobs.iter().for_each(|(part, _)| *counts.entry(*part).or_default() += 1);
        assert_eq!(counts.into_iter().collect::<Vec<_>>(), each.parts());
        let turns = each.jobs.windows(2).filter(|two| two[0].0 != two[1].0).count();
        assert!(turns > 40, "{turns}");
        assert_eq!((each.id(7).as_str(), each.len()), ("v1-trial-00007", 120));
    }

    #[test]
    fn every_loop_has_a_name_a_truth_and_groups() {
        let each = suite("v1-trial", None);
        let mut kinds = BTreeSet::new();
        for k in 0..each.len() {
            let Known { recording, asked } = each.known(k).unwrap();
            assert_eq!((&recording.name, &asked.id), (&each.id(k), &each.id(k)));
            let part = each.jobs[k].0;
            assert!(asked.groups.contains(&("part", part.name().to_owned())), "{asked:?}");
            assert_eq!(recording.vp.is_some(), part == Part::Positions);
            assert!(recording.pv.is_some() && recording.op.values.iter().all(|v| v.is_finite()));
            assert!(asked.truth.sticks || !asked.truth.visible);
            // The wire carries evenly sampled signals on one clock.
            let step = recording.op.time[1];
            let times = [
                Some(&recording.op),
                recording.pv.as_ref(),
                recording.sp.as_ref(),
                recording.vp.as_ref(),
            ];
            for channel in times.into_iter().flatten() {
                assert!(channel.time.iter().enumerate().all(|(k, t)| *t == k as f64 * step));
            }
            kinds.insert(asked.truth.kind);
        }
        assert!(kinds.len() > 30, "{kinds:?}");
        assert!(each.known(each.len()).is_err());
    }

    #[test]
    fn the_hidden_half_depends_on_its_key() {
        let first = |key| suite("v1-trial", key).known(3).unwrap().recording.op.values;
        let (open, one, two) = (first(None), first(Some([9, 9, 9, 9])), first(Some([9, 9, 9, 8])));
        assert!(open != one && one != two && open != two);
        assert_eq!(one, first(Some([9, 9, 9, 9])));
        let refused = Suite::by_name("v1-training", Some([1; 4])).unwrap_err().to_string();
        assert!(refused.contains("hidden half"), "{refused}");
        let refused = Suite::by_name("v0", None).unwrap_err().to_string();
        assert!(refused.contains("v1-trial"), "{refused}");
    }
}
