//! The response of a sticking valve to a sine: the describing function of every model.
//!
//! # What it computes
//! The complex gain `N(X)` from the OP, a sine of amplitude `X`, to the fundamental of the VP, in the steady motion
//! with the same middle as the OP: in closed form by [`DescribingFunction`], and for any valve by simulation over a
//! period, [`by_integration`].
//!
//! # Assumptions
//! The valve responds in continuous time: the limit of its model as the sample time goes to 0. It was moving
//! before. A valve at rest in the middle starts to move only once the OP exceeds `fs`, but continues to move above
//! the smaller [`DescribingFunction::least_amplitude`].
//!
//! # Equations
//! With `u = X cos q`, the VP `x`, and `N = 1 / (pi X) * integral of x exp(-jq) dq` over a period:
//!
//! A valve that **slides** rests at `x = X - fd` after the peak until the OP has returned by `R`, and then
//! follows with `x = u + fd`. With `cos a = 1 - R/X`, for `X > R/2`:
//! ```text
//! Re N = [pi - a + 2 (1 - 2 fd/X) sin a - sin a cos a] / pi
//! Im N = -[R^2 + 4 fd (X - R)] / (pi X^2)
//! ```
//! `R = S` for the two-phase model, for Kano's, Chen's and play (`J = 0`), and Choudhury's with `J <= S`; `R = J`
//! for Choudhury's with `J > S`, whose flow chart uses `J` at a reversal.
//!
//! A valve that climbs **stairs** of height `J` is a sum of relays with hysteresis. With `n` slips per stroke,
//! the `k`-th at `h = (S - (n-1) J) / 2 + k J`, for `(S + (n-1) J) / 2 < X <= (S + (n+1) J) / 2`:
//! ```text
//! N = 2 J / (pi X) * sum over k = 0 .. n-1 of [sqrt(1 - (h/X)^2) - j h/X],    Im N = -n J S / (pi X^2)
//! ```
//! The same holds for He's model. He and Wang's with the overshoot `K` has `K J` for `J` and `S - (K-1) J` for `S`,
//! and Stenman's has `S = J = d`. The ranges of `n` and `n + 1` overlap: the position of the stairs decides, and
//! both are steady.
//!
//! In both, `Im N = -A / (pi X^2)` with the area `A` that the path of `x` over `u` encloses.
//!
//! # Limits
//! Only motions whose VP has the same middle as the OP. The VP of a valve that slides always has. He's stairs may have any
//! position in between, with a mean VP that differs from the mean OP. A sine is an assumption: the cycle of a real
//! loop is not one.
//!
//! # References
//! M. A. A. S. Choudhury, N. F. Thornhill, S. L. Shah, "Modelling valve stiction", Control Engineering
//! Practice 13 (2005) 641-658, has the first closed form in its appendix (recalled, not read; derived and
//! confirmed by integration here). The relay: A. Gelb, W. E. Vander Velde, "Multiple-Input Describing
//! Functions and Nonlinear System Design", 1968 (recalled, not read).

use crate::bands::Bands;
use crate::error::{Error, Result, positive};
use crate::valve::{Direction, HeWang, Model, Start, Valve};
use nalgebra::Complex;
use std::f64::consts::PI;

/// The response of a valve to a sine of the OP.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Response {
    /// It does not move: the sine is too small.
    Stuck,
    /// It moves.
    Moves {
        /// The gain from OP to the fundamental of the VP.
        n: Complex<f64>,
        /// Slips in one direction; 0 for a valve without friction.
        slips: usize,
    },
}

impl Response {
    /// The gain, if the valve moves.
    pub fn gain(self) -> Option<Complex<f64>> {
        match self {
            Self::Stuck => None,
            Self::Moves { n, .. } => Some(n),
        }
    }
}

/// A range of amplitudes with the same number of slips.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// Slips in one direction.
    pub slips: usize,
    /// The amplitude above which this motion exists, percent.
    pub from: f64,
    /// The largest amplitude of this motion, percent; may be infinite.
    pub to: f64,
}

/// The describing function of a valve, in closed form.
///
/// ```
/// use stiction_model::{Bands, limit_cycle::DescribingFunction, valve::Model};
///
/// let n = DescribingFunction::new(Model::TwoPhase, Bands::from_s_j(5.0, 2.0)?)?;
/// let gain = n.at(10.0)?.gain().expect("10 % moves it");
/// assert!((gain.re - 0.914765).abs() < 1e-6 && (gain.im + 0.175070).abs() < 1e-6);
/// assert_eq!(n.at(2.5)?.gain(), None);
/// # Ok::<(), stiction_model::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DescribingFunction(Motion);

