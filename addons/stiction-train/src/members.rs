//! Members of the simulated population, and the evidence in their recordings.

use crate::dataset::{Column, Dataset, Truth};
use crate::signals_file::SignalsFile;
use rayon::prelude::*;
use std::collections::BTreeMap;
use stiction_diagnose::evidence::raw::Input;
use stiction_diagnose::evidence::{self, Evidence, Prepared};
use stiction_diagnose::fusion::{Cause, row};
use stiction_diagnose::recording::{Grid, GridOptions, Recording};
use stiction_population::{self, LoopKind, Simulated};

/// Evidence of recordings, with all their signals and with their OP alone.
#[derive(Debug, Clone)]
pub struct Both {
    /// All signals of the population.
    pub full: Dataset,
    /// The OP, and neither PV nor SP.
    pub alone: Dataset,
    /// Recordings with a mistake in their columns, with all their signals; empty if not requested.
    pub mistaken: Dataset,
}

/// Members between two reports of progress.
const BATCH: u64 = 512;

/// The truth of a member, and its evidence if there is any.
type Row = (Truth, Option<Vec<f32>>);

/// A member: all its signals, its OP alone, and the input of the net.
type Member = ([Row; 2], Option<Input>);

/// The columns of the evidence as this build computes it.
pub fn columns() -> Vec<Column> {
    let mut columns: Vec<Column> = evidence::features()
        .map(|feature| Column {
            name: feature.name.to_owned(),
            monotone: feature.monotone,
            line: feature.line,
            op_only: false,
        })
        .collect();
    evidence::op_only().for_each(|k| columns[k].op_only = true);
    columns
}

/// Simulates members of the population of a seed. Gathers their evidence, and the input of the net if a file for it is
/// given. `progress` is called with the number of finished members.
///
/// # Errors
/// If a member cannot be simulated or brought onto a grid, or the file cannot be written.
pub fn simulate(
    seed: u64,
    members: u64,
    mut signals: Option<&mut SignalsFile>,
    progress: impl Fn(u64),
) -> anyhow::Result<Both> {
    let (mut full, mut alone) = (Gathered::default(), Gathered::default());
    for from in (0..members).step_by(BATCH as usize) {
        let batch = from..(from + BATCH).min(members);
        let batch: Vec<_> = batch.into_par_iter().map(|index| member(seed, index)).collect();
        for each in batch {
            let ([of_all, of_op], heard) = each?;
            if let Some(file) = signals.as_deref_mut().filter(|_| of_all.1.is_some()) {
                file.add(of_all.0.index, heard.as_ref())?;
            }
            full.add(of_all);
            alone.add(of_op);
        }
        progress((from + BATCH).min(members));
    }
    let (full, alone) = (full.into_dataset(), alone.into_dataset());
    Ok(Both { full, alone, mistaken: Dataset::default() })
}

/// Makes mistaken recordings of a seed and gathers their evidence. The kind of each recording is its mistake.
///
/// # Errors
/// As [`simulate`].
pub fn mistaken(seed: u64, recordings: u64, progress: impl Fn(u64)) -> anyhow::Result<Dataset> {
    let mut gathered = Gathered::default();
    for from in (0..recordings).step_by(BATCH as usize) {
        let batch = from..(from + BATCH).min(recordings);
        let rows: Vec<_> = batch.into_par_iter().map(|index| mistake(seed, index)).collect();
        for row in rows {
            gathered.add(row?);
        }
        progress((from + BATCH).min(recordings));
    }
    Ok(gathered.into_dataset())
}

/// Collected rows.
#[derive(Default)]
struct Gathered {
    rows: Vec<(Truth, Vec<f32>)>,
    abstained: BTreeMap<String, u64>,
}

impl Gathered {
    fn add(&mut self, (truth, values): Row) {
        match values {
            Some(values) => self.rows.push((truth, values)),
            None => *self.abstained.entry(truth.kind).or_insert(0) += 1,
        }
    }

    fn into_dataset(self) -> Dataset {
        Dataset { abstained: self.abstained, ..Dataset::new(columns(), self.rows) }
    }
}

/// A mistake, and the evidence of the recording. Of its truth, only number and mistake are meaningful.
fn mistake(seed: u64, index: u64) -> stiction_model::Result<Row> {
    let (mistake, recording) = stiction_population::mistaken(seed, index)?;
    let evidence = evidence(&recording)?.map(|(evidence, _)| evidence);
    let truth = Truth {
        index,
        kind: mistake.name().to_owned(),
        cause: Cause::NormalOperation,
        visible: false,
        slips: 0,
        nats: 0.0,
        swing: 0.0,
        s: 0.0,
        j: 0.0,
        model: String::new(),
        process: String::new(),
        steps: 1,
        op_span: evidence.as_ref().map_or(f64::NAN, |evidence| evidence.op_span),
        families: vec![],
    };
    Ok((truth, evidence.map(|evidence| row(&evidence.values))))
}

