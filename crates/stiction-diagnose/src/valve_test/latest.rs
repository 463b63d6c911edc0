//! A valve that changed between two tests in one recording, as by a repair.

use super::read::TestReading;
use crate::diagnose::VerdictClass;
use crate::finding::Abstention;
use crate::recording::ByHand;

/// The later test contradicts a decision if its probability is below the first number against `sticks`, or above the
/// second against `does not stick`.
const AGAINST: (f64, f64) = (0.1, 0.9);

/// The reading of only the settings after the longest time in automatic, if it contradicts the reading of all settings.
pub(super) fn latest(
    whole: &TestReading,
    by_hand: &ByHand,
    read: impl Fn(ByHand) -> Result<TestReading, Abstention>,
) -> Option<TestReading> {
    let decides = whole.class != VerdictClass::CannotTell && whole.stops > 0;
    let later = decides.then(|| by_hand.after_pause()).flatten()?;
    let mut later = read(later).ok()?;
    if !contradicts(&later, whole) {
        return None;
    }
    let why = format!(
        "the turns before the longest time in automatic would make the result \"{}\", so the valve seems to have \
         changed; only later turns count",
        whole.word()
    );
    later.reasons.insert(0, why);
    Some(later)
}

fn contradicts(later: &TestReading, whole: &TestReading) -> bool {
    let fine = |reading: &TestReading| match reading.class {
        VerdictClass::DoesNotStick => Some(true),
        VerdictClass::Sticks | VerdictClass::DoesNotRespond => Some(false),
        VerdictClass::CannotTell => None,
    };
    match (fine(whole), fine(later)) {
        (Some(true), None) => later.by_test > AGAINST.1,
        (Some(false), None) => later.by_test < AGAINST.0,
        (Some(false), Some(false)) => {
            later.s.zip(whole.s).is_some_and(|(a, b)| a.high < b.low || b.high < a.low)
        }
        (whole, later) => whole != later,
    }
}
