//! The linear part of a loop, without units.

use super::super::ContinuousLoop;
use super::series::DEGREE;
use crate::error::{Error, Result};
use nalgebra::Complex;
use nalgebra::{DMatrix, Schur};

/// Most states: a process, the integral and the filter of the derivative.
pub(super) const STATES: usize = crate::closed_loop::Process::MAX_ORDER + 2;

/// Process and controller around their equilibrium, as `w' = A w + B v(t - theta)`, `u = C w`, `y = w_0`.
///
/// Time is in units of [`Plant::time_s`], OP and VP of `fs`, the PV of [`Plant::pv_unit`]. In that time no eigenvalue
/// of `A`, nor of the loop closed without dead time, exceeds 1. The terms of a power series over a segment of 1
/// therefore fall as `1 / k!`.
#[derive(Debug, Clone)]
pub(super) struct Plant {
    /// Number of states.
    pub(super) order: usize,
    /// Number of process states. The integral, if any, and the filter come after them.
    process_order: usize,
    integrates: bool,
    pub(super) a: [[f64; STATES]; STATES],
    pub(super) b: [f64; STATES],
    pub(super) c: [f64; STATES],
    pub(super) dead_time: f64,
    /// The unit of time, s.
    pub(super) time_s: f64,
    /// The unit of the PV, PV units.
    pub(super) pv_unit: f64,
    /// OP and VP at equilibrium, percent.
    pub(super) op_rest: f64,
    /// PV at equilibrium, its units.
    pub(super) pv_rest: f64,
}

impl Plant {
    /// The linear part of `l`, OP and VP in units of `op_unit`.
    pub(super) fn new(l: &ContinuousLoop, op_unit: f64) -> Result<Self> {
        l.check()?;
        let (num, den) = l.process.coefficients();
        let n = den.len() - 1;
        let num: Vec<f64> =
            std::iter::repeat_n(0.0, n + 1 - num.len()).chain(num).map(|c| c / den[0]).collect();
        let den: Vec<f64> = den.iter().map(|c| c / den[0]).collect();
        let (kp, ki, kd) = l.controller.gains();
        if num[0] != 0.0 {
            return Err(Error::Inconsistent(
                "the exact cycle needs a process without direct feedthrough: its numerator must be of lower degree \
                 than its denominator"
                    .to_owned(),
            ));
        }
        let filter_s = l.controller.filter_s();
        if kd != 0.0 && filter_s == 0.0 && num[1] != 0.0 {
            return Err(Error::Inconsistent(
                "the derivative needs a filter time: without a filter time, the OP jumps whenever a slip reaches \
                 a process whose numerator is only one degree below the denominator"
                    .to_owned(),
            ));
        }
        if num.iter().all(|c| *c == 0.0) || (kp == 0.0 && ki == 0.0 && kd == 0.0) {
            return Err(Error::Inconsistent(
                "there is no loop: the gain of the process or of the controller is 0".to_owned(),
            ));
        }
        let (op_rest, pv_rest) = equilibrium(l, num[n], den[n])?;

        let filtered = kd != 0.0 && filter_s > 0.0;
        let order = n + usize::from(ki != 0.0) + usize::from(filtered);
        if n == 0 {
            return Err(Error::Inconsistent("the process has no dynamics".to_owned()));
        }
        // A unit of time that makes the largest eigenvalue 1, from a first guess.
        let guess = (0..n).map(|i| den[i + 1].abs().powf(1.0 / (i + 1) as f64)).fold(0.0, f64::max);
        let guess = if guess > 0.0 { guess } else { 1.0 };
        let build = |rate: f64| {
            let per = |power: usize| rate.powi(-(power as i32));
            // Observable form, in time units of 1 / rate.
            let gain = (1..=n).map(|i| (num[i] * per(i)).abs()).fold(0.0, f64::max);
            let mut a = [[0.0; STATES]; STATES];
            let (mut b, mut c) = ([0.0; STATES], [0.0; STATES]);
            for i in 0..n {
                a[i][0] = -den[i + 1] * per(i + 1);
                if i + 1 < n {
                    a[i][i + 1] = 1.0;
                }
                b[i] = num[i + 1] * per(i + 1) / gain;
            }
            c[0] = -kp * gain;
            let mut next = n;
            if ki != 0.0 {
                a[next][0] = -ki * gain / rate;
                c[next] = 1.0;
                next += 1;
            }
            if filtered {
                let lag = 1.0 / (filter_s * rate);
                a[next][0] = lag;
                a[next][next] = -lag;
                c[0] -= kd * gain / filter_s;
                c[next] = kd * gain / filter_s;
            } else if kd != 0.0 {
                for j in 0..n {
                    c[j] -= kd * gain * rate * a[0][j];
                }
            }
            (a, b, c, gain)
        };
        let radius = |rate: f64| -> Option<f64> {
            let (a, b, c, _) = build(rate);
            let open = DMatrix::from_fn(order, order, |i, j| a[i][j]);
            let closed = DMatrix::from_fn(order, order, |i, j| a[i][j] + b[i] * c[j]);
            let largest = |m: DMatrix<f64>| {
                eigenvalues(m).map(|all| all.iter().map(|l| l.norm()).fold(0.0, f64::max))
            };
            Some(largest(open)?.max(largest(closed)?))
        };
        let overflow = || {
            Error::Inconsistent("the eigenvalues of the loop are beyond floating point".to_owned())
        };
        let rate = guess * radius(guess).ok_or_else(overflow)?;
        if !(rate > 0.0 && rate.is_finite()) {
            return Err(overflow());
        }
        let (a, b, c, gain) = build(rate);
        let finite = a.iter().flatten().chain(&b).chain(&c).all(|c| c.is_finite());
        if !(finite && gain > 0.0) {
            return Err(overflow());
        }
        Ok(Self {
            order,
            process_order: n,
            integrates: ki != 0.0,
            a,
            b,
            c,
            dead_time: l.process.dead_time() * rate,
            time_s: 1.0 / rate,
            pv_unit: gain * op_unit,
            op_rest,
            pv_rest,
        })
    }

