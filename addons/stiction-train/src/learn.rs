//! From a dataset to everything that is frozen.

use crate::bins::Bins;
use crate::boost::{BoostOptions, Loss, Task, boost};
use crate::calibrate;
use crate::dataset::{Dataset, Truth};
use crate::decide;
use crate::decide::Choice;
use crate::families::{Families, Lesson, families};
use crate::grow::Limits;
use crate::limit;
use crate::members::Both;
use crate::mistakes;
use crate::reference::reference;
use anyhow::{Context, Result};
use stiction_diagnose::evidence::Line;
use stiction_diagnose::fusion::{
    Bundle, Calibration, Cause, Confidence, Decision, Deferred, Ensemble, LIMIT, Limit, Mismatch,
    Provenance, Quantiles, TrainedModel, row,
};

/// Smallest number of slips of a valve for learning S: fewer show only where it sticks.
pub const FEWEST_SLIPS: u64 = 3;

/// The probability from which loops count for the intervals of S and J/S.
const LIKELY: f64 = 0.7;

/// One of this many loops for learning is used for stopping.
const STOP_SHARE: u64 = 8;

/// The initial probability up to which valves are cleared.
const FIRST_CLEAR: f64 = 0.2;

/// The quantiles of intervals.
const QUANTILES: [f64; 3] = [0.05, 0.5, 0.95];

/// Settings of a model, and the number of averaged models with different seeds.
#[derive(Debug, Clone, Copy)]
struct Recipe {
    options: BoostOptions,
    members: u64,
}

const fn recipe(members: u64, rounds: usize, rate: f64, leaves: usize, least: f64) -> Recipe {
    Recipe {
        members,
        options: BoostOptions {
            rounds,
            rate,
            limits: Limits { leaves, least_weight: least, l2: 2.0 },
            rows: 0.7,
            columns: 0.4,
            patience: 30,
            seed: 1,
        },
    }
}

// The smallest weight of a leaf is in loops for quantiles, and in loops times p (1 - p) for probabilities.
const FAULT: Recipe = recipe(3, 2000, 0.05, 31, 6.0);
const NO_RESPONSE: Recipe = recipe(1, 150, 0.1, 8, 2.0);
const LINE: Recipe = recipe(1, 300, 0.08, 8, 4.0);
const CAUSES: Recipe = recipe(1, 200, 0.1, 16, 4.0);
const MISMATCH: Recipe = recipe(1, 300, 0.1, 16, 4.0);
const S: Recipe = recipe(2, 1000, 0.05, 20, 20.0);
const J_OVER_S: Recipe = recipe(1, 500, 0.06, 14, 30.0);
const LIMIT_OF_S: Recipe = recipe(1, 400, 0.08, 15, 20.0);

/// Features that the models of a fault may not use. They show how a loop was recorded. In a simulated population this
/// can reveal more about the valve than in a plant.
const SHORTCUTS: [&str; 4] = ["samples", "op_levels", "pv_levels", "sp_known"];
/// With the OP alone, also its still and straight parts.
const SHORTCUTS_OF_OP: [&str; 2] = ["op_still", "op_lines"];

/// A bundle, with information about its training.
pub struct Learned {
    pub bundle: Bundle,
    /// The choice of its thresholds.
    pub choice: Choice,
    /// For each learned model: its name, rounds, loss on the loops for stopping.
    pub notes: Vec<(String, usize, f64)>,
    /// Gain of the splits by each column in the models of a fault and of the median of S, of OP and PV; each adds
    /// up to one.
    pub fault_gains: Vec<f64>,
    pub s_gains: Vec<f64>,
    /// Results of leaving out families, of OP and PV and of the OP alone; `None` if none were left out.
    pub families: Option<[Families; 2]>,
}

/// Whether a loop has a visible fault; `None` for an invisible one, which is not used for learning.
pub fn fault(truth: &Truth) -> Option<bool> {
    match truth.cause.is_fault() {
        true => truth.visible.then_some(true),
        false => Some(false),
    }
}

