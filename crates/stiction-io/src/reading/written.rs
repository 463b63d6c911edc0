//! Writes down how a file was interpreted, as a mapping file. With it, the file is read again without guesses.

use super::format::sheets;
use super::summary::understood;
use super::{Reading, parse};
use crate::cells::number::{self, DecimalMark};
use crate::cells::{mode, quality};
use crate::columns::layout::{self, LoopPlan, Place, Plan, side_by_side};
use crate::columns::options::ReadOptions;
use crate::columns::role::Signal;
use crate::error::{Error, Result};
use crate::fields::quoted;
use crate::reading::Format;
use crate::sheet::{Sheet, Viewed};
use crate::timestamp::{Clock, TimeFormat};
use std::collections::BTreeMap;
use stiction_recording::recording::{Channel, Range, Recording};

/// The mapping file, in TOML, by which `bytes` are read to the same recordings as with `options`. Each line has its
/// reason as a comment. The mapping was tested: the file is read with it before it is returned.
///
/// # Errors
/// As for [`parse`], or if a mapping file cannot express how the file was read.
pub fn mapping_of(bytes: &[u8], origin: &str, options: &ReadOptions) -> Result<String> {
    let reading = parse(bytes, origin, options)?;
    let (_, sheets, _) = sheets(bytes, origin)?;
    let mut draft = Draft::of(&reading, options);
    let mut recordings = reading.recordings.iter();
    let unfolded: Vec<_> =
        sheets.iter().map(|sheet| side_by_side::unfold(sheet, options)).collect();
    let mut read = vec![];
    for (original, unfolded) in sheets.iter().zip(&unfolded) {
        let (sheet, options) = match unfolded {
            Some(unfolded) => (&unfolded.sheet, &unfolded.options),
            None => (original, options),
        };
        let mut plan = layout::recognise(sheet, options)?;
        if let Some(unfolded) = unfolded {
            unfolded.describe(&mut plan);
        }
        read.push((sheet, options, plan));
    }
    let is_everywhere = |name: &str| {
        read.iter().all(|(.., plan)| plan.recognised.iter().any(|each| each.column == name))
    };
    for (sheet, options, plan) in &read {
        let mark = match reading.format {
            Format::Csv(dialect) => dialect.decimal_mark,
            _ => number::decimal_mark(&sheet.columns).mark,
        };
        draft.columns(sheet, plan, &is_everywhere);
        let loops = plan.loops.iter().filter(|each| each.unread.is_none());
        for (each, recording) in loops.zip(&mut recordings) {
            draft.codes((sheet, mark), plan, each, recording, options);
            draft.of_loop(each, recording, &reading);
        }
        if read.iter().all(|(.., plan)| plan.time.is_none()) && options.sample_time.is_none() {
            draft.sample_time(sheet);
        }
    }
    // One meaning of a code holds for the whole file. Where it does not fit, the reader decides again.
    let mut drafts = vec![draft.clone()];
    for table in [Table::Modes, Table::Quality, Table::Top] {
        let mut lines = draft.lines.clone();
        lines.remove(&table);
        drafts.push(Draft { lines, ..draft.clone() });
    }
    let is_right = |text: &String| {
        let again = ReadOptions::parse(text, origin).and_then(|said| parse(bytes, origin, &said));
        again.is_ok_and(|again| same(&reading, &again))
    };
    drafts.iter().map(Draft::text).find(is_right).ok_or_else(|| Error::Table {
        origin: origin.to_owned(),
        message: "cannot be read by column names alone, for instance because parts have equal names; give options \
                  instead of a mapping file"
            .to_owned(),
    })
}

/// Whether two readings have the same recordings. Notes, and the sources of ranges and zones, may differ.
pub fn same(a: &Reading, b: &Reading) -> bool {
    a.recordings.len() == b.recordings.len()
        && a.recordings.iter().zip(&b.recordings).all(|(a, b)| same_recording(a, b))
}