    /// `C w`.
    #[inline]
    pub(super) fn op<T: super::number::Number>(&self, w: &[T; STATES]) -> T {
        (1..self.order).fold(w[0] * self.c[0], |sum, i| sum + w[i] * self.c[i])
    }

    /// The process at rest under VP `position`, with the integral such that the OP is `op`. An integrating process does
    /// not rest there. Its PV is `position` instead.
    pub(super) fn resting(&self, position: f64, op: f64) -> [f64; STATES] {
        let n = self.process_order;
        let mut state = [0.0; STATES];
        let pull = self.a[n - 1][0];
        state[0] = if pull == 0.0 { position } else { -self.b[n - 1] * position / pull };
        let input = if pull == 0.0 { 0.0 } else { position };
        for i in 0..n - 1 {
            state[i + 1] = -self.a[i][0] * state[0] - self.b[i] * input;
        }
        let filter = n + usize::from(self.integrates);
        if filter < self.order {
            state[filter] = state[0];
        }
        if self.integrates {
            state[n] = op - self.op(&state);
        }
        state
    }
}

const _: () = assert!(DEGREE == 20, "1/21! is below a double's rounding; a lower degree is not");

/// OP (equal to VP) and PV at rest without friction.
fn equilibrium(l: &ContinuousLoop, num: f64, den: f64) -> Result<(f64, f64)> {
    let (kp, ki, _) = l.controller.gains();
    let nowhere =
        |why: &str| Err(Error::Inconsistent(format!("the loop has no equilibrium: {why}")));
    if ki != 0.0 {
        if num == 0.0 {
            return nowhere("the process has no gain at rest, so its PV cannot be held anywhere");
        }
        return Ok((l.set_point * den / num - l.load, l.set_point));
    }
    let stiffness = den + num * kp;
    if stiffness == 0.0 {
        return nowhere("the gains of process and controller cancel");
    }
    let aim = kp * l.controller.set_point_weight() * l.set_point;
    let pv = num * (aim + l.load) / stiffness;
    Ok((aim - kp * pv, pv))
}

/// The eigenvalues of `m`, the largest first; `None` if they cannot be found.
pub(super) fn eigenvalues(m: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let finite = m.iter().all(|v| v.is_finite());
    let mut all: Vec<_> = match m.nrows() {
        _ if !finite => return None,
        1 => vec![Complex::new(m[(0, 0)], 0.0)],
        2 => {
            let half = 0.5 * (m[(0, 0)] + m[(1, 1)]);
            let spread = 0.5 * (m[(0, 0)] - m[(1, 1)]);
            let split = Complex::new(spread * spread + m[(0, 1)] * m[(1, 0)], 0.0).sqrt();
            vec![half + split, half - split]
        }
        _ => {
            let schur = Schur::try_new(m, f64::EPSILON, 10_000)?;
            schur.complex_eigenvalues().iter().map(|l| Complex::new(l.re, l.im)).collect()
        }
    };
    all.sort_by(|a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
    Some(all)
}
