//! How often a change of a valve within one recording is found, and how often one is reported that is none.
//!
//! ```text
//! cargo run --release -p stiction-population --example valve_changes -- 200 40
//! ```
//!
//! prints, for 200 loops with records of 40 usual lengths, the results of four cases. They are sticking valves that are
//! repaired in the middle, these with both halves exchanged, these without a repair, and loops of all kinds without
//! changes. The change is visible if the windows of one half accuse the valve and the windows of the other half do not.

use rayon::prelude::*;
use stiction_diagnose::diagnose::Weighing;
use stiction_diagnose::recording::{Channel, Grid, GridOptions, Recording};
use stiction_population::{LoopKind, Repaired};

/// A recording with a change at a known time.
struct Read {
    weighing: Weighing,
    at: f64,
}

fn weighed(recording: &Recording) -> Option<Weighing> {
    let grid = Grid::of(recording, &GridOptions::default()).ok()?;
    Weighing::of(grid.longest()?).ok()
}

/// One recording directly after another.
fn joined(first: &Recording, second: &Recording) -> Option<(Recording, f64)> {
    let (mut all, mut second) = (first.clone(), second.clone());
    let step = second.op.time.get(1)? - second.op.time.first()?;
    let at = all.op.time.last()? + step;
    let shift = at - second.op.time.first()?;
    let append = |to: &mut Channel, from: &mut Channel| {
        to.time.extend(from.time.iter().map(|t| t + shift));
        to.values.append(&mut from.values);
        to.quality.append(&mut from.quality);
    };
    append(&mut all.op, &mut second.op);
    for (to, from) in [(&mut all.pv, &mut second.pv), (&mut all.sp, &mut second.sp)] {
        if let (Some(to), Some(from)) = (to, from) {
            append(to, from);
        }
    }
    Some((all, at))
}

impl Read {
    fn of((recording, at): (Recording, f64)) -> Option<Self> {
        Some(Self { weighing: weighed(&recording)?, at })
    }

    /// Whether exactly one half of the record, judged separately, accuses the valve.
    fn is_visible(halves: [&Recording; 2]) -> Option<bool> {
        let [a, b] = halves
            .map(|half| weighed(half).map(|half| half.probability >= half.thresholds().accuse));
        Some(a? != b?)
    }

    /// Whether it begins anew near the true time.
    fn is_found(&self) -> bool {
        let window = self.weighing.windows.first().map_or(0.0, |window| window.duration);
        let mut events = self.weighing.changes.iter().filter(|event| event.change.begins_anew());
        events.any(|event| {
            let (from, to) = event.interval;
            (from - window..=to + window).contains(&self.at)
        })
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Vec<f64> =
        std::env::args().skip(1).map(|n| n.parse()).collect::<Result<_, _>>()?;
    let (n, factor) =
        (numbers.first().copied().unwrap_or(100.0) as u64, numbers.get(1).copied().unwrap_or(40.0));
    let seen: Vec<[Option<(bool, bool)>; 3]> = (0..n)
        .into_par_iter()
        .map(|seed| {
            let Ok(Some(of)) = Repaired::simulate_for(seed, factor) else { return [None; 3] };
            let visible = Read::is_visible([&of.before, &of.after]);
            let read =
                |a, b| Read::of(joined(a, b)?).map(|read| (visible == Some(true), read.is_found()));
            let same = joined(&of.before, &of.unrepaired).and_then(Read::of).map(|read| {
                (true, read.weighing.changes.iter().any(|event| event.change.begins_anew()))
            });
            [read(&of.before, &of.after), read(&of.after, &of.before), same]
        })
        .collect();
    for (k, what) in ["repaired", "begins to stick", "sticks all the time"].into_iter().enumerate()
    {
        let all: Vec<(bool, bool)> = seen.iter().filter_map(|of| of[k]).collect();
        let visible: Vec<bool> =
            all.iter().filter(|(visible, _)| *visible).map(|(_, is)| *is).collect();
        let found = visible.iter().filter(|is| **is).count();
        println!(
            "{what}: {} loops, {} visible, change reported in {found}",
            all.len(),
            visible.len()
        );
    }
    let still: Vec<usize> = (0..n)
        .into_par_iter()
        .filter_map(|index| {
            let kind = LoopKind::at((index as f64 + 0.5) / n as f64);
            let weighing = weighed(&kind.simulate_for(1000 + index, factor).ok()?.recording)?;
            Some(weighing.changes.iter().filter(|event| event.change.begins_anew()).count())
        })
        .collect();
    let wrong = still.iter().filter(|changes| **changes > 0).count();
    println!("nothing changes: {} loops of all kinds, change reported in {wrong}", still.len());
    Ok(())
}
