//! Nonlinearity by surrogate data (Thornhill 2005).
//!
//! # What it measures
//! A nonlinear loop's signal is more predictable than a linear one of the same spectrum. The signal's future is
//! predicted from the futures of its most similar pieces. The same is done for surrogates, random series of the
//! same spectrum and distribution of values. If the signal is predicted clearly better, something in the loop is
//! nonlinear. In a plant that oscillates as a whole, the index is largest near the source.
//!
//! # Assumptions
//! A stationary record of at least ten periods of a dominant oscillation.
//!
//! # Equations
//! The period is refined, within 10 %, to the period of the best-fitting sine. A whole number of periods of the control
//! error is averaged to `E` means of equal duration per period, so that end and beginning meet and the oscillation is
//! one line of the spectrum. Vectors `v_i = (x_i, ..., x_{i+E-1})`; for each, the `k` nearest `v_j` with `|i - j| >= E`
//! predict `x` after a horizon of `E`:
//! * `Gamma = sum (x_{i+E-1+E} - mean x_{j+E-1+E})²`;
//! * `N = (mean Gamma_s - Gamma) / (3 sd Gamma_s)` over the surrogates `s`; nonlinear if `N > 1`.
//!
//! Surrogates: the phases of the Fourier transform are random. Then, in turns, the values of the series are put in
//! the order of the surrogate, and the magnitudes of the transform under the phases of the surrogate (iterated
//! amplitude-adjusted Fourier transform, Schreiber & Schmitz), ending with the values. Distances of vectors follow
//! from one another: `d²(i+1, j+1) = d²(i, j) - (x_i - x_j)² + (x_{i+E} - x_{j+E})²`, so that the work does not
//! grow with `E`.
//!
//! # Parameters
//! | name | default | unit | source |
//! |---|---|---|---|
//! | neighbours | 8 | | recalled |
//! | surrogates | 50 | | recalled |
//! | limit of N | 1 | | recalled |
//! | samples per period, E | 8 | | ours; recalled are 7 to 25 |
//! | most samples | 192 | after resampling | ours, for speed |
//! | iterations | 6 | | ours, for speed |
//! | seed | 2005 | | ours |
//!
//! # Limits
//! Any nonlinearity counts, in the valve or not. A known period is needed. A change of amplitude or a transient looks
//! nonlinear. Cycles that repeat exactly are predicted no better than their surrogates, which repeat as well. A sticky
//! loop with steady cycles is therefore called linear. `N` varies by some tenths with the seed.
//!
//! # Deviations from the paper
//! Only the abstract was read; formulas and limits were recalled. The middle of a long record is used. Surrogates are
//! refined by a few iterations only, and end with the values, so that their spectrum is approximate. The original cuts
//! the record where its end matches its beginning.
//!
//! # References
//! Thornhill, IEEE Trans. Control Syst. Technol. 13 (2005) 434-443 (abstract read); Schreiber, Schmitz, Phys.
//! Rev. Lett. 77 (1996) 635-638 (not read).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{Transform, centred, mean, sample_std, standardised};
use crate::simd::{Kernel, Width};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use realfft::num_complex::Complex;

/// Number of predicting neighbours; recalled.
pub const NEIGHBOURS: usize = 8;
/// Number of surrogates; recalled.
pub const SURROGATES: usize = 50;
/// Index above which a loop is nonlinear; recalled.
pub const LIMIT: f64 = 1.0;
/// Samples per period after resampling; ours.
pub const SAMPLES_PER_PERIOD: usize = 8;
/// Largest number of samples, after resampling; ours.
pub const MOST_SAMPLES: usize = 192;
/// Iterations of a surrogate; ours.
pub const ITERATIONS: usize = 6;
/// Seed of the surrogates' phases; ours.
pub const SEED: u64 = 2005;

/// Fewest periods; ours.
const FEWEST_PERIODS: f64 = 10.0;

static METHOD: Method = Method {
    name: "surrogates",
    title: "Thornhill's surrogate data",
    source: "Thornhill, IEEE Trans. Control Syst. Technol. 13 (2005) 434-443; abstract read, formulas \
             and limits recalled",
    statistic: "N",
    rule: "nonlinear if N is above the threshold 1; N is the mean prediction error of the surrogates less the error of \
           the signal, divided by three standard deviations of the surrogates' errors",
    applies: Applies::AnyLoop,
    decides: Decides::Nonlinearity,
    needs: Needs::Error,
    family: Family::HigherOrder,
    explains_oscillation: true,
};

