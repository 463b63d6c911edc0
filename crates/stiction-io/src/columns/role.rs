//! Recognises the role of a column by its name.

use crate::cells::mode;
use std::fmt;
use stiction_recording::recording::{LoopType, Mode};

/// A signal of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Signal {
    /// Controller output.
    Op,
    /// Process value.
    Pv,
    /// Set point.
    Sp,
    /// Measured valve position.
    Vp,
    /// The controller's mode.
    Mode,
}

impl Signal {
    /// All signals.
    pub const ALL: [Self; 5] = [Self::Op, Self::Pv, Self::Sp, Self::Vp, Self::Mode];

    /// Name, such as `OP`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Op => "OP",
            Self::Pv => "PV",
            Self::Sp => "SP",
            Self::Vp => "VP",
            Self::Mode => "mode",
        }
    }

    /// The signal of a word, without separators and in lower case.
    fn of_word(word: &str) -> Option<Self> {
        Some(match word {
            "op" | "co" | "out" | "output" | "mv" | "cv" | "lmn" | "outv" | "aout" | "cmd"
            | "demand" | "command" | "outputvalue" | "opvalue" | "controlleroutput"
            | "controloutput" | "ctrlout" | "manipulatedvalue" | "valvedemand" | "valvecommand"
            | "valveoutput" | "cveu" | "stellwert" | "stellgrösse" | "stellgroesse" | "sortie"
            | "sortierégulateur" | "sortieregulateur" | "sortievanne" | "sortierégulation"
            | "salida" | "salidacontrolador" | "salidaválvula" | "uscita" | "uscitaregolatore"
            | "uscitavalvola" | "reglerausgang" | "stellsignal" => Self::Op,
            "manipulatedvariable" | "salidadelcontrolador" => Self::Op,
            "pv" | "processvalue" | "processvariable" | "processvar" | "meas" | "measurement"
            | "measuredvalue" | "controlledvariable" | "pvin" | "istwert" | "regelgrösse"
            | "regelgroesse" | "mesure" | "valeurmesurée" | "valeurprocédé" | "medida"
            | "medición" | "medicion" | "valordeproceso" | "variabledeproceso" | "misura"
            | "valoremisurato" | "valorediprocesso" => Self::Pv,
            "variabilediprocesso" => Self::Pv,
            "sp" | "setpoint" | "setpt" | "spt" | "stpt" | "sv" | "setvalue" | "wsp"
            | "workingsetpoint" | "reference" | "spint" | "sollwert" | "führungsgrösse"
            | "fuehrungsgroesse" | "consigne" | "pointdeconsigne" | "consigna"
            | "puntodeajuste" | "valoreimpostato" | "valoredesiderato" => Self::Sp,
            "vp" | "valveposition" | "valvepos" | "zt" | "zi" | "pos" | "position" | "posn"
            | "feedback" | "fb" | "fbk" | "travel" | "stem" | "stemposition" | "stemtravel"
            | "valvetravel" | "actualposition" | "positionfeedback" | "readback" => Self::Vp,
            "mode" | "md" | "modeact" | "modeactual" | "actualmode" | "automan" | "controlmode"
            | "controllermode" | "modblk" | "betriebsart" | "reglermodus" | "modus" | "modo"
            | "mododecontrol" | "modederégulation" | "modemarche" | "modalità" | "modalita"
            | "automanual" | "manualauto" | "manauto" | "manaut" | "qmanaut" | "operatingmode" => {
                Self::Mode
            }
            _ => return None,
        })
    }
}

/// The role of a column or, in a long table, of a tag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The time of the row.
    Time,
    /// The day, beside a time of day.
    Date,
    /// A signal.
    Signal(Signal),
    /// The quality of a signal, or of all signals.
    Quality(Option<Signal>),
    /// The tag of the row, in a long table.
    Tag,
    /// The value, in a long table.
    Value,
    /// Not read.
    Ignored,
}

