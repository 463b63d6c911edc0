//! The first screen of a loop, with verdict, size, actions and trend.

use super::fitted::Fitted;
use super::layout::{Badge, Fact, Head, Tone};
use super::views::{self, Context};
use crate::document::Source;
use crate::words::{self, percent, rough, sentence, spoken};
use stiction_diagnose::diagnose::{Basis, Cause, Diagnosis, Estimate, Grade};
use stiction_diagnose::fit::prospects::Remedy;
use stiction_diagnose::recording::fitness::{Class, Measure, MeasureId};

/// Number of other causes that are listed.
const CAUSES: usize = 3;
/// Causes less likely than this are not listed.
const LEAST_LIKELY: f64 = 0.01;
/// Likelihood from which another cause is ruled out first.
const WORTH_RULING_OUT: f64 = 0.2;

/// The information that an engineer with three minutes needs.
pub(super) fn head(
    diagnosis: &Diagnosis,
    source: &Source,
    context: &Context<'_>,
    fitted: Option<&Fitted>,
) -> Head {
    let segments = &diagnosis.grid.segments;
    let drawn = |figure: &stiction_figure::Figure| figure.check().is_ok();
    let trend = diagnosis
        .judged
        .as_ref()
        .and_then(|judged| {
            views::head_trend(segments, judged.segment, diagnosis.slips().as_deref(), context)
        })
        .map(|mut trend| {
            if diagnosis.deciding_test().is_some() {
                trend.caption += " The valve test is in a shaded time (see The test).";
            }
            trend
        })
        .filter(drawn);
    let s = diagnosis.stiction.s.map(|s| s.value);
    // The answers of a test that decides are its evidence.
    let map = match diagnosis.deciding_test().filter(|test| !test.steps.is_empty()) {
        Some(test) => Some(views::head_answers(test, context)),
        None => diagnosis.segment().and_then(|segment| views::head_map(segment, s, context)),
    };
    let map = map.filter(drawn);
    Head {
        line: line(diagnosis, source),
        probability: diagnosis.verdict.shown_probability(),
        facts: facts(diagnosis),
        actions: actions(diagnosis, fitted),
        lines: lines(diagnosis),
        lines_are_means: diagnosis.windows.len() > 1,
        causes: causes(diagnosis),
        remarks: remarks(diagnosis),
        cycle: trend.as_ref().and_then(|_| views::cycle_on_axis(segments, context)),
        trend,
        map,
    }
}

/// Type, time, sample time and file.
pub(super) fn line(diagnosis: &Diagnosis, source: &Source) -> String {
    let mut parts = vec![diagnosis.loop_type.name().to_owned()];
    if let Some(test) = diagnosis.deciding_test() {
        let [from, to] = [test.from_s, test.to_s].map(|at| super::moment::moment(diagnosis, at));
        parts.push(format!("valve test from {from} to {to}"));
    } else if let Some(segment) = diagnosis.segment() {
        let (mut from, mut to) = (segment.from, segment.from + segment.duration());
        let judged_s = diagnosis.judged_s().unwrap_or(to - from);
        if judged_s > to - from {
            for window in &diagnosis.windows {
                (from, to) = (from.min(window.from), to.max(window.from + window.duration));
            }
        }
        let date = |at: f64| super::moment::date(diagnosis, at);
        let lasting = spoken(judged_s);
        let has_gaps = judged_s < 0.999 * (to - from);
        parts.push(match (date(from), date(to)) {
            (Some(from), Some(to)) if has_gaps => format!("{lasting} from {from} to {to}"),
            (Some(from), Some(to)) => format!("{from} to {to} ({lasting})"),
            _ => lasting,
        });
        parts.push(format!("every {}", spoken(segment.sample_time)));
    }
    parts.push(source.file.clone());
    parts.join(" | ")
}

