//! A report on diagnosed loops.

use super::evidence;
use super::layout::{Badge, Block, Fact, Report, Section, Table, number};
use super::moment::moment;
use super::views::{self, Context};
use super::{fitted, head, verdict};
use crate::Error;
use crate::document::{self, Loop, Source};
use crate::valve_test_page;
use crate::words::{self, sentence, spoken};
use stiction_diagnose::diagnose::{Diagnosis, Estimate};
use stiction_diagnose::finding::{Decision, Finding};
use stiction_diagnose::oscillation::{self, Oscillation};
use stiction_diagnose::recording::fitness::Class;

/// The report on loops as one self-contained HTML page. The loops are in the order of [`Diagnosis::rank`], the worst
/// first.
///
/// # Errors
/// If a figure cannot be drawn. This is not expected, because signals out of range are left out.
pub fn html(tool: &str, loops: &[Loop<'_>]) -> Result<String, Error> {
    report(tool, &by_rank(loops)).html()
}

/// Loops, the worst first.
pub(super) fn by_rank<'a>(loops: &[Loop<'a>]) -> Vec<Loop<'a>> {
    let mut ranked = loops.to_vec();
    ranked.sort_by(Loop::in_rank);
    ranked
}

/// The report on loops, in the given order.
pub(super) fn report(tool: &str, ranked: &[Loop<'_>]) -> Report {
    let title = match ranked {
        [one] => format!("Diagnosis of {}", one.diagnosis.name),
        several => format!("Diagnosis of {} control loops", several.len()),
    };
    let tool = format!("{tool}, format version {}", document::VERSION);
    let mut report = Report::new(title, tool).introduction(INTRODUCTION);
    for case in ranked {
        report = report.source(case.source).with(section(case));
    }
    report
}

const INTRODUCTION: &str = "This report shows whether the valve of a control loop sticks, judged from its recording. \
                            The figures show the evidence of each method.";

pub(super) fn section(case: &Loop<'_>) -> Section {
    let Loop { diagnosis, source, fitted } = *case;
    let badge = Badge::from(diagnosis.verdict.grade);
    let mut section = Section::new(&diagnosis.name, badge, words::verdict(diagnosis));
    let overruled = diagnosis.verdict.overruled.as_ref();
    section.reasons = overruled.map(words::overruled).into_iter().collect();
    let context = Context::of(diagnosis);
    section.head = Some(head::head(diagnosis, source, &context, fitted));

    section = section
        .fold("Why", |inside| verdict::why(why(inside, diagnosis), diagnosis))
        .fold("The test", |inside| match diagnosis.deciding_test() {
            Some(test) => valve_test_page::of_test(inside, test, &context),
            None => verdict::confirm(inside, diagnosis),
        })
        .fold("Fitted loop and effects of actions", |inside| match fitted {
            Some(fitted) => fitted::added_to(inside, fitted, diagnosis.pv_unit.as_deref()),
            None => inside,
        })
        .fold("Over time", |inside| verdict::windows(inside, diagnosis))
        .fold("The signals: map, correlation, spectrum", |inside| {
            recorded(inside, diagnosis, &context)
        })
        .fold("Data quality", |inside| quality(inside, diagnosis))
        .fold("S and J, also by other definitions", |inside| verdict::size(inside, diagnosis));
    let votes = diagnosis.findings.len();
    section
        .fold(format!("Every method ({votes}), with its evidence"), |inside| {
            let inside = evidence(methods(inside, diagnosis), diagnosis, &context);
            inside.with(parameters(diagnosis))
        })
        .fold("Oscillation", |inside| oscillations(inside, diagnosis))
        .fold("Key figures", |inside| inside.with(key_figures(diagnosis)))
        .fold("Where the data come from", |inside| data(inside, diagnosis, source))
}

/// The basis of the verdict, and results that are not in the head.
fn why(section: Section, diagnosis: &Diagnosis) -> Section {
    section.list(reasons(diagnosis)).with(Block::Facts(facts(diagnosis)))
}

/// Figures of the recording.
fn recorded(section: Section, diagnosis: &Diagnosis, context: &Context<'_>) -> Section {
    let Some(judged) = &diagnosis.judged else { return section };
    // A figure that cannot be drawn is left out.
    let views = views::all(&diagnosis.grid.segments, judged.segment, context);
    section.with_all(views.into_iter().filter(|figure| figure.check().is_ok()))
}

/// The measures that are not fit, and all measures on demand.
fn quality(section: Section, diagnosis: &Diagnosis) -> Section {
    let measures = &diagnosis.fitness.measures;
    let lacking = measures.iter().filter(|measure| measure.class != Class::Fit);
    let items: Vec<String> = lacking
        .map(|measure| {
            format!(
                "{}: {}",
                sentence(measure.id.name()).trim_end_matches('.'),
                sentence(&measure.reason)
            )
        })
        .collect();
    let section = match items.is_empty() {
        true => section.paragraph(format!("All {} measures are fit.", measures.len())),
        false => section.list(items),
    };
    section.with(Block::details("All measures, with their limits", fitness(diagnosis)))
}

fn reasons(diagnosis: &Diagnosis) -> Vec<String> {
    let mut reasons: Vec<String> = vec![];
    if diagnosis.fitness.class == Class::Caveats {
        reasons.extend(diagnosis.fitness.reasons.iter().map(|r| format!("Caveat: {r}.")));
    }
    if diagnosis.stiction.s.is_none() {
        let why = diagnosis.stiction.why_not.as_ref();
        reasons.extend(
            why.map(|why| format!("S and J are not known: {}.", why.trim_end_matches('.'))),
        );
    }
    reasons
}

fn facts(diagnosis: &Diagnosis) -> Vec<Fact> {
    let votes = diagnosis.verdict.votes;
    let mut facts: Vec<Fact> = verdict::probability(diagnosis).into_iter().collect();
    let estimate = |name: &str, estimate: Option<Estimate>| {
        estimate.map(|estimate| Fact::new(name, words::interval(estimate), ""))
    };
    facts.extend(estimate("S, stick band plus dead band", diagnosis.stiction.s));
    facts.extend(estimate("J, slip jump", diagnosis.stiction.j));
    facts.extend(diagnosis.verdict.s_below.map(|limit| {
        let name = format!("upper limit of S ({:.0} % confidence)", 100.0 * limit.confidence);
        Fact::new(name, words::rough(limit.value), "%")
    }));
    facts.extend([
        Fact::new("basis", diagnosis.verdict.basis.name(), ""),
        Fact::new("families of methods that find stiction", votes.sticks, ""),
        Fact::new("families that find none", votes.does_not_stick, ""),
        Fact::new("undecided", votes.undecided, ""),
        Fact::new("abstaining", votes.abstains, ""),
    ]);
    if let Some((signal, found)) = diagnosis.oscillation() {
        let finite = |value: Option<f64>| value.filter(|v| v.is_finite());
        facts.extend(finite(found.period_s).map(|p| Fact::new("period", spoken(p), "")));
        facts.extend(finite(found.amplitude).map(|a| {
            Fact::new(format!("amplitude of the {signal}"), number(a), unit_of(signal, diagnosis))
        }));
        facts.extend(finite(found.cycles).map(|c| Fact::new("cycles", number(c), "")));
    }
    facts.push(Fact::new("data", Badge::from(diagnosis.fitness.class).text(), ""));
    facts.push(Fact::new("type of loop", diagnosis.loop_type.name(), ""));
    if let Some(segment) = diagnosis.segment() {
        let judged_s = diagnosis.judged_s().unwrap_or(segment.duration());
        facts.push(Fact::new("judged", spoken(judged_s), ""));
        if diagnosis.start.is_some() {
            facts.push(Fact::new("from", moment(diagnosis, segment.from), ""));
        }
        facts.push(Fact::new("samples", segment.len(), ""));
        facts.push(Fact::new("sample time", spoken(segment.sample_time), ""));
    }
    facts
}

fn unit_of(signal: &str, diagnosis: &Diagnosis) -> String {
    match signal {
        "OP" => "%".to_owned(),
        _ => pv_unit(diagnosis).to_owned(),
    }
}

fn pv_unit(diagnosis: &Diagnosis) -> &str {
    diagnosis.pv_unit.as_deref().unwrap_or("PV units")
}

/// A value with its unit; a dash for a missing value.
fn measured(value: Option<f64>, unit: &str) -> String {
    let text = optional(value);
    if value.is_some() && !unit.is_empty() { format!("{text}\u{a0}{unit}") } else { text }
}

fn optional(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), number)
}

