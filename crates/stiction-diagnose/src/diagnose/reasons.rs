//! Evidence in sentences with its numbers.

use super::verdict::Alternative;
use super::weighing::Weighing;
use crate::evidence::{Evidence, Line};
use crate::fusion::Cause;
use crate::spoken::{percent, rough};

/// Alternatives below this likelihood are not named.
const LEAST_LIKELIHOOD: f64 = 0.01;

/// What a line of evidence says: which, the probability that it gives by itself, and a sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Saying {
    /// The line.
    pub line: Line,
    /// The probability of a fault by this line alone.
    pub probability: f64,
    /// What it saw.
    pub sentence: String,
}

/// What each line says, in the order of [`Line::WEIGHED`].
pub fn sayings(weighing: &Weighing) -> Vec<Saying> {
    let evidence = weighing.typical();
    let of = |(line, probability): &(Line, f64)| Saying {
        line: *line,
        probability: *probability,
        sentence: format!(
            "{}, which alone make it {}: {}",
            line.name(),
            percent(*probability),
            match line {
                Line::Model => models(evidence),
                Line::Patterns => patterns(evidence),
                _ => shapes(evidence),
            }
        ),
    };
    weighing.lines.iter().map(of).collect()
}

fn models(evidence: &Evidence) -> String {
    let Some(fits) = evidence.dense.as_ref().or(evidence.model.as_ref()) else {
        return "no valve model could be fitted".to_owned();
    };
    let best = fits.best();
    let saved = 100.0 * (1.0 - (-best.gain).exp());
    let s = best.s_over_span * evidence.op_span;
    if saved < 0.5 {
        return "a valve that sticks predicts the PV no better than one that follows".to_owned();
    }
    let placebo = (100.0 * (1.0 - (-fits.reversed_gain).exp())).max(0.0);
    format!(
        "a valve by the model {} with S {} % and J {} % leaves {saved:.0} % less of the PV unpredicted than one that \
         follows (the same in reversed time, which proves nothing: {placebo:.0} %)",
        best.model.describe().name,
        rough(s),
        rough(best.j_over_s * s),
    )
}

fn patterns(evidence: &Evidence) -> String {
    let value = |name: &str| evidence.get(name).filter(|v| v.is_finite());
    let mut parts = vec![];
    if let Some(rho) = value("rho1") {
        parts.push(format!(
            "in {:.0} % of the steps in which anything moves the OP moves and the PV does not (chance \
             gives 25 %)",
            100.0 * rho
        ));
    }
    if let Some(travel) = value("rest_travel").filter(|travel| *travel > 0.0) {
        parts.push(format!(
            "the PV rests while the OP travels up to {} %",
            rough(travel * evidence.op_span)
        ));
    }
    if value("pv_constant").is_some_and(|constant| constant > 0.0) {
        parts.push("the PV never moves while the OP does".to_owned());
    }
    match parts.is_empty() {
        true => "no pattern could be counted".to_owned(),
        false => parts.join("; "),
    }
}

fn shapes(evidence: &Evidence) -> String {
    let value = |name: &str| evidence.get(name).filter(|v| v.is_finite());
    let nearer = |index: f64| match index {
        i if i >= 0.55 => "closer to triangles than to sines",
        i if i <= 0.45 => "closer to sines than to triangles",
        _ => "as close to sines as to triangles",
    };
    let mut parts = vec![];
    for (signal, name) in [("OP", "op_triangle"), ("error", "error_triangle")] {
        if let Some(index) = value(name) {
            parts.push(format!(
                "the {signal}'s half waves are {} (index {index:.2})",
                nearer(index)
            ));
        }
    }
    match parts.is_empty() {
        true => "there are too few waves to look at".to_owned(),
        false => parts.join("; "),
    }
}

/// What else it could be, the likeliest first, without what was concluded.
pub fn alternatives(weighing: &Weighing, concluded: Option<Cause>) -> Vec<Alternative> {
    let evidence = weighing.typical();
    let mut others: Vec<Alternative> = weighing
        .causes
        .iter()
        .filter(|(cause, likelihood)| Some(*cause) != concluded && *likelihood >= LEAST_LIKELIHOOD)
        .map(|(cause, likelihood)| Alternative {
            cause: *cause,
            likelihood: *likelihood,
            because: because(*cause, evidence),
        })
        .collect();
    others.sort_by(|a, b| b.likelihood.total_cmp(&a.likelihood));
    others
}

/// What the data show of a cause, and how to tell it apart.
fn because(cause: Cause, evidence: &Evidence) -> String {
    let share = |name: &str| {
        let value = evidence.get(name).filter(|v| v.is_finite());
        value.map(|v| format!("{:.0} %", 100.0 * v))
    };
    match cause {
        Cause::StickingValve => {
            "small steps of the output in manual settle it: a sticking valve answers late and with a jump"
                .to_owned()
        }
        Cause::NoResponse => {
            "look whether the stem moves when the output does: air supply, block valves and the sensor are \
             the first to check"
                .to_owned()
        }
        Cause::AggressiveTuning => {
            "an oscillation that comes from tuning has the shape of a sine, stops in manual, and fades when \
             the controller's gain is halved"
                .to_owned()
        }
        Cause::ExternalOscillation => {
            "it would go on with the controller in manual; look for a loop nearby with the same period"
                .to_owned()
        }
        Cause::ExternalWave => {
            "another valve that sticks upstream sends waves with corners, too: it would go on in manual; look \
             for a loop with the same period that leads this one"
                .to_owned()
        }
        Cause::ResettingLoad => {
            "a load that builds up and is reset, as by fouling and backwash, dumped batches or a relief, makes \
             waves with corners, too: look what is switched when the PV jumps"
                .to_owned()
        }
        Cause::DeadZoneElsewhere => {
            "play in the sensor's linkage or a gap in the controller looks much like a dead band of the \
             valve: watch the stem itself while the output steps"
                .to_owned()
        }
        Cause::Quantisation => format!(
            "the PV rests {}: a coarse transmitter or historian makes steps that no valve \
             made; record with a finer resolution",
            share("pv_still").map_or("often".to_owned(), |of| format!("in {of} of the samples"))
        ),
        Cause::Saturation => format!(
            "the output rests at its limits{}: it cannot give what the loop asks for",
            share("op_at_limit").map_or(String::new(), |of| format!(" for {of} of the time"))
        ),
        Cause::SetPointChanges => match (share("sp_moves"), share("sp_explains")) {
            (Some(moves), Some(explains)) => format!(
                "the set point moves in {moves} of the samples and explains {explains} of the PV's variance"
            ),
            _ => "no set point is recorded, which may have moved: export it".to_owned(),
        },
        Cause::ProcessNonlinearity => {
            "a process gain that changes along the wave bends it without any friction: compare small and \
             large steps, up and down"
                .to_owned()
        }
        Cause::NormalOperation => {
            "the loop may do no more than reject the disturbances that come".to_owned()
        }
    }
}