impl Role {
    /// The names of roles for users, in lower case.
    const NAMES: [(&'static str, Self); 16] = [
        ("time", Self::Time),
        ("date", Self::Date),
        ("op", Self::Signal(Signal::Op)),
        ("pv", Self::Signal(Signal::Pv)),
        ("sp", Self::Signal(Signal::Sp)),
        ("vp", Self::Signal(Signal::Vp)),
        ("mode", Self::Signal(Signal::Mode)),
        ("quality", Self::Quality(None)),
        ("op_quality", Self::Quality(Some(Signal::Op))),
        ("pv_quality", Self::Quality(Some(Signal::Pv))),
        ("sp_quality", Self::Quality(Some(Signal::Sp))),
        ("vp_quality", Self::Quality(Some(Signal::Vp))),
        ("mode_quality", Self::Quality(Some(Signal::Mode))),
        ("tag", Self::Tag),
        ("value", Self::Value),
        ("ignore", Self::Ignored),
    ];

    /// The role of that name.
    pub fn by_name(name: &str) -> Option<Self> {
        let lower = name.to_lowercase();
        Self::NAMES.iter().find(|(known, _)| *known == lower).map(|(_, role)| *role)
    }

    /// The names of all roles, for messages.
    pub fn names() -> String {
        Self::NAMES.map(|(name, _)| name).join(", ")
    }

    /// The name that a user gives for it.
    pub fn option_name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, role)| *role == self).map_or("ignore", |(name, _)| name)
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time => f.write_str("time"),
            Self::Date => f.write_str("date"),
            Self::Signal(signal) => f.write_str(signal.name()),
            Self::Quality(None) => f.write_str("quality"),
            Self::Quality(Some(signal)) => write!(f, "quality of {}", signal.name()),
            Self::Tag => f.write_str("tag"),
            Self::Value => f.write_str("value"),
            Self::Ignored => f.write_str("not used"),
        }
    }
}

/// Separators between the parts of a tag.
pub(crate) const SEPARATORS: [char; 9] = ['.', '_', '/', ':', '\\', ' ', '-', '|', '#'];
/// Words for signals that are ambiguous behind a tag. They count only as a whole name.
const WHOLE: [(&str, Signal); 1] = [("set", Signal::Sp)];
/// Signals that may stand before their tag, as in `PV_FIC101`.
const PREFIXES: [&str; 7] = ["pv", "sp", "op", "vp", "mv", "sv", "mode"];
/// Names of quantities that a process value measures, as a whole name.
const QUANTITIES: &str = "flow flowrate level pressure temperature temp durchfluss füllstand druck temperatur \
    débit niveau pression température caudal nivel presión temperatura portata pressione";

/// The role of a word that describes rows, without separators and in lower case.
fn of_row_word(word: &str) -> Option<Role> {
    Some(match word {
        // Times in files of historians, loggers, simulators and data bases.
        "t" | "ts" | "time" | "times" | "timestamp" | "timestamps" | "tstamp" | "datetime"
        | "dateandtime" | "datetimestamp" | "datestamp" | "datestring" | "timestring"
        | "eventtime" | "eventtimestamp" | "sourcetime" | "sourcetimestamp" | "servertime"
        | "servertimestamp" | "sourcetimeutc" | "picotime" | "localtime" | "localtimestamp"
        | "timestamplocal" | "timestamputc" | "utctimestamp" | "timestamputcms" | "datetimeutc"
        | "datetimelocal" | "sampletime" | "sampletimestamp" | "recordtime" | "recordtimestamp"
        | "recordedtime" | "recordedat" | "receivetime" | "receivedtime" | "acquisitiontime"
        | "measurementtime" | "readtime" | "logtime" | "logdate" | "logdatetime" | "trendtime"
        | "scantime" | "storetime" | "plctime" | "systemtime" | "wallclock" | "clock"
        | "iptrendtime" | "iptime" | "tstime" | "entrytime" | "createdat" | "utc" | "utctime"
        | "timeutc" | "timelocal" | "unixtime" | "unixtimestamp" | "epoch" | "epochtime" | "s"
        | "sec" | "seconds" | "elapsed" | "elapsedtime" | "relativetime" | "reltime" | "timems"
        | "simtime" | "simulationtime" | "timesim" | "tout" | "tsim" | "tspan" | "tvec"
        | "zeit" | "zeitpunkt" | "zeitstempel" | "zeitmarke" | "datumzeit" | "datumuhrzeit"
        | "datumundzeit" | "uhrzeit" | "heure" | "horodatage" | "horodate" | "dateheure"
        | "hora" | "dateethure" | "dateetheure" | "fechahora" | "fechayhora" | "marcadetiempo"
        | "estampadetiempo" | "tiempo" | "temps" | "tempo" | "ora" | "dataora" | "dataeora"
        | "datahora" | "dataehora" | "marcatemporale" | "carimbodetempo" | "tijd" | "tijdstip"
        | "datumtijd" | "tidpunkt" => Role::Time,
        "date" | "datum" | "fecha" | "data" | "dato" | "jour" => Role::Date,
        "tag" | "tagname" | "tagid" | "point" | "pointname" | "item" | "itemid" | "name"
        | "signal" | "varname" | "variablename" | "tagpath" | "pointid" | "nodeid" => Role::Tag,
        // Ignition writes float values beside those of whole numbers.
        "value" | "val" | "tagvalue" | "eventvalue" | "wert" | "varvalue" | "iptrendvalue"
        | "valeur" | "floatvalue" => Role::Value,
        "quality" | "status" | "statuscode" | "confidence" | "qual" | "qualitycode"
        | "opcquality" | "sts" | "qualitystatus" | "qualitydetail" | "validity" | "conf"
        | "qstatus" | "iptrendqstatus" | "dataintegrity" | "qualität" | "qualité"
        | "dataquality" | "samplestatus" | "flags" | "good" | "isgood" | "valid" | "isvalid"
        | "bad" | "isbad" | "invalid" | "questionable" => Role::Quality(None),
        _ => return None,
    })
}

