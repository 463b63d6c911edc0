//! Bicoherence, and the ellipse of PV and OP (Choudhury, Shah & Thornhill 2004, 2006).
//!
//! # What it measures
//! Components of a linear system's signals have no fixed phases among each other. A sticking valve binds the phases
//! of its harmonics to the fundamental; bicoherence measures that. If the loop is nonlinear and PV and OP, filtered
//! around the oscillation, move along an ellipse, the width of the ellipse along the OP is the apparent stiction.
//!
//! # Assumptions
//! A stationary record of some ten segments. The valve is the only nonlinearity of the loop, and disturbances are
//! linear (the method cannot locate a nonlinearity).
//!
//! # Equations
//! The control error is decimated to 12 to 24 samples per period and cut into `K` segments of `L`
//! samples, half overlapping, each less its mean and under a Hann window; `X` are their transforms:
//! * `bic²(i, j) = |sum X_i X_j X*_{i+j}|² / (sum |X_i X_j|² sum |X_{i+j}|²)`, `j <= i`, `i + j <= L/2`;
//! * `NGI = mean of the significant bic² - crit`, 0 if there is none; `NLI = |max bic² - (mean + 2 sd)|`;
//! * linear and Gaussian if `NGI <= 0.001`, linear if `NLI < 0.01`, else nonlinear;
//! * cubic coupling `|sum X_i³ X*_{3i}|² / (sum |X_i³|² sum |X_{3i}|²)`, nonlinear where
//!   significant, `i >= 2`;
//! * the ellipse: see [`Ellipse`]; apparent stiction is
//!   [`Ellipse::op_width`] of the OP and PV, both limited to a half to three
//!   and a half times the frequency of the oscillation.
//!
//! # Parameters
//! | name | default | unit | source |
//! |---|---|---|---|
//! | segment | 64 | samples | recalled (64 to 128) |
//! | NGI limit | 0.001 | | recalled |
//! | NLI limit | 0.01 | | recalled |
//! | alpha | 0.01 | | ours, for all bins together |
//! | power floor | 1e-4 | | ours |
//! | most segments | 256 | | ours, for speed |
//! | most residual | 0.3 | | ours |
//!
//! # Limits
//! Bicoherence is blind to cycles whose half waves mirror each other, because they have no even harmonics. The
//! limit cycle of a loop with a symmetric sticky valve is of this kind. The cubic coupling, an addition of ours,
//! detects odd harmonics. Noise above the harmonics masks both. Any nonlinearity is attributed to the valve.
//! Apparent stiction is a quantity of the loop, not S: a controller that swings the OP further than S has a wider
//! ellipse.
//!
//! # Deviations from the paper
//! Formulas and limits were recalled, not read. The abstract of a later paper of the authors modifies NGI and NLI;
//! these are the earlier ones.
//! * Significance: the recalled limit `chi²/(2K)` at 5 % for each bin lets one in twenty bins of
//!   Gaussian noise pass, so that NGI is then always above 0.001. Here `crit = 1 - (alpha/bins)^(1/(K-1))`,
//!   exact for independent Gaussian segments, and alpha is shared among all bins.
//! * Bins with less than `power floor` of the strongest bin's power are left out: there the window's leakage, not
//!   the signal, has fixed phases.
//! * The cubic coupling, see Limits.
//! * The original filters by Wiener's method around the bicoherence peak, and may fit the ellipse to clustered
//!   points.
//! * An ellipse counts if its residual is at most `most residual` and its width exceeds twice the standard
//!   deviation of the part that the filter removed from the OP.
//!
//! # References
//! Choudhury, Shah, Thornhill, Automatica 40 (2004) 1719-1728; Choudhury, Shah, Thornhill, Shook,
//! Control Eng. Practice 14 (2006) 1395-1412 (neither read). Trispectrum: Collis, White, Hammond, Mech.
//! Syst. Signal Process. 12 (1998) 375-394 (not read).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::ellipse::Ellipse;
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{Transform, band_passed, decimated, std};
use realfft::num_complex::Complex;

