//! A diagnosis as a document for programs: what `stiction diagnose --json` prints; and a history, what
//! `stiction history --json` prints.
//!
//! The JSON schema is generated from these types ([`schema`]). Fields are added, never renamed or
//! removed, within one [`VERSION`].

use schemars::JsonSchema;
use serde::Serialize;
use stiction_diagnose::detect::{self, Finding};
use stiction_diagnose::diagnose::{self, Diagnosis};
use stiction_diagnose::fusion::LIMIT;
use stiction_diagnose::oscillation;
use stiction_diagnose::recording::{Repair, fitness};

mod history;

pub use history::{Combined, Contrast, Drift, Point, RepairTest, Valve, ValveHistory};

/// Version of the document's form.
pub const VERSION: u32 = 1;

/// What was found out about some loops.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Document {
    /// The program that made it, with its version.
    pub tool: String,
    /// Version of this form.
    pub version: u32,
    /// The loops in the order of the files, and in them in the order of first appearance.
    pub loops: Vec<Loop>,
}

/// What was found out about one loop.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Loop {
    /// Tag of the loop.
    #[serde(rename = "loop")]
    pub name: String,
    /// Where the recording comes from.
    pub source: Source,
    /// What the loop controls: flow, level, pressure, temperature, analysis, self-regulating,
    /// integrating, or unknown.
    #[serde(rename = "type")]
    pub loop_type: String,
    /// The stretch of the recording that was judged; null if there is none.
    pub judged: Option<Judged>,
    /// What had to be mended in the data.
    pub repairs: Vec<Mended>,
    /// Whether the data can answer.
    pub fitness: Fitness,
    /// The oscillation that speaks for the loop; null without a stretch to judge.
    pub oscillation: Option<Oscillation>,
    /// What each method says.
    pub detectors: Vec<Detector>,
    /// Key figures of the loop.
    pub kpis: Vec<Kpi>,
    /// The likely mistake in the columns; null where OP and PV belong together, as far as can be told.
    pub relation: Option<Relation>,
    /// What the PV does that does not respond; null where it responds, as far as can be told.
    pub no_response: Option<NoResponse>,
    /// The conclusion.
    pub verdict: Verdict,
    /// How much the valve sticks.
    pub stiction: Stiction,
    /// Slips that a record lacks which looks stuck; null where it does not, or has enough.
    pub few_slips: Option<FewSlips>,
    /// The evidence that was weighed, all windows together; null where nothing could be.
    pub evidence: Option<Evidence>,
    /// The windows of the judged stretch that were weighed one by one, in order of time; empty where the
    /// stretch was judged as a whole only.
    pub windows: Vec<Window>,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// Where a recording comes from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Source {
    /// The file as it was named.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

/// The part of a recording that was judged.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Judged {
    /// Time of its first sample, s on the recording's clock.
    pub from_s: f64,
    /// Its duration, s.
    pub duration_s: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// How many of them were bridged.
    pub bridged: usize,
    /// Out of how many stretches it was taken.
    pub stretches: usize,
    /// The signals it has.
    pub signals: Vec<String>,
}

/// Something that had to be mended.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Mended {
    /// The signal, or `time`.
    pub signal: String,
    /// How many samples or steps.
    pub count: usize,
    /// The first place, s on the recording's clock.
    pub first_s: f64,
    /// What was done.
    pub done: String,
}

/// Whether the data can answer.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Fitness {
    /// `fit`, `caveats` or `unfit`.
    pub class: String,
    /// Why it is not `fit`, worst first.
    pub reasons: Vec<String>,
    /// All that was measured.
    pub measures: Vec<Measure>,
}

/// One thing that was measured about the data.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Measure {
    /// Its name.
    pub name: String,
    /// What was found; null where it could not be measured.
    pub value: Option<f64>,
    /// Its unit; empty for a ratio.
    pub unit: String,
    /// Where caveats begin.
    pub caveat_at: Option<f64>,
    /// Where the data become unfit.
    pub unfit_at: Option<f64>,
    /// `fit`, `caveats` or `unfit`.
    pub class: String,
    /// What it means, a sentence.
    pub reason: String,
}

