//! Mapping files, the user's information on recordings in TOML.

use crate::bytes;
use crate::cells::{mode, quality};
use crate::columns::options::{LoopOptions, LoopSettings, Mapped, ReadOptions};
use crate::columns::role::{Role, Signal};
use crate::error::{Error, Result};
use crate::fields::{Fields, Known, Wrong, line_of};
use std::path::{Path, PathBuf};
use stiction_recording::recording::LoopType;
use toml::de::DeTable;

/// All top-level keys.
const TOP: Known = "zone time_format date sample_time part pattern bad_text decimal_mark bad_value \
    columns signals modes quality loop type op_range pv_range vp_range";
const SIGNALS: [(&str, Signal); 5] = [
    ("op", Signal::Op),
    ("pv", Signal::Pv),
    ("sp", Signal::Sp),
    ("vp", Signal::Vp),
    ("mode", Signal::Mode),
];
const SIGNAL_KEYS: Known = "op pv sp vp mode";
pub(super) const LOOP_KEYS: Known = "op pv sp vp mode type op_range pv_range vp_range";

/// The suffix of the mapping file of a single file.
const OWN: &str = ".mapping.toml";

impl ReadOptions {
    /// The mapping file of a single file, beside it: `FIC101.csv.mapping.toml` for `FIC101.csv`.
    pub fn mapping_path(file: &Path) -> PathBuf {
        let mut name = file.file_name().unwrap_or_default().to_owned();
        name.push(OWN);
        file.with_file_name(name)
    }

    /// Reads the mapping file at `path`.
    ///
    /// # Errors
    /// If the file cannot be read or is not well-formed.
    pub fn read(path: &Path) -> Result<Self> {
        let origin = path.display().to_string();
        Self::parse(&bytes::text(bytes::read(path)?, &origin)?, &origin)
    }

    /// Reads a mapping file from its `text`. Errors name it `origin`.
    ///
    /// # Errors
    /// If the text is not well-formed. The error gives the line.
    pub fn parse(text: &str, origin: &str) -> Result<Self> {
        let at = |wrong: Wrong| Error::Mapping {
            origin: origin.to_owned(),
            line: line_of(text.as_bytes(), wrong.span.start),
            message: wrong.message,
        };
        let document = DeTable::parse(text).map_err(|e| at(e.into()))?;
        let fields = Fields::document(&document, TOP).map_err(at)?;
        Ok(ReadOptions { mapping: Some(origin.to_owned()), ..build(fields).map_err(at)? })
    }
}

type Built<T> = std::result::Result<T, Wrong>;

fn build(fields: Fields<'_, '_>) -> Built<ReadOptions> {
    let mut options = ReadOptions { all: settings(&fields)?, ..ReadOptions::default() };
    options.zone = parsed(&fields, "zone")?;
    options.time_format = parsed(&fields, "time_format")?;
    options.date = parsed(&fields, "date")?;
    options.pattern = parsed(&fields, "pattern")?;
    options.decimal_mark = parsed(&fields, "decimal_mark")?;
    options.sample_time = fields.number("sample_time")?;
    if options.sample_time.is_some_and(|seconds| !(seconds > 0.0)) {
        return Err(fields.wrong("sample_time", "must be above 0 s"));
    }
    options.part = fields.text("part")?;
    options.bad_text = fields.texts("bad_text")?.unwrap_or_default();
    options.bad_value = fields.numbers("bad_value")?.unwrap_or_default();
    if let Some(table) = fields.table("signals", SIGNAL_KEYS)? {
        for (key, signal) in SIGNALS {
            if let Some(words) = table.texts(key)? {
                options.signals.push((signal, words));
            }
        }
        table.finish()?;
    }
    for (table, column, role) in fields.named_texts("columns")? {
        options.map.push(Mapped::of(role, column).map_err(|e| table.wrong(column, e))?);
    }
    options.modes = meanings(&fields, "modes", &mode::NAMES)?;
    options.qualities = meanings(&fields, "quality", &quality::NAMES)?;
    for (name, table) in fields.named_tables("loop", LOOP_KEYS)? {
        options.loops.push(LoopOptions { name: name.to_owned(), settings: settings(&table)? });
        for (key, signal) in SIGNALS {
            let (loop_name, role) = (Some(name.to_owned()), Role::Signal(signal));
            let mapped = table.text(key)?.map(|column| Mapped { loop_name, role, column });
            options.map.extend(mapped);
        }
        table.finish()?;
    }
    fields.finish()?;
    Ok(options)
}

/// The words and codes in a table with their meanings.
fn meanings<T: Copy>(
    fields: &Fields<'_, '_>,
    key: &'static str,
    of: &[(&str, T)],
) -> Built<Vec<(String, T)>> {
    let all = fields.named_texts(key)?.into_iter();
    all.map(|(table, word, text)| Ok((word.to_owned(), table.chosen(word, text, of)?))).collect()
}

