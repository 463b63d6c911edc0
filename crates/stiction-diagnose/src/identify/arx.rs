//! A linear model of the PV from its own past and the input: ARX.
//!
//! # What it measures
//! How the PV follows an input (OP or valve position) from one sample to the next, and with which delay.
//!
//! # Assumptions
//! A linear process of at most fifth order; its disturbance is white at the equation's input.
//!
//! # Equations
//! ```text
//! y(k) = c + sum_{i=1..5} a_i y(k-i) + sum_{j=0..3} b_j x(k-d-j) + e(k)
//! ```
//! by least squares for every delay d up to the longest. The result is the delay with the smallest error.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | orders 5 and 4 | samples | | ours |
//! | `longest_delay` | samples | 40, in Python | ours |
//!
//! # Limits
//! Measurement noise of the PV biases the coefficients towards a faster process. In closed loop with noise alone,
//! the inverse of the controller explains as much.
//!
//! # References
//! L. Ljung, System Identification: Theory for the User, 2nd ed., Prentice Hall (1999), section 4.2 (recalled, not
//! read).

// Within the crate: sixteen models of one PV at a time, each with its own input, for several delays at once. All
// columns are shifts of two series, so every product of two columns is a sum over one lag with a few samples more
// or less at its edges: `G(l+1, i+1) = G(l, i) + first - last`. The sums over lags are formed once for an input and
// serve all delays. The part explained by the past of `y` is the same for every input and delay; its normal
// equations are factored once, and only a system of four unknowns remains.

use crate::finding::Abstention;
use crate::numeric::least_squares::{RIDGE, Solution, dot, least_squares};
use crate::series::{centred, mean, std};
use crate::simd::{Kernel, LANES, Lane, Width};

/// Number of past values of the PV in a model.
pub const PAST: usize = 5;
/// Number of neighbouring values of its input in a model.
pub const TAPS: usize = 4;
/// A constant and the past of the PV.
const COMMON: usize = PAST + 1;
/// Samples whose positions stay in the first-level cache during all lags.
const TILE: usize = 96;

/// A linear model of a PV.
#[derive(Debug, Clone, PartialEq)]
pub struct Arx {
    /// The constant `c`, in units of the PV.
    pub constant: f64,
    /// `a_1` to `a_5`.
    pub past: [f64; PAST],
    /// `b_0` to `b_3`, units of the PV per percent.
    pub taps: [f64; TAPS],
    /// Samples from input to PV, at least 1.
    pub delay: usize,
    /// Standard deviation of the residual, in units of the PV.
    pub residual_std: f64,
    /// Share of the variance of the PV that is explained from sample to sample.
    pub fit: f64,
    /// The PV predicted from the earlier samples, in units of the PV. The first samples have no past and equal the PV.
    pub predicted: Vec<f64>,
}

impl Arx {
    /// Static gain, units of the PV per percent: `sum b / (1 - sum a)`. Infinite for an integrating process, and
    /// meaningless for one that nearly integrates.
    pub fn gain(&self) -> f64 {
        self.taps.iter().sum::<f64>() / (1.0 - self.past.iter().sum::<f64>())
    }
}

