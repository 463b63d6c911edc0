//! How much memory a binary file may take, and what to do with a decoder that panics.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Compressed and run-length encoded cells are larger in memory than in the file: by so many bytes in
/// any case, and so many times. No real recording comes near that, and no damaged one may.
const ALLOWANCE: usize = 64 << 20;
const EXPANSION: usize = 256;

/// Bytes that a file may still take.
#[derive(Debug)]
pub(crate) struct Budget {
    most: usize,
    left: usize,
}

impl Budget {
    /// What a file of so many bytes may take.
    pub(crate) fn of(file: usize) -> Self {
        let most = file.saturating_mul(EXPANSION).saturating_add(ALLOWANCE);
        Self { most, left: most }
    }

    /// Bytes that the file may take altogether.
    pub(crate) fn most(&self) -> usize {
        self.most
    }

    /// Bytes that are left.
    pub(crate) fn left(&self) -> usize {
        self.left
    }

    /// Takes `bytes`, or says that there are too few left.
    pub(crate) fn spend(&mut self, bytes: usize) -> Result<(), String> {
        self.left = self.left.checked_sub(bytes).ok_or_else(|| {
            format!(
                "would take more than {} MiB of memory, {EXPANSION} times what it has; write fewer \
                 rows or columns",
                self.most >> 20
            )
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
pub(crate) fn guarded<T>(decode: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(decode)).ok()
}
