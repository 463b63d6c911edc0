//! Makes recordings from a sheet with known columns.

use super::naming::attribute;
use super::times::times;
use crate::cells::number::{self, DecimalMark};
use crate::cells::{mode, quality, range};
use crate::columns::layout::content::Content;
use crate::columns::layout::{LoopPlan, Place, Plan, Recognised};
use crate::columns::options::{ReadOptions, SettingsByName};
use crate::columns::role::{self, Role, Signal};
use crate::error::{Error, Result};
use crate::names::list;
use crate::remedy::{Remedy, Wording};
use crate::sheet::{Column, Sheet, Viewed};
use crate::timestamp::{Clock, Times};
use stiction_recording::recording::{
    Channel, Columns, LoopType, Mode, Modes, PlantTime, Quality, Range, RangeSource, Recording,
    rhythm,
};

/// Makes recordings from a sheet.
pub struct Builder<'a> {
    pub(super) sheet: &'a Sheet,
    pub(super) plan: &'a Plan,
    pub(super) options: &'a ReadOptions,
    settings: SettingsByName<'a>,
    mark: DecimalMark,
    /// Numbers that the user declares as bad, also those among the words.
    bad_values: Vec<f64>,
    pub times: Times,
}

/// The cells of one signal, as a column and its rows.
pub(super) struct Source<'a> {
    column: &'a Column,
    /// Name, of the column or the tag.
    pub(super) name: &'a str,
    pub(super) rows: Vec<usize>,
}

impl<'a> Builder<'a> {
    pub fn new(
        sheet: &'a Sheet,
        plan: &'a Plan,
        options: &'a ReadOptions,
        mark: DecimalMark,
    ) -> Result<Self> {
        let times = times(sheet, plan, options, mark)?;
        let of_words = options.bad_text.iter().filter_map(|word| {
            let word = word.trim();
            number::parse(word, mark).or_else(|| number::parse(word, DecimalMark::Point))
        });
        let bad_values = options.bad_value.iter().copied().chain(of_words).collect();
        let settings = SettingsByName::of(options);
        Ok(Self { sheet, plan, options, settings, mark, bad_values, times })
    }