/// Kind of response to a sine.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Motion {
    /// The identity.
    Follows,
    /// It rests until the OP has returned by `turn`, then follows it with a distance of `drag`.
    Slides { turn: f64, drag: f64 },
    /// It climbs steps of height `step`; up and down are `apart`.
    Stairs { apart: f64, step: f64 },
}

impl DescribingFunction {
    /// The most slips per stroke in the sum.
    pub const MAX_SLIPS: usize = 1_000_000;

    /// The describing function of `model` with these bands.
    ///
    /// # Errors
    /// If the model does not allow these bands.
    pub fn new(model: Model, bands: Bands) -> Result<Self> {
        model.build(bands)?;
        let (s, j, fd) = (bands.s(), bands.j(), bands.fd());
        let slides = |turn: f64, drag: f64| {
            if turn == 0.0 && drag == 0.0 { Motion::Follows } else { Motion::Slides { turn, drag } }
        };
        let stairs = |apart: f64, step: f64| {
            if step == 0.0 { slides(apart, apart / 2.0) } else { Motion::Stairs { apart, step } }
        };
        Ok(Self(match model {
            Model::TwoPhase | Model::Kano | Model::Chen => slides(s, fd),
            Model::Choudhury => slides(s.max(j), fd),
            Model::Play => slides(s, s / 2.0),
            Model::He => stairs(s, j),
            Model::HeWang => {
                let overshoot = HeWang::TYPICAL_OVERSHOOT;
                stairs(s - (overshoot - 1.0) * j, overshoot * j)
            }
            Model::Stenman => stairs(j, j),
            Model::Ideal => Motion::Follows,
        }))
    }

    /// The amplitude of the OP above which a motion sustains itself, percent.
    pub fn least_amplitude(&self) -> f64 {
        self.branch(1).map_or(0.0, |branch| branch.from)
    }

    /// The amplitudes at which the valve slips `slips` times in one direction; `None` if it never does.
    pub fn branch(&self, slips: usize) -> Option<Branch> {
        let (from, to) = match self.0 {
            Motion::Slides { turn, .. } if slips == 1 => (turn / 2.0, f64::INFINITY),
            Motion::Stairs { apart, step } if slips >= 1 => {
                let n = slips as f64;
                ((apart + (n - 1.0) * step) / 2.0, (apart + (n + 1.0) * step) / 2.0)
            }
            _ => return None,
        };
        Some(Branch { slips, from, to })
    }

    /// The response to a sine of amplitude `x`, percent. If several responses are possible, it is the one with the
    /// fewest slips.
    ///
    /// # Errors
    /// If `x` is not positive, or there would be more than [`DescribingFunction::MAX_SLIPS`] slips.
    pub fn at(&self, x: f64) -> Result<Response> {
        positive("amplitude of the OP", x)?;
        if let Motion::Follows = self.0 {
            return Ok(Response::Moves { n: Complex::new(1.0, 0.0), slips: 0 });
        }
        if x <= self.least_amplitude() {
            return Ok(Response::Stuck);
        }
        let slips = self.fewest_slips(x)?;
        Ok(Response::Moves { n: self.on_branch(slips, x).0, slips })
    }

    /// The response to a sine of amplitude `x`, percent, with exactly this many slips per stroke.
    ///
    /// # Errors
    /// If the valve does not slip this often under this sine. The message states the range of amplitudes in which it
    /// does.
    pub fn with_slips(&self, slips: usize, x: f64) -> Result<Complex<f64>> {
        positive("amplitude of the OP", x)?;
        match self.branch(slips) {
            Some(branch) if branch.from < x && x <= branch.to && slips <= Self::MAX_SLIPS => {
                Ok(self.on_branch(slips, x).0)
            }
            Some(Branch { from, to, .. }) => Err(Error::Inconsistent(format!(
                "with {slips} slips per stroke the amplitude of the OP is above {from} % and at most {to} %, \
                 but it is {x} %"
            ))),
            None => {
                Err(Error::Inconsistent(format!("the valve never makes {slips} slips per stroke")))
            }
        }
    }

