//! A stem with friction fitted to a recorded valve position.
//!
//! # What it measures
//! From OP and recorded valve position (VP): static and Coulomb friction of the stem, and its time constant. Also
//! the corresponding S and J, and whether this explains VP better than the data-driven models of
//! [`super::position`], which move at once.
//!
//! OP and VP are sampled together, and each OP is held until the next sample. Friction is the law of [`Classical`] with
//! static friction at rest only. The stem is so light that it neither rings nor overshoots: its damping ratio is
//! [`DAMPING_RATIO`]. The valve does not change within the recording.
//!
//! # Equations
//! ```text
//! T x' = u - x - fc sgn x'              moving       fc = Fc/k, T = Fv/k
//! x' = 0 while |u - x| <= fs            at rest      fs = Fs/k
//! VP(k) = g x(k - 1) + o + e(k)
//! S = fs + fc,   J = fs - fc            (stem/equivalent.rs)
//! explained = 1 - sum e^2 / sum (VP - mean VP)^2
//! information = m ln(mean e^2) + 3 ln m  over m samples (Schwarz)
//! ```
//! x(k) is the position after OP(k) has been held for its sample time, as in [`StemValve`]. The mass is left out above;
//! [`StemValve`] includes it. Least squares gives gain g and offset o. fs, fc and ln T are found within bounds by the
//! simplex of Nelder and Mead, from the best of sixty starts around the fs of the best data-driven model, five times
//! with different simplexes.
//!
//! Least squares of all five numbers, with differences of x for derivatives, gives the standard deviations; errors with
//! correlation r from sample to sample count as `(1 - r)/(1 + r)` samples each.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `sample_time_s` | s | none | the recording |
//!
//! Constants: [`MOST_SAMPLES`], [`FEWEST_SLIPS`], [`DAMPING_RATIO`], [`UNSURE`]; ours.
//!
//! # Limits
//! The mass is not identified, nor is a Stribeck velocity: a stem that overshoots or moves in steps under a slow ramp
//! is fitted badly, and He's model should then explain it better. A lag much shorter than the sample time cannot be
//! distinguished from zero, nor a lag on slow ramps from Coulomb friction. A delay counts as lag. A slip is located to
//! a sample at best, so the uncertainty of the bands is at least the OP travel in a sample. Air lag and positioner
//! count as lag or delay. J is at most S. Of a longer recording only the first [`MOST_SAMPLES`] are fitted. The
//! standard deviations describe the best fit and ignore other minima.
//!
//! Force balance: M. A. A. S. Choudhury, N. F. Thornhill, S. L. Shah, Modelling valve stiction, Control Engineering
//! Practice 13 (2005) 641-658 (recalled, not read). Friction from stem position: R. A. Romano and C. Garcia, IFAC
//! DYCOPS 2007 (abstract read). The map to S and J is ours.

use super::position::{self, Line, PositionFit, Record, Sums};
use super::slips::Motion;
use crate::Bands;
use crate::error::{Result, positive};
use crate::finding::Abstention;
use crate::numeric::nelder_mead::{Minimum, minimise};
use crate::parallel::*;
use crate::series::{autocorrelation, span};
use crate::stem::friction::Classical;
use crate::stem::{FrictionLaw, Stem, StemParameters, StemValve};
use crate::valve::{Start, Valve};
use nalgebra::{SMatrix, SVector};

/// Number of samples above which only the beginning is fitted.
pub const MOST_SAMPLES: usize = 2_000;
/// Smallest number of slips against the last direction of motion for a fit.
pub const FEWEST_SLIPS: usize = 3;
/// Damping ratio `Fv / (2 sqrt(k M))`: the stem's second time constant is a hundredth of the first.
pub const DAMPING_RATIO: f64 = 5.0;
/// Standard deviation over value above which a number is not identified.
pub const UNSURE: f64 = 0.5;
/// Number of parameters of the stem, and of all fitted numbers.
const PARAMETERS: usize = 3;
const FITTED: usize = PARAMETERS + 2;
/// Starting lags of the search, samples.
const LAGS: [f64; 5] = [0.1, 1.0, 2.5, 5.0, 10.0];
/// Starting fc over fs.
const RATIOS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// Shortest lag, samples, and longest, share of the recording.
const SHORTEST: f64 = 0.02;
const LONGEST: f64 = 0.1;
/// Starting fs, as shares of the data-driven model's fs; its smallest value, span of OP.
const ABOUT: [f64; 3] = [0.8, 1.0, 1.2];
const LEAST: f64 = 0.005;
/// Simplex along fs and along fc, both as a share of fs, and along ln T.
const SIZE: [f64; PARAMETERS] = [0.15, -0.15, 0.5];
/// Sizes of successive simplexes, shares of `SIZE`.
const SIMPLEXES: [f64; 5] = [1.0, -0.7, 1.0, -0.5, 0.3];
/// Samples between the end of an OP's hold interval and its VP.
const DELAY: usize = 1;
/// Slips occur at samples, so the errors have steps along fs, at which a simplex stops. Before each search, this many
/// values of fs are tried, between these shares of fs.
const SCAN: [f64; 2] = [0.7, 1.4];
const SCANNED: usize = 15;
/// Simplex at the end of a search, share of the first; tries in each search.
const TOLERANCE: f64 = 1e-3;
const EVALUATIONS: usize = 50;
/// Half the difference for a derivative, share of the value.
const DIFFERENCE: f64 = 0.03;

