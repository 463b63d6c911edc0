//! Chooses the column of times by its name and by what it does to the rows.
//!
//! A column is a good clock if its cells are times that mostly ascend (or descend) and neither stay nor repeat. Of
//! columns with a known name the good ones come first. Without one, a column of dates without a known name is used.

use super::about_rows::AboutRows;
use super::given::Given;
use crate::cells::number::{self, DecimalMark};
use crate::columns::role::{self, Role};
use crate::names::list;
use crate::remedy::Remedy;
use crate::sheet::{Cells, Sheet, Viewed};
use crate::timestamp::{is_epoch, scan, time_of_day};
use std::collections::HashSet;

/// Rows are examined in three blocks of this many, at the beginning, in the middle and at the end.
const BLOCK: usize = 64;

/// The share of steps back, or of steps that stay, up to which a column is a good clock.
const MOST_BACK: f64 = 0.25;
const MOST_EQUAL: f64 = 0.5;

/// A column is better than another if it has this many times as many different times.
const MORE_TIMES: f64 = 1.1;

/// The kind of a column's cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Dates, with times of day unless all are midnight.
    Dates { only_days: bool },
    /// Times of day.
    TimesOfDay,
    /// Numbers. `is_epoch` is true if their magnitude shows that they are dates.
    Numbers { is_epoch: bool },
}

/// What a column does to the rows if it is the time.
#[derive(Debug, Clone, Copy)]
struct Clock {
    kind: Kind,
    is_good: bool,
    /// Whether every step is positive.
    ascends: bool,
}

/// Chooses among the columns with the role of a time or date, and the columns without a role.
pub fn choose(sheet: &Sheet, found: &mut AboutRows, given: &Given<'_>) {
    if sheet.is_empty() || given.options.sample_time.is_some() || found.is_given(Role::Time) {
        return;
    }
    let is_long = found.of(Role::Tag).is_some() && found.of(Role::Value).is_some();
    let clock = |column: usize| Clock::of(&sheet.columns[column].cells, is_long);
    let name = |column: usize| &*sheet.columns[column].name;
    let of = |role: Role| -> Vec<usize> {
        found.roles.iter().filter(|(_, each)| *each == role).map(|(column, _)| *column).collect()
    };
    let (named, days) = (of(Role::Time), of(Role::Date));
    let wording = given.options.wording;
    let use_it = |column: usize| wording.of(Remedy::map("time", name(column)));

    // A date with times of day is a time.
    let is_day = |column: &usize| {
        found.is_given(Role::Date)
            || clock(*column).is_some_and(|clock| clock.kind == Kind::Dates { only_days: true })
            || is_day_number(&sheet.columns[*column].cells)
    };
    let is_whole = |column: &usize| !is_day(column) && clock(*column).is_some();
    let whole_days: Vec<usize> = days.iter().copied().filter(is_whole).collect();
    let day = days.iter().copied().find(is_day);
    let candidates: Vec<usize> = named.iter().chain(&whole_days).copied().collect();
    let is_good = |column: &usize| {
        let good = clock(*column).filter(|clock| clock.is_good);
        // Beside days, times of day may repeat from day to day.
        good.is_some()
            || (day.is_some() && clock(*column).is_some_and(|clock| clock.kind == Kind::TimesOfDay))
    };
    let mut good: Vec<usize> = candidates.iter().copied().filter(is_good).collect();
    let mut notes = vec![];
    if good.is_empty() {
        let free = |column: &usize| {
            let name = name(*column);
            !found.roles.iter().any(|(each, _)| each == column)
                && given.mapped(name).is_none()
                && role::split(name, &given.options.signals).is_none()
        };
        let fits = |column: &usize| {
            clock(*column).is_some_and(|clock| match clock.kind {
                Kind::Dates { only_days: true } => false,
                Kind::Dates { .. } | Kind::TimesOfDay => clock.is_good,
                Kind::Numbers { is_epoch } => {
                    clock.is_good
                        && clock.ascends
                        && (is_epoch
                            || role::may_be_time(name(*column))
                                && !is_count(&sheet.columns[*column].cells))
                }
            })
        };
        good = (0..sheet.columns.len()).filter(free).filter(fits).collect();
        // Only a day beside a named time of day helps more than it.
        if let (Some(chosen), false) = (best(sheet, &good, clock), good.is_empty()) {
            let known = match &candidates[..] {
                [] if day.is_some() => "the column of dates has only days".to_owned(),
                [] => "no column has a known name for times".to_owned(),
                _ => {
                    let names: Vec<&str> = candidates.iter().map(|column| name(*column)).collect();
                    format!("{} cannot be the time of the rows", list(&names))
                }
            };
            notes.push(format!("\"{}\" is interpreted as the time, because {known}", name(chosen)));
        }
    }
    let chosen = match best(sheet, &good, clock) {
        Some(chosen) => chosen,
        // No column is good, so the first known name has its say.
        None => match candidates.first().or(day.as_ref()).or(days.first()) {
            Some(first) => *first,
            None => return,
        },
    };
    let spare = days.iter().filter(|column| Some(**column) != day && !whole_days.contains(column));
    let rivals = if good.is_empty() { &candidates } else { &good };
    let others: Vec<usize> =
        rivals.iter().chain(spare).copied().filter(|column| *column != chosen).collect();
    if !others.is_empty() {
        let names: Vec<&str> = others.iter().map(|column| name(*column)).collect();
        notes.push(format!(
            "\"{}\" is used as the time instead of {}; to use another column, give {}",
            name(chosen),
            list(&names),
            use_it(others[0])
        ));
    }
    let rejected: Vec<&str> = candidates
        .iter()
        .filter(|column| {
            candidates.contains(&chosen) && !rivals.contains(column) && **column != chosen
        })
        .map(|column| name(*column))
        .collect();
    if !rejected.is_empty() {
        notes.push(format!(
            "\"{}\" is used as the time, because {} cannot be the time of the rows",
            name(chosen),
            list(&rejected)
        ));
    }
    // A day completes a time of day.
    let is_of_day = clock(chosen).is_some_and(|clock| clock.kind == Kind::TimesOfDay);
    let unnamed_day = || {
        let is_day = |column: &usize| {
            *column != chosen
                && clock(*column).is_some_and(|clock| clock.kind == Kind::Dates { only_days: true })
        };
        (0..sheet.columns.len()).find(is_day)
    };
    let day = day.or_else(|| if is_of_day { unnamed_day() } else { None });
    let day = day.filter(|column| *column != chosen);
    let given_day = found.is_given(Role::Date);
    found.roles.retain(|(_, role)| *role != Role::Time && (*role != Role::Date || given_day));
    found.roles.push((chosen, Role::Time));
    if let Some(day) = day.filter(|_| !given_day) {
        found.roles.push((day, Role::Date));
    }
    // Other good clocks are no signals.
    found.roles.extend(
        others.into_iter().filter(|other| Some(*other) != day).map(|other| (other, Role::Ignored)),
    );
    found.roles.sort_by_key(|(column, _)| *column);
    found.notes = notes;
}

