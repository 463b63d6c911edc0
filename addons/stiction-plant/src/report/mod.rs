//! The report of a week: a folder `reports/WEEK/` with a page, pages of loops, and all of it as tables.
//!
//! ```text
//! index.html            the page
//! loops/TAG.html        the diagnosis of one window of a loop
//! loops/TAG-test.html   the sheet of its valve test, if an order needs one
//! ranking.csv|json|parquet
//! orders.csv|json
//! work-orders.csv       the orders for a CMMS
//! groups.parquet
//! ```
//!
//! Equal stores, files and options give equal bytes. Each file is written whole or not at all, the page last.

pub mod action;
pub mod heading;
pub mod health;
pub mod last_test;
pub mod orders;
pub mod page;
pub mod ranking;
pub mod treemap;

use crate::day;
use crate::error::{Error, Result, store};
use crate::groups::pairs::{self, Pair};
use crate::groups::{self, Group, GroupOptions, LoopOfWeek};
use crate::log::Log;
use crate::plant_file::Plant;
use crate::scan::inputs::Inputs;
use crate::scan::judge::fingerprint;
use crate::scan::recordings_of;
use crate::store::parquet_file;
use crate::store::table::{Row, columns};
use crate::store::trace::Trace;
use crate::store::window::{ENGINE_VERSION, WindowRow};
use crate::store::{Store, write_whole};
use crate::unknown::{self, Unknown};
use crate::week::Week;
use action::Action;
use orders::{Order, WorkOrder, orders};
use ranking::{LoopRow, Ranked, Ranking, rank};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::path::Path;
use stiction_diagnose::diagnose::change::Change;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, Diagnosis, Grade, diagnose};
use stiction_diagnose::finding::Abstention;
use stiction_diagnose::recording::Recording;
use stiction_diagnose::valve_test::{self, PlanOptions, TestPlan};
use stiction_report::document::{Loop, Source, json};
use stiction_report::report::folder::plain;
use stiction_report::report::{Fitted, Folder};
use stiction_report::sheet::Sheet;
use stiction_report::valve_test_sheet;

/// The folder of all reports, inside the plant's folder.
pub const FOLDER: &str = "reports";

columns! {
    /// A loop of a group of loops that swing together.
    pub struct GroupRow;
    /// Number of the group.
    "group" [""] group: i64;
    /// Period of the common swing.
    "period_s" ["s"] period_s: f64;
    /// Tag of the loop.
    "loop" [""] name: String;
    /// Coherence of the loop with the group at the period.
    "coherence" [""] coherence: f64;
    /// Place among the candidates for the source; empty if the loop is no candidate.
    "candidate_rank" [""] candidate_rank: Option<i64>;
    /// Evidence, sentences.
    "reasons" [""] reasons: String;
}

/// Options of a report.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReportOptions {
    /// The week; by default the last one with windows of most loops.
    pub week: Option<Week>,
    /// Pages for this many of the worst loops, besides the loops that changed, are watched or need a valve test.
    pub pages: usize,
}

/// The ranking as a document.
#[derive(Debug, serde::Serialize)]
struct RankingDocument<'a> {
    /// Name of the plant.
    plant: &'a str,
    /// The week, such as `2026-W10`.
    week: String,
    /// First day.
    first_day: String,
    /// Last day.
    last_day: String,
    /// Version of the program.
    engine_version: &'static str,
    /// The loops, the most urgent first.
    loops: Vec<&'a LoopRow>,
    /// Loops that swing together.
    groups: &'a [Group],
}

/// The content of a report.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Reported {
    /// Name of the plant.
    pub plant: String,
    /// The week, such as `2026-W10`.
    pub week: String,
    /// Folder, relative to the plant's folder.
    pub folder: String,
    /// Loops in it.
    pub loops: usize,
    /// Of these, loops with a judged window.
    pub judged: usize,
    /// Loops by action.
    pub actions: Vec<Counted>,
    /// Changes in the week.
    pub changes: Vec<Changed>,
    /// Work orders to do.
    pub orders: usize,
    /// Work orders that a test closed.
    pub orders_closed: usize,
    /// Pages of loops that were written.
    pub pages: usize,
    /// Damaged files, data files that differ from the last scan, and reasons why pages of loops could not be written.
    pub problems: Vec<String>,
    /// What was not read of the data, and windows of the week that could not be judged.
    pub unknown: Vec<Unknown>,
    /// Loops whose valves began to stick, without snoozed ones.
    pub new_sticking: usize,
}

