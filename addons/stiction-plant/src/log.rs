//! `log.toml`: the actions and conclusions of people, entered by hand or by command.
//!
//! ```toml
//! [[entry]]
//! kind = "override"              # repair, order, override, note or snooze
//! loop = "FIC101"
//! day = 2026-03-02               # day of the action, or of the entry
//! by = "J. Miller"
//! until = 2026-06-30             # the last day on which it holds
//! verdict = "does not stick"     # of an override
//! text = "new packing, stroked"
//! ```
//!
//! A file with a mistake is refused as a whole, with the line, because the program must not guess. A command adds its entry at the
//! end, and leaves the rest unchanged, including comments and order.

use crate::day;
use crate::error::{Error, Result, file};
use crate::plant_file::{self, Plant};
use crate::scan::inputs::Inputs;
use crate::store::{Store, write_whole};
use serde::{Deserialize, Deserializer, Serialize};
use std::path::Path;
use stiction_diagnose::diagnose::VerdictClass;
use stiction_model::named;
use toml::Spanned;

/// What the file is called.
pub const NAME: &str = "log.toml";

const HEAD: &str =
    "# Actions and conclusions of people, kept by `stiction plant`. You may edit this file.\n";

named! {
    /// What an entry is about.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
    #[serde(rename_all = "lowercase")]
    pub enum Kind {
        /// The valve was repaired on that day. A week is judged by the windows after it.
        Repair = "repair",
        /// A work order was placed.
        Order = "order",
        /// The conclusion of a person about the valve, shown beside the computed verdict.
        Override = "override",
        /// A remark.
        Note = "note",
        /// The loop is not in the work list before the day `until`.
        Snooze = "snooze",
    }
}

/// An entry of the log. Days count from 1970-01-01 on the plant's calendar, and are dates in the file.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Kind.
    pub kind: Kind,
    /// Tag of the loop.
    #[serde(rename = "loop")]
    pub name: String,
    /// Day of the action, or of the entry.
    #[serde(deserialize_with = "a_day", serialize_with = "as_date")]
    #[schemars(with = "String")]
    pub day: i64,
    /// Author.
    pub by: Option<String>,
    /// The last day on which it holds.
    #[serde(default, deserialize_with = "a_day_if_any", serialize_with = "as_date_if_any")]
    #[schemars(with = "Option<String>")]
    pub until: Option<i64>,
    /// The verdict of an override.
    #[serde(default, deserialize_with = "a_verdict")]
    pub verdict: Option<VerdictClass>,
    /// The remark.
    #[serde(default)]
    pub text: String,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "must be a day such as 2026-03-01")]
enum Written {
    Date(toml::value::Datetime),
    Text(String),
}

fn a_day<'a, D: Deserializer<'a>>(from: D) -> std::result::Result<i64, D::Error> {
    let text = match Written::deserialize(from)? {
        Written::Date(date) => date.to_string(),
        Written::Text(text) => text,
    };
    day::parse(&text).map_err(serde::de::Error::custom)
}

fn a_day_if_any<'a, D: Deserializer<'a>>(from: D) -> std::result::Result<Option<i64>, D::Error> {
    a_day(from).map(Some)
}

fn a_verdict<'a, D: Deserializer<'a>>(
    from: D,
) -> std::result::Result<Option<VerdictClass>, D::Error> {
    let text = String::deserialize(from)?;
    VerdictClass::by_name(&text).map(Some).map_err(serde::de::Error::custom)
}

fn as_date<S: serde::Serializer>(day: &i64, to: S) -> std::result::Result<S::Ok, S::Error> {
    to.serialize_str(&day::date(*day))
}

fn as_date_if_any<S: serde::Serializer>(
    day: &Option<i64>,
    to: S,
) -> std::result::Result<S::Ok, S::Error> {
    day.map(day::date).serialize(to)
}

impl Entry {
    /// Fault, as key and remedy.
    fn mistake(&self) -> Option<(&'static str, &'static str)> {
        let needs_text = matches!(self.kind, Kind::Override | Kind::Note | Kind::Order);
        match self {
            Self { name, .. } if name.trim().is_empty() => Some(("loop", "is empty")),
            Self { kind: Kind::Override, verdict: None, .. } => {
                Some(("verdict", "is missing; give the verdict, such as \"does not stick\""))
            }
            Self { kind, verdict: Some(_), .. } if *kind != Kind::Override => {
                Some(("verdict", "belongs to an override only"))
            }
            Self { kind: Kind::Snooze, until: None, .. } => {
                Some(("until", "is missing; give the day on which to look again"))
            }
            Self { day, until: Some(until), .. } if until < day => Some(("until", "is before day")),
            Self { text, .. } if needs_text && text.trim().is_empty() => {
                Some(("text", "is missing; give a reason"))
            }
            _ => None,
        }
    }

