//! The published detectors of stiction, one file each, behind one trait and one registry.
//!
//! A detector is given a [`Subject`]: one segment of a recording with what is known about its loop.
//! It answers with a [`Finding`]: its statistic, its threshold, its decision, the numbers between,
//! and, where it does not apply, why it abstains. Each also has its own method that returns a typed
//! result with all that a plot of its evidence needs.
//!
//! Detectors differ in what they assume, need and mean; none is right on all loops. Thresholds are the
//! published ones; where those could only be recalled, the documentation of the detector says so.

mod area_ratio;
mod bicoherence;
mod butterfly;
mod counts;
mod curvature;
mod curve_fit;
mod damarla_regression;
mod damarla_sigmoid;
mod damarla_steadiness;
mod ellipse;
mod finding;
mod horch;
mod horch_density;
mod kano;
mod model_fit;
mod registry;
mod relay_fit;
mod shapes;
mod sharp_corner;
mod square_wave;
mod stuck;
mod subject;
mod surrogates;
mod valve_position;
mod windows;
mod yamashita;
mod yamashita_level;

pub use crate::Number;
pub use area_ratio::{AreaRatio, AreaRatioResult, Areas};
pub use bicoherence::{Bicoherence, BicoherenceOp, BicoherencePlane, BicoherenceResult, Bin};
pub use butterfly::{Butterfly, ButterflyResult};
pub use counts::Counts;
pub use curve_fit::{CurveFit, CurveFitResult, CurveFitWave};
pub use damarla_regression::{DamarlaRegression, DamarlaRegressionResult};
pub use damarla_sigmoid::{DamarlaSigmoid, DamarlaSigmoidResult};
pub use damarla_steadiness::{DamarlaTest, DamarlaTestResult, Steadiness, SteadinessTest};
pub use ellipse::{Ellipse, EllipseSource};
pub use finding::{Abstention, Decision, Finding};
pub use horch::{Horch, HorchResult};
pub use horch_density::{HorchDensity, HorchDensityResult};
pub use kano::{Kano, KanoResult};
pub use model_fit::{FittedBy, ModelFit, ModelFitResult};
pub use registry::{all, by_name};
pub use relay_fit::{RelayFit, RelayFitResult, RelayFitWave};
pub use shapes::{Relay, Triangle};
pub use sharp_corner::{SharpCorner, SharpCornerCycle, SharpCornerResult};
pub use square_wave::{SquareWave, SquareWaveFit, SquareWaveResult};
pub use stuck::StuckSpan;
pub use subject::{ControlError, ErrorSource, Subject};
pub use surrogates::{Surrogates, SurrogatesResult};
pub use valve_position::{Measured, MeasuredValve, Rest, Spread, ValvePosition};
pub use yamashita::{Follower, Yamashita, YamashitaResult};
pub use yamashita_level::{YamashitaLevel, YamashitaLevelResult};

/// What a method is, before it sees any data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Method {
    /// Which it is.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub id: MethodId,
    /// Its name in commands and files, such as `horch`.
    pub name: &'static str,
    /// Its title, such as `Horch's cross-correlation`.
    pub title: &'static str,
    /// Authors, year, journal; and whether its formulas were read or recalled.
    #[cfg_attr(feature = "serde", serde(rename = "reference"))]
    pub source: &'static str,
    /// Name of its statistic, with its unit if it has one. With every method of the registry, the larger it
    /// is, the more it speaks for a positive decision.
    #[cfg_attr(feature = "serde", serde(rename = "statistic_name"))]
    pub statistic: &'static str,
    /// The decision rule, a sentence with the thresholds.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub rule: &'static str,
    /// For which loops it was made.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub applies: Applies,
    /// What a positive decision means.
    #[cfg_attr(
        feature = "serde",
        serde(rename = "votes", serialize_with = "votes"),
        schemars(with = "bool")
    )]
    pub decides: Decides,
    /// The signals it cannot do without.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub needs: Needs,
    /// What it looks at.
    pub family: Family,
    /// Whether it was made to tell the cause of an oscillation that was found before; see [`judge`].
    #[cfg_attr(feature = "serde", serde(skip))]
    pub explains_oscillation: bool,
}

/// Whether the decision of a method is counted in the vote of its family.
#[cfg(feature = "serde")]
fn votes<S: serde::Serializer>(decides: &Decides, to: S) -> std::result::Result<S::Ok, S::Error> {
    to.serialize_bool(*decides == Decides::Stiction)
}

/// What a method looks at. Methods of one family see the same evidence, so they have one vote
/// together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Family {
    /// The measured valve position.
    Measured,
    /// The correlation of OP and PV.
    Correlation,
    /// The shape of the waves of one signal.
    Shape,
    /// Samples in which one signal moves and the other rests.
    Patterns,
    /// The path that the loop takes in the plane of OP and PV.
    PhasePlot,
    /// Short windows in which OP and PV move differently.
    Windows,
    /// Models of valve and process fitted to OP and PV.
    Model,
    /// Spectra of higher order and surrogate data.
    HigherOrder,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Measured,
        Self::Correlation,
        Self::Shape,
        Self::Patterns,
        Self::PhasePlot,
        Self::Windows,
        Self::Model,
        Self::HigherOrder,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Measured => "measured position",
            Self::Correlation => "correlation",
            Self::Shape => "wave shape",
            Self::Patterns => "patterns",
            Self::PhasePlot => "phase plot",
            Self::Windows => "windows",
            Self::Model => "model fits",
            Self::HigherOrder => "higher order",
        }
    }
}

