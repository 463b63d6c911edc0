//! Accuracy of the verdict on families of loops that were left out of its training.
//!
//! Every family in turn is left out: smaller models are trained and calibrated without it, and tested on it. Their
//! errors determine the confidence of the verdict ([`Confidence`]) and the stretch of its intervals of S. A family of
//! one class is completed by loops of the other class, which were not used for training either, at the population's
//! shares. Leaving out a family changes the share of faults, so log-odds are shifted back to the share of the whole
//! population.

use crate::bins::Bins;
use crate::boost::{BoostOptions, Loss, Task, boost};
use crate::calibrate;
use crate::dataset::{Dataset, Truth};
use crate::grow::Limits;
use crate::learn::{at_fault, fault, limit_target, ln_s};
use crate::measure::{Share, auc};
use crate::reference::{reference, thinned};
use anyhow::{Context, Result};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write;
use stiction_diagnose::fusion::{
    COVERAGE, Calibration, Cause, Confidence, Ensemble, LIMIT, Limit, SURE, Side, logit, row,
    sigmoid,
};
use stiction_score::scoreboard::wilson;

/// The most loops for training, calibration and test.
const TRAINED: usize = 40_000;
const CALIBRATED: usize = 10_000;
const ASKED: usize = 6_000;

/// Families with fewer loops give no result. Families with more than this share are the population itself.
const FEWEST: usize = 200;
const LARGEST: f64 = 0.6;

/// The largest share of wrong sure decisions, on either side over all families, and in each family except [`EXCUSED`]
/// families. A family with fewer sure decisions than [`COUNTED`], or with a single wrong one, is not judged.
const WRONG: f64 = 0.04;
const EXCUSED: usize = 2;
const COUNTED: usize = 20;

/// Intervals of S are stretched until they cover this share of all left-out families, with one exception in this many
/// families, up to this limit. Otherwise all intervals would widen for the worst families.
const COVERED: f64 = 0.885;
const UNCOVERED: usize = 8;
const MOST_STRETCH: f64 = 1.4;

/// The reported confidence if no log-odds are sure enough.
const NEVER: f64 = 0.975;

const fn recipe(rounds: usize, rate: f64, leaves: usize, least: f64) -> BoostOptions {
    BoostOptions {
        rounds,
        rate,
        limits: Limits { leaves, least_weight: least, l2: 2.0 },
        rows: 0.7,
        columns: 0.4,
        patience: 20,
        seed: 1,
    }
}

const FAULT: BoostOptions = recipe(300, 0.1, 31, 6.0);
const S: BoostOptions = recipe(200, 0.1, 20, 20.0);
const LIMIT_TREES: BoostOptions = recipe(150, 0.1, 15, 20.0);

/// The input of learning: the columns of a model, those allowed for the models of a fault, and their directions.
pub struct Lesson<'a> {
    pub data: &'a Dataset,
    pub bins: &'a Bins,
    pub monotone: &'a [i8],
    pub columns: &'a [usize],
    pub open: &'a [usize],
    /// The loops for training. All other loops are for calibration and test.
    pub trained: &'a [u32],
    pub calibrated: &'a [u32],
    /// Whether S, its limit and the distance are tested too.
    pub thorough: bool,
}

/// The results of leaving out families.
#[derive(Debug, Clone)]
pub struct Families {
    /// First the result with all families.
    left: Vec<Left>,
    pub confidence: Confidence,
    pub stretch: f64,
}

/// A left-out family.
#[derive(Debug, Clone)]
struct Left {
    name: String,
    loops: usize,
    /// Whether the family counts for the confidence. A family with all loops of another fault does not count.
    counted: bool,
    /// Log-odds, truth and weight; the weights add up to the number of tested loops.
    judged: Vec<(f64, bool, f64)>,
    /// For every valve with a known S: the distance from the middle of its interval, in half-widths.
    ends: Vec<f64>,
    /// Share of the faulty valves whose S is not above the limit.
    limit: Share,
    /// Share of all loops whose distance exceeds 1.
    unlike: Share,
}

/// Sure decisions of some loops: weight and number of the wrong ones, and of all.
#[derive(Debug, Clone, Copy, Default)]
struct Sure {
    wrong: f64,
    all: f64,
    raw: Share,
}

impl Sure {
    fn share(self) -> f64 {
        if self.all > 0.0 { self.wrong / self.all } else { 0.0 }
    }

