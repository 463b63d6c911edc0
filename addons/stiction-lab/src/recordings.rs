//! Recordings: the open files, how they were read, and the verdict on any stretch.
//!
//! Files and folders of the command are read when the page needs them. Dropped files are kept in memory. The page names
//! a file by an identifier from the lab, never by a path. The verdict on a whole recording is that of `stiction
//! diagnose`. The verdict on a stretch uses only its samples, as `stiction history` cuts them.

mod files;
mod mapping;
mod reports;
mod routes;
mod trend;

pub(crate) use files::Room;
pub(crate) use reports::REPORTS;
pub(crate) use routes::routes;

use crate::calls::{Answer, Wrong};
use crate::lab::Lab;
use crate::loops::{self, Nothing};
use crate::turns::Wanted;
use files::{Entry, File};
use mapping::Mapping;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use stiction_diagnose::diagnose::{DiagnoseOptions, Diagnosis, VerdictClass};
use stiction_diagnose::recording::{LoopType, Recording};
use stiction_diagnose::spoken::counted;
use stiction_io::summary::Summary;
use stiction_io::{Reading, role::Role, scenario};
use stiction_plant::overrides::{self, Date, Override, Overrides, Scope};
use stiction_report::document::{Loop, Source};
use stiction_report::report::{self, FirstScreen, Fitted, Folds, Table, first_screen::Piece};

/// The open files.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Recordings {
    /// The files, in their order.
    files: Vec<Entry>,
    /// The largest size of a dropped file, bytes.
    most_dropped: u64,
    /// Types of loops.
    loop_types: Vec<&'static str>,
    /// Roles of columns.
    roles: Vec<String>,
    /// Verdicts of an override.
    verdicts: Vec<&'static str>,
}

/// The open files. Folders are searched again.
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
    /// Identifier.
    file: String,
}

/// Number of loops whose table is shown, as with their settings.
const MOST_TABLES: usize = 12;

/// How a file was read.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Opened {
    /// The identifier of the file.
    id: String,
    /// Content of the file, as `stiction inspect --json` prints it; null if the file could not be read.
    summary: Option<Summary>,
    /// How each of its first loops was interpreted, as a table.
    understood: Vec<Table>,
    /// Why it could not be read, with the remedy.
    failure: Option<String>,
    /// The role of each column of the summary.
    roles: Vec<&'static str>,
    /// The names of its columns.
    columns: Vec<String>,
    /// The corrections by hand.
    mapping: Mapping,
    /// The corrections as a mapping file.
    mapping_toml: String,
    /// The path of its own mapping file, existing or not; null for a dropped file.
    mapping_file: Option<String>,
    /// Whether the present corrections equal those in that file.
    is_saved: bool,
    /// Why its mapping cannot be changed here, if it cannot.
    fixed: Option<String>,
    /// The equivalent command.
    command: Option<String>,
}

/// Opens a file, and reads it if it is new or has changed. If the columns are not recognised, the answer lists their
/// names, so that the user can assign them.
///
/// # Errors
/// If the file is not open in this lab, or contains no recordings.
pub fn open(lab: &Lab, which: Which) -> Answer<Opened> {
    let file = lab.recordings.file(&which.file)?;
    match lab.recordings.read(&file) {
        Ok(reading) => Ok(opened(&file, &reading)),
        Err(wrong) => match file.columns() {
            Ok(columns) => {
                Ok(Opened { failure: Some(wrong.error), columns, ..uninterpreted(&file) })
            }
            Err(_) => Err(wrong),
        },
    }
}

/// A file that was read.
fn opened(file: &File, reading: &Reading) -> Opened {
    let summary = Summary::from(reading);
    let of_loop =
        |each: &stiction_io::summary::Loop| Table::understood(&each.name, &each.understood);
    Opened {
        understood: summary.loops.iter().take(MOST_TABLES).map(of_loop).collect(),
        summary: Some(summary),
        roles: reading.recognised.iter().map(|each| each.role.option_name()).collect(),
        columns: reading.recognised.iter().map(|each| each.column.clone()).collect(),
        ..uninterpreted(file)
    }
}

/// The corrections to a file by hand.
fn uninterpreted(file: &File) -> Opened {
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
        understood: vec![],
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

/// New corrections to a file.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Say {
    /// The file.
    file: String,
    /// The corrections.
    mapping: Mapping,
    /// Whether to save the corrections in a mapping file beside the recording.
    #[serde(default)]
    save: bool,
}

