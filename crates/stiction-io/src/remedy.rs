//! Remedies for a reader that cannot recognise something by itself.

use crate::cells::number::DecimalMark;
use std::fmt;

/// A request of the reader, with an example if possible. Every front end has its own wording, see [`Wording`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Remedy {
    /// Give the role of a column ([`ReadOptions::map`](crate::ReadOptions::map)).
    Map {
        /// The role, such as `op`, or `FIC101.op` of one loop of several.
        role: String,
        /// The column; `None` if only the user knows it.
        column: Option<String>,
    },
    /// Give the time between rows, in s, such as this one.
    SampleTime(f64),
    /// Give the format of times, such as one of these. Any format is possible if the list is empty.
    TimeFormat(Vec<String>),
    /// Give the day of the first row, such as this one.
    Date(Option<String>),
    /// Give the zone of local times, such as this one.
    Zone(Option<String>),
    /// Read only this sheet of the workbook, or this part of the file.
    Part(String),
    /// Declare these words as bad values.
    BadText(Vec<String>),
    /// Give the decimal mark.
    DecimalMark(DecimalMark),
    /// Give the mode that this word or code means, such as one of these.
    Mode {
        /// The word or code.
        word: String,
        /// The possible modes.
        modes: Vec<&'static str>,
    },
    /// Give the quality that this word or code means, such as one of these.
    Quality {
        /// The word or code.
        word: String,
        /// The possible qualities.
        qualities: Vec<&'static str>,
    },
    /// Give the values of a signal at 0 % and 100 %.
    Range {
        /// The signal, `OP` or `VP`.
        signal: &'static str,
        /// The likely values, if known.
        ends: Option<(f64, f64)>,
    },
}

impl Remedy {
    /// A role for a column with this name.
    pub(crate) fn map(role: impl Into<String>, column: &str) -> Self {
        Self::Map { role: role.into(), column: Some(column.to_owned()) }
    }

    /// A role for a column that only the user knows.
    pub(crate) fn map_some(role: &str) -> Self {
        Self::Map { role: role.to_owned(), column: None }
    }

    /// The field of [`ReadOptions`](crate::ReadOptions), or of its loops' settings, for this remedy.
    pub fn option(&self) -> &'static str {
        match self {
            Self::Map { .. } => "map",
            Self::SampleTime(_) => "sample_time",
            Self::TimeFormat(_) => "time_format",
            Self::Date(_) => "date",
            Self::Zone(_) => "zone",
            Self::Part(_) => "part",
            Self::BadText(_) => "bad_text",
            Self::DecimalMark(_) => "decimal_mark",
            Self::Mode { .. } => "mode",
            Self::Quality { .. } => "quality",
            Self::Range { signal: "VP", .. } => "vp_range",
            Self::Range { .. } => "op_range",
        }
    }

    /// The value to give, as the command line writes it; empty without an example.
    pub fn value(&self) -> String {
        match self {
            Self::Map { role, column } => {
                format!("{role}={}", column.as_deref().unwrap_or("COLUMN"))
            }
            Self::SampleTime(seconds) => seconds.to_string(),
            Self::TimeFormat(ways) => ways.join(" or "),
            Self::Date(text) | Self::Zone(text) => text.clone().unwrap_or_default(),
            Self::Part(word) => word.clone(),
            Self::BadText(words) => words.join(" and "),
            Self::DecimalMark(mark) => mark.name().to_owned(),
            Self::Mode { word, modes: meanings } | Self::Quality { word, qualities: meanings } => {
                format!("{word}={}", meanings.join(" or "))
            }
            Self::Range { ends: Some((low, high)), .. } => format!("{low},{high}"),
            Self::Range { ends: None, .. } => "LOW,HIGH".to_owned(),
        }
    }
}

/// The option of this library and the value, such as `map op=COLUMN`.
impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.option())?;
        match self.value() {
            value if value.is_empty() => Ok(()),
            value => write!(f, " {value}"),
        }
    }
}

/// The wording of remedies in messages and notes, by default with the names of this library's options. A front end
/// whose options have other names provides its own.
#[derive(Clone, Copy)]
pub struct Wording(pub fn(&Remedy) -> String);

impl Wording {
    pub(crate) fn of(self, remedy: Remedy) -> String {
        (self.0)(&remedy)
    }
}

impl Default for Wording {
    fn default() -> Self {
        Self(Remedy::to_string)
    }
}

impl fmt::Debug for Wording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Wording")
    }
}

/// Wordings do not affect reading, so all are equal.
impl PartialEq for Wording {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Mapped;
    use crate::{ReadOptions, mode, quality, reading};
    use std::cell::RefCell;

    thread_local! {
        static GIVEN: RefCell<Vec<Remedy>> = const { RefCell::new(vec![]) };
    }

    /// Keeps every remedy that a reader words, also in notes.
    const KEPT: Wording = Wording(|remedy| {
        GIVEN.with_borrow_mut(|given| given.push(remedy.clone()));
        remedy.to_string()
    });

