//! More sticking is never less suspicious, and a valve that does not move is not fine.

use rayon::prelude::*;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, Diagnosis, VerdictClass, diagnose};
use stiction_diagnose::recording::Recording;
use stiction_population::{LoopKind, Simulated, Truth};

/// S of paired loops, percent of span.
const BANDS: [f64; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0];
/// What counts as the same suspicion: a probability that is less by no more.
const SAME: f64 = 0.02;

fn verdict_of(recording: &Recording) -> Diagnosis {
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    diagnose(recording, &options).unwrap()
}

/// Truth, probability and class of the loop of a seed with each S; `None` where a draw does not serve.
fn paired(seed: u64) -> Option<Vec<(Truth, f64, VerdictClass)>> {
    BANDS
        .iter()
        .map(|s| {
            let Simulated { recording, truth } = LoopKind::sticky_with_s(seed, *s).unwrap()?;
            let verdict = verdict_of(&recording).verdict;
            Some((truth, verdict.probability?, verdict.class))
        })
        .collect()
}

/// Of neighbouring pairs of S whose larger one shows, how many lose no suspicion, and all; with how often the larger
/// one is accused and the smaller one is not, and the reverse.
fn counted(seeds: std::ops::Range<u64>) -> [usize; 5] {
    let designs: Vec<_> = seeds.into_par_iter().filter_map(paired).collect();
    let mut counts = [0; 5];
    counts[4] = designs.len();
    let accused =
        |class: VerdictClass| matches!(class, VerdictClass::Sticks | VerdictClass::DoesNotRespond);
    for design in &designs {
        for two in design.windows(2) {
            let [(.., p, a), (truth, q, b)] = two else { continue };
            if !truth.visible {
                continue;
            }
            counts[0] += usize::from(*q >= p - SAME);
            counts[1] += 1;
            counts[2] += usize::from(accused(*b) && !accused(*a));
            counts[3] += usize::from(accused(*a) && !accused(*b));
        }
    }
    counts
}

/// Of valves that never move though the OP does: cleared, named, and all.
fn unmoved(seeds: std::ops::Range<u64>) -> [usize; 3] {
    let of = |seed: u64| -> Option<VerdictClass> {
        // A valve that sticks by half its travel, under whatever its controller does.
        let simulated = LoopKind::sticky_with_s(seed, 60.0).unwrap()?;
        let moves = simulated.truth.moves || simulated.truth.facts.op_travel < 0.5;
        (!moves).then(|| verdict_of(&simulated.recording).verdict.class)
    };
    let classes: Vec<VerdictClass> = seeds.into_par_iter().filter_map(of).collect();
    let count = |wanted: &[VerdictClass]| classes.iter().filter(|c| wanted.contains(c)).count();
    [
        count(&[VerdictClass::DoesNotStick]),
        count(&[VerdictClass::Sticks, VerdictClass::DoesNotRespond]),
        classes.len(),
    ]
}

#[test]
fn loops_of_one_seed_differ_in_s_alone() {
    let of = |s: f64| LoopKind::sticky_with_s(5, s).unwrap().unwrap();
    let (small, large) = (of(0.5), of(4.0));
    assert_eq!((small.truth.s, large.truth.s), (0.5, 4.0));
    assert_eq!(small.truth.facts.kc, large.truth.facts.kc);
    assert_eq!(small.truth.facts.activity, large.truth.facts.activity);
    assert!((small.truth.j / 0.5 - large.truth.j / 4.0).abs() < 1e-9);
    assert!(LoopKind::sticky_with_s(5, 0.0).is_err() && LoopKind::sticky_with_s(5, 200.0).is_err());
}

#[test]
fn an_unmoved_valve_is_seldom_cleared() {
    let [cleared, _, all] = unmoved(9000..9100);
    assert!(all >= 20 && 10 * cleared <= all, "{cleared} of {all} are cleared");
}

#[test]
#[ignore = "minutes; prints the figures of docs/accuracy-loops.md"]
fn suspicion_rises_with_s() {
    let [kept, all, gained, lost, designs] = counted(20_000..20_260);
    println!(
        "{designs} designs, S from 0.5 to 16 %, pairs of neighbouring S whose larger one shows:"
    );
    println!("suspicion rises or stays in {kept} of {all}");
    println!("the larger S alone is accused in {gained}, the smaller alone in {lost}");
    let [cleared, named, unmoved] = unmoved(30_000..30_400);
    println!(
        "valves that never move while the OP does: {cleared} of {unmoved} cleared, {named} named"
    );
}
