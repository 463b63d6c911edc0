//! Horch and Isaksson's density of the second derivative, for integrating loops.
//!
//! # What it measures
//! The distribution of the PV's second derivative. Behind a sticking valve the PV is a triangle wave, whose second
//! derivative is mostly noise: one hump in the middle. That of a sinusoid is mostly near its ends: two humps, a
//! camel.
//!
//! # Assumptions
//! An oscillating loop with an integrating process; noise that is about Gaussian.
//!
//! # Equations
//! ```text
//! z(k) = p(k - m) - 2 p(k) + p(k + m),  p = PV averaged over m samples,  m = period / 12
//! one hump:   f1 = N(0, w^2), with the best w from a tenth to 1.25 of sd(z)
//! two humps:  f2 = density of A sin(phase) + N(0, s^2), phase uniform,  A^2 = 2 (var(z) - s^2)
//! s^2 = part of var(z) by white noise of the PV, from the median size of its third differences
//! E1, E2 = squared differences of f1, f2 from the histogram of z over -4 sd to 4 sd, 41 bins, summed
//! index = (E2 - E1) / (E2 + E1)
//! ```
//! Above 0 the hump fits better: sticks. Below 0 the camel fits better: does not stick. Within `margin` of 0:
//! undecided.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `margin` | none | 0.2 | ours |
//! | `least_signal` | share of `var(z)` | 0.5 | ours: with less, two humps are one |
//!
//! # Limits
//! Abstains without an oscillation, and if noise covers the curvature. Irregular signals also have one hump. Steps
//! of the set point or of the load are also corners.
//!
//! # Deviations from the paper
//! The paper was not read. The claims of Horch's patent agree in the idea: the derived signal is mapped, and the
//! mapping is compared with the mapping of static friction and of a sinusoid. The patent filters to two to four times
//! the frequency of the oscillation; the average over `m` passes up to about five times. The estimate of the noise, the
//! histogram, the index and its margin are ours.
//!
//! # References
//! A. Horch, A. J. Isaksson, Detection of stiction in integrating processes, European Control
//! Conference (2001) (not read); A. Horch, US patent 7,047,152 (claims read).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::curvature::curvature;
use super::shared::shapes::representable;
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{centred, std};
use statrs::function::erf::erf;

/// Bins of the histogram: ours.
const BINS: usize = 41;
/// Reach of the histogram to either side, in standard deviations: ours.
const REACH: f64 = 4.0;
/// Phases over which the camel is averaged: ours.
const PHASES: usize = 64;

/// Tried widths of the one hump: ours.
const WIDTHS: usize = 24;
/// The first width, in standard deviations: ours.
const LEAST_WIDTH: f64 = 0.1;
/// Ratio of each width to the previous one: ours.
const WIDTH_STEP: f64 = 1.116;

/// The density of the second derivative with its thresholds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HorchDensity {
    /// Around 0, within this margin, the index does not decide.
    pub margin: f64,
    /// Smallest share of the variance that is not noise.
    pub least_signal: f64,
}

impl Default for HorchDensity {
    fn default() -> Self {
        Self { margin: 0.2, least_signal: 0.5 }
    }
}

/// The result of the density of the second derivative.
#[derive(Debug, Clone, PartialEq)]
pub struct HorchDensityResult {
    /// The index: 1 if one hump fits, -1 if two do.
    pub statistic: f64,
    /// Threshold of the statistic.
    pub threshold: f64,
    /// The verdict.
    pub decision: Decision,
    /// Middles of the bins, in standard deviations of the second difference.
    pub places: Vec<f64>,
    /// Density of the second difference in each bin, per standard deviation.
    pub found: Vec<f64>,
    /// Density with one hump.
    pub one_hump: Vec<f64>,
    /// Density with two humps.
    pub two_humps: Vec<f64>,
    /// Share of the variance that is not noise.
    pub signal: f64,
    /// Lag of the second difference, samples.
    pub lag: usize,
    /// Cautions.
    pub caveats: Vec<String>,
}

/// Share of a standard normal below `z`.
fn below(z: f64) -> f64 {
    0.5 * (1.0 + erf(z / std::f64::consts::SQRT_2))
}

/// Density in each bin of a distribution, from the share below each edge.
fn density(below: impl Fn(f64) -> f64) -> Vec<f64> {
    let width = 2.0 * REACH / BINS as f64;
    let edges: Vec<f64> = (0..=BINS).map(|i| below(i as f64 * width - REACH)).collect();
    edges.windows(2).map(|pair| (pair[1] - pair[0]) / width).collect()
}

