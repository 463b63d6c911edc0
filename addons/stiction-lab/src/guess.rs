//! Guess the fault: first only the trends of a loop, then the truth.
//!
//! A seed and a number draw a loop, so the same seed gives the same loops.

use crate::calls::{Answer, Wrong};
use crate::judgement::Judgement;
use crate::lab::Lab;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiction_diagnose::diagnose::{DiagnoseOptions, diagnose};
use stiction_diagnose::recording::Channel;
use stiction_figure::figure::{Series, Style, colour};
use stiction_population::{LoopKind, Simulated};

/// The kinds to choose from. A third of the loops are of the first kind; the others are equally frequent.
const KINDS: [LoopKind; 12] = [
    LoopKind::Sticky,
    LoopKind::Stuck,
    LoopKind::Normal,
    LoopKind::Sine,
    LoopKind::AggressiveTuning,
    LoopKind::QuantisedPv,
    LoopKind::Saturation,
    LoopKind::DeadZoneElsewhere,
    LoopKind::SetPoint,
    LoopKind::ProcessNonlinearity,
    LoopKind::ExternalWave,
    LoopKind::StickingNeighbour,
];

/// Which loop.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Which {
    /// What draws the loops.
    seed: u32,
    /// The number of the loop, from 0.
    number: u32,
}

/// What a plant would have recorded.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Trends {
    /// The kinds that it may be of.
    kinds: Vec<String>,
    /// The recorded signals: OP, PV, and the SP of some loops.
    signals: Vec<Trend>,
}

/// A signal over time.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Trend {
    /// Name: SP, PV or OP.
    name: String,
    /// Times, s.
    time: Vec<f64>,
    /// Values; null where a value is missing.
    values: Vec<Option<f64>>,
}

/// The truth about a loop, and its diagnosis.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Revealed {
    /// What it is.
    kind: String,
    /// Whether its own valve is at fault.
    sticks: bool,
    /// Stick band plus dead band, percent of span; of a valve that sticks.
    #[serde(rename = "S")]
    s: Option<f64>,
    /// Slip jump, percent of span; of a valve that sticks.
    #[serde(rename = "J")]
    j: Option<f64>,
    /// The valve position.
    vp: Trend,
    /// The diagnosis of the shown recording.
    judgement: Judgement,
}

impl Trend {
    /// A signal of these samples.
    pub(crate) fn new(name: &str, time: Vec<f64>, values: &[f64]) -> Self {
        let value = |x: &f64| x.is_finite().then_some(*x);
        Self { name: name.to_owned(), time, values: values.iter().map(value).collect() }
    }

    fn of(name: &str, channel: &Channel) -> Self {
        Self::new(name, channel.time.clone(), &channel.values)
    }

    /// Name.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Line in a figure.
    pub(crate) fn series(&self) -> Series {
        let known = self.time.iter().zip(&self.values).filter_map(|(t, x)| Some((*t, (*x)?)));
        let (time, values): (Vec<f64>, Vec<f64>) = known.unzip();
        let (style, index) = match &*self.name {
            "SP" => (Style::Dashed, colour::SP),
            "PV" => (Style::Line, colour::PV),
            "OP" => (Style::Line, colour::OP),
            _ => (Style::Dashed, colour::VP),
        };
        Series::new(style, &*self.name, time, values).colour(index)
    }
}

/// Pseudo-random numbers (splitmix64, Steele, Lea, Flood, OOPSLA 2014).
pub(crate) fn mixed(x: u64) -> u64 {
    let mut z = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Such a number as a fraction from 0 to 1.
pub(crate) fn share(mixed: u64) -> f64 {
    (mixed >> 11) as f64 / (1u64 << 53) as f64
}

fn drawn(which: &Which) -> Answer<Simulated> {
    let own = mixed(u64::from(which.seed) << 32 | u64::from(which.number));
    let kind = match own % 3 {
        0 => LoopKind::Sticky,
        _ => KINDS[1 + (mixed(own) % (KINDS.len() as u64 - 1)) as usize],
    };
    // An invisible fault makes no question.
    for again in 0..40 {
        let simulated = kind.simulate(mixed(own ^ again) >> 16)?;
        if !simulated.truth.sticks || simulated.truth.visible {
            return Ok(simulated);
        }
    }
    Err(Wrong::own("the lab found no loop with a visible fault; go on to the next loop"))
}

/// The trends of a loop.
///
/// # Errors
/// If no such loop can be drawn.
pub fn trends(_: &Lab, which: Which) -> Answer<Trends> {
    let recording = drawn(&which)?.recording;
    let mut signals = vec![Trend::of("OP", &recording.op)];
    for (name, channel) in [("PV", &recording.pv), ("SP", &recording.sp)] {
        signals.extend(channel.as_ref().map(|channel| Trend::of(name, channel)));
    }
    Ok(Trends { kinds: KINDS.map(|kind| kind.name().to_owned()).into(), signals })
}

/// The truth about a loop.
///
/// # Errors
/// If no such loop can be drawn.
pub fn reveal(_: &Lab, which: Which) -> Answer<Revealed> {
    let Simulated { recording, truth } = drawn(&which)?;
    let bands = truth.has_bands();
    let vp = Trend::new("VP", recording.op.time.clone(), &truth.vp);
    Ok(Revealed {
        kind: truth.kind.name().to_owned(),
        sticks: truth.sticks,
        s: bands.then_some(truth.s),
        j: bands.then_some(truth.j),
        vp,
        judgement: Judgement::new(diagnose(&recording, &DiagnoseOptions::default())?),
    })
}
