//! Times in which an operator sets the OP, as in a test of the valve.
//!
//! # Method
//! By the mode, if it is recorded: each time in manual in which the OP is set at least twice.
//!
//! Otherwise by the OP. If it moves with nearly every sample, at least [`FEWEST_HELD`] consecutive levels of two
//! samples or more count as an operator's moves. Else at least [`FEWEST_TURNS`] consecutive levels count, each held
//! constant for four samples or more. Either at least four different sizes, where seven of ten steps reverse the last
//! one, and the levels lie around a value that moves little. Or a staircase of nearly one size and hold, in runs up and
//! down of at least [`FEWEST_STEPS`]. A coarse OP that creeps makes steps of one size, too, but holds them for any
//! time. Other times with alternating levels are included. A slow or coarse controller also does this, but its moves
//! follow from PV and SP (`law`), or its steps differ in size.

mod law;

use super::{Channel, Mode, Recording};
use crate::series::median;
use std::collections::HashMap;
use stiction_model::named;

/// Smallest number of reversals for a test recognised by its OP.
pub const FEWEST_TURNS: usize = 8;
/// Smallest number of steps of a staircase in one direction.
const FEWEST_STEPS: usize = 3;
/// Share of steps in such runs, and share of steps and holds that are equal; largest ratio of a step and of a hold to
/// their median.
const IN_RUNS: f64 = 0.8;
const ALIKE: (f64, f64) = (1.25, 1.5);
/// Smallest step of a staircase, percent.
const SMALLEST: f64 = 1.0;
/// Smallest step of a staircase that is not compared with a controller's law, percent, and the largest differences of
/// its steps and holds.
const EVEN: (f64, f64, f64) = (2.0, 0.05, 0.2);
/// Smallest number of samples of a held level.
const HELD: usize = 4;
/// Largest distance of a step's middle from the middle of this many steps on either side, as a share of the step.
const ASKEW: f64 = 0.35;
const BESIDE: usize = 4;
/// Samples between two levels.
const NEAR: usize = 2;
/// Fewest levels of an operator, and different ones among them, if the OP moves with nearly every other sample.
const FEWEST_HELD: usize = 6;
const FEWEST_DIFFERENT: usize = 3;
/// Fewest other samples, and the largest share of these samples that repeat the last sample.
const FEWEST_OUTSIDE: usize = 100;
const STILL: f64 = 0.1;
/// Share of steps that reverse the last one.
const TO_AND_FRO: f64 = 0.7;
/// Smallest number of reversals of another time in manual beside a test.
const FEWEST_BESIDE: usize = 3;
/// Number of different sizes, and their smallest difference.
const SIZES: usize = 4;
const DIFFERENT: f64 = 0.05;

/// An OP set by the operator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Set {
    /// Time, s on the recording's clock.
    pub at_s: f64,
    /// Value, percent; `None` when the controller took over.
    pub op: Option<f64>,
}

named! {
    /// How the manual setting was recognised.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum KnownBy {
        /// A sheet with notes on the test.
        Sheet = "sheet",
        /// The recorded mode.
        Mode = "mode",
        /// The pattern of the OP.
        #[default]
        Output = "output",
    }
}

/// The manual settings in order of time; each time in manual ends with a [`Set`] without an OP.
#[derive(Debug, Clone, PartialEq)]
pub struct ByHand {
    /// The settings.
    pub sets: Vec<Set>,
    /// How they were recognised.
    pub known_by: KnownBy,
}

impl ByHand {
    /// The manual settings in a recording; `None` without any.
    pub fn of(recording: &Recording) -> Option<Self> {
        let (sets, known_by) = match &recording.mode {
            Some(_) => (by_mode(recording), KnownBy::Mode),
            None => (by_output(recording), KnownBy::Output),
        };
        (!sets.is_empty()).then_some(Self { sets, known_by })
    }

