//! The classifier of recordings with a mistake in their columns.

use crate::bins::Bins;
use crate::boost::{BoostOptions, Boosted, Loss, Task, boost};
use crate::calibrate::upper;
use crate::dataset::{Dataset, Truth};
use crate::measure::Share;
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::fmt::Write;
use stiction_diagnose::fusion::{Ensemble, Mismatch, Weighed, row};

/// Loops without a mistake for each one with a mistake, apart from stuck valves. All stuck valves are used, because
/// a PV that does not respond looks most like a mistake.
const TRUE_LOOPS: usize = 2;

/// One of this many loops for learning is used for stopping.
const STOP_SHARE: u64 = 8;

/// The shares of true loops below the threshold: of all, of the decided ones, of visibly stuck valves, and of every
/// kind with at least this many of them.
const KEPT: f64 = 0.993;
const KEPT_OF_KIND: f64 = 0.98;
const FEWEST_OF_KIND: usize = 100;

/// A decided loop.
fn is_decided(probability: f64) -> bool {
    !(probability > 0.2 && probability < 0.9)
}

fn is_stuck(truth: &Truth) -> bool {
    truth.kind == stiction_population::LoopKind::Stuck.name()
}

/// The input of learning.
pub struct Lesson<'a> {
    pub data: &'a Dataset,
    pub mistaken: &'a Dataset,
    /// Rows of the data for learning, and for the threshold.
    pub trained: &'a [u32],
    pub calibrated: &'a [u32],
    pub columns: &'a [usize],
    pub options: &'a BoostOptions,
    /// The probability of a fault of a row, to find the decided ones.
    pub probability: &'a dyn Fn(u32) -> f64,
}

/// Trains the model. Also returns its rounds and its loss.
///
/// # Errors
/// If there is no data.
pub fn mismatch(lesson: &Lesson<'_>) -> Result<(Mismatch, usize, f64)> {
    let Boosted { ensembles, rounds, loss, .. } = learned(lesson)?;
    let trees = Ensemble::mean(&ensembles[..1]).rounded();
    let threshold = threshold(lesson, &trees);
    Ok((Mismatch { trees, threshold }, rounds, loss))
}

fn learned(lesson: &Lesson<'_>) -> Result<Boosted> {
    let Lesson { data, mistaken, .. } = lesson;
    let others = lesson.trained.iter().filter(|k| !is_stuck(&data.truth[**k as usize])).count();
    let every = (others / (TRUE_LOOPS * mistaken.truth.len()).max(1)).max(1);
    let mut passed = 0;
    let chosen: Vec<u32> = lesson
        .trained
        .iter()
        .filter(|k| {
            let stuck = is_stuck(&data.truth[**k as usize]);
            passed += usize::from(!stuck);
            stuck || passed % every == 0
        })
        .copied()
        .collect();
    let values: Vec<Vec<f32>> = data
        .values
        .iter()
        .zip(&mistaken.values)
        .map(|(own, of)| {
            chosen.iter().map(|k| own[*k as usize]).chain(of.iter().copied()).collect()
        })
        .collect();
    let numbers = chosen.iter().map(|k| data.truth[*k as usize].index / every as u64);
    let numbers = numbers.chain(mistaken.truth.iter().map(|truth| truth.index));
    let (stop, train): (Vec<(u32, u64)>, _) =
        (0..).zip(numbers).partition(|(_, number)| number % STOP_SHARE == 0);
    let rows = |part: Vec<(u32, u64)>| -> Vec<u32> { part.into_iter().map(|(k, _)| k).collect() };
    let (train, stop) = (rows(train), rows(stop));
    let n = chosen.len() + mistaken.truth.len();
    let target: Vec<f64> = (0..n).map(|k| f64::from(k >= chosen.len())).collect();
    let task = Task {
        loss: Loss::Logistic,
        target: &target,
        weight: &vec![1.0; n],
        train: &train,
        stop: &stop,
        columns: lesson.columns,
        monotone: &vec![0; values.len()],
    };
    boost(&Bins::new(&values, &train), &task, lesson.options)
        .context("cannot learn mistaken columns")
}

