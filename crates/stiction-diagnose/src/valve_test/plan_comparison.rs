//! Compares a test with its plan.
//!
//! The sizes of a test are found from the manual settings: consecutive turns of equal size around the same OP form one
//! size. Sizes up to the largest are part 1, and the remaining sizes part 2. A size of part 1 is matched to the nearest
//! size of the plan. A size of part 2 is compared with the size before it.
//!
//! # Limits
//! The end of part 1 and the holds of part 2 depend on the answers that the operator saw. They are not recorded, so
//! only the sizes and the end of part 2 are compared.

use super::plan::TestPlan;
use super::read::Step;
use super::weigh::Manual;
use crate::series::{max, min};
use crate::spoken::{counted, range, rough, time, times};

/// A size of turns in the plan and in the test.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct SizeComparison {
    /// The part of the test: 1 with growing sizes, 2 with shrinking sizes.
    pub part: u8,
    /// The planned size, percent from one turn to the next; `None` if the plan lacks the size.
    pub planned: Option<f64>,
    /// The actual size, percent; `None` if the test lacks the size.
    pub made: Option<f64>,
    /// Number of turns of this size in the test.
    pub turns: usize,
    /// Number of turns of this size to which the PV responded.
    pub answered: usize,
    /// The longest planned hold, s; `None` in part 2, where the hold depends on the responses.
    pub hold_planned_s: Option<f64>,
    /// The longest actual hold, s; `None` if the test lacks the size.
    pub hold_s: Option<f64>,
}

/// A test compared with its plan.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct PlanComparison {
    /// The sizes of turns, in the order of the test or of the plan.
    pub sizes: Vec<SizeComparison>,
    /// Number of planned turns of the compared sizes.
    pub turns_planned: usize,
    /// Number of turns in the test.
    pub turns: usize,
    /// Number of turns of part 1 that ended before the planned hold, although the PV had not responded.
    pub cut_short: usize,
    /// Number of turns of part 1 that were held longer than planned.
    pub held_longer: usize,
    /// Time in the test with the PV outside the limits of the plan, s.
    pub pv_beyond_s: f64,
    /// The lowest PV of the test, in PV units.
    pub pv_low: f64,
    /// The highest PV of the test, in PV units.
    pub pv_high: f64,
    /// Deviations from the plan in sentences, or a sentence that there are no deviations.
    pub remarks: Vec<String>,
}

/// Largest relative difference between turns of one size, and between a size of part 1 and the plan.
const ALIKE: f64 = 0.07;
const NEAR: f64 = 0.15;
/// Accuracy of an OP setting, percent.
const SETTING: f64 = 0.02;
/// A hold is too short or too long if its ratio to the plan is outside these bounds, with a tolerance of two samples.
const SHORTER: f64 = 0.8;
const LONGER: f64 = 1.25;

/// Consecutive turns of one size.
#[derive(Debug, Clone, Copy)]
struct Made {
    size: f64,
    turns: usize,
    answered: usize,
    longest_s: f64,
}

/// A turn in the test.
#[derive(Debug, Clone, Copy)]
struct Turned {
    size: f64,
    hold_s: f64,
    /// Whether the PV answered during the hold, by the plan.
    moved: bool,
    /// Whether the test ended because the controller took over.
    last: bool,
    answered: bool,
}