    /// As a table of the file.
    fn in_toml(&self) -> String {
        let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
        let mut out = format!(
            "[[entry]]\nkind = \"{}\"\nloop = {}\nday = {}\n",
            self.kind.name(),
            quoted(&self.name),
            day::date(self.day)
        );
        let mut set = |key: &str, value: Option<String>| {
            if let Some(value) = value {
                out += &format!("{key} = {value}\n");
            }
        };
        set("by", self.by.as_deref().map(quoted));
        set("until", self.until.map(day::date));
        set("verdict", self.verdict.map(|verdict| quoted(verdict.name())));
        set("text", (!self.text.is_empty()).then(|| quoted(&self.text)));
        out
    }

    /// The entry in words, without its loop.
    pub fn words(&self) -> String {
        let mut words = match (self.kind, self.verdict) {
            (Kind::Repair, _) => "repaired".to_owned(),
            (Kind::Order, _) => "ordered".to_owned(),
            (Kind::Override, Some(verdict)) => verdict.name().to_owned(),
            (Kind::Override | Kind::Note, _) => String::new(),
            (Kind::Snooze, _) => "snoozed".to_owned(),
        };
        if !self.text.is_empty() {
            words += if words.is_empty() { "" } else { ": " };
            words += &self.text;
        }
        words += &match &self.by {
            Some(by) => format!(" ({by}, {})", day::date(self.day)),
            None => format!(" ({})", day::date(self.day)),
        };
        match self.until {
            Some(until) => format!("{words}, until {}", day::date(until)),
            None => words,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LogFile {
    #[serde(default)]
    entry: Vec<Spanned<Entry>>,
}

/// The entries of a log, in the order of the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Log {
    /// All of them.
    pub entries: Vec<Entry>,
}

impl Log {
    /// Reads `log.toml` in `folder`; empty if the file does not exist.
    ///
    /// # Errors
    /// If the log cannot be read, or as for [`Log::parse`].
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(NAME);
        Self::parse(&text_of(&path)?, &path.display().to_string())
    }

    /// Reads a log from its `text`. Errors name it `origin`.
    ///
    /// # Errors
    /// If the log is not well-formed, or has unknown keys or invalid values. The message names the line.
    pub fn parse(text: &str, origin: &str) -> Result<Self> {
        let line = |at: usize| text.as_bytes().iter().take(at).filter(|b| **b == b'\n').count() + 1;
        let refused = |problems| Error::PlantFile { origin: origin.to_owned(), problems };
        let log: LogFile = toml::from_str(text).map_err(|e| {
            let at = e.span().map_or(0, |span| span.start);
            refused(vec![format!("line {}: {}", line(at), e.message().trim())])
        })?;
        let mut problems = vec![];
        for entry in &log.entry {
            if let Some((key, what)) = entry.get_ref().mistake() {
                problems.push(format!("line {}, entry.{key}: {what}", line(entry.span().start)));
            }
        }
        match problems.is_empty() {
            true => Ok(Self { entries: log.entry.into_iter().map(Spanned::into_inner).collect() }),
            false => Err(refused(problems)),
        }
    }

    /// The entries of a loop, in the order of their days; names are compared without case.
    pub fn of(&self, name: &str) -> Vec<&Entry> {
        let same = |entry: &&Entry| entry.name.to_lowercase() == name.to_lowercase();
        let mut own: Vec<&Entry> = self.entries.iter().filter(same).collect();
        own.sort_by_key(|entry| entry.day);
        own
    }
}

/// The loop of this name, in any case, from the plant's file or the `judged` loops.
///
/// # Errors
/// If no loop has this name.
pub fn loop_named<'a>(
    plant: &'a Plant,
    judged: impl IntoIterator<Item = &'a str>,
    tag: &str,
) -> Result<&'a str> {
    let known = judged.into_iter().chain(plant.file.loops.keys().map(String::as_str));
    let same = |name: &&str| name.to_lowercase() == tag.to_lowercase();
    known.into_iter().find(same).ok_or_else(|| {
        Error::Option(format!(
            "there is no loop \"{tag}\" in {} or among the judged loops; check the tag in the report",
            plant_file::NAME
        ))
    })
}

/// The loop of this name, from the plant's file, its examined data or the judged loops. Unreadable rows are no reason
/// to refuse an entry.
///
/// # Errors
/// If no loop has this name.
pub fn known_loop(folder: &Path, plant: &Plant, tag: &str) -> Result<String> {
    let store = Store::of(folder);
    let inputs = Inputs::known(&store, plant);
    let looked_at = inputs.files.values().flat_map(|input| input.loops.keys());
    if let Ok(name) = loop_named(plant, looked_at.map(String::as_str), tag) {
        return Ok(name.to_owned());
    }
    let rows = store.rows().unwrap_or_default();
    loop_named(plant, rows.iter().map(|row| &*row.name), tag).map(str::to_owned)
}

