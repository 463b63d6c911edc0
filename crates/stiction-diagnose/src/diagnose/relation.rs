//! Whether OP and PV belong together.
//!
//! In closed loop, OP and PV obey the controller's law with any valve and any disturbance. A sticking, stuck or healthy
//! valve is driven by the same controller. So three questions about a recording need no tuning. Is one signal a copy of
//! another? Which of the columns stays at the set point? Does the OP follow the PV as a controller's output does
//! ([`law`]), does the PV follow the OP, or neither? If the columns are mistaken, the valve is not judged.

mod law;

use crate::recording::Segment;
use crate::recording::fitness::levels;
use crate::series::{max, mean, median, min, span, std};
use crate::spoken::{rough, set};
use law::Law;
use stiction_model::named;

named! {
    /// A likely mistake in the columns of a recording.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Mismatch {
        /// The column of the PV has the OP, and the column of the OP has the PV.
        Exchanged = "PV and OP look exchanged",
        /// OP and PV are one signal; which one is unknown.
        SameSignal = "PV and OP are one and the same signal",
        /// The PV is a copy of the OP.
        PvIsOp = "the PV is a copy of the OP",
        /// The OP is a copy of the PV.
        OpIsPv = "the OP is a copy of the PV",
        /// The column of the OP has the SP, and the column of the SP has the OP.
        SpAndOpExchanged = "SP and OP look exchanged",
        /// The column of the PV has the SP, and the column of the SP has the PV.
        SpAndPvExchanged = "SP and PV look exchanged",
        /// Neither follows the other: noise, samples out of order, or signals of two loops.
        Unrelated = "PV and OP have nothing to do with each other",
    }
}

impl Mismatch {
    /// The remedy.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::Exchanged => {
                "check which tag is in which column, swap the two, and diagnose again"
            }
            Self::SameSignal => {
                "both columns have the same tag: export the missing signal. A P controller with a gain of \
                 one and a constant set point would look the same: test such a loop in manual"
            }
            Self::PvIsOp => "the column of the PV has the tag of the OP: export the PV",
            Self::OpIsPv => {
                "the column of the OP has the tag of the PV: export the controller's output"
            }
            Self::SpAndOpExchanged | Self::SpAndPvExchanged => {
                "check which tag is in which column, swap the two, and diagnose again"
            }
            Self::Unrelated => {
                "check that both tags are of the same loop, that their clocks agree, that samples are in order of \
                 time, and that the loop was in automatic"
            }
        }
    }
}

/// Whether OP and PV belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Relation {
    /// The likely mistake; `None` without a mistake, or if too little happens to decide.
    pub mismatch: Option<Mismatch>,
    /// The evidence for the mistake: a sentence. Empty without a mistake.
    pub because: String,
    /// The largest share of the OP that the PV explains through a controller's law, over all block lengths; `None`
    /// if too little happens.
    pub op_explained: Option<f64>,
    /// The share of the PV that the OP explains through such a law. It should be smaller.
    pub pv_explained: Option<f64>,
    /// How clearly the OP follows the PV (above 0) or the PV the OP (below), in standard errors, summed over the
    /// block lengths; `None` if too little happens.
    pub order: Option<f64>,
}

/// A likely mistake in the columns of a recording.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
#[schemars(rename = "Relation")]
pub(super) struct Mistake<'a> {
    /// The mistake, such as `PV and OP look exchanged`.
    mismatch: Mismatch,
    /// The evidence for the mistake.
    because: &'a str,
    /// How to correct the mistake.
    remedy: &'static str,
}

#[cfg(feature = "serde")]
impl Mistake<'_> {
    pub(super) fn of<S: serde::Serializer>(
        relation: &Option<Relation>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        let mistake = relation.as_ref().and_then(|Relation { mismatch, because, .. }| {
            let mismatch = (*mismatch)?;
            Some(Mistake { mismatch, because, remedy: mismatch.remedy() })
        });
        serde::Serialize::serialize(&mistake, to)
    }
}

