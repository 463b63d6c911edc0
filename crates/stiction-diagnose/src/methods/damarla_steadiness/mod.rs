//! Statistical tests of neighbouring windows, four methods M1 to M4 (Damarla et al. 2023).
//!
//! # What it measures
//! While a valve sticks, the PV is steady and the OP is not. Short windows are tested for steadiness. Windows in which
//! the PV passes and the OP fails are marked, and Omega is the share marked. The OP travel in each run of marked
//! windows measures the stiction: `eta_95` is its 95th percentile.
//!
//! # Assumptions
//! The PV responds to the valve within a window: a flow loop, or windows about as long as the process time
//! constant. The samples of a window are independent and normal (not for M4).
//!
//! # Equations
//! For a window and the next one, each of `n` samples, with variances `s1`, `s2` (divisor n - 1) and
//! means `m1`, `m2`:
//! * M1, F-test of variances, one-sided: steady if `s1/s2 < F(1 - alpha; n - 1, n - 1)`;
//! * M2, pooled t-test of means: steady if `|m1 - m2| / sqrt((s1 + s2)/n) < t(1 - alpha; 2n - 2)`;
//! * M3, Hotelling's T² of one variable with modified degrees of freedom: steady if
//!   `n (m1 - m2)² / (s1 + s2) < F(1 - alpha; 1, f)`, `f = (n - 1) / (w² + (1 - w)²)`,
//!   `w = s1/(s1 + s2)`; it equals Welch's t-test, two-sided;
//! * M4, reverse arrangements within one window: with `A` the number of pairs of samples whose earlier one is
//!   larger, steady if `A` lies strictly between `n(n - 1)/4 ± (z sigma - 1/2)`, `sigma² = (2n³ + 3n² - 5n)/72`,
//!   `z` the normal quantile of `1 - alpha/2`.
//!
//! # Parameters
//! | name | default | unit | source |
//! |---|---|---|---|
//! | window | 8, M4: 3 | samples | read in the public implementation |
//! | alpha | 0.05 | | the same |
//! | confidence | 0.95 | | ours |
//!
//! # Limits
//! The published rule, Omega > 0, calls nearly every long recording sticky: chance alone marks 4.75 % of the
//! windows of white noise by M1 and M3, 9 % by M2, and 2/9 by the three samples of M4. A linear loop is also marked
//! at the peaks of its PV while its OP moves. Quantised and strongly filtered signals violate the assumptions of
//! all four. In M4, equal samples count as rising, as published. So a window of one value has a trend, and with
//! many equal samples the result depends on the sign of the loop gain.
//!
//! # Deviations from the paper
//! The paper was not read. Definitions were taken from the source of the public implementation below.
//! * It announces that both windows of a pair are marked, but overwrites the first mark with the mark of the next pair.
//!   So a window has the result of itself and the next one, and the last window has the result of the last pair. We do
//!   the same. This gives its counts: 13, 22, 22 of 125 windows, M4 114 of 333, on loop CHEM2 of the International
//!   Stiction Data Base.
//! * Two windows of one constant value are steady. The program divides 0 by 0 there and does not mark them.
//! * Windows have exactly `window` samples, and remaining samples at the end are left out. A run of marks at the end
//!   counts in `eta_95`.
//! * A number of marks that chance alone could cause is undecided: the decision is positive only above the binomial
//!   quantile `confidence` (normal approximation). A confidence of 0 is the published rule.
//!
//! # References
//! Damarla, S. K. et al., Ind. Eng. Chem. Res. 62 (2023) 4410-4421 (not read); GitHub
//! nPoKhappy/control-valve-stiction-implementation, thesis_1 (read).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::windows::{Moments, op_travel, percentile_95};
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use statrs::distribution::{ContinuousCDF, FisherSnedecor, Normal, StudentsT};