/// Fits a model of `pv` behind `op`, trying delays up to `longest_delay` (at least 1).
///
/// ```
/// use stiction_diagnose::identify::arx;
/// let op: Vec<f64> = (0..400).map(|k| f64::from(k * k % 17)).collect();
/// let mut pv = vec![20.0; 400];
/// for k in 3..400 {
///     pv[k] = 2.0 + 0.9 * pv[k - 1] + 0.3 * op[k - 3];
/// }
/// let found = arx::fit(&op, &pv, 10)?;
/// assert!(found.delay <= 3 && (found.gain() - 3.0).abs() < 1e-3);
/// # Ok::<(), stiction_diagnose::finding::Abstention>(())
/// ```
///
/// # Errors
/// If the series differ in length or are too short for the longest delay, a sample is not finite, or a series is
/// constant.
pub fn fit(op: &[f64], pv: &[f64], longest_delay: usize) -> Result<Arx, Abstention> {
    let longest = longest_delay.max(1);
    let fewest = (longest.saturating_add(TAPS - 1)).max(PAST).saturating_add(3 * (COMMON + TAPS));
    if op.len() != pv.len() || op.len() < fewest {
        return Err(Abstention(format!(
            "a model needs at least {fewest} samples of both OP and PV; there are {} and {}",
            op.len(),
            pv.len()
        )));
    }
    if op.iter().chain(pv).any(|v| !v.is_finite()) {
        return Err(Abstention("a sample is not finite".to_owned()));
    }
    let still = || Abstention("the OP or the PV does not move".to_owned());
    let (scale_x, scale_y) = (std(op), std(pv));
    if !(scale_x > 0.0 && scale_y > 0.0) {
        return Err(still());
    }
    let scaled = |x: &[f64], by: f64| -> Vec<f64> { centred(x).iter().map(|v| v / by).collect() };
    let (x, y) = (scaled(op, scale_x), scaled(pv, scale_y));
    let delays: Vec<usize> = (1..=longest).collect();
    let target = Target::new(&y, &delays).ok_or_else(still)?;
    let tried = delays.iter().filter_map(|d| Some((*d, target.explain(&[(&x, *d)])?)));
    let (delay, best) = tried.min_by(|a, b| a.1.sse.total_cmp(&b.1.sse)).ok_or_else(still)?;
    let past = std::array::from_fn(|i| best.coefficients[1 + i]);
    let taps = std::array::from_fn(|j| best.coefficients[COMMON + j] * scale_y / scale_x);
    let (level_x, level_y) = (mean(op), mean(pv));
    let constant = scale_y * best.coefficients[0] + level_y * (1.0 - past.iter().sum::<f64>())
        - level_x * taps.iter().sum::<f64>();
    let first = target.first();
    let seen = centred(&y[first..]);
    let mut predicted = pv.to_vec();
    for (p, left) in predicted[first..].iter_mut().zip(&best.residual) {
        *p -= scale_y * left;
    }
    Ok(Arx {
        constant,
        past,
        taps,
        delay,
        residual_std: scale_y * (best.sse / target.samples() as f64).sqrt(),
        fit: 1.0 - best.sse / dot(&seen, &seen),
        predicted,
    })
}

/// A PV to explain: everything about it that does not depend on the input.
pub(crate) struct Target {
    /// The series, followed by zeros that no model uses.
    y: Vec<f64>,
    n: usize,
    /// First predicted sample. It is the same for all delays, so that sums of squares are comparable.
    first: usize,
    delays: Vec<usize>,
    /// Lower triangle of the factored normal equations of the common columns.
    factor: [[f64; COMMON]; COMMON],
    /// The factored product of common columns and target.
    target: [f64; COMMON],
    /// Sum of squares that the common columns do not explain.
    left: f64,
}

/// Residuals of the fits to sixteen inputs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fits {
    /// Sum of squares at the best delay.
    pub sse: Lane,
    /// The best delay, samples.
    pub delay: [usize; LANES],
}

impl Target {
    /// The target `y`, of variance one, for inputs at each of `delays` (at least 1); `None` if the samples are too few,
    /// or `y` is constant.
    pub fn new(y: &[f64], delays: &[usize]) -> Option<Self> {
        let longest = delays.iter().max()? + TAPS - 1;
        let (n, first) = (y.len(), longest.max(PAST));
        if n < first + 3 * (COMMON + TAPS) {
            return None;
        }
        let column = |i: usize, k: usize| if i == 0 { 1.0 } else { y[k - i] };
        let mut factor = [[0.0; COMMON]; COMMON];
        let mut target = [0.0; COMMON];
        let mut left = 0.0;
        for k in first..n {
            for i in 0..COMMON {
                for j in 0..=i {
                    factor[i][j] += column(i, k) * column(j, k);
                }
                target[i] += column(i, k) * y[k];
            }
            left += y[k] * y[k];
        }
        let total = left;
        for i in 0..COMMON {
            factor[i][i] += RIDGE * n as f64;
            for j in 0..=i {
                let mut sum = factor[i][j];
                for m in 0..j {
                    sum -= factor[i][m] * factor[j][m];
                }
                factor[i][j] = if i == j { sum.sqrt() } else { sum / factor[j][j] };
            }
            let mut sum = target[i];
            for m in 0..i {
                sum -= factor[i][m] * target[m];
            }
            target[i] = sum / factor[i][i];
            left -= target[i] * target[i];
        }
        let mut y = y.to_vec();
        y.resize(n + longest, 0.0);
        let sound = total > RIDGE * n as f64 && target.iter().all(|v| v.is_finite());
        sound.then(|| Self { y, n, first, delays: delays.to_vec(), factor, target, left })
    }

