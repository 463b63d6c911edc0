//! From a file to recordings, and from those to findings.

use crate::Found;
use crate::diagnose::DiagnoseOptions;
use std::ops::Deref;
use std::path::Path;
use stiction_io::{ReadOptions, Reading, reading};

/// The recordings in the file at `path`: CSV, Parquet or MATLAB, whichever it is; columns, time stamps and
/// units are recognised.
///
/// # Errors
/// If the file cannot be read or understood; the message names file, row, column and remedy.
pub fn read(path: impl AsRef<Path>) -> stiction_io::Result<Recordings> {
    read_with(path, &ReadOptions::default())
}

/// As [`read`], told what cannot be recognised.
///
/// # Errors
/// As for [`read`], and if `options` name what is not there.
pub fn read_with(path: impl AsRef<Path>, options: &ReadOptions) -> stiction_io::Result<Recordings> {
    reading::read(path.as_ref(), options).map(Recordings::from)
}

/// What was read from a file: a [`Reading`], whose fields are seen through it, that can be diagnosed.
#[derive(Debug, Clone, PartialEq)]
pub struct Recordings {
    reading: Reading,
}

impl From<Reading> for Recordings {
    fn from(reading: Reading) -> Self {
        Self { reading }
    }
}

impl Deref for Recordings {
    type Target = Reading;

    fn deref(&self) -> &Reading {
        &self.reading
    }
}

impl Recordings {
    /// What each of them says about its valve, in their order; on all threads, with the feature `rayon`.
    ///
    /// # Errors
    /// As for [`diagnose`](crate::diagnose::diagnose); of several, the first.
    pub fn diagnose(&self) -> crate::Result<Vec<Found>> {
        self.diagnose_with(&DiagnoseOptions::default())
    }

    /// As [`diagnose`](Self::diagnose), with options.
    ///
    /// # Errors
    /// As for [`diagnose`](Self::diagnose), and if an option is out of range.
    pub fn diagnose_with(&self, options: &DiagnoseOptions) -> crate::Result<Vec<Found>> {
        let one = |recording: &crate::recording::Recording| {
            let mut recording = recording.clone();
            recording.notes.splice(0..0, self.reading.notes.iter().cloned());
            let diagnosis = crate::diagnose::diagnose(&recording, options)?;
            let (origin, sha256) = (self.reading.origin.clone(), self.reading.sha256.clone());
            Ok(Found { origin, sha256, diagnosis })
        };
        use stiction_model::parallel::*;
        self.reading.recordings.par_iter().map(one).collect()
    }
}