pub(super) fn facts(diagnosis: &Diagnosis) -> Vec<Fact> {
    let mut facts = sizes(diagnosis.stiction.s, diagnosis.stiction.j);
    if let Some(limit) = diagnosis.verdict.s_below {
        let name = format!("detection limit of S ({:.0} %)", 100.0 * limit.confidence);
        facts.push(Fact::new(name, rough(limit.value), "%"));
    }
    if let Some((signal, found)) = diagnosis.oscillation()
        && let Some(period) = found.period_s.filter(|p| p.is_finite())
    {
        let unit = match signal {
            "OP" => "%".to_owned(),
            _ => diagnosis.pv_unit.clone().unwrap_or_else(|| "PV units".to_owned()),
        };
        // The error swings like the PV about its set point.
        let signal = if signal == "error" { "PV" } else { signal };
        let swings = found.amplitude.filter(|a| a.is_finite());
        let by = swings.map_or(String::new(), |a| format!("±{} {unit} ", rough(a)));
        facts.push(Fact::new(
            format!("{signal} swings"),
            format!("{by}every {}", spoken(period)),
            "",
        ));
    }
    let travel = diagnosis.kpis.get("OP travel").and_then(|kpi| kpi.value);
    facts.extend(travel.map(|t| Fact::new("OP travel", rough(t), "%/h")));
    facts
}

/// S and J as facts.
pub(super) fn sizes(s: Option<Estimate>, j: Option<Estimate>) -> Vec<Fact> {
    let s = s.map(|s| Fact::new("S, stick band plus dead band", words::interval(s), ""));
    let j = j.map(|j| Fact::new("J, slip jump", words::interval(j), ""));
    s.into_iter().chain(j).collect()
}

/// The actions, most urgent first.
pub(super) fn actions(diagnosis: &Diagnosis, fitted: Option<&Fitted>) -> Vec<String> {
    let prospects = fitted.and_then(|fitted| fitted.prospects.as_ref().ok());
    let unexplained = fitted
        .and_then(|fitted| fitted.fit.cycle.known())
        .is_some_and(|cycle| cycle.explained == Some(false));
    let verdict = &diagnosis.verdict;
    let test = || match (&verdict.confirm, &verdict.no_test) {
        (Some(plan), _) => {
            let most = spoken(plan.total_s);
            format!(
                "Test the valve in manual, {most} at most (stiction test plan prints the sheet)."
            )
        }
        (None, Some(why)) => format!("No test can be planned: {why}."),
        (None, None) => {
            "Test the valve in manual with small OP reversals, and watch the flow or the stem."
                .to_owned()
        }
    };
    // A test or a position that shows the stem needs no confirmation.
    let is_confirmed = matches!(verdict.basis, Basis::ValveTest | Basis::ValvePosition);
    let repair = || {
        let row = prospects.and_then(|found| {
            found.actions.iter().find(|row| row.action == Remedy::Repair && row.certain())
        });
        let what = match row {
            Some(row) => format!("repair the valve. PV swing would fall by {}.", row.fall()),
            None => "inspect packing, actuator and positioner.".to_owned(),
        };
        if is_confirmed { sentence(&what) } else { format!("If confirmed, {what}") }
    };
    let sticks = verdict.probability.unwrap_or(0.0);
    let first = verdict.alternatives.first().filter(|other| {
        !matches!(other.cause, Cause::StickingValve | Cause::NormalOperation)
            && other.likelihood >= WORTH_RULING_OUT.max(sticks)
    });
    let elsewhere =
        || first.map(|other| format!("First rule out {}.", words::cause(other.cause.name())));
    match verdict.grade {
        Grade::Sticks => {
            let mut all = if is_confirmed { vec![] } else { vec![test()] };
            all.push(repair());
            if unexplained {
                all.push(
                    "Look upstream, too. The fitted valve does not explain the swing (see Fitted loop and effects of actions)."
                        .to_owned(),
                );
            }
            all
        }
        Grade::ProbablySticks => vec![test(), repair()],
        Grade::DoesNotRespond => {
            vec!["Check the possible faults.".to_owned()]
        }
        Grade::Unclear => {
            let due = verdict.confirm.is_some() || verdict.no_test.is_some();
            let mut all: Vec<String> = elsewhere().into_iter().collect();
            all.extend(due.then(test));
            all.extend(words::what_would_answer(diagnosis));
            all
        }
        Grade::ProbablyFine | Grade::NoneVisible | Grade::TooLittle | Grade::Fine => {
            let leave = || match verdict.s_below.filter(|_| verdict.grade == Grade::NoneVisible) {
                Some(limit) => format!(
                    "Leave the valve as it is, or test it if an S of up to {} % would matter.",
                    rough(limit.value)
                ),
                None => "Leave the valve as it is.".to_owned(),
            };
            let large = || {
                let plan = verdict.confirm.as_ref()?;
                Some(format!(
                    "If a large S would matter, test the valve in manual for at most {}.",
                    spoken(plan.total_s)
                ))
            };
            let undecided = verdict.grade == Grade::ProbablyFine;
            let mut all = vec![elsewhere().unwrap_or_else(leave)];
            all.extend(undecided.then(large).flatten());
            all
        }
        Grade::CannotAnswer => words::what_would_answer(diagnosis).into_iter().collect(),
    }
}

