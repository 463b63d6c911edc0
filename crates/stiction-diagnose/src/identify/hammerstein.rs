//! How much better a sticking valve before a linear process explains a PV than a valve that follows.
//!
//! # What it measures
//! Candidates of S and J are tried in two models of a valve. Their one-step predictions of the PV are compared with a
//! prediction from the OP. Several controls accompany this evidence: the same in reversed time, under a disturbance
//! that wanders, and without the PV's past. Rivals that also have corners are a load that jumps, a sensor with play,
//! and the same valve under an OP of another loop.
//!
//! # Assumptions
//! One valve before one linear process. An oscillation, or another motion of the OP, covers several times S. The
//! samples are dense enough to show the slips: 36 to 72 a period, for which the default grids are made. OP and PV
//! have mean 0 and variance 1; slow trends do not dominate.
//!
//! # Equations
//! For each candidate, `x = valve(u; S, J)` with `x(0) = u(0)`, and by least squares
//! ```text
//! y(k) = c + sum_{i=1..5} a_i y(k-i) + sum_{j=0..3} b_j x(k-d-j) + e(k),    d >= 1
//! gain = ln(SSE with x = u / SSE),                    each with its own best delay d
//! information = ln(1 + max(0, m gain - 2 ln m))       over m samples (Schwarz, two parameters more)
//! ```
//! With `d = 0` the regression finds the controller's inverse instead of the process, so it is never tried.
//! * Reversed: OP and PV backwards. A cause precedes its effect, so a true gain disappears.
//! * Walk: both sides differenced, which whitens a disturbance that is a random walk.
//! * Output error: `y = g z(k-d)`, where z is x through a first-order lag or an integrator, both less their
//!   moving mean over 1.5 periods, and g has the sign of `-sum dOP dPV`; `gain = ln(1 - R2 with u) -
//!   ln(1 - R2)`.
//! * Load that jumps: the regression with u plus a square wave that changes sign whenever the best model's valve
//!   reverses. It explains corners without friction.
//! * Placebo: valves driven by the OP of half a period earlier, mirrored. A regular wave looks the same there, so the
//!   placebo explains everything that depends only on the period.
//! * Sensor: the output error of u behind a sensor with play.
//! * Slips: see [`Slips`] and [`Steadiness`].
//!
//! # Parameters
//! | name | default | unit | source |
//! |---|---|---|---|
//! | S | 16 values, 0.04 to 1.08 | span of the OP | ours |
//! | J | 0.05, 0.2, 0.4, 0.6, 0.8, 1 | S | ours |
//! | delays | 1 and 2 samples; 0.05, 0.1, 0.16, 0.24 | period | ours |
//!
//! The grid is refined around its three best S that lie a factor 1.2 apart, along J = 0 and 0.1 S, and once more around
//! the best of all, with a final parabola in ln S. The span of the OP is the span of its middle 98 % after subtraction
//! of a moving mean over two periods.
//!
//! # Limits
//! The gain compares predictions and is not a probability. A wave with corners from elsewhere gains as well, so the
//! controls are needed. S is biased if the valve moves between samples. J is often not identifiable: see
//! [`ValveFit::jump_gain`]. For a valve by He with a large slip jump, a two-phase valve with an S larger by the OP's
//! overrun often wins, because the valley of He's own S is narrower than the grid. If the load wanders, the output
//! error may be evidence against a sticking valve. A dead band (J = 0) can hardly be distinguished from play in the
//! sensor.
//!
//! # References
//! Structure and search after R. Srinivasan, R. Rengaswamy, S. Narasimhan, R. Miller, Ind. Eng. Chem. Res.
//! 44 (2005) 6719; M. Jelali, J. Process Control 18 (2008); random-walk disturbance after S. Karra, M. N.
//! Karim, Control Eng. Practice 17 (2009) 939; comparison of linear models after R. Bacci di Capaci, C.
//! Scali, Chem. Eng. Res. Des. 130 (2018): all recalled, not read. The lag sums, the controls and rivals,
//! and their combination are ours.

pub use super::slips::{Slips, Steadiness};

use super::arx::{Fits, Target};
use super::output_error::{Response, without_slow};
use super::slips::Motion;
use crate::bands::Bands;
use crate::finding::Abstention;
use crate::numeric::least_squares::RIDGE;
use crate::series::{excess_kurtosis, quantile, std};
use crate::simd::{LANES, Lane, Width};
use crate::valve::lanes::{Laned, follow};
use crate::valve::{He, Model, Start, TwoPhase};