/// Number of samples in a segment; recalled.
pub const SEGMENT: usize = 64;
/// Non-Gaussianity index up to which a loop is linear and Gaussian; recalled.
pub const NGI_LIMIT: f64 = 0.001;
/// Nonlinearity index from which a loop is nonlinear; recalled.
pub const NLI_LIMIT: f64 = 0.01;
/// Probability that Gaussian noise has any significant bin; ours.
pub const ALPHA: f64 = 0.01;
/// Share of the strongest bin's power below which a bin is left out; ours.
pub const POWER_FLOOR: f64 = 1e-4;
/// Most averaged segments, evenly spaced; ours.
pub const MOST_SEGMENTS: usize = 256;
/// Residual up to which points lie along an ellipse; ours. Points evenly spread over its inside have 0.34 (closed
/// form, for the ellipse of their covariance).
pub const MOST_RESIDUAL: f64 = 0.3;

/// Fewest samples per period after decimation; ours.
const SAMPLES_PER_PERIOD: f64 = 12.0;
/// Smallest number of segments for significance; ours.
const FEWEST_SEGMENTS: usize = 8;
/// Largest number of samples of the phase plot; ours.
const MOST_POINTS: usize = 4096;

static METHOD: Method = Method {
    name: "bicoherence",
    title: "Bicoherence and ellipse",
    source: "Choudhury, Shah, Thornhill, Automatica 40 (2004) 1719-1728, and Control Eng. Practice 14 \
             (2006) 1395-1412; formulas and limits recalled, not read",
    statistic: "apparent stiction, %",
    rule: "sticks if the loop is nonlinear and an ellipse fits PV and OP with an apparent stiction above the \
           noise, does not stick if the loop is linear. Nonlinear means significant cubic coupling, or NGI above 0.001 and NLI \
           at least 0.01",
    applies: Applies::AnyLoop,
    decides: Decides::Stiction,
    needs: Needs::Error,
    family: Family::HigherOrder,
    explains_oscillation: false,
};

/// The bicoherence of the control error and the ellipse of PV and OP.
#[derive(Debug, Clone, PartialEq)]
pub struct Bicoherence {
    /// Samples in a segment, after decimation.
    pub segment: usize,
    /// NGI up to which the loop is linear and Gaussian.
    pub ngi_limit: f64,
    /// NLI from which the loop is nonlinear.
    pub nli_limit: f64,
    /// Probability that Gaussian noise has any significant bin.
    pub alpha: f64,
    /// Share of the strongest bin's power below which a bin is left out.
    pub power_floor: f64,
    /// Most averaged segments.
    pub most_segments: usize,
    /// Residual up to which points lie along an ellipse.
    pub most_residual: f64,
}

impl Default for Bicoherence {
    fn default() -> Self {
        Self {
            segment: SEGMENT,
            ngi_limit: NGI_LIMIT,
            nli_limit: NLI_LIMIT,
            alpha: ALPHA,
            power_floor: POWER_FLOOR,
            most_segments: MOST_SEGMENTS,
            most_residual: MOST_RESIDUAL,
        }
    }
}

/// A bin of the bicoherence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bin {
    /// Index of the first frequency, in cycles per segment.
    pub i: usize,
    /// Index of the second, not above the first.
    pub j: usize,
    /// Squared bicoherence, from 0 to 1.
    pub value: f64,
}

/// The squared bicoherence of a series and its indices.
#[derive(Debug, Clone, PartialEq)]
pub struct BicoherencePlane {
    /// Samples in a segment; bin `i` is the frequency `i / (segment * factor)` per recorded sample.
    pub segment: usize,
    /// Recorded samples in one of a segment's samples.
    pub factor: usize,
    /// Number of segments.
    pub segments: usize,
    /// All bins with power.
    pub bins: Vec<Bin>,
    /// Squared bicoherence from which a bin is significant.
    pub critical: f64,
    /// The largest bin.
    pub peak: Option<Bin>,
    /// Non-Gaussianity index.
    pub ngi: f64,
    /// Nonlinearity index.
    pub nli: f64,
    /// The largest cubic coupling, of the bin `i` with `3 i`, kept in `i` and `j`.
    pub cubic: Option<Bin>,
    /// Cubic coupling from which it is significant.
    pub cubic_critical: f64,
    /// Whether the series is nonlinear.
    pub nonlinear: bool,
}

