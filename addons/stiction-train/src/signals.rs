//! Benefit of the nets beside the evidence: on fresh loops, and on families unseen by nets and trees.

use crate::curve::{Worth, grown, worth};
use crate::dataset::{Dataset, Truth};
use crate::hear::FOLDS;
use crate::learn::{fault, open};
use anyhow::Result;
use std::fmt::Write;
use stiction_diagnose::evidence::Line;

/// Trees with and without the output of the nets, as Markdown. The trees are grown on the loops that one net has not
/// seen, except the families `without`. They are tested on fresh loops and on these families.
///
/// # Errors
/// If there is too little data.
pub fn table(train: &Dataset, test: &Dataset, trained: u64, without: &[String]) -> Result<String> {
    let left_out = |truth: &Truth| truth.families.iter().any(|name| without.contains(name));
    let known: Vec<u32> = (0..train.truth.len() as u32)
        .filter(|k| {
            let truth = &train.truth[*k as usize];
            let heard = truth.index < trained && !truth.index.is_multiple_of(FOLDS);
            heard && fault(truth).is_some() && !left_out(truth)
        })
        .collect();
    let all: Vec<usize> = (0..train.columns.len()).collect();
    let with = open(train, &all);
    let deaf: Vec<usize> =
        with.iter().copied().filter(|k| train.columns[*k].line != Line::Signals).collect();
    let [with, deaf] = [&with, &deaf].map(|columns| grown(train, &known, columns));
    let (with, deaf) = (with?, deaf?);
    let mut out = format!(
        "Trees trained on {} loops. A probability is sure below 0.02 or above 0.98.\n\n\
         | tested on | loops | AUC | with the net | log loss | with the net | sure, wrong | with the net |\n\
         |---|---|---|---|---|---|---|---|\n",
        known.len()
    );
    let mut row = |name: &str, asked: &dyn Fn(&Truth) -> bool| {
        let [a, b] = [&deaf, &with].map(|trees| worth(trees, test, asked));
        let sure = |of: &Worth| format!("{} of {}", of.sure.k, of.sure.n);
        let _ = writeln!(
            out,
            "| {name} | {} | {:.4} | {:.4} | {:.4} | {:.4} | {} | {} |",
            a.loops,
            a.auc,
            b.auc,
            a.log_loss,
            b.log_loss,
            sure(&a),
            sure(&b)
        );
    };
    row("fresh loops of families in the training", &|truth| !left_out(truth));
    row("families left out, all", &left_out);
    for name in without {
        row(name, &|truth| truth.families.contains(name));
    }
    Ok(out)
}