    /// Whether a file is read, and the remedies beside that.
    fn read(file: &[u8], name: &str, options: ReadOptions) -> (bool, Vec<Remedy>) {
        GIVEN.take();
        let read = reading::parse(file, name, &ReadOptions { wording: KEPT, ..options });
        (read.is_ok(), GIVEN.take())
    }

    /// Does what a remedy asks for, with the word of a user where it has no example. A new remedy needs a line here, and a file
    /// below.
    fn follow(remedy: &Remedy, user: &str) -> ReadOptions {
        let mut options = ReadOptions::default();
        let or_user = |example: &Option<String>| example.clone().unwrap_or_else(|| user.to_owned());
        match remedy {
            Remedy::Map { role, column } => {
                options.map.push(Mapped::of(role, &or_user(column)).unwrap());
            }
            Remedy::SampleTime(seconds) => options.sample_time = Some(*seconds),
            Remedy::TimeFormat(some) => {
                options.time_format = Some(or_user(&some.first().cloned()).parse().unwrap());
            }
            Remedy::Date(day) => options.date = Some(or_user(day).parse().unwrap()),
            Remedy::Zone(zone) => options.zone = Some(or_user(zone).parse().unwrap()),
            Remedy::Part(part) => options.part = Some(part.clone()),
            Remedy::BadText(words) => options.bad_text.extend(words.clone()),
            Remedy::DecimalMark(mark) => options.decimal_mark = Some(*mark),
            Remedy::Mode { word, modes } => {
                let meaning = format!("{word}={}", modes[0]);
                options.modes.push(mode::of_option(&meaning).unwrap());
            }
            Remedy::Quality { word, qualities } => {
                let meaning = format!("{word}={}", qualities[0]);
                options.qualities.push(quality::of_option(&meaning).unwrap());
            }
            Remedy::Range { signal, ends } => {
                let known = || user.split_once(',').unwrap();
                let ends = ends.unwrap_or_else(|| {
                    let (low, high) = known();
                    (low.parse().unwrap(), high.parse().unwrap())
                });
                match *signal {
                    "VP" => options.all.vp_range = Some(ends),
                    _ => options.all.op_range = Some(ends),
                }
            }
        }
        options
    }

    /// A file for each remedy: with the first that it gives, it is read, and the remedy is not given again.
    #[test]
    fn each_remedy_helps_once_it_is_followed() {
        let rows = |of: &dyn Fn(usize) -> String| (0..40).map(of).collect::<String>();
        let counts = |name: &str| {
            format!("t,PV,OP,{name}\n")
                + &rows(&|k| format!("{k},5{},5{},{}\n", k % 9, k % 7, 9_800 + 90 * (k % 12)))
        };
        let sheets = format!("{}/tests/fixtures/days.xlsx", env!("CARGO_MANIFEST_DIR"));
        // The option, the file, and what only its user knows.
        let cases: [(&str, Vec<u8>, &str); 14] = [
            ("map", "t,x,y\n0,50,1\n1,51,2\n".into(), "x"),
            ("map", "t,FIC1.OP,State\n0,50,AUTO\n1,51,MAN\n".into(), ""),
            ("sample_time", "op\n50\n51\n".into(), ""),
            ("time_format", "time,op\n05/06/2024 00:00:00,50\n05/06/2024 00:00:01,51\n".into(), ""),
            ("date", "time,op\n23:59:58,50\n23:59:59,51\n00:00:00,52\n".into(), ""),
            ("zone", "time,op\n2025-03-14 06:00:00Z,50\n2025-03-14 06:00:01,51\n".into(), "UTC"),
            ("part", std::fs::read(sheets).unwrap(), ""),
            ("bad_text", "t,op\n0,50\n1,Foo\n2,51\n3,Bar\n4,52\n".into(), ""),
            ("decimal_mark", "F.PV;F.OP\n30;45\n1.000;46\n33;45\n".into(), ""),
            ("mode", "t,op,mode\n0,50,Foo\n1,51,Foo\n".into(), ""),
            ("quality", "t,op,op quality\n0,50,192\n1,51,777\n".into(), ""),
            ("quality", "t,op\n0,50\n1,51 S\n2,52\n".into(), ""),
            ("op_range", counts("x").replace("OP,x", "x,OP").into(), "0,27648"),
            ("vp_range", counts("VP").into(), "0,27648"),
        ];
        for (option, file, user) in cases {
            let name = if option == "part" { "f.xlsx" } else { "f.csv" };
            let (_, given) = read(&file, name, ReadOptions::default());
            let remedy = given.iter().find(|remedy| remedy.option() == option);
            let remedy = remedy.unwrap_or_else(|| panic!("{option} is not given, but {given:?}"));
            let mut options = follow(remedy, user);
            if option == "decimal_mark" {
                // Its file has no times.
                options.sample_time = Some(1.0);
            }
            let (is_read, again) = read(&file, name, options);
            assert!(is_read && !again.contains(remedy), "{remedy}: then {again:?}");
        }
    }
}
