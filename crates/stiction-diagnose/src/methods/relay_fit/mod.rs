//! Rossi and Scali's fit of relay responses.
//!
//! # What it measures
//! Whether the PV looks like the response of the process to a relay, from triangle to square, or like a sine. A
//! sticking valve is such a relay.
//!
//! # Assumptions
//! An oscillating loop with a self-regulating process of about first order.
//!
//! # Equations
//! In each half wave of the PV around its mean, of length `L` between interpolated crossings, by least squares:
//! ```text
//! sine:      A sin(pi t / L)
//! triangle:  k1 t up to the apex, k2 (L - t) beyond; the apex is the inner sample of least error
//! relay:     A min(1 - exp(-t/tau), exp((L - t)/tau) - 1),  L/tau from 0.1 to 20
//! S = (E_sin - E) / (E_sin + E),  E = min(E_tri, E_rel);  each E the mean square error, averaged over
//!                                 the half waves
//! ```
//! The relay response is the response of a first-order lag to a square wave of half period `L`, shifted by the dead
//! time that gives the crossing of zero. It rises towards one level, and falls towards the other once the relay has
//! switched (derived here). S above 0.21 sticks, below 0 does not.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `upper` | none | 0.21 | Rossi & Scali 2005, recalled, not read |
//! | `lower` | none | 0 | Rossi & Scali 2005, recalled, not read |
//!
//! # Limits
//! The relay's shape has one parameter more than the sine, so noise alone moves S above 0. Half waves of fewer than
//! five samples are left out. Four half waves are needed.
//!
//! # Deviations from the paper
//! Recalled, not read. Ours: mean square errors averaged before they are compared; the ratio `L/tau`
//! on a geometric grid refined once, to about 4 %; the apex of the triangle is free.
//!
//! # References
//! M. Rossi, C. Scali, A comparison of techniques for automatic detection of stiction: simulation and
//! application to industrial data, Journal of Process Control 15 (2005) 505-514.

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::shapes::{Relay, Triangle, enough, pieces, presume_oscillation, representable};
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{HalfWave, centred, half_waves};

/// The fit of relay responses with its thresholds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayFit {
    /// Above it, the index indicates stiction.
    pub upper: f64,
    /// Below it, the index indicates no stiction.
    pub lower: f64,
}

impl Default for RelayFit {
    fn default() -> Self {
        Self { upper: 0.21, lower: 0.0 }
    }
}

/// A half wave with its three shapes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayFitWave {
    /// Range.
    pub wave: HalfWave,
    /// Amplitude of the sine, negative below zero.
    pub sine: f64,
    /// The triangle.
    pub triangle: Triangle,
    /// The relay response.
    pub relay: Relay,
    /// Mean square errors of sine, triangle and relay response.
    pub mse: [f64; 3],
}

/// The result of the fit of relay responses.
#[derive(Debug, Clone, PartialEq)]
pub struct RelayFitResult {
    /// The index S, -1 to 1.
    pub statistic: f64,
    /// Threshold of the statistic.
    pub threshold: f64,
    /// The verdict.
    pub decision: Decision,
    /// Mean square errors of sine, triangle and relay response, over the half waves.
    pub mse: [f64; 3],
    /// The PV less its mean.
    pub values: Vec<f64>,
    /// The fits.
    pub waves: Vec<RelayFitWave>,
    /// Cautions.
    pub caveats: Vec<String>,
}

impl RelayFit {
    /// The description of this method.
    pub const METHOD: Method = Method {
        name: "relay-fit",
        title: "Rossi and Scali's fit of relay responses",
        source: "Rossi, Scali, J. Process Control 15 (2005) 505-514; recalled, not read",
        statistic: "index S",
        rule: "sticks if S exceeds 0.21, does not stick if it is below 0",
        applies: Applies::SelfRegulating,
        decides: Decides::Stiction,
        needs: Needs::OpAndPv,
        family: Family::Shape,
        explains_oscillation: true,
    };

    /// Fits the half waves of the PV.
    ///
    /// # Errors
    /// If the method does not apply, or there are too few half waves.
    pub fn run(&self, subject: &Subject<'_>) -> Result<RelayFitResult, Abstention> {
        let mut caveats = subject.check(&Self::METHOD)?;
        presume_oscillation(subject, &mut caveats);
        let values = centred(subject.segment.pv.as_deref().unwrap_or_default());
        let pieces = pieces(&values, &half_waves(&values));
        enough(pieces.len())?;
        let waves: Vec<RelayFitWave> = pieces
            .iter()
            .map(|piece| {
                let sine = piece.sine();
                let ((triangle, of_triangle), (relay, of_relay)) =
                    (piece.triangle(), piece.relay());
                RelayFitWave {
                    wave: piece.wave,
                    sine: sine.amplitude,
                    triangle,
                    relay,
                    mse: [sine.mse, of_triangle, of_relay],
                }
            })
            .collect();
        let mse = [0, 1, 2]
            .map(|shape| waves.iter().map(|w| w.mse[shape]).sum::<f64>() / waves.len() as f64);
        let best = mse[1].min(mse[2]);
        let statistic = representable((mse[0] - best) / (mse[0] + best))?;
        let decision = if statistic > self.upper {
            Decision::Sticks
        } else if statistic < self.lower {
            Decision::DoesNotStick
        } else {
            Decision::Undecided
        };
        Ok(RelayFitResult {
            statistic,
            threshold: self.upper,
            decision,
            mse,
            values,
            waves,
            caveats,
        })
    }
}

impl Detector for RelayFit {
    fn method(&self) -> &'static Method {
        &Self::METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![Number::new("upper", self.upper, ""), Number::new("lower", self.lower, "")]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let r = self.run(subject)?;
        let shape = if r.mse[1] <= r.mse[2] { "a triangle wave" } else { "a relay's response" };
        let what = match r.decision {
            Decision::Sticks => format!("is nearer to {shape} than to a sine"),
            Decision::DoesNotStick => format!("is nearer to a sine than to {shape}"),
            _ => format!("is hardly nearer to {shape} than to a sine"),
        };
        let reason = format!(
            "the PV {what}: S is {:.3} (sticks above {:.2}, does not below {:.2}) over {} half waves",
            r.statistic,
            self.upper,
            self.lower,
            r.waves.len()
        );
        let power = r.values.iter().map(|v| v * v).sum::<f64>() / r.values.len() as f64;
        let numbers = vec![
            Number::new("S", r.statistic, ""),
            Number::new("sine misfit", r.mse[0] / power, ""),
            Number::new("triangle misfit", r.mse[1] / power, ""),
            Number::new("relay misfit", r.mse[2] / power, ""),
            Number::new("half waves", r.waves.len() as f64, ""),
        ];
        let finding =
            Finding::new(&Self::METHOD, r.decision, r.statistic, r.threshold, reason, numbers);
        let caveats = r.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(r)), ..finding })
    }
}
