//! Limit cycles by harmonic balance: where the frequency response meets `-1/N(X)`.
//!
//! # What it computes
//! Every frequency and amplitude of the OP at which a sine would sustain itself around the loop, as [`Cycle`]s with
//! [`Method::DescribingFunction`], and whether each cycle attracts. If no such sine exists, the result gives the
//! reason.
//!
//! # Assumptions
//! OP and VP are treated as sines: the process passes the fundamental of the VP and suppresses the rest. For
//! stiction this is inaccurate: against exact cycles of the paper's loop the period is 5 to 7 % too long, and up to
//! 55 % if dead time dominates.
//!
//! # Equations
//! ```text
//! L(jw) N(X) = -1,    period = 2 pi / w
//! half peak-to-peak values: OP X,  VP |N| X,  PV |G(jw)| |N| X
//! ```
//! The VP is its fundamental, not the stroke of the stem: a valve that slides moves `X - fd` to either side.
//!
//! A cycle attracts if a larger swing decays and a smaller one grows (Loeb). While a swing deviates by `dX`
//! and the balance holds, it grows at the rate
//! ```text
//! r = -Re[ j (d ln N / dX) / (d ln L / dw) ] dX,    so the cycle is stable if the real part is positive,
//! ```
//! which means that `-1/N` leaves to the left of L as X grows.
//!
//! # How it is computed
//! Both curves are polygons in the plane of phase and logarithm of the magnitude. Crossings of edges are found, and
//! each is refined by Newton's method on `ln(L N) = -j pi` to `|L N + 1| < 1e-10`.
//!
//! # Limits
//! * Two crossings within one edge of both polygons (1 % in frequency and about as much in amplitude) may be
//!   missed, which happens where a cycle appears or vanishes.
//! * A cycle may exist even if it finds none. With an integral time well above the sum of time constant and dead
//!   time the curves do not meet, but the loop cycles: the stuck valve waits until the integral moves it, and such
//!   a cycle is far from a sine.
//! * Loeb's criterion is local and necessary; it is sufficient only if the linear loop has no other poles
//!   near instability.
//! * For He's model only motions whose VP has the same middle as the OP are found, for any number of slips;
//!   asymmetric cycles need the exact method.
//! * Swings below `J / 1000` are not searched if the valve has no smallest amplitude (`S = 0`).
//!
//! # References
//! J. M. Loeb, "Recent advances in nonlinear servo theory", in "Frequency Response", 1956 (recalled, not
//! read). M. A. A. S. Choudhury, N. F. Thornhill, S. L. Shah, "Modelling valve stiction", Control
//! Engineering Practice 13 (2005) 641-658.

use super::describing_function::Branch;
use super::{
    ContinuousLoop, Cycle, DescribingFunction, FrequencyResponse, Method, Stability, Swing,
};
use crate::error::{Error, Result};
use nalgebra::Complex;
use std::f64::consts::PI;
use std::fmt;

/// Why a loop has no cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoCycle {
    /// The loop would be stable without friction, and the curves do not meet.
    Decays,
    /// The loop would be unstable without friction, and the curves do not meet.
    Grows,
    /// The loop would be at its stability limit without friction.
    Undecided,
}

impl fmt::Display for NoCycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Decays => {
                "a swing of any size decays: the loop is stable, and its frequency response does not meet \
                 -1/N(X)"
            }
            Self::Grows => {
                "a swing grows until the OP meets its limits: the loop is unstable even without friction, \
                 and its frequency response does not meet -1/N(X)"
            }
            Self::Undecided => {
                "the loop is at its stability limit without friction; its frequency response does not meet \
                 -1/N(X)"
            }
        })
    }
}

/// The result of harmonic balance.
#[derive(Debug, Clone, PartialEq)]
pub enum Balance {
    /// Cycles, the largest OP first; at least one.
    Cycles(Vec<Cycle>),
    /// It has none.
    None(NoCycle),
}

impl Balance {
    /// The cycles; empty if the loop has none.
    pub fn cycles(&self) -> &[Cycle] {
        match self {
            Self::Cycles(cycles) => cycles,
            Self::None(_) => &[],
        }
    }

    /// The stable cycle with the largest OP.
    pub fn attracting(&self) -> Option<&Cycle> {
        self.cycles().iter().find(|cycle| cycle.stable)
    }
}

/// A vertex of a curve: its parameter, phase (rad), logarithm of the magnitude.
type Vertex = [f64; 3];