/// Block lengths in samples, from the waves of a fast loop to the waves of a slow loop. Each is four times the previous
/// one.
const LENGTHS: [usize; 4] = [16, 64, 256, 1024];
/// The two lengths for averages.
const SHORT: [usize; 2] = [16, 64];
/// Numbers of samples to average. A PV fed forward through derivative action, or a sample that is held, leads at the
/// fastest scale only. A controller's integral shows at the slower scales, even if the controller filters noise.
const SCALES: [usize; 2] = [4, 16];
/// Largest number of samples to examine. Of a longer segment, the middle is examined.
const LONGEST: usize = 16_384;
/// Largest distance of an exact copy, in standard deviations: rounding of floating point.
const EXACT: f64 = 1e-8;
/// Fewest steps in the span of a rounded copy, or any signal would pass.
const FEWEST_STEPS: f64 = 30.0;
/// Ranges in which an OP is often recorded a second time: its values at 0 and at 100 %.
const RANGES: [(f64, f64); 10] = [
    (0.0, 100.0),
    (100.0, 0.0),
    (0.0, 1.0),
    (0.0, 10.0),
    (4.0, 20.0),
    (0.0, 20.0),
    (1.0, 5.0),
    (3.0, 15.0),
    (0.2, 1.0),
    (0.0, 1000.0),
];
/// A signal is at its set point if its mean distance is below one standard deviation and it crosses the set point at
/// least this many times.
const CROSSINGS: usize = 8;
/// Least distance of a signal that is far from its set point and never reaches it, in standard deviations.
const FAR: f64 = 5.0;
/// Below this share, a signal does not explain another.
const NOTHING: f64 = 0.1;
/// The variance must be spread over this many blocks, or the share is meaningless.
const SPREAD: f64 = 3.0;
/// A law indicates an order if it explains this much.
const EXPLAINS: f64 = 0.5;
/// Limit of one law's evidence for the order, standard errors, so that no single block length decides.
const MOST: f64 = 10.0;
/// The order contradicts the columns from here on: half more than the limit of a single law.
const REVERSED: f64 = 1.5 * MOST;
/// Percent beyond 0 and 100 where a controller's output cannot be.
const BEYOND: f64 = 10.0;

impl Relation {
    /// Nothing known.
    const UNKNOWN: Self = Self {
        mismatch: None,
        because: String::new(),
        op_explained: None,
        pv_explained: None,
        order: None,
    };

    /// Checks whether OP and PV of a segment belong together; nothing is known without a PV.
    pub fn of(segment: &Segment) -> Self {
        let Some(pv) = &segment.pv else { return Self::UNKNOWN };
        let kept = |x: &[f64]| middle(x).to_vec();
        let (op, pv) = (kept(&segment.op), kept(pv));
        let sp = segment.sp.as_deref().map(kept);
        if !op.iter().chain(&pv).chain(sp.iter().flatten()).all(|v| v.is_finite()) {
            return Self::UNKNOWN;
        }
        let found = |(mismatch, because): (Mismatch, String)| Self {
            mismatch: Some(mismatch),
            because,
            ..Self::UNKNOWN
        };
        if let Some(copy) = copied(&op, &pv, sp.as_deref()) {
            return found(copy);
        }
        if let Some(misplaced) = sp.as_deref().and_then(|sp| misplaced(&op, &pv, sp)) {
            return found(misplaced);
        }
        let laws = Laws::of(&op, &pv, sp.as_deref());
        let (mismatch, because) = match laws.mismatch(&op, &pv) {
            Some((mismatch, because)) => (Some(mismatch), because),
            None => (None, String::new()),
        };
        Self {
            mismatch,
            because,
            op_explained: laws.best(&laws.op_after_pv),
            pv_explained: laws.best(&laws.pv_after_op),
            order: laws.order(),
        }
    }

    /// The mistake that ends the judgement; with a `measured` valve position only one that concerns the OP.
    pub(super) fn ends(&self, measured: bool) -> Option<Mismatch> {
        let of_pv = |mismatch: &Mismatch| {
            matches!(mismatch, Mismatch::Unrelated | Mismatch::PvIsOp | Mismatch::SpAndPvExchanged)
        };
        self.mismatch.filter(|mismatch| !(measured && of_pv(mismatch)))
    }
}

/// The samples in the middle of a segment that is too long.
fn middle(x: &[f64]) -> &[f64] {
    let from = x.len().saturating_sub(LONGEST) / 2;
    &x[from..x.len().min(from + LONGEST)]
}

