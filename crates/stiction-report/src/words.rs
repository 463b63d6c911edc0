//! A verdict in words that an operator and a mechanic understand, the same on a terminal and in a report.

use std::collections::BTreeSet;
use stiction_diagnose::diagnose::{
    Basis, Diagnosis, Estimate, Fault, FewSlips, Grade, Override, Ruling, Silence, VerdictClass,
    thresholds,
};
use stiction_diagnose::recording::Segment;
use stiction_diagnose::recording::fitness::{Class, MeasureId};
use stiction_diagnose::spoken::{self, number};

pub use stiction_diagnose::spoken::{percent, unparted as spoken};

/// A number that is known roughly, two digits, with a typographic minus.
pub fn rough(value: f64) -> String {
    if value.is_finite() { spoken::rough(value).replace('-', "\u{2212}") } else { number(value) }
}

/// A sentence of its own: with a capital and a full stop.
pub(crate) fn sentence(clause: &str) -> String {
    let mut chars = clause.chars();
    let first = chars.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    let stop = if clause.ends_with(['.', '!', '?']) { "" } else { "." };
    format!("{first}{}{stop}", chars.as_str())
}

/// A value with its interval, such as `4.1 % (3.4 to 4.9)`.
pub fn interval(estimate: Estimate) -> String {
    format!("{} % ({} to {})", rough(estimate.value), rough(estimate.low), rough(estimate.high))
}

/// The verdict in a sentence or two.
pub fn verdict(diagnosis: &Diagnosis) -> String {
    let verdict = &diagnosis.verdict;
    let sure = verdict.probability.map(percent);
    match (verdict.class, verdict.basis) {
        (VerdictClass::Sticks, Basis::ValvePosition) => {
            join(["The measured position shows that the valve sticks.".to_owned(), band(diagnosis)])
        }
        (VerdictClass::DoesNotStick, Basis::ValvePosition) => {
            let follows = "The measured position shows that the valve follows the controller.";
            join([follows.to_owned(), limit(diagnosis)])
        }
        (VerdictClass::DoesNotRespond, Basis::ValvePosition) => {
            "The valve does not respond: the controller output travels and the measured position does not. It \
             may be stuck fast, shut off, or without power or air; or the position's transmitter may be dead."
                .to_owned()
        }
        (VerdictClass::DoesNotRespond, _) => no_response(diagnosis),
        (VerdictClass::CannotTell, _) => cannot_tell(diagnosis),
        (_, Basis::OpAlone) => op_alone(diagnosis),
        (VerdictClass::Sticks, Basis::Majority) => format!(
            "Preliminary: the loop behaves like one with a sticking valve, say {} of {} families of \
             methods that decide.",
            verdict.votes.sticks,
            verdict.votes.sticks + verdict.votes.does_not_stick
        ),
        (VerdictClass::DoesNotStick, Basis::Majority) => format!(
            "Preliminary: the loop does not behave like one with a sticking valve, say {} of {} \
             families of methods that decide. {}",
            verdict.votes.does_not_stick,
            verdict.votes.sticks + verdict.votes.does_not_stick,
            limit(diagnosis)
        ),
        (VerdictClass::Sticks, _) => {
            let likely = sure.map_or(String::new(), |p| format!(": {p}"));
            join([format!("The valve most likely sticks{likely}."), band(diagnosis)])
        }
        (VerdictClass::DoesNotStick, _) => {
            let left = sure.map_or(String::new(), |p| format!(": the probability that it does is {p}"));
            let cause = verdict.alternatives.first().map_or(String::new(), |other| {
                format!("The likeliest cause of what is seen is {}.", cause(other.cause.name()))
            });
            join([format!("The valve most likely does not stick{left}."), limit(diagnosis), cause])
        }
    }
}

