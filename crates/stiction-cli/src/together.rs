//! Reads several files. Files with one signal each are read together, if the files or their names identify the loop.

use crate::files::In;
use crate::input;
use anyhow::{Result, anyhow};
use rayon::prelude::*;
use std::collections::BTreeMap;
use stiction_io::reading::file_per_tag::{SignalFile, read_together};
use stiction_io::role::Signal;
use stiction_io::summary::Loop;
use stiction_io::{ReadOptions, Reading, Summary, bytes};

/// What a command keeps of a file.
pub trait Kept: Send + Sized {
    /// Reads a file.
    ///
    /// # Errors
    /// As for [`input::recordings`].
    fn read(file: &In, options: &ReadOptions) -> stiction_io::Result<Self>;

    /// What is kept of files that were read together.
    fn of(reading: Reading) -> Self;

    /// Whether it is one loop with only an OP.
    fn is_lone_op(&self) -> bool;
}

impl Kept for Reading {
    fn read(file: &In, options: &ReadOptions) -> stiction_io::Result<Self> {
        input::recordings(file, options)
    }

    fn of(reading: Reading) -> Self {
        reading
    }

    fn is_lone_op(&self) -> bool {
        matches!(&self.recordings[..],
            [one] if one.pv.is_none() && one.sp.is_none() && one.vp.is_none() && one.mode.is_none())
    }
}

impl Kept for Summary {
    fn read(file: &In, options: &ReadOptions) -> stiction_io::Result<Self> {
        let mut loops = vec![];
        let reading = input::visit(file, options, &mut |recording, clock| {
            loops.push(Loop::of(&recording, clock));
        })?;
        Ok(Self { loops, ..Self::from(&reading) })
    }

    fn of(reading: Reading) -> Self {
        Self::from(&reading)
    }

    fn is_lone_op(&self) -> bool {
        matches!(&self.loops[..], [one] if one.signals.len() == 1 && one.modes.is_none())
    }
}

/// What is kept of all files, in their order. Files that are read together are at the place of the first.
pub fn read<T: Kept>(
    files: &[In],
    options: Vec<Result<ReadOptions>>,
    done: impl Fn() + Sync,
) -> Vec<Result<T>> {
    let mut readings: Vec<Option<Result<T>>> = files
        .par_iter()
        .zip(&options)
        .map(|(file, own)| {
            let reading = match own {
                Ok(own) => T::read(file, own).map_err(anyhow::Error::from),
                Err(error) => Err(anyhow!("{error:#}")),
            };
            done();
            Some(reading)
        })
        .collect();
    if files.len() > 1 && readings.iter().flatten().any(Result::is_err) {
        join(files, &options, &mut readings);
    }
    readings.into_iter().flatten().collect()
}

/// Reads files with one signal each together, and states how to assign those whose signal is unknown.
fn join<T: Kept>(
    files: &[In],
    options: &[Result<ReadOptions>],
    readings: &mut [Option<Result<T>>],
) {
    let mut of_loop: BTreeMap<Option<String>, Vec<(usize, SignalFile)>> = BTreeMap::new();
    for (k, file) in files.iter().enumerate().filter(|(_, file)| !file.is_standard()) {
        // It was refused, or has only an OP.
        let is_one = match &readings[k] {
            Some(Ok(reading)) => reading.is_lone_op(),
            refused => refused.is_some(),
        };
        let (true, Ok(options), Ok(bytes)) = (is_one, &options[k], bytes::read(file)) else {
            continue;
        };
        let Some(found) = SignalFile::of(&bytes, &file.origin(), options) else { continue };
        if found.signal.is_some() {
            let key = found.loop_name.as_ref().map(|name| name.to_lowercase());
            of_loop.entry(key).or_default().push((k, found));
        } else if let Some(Err(error)) = &readings[k] {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            readings[k] = Some(Err(anyhow!(
                "{error:#}. If each file holds one signal of a loop, state the signal, as in --map \"op={name}\""
            )));
        }
    }
    for group in of_loop.into_values().filter(|group| group.len() > 1) {
        let count =
            |signal: Signal| group.iter().filter(|(_, file)| file.signal == Some(signal)).count();
        let is_loop =
            Signal::ALL.into_iter().all(|signal| count(signal) <= 1) && count(Signal::Op) == 1;
        let (places, signals): (Vec<usize>, Vec<SignalFile>) = group.into_iter().unzip();
        if !is_loop {
            continue;
        }
        let Ok(options) = &options[places[0]] else { continue };
        let reading = read_together(&signals, options).map(T::of).map_err(anyhow::Error::from);
        places.iter().for_each(|place| readings[*place] = None);
        readings[places[0]] = Some(reading);
    }
}
