//! How well one signal follows another as a PI controller's output follows its error.
//!
//! # Equation
//! ```text
//! y(k) = c_0 x(k) + c_1 x(k-1) + c_2 sum_{i <= k} x(i) + level + slope k
//! ```
//! in blocks of equal length, by least squares with the same `c` for all. Each block has its own level and slope,
//! so an unknown set point, a drifting load and the past do not matter. Blocks are weighted by the inverse of their
//! variance plus a tenth of the mean variance, so that one upset does not dominate.
//!
//! * `explained`: the share of y explained in blocks by the `c` of all *other* blocks. It is negative for unrelated
//!   signals, for any number of blocks.
//! * `integral`: the t statistic over blocks of the sign of `c_2 (c_0 + c_1)`. In closed loop OP and PV obey the
//!   controller's law, with any valve. A controller integrates, so the OP as `y` lags the PV as `x`: positive. This law
//!   solved for the PV leads: negative. Exchanged columns change both signs.

/// The law of one direction and block length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Law {
    /// Share of the variance in blocks that the law from the other blocks explains.
    pub explained: f64,
    /// The t statistic of the integral part.
    pub integral: f64,
    /// Number of blocks over which the variance is spread.
    pub blocks: f64,
}

/// Share of the mean variance that is added to a block's own variance in its weight.
const CALM: f64 = 0.1;
/// Variance of a correlation that is added to the variance of the blocks, because a few blocks may agree by chance.
const LEAST_SPREAD: f64 = 1e-3;
/// Smallest number of blocks for a law.
const FEWEST: usize = 4;

type Matrix = [[f64; 3]; 3];

struct Block {
    products: Matrix,
    with_target: [f64; 3],
    target: f64,
}

impl Block {
    /// The block that starts at `from`, which is not the first sample.
    fn of(y: &[f64], x: &[f64], from: usize, length: usize) -> Self {
        let (until, n) = (from + length, length as f64);
        let x0 = &x[from..until];
        let level = x0.iter().sum::<f64>() / n;
        let mut sum = 0.0;
        let summed = x0.iter().map(|v| {
            sum += (v - level) / n;
            sum
        });
        let columns = [summed.collect(), x0.to_vec(), x[from - 1..until - 1].to_vec()];
        let [s, x0, x1] = columns.map(without_line);
        let columns = [&x0, &x1, &s];
        let y = without_line(y[from..until].to_vec());
        Self {
            products: columns.map(|a| columns.map(|b| dot(a, b))),
            with_target: columns.map(|a| dot(a, &y)),
            target: dot(&y, &y),
        }
    }

    /// The residual of the target after `c`.
    fn left(&self, c: [f64; 3]) -> f64 {
        let mut left = self.target;
        for i in 0..3 {
            left -= 2.0 * c[i] * self.with_target[i];
            for j in 0..3 {
                left += c[i] * c[j] * self.products[i][j];
            }
        }
        left.max(0.0)
    }

    /// The correlation of target and sum, without the part that the input explains by `of_target` and `of_sum`.
    fn partial(&self, of_target: [f64; 2], of_sum: [f64; 2]) -> f64 {
        let (g, r) = (&self.products, &self.with_target);
        let (mut q, mut s) = (r[2], g[2][2]);
        for i in 0..2 {
            q -= of_sum[i] * r[i] + of_target[i] * g[i][2];
            s -= 2.0 * of_sum[i] * g[i][2];
            for j in 0..2 {
                q += of_target[i] * of_sum[j] * g[i][j];
                s += of_sum[i] * of_sum[j] * g[i][j];
            }
        }
        let scale = (s.max(0.0) * self.target).sqrt();
        if scale > 0.0 { q / scale } else { 0.0 }
    }
}