/// Number of samples in a window of M1 to M3, as in the public implementation.
pub const WINDOW: usize = 8;
/// Number of samples in a window of M4, as in the public implementation.
pub const WINDOW_OF_ARRANGEMENTS: usize = 3;
/// Level of significance, as in the public implementation.
pub const ALPHA: f64 = 0.05;
/// Probability of fewer marks by chance alone; ours.
pub const CONFIDENCE: f64 = 0.95;

/// Smallest number of windows for a share; ours.
const FEWEST_WINDOWS: usize = 10;

macro_rules! method {
    ($name:literal, $title:literal, $rule:literal) => {
        Method {
            name: $name,
            title: $title,
            source: "Damarla et al., Ind. Eng. Chem. Res. 62 (2023) 4410-4421; definitions as read in a \
                     public implementation, not in the paper",
            statistic: "Omega, share of marked windows",
            rule: $rule,
            applies: Applies::SelfRegulating,
            decides: Decides::Stiction,
            needs: Needs::OpAndPv,
            family: Family::Windows,
            explains_oscillation: false,
        }
    };
}

static METHODS: [Method; 4] = [
    method!(
        "damarla-f-test",
        "Damarla's F-test",
        "sticks if more windows than expected by chance (in the paper, any) have a steady PV variance and an \
         unsteady OP variance, by a one-sided F-test at 5 %"
    ),
    method!(
        "damarla-t-test",
        "Damarla's t-test",
        "sticks if more windows than expected by chance (in the paper, any) have a steady PV mean and an unsteady OP \
         mean, by a t-test at 5 %"
    ),
    method!(
        "damarla-hotelling",
        "Damarla's Hotelling test",
        "sticks if more windows than expected by chance (in the paper, any) have a steady PV mean and an unsteady OP \
         mean, by Hotelling's T² (modified degrees of freedom) at 5 %"
    ),
    method!(
        "damarla-reverse-arrangements",
        "Damarla's reverse arrangements",
        "sticks if more windows than expected by chance (in the paper, any) have a trend in the OP but none in the \
         PV, by the reverse arrangements test at 5 %"
    ),
];

/// The test of steadiness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SteadinessTest {
    /// M1: ratio of variances.
    FTest,
    /// M2: difference of means, pooled variance.
    TTest,
    /// M3: Hotelling's T² with modified degrees of freedom.
    Hotelling,
    /// M4: trend within a window.
    ReverseArrangements,
}

/// One of Damarla's four tests with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct DamarlaTest {
    /// The test.
    pub test: SteadinessTest,
    /// Samples in a window.
    pub window: usize,
    /// Level of significance.
    pub alpha: f64,
    /// Probability of fewer marks by chance alone; 0 is the published rule, by which any mark decides.
    pub confidence: f64,
}

/// A window's test of one signal: steady if the statistic lies strictly between the limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steadiness {
    /// The statistic of the test; infinite for a difference without variance.
    pub statistic: f64,
    /// Lower limit; minus infinity without a limit.
    pub low: f64,
    /// Upper limit.
    pub high: f64,
}

impl Steadiness {
    /// Whether the signal is steady.
    pub fn steady(&self) -> bool {
        self.low < self.statistic && self.statistic < self.high
    }
}

/// The result of a test.
#[derive(Debug, Clone, PartialEq)]
pub struct DamarlaTestResult {
    /// The test.
    pub test: SteadinessTest,
    /// Samples in a window.
    pub window: usize,
    /// The PV's test in each window.
    pub pv: Vec<Steadiness>,
    /// The OP's test in each window.
    pub op: Vec<Steadiness>,
    /// Whether each window is marked.
    pub marked: Vec<bool>,
    /// Number of marked windows.
    pub count: usize,
    /// Share of marked windows, Omega.
    pub share: f64,
    /// Share chance alone would mark, on average.
    pub expected: f64,
    /// Share above which the decision is positive.
    pub threshold: f64,
    /// OP travel in each run of marked windows, percent.
    pub bands: Vec<f64>,
    /// Their 95th percentile, percent.
    pub eta_95: Option<f64>,
    /// The decision.
    pub decision: Decision,
    /// Cautions.
    pub caveats: Vec<String>,
}

