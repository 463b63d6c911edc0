//! Overrides: what people concluded of a valve against, or beside, the computed verdict.
//!
//! They stand in `stiction-overrides.toml` beside the recordings they are about:
//!
//! ```toml
//! [[override]]
//! loop = "FIC101"
//! verdict = "does not stick"
//! reason = "new packing, stroked by maintenance"
//! by = "J. Miller"
//! entered = 2026-03-02
//! file = "FIC101.csv"
//! sha256 = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"
//!
//! [[override]]
//! loop = "FIC102"
//! verdict = "does not stick"
//! reason = "stroked on the bench"
//! all_recordings = true
//! from = 2026-03-01
//! until = 2026-06-30
//! ```
//!
//! An override holds for the loop of exactly that tag, and
//!
//! * either for one recording: the file of that name in this folder whose bytes have that SHA-256. A file
//!   that was written anew is another recording;
//! * or, with `all_recordings`, for every file of this folder; such an override must end, with `until`.
//!
//! With `from` or `until` it holds only for what was recorded on those days, both included, in UTC: the
//! judged segment must lie between them as a whole, so a recording without dates is not covered. An
//! override of one recording goes before one of all. Two of one loop and one scope whose days overlap
//! contradict each other and are an error.

use crate::error::{Error, Result};
use crate::fields::{Fields, Wrong, line_of};
use jiff::tz::TimeZone;
use std::path::{Path, PathBuf};
use stiction_diagnose::diagnose::VerdictClass;
use toml::de::DeTable;

pub use jiff::civil::Date;

/// Name of the file that holds the overrides of a folder.
pub const FILE_NAME: &str = "stiction-overrides.toml";

const TOP: &[&str] = &["override"];
const KEYS: &[&str] = &[
    "loop",
    "verdict",
    "reason",
    "by",
    "entered",
    "file",
    "sha256",
    "all_recordings",
    "from",
    "until",
];

/// What a person concluded of a valve.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// Tag of the loop, exactly.
    pub loop_name: String,
    /// The conclusion.
    pub verdict: VerdictClass,
    /// Why; not empty.
    pub reason: String,
    /// Who says so.
    pub by: Option<String>,
    /// When it was entered.
    pub entered: Option<Date>,
    /// What it is about.
    pub scope: Scope,
    /// The first day on which it holds, UTC.
    pub from: Option<Date>,
    /// The last day on which it holds, UTC.
    pub until: Option<Date>,
}

/// Which recordings an override is about.
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

/// The overrides of a folder.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Overrides {
    /// The file, as it is named in messages.
    pub origin: String,
    /// All of them, in the order of the file.
    pub all: Vec<Override>,
}

/// A recording, as far as overrides are concerned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recorded<'a> {
    /// Tag of the loop.
    pub loop_name: &'a str,
    /// Its file.
    pub file: &'a Path,
    /// SHA-256 of the file's bytes, hexadecimal.
    pub sha256: &'a str,
    /// Beginning and end of what was judged, in seconds since 1970-01-01 UTC, if they are known.
    pub span: Option<(f64, f64)>,
}

impl Override {
    /// Its scope in words.
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

    /// Whether both are about one loop and one scope.
    fn rivals(&self, other: &Self) -> bool {
        let same_scope = match (&self.scope, &other.scope) {
            (Scope::File { name: a, .. }, Scope::File { name: b, .. }) => a == b,
            (Scope::All, Scope::All) => true,
            _ => false,
        };
        self.loop_name == other.loop_name && same_scope
    }

    /// Whether a day is within the days of both.
    fn overlaps(&self, other: &Self) -> bool {
        let ends_before =
            |a: &Self, b: &Self| matches!((a.until, b.from), (Some(a), Some(b)) if a < b);
        !ends_before(self, other) && !ends_before(other, self)
    }

    /// Why it does not hold for what was recorded in `span`; `None` if it does.
    fn outside(&self, span: Option<(f64, f64)>) -> Option<&'static str> {
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
        (early || late)
            .then_some("it holds for certain days, and what was judged lies outside them")
    }
}