    /// Number of predicted samples.
    pub fn samples(&self) -> usize {
        self.n - self.first
    }

    /// The first predicted sample.
    pub fn first(&self) -> usize {
        self.first
    }

    /// The residual of the target after regression on its past and on these inputs, each at its delay. Inputs are as
    /// long as the target, delays at most the longest of the target's.
    pub fn explain(&self, inputs: &[(&[f64], usize)]) -> Option<Solution> {
        let (n, first) = (self.n, self.first);
        let constant = vec![1.0; n - first];
        let mut columns = vec![&constant[..]];
        columns.extend((1..=PAST).map(|i| &self.y[first - i..n - i]));
        for (x, delay) in inputs {
            columns.extend((*delay..delay + TAPS).map(|i| &x[first - i..n - i]));
        }
        least_squares(&columns, &self.y[first..n])
    }

    /// Fits a model to each of the inputs `x`, as long as the target.
    pub fn fit(&self, x: &[Lane], width: Width) -> Fits {
        width.run(Fit { target: self, x })
    }
}

/// `sums[g] += sum_k x(k) y(k + offsets[g])`, in tiles.
#[inline(always)]
pub(super) fn lag_sums(x: &[Lane], y: &[f64], offsets: &[usize], sums: &mut [Lane]) {
    for (tile, x) in x.chunks(TILE).enumerate() {
        let y = &y[tile * TILE..];
        let mut offsets = offsets.chunks_exact(3);
        let mut sums = sums.chunks_exact_mut(3);
        for (offsets, sums) in offsets.by_ref().zip(sums.by_ref()) {
            // By name, not in an array, so that each stays in registers.
            let (mut a, mut b, mut c) = (sums[0], sums[1], sums[2]);
            let row = |g: usize| &y[offsets[g]..][..x.len()];
            let rows = row(0).iter().zip(row(1)).zip(row(2));
            for (x, ((p, q), r)) in x.iter().zip(rows) {
                a.add_scaled(x, *p);
                b.add_scaled(x, *q);
                c.add_scaled(x, *r);
            }
            (sums[0], sums[1], sums[2]) = (a, b, c);
        }
        for (offset, sum) in offsets.remainder().iter().zip(sums.into_remainder()) {
            let mut a = *sum;
            for (x, p) in x.iter().zip(&y[*offset..]) {
                a.add_scaled(x, *p);
            }
            *sum = a;
        }
    }
}

struct Fit<'a> {
    target: &'a Target,
    x: &'a [Lane],
}