/// A fitted number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StemEstimate {
    /// The number.
    pub value: f64,
    /// Standard deviation; `None` if the recording does not depend on it.
    pub deviation: Option<f64>,
}

impl StemEstimate {
    /// Whether the standard deviation is at most [`UNSURE`] of the value.
    pub fn identified(&self) -> bool {
        self.deviation.is_some_and(|deviation| deviation <= UNSURE * self.value)
    }
}

/// A stem fitted to a recorded position.
#[derive(Debug, Clone, PartialEq)]
pub struct PhysicalFit {
    /// Static friction over spring constant `Fs/k`, percent of span of the OP.
    pub static_band: StemEstimate,
    /// Coulomb friction over spring constant `Fc/k`, percent of span of the OP.
    pub coulomb_band: StemEstimate,
    /// Viscous friction over spring constant `Fv/k`, s.
    pub lag_s: StemEstimate,
    /// The corresponding S and J, percent of span of the OP.
    pub bands: Bands,
    /// Percent of VP per percent of the stem's position.
    pub gain: f64,
    /// VP where the stem's position is 0, percent.
    pub offset: f64,
    /// Root mean square error, percent of VP.
    pub rmse: f64,
    /// Share of the variance of VP that is explained.
    pub explained: f64,
    /// Schwarz's information; only differences are meaningful.
    pub information: f64,
    /// Number of slips against the last direction.
    pub slips: usize,
    /// VP of the stem model, percent.
    pub vp: Vec<f64>,
    /// The best data-driven model on the same samples.
    pub data_driven: PositionFit,
    /// Numbers that are not identified, and why, a sentence each.
    pub unidentified: Vec<String>,
}

impl PhysicalFit {
    /// Whether Schwarz's information prefers the stem to the best data-driven model.
    pub fn explains_better(&self) -> bool {
        self.information < self.data_driven.information
    }

    /// The fitted stem, on a spring of 1 N/m, with a stroke of 1 m for 1 Pa on 1 m2.
    ///
    /// # Errors
    /// If a number was changed to an impossible value.
    pub fn stem(&self) -> Result<Stem> {
        stem(self.static_band.value, self.coulomb_band.value, self.lag_s.value)
    }
}

