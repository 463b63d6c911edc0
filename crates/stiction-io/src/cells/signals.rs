//! Ranges of signals to a valve that fit values without a unit.

/// Ranges of analogue signals whose values could also be percent: mA, psi and V.
pub const ANALOGUE: [(f64, f64); 6] =
    [(4.0, 20.0), (3.0, 15.0), (1.0, 5.0), (0.0, 5.0), (0.0, 10.0), (2.0, 10.0)];

/// Ranges of counts and scaled integers, each with a weight by how common it is (ours).
pub const SCALED: [((f64, f64), f64); 24] = [
    ((0.0, 1_000.0), 1.0),
    ((0.0, 4_095.0), 1.0),
    ((0.0, 27_648.0), 1.0),
    ((0.0, 10_000.0), 1.0),
    ((0.0, 32_767.0), 1.0),
    ((0.0, 65_535.0), 0.6),
    ((0.0, 16_383.0), 0.6),
    ((0.0, 4_000.0), 0.6),
    ((4_000.0, 20_000.0), 0.6),
    ((0.0, 200.0), 0.6),
    ((0.0, 1_023.0), 0.3),
    ((0.0, 255.0), 0.3),
    ((0.0, 20_000.0), 0.3),
    ((0.0, 32_000.0), 0.3),
    ((800.0, 4_000.0), 0.3),
    ((819.0, 4_095.0), 0.3),
    ((3_277.0, 16_384.0), 0.3),
    ((6_242.0, 31_208.0), 0.3),
    ((6_553.0, 32_767.0), 0.3),
    ((-100.0, 100.0), 1.0),
    ((-1_000.0, 1_000.0), 0.6),
    ((-10_000.0, 10_000.0), 0.3),
    ((-27_648.0, 27_648.0), 1.0),
    ((-32_768.0, 32_767.0), 0.6),
];

/// Tolerance for values beyond the ends of a range, as a share of its span.
pub const BEYOND: f64 = 0.03;
/// Least level of the median in a range, as a share of its span. A valve that stays below is rarely in service.
const LEAST_LEVEL: f64 = 0.05;

/// Lowest value, median and highest value.
#[derive(Debug, Clone, Copy)]
pub struct Values {
    pub low: f64,
    pub median: f64,
    pub high: f64,
}

impl Values {
    /// Values of the finite `values`; `None` if none is finite.
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        let (low, high) = sorted
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        let middle = sorted.len() / 2;
        if sorted.is_empty() {
            return None;
        }
        let (_, median, _) = sorted.select_nth_unstable_by(middle, f64::total_cmp);
        Some(Self { low, median: *median, high })
    }

    /// Whether a range holds the values, with a tolerance as a share of its span.
    pub fn within(&self, (low, high): (f64, f64), tolerance: f64) -> bool {
        // A range that is much too wide must not swallow negative values.
        let slack = tolerance * (high - low).min(2.0 * self.low.abs().max(self.high.abs()));
        self.low >= low - slack && self.high <= high + slack
    }

    /// Whether they move within 0 to 1 and mostly are at neither end.
    pub fn move_within_one(&self) -> bool {
        let inner = self.median > 0.0 && self.median < 1.0;
        inner && self.low < self.high && self.within((0.0, 1.0), 0.0)
    }

    /// The level of the values in a range. It is the median as a share of the span, or the largest size if the range
    /// has two sides.
    fn level(&self, (low, high): (f64, f64)) -> f64 {
        match low < 0.0 {
            true => self.low.abs().max(self.high.abs()) / high,
            false => (self.median - low) / (high - low),
        }
    }

    /// Whether a range holds the values and its span is not much too wide for them.
    pub fn fit(&self, range: (f64, f64)) -> bool {
        // Values without negative ones show no range with two sides.
        let two_sided = range.0 < 0.0;
        self.within(range, BEYOND)
            && (!two_sided || self.low < 0.0)
            && self.level(range) >= LEAST_LEVEL
    }

    /// Plausibility of a range that fits, by its weight and the level of the values in it.
    pub fn plausibility(&self, (range, weight): ((f64, f64), f64)) -> f64 {
        weight
            * match self.level(range) {
                level if (0.2..=0.8).contains(&level) => 1.0,
                level if (0.1..=0.97).contains(&level) => 0.3,
                _ => 0.1,
            }
    }
}