/// Compares a test with its plan. `spells` are the recorded times in manual with a sample every `dt` s, and `steps` are
/// their turns with the answers.
pub(super) fn compared(
    plan: &TestPlan,
    spells: &[(Vec<f64>, Manual)],
    steps: &[Step],
    dt: f64,
) -> PlanComparison {
    let mut turned = vec![];
    let mut seen = steps.iter().map(|step| step.answered);
    for (_, manual) in spells {
        turned.extend(of_spell(plan, manual, dt, &mut seen));
    }
    let made = grouped(&turned);
    let (sizes, of_turn) = aligned(plan, &made);
    let pv = || spells.iter().flat_map(|(_, manual)| manual.pv.iter().copied());
    let values: Vec<f64> = pv().collect();
    let outside = pv().filter(|v| *v < plan.pv_low || *v > plan.pv_high).count();
    let (mut cut_short, mut held_longer) = (0, 0);
    let holds = of_turn.iter().zip(&turned).filter_map(|(hold, turn)| Some(((*hold)?, turn)));
    for (hold_s, turn) in holds {
        let short = turn.hold_s < SHORTER * hold_s - 2.0 * dt;
        cut_short += usize::from(short && !turn.moved && !turn.last);
        held_longer += usize::from(turn.hold_s > LONGER * hold_s + 2.0 * dt);
    }
    let mut all = PlanComparison {
        turns_planned: plan.each * sizes.iter().filter(|size| size.planned.is_some()).count(),
        turns: turned.len(),
        cut_short,
        held_longer,
        pv_beyond_s: outside as f64 * dt,
        pv_low: min(&values),
        pv_high: max(&values),
        sizes,
        remarks: vec![],
    };
    all.remarks = remarks(&all, plan, spells, dt);
    all
}

/// The turns of a time in manual.
fn of_spell(
    plan: &TestPlan,
    manual: &Manual,
    dt: f64,
    seen: &mut impl Iterator<Item = bool>,
) -> Vec<Turned> {
    let centres = centres(&manual.turns);
    let mut all = vec![];
    for (i, ((at, op), middle)) in manual.turns.iter().zip(centres).enumerate() {
        let until = manual.turns.get(i + 1).map_or(manual.pv.len(), |next| next.0);
        // The answer may be in the sample at which the next turn begins.
        let held = &manual.pv[*at..(until + 1).clamp(*at, manual.pv.len())];
        let from = held.first().copied().unwrap_or(0.0);
        let answered = seen.next().unwrap_or(false);
        // The return to the centre is no size.
        if (op - middle).abs() <= SETTING {
            continue;
        }
        all.push(Turned {
            size: 2.0 * (op - middle).abs(),
            hold_s: until.saturating_sub(*at) as f64 * dt,
            moved: held.iter().any(|v| (v - from).abs() >= 0.9 * plan.answer),
            last: i + 1 == manual.turns.len(),
            answered,
        });
    }
    all
}

/// The centre of each turn, which the operator may shift: the most frequent middle of two consecutive turns among those with its
/// neighbours, or if each of these occurs once, among those with the next but one, too.
fn centres(turns: &[(usize, f64)]) -> impl Iterator<Item = f64> {
    let middles: Vec<f64> = turns.windows(2).map(|two| 0.5 * (two[0].1 + two[1].1)).collect();
    (0..turns.len()).map(move |i| {
        let near = |m: f64| middles.iter().filter(|other| (**other - m).abs() <= SETTING).count();
        let best = |reach: usize| {
            let of = &middles[i.saturating_sub(reach)..(i + reach).min(middles.len())];
            of.iter().fold((0.0, 0), |best, m| match near(*m) {
                count if count > best.1 => (*m, count),
                _ => best,
            })
        };
        let beside = best(1);
        if beside.1 > 1 { beside.0 } else { best(2).0 }
    })
}

fn alike(a: f64, b: f64) -> bool {
    (a - b).abs() <= ALIKE * a.max(b) + SETTING
}

fn grouped(turned: &[Turned]) -> Vec<Made> {
    let mut all: Vec<Made> = vec![];
    for turn in turned {
        match all.last_mut() {
            Some(last) if alike(last.size, turn.size) => {
                last.turns += 1;
                last.answered += usize::from(turn.answered);
                last.longest_s = last.longest_s.max(turn.hold_s);
            }
            _ => all.push(Made {
                size: turn.size,
                turns: 1,
                answered: usize::from(turn.answered),
                longest_s: turn.hold_s,
            }),
        }
    }
    all
}