impl DamarlaTest {
    /// A test with its published parameters.
    pub fn new(test: SteadinessTest) -> Self {
        let window = match test {
            SteadinessTest::ReverseArrangements => WINDOW_OF_ARRANGEMENTS,
            _ => WINDOW,
        };
        Self { test, window, alpha: ALPHA, confidence: CONFIDENCE }
    }

    /// Runs the test.
    ///
    /// # Errors
    /// If the method does not apply or there are fewer than ten windows.
    pub fn run(&self, subject: &Subject<'_>) -> Result<DamarlaTestResult, Abstention> {
        let caveats = subject.check(self.method())?;
        let Some(pv) = &subject.segment.pv else {
            return Err(Abstention("needs the PV, which is not recorded".to_owned()));
        };
        let op = &subject.segment.op;
        let window = self.window.max(2);
        if op.len() < FEWEST_WINDOWS * window {
            return Err(Abstention(format!(
                "needs at least {FEWEST_WINDOWS} windows of {window} samples; there are {} samples",
                op.len()
            )));
        }
        let alpha = self.alpha.clamp(1e-6, 0.5);
        let tester = Tester::new(self.test, window, alpha);
        let (pv, op_tests) = (tester.windows(pv), tester.windows(op));
        let marked: Vec<bool> =
            pv.iter().zip(&op_tests).map(|(pv, op)| pv.steady() && !op.steady()).collect();
        let n = marked.len() as f64;
        let count = marked.iter().filter(|m| **m).count();
        let unsteady = tester.false_alarm();
        let expected = unsteady * (1.0 - unsteady);
        let threshold = if self.confidence > 0.0 {
            let z = standard_normal(self.confidence.min(1.0 - 1e-9));
            (expected + z * (expected * (1.0 - expected) / n).sqrt()).max(0.0)
        } else {
            0.0
        };
        let share = count as f64 / n;
        let decision = match count {
            0 => Decision::DoesNotStick,
            _ if share > threshold => Decision::Sticks,
            _ => Decision::Undecided,
        };
        let bands = op_travel(op, &marked, window);
        Ok(DamarlaTestResult {
            test: self.test,
            window,
            pv,
            op: op_tests,
            count,
            share,
            expected,
            threshold,
            eta_95: percentile_95(&bands),
            bands,
            marked,
            decision,
            caveats,
        })
    }
}

impl Detector for DamarlaTest {
    fn method(&self) -> &'static Method {
        &METHODS[self.test as usize]
    }

    fn parameters(&self) -> Vec<Number> {
        vec![
            Number::new("window", self.window as f64, "samples"),
            Number::new("alpha", self.alpha, ""),
            Number::new("confidence", self.confidence, ""),
        ]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let result = self.run(subject)?;
        let reason = format!(
            "in {} of {} windows the PV is steady and the OP is not, Omega = {:.3}; chance alone gives {:.3}, and \
             rarely more than {:.3}",
            result.count,
            result.marked.len(),
            result.share,
            result.expected,
            result.threshold
        );
        let mut numbers = vec![
            Number::new("Omega", result.share, ""),
            Number::new("marked windows", result.count as f64, ""),
            Number::new("windows", result.marked.len() as f64, ""),
            Number::new("Omega by chance", result.expected, ""),
        ];
        numbers.extend(result.eta_95.map(|eta| Number::new("eta 95", eta, "%")));
        let finding = Finding::new(
            self.method(),
            result.decision,
            result.share,
            result.threshold,
            reason,
            numbers,
        );
        let caveats = result.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(result)), ..finding })
    }
}

/// The value below which a standard normal number lies with probability `p`.
fn standard_normal(p: f64) -> f64 {
    Normal::standard().inverse_cdf(p)
}

