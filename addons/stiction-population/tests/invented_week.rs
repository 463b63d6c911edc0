//! Records of a week, of kinds that no training has seen.

use rayon::prelude::*;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, VerdictClass, diagnose};
use stiction_population::Invention;

/// Healthy loops of a kind, and as many that stick.
const LOOPS: u64 = 24;
/// Probabilities near 0 or 1.
const SURE: (f64, f64) = (0.02, 0.98);
const WEEK: f64 = 604_800.0;
/// Most samples, over those of a record of the usual length.
const LONGEST: f64 = 64.0;

/// What is judged of a loop.
struct Judged {
    sticks: bool,
    /// Whether the week can show it, or the record of the usual length can. The likelihood alone would tell too few:
    /// its rows are at most 800, and those of a week are far apart.
    visible: bool,
    class: VerdictClass,
    /// Whether the class is decided and the probability is near 0 or 1.
    sure: bool,
    days: f64,
}

/// What is judged of a loop of this kind after a week, or as much of it as the usual length allows.
fn of(kind: Invention, seed: u64, sticks: bool) -> Judged {
    let duration = |time: &[f64]| time[time.len() - 1] - time[0];
    let usual = kind.simulate(seed, sticks).unwrap();
    // A longer record may reject a draw that the usual one accepts; S then differs.
    let factor = (WEEK / duration(&usual.recording.op.time)).clamp(1.0, LONGEST);
    let made = kind.simulate_for(seed, sticks, factor).unwrap();
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let verdict = diagnose(&made.recording, &options).unwrap().verdict;
    let decided = matches!(verdict.class, VerdictClass::Sticks | VerdictClass::DoesNotStick);
    let near = verdict.probability.is_some_and(|p| p <= SURE.0 || p >= SURE.1);
    Judged {
        sticks,
        visible: made.visible || usual.visible && usual.s == made.s,
        class: verdict.class,
        sure: decided && near,
        days: duration(&made.recording.op.time) / 86_400.0,
    }
}

fn print_row(kind: &str, judged: &[Judged]) {
    let count = |which: &dyn Fn(&Judged) -> bool| judged.iter().filter(|one| which(one)).count();
    let accused = |one: &Judged| one.class == VerdictClass::Sticks;
    let cleared = |one: &Judged| one.class == VerdictClass::DoesNotStick;
    // Sticking that no record can show is no error of either class.
    let counts = |one: &Judged| one.visible || !one.sticks;
    let wrong = |one: &Judged| counts(one) && one.sure && accused(one) != one.sticks;
    println!(
        "{kind:20} {:4.1} days; healthy {}: accused {}, cleared {}; visible sticking {}: found {}, \
         cleared {}; sure {}: wrong {}",
        judged.iter().map(|one| one.days).sum::<f64>() / judged.len() as f64,
        count(&|one| !one.sticks),
        count(&|one| !one.sticks && accused(one)),
        count(&|one| !one.sticks && cleared(one)),
        count(&|one| one.visible),
        count(&|one| one.visible && accused(one)),
        count(&|one| one.visible && cleared(one)),
        count(&|one| counts(one) && one.sure),
        count(&wrong),
    );
}

/// The table of the third examination; nothing in it is asserted.
#[test]
#[ignore = "prints a table, takes minutes"]
fn a_week_of_kinds_never_trained_on() {
    let mut all = vec![];
    for kind in Invention::THIRD {
        let loops = (70_000..70_000 + LOOPS).into_par_iter();
        let judged: Vec<Judged> = loops
            .flat_map_iter(|seed| [false, true].map(|sticks| of(kind, seed, sticks)))
            .collect();
        print_row(kind.name(), &judged);
        all.extend(judged);
    }
    print_row("all", &all);
}