/// Whether OP and PV are copies of each other, in the same sample or one sample late.
fn copied(op: &[f64], pv: &[f64], sp: Option<&[f64]>) -> Option<(Mismatch, String)> {
    let n = op.len();
    if n < 8 || !(span(op) > 0.0 && span(pv) > 0.0) {
        return None;
    }
    if let Some(line) = Line::of(op, pv).filter(Line::is_copy) {
        let mismatch = match sp.map(|sp| (is_at(pv, sp), is_at(op, sp))) {
            // The SP shows whose signal it is.
            Some((true, false)) => Mismatch::OpIsPv,
            Some((false, _)) if is_far(pv, sp?) => Mismatch::PvIsOp,
            _ => Mismatch::SameSignal,
        };
        return Some((mismatch, format!("in every sample PV = {}", line.words("OP"))));
    }
    if let Some(line) = Line::of(&op[..n - 1], &pv[1..]).filter(Line::is_late_copy) {
        let because = format!("in every sample PV = {}, one sample later", line.words("OP"));
        return Some((Mismatch::PvIsOp, because));
    }
    // A P controller may answer to the sample before, so only plain copies count.
    let line = Line::of(&pv[..n - 1], &op[1..]).filter(Line::is_copy)?;
    Some((Mismatch::OpIsPv, format!("in every sample OP = {}, one sample later", line.words("PV"))))
}

/// A straight line through two signals, and their distance from it.
struct Line {
    slope: f64,
    at_zero: f64,
    /// The largest distance from the line, in standard deviations of the result.
    apart: f64,
    /// Distance that rounding of both may cause, in the same unit.
    rounding: f64,
    steps: f64,
    scale: f64,
}

impl Line {
    fn of(x: &[f64], y: &[f64]) -> Option<Self> {
        let (mx, my, sy) = (mean(x), mean(y), std(y));
        let xx: f64 = x.iter().map(|v| (v - mx).powi(2)).sum();
        let xy: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
        let slope = xy / xx;
        let off = |(x, y): (&f64, &f64)| (y - my - slope * (x - mx)).abs();
        // Most pairs that are no copies are recognised by their first samples.
        let apart = x.iter().zip(y).map(off).fold(0.0, f64::max) / sy;
        let quantum = |x: &[f64]| levels(x).map_or(0.0, |levels| span(x) / (levels - 1.0).max(1.0));
        let (qx, qy) = if apart < 0.5 { (quantum(x), quantum(y)) } else { (0.0, 0.0) };
        (slope.is_finite() && apart.is_finite()).then(|| Self {
            slope,
            at_zero: my - slope * mx,
            apart,
            rounding: 0.51 * (qy + slope.abs() * qx) / sy,
            steps: span(y) / (qy + slope.abs() * qx),
            scale: sy,
        })
    }

    /// A copy in the same sample: exact and through zero, or in one of the usual ranges except for rounding. Any
    /// other line may be that of a P controller.
    fn is_copy(&self) -> bool {
        let exact = self.apart <= EXACT;
        let near = |a: f64, b: f64, by: f64| (a - b).abs() <= by;
        let through_zero = self.slope > 0.0 && self.at_zero.abs() <= 10.0 * EXACT * self.scale;
        let rounded = self.apart <= self.rounding && self.steps >= FEWEST_STEPS;
        let plain = RANGES.iter().any(|(low, high)| {
            let slope = (high - low) / 100.0;
            near(self.slope, slope, 1e-3 * slope.abs())
                && near(self.at_zero, *low, 1e-3 * 100.0 * slope.abs())
        });
        exact && through_zero || (exact || rounded) && plain
    }

    /// A copy one sample late: no process responds without noise.
    fn is_late_copy(&self) -> bool {
        self.apart <= EXACT || self.is_copy()
    }

    fn words(&self, name: &str) -> String {
        if (self.slope - 1.0).abs() < 1e-3 && self.at_zero.abs() <= 1e-3 * self.scale {
            return name.to_owned();
        }
        format!("{} + {} {name}", set(self.at_zero), set(self.slope))
    }
}