/// The method with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Surrogates {
    /// Number of predicting neighbours.
    pub neighbours: usize,
    /// Number of surrogates.
    pub surrogates: usize,
    /// Index above which the loop is nonlinear.
    pub limit: f64,
    /// Samples per period after resampling; fewer if fewer are recorded.
    pub samples_per_period: usize,
    /// Most samples, after resampling.
    pub most_samples: usize,
    /// Iterations of a surrogate.
    pub iterations: usize,
    /// Seed of the surrogates' phases.
    pub seed: u64,
}

impl Default for Surrogates {
    fn default() -> Self {
        Self {
            neighbours: NEIGHBOURS,
            surrogates: SURROGATES,
            limit: LIMIT,
            samples_per_period: SAMPLES_PER_PERIOD,
            most_samples: MOST_SAMPLES,
            iterations: ITERATIONS,
            seed: SEED,
        }
    }
}

/// The result of the method.
#[derive(Debug, Clone, PartialEq)]
pub struct SurrogatesResult {
    /// N from which the loop is nonlinear.
    pub limit: f64,
    /// The tested series: resampled, less its mean and over its standard deviation.
    pub series: Vec<f64>,
    /// First recorded sample.
    pub first: usize,
    /// The refined period, recorded samples.
    pub period: f64,
    /// Samples of a vector, and the horizon of the prediction.
    pub embedding: usize,
    /// The prediction error of the series.
    pub gamma: f64,
    /// Those of the surrogates.
    pub surrogates: Vec<f64>,
    /// The index N.
    pub n: f64,
    /// The decision.
    pub decision: Decision,
    /// Cautions.
    pub caveats: Vec<String>,
}

impl Surrogates {
    /// Runs the method.
    ///
    /// # Errors
    /// If the method does not apply, no period is known, or there are fewer than ten.
    pub fn run(&self, subject: &Subject<'_>) -> Result<SurrogatesResult, Abstention> {
        let caveats = subject.check(&METHOD)?;
        let abstain = |why: &str| Err(Abstention(why.to_owned()));
        let Some(error) = subject.error() else {
            return abstain("needs the PV, which is not recorded");
        };
        let Some(period) = subject.period.filter(|p| p.is_finite() && *p >= 4.0) else {
            return abstain("needs an oscillation with a period of at least four samples");
        };
        if (error.values.len() as f64) < FEWEST_PERIODS * period {
            return Err(Abstention(format!(
                "needs at least {FEWEST_PERIODS} periods; there are {:.1}",
                error.values.len() as f64 / period
            )));
        }
        let embedding = self.samples_per_period.clamp(4, 64).min(period as usize);
        let recorded = &error.values;
        // At least the needed periods, even if fewer samples are requested.
        let most = (self.most_samples.min(4096) / embedding).max(FEWEST_PERIODS as usize);
        let reach = (recorded.len() as f64 / period) as usize;
        let length = ((most.min(reach) as f64 * period) as usize).min(recorded.len());
        let first = (recorded.len() - length) / 2;
        let piece = centred(&recorded[first..first + length]);
        let period = refined(&piece, period);
        let periods = (piece.len() as f64 / period + 1e-9) as usize;
        let x = resampled(&piece, period / embedding as f64, periods * embedding);
        let Some(x) = standardised(&x).filter(|x| x.iter().all(|v| v.is_finite())) else {
            return abstain("the control error does not move, or its values are extreme");
        };
        if x.len() < 4 * embedding + self.neighbours {
            return abstain("the segment is too short for the period of the oscillation");
        }
        let mut predictor = Predictor::new(x.len(), embedding, self.neighbours.max(1));
        let gamma = predictor.error(&x);
        let mut source = Source::new(&x, self.seed);
        let surrogates: Vec<f64> = (0..self.surrogates.clamp(2, 1000))
            .map(|_| predictor.error(source.draw(self.iterations)))
            .collect();
        let n = (mean(&surrogates) - gamma) / (3.0 * sample_std(&surrogates));
        if !n.is_finite() {
            return abstain("the prediction errors of all surrogates are equal");
        }
        let decision = if n > self.limit { Decision::Nonlinear } else { Decision::Linear };
        Ok(SurrogatesResult {
            limit: self.limit,
            series: x,
            first,
            period,
            embedding,
            gamma,
            surrogates,
            n,
            decision,
            caveats,
        })
    }
}

