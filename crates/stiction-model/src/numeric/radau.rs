//! Radau IIA of order 5 for stiff systems of a few states, with dense output and located events.
//!
//! Three implicit stages, adaptive steps, everything in arrays of fixed size. The method and its constants were taken
//! from E. Hairer and G. Wanner, *Solving Ordinary Differential Equations II* (Springer 1996), section IV.8. The error
//! estimate is of order 3, and so is the collocation polynomial between steps, so that the tolerance controls its
//! error.

use nalgebra::{Complex, ComplexField};

use super::roots::bracketed;
use crate::error::{Error, Result};

const METHOD: &str = "Radau IIA integrator";

/// Largest number of guards of a system.
pub const GUARDS: usize = 5;

const SQRT6: f64 = 2.449_489_742_783_178;
const NODES: [f64; 3] = [(4.0 - SQRT6) / 10.0, (4.0 + SQRT6) / 10.0, 1.0];

/// Eigenvalues of the inverse of the Butcher matrix: one real, one of a complex pair.
const MU_REAL: f64 = 3.637_834_252_744_496;
const MU_COMPLEX: Complex<f64> = Complex::new(2.681_082_873_627_752, -3.050_430_199_247_410_5);

/// The transformation that makes that matrix block-diagonal, and its inverse.
const T: [[f64; 3]; 3] = [
    [0.094_438_762_488_975_24, -0.141_255_295_020_954_2, 0.030_029_194_105_147_424],
    [0.250_213_122_965_333_13, 0.204_129_352_293_799_93, -0.382_942_112_757_261_9],
    [1.0, 1.0, 0.0],
];
const T_INVERSE: [[f64; 3]; 3] = [
    [4.178_718_591_551_904, 0.327_682_820_761_062_4, 0.523_376_445_499_449_5],
    [-4.178_718_591_551_904, -0.327_682_820_761_062_4, 0.476_623_554_500_550_4],
    [0.502_872_634_945_786_9, -2.571_926_949_855_605, 0.596_039_204_828_224_9],
];

/// Weights of the embedded error estimate.
const ERROR_WEIGHTS: [f64; 3] =
    [(-13.0 - 7.0 * SQRT6) / 3.0, (-13.0 + 7.0 * SQRT6) / 3.0, -1.0 / 3.0];

/// Coefficients of the collocation polynomial in the stage increments.
const POLYNOMIAL: [[f64; 3]; 3] = [
    [13.0 / 3.0 + 7.0 * SQRT6 / 3.0, -23.0 / 3.0 - 22.0 * SQRT6 / 3.0, 10.0 / 3.0 + 5.0 * SQRT6],
    [13.0 / 3.0 - 7.0 * SQRT6 / 3.0, -23.0 / 3.0 + 22.0 * SQRT6 / 3.0, 10.0 / 3.0 - 5.0 * SQRT6],
    [1.0 / 3.0, -8.0 / 3.0, 10.0 / 3.0],
];

/// A system `y' = rate(s, y)`.
pub trait System<const N: usize> {
    fn rate(&self, s: f64, y: &[f64; N]) -> [f64; N];

    fn jacobian(&self, s: f64, y: &[f64; N]) -> [[f64; N]; N];

    /// Values that are at least 0 while the system is unchanged; unused ones are infinite.
    fn guards(&self, y: &[f64; N]) -> [f64; GUARDS];

    /// Longest step from `s` on.
    fn longest_step(&self, _s: f64) -> f64 {
        f64::INFINITY
    }

    /// Called after each accepted step.
    fn accepted(&mut self, _step: &Step<N>) {}
}

/// Relative tolerance, and an absolute one for each state.
#[derive(Debug, Clone, Copy)]
pub struct Tolerance<const N: usize> {
    pub relative: f64,
    pub absolute: [f64; N],
}

/// One step, and the collocation polynomial over it.
#[derive(Debug, Clone, Copy)]
pub struct Step<const N: usize> {
    pub start: f64,
    pub length: f64,
    y: [f64; N],
    coefficients: [[f64; N]; 3],
    end: [f64; N],
}

