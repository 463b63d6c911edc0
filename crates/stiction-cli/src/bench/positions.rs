//! Simulated loops whose valve position is recorded.

use super::About;
use super::measure::{Known, Measured, Plan};
use anyhow::{Context, Result};
use stiction::population::position::positioned;
use stiction::scoreboard::Truth;
use stiction_report::document::Source;

/// Measures the first `n` loops of `seed`.
pub fn measure(seed: u64, n: u64, plan: &Plan<'_>) -> Result<(About, Measured)> {
    let loops: Vec<u64> = (0..n).collect();
    let mut measured = Measured::default();
    measured.add(&loops, |index| load(seed, *index), plan)?;
    let about = About {
        title: format!("{n} simulated loops with a recorded valve position"),
        origin: format!(
            "Loops 0 to {} of the generator of positions, seed {seed}. A sticking valve counts as visible if it \
             slips ten times and S is three times the noise of OP and of the position.",
            n - 1
        ),
    };
    Ok((about, measured.finish(plan)?))
}

fn load(seed: u64, index: u64) -> Result<Known> {
    let name = format!("position {index}");
    let made = positioned(seed, index).with_context(|| name.clone())?;
    let mut recording = made.recording;
    recording.name = name.clone();
    let source = Source { file: "simulated".to_owned(), sha256: String::new() };
    Ok(Known { recording, source, truth: Truth::of_position(name, &made.truth) })
}