    /// Number of settings.
    pub fn turns(&self) -> usize {
        self.sets.iter().filter(|set| set.op.is_some()).count()
    }

    /// The settings after the longest time in automatic between two times in manual; `None` if either side has fewer than
    /// [`FEWEST_TURNS`].
    pub fn after_pause(&self) -> Option<Self> {
        let ends = self.sets.windows(2).enumerate().filter(|(_, two)| two[0].op.is_none());
        let pause = |two: &[Set]| two[1].at_s - two[0].at_s;
        let (end, _) = ends.max_by(|a, b| pause(a.1).total_cmp(&pause(b.1)))?;
        let (before, after) = self.sets.split_at(end + 1);
        let part = |sets: &[Set]| Self { sets: sets.to_vec(), known_by: self.known_by };
        (part(before).turns() >= FEWEST_TURNS && part(after).turns() >= FEWEST_TURNS)
            .then(|| part(after))
    }

    /// The part of at most `most` consecutive settings whose turns have the most different sizes, the first of several;
    /// `None` if the number of settings does not exceed `most`. The sizes of a test differ, so a test among thousands
    /// of other settings is found.
    pub fn most_varied(&self, most: usize) -> Option<Self> {
        let places: Vec<usize> =
            (0..self.sets.len()).filter(|i| self.sets[*i].op.is_some()).collect();
        if places.len() <= most || most < 2 {
            return None;
        }
        // The class of the turn that leads to each setting, for a turn that reverses the last one.
        let turn = |k: usize| {
            let (a, b) = (self.sets.get(k.checked_sub(1)?)?.op?, self.sets[k].op?);
            Some(b - a)
        };
        let class = |k: usize| {
            let (last, this) = (turn(k.checked_sub(1)?)?, turn(k)?);
            (last * this < 0.0).then(|| (this.abs().ln() / DIFFERENT.ln_1p()).round() as i64)
        };
        let classes: Vec<Option<i64>> = places.iter().map(|k| class(*k)).collect();
        let mut counts: HashMap<i64, usize> = HashMap::new();
        let mut best = (0, 0);
        for (end, entered) in classes.iter().enumerate() {
            if let Some(entered) = entered {
                *counts.entry(*entered).or_default() += 1;
            }
            let left = end.checked_sub(most).and_then(|at| classes[at]);
            if let Some(left) = left {
                let count = counts.entry(left).or_default();
                *count -= 1;
                if *count == 0 {
                    counts.remove(&left);
                }
            }
            if end + 1 >= most && counts.len() > best.0 {
                best = (counts.len(), end + 1 - most);
            }
        }
        let (from, to) = (places[best.1], places[best.1 + most - 1]);
        let mut sets = self.sets[from..=to].to_vec();
        sets.extend(self.sets.get(to + 1).map(|next| Set { at_s: next.at_s, op: None }));
        Some(Self { sets, known_by: self.known_by })
    }

    /// Whether it looks like a test: [`FEWEST_TURNS`] or more steps, nearly all reversing the last one, or a
    /// [staircase](Self::is_staircase). An operator who runs a loop by hand moves in one direction for long.
    pub fn is_test(&self) -> bool {
        let op: Vec<f64> = self.sets.iter().filter_map(|set| set.op).collect();
        let turned = op.windows(3).filter(|o| (o[1] - o[0]) * (o[2] - o[1]) < 0.0).count();
        op.len() >= FEWEST_TURNS && 4 * turned >= 3 * (op.len() - 2) || self.is_staircase()
    }

    /// Whether the steps go up and down a staircase: runs of three or more in both directions, of nearly
    /// one size and hold.
    pub fn is_staircase(&self) -> bool {
        let spells = self.sets.split(|set| set.op.is_none());
        let steps = spells.flat_map(|sets| sets.windows(2)).filter_map(|two| {
            let [from, to] = [two[0].op?, two[1].op?];
            (to != from).then_some((two[1].at_s - two[0].at_s, to - from))
        });
        is_staircase(&steps.collect::<Vec<_>>())
    }

