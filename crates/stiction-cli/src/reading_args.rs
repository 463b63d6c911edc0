//! The options on how files of recordings are interpreted, shared by all commands that read one.

use crate::files::In;
use crate::input;
use anyhow::Result;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use stiction::recording::{LoopType, Mode, Quality};
use stiction_io::number::DecimalMark;
use stiction_io::options::LoopSettings;
use stiction_io::timestamp::{Day, TimeFormat, Zone};
use stiction_io::{ReadOptions, Remedy, Wording, mode, quality};

/// The user's information on the files. All of it is optional.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Interpretation of the files")]
pub struct Reading {
    /// Set the role of a column or tag: op, pv, sp, vp, mode, time, date, tag, value, quality, op_quality and so on, or
    /// ignore. FIC101.op is the role op in the loop FIC101. Or set a key of a mapping file, such as op_range=4,20,
    /// FIC101.op_range=4,20, modes.16=auto, quality.0=good or type=level. May be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    map: Vec<ReadOptions>,
    /// Read further settings on the files from this TOML file [default: the mapping file beside each
    /// recording, such as FIC101.csv.mapping.toml, else an existing stiction.toml]
    #[arg(long, value_name = "FILE")]
    mapping: Option<In>,
    /// Zone of times that state no zone, such as Europe/Berlin or +01:00
    #[arg(long)]
    zone: Option<Zone>,
    /// Format of times: a pattern such as "%d/%m/%Y %H:%M:%S", or day-first, month-first, year-first, epoch-s,
    /// epoch-ms, epoch-us, epoch-ns, dotnet-ticks, filetime, labview, gps, excel, excel-1904, datenum, seconds,
    /// milliseconds, microseconds, nanoseconds, minutes, hours, days
    #[arg(long, value_name = "FORMAT")]
    time_format: Option<TimeFormat>,
    /// Day of the first row, such as 2025-03-14, for times of day without a date
    #[arg(long, value_name = "DAY")]
    date: Option<Day>,
    /// Time between rows in s, instead of a column of times
    #[arg(long, value_name = "SECONDS", value_parser = above_zero)]
    sample_time: Option<f64>,
    /// Read only this sheet of a workbook, or this part of a MATLAB file
    #[arg(long, value_name = "NAME")]
    part: Option<String>,
    /// The values of OP at 0 % and 100 %
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    op_range: Option<(f64, f64)>,
    /// The values of PV at 0 % and 100 %
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    pv_range: Option<(f64, f64)>,
    /// The values of VP at 0 % and 100 %
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    vp_range: Option<(f64, f64)>,
    /// Type of the loops: flow, level, pressure, temperature, analysis, self-regulating, integrating or unknown
    #[arg(long = "type", value_name = "TYPE", value_parser = LoopType::by_name)]
    loop_type: Option<LoopType>,
    /// A word that marks a bad value instead of a number; may be given several times
    #[arg(long, value_name = "WORD", allow_hyphen_values = true)]
    bad_text: Vec<String>,
    /// The decimal mark of numbers, if the file leaves it open: point or comma
    #[arg(long, value_name = "MARK")]
    decimal_mark: Option<DecimalMark>,
    /// The meaning of a word or code for a mode: auto, manual, cascade or other; may be given several times
    #[arg(long = "mode", value_name = "WORD=MODE", value_parser = mode::of_option,
          allow_hyphen_values = true)]
    modes: Vec<(String, Mode)>,
    /// The meaning of a word or code for a quality: good, uncertain or bad; may be given several times
    #[arg(long = "quality", value_name = "WORD=QUALITY", value_parser = quality::of_option,
          allow_hyphen_values = true)]
    qualities: Vec<(String, Quality)>,
    /// A number that is not a measurement, such as -1; may be given several times. -9999 and similar numbers are
    /// recognised
    #[arg(long, value_name = "NUMBER", value_parser = finite, allow_hyphen_values = true)]
    bad_value: Vec<f64>,
}

impl Reading {
    /// The zone of times without one, if given.
    pub fn zone(&self) -> Result<Option<Zone>> {
        Ok(self.options()?.zone)
    }

    /// The options. The command line takes precedence over the mapping file.
    pub fn options(&self) -> Result<ReadOptions> {
        let mapping = match &self.mapping {
            None => settings().map(In::also).transpose()?,
            given => given.clone(),
        };
        self.over(mapping.as_ref())
    }

