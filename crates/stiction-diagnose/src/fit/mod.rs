//! The identified loop of a recording: controller, process and valve, and whether that loop explains the recording.
//!
//! # Method
//! * [`controller`]: the controller of the OP, with intervals.
//! * The valve: its recorded position, or S and J from the [verdict](crate::diagnose), each possible pair weighted
//!   by how well the PV follows from it ([`valve`]). If the stem only jumps, the PV gives the product of J and gain alone.
//!   So among valves that stick the likelihood is weakened, and those whose loop cycles about as recorded are preferred.
//! * [`process`]: gain, lag and dead time between valve and PV, with all combinations that fit the data equally
//!   well, behind all valves.
//! * [`Draws`](Draw): loops drawn from all possible ones, seeded.
//! * If the valve began or ceased to stick, all of this for the part of the recording since then.
//! * [`Cycle`]: the exact limit cycle of such loops, drawn without that preference, beside the recorded swing. It also
//!   gives the share of the swing that would remain with a valve that follows. If they cycle as the recording does, or
//!   little of the swing remains, a sticking valve explains the swing. Otherwise something else causes it, even with
//!   clear signs of stiction.
//!
//! # Limits
//! As for the parts. Parts that cannot be identified are reported, and the explanation is not tested.

pub mod cycle;
mod draw;
pub mod prospects;
pub mod ring;
pub mod valve;
pub mod without;

pub use cycle::{Cycle, Swing};
pub use draw::Draw;
pub use prospects::{Prospect, Prospects, prospects};
pub use valve::FittedValve;

use crate::diagnose::{Diagnosis, VerdictClass};
use crate::fusion::{Cause, Estimate};
use crate::identify::controller::{self, FittedController};
use crate::identify::process::{self, Candidate, FittedProcess, MOST_SAMPLES};
use crate::recording::Segment;
use crate::series::{line, mean};
use crate::valve::Model;

/// Largest number of repetitions of the process fit behind the valve that explains the PV best.
const ROUNDS: usize = 3;
/// The note on a valve that changed.
const CHANGED: &str = "Only the part since the valve changed is fitted.";

/// Number of drawn loops, and their stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FitOptions {
    /// Number of loops to draw.
    pub draws: usize,
    /// Stream of random numbers.
    pub seed: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { draws: 60, seed: 1 }
    }
}

/// A part of a loop, or why it could not be identified.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(untagged))]
pub enum Part<T> {
    /// Identified.
    Identified(Box<T>),
    /// Not identified.
    Not {
        /// The reason: a sentence, with the remedy where there is one.
        not_identified: String,
    },
}

impl<T> Part<T> {
    /// The identified part, if there is one.
    pub fn known(&self) -> Option<&T> {
        match self {
            Self::Identified(part) => Some(part),
            Self::Not { .. } => None,
        }
    }

    /// The reason, if it was not identified.
    pub fn why_not(&self) -> Option<&str> {
        match self {
            Self::Identified(_) => None,
            Self::Not { not_identified } => Some(not_identified),
        }
    }

    fn of(found: Result<T, String>) -> Self {
        match found {
            Ok(part) => Self::Identified(Box::new(part)),
            Err(not_identified) => Self::Not { not_identified },
        }
    }
}

/// The operating point of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Resting {
    /// Mean of the OP, percent.
    pub op: f64,
    /// Mean of the PV, in PV units.
    pub pv: f64,
    /// Slope of the OP, percent per hour, which shows the drift of the load.
    pub op_drift_per_hour: f64,
}

/// The identified loop of a recording.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Fit {
    /// Time between the fitted samples, s.
    pub sample_time_s: f64,
    /// The operating point.
    pub resting: Resting,
    /// The controller.
    pub controller: Part<FittedController>,
    /// The process behind the valve.
    pub process: Part<FittedProcess>,
    /// The valve.
    pub valve: Part<FittedValve>,
    /// The limit cycle of that loop beside the recording.
    pub cycle: Part<Cycle>,
    /// Loops drawn from all possible loops; empty if a part is missing.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub draws: Vec<Draw>,
    /// Whether the valve began or ceased to stick within the recording; only the part since then is fitted.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub changed: bool,
    /// The fitted segment.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub segment: Segment,
}

