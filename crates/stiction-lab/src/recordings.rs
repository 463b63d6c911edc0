//! Recordings: what is open, how it was read, and the verdict on any stretch of it.
//!
//! Files and folders that the lab was opened with are read when they are asked for; what is dropped on the page is kept in
//! memory. A file is asked for by a name that the lab gave it, never by a path. The verdict on a whole recording is that of
//! `stiction diagnose`, and of a stretch that of the same samples alone, as `stiction history` cuts them.

mod files;
mod mapping;
mod routes;
mod trend;

pub(crate) use files::Room;
pub(crate) use routes::routes;

use crate::calls::{Answer, Wrong};
use crate::lab::Lab;
use crate::loops::{self, Nothing};
use files::{Entry, File};
use mapping::Mapping;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use stiction_diagnose::diagnose::{DiagnoseOptions, Diagnosis, VerdictClass, diagnose};
use stiction_diagnose::recording::{LoopType, Recording};
use stiction_io::overrides::{self, Date, Override, Overrides, Scope};
use stiction_io::summary::Summary;
use stiction_io::{Reading, role::Role, scenario};
use stiction_report::document::{Loop, Source};
use stiction_report::report::{self, Folds, Told, told::Piece};

/// What is open.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Recordings {
    /// The files, in their order.
    files: Vec<Entry>,
    /// The most that a file which is dropped may hold, bytes.
    most_dropped: u64,
    /// What a loop can control.
    loop_types: Vec<&'static str>,
    /// What a column can be.
    roles: Vec<String>,
    /// What can be concluded of a valve.
    verdicts: Vec<&'static str>,
}

/// What is open; folders are looked through again.
///
/// # Errors
/// Never.
pub fn list(lab: &Lab, _: Nothing) -> Answer<Recordings> {
    let files = lab.recordings.files().iter().map(|file| file.entry()).collect();
    Ok(Recordings {
        files,
        most_dropped: routes::DROPPED as u64,
        loop_types: LoopType::NAMES.map(|(name, _)| name).into(),
        roles: Role::names().split(", ").map(str::to_owned).collect(),
        verdicts: VerdictClass::ALL.map(VerdictClass::name).into(),
    })
}

/// Which file is meant.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Which {
    /// The name that the lab gave it.
    file: String,
}

/// How a file was read.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Opened {
    /// The file, as it is asked for.
    id: String,
    /// What it holds, as `stiction inspect --json` tells it; null if it could not be read.
    summary: Option<Summary>,
    /// Why it could not be read, and what would help.
    failure: Option<String>,
    /// The role of each column of the summary, by the name under which it is given.
    roles: Vec<&'static str>,
    /// The names of its columns.
    columns: Vec<String>,
    /// What was said of it by hand.
    mapping: Mapping,
    /// The same as a mapping file.
    mapping_toml: String,
    /// Where its own mapping file is, or would be; null for what was dropped.
    mapping_file: Option<String>,
    /// Whether what holds now is what that file says.
    is_saved: bool,
    /// Why its mapping cannot be changed here, if it cannot.
    fixed: Option<String>,
    /// The command that says the same.
    command: Option<String>,
}

/// Opens a file: reads it, if it was not read, or has changed since. Of one whose columns are not understood it tells
/// their names, so that one can say what they are.
///
/// # Errors
/// If it is not open in this lab, or is no file of recordings.
pub fn open(lab: &Lab, which: Which) -> Answer<Opened> {
    let file = lab.recordings.file(&which.file)?;
    match lab.recordings.read(&file) {
        Ok(reading) => Ok(opened(&file, &reading)),
        Err(wrong) => match file.columns() {
            Ok(columns) => Ok(Opened { failure: Some(wrong.error), columns, ..told(&file) }),
            Err(_) => Err(wrong),
        },
    }
}

