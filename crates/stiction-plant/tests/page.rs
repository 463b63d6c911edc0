//! The ranking and the page of a week, of rows that are made up.

use stiction_plant::action::Action;
use stiction_plant::change::Change;
use stiction_plant::groups::{Group, Member, Source};
use stiction_plant::health::Health;
use stiction_plant::log::Log;
use stiction_plant::orders::orders;
use stiction_plant::page::page;
use stiction_plant::plant_file::Plant;
use stiction_plant::ranking::{LoopRow, Ranking, rank};
use stiction_plant::week::Week;
use stiction_plant::{WindowRow, demo};

const DAYS: i64 = 28;

/// A number from 0 to 1 that looks like chance, the same for the same `k`.
fn chance(k: usize) -> f64 {
    let mixed = (k as u64)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .rotate_left(29)
        .wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed >> 11) as f64 / (1u64 << 53) as f64
}

fn name(k: usize) -> String {
    format!("{}IC{}", ["F", "L", "P", "T"][k % 4], 1001 + k)
}

/// Rows of `loops` loops: a seventh sticks, some of them from the last week on, some no longer.
fn rows(loops: usize) -> Vec<WindowRow> {
    let mut rows = vec![];
    for k in (0..loops).filter(|k| k % 97 != 5) {
        for day in 0..DAYS {
            let late = day >= DAYS - 4;
            let sticks = match k % 14 {
                0 | 1 => true,
                2 if k % 5 == 0 => late,
                3 if k % 5 == 0 => !late,
                _ => false,
            };
            let chance = |n: usize| chance(1000 * k + 10 * day as usize + n);
            let p = if sticks { 0.9 + 0.09 * chance(0) } else { 0.05 + 0.2 * chance(0) };
            let class = match p {
                p if p > 0.9 => "sticks",
                p if p < 0.1 => "does not stick",
                _ => "cannot tell",
            };
            let s = sticks.then(|| {
                (1.0 + (k % 9) as f64) * (1.0 + 0.008 * day as f64) * (1.0 + 0.05 * chance(1))
            });
            let refused = k % 97 == 11;
            let start = (demo::FIRST_DAY + day) * 86_400;
            let identity = WindowRow {
                name: name(k),
                loop_type: ["flow", "level", "pressure", "temperature"][k % 4].to_owned(),
                window_start: start,
                window_s: 86_400,
                error: refused.then(|| "its PV has no sample that can be used".to_owned()),
                ..WindowRow::default()
            };
            if refused {
                rows.push(identity);
                continue;
            }
            rows.push(WindowRow {
                samples: Some(8640),
                good_share: Some(100.0),
                auto_share: Some(if k % 89 == 7 { 0.0 } else { 100.0 - 9.0 * chance(2) }),
                stretch_start_s: Some(0.0),
                stretch_s: Some(86_400.0),
                fitness: Some("fit".to_owned()),
                oscillates: Some(k % 3 != 0 || sticks),
                period_s: Some(60.0 + (k % 50) as f64 * 17.0),
                amplitude: Some(1.0 + chance(3)),
                travel_per_hour: Some(30.0 + 300.0 * chance(4)),
                reversals_per_hour: Some(20.0 + 80.0 * chance(5)),
                at_limit_share: Some(3.0 * chance(6)),
                verdict: Some(class.to_owned()),
                probability: Some(p),
                evidence_windows: Some(4.0),
                s,
                s_low: s.map(|s| 0.9 * s),
                s_high: s.map(|s| 1.1 * s),
                j: s.map(|s| 0.4 * s),
                j_low: s.map(|s| 0.2 * s),
                j_high: s.map(|s| 0.6 * s),
                s_below: (!sticks).then_some(1.2),
                alternative: Some(
                    ["aggressive tuning", "external oscillation", "normal operation"][k % 3]
                        .to_owned(),
                ),
                alternative_likelihood: Some(0.4 + 0.3 * chance(7)),
                no_response: (k % 83 == 9).then(|| "PV frozen".to_owned()),
                ..identity
            });
        }
    }
    rows.sort_by(|a, b| (&a.name, a.window_start).cmp(&(&b.name, b.window_start)));
    rows
}

fn plant(loops: usize) -> Plant {
    let mut text = "name = \"North refinery\"\nzone = \"UTC\"\ndata = [\"*.csv\"]\n".to_owned();
    for (k, area) in ["Crude", "Vacuum", "Reformer", "Utilities", "Tank farm"].iter().enumerate() {
        text += &format!("[area.\"{area}\"]\nweight = {}\n", 1 + k % 3);
    }
    for k in 0..loops {
        let area = ["Crude", "Vacuum", "Reformer", "Utilities", "Tank farm"][k * 7 % 31 % 5];
        text += &format!(
            "[loop.{}]\narea = \"{area}\"\nunit = \"C-{}\"\nweight = {}\nwatch = {}\n",
            name(k),
            100 + k % 6,
            1 + k % 5,
            k % 50 == 3
        );
    }
    Plant::parse(&text, "plant.toml").unwrap()
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
    let (plant, rows, log, groups) = (plant(1000), rows(1000), log(), groups());
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
    assert_eq!(of(&ranking, 17).action, Action::LookUpstream);

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
            .count()
    );

    let orders = orders(&ranking);
    assert!(orders.iter().all(|order| order.name != name(14) && order.name != name(15)));
    let first = orders.iter().find(|order| order.name == name(28)).unwrap();
    assert!(
        first.evidence.contains("by 7 windows") && first.test.contains("steps of the output"),
        "{first:?}"
    );

    let html = page(&ranking, &orders, &groups);
    assert!(html.len() < 1_500_000, "{} bytes", html.len());
    assert_eq!(html.matches("<tr id=").count(), 1000);
    for said in [
        "these loops swing together",
        "The source is not among the recorded loops.",
        "a person: does not stick",
    ] {
        assert!(html.contains(said), "{said}");
    }
    assert!(!html.contains("root cause"));
    assert_eq!(html, page(&rank(&plant, &log, &rows, &groups, week), &orders, &groups));
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("plant-of-1000.html");
    std::fs::write(path, html).unwrap();
}

#[test]
fn windows_of_a_week_are_combined_as_a_history_does() {
    let (plant, rows) = (plant(30), rows(30));
    let week: Week = "2026-W13".parse().unwrap();
    let ranking = rank(&plant, &Log::default(), &rows, &[], week);
    let row = of(&ranking, 17);
    let own = rows.iter().filter(|r| r.name == row.name).rev().take(7);
    let seen: Vec<_> = own.filter_map(|row| row.observation()).collect();
    let history = stiction_diagnose::diagnose::combine(&seen).unwrap();
    assert_eq!((row.probability, row.grade), (history.probability, Some(history.grade)));
    // An earlier week does not know what came after it.
    let early = rank(&plant, &Log::default(), &rows, &[], "2026-W11".parse().unwrap());
    assert!(early.loops.iter().all(|ranked| ranked.row.change == Change::None));
    let batch =
        LoopRow::batch(&ranking.loops.iter().map(|r| r.row.clone()).collect::<Vec<_>>()).unwrap();
    let back = LoopRow::rows(&batch).unwrap();
    assert!(back.iter().eq(ranking.loops.iter().map(|ranked| &ranked.row)));
}
