//! Files that can be read loop by loop, which needs memory only for some loops.
//!
//! Wide Parquet is read by columns, long Parquet by row groups. The result for a loop is the same as from reading the
//! whole file.

use crate::columns::layout::{self, Bundle, Shape};
use crate::columns::options::ReadOptions;
use crate::error::Result;
use crate::parquet::{Holds, ParquetFile};
use crate::reading::{self, Reading};
use crate::sheet::{Cells, Column, Sheet};
use sha2::{Digest, Sha256};
use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

/// Number of cells of beginnings held at a time.
const HEAD: usize = 2_000_000;

/// A file of several loops, with the places of each.
#[derive(Debug)]
pub struct PartedFile {
    file: ParquetFile,
    shape: Shape,
    bundles: Vec<Bundle>,
    /// The bundle of each loop.
    places: HashMap<String, usize>,
    /// The tags of each row group of long tables, as indices of the names.
    tags: Vec<Vec<usize>>,
    /// The row groups of each name of a long table.
    groups: Vec<Vec<usize>>,
    names: Vec<Arc<str>>,
    /// Names of signals whose loops have no OP, as indices.
    without_op: Vec<usize>,
}

/// The time of samples of a loop's OP.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stamp {
    /// s since 1970-01-01 UTC.
    Utc(f64),
    /// s since 1970-01-01 on the clock of the plant.
    Local(f64),
}

