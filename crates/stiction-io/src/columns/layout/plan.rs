//! The content of a sheet: its loops, and the role of each name.

use crate::columns::role::{Role, Signal};

/// The arrangement of loops in a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// One loop, one column per signal.
    OneLoop,
    /// Several loops side by side, one column per signal.
    Wide,
    /// One row per sample, with its tag.
    Long,
    /// Signals side by side, each with a column of times.
    SideBySide,
}

impl Layout {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::OneLoop => "one loop, one column per signal",
            Self::Wide => "wide: one column per signal of a loop",
            Self::Long => "long: one row per sample, with its tag",
            Self::SideBySide => "side by side: each signal with its own column of times",
        }
    }
}

/// The recognised role of a column or tag, with the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recognised {
    /// The part of the file, as in [`Sheet::part`](crate::sheet::Sheet::part).
    pub part: String,
    /// Name of the column, or of the tag of a long sheet.
    pub column: String,
    /// Role.
    pub role: Role,
    /// The loop to which the column belongs, if its name shows this.
    pub loop_name: Option<String>,
    /// The reason, in words.
    pub why: String,
}

/// A loop of a mapping that is not read, because a column or tag is missing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingLoop {
    /// Name.
    pub name: String,
    /// Why it is not read, with a remedy.
    pub reason: String,
    /// Whether the file has other signals of the loop. If not, it may be in another file.
    pub is_partly_here: bool,
}

/// A loop with the indices of the names of its signals and qualities.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LoopPlan {
    /// Name; none if unknown.
    pub name: Option<String>,
    /// Notes for the user on this loop.
    pub notes: Vec<String>,
    /// Why the loop is not read, if the file has a signal of the loop that could not become a column.
    pub unread: Option<String>,
    pub(super) signals: [Option<usize>; 5],
    pub(super) qualities: [Option<usize>; 5],
    pub(super) quality: Option<usize>,
}

impl LoopPlan {
    /// The name with `signal`.
    pub fn signal(&self, signal: Signal) -> Option<usize> {
        self.signals[signal as usize]
    }

    /// The name with the quality of `signal`.
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

/// A tag of a long sheet, with its rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tag {
    /// Name.
    pub name: String,
    /// Rows, in order.
    pub rows: Vec<usize>,
}

/// The place of the samples in a sheet.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// In columns, whose names name the loops.
    Columns,
    /// In rows with tags, which name the loops.
    Rows {
        /// The tags in order of their first row.
        tags: Vec<Tag>,
        /// The column of values.
        value: usize,
        /// The column of qualities.
        quality: Option<usize>,
    },
}

/// The plan of a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The arrangement of its loops.
    pub layout: Layout,
    /// The place of the samples.
    pub place: Place,
    /// The column of times; none if rows are evenly spaced.
    pub time: Option<usize>,
    /// The column of days, if `time` is a time of day.
    pub date: Option<usize>,
    /// The loops that have an OP, in order of their first name.
    pub loops: Vec<LoopPlan>,
    /// Every column and tag.
    pub recognised: Vec<Recognised>,
    /// The loops of the mapping that lack a column or tag.
    pub missing: Vec<MissingLoop>,
    /// Notes for the user.
    pub notes: Vec<String>,
}