/// The name of a cause in a sentence.
pub(crate) fn cause(name: &str) -> String {
    match name {
        "no response" => "a valve that does not respond".to_owned(),
        "aggressive tuning" => "a controller that is tuned too tightly".to_owned(),
        "quantisation" => "coarse steps of the transmitter or the historian".to_owned(),
        "saturation" => "an output at its limits".to_owned(),
        "set-point changes" => "moves of the set point".to_owned(),
        "process nonlinearity" => "a process whose gain changes".to_owned(),
        "load that ramps and resets" => "a load that builds up and is reset".to_owned(),
        "external oscillation" => "an oscillation that comes in from outside".to_owned(),
        "external wave with corners" => "a wave with corners that comes in from outside".to_owned(),
        "dead zone elsewhere" => "play or a dead zone elsewhere in the loop".to_owned(),
        "sticking valve" => "a sticking valve".to_owned(),
        _ => name.to_owned(),
    }
}

/// What S and J mean for who stands beside the valve; empty if S is not known.
fn band(diagnosis: &Diagnosis) -> String {
    let Some(s) = diagnosis.stiction.s else { return String::new() };
    let stays = format!(
        "It stays put until the controller output has moved about {} % ({} to {})",
        rough(s.value),
        rough(s.low),
        rough(s.high)
    );
    match diagnosis.stiction.j {
        Some(j) if j.value > 0.0 => format!("{stays}, then jumps about {} %.", rough(j.value)),
        Some(_) => format!("{stays}, then follows."),
        None => format!("{stays}; how far it then jumps is not known."),
    }
}

fn op_alone(diagnosis: &Diagnosis) -> String {
    let verdict = &diagnosis.verdict;
    let alone = "by the pattern of the controller output alone; without the PV nothing proves it";
    match (verdict.grade, verdict.probability) {
        (Grade::ProbablySticks, Some(p)) => {
            format!("The valve probably sticks: {}, {alone}.", percent(p))
        }
        (Grade::ProbablyFine, Some(p)) => format!(
            "The valve is probably fine: the probability that it sticks is {}, {alone}.",
            percent(p)
        ),
        _ => "The pattern of the controller output leaves it open whether the valve sticks; without the PV \
              nothing more can be said."
            .to_owned(),
    }
}

/// What does not respond, and what that may be.
fn no_response(diagnosis: &Diagnosis) -> String {
    let silence = diagnosis.silence().unwrap_or(Silence::Unmoved);
    let says = match silence {
        Silence::AtItsLowEnd => {
            "The valve does not respond: the controller output travels and the PV rests at its low end."
        }
        Silence::AtItsHighEnd => {
            "The valve does not respond: the controller output travels and the PV rests at its high end."
        }
        Silence::Frozen => {
            "The PV does not respond: it is frozen, away from its set point, while the controller output travels."
        }
        Silence::Unmoved => {
            "The valve does not respond: the controller output travels, and the PV moves without relation to it."
        }
    };
    let faults: Vec<&str> = Fault::behind(silence).iter().map(|fault| fault.name()).collect();
    format!("{says} It may be, the likeliest first: {}.", faults.join("; "))
}

/// Why it cannot be told, the most important reason alone; empty where something was told.
pub fn why(diagnosis: &Diagnosis) -> String {
    let verdict = &diagnosis.verdict;
    if verdict.class != VerdictClass::CannotTell {
        return String::new();
    }
    let clause = |text: &String| text.trim_start_matches("but ").trim_end_matches('.').to_owned();
    let first = || verdict.reasons.first().map(clause);
    let last = || verdict.reasons.last().map(clause);
    let unfit = || diagnosis.fitness.reasons.first().map(clause);
    let found = match verdict.basis {
        _ if diagnosis.mistaken().is_some() => first(),
        Basis::ValvePosition => first(),
        _ if diagnosis.fitness.class == Class::Unfit => unfit(),
        _ => last(),
    };
    found.unwrap_or("nothing decides".to_owned())
}

