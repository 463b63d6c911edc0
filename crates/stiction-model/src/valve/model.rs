//! The valve models by name.

use super::memory::{Memory, Remember};
use super::{Chen, Choudhury, He, HeWang, Ideal, Kano, Play, Start, Stenman, TwoPhase, Valve};
use crate::bands::Bands;
use crate::error::{Error, Result};

/// A published valve model, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Model {
    /// [`TwoPhase`]
    TwoPhase,
    /// [`Choudhury`]
    Choudhury,
    /// [`Kano`]
    Kano,
    /// [`He`]
    He,
    /// [`HeWang`]
    HeWang,
    /// [`Stenman`]
    Stenman,
    /// [`Chen`]
    Chen,
    /// [`Play`]
    Play,
    /// [`Ideal`]
    Ideal,
}

/// What a [`Model`] is, in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Description {
    /// The name by which the model is asked for.
    pub name: &'static str,
    /// Other names it answers to.
    pub aliases: &'static [&'static str],
    /// What it does, in one line.
    pub summary: &'static str,
    /// Where it comes from.
    pub citation: &'static str,
    /// Whether `S` makes a difference.
    pub uses_s: bool,
    /// Whether `J` makes a difference.
    pub uses_j: bool,
}

impl Model {
    /// All models.
    pub const ALL: [Self; 9] = [
        Self::TwoPhase,
        Self::Choudhury,
        Self::Kano,
        Self::He,
        Self::HeWang,
        Self::Stenman,
        Self::Chen,
        Self::Play,
        Self::Ideal,
    ];

    /// What this model is.
    pub fn describe(self) -> Description {
        let (name, aliases, summary, citation): (_, &'static [&'static str], _, _) = match self {
            Self::TwoPhase => (
                "two-phase",
                &["twophase", "two_phase"],
                "stuck or moving; slides after a slip until the input pauses or reverses",
                "Modelling and Dynamic Analysis of Pneumatic Control Valve with Stiction",
            ),
            Self::Choudhury => (
                "choudhury",
                &[],
                "revised flow chart; equals two-phase for J <= S",
                "Choudhury, Thornhill, Shah, Control Eng. Practice 13 (2005) 641-658",
            ),
            Self::Kano => (
                "kano",
                &[],
                "equals two-phase",
                "Kano, Maruta, Kugemoto, Shimizu, IFAC DYCOPS (2004)",
            ),
            Self::He => (
                "he",
                &[],
                "at rest after every sample; climbs a slow ramp in steps of J",
                "He, Wang, Pottmann, Qin, Ind. Eng. Chem. Res. 46 (2007) 4549-4560",
            ),
            Self::HeWang => (
                "he-wang",
                &["hewang", "he_wang"],
                "he with slips that overshoot by the factor K (equation recalled)",
                "He, Wang, American Control Conference (2010)",
            ),
            Self::Stenman => (
                "stenman",
                &[],
                "one parameter: jumps to the input once it is J away",
                "Stenman, Gustafsson, Forsman, Int. J. Adapt. Control Signal Process. 17 (2003)",
            ),
            Self::Chen => (
                "chen",
                &["xch"],
                "two-layer binary tree; reversals one sample late (recalled)",
                "Chen, Tan, Huang, Ind. Eng. Chem. Res. 47 (2008) 2842-2848",
            ),
            Self::Play => (
                "play",
                &["backlash", "deadband"],
                "pure dead band S, no slip jump",
                "play operator, Krasnosel'skii and Pokrovskii (1989)",
            ),
            Self::Ideal => ("ideal", &["linear"], "no friction: position equals input", "identity"),
        };
        let uses_s = !matches!(self, Self::Stenman | Self::Ideal);
        let uses_j = !matches!(self, Self::Play | Self::Ideal);
        Description { name, aliases, summary, citation, uses_s, uses_j }
    }

    /// The model called `name`, in any case.
    ///
    /// # Errors
    /// If no model has that name; the error lists those there are.
    pub fn by_name(name: &str) -> Result<Self> {
        let wanted = name.to_ascii_lowercase();
        Self::ALL
            .into_iter()
            .find(|model| {
                let description = model.describe();
                description.name == wanted || description.aliases.contains(&wanted.as_str())
            })
            .ok_or_else(|| Error::UnknownName {
                family: "valve model",
                name: name.to_owned(),
                known: Self::ALL.map(|model| model.describe().name).join(", "),
            })
    }

    /// A valve of this model with these friction bands, stuck at 0.
    ///
    /// [`HeWang`] gets an overshoot of 1.99, the value recalled for a typical valve; [`Stenman`]
    /// takes `J` for its band, [`Play`] takes `S` for its dead band.
    ///
    /// # Errors
    /// If the model does not allow these bands.
    pub fn build(self, bands: Bands) -> Result<AnyModel> {
        Ok(match self {
            Self::TwoPhase => AnyModel::TwoPhase(TwoPhase::new(bands)),
            Self::Choudhury => AnyModel::Choudhury(Choudhury::new(bands)),
            Self::Kano => AnyModel::Kano(Kano::new(bands)),
            Self::He => AnyModel::He(He::new(bands)),
            Self::HeWang => AnyModel::HeWang(HeWang::new(bands, HeWang::TYPICAL_OVERSHOOT)?),
            Self::Stenman => AnyModel::Stenman(Stenman::new(bands.j())?),
            Self::Chen => AnyModel::Chen(Chen::new(bands)),
            Self::Play => AnyModel::Play(Play::new(bands.s())?),
            Self::Ideal => AnyModel::Ideal(Ideal::new()),
        })
    }
}

