//! The files of a plant, read for some of its loops at a time.

use crate::error::Result;
use crate::plant_file::Plant;
use crate::scan::spill::{self, Spill};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use stiction_diagnose::recording::Recording;
use stiction_io::parted::PartedFile;
use stiction_io::reading;
use stiction_io::sheet::Sheet;

/// Number of bytes of a sample of a recording: time, value, quality.
const SAMPLE: usize = 17;
/// Approximate memory of a row group in the metadata of a file.
const GROUP: usize = 256;

/// The recordings of a loop, and possibly of others, or the reason why the loop cannot be read.
pub type Loops = Result<Arc<Vec<Recording>>, String>;

/// The files of a plant, with a cache of those used last.
pub struct Files<'a> {
    folder: &'a Path,
    plant: &'a Plant,
    /// Size of the cache, bytes.
    memory: usize,
    opened: Mutex<Vec<(String, Opened)>>,
    /// Folders of sorted rows, by file.
    sorted: HashMap<String, PathBuf>,
}

#[derive(Clone)]
enum Opened {
    Parted(Arc<PartedFile>),
    Whole(Arc<Vec<Recording>>),
}

impl Opened {
    fn bytes(&self) -> usize {
        let samples = |each: &Recording| {
            let channels = [Some(&each.op), each.pv.as_ref(), each.sp.as_ref(), each.vp.as_ref()];
            channels.into_iter().flatten().map(|channel| channel.time.len()).sum::<usize>()
        };
        match self {
            Self::Parted(file) => file.groups() * GROUP,
            Self::Whole(recordings) => recordings.iter().map(samples).sum::<usize>() * SAMPLE,
        }
    }
}

impl<'a> Files<'a> {
    /// The files of a plant in `folder`, with a cache of `memory` bytes.
    pub fn of(folder: &'a Path, plant: &'a Plant, memory: usize) -> Self {
        Self { folder, plant, memory, opened: Mutex::default(), sorted: HashMap::new() }
    }

    fn open(&self, path: &str) -> stiction_io::Result<Opened> {
        let mut opened = self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(place) = opened.iter().position(|(known, _)| known == path) {
            let known = opened.remove(place);
            opened.push(known.clone());
            return Ok(known.1);
        }
        drop(opened);
        let whole = self.folder.join(path);
        let file = match PartedFile::open(&whole, &self.plant.options)? {
            Some(file) => Opened::Parted(Arc::new(file)),
            None => {
                let reading = reading::read(&whole, &self.plant.options)?;
                Opened::Whole(Arc::new(reading.recordings))
            }
        };
        let mut opened = self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        opened.push((path.to_owned(), file.clone()));
        let mut bytes: usize = opened.iter().map(|(_, file)| file.bytes()).sum();
        while bytes > self.memory && opened.len() > 1 {
            bytes -= opened.remove(0).1.bytes();
        }
        Ok(file)
    }

    /// The approximate number of rows of one loop in a long table; 0 for an unreadable file.
    pub fn rows(&self, path: &str) -> usize {
        match self.open(path) {
            Ok(Opened::Parted(file)) => {
                let loops = file.loops().count().max(1);
                file.rows(file.loops()).1.div_ceil(loops)
                    * if file.is_long() { 1 } else { 3 * loops }
            }
            Ok(Opened::Whole(recordings)) => {
                recordings.iter().map(|each| 3 * each.op.time.len()).max().unwrap_or(0)
            }
            Err(_) => 0,
        }
    }

