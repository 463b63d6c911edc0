//! One override.

use jiff::civil::Date;
use jiff::tz::TimeZone;
use stiction_diagnose::diagnose::{self, VerdictClass};

/// The conclusion of a person about a valve.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// Tag of the loop, exactly.
    pub loop_name: String,
    /// The conclusion.
    pub verdict: VerdictClass,
    /// The reason; not empty.
    pub reason: String,
    /// The person.
    pub by: Option<String>,
    /// The day of the entry.
    pub entered: Option<Date>,
    /// Name and version of the program that entered the override.
    pub tool: Option<String>,
    /// Scope.
    pub scope: Scope,
    /// The first day on which it holds, UTC.
    pub from: Option<Date>,
    /// The last day on which it holds, UTC.
    pub until: Option<Date>,
}

/// The recordings that an override is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Scope {
    /// One recording.
    File {
        /// Name of its file, without folder.
        name: String,
        /// SHA-256 of its bytes, hexadecimal.
        sha256: String,
    },
    /// All recordings of the folder.
    All,
}

impl Override {
    /// Scope in words.
    pub fn scope_in_words(&self) -> String {
        let mut words = match &self.scope {
            Scope::File { name, sha256 } => {
                format!("this recording, {name} (SHA-256 {}...)", &sha256[..sha256.len().min(8)])
            }
            Scope::All => "all recordings of the loop in this folder".to_owned(),
        };
        if let Some(from) = self.from {
            words += &format!(", from {from}");
        }
        if let Some(until) = self.until {
            words += &format!(", until {until}");
        }
        words
    }

    /// The override as a diagnosis shows it, kept in the file `kept_in`.
    pub fn shown(&self, kept_in: &str) -> diagnose::Override {
        diagnose::Override {
            verdict: self.verdict,
            reason: self.reason.clone(),
            by: self.by.clone(),
            entered: self.entered.map(|day| day.to_string()),
            scope: self.scope_in_words(),
            kept_in: kept_in.to_owned(),
        }
    }

    /// Whether it is about this loop in the file of that name or, with `in_all`, in all recordings.
    pub fn is_of(&self, loop_name: &str, file_name: &str, in_all: bool) -> bool {
        let scope = match &self.scope {
            Scope::File { name, .. } => !in_all && *name == file_name,
            Scope::All => in_all,
        };
        scope && self.loop_name == loop_name
    }

    /// Whether both overrides concern the same loop and have the same scope.
    pub(super) fn rivals(&self, other: &Self) -> bool {
        let same_scope = match (&self.scope, &other.scope) {
            (Scope::File { name: a, .. }, Scope::File { name: b, .. }) => a == b,
            (Scope::All, Scope::All) => true,
            _ => false,
        };
        self.loop_name == other.loop_name && same_scope
    }

    /// Whether some day belongs to both.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        let ends_before =
            |a: &Self, b: &Self| matches!((a.until, b.from), (Some(a), Some(b)) if a < b);
        !ends_before(self, other) && !ends_before(other, self)
    }

    /// Why the override does not apply to a recording of `span`; `None` if it applies.
    pub(super) fn outside(&self, span: Option<(f64, f64)>) -> Option<&'static str> {
        if self.from.is_none() && self.until.is_none() {
            return None;
        }
        let Some((begin, end)) = span else {
            return Some("it holds for certain days, and this recording has no dates");
        };
        let starts = |date: Date| {
            date.to_zoned(TimeZone::UTC).ok().map(|z| z.timestamp().as_second() as f64)
        };
        let early = self.from.and_then(starts).is_some_and(|from| begin < from);
        let after = |date: Date| date.tomorrow().ok().and_then(starts);
        let late = self.until.and_then(after).is_some_and(|until| end >= until);
        (early || late).then_some("it holds for certain days, and the judged data lie outside them")
    }
}