impl Overrides {
    /// The file of overrides in the folder of `file`, or in that folder if it is one.
    pub fn path_beside(file: &Path) -> PathBuf {
        if file.is_dir() { file.join(FILE_NAME) } else { file.with_file_name(FILE_NAME) }
    }

    /// Reads the overrides at `path`; none if there is no such file.
    ///
    /// # Errors
    /// If it cannot be read or is not well formed.
    pub fn read(path: &Path) -> Result<Self> {
        let origin = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&text, &origin),
            Err(source) if source.kind() == std::io::ErrorKind::NotFound => {
                Ok(Self { origin, all: vec![] })
            }
            Err(source) => Err(Error::File { path: origin, source }),
        }
    }

    /// Reads overrides from their `text`; `origin` names it in errors.
    ///
    /// # Errors
    /// If it is not well formed; the error tells the line and what would be right.
    pub fn parse(text: &str, origin: &str) -> Result<Self> {
        let at = |wrong: Wrong| Error::Overrides {
            origin: origin.to_owned(),
            line: line_of(text.as_bytes(), wrong.span.start),
            message: wrong.message,
        };
        let document = DeTable::parse(text).map_err(|e| {
            at(Wrong { span: e.span().unwrap_or_default(), message: e.message().to_owned() })
        })?;
        let fields = Fields::document(&document, TOP).map_err(at)?;
        let mut all: Vec<Override> = vec![];
        for table in fields.tables("override", KEYS).map_err(at)? {
            let one = entry(&table).map_err(at)?;
            if all.iter().any(|other| one.rivals(other) && one.overlaps(other)) {
                let message = format!(
                    "a second override of {} for {}; remove one, or give them days that do not overlap",
                    one.loop_name,
                    one.scope_in_words()
                );
                return Err(at(table.wrong_table(message)));
            }
            table.finish().map_err(at)?;
            all.push(one);
        }
        fields.finish().map_err(at)?;
        Ok(Self { origin: origin.to_owned(), all })
    }

    /// The override that holds for a recording, and why others of its tag do not.
    pub fn of(&self, recorded: &Recorded<'_>) -> (Option<&Override>, Vec<String>) {
        let file_name = recorded.file.file_name().unwrap_or_default().to_string_lossy();
        let (mut found, mut notes): (Option<&Override>, _) = (None, vec![]);
        for each in self.all.iter().filter(|each| each.loop_name == recorded.loop_name) {
            let why_not = match &each.scope {
                Scope::File { name, .. } if *name != file_name => continue,
                Scope::File { sha256, .. } if !sha256.eq_ignore_ascii_case(recorded.sha256) => {
                    Some(
                        "the file has changed since it was entered; enter it again if it still holds",
                    )
                }
                _ => each.outside(recorded.span),
            };
            match why_not {
                Some(why) => notes.push(format!(
                    "an override in {} says that it {}, but does not apply: {why}",
                    self.origin,
                    each.verdict.name()
                )),
                None if each.scope == Scope::All && found.is_some() => {}
                None => found = Some(each),
            }
        }
        (found, notes)
    }
}

