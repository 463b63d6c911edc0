//! How often the advice for an undecided loop decides, once it is followed.
//!
//! ```text
//! cargo run --release -p stiction-score --example advice_followed -- 1000
//! ```
//!
//! simulates 1,000 loops of all kinds. For undecided loops, it follows each part of the printed advice on the same
//! loop: a record of ten cycles, a record without compression, a recorded valve position. It prints how many loops are
//! then decided, and how many of these decisions are right. `stiction bench tests` does the same for the planned test.

use rayon::prelude::*;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, Diagnosis, VerdictClass, diagnose};
use stiction_diagnose::recording::Recording;
use stiction_population::LoopKind;
use stiction_population::position::observed;
use stiction_report::words::what_would_answer;

/// A part of the advice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Advice {
    TenCycles,
    Uncompressed,
    Position,
}

impl Advice {
    const ALL: [Self; 3] = [Self::TenCycles, Self::Uncompressed, Self::Position];

    /// Words within the printed advice.
    fn words(self) -> &'static str {
        match self {
            Self::TenCycles => "over at least ten cycles",
            Self::Uncompressed => "without compression",
            Self::Position => "a recorded valve position",
        }
    }

    /// The loop, recorded as advised.
    fn followed(self, kind: LoopKind, seed: u64, now: &Diagnosis) -> Option<Recording> {
        match self {
            Self::TenCycles => {
                let period = now.oscillation()?.1.period_s?;
                let factor = 10.5 * period / now.segment()?.duration();
                Some(kind.simulate_for(seed, factor.max(1.0)).ok()?.recording)
            }
            Self::Uncompressed => Some(kind.simulate_uncompressed(seed).ok()?.recording),
            Self::Position => observed(&kind.simulate(seed).ok()?, seed).ok(),
        }
    }
}

fn diagnosed(recording: &Recording) -> Option<Diagnosis> {
    let options =
        DiagnoseOptions { detectors: Detectors::Only(vec![]), ..DiagnoseOptions::default() };
    diagnose(recording, &options).ok()
}

/// For each part of the advice for a loop, whether it decided, and rightly. `None` for a loop that needs no advice.
fn read(kind: LoopKind, seed: u64) -> Option<Vec<(Advice, bool, bool)>> {
    let simulated = kind.simulate(seed).ok()?;
    let now = diagnosed(&simulated.recording)?;
    if now.verdict.class != VerdictClass::CannotTell {
        return None;
    }
    let text = what_would_answer(&now)?;
    let given = Advice::ALL.into_iter().filter(|advice| text.contains(advice.words()));
    let truth = &simulated.truth;
    let done = given.filter_map(|advice| {
        let verdict = diagnosed(&advice.followed(kind, seed, &now)?)?.verdict;
        let right = match verdict.class {
            VerdictClass::Sticks | VerdictClass::DoesNotRespond => truth.sticks,
            VerdictClass::DoesNotStick => {
                !truth.sticks || verdict.s_below.is_some_and(|limit| truth.s <= limit.value)
            }
            VerdictClass::CannotTell => false,
        };
        Some((advice, verdict.class != VerdictClass::CannotTell, right))
    });
    Some(done.collect())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let n: u64 = std::env::args().nth(1).map_or(Ok(1000), |n| n.parse())?;
    let all: Vec<Vec<(Advice, bool, bool)>> = (0..n)
        .into_par_iter()
        .filter_map(|index| read(LoopKind::at((index as f64 + 0.5) / n as f64), 70_000 + index))
        .collect();
    println!("{} of {n} loops are undecided", all.len());
    for advice in Advice::ALL {
        let of: Vec<_> = all.iter().flatten().filter(|each| each.0 == advice).collect();
        let decided = of.iter().filter(|each| each.1).count();
        let right = of.iter().filter(|each| each.2).count();
        let share = 100.0 * decided as f64 / of.len().max(1) as f64;
        println!(
            "{}: {} loops, {decided} decided ({share:.0} %), {right} of these rightly",
            advice.words(),
            of.len()
        );
    }
    Ok(())
}