/// The smallest margin that few enough unseen true loops exceed, of all and of every kind.
fn threshold(lesson: &Lesson<'_>, trees: &Ensemble) -> f64 {
    let mut sorts: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    let (mut all, mut decided, mut stuck) = (vec![], vec![], vec![]);
    for k in lesson.calibrated {
        let truth = &lesson.data.truth[*k as usize];
        let margin = trees.margin(&row(&lesson.data.row(*k as usize)));
        all.push(margin);
        if is_decided((lesson.probability)(*k)) {
            decided.push(margin);
        }
        if is_stuck(truth) && truth.visible {
            stuck.push(margin);
        }
        sorts.entry(&truth.kind).or_default().push(margin);
    }
    let kinds = sorts.into_values().filter(|margins| margins.len() >= FEWEST_OF_KIND);
    let of_kinds = kinds.map(|margins| upper(margins, KEPT_OF_KIND));
    [all, decided, stuck]
        .into_iter()
        .filter(|margins| !margins.is_empty())
        .map(|margins| upper(margins, KEPT))
        .chain(of_kinds)
        .fold(f64::NEG_INFINITY, f64::max)
        .max(f64::MIN)
}

/// Results for mistaken recordings and for true loops, for the model card.
pub fn table(
    mistaken: (&Dataset, &[Weighed]),
    loops: (&Dataset, &[Weighed]),
) -> Result<String, std::fmt::Error> {
    let mut out = String::from(
        "\nThe next tables have recordings with a mistake in their columns, and correct recordings. \"Confident\" means a \
         probability of at most 0.2 or at least 0.9 in a recording that is not unlike all training loops, \
         without any further check.\n\n\
         | mistake | caught | confident and not caught |\n|---|---|---|\n",
    );
    let stopped = |weighed: &Weighed| weighed.mismatch > 1.0;
    let confident = |w: &Weighed| is_decided(w.probability) && w.distance <= 1.0;
    let slips = |w: &Weighed| confident(w) && !stopped(w);
    let grouped = |(data, weighed): (&Dataset, &[Weighed]), keep: &dyn Fn(&Truth) -> bool| {
        let mut groups: BTreeMap<String, Vec<Weighed>> = BTreeMap::new();
        for (truth, weighed) in data.truth.iter().zip(weighed).filter(|(truth, _)| keep(truth)) {
            groups.entry(truth.kind.clone()).or_default().push(weighed.clone());
        }
        groups
    };
    let all = |groups: &BTreeMap<String, Vec<Weighed>>| {
        let all: Vec<Weighed> = groups.values().flatten().cloned().collect();
        [("all".to_owned(), all)]
    };
    let groups = grouped(mistaken, &|_| true);
    for (name, part) in all(&groups).into_iter().chain(groups) {
        let (caught, missed) =
            (Share::of(part.iter().map(stopped)), Share::of(part.iter().map(slips)));
        writeln!(out, "| {name} | {caught} | {missed} |")?;
    }
    writeln!(
        out,
        "\n| correct loops | rejected | rejected, of the confident ones |\n|---|---|---|"
    )?;
    let groups = grouped(loops, &|_| true);
    let stuck = grouped(loops, &|truth| is_stuck(truth) && truth.visible);
    let stuck = stuck.into_iter().map(|(kind, part)| (format!("{kind}, visible"), part));
    for (name, part) in all(&groups).into_iter().chain(groups).chain(stuck) {
        let of_decided = part.iter().filter(|w| confident(w)).map(stopped);
        writeln!(
            out,
            "| {name} | {} | {} |",
            Share::of(part.iter().map(stopped)),
            Share::of(of_decided)
        )?;
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::tests::learned_from;
    use crate::measure::judge;
    use crate::members::Both;
    use crate::synthetic;

    /// Loops whose cause is none.
    fn mistaken(seed: u64) -> Dataset {
        let mut data = synthetic::dataset(seed, 600);
        data.values[2].iter_mut().for_each(|value| *value += 40.0);
        data.truth.iter_mut().for_each(|truth| truth.kind = "mistake".into());
        data
    }

    #[test]
    fn what_no_loop_looks_like_is_caught_and_loops_are_not() {
        let full = synthetic::dataset(1, 8000);
        let both = Both { full: full.clone(), alone: full, mistaken: mistaken(3) };
        let bundle = learned_from(&both, false).bundle;
        assert!(bundle.op_only.get().unwrap().mismatch.is_none());
        let (wrong, right) = (mistaken(4), synthetic::dataset(2, 4000));
        let of = |data: &Dataset| judge(&bundle, data, false).unwrap();
        let caught = |data: &Dataset| {
            Share::of(of(data).iter().map(|weighed| weighed.mismatch > 1.0)).value()
        };
        assert!(caught(&wrong) > 0.98 && caught(&right) < 0.03);
        let said = table((&wrong, &of(&wrong)), (&right, &of(&right))).unwrap();
        assert!(said.contains("| mistake |") && said.contains("| saturation |"));
    }
}
