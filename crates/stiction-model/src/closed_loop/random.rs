//! Seeded pseudo-random streams.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A stream of standard normal numbers that depends on its seed only.
///
/// Version 1: xoshiro256++ seeded by SplitMix64, normal numbers by the ziggurat method. A change of either is a new
/// version and is listed in the change log.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalStream(Xoshiro256PlusPlus);

impl NormalStream {
    /// The stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// The next number: mean 0, standard deviation 1.
    #[inline]
    pub fn draw(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}
