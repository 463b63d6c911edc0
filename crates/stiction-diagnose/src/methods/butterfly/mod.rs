//! The butterfly shape of PV and OP (Kamaruddin, Zabiri et al. 2020).
//!
//! # What it measures
//! `|OP(k) - PV(k-1)|` is plotted against `PV(k)`, both normalised. While a valve sticks, the OP moves and the PV rests
//! on one side, which draws a wing. Then the PV moves quickly to the opposite side. The result looks like a butterfly:
//! two open wings with an empty body between.
//!
//! # Assumptions
//! The PV rests while the valve does: a fast self-regulating process. A stationary oscillation.
//!
//! # Equations
//! PV and OP less their means and over their standard deviations, `d(k) = |OP(k) - PV(k-1)|`.
//! * body: the share `B` of samples with `|PV| < 1/2`; the other samples are the wings, by the sign of the PV;
//! * emptiness `W = 1 - B/B_sine`, `B_sine = (2/pi) asin(1/sqrt 8) = 0.2301`: 0 for a sine, 1 for a
//!   square wave, `1 - 1/(sqrt 12 B_sine) = -0.2548` for a triangle;
//! * opening of a wing: the range of `d` that contains its middle 90 %. For a square PV and a triangular OP a
//!   quarter of a period apart, it is about 2.5.
//!
//! # Parameters
//! | name | default | unit | source |
//! |---|---|---|---|
//! | emptiness | 0.5 | | ours, midway between sine and square |
//! | opening | 1 | standard deviations | ours |
//! | cutoff | none | share of the Nyquist frequency | read (0.2, optional) |
//!
//! # Limits
//! A PV behind a lag, rounded or triangular, has no empty body even if the valve sticks. So a shape without wings
//! decides nothing, and the method never finds that a valve does not stick. A square set point or disturbance also
//! empties the body.
//!
//! # Deviations from the paper
//! The paper was not read; the plot was read in a public repository, which scales both signals to 0 to 1, not to
//! standard deviations. The publication judges the plot by eye or by a network; emptiness, opening and their
//! thresholds are ours. The optional low pass (Butterworth, third order) runs forwards and backwards, as there.
//!
//! # References
//! Kamaruddin, Zabiri et al., J. Process Control 87 (2020) (not read); GitHub
//! TerenceXue-tech/StictionGPT (plot read).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{low_passed, quantile, standardised};

/// Emptiness of the body from which there are wings; ours, midway between a sine and a square wave.
pub const EMPTINESS: f64 = 0.5;
/// Opening from which a wing is open, standard deviations; ours.
pub const OPENING: f64 = 1.0;

/// Half width of the body, standard deviations of the PV; ours.
const BODY: f64 = 0.5;
/// Share of a sine that lies within half a standard deviation; closed form.
const BODY_OF_SINE: f64 = 0.230_053_456_162_615_88;
/// Smallest number of samples; ours.
const FEWEST_SAMPLES: usize = 50;

static METHOD: Method = Method {
    name: "butterfly",
    title: "Butterfly shape",
    source: "Kamaruddin, Zabiri et al., J. Process Control 87 (2020), not read; plot as read in a public \
             implementation, statistic and threshold ours",
    statistic: "W, emptiness of the body",
    rule: "sticks if W reaches the threshold 0.5 (ours) and both wings are open; else undecided",
    applies: Applies::SelfRegulating,
    decides: Decides::Stiction,
    needs: Needs::OpAndPv,
    family: Family::PhasePlot,
    explains_oscillation: false,
};

/// The method with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Butterfly {
    /// Emptiness of the body from which there are wings.
    pub emptiness: f64,
    /// Opening from which a wing is open, standard deviations.
    pub opening: f64,
    /// Cutoff of the low pass, share of the Nyquist frequency; none by default.
    pub cutoff: Option<f64>,
}

impl Default for Butterfly {
    fn default() -> Self {
        Self { emptiness: EMPTINESS, opening: OPENING, cutoff: None }
    }
}