impl PartedFile {
    /// Finds the places of the loops in the file at `path`. `None` for a file that can only be read whole: CSV,
    /// MATLAB, a file of one loop, or one whose times are not of a time type.
    ///
    /// # Errors
    /// If the file cannot be read, or is damaged.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Option<Self>> {
        if !ParquetFile::is_one(path)? {
            return Ok(None);
        }
        let file = ParquetFile::open(path)?;
        let columns: Vec<&str> = file.columns().collect();
        let Some(shape) = layout::shape(&columns, options) else { return Ok(None) };
        if file.is_utc(shape.time).is_none() {
            return Ok(None);
        }
        let (mut names, mut tags): (Vec<Arc<str>>, Vec<Vec<usize>>) = (vec![], vec![]);
        let about_rows = match shape.long {
            None => {
                names.extend(columns.iter().map(|name| Arc::from(*name)));
                &shape.about_rows[..]
            }
            Some((tag, _)) => {
                let mut known: HashMap<Arc<str>, usize> = HashMap::new();
                let mut place = |word: &Arc<str>| {
                    *known.entry(Arc::clone(word)).or_insert_with(|| {
                        names.push(Arc::clone(word));
                        names.len() - 1
                    })
                };
                for group in 0..file.groups() {
                    let own: Vec<usize> = match file.holds(tag, group) {
                        Holds::Word(word) => vec![place(word)],
                        _ => {
                            let sheet = file.sheet(&[tag], &[group])?;
                            let Some(cells) = sheet.columns.first().and_then(words) else {
                                return Ok(None);
                            };
                            distinct(cells).into_iter().map(&mut place).collect()
                        }
                    };
                    tags.push(own);
                }
                &[]
            }
        };
        let named: Vec<&str> = names.iter().map(|name| &**name).collect();
        let Some(bundles) = layout::bundles(&named, about_rows, options) else { return Ok(None) };
        let without_op = layout::without_op(&named, &bundles, options);
        let mut groups = vec![vec![]; if shape.long.is_some() { names.len() } else { 0 }];
        for (group, own) in tags.iter().enumerate() {
            own.iter().for_each(|tag| groups[*tag].push(group));
        }
        let places = bundles.iter().enumerate().flat_map(|(place, bundle)| {
            bundle.loops.iter().map(move |(name, _)| (name.clone(), place))
        });
        let places = places.collect();
        Ok(Some(Self { file, shape, bundles, places, tags, groups, names, without_op }))
    }

    /// The loops that have an OP, by the name of the OP.
    pub fn loops(&self) -> impl Iterator<Item = &str> {
        self.bundles.iter().flat_map(|bundle| &bundle.loops).map(|(name, _)| &**name)
    }

    /// Whether a loop has a PV.
    pub fn has_pv(&self, name: &str) -> bool {
        self.places.get(name).is_some_and(|place| self.bundles[*place].has_pv)
    }

    /// The names of signals that nothing reads, because their loops have no OP.
    pub fn without_op(&self) -> impl Iterator<Item = &str> {
        self.without_op.iter().map(|name| &*self.names[*name])
    }

    /// Passes to `visit`, for each loop, the first and the last time of stretches of samples of its OP. A stretch
    /// that `whole` rejects is passed sample by sample.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn stretches(
        &self,
        whole: impl Fn(Stamp, Stamp) -> bool,
        mut visit: impl FnMut(&str, Stamp, Stamp),
    ) -> Result<()> {
        let utc = self.file.is_utc(self.shape.time) == Some(true);
        let stamp = |seconds: f64| if utc { Stamp::Utc(seconds) } else { Stamp::Local(seconds) };
        let mut of_tag: HashMap<usize, Vec<&str>> = HashMap::new();
        for (name, op) in self.bundles.iter().flat_map(|bundle| &bundle.loops) {
            of_tag.entry(*op).or_default().push(name);
        }
        for group in 0..self.file.groups() {
            // A row of a wide table belongs to all loops.
            let there: Vec<usize> = match self.tags.get(group) {
                Some(tags) => tags.iter().copied().filter(|tag| of_tag.contains_key(tag)).collect(),
                None => of_tag.keys().copied().collect(),
            };
            if there.is_empty() {
                continue;
            }
            if let Holds::Times(first, last) = self.file.holds(self.shape.time, group)
                && whole(stamp(*first), stamp(*last))
            {
                for name in there.iter().flat_map(|tag| &of_tag[tag]) {
                    visit(name, stamp(*first), stamp(*last));
                }
                continue;
            }
            let columns: Vec<usize> =
                [self.shape.time].into_iter().chain(self.shape.long.map(|(tag, _)| tag)).collect();
            let sheet = self.file.sheet(&columns, &[group])?;
            let Some(Cells::Times { seconds, .. }) = sheet.columns.first().map(|c| &c.cells) else {
                continue;
            };
            let words = sheet.columns.get(1).and_then(words);
            let by_word: HashMap<&str, usize> =
                there.iter().map(|tag| (&*self.names[*tag], *tag)).collect();
            let mut last: Option<(&Arc<str>, Option<usize>)> = None;
            for (row, second) in seconds.iter().enumerate() {
                let mut hand = |tag: &usize| {
                    of_tag[tag].iter().for_each(|name| visit(name, stamp(*second), stamp(*second)));
                };
                let Some(words) = words else {
                    there.iter().for_each(&mut hand);
                    continue;
                };
                let word = &words[row];
                let tag = match last.filter(|(known, _)| Arc::ptr_eq(known, word)) {
                    Some((_, tag)) => tag,
                    None => by_word.get(&**word).copied(),
                };
                last = Some((word, tag));
                tag.iter().for_each(&mut hand);
            }
        }
        Ok(())
    }

    /// Number of rows decoded to read these loops, and of rows in the file.
    pub fn rows<'n>(&self, loops: impl IntoIterator<Item = &'n str>) -> (usize, usize) {
        let of = |groups: &mut dyn Iterator<Item = usize>| {
            groups.map(|group| self.file.rows(group)).sum()
        };
        let all = of(&mut (0..self.file.groups()));
        let names = self.names_of(loops);
        match self.shape.long {
            None => (all * names.len() / self.names.len().max(1), all),
            Some(_) => (of(&mut self.groups_of(&names).into_iter()), all),
        }
    }

    /// SHA-256 of the stored data of each loop whose row groups hold no other data.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn fingerprints(&self) -> Result<HashMap<&str, String>> {
        let mut found = HashMap::new();
        if self.shape.long.is_none() {
            return Ok(found);
        }
        for bundle in &self.bundles {
            let groups = self.groups_of(&bundle.names);
            let own: HashSet<&usize> = bundle.names.iter().collect();
            if groups.iter().flat_map(|group| &self.tags[*group]).any(|tag| !own.contains(tag)) {
                continue;
            }
            let mut hasher = Sha256::new();
            for group in groups {
                hasher.update(self.file.rows(group).to_le_bytes());
                for chunk in self.file.stored(group)? {
                    hasher.update(chunk.len().to_le_bytes());
                    hasher.update(&chunk);
                }
            }
            let sha256 = format!("{:x}", hasher.finalize());
            found.extend(bundle.loops.iter().map(|(name, _)| (&**name, sha256.clone())));
        }
        Ok(found)
    }

    /// Reads the first samples of every loop, some loops at a time, and passes each reading to `visit`.
    ///
    /// # Errors
    /// As for [`PartedFile::read`].
    pub fn heads(&self, options: &ReadOptions, mut visit: impl FnMut(Reading)) -> Result<()> {
        let mut bundles = self.bundles.iter().peekable();
        while bundles.peek().is_some() {
            let (mut names, mut groups): (Vec<usize>, HashSet<usize>) = Default::default();
            let mut rows = 0;
            while let Some(bundle) = bundles.next_if(|_| rows < HEAD) {
                names.extend(&bundle.names);
                let first = |name: &usize| match self.shape.long {
                    Some(_) => self.groups[*name].first().copied(),
                    None => (self.file.groups() > 0).then_some(0),
                };
                groups.extend(bundle.names.iter().filter_map(first));
                let long: usize = groups.iter().map(|group| self.file.rows(*group)).sum();
                rows = if self.is_long() { long } else { long * names.len() };
            }
            names.sort_unstable();
            let mut groups: Vec<usize> = groups.into_iter().collect();
            groups.sort_unstable();
            let sheet = self.part(&names, &groups)?;
            visit(reading::of_sheet(sheet, &self.options_of(&names, options))?);
        }
        Ok(())
    }

    /// Number of row groups.
    pub fn groups(&self) -> usize {
        self.file.groups()
    }

    /// Whether a row is a sample.
    pub fn is_long(&self) -> bool {
        self.shape.long.is_some()
    }

    /// The sheets of a long table, one per row group, to be sorted by [loops](Self::tags_of).
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn sheets(&self) -> impl Iterator<Item = Result<Sheet>> {
        let columns: Vec<usize> = (0..self.file.columns().count()).collect();
        (0..self.file.groups()).map(move |group| self.file.sheet(&columns, &[group]))
    }

    /// A sheet of the file's columns, without rows.
    ///
    /// # Errors
    /// None is known.
    pub fn empty(&self) -> Result<Sheet> {
        let columns: Vec<usize> = (0..self.file.columns().count()).collect();
        self.file.sheet(&columns, &[])
    }

    /// The tags read for these loops.
    pub fn tags_of<'n>(&self, loops: impl IntoIterator<Item = &'n str>) -> Vec<&str> {
        self.names_of(loops).into_iter().map(|name| &*self.names[name]).collect()
    }

    /// The tags in a sheet of a long table.
    pub fn tags<'s>(&self, sheet: &'s Sheet) -> &'s [Arc<str>] {
        let tags = self.shape.long.and_then(|(tag, _)| sheet.columns.get(tag)).and_then(words);
        tags.unwrap_or(&[])
    }

    /// The recordings of these loops, from a sheet that contains only these loops.
    ///
    /// # Errors
    /// As for [`reading::parse`].
    pub fn recordings<'n>(
        &self,
        sheet: Sheet,
        loops: impl IntoIterator<Item = &'n str>,
        options: &ReadOptions,
    ) -> Result<Reading> {
        reading::of_sheet(sheet, &self.options_of(&self.names_of(loops), options))
    }

    /// The options that concern the loops of these names.
    fn options_of(&self, names: &[usize], options: &ReadOptions) -> ReadOptions {
        let names: HashSet<&usize> = names.iter().collect();
        let told =
            self.bundles.iter().filter(|bundle| bundle.names.iter().any(|n| names.contains(n)));
        let told = told.flat_map(|bundle| &bundle.loops).map(|(name, _)| name.to_lowercase());
        options.of_loops(&told.collect())
    }

    /// The recordings of these loops, and of loops that must be read with them.
    ///
    /// # Errors
    /// As for [`reading::parse`].
    pub fn read<'n>(
        &self,
        loops: impl IntoIterator<Item = &'n str>,
        options: &ReadOptions,
    ) -> Result<Reading> {
        let names = self.names_of(loops);
        let options = self.options_of(&names, options);
        let groups = match self.shape.long {
            Some(_) => self.groups_of(&names),
            None => (0..self.file.groups()).collect(),
        };
        reading::of_sheet(self.part(&names, &groups)?, &options)
    }

    /// The data of these names in these row groups.
    fn part(&self, names: &[usize], groups: &[usize]) -> Result<Sheet> {
        let Some((tag, _)) = self.shape.long else {
            let mut columns: Vec<usize> =
                names.iter().chain(&self.shape.about_rows).copied().collect();
            columns.sort_unstable();
            return self.file.sheet(&columns, groups);
        };
        let columns: Vec<usize> = (0..self.file.columns().count()).collect();
        let sheet = self.file.sheet(&columns, groups)?;
        let wanted: HashSet<&str> = names.iter().map(|name| &*self.names[*name]).collect();
        let mut there = groups.iter().flat_map(|group| &self.tags[*group]);
        if there.any(|tag| !wanted.contains(&*self.names[*tag]))
            && let Some(tags) = words(&sheet.columns[tag])
        {
            let is_wanted = |row: &usize| wanted.contains(&*tags[*row]);
            let kept: Vec<usize> = (0..tags.len()).filter(is_wanted).collect();
            return Ok(sheet.rows_at(&kept));
        }
        Ok(sheet)
    }

    /// The names read for these loops, in order.
    fn names_of<'n>(&self, loops: impl IntoIterator<Item = &'n str>) -> Vec<usize> {
        let places: HashSet<usize> =
            loops.into_iter().filter_map(|name| self.places.get(name).copied()).collect();
        let mut names: Vec<usize> = places
            .into_iter()
            .flat_map(|place| self.bundles[place].names.iter().copied())
            .collect();
        names.sort_unstable();
        names
    }

    /// The row groups that hold some of these tags, in order.
    fn groups_of(&self, tags: &[usize]) -> Vec<usize> {
        let mut groups: Vec<usize> =
            tags.iter().flat_map(|tag| self.groups[*tag].iter().copied()).collect();
        groups.sort_unstable();
        groups.dedup();
        groups
    }
}

/// The words of a column.
fn words(column: &Column) -> Option<&[Arc<str>]> {
    match &column.cells {
        Cells::Text(texts) => texts.words(),
        _ => None,
    }
}

/// The different words among cells, in order of first appearance.
fn distinct(cells: &[Arc<str>]) -> Vec<&Arc<str>> {
    let mut seen: HashSet<&str> = HashSet::new();
    let mut words: Vec<&Arc<str>> = vec![];
    for cell in cells {
        if words.last().is_some_and(|last| Arc::ptr_eq(last, cell)) {
            continue;
        }
        if seen.insert(cell) {
            words.push(cell);
        }
    }
    words
}