/// `ln(S / OP span)` of a loop for learning S.
pub fn ln_s(truth: &Truth) -> Option<f64> {
    let known = truth.cause == Cause::StickingValve && truth.visible && truth.slips >= FEWEST_SLIPS;
    (known && truth.s > 0.0 && truth.op_span > 0.0).then(|| (truth.s / truth.op_span).ln())
}

/// J/S of a loop for learning it.
pub fn j_over_s(truth: &Truth) -> Option<f64> {
    ln_s(truth).map(|_| truth.j / truth.s)
}

/// `ln(S / OP span)` of any loop, for the limit: minus infinity for healthy valves, infinity for stuck ones. A
/// fault without an S, such as one in a loop below, is unknown for this OP and bounds nothing.
pub fn limit_target(truth: &Truth) -> Option<f64> {
    let s = if truth.cause.is_fault() { truth.s } else { 0.0 };
    let known = truth.op_span > 0.0 && (s > 0.0 || !truth.cause.is_fault());
    known.then(|| Limit::target(s, truth.op_span))
}

/// The target for faulty valves only, visible or not.
pub fn at_fault(truth: &Truth) -> Option<f64> {
    limit_target(truth).filter(|_| truth.cause.is_fault())
}

/// Learns all models from members of the population, as recorded and with the OP alone. The trees come from the first
/// `trained` members, calibration and intervals from the rest. If `leaves_out`, the confidence comes from leaving out
/// every family in turn.
///
/// # Errors
/// If there are too few loops of a kind.
pub fn learn(
    both: &Both,
    provenance: Provenance,
    leaves_out: bool,
    report: impl Fn(&str),
) -> Result<Learned> {
    let Both { full, alone, mistaken } = both;
    let mut school = School::new(full, provenance.trained, &report);
    let all: Vec<usize> = (0..full.columns.len()).collect();
    let (mut of_both, fault_gains, s_gains) = school.model("OP and PV", &all)?;
    of_both.mismatch = school.mismatch(mistaken, &all, &of_both)?;
    let left = if leaves_out { Some(school.families(&all)?) } else { None };
    let mut notes = school.notes;
    let mut school = School::new(alone, provenance.trained, &report);
    let of_op: Vec<usize> = all.into_iter().filter(|k| alone.columns[*k].op_only).collect();
    let (mut op_only, ..) = school.model("OP alone", &of_op)?;
    let mut families = None;
    if let Some(of_full) = left {
        let of_alone = school.families(&of_op)?;
        (of_both.confidence, of_both.s.stretch) = (of_full.confidence, of_full.stretch);
        op_only.confidence = of_alone.confidence;
        families = Some([of_full, of_alone]);
    }
    notes.extend(school.notes);
    let features: Vec<String> = full.columns.iter().map(|column| column.name.clone()).collect();
    let op_only = Deferred::new(&op_only, features.len());
    let rows = full.rows(provenance.trained..u64::MAX);
    let decision = Decision::CAUTIOUS;
    let mut bundle = Bundle { provenance, features, decision, full: of_both, op_only };
    let of_full = families.as_ref().map(|[of_full, _]| of_full);
    let choice = decide(&mut bundle, full, &rows, of_full)?;
    Ok(Learned { bundle, choice, notes, fault_gains, s_gains, families })
}

/// Shifts the limit and chooses the thresholds, on loops that were not used for learning.
///
/// # Errors
/// If evidence cannot be weighed.
pub fn decide(
    bundle: &mut Bundle,
    data: &Dataset,
    rows: &[u32],
    families: Option<&Families>,
) -> Result<Choice> {
    let mut clear = FIRST_CLEAR;
    loop {
        limit::calibrate(bundle, data, rows, clear)?;
        let choice = decide::choose(bundle, data, rows, families)?;
        bundle.decision = choice.decision;
        // The cleared loops depend on the limit, and the limit on the cleared loops: both converge downwards.
        if choice.decision.clear >= clear {
            return Ok(choice);
        }
        clear = choice.decision.clear;
    }
}

