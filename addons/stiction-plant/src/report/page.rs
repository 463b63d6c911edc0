//! The page of a week: the work list, changes, a map of the plant, all loops, and the health of the data. It is one file that
//! works offline, by keyboard and on paper. Without scripts it shows all loops.

use crate::day;
use crate::groups::{Group, Source};
use crate::report::action::Action;
use crate::report::health::Health;
use crate::report::orders::{Order, WorkOrder, capital, to_do};
use crate::report::ranking::{FULL, LoopRow, Ranked, Ranking};
use crate::report::treemap::{AreaTile, LoopTile, NOWHERE, Tile, map};
use crate::store::window::ENGINE_VERSION;
use crate::unknown::{self, Unknown};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::collections::BTreeMap;
use std::fmt::Write;
use stiction_diagnose::diagnose::Grade;
use stiction_diagnose::diagnose::change::Change;
use stiction_diagnose::spoken::counted;
use stiction_figure::page::relative;
use stiction_report::report::layout::{Badge, STYLE, TABLES};
use stiction_report::words::{percent, rough, spoken};

/// Name of the page.
pub const INDEX: &str = "index.html";
const OWN_STYLE: &str = include_str!("page.css");
const OWN_SCRIPT: &str = include_str!("page.js");
/// The most changes of a box; the list of loops has all.
const LINES: usize = 20;
/// Orders on the first screen.
const FIRST: usize = 6;
/// Windows of a small history.
const POINTS: usize = 42;
/// Size, px.
pub const SPARK: (f64, f64) = (84.0, 22.0);
/// For a wide and a narrow screen: width of the map, its height, the additional height per loop, and the largest
/// height.
const MAPS: [(&str, f64, f64, f64, f64); 2] =
    [("wide", 1240.0, 120.0, 1.0, 420.0), ("narrow", 350.0, 160.0, 2.0, 560.0)];
/// A less likely cause is left out of the list: beside a valve that sticks it reads as doubt.
const LEAST_LIKELY: f64 = 0.1;
/// Width of a letter of a tag on the map.
const LETTER: f64 = 5.4;

/// The page.
pub fn page(
    ranking: &Ranking<'_>,
    orders: &[Order],
    groups: &[Group],
    unknown: &[Unknown],
) -> String {
    let title = format!("{}, week {}", ranking.plant, ranking.week);
    let days = ranking.week.days();
    let (first, last) = (day::date(*days.start()), day::date(*days.end()));
    let rows = || ranking.loops.iter().map(|ranked| &ranked.row);
    let judged = rows().filter(|row| row.windows_judged > 0).count();
    let windows: i64 = rows().map(|row| row.windows).sum();
    let windows_judged: i64 = rows().map(|row| row.windows_judged).sum();
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (stiction_figure::page::head(&title, &[STYLE, OWN_STYLE]))
            body.index.plant {
                header {
                    h1 { (title) }
                    p.soft {
                        (first) " to " (last) " · " (counted(ranking.loops.len(), "loop")) ", "
                        (judged) " judged, by " (windows_judged) " of " (counted(windows as usize, "window"))
                    }
                    @if !unknown.is_empty() {
                        p.unknown { a href="#unknown" { "Not known" } ": " (unknown::counted_words(unknown)) "." }
                    }
                }
                main {
                    div.first { (work(orders)) (changed(ranking)) }
                    (treemap(ranking))
                    h2 #loops { "Loops" }
                    (chips(ranking))
                    (tree(ranking))
                    (table(ranking))
                    (columns(ranking))
                    (together(groups, ranking))
                    (not_known(unknown))
                    (health(ranking))
                }
                footer { p { "stiction " (ENGINE_VERSION) } }
                script { (PreEscaped(TABLES)) (PreEscaped(OWN_SCRIPT)) }
            }
        }
    };
    page.into_string()
}

