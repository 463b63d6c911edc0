//! The random stream of a loop.

use rand::{Rng, SeedableRng};
use rand_distr::{Distribution, StudentT};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A stream of pseudo-random numbers: xoshiro256++.
pub struct Draw(Xoshiro256PlusPlus);

impl Draw {
    /// The stream of these numbers, in this order.
    pub fn of(numbers: &[u64]) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(numbers.iter().fold(0, |hash, n| mixed(hash ^ n))))
    }

    /// Another stream, drawn from this.
    pub fn fork(&mut self) -> Self {
        Self::of(&[self.seed()])
    }

    /// A different stream, derived from the state of this one. This stream does not change.
    pub fn branch(&self) -> Self {
        Self::of(&[Self(self.0.clone()).seed(), 1])
    }

    /// Any number.
    pub fn seed(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform from 0 up to but not including 1.
    pub fn unit(&mut self) -> f64 {
        (self.seed() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform.
    pub fn uniform(&mut self, from: f64, to: f64) -> f64 {
        from + self.unit() * (to - from)
    }

    /// Uniform in the logarithm.
    pub fn log(&mut self, from: f64, to: f64) -> f64 {
        self.uniform(from.ln(), to.ln()).exp()
    }

    /// Plus or minus one.
    pub fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// An integer, both ends included.
    pub fn count(&mut self, from: usize, to: usize) -> usize {
        from + (self.unit() * (to - from + 1) as f64) as usize
    }

    /// `n` numbers of Student's t distribution with this many degrees of freedom, above 0.
    pub fn student(&mut self, freedom: f64, n: usize) -> impl Iterator<Item = f64> {
        let law = StudentT::new(freedom);
        (0..n).map(move |_| law.map_or(0.0, |law| law.sample(&mut self.0)))
    }

    /// One of several equally likely items.
    pub fn one_of<T: Copy, const N: usize>(&mut self, things: [T; N]) -> T {
        things[self.count(0, N - 1)]
    }

    /// Draws one of several items by their weights, which need not sum to one.
    pub fn weighted<T: Copy, const N: usize>(&mut self, things: [(T, f64); N]) -> T {
        let all: f64 = things.iter().map(|(_, weight)| weight).sum();
        let mut place = self.unit() * all;
        for (thing, weight) in things {
            place -= weight;
            if place < 0.0 {
                return thing;
            }
        }
        things[N - 1].0
    }
}

/// A number that depends on all bits of `x`: the finaliser of SplitMix64 (G. L. Steele, D. Lea,
/// C. H. Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014; recalled, not read).
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_and_shares_are_kept() {
        let mut draw = Draw::of(&[1, 2]);
        let (mut heavy, mut likely, mut low, mut high) = (0, 0, 0, 0);
        for _ in 0..10_000 {
            heavy += usize::from(draw.weighted([(true, 3.0), (false, 1.0)]));
            likely += usize::from(draw.chance(0.2));
            match draw.count(3, 5) {
                3 => low += 1,
                5 => high += 1,
                other => assert_eq!(other, 4),
            }
            assert!((0.5..=8.0).contains(&draw.log(0.5, 8.0)));
        }
        // Four standard deviations of a share of 10,000.
        assert!((heavy as f64 - 7500.0).abs() < 175.0, "{heavy}");
        assert!((likely as f64 - 2000.0).abs() < 160.0, "{likely}");
        for end in [low, high] {
            assert!((end as f64 - 3333.0).abs() < 190.0, "{end}");
        }
    }

    #[test]
    fn streams_depend_on_every_number_and_their_order() {
        let first = |numbers: &[u64]| Draw::of(numbers).seed();
        let all = [first(&[1, 2]), first(&[2, 1]), first(&[1]), first(&[1, 2, 0]), first(&[0, 2])];
        for (k, one) in all.iter().enumerate() {
            assert!(!all[..k].contains(one));
        }
        assert_eq!(first(&[1, 2]), first(&[1, 2]));
    }
}
