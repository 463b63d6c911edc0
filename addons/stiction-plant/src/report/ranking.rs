//! The ranking of a week: a row per loop, the most urgent first.
//!
//! # A week
//! The windows of the week are combined as `stiction history` combines the windows of a valve ([`together`]). If the
//! valve was repaired (by `log.toml`), or began or ceased to stick, only the windows after that count: the verdict is
//! on the valve as it is now. S and J are the medians of the windows that have them, as are the ends of their
//! intervals. Key figures are means.
//!
//! # Priority
//! ```text
//! priority = weight x severity x probability
//! ```
//!
//! * weight: weight of the loop times weight of its area, both 1 by default;
//! * severity: S + J in percent of span over [`FULL`], at most 1. If they are unknown, it uses the smallest of the OP travel between
//!   two reversals, the OP travel in half a period, and the detection limit;
//! * probability: of stiction; for "retune" and "look upstream", of the other cause.
//!
//! For "check data" severity and probability are 1.

use crate::day;
use crate::groups::{Group, Member};
use crate::log::{Entry, Kind, Log};
use crate::plant_file::Plant;
use crate::report::action::{Action, Found, LIKELY};
use crate::report::health::Health;
use crate::report::last_test::{LastTest, s_in_words};
use crate::store::table::columns;
use crate::store::window::WindowRow;
use crate::week::Week;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use stiction_diagnose::diagnose::change::{Change, Event, SIDE, Seen, events, present_since};
use stiction_diagnose::diagnose::{
    Cause, Drift, Estimate, Grade, History, Observation, VerdictClass, together,
};
use stiction_diagnose::series::{mean, median};

/// S + J with severity 1, and the S whose date is reported if S drifts, percent of span.
pub const FULL: f64 = 10.0;
/// Length of the time before a week or a change, days.
const BEFORE: i64 = 28;
/// The least squared coherence with the group of a loop that the group makes swing.
const SHARED: f64 = 0.6;
/// Largest factor between the period of a loop and the period of its group.
const SAME_PERIOD: f64 = 1.5;
/// Windows by which a loop oscillates now.
const LAST: usize = 3;
/// The farthest date that is reported ahead, days: two years.
const FARTHEST: f64 = 730.0;