impl Detector for Surrogates {
    fn method(&self) -> &'static Method {
        &METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![
            Number::new("neighbours", self.neighbours as f64, ""),
            Number::new("surrogates", self.surrogates as f64, ""),
            Number::new("limit of N", self.limit, ""),
            Number::new("samples per period", self.samples_per_period as f64, ""),
            Number::new("most samples", self.most_samples as f64, ""),
            Number::new("iterations", self.iterations as f64, ""),
            Number::new("seed", self.seed as f64, ""),
        ]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let result = self.run(subject)?;
        let average = mean(&result.surrogates);
        let reason = format!(
            "the squared prediction error is {:.3}, against {:.3} of {} surrogates; N = {:.2}, threshold {}",
            result.gamma,
            average,
            result.surrogates.len(),
            result.n,
            self.limit
        );
        let numbers = vec![
            Number::new("N", result.n, ""),
            Number::new("Gamma", result.gamma, ""),
            Number::new("mean Gamma of surrogates", average, ""),
            Number::new("sd Gamma of surrogates", sample_std(&result.surrogates), ""),
            Number::new("embedding", result.embedding as f64, "samples"),
        ];
        let finding = Finding::new(&METHOD, result.decision, result.n, self.limit, reason, numbers);
        let caveats = result.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(result)), ..finding })
    }
}

/// The period near `period` of the sine that explains most of `x`, which has no mean.
fn refined(x: &[f64], period: f64) -> f64 {
    let power = |period: f64| {
        // The sum of x times a rotating phasor.
        let (s, c) = (std::f64::consts::TAU / period).sin_cos();
        let (turn, mut pointer) = (Complex::new(c, s), Complex::new(1.0, 0.0));
        let mut sum = Complex::new(0.0, 0.0);
        for v in x {
            sum += pointer * v;
            pointer *= turn;
        }
        sum.norm_sqr()
    };
    // The line is as wide as one period in the whole length; steps of a fifth of that find its maximum.
    let periods = x.len() as f64 / period;
    let best = |places: &mut dyn Iterator<Item = f64>| {
        places.map(|p| (power(p), p)).max_by(|a, b| a.0.total_cmp(&b.0)).map_or(period, |b| b.1)
    };
    let steps = (0.5 * periods).ceil();
    let coarse = best(
        &mut (-(steps as i32)..=steps as i32)
            .map(|i| x.len() as f64 / (periods * (1.0 + 0.1 * f64::from(i) / steps))),
    );
    let turns = x.len() as f64 / coarse;
    best(&mut (-5..=5).map(|i| x.len() as f64 / (turns + 0.04 * f64::from(i))))
}

/// `n` means of `x` over neighbouring intervals of `step` samples; there are enough samples.
fn resampled(x: &[f64], step: f64, n: usize) -> Vec<f64> {
    let mut sums = vec![0.0; x.len() + 1];
    for (k, v) in x.iter().enumerate() {
        sums[k + 1] = sums[k] + v;
    }
    let sum_to = |place: f64| {
        let k = (place as usize).min(x.len() - 1);
        sums[k] + (place.min(x.len() as f64) - k as f64) * x[k]
    };
    (0..n).map(|i| (sum_to((i + 1) as f64 * step) - sum_to(i as f64 * step)) / step).collect()
}

/// Prediction errors of series of one length, with their buffers.
struct Predictor {
    embedding: usize,
    neighbours: usize,
    vectors: usize,
    /// Squared distances of one vector from all others, and a buffer for the next vector.
    distances: Vec<f64>,
    next: Vec<f64>,
    /// The nearest vectors of the previous vector and of this one, with their distances.
    before: Vec<usize>,
    nearest: Vec<(f64, usize)>,
}

impl Predictor {
    fn new(length: usize, embedding: usize, neighbours: usize) -> Self {
        let vectors = (length + 1).saturating_sub(2 * embedding);
        Self {
            embedding,
            neighbours,
            vectors,
            distances: vec![0.0; vectors],
            next: vec![0.0; vectors],
            before: vec![],
            nearest: Vec::with_capacity(4 * neighbours),
        }
    }