/// The best of several good clocks. More distinct times decide first, then dates, then the name.
fn best(sheet: &Sheet, good: &[usize], clock: impl Fn(usize) -> Option<Clock>) -> Option<usize> {
    if good.len() < 2 {
        return good.first().copied();
    }
    let counts: Vec<usize> =
        good.iter().map(|column| different(&sheet.columns[*column].cells)).collect();
    let most = counts.iter().copied().max().unwrap_or(0) as f64;
    let enough = good.iter().zip(counts).filter(|(_, count)| *count as f64 * MORE_TIMES >= most);
    let rank = |column: &usize| {
        let is_dated = clock(*column).is_some_and(|clock| {
            matches!(clock.kind, Kind::Dates { .. } | Kind::Numbers { is_epoch: true })
        });
        (!is_dated, role::rank_of_time(&sheet.columns[*column].name))
    };
    enough.map(|(column, _)| *column).min_by_key(rank)
}

/// The number of different cells.
fn different(cells: &Cells) -> usize {
    match cells {
        Cells::Text(cells) => cells.view().iter().collect::<HashSet<_>>().len(),
        Cells::Numbers(cells) | Cells::Times { seconds: cells, .. } => {
            cells.iter().map(|cell| cell.to_bits()).collect::<HashSet<_>>().len()
        }
    }
}

/// Whether numbers are whole days, of spreadsheets or as in 20250314.
fn is_day_number(cells: &Cells) -> bool {
    let is_day = |cell: &f64| {
        cell.fract() == 0.0
            && ((20_000.0..80_000.0).contains(cell) || (19_700_101.0..21_000_101.0).contains(cell))
    };
    match cells {
        Cells::Numbers(cells) => !cells.is_empty() && cells.iter().all(is_day),
        Cells::Text(cells) => {
            let number = |cell: &str| number::parse(cell, DecimalMark::Point);
            !cells.is_empty()
                && cells.view().iter().all(|cell| number(cell).is_some_and(|cell| is_day(&cell)))
        }
        Cells::Times { .. } => false,
    }
}