impl Law {
    /// How `y` follows `x` in blocks of this length whose first sample satisfies `counts`; `None` if the blocks are too
    /// few, or nothing moves.
    pub fn of(y: &[f64], x: &[f64], length: usize, counts: &dyn Fn(usize) -> bool) -> Option<Self> {
        let starts =
            (1..y.len().min(x.len())).step_by(length).filter(|from| from + length <= y.len());
        let mut blocks: Vec<Block> =
            starts.filter(|from| counts(*from)).map(|from| Block::of(y, x, from, length)).collect();
        let mean = blocks.iter().map(|b| b.target).sum::<f64>() / blocks.len() as f64;
        if blocks.len() < FEWEST || !(mean > 0.0 && mean.is_finite()) {
            return None;
        }
        let (mut all, mut with, mut total, mut squares) = ([[0.0; 3]; 3], [0.0; 3], 0.0, 0.0);
        for block in &mut blocks {
            let weight = 1.0 / (block.target + CALM * mean);
            block.target *= weight;
            block.with_target.iter_mut().for_each(|v| *v *= weight);
            block.products.iter_mut().flatten().for_each(|v| *v *= weight);
            add(&mut all, &mut with, block, 1.0);
            total += block.target;
            squares += block.target * block.target;
        }
        let c = solved(all, with);
        let (of_target, of_sum) =
            (solved_two(&all, [with[0], with[1]]), solved_two(&all, [all[0][2], all[1][2]]));
        let sign = (c[0] + c[1]).signum();
        let (mut left, mut sum, mut square) = (0.0, 0.0, 0.0);
        for block in &blocks {
            let (mut others, mut with_others) = (all, with);
            add(&mut others, &mut with_others, block, -1.0);
            left += block.left(solved(others, with_others));
            let together = sign * block.partial(of_target, of_sum);
            sum += together;
            square += together * together;
        }
        let n = blocks.len() as f64;
        let spread = (square / n - (sum / n).powi(2)).max(0.0) + LEAST_SPREAD;
        let law = Self {
            explained: 1.0 - left / total,
            integral: sum / n / (spread / n).sqrt(),
            blocks: total * total / squares,
        };
        (law.explained.is_finite() && law.integral.is_finite()).then_some(law)
    }
}

fn add(all: &mut Matrix, with: &mut [f64; 3], block: &Block, factor: f64) {
    for i in 0..3 {
        with[i] += factor * block.with_target[i];
        for j in 0..3 {
            all[i][j] += factor * block.products[i][j];
        }
    }
}

/// The series without its nearest straight line.
fn without_line(mut x: Vec<f64>) -> Vec<f64> {
    let n = x.len() as f64;
    let (middle, mean) = ((n - 1.0) / 2.0, x.iter().sum::<f64>() / n);
    let rise: f64 = x.iter().enumerate().map(|(k, v)| (k as f64 - middle) * (v - mean)).sum();
    let slope = rise / (n * (n * n - 1.0) / 12.0);
    for (k, v) in x.iter_mut().enumerate() {
        *v -= mean + slope * (k as f64 - middle);
    }
    x
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The solution of three equations, by elimination with a little ridge.
fn solved(mut a: Matrix, mut b: [f64; 3]) -> [f64; 3] {
    for (i, row) in a.iter_mut().enumerate() {
        row[i] += 1e-9 * row[i] + f64::MIN_POSITIVE;
    }
    for i in 0..3 {
        for j in i + 1..3 {
            let factor = a[j][i] / a[i][i];
            for m in i..3 {
                a[j][m] -= factor * a[i][m];
            }
            b[j] -= factor * b[i];
        }
    }
    for i in (0..3).rev() {
        for m in i + 1..3 {
            b[i] -= a[i][m] * b[m];
        }
        b[i] /= a[i][i];
    }
    b
}

/// The solution of the first two of three equations.
fn solved_two(a: &Matrix, b: [f64; 2]) -> [f64; 2] {
    let floor = 1e-12 * a[0][0] * a[1][1] + f64::MIN_POSITIVE;
    let d = (a[0][0] * a[1][1] - a[0][1] * a[0][1]).max(floor);
    [(b[0] * a[1][1] - b[1] * a[0][1]) / d, (b[1] * a[0][0] - b[0] * a[0][1]) / d]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(n: usize, mut seed: u64) -> Vec<f64> {
        let next = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / f64::from(1u32 << 31) - 0.5
        };
        std::iter::repeat_with(next).take(n).collect()
    }

    /// What a PI controller makes of an error.
    fn controlled(error: &[f64]) -> Vec<f64> {
        let mut sum = 0.0;
        let of = |e: &f64| {
            sum += 0.1 * e;
            -2.0 * (e + sum)
        };
        error.iter().map(of).collect()
    }

    #[test]
    fn a_controller_lags_and_its_inverse_leads() {
        let mut wave = noise(1000, 3);
        for k in 1..1000 {
            wave[k] += 0.9 * wave[k - 1];
        }
        let op = controlled(&wave);
        let forward = Law::of(&op, &wave, 64, &|_| true).unwrap();
        let back = Law::of(&wave, &op, 64, &|_| true).unwrap();
        assert!((forward.explained - 1.0).abs() < 1e-6 && forward.integral > 10.0, "{forward:?}");
        assert!(back.explained < forward.explained && back.integral < -3.0, "{back:?}");
    }

    #[test]
    fn unrelated_signals_explain_nothing() {
        for length in [16, 64] {
            let law = Law::of(&noise(1000, 1), &noise(1000, 2), length, &|_| true).unwrap();
            assert!(law.explained < 0.02 && law.blocks > 10.0, "{law:?}");
        }
        assert_eq!(Law::of(&[1.0; 200], &noise(200, 1), 16, &|_| true), None);
        assert_eq!(Law::of(&noise(50, 2), &noise(50, 1), 16, &|_| true), None);
    }
}