/// Whether a word names a quality.
fn is_quality(word: &str) -> bool {
    of_row_word(word) == Some(Role::Quality(None))
}

/// Whether a name denotes a quality.
pub fn is_of_quality(name: &str) -> bool {
    of_rows(without_number(name)) == Some(Role::Quality(None))
        || split(name, &[]).is_some_and(|split| matches!(split.role, Role::Quality(_)))
}

/// Ends of tags that name the value of a parameter, not another signal.
const VALUE_ENDS: [&str; 7] = ["cv", "value", "val", "pct", "percent", "daca", "fcv"];

/// Words for signals in addition to the common ones: `(signal, words)`.
pub type Words = [(Signal, Vec<String>)];

/// A name without separators, in lower case. ß, which has no common capital, becomes ss.
pub(crate) fn plain(name: &str) -> String {
    name.to_lowercase().replace(SEPARATORS, "").replace('ß', "ss")
}

/// A name, and the unit in brackets at its end.
pub fn without_unit(name: &str) -> (&str, Option<&str>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        let split = name.strip_suffix(close).and_then(|rest| rest.rsplit_once(open));
        if let Some((before, unit)) = split
            && !before.trim().is_empty()
        {
            // The place of a column whose name occurs several times.
            if unit.starts_with("column ") {
                return without_unit(before.trim_end());
            }
            return (before.trim_end(), Some(unit.trim()).filter(|unit| !unit.is_empty()));
        }
    }
    (name, None)
}

/// A name without the place that it has if it occurs several times, as in `Conf (column 3)`.
pub fn without_place(name: &str) -> &str {
    name.rsplit_once(" (column ").map_or(name, |(before, _)| before)
}

/// A name without its unit, and without a number at its end, as in `Time2`, `Time.1` or `Time (column 3)`.
pub fn without_number(name: &str) -> &str {
    let bare = without_unit(name).0;
    let cut = bare.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches(SEPARATORS);
    if cut.is_empty() { bare } else { cut }
}

/// The role of a whole name that describes rows: time, tag, value or quality.
pub fn of_rows(name: &str) -> Option<Role> {
    let word = plain(without_unit(name).0);
    let is_timed = |word: &str| {
        let timed = ["timestamp", "time", "elapsed", "epoch", "t"];
        let unit = timed.iter().find_map(|start| word.strip_prefix(start));
        let units = ["s", "sec", "seconds", "ms", "us", "ns", "min", "h"];
        unit.is_some_and(|unit| units.contains(&unit))
    };
    of_row_word(&word).or_else(|| is_timed(&word).then_some(Role::Time))
}

/// Whether a column with an unknown name may still contain times: the index of a table, or a longer name.
pub fn may_be_time(name: &str) -> bool {
    let word = plain(without_unit(name).0);
    let index = ["index", "level0", "unnamed:0", "unnamed0", "indexlevel0"];
    let parts = ["time", "stamp", "zeit", "heure", "hora", "date", "datum", "fecha", "clock"];
    index.contains(&&*word) || parts.iter().any(|part| word.contains(part))
}

