//! The texts of a column. Cells of a large table wait in a file without a name until they are used, so memory depends
//! on the columns in use and not on the table.

use std::borrow::Cow;
use std::fmt;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::ops::Index;
use std::sync::{Arc, Mutex, PoisonError};

/// The byte behind each packed text. Text files that hold it are refused.
const END: char = '\0';

/// The most bytes of a block. Its ends count in 32 bits.
const BLOCK: usize = 16 << 20;

/// Number of bytes that a packed text takes beside its own.
pub(crate) const BESIDE: usize = size_of::<u32>() + END.len_utf8();

/// The most bytes of packed texts that a table holds in memory.
pub(crate) const MOST_HELD: usize = 256 << 20;

/// The texts of a column as written, empty if missing.
#[derive(Clone)]
pub struct Texts(Kind);

#[derive(Clone)]
enum Kind {
    /// Repeated words, such as tags, share one copy.
    Words(Vec<Arc<str>>),
    Packed(Packed),
    Stored {
        store: Arc<Store>,
        places: Vec<Place>,
        len: usize,
    },
}

/// Texts behind each other.
#[derive(Debug, Clone, Default)]
pub struct Packed {
    blocks: Vec<Block>,
    len: usize,
}

#[derive(Debug, Clone, Default)]
struct Block {
    /// Index of its first text.
    begin: usize,
    text: String,
    ends: Vec<u32>,
}

/// The texts of a column, to be read.
#[derive(Debug)]
pub enum View<'a> {
    #[doc(hidden)]
    Words(&'a [Arc<str>]),
    #[doc(hidden)]
    Packed(&'a Packed),
    /// The first of them.
    #[doc(hidden)]
    Stored(Arc<Packed>, usize),
}

impl Texts {
    /// Number of texts.
    pub fn len(&self) -> usize {
        match &self.0 {
            Kind::Words(words) => words.len(),
            Kind::Packed(packed) => packed.len,
            Kind::Stored { len, .. } => *len,
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The texts, fetched if they are stored. They stay in memory at least as long as the view.
    pub fn view(&self) -> View<'_> {
        match &self.0 {
            Kind::Words(words) => View::Words(words),
            Kind::Packed(packed) => View::Packed(packed),
            Kind::Stored { store, places, len } => View::Stored(store.load(places, *len), *len),
        }
    }

    /// The words, if they are shared.
    pub fn words(&self) -> Option<&[Arc<str>]> {
        match &self.0 {
            Kind::Words(words) => Some(words),
            _ => None,
        }
    }

    /// The texts in these rows.
    #[must_use]
    pub fn at(&self, rows: &[usize]) -> Self {
        match self.view() {
            View::Words(words) => rows.iter().map(|row| Arc::clone(&words[*row])).collect(),
            view => rows.iter().map(|row| &view[*row]).collect(),
        }
    }

    /// Appends a word.
    pub fn push(&mut self, word: Arc<str>) {
        match &mut self.0 {
            Kind::Words(words) => words.push(word),
            Kind::Packed(packed) => packed.push(&word),
            Kind::Stored { .. } => self.append([word].into_iter().collect()),
        }
    }

    /// Appends other texts.
    pub fn append(&mut self, other: Self) {
        match (&mut self.0, other.0) {
            (Kind::Words(own), Kind::Words(more)) => own.extend(more),
            (Kind::Packed(own), other) => {
                Self(other).view().iter().for_each(|text| own.push(text));
            }
            (_, other) => {
                let both = self.view().iter().chain(Self(other).view().iter()).collect();
                *self = both;
            }
        }
    }

    /// Why stored texts could not be fetched, if so.
    pub(crate) fn failure(&self) -> Option<String> {
        match &self.0 {
            Kind::Stored { store, .. } => store.lock().failure.clone(),
            _ => None,
        }
    }

    /// Keeps the first texts.
    pub(crate) fn truncate(&mut self, most: usize) {
        match &mut self.0 {
            Kind::Words(words) => words.truncate(most),
            Kind::Packed(packed) => packed.truncate(most),
            Kind::Stored { len, .. } => *len = most.min(*len),
        }
    }
}

impl From<Vec<Arc<str>>> for Texts {
    fn from(words: Vec<Arc<str>>) -> Self {
        Self(Kind::Words(words))
    }
}

impl FromIterator<Arc<str>> for Texts {
    fn from_iter<I: IntoIterator<Item = Arc<str>>>(words: I) -> Self {
        Self(Kind::Words(words.into_iter().collect()))
    }
}

impl<'t> FromIterator<&'t str> for Texts {
    fn from_iter<I: IntoIterator<Item = &'t str>>(texts: I) -> Self {
        let mut packed = Packed::default();
        texts.into_iter().for_each(|text| packed.push(text));
        Self(Kind::Packed(packed))
    }
}

impl<'t> FromIterator<Cow<'t, str>> for Texts {
    fn from_iter<I: IntoIterator<Item = Cow<'t, str>>>(texts: I) -> Self {
        let mut packed = Packed::default();
        texts.into_iter().for_each(|text| packed.push(&text));
        Self(Kind::Packed(packed))
    }
}