fn fitness(diagnosis: &Diagnosis) -> Table {
    let table =
        Table::new("").columns("measure | #value | #caveat at | #unfit at | class | meaning");
    diagnosis.fitness.measures.iter().fold(table, |table, measure| {
        table.row([
            measure.id.name().to_owned(),
            measured(measure.value, measure.unit),
            measured(measure.caveat_at, measure.unit),
            measured(measure.unfit_at, measure.unit),
            Badge::from(measure.class).text(),
            sentence(&measure.reason),
        ])
    })
}

/// A table with the results of all methods, and one with those that abstain.
fn methods(section: Section, diagnosis: &Diagnosis) -> Section {
    let deciding =
        Table::new("Methods marked with a diamond test only for linearity and have no vote.")
            .columns("method | decision | statistic | #value | #threshold | reason");
    let abstaining = Table::new("").words("method").words("reason for abstaining");
    let (silent, speaking): (Vec<&Finding>, Vec<&Finding>) =
        diagnosis.findings.iter().partition(|f| f.decision == Decision::Abstains);
    let deciding = speaking.iter().fold(deciding, |table, finding| {
        table.row([
            finding.method.title.to_owned(),
            Badge::from(finding.decision).text(),
            finding.method.statistic.to_owned(),
            optional(finding.statistic),
            optional(finding.threshold),
            sentence(&finding.reason),
        ])
    });
    let count = silent.len();
    let abstaining = silent.into_iter().fold(abstaining, |table, finding| {
        table.row([finding.method.title.to_owned(), sentence(&finding.reason)])
    });
    let abstaining = Block::details(format!("{count} methods abstain"), abstaining);
    let section = section.heading("Results of the methods");
    let section = section.with_all((!speaking.is_empty()).then_some(deciding));
    section.with_all((count > 0).then_some(abstaining))
}