/// The rank of a name of times among several, the best first: the time at the source, then UTC, others, the time at a
/// server, local time, the time of receipt or storage.
pub fn rank_of_time(name: &str) -> usize {
    let word = plain(without_unit(name).0);
    let ranks: [&[&str]; 6] = [
        &["source"],
        &["utc", "gmt"],
        &["server"],
        &["local"],
        &["receive", "record", "created", "store", "log", "entry"],
        &["elapsed", "relative"],
    ];
    let rank = ranks.iter().position(|parts| parts.iter().any(|part| word.contains(part)));
    rank.map_or(2, |rank| if rank < 2 { rank } else { rank + 1 })
}

/// A name split into its parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Split {
    /// The loop; none if the name denotes only a signal.
    pub loop_name: Option<String>,
    /// The signal or quality.
    pub role: Role,
    /// The part of the name that shows the role.
    pub word: String,
}

/// Splits a name such as `FIC101.PV`, `UNIT/FIC101/PID1/PV.CV` or `pv_quality`.
pub fn split(name: &str, more: &Words) -> Option<Split> {
    let name = without_unit(name).0;
    let last = name.rfind(SEPARATORS).map(|at| (&name[..at], plain(&name[at + 1..])));
    let whole = plain(name);
    if let Some((_, signal)) = WHOLE.iter().find(|(word, _)| *word == whole) {
        let role = Role::Signal(*signal);
        return Some(Split { loop_name: None, role, word: name.to_owned() });
    }
    // The longest suffix that only marks a value, such as F_CV.
    let mut ends = name.match_indices(SEPARATORS).map(|(at, _)| (&name[..at], &name[at + 1..]));
    let value = ends.find(|(_, end)| VALUE_ENDS.contains(&&*plain(end)));
    if let Some(split) = split_quality(name, more) {
        return Some(split);
    }
    if let Some((before, _)) = value
        && let Some(split) = split_end(before, more).or_else(|| split_start(before, more))
    {
        return Some(split).filter(|split| !is_no_output(split));
    }
    if let Some(split) = split_end(name, more) {
        // F_CV is the value of the parameter before it, not a CV.
        let is_value = value.is_some_and(|(_, end)| end.len() > split.word.len());
        return Some(split).filter(|split| !is_value && !is_no_output(split));
    }
    if let Some(split) = split_start(name, more) {
        return Some(split);
    }
    let (before, end) = last?;
    is_quality(&end).then(|| Split {
        loop_name: Some(before.to_owned()),
        role: Role::Quality(None),
        word: end,
    })
}

/// Whether a name that ends like an OP denotes a DeltaV parameter, such as `FIC101/PID1/GAIN.CV`, the output of an
/// analog input, such as `FI205/AI1/OUT`, or the manual value of PCS 7, `FIC101/PID.MAN_OP`.
fn is_no_output(split: &Split) -> bool {
    let Some((path, last)) = split.loop_name.as_ref().and_then(|of| of.rsplit_once('/')) else {
        return false;
    };
    let is_digit = |c: char| c.is_ascii_digit();
    let is_parameter = split.word.eq_ignore_ascii_case("cv") && !last.contains(is_digit);
    let is_input = !path.is_empty() && last.trim_end_matches(is_digit).eq_ignore_ascii_case("ai");
    let is_manual = last.to_ascii_lowercase().ends_with(".man");
    split.role == Role::Signal(Signal::Op) && (is_parameter || is_input || is_manual)
}

/// Splits a name that ends with a signal and a word for its quality, such as `FIC101.PV.Status` or `FIC101.PVSTS`.
fn split_quality(name: &str, more: &Words) -> Option<Split> {
    let from = name.rfind(SEPARATORS).map_or(0, |at| at + 1);
    let end = plain(&name[from..]);
    let glued = if name[from..].is_ascii() { end.len() } else { 1 };
    let split = (0..glued).find_map(|at| match &end[at..] {
        // Honeywell's flag of a bad PV.
        "badpvfl" => split_end(&format!("{}pv", &name[..from]), more),
        "st" if at > 0 => None,
        word if is_quality(word) || matches!(word, "q" | "st") => {
            split_end(name[..from + at].trim_end_matches(SEPARATORS), more)
        }
        _ => None,
    })?;
    let Role::Signal(signal) = split.role else { return None };
    Some(Split { role: Role::Quality(Some(signal)), word: name.to_owned(), ..split })
}