/// Leaves out every family in turn, for the evidence of OP and PV.
///
/// # Errors
/// If there are too few loops of a kind.
pub fn leave_out(data: &Dataset, trained: u64, report: impl Fn(&str)) -> Result<Families> {
    let all: Vec<usize> = (0..data.columns.len()).collect();
    School::new(data, trained, report).families(&all)
}

/// The columns that models of a fault may use.
pub fn open(data: &Dataset, columns: &[usize]) -> Vec<usize> {
    let of_op = is_of_op(data, columns);
    let is_shortcut = |k: &usize| {
        let name = &data.columns[*k].name[..];
        SHORTCUTS.contains(&name) || (of_op && SHORTCUTS_OF_OP.contains(&name))
    };
    columns.iter().filter(|k| !is_shortcut(k)).copied().collect()
}

fn is_of_op(data: &Dataset, columns: &[usize]) -> bool {
    columns.iter().all(|k| data.columns[*k].op_only)
}

/// The input of learning.
struct School<'a, R> {
    data: &'a Dataset,
    bins: Bins,
    monotone: Vec<i8>,
    trained: Vec<u32>,
    calibrated: Vec<u32>,
    notes: Vec<(String, usize, f64)>,
    report: R,
}

impl<'a, R: Fn(&str)> School<'a, R> {
    fn new(data: &'a Dataset, trained: u64, report: R) -> Self {
        let calibrated = data.rows(trained..u64::MAX);
        let trained = data.rows(0..trained);
        Self {
            data,
            bins: Bins::new(&data.values, &trained),
            monotone: data.monotone(),
            trained,
            calibrated,
            notes: vec![],
            report,
        }
    }

    /// Leaves out every family in turn; with the OP alone only to find the confidence of its verdict.
    fn families(&self, columns: &[usize]) -> Result<Families> {
        let lesson = Lesson {
            data: self.data,
            bins: &self.bins,
            monotone: &self.monotone,
            columns,
            open: &open(self.data, columns),
            trained: &self.trained,
            calibrated: &self.calibrated,
            thorough: !is_of_op(self.data, columns),
        };
        families(&lesson, &self.report)
    }

