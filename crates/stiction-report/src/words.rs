//! The verdict in words that an operator and a mechanic understand, the same on a terminal and in a report.

use crate::report::moment::moment;
use std::collections::BTreeSet;
use stiction_diagnose::diagnose::change::{Event, present_since};
use stiction_diagnose::diagnose::{
    Basis, Diagnosis, Estimate, Fault, Grade, Override, Ruling, Silence, VerdictClass, Weighing,
    thresholds,
};
use stiction_diagnose::recording::fitness::{Class, MeasureId};
use stiction_diagnose::recording::{RangeSource, Segment};
use stiction_diagnose::spoken::{self, number};

pub use stiction_diagnose::spoken::{percent, unparted as spoken};

/// The meaning of the probability of a verdict.
pub const PROBABILITY: &str = "The probability covers only sticking that the recording can show. An S below the detection limit may go undetected.";

/// A rough number with two digits and a typographic minus.
pub fn rough(value: f64) -> String {
    if value.is_finite() { spoken::rough(value).replace('-', "\u{2212}") } else { number(value) }
}

/// A clause as a sentence, with a capital letter and a full stop.
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

/// The range of the OP, if neither the user nor the file states it, such as `of an estimated OP range (0 to 27648)`.
/// S and all other amounts in percent depend on it.
pub fn guessed_range(diagnosis: &Diagnosis) -> Option<String> {
    let range = diagnosis.op_range.filter(|range| range.source.is_guess())?;
    let source = if range.source == RangeSource::Assumed { "assumed" } else { "estimated" };
    let ends = [range.low, range.high].map(|end| spoken::cell(end).replace('-', "\u{2212}"));
    Some(format!("of an {source} OP range ({} to {})", ends[0], ends[1]))
}

/// The sentence on a guessed range beside S or its limit; empty if the range is known.
fn span(diagnosis: &Diagnosis) -> String {
    let amount = diagnosis.stiction.s.is_some() || diagnosis.verdict.s_below.is_some();
    let Some((of, range)) = guessed_range(diagnosis).zip(diagnosis.op_range).filter(|_| amount)
    else {
        return String::new();
    };
    let span = range.high - range.low;
    match range.spans {
        [narrowest, widest] if narrowest < span || widest > span => format!(
            "Percentages are {of}. The interval allows for spans of {} to {}.",
            rough(narrowest),
            rough(widest)
        ),
        _ => format!("Percentages are {of}."),
    }
}

/// The verdict in a few sentences.
pub fn verdict(diagnosis: &Diagnosis) -> String {
    join([verdict_alone(diagnosis), changes(diagnosis), span(diagnosis)])
}

/// The changes of the valve within the recording.
fn changes(diagnosis: &Diagnosis) -> String {
    let by_windows = matches!(diagnosis.verdict.basis, Basis::Evidence | Basis::OpAlone);
    let Some(evidence) = diagnosis.evidence.as_ref().filter(|_| by_windows) else {
        return String::new();
    };
    let since = present_since(&evidence.changes);
    let of = |event: &Event| {
        let words = sentence(&event.words(|at| moment(diagnosis, at)));
        let counts = if event.time == since { " Only the windows since then count." } else { "" };
        words + counts
    };
    evidence.changes.iter().map(of).collect::<Vec<_>>().join(" ")
}

