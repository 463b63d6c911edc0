//! Kano's methods A and B.
//!
//! # What it measures
//! A: the share of the time in which the OP travels and the valve rests. B: the width of the parallelogram of OP
//! and valve position. C, qualitative patterns of both, is counted by [`Yamashita`](super::yamashita::Yamashita).
//!
//! # Assumptions
//! The valve position is recorded, or the PV is a flow that follows it at once.
//!
//! # Equations
//! With `u` the OP and `x` the position, or the flow instead of it:
//! ```text
//! A:  rho = share of the samples at rest: x stays within its tolerance (four standard deviations of
//!           its noise, at least a quantum) while u travels by more than least_travel of its span
//! B:  F(k) = clamp(F(k-1) + u(k) - u(k-1), 0, w),   x_w = u - F
//!     width = the w from 0 to the span of u for which x_w explains most of x: r^2 of both is largest
//! ```
//! The thresholds of the paper are unknown, so it is always undecided. Without stiction rho and width are about zero.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `least_travel` | share of the OP's span | 0.05 | ours |
//!
//! # Limits
//! A lag or a dead time between valve and flow widens the parallelogram. The search for the width uses a grid that
//! is refined once, to 0.2 % of the OP's span.
//!
//! # Deviations from the paper
//! Recalled, not read; public programs named after Kano have other rules. A counts how long the position rests while
//! the OP's changes add up, and B reconstructs the position through a dead band of unknown width. Tolerances and the
//! search are ours.
//!
//! # References
//! M. Kano, H. Maruta, H. Kugemoto, K. Shimizu, Practical model and detection algorithm for valve
//! stiction, IFAC DYCOPS (2004).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::shapes::representable;
use super::shared::stuck::{StuckSpan, find_rests};
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::recording::LoopType;
use crate::series::{centred, span};

/// Widths per search step.
const WIDTHS: usize = 32;

/// Kano's methods with their parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kano {
    /// Share of its span by which the OP must travel during a rest.
    pub least_travel: f64,
}

impl Default for Kano {
    fn default() -> Self {
        Self { least_travel: 0.05 }
    }
}

/// The result of Kano's methods.
#[derive(Debug, Clone, PartialEq)]
pub struct KanoResult {
    /// Share of the samples at rest, by method A.
    pub statistic: f64,
    /// Always undecided: no threshold is known.
    pub decision: Decision,
    /// The rests of method A.
    pub rests: Vec<StuckSpan>,
    /// Width of the parallelogram, percent of OP, by method B.
    pub width: f64,
    /// Share of the variance of the position that is explained with that width.
    pub explained: f64,
    /// Share that is explained without a dead band.
    pub explained_without: f64,
    /// The signal that replaces the position, `VP` or `PV`.
    pub follower: &'static str,
    /// Cautions.
    pub caveats: Vec<String>,
}

/// For a dead band of each width, the share of the variance of `x` that `u` explains. Both signals are less their
/// means.
fn explained(u: &[f64], x: &[f64], widths: &[f64; WIDTHS]) -> [f64; WIDTHS] {
    let (mut sp, mut pp, mut px) = ([0.0; WIDTHS], [0.0; WIDTHS], [0.0; WIDTHS]);
    let (mut f, mut before) = (widths.map(|w| 0.5 * w), u.first().copied().unwrap_or(0.0));
    let mut xx = 0.0;
    for (&u, &x) in u.iter().zip(x) {
        let step = u - before;
        before = u;
        xx += x * x;
        for i in 0..WIDTHS {
            f[i] = (f[i] + step).max(0.0).min(widths[i]);
            // Less half the width, so that the sums stay small.
            let position = u - f[i] + 0.5 * widths[i];
            sp[i] += position;
            pp[i] += position * position;
            px[i] += position * x;
        }
    }
    let n = u.len() as f64;
    std::array::from_fn(|i| px[i] * px[i] / ((pp[i] - sp[i] * sp[i] / n) * xx))
}

