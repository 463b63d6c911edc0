//! Least-squares shapes in the half waves of a signal: sine, triangle, square, and a square wave behind a
//! first-order lag.

use crate::finding::Abstention;
use crate::methods::subject::Subject;
use crate::series::HalfWave;

/// Number of samples in the shortest half wave that is used. Ours: with fewer, a triangle with a free apex passes
/// through all of them.
pub const LEAST_SAMPLES: usize = 5;

/// Fewest half waves for a judgement: two cycles. Ours.
pub const LEAST_HALF_WAVES: usize = 4;

/// The samples of one half wave.
#[derive(Debug, Clone, Copy)]
pub struct Piece<'a> {
    pub wave: HalfWave,
    pub y: &'a [f64],
}

/// The half waves of `x` with at least [`LEAST_SAMPLES`] samples.
pub fn pieces<'a>(x: &'a [f64], waves: &[HalfWave]) -> Vec<Piece<'a>> {
    let long = waves.iter().filter(|wave| wave.end - wave.first >= LEAST_SAMPLES);
    long.map(|&wave| Piece { wave, y: &x[wave.first..wave.end] }).collect()
}

/// Whether this number of half waves suffices for a judgement.
pub fn enough(count: usize) -> Result<(), Abstention> {
    if count >= LEAST_HALF_WAVES {
        return Ok(());
    }
    Err(Abstention(format!(
        "finds {count} half waves of at least {LEAST_SAMPLES} samples, but needs {LEAST_HALF_WAVES}"
    )))
}

/// `statistic`, if its input could be represented.
pub fn representable(statistic: f64) -> Result<f64, Abstention> {
    if statistic.is_finite() {
        Ok(statistic)
    } else {
        Err(Abstention("the samples are too large, too small or too similar to compare".to_owned()))
    }
}

/// Notes in `caveats` that no oscillation is known, for a method that assumes one.
pub fn presume_oscillation(subject: &Subject<'_>, caveats: &mut Vec<String>) {
    if subject.period.is_none() {
        caveats.push("the method assumes an oscillation, and none was detected".to_owned());
    }
}

/// A triangle on a half wave: two lines through its two zeros, each by least squares on its side of the apex. The two
/// lines need not meet there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    /// Sample of the apex.
    pub apex: usize,
    /// Slope of the first side, per sample.
    pub rise: f64,
    /// Slope of the second side towards its zero, per sample: positive if the first is.
    pub fall: f64,
}

impl Triangle {
    /// Value at `k` in its half wave, in samples.
    pub fn at(&self, wave: &HalfWave, k: f64) -> f64 {
        if k <= self.apex as f64 { self.rise * (k - wave.from) } else { self.fall * (wave.to - k) }
    }
}

/// A shape of one factor and how well it fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scaled {
    pub amplitude: f64,
    pub mse: f64,
}

impl Piece<'_> {
    /// Time of sample `i` since the half wave began, in samples.
    fn t(&self, i: usize) -> f64 {
        (self.wave.first + i) as f64 - self.wave.from
    }

    /// Mean square distance of the samples from a shape.
    fn mse(&self, shape: impl Fn(usize) -> f64) -> f64 {
        let squares = self.y.iter().enumerate().map(|(i, y)| (y - shape(i)).powi(2));
        squares.sum::<f64>() / self.y.len() as f64
    }

    /// `amplitude * shape` of least squares.
    fn scaled(&self, shape: impl Iterator<Item = f64>) -> Scaled {
        let shape: Vec<f64> = shape.collect();
        let (mut sy, mut ss) = (0.0, 0.0);
        for (y, s) in self.y.iter().zip(&shape) {
            sy += y * s;
            ss += s * s;
        }
        let amplitude = sy / ss;
        Scaled { amplitude, mse: self.mse(|i| amplitude * shape[i]) }
    }

    /// Half a period of a sine between the crossings.
    pub fn sine(&self) -> Scaled {
        let step = std::f64::consts::PI / self.wave.length();
        self.scaled((0..self.y.len()).map(|i| (step * self.t(i)).sin()))
    }

    /// A constant between the crossings.
    pub fn square(&self) -> Scaled {
        self.scaled(std::iter::repeat_n(1.0, self.y.len()))
    }

    /// The triangle with the best apex among the inner samples, and its mean square error. The sample at the apex
    /// counts in the slopes of both sides.
    pub fn triangle(&self) -> (Triangle, f64) {
        let (n, length) = (self.y.len(), self.wave.length());
        // Sums over the samples from each apex on.
        let (mut yy, mut qy, mut qq) = (0.0, 0.0, 0.0);
        let mut after = vec![(0.0, 0.0, 0.0); n + 1];
        for i in (0..n).rev() {
            let (y, q) = (self.y[i], length - self.t(i));
            yy += y * y;
            qy += q * y;
            qq += q * q;
            after[i] = (yy, qy, qq);
        }
        let mut best = (f64::INFINITY, Triangle { apex: self.wave.first, rise: 0.0, fall: 0.0 });
        let (mut yy, mut ty, mut tt) = (0.0, 0.0, 0.0);
        for i in 0..n - 1 {
            let (y, t) = (self.y[i], self.t(i));
            yy += y * y;
            ty += t * y;
            tt += t * t;
            if i == 0 {
                continue;
            }
            let (rise, fall) = (ty / tt, after[i].1 / after[i].2);
            let (right_yy, right_qy, right_qq) = after[i + 1];
            let error = (yy - rise * ty) + (right_yy - fall * (2.0 * right_qy - fall * right_qq));
            if error < best.0 {
                best = (error, Triangle { apex: self.wave.first + i, rise, fall });
            }
        }
        let triangle = best.1;
        (triangle, self.mse(|i| triangle.at(&self.wave, (self.wave.first + i) as f64)))
    }

    /// The response of a first-order lag with dead time to a square wave of this half period: the best with a half
    /// period of `LEAST_RATIO` to `LARGEST_RATIO` time constants.
    pub fn relay(&self) -> (Relay, f64) {
        let (mut low, mut high) = (LEAST_RATIO, LARGEST_RATIO);
        let mut best = Relay { amplitude: 0.0, ratio: low };
        // Two passes over a geometric grid, the second between the neighbours of the first's best.
        for _ in 0..2 {
            let step = (high / low).powf(1.0 / (RATIOS - 1) as f64);
            let ratios: [f64; RATIOS] = std::array::from_fn(|i| low * step.powi(i as i32));
            let (fy, ff) = self.relay_sums(&ratios);
            let explained = |i: usize| fy[i] * fy[i] / ff[i];
            let i = (0..RATIOS).fold(0, |a, b| if explained(b) > explained(a) { b } else { a });
            best = Relay { amplitude: fy[i] / ff[i], ratio: ratios[i] };
            (low, high) = (ratios[i.saturating_sub(1)], ratios[(i + 1).min(RATIOS - 1)]);
        }
        (best, self.mse(|i| best.at(&self.wave, (self.wave.first + i) as f64)))
    }

    /// Sums of `f y` and `f f` over the samples, for the relay response `f` of each ratio.
    fn relay_sums(&self, ratios: &[f64; RATIOS]) -> ([f64; RATIOS], [f64; RATIOS]) {
        let length = self.wave.length();
        let (mut fy, mut ff) = ([0.0; RATIOS], [0.0; RATIOS]);
        let decay = ratios.map(|ratio| (-ratio / length).exp());
        let whole = ratios.map(f64::exp);
        let mut g = ratios.map(|ratio| (-ratio / length * self.t(0)).exp());
        for &y in self.y {
            for r in 0..RATIOS {
                let f = (1.0 - g[r]).min(whole[r] * g[r] - 1.0);
                fy[r] += f * y;
                ff[r] += f * f;
                g[r] *= decay[r];
            }
        }
        (fy, ff)
    }
}