/// How many loops need an action.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Counted {
    /// The action.
    pub action: Action,
    /// Loops.
    pub loops: usize,
}

/// A loop that changed.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Changed {
    /// Tag.
    #[serde(rename = "loop")]
    pub name: String,
    /// What changed.
    pub change: Change,
    /// The first day after the week.
    pub day: Option<String>,
    /// First day of the 95 % interval of that day.
    pub from: Option<String>,
    /// Last day of that interval.
    pub to: Option<String>,
}

/// Weeks before the week that are read, for changes and the small histories.
const WEEKS: i64 = 26;

/// The content of a plant's folder for the report of a week.
#[derive(Debug)]
pub struct Known {
    log: Log,
    rows: Vec<WindowRow>,
    week: Week,
    /// The loops that swing together in the week.
    pub groups: Vec<Group>,
    /// Damaged files of the store, and windows after the week, in sentences.
    remarks: Vec<String>,
}

/// The last week whose windows cover not much fewer loops than the week before. A few samples with times in the future
/// make no week of the plant.
fn usual_week(store: &Store, plant: &Plant) -> Result<Option<Week>> {
    /// The smallest share of the loops of the week before.
    const SHARE: usize = 4;
    let begin = |day: i64| day::begin(day, &plant.zone) as i64;
    let loops = |week: &Week| -> Result<usize> {
        let rows = store.rows_between(begin(*week.days().start()), begin(week.days().end() + 1))?;
        Ok(rows.chunk_by(|a, b| a.name == b.name).count())
    };
    let mut weeks = store.weeks_judged()?;
    while let [.., before, last] = &weeks[..] {
        if SHARE * loops(last)? >= loops(before)? {
            break;
        }
        weeks.pop();
    }
    Ok(weeks.pop())
}

impl Known {
    /// Reads the data of `week`, or of the last week with windows of most loops.
    ///
    /// # Errors
    /// If there is no window in or before the week, or a file of the store or the log cannot be read.
    pub fn of(folder: &Path, plant: &Plant, week: Option<Week>) -> Result<Self> {
        let mut known = Self::without_groups(folder, plant, week)?;
        known.groups = known.find_groups(folder, plant, &known.loops_of_week(plant))?;
        Ok(known)
    }

    /// The report without groups, which take the most time.
    ///
    /// # Errors
    /// As for [`Known::of`].
    pub fn without_groups(folder: &Path, plant: &Plant, week: Option<Week>) -> Result<Self> {
        let (log, store) = (Log::read(folder)?, Store::of(folder));
        let begin = |day: i64| day::begin(day, &plant.zone) as i64;
        let none = || Error::Option("no window was judged so far; scan first".to_owned());
        let last = store.last()?.ok_or_else(none)?;
        let last = Week::of(day::of(last as f64, &plant.zone));
        let (week, is_default) = match week {
            Some(week) => (week, false),
            None => (usual_week(&store, plant)?.unwrap_or(last), true),
        };
        let end = begin(week.days().end() + 1);
        let rows = store.rows_between(begin(week.days().start() - 7 * WEEKS), end)?;
        if rows.is_empty() {
            return Err(Error::Option(format!(
                "no window was judged in or before {week}; the last week is {last}"
            )));
        }
        let mut remarks = store.damaged();
        if is_default && last > week {
            remarks.push(format!(
                "there are windows up to {last}, after this week; if their times are wrong, correct the time stamps of the data"
            ));
        }
        Ok(Self { log, rows, week, groups: vec![], remarks })
    }