fn same_recording(a: &Recording, b: &Recording) -> bool {
    // Without a range, OP and VP are percent.
    let percent =
        |range: Option<Range>| range.map_or((0.0, 100.0), |range| (range.low, range.high));
    let ends = |range: Option<Range>| range.map(|range| (range.low, range.high));
    let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let samples = |a: &Channel, b: &Channel| {
        bits(&a.time) == bits(&b.time)
            && bits(&a.values) == bits(&b.values)
            && (&a.quality, &a.unit) == (&b.quality, &b.unit)
    };
    let both = |a: &Option<Channel>,
                b: &Option<Channel>,
                same: &dyn Fn(&Channel, &Channel) -> bool| {
        match (a, b) {
            (Some(a), Some(b)) => same(a, b),
            (a, b) => a.is_none() && b.is_none(),
        }
    };
    let of_valve = |a: &Channel, b: &Channel| samples(a, b) && percent(a.range) == percent(b.range);
    let measured = |a: &Channel, b: &Channel| samples(a, b) && ends(a.range) == ends(b.range);
    (&a.name, a.loop_type, a.start, &a.mode) == (&b.name, b.loop_type, b.start, &b.mode)
        && of_valve(&a.op, &b.op)
        && both(&a.vp, &b.vp, &of_valve)
        && both(&a.pv, &b.pv, &measured)
        && both(&a.sp, &b.sp, &measured)
}

/// A table of a mapping file, in the order in which they are written.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Table {
    /// The keys at the top.
    Top,
    Columns,
    Modes,
    Quality,
    Loop(String),
}

/// A value with its reason; `None` if the file has two different values for its key.
type Line = Option<(String, String)>;

/// A mapping file in the making.
#[derive(Clone)]
struct Draft {
    head: Vec<String>,
    /// The keys of each table, in the order of the file.
    lines: BTreeMap<Table, Vec<(String, Line)>>,
}

impl Draft {
    /// The file as a whole.
    fn of(reading: &Reading, options: &ReadOptions) -> Self {
        // Named one by one, so that a new option is not forgotten here. Roles, ranges and codes are written as found.
        let ReadOptions {
            map: _,
            loops: _,
            pattern: _,
            signals: _,
            modes,
            qualities,
            bad_text,
            bad_value,
            decimal_mark: _,
            zone,
            time_format,
            date,
            sample_time,
            part,
            all: _,
            wording: _,
            mapping: _,
        } = options;
        let mut draft = Self {
            head: vec![
                format!("How {} is read (SHA-256 {}).", reading.origin, reading.sha256),
                "Each line has its reason; correct what is wrong.".to_owned(),
            ],
            lines: BTreeMap::new(),
        };
        let of_loops = reading.recordings.iter().flat_map(|each| &each.notes);
        draft.head.extend(reading.notes.iter().chain(of_loops).map(|note| format!("Note: {note}")));
        let mut top = |key: &str, value: String, why: &str| {
            draft.set(Table::Top, key, value, why);
        };
        if let Some(seconds) = sample_time {
            top("sample_time", decimal(*seconds), "given");
        }
        if !bad_text.is_empty() {
            let words: Vec<String> = bad_text.iter().map(|word| quoted(word)).collect();
            top("bad_text", format!("[{}]", words.join(", ")), "given");
        }
        if !bad_value.is_empty() {
            let values: Vec<String> = bad_value.iter().map(|value| decimal(*value)).collect();
            top("bad_value", format!("[{}]", values.join(", ")), "given");
        }
        if let Some(part) = part {
            top("part", quoted(part), "given");
        }
        if let Some(day) = date {
            top("date", quoted(&day.to_string()), "given");
        }
        if let Format::Csv(dialect) = reading.format {
            top(
                "decimal_mark",
                quoted(dialect.decimal_mark.name()),
                "by the numbers of the file, or given",
            );
        }
        match zone {
            Some(zone) => top("zone", quoted(zone.name()), "given"),
            None if reading.time.clock == Clock::Local => {
                top("zone", quoted("UTC"), "the times have no zone; name the zone of the plant");
            }
            None => {}
        }
        for each in &reading.recordings {
            let described = &each.columns.time_format;
            match (time_format, TimeFormat::name_of(described)) {
                (Some(format), _) => top("time_format", quoted(format.name()), "given"),
                (None, Some(name)) => top("time_format", quoted(name), described),
                (None, None) => {}
            }
        }
        for (word, mode) in modes {
            draft.set(Table::Modes, word, quoted(name_of(&mode::NAMES, *mode)), "given");
        }
        for (word, quality) in qualities {
            draft.set(Table::Quality, word, quoted(name_of(&quality::NAMES, *quality)), "given");
        }
        draft
    }

