//! Tables in which every signal has a clock of its own: time, value, time, value and so on. They are read as a long
//! table.

use super::given::Given;
use super::neighbours::by_letter;
use super::plan::{Layout, Plan, Recognised};
use crate::cells::number;
use crate::columns::options::{Mapped, ReadOptions};
use crate::columns::role::{self, Role, SEPARATORS};
use crate::names::list;
use crate::sheet::{Cells, Column, LeftOut, Sheet, Viewed};
use crate::timestamp;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// Words at the end or beginning of the name of a signal's clock.
const CLOCK_WORDS: &str =
    "time timestamp t ts x valuex zeit zeitstempel datetime horodatage fecha tempo";
/// Words at the end or beginning of the name of a signal's values.
const VALUE_WORDS: &str = "value val v y valuey wert valeur valore";

/// A clock, as columns.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Clock {
    time: usize,
    /// The columns of values, each with the name of its signal and its quality.
    values: Vec<(usize, String, Option<usize>)>,
}

/// A table with several clocks as a long table.
pub struct Unfolded {
    /// The long table.
    pub sheet: Sheet,
    /// The user's information, with the names of the long table.
    pub options: ReadOptions,
    /// The clocks: the column of times, and its signals.
    clocks: Vec<(String, Vec<String>)>,
}

/// The long form of a table with a clock for each signal; `None` for any other table.
pub fn unfold(sheet: &Sheet, options: &ReadOptions) -> Option<Unfolded> {
    let names: Vec<&str> = sheet.columns.iter().map(|column| &*column.name).collect();
    let clocks = clocks(&names, options);
    let is_clock = |clock: &Clock| counts(&sheet.columns[clock.time].cells);
    if clocks.is_empty() || !clocks.iter().all(is_clock) {
        return None;
    }
    // Several values beside one clock are a table with a time for each row.
    if clocks.len() == 1 && clocks[0].values.len() > 1 {
        return None;
    }
    let times: Vec<&Column> = clocks.iter().map(|clock| &sheet.columns[clock.time]).collect();
    let values: Vec<(usize, &str, Option<usize>)> = clocks
        .iter()
        .flat_map(|clock| &clock.values)
        .map(|(column, tag, quality)| (*column, &**tag, *quality))
        .collect();
    let time_of: HashMap<usize, usize> = clocks
        .iter()
        .flat_map(|clock| clock.values.iter().map(|(value, ..)| (*value, clock.time)))
        .collect();
    let mut places: Vec<(usize, Rc<str>, Option<usize>, usize)> = vec![];
    for (column, tag, quality) in &values {
        let own = &sheet.columns[*column];
        let tag: Rc<str> = match &own.unit {
            Some(unit) if role::without_unit(tag).1.is_none() => format!("{tag} [{unit}]").into(),
            _ => Rc::from(*tag),
        };
        let (time, values) = (sheet.columns[time_of[column]].cells.view(), own.cells.view());
        let is_there = |row: &usize| !(is_nothing(&time, *row) && is_nothing(&values, *row));
        let rows = (0..sheet.len()).filter(is_there);
        places.extend(rows.map(|row| (*column, Rc::clone(&tag), *quality, row)));
    }
    let time_name = match &times[..] {
        [one] => one.name.clone(),
        several => several.iter().map(|time| &*time.name).collect::<Vec<_>>().join(" / "),
    };
    let of = |name: &str, cells: Cells| Column { name: name.to_owned(), unit: None, cells };
    let mut columns = vec![
        of("tag", Cells::Text(places.iter().map(|place| &*place.1).collect())),
        Column {
            unit: times[0].unit.clone(),
            ..of(&time_name, gathered(sheet, places.iter().map(|p| Some((time_of[&p.0], p.3)))))
        },
        of("value", gathered(sheet, places.iter().map(|place| Some((place.0, place.3))))),
    ];
    if values.iter().any(|(_, _, quality)| quality.is_some()) {
        let cells = places.iter().map(|place| place.2.map(|quality| (quality, place.3)));
        columns.push(of("quality", gathered(sheet, cells)));
    }
    let used: HashSet<usize> = clocks
        .iter()
        .map(|clock| clock.time)
        .chain(values.iter().flat_map(|(column, _, quality)| [Some(*column), *quality]).flatten())
        .collect();
    let given = Given::of(options);
    let is_left = |(i, name): &(usize, &&str)| {
        !used.contains(i) && given.mapped(name).is_none_or(|mapped| mapped.role != Role::Ignored)
    };
    let left_out = names.iter().enumerate().filter(is_left).map(|(_, name)| LeftOut {
        name: (*name).to_owned(),
        why: "has no column of times, unlike other columns".to_owned(),
        holds_samples: true,
    });
    let long = Sheet {
        columns,
        rows: places.iter().map(|place| sheet.row(place.3)).collect(),
        origin: sheet.origin.clone(),
        part: sheet.part.clone(),
        sample_time: None,
        attributes: sheet.attributes.clone(),
        left_out: sheet.left_out.iter().cloned().chain(left_out).collect(),
        notes: sheet.notes.clone(),
    };
    let tags: HashMap<String, &str> =
        values.iter().map(|(column, tag, _)| (names[*column].to_lowercase(), *tag)).collect();
    let map = options.map.iter().filter_map(|mapped| {
        let name = mapped.column.to_lowercase();
        let is_here = names.iter().any(|known| known.to_lowercase() == name);
        match tags.get(&name) {
            Some(tag) => Some(Mapped { column: (*tag).to_owned(), ..mapped.clone() }),
            None if is_here || matches!(mapped.role, Role::Time | Role::Ignored) => None,
            None => Some(mapped.clone()),
        }
    });
    let time = Mapped { loop_name: None, role: Role::Time, column: time_name };
    let options = ReadOptions { map: map.chain([time]).collect(), ..options.clone() };
    let clocks = clocks
        .into_iter()
        .map(|clock| {
            let tags = clock.values.into_iter().map(|(_, tag, _)| tag).collect();
            (names[clock.time].to_owned(), tags)
        })
        .collect();
    Some(Unfolded { sheet: long, options, clocks })
}