    fn with(self, other: Self) -> Self {
        Self {
            wrong: self.wrong + other.wrong,
            all: self.all + other.all,
            raw: Share { k: self.raw.k + other.raw.k, n: self.raw.n + other.raw.n },
        }
    }

    fn is_above(self) -> bool {
        self.raw.n >= COUNTED && self.raw.k >= 2 && self.share() > WRONG
    }
}

impl std::fmt::Display for Sure {
    /// The weighted share in percent with the interval for this many loops, and the plain count.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Share { k, n } = self.raw;
        if n == 0 {
            return f.write_str("-");
        }
        let (low, high) = wilson((self.share() * n as f64).round() as usize, n);
        let [share, low, high] = [self.share(), low, high].map(|share| 100.0 * share);
        write!(f, "{share:.1} % ({low:.1} to {high:.1}; {k} of {n})")
    }
}

/// Leaves out every family in turn.
///
/// # Errors
/// If there is too little data.
pub fn families(lesson: &Lesson<'_>, report: impl Fn(&str)) -> Result<Families> {
    let names = names(lesson.data);
    report(&format!("leaving out {} families", names.len()));
    let none = [(String::new(), 0, false)];
    let left: Vec<Left> = none
        .par_iter()
        .chain(&names)
        .with_max_len(1)
        .map(|(name, loops, counted)| {
            lesson.leave_out(name, *loops, *counted).with_context(|| format!("without {name}"))
        })
        .collect::<Result<_>>()?;
    let judged: Vec<&Left> = left.iter().filter(|each| each.counted).collect();
    let confidence = confidence(&judged);
    let stretch = stretch(&judged);
    Ok(Families { left, confidence, stretch })
}

/// The families to leave out with the number of their loops, and whether they count. A family with most loops, or
/// nearly all sticking valves, is the whole question. A family of valves that do not respond is a different fault,
/// and reported separately.
fn names(data: &Dataset) -> Vec<(String, usize, bool)> {
    let mut found: BTreeMap<&str, [usize; 3]> = BTreeMap::new();
    let mut all = [0; 3];
    for truth in &data.truth {
        let is = [true, truth.cause == Cause::StickingValve, truth.cause == Cause::NoResponse];
        let add = |counts: &mut [usize; 3]| {
            counts.iter_mut().zip(is).for_each(|(count, is)| *count += usize::from(is));
        };
        add(&mut all);
        truth.families.iter().for_each(|name| add(found.entry(name).or_default()));
    }
    let holds = |counts: &[usize; 3], k: usize, share: f64| {
        all[k] > 0 && counts[k] as f64 > share * all[k] as f64
    };
    found
        .into_iter()
        .filter(|(_, counts)| counts[0] >= FEWEST)
        .filter(|(_, counts)| !holds(counts, 0, LARGEST) && !holds(counts, 1, 0.9))
        .map(|(name, counts)| (name.to_owned(), counts[0], 2 * counts[2] < counts[0]))
        .collect()
}