/// The result of the method.
#[derive(Debug, Clone, PartialEq)]
pub struct BicoherenceResult {
    /// The bicoherence of the control error.
    pub plane: BicoherencePlane,
    /// OP around its mean, filtered, percent. Empty if the loop is linear.
    pub op: Vec<f64>,
    /// PV around its mean, filtered. Empty if the loop is linear.
    pub pv: Vec<f64>,
    /// The ellipse of PV and OP, if they lie along one.
    pub ellipse: Option<Ellipse>,
    /// Apparent stiction, percent; 0 without an ellipse.
    pub apparent: f64,
    /// Apparent stiction from which it is above noise, percent.
    pub noise: f64,
    /// The decision.
    pub decision: Decision,
    /// Cautions.
    pub caveats: Vec<String>,
}

/// Significance limit of a squared coherence of `k` segments, `tests` of them judged together.
fn critical(alpha: f64, tests: usize, k: usize) -> f64 {
    1.0 - (alpha / tests.max(1) as f64).powf(1.0 / (k as f64 - 1.0))
}

impl Bicoherence {
    /// The bicoherence of a series whose dominant oscillation has a period of `period` samples, if any.
    ///
    /// # Errors
    /// If the series is shorter than eight segments, or cannot be brought to a common scale.
    pub fn plane(&self, x: &[f64], period: Option<f64>) -> Result<BicoherencePlane, Abstention> {
        let segment = self.segment.clamp(16, 1024) & !1;
        let hop = segment / 2;
        // More samples per period are better than too few segments.
        let wanted = period.map_or(1, |p| (p / SAMPLES_PER_PERIOD) as usize);
        let most = x.len() / (hop * (FEWEST_SEGMENTS + 1));
        let factor = wanted.min(most).max(1);
        let x = decimated(x, factor);
        let available = (x.len() / hop).saturating_sub(1);
        if available < FEWEST_SEGMENTS {
            return Err(Abstention(format!(
                "needs at least {} samples; there are {}",
                hop * (FEWEST_SEGMENTS + 1),
                x.len()
            )));
        }
        let scale = std(&x);
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Abstention(
                "the signal does not move, or its values are extreme".to_owned(),
            ));
        }
        let k = available.min(self.most_segments.max(FEWEST_SEGMENTS));
        let half = hop + 1;
        let mut spectra = vec![Complex::default(); k * half];
        let mut transform = Transform::new(segment);
        let window: Vec<f64> = (0..segment)
            .map(|n| 0.5 - 0.5 * (std::f64::consts::TAU * (n as f64 + 0.5) / segment as f64).cos())
            .collect();
        let mut samples = vec![0.0; segment];
        for (s, bins) in spectra.chunks_exact_mut(half).enumerate() {
            // Evenly spaced if there are more than the limit.
            let first = hop * (s * (available - 1) / (k - 1).max(1));
            let piece = &x[first..first + segment];
            let middle = piece.iter().sum::<f64>() / segment as f64;
            for ((v, x), w) in samples.iter_mut().zip(piece).zip(&window) {
                *v = (x - middle) / scale * w;
            }
            transform.forward(&samples, bins);
        }
        // Bin after bin, so that sums run over neighbours in memory.
        let (mut re, mut im) = (vec![0.0; k * half], vec![0.0; k * half]);
        for s in 0..k {
            for i in 0..half {
                let bin = spectra[s * half + i];
                (re[i * k + s], im[i * k + s]) = (bin.re, bin.im);
            }
        }
        let bin = |i: usize| (&re[i * k..(i + 1) * k], &im[i * k..(i + 1) * k]);
        let power: Vec<f64> = (0..half)
            .map(|i| bin(i).0.iter().zip(bin(i).1).map(|(re, im)| re * re + im * im).sum())
            .collect();
        let strongest = power[1..].iter().copied().fold(0.0, f64::max);
        let strong: Vec<bool> = power.iter().map(|p| *p > self.power_floor * strongest).collect();
        let mut bins = vec![];
        for i in 1..half {
            for j in 1..=i.min(half - 1 - i) {
                if strong[i] && strong[j] && strong[i + j] {
                    let value = coherence(bin(i), bin(j), bin(i + j), power[i + j]);
                    bins.push(Bin { i, j, value });
                }
            }
        }
        let limit = critical(self.alpha, bins.len(), k);
        let (mut above, mut significant) = (0.0, 0);
        for bin in bins.iter().filter(|bin| bin.value > limit) {
            above += bin.value - limit;
            significant += 1;
        }
        let ngi = if significant > 0 { above / f64::from(significant) } else { 0.0 };
        let peak = bins.iter().copied().max_by(|a, b| a.value.total_cmp(&b.value));
        let values: Vec<f64> = bins.iter().map(|bin| bin.value).collect();
        let nli = peak.map_or(0.0, |peak| {
            (peak.value - (crate::series::mean(&values) + 2.0 * std(&values))).abs()
        });
        // Below the second bin, the window's lobes around zero, i and 3 i overlap.
        let cubics: Vec<Bin> = (2..half)
            .take_while(|i| 3 * i < half)
            .filter(|i| strong[*i] && strong[3 * i])
            .map(|i| Bin { i, j: 3 * i, value: cubic_coherence(bin(i), bin(3 * i), power[3 * i]) })
            .collect();
        let cubic_critical = critical(self.alpha, cubics.len(), k);
        let cubic = cubics.into_iter().max_by(|a, b| a.value.total_cmp(&b.value));
        let nonlinear = ngi > self.ngi_limit && nli >= self.nli_limit
            || cubic.is_some_and(|cubic| cubic.value > cubic_critical);
        Ok(BicoherencePlane {
            segment,
            factor,
            segments: k,
            bins,
            critical: limit,
            peak,
            ngi,
            nli,
            cubic,
            cubic_critical,
            nonlinear,
        })
    }

    /// Runs the method.
    ///
    /// # Errors
    /// If the method does not apply or the segment is too short.
    pub fn run(&self, subject: &Subject<'_>) -> Result<BicoherenceResult, Abstention> {
        let caveats = subject.check(&METHOD)?;
        let (Some(error), Some(pv)) = (subject.error(), &subject.segment.pv) else {
            return Err(Abstention("needs the PV, which is not recorded".to_owned()));
        };
        let plane = self.plane(&error.values, subject.period)?;
        let mut result = BicoherenceResult {
            decision: if plane.nonlinear { Decision::Undecided } else { Decision::DoesNotStick },
            plane,
            op: vec![],
            pv: vec![],
            ellipse: None,
            apparent: 0.0,
            noise: 0.0,
            caveats,
        };
        if !result.plane.nonlinear {
            return Ok(result);
        }
        let frequency = match subject.period {
            Some(period) => 1.0 / period,
            None => result.plane.fundamental(),
        };
        // The middle of a long segment.
        let middle = |x: &[f64]| -> Vec<f64> {
            let n = x.len().min(MOST_POINTS);
            let first = (x.len() - n) / 2;
            x[first..first + n].to_vec()
        };
        let (op, pv) = (middle(&subject.segment.op), middle(pv));
        let filtered = |x: &[f64]| band_passed(x, 0.5 * frequency, 3.5 * frequency);
        (result.op, result.pv) = (filtered(&op), filtered(&pv));
        let rest: Vec<f64> = op.iter().zip(&result.op).map(|(x, f)| x - f).collect();
        // Slow drifts are not noise.
        result.noise = 2.0 * std(&band_passed(&rest, 0.5 * frequency, 0.5));
        result.ellipse = Ellipse::fit(&result.op, &result.pv)
            .filter(|ellipse| ellipse.residual <= self.most_residual);
        result.apparent = result.ellipse.map_or(0.0, |ellipse| ellipse.op_width());
        if result.apparent > result.noise {
            result.decision = Decision::Sticks;
        }
        Ok(result)
    }
}