    /// All models of these columns, and the gain of the columns in the models of a fault and of S.
    fn model(
        &mut self,
        name: &str,
        columns: &[usize],
    ) -> Result<(TrainedModel, Vec<f64>, Vec<f64>)> {
        let named = |what: &str| format!("{name}: {what}");

        let target = |truth: &Truth| fault(truth).map(f64::from);
        let monotone = self.monotone.clone();
        let open = open(self.data, columns);
        let (mut trees, fault_gains) =
            self.fit(&named("fault"), Loss::Logistic, &open, &monotone, &FAULT, &target)?;
        let fault_trees = trees.swap_remove(0);
        // Smooth, because the confidence depends on log-odds, which pools of loops do not resolve.
        let (margins, truth) = self.margins(&fault_trees, &target);
        let calibration = calibrate::beta(&margins, &truth);

        let mut lines = vec![];
        for (line, parts) in Line::WEIGHED {
            let of = |k: &&usize| parts.contains(&self.data.columns[**k].line);
            let looks_at: Vec<usize> = open.iter().filter(of).copied().collect();
            if looks_at.is_empty() {
                continue;
            }
            let name = named(line.name());
            let (mut trees, _) =
                self.fit(&name, Loss::Logistic, &looks_at, &monotone, &LINE, &target)?;
            let trees = trees.swap_remove(0);
            let calibration = self.calibration(&trees, &target);
            lines.push((line, trees, calibration));
        }

        let free = vec![0; monotone.len()];
        let target = |truth: &Truth| {
            let shows = fault(truth) == Some(true);
            shows.then(|| f64::from(truth.cause == Cause::NoResponse))
        };
        let name_of = named("no response, given a fault");
        let (mut trees, _) =
            self.fit(&name_of, Loss::Logistic, columns, &free, &NO_RESPONSE, &target)?;
        let no_response = trees.swap_remove(0);

        let others: Vec<Cause> = Cause::ALL
            .into_iter()
            .filter(|cause| !cause.is_fault())
            .filter(|cause| self.data.truth.iter().any(|truth| truth.cause == *cause))
            .collect();
        let target = |truth: &Truth| {
            others.iter().position(|cause| *cause == truth.cause).map(|class| class as f64)
        };
        let loss = Loss::Softmax(others.len());
        let (trees, _) =
            self.fit(&named("causes, given no fault"), loss, columns, &free, &CAUSES, &target)?;
        let causes = others.iter().copied().zip(trees).collect();

        // Intervals are for loops with a reported S.
        let likely: Vec<u32> = self
            .calibrated
            .iter()
            .filter(|k| {
                let margin = fault_trees.margin(&row(&self.data.row(**k as usize)));
                calibration.probability(margin) >= LIKELY
            })
            .copied()
            .collect();
        let (s, s_gains) = self.quantiles(&named("S"), columns, &S, &ln_s, &likely)?;
        let (j_over_s, _) =
            self.quantiles(&named("J/S"), columns, &J_OVER_S, &j_over_s, &likely)?;
        let limit = match is_of_op(self.data, columns) {
            true => None,
            false => Some(self.limit(&named("detection limit"), columns)?),
        };
        (self.report)(&format!("{name}: distance"));
        let known = reference(self.data, columns, &self.trained, &self.calibrated);
        let model = TrainedModel {
            fault: fault_trees,
            calibration,
            confidence: Confidence::IDENTITY,
            lines,
            no_response,
            causes,
            s,
            j_over_s,
            limit,
            reference: Some(known),
            mismatch: None,
        };
        Ok((model, fault_gains, s_gains))
    }

    /// The classifier of mistaken columns; `None` without data for it.
    fn mismatch(
        &mut self,
        mistaken: &Dataset,
        columns: &[usize],
        model: &TrainedModel,
    ) -> Result<Option<Mismatch>> {
        if mistaken.truth.is_empty() {
            return Ok(None);
        }
        let probability = |k: u32| {
            let margin = model.fault.margin(&row(&self.data.row(k as usize)));
            model.calibration.probability(margin)
        };
        let lesson = mistakes::Lesson {
            data: self.data,
            mistaken,
            trained: &self.trained,
            calibrated: &self.calibrated,
            columns: &open(self.data, columns),
            options: &MISMATCH.options,
            probability: &probability,
        };
        let (known, rounds, loss) = mistakes::mismatch(&lesson)?;
        let name = "OP and PV: mistaken columns".to_owned();
        (self.report)(&format!("{name}: {rounds} rounds, loss {loss:.4}"));
        self.notes.push((name, rounds, loss));
        Ok(Some(known))
    }

    /// An upper limit on S, shifted so that it holds for faulty valves.
    fn limit(&mut self, name: &str, columns: &[usize]) -> Result<Limit> {
        let free = vec![0; self.monotone.len()];
        let loss = Loss::Pinball(LIMIT);
        let (mut trees, _) = self.fit(name, loss, columns, &free, &LIMIT_OF_S, &limit_target)?;
        let trees = trees.swap_remove(0);
        Ok(Limit { trees, shifts: vec![(1.0, 0.0)] })
    }

