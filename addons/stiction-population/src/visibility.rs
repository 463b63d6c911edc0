//! Whether a record can show that its valve sticks: by the likelihood of the PV, given the stem or the OP.

use stiction_diagnose::series::{mean, median, std};

/// Gain in log-likelihood from which a sticking valve counts as visible, nats. It consists of 8, of 4 that eight more
/// factors gain by chance, and of `ln 36` for an observer who has to find S and J among 36 pairs and does not know the
/// stem.
pub(super) const NATS: f64 = 15.6;

/// Most and fewest rows of a regression.
const ROWS: (usize, usize) = (800, 150);
/// More of them are not independent of unmodelled effects.
const EFFECTIVE: f64 = 500.0;
const OWN: usize = 5;
const MEANS: usize = 4;
const TAPS: [usize; 8] = [0, 1, 2, 3, 5, 7, 10, 14];
/// Number of columns of the past, columns with the OP, and all columns.
const PAST: usize = 2 + OWN + MEANS;
const WITHOUT: usize = PAST + TAPS.len();
const COLUMNS: usize = WITHOUT + TAPS.len();

/// The data of an observer: the recorded PV, and the loop itself, step by step.
pub(super) struct Observed<'a> {
    /// The PV at the recorded instants.
    pub recorded: &'a [f64],
    /// PV, OP and position of the stem at every step of the controller.
    pub pv: &'a [f64],
    pub op: &'a [f64],
    pub stem: &'a [f64],
    /// Steps a recorded sample.
    pub steps: usize,
    /// Dead time between stem and PV, in steps.
    pub dead_time: f64,
}

impl Observed<'_> {
    /// Information of the true stem about the PV beyond the information of the OP, nats.
    ///
    /// `y(k)`, the PV at every `q`-th recorded instant, is regressed on a constant, a line, five of its own past
    /// values, and means over the `q` samples strictly before an instant. These are four of the PV, before the
    /// instants 1 to 4 back, and eight of the OP, before the instants 0, 1, 2, 3, 5, 7, 10 and 14 back (more if the
    /// dead time is longer). A second regression adds such means of the stem. The OP is kept with the stem, because
    /// through the controller it contains the PV: that between the instants, and, through the integral, that of
    /// long ago.
    ///
    /// The gain is the difference of the two logarithms of likelihood of Student's t with four degrees of freedom. The
    /// scale is the scale of the residuals without the stem (median of their size) plus 5 % of the residual variance
    /// after the PV's own past, because no model is perfect. The gain is multiplied by the effective number of samples over
    /// `n`. This number is `n (1 - |r|)/(1 + |r|)` with the first autocorrelation of the residuals with the stem, 500 at
    /// most. Zero if the record is too short or the PV does not move.
    pub fn gain(&self) -> f64 {
        let Some(fits) = Rows::of(self, self.decimation()).fits() else { return 0.0 };
        let scale = (median_size(&fits.without) / 0.6745).powi(2) + 0.05 * fits.own;
        if !(scale > 0.0) {
            return 0.0;
        }
        let loss = |e: f64| 2.5 * (1.0 + e * e / (4.0 * scale)).ln();
        let gain: f64 = fits.without.iter().zip(&fits.with).map(|(a, b)| loss(*a) - loss(*b)).sum();
        let n = fits.with.len() as f64;
        let r = autocorrelation(&fits.with).abs();
        let effective = (n * (1.0 - r) / (1.0 + r)).min(EFFECTIVE);
        let gain = gain * effective / n;
        if gain.is_finite() { gain } else { 0.0 }
    }

    /// Recorded samples between two rows, limited by a fortieth of the OP's period, the number of rows, and the
    /// hold time of the PV.
    fn decimation(&self) -> usize {
        let n = self.recorded.len();
        let centre = mean(self.op);
        let crossings =
            self.op.windows(2).filter(|x| (x[0] - centre) * (x[1] - centre) < 0.0).count();
        let period = 2.0 * n as f64 / (1.0 + crossings as f64);
        let changes = self.recorded.windows(2).filter(|x| x[0] != x[1]).count();
        let q =
            (n as f64 / ROWS.0 as f64).max(period / 40.0).max(n as f64 / (1.0 + changes as f64));
        q.min(n as f64 / ROWS.1 as f64).max(1.0) as usize
    }
}

