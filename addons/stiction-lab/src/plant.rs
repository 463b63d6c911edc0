//! A plant: its weeks, its loops over time, and the log.
//!
//! The page shows the content that `stiction plant report` writes, from the same [store](stiction_plant::Store) by the
//! same functions. A week is read once, and again when the store, the log or the plant's file has changed. The search
//! for loops that swing together may take long, so it runs in the background, and the page shows that it is running.

mod entries;
mod happened;
mod scanning;
mod trend;

pub use entries::{enter_note, enter_override, enter_snooze};
pub use scanning::{begin_scan, stop_scan};
pub use trend::{diagnose_window, trend};

use crate::calls::{Answer, Wrong};
use crate::lab::{Lab, locked};
use crate::loops::Nothing;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, UNIX_EPOCH};
use stiction_diagnose::diagnose::change::Change;
use stiction_diagnose::diagnose::{Grade, VerdictClass};
use stiction_diagnose::recording::Recording;
use stiction_plant::action::Action;
use stiction_plant::groups::{Group, LoopOfWeek};
use stiction_plant::health::Health;
use stiction_plant::log::{self, Entry};
use stiction_plant::orders::{Order, orders};
use stiction_plant::page::{SPARK, Spark};
use stiction_plant::plant_file::{self, Plant};
use stiction_plant::ranking::LoopRow;
use stiction_plant::report::Known;
use stiction_plant::treemap::{self, AreaTile, NOWHERE, Tile};
use stiction_plant::week::Week;
use stiction_plant::{Store, WindowRow, day};
use stiction_report::report::layout::{Badge, Tone};

/// Weeks that are kept, and recordings.
const KEPT: usize = 2;
const KEPT_RECORDINGS: usize = 4;
/// How long an answer waits for groups. Those of a small plant are found by then.
const PATIENCE: Duration = Duration::from_millis(400);
/// Widths of the maps of a plant, for a large and a small screen, and their heights, which grow with the number of
/// loops up to a limit.
const MAPS: [(f64, f64, f64, f64); 2] = [(1240.0, 200.0, 0.4, 600.0), (360.0, 260.0, 0.6, 900.0)];

/// The plant of a lab.
#[derive(Debug)]
pub(crate) struct Room {
    folder: Option<PathBuf>,
    weeks: Mutex<Vec<Arc<WeekOf>>>,
    groups: Arc<Grouping>,
    recordings: Mutex<Vec<(trend::Window, Arc<Recording>)>>,
    scanning: Arc<scanning::Scanning>,
}

impl Room {
    /// The room of the plant in a folder.
    pub fn new(folder: Option<PathBuf>) -> Self {
        Self {
            folder,
            weeks: Mutex::default(),
            groups: Arc::default(),
            recordings: Mutex::default(),
            scanning: Arc::default(),
        }
    }

    fn folder(&self) -> Answer<&Path> {
        let none = || Wrong::gone("no plant is open; open a plant with stiction lab --plant DIR");
        self.folder.as_deref().ok_or_else(none)
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        self.scanning.stop();
    }
}

/// A week as it was read.
#[derive(Debug)]
struct WeekOf {
    /// The state of store, log and plant's file when they were read.
    stamp: String,
    plant: Plant,
    known: Known,
    loops: Vec<LoopOfWeek>,
    /// Whether this is the last week, which is the default.
    is_last: bool,
}

/// Searches for groups in the background, one week at a time, and keeps the result.
#[derive(Debug, Default)]
struct Grouping {
    state: Mutex<Groups>,
    done: Condvar,
}

/// Groups, or why they are not known.
type Found = Result<Vec<Group>, String>;

#[derive(Debug, Default)]
struct Groups {
    busy: bool,
    found: Vec<(Sought, Found)>,
}

/// The inputs of the search for groups.
#[derive(Debug, Clone, PartialEq)]
struct Sought {
    store: String,
    week: Week,
    loops: Vec<LoopOfWeek>,
    upstream: Vec<(String, Vec<String>)>,
}

impl Sought {
    fn of(week: &WeekOf) -> Self {
        let facts = week.plant.file.loops.iter();
        Self {
            store: week.stamp.split('\n').next().unwrap_or_default().to_owned(),
            week: week.known.week(),
            loops: week.loops.clone(),
            upstream: facts.map(|(name, facts)| (name.clone(), facts.upstream.clone())).collect(),
        }
    }
}

