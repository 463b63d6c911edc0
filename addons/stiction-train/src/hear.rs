//! Output of the nets for loops that they have not seen in training.
//!
//! Each net was trained on every [`FOLDS`]th of the loops for growing trees. For each of these loops, the trees get the
//! output of the nets that have not seen it. Without such a net the output is empty. For all other loops they get the
//! mean, as in a diagnosis.

use crate::dataset::Dataset;
use crate::signals_file;
use anyhow::{Context, Result, ensure};
use rayon::prelude::*;
use std::path::Path;
use stiction_diagnose::evidence::raw::{FEATURES, Net, OUTPUTS, values};

/// Number of nets. The loops for growing trees are divided into as many parts.
pub const FOLDS: u64 = 2;

/// Records that are processed at once.
const AT_ONCE: usize = 2048;

/// Fills the columns of the nets from the signals of the same loops. Loops with a number below `trained` belong to the
/// population on which the nets were trained.
///
/// # Errors
/// If there are more nets than parts, or the signals are of other loops.
pub fn hear(data: &mut Dataset, signals: &Path, net: &Net, trained: u64) -> Result<()> {
    let members: Vec<Net> = net.members().collect();
    ensure!(members.len() as u64 <= FOLDS, "{} nets, but {FOLDS} parts", members.len());
    let first = data.columns.iter().position(|column| column.name == FEATURES[0].name);
    let first = first.context("the matrix has no columns of the nets")?;
    let mut row = 0;
    signals_file::read(signals, AT_ONCE, |records| {
        let said: Vec<[f64; FEATURES.len()]> = records
            .par_iter()
            .map(|(index, heard)| {
                let Some(heard) = heard else { return [f64::NAN; FEATURES.len()] };
                let mut sum = [0.0; OUTPUTS];
                let mut count = 0.0;
                for (fold, member) in members.iter().enumerate() {
                    if *index >= trained || index % FOLDS != fold as u64 {
                        let said = member.outputs(heard);
                        sum.iter_mut().zip(said).for_each(|(sum, said)| *sum += said);
                        count += 1.0;
                    }
                }
                match count > 0.0 {
                    true => values(&sum.map(|value| value / count)),
                    false => [f64::NAN; FEATURES.len()],
                }
            })
            .collect();
        for ((index, _), said) in records.iter().zip(said) {
            let known = data.truth.get(row).map(|truth| truth.index);
            ensure!(known == Some(*index), "{} is of other loops", signals.display());
            for (k, value) in said.into_iter().enumerate() {
                data.values[first + k][row] = value as f32;
            }
            row += 1;
        }
        Ok(())
    })?;
    ensure!(row == data.truth.len(), "{} is of other loops", signals.display());
    Ok(())
}
