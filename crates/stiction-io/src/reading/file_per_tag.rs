//! Files that hold one signal each, such as `FIC101.PV.csv`, `FIC101.SP.csv` and `FIC101.OP.csv`, read together as one
//! loop.

use super::format::{File, Format, sheets};
use super::{Reading, collected, join};
use crate::columns::options::{Mapped, ReadOptions};
use crate::columns::role::{self, Role, SEPARATORS, Signal};
use crate::error::Result;
use crate::sheet::{Cells, Column, Sheet, Viewed};
use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::path::Path;

/// A file with the times and values of one signal.
#[derive(Debug, Clone)]
pub struct SignalFile {
    /// The loop; none if neither the file nor its name shows it.
    pub loop_name: Option<String>,
    /// The signal; none if neither the file nor its name shows it.
    pub signal: Option<Signal>,
    origin: String,
    sha256: String,
    format: Format,
    sheet: Sheet,
    notes: Vec<String>,
    time: usize,
    value: usize,
    quality: Option<usize>,
}

impl SignalFile {
    /// The signal in `bytes`; `None` if they hold anything else. The user's role for the name of the file takes
    /// precedence, then the tag in the file, then the name of the file.
    pub fn of(bytes: &[u8], origin: &str, options: &ReadOptions) -> Option<Self> {
        let (format, mut sheets, notes) = sheets(bytes, origin).ok()?;
        let (Some(sheet), true) = (sheets.pop(), sheets.is_empty()) else { return None };
        let role_of = |column: &Column| {
            let mapped =
                options.map.iter().rev().find(|mapped| is_name(&mapped.column, &column.name));
            mapped.map(|mapped| mapped.role).or_else(|| role::of_rows(&column.name))
        };
        let roles: Vec<Option<Role>> = sheet.columns.iter().map(role_of).collect();
        let of = |role: Role| roles.iter().position(|each| *each == Some(role));
        let is_value = |i: &usize| matches!(roles[*i], None | Some(Role::Value | Role::Signal(_)));
        let values: Vec<usize> = (0..roles.len()).filter(is_value).collect();
        let value = match (of(Role::Value), &values[..]) {
            (Some(value), _) => value,
            (None, [value]) => *value,
            _ => return None,
        };
        if of(Role::Date).is_some() {
            return None;
        }
        let tag = match of(Role::Tag).map(|tag| &sheet.columns[tag].cells) {
            None => None,
            Some(Cells::Text(cells)) => {
                let cells = cells.view();
                let first = cells.first()?;
                Some(first.to_owned()).filter(|_| cells.iter().all(|cell| cell == first))
            }
            Some(_) => return None,
        };
        if of(Role::Tag).is_some() && tag.is_none() {
            return None;
        }
        let path = Path::new(origin);
        let file =
            path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let stem =
            path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let told = mapped(&file, &stem, options);
        let column =
            Some(sheet.columns[value].name.clone()).filter(|name| role::of_rows(name).is_none());
        let named = [tag, column].into_iter().flatten().find_map(|name| split(&name, options));
        let named = named.or_else(|| without_dates(&stem).find_map(|name| split(name, options)));
        let (loop_name, signal) = match (told, named) {
            (Some(told), named) => {
                let loop_name =
                    told.loop_name.clone().or(named.and_then(|(loop_name, _)| loop_name));
                let Role::Signal(signal) = told.role else { return None };
                (loop_name, Some(signal))
            }
            (None, Some((loop_name, signal))) => (loop_name, Some(signal)),
            (None, None) => (None, None),
        };
        Some(Self {
            loop_name,
            signal,
            origin: origin.to_owned(),
            sha256: format!("{:x}", Sha256::digest(bytes)),
            format,
            time: of(Role::Time)?,
            value,
            quality: of(Role::Quality(None)),
            sheet,
            notes,
        })
    }

    /// Tag in the joined table, with the unit of its values.
    fn tag(&self) -> String {
        let signal = self.signal.map_or("", Signal::name);
        let column = &self.sheet.columns[self.value];
        let unit = column.unit.as_deref().or(role::without_unit(&column.name).1);
        let unit = unit.map_or(String::new(), |unit| format!(" [{unit}]"));
        self.loop_name
            .as_ref()
            .map_or(format!("{signal}{unit}"), |loop_name| format!("{loop_name}.{signal}{unit}"))
    }
}

