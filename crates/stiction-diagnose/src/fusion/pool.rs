//! What the windows of one valve say together: sums, which are added in any order.

use super::Weighed;
use super::confidence::logit;
use super::valves::Valves;
use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// What the windows of one valve say together, for [`Valves`].
///
/// For each window: log-odds of a fault, S with the width of its interval, detection limit, span of the OP, and the
/// features of the model. The weight of a window is the share of it that overlaps no earlier window. It holds their
/// sums, the sums of some squares, and the extremes of log-odds, limit and span.
///
/// Sums are of integers (multiples of `2^-20`), so they are the same to the bit in any order and however the windows
/// are grouped. It has about 2 kB, as text 3 kB, however many windows it has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pool {
    sums: Vec<i64>,
    least: [i64; 2],
    most: [i64; 2],
}

/// One, as a multiple of the unit of sums.
const ONE: f64 = (1 << 20) as f64;
/// The largest value; larger ones, in features only, count as this.
const LARGEST: f64 = (1 << 26) as f64;
/// Log-odds beyond the log-odds of this probability count as these.
const SUREST: f64 = 0.999;
/// Standard deviation of `ln S` below which an interval counts as no narrower.
const NARROWEST: f64 = 0.05;
/// Width of a 90 % interval in standard deviations.
const OF_INTERVAL: f64 = 3.29;

/// The sums of [`Pool`] that precede the sums of the features, in their order.
const SUMS: usize = 13;

/// The numbers of a row before the means of the features, and the sign by which each may affect the probability.
pub const SUMMARY: [(&str, i8); 16] = [
    ("windows", 0),
    ("log-odds, mean", 1),
    ("log-odds, standard deviation", 0),
    ("log-odds, least", 1),
    ("log-odds, most", 1),
    ("log-odds, sum of those above 0", 1),
    ("share above 0", 1),
    ("share above 2", 1),
    ("share below -2", -1),
    ("information on S", 0),
    ("ln(S/span), weighted mean", 0),
    ("ln S, weighted standard deviation", 0),
    ("share with a limit", 0),
    ("ln(limit/span), mean", 0),
    ("ln(limit/span), least", 0),
    ("ln span, most less mean", 0),
];

fn whole(value: f64) -> i64 {
    (value.clamp(-LARGEST, LARGEST) * ONE).round() as i64
}

impl Pool {
    /// A pool without windows, for this number of features.
    fn empty(features: usize) -> Self {
        Self { sums: vec![0; SUMS + 2 * features], least: [i64::MAX; 2], most: [i64::MIN; 2] }
    }

    /// The pool of one window: the results of a window's model, its span of the OP, percent, the values of all
    /// features, and the share of the window that overlaps no other. `features` are the places of the model's features
    /// among the values.
    pub fn of(
        says: &Weighed,
        op_span: f64,
        values: &[f64],
        share: f64,
        features: &[usize],
    ) -> Self {
        let p = says.probability.clamp(1.0 - SUREST, SUREST);
        let (l, ln_span) = (logit(p), op_span.ln());
        let ln_s = says.s.value.ln();
        let sd = ((says.s.high / says.s.low).ln() / OF_INTERVAL).max(NARROWEST);
        let known = p / (sd * sd);
        let ln_limit = says.limit.filter(|l| l.is_finite() && *l > 0.0).map(|l| l.ln() - ln_span);
        let count = |is: bool| if is { 1.0 } else { 0.0 };
        let own: [f64; SUMS] = [
            1.0,
            l,
            l * l,
            l.max(0.0),
            count(l > 0.0),
            count(l > 2.0),
            count(l < -2.0),
            known,
            known * ln_s,
            known * ln_s * ln_s,
            count(ln_limit.is_some()),
            ln_limit.unwrap_or(0.0),
            ln_span,
        ];
        let values = features.iter().map(|k| values.get(*k).copied().unwrap_or(f64::NAN));
        let of_features = values.flat_map(|v| if v.is_finite() { [v, 1.0] } else { [0.0, 0.0] });
        Self {
            sums: own.into_iter().chain(of_features).map(|v| whole(share * v)).collect(),
            least: [whole(l), ln_limit.map_or(i64::MAX, whole)],
            most: [whole(l), whole(ln_span)],
        }
    }

    /// Adds the windows of another pool of the same valve and model.
    pub fn merge(&mut self, other: &Self) {
        self.sums.iter_mut().zip(&other.sums).for_each(|(a, b)| *a = a.saturating_add(*b));
        self.least.iter_mut().zip(&other.least).for_each(|(a, b)| *a = *b.min(a));
        self.most.iter_mut().zip(&other.most).for_each(|(a, b)| *a = *b.max(a));
    }