/// A file that was read.
fn opened(file: &File, reading: &Reading) -> Opened {
    Opened {
        summary: Some(Summary::from(reading)),
        roles: reading.recognised.iter().map(|each| each.role.option_name()).collect(),
        columns: reading.recognised.iter().map(|each| each.column.clone()).collect(),
        ..told(file)
    }
}

/// What is said of a file by hand.
fn told(file: &File) -> Opened {
    let own = file.own();
    let quoted = |text: &str| match text.contains([' ', '\'', '"', '$', '(', ')', '&', ';', '\\']) {
        true => format!("'{}'", text.replace('\'', "'\\''")),
        false => text.to_owned(),
    };
    let command = file
        .path()
        .map(|path| format!("stiction diagnose {}", quoted(&path.display().to_string())));
    Opened {
        id: file.id.clone(),
        summary: None,
        failure: None,
        roles: vec![],
        columns: vec![],
        mapping_toml: own.text(),
        mapping_file: file.mapping_path().map(|path| path.display().to_string()),
        is_saved: own.is_saved,
        fixed: own.fixed.clone(),
        mapping: own.mapping,
        command,
    }
}

/// What is said of a file by hand.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Say {
    /// The file.
    file: String,
    /// What is said.
    mapping: Mapping,
    /// Whether it is kept in a file beside it.
    #[serde(default)]
    save: bool,
}

/// Reads a file as one says, and keeps what was said if that is asked for.
///
/// # Errors
/// If it cannot be read so, or the mapping file cannot be written; then all stays as it was.
pub fn say(lab: &Lab, asked: Say) -> Answer<Opened> {
    let file = lab.recordings.file(&asked.file)?;
    let reading = lab.recordings.say(&file, asked.mapping, asked.save)?;
    Ok(opened(&file, &reading))
}

/// Closes what was dropped, and frees its memory.
///
/// # Errors
/// If it is not open, or was not dropped.
pub fn close(lab: &Lab, which: Which) -> Answer<Recordings> {
    lab.recordings.close(&which.file)?;
    list(lab, Nothing {})
}

/// Opens an example: a loop whose valve sticks, simulated.
///
/// # Errors
/// If the lab is full.
pub fn example(lab: &Lab, _: Nothing) -> Answer<Entry> {
    const NAME: &str = "samples/sticky-flow";
    let text =
        scenario::built_in_text(NAME).ok_or_else(|| Wrong::own("the example is not built in"))?;
    let scenario = scenario::Scenario::parse_with(text, NAME, None, &[])?;
    let scenario::System::ClosedLoop(plant) = scenario.system else {
        return Err(Wrong::own("the example is no single loop"));
    };
    let run = plant.run()?;
    let csv = loops::recorded(run.sample_time, &run.sp, &run.pv, &run.op);
    lab.recordings.take("FIC101-example.csv", csv.into_bytes()).map(|file| file.entry())
}

/// A loop, or a stretch of its recording.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// The file.
    file: String,
    /// The loop in it.
    #[serde(rename = "loop")]
    tag: String,
    /// Where the stretch begins, s on the recording's clock; with its beginning if this is not given.
    #[serde(default)]
    from: Option<f64>,
    /// Where it ends, the sample there not in it; with the end of the recording if this is not given.
    #[serde(default)]
    to: Option<f64>,
}

/// The verdict on a loop, or on a stretch of its recording.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Judged {
    /// Where the recording comes from.
    source: Source,
    /// What was found out, as `stiction diagnose --json` tells it.
    diagnosis: Diagnosis,
    /// The same in the words of the report.
    told: Told,
    /// Where slips of the valve are seen, s on the recording's clock.
    slips: Vec<f64>,
}

/// A recording with its source, or what was cut of it.
struct Found {
    source: Source,
    recording: Recording,
    file: Arc<File>,
}

