//! The part of a CSV file above its samples: titles, settings, and one or more rows of a header.

use super::{attribute, filled, is_comment, trimmed};
use crate::cells::number;
use crate::columns::role::{self, Role};
use crate::names::list;
use crate::timestamp;
use csv::StringRecord;
use std::collections::HashSet;

/// Maximum number of consecutive rows of words that form one header.
const MOST_ROWS: usize = 6;

/// A record that is not blank, with its line.
pub type Line = (usize, StringRecord);

/// The part above the samples.
pub struct Top {
    /// The names of the columns.
    pub names: Vec<String>,
    /// The cells of the row of names, which may come again in a file that was put together.
    pub header: Vec<String>,
    /// Their units, if a row gives them.
    pub units: Option<Vec<String>>,
    /// Line of the first row of samples.
    pub first: usize,
    /// Settings above the table.
    pub attributes: Vec<(String, String)>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

impl Top {
    /// Finds the header in the first records of a file, whose table is mostly `width` cells wide. It begins with the
    /// first record of that width that is neither a comment nor a row of samples. More rows of words may follow. If
    /// there is no such record, the comment above the samples may be the header, and otherwise columns are named by
    /// their places.
    pub fn find(records: &[Line], width: usize) -> Result<Self, String> {
        let mut attributes = vec![];
        let mut comment: Option<&Line> = None;
        let mut above: Option<&Line> = None;
        for (at, line) in records.iter().enumerate() {
            let record = &line.1;
            let first = record[0].trim();
            if line.0 == 1 && first.to_ascii_lowercase().starts_with("sep=") {
                continue;
            }
            if is_comment(record) {
                attributes.extend(attribute(record));
                comment = Some(line);
                continue;
            }
            let has_header_below = || {
                let is_header = |(k, (_, below)): (usize, &Line)| {
                    filled(below) >= width.max(filled(record))
                        && is_words(below)
                        && score(below) > 0
                        && records.get(at + k + 2).is_some_and(|(_, row)| !is_words(row))
                };
                records[at + 1..].iter().enumerate().any(is_header)
            };
            let is_setting = filled(record) < width
                || first.ends_with(':')
                || (score(record) == 0
                    && !is_value(first)
                    && filled(record) <= 2
                    && has_header_below());
            if is_setting {
                // Titles and settings above the table.
                attributes.extend(attribute(record));
                above = Some(line);
                continue;
            }
            if !is_samples(record) {
                return Self::of_header(records, at, width, above, attributes);
            }
            if let Some((row, header)) = comment.filter(|(_, text)| filled(text) == width) {
                let mut names: Vec<String> = header.iter().map(trimmed).collect();
                names[0] = names[0].trim_start_matches(['#', ' ']).to_owned();
                let notes = vec![format!("the comment in row {row} is used as the header")];
                let header = names.clone();
                return Ok(Self { names, header, units: None, first: line.0, attributes, notes });
            }
            let above = above.filter(|(row, _)| row + 1 == line.0);
            if let Some((row, names)) =
                above.and_then(|(row, tags)| Some((row, over_times(tags, record)?)))
            {
                let notes = vec![format!(
                    "each tag in row {row} names the times below it and the values beside them"
                )];
                let header = vec![];
                return Ok(Self { names, header, units: None, first: line.0, attributes, notes });
            }
            return Ok(Self::without_header(&records[at..], attributes));
        }
        Err("names no columns; a header such as \"time,pv,op\" and rows of samples are needed"
            .to_owned())
    }

