//! Periodic orbits by shooting from slip to slip.

use super::super::{Cycle, Method, Swing};
use super::flow::{Event, Flow, Range, Stem};
use super::number::{Jet, Number};
use super::plant::{Plant, STATES, eigenvalues};

use nalgebra::Complex;
use nalgebra::{DMatrix, DVector};

/// Largest number of steps of a flow.
pub(super) const PATIENCE: usize = 200_000;

/// A state at a slip, multiplied by its sign so that the slip is upward.
pub(super) type State = [f64; STATES];

/// A map of the state over `slips` slips, with the stem stuck for a dead time at both ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shooting<'a> {
    pub(super) plant: &'a Plant,
    pub(super) stem: Stem,
    /// Slips from end to end.
    pub(super) slips: usize,
    /// Direction of the last slip: -1 if the orbit is symmetric and this is half of the orbit.
    pub(super) direction: f64,
    /// Allowed steps of the flow.
    pub(super) patience: usize,
}

/// A periodic orbit.
#[derive(Debug, Clone)]
pub(super) struct Orbit<'a> {
    pub(super) map: Shooting<'a>,
    /// At its slip, upward.
    pub(super) state: State,
    /// Multipliers of one period.
    pub(super) multipliers: Vec<Complex<f64>>,
}

impl<'a> Shooting<'a> {
    /// The state at the last slip, multiplied by its sign so that the slip is upward.
    fn passage<T: Number>(&self, state: [T; STATES]) -> Option<[T; STATES]> {
        let mut flow = Flow::slipping(self.plant, self.stem, state, self.patience);
        for _ in 0..self.slips {
            flow.slip();
            if flow.run_to_slip() != Event::Slips {
                return None;
            }
        }
        let right = flow.is_clean() && flow.direction == self.direction;
        right.then(|| flow.state.map(|w| w * flow.direction))
    }

    /// The image of `state`, and its derivatives, column by column.
    fn image(&self, state: &State) -> Option<(State, DMatrix<f64>)> {
        let n = self.plant.order;
        let mut derivatives = DMatrix::zeros(n, n);
        let mut image = [0.0; STATES];
        for first in (0..n).step_by(2) {
            let mut seeded: [Jet<2>; STATES] = state.map(Jet::of);
            for k in 0..2.min(n - first) {
                seeded[first + k].slope[k] = 1.0;
            }
            let there = self.passage(seeded)?;
            for i in 0..n {
                image[i] = there[i].value;
                for k in 0..2.min(n - first) {
                    derivatives[(i, first + k)] = there[i].slope[k];
                }
            }
        }
        Some((image, derivatives))
    }

    /// The orbit near `guess`, by Newton's method.
    ///
    /// Orbits of a stem that jumps come in families, along which the map is constant. For an orbit that is not
    /// symmetric, the position before the slip is kept.
    pub(super) fn orbit(self, guess: &State) -> Option<Orbit<'a>> {
        let family = matches!(self.stem, Stem::Jumps { .. }) && self.direction > 0.0;
        let position = family.then(|| self.plant.op(guess) - 1.0);
        self.orbit_at(guess, position)
    }

    /// As [`orbit`](Self::orbit), with the position before the slip prescribed.
    pub(super) fn orbit_at(self, guess: &State, position: Option<f64>) -> Option<Orbit<'a>> {
        const GOOD: f64 = 1e-11;
        let n = self.plant.order;
        let mut state = *guess;
        let mut best = f64::INFINITY;
        for round in 0..30 {
            let (image, derivatives) = self.image(&state)?;
            let size = (0..n).map(|i| state[i].abs()).fold(1.0, f64::max);
            let off = position.map_or(0.0, |p| self.plant.op(&state) - 1.0 - p);
            let residual =
                (0..n).map(|i| (image[i] - state[i]).abs()).fold(off.abs(), f64::max) / size;
            if !residual.is_finite() || (round > 6 && residual > 0.5 * best && best > GOOD) {
                return None;
            }
            let better = residual < 0.25 * best;
            best = best.min(residual);
            if residual < 1e-14 || (residual < GOOD && !better) {
                let multipliers = self.multipliers(&derivatives)?;
                return Some(Orbit { map: self, state, multipliers });
            }
            let slope = DMatrix::identity(n, n) - &derivatives;
            let gap = DVector::from_fn(n, |i, _| image[i] - state[i]);
            let step = match position {
                None => slope.lu().solve(&gap)?,
                Some(_) => {
                    let rows = DMatrix::from_fn(n + 1, n, |i, j| {
                        if i < n { slope[(i, j)] } else { self.plant.c[j] }
                    });
                    let gap = DVector::from_fn(n + 1, |i, _| if i < n { gap[i] } else { -off });
                    rows.svd(true, true).solve(&gap, 1e-13).ok()?
                }
            };
            let far = (0..n).map(|i| step[i].abs()).fold(0.0, f64::max) / size;
            // Far from the orbit a whole step leads to a different sequence of slips.
            let part = if far > 2.0 { 2.0 / far } else { 1.0 };
            (0..n).for_each(|i| state[i] += part * step[i]);
        }
        None
    }

    fn multipliers(&self, derivatives: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
        let all = eigenvalues(derivatives.clone())?;
        Some(if self.direction < 0.0 { all.iter().map(|l| l * l).collect() } else { all })
    }
}

