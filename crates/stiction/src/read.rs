//! Reads files to recordings and diagnoses them.

use crate::Found;
use crate::diagnose::DiagnoseOptions;
use std::ops::Deref;
use std::path::Path;
use stiction_io::{ReadOptions, Reading, reading};

/// The recordings in the CSV, Parquet, Excel or MATLAB file at `path`. Columns, time stamps and units are recognised.
///
/// # Errors
/// If the file cannot be read or understood; the message names file, row, column and remedy.
pub fn read(path: impl AsRef<Path>) -> stiction_io::Result<Recordings> {
    read_with(path, &ReadOptions::default())
}

/// Like [`read`], with options for what cannot be recognised.
///
/// # Errors
/// As for [`read`], and if `options` name something that the file lacks.
pub fn read_with(path: impl AsRef<Path>, options: &ReadOptions) -> stiction_io::Result<Recordings> {
    reading::read(path.as_ref(), options).map(Recordings::from)
}

/// The [`Reading`] of a file, whose fields can be read directly and whose recordings can be diagnosed.
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
    /// Diagnoses each recording, in order. The feature `rayon` uses all threads.
    ///
    /// # Errors
    /// As for [`diagnose`](crate::diagnose::diagnose); if several fail, the first error is returned.
    pub fn diagnose(&self) -> crate::Result<Vec<Found>> {
        self.diagnose_with(&DiagnoseOptions::default())
    }

    /// Like [`diagnose`](Self::diagnose), with options.
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