    /// The pool of all windows of several pools; `None` for an empty list.
    pub fn merged<'a>(pools: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        let mut pools = pools.into_iter();
        let mut all = pools.next()?.clone();
        pools.for_each(|pool| all.merge(pool));
        Some(all)
    }

    /// Number of windows, with overlaps counted once.
    pub fn windows(&self) -> f64 {
        self.sums[0] as f64 / ONE
    }

    /// The mean of `ln S`, S in percent of span. The weight of each window is the probability that it sticks, over the
    /// square of its interval.
    pub fn mean_ln_s(&self) -> f64 {
        self.sums[8] as f64 / self.sums[7] as f64
    }

    /// The [`SUMMARY`] and the mean of each feature, as inputs of the trees. Unknown values are NaN.
    pub fn row(&self) -> Vec<f32> {
        let sum = |k: usize| self.sums[k] as f64 / ONE;
        let over = |a: f64, b: f64| if b > 0.0 { a / b } else { f64::NAN };
        let n = sum(0);
        let mean = |k: usize| over(sum(k), n);
        // Below a hundredth it is the rounding of the sums.
        let deviation = |square: f64, mean: f64| match square - mean * mean {
            known if known > 1e-4 => known.sqrt(),
            _ => 0.0,
        };
        let extreme = |x: i64| match x {
            i64::MAX | i64::MIN => f64::NAN,
            x => x as f64 / ONE,
        };
        let (ln_s, ln_span) = (over(sum(8), sum(7)), mean(12));
        let own = [
            n,
            mean(1),
            deviation(mean(2), mean(1)),
            extreme(self.least[0]),
            extreme(self.most[0]),
            sum(3),
            mean(4),
            mean(5),
            mean(6),
            sum(7).ln(),
            ln_s - ln_span,
            deviation(over(sum(9), sum(7)), ln_s),
            mean(10),
            over(sum(11), sum(10)),
            extreme(self.least[1]),
            extreme(self.most[1]) - ln_span,
        ];
        let of_features = self.sums[SUMS..].chunks_exact(2);
        let means = of_features.map(|of| over(of[0] as f64 / ONE, of[1] as f64 / ONE));
        super::row(&own.into_iter().chain(means).collect::<Vec<_>>())
    }
}

/// As in [`Display`](fmt::Display).
#[cfg(feature = "serde")]
impl serde::Serialize for Pool {
    fn serialize<S: serde::Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

/// All its integers, with the model that they are for.
impl fmt::Display for Pool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", Valves::shipped().map_or("none", |valves| &valves.name))?;
        let all = self.sums.iter().chain(&self.least).chain(&self.most);
        all.into_iter().try_for_each(|number| write!(f, " {number}"))
    }
}