    /// The facts about each loop that groups need.
    pub fn loops_of_week(&self, plant: &Plant) -> Vec<LoopOfWeek> {
        let of_week = |ranked: &Ranked<'_>| {
            let swings = ranked.of_week.iter().filter(|row| row.oscillates == Some(true)).count();
            LoopOfWeek {
                name: ranked.row.name.clone(),
                probability: ranked.row.probability,
                period_s: ranked
                    .row
                    .period_s
                    .filter(|_| 2 * swings > ranked.row.windows_judged as usize),
            }
        };
        let ranking = rank(plant, &self.log, &self.rows, &[], self.week);
        ranking.loops.iter().map(of_week).collect()
    }

    /// The loops that swing together in the week, from these facts. It uses pairs found elsewhere if these are from the
    /// same traces.
    ///
    /// # Errors
    /// If a file of the store cannot be read.
    pub fn find_groups(
        &self,
        folder: &Path,
        plant: &Plant,
        loops: &[LoopOfWeek],
    ) -> Result<Vec<Group>> {
        let upstream =
            plant.file.loops.iter().map(|(name, facts)| (name.clone(), facts.upstream.clone()));
        let (upstream, options) = (upstream.collect(), GroupOptions::default());
        let traces = self.traces(folder, plant)?;
        let kept = Store::of(folder).pairs(self.week, || pairs::made_of(&traces, loops))?;
        let of = |pairs: Vec<Pair>| groups::find_of(&pairs, &traces, loops, &upstream, &options);
        let found = kept.and_then(of);
        Ok(found.unwrap_or_else(|| groups::find(&traces, loops, &upstream, &options)))
    }

    /// When the week begins and ends, s since 1970-01-01 UTC.
    pub fn span(&self, plant: &Plant) -> (i64, i64) {
        let begin = |day: i64| day::begin(day, &plant.zone) as i64;
        (begin(*self.week.days().start()), begin(self.week.days().end() + 1))
    }

    fn traces(&self, folder: &Path, plant: &Plant) -> Result<Vec<Trace>> {
        let (first, end) = self.span(plant);
        Store::of(folder).traces(first, end)
    }

    /// Keeps pairs of loops that were found elsewhere, for the groups of the week. `compared` lists their traces: loop, start, the
    /// bits of the unit, and [digest](Trace::digest).
    ///
    /// # Errors
    /// If these are not the traces in the store, or the store cannot be read or written.
    pub fn keep_pairs(
        &self,
        folder: &Path,
        plant: &Plant,
        pairs: &[Pair],
        compared: &BTreeSet<(String, i64, u64, String)>,
    ) -> Result<()> {
        let traces = self.traces(folder, plant)?;
        let told = |of: &Trace| (of.name.clone(), of.start, of.unit.to_bits(), of.digest());
        let own: BTreeSet<_> = traces.iter().map(told).collect();
        if let Some((name, start, ..)) = own.symmetric_difference(compared).next() {
            let day = day::date(day::of(*start as f64, &plant.zone));
            return Err(Error::Option(format!(
                "the pairs and the plant have different windows, such as that of {name} on {day}; judge again, and \
                 keep windows and pairs of the same output"
            )));
        }
        let made_of = pairs::made_of(&traces, &self.loops_of_week(plant));
        Store::of(folder).keep_pairs(self.week, &made_of, pairs)
    }

    /// The ranking of the week with groups that were found elsewhere.
    pub fn ranking_with(&self, plant: &Plant, groups: &[Group]) -> Ranking<'_> {
        rank(plant, &self.log, &self.rows, groups, self.week)
    }

    /// The judged loops, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.rows.chunk_by(|a, b| a.name == b.name).map(|rows| &*rows[0].name)
    }

    /// The windows of a loop, in order of time.
    pub fn rows_of(&self, name: &str) -> &[WindowRow] {
        let from = self.rows.partition_point(|row| *row.name < *name);
        let count = self.rows[from..].partition_point(|row| *row.name <= *name);
        &self.rows[from..from + count]
    }

    /// The week.
    pub fn week(&self) -> Week {
        self.week
    }

    /// The log.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// The ranking of the week.
    pub fn ranking(&self, plant: &Plant) -> Ranking<'_> {
        rank(plant, &self.log, &self.rows, &self.groups, self.week)
    }
}

