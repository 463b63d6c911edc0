//! Compares the weekly reports of demo plants with their true values: changes, work orders, and loops with the action
//! "look upstream".
//!
//! `cargo run -p stiction-plant --example changes -- PLANT...`, with folders that `stiction plant demo` wrote and
//! `stiction plant scan` judged. A change of the demo is visible if the windows before and after it, each side
//! combined, have 80 % or more on the side that sticks and 50 % or less on the other. A change is found if a weekly
//! report shows it and the true day lies in the reported interval or next to it. Every other change in a report is
//! false, with one exception: a valve whose S grows may be reported as worse, or as new if S was too small before. The
//! report is wrong to send a loop upstream if no wave, and no valve that sticks on the last day, reaches the loop.

use std::path::Path;
use stiction_diagnose::diagnose::change::Change;
use stiction_diagnose::diagnose::together;
use stiction_plant::action::Action;
use stiction_plant::plant_file::Plant;
use stiction_plant::report::Known;
use stiction_plant::week::Week;
use stiction_plant::{Store, WindowRow, day, demo};

const DAY: f64 = 86_400.0;

/// Some of all.
#[derive(Default)]
struct Share {
    some: usize,
    all: usize,
}

impl Share {
    fn add(&mut self, is: bool) {
        self.some += usize::from(is);
        self.all += 1;
    }

    fn print(&self, what: &str) {
        let percent = 100.0 * self.some as f64 / self.all.max(1) as f64;
        println!("{what}: {} of {}, {percent:.1} %", self.some, self.all);
    }
}

/// Whether the valve of a loop sticks on the last day, by the truth.
fn sticks_last<'a>(truth: &'a str, name: &str) -> Option<&'a str> {
    let own = truth.lines().find(|line| line.split(',').next() == Some(name))?;
    own.split(',').nth(4)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [mut found, mut found_of_all, mut ordered, mut onsets, mut upstream, mut worse] =
        std::array::from_fn(|_| Share::default());
    let [mut false_changes, mut loop_weeks] = [0; 2];
    for folder in std::env::args().skip(1) {
        let folder = Path::new(&folder);
        let plant = Plant::read(folder)?;
        let rows = Store::of(folder).rows()?;
        let days = std::fs::read_dir(folder.join("data"))?.count() as f64;
        let middle = demo::FIRST_DAY + (days / 2.0).ceil() as i64;
        let at = middle as f64 * DAY;
        let truth = std::fs::read_to_string(folder.join("truth.csv"))?;
        let mut weeks: Vec<Week> = rows
            .iter()
            .map(|row| Week::of(day::of(row.window_start as f64, &plant.zone)))
            .collect();
        weeks.sort_unstable();
        weeks.dedup();
        let known: Vec<Known> = weeks
            .iter()
            .map(|week| Known::of(folder, &plant, Some(*week)))
            .collect::<Result<_, _>>()?;
        let rankings: Vec<_> = known.iter().map(|known| known.ranking(&plant)).collect();
        for line in truth.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let [name, _, story, first, last, _, _, _, _, _, reached_by, _] = cells[..] else {
                return Err(format!("truth.csv has a line without 12 cells: {line}").into());
            };
            let reports = || {
                rankings.iter().filter_map(|ranking| {
                    ranking.loops.iter().map(|ranked| &ranked.row).find(|row| row.name == name)
                })
            };
            let own = || rows.iter().filter(|row| row.name == name);
            let p = |is: &dyn Fn(&WindowRow) -> bool| {
                let seen: Vec<_> =
                    own().filter(|row| is(row)).filter_map(WindowRow::observation).collect();
                together(&seen).ok()?.probability
            };
            let before = p(&|row| (row.window_start + row.window_s) as f64 <= at);
            let after = p(&|row| row.window_start as f64 >= at);
            let in_words = || {
                let all = own().filter_map(|row| row.probability);
                let all = all.map(|p| format!("{:.0}", 100.0 * p)).collect::<Vec<_>>().join(" ");
                format!("{} {name}, {story}: {all}", folder.display())
            };
            let visible = match (first, last) {
                ("true", "false") => before >= Some(0.8) && after.is_some_and(|p| p <= 0.5),
                ("false", "true") => after >= Some(0.8) && before.is_some_and(|p| p <= 0.5),
                _ => false,
            };
            let mut is_found = false;
            for row in reports() {
                loop_weeks += 1;
                let near = |from: &Option<String>, to: &Option<String>| {
                    let day = |of: &Option<String>| day::parse(of.as_deref().unwrap_or("")).ok();
                    day(from).zip(day(to)).is_some_and(|(a, b)| (a - 1..=b + 1).contains(&middle))
                };
                let is_it = match (row.change, first, last) {
                    (Change::None, ..) => continue,
                    (Change::Gone, "true", "false")
                    | (Change::New | Change::Returned, "false", "true") => {
                        near(&row.change_from, &row.change_to)
                    }
                    // It may be too small to be seen first.
                    (Change::Worse | Change::New, "true", "true") => {
                        story.starts_with("sticks more")
                    }
                    // The data end: that is a matter of their health.
                    _ => story.starts_with("PV dead"),
                };
                is_found |= is_it;
                if !is_it {
                    false_changes += 1;
                    println!(
                        "false, {} on {:?}: {}",
                        row.change.name(),
                        row.change_day,
                        in_words()
                    );
                }
            }
            if first != last {
                found_of_all.add(is_found);
                if visible {
                    found.add(is_found);
                    if !is_found {
                        println!("missed: {}", in_words());
                    }
                }
            }
            // What the last report does about it.
            let Some(row) = reports().next_back() else { continue };
            let repair = row.action == Action::Repair;
            match (first, last) {
                ("true", "false") => {
                    ordered.add(repair);
                    if repair {
                        println!("ordered: {}", in_words());
                    }
                }
                ("false", "true") if visible => onsets.add(repair),
                _ if story.starts_with("sticks more") && row.s.is_some() => {
                    worse.add(reports().any(|row| row.change == Change::Worse));
                }
                _ => {}
            }
            if row.action == Action::LookUpstream {
                let reaches = |cause: &str| {
                    cause.starts_with("wave-") || sticks_last(&truth, cause) == Some("true")
                };
                let is_reached = reached_by.split(' ').any(reaches);
                upstream.add(!is_reached);
                if !is_reached {
                    println!(
                        "upstream, {:?} {:?}, group {:?}: {}",
                        row.alternative,
                        row.alternative_likelihood,
                        row.group,
                        in_words()
                    );
                }
            }
        }
    }
    found.print("visible changes found");
    found_of_all.print("all changes of the demo found");
    let rate = 200.0 * false_changes as f64 / f64::from(loop_weeks.max(1));
    println!(
        "false changes: {false_changes} in {loop_weeks} loop-weeks, {rate:.2} a week per 200 loops"
    );
    worse.print("valves with an S that grows, reported as worse");
    ordered.print("repaired valves with an order for repair");
    onsets.print("visible onsets with an order for repair");
    upstream.print("loops sent upstream that nothing reaches");
    Ok(())
}
