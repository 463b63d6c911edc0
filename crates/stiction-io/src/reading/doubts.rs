//! Notes on signals that contradict each other or themselves.

use super::builder::Builder;
use crate::cells::signals::Values;
use crate::cells::unit::{self, Unit};
use crate::columns::layout::LoopPlan;
use crate::columns::role::Signal;
use crate::remedy::Remedy;
use stiction_recording::recording::{Channel, Recording};
use stiction_recording::spoken;

impl Builder<'_> {
    /// The notes. An SP that is certainly not in the unit of the PV is left out.
    pub(super) fn doubts(&self, plan: &LoopPlan, recording: &mut Recording) -> Vec<String> {
        let first = self.repeated(plan, recording).into_iter();
        let scale = self.scale_of_op(plan, &recording.op);
        first.chain(scale).chain(self.sp_elsewhere(recording)).collect()
    }

    /// The column of a sample and its row or, if rows of other signals were skipped, its time.
    fn place(&self, plan: &LoopPlan, signal: Signal, of: &Channel, sample: usize) -> [String; 2] {
        let source = plan.signal(signal).map(|place| self.source(place));
        let column = source.as_ref().map_or(signal.name(), |source| source.name);
        let rows = source.as_ref().filter(|source| source.rows.len() == of.time.len());
        let time = || self.times.clock.show(self.times.start, of.time[sample]);
        let row = |row| format!("row {}", self.sheet.row(row));
        [format!("\"{column}\""), rows.map_or_else(time, |source| row(source.rows[sample]))]
    }

    /// A note on samples with the time of another sample but a different value.
    fn repeated(&self, plan: &LoopPlan, recording: &Recording) -> Option<String> {
        let Recording { op, pv, sp, vp, .. } = recording;
        let [pv, sp, vp] = [pv, sp, vp].map(Option::as_ref);
        let channels = [Some(op), pv, sp, vp].into_iter();
        let found = channels.zip([Signal::Op, Signal::Pv, Signal::Sp, Signal::Vp]);
        let found = found.filter_map(|(channel, signal)| {
            let Channel { time, values, .. } = channel?;
            let mut order: Vec<usize> =
                (0..time.len()).filter(|k| values[*k].is_finite()).collect();
            order.sort_by(|a, b| time[*a].total_cmp(&time[*b]));
            let is_it = |(a, b): (usize, usize)| time[a] == time[b] && values[a] != values[b];
            let mut found = order.windows(2).filter(|pair| is_it((pair[0], pair[1])));
            let [column, at] = self.place(plan, signal, channel?, found.next()?[1]);
            Some(format!("{} of {column} from {at} on", 1 + found.count()))
        });
        let found = found.reduce(|all, each| format!("{all}, {each}"))?;
        Some(format!(
            "different values have the same time ({found}), and the last in the file is used; remove the wrong rows, or \
             correct their times"
        ))
    }

    /// A note on an OP that is a fraction in one part of the file, and in percent in the rest.
    fn scale_of_op(&self, plan: &LoopPlan, op: &Channel) -> Option<String> {
        /// The fewest samples of the fraction that are not 0, because a valve may be shut for a while.
        const FEWEST: usize = 50;
        /// By this share of the range of the percent, the fraction may be outside and may jump at its beginning (ours).
        const NEAR: f64 = 0.2;
        let known = op.values.iter().enumerate().filter(|(_, value)| value.is_finite());
        let (places, values): (Vec<usize>, Vec<f64>) = known.unzip();
        let is_percent = |value: &f64| !(0.0..=1.0).contains(value);
        let end = values.iter().rposition(is_percent)? + 1;
        [end, values.iter().position(is_percent)?].into_iter().find_map(|at| {
            let (before, after) = values.split_at(at);
            let (fraction, percent) = if at == end { (after, before) } else { (before, after) };
            let (small, percent) = (Values::of(fraction)?, Values::of(percent)?);
            let [low, median, high] = [small.low, small.median, small.high].map(|v| 100.0 * v);
            let is_near = Values { low, median, high }.within((percent.low, percent.high), NEAR);
            let (a, b) = (values[at - 1], values[at]);
            let jump = (a.max(b) - 100.0 * a.min(b)).abs();
            let count = fraction.iter().filter(|value| **value != 0.0).count();
            let continues = is_near && jump <= NEAR * (percent.high - percent.low);
            let [column, place] = self.place(plan, Signal::Op, op, places[at]);
            (continues && low < high && count >= FEWEST).then(|| {
                format!(
                    "{column} is between 0 and 1 on one side of {place} and in percent on the other side, so its scale \
                     probably changes there; convert one part, or diagnose the parts as two files"
                )
            })
        })
    }

    /// A note if the SP may be in percent, unlike the PV. The note appears if their units say so, or if the SP is in 0
    /// to 100, the PV is not, and the two are far apart. If they are far apart and in different units, the SP is left
    /// out.
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