/// Writes the report of a week of the plant in `folder`; `seen` is called for each page of a loop.
///
/// # Errors
/// If there is nothing to report, or a file of the store, the log or the report cannot be read or written. A loop whose
/// page cannot be made is among the problems, and does not stop the others.
pub fn write(
    folder: &Path,
    plant: &Plant,
    options: &ReportOptions,
    seen: impl Fn() + Sync,
) -> Result<Reported> {
    let known = Known::of(folder, plant, options.week)?;
    let groups = &known.groups[..];
    let mut ranking = known.ranking(plant);
    let own = format!("{FOLDER}/{}", ranking.week);
    let to = folder.join(&own);
    let mut problems = known.remarks.clone();
    let mut inputs = Inputs::known(&Store::of(folder), plant);
    problems.extend(inputs.compared(folder, plant).words());
    problems.extend(write_pages(folder, &to, plant, &mut ranking, options.pages, &seen)?);
    let orders = orders(&ranking);
    write_tables(&to, &ranking, &orders, groups)?;
    let unknown = unknown::of_week(&inputs, plant, &ranking);
    let page = page::page(&ranking, &orders, groups, &unknown);
    write_whole(&to.join(page::INDEX), page.as_bytes())?;

    let loops = || ranking.loops.iter().map(|ranked| &ranked.row);
    let changed = loops().filter(|row| row.change != Change::None);
    Ok(Reported {
        plant: ranking.plant.clone(),
        week: ranking.week.to_string(),
        folder: own,
        loops: ranking.loops.len(),
        judged: loops().filter(|row| row.windows_judged > 0).count(),
        actions: Action::ALL
            .map(|action| Counted { action, loops: loops().filter(|r| r.action == action).count() })
            .into(),
        changes: changed
            .map(|row| Changed {
                name: row.name.clone(),
                change: row.change,
                day: row.change_day.clone(),
                from: row.change_from.clone(),
                to: row.change_to.clone(),
            })
            .collect(),
        orders: orders::to_do(&orders),
        orders_closed: orders.len() - orders::to_do(&orders),
        pages: loops().filter(|row| row.page.is_some()).count(),
        problems,
        unknown,
        new_sticking: loops().filter(|row| row.is_new_sticking() && !row.is_snoozed()).count(),
    })
}

/// Writes the pages of the worst, changed and watched loops and of valves to test, and enters their paths in the ranking.
fn write_pages(
    folder: &Path,
    to: &Path,
    plant: &Plant,
    ranking: &mut Ranking<'_>,
    worst: usize,
    seen: &(impl Fn() + Sync),
) -> Result<Vec<String>> {
    let mut names = BTreeSet::new();
    let mut chosen: Vec<(usize, &WindowRow, [String; 2])> = vec![];
    for (place, ranked) in ranking.loops.iter().enumerate() {
        let row = &ranked.row;
        if place >= worst && row.change == Change::None && !row.watch && !row.is_to_test() {
            continue;
        }
        let Some(window) = telling(ranked) else { continue };
        let name = plain(&row.name);
        let paths = [name.clone(), format!("{name}-test")].map(|name| file_name(&mut names, name));
        chosen.push((place, window, paths));
    }
    let week = ranking.week;
    let windows: Vec<&WindowRow> = chosen.iter().map(|(_, window, _)| *window).collect();
    let recordings = recordings_of(folder, plant, &windows);
    let mut problems = vec![];
    // A few at a time: a page is a megabyte, and a diagnosis some more.
    for (part, recordings) in chosen.chunks(8).zip(recordings.chunks(8)) {
        let made: Vec<std::result::Result<LoopPages, String>> = part
            .par_iter()
            .zip(recordings)
            .map(|((place, window, [_, sheet]), recording)| {
                let recording = recording.as_ref().map_err(Clone::clone)?;
                let row = &ranking.loops[*place].row;
                let pages = loop_pages(row, window, recording, plant, week, sheet);
                seen();
                pages
            })
            .collect();
        for ((place, window, [path, sheet]), pages) in part.iter().zip(made) {
            let row = &mut ranking.loops[*place].row;
            match pages {
                Ok(pages) => {
                    write_whole(&to.join(path), pages.diagnosis.as_bytes())?;
                    row.page = Some(path.clone());
                    match pages.plan {
                        _ if !row.is_to_test() => {}
                        Ok(plan) => {
                            let html = valve_test_sheet::html(&plan, &tool());
                            write_whole(&to.join(sheet), html.as_bytes())?;
                            row.plan = Some(valve_test::short(&plan));
                            row.sheet = Some(sheet.clone());
                        }
                        Err(Abstention(why)) => row.plan = Some(orders::impossible(&why)),
                    }
                }
                Err(why) => problems.push(format!("page of {}: {why}", window.name)),
            }
        }
    }
    Ok(problems)
}