fn entry(table: &Fields<'_, '_>) -> std::result::Result<Override, Wrong> {
    let text = |key| -> std::result::Result<Option<String>, Wrong> {
        match table.text(key)?.map(str::trim) {
            Some("") => Err(table.wrong(key, "is empty")),
            given => Ok(given.map(str::to_owned)),
        }
    };
    let needed = |key, what: &str| {
        text(key)?.ok_or_else(|| table.wrong(key, format!("is missing; give {what}")))
    };
    let loop_name = needed("loop", "the tag of the loop")?;
    let verdict = needed("verdict", "what the valve does, such as \"does not stick\"")?;
    let verdict = VerdictClass::by_name(&verdict).map_err(|e| table.wrong("verdict", e))?;
    let reason = needed("reason", "why, in words")?;
    let date = |key| -> std::result::Result<Option<Date>, Wrong> {
        let wrong = || table.wrong(key, "must be a date such as 2026-03-01");
        table.text_or_date(key)?.map(|text| text.parse().map_err(|_| wrong())).transpose()
    };
    let (from, until) = (date("from")?, date("until")?);
    if from.zip(until).is_some_and(|(from, until)| from > until) {
        return Err(table.wrong("until", "is before from"));
    }
    let (file, sha256) = (text("file")?, text("sha256")?);
    let scope = match (table.flag("all_recordings")?, file, sha256) {
        (true, None, None) if until.is_none() => {
            return Err(table.wrong(
                "until",
                "is missing; an override of all recordings must end, \
                                             as in until = 2026-12-31",
            ));
        }
        (true, None, None) => Scope::All,
        (true, _, _) => {
            return Err(table.wrong("all_recordings", "and file exclude each other; remove one"));
        }
        (false, Some(name), Some(sha256)) => {
            if sha256.len() != 64 || !sha256.bytes().all(|b| b.is_ascii_hexdigit()) {
                return Err(table.wrong(
                    "sha256",
                    "must be 64 hexadecimal digits, as the JSON of a diagnosis tells",
                ));
            }
            Scope::File { name, sha256 }
        }
        (false, None, _) => {
            return Err(
                table.wrong("file", "is missing; name the file, or say all_recordings = true")
            );
        }
        (false, Some(_), None) => {
            return Err(table.wrong(
                "sha256",
                "is missing; give that of the file's bytes, which \
                                              the JSON of a diagnosis tells",
            ));
        }
    };
    let (by, entered) = (text("by")?, date("entered")?);
    Ok(Override { loop_name, verdict, reason, by, entered, scope, from, until })
}

/// The day of today, UTC.
pub fn today() -> Date {
    jiff::Timestamp::now().to_zoned(TimeZone::UTC).date()
}

/// The `text` of a file of overrides with one more: in place of those of the same loop and scope whose
/// days overlap with its own. All else, such as comments, stays as it is.
///
/// # Errors
/// If the text, or the result, is not well formed.
pub fn with(text: &str, origin: &str, one: &Override) -> Result<String> {
    let head = if text.trim().is_empty() { HEAD } else { "" };
    let (mut document, _, comments) =
        edited(text, origin, |other| one.rivals(other) && one.overlaps(other))?;
    let mut table = toml_edit::Table::new();
    if !comments.is_empty() {
        table.decor_mut().set_prefix(comments);
    }
    let mut set =
        |key: &str, value: toml_edit::Value| table.insert(key, toml_edit::Item::Value(value));
    set("loop", one.loop_name.as_str().into());
    set("verdict", one.verdict.name().into());
    set("reason", one.reason.as_str().into());
    if let Some(by) = &one.by {
        set("by", by.as_str().into());
    }
    match &one.scope {
        Scope::File { name, sha256 } => {
            set("file", name.as_str().into());
            set("sha256", sha256.as_str().into());
        }
        Scope::All => {
            set("all_recordings", true.into());
        }
    }
    for (key, date) in [("from", one.from), ("until", one.until), ("entered", one.entered)] {
        // A date as jiff writes it is one of TOML.
        if let Some(Ok(date)) = date.map(|date| date.to_string().parse::<toml_edit::Datetime>()) {
            set(key, date.into());
        }
    }
    let item = document
        .entry("override")
        .or_insert_with(|| toml_edit::Item::ArrayOfTables(toml_edit::ArrayOfTables::new()));
    match item.as_array_of_tables_mut() {
        Some(tables) => tables.push(table),
        None => {
            let message = "override: write each as a table of its own, [[override]]".to_owned();
            return Err(Error::Overrides { origin: origin.to_owned(), line: 1, message });
        }
    }
    let made = format!("{head}{document}");
    Overrides::parse(&made, origin)?;
    Ok(made)
}

/// The `text` of a file of overrides without those that are `unwanted`, and how many those were.
///
/// # Errors
/// If the text is not well formed.
pub fn without(
    text: &str,
    origin: &str,
    unwanted: impl Fn(&Override) -> bool,
) -> Result<(String, usize)> {
    let (mut document, removed, comments) = edited(text, origin, unwanted)?;
    let end = document.trailing().as_str().unwrap_or_default().to_owned();
    document.set_trailing(format!("{comments}{end}"));
    Ok((document.to_string(), removed))
}