    /// The cells of the signal or quality with the plan's `name`.
    pub(super) fn source(&self, name: usize) -> Source<'a> {
        match &self.plan.place {
            Place::Columns => {
                let column = &self.sheet.columns[name];
                Source { column, name: &column.name, rows: (0..self.sheet.len()).collect() }
            }
            Place::Rows { tags, value, .. } => {
                let tag = &tags[name];
                let column = &self.sheet.columns[*value];
                Source { column, name: &tag.name, rows: tag.rows.clone() }
            }
        }
    }

    /// Whether each row is a sample of a tag.
    pub(super) fn is_long(&self) -> bool {
        matches!(self.plan.place, Place::Rows { .. })
    }

    fn wrong(&self, source: &Source<'_>, row: usize, message: String) -> Error {
        let column = if source.name == source.column.name {
            source.name.to_owned()
        } else {
            format!("{}\" of \"{}", source.column.name, source.name)
        };
        Error::Cell { origin: self.sheet.origin.clone(), row: self.sheet.row(row), column, message }
    }

    pub fn recording(&self, plan: &LoopPlan, name: String) -> Result<Recording> {
        let settings = self.settings.of_loop(plan.name.as_deref().unwrap_or(&name));
        let refused = |e: stiction_model::Error| Error::Table {
            origin: self.sheet.origin.clone(),
            message: format!("loop {name}: {e}"),
        };
        let mut notes = plan.notes.clone();
        let mut sparse = vec![];
        let mut channel = |signal: Signal| {
            plan.signal(signal)
                .map(|place| self.channel(plan, signal, place, &mut notes, &mut sparse))
                .transpose()
        };
        let op = channel(Signal::Op)?;
        let (mut pv, sp, mut vp) =
            (channel(Signal::Pv)?, channel(Signal::Sp)?, channel(Signal::Vp)?);
        let Some(mut op) = op else {
            let recognised = &self.plan.recognised;
            return Err(no_op(&self.sheet.origin, recognised, self.options.wording));
        };
        let is_sparse = !sparse.is_empty();
        if is_sparse {
            notes.push(format!(
                "empty cells of {} do not count as missing samples, because the spacing of the values shows that the \
                 rows belong to other signals, or that the file stores only changes",
                list(&sparse)
            ));
        }
        let mode = plan.signal(Signal::Mode);
        let mode = mode.map(|place| self.modes(plan, place, is_sparse, &mut notes));
        let mode = mode.transpose()?;

        let told_range = |key: &str| attribute(self.sheet, &[key]).and_then(range::of_text);
        if let Some(pv) = &mut pv {
            let given = settings.pv_range.map(|ends| (ends, RangeSource::Given));
            let told = told_range("pv_range").map(|ends| (ends, RangeSource::Metadata));
            let range = given.or(told).map(|((low, high), source)| Range::new(low, high, source));
            pv.range = range.transpose().map_err(refused)?;
        }
        // Ranges are estimated from measurements alone.
        let known = |given: Option<(f64, f64)>, key: &str| {
            let (low, high) = given.or(told_range(key))?;
            Range::new(low, high, RangeSource::Given).ok()
        };
        op.range = known(settings.op_range, "op_range");
        if let Some(vp) = &mut vp {
            vp.range = known(settings.vp_range, "vp_range");
        }
        let mut recording = Recording {
            name: name.clone(),
            loop_type: LoopType::Unknown,
            start: self.times.start,
            plant_time: PlantTime::default(),
            columns: self.columns(plan),
            op,
            pv,
            sp,
            vp,
            mode,
            notes: vec![],
        };
        self.separate_runs(plan, &mut recording)?;
        notes.append(&mut recording.notes);
        recording.mask();

        notes.extend(self.doubts(plan, &mut recording));
        let (op_range, op_note) = range::of_valve_signal(
            "OP",
            &recording.op,
            settings.op_range,
            told_range("op_range"),
            self.options.wording,
        )
        .map_err(refused)?;
        recording.op.range = op_range;
        notes.extend(op_note);
        if let Some(vp) = &mut recording.vp {
            let (vp_range, vp_note) = range::of_valve_signal(
                "VP",
                vp,
                settings.vp_range,
                told_range("vp_range"),
                self.options.wording,
            )
            .map_err(refused)?;
            vp.range = vp_range;
            notes.extend(vp_note);
        }
        recording.loop_type = match settings.loop_type {
            Some(given) => given,
            None => self.stated_type(&mut notes).unwrap_or_else(|| role::loop_type(&name)),
        };
        recording.plant_time = match (&self.options.zone, self.times.start, &self.times.clock) {
            (Some(zone), Some(start), _) => zone.plant_time(start),
            (None, _, Clock::Local) => PlantTime::unnamed(),
            _ => PlantTime::default(),
        };
        recording.notes = notes;
        Ok(recording)
    }

    /// The columns of a loop.
    fn columns(&self, plan: &LoopPlan) -> Columns {
        let column = |place: usize| &*self.sheet.columns[place].name;
        let name = |signal| {
            plan.signal(signal).map(|place| match &self.plan.place {
                Place::Columns => column(place).to_owned(),
                Place::Rows { tags, .. } => tags[place].name.clone(),
            })
        };
        let time = self.plan.date.into_iter().chain(self.plan.time);
        let time = time.filter(|_| self.options.sample_time.is_none()).map(column);
        let time = time.collect::<Vec<_>>();
        Columns {
            time: Some(time.join(" and ")).filter(|names| !names.is_empty()),
            time_format: self.times.format.clone(),
            zone: self.times.clock.name().to_owned(),
            op: name(Signal::Op),
            pv: name(Signal::Pv),
            sp: name(Signal::Sp),
            vp: name(Signal::Vp),
            mode: name(Signal::Mode),
        }
    }

    /// The type in the file, as a name or as a flag for an integrating loop.
    fn stated_type(&self, notes: &mut Vec<String>) -> Option<LoopType> {
        let told = attribute(self.sheet, &["type", "loop_type"])?;
        let integrating = number::parse(told, DecimalMark::Point);
        let found = match integrating {
            Some(0.0) => Some(LoopType::OtherSelfRegulating),
            Some(1.0) => Some(LoopType::OtherIntegrating),
            _ => LoopType::by_name(told).ok(),
        };
        if found.is_none() {
            notes.push(format!("the file gives the loop type \"{told}\", which is unknown"));
        }
        found
    }

    /// The samples of a signal. If empty cells of its column are no samples, its name is added to `sparse`.
    fn channel(
        &self,
        plan: &LoopPlan,
        signal: Signal,
        place: usize,
        notes: &mut Vec<String>,
        sparse: &mut Vec<&'a str>,
    ) -> Result<Channel> {
        let source = self.source(place);
        let said = self.qualities(plan, signal, &source, notes)?;
        let cells = source.column.cells.view();
        let mut values = Vec::with_capacity(source.rows.len());
        let mut qualities = Vec::with_capacity(source.rows.len());
        for (k, row) in source.rows.iter().enumerate() {
            let said = said.as_ref().map_or(Quality::Good, |said| said[k]);
            let (value, quality) = match &cells {
                Viewed::Text(cells) => self.sample(&source, *row, &cells[*row], said)?,
                Viewed::Numbers(numbers) => match numbers[*row] {
                    value if value.is_nan() => (value, Quality::Missing),
                    value if value.is_infinite() && said.is_usable() => {
                        let message = format!("{value} is not a finite number; correct it");
                        return Err(self.wrong(&source, *row, message));
                    }
                    value => (value, Quality::Good),
                },
                Viewed::Times(_) => {
                    let message = format!("holds a time, but is used as {}", signal.name());
                    return Err(self.wrong(&source, *row, message));
                }
            };
            values.push(value);
            qualities.push(if quality == Quality::Good { said } else { quality });
        }
        let mut time: Vec<f64> = source.rows.iter().map(|row| self.times.seconds[*row]).collect();
        if qualities.contains(&Quality::Missing) && matches!(self.plan.place, Place::Columns) {
            let empty: Vec<bool> = source.rows.iter().map(|row| is_empty(&cells, *row)).collect();
            if rhythm::are_other_rows(&time, &values, &empty) {
                sparse.push(source.name);
                keep(&mut time, &empty);
                keep(&mut values, &empty);
                keep(&mut qualities, &empty);
            }
        }
        let channel = Channel::with_quality(signal.name(), time, values, qualities);
        let mut channel = channel.map_err(|e| Error::Table {
            origin: self.sheet.origin.clone(),
            message: format!("\"{}\": {e}", source.name),
        })?;
        channel.mask_named(&self.bad_values);
        let in_name = || role::without_unit(source.name).1.map(str::to_owned);
        channel.unit = source.column.unit.clone().or_else(in_name);
        Ok(channel)
    }

    /// The value and quality of a cell whose quality is given elsewhere.
    fn sample(
        &self,
        source: &Source<'_>,
        row: usize,
        cell: &str,
        said: Quality,
    ) -> Result<(f64, Quality)> {
        if let Some(value) = number::parse(cell, self.mark) {
            return Ok((value, Quality::Good));
        }
        if let Some(quality) = number::word(cell) {
            return Ok((f64::NAN, quality));
        }
        if !said.is_usable() || self.is_bad_text(cell) {
            return Ok((f64::NAN, Quality::Bad));
        }
        let flagged = number::flagged(cell, self.mark).and_then(|(value, flag)| {
            Some((value, quality::of_flag(flag, &self.options.qualities)?))
        });
        flagged.ok_or_else(|| {
            let (unknown, wording) = (self.unknown_words(cell), self.options.wording);
            self.wrong(source, row, number::refusal(cell, self.mark, unknown, wording))
        })
    }

    fn is_bad_text(&self, cell: &str) -> bool {
        self.options.bad_text.iter().any(|word| word.trim().eq_ignore_ascii_case(cell))
    }

    /// The unknown words of all signals, up to ten, the `first` in front.
    fn unknown_words(&self, first: &str) -> Vec<String> {
        let mut found = vec![number::shown(first)];
        let numeric = [Signal::Op, Signal::Pv, Signal::Sp, Signal::Vp];
        let of_loop =
            |each: &'a LoopPlan| numeric.into_iter().filter_map(|signal| each.signal(signal));
        for source in self.plan.loops.iter().flat_map(of_loop).map(|place| self.source(place)) {
            let Viewed::Text(cells) = source.column.cells.view() else { continue };
            for cell in source.rows.iter().map(|row| &cells[*row]) {
                let is_new = |known: &String| !known.eq_ignore_ascii_case(cell);
                if found.len() < 10
                    && number::is_unknown_word(cell, self.mark)
                    && !self.is_bad_text(cell)
                    && found.iter().all(is_new)
                {
                    found.push(number::shown(cell));
                }
            }
        }
        found
    }

    /// The qualities of the samples of `signal`, if given.
    fn qualities(
        &self,
        plan: &LoopPlan,
        signal: Signal,
        of: &Source<'_>,
        notes: &mut Vec<String>,
    ) -> Result<Option<Vec<Quality>>> {
        let place = match &self.plan.place {
            Place::Columns => plan.quality(signal),
            Place::Rows { quality, .. } => *quality,
        };
        let Some(place) = place else { return Ok(None) };
        let column = &self.sheet.columns[place];
        let read = quality::read(
            &column.name,
            &column.cells,
            &of.rows,
            &self.options.qualities,
            self.mark,
            self.options.wording,
        );
        let read = read.map_err(|(row, message)| Error::Cell {
            origin: self.sheet.origin.clone(),
            row: self.sheet.row(row),
            column: column.name.clone(),
            message,
        })?;
        if let Some(code) = read.code {
            let note =
                format!("the values in \"{}\" are interpreted as {}", column.name, code.name());
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
        Ok(Some(read.qualities))
    }

    /// The mode that a column of modes turns on, if its name and all its cells show a switch and the user gives no
    /// meaning for its cells.
    fn switch(&self, place: usize, source: &Source<'_>, notes: &mut Vec<String>) -> Option<Mode> {
        let (_, mode) = role::split_switch(source.name)?;
        let content = Content { sheet: self.sheet, place: &self.plan.place };
        if !self.options.modes.is_empty() || !content.is_switch(place) {
            return None;
        }
        let (on, off) = match mode {
            Mode::Manual => ("manual", "automatic"),
            Mode::Automatic => ("automatic", "manual"),
            // A loop that is not in cascade may be in automatic or manual.
            _ => return None,
        };
        notes.push(format!(
            "\"{}\" is interpreted as the mode, with 1 {on} and 0 {off}; if it is something else, give {}",
            source.name,
            self.options.wording.of(Remedy::map("ignore", source.name))
        ));
        Some(mode)
    }

    /// The modes. If the table is `sparse`, or most of its modes are empty, an empty cell is no mode.
    fn modes(
        &self,
        plan: &LoopPlan,
        place: usize,
        is_sparse: bool,
        notes: &mut Vec<String>,
    ) -> Result<Modes> {
        let mut source = self.source(place);
        let cells = source.column.cells.view();
        if matches!(self.plan.place, Place::Columns) {
            let full = |row: &usize| !is_empty(&cells, *row);
            let full: Vec<usize> = source.rows.iter().copied().filter(full).collect();
            let is_most = 2 * full.len() < source.rows.len();
            if !full.is_empty() && (is_sparse || is_most) {
                source.rows = full;
            }
        }
        let said = self.qualities(plan, Signal::Mode, &source, notes)?;
        let switch = self.switch(place, &source, notes);
        let (mut modes, mut codes, mut nothing) = (Vec::with_capacity(source.rows.len()), false, 0);
        let numbers = source.rows.iter().filter_map(|row| match &cells {
            Viewed::Text(cells) => number::parse(&cells[*row], self.mark),
            Viewed::Numbers(numbers) | Viewed::Times(numbers) => Some(numbers[*row]),
        });
        let kind = mode::Codes::of(source.name, numbers);
        for (k, row) in source.rows.iter().enumerate() {
            if said.as_ref().is_some_and(|said| !said[k].is_usable()) {
                nothing += 1;
                modes.push(Mode::Other);
                continue;
            }
            let number;
            let (cell, mark) = match &cells {
                Viewed::Text(cells) => (&cells[*row], self.mark),
                Viewed::Numbers(numbers) | Viewed::Times(numbers) => {
                    number = numbers[*row].to_string();
                    (&*number, DecimalMark::Point)
                }
            };
            if let Some((mode, is_on)) = switch.zip(mode::is_on(cell)) {
                modes.push(if is_on { mode } else { mode::switched_off(mode) });
                continue;
            }
            modes.push(match mode::of_cell(cell, &self.options.modes, kind, mark) {
                Some(mode::ModeCell::Mode(mode)) => mode,
                Some(mode::ModeCell::Code(mode)) => {
                    codes = true;
                    mode
                }
                Some(mode::ModeCell::Nothing) => {
                    nothing += 1;
                    Mode::Other
                }
                None => {
                    let cell = number::shown(cell);
                    let message = format!(
                        "\"{cell}\" is not a known mode; give its meaning, as in {}, or leave the mode out, as in {}",
                        self.options.wording.of(Remedy::Mode {
                            word: cell.clone(),
                            modes: vec!["auto", "manual", "cascade"],
                        }),
                        self.options.wording.of(Remedy::map("ignore", source.name))
                    );
                    return Err(self.wrong(&source, *row, message));
                }
            });
        }
        if codes {
            notes.push(format!(
                "mode codes are interpreted as {}; if they mean something else, give their meaning, as in {}",
                kind.words(),
                self.options.wording.of(Remedy::Mode { word: "1".to_owned(), modes: vec!["manual"] })
            ));
        }
        if nothing > 0 {
            notes.push(format!("{nothing} of {} modes are not recorded", modes.len()));
        }
        // Each holds until the next, so a file with the newest row first is turned round.
        let time = source.rows.iter().map(|row| self.times.seconds[*row]);
        let mut all: Vec<(f64, Mode)> = time.zip(modes).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (time, modes) = all.into_iter().unzip();
        Ok(Modes { time, modes })
    }
}