/// The regression.
struct Rows {
    /// Additional delay of the taps for the dead time, blocks.
    later: usize,
    y: Vec<f64>,
    means: Vec<f64>,
    op: Vec<f64>,
    stem: Vec<f64>,
}

/// Residuals without and with the stem, and the mean square after the PV's own past.
struct Fits {
    without: Vec<f64>,
    with: Vec<f64>,
    own: f64,
}

impl Rows {
    fn of(seen: &Observed<'_>, q: usize) -> Self {
        let block = q * seen.steps;
        let blocks = seen.recorded.len() / q;
        // The steps of block k end before that at which y(k) is read.
        let y: Vec<f64> = (0..blocks).map(|k| seen.recorded[(k + 1) * q - 1]).collect();
        let later = ((seen.dead_time / block as f64) as usize).saturating_sub(1).min(blocks / 4);
        let (centre, size) = (mean(&y), scale_of(&y));
        let of_pv = |v: &f64| (v - centre) / size;
        let standard = |x: Vec<f64>| {
            let (centre, size) = (mean(&x), scale_of(&x));
            x.iter().map(|v| (v - centre) / size).collect()
        };
        Self {
            later,
            means: block_means(seen.pv, block).iter().map(of_pv).collect(),
            y: y.iter().map(of_pv).collect(),
            op: standard(block_means(seen.op, block)),
            stem: standard(block_means(seen.stem, block)),
        }
    }

    fn row(&self, k: usize) -> [f64; COLUMNS] {
        let mut row = [0.0; COLUMNS];
        row[0] = 1.0;
        row[1] = k as f64 / self.y.len() as f64 - 0.5;
        for j in 0..OWN {
            row[2 + j] = self.y[k - 1 - j];
        }
        for j in 0..MEANS {
            row[2 + OWN + j] = self.means[k - 1 - j];
        }
        for (j, lag) in TAPS.iter().enumerate() {
            row[PAST + j] = self.op[k - lag - self.later];
            row[WITHOUT + j] = self.stem[k - lag - self.later];
        }
        row
    }

    fn fits(&self) -> Option<Fits> {
        let n = self.y.len();
        let first = (self.later + TAPS[TAPS.len() - 1]).max(OWN);
        if n < first + 2 * COLUMNS || self.y.iter().all(|v| *v == self.y[0]) {
            return None;
        }
        let rows: Vec<_> = (first..n).map(|k| self.row(k)).collect();
        let y = &self.y[first..];
        let normal = Normal::of(&rows, y);
        let left = |columns: usize| -> Vec<f64> {
            let coefficients = normal.solution(columns);
            let explained = |row: &[f64; COLUMNS]| -> f64 {
                row.iter().zip(&coefficients).map(|(a, b)| a * b).sum()
            };
            rows.iter().zip(y).map(|(row, y)| y - explained(row)).collect()
        };
        let all: f64 = y.iter().map(|y| y * y).sum();
        let by_past: f64 = normal.target[..PAST].iter().map(|z| z * z).sum();
        let own = (all - by_past).max(0.0) / rows.len() as f64;
        Some(Fits { without: left(WITHOUT), with: left(COLUMNS), own })
    }
}

/// Normal equations, factored by Cholesky with a small ridge. The first columns of the factor solve the equations of
/// the first columns.
struct Normal {
    factor: [[f64; COLUMNS]; COLUMNS],
    target: [f64; COLUMNS],
}

impl Normal {
    fn of(rows: &[[f64; COLUMNS]], y: &[f64]) -> Self {
        const RIDGE: f64 = 1e-7;
        let mut factor = [[0.0; COLUMNS]; COLUMNS];
        let mut target = [0.0; COLUMNS];
        for (row, y) in rows.iter().zip(y) {
            for i in 0..COLUMNS {
                for (sum, other) in factor[i][..=i].iter_mut().zip(row) {
                    *sum += row[i] * other;
                }
                target[i] += row[i] * y;
            }
        }
        let ridge = RIDGE * rows.len() as f64;
        for i in 0..COLUMNS {
            factor[i][i] += ridge;
            for j in 0..=i {
                let mut sum = factor[i][j];
                for m in 0..j {
                    sum -= factor[i][m] * factor[j][m];
                }
                factor[i][j] = if i == j { sum.max(ridge).sqrt() } else { sum / factor[j][j] };
            }
            for m in 0..i {
                target[i] -= factor[i][m] * target[m];
            }
            target[i] /= factor[i][i];
        }
        Self { factor, target }
    }