/// Adds an entry at the end of `log.toml` in `folder`, even if others do so at the same time. If the last entry of the
/// loop is equal, as after a command that was repeated because its output failed, nothing is added.
///
/// # Errors
/// If the entry is invalid, or the file is damaged or cannot be read or written.
pub fn enter(folder: &Path, entry: &Entry) -> Result<()> {
    if let Some((key, what)) = entry.mistake() {
        return Err(Error::Option(format!("{key} {what}")));
    }
    let _lock = Store::of(folder).lock_log()?;
    let path = folder.join(NAME);
    let mut text = text_of(&path)?;
    let log = Log::parse(&text, &path.display().to_string())?;
    if log.entries.iter().rfind(|known| known.name == entry.name) == Some(entry) {
        return Ok(());
    }
    if text.is_empty() {
        text = HEAD.to_owned();
    }
    // A file that was cut may end within a line.
    text += if text.ends_with('\n') { "\n" } else { "\n\n" };
    text += &entry.in_toml();
    write_whole(&path, text.as_bytes())
}

fn text_of(path: &Path) -> Result<String> {
    match std::fs::read_to_string(path) {
        Ok(text) => Ok(text),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(String::new()),
        Err(e) => Err(file(path)(e)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: &str = r#"# By hand.
[[entry]]
kind = "override"
loop = "FIC101"
day = 2026-03-02
by = "J. Miller"
until = 2026-06-30
verdict = "does not stick"
text = "new packing"

[[entry]]   # seen at the stem
kind = "repair"
loop = "fic101"
day = "2026-03-01"
"#;

    #[test]
    fn entries_are_read_by_loop_and_day() {
        let log = Log::parse(ALL, "log.toml").unwrap();
        let own = log.of("FIC101");
        assert_eq!((own[0].kind, own[1].kind), (Kind::Repair, Kind::Override));
        assert_eq!(
            own[1].words(),
            "does not stick: new packing (J. Miller, 2026-03-02), until 2026-06-30"
        );
        assert!(Log::parse("", "log.toml").unwrap().entries.is_empty());
    }

    #[test]
    fn mistakes_are_named_with_their_lines() {
        for (from, to, expected) in [
            ("by = ", "bye = ", "log.toml, line 6: unknown field `bye`"),
            ("\"override\"", "\"overide\"", "log.toml, line 3: unknown variant `overide`"),
            ("\"does not stick\"", "\"wobbles\"", "log.toml, line 8: "),
            ("2026-06-30", "2026-02-30", "log.toml, line 7: "),
            ("2026-06-30", "2026-01-30", "log.toml, line 2, entry.until: is before day"),
            ("verdict = \"does not stick\"\n", "", "log.toml, line 2, entry.verdict: is missing"),
            (
                "kind = \"repair\"",
                "kind = \"snooze\"",
                "log.toml, line 11, entry.until: is missing",
            ),
            ("[[entry]]   #", "[[entri]] #", "log.toml, line 11: unknown field `entri`"),
        ] {
            let message =
                Log::parse(&ALL.replacen(from, to, 1), "log.toml").unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}\nnot {expected}");
        }
    }

    #[test]
    fn what_was_written_by_hand_survives_an_entry() {
        let folder = std::env::temp_dir().join(format!("stiction-log-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let entry = Entry {
            kind: Kind::Snooze,
            name: "FIC\"1\n".to_owned(),
            day: 20_514,
            by: None,
            until: Some(20_520),
            verdict: None,
            text: "ordered, WO 4711".to_owned(),
        };
        std::fs::write(folder.join(NAME), ALL.trim_end()).unwrap();
        enter(&folder, &entry).unwrap();
        let text = std::fs::read_to_string(folder.join(NAME)).unwrap();
        assert!(
            text.starts_with(ALL)
                && text.ends_with("until = 2026-03-08\ntext = \"ordered, WO 4711\"\n"),
            "{text}"
        );
        assert_eq!(Log::read(&folder).unwrap().entries[2], entry);
        enter(&folder, &entry).unwrap();
        assert_eq!(Log::read(&folder).unwrap().entries.len(), 3, "entered again");
        assert!(enter(&folder, &Entry { until: None, ..entry.clone() }).is_err());
        // Nothing is added to an invalid file.
        std::fs::write(folder.join(NAME), "[[entry]]\nkind = 1\n").unwrap();
        assert!(enter(&folder, &entry).unwrap_err().to_string().contains("line 2"));
        assert_eq!(std::fs::read_to_string(folder.join(NAME)).unwrap(), "[[entry]]\nkind = 1\n");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