    /// The sum of squared prediction errors of `x`.
    fn error(&mut self, x: &[f64]) -> f64 {
        Width::widest().run(Predicted { predictor: self, x })
    }

    /// Computes the distances of vector `i` from the distances of vector `i - 1`.
    #[inline(always)]
    fn next_row(&mut self, x: &[f64], i: usize) {
        let e = self.embedding;
        let (gone, come) = (x[i - 1], x[i + e - 1]);
        let pairs = x.iter().zip(&x[e..]);
        for ((next, d), (old, new)) in self.next[1..].iter_mut().zip(&self.distances).zip(pairs) {
            let (old, new) = (gone - old, come - new);
            *next = d + (new * new - old * old);
        }
        self.next[0] = (0..e).map(|m| (x[m] - x[i + m]).powi(2)).sum();
        std::mem::swap(&mut self.distances, &mut self.next);
    }

    /// The nearest of all vectors at least one period from vector `i`.
    #[inline(always)]
    fn find_nearest(&mut self, i: usize) {
        let (e, n, k) = (self.embedding, self.vectors, self.neighbours);
        let allowed = [0..(i + 1).saturating_sub(e), (i + e).min(n)..n];
        // The neighbours of the previous vector, moved on, are near: no vector farther than the farthest of them is
        // among the nearest.
        let mut bound: f64 = 0.0;
        let mut known = 0;
        for j in self.before.iter().map(|j| j + 1) {
            if allowed.iter().any(|range| range.contains(&j)) {
                bound = bound.max(self.distances[j]);
                known += 1;
            }
        }
        if known < k {
            bound = f64::INFINITY;
        }
        self.nearest.clear();
        for range in allowed {
            for from in range.clone().step_by(8) {
                let part = from..(from + 8).min(range.end);
                // Most are farther, and are passed eight at a time.
                let far =
                    self.distances[part.clone()].iter().fold(true, |far, d| far & (*d > bound));
                for j in part.filter(|_| !far) {
                    let d = self.distances[j];
                    if d > bound {
                        continue;
                    }
                    let place = self.nearest.iter().rposition(|(other, _)| *other <= d);
                    self.nearest.insert(place.map_or(0, |p| p + 1), (d, j));
                    if self.nearest.len() > k {
                        self.nearest.truncate(k);
                    }
                    if self.nearest.len() == k {
                        bound = bound.min(self.nearest[k - 1].0);
                    }
                }
            }
        }
        self.before.clear();
        self.before.extend(self.nearest.iter().map(|(_, j)| *j));
    }
}

/// The prediction errors of a series.
struct Predicted<'a> {
    predictor: &'a mut Predictor,
    x: &'a [f64],
}

impl Kernel for Predicted<'_> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { predictor, x } = self;
        let (e, n) = (predictor.embedding, predictor.vectors);
        let ahead = &x[2 * e - 1..];
        predictor.before.clear();
        for j in 0..n {
            predictor.distances[j] = (0..e).map(|m| (x[m] - x[j + m]).powi(2)).sum();
        }
        let mut sum = 0.0;
        for i in 0..n {
            if i > 0 {
                predictor.next_row(x, i);
            }
            predictor.find_nearest(i);
            let predicted: f64 = predictor.nearest.iter().map(|(_, j)| ahead[*j]).sum();
            let error = ahead[i] - predicted / predictor.nearest.len().max(1) as f64;
            sum += error * error;
        }
        sum
    }
}

/// The source of a series' surrogates.
struct Source {
    random: Xoshiro256PlusPlus,
    transform: Transform,
    magnitudes: Vec<f64>,
    sorted: Vec<f64>,
    bins: Vec<Complex<f64>>,
    surrogate: Vec<f64>,
    order: Vec<u64>,
}

impl Source {
    fn new(x: &[f64], seed: u64) -> Self {
        let mut transform = Transform::new(x.len());
        let mut bins = vec![Complex::default(); transform.bins()];
        transform.forward(x, &mut bins);
        let mut sorted = x.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        Self {
            random: Xoshiro256PlusPlus::seed_from_u64(seed),
            magnitudes: bins.iter().map(|bin| bin.norm()).collect(),
            order: vec![0; x.len()],
            surrogate: x.to_vec(),
            transform,
            sorted,
            bins,
        }
    }