    /// Quantiles, shifted so that their interval covers, and the gain of the columns in the median.
    fn quantiles(
        &mut self,
        name: &str,
        columns: &[usize],
        recipe: &Recipe,
        target: &dyn Fn(&Truth) -> Option<f64>,
        judged: &[u32],
    ) -> Result<(Quantiles, Vec<f64>)> {
        let free = vec![0; self.monotone.len()];
        let mut fitted = vec![];
        let mut gains = vec![];
        for share in QUANTILES {
            let name = format!("{name}, {:.0} %", 100.0 * share);
            let (mut trees, gain) =
                self.fit(&name, Loss::Pinball(share), columns, &free, recipe, target)?;
            fitted.push(trees.swap_remove(0));
            if share == 0.5 {
                gains = gain;
            }
        }
        let [low, middle, high] =
            <[Ensemble; 3]>::try_from(fitted).unwrap_or_else(|_| unreachable!());
        let shifts = vec![(f64::INFINITY, 0.0)];
        let mut quantiles = Quantiles { low, middle, high, shifts, stretch: 1.0 };
        let predicted: Vec<(f64, f64, f64)> = judged
            .iter()
            .filter_map(|k| {
                let truth = target(&self.data.truth[*k as usize])?;
                let [low, _, high] = quantiles.raw(&row(&self.data.row(*k as usize)));
                Some((low, high, truth))
            })
            .collect();
        quantiles.shifts = calibrate::shifts(&predicted);
        Ok((quantiles, gains))
    }

    fn calibration(&self, trees: &Ensemble, target: &dyn Fn(&Truth) -> Option<f64>) -> Calibration {
        let (margins, truth) = self.margins(trees, target);
        calibrate::calibration(&margins, &truth).0
    }

    /// Output of trees for the calibration loops, with the truth.
    fn margins(
        &self,
        trees: &Ensemble,
        target: &dyn Fn(&Truth) -> Option<f64>,
    ) -> (Vec<f64>, Vec<bool>) {
        let known = self.calibrated.iter().filter_map(|k| {
            let truth = target(&self.data.truth[*k as usize])?;
            Some((trees.margin(&row(&self.data.row(*k as usize))), truth == 1.0))
        });
        known.unzip()
    }