impl Kernel for Fit<'_> {
    type Output = Fits;

    #[inline(always)]
    fn run(self) -> Fits {
        let Self { target, x } = self;
        let (n, first) = (target.n, target.first);
        // Columns are the lags 1 to `longest` of the input; column c is x(first - c ..= n - 1 - c).
        let longest = target.y.len() - n;
        // The lags of input against target, from 1 - PAST, as they are in column 1.
        let lowest = PAST - 1;
        let offsets: Vec<usize> = (0..=longest + lowest).collect();
        let mut lags = vec![Lane::splat(0.0); offsets.len()];
        lag_sums(&x[first - 1..n - 1], &target.y[first - 1 - lowest..], &offsets, &mut lags);
        let (mut sum, mut squares) = own_sums(x, first - 1, n - 1);

        // For every column, the part that the common columns explain and the rest of its products.
        let mut explained = vec![[Lane::splat(0.0); COMMON]; longest + 1];
        let mut onto = vec![Lane::splat(0.0); longest + 1];
        let mut products = vec![[Lane::splat(0.0); TAPS]; longest + 1];
        for column in 1..=longest {
            let solved = &mut explained[column];
            let mut product = lags[column + lowest];
            for i in 0..COMMON {
                let mut value = if i == 0 { sum } else { lags[column + lowest - i] };
                for m in 0..i {
                    value.add_scaled(&solved[m], -target.factor[i][m]);
                }
                let scale = 1.0 / target.factor[i][i];
                value = Lane::from_fn(|l| value[l] * scale);
                product.add_scaled(&value, -target.target[i]);
                solved[i] = value;
            }
            onto[column] = product;
            products[column] = squares;
            if column == longest {
                break;
            }
            // In the next column every product has one sample more at its beginning, one less at its end.
            let (enters, leaves) = (first - 1 - column, n - 1 - column);
            for (lag, sums) in lags.iter_mut().enumerate() {
                // Products with values of the target before the past belong to finished columns.
                if let Some(shifted) = (enters + lag).checked_sub(lowest) {
                    sums.add_scaled(&x[enters], target.y[shifted]);
                    sums.add_scaled(&x[leaves], -target.y[leaves + lag - lowest]);
                }
            }
            sum.add_scaled(&x[enters], 1.0);
            sum.add_scaled(&x[leaves], -1.0);
            for (j, square) in squares.iter_mut().enumerate() {
                // Products with values before the first sample belong to unused columns.
                square.add_product(&x[enters], &x[enters.saturating_sub(j)]);
                square.subtract_product(&x[leaves], &x[leaves - j]);
            }
        }
        for column in 1..=longest {
            for j in 0..TAPS.min(longest + 1 - column) {
                let mut product = products[column][j];
                for i in 0..COMMON {
                    product.subtract_product(&explained[column][i], &explained[column + j][i]);
                }
                products[column][j] = product;
            }
            let ridge = RIDGE * n as f64;
            products[column][0].add_scaled(&Lane::splat(1.0), ridge);
        }

        let mut fits = Fits { sse: Lane::splat(f64::INFINITY), delay: [0; LANES] };
        for &delay in &target.delays {
            let sse = remaining(target.left, &products[delay..], &onto[delay..]);
            for l in 0..LANES {
                if sse[l] < fits.sse[l] {
                    fits.sse[l] = sse[l];
                    fits.delay[l] = delay;
                }
            }
        }
        fits
    }
}

/// The sum of `x` from one sample to another, and of the products of `x` with itself 0 to 3 samples before.
#[inline(always)]
fn own_sums(x: &[Lane], from: usize, to: usize) -> (Lane, [Lane; TAPS]) {
    let (mut sum, mut square) = (Lane::splat(0.0), Lane::splat(0.0));
    for x in &x[from..to] {
        sum.add_scaled(x, 1.0);
        square.add_product(x, x);
    }
    let (mut one, mut two, mut three) = (Lane::splat(0.0), Lane::splat(0.0), Lane::splat(0.0));
    let earlier = x[from - 1..].iter().zip(&x[from - 2..]).zip(&x[from - 3..]);
    for (x, ((a, b), c)) in x[from..to].iter().zip(earlier) {
        one.add_product(x, a);
        two.add_product(x, b);
        three.add_product(x, c);
    }
    (sum, [square, one, two, three])
}