/// Distance from a set point, in standard deviations, and how often it is crossed.
fn distance(x: &[f64], sp: &[f64]) -> (f64, usize) {
    let off: Vec<f64> = x.iter().zip(sp).map(|(x, sp)| x - sp).collect();
    let crossings = off.windows(2).filter(|w| (w[0] > 0.0) != (w[1] > 0.0)).count();
    (mean(&off).abs() / std(&off), crossings)
}

fn is_at(x: &[f64], sp: &[f64]) -> bool {
    let (distance, crossings) = distance(x, sp);
    distance < 1.0 && crossings >= CROSSINGS
}

fn is_far(x: &[f64], sp: &[f64]) -> bool {
    let (distance, crossings) = distance(x, sp);
    distance > FAR && crossings == 0
}

/// Which column stays at the set point.
fn misplaced(op: &[f64], pv: &[f64], sp: &[f64]) -> Option<(Mismatch, String)> {
    let off = |x: &[f64]| mean(x) - mean(sp);
    if is_at(op, sp) && is_far(pv, sp) {
        let because = format!(
            "the column of the OP stays at the set point (mean distance {}), and the column of the PV never meets the set point ({})",
            rough(off(op)),
            rough(off(pv))
        );
        return Some((Mismatch::Exchanged, because));
    }
    if is_at(pv, op) && is_far(pv, sp) && is_far(op, sp) {
        let because = "the PV stays at the values in the column of the OP, as at a set point, and never meets \
                       the values in the column of the SP";
        return Some((Mismatch::SpAndOpExchanged, because.to_owned()));
    }
    let share = |x: &[f64]| {
        x.windows(2).filter(|w| w[0] != w[1]).count() as f64 / (x.len() - 1).max(1) as f64
    };
    // A set point rests, a measurement does not.
    let steps = share(pv);
    if steps < 0.05 && share(sp) > 0.5 && share(op) > 0.5 && is_at(sp, pv) {
        let because = format!(
            "the column of the PV changes in {:.1} % of the samples, but the column of the SP changes in {:.0} %, around the PV",
            100.0 * steps,
            100.0 * share(sp)
        );
        return Some((Mismatch::SpAndPvExchanged, because));
    }
    None
}

/// The controller's law in both directions: for samples in blocks of each length, and for averages.
struct Laws {
    op_after_pv: Vec<Option<Law>>,
    pv_after_op: Vec<Option<Law>>,
    /// The laws of averages, in both directions.
    averaged: Vec<Law>,
    /// The order of samples and at each scale of averaging.
    orders: Vec<f64>,
    /// Whether both signals are recorded without long holds, rounding or interpolation.
    alive: bool,
}

impl Laws {
    fn of(op: &[f64], pv: &[f64], sp: Option<&[f64]>) -> Self {
        let sp = sp.filter(|sp| span(sp) > 0.0);
        let (op_after_pv, pv_after_op) = both_ways(op, pv, sp, &LENGTHS);
        let averages = SCALES.map(|scale| {
            let averaged = |x: &[f64]| -> Vec<f64> { x.chunks_exact(scale).map(mean).collect() };
            let sp = sp.map(averaged);
            both_ways(&averaged(op), &averaged(pv), sp.as_deref(), &SHORT)
        });
        let of_samples = order(&op_after_pv[..SHORT.len()], &pv_after_op[..SHORT.len()]);
        let of_averages = averages.iter().map(|(there, back)| order(there, back));
        let orders = [of_samples].into_iter().chain(of_averages).flatten().collect();
        let averaged = averages.into_iter().flat_map(|(there, back)| [there, back].concat());
        let averaged = averaged.flatten().collect();
        Self { op_after_pv, pv_after_op, averaged, orders, alive: is_alive(op) && is_alive(pv) }
    }

    fn best(&self, laws: &[Option<Law>]) -> Option<f64> {
        laws.iter().flatten().map(|law| law.explained).reduce(f64::max)
    }

    /// In standard errors, above 0 if the OP follows the PV: the most favourable of the scales.
    fn order(&self) -> Option<f64> {
        self.orders.iter().copied().reduce(f64::max)
    }