impl Grouping {
    /// The groups of a week, if they are found within a moment.
    fn of(self: &Arc<Self>, folder: &Path, week: &Arc<WeekOf>) -> Option<Found> {
        let sought = Sought::of(week);
        let there = |state: &Groups| {
            state.found.iter().find(|(of, _)| *of == sought).map(|(_, groups)| groups.clone())
        };
        let mut state = locked(&self.state);
        if let Some(found) = there(&state) {
            return Some(found);
        }
        if !state.busy {
            state.busy = true;
            let (own, folder, week, sought) =
                (Arc::clone(self), folder.to_owned(), Arc::clone(week), sought.clone());
            std::thread::spawn(move || own.find(&folder, &week, sought));
        }
        let waited = self.done.wait_timeout_while(state, PATIENCE, |state| state.busy);
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        there(&state)
    }

    fn find(&self, folder: &Path, week: &WeekOf, sought: Sought) {
        let find = || week.known.find_groups(folder, &week.plant, &week.loops);
        let found = std::panic::catch_unwind(std::panic::AssertUnwindSafe(find));
        let groups = match found {
            Ok(found) => found.map_err(|e| e.to_string()),
            Err(_) => Err("internal error of the search for groups; please report it".to_owned()),
        };
        let mut state = locked(&self.state);
        state.found.insert(0, (sought, groups));
        state.found.truncate(KEPT);
        state.busy = false;
        self.done.notify_all();
    }
}

/// A text that changes when the data of the page change. Its first line belongs to the store.
fn stamp(folder: &Path) -> Answer<String> {
    let mut stamp = Store::of(folder).stamp()?;
    for name in [log::NAME, plant_file::NAME] {
        let known = std::fs::metadata(folder.join(name)).ok();
        let changed = known.as_ref().and_then(|known| known.modified().ok());
        let changed = changed.and_then(|at| at.duration_since(UNIX_EPOCH).ok());
        let size = known.map_or(0, |known| known.len());
        stamp += &format!("\n{size} {}", changed.unwrap_or_default().as_nanos());
    }
    Ok(stamp)
}

impl Room {
    /// A week, read once.
    fn week(&self, week: Option<Week>) -> Answer<Arc<WeekOf>> {
        let folder = self.folder()?;
        let stamp = stamp(folder)?;
        let is_it = |of: &Arc<WeekOf>| match week {
            Some(week) => of.stamp == stamp && of.known.week() == week,
            None => of.stamp == stamp && of.is_last,
        };
        // Others that ask for the same week wait, and do not read it again.
        let mut weeks = locked(&self.weeks);
        if let Some(place) = weeks.iter().position(is_it) {
            let found = weeks.remove(place);
            weeks.insert(0, Arc::clone(&found));
            return Ok(found);
        }
        weeks.retain(|of| of.stamp == stamp);
        let plant = Plant::read(folder)?;
        let known = Known::without_groups(folder, &plant, week)?;
        let last = Store::of(folder).weeks_judged()?.pop();
        let is_last = week.is_none() || last == Some(known.week());
        let loops = known.loops_of_week(&plant);
        let of = Arc::new(WeekOf { stamp, plant, known, loops, is_last });
        weeks.insert(0, Arc::clone(&of));
        weeks.truncate(KEPT);
        Ok(of)
    }

    /// A recording of a window, read once from the plant's files.
    fn recording(&self, window: &trend::Window) -> Answer<Arc<Recording>> {
        if let Some((_, found)) = locked(&self.recordings).iter().find(|(of, _)| of == window) {
            return Ok(Arc::clone(found));
        }
        let folder = self.folder()?;
        let read = Arc::new(window.read(folder)?);
        let mut recordings = locked(&self.recordings);
        recordings.insert(0, (window.clone(), Arc::clone(&read)));
        recordings.truncate(KEPT_RECORDINGS);
        Ok(read)
    }
}

/// A word of the library, and how it looks.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Word {
    /// The word.
    pub name: &'static str,
    /// Short form.
    pub symbol: String,
    /// What it means for the reader: bad, warning, good or open.
    pub tone: &'static str,
}

