//! A walk over demo plants: order, page, map and list of a week say the same of each loop, and a week says no more than its days.
//!
//! ```text
//! PLANTS=300 cargo test -p stiction-plant agree -- --nocapture
//! ```

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use stiction_diagnose::diagnose::Grade;
use stiction_plant::action::Action;
use stiction_plant::orders::orders;
use stiction_plant::plant_file::Plant;
use stiction_plant::ranking::Ranked;
use stiction_plant::report::{self, Known, ReportOptions};
use stiction_plant::{ScanOptions, WindowRow, demo, scan};

/// Plants of the walk, and their loops and days.
const PLANTS: u64 = 4;
const LOOPS: usize = 3;
const DAYS: usize = 3;

#[test]
fn order_page_map_and_list_agree() {
    let plants = std::env::var("PLANTS").map_or(PLANTS, |text| text.parse().unwrap());
    let (mut disagreements, mut loops, mut due) = (vec![], 0, 0);
    for seed in 1..=plants {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("agree-{seed}"));
        let _ = fs::remove_dir_all(&folder);
        demo::write(&folder, LOOPS, DAYS, 70_000 + seed, || ()).unwrap();
        let plant = Plant::read(&folder).unwrap();
        scan(&folder, &plant, &ScanOptions::default(), |_| ControlFlow::Continue(())).unwrap();
        let told = report::write(&folder, &plant, &ReportOptions { week: None, pages: 100 }, || ())
            .unwrap();
        assert_eq!(told.problems, [""; 0]);
        let written = folder.join(&told.folder);
        let index = fs::read_to_string(written.join("index.html")).unwrap();
        let listed: Vec<serde_json::Value> =
            serde_json::from_str(&fs::read_to_string(written.join("orders.json")).unwrap())
                .unwrap();
        let known = Known::of(&folder, &plant, None).unwrap();
        let mut ranking = known.ranking(&plant);
        report::size_tests(&folder, &plant, &mut ranking);
        let printed = orders(&ranking);
        for (place, ranked) in ranking.loops.iter().enumerate() {
            let row = &ranked.row;
            let mut wrong =
                |what: &str| disagreements.push(format!("seed {seed}, {}: {what}", row.name));
            loops += 1;
            due += usize::from(row.action == Action::Repair);
            let order = listed.iter().find(|order| order["loop"] == *row.name);
            if order.is_some() != (row.action == Action::Repair) {
                wrong("order and list");
            }
            let own = printed.iter().find(|order| order.name == row.name);
            if order.map(|order| order["test"].as_str().unwrap()) != own.map(|own| &*own.test) {
                wrong("the test of the order and the printed one");
            }
            if !index.contains(&format!("<g class=\"{}\" data-k=\"{place}\">", row.action.letter()))
            {
                wrong("map and list");
            }
            let page = fs::read_to_string(written.join(format!("loops/{}.html", row.name)));
            if let Ok(page) = page {
                of_page(ranked, &page, &mut wrong);
            }
            of_days(ranked, &mut wrong);
        }
        fs::remove_dir_all(&folder).unwrap();
    }
    println!("{plants} plants, {loops} loops, {due} orders, {} disagreements", disagreements.len());
    assert!(disagreements.is_empty(), "{disagreements:#?}");
}

/// Whether the first screen of a page says what the list says.
fn of_page(ranked: &Ranked<'_>, page: &str, wrong: &mut impl FnMut(&str)) {
    let row = &ranked.row;
    let grade = row.grade.unwrap_or(Grade::CannotAnswer);
    let (_, said) = page.split_once("<div class=\"said\">").unwrap();
    let (said, _) = said.split_once("<div class=\"seen\">").unwrap();
    let (badge, rest) = said.split_once("</p>").unwrap();
    if !badge.contains(grade.name()) {
        wrong(&format!("the list says {grade}, the page {badge}"));
    }
    let shown = grade.shown(row.probability).map(stiction_diagnose::spoken::percent);
    let on_page = rest.split_once(" sticks: ").and_then(|(_, p)| p.split('<').next());
    if on_page.map(str::to_owned) != shown {
        wrong(&format!("the list says {shown:?}, the page {on_page:?}"));
    }
    let (_, actions) = rest.split_once("Actions").unwrap_or(("", ""));
    let orders_work = [
        "Test the valve",
        "Repair the valve",
        "repair packing",
        "Make a signature",
        "Check air supply",
        "possible faults",
    ];
    let orders_work = orders_work.iter().any(|words| actions.contains(words));
    let is_open = row.action == Action::Leave && grade == Grade::Unclear;
    if orders_work != (row.action == Action::Repair) && !is_open {
        wrong(&format!("the list says {}, the page {actions}", row.action.name()));
    }
    if actions.contains("Leave the valve as it is") && row.action != Action::Leave {
        wrong("the page leaves the valve alone");
    }
}

/// Whether the week says what most of its days say that have such a probability, and one day what the day says.
fn of_days(ranked: &Ranked<'_>, wrong: &mut impl FnMut(&str)) {
    let row = &ranked.row;
    let judged: Vec<&&WindowRow> = ranked
        .of_week
        .iter()
        .filter(|day| day.is_judged() && day.middle() >= ranked.settled)
        .collect();
    if let [only] = judged[..]
        && row.grade != only.grade()
    {
        wrong(&format!("the week says {:?}, its only day {:?}", row.grade, only.grade()));
    }
    let accuses = row.grade.is_some_and(Grade::accuses);
    let fine = |day: &&&WindowRow| day.grade().is_some_and(Grade::spares);
    if accuses && !judged.is_empty() && judged.iter().all(fine) {
        wrong("the week accuses a valve that is fine on each day");
    }
}