const HEAD: &str = "# What people concluded of valves, kept by `stiction override`.\n\
                    # The computed verdict is always shown beside it.\n\n";

/// The document without those that are `unwanted`, how many those were, and what stood above them.
fn edited(
    text: &str,
    origin: &str,
    unwanted: impl Fn(&Override) -> bool,
) -> Result<(toml_edit::DocumentMut, usize, String)> {
    let known = Overrides::parse(text, origin)?;
    let mut document: toml_edit::DocumentMut =
        text.parse().map_err(|e: toml_edit::TomlError| Error::Overrides {
            origin: origin.to_owned(),
            line: line_of(text.as_bytes(), e.span().unwrap_or_default().start),
            message: e.message().to_owned(),
        })?;
    let (mut removed, mut comments) = (0, String::new());
    if let Some(tables) =
        document.get_mut("override").and_then(toml_edit::Item::as_array_of_tables_mut)
    {
        for place in (0..known.all.len()).rev().filter(|place| unwanted(&known.all[*place])) {
            let above = tables.get(place).and_then(|table| table.decor().prefix()?.as_str());
            comments.insert_str(0, above.filter(|text| text.contains('#')).unwrap_or_default());
            tables.remove(place);
            removed += 1;
        }
    }
    Ok((document, removed, comments))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHA: &str = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08";

    fn one() -> Override {
        Override {
            loop_name: "FIC101".to_owned(),
            verdict: VerdictClass::DoesNotStick,
            reason: "new \"packing\"".to_owned(),
            by: Some("J. Miller".to_owned()),
            entered: Some(Date::constant(2026, 3, 2)),
            scope: Scope::File { name: "a.csv".to_owned(), sha256: SHA.to_owned() },
            from: None,
            until: None,
        }
    }

    fn for_all(from: Option<Date>, until: Date) -> Override {
        Override { scope: Scope::All, from, until: Some(until), ..one() }
    }

    fn recorded<'a>(tag: &'a str, file: &'a str, sha256: &'a str) -> Recorded<'a> {
        Recorded { loop_name: tag, file: Path::new(file), sha256, span: None }
    }

    #[test]
    fn what_is_written_is_read() {
        let text = with("", "o.toml", &one()).unwrap();
        assert!(
            text.starts_with("# What people") && text.contains("entered = 2026-03-02"),
            "{text}"
        );
        assert_eq!(Overrides::parse(&text, "o.toml").unwrap().all, [one()]);
        let both = with(&text, "o.toml", &for_all(None, Date::constant(2026, 6, 1))).unwrap();
        assert_eq!(Overrides::parse(&both, "o.toml").unwrap().all.len(), 2);
    }

    #[test]
    fn comments_stay_and_the_same_scope_is_replaced() {
        let text = format!("# of ours\n{}", with("", "o.toml", &one()).unwrap());
        let newer = Override { reason: "stroked".to_owned(), ..one() };
        let text = with(&text, "o.toml", &newer).unwrap();
        assert!(text.starts_with("# of ours\n"), "{text}");
        assert_eq!(Overrides::parse(&text, "o.toml").unwrap().all, [newer]);
        let (rest, removed) = without(&text, "o.toml", |each| each.loop_name == "FIC101").unwrap();
        assert_eq!((removed, Overrides::parse(&rest, "o.toml").unwrap().all.len()), (1, 0));
        assert!(rest.contains("# of ours"));
        assert_eq!(without(&text, "o.toml", |_| false).unwrap(), (text, 0));
    }

    #[test]
    fn nothing_is_applied_to_another_loop_or_recording() {
        let overrides = Overrides { origin: "o.toml".to_owned(), all: vec![one()] };
        let found = |tag, file, sha| overrides.of(&recorded(tag, file, sha));
        assert_eq!(found("FIC101", "folder/a.csv", SHA), (Some(&one()), vec![]));
        assert_eq!(found("FIC101", "b.csv", SHA), (None, vec![]));
        for tag in ["fic101", "FIC1011", "FIC10"] {
            assert_eq!(found(tag, "a.csv", SHA), (None, vec![]), "{tag}");
        }
        let (none, notes) = found("FIC101", "a.csv", &"0".repeat(64));
        assert!(none.is_none() && notes[0].contains("the file has changed"), "{notes:?}");
    }

    #[test]
    fn days_bound_what_is_covered() {
        let day = Date::constant(2026, 3, 1);
        let begin = day.to_zoned(TimeZone::UTC).unwrap().timestamp().as_second() as f64;
        let overrides =
            Overrides { origin: "o.toml".to_owned(), all: vec![for_all(Some(day), day)] };
        let covers = |span| overrides.of(&Recorded { span, ..recorded("FIC101", "x.csv", SHA) });
        assert!(covers(Some((begin, begin + 86_399.0))).0.is_some());
        for span in [Some((begin - 1.0, begin + 9.0)), Some((begin, begin + 86_400.0)), None] {
            let (none, notes) = covers(span);
            assert!(none.is_none() && notes.len() == 1, "{span:?}");
        }
        // One recording goes before all of them, in either order.
        let sure = Override { verdict: VerdictClass::Sticks, ..one() };
        for all in [vec![for_all(None, day), sure.clone()], vec![sure.clone(), for_all(None, day)]]
        {
            let overrides = Overrides { origin: String::new(), all };
            let span = Some((begin, begin));
            let found = overrides.of(&Recorded { span, ..recorded("FIC101", "a.csv", SHA) });
            assert_eq!(found.0, Some(&sure));
        }
    }

    #[test]
    fn mistakes_name_the_line_and_the_remedy() {
        let file = format!("file = \"a.csv\"\nsha256 = \"{SHA}\"\n");
        let head = "[[override]]\nloop = \"A\"\nverdict = \"sticks\"\nreason = \"x\"\n";
        let twice = format!("{head}{file}{head}{file}");
        for (text, expected) in [
            ("[[override]]\n", "line 1: override.loop: is missing; give the tag"),
            ("[[override]]\nloop = \"\"\n", "line 2: override.loop: is empty"),
            (
                "[[override]]\nloop = \"A\"\nverdict = \"fine\"\n",
                "line 3: override.verdict: there is no verdict named \"fine\"; known are sticks, does not stick",
            ),
            ("[[override]]\nloop = \"A\"\nverdict = \"sticks\"\n", "override.reason: is missing"),
            (head, "override.file: is missing; name the file, or say all_recordings = true"),
            (&format!("{head}file = \"a.csv\"\n"), "override.sha256: is missing"),
            (
                &format!("{head}file = \"a.csv\"\nsha256 = \"12\"\n"),
                "line 6: override.sha256: must be 64",
            ),
            (
                &format!("{head}all_recordings = true\n"),
                "override.until: is missing; an override of all",
            ),
            (
                &format!("{head}all_recordings = 1\n"),
                "line 5: override.all_recordings: must be true or false",
            ),
            (&format!("{head}all_recordings = true\n{file}"), "exclude each other"),
            (
                &format!("{head}{file}until = \"soon\"\n"),
                "line 7: override.until: must be a date such as",
            ),
            (&format!("{head}{file}until = 3\n"), "line 7: override.until: must be a date such as"),
            (
                &format!("{head}{file}from = 2026-02-02\nuntil = 2026-02-01\n"),
                "line 8: override.until: is before from",
            ),
            (&format!("{head}{file}tag = \"B\"\n"), "line 7: unknown key \"override.tag\""),
            (&twice, "line 7: [override]: a second override of A for this recording, a.csv"),
            ("override = 3\n", "line 1"),
            ("[[override]\n", "line 1"),
        ] {
            let message = Overrides::parse(text, "o.toml").unwrap_err().to_string();
            assert!(message.starts_with("o.toml, line "), "{message}");
            assert!(message.contains(expected), "{expected}: {message}");
        }
    }
}