/// A test with its critical values.
enum Tester {
    F { window: usize, critical: f64, alpha: f64 },
    T { window: usize, critical: f64, alpha: f64 },
    Hotelling { window: usize, critical: Critical, alpha: f64 },
    Arrangements { window: usize, low: f64, high: f64 },
}

impl Tester {
    fn new(test: SteadinessTest, window: usize, alpha: f64) -> Self {
        let n = window as f64;
        match test {
            SteadinessTest::FTest => {
                let critical = FisherSnedecor::new(n - 1.0, n - 1.0)
                    .map_or(f64::INFINITY, |f| f.inverse_cdf(1.0 - alpha));
                Self::F { window, critical, alpha }
            }
            SteadinessTest::TTest => {
                Self::T { window, critical: student(1.0 - alpha, 2.0 * n - 2.0), alpha }
            }
            SteadinessTest::Hotelling => {
                Self::Hotelling { window, critical: Critical::new(alpha, n - 1.0), alpha }
            }
            SteadinessTest::ReverseArrangements => {
                let middle = n * (n - 1.0) / 4.0;
                let sigma = ((2.0 * n.powi(3) + 3.0 * n * n - 5.0 * n) / 72.0).sqrt();
                let reach = standard_normal(1.0 - alpha / 2.0) * sigma - 0.5;
                Self::Arrangements { window, low: middle - reach, high: middle + reach }
            }
        }
    }

    /// Probability that a steady signal with independent samples is found unsteady.
    fn false_alarm(&self) -> f64 {
        match self {
            Self::F { alpha, .. } | Self::Hotelling { alpha, .. } => *alpha,
            // A one-sided quantile against an absolute value.
            Self::T { alpha, .. } => 2.0 * alpha,
            Self::Arrangements { window, low, high } => {
                let ways = arrangements(*window);
                let outside: f64 = ways
                    .iter()
                    .enumerate()
                    .filter(|(a, _)| !(*low < *a as f64 && (*a as f64) < *high))
                    .map(|(_, p)| p)
                    .sum();
                outside
            }
        }
    }

    /// The test in each window of `x`.
    fn windows(&self, x: &[f64]) -> Vec<Steadiness> {
        let pairs = |window: usize, test: &dyn Fn(&[Moments]) -> (f64, f64)| {
            let moments: Vec<Moments> = x.chunks_exact(window).map(Moments::of).collect();
            let mut tests: Vec<Steadiness> = moments
                .windows(2)
                .map(|pair| {
                    let (statistic, high) = test(pair);
                    Steadiness { statistic, low: f64::NEG_INFINITY, high }
                })
                .collect();
            // The last window has no next one; it has the result of the one before.
            tests.extend(tests.last().copied());
            tests
        };
        match self {
            Self::F { window, critical, .. } => {
                pairs(*window, &|pair| (ratio(pair[0].squares, pair[1].squares), *critical))
            }
            Self::T { window, critical, .. } => {
                pairs(*window, &|pair| (t_squared(pair, *window).sqrt(), *critical))
            }
            Self::Hotelling { window, critical, .. } => pairs(*window, &|pair| {
                let sum = pair[0].squares + pair[1].squares;
                let share = if sum > 0.0 { pair[0].squares / sum } else { 0.5 };
                (t_squared(pair, *window), critical.at(share))
            }),
            Self::Arrangements { window, low, high } => x
                .chunks_exact(*window)
                .map(|x| Steadiness { statistic: reversals(x), low: *low, high: *high })
                .collect(),
        }
    }
}

/// `a/b`, with zero over zero as zero.
fn ratio(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}

/// `n (m1 - m2)² / (s1 + s2)` of two windows of `n` samples.
fn t_squared(pair: &[Moments], n: usize) -> f64 {
    let difference = pair[0].mean - pair[1].mean;
    let n = n as f64;
    ratio(n * (n - 1.0) * difference * difference, pair[0].squares + pair[1].squares)
}