    /// The mean of several models of different seeds, each stopped by different loops, and the gain of each column
    /// in them.
    fn fit(
        &mut self,
        name: &str,
        loss: Loss,
        columns: &[usize],
        monotone: &[i8],
        recipe: &Recipe,
        target: &dyn Fn(&Truth) -> Option<f64>,
    ) -> Result<(Vec<Ensemble>, Vec<f64>)> {
        let targets: Vec<Option<f64>> = self.data.truth.iter().map(target).collect();
        let known = self.trained.iter().copied().filter(|row| targets[*row as usize].is_some());
        let known: Vec<u32> = known.collect();
        let targets: Vec<f64> = targets.into_iter().map(Option::unwrap_or_default).collect();
        let weight = vec![1.0; targets.len()];
        let mut members: Vec<Vec<Ensemble>> = vec![];
        let mut gains = vec![0.0; self.data.columns.len()];
        let (mut rounds, mut lost) = (0, 0.0);
        for member in 0..recipe.members {
            let stops = |row: &u32| self.data.truth[*row as usize].index % STOP_SHARE == member;
            let (stop, train): (Vec<u32>, Vec<u32>) = known.iter().partition(|row| stops(row));
            let task = Task {
                loss,
                target: &targets,
                weight: &weight,
                train: &train,
                stop: &stop,
                columns,
                monotone,
            };
            let options = BoostOptions { seed: recipe.options.seed + member, ..recipe.options };
            let boosted = boost(&self.bins, &task, &options)
                .with_context(|| format!("cannot learn {name}"))?;
            gains.iter_mut().zip(&boosted.gains).for_each(|(sum, gain)| *sum += gain);
            rounds += boosted.rounds;
            lost += boosted.loss / recipe.members as f64;
            members.push(boosted.ensembles);
        }
        let total: f64 = gains.iter().sum();
        gains.iter_mut().for_each(|gain| *gain /= total.max(f64::MIN_POSITIVE));
        (self.report)(&format!("{name}: {} loops, {rounds} rounds, loss {lost:.4}", known.len()));
        self.notes.push((name.to_owned(), rounds, lost));
        let outputs = members[0].len();
        let mean = |output: usize| {
            let all: Vec<Ensemble> = members.iter().map(|each| each[output].clone()).collect();
            // As in the file: calibration and intervals are those of the rounded trees.
            Ensemble::mean(&all).rounded()
        };
        Ok(((0..outputs).map(mean).collect(), gains))
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::synthetic;

    fn learned(leaves_out: bool) -> (Learned, Dataset) {
        let data = synthetic::dataset(1, 8000);
        let both = Both { full: data.clone(), alone: data, mistaken: Dataset::default() };
        (learned_from(&both, leaves_out), synthetic::dataset(2, 4000))
    }

    /// What is learned of 8000 loops.
    pub fn learned_from(both: &Both, leaves_out: bool) -> Learned {
        let provenance = Provenance { trained: 6000, calibrated: 2000, ..Default::default() };
        learn(both, provenance, leaves_out, |_| {}).unwrap()
    }

    #[test]
    fn a_bundle_says_what_is_so() {
        let (learned, fresh) = learned(true);
        let [of_both, _] = learned.families.as_ref().unwrap();
        assert_eq!(learned.bundle.full.confidence, of_both.confidence);
        let bundle = Bundle::from_bytes(&learned.bundle.to_bytes()).unwrap();
        assert_eq!(bundle, learned.bundle);
        let (mut hits, mut said, mut right, mut causes) = (0.0, 0.0, 0, 0);
        let (mut covered, mut measured, mut faults, mut below) = (0, 0, 0, 0);
        for (k, truth) in fresh.truth.iter().enumerate() {
            let weighed = bundle.weigh(&fresh.row(k), truth.op_span, false).unwrap();
            let Some(fault) = fault(truth) else { continue };
            hits += f64::from(fault);
            said += weighed.probability;
            right += usize::from((weighed.probability > 0.5) == fault);
            let likeliest = weighed.causes.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0;
            causes += usize::from(likeliest == truth.cause);
            if truth.cause.is_fault() {
                faults += 1;
                below += usize::from(weighed.limit.is_none_or(|limit| truth.s <= limit));
            }
            if ln_s(truth).is_some() {
                measured += 1;
                covered += usize::from((weighed.s.low..=weighed.s.high).contains(&truth.s));
            }
        }
        let n = fresh.truth.len() as f64;
        assert!((hits - said).abs() / n < 0.03, "{hits} faults, {said} predicted");
        assert!(right as f64 / n > 0.82, "{right} of {n}");
        assert!(causes as f64 / n > 0.7, "{causes} of {n}");
        let share = covered as f64 / measured as f64;
        assert!((share - 0.9).abs() < 0.03, "{share}");
        let share = below as f64 / faults as f64;
        assert!((share - LIMIT).abs() < 0.03, "{share}");
        // What tells S is found, and tells nothing of a fault.
        assert!(learned.fault_gains[3] < 0.05, "{:?}", learned.fault_gains);
        assert!(learned.s_gains[3] > 0.5, "{:?}", learned.s_gains);
    }

    #[test]
    fn op_only_looks_at_nothing_else() {
        let (learned, fresh) = learned(false);
        let mut blind = fresh.clone();
        for column in [0, 2, 3] {
            blind.values[column].fill(f32::NAN);
        }
        for k in 0..200 {
            let ask = |data: &Dataset| learned.bundle.weigh(&data.row(k), 1.0, true).unwrap();
            assert_eq!(ask(&fresh), ask(&blind));
        }
        let of = |k: usize| learned.bundle.weigh(&fresh.row(k), 1.0, true).unwrap().probability;
        assert!((0..200).any(|k| of(k) != of(0)));
    }
}
