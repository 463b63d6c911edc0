//! Percent of a span that is not known for certain.

use super::Range;
use crate::estimate::Estimate;

/// How percent of an assumed span compare with percent of all other plausible spans: factors of at most and at least
/// one. A known span has the factor one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Doubt {
    /// The factor for the widest plausible span.
    pub least: f64,
    /// The factor for the narrowest plausible span.
    pub most: f64,
}

impl Default for Doubt {
    fn default() -> Self {
        Self { least: 1.0, most: 1.0 }
    }
}

impl Doubt {
    /// That of a range. Values without a range are percent.
    pub fn of(range: Option<Range>) -> Self {
        range.map_or_else(Self::default, |range| {
            let (span, [narrowest, widest]) = (range.high - range.low, range.spans);
            Self { least: span / widest, most: span / narrowest }
        })
    }

    /// Both doubts together.
    pub fn and(self, other: Self) -> Self {
        Self { least: self.least.min(other.least), most: self.most.max(other.most) }
    }

    /// An amount in percent, with an interval that covers every plausible span.
    pub fn widen(self, of: Estimate) -> Estimate {
        let ends = [of.low, of.high].map(|end| [end * self.least, end * self.most]);
        Estimate {
            value: of.value,
            low: ends[0][0].min(ends[0][1]),
            high: ends[1][0].max(ends[1][1]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::RangeSource;

    #[test]
    fn an_interval_holds_the_amount_of_every_span() {
        let range = Range::among(0.0, 20.0, RangeSource::Estimated, (10.0, 80.0)).unwrap();
        let doubt = Doubt::of(Some(range));
        assert_eq!((doubt.least, doubt.most), (0.25, 2.0));
        let wide = doubt.widen(Estimate { value: 4.0, low: 3.0, high: 5.0 });
        assert_eq!((wide.value, wide.low, wide.high), (4.0, 0.75, 10.0));
        let sure = Doubt::of(Some(Range::new(4.0, 20.0, RangeSource::Given).unwrap()));
        assert_eq!((sure, Doubt::of(None)), (Doubt::default(), Doubt::default()));
        assert_eq!(sure.and(doubt), doubt);
    }
}