/// Identifies the loop of a diagnosed recording.
///
/// # Errors
/// In words, if no segment was judged, it has no PV, or its columns look mistaken.
pub fn fit(diagnosis: &Diagnosis, options: &FitOptions) -> Result<Fit, String> {
    let segment =
        diagnosis.segment().ok_or("no segment in automatic is long enough to fit a loop to")?;
    // The valve as it is now.
    let evidence = diagnosis.evidence.as_ref();
    let since_change = evidence.and_then(|evidence| evidence.since_change(segment));
    let changed = since_change.is_some();
    let segment = since_change.as_ref().unwrap_or(segment);
    if segment.is_empty() {
        return Err("the valve changed after the longest segment in automatic; fit a recording from after the change".to_owned());
    }
    let pv = segment.pv.as_deref().ok_or("without a PV no loop can be fitted; export the PV")?;
    if let Some(mistake) = diagnosis.mistaken() {
        return Err(format!("{}: {}", mistake.name(), mistake.remedy()));
    }
    let step = segment.sample_time;
    let controller = controller::fit(segment).map_err(|why| why.0);
    // In closed loop OP and PV feed back negatively.
    let sign = controller.as_ref().ok().map(|found| found.kc.value.signum());
    // Of a long segment, valve and process are fitted to the middle.
    let middle = segment.part(segment.len().saturating_sub(MOST_SAMPLES) / 2, MOST_SAMPLES);
    let (op, pv) = (&middle.op, middle.pv.as_deref().unwrap_or(pv));
    let idle = evidence.map_or(0.0, |evidence| evidence.likelihood(Cause::NoResponse));
    let silent = diagnosis.verdict.class == VerdictClass::DoesNotRespond || idle > 0.5;
    let valves = match silent {
        true => Err("the PV probably does not respond to the OP".to_owned()),
        false => valve::possible(diagnosis, &middle),
    };
    let recorded = cycle::recorded(diagnosis, segment);
    let mut process = Err(String::new());
    let chosen;
    let (mut unbiased, mut draws) = (vec![], vec![]);
    match valves {
        Err(why) => {
            process = match silent {
                true => Err(why.clone()),
                false => process::fit(op, pv, step, sign).map_err(|why| why.0),
            };
            chosen = Err(why);
        }
        Ok(valves) => {
            // The process behind the likeliest of a few paths, then all valves before that process.
            let tried = valves
                .iter()
                .filter(|valve| valve.first)
                .map(|valve| process::fit(&valve.path, pv, step, sign).map_err(|why| why.0));
            for found in tried {
                process = match (process, found) {
                    (Ok(a), Ok(b)) if b.gained > a.gained => Ok(b),
                    (Ok(a), _) => Ok(a),
                    (Err(_), Ok(found)) => Ok(found),
                    // The reason of the valve that follows, which moves if any valve does.
                    (Err(first), Err(other)) => Err(if first.is_empty() { other } else { first }),
                };
            }
            if let Ok(process) = &mut process {
                let mut weighed = valve::weighed(&valves, process, pv, step);
                // The process behind the likeliest valve of all, and again all valves before that process.
                for _ in 0..ROUNDS {
                    let Some(best) = valve::likeliest(&weighed, &valves) else { break };
                    match process::fit(&best.path, pv, step, sign) {
                        Ok(again) if again.gained > process.gained + 1.0 => *process = again,
                        _ => break,
                    }
                    weighed = valve::weighed(&valves, process, pv, step);
                }
                let loops = |weighed: &[valve::Weighed]| {
                    let controller = controller.as_ref().ok();
                    controller.map_or(vec![], |of| draw::drawn(of, weighed, step, options))
                };
                // The recorded swing must not decide whether the loops explain it.
                unbiased = loops(&weighed);
                if let (Ok(controller), Some(recorded)) = (&controller, recorded) {
                    weighed = cycle::alike(weighed, controller, step, recorded);
                }
                draws = loops(&weighed);
                chosen = Ok(valve::summarised(&weighed));
                // A measured position leaves the numbers of its process as they are.
                if valves.len() > 1 {
                    let sticks = |one: &&valve::Weighed| one.model != Model::Ideal;
                    let follows = chosen.as_ref().is_ok_and(|valve| valve.follows > 0.5);
                    let shown = weighed.iter().filter(|one| sticks(one) != follows);
                    let points = shown.map(|one| Candidate { weight: one.weight, ..one.process });
                    *process = process.clone().over(points.collect(), step);
                }
            } else {
                chosen = valve::alone(diagnosis);
            }
        }
    }
    let typical = |draw: &Draw| {
        let within =
            |of: Option<Estimate>, value: f64| of.is_none_or(|e| e.low <= value && value <= e.high);
        let valve = chosen.as_ref().ok();
        let gain = process.as_ref().ok().and_then(|process| process.gain);
        within(valve.map(|valve| valve.s), draw.bands.s())
            && within(valve.map(|valve| valve.j), draw.bands.j())
            && draw.lasting_gain().is_none_or(|value| within(gain, value))
    };
    let mut cycle = match (&controller, &process) {
        (Ok(_), Ok(_)) => cycle::tested(recorded, segment, &unbiased, typical),
        (Err(_), _) => {
            Err("the controller is not identified, so the behaviour of the loop is unknown"
                .to_owned())
        }
        (_, Err(_)) => {
            Err("the process is not identified, so the behaviour of the loop is unknown".to_owned())
        }
    };
    if let Ok(cycle) = &mut cycle
        && changed
    {
        cycle.sentence = format!("{} {CHANGED}", cycle.sentence);
    }
    Ok(Fit {
        changed,
        sample_time_s: step,
        resting: Resting {
            op: mean(&segment.op),
            pv: segment.pv.as_deref().map_or(0.0, mean),
            op_drift_per_hour: 3600.0 * line(&segment.times(), &segment.op).slope,
        },
        controller: Part::of(controller),
        process: Part::of(process.map_err(|why| match changed {
            true => format!("{why}. {CHANGED}"),
            false => why,
        })),
        valve: Part::of(chosen),
        cycle: Part::of(cycle),
        draws,
        segment: segment.clone(),
    })
}
