//! Distance of recordings from simulated loops, feature by feature, without labels.
//!
//! A model trained on simulated loops is valid for similar loops. For every feature, the *place* is the share of
//! simulated values that a recorded one exceeds, averaged over the recorded values (ties count half). It is 0.5 if both
//! are alike, and 0 or 1 if they do not overlap. It equals the area under the curve of a test that separates recordings
//! from simulations by this feature (Mann and Whitney 1947, recalled, not read). The simulated loops are the training
//! loops, represented by the quantiles in the frozen model. So a place is accurate to about a hundredth, and at least
//! 0.0005 from 0 or 1 for a value outside all of them.

use super::Reference;
use crate::evidence::{Evidence, Feature, features};
use crate::series::quantile;

/// A feature in simulated and in recorded loops.
#[derive(Debug, Clone, PartialEq)]
pub struct Shift {
    /// The feature.
    pub feature: &'static Feature,
    /// Place of the recorded values among the simulated ones; `None` if either could not be measured at all.
    pub place: Option<f64>,
    /// The 5, 50 and 95 % quantiles of the simulated values; NaN of none.
    pub simulated: [f64; 3],
    /// Quantiles of the recorded values.
    pub recorded: [f64; 3],
    /// Shares of the simulated and of the recorded loops in which it could not be measured.
    pub missing: [f64; 2],
}

impl Shift {
    /// Their distance: 0 alike, 1 not overlapping.
    pub fn distance(&self) -> f64 {
        self.place.map_or(0.0, |place| (2.0 * place - 1.0).abs())
    }
}

/// The shift of every feature from the training loops, the largest first; equal ones in the order of [`features`].
pub fn shifts(simulated: &Reference, recorded: &[Evidence]) -> Vec<Shift> {
    let quantiles = |of: &dyn Fn(f64) -> f64| [0.05, 0.5, 0.95].map(of);
    let mut all: Vec<Shift> = features()
        .enumerate()
        .map(|(k, feature)| {
            let values: Vec<f64> =
                recorded.iter().map(|each| each.values[k]).filter(|v| v.is_finite()).collect();
            let missing = match recorded.len() {
                0 => 0.0,
                n => 1.0 - values.len() as f64 / n as f64,
            };
            let known = simulated.spread(k);
            let places: Option<Vec<f64>> =
                known.and_then(|spread| values.iter().map(|v| spread.place(*v)).collect());
            let places = places.filter(|places| !places.is_empty());
            let none = [f64::NAN; 3];
            Shift {
                feature,
                place: places.map(|all| all.iter().sum::<f64>() / all.len() as f64),
                simulated: known.map_or(none, |known| quantiles(&|share| known.quantile(share))),
                recorded: quantiles(&|share| quantile(&values, share)),
                missing: [known.map_or(1.0, |known| f64::from(known.missing)), missing],
            }
        })
        .collect();
    all.sort_by(|a, b| b.distance().total_cmp(&a.distance()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fusion::{QUANTILES, Spread, level, sigmoid};

    fn loops(values: &[f64]) -> Vec<Evidence> {
        let of = |v: &f64| Evidence {
            values: features()
                .map(|feature| if feature.name == "rho1" { *v } else { 1.0 })
                .collect(),
            op_span: 1.0,
            period_s: 1.0,
            model: None,
            dense: None,
            information: None,
        };
        values.iter().map(of).collect()
    }

    /// Loops of training in which the log-odds of the place of `rho1` are its value, and all else is 1.
    fn reference() -> Reference {
        let spread = |(k, feature): (usize, &Feature)| Spread {
            feature: k as u16,
            missing: 0.25,
            quantiles: (0..QUANTILES)
                .map(|k| if feature.name == "rho1" { level(k) as f32 } else { 1.0 })
                .collect(),
        };
        let spreads: Vec<Spread> = features().enumerate().map(spread).collect();
        let n = spreads.len();
        Reference { spreads, whitening: vec![0.0; n * (n + 1) / 2], threshold: 1.0 }
    }

    #[test]
    fn what_differs_most_stands_first() {
        let found = shifts(&reference(), &loops(&[1.0, 2.0, f64::NAN]));
        assert_eq!(found.len(), features().count());
        assert_eq!(found[0].feature.name, "rho1");
        let place = 0.5 * (sigmoid(1.0) + sigmoid(2.0));
        assert!((found[0].distance() - (2.0 * place - 1.0)).abs() < 1e-6);
        assert!((found[0].simulated[2] - 19f64.ln()).abs() < 1e-5);
        assert_eq!(found[0].recorded[1], 1.5);
        assert!((found[0].missing[1] - 1.0 / 3.0).abs() < 1e-12 && found[0].missing[0] == 0.25);
        assert!(found[1..].iter().all(|shift| shift.distance() == 0.0));
    }

    #[test]
    fn without_values_there_is_no_place() {
        let nothing = Reference { spreads: vec![], whitening: vec![], threshold: 1.0 };
        assert!(shifts(&nothing, &loops(&[1.0])).iter().all(|shift| shift.place.is_none()));
        assert!(shifts(&reference(), &[]).iter().all(|shift| shift.place.is_none()));
    }
}