/// Fewest samples.
pub const FEWEST_SAMPLES: usize = 100;
/// Fewest samples a period: with fewer, corners are invisible.
pub const SHORTEST_PERIOD: f64 = 4.0;
/// J/S up to which a valve counts as one without a slip jump.
pub const NO_JUMP: f64 = 0.1;
/// Rise of `ln SSE` within which an S explains the PV almost as well as the best.
pub const RISE: f64 = 0.02;

/// Number of basins to refine, and their smallest distance in ln S.
const BASINS: usize = 3;
const APART: f64 = 0.2;
/// Steps in ln S and in J/S around a candidate to be refined, and around the best at the end.
const STEPS: [[f64; 2]; 2] = [[0.075, 0.15], [0.025, 0.07]];
/// Steps in ln S along a valve without slip jump.
const STEP_WITHOUT_JUMP: f64 = 0.06;
/// Candidates of the two-phase model that are compared in parallel with the candidates of He's model, after the valve
/// that follows.
const SIDE_BY_SIDE: usize = LANES / 2 - 1;
/// Widths of the play in a sensor, steps of a share of the range of its input.
const SENSOR_STEP: f64 = 0.06;

/// The candidates.
#[derive(Debug, Clone, PartialEq)]
pub struct HammersteinOptions {
    /// First values of S, shares of the OP's span without its slow part, ascending.
    pub s_over_span: Vec<f64>,
    /// First values of J, shares of S.
    pub j_over_s: Vec<f64>,
    /// Delays beside one and two samples, shares of the period, at most 1.
    pub delays: Vec<f64>,
}

impl Default for HammersteinOptions {
    fn default() -> Self {
        Self {
            s_over_span: vec![
                0.04, 0.07, 0.11, 0.16, 0.21, 0.27, 0.33, 0.4, 0.47, 0.55, 0.63, 0.71, 0.8, 0.89,
                0.98, 1.08,
            ],
            j_over_s: vec![0.05, 0.2, 0.4, 0.6, 0.8, 1.0],
            delays: vec![0.05, 0.1, 0.16, 0.24],
        }
    }
}

impl HammersteinOptions {
    /// Whether the grids are valid.
    fn check(&self) -> Result<(), Abstention> {
        let ok = |grid: &[f64], low: f64, high: f64| {
            grid.iter().all(|v| v.is_finite() && *v >= low && *v <= high)
        };
        let (s, j) = (&self.s_over_span, &self.j_over_s);
        if s.is_empty() || j.is_empty() {
            return Err(Abstention("there are no candidates of S or J".to_owned()));
        }
        if !(ok(s, 1e-3, 1e3) && ok(j, 0.0, 1.0) && ok(&self.delays, 0.0, 1.0)) {
            return Err(Abstention(
                "candidates of S must lie between 0.001 and 1000 spans, candidates of J between 0 and \
                 1 S, delays between 0 and 1 periods"
                    .to_owned(),
            ));
        }
        Ok(())
    }

    /// The first pairs of S and J.
    fn grid(&self) -> Vec<(f64, f64)> {
        let of_s = |j: &f64| self.s_over_span.iter().map(move |s| (*s, *j)).collect::<Vec<_>>();
        self.j_over_s.iter().flat_map(of_s).collect()
    }
}

/// The process with a valve that follows the OP.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearFit {
    /// Mean square of the one-step prediction error, variances of the PV.
    pub mse: f64,
    /// Delay, samples.
    pub delay: usize,
    /// Excess kurtosis of the error: large if the PV jumps now and then.
    pub kurtosis: f64,
}

/// The process behind a sticking valve of one model.
#[derive(Debug, Clone, PartialEq)]
pub struct ValveFit {
    /// The valve's model.
    pub model: Model,
    /// S, share of [`ModelEvidence::op_span`].
    pub s_over_span: f64,
    /// J, share of S.
    pub j_over_s: f64,
    /// Delay, samples.
    pub delay: usize,
    /// Mean square of the one-step prediction error, variances of the PV.
    pub mse: f64,
    /// Evidence: `ln(SSE of the valve that follows / SSE)`.
    pub gain: f64,
    /// This error with Schwarz's criterion: `ln(1 + max(0, m gain - 2 ln m))`.
    pub information: f64,
    /// The part explained by the slip jump: `ln(SSE with J/S at most 0.1 / SSE)`. Near 0, J is not identified.
    pub jump_gain: f64,
    /// Logarithm of the ratio of the largest to the smallest S that explain the PV almost as well.
    pub width: f64,
    /// For each tried S, ascending: S, as a share of the span, and the smallest mean square over J and delay.
    pub profile: Vec<(f64, f64)>,
}

/// Without the PV's past: one lag and a delay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputError {
    /// Unexplained share of the PV's variance with a valve that follows the OP.
    pub linear: f64,
    /// Unexplained share with the best sticking valve among those that predict best.
    pub sticky: f64,
    /// Unexplained share with a valve that follows the OP, if the sensor has play.
    pub sensor: f64,
    /// S of that sticking valve, share of [`ModelEvidence::op_span`].
    pub s_over_span: f64,
}

