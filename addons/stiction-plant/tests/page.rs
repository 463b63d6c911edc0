//! The ranking and the page of a week, of rows that are made up.

use crate::made_up;

use made_up::MadeUp;
use stiction_diagnose::diagnose::change::Change;
use stiction_plant::action::Action;
use stiction_plant::demo;
use stiction_plant::groups::{Group, Member, Source};
use stiction_plant::health::Health;
use stiction_plant::log::Log;
use stiction_plant::orders::orders;
use stiction_plant::page::page;
use stiction_plant::plant_file::Plant;
use stiction_plant::ranking::{LoopRow, Ranking, rank};
use stiction_plant::table::Row;
use stiction_plant::week::Week;

fn made_up(loops: usize) -> MadeUp {
    MadeUp { loops, first_number: 1001, first_day: demo::FIRST_DAY, late_days: 4 }
}

fn name(k: usize) -> String {
    made_up(0).name(k)
}

fn plant(loops: usize) -> Plant {
    let head = "name = \"North refinery\"\nzone = \"UTC\"\ndata = [\"*.csv\"]\n";
    Plant::parse(&(head.to_owned() + &made_up(loops).plant_toml()), "plant.toml").unwrap()
}

fn log() -> Log {
    let text = format!(
        "[[entry]]\nkind = \"override\"\nloop = \"{}\"\nday = 2026-03-20\nby = \"J. Miller\"\nverdict = \"does not stick\"\n\
         text = \"stroked on the bench\"\n\
         [[entry]]\nkind = \"snooze\"\nloop = \"{}\"\nday = 2026-03-20\nuntil = 2026-04-20\ntext = \"WO 4711\"\n\
         [[entry]]\nkind = \"repair\"\nloop = \"{}\"\nday = 2026-03-26\ntext = \"new packing\"\n",
        name(14),
        name(15),
        name(45)
    );
    Log::parse(&text, "log.toml").unwrap()
}

fn groups() -> Vec<Group> {
    let member = |k: usize, candidate_rank: Option<usize>| Member {
        name: name(k),
        probability: Some(if k == 28 { 0.97 } else { 0.1 }),
        coherence: 0.9,
        candidate_rank,
        reasons: vec!["its valve is the likeliest to stick.".to_owned()],
    };
    let members = vec![member(28, Some(1)), member(16, Some(2)), member(17, None)];
    vec![
        Group {
            id: 1,
            period_s: 260.0,
            members: members.clone(),
            source: Source::Candidates,
            reasons: vec![],
        },
        Group {
            id: 2,
            period_s: 900.0,
            members: members[2..].to_vec(),
            source: Source::NotRecorded,
            reasons: vec![],
        },
    ]
}

fn of<'a>(ranking: &'a Ranking<'_>, k: usize) -> &'a LoopRow {
    ranking.loops.iter().map(|ranked| &ranked.row).find(|row| row.name == name(k)).unwrap()
}

