//! S and J from OP and PV, as numbers where their intervals are narrow enough.

use super::verdict::{Stiction, Verdict, VerdictClass};
use super::weighing::{WIDEST, Weighing, jump, quantified};
use crate::fusion::COVERAGE;
use crate::spoken::rough;

/// Size of the stiction, if the valve sticks: 90 % intervals of the [frozen model](crate::fusion). S is a number
/// only where its interval reaches at most 35 % to either side on average. J is a number only where S is known and
/// the interval of J is at most half of S wide.
pub fn estimated(weighing: &Weighing, verdict: &Verdict, op_only: bool) -> Stiction {
    let why_not = |why: String| Stiction { why_not: Some(why), ..Stiction::default() };
    match verdict.class {
        VerdictClass::DoesNotStick => {
            return why_not("by the evidence, the valve does not stick".to_owned());
        }
        VerdictClass::DoesNotRespond => {
            return why_not("a valve that does not respond never slips".to_owned());
        }
        _ => {}
    }
    if weighing.probability <= super::grade::PROBABLY_FINE_UP_TO {
        return why_not("the evidence does not indicate stiction".to_owned());
    }
    if weighing.distance > 1.0 {
        return why_not(
            "the recording is unlike the training loops, for which the intervals hold".to_owned(),
        );
    }
    let Some(s) = quantified(weighing.s) else {
        return why_not(format!(
            "if the valve sticks, S is between {} and {} % (90 % interval), too wide for a number (more than {:.0} \
             % to either side)",
            rough(weighing.doubt.widen(weighing.s).low),
            rough(weighing.doubt.widen(weighing.s).high),
            100.0 * WIDEST
        ));
    };
    let j = jump(weighing.s, weighing.j_over_s);
    let evidence = weighing.typical();
    let best = evidence.dense.as_ref().or(evidence.model.as_ref()).map(|fits| fits.best().model);
    let model = match (best, op_only) {
        (Some(model), false) => model.describe().name.to_owned(),
        _ => "any data-driven valve model".to_owned(),
    };
    Stiction {
        model: Some(model),
        s: Some(weighing.doubt.widen(s)),
        j: j.map(|j| weighing.doubt.widen(j)),
        coverage: Some(COVERAGE),
        why_not: j.is_none().then(|| {
            format!(
                "J could not be estimated: its 90 % interval is {:.0} to {:.0} % of S",
                100.0 * weighing.j_over_s.low,
                100.0 * weighing.j_over_s.high.min(1.5)
            )
        }),
        definitions: vec![],
    }
}
