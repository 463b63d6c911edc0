//! Growth that friction cannot stop.

use super::flow::Flow;
use super::plant::Plant;
use nalgebra::Complex;
use nalgebra::{DMatrix, DVector};

/// The fastest growing mode of a loop that is unstable without friction.
///
/// With `x = u - d` the loop is linear except for `d`, and friction keeps `|d| <= 1`. Let `s`, of positive real
/// part, solve `C (sI - A)^-1 B e^(-s theta) = 1`. Then
/// ```text
/// z(t) = C (sI - A)^-1 w(t) + integral of e^(s (t - r)) x(r) dr from t - theta to t        z' = s z - d
/// ```
/// (derived for this project). So `z` grows for ever once it is beyond the largest possible contribution of `d`:
/// `|integral of e^(-s r) d(r) dr|` is at most `1 / re s`, and as `d` is real, at most `(2 / im s) / (1 - exp(-pi
/// re s / im s))`.
#[derive(Debug, Clone)]
pub(super) struct Growth {
    root: Complex<f64>,
    /// `C (sI - A)^-1`.
    left: DVector<Complex<f64>>,
    /// Value beyond which `z` grows.
    limit: f64,
}

impl Growth {
    /// For `plant`; `None` if no growing mode was found.
    pub(super) fn of(plant: &Plant) -> Option<Self> {
        let (root, left) = (0..9)
            .filter_map(|k| growing(plant, Complex::new(0.05, 0.02 * 2f64.powi(k) - 0.02)))
            .max_by(|a, b| a.0.re.total_cmp(&b.0.re))?;
        let plain = 1.0 / root.re;
        let waves = root.im.abs();
        let limit = if waves > 0.0 {
            plain.min(2.0 / waves / -f64::exp_m1(-std::f64::consts::PI * root.re / waves))
        } else {
            plain
        };
        // A thousandth for rounding.
        Some(Self { root, left, limit: 1.001 * limit })
    }

    /// Whether the motion has grown beyond the influence of friction.
    pub(super) fn is_certain(&self, flow: &Flow<'_, f64>) -> bool {
        let w = self.left.iter().zip(&flow.state);
        let state: Complex<f64> = w.map(|(left, w)| left * *w).sum();
        (state + flow.way(self.root)).norm() > self.limit
    }
}

/// `C (sI - A)^-1`; `None` where there is no inverse.
fn resolvent(plant: &Plant, s: Complex<f64>) -> Option<DVector<Complex<f64>>> {
    let n = plant.order;
    let transposed = DMatrix::from_fn(n, n, |i, j| {
        let own = if i == j { s } else { Complex::new(0.0, 0.0) };
        own - plant.a[j][i]
    });
    transposed.lu().solve(&DVector::from_fn(n, |i, _| Complex::new(plant.c[i], 0.0)))
}

/// A root of positive real part near `guess`, by the method of secants, and its resolvent.
fn growing(plant: &Plant, guess: Complex<f64>) -> Option<(Complex<f64>, DVector<Complex<f64>>)> {
    let value = |s: Complex<f64>| {
        let left = resolvent(plant, s)?;
        let gain: Complex<f64> = left.iter().zip(&plant.b).map(|(left, b)| left * *b).sum();
        Some((gain * (-s * plant.dead_time).exp() - 1.0, left))
    };
    let (mut before, mut s) = (guess, guess * 1.01);
    let mut old = value(before)?.0;
    for _ in 0..30 {
        let (new, left) = value(s)?;
        let step = new * (s - before) / (new - old);
        if !step.norm().is_finite() {
            break;
        }
        (before, old) = (s, new);
        s -= step;
        if step.norm() < 1e-12 && new.norm() < 1e-9 {
            return (s.re > 1e-9).then_some((s, left));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::flow::{Event, Stem};
    use super::super::orbit::PATIENCE;
    use super::*;
    use crate::bands::Bands;
    use crate::closed_loop::{Controller, Process};
    use crate::limit_cycle::ContinuousLoop;
    use crate::valve::Model;

    const STEM: Stem = Stem::Follows { fd: 0.25 };

    fn plant(kc: f64, ti: f64) -> Plant {
        let process = Process::first_order(1.5, 5.93, 1.07).unwrap();
        let bands = Bands::from_s_j(5.0, 3.0).unwrap();
        let controller = Controller::pi(kc, ti).unwrap();
        let l = ContinuousLoop::new(controller, process, Model::TwoPhase, bands);
        Plant::new(&l, bands.fs()).unwrap()
    }

    #[test]
    fn the_root_solves_the_loops_equation() {
        let unstable = plant(8.0, 2.5);
        let s = Growth::of(&unstable).unwrap().root / unstable.time_s;
        let gain = 8.0 * (1.0 + 1.0 / (s * 2.5)) * 1.5 * (-s * 1.07).exp() / (s * 5.93 + 1.0);
        assert!((gain + 1.0).norm() < 1e-9 && s.re > 0.0, "{s} {gain}");
        assert!(Growth::of(&plant(1.1, 2.5)).is_none());
    }

    /// Far out friction hardly counts: there the mode grows as in the linear loop, whatever the stem did.
    #[test]
    fn the_mode_grows_at_its_rate_and_is_certain_only_beyond_the_limit() {
        let unstable = plant(6.2, 8.0);
        let growth = Growth::of(&unstable).unwrap();
        let z = |flow: &Flow<'_, f64>| {
            let states = growth.left.iter().zip(&flow.state);
            states.map(|(left, w)| left * *w).sum::<Complex<f64>>() + flow.way(growth.root)
        };
        let mut flow = Flow::stuck(&unstable, STEM, [0.0; _], -0.4, PATIENCE);
        let mut before: Option<(Complex<f64>, f64)> = None;
        for _ in 0..10_000 {
            assert_eq!(flow.run_to_slip(), Event::Slips);
            let (now, time) = (z(&flow), flow.time);
            assert_eq!(growth.is_certain(&flow), now.norm() > growth.limit);
            if let Some((old, at)) = before {
                let length = time - at;
                let linear = Complex::exp(growth.root * length) * old;
                // |d| <= 1 adds no more than that.
                let most = f64::exp_m1(growth.root.re * length) / growth.root.re;
                assert!((now - linear).norm() <= most + 1e-9 * now.norm());
            }
            before = Some((now, time));
            if now.norm() > 1e4 {
                return;
            }
            flow.slip();
        }
        panic!("it does not grow");
    }
}