/// The limit cycles of `continuous` by harmonic balance.
///
/// ```
/// use stiction_model::Bands;
/// use stiction_model::closed_loop::{Controller, Process};
/// use stiction_model::limit_cycle::{ContinuousLoop, harmonic_balance};
/// use stiction_model::valve::Model;
///
/// let paper = ContinuousLoop::new(
///     Controller::pi(1.1, 2.5)?,
///     Process::first_order(1.5, 5.93, 1.07)?,
///     Model::TwoPhase,
///     Bands::from_s_j(5.0, 3.0)?,
/// );
/// let balance = harmonic_balance(&paper)?;
/// let cycle = balance.attracting().expect("it cycles");
/// assert!((cycle.period_s - 19.2292).abs() < 1e-4);
/// # Ok::<(), stiction_model::Error>(())
/// ```
///
/// # Errors
/// If the loop gain is zero or improper, the model does not allow its bands, the loop has no operating point, He's
/// slips are so small that a cycle would have thousands a stroke, or a crossing cannot be refined.
pub fn harmonic_balance(continuous: &ContinuousLoop) -> Result<Balance> {
    /// The most slips per stroke.
    const SLIPS: usize = 1_000;
    let response = FrequencyResponse::of(continuous)?;
    let middle = continuous.operating_point()?;
    let valve = DescribingFunction::new(continuous.model, continuous.bands)?;
    // No point of L is nearer to -1 than this, so -1/N need not be followed once it stays nearer.
    let clearance = 1.0 / response.peak().0;
    let mut cycles = vec![];
    let mut slips = 1;
    while let Some(branch) = valve.branch(slips) {
        if slips > SLIPS {
            return Err(Error::Inconsistent(format!(
                "a cycle of this loop may have more than {SLIPS} slips per stroke, because it is near its stability \
                 limit or its slips are small; without a slip jump the valve has only backlash"
            )));
        }
        let amplitudes = Amplitudes::of(&valve, branch);
        let far = amplitudes.distance_from_minus_1();
        if branch.to.is_finite() && far < clearance {
            break;
        }
        let on_branch = Meeting { response: &response, amplitudes };
        for (w, x, stable) in on_branch.all()? {
            let n = valve.on_branch(slips, x).0.norm();
            let half_pp = Swing { op: x, vp: n * x, pv: response.process_at(w).norm() * n * x };
            cycles.push(Cycle {
                method: Method::DescribingFunction,
                period_s: 2.0 * PI / w,
                half_pp,
                middle,
                stable,
                multipliers: vec![],
                slips: 2 * slips,
            });
        }
        slips += 1;
    }
    cycles.sort_by(|a, b| b.half_pp.op.total_cmp(&a.half_pp.op));
    if !cycles.is_empty() {
        return Ok(Balance::Cycles(cycles));
    }
    Ok(Balance::None(match response.stability() {
        Stability::Stable => NoCycle::Decays,
        Stability::Unstable => NoCycle::Grows,
        Stability::Marginal => NoCycle::Undecided,
    }))
}

/// The amplitudes of a branch, along a parameter `t` from 0 to 1 in which N is smooth at both ends.
#[derive(Clone, Copy)]
struct Amplitudes<'a> {
    valve: &'a DescribingFunction,
    branch: Branch,
    /// A reference amplitude.
    scale: f64,
}

impl<'a> Amplitudes<'a> {
    /// The last `t` of an infinite branch: X is a million times the bands there.
    const LAST: f64 = 1.0 - 1e-3;
    const POINTS: usize = 200;

    fn of(valve: &'a DescribingFunction, branch: Branch) -> Self {
        let scale = if branch.to.is_finite() {
            branch.to - branch.from
        } else {
            branch.from.max(valve.trail())
        };
        Self { valve, branch, scale }
    }

    /// The amplitude at `t` and its derivative.
    fn x(&self, t: f64) -> (f64, f64) {
        let Branch { from, to, .. } = self.branch;
        if to.is_finite() {
            (from + self.scale * t * t, 2.0 * self.scale * t)
        } else {
            let left = 1.0 - t;
            let ratio = t / left;
            (from + self.scale * ratio * ratio, 2.0 * self.scale * ratio / (left * left))
        }
    }

    /// `N` and its derivative with respect to `X`.
    fn n(&self, x: f64) -> (Complex<f64>, Complex<f64>) {
        self.valve.on_branch(self.branch.slips, x)
    }

    fn bounds(&self) -> (f64, f64) {
        let first = if self.branch.from > 0.0 { 1e-7 } else { 1e-3_f64.sqrt() };
        (first, if self.branch.to.is_finite() { 1.0 } else { Self::LAST })
    }

    /// Vertices of -1/N at `t` from `a` to `b`, denser at the beginning of the branch.
    fn curve(&self, a: f64, b: f64, points: usize) -> Vec<Vertex> {
        let (a, b) = (a.sqrt(), b.sqrt());
        (0..=points)
            .map(|k| {
                let root = a + (b - a) * k as f64 / points as f64;
                let t = root * root;
                let n = self.n(self.x(t).0).0;
                [t, -PI - n.arg(), -n.norm().ln()]
            })
            .collect()
    }

