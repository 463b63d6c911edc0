//! `stiction bench`: every method on loops whose truth is known.

use crate::diagnose::{Diagnosed, diagnose_all};
use crate::output;
use anyhow::{Result, bail};
use clap::Parser;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use stiction::detect::{self, Decides, Decision};
use stiction::diagnose::scoreboard::{Counts, wilson};
use stiction::diagnose::{Diagnosis, Options, VerdictClass};
use stiction::population::{self, Kind};
use stiction::recording::{LoopType, Recording};
use stiction_io::{ReadOptions, Table};
use stiction_report::document::Source;

/// Measure every method on loops whose truth is known: labelled recordings, or simulated families.
///
/// Prints tables in Markdown: of labelled recordings, how many sticky and healthy ones each method
/// calls sticky, not sticky, is undecided about or abstains from; of simulated families, the share
/// each method calls sticky, with its 95 % interval (Wilson).
///
/// An index of labelled recordings is a CSV with the columns loop and label (stiction or
/// no stiction), and, where they are known, loop_type and tag, the valve; the recording of a loop is
/// the file LOOP.csv beside the index. No threshold is ever fitted to labels.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction bench --labels recordings/index.csv --csv details.csv
  stiction bench --simulated 200")]
pub struct Args {
    /// Index of labelled recordings
    #[arg(long, value_name = "INDEX.csv", required_unless_present = "simulated")]
    labels: Option<PathBuf>,
    /// Simulate this many loops of each family
    #[arg(long, value_name = "N", conflicts_with = "labels",
          value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    simulated: Option<u64>,
    /// First seed of the simulated loops
    #[arg(long, default_value_t = 1, value_name = "SEED")]
    seed: u64,
    /// Write every loop's statistics and decisions to this CSV file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

/// The name under which the verdict stands among the methods.
const VERDICT: &str = "verdict (majority)";

/// A loop with its truth.
struct Labelled {
    name: String,
    /// Its family or valve.
    group: String,
    sticks: bool,
    diagnosis: Diagnosis,
}

pub fn run(args: Args) -> Result<()> {
    let (loops, tables) = match (&args.labels, args.simulated) {
        (Some(index), _) => {
            let loops = labelled(index)?;
            let tables = of_labels(&loops);
            (loops, tables)
        }
        (None, Some(n)) => {
            let loops = simulated(args.seed, n)?;
            let tables = of_families(&loops, args.seed, n);
            (loops, tables)
        }
        (None, None) => bail!("nothing to measure: give --labels or --simulated"),
    };
    if let Some(path) = &args.csv {
        output::write(Some(path), details(&loops)?.as_bytes())?;
    }
    output::write(None, tables.as_bytes())
}

/// Name, title and meaning of all methods, and the verdict behind them.
fn methods() -> Vec<(&'static str, &'static str)> {
    let mut methods: Vec<_> = detect::all()
        .iter()
        .map(|detector| {
            let method = detector.method();
            (method.name, method.title)
        })
        .collect();
    methods.push((VERDICT, VERDICT));
    methods
}

/// What a method, or the verdict, decided.
fn decision(diagnosis: &Diagnosis, method: &str) -> Decision {
    if method == VERDICT {
        return match diagnosis.verdict.class {
            VerdictClass::Sticks => Decision::Sticks,
            VerdictClass::DoesNotStick => Decision::DoesNotStick,
            _ => Decision::Undecided,
        };
    }
    let finding = diagnosis.findings.iter().find(|f| f.method.name == method);
    finding.map_or(Decision::Abstains, |f| f.decision)
}

fn labelled(index: &Path) -> Result<Vec<Labelled>> {
    let table = Table::read(index)?;
    let folder = index.parent().unwrap_or(Path::new(""));
    let (names, labels) = (table.texts("loop")?, table.texts("label")?);
    let types = table.texts("loop_type").or_else(|_| table.texts("loop_type_unverified")).ok();
    let tags = table.texts("tag").ok();
    let (mut recordings, mut truths) = (vec![], vec![]);
    for (k, name) in names.iter().enumerate() {
        let sticks = match &labels[k][..] {
            "stiction" => true,
            "no stiction" => false,
            // A loop without a label teaches nothing.
            "" => continue,
            other => bail!(
                "{}: the label of {name} is \"{other}\", but must be stiction or no stiction",
                index.display()
            ),
        };
        let reading = stiction_io::reading::read(
            &folder.join(format!("{name}.csv")),
            &ReadOptions::default(),
        )?;
        let Some(mut recording) = reading.recordings.into_iter().next() else { continue };
        recording.name = name.clone();
        if let Some(word) =
            types.as_ref().map(|types| &types[k][..]).filter(|word| !word.is_empty())
        {
            recording.loop_type = LoopType::by_name(word).unwrap_or(LoopType::Unknown);
        }
        let group = tags.as_ref().map_or(name, |tags| &tags[k]).clone();
        truths.push((group, sticks));
        recordings.push((Source { file: reading.origin, sha256: reading.sha256 }, recording));
    }
    collect(&recordings, truths)
}

/// Diagnoses recordings whose truth is known.
fn collect(
    recordings: &[(Source, Recording)],
    truths: Vec<(String, bool)>,
) -> Result<Vec<Labelled>> {
    let (loops, mut failures) = diagnose_all(recordings, &Options::default());
    if let Some(failure) = failures.pop() {
        return Err(failure);
    }
    let loops =
        loops.into_iter().zip(truths).map(|(Diagnosed { diagnosis, .. }, (group, sticks))| {
            Labelled { name: diagnosis.name.clone(), group, sticks, diagnosis }
        });
    Ok(loops.collect())
}

fn simulated(seed: u64, n: u64) -> Result<Vec<Labelled>> {
    let wanted: Vec<(Kind, u64)> =
        Kind::ALL.iter().flat_map(|kind| (seed..seed + n).map(move |seed| (*kind, seed))).collect();
    let made: Vec<_> = wanted
        .par_iter()
        .map(|(kind, seed)| kind.simulate(*seed).map(|simulated| (*kind, simulated)))
        .collect::<stiction::Result<_>>()?;
    let truths =
        made.iter().map(|(kind, simulated)| (kind.name().to_owned(), simulated.truth.sticks));
    let truths = truths.collect();
    let recordings: Vec<_> = made
        .into_iter()
        .map(|(_, simulated)| {
            let file = "simulated".to_owned();
            (Source { file, sha256: String::new() }, simulated.recording)
        })
        .collect();
    collect(&recordings, truths)
}

/// What each method decides on labelled recordings, by recording and by valve.
fn of_labels(loops: &[Labelled]) -> String {
    let mut out = String::new();
    let by_loop: Vec<(bool, Vec<&Diagnosis>)> =
        loops.iter().map(|each| (each.sticks, vec![&each.diagnosis])).collect();
    out += &decisions("recordings", &by_loop);
    let mut valves: BTreeMap<&str, (bool, Vec<&Diagnosis>)> = BTreeMap::new();
    for each in loops {
        let valve = valves.entry(&each.group).or_insert((false, vec![]));
        valve.0 |= each.sticks;
        valve.1.push(&each.diagnosis);
    }
    if valves.len() < loops.len() {
        let by_valve: Vec<_> = valves.into_values().collect();
        out += "\nBy valve: what most of a valve's recordings come to.\n\n";
        out += &decisions("valves", &by_valve);
    }
    out
}

/// A table of what each method decides on sticky and healthy loops, each seen in some recordings.
fn decisions(what: &str, loops: &[(bool, Vec<&Diagnosis>)]) -> String {
    let count = |sticks: bool| loops.iter().filter(|each| each.0 == sticks).count();
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "{} sticky and {} healthy {what}. Each cell: sticks / does not / undecided / abstains \
         (methods marked *: nonlinear / linear).\n",
        count(true),
        count(false)
    );
    let _ = writeln!(
        out,
        "| method | on sticky | on healthy | recall | 95 % | false alarms | 95 % |\n\
         |---|---|---|---|---|---|---|"
    );
    for (method, title) in methods() {
        let of = |sticks: bool| {
            let mut counts = Counts::default();
            for (_, seen) in loops.iter().filter(|each| each.0 == sticks) {
                let mut votes = Counts::default();
                seen.iter().for_each(|diagnosis| votes.add(decision(diagnosis, method)));
                counts.add(votes.majority());
            }
            counts
        };
        let (sticky, healthy) = (of(true), of(false));
        let cell = |c: Counts| {
            format!("{} / {} / {} / {}", c.positive, c.negative, c.undecided, c.abstains)
        };
        let _ = writeln!(
            out,
            "| {title}{} | {} | {} | {} | {} |",
            star(method),
            cell(sticky),
            cell(healthy),
            share(sticky.positive, sticky.all(), " | "),
            share(healthy.positive, healthy.all(), " | "),
        );
    }
    out
}