/// Reads what [`Display`](fmt::Display) writes, of the model in the library.
impl FromStr for Pool {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let refused = |why: &str| Error::Inconsistent(format!("the pool of windows {why}"));
        let mut words = text.split(' ');
        let valves = Valves::shipped()?;
        let mut pool = Self::empty(valves.features.len());
        if words.next() != Some(&valves.name) {
            return Err(refused("is of another model: judge the recording again"));
        }
        let places = pool.sums.iter_mut().chain(&mut pool.least).chain(&mut pool.most);
        for place in places {
            let word = words.next().ok_or_else(|| refused("ends too early"))?;
            *place = word.parse().map_err(|_| refused(&format!("has no number at {word:?}")))?;
        }
        match (words.next(), pool.sums[0] > 0) {
            (None, true) => Ok(pool),
            (None, false) => Err(refused("has no windows")),
            (Some(_), _) => Err(refused("continues after its end")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cause::Cause;
    use crate::estimate::Estimate;
    use crate::evidence::features;
    use proptest::prelude::*;

    fn says(probability: f64, s: f64, limit: Option<f64>) -> Weighed {
        Weighed {
            probability,
            lines: vec![],
            causes: Cause::ALL.map(|cause| (cause, 0.0)),
            s: Estimate { value: s, low: 0.8 * s, high: 1.4 * s },
            j_over_s: Estimate { value: 0.5, low: 0.2, high: 0.9 },
            limit,
            distance: 0.5,
            mismatch: 0.1,
        }
    }

    /// The pool of a window of the model in the library.
    fn window(probability: f64, s: f64, limit: Option<f64>, values: f64) -> Pool {
        let values: Vec<f64> = (0..features().count()).map(|k| values + (k as f64).sin()).collect();
        let places = &Valves::shipped().unwrap().features;
        Pool::of(&says(probability, s, limit), 12.0, &values, 1.0, places)
    }

    proptest! {
        #[test]
        fn windows_give_the_same_however_they_are_grouped(
            windows in prop::collection::vec((0.0..=1.0f64, 0.1..30.0f64, any::<bool>(), -2.0..2.0f64), 1..60),
            cuts in prop::collection::vec(any::<bool>(), 60),
            turn in 0..60usize,
        ) {
            let all: Vec<Pool> = windows
                .iter()
                .map(|(p, s, known, v)| window(*p, *s, known.then_some(*s), *v))
                .collect();
            let at_once = Pool::merged(&all).unwrap();
            let mut groups: Vec<Vec<Pool>> = vec![vec![]];
            for (each, cut) in all.iter().zip(cuts) {
                if cut && !groups.last().unwrap().is_empty() {
                    groups.push(vec![]);
                }
                groups.last_mut().unwrap().push(each.clone());
            }
            let middle = turn % groups.len();
            groups.rotate_left(middle);
            // As text between, as in a store.
            let kept = groups.iter().map(|group| Pool::merged(group).unwrap().to_string());
            let back: Vec<Pool> = kept.map(|text| text.parse().unwrap()).collect();
            prop_assert_eq!(Pool::merged(&back).unwrap(), at_once);
        }

        #[test]
        fn more_suspicion_in_each_window_never_lowers_the_probability(
            windows in prop::collection::vec((0.01..0.9f64, -1.0..1.0f64), 1..12),
            more in 0.0..0.09f64,
        ) {
            let valves = Valves::shipped().unwrap();
            let of = |more: f64| {
                // With S and its weight alike, only the log-odds differ, and by as much in each.
                let shift = |p: f64| super::super::sigmoid(logit(p) + more);
                let all: Vec<Pool> =
                    windows.iter().map(|(p, v)| window(shift(*p), 3.0, Some(2.0), *v)).collect();
                let mut pool = Pool::merged(&all).unwrap();
                pool.sums[7] = ONE as i64;
                pool.sums[8] = ONE as i64;
                pool.sums[9] = ONE as i64;
                valves.weigh(&pool).probability
            };
            // Standard deviations differ only where log-odds meet their bound.
            prop_assert!(of(more) >= of(0.0) - 1e-12);
        }
    }

    #[test]
    fn a_pool_is_small_and_its_numbers_mean_what_they_say() {
        let one = window(0.7, 4.0, Some(2.0), 0.3);
        let many = Pool::merged(&vec![one.clone(); 1_000]).unwrap();
        assert!(many.to_string().len() < 8_000, "{}", many.to_string().len());
        assert_eq!((one.windows(), many.windows()), (1.0, 1_000.0));
        let (row, single) = (many.row(), one.row());
        for (k, (name, _)) in SUMMARY.iter().enumerate() {
            if !["windows", "log-odds, sum of those above 0", "information on S"].contains(name) {
                assert!((row[k] - single[k]).abs() < 1e-2 || row[k].is_nan(), "{name}");
            }
        }
        assert!(
            row[SUMMARY.len()..]
                .iter()
                .zip(&single[SUMMARY.len()..])
                .all(|(a, b)| (a - b).abs() < 1e-4)
        );
        assert!((single[1] - logit(0.7) as f32).abs() < 1e-4);
        assert!((one.mean_ln_s() - 4f64.ln()).abs() < 1e-4);
        // What overlaps others counts by its own share.
        let places = &Valves::shipped().unwrap().features;
        let half = Pool::of(&says(0.7, 4.0, Some(2.0)), 12.0, &[], 0.5, places);
        assert_eq!(half.windows(), 0.5);
        assert!((half.row()[1] - single[1]).abs() < 1e-4);
    }

    #[test]
    fn a_text_that_is_no_pool_is_refused() {
        let text = window(0.7, 4.0, None, 0.3).to_string();
        assert_eq!(text.parse::<Pool>().unwrap().to_string(), text);
        let (name, numbers) = text.split_once(' ').unwrap();
        for wrong in [
            String::new(),
            format!("other {numbers}"),
            format!("{name} "),
            text.replacen(' ', " x", 1),
            text.rsplit_once(' ').unwrap().0.to_owned(),
            format!("{text} 1"),
            format!("{name} {}", vec!["0"; numbers.split(' ').count()].join(" ")),
        ] {
            assert!(wrong.parse::<Pool>().is_err(), "{wrong}");
        }
    }
}