/// Sizes the tests of a ranking's orders, as their pages do. Returns why some could not be sized, in sentences.
pub fn size_tests(folder: &Path, plant: &Plant, ranking: &mut Ranking<'_>) -> Vec<String> {
    let due = |ranked: &Ranked<'_>| ranked.row.is_to_test() && !ranked.row.is_snoozed();
    let places = (0..ranking.loops.len()).filter(|place| due(&ranking.loops[*place]));
    let chosen: Vec<(usize, &WindowRow)> =
        places.filter_map(|place| Some((place, telling(&ranking.loops[place])?))).collect();
    let windows: Vec<&WindowRow> = chosen.iter().map(|(_, window)| *window).collect();
    let recordings = recordings_of(folder, plant, &windows);
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let sized: Vec<_> = (windows.par_iter().zip(recordings))
        .map(|(window, recording)| Ok(planned(&judged(window, &recording?, &options)?)))
        .collect();
    let mut problems = vec![];
    for ((place, window), sized) in chosen.into_iter().zip(sized) {
        match sized {
            Ok(Ok(plan)) => ranking.loops[place].row.plan = Some(valve_test::short(&plan)),
            Ok(Err(why)) => ranking.loops[place].row.plan = Some(orders::impossible(&why.0)),
            Err::<_, String>(why) => problems.push(format!("test of {}: {why}", window.name)),
        }
    }
    problems
}

/// The diagnosis of a window from its samples, if these are the judged samples.
fn judged(
    window: &WindowRow,
    recording: &Recording,
    options: &DiagnoseOptions,
) -> std::result::Result<Diagnosis, String> {
    // Other data would contradict the ranking.
    if window.samples_fingerprint.as_ref().is_some_and(|own| *own != fingerprint(recording)) {
        return Err(
            "the data files have changed since the window was judged; scan again".to_owned()
        );
    }
    diagnose(recording, options).map_err(|e| e.to_string())
}

fn planned(diagnosis: &Diagnosis) -> std::result::Result<TestPlan, Abstention> {
    valve_test::plan(diagnosis, &PlanOptions::default())
}

/// A unique file name for the page of a loop: tags may differ in characters that file names cannot hold.
fn file_name(names: &mut BTreeSet<String>, plain: String) -> String {
    let tries = std::iter::once(plain.clone()).chain((2..).map(|k| format!("{plain}-{k}")));
    let name = tries.into_iter().find(|name| names.insert(name.to_lowercase()));
    format!("loops/{}.html", name.unwrap_or(plain))
}

/// The window whose page is made, among the windows on which the verdict rests. For a valve to repair, it is the window
/// that accuses the valve with the largest probability, else the last window.
fn telling<'a>(ranked: &Ranked<'a>) -> Option<&'a WindowRow> {
    let mut judged = ranked.of_week.iter().copied().filter(|row| row.is_judged());
    let key = |row: &&WindowRow| {
        (row.grade().is_some_and(Grade::accuses), row.probability.unwrap_or(0.0))
    };
    match ranked.row.action {
        Action::Repair => judged
            .filter(|row| row.middle() >= ranked.settled)
            .max_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal)),
        _ => judged.next_back(),
    }
}