impl OutputError {
    /// The unexplained shares of `candidates`, whose positions are `valves`.
    fn of(
        response: &Response,
        op: &[f64],
        valves: &[Lane],
        candidates: &[Candidate; LANES],
        width: Width,
    ) -> Self {
        let left = response.unexplained(valves, width);
        let explains = (1..LANES).min_by(|a, b| left[*a].total_cmp(&left[*b])).unwrap_or(1);
        let plays = Lane::from_fn(|l| SENSOR_STEP * l as f64);
        Self {
            linear: left[0],
            sticky: left[explains],
            sensor: least(&response.unexplained_by_sensor(op, &plays, width)[..]),
            s_over_span: candidates[explains].s,
        }
    }

    /// Evidence for the sticking valve: `ln(linear / sticky)`.
    pub fn gain(&self) -> f64 {
        (self.linear / self.sticky).ln()
    }

    /// Evidence for the sticking valve against play in the sensor: `ln(sensor / sticky)`.
    pub fn over_sensor(&self) -> f64 {
        (self.sensor / self.sticky).ln()
    }
}

/// The results of the models for a segment.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelEvidence {
    /// Number of predicted samples.
    pub samples: usize,
    /// Span of the OP without its slow part, in units of the given OP.
    pub op_span: f64,
    /// Behind a valve that follows.
    pub linear: LinearFit,
    /// Behind a two-phase valve.
    pub two_phase: ValveFit,
    /// Behind a valve by He.
    pub he: ValveFit,
    /// Excess kurtosis of the error behind the better of the two.
    pub kurtosis: f64,
    /// Gain of the first candidates of the two-phase model.
    pub forward_gain: f64,
    /// Gain of the first candidates in reversed time.
    pub reversed_gain: f64,
    /// Gain if the disturbance is a random walk.
    pub walk_gain: f64,
    /// Evidence against a load that jumps when the model slips: `ln(SSE with it / SSE)`.
    pub over_load: f64,
    /// Evidence against the same valves under another OP: `ln(their SSE / SSE)`.
    pub over_placebo: f64,
    /// Without the PV's past.
    pub output_error: OutputError,
    /// The PV at the slips of the better model.
    pub slips: Slips,
}

impl ModelEvidence {
    /// The valve that predicts the PV better.
    pub fn best(&self) -> &ValveFit {
        if self.he.mse < self.two_phase.mse { &self.he } else { &self.two_phase }
    }
}