    fn set(&mut self, table: Table, key: &str, value: String, why: &str) {
        let lines = self.lines.entry(table).or_default();
        match lines.iter_mut().find(|(known, _)| known == key) {
            None => lines.push((key.to_owned(), Some((value, why.to_owned())))),
            Some((_, line)) => *line = line.take().filter(|(before, _)| *before == value),
        }
    }

    /// The role of each column and tag. A column that only some parts of the file have would be missed in the remaining
    /// parts.
    fn columns(&mut self, sheet: &Sheet, plan: &Plan, is_everywhere: &dyn Fn(&str) -> bool) {
        let is_left_out = |name: &str| sheet.left_out.iter().any(|each| each.name == name);
        let is_written = |name: &str| !is_left_out(name) && is_everywhere(name);
        for each in plan.recognised.iter().filter(|each| is_written(&each.column)) {
            let role = each.role.option_name();
            let role = match &each.loop_name {
                Some(loop_name) if role != "ignore" => format!("{loop_name}.{role}"),
                _ => role.to_owned(),
            };
            self.set(Table::Columns, &each.column, quoted(&role), &each.why);
        }
    }

    /// The meaning of the codes of modes and qualities that a loop has.
    fn codes(
        &mut self,
        (sheet, mark): (&Sheet, DecimalMark),
        plan: &Plan,
        of: &LoopPlan,
        recording: &Recording,
        options: &ReadOptions,
    ) {
        let place = |name: usize| match &plan.place {
            Place::Columns => (&sheet.columns[name].cells, (0..sheet.len()).collect()),
            Place::Rows { tags, value, .. } => {
                (&sheet.columns[*value].cells, tags[name].rows.clone())
            }
        };
        for signal in Signal::ALL {
            let Some((_, rows)) = of.signal(signal).map(place) else { continue };
            let said = match &plan.place {
                Place::Columns => of.quality(signal),
                Place::Rows { quality, .. } => *quality,
            };
            let Some(said) = said.map(|place| &sheet.columns[place]) else { continue };
            let (words, wording) = (&options.qualities, options.wording);
            let read = quality::read(&said.name, &said.cells, &rows, words, mark, wording).ok();
            let Some((code, read)) = read.and_then(|read| Some((read.code?, read.qualities)))
            else {
                continue;
            };
            let cells = said.cells.view();
            for (row, quality) in rows.iter().zip(read) {
                if let Cell::Number(number) = Cell::of(&cells, *row, mark) {
                    let value = quoted(name_of(&quality::NAMES, quality));
                    self.set(Table::Quality, &number, value, code.name());
                }
            }
        }
        let Some((cells, mut rows)) = of.signal(Signal::Mode).map(place) else { return };
        let modes = recording.mode.as_ref().map_or(&[][..], |modes| &modes.modes);
        let cells = cells.view();
        if let (Viewed::Text(cells), true) = (&cells, rows.len() > modes.len()) {
            // Empty cells were rows of other signals.
            rows.retain(|row: &usize| !cells[*row].is_empty());
        }
        for (row, mode) in rows.iter().zip(modes) {
            let (Cell::Number(cell) | Cell::Word(cell)) = Cell::of(&cells, *row, mark);
            // A word that is known is no guess. A word that is not known is the position of a switch.
            let said = mode::of_cell(&cell, &options.modes, mode::Codes::Common, mark);
            if let Some(mode::ModeCell::Code(_)) | None = said {
                let value = quoted(name_of(&mode::NAMES, *mode));
                self.set(Table::Modes, &cell, value, "a common mode code or switch");
            }
        }
    }

