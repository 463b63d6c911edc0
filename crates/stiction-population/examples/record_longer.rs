//! How often a longer record decides.
//!
//! ```text
//! cargo run --release -p stiction-population --example record_longer -- 4000
//! ```
//!
//! prints, for 4,000 loops of all kinds of which a record of the usual length is undecided, how many are decided by 2, 4 and 8 times
//! this record, and the same of those with too few slips.

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

/// Whether longer records are decided, if the usual one is not.
struct Undecided {
    few_slips: bool,
    longer: [bool; 3],
}

fn read(seed: u64, kind: LoopKind) -> Option<Undecided> {
    let [.., most] = TIMES;
    let whole = kind.simulate_for(seed, most).ok()?.recording;
    let now = diagnosed(&first(&whole, 1.0 / most))?;
    if now.verdict.class != VerdictClass::CannotTell {
        return None;
    }
    let longer = TIMES.map(|times| is_decided(&first(&whole, times / most)).unwrap_or(false));
    Some(Undecided { few_slips: now.few_slips.is_some(), longer })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let n: u64 = std::env::args().nth(1).map_or(Ok(1000), |n| n.parse())?;
    let all: Vec<Undecided> = (0..n)
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
    of("all", &all.iter().collect::<Vec<_>>());
    let few: Vec<&Undecided> = all.iter().filter(|each| each.few_slips).collect();
    of("too few slips", &few);
    Ok(())
}