impl HorchDensity {
    /// The description of this method.
    pub const METHOD: Method = Method {
        name: "horch-density",
        title: "Horch and Isaksson's density of the second derivative",
        source: "Horch, Isaksson, European Control Conference (2001), not read; idea as in the \
                 claims of US patent 7,047,152; filter, index and margin ours",
        statistic: "index of the densities' misfits",
        rule: "sticks if one hump fits the density better than two humps by a margin of 0.2, does not \
               stick if two humps fit better than one",
        applies: Applies::Integrating,
        decides: Decides::Stiction,
        needs: Needs::OpAndPv,
        family: Family::Shape,
        explains_oscillation: true,
    };

    /// Compares densities.
    ///
    /// # Errors
    /// If the method does not apply, the subject has no period, the PV spans less than two periods, or noise covers
    /// its curvature.
    pub fn run(&self, subject: &Subject<'_>) -> Result<HorchDensityResult, Abstention> {
        let caveats = subject.check(&Self::METHOD)?;
        let pv = centred(subject.segment.pv.as_deref().unwrap_or_default());
        let curvature = curvature(subject, &pv)?;
        let sd = representable(std(&curvature.values))?;
        if !(sd > 0.0) {
            return Err(Abstention("the second difference of the PV is zero".to_owned()));
        }
        // In standard deviations from here on.
        let noise = (curvature.noise / sd).min(1.0);
        let signal = 1.0 - noise * noise;
        if !(signal >= self.least_signal) {
            return Err(Abstention(format!(
                "noise masks the PV's curvature: {:.0} % of the variance of its second difference is noise",
                100.0 * noise * noise
            )));
        }
        let width = 2.0 * REACH / BINS as f64;
        let values = centred(&curvature.values);
        let mut found = vec![0.0; BINS];
        for z in &values {
            // Values farther out are in no bin.
            if let Some(bin) = found.get_mut(((z / sd + REACH) / width).floor() as usize)
                && *z >= -REACH * sd
            {
                *bin += 1.0 / (values.len() as f64 * width);
            }
        }
        let amplitude = (2.0 * signal).sqrt();
        // The noise is at least wide enough to blend the phases.
        let spread = noise.max(0.05);
        let offsets: [f64; PHASES] = std::array::from_fn(|i| {
            amplitude * (std::f64::consts::PI * ((i as f64 + 0.5) / PHASES as f64 - 0.5)).sin()
        });
        let two_humps = density(|edge| {
            offsets.iter().map(|offset| below((edge - offset) / spread)).sum::<f64>()
                / PHASES as f64
        });
        let misfit = |model: &[f64]| -> f64 {
            found.iter().zip(model).map(|(found, model)| (found - model).powi(2)).sum()
        };
        let two = misfit(&two_humps);
        let (mut one, mut one_hump) = (f64::INFINITY, vec![]);
        for i in 0..WIDTHS {
            let width = LEAST_WIDTH * WIDTH_STEP.powi(i as i32);
            let hump = density(|edge| below(edge / width));
            let error = misfit(&hump);
            if error < one {
                (one, one_hump) = (error, hump);
            }
        }
        let statistic = representable((two - one) / (two + one))?;
        let decision = if statistic > self.margin {
            Decision::Sticks
        } else if statistic < -self.margin {
            Decision::DoesNotStick
        } else {
            Decision::Undecided
        };
        let places = (0..BINS).map(|i| (i as f64 + 0.5) * width - REACH).collect();
        Ok(HorchDensityResult {
            statistic,
            threshold: self.margin,
            decision,
            places,
            found,
            one_hump,
            two_humps,
            signal,
            lag: curvature.lag,
            caveats,
        })
    }
}

impl Detector for HorchDensity {
    fn method(&self) -> &'static Method {
        &Self::METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![
            Number::new("margin", self.margin, ""),
            Number::new("least signal", self.least_signal, ""),
        ]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let r = self.run(subject)?;
        let what = match r.decision {
            Decision::Sticks => "one hump, as between the corners of a triangle wave",
            Decision::DoesNotStick => "two humps, as of a sinusoid",
            _ => "neither clearly one hump nor two",
        };
        let reason = format!(
            "the second difference of the PV has {what}: the index is {:.3} (sticks above {:.2}, does not below \
             {:.2})",
            r.statistic, self.margin, -self.margin
        );
        let numbers = vec![
            Number::new("index", r.statistic, ""),
            Number::new("share that is not noise", r.signal, ""),
            Number::new("lag", r.lag as f64 * subject.segment.sample_time, "s"),
        ];
        let finding =
            Finding::new(&Self::METHOD, r.decision, r.statistic, r.threshold, reason, numbers);
        let caveats = r.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(r)), ..finding })
    }
}
