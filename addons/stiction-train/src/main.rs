//! Trains the model of the verdict on simulated loops.
//!
//! ```text
//! population ──> evidence ──> dataset ──> bins ──> boost (grow) ──> learn (calibrate) ──> Bundle
//!                             (matrix_file)   ├──> families (left out in turn)     measure ──> card
//!                                             ├──> mistakes (of columns)
//!                                             ├──> decide (thresholds)
//!                                             └──> reference (quantiles, distance)
//! ```

mod bins;
mod boost;
mod calibrate;
mod card;
mod curve;
mod dataset;
mod decide;
mod families;
mod grow;
mod hear;
mod learn;
mod limit;
mod matrix_file;
mod measure;
mod members;
mod mistakes;
mod planned_tests;
mod random;
mod reference;
mod signals;
mod signals_file;
#[cfg(test)]
mod synthetic;
mod valves;

use anyhow::{Context, Result, ensure};
use clap::{Parser, Subcommand};
use dataset::Dataset;
use members::Both;
use sha2::{Digest, Sha256};
use signals_file::SignalsFile;
use std::io::IsTerminal;
use std::path::PathBuf;
use stiction_diagnose::evidence::raw::{self, Net};
use stiction_diagnose::fusion::Provenance;

/// The share of the members for calibration and intervals.
const CALIBRATED: f64 = 0.2;

/// Members for each recording with a mistake in its columns.
const MISTAKEN: u64 = 8;

/// Train the model of the verdict on simulated loops.
///
/// Simulates members of the population and gathers their evidence. The command learns from four fifths of the members,
/// calibrates on the rest, leaves out every family of loops in turn to find the confidence of the verdict, and measures
/// on members of another seed. The command writes verdict.bin and the model card README.md. The same arguments and the
/// same nets give the same bytes on any number of threads. The output of nets on their own training loops must not serve
/// as evidence, so first run gather, train the nets, and run hear.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction-train --n 40000 --cache matrices gather
  stiction-train --n 40000 --cache matrices families

addons/stiction-train/train.sh gathers, trains the nets, adds their output, and trains the trees.")]
struct Args {
    /// Members of the population for learning and calibration
    #[arg(long, value_name = "N", default_value_t = 40_000, global = true,
          value_parser = clap::value_parser!(u64).range(100..=10_000_000))]
    n: u64,
    /// Seed of the population; the loops for measuring have the next seed
    #[arg(long, value_name = "SEED", default_value_t = 1, global = true)]
    seed: u64,
    /// Members for measuring [default: a quarter of N]
    #[arg(long, value_name = "N", global = true,
          value_parser = clap::value_parser!(u64).range(100..=10_000_000))]
    test: Option<u64>,
    /// Keep the evidence in this folder as CSV, and read it from there if it is of the same loops and features. A
    /// changed computation of a feature is not detected
    #[arg(long, value_name = "DIR", global = true)]
    cache: Option<PathBuf>,
    /// For trials, leave out no families, so that confidence and intervals of S are not corrected
    #[arg(long)]
    no_families: bool,
    /// Folder for verdict.bin and README.md
    #[arg(short, long, value_name = "DIR", required = true, requires = "cache")]
    output: Option<PathBuf>,
    #[command(subcommand)]
    experiment: Option<Experiment>,
}

#[derive(Subcommand)]
#[command(subcommand_negates_reqs = true)]
enum Experiment {
    /// Print the accuracy of the verdict on every family of loops that is left out of its training
    Families,
    /// Print the benefit of more loops for learning, and the limit of an observer who knows the stem
    Curve,
    /// Print the benefit of a net that was trained on every second loop, without some families
    Signals {
        /// The net, of `train.py --half`
        net: PathBuf,
        /// A family without training of the net, such as "kind: external wave"; may be repeated
        #[arg(long)]
        without: Vec<String>,
    },
    /// Only gather the evidence, and the input of the nets, into the folder of --cache
    Gather,
    /// Add the output of the nets, for loops that they were not trained on, to the evidence in the folder of
    /// --cache
    Hear,
    /// Simulate N valves with long records, and write the evidence of their windows into the folder of --cache
    Valves {
        /// The kinds that are never trained on, instead of the population
        #[arg(long)]
        invented: bool,
        /// Only pool the windows in the folder of --cache
        #[arg(long)]
        pool: bool,
    },
    /// Test N loops, and print the calibration of valve tests
    Tests,
}

