//! Singhal and Salsbury's ratio of areas.
//!
//! # What it measures
//! For each half wave of the control error, the area before the peak over the area after it. Behind a lag, a jump of
//! the valve makes the error rise in a curve and fall at once, so the peak comes late. The sinusoid of a tightly tuned
//! loop has its peak in the middle.
//!
//! # Assumptions
//! An oscillating loop with a self-regulating process, whose time constant is not large against the period.
//!
//! # Equations
//! ```text
//! R = mean over the half waves of A1 / A2
//! A1, A2 = areas by trapezia from the crossing of zero to the first largest sample, and from there
//!          to the next crossing; crossings are interpolated and are corners of the trapezia
//! ```
//! For a square wave of half period `h` behind a lag `tau`, with `c = 2 / (1 + exp(-h/tau))`: `R = (h/tau - ln c -
//! (c - 1)) / ((c - 1) - ln c)`, which is 1.18 at `h = tau/4`, 1.92 at `h = tau` and 3.44 at `h = 2 tau` (derived
//! here). For sine and triangle it is 1.
//!
//! `R > 1 + margin`: sticks. Within the margin around 1: does not stick. Below: undecided, because no cause of an
//! early peak is known.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `margin` | none | 0.18 | ours: a square wave behind a lag of four half periods |
//!
//! # Limits
//! Noise moves peaks and splits half waves: filter first. A quantised PV has peaks of several equal samples, of
//! which the first counts. Half waves of fewer than five samples are left out. Four half waves are needed.
//!
//! # Deviations from the paper
//! Only the first page of the paper was read: areas before and after the peak of an oscillating signal. The formula
//! was recalled, and the paper's margin was not found. Set point changes are not cut out.
//!
//! # References
//! A. Singhal, T. I. Salsbury, A simple method for detecting valve stiction in oscillating control
//! loops, Journal of Process Control 15 (2005) 371-382.

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::shapes::{Piece, enough, pieces, presume_oscillation, representable};
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{HalfWave, half_waves, mean, median};

/// The ratio of areas with its margin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaRatio {
    /// Largest distance of the ratio from 1 in a loop that does not stick.
    pub margin: f64,
}

impl Default for AreaRatio {
    fn default() -> Self {
        Self { margin: 0.18 }
    }
}

/// The areas of one half wave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Areas {
    /// Range.
    pub wave: HalfWave,
    /// First largest sample.
    pub peak: usize,
    /// Area before the peak, units of the error times samples.
    pub before: f64,
    /// Area after the peak.
    pub after: f64,
}

/// The result of the ratio of areas.
#[derive(Debug, Clone, PartialEq)]
pub struct AreaRatioResult {
    /// Mean ratio.
    pub statistic: f64,
    /// Threshold of the statistic.
    pub threshold: f64,
    /// The verdict.
    pub decision: Decision,
    /// Median ratio, which a few odd half waves do not change.
    pub median: f64,
    /// The control error.
    pub error: Vec<f64>,
    /// Half waves.
    pub areas: Vec<Areas>,
    /// Cautions.
    pub caveats: Vec<String>,
}

fn areas(piece: &Piece<'_>) -> Areas {
    let HalfWave { from, to, first, end, .. } = piece.wave;
    let mut top = 0;
    for (i, y) in piece.y.iter().enumerate() {
        if y.abs() > piece.y[top].abs() {
            top = i;
        }
    }
    let trapezia =
        |y: &[f64]| -> f64 { y.windows(2).map(|pair| 0.5 * (pair[0].abs() + pair[1].abs())).sum() };
    let ends = (piece.y[0].abs(), piece.y[piece.y.len() - 1].abs());
    Areas {
        wave: piece.wave,
        peak: first + top,
        before: 0.5 * ends.0 * (first as f64 - from) + trapezia(&piece.y[..=top]),
        after: 0.5 * ends.1 * (to - (end - 1) as f64) + trapezia(&piece.y[top..]),
    }
}

impl AreaRatio {
    /// The description of this method.
    pub const METHOD: Method = Method {
        name: "area-ratio",
        title: "Singhal and Salsbury's ratio of areas",
        source: "Singhal, Salsbury, J. Process Control 15 (2005) 371-382; first page read, \
                 formula recalled; margin ours",
        statistic: "mean area before the peak over area after it",
        rule: "sticks if the ratio exceeds 1.18, does not stick if it is within 0.18 of 1",
        applies: Applies::SelfRegulating,
        decides: Decides::Stiction,
        needs: Needs::Error,
        family: Family::Shape,
        explains_oscillation: true,
    };

    /// Measures the half waves of the control error around zero.
    ///
    /// # Errors
    /// If the method does not apply, or there are too few half waves.
    pub fn run(&self, subject: &Subject<'_>) -> Result<AreaRatioResult, Abstention> {
        let mut caveats = subject.check(&Self::METHOD)?;
        presume_oscillation(subject, &mut caveats);
        let error = subject.error().map_or(vec![], |error| error.values.clone());
        let pieces = pieces(&error, &half_waves(&error));
        enough(pieces.len())?;
        let areas: Vec<Areas> = pieces.iter().map(areas).collect();
        let ratios: Vec<f64> = areas.iter().map(|each| each.before / each.after).collect();
        let statistic = representable(mean(&ratios))?;
        let decision = if statistic > 1.0 + self.margin {
            Decision::Sticks
        } else if statistic >= 1.0 - self.margin {
            Decision::DoesNotStick
        } else {
            Decision::Undecided
        };
        let threshold = 1.0 + self.margin;
        let median = median(&ratios);
        Ok(AreaRatioResult { statistic, threshold, decision, median, error, areas, caveats })
    }
}

impl Detector for AreaRatio {
    fn method(&self) -> &'static Method {
        &Self::METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![Number::new("margin", self.margin, "")]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let r = self.run(subject)?;
        let what = match r.decision {
            Decision::Sticks => "the control error peaks late, as with a sticking valve",
            Decision::DoesNotStick => "the control error peaks in the middle, as a sinusoid does",
            _ => "the control error peaks early, for which the method has no cause",
        };
        let reason = format!(
            "{what}: the ratio of the areas before and after the peak is {:.3} (sticks above {:.3}) over {} half \
             waves",
            r.statistic,
            r.threshold,
            r.areas.len()
        );
        let numbers = vec![
            Number::new("mean ratio", r.statistic, ""),
            Number::new("median ratio", r.median, ""),
            Number::new("half waves", r.areas.len() as f64, ""),
        ];
        let finding =
            Finding::new(&Self::METHOD, r.decision, r.statistic, r.threshold, reason, numbers);
        let caveats = r.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(r)), ..finding })
    }
}