/// Whether numbers count rows, from 0 or 1 on.
fn is_count(cells: &Cells) -> bool {
    let view = cells.view();
    let number = |row: usize| match &view {
        Viewed::Numbers(cells) => Some(cells[row]),
        Viewed::Text(cells) => number::parse(&cells[row], DecimalMark::Point),
        Viewed::Times(_) => None,
    };
    let first = (!cells.is_empty()).then(|| number(0)).flatten();
    first.is_some_and(|first| {
        (first == 0.0 || first == 1.0)
            && (0..cells.len().min(BLOCK)).all(|row| number(row) == Some(first + row as f64))
    })
}

impl Clock {
    /// `None` if the cells are not times.
    fn of(cells: &Cells, is_long: bool) -> Option<Self> {
        let count = cells.len();
        let begins = [0, (count / 2).max(BLOCK), count.saturating_sub(BLOCK).max(2 * BLOCK)];
        let blocks = begins.map(|begin| begin.min(count)..(begin + BLOCK).min(count));
        let (mut kind, mut times, mut only_days): (Option<Kind>, Vec<Vec<f64>>, bool) =
            (None, vec![], true);
        let view = cells.view();
        let (mut unread, mut all) = (0, 0);
        for block in blocks {
            let mut of_block = vec![];
            for row in block {
                all += 1;
                let read = match &view {
                    Viewed::Times(seconds) => {
                        Some((Kind::Dates { only_days: false }, seconds[row]))
                    }
                    Viewed::Numbers(cells) => Some((Kind::Numbers { is_epoch: false }, cells[row])),
                    Viewed::Text(cells) => text(&cells[row]),
                };
                let read = read.filter(|(_, at)| at.is_finite());
                let Some((of_cell, at)) =
                    read.filter(|(of_cell, _)| kind.is_none_or(|kind| like(kind, *of_cell)))
                else {
                    unread += 1;
                    continue;
                };
                kind = kind.or(Some(of_cell));
                only_days &= matches!(of_cell, Kind::Dates { only_days: true });
                of_block.push(at);
            }
            times.push(of_block);
        }
        let kind = match kind? {
            Kind::Dates { .. } => Kind::Dates {
                only_days: match cells {
                    Cells::Times { .. } => times.iter().flatten().all(|at| at % 86_400.0 == 0.0),
                    _ => only_days,
                },
            },
            Kind::Numbers { .. } => {
                let all: Vec<f64> = times.iter().flatten().copied().collect();
                Kind::Numbers { is_epoch: is_epoch(&all) }
            }
            Kind::TimesOfDay => Kind::TimesOfDay,
        };
        let steps =
            || times.iter().flat_map(|block| block.windows(2)).map(|pair| pair[1] - pair[0]);
        let count = steps().count().max(1) as f64;
        let share = |is: fn(f64) -> bool| steps().filter(|step| is(*step)).count() as f64 / count;
        let (back, forward) = (share(|step| step < 0.0), share(|step| step > 0.0));
        let equal = share(|step| step == 0.0);
        let moves = times.iter().flatten().any(|at| Some(at) != times[0].first());
        let is_good = unread * 10 <= all
            && (moves || all < 2)
            && (is_long || equal <= MOST_EQUAL)
            && back.min(forward) <= MOST_BACK;
        Some(Self {
            kind,
            is_good,
            ascends: unread == 0 && (forward == 1.0 || (is_long && back == 0.0)),
        })
    }
}

fn like(a: Kind, b: Kind) -> bool {
    std::mem::discriminant(&a) == std::mem::discriminant(&b)
}

/// The kind and time of a cell, s on any clock.
fn text(cell: &str) -> Option<(Kind, f64)> {
    if let Some(stamp) = scan(cell) {
        let civil = stamp.orders().next().and_then(|order| stamp.civil(order))?;
        let at = civil.duration_since(jiff::civil::DateTime::ZERO).as_secs_f64();
        return Some((Kind::Dates { only_days: stamp.is_day() }, at));
    }
    if let Some(time) = time_of_day(cell) {
        return Some((Kind::TimesOfDay, time.rough()));
    }
    let number = number::parse(cell, DecimalMark::Point)
        .or_else(|| number::parse(cell, DecimalMark::Comma))?;
    Some((Kind::Numbers { is_epoch: false }, number))
}