fn main() -> Result<()> {
    let args = Args::parse();
    let members = args.test.unwrap_or((args.n / 4).max(100));
    let trained = ((1.0 - CALIBRATED) * args.n as f64).round() as u64;
    let fresh = args.seed.wrapping_add(1);
    if let Some(Experiment::Valves { invented, pool }) = args.experiment {
        let folder =
            args.cache.as_ref().context("valves needs --cache DIR, the folder for the evidence")?;
        let source = if invented { valves::Source::Invented } else { valves::Source::Population };
        if !pool {
            let progress = |done| tell_progress(args.seed, done, args.n, "valves");
            valves::gather(folder, source, args.seed, args.n, progress)?;
        }
        return valves::pool(folder, source, args.seed);
    }
    if matches!(args.experiment, Some(Experiment::Tests)) {
        let done = std::sync::atomic::AtomicU64::new(0);
        let all = args.n + args.n / 3;
        return planned_tests::fit(args.seed, args.n, || {
            let done = 1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            tell_progress(args.seed, done, all, "loops");
        });
    }
    let mut test = gather(&args, fresh, members)?;
    let mut train = gather(&args, args.seed, args.n)?;
    if args.experiment.is_none() {
        test.mistaken = mistaken(&args, fresh, members / MISTAKEN)?;
        train.mistaken = mistaken(&args, args.seed, args.n / MISTAKEN)?;
    }
    match (&args.experiment, &args.output) {
        (Some(Experiment::Gather), _) => {
            ensure!(args.cache.is_some(), "gather needs --cache DIR, the folder for the evidence");
        }
        (Some(asked @ (Experiment::Hear | Experiment::Signals { .. })), _) => {
            let folder = args
                .cache
                .as_ref()
                .context("hear needs --cache DIR, the folder written by gather")?;
            let net = match asked {
                Experiment::Signals { net, .. } => {
                    let bytes = std::fs::read(net)
                        .with_context(|| format!("cannot read {}", net.display()))?;
                    Net::from_bytes(&bytes)?
                }
                _ => raw::shipped()
                    .context("model/net.bin is not a net; train the net first")?
                    .clone(),
            };
            let signals = |seed, members| folder.join(format!("signals-{seed}-{members}.bin"));
            hear::hear(&mut test.full, &signals(fresh, members), &net, 0)?;
            hear::hear(&mut train.full, &signals(args.seed, args.n), &net, trained)?;
            if let Experiment::Signals { without, .. } = asked {
                print!("{}", signals::table(&train.full, &test.full, trained, without)?);
                return Ok(());
            }
            for (data, seed, members) in
                [(&test.full, fresh, members), (&train.full, args.seed, args.n)]
            {
                let key = matrix_file::key(stiction_population::VERSION, seed, members);
                matrix_file::write(&folder.join(format!("seed-{seed}-{members}.csv")), &key, data)?;
            }
        }
        (Some(Experiment::Curve), _) => print!("{}", curve::table(&train.full, &test.full, tell)?),
        (Some(Experiment::Families), _) => {
            print!("{}", learn::leave_out(&train.full, trained, tell)?.table());
        }
        (None, Some(folder)) => {
            let provenance = Provenance {
                command: format!(
                    "cargo run --profile dist -p stiction-train -- --n {} --seed {} --test {members}{} --cache \
                     target/training -o crates/stiction-diagnose/model",
                    args.n,
                    args.seed,
                    if args.no_families { " --no-families" } else { "" },
                ),
                population: stiction_population::VERSION,
                seed: args.seed,
                trained,
                calibrated: args.n - trained,
            };
            let learned = learn::learn(&train, provenance, !args.no_families, tell)?;
            let bytes = learned.bundle.to_bytes();
            let sha256: String =
                Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
            let test = card::Test { data: &test, seed: fresh, members };
            let card = card::card(&learned, &sha256, &train.full, &test)?;
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot make {}", folder.display()))?;
            for (name, bytes) in [("verdict.bin", &bytes[..]), ("README.md", card.as_bytes())] {
                let path = folder.join(name);
                std::fs::write(&path, bytes)
                    .with_context(|| format!("cannot write {}", path.display()))?;
            }
            print!("{card}");
        }
        (Some(Experiment::Valves { .. } | Experiment::Tests), _) | (None, None) => {
            unreachable!("clap asks for --output")
        }
    }
    Ok(())
}

/// The evidence of the first members of a population, read or simulated.
fn gather(args: &Args, seed: u64, members: u64) -> Result<Both> {
    let key = matrix_file::key(stiction_population::VERSION, seed, members);
    let paths = args.cache.as_ref().map(|folder| {
        ["", "-op"].map(|suffix| folder.join(format!("seed-{seed}-{members}{suffix}.csv")))
    });
    if let Some([full, alone]) = &paths
        && full.exists()
        && alone.exists()
    {
        let read = |path| matrix_file::read(path, &key, members::columns());
        let mistaken = Dataset::default();
        return Ok(Both { full: read(full)?, alone: read(alone)?, mistaken });
    }
    let mut signals = match &args.cache {
        None => None,
        Some(folder) => {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot make {}", folder.display()))?;
            Some(SignalsFile::create(&folder.join(format!("signals-{seed}-{members}.bin")))?)
        }
    };
    let progress = |done| tell_progress(seed, done, members, "loops");
    let both = members::simulate(seed, members, signals.as_mut(), progress)?;
    signals.map_or(Ok(()), SignalsFile::finish)?;
    if let Some([full, alone]) = &paths {
        matrix_file::write(full, &key, &both.full)?;
        matrix_file::write(alone, &key, &both.alone)?;
    }
    Ok(both)
}

/// The evidence of the first mistaken recordings of a seed, read or made.
fn mistaken(args: &Args, seed: u64, recordings: u64) -> Result<Dataset> {
    let key = matrix_file::key_of_mistaken(stiction_population::VERSION, seed, recordings);
    let path =
        args.cache.as_ref().map(|folder| folder.join(format!("mistaken-{seed}-{recordings}.csv")));
    if let Some(path) = path.as_ref().filter(|path| path.exists()) {
        return matrix_file::read(path, &key, members::columns());
    }
    let progress = |done| tell_progress(seed, done, recordings, "mistaken recordings");
    let data = members::mistaken(seed, recordings, progress)?;
    if let (Some(folder), Some(path)) = (&args.cache, &path) {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make {}", folder.display()))?;
        matrix_file::write(path, &key, &data)?;
    }
    Ok(data)
}

/// Prints the progress on a terminal.
fn tell_progress(seed: u64, done: u64, all: u64, what: &str) {
    if std::io::stderr().is_terminal() {
        eprint!("\rseed {seed}: {done} of {all} {what}");
        if done == all {
            eprintln!();
        }
    }
}

/// Prints the present step on a terminal.
fn tell(what: &str) {
    if std::io::stderr().is_terminal() {
        eprintln!("{what}");
    }
}
