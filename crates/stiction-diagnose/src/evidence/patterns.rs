//! Samples in which OP and PV move differently.

use super::prepared::{Prepared, Trace, of_pair};
use super::regression::Regression;
use super::turns::{spread, turns};
use super::{Feature, Line};
use crate::methods::{
    Subject,
    damarla_regression::DamarlaRegression,
    damarla_steadiness::{DamarlaTest, SteadinessTest},
    horch::Horch,
    yamashita::{Yamashita, YamashitaResult},
};
use crate::recording::LoopType;
use crate::series::{mean, median, median_absolute_deviation, std};

const fn feature(name: &'static str, monotone: i8, meaning: &'static str) -> Feature {
    Feature { name, meaning, line: Line::Patterns, monotone }
}

/// Features.
pub const FEATURES: [Feature; 25] = [
    feature("rho1", 1, "share of the moving steps in which the OP moves and the PV does not"),
    feature("rho1_narrow", 1, "rho1 with a narrower dead zone of 0.2 standard deviations"),
    feature("rho2", 1, "rho1 for runs that end with a response in the OP's direction"),
    feature("rho3", 1, "rho1 without runs that end differently from stiction"),
    feature(
        "rho1_mirror",
        0,
        "share of the moving steps in which the PV moves and the OP does not",
    ),
    feature("rho1_fine", 1, "rho1 at three times the resolution"),
    feature("rho3_fine", 1, "rho3 at three times the resolution"),
    feature("horch_tau", 0, "oddness of the correlation of OP and PV, by the zero crossings"),
    feature("horch_rho", 0, "oddness of the correlation of OP and PV, by the peak"),
    feature(
        "pv_step_by_op",
        0,
        "largest correlation of PV steps with whether the OP is above a level",
    ),
    feature(
        "pv_by_op_side",
        0,
        "largest correlation of the PV with whether the OP is above a level",
    ),
    feature("steady_t", 0, "share of short windows with a steady PV and a moving OP, by a t-test"),
    feature(
        "steady_slope",
        0,
        "share of short windows in which the OP's slope is at least 15 times the PV's",
    ),
    feature("op_to_pv", 0, "how much past OP helps to predict the PV, logarithm"),
    feature("innovation_kurtosis", 0, "excess kurtosis of the PV's error given past OP and PV"),
    feature("innovation_focus", 0, "concentration of innovation at one phase between OP reversals"),
    feature(
        "innovation_late",
        0,
        "whether innovation comes late rather than early between OP reversals",
    ),
    feature("op_before_jump", 0, "OP travel before a jump of the PV, in the direction of the jump"),
    feature("op_after_jump", 0, "OP travel after a jump of the PV, in the direction of the jump"),
    feature("slips", 0, "bursts of innovation per cycle"),
    feature("slip_with_op", 0, "share of bursts in the direction in which the OP moves"),
    feature("slip_travel", 0, "median OP travel from the OP's reversal to a burst, in OP spans"),
    feature("slip_travel_spread", 0, "relative spread of the OP travel to a burst"),
    feature("answer_travel", 0, "median OP travel from OP reversal to PV reversal, in OP spans"),
    feature("answer_travel_spread", 0, "relative spread of the OP travel to the PV's reversal"),
];

/// Share of the span that a reversal needs.
pub(super) const TURN: f64 = 1.0 / 3.0;