/// Fits a stem to a recorded position; OP and VP in percent of span, `sample_time_s` in s.
///
/// ```
/// use stiction_diagnose::identify::physical;
/// use stiction_model::valve::{Start, Valve};
/// use stiction_model::stem::{FrictionLaw, Stem, StemParameters, StemValve, friction::Classical};
/// let usp = *Stem::named("usp")?.parameters();
/// // Force of a percent of the OP; static and Coulomb bands of 4 and 2 %, Fv/k = 1.5 s.
/// let percent_n = usp.area_m2 * (usp.pressure_max_pa - usp.pressure_min_pa) / 100.0;
/// let law = Classical::new(4.0 * percent_n, 2.0 * percent_n, 1.5 * usp.spring_n_per_m, 0.0)?;
/// let free = StemParameters { end_stops: false, ..usp };
/// let mut valve = StemValve::new(Stem::new(free, FrictionLaw::Classical(law))?, 0.5)?;
/// let wave = |k: f64| 50.0 + 9.0 * (0.045 * k).sin() + 5.0 * (0.0173 * k).sin();
/// let op: Vec<f64> = (0..1500).map(|k| wave(k as f64)).collect();
/// valve.restart(Start { op: op[0], ..Start::at_rest(45.0) });
/// let mut vp = vec![valve.position()];
/// vp.extend(op[..1499].iter().map(|u| valve.step(*u)));
/// let fit = physical::fit(&op, &vp, 0.5).expect("it moves");
/// assert!((fit.static_band.value - 4.0).abs() < 0.4);
/// assert!((fit.coulomb_band.value - 2.0).abs() < 0.2);
/// assert!((fit.lag_s.value - 1.5).abs() < 0.15);
/// assert!(fit.explains_better());
/// # Ok::<(), stiction_model::Error>(())
/// ```
///
/// # Errors
/// As [`position::fit`]; if the sample time is not above 0; or if the fitted stem slips back fewer than
/// [`FEWEST_SLIPS`] times, because friction then cannot be separated from gain and offset.
pub fn fit(
    op: &[f64],
    vp: &[f64],
    sample_time_s: f64,
) -> std::result::Result<PhysicalFit, Abstention> {
    positive("sample time", sample_time_s).map_err(|e| Abstention(e.to_string()))?;
    let first = |x: &[f64]| x.len().min(MOST_SAMPLES);
    let (op, vp) = (&op[..first(op)], &vp[..first(vp)]);
    let data_driven = position::fit(op, vp)?.ranked.swap_remove(0);
    let trial = Trial::new(op, vp, sample_time_s, &data_driven);
    let Some(best) = trial.search(&data_driven) else { return Err(no_stem()) };
    let Some((x, line)) = trial.response(&best) else { return Err(no_stem()) };
    let slips = Motion::of(&x).reversals.len();
    if slips < FEWEST_SLIPS {
        return Err(Abstention(format!(
            "a stem fit needs at least {FEWEST_SLIPS} reversals of the valve; there are {slips}. Use a longer \
             recording, or a recording with larger movements of the OP"
        )));
    }
    let [fs, fc, lag_s] = trial.estimates(&best, &x, &line);
    let stem = stem(fs.value, fc.value, lag_s.value).and_then(|stem| stem.equivalent());
    let Ok(equivalent) = stem else { return Err(no_stem()) };
    Ok(PhysicalFit {
        static_band: fs,
        coulomb_band: fc,
        lag_s,
        bands: equivalent.signal_bands,
        gain: line.gain,
        offset: line.offset,
        rmse: trial.record.rmse(&line),
        explained: 1.0 - line.left,
        information: trial.record.information(&line, PARAMETERS),
        slips,
        vp: line.vp(&x),
        data_driven,
        unidentified: unidentified(&fs, &fc, &lag_s, sample_time_s),
    })
}

fn no_stem() -> Abstention {
    Abstention("no stem can be fitted to the valve position".to_owned())
}

/// Why a number is not identified.
fn unidentified(
    fs: &StemEstimate,
    fc: &StemEstimate,
    lag_s: &StemEstimate,
    sample_time_s: f64,
) -> Vec<String> {
    let mut reasons = vec![];
    if !fs.identified() {
        reasons.push(
            "the static band cannot be distinguished from zero: the valve sticks too little to show above the noise"
                .to_owned(),
        );
    } else if !fc.identified() {
        reasons.push(
            "the Coulomb band cannot be distinguished from zero or from the lag: the stem slides too little \
             between its slips"
                .to_owned(),
        );
    }
    if !lag_s.identified() {
        reasons.push(format!(
            "the lag of the stem cannot be distinguished from zero with a sample time of {sample_time_s} s"
        ));
    }
    reasons
}

/// A stem with these bands in percent and this lag, on a spring of 1 N/m and so on.
fn stem(fs: f64, fc: f64, lag_s: f64) -> Result<Stem> {
    let parameters = StemParameters {
        mass_kg: (lag_s / (2.0 * DAMPING_RATIO)).powi(2),
        spring_n_per_m: 1.0,
        area_m2: 1.0,
        preload_n: 0.0,
        stroke_m: 1.0,
        pressure_min_pa: 0.0,
        pressure_max_pa: 1.0,
        air_lag_s: 0.0,
        end_stops: false,
    };
    let friction = Classical::new(fs / 100.0, fc / 100.0, lag_s, 0.0)?;
    Stem::new(parameters, FrictionLaw::Classical(friction))
}

/// A recording for trying stems: fs in percent, fc (at most fs), ln of the lag in samples.
struct Trial<'a> {
    op: &'a [f64],
    vp: &'a [f64],
    record: Record<'a>,
    sample_time_s: f64,
    start: Start,
    bounds: [(f64, f64); PARAMETERS],
}

