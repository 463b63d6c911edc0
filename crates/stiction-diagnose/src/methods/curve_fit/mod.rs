//! He's fit of sine and triangle.
//!
//! # What it measures
//! Whether the output of the first integrator behind the valve is a triangle wave or a sine. A sticking valve jumps
//! between two positions; integrated, that is a triangle. In a self-regulating loop the first integrator is the
//! controller, so the signal is the OP; in an integrating loop it is the process, so the signal is the PV.
//!
//! # Assumptions
//! An oscillating loop; integral action in the controller of a self-regulating loop.
//!
//! # Equations
//! In each half wave around the mean, between interpolated crossings of zero:
//! ```text
//! sine:      A sin(pi t / L), A of least squares
//! triangle:  k1 t up to the apex, k2 (L - t) beyond; k1, k2 of least squares on their sides, the
//!            apex in both; the apex is the inner sample with the least error
//! SI = MSE_sin / (MSE_sin + MSE_tri),  each the mean over the half waves
//! ```
//! SI is 0 for a sine and 1 for a triangle. Either shape, fitted by the other, leaves `1 - 96/pi^4` of its power
//! (derived here). 0.6 and above sticks, 0.4 and below does not.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `upper` | none | 0.6 | read in two public programs, not in the paper |
//! | `lower` | none | 0.4 | read in two public programs, not in the paper |
//!
//! # Limits
//! A square wave scores about 0.43, and noise moves SI towards 0.5. With proportional action the OP keeps part of
//! the PV's shape. Half waves of fewer than five samples are left out. Four half waves are needed.
//!
//! # Deviations from the paper
//! Not known: only the abstract was read. The two sides of a triangle need not meet at the apex. Two public programs
//! also form SI from mean errors; a third averages one SI per cycle. The programs fit lines between the end samples
//! of a half wave; ours begin and end at the interpolated crossings.
//!
//! # References
//! Q. P. He, J. Wang, M. Pottmann, S. J. Qin, A curve fitting method for detecting valve stiction in
//! oscillating control loops, Industrial & Engineering Chemistry Research 46 (2007) 4549-4560.

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::shapes::{Triangle, enough, pieces, presume_oscillation, representable};
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::recording::Dynamics;
use crate::series::{HalfWave, centred, half_waves, span};

/// He's fit with its thresholds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveFit {
    /// Index from which the valve sticks.
    pub upper: f64,
    /// Index up to which it does not stick.
    pub lower: f64,
}

impl Default for CurveFit {
    fn default() -> Self {
        Self { upper: 0.6, lower: 0.4 }
    }
}

/// A half wave with its sine and its triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveFitWave {
    /// Range.
    pub wave: HalfWave,
    /// Amplitude of the sine, negative below zero.
    pub sine: f64,
    /// The triangle.
    pub triangle: Triangle,
    /// Mean square error of the sine.
    pub sine_mse: f64,
    /// Mean square error of the triangle.
    pub triangle_mse: f64,
}

impl CurveFitWave {
    /// Value of the sine at sample `k`, which may be fractional.
    pub fn sine_at(&self, k: f64) -> f64 {
        let phase = (k - self.wave.from) / self.wave.length();
        self.sine * (std::f64::consts::PI * phase).sin()
    }

    /// The triangle's value at `k`, in samples.
    pub fn triangle_at(&self, k: f64) -> f64 {
        self.triangle.at(&self.wave, k)
    }
}

/// The result of He's fit.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveFitResult {
    /// The stiction index SI, 0 for a sine and 1 for a triangle.
    pub statistic: f64,
    /// Threshold of the statistic.
    pub threshold: f64,
    /// The verdict.
    pub decision: Decision,
    /// Name of the signal, `OP` or `PV`.
    pub signal: &'static str,
    /// That signal less its mean.
    pub values: Vec<f64>,
    /// Mean square error of the sines, over the half waves.
    pub sine_mse: f64,
    /// Mean square error of the triangles, over the half waves.
    pub triangle_mse: f64,
    /// The fits.
    pub waves: Vec<CurveFitWave>,
    /// Cautions.
    pub caveats: Vec<String>,
}