/// Splits a name that ends with a signal. The longest suffix counts.
fn split_end(name: &str, more: &Words) -> Option<Split> {
    let starts = std::iter::once(0).chain(name.match_indices(SEPARATORS).map(|(at, _)| at + 1));
    for start in starts {
        let Some(signal) = signal_of(&name[start..], more) else { continue };
        let loop_name = name[..start].trim_end_matches(SEPARATORS);
        return Some(Split {
            loop_name: (!loop_name.is_empty()).then(|| loop_name.to_owned()),
            role: Role::Signal(signal),
            word: name[start..].to_owned(),
        });
    }
    None
}

/// Splits a name such as `PV_FIC101`, where a signal precedes a tag with letters and a number.
fn split_start(name: &str, more: &Words) -> Option<Split> {
    let (word, tag) = name.split_once(SEPARATORS)?;
    let signal = signal_of(word, more).filter(|_| PREFIXES.contains(&&*plain(word)))?;
    let letters = tag.find(|c: char| c.is_ascii_alphabetic())?;
    tag[letters..].contains(|c: char| c.is_ascii_digit()).then(|| Split {
        loop_name: Some(tag.to_owned()),
        role: Role::Signal(signal),
        word: word.to_owned(),
    })
}

/// Whether a name as a whole is a measured quantity, such as `Flow (m3/h)`.
pub fn is_quantity(name: &str) -> bool {
    QUANTITIES.split(' ').any(|word| word == plain(without_unit(name).0))
}

/// Whether a name mentions a measured quantity, such as `Flow 2`.
pub fn has_quantity(name: &str) -> bool {
    let name = plain(name);
    QUANTITIES.split(' ').any(|word| name.contains(word))
}

/// Splits a name such as `FIC101.AUTO` or `FIC101.A/M`, whose 0 and 1 show whether a mode is on.
pub fn split_switch(name: &str) -> Option<(Split, Mode)> {
    let name = without_unit(name).0;
    let mut starts = name.rmatch_indices(SEPARATORS).map(|(at, _)| at + 1).chain([0]);
    let (last, before) = (starts.next(), starts.next());
    // A/M is one word.
    [before, last].into_iter().flatten().find_map(|start| {
        let mode = mode::of_switch(&plain(&name[start..]), start > 0)?;
        let loop_name = name[..start].trim_end_matches(SEPARATORS);
        let loop_name = (!loop_name.is_empty()).then(|| loop_name.to_owned());
        let role = Role::Signal(Signal::Mode);
        Some((Split { loop_name, role, word: name[start..].to_owned() }, mode))
    })
}

fn signal_of(word: &str, more: &Words) -> Option<Signal> {
    let word = plain(word);
    let given = more.iter().find(|(_, words)| words.iter().any(|each| plain(each) == word));
    given.map(|(signal, _)| *signal).or_else(|| Signal::of_word(&word))
}

/// The type of a loop by its tag. In a path the last part with a type counts, so that `[PLC1]FIC101` is a flow and
/// the letters of the PLC do not count.
pub fn loop_type(name: &str) -> LoopType {
    let parts = name.rsplit(['/', '\\', ':', ']', '|', '#']).map(LoopType::of_tag);
    parts.into_iter().find(|kind| *kind != LoopType::Unknown).unwrap_or(LoopType::Unknown)
}

/// The pattern of tags, such as `{loop}.{signal}`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    text: String,
    before: String,
    between: String,
    after: String,
    loop_first: bool,
}

impl std::str::FromStr for Pattern {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "\"{text}\" is not a pattern of tags; write {{loop}} and {{signal}} once each with something between \
                 them, as in \"{{loop}}.{{signal}}\""
            )
        };
        let (l, s) =
            (text.find("{loop}").ok_or_else(wrong)?, text.find("{signal}").ok_or_else(wrong)?);
        let loop_first = l < s;
        let (first, second) = if loop_first { (l..l + 6, s..s + 8) } else { (s..s + 8, l..l + 6) };
        let (before, between) = (&text[..first.start], &text[first.end..second.start]);
        let after = &text[second.end..];
        if between.is_empty() || [before, between, after].iter().any(|t| t.contains(['{', '}'])) {
            return Err(wrong());
        }
        let [before, between, after] = [before, between, after].map(str::to_owned);
        Ok(Self { text: text.to_owned(), before, between, after, loop_first })
    }
}

