//! How well sixteen inputs explain a PV through one lag and a delay, without the PV's past.
//!
//! ```text
//! z = lag(x),   z' = z - moving mean,   y'(k) = g z'(k - d)
//! ```

use super::arx::lag_sums;
use crate::numeric::least_squares::dot;
use crate::simd::{Kernel, LANES, Lane, Width};

/// Time constants of the lag, shares of the period; the integrator is tried as well.
const TIME_CONSTANTS: [f64; 5] = [0.0, 0.04, 0.1, 0.22, 0.5];
/// Delays besides zero, shares of the period.
const DELAYS: [f64; 7] = [0.02, 0.05, 0.09, 0.13, 0.18, 0.23, 0.28];
/// Length of the moving mean, periods.
const SLOW: f64 = 1.5;
/// Share of the variance that counts as never explained, so that logarithms stay finite.
const FLOOR: f64 = 1e-6;

/// A PV to explain by filtered inputs.
pub(super) struct Response {
    /// Without its slow part, followed by zeros.
    y: Vec<f64>,
    n: usize,
    power: f64,
    period: f64,
    half: usize,
    /// The sign of the gain.
    sign: f64,
    delays: Vec<usize>,
}

impl Response {
    /// For `pv`, which follows `op` in the direction assumed by the controller. It moves the OP against the PV, so
    /// the gain has the sign of `-sum dOP dPV`.
    pub fn new(op: &[f64], pv: &[f64], period: f64) -> Self {
        let half = (0.5 * SLOW * period).round() as usize;
        let mut y = without_slow(pv, half);
        let power = dot(&y, &y);
        let together: f64 =
            op.windows(2).zip(pv.windows(2)).map(|(u, y)| (u[1] - u[0]) * (y[1] - y[0])).sum();
        let mut delays: Vec<usize> =
            DELAYS.iter().map(|share| (share * period).round() as usize).collect();
        delays.insert(0, 0);
        delays.dedup();
        let n = y.len();
        y.resize(n + delays[delays.len() - 1], 0.0);
        Self { y, n, power, period, half, sign: if together > 0.0 { -1.0 } else { 1.0 }, delays }
    }

    /// The share of the variance that each of the inputs does not explain, through its best lag and delay.
    pub fn unexplained(&self, x: &[Lane], width: Width) -> Lane {
        width.run(Filters { response: self, x, plays: None })
    }

    /// The unexplained share for one input and sensors with plays of these widths, in shares of the range of the input.
    pub fn unexplained_by_sensor(&self, x: &[f64], plays: &Lane, width: Width) -> Lane {
        let x: Vec<Lane> = x.iter().map(|x| Lane::splat(*x)).collect();
        width.run(Filters { response: self, x: &x, plays: Some(plays) })
    }
}

/// A series less its centred moving mean over `half` samples to either side, or fewer at the ends.
pub(super) fn without_slow(x: &[f64], half: usize) -> Vec<f64> {
    let lanes: Vec<Lane<1>> = x.iter().map(|v| Lane([*v])).collect();
    let mut y = vec![Lane([0.0]); x.len()];
    high_pass(&lanes, half, &mut y);
    y.iter().map(|v| v[0]).collect()
}

#[inline(always)]
fn high_pass<const N: usize>(x: &[Lane<N>], half: usize, y: &mut [Lane<N>]) {
    let n = x.len();
    let mut sum = Lane::<N>::splat(0.0);
    for v in &x[..half.min(n)] {
        for l in 0..N {
            sum[l] += v[l];
        }
    }
    for k in 0..n {
        let (from, to) = (k.saturating_sub(half), (k + half + 1).min(n));
        if k + half < n {
            for l in 0..N {
                sum[l] += x[k + half][l];
            }
        }
        if from > 0 {
            for l in 0..N {
                sum[l] -= x[from - 1][l];
            }
        }
        let share = 1.0 / (to - from) as f64;
        for l in 0..N {
            y[k][l] = x[k][l] - sum[l] * share;
        }
    }
}

/// Lags, high pass, delays.
struct Filters<'a> {
    response: &'a Response,
    x: &'a [Lane],
    plays: Option<&'a Lane>,
}

