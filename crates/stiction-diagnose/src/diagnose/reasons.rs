//! Evidence in sentences with numbers.

use super::verdict::Alternative;
use super::weighing::Weighing;
use crate::evidence::{Evidence, Line};
use crate::fusion::Cause;
use crate::spoken::{percent, rough};

/// Alternatives below this likelihood are not listed.
const LEAST_LIKELIHOOD: f64 = 0.01;

/// A line of evidence: its name, the probability from it alone, and a sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Saying {
    /// The line.
    pub line: Line,
    /// The probability of a fault by this line alone.
    pub probability: f64,
    /// The evidence in words.
    pub sentence: String,
}

/// The lines in the order of [`Line::WEIGHED`].
pub fn sayings(weighing: &Weighing) -> Vec<Saying> {
    let evidence = weighing.typical();
    let of = |(line, probability): &(Line, f64)| Saying {
        line: *line,
        probability: *probability,
        sentence: format!(
            "{} alone: {} ({})",
            line.name(),
            percent(*probability),
            match line {
                Line::Model => models(evidence),
                Line::Patterns => patterns(evidence, *probability),
                _ => shapes(evidence, *probability),
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
        return "a sticking valve predicts the PV no better than a healthy valve".to_owned();
    }
    let placebo = (100.0 * (1.0 - (-fits.reversed_gain).exp())).max(0.0);
    format!(
        "the {} model with S = {} % and J = {} % cuts the PV's prediction error by {saved:.0} %; on time-reversed \
         data, the control, by {placebo:.0} %",
        best.model.describe().name,
        rough(s),
        rough(best.j_over_s * s),
    )
}

/// Observations that agree with the probability of their line, then observations that disagree. Each is given with
/// whether it is evidence of sticking.
fn agreeing(parts: Vec<(bool, String)>, probability: f64, none: &str) -> String {
    let (with, against): (Vec<_>, Vec<_>) =
        parts.into_iter().partition(|(sticks, _)| *sticks == (probability >= 0.5));
    let joined = |parts: Vec<(bool, String)>| {
        parts.into_iter().map(|(_, part)| part).collect::<Vec<_>>().join("; ")
    };
    match (with.is_empty(), against.is_empty()) {
        (true, true) => none.to_owned(),
        (false, true) => joined(with),
        (true, false) => format!("all features together, although {}", joined(against)),
        (false, false) => format!("{}, although {}", joined(with), joined(against)),
    }
}

fn patterns(evidence: &Evidence, probability: f64) -> String {
    let value = |name: &str| evidence.get(name).filter(|v| v.is_finite());
    let mut parts = vec![];
    if let Some(rho) = value("rho1") {
        let text = format!(
            "the OP moves and the PV does not in {:.0} % of the steps with movement; 25 % is expected by chance",
            100.0 * rho
        );
        parts.push((rho > 0.25, text));
    }
    if let Some(travel) = value("rest_travel").filter(|travel| *travel > 0.0) {
        let text = format!(
            "the PV rests while the OP travels up to {} %",
            rough(travel * evidence.op_span)
        );
        parts.push((true, text));
    }
    if value("pv_constant").is_some_and(|constant| constant > 0.0) {
        parts.push((true, "the PV never moves while the OP does".to_owned()));
    }
    agreeing(parts, probability, "no pattern could be counted")
}

fn shapes(evidence: &Evidence, probability: f64) -> String {
    let value = |name: &str| evidence.get(name).filter(|v| v.is_finite());
    let nearer = |index: f64| match index {
        i if i >= 0.55 => "closer to triangles",
        i if i <= 0.45 => "closer to sines",
        _ => "between sines and triangles",
    };
    let mut parts = vec![];
    for (signal, name) in [("OP", "op_triangle"), ("error", "error_triangle")] {
        if let Some(index) = value(name) {
            let text = format!("the {signal}'s half waves are {}, index {index:.2}", nearer(index));
            // Between the two an index is no evidence, so it contradicts neither.
            let sticks =
                if (0.45..0.55).contains(&index) { probability >= 0.5 } else { index > 0.5 };
            parts.push((sticks, text));
        }
    }
    agreeing(parts, probability, "too few waves")
}

/// Other possible causes, the likeliest first, without the concluded one.
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

/// The evidence for a cause, and how to distinguish it.
fn because(cause: Cause, evidence: &Evidence) -> String {
    let share = |name: &str| {
        let value = evidence.get(name).filter(|v| v.is_finite());
        value.map(|v| format!("{:.0} %", 100.0 * v))
    };
    match cause {
        Cause::StickingValve => {
            "small OP steps in manual may show stiction: a sticking valve responds late and with a jump"
                .to_owned()
        }
        Cause::NoResponse => {
            "check whether the stem moves when the OP does. Check the air supply, the block valves and the sensor \
             first"
                .to_owned()
        }
        Cause::AggressiveTuning => {
            "an oscillation from tuning is sinusoidal, stops in manual, and fades when the controller gain is \
             halved"
                .to_owned()
        }
        Cause::ExternalOscillation => {
            "an external oscillation continues in manual; find a neighbouring loop with the same period"
                .to_owned()
        }
        Cause::ExternalWave => {
            "another sticking valve upstream also sends waves with corners, which would continue in manual; find a \
             loop with the same period that leads this loop"
                .to_owned()
        }
        Cause::ResettingLoad => {
            "a cyclic load (backwash, batch dump, relief) also makes waves with corners: check what is switched \
             when the PV jumps"
                .to_owned()
        }
        Cause::DeadZoneElsewhere => {
            "play in the sensor's linkage or a gap in the controller looks much like a dead band of the valve: \
             watch the stem itself while the OP steps"
                .to_owned()
        }
        Cause::Quantisation => format!(
            "the PV rests {}: a coarse transmitter or historian causes this without stiction. Record with a finer \
             resolution",
            share("pv_still").map_or("often".to_owned(), |of| format!("in {of} of the samples"))
        ),
        Cause::Saturation => format!(
            "the OP is at its limits{}, so the valve cannot give the demanded flow",
            share("op_at_limit").map_or(String::new(), |of| format!(" for {of} of the time"))
        ),
        Cause::SetPointChanges => match (share("sp_moves"), share("sp_explains")) {
            (Some(moves), Some(explains)) => format!(
                "the set point moves in {moves} of the samples and explains {explains} of the PV's variance"
            ),
            _ => "the SP is not recorded and may have moved: export the SP".to_owned(),
        },
        Cause::ProcessNonlinearity => {
            "a process gain that changes along the wave distorts the wave without friction: compare small and large \
             steps, up and down"
                .to_owned()
        }
        Cause::NormalOperation => {
            "the controller may only be rejecting ordinary disturbances".to_owned()
        }
    }
}