/// The evidence in a recording, if there is any, and the input of the net.
fn evidence(recording: &Recording) -> stiction_model::Result<Option<(Evidence, Option<Input>)>> {
    let grid = Grid::of(recording, &GridOptions::default())?;
    // As in a diagnosis, a long recording is divided into windows; one of them is enough for learning.
    Ok(grid.longest().and_then(|segment| {
        let windows = evidence::windows(segment);
        let prepared = Prepared::of(&windows[windows.len() / 2]).ok()?;
        let evidence = Evidence::of_prepared(&prepared);
        let told = evidence.information.as_ref();
        let heard = told.and_then(|told| Input::of(&prepared, &told.added_stem));
        Some((evidence, heard))
    }))
}

/// A member, and the evidence of all its signals and of its OP alone.
fn member(seed: u64, index: u64) -> stiction_model::Result<Member> {
    let Simulated { recording, truth } = stiction_population::member(seed, index)?;
    let alone = Recording { pv: None, sp: None, ..recording.clone() };
    let row_of = |recording: &Recording| -> stiction_model::Result<(Row, Option<Input>)> {
        let (evidence, heard) = evidence(recording)?.unzip();
        let families = families(&truth);
        let truth = Truth {
            index,
            kind: truth.kind.name().to_owned(),
            cause: cause_of(&truth),
            visible: truth.visible,
            slips: truth.slips as u64,
            nats: truth.gain,
            swing: truth.swing,
            // S and J of a valve in the loop below refer to a different OP from the recorded one.
            s: if truth.kind == LoopKind::StickyBelow { 0.0 } else { truth.s },
            j: if truth.kind == LoopKind::StickyBelow { 0.0 } else { truth.j },
            model: truth.model.map_or_else(String::new, |model| model.describe().name.to_owned()),
            process: truth.facts.process.name().to_owned(),
            steps: truth.facts.steps_per_sample as u64,
            op_span: evidence.as_ref().map_or(f64::NAN, |evidence| evidence.op_span),
            families,
        };
        Ok(((truth, evidence.map(|evidence| row(&evidence.values))), heard.flatten()))
    };
    let ((full, heard), (alone, _)) = (row_of(&recording)?, row_of(&alone)?);
    Ok(([full, alone], heard))
}

/// The families of a loop. Leaving them out in turn imitates conditions of a plant that the population lacks.
pub fn families(truth: &stiction_population::Truth) -> Vec<String> {
    let facts = &truth.facts;
    let own = truth.families();
    let mut names: Vec<(&str, &str)> = own.iter().map(|f| (f.axis(), f.name())).collect();
    names.push(("kind", truth.kind.name()));
    names.push(("margin", if facts.gain_margin < 2.2 { "below 2.2" } else { "2.2 or more" }));
    names.push(match facts.steps_per_sample {
        1 => ("sampling", "every step"),
        2..=9 => ("sampling", "2 to 9 steps"),
        10..=19 => ("sampling", "10 to 19 steps"),
        _ => ("sampling", "20 steps or more"),
    });
    names.into_iter().map(|(axis, name)| format!("{axis}: {name}")).collect()
}

/// The cause of a loop's behaviour. A valve that sticks so much that it never moves does not respond.
fn cause_of(truth: &stiction_population::Truth) -> Cause {
    match truth.kind {
        LoopKind::Sticky if !truth.moves => Cause::NoResponse,
        LoopKind::Sticky | LoopKind::StickyBelow => Cause::StickingValve,
        LoopKind::Stuck => Cause::NoResponse,
        LoopKind::Sine | LoopKind::Irregular => Cause::ExternalOscillation,
        LoopKind::AggressiveTuning => Cause::AggressiveTuning,
        LoopKind::QuantisedPv => Cause::Quantisation,
        LoopKind::Saturation => Cause::Saturation,
        LoopKind::DeadZoneElsewhere => Cause::DeadZoneElsewhere,
        LoopKind::SetPoint => Cause::SetPointChanges,
        LoopKind::ProcessNonlinearity => Cause::ProcessNonlinearity,
        LoopKind::ExternalWave | LoopKind::StickingNeighbour | LoopKind::SwitchedNeighbour => {
            Cause::ExternalWave
        }
        LoopKind::RampAndReset => Cause::ResettingLoad,
        _ => Cause::NormalOperation,
    }
}