impl CurveFit {
    /// The description of this method.
    pub const METHOD: Method = Method {
        name: "curve-fit",
        title: "He's fit of sine and triangle",
        source: "He, Wang, Pottmann, Qin, Ind. Eng. Chem. Res. 46 (2007) 4549-4560; abstract read, \
                 formulas and thresholds from public programs",
        statistic: "stiction index SI",
        rule: "sticks if SI is at least 0.6, does not stick if it is at most 0.4",
        applies: Applies::AnyLoop,
        decides: Decides::Stiction,
        needs: Needs::Op,
        family: Family::Shape,
        explains_oscillation: true,
    };

    /// Fits the OP of a self-regulating loop or the PV of an integrating one.
    ///
    /// # Errors
    /// If the method does not apply, the PV of an integrating loop is not known, or there are too few
    /// half waves.
    pub fn run(&self, subject: &Subject<'_>) -> Result<CurveFitResult, Abstention> {
        let mut caveats = subject.check(&Self::METHOD)?;
        presume_oscillation(subject, &mut caveats);
        let dynamics = subject.loop_type.dynamics();
        let (signal, values) = if dynamics == Dynamics::Integrating {
            let pv = subject.segment.pv.as_deref().ok_or_else(|| {
                Abstention("needs the PV of an integrating loop, which is not recorded".to_owned())
            })?;
            ("PV", pv)
        } else {
            if dynamics == Dynamics::Unknown {
                caveats
                    .push("the loop's type is not known; it is assumed self-regulating".to_owned());
            }
            ("OP", subject.segment.op.as_slice())
        };
        if span(values) == 0.0 {
            return Err(Abstention(format!("the {signal} never moves")));
        }
        let result = self.fit(signal, values)?;
        enough(result.waves.len())?;
        Ok(CurveFitResult { caveats, ..result })
    }

    /// Fits a signal of that name, for any loop and any number of half waves.
    ///
    /// # Errors
    /// If there is no half wave, or both fits are exact.
    pub fn fit(&self, signal: &'static str, values: &[f64]) -> Result<CurveFitResult, Abstention> {
        let values = centred(values);
        let pieces = pieces(&values, &half_waves(&values));
        let waves: Vec<CurveFitWave> = pieces
            .iter()
            .map(|piece| {
                let (sine, (triangle, triangle_mse)) = (piece.sine(), piece.triangle());
                CurveFitWave {
                    wave: piece.wave,
                    sine: sine.amplitude,
                    triangle,
                    sine_mse: sine.mse,
                    triangle_mse,
                }
            })
            .collect();
        let average =
            |mse: fn(&CurveFitWave) -> f64| waves.iter().map(mse).sum::<f64>() / waves.len() as f64;
        let (sine_mse, triangle_mse) = (average(|w| w.sine_mse), average(|w| w.triangle_mse));
        let statistic = representable(sine_mse / (sine_mse + triangle_mse))?;
        let decision = if statistic >= self.upper {
            Decision::Sticks
        } else if statistic <= self.lower {
            Decision::DoesNotStick
        } else {
            Decision::Undecided
        };
        Ok(CurveFitResult {
            statistic,
            threshold: self.upper,
            decision,
            signal,
            values,
            sine_mse,
            triangle_mse,
            waves,
            caveats: vec![],
        })
    }
}

impl Detector for CurveFit {
    fn method(&self) -> &'static Method {
        &Self::METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![Number::new("upper", self.upper, ""), Number::new("lower", self.lower, "")]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let r = self.run(subject)?;
        let what = match r.decision {
            Decision::Sticks => "is nearer to a triangle wave than to a sine",
            Decision::DoesNotStick => "is nearer to a sine than to a triangle wave",
            _ => "is as near to a triangle wave as to a sine",
        };
        let reason = format!(
            "the {} {what}: SI is {:.3} (sticks at {:.2} or more, does not at {:.2} or less) over {} half waves",
            r.signal,
            r.statistic,
            self.upper,
            self.lower,
            r.waves.len()
        );
        // Errors over the mean square of the signal, so that they have no unit.
        let power = r.values.iter().map(|v| v * v).sum::<f64>() / r.values.len() as f64;
        let numbers = vec![
            Number::new("SI", r.statistic, ""),
            Number::new("sine misfit", r.sine_mse / power, ""),
            Number::new("triangle misfit", r.triangle_mse / power, ""),
            Number::new("half waves", r.waves.len() as f64, ""),
        ];
        let finding =
            Finding::new(&Self::METHOD, r.decision, r.statistic, r.threshold, reason, numbers);
        let caveats = r.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(r)), ..finding })
    }
}