impl BicoherencePlane {
    /// Whether the decision rests on the bicoherence (else, if nonlinear, on cubic coupling).
    fn by_bicoherence(&self, limits: &Bicoherence) -> bool {
        self.ngi > limits.ngi_limit && self.nli >= limits.nli_limit
    }

    /// The lowest frequency of the significant couplings, cycles per recorded sample.
    fn fundamental(&self) -> f64 {
        let quadratic = self.peak.filter(|peak| peak.value > self.critical).map(|peak| peak.j);
        let bin = quadratic.or(self.cubic.map(|cubic| cubic.i)).unwrap_or(1);
        bin as f64 / (self.segment * self.factor) as f64
    }

    /// The result, a clause.
    pub(super) fn says(&self, limits: &Bicoherence) -> String {
        let indices = format!("NGI = {:.4}, NLI = {:.3}", self.ngi, self.nli);
        match (self.nonlinear, self.cubic) {
            (true, Some(cubic)) if !self.by_bicoherence(limits) => format!(
                "the loop is nonlinear by cubic coupling, {:.2} above {:.2} ({indices})",
                cubic.value, self.cubic_critical
            ),
            (true, _) => format!(
                "the loop is nonlinear, {indices} (limits {} and {})",
                limits.ngi_limit, limits.nli_limit
            ),
            (false, _) => format!(
                "the loop is linear, {indices} (limits {} and {}), without cubic coupling",
                limits.ngi_limit, limits.nli_limit
            ),
        }
    }

