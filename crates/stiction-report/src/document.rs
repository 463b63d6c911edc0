//! A diagnosis as a document for programs: what `stiction diagnose --json` prints.
//!
//! The JSON schema is generated from these types ([`schema`]). Fields are added, never renamed or
//! removed, within one [`VERSION`].

use schemars::JsonSchema;
use serde::Serialize;
use stiction::detect::{self, Finding};
use stiction::diagnose::{self, Diagnosis};
use stiction::oscillation;
use stiction::recording::{Repair, fitness};

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
    /// The conclusion.
    pub verdict: Verdict,
    /// How much the valve sticks.
    pub stiction: Stiction,
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
    /// All oscillations that were told apart, strongest first.
    pub peaks: Vec<Peak>,
    /// When it oscillates.
    pub episodes: Vec<Episode>,
    /// Why it is, or is not, called an oscillation.
    pub reasons: Vec<String>,
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

/// The conclusion.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Verdict {
    /// `sticks`, `does not stick` or `cannot tell`.
    pub class: String,
    /// The probability that the valve sticks; null for a majority, which has none.
    pub probability: Option<f64>,
    /// What it rests on.
    pub basis: String,
    /// How the families of published methods voted, one vote each.
    pub votes: Votes,
    /// Why.
    pub reasons: Vec<String>,
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
    /// Why a number is missing.
    pub why_not: Option<String>,
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
    serde_json::to_string_pretty(&schemars::schema_for!(Document)).unwrap_or_default()
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
            votes: Votes {
                sticks: votes.sticks,
                does_not_stick: votes.does_not_stick,
                undecided: votes.undecided,
                abstains: votes.abstains,
            },
            reasons: verdict.reasons.clone(),
        }
    }
}

impl From<&diagnose::Stiction> for Stiction {
    fn from(stiction: &diagnose::Stiction) -> Self {
        let estimate = |estimate: Option<diagnose::Estimate>| {
            estimate.map(|e| Estimate { value: e.value, low: e.low, high: e.high })
        };
        Self {
            model: stiction.model.clone(),
            s: estimate(stiction.s),
            j: estimate(stiction.j),
            why_not: stiction.why_not.clone(),
        }
    }
}

impl Loop {
    /// The diagnosis of a recording that comes from a file.
    pub fn new(diagnosis: &Diagnosis, source: Source) -> Self {
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
            verdict: Verdict::from(&diagnosis.verdict),
            stiction: Stiction::from(&diagnosis.stiction),
            notes: diagnosis.notes.clone(),
        }
    }
}