impl Kano {
    /// The description of this method.
    pub const METHOD: Method = Method {
        name: "kano",
        title: "Kano's methods A and B",
        source: "Kano, Maruta, Kugemoto, Shimizu, IFAC DYCOPS (2004); recalled, not read",
        statistic: "share of the time at rest, rho of method A",
        rule: "none, because the thresholds of the paper are unknown",
        applies: Applies::AnyLoop,
        decides: Decides::Stiction,
        needs: Needs::Op,
        family: Family::Patterns,
        explains_oscillation: false,
    };

    /// Compares the OP with the valve position, or with a flow if no position is recorded.
    ///
    /// # Errors
    /// If neither signal is recorded, or the recorded one never moves.
    pub fn run(&self, subject: &Subject<'_>) -> Result<KanoResult, Abstention> {
        let mut caveats = subject.check(&Self::METHOD)?;
        let segment = subject.segment;
        let (follower, x) = match (&segment.vp, &segment.pv, subject.loop_type) {
            (Some(vp), _, _) => ("VP", vp),
            (None, Some(pv), LoopType::Flow) => ("PV", pv),
            (None, Some(pv), LoopType::Unknown) => {
                caveats.push(
                    "the loop's type is not known; its PV is assumed to be the flow through the valve"
                        .to_owned(),
                );
                ("PV", pv)
            }
            _ => {
                return Err(Abstention(
                    "needs the valve position, or the PV of a flow loop".to_owned(),
                ));
            }
        };
        if span(x) == 0.0 {
            return Err(Abstention(format!("the {follower} never moves")));
        }
        let u = &segment.op;
        let range = span(u);
        let found = find_rests(u, x, self.least_travel * range);
        let at_rest: usize = found.spans.iter().map(|span| span.end - span.first).sum();
        let statistic = representable(at_rest as f64 / u.len() as f64)?;

        let (uc, xc) = (centred(u), centred(x));
        let (mut low, mut high) = (0.0, range);
        let (mut best, mut without) = ((0.0, 0.0), 0.0);
        for round in 0..2 {
            let widths: [f64; WIDTHS] =
                std::array::from_fn(|i| low + (high - low) * i as f64 / WIDTHS as f64);
            let shares = explained(&uc, &xc, &widths);
            if round == 0 {
                without = shares[0];
            }
            let i = (0..WIDTHS).fold(0, |a, b| if shares[b] > shares[a] { b } else { a });
            best = (widths[i], shares[i]);
            (low, high) = (widths[i.saturating_sub(1)], widths.get(i + 1).copied().unwrap_or(high));
        }
        Ok(KanoResult {
            statistic,
            decision: Decision::Undecided,
            rests: found.spans,
            width: best.0,
            explained: representable(best.1)?,
            explained_without: representable(without)?,
            follower,
            caveats,
        })
    }
}

impl Detector for Kano {
    fn method(&self) -> &'static Method {
        &Self::METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![Number::new("least travel", self.least_travel, "")]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let r = self.run(subject)?;
        let reason = format!(
            "the {} rests {:.0} % of the time while the OP travels. With a dead band of {:.2} % of OP, the OP \
             explains {:.0} % of the variance, without a dead band {:.0} % (no threshold is known)",
            r.follower,
            100.0 * r.statistic,
            r.width,
            100.0 * r.explained,
            100.0 * r.explained_without
        );
        let numbers = vec![
            Number::new("rho", r.statistic, ""),
            Number::new("width", r.width, "%"),
            Number::new("explained", r.explained, ""),
            Number::new("explained without", r.explained_without, ""),
        ];
        let finding = Finding::new(&Self::METHOD, r.decision, r.statistic, 0.0, reason, numbers);
        let caveats = r.caveats.clone();
        let looked_at = Some(LookedAt::new(r));
        Ok(Finding { threshold: None, caveats, looked_at, ..finding })
    }
}
