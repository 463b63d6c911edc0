//! Crossings of zero, and the half waves between.

/// The direction of a crossing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// From below zero to above.
    Up,
    /// From above zero to below.
    Down,
}

/// A crossing of zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZeroCrossing {
    /// Position, in samples, interpolated between its neighbours.
    pub place: f64,
    /// The first sample after it.
    pub next: usize,
    /// Direction.
    pub direction: Direction,
}

/// All changes of sign of `x`. Samples of exactly zero belong to the side of the sample before, so a series that
/// touches zero and turns back does not cross it.
pub fn zero_crossings(x: &[f64]) -> Vec<ZeroCrossing> {
    let mut crossings = vec![];
    // The last sample that was not zero.
    let mut last: Option<usize> = None;
    for (k, &v) in x.iter().enumerate() {
        if v == 0.0 || v.is_nan() {
            continue;
        }
        if let Some(j) = last
            && (x[j] > 0.0) != (v > 0.0)
        {
            // Between j and k there are only zeros: the line leaves zero at k - 1, or crosses it.
            let before = x[k - 1];
            let place = (k - 1) as f64 + before / (before - v);
            let direction = if v > 0.0 { Direction::Up } else { Direction::Down };
            crossings.push(ZeroCrossing { place, next: k, direction });
        }
        last = Some(k);
    }
    crossings
}

/// The samples between two neighbouring crossings of zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfWave {
    /// Beginning, in samples.
    pub from: f64,
    /// End, in samples.
    pub to: f64,
    /// First sample.
    pub first: usize,
    /// Index after the last sample.
    pub end: usize,
    /// Whether the series is above zero.
    pub above: bool,
}

impl HalfWave {
    /// Length in samples, between crossings.
    pub fn length(&self) -> f64 {
        self.to - self.from
    }
}

/// The complete half waves of `x`, those between two crossings.
pub fn half_waves(x: &[f64]) -> Vec<HalfWave> {
    let crossings = zero_crossings(x);
    let waves = crossings.windows(2).map(|pair| HalfWave {
        from: pair[0].place,
        to: pair[1].place,
        first: pair[0].next,
        end: pair[1].next,
        above: pair[0].direction == Direction::Up,
    });
    waves.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossings_are_interpolated_and_touching_is_no_crossing() {
        let x = [-1.0, 3.0, 0.0, 2.0, -2.0, 0.0, 0.0, 1.0];
        let places: Vec<f64> = zero_crossings(&x).iter().map(|c| c.place).collect();
        assert_eq!(places, [0.25, 3.5, 6.0]);
        let waves = half_waves(&x);
        assert_eq!((waves[0].first, waves[0].end, waves[0].above), (1, 4, true));
        assert_eq!(waves[1].length(), 2.5);
        assert!(half_waves(&[0.0; 5]).is_empty());
    }
}
