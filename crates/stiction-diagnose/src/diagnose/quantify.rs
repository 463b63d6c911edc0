//! S and J from OP and PV, as numbers where they are known well enough.

use super::verdict::{Stiction, Verdict, VerdictClass};
use super::weighing::{WIDEST, Weighing, jump, quantified};
use crate::fusion::COVERAGE;
use crate::spoken::rough;

/// How much the valve sticks, if it does: 90 % intervals of the [frozen model](crate::fusion), and a number
/// only where the interval of S reaches at most 35 % of it to either side on average; J only where S is
/// known and its own interval is at most half of S wide.
pub fn estimated(weighing: &Weighing, verdict: &Verdict, op_only: bool) -> Stiction {
    let why_not = |why: String| Stiction { why_not: Some(why), ..Stiction::default() };
    match verdict.class {
        VerdictClass::DoesNotStick => {
            return why_not("the valve does not stick by this evidence".to_owned());
        }
        VerdictClass::DoesNotRespond => {
            return why_not("a valve that does not respond never slips".to_owned());
        }
        _ => {}
    }
    if weighing.probability <= super::grade::PROBABLY_FINE_UP_TO {
        return why_not("the evidence does not speak for a valve that sticks".to_owned());
    }
    if weighing.distance > 1.0 {
        return why_not(
            "the recording is unlike those of the training, for which intervals hold".to_owned(),
        );
    }
    let Some(s) = quantified(weighing.s) else {
        return why_not(format!(
            "if it sticks, S lies between {} and {} % with 90 % confidence, which is wider than {:.0} % to either \
             side and no number",
            rough(weighing.s.low),
            rough(weighing.s.high),
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
        s: Some(s),
        j,
        coverage: Some(COVERAGE),
        why_not: j.is_none().then(|| {
            format!(
                "J is not identified: it lies between {:.0} and {:.0} % of S with 90 % confidence",
                100.0 * weighing.j_over_s.low,
                100.0 * weighing.j_over_s.high.min(1.5)
            )
        }),
        definitions: vec![],
    }
}