fn word(badge: Badge) -> Word {
    let tone = match badge.tone {
        Tone::Bad => "bad",
        Tone::Warning => "warning",
        Tone::Good => "good",
        Tone::Open => "open",
    };
    Word { name: badge.word, symbol: badge.symbol.to_owned(), tone }
}

/// The words of the plant page, in their order.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Words {
    /// Actions.
    pub actions: Vec<Word>,
    /// Changes.
    pub changes: Vec<&'static str>,
    /// Verdicts.
    pub grades: Vec<Word>,
    /// Qualities of the data.
    pub health: Vec<&'static str>,
    /// Verdicts of an override.
    pub verdicts: Vec<&'static str>,
    /// The name for loops without an area.
    pub no_area: &'static str,
    /// The formula of the priority.
    pub priority: &'static str,
}

impl Words {
    fn all() -> Self {
        let action = |action: Action| Word {
            name: action.name(),
            symbol: action.letter().to_string(),
            tone: "open",
        };
        Self {
            actions: Action::ALL.map(action).into(),
            changes: Change::ALL.map(Change::name).into(),
            grades: Grade::ALL.map(|grade| word(grade.into())).into(),
            health: Health::ALL.map(Health::name).into(),
            verdicts: VerdictClass::ALL.map(VerdictClass::name).into(),
            no_area: NOWHERE,
            priority: "weight × severity × probability",
        }
    }
}

/// The state of the plant.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Now {
    /// The folder that was opened; none without a plant.
    folder: Option<String>,
    /// Name of the plant.
    plant: Option<String>,
    /// Why the plant cannot be read.
    wrong: Option<String>,
    /// Weeks in which windows were judged, the last first.
    weeks: Vec<String>,
    /// Changes when the data of the page change.
    stamp: String,
    /// The scan.
    scan: scanning::ScanNow,
    /// The last events of `stiction watch`, the newest first.
    events: Vec<happened::Happened>,
    /// The default author of an entry.
    user: Option<String>,
    /// Today.
    today: String,
    /// The words of the library.
    words: Words,
}

/// The state of the plant.
///
/// # Errors
/// Never: faults are part of the answer.
pub fn status(lab: &Lab, _: Nothing) -> Answer<Now> {
    let room = &lab.plant;
    let mut now = Now {
        folder: room.folder.as_ref().map(|folder| folder.display().to_string()),
        plant: None,
        wrong: None,
        weeks: vec![],
        stamp: String::new(),
        scan: room.scanning.now(),
        events: room.folder.as_deref().map(happened::last).unwrap_or_default(),
        user: whoami::username().ok(),
        today: stiction_plant::overrides::today().to_string(),
        words: Words::all(),
    };
    let Some(folder) = &room.folder else { return Ok(now) };
    let told = || -> Answer<(Plant, Vec<Week>, String)> {
        let weeks = Store::of(folder).weeks_judged()?;
        let groups = locked(&room.groups.state).found.len();
        Ok((Plant::read(folder)?, weeks, format!("{}\n{groups}", stamp(folder)?)))
    };
    match told() {
        Ok((plant, weeks, stamp)) => {
            now.plant = Some(plant.file.name);
            now.weeks = weeks.into_iter().rev().map(|week| week.to_string()).collect();
            now.stamp = stamp;
        }
        Err(wrong) => now.wrong = Some(wrong.error),
    }
    Ok(now)
}

/// Which week is asked for.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PageRequest {
    /// The week, such as `2026-W10`; by default the last week.
    #[serde(default)]
    week: Option<String>,
}

/// A week of the plant.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Page {
    /// Name of the plant.
    plant: String,
    /// The week.
    week: String,
    /// First day.
    first_day: String,
    /// Last day.
    last_day: String,
    /// The loops, most urgent first.
    loops: Vec<LoopRow>,
    /// Their small histories, in the same order.
    sparks: Vec<Spark>,
    /// Size of a small history, px.
    spark_size: [f64; 2],
    /// Loops that swing together; null while the search runs, or if they are not known.
    groups: Option<Vec<Group>>,
    /// Why they are not known.
    groups_wrong: Option<String>,
    /// Work orders.
    orders: Vec<Order>,
    /// The plant on a map: for a large screen, and for a small one.
    maps: Vec<Map>,
}