/// The verdict without the doubt about the range of the OP.
fn verdict_alone(diagnosis: &Diagnosis) -> String {
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
            "The valve does not respond: the OP moves, but the measured position does not. The valve may be seized, \
             shut off, or without power or air, or the position transmitter may be dead."
                .to_owned()
        }
        (class, Basis::ValveTest) => by_test(diagnosis, class),
        (VerdictClass::DoesNotRespond, _) => no_response(diagnosis),
        (VerdictClass::CannotTell, _) => cannot_tell(diagnosis),
        (_, Basis::OpAlone) => op_alone(diagnosis),
        (VerdictClass::Sticks, _) => {
            let likely = sure.map_or(String::new(), |p| format!(" ({p})"));
            join([format!("The valve most likely sticks{likely}."), band(diagnosis)])
        }
        (VerdictClass::DoesNotStick, _) => {
            let left = sure.map_or(String::new(), |p| format!(" (probability of sticking {p})"));
            let cause = verdict.alternatives.first().map_or(String::new(), |other| {
                format!("The most likely explanation is {}.", cause(other.cause.name()))
            });
            let says = match verdict.s_below.filter(|_| verdict.grade == Grade::NoneVisible) {
                Some(limit) => format!(
                    "No stiction is visible{left}. This recording could mask an S of up to {} % ({:.0} % confidence).",
                    rough(limit.value),
                    100.0 * limit.confidence
                ),
                None => join([
                    format!("The valve most likely does not stick{left}."),
                    limit(diagnosis),
                ]),
            };
            join([says, cause])
        }
    }
}

/// The verdict by the valve test in the recording, and the operation before it.
fn by_test(diagnosis: &Diagnosis, class: VerdictClass) -> String {
    let shows = "The valve test in this recording shows that the valve";
    let sure = diagnosis.verdict.shown_probability().map(percent);
    match class {
        VerdictClass::Sticks => {
            let likely = sure.map_or(String::new(), |p| format!(" ({p})"));
            join([format!("{shows} sticks{likely}."), band(diagnosis)])
        }
        VerdictClass::DoesNotRespond => {
            "The valve did not respond to the turns of the test in this recording. The valve may be seized, shut off, or \
             without power or air."
                .to_owned()
        }
        VerdictClass::DoesNotStick | VerdictClass::CannotTell => {
            let left = match sure {
                Some(p) => format!(" (probability of sticking {p})"),
                None => " by more than the limit".to_owned(),
            };
            join([format!("{shows} does not stick{left}."), limit(diagnosis)])
        }
    }
}

/// The name of a cause within a sentence.
pub(crate) fn cause(name: &str) -> String {
    match name {
        "no response" => "a valve that does not respond".to_owned(),
        "aggressive tuning" => "aggressive controller tuning".to_owned(),
        "quantisation" => "coarse resolution of the transmitter or the historian".to_owned(),
        "saturation" => "an OP at its limits".to_owned(),
        "set-point changes" => "set-point changes".to_owned(),
        "process nonlinearity" => "a process whose gain changes".to_owned(),
        "load that ramps and resets" => "a cyclic load (batch dump, backwash)".to_owned(),
        "external oscillation" => "an external oscillation".to_owned(),
        "external wave with corners" => "an external wave with corners".to_owned(),
        "dead zone elsewhere" => "backlash or a dead zone elsewhere in the loop".to_owned(),
        "sticking valve" => "a sticking valve".to_owned(),
        _ => name.to_owned(),
    }
}

/// The meaning of S and J at the valve; empty if S is unknown.
fn band(diagnosis: &Diagnosis) -> String {
    let Some(s) = diagnosis.stiction.s else { return String::new() };
    let stays = format!(
        "After a reversal the stem stands still until the OP has travelled about {} % ({} to {})",
        rough(s.value),
        rough(s.low),
        rough(s.high)
    );
    match diagnosis.stiction.j {
        Some(j) if j.value > 0.0 => format!("{stays}, then jumps by about {} %.", rough(j.value)),
        Some(_) => format!("{stays}, then follows."),
        None => format!("{stays}. J could not be estimated."),
    }
}

fn op_alone(diagnosis: &Diagnosis) -> String {
    let verdict = &diagnosis.verdict;
    let alone = "judged by the pattern of the OP alone. Without the PV this cannot be proven";
    match (verdict.grade, verdict.probability) {
        (Grade::ProbablySticks, Some(p)) => {
            format!("The valve probably sticks ({}), {alone}.", percent(p))
        }
        (Grade::ProbablyFine, Some(p)) => format!(
            "The valve is probably fine (probability of sticking {}), {alone}.",
            percent(p)
        ),
        _ => "The pattern of the OP leaves open whether the valve sticks. The PV is needed for a better answer."
            .to_owned(),
    }
}

