//! The methods. Each has its own folder, and all share a trait and a registry.
//!
//! A detector gets a [`Subject`]: one segment of a recording and the information about its loop. It returns a
//! [`Finding`](crate::finding::Finding) with its statistic, threshold, decision and intermediate numbers, or the reason
//! for abstaining. Each also has its own method that returns a typed result with the data for a plot of its evidence.
//!
//! Detectors differ in their assumptions, needs and meaning. No detector is right on all loops. Each method documents
//! which of its equations and thresholds were read, which were recalled, and which are ours.
//!
//! A folder contains the computation (`mod.rs`) and the figure of its evidence (`figure.rs`, with the feature
//! `figure`); `shared` contains the common parts of several methods.
//!
#![doc = include_str!("basis.md")]

pub mod area_ratio;
pub mod bicoherence;
pub mod bicoherence_op;
pub mod butterfly;
pub mod curve_fit;
pub mod damarla_regression;
pub mod damarla_sigmoid;
pub mod damarla_steadiness;
pub mod horch;
pub mod horch_density;
pub mod kano;
pub mod model_fit;
pub mod relay_fit;
pub mod sharp_corner;
pub mod square_wave;
pub mod surrogates;
pub mod valve_position;
pub mod yamashita;
pub mod yamashita_level;

mod counts;
mod detector;
mod registry;
mod shared;
mod subject;

pub use counts::Counts;
pub use detector::{Detector, judge};
#[cfg(feature = "figure")]
pub use registry::figure;
pub use registry::{all, by_name, looked_at};
pub use shared::ellipse::{Ellipse, EllipseSource};
pub use shared::shapes::{Relay, Triangle};
pub use shared::stuck::StuckSpan;
pub use subject::{ControlError, ErrorSource, Subject};

// In the order of reports: methods of the measured valve position, of the shape of the signals, of patterns, of the
// phase plot, of windows, of fitted models, and of nonlinearity.
registry::methods! {
    Direct of valve_position: ValvePosition::default(),
    YamashitaVp of yamashita: Yamashita { follower: Follower::Vp, ..Yamashita::default() },
    Horch of horch: Horch::default(),
    HorchDensity of horch_density: HorchDensity::default(),
    AreaRatio of area_ratio: AreaRatio::default(),
    CurveFit of curve_fit: CurveFit::default(),
    RelayFit of relay_fit: RelayFit::default(),
    SquareWave of square_wave: SquareWave::default(),
    Yamashita of yamashita: Yamashita::default(),
    YamashitaLevel of yamashita_level: YamashitaLevel::default(),
    Kano of kano: Kano::default(),
    SharpCorner of sharp_corner: SharpCorner::default(),
    Butterfly of butterfly: Butterfly::default(),
    DamarlaRegression of damarla_regression: DamarlaRegression::default(),
    DamarlaFTest of damarla_steadiness: DamarlaTest::new(SteadinessTest::FTest),
    DamarlaTTest of damarla_steadiness: DamarlaTest::new(SteadinessTest::TTest),
    DamarlaHotelling of damarla_steadiness: DamarlaTest::new(SteadinessTest::Hotelling),
    DamarlaReverseArrangements of damarla_steadiness: DamarlaTest::new(SteadinessTest::ReverseArrangements),
    DamarlaSigmoid of damarla_sigmoid: DamarlaSigmoid::default(),
    Srinivasan of model_fit: ModelFit::new(FittedBy::Srinivasan),
    Lee of model_fit: ModelFit::new(FittedBy::Lee),
    Jelali of model_fit: ModelFit::new(FittedBy::Jelali),
    KarraKarim of model_fit: ModelFit::new(FittedBy::KarraKarim),
    Bicoherence of bicoherence: Bicoherence::default(),
    BicoherenceOp of bicoherence_op: BicoherenceOp::default(),
    Surrogates of surrogates: Surrogates::default(),
}