/// A valve of any model.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)]
pub enum AnyModel {
    TwoPhase(TwoPhase),
    Choudhury(Choudhury),
    Kano(Kano),
    He(He),
    HeWang(HeWang),
    Stenman(Stenman),
    Chen(Chen),
    Play(Play),
    Ideal(Ideal),
}

/// Evaluates `$body` with `$valve` bound to the concrete model inside `$any`.
macro_rules! with_model {
    ($any:expr, $valve:ident => $body:expr) => {
        match $any {
            $crate::valve::AnyModel::TwoPhase($valve) => $body,
            $crate::valve::AnyModel::Choudhury($valve) => $body,
            $crate::valve::AnyModel::Kano($valve) => $body,
            $crate::valve::AnyModel::He($valve) => $body,
            $crate::valve::AnyModel::HeWang($valve) => $body,
            $crate::valve::AnyModel::Stenman($valve) => $body,
            $crate::valve::AnyModel::Chen($valve) => $body,
            $crate::valve::AnyModel::Play($valve) => $body,
            $crate::valve::AnyModel::Ideal($valve) => $body,
        }
    };
}

impl AnyModel {
    /// The state from which [`Valve::restart`] makes it go on as it does now; `None` if it remembers more.
    pub(crate) fn state(&self) -> Option<Start> {
        match self {
            Self::TwoPhase(valve) => Some(valve.state()),
            Self::Chen(valve) => Some(valve.state()),
            Self::Choudhury(_) | Self::Kano(_) => None,
            // All that they remember is where they are.
            Self::He(_) | Self::HeWang(_) | Self::Stenman(_) | Self::Play(_) | Self::Ideal(_) => {
                Some(Start::at_rest(self.position()))
            }
        }
    }
}

impl Valve for AnyModel {
    #[inline]
    fn step(&mut self, op: f64) -> f64 {
        with_model!(self, valve => valve.step(op))
    }

    fn position(&self) -> f64 {
        with_model!(self, valve => valve.position())
    }

    fn restart(&mut self, start: Start) {
        with_model!(self, valve => valve.restart(start));
    }

    // One dispatch for the whole slice instead of one a sample.
    fn run(&mut self, op: &[f64], vp: &mut [f64]) -> Result<()> {
        with_model!(self, valve => valve.run(op, vp))
    }
}

impl Remember for AnyModel {
    fn memory(&self) -> Memory {
        with_model!(self, valve => valve.memory())
    }

    fn recall(&mut self, memory: &Memory) {
        with_model!(self, valve => valve.recall(memory));
    }
}
