//! A report on the history of valves.

use super::layout::{Badge, Fact, Report, Section, Table};
use super::over_time::{self, Point};
use crate::Error;
use crate::document::{Valve, ValveHistory};
use crate::words::{interval, percent, sentence, spoken};
use stiction_diagnose::diagnose::Estimate;
use stiction_diagnose::spoken::counted;

const INTRODUCTION: &str = "Each window of the recordings is judged on its own and together with the others, to show \
    whether the valve gets worse. Windows of one valve are not independent: how much their agreement is worth was \
    learned from simulated valves with long records.";

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
    for change in &combined.changes {
        section = section.reason(sentence(&change.words(|at| moment(valve, at))));
    }
    section = section.reason(&combined.trend);
    if let Some(repair) = &valve.repair {
        section = section.reason(&repair.words);
    }
    section = section.fact(Fact::new("windows", valve.windows.len(), "")).fact(Fact::new(
        "windows that count",
        combined.decided,
        "",
    ));
    if let Some(p) = combined.probability {
        section = section.fact(Fact::new("combined probability of sticking", percent(p), ""));
    }
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
    let table =
        Table::new("").columns("from | duration | verdict | #probability | #S | #J | data | file");
    section.with(valve.windows.iter().fold(table, |table, w| {
        let say = |e: Option<Estimate>| e.map_or("–".to_owned(), interval);
        table.row([
            moment(valve, w.from_s),
            spoken(w.duration_s),
            Badge::from(w.grade).text(),
            w.probability.map_or("–".to_owned(), percent),
            say(w.s),
            say(w.j),
            w.fitness.name().to_owned(),
            w.file.clone(),
        ])
    }))
}

fn headline(valve: &Valve) -> String {
    let combined = &valve.combined;
    let which = valve.since();
    let n = combined.observations;
    match combined.probability {
        Some(p) if n == 1 => {
            format!("The window{which} gives a probability of sticking of {}.", percent(p))
        }
        Some(p) => format!(
            "The {n} windows{which} together give a probability of sticking of {}.",
            percent(p)
        ),
        None => format!(
            "{} of {}{which} can be judged. Together: {}.",
            combined.decided,
            counted(n, "window"),
            combined.grade
        ),
    }
}

fn moment(valve: &Valve, at: f64) -> String {
    valve.date(at).unwrap_or_else(|| spoken(at))
}