    /// Time of the first setting and end of the last one, s on the recording's clock.
    pub fn span_s(&self) -> (f64, f64) {
        let at = |set: Option<&Set>| set.map_or(0.0, |set| set.at_s);
        (at(self.sets.first()), at(self.sets.last()))
    }
}

/// Times and values of the usable samples, percent, in order of time.
fn usable(op: &Channel) -> Vec<(f64, f64)> {
    let percent = |v: f64| op.range.map_or(v, |range| range.percent(v));
    let all = op.time.iter().zip(&op.values).zip(&op.quality);
    let mut samples: Vec<(f64, f64)> = all
        .filter(|(_, quality)| quality.is_usable())
        .map(|((t, v), _)| (*t, percent(*v)))
        .collect();
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    samples
}

fn by_mode(recording: &Recording) -> Vec<Set> {
    let Some(modes) = &recording.mode else { return vec![] };
    let op = usable(&recording.op);
    let Some((last, _)) = op.last().copied() else { return vec![] };
    let mut all = vec![];
    for (k, mode) in modes.modes.iter().enumerate() {
        if *mode != Mode::Manual {
            continue;
        }
        // Manual continues if the next time is manual, too.
        if k > 0 && modes.modes[k - 1] == Mode::Manual {
            continue;
        }
        let from = modes.time[k];
        let next = (k + 1..modes.modes.len()).find(|i| modes.modes[*i] != Mode::Manual);
        let to = next.map_or(last, |i| modes.time[i]);
        let at = |time: f64| op.partition_point(|(t, _)| *t < time);
        let sets = levels(op.get(at(from)..at(to)).unwrap_or_default());
        if sets.len() >= 2 {
            all.extend(sets.iter().map(|(at, op)| Set { at_s: *at, op: Some(*op) }));
            all.push(Set { at_s: to, op: None });
        }
    }
    all
}

/// The levels of an OP, with their start times: a change that continues in the next sample is one.
fn levels(op: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = vec![];
    let mut moving = false;
    for (k, (t, v)) in op.iter().enumerate() {
        let changed = k == 0 || (v - op[k - 1].1).abs() > 1e-9;
        match all.last_mut() {
            Some(last) if changed && moving => last.1 = *v,
            _ if changed => all.push((*t, *v)),
            _ => {}
        }
        moving = changed && k > 0;
    }
    all
}

/// A level of the OP.
#[derive(Debug, Clone, Copy)]
struct Level {
    from: usize,
    to: usize,
    op: f64,
}

fn by_output(recording: &Recording) -> Vec<Set> {
    let op = usable(&recording.op);
    let still = among_moves(&op);
    let chains = if still.is_empty() { by_pattern(&op, recording) } else { still };
    let mut sets = vec![];
    for chain in chains {
        sets.extend(chain.iter().map(|level| Set { at_s: op[level.from].0, op: Some(level.op) }));
        let to = chain.last().map_or(0, |last| last.to);
        sets.push(Set { at_s: op[to.min(op.len() - 1)].0, op: None });
    }
    sets
}

/// Levels of at least this many samples, with at most this many samples between two levels of a chain.
fn chains(op: &[(f64, f64)], samples: usize, between: usize) -> Vec<Vec<Level>> {
    let mut held: Vec<Level> = vec![];
    let mut first = 0;
    for run in op.chunk_by(|a, b| is_still(&[*a, *b])) {
        let to = first + run.len();
        if run.len() >= samples {
            held.push(Level { from: first, to, op: run[0].1 });
        }
        first = to;
    }
    held.chunk_by(|a, b| b.from <= a.to + between).map(<[Level]>::to_vec).collect()
}

fn is_still(two: &[(f64, f64)]) -> bool {
    (two[0].1 - two[1].1).abs() <= 1e-9
}

