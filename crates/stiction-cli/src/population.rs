//! `stiction population`: simulated loops with known truth, as files.

use crate::files::{self, Out};
use crate::{output, progress};
use anyhow::{Context, Result};
use clap::Parser;
use rayon::prelude::*;
use stiction::population::{self, LoopKind, Simulated};
use stiction_io::table;
use stiction_io::whole::WholeFile;

/// Simulate a population of loops with known truth, to train or to test a method.
///
/// Writes a folder with a recording per loop, loop-NUMBER.csv, with the columns t, sp, pv, op. The file truth.csv has a
/// row per loop with its kind, S, J and all other drawn properties. The file index.csv is for stiction bench labels.
/// docs/population.md explains the properties. The same seed gives the same files on every machine.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction population --n 1000 --seed 7 -o loops
  stiction bench labels loops/index.csv
  stiction population --n 20 --kind \"external wave\" --vp -o waves")]
pub struct Args {
    /// Number of loops
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    n: u64,
    /// Seed of the population
    #[arg(long, default_value_t = 1, value_name = "SEED")]
    seed: u64,
    /// Folder to write to; created if missing
    #[arg(short, long, value_name = "DIR")]
    output: Out,
    /// Simulate only loops of this kind, such as "sticky valve", with the seeds from SEED on
    #[arg(long, value_name = "NAME")]
    kind: Option<String>,
    /// Write the valve position too, which reveals the answer to methods that use it
    #[arg(long)]
    vp: bool,
}

/// Number of loops held in memory at a time.
const BATCH: u64 = 256;

pub fn run(args: Args) -> Result<()> {
    let kind = args.kind.as_deref().map(LoopKind::by_name).transpose()?;
    let folder = &args.output;
    files::make_empty_folder(folder)?;
    // They mark the folder as complete, so they come last. Those of another population would not fit.
    let (truth, listed) = (folder.inside("truth.csv")?, folder.inside("index.csv")?);
    let open = |path: &Out| {
        let _ = std::fs::remove_file(&**path);
        let file = WholeFile::create(path).with_context(|| path.display().to_string())?;
        anyhow::Ok(csv::Writer::from_writer(file))
    };
    let (mut truths, mut index) = (open(&truth)?, open(&listed)?);
    index.write_record(["loop", "label", "loop_type"])?;

    let digits = (args.n - 1).to_string().len();
    let progress = progress::bar("simulating", args.n as usize);
    let mut sticky = 0;
    for from in (0..args.n).step_by(BATCH as usize) {
        let batch: Vec<(String, Simulated)> = (from..args.n.min(from + BATCH))
            .into_par_iter()
            .map(|k| {
                let simulated = match kind {
                    Some(kind) => kind.simulate(args.seed.wrapping_add(k))?,
                    None => population::member(args.seed, k)?,
                };
                let name = format!("loop-{k:0digits$}");
                write_recording(folder, &name, &simulated, args.vp)?;
                progress.inc(1);
                Ok((name, simulated))
            })
            .collect::<Result<_>>()?;
        for (k, (name, Simulated { recording, truth })) in batch.iter().enumerate() {
            let facts = || truth.entries().into_iter().chain(truth.facts.entries());
            if from == 0 && k == 0 {
                truths.write_record(["file"].into_iter().chain(facts().map(|(name, _)| name)))?;
            }
            let cells = facts().map(|(_, value)| value.to_string());
            truths.write_record([format!("{name}.csv")].into_iter().chain(cells))?;
            let label = if truth.sticks { "stiction" } else { "no stiction" };
            index.write_record([name, label, recording.loop_type.name()])?;
            sticky += usize::from(truth.sticks);
        }
    }
    progress.finish_and_clear();
    for (path, written) in [(truth, truths), (listed, index)] {
        let file = written.into_inner().map_err(|e| e.into_error());
        file.and_then(WholeFile::keep).with_context(|| path.display().to_string())?;
    }
    output::line(format!(
        "{} loops, {sticky} with a valve at fault; see {}",
        args.n,
        folder.display()
    ))
}

fn write_recording(folder: &Out, name: &str, simulated: &Simulated, vp: bool) -> Result<()> {
    output::write(Some(&folder.inside(format!("{name}.csv"))?), recorded(simulated, vp).as_bytes())
}

/// A loop as a plant would have recorded it, as CSV, optionally with the valve position.
pub fn recorded(simulated: &Simulated, vp: bool) -> String {
    let recording = &simulated.recording;
    let op = &recording.op;
    let times = table::times(simulated.truth.facts.sample_time_s, op.values.len());
    let mut columns = vec![("t", Some(&times[..]))];
    let measured = [("sp", &recording.sp), ("pv", &recording.pv)];
    // An empty column would be interpreted as a signal that is missing throughout.
    let there =
        measured.iter().filter_map(|(name, x)| x.as_ref().map(|x| (*name, Some(&x.values[..]))));
    columns.extend(there.chain([("op", Some(&op.values[..]))]));
    if vp {
        columns.push(("vp", Some(&simulated.truth.vp)));
    }
    table::write(&columns)
}
