//! The user's information on a file of recordings.

use crate::cells::number::DecimalMark;
use crate::columns::role::{Pattern, Role, Signal};
use crate::remedy::Wording;
use crate::timestamp::{Day, TimeFormat, Zone};
use std::collections::{HashMap, HashSet};
use stiction_recording::recording::{LoopType, Mode, Quality};

/// The user's information on a file. By default there is none, and everything is recognised.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Columns, or tags of a long table, with a given role.
    pub map: Vec<Mapped>,
    /// Loops with given settings.
    pub loops: Vec<LoopOptions>,
    /// The pattern of tags.
    pub pattern: Option<Pattern>,
    /// Additional words for signals.
    pub signals: Vec<(Signal, Vec<String>)>,
    /// Additional words and codes for modes.
    pub modes: Vec<(String, Mode)>,
    /// Additional words and codes for qualities.
    pub qualities: Vec<(String, Quality)>,
    /// Additional words for bad values instead of numbers.
    pub bad_text: Vec<String>,
    /// The decimal mark of numbers in text.
    pub decimal_mark: Option<DecimalMark>,
    /// Numbers that are no measurements, in every signal.
    pub bad_value: Vec<f64>,
    /// Time zone of local times.
    pub zone: Option<Zone>,
    /// Format of times.
    pub time_format: Option<TimeFormat>,
    /// Day of the first row, for times of day without a date.
    pub date: Option<Day>,
    /// Time between rows, s, instead of a column of times.
    pub sample_time: Option<f64>,
    /// The only part of the file to read, such as a sheet of a workbook.
    pub part: Option<String>,
    /// Settings of every loop without its own in [`ReadOptions::loops`].
    pub all: LoopSettings,
    /// Wording of remedies in messages and notes.
    pub wording: Wording,
    /// The mapping file behind these options, for messages.
    pub mapping: Option<String>,
}

impl ReadOptions {
    /// The options that concern these loops, in lower case, and options for any loop.
    pub fn of_loops(&self, names: &HashSet<String>) -> Self {
        let concerns = |name: &str| names.contains(&name.to_lowercase());
        let mapped = |each: &&Mapped| each.loop_name.as_deref().is_none_or(concerns);
        Self {
            map: self.map.iter().filter(mapped).cloned().collect(),
            loops: self.loops.iter().filter(|each| concerns(&each.name)).cloned().collect(),
            pattern: self.pattern.clone(),
            signals: self.signals.clone(),
            modes: self.modes.clone(),
            qualities: self.qualities.clone(),
            bad_text: self.bad_text.clone(),
            decimal_mark: self.decimal_mark,
            bad_value: self.bad_value.clone(),
            zone: self.zone.clone(),
            time_format: self.time_format.clone(),
            date: self.date,
            sample_time: self.sample_time,
            part: self.part.clone(),
            all: self.all,
            wording: self.wording,
            mapping: self.mapping.clone(),
        }
    }
}

impl ReadOptions {
    /// These options, completed by the options `below`. An option of `below` counts only where these options give no value.
    #[must_use]
    pub fn over(self, below: Self) -> Self {
        fn both<T>(first: Vec<T>, then: Vec<T>) -> Vec<T> {
            first.into_iter().chain(then).collect()
        }
        let mut own = self.loops;
        for each in below.loops {
            match own.iter_mut().find(|known| known.name.eq_ignore_ascii_case(&each.name)) {
                Some(known) => known.settings = known.settings.over(each.settings),
                None => own.push(each),
            }
        }
        Self {
            // The last role of a column counts, and the first meaning of a word.
            map: both(below.map, self.map),
            loops: own,
            pattern: self.pattern.or(below.pattern),
            signals: both(self.signals, below.signals),
            modes: both(self.modes, below.modes),
            qualities: both(self.qualities, below.qualities),
            bad_text: both(below.bad_text, self.bad_text),
            bad_value: both(below.bad_value, self.bad_value),
            zone: self.zone.or(below.zone),
            time_format: self.time_format.or(below.time_format),
            date: self.date.or(below.date),
            sample_time: self.sample_time.or(below.sample_time),
            part: self.part.or(below.part),
            decimal_mark: self.decimal_mark.or(below.decimal_mark),
            all: self.all.over(below.all),
            wording: below.wording,
            mapping: self.mapping.or(below.mapping),
        }
    }
}

/// A column or tag with a given role.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mapped {
    /// The loop; if none, the name of the column decides.
    pub loop_name: Option<String>,
    /// The role.
    pub role: Role,
    /// Name of the column or tag.
    pub column: String,
}

impl std::str::FromStr for Mapped {
    type Err = String;

    /// Reads `ROLE=COLUMN` or `LOOP.ROLE=COLUMN`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (role, column) = text
            .split_once('=')
            .ok_or_else(|| format!("\"{text}\" is not ROLE=COLUMN, such as op=OUT"))?;
        Self::of(role.trim(), column.trim())
    }
}

impl Mapped {
    /// A column with the role `ROLE` or `LOOP.ROLE`.
    ///
    /// # Errors
    /// If no role has this name. The message lists all roles.
    pub fn of(role: &str, column: &str) -> Result<Self, String> {
        let (loop_name, role) = match role.rsplit_once('.') {
            Some((loop_name, role)) => (Some(loop_name.to_owned()), role),
            None => (None, role),
        };
        let known = Role::by_name(role)
            .ok_or_else(|| format!("\"{role}\" is not a role; roles are {}", Role::names()))?;
        Ok(Self { loop_name, role: known, column: column.to_owned() })
    }
}

/// Settings of a loop.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LoopSettings {
    /// Type of the loop.
    pub loop_type: Option<LoopType>,
    /// The values of OP at 0 % and 100 %.
    pub op_range: Option<(f64, f64)>,
    /// The values of PV at 0 % and 100 %.
    pub pv_range: Option<(f64, f64)>,
    /// The values of VP at 0 % and 100 %.
    pub vp_range: Option<(f64, f64)>,
}

impl LoopSettings {
    /// These settings, completed by the settings `below`.
    fn over(self, below: Self) -> Self {
        Self {
            loop_type: self.loop_type.or(below.loop_type),
            op_range: self.op_range.or(below.op_range),
            pv_range: self.pv_range.or(below.pv_range),
            vp_range: self.vp_range.or(below.vp_range),
        }
    }
}

/// Settings of one loop.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LoopOptions {
    /// Name, compared without case.
    pub name: String,
    /// The settings.
    pub settings: LoopSettings,
}

/// The settings of loops by their names.
#[derive(Debug)]
pub(crate) struct SettingsByName<'o> {
    all: LoopSettings,
    own: HashMap<String, &'o LoopSettings>,
}

impl<'o> SettingsByName<'o> {
    pub(crate) fn of(options: &'o ReadOptions) -> Self {
        let mut own = HashMap::with_capacity(options.loops.len());
        for each in &options.loops {
            // The first of several counts.
            own.entry(each.name.to_lowercase()).or_insert(&each.settings);
        }
        Self { all: options.all, own }
    }

    /// The settings of the loop called `name`.
    pub(crate) fn of_loop(&self, name: &str) -> LoopSettings {
        self.own.get(&name.to_lowercase()).copied().copied().unwrap_or_default().over(self.all)
    }
}