fn found(lab: &Lab, asked: &Stretch) -> Answer<Found> {
    let file = lab.recordings.file(&asked.file)?;
    let reading = lab.recordings.read(&file)?;
    let whole = recording(&reading, &asked.tag)?;
    let mut recording = match (asked.from, asked.to) {
        (None, None) => whole.clone(),
        (from, to) => {
            let (from, to) = (from.unwrap_or(f64::NEG_INFINITY), to.unwrap_or(f64::INFINITY));
            whole.part(from, to, f64::INFINITY).ok_or_else(|| {
                Wrong::asked("this stretch has no sample of the OP; choose a longer one")
            })?
        }
    };
    // As the command tells them: what is known of the file before what is of the loop.
    recording.notes.splice(0..0, reading.notes.iter().cloned());
    let source = Source { file: reading.origin.clone(), sha256: reading.sha256.clone() };
    Ok(Found { source, recording, file })
}

fn recording<'r>(reading: &'r Reading, tag: &str) -> Answer<&'r Recording> {
    reading.recordings.iter().find(|each| each.name == tag).ok_or_else(|| {
        let known: Vec<&str> = reading.recordings.iter().map(|each| &*each.name).collect();
        Wrong::gone(format!("{} has no loop {tag}; there are {}", reading.origin, known.join(", ")))
    })
}

fn judged(lab: &Lab, asked: &Stretch, evidence: bool) -> Answer<(Source, Diagnosis)> {
    let Found { source, recording, file } = found(lab, asked)?;
    let options = DiagnoseOptions { evidence, ..DiagnoseOptions::default() };
    let mut diagnosis = diagnose(&recording, &options)?;
    if let Some(path) = file.path() {
        let kept = Overrides::read(&Overrides::path_beside(path))?;
        kept.overrule(&mut diagnosis, path, &source.sha256);
        diagnosis.notes.extend(kept.complaints());
    }
    Ok((source, diagnosis))
}

/// The verdict on a loop, or on a stretch of its recording.
///
/// # Errors
/// If there is no such loop, or its times make no sense.
pub fn verdict(lab: &Lab, asked: Stretch) -> Answer<Judged> {
    let (source, diagnosis) = judged(lab, &asked, false)?;
    let told = report::told(&Loop { source: &source, diagnosis: &diagnosis });
    let at = |segment: &stiction_diagnose::recording::Segment| {
        let time = |sample: usize| segment.from + sample as f64 * segment.sample_time;
        diagnosis.slips().unwrap_or_default().into_iter().map(time).collect()
    };
    let slips = diagnosis.segment().map(at).unwrap_or_default();
    Ok(Judged { source, told, slips, diagnosis })
}

/// What of a report is asked for.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct More {
    /// The loop, or the stretch of its recording.
    of: Stretch,
    /// The number of the fold; what there is without.
    #[serde(default)]
    fold: Option<usize>,
}

/// What a report tells beyond its first screen.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Details {
    /// What each fold is about.
    folds: Vec<String>,
    /// What the one that was asked for tells.
    pieces: Vec<Piece>,
}

/// All that a report tells beyond its first screen, fold by fold, with its pictures.
///
/// # Errors
/// If there is no such loop or fold.
pub fn details(lab: &Lab, asked: More) -> Answer<Details> {
    let file = lab.recordings.file(&asked.of.file)?;
    let sha256 = lab.recordings.read(&file)?.sha256.clone();
    // Where there are none, nothing was concluded.
    let beside = file.path().and_then(|path| std::fs::read(Overrides::path_beside(path)).ok());
    let of = (asked.of, sha256, beside.unwrap_or_default());
    let folds = match lab.recordings.told(&of) {
        Some(known) => known,
        None => {
            let (source, diagnosis) = judged(lab, &of.0, true)?;
            let folds = Arc::new(Folds::of(&Loop { source: &source, diagnosis: &diagnosis }));
            lab.recordings.tell(of, Arc::clone(&folds));
            folds
        }
    };
    let pieces = match asked.fold {
        None => vec![],
        Some(number) => folds
            .pieces(number)
            .ok_or_else(|| Wrong::gone(format!("the report has no part {number}")))??,
    };
    Ok(Details { folds: folds.summaries(), pieces })
}

