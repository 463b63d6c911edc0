//! The part of a diagnosis that is kept for counting.

use stiction_diagnose::diagnose::{Diagnosis, Estimate, Ruling, VerdictClass};
use stiction_diagnose::finding::{Decision, Method};
use stiction_population::position::PositionTruth;
use stiction_population::{Invented, Invention};

/// The truth about a loop, by its label or by its simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Valve of the recording. Recordings of one valve are also judged together.
    pub valve: String,
    /// Kind of the loop, such as `saturation`; empty if unknown.
    pub kind: String,
    /// Whether the valve sticks.
    pub sticks: bool,
    /// Whether the recording can show the stiction. Invisible stiction is left out of all measures.
    pub visible: bool,
    /// Stick band plus dead band, percent of span, if it is known.
    pub s: Option<f64>,
    /// Slip jump, percent of span, if it is known.
    pub j: Option<f64>,
    /// Visibility for a member of a mixed population; `None` for labelled loops, and for loops added to reach a
    /// sufficient number of their kind.
    pub member: Option<Member>,
}

/// Visibility of the valve in the record of a member of a mixed population.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member {
    /// Gain of an observer who knows the stem, nats, as in [`population::Truth`](stiction_population::Truth::gain).
    pub gain: f64,
    /// Number of slips of the stem.
    pub slips: usize,
}

impl Truth {
    /// Of a loop about which nothing is known.
    pub(super) fn unknown() -> Self {
        Self {
            valve: String::new(),
            kind: String::new(),
            sticks: false,
            visible: false,
            s: None,
            j: None,
            member: None,
        }
    }

    /// The truth about a simulated loop.
    pub fn of_simulated(valve: String, truth: &stiction_population::Truth) -> Self {
        // A valve that is stuck fast has no measurable S. The valve of the inner loop has none for this OP.
        let known = |value: f64| truth.has_bands().then_some(value);
        Self {
            valve,
            kind: truth.kind.name().to_owned(),
            sticks: truth.sticks,
            visible: truth.visible,
            s: known(truth.s),
            j: known(truth.j),
            member: None,
        }
    }

    /// The truth about a member of a mixed population, with its visibility.
    pub fn of_member(valve: String, truth: &stiction_population::Truth) -> Self {
        let member = Some(Member { gain: truth.gain, slips: truth.slips });
        Self { member, ..Self::of_simulated(valve, truth) }
    }

    /// The truth about a loop of a kind outside the population.
    pub fn of_invented(valve: String, what: Invention, made: &Invented) -> Self {
        let state = if made.sticks { "sticking" } else { "healthy" };
        Self {
            valve,
            kind: format!("{}, {state}", what.name()),
            sticks: made.sticks,
            visible: made.visible,
            s: made.sticks.then_some(made.s),
            j: made.sticks.then_some(made.j),
            member: None,
        }
    }

    /// The truth about a loop with a recorded position. A sticking valve counts as visible if it slips ten times and S is
    /// three times the noise of OP and of the position.
    pub fn of_position(valve: String, truth: &PositionTruth) -> Self {
        let rounding = truth.transmitter.quantum / 12f64.sqrt();
        let noise = truth.transmitter.noise.max(rounding).max(truth.op_noise);
        // Healthy valves may have a band, too, which is not stiction.
        let known = |value: f64| truth.sticks.then_some(value);
        let valve_is = if truth.sticks { "sticks" } else { "healthy" };
        let moves = if truth.acts == 1 { "every move recorded" } else { "moves between samples" };
        Self {
            valve,
            kind: format!("{valve_is}, {moves}"),
            sticks: truth.sticks,
            visible: truth.sticks && truth.slips >= 10 && truth.s >= 3.0 * noise,
            s: known(truth.s),
            j: known(truth.j),
            member: None,
        }
    }
}

/// The result of a method for a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodResult {
    /// The method.
    pub method: &'static Method,
    /// The number behind the decision; larger values indicate sticking.
    pub statistic: Option<f64>,
    /// The value of the statistic from which the decision is positive.
    pub threshold: Option<f64>,
    /// Decision.
    pub decision: Decision,
}

/// A loop of known truth with its results.
#[derive(Debug, Clone, PartialEq)]
pub struct Scored {
    /// Name of the recording.
    pub name: String,
    /// Truth.
    pub truth: Truth,
    /// The result of each method that was run, in the order of the registry.
    pub methods: Vec<MethodResult>,
    /// The conclusion.
    pub verdict: VerdictClass,
    /// The rule by which the evidence decided nothing; `None` if it decided, or something else did.
    pub undecided_by: Option<Ruling>,
    /// The probability that the valve sticks, if there is one.
    pub probability: Option<f64>,
    /// The estimate of S, percent of span.
    pub s: Option<Estimate>,
    /// The estimate of J, percent of span.
    pub j: Option<Estimate>,
    /// The upper limit of S, percent of span.
    pub s_below: Option<f64>,
}

impl MethodResult {
    /// The score that ranks loops. It is the statistic, unless the method abstains although it has a statistic, for
    /// example without an oscillation to explain.
    pub fn score(&self) -> Option<f64> {
        self.statistic.filter(|_| self.decision != Decision::Abstains)
    }
}

impl Scored {
    /// The diagnosis of a loop with known truth.
    pub fn new(diagnosis: &Diagnosis, truth: Truth) -> Self {
        let said = diagnosis.findings.iter().map(|finding| MethodResult {
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

    /// The verdict as a decision. "Does not respond" counts as an accusation, just as "sticks" does.
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

    /// A loop that is only known to have a healthy valve.
    pub fn truth() -> Truth {
        Truth::unknown()
    }

    /// The results for a loop, with the verdict alone.
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