    /// A header that begins with the record at `at`.
    fn of_header(
        records: &[Line],
        at: usize,
        width: usize,
        above: Option<&Line>,
        attributes: Vec<(String, String)>,
    ) -> Result<Self, String> {
        let mut rows: Vec<&Line> = vec![&records[at]];
        let mut below =
            records[at + 1..].iter().filter(|(_, record)| !is_comment(record)).peekable();
        while let Some(row) = below.next_if(|(_, record)| is_words(record) || is_range(record)) {
            rows.push(row);
        }
        // Samples follow a header. Many rows of words are samples themselves.
        let first = below.peek().copied();
        if first.is_none() || rows.len() > MOST_ROWS {
            rows.truncate(1);
            rows.extend(records.get(at + 1).filter(|(_, record)| is_units(record)));
        }
        let is_candidate = |(_, record): &&&Line| {
            rows.len() == 1 || (filled(record) >= width && !is_units(record) && !is_range(record))
        };
        let names = rows.iter().filter(is_candidate).rev().max_by_key(|(_, record)| score(record));
        let names: &Line = names.copied().unwrap_or(rows[0]);
        let units = rows.iter().find(|(line, record)| *line != names.0 && is_units(record));
        let directly_above =
            rows.iter().copied().chain(above).find(|(line, _)| line + 1 == names.0);
        let group = directly_above
            .filter(|(line, _)| units.is_none_or(|(unit, _)| unit != line))
            .and_then(|(line, record)| Some((line, grouped(record, &names.1)?)));
        let mut notes = vec![];
        let is_used = |line: usize| {
            line == names.0
                || units.is_some_and(|(unit, _)| *unit == line)
                || group.as_ref().is_some_and(|(group, _)| **group == line)
        };
        let other: Vec<String> = rows
            .iter()
            .filter(|(line, _)| !is_used(*line))
            .map(|(line, _)| line.to_string())
            .collect();
        match &other[..] {
            [] => {}
            [row] => notes.push(format!("row {row} only describes the columns and is not read")),
            rows => notes.push(format!(
                "rows {} only describe the columns and are not read",
                rows.join(", ")
            )),
        }
        let header: Vec<String> = names.1.iter().map(trimmed).collect();
        let mut name_of = match &group {
            Some((line, grouped)) => {
                notes.push(format!("the names in rows {line} and {} are combined", names.0));
                grouped.clone()
            }
            None => header.clone(),
        };
        // The name of the times may be in another row than those of the signals.
        for (k, name) in name_of.iter_mut().enumerate().filter(|(_, name)| name.is_empty()) {
            let is_time =
                |cell: &&str| matches!(role::of_rows(cell), Some(Role::Time | Role::Date));
            let mut cells = rows.iter().filter_map(|row| row.1.get(k)).map(str::trim);
            name.push_str(cells.find(is_time).unwrap_or(""));
        }
        // A column of times may bear the word for what stands to the right of it, or none.
        let sample = first.map(|(_, record)| record[0].trim());
        let is_tag = role::of_rows(&name_of[0]) == Some(Role::Tag)
            && !name_of.iter().any(|name| role::of_rows(name) == Some(Role::Value));
        if (is_tag || name_of[0].is_empty()) && sample.is_some_and(timestamp::looks_like) {
            notes.push(format!(
                "the first column is called \"{}\", but holds times and is read as such",
                name_of[0]
            ));
            "Time".clone_into(&mut name_of[0]);
        }
        let after = rows.iter().map(|(line, _)| *line).max().unwrap_or(names.0);
        Ok(Self {
            names: name_of,
            header,
            units: units.map(|(_, record)| record.iter().map(unit).collect()),
            first: records
                .iter()
                .map(|(line, _)| *line)
                .find(|line| *line > after)
                .unwrap_or(usize::MAX),
            attributes,
            notes,
        })
    }