/// Number of pairs of which the earlier sample is larger.
fn reversals(x: &[f64]) -> f64 {
    let mut count = 0u32;
    for (i, early) in x.iter().enumerate() {
        for late in &x[i + 1..] {
            count += u32::from(early > late);
        }
    }
    f64::from(count)
}

/// The distribution of the number of reverse arrangements of `n` different numbers in random order.
fn arrangements(n: usize) -> Vec<f64> {
    let mut ways = vec![1.0];
    for m in 2..=n {
        // The m-th number overtakes 0 to m - 1 of those before.
        let mut next = vec![0.0; ways.len() + m - 1];
        for (a, p) in ways.iter().enumerate() {
            for overtaken in 0..m {
                next[a + overtaken] += p / m as f64;
            }
        }
        ways = next;
    }
    ways
}

/// The value below which Student's t of `freedom` degrees lies with probability `p`.
fn student(p: f64, freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(p))
}

/// `F(1 - alpha; 1, f)` for all `f` from `n` to `2 n`. It is a polynomial in `1/f` through Chebyshev's points, because
/// each window has its own `f` and a quantile is slow.
struct Critical {
    nodes: [f64; 12],
    values: [f64; 12],
}

impl Critical {
    fn new(alpha: f64, n: f64) -> Self {
        let nodes = std::array::from_fn(|i| (std::f64::consts::PI * i as f64 / 11.0).cos());
        // n/f lies between 1/2 and 1.
        let values = nodes.map(|x| student(1.0 - alpha / 2.0, n / (0.75 + 0.25 * x)).powi(2));
        Self { nodes, values }
    }

    /// The critical value where the first window has the share `w` of the squares.
    fn at(&self, w: f64) -> f64 {
        let place = 4.0 * (w * w + (1.0 - w) * (1.0 - w) - 0.75);
        let (mut above, mut below) = (0.0, 0.0);
        for (i, (node, value)) in self.nodes.iter().zip(&self.values).enumerate() {
            let distance = place - node;
            if distance == 0.0 {
                return *value;
            }
            let end = if i == 0 || i == 11 { 0.5 } else { 1.0 };
            let weight = if i % 2 == 0 { end } else { -end } / distance;
            above += weight * value;
            below += weight;
        }
        above / below
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn critical_values_are_those_of_the_distributions() {
        // From scipy.stats: f.ppf(.95, 7, 7), t.ppf(.95, 14), f.ppf(.95, 1, f) for f = 7, 10.5, 14.
        let Tester::F { critical, .. } = Tester::new(SteadinessTest::FTest, 8, 0.05) else {
            panic!()
        };
        assert!((critical - 3.7870435399280686).abs() < 1e-6, "{critical}");
        let Tester::T { critical, .. } = Tester::new(SteadinessTest::TTest, 8, 0.05) else {
            panic!()
        };
        assert!((critical - 1.761310135774891).abs() < 1e-8, "{critical}");
        let critical = Critical::new(0.05, 7.0);
        for (w, expected) in [(0.0, F7), (0.5, F14), (0.5 - 1.0 / 12f64.sqrt(), F10_5)] {
            assert!(
                (critical.at(w) / expected - 1.0).abs() < 1e-8,
                "{} {expected}",
                critical.at(w)
            );
        }
    }

    const F7: f64 = 5.591447851220735;
    const F10_5: f64 = 4.901088842550745;
    const F14: f64 = 4.600109936669422;

    #[test]
    fn three_numbers_have_six_orders() {
        let sixth = 1.0 / 6.0;
        let expected = [sixth, 2.0 * sixth, 2.0 * sixth, sixth];
        assert!(arrangements(3).iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15));
        assert_eq!(reversals(&[3.0, 2.0, 1.0]), 3.0);
        assert_eq!(reversals(&[2.0, 2.0, 1.0]), 2.0);
        assert_eq!(reversals(&[2.0; 4]), 0.0);
    }
}