impl<const N: usize> Step<N> {
    fn new(start: f64, length: f64, y: [f64; N], z: &[[f64; N]; 3]) -> Self {
        let coefficients = std::array::from_fn(|p| {
            std::array::from_fn(|i| (0..3).map(|stage| z[stage][i] * POLYNOMIAL[stage][p]).sum())
        });
        Self { start, length, y, coefficients, end: std::array::from_fn(|i| y[i] + z[2][i]) }
    }

    /// The whole step as plain numbers.
    pub fn remember(&self, memory: &mut Vec<f64>) {
        memory.extend([self.start, self.length]);
        memory.extend(self.y);
        memory.extend(self.coefficients.iter().flatten());
        memory.extend(self.end);
    }

    /// The step from its stored numbers.
    pub fn recalled(memory: &mut dyn Iterator<Item = f64>) -> Option<Self> {
        let (start, length) = (memory.next()?, memory.next()?);
        let mut state = || {
            let mut state = [0.0; N];
            for value in &mut state {
                *value = memory.next()?;
            }
            Some(state)
        };
        Some(Self {
            start,
            length,
            y: state()?,
            coefficients: [state()?, state()?, state()?],
            end: state()?,
        })
    }

    /// The state at the fraction `theta` of the step.
    fn at_fraction(&self, theta: f64) -> [f64; N] {
        let [q1, q2, q3] = &self.coefficients;
        std::array::from_fn(|i| self.y[i] + theta * (q1[i] + theta * (q2[i] + theta * q3[i])))
    }

    /// The state at `s`, within the step.
    pub fn at(&self, s: f64) -> [f64; N] {
        self.at_fraction((s - self.start) / self.length)
    }
}

/// The end of an integration, and the guard that ended it, if one did.
#[derive(Debug, Clone, Copy)]
pub struct RadauOutcome<const N: usize> {
    pub elapsed: f64,
    pub y: [f64; N],
    pub guard: Option<usize>,
}

/// Integrates from `s = 0` until `duration`, or until a guard falls below 0.
///
/// `observe` is called after each accepted step.
///
/// # Errors
/// [`Error::Solver`], with its time from the start of the integration, if the step shrinks to zero, the rates
/// become NaN, or more than ten million steps are needed.
pub fn integrate<const N: usize, S: System<N>>(
    system: &mut S,
    y0: [f64; N],
    duration: f64,
    tolerance: &Tolerance<N>,
    mut observe: impl FnMut(&S, &Step<N>),
) -> Result<RadauOutcome<N>> {
    const MOST_STEPS: usize = 10_000_000;
    let stopped = |time_s: f64, reason: &str| {
        Err(Error::Solver { method: METHOD, time_s, reason: reason.to_owned() })
    };
    let mut s = 0.0;
    let mut y = y0;
    let mut length = first_step(system, &y, duration, tolerance);
    let mut last: Option<(Step<N>, f64)> = None;
    for _ in 0..MOST_STEPS {
        let left = duration - s;
        length = length.min(system.longest_step(s));
        let ends = length >= left * (1.0 - 1e-12);
        let wanted = if ends { left } else { length };
        if s + wanted == s {
            return stopped(s, "its step shrank to zero");
        }
        let attempt = attempt(system, s, &y, wanted, tolerance, last.as_ref().map(|l| &l.0));
        let Some(Attempt { step, error, iterations }) = attempt else {
            length = 0.5 * wanted;
            last = None;
            continue;
        };
        let safety = 0.9 * 15.0 / (14.0 + iterations as f64);
        let mut factor = safety * error.max(1e-10).powf(-0.25);
        if error > 1.0 {
            length = wanted * factor.max(0.2);
            continue;
        }
        if let Some((guard, fraction)) = fallen_guard(system, &step) {
            let step = polish(system, &y, &step, guard, fraction, tolerance);
            system.accepted(&step);
            observe(system, &step);
            return Ok(RadauOutcome { elapsed: s + step.length, y: step.end, guard: Some(guard) });
        }
        if let Some((before, error_before)) = &last {
            // Gustafsson's predictive control: reduces the step before it is rejected.
            let trend = wanted / before.length * (error_before / error.max(1e-10)).powf(0.25);
            factor = factor.min(factor * trend);
        }
        system.accepted(&step);
        observe(system, &step);
        y = step.end;
        if ends {
            return Ok(RadauOutcome { elapsed: duration, y, guard: None });
        }
        s += wanted;
        length = wanted * factor.clamp(0.2, 10.0);
        last = Some((step, error.max(1e-2)));
    }
    stopped(s, "it needs more than ten million steps")
}