/// Reads a file with these corrections, and keeps them if asked to.
///
/// # Errors
/// If the file cannot be read with these corrections, or the mapping file cannot be written. Then nothing changes.
pub fn say(lab: &Lab, asked: Say) -> Answer<Opened> {
    let file = lab.recordings.file(&asked.file)?;
    let reading = lab.recordings.say(&file, asked.mapping, asked.save)?;
    Ok(opened(&file, &reading))
}

/// Closes a dropped file, and frees its memory.
///
/// # Errors
/// If the file is not open, or was not dropped on the page.
pub fn close(lab: &Lab, which: Which) -> Answer<Recordings> {
    lab.recordings.close(&which.file)?;
    list(lab, Nothing {})
}

/// Opens an example: a simulated loop with a sticking valve.
///
/// # Errors
/// If the lab is full.
pub fn example(lab: &Lab, _: Nothing) -> Answer<Entry> {
    const NAME: &str = "samples/sticky-flow";
    let text =
        scenario::built_in_text(NAME).ok_or_else(|| Wrong::own("the example is not built in"))?;
    let scenario = scenario::Scenario::parse_with(text, NAME, None, &[])?;
    let scenario::System::ClosedLoop(plant) = scenario.system else {
        return Err(Wrong::own("the example is not a single loop"));
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
    /// Beginning of the stretch, s on the recording's clock; the beginning of the recording by default.
    #[serde(default)]
    from: Option<f64>,
    /// End of the stretch, exclusive; the end of the recording by default.
    #[serde(default)]
    to: Option<f64>,
}

/// The verdict on a loop, or on a stretch of its recording.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Judged {
    /// Where the recording comes from.
    source: Source,
    /// The diagnosis, as `stiction diagnose --json` prints it.
    diagnosis: Diagnosis,
    /// The diagnosis in the words of the report.
    first_screen: FirstScreen,
    /// Times of the slips of the valve, s on the recording's clock.
    slips: Vec<f64>,
}

/// A recording, or a stretch of it, with its source.
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
                Wrong::request("this stretch has no OP sample; select a longer stretch")
            })?
        }
    };
    // In the order of the command: notes on the file before notes on the loop.
    recording.notes.splice(0..0, reading.notes.iter().cloned());
    let source = Source { file: reading.origin.clone(), sha256: reading.sha256.clone() };
    Ok(Found { source, recording, file })
}

fn recording<'r>(reading: &'r Reading, tag: &str) -> Answer<&'r Recording> {
    reading.recordings.iter().find(|each| each.name == tag).ok_or_else(|| {
        let known: Vec<&str> = reading.recordings.iter().map(|each| &*each.name).collect();
        Wrong::gone(format!(
            "{} has no loop {tag}; its loops are {}",
            reading.origin,
            known.join(", ")
        ))
    })
}

fn judged(
    lab: &Lab,
    asked: &Stretch,
    evidence: bool,
    wanted: &Wanted,
) -> Answer<(Source, Diagnosis)> {
    let Found { source, recording, file } = found(lab, asked)?;
    // Reading may have taken long.
    wanted.check()?;
    let options = DiagnoseOptions { evidence, ..DiagnoseOptions::default() };
    let mut diagnosis = wanted.diagnose(&recording, &options)?;
    if let Some(path) = file.path() {
        let kept = Overrides::read(&Overrides::path_for(path))?;
        kept.overrule(&mut diagnosis, path, &source.sha256);
        diagnosis.notes.extend(kept.complaints());
    }
    Ok((source, diagnosis))
}

/// The verdict on a loop, or on a stretch of its recording.
///
/// # Errors
/// If no such loop exists, or the times of the stretch are impossible.
pub fn verdict(lab: &Lab, asked: Stretch, wanted: &Wanted) -> Answer<Judged> {
    let (source, diagnosis) = judged(lab, &asked, false, wanted)?;
    let first_screen = report::first_screen(&Loop::new(&source, &diagnosis));
    let at = |segment: &stiction_diagnose::recording::Segment| {
        let time = |sample: usize| segment.from + sample as f64 * segment.sample_time;
        diagnosis.slips().unwrap_or_default().into_iter().map(time).collect()
    };
    let slips = diagnosis.segment().map(at).unwrap_or_default();
    Ok(Judged { source, first_screen, slips, diagnosis })
}

/// A part of a report.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct More {
    /// The loop, or the stretch of its recording.
    of: Stretch,
    /// The number of the fold; without it only the list of folds.
    #[serde(default)]
    fold: Option<usize>,
}