/// The oscillation of a signal.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Oscillation {
    /// The signal it was found in: `error` or `OP`.
    pub signal: String,
    /// Whether the signal oscillates.
    pub found: bool,
    /// Period of the dominant oscillation, s.
    pub period_s: Option<f64>,
    /// Regularity of the zero crossings of its autocorrelation; above 1 is regular.
    pub regularity: Option<f64>,
    /// Decay ratio of its autocorrelation; above 0.5 is oscillatory.
    pub decay_ratio: Option<f64>,
    /// Half of its typical peak-to-peak value, in units of the signal.
    pub amplitude: Option<f64>,
    /// How many periods were seen.
    pub cycles: Option<f64>,
    /// Supervision of the areas between zero crossings; null if nothing was found.
    pub supervision: Option<Supervision>,
    /// All oscillations that were told apart, strongest first.
    pub peaks: Vec<Peak>,
    /// When it oscillates.
    pub episodes: Vec<Episode>,
    /// Why it is, or is not, called an oscillation.
    pub reasons: Vec<String>,
}

/// Hägglund's supervision: half waves whose integrated absolute error is large count as disturbances.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Supervision {
    /// The integrated absolute error from which a half wave counts, in units of the signal times s.
    pub threshold: f64,
    /// Half waves that count.
    pub disturbances: usize,
    /// All half waves.
    pub half_waves: usize,
    /// The largest value of the forgetting counter; above 10 the loop oscillates.
    pub counter: f64,
    /// When the counter first passed that, s on the recording's clock; null if it did not.
    pub alarm_s: Option<f64>,
}

/// One of several simultaneous oscillations.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Peak {
    /// Period, s.
    pub period_s: f64,
    /// Half of its peak-to-peak value, in units of the signal.
    pub amplitude: f64,
    /// Share of the signal's variance in its band.
    pub share: f64,
    /// Regularity in its band.
    pub regularity: Option<f64>,
    /// Which harmonic of a stronger one it may be.
    pub harmonic: Option<usize>,
}

/// A time in which a signal oscillates.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Episode {
    /// Its beginning, s on the recording's clock.
    pub from_s: f64,
    /// Its end, s on the recording's clock.
    pub to_s: f64,
    /// Amplitude in it, in units of the signal.
    pub amplitude: f64,
}

/// What a method says.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Detector {
    /// Its name.
    pub name: String,
    /// Its title.
    pub title: String,
    /// Authors, year, journal; and what of it was recalled, not read.
    pub reference: String,
    /// The number the decision rests on; null if it abstains.
    pub statistic: Option<f64>,
    /// What that number is.
    pub statistic_name: String,
    /// Its value from which the decision is positive.
    pub threshold: Option<f64>,
    /// `sticks`, `does not stick`, `nonlinear`, `linear`, `undecided` or `abstains`.
    pub decision: String,
    /// Whether its decision is counted in the vote of its family.
    pub votes: bool,
    /// What it looks at: methods of one family have one vote together.
    pub family: String,
    /// What the numbers say, or why it abstains.
    pub reason: String,
    /// All its numbers.
    pub numbers: Vec<Number>,
    /// What to keep in mind.
    pub caveats: Vec<String>,
    /// Its parameters as they were set.
    pub parameters: Vec<Number>,
}

/// A named number.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Number {
    /// Its name.
    pub name: String,
    /// Its value; null if it is not finite.
    pub value: Option<f64>,
    /// Its unit; empty for a ratio or a count.
    pub unit: String,
}

/// A key figure.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Kpi {
    /// Its name.
    pub name: String,
    /// Its value; null where it cannot be computed.
    pub value: Option<f64>,
    /// Its unit; empty for a ratio or a count.
    pub unit: String,
    /// What it is.
    pub meaning: String,
    /// What was assumed, or why there is no value.
    pub note: Option<String>,
}

/// A likely mistake in the columns of a recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Relation {
    /// The mistake, such as `PV and OP look exchanged`.
    pub mismatch: String,
    /// What the data show of it.
    pub because: String,
    /// What to do about it.
    pub remedy: String,
}

/// A PV that does not respond.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct NoResponse {
    /// What the PV does: `PV at its low end`, `PV at its high end`, `PV frozen` or `PV moves without the OP`.
    pub silence: String,
    /// Whether the verdict rests on it.
    pub decides: bool,
    /// The rest of the PV in which the OP travels farthest; null if it moves on.
    pub rest: Option<Rest>,
    /// What it may be, the likeliest first.
    pub faults: Vec<Fault>,
}

/// A time in which the PV rests away from its set point while the OP travels.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Rest {
    /// Its beginning, s on the recording's clock.
    pub from_s: f64,
    /// Its end, s on the recording's clock.
    pub to_s: f64,
    /// How far the OP travels in it, percent.
    pub op_travel: f64,
    /// Mean of SP less PV in it, in units of the PV.
    pub error: f64,
    /// Whether that alone names the fault.
    pub overwhelming: bool,
}