impl PartialEq for Texts {
    fn eq(&self, other: &Self) -> bool {
        self.len() == other.len() && self.view().iter().eq(other.view().iter())
    }
}

impl fmt::Debug for Texts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.view().iter()).finish()
    }
}

impl View<'_> {
    /// Number of texts.
    pub fn len(&self) -> usize {
        match self {
            Self::Words(words) => words.len(),
            Self::Packed(packed) => packed.len,
            Self::Stored(_, len) => *len,
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The text in a row, if there is such a row.
    pub fn get(&self, row: usize) -> Option<&str> {
        (row < self.len()).then(|| &self[row])
    }

    /// The first text.
    pub fn first(&self) -> Option<&str> {
        self.get(0)
    }

    /// The last text.
    pub fn last(&self) -> Option<&str> {
        self.get(self.len().checked_sub(1)?)
    }

    /// All texts in order.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &str> {
        (0..self.len()).map(|row| &self[row])
    }
}

impl Index<usize> for View<'_> {
    type Output = str;

    #[inline]
    fn index(&self, row: usize) -> &str {
        match self {
            Self::Words(words) => &words[row],
            Self::Packed(packed) => packed.get(row),
            Self::Stored(packed, _) => packed.get(row),
        }
    }
}

impl Packed {
    #[inline]
    fn get(&self, row: usize) -> &str {
        let block = match &self.blocks[..] {
            [one] => one,
            several => &several[several.partition_point(|block| block.begin <= row) - 1],
        };
        let row = row - block.begin;
        let begin = row.checked_sub(1).map_or(0, |before| block.ends[before] as usize + 1);
        &block.text[begin..block.ends[row] as usize]
    }

    #[inline]
    fn push(&mut self, text: &str) {
        let is_full = |block: &Block| block.text.len() + text.len() >= BLOCK;
        if self.blocks.last().is_none_or(is_full) {
            self.blocks.push(Block { begin: self.len, ..Block::default() });
        }
        if let Some(block) = self.blocks.last_mut() {
            block.text.push_str(text);
            block.ends.push(block.text.len() as u32);
            block.text.push(END);
            self.len += 1;
        }
    }

    /// Appends the texts of a stored place.
    fn take(&mut self, text: String) {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == END as u8);
        let ends: Vec<u32> = ends.map(|(at, _)| at as u32).collect();
        let begin = self.len;
        self.len += ends.len();
        self.blocks.push(Block { begin, text, ends });
    }

    fn truncate(&mut self, most: usize) {
        self.blocks.retain(|block| block.begin < most);
        if let Some(block) = self.blocks.last_mut() {
            block.ends.truncate(most - block.begin);
            block.text.truncate(block.ends.last().map_or(0, |end| *end as usize + 1));
        }
        self.len = self.len.min(most);
    }

    fn bytes(&self) -> usize {
        self.blocks.iter().map(|block| block.text.len()).sum::<usize>()
            + self.len * size_of::<u32>()
    }
}

