//! All detectors, by name.

use super::Detector;
use super::{
    AreaRatio, Bicoherence, BicoherenceOp, Butterfly, CurveFit, DamarlaRegression, DamarlaSigmoid,
    DamarlaTest, FittedBy, Follower, Horch, HorchDensity, Kano, ModelFit, RelayFit, SharpCorner,
    SquareWave, SteadinessTest, Surrogates, ValvePosition, Yamashita, YamashitaLevel,
};
use crate::error::{Error, Result};

/// All detectors with their published parameters, in the order of reports: those of the measured
/// valve position, of the shape of the signals, of patterns, of the phase plot, of windows, of fitted
/// models, and of nonlinearity.
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
        Box::new(ModelFit::new(FittedBy::Srinivasan)),
        Box::new(ModelFit::new(FittedBy::Lee)),
        Box::new(ModelFit::new(FittedBy::Jelali)),
        Box::new(ModelFit::new(FittedBy::KarraKarim)),
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

#[cfg(test)]
mod tests {
    use super::super::{Decides, Decision, Subject};
    use super::*;
    use crate::recording::{LoopType, Stretch};

    #[test]
    fn every_method_is_described_and_found_by_its_name() {
        let detectors = all();
        for (i, detector) in detectors.iter().enumerate() {
            let method = detector.method();
            assert!(detectors[..i].iter().all(|other| other.method().name != method.name));
            for text in [method.title, method.source, method.statistic, method.rule] {
                assert!(!text.trim().is_empty() && !text.contains("  "), "{}: {text}", method.name);
            }
            let numbers = method.rule.chars().any(|c| c.is_ascii_digit());
            assert!(
                numbers || method.rule.contains("threshold"),
                "{}: {}",
                method.name,
                method.rule
            );
            let parameters = detector.parameters();
            assert!(!parameters.is_empty(), "{}", method.name);
            assert!(parameters.iter().all(|p| !p.name.is_empty() && p.value.is_finite()));
            assert_eq!(by_name(&method.name.to_uppercase()).unwrap().method(), method);
        }
        let Err(error) = by_name("nonesuch") else { panic!() };
        assert!(error.to_string().contains(detectors[0].method().name));
    }

    /// Stretches no one should record.
    fn zoo() -> Vec<Stretch> {
        let mut zoo = vec![];
        let wave = |k: usize| (0.3 * k as f64).sin();
        let mut add = |op: Vec<f64>, pv: Option<Vec<f64>>, sp: Option<Vec<f64>>| {
            let vp = pv.clone();
            zoo.push(Stretch { from: 0.0, sample_time: 1.0, op, pv, sp, vp, bridged: 0 });
        };
        for n in [0, 1, 2, 3, 4, 5, 17, 64, 300, 1000] {
            let series = |f: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..n).map(f).collect() };
            let waves = series(&wave);
            let other = series(&|k| (0.3 * k as f64 + 1.0).sin());
            add(waves.clone(), None, None);
            add(waves.clone(), Some(waves.clone()), None);
            add(waves.clone(), Some(other.clone()), Some(series(&|_| 1.0)));
            add(series(&|_| 50.0), Some(series(&|_| 0.1)), None);
            add(waves.clone(), Some(series(&|_| 0.1)), None);
            add(series(&|_| 0.1), Some(waves.clone()), None);
            add(series(&|k| k as f64), Some(series(&|k| -(k as f64))), None);
            add(series(&|k| (k % 2) as f64), Some(series(&|k| (k % 3) as f64)), None);
            add(series(&|k| f64::from(k == 7)), Some(series(&|k| f64::from(k == 9))), None);
            for scale in [1e300, f64::MAX, 1e-300, f64::MIN_POSITIVE, 1e160] {
                let scaled = |x: &[f64]| -> Vec<f64> { x.iter().map(|v| v * scale).collect() };
                add(scaled(&waves), Some(scaled(&other)), None);
                add(waves.clone(), Some(scaled(&other)), Some(scaled(&waves)));
                add(scaled(&waves), Some(other.clone()), None);
            }
        }
        zoo
    }

    #[test]
    fn nothing_makes_a_detector_panic_or_answer_in_another_kind() {
        let periods = [None, Some(0.0), Some(4.0), Some(21.0), Some(1e9), Some(f64::NAN)];
        let types = [LoopType::Unknown, LoopType::Level];
        for stretch in zoo() {
            for (period, loop_type) in
                periods.into_iter().flat_map(|period| types.map(|loop_type| (period, loop_type)))
            {
                let subject = Subject::new(&stretch, loop_type, period);
                for detector in all() {
                    let finding = detector.judge(&subject);
                    assert_eq!(finding.method, detector.method());
                    assert!(!finding.reason.is_empty());
                    let kind = match detector.method().decides {
                        Decides::Stiction => {
                            !matches!(finding.decision, Decision::Nonlinear | Decision::Linear)
                        }
                        Decides::Nonlinearity => {
                            !matches!(finding.decision, Decision::Sticks | Decision::DoesNotStick)
                        }
                    };
                    assert!(kind, "{}", detector.method().name);
                    let abstains = finding.decision == Decision::Abstains;
                    assert_eq!(abstains, finding.statistic.is_none(), "{}", detector.method().name);
                    // A method without a known threshold tells its statistic and decides nothing.
                    let open = abstains || finding.decision == Decision::Undecided;
                    assert!(open || finding.threshold.is_some(), "{}", detector.method().name);
                }
            }
        }
    }
}
