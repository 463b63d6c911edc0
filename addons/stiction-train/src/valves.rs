//! The windows of simulated valves with records of 1 to [`LONGEST`] times the usual length, for the model of valves.
//!
//! Valves are kept in files of [`PART`], so that an interrupted run continues where it ended. Each file has a line with
//! the truth of each valve (CSV), and a row of numbers for each window (`f32`, little-endian): [`WINDOW`], then all
//! features.

use crate::random::Stream;
use anyhow::{Context, Result};
use rayon::prelude::*;
use std::path::Path;
use stiction_diagnose::diagnose::own_shares;
use stiction_diagnose::evidence::{self, Evidence, features};
use stiction_diagnose::fusion::{self, Cause, Confidence, Estimate, Pool, SUMMARY, Weighed, row};
use stiction_diagnose::recording::{Grid, GridOptions, Recording};
use stiction_population::{Invention, LoopKind};

/// The longest record, in usual lengths; lengths are log-uniform.
pub const LONGEST: f64 = 64.0;
/// Valves of a file.
const PART: u64 = 500;

/// The numbers of a window before its features.
pub const WINDOW: [&str; 15] = [
    "valve",
    "share",
    "op_span",
    "probability",
    "no_response",
    "s",
    "s_low",
    "s_high",
    "j",
    "j_low",
    "j_high",
    "limit",
    "distance",
    "mismatch",
    "op_range",
];

/// What is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The population.
    Population,
    /// The kinds that are never trained on.
    Invented,
}

impl Source {
    fn name(self) -> &'static str {
        match self {
            Self::Population => "valves",
            Self::Invented => "invented",
        }
    }
}

/// Simulates the first `n` valves of a seed into the folder; `progress` is called with the number of finished ones.
///
/// # Errors
/// If a valve cannot be simulated or a file not be written.
pub fn gather(
    folder: &Path,
    source: Source,
    seed: u64,
    n: u64,
    progress: impl Fn(u64),
) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let names: Vec<&str> = features().map(|feature| feature.name).collect();
    let head = [&WINDOW[..], &names].concat().join("\n");
    let write = |path: &Path, bytes: &[u8]| {
        std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
    };
    write(&folder.join("columns.txt"), head.as_bytes())?;
    for from in (0..n).step_by(PART as usize) {
        let to = (from + PART).min(n);
        let path = |end: &str| folder.join(format!("{}-{seed}-{from}-{to}.{end}", source.name()));
        if !path("csv").exists() {
            let all: Vec<_> = (from..to)
                .into_par_iter()
                .map(|index| match source {
                    Source::Population => member(seed, index),
                    Source::Invented => invented(seed, index),
                })
                .collect::<Result<_>>()?;
            let rows: Vec<u8> = all
                .iter()
                .flat_map(|(_, rows)| rows)
                .flat_map(|value| value.to_le_bytes())
                .collect();
            let lines: String = all.iter().map(|(line, _)| &line[..]).collect();
            write(&path("bin"), &rows)?;
            // Its name shows that both are whole.
            let head = "valve,kind,fault,visible,S,J,nats,families\n";
            write(&path("part"), [head, &lines].concat().as_bytes())?;
            std::fs::rename(path("part"), path("csv"))?;
        }
        progress(to);
    }
    Ok(())
}

/// A valve: its line, then the rows of its windows.
type Valve = (String, Vec<f32>);

/// The length of a record, in usual ones.
fn length(stream: &mut Stream) -> f64 {
    (stream.unit() * LONGEST.ln()).exp()
}

fn member(seed: u64, index: u64) -> Result<Valve> {
    let mut stream = Stream::new(seed, index);
    let kind = LoopKind::at(stream.unit());
    let factor = length(&mut stream);
    let simulated = kind.simulate_for(stream.next(), factor)?;
    let truth = &simulated.truth;
    // S and J of a valve in the loop below refer to a different OP from the recorded one.
    let own = if kind == LoopKind::StickyBelow { 0.0 } else { 1.0 };
    let line = format!(
        "{index},{},{},{},{},{},{},{}\n",
        kind.name(),
        u8::from(truth.sticks),
        u8::from(truth.visible),
        own * truth.s,
        own * truth.j,
        truth.gain,
        crate::members::families(truth).join(";")
    );
    Ok((line, windows(index, &simulated.recording)?))
}

fn invented(seed: u64, index: u64) -> Result<Valve> {
    let mut stream = Stream::new(seed, index);
    let kinds = || Invention::FIRST.into_iter().chain(Invention::SECOND);
    let kind = kinds().nth(index as usize % kinds().count()).context("there are no kinds")?;
    let factor = length(&mut stream);
    let sticks = stream.unit() < 0.5;
    let found = kind.simulate_for(stream.next(), sticks, factor)?;
    let line = format!(
        "{index},{},{},{},{},{},0,\n",
        kind.name(),
        u8::from(found.sticks),
        u8::from(found.visible),
        found.s,
        found.j
    );
    Ok((line, windows(index, &found.recording)?))
}