impl Pattern {
    /// Splits `name`, if it matches the pattern and its signal is known.
    pub fn split(&self, name: &str, more: &Words) -> Option<Split> {
        let name = without_unit(name).0;
        let inner = name.strip_prefix(&*self.before)?.strip_suffix(&*self.after)?;
        inner.match_indices(&*self.between).find_map(|(at, between)| {
            let (a, b) = (&inner[..at], &inner[at + between.len()..]);
            let (loop_name, word) = if self.loop_first { (a, b) } else { (b, a) };
            let signal = signal_of(word, more).filter(|_| !loop_name.is_empty())?;
            Some(Split {
                loop_name: Some(loop_name.to_owned()),
                role: Role::Signal(signal),
                word: word.to_owned(),
            })
        })
    }

    /// The setting as the user wrote it.
    pub fn text(&self) -> &str {
        &self.text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(name: &str) -> Option<(Option<String>, Role)> {
        split(name, &[]).map(|split| (split.loop_name, split.role))
    }

    #[test]
    fn tags_are_taken_apart() {
        use Signal::{Mode, Op, Pv, Sp, Vp};
        for (name, loop_name, signal) in [
            ("pv", None, Pv),
            ("OP [%]", None, Op),
            ("Set Point", None, Sp),
            ("valve_position", None, Vp),
            ("PROCESS_VALUE", None, Pv),
            ("FIC101.PV", Some("FIC101"), Pv),
            ("FIC101_sp", Some("FIC101"), Sp),
            ("unit 2/FIC-101/OUT", Some("unit 2/FIC-101"), Op),
            ("FIC101:MODE", Some("FIC101"), Mode),
            ("\\\\server\\FIC101\\OP", Some("\\\\server\\FIC101"), Op),
            ("FIC101 SET POINT", Some("FIC101"), Sp),
            ("FIC-101-CO (%)", Some("FIC-101"), Op),
            ("UNIT/FIC101/PID1/PV.CV", Some("UNIT/FIC101/PID1"), Pv),
            ("FIC101.CV", Some("FIC101"), Op),
            ("U1/FIC101.CV", Some("U1/FIC101"), Op),
            ("VALVE.CV", Some("VALVE"), Op),
            ("FIC-101/AO1/OUT.CV", Some("FIC-101/AO1"), Op),
            ("AI1.OUT", Some("AI1"), Op),
            ("FIC101.MODE.ACTUAL", Some("FIC101"), Mode),
            ("FIC101.Auto/Manual", Some("FIC101"), Mode),
            ("FIC101/PID.QMAN_AUT", Some("FIC101/PID"), Mode),
            ("FIC101.TRAVEL", Some("FIC101"), Vp),
            ("FC-101/AO1/READBACK.CV", Some("FC-101/AO1"), Vp),
            ("Valve output (%)", None, Op),
            ("Set", None, Sp),
            ("STELLGRÖSSE", None, Op),
            ("Sortie régulateur", None, Op),
            ("FIC101 Mesure (m3/h)", Some("FIC101"), Pv),
            ("Consigna", None, Sp),
            ("FIC2105_OUT", Some("FIC2105"), Op),
            ("FIC2112/PID.LMN#Value", Some("FIC2112/PID"), Op),
            ("OP (column 3)", None, Op),
            ("PV (m3/h) (column 4)", None, Pv),
            ("Stellgröße", None, Op),
            ("Führungsgröße [m³/h]", None, Sp),
            ("FIC101.Sollwert", Some("FIC101"), Sp),
            ("PV_FIC101", Some("FIC101"), Pv),
            ("FIX.FIC101_PV.F_CV", Some("FIX.FIC101"), Pv),
        ] {
            let expected = Some((loop_name.map(str::to_owned), Role::Signal(signal)));
            assert_eq!(told(name), expected, "{name}");
        }
        for (name, loop_name, role) in [
            ("FIC101.PV.Status", Some("FIC101"), Role::Quality(Some(Pv))),
            ("pv_quality", None, Role::Quality(Some(Pv))),
            ("FIC101.Quality", Some("FIC101"), Role::Quality(None)),
            ("FIC101.PV.Conf (column 5)", Some("FIC101"), Role::Quality(Some(Pv))),
            ("FIC101.PVSTS", Some("FIC101"), Role::Quality(Some(Pv))),
            ("FIC101.PV_BAD", Some("FIC101"), Role::Quality(Some(Pv))),
            ("FIC101.BADPVFL", Some("FIC101"), Role::Quality(Some(Pv))),
            ("FIC101.MVQ", Some("FIC101"), Role::Quality(Some(Op))),
            ("PVQuality", None, Role::Quality(Some(Pv))),
        ] {
            assert_eq!(told(name), Some((loop_name.map(str::to_owned), role)), "{name}");
        }
        for name in [
            "flow",
            "FIC101",
            "FI101.X",
            "",
            ".",
            "Temp",
            "p1",
            "data_set",
            "pv_1",
            "out_temp2",
            "FIC101PVQ",
            "FIC101.Q",
            "SPST",
            "FIX.FIC101.F_CV",
            "FIC101/PID1/GAIN.CV",
            "FIC101/PID1/BKCAL_IN.CV",
            "FIC101/PID1/OUT_HI_LIM.CV",
            "FI205/AI1/OUT.CV",
            "FIC101/PID.MAN_OP",
        ] {
            assert_eq!(told(name), None, "{name}");
        }
    }

    #[test]
    fn switches_of_a_mode() {
        for (name, expected) in [
            ("FIC101.AUTO", Some((Some("FIC101"), Mode::Automatic))),
            ("FIC101_MAN", Some((Some("FIC101"), Mode::Manual))),
            ("Hand", Some((None, Mode::Manual))),
            ("CP01:FIC101.MA", Some((Some("CP01:FIC101"), Mode::Automatic))),
            ("U1/FIC101.A/M", Some((Some("U1/FIC101"), Mode::Automatic))),
            ("FIC101_A_M", Some((Some("FIC101"), Mode::Automatic))),
            ("A/M", Some((None, Mode::Automatic))),
            ("mA", None),
            ("FIC101.PV", None),
        ] {
            let found = split_switch(name).map(|(split, mode)| (split.loop_name, mode));
            assert_eq!(found, expected.map(|(tag, mode)| (tag.map(str::to_owned), mode)), "{name}");
        }
    }

    #[test]
    fn types_of_paths() {
        for (name, expected) in [
            ("[PLC1]FIC101", LoopType::Flow),
            ("TC1/LIC7/PID1", LoopType::Level),
            ("PLC1", LoopType::Pressure),
            ("area", LoopType::Unknown),
        ] {
            assert_eq!(loop_type(name), expected, "{name}");
        }
    }

    #[test]
    fn columns_about_rows() {
        for (name, role) in [
            ("t_s", Role::Time),
            ("Time (s)", Role::Time),
            ("TIME_MS", Role::Time),
            ("Time Stamp", Role::Time),
            ("Date", Role::Date),
            ("TagName", Role::Tag),
            ("Value", Role::Value),
            ("StatusCode", Role::Quality(None)),
        ] {
            assert_eq!(of_rows(name), Some(role), "{name}");
        }
        assert_eq!(of_rows("temp"), None);
    }

    #[test]
    fn numbers_and_places_are_no_part_of_a_name() {
        for (name, bare, place) in [
            ("Time2", "Time", "Time2"),
            ("Time.1 (s)", "Time", "Time.1 (s)"),
            ("Conf (column 3)", "Conf", "Conf"),
            ("PV (m3/h) (column 4)", "PV", "PV (m3/h)"),
            ("7", "7", "7"),
        ] {
            assert_eq!((without_number(name), without_place(name)), (bare, place), "{name}");
        }
    }

    #[test]
    fn patterns_go_first() {
        let pattern: Pattern = "plant:{signal}-{loop}".parse().unwrap();
        let words = [(Signal::Pv, vec!["MEAS_VAL".to_owned()])];
        let split = pattern.split("plant:meas_val-FIC-1", &words).unwrap();
        assert_eq!(
            (split.loop_name.as_deref(), split.role),
            (Some("FIC-1"), Role::Signal(Signal::Pv))
        );
        assert_eq!(pattern.split("plant:temp-FIC1", &words), None);
        for wrong in ["{loop}", "{loop}{signal}", "{loop}.{signal}.{x}", ""] {
            assert!(wrong.parse::<Pattern>().is_err(), "{wrong}");
        }
    }
}