impl Lesson<'_> {
    fn leave_out(&self, name: &str, loops: usize, counted: bool) -> Result<Left> {
        let truth = |k: &u32| &self.data.truth[*k as usize];
        let is_left = |k: &u32| truth(k).families.iter().any(|each| each == name);
        let stays = |rows: &[u32], parity: Option<u64>| -> Vec<u32> {
            let fits = |k: &u32| parity.is_none_or(|parity| truth(k).index % 2 == parity);
            rows.iter().copied().filter(|k| !is_left(k) && fits(k)).collect()
        };
        let trained = thinned(&stays(self.trained, None), TRAINED);
        let calibrated = thinned(&stays(self.calibrated, Some(0)), CALIBRATED);
        let others = thinned(&stays(self.calibrated, Some(1)), CALIBRATED);
        let mut asked: Vec<u32> =
            self.trained.iter().chain(self.calibrated).copied().filter(is_left).collect();
        if name.is_empty() {
            asked = others.clone();
        }
        let asked = thinned(&asked, ASKED);
        let mut left = Left {
            name: name.to_owned(),
            loops: if name.is_empty() { asked.len() } else { loops },
            counted,
            judged: self.judged(&trained, &calibrated, &others, &asked)?,
            ends: vec![],
            limit: Share::default(),
            unlike: Share::default(),
        };
        if self.thorough {
            left.ends = self.ends(&trained, &calibrated, &asked)?;
            left.limit = self.limit(&trained, &calibrated, &asked)?;
            let known = reference(self.data, self.columns, &trained, &calibrated);
            left.unlike = Share::of(asked.iter().map(|k| known.distance(&self.row(k)) > 1.0));
        }
        Ok(left)
    }

    fn row(&self, k: &u32) -> Vec<f32> {
        row(&self.data.row(*k as usize))
    }

    /// The rows with a known target, each with its target.
    fn known(&self, rows: &[u32], target: &dyn Fn(&Truth) -> Option<f64>) -> Vec<(u32, f64)> {
        rows.iter().filter_map(|k| Some((*k, target(&self.data.truth[*k as usize])?))).collect()
    }

    fn fit(
        &self,
        rows: &[u32],
        loss: Loss,
        columns: &[usize],
        options: &BoostOptions,
        target: &dyn Fn(&Truth) -> Option<f64>,
    ) -> Result<Ensemble> {
        let n = self.data.truth.len();
        let (mut targets, weight) = (vec![0.0; n], vec![1.0; n]);
        let (mut train, mut stop) = (vec![], vec![]);
        for (place, (k, y)) in self.known(rows, target).into_iter().enumerate() {
            targets[k as usize] = y;
            if place % 8 == 0 { stop.push(k) } else { train.push(k) }
        }
        let free = vec![0; self.monotone.len()];
        let task = Task {
            loss,
            target: &targets,
            weight: &weight,
            train: &train,
            stop: &stop,
            columns,
            monotone: if loss == Loss::Logistic { self.monotone } else { &free },
        };
        Ok(boost(self.bins, &task, options)?.ensembles.swap_remove(0).rounded())
    }

    /// Log-odds, truth and weight of the loops of a family, completed.
    fn judged(
        &self,
        trained: &[u32],
        calibrated: &[u32],
        others: &[u32],
        asked: &[u32],
    ) -> Result<Vec<(f64, bool, f64)>> {
        let target = |truth: &Truth| fault(truth).map(f64::from);
        let trees = self.fit(trained, Loss::Logistic, self.open, &FAULT, &target)?;
        let margins = |rows: &[u32]| -> Vec<(f64, bool)> {
            let known = self.known(rows, &target);
            known.iter().map(|(k, y)| (trees.margin(&self.row(k)), *y == 1.0)).collect()
        };
        let (seen, truth): (Vec<f64>, Vec<bool>) = margins(calibrated).into_iter().unzip();
        let map = calibrate::beta(&seen, &truth);
        let share = |truth: &mut dyn Iterator<Item = bool>| {
            let all = Share::of(truth);
            (all.k as f64 + 0.5) / (all.n as f64 + 1.0)
        };
        let everyone = self.known(self.calibrated, &target);
        let prior = share(&mut everyone.iter().map(|(_, y)| *y == 1.0));
        let moved = logit(prior) - logit(share(&mut truth.iter().copied()));
        let log_odds = |margin: f64| log_odds(&map, margin) + moved;
        let own: Vec<(f64, bool)> = margins(asked);
        let hits = Share::of(own.iter().map(|(_, hit)| *hit)).value();
        let all = |w: f64| move |(margin, hit): (f64, bool)| (log_odds(margin), hit, w);
        if (0.03..0.97).contains(&hits) {
            return Ok(own.into_iter().map(all(1.0)).collect());
        }
        let opposite: Vec<(f64, bool)> =
            margins(others).into_iter().filter(|(_, hit)| *hit != (hits > 0.5)).collect();
        let share = if hits > 0.5 { prior } else { 1.0 - prior };
        let total = (own.len() + opposite.len()) as f64;
        let of_own = total * share / own.len().max(1) as f64;
        let of_opposite = total * (1.0 - share) / opposite.len().max(1) as f64;
        let own = own.into_iter().map(all(of_own));
        Ok(own.chain(opposite.into_iter().map(all(of_opposite))).collect())
    }

    /// Distances of S from the middles of the intervals for the valves of a family.
    fn ends(&self, trained: &[u32], calibrated: &[u32], asked: &[u32]) -> Result<Vec<f64>> {
        let fit = |share| self.fit(trained, Loss::Pinball(share), self.columns, &S, &ln_s);
        let (low, high) = (fit(0.5 * (1.0 - COVERAGE))?, fit(0.5 * (1.0 + COVERAGE))?);
        let predicted = |rows: &[u32]| -> Vec<(f64, f64, f64)> {
            let known = self.known(rows, &ln_s);
            known
                .iter()
                .map(|(k, y)| {
                    let row = self.row(k);
                    let (a, b) = (low.margin(&row), high.margin(&row));
                    (a.min(b), a.max(b), *y)
                })
                .collect()
        };
        let shifts = calibrate::shifts(&predicted(calibrated));
        let end = |(low, high, y): (f64, f64, f64)| {
            let class = shifts.iter().find(|(widest, _)| high - low <= *widest);
            let half = 0.5 * (high - low) + class.map_or(0.0, |(_, shift)| *shift);
            (y - 0.5 * (low + high)).abs() / half.max(1e-9)
        };
        Ok(predicted(asked).into_iter().map(end).collect())
    }

    /// Share of the faulty valves of a family whose S is not above the limit.
    fn limit(&self, trained: &[u32], calibrated: &[u32], asked: &[u32]) -> Result<Share> {
        let trees =
            self.fit(trained, Loss::Pinball(LIMIT), self.columns, &LIMIT_TREES, &limit_target)?;
        let at_fault = |rows: &[u32]| self.known(rows, &at_fault);
        let excess = |(k, y): &(u32, f64)| y - trees.margin(&self.row(k));
        let shift = calibrate::upper(at_fault(calibrated).iter().map(excess).collect(), LIMIT);
        let limit = Limit { trees: trees.clone(), shifts: vec![(1.0, shift)] };
        Ok(Share::of(at_fault(asked).iter().map(|(k, y)| {
            limit.spans(&self.row(k), 1.0).is_none_or(|spans| *y <= spans.ln() + 1e-9)
        })))
    }
}