/// Whether nothing is written in a cell.
fn is_empty(cells: &Viewed<'_>, row: usize) -> bool {
    match cells {
        Viewed::Text(cells) => cells[row].is_empty(),
        Viewed::Numbers(numbers) | Viewed::Times(numbers) => numbers[row].is_nan(),
    }
}

/// Keeps the non-empty cells.
fn keep<T>(all: &mut Vec<T>, empty: &[bool]) {
    let mut empty = empty.iter();
    all.retain(|_| !empty.next().copied().unwrap_or(false));
}

/// Whether a column holds times or days. Alone, S is rather an amount of stiction than seconds.
pub fn has_times(recognised: &[Recognised]) -> bool {
    recognised.iter().any(|each| {
        matches!(each.role, Role::Time | Role::Date) && !each.column.eq_ignore_ascii_case("s")
    })
}

/// The error for a file without an OP.
pub fn no_op(origin: &str, recognised: &[Recognised], wording: Wording) -> Error {
    let names: Vec<&str> = recognised.iter().map(|each| &*each.column).collect();
    Error::NoOp {
        origin: origin.to_owned(),
        has_times: has_times(recognised),
        message: format!(
            "has no column known as the controller output (OP); its columns are {}; name the column, as in {}",
            list(&names),
            wording.of(Remedy::map_some("op"))
        ),
    }
}