/// Measures them.
pub fn measure(prepared: &Prepared<'_>, out: &mut Vec<f64>) {
    let Some(pv) = &prepared.pv else {
        out.extend([f64::NAN; FEATURES.len()]);
        return;
    };
    let op = &prepared.op;
    let patterns = |dead_zone: f64, op: &[f64], pv: &[f64]| {
        Yamashita { dead_zone, ..Yamashita::default() }.count(op, pv).ok()
    };
    let wide = patterns(0.5, &op.values, &pv.values);
    let narrow = patterns(0.2, &op.values, &pv.values);
    let fine = patterns(0.5, &prepared.fine_op, prepared.fine_pv.as_deref().unwrap_or_default());
    let of = |result: &Option<YamashitaResult>, number: fn(&YamashitaResult) -> f64| {
        result.as_ref().map_or(f64::NAN, number)
    };

    let segment = of_pair(&op.high, &pv.high);
    let subject = Subject::new(&segment, LoopType::Unknown, Some(prepared.period));
    let horch = Horch::default().run(&subject).ok();
    let steady = DamarlaTest::new(SteadinessTest::TTest).run(&subject);
    let slope = DamarlaRegression::default().run(&subject);

    let legs = Legs::of(op);
    let innovations = Innovations::of(op, pv);
    let [pv_step_by_op, pv_by_op_side] = by_level(&op.values, &pv.values);
    let [before, after] = innovations.op_about_jumps(&op.values, prepared.lag(1.0 / 6.0));
    let slips = innovations.slips(prepared.lag(1.0 / 8.0));
    let slip_travels: Vec<f64> =
        slips.iter().filter_map(|slip| legs.travel(slip.place)).map(|t| t / op.span).collect();
    let with_op: Vec<f64> = slips
        .iter()
        .filter_map(|slip| Some(f64::from(legs.direction(slip.place)? == slip.up)))
        .collect();
    let [focus, late] = innovations.over_legs(&legs);
    let answers: Vec<f64> = legs.answers(pv).iter().map(|t| t / op.span).collect();
    let values: [f64; FEATURES.len()] = [
        of(&wide, |r| r.statistic),
        of(&narrow, |r| r.statistic),
        of(&wide, |r| r.rho2),
        of(&wide, |r| r.rho3),
        of(&wide, |r| {
            let moving: usize = r.patterns.iter().flatten().sum::<usize>() - r.patterns[1][1];
            (r.patterns[1][0] + r.patterns[1][2]) as f64 / moving as f64
        }),
        of(&fine, |r| r.statistic),
        of(&fine, |r| r.rho3),
        horch.as_ref().map_or(f64::NAN, |r| r.delta_tau),
        horch.as_ref().map_or(f64::NAN, |r| r.delta_rho),
        pv_step_by_op,
        pv_by_op_side,
        steady.map_or(f64::NAN, |r| r.share),
        slope.map_or(f64::NAN, |r| r.index / 100.0),
        innovations.of_op,
        innovations.kurtosis,
        focus,
        late,
        before,
        after,
        slips.len() as f64 / prepared.cycles(),
        mean(&with_op),
        median(&slip_travels),
        spread(&slip_travels),
        median(&answers),
        spread(&answers),
    ];
    out.extend(values);
}

/// The largest correlation, in size, of the steps of `y` and of `y` itself with whether `u` is above a level;
/// levels with less than a tenth of the samples on either side do not count.
fn by_level(u: &[f64], y: &[f64]) -> [f64; 2] {
    let mut order: Vec<usize> = (1..u.len()).collect();
    order.sort_unstable_by(|a, b| u[*b].total_cmp(&u[*a]).then(a.cmp(b)));
    let n = order.len() as f64;
    let of = |value: &dyn Fn(usize) -> f64| {
        let all: Vec<f64> = order.iter().map(|k| value(*k)).collect();
        let (middle, deviation) = (mean(&all), std(&all));
        let (mut sum, mut best) = (0.0, 0.0f64);
        for (i, pair) in order.windows(2).enumerate() {
            sum += all[i] - middle;
            let share = (i + 1) as f64 / n;
            // Equal samples are on one side.
            if (0.1..=0.9).contains(&share) && u[pair[0]] > u[pair[1]] {
                let r = sum / (n * deviation * (share * (1.0 - share)).sqrt());
                best = best.max(r.abs());
            }
        }
        best
    };
    [of(&|k| y[k] - y[k - 1]), of(&|k| y[k])]
}

/// The OP between its turns.
struct Legs<'a> {
    op: &'a [f64],
    turns: Vec<usize>,
}

impl<'a> Legs<'a> {
    fn of(op: &'a Trace) -> Self {
        Self { op: &op.values, turns: turns(&op.values, TURN * op.span) }
    }

    /// The last turn before the sample `k`.
    fn turn_before(&self, k: usize) -> Option<usize> {
        let after = self.turns.partition_point(|turn| *turn < k);
        after.checked_sub(1).map(|i| self.turns[i])
    }

    /// OP travel at `k` since its last turn.
    fn travel(&self, k: usize) -> Option<f64> {
        self.turn_before(k).map(|turn| (self.op[k] - self.op[turn]).abs())
    }

    /// Whether the OP is above where it turned before the sample `k`.
    fn direction(&self, k: usize) -> Option<bool> {
        self.turn_before(k).map(|turn| self.op[k] > self.op[turn])
    }

    /// OP travel in each leg before the PV turns to follow it.
    fn answers(&self, pv: &Trace) -> Vec<f64> {
        let leg = |pair: &[usize]| {
            let up = self.op[pair[1]] > self.op[pair[0]];
            let depth = |k: usize| if up { pv.values[k] } else { -pv.values[k] };
            let turn =
                (pair[0]..=pair[1]).reduce(|a, b| if depth(b) < depth(a) { b } else { a })?;
            Some((self.op[turn] - self.op[pair[0]]).abs())
        };
        self.turns.windows(2).filter_map(leg).collect()
    }
}

/// A burst of innovation.
struct Slip {
    /// The sample before it.
    place: usize,
    /// Whether the PV rises.
    up: bool,
}

/// The prediction error of the PV from past OP and PV.
struct Innovations {
    /// From sample `FIRST` on; empty if only rounding remains.
    values: Vec<f64>,
    kurtosis: f64,
    /// Logarithm of the share that remains without the OP, over the share that remains with it.
    of_op: f64,
}

/// The first sample whose past is complete.
const FIRST: usize = 4;

