//! Entries in the log, by the functions of the command.

use super::LogEntry;
use crate::calls::{Answer, Wrong};
use crate::lab::Lab;
use schemars::JsonSchema;
use serde::Deserialize;
use stiction_diagnose::diagnose::VerdictClass;
use stiction_plant::day;
use stiction_plant::log::{self, Entry, Kind};
use stiction_plant::overrides;
use stiction_plant::plant_file::Plant;

/// Characters of a text, and of a name.
const TEXT: usize = 4000;
const NAME: usize = 200;

/// An entry for a loop.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Note {
    /// The loop.
    #[serde(rename = "loop")]
    name: String,
    /// Whether it is a note, a repair or an order.
    kind: Kind,
    /// The text; may be empty for a repair.
    #[serde(default)]
    text: String,
    /// The author; the user of this system by default.
    #[serde(default)]
    by: Option<String>,
    /// The day of the work; today by default.
    #[serde(default)]
    day: Option<String>,
}

/// A loop that leaves the work list for a while.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Snooze {
    /// The loop.
    #[serde(rename = "loop")]
    name: String,
    /// The day on which it comes back.
    until: String,
    /// Why.
    #[serde(default)]
    text: String,
    /// The author; the user of this system by default.
    #[serde(default)]
    by: Option<String>,
}

/// An override.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Conclusion {
    /// The loop.
    #[serde(rename = "loop")]
    name: String,
    /// The verdict; "cannot tell" removes the override.
    verdict: String,
    /// Why.
    reason: String,
    /// The last day on which it holds.
    #[serde(default)]
    until: Option<String>,
    /// The author; the user of this system by default.
    #[serde(default)]
    by: Option<String>,
}

/// The content of an entry.
struct New {
    name: String,
    kind: Kind,
    day: Option<String>,
    by: Option<String>,
    until: Option<String>,
    verdict: Option<VerdictClass>,
    text: String,
}

fn enter(lab: &Lab, new: New) -> Answer<LogEntry> {
    let folder = lab.plant.folder()?;
    if new.text.chars().count() > TEXT || new.by.iter().any(|by| by.chars().count() > NAME) {
        return Err(Wrong::request(format!("write at most {TEXT} characters, {NAME} in a name")));
    }
    let plant = Plant::read(folder)?;
    let days = |text: Option<String>| text.map(|day| day::parse(&day)).transpose();
    let (day, until) =
        (days(new.day).map_err(Wrong::request)?, days(new.until).map_err(Wrong::request)?);
    let today = || day::parse(&overrides::today().to_string()).map_err(Wrong::own);
    // Of all judged loops, not of one week, so that old loops can have entries too.
    let week = lab.plant.week(None).ok();
    let judged = week.iter().flat_map(|week| week.known.names());
    let name = match log::loop_named(&plant, judged, &new.name) {
        Ok(name) => name.to_owned(),
        Err(_) => log::known_loop(folder, &plant, &new.name)?,
    };
    let by = new.by.map(|by| by.trim().to_owned()).filter(|by| !by.is_empty());
    let entry = Entry {
        kind: new.kind,
        name,
        day: day.map_or_else(today, Ok)?,
        by: by.or_else(|| whoami::username().ok()),
        until,
        verdict: new.verdict,
        text: new.text.trim().to_owned(),
    };
    log::enter(folder, &entry)?;
    Ok(LogEntry::of(&entry))
}

/// Enters a note, a repair or an order.
///
/// # Errors
/// If there is no such loop, the entry is not possible, or the log cannot be written.
pub fn enter_note(lab: &Lab, asked: Note) -> Answer<LogEntry> {
    let Note { name, kind, text, by, day } = asked;
    if !matches!(kind, Kind::Note | Kind::Repair | Kind::Order) {
        return Err(Wrong::request("the kind of a note must be note, repair or order"));
    }
    enter(lab, New { name, kind, day, by, until: None, verdict: None, text })
}

/// Removes a loop from the work list until a day.
///
/// # Errors
/// As [`enter_note`].
pub fn enter_snooze(lab: &Lab, asked: Snooze) -> Answer<LogEntry> {
    let Snooze { name, until, text, by } = asked;
    let (kind, until) = (Kind::Snooze, Some(until));
    enter(lab, New { name, kind, day: None, by, until, verdict: None, text })
}

/// Enters an override.
///
/// # Errors
/// As [`enter_note`].
pub fn enter_override(lab: &Lab, asked: Conclusion) -> Answer<LogEntry> {
    let Conclusion { name, verdict, reason: text, until, by } = asked;
    let verdict = Some(VerdictClass::by_name(&verdict)?);
    enter(lab, New { name, kind: Kind::Override, day: None, by, until, verdict, text })
}