impl Unfolded {
    /// Describes the columns of the file instead of the columns of the long table.
    pub fn describe(&self, plan: &mut Plan) {
        plan.layout = Layout::SideBySide;
        let columns = self.sheet.columns.len();
        let clock = |(name, tags): &(String, Vec<String>)| {
            let tags: Vec<&str> = tags.iter().map(|tag| &**tag).collect();
            Recognised {
                part: self.sheet.part.clone(),
                column: name.clone(),
                role: Role::Time,
                loop_name: None,
                why: format!("it holds the times of {}", list(&tags)),
            }
        };
        plan.recognised.splice(..columns, self.clocks.iter().map(clock));
        plan.notes.push(format!(
            "the file has {} columns of times; each signal is read with the times beside the signal or with the same name",
            self.clocks.len()
        ));
    }
}

/// Whether names show that signals have clocks of their own.
pub fn has_clocks(names: &[&str], options: &ReadOptions) -> bool {
    !clocks(names, options).is_empty()
}

/// The clocks of a table, by the names of its columns. None if all rows have one clock.
fn clocks(names: &[&str], options: &ReadOptions) -> Vec<Clock> {
    let given = Given::of(options);
    let role = |i: usize| given.mapped(names[i]).map(|mapped| mapped.role);
    let told: Vec<usize> = (0..names.len()).filter(|i| role(*i) == Some(Role::Time)).collect();
    let is_single = told.len() == 1 || options.sample_time.is_some();
    if is_single
        || by_letter(names).iter().any(Option::is_some)
        || options.map.iter().any(|each| matches!(each.role, Role::Tag | Role::Value))
    {
        return vec![];
    }
    // A long table, such as that of IP.21 with NAME, IP_TREND_TIME and IP_TREND_VALUE.
    let has = |role: Role| names.iter().any(|name| role::of_rows(name) == Some(role));
    if has(Role::Tag) && has(Role::Value) {
        return vec![];
    }
    let is_free = |i: &usize| role(*i).is_none();
    let mut clocks = if told.is_empty() { by_name(names, is_free) } else { vec![] };
    let taken: HashSet<usize> = clocks
        .iter()
        .flat_map(|clock| clock.values.iter().map(|(value, ..)| *value).chain([clock.time]))
        .collect();
    let plain: Vec<usize> = match told.is_empty() {
        true => alike(names, |i| is_free(i) && !taken.contains(i)),
        false => told,
    };
    let is_value = |i: &usize| {
        !plain.contains(i)
            && !taken.contains(i)
            && role(*i) != Some(Role::Ignored)
            && !role::is_of_quality(names[*i])
    };
    if plain.len() > 1 || (!clocks.is_empty() && plain.len() == 1) {
        // A clock stands to the left of its signals, or to the right if the first column is a signal.
        let values: Vec<usize> = (0..names.len()).filter(is_value).collect();
        let is_right = plain[0] > 0
            && plain.last() == Some(&(names.len() - 1))
            && values.first().is_some_and(|first| *first < plain[0]);
        let beside: Vec<Clock> = (0..plain.len())
            .map(|k| {
                let (from, to) = match is_right {
                    true => (if k == 0 { 0 } else { plain[k - 1] + 1 }, plain[k]),
                    false => (plain[k] + 1, plain.get(k + 1).copied().unwrap_or(names.len())),
                };
                let own = values.iter().filter(|i| (from..to).contains(*i));
                let values = own.map(|i| (*i, names[*i].to_owned(), None)).collect();
                Clock { time: plain[k], values }
            })
            .collect();
        let each_has_some = beside.iter().all(|clock| !clock.values.is_empty());
        if !each_has_some && clocks.is_empty() {
            return vec![];
        }
        clocks.extend(beside.into_iter().filter(|clock| !clock.values.is_empty()));
    }
    // A single name such as `op_t` beside a common clock may be a signal.
    if clocks.len() == 1
        && (0..names.len())
            .any(|i| i != clocks[0].time && role::of_rows(names[i]) == Some(Role::Time))
    {
        return vec![];
    }
    for (value, tag, quality) in clocks.iter_mut().flat_map(|clock| &mut clock.values) {
        let right =
            names.get(*value + 1).filter(|name| role::is_of_quality(name)).map(|_| *value + 1);
        let named = |(_, name): &(usize, &&str)| {
            role::split(name, &[]).is_some_and(|split| matches!(split.role, Role::Quality(_)))
                && name.to_lowercase().starts_with(&tag.to_lowercase())
        };
        *quality = names.iter().enumerate().find(named).map(|(i, _)| i).or(right);
    }
    clocks.sort_by_key(|clock| clock.time);
    clocks
}

