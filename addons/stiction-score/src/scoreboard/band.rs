//! Number ranges for counting loops.

/// Numbers from a lower end to below an upper end.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Band {
    /// Lower end.
    pub from: f64,
    /// Upper end, which belongs to the next band; `None` for the last band.
    pub to: Option<f64>,
}

impl Band {
    /// The bands that begin at these numbers, which are in order.
    pub(super) fn beginning_at(ends: &[f64]) -> Vec<Self> {
        let next = ends.iter().skip(1).copied().map(Some).chain([None]);
        ends.iter().zip(next).map(|(from, to)| Self { from: *from, to }).collect()
    }

    /// Whether the band contains a number.
    pub fn holds(&self, value: f64) -> bool {
        value >= self.from && self.to.is_none_or(|to| value < to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_from_the_first_end_on_is_in_one_band() {
        let bands = Band::beginning_at(&[1.0, 3.0, 6.0]);
        let place = |value: f64| {
            let within: Vec<_> = (0..3).filter(|k| bands[*k].holds(value)).collect();
            assert!(within.len() <= 1, "{value} is in {within:?}");
            within.first().copied()
        };
        for (value, want) in [
            (0.99, None),
            (1.0, Some(0)),
            (2.9, Some(0)),
            (3.0, Some(1)),
            (6.0, Some(2)),
            (1e9, Some(2)),
            (f64::NAN, None),
        ] {
            assert_eq!(place(value), want, "{value}");
        }
        assert_eq!(Band::beginning_at(&[]), []);
    }
}