/// Possible faults of a loop that does not respond.
fn no_response(diagnosis: &Diagnosis) -> String {
    let silence = diagnosis.silence().unwrap_or(Silence::Unmoved);
    let says = match silence {
        Silence::AtItsLowEnd => {
            "The valve does not respond: the OP moves, but the PV stays at its low end."
        }
        Silence::AtItsHighEnd => {
            "The valve does not respond: the OP moves, but the PV stays at its high end."
        }
        Silence::Frozen => {
            "The PV does not respond: it is frozen away from its set point while the OP moves."
        }
        Silence::Unmoved => {
            "The valve does not respond: the OP moves, and the PV moves without relation to it."
        }
    };
    let faults: Vec<&str> = Fault::behind(silence).iter().map(|fault| fault.name()).collect();
    format!("{says} Possible faults, most likely first: {}.", faults.join("; "))
}

/// The most important reason why the answer is open; empty if there is an answer.
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
    found.unwrap_or("the evidence is insufficient".to_owned())
}

fn cannot_tell(diagnosis: &Diagnosis) -> String {
    let verdict = &diagnosis.verdict;
    let why = why(diagnosis);
    if diagnosis.mistaken().is_some() {
        return format!(
            "The columns of the recording are probably wrong, so the valve is not judged: {why}."
        );
    }
    if verdict.basis == Basis::ValvePosition {
        return format!("The measured position leaves open whether the valve sticks: {why}.");
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
                "The valve probably sticks ({}), but this recording alone does not prove it: {why}.",
                percent(p)
            ),
            band(diagnosis),
        ]),
        (Grade::TooLittle, _) => format!("The valve sticks too little to matter: {why}."),
        (Grade::ProbablyFine, Some(p)) => format!(
            "The valve is probably fine (probability of sticking {}), but this recording does not clear it: {why}.",
            percent(p)
        ),
        (_, Some(p)) => {
            let limits = diagnosis.evidence.as_ref().map_or_else(thresholds, Weighing::thresholds);
            let says = match p {
                p if p <= limits.clear => "the probability is {}, but the valve is not cleared",
                p if p >= limits.accuse => "the probability is {}, but the valve is not accused",
                _ => "the probability is {}",
            };
            let says = says.replace("{}", &percent(p));
            format!("Whether the valve sticks is unclear: {says}; {why}.")
        }
        (_, None) => format!("Whether the valve sticks is unclear: {why}."),
    }
}

/// Advice on a better recording or a test; `None` if there is an answer.
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
            "Record OP, PV and SP in automatic, uncompressed, over at least ten cycles.".to_owned(),
        );
    };
    if verdict.basis == Basis::ValvePosition {
        // The remedy is stated with the reason why the position is inconclusive.
        return verdict.reasons.get(1).map(|reason| sentence(reason));
    }
    // No position is requested if one was recorded.
    let position = match segment.vp {
        None => "a recorded valve position",
        Some(_) => "a position of this valve",
    };
    if let Some(remedy) = too_little(diagnosis) {
        return Some(remedy);
    }
    if let Some(few) = &diagnosis.few_slips {
        let step = rough(few.step);
        return Some(format!(
            "A test of the valve or {position} may decide. OP steps of one size, {step} %, are seldom conclusive."
        ));
    }
    let ask = match diagnosis.undecided_by() {
        Some(Ruling::Mistaken) => {
            return Some(format!(
                "Check the assignment of the columns. OP and PV of one loop, {position}, or a test of the valve may \
                 decide."
            ));
        }
        Some(Ruling::Strange) => {
            return Some(format!(
                "Only {position} or a test of the valve can decide. A longer recording would not help, because the \
                 recording is unlike the simulated loops."
            ));
        }
        Some(Ruling::Harmless) => {
            return Some(format!(
                "If certainty is needed, {position} or a test of the valve may decide."
            ));
        }
        Some(Ruling::Blind) => {
            "a recording with more OP travel, such as at a changing load or set point".to_owned()
        }
        _ => match recording(diagnosis, segment) {
            Some(better) => better,
            None => {
                return Some(format!(
                    "A test of the valve or {position} may decide. A longer recording rarely helps: at eight times the length, \
                     one in five undecided simulated loops was decided."
                ));
            }
        },
    };
    // The likeliest to decide goes first (`docs/accuracy-loops.md`, Advice followed). No test can be planned without a PV.
    Some(match segment.pv {
        None => sentence(&format!("{ask}, or {position}, may decide")),
        Some(_) => sentence(&format!("a test of the valve, {position}, or {ask} may decide")),
    })
}

