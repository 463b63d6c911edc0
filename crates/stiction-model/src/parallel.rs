//! Iterators over all threads, with the feature `rayon`. Without this feature, the same names run on one thread.
//!
//! Results are collected in order and never added up across threads, so any number of threads gives the same bits.

#[cfg(feature = "rayon")]
pub use rayon::{join, prelude::*};

/// Replaces [`join`](https://docs.rs/rayon) of rayon: runs one after the other.
#[cfg(not(feature = "rayon"))]
pub fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    (a(), b())
}

/// Replaces rayon's [`IntoParallelIterator`](https://docs.rs/rayon).
#[cfg(not(feature = "rayon"))]
pub trait IntoParallelIterator: IntoIterator + Sized {
    /// All items.
    fn into_par_iter(self) -> Self::IntoIter {
        self.into_iter()
    }
}

#[cfg(not(feature = "rayon"))]
impl<I: IntoIterator> IntoParallelIterator for I {}

/// Replaces rayon's methods of slices.
#[cfg(not(feature = "rayon"))]
pub trait ParallelSlice<T> {
    /// All elements.
    fn par_iter(&self) -> std::slice::Iter<'_, T>;
    /// All elements, mutable.
    fn par_iter_mut(&mut self) -> std::slice::IterMut<'_, T>;
    /// Blocks of `size` elements, the last of which may be shorter.
    fn par_chunks(&self, size: usize) -> std::slice::Chunks<'_, T>;
}

#[cfg(not(feature = "rayon"))]
impl<T> ParallelSlice<T> for [T] {
    fn par_iter(&self) -> std::slice::Iter<'_, T> {
        self.iter()
    }

    fn par_iter_mut(&mut self) -> std::slice::IterMut<'_, T> {
        self.iter_mut()
    }

    fn par_chunks(&self, size: usize) -> std::slice::Chunks<'_, T> {
        self.chunks(size)
    }
}