/// The cards of all methods that do not abstain, in the order of sticks, does not stick, undecided.
fn evidence(section: Section, diagnosis: &Diagnosis, context: &Context<'_>) -> Section {
    let place = |decision: Decision| match decision {
        Decision::Sticks => 0,
        Decision::Nonlinear => 1,
        Decision::DoesNotStick => 2,
        Decision::Linear => 3,
        _ => 4,
    };
    let mut findings: Vec<&Finding> =
        diagnosis.findings.iter().filter(|f| f.decision != Decision::Abstains).collect();
    if findings.is_empty() {
        return section;
    }
    findings.sort_by_key(|finding| place(finding.decision));
    let subject = diagnosis.subject();
    let cards = findings.into_iter().map(|f| evidence::card(f, subject.as_ref(), context));
    section.heading("Evidence").with_all(cards)
}

fn oscillations(mut section: Section, diagnosis: &Diagnosis) -> Section {
    let signals = [
        ("error", diagnosis.oscillations.error.as_ref()),
        ("OP", diagnosis.oscillations.op.as_ref()),
    ];
    let signals: Vec<(&str, &Oscillation)> =
        signals.into_iter().filter_map(|(name, found)| Some((name, found?))).collect();
    if signals.is_empty() {
        return section;
    }
    let mut table = Table::new("")
        .columns("signal | oscillates | period | #amplitude | #cycles | #regularity [regular above 1] | #decay ratio \
             [lasting above 0.5] | #supervision [oscillates above 10] | found by");
    let mut peaks = Table::new("Oscillations with a peak in the spectrum, strongest first.")
        .columns(
            "signal | period | #amplitude | #share of the variance [%] | #regularity | remark",
        );
    let mut episodes = Table::new("Episodes of the dominant oscillation.")
        .columns("signal | from | to | #half waves | #amplitude");
    for (signal, found) in &signals {
        let unit = unit_of(signal, diagnosis);
        table = table.row([
            (*signal).to_owned(),
            if found.found { "yes" } else { "not clearly" }.to_owned(),
            found.period_s.map_or("–".to_owned(), spoken),
            measured(found.amplitude, &unit),
            optional(found.cycles),
            optional(found.regularity),
            optional(found.decay_ratio),
            optional(found.supervised.map(|supervised| supervised.counter)),
            match found.basis {
                Some(oscillation::OscillationBasis::Autocorrelation) => "autocorrelation",
                Some(oscillation::OscillationBasis::SpectralPeak) => "peak of the spectrum",
                None => "–",
            }
            .to_owned(),
        ]);
        for peak in &found.peaks {
            peaks = peaks.row([
                (*signal).to_owned(),
                spoken(peak.period_s),
                measured(Some(peak.amplitude), &unit),
                number(100.0 * peak.share),
                optional(peak.regularity),
                peak.harmonic
                    .map_or(String::new(), |n| format!("harmonic {n} of a stronger oscillation")),
            ]);
        }
        for episode in &found.episodes {
            episodes = episodes.row([
                (*signal).to_owned(),
                moment(diagnosis, episode.from_s),
                moment(diagnosis, episode.to_s),
                episode.half_waves.to_string(),
                measured(Some(episode.amplitude), &unit),
            ]);
        }
    }
    section = section.with(table);
    for (signal, found) in &signals {
        let reasons: Vec<String> = found.reasons.iter().map(|r| sentence(r)).collect();
        if !reasons.is_empty() {
            let text = format!("{}: {}", sentence(signal).trim_end_matches('.'), reasons.join(" "));
            section = section.paragraph(text);
        }
    }
    let more = [peaks, episodes].into_iter().filter(|table| !table.rows.is_empty());
    section.with_all(more.map(shortened))
}