/// Where a block is in a store.
#[derive(Debug, Clone)]
struct Place {
    at: u64,
    bytes: usize,
}

/// Texts in a file without a name, which the system removes when it is closed.
#[derive(Debug)]
struct Store(Mutex<Inside>);

#[derive(Debug)]
struct Inside {
    file: File,
    /// The columns used last, by the place of their first block.
    loaded: Vec<(u64, Arc<Packed>)>,
    /// Largest number of bytes of these columns.
    most: usize,
    failure: Option<String>,
}

impl Store {
    fn lock(&self) -> std::sync::MutexGuard<'_, Inside> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The texts of a column. If they cannot be fetched, they are empty, and the failure is kept.
    fn load(&self, places: &[Place], len: usize) -> Arc<Packed> {
        let mut inside = self.lock();
        let key = places.first().map_or(0, |place| place.at);
        let packed = match inside.loaded.iter().position(|(known, _)| *known == key) {
            Some(place) => inside.loaded.remove(place).1,
            None => {
                let packed = Arc::new(inside.fetch(places, len));
                let mut held = packed.bytes();
                let first = inside.loaded.iter().rposition(|(_, packed)| {
                    held += packed.bytes();
                    held > inside.most
                });
                inside.loaded.drain(..first.map_or(0, |first| first + 1));
                packed
            }
        };
        inside.loaded.push((key, Arc::clone(&packed)));
        packed
    }
}

impl Inside {
    fn fetch(&mut self, places: &[Place], len: usize) -> Packed {
        let mut packed = Packed::default();
        for place in places {
            let mut bytes = vec![0; place.bytes];
            let read = self.file.seek(SeekFrom::Start(place.at));
            match read.and_then(|_| self.file.read_exact(&mut bytes)) {
                Ok(()) => packed.take(String::from_utf8(bytes).unwrap_or_default()),
                Err(error) => self.failure = Some(refused(&error)),
            }
        }
        (packed.len..len).for_each(|_| packed.push(""));
        packed
    }
}

/// The message that texts cannot be stored or fetched.
fn refused(error: &std::io::Error) -> String {
    format!(
        "is so large that the program keeps its cells in a temporary file in {}, which failed: {error}; free space \
         there, or name another folder in the environment variable TMPDIR",
        std::env::temp_dir().display()
    )
}

/// Columns of texts that are filled row by row.
pub(crate) struct Filling {
    columns: Vec<Packed>,
    places: Vec<Vec<Place>>,
    file: Option<File>,
    /// Bytes in the file.
    at: u64,
    rows: usize,
    /// Bytes in memory, and the limit.
    held: usize,
    most: usize,
}

impl Filling {
    /// So many empty columns, of which `most` bytes stay in memory.
    pub fn new(columns: usize, most: usize) -> Self {
        Self {
            columns: vec![Packed::default(); columns],
            places: vec![vec![]; columns],
            file: None,
            at: 0,
            rows: 0,
            held: 0,
            most,
        }
    }

