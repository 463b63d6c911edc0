//! Power series of a signal over a short segment of time, and its rises through zero.

use super::number::Number;

/// Highest power. Segments are short enough (see [`Plant`](super::plant::Plant)) that the next would not change a
/// double.
pub(super) const DEGREE: usize = 20;

/// `c0 + c1 s + c2 s^2 + ...`, with `s` relative to the start of the segment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Series<T>(pub(super) [T; DEGREE + 1]);

impl<T: Number> Series<T> {
    pub(super) fn constant(value: T) -> Self {
        let mut series = Self([T::of(0.0); DEGREE + 1]);
        series.0[0] = value;
        series
    }

    /// The signal at `s`.
    #[inline]
    pub(super) fn at(&self, s: T) -> T {
        self.0.iter().rev().fold(T::of(0.0), |sum, c| sum * s + *c)
    }

    /// The signal relative to `s`.
    pub(super) fn from(mut self, s: T) -> Self {
        for i in 0..DEGREE {
            for j in (i..DEGREE).rev() {
                self.0[j] = self.0[j] + self.0[j + 1] * s;
            }
        }
        self
    }

    /// Largest distance of the signal from its start, until `end`.
    pub(super) fn range(&self, end: f64) -> f64 {
        self.0[1..].iter().rev().fold(0.0, |sum, c| (sum + c.value().abs()) * end)
    }

    /// `self + offset`.
    pub(super) fn plus(mut self, offset: T) -> Self {
        self.0[0] = self.0[0] + offset;
        self
    }

    /// `factor self`.
    pub(super) fn times(self, factor: f64) -> Self {
        Self(self.0.map(|c| c * factor))
    }

    /// Derivative.
    pub(super) fn slope(&self) -> Self {
        Self(std::array::from_fn(|k| match self.0.get(k + 1) {
            Some(c) => *c * (k + 1) as f64,
            None => T::of(0.0),
        }))
    }

    /// Values without derivatives.
    pub(super) fn values(&self) -> Series<f64> {
        Series(self.0.map(T::value))
    }
}

impl Series<f64> {
    /// Below this a difference is rounding: signals are of size 1.
    pub(super) const ROUNDING: f64 = 1e-13;

    /// The first `s` in `0..=end` at which the signal rises through zero; 0 if it begins above.
    ///
    /// It misses only a rise that falls again within `end / 2^40`: a segment is halved until its coefficients bound
    /// the signal, or its slope, away from zero.
    pub(super) fn rise(&self, end: f64) -> Option<f64> {
        // A signal that begins at zero has, later on, the sign of the rest after division by a power of s.
        let zeros = self.0.iter().take_while(|c| c.abs() <= Self::ROUNDING).count();
        match self.0.get(zeros) {
            None => None,
            Some(c) if *c > 0.0 => Some(0.0),
            Some(_) => {
                let mut rest = *self;
                rest.0.rotate_left(zeros);
                rest.0[DEGREE + 1 - zeros..].fill(0.0);
                rest.rises(end)
            }
        }
    }

    /// As [`rise`](Self::rise), but a start above zero is ignored.
    pub(super) fn rises(&self, end: f64) -> Option<f64> {
        let mut power = 1.0;
        let unit = Self(self.0.map(|c| {
            let scaled = c * power;
            power *= end;
            scaled
        }));
        let size: f64 = unit.0.iter().map(|c| c.abs()).sum();
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        unit.rise_in_unit(40, 1e-18 * size).map(|s| s * end)
    }

    /// `flat` is the size below which a part of the segment is only rounding.
    fn rise_in_unit(&self, halvings: u32, flat: f64) -> Option<f64> {
        let c = &self.0;
        let range: f64 = c[1..].iter().map(|c| c.abs()).sum();
        if c[0].abs() > range {
            return None;
        }
        let bend: f64 = c[2..].iter().zip(2..).map(|(c, k)| f64::from(k) * c.abs()).sum();
        if c[1].abs() > bend {
            let rises = c[1] > 0.0 && c[0] <= 0.0 && self.at(1.0) > 0.0;
            return rises.then(|| self.root_in_unit());
        }
        // A part that is zero everywhere would be halved for ever.
        if halvings == 0 || c[0].abs() + range <= flat {
            return (c[0] <= 0.0 && self.at(1.0) > 0.0).then_some(0.5);
        }
        let mut power = 1.0;
        let left = Self(self.0.map(|c| {
            let scaled = c * power;
            power *= 0.5;
            scaled
        }));
        left.rise_in_unit(halvings - 1, flat)
            .map(|s| 0.5 * s)
            .or_else(|| left.from(1.0).rise_in_unit(halvings - 1, flat).map(|s| 0.5 + 0.5 * s))
    }

    /// The zero of a signal that rises all the way from 0 to 1: Newton's method in a bracket.
    fn root_in_unit(&self) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        let mut s = (-self.0[0] / self.0[1]).clamp(0.0, 1.0);
        for _ in 0..100 {
            let (mut value, mut slope) = (0.0, 0.0);
            for c in self.0.iter().rev() {
                slope = slope * s + value;
                value = value * s + c;
            }
            if value > 0.0 {
                high = s;
            } else {
                low = s;
            }
            let newton = s - value / slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - s).abs() <= 1e-16 || value == 0.0 {
                break;
            }
            s = next;
        }
        s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(coefficients: &[f64]) -> Series<f64> {
        let mut series = Series::constant(0.0);
        series.0[..coefficients.len()].copy_from_slice(coefficients);
        series
    }

    #[test]
    fn a_rise_is_found_where_it_is() {
        // (s - 0.25)(0.75 - s) rises at 0.25 and falls at 0.75; cubes rise flat.
        assert!((series(&[-0.1875, 1.0, -1.0]).rises(1.0).unwrap() - 0.25).abs() < 1e-15);
        assert!((series(&[-0.125, 0.75, -1.5, 1.0]).rises(1.0).unwrap() - 0.5).abs() < 1e-5);
        assert_eq!(series(&[0.25, -1.0]).rises(1.0), None);
        assert_eq!(series(&[-2.0, 1.0]).rises(1.0), None);
    }

    /// These once took 2^40 halves.
    #[test]
    fn what_touches_zero_or_is_nothing_has_no_rise() {
        for none in [
            &[0.0][..],
            &[f64::NAN, 1.0],
            &[f64::INFINITY],
            &[f64::MIN_POSITIVE],
            &[-f64::MIN_POSITIVE, f64::MIN_POSITIVE, -f64::MIN_POSITIVE],
            // -(s - 0.3)^2, and its square.
            &[-0.09, 0.6, -1.0],
            &[-0.0081, 0.108, -0.54, 1.2, -1.0],
        ] {
            assert_eq!(series(none).rises(1.0), None, "{none:?}");
        }
    }
}