fn cannot_tell(diagnosis: &Diagnosis) -> String {
    let verdict = &diagnosis.verdict;
    let why = why(diagnosis);
    if diagnosis.mistaken().is_some() {
        return format!(
            "The columns of the recording look mistaken, so nothing is said of the valve: {why}."
        );
    }
    if verdict.basis == Basis::ValvePosition {
        return format!(
            "Whether the valve sticks cannot be told from its measured position: {why}."
        );
    }
    if diagnosis.fitness.class == Class::Unfit {
        let few = diagnosis.few_slips.as_ref();
        let few = few.map_or(String::new(), |few| format!("The valve {}.", few.words));
        return join([format!("The data cannot answer: {why}."), few]);
    }
    if verdict.basis == Basis::OpAlone {
        return op_alone(diagnosis);
    }
    match (verdict.grade, verdict.probability) {
        (Grade::ProbablySticks, Some(p)) => join([
            format!(
                "The valve probably sticks: {}, which this recording alone does not prove: {why}.",
                percent(p)
            ),
            band(diagnosis),
        ]),
        (Grade::ProbablyFine, Some(p)) => format!(
            "The valve is probably fine: the probability that it sticks is {}; this recording does not clear it: {why}.",
            percent(p)
        ),
        (_, Some(p)) => {
            let says = match p {
                p if p <= thresholds().clear => "makes it {}, but does not clear it",
                p if p >= thresholds().accuse => "makes it {}, but does not accuse it",
                _ => "leaves it at {}",
            };
            let says = says.replace("{}", &percent(p));
            format!("Whether the valve sticks is unclear: the evidence {says}; {why}.")
        }
        (_, None) => format!("Whether the valve sticks is unclear: {why}."),
    }
}

/// What to record so that more can be told; `None` where something was told.
pub fn what_would_answer(diagnosis: &Diagnosis) -> Option<String> {
    let verdict = &diagnosis.verdict;
    if verdict.class != VerdictClass::CannotTell && verdict.basis != Basis::OpAlone {
        return None;
    }
    if let Some(mismatch) = diagnosis.mistaken() {
        return Some(sentence(mismatch.remedy()));
    }
    let Some(segment) = diagnosis.segment() else {
        return Some(
            "A recording with the controller in automatic would answer: OP, PV and SP, uncompressed, over \
             at least ten cycles."
                .to_owned(),
        );
    };
    if verdict.basis == Basis::ValvePosition {
        // What a position lacks is told with why it decides nothing.
        return verdict.reasons.get(1).map(|reason| sentence(reason));
    }
    // A position is not asked for where one was read.
    let position = match segment.vp {
        None => "a recording of the valve position",
        Some(_) => "a position that belongs to this valve",
    };
    if let Some(few) = &diagnosis.few_slips {
        return Some(format!("{}, or {position}, would answer.", missing(few)));
    }
    let ask = match diagnosis.undecided_by() {
        Some(Ruling::Mistaken) => {
            return Some(format!(
                "Look up which column is which: OP and PV of one loop, {position}, or a manual step test would answer."
            ));
        }
        Some(Ruling::Strange) => {
            return Some(format!(
                "More of the same would not help, because the recording is unlike the simulated loops: {position}, \
                 or a manual step test would answer."
            ));
        }
        Some(Ruling::Harmless) => {
            return Some(format!(
                "If it has to be known, {position}, or a manual step test would answer."
            ));
        }
        Some(Ruling::Blind) => {
            "A recording in which the output travels farther, as at a changing load or set \
                                point, or a longer one"
                .to_owned()
        }
        _ => recording(diagnosis, segment),
    };
    Some(format!("{ask}, or {position}, or a manual step test would answer."))
}

/// What slips are missing, as an order.
fn missing(few: &FewSlips) -> String {
    let step = format!("steps of the output by {} % up and down", rough(few.step));
    match few.record_for_s {
        Some(time) => format!("A recording {} longer, or {step}", spoken::time(time)),
        None => format!("Manual {step}"),
    }
}

