//! Simulated loops.

use super::About;
use super::measure::{Known, Measured, Plan};
use anyhow::{Context, Result};
use stiction::population::{self, Invention, LoopKind, Simulated};
use stiction::scoreboard::Truth;
use stiction_report::document::Source;

/// A loop to simulate.
enum Job {
    /// A member of the mixed population.
    Member(u64),
    /// The loop of this kind with this seed.
    Of(LoopKind, u64),
}

/// Measures `n` members of the mixed population. Kinds with fewer than `per_kind` members are filled up.
pub fn measure(
    seed: u64,
    n: u64,
    per_kind: Option<u64>,
    plan: &Plan<'_>,
) -> Result<(About, Measured)> {
    let per_kind = per_kind.unwrap_or(n / 20);
    let load = |job: &Job| load(seed, job);
    let mut measured = Measured::default();
    let members: Vec<Job> = (0..n).map(Job::Member).collect();
    measured.add(&members, load, plan)?;
    let mut more = vec![];
    for kind in LoopKind::ALL {
        let there = measured.loops.iter().filter(|each| each.truth.kind == kind.name()).count();
        let missing = per_kind.saturating_sub(there as u64);
        more.extend((0..missing).map(|k| Job::Of(kind, seed.wrapping_add(k))));
    }
    measured.add(&more, load, plan)?;
    let added = match more.len() {
        0 => String::new(),
        more => format!(" {more} loops were added, so that each kind has at least {per_kind}."),
    };
    let about = About {
        title: format!("{} simulated loops", measured.loops.len()),
        origin: format!(
            "{n} members of the mixed population of version {}, seed {seed}.{added}",
            population::VERSION
        ),
    };
    Ok((about, measured.finish(plan)?))
}

/// Measures `n` loops of each of these kinds. Every second loop is healthy.
pub fn invented(
    kinds: [Invention; 8],
    seed: u64,
    n: u64,
    plan: &Plan<'_>,
) -> Result<(About, Measured)> {
    let jobs: Vec<(Invention, u64)> =
        kinds.into_iter().flat_map(|what| (0..n).map(move |k| (what, k))).collect();
    let load = |(what, k): &(Invention, u64)| -> Result<Known> {
        let sticks = k % 2 == 1;
        let state = if sticks { "sticking" } else { "healthy" };
        let name = format!("{}, {state} {k}", what.name());
        let made = what.simulate(seed.wrapping_add(k / 2), sticks).with_context(|| name.clone())?;
        let truth = Truth::of_invented(name.clone(), *what, &made);
        let mut recording = made.recording;
        recording.name = name;
        let source = Source { file: "simulated".to_owned(), sha256: String::new() };
        Ok(Known { recording, source, truth })
    };
    let mut measured = Measured::default();
    measured.add(&jobs, load, plan)?;
    let about = About {
        title: format!("{} simulated loops", measured.loops.len()),
        origin: format!(
            "{n} of each kind that was not used in training, half of them healthy, seed {seed}."
        ),
    };
    Ok((about, measured.finish(plan)?))
}

fn load(seed: u64, job: &Job) -> Result<Known> {
    let (made, name) = match job {
        Job::Member(index) => (population::member(seed, *index), format!("member {index}")),
        Job::Of(kind, seed) => (kind.simulate(*seed), format!("{} {seed}", kind.name())),
    };
    let Simulated { mut recording, truth } = made.with_context(|| name.clone())?;
    recording.name = name.clone();
    let truth = match job {
        Job::Member(_) => Truth::of_member(name, &truth),
        Job::Of(..) => Truth::of_simulated(name, &truth),
    };
    let source = Source { file: "simulated".to_owned(), sha256: String::new() };
    Ok(Known { recording, source, truth })
}