/// Compares a sticking valve with one that follows.
///
/// `op` and `pv` are of one length, with mean 0 and variance 1; `period` is the dominant period in samples.
/// Everything is computed on the calling thread, and depends on nothing else.
///
/// ```
/// use stiction_model::closed_loop::NormalStream;
/// use stiction_diagnose::identify::hammerstein::{HammersteinOptions, weigh};
/// use stiction_model::valve::{Start, TwoPhase, Valve};
/// use stiction_model::Bands;
///
/// // A sticking valve, S a quarter of the OP's span, before a lag; and some noise.
/// let op: Vec<f64> = (0..1000).map(|k| 1.4 * (0.13 * k as f64).sin()).collect();
/// let mut valve = TwoPhase::new(Bands::from_s_j(0.7, 0.3)?);
/// valve.restart(Start::at_rest(0.0));
/// let (mut y, mut before, mut noise) = (0.0, 0.0, NormalStream::new(1));
/// let pv: Vec<f64> = op
///     .iter()
///     .map(|u| {
///         y = 0.8 * y + 0.2 * before;
///         before = valve.step(*u);
///         y + 0.01 * noise.draw()
///     })
///     .collect();
/// let pv = stiction_diagnose::series::standardised(&pv).expect("it moves");
/// let evidence = weigh(&op, &pv, 48.0, &HammersteinOptions::default()).expect("it can be weighed");
/// let valve = evidence.best();
/// assert!(valve.gain > 1.0);
/// assert!((valve.s_over_span * evidence.op_span / 0.7 - 1.0).abs() < 0.1);
/// # Ok::<(), stiction_model::Error>(())
/// ```
///
/// # Errors
/// If the series are shorter than [`FEWEST_SAMPLES`] samples or one period, a period has fewer than [`SHORTEST_PERIOD`]
/// samples, a signal is constant or not finite, or the candidates are invalid.
pub fn weigh(
    op: &[f64],
    pv: &[f64],
    period: f64,
    options: &HammersteinOptions,
) -> Result<ModelEvidence, Abstention> {
    options.check()?;
    check(op, pv, period)?;
    let flat = || Abstention("the OP or the PV does not move".to_owned());
    let fast = without_slow(op, period.round() as usize);
    let span = quantile(&fast, 0.99) - quantile(&fast, 0.01);
    if !(span > 1e-6) {
        return Err(flat());
    }

    let delays = delays(period, options);
    let width = Width::widest();
    let grid = options.grid();
    let target = Target::new(pv, &delays).ok_or_else(flat)?;
    let mut bench = Bench { op, span, target, width, vp: vec![] };
    let two_phase = Explored::by::<TwoPhase>(&mut bench, &grid).ok_or_else(flat)?;
    let he = Explored::by::<He>(&mut bench, &grid).ok_or_else(flat)?;
    let samples = bench.target.samples();
    let linear = two_phase.linear;

    let reversed_gain = {
        let [op, pv] = [op, pv].map(|x| x.iter().rev().copied().collect::<Vec<_>>());
        let target = Target::new(&pv, &delays).ok_or_else(flat)?;
        let mut bench = Bench { op: &op, span, target, width, vp: vec![] };
        Explored::first::<TwoPhase>(&mut bench, &grid).ok_or_else(flat)?.1
    };

    let candidates = side_by_side(linear, &two_phase.ranked, &he.ranked);
    let best = if he.ranked[0].sse < two_phase.ranked[0].sse { 1 + SIDE_BY_SIDE } else { 1 };
    let valves = bench.side_by_side(op, &candidates);

    let output_error =
        OutputError::of(&Response::new(op, pv, period), op, &valves, &candidates, width);
    let vp: Vec<f64> = valves.iter().map(|x| x[best]).collect();
    let motion = Motion::of(&vp);
    let delay = candidates[best].delay;
    let target = &bench.target;
    let (behind_op, behind_vp, beside_load) = target
        .explain(&[(op, linear.delay)])
        .zip(target.explain(&[(&vp, delay)]))
        .zip(target.explain(&[(op, linear.delay), (&motion.direction, delay)]))
        .map(|((a, b), c)| (a, b, c))
        .ok_or_else(flat)?;
    let slips = Slips::of(
        &motion,
        op,
        delay,
        period,
        target.first(),
        &behind_op.residual,
        &behind_vp.residual,
    );

    let half = (0.5 * period).round() as usize;
    let other_op: Vec<f64> = (0..op.len()).map(|k| -op[k.saturating_sub(half)]).collect();
    bench.vp = bench.side_by_side(&other_op, &candidates);
    let placebo = least(&bench.fit().sse[1..]);

    Ok(ModelEvidence {
        samples,
        op_span: span,
        linear: LinearFit {
            mse: linear.sse / samples as f64,
            delay: linear.delay,
            kurtosis: kurtosis(&behind_op.residual),
        },
        kurtosis: kurtosis(&behind_vp.residual),
        forward_gain: two_phase.first_gain,
        reversed_gain,
        walk_gain: walk_gain(pv, &valves, &delays, width),
        over_load: gain(beside_load.sse, behind_vp.sse, samples),
        over_placebo: gain(placebo, candidates[best].sse, samples),
        output_error,
        slips,
        two_phase: two_phase.fit(Model::TwoPhase, samples),
        he: he.fit(Model::He, samples),
    })
}

/// Whether there is enough data.
fn check(op: &[f64], pv: &[f64], period: f64) -> Result<(), Abstention> {
    let n = op.len();
    if n != pv.len() || n < FEWEST_SAMPLES {
        return Err(Abstention(format!(
            "needs at least {FEWEST_SAMPLES} samples of both OP and PV; there are {n} and {}",
            pv.len()
        )));
    }
    if !(period >= SHORTEST_PERIOD && period <= n as f64) {
        return Err(Abstention(format!(
            "needs a period of at least {SHORTEST_PERIOD} samples that fits in the {n} samples; the period has {period:.1} samples"
        )));
    }
    if op.iter().chain(pv).any(|v| !v.is_finite()) {
        return Err(Abstention("a sample is not finite".to_owned()));
    }
    Ok(())
}

/// The delays to try, samples, ascending.
fn delays(period: f64, options: &HammersteinOptions) -> Vec<usize> {
    let mut delays = vec![1, 2];
    delays.extend(options.delays.iter().map(|share| (share * period).round() as usize));
    delays.retain(|delay| *delay > 0);
    delays.sort_unstable();
    delays.dedup();
    delays
}

/// `ln(a / b)` of two sums of squares of series of variance one; values below rounding and ridge count as zero.
fn gain(a: f64, b: f64, samples: usize) -> f64 {
    let floor = 10.0 * RIDGE * samples as f64;
    ((a.max(0.0) + floor) / (b.max(0.0) + floor)).ln()
}

