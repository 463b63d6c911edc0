//! OP, PV and the residuals of the regressions, sample by sample: the input of a net on raw signals.

use super::{AddedStem, Candidate, LONGEST, Problem, block_means};
use crate::series::{quantile, std};

/// Signals at one rate, all of one length.
#[derive(Debug, Clone, PartialEq)]
pub struct Traces {
    /// Means of the OP over blocks, percent.
    pub op: Vec<f64>,
    /// The PV at the end of each block.
    pub pv: Vec<f64>,
    /// The residual of the PV with a valve that follows the OP, in standard deviations of the PV; 0 where the past is
    /// not known.
    pub follows: Vec<f64>,
    /// This residual with the likeliest stem in addition to the OP.
    pub sticks: Vec<f64>,
    /// OP less that stem, in units of its S.
    pub behind: Vec<f64>,
}

/// The traces at `factor` recorded samples per value; `None` if too little can be predicted.
pub fn traces(op: &[f64], pv: &[f64], factor: usize, beside: &AddedStem) -> Option<Traces> {
    let op_range = quantile(op, 0.995) - quantile(op, 0.005);
    if !(op_range > 0.0 && op_range.recip().is_finite() && std(pv) > 0.0) {
        return None;
    }
    let problem = Problem::of(op, pv, op_range, factor)?;
    let (model, s, j, _) = beside.best;
    let stem = problem.stems(&[Candidate { s, j, model, place: beside.place }]).pop()?;
    let sticks = match problem.added(&stem) {
        Some(added) => problem.errors_with(&stem, &added),
        None => problem.error.clone(),
    };
    let instants = problem.instants;
    let from_start = |error: &[f64]| {
        let mut whole = vec![0.0; LONGEST];
        whole.extend(error);
        whole
    };
    let means = block_means(&problem.op, factor, instants);
    let behind = means.iter().zip(&stem.path).map(|(u, x)| (u - x) / s).collect();
    Some(Traces {
        op: block_means(op, factor, instants),
        pv: (0..instants).map(|k| pv[(k + 1) * factor]).collect(),
        follows: from_start(&problem.error),
        sticks: from_start(&sticks),
        behind,
    })
}