/// A plant on a map.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Map {
    /// Width.
    width: f64,
    /// Height.
    height: f64,
    /// Height of the name of an area.
    name: f64,
    /// Areas.
    areas: Vec<AreaTile>,
}

/// A week of the plant, as `stiction plant report` shows it.
///
/// # Errors
/// If there is no such week, or the store cannot be read.
pub fn page(lab: &Lab, asked: PageRequest) -> Answer<Page> {
    let week = asked.week.map(|week| week.parse::<Week>()).transpose().map_err(Wrong::request)?;
    let room = &lab.plant;
    let of = room.week(week)?;
    let (groups, groups_wrong) = match room.groups.of(room.folder()?, &of) {
        Some(Err(wrong)) => (None, Some(wrong)),
        found => (found.and_then(Result::ok), None),
    };
    let ranking = of.known.ranking_with(&of.plant, groups.as_deref().unwrap_or_default());
    let orders = orders(&ranking);
    let map = |(width, least, each, most): (f64, f64, f64, f64)| {
        let height = (least + each * ranking.loops.len() as f64).min(most);
        let whole = Tile { x: 0.0, y: 0.0, w: width, h: height };
        let areas = treemap::map(ranking.loops.iter().map(|ranked| &ranked.row), whole);
        Map { width, height, name: treemap::NAME, areas }
    };
    let days = ranking.week.days();
    Ok(Page {
        plant: ranking.plant.clone(),
        week: ranking.week.to_string(),
        first_day: day::date(*days.start()),
        last_day: day::date(*days.end()),
        maps: MAPS.into_iter().map(map).collect(),
        sparks: ranking.loops.iter().map(Spark::of).collect(),
        spark_size: SPARK.into(),
        loops: ranking.loops.into_iter().map(|ranked| ranked.row).collect(),
        groups,
        groups_wrong,
        orders,
    })
}

/// Which loop is asked for.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HistoryRequest {
    /// Tag.
    #[serde(rename = "loop")]
    name: String,
    /// The last week to show; the latest one by default.
    #[serde(default)]
    week: Option<String>,
}

/// A loop over time.
#[derive(Debug, Serialize, JsonSchema)]
pub struct LoopHistory {
    /// Tag.
    #[serde(rename = "loop")]
    name: String,
    /// Windows of the loop in the half year up to the end of the week, in order of time.
    windows: Vec<JudgedWindow>,
    /// Entries of the log for it, in the order of days.
    entries: Vec<LogEntry>,
    /// Loops whose swing would reach it.
    upstream: Vec<String>,
}

/// A window of a loop.
#[derive(Debug, Serialize, JsonSchema)]
pub struct JudgedWindow {
    /// First day.
    day: String,
    /// How many days it has.
    days: i64,
    /// What was judged.
    row: WindowRow,
}

/// An entry of the log.
#[derive(Debug, Serialize, JsonSchema)]
pub struct LogEntry {
    /// The entry of the log.
    entry: Entry,
    /// The same in words.
    words: String,
}

impl LogEntry {
    fn of(entry: &Entry) -> Self {
        Self { entry: entry.clone(), words: entry.words() }
    }
}

/// A loop over time.
///
/// # Errors
/// If there is no such loop.
pub fn history(lab: &Lab, asked: HistoryRequest) -> Answer<LoopHistory> {
    let week = asked.week.map(|week| week.parse::<Week>()).transpose().map_err(Wrong::request)?;
    let of = lab.plant.week(week)?;
    let zone = &of.plant.zone;
    let name = log::loop_named(&of.plant, of.known.names(), &asked.name).map_err(Wrong::gone)?;
    let told = |row: &WindowRow| {
        let first = day::of(row.window_start as f64, zone);
        let last = day::of((row.window_start + row.window_s) as f64 - 1.0, zone);
        JudgedWindow { day: day::date(first), days: last + 1 - first, row: row.clone() }
    };
    let facts = of.plant.facts(name);
    Ok(LoopHistory {
        name: name.to_owned(),
        windows: of.known.rows_of(name).iter().map(told).collect(),
        entries: of.known.log().of(name).into_iter().map(LogEntry::of).collect(),
        upstream: facts.map(|facts| facts.upstream.clone()).unwrap_or_default(),
    })
}