/// The smallest of some numbers.
fn least(x: &[f64]) -> f64 {
    x.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Excess kurtosis; 0 without data.
fn kurtosis(x: &[f64]) -> f64 {
    Some(excess_kurtosis(x)).filter(|v| v.is_finite()).unwrap_or(0.0)
}

/// The gain of the best valve over the valve in the first lane if both sides are differenced; 0 if nothing remains.
fn walk_gain(pv: &[f64], valves: &[Lane], delays: &[usize], width: Width) -> f64 {
    let dy: Vec<f64> = pv.windows(2).map(|w| w[1] - w[0]).collect();
    let scale = 1.0 / std(&dy);
    let dy: Vec<f64> = dy.iter().map(|v| v * scale).collect();
    let Some(target) = Target::new(&dy, delays) else { return 0.0 };
    let dx: Vec<Lane> =
        valves.windows(2).map(|w| Lane::from_fn(|l| scale * (w[1][l] - w[0][l]))).collect();
    let sse = target.fit(&dx, width).sse;
    let walk = gain(sse[0], least(&sse[1..]), target.samples());
    if walk.is_finite() { walk } else { 0.0 }
}

/// A tried pair of S and J.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Candidate {
    /// Share of the span.
    s: f64,
    /// Share of S.
    j: f64,
    sse: f64,
    delay: usize,
}

/// The valve that follows and the best of each model.
fn side_by_side(
    linear: Candidate,
    two_phase: &[Candidate],
    he: &[Candidate],
) -> [Candidate; LANES] {
    std::array::from_fn(|l| match l {
        0 => linear,
        _ if l <= SIDE_BY_SIDE => two_phase[(l - 1).min(two_phase.len() - 1)],
        _ => he[(l - 1 - SIDE_BY_SIDE).min(he.len() - 1)],
    })
}

/// Tries candidates.
struct Bench<'a> {
    op: &'a [f64],
    span: f64,
    target: Target,
    width: Width,
    /// Positions of sixteen valves.
    vp: Vec<Lane>,
}

impl Bench<'_> {
    /// Moves valves, up to sixteen, along `op`.
    fn follow<M: Laned>(&mut self, op: &[f64], pairs: &[(f64, f64)]) {
        let bands = std::array::from_fn(|l| {
            let (s, j) = pairs[l.min(pairs.len() - 1)];
            let s = s * self.span;
            Bands::from_s_j(s, j * s).unwrap_or(Bands::NONE)
        });
        self.vp.resize(op.len(), Lane::splat(0.0));
        follow::<M>(&bands, Start::at_rest(op[0]), op, &mut self.vp, self.width);
    }

    fn fit(&self) -> Fits {
        self.target.fit(&self.vp, self.width)
    }

    /// Tries `pairs` of S and J, and adds their errors to `tried`.
    fn try_all<M: Laned>(&mut self, pairs: &[(f64, f64)], tried: &mut Vec<Candidate>) {
        let op = self.op;
        for pairs in pairs.chunks(LANES) {
            self.follow::<M>(op, pairs);
            let Fits { sse, delay } = self.fit();
            let found = pairs.iter().zip(sse.iter().zip(delay));
            tried.extend(found.map(|(&(s, j), (&sse, delay))| Candidate { s, j, sse, delay }));
        }
    }

    /// The positions of valves along `op`: first two-phase ones, then He's.
    fn side_by_side(&mut self, op: &[f64], candidates: &[Candidate; LANES]) -> Vec<Lane> {
        let pairs = candidates.map(|c| (c.s, c.j));
        self.follow::<TwoPhase>(op, &pairs);
        let mut valves = self.vp.clone();
        self.follow::<He>(op, &pairs);
        for (x, he) in valves.iter_mut().zip(&self.vp) {
            x[1 + SIDE_BY_SIDE..].copy_from_slice(&he[1 + SIDE_BY_SIDE..]);
        }
        valves
    }
}

/// The best of some candidates.
fn best<'a>(candidates: impl IntoIterator<Item = &'a Candidate>) -> Option<Candidate> {
    candidates.into_iter().copied().min_by(|a, b| a.sse.total_cmp(&b.sse))
}

/// All tried candidates of one model.
struct Explored {
    linear: Candidate,
    /// Gain of the best of the first candidates.
    first_gain: f64,
    /// The best first.
    ranked: Vec<Candidate>,
}