/// The pages of a loop.
struct LoopPages {
    /// The diagnosis of a window as a page.
    diagnosis: String,
    /// The test of the valve, or the reason why no test is possible.
    plan: std::result::Result<TestPlan, Abstention>,
}

fn tool() -> String {
    format!("stiction {ENGINE_VERSION}")
}

fn loop_pages(
    row: &LoopRow,
    window: &WindowRow,
    recording: &Recording,
    plant: &Plant,
    week: Week,
    sheet: &str,
) -> std::result::Result<LoopPages, String> {
    let diagnosis = judged(window, recording, &DiagnoseOptions::default())?;
    let day = day::date(day::of(window.window_start as f64, &plant.zone));
    let file = format!("all files of {day} together");
    let source = Source { file, sha256: window.input_fingerprint.clone() };
    let fitted = Fitted::of_accused(&diagnosis);
    let one = Loop::new(&source, &diagnosis).with_fit(&fitted);
    let plan = planned(&diagnosis);
    let is_planned = row.is_to_test() && plan.is_ok();
    let row =
        LoopRow { plan: plan.as_ref().err().map(|why| orders::impossible(&why.0)), ..row.clone() };
    let mut head = heading::heading(&row, week, &day, &diagnosis.verdict);
    // Both are in one folder.
    head.sheet = is_planned.then(|| sheet.replacen("loops/", "", 1));
    let page = Folder::new(tool(), &[one]).page_under(0, &head).map_err(|e| e.to_string())?;
    Ok(LoopPages { diagnosis: page, plan })
}

fn write_tables(
    to: &Path,
    ranking: &Ranking<'_>,
    orders: &[Order],
    groups: &[Group],
) -> Result<()> {
    let write = |name: &str, made: std::result::Result<Vec<u8>, String>| {
        let path = to.join(name);
        write_whole(&path, &made.map_err(|why| store(&path, why))?)
    };
    let loops: Vec<LoopRow> = ranking.loops.iter().map(|ranked| ranked.row.clone()).collect();
    write("ranking.csv", csv(&loops))?;
    write("ranking.parquet", parquet(&loops))?;
    let document = RankingDocument {
        plant: &ranking.plant,
        week: ranking.week.to_string(),
        first_day: day::date(*ranking.week.days().start()),
        last_day: day::date(*ranking.week.days().end()),
        engine_version: ENGINE_VERSION,
        loops: loops.iter().collect(),
        groups,
    };
    write("ranking.json", Ok(json(&document).into_bytes()))?;
    write("orders.csv", csv(orders))?;
    write("orders.json", Ok(json(&orders).into_bytes()))?;
    let work_orders: Vec<WorkOrder> = orders.iter().map(WorkOrder::from).collect();
    write("work-orders.csv", csv(&work_orders))?;

    let of_group = |group: &Group| {
        let (id, period_s) = (group.id as i64, group.period_s);
        let row = move |member: &crate::groups::Member| GroupRow {
            group: id,
            period_s,
            name: member.name.clone(),
            coherence: member.coherence,
            candidate_rank: member.candidate_rank.map(|rank| rank as i64),
            reasons: member.reasons.join(" "),
        };
        group.members.iter().map(row).collect::<Vec<_>>()
    };
    let rows: Vec<GroupRow> = groups.iter().flat_map(of_group).collect();
    write("groups.parquet", parquet(&rows))
}

fn csv<R: Row>(rows: &[R]) -> std::result::Result<Vec<u8>, String> {
    let made = || {
        let mut sheet = Sheet::new(R::columns().into_iter().map(|column| column.name))?;
        rows.iter().try_for_each(|row| sheet.row(row.cells()))?;
        sheet.text()
    };
    made().map(String::into_bytes).map_err(|e: std::io::Error| e.to_string())
}

fn parquet<R: Row>(rows: &[R]) -> std::result::Result<Vec<u8>, String> {
    parquet_file::bytes(rows).map_err(|e| e.to_string())
}