/// What a better recording would be like.
fn recording(diagnosis: &Diagnosis, segment: &Segment) -> String {
    let period = diagnosis.oscillation().filter(|(_, o)| o.found).and_then(|(_, o)| o.period_s);
    let mut wants = vec![];
    if segment.pv.is_none() {
        wants.push("with the PV".to_owned());
    }
    if let Some(period) = period {
        if segment.duration() < 10.0 * period {
            wants.push(format!("over at least ten cycles ({})", spoken::time(10.0 * period)));
        }
        if period < 8.0 * segment.sample_time {
            wants.push(format!("sampled at least every {}", spoken::time(period / 10.0)));
        }
    }
    let unfit = diagnosis.fitness.measures.iter().filter(|m| m.class != Class::Fit);
    let better: BTreeSet<Better> = unfit.filter_map(|measure| Better::than(measure.id)).collect();
    wants.extend(better.into_iter().map(|better| better.words().to_owned()));
    match (wants.is_empty(), period) {
        (false, _) => format!("A recording {}", wants.join(", ")),
        // It has ten cycles.
        (true, Some(_)) => "A longer recording".to_owned(),
        (true, None) => "A longer recording, at least ten cycles long".to_owned(),
    }
}

/// What makes a recording better, in the order in which it is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Better {
    Uncompressed,
    Finer,
    OffLimits,
    AtRest,
}

impl Better {
    /// What makes a recording better in which a measure is not fit; `None` where its length or its sampling does, which
    /// are asked for with their numbers, or nothing that is recorded.
    fn than(measure: MeasureId) -> Option<Self> {
        match measure {
            MeasureId::CompressionFactor
            | MeasureId::LongestFrozenPv
            | MeasureId::PvUpdatesPerCycle => Some(Self::Uncompressed),
            MeasureId::PvLevels | MeasureId::OpLevels => Some(Self::Finer),
            MeasureId::OpAtLimit | MeasureId::ClippedPv => Some(Self::OffLimits),
            MeasureId::SetPoint => Some(Self::AtRest),
            MeasureId::Samples | MeasureId::Cycles | MeasureId::SamplesPerCycle => None,
            MeasureId::GoodValues
            | MeasureId::BridgedSamples
            | MeasureId::DoubtfulSamples
            | MeasureId::InCommand
            | MeasureId::AutomaticSegment
            | MeasureId::OpMoves
            | MeasureId::PvMoves
            | MeasureId::FitWindows => None,
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Uncompressed => "taken without compression by the historian",
            Self::Finer => "with more digits",
            Self::OffLimits => "at a load where OP and PV stay off their limits",
            Self::AtRest => "with the set point at rest",
        }
    }
}

/// What a person said, beside the computed verdict.
pub fn overruled(overruled: &Override) -> String {
    let mut who = overruled.by.clone().map_or("a person".to_owned(), |by| by.trim().to_owned());
    if let Some(day) = &overruled.entered {
        who += &format!(" on {day}");
    }
    format!(
        "Overruled by {who}: the valve {}, because: {}. This holds for {} ({}).",
        said(overruled.verdict),
        overruled.reason.trim_end_matches('.'),
        overruled.scope,
        overruled.kept_in
    )
}

fn said(verdict: VerdictClass) -> &'static str {
    match verdict {
        VerdictClass::CannotTell => "cannot be judged",
        verb => verb.name(),
    }
}

/// What the recording would have shown, of a valve that is cleared.
fn limit(diagnosis: &Diagnosis) -> String {
    match diagnosis.verdict.s_below {
        Some(limit) => format!(
            "Had it stuck by more than {} %, this recording would have shown it ({:.0} %).",
            rough(limit.value),
            100.0 * limit.confidence
        ),
        None => "By how little it could stick without being seen is not known.".to_owned(),
    }
}

fn join<const N: usize>(sentences: [String; N]) -> String {
    sentences.into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_have_two_digits() {
        for (value, text) in
            [(4.1234, "4.1"), (0.0567, "0.057"), (12.34, "12"), (0.0, "0"), (99.7, "100")]
        {
            assert_eq!(rough(value), text);
        }
        let s = Estimate { value: 4.12, low: 3.41, high: 4.92 };
        assert_eq!(interval(s), "4.1 % (3.4 to 4.9)");
    }
}