    /// The valve at the peak of a sine of amplitude `x`, in the motion of [`DescribingFunction::at`], for starting
    /// a model in it. `None` if the valve is stuck.
    ///
    /// # Errors
    /// As [`DescribingFunction::at`].
    pub fn at_peak(&self, x: f64) -> Result<Option<Start>> {
        let Response::Moves { slips, .. } = self.at(x)? else { return Ok(None) };
        let position = match self.0 {
            Motion::Follows => x,
            Motion::Slides { drag, .. } => x - drag,
            Motion::Stairs { step, .. } => slips as f64 * step / 2.0,
        };
        Ok(Some(Start { position, op: x, direction: Direction::Up, moving: true }))
    }

    /// The least number of slips under a sine that moves the valve.
    fn fewest_slips(&self, x: f64) -> Result<usize> {
        let Motion::Stairs { apart, step } = self.0 else { return Ok(1) };
        let slips = (((2.0 * x - apart) / step).ceil() - 1.0).max(1.0);
        if slips <= Self::MAX_SLIPS as f64 {
            Ok(slips as usize)
        } else {
            Err(Error::Inconsistent(format!(
                "slips of {step} % under an OP of amplitude {x} % are more than {} a stroke; without a slip jump \
                 the valve has only backlash",
                Self::MAX_SLIPS
            )))
        }
    }

    /// Lag of the VP behind the OP for a valve that slides, percent; 0 for other valves.
    pub(super) fn trail(&self) -> f64 {
        if let Motion::Slides { drag, .. } = self.0 { drag.abs() } else { 0.0 }
    }

    /// `N` and its derivative with respect to `X` on the branch of `slips`, within its range.
    pub(super) fn on_branch(&self, slips: usize, x: f64) -> (Complex<f64>, Complex<f64>) {
        match self.0 {
            Motion::Follows => (Complex::new(1.0, 0.0), Complex::new(0.0, 0.0)),
            Motion::Slides { turn, drag } => sliding(turn, drag, x),
            Motion::Stairs { apart, step } => {
                let lowest = (apart - (slips as f64 - 1.0) * step) / 2.0;
                let (mut n, mut slope) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
                for k in 0..slips {
                    let h = lowest + k as f64 * step;
                    // Without the square of X, whose difference would lose all digits at X = h.
                    let root = ((x - h) * (x + h)).max(0.0).sqrt();
                    n += Complex::new(root, -h);
                    slope += Complex::new(x / root - 2.0 * root / x, 2.0 * h / x);
                }
                let scale = 2.0 * step / (PI * x * x);
                (scale * n, scale * slope)
            }
        }
    }
}

fn sliding(turn: f64, drag: f64, x: f64) -> (Complex<f64>, Complex<f64>) {
    let half = (turn / (2.0 * x)).min(1.0).sqrt();
    let (angle, cos) = (2.0 * half.asin(), 1.0 - turn / x);
    let sin = 2.0 * half * (1.0 - half * half).sqrt();
    let free = 1.0 - 2.0 * drag / x;
    let re = PI - angle + (2.0 * free - cos) * sin;
    let im = -(turn * turn + 4.0 * drag * (x - turn)) / (x * x);
    let turning = -turn / (x * x * sin);
    let turning = if turn == 0.0 { 0.0 } else { turning };
    let slope = Complex::new(
        -turning
            + 4.0 * drag * sin / (x * x)
            + turning * (2.0 * free * cos - cos * cos + sin * sin),
        -2.0 * im / x - 4.0 * drag / (x * x),
    );
    (Complex::new(re, im) / PI, slope / PI)
}

/// The response of any valve to a sine of amplitude `x`, percent, by simulation.
///
/// The OP begins at its peak, with the valve in its given state, and continues until the motion repeats itself.
/// Where `valve` neither rests nor moves in proportion to the OP, the step is halved until slips are located to
/// rounding. In between, the integral is exact. So `N` is accurate to about 1e-9 for a model whose VP depends on
/// the path of the OP but not on its speed, as all of [`Model`] do.
///
/// Two cases fail. With `S = 0` and a slip jump, the valve is at its threshold whenever it stops, and rounding
/// decides. He and Wang's model with `J = 0` and an overshoot jumps at every step.
///
/// # Errors
/// If `x` is not positive, the valve jumps at any step size, the motion does not repeat itself within 100 periods,
/// or two successive numbers of steps do not agree.
pub fn by_integration<V: Valve + Clone>(valve: &V, x: f64) -> Result<Response> {
    const STEPS: [usize; 5] = [500, 1_000, 2_000, 4_000, 8_000];
    positive("amplitude of the OP", x)?;
    let mut before = None;
    for steps in STEPS {
        let found =
            Follower { valve: valve.clone(), x, sum: Complex::default(), slips: 0, steps: 0 }
                .settle(steps)?;
        match (before, found) {
            (Some(Response::Stuck), Response::Stuck) => return Ok(found),
            (Some(Response::Moves { n, .. }), Response::Moves { n: finer, .. })
                if (n - finer).norm() <= 1e-10 * (1.0 + n.norm()) =>
            {
                return Ok(found);
            }
            _ => before = Some(found),
        }
    }
    Err(Error::Inconsistent(format!(
        "the response to an OP of amplitude {x} % still depends on the number of steps at {} per period",
        STEPS[STEPS.len() - 1]
    )))
}