columns! {
    /// A loop in a week. Units are as in the columns.
    pub struct LoopRow;
    /// Tag of the loop.
    "loop" [""] name: String;
    /// Area of the plant, from plant.toml.
    "area" [""] area: Option<String>;
    /// Unit of the plant, from plant.toml.
    "unit" [""] unit: Option<String>;
    /// Type of the loop.
    "type" [""] loop_type: String;
    /// Weight of the loop times weight of its area.
    "weight" [""] weight: f64;
    /// Number of judged windows of the week.
    "windows_judged" [""] windows_judged: i64;
    /// Number of windows of the week.
    "windows" [""] windows: i64;
    /// Conclusion of the verdict on the week, such as sticks.
    "verdict" [""] verdict: Option<VerdictClass>;
    /// Grade of the verdict, such as probably sticks.
    "grade" [""] grade: Option<Grade>;
    /// Probability that the valve sticks, from the windows of the verdict.
    "probability" [""] probability: Option<f64>;
    /// Stick band plus dead band, of span. With a significant drift, the value at the end of the week.
    "S" ["%"] s: Option<f64>;
    /// Lower end of the interval of S, of span.
    "S_low" ["%"] s_low: Option<f64>;
    /// Upper end of the interval of S, of span.
    "S_high" ["%"] s_high: Option<f64>;
    /// Slip jump, of span.
    "J" ["%"] j: Option<f64>;
    /// Lower end of the interval of J, of span.
    "J_low" ["%"] j_low: Option<f64>;
    /// Upper end of the interval of J, of span.
    "J_high" ["%"] j_high: Option<f64>;
    /// Detection limit, of span: a larger S would have been detected.
    "S_below" ["%"] s_below: Option<f64>;
    /// The likeliest cause other than stiction.
    "alternative" [""] alternative: Option<Cause>;
    /// Probability of the cause in `alternative`.
    "alternative_likelihood" [""] alternative_likelihood: Option<f64>;
    /// Share of the time in automatic: the service factor.
    "auto_share" ["%"] auto_share: Option<f64>;
    /// Share of the time with the OP at a limit.
    "at_limit_share" ["%"] at_limit_share: Option<f64>;
    /// OP travel, up and down, per hour.
    "travel_per_hour" ["%/h"] travel_per_hour: Option<f64>;
    /// OP reversals above the noise, per hour.
    "reversals_per_hour" ["1/h"] reversals_per_hour: Option<f64>;
    /// Period of the oscillation.
    "period_s" ["s"] period_s: Option<f64>;
    /// Amplitude of the oscillation of the control error. If only the OP oscillates, amplitude of the OP in %.
    "amplitude" ["PV"] amplitude: Option<f64>;
    /// Action: repair, retune, look upstream, check data or leave.
    "action" [""] action: Action;
    /// Severity, from 0 to 1.
    "severity" [""] severity: f64;
    /// Weight times severity times probability.
    "priority" [""] priority: f64;
    /// Change in the week: new, returned, still sticks, worse, better, gone or none.
    "change" [""] change: Change;
    /// First day after the change.
    "change_day" [""] change_day: Option<String>;
    /// First day of the 95 % interval of `change_day`.
    "change_from" [""] change_from: Option<String>;
    /// Last day of the 95 % interval of `change_day`.
    "change_to" [""] change_to: Option<String>;
    /// Grade before the change; without a change, grade of the four weeks before.
    "verdict_before" [""] verdict_before: Option<Grade>;
    /// Number of windows of the verdict: windows of the week after the last change or repair.
    "windows_used" [""] windows_used: i64;
    /// First day of the windows of the verdict.
    "since" [""] since: Option<String>;
    /// Last day of the windows of the verdict.
    "until" [""] until: Option<String>;
    /// Growth of S per week, since the last repair or since the valve began to stick.
    "drift_per_week" ["% of S"] drift: Option<f64>;
    /// Lower end of the 95 % interval of the growth of S per week.
    "drift_low" ["% of S"] drift_low: Option<f64>;
    /// Upper end of the 95 % interval of the growth of S per week.
    "drift_high" ["% of S"] drift_high: Option<f64>;
    /// p-value of the drift of S: the larger p-value of two tests.
    "drift_p" [""] drift_p: Option<f64>;
    /// Whether the drift of S is significant by both tests.
    "drift_significant" [""] drift_significant: Option<bool>;
    /// Day within two years on which a growing S reaches 10 %; only for a significant drift.
    "limit_day" [""] limit_day: Option<String>;
    /// Conclusion of a person that is valid in the week.
    "override" [""] overruled: Option<VerdictClass>;
    /// Reason, author and last day of the conclusion in `override`.
    "override_reason" [""] override_reason: Option<String>;
    /// Result of the last valve test that counts in the week; a decisive test has precedence.
    "test" [""] test: Option<VerdictClass>;
    /// Day on which the test in `test` ended.
    "test_day" [""] test_day: Option<String>;
    /// S by the test, of span.
    "test_S" ["%"] test_s: Option<f64>;
    /// Lower end of the interval of S by the test, of span.
    "test_S_low" ["%"] test_s_low: Option<f64>;
    /// Upper end of the interval of S by the test, of span.
    "test_S_high" ["%"] test_s_high: Option<f64>;
    /// Upper limit of S by a test without a value of S, of span.
    "test_S_below" ["%"] test_s_below: Option<f64>;
    /// Day of the last order without a later repair.
    "ordered" [""] ordered: Option<String>;
    /// Day until which the loop is snoozed.
    "snoozed_until" [""] snoozed_until: Option<String>;
    /// Whether the loop is on the watch list.
    "watch" [""] watch: bool;
    /// Last repair, order or note in the log.
    "note" [""] note: Option<String>;
    /// Number of the group of loops that swing together with this loop.
    "group" [""] group: Option<i64>;
    /// Rank of the loop among the candidates for the source of the group.
    "candidate_rank" [""] candidate_rank: Option<i64>;
    /// Health of the data: no data, errors, dead or frozen, always in manual, not fit or good.
    "health" [""] health: Health;
    /// Error of the last window of the week that could not be judged.
    "error" [""] error: Option<String>;
    /// Page of the loop, relative to the folder of the report.
    "page" [""] page: Option<String>;
    /// Valve test that is due, or why no test is due; only for a loop with a page.
    "plan" [""] plan: Option<String>;
    /// Sheet of the valve test that is due, relative to the folder of the report.
    "sheet" [""] sheet: Option<String>;
}

