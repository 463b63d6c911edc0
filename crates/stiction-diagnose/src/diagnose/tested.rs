//! The verdict from a valve test in the recording.

use super::change::present_since;
use super::verdict::{Basis, Limit, Stiction, Verdict, VerdictClass, Votes};
use super::weighing::Weighing;
use crate::fusion::{COVERAGE, LIMIT};
use crate::recording::{ByHand, GridOptions, KnownBy, Recording};
use crate::spoken::{percent, time};
use crate::valve_test::{ReadOptions, TestReading, by_ramps, read};

/// The test in a recording, as `stiction test read` finds it. It is `None` without a readable test, or if the valve
/// changed after the test. Settings that hardly look like a test, as in a loop that is controlled by hand, count as a
/// test only if they decide.
pub(super) fn tested(
    recording: &Recording,
    grid: GridOptions,
    weighing: Option<&Weighing>,
) -> Option<TestReading> {
    let test = match by_ramps(recording, &grid) {
        // A controller ramps the OP, too.
        Some(ramps) => Some(TestReading::from(ramps)).filter(|of| of.known_by == KnownBy::Mode)?,
        None => read(recording, &ReadOptions { grid, ..ReadOptions::default() }).ok()?,
    };
    let decides = test.class != VerdictClass::CannotTell;
    let is_test = decides || ByHand::of(recording).is_some_and(|by_hand| by_hand.is_test());
    let changed = weighing.map_or(f64::NEG_INFINITY, |of| present_since(&of.changes));
    (is_test && changed < test.to_s).then_some(test)
}

/// The verdict from a test that decides, whose probability includes the operation before it; `None` otherwise. Without a mode a
/// controller may have moved the OP: one of 1,000 simulated recordings of operation looks like a test.
pub(super) fn by_test(test: &TestReading, votes: Votes) -> Option<Verdict> {
    if test.class == VerdictClass::CannotTell || test.known_by != KnownBy::Mode {
        return None;
    }
    let cleared = test.class == VerdictClass::DoesNotStick;
    Some(Verdict {
        class: test.class,
        probability: Some(test.probability),
        basis: Basis::ValveTest,
        s_below: test.s_below.filter(|_| cleared).map(|value| Limit { value, confidence: LIMIT }),
        votes,
        reasons: test.reasons.clone(),
        ..Verdict::default()
    })
}

/// The amount of stiction from a test that decides.
pub(super) fn stiction(test: &TestReading) -> Stiction {
    let why_not = match test.class {
        VerdictClass::Sticks => {
            test.s.is_none().then_some("no turn of the test was large enough for an upper limit")
        }
        VerdictClass::DoesNotStick => Some("by the test, the valve does not stick"),
        _ => Some("a valve that does not respond never slips"),
    };
    Stiction {
        model: test
            .s
            .map(|_| "a valve that explains the answers to the turns of the test".to_owned()),
        s: test.s,
        j: test.j,
        coverage: test.s.map(|_| COVERAGE),
        why_not: why_not.map(str::to_owned),
        definitions: vec![],
    }
}

/// The note on a valve test in the recording, given the basis of the verdict.
pub(super) fn note(test: &TestReading, basis: Basis) -> String {
    let moves = if test.steps.is_empty() { "ramps" } else { "turns" };
    let turns = format!(
        "{} {moves} of the OP by hand within {}",
        test.turned,
        time(test.to_s - test.from_s)
    );
    match basis {
        Basis::ValveTest => format!(
            "the verdict is from the valve test in this recording, {turns}; `stiction test read` shows its answers"
        ),
        _ => format!(
            "this recording {} a valve test, {turns}, with the result {} ({}); `stiction test read` shows its answers",
            if test.known_by == KnownBy::Mode { "contains" } else { "seems to contain" },
            test.word(),
            percent(test.probability)
        ),
    }
}
