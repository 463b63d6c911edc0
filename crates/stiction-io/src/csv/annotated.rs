//! The CSV of InfluxDB, as `influx query --raw` and the web page of InfluxDB export it. It contains several tables
//! below each other. Each table has a header and, in the annotated form, rows that begin with `#group`, `#datatype` and
//! `#default`.
//!
//! The tables become one. With `_value`, each row is a sample. Its signal is named by the values of `_measurement`, and
//! by the tags and `_field` that distinguish the signals. Without `_value`, the data were pivoted, and the columns are
//! the signals.

use super::{Records, filled, trimmed};
use crate::budget::Budget;
use crate::cells::number;
use crate::columns::role::{self, Role};
use crate::names::list;
use crate::sheet::{Cells, Column, Sheet};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

const TIME: &str = "_time";
const VALUE: &str = "_value";
const FIELD: &str = "_field";
const MEASUREMENT: &str = "_measurement";

/// Columns that describe the query and no signal.
const OF_THE_QUERY: [&str; 5] = ["", "result", "table", "_start", "_stop"];

const ANNOTATIONS: [&str; 3] = ["#group", "#datatype", "#default"];

/// Whether a text is of InfluxDB, by its first record.
pub(super) fn is(text: &str) -> bool {
    let Some(first) = text.split(['\r', '\n']).find(|line| !line.trim().is_empty()) else {
        return false;
    };
    let mut cells = first.split(',').map(|cell| cell.trim().trim_matches('"'));
    ANNOTATIONS.iter().any(|annotation| first.starts_with(&format!("{annotation},")))
        || first.starts_with(",result,table,")
        || cells.any(|cell| cell == TIME)
        || first.trim_start_matches(',').starts_with("error,reference")
}

/// The header and annotations of a table.
#[derive(Debug, Default)]
struct Head {
    names: Vec<String>,
    types: Vec<String>,
    groups: Vec<bool>,
    defaults: Vec<String>,
}

impl Head {
    fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|each| each == name)
    }

    /// Whether a column may name signals: text that is no value. Without annotations, the whole file decides.
    fn may_name(&self, place: usize) -> bool {
        let name = &*self.names[place];
        let is_text = match self.types.get(place) {
            Some(kind) => kind == "string",
            None => true,
        };
        let is_group = self.groups.get(place).copied().unwrap_or(true) || name == FIELD;
        name != TIME && name != VALUE && !OF_THE_QUERY.contains(&name) && is_text && is_group
    }
}

/// A row, with the place of its table.
struct Row {
    table: usize,
    line: usize,
    cells: Vec<Arc<str>>,
}

/// The sheet of a text of InfluxDB.
pub(super) fn read(text: &str, budget: &mut Budget) -> Result<Sheet, String> {
    let (heads, rows) = tables(text, budget)?;
    if rows.is_empty() {
        return Err(
            "has no row of samples; query a time at which the signals were recorded".to_owned()
        );
    }
    let used: BTreeSet<usize> = rows.iter().map(|row| row.table).collect();
    for (head, line) in used.iter().map(|table| (&heads[*table].0, heads[*table].1)) {
        if head.place(TIME).is_none() {
            return Err(format!(
                "has a table below row {line} without the column \"_time\"; its columns are {}; keep _time in the query",
                list(&head.names.iter().map(|name| &**name).collect::<Vec<_>>())
            ));
        }
    }
    let is_long = used.iter().any(|table| heads[*table].0.place(VALUE).is_some());
    let heads: Vec<Head> = heads.into_iter().map(|(head, _)| head).collect();
    let labels = Labels::of(&heads, &rows);
    let mut sheet = match is_long || labels.names.len() > 1 {
        true => long(&heads, &rows, &labels, budget)?,
        false => wide(&heads, &rows, &labels),
    };
    let keys: Vec<&str> = labels.keys.iter().map(|key| &**key).collect();
    if used.len() > 1 || !keys.is_empty() {
        let named = match &keys[..] {
            [] => String::new(),
            keys => format!("; its signals are named by {}", list(keys)),
        };
        sheet.notes.push(format!("the file is CSV of InfluxDB with {} tables{named}", used.len()));
    }
    Ok(sheet)
}

type Tables = (Vec<(Head, usize)>, Vec<Row>);