/// Columns of times with a shared name, such as `Time`, `Time2` and `Time3`. Empty if other time columns exist.
fn alike(names: &[&str], is_free: impl Fn(&usize) -> bool) -> Vec<usize> {
    let stem = |i: usize| role::without_number(names[i]).to_lowercase();
    let is_time = |i: &usize| {
        let stem = stem(*i);
        // T1 and T2 are temperatures.
        let is_numbered = stem != names[*i].to_lowercase() && !names[*i].contains("(column ");
        role::of_rows(&stem) == Some(Role::Time) && !(is_numbered && stem.len() < 3)
    };
    let times: Vec<usize> = (0..names.len()).filter(is_free).filter(is_time).collect();
    let same = |i: &usize| times.first().is_some_and(|first| stem(*first) == stem(*i));
    if times.iter().all(same) { times } else { vec![] }
}

/// Clocks named after their signals, such as `FIC1.PV.Time` beside `FIC1.PV.Value` or `FIC1.PV_t` beside `FIC1.PV`.
fn by_name(names: &[&str], is_free: impl Fn(&usize) -> bool) -> Vec<Clock> {
    let mut signals: HashMap<String, (usize, String)> = HashMap::new();
    for (i, name) in names.iter().enumerate() {
        let bare = role::without_unit(name).0;
        let named = parted(bare, VALUE_WORDS).map_or(bare, |signal| signal);
        let tag = if named.len() < bare.len() { named } else { *name };
        // A whole name goes before one whose end is taken off.
        signals.entry(bare.to_lowercase()).or_insert((i, (*name).to_owned()));
        signals.entry(named.to_lowercase()).or_insert((i, tag.to_owned()));
    }
    let clock = |i: usize| {
        let signal = parted(role::without_unit(names[i]).0, CLOCK_WORDS)?;
        let (value, tag) = signals.get(&signal.to_lowercase())?;
        // In a table of samples, the value has no name of its own.
        let is_signal = role::of_rows(signal).is_none() && *value != i;
        is_signal.then(|| Clock { time: i, values: vec![(*value, tag.clone(), None)] })
    };
    let mut clocks: Vec<Clock> = (0..names.len()).filter(is_free).filter_map(clock).collect();
    let mut seen = HashSet::new();
    clocks.retain(|clock| seen.insert(clock.values[0].0));
    clocks
}