/// A loop in the ranking, with the sources of its row.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranked<'a> {
    /// Row.
    pub row: LoopRow,
    /// Windows of the loop up to the end of the week, in order of time.
    pub windows: Vec<&'a WindowRow>,
    /// Those of the week.
    pub of_week: Vec<&'a WindowRow>,
    /// Repairs of the loop, days since 1970-01-01.
    pub repairs: Vec<i64>,
    /// Time of the last change or repair, s; minus infinity if none is known.
    pub settled: f64,
}

/// The loops of a plant, the most urgent first.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranking<'a> {
    /// Name of the plant.
    pub plant: String,
    /// The week.
    pub week: Week,
    /// The loops.
    pub loops: Vec<Ranked<'a>>,
}

impl LoopRow {
    /// Whether it is not in the work list.
    pub fn is_snoozed(&self) -> bool {
        self.snoozed_until.is_some()
    }

    /// Whether by the last test the valve sticks or does not respond.
    pub fn is_confirmed(&self) -> bool {
        matches!(self.test, Some(VerdictClass::Sticks | VerdictClass::DoesNotRespond))
    }

    /// Whether a test is due before the valve is repaired.
    pub fn is_to_test(&self) -> bool {
        self.action == Action::Repair && !self.is_confirmed() && self.overruled.is_none()
    }

    /// Whether a person or a test decides, in place of the verdict.
    pub fn is_decided(&self) -> bool {
        let decides =
            |class: Option<VerdictClass>| class.is_some_and(|c| c != VerdictClass::CannotTell);
        decides(self.overruled) || decides(self.test)
    }

    /// Whether the last test clears a valve that was to be repaired according to its windows or an order.
    pub fn is_cleared(&self) -> bool {
        let accused = [self.grade, self.verdict_before].into_iter().flatten().any(Grade::accuses);
        self.test == Some(VerdictClass::DoesNotStick)
            && self.action != Action::Repair
            && (accused || self.ordered.is_some())
    }

    /// The last test in words, without its verdict: `a test on 2026-03-04, S 3.2 % (3 to 3.5)`.
    pub fn test_in_words(&self) -> Option<String> {
        let day = self.test_day.as_ref()?;
        let s = s_in_words(self.test_s, self.test_s_low, self.test_s_high, self.test_s_below);
        Some(if s.is_empty() {
            format!("a test on {day}")
        } else {
            format!("a test on {day}, {s}")
        })
    }

    /// The change with its day and interval: `new since 2026-03-06 (2026-03-05 to 2026-03-06)`.
    pub fn change_in_words(&self) -> Option<String> {
        let day = self.change_day.as_ref()?;
        let range = match (&self.change_from, &self.change_to) {
            (Some(from), Some(to)) if from != to => format!(" ({from} to {to})"),
            _ => String::new(),
        };
        Some(format!("{}{range}", self.change.since(day)))
    }

    /// Whether the valve began to stick.
    pub fn is_new_sticking(&self) -> bool {
        matches!(self.change, Change::New | Change::Returned) && self.action == Action::Repair
    }
}

/// Ranks all loops of the plant's file and of `rows` in a week, from the rows of the week and the time before.
pub fn rank<'a>(
    plant: &Plant,
    log: &Log,
    rows: &'a [WindowRow],
    groups: &[Group],
    week: Week,
) -> Ranking<'a> {
    let end = day::begin(week.days().end() + 1, &plant.zone) as i64;
    let mut by_loop: BTreeMap<&str, Vec<&WindowRow>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.window_start < end) {
        by_loop.entry(&row.name).or_default().push(row);
    }
    let seen: BTreeSet<String> = by_loop.keys().map(|name| name.to_lowercase()).collect();
    for name in plant.file.loops.keys().filter(|name| !seen.contains(&name.to_lowercase())) {
        by_loop.insert(name, vec![]);
    }
    let by_loop: Vec<(&str, Vec<&WindowRow>)> = by_loop.into_iter().collect();
    let mut loops: Vec<Ranked<'a>> = by_loop
        .into_par_iter()
        .map(|(name, mut windows)| {
            windows.sort_by_key(|row| row.window_start);
            ranked(plant, log, name, windows, groups, week)
        })
        .collect();
    loops.sort_by(|a, b| {
        let by_priority = b.row.priority.total_cmp(&a.row.priority);
        a.row.action.cmp(&b.row.action).then(by_priority).then_with(|| a.row.name.cmp(&b.row.name))
    });
    Ranking { plant: plant.file.name.clone(), week, loops }
}