/// The headers with their lines, and all rows.
fn tables(text: &str, budget: &mut Budget) -> Result<Tables, String> {
    let mut records = Records::new(text, b',');
    let (mut heads, mut rows): Tables = (vec![], vec![]);
    let mut words: HashMap<String, Arc<str>> = HashMap::new();
    let mut coming: Option<Head> = None;
    while let Some((line, record)) = records.next()? {
        let cells = || record.iter().map(trimmed);
        let first = record[0].trim();
        if ANNOTATIONS.contains(&first) {
            let head = coming.get_or_insert_default();
            match first {
                "#group" => head.groups = cells().map(|cell| cell == "true").collect(),
                "#datatype" => head.types = cells().collect(),
                _ => {
                    head.defaults = cells().collect();
                    head.defaults[0].clear();
                }
            }
            continue;
        }
        let bare = || record.iter().map(str::trim);
        let is_header = coming.is_some()
            || heads.is_empty()
            || bare().any(|cell| cell == TIME)
            || first.is_empty() && bare().nth(1) == Some("result")
            || bare().find(|cell| !cell.is_empty()) == Some("error") && filled(record) <= 3;
        if is_header {
            let head = Head { names: cells().collect(), ..coming.take().unwrap_or_default() };
            heads.push((head, line));
            continue;
        }
        let Some((head, _)) = heads.last() else { continue };
        if head.names.iter().find(|name| !name.is_empty()).is_some_and(|name| name == "error") {
            let place = head.place("error").unwrap_or(0);
            let message = record.get(place).unwrap_or("");
            return Err(format!(
                "row {line} is an error of the query, not a sample: \"{}\"; correct the query and export it again",
                number::shown(message)
            ));
        }
        if record.len() < head.names.len() || filled(record) > head.names.len() {
            return Err(format!(
                "row {line} has {} cells, but its header has {} columns; export the data again, or remove the row",
                record.len(),
                head.names.len()
            ));
        }
        let bytes: usize = record.iter().map(|cell| cell.len() + 2 * size_of::<Arc<str>>()).sum();
        budget.spend(bytes).map_err(|message| format!("row {line} {message}"))?;
        let mut cell = |(place, cell): (usize, &str)| -> Arc<str> {
            let cell = match cell.trim() {
                "" => head.defaults.get(place).map_or("", String::as_str),
                cell => cell,
            };
            if !head.may_name(place) {
                return cell.into();
            }
            if let Some(known) = words.get(cell) {
                return Arc::clone(known);
            }
            let new: Arc<str> = cell.into();
            words.insert(cell.to_owned(), Arc::clone(&new));
            new
        };
        let cells = record.iter().take(head.names.len()).enumerate().map(&mut cell).collect();
        rows.push(Row { table: heads.len() - 1, line, cells });
    }
    Ok((heads, rows))
}

/// The columns that name the signals, and the names of the rows.
struct Labels {
    keys: Vec<String>,
    /// The different names.
    names: BTreeSet<String>,
    of_rows: Vec<Arc<str>>,
    /// All columns that could name signals.
    naming: BTreeSet<String>,
    /// The loop of all signals, if a column gives it.
    of_all: Option<String>,
    quality: Option<String>,
}

impl Labels {
    fn of(heads: &[Head], rows: &[Row]) -> Self {
        // The values of all columns that may name signals, by their names.
        let mut values: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        let mut quality = None;
        let places: Vec<Vec<(&str, usize)>> = heads
            .iter()
            .map(|head| {
                let all = 0..head.names.len();
                all.filter(|place| head.may_name(*place))
                    .map(|place| (&*head.names[place], place))
                    .collect()
            })
            .collect();
        for row in rows {
            for (name, place) in &places[row.table] {
                if role::of_rows(name) == Some(Role::Quality(None)) {
                    quality = Some((*name).to_owned());
                    continue;
                }
                values.entry(*name).or_default().insert(&row.cells[*place]);
            }
        }
        let is_pivoted = heads.iter().all(|head| head.place(VALUE).is_none());
        // Without types, numbers name no signals, and after a pivot a column with the name of a signal is one.
        let has_types = heads.iter().all(|head| !head.types.is_empty());
        values.retain(|name, texts| {
            let is_number = |text: &&str| number::looks_like(text) || number::word(text).is_some();
            let is_signal = is_pivoted && role::split(name, &[]).is_some();
            has_types || !is_signal && !texts.iter().all(is_number)
        });
        let order = |name: &&str| match *name {
            MEASUREMENT => 0,
            FIELD => 2,
            _ => 1,
        };
        let cell = |row: &Row, key: &str| -> Arc<str> {
            let place =
                places[row.table].iter().find(|(name, _)| *name == key).map(|(_, place)| *place);
            place.map_or_else(|| "".into(), |place| Arc::clone(&row.cells[place]))
        };
        let count = |keys: &[&str]| {
            let names =
                rows.iter().map(|row| keys.iter().map(|key| cell(row, key)).collect::<Vec<_>>());
            names.collect::<BTreeSet<_>>().len()
        };
        let mut keys: Vec<&str> =
            values.iter().filter(|(_, texts)| texts.len() > 1).map(|(name, _)| *name).collect();
        keys.sort_by_key(order);
        // Keys that distinguish nothing further, those without digits first.
        let has_digits =
            |key: &&str| values[key].iter().any(|text| text.contains(|c: char| c.is_ascii_digit()));
        let all = count(&keys);
        let mut doubtful: Vec<&str> = keys.iter().copied().filter(|key| *key != FIELD).collect();
        doubtful.sort_by_key(|key| (has_digits(key), *key != MEASUREMENT));
        for key in doubtful {
            let rest: Vec<&str> = keys.iter().copied().filter(|each| *each != key).collect();
            if !rest.is_empty() && count(&rest) == all {
                keys = rest;
            }
        }
        let joined = |row: &Row, keys: &[&str]| {
            let parts: Vec<Arc<str>> =
                keys.iter().map(|key| cell(row, key)).filter(|part| !part.is_empty()).collect();
            parts.iter().map(|part| &**part).collect::<Vec<_>>().join(".")
        };
        // Signals without a loop have its name in a column that is the same in all rows.
        let is_bare =
            |name: &str| role::split(name, &[]).is_some_and(|split| split.loop_name.is_none());
        let all_bare = rows.first().is_some_and(|row| is_bare(&joined(row, &keys)));
        let mut constant: Vec<&str> = values
            .iter()
            .filter(|(name, texts)| {
                texts.len() == 1 && **name != FIELD && **name != "host" && has_digits(name)
            })
            .map(|(name, _)| *name)
            .collect();
        constant.sort_by_key(order);
        let of_all = constant.first().map(|key| values[key].iter().copied().collect::<String>());
        if keys.is_empty() && !is_pivoted || all_bare {
            keys.splice(0..0, constant.into_iter().take(1));
            if keys.is_empty() {
                keys.extend([FIELD, MEASUREMENT].into_iter().find(|key| values.contains_key(key)));
            }
        }
        let mut known: HashMap<String, Arc<str>> = HashMap::new();
        let of_rows: Vec<Arc<str>> = rows
            .iter()
            .map(|row| {
                let name = joined(row, &keys);
                Arc::clone(known.entry(name).or_insert_with_key(|name| (&**name).into()))
            })
            .collect();
        let names = known.into_keys().collect();
        let naming = values.keys().map(|name| (*name).to_owned()).collect();
        let keys = keys.into_iter().map(str::to_owned).collect();
        Self { keys, names, of_rows, naming, of_all, quality }
    }
}

