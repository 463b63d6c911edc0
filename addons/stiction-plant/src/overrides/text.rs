//! Splits the text of overrides into pieces, so that a damaged override does not affect the others.

use super::entry::{Override, Scope};
use jiff::civil::Date;
use std::ops::Range;
use stiction_diagnose::diagnose::VerdictClass;
use stiction_io::fields::{Fields, Known, Wrong, line_of, quoted};
use toml::de::DeTable;

const TOP: Known = "override";
const KEYS: Known = "loop verdict reason by entered tool file sha256 all_recordings from until";

/// An entry that does not hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damaged {
    /// Line, from 1.
    pub line: usize,
    /// Tag of its loop, if that is readable.
    pub loop_name: Option<String>,
    /// The fault and the remedy.
    pub message: String,
}

/// A piece of a file of overrides: an entry, or the text above the first one.
pub struct Piece {
    pub range: Range<usize>,
    /// The overrides in the piece with their lines.
    pub found: std::result::Result<Vec<(usize, Override)>, Damaged>,
}

/// The pieces of a file, which together are the whole file. If the file is not valid TOML, an entry begins with each
/// line that begins with `[[`.
pub fn pieces(bytes: &[u8]) -> Vec<Piece> {
    let known = std::str::from_utf8(bytes).ok().and_then(|text| {
        let document = DeTable::parse(text).ok()?;
        // Misspelt names do not belong to the entry above them.
        let lists = document.get_ref().values().filter_map(|value| value.get_ref().as_array());
        let mut starts: Vec<usize> =
            lists.flat_map(|list| list.iter().map(|each| each.span().start)).collect();
        starts.retain(|at| text[*at..].starts_with("[["));
        starts.sort_unstable();
        Some(starts)
    });
    let mut starts = known.unwrap_or_else(|| {
        let (mut at, mut starts) = (0, vec![]);
        for line in bytes.split_inclusive(|b| *b == b'\n') {
            if line.trim_ascii_start().starts_with(b"[[") {
                starts.push(at + line.len() - line.trim_ascii_start().len());
            }
            at += line.len();
        }
        starts
    });
    starts.insert(0, 0);
    starts.push(bytes.len());
    starts.dedup();
    let ranges = starts.windows(2).map(|pair| pair[0]..pair[1]);
    ranges.map(|range| Piece { found: understood(bytes, range.clone()), range }).collect()
}

/// The overrides in a piece of a file.
fn understood(
    bytes: &[u8],
    range: Range<usize>,
) -> std::result::Result<Vec<(usize, Override)>, Damaged> {
    let line = |at: usize| line_of(bytes, range.start + at);
    let text = std::str::from_utf8(&bytes[range.clone()]).map_err(|e| Damaged {
        line: line(e.valid_up_to()),
        loop_name: None,
        message: "is not UTF-8 text; save the file in UTF-8".to_owned(),
    })?;
    let found = entries(text).map_err(|wrong| Damaged {
        line: line(wrong.span.start),
        loop_name: tag(text),
        message: wrong.message,
    })?;
    Ok(found.into_iter().map(|(at, one)| (line(at), one)).collect())
}

/// The overrides in a text with their places.
fn entries(text: &str) -> std::result::Result<Vec<(usize, Override)>, Wrong> {
    let document = DeTable::parse(text)?;
    let fields = Fields::document(&document, TOP)?;
    let mut all = vec![];
    for table in fields.tables("override", KEYS)? {
        let at = table.wrong_table("").span.start;
        all.push((at, entry(&table)?));
        table.finish()?;
    }
    fields.finish()?;
    Ok(all)
}

/// The tag in an entry that is not valid TOML, if its own line is.
fn tag(text: &str) -> Option<String> {
    text.lines().find_map(|line| {
        let line = DeTable::parse(line).ok()?;
        Some(line.get_ref().get("loop")?.get_ref().as_str()?.to_owned())
    })
}

fn entry(table: &Fields<'_, '_>) -> std::result::Result<Override, Wrong> {
    let text = |key| -> std::result::Result<Option<String>, Wrong> {
        match table.text(key)?.map(|text| text.trim().to_owned()) {
            Some(text) if text.is_empty() => Err(table.wrong(key, "is empty")),
            given => Ok(given),
        }
    };
    let needed = |key, what: &str| {
        text(key)?.ok_or_else(|| table.wrong(key, format!("is missing; give {what}")))
    };
    let loop_name = needed("loop", "the tag of the loop")?;
    let verdict = needed("verdict", "the verdict, such as \"does not stick\"")?;
    let verdict = VerdictClass::by_name(&verdict).map_err(|e| table.wrong("verdict", e))?;
    let reason = needed("reason", "the reason, in words")?;
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
                    "must be 64 hexadecimal digits, as in the JSON of a diagnosis",
                ));
            }
            Scope::File { name, sha256 }
        }
        (false, None, _) => {
            return Err(
                table.wrong("file", "is missing; name the file, or write all_recordings = true")
            );
        }
        (false, Some(_), None) => {
            return Err(table.wrong(
                "sha256",
                "is missing; give the SHA-256 of the file's bytes from the JSON of a diagnosis",
            ));
        }
    };
    let (by, entered, tool) = (text("by")?, date("entered")?, text("tool")?);
    Ok(Override { loop_name, verdict, reason, by, entered, tool, scope, from, until })
}

/// An override as a table. Its texts have no line breaks, because lines show where entries begin when a file is
/// damaged.
pub fn in_toml(one: &Override) -> String {
    let mut out = "[[override]]\n".to_owned();
    let mut set = |key: &str, value: String| out += &format!("{key} = {value}\n");
    set("loop", quoted(&one.loop_name));
    set("verdict", quoted(one.verdict.name()));
    set("reason", quoted(&one.reason));
    if let Some(by) = &one.by {
        set("by", quoted(by));
    }
    match &one.scope {
        Scope::File { name, sha256 } => {
            set("file", quoted(name));
            set("sha256", quoted(sha256));
        }
        Scope::All => set("all_recordings", "true".to_owned()),
    }
    for (key, date) in [("from", one.from), ("until", one.until), ("entered", one.entered)] {
        if let Some(date) = date {
            set(key, date.to_string());
        }
    }
    if let Some(tool) = &one.tool {
        set("tool", quoted(tool));
    }
    out
}