/// The part of the sum of squares `left` that four neighbouring columns do not explain.
#[inline(always)]
fn remaining(left: f64, products: &[[Lane; TAPS]], onto: &[Lane]) -> Lane {
    let mut factor: [[Lane; TAPS]; TAPS] = [[Lane::splat(0.0); TAPS]; TAPS];
    let mut solved: [Lane; TAPS] = [Lane::splat(0.0); TAPS];
    let mut sse = Lane::splat(left);
    for i in 0..TAPS {
        for j in 0..i {
            let mut value = products[j][i - j];
            for m in 0..j {
                value.subtract_product(&factor[i][m], &factor[j][m]);
            }
            factor[i][j] = Lane::from_fn(|l| value[l] * factor[j][j][l]);
        }
        let (mut value, mut product) = (products[i][0], onto[i]);
        for m in 0..i {
            value.subtract_product(&factor[i][m], &factor[i][m]);
            product.subtract_product(&factor[i][m], &solved[m]);
        }
        // The diagonal contains its own reciprocal.
        let scale = Lane::from_fn(|l| 1.0 / value[l].sqrt());
        factor[i][i] = scale;
        solved[i] = Lane::from_fn(|l| product[l] * scale[l]);
        sse.subtract_product(&solved[i], &solved[i]);
    }
    sse
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;

    #[test]
    fn a_model_of_these_orders_is_found_again() {
        let (past, taps, delay, constant) =
            ([1.2, -0.5, 0.1, 0.0, 0.05], [0.4, 0.0, -0.2, 0.1], 6, 3.0);
        let mut noise = NormalStream::new(5);
        let op: Vec<f64> = (0..3000).map(|_| 50.0 + 4.0 * noise.draw()).collect();
        let mut pv = vec![80.0; op.len()];
        for k in 20..op.len() {
            pv[k] = constant + 0.01 * noise.draw();
            pv[k] += (0..PAST).map(|i| past[i] * pv[k - 1 - i]).sum::<f64>();
            pv[k] += (0..TAPS).map(|j| taps[j] * op[k - delay - j]).sum::<f64>();
        }
        let (op, pv) = (&op[500..], &pv[500..]);
        let found = fit(op, pv, 15).unwrap();
        assert_eq!(found.delay, delay);
        let pairs = found.past.iter().zip(past).chain(found.taps.iter().zip(taps));
        assert!(pairs.clone().all(|(found, true_)| (found - true_).abs() < 2e-3), "{found:?}");
        assert!((found.constant - constant).abs() < 0.05, "{}", found.constant);
        assert!((found.residual_std / 0.01 - 1.0).abs() < 0.05, "{}", found.residual_std);
        assert!((found.gain() - 0.3 / 0.15).abs() < 0.01 && found.fit > 0.9999);
        let at = |k: usize| {
            let own = (0..PAST).map(|i| found.past[i] * pv[k - 1 - i]).sum::<f64>();
            found.constant + own + (0..TAPS).map(|j| found.taps[j] * op[k - delay - j]).sum::<f64>()
        };
        assert!((100..op.len()).all(|k| (found.predicted[k] - at(k)).abs() < 1e-9));
        assert_eq!(found.predicted[..10], pv[..10]);
    }

    #[test]
    fn a_model_of_nothing_is_refused() {
        let wave: Vec<f64> = (0..200).map(|k| f64::from(k % 7)).collect();
        for (op, pv, words) in [
            (&wave[..30], &wave[..30], "at least 73 samples"),
            (&wave[..], &wave[1..], "there are 200 and 199"),
            (&[1.0; 200][..], &wave[..], "does not move"),
            (&wave[..], &[f64::NAN; 200][..], "not finite"),
        ] {
            let Abstention(why) = fit(op, pv, 40).unwrap_err();
            assert!(why.contains(words), "{why}");
        }
        assert!(fit(&wave, &wave, usize::MAX).is_err());
    }

    #[test]
    fn lag_sums_give_what_the_columns_give() {
        let mut noise = NormalStream::new(3);
        let n = 160;
        let y: Vec<f64> = (0..n).map(|_| noise.draw()).collect();
        let x: Vec<Lane> = (0..n).map(|_| Lane::from_fn(|_| noise.draw())).collect();
        let delays = [1, 2, 7];
        let target = Target::new(&y, &delays).unwrap();
        for width in Width::available() {
            let fits = target.fit(&x, width);
            for l in 0..LANES {
                let x: Vec<f64> = x.iter().map(|x| x[l]).collect();
                let slow = delays.map(|d| target.explain(&[(&x, d)]).unwrap().sse);
                let best = (0..3).min_by(|a, b| slow[*a].total_cmp(&slow[*b])).unwrap();
                assert!((fits.sse[l] / slow[best] - 1.0).abs() < 1e-7, "{} {slow:?}", fits.sse[l]);
                assert_eq!(fits.delay[l], delays[best]);
            }
        }
    }

    #[test]
    fn what_cannot_be_fitted_is_not() {
        assert!(Target::new(&[0.0; 500], &[1]).is_none());
        assert!(Target::new(&[1.0, -1.0, 0.5], &[1]).is_none());
    }
}