/// The lines of evidence behind the verdict, with the probability of sticking by each alone.
fn lines(diagnosis: &Diagnosis) -> Vec<(String, f64)> {
    let weighing =
        diagnosis.evidence.as_ref().filter(|_| diagnosis.verdict.basis == Basis::Evidence);
    let lines = weighing.iter().flat_map(|weighing| &weighing.lines);
    lines.map(|(line, probability)| (line.name().to_owned(), *probability)).collect()
}

/// The likeliest causes besides a sticking valve, with their likelihood.
pub(super) fn causes(diagnosis: &Diagnosis) -> Vec<(String, f64)> {
    let others = diagnosis.verdict.alternatives.iter();
    let named = others
        .filter(|other| other.cause != Cause::StickingValve && other.likelihood >= LEAST_LIKELY);
    named.take(CAUSES).map(|other| (other.cause.name().to_owned(), other.likelihood)).collect()
}

/// Remarks on the data.
pub(super) fn remarks(diagnosis: &Diagnosis) -> Vec<String> {
    let fitness = &diagnosis.fitness;
    let caveats = fitness.measures.iter().filter(|m| m.class != Class::Fit).count();
    let mut all = vec![match fitness.class {
        Class::Fit if diagnosis.verdict.grade == Grade::CannotAnswer => {
            "Data: fit, but OP and PV may not belong together".to_owned()
        }
        Class::Fit => "Data: fit".to_owned(),
        Class::Caveats if caveats == 1 => "Data: fit, one caveat".to_owned(),
        Class::Caveats => format!("Data: fit, {caveats} caveats"),
        Class::Unfit => "Data: not fit".to_owned(),
    }];
    // The measure says the same, if it is not fit.
    let counts = |m: &&Measure| m.id == MeasureId::MaskedValues && m.class == Class::Fit;
    if let Some(masked) = fitness.measures.iter().find(counts)
        && !diagnosis.masked.is_empty()
    {
        all.push(sentence(&masked.reason));
    }
    all.extend(fitness.reasons.iter().map(|reason| sentence(reason)));
    all
}

impl Head {
    /// The probability as the length of a bar, and in words.
    pub(super) fn likelihood(&self) -> Option<(f64, String)> {
        let p = self.probability?;
        Some((p.clamp(0.01, 0.99), percent(p)))
    }
}

impl From<Grade> for Badge {
    fn from(grade: Grade) -> Self {
        let (symbol, tone) = match grade {
            Grade::Sticks => ("●", Tone::Bad),
            Grade::DoesNotRespond => ("■", Tone::Bad),
            Grade::ProbablySticks => ("◐", Tone::Warning),
            Grade::Unclear => ("?", Tone::Open),
            Grade::ProbablyFine => ("◌", Tone::Good),
            Grade::NoneVisible => ("◎", Tone::Good),
            Grade::TooLittle => ("◦", Tone::Good),
            Grade::Fine => ("○", Tone::Good),
            Grade::CannotAnswer => ("–", Tone::Open),
        };
        Self { symbol, word: grade.name(), tone }
    }
}
