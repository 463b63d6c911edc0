//! Spectra of all loops in pieces of six to twelve periods, so that each period has pieces of suitable length.
//!
//! A level takes pieces of `L` values, where `L` is a power of two. The pieces overlap by half, have a Hann window, and
//! keep the bins 6 to 11. The levels side by side are bands an eighth of their frequency wide, from
//! [`SHORTEST_S`](crate::store::trace::SHORTEST_S) on.

use crate::store::trace::{STEP_S, Trace, TraceSignal};
use realfft::num_complex::Complex;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use stiction_diagnose::series::{Transform, median};

/// Number of periods in a piece, of the first bin that is kept; as many bins are kept.
const BINS: usize = 6;
/// Number of values of the shortest and of the longest piece, as powers of two.
const LEVELS: (u32, u32) = (5, 13);
/// Bands in all, the slowest first.
pub const BANDS: usize = BINS * (LEVELS.1 - LEVELS.0 + 1) as usize;
/// A piece counts if at least this share of it is known.
const KNOWN: f64 = 0.9;
/// The strength of a piece is limited to this many medians, because one upset of all loops is no swing.
const STRONGEST: f64 = 2.0;
/// The fewest pieces of a band.
pub const FEWEST: usize = 12;
/// A band is a peak if its power is this many times the median of the bands within an octave.
const PEAK: f64 = 4.0;
/// The most peaks of a loop.
const PEAKS: usize = 3;

/// Values of a piece of a band's level, and the bin of the band.
fn level(band: usize) -> (usize, usize) {
    (1 << (LEVELS.1 as usize - band / BINS), BINS + band % BINS)
}

/// The frequency in the middle of a band, Hz.
pub fn frequency(band: usize) -> f64 {
    let (length, bin) = level(band);
    bin as f64 / (length as f64 * STEP_S as f64)
}

/// The band that holds a frequency, Hz, if one does.
pub fn band_of(hz: f64) -> Option<usize> {
    let nearest = |a: &usize, b: &usize| {
        let away = |band: usize| (frequency(band) / hz).ln().abs();
        away(*a).total_cmp(&away(*b))
    };
    (0..BANDS).min_by(nearest).filter(|band| (frequency(*band) / hz).ln().abs() < 0.12)
}

/// A loop's signal over the week, on the clock of all.
pub struct Series {
    pub name: String,
    values: Vec<f32>,
}

/// The pieces of a loop in one band.
#[derive(Debug, Clone)]
pub struct Pieces {
    /// One value per piece; zero where the value is unknown.
    pub values: Vec<Complex<f32>>,
    /// The memory of the band: how well the phases of pieces at a distance agree, from distance 1; see [`memory`].
    pub memory: Vec<f32>,
}

/// The series of each loop over a span, by name. A trace that begins before the span is left out. If the traces of a loop are of
/// two signals, the more frequent one is used.
pub fn series<'a>(traces: impl IntoIterator<Item = &'a Trace>, span: &Range<i64>) -> Vec<Series> {
    let cells = ((span.end - span.start) / STEP_S).max(0) as usize;
    let mut loops: BTreeMap<&str, Vec<&Trace>> = BTreeMap::new();
    traces.into_iter().for_each(|trace| loops.entry(&trace.name).or_default().push(trace));
    let one = |(name, own): (&str, Vec<&Trace>)| {
        let of = |signal: TraceSignal| own.iter().filter(|t| t.signal == signal).count();
        let errors = of(TraceSignal::Error) >= of(TraceSignal::Op);
        let signal = if errors { TraceSignal::Error } else { TraceSignal::Op };
        let mut values = vec![f32::NAN; cells];
        for trace in own.iter().filter(|trace| trace.signal == signal) {
            let at = usize::try_from((trace.start - span.start) / STEP_S).ok();
            let Some(cells) = at.and_then(|at| values.get_mut(at..)) else { continue };
            cells.iter_mut().zip(trace.values()).for_each(|(cell, v)| *cell = v as f32);
        }
        Series { name: name.to_owned(), values }
    };
    loops.into_iter().map(one).collect()
}

