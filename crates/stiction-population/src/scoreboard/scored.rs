//! What is kept of a diagnosis to be counted.

use stiction_diagnose::diagnose::{Diagnosis, Estimate, Ruling, VerdictClass};
use stiction_diagnose::finding::{Decision, Method};

/// What is true of a loop, by its label or by its simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Which valve it is; recordings of one valve are judged together, too.
    pub valve: String,
    /// What kind of loop it is, such as `saturation`; empty where that is not known.
    pub kind: String,
    /// Whether the valve sticks.
    pub sticks: bool,
    /// Whether the recording can show it. What sticks invisibly is left out of all measures.
    pub visible: bool,
    /// Stick band plus dead band, percent of span, where it is known.
    pub s: Option<f64>,
    /// Slip jump, percent of span, where it is known.
    pub j: Option<f64>,
    /// What shows of a member of a mixed population; `None` of other loops: labelled ones, and those that were added
    /// so that there are enough of their kind.
    pub member: Option<Member>,
}

/// What the record of a member of a mixed population shows of its valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member {
    /// What an observer who knows the stem gains, nats, as in [`population::Truth`](crate::Truth::gain).
    pub gain: f64,
    /// How often the stem began to move.
    pub slips: usize,
}

/// What a method says of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Said {
    /// The method.
    pub method: &'static Method,
    /// The number the decision rests on; the larger, the more it speaks for sticking.
    pub statistic: Option<f64>,
    /// The value of the statistic from which the decision is positive.
    pub threshold: Option<f64>,
    /// What it decides.
    pub decision: Decision,
}

/// A loop of known truth with what was said of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scored {
    /// Name of the recording.
    pub name: String,
    /// What is true of it.
    pub truth: Truth,
    /// What each method says that was asked, in the order of the registry.
    pub methods: Vec<Said>,
    /// The conclusion.
    pub verdict: VerdictClass,
    /// The rule by which the evidence decided nothing; `None` where something else, or it, decided.
    pub undecided_by: Option<Ruling>,
    /// The probability that the valve sticks, where there is one.
    pub probability: Option<f64>,
    /// The estimate of S, percent of span.
    pub s: Option<Estimate>,
    /// The estimate of J, percent of span.
    pub j: Option<Estimate>,
    /// The upper limit of S, percent of span.
    pub s_below: Option<f64>,
}

impl Said {
    /// The score that ranks loops: the statistic, unless the method abstains although it has one, as where
    /// there is no oscillation whose cause it could tell.
    pub fn score(&self) -> Option<f64> {
        self.statistic.filter(|_| self.decision != Decision::Abstains)
    }
}

impl Scored {
    /// What a diagnosis says of a loop whose truth is known.
    pub fn new(diagnosis: &Diagnosis, truth: Truth) -> Self {
        let said = diagnosis.findings.iter().map(|finding| Said {
            method: finding.method,
            statistic: finding.statistic,
            threshold: finding.threshold,
            decision: finding.decision,
        });
        Self {
            name: diagnosis.name.clone(),
            truth,
            methods: said.collect(),
            verdict: diagnosis.verdict.class,
            undecided_by: diagnosis.undecided_by(),
            probability: diagnosis.verdict.probability,
            s: diagnosis.stiction.s,
            j: diagnosis.stiction.j,
            s_below: diagnosis.verdict.s_below.map(|limit| limit.value),
        }
    }

    /// The verdict as a decision. That a valve does not respond accuses it as that it sticks does.
    pub fn decision(&self) -> Decision {
        match self.verdict {
            VerdictClass::Sticks | VerdictClass::DoesNotRespond => Decision::Sticks,
            VerdictClass::DoesNotStick => Decision::DoesNotStick,
            VerdictClass::CannotTell => Decision::Undecided,
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A loop of which nothing is known but that its valve is healthy.
    pub fn truth() -> Truth {
        Truth {
            valve: String::new(),
            kind: String::new(),
            sticks: false,
            visible: false,
            s: None,
            j: None,
            member: None,
        }
    }

    /// What is said of a loop, by no method but the verdict.
    pub fn scored(truth: Truth, verdict: VerdictClass, probability: Option<f64>) -> Scored {
        Scored {
            name: String::new(),
            truth,
            methods: vec![],
            verdict,
            undecided_by: None,
            probability,
            s: None,
            j: None,
            s_below: None,
        }
    }
}