/// Why a PV may not respond.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Fault {
    /// Its name, such as `line isolated`.
    pub name: String,
    /// How to tell it from the others.
    pub told_by: String,
}

/// A record that looks stuck, with too few slips to decide.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FewSlips {
    /// Slips that the best valve model sees.
    pub seen: usize,
    /// Slips that a decision takes.
    pub needed: usize,
    /// For how much longer to record, s, if the valve goes on slipping as often; null if it never slipped.
    pub record_for_s: Option<f64>,
    /// How large steps of the OP would make it slip, percent of span.
    pub step: f64,
    /// The same in words.
    pub words: String,
}

/// The evidence that was weighed.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Evidence {
    /// What each line of evidence says by itself.
    pub lines: Vec<Line>,
    /// Standard errors by which a valve that sticks predicts the PV better than one that follows; from 3 on a
    /// valve is not cleared.
    pub z: f64,
    /// An S above this would have shown; null where nothing could have been seen.
    #[serde(rename = "S_below")]
    pub s_below: Option<Limit>,
    /// Range of the OP in its widest window, percent of span.
    pub op_range: f64,
    /// How far the recording is from the loops of training; above 1 it is unlike all of them.
    pub distance: f64,
    /// What lies farthest outside of them.
    pub strangest: Vec<String>,
}

/// What a line of evidence says.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Line {
    /// Its name.
    pub name: String,
    /// The probability of a fault by this line alone.
    pub probability: f64,
}

/// The conclusion.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Verdict {
    /// `sticks`, `does not stick`, `does not respond` or `cannot tell`: what was computed, whatever a
    /// person said.
    pub class: String,
    /// The probability that the valve sticks; null for a majority, which has none.
    pub probability: Option<f64>,
    /// What it rests on: `measured valve position`, `evidence in OP and PV`, `shape of the OP alone`,
    /// `majority of the families of methods that apply` or `none`.
    pub basis: String,
    /// An S above this would have shown in this very recording; null where the valve is at fault or no such
    /// number is known.
    #[serde(rename = "S_below")]
    pub s_below: Option<Limit>,
    /// How the families of published methods voted, one vote each.
    pub votes: Votes,
    /// Why.
    pub reasons: Vec<String>,
    /// Evidence that speaks against it.
    pub contradictions: Vec<String>,
    /// What else it could be, the likeliest first.
    pub alternatives: Vec<Alternative>,
    /// The manual test that would settle it; null if none can be sized.
    pub confirm: Option<ConfirmingTest>,
    /// What a person concluded of this recording; null if nobody did.
    #[serde(rename = "override")]
    pub overruled: Option<Override>,
}

/// An upper limit of S.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Limit {
    /// Stick band plus dead band, percent of span.
    pub value: f64,
    /// Of valves that stick by more, the share that would have been seen.
    pub confidence: f64,
}

/// A cause other than the concluded one.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Alternative {
    /// The cause, such as `aggressive tuning`.
    pub cause: String,
    /// Its probability; together with that of sticking they add up to one.
    pub likelihood: f64,
    /// What the data show of it, and how to tell it apart.
    pub because: String,
}

/// A test with the controller in manual that settles whether the valve sticks.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ConfirmingTest {
    /// Size of each step of the OP, percent of span.
    pub step: f64,
    /// How many steps in one direction before they turn.
    pub steps: usize,
    /// Whether the first steps go up.
    pub up_first: bool,
    /// How long to wait after each step, s.
    pub wait_s: f64,
    /// By how much the PV should change with one step if the valve follows, in its units; null where the
    /// data do not tell.
    pub pv_change: Option<f64>,
    /// What to do and what to look for, in order.
    pub instructions: Vec<String>,
}

/// What a person concluded of a valve, beside the computed verdict.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Override {
    /// `sticks`, `does not stick`, `does not respond` or `cannot tell`.
    pub verdict: String,
    /// Why.
    pub reason: String,
    /// Who says so; null where that is not kept.
    pub by: Option<String>,
    /// The day on which it was entered, as in `2026-03-01`; null where that is not kept.
    pub entered: Option<String>,
    /// What it holds for, in words.
    pub scope: String,
    /// The file it is kept in.
    pub kept_in: String,
}

