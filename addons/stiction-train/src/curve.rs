//! The benefit of more loops for learning, and the limit of an observer who knows the stem: possible improvements
//! of the verdict.

use crate::bins::Bins;
use crate::boost::{BoostOptions, Loss, Task, boost};
use crate::dataset::{Column, Dataset, Truth};
use crate::grow::Limits;
use crate::learn::{fault, open};
use crate::measure::{Share, auc};
use anyhow::Result;
use std::fmt::Write;
use stiction_diagnose::evidence::Line;
use stiction_diagnose::fusion::{Ensemble, SURE, logit, row, softplus};

/// One recipe for all sizes: the recipe of the left-out families, with more rounds.
const RECIPE: BoostOptions = BoostOptions {
    rounds: 800,
    rate: 0.08,
    limits: Limits { leaves: 31, least_weight: 6.0, l2: 2.0 },
    rows: 0.7,
    columns: 0.4,
    patience: 25,
    seed: 1,
};

/// Number of loops for learning.
const SIZES: [usize; 5] = [10_000, 40_000, 110_000, 300_000, 500_000];
/// Lower ends of the bands of gain for an observer who knows the stem, nats.
const BANDS: [f64; 7] = [0.0, 15.6, 25.0, 50.0, 100.0, 200.0, 400.0];

/// Accuracy of trees on unseen loops.
pub struct Worth {
    pub loops: usize,
    pub auc: f64,
    pub log_loss: f64,
    /// Loops with a probability below 0.02 or above 0.98, and the wrong ones among them.
    pub sure: Share,
}

/// The learning curve, the limit, and the share of an observer's nats that the search of stems reaches, as
/// Markdown.
///
/// # Errors
/// If there is too little data.
pub fn table(train: &Dataset, test: &Dataset, report: impl Fn(&str)) -> Result<String> {
    let mut out = String::from("| loops for learning | AUC | log loss |\n|---|---|---|\n");
    let columns: Vec<usize> = (0..train.columns.len()).collect();
    let taught = train.truth.iter().filter(|truth| fault(truth).is_some()).count();
    let largest = SIZES.into_iter().filter(|size| *size < taught).chain([taught]);
    for size in largest {
        report(&format!("{size} loops"));
        let Worth { auc, log_loss, .. } = learned(train, test, &open(train, &columns), size)?;
        let _ = writeln!(out, "| {size} | {auc:.4} | {log_loss:.4} |");
    }
    let (knowing, of_test) = (with_truth(train), with_truth(test));
    let all: Vec<usize> = (0..knowing.columns.len()).collect();
    let Worth { auc, log_loss, .. } = learned(&knowing, &of_test, &open(&knowing, &all), taught)?;
    let _ = writeln!(
        out,
        "| {taught}, with the gain of an observer who knows the stem as a feature: upper bound | {auc:.4} | {log_loss:.4} |"
    );
    out += &reached(test);
    Ok(out)
}

fn learned(train: &Dataset, test: &Dataset, columns: &[usize], size: usize) -> Result<Worth> {
    let known: Vec<u32> = (0..train.truth.len() as u32)
        .filter(|k| fault(&train.truth[*k as usize]).is_some())
        .take(size)
        .collect();
    let trees = grown(train, &known, columns)?;
    Ok(worth(&trees, test, |_| true))
}

/// Trees for a fault, grown on some loops and columns.
pub fn grown(train: &Dataset, known: &[u32], columns: &[usize]) -> Result<Ensemble> {
    let target: Vec<f64> =
        train.truth.iter().map(|truth| f64::from(fault(truth) == Some(true))).collect();
    let weight = vec![1.0; target.len()];
    let (stop, kept): (Vec<u32>, Vec<u32>) = known.iter().partition(|k| *k % 8 == 0);
    let bins = Bins::new(&train.values, &kept);
    let task = Task {
        loss: Loss::Logistic,
        target: &target,
        weight: &weight,
        train: &kept,
        stop: &stop,
        columns,
        monotone: &train.monotone(),
    };
    Ok(boost(&bins, &task, &RECIPE)?.ensembles.swap_remove(0))
}