/// The parts of a report below its first screen.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Details {
    /// What each fold is about.
    folds: Vec<String>,
    /// The content of the requested one.
    pieces: Vec<Piece>,
}

/// The parts of a report below its first screen, fold by fold, with their figures.
///
/// # Errors
/// If there is no such loop or fold.
pub fn details(lab: &Lab, asked: More, wanted: &Wanted) -> Answer<Details> {
    let file = lab.recordings.file(&asked.of.file)?;
    let sha256 = lab.recordings.read(&file)?.sha256.clone();
    // Without the file there are no overrides.
    let beside = file.path().and_then(|path| std::fs::read(Overrides::path_for(path)).ok());
    let of = (asked.of, sha256, beside.unwrap_or_default());
    let folds = match lab.recordings.folds(&of) {
        Some(known) => known,
        None => {
            let (source, diagnosis) = judged(lab, &of.0, true, wanted)?;
            let fitted = Fitted::of_accused(&diagnosis);
            let one = Loop::new(&source, &diagnosis).with_fit(&fitted);
            let folds = Arc::new(Folds::of(&one));
            lab.recordings.keep_folds(of, Arc::clone(&folds));
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

/// Where a report is.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ReportAt {
    /// Address at this lab. The address contains a secret, so that the browser can open the report without the token.
    address: String,
}

/// The report of a loop, or of a stretch of its recording, as a page of its own.
///
/// # Errors
/// If there is no such loop, or the machine gives no random numbers.
pub fn report(lab: &Lab, asked: Stretch, wanted: &Wanted) -> Answer<ReportAt> {
    let (source, diagnosis) = judged(lab, &asked, true, wanted)?;
    let fitted = Fitted::of_accused(&diagnosis);
    let html = report::html(&lab.tool, &[Loop::new(&source, &diagnosis).with_fit(&fitted)])?;
    let address = lab.recordings.reports.keep(&format!("{}.html", diagnosis.name), html)?;
    Ok(ReportAt { address })
}

/// An override of a verdict.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Conclude {
    /// The file.
    file: String,
    /// The loop in it.
    #[serde(rename = "loop")]
    tag: String,
    /// The verdict: sticks, does not stick, does not respond or cannot tell. Without it, the override of this file or,
    /// with `all_recordings`, of all files is removed.
    #[serde(default)]
    verdict: Option<String>,
    /// Why, in words.
    #[serde(default)]
    reason: String,
    /// The author.
    #[serde(default)]
    by: Option<String>,
    /// Whether it is valid for the loop in all recordings of the folder. Then it needs a last day.
    #[serde(default)]
    all_recordings: bool,
    /// The last day of its validity, UTC, such as 2026-12-31.
    #[serde(default)]
    until: Option<String>,
}

/// What was done.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Concluded {
    /// The change, in a sentence.
    said: String,
}

/// Enters or removes an override, where `stiction override` keeps it.
///
/// # Errors
/// If the recording was dropped and so has no folder, there is no such loop, or the file cannot be written.
pub fn conclude(lab: &Lab, asked: Conclude) -> Answer<Concluded> {
    let file = lab.recordings.file(&asked.file)?;
    let reading = lab.recordings.read(&file)?;
    let name = recording(&reading, &asked.tag)?.name.clone();
    let Some(path) = file.path() else {
        return Err(Wrong::request(
            "the lab keeps overrides beside the recording, which it cannot do for a dropped file; open the file with `stiction lab FILE`",
        ));
    };
    let kept_in = Overrides::path_for(path);
    let file_name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let Some(verdict) = &asked.verdict else {
        let removed = overrides::remove(&kept_in, |each| {
            each.is_of(&name, &file_name, asked.all_recordings)
        })?;
        return match removed {
            0 => Err(Wrong::gone(format!("{} has no such override of {name}", kept_in.display()))),
            some => Ok(Concluded {
                said: format!(
                    "removed {} of {name} from {}",
                    counted(some, "override"),
                    kept_in.display()
                ),
            }),
        };
    };
    let text = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
    let reason = text(&asked.reason).ok_or_else(|| {
        Wrong::request("an override needs a reason; enter in a few words why the verdict holds")
    })?;
    let date = |day: &String| {
        day.parse::<Date>()
            .map_err(|_| Wrong::request(format!("\"{day}\" is not a date; write it as 2026-12-31")))
    };
    let until = asked.until.as_ref().and_then(|day| text(day)).as_ref().map(date).transpose()?;
    if asked.all_recordings && until.is_none() {
        return Err(Wrong::request(
            "an override for all recordings needs a last day, such as 2026-12-31",
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