    /// The next surrogate.
    fn draw(&mut self, iterations: usize) -> &[f64] {
        for (bin, magnitude) in self.bins.iter_mut().zip(&self.magnitudes) {
            // 53 random bits are a number between 0 and 1.
            let turn = (self.random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
            *bin = Complex::from_polar(*magnitude, std::f64::consts::TAU * turn);
        }
        self.transform.inverse(&mut self.bins, &mut self.surrogate);
        self.take_values();
        for _ in 0..iterations {
            self.transform.forward(&self.surrogate, &mut self.bins);
            for (bin, magnitude) in self.bins.iter_mut().zip(&self.magnitudes) {
                let norm = bin.norm_sqr().sqrt();
                *bin *= if norm > 0.0 { magnitude / norm } else { 0.0 };
            }
            self.transform.inverse(&mut self.bins, &mut self.surrogate);
            self.take_values();
        }
        &self.surrogate
    }

    /// Replaces each value of the surrogate by the series' value of the same rank.
    fn take_values(&mut self) {
        // Integers sort fast. The bits of a number are mapped to an integer of the same order, with its index in
        // the last twelve bits, which are far below the relevant digits. Indices are below 4096.
        for (k, (order, value)) in self.order.iter_mut().zip(&self.surrogate).enumerate() {
            let bits = value.to_bits();
            let ordered = if bits >> 63 == 1 { !bits } else { bits | 1 << 63 };
            *order = ordered & !0xFFF | k as u64;
        }
        self.order.sort_unstable();
        for (order, value) in self.order.iter().zip(&self.sorted) {
            self.surrogate[(order & 0xFFF) as usize] = *value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chirps(n: usize) -> Vec<f64> {
        (0..n).map(|k| (0.8 * k as f64).sin() + 0.3 * ((k * k) as f64).sin()).collect()
    }

    #[test]
    fn prediction_errors_are_those_of_the_definition() {
        let (x, e, k) = (chirps(120), 8, 5);
        let n = x.len() + 1 - 2 * e;
        let mut slow = 0.0;
        for i in 0..n {
            let mut others: Vec<(f64, usize)> = (0..n)
                .filter(|j| i.abs_diff(*j) >= e)
                .map(|j| ((0..e).map(|m| (x[i + m] - x[j + m]).powi(2)).sum(), j))
                .collect();
            others.sort_by(|a, b| a.0.total_cmp(&b.0));
            let predicted: f64 = others[..k].iter().map(|(_, j)| x[j + 2 * e - 1]).sum();
            slow += (x[i + 2 * e - 1] - predicted / k as f64).powi(2);
        }
        let fast = Predictor::new(x.len(), e, k).error(&x);
        assert!((fast / slow - 1.0).abs() < 1e-9, "{fast} {slow}");
    }

    #[test]
    fn surrogates_have_the_values_and_nearly_the_spectrum() {
        let x = chirps(150);
        let mut source = Source::new(&x, 1);
        let mut surrogate = source.draw(20).to_vec();
        let (a, b) = (
            crate::series::autocorrelation(&x, 20).unwrap(),
            crate::series::autocorrelation(&surrogate, 20).unwrap(),
        );
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 0.1));
        assert!(surrogate != x);
        surrogate.sort_by(f64::total_cmp);
        assert_eq!(surrogate, source.sorted);
        // Another seed, another surrogate; the same seed, the same.
        assert_eq!(Source::new(&x, 1).draw(3), Source::new(&x, 1).draw(3));
        assert_ne!(Source::new(&x, 1).draw(3), Source::new(&x, 2).draw(3));
    }

    #[test]
    fn the_period_is_found_from_nearby() {
        let x: Vec<f64> =
            (0..700).map(|k| (std::f64::consts::TAU * f64::from(k) / 31.3).sin()).collect();
        for guess in [29.5, 31.0, 33.0] {
            assert!((refined(&x, guess) - 31.3).abs() < 0.06, "{}", refined(&x, guess));
        }
        let y = resampled(&x, 31.3 / 8.0, 160);
        assert!((0..152).all(|k| (y[k] - y[k + 8]).abs() < 0.05));
    }
}
