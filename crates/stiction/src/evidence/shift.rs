//! How far recordings are from simulated loops, feature by feature, without any label.
//!
//! A model that was trained on simulated loops means something on loops like them. For every feature, the
//! *place* is the share of simulated values that a recorded one exceeds, on average over the recorded ones
//! (ties count half): 0.5 if both are alike, 0 or 1 if they do not overlap. It is the area under the curve
//! of a test that tells recordings from simulations by this feature (Mann and Whitney 1947, recalled, not
//! read).

use super::{Evidence, Feature, features};
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
    /// Those of the recorded values.
    pub recorded: [f64; 3],
    /// Shares of the simulated and of the recorded loops in which it could not be measured.
    pub missing: [f64; 2],
}

impl Shift {
    /// How far apart they are: 0 alike, 1 not overlapping.
    pub fn distance(&self) -> f64 {
        self.place.map_or(0.0, |place| (2.0 * place - 1.0).abs())
    }
}

/// The shift of every feature, the largest first; of equal ones in the order of [`features`].
pub fn shifts(simulated: &[Evidence], recorded: &[Evidence]) -> Vec<Shift> {
    let column = |loops: &[Evidence], k: usize| -> Vec<f64> {
        let mut values: Vec<f64> =
            loops.iter().map(|each| each.values[k]).filter(|v| v.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let missing = |values: &[f64], loops: &[Evidence]| match loops.len() {
        0 => 0.0,
        n => 1.0 - values.len() as f64 / n as f64,
    };
    let quantiles = |values: &[f64]| [0.05, 0.5, 0.95].map(|share| quantile(values, share));
    let mut all: Vec<Shift> = features()
        .enumerate()
        .map(|(k, feature)| {
            let (of_simulated, of_recorded) = (column(simulated, k), column(recorded, k));
            Shift {
                feature,
                place: place(&of_simulated, &of_recorded),
                simulated: quantiles(&of_simulated),
                recorded: quantiles(&of_recorded),
                missing: [missing(&of_simulated, simulated), missing(&of_recorded, recorded)],
            }
        })
        .collect();
    all.sort_by(|a, b| b.distance().total_cmp(&a.distance()));
    all
}

/// Place of some values among others, both ascending.
fn place(among: &[f64], values: &[f64]) -> Option<f64> {
    if among.is_empty() || values.is_empty() {
        return None;
    }
    let exceeded = |v: &f64| {
        let below = among.partition_point(|a| a < v);
        let up_to = among.partition_point(|a| a <= v);
        0.5 * (below + up_to) as f64
    };
    Some(values.iter().map(exceeded).sum::<f64>() / (among.len() * values.len()) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loops(values: &[f64]) -> Vec<Evidence> {
        let of = |v: &f64| Evidence {
            values: features()
                .map(|feature| if feature.name == "rho1" { *v } else { 1.0 })
                .collect(),
            op_span: 1.0,
            period_s: 1.0,
            model: None,
            dense: None,
        };
        values.iter().map(of).collect()
    }

    #[test]
    fn places_and_distances() {
        assert_eq!(place(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0]), Some(0.5));
        assert_eq!(place(&[1.0, 2.0], &[3.0]), Some(1.0));
        assert_eq!(place(&[1.0, 2.0], &[1.0]), Some(0.25));
        assert_eq!(place(&[], &[1.0]), None);
    }

    #[test]
    fn what_differs_most_stands_first() {
        let found = shifts(&loops(&[0.0, 1.0, 2.0]), &loops(&[1.5, f64::NAN]));
        assert_eq!(found.len(), features().count());
        assert_eq!(found[0].feature.name, "rho1");
        assert!((found[0].distance() - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(found[0].missing, [0.0, 0.5]);
        assert!(found[1..].iter().all(|shift| shift.distance() == 0.0));
        assert_eq!(shifts(&[], &[])[0].place, None);
    }
}