    /// The factors of the first columns, this many.
    fn solution(&self, columns: usize) -> Vec<f64> {
        let mut solution = self.target[..columns].to_vec();
        for i in (0..columns).rev() {
            for m in i + 1..columns {
                solution[i] -= self.factor[m][i] * solution[m];
            }
            solution[i] /= self.factor[i][i];
        }
        solution
    }
}

/// The standard deviation, or one if it is zero.
fn scale_of(x: &[f64]) -> f64 {
    let sd = std(x);
    if sd > 0.0 { sd } else { 1.0 }
}

/// Means of blocks that end one step before the blocks of the record do; the first is one step shorter.
fn block_means(x: &[f64], block: usize) -> Vec<f64> {
    let mean_of = |k: usize| {
        let part = &x[(k * block).saturating_sub(1)..((k + 1) * block - 1).max(1)];
        part.iter().sum::<f64>() / part.len() as f64
    };
    (0..x.len() / block).map(mean_of).collect()
}

fn median_size(x: &[f64]) -> f64 {
    let sizes: Vec<f64> = x.iter().map(|v| v.abs()).collect();
    median(&sizes)
}

fn autocorrelation(x: &[f64]) -> f64 {
    let all: f64 = x.iter().map(|v| v * v).sum();
    let next: f64 = x.windows(2).map(|x| x[0] * x[1]).sum();
    if all > 0.0 { next / all } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_model::closed_loop::NormalStream;

    /// A first-order process behind a play of `band`, under an OP that swings by two percent.
    fn gain(band: f64, noise: f64, shuffled: bool) -> f64 {
        let mut stream = NormalStream::new(3);
        let (mut stem, mut x) = (0.0, 0.0);
        let mut all = [vec![], vec![], vec![]];
        for k in 0..1200 {
            let op = (f64::from(k) * 0.13).sin() + 0.1 * stream.draw();
            all[0].push(x + noise * stream.draw());
            stem += (op - stem - band / 2.0).max(0.0) + (op - stem + band / 2.0).min(0.0);
            x += 0.2 * (stem - x);
            all[1].push(op);
            all[2].push(stem);
        }
        if shuffled {
            all[2].reverse();
        }
        let [pv, op, stem] = &all;
        Observed { recorded: pv, pv, op, stem, steps: 1, dead_time: 0.0 }.gain()
    }

    #[test]
    fn a_band_is_seen_until_noise_drowns_it() {
        assert!(gain(1.0, 0.01, false) > 100.0);
        assert!(gain(1.0, 0.05, false) > gain(1.0, 0.5, false));
        assert!(gain(1.0, 5.0, false) < NATS);
    }

    #[test]
    fn a_stem_that_says_nothing_new_gains_nothing() {
        assert!(gain(0.0, 0.05, false) < NATS, "{}", gain(0.0, 0.05, false));
        assert!(gain(1.0, 0.05, true) < NATS, "{}", gain(1.0, 0.05, true));
    }

    #[test]
    fn what_does_nothing_or_is_short_gains_nothing() {
        let (flat, wave): (Vec<f64>, Vec<f64>) =
            (vec![5.0; 400], (0..400).map(|k| f64::from(k).sin()).collect());
        let seen = |pv: &[f64], n: usize| {
            let (pv, wave) = (&pv[..n], &wave[..n]);
            Observed { recorded: pv, pv, op: wave, stem: wave, steps: 1, dead_time: 1e9 }.gain()
        };
        assert_eq!(seen(&flat, 400), 0.0);
        assert_eq!(seen(&wave, 20), 0.0);
        assert_eq!(seen(&wave, 1), 0.0);
    }
}