/// The entries of a loop in the log that count in a week.
struct LogEntries<'a> {
    /// Days of repairs up to its end.
    repairs: Vec<i64>,
    overruled: Option<&'a Entry>,
    snoozed: Option<i64>,
    note: Option<&'a Entry>,
    /// The day of the last order without a later repair.
    ordered: Option<i64>,
}

impl<'a> LogEntries<'a> {
    /// Of entries in the order of their days, and the days of the week.
    fn of(entries: &[&'a Entry], days: &RangeInclusive<i64>) -> Self {
        let of_kind = |kind: Kind| entries.iter().copied().filter(move |entry| entry.kind == kind);
        let holds = |entry: &&Entry| entry.until.is_none_or(|until| until >= *days.start());
        let repairs = of_kind(Kind::Repair).map(|entry| entry.day);
        let repaired = of_kind(Kind::Repair).map(|entry| entry.day).max();
        let ordered = of_kind(Kind::Order).map(|entry| entry.day).filter(|day| day <= days.end());
        let snoozed = of_kind(Kind::Snooze).filter_map(|entry| entry.until).max();
        // The last one counts. "Cannot tell" withdraws earlier ones.
        let overruled = of_kind(Kind::Override).rfind(holds);
        Self {
            repairs: repairs.filter(|day| day <= days.end()).collect(),
            overruled: overruled.filter(|e| e.verdict != Some(VerdictClass::CannotTell)),
            snoozed: snoozed.filter(|until| until > days.end()),
            ordered: ordered.max().filter(|day| repaired.is_none_or(|r| r < *day)),
            note: entries.iter().copied().rfind(|entry| entry.kind != Kind::Override),
        }
    }
}

/// The present state of a valve according to its windows, and its change.
struct Valve {
    /// Time of the last change or repair, s. Windows from then on count.
    settled: f64,
    /// The observations that count in the week.
    now: Vec<Observation>,
    history: Option<History>,
    /// The grade before the change, or else the grade of the four weeks before.
    before: Option<Grade>,
    drift: Option<Drift>,
    event: Option<Event>,
}

/// The probability of sticking up to which stiction is gone.
const GONE_UP_TO: f64 = 0.5;

impl Valve {
    /// By windows up to the end of the week; `first` is its first day, `begin` is when a day begins.
    fn of(
        windows: &[&WindowRow],
        entries: &[&Entry],
        repaired: Option<i64>,
        first: i64,
        begin: impl Fn(i64) -> f64,
    ) -> Self {
        let observed = |from: f64, to: f64| -> Vec<Observation> {
            let all = windows.iter().filter_map(|row| row.observation());
            all.filter(|seen| seen.time >= from && seen.time < to).collect()
        };
        let seen: Vec<Seen> = windows.iter().filter_map(|row| row.seen()).collect();
        let repairs = entries.iter().filter(|entry| entry.kind == Kind::Repair);
        let events = events(&seen, &repairs.map(|entry| begin(entry.day)).collect::<Vec<_>>());
        // A change on Sunday is found by Monday's data, in the week after.
        let event = events.iter().rev().find(|event| event.found >= begin(first));
        // What drifts becomes worse in the end, which is the same drift.
        let repaired = repaired.map_or(f64::NEG_INFINITY, &begin);
        let settled = present_since(&events).max(repaired);
        let now = observed(begin(first).max(settled), f64::INFINITY);
        let history = combined(&now);
        // The change must agree with the verdict on the week.
        let accused = history.as_ref().is_some_and(|history| history.grade.accuses());
        let probability = history.as_ref().and_then(|history| history.probability);
        let event = event.copied().filter(|event| match event.change {
            Change::New | Change::Returned => accused,
            Change::Gone => !accused && probability.is_none_or(|p| p <= GONE_UP_TO),
            _ => true,
        });
        let event = event.or_else(|| {
            let is_last =
                repaired == settled && begin(first) - repaired <= BEFORE as f64 * 86_400.0;
            let is_open = |from: f64, to: f64| match combined(&observed(from, to)) {
                Some(history) => !history.grade.spares(),
                None => true,
            };
            let is_told = combined(&observed(repaired, begin(first)));
            let is_told = is_told.is_some_and(|history| history.grade.accuses());
            let days: f64 = seen.iter().filter(|s| s.valve.time >= repaired).map(|s| s.days).sum();
            let sticks = is_last && accused && !is_told && days >= SIDE - 0.1;
            let still = sticks
                && is_open(repaired - BEFORE as f64 * 86_400.0, repaired)
                && is_open(repaired, begin(first));
            let (time, interval) = (repaired, (repaired, repaired));
            still.then_some(Event { change: Change::StillSticks, time, interval, found: repaired })
        });
        let until = event.map_or(begin(first), |event| event.time);
        let before = combined(&observed(until - BEFORE as f64 * 86_400.0, until));
        let drift = combined(&observed(settled, f64::INFINITY)).and_then(|history| history.drift);
        Self { settled, now, history, before: before.map(|h| h.grade), drift, event }
    }
}

fn ranked<'a>(
    plant: &Plant,
    log: &Log,
    name: &str,
    windows: Vec<&'a WindowRow>,
    groups: &[Group],
    week: Week,
) -> Ranked<'a> {
    let begin = |day: i64| day::begin(day, &plant.zone);
    let date = |time: f64| day::date(day::of(time, &plant.zone));
    let days = week.days();
    let facts = plant.facts(name);
    let entries = log.of(name);
    let LogEntries { repairs, overruled, snoozed, note, ordered } = LogEntries::of(&entries, &days);
    let last_repair = repairs.last().copied();
    let Valve { settled, now, history, before, drift, event } =
        Valve::of(&windows, &entries, last_repair, *days.start(), begin);
    let test = LastTest::of(&windows, *days.start(), last_repair, &plant.zone);
    let tested = test.as_ref().map(|test| test.window);
    let from = begin(*days.start());
    let of_week: Vec<&WindowRow> =
        windows.iter().copied().filter(|row| row.window_start as f64 >= from).collect();

    let area = facts.and_then(|facts| facts.area.clone());
    let of_area = area.as_ref().and_then(|area| plant.file.area.get(area)?.weight);
    let weight = facts.and_then(|facts| facts.weight).unwrap_or(1.0) * of_area.unwrap_or(1.0);
    // Figures are those of the valve as it is now.
    let counts = |row: &&WindowRow| row.is_judged() && row.middle() >= settled;
    let judged: Vec<&WindowRow> = of_week.iter().copied().filter(counts).collect();
    let answers = |row: &&&WindowRow| row.grade() != Some(Grade::CannotAnswer);
    let used: Vec<&&WindowRow> = judged.iter().filter(answers).collect();
    let numbers = |of: fn(&WindowRow) -> Option<f64>| -> Vec<f64> {
        judged.iter().filter_map(|row| of(row)).collect()
    };
    let typical = |of: fn(&WindowRow) -> Option<f64>| middle(&numbers(of));
    let average = |of: fn(&WindowRow) -> Option<f64>| {
        let all = numbers(of);
        (!all.is_empty()).then(|| mean(&all))
    };
    let s = estimate(at_the_end(&now, drift));
    let j = estimate(now.iter().filter_map(|seen| seen.j).collect());
    let alternative = alternative(&judged);
    let last = &judged[judged.len().saturating_sub(LAST)..];
    let oscillating = last.iter().filter(|row| row.oscillates == Some(true)).count();
    let health = Health::of(&of_week);
    // Dead or unfit data are no evidence of new stiction.
    let event = event.filter(|event| {
        health == Health::Good || !matches!(event.change, Change::New | Change::Returned)
    });

    let member = groups
        .iter()
        .find_map(|group| Some((group, group.members.iter().find(|member| member.name == name)?)));
    let period_s = typical(|row| row.period_s);
    let is_victim = member.is_some_and(|(group, member)| {
        let own = period_s.is_some_and(|own| (own / group.period_s).ln().abs() <= SAME_PERIOD.ln());
        let is_first = member.candidate_rank == Some(1);
        let sticks = |other: &Member| other.probability.is_some_and(|p| p >= LIKELY);
        own && !is_first && member.coherence >= SHARED && group.members.iter().any(sticks)
    });

    let mut row = LoopRow {
        name: name.to_owned(),
        area,
        unit: facts.and_then(|facts| facts.unit.clone()),
        loop_type: windows.last().map_or("unknown".to_owned(), |row| row.loop_type.clone()),
        weight,
        windows_judged: of_week.iter().filter(|row| row.is_judged()).count() as i64,
        windows: of_week.len() as i64,
        verdict: history.as_ref().map(|history| history.class),
        grade: history.as_ref().map(|history| history.grade),
        probability: history.as_ref().and_then(|history| history.probability),
        s: s.map(|s| s.value),
        s_low: s.map(|s| s.low),
        s_high: s.map(|s| s.high),
        j: j.map(|j| j.value),
        j_low: j.map(|j| j.low),
        j_high: j.map(|j| j.high),
        s_below: typical(|row| row.s_below),
        alternative: alternative.map(|(cause, _)| cause),
        alternative_likelihood: alternative.map(|(_, likelihood)| likelihood),
        auto_share: average(|row| row.auto_share),
        at_limit_share: average(|row| row.at_limit_share),
        travel_per_hour: average(|row| row.travel_per_hour),
        reversals_per_hour: average(|row| row.reversals_per_hour),
        period_s,
        amplitude: typical(|row| row.amplitude),
        change: event.map_or(Change::None, |event| event.change),
        change_day: event.map(|event| date(event.time)),
        change_from: event.map(|event| date(event.interval.0)),
        change_to: event.map(|event| date(event.interval.1)),
        verdict_before: before,
        windows_used: used.len() as i64,
        since: used.first().map(|row| date(row.window_start as f64)),
        until: used.last().map(|row| date((row.window_start + row.window_s - 1) as f64)),
        overruled: overruled.and_then(|entry| entry.verdict),
        override_reason: overruled.map(|entry| entry.words()),
        test: test.as_ref().map(|test| test.class),
        test_day: test.as_ref().map(|test| test.day.clone()),
        test_s: tested.and_then(|row| row.test_s),
        test_s_low: tested.and_then(|row| row.test_s_low),
        test_s_high: tested.and_then(|row| row.test_s_high),
        test_s_below: tested.and_then(|row| row.test_s_below),
        ordered: ordered.map(day::date),
        snoozed_until: snoozed.map(day::date),
        watch: facts.is_some_and(|facts| facts.watch),
        note: note.map(|entry| entry.words()),
        group: member.map(|(group, _)| group.id as i64),
        candidate_rank: member.and_then(|(_, m)| Some(m.candidate_rank? as i64)),
        health,
        error: of_week.iter().rev().find_map(|row| row.error.clone()),
        ..LoopRow::default()
    };
    row.drifts(drift, windows.last().map(|row| day::of(row.window_start as f64, &plant.zone)));
    row.decides(&Found {
        grade: row.grade,
        overruled: row.overruled,
        tested: row.test,
        health,
        oscillates: 2 * oscillating > last.len(),
        alternative,
        is_victim,
    });
    Ranked { row, windows, of_week, repairs, settled }
}

