//! Compares the first and the last week of demo plants with their true values.
//!
//! `cargo run -p stiction-plant --example weeks -- PLANT...` compares folders that `stiction plant demo` wrote and `stiction
//! plant scan` judged, for two weeks or more. The first and the last week lie before and after the events. A sticking valve
//! is found if its action is a repair. A healthy valve with this action is falsely accused. A pair of a valve and a loop
//! that it reaches is found if both are in one group.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use stiction_plant::action::Action;
use stiction_plant::plant_file::Plant;
use stiction_plant::report::Known;
use stiction_plant::week::Week;
use stiction_plant::{Store, day};

#[derive(Default)]
struct Count {
    found: usize,
    of: usize,
}

impl Count {
    fn add(&mut self, found: bool) {
        self.found += usize::from(found);
        self.of += 1;
    }

    fn told(&self) -> String {
        format!(
            "{} of {}, {:.1} %",
            self.found,
            self.of,
            100.0 * self.found as f64 / self.of as f64
        )
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut sticking, mut healthy) = (Count::default(), Count::default());
    let (mut pairs, mut sources) = (Count::default(), Count::default());
    for folder in std::env::args().skip(1) {
        let folder = Path::new(&folder);
        let plant = Plant::read(folder)?;
        let rows = Store::of(folder).rows()?;
        let week_of = |begin: i64| Week::of(day::of(begin as f64, &plant.zone));
        let begins = || rows.iter().map(|row| row.window_start);
        let weeks = begins().min().zip(begins().max()).map(|(a, b)| [week_of(a), week_of(b)]);
        let truth = std::fs::read_to_string(folder.join("truth.csv"))?;
        let truth: Vec<Vec<&str>> =
            truth.lines().skip(1).map(|line| line.split(',').collect()).collect();
        for (place, week) in weeks.into_iter().flatten().enumerate() {
            let known = Known::of(folder, &plant, Some(week))?;
            let ranking = known.ranking(&plant);
            let action: BTreeMap<&str, Action> =
                ranking.loops.iter().map(|own| (&*own.row.name, own.row.action)).collect();
            let groups: Vec<BTreeMap<&str, Option<usize>>> = known
                .groups
                .iter()
                .map(|group| group.members.iter().map(|m| (&*m.name, m.candidate_rank)).collect())
                .collect();
            let sticks: BTreeSet<&str> =
                truth.iter().filter(|own| own[3 + place] == "true").map(|own| own[0]).collect();
            for own in &truth {
                let accused = action.get(own[0]) == Some(&Action::Repair);
                if sticks.contains(own[0]) {
                    sticking.add(accused)
                } else {
                    healthy.add(accused)
                }
                for source in own[10].split(' ').filter(|source| sticks.contains(source)) {
                    let both =
                        |g: &BTreeMap<_, _>| g.contains_key(own[0]) && g.contains_key(source);
                    pairs.add(groups.iter().any(both));
                }
            }
            for source in
                groups.iter().flat_map(|group| group.iter()).filter(|(n, _)| sticks.contains(**n))
            {
                sources.add(source.1.is_some_and(|rank| rank <= 3));
            }
        }
    }
    println!("valves that stick, found in the week: {}", sticking.told());
    println!("loop-weeks of others, accused: {}", healthy.told());
    println!("pairs of a valve and a loop that it reaches, in one group: {}", pairs.told());
    println!("valves that stick in a group, among its first three candidates: {}", sources.told());
    Ok(())
}
