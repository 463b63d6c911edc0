//! What a sheet holds: its loops, and which of its names are what of them.

use crate::columns::role::{Role, Signal};

/// How a sheet holds its loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// One loop, a column a signal.
    OneLoop,
    /// Several loops side by side, a column a signal.
    Wide,
    /// A row a sample, with the name of its tag.
    Long,
}

impl Layout {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::OneLoop => "one loop, a column a signal",
            Self::Wide => "wide: a column a signal of a loop",
            Self::Long => "long: a row a sample, with its tag",
        }
    }
}

/// What a column or tag was recognised as, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recognised {
    /// The part of the file, as in [`Sheet::part`](crate::sheet::Sheet::part).
    pub part: String,
    /// Name of the column, or of the tag of a long sheet.
    pub column: String,
    /// What it is.
    pub role: Role,
    /// The loop it belongs to, where its name tells one.
    pub loop_name: Option<String>,
    /// Why, in words.
    pub why: String,
}

/// A loop that a mapping names, and that is not read because a column or tag is not there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingLoop {
    /// Its name.
    pub name: String,
    /// Why it is not read, with what would help.
    pub reason: String,
    /// Whether other signals of it are there; if not, it may be in another file.
    pub is_partly_here: bool,
}

/// A loop: which names hold its signals and qualities, as indices of the names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LoopPlan {
    /// Its name; none if nothing tells one.
    pub name: Option<String>,
    /// What the user should know of it alone.
    pub notes: Vec<String>,
    /// Why it is not read, where the file has a signal of it that could not be made a column.
    pub unread: Option<String>,
    pub(super) signals: [Option<usize>; 5],
    pub(super) qualities: [Option<usize>; 5],
    pub(super) quality: Option<usize>,
}

impl LoopPlan {
    /// The name that holds `signal`.
    pub fn signal(&self, signal: Signal) -> Option<usize> {
        self.signals[signal as usize]
    }

    /// The name that holds the quality of `signal`.
    pub fn quality(&self, signal: Signal) -> Option<usize> {
        self.qualities[signal as usize].or(self.quality)
    }

    pub(super) fn place(&mut self, role: Role) -> Option<&mut Option<usize>> {
        match role {
            Role::Signal(signal) => Some(&mut self.signals[signal as usize]),
            Role::Quality(Some(signal)) => Some(&mut self.qualities[signal as usize]),
            Role::Quality(None) => Some(&mut self.quality),
            _ => None,
        }
    }

    /// Every name it uses.
    pub(super) fn names(&self) -> impl Iterator<Item = usize> + '_ {
        self.signals.iter().chain(&self.qualities).chain([&self.quality]).flatten().copied()
    }

    pub(super) fn has_op(&self) -> bool {
        self.signal(Signal::Op).is_some()
    }
}

/// A tag of a long sheet and the rows that are its.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tag {
    /// Its name.
    pub name: String,
    /// Its rows, in their order.
    pub rows: Vec<usize>,
}

/// Where the samples of a sheet are.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// In columns, which are the names of the loops.
    Columns,
    /// In rows, each of a tag; the tags are the names of the loops.
    Rows {
        /// The tags in order of their first row.
        tags: Vec<Tag>,
        /// The column of values.
        value: usize,
        /// The column of qualities.
        quality: Option<usize>,
    },
}

/// What a sheet holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// How its loops lie in it.
    pub layout: Layout,
    /// Where the samples are.
    pub place: Place,
    /// The column of times; none if rows are evenly spaced.
    pub time: Option<usize>,
    /// The column of days, where `time` is a time of day.
    pub date: Option<usize>,
    /// The loops that have an OP, in order of their first name.
    pub loops: Vec<LoopPlan>,
    /// Every column and tag.
    pub recognised: Vec<Recognised>,
    /// The loops of the mapping that lack a column or tag.
    pub missing: Vec<MissingLoop>,
    /// What the user should know.
    pub notes: Vec<String>,
}