/// A table; a long one is folded.
fn shortened(table: Table) -> Block {
    const MOST: usize = 12;
    if table.rows.len() <= MOST {
        return table.into();
    }
    let summary = format!("{} ({} rows)", table.caption.trim_end_matches('.'), table.rows.len());
    Block::details(summary, Table { caption: String::new(), ..table })
}

fn key_figures(diagnosis: &Diagnosis) -> Table {
    let table = Table::new("").words("key figure").numbers("value", "").words("meaning");
    diagnosis.kpis.numbers.iter().fold(table, |table, kpi| {
        let unit = match kpi.unit.strip_prefix("PV") {
            Some(rest) => format!("{}{rest}", pv_unit(diagnosis)),
            None => kpi.unit.to_owned(),
        };
        table.row([
            kpi.name.to_owned(),
            measured(kpi.value, &unit),
            [Some(kpi.meaning), kpi.note.as_deref()]
                .into_iter()
                .flatten()
                .map(sentence)
                .collect::<Vec<_>>()
                .join(" "),
        ])
    })
}

fn data(section: Section, diagnosis: &Diagnosis, source: &Source) -> Section {
    let grid = &diagnosis.grid;
    let section = section.with(Block::Facts(vec![
        Fact::new("file", &source.file, ""),
        Fact::new("SHA-256", &source.sha256, ""),
        Fact::new("recorded", spoken(grid.duration), ""),
        Fact::new("in automatic", number(100.0 * grid.closed_share), "%"),
    ]));
    let rows = diagnosis.understood.rows(&|at| moment(diagnosis, at));
    let notes = diagnosis.notes.iter().map(|note| Block::Paragraph(sentence(note)));
    section.with(Table::understood("", &rows)).with_all(notes)
}

/// The rule, the source and the parameters of every method.
fn parameters(diagnosis: &Diagnosis) -> Block {
    let table = Table::new("").columns("method | name | family | rule | parameters | source");
    let table = diagnosis.findings.iter().fold(table, |table, finding| {
        let method = finding.method;
        let parameters: Vec<String> = finding
            .parameters
            .iter()
            .map(|p| format!("{} = {} {}", p.name, number(p.value), p.unit).trim_end().to_owned())
            .collect();
        table.row([
            method.title.to_owned(),
            method.name.to_owned(),
            method.family.name().to_owned(),
            sentence(method.rule),
            parameters.join("; "),
            sentence(method.source),
        ])
    });
    Block::details("All methods with their rules, parameters and sources", table)
}