/// Ratios per search step.
const RATIOS: usize = 16;
/// Half period over time constant below which the response is a triangle.
const LEAST_RATIO: f64 = 0.1;
/// Half period over time constant above which the response is a square wave.
const LARGEST_RATIO: f64 = 20.0;

/// The response of a first-order lag with dead time to a relay, between two crossings of zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relay {
    /// The final level of either side.
    pub amplitude: f64,
    /// Half period over time constant.
    pub ratio: f64,
}

impl Relay {
    /// Value at `k` in its half wave, in samples.
    pub fn at(&self, wave: &HalfWave, k: f64) -> f64 {
        let g = (-self.ratio * (k - wave.from) / wave.length()).exp();
        self.amplitude * (1.0 - g).min(self.ratio.exp() * g - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::half_waves;

    /// Two periods of `shape` of the phase in periods, from just before a crossing.
    fn wave(shape: impl Fn(f64) -> f64, period: f64) -> Vec<f64> {
        let end = (2.0 * period) as usize + 2;
        (0..end).map(|k| shape((k as f64 - 0.7) / period)).collect()
    }

    #[test]
    fn a_shape_fits_itself() {
        let half = |phase: f64, f: &dyn Fn(f64) -> f64| {
            let (sign, phase) =
                if phase.rem_euclid(1.0) < 0.5 { (3.0, phase) } else { (-3.0, phase) };
            sign * f(phase.rem_euclid(0.5) * 2.0)
        };
        let lag = |t: f64| (1.0 - (-2.0 * t).exp()).min((2.0 - 2.0 * t).exp() - 1.0);
        let (sine, relay) =
            (wave(|p| (std::f64::consts::TAU * p).sin(), 4000.0), wave(|p| half(p, &lag), 4000.0));
        let triangle = wave(|p| half(p, &|t| t.min(1.0 - t)), 400.0);
        for piece in pieces(&sine, &half_waves(&sine)) {
            assert!(piece.sine().mse < 1e-12 && (piece.sine().amplitude.abs() - 1.0).abs() < 1e-6);
            // Relative error of the best triangle: 1 - 96/pi^4.
            let expected = 0.5 * (1.0 - 96.0 / std::f64::consts::PI.powi(4));
            assert!((piece.triangle().1 / expected - 1.0).abs() < 3e-3);
        }
        for piece in pieces(&triangle, &half_waves(&triangle)) {
            let (found, mse) = piece.triangle();
            assert!(mse < 1e-6, "{mse:e}");
            assert!((found.rise.abs() / (3.0 / 200.0) - 1.0).abs() < 1e-2, "{found:?}");
        }
        for piece in pieces(&relay, &half_waves(&relay)) {
            let (found, mse) = piece.relay();
            assert!(mse < 1e-4 && (found.ratio - 2.0).abs() < 0.1, "{found:?} {mse:e}");
            assert!(mse < piece.triangle().1 && mse < piece.sine().mse);
        }
    }
}