/// A name without one of the `words` at its end or beginning.
fn parted<'n>(name: &'n str, words: &str) -> Option<&'n str> {
    let is_word = |part: &str| words.split(' ').any(|word| word == part.to_lowercase());
    let (before, end) = name.rsplit_once(SEPARATORS)?;
    if is_word(end) {
        return Some(before.trim_end_matches(SEPARATORS)).filter(|rest| !rest.is_empty());
    }
    let (start, rest) = name.split_once(SEPARATORS)?;
    // A single letter in front may be anything.
    (start.len() > 2 && is_word(start))
        .then(|| rest.trim_start_matches(SEPARATORS))
        .filter(|rest| !rest.is_empty())
}

/// Whether cells can be times of a clock: times or numbers, of which the last differs from the first.
fn counts(cells: &Cells) -> bool {
    match cells {
        Cells::Times { .. } => true,
        Cells::Numbers(numbers) => {
            let mut known = numbers.iter().filter(|number| number.is_finite());
            let first = known.next();
            first.is_some() && known.next_back().is_none_or(|last| Some(last) != first)
        }
        Cells::Text(cells) => {
            let cells = cells.view();
            let mut known = cells.iter().filter(|cell| number::word(cell).is_none());
            let Some(first) = known.next() else { return false };
            let last = known.next_back();
            let is_time = |cell: &str| {
                cell.starts_with(|c: char| c.is_ascii_digit()) || timestamp::looks_like(cell)
            };
            is_time(first) && last.is_none_or(|last| is_time(last) && last != first)
        }
    }
}

/// Whether a cell is empty, or a word for a missing value.
fn is_nothing(cells: &Viewed<'_>, row: usize) -> bool {
    match cells {
        Viewed::Numbers(numbers) | Viewed::Times(numbers) => numbers[row].is_nan(),
        Viewed::Text(cells) => {
            cells[row].is_empty()
                || number::word(&cells[row])
                    == Some(stiction_recording::recording::Quality::Missing)
        }
    }
}

/// Cells of several columns in a new order. Columns of one kind stay of that kind. Mixed columns become text.
fn gathered(sheet: &Sheet, places: impl Iterator<Item = Option<(usize, usize)>> + Clone) -> Cells {
    let cells = |column: usize| &sheet.columns[column].cells;
    let columns: HashSet<usize> = places.clone().flatten().map(|(column, _)| column).collect();
    let numbers =
        |place: Option<(usize, usize)>| match place.map(|(column, row)| (cells(column), row)) {
            Some((Cells::Numbers(numbers) | Cells::Times { seconds: numbers, .. }, row)) => {
                numbers[row]
            }
            _ => f64::NAN,
        };
    if columns.iter().all(|column| matches!(cells(*column), Cells::Numbers(_))) {
        return Cells::Numbers(places.map(numbers).collect());
    }
    for zone in [false, true] {
        if columns.iter().all(|c| matches!(cells(*c), Cells::Times { utc, .. } if *utc == zone)) {
            return Cells::Times { seconds: places.map(numbers).collect(), utc: zone };
        }
    }
    let views: HashMap<usize, Viewed<'_>> =
        columns.iter().map(|column| (*column, cells(*column).view())).collect();
    let text = |place: Option<(usize, usize)>| match place {
        None => Cow::Borrowed(""),
        Some((column, row)) => views[&column].text(row),
    };
    Cells::Text(places.map(text).collect())
}