impl LoopRow {
    /// Travel of the valve or of the OP, percent of span.
    fn swing(&self) -> f64 {
        if let Some(s) = self.test_s.or(self.s) {
            return s + self.j.unwrap_or(0.0);
        }
        let Some(travel) = self.travel_per_hour else { return 0.0 };
        let by_turns = self.reversals_per_hour.filter(|turns| *turns > 0.0).map(|t| travel / t);
        let by_period = self.period_s.map(|period| travel * period / 7200.0);
        let known = [by_turns, by_period, self.s_below];
        known.into_iter().flatten().min_by(f64::total_cmp).unwrap_or(0.0)
    }

    /// The probability of the cause that the action addresses.
    pub fn likelihood(&self) -> f64 {
        let other = || self.alternative_likelihood.unwrap_or(0.5);
        match (self.action, self.overruled) {
            (Action::CheckData, _) | (Action::Repair, Some(_)) => 1.0,
            (Action::Repair, None) if self.is_confirmed() => 1.0,
            (Action::Repair, None) if self.grade == Some(Grade::DoesNotRespond) => 1.0,
            (Action::Repair | Action::Leave, _) => self.probability.unwrap_or(0.0),
            (Action::Retune | Action::LookUpstream, _) => other(),
        }
    }

    /// Sets action, severity and priority.
    fn decides(&mut self, found: &Found) {
        self.action = found.action();
        self.severity = match self.action {
            Action::CheckData => 1.0,
            _ => (self.swing() / FULL).min(1.0),
        };
        self.priority = self.weight * self.severity * self.likelihood();
    }

