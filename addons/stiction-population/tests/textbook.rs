//! The cycles of every textbook: regular, with an OP that moves little more than S; and the same from outside.

use rayon::prelude::*;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, Diagnosis, VerdictClass, diagnose};
use stiction_diagnose::recording::Recording;
use stiction_population::{Invention, LoopKind, Situation};

/// Least number of cycles.
const CYCLES: f64 = 5.0;
/// Range of the OP in S.
const RANGE: std::ops::Range<f64> = 1.0..2.0;

/// The class, if the recording swings regularly for long enough.
fn class_of(recording: &Recording) -> Option<VerdictClass> {
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let diagnosis: Diagnosis = diagnose(recording, &options).ok()?;
    let (_, swing) = diagnosis.oscillation()?;
    let swings = swing.found && swing.cycles.is_some_and(|cycles| cycles >= CYCLES);
    swings.then_some(diagnosis.verdict.class)
}

/// The class of a sticking loop of the population with such cycles.
fn sticking(seed: u64) -> Option<VerdictClass> {
    let simulated = LoopKind::Sticky.simulate(seed).ok()?;
    let truth = simulated.truth;
    let serves = truth.visible && truth.facts.situation == Situation::Ordinary;
    (serves && RANGE.contains(&truth.swing)).then(|| class_of(&simulated.recording))?
}

/// That of a healthy one with a wave from outside.
fn healthy(seed: u64) -> Option<VerdictClass> {
    let simulated = LoopKind::ExternalWave.simulate(seed).ok()?;
    let ordinary = simulated.truth.facts.situation == Situation::Ordinary;
    ordinary.then(|| class_of(&simulated.recording))?
}

/// That of a loop of a kind never trained on.
fn invented(kind: Invention, seed: u64, sticks: bool) -> Option<VerdictClass> {
    let made = kind.simulate(seed, sticks).ok()?;
    let op = &made.recording.op.values;
    let range =
        op.iter().copied().fold(f64::MIN, f64::max) - op.iter().copied().fold(f64::MAX, f64::min);
    let serves = !sticks || made.visible && RANGE.contains(&(range / made.s));
    serves.then(|| class_of(&made.recording))?
}

/// How many are accused, of all.
fn accused(classes: impl ParallelIterator<Item = VerdictClass>) -> String {
    let classes: Vec<_> = classes.collect();
    let n = classes.iter().filter(|class| **class == VerdictClass::Sticks).count();
    format!("{n} of {} ({:.0} %)", classes.len(), 100.0 * n as f64 / classes.len() as f64)
}

#[test]
#[ignore = "minutes; prints the figures of docs/accuracy-loops.md"]
fn cycles_of_textbooks() {
    let seeds = || 60_000..66_000_u64;
    println!("sticking loops found: {}", accused(seeds().into_par_iter().filter_map(sticking)));
    println!("external waves accused: {}", accused(seeds().into_par_iter().filter_map(healthy)));
    let earlier = [Invention::FIRST, Invention::SECOND].concat();
    for (set, kinds) in [("first and second", earlier), ("third", Invention::THIRD.to_vec())] {
        for sticks in [true, false] {
            let all = kinds.par_iter().flat_map_iter(move |kind| {
                (60_000..60_300_u64).filter_map(move |seed| invented(*kind, seed, sticks))
            });
            let what = if sticks { "sticking loops found" } else { "healthy loops accused" };
            println!("kinds never trained on, {set} set, {what}: {}", accused(all));
        }
    }
}