/// The rows of the windows of a recording; none without evidence. The model of valves itself is not asked.
fn windows(index: u64, recording: &Recording) -> Result<Vec<f32>> {
    let grid = Grid::of(recording, &GridOptions::default())?;
    let Some(segment) = grid.longest() else { return Ok(vec![]) };
    let windows = evidence::windows(segment);
    let weighed: Vec<((f64, f64), Evidence)> = windows
        .iter()
        .filter_map(|part| Some(((part.from, part.duration()), Evidence::of(part).ok()?)))
        .collect();
    let shares = own_shares(weighed.iter().map(|(span, _)| *span));
    let bundle = fusion::shipped()?;
    let mut rows = vec![];
    for ((_, evidence), share) in weighed.iter().zip(&shares) {
        let says = bundle.weigh(&evidence.values, evidence.op_span, false)?;
        let range = evidence.information.as_ref().map_or(f64::NAN, |of| of.op_range);
        let (s, j) = (says.s, says.j_over_s);
        let own = [
            index as f64,
            *share,
            evidence.op_span,
            says.probability,
            says.of(Cause::NoResponse),
            s.value,
            s.low,
            s.high,
            j.value,
            j.low,
            j.high,
            says.limit.unwrap_or(f64::NAN),
            says.distance,
            says.mismatch,
            range,
        ];
        rows.extend(row(&own));
        rows.extend(row(&evidence.values));
    }
    Ok(rows)
}

/// Pools the windows of all valves of a seed in the folder: one row of numbers (`f32`, little-endian) for each valve with
/// evidence, [`SUMMARY`] and the means of all features, and one line with its truth.
///
/// # Errors
/// If a file is missing, damaged, or cannot be written.
pub fn pool(folder: &Path, source: Source, seed: u64) -> Result<()> {
    let all: Vec<usize> = (0..features().count()).collect();
    let width = WINDOW.len() + all.len();
    let mut parts: Vec<(u64, String)> = vec![];
    for entry in std::fs::read_dir(folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        let words: Vec<&str> = name.split(['-', '.']).collect();
        if let [what, of, from, _, "csv"] = words[..]
            && what == source.name()
            && of == seed.to_string()
        {
            parts.push((from.parse()?, name.trim_end_matches(".csv").to_owned()));
        }
    }
    parts.sort();
    let (mut rows, mut lines) =
        (vec![], "valve,kind,fault,visible,S,J,nats,families,mean_ln_s,part\n".to_owned());
    for (_, part) in parts {
        let path = |end: &str| folder.join(format!("{part}.{end}"));
        let text = std::fs::read_to_string(path("csv"))?;
        let bytes = std::fs::read(path("bin"))?;
        let values: Vec<f32> =
            bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        let windows: Vec<&[f32]> = values.chunks_exact(width).collect();
        let mut truths = text.lines().skip(1);
        for valve in windows.chunk_by(|a, b| a[0] == b[0]) {
            let number = format!("{},", valve[0][0]);
            let truth = truths.find(|line| line.starts_with(&number));
            let truth = truth.with_context(|| format!("{part}.csv has no valve {number}"))?;
            let pools: Vec<Pool> = valve.iter().map(|window| pool_of(window, &all)).collect();
            for (part, pools) in parts_of(&pools) {
                let pool = Pool::merged(pools).context("a valve has no windows")?;
                rows.extend(pool.row().into_iter().flat_map(f32::to_le_bytes));
                lines += &format!("{truth},{},{part}\n", pool.mean_ln_s());
            }
        }
    }
    let write = |end: &str, bytes: &[u8]| -> Result<()> {
        let path = folder.join(format!("{}.{end}", source.name()));
        std::fs::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))
    };
    let names = SUMMARY.iter().map(|(name, sign)| format!("{name},{sign}\n"));
    let names = names.chain(features().map(|f| format!("{},{}\n", f.name, f.monotone)));
    write("columns.csv", names.collect::<String>().as_bytes())?;
    let Confidence { clearing, accusing } = fusion::shipped()?.full.confidence;
    write("confidence.csv", format!("{},{}", clearing.reached, accusing.reached).as_bytes())?;
    write("pools", &rows)?;
    write("pools.csv", lines.as_bytes())
}

/// All windows of a valve, then its first and last half, quarter and so on down to one window, with the name of each
/// part.
fn parts_of(pools: &[Pool]) -> Vec<(String, &[Pool])> {
    let n = pools.len();
    let mut parts = vec![("all".to_owned(), pools)];
    for k in (1..).take_while(|k| n >> k > 0) {
        parts.push((format!("first {}", 1 << k), &pools[..n >> k]));
        parts.push((format!("last {}", 1 << k), &pools[n - (n >> k)..]));
    }
    parts
}

fn pool_of(window: &[f32], features: &[usize]) -> Pool {
    let value = |k: usize| f64::from(window[k]);
    let estimate = |k: usize| Estimate { value: value(k), low: value(k + 1), high: value(k + 2) };
    let says = Weighed {
        probability: value(3),
        lines: vec![],
        causes: Cause::ALL.map(|cause| (cause, 0.0)),
        s: estimate(5),
        j_over_s: estimate(8),
        limit: Some(value(11)).filter(|limit| limit.is_finite()),
        distance: value(12),
        mismatch: value(13),
    };
    let values: Vec<f64> = window[WINDOW.len()..].iter().map(|v| f64::from(*v)).collect();
    Pool::of(&says, value(2), &values, value(1), features)
}
