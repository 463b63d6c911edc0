//! Prints a loop of the population with a test of its valve at the end, as CSV: how the samples in `samples/test` were
//! made. KIND is the kind of the loop, by default a sticking valve.
//!
//! ```text
//! cargo run --release -p stiction-population --example valve_trial -- SEED [KIND] > loop.csv
//! ```

use std::io::Write;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, diagnose};
use stiction_diagnose::valve_test::{PlanOptions, plan};
use stiction_population::{LoopKind, Operator, Trend};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seed = std::env::args().nth(1).ok_or("give a seed")?.parse()?;
    let kind = std::env::args().nth(2).map(|name| LoopKind::by_name(&name));
    let kind = kind.transpose()?.unwrap_or(LoopKind::Sticky);
    let tested =
        kind.tested(seed, 12.0, Operator::Careful, Trend::AsPlanned, &mut |before, of| {
            let asked =
                DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
            let options = PlanOptions {
                rises: Some(of.rises),
                pv_allowed: Some(of.pv_allowed),
                ..PlanOptions::default()
            };
            plan(&diagnose(before, &asked).ok()?, &options).ok()
        })?;
    let tested = tested.ok_or("this loop has no plan")?;
    let (recording, sets) = (&tested.whole, &tested.carried.sheet.sets);
    let (pv, sp) =
        (recording.pv.as_ref().ok_or("no PV")?, recording.sp.as_ref().ok_or("no SP is recorded")?);
    let valve = tested.valve;
    eprintln!("{valve:?}");
    let mut out = std::io::stdout().lock();
    writeln!(out, "time_s,OP,PV,SP,mode")?;
    for (k, t) in recording.op.time.iter().enumerate() {
        // The OP of a sample is that of its end.
        let end = t + 0.5 * valve.sample_time_s;
        let last = sets.iter().rev().find(|set| set.at_s <= end);
        let mode = if last.is_some_and(|set| set.op.is_some()) { "MAN" } else { "AUTO" };
        writeln!(
            out,
            "{t},{:.3},{:.5},{:.5},{mode}",
            recording.op.values[k], pv.values[k], sp.values[k]
        )?;
    }
    Ok(())
}