impl<'a> Trial<'a> {
    fn new(op: &'a [f64], vp: &'a [f64], sample_time_s: f64, known: &PositionFit) -> Self {
        let position =
            if known.gain == 0.0 { op[0] } else { (vp[known.delay] - known.offset) / known.gain };
        let start = Start { op: op[0], ..Start::at_rest(position) };
        let lags = (SHORTEST.ln(), (LONGEST * op.len() as f64).ln());
        let bounds = [(0.0, span(op)), (0.0, span(op)), lags];
        Self { op, vp, record: Record::of(op, vp), sample_time_s, start, bounds }
    }

    /// fs and fc in percent and the lag in s of a trial.
    fn physical(&self, &[fs, fc, ln_lag]: &[f64; PARAMETERS]) -> [f64; PARAMETERS] {
        [fs, fc.min(fs), ln_lag.exp() * self.sample_time_s]
    }

    /// Positions of a stem, percent; `None` if it cannot be stepped.
    fn positions(&self, [fs, fc, lag_s]: [f64; PARAMETERS]) -> Option<Vec<f64>> {
        let mut valve = StemValve::new(stem(fs, fc, lag_s).ok()?, self.sample_time_s).ok()?;
        valve.restart(self.start);
        let mut x = vec![0.0; self.op.len()];
        valve.run(self.op, &mut x).ok()?;
        x.iter().all(|x| x.is_finite()).then_some(x)
    }

    /// The positions of a trial, and the best line through them and VP.
    fn response(&self, tried: &[f64; PARAMETERS]) -> Option<(Vec<f64>, Line)> {
        let x = self.positions(self.physical(tried))?;
        let mut sums = Sums::default();
        for (k, x) in x.iter().enumerate() {
            self.record.gather(&mut sums, k, *x);
        }
        Some((x, self.record.lines(&sums)[DELAY]))
    }

    /// Unexplained share of the variance of VP; infinite for an impossible stem.
    fn left(&self, tried: &[f64; PARAMETERS]) -> f64 {
        self.response(tried).map_or(f64::INFINITY, |(_, line)| line.left)
    }

    /// The best result of the search.
    fn search(&self, known: &PositionFit) -> Option<[f64; PARAMETERS]> {
        let fs = known.bands.fs().max(LEAST * span(self.op));
        let about =
            |ratio: f64, lag: f64| ABOUT.map(|share| [share * fs, ratio * share * fs, lag.ln()]);
        let starts: Vec<[f64; PARAMETERS]> =
            RATIOS.iter().flat_map(|r| LAGS.iter().flat_map(|lag| about(*r, *lag))).collect();
        let left: Vec<f64> = starts.par_iter().map(|start| self.left(start)).collect();
        let lesser = |a: Minimum<PARAMETERS>, b: Minimum<PARAMETERS>| {
            if b.value < a.value { b } else { a }
        };
        let search = |from: Minimum<PARAMETERS>| {
            let f = |tried: &[f64; PARAMETERS]| self.left(tried);
            SIMPLEXES.iter().fold(from, |from, share| {
                let scanned = position::spaced(SCANNED, SCAN[0], SCAN[1]).into_iter().map(|by| {
                    let at = [by * from.at[0], from.at[1], from.at[2]];
                    Minimum { at, value: f(&at) }
                });
                let from = scanned.fold(from, lesser);
                let size = [fs * SIZE[0], fs * SIZE[1], SIZE[2]].map(|size| size * share);
                minimise(f, from.at, size, self.bounds, TOLERANCE, EVALUATIONS)
            })
        };
        let tried = starts.iter().zip(&left).map(|(at, left)| Minimum { at: *at, value: *left });
        Some(search(tried.reduce(lesser)?).at)
    }

