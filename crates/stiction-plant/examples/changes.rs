//! Holds the changes that are told of demo plants against their truth.
//!
//! `cargo run -p stiction-plant --example changes -- PLANT...`, of folders that `stiction plant demo` wrote and `stiction
//! plant scan` judged. A change of the demo is visible if all windows before it and all after it, each combined, have
//! verdicts that differ: 80 % or more on the side that sticks, 50 % or less on the other. It is found if it is told with
//! the second window after it, or the first. Every other change that is told is false.

use std::path::Path;
use stiction_diagnose::diagnose::combine;
use stiction_plant::change::{Change, Seen, events};
use stiction_plant::{Store, WindowRow, demo};

const DAY: f64 = 86_400.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut visible, mut found, mut told_false, mut weeks, mut all) = (0, 0, 0, 0.0, 0);
    for folder in std::env::args().skip(1) {
        let folder = Path::new(&folder);
        let rows = Store::of(folder).rows()?;
        let begin = demo::FIRST_DAY as f64 * DAY;
        let days = std::fs::read_dir(folder.join("data"))?.count() as f64;
        let middle = begin + (days / 2.0).ceil() * DAY;
        let truth = std::fs::read_to_string(folder.join("truth.csv"))?;
        for line in truth.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let [name, _, story, sticks_first, sticks_last, ..] = cells[..] else { continue };
            let own: Vec<_> = rows.iter().filter(|row| row.name == name).collect();
            let seen: Vec<Seen> = own.iter().filter_map(|row| Seen::of(row)).collect();
            let told = events(&seen, &[], |_| f64::INFINITY);
            weeks += days / 7.0;
            // A PV that dies is a change of its own.
            if story.starts_with("PV dead") {
                continue;
            }
            let end = |row: &WindowRow| (row.window_start + row.window_s) as f64;
            let before: Vec<Seen> = own
                .iter()
                .filter(|row| end(row) <= middle)
                .filter_map(|row| Seen::of(row))
                .collect();
            let after: Vec<Seen> = own
                .iter()
                .filter(|row| row.window_start as f64 >= middle)
                .filter_map(|row| Seen::of(row))
                .collect();
            // A window of several days may lie across the change.
            let first =
                own.iter().filter(|row| end(row) > middle).filter_map(|row| Seen::of(row)).next();
            let first = first.map_or(f64::INFINITY, |seen| seen.valve.time);
            let second = after.get(1).map_or(f64::INFINITY, |seen| seen.valve.time);
            let expected = match (sticks_first, sticks_last) {
                ("true", "false") => Some(Change::Gone),
                ("false", "true") => Some(Change::New),
                _ => None,
            };
            let is_it = |change: Change| expected == Some(change);
            let wrong = told.iter().filter(|e| !(is_it(e.change) && e.told >= first)).count();
            told_false += wrong;
            if wrong > 0 {
                println!(
                    "{} {name} {story}: {wrong} false: {:?}",
                    folder.display(),
                    percents(&seen)
                );
            }
            if expected.is_some() {
                all += 1;
                let p = |side: &[Seen]| {
                    let valves: Vec<_> = side.iter().map(|seen| seen.valve).collect();
                    combine(&valves).ok()?.probability
                };
                let (a, b) = (p(&before), p(&after));
                let (sick, well) = if is_it(Change::Gone) { (a, b) } else { (b, a) };
                if sick < Some(0.8) || well > Some(0.5) || well.is_none() {
                    continue;
                }
                visible += 1;
                let hit =
                    told.iter().any(|e| is_it(e.change) && e.told >= first && e.told <= second);
                found += usize::from(hit);
                if !hit {
                    println!("{} {name} {story}: missed: {:?}", folder.display(), percents(&seen));
                }
            }
        }
    }
    println!("{found} of {visible} visible changes found within two days, of {all} in all");
    let rate = 200.0 * told_false as f64 / weeks;
    println!("{told_false} false changes in {weeks:.0} loop-weeks: {rate:.2} a week per 200 loops");
    Ok(())
}

fn percents(seen: &[Seen]) -> Vec<i64> {
    seen.iter().filter_map(|each| Some((100.0 * each.valve.probability?).round() as i64)).collect()
}