impl Innovations {
    /// The past of the OP starts one sample back: with the present sample the fit would find the controller.
    fn of(op: &Trace, pv: &Trace) -> Self {
        let (u, y) = (&op.values, &pv.values);
        let alone = super::regression::autoregression(y);
        let both: Option<Regression<8>> = Regression::of(y, FIRST, |k| {
            [1.0, y[k - 1], y[k - 2], y[k - 3], y[k - 4], u[k - 1], u[k - 2], u[k - 3]]
        });
        let of_op = alone.zip(both.as_ref()).map(|(a, b)| a.ln_left() - b.ln_left());
        let kurtosis = both.as_ref().map_or(f64::NAN, Regression::kurtosis);
        let values = both.filter(|b| !b.is_exact()).map_or(vec![], |b| b.residuals);
        Self { values, kurtosis, of_op: of_op.unwrap_or(f64::NAN) }
    }

    /// OP travel in the `lag` samples before and after jumps, in their direction, over its typical travel in as
    /// many samples; jumps are weighted by their squares.
    fn op_about_jumps(&self, op: &[f64], lag: usize) -> [f64; 2] {
        let ways: Vec<f64> =
            op.iter().zip(op.iter().skip(lag)).map(|(a, b)| (b - a).powi(2)).collect();
        let typical = mean(&ways).sqrt();
        let (mut before, mut after, mut all) = (0.0, 0.0, 0.0);
        for (i, r) in self.values.iter().enumerate() {
            // The sample before the innovation, the last that cannot have responded to it.
            let k = i + FIRST - 1;
            if k < lag || k + lag >= op.len() {
                continue;
            }
            let weight = r * r.abs();
            before += weight * (op[k] - op[k - lag]);
            after += weight * (op[k + lag] - op[k]);
            all += r * r;
        }
        [before / (all * typical), after / (all * typical)]
    }

    /// Bursts above the noise, at least `apart` samples from each other.
    fn slips(&self, apart: usize) -> Vec<Slip> {
        if self.values.is_empty() {
            return vec![];
        }
        // Gaussian noise exceeds the first threshold once in 2,000 samples. Between the slips of a loop without
        // noise any value does, hence the second.
        let least = (3.5 * median_absolute_deviation(&self.values)).max(0.5 * std(&self.values));
        let mut slips: Vec<Slip> = vec![];
        let mut last: Option<usize> = None;
        for (i, r) in self.values.iter().enumerate() {
            if r.abs() > least {
                let place = i + FIRST - 1;
                if last.is_none_or(|last| place - last >= apart) {
                    slips.push(Slip { place, up: *r > 0.0 });
                }
                last = Some(place);
            }
        }
        slips
    }

    /// Concentration of their energy at one phase of the OP's legs, 0 to 1, and its excess in the last third of the
    /// legs over the first, -1 to 1.
    fn over_legs(&self, legs: &Legs<'_>) -> [f64; 2] {
        let (mut cosine, mut sine, mut lean, mut all) = (0.0, 0.0, 0.0, 0.0);
        for pair in legs.turns.windows(2) {
            for k in pair[0].max(FIRST)..pair[1] {
                let energy = self.values.get(k - FIRST).map_or(0.0, |r| r * r);
                let phase = (k - pair[0]) as f64 / (pair[1] - pair[0]) as f64;
                let (s, c) = (std::f64::consts::TAU * phase).sin_cos();
                (cosine, sine, all) = (cosine + energy * c, sine + energy * s, all + energy);
                lean += energy * (f64::from(phase >= 2.0 / 3.0) - f64::from(phase < 1.0 / 3.0));
            }
        }
        [(cosine * cosine + sine * sine).sqrt() / all, lean / all]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relay_correlates_with_its_level() {
        let u: Vec<f64> = (0..600).map(|k| (f64::from(k) * 0.05).sin()).collect();
        let relay: Vec<f64> = u.iter().map(|u| f64::from(*u > 0.2)).collect();
        assert!((by_level(&u, &relay)[1] - 1.0).abs() < 1e-12);
        let integral: Vec<f64> = relay
            .iter()
            .scan(0.0, |sum, r| {
                *sum += r - 0.4;
                Some(*sum)
            })
            .collect();
        assert!((by_level(&u, &integral)[0] - 1.0).abs() < 1e-12);
        assert_eq!(by_level(&[1.0; 20], &relay[..20]), [0.0, 0.0]);
    }

    #[test]
    fn travel_counts_from_the_last_turn() {
        let op: Vec<f64> = (0..100).map(|k| f64::from((k % 40 - 20i32).abs())).collect();
        let legs = Legs { op: &op, turns: turns(&op, 5.0) };
        assert_eq!(legs.turns, [20, 40, 60, 80]);
        assert_eq!(legs.travel(27), Some(7.0));
        assert_eq!((legs.direction(27), legs.direction(47)), (Some(true), Some(false)));
        assert_eq!(legs.travel(20), None);
    }
}