impl Kernel for Filters<'_> {
    type Output = Lane;

    #[inline(always)]
    fn run(self) -> Lane {
        let Self { response, x, plays } = self;
        let n = response.n;
        let mut mean: Lane = Lane::splat(0.0);
        for v in x {
            for l in 0..LANES {
                mean[l] += v[l] / n as f64;
            }
        }
        let mut filtered = vec![Lane::splat(0.0); n];
        let mut fast = vec![Lane::splat(0.0); n];
        let mut products = vec![Lane::splat(0.0); response.delays.len()];
        let mut best: Lane = Lane::splat(1.0);
        for lag in 0..=TIME_CONSTANTS.len() {
            // z = keep z + take (x - mean): a lag of gain one, or an integrator.
            let (keep, take) = match TIME_CONSTANTS.get(lag) {
                Some(0.0) => (0.0, 1.0),
                Some(share) => {
                    let keep = (-1.0 / (share * response.period)).exp();
                    (keep, 1.0 - keep)
                }
                None => (1.0, 1.0 / response.period),
            };
            // The initial state of a lag is at rest, that of an integrator is zero.
            let rest = if keep < 1.0 { 1.0 } else { 0.0 };
            let mut z: Lane = Lane::from_fn(|l| rest * (x[0][l] - mean[l]));
            for (x, out) in x.iter().zip(&mut filtered) {
                for l in 0..LANES {
                    z[l] = keep * z[l] + take * (x[l] - mean[l]);
                }
                *out = z;
            }
            if let Some(plays) = plays {
                play(&mut filtered, plays);
            }
            high_pass(&filtered, response.half, &mut fast);
            products.fill(Lane::splat(0.0));
            lag_sums(&fast, &response.y, &response.delays, &mut products);
            let mut power: Lane = Lane::splat(0.0);
            for v in &fast {
                for l in 0..LANES {
                    power[l] += v[l] * v[l];
                }
            }
            for product in &products {
                for l in 0..LANES {
                    let aligned = (response.sign * product[l]).max(0.0);
                    let scale = (power[l] * response.power).max(f64::MIN_POSITIVE);
                    let left = (1.0 - aligned * aligned / scale).max(FLOOR);
                    best[l] = best[l].min(left);
                }
            }
        }
        best
    }
}

/// Play of the given widths, in shares of the range of its input.
#[inline(always)]
fn play(x: &mut [Lane], widths: &Lane) {
    let (mut low, mut high) = (x[0], x[0]);
    for v in &*x {
        for l in 0..LANES {
            low[l] = low[l].min(v[l]);
            high[l] = high[l].max(v[l]);
        }
    }
    let half = Lane::<LANES>::from_fn(|l| 0.5 * widths[l] * (high[l] - low[l]));
    let mut position = x[0];
    for v in x {
        for l in 0..LANES {
            position[l] = position[l].max(v[l] - half[l]).min(v[l] + half[l]);
        }
        *v = position;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;

    #[test]
    fn the_moving_mean_is_that_of_its_definition() {
        let x: Vec<f64> = (0..40).map(|k| f64::from(k * k % 17)).collect();
        for half in [0, 3, 100] {
            let fast = without_slow(&x, half);
            for k in 0..40usize {
                let about = &x[k.saturating_sub(half)..(k + half + 1).min(40)];
                let mean = about.iter().sum::<f64>() / about.len() as f64;
                assert!((fast[k] - (x[k] - mean)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn what_is_filtered_and_delayed_is_explained_and_only_with_the_right_sign() {
        let mut noise = NormalStream::new(7);
        let mut u = 0.0;
        let period = 50.0;
        let op: Vec<f64> = (0..900)
            .map(|k| {
                u = 0.95 * u + 0.3 * noise.draw();
                u + (std::f64::consts::TAU * f64::from(k) / 50.0).sin()
            })
            .collect();
        // A lag of a tenth of the period, five samples late.
        let keep = (-1.0f64 / 5.0).exp();
        let mut z = op[0];
        let lagged: Vec<f64> = op
            .iter()
            .map(|u| {
                z = keep * z + (1.0 - keep) * u;
                z
            })
            .collect();
        let pv = |sign: f64| -> Vec<f64> {
            (0..900usize).map(|k| sign * lagged[k.saturating_sub(5)]).collect()
        };
        let x: Vec<Lane> =
            op.iter().map(|u| Lane::from_fn(|l| if l < 8 { *u } else { u.abs() })).collect();
        for width in Width::available() {
            let response = Response { sign: 1.0, ..Response::new(&op, &pv(1.0), period) };
            let left = response.unexplained(&x, width);
            assert!(left[0] < 0.01 && left[15] > 0.5, "{left:?}");
            let response = Response { sign: 1.0, ..Response::new(&op, &pv(-1.0), period) };
            assert!(response.unexplained(&x, width)[0] > 0.3);
        }
    }

    #[test]
    fn play_in_the_sensor_is_found() {
        let op: Vec<f64> = (0..900)
            .map(|k| {
                let k = f64::from(k);
                (0.125 * k).sin() + 0.4 * (0.31 * k).sin()
            })
            .collect();
        let mut pv: Vec<Lane> = op.iter().map(|u| Lane::splat(*u)).collect();
        play(&mut pv, &Lane::splat(0.3));
        let pv: Vec<f64> = pv.iter().map(|y| y[0]).collect();
        let response = Response { sign: 1.0, ..Response::new(&op, &pv, 50.0) };
        let plays = Lane::from_fn(|l| 0.1 * l as f64);
        let left = response.unexplained_by_sensor(&op, &plays, Width::widest());
        let best = (0..LANES).min_by(|a, b| left[*a].total_cmp(&left[*b])).unwrap();
        assert_eq!(best, 3, "{left:?}");
        assert!(left[3] < 1e-5);
    }
}
