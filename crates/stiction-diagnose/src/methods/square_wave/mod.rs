//! Hägglund's shape: square wave or sine.
//!
//! # What it measures
//! Whether the half waves of the control error are nearer to a square wave or to a sine. If the process is fast
//! against the period, a sticking valve makes the error nearly square.
//!
//! # Assumptions
//! An oscillating loop with a self-regulating process whose time constant is short against the period.
//!
//! # Equations
//! In each half wave of the control error around its mean, by least squares:
//! ```text
//! V_sq = sum (e - a)^2,   V_sin = sum (e - b sin(pi t / L))^2
//! index = (V_sin - V_sq) / (V_sin + V_sq),  both V summed over all half waves
//! ```
//! Above 0: sticks. Below: does not stick.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `threshold` | none | 0 | recalled, and read in a public program |
//!
//! # Limits
//! If the process is slow, the error of a sticking loop is a triangle, which a sine fits better: the index is then
//! evidence against stiction. Half waves of fewer than five samples are left out. Four half waves are needed.
//!
//! # Deviations from the paper
//! The paper was not read. A public program agrees in the index and the threshold. It takes the amplitudes from equal
//! areas, `a = 2 IAE / Tp` and `b = pi IAE / Tp` with the half wave's absolute area `IAE` and the period `Tp`, and
//! averages one index per half wave. Here the amplitudes are of least squares, and errors are summed. The paper's
//! method, as recalled, is recursive and forgets; this one uses the whole segment.
//!
//! # References
//! T. Hägglund, A shape-analysis approach for diagnosis of stiction in control valves, Control
//! Engineering Practice 19 (2011) 782-789 (not read); GitHub
//! Freddymt20/Non-linearity-detection-algorithm-in-control-valves (read).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::shapes::{enough, pieces, presume_oscillation, representable};
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{HalfWave, centred};

/// Hägglund's shape with its threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SquareWave {
    /// Above it, the index indicates stiction.
    pub threshold: f64,
}

impl Default for SquareWave {
    fn default() -> Self {
        Self { threshold: 0.0 }
    }
}

/// A half wave with its square wave and sine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SquareWaveFit {
    /// Range.
    pub wave: HalfWave,
    /// Level of the square wave.
    pub square: f64,
    /// Amplitude of the sine, negative below zero.
    pub sine: f64,
    /// Squared errors of the square wave, summed.
    pub square_error: f64,
    /// Squared errors of the sine, summed.
    pub sine_error: f64,
}

/// The result of Hägglund's shape.
#[derive(Debug, Clone, PartialEq)]
pub struct SquareWaveResult {
    /// The index, -1 for a sine to 1 for a square wave.
    pub statistic: f64,
    /// Threshold of the statistic.
    pub threshold: f64,
    /// The verdict.
    pub decision: Decision,
    /// The control error less its mean.
    pub error: Vec<f64>,
    /// The fits.
    pub waves: Vec<SquareWaveFit>,
    /// Cautions.
    pub caveats: Vec<String>,
}

impl SquareWave {
    /// The description of this method.
    pub const METHOD: Method = Method {
        name: "square-wave",
        title: "Hägglund's shape",
        source: "Hägglund, Control Eng. Practice 19 (2011) 782-789, not read; index and threshold \
                 as in a public program",
        statistic: "shape index",
        rule: "sticks if the index exceeds 0",
        applies: Applies::SelfRegulating,
        decides: Decides::Stiction,
        needs: Needs::Error,
        family: Family::Shape,
        explains_oscillation: true,
    };

    /// Fits the half waves of the control error.
    ///
    /// # Errors
    /// If the method does not apply, or there are too few half waves.
    pub fn run(&self, subject: &Subject<'_>) -> Result<SquareWaveResult, Abstention> {
        let mut caveats = subject.check(&Self::METHOD)?;
        presume_oscillation(subject, &mut caveats);
        let error = subject.error().map_or(vec![], |error| centred(&error.values));
        let pieces = pieces(&error, subject.error_half_waves());
        enough(pieces.len())?;
        let waves: Vec<SquareWaveFit> = pieces
            .iter()
            .map(|piece| {
                let (square, sine) = (piece.square(), piece.sine());
                let n = piece.y.len() as f64;
                SquareWaveFit {
                    wave: piece.wave,
                    square: square.amplitude,
                    sine: sine.amplitude,
                    square_error: n * square.mse,
                    sine_error: n * sine.mse,
                }
            })
            .collect();
        let square: f64 = waves.iter().map(|w| w.square_error).sum();
        let sine: f64 = waves.iter().map(|w| w.sine_error).sum();
        let statistic = representable((sine - square) / (sine + square))?;
        let sticks = statistic > self.threshold;
        let decision = if sticks { Decision::Sticks } else { Decision::DoesNotStick };
        let threshold = self.threshold;
        Ok(SquareWaveResult { statistic, threshold, decision, error, waves, caveats })
    }
}

impl Detector for SquareWave {
    fn method(&self) -> &'static Method {
        &Self::METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![Number::new("threshold", self.threshold, "")]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let r = self.run(subject)?;
        let nearer = if r.decision == Decision::Sticks {
            "a square wave than to a sine"
        } else {
            "a sine than to a square wave"
        };
        let reason = format!(
            "the control error is nearer to {nearer}: the index is {:.3} (sticks above {:.2}) over {} half waves",
            r.statistic,
            r.threshold,
            r.waves.len()
        );
        let numbers = vec![
            Number::new("shape index", r.statistic, ""),
            Number::new("half waves", r.waves.len() as f64, ""),
        ];
        let finding =
            Finding::new(&Self::METHOD, r.decision, r.statistic, r.threshold, reason, numbers);
        let caveats = r.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(r)), ..finding })
    }
}