impl Series {
    /// The transforms of all pieces of a length. Unknown values are zero.
    fn transforms(&self, length: usize, mut each: impl FnMut(Option<&[Complex<f64>]>)) {
        let mut transform = Transform::new(length);
        let mut bins = vec![Complex::default(); transform.bins()];
        let hann =
            |k: usize| 0.5 - 0.5 * (std::f64::consts::TAU * (k as f64 + 0.5) / length as f64).cos();
        let window: Vec<f64> = (0..length).map(hann).collect();
        let mut from = 0;
        while from + length <= self.values.len() {
            let piece = &self.values[from..from + length];
            let known = piece.iter().filter(|v| v.is_finite()).count();
            if (known as f64) < KNOWN * length as f64 {
                each(None);
            } else {
                let sum: f64 = piece.iter().filter(|v| v.is_finite()).map(|v| f64::from(*v)).sum();
                let mean = sum / known as f64;
                let value = |v: &f32| if v.is_finite() { f64::from(*v) - mean } else { 0.0 };
                let x: Vec<f64> = piece.iter().zip(&window).map(|(v, w)| w * value(v)).collect();
                transform.forward(&x, &mut bins);
                each(Some(&bins));
            }
            from += length / 2;
        }
    }

    /// The power of each band times its frequency, which is flat if all octaves are alike. NaN for a band with too few pieces.
    pub fn powers(&self) -> Vec<f64> {
        let mut powers = vec![f64::NAN; BANDS];
        for first in (0..BANDS).step_by(BINS) {
            let (length, _) = level(first);
            let mut pieces: Vec<[f64; BINS]> = vec![];
            self.transforms(length, |bins| {
                let of = |bins: &[Complex<f64>]| std::array::from_fn(|k| bins[BINS + k].norm_sqr());
                pieces.extend(bins.map(of));
            });
            if pieces.len() < FEWEST {
                continue;
            }
            for k in 0..BINS {
                // The median: one upset makes no peak.
                let each: Vec<f64> = pieces.iter().map(|piece| piece[k]).collect();
                let scale = (BINS + k) as f64 / (length as f64).powi(2);
                powers[first + k] = median(&each) * scale;
            }
        }
        powers
    }

    /// Pieces in some bands of one level.
    pub fn pieces(&self, bands: &[usize]) -> Vec<Pieces> {
        let Some(first) = bands.first() else { return vec![] };
        let mut values: Vec<Vec<Complex<f32>>> = vec![vec![]; bands.len()];
        self.transforms(level(*first).0, |bins| {
            for (own, band) in values.iter_mut().zip(bands) {
                let bin = bins.map_or(Complex::default(), |bins| bins[level(*band).1]);
                own.push(Complex::new(bin.re as f32, bin.im as f32));
            }
        });
        values.into_iter().map(Pieces::of).collect()
    }
}

impl Pieces {
    /// Pieces whose strength is limited, and their memory.
    pub fn of(mut values: Vec<Complex<f32>>) -> Self {
        let known = |v: &&Complex<f32>| v.norm_sqr() > 0.0;
        let strengths: Vec<f64> =
            values.iter().filter(known).map(|v| f64::from(v.norm())).collect();
        let most = (STRONGEST * median(&strengths)) as f32;
        for value in &mut values {
            let strength = value.norm();
            if strength > most {
                *value *= most / strength;
            }
        }
        let memory = memory(&values);
        Self { values, memory }
    }
}

