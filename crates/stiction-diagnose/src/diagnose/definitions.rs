//! The different quantities that are called "stiction in percent", side by side.
//!
//! The stick band S is the OP travel that a reversal of the valve needs. An ellipse through the PV-OP plot is also
//! widened by dead time and lag, and its axis ratio is not a travel. Their sources are recalled, not read. Each
//! quantity has its own name, so that nobody compares different quantities from two tools.

use super::verdict::Definition;
use crate::finding::Finding;
use crate::methods::damarla_steadiness::DamarlaTestResult;
use crate::methods::sharp_corner::SharpCornerResult;
use crate::methods::{Ellipse, MethodId, Subject};
use crate::series::{band_passed, std};
use std::borrow::Cow;

/// Largest number of samples for the fit of an ellipse: the middle of a long segment.
const MOST_POINTS: usize = 4_000;

/// All definitions for a loop, `s` being the estimate of S, percent. A method's result is read from its finding; a
/// method without a finding runs now.
pub fn definitions(subject: &Subject<'_>, findings: &[Finding], s: Option<f64>) -> Vec<Definition> {
    let ellipse = ellipse(subject);
    let finding = |id: MethodId| {
        let asked = findings.iter().find(|finding| finding.method == id.method());
        asked.map_or_else(|| Cow::Owned(id.detector().judge(subject)), Cow::Borrowed)
    };
    let corners = finding(MethodId::SharpCorner);
    let corners = corners.looked_at().filter(|found: &&SharpCornerResult| !found.cycles.is_empty());
    let corners = corners.map(|found| found.magnitude);
    let knees = finding(MethodId::DamarlaTTest);
    let knees = knees.looked_at().and_then(|found: &DamarlaTestResult| found.eta_95);
    vec![
        Definition {
            name: "S",
            value: s,
            unit: "%",
            meaning: "stick band plus dead band: OP travel after a reversal until the valve moves (Choudhury, \
                      Thornhill and Shah 2005)",
        },
        Definition {
            name: "apparent stiction",
            value: ellipse.as_ref().map(|(in_units, _)| in_units.op_width()),
            unit: "%",
            meaning: "width of the ellipse of OP and PV around the dominant period, along the OP through its centre \
                      (Choudhury, Shah and Thornhill 2004). Dead time and lag widen the ellipse",
        },
        Definition {
            name: "ellipse width",
            value: corners,
            unit: "%",
            meaning: "mean width along the OP of the ellipses of the cycles of OP and control error (sharp-corner \
                      method)",
        },
        Definition {
            name: "ellipse axis ratio",
            value: ellipse.as_ref().map(|(_, scaled)| {
                let [long, short] = scaled.semi_axes();
                short / long
            }),
            unit: "",
            meaning: "shorter over longer axis of the ellipse of OP and PV, each in standard deviations. This \
                      ratio is not OP travel",
        },
        Definition {
            name: "knee to knee",
            value: knees,
            unit: "%",
            meaning: "OP travel while the PV is steady: 95th percentile over consecutive windows that a t-test \
                      marks (Damarla et al. 2023)",
        },
    ]
}

/// The ellipse of OP and PV around the dominant period: in their units, and in standard deviations.
fn ellipse(subject: &Subject<'_>) -> Option<(Ellipse, Ellipse)> {
    let frequency = 1.0 / subject.period?;
    let filtered = |x: &[f64]| {
        let n = x.len().min(MOST_POINTS);
        let first = (x.len() - n) / 2;
        band_passed(&x[first..first + n], 0.5 * frequency, 3.5 * frequency)
    };
    let (op, pv) = (filtered(&subject.segment.op), filtered(subject.segment.pv.as_deref()?));
    let in_units = Ellipse::fit(&op, &pv)?;
    let scaled = |x: &[f64]| {
        let sd = std(x);
        x.iter().map(|v| v / sd).collect::<Vec<_>>()
    };
    Some((in_units, Ellipse::fit(&scaled(&op), &scaled(&pv))?))
}