    /// Names by places, or by what the columns hold if those are clearly tags, times and values.
    fn without_header(samples: &[Line], attributes: Vec<(String, String)>) -> Self {
        let width = samples.iter().map(|(_, record)| filled(record)).max().unwrap_or(0);
        let cells = |column: usize| {
            samples
                .iter()
                .filter_map(move |(_, record)| record.get(column))
                .map(str::trim)
                .take(100)
        };
        let all = |column: usize, is: &dyn Fn(&str) -> bool| {
            cells(column).any(is)
                && cells(column).all(|cell| is(cell) || number::word(cell).is_some())
        };
        let is_word = |cell: &str| cell.contains(char::is_alphabetic) && !is_value(cell);
        let is_tag = |cell: &str| is_word(cell) && role::split(cell, &[]).is_some();
        let mut names: Vec<String> = (1..=width).map(|place| format!("column {place}")).collect();
        let mut notes = vec![];
        let columns = |is: &dyn Fn(&str) -> bool| -> Vec<usize> {
            (0..width).filter(|column| all(*column, is)).collect()
        };
        let times = columns(&timestamp::looks_like);
        let numbers =
            columns(&|cell: &str| number::looks_like(cell) && !timestamp::looks_like(cell));
        let words = columns(&is_word);
        let tags: Vec<usize> =
            words.iter().copied().filter(|column| cells(*column).any(is_tag)).collect();
        if let ([time], [tag], [value]) = (&times[..], &tags[..], &numbers[..]) {
            for (column, name) in [(time, "time"), (tag, "tag"), (value, "value")] {
                name.clone_into(&mut names[*column]);
            }
            if let [other] = words.iter().filter(|column| *column != tag).collect::<Vec<_>>()[..] {
                "quality".clone_into(&mut names[*other]);
            }
            notes.push(format!(
                "the file has no header; its columns, by their content, are {}",
                list(&names.iter().map(|name| &**name).collect::<Vec<_>>())
            ));
        }
        let header = vec![];
        Self { names, header, units: None, first: samples[0].0, attributes, notes }
    }
}

/// A cell of a row of units.
fn unit(cell: &str) -> String {
    let unit = cell.trim();
    if number::word(unit).is_some() { String::new() } else { unit.to_owned() }
}

/// Whether a cell is a value: a number, or something with a date or time of day.
fn is_value(cell: &str) -> bool {
    number::looks_like(cell)
        || timestamp::looks_like(cell)
        || (cell.starts_with(|c: char| c.is_ascii_digit()) && cell.contains(':'))
}

/// Whether a record holds words, and no value.
fn is_words(record: &StringRecord) -> bool {
    let cells = || record.iter().map(str::trim).filter(|cell| !cell.is_empty());
    !cells().any(is_value) && cells().any(|cell| number::word(cell).is_none())
}

/// Whether a record of a header gives the ends of ranges, such as `Low,,0,0,0`.
fn is_range(record: &StringRecord) -> bool {
    const WORDS: [&str; 12] = [
        "min", "max", "minimum", "maximum", "low", "high", "lo", "hi", "zero", "span", "lrv", "urv",
    ];
    let first = record[0].to_lowercase().replace([' ', '_', '-', ':', '.'], "");
    let bare = ["range", "eu", "limit", "value", "scale"]
        .iter()
        .fold(first, |word, known| word.replace(known, ""));
    let mut cells = record.iter().skip(1).map(str::trim).filter(|cell| !cell.is_empty()).peekable();
    WORDS.contains(&&*bare)
        && cells.peek().is_some()
        && cells.all(|cell| !timestamp::looks_like(cell))
}

/// Number of cells that are names of columns by a known word.
fn score(record: &StringRecord) -> usize {
    let is_known = |cell: &str| role::of_rows(cell).is_some() || role::split(cell, &[]).is_some();
    record.iter().map(str::trim).filter(|cell| !cell.is_empty() && is_known(cell)).count()
}

/// The names under a row of groups, which names each group once, above its first column. `None` if these names do not
/// need groups, or have none.
fn grouped(groups: &StringRecord, names: &StringRecord) -> Option<Vec<String>> {
    let distinct = |names: &[String]| {
        let mut seen = HashSet::new();
        names.iter().filter(|name| !name.is_empty()).all(|name| seen.insert(name.to_lowercase()))
    };
    let bare: Vec<String> = names.iter().map(trimmed).collect();
    // One tag above the signals of one loop.
    let is_tag = |cell: &str| {
        cell.is_empty() || cell.contains(|c: char| c.is_ascii_digit()) && !is_value(cell)
    };
    let is_bare =
        |name: &String| role::split(name, &[]).is_some_and(|split| split.loop_name.is_none());
    let is_loop = groups[0].trim().is_empty()
        && groups.iter().map(str::trim).all(is_tag)
        && bare.iter().skip(1).all(is_bare);
    if distinct(&bare) && !is_loop {
        return None;
    }
    let starts: Vec<usize> = (0..groups.len()).filter(|i| !groups[*i].trim().is_empty()).collect();
    let of = |i: usize| {
        let place = starts.partition_point(|start| *start <= i).checked_sub(1)?;
        let end = starts.get(place + 1).copied().unwrap_or(names.len());
        Some((groups[starts[place]].trim(), end - starts[place]))
    };
    let name = |(i, name): (usize, &String)| match of(i) {
        None => name.clone(),
        // A delimiter at the end of the rows makes no column.
        Some(_) if name.is_empty() => groups.get(i).unwrap_or("").trim().to_owned(),
        Some((_, 1)) if role::of_rows(name).is_some() => name.clone(),
        Some((group, _)) => format!("{group}.{name}"),
    };
    let combined: Vec<String> = bare.iter().enumerate().map(name).collect();
    distinct(&combined).then_some(combined)
}

/// The names of the columns if each of the `tags` stands above its times, with nothing above its values, as PI DataLink
/// writes them.
fn over_times(tags: &StringRecord, sample: &StringRecord) -> Option<Vec<String>> {
    let cell = |record: &StringRecord, k: usize| record.get(k).unwrap_or("").trim().to_owned();
    let mut names = vec![];
    for k in (0..sample.len()).step_by(2) {
        let (tag, beside) = (cell(tags, k), cell(tags, k + 1));
        let is_pair = !tag.is_empty() && beside.is_empty();
        if !is_pair
            || !timestamp::looks_like(&cell(sample, k))
            || timestamp::looks_like(&cell(sample, k + 1))
        {
            return None;
        }
        names.extend([format!("{tag}.Time"), tag]);
    }
    (names.len() > 2).then_some(names)
}

/// Whether a record holds samples and not names, that is only numbers, or a date and time.
fn is_samples(record: &StringRecord) -> bool {
    let cells = || record.iter().map(str::trim).filter(|cell| !cell.is_empty());
    cells().all(number::looks_like) || cells().any(timestamp::looks_like)
}

/// Whether a record below the header holds units. It has no sample, and something that is certainly a unit.
fn is_units(record: &StringRecord) -> bool {
    const UNITS: [&str; 44] = [
        "%", "s", "sec", "ms", "min", "h", "hr", "°c", "°f", "k", "degc", "deg c", "degf", "deg f",
        "m3/h", "m³/h", "nm3/h", "l/h", "l/min", "l/s", "kg/h", "kg/s", "t/h", "bar", "barg",
        "bara", "mbar", "pa", "kpa", "mpa", "psi", "psig", "kg/cm2", "ma", "v", "mm", "cm", "m",
        "in", "ph", "ppm", "gpm", "rpm", "pct",
    ];
    let cells = || record.iter().map(str::trim).filter(|cell| !cell.is_empty());
    let bracketed = |cell: &str| {
        [('[', ']'), ('(', ')')].iter().any(|(a, b)| cell.starts_with(*a) && cell.ends_with(*b))
    };
    let unit = |cell: &str| {
        UNITS.contains(&cell.to_lowercase().trim_matches(['[', ']', '(', ')']))
            || (bracketed(cell) && number::word(cell).is_none())
    };
    cells().any(unit)
        && !cells().any(|cell| number::looks_like(cell) || timestamp::looks_like(cell))
}