fn log_odds(map: &Calibration, margin: f64) -> f64 {
    logit(map.probability(margin).clamp(1e-12, 1.0 - 1e-12))
}

impl Left {
    /// Decisions with log-odds of size `above` or more, for or against a fault.
    fn sure(&self, accusing: bool, above: f64) -> Sure {
        let mut sure = Sure::default();
        for (log_odds, hit, weight) in &self.judged {
            if (*log_odds > 0.0) == accusing && log_odds.abs() >= above {
                let wrong = *hit != accusing;
                sure.all += weight;
                sure.wrong += if wrong { *weight } else { 0.0 };
                sure.raw.n += 1;
                sure.raw.k += usize::from(wrong);
            }
        }
        sure
    }

    fn confidence(&self, [clearing, accusing]: [f64; 2]) -> Sure {
        self.sure(false, clearing).with(self.sure(true, accusing))
    }

    /// The stretch of intervals of S for their coverage.
    fn stretch(&self) -> f64 {
        if self.ends.len() < 100 {
            return 1.0;
        }
        calibrate::upper(self.ends.clone(), COVERED)
    }

    fn covered(&self, stretch: f64) -> Share {
        Share::of(self.ends.iter().map(|end| *end <= stretch))
    }
}

/// The log-odds at which sure decisions begin, against a fault and for one. They give the most decisions of which at
/// most [`WRONG`] of either side are wrong over all families, and more in at most [`EXCUSED`] of the families. They are
/// infinite if no decision is allowed.
fn thresholds(families: &[&Left]) -> [f64; 2] {
    let own = logit(SURE);
    let grid: Vec<f64> =
        (0..=60).map(|k| own + 0.1 * f64::from(k)).chain([f64::INFINITY]).collect();
    let at = |accusing: bool| -> Vec<Vec<Sure>> {
        let of = |above: &f64| families.iter().map(|each| each.sure(accusing, *above)).collect();
        grid.par_iter().map(of).collect()
    };
    let (clearing, accusing) = (at(false), at(true));
    let pooled = |all: &[Sure]| all.iter().fold(Sure::default(), |sum, each| sum.with(*each));
    let mut best = ([f64::INFINITY; 2], 0.0);
    for (a, cleared) in grid.iter().zip(&clearing) {
        for (b, accused) in grid.iter().zip(&accusing) {
            let sides = [pooled(cleared), pooled(accused)];
            let above = cleared.iter().zip(accused).filter(|(c, a)| c.with(**a).is_above());
            let decided = sides[0].all + sides[1].all;
            if decided > best.1
                && sides.iter().all(|side| side.share() <= WRONG)
                && above.count() <= EXCUSED
            {
                best = ([*a, *b], decided);
            }
        }
    }
    best.0
}

/// The stretch of all intervals of S.
fn stretch(families: &[&Left]) -> f64 {
    let mut wanted: Vec<f64> = families.iter().map(|each| each.stretch()).collect();
    wanted.sort_by(|a, b| b.total_cmp(a));
    let left = wanted.len().div_ceil(UNCOVERED);
    wanted.get(left).copied().unwrap_or(1.0).clamp(1.0, MOST_STRETCH)
}