/// What changed in the week, the worst first.
fn changed(ranking: &Ranking<'_>) -> Markup {
    let mut changed: Vec<&LoopRow> =
        ranking.loops.iter().map(|r| &r.row).filter(|row| row.change != Change::None).collect();
    changed.sort_by_key(|row| row.change);
    html! {
        section.box aria-labelledby="changed" {
            h2 #changed { "Changes this week" }
            @if changed.is_empty() { p { "No significant change this week." } }
            @else {
                ul.changes {
                    @for row in changed.iter().take(LINES) {
                        li { b.change.(row.change.name()) { (row.change.name()) } " " (name(row)) " " span.soft { (change_in_words(row)) } }
                    }
                }
                @if changed.len() > LINES {
                    p { "The list below has " (counted(changed.len() - LINES, "more changed loop")) "." }
                }
            }
            p.soft { "New: the valve sticks now and did not before. Returned: the valve sticks again. Still sticks: the valve sticks after a repair. Worse or \
                      better: S grew or shrank. Gone: the valve probably stuck before, and the probability is now at most 50 %." }
        }
    }
}

/// A change in words, after its name.
fn change_in_words(row: &LoopRow) -> String {
    let words = row.change_in_words().unwrap_or_default();
    let mut words = words.trim_start_matches(row.change.name()).trim_start().to_owned();
    if let (Some(before), Some(grade)) = (row.verdict_before, row.grade) {
        let _ = write!(words, ", {before} before, {grade} now");
    }
    words
}

/// The name of a loop, with a link to its page if one exists.
fn linked(name: &str, page: Option<&String>) -> Markup {
    html! { @match page { Some(path) => a href=(relative(path)) { (name) }, None => (name) } }
}

fn name(row: &LoopRow) -> Markup {
    linked(&row.name, row.page.as_ref())
}

/// Areas, and loops in them, as tiles.
fn treemap(ranking: &Ranking<'_>) -> Markup {
    html! {
        section aria-labelledby="map" {
            h2 #map { "Plant map" }
            p.key {
                "Each tile is a loop, sized by its weight. Press a tile to find the loop in the list. "
                @for action in Action::ALL {
                    span.{ "tile " (action.letter()) } { (action.letter()) } " " (action.name()) " "
                }
            }
            @for (class, width, least, each, most) in MAPS {
                (PreEscaped(drawn(ranking, class, width, (least + each * ranking.loops.len() as f64).min(most))))
            }
        }
    }
}

fn drawn(ranking: &Ranking<'_>, class: &str, width: f64, height: f64) -> String {
    let whole = Tile { x: 0.0, y: 0.0, w: width, h: height };
    let mut svg = format!(
        "<svg class=\"map {class}\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"Loops by area and weight, as in the list below\">"
    );
    for AreaTile { area, tile, loops } in map(ranking.loops.iter().map(|r| &r.row), whole) {
        let most = (tile.w / 7.5) as usize;
        let label: String = area.chars().take(most).collect();
        let _ = write!(
            svg,
            "<text class=\"area\" x=\"{:.0}\" y=\"{:.0}\">{}</text>",
            tile.x + 2.0,
            tile.y + 12.0,
            html! { (label) }.into_string()
        );
        for LoopTile { place, tile } in loops {
            let row = &ranking.loops[place].row;
            let letter = row.action.letter();
            let _ = write!(
                svg,
                "<g class=\"{letter}\" data-k=\"{place}\"><path d=\"M{:.1} {:.1}h{:.1}v{:.1}h-{:.1}z\"/>",
                tile.x, tile.y, tile.w, tile.h, tile.w
            );
            let (x, y) = (tile.x + tile.w / 2.0, tile.y + tile.h / 2.0 + 4.0);
            let has_tag =
                tile.w >= LETTER * row.name.chars().count() as f64 + 2.0 && tile.h >= 24.0;
            if has_tag {
                let tag = html! { (row.name) }.into_string();
                let _ = write!(svg, "<text x=\"{x:.0}\" y=\"{:.0}\">{letter}</text>", y - 5.0);
                let _ = write!(
                    svg,
                    "<text class=\"tag\" x=\"{x:.0}\" y=\"{:.0}\">{tag}</text>",
                    y + 6.0
                );
            } else if tile.w >= 9.0 && tile.h >= 11.0 {
                let _ = write!(svg, "<text x=\"{x:.0}\" y=\"{y:.0}\">{letter}</text>");
            }
            svg += "</g>";
        }
    }
    svg + "</svg>"
}