fn text(name: &str, cells: Vec<Arc<str>>) -> Column {
    Column { name: name.to_owned(), unit: None, cells: Cells::Text(cells.into()) }
}

/// A sheet with a row for each sample.
fn long(
    heads: &[Head],
    rows: &[Row],
    labels: &Labels,
    budget: &mut Budget,
) -> Result<Sheet, String> {
    let (mut times, mut tags, mut values, mut qualities, mut lines) =
        (vec![], vec![], vec![], vec![], vec![]);
    let mut known: HashMap<(Arc<str>, &str), Arc<str>> = HashMap::new();
    for (row, label) in rows.iter().zip(&labels.of_rows) {
        let head = &heads[row.table];
        let Some(time) = head.place(TIME) else { continue };
        let quality = labels.quality.as_ref().and_then(|name| head.place(name));
        let mut push = |tag: Arc<str>, value: &Arc<str>| {
            times.push(Arc::clone(&row.cells[time]));
            tags.push(tag);
            values.push(Arc::clone(value));
            qualities
                .push(quality.map_or_else(|| "".into(), |place| Arc::clone(&row.cells[place])));
            lines.push(row.line);
        };
        if let Some(value) = head.place(VALUE) {
            push(Arc::clone(label), &row.cells[value]);
            continue;
        }
        budget.spend(row.cells.len() * 4 * size_of::<Arc<str>>())?;
        for (place, name) in head.names.iter().enumerate() {
            let is_signal = name != TIME
                && !OF_THE_QUERY.contains(&&**name)
                && Some(name) != labels.quality.as_ref()
                && !labels.naming.contains(name);
            if is_signal && !row.cells[place].is_empty() {
                let tag =
                    known.entry((Arc::clone(label), name.as_str())).or_insert_with(
                        || match &**label {
                            "" => name.as_str().into(),
                            label => format!("{label}.{name}").into(),
                        },
                    );
                push(Arc::clone(tag), &row.cells[place]);
            }
        }
    }
    let mut columns = vec![text(TIME, times), text("tag", tags), text(VALUE, values)];
    if let Some(name) = &labels.quality {
        columns.push(text(name, qualities));
    }
    Ok(Sheet { columns, rows: lines, ..Sheet::default() })
}

/// A sheet with a column for each signal.
fn wide(heads: &[Head], rows: &[Row], labels: &Labels) -> Sheet {
    let mut names: Vec<&str> = vec![];
    for head in heads {
        let own = head.names.iter().map(|name| &**name).filter(|name| !OF_THE_QUERY.contains(name));
        let own: Vec<&str> =
            own.filter(|name| !names.contains(name) && !labels.naming.contains(*name)).collect();
        names.extend(own);
    }
    let column = |name: &&str| {
        let places: Vec<Option<usize>> = heads.iter().map(|head| head.place(name)).collect();
        let cell = |row: &Row| match places[row.table] {
            Some(place) => Arc::clone(&row.cells[place]),
            None => "".into(),
        };
        text(name, rows.iter().map(cell).collect())
    };
    Sheet {
        columns: names.iter().map(column).collect(),
        rows: rows.iter().map(|row| row.line).collect(),
        attributes: labels.of_all.iter().map(|name| ("loop".to_owned(), name.clone())).collect(),
        ..Sheet::default()
    }
}