#[test]
fn a_week_of_a_thousand_loops_is_ranked_and_fits_a_page() {
    let (plant, rows, log, groups) = (plant(1000), made_up(1000).rows(), log(), groups());
    let week: Week = "2026-W13".parse().unwrap();
    let ranking = rank(&plant, &log, &rows, &groups, week);
    assert_eq!(ranking.loops.len(), 1000);

    let sticking = of(&ranking, 28);
    assert_eq!(
        (sticking.action, sticking.change, sticking.windows_judged),
        (Action::Repair, Change::None, 7)
    );
    assert_eq!(
        sticking.weight,
        4.0 * plant.file.area[sticking.area.as_ref().unwrap()].weight.unwrap()
    );
    let expected = sticking.weight
        * ((sticking.s.unwrap() + sticking.j.unwrap()) / 10.0).min(1.0)
        * sticking.probability.unwrap();
    assert!((sticking.priority - expected).abs() < 1e-12);
    assert_eq!(sticking.drift_significant, Some(true));
    // 0.8 % of the first day a day.
    assert!((3.0..8.0).contains(&sticking.drift.unwrap()), "{:?}", sticking.drift);
    assert!(sticking.limit_day.is_some(), "{sticking:?}");
    assert_eq!((sticking.group, sticking.candidate_rank), (Some(1), Some(1)));
    assert_eq!(of(&ranking, 16).action, Action::LookUpstream);

    let overruled = of(&ranking, 14);
    assert_eq!(overruled.verdict.unwrap().name(), "sticks", "what is computed stays");
    assert_ne!(overruled.action, Action::Repair);
    assert!(of(&ranking, 15).is_snoozed());
    let began = of(&ranking, 30);
    assert_eq!((began.change, began.change_day.as_deref()), (Change::New, Some("2026-03-26")));
    assert!(began.is_new_sticking(), "by the days since, not by the week: {began:?}");
    let repaired = of(&ranking, 45);
    assert_eq!((repaired.change, repaired.action), (Change::Gone, repaired.action));
    assert!(repaired.probability < Some(0.3), "what was before the repair says nothing of it");
    assert_eq!(of(&ranking, 5).health, Health::NoData);
    assert_eq!(of(&ranking, 11).health, Health::Errors);
    assert_eq!(of(&ranking, 9).health, Health::Frozen);
    let changed = ranking.loops.iter().filter(|ranked| ranked.row.change != Change::None).count();
    assert_eq!(
        changed,
        (0..1000)
            .filter(|k| matches!(k % 14, 2 | 3) && k % 5 == 0 && k % 97 != 5 && k % 97 != 11)
            // The PV of these is frozen.
            .filter(|k| k % 83 != 9)
            .count()
    );

    let orders = orders(&ranking);
    assert!(orders.iter().all(|order| order.name != name(14) && order.name != name(15)));
    let first = orders.iter().find(|order| order.name == name(28)).unwrap();
    assert!(
        first.evidence.contains("from 7 windows") && first.test.contains("turn the OP"),
        "{first:?}"
    );

    let html = page(&ranking, &orders, &groups, &[]);
    assert!(html.len() < 1_500_000, "{} bytes", html.len());
    assert_eq!(html.matches("<tr id=").count(), 1000);
    for said in [
        "these loops swing together",
        "The source is not among the recorded loops.",
        "override: does not stick",
    ] {
        assert!(html.contains(said), "{said}");
    }
    assert!(!html.contains("root cause"));
    assert_eq!(html, page(&rank(&plant, &log, &rows, &groups, week), &orders, &groups, &[]));
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("plant-of-1000.html");
    std::fs::write(path, html).unwrap();
}

#[test]
fn a_repair_that_did_not_help_is_a_change_once() {
    let (plant, rows) = (plant(30), made_up(30).rows());
    let of_week = |day: &str, week: &str| {
        let text = format!(
            "[[entry]]\nkind = \"repair\"\nloop = \"{}\"\nday = {day}\ntext = \"new packing\"\n",
            name(28)
        );
        let log = Log::parse(&text, "log.toml").unwrap();
        let ranking = rank(&plant, &log, &rows, &[], week.parse().unwrap());
        let orders = orders(&ranking);
        let html = page(&ranking, &orders, &[], &[]);
        let finding = orders.iter().find(|order| order.name == name(28)).unwrap().finding.clone();
        (of(&ranking, 28).clone(), finding, html)
    };
    let (row, finding, html) = of_week("2026-03-25", "2026-W13");
    assert_eq!((row.change, row.change_day.as_deref()), (Change::StillSticks, Some("2026-03-25")));
    assert_eq!(finding, "the valve probably sticks, still after the repair of 2026-03-25");
    assert!(html.contains("<b class=\"change still sticks\">still sticks</b>"), "{html}");
    assert!(html.contains("after the repair of 2026-03-25, sticks before, probably sticks now"));
    assert!(!row.is_new_sticking());
    // Two days are needed, as for any change. Then it is told once.
    assert_eq!(of_week("2026-03-29", "2026-W13").0.change, Change::None);
    assert_eq!(of_week("2026-03-19", "2026-W12").0.change, Change::StillSticks);
    assert_eq!(of_week("2026-03-19", "2026-W13").0.change, Change::None);
}

#[test]
fn windows_of_a_week_are_combined_as_a_history_does() {
    let (plant, rows) = (plant(30), made_up(30).rows());
    let week: Week = "2026-W13".parse().unwrap();
    let ranking = rank(&plant, &Log::default(), &rows, &[], week);
    let row = of(&ranking, 17);
    let own = rows.iter().filter(|r| r.name == row.name).rev().take(7);
    let seen: Vec<_> = own.filter_map(|row| row.observation()).collect();
    let history = stiction_diagnose::diagnose::together(&seen).unwrap();
    assert_eq!((row.probability, row.grade), (history.probability, Some(history.grade)));
    // An earlier week does not know what came after it.
    let early = rank(&plant, &Log::default(), &rows, &[], "2026-W11".parse().unwrap());
    assert!(early.loops.iter().all(|ranked| ranked.row.change == Change::None));
    let loops: Vec<LoopRow> = ranking.loops.iter().map(|r| r.row.clone()).collect();
    let back = LoopRow::rows(&LoopRow::table(&loops)).unwrap();
    assert!(back.iter().eq(ranking.loops.iter().map(|ranked| &ranked.row)));
}