/// Accuracy of trees on loops that are healthy, or visibly faulty.
pub fn worth(trees: &Ensemble, test: &Dataset, asked: impl Fn(&Truth) -> bool) -> Worth {
    let scored: Vec<(f64, bool)> = (0..test.truth.len())
        .filter(|k| asked(&test.truth[*k]))
        .filter_map(|k| Some((trees.margin(&row(&test.row(k))), fault(&test.truth[k])?)))
        .collect();
    let loss = |(margin, hit): &(f64, bool)| softplus(if *hit { -margin } else { *margin });
    let log_loss = scored.iter().map(loss).sum::<f64>() / scored.len().max(1) as f64;
    let sure = logit(SURE);
    let decided = scored.iter().filter(|(margin, _)| margin.abs() >= sure);
    let wrong = decided.clone().filter(|(margin, hit)| (*margin > 0.0) != *hit).count();
    Worth {
        loops: scored.len(),
        auc: auc(&scored),
        log_loss,
        sure: Share { k: wrong, n: decided.count() },
    }
}

/// The loops with the gain of an observer who knows the stem; empty for valves that do not stick.
fn with_truth(data: &Dataset) -> Dataset {
    let mut knowing = data.clone();
    knowing.columns.push(Column {
        name: "nats_of_the_true_stem".into(),
        monotone: 1,
        line: Line::Model,
        op_only: false,
    });
    knowing.values.push(data.truth.iter().map(|truth| truth.nats as f32).collect());
    knowing
}

/// Gain of the best stem in the search against the gain of the true one.
fn reached(data: &Dataset) -> String {
    let Some(place) = data.columns.iter().position(|column| column.name == "stem_gain") else {
        return String::new();
    };
    let nats = |k: usize| f64::from(data.values[place][k]).exp_m1();
    let quantile = |mut values: Vec<f64>, share: f64| {
        values.retain(|v| v.is_finite());
        values.sort_by(f64::total_cmp);
        values.get(((values.len() as f64) * share) as usize).copied().unwrap_or(f64::NAN)
    };
    let of = |wanted: &dyn Fn(&Truth) -> bool| -> Vec<f64> {
        (0..data.truth.len()).filter(|k| wanted(&data.truth[*k])).map(nats).collect()
    };
    let healthy = of(&|truth| !truth.cause.is_fault());
    let mut out = format!(
        "\nNats of the best stem in the search, beside the OP. For healthy loops, median {:.0}, 95 % quantile {:.0}.\n\n\
         | an observer who knows the stem gains | sticky loops | search, median | recorded every step | \
         2 to 9 steps a sample | 10 or more |\n|---|---|---|---|---|---|\n",
        quantile(healthy.clone(), 0.5),
        quantile(healthy, 0.95)
    );
    for (k, from) in BANDS.iter().enumerate() {
        let to = BANDS.get(k + 1).copied().unwrap_or(f64::INFINITY);
        let within =
            |truth: &Truth| truth.kind == "sticky valve" && (*from..to).contains(&truth.nats);
        let cell = |steps: std::ops::RangeInclusive<u64>| {
            let found = of(&|truth| within(truth) && steps.contains(&truth.steps));
            format!("{:.0} of {}", quantile(found.clone(), 0.5), found.len())
        };
        let all = of(&within);
        let _ = writeln!(
            out,
            "| from {from} | {} | {:.0} | {} | {} | {} |",
            all.len(),
            quantile(all.clone(), 0.5),
            cell(1..=1),
            cell(2..=9),
            cell(10..=u64::MAX)
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn more_loops_bring_more_and_the_truth_most() {
        let (train, test) = (synthetic::dataset(1, 6000), synthetic::dataset(2, 2000));
        let columns: Vec<usize> = (0..train.columns.len()).collect();
        let few = learned(&train, &test, &columns, 300).unwrap();
        let many = learned(&train, &test, &columns, 6000).unwrap();
        assert!(many.auc > few.auc && many.log_loss < few.log_loss);
        assert_eq!(with_truth(&test).columns.len(), columns.len() + 1);
        assert!(table(&train, &test, |_| {}).unwrap().contains("upper bound"));
    }
}
