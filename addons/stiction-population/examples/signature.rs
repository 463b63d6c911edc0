//! Prints the signature of a valve that binds in the middle of its stroke, as CSV: how `samples/test/LV104-signature.csv`
//! was made.
//!
//! ```text
//! cargo run --release -p stiction-population --example signature > LV104-signature.csv
//! ```

use std::io::Write;
use stiction_diagnose::valve_test::signature_plan;
use stiction_model::Bands;
use stiction_model::closed_loop::NormalStream;
use stiction_model::valve::{Model, Start, StemLag, Valve};

/// S at a stem position, percent. J is half of S.
fn friction(stem: f64) -> f64 {
    if (40.0..60.0).contains(&stem) { 5.4 } else { 2.2 }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let plan = signature_plan("LV104", [0.0, 100.0]).map_err(|why| why.0)?;
    let (mut at, mut op) = (plan.from_op, vec![plan.from_op; 60]);
    for ramp in &plan.ramps {
        let n = ramp.duration_s as usize;
        op.extend((1..=n).map(|k| at + (ramp.to_op - at) * k as f64 / n as f64));
        op.extend(vec![ramp.to_op; ramp.hold_s as usize]);
        at = ramp.to_op;
    }
    let build = |s: f64| Model::TwoPhase.build(Bands::from_s_j(s, 0.5 * s)?);
    let (mut lag, mut noise) = (StemLag::new(0.8, 1.0)?, NormalStream::new(104));
    let (mut stem, mut s) = (0.0, friction(0.0));
    let mut valve = build(s)?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "time_s,OP,VP")?;
    for (k, op) in op.iter().enumerate() {
        if friction(stem) != s {
            s = friction(stem);
            valve = build(s)?;
            valve.restart(Start { op: *op, ..Start::at_rest(stem) });
        }
        stem = valve.step(*op).clamp(0.0, 100.0);
        writeln!(out, "{k},{op:.2},{:.2}", lag.step(stem) - 0.7 + 0.04 * noise.draw())?;
    }
    Ok(())
}