    pub(super) fn numbers(&self) -> Vec<Number> {
        let mut numbers = vec![
            Number::new("NGI", self.ngi, ""),
            Number::new("NLI", self.nli, ""),
            Number::new("segments", self.segments as f64, ""),
            Number::new("significant from", self.critical, ""),
        ];
        numbers.extend(self.peak.map(|peak| Number::new("largest bicoherence", peak.value, "")));
        numbers.extend(self.cubic.map(|cubic| Number::new("cubic coupling", cubic.value, "")));
        numbers.push(Number::new("cubic coupling significant from", self.cubic_critical, ""));
        numbers
    }
}

/// `|sum a b c*|² / (sum |a b|² sum |c|²)`.
fn coherence(a: (&[f64], &[f64]), b: (&[f64], &[f64]), c: (&[f64], &[f64]), power: f64) -> f64 {
    let (mut re, mut im, mut products) = (0.0, 0.0, 0.0);
    let first = a.0.iter().zip(a.1).zip(b.0.iter().zip(b.1));
    for (((ar, ai), (br, bi)), (cr, ci)) in first.zip(c.0.iter().zip(c.1)) {
        let (pr, pi) = (ar * br - ai * bi, ar * bi + ai * br);
        re += pr * cr + pi * ci;
        im += pi * cr - pr * ci;
        products += pr * pr + pi * pi;
    }
    squared_coherence(re, im, products, power)
}

/// `|sum a³ c*|² / (sum |a³|² sum |c|²)`.
fn cubic_coherence(a: (&[f64], &[f64]), c: (&[f64], &[f64]), power: f64) -> f64 {
    let (mut sum, mut products) = (Complex::new(0.0, 0.0), 0.0);
    for ((ar, ai), (cr, ci)) in a.0.iter().zip(a.1).zip(c.0.iter().zip(c.1)) {
        let cube = Complex::new(*ar, *ai).powu(3);
        sum += cube * Complex::new(*cr, -ci);
        products += cube.norm_sqr();
    }
    squared_coherence(sum.re, sum.im, products, power)
}

fn squared_coherence(re: f64, im: f64, products: f64, power: f64) -> f64 {
    let value = (re * re + im * im) / (products * power);
    if value.is_finite() { value.min(1.0) } else { 0.0 }
}

pub(super) fn parameters(p: &Bicoherence) -> Vec<Number> {
    vec![
        Number::new("segment", p.segment as f64, "samples"),
        Number::new("NGI limit", p.ngi_limit, ""),
        Number::new("NLI limit", p.nli_limit, ""),
        Number::new("alpha", p.alpha, ""),
        Number::new("power floor", p.power_floor, ""),
        Number::new("most segments", p.most_segments as f64, ""),
        Number::new("most residual", p.most_residual, ""),
    ]
}

impl Detector for Bicoherence {
    fn method(&self) -> &'static Method {
        &METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        parameters(self)
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let result = self.run(subject)?;
        let says = result.plane.says(self);
        let reason = match (result.decision, result.ellipse) {
            (Decision::Sticks, _) => format!(
                "{says}; PV and OP move along an ellipse {:.3} % wide, the apparent stiction",
                result.apparent
            ),
            (Decision::DoesNotStick, _) => says,
            (_, Some(_)) => format!(
                "{says}; the apparent stiction, {:.3} %, is within the noise of {:.3} %",
                result.apparent, result.noise
            ),
            (_, None) => format!("{says}; PV and OP do not move along an ellipse"),
        };
        let mut numbers = result.plane.numbers();
        numbers.push(Number::new("apparent stiction", result.apparent, "%"));
        numbers.push(Number::new("noise", result.noise, "%"));
        numbers.extend(result.ellipse.map(|e| Number::new("ellipse residual", e.residual, "")));
        let finding =
            Finding::new(&METHOD, result.decision, result.apparent, result.noise, reason, numbers);
        let caveats = result.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(result)), ..finding })
    }
}