/// Buttons that narrow the list down: by action, change, and list.
fn chips(ranking: &Ranking<'_>) -> Markup {
    let count = |is: &dyn Fn(&LoopRow) -> bool| ranking.loops.iter().filter(|r| is(&r.row)).count();
    let lists: [(&str, &str, usize); 3] = [
        ("open", "open", count(&|row| !row.is_snoozed())),
        ("watched", "watched", count(&|row| row.watch)),
        ("snoozed", "snoozed", count(&LoopRow::is_snoozed)),
    ];
    html! {
        div.chips data-chips role="group" aria-label="Actions" {
            @for action in Action::ALL {
                @let loops = count(&|row| row.action == action);
                @if loops > 0 {
                    button type="button" data-by="action" data-only=(action.name()) aria-pressed="false" {
                        b.{ "tile " (action.letter()) } { (action.letter()) } " " (action.name()) " " span data-count { (loops) }
                    }
                }
            }
        }
        div.chips data-chips role="group" aria-label="Changes and lists" {
            @for change in Change::ALL.into_iter().filter(|change| *change != Change::None) {
                @let loops = count(&|row| row.change == change);
                @if loops > 0 {
                    button type="button" data-by="change" data-only=(change.name()) aria-pressed="false" {
                        (change.name()) " " span data-count { (loops) }
                    }
                }
            }
            @for (key, word, loops) in lists {
                button type="button" data-by="list" data-only=(key) aria-pressed=(key == "open") {
                    (word) " " span data-count { (loops) }
                }
            }
        }
    }
}

/// Loops of a place.
#[derive(Default, Clone, Copy)]
struct Count {
    loops: usize,
    judged: usize,
    repair: usize,
}

impl Count {
    fn add(&mut self, row: &LoopRow) {
        self.loops += 1;
        self.judged += usize::from(row.windows_judged > 0);
        self.repair += usize::from(row.action == Action::Repair);
    }

    fn words(self) -> String {
        let judged = format!("{} of {} judged", self.judged, self.loops);
        if self.repair == 0 { judged } else { format!("{judged}, {} to repair", self.repair) }
    }
}