/// A mark for the methods that decide on linearity, not on stiction.
fn star(method: &str) -> &'static str {
    let decides = detect::all()
        .iter()
        .find(|detector| detector.method().name == method)
        .map(|detector| detector.method().decides);
    if decides == Some(Decides::Nonlinearity) { " *" } else { "" }
}

/// A share in percent and its interval.
fn share(k: usize, n: usize, between: &str) -> String {
    if n == 0 {
        return format!("-{between}-");
    }
    let (low, high) = wilson(k, n);
    format!(
        "{:.0} %{between}{:.0} to {:.0}",
        100.0 * k as f64 / n as f64,
        100.0 * low,
        100.0 * high
    )
}

/// The share of each family that each method calls sticky.
fn of_families(loops: &[Labelled], seed: u64, n: u64) -> String {
    let mut out = format!(
        "{n} simulated loops of each family (version {}, seeds {seed} to {}). Each cell: share called \
         sticky, or nonlinear (methods marked *), and its 95 % interval; in brackets, the share the \
         method abstains from, if any.\n\n| method |",
        population::VERSION,
        seed + n - 1
    );
    for kind in Kind::ALL {
        let _ = write!(out, " {} |", kind.name());
    }
    out += "\n|---|";
    out += &"---|".repeat(Kind::ALL.len());
    out.push('\n');
    for (method, title) in methods() {
        let _ = write!(out, "| {title}{} |", star(method));
        for kind in Kind::ALL {
            let mut counts = Counts::default();
            for each in loops.iter().filter(|each| each.group == kind.name()) {
                counts.add(decision(&each.diagnosis, method));
            }
            let _ = write!(out, " {}", share(counts.positive, counts.all(), ", "));
            if counts.abstains > 0 {
                let abstains = 100.0 * counts.abstains as f64 / counts.all() as f64;
                let _ = write!(out, " ({abstains:.0} %)");
            }
            out += " |";
        }
        out.push('\n');
    }
    out
}

/// One row a loop and method.
fn details(loops: &[Labelled]) -> Result<String> {
    let mut writer = csv::Writer::from_writer(vec![]);
    writer.write_record([
        "loop",
        "group",
        "sticks",
        "method",
        "statistic",
        "threshold",
        "decision",
    ])?;
    for each in loops {
        let say = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
        for finding in &each.diagnosis.findings {
            writer.write_record([
                &each.name,
                &each.group,
                &each.sticks.to_string(),
                finding.method.name,
                &say(finding.statistic),
                &say(finding.threshold),
                finding.decision.name(),
            ])?;
        }
        let verdict = &each.diagnosis.verdict;
        let votes = (verdict.votes.sticks, verdict.votes.sticks + verdict.votes.does_not_stick);
        writer.write_record([
            &each.name,
            &each.group,
            &each.sticks.to_string(),
            "verdict",
            &say((votes.1 > 0).then(|| votes.0 as f64 / votes.1 as f64)),
            "0.5",
            verdict.class.name(),
        ])?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}
