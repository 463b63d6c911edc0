//! What becomes of the intervals of S on loops unlike those of training.

use crate::dataset::{Dataset, Truth};
use crate::learn::{learn_s, ln_s};
use crate::measure::{estimation, is_quantified};
use anyhow::Result;
use std::fmt::Write;
use stiction_diagnose::fusion::{Estimate, Quantiles, row};

/// A way in which plants differ from the loops of training: which loops are taught, and which asked.
struct Mismatch {
    name: &'static str,
    taught: fn(&Truth) -> bool,
    asked: fn(&Truth) -> bool,
}

const ALL: [Mismatch; 4] = [
    Mismatch {
        name: "two-phase valves taught, He asked",
        taught: |truth| truth.model == "two-phase",
        asked: |truth| truth.model == "he",
    },
    Mismatch {
        name: "at most 2 steps a sample taught, 5 or more asked",
        taught: |truth| truth.steps <= 2,
        asked: |truth| truth.steps >= 5,
    },
    Mismatch {
        name: "first order taught, second order asked",
        taught: |truth| truth.process == "first order",
        asked: |truth| truth.process == "second order",
    },
    Mismatch {
        name: "self-regulating taught, integrating asked",
        taught: |truth| truth.process != "integrating",
        asked: |truth| truth.process == "integrating",
    },
];

/// For every mismatch, errors and coverage of S on fresh loops of both sorts, as a Markdown table.
pub fn table(
    train: &Dataset,
    trained: u64,
    test: &Dataset,
    report: impl Fn(&str),
) -> Result<String> {
    let mut out = String::from(
        "| mismatch | fresh loops | n | error, median | error, 90 % | coverage | quantified | error, \
         median | error, 90 % | coverage |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for Mismatch { name, taught, asked } in ALL {
        report(name);
        let quantiles = learn_s(train, trained, taught, &report)?;
        for (which, part) in [("as taught", taught), ("as asked", asked)] {
            let found = estimates(&quantiles, test, part);
            let all = estimation(&found, true);
            let narrow: Vec<_> = found.iter().copied().filter(|(s, _)| is_quantified(s)).collect();
            let gated = estimation(&narrow, true);
            writeln!(
                out,
                "| {name} | {which} | {} | {:.3} | {:.3} | {} | {:.3} | {:.3} | {:.3} | {} |",
                found.len(),
                all.error.0,
                all.error.1,
                all.coverage,
                narrow.len() as f64 / found.len() as f64,
                gated.error.0,
                gated.error.1,
                gated.coverage
            )?;
        }
    }
    Ok(out)
}

/// S of the loops of a part that have one, with its truth.
fn estimates(
    quantiles: &Quantiles,
    data: &Dataset,
    part: fn(&Truth) -> bool,
) -> Vec<(Estimate, f64)> {
    let rows =
        data.truth.iter().enumerate().filter(|(_, truth)| part(truth) && ln_s(truth).is_some());
    rows.map(|(k, truth)| {
        let percent = |ln_ratio: f64| truth.op_span * ln_ratio.exp();
        let found = quantiles.estimate(&row(&data.row(k)));
        let [value, low, high] = [found.value, found.low, found.high].map(percent);
        (Estimate { value, low, high }, truth.s)
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn intervals_cover_where_they_were_taught() {
        let (train, test) = (synthetic::dataset(3, 8000), synthetic::dataset(4, 4000));
        let two_phase: fn(&Truth) -> bool = |truth| truth.model == "two-phase";
        let quantiles = learn_s(&train, 6000, two_phase, |_| {}).unwrap();
        let found = estimation(&estimates(&quantiles, &test, two_phase), true);
        assert!((found.coverage.value() - 0.9).abs() < 0.04, "{}", found.coverage);
        assert!(found.error.0 < 0.25, "{found:?}");
    }
}