/// Site, areas and units, with counts, which narrow the list down.
fn tree(ranking: &Ranking<'_>) -> Markup {
    let mut site = Count::default();
    let mut areas: BTreeMap<&str, (Count, BTreeMap<&str, Count>)> = BTreeMap::new();
    for Ranked { row, .. } in &ranking.loops {
        site.add(row);
        let (count, units) = areas.entry(row.area.as_deref().unwrap_or(NOWHERE)).or_default();
        count.add(row);
        if let Some(unit) = row.unit.as_deref() {
            units.entry(unit).or_default().add(row);
        }
    }
    let button = |place: &str, word: &str, count: Count| {
        html! {
            button type="button" data-by="place" data-only=(place) aria-pressed="false" {
                b { (word) } " " span.soft { (count.words()) }
            }
        }
    };
    html! {
        details.tree open[areas.len() <= 12] {
            summary { (ranking.plant) ", " (site.words()) }
            div data-chips role="group" aria-label="Areas and units" {
                ul {
                    @for (area, (count, units)) in &areas {
                        li {
                            (button(area, area, *count))
                            @if !units.is_empty() {
                                details {
                                    summary { (counted(units.len(), "unit")) }
                                    @for (unit, count) in units { (button(&format!("{area}/{unit}"), unit, *count)) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A column of the list of loops.
struct Head {
    name: &'static str,
    /// Whether its cells are numbers.
    is_number: bool,
    /// Width, px: a table that is measured anew takes a second to sort.
    width: u32,
    meaning: &'static str,
}

const fn head(name: &'static str, is_number: bool, width: u32, meaning: &'static str) -> Head {
    Head { name, is_number, width, meaning }
}

const HEADS: [Head; 17] = [
    head("Loop", false, 104, "Tag, area and unit."),
    head("Action", false, 92, "What to do: repair, retune, look upstream, check data or leave."),
    head("Priority", true, 58, "Weight × severity × probability."),
    head("Verdict", false, 100, "Verdict on the valve after its last change or repair."),
    head("Prob., %", true, 50, "Probability that the valve sticks."),
    head(
        "S, %",
        true,
        50,
        "Stick band plus dead band, % of span. “< 3” means no stiction: an S above this limit would have been detected.",
    ),
    head("J, %", true, 44, "Slip jump, % of span."),
    head("Change", false, 84, "Change in the week, with its day."),
    head(
        "History",
        false,
        88,
        "Line: probability from 0 to 100 %. Dots: S from 0 to its largest value. Upright lines: repairs.",
    ),
    head(
        "S drift, % of S/week",
        true,
        112,
        "Growth of S a week, % of S. Bold: significant, with the day on which S reaches 10 %.",
    ),
    head("In auto, %", true, 44, "Share of the time in automatic (service factor)."),
    head("OP at limit, %", true, 50, "Share of the time with the OP at a limit."),
    head("OP travel, %/h", true, 56, "OP travel, up and down, an hour."),
    head("Reversals, 1/h", true, 76, "OP reversals an hour."),
    head("Other cause", false, 112, "Likeliest cause other than stiction (likelihood from 10 %)."),
    head("Period", false, 78, "Period of the oscillation."),
    head(
        "Notes",
        false,
        0,
        "Watch list, group, overrides, repairs, orders and notes, and the last valve test.",
    ),
];

/// The place of the column of J in [`HEADS`].
const J: usize = 6;

/// The columns that are shown: that of J only if a loop has one.
fn shown(ranking: &Ranking<'_>) -> Vec<&'static Head> {
    let has_j = ranking.loops.iter().any(|ranked| ranked.row.j.is_some());
    HEADS.iter().enumerate().filter(|(k, _)| *k != J || has_j).map(|(_, head)| head).collect()
}

fn table(ranking: &Ranking<'_>) -> Markup {
    let heads = shown(ranking);
    let has_j = heads.len() == HEADS.len();
    html! {
        div.rows tabindex="0" role="region" aria-label="Loops" {
            table.loops data-sortable {
                colgroup {
                    @for head in &heads {
                        @if head.width > 0 { col style={ "width:" (head.width) "px" }; } @else { col; }
                    }
                }
                thead {
                    tr {
                        @for head in &heads {
                            th scope="col" title=(head.meaning) class=[head.is_number.then_some("number")] { (head.name) }
                        }
                    }
                }
                tbody { @for (place, ranked) in ranking.loops.iter().enumerate() { (row(place, ranked, has_j)) } }
            }
        }
    }
}

/// What the columns mean, and how the priority is calculated.
fn columns(ranking: &Ranking<'_>) -> Markup {
    html! {
        details #columns {
            summary { "What the columns mean" }
            dl { @for head in shown(ranking) { dt { (head.name) } dd { (head.meaning) } } }
            p {
                b { "Weight" } " is the weight of the loop times the weight of its area, both from plant.toml. "
                b { "Severity" } " is S + J over " (FULL) " % of span, at most 1. If S and J are unknown, the smallest of three values \
                replaces S + J: OP travel between two reversals, OP travel in half a period, and the detection limit. "
                b { "Probability" } " is the probability of stiction; for “retune” and “look upstream”, of the other cause. For “check data”, \
                severity and probability are 1."
            }
        }
    }
}

fn row(place: usize, ranked: &Ranked<'_>, has_j: bool) -> Markup {
    let row = &ranked.row;
    let area = row.area.as_deref().unwrap_or(NOWHERE);
    let places = row.unit.as_ref().map(|unit| format!("{area}|{area}/{unit}"));
    let list = match (row.is_snoozed(), row.watch) {
        (false, false) => "open",
        (false, true) => "open|watched",
        (true, false) => "snoozed",
        (true, true) => "snoozed|watched",
    };
    let change = (row.change != Change::None).then(|| row.change.name());
    let cell = |value: Option<f64>| number(value.map(|v| (v, rough(v))));
    let share = |value: Option<f64>| number(value.map(|v| (v, format!("{v:.0}"))));
    let s = match (row.s, row.s_below) {
        (Some(s), _) => Some((s, rough(s))),
        (None, below) => below
            .filter(|_| row.grade.is_some_and(Grade::spares))
            .map(|limit| (limit, format!("<\u{a0}{}", rough(limit)))),
    };
    let range = row.s_low.zip(row.s_high).map(|(a, b)| format!("{} to {}", rough(a), rough(b)));
    html! {
        tr #{ "k" (place) } data-action=(row.action.name()) data-place=(places.as_deref().unwrap_or(area))
            data-change=(row.change.name()) data-list=(list)
        {
            th scope="row" {
                (name(row))
                small { (area) @if let Some(unit) = &row.unit { " · " (unit) } }
            }
            td data-value=(row.action as usize) { b.{ "tile " (row.action.letter()) } { (row.action.letter()) } " " (row.action.name()) }
            td.number title=(format!("{} × {} × {}", rough(row.weight), rough(row.severity), rough(row.likelihood()))) { (if row.priority < 0.01 { "0".to_owned() } else { rough(row.priority) }) }
            (verdict(row))
            (number(row.grade.and_then(|grade| grade.shown(row.probability)).map(|p| (p, percent(p).replace("more than ", ">\u{a0}").replace("less than ", "<\u{a0}").replace(" %", "")))))
            @match s {
                Some((value, text)) => td.number data-value=(short(value)) title=[range] { (text) },
                None => td.number { "–" },
            }
            @if has_j { (cell(row.j)) }
            td { @if let Some(word) = change {
                b.change.(word) { (word) }
                @if let Some(day) = &row.change_day { small { (day) } }
            } }
            td { (PreEscaped(spark(ranked))) }
            (drift(row))
            (share(row.auto_share)) (share(row.at_limit_share)) (cell(row.travel_per_hour)) (cell(row.reversals_per_hour))
            @match row.alternative.zip(row.alternative_likelihood).filter(|(_, p)| *p >= LEAST_LIKELY) {
                Some((cause, p)) => td title=(percent(p)) { (cause.name()) },
                None => td {},
            }
            @match row.period_s {
                Some(period) => td.whole data-value=(short(period)) { (spoken(period)) },
                None => td { "–" },
            }
            td { (notes(row)) }
        }
    }
}

fn verdict(row: &LoopRow) -> Markup {
    let place = row.grade.and_then(|grade| Grade::ALL.iter().position(|each| *each == grade));
    html! {
        td data-value=(place.unwrap_or(Grade::ALL.len())) {
            @match row.grade {
                Some(grade) => { @let Badge { symbol, word, .. } = Badge::from(grade); (symbol) " " (word) },
                None => (row.health.name()),
            }
            @if let Some(other) = row.overruled { small { "override: " (other.name()) } }
        }
    }
}

/// A number by which rows are sorted, with the text that is shown for it.
fn number(of: Option<(f64, String)>) -> Markup {
    match of {
        // What is shown is what it is sorted by, unless it begins with a sign.
        Some((value, text)) if text.starts_with(['<', '>']) => {
            html! { td.number data-value=(short(value)) { (text) } }
        }
        Some((value, text)) if text.contains('e') => {
            html! { td.number data-value=(short(value)) { (text) } }
        }
        Some((_, text)) => html! { td.number { (text) } },
        None => html! { td.number { "–" } },
    }
}

/// A number to sort by.
fn short(value: f64) -> String {
    format!("{value:.3}")
}

fn drift(row: &LoopRow) -> Markup {
    let Some(drift) = row.drift else { return html! { td.number { "–" } } };
    let text = match drift.abs() {
        ..0.1 => "0".to_owned(),
        _ => format!("{}{}", if drift > 0.0 { "+" } else { "" }, rough(drift)),
    };
    let told = row.drift_p.map(|p| {
        let ends = row.drift_low.zip(row.drift_high);
        let ends =
            ends.map_or(String::new(), |(a, b)| format!("{} to {} % a week, ", rough(a), rough(b)));
        format!("{ends}p = {p:.3}")
    });
    html! {
        td.number data-value=(short(drift)) title=[told] {
            @if row.drift_significant == Some(true) { b { (text) } } @else { span.soft { (text) } }
            @if let Some(day) = &row.limit_day { small { (FULL) " % by " (day) } }
        }
    }
}

fn notes(row: &LoopRow) -> Markup {
    html! {
        @if row.watch { small { "watched" } }
        @if let Some(id) = row.group { small { a href={ "#group-" (id) } { "group " (id) } } }
        @if let Some(reason) = &row.override_reason { small { "override: " (reason) } }
        @if let (Some(class), Some(test)) = (row.test, row.test_in_words()) {
            small { (test) ": " (class.name()) }
        }
        @if let Some(note) = &row.note { small { (note) } }
        @if let Some(error) = &row.error { small { "error: " (error) } }
    }
}

/// p and S of the last windows in little, with repairs: paths of SVG, of [`SPARK`] px.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, schemars::JsonSchema)]
pub struct Spark {
    /// Upright lines, at repairs.
    pub repairs: String,
    /// p as a line, from 0 to 100 %.
    pub probability: String,
    /// S as dots, from 0 to its largest.
    #[serde(rename = "S")]
    pub s: String,
}

impl Spark {
    /// Of the last windows of a loop; empty without a window.
    pub fn of(ranked: &Ranked<'_>) -> Self {
        let windows = &ranked.windows[ranked.windows.len().saturating_sub(POINTS)..];
        let mut spark = Self::default();
        let (Some(first), Some(last)) = (windows.first(), windows.last()) else { return spark };
        let (begin, end) = (first.window_start as f64, (last.window_start + last.window_s) as f64);
        let x = |row: &crate::store::window::WindowRow| {
            SPARK.0 * (row.window_start as f64 + row.window_s as f64 / 2.0 - begin) / (end - begin)
        };
        let mut pen: Option<(i64, i64)> = None;
        for row in windows {
            let Some(p) = row.probability else {
                pen = None;
                continue;
            };
            let at = (x(row).round() as i64, (1.0 + (SPARK.1 - 2.0) * (1.0 - p)).round() as i64);
            let _ = match pen {
                None => write!(spark.probability, "M{} {}l0 0", at.0, at.1),
                Some(from) => write!(spark.probability, " {} {}", at.0 - from.0, at.1 - from.1),
            };
            pen = Some(at);
        }
        let most = windows.iter().filter_map(|row| row.s).fold(0.0, f64::max);
        for row in windows {
            if let Some(s) = row.s.filter(|_| most > 0.0) {
                let y = 1.0 + (SPARK.1 - 2.0) * (1.0 - s / most);
                let _ = write!(spark.s, "M{:.0} {:.0}h0", x(row), y);
            }
        }
        for repair in &ranked.repairs {
            let at = SPARK.0 * (*repair as f64 * 86_400.0 - begin) / (end - begin);
            if (0.0..=SPARK.0).contains(&at) {
                let _ = write!(spark.repairs, "M{at:.0} 0V{}", SPARK.1);
            }
        }
        spark
    }
}

fn spark(ranked: &Ranked<'_>) -> String {
    if ranked.windows.is_empty() {
        return String::new();
    }
    let of = Spark::of(ranked);
    let mut svg = format!(
        "<svg class=\"spark\" viewBox=\"0 0 {} {}\" aria-hidden=\"true\">",
        SPARK.0, SPARK.1
    );
    for (class, d) in [("r", of.repairs), ("p", of.probability), ("s", of.s)] {
        if !d.is_empty() {
            let _ = write!(svg, "<path class=\"{class}\" d=\"{d}\"/>");
        }
    }
    svg + "</svg>"
}

/// Candidates for the source of a group that are listed first.
const CANDIDATES: usize = 3;

fn together(groups: &[Group], ranking: &Ranking<'_>) -> Markup {
    let link = |name: &str| {
        let place = ranking.loops.iter().position(|ranked| ranked.row.name == name);
        html! { @match place { Some(k) => a href={ "#k" (k) } { (name) }, None => (name) } }
    };
    html! {
        @if !groups.is_empty() {
            h2 #groups { "Loops that swing together" }
            @for group in groups {
                section.box #{ "group-" (group.id) } {
                    p {
                        b { "Group " (group.id) ": " } "these loops swing together with a period of " (spoken(group.period_s)) ": "
                        @for (k, member) in group.members.iter().enumerate() { @if k > 0 { ", " } (link(&member.name)) }
                        "."
                    }
                    @match group.source {
                        Source::NotRecorded => p { "The source is not among the recorded loops." },
                        Source::Candidates => {
                            @let mut ranked: Vec<_> = group.members.iter().filter(|m| m.candidate_rank.is_some()).collect();
                            @let () = ranked.sort_by_key(|member| member.candidate_rank);
                            @let (first, rest) = ranked.split_at(ranked.len().min(CANDIDATES));
                            p { "Candidates for the source, by probability, wave shape and the loops upstream:" }
                            ol { @for member in first { li { (link(&member.name)) ": " (member.reasons.join(" ")) } } }
                            @if !rest.is_empty() {
                                details {
                                    summary { (counted(rest.len(), "less likely candidate")) }
                                    ol start=(CANDIDATES + 1) {
                                        @for member in rest { li { (link(&member.name)) ": " (member.reasons.join(" ")) } }
                                    }
                                }
                            }
                        },
                    }
                    // The first reason repeats the period.
                    @if group.reasons.len() > 1 { p.soft { (group.reasons[1..].join(" ")) } }
                }
            }
        }
    }
}

fn work(orders: &[Order]) -> Markup {
    let (first, rest) = orders.split_at(orders.len().min(FIRST));
    html! {
        section.box aria-labelledby="orders" {
            h2 #orders { "Work list" }
            @if orders.is_empty() { p { "No valve needs a repair." } }
            ol.work { @for order in first { (line(order)) } }
            @if !rest.is_empty() {
                details data-print {
                    summary { (counted(rest.len(), "more order")) }
                    ol.work start=(FIRST + 1) { @for order in rest { (line(order)) } }
                }
            }
            p.soft {
                (counted(to_do(orders), "order")) " to do"
                @if to_do(orders) < orders.len() { ", " (orders.len() - to_do(orders)) " closed by a test" }
                ". For a CMMS: " a href="work-orders.csv" download { "work-orders.csv" } ". With evidence: "
                a href="orders.csv" download { "orders.csv" } ", " a href="orders.json" download { "orders.json" } ". All loops: "
                a href="ranking.csv" download { "ranking.csv" } ", " a href="ranking.json" download { "ranking.json" } ", "
                a href="ranking.parquet" download { "ranking.parquet" } "."
            }
        }
    }
}

fn line(order: &Order) -> Markup {
    html! {
        li {
            b { (linked(&order.name, order.page.as_ref())) }
            " " (capital(&order.finding)) "." span.soft { " Priority class " (WorkOrder::from(order).priority) " of 4, " (order.status.name()) "." }
            details data-print {
                summary { "Action, evidence and test" }
                p { (order.action) "." }
                p { "Evidence: " (order.evidence) "." }
                p {
                    "Test: " (order.test) "."
                    @if let Some(sheet) = &order.sheet { " " a href=(relative(sheet)) { "Test sheet" } "." }
                }
                @if let Some(note) = &order.note { p.soft { (note) } }
            }
        }
    }
}

/// What was not read and not judged, with the reasons.
fn not_known(unknown: &[Unknown]) -> Markup {
    html! {
        h2 #unknown { "Not known" }
        @if unknown.is_empty() { p { "All data were read, and all windows judged." } }
        @for (kind, count) in unknown::counts(unknown) {
            @let all: Vec<&Unknown> = unknown.iter().filter(|each| each.kind == kind).collect();
            details open[all.len() <= FIRST] {
                summary { (kind.counted(count)) }
                ul {
                    @for each in all.iter().take(100) { li { (each.words()) } }
                    @if all.len() > 100 { li { (all.len() - 100) " more; stiction plant status lists all" } }
                }
            }
        }
    }
}

fn health(ranking: &Ranking<'_>) -> Markup {
    let of = |health: Health| -> Vec<&LoopRow> {
        ranking.loops.iter().map(|ranked| &ranked.row).filter(|row| row.health == health).collect()
    };
    html! {
        h2 #health { "Health of the data" }
        @if of(Health::Good).len() == ranking.loops.len() { p { "The data of all loops are good." } }
        @for kind in Health::ALL.into_iter().filter(|health| *health != Health::Good) {
            @let rows = of(kind);
            @if !rows.is_empty() {
                details data-print {
                    summary { (kind.name()) ": " (counted(rows.len(), "loop")) }
                    ul {
                        @for row in rows.iter().take(100) {
                            li { (name(row)) @if let Some(error) = &row.error { ": " (error) } }
                        }
                        @if rows.len() > 100 { li { (rows.len() - 100) " more; ranking.csv lists all" } }
                    }
                }
            }
        }
    }
}
