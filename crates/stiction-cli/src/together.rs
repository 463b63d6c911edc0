//! Reads several files. Those that hold one signal each are read together, if they or their names show the loop.

use crate::files::In;
use crate::input;
use anyhow::{Result, anyhow};
use rayon::prelude::*;
use std::collections::BTreeMap;
use stiction_io::reading::file_per_tag::{SignalFile, read_together};
use stiction_io::role::Signal;
use stiction_io::{ReadOptions, Reading, bytes};

/// The recordings in all files, in their order. Files that are read together are at the place of the first.
pub fn recordings(
    files: &[In],
    options: Vec<Result<ReadOptions>>,
    done: impl Fn() + Sync,
) -> Vec<Result<Reading>> {
    let mut readings: Vec<Option<Result<Reading>>> = files
        .par_iter()
        .zip(&options)
        .map(|(file, own)| {
            let reading = match own {
                Ok(own) => input::recordings(file, own).map_err(anyhow::Error::from),
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

/// Whether a file may hold one signal: it was refused, or has only an OP.
fn may_be_signal(reading: &Result<Reading>) -> bool {
    let Ok(reading) = reading else { return true };
    matches!(&reading.recordings[..],
        [one] if one.pv.is_none() && one.sp.is_none() && one.vp.is_none() && one.mode.is_none())
}

/// Reads files with one signal each together, and states how to assign those whose signal is unknown.
fn join(files: &[In], options: &[Result<ReadOptions>], readings: &mut [Option<Result<Reading>>]) {
    let mut of_loop: BTreeMap<Option<String>, Vec<(usize, SignalFile)>> = BTreeMap::new();
    for (k, file) in files.iter().enumerate().filter(|(_, file)| !file.is_standard()) {
        let is_one = readings[k].as_ref().is_some_and(may_be_signal);
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
                "{error:#}. If each file holds one signal of a loop, state which, as in --map \"op={name}\""
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
        let reading = read_together(&signals, options).map_err(anyhow::Error::from);
        places.iter().for_each(|place| readings[*place] = None);
        readings[places[0]] = Some(reading);
    }
}
