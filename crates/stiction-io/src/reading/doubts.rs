//! Notes on signals that contradict each other or themselves.

use super::builder::Builder;
use crate::cells::signals::Values;
use crate::cells::unit::{self, Unit};
use crate::remedy::Remedy;
use stiction_recording::recording::Recording;
use stiction_recording::spoken;

impl Builder<'_> {
    /// The notes. An SP that is certainly not in the unit of the PV is left out.
    pub(super) fn doubts(&self, recording: &mut Recording) -> Vec<String> {
        self.sp_elsewhere(recording).into_iter().collect()
    }

    /// A note if the SP may be in percent, unlike the PV. Either their units say so, or the SP is in 0 to 100, the PV is
    /// not, and they are far apart. If they are far apart and in different units, the SP is left out.
    fn sp_elsewhere(&self, recording: &mut Recording) -> Option<String> {
        /// Least distance in swings of the PV (ours). A saturated loop has a smaller one.
        const FAR: f64 = 3.0;
        let (sp, pv) = (recording.sp.as_ref()?, recording.pv.as_ref()?);
        let (values, of_pv) = (Values::of(&sp.values)?, Values::of(&pv.values)?);
        let distance = (of_pv.low - values.high).max(values.low - of_pv.high);
        let is_far = distance > FAR * (of_pv.high - of_pv.low) && distance > 0.0;
        let has_range =
            values.low >= 0.0 && values.high <= 100.0 && !of_pv.within((0.0, 100.0), 0.0);
        let [unit, pv_unit] = [sp, pv].map(|channel| channel.unit.as_deref().unwrap_or(""));
        let kinds = (unit::of(unit), unit::of(pv_unit));
        let is_stated = matches!(kinds, (Unit::Share(_), Unit::Quantity | Unit::Temperature));
        let column = recording.columns.sp.as_deref().unwrap_or("SP");
        let left_out = self.options.wording.of(Remedy::map("ignore", column));
        if !is_stated && is_far && unit::differ(unit, pv_unit) {
            let note = format!(
                "the SP is in {unit}, the PV in {pv_unit}, and they are far apart, so the SP is not used; convert it, or \
                 leave it out with {left_out}"
            );
            recording.sp = None;
            return Some(note);
        }
        if !is_stated && !(is_far && has_range && (sp.unit.is_none() || sp.unit != pv.unit)) {
            return None;
        }
        let shown = |values: &Values| match values.low == values.high {
            true => spoken::number(values.low),
            false => spoken::range(values.low, values.high),
        };
        Some(format!(
            "the SP is {} and the PV {}, so the SP may be in percent of the PV's range; if so, convert it, or leave it out \
             with {left_out}",
            shown(&values),
            shown(&of_pv),
        ))
    }
}
