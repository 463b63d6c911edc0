//! Lanes compiled for the widest vectors the processor has: the one place with `unsafe`.
//!
//! The same Rust code is compiled several times, for different vector widths, and the widest one that the processor
//! supports is chosen at run time. Only the width differs: Rust never fuses or reorders floating-point operations,
//! so all widths give the same bits.
//!
//! Calling a function compiled for more than the baseline is `unsafe`, because the processor may lack the
//! instructions. Each call below follows a check for exactly those instructions. `BENCHMARKS.md` reports the gain.
#![allow(unsafe_code)]

/// Number of candidates or loops that are stepped together.
pub const LANES: usize = 16;

/// One number in each of `N` lanes. The array starts on a cache line, so that no vector crosses two cache lines.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Lane<const N: usize = LANES>(pub [f64; N]);

impl<const N: usize> Lane<N> {
    /// The same value in every lane.
    pub const fn splat(value: f64) -> Self {
        Self([value; N])
    }

    /// `f(lane)` in each lane. Unlike `std::array::from_fn` it is always inlined: a call in the
    /// inner loop would leave the wide vectors.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize) -> f64) -> Self {
        let mut lanes = Self::splat(0.0);
        for l in 0..N {
            lanes[l] = f(l);
        }
        lanes
    }

    /// Adds `factor x` in each lane.
    #[inline(always)]
    pub fn add_scaled(&mut self, x: &Self, factor: f64) {
        for l in 0..N {
            self.0[l] += x.0[l] * factor;
        }
    }

    /// Adds `x y` in each lane.
    #[inline(always)]
    pub fn add_product(&mut self, x: &Self, y: &Self) {
        for l in 0..N {
            self.0[l] += x.0[l] * y.0[l];
        }
    }

    /// Subtracts `x y` in each lane.
    #[inline(always)]
    pub fn subtract_product(&mut self, x: &Self, y: &Self) {
        for l in 0..N {
            self.0[l] -= x.0[l] * y.0[l];
        }
    }
}

impl<const N: usize> std::ops::Deref for Lane<N> {
    type Target = [f64; N];
    #[inline(always)]
    fn deref(&self) -> &[f64; N] {
        &self.0
    }
}

impl<const N: usize> std::ops::DerefMut for Lane<N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64; N] {
        &mut self.0
    }
}

/// A computation for wide vectors. `run` must be `#[inline(always)]`, and so must the functions in its inner loop.
pub trait Kernel {
    /// Result.
    type Output;
    /// Runs the computation. Implementations are marked `#[inline(always)]`.
    fn run(self) -> Self::Output;
}

/// Width of the vectors of a compilation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Width {
    /// That of every processor of the target.
    Baseline,
    /// Four numbers.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// Eight numbers.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Width {
    /// The widest this processor has.
    pub fn widest() -> Self {
        Self::available().next().unwrap_or(Self::Baseline)
    }

    /// All widths this processor has, the widest first.
    pub fn available() -> impl Iterator<Item = Self> {
        [
            #[cfg(target_arch = "x86_64")]
            Self::Avx512,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2,
            Self::Baseline,
        ]
        .into_iter()
        .filter(|width| width.is_available())
    }

    fn is_available(self) -> bool {
        match self {
            Self::Baseline => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512dq")
            }
        }
    }

    /// Runs `kernel` with vectors of this width, or of the baseline if the processor lacks it.
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
        fn avx512<K: Kernel>(kernel: K) -> K::Output {
            kernel.run()
        }
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2")]
        fn avx2<K: Kernel>(kernel: K) -> K::Output {
            kernel.run()
        }
        match self {
            // SAFETY: the processor has all the features checked by `is_available`.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 if self.is_available() => unsafe { avx512(kernel) },
            // SAFETY: the processor has the feature.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 if self.is_available() => unsafe { avx2(kernel) },
            _ => kernel.run(),
        }
    }
}