/// A cautious first step: one over which the state changes by about the tolerance's fourth root.
fn first_step<const N: usize, S: System<N>>(
    system: &S,
    y: &[f64; N],
    duration: f64,
    tolerance: &Tolerance<N>,
) -> f64 {
    let rate = system.rate(0.0, y);
    let speed = norm(&rate, &scales(y, tolerance));
    let change = tolerance.relative.powf(-0.25);
    let step = if speed > 0.0 { change / speed } else { 1e-3 * duration };
    step.min(duration)
}

struct Attempt<const N: usize> {
    step: Step<N>,
    error: f64,
    iterations: usize,
}

/// One step of `length` and its error relative to the tolerance; `None` if Newton's method fails.
fn attempt<const N: usize, S: System<N>>(
    system: &S,
    s: f64,
    y: &[f64; N],
    length: f64,
    tolerance: &Tolerance<N>,
    last: Option<&Step<N>>,
) -> Option<Attempt<N>> {
    const MOST_ITERATIONS: usize = 8;
    let scale = scales(y, tolerance);
    let jacobian = system.jacobian(s, y);
    let real = Lu::new(shifted(&jacobian, MU_REAL / length))?;
    let complex = Lu::new(shifted(&jacobian, MU_COMPLEX / length))?;

    // The previous step's polynomial, extrapolated, is a good first guess.
    let mut z: [[f64; N]; 3] = match last {
        None => [[0.0; N]; 3],
        Some(step) => NODES.map(|node| {
            let guess = step.at(s + node * length);
            std::array::from_fn(|i| guess[i] - y[i])
        }),
    };
    let mut w = combine(&T_INVERSE, &z);
    // Changes by rounding alone, which have no trend.
    let noise = 10.0 * f64::EPSILON / tolerance.relative;
    let close = noise.max(tolerance.relative.sqrt().min(0.03));
    let mut change_before = f64::NAN;
    let mut iterations = 0;
    let mut converged = false;
    while !converged && iterations < MOST_ITERATIONS {
        let rates: [[f64; N]; 3] = std::array::from_fn(|stage| {
            let at = std::array::from_fn(|i| y[i] + z[stage][i]);
            system.rate(s + NODES[stage] * length, &at)
        });
        let [f1, f2, f3] = combine(&T_INVERSE, &rates);
        let dw1 = real.solve(std::array::from_fn(|i| f1[i] - MU_REAL / length * w[0][i]));
        let dw2 = complex.solve(std::array::from_fn(|i| {
            Complex::new(f2[i], f3[i]) - MU_COMPLEX / length * Complex::new(w[1][i], w[2][i])
        }));
        for i in 0..N {
            w[0][i] += dw1[i];
            w[1][i] += dw2[i].re;
            w[2][i] += dw2[i].im;
        }
        z = combine(&T, &w);
        let re = dw2.map(|d| d.re);
        let im = dw2.map(|d| d.im);
        let change = norm(&dw1, &scale).max(norm(&re, &scale)).max(norm(&im, &scale));
        if !change.is_finite() {
            return None;
        }
        iterations += 1;
        let ratio = change / change_before;
        if iterations > 1 && change > noise {
            let left = (MOST_ITERATIONS - iterations) as i32;
            if ratio >= 1.0 || ratio.powi(left) / (1.0 - ratio) * change > close {
                return None;
            }
        }
        converged = change == 0.0
            || (iterations > 1 && (change <= noise || ratio / (1.0 - ratio) * change < close));
        change_before = change;
    }
    if !converged {
        return None;
    }

    let slope = system.rate(s, y);
    let defect: [f64; N] = std::array::from_fn(|i| {
        (0..3).map(|stage| z[stage][i] * ERROR_WEIGHTS[stage]).sum::<f64>() / length
    });
    let scale_end: [f64; N] = std::array::from_fn(|i| {
        tolerance.absolute[i] + tolerance.relative * y[i].abs().max((y[i] + z[2][i]).abs())
    });
    let mut estimate = real.solve(std::array::from_fn(|i| slope[i] + defect[i]));
    let mut error = norm(&estimate, &scale_end);
    if error > 1.0 {
        // Filters the stiff part of the estimate, which the step itself has damped.
        let moved = std::array::from_fn(|i| y[i] + estimate[i]);
        let slope = system.rate(s, &moved);
        estimate = real.solve(std::array::from_fn(|i| slope[i] + defect[i]));
        error = norm(&estimate, &scale_end);
    }
    error.is_finite().then(|| Attempt { step: Step::new(s, length, *y, &z), error, iterations })
}