    /// fs, fc and lag with the standard deviations of least squares.
    fn estimates(
        &self,
        best: &[f64; PARAMETERS],
        x: &[f64],
        line: &Line,
    ) -> [StemEstimate; PARAMETERS] {
        let values = self.physical(best);
        let [fs, fc, lag_s] = values;
        let within = [(fc, f64::INFINITY), (0.0, fs), (0.0, f64::INFINITY)];
        // A slip moves from sample to sample only if a band changes by the OP travel in between.
        let moved: f64 = self.op.windows(2).map(|w| (w[1] - w[0]).abs()).sum();
        let least = moved / self.op.len() as f64;
        let steps =
            [(DIFFERENCE * fs).max(least), (DIFFERENCE * fc).max(least), DIFFERENCE * lag_s];
        let derivative = |i: usize| -> Option<Vec<f64>> {
            let [low, high] = [-steps[i], steps[i]].map(|step| {
                let mut changed = values;
                changed[i] = (values[i] + step).max(within[i].0).min(within[i].1);
                changed
            });
            let width = high[i] - low[i];
            let (low, high) = (self.positions(low)?, self.positions(high)?);
            let slopes = low.iter().zip(&high).map(|(a, b)| line.gain * (b - a) / width);
            (width > 0.0).then(|| slopes.collect())
        };
        let columns: [Vec<f64>; PARAMETERS] =
            std::array::from_fn(|i| derivative(i).unwrap_or_else(|| vec![0.0; x.len()]));
        let m = self.record.compared;
        let middle = x[..m].iter().sum::<f64>() / m as f64;
        let mut normal = SMatrix::<f64, FITTED, FITTED>::zeros();
        for k in 0..m {
            let row = [columns[0][k], columns[1][k], columns[2][k], x[k] - middle, 1.0];
            let row = SVector::from(row);
            normal += row * row.transpose();
        }
        // Scaled to unit length; a number without an effect is left out.
        let length = normal.diagonal().map(f64::sqrt);
        let unit = SMatrix::<f64, FITTED, FITTED>::from_fn(|i, j| match length[i] * length[j] {
            product if product > 0.0 => normal[(i, j)] / product,
            _ if i == j => 1.0,
            _ => 0.0,
        });
        let inverse = nalgebra::Cholesky::new(unit).map(|c| c.inverse());
        let variance = self.error_variance(x, line);
        std::array::from_fn(|i| {
            let deviation = inverse.map(|c| (variance * c[(i, i)]).sqrt() / length[i]);
            StemEstimate { value: values[i], deviation: deviation.filter(|d| d.is_finite()) }
        })
    }