    /// The options of each file. A mapping beside a file takes precedence over default settings.
    pub fn options_of(&self, files: &[In]) -> Result<Vec<Result<ReadOptions>>> {
        let of_all = self.options()?;
        let of_one = |file: &In| match self.own_mapping(file)? {
            Some(own) => self.over(Some(&own)),
            None => Ok(of_all.clone()),
        };
        Ok(files.iter().map(of_one).collect())
    }

    /// The mapping kept beside a file, if it is to be used.
    fn own_mapping(&self, file: &In) -> Result<Option<In>> {
        if self.mapping.is_some() || file.is_standard() || IGNORED.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let own = ReadOptions::mapping_path(file);
        if !own.is_file() {
            return Ok(None);
        }
        let path = own.display();
        crate::output::note(format!("using {path} (--no-config ignores it)"));
        In::also(own).map(Some)
    }

    /// The options of the command line, completed from a mapping file.
    fn over(&self, mapping: Option<&In>) -> Result<ReadOptions> {
        let given = self.clone();
        let below = mapping.map_or_else(|| Ok(ReadOptions::default()), input::mapping)?;
        // The last of several counts.
        let below = given.map.into_iter().fold(below, |below, each| each.over(below));
        let flags = ReadOptions {
            bad_text: given.bad_text,
            bad_value: given.bad_value,
            zone: given.zone,
            time_format: given.time_format,
            date: given.date,
            sample_time: given.sample_time,
            part: given.part,
            decimal_mark: given.decimal_mark,
            modes: given.modes,
            qualities: given.qualities,
            all: LoopSettings {
                loop_type: given.loop_type,
                op_range: given.op_range,
                pv_range: given.pv_range,
                vp_range: given.vp_range,
            },
            ..ReadOptions::default()
        };
        Ok(ReadOptions { wording: FLAGS, ..flags.over(below) })
    }
}

/// Whether default settings are ignored.
static IGNORED: AtomicBool = AtomicBool::new(false);

/// Ignores default settings from now on.
pub fn ignore_settings() {
    IGNORED.store(true, Ordering::Relaxed);
}

/// The mapping file for all files here or for all of this user: `stiction.toml` in the present folder, else
/// `config.toml` in the folder `stiction` of the user's settings.
fn settings() -> Option<PathBuf> {
    static FOUND: OnceLock<Option<PathBuf>> = OnceLock::new();
    let look = || {
        let of_user = dirs::config_dir().map(|folder| folder.join("stiction/config.toml"));
        let mut places = [Some(PathBuf::from("stiction.toml")), of_user].into_iter().flatten();
        let found = places.find(|path| path.is_file())?;
        let path = found.display();
        crate::output::note(format!("using settings of {path} (--no-config ignores them)"));
        Some(found)
    };
    match IGNORED.load(Ordering::Relaxed) {
        true => None,
        false => FOUND.get_or_init(look).clone(),
    }
}

/// Remedies as options of the command: `--map op=COLUMN`.
const FLAGS: Wording = Wording(|remedy| {
    let (option, value) = (remedy.option().replace('_', "-"), remedy.value());
    if let Remedy::Mode { word, modes: meanings } | Remedy::Quality { word, qualities: meanings } =
        remedy
    {
        let each = meanings.iter().map(|meaning| format!("--{option} \"{word}={meaning}\""));
        return each.collect::<Vec<_>>().join(" or ");
    }
    if let Remedy::BadText(words) = remedy {
        let each = words.iter().map(|word| format!("--{option} \"{word}\""));
        return each.collect::<Vec<_>>().join(" ");
    }
    // A value from the file may contain spaces. A placeholder for the user has none.
    let quoted = match remedy {
        Remedy::Map { column, .. } => column.is_some(),
        Remedy::Part(_) => true,
        Remedy::TimeFormat(ways) => ways.iter().any(|way| way.contains('%')),
        _ => false,
    };
    match value {
        value if value.is_empty() => format!("--{option}"),
        value if quoted => format!("--{option} \"{value}\""),
        value => format!("--{option} {value}"),
    }
});

fn above_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("must be a number above 0".to_owned()),
    }
}

fn finite(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| "must be a number, such as -9999".to_owned())
}

fn range(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once(',').and_then(|(low, high)| {
        let (low, high) = (low.trim().parse::<f64>().ok()?, high.trim().parse::<f64>().ok()?);
        (low.is_finite() && high.is_finite() && low < high).then_some((low, high))
    });
    ends.ok_or_else(|| "must be two numbers, the lower one first, such as 0,100".to_owned())
}
