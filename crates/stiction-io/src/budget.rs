//! Limits the memory that a file may take, and catches panics of decoders.

#[cfg(any(feature = "matlab73", feature = "parquet", feature = "spreadsheet"))]
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Cells that are compressed or run-length encoded are larger in memory than in the file. Every file may take this
/// many bytes, plus this multiple of its size. No real recording comes near that limit, and no damaged one may exceed
/// it.
const ALLOWANCE: usize = 64 << 20;
const EXPANSION: usize = 256;

/// Limit for the cells of any file together, 4 GiB: 500 million numbers, or a year of four signals at 1 s as text.
pub(crate) const MOST: usize = u32::MAX as usize;

/// Bytes that the cells of a file may still take.
#[derive(Debug)]
pub(crate) struct Budget {
    most: usize,
    left: usize,
}

impl Budget {
    /// The budget of a file of this size.
    pub(crate) fn of(file: usize) -> Self {
        Self::new(file.saturating_mul(EXPANSION).saturating_add(ALLOWANCE).min(MOST))
    }

    /// A budget of this many bytes.
    pub(crate) fn new(most: usize) -> Self {
        Self { most, left: most }
    }

    /// Bytes that the file may take in total.
    #[cfg(any(feature = "matlab73", feature = "parquet"))]
    pub(crate) fn most(&self) -> usize {
        self.most
    }

    /// Bytes that are left.
    #[cfg(any(feature = "matlab", feature = "parquet", feature = "spreadsheet"))]
    pub(crate) fn left(&self) -> usize {
        self.left
    }

    /// Spends `bytes`, or fails if too few are left.
    pub(crate) fn spend(&mut self, bytes: usize) -> Result<(), String> {
        self.left = self.left.checked_sub(bytes).ok_or_else(|| {
            let why = match self.most {
                MOST => "which no recording needs",
                _ => "far more than a file of this size should take",
            };
            let most = self.most >> 20;
            format!("would take more than {most} MiB of memory, {why}; write fewer rows or columns")
        })?;
        Ok(())
    }
}

/// The result of `decode`; none after a panic.
///
/// The parquet crate panics where a damaged page contradicts itself, which random damage triggers within thousands of
/// files. calamine slices records without a check, so it panics as often on damaged `.xls` files. hdf5-pure has never
/// panicked, but is as large. Catching the panic is the last resort, because there is no other way to continue. Nothing
/// that `decode` touches is used afterwards.
#[cfg(any(feature = "matlab73", feature = "parquet", feature = "spreadsheet"))]
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