    /// Variance of the errors, raised for their correlation.
    fn error_variance(&self, x: &[f64], line: &Line) -> f64 {
        let m = self.record.compared;
        let errors: Vec<f64> =
            (0..m).map(|k| self.vp[k + line.delay] - line.gain * x[k] - line.offset).collect();
        let r = autocorrelation(&errors, 1).map_or(0.0, |r| r[1].clamp(0.0, 0.99));
        let squares: f64 = errors.iter().map(|e| e * e).sum();
        squares / (m - FITTED) as f64 * (1.0 + r) / (1.0 - r)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;

    /// An OP that swings by up to 28 %, unevenly.
    fn op(n: usize) -> Vec<f64> {
        let wave = |k: f64| 50.0 + 9.0 * (0.045 * k).sin() + 5.0 * (0.0173 * k).sin();
        (0..n).map(|k| wave(k as f64)).collect()
    }

    /// What a valve of other size, mass and preload does, one sample after the OP.
    fn recorded(op: &[f64], [fs, fc, lag_s]: [f64; 3], sample_time_s: f64) -> Vec<f64> {
        let usp = *Stem::named("usp").unwrap().parameters();
        let signal_n = usp.area_m2 * (usp.pressure_max_pa - usp.pressure_min_pa) / 100.0;
        let viscous = lag_s * usp.spring_n_per_m;
        let law = Classical::new(fs * signal_n, fc * signal_n, viscous, 0.0).unwrap();
        let free = StemParameters { end_stops: false, ..usp };
        let stem = Stem::new(free, FrictionLaw::Classical(law)).unwrap();
        let mut valve = StemValve::new(stem, sample_time_s).unwrap();
        valve.restart(Start { op: op[0], ..Start::at_rest(45.0) });
        let mut vp = vec![valve.position()];
        vp.extend(op[..op.len() - 1].iter().map(|u| valve.step(*u)));
        vp
    }

    const VALVES: [[f64; 3]; 4] =
        [[4.0, 2.0, 1.5], [2.0, 1.5, 0.5], [3.0, 0.8, 2.5], [5.0, 4.5, 1.0]];

    fn close(fit: &PhysicalFit, known: [f64; 3], share: f64) {
        let found = [fit.static_band, fit.coulomb_band, fit.lag_s];
        for (found, known) in found.iter().zip(known) {
            assert!((found.value - known).abs() <= share * known, "{known}: {found:?}");
            assert!(found.identified(), "{known}: {found:?}");
        }
        assert!(fit.unidentified.is_empty(), "{:?}", fit.unidentified);
        let (s, j) = (found[0].value + found[1].value, found[0].value - found[1].value);
        assert!((fit.bands.s() - s).abs() < 1e-9 && (fit.bands.j() - j).abs() < 1e-9);
    }

    #[test]
    fn a_stem_is_recovered_from_what_it_does() {
        let op = op(1500);
        let fits = VALVES.map(|known| fit(&op, &recorded(&op, known, 0.5), 0.5).unwrap());
        for (fit, known) in fits.iter().zip(VALVES) {
            close(fit, known, 0.1);
            assert!(fit.explained > 0.999 && fit.explains_better(), "{}", fit.explained);
        }
    }

    #[test]
    fn noise_is_seen_through() {
        let op = op(1500);
        let mut noise = NormalStream::new(1);
        let fits = VALVES.map(|known| {
            let vp = recorded(&op, known, 0.5);
            let vp: Vec<f64> = vp.iter().map(|v| v + 0.1 * noise.draw()).collect();
            fit(&op, &vp, 0.5).unwrap()
        });
        for (fit, known) in fits.iter().zip(VALVES) {
            close(fit, known, 0.2);
            // Of many slips a few are a sample off, which adds to the noise.
            assert!(fit.rmse < 0.2, "{}", fit.rmse);
            assert!(fit.explains_better());
        }
    }

    #[test]
    fn a_healthy_valve_has_no_bands() {
        let op = op(1500);
        let mut noise = NormalStream::new(7);
        let seen = |k: usize| op[k.saturating_sub(1)] + 0.1 * noise.draw();
        let vp: Vec<f64> = (0..op.len()).map(seen).collect();
        let fit = fit(&op, &vp, 1.0).unwrap();
        assert!(fit.static_band.value < 0.2 && fit.bands.s() < 0.4, "{:?}", fit.static_band);
        assert!(!fit.explains_better());
        assert!(!fit.unidentified.is_empty());
    }

    #[test]
    fn a_valve_without_lag_is_left_to_the_data_driven_models() {
        let op = op(1500);
        let mut valve =
            crate::valve::Model::TwoPhase.build(Bands::from_s_j(5.0, 2.0).unwrap()).unwrap();
        valve.restart(Start::at_rest(50.0));
        let mut noise = NormalStream::new(8);
        let mut vp = vec![50.0];
        vp.extend(op[..op.len() - 1].iter().map(|u| valve.step(*u) + 0.1 * noise.draw()));
        let fit = fit(&op, &vp, 1.0).unwrap();
        assert!((fit.bands.s() - 5.0).abs() < 0.5, "{:?}", fit.bands);
        assert!((fit.bands.j() - 2.0).abs() < 0.4, "{:?}", fit.bands);
        let by = fit.information - fit.data_driven.information;
        assert!(!fit.explains_better(), "{by} {:?}", fit.lag_s);
        assert!(fit.lag_s.value < 0.5 && fit.static_band.identified());
    }

    #[test]
    fn only_units_follow_units() {
        let op = op(800);
        let vp = recorded(&op, VALVES[0], 0.5);
        let once = fit(&op, &vp, 0.5).unwrap();
        assert_eq!(once, fit(&op, &vp, 0.5).unwrap());
        let slow = fit(&op, &vp, 30.0).unwrap();
        assert!((slow.lag_s.value / once.lag_s.value - 60.0).abs() < 1e-3);
        assert!((slow.static_band.value - once.static_band.value).abs() < 1e-3);
        let mirror: Vec<f64> = vp.iter().map(|v| 30.0 - 0.5 * v).collect();
        let mirrored = fit(&op, &mirror, 0.5).unwrap();
        assert!((mirrored.gain + 0.5 * once.gain).abs() < 1e-3);
        assert!((mirrored.static_band.value - once.static_band.value).abs() < 1e-2);
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let op = op(400);
        assert!(fit(&op, &op[..399], 1.0).is_err());
        assert!(fit(&op[..20], &op[..20], 1.0).is_err());
        assert!(fit(&op, &[5.0; 400], 1.0).is_err());
        assert!(fit(&[5.0; 400], &op, 1.0).is_err());
        assert!(fit(&op, &[f64::NAN; 400], 1.0).is_err());
        for sample_time_s in [0.0, -1.0, f64::NAN] {
            assert!(fit(&op, &op, sample_time_s).is_err());
        }
        let ramp: Vec<f64> = (0..400).map(|k| 0.1 * f64::from(k)).collect();
        let why = fit(&ramp, &ramp, 1.0).unwrap_err();
        assert!(why.0.contains("reversals"), "{why:?}");
    }
}
