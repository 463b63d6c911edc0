//! Yamashita's patterns of OP against valve position.
//!
//! # What it measures
//! How often the OP moves while the valve does not. Each step of both signals is coded as increasing
//! (I), steady (S) or decreasing (D); a sticking valve spends its time in the patterns IS and DS.
//!
//! # Assumptions
//! A signal that follows the valve at once: its measured position, or the PV of a fast flow loop. In a slow loop
//! the PV lags behind and the patterns are meaningless. The method, made for self-regulating loops, therefore warns
//! if the loop is not a flow.
//!
//! # Equations
//! The differences of either signal from sample to sample, less their mean, over their standard deviation, are I above
//! `dead_zone`, D below `-dead_zone`, else S. Of `T` steps, `t(..)` counts the steps with a pattern (OP, position):
//! ```text
//! rho1 = (t(IS) + t(DS)) / (T - t(SS))
//! rho2 = as rho1, but of the runs of IS only those that II or SI follows, of DS those before DD or SD
//! rho3 = rho1 without the runs of IS that DD, DI, SD, ID or DS follows, and without their mirrors
//! ```
//! rho1 above 0.25 sticks, else not: of eight patterns other than SS two count, so chance gives 0.25. rho2 and rho3
//! are reported beside it.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `threshold` | none | 0.25 | Yamashita 2006, recalled, not read |
//! | `dead_zone` | standard deviations | 0.5 | ours |
//! | `follower` | | PV | ours; optionally the recorded valve position |
//!
//! # Limits
//! Sensitive to the sample time: below about eight samples a cycle patterns blur, and far above, noise makes them.
//! Dead time and lag between valve and PV look like stiction.
//!
//! # Deviations from the paper
//! Recalled, not read; no public program with these patterns was found. The decision by rho1 and not rho3 is ours: at
//! 0.25 rho1 agrees with the known state of eight of nine recorded loops, rho3 of four.
//!
//! # References
//! Y. Yamashita, An automatic method for detection of valve stiction in process control loops, Control
//! Engineering Practice 14 (2006) 503-510.

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::recording::LoopType;
use crate::series::span;

/// The signal that follows the valve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Follower {
    /// The PV instead of the flow.
    #[default]
    Pv,
    /// The measured valve position.
    Vp,
}

/// Yamashita's patterns with threshold and dead zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Yamashita {
    /// Above it, rho1 indicates stiction.
    pub threshold: f64,
    /// Steps within this many standard deviations of their mean count as steady.
    pub dead_zone: f64,
    /// The signal that follows the valve.
    pub follower: Follower,
}

impl Default for Yamashita {
    fn default() -> Self {
        Self { threshold: 0.25, dead_zone: 0.5, follower: Follower::Pv }
    }
}

/// The result of Yamashita's patterns.
#[derive(Debug, Clone, PartialEq)]
pub struct YamashitaResult {
    /// rho1, which decides.
    pub statistic: f64,
    /// Threshold of the statistic.
    pub threshold: f64,
    /// The verdict.
    pub decision: Decision,
    /// The signal that follows the valve.
    pub follower: Follower,
    /// Steps up to this many standard deviations were steady.
    pub dead_zone: f64,
    /// Share of the OP's movement without a response that is then followed by one in the same direction.
    pub rho2: f64,
    /// rho1 without patterns that stiction cannot cause.
    pub rho3: f64,
    /// Number of steps with each pattern, by the OP's symbol in the order D, S, I, then by the follower's symbol.
    pub patterns: [[usize; 3]; 3],
    /// Symbols of the OP's steps: -1, 0, 1.
    pub op_symbols: Vec<i8>,
    /// Symbols of the follower's steps.
    pub follower_symbols: Vec<i8>,
    /// Cautions.
    pub caveats: Vec<String>,
}

/// The symbols of the steps of `x`; `None` if all steps are equal.
fn symbols(x: &[f64], dead_zone: f64) -> Option<Vec<i8>> {
    let steps: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let steps = crate::series::standardised(&steps)?;
    let code = |step: &f64| i8::from(*step > dead_zone) - i8::from(*step < -dead_zone);
    Some(steps.iter().map(code).collect())
}

/// Steps in runs of IS and DS: those that a jump follows, and those that something else follows.
fn runs(u: &[i8], x: &[i8]) -> (usize, usize) {
    let (mut jumps, mut others) = (0, 0);
    let mut k = 0;
    while k < u.len() {
        if u[k] == 0 || x[k] != 0 {
            k += 1;
            continue;
        }
        let (begin, way) = (k, u[k]);
        while k < u.len() && u[k] == way && x[k] == 0 {
            k += 1;
        }
        if k < u.len() {
            match (u[k] * way, x[k] * way) {
                (1 | 0, 1) => jumps += k - begin,
                (0, 0) => {}
                _ => others += k - begin,
            }
        }
    }
    (jumps, others)
}