    /// The largest distance of -1/N from -1.
    fn distance_from_minus_1(&self) -> f64 {
        let (first, last) = self.bounds();
        let distance = |v: &Vertex| (Complex::from_polar(v[2].exp(), v[1]) + 1.0).norm();
        self.curve(first, last, 20).iter().map(distance).fold(0.0, f64::max)
    }
}

/// Intersections of the two curves.
struct Meeting<'a> {
    response: &'a FrequencyResponse,
    amplitudes: Amplitudes<'a>,
}

impl Meeting<'_> {
    /// Frequency, amplitude and stability of all intersections.
    fn all(&self) -> Result<Vec<(f64, f64, bool)>> {
        let (first, last) = self.amplitudes.bounds();
        let valve_curve = self.amplitudes.curve(first, last, Amplitudes::POINTS);
        let (least, most) = valve_curve
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v[2]), b.max(v[2])));
        // Only where the gain of L is one of -1/N.
        let lowest = self.response.lowest();
        let strongest = 1.01 * most.exp();
        let low = match self.response.where_gain_is(strongest).first() {
            Some(w) if self.response.at(0.5 * w).norm() > strongest => *w,
            first => 1e-3 * first.map_or(lowest, |w| w.min(lowest)),
        };
        let high = self.response.last_crossover(0.99 * least.exp()).unwrap_or(1e3 * lowest);
        if !(high > low) {
            return Ok(vec![]);
        }
        let loop_curve = self.loop_curve(&self.response.grid(low, high));
        let mut found: Vec<(f64, f64, bool)> = vec![];
        for (i, k) in crossings(&loop_curve, &valve_curve) {
            let edge = |curve: &[Vertex], i: usize| (curve[i][0], curve[i + 1][0]);
            self.settle(edge(&loop_curve, i), edge(&valve_curve, k), &mut found)?;
        }
        Ok(found)
    }

    /// Vertices of L; the phase is unwrapped.
    fn loop_curve(&self, grid: &[f64]) -> Vec<Vertex> {
        let mut before: Option<f64> = None;
        grid.iter()
            .map(|w| {
                let value = self.response.at(*w);
                let turn = 2.0 * PI;
                let arg = value.arg();
                let phase = before.map_or(arg, |b| arg + turn * ((b - arg) / turn).round());
                before = Some(phase);
                [w.ln(), phase, value.norm().ln()]
            })
            .collect()
    }

    /// Refines a crossing of two edges and adds it, or finds on finer polygons that the edges do not cross.
    fn settle(
        &self,
        w_edge: (f64, f64),
        t_edge: (f64, f64),
        found: &mut Vec<(f64, f64, bool)>,
    ) -> Result<()> {
        const FINER: usize = 64;
        let mid = |edge: (f64, f64)| 0.5 * (edge.0 + edge.1);
        if self.polish(mid(w_edge), mid(t_edge), found) {
            return Ok(());
        }
        // A chord may cross where the curve does not, so the search is repeated with both edges and their
        // neighbours.
        let (first, last) = self.amplitudes.bounds();
        let (w_width, t_width) = (w_edge.1 - w_edge.0, t_edge.1 - t_edge.0);
        let grid: Vec<f64> = (0..=3 * FINER)
            .map(|k| (w_edge.0 + w_width * (k as f64 / FINER as f64 - 1.0)).exp())
            .collect();
        let (a, b) = ((t_edge.0 - t_width).max(first), (t_edge.1 + t_width).min(last));
        let loop_curve = self.loop_curve(&grid);
        let valve_curve = self.amplitudes.curve(a, b, 3 * FINER);
        for (i, k) in crossings(&loop_curve, &valve_curve) {
            let w = mid((loop_curve[i][0], loop_curve[i + 1][0]));
            let t = mid((valve_curve[k][0], valve_curve[k + 1][0]));
            if !self.polish(w, t, found) {
                return Err(Error::Inconsistent(format!(
                    "the frequency response seems to meet -1/N(X) near {} rad/s and X = {} %, but this could not \
                     be confirmed",
                    w.exp(),
                    self.amplitudes.x(t).0
                )));
            }
        }
        Ok(())
    }

    /// Newton's method from `(ln w, t)`; whether it ended on a nearby intersection, which is added if new.
    fn polish(&self, ln_w: f64, t: f64, found: &mut Vec<(f64, f64, bool)>) -> bool {
        const ITERATIONS: usize = 60;
        const NEAR: f64 = 0.1;
        let (first, last) = self.amplitudes.bounds();
        let residual = |ln_w: f64, t: f64| {
            let product =
                self.response.at(ln_w.exp()) * self.amplitudes.n(self.amplitudes.x(t).0).0;
            (-product).ln()
        };
        let (mut at, mut now) = ((ln_w, t), residual(ln_w, t));
        for _ in 0..ITERATIONS {
            let w = at.0.exp();
            let (x, dx) = self.amplitudes.x(at.1);
            let (n, slope) = self.amplitudes.n(x);
            let (by_w, by_t) = (self.response.log_slope(w) * w, slope / n * dx);
            let determinant = by_w.re * by_t.im - by_w.im * by_t.re;
            let step_w = -(now.re * by_t.im - now.im * by_t.re) / determinant;
            let step_t = -(by_w.re * now.im - by_w.im * now.re) / determinant;
            if !(step_w.is_finite() && step_t.is_finite()) {
                break;
            }
            let mut share = 1.0;
            let mut better = None;
            while share > 1e-4 && better.is_none() {
                let next = (at.0 + share * step_w, (at.1 + share * step_t).clamp(first, last));
                let value = residual(next.0, next.1);
                better = (value.norm() < now.norm()).then_some((next, value));
                share *= 0.5;
            }
            let Some((next, value)) = better else { break };
            (at, now) = (next, value);
        }
        // Not NaN, and not far away.
        if !(now.norm() < 1e-10) || (at.0 - ln_w).abs() > NEAR || (at.1 - t).abs() > NEAR {
            return false;
        }
        let (w, x) = (at.0.exp(), self.amplitudes.x(at.1).0);
        let same = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-7;
        if !found.iter().any(|old| same(old.0, w) && same(old.1, x)) {
            let (n, slope) = self.amplitudes.n(x);
            let growth = Complex::new(0.0, 1.0) * (slope / n) / self.response.log_slope(w);
            found.push((w, x, growth.re > 0.0));
        }
        true
    }
}