impl Explored {
    /// Tries the first candidates, the valve that follows before all; `None` without a result. They return with
    /// their gain.
    fn first<M: Laned>(
        bench: &mut Bench<'_>,
        grid: &[(f64, f64)],
    ) -> Option<(Vec<Candidate>, f64)> {
        let mut tried = vec![];
        let mut pairs = vec![(0.0, 0.0)];
        pairs.extend(grid);
        bench.try_all::<M>(&pairs, &mut tried);
        let gain = gain(tried[0].sse, best(&tried[1..])?.sse, bench.target.samples());
        gain.is_finite().then_some((tried, gain))
    }

    fn by<M: Laned>(bench: &mut Bench<'_>, grid: &[(f64, f64)]) -> Option<Self> {
        let (mut tried, first_gain) = Self::first::<M>(bench, grid)?;
        let linear = tried.remove(0);
        let coarse = tried.clone();
        let [near, nearer] = STEPS;
        // The valley of a valve that never slides is narrow, and the widest basin is not always the deepest.
        let mut basins: Vec<Candidate> = vec![];
        for _ in 0..BASINS {
            let apart = |c: &&Candidate| basins.iter().all(|b| (c.s / b.s).ln().abs() > APART);
            let Some(basin) = best(coarse.iter().filter(apart)) else { break };
            bench.try_all::<M>(&around(basin, near), &mut tried);
            basins.push(basin);
        }
        let least_jump = least(&coarse.iter().map(|c| c.j).collect::<Vec<_>>());
        let start = best(coarse.iter().filter(|c| c.j == least_jump))?;
        let along = |j: f64| {
            (0..8).map(move |i| (start.s * (STEP_WITHOUT_JUMP * (f64::from(i) - 3.5)).exp(), j))
        };
        bench.try_all::<M>(&along(0.0).chain(along(NO_JUMP)).collect::<Vec<_>>(), &mut tried);
        bench.try_all::<M>(&around(best(&tried)?, nearer), &mut tried);
        tried.sort_by(|a, b| a.sse.total_cmp(&b.sse));
        Some(Self { linear, first_gain, ranked: tried })
    }

    fn fit(&self, model: Model, samples: usize) -> ValveFit {
        let best = self.ranked[0];
        let mse = |c: &Candidate| c.sse.max(0.0) / samples as f64;
        let won = gain(self.linear.sse, best.sse, samples);
        let m = samples as f64;
        let jumpless = self.ranked.iter().find(|c| c.j <= NO_JUMP).unwrap_or(&best);
        let good = self.ranked.iter().take_while(|c| gain(c.sse, best.sse, samples) <= RISE);
        let (low, high) = good.fold((best.s, best.s), |(a, b), c| (a.min(c.s), b.max(c.s)));
        let mut by_s: Vec<(f64, f64)> = self.ranked.iter().map(|c| (c.s, mse(c))).collect();
        by_s.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        by_s.dedup_by_key(|point| point.0);
        ValveFit {
            model,
            s_over_span: self.vertex(),
            j_over_s: best.j,
            delay: best.delay,
            mse: mse(&best),
            gain: won,
            information: (m * won - 2.0 * m.ln()).max(0.0).ln_1p(),
            jump_gain: gain(jumpless.sse, best.sse, samples),
            width: (high / low).ln(),
            profile: by_s,
        }
    }

