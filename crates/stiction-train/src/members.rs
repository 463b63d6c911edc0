//! Members of the simulated population, and the evidence in their recordings.

use crate::dataset::{Column, Dataset, Truth};
use rayon::prelude::*;
use std::collections::BTreeMap;
use stiction::evidence::{self, Evidence};
use stiction::fusion::{Cause, row};
use stiction::population::{self, Kind, Simulated};
use stiction::recording::{Grid, GridOptions};

/// Which signals of a recording there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signals {
    /// All that the population gives it.
    All,
    /// The OP, and neither PV nor SP.
    OpAlone,
}

/// The columns of today's evidence.
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

/// Simulates members of the population of a seed and gathers their evidence; `progress` is told how
/// many are done.
///
/// # Errors
/// If a member cannot be simulated or brought onto a grid.
pub fn simulate(
    seed: u64,
    members: u64,
    signals: Signals,
    progress: impl Fn(u64),
) -> anyhow::Result<Dataset> {
    /// Members between two reports of progress.
    const BATCH: u64 = 512;
    let mut rows = Vec::new();
    let mut abstained = BTreeMap::new();
    for from in (0..members).step_by(BATCH as usize) {
        let batch = from..(from + BATCH).min(members);
        let batch: Vec<_> =
            batch.into_par_iter().map(|index| member(seed, index, signals)).collect();
        for each in batch {
            match each? {
                (truth, Some(values)) => rows.push((truth, values)),
                (truth, None) => *abstained.entry(truth.kind).or_insert(0) += 1,
            }
        }
        progress((from + BATCH).min(members));
    }
    Ok(Dataset { abstained, ..Dataset::new(columns(), rows) })
}

/// The truth of a member, and its evidence if there is any.
fn member(seed: u64, index: u64, signals: Signals) -> stiction::Result<(Truth, Option<Vec<f32>>)> {
    let Simulated { mut recording, truth } = population::member(seed, index)?;
    if signals == Signals::OpAlone {
        (recording.pv, recording.sp) = (None, None);
    }
    let grid = Grid::of(&recording, &GridOptions::default())?;
    let evidence = grid.longest().and_then(|stretch| Evidence::of(stretch).ok());
    let truth = Truth {
        index,
        kind: truth.kind.name().to_owned(),
        cause: cause_of(truth.kind),
        visible: truth.visible,
        slips: truth.slips as u64,
        s: truth.s,
        j: truth.j,
        model: truth.model.map_or_else(String::new, |model| model.describe().name.to_owned()),
        process: truth.facts.process.name().to_owned(),
        steps: truth.facts.steps_per_sample as u64,
        op_span: evidence.as_ref().map_or(f64::NAN, |evidence| evidence.op_span),
    };
    Ok((truth, evidence.map(|evidence| row(&evidence.values))))
}

/// What is the matter with a loop of a kind.
fn cause_of(kind: Kind) -> Cause {
    match kind {
        Kind::Sticky => Cause::StickingValve,
        Kind::Stuck => Cause::NoResponse,
        Kind::Sine | Kind::Irregular => Cause::ExternalOscillation,
        Kind::AggressiveTuning => Cause::AggressiveTuning,
        Kind::QuantisedPv => Cause::Quantisation,
        Kind::Saturation => Cause::Saturation,
        Kind::DeadZoneElsewhere => Cause::DeadZoneElsewhere,
        Kind::SetPoint => Cause::SetPointChanges,
        Kind::ProcessNonlinearity => Cause::ProcessNonlinearity,
        Kind::ExternalWave => Cause::ExternalWave,
        _ => Cause::NormalOperation,
    }
}
