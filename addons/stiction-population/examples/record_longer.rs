//! How often a longer record decides, and the resulting limits of S.
//!
//! ```text
//! cargo run --release -p stiction-population --example record_longer -- 4000
//! ```
//!
//! It prints, for 4,000 loops of all kinds whose usual record is undecided, how many are decided by 2, 4 and 8 times
//! this record. It prints the same for loops with too few slips. It also prints the median limit of S of healthy loops
//! that 8 times the usual record clears, and how many sticking loops with a limit exceed it.

use rayon::prelude::*;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, Diagnosis, VerdictClass, diagnose};
use stiction_diagnose::recording::{Channel, Recording};
use stiction_population::LoopKind;

const TIMES: [f64; 3] = [2.0, 4.0, 8.0];

fn diagnosed(recording: &Recording) -> Option<Diagnosis> {
    let options =
        DiagnoseOptions { detectors: Detectors::Only(vec![]), ..DiagnoseOptions::default() };
    diagnose(recording, &options).ok()
}

fn is_decided(recording: &Recording) -> Option<bool> {
    Some(diagnosed(recording)?.verdict.class != VerdictClass::CannotTell)
}

/// The first part of a recording.
fn first(recording: &Recording, share: f64) -> Recording {
    let end = recording.op.time.last().copied().unwrap_or(0.0) * share;
    let mut part = recording.clone();
    let cut = |channel: &mut Channel| {
        let n = channel.time.partition_point(|t| *t <= end);
        channel.time.truncate(n);
        channel.values.truncate(n);
        channel.quality.truncate(n);
    };
    cut(&mut part.op);
    [&mut part.pv, &mut part.sp, &mut part.vp].into_iter().flatten().for_each(cut);
    part
}

/// A loop by its longest record.
struct Longest {
    sticks: bool,
    s: f64,
    cleared: bool,
    limit: Option<f64>,
    /// If the usual record is undecided.
    undecided: Option<Undecided>,
}

/// Whether longer records are decided.
struct Undecided {
    few_slips: bool,
    longer: [bool; 3],
}

fn read(seed: u64, kind: LoopKind) -> Option<Longest> {
    let [.., most] = TIMES;
    let loop_ = kind.simulate_for(seed, most).ok()?;
    let whole = loop_.recording;
    let now = diagnosed(&first(&whole, 1.0 / most))?;
    let all = diagnosed(&whole)?.verdict;
    let undecided = (now.verdict.class == VerdictClass::CannotTell).then(|| Undecided {
        few_slips: now.few_slips.is_some(),
        longer: TIMES.map(|times| is_decided(&first(&whole, times / most)).unwrap_or(false)),
    });
    let cleared = all.class == VerdictClass::DoesNotStick;
    Some(Longest {
        sticks: loop_.truth.sticks,
        s: loop_.truth.s,
        cleared,
        limit: all.s_below.map(|limit| limit.value),
        undecided,
    })
}

fn print_limits(all: &[Longest]) {
    let mut limits: Vec<f64> = all
        .iter()
        .filter(|each| !each.sticks && each.cleared)
        .filter_map(|each| each.limit)
        .collect();
    limits.sort_unstable_by(f64::total_cmp);
    let [.., most] = TIMES;
    if let Some(median) = limits.get(limits.len() / 2) {
        println!(
            "{} healthy loops are cleared with a record {most} times as long: median limit of S {median:.1} %",
            limits.len()
        );
    }
    for (what, of_all) in [("sticking loops", true), ("cleared sticking loops", false)] {
        let of: Vec<bool> = all
            .iter()
            .filter(|each| each.sticks && (of_all || each.cleared))
            .filter_map(|each| each.limit.map(|limit| each.s > limit))
            .collect();
        let broken = of.iter().filter(|is| **is).count();
        println!("{what} with a limit: S of {broken} of {} exceeds it", of.len());
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let n: u64 = std::env::args().nth(1).map_or(Ok(1000), |n| n.parse())?;
    let all: Vec<Longest> = (0..n)
        .into_par_iter()
        .filter_map(|index| read(50_000 + index, LoopKind::at((index as f64 + 0.5) / n as f64)))
        .collect();
    let share = |of: &[bool]| {
        let k = of.iter().filter(|is| **is).count();
        format!("{k} of {} ({:.0} %)", of.len(), 100.0 * k as f64 / of.len() as f64)
    };
    let of = |what: &str, own: &[&Undecided]| {
        println!("{what}: {} undecided loops", own.len());
        for (k, times) in TIMES.iter().enumerate() {
            let decided: Vec<bool> = own.iter().map(|each| each.longer[k]).collect();
            println!("  decided by {times} times the record: {}", share(&decided));
        }
    };
    println!("{n} loops");
    let undecided: Vec<&Undecided> =
        all.iter().filter_map(|each| each.undecided.as_ref()).collect();
    of("all", &undecided);
    let few: Vec<&Undecided> = undecided.into_iter().filter(|each| each.few_slips).collect();
    of("too few slips", &few);
    print_limits(&all);
    Ok(())
}
