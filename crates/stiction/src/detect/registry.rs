//! All detectors, by name.

use super::Detector;
use super::{
    AreaRatio, Bicoherence, BicoherenceOp, Butterfly, CurveFit, DamarlaRegression, DamarlaSigmoid,
    DamarlaTest, Follower, Horch, HorchDensity, Kano, RelayFit, SharpCorner, SquareWave,
    SteadinessTest, Surrogates, ValvePosition, Yamashita, YamashitaLevel,
};
use crate::error::{Error, Result};

/// All detectors with their published parameters, in the order of reports: those of the measured
/// valve position, of the shape of the signals, of patterns, of the phase plot, of windows, and of
/// nonlinearity.
pub fn all() -> Vec<Box<dyn Detector>> {
    vec![
        Box::new(ValvePosition::default()),
        Box::new(Yamashita { follower: Follower::Vp, ..Yamashita::default() }),
        Box::new(Horch::default()),
        Box::new(HorchDensity::default()),
        Box::new(AreaRatio::default()),
        Box::new(CurveFit::default()),
        Box::new(RelayFit::default()),
        Box::new(SquareWave::default()),
        Box::new(Yamashita::default()),
        Box::new(YamashitaLevel::default()),
        Box::new(Kano::default()),
        Box::new(SharpCorner::default()),
        Box::new(Butterfly::default()),
        Box::new(DamarlaRegression::default()),
        Box::new(DamarlaTest::new(SteadinessTest::FTest)),
        Box::new(DamarlaTest::new(SteadinessTest::TTest)),
        Box::new(DamarlaTest::new(SteadinessTest::Hotelling)),
        Box::new(DamarlaTest::new(SteadinessTest::ReverseArrangements)),
        Box::new(DamarlaSigmoid::default()),
        Box::new(Bicoherence::default()),
        Box::new(BicoherenceOp::default()),
        Box::new(Surrogates::default()),
    ]
}

/// The detector called `name`, in any case.
///
/// # Errors
/// If there is none; the message names those there are.
pub fn by_name(name: &str) -> Result<Box<dyn Detector>> {
    let mut detectors = all();
    match detectors.iter().position(|d| d.method().name.eq_ignore_ascii_case(name.trim())) {
        Some(i) => Ok(detectors.swap_remove(i)),
        None => {
            let known: Vec<&str> = detectors.iter().map(|d| d.method().name).collect();
            Err(Error::UnknownName {
                family: "detector",
                name: name.to_owned(),
                known: known.join(", "),
            })
        }
    }
}