/// The sizes of plan and test, and the planned hold of each turn, s.
fn aligned(plan: &TestPlan, made: &[Made]) -> (Vec<SizeComparison>, Vec<Option<f64>>) {
    let planned: Vec<(f64, f64)> =
        plan.grow.chunks(plan.each).map(|two| (2.0 * two[0].op.abs(), two[0].hold_s)).collect();
    // The first of equal sizes, because those of part 2 are smaller.
    let top = made.iter().enumerate().fold(0, |top, (k, m)| match m.size > made[top].size {
        true => k,
        false => top,
    });
    let row = |part, planned: Option<(f64, Option<f64>)>, made: Option<&Made>| SizeComparison {
        part,
        planned: planned.map(|(size, _)| size),
        made: made.map(|m| m.size),
        turns: made.map_or(0, |m| m.turns),
        answered: made.map_or(0, |m| m.answered),
        hold_planned_s: planned.and_then(|(_, hold)| hold),
        hold_s: made.map(|m| m.longest_s),
    };
    let (mut rows, mut holds, mut next) = (vec![], vec![], 0);
    let grown = made.len().min(top + 1);
    for m in &made[..grown] {
        let near = (next..planned.len()).find(|k| (planned[*k].0 / m.size).ln().abs() <= NEAR);
        let of = near.map(|k| (planned[k].0, Some(planned[k].1)));
        if let Some(k) = near {
            let left = planned[next..k].iter().map(|(size, hold)| (*size, Some(*hold)));
            rows.extend(left.map(|of| row(1, Some(of), None)));
            next = k + 1;
        }
        rows.push(row(1, of, Some(m)));
        holds.extend(vec![of.and_then(|(_, hold)| hold); m.turns]);
    }
    let mut last = made.get(top).map_or(0.0, |m| m.size);
    for m in &made[grown..] {
        let (one, two) = (plan.shrink_by * last, plan.shrink_by.powi(2) * last);
        let of = match () {
            () if alike(m.size, one) => Some((one, None)),
            () if alike(m.size, two) => {
                rows.push(row(2, Some((one, None)), None));
                Some((two, None))
            }
            () => None,
        };
        rows.push(row(2, of, Some(m)));
        holds.extend(vec![None; m.turns]);
        last = m.size;
    }
    (rows, holds)
}

fn remarks(
    of: &PlanComparison,
    plan: &TestPlan,
    spells: &[(Vec<f64>, Manual)],
    dt: f64,
) -> Vec<String> {
    let unit = plan.pv_unit.as_deref().map_or(String::new(), |unit| format!(" {unit}"));
    let listed = |sizes: Vec<f64>| sizes.into_iter().map(rough).collect::<Vec<_>>().join(", ");
    let sizes = |wanted: &dyn Fn(&SizeComparison) -> Option<f64>| -> Vec<f64> {
        of.sizes.iter().filter_map(wanted).collect()
    };
    let left_out = sizes(&|size| size.planned.filter(|_| size.made.is_none()));
    // A size that is made again is planned.
    let is_planned = |made: f64| plan.grow.iter().any(|turn| alike(2.0 * turn.op.abs(), made));
    let other =
        sizes(&|size| size.made.filter(|made| size.planned.is_none() && !is_planned(*made)));
    let fewer = sizes(&|size| size.made.filter(|_| size.turns < plan.each));
    let mut all = vec![];
    if !left_out.is_empty() {
        all.push(format!("These sizes of the plan were left out: {} %.", listed(left_out)));
    }
    if !other.is_empty() {
        all.push(format!("These sizes are not in the plan: {} %.", listed(other)));
    }
    if !fewer.is_empty() {
        all.push(format!(
            "These sizes had fewer than {}: {} %.",
            counted(plan.each, "turn"),
            listed(fewer)
        ));
    }
    if of.cut_short > 0 {
        all.push(format!(
            "{} of part 1 ended before the planned hold, although the PV had not answered.",
            counted(of.cut_short, "turn")
        ));
    }
    if of.held_longer > 0 {
        all.push(format!(
            "{} of part 1 lasted longer than the planned hold.",
            counted(of.held_longer, "turn")
        ));
    }
    all.extend(end(of, plan));
    let stops = spells.len().saturating_sub(1);
    if stops > 0 {
        all.push(format!("The controller was in automatic {} between turns.", times(stops)));
    }
    if of.pv_beyond_s > 0.0 {
        let far = if of.pv_high > plan.pv_high { of.pv_high } else { of.pv_low };
        all.push(format!(
            "The PV was outside the limits of the plan ({}{unit}) for {} and reached {}{unit}.",
            range(plan.pv_low, plan.pv_high),
            time(of.pv_beyond_s),
            rough(far)
        ));
    }
    let op = || spells.iter().flat_map(|(_, manual)| &manual.turns).map(|(_, op)| *op);
    let beyond = |op: &f64| *op < plan.op_low - SETTING || *op > plan.op_high + SETTING;
    let outside = op().filter(beyond).count();
    if outside > 0 {
        all.push(format!(
            "The OP was set outside the limits of the plan ({} %) {}.",
            range(plan.op_low, plan.op_high),
            times(outside)
        ));
    }
    if dt > 1.05 * plan.record_every_s {
        all.push(format!(
            "The recording has a sample every {}, but the plan asks for one every {}.",
            time(dt),
            time(plan.record_every_s)
        ));
    }
    if all.is_empty() {
        all.push("The test was carried out as planned.".to_owned());
    }
    all
}