/// The chains of at least [`FEWEST_HELD`] levels, if the OP moves with nearly every other sample.
fn among_moves(op: &[(f64, f64)]) -> Vec<Vec<Level>> {
    let mut chains = chains(op, 2, 1);
    chains.retain(|chain| {
        let mut levels: Vec<f64> = chain.iter().map(|level| level.op).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        chain.len() >= FEWEST_HELD && levels.len() >= FEWEST_DIFFERENT
    });
    let mut outside = vec![true; op.len()];
    for chain in &chains {
        outside[chain[0].from..chain[chain.len() - 1].to].fill(false);
    }
    let pairs = || op.windows(2).zip(&outside).filter(|(_, outside)| **outside);
    let still = pairs().filter(|(two, _)| is_still(two)).count();
    let moves =
        pairs().count() >= FEWEST_OUTSIDE && (still as f64) < STILL * pairs().count() as f64;
    if moves { chains } else { vec![] }
}

/// The chains of levels that no controller would make, and beside one of them the times with alternating levels.
fn by_pattern(op: &[(f64, f64)], recording: &Recording) -> Vec<Vec<Level>> {
    let mut chains = chains(op, HELD, NEAR);
    let [pv, sp] =
        [&recording.pv, &recording.sp].map(|channel| channel.as_ref().map_or(vec![], usable));
    let by_operator = |chain: &Vec<Level>| {
        let staircase = goes_up_and_down(chain);
        (is_test(chain) || staircase)
            && (staircase && is_even(chain) || !law::is_obeyed(chain, op, &pv, &sp))
    };
    if !chains.iter().any(by_operator) {
        return vec![];
    }
    chains.retain(|chain| goes_to_and_fro(chain) || goes_up_and_down(chain));
    chains
}

/// Steps of a chain, percent.
fn turns(chain: &[Level]) -> Vec<f64> {
    chain.windows(2).map(|two| two[1].op - two[0].op).collect()
}

/// Whether levels alternate, except for a few that brought the PV back.
fn goes_to_and_fro(chain: &[Level]) -> bool {
    let turns = turns(chain);
    let back = turns.windows(2).filter(|two| two[0] * two[1] < 0.0).count();
    turns.len() >= FEWEST_BESIDE && back as f64 >= TO_AND_FRO * (turns.len() - 1) as f64
}

/// Whether the levels form a staircase.
fn goes_up_and_down(chain: &[Level]) -> bool {
    let steps =
        chain.windows(2).map(|two| ((two[1].from - two[0].from) as f64, two[1].op - two[0].op));
    is_staircase(&steps.collect::<Vec<_>>())
}

/// Whether all steps have one size and all holds one length, which hardly any controller makes.
fn is_even(chain: &[Level]) -> bool {
    let sizes: Vec<f64> = turns(chain).iter().map(|turn| turn.abs()).collect();
    // The first hold may have begun long before.
    let holds: Vec<f64> =
        chain[1..].windows(2).map(|two| (two[1].from - two[0].from) as f64).collect();
    let even = |values: &[f64], by: f64| {
        let usual = median(values);
        values.iter().all(|value| (value - usual).abs() <= by * usual)
    };
    median(&sizes) >= EVEN.0 && even(&sizes, EVEN.1) && even(&holds, EVEN.2)
}

/// Whether steps, each with the hold before it, go up and down in runs, and are nearly of one size and hold.
fn is_staircase(steps: &[(f64, f64)]) -> bool {
    if steps.len() < 2 * FEWEST_STEPS {
        return false;
    }
    let runs: Vec<&[(f64, f64)]> = steps.chunk_by(|a, b| a.1 * b.1 > 0.0).collect();
    let long = || runs.iter().filter(|run| run.len() >= FEWEST_STEPS);
    let within: usize = long().map(|run| run.len()).sum();
    let both = long().any(|run| run[0].1 > 0.0) && long().any(|run| run[0].1 < 0.0);
    let (holds, sizes): (Vec<f64>, Vec<f64>) =
        steps.iter().map(|(hold, step)| (*hold, step.abs())).unzip();
    let alike = |values: &[f64], ratio: f64| {
        let usual = median(values);
        values.iter().filter(|value| (usual / ratio..=usual * ratio).contains(*value)).count()
    };
    let most = |count: usize| count as f64 >= IN_RUNS * steps.len() as f64;
    both && most(within)
        && most(alike(&sizes, ALIKE.0))
        && most(alike(&holds, ALIKE.1))
        && median(&sizes) >= SMALLEST
}