    /// Sets the drift of S; `today` is the last day.
    fn drifts(&mut self, drift: Option<Drift>, today: Option<i64>) {
        let Some(drift) = drift else { return };
        let weekly = |per_day: f64| 100.0 * ((7.0 * per_day).exp() - 1.0);
        self.drift = Some(weekly(drift.per_day));
        self.drift_low = Some(weekly(drift.low)).filter(|v| v.is_finite());
        self.drift_high = Some(weekly(drift.high)).filter(|v| v.is_finite());
        self.drift_p = Some(drift.p_value.max(drift.robust_p_value));
        self.drift_significant = Some(drift.significant);
        let Some((s, today)) = self.s.zip(today) else { return };
        if drift.significant && drift.per_day > 0.0 && s > 0.0 && s < FULL {
            let days = (FULL / s).ln() / drift.per_day;
            self.limit_day = (days <= FARTHEST).then(|| day::date(today + days.ceil() as i64));
        }
    }
}

/// The combined history of observations; `None` without observations.
fn combined(observations: &[Observation]) -> Option<History> {
    // Numbers in the store are finite: others were left out when rows were made.
    (!observations.is_empty()).then(|| together(observations).ok())?
}

/// S of each window. Where it drifts, each is carried to the time of the last one by the fitted drift.
fn at_the_end(now: &[Observation], drift: Option<Drift>) -> Vec<Estimate> {
    let end = now.iter().map(|seen| seen.time).fold(f64::NEG_INFINITY, f64::max);
    let per_day = drift.filter(|drift| drift.significant).map_or(0.0, |drift| drift.per_day);
    let carried = |seen: &Observation| {
        let by = (per_day * (end - seen.time) / 86_400.0).exp();
        let s = seen.s?;
        Some(Estimate { value: by * s.value, low: by * s.low, high: by * s.high })
    };
    now.iter().filter_map(carried).collect()
}

