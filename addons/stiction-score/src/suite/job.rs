//! The loops of a suite, as they are made.

use super::Known;
use crate::scoreboard::{Group, KnownLoop, Truth};
use stiction_diagnose::recording::Recording;
use stiction_model::error::Result;
use stiction_model::named;
use stiction_population::network::{Network, NetworkPlan};
use stiction_population::position::positioned;
use stiction_population::{Draw, Invented, Invention, LoopKind, Simulated};

named! {
    /// A part of a suite.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum Part {
        /// Members of the mixed population.
        Population = "population",
        /// Equally many loops of each kind of the population.
        Kinds = "kinds",
        /// Loops of the population with four times as long a record.
        Long = "long records",
        /// Loops of kinds that are not in the population, half of them healthy.
        Invented = "invented kinds",
        /// Loops with a recorded valve position.
        Positions = "recorded positions",
        /// Loops of networks with one sticking valve. Half of these loops have the sticking valve, and the other half
        /// have a healthy valve.
        Networks = "networks",
    }
}

impl Part {
    /// Content, a sentence.
    pub fn about(self) -> &'static str {
        match self {
            Self::Population => {
                "Members of the mixed population, which no detector should have been tuned on."
            }
            Self::Kinds => {
                "Equally many loops of each of the 19 kinds, for false alarms by confuser."
            }
            Self::Long => "Loops of the population with records four times as long as usual.",
            Self::Invented => {
                "Loops of 16 kinds that are not in the population, half of them healthy."
            }
            Self::Positions => "Loops whose valve position is recorded.",
            Self::Networks => {
                "One loop of a network of five coupled loops with one sticking valve. Half of \
                 these loops have the sticking valve, and the other half have a healthy valve."
            }
        }
    }
}

/// How a loop is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Job {
    /// A member of the mixed population of a seed.
    Member(u64, u64),
    /// The loop of this kind with this seed.
    Of(LoopKind, u64),
    /// The loop with a longer record.
    Longer(LoopKind, u64),
    /// The loop of this kind outside the population, healthy or sticking.
    Invented(Invention, u64, bool),
    /// A loop with a recorded position.
    Position(u64, u64),
    /// A loop of the network of this seed: the loop of the sticking valve, or another one.
    Network(u64, bool),
}

/// Factor of the longer records.
const LONGER: f64 = 4.0;
/// Number of loops of a network, and its record, s.
const NETWORK: usize = 5;
const NETWORK_S: f64 = 28_800.0;

/// The first `n` jobs of a part.
pub(super) fn jobs(part: Part, n: u64, draw: &mut Draw) -> Vec<Job> {
    let seed = draw.seed();
    (0..n)
        .map(|k| match part {
            Part::Population => Job::Member(seed, k),
            Part::Kinds => Job::Of(LoopKind::ALL[k as usize % LoopKind::ALL.len()], draw.seed()),
            Part::Long => Job::Longer(LoopKind::at(draw.unit()), draw.seed()),
            Part::Invented => {
                let kinds = [Invention::FIRST, Invention::SECOND].concat();
                let what = kinds[k as usize % kinds.len()];
                Job::Invented(what, draw.seed(), (k + k / kinds.len() as u64) % 2 == 1)
            }
            Part::Positions => Job::Position(seed, k),
            Part::Networks => Job::Network(draw.seed(), k % 2 == 0),
        })
        .collect()
}

impl Job {
    pub(super) fn known(self, part: Part, id: String) -> Result<Known> {
        let (mut recording, truth, mut groups) = match self {
            Self::Member(seed, index) => {
                of_population(stiction_population::member(seed, index)?, &id)
            }
            Self::Of(kind, seed) => of_population(kind.simulate(seed)?, &id),
            Self::Longer(kind, seed) => of_population(kind.simulate_for(seed, LONGER)?, &id),
            Self::Invented(what, seed, sticks) => {
                let made = what.simulate(seed, sticks)?;
                let truth = Truth::of_invented(id.clone(), what, &made);
                let Invented { recording, .. } = made;
                (recording, truth, vec![])
            }
            Self::Position(seed, index) => {
                let made = positioned(seed, index)?;
                let truth = Truth::of_position(id.clone(), &made.truth);
                (made.recording, truth, vec![])
            }
            Self::Network(seed, sticks) => of_network(seed, sticks, &id)?,
        };
        recording.name.clone_from(&id);
        groups.push(("part", part.name().to_owned()));
        groups.push(("samples", band(recording.op.values.len()).to_owned()));
        Ok(Known { recording, asked: KnownLoop { id, truth, groups } })
    }
}

fn of_population(made: Simulated, id: &str) -> (Recording, Truth, Vec<Group>) {
    let Simulated { recording, truth } = made;
    let facts = &truth.facts;
    let mut groups: Vec<Group> = vec![
        ("executions a sample", facts.steps_per_sample.to_string()),
        ("process", facts.process.name().to_owned()),
        ("controller", facts.controller.name().to_owned()),
        ("situation", facts.situation.name().to_owned()),
    ];
    groups.extend(facts.historian.iter().map(|each| ("historian", each.name().to_owned())));
    (recording, Truth::of_member(id.to_owned(), &truth), groups)
}

fn of_network(seed: u64, sticks: bool, id: &str) -> Result<(Recording, Truth, Vec<Group>)> {
    let mut draw = Draw::of(&[seed, 0x4e72]);
    let sticking = draw.count(0, NETWORK - 1);
    let plan = NetworkPlan {
        loops: NETWORK,
        sticking: vec![sticking],
        outside: draw.count(0, 1),
        coupled: true,
    };
    let network = Network::planned(seed, &plan)?;
    // A loop that writes a set point has no valve of its own.
    let others: Vec<usize> =
        (0..NETWORK).filter(|k| *k != sticking && network.loops[*k].below.is_none()).collect();
    let at = match sticks || others.is_empty() {
        true => sticking,
        false => others[draw.count(0, others.len() - 1)],
    };
    let samples = network.run(None)?.record(NETWORK_S)?;
    let own = &network.loops[at];
    let recording = samples[at].recording(id, own)?;
    let has_valve = at == sticking;
    let visible = has_valve && {
        let reached = network.truth(&samples)?;
        reached.causes.first().is_some_and(|cause| cause.swings[at])
    };
    let truth = Truth {
        valve: id.to_owned(),
        kind: if has_valve { "network, sticks" } else { "network, healthy" }.to_owned(),
        sticks: has_valve,
        visible,
        s: has_valve.then_some(own.s),
        j: has_valve.then_some(own.j),
        member: None,
    };
    Ok((recording, truth, vec![]))
}

/// The band of a number of samples.
fn band(samples: usize) -> &'static str {
    match samples {
        0..500 => "below 500",
        500..1000 => "500 to 1,000",
        1000..2000 => "1,000 to 2,000",
        2000..5000 => "2,000 to 5,000",
        _ => "5,000 and more",
    }
}