    /// S at the vertex of a parabola in ln S through the best candidate and its neighbours of the same J; S of the
    /// candidate at an edge of the grid.
    fn vertex(&self) -> f64 {
        let best = self.ranked[0];
        let beside = |side: f64| {
            let distance = |c: &&Candidate| side * (c.s / best.s).ln();
            self.ranked
                .iter()
                .filter(|c| c.j == best.j && distance(c) > 1e-6)
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let (Some(below), Some(above)) = (beside(-1.0), beside(1.0)) else { return best.s };
        let (a, b) = ((below.s / best.s).ln(), (above.s / best.s).ln());
        let (fall, rise) = ((below.sse - best.sse) / a, (above.sse - best.sse) / b);
        let curvature = (rise - fall) / (b - a);
        let slope = fall - curvature * a;
        let vertex = -0.5 * slope / curvature;
        // A parabola is reliable up to half the distance to a neighbour.
        if curvature > 0.0 { best.s * vertex.clamp(0.5 * a, 0.5 * b).exp() } else { best.s }
    }
}

/// Candidates around one: five values of S, three of J.
fn around(c: Candidate, [in_s, in_j]: [f64; 2]) -> Vec<(f64, f64)> {
    let js = [c.j - in_j, c.j, c.j + in_j].map(|j| j.clamp(0.0, 1.0));
    let of_s = |j: f64| (-2..=2).map(move |i| (c.s * (in_s * f64::from(i)).exp(), j));
    js.into_iter().flat_map(of_s).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::{ClosedLoop, Controller, Process, Signal, Wave};
    use crate::series::standardised;
    use crate::valve::Assembly;

    /// A PI loop about a first-order process, a thousand samples of 0.45 s after it has settled.
    struct Plant {
        model: Model,
        bands: Bands,
        load: Signal,
        noise: f64,
        seed: u64,
    }

    impl Plant {
        fn sticky(model: Model, s: f64, j: f64, seed: u64) -> Self {
            let load = Signal::RandomWalk { sd_per_sqrt_s: 0.05, seed: 100 + seed };
            Self { model, bands: Bands::from_s_j(s, j).unwrap(), load, noise: 0.03, seed }
        }

        fn healthy(load: Signal, seed: u64) -> Self {
            Self { model: Model::Ideal, bands: Bands::NONE, load, noise: 0.03, seed }
        }

        /// OP and PV as they are to be weighed, and what one of the OP's units is in percent.
        fn recorded(&self) -> (Vec<f64>, Vec<f64>, f64) {
            let mut plant = ClosedLoop::new(
                Controller::pi(1.1, 2.5).unwrap(),
                Assembly::new(self.model.build(self.bands).unwrap()),
                Process::first_order(1.5, 5.93, 1.07).unwrap(),
            );
            (plant.sample_time, plant.samples) = (0.45, 1400);
            plant.set_point = 5.0.into();
            plant.load = vec![self.load.clone()];
            let noise = |tau_s| Signal::Noise { sd: self.noise, tau_s, seed: self.seed };
            plant.measurement = vec![noise(0.0)];
            let run = plant.run().unwrap();
            let of = |x: &[f64]| standardised(&x[400..]).unwrap();
            (of(&run.op), of(&run.pv), std(&run.op[400..]))
        }

        fn weighed(&self, period: f64) -> (ModelEvidence, f64) {
            let (op, pv, unit) = self.recorded();
            (weigh(&op, &pv, period, &HammersteinOptions::default()).unwrap(), unit)
        }
    }

    fn wave(wave: Wave, amplitude: f64, period_s: f64) -> Signal {
        Signal::Periodic { wave, mean: 0.0, amplitude, period_s, phase: 0.1 }
    }

    #[test]
    fn s_is_recovered() {
        let mut errors = vec![];
        for seed in 0..6 {
            for model in [Model::TwoPhase, Model::He] {
                let s = 3.0 + seed as f64;
                let plant = Plant::sticky(model, s, s * (0.4 + 0.1 * seed as f64), seed);
                let (evidence, unit) = plant.weighed(42.0);
                let fit = evidence.best();
                // He's S counts from the last slip, not from where the OP turned: that of a two-phase
                // valve which explains the same PV is larger.
                if model == Model::TwoPhase {
                    errors.push((fit.s_over_span * evidence.op_span * unit / s - 1.0).abs());
                }
                assert!(fit.gain > 0.1, "{seed} {model:?}: {}", fit.gain);
                assert!(fit.delay >= 1 && evidence.linear.delay >= 1);
                assert!(fit.gain >= evidence.two_phase.gain && fit.gain >= evidence.he.gain);
                let profile = &fit.profile;
                assert!(profile.windows(2).all(|w| w[0].0 < w[1].0));
                assert!(profile.iter().all(|point| point.1 >= fit.mse));
            }
        }
        assert!(quantile(&errors, 0.5) < 0.05 && quantile(&errors, 0.9) < 0.15, "{errors:?}");
    }

    #[test]
    fn a_quiet_load_lets_the_output_error_speak() {
        for (s, j, seed) in [(3.0, 1.2, 0), (6.0, 4.2, 3)] {
            let mut plant = Plant::sticky(Model::TwoPhase, s, j, seed);
            plant.load = Signal::RandomWalk { sd_per_sqrt_s: 0.005, seed: 100 + seed };
            let (evidence, unit) = plant.weighed(42.0);
            let output = evidence.output_error;
            assert!(output.gain() > 0.3, "{output:?}");
            assert!(
                (output.s_over_span * evidence.op_span * unit / s - 1.0).abs() < 0.1,
                "{output:?}"
            );
        }
    }

    #[test]
    fn a_valve_that_follows_gains_nothing() {
        for seed in 0..4 {
            for load in [
                wave(Wave::Sine, 4.0, 20.0),
                Signal::RandomWalk { sd_per_sqrt_s: 0.3, seed: 50 + seed },
                Signal::Noise { sd: 2.0, tau_s: 10.0, seed: 60 + seed },
            ] {
                let (evidence, _) = Plant::healthy(load.clone(), seed).weighed(44.0);
                assert!(evidence.best().gain < 0.06, "{load:?}: {}", evidence.best().gain);
                assert!(evidence.walk_gain < 0.06, "{load:?}: {}", evidence.walk_gain);
            }
        }
    }

    #[test]
    fn a_square_load_from_elsewhere_is_less_steady_and_less_causal() {
        // Sums over several loops: one square wave may happen to look steady.
        let measured = |plant: Plant| {
            let (evidence, _) = plant.weighed(40.0);
            let steady = evidence.slips.steadiness.map_or(0.0, |s| s.of_travel_over_time());
            [steady, evidence.slips.removed, evidence.forward_gain - evidence.reversed_gain]
        };
        let (mut sticky, mut other) = ([0.0; 3], [0.0; 3]);
        for seed in 0..6 {
            let here = measured(Plant::sticky(Model::TwoPhase, 5.0, 3.0, seed));
            let period_s = 17.0 + seed as f64;
            let there = measured(Plant::healthy(wave(Wave::Square, 2.0, period_s), seed));
            for i in 0..3 {
                sticky[i] += here[i];
                other[i] += there[i];
            }
        }
        assert!((0..3).all(|i| sticky[i] > other[i]), "{sticky:?} {other:?}");
    }

    #[test]
    fn directions_do_not_matter() {
        let (op, pv, _) = Plant::sticky(Model::TwoPhase, 5.0, 2.0, 3).recorded();
        let minus = |x: &[f64]| x.iter().map(|v| -v).collect::<Vec<_>>();
        let options = HammersteinOptions::default();
        let upright = weigh(&op, &pv, 42.0, &options).unwrap();
        let mut values = vec![];
        crate::evidence::model::measure(Some(&upright), &mut values);
        for (op, pv) in
            [(minus(&op), pv.clone()), (op.clone(), minus(&pv)), (minus(&op), minus(&pv))]
        {
            let mirrored = weigh(&op, &pv, 42.0, &options).unwrap();
            let mut others = vec![];
            crate::evidence::model::measure(Some(&mirrored), &mut others);
            for (a, b) in values.iter().zip(&others) {
                assert!((a - b).abs() <= 1e-6 * a.abs().max(1.0), "{values:?} {others:?}");
            }
        }
        assert_eq!(weigh(&op, &pv, 42.0, &options).unwrap(), upright);
    }

    #[test]
    fn what_cannot_be_weighed_is_not() {
        let wave: Vec<f64> = (0..400).map(|k| 1.4 * (0.14 * f64::from(k)).sin()).collect();
        let with = |op: &[f64], pv: &[f64], period, options: &HammersteinOptions| {
            weigh(op, pv, period, options).map(|_| ()).unwrap_err().0
        };
        let options = HammersteinOptions::default();
        assert!(with(&wave[..50], &wave[..50], 20.0, &options).contains("at least 100 samples"));
        assert!(with(&wave, &wave[..200], 20.0, &options).contains("both"));
        for period in [f64::NAN, 2.0, 1e9] {
            assert!(with(&wave, &wave, period, &options).contains("period"));
        }
        let mut spoiled = wave.clone();
        spoiled[17] = f64::NAN;
        assert!(with(&wave, &spoiled, 45.0, &options).contains("finite"));
        assert!(with(&[0.0; 400], &wave, 45.0, &options).contains("not move"));
        assert!(with(&wave, &[0.0; 400], 45.0, &options).contains("not move"));
        let wrong = HammersteinOptions { s_over_span: vec![], ..options.clone() };
        assert!(with(&wave, &wave, 45.0, &wrong).contains("candidates"));
        let wrong = HammersteinOptions { delays: vec![1e12], ..options.clone() };
        assert!(with(&wave, &wave, 45.0, &wrong).contains("delays"));
    }

    #[test]
    fn whatever_is_weighed_is_finite() {
        let mut noise = crate::closed_loop::NormalStream::new(5);
        let sine: Vec<f64> = (0..300).map(|k| 1.4 * (0.14 * f64::from(k)).sin()).collect();
        let mut square: Vec<f64> = sine.iter().map(|v| v.signum()).collect();
        square[0] = 1.0;
        let white: Vec<f64> = (0..300).map(|_| noise.draw()).collect();
        let mut spike = vec![-0.05; 300];
        spike[150] = 17.0;
        let signals = [&sine, &square, &white, &spike];
        for op in signals {
            for pv in signals {
                for period in [4.0, 45.0, 300.0] {
                    let Ok(evidence) = weigh(op, pv, period, &HammersteinOptions::default()) else {
                        continue;
                    };
                    let mut values = vec![];
                    crate::evidence::model::measure(Some(&evidence), &mut values);
                    for (value, feature) in values.iter().zip(crate::evidence::model::FEATURES) {
                        let missing = evidence.slips.steadiness.is_none();
                        assert!(value.is_finite() || missing, "{}: {value}", feature.name);
                    }
                }
            }
        }
    }
}