/// The remark on the end of part 2, if it differs from the plan.
fn end(of: &PlanComparison, plan: &TestPlan) -> Option<String> {
    let second: Vec<&SizeComparison> =
        of.sizes.iter().filter(|size| size.part == 2 && size.made.is_some()).collect();
    let Some(last) = second.last() else {
        return Some("Part 2 was not carried out.".to_owned());
    };
    let silent = second.iter().rev().take_while(|size| size.answered == 0).count();
    // Part 2 may also end at the smallest planned turn.
    let smallest = last.made.is_some_and(|made| made <= plan.grow[0].op.abs() * 2.0);
    (silent < plan.ends_after && !smallest).then(|| {
        format!(
            "Part 2 ended after {} without an answer, but the plan asks for {}.",
            counted(silent, "size"),
            plan.ends_after
        )
    })
}

/// Whether two names belong to the same loop. A recording often has the name of its file, so a word may follow the tag
/// after a separator, as in `FIC106-tested`. Case is ignored.
pub fn same_loop(a: &str, b: &str) -> bool {
    tag(a).eq_ignore_ascii_case(tag(b))
}

/// Shortest word after a separator that is not part of a tag, letters.
const WORD: usize = 3;

fn tag(name: &str) -> &str {
    match name.trim().rsplit_once(['-', '_', '.', ' ']) {
        Some((tag, word))
            if word.len() >= WORD
                && word.bytes().all(|byte| byte.is_ascii_alphabetic())
                && tag.bytes().any(|byte| byte.is_ascii_digit()) =>
        {
            tag
        }
        _ => name.trim(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::valve_test::Turn;

    fn plan() -> TestPlan {
        let halves = [0.2, 0.32, 0.51, 0.82, 1.3, 2.1];
        let both = |half: &f64| [*half, -half].map(|op| Turn { op, hold_s: 40.0 });
        TestPlan {
            name: "FIC1".to_owned(),
            pv_unit: Some("m3/h".to_owned()),
            each: 2,
            grow: halves.iter().flat_map(both).collect(),
            shrink_by: 0.85,
            ends_after: 3,
            answer: 1.0,
            rises: Some(true),
            pv_low: -5.0,
            pv_high: 5.0,
            op_low: 40.0,
            op_high: 60.0,
            record_every_s: 5.0,
            total_s: 480.0,
            expected_s: 240.0,
            summary: String::new(),
            instructions: vec![],
        }
    }

    /// Turns about 50 %, each as long as `held` says, samples; the PV goes along with those of 1.6 % and more.
    fn made(sizes: &[(f64, usize)], held: usize) -> (Vec<(Vec<f64>, Manual)>, Vec<Step>) {
        let (mut turns, mut pv, mut steps) = (vec![], vec![], vec![]);
        let mut up = true;
        for (size, count) in sizes {
            for _ in 0..*count {
                let op = 50.0 + if up { 0.5 * size } else { -0.5 * size };
                turns.push((pv.len(), op));
                let answers = *size >= 1.6;
                let moves = if answers { *size } else { 0.0 };
                let from = pv.last().copied().unwrap_or(0.0);
                pv.push(from);
                pv.extend(vec![if up { moves } else { -moves }; held - 1]);
                let (answer, error) = (Some(moves), Some(0.1));
                steps.push(Step {
                    at_s: 0.0,
                    op,
                    travel: Some(*size),
                    answer,
                    error,
                    answered: answers,
                });
                up = !up;
            }
        }
        (vec![(vec![], Manual { pv, before: 50.0, turns })], steps)
    }

    const AS_PLANNED: [(f64, usize); 8] =
        [(0.4, 2), (0.64, 2), (1.02, 2), (1.64, 4), (1.394, 2), (1.185, 2), (1.007, 2), (0.856, 2)];

    fn remarks_of(sizes: &[(f64, usize)], held: usize, plan: &TestPlan) -> PlanComparison {
        let (spells, steps) = made(sizes, held);
        compared(plan, &spells, &steps, 5.0)
    }

    #[test]
    fn what_is_done_by_the_plan_has_no_remark() {
        let found = remarks_of(&AS_PLANNED, 8, &plan());
        assert_eq!(found.remarks, ["The test was carried out as planned."], "{found:?}");
        assert_eq!((found.turns, found.turns_planned, found.sizes.len()), (18, 16, 8));
        assert!(found.sizes.iter().all(|size| size.planned.is_some() && size.made.is_some()));
        assert_eq!(found.sizes[3].answered, 4);
    }

    #[test]
    fn a_centre_that_the_operator_shifts_changes_no_size() {
        let (mut spells, steps) = made(&AS_PLANNED, 8);
        spells[0].1.turns.iter_mut().skip(4).for_each(|(_, op)| *op += 1.3);
        let found = compared(&plan(), &spells, &steps, 5.0);
        assert_eq!(found.remarks, ["The test was carried out as planned."], "{found:?}");
        // A size of its own is still one.
        spells[0].1.turns.iter_mut().skip(4).step_by(2).take(1).for_each(|(_, op)| *op += 0.5);
        let found = compared(&plan(), &spells, &steps, 5.0);
        assert_ne!(found.remarks, ["The test was carried out as planned."], "{found:?}");
    }

    #[test]
    fn what_is_done_otherwise_is_reported() {
        let mut sizes = AS_PLANNED.to_vec();
        // 0.64 % is left out, 1.02 % becomes 0.8 %, and one turn of it alone.
        sizes[2] = (0.8, 1);
        sizes.remove(1);
        sizes.truncate(4);
        let mut plan = plan();
        (plan.pv_high, plan.record_every_s, plan.op_high) = (1.0, 2.0, 50.5);
        let found = remarks_of(&sizes, 4, &plan);
        for part in [
            "left out: 0.64, 1 %",
            "not in the plan: 0.8 %",
            "These sizes had fewer than 2 turns: 0.8 %",
            "2 turns of part 1 ended before the planned hold",
            "Part 2 ended after 1 size without an answer, but the plan asks for 3.",
            "The PV was outside the limits of the plan (-5.0 to 1.0 m3/h) for ",
            "and reached 1.6 m3/h",
            "The OP was set outside the limits of the plan (40 to 50 %) 3 times",
            "The recording has a sample every 5 s, but the plan asks for one every 2 s.",
        ] {
            assert!(found.remarks.iter().any(|r| r.contains(part)), "{part}: {found:#?}");
        }
        let long = remarks_of(&AS_PLANNED[..4], 20, &self::plan());
        let wanted = [
            "10 turns of part 1 lasted longer than the planned hold.",
            "Part 2 was not carried out.",
        ];
        assert_eq!(long.remarks, wanted);
    }

    #[test]
    fn a_loop_is_known_by_its_tag() {
        for (a, b, same) in [
            ("FIC106", "fic106", true),
            ("FIC106-tested", "FIC106-repaired", true),
            ("FIC-106", "FIC-106_test", true),
            ("FIC-106", "FIC-107", false),
            ("FIC106-A", "FIC106-B", false),
            ("FIC101-sticky", "FIC106-tested", false),
            ("level-tank", "level-drum", false),
        ] {
            assert_eq!(same_loop(a, b), same, "{a} {b}");
        }
    }
}