    /// Type and ranges of a loop.
    fn of_loop(&mut self, plan: &LoopPlan, recording: &Recording, reading: &Reading) {
        let table = match &plan.name {
            None if reading.recordings.len() == 1 => Table::Top,
            name => Table::Loop(name.clone().unwrap_or_else(|| recording.name.clone())),
        };
        let why = match plan.name {
            Some(_) => "by the letters of its tag, by the file, or given",
            None => "by the name of the file, by the file, or given",
        };
        self.set(table.clone(), "type", quoted(recording.loop_type.name()), why);
        for row in understood(recording, &reading.time.clock) {
            let (key, range) = match row.signal {
                "OP" => ("op_range", Some(&recording.op)),
                "VP" => ("vp_range", recording.vp.as_ref()),
                "PV" => ("pv_range", recording.pv.as_ref()),
                _ => continue,
            };
            let range = range.and_then(|channel| channel.range);
            let (low, high) = match range {
                Some(range) => (range.low, range.high),
                None if row.signal == "PV" => continue,
                None => (0.0, 100.0),
            };
            let ends = format!("[{}, {}]", decimal(low), decimal(high));
            let (_, why) = row.range.split_once(", ").unwrap_or_default();
            self.set(table.clone(), key, ends, why);
        }
    }

    fn sample_time(&mut self, sheet: &Sheet) {
        if let Some(seconds) = sheet.sample_time {
            self.set(Table::Top, "sample_time", decimal(seconds), "from the file");
        }
    }

    fn text(&self) -> String {
        let mut text: String =
            self.head.iter().map(|line| format!("# {}\n", plain(line))).collect();
        for (table, lines) in &self.lines {
            text += &match table {
                Table::Top => String::new(),
                Table::Columns => "\n[columns]\n".to_owned(),
                Table::Modes => "\n[modes]\n".to_owned(),
                Table::Quality => "\n[quality]\n".to_owned(),
                Table::Loop(name) => format!("\n[loop.{}]\n", quoted(name)),
            };
            for (key, line) in lines {
                text += &match line {
                    Some((value, why)) => format!("{} = {value}  # {}\n", key_of(key), plain(why)),
                    None => format!("# {} has several meanings in this file\n", plain(key)),
                };
            }
        }
        text
    }
}

/// A cell, as a mapping file names it.
enum Cell {
    Number(String),
    Word(String),
}

impl Cell {
    fn of(cells: &Viewed<'_>, row: usize, mark: DecimalMark) -> Self {
        let number = match cells {
            Viewed::Numbers(numbers) | Viewed::Times(numbers) => Some(numbers[row]),
            Viewed::Text(cells) => number::parse(&cells[row], mark),
        };
        match (number, cells) {
            (Some(number), _) if number.is_finite() => Self::Number(number.to_string()),
            (_, Viewed::Text(cells)) => Self::Word(cells[row].to_string()),
            _ => Self::Word(String::new()),
        }
    }
}

/// The name of a choice in a mapping file.
fn name_of<T: PartialEq>(names: &[(&'static str, T)], choice: T) -> &'static str {
    names.iter().find(|(_, each)| *each == choice).map_or("", |(name, _)| name)
}

/// A key as TOML writes it.
fn key_of(key: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if key.chars().all(is_bare) && !key.is_empty() { key.to_owned() } else { quoted(key) }
}

/// A number as TOML writes it. An integer has no decimal point, unless it exceeds the integers of TOML.
fn decimal(value: f64) -> String {
    if value.abs() < 1e15 { value.to_string() } else { format!("{value:?}") }
}

/// A text without characters that end a comment.
fn plain(text: &str) -> String {
    text.replace(char::is_control, " ")
}