/// Whether levels alternate, lie around a value that moves little from step to step, and differ in size.
fn is_test(chain: &[Level]) -> bool {
    if chain.len() <= FEWEST_TURNS || !goes_to_and_fro(chain) {
        return false;
    }
    let middles: Vec<f64> = chain.windows(2).map(|two| 0.5 * (two[0].op + two[1].op)).collect();
    let mut sizes: Vec<f64> = turns(chain).iter().map(|turn| turn.abs()).collect();
    let askew = (0..middles.len()).filter(|k| {
        let near = &middles[k.saturating_sub(BESIDE)..(k + BESIDE + 1).min(middles.len())];
        (middles[*k] - median(near)).abs() > ASKEW * sizes[*k]
    });
    let few = 4 * askew.count() <= middles.len();
    sizes.sort_by(f64::total_cmp);
    let different = 1 + sizes.windows(2).filter(|s| s[1] > (1.0 + DIFFERENT) * s[0]).count();
    few && different >= SIZES
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Modes;

    /// 50 samples that follow an error, then turns of growing size, then 50 again.
    fn op(turns: usize) -> Vec<f64> {
        let wanders = |k: usize| 40.0 + (0.37 * k as f64).sin();
        let mut op: Vec<f64> = (0..50).map(wanders).collect();
        for turn in 0..turns {
            let size = 0.3 * 1.3f64.powi(turn as i32);
            op.extend([40.0 + if turn % 2 == 0 { size } else { -size }; 6]);
        }
        op.extend((0..50).map(wanders));
        op
    }

    #[test]
    fn a_test_is_found_by_what_the_op_does() {
        let recording = Recording::regular("", 2.0, &op(12), None, None).unwrap();
        let found = ByHand::of(&recording).unwrap();
        assert_eq!((found.turns(), found.known_by), (12, KnownBy::Output));
        assert_eq!(found.span_s(), (100.0, 100.0 + 2.0 * 72.0));
        assert!(found.is_test());
        assert_eq!(found.sets[3].op, Some(40.0 - 0.3 * 1.3f64.powi(3)));
        // Fewer, or none, are not one.
        for turns in [0, 3, FEWEST_TURNS - 1] {
            let recording = Recording::regular("", 2.0, &op(turns), None, None).unwrap();
            assert_eq!(ByHand::of(&recording), None, "{turns}");
        }
    }

    #[test]
    fn short_holds_are_found_where_the_op_otherwise_moves() {
        let of = |op: &[f64]| {
            let recording = Recording::regular("", 2.0, op, None, None).unwrap();
            ByHand::of(&recording).map(|found| found.turns())
        };
        let wanders = |k: usize| 40.0 + (0.37 * k as f64).sin();
        let moves: Vec<f64> = (0..100).map(wanders).collect();
        for levels in [5, 6, 9] {
            let holds = (0..2 * levels).map(|k| [40.0, 43.0, 41.0, 42.0][k / 2 % 4]);
            let op: Vec<f64> = moves.iter().copied().chain(holds).chain(moves.clone()).collect();
            assert_eq!(of(&op), (levels >= 6).then_some(levels));
            // A coarse OP rests by itself.
            let coarse: Vec<f64> = op.iter().map(|v| v.round()).collect();
            assert_eq!(of(&coarse), None);
        }
    }

    #[test]
    fn a_staircase_up_and_down_is_a_test() {
        let steps = |k: usize| [0, 1, 2, 3, 4, 5, 4, 3, 2, 1, 0][k / 8] as f64;
        for (size, found) in [(5.0, true), (0.2, false)] {
            let op: Vec<f64> = (0..88).map(|k| 40.0 + size * steps(k)).collect();
            let recording = Recording::regular("", 2.0, &op, None, None).unwrap();
            let by_hand = ByHand::of(&recording);
            assert_eq!(by_hand.is_some(), found);
            if let Some(by_hand) = by_hand {
                assert!(by_hand.turns() == 11 && by_hand.is_staircase() && by_hand.is_test());
            }
        }
    }

    #[test]
    fn what_has_one_size_or_goes_one_way_is_no_test() {
        let square: Vec<f64> = (0..200).map(|k| if k / 8 % 2 == 0 { 40.0 } else { 42.0 }).collect();
        let stairs: Vec<f64> = (0..200).map(|k| 40.0 + f64::from(k / 8)).collect();
        for op in [square, stairs] {
            let recording = Recording::regular("", 2.0, &op, None, None).unwrap();
            assert_eq!(ByHand::of(&recording), None);
        }
    }

    #[test]
    fn a_test_among_thousands_of_settings_is_found() {
        let set = |at: usize, op: Option<f64>| Set { at_s: at as f64, op };
        let square = |k: usize| set(k, Some(if k.is_multiple_of(2) { 40.0 } else { 42.0 }));
        let mut sets: Vec<Set> = (0..3000).map(square).collect();
        for (k, set) in sets[1000..1020].iter_mut().enumerate() {
            let size = 0.3 * 1.3f64.powi(k as i32);
            set.op = Some(41.0 + if k.is_multiple_of(2) { size } else { -size });
        }
        sets.push(set(3000, None));
        let by_hand = ByHand { sets, known_by: KnownBy::Mode };
        let part = by_hand.most_varied(50).unwrap();
        let (from, to) = part.span_s();
        assert!(part.turns() == 50 && from <= 1000.0 && to >= 1020.0, "{from} to {to}");
        assert_eq!(part.sets.last().unwrap().op, None);
        assert_eq!((part.most_varied(50), by_hand.most_varied(3000)), (None, None));
    }

    #[test]
    fn a_loop_that_is_run_by_hand_is_not_tested() {
        let op: Vec<f64> = (0..200).map(|k| 40.0 + f64::from(k / 10) * 0.5).collect();
        let mut recording = Recording::regular("", 2.0, &op, None, None).unwrap();
        recording.mode = Some(Modes { time: vec![0.0], modes: vec![Mode::Manual] });
        let found = ByHand::of(&recording).unwrap();
        assert!(found.turns() == 20 && !found.is_test());
    }

    #[test]
    fn times_in_manual_are_found_by_the_mode() {
        let mut op = op(2);
        // It moves to the second level in three samples.
        op[56..58].copy_from_slice(&[40.1, 39.9]);
        let mut recording = Recording::regular("", 2.0, &op, None, None).unwrap();
        recording.mode = Some(Modes {
            time: vec![0.0, 100.0, 124.0],
            modes: vec![Mode::Automatic, Mode::Manual, Mode::Automatic],
        });
        let found = ByHand::of(&recording).unwrap();
        assert_eq!(found.known_by, KnownBy::Mode);
        let at: Vec<f64> = found.sets.iter().map(|set| set.at_s).collect();
        assert_eq!(at, [100.0, 112.0, 124.0]);
        assert_eq!(found.sets[1].op, Some(40.0 - 0.39));
        assert!(!found.is_test());
        // In automatic throughout nothing was set by hand.
        recording.mode = Some(Modes { time: vec![0.0], modes: vec![Mode::Automatic] });
        assert_eq!(ByHand::of(&recording), None);
    }
}
