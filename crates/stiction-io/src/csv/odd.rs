//! Rows below the header that are no samples: torn or too long ones, repeated headers, and lines at the end.

use super::top::Top;
use super::{filled, trimmed};
use crate::cells::number;
use crate::texts::Texts;
use crate::timestamp;
use csv::StringRecord;

/// The most lines at the end of a file that are no samples.
const MOST_TRAILERS: usize = 20;

/// The fewest rows of which one may be torn. In larger files it may be one in a hundred.
const FEWEST_ROWS: usize = 10;

/// Rows that are no samples.
#[derive(Default)]
pub struct Odd {
    /// Lines with too few or too many cells, with their text and number of cells.
    unfit: Vec<(usize, String, usize)>,
    /// Lines that repeat the header.
    headers: usize,
}

impl Odd {
    /// Whether a record contains no samples. Such a record is counted.
    pub fn takes(&mut self, line: usize, record: &StringRecord, top: &Top, pads: bool) -> bool {
        let columns = top.names.len();
        let is_short = record.len() < columns && !pads;
        if is_short || filled(record) > columns {
            let text: Vec<&str> = record.iter().take(filled(record)).map(str::trim).collect();
            self.unfit.push((line, text.join(" "), record.len()));
            return true;
        }
        let is_header = top.header.first().is_some_and(|first| **first == *record[0].trim())
            && record.len() == top.header.len()
            && record.iter().map(trimmed).eq(top.header.iter().cloned());
        self.headers += usize::from(is_header);
        is_header
    }

    /// Removes lines at the end that are no samples from the columns, and returns notes on all such rows.
    ///
    /// # Errors
    /// If so many rows are torn or too long that the delimiter must be wrong.
    pub fn notes(
        mut self,
        columns: &mut [Texts],
        rows: &mut Vec<usize>,
    ) -> Result<Vec<String>, String> {
        let mut notes = vec![];
        let mut trailers: Vec<(usize, String)> = vec![];
        let wide = columns.len() > 1;
        while trailers.len() < MOST_TRAILERS && wide && is_trailer(columns, rows.len()) {
            let cells: Vec<String> = last(columns, rows.len()).filter(|c| !c.is_empty()).collect();
            trailers.push((rows.pop().unwrap_or(0), cells.join(" ")));
        }
        columns.iter_mut().for_each(|column| column.truncate(rows.len()));
        let last = rows.last().copied().unwrap_or(0);
        let is_text = |text: &str| !text.starts_with(|c: char| c.is_ascii_digit() || c == '.');
        while let Some((line, text, _)) =
            self.unfit.pop_if(|(line, text, _)| *line > last && is_text(text))
        {
            trailers.push((line, text));
        }
        trailers.sort_unstable();
        match &trailers[..] {
            [] => {}
            [(line, text)] => notes.push(format!(
                "row {line} at the end, \"{}\", holds no sample and is not read",
                number::shown(text)
            )),
            [(line, text), ..] => notes.push(format!(
                "{} rows at the end from row {line} on, \"{}\" and so on, hold no samples and are not read",
                trailers.len(),
                number::shown(text)
            )),
        }
        let most =
            ((rows.len() + self.unfit.len()) / 100).max(usize::from(rows.len() >= FEWEST_ROWS));
        if let Some((line, text, cells)) = self.unfit.first() {
            if self.unfit.len() > most {
                return Err(format!(
                    "row {line} has {cells} cells, but the header has {} columns; give every row the same number of \
                     cells, and put cells that contain the delimiter in quotes",
                    columns.len()
                ));
            }
            notes.push(match self.unfit.len() {
                1 => format!(
                    "row {line}, \"{}\", has {cells} cells instead of {} and is not read",
                    number::shown(text),
                    columns.len()
                ),
                several => format!(
                    "{several} rows do not have {} cells and are not read: {}",
                    columns.len(),
                    lines(&self.unfit)
                ),
            });
        }
        match self.headers {
            0 => {}
            1 => notes.push("one row repeats the header and is not read".to_owned()),
            several => notes.push(format!("{several} rows repeat the header and are not read")),
        }
        Ok(notes)
    }
}

/// The numbers of the first lines.
fn lines(unfit: &[(usize, String, usize)]) -> String {
    const MOST: usize = 8;
    let shown: Vec<String> = unfit.iter().take(MOST).map(|(line, ..)| line.to_string()).collect();
    let more = if unfit.len() > MOST { " and so on" } else { "" };
    format!("rows {}{more}", shown.join(", "))
}

/// The cells of the last of this number of rows.
fn last(columns: &[Texts], rows: usize) -> impl Iterator<Item = String> {
    columns
        .iter()
        .filter_map(move |column| Some(column.view().get(rows.checked_sub(1)?)?.to_owned()))
}

/// Whether the last of this number of rows is no sample. It begins with a word that begins no other row, has no time, and has few
/// cells or is a statistic.
fn is_trailer(columns: &[Texts], rows: usize) -> bool {
    const STATISTICS: &str =
        "total sum average avg mean min max std count end summe mittelwert moyenne fin";
    let Some(above) = rows.checked_sub(1) else { return false };
    let view = columns[0].view();
    let first = &view[above];
    let is_value = first.is_empty()
        || first.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | '+'))
        || number::looks_like(first)
        || timestamp::looks_like(first)
        || number::word(first).is_some();
    if is_value || above == 0 {
        return false;
    }
    let cells = || last(columns, rows).filter(|cell| !cell.is_empty());
    let is_few = cells().count() <= (columns.len() - 1).min(2);
    let word = first.to_lowercase();
    let word = word.trim_start_matches(|c: char| !c.is_alphanumeric());
    let is_statistic = STATISTICS.split(' ').any(|known| word.starts_with(known));
    (is_few || is_statistic)
        && !cells().any(|cell| timestamp::looks_like(&cell))
        && !view.iter().take(above).any(|cell| cell == first)
}