/// The remedy for data that are unfit because they contain too little of the OP; `None` for other data.
fn too_little(diagnosis: &Diagnosis) -> Option<String> {
    let mut unfit = diagnosis.fitness.measures.iter().filter(|m| m.class == Class::Unfit);
    unfit.find_map(|measure| match measure.id {
        MeasureId::Samples => {
            measure.caveat_at.map(|least| format!("Record at least {least:.0} samples."))
        }
        MeasureId::OpMoves => Some("Choose another time, in which the OP moves.".to_owned()),
        _ => None,
    })
}

/// The properties of a better recording, if there are any. Of 672 undecided loops of the population 15 % were decided by
/// twice the record, 17 % by four times, 21 % by eight times (example `record_longer` of the population).
fn recording(diagnosis: &Diagnosis, segment: &Segment) -> Option<String> {
    let period = diagnosis.oscillation().filter(|(_, o)| o.found).and_then(|(_, o)| o.period_s);
    let mut wants = vec![];
    let few = diagnosis
        .fitness
        .measures
        .iter()
        .find(|measure| measure.id == MeasureId::Samples && measure.class != Class::Fit);
    if let Some(least) = few.and_then(|measure| measure.caveat_at) {
        wants.push(format!("of at least {least:.0} samples"));
    }
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
    (!wants.is_empty()).then(|| format!("a recording {}", wants.join(", ")))
}

/// Properties of a better recording, in the order in which they are requested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Better {
    Uncompressed,
    Finer,
    OffLimits,
    AtRest,
}

impl Better {
    /// The property that would fix an unfit measure. `None` for length and sampling, which are requested with
    /// numbers, and for measures that no recording can fix.
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
            | MeasureId::MaskedValues
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
            Self::Uncompressed => "without compression by the historian",
            Self::Finer => "with more digits",
            Self::OffLimits => "at a load at which OP and PV are within their limits",
            Self::AtRest => "with the set point at rest",
        }
    }
}

/// The conclusion of a person, to be shown beside the computed verdict.
pub fn overruled(overruled: &Override) -> String {
    let mut who = overruled.by.clone().map_or("a person".to_owned(), |by| by.trim().to_owned());
    if let Some(day) = &overruled.entered {
        who += &format!(" on {day}");
    }
    format!(
        "Overruled by {who}: the valve {} ({}). The override holds for {} ({}).",
        verb(overruled.verdict),
        overruled.reason.trim_end_matches('.'),
        overruled.scope,
        overruled.kept_in
    )
}

fn verb(verdict: VerdictClass) -> &'static str {
    match verdict {
        VerdictClass::CannotTell => "cannot be judged",
        verb => verb.name(),
    }
}

/// The detection limit of a cleared valve.
fn limit(diagnosis: &Diagnosis) -> String {
    match diagnosis.verdict.s_below {
        Some(limit) => format!(
            "Stiction with S above {} % would have been detected ({:.0} % confidence).",
            rough(limit.value),
            100.0 * limit.confidence
        ),
        None => "The detection limit of S is unknown.".to_owned(),
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