/// The result of the method.
#[derive(Debug, Clone, PartialEq)]
pub struct ButterflyResult {
    /// PV(k) in standard deviations, from the second sample.
    pub pv: Vec<f64>,
    /// |OP(k) - PV(k-1)| in standard deviations, from the second sample.
    pub distance: Vec<f64>,
    /// Share of samples in the body.
    pub body: f64,
    /// Emptiness of the body, W.
    pub emptiness: f64,
    /// Openings of the wings of low and high PV, standard deviations.
    pub openings: [f64; 2],
    /// The decision.
    pub decision: Decision,
    /// Cautions.
    pub caveats: Vec<String>,
}

impl Butterfly {
    /// Runs the method.
    ///
    /// # Errors
    /// If the method does not apply or there are fewer than 50 samples.
    pub fn run(&self, subject: &Subject<'_>) -> Result<ButterflyResult, Abstention> {
        let caveats = subject.check(&METHOD)?;
        let Some(pv) = &subject.segment.pv else {
            return Err(Abstention("needs the PV, which is not recorded".to_owned()));
        };
        if pv.len() < FEWEST_SAMPLES {
            return Err(Abstention(format!(
                "needs at least {FEWEST_SAMPLES} samples; there are {}",
                pv.len()
            )));
        }
        let normalised = |x: &[f64]| {
            let filtered = self.cutoff.map(|cutoff| low_passed(x, cutoff));
            standardised(filtered.as_deref().unwrap_or(x))
                .filter(|x| x.iter().all(|v| v.is_finite()))
                .ok_or_else(|| {
                    Abstention("a signal does not move, or its values are extreme".into())
                })
        };
        let (mut pv, op) = (normalised(pv)?, normalised(&subject.segment.op)?);
        let distance: Vec<f64> = op[1..].iter().zip(&pv).map(|(op, pv)| (op - pv).abs()).collect();
        pv.remove(0);
        let body = pv.iter().filter(|v| v.abs() < BODY).count() as f64 / pv.len() as f64;
        let emptiness = 1.0 - body / BODY_OF_SINE;
        let openings = [-1.0, 1.0].map(|side| {
            let wing: Vec<f64> = pv
                .iter()
                .zip(&distance)
                .filter(|(pv, _)| side * **pv >= BODY)
                .map(|(_, d)| *d)
                .collect();
            if wing.is_empty() { 0.0 } else { quantile(&wing, 0.95) - quantile(&wing, 0.05) }
        });
        let open = openings.iter().all(|opening| *opening >= self.opening);
        let decision = if emptiness >= self.emptiness && open {
            Decision::Sticks
        } else {
            Decision::Undecided
        };
        Ok(ButterflyResult { pv, distance, body, emptiness, openings, decision, caveats })
    }
}

impl Detector for Butterfly {
    fn method(&self) -> &'static Method {
        &METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        let mut numbers = vec![
            Number::new("emptiness", self.emptiness, ""),
            Number::new("opening", self.opening, "sd"),
        ];
        numbers.extend(self.cutoff.map(|cutoff| Number::new("cutoff", cutoff, "of Nyquist")));
        numbers
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let result = self.run(subject)?;
        let reason = format!(
            "the emptiness of the body between the wings is W = {:.2} (0 for a sine, 1 for a square wave; threshold \
             {}). The wings open by {:.2} and {:.2} standard deviations",
            result.emptiness, self.emptiness, result.openings[0], result.openings[1]
        );
        let numbers = vec![
            Number::new("W", result.emptiness, ""),
            Number::new("share in the body", result.body, ""),
            Number::new("opening at low PV", result.openings[0], "sd"),
            Number::new("opening at high PV", result.openings[1], "sd"),
        ];
        let finding = Finding::new(
            &METHOD,
            result.decision,
            result.emptiness,
            self.emptiness,
            reason,
            numbers,
        );
        let caveats = result.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(result)), ..finding })
    }
}