/// The page of the report, and what to call it.
fn page(lab: &Lab, asked: &Stretch) -> Answer<(String, String)> {
    let (source, diagnosis) = judged(lab, asked, true)?;
    let html = report::html(&lab.tool, &[Loop { source: &source, diagnosis: &diagnosis }])?;
    Ok((format!("{}.html", diagnosis.name), html))
}

/// What a person concludes of a valve.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Conclude {
    /// The file.
    file: String,
    /// The loop in it.
    #[serde(rename = "loop")]
    tag: String,
    /// What the valve does: sticks, does not stick, does not respond or cannot tell; without, what was concluded of this
    /// file or, with `all_recordings`, of all is taken back.
    #[serde(default)]
    verdict: Option<String>,
    /// Why, in words.
    #[serde(default)]
    reason: String,
    /// Who says so.
    #[serde(default)]
    by: Option<String>,
    /// Whether it holds for the loop in all recordings of the folder; then it must end.
    #[serde(default)]
    all_recordings: bool,
    /// The last day on which it holds, UTC, such as 2026-12-31.
    #[serde(default)]
    until: Option<String>,
}

/// What was done.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Concluded {
    /// It, in a sentence.
    said: String,
}

/// Keeps, or takes back, what a person concluded of a valve, where `stiction override` keeps it.
///
/// # Errors
/// If the recording was dropped and so has no folder, there is no such loop, or the file cannot be written.
pub fn conclude(lab: &Lab, asked: Conclude) -> Answer<Concluded> {
    let file = lab.recordings.file(&asked.file)?;
    let reading = lab.recordings.read(&file)?;
    let name = recording(&reading, &asked.tag)?.name.clone();
    let Some(path) = file.path() else {
        return Err(Wrong::asked(
            "an override is kept beside its recording, and a file that was dropped has no place; open it with `stiction lab FILE`",
        ));
    };
    let kept_in = Overrides::path_beside(path);
    let file_name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let Some(verdict) = &asked.verdict else {
        let removed = overrides::remove(&kept_in, |each| {
            each.is_of(&name, &file_name, asked.all_recordings)
        })?;
        return match removed {
            0 => Err(Wrong::gone(format!("{}: has no such override of {name}", kept_in.display()))),
            some => Ok(Concluded {
                said: format!("removed {some} of {name} from {}", kept_in.display()),
            }),
        };
    };
    let text = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
    let reason = text(&asked.reason).ok_or_else(|| {
        Wrong::asked("an override needs its reason; say in a few words how you know")
    })?;
    let date = |day: &String| {
        day.parse::<Date>()
            .map_err(|_| Wrong::asked(format!("\"{day}\" is no date; write it as 2026-12-31")))
    };
    let until = asked.until.as_ref().and_then(|day| text(day)).as_ref().map(date).transpose()?;
    if asked.all_recordings && until.is_none() {
        return Err(Wrong::asked(
            "what holds for all recordings needs a last day on which it holds, such as 2026-12-31",
        ));
    }
    let one = Override {
        loop_name: name,
        verdict: VerdictClass::by_name(verdict)?,
        reason,
        by: asked.by.as_deref().and_then(text),
        entered: Some(overrides::today()),
        tool: Some(lab.tool.clone()),
        scope: match asked.all_recordings {
            true => Scope::All,
            false => Scope::File { name: file_name, sha256: reading.sha256.clone() },
        },
        from: None,
        until,
    };
    overrides::enter(&kept_in, &one)?;
    let said = format!(
        "{} {}, by override, for {}; kept in {}",
        one.loop_name,
        one.verdict.name(),
        one.scope_in_words(),
        kept_in.display()
    );
    Ok(Concluded { said })
}