/// A valve under `x cos q`.
struct Follower<V> {
    valve: V,
    x: f64,
    /// The integral of `exp(-jq) dx` over the period so far.
    sum: Complex<f64>,
    /// Slips upwards in the period so far.
    slips: usize,
    /// Steps in the period so far.
    steps: usize,
}

impl<V: Valve + Clone> Follower<V> {
    /// The largest slope of VP over OP apart from slips.
    const STEEP: f64 = 8.0;
    /// The most steps in a period; enough for thousands of slips.
    const MOST_STEPS: usize = 1_000_000;
    /// The narrowest step, in radians.
    const NARROW: f64 = 1e-13;

    fn op(&self, q: f64) -> f64 {
        self.x * q.cos()
    }

    fn settle(mut self, steps: usize) -> Result<Response> {
        const PERIODS: usize = 100;
        let tolerance = 1e-11 * self.x;
        self.valve.step(self.x);
        let mut before = Complex::default();
        for period in 0..PERIODS {
            let begin = self.valve.position();
            (self.sum, self.slips, self.steps) = (Complex::default(), 0, 0);
            let angle = |k: usize| 2.0 * PI * k as f64 / steps as f64;
            for k in 0..steps {
                self.advance(angle(k), angle(k + 1));
            }
            if self.steps >= Self::MOST_STEPS {
                return Err(Error::Inconsistent(format!(
                    "under an OP of amplitude {} % the valve jumps at any step size",
                    self.x
                )));
            }
            let repeats = (self.valve.position() - begin).abs() <= tolerance;
            if period > 0 && repeats && (self.sum - before).norm() <= tolerance {
                if self.sum.norm() <= tolerance {
                    return Ok(Response::Stuck);
                }
                let n = Complex::new(0.0, -1.0) * self.sum / (PI * self.x);
                return Ok(Response::Moves { n, slips: self.slips });
            }
            before = self.sum;
        }
        Err(Error::Inconsistent(format!(
            "under an OP of amplitude {} % the valve does not repeat itself within {PERIODS} periods",
            self.x
        )))
    }

    /// Takes the OP from phase `a` to phase `b`.
    fn advance(&mut self, a: f64, b: f64) {
        let mid = 0.5 * (a + b);
        let (from, middle, to) = (self.op(a), self.op(mid), self.op(b));
        let begin = self.valve.position();
        let mut probe = self.valve.clone();
        let half_way = probe.step(middle);
        let end = probe.step(to);
        let change = end - begin;
        let share = if to == from { 0.5 } else { (middle - from) / (to - from) };
        let rounding = 1e-13 * self.x.max(end.abs());
        // A slip where the OP hardly changes, near its peak, is not a steep line.
        let straight = change.abs() <= Self::STEEP * (to - from).abs() + rounding
            && (half_way - begin - share * change).abs() <= rounding;
        self.steps += 1;
        let narrow = b - a <= Self::NARROW || self.steps >= Self::MOST_STEPS;
        if !(straight || narrow) {
            self.advance(a, mid);
            self.advance(mid, b);
            return;
        }
        self.valve = probe;
        if narrow || to == from {
            self.sum += Complex::new(mid.cos(), -mid.sin()) * change;
            self.slips += usize::from(change > 1e-9 * self.x);
        } else if change != 0.0 {
            // The integral of exp(-jq) sin q.
            let whole =
                |q: f64| Complex::new(0.5 * q.sin() * q.sin(), 0.25 * (2.0 * q).sin() - 0.5 * q);
            self.sum -= self.x * change / (to - from) * (whole(b) - whole(a));
        }
    }
}