impl Orbit<'_> {
    /// Whether nearby motions approach it, or its family.
    pub(super) fn is_stable(&self) -> bool {
        let from_one = |i: &usize| (self.multipliers[*i] - 1.0).norm();
        let family = (0..self.multipliers.len())
            .min_by(|a, b| from_one(a).total_cmp(&from_one(b)))
            .filter(|i| from_one(i) < 1e-7);
        let beside = (0..self.multipliers.len()).filter(|i| Some(*i) != family);
        beside.into_iter().all(|i| self.multipliers[i].norm() < 1.0 - 1e-9)
    }

    /// The cycle in units, `op_unit` percent to 1.
    pub(super) fn cycle(&self, op_unit: f64) -> Option<Cycle> {
        let mut flow = Flow::slipping(self.map.plant, self.map.stem, self.state, PATIENCE);
        flow.watch();
        for _ in 0..self.map.slips {
            flow.slip();
            if flow.run_to_slip() != Event::Slips {
                return None;
            }
        }
        let mirrored = self.map.direction < 0.0;
        let mut cycle = measure(self.map.plant, &flow, flow.time, mirrored, op_unit)?;
        cycle.slips = self.map.slips * if mirrored { 2 } else { 1 };
        cycle.stable = self.is_stable();
        cycle.multipliers = self.multipliers.clone();
        Some(cycle)
    }
}

/// The signals of `flow` over `time`, which is half a period if the second half mirrors it.
pub(super) fn measure(
    plant: &Plant,
    flow: &Flow<'_, f64>,
    time: f64,
    mirrored: bool,
    op_unit: f64,
) -> Option<Cycle> {
    let ranges = flow.ranges?;
    let whole = |range: Range| {
        if mirrored {
            let high = range.high.max(-range.low);
            Range { low: -high, high }
        } else {
            range
        }
    };
    let [op, vp, pv] = [ranges.op, ranges.vp, ranges.pv].map(whole);
    let swing = |of: fn(Range) -> f64| Swing {
        op: of(op) * op_unit,
        vp: of(vp) * op_unit,
        pv: of(pv) * plant.pv_unit,
    };
    let half_pp = swing(|range| 0.5 * (range.high - range.low));
    let middle = swing(|range| 0.5 * (range.high + range.low));
    Some(Cycle {
        method: Method::Exact,
        period_s: time * plant.time_s * if mirrored { 2.0 } else { 1.0 },
        half_pp,
        middle: Swing {
            op: plant.op_rest + middle.op,
            vp: plant.op_rest + middle.vp,
            pv: plant.pv_rest + middle.pv,
        },
        stable: true,
        multipliers: vec![],
        slips: 0,
    })
}