/// Reads files of one loop, one signal per file, as one long table.
///
/// # Errors
/// As for [`parse`](super::parse), with all files as the origin.
pub fn read_together(files: &[SignalFile], options: &ReadOptions) -> Result<Reading> {
    let first = files.first().map_or("", |file| &file.origin);
    let origin = format!("{first} and {} more", files.len().saturating_sub(1));
    let mut places = vec![];
    for (k, file) in files.iter().enumerate() {
        places.extend((0..file.sheet.len()).map(|row| (k, row)));
    }
    let tags: Vec<String> = files.iter().map(SignalFile::tag).collect();
    let text = |of: &dyn Fn(&SignalFile) -> Option<usize>| -> Cells {
        let columns = files.iter().map(|file| Some(&file.sheet.columns[of(file)?]));
        let views: Vec<Option<Viewed<'_>>> =
            columns.map(|column| Some(column?.cells.view())).collect();
        let cell = |(k, row): &(usize, usize)| match &views[*k] {
            None => Cow::Borrowed(""),
            Some(cells) => cells.text(*row),
        };
        Cells::Text(places.iter().map(cell).collect())
    };
    let times = |file: &SignalFile| match file.sheet.columns[file.time].cells {
        Cells::Times { utc, .. } => Some(utc),
        _ => None,
    };
    let utc = files.first().and_then(times);
    let time = match utc.filter(|_| files.iter().all(|file| times(file) == utc)) {
        None => text(&|file| Some(file.time)),
        Some(utc) => {
            let second =
                |(k, row): &(usize, usize)| match &files[*k].sheet.columns[files[*k].time].cells {
                    Cells::Times { seconds, .. } => seconds[*row],
                    _ => f64::NAN,
                };
            Cells::Times { seconds: places.iter().map(second).collect(), utc }
        }
    };
    let column = |name: &str, cells: Cells| Column { name: name.to_owned(), unit: None, cells };
    let mut columns = vec![
        column("tag", Cells::Text(places.iter().map(|(k, _)| &*tags[*k]).collect())),
        column("time", time),
        column("value", text(&|file| Some(file.value))),
    ];
    if files.iter().any(|file| file.quality.is_some()) {
        columns.push(column("quality", text(&|file| file.quality)));
    }
    let first = files.first();
    let sheet = Sheet {
        origin: origin.clone(),
        columns,
        attributes: first.map(|file| file.sheet.attributes.clone()).unwrap_or_default(),
        rows: places.iter().map(|(k, row)| files[*k].sheet.row(*row)).collect(),
        ..Sheet::default()
    };
    let is_general = |mapped: &&Mapped| {
        !matches!(mapped.role, Role::Signal(_) | Role::Time | Role::Value | Role::Tag)
    };
    let map = options.map.iter().filter(is_general).cloned().collect();
    let mut notes = vec![format!(
        "read together from {} files, each with one signal: {}",
        files.len(),
        files
            .iter()
            .map(|file| format!("{} is {}", file.origin, file.tag()))
            .collect::<Vec<_>>()
            .join(", ")
    )];
    notes.extend(
        files
            .iter()
            .flat_map(|file| file.notes.iter().map(|note| format!("{}: {note}", file.origin))),
    );
    let sha256 = join::sha256(files.iter().map(|file| &*file.sha256));
    let format = first.map_or(Format::Memory, |file| file.format);
    let options = ReadOptions { map, ..options.clone() };
    collected(File { format, sheets: vec![sheet], notes, sha256 }, &origin, &options)
}

/// The user's role for a file by its name.
fn mapped<'o>(file: &str, stem: &str, options: &'o ReadOptions) -> Option<&'o Mapped> {
    let is_it = |mapped: &&Mapped| is_name(&mapped.column, file) || is_name(&mapped.column, stem);
    options.map.iter().rev().find(is_it)
}

fn is_name(given: &str, name: &str) -> bool {
    given.to_lowercase() == name.to_lowercase()
}

/// The loop and signal in a name.
fn split(name: &str, options: &ReadOptions) -> Option<(Option<String>, Signal)> {
    let by_pattern =
        options.pattern.as_ref().and_then(|pattern| pattern.split(name, &options.signals));
    let split = by_pattern.or_else(|| role::split(name, &options.signals))?;
    match split.role {
        Role::Signal(signal) => Some((split.loop_name, signal)),
        _ => None,
    }
}

