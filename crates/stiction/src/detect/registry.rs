//! All detectors, by name.

use super::Detector;
use super::{
    Bicoherence, BicoherenceOp, Butterfly, DamarlaRegression, DamarlaSigmoid, DamarlaTest,
    SharpCorner, SteadinessTest, Surrogates,
};
use crate::error::{Error, Result};

/// All detectors with their published parameters, in the order of reports: those of the shape of the
/// signals, of the phase plot, of windows, and of nonlinearity.
pub fn all() -> Vec<Box<dyn Detector>> {
    vec![
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
