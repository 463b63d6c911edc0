//! What a valve is asked for with, and what its model says of itself.

use stiction_model::valve::{Model, Motion, StemLag, Valve, ValveSpec};
use stiction_model::{Bands, Error};

fn spec(model: Model) -> ValveSpec {
    ValveSpec::new(model, Bands::from_s_j(5.0, 2.0).unwrap())
}

/// Along a slow sine, of which every move is below the rest tolerance asked for.
fn positions(spec: &ValveSpec) -> Vec<f64> {
    let op: Vec<f64> = (0..600).map(|k| 10.0 * (1.0 - (0.03 * f64::from(k)).cos())).collect();
    let mut vp = vec![0.0; op.len()];
    spec.build(Some(0.1)).unwrap().run(&op, &mut vp).unwrap();
    vp
}

#[test]
fn a_setting_makes_a_difference_or_is_refused() {
    for model in Model::ALL {
        let uses = model.describe();
        let plain = positions(&spec(model));
        let settings = [
            ("K", uses.uses_k, ValveSpec { overshoot: Some(1.3), ..spec(model) }),
            (
                "rest tolerance",
                uses.uses_rest_tolerance,
                ValveSpec { rest_tolerance: Some(6.0), ..spec(model) },
            ),
        ];
        for (setting, used, spec) in settings {
            if used {
                assert!(positions(&spec) != plain, "{model:?}, {setting}");
                continue;
            }
            match spec.build(Some(0.1)) {
                Err(Error::NotOfModel { name, models, .. }) => {
                    assert_eq!(name, setting);
                    assert!(
                        !models.is_empty() && models.split(", ").all(|m| m != uses.name),
                        "{models}"
                    );
                }
                other => panic!("{model:?}, {setting}: {other:?}"),
            }
        }
        let limited = ValveSpec { limits: Some((3.0, 9.0)), lag_s: 0.3, ..spec(model) };
        let by_hand = spec(model).build(None).unwrap().with_limits(3.0, 9.0).unwrap();
        let by_hand = by_hand.with_lag(StemLag::new(0.3, 0.1).unwrap());
        assert_eq!(limited.build(Some(0.1)), Ok(by_hand));
    }
}

#[test]
fn what_is_missing_or_out_of_range_is_named() {
    let missing = |error: Error| match error {
        Error::Missing { name, needed_by } => format!("{needed_by}: {name}"),
        other => panic!("{other}"),
    };
    assert_eq!(missing(Model::He.bands(Some(5.0), None).unwrap_err()), "he: J");
    assert_eq!(missing(Model::Play.bands(None, Some(1.0)).unwrap_err()), "play: S");
    assert_eq!(Model::Ideal.bands(None, None), Ok(Bands::NONE));
    let lagged = ValveSpec { lag_s: 1.0, ..spec(Model::Kano) };
    assert_eq!(missing(lagged.build(None).unwrap_err()), "stem lag: sample time");
    let resting = ValveSpec { rest_tolerance: Some(1.0), ..spec(Model::TwoPhase) };
    assert_eq!(missing(resting.build(None).unwrap_err()), "rest tolerance: sample time");
    let bad = |spec: ValveSpec| spec.build(Some(0.1)).unwrap_err().to_string();
    assert!(bad(ValveSpec { lag_s: f64::NAN, ..spec(Model::He) }).starts_with("stem lag is NaN"));
    assert!(bad(ValveSpec { limits: Some((9.0, 1.0)), ..spec(Model::He) }).contains("limit"));
    assert!(bad(ValveSpec { overshoot: Some(3.0), ..spec(Model::HeWang) }).starts_with("K is 3"));
    let unused: Vec<_> = Model::Stenman.unused(Some(5.0), Some(2.0)).collect();
    assert_eq!(unused, ["S"]);
}

#[test]
fn models_move_as_they_say() {
    for model in Model::ALL {
        let uses = model.describe();
        if let Some(other) = uses.same_as {
            assert_eq!(positions(&spec(model)), positions(&spec(other)), "{model:?}");
        }
        // A ramp, well beyond where the stem breaks away.
        let mut valve = spec(model).build(None).unwrap();
        let vp: Vec<f64> = (0..2_000).map(|k| valve.step(0.01 * f64::from(k))).collect();
        let rests = vp[1_000..].windows(2).filter(|x| x[0] == x[1]).count();
        let starts = vp.iter().position(|x| *x != 0.0).unwrap();
        let expected = match (starts, rests) {
            (1, 0) => Motion::Follows,
            (_, 0) => Motion::Slides,
            _ => Motion::Staircase,
        };
        assert_eq!(expected, uses.motion, "{model:?}");
    }
}
