//! A report on the history of valves.

use super::layout::{Badge, Fact, Report, Section, Table};
use super::over_time::{self, Point};
use crate::Error;
use crate::document::{Valve, ValveHistory};
use crate::words::{interval, percent, sentence, spoken};
use stiction_diagnose::diagnose::{Estimate, History};
use stiction_diagnose::spoken::counted;

const INTRODUCTION: &str = "Each window of the recordings is judged on its own and together with the others, to show \
    whether the valve gets worse. Windows of one valve are not independent. The weight of agreeing windows was learned \
    from simulated valves with long records.";

/// The report on the histories of some valves, as one self-contained HTML page.
///
/// # Errors
/// If a figure cannot be drawn, which is not expected.
pub fn history_html(history: &ValveHistory) -> Result<String, Error> {
    let title = match &history.valves[..] {
        [one] => format!("History of {}", one.name),
        several => format!("History of {} valves", several.len()),
    };
    let tool = format!("{}, format version {}", history.tool, history.version);
    let mut report = Report::new(title, tool).introduction(INTRODUCTION);
    for valve in &history.valves {
        for source in &valve.sources {
            report = report.source(source);
        }
        report = report.with(section(valve));
    }
    report.html()
}

fn section(valve: &Valve) -> Section {
    let combined = &valve.combined;
    let mut section = Section::new(&valve.name, Badge::from(combined.grade), headline(valve));
    section.facts = course(valve);
    let points: Vec<Point> = valve
        .windows
        .iter()
        .map(|w| Point {
            from: w.from_s,
            duration: w.duration_s,
            probability: w.probability,
            s: w.s,
        })
        .collect();
    let changes = combined.changes.iter().map(|event| (event.time, event.change.name()));
    let marks: Vec<(f64, &str)> =
        valve.repair.iter().map(|repair| (repair.time, "repair")).chain(changes).collect();
    section = section.heading("Over time");
    section =
        match over_time::figure(&points, valve.dated.then_some(0.0), &valve.plant_time, &marks) {
            Some(figure) => section.with(figure),
            None => {
                section.paragraph("No window has a probability or an S, so there is no figure.")
            }
        };
    section.with(windows(valve))
}

/// The windows of a valve, a row each.
pub fn windows(valve: &Valve) -> Table {
    let one_file = valve.sources.len() == 1;
    let file = if one_file { "" } else { " | file" };
    let columns = format!("from | #duration | verdict | #probability | #S | #J | data{file}");
    valve.windows.iter().fold(Table::new("").columns(&columns), |table, w| {
        let say = |e: Option<Estimate>| e.map_or("–".to_owned(), interval);
        let cells = [
            moment(valve, w.from_s),
            spoken(w.duration_s),
            Badge::from(w.grade).text(),
            w.probability.map_or("–".to_owned(), percent),
            say(w.s),
            say(w.j),
            w.fitness.name().to_owned(),
        ];
        table.row(cells.into_iter().chain((!one_file).then(|| w.file.clone())))
    })
}

/// How many windows count, and their combined probability.
pub fn headline(valve: &Valve) -> String {
    let History { decided, observations, probability, .. } = valve.combined;
    format!(
        "{decided} of {}{} {}{}.",
        counted(observations, "window"),
        valve.since(),
        if decided == 1 || observations == 1 { "counts" } else { "count" },
        probability.map_or(String::new(), |p| format!(
            ", with a probability of sticking of {}",
            percent(p)
        ))
    )
}

/// Changes, drift and repair.
pub fn course(valve: &Valve) -> Vec<Fact> {
    let combined = &valve.combined;
    let change = |words: String| Fact::new("change", sentence(&words), "");
    let changes = combined.changes.iter().map(|each| each.words(|at| moment(valve, at)));
    let mut facts: Vec<Fact> = changes.map(change).collect();
    facts.push(Fact::new("drift", sentence(&combined.trend), ""));
    facts.extend(valve.repair.as_ref().map(|repair| {
        let words = format!("at {}: {}", moment(valve, repair.time), repair.words);
        Fact::new("repair", words, "")
    }));
    facts
}

fn moment(valve: &Valve, at: f64) -> String {
    valve.date(at).unwrap_or_else(|| spoken(at))
}