impl Yamashita {
    /// The description of this method.
    pub const METHOD: Method = Method {
        name: "yamashita",
        title: "Yamashita's patterns",
        source: "Yamashita, Control Eng. Practice 14 (2006) 503-510; recalled, not read; dead zone \
                 ours",
        statistic: "rho1",
        rule: "sticks if rho1 exceeds 0.25",
        applies: Applies::SelfRegulating,
        decides: Decides::Stiction,
        needs: Needs::OpAndPv,
        family: Family::Patterns,
        explains_oscillation: false,
    };

    /// The method on the measured valve position, for loops of any kind.
    pub const METHOD_VP: Method = Method {
        name: "yamashita-vp",
        title: "Yamashita's patterns on the valve position",
        applies: Applies::AnyLoop,
        needs: Needs::OpAndVp,
        family: Family::Measured,
        explains_oscillation: false,
        ..Self::METHOD
    };

    /// Counts patterns.
    ///
    /// # Errors
    /// If the method does not apply, or a signal moves in equal steps.
    pub fn run(&self, subject: &Subject<'_>) -> Result<YamashitaResult, Abstention> {
        let mut caveats = subject.check(self.method())?;
        let segment = subject.segment;
        let (name, follower) = match self.follower {
            Follower::Pv => ("PV", segment.pv.as_deref()),
            Follower::Vp => ("valve position", segment.vp.as_deref()),
        };
        let follower = follower.unwrap_or_default();
        if span(follower) == 0.0 {
            return Err(Abstention(format!("the {name} never moves")));
        }
        if self.follower == Follower::Pv
            && !matches!(subject.loop_type, LoopType::Flow | LoopType::Unknown)
        {
            caveats.push(format!(
                "made for flow loops, whose PV follows the valve at once; the type of this loop is {}",
                subject.loop_type.name()
            ));
        }
        let result = self.count(&segment.op, follower)?;
        Ok(YamashitaResult { caveats, ..result })
    }

    /// Counts patterns of an OP and a signal that follows the valve.
    ///
    /// # Errors
    /// If a signal moves in equal steps, or both are steady throughout.
    pub fn count(&self, op: &[f64], follower: &[f64]) -> Result<YamashitaResult, Abstention> {
        let n = op.len().min(follower.len());
        let equal =
            || Abstention("a signal moves in equal steps, which have no pattern".to_owned());
        let u = symbols(&op[..n], self.dead_zone).ok_or_else(equal)?;
        let x = symbols(&follower[..n], self.dead_zone).ok_or_else(equal)?;
        let mut patterns = [[0; 3]; 3];
        for (u, x) in u.iter().zip(&x) {
            patterns[(u + 1) as usize][(x + 1) as usize] += 1;
        }
        let moving = u.len() - patterns[1][1];
        if moving == 0 {
            return Err(Abstention("every step is within the dead zone".to_owned()));
        }
        let share = |count: usize| count as f64 / moving as f64;
        let (jumps, others) = runs(&u, &x);
        let silent = patterns[0][1] + patterns[2][1];
        let statistic = share(silent);
        let sticks = statistic > self.threshold;
        Ok(YamashitaResult {
            statistic,
            threshold: self.threshold,
            decision: if sticks { Decision::Sticks } else { Decision::DoesNotStick },
            follower: self.follower,
            dead_zone: self.dead_zone,
            rho2: share(jumps),
            rho3: share(silent - others),
            patterns,
            op_symbols: u,
            follower_symbols: x,
            caveats: vec![],
        })
    }
}

impl Detector for Yamashita {
    fn method(&self) -> &'static Method {
        match self.follower {
            Follower::Pv => &Self::METHOD,
            Follower::Vp => &Self::METHOD_VP,
        }
    }

    fn parameters(&self) -> Vec<Number> {
        vec![
            Number::new("threshold", self.threshold, ""),
            Number::new("dead zone", self.dead_zone, "standard deviations"),
        ]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let r = self.run(subject)?;
        let name = match self.follower {
            Follower::Pv => "PV",
            Follower::Vp => "valve position",
        };
        let reason = format!(
            "in {:.0} % of the steps with movement, the OP moves and the {name} does not: rho1 is {:.3} (sticks \
             above {:.2}), rho2 {:.3}, rho3 {:.3}",
            100.0 * r.statistic,
            r.statistic,
            r.threshold,
            r.rho2,
            r.rho3
        );
        let numbers = vec![
            Number::new("rho1", r.statistic, ""),
            Number::new("rho2", r.rho2, ""),
            Number::new("rho3", r.rho3, ""),
        ];
        let finding =
            Finding::new(self.method(), r.decision, r.statistic, r.threshold, reason, numbers);
        let caveats = r.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(r)), ..finding })
    }
}