    fn mismatch(&self, op: &[f64], pv: &[f64]) -> Option<(Mismatch, String)> {
        let middle = median(op);
        let order = self.order();
        if !(-BEYOND..=100.0 + BEYOND).contains(&middle)
            && min(pv) >= 0.0
            && max(pv) <= 100.0
            && order.is_none_or(|order| order < REVERSED)
        {
            let because = format!(
                "the values in the column of the OP are around {}, outside the range of an output in percent, and \
                 the values in the column of the PV are between 0 and 100",
                rough(middle)
            );
            return Some((Mismatch::Exchanged, because));
        }
        let explained = |laws| 100.0 * self.best(laws).unwrap_or(0.0);
        if self.alive && self.orders.len() > 1 && order.is_some_and(|order| order <= -REVERSED) {
            let because = format!(
                "the PV follows the OP as a controller's output follows its error ({:.0} % explained); the OP does \
                 not follow the PV",
                explained(&self.pv_after_op)
            );
            return Some((Mismatch::Exchanged, because));
        }
        let of_samples = self.op_after_pv.iter().chain(&self.pv_after_op).flatten();
        let mut all = of_samples.chain(&self.averaged);
        let seen = self.op_after_pv.iter().flatten().any(|law| law.blocks > SPREAD);
        (self.alive && seen && all.all(|law| law.explained < NOTHING)).then(|| {
            let because = format!(
                "a controller would respond to its PV, but no control law explains more than {:.0} % of the OP \
                 from the PV, or of the PV from the OP",
                explained(&self.op_after_pv).max(explained(&self.pv_after_op)).max(1.0)
            );
            (Mismatch::Unrelated, because)
        })
    }
}

/// The laws of the OP after the PV and of the PV after the OP, for each length of blocks.
fn both_ways(
    op: &[f64],
    pv: &[f64],
    sp: Option<&[f64]>,
    lengths: &[usize],
) -> (Vec<Option<Law>>, Vec<Option<Law>>) {
    let resting: Vec<bool> = rests(op).into_iter().zip(rests(pv)).map(|(a, b)| a || b).collect();
    let direction = |y: &[f64], x: &[f64]| -> Vec<Option<Law>> {
        let error: Option<Vec<f64>> = sp.map(|sp| x.iter().zip(sp).map(|(x, sp)| x - sp).collect());
        let of = |length: &usize| {
            // Blocks in which a signal, and so the law, rests at a limit do not count.
            let counts = |from: usize| {
                let part = from..from + length;
                resting[part.clone()].iter().filter(|r| **r).count() * 5 < *length
                    && span(&y[part.clone()]) > 0.0
                    && span(&x[part]) > 0.0
            };
            let plain = Law::of(y, x, *length, &counts);
            let with_sp = error.as_ref().and_then(|error| Law::of(y, error, *length, &counts));
            match (plain, with_sp) {
                (Some(a), Some(b)) => Some(if b.explained > a.explained { b } else { a }),
                (a, b) => a.or(b),
            }
        };
        lengths.iter().map(of).collect()
    };
    (direction(op, pv), direction(pv, op))
}

/// The combined evidence of clear laws for the order; `None` if no law is clear.
fn order(op_after_pv: &[Option<Law>], pv_after_op: &[Option<Law>]) -> Option<f64> {
    let clear = |law: &&Law| law.explained > EXPLAINS;
    let says = |laws: &[Option<Law>]| -> f64 {
        laws.iter().flatten().filter(clear).map(|law| law.integral.clamp(-MOST, MOST)).sum()
    };
    op_after_pv.iter().chain(pv_after_op).flatten().find(clear)?;
    Some(says(op_after_pv) - says(pv_after_op))
}

/// Whether a signal changes, and not along straight lines, in at least one sample of four.
fn is_alive(x: &[f64]) -> bool {
    let flat = 1e-9 * span(x);
    let dead = |w: &&[f64]| {
        let (before, after) = (w[1] - w[0], w[2] - w[1]);
        after == 0.0 || (after - before).abs() <= flat
    };
    4 * x.windows(3).filter(dead).count() < 3 * x.len()
}

/// Where a signal rests at its highest or lowest value; nowhere if its values are too few to avoid that.
fn rests(x: &[f64]) -> Vec<bool> {
    let mut out = vec![false; x.len()];
    if levels(x).is_none_or(|levels| levels < 10.0) {
        return out;
    }
    let (low, high) = (min(x), max(x));
    for k in 1..x.len() {
        out[k] = x[k] == x[k - 1] && (x[k] == low || x[k] == high);
    }
    out
}