fn confidence(families: &[&Left]) -> Confidence {
    let [clearing, accusing] = thresholds(families).map(|from| match from.is_finite() {
        true => Side::reaching(from),
        false => Side::bounded(logit(SURE) + 6.0, NEVER),
    });
    Confidence { clearing, accusing }
}

impl Families {
    /// Increase of the share of wrong decisions when a family is left out, over all families: decisions up to one
    /// probability against a fault, from the other one for it. Both shares come from models of the same size, so the
    /// weakness of a small model does not count.
    pub fn excess_beyond(&self, clear: f64, accuse: f64) -> f64 {
        let wrong = |of: &dyn Fn(&&Left) -> bool| {
            let mut sure = Sure::default();
            for (log_odds, hit, weight) in self.left.iter().filter(of).flat_map(|each| &each.judged)
            {
                let p = self.confidence.reported(sigmoid(*log_odds));
                if p <= clear || p >= accuse {
                    sure.all += weight;
                    sure.wrong += if *hit == (p <= clear) { *weight } else { 0.0 };
                }
            }
            sure.share()
        };
        wrong(&|each| each.counted && !each.name.is_empty()) - wrong(&|each| each.name.is_empty())
    }

    /// The table in Markdown. The reported values of a family use thresholds and stretches from the other families.
    pub fn table(&self) -> String {
        let mut out = String::from(
            "| left out | loops | AUC | decided, 20/80 % | right | wrong below 2 %, calibrated | wrong above \
             98 %, calibrated | wrong beyond 2 and 98 %, reported | S covered | S covered, stretched | S at or \
             below its limit | unlike training |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        );
        for (place, each) in self.left.iter().enumerate() {
            let others: Vec<&Left> = self
                .left
                .iter()
                .enumerate()
                .filter(|(k, other)| *k != place && other.counted)
                .map(|(_, other)| other)
                .collect();
            let from = thresholds(&others);
            let stretch = stretch(&others);
            let scored: Vec<(f64, bool)> =
                each.judged.iter().map(|(l, hit, _)| (*l, *hit)).collect();
            let decided = each.confidence([4f64.ln(); 2]);
            let total: f64 = each.judged.iter().map(|(.., weight)| weight).sum();
            let own = logit(SURE);
            let name = match (&each.name[..], each.counted) {
                ("", _) => "nothing".to_owned(),
                (name, true) => name.to_owned(),
                (name, false) => format!("{name} (a different fault, not counted)"),
            };
            let _ = writeln!(
                out,
                "| {name} | {} | {:.4} | {:.1} % | {:.1} % | {} | {} | {} | {} | {} | {} | {} |",
                each.loops,
                auc(&scored),
                100.0 * decided.all / total,
                100.0 * (1.0 - decided.share()),
                each.sure(false, own),
                each.sure(true, own),
                each.confidence(from),
                each.covered(1.0),
                each.covered(stretch),
                each.limit,
                each.unlike,
            );
        }
        let Confidence { clearing, accusing } = self.confidence;
        let counted: Vec<&Left> = self.left.iter().filter(|each| each.counted).collect();
        let from = thresholds(&counted);
        let above = counted.iter().filter(|each| each.confidence(from).is_above()).count();
        let told = |accusing: bool, above: f64| {
            counted.iter().fold(Sure::default(), |sum, each| sum.with(each.sure(accusing, above)))
        };
        let _ = writeln!(
            out,
            "\nThe verdict reports {:.0} % confidence only beyond calibrated log-odds of {:.2} against a fault{} and \
             {:.2} for one{}. Beyond these bounds, {above} of {} families are wrong in more than {:.0} % of at least {COUNTED} such \
             decisions. Over all families, decisions against a fault are wrong in {}. Decisions for a fault are wrong \
             in {}. Intervals of S are stretched by {:.2}.",
            100.0 * SURE,
            clearing.reached,
            if clearing.most.is_finite() { " (never)" } else { "" },
            accusing.reached,
            if accusing.most.is_finite() { " (never)" } else { "" },
            counted.len(),
            100.0 * WRONG,
            told(false, from[0]),
            told(true, from[1]),
            self.stretch
        );
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    fn left(judged: Vec<(f64, bool, f64)>) -> Left {
        Left {
            name: "made".into(),
            loops: judged.len(),
            counted: true,
            judged,
            ends: vec![],
            limit: Share::default(),
            unlike: Share::default(),
        }
    }

    #[test]
    fn confidence_begins_where_errors_end() {
        // Cleared loops err in one of ten up to log-odds of 6, accused ones never.
        let made: Vec<(f64, bool, f64)> = (0..2000)
            .flat_map(|k| {
                let size = 3.0 + 6.0 * f64::from(k) / 2000.0;
                [(-size, size < 6.0 && k % 10 == 0, 1.0), (size, true, 1.0)]
            })
            .collect();
        let made = left(made);
        let [clearing, accusing] = thresholds(&[&made, &made, &made]);
        assert_eq!(accusing, logit(SURE));
        // Four in a hundred of all from there on.
        assert!((3.95..4.2).contains(&clearing), "{clearing}");
        assert!(made.sure(false, clearing).share() <= WRONG);
    }

    #[test]
    fn intervals_are_stretched_for_all_but_the_worst_families() {
        let of = |scale: f64| Left {
            ends: (0..1000).map(|k| scale * f64::from(k) / 900.0).collect(),
            ..left(vec![])
        };
        let (fair, poor, worst) = (of(1.0), of(1.2), of(3.0));
        let found = stretch(&[&fair, &worst, &poor]);
        assert!((found - 1.2 * 0.885 / 0.9).abs() < 0.01, "{found}");
        assert!(poor.covered(found).value() >= 0.88);
        assert_eq!((stretch(&[&fair, &fair]), stretch(&[&worst, &worst])), (1.0, MOST_STRETCH));
    }

    #[test]
    fn what_leaving_out_adds_is_counted_beyond_what_a_small_model_misses() {
        // Decisions of 95 %, so many of a hundred wrong, and as many that decide nothing.
        let with = |name: &str, wrong: usize| Left {
            name: name.to_owned(),
            ..left((0..100).flat_map(|k| [(3.0, k >= wrong, 1.0), (0.0, true, 1.0)]).collect())
        };
        let of = |wrong: usize| {
            let left = vec![with("", 2), with("a", wrong), with("b", wrong)];
            let confidence = confidence(&left.iter().collect::<Vec<_>>());
            Families { left, confidence, stretch: 1.0 }.excess_beyond(0.1, 0.9)
        };
        assert!((of(10) - 0.08).abs() < 1e-9 && of(2).abs() < 1e-9, "{} {}", of(10), of(2));
    }

    #[test]
    fn without_right_decisions_there_is_no_confidence() {
        let wrong =
            left((0..400).map(|k| (9.0 - 18.0 * f64::from(k % 2), k % 2 == 1, 1.0)).collect());
        let map = confidence(&[&wrong, &wrong, &wrong]);
        assert!(map.reported(1e-9) > 1.0 - SURE && map.reported(1.0 - 1e-9) < SURE);
    }

    #[test]
    fn families_of_one_class_are_completed() {
        let data = synthetic::dataset(1, 4000);
        let rows = (data.rows(0..3000), data.rows(3000..4000));
        let columns = [0, 1, 2, 3];
        let lesson = Lesson {
            data: &data,
            bins: &Bins::new(&data.values, &rows.0),
            monotone: &data.monotone(),
            columns: &columns,
            open: &columns,
            trained: &rows.0,
            calibrated: &rows.1,
            thorough: true,
        };
        let found = families(&lesson, |_| {}).unwrap();
        let of = |name: &str| found.left.iter().find(|each| each.name == name).unwrap();
        let healthy = of("cause: saturation");
        let weight = |hit: bool| -> f64 {
            let of_class = healthy.judged.iter().filter(|(_, truth, _)| *truth == hit);
            of_class.map(|(.., weight)| weight).sum()
        };
        let share = weight(true) / (weight(true) + weight(false));
        assert!((share - 0.45).abs() < 0.05, "{share}");
        // The question itself is not left out; another fault is, but does not count.
        assert!(found.left.iter().all(|each| each.name != "cause: sticking valve"));
        assert!(found.left.iter().all(|each| each.name != "cause: no response" || !each.counted));
        // A family like all others is judged like them.
        let first = of("process: first order");
        let scored: Vec<(f64, bool)> = first.judged.iter().map(|(l, hit, _)| (*l, *hit)).collect();
        assert!(auc(&scored) > 0.9, "{}", auc(&scored));
        assert!((first.covered(1.0).value() - COVERAGE).abs() < 0.06, "{}", first.covered(1.0));
        assert!(first.limit.value() > 0.88, "{}", first.limit);
        assert!(found.table().lines().count() > found.left.len() + 2);
    }
}
