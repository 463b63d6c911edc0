//! How much memory a file may take, and what to do with a decoder that panics.

#[cfg(any(feature = "matlab73", feature = "parquet"))]
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Compressed and run-length encoded cells are larger in memory than in the file: by so many bytes in
/// any case, and so many times. No real recording comes near that, and no damaged one may.
const ALLOWANCE: usize = 64 << 20;
const EXPANSION: usize = 256;

/// What the cells of no file may take together, 4 GiB: 500 million numbers, or a year of four signals at 1 s as text.
pub(crate) const MOST: usize = u32::MAX as usize;

/// Bytes that the cells of a file may still take.
#[derive(Debug)]
pub(crate) struct Budget {
    most: usize,
    left: usize,
}

impl Budget {
    /// What a file of so many bytes may take.
    pub(crate) fn of(file: usize) -> Self {
        Self::new(file.saturating_mul(EXPANSION).saturating_add(ALLOWANCE).min(MOST))
    }

    /// So many bytes.
    pub(crate) fn new(most: usize) -> Self {
        Self { most, left: most }
    }

    /// Bytes that the file may take altogether.
    #[cfg(any(feature = "matlab73", feature = "parquet"))]
    pub(crate) fn most(&self) -> usize {
        self.most
    }

    /// Bytes that are left.
    #[cfg(feature = "matlab")]
    pub(crate) fn left(&self) -> usize {
        self.left
    }

    /// Takes `bytes`, or says that there are too few left.
    pub(crate) fn spend(&mut self, bytes: usize) -> Result<(), String> {
        self.left = self.left.checked_sub(bytes).ok_or_else(|| {
            let why = match self.most {
                MOST => "which no recording needs",
                _ => "far more than a file of its size should",
            };
            let most = self.most >> 20;
            format!("would take more than {most} MiB of memory, {why}; write fewer rows or columns")
        })?;
        Ok(())
    }
}

/// What `decode` gives; none if it panics.
///
/// The parquet crate asserts and indexes where a damaged page contradicts itself, which random damage
/// finds within thousands of files; hdf5-pure has never been seen to, but is as large. Catching that
/// is the last resort, for there is no other way to go on. Nothing that `decode` touches is used
/// afterwards.
#[cfg(any(feature = "matlab73", feature = "parquet"))]
pub(crate) fn guarded<T>(decode: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(decode)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_file_may_take_everything() {
        assert_eq!(Budget::of(0).most, ALLOWANCE);
        assert_eq!(Budget::of(1 << 20).most, ALLOWANCE + (EXPANSION << 20));
        let mut endless = Budget::of(usize::MAX);
        assert!(endless.spend(MOST).is_ok());
        assert!(endless.spend(1).unwrap_err().contains("4095 MiB of memory, which no recording"));
    }
}