/// A name, and without the numbers at its end, such as a date.
fn without_dates(name: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(name), |name| {
        let (before, end) = name.rsplit_once(SEPARATORS)?;
        end.bytes().all(|b| b.is_ascii_digit() || b == b'T').then_some(before)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, origin: &str, map: &[&str]) -> Option<SignalFile> {
        let map = map.iter().map(|each| each.parse().unwrap()).collect();
        SignalFile::of(text.as_bytes(), origin, &ReadOptions { map, ..ReadOptions::default() })
    }

    #[test]
    fn the_signal_of_a_file_is_in_the_file_or_its_name() {
        let plain = "Timestamp,Value\n2020-12-10 23:40:00,1\n2020-12-10 23:40:01,2\n";
        let tagged = plain.replace("Value", "FIC7.OP");
        let long = "tag,time,value\nFIC7.SP,0,1\nFIC7.SP,1,2\n";
        for (text, origin, map, expected) in [
            (plain, "x/FIC101.PV.csv", &[][..], Some((Some("FIC101"), Some(Signal::Pv)))),
            (plain, "FIC101_OP_2020-12-10.csv", &[], Some((Some("FIC101"), Some(Signal::Op)))),
            (plain, "FIC101-SP.txt", &[], Some((Some("FIC101"), Some(Signal::Sp)))),
            (plain, "export.csv", &[], Some((None, None))),
            (plain, "a.csv", &["pv=a.csv"], Some((None, Some(Signal::Pv)))),
            (plain, "a.csv", &["LIC2.op=a"], Some((Some("LIC2"), Some(Signal::Op)))),
            (&tagged, "export.csv", &[], Some((Some("FIC7"), Some(Signal::Op)))),
            (long, "export.csv", &[], Some((Some("FIC7"), Some(Signal::Sp)))),
            ("t,pv,op\n0,1,2\n", "FIC101.PV.csv", &[], None),
            ("tag,time,value\nA.PV,0,1\nA.OP,0,2\n", "FIC101.PV.csv", &[], None),
            ("x", "FIC101.PV.csv", &[], None),
        ] {
            let found = of(text, origin, map);
            let found = found.as_ref().map(|file| (file.loop_name.as_deref(), file.signal));
            assert_eq!(found, expected, "{origin} {map:?}");
        }
    }

    #[test]
    fn files_of_a_loop_are_one_recording() {
        let text = |from: f64| {
            let rows: String = (0..3)
                .map(|k| format!("2020-12-10 23:40:0{k},{}\n", from + f64::from(k)))
                .collect();
            format!("Timestamp,Value\n{rows}")
        };
        let files: Vec<SignalFile> =
            [("FIC101.PV.csv", 1.0), ("FIC101.OP.csv", 50.5), ("FIC101.SP.csv", 2.0)]
                .into_iter()
                .filter_map(|(origin, from)| of(&text(from), origin, &[]))
                .collect();
        let reading = read_together(&files, &ReadOptions::default()).unwrap();
        let [one] = &reading.recordings[..] else { panic!("{reading:?}") };
        assert_eq!((&*one.name, &one.op.values[..]), ("FIC101", &[50.5, 51.5, 52.5][..]));
        assert_eq!(one.pv.as_ref().unwrap().values, [1.0, 2.0, 3.0]);
        assert_eq!(one.sp.as_ref().unwrap().time, [0.0, 1.0, 2.0]);
        assert!(reading.notes[0].contains("FIC101.SP.csv is FIC101.SP"), "{:?}", reading.notes);
        assert_eq!(reading.origin, "FIC101.PV.csv and 2 more");
    }

    #[test]
    fn the_unit_of_a_signal_is_kept() {
        let text = |name: &str, unit: &str| format!("t,{name}\ns,{unit}\n0,9\n1,9.2\n2,9.1\n");
        let files: Vec<SignalFile> = [
            ("FIC101.PV.csv", text("Value", "m3/h")),
            ("FIC101.OP.csv", text("Value", "psi")),
            ("FIC101.SP.csv", text("Value [m3/h]", "")),
        ]
        .into_iter()
        .filter_map(|(origin, text)| of(&text, origin, &[]))
        .collect();
        let reading = read_together(&files, &ReadOptions::default()).unwrap();
        let one = &reading.recordings[0];
        assert_eq!((&*one.name, one.op.unit.as_deref()), ("FIC101", Some("psi")));
        assert_eq!(one.op.range.map(|range| (range.low, range.high)), Some((3.0, 15.0)));
        assert_eq!(one.pv.as_ref().unwrap().unit.as_deref(), Some("m3/h"));
        assert_eq!(one.sp.as_ref().unwrap().unit.as_deref(), Some("m3/h"));
    }
}