    /// Appends a row, with empty texts where it has fewer cells than there are columns.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn push<'t>(&mut self, mut cells: impl Iterator<Item = &'t str>) -> Result<(), String> {
        for column in &mut self.columns {
            let cell = cells.next().unwrap_or("");
            self.held += cell.len() + BESIDE;
            column.push(cell);
        }
        self.rows += 1;
        if self.held > self.most { self.store().map_err(|error| refused(&error)) } else { Ok(()) }
    }

    /// Moves all columns to the file.
    fn store(&mut self) -> std::io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            file => file.insert(tempfile::tempfile()?),
        };
        for (column, places) in self.columns.iter_mut().zip(&mut self.places) {
            for block in std::mem::take(column).blocks {
                file.write_all(block.text.as_bytes())?;
                places.push(Place { at: self.at, bytes: block.text.len() });
                self.at += block.text.len() as u64;
            }
        }
        self.held = 0;
        Ok(())
    }

    /// The columns.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn end(mut self) -> Result<Vec<Texts>, String> {
        if self.file.is_some() {
            self.store().map_err(|error| refused(&error))?;
        }
        let Some(file) = self.file else {
            return Ok(self
                .columns
                .into_iter()
                .map(|packed| Texts(Kind::Packed(packed)))
                .collect());
        };
        let inside = Inside { file, loaded: vec![], most: self.most, failure: None };
        let (store, len) = (Arc::new(Store(Mutex::new(inside))), self.rows);
        let stored = |places| Texts(Kind::Stored { store: Arc::clone(&store), places, len });
        Ok(self.places.into_iter().map(stored).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of 1000 rows, of which `most` bytes stay in memory.
    fn filled(most: usize) -> Vec<Texts> {
        let mut columns = Filling::new(3, most);
        for row in 0..1000 {
            let (a, b) = (row.to_string(), "\u{b0}\n".repeat(row % 3));
            columns.push([&*a, &*b].into_iter()).unwrap();
        }
        columns.end().unwrap()
    }

    #[test]
    fn texts_are_the_same_in_memory_and_in_a_file() {
        let here = filled(usize::MAX);
        for most in [0, 100, 10_000] {
            let stored = filled(most);
            assert!(stored.iter().all(|column| matches!(column.0, Kind::Stored { .. })));
            assert_eq!(stored, here, "{most}");
            assert_eq!(stored[0].view().iter().next_back(), Some("999"));
            assert!(stored[2].view().iter().all(str::is_empty));
            let Kind::Stored { store, .. } = &stored[0].0 else { panic!("stored") };
            let held = || store.lock().loaded.iter().map(|(_, each)| each.bytes()).sum::<usize>();
            // A column that is larger than what may be held stays alone.
            assert!(held() <= most.max(filled(usize::MAX)[0].view().iter().count() * 20));
        }
    }

    #[test]
    fn rows_are_chosen_cut_and_appended() {
        for most in [usize::MAX, 500] {
            let [mut a, b, _] = <[Texts; 3]>::try_from(filled(most)).unwrap();
            assert_eq!(a.at(&[7, 500]), ["7", "500"].into_iter().collect());
            a.truncate(2);
            assert_eq!(a.view().iter().collect::<Vec<_>>(), ["0", "1"]);
            a.push("x".into());
            a.append(b.at(&[1]));
            assert_eq!(a.view().iter().collect::<Vec<_>>(), ["0", "1", "x", "\u{b0}\n"]);
            assert_eq!((a.view().get(3), a.view().get(4)), (Some("\u{b0}\n"), None));
        }
        let words: Texts = vec![Arc::from("a"), Arc::from("b")].into();
        assert_eq!(words.at(&[1, 1]), ["b", "b"].into_iter().collect());
    }

    #[test]
    fn large_columns_have_several_blocks() {
        let long = "x".repeat(BLOCK / 3);
        let texts: Texts = (0..7).map(|_| &*long).chain(["end"]).collect();
        let Kind::Packed(packed) = &texts.0 else { panic!("packed") };
        assert!(packed.blocks.len() > 2);
        assert_eq!((texts.view().last(), texts.view()[6].len()), (Some("end"), long.len()));
    }

    #[test]
    fn a_file_that_cannot_be_read_is_a_failure() {
        let stored = filled(0);
        let Kind::Stored { store, .. } = &stored[0].0 else { panic!("stored") };
        store.lock().file.set_len(10).unwrap();
        assert_eq!(stored[0].view().len(), 1000);
        assert_eq!(&stored[0].view()[999], "");
        assert!(stored[1].failure().unwrap().contains("TMPDIR"));
    }
}