/// The first guard to fall within the step, and its fraction of the step.
fn fallen_guard<const N: usize, S: System<N>>(system: &S, step: &Step<N>) -> Option<(usize, f64)> {
    const LOOKS: u32 = 8;
    let mut before = 0.0;
    for look in 1..=LOOKS {
        let theta = f64::from(look) / f64::from(LOOKS);
        let state = if look == LOOKS { step.end } else { step.at_fraction(theta) };
        let guards = system.guards(&state);
        let first = (0..GUARDS)
            .filter(|g| guards[*g] < 0.0)
            .map(|g| {
                let value = |theta: f64| system.guards(&step.at_fraction(theta))[g];
                let fell = value(before) <= 0.0;
                (g, if fell { before } else { bracketed(value, before, theta) })
            })
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if first.is_some() {
            return first;
        }
        before = theta;
    }
    None
}

/// The step that ends where the guard vanishes: found on the polynomial, then refined with steps of exactly that
/// length, because the end of a step is more accurate than its interior.
fn polish<const N: usize, S: System<N>>(
    system: &S,
    y: &[f64; N],
    whole: &Step<N>,
    guard: usize,
    fraction: f64,
    tolerance: &Tolerance<N>,
) -> Step<N> {
    const MOST_REFINEMENTS: usize = 4;
    let cut = |length: f64| {
        let theta = length / whole.length;
        let end = whole.at_fraction(theta);
        let coefficients = std::array::from_fn(|p: usize| {
            whole.coefficients[p].map(|q| q * theta.powi(p as i32 + 1))
        });
        Step { length, end, coefficients, ..*whole }
    };
    let mut length = fraction * whole.length;
    let mut best = cut(length);
    if length == 0.0 {
        return best;
    }
    for _ in 0..MOST_REFINEMENTS {
        let Some(Attempt { step, .. }) =
            attempt(system, whole.start, y, length, tolerance, Some(whole))
        else {
            return best;
        };
        let value = system.guards(&step.end)[guard];
        let nudge = 1e-6 * length;
        let nudged = system.guards(&step.at_fraction(1.0 - 1e-6))[guard];
        let change = -value * nudge / (value - nudged);
        best = step;
        if !(change.abs() > 1e-14 * length && change.abs() < 0.5 * length) {
            break;
        }
        length += change;
    }
    best
}

fn scales<const N: usize>(y: &[f64; N], tolerance: &Tolerance<N>) -> [f64; N] {
    std::array::from_fn(|i| tolerance.absolute[i] + tolerance.relative * y[i].abs())
}

/// Root mean square in units of `scale`.
fn norm<const N: usize>(values: &[f64; N], scale: &[f64; N]) -> f64 {
    let sum: f64 = values.iter().zip(scale).map(|(v, s)| (v / s) * (v / s)).sum();
    (sum / N as f64).sqrt()
}

/// Each row of `matrix` times the three vectors.
fn combine<const N: usize>(matrix: &[[f64; 3]; 3], vectors: &[[f64; N]; 3]) -> [[f64; N]; 3] {
    matrix.map(|row| {
        std::array::from_fn(|i| {
            row[0] * vectors[0][i] + row[1] * vectors[1][i] + row[2] * vectors[2][i]
        })
    })
}

/// `shift I - jacobian`.
fn shifted<C: ComplexField<RealField = f64> + Copy, const N: usize>(
    jacobian: &[[f64; N]; N],
    shift: C,
) -> [[C; N]; N] {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let entry = C::from_real(-jacobian[i][j]);
            if i == j { entry + shift } else { entry }
        })
    })
}