/// The settings of a loop, or of all.
fn settings(fields: &Fields<'_, '_>) -> Built<LoopSettings> {
    let loop_type = fields
        .text("type")?
        .map(|name| LoopType::by_name(&name).map_err(|e| fields.wrong("type", e)));
    Ok(LoopSettings {
        loop_type: loop_type.transpose()?,
        op_range: range(fields, "op_range")?,
        pv_range: range(fields, "pv_range")?,
        vp_range: range(fields, "vp_range")?,
    })
}

fn range(fields: &Fields<'_, '_>, key: &'static str) -> Built<Option<(f64, f64)>> {
    match fields.two(key)? {
        Some((low, high)) if !(high > low) => {
            Err(fields.wrong(key, "must be two numbers, the lower one first, such as [0, 100]"))
        }
        range => Ok(range),
    }
}

fn parsed<T: std::str::FromStr<Err = String>>(
    fields: &Fields<'_, '_>,
    key: &'static str,
) -> Built<Option<T>> {
    let parse = |text: String| text.parse().map_err(|message: String| fields.wrong(key, message));
    fields.text(key)?.map(parse).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: &str = r#"
zone = "Europe/Berlin"
time_format = "day-first"
pattern = "{loop}.{signal}"
bad_text = ["Kaputt"]
part = "Trend 2"
decimal_mark = ","
bad_value = [-9999, 327.67]
op_range = [0, 100]
[columns]
"10FC102.OP" = "FIC102.op"
spare = "ignore"
[signals]
pv = ["MEAS"]
[modes]
"3" = "auto"
[quality]
Ersatz = "uncertain"
[loop.FIC101]
pv = "10FT101.DACA"
op = "10FC101.OP"
type = "flow"
pv_range = [0, 120.5]
"#;

    #[test]
    fn everything_is_read() {
        let options = ReadOptions::parse(ALL, "map.toml").unwrap();
        assert_eq!(options.zone.as_ref().unwrap().name(), "Europe/Berlin");
        assert_eq!(options.part.as_deref(), Some("Trend 2"));
        assert_eq!(options.decimal_mark, Some(crate::cells::number::DecimalMark::Comma));
        assert_eq!(options.signals, [(Signal::Pv, vec!["MEAS".to_owned()])]);
        assert_eq!(options.bad_value, [-9999.0, 327.67]);
        assert_eq!((options.modes.len(), options.qualities.len(), options.map.len()), (1, 1, 4));
        assert_eq!(options.map[0], "FIC102.op=10FC102.OP".parse().unwrap());
        assert_eq!(options.map[1], "ignore=spare".parse().unwrap());
        let by_name = crate::columns::options::SettingsByName::of(&options);
        let settings = by_name.of_loop("fic101");
        assert_eq!(settings.pv_range, Some((0.0, 120.5)));
        assert_eq!(settings.op_range, Some((0.0, 100.0)));
        assert_eq!(settings.loop_type, Some(LoopType::Flow));
        assert_eq!(by_name.of_loop("other").loop_type, None);
    }

    #[test]
    fn mistakes_name_the_line() {
        for (text, expected) in [
            ("zone = \"Berlin\"", "line 1: zone: \"Berlin\" is not a time zone"),
            ("\nzon = \"UTC\"", "line 2: unknown key \"zon\""),
            ("op_range = [100, 0]", "line 1: op_range: must be two numbers"),
            ("[loop.A]\n\ntype = \"flo\"", "line 3: loop.A.type"),
            ("[loop.A]\nmv = \"x\"", "line 2: unknown key \"loop.A.mv\""),
            (
                "[modes]\n\"3\" = \"car\"",
                "line 2: modes.3: is \"car\", but must be one of \"auto\"",
            ),
            ("[modes]\n\"3\" = 1", "line 2: modes.3: must be a text in quotes"),
            ("bad_text = \"x\"", "line 1: bad_text: must be a list of texts"),
            (
                "decimal_mark = \";\"",
                "line 1: decimal_mark: \";\" is not a decimal mark; give point or comma",
            ),
            ("sample_time = 0", "line 1: sample_time: must be above 0 s"),
            ("pattern = \"{loop}\"", "line 1: pattern"),
            ("time_format = \"iso\"", "line 1: time_format: \"iso\" is not a time format"),
            ("loop = 3", "line 1: loop: must be tables"),
            (
                "[columns]\nx = \"open\"",
                "line 2: columns.x: \"open\" is not a role; roles are time",
            ),
            ("[columns]\nx = 3", "line 2: columns.x: must be a text in quotes"),
            ("zone = ", "line 1"),
        ] {
            let message = ReadOptions::parse(text, "map.toml").unwrap_err().to_string();
            assert!(message.starts_with("map.toml, line "), "{message}");
            assert!(message.contains(expected), "{expected}: {message}");
        }
    }
}