    /// Sorts the rows of a file to `folder`, by the batch that will read them, if the file would otherwise be decoded
    /// more than twice.
    ///
    /// # Errors
    /// If the sorted rows cannot be written. Faults of the file are reported when it is read.
    pub fn sort(&mut self, path: &str, batches: &[Vec<&str>], folder: &Path) -> Result<()> {
        let Ok(Opened::Parted(file)) = self.open(path) else { return Ok(()) };
        if !file.is_long() {
            return Ok(());
        }
        let decoded: usize = batches.iter().map(|batch| file.rows(batch.iter().copied()).0).sum();
        let all = file.rows([]).1;
        if decoded <= 2 * all {
            return Ok(());
        }
        let mut of_tag: HashMap<&str, usize> = HashMap::new();
        for (place, batch) in batches.iter().enumerate() {
            of_tag.extend(file.tags_of(batch.iter().copied()).into_iter().map(|tag| (tag, place)));
        }
        let mut spill = Spill::begin(folder, batches.len())?;
        for sheet in file.sheets() {
            let Ok(sheet) = sheet else { return Ok(()) };
            let tags = file.tags(&sheet);
            spill.add(&sheet, |row| of_tag.get(&*tags[row]).copied())?;
        }
        spill.end()?;
        self.sorted.insert(path.to_owned(), folder.to_owned());
        Ok(())
    }

    /// Forgets the sorted rows. The caller owns the folders.
    pub fn forget_sorted(&mut self) {
        self.sorted.clear();
    }

    /// The recordings of these loops in a file, and possibly of further loops. `batch` is their place when rows were
    /// sorted. If a loop is unreadable, each loop is read separately, so the others are unaffected.
    ///
    /// # Errors
    /// The reason why a loop cannot be read, a sentence. For an unreadable file it is the same for all loops.
    pub fn read(&self, path: &str, loops: &[&str], batch: usize) -> Vec<Loops> {
        let all = |result: Loops| vec![result; loops.len()];
        let file = match self.open(path) {
            Ok(Opened::Whole(recordings)) => return all(Ok(recordings)),
            Ok(Opened::Parted(file)) => file,
            Err(e) => return all(Err(e.to_string())),
        };
        let sorted = match self.sorted.get(path).map(|folder| sorted(&file, folder, batch)) {
            None => None,
            Some(Ok(Some(sheet))) => Some(sheet),
            Some(Ok(None)) => return all(Ok(Arc::default())),
            Some(Err(e)) => return all(Err(e)),
        };
        let together = self.part(&file, sorted.as_ref(), path, loops);
        match (together, loops) {
            (Ok(recordings), _) => all(Ok(recordings)),
            (Err(e), [_]) => vec![Err(e)],
            (Err(_), _) => loops
                .iter()
                .map(|own| {
                    let of_loop = sorted.as_ref().map(|sheet| {
                        let tags: HashSet<&str> = file.tags_of([*own]).into_iter().collect();
                        let all = file.tags(sheet);
                        let is_own = |row: &usize| tags.contains(&*all[*row]);
                        sheet.rows_at(&(0..all.len()).filter(is_own).collect::<Vec<_>>())
                    });
                    self.part(&file, of_loop.as_ref(), path, &[*own])
                })
                .collect(),
        }
    }

    /// The recordings of loops, from the file or from its sorted rows.
    fn part(&self, file: &PartedFile, sorted: Option<&Sheet>, path: &str, loops: &[&str]) -> Loops {
        let options = &self.plant.options;
        let names = || loops.iter().copied();
        let reading = match sorted {
            None => file.read(names(), options),
            Some(sheet) => file.recordings(sheet.clone(), names(), options),
        };
        let reading = reading.map_err(|e| e.to_string())?;
        let read = |name: &str| reading.recordings.iter().any(|own| own.name == name);
        let missing = reading.missing.iter().find(|missing| {
            let same = |own: &str| own.to_lowercase() == missing.name.to_lowercase() && !read(own);
            missing.is_partly_here && names().any(same)
        });
        match missing {
            Some(of) => Err(format!("{path}, loop {}: the file {}", of.name, of.reason)),
            None => Ok(Arc::new(reading.recordings)),
        }
    }
}

/// The rows sorted to a folder for a batch; none if the file has no rows for the batch.
fn sorted(file: &PartedFile, folder: &Path, batch: usize) -> Result<Option<Sheet>, String> {
    let empty = file.empty().map_err(|e| e.to_string())?;
    spill::read(folder, batch, &empty).map_err(|e| e.to_string())
}
