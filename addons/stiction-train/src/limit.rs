//! Shift of the detection limit for each class of the probability: loops that are cleared if their limit permits, loops
//! up to twice as likely at fault, all other loops.
//!
//! The coverage has two conditions. Of all faulty valves of a class, and of those whose limit is small enough to
//! clear them, at most one in twenty sticks by more than its limit. The second is the harder one, because a wrong
//! limit is small.

use crate::calibrate;
use crate::dataset::Dataset;
use crate::learn::at_fault;
use anyhow::Result;
use rayon::prelude::*;
use stiction_diagnose::diagnose::LARGEST_LIMIT;
use stiction_diagnose::fusion::{Bundle, LIMIT, row};

/// A class with fewer faulty valves is merged with the next.
const FEWEST: usize = 200;
/// Steps in which a shift grows.
const STEP: f64 = 0.01;
const MOST: f64 = 4.0;

/// A faulty valve.
struct Case {
    probability: f64,
    /// `ln(S / OP span)` above the quantile from the trees.
    excess: f64,
    /// Largest shift of the quantile at which the limit still clears the valve.
    room: f64,
}

/// Shifts the limit of the model of OP and PV, where valves are cleared up to that probability.
///
/// # Errors
/// If evidence cannot be weighed.
pub fn calibrate(bundle: &mut Bundle, data: &Dataset, rows: &[u32], clear: f64) -> Result<()> {
    let Some(limit) = &bundle.full.limit else { return Ok(()) };
    let range = data.columns.iter().position(|column| column.name == "info_range");
    let of = |k: &u32| -> Option<Result<Case>> {
        let (k, truth) = (*k as usize, &data.truth[*k as usize]);
        let z = at_fault(truth)?;
        let values = data.row(k);
        let quantile = limit.trees.margin(&row(&values));
        // In spans of the OP, as the quantile.
        let range = range.map_or(f64::NAN, |c| values[c]);
        let room =
            if range.is_nan() { f64::NEG_INFINITY } else { LARGEST_LIMIT.ln() + range - quantile };
        let says = bundle.weigh(&values, truth.op_span, false).map_err(anyhow::Error::from);
        Some(says.map(|says| Case { probability: says.probability, excess: z - quantile, room }))
    };
    let cases: Vec<Case> = rows.par_iter().filter_map(of).collect::<Result<_>>()?;
    let mut shifts: Vec<(f64, f64)> = vec![];
    let mut class: Vec<&Case> = vec![];
    let mut from = f64::NEG_INFINITY;
    let classes = [clear, (2.0 * clear).min(0.5), 1.0];
    for up_to in classes {
        class.extend(
            cases.iter().filter(|case| case.probability > from && case.probability <= up_to),
        );
        from = up_to;
        if class.len() >= FEWEST || up_to == 1.0 {
            shifts.push((up_to, shift(&class)));
            class.clear();
        }
    }
    if let Some(limit) = &mut bundle.full.limit {
        limit.shifts = shifts;
    }
    Ok(())
}

/// The smallest shift that satisfies both conditions in a class.
fn shift(class: &[&Case]) -> f64 {
    let of_all = calibrate::upper(class.iter().map(|case| case.excess).collect(), LIMIT);
    let mut shift = of_all;
    while shift < MOST {
        let cleared: Vec<&&Case> = class.iter().filter(|case| case.room >= shift).collect();
        let broken = cleared.iter().filter(|case| case.excess > shift).count();
        // One more, as for the quantile of a sample.
        if (broken + 1) as f64 <= (1.0 - LIMIT) * (cleared.len() + 1) as f64 || cleared.is_empty() {
            break;
        }
        shift += STEP;
    }
    shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_promises_are_kept() {
        // Every tenth is 2 beyond its quantile, and only these have little room.
        let of = |room: f64| -> Vec<Case> {
            let excess = |k: i32| if k % 10 == 0 { 2.0 } else { f64::from(k % 10) / 10.0 };
            (0..2000).map(|k| Case { probability: 0.1, excess: excess(k), room }).collect()
        };
        let wide = of(5.0);
        assert!((shift(&wide.iter().collect::<Vec<_>>()) - 2.0).abs() < 1e-9);
        // Of those that are cleared, one in ten sticks by more; of all, one in a hundred.
        let mixed: Vec<Case> = (0..1000)
            .map(|k| Case {
                probability: 0.1,
                excess: if k % 100 == 0 { 1.0 } else { -1.0 },
                room: if k < 100 || k % 100 == 0 { 3.0 } else { -2.0 },
            })
            .collect();
        let all: Vec<&Case> = mixed.iter().collect();
        let found = shift(&all);
        assert!((1.0 - STEP..1.1).contains(&found), "{found}");
    }
}