fn middle(of: &[f64]) -> Option<f64> {
    (!of.is_empty()).then(|| median(of))
}

/// The medians of values and of the ends of their intervals.
fn estimate(of: Vec<Estimate>) -> Option<Estimate> {
    let each = |part: fn(&Estimate) -> f64| middle(&of.iter().map(part).collect::<Vec<_>>());
    Some(Estimate { value: each(|e| e.value)?, low: each(|e| e.low)?, high: each(|e| e.high)? })
}

/// The likeliest other cause over windows, and its mean likelihood.
fn alternative(judged: &[&WindowRow]) -> Option<(Cause, f64)> {
    let named = judged.iter().filter(|row| row.alternative.is_some()).count();
    let sum = |cause: Cause| -> f64 {
        let own = judged.iter().filter(|row| row.alternative.as_deref() == Some(cause.name()));
        own.filter_map(|row| row.alternative_likelihood).sum()
    };
    let all = Cause::ALL.into_iter().map(|cause| (cause, sum(cause)));
    let (cause, total) = all.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (total > 0.0).then(|| (cause, total / named as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_diagnose::diagnose::VerdictClass;

    #[test]
    fn s_of_a_valve_that_gets_worse_is_that_of_the_end() {
        // S doubles each day.
        let seen = |day: f64| Observation {
            time: day * 86_400.0,
            class: VerdictClass::Sticks,
            grade: None,
            probability: Some(0.95),
            s: Some(Estimate { value: day.exp2(), low: 0.9 * day.exp2(), high: 1.1 * day.exp2() }),
            j: None,
            weight: 1.0,
            windows: 1.0,
            pool: None,
        };
        let now: Vec<Observation> = (0..7).map(|day| seen(f64::from(day))).collect();
        let per_day = 2f64.ln();
        let drift = |significant| Drift {
            per_day,
            low: per_day,
            high: per_day,
            p_value: 0.001,
            robust_per_day: per_day,
            robust_p_value: 0.001,
            significant,
        };
        let of = |drift| estimate(at_the_end(&now, drift)).unwrap();
        let end = of(Some(drift(true)));
        assert!((end.value - 64.0).abs() < 1e-9 && (end.low - 57.6).abs() < 1e-9, "{end:?}");
        for none in [None, Some(drift(false))] {
            assert_eq!(of(none).value, 8.0);
        }
    }
}