/// The pairs of edges, one of each curve, that cross; phases count up to whole turns.
fn crossings(a: &[Vertex], b: &[Vertex]) -> Vec<(usize, usize)> {
    /// Edges in a block, which is skipped if its box does not overlap.
    const BLOCK: usize = 16;
    let frame = |vertices: &[Vertex]| {
        let fold = |i: usize| {
            vertices
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v[i]), h.max(v[i])))
        };
        (fold(1), fold(2))
    };
    let apart = |p: (f64, f64), q: (f64, f64)| p.0 > q.1 || q.0 > p.1;
    let turn = 2.0 * PI;
    let blocks: Vec<_> = (0..b.len().saturating_sub(1))
        .step_by(BLOCK)
        .map(|from| {
            let to = (from + BLOCK).min(b.len() - 1);
            (from, to, frame(&b[from..=to]))
        })
        .collect();
    let (phases, _) = frame(b);
    let mut pairs = vec![];
    for i in 0..a.len().saturating_sub(1) {
        let (p, q) = (a[i], a[i + 1]);
        if !p.iter().chain(&q).all(|c| c.is_finite()) {
            continue;
        }
        let (low, high) = (p[1].min(q[1]), p[1].max(q[1]));
        let gains = (p[2].min(q[2]), p[2].max(q[2]));
        let turns =
            (((low - phases.1) / turn).ceil() as i64, ((high - phases.0) / turn).floor() as i64);
        for k in turns.0..=turns.1 {
            let shift = k as f64 * turn;
            let phase = (low - shift, high - shift);
            for (from, to, (block_phase, block_gain)) in &blocks {
                if apart(phase, *block_phase) || apart(gains, *block_gain) {
                    continue;
                }
                for m in *from..*to {
                    let moved = |v: Vertex| (v[1] - shift, v[2]);
                    if cross(moved(p), moved(q), (b[m][1], b[m][2]), (b[m + 1][1], b[m + 1][2])) {
                        pairs.push((i, m));
                    }
                }
            }
        }
    }
    pairs
}

/// Whether the edge from `p` to `q` meets the edge from `r` to `s`. Ends are included with a small margin, so that
/// rounding misses nothing.
fn cross(p: (f64, f64), q: (f64, f64), r: (f64, f64), s: (f64, f64)) -> bool {
    const MORE: f64 = 1e-9;
    let (d, e, f) = ((q.0 - p.0, q.1 - p.1), (s.0 - r.0, s.1 - r.1), (r.0 - p.0, r.1 - p.1));
    let determinant = d.0 * e.1 - d.1 * e.0;
    let along = (f.0 * e.1 - f.1 * e.0) / determinant;
    let other = (f.0 * d.1 - f.1 * d.0) / determinant;
    let inside = |share: f64| (-MORE..=1.0 + MORE).contains(&share);
    inside(along) && inside(other)
}
