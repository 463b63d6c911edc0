//! How often the graded words are right. The table of `docs/accuracy.md` is what
//! `cargo test --release -p stiction-population --test population grades:: -- --ignored --nocapture` prints.

use rayon::prelude::*;
use stiction_diagnose::diagnose::{
    Detectors, DiagnoseOptions, FINE_UP_TO, Grade, VerdictClass, diagnose,
};
use stiction_population::member;

/// Loops on which no rule was chosen.
const SEED: u64 = 20_261_224;

/// For each grade, how many loops have it, and how many of their valves are at fault, among those whose fault can be
/// seen or who have none.
fn table(loops: u64) -> Vec<(Grade, usize, usize)> {
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let one = |k: u64| {
        let simulated = member(SEED, k).unwrap();
        let truth = &simulated.truth;
        let grade = diagnose(&simulated.recording, &options).unwrap().verdict.grade;
        (truth.visible || !truth.sticks).then_some((grade, truth.sticks))
    };
    let all: Vec<(Grade, bool)> = (0..loops).into_par_iter().filter_map(one).collect();
    let row = |grade: Grade| {
        let of: Vec<bool> =
            all.iter().filter(|(each, _)| *each == grade).map(|(_, sticks)| *sticks).collect();
        (grade, of.len(), of.iter().filter(|sticks| **sticks).count())
    };
    Grade::ALL.map(row).to_vec()
}

fn share(table: &[(Grade, usize, usize)], of: Grade) -> f64 {
    let (_, all, sticks) = table.iter().find(|(grade, ..)| *grade == of).unwrap();
    *sticks as f64 / (*all).max(1) as f64
}

#[test]
fn words_are_graded() {
    let table = table(800);
    let [sticks, probably, unclear, probably_not, fine] =
        [Grade::Sticks, Grade::ProbablySticks, Grade::Unclear, Grade::ProbablyFine, Grade::Fine]
            .map(|grade| share(&table, grade));
    assert!(sticks > 0.9 && fine < 0.15, "{table:?}");
    assert!(probably > 0.65 && probably > unclear && unclear > probably_not, "{table:?}");
}

#[test]
#[ignore = "measures, a minute"]
fn table_of_grades() {
    println!("| grade | loops | valve at fault |");
    println!("|---|---|---|");
    for (grade, all, sticks) in table(5_000) {
        println!("| {grade} | {all} | {:.0} % |", 100.0 * sticks as f64 / all.max(1) as f64);
    }
}

/// A cleared valve is fine up to the limit that matters to the user, and no other verdict depends on it.
#[test]
fn fine_needs_a_limit_that_matters() {
    let of = |k: u64, fine_up_to: f64| {
        let options = DiagnoseOptions {
            detectors: Detectors::None,
            fine_up_to,
            ..DiagnoseOptions::default()
        };
        diagnose(&member(SEED, k).unwrap().recording, &options).unwrap().verdict
    };
    let differ = (0..60).filter(|k| {
        let (strict, usual, lax) = (of(*k, 0.01), of(*k, FINE_UP_TO), of(*k, 1e6));
        assert_eq!((strict.class, usual.class), (usual.class, lax.class));
        if usual.class != VerdictClass::DoesNotStick {
            assert_eq!((strict.grade, usual.grade), (usual.grade, lax.grade));
            return false;
        }
        let is_small = usual.s_below.unwrap().value <= FINE_UP_TO;
        assert_eq!(usual.grade, if is_small { Grade::Fine } else { Grade::NoneVisible });
        assert_eq!((strict.grade, lax.grade), (Grade::NoneVisible, Grade::Fine));
        true
    });
    assert!(differ.count() >= 5);
}