/// LU factors with row exchanges.
struct Lu<C, const N: usize> {
    factors: [[C; N]; N],
    rows: [usize; N],
}

impl<C: ComplexField<RealField = f64> + Copy, const N: usize> Lu<C, N> {
    /// `None` if the matrix is singular or not finite.
    fn new(mut a: [[C; N]; N]) -> Option<Self> {
        let mut rows: [usize; N] = std::array::from_fn(|i| i);
        for k in 0..N {
            let pivot = (k..N).max_by(|i, j| a[*i][k].norm1().total_cmp(&a[*j][k].norm1()))?;
            let size = a[pivot][k].norm1();
            if !(size > 0.0 && size.is_finite()) {
                return None;
            }
            a.swap(k, pivot);
            rows.swap(k, pivot);
            let inverse = C::one() / a[k][k];
            for i in k + 1..N {
                let factor = a[i][k] * inverse;
                a[i][k] = factor;
                let upper = a[k];
                for (entry, upper) in a[i].iter_mut().zip(upper).skip(k + 1) {
                    *entry -= factor * upper;
                }
            }
        }
        Some(Self { factors: a, rows })
    }

    fn solve(&self, b: [C; N]) -> [C; N] {
        let mut x = self.rows.map(|row| b[row]);
        for i in 1..N {
            for j in 0..i {
                let known = x[j];
                x[i] -= self.factors[i][j] * known;
            }
        }
        for i in (0..N).rev() {
            for j in i + 1..N {
                let known = x[j];
                x[i] -= self.factors[i][j] * known;
            }
            x[i] /= self.factors[i][i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::{GUARDS, System, Tolerance, integrate};

    /// Robertson's reactions, a stiff standard problem.
    struct Robertson;

    impl System<3> for Robertson {
        fn rate(&self, _s: f64, y: &[f64; 3]) -> [f64; 3] {
            let [a, b, c] = *y;
            let slow = -0.04 * a + 1e4 * b * c;
            let fast = 3e7 * b * b;
            [slow, -slow - fast, fast]
        }

        fn jacobian(&self, _s: f64, y: &[f64; 3]) -> [[f64; 3]; 3] {
            let [_, b, c] = *y;
            let top = [-0.04, 1e4 * c, 1e4 * b];
            let bottom = [0.0, 6e7 * b, 0.0];
            [top, [-top[0], -top[1] - bottom[1], -top[2]], bottom]
        }

        fn guards(&self, _y: &[f64; 3]) -> [f64; GUARDS] {
            [f64::INFINITY; GUARDS]
        }
    }

    #[test]
    fn robertson_at_forty() {
        let tolerance = Tolerance { relative: 1e-10, absolute: [1e-10, 1e-14, 1e-10] };
        let end = integrate(&mut Robertson, [1.0, 0.0, 0.0], 40.0, &tolerance, |_, _| ()).unwrap();
        // From Hairer and Wanner's test set, as commonly quoted.
        let expected = [0.715_827_068_8, 9.185_534_764_6e-6, 0.284_163_745_7];
        for (found, expected) in end.y.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
        }
    }

    /// A falling body that bounces at height 0.
    struct Fall;

    impl System<2> for Fall {
        fn rate(&self, s: f64, y: &[f64; 2]) -> [f64; 2] {
            [y[1], -s.cos()]
        }

        fn jacobian(&self, _s: f64, _y: &[f64; 2]) -> [[f64; 2]; 2] {
            [[0.0, 1.0], [0.0, 0.0]]
        }

        fn guards(&self, y: &[f64; 2]) -> [f64; GUARDS] {
            [y[0], f64::INFINITY, f64::INFINITY, f64::INFINITY, f64::INFINITY]
        }
    }

    #[test]
    fn events_are_located() {
        let tolerance = Tolerance { relative: 1e-9, absolute: [1e-9; 2] };
        let mut seen = 0.0;
        let end = integrate(&mut Fall, [0.5, 0.0], 9.0, &tolerance, |_, step| {
            seen = step.start + step.length;
        })
        .unwrap();
        // 0.5 = 1 - cos s.
        assert_eq!(end.guard, Some(0));
        assert!((end.elapsed - std::f64::consts::PI / 3.0).abs() < 1e-9);
        assert_eq!(end.elapsed, seen);
    }
}