/// What a detector says of a segment, the published precondition of its method included.
///
/// Methods that tell the cause of an oscillation are applied, in their publications, to loops in which
/// one was found before. Where none was found (the subject has no period) such a method abstains; the
/// statistic stays, for whoever wants to see it.
pub fn judge(detector: &dyn Detector, subject: &Subject<'_>) -> Finding {
    let mut finding = detector.judge(subject);
    let judged = finding.decision != Decision::Abstains;
    if judged && detector.method().explains_oscillation && subject.period.is_none() {
        finding.reason = format!(
            "tells the cause of an oscillation, and none was found (it would say: {})",
            finding.decision.name()
        );
        finding.decision = Decision::Abstains;
    }
    finding
}

/// The loops a method was made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Applies {
    /// Any.
    AnyLoop,
    /// Those with a self-regulating process.
    SelfRegulating,
    /// Those with an integrating process.
    Integrating,
}

/// What a positive decision of a method means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decides {
    /// That the valve sticks; such methods vote.
    Stiction,
    /// That something in the loop is not linear, whatever it is; such methods do not vote.
    Nonlinearity,
}

/// The signals a method cannot do without.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// OP alone.
    Op,
    /// OP and PV.
    OpAndPv,
    /// The control error, from PV and, where it is recorded, SP.
    Error,
    /// OP and a measured valve position.
    OpAndVp,
}

/// A method with its parameters.
pub trait Detector: Send + Sync {
    /// What it is.
    fn method(&self) -> &'static Method;
    /// Its parameters as they are set.
    fn parameters(&self) -> Vec<Number>;
    /// What it says of a segment and what it looked at; [`judge`](Self::judge) adds the parameters.
    ///
    /// # Errors
    /// If it does not apply, or the data do not suffice.
    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention>;
    /// What it says of a segment. It never fails: what it cannot judge, it abstains from.
    fn judge(&self, subject: &Subject<'_>) -> Finding {
        let found = self.look(subject);
        let finding = found.unwrap_or_else(|why| Finding::abstains(self.method(), why));
        Finding { parameters: self.parameters(), ..finding }
    }
}

registry::methods! {
    Direct: ValvePosition::default(),
    YamashitaVp: Yamashita { follower: Follower::Vp, ..Yamashita::default() },
    Horch: Horch::default(),
    HorchDensity: HorchDensity::default(),
    AreaRatio: AreaRatio::default(),
    CurveFit: CurveFit::default(),
    RelayFit: RelayFit::default(),
    SquareWave: SquareWave::default(),
    Yamashita: Yamashita::default(),
    YamashitaLevel: YamashitaLevel::default(),
    Kano: Kano::default(),
    SharpCorner: SharpCorner::default(),
    Butterfly: Butterfly::default(),
    DamarlaRegression: DamarlaRegression::default(),
    DamarlaFTest: DamarlaTest::new(SteadinessTest::FTest),
    DamarlaTTest: DamarlaTest::new(SteadinessTest::TTest),
    DamarlaHotelling: DamarlaTest::new(SteadinessTest::Hotelling),
    DamarlaReverseArrangements: DamarlaTest::new(SteadinessTest::ReverseArrangements),
    DamarlaSigmoid: DamarlaSigmoid::default(),
    Srinivasan: ModelFit::new(FittedBy::Srinivasan),
    Lee: ModelFit::new(FittedBy::Lee),
    Jelali: ModelFit::new(FittedBy::Jelali),
    KarraKarim: ModelFit::new(FittedBy::KarraKarim),
    Bicoherence: Bicoherence::default(),
    BicoherenceOp: BicoherenceOp::default(),
    Surrogates: Surrogates::default(),
}

/// What a method looked at: its typed result, one kind for all methods that share it.
#[derive(Debug, Clone, PartialEq)]
pub enum LookedAt {
    /// Rests and slips of a measured valve position.
    ValvePosition(MeasuredValve),
    /// Patterns of the OP and of what follows it.
    Yamashita(YamashitaResult),
    /// The cross-correlation of OP and PV.
    Horch(HorchResult),
    /// How the PV bends.
    HorchDensity(HorchDensityResult),
    /// The areas of half waves before and after their peaks.
    AreaRatio(AreaRatioResult),
    /// Half waves with triangle and sine.
    CurveFit(CurveFitResult),
    /// Half waves with the response to a relay, triangle and sine.
    RelayFit(RelayFitResult),
    /// Half waves with square wave and sine.
    SquareWave(SquareWaveResult),
    /// How the PV of a level bends.
    YamashitaLevel(YamashitaLevelResult),
    /// Rests of the PV while the OP travels.
    Kano(KanoResult),
    /// Cycles of OP and error with their corners.
    SharpCorner(SharpCornerResult),
    /// The wings of PV and OP.
    Butterfly(ButterflyResult),
    /// Windows by the slopes of OP and PV.
    DamarlaRegression(DamarlaRegressionResult),
    /// Windows by a test of steadiness.
    DamarlaTest(DamarlaTestResult),
    /// OP over increments of the PV.
    DamarlaSigmoid(DamarlaSigmoidResult),
    /// A fitted model of valve and process.
    ModelFit(ModelFitResult),
    /// The bicoherence of the error, and the ellipse of PV and OP.
    Bicoherence(BicoherenceResult),
    /// The bicoherence of the OP.
    BicoherenceOp(BicoherencePlane),
    /// Prediction errors of surrogates.
    Surrogates(SurrogatesResult),
}