/// How the families of published methods voted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Votes {
    /// Families that say the valve sticks.
    pub sticks: usize,
    /// Families that say it does not.
    pub does_not_stick: usize,
    /// Families that apply and are undecided.
    pub undecided: usize,
    /// Families that abstain.
    pub abstains: usize,
}

/// How much a valve sticks.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Stiction {
    /// What S and J were found with.
    pub model: Option<String>,
    /// Stick band plus dead band, percent of span.
    #[serde(rename = "S")]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span.
    #[serde(rename = "J")]
    pub j: Option<Estimate>,
    /// The nominal coverage of the intervals, such as 0.9; null where they are not of that kind.
    pub coverage: Option<f64>,
    /// Why a number is missing.
    pub why_not: Option<String>,
    /// The competing definitions of "stiction in percent", side by side.
    pub definitions: Vec<Definition>,
}

/// One of the numbers that are called "stiction in percent".
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Definition {
    /// Its name.
    pub name: String,
    /// Its value; null where it cannot be measured.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// What it is, and by whom.
    pub meaning: String,
}

/// What one window of a stretch says.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Window {
    /// Time of its first sample, s on the recording's clock.
    pub from_s: f64,
    /// Its duration, s.
    pub duration_s: f64,
    /// The probability that the valve sticks.
    pub probability: f64,
    /// Stick band plus dead band, percent of span; null where it could not be quantified.
    #[serde(rename = "S")]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span; null where it could not be quantified.
    #[serde(rename = "J")]
    pub j: Option<Estimate>,
    /// An S above this would have shown in this window; null where nothing could have been seen.
    #[serde(rename = "S_below")]
    pub s_below: Option<Limit>,
}

/// A number with an interval.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Estimate {
    /// The best value.
    pub value: f64,
    /// Lower end of its interval.
    pub low: f64,
    /// Upper end of its interval.
    pub high: f64,
}

impl Document {
    /// A document of some loops.
    pub fn new(tool: impl Into<String>, loops: Vec<Loop>) -> Self {
        Self { tool: tool.into(), version: VERSION, loops }
    }