/// The magnitude of the autocorrelation of pieces at the distances 1, 2, ..., less twice its value by chance. For `K`
/// pieces of noise the squared magnitude is `1/K` on average, and some values of many lags exceed this mean.
fn memory(values: &[Complex<f32>]) -> Vec<f32> {
    let k = values.len();
    let length = (2 * k).next_power_of_two();
    // Real and imaginary parts correlate by two real transforms.
    let mut transform = Transform::new(length);
    let spectrum = |transform: &mut Transform, part: fn(&Complex<f32>) -> f32| {
        let mut x: Vec<f64> = values.iter().map(|v| f64::from(part(v))).collect();
        x.resize(length, 0.0);
        let mut bins = vec![Complex::default(); transform.bins()];
        transform.forward(&x, &mut bins);
        bins
    };
    let (re, im) = (spectrum(&mut transform, |v| v.re), spectrum(&mut transform, |v| v.im));
    // Re: re*re + im*im; Im: im lagged by re less re lagged by im.
    let mut even: Vec<Complex<f64>> =
        re.iter().zip(&im).map(|(a, b)| (a.norm_sqr() + b.norm_sqr()).into()).collect();
    let mut odd: Vec<Complex<f64>> =
        re.iter().zip(&im).map(|(a, b)| a.conj() * b - b.conj() * a).collect();
    let (mut real, mut imaginary) = (vec![0.0; length], vec![0.0; length]);
    transform.inverse(&mut even, &mut real);
    transform.inverse(&mut odd, &mut imaginary);
    let known = values.iter().filter(|v| v.norm_sqr() > 0.0).count().max(2) as f64;
    let power = real[0].max(f64::MIN_POSITIVE);
    let debiased = |lag: usize| {
        // There are fewer pairs at this distance.
        let squared = (real[lag].powi(2) + imaginary[lag].powi(2)) / power.powi(2);
        let share = 1.0 - lag as f64 / k as f64;
        let chance = 2.0 * share / known;
        (((squared - chance).max(0.0)).sqrt() / share).min(1.0) as f32
    };
    let mut memory: Vec<f32> = (1..k).map(debiased).collect();
    // After two distances without memory, the rest is chance.
    let ends = memory.windows(2).position(|pair| pair == [0.0, 0.0]).unwrap_or(memory.len());
    memory[ends..].fill(0.0);
    memory
}

/// The bands in which a loop swings, the strongest first.
pub fn peaks(powers: &[f64]) -> Vec<usize> {
    let strength = |band: usize| {
        let about: Vec<f64> = (band.saturating_sub(BINS)..(band + BINS + 1).min(BANDS))
            .filter(|other| other.abs_diff(band) > 2)
            .map(|other| powers[other])
            .filter(|power| power.is_finite())
            .collect();
        let over = powers[band] / median(&about);
        let neighbours = [band.checked_sub(1), Some(band + 1)];
        let highest = neighbours
            .into_iter()
            .flatten()
            .filter_map(|other| powers.get(other))
            .all(|other| !(*other > powers[band]));
        (highest && over >= PEAK).then_some(powers[band])
    };
    let mut found: Vec<(usize, f64)> =
        (0..BANDS).filter_map(|band| Some((band, strength(band)?))).collect();
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    found.into_iter().take(PEAKS).map(|(band, _)| band).collect()
}

/// Bands, level by level.
pub fn levels(bands: &BTreeSet<usize>) -> Vec<Vec<usize>> {
    let of = |first: usize| bands.range(first..first + BINS).copied().collect::<Vec<_>>();
    (0..BANDS).step_by(BINS).map(of).filter(|level| !level.is_empty()).collect()
}

impl Series {
    /// How long it is, s.
    pub fn seconds(&self) -> f64 {
        self.values.len() as f64 * STEP_S as f64
    }

    /// How much the loop's swing in a band deviates from a sine: the power at two and three times the frequency that is
    /// locked to it, over the power at the frequency.
    pub fn shape(&self, band: usize) -> f64 {
        let (length, bin) = level(band);
        let mut sums = [(Complex::new(0.0, 0.0), 0.0, 0.0); 2];
        let mut power = 0.0;
        self.transforms(length, |bins| {
            let Some(bins) = bins else { return };
            let first = bins[bin];
            power += first.norm_sqr();
            for (times, (product, own, of)) in (2..).zip(&mut sums) {
                // There is no signal beyond half the sample rate.
                let harmonic = bins.get(times * bin).copied().unwrap_or_default();
                let turned =
                    first.powu(times as u32) / first.norm().powi(times as i32 - 1).max(1e-300);
                *product += turned * harmonic.conj();
                *own += turned.norm_sqr();
                *of += harmonic.norm_sqr();
            }
        });
        let locked = sums.iter().map(|(product, own, _)| product.norm_sqr() / own.max(1e-300));
        locked.sum::<f64>() / power.max(1e-300)
    }
}