    /// The document as JSON text, indented.
    pub fn json(&self) -> String {
        // Types made of strings, finite numbers and lists always serialise.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

/// The JSON schema of a [`Document`], indented.
pub fn schema() -> String {
    schema_of::<Document>()
}

/// The JSON schema of a [`ValveHistory`], indented.
pub fn history_schema() -> String {
    schema_of::<ValveHistory>()
}

/// The JSON schema of a document, indented.
pub fn schema_of<T: JsonSchema>() -> String {
    serde_json::to_string_pretty(&schemars::schema_for!(T)).unwrap_or_default()
}

/// A number that JSON can carry.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

impl From<&detect::Number> for Number {
    fn from(number: &detect::Number) -> Self {
        Self { name: number.name.into(), value: finite(number.value), unit: number.unit.into() }
    }
}

impl Detector {
    /// What a method with these parameters says.
    pub fn new(finding: &Finding, parameters: &[detect::Number]) -> Self {
        let method = finding.method;
        Self {
            name: method.name.into(),
            title: method.title.into(),
            reference: method.source.into(),
            statistic: finding.statistic.and_then(finite),
            statistic_name: method.statistic.into(),
            threshold: finding.threshold.and_then(finite),
            decision: finding.decision.name().into(),
            votes: method.decides == detect::Decides::Stiction,
            family: method.family.name().into(),
            reason: finding.reason.clone(),
            numbers: finding.numbers.iter().map(Number::from).collect(),
            caveats: finding.caveats.clone(),
            parameters: parameters.iter().map(Number::from).collect(),
        }
    }
}

impl From<&fitness::Fitness> for Fitness {
    fn from(fitness: &fitness::Fitness) -> Self {
        let measures = fitness.measures.iter().map(|m| Measure {
            name: m.name.into(),
            value: m.value.and_then(finite),
            unit: m.unit.into(),
            caveat_at: m.caveat_at,
            unfit_at: m.unfit_at,
            class: m.class.name().into(),
            reason: m.reason.clone(),
        });
        Self {
            class: fitness.class.name().into(),
            reasons: fitness.reasons().into_iter().map(str::to_owned).collect(),
            measures: measures.collect(),
        }
    }
}

impl From<&Repair> for Mended {
    fn from(repair: &Repair) -> Self {
        Self {
            signal: repair.signal.into(),
            count: repair.count,
            first_s: repair.first_s,
            done: repair.done.clone(),
        }
    }
}

impl Oscillation {
    /// The oscillation of a signal whose first sample is at `from_s`.
    pub fn new(signal: &str, oscillation: &oscillation::Oscillation, from_s: f64) -> Self {
        let peaks = oscillation.peaks.iter().map(|peak| Peak {
            period_s: peak.period_s,
            amplitude: peak.amplitude,
            share: peak.share,
            regularity: peak.regularity.and_then(finite),
            harmonic: peak.harmonic,
        });
        let episodes = oscillation.episodes.iter().map(|episode| Episode {
            from_s: from_s + episode.from_s,
            to_s: from_s + episode.to_s,
            amplitude: episode.amplitude,
        });
        Self {
            signal: signal.into(),
            found: oscillation.found,
            period_s: oscillation.period_s.and_then(finite),
            regularity: oscillation.regularity.and_then(finite),
            decay_ratio: oscillation.decay_ratio.and_then(finite),
            amplitude: oscillation.amplitude.and_then(finite),
            cycles: oscillation.cycles.and_then(finite),
            supervision: oscillation.supervised.map(|found| Supervision {
                threshold: found.threshold,
                disturbances: found.disturbances,
                half_waves: found.half_waves,
                counter: found.counter,
                alarm_s: found.alarm_s.map(|alarm| from_s + alarm),
            }),
            peaks: peaks.collect(),
            episodes: episodes.collect(),
            reasons: oscillation.reasons.clone(),
        }
    }
}

impl From<&diagnose::Verdict> for Verdict {
    fn from(verdict: &diagnose::Verdict) -> Self {
        let votes = verdict.votes;
        Self {
            class: verdict.class.name().into(),
            probability: verdict.probability,
            basis: verdict.basis.name().into(),
            s_below: verdict.s_below.map(Limit::from),
            votes: Votes {
                sticks: votes.sticks,
                does_not_stick: votes.does_not_stick,
                undecided: votes.undecided,
                abstains: votes.abstains,
            },
            reasons: verdict.reasons.clone(),
            contradictions: verdict.contradictions.clone(),
            alternatives: verdict
                .alternatives
                .iter()
                .map(|each| Alternative {
                    cause: each.cause.name().into(),
                    likelihood: each.likelihood,
                    because: each.because.clone(),
                })
                .collect(),
            confirm: verdict.confirm.as_ref().map(|test| ConfirmingTest {
                step: test.step,
                steps: test.steps,
                up_first: test.up_first,
                wait_s: test.wait_s,
                pv_change: test.pv_change.and_then(finite),
                instructions: test.instructions.clone(),
            }),
            overruled: None,
        }
    }
}

impl From<diagnose::Limit> for Limit {
    fn from(limit: diagnose::Limit) -> Self {
        Self { value: limit.value, confidence: limit.confidence }
    }
}

impl Limit {
    /// What would have shown with the confidence of all limits.
    fn of(value: Option<f64>) -> Option<Self> {
        Some(Self { value: value.and_then(finite)?, confidence: LIMIT })
    }
}

impl Relation {
    /// The mistake in the columns, if there is one.
    fn of(relation: &diagnose::Relation) -> Option<Self> {
        let mismatch = relation.mismatch?;
        Some(Self {
            mismatch: mismatch.name().into(),
            because: relation.because.clone(),
            remedy: mismatch.remedy().into(),
        })
    }
}

impl From<diagnose::Fault> for Fault {
    fn from(fault: diagnose::Fault) -> Self {
        Self { name: fault.name().into(), told_by: fault.told_by().into() }
    }
}

impl NoResponse {
    /// What does not respond in a diagnosis.
    fn of(diagnosis: &Diagnosis) -> Option<Self> {
        let decides = diagnosis.silence();
        let silence = decides.or(diagnosis.no_response.map(|rest| rest.silence))?;
        let rest = diagnosis.no_response.zip(diagnosis.stretch()).map(|(rest, stretch)| {
            let at = |sample: usize| stretch.from + sample as f64 * stretch.sample_time;
            Rest {
                from_s: at(rest.first),
                to_s: at(rest.end),
                op_travel: rest.op_travel,
                error: rest.error,
                overwhelming: rest.overwhelming,
            }
        });
        Some(Self {
            silence: silence.name().into(),
            decides: decides.is_some(),
            rest,
            faults: diagnose::Fault::behind(silence).iter().copied().map(Fault::from).collect(),
        })
    }
}

impl From<&diagnose::FewSlips> for FewSlips {
    fn from(few: &diagnose::FewSlips) -> Self {
        Self {
            seen: few.seen,
            needed: few.needed,
            record_for_s: few.record_for_s,
            step: few.step,
            words: few.words.clone(),
        }
    }
}

impl From<&diagnose::Weighing> for Evidence {
    fn from(weighing: &diagnose::Weighing) -> Self {
        let lines = weighing.lines.iter();
        Self {
            lines: lines
                .map(|(line, probability)| Line {
                    name: line.name().into(),
                    probability: *probability,
                })
                .collect(),
            z: weighing.z,
            s_below: Limit::of(weighing.limit),
            op_range: weighing.op_range,
            distance: weighing.distance,
            strangest: weighing.strangest.clone(),
        }
    }
}

impl From<diagnose::Estimate> for Estimate {
    fn from(estimate: diagnose::Estimate) -> Self {
        Self { value: estimate.value, low: estimate.low, high: estimate.high }
    }
}

impl From<&diagnose::Window> for Window {
    fn from(window: &diagnose::Window) -> Self {
        Self {
            from_s: window.from,
            duration_s: window.duration,
            probability: window.probability,
            s: window.s.map(Estimate::from),
            j: window.j.map(Estimate::from),
            s_below: Limit::of(window.limit),
        }
    }
}

impl From<&diagnose::Stiction> for Stiction {
    fn from(stiction: &diagnose::Stiction) -> Self {
        Self {
            model: stiction.model.clone(),
            s: stiction.s.map(Estimate::from),
            j: stiction.j.map(Estimate::from),
            coverage: stiction.coverage,
            why_not: stiction.why_not.clone(),
            definitions: stiction
                .definitions
                .iter()
                .map(|each| Definition {
                    name: each.name.into(),
                    value: each.value.and_then(finite),
                    unit: each.unit.into(),
                    meaning: each.meaning.into(),
                })
                .collect(),
        }
    }
}

impl Loop {
    /// The diagnosis of a recording that comes from a file, and what a person concluded of it.
    pub fn new(diagnosis: &Diagnosis, source: Source, overruled: Option<Override>) -> Self {
        let stretch = diagnosis.stretch();
        let judged = stretch.map(|stretch| Judged {
            from_s: stretch.from,
            duration_s: stretch.duration(),
            sample_time_s: stretch.sample_time,
            samples: stretch.len(),
            bridged: stretch.bridged,
            stretches: diagnosis.grid.stretches.len(),
            signals: [
                ("OP", true),
                ("PV", stretch.pv.is_some()),
                ("SP", stretch.sp.is_some()),
                ("VP", stretch.vp.is_some()),
            ]
            .into_iter()
            .filter(|(_, there)| *there)
            .map(|(name, _)| name.to_owned())
            .collect(),
        });
        let oscillation = diagnosis
            .oscillation()
            .zip(stretch)
            .map(|((signal, found), stretch)| Oscillation::new(signal, found, stretch.from));
        let detectors = detect::all();
        let parameters = |finding: &Finding| {
            detectors
                .iter()
                .find(|detector| detector.method().name == finding.method.name)
                .map_or(vec![], |detector| detector.parameters())
        };
        let findings = diagnosis.findings.iter();
        let kpis = diagnosis.kpis.numbers.iter().map(|kpi| Kpi {
            name: kpi.name.into(),
            value: kpi.value.and_then(finite),
            unit: kpi.unit.into(),
            meaning: kpi.meaning.into(),
            note: kpi.note.clone(),
        });
        Self {
            name: diagnosis.name.clone(),
            source,
            loop_type: diagnosis.loop_type.name().into(),
            judged,
            repairs: diagnosis.grid.repairs.iter().map(Mended::from).collect(),
            fitness: Fitness::from(&diagnosis.fitness),
            oscillation,
            detectors: findings.map(|f| Detector::new(f, &parameters(f))).collect(),
            kpis: kpis.collect(),
            relation: diagnosis.relation.as_ref().and_then(Relation::of),
            no_response: NoResponse::of(diagnosis),
            verdict: Verdict { overruled, ..Verdict::from(&diagnosis.verdict) },
            stiction: Stiction::from(&diagnosis.stiction),
            few_slips: diagnosis.few_slips.as_ref().map(FewSlips::from),
            evidence: diagnosis.evidence.as_ref().map(Evidence::from),
            windows: diagnosis.windows.iter().map(Window::from).collect(),
            notes: diagnosis.notes.clone(),
        }
    }
}
