//! The page of the scoreboard.

use crate::html;

use stiction_diagnose::diagnose::{Estimate, Ruling, VerdictClass};
use stiction_diagnose::{finding, methods};
use stiction_population::LoopKind;
use stiction_score::page::{self, Scoreboard};
use stiction_score::scoreboard::{Board, Member, MethodResult, MethodRow, Scored, Truth};

/// Loops whose probabilities and statistics rank most of them as they are.
fn loops() -> Vec<Scored> {
    let detectors = methods::all();
    (0..60u8)
        .map(|k| {
            let sticks = k % 3 == 0;
            let p = 0.1 + 0.013 * f64::from(k) + if sticks { 0.1 } else { 0.0 };
            let kind =
                if sticks { LoopKind::Sticky } else { LoopKind::ALL[3 + usize::from(k) % 10] };
            let class = match p {
                p if p > 0.7 => VerdictClass::Sticks,
                p if p < 0.4 => VerdictClass::DoesNotStick,
                _ => VerdictClass::CannotTell,
            };
            let said = |index: usize, statistic: Option<f64>| MethodResult {
                method: detectors[index].method(),
                statistic,
                threshold: Some(0.5),
                decision: match statistic {
                    Some(s) if s > 0.5 => finding::Decision::Sticks,
                    Some(_) => finding::Decision::DoesNotStick,
                    None => finding::Decision::Abstains,
                },
            };
            Scored {
                name: format!("loop <{k}>"),
                truth: Truth {
                    valve: format!("valve & {}", k / 2),
                    kind: kind.name().to_owned(),
                    sticks,
                    visible: k != 0,
                    s: sticks.then_some(3.0),
                    j: sticks.then_some(1.0),
                    member: (k < 50).then_some(Member { gain: 30.0, slips: 4 }),
                },
                methods: vec![said(2, Some(p)), said(25, (k % 2 == 0).then_some(1.0 - p))],
                verdict: class,
                undecided_by: (class == VerdictClass::CannotTell && k > 25).then_some(Ruling::Open),
                probability: Some(p),
                s: sticks.then_some(Estimate { value: 2.0 + p, low: 2.0, high: 4.0 }),
                j: None,
                s_below: (!sticks).then_some(1.0),
            }
        })
        .collect()
}

fn page(loops: &[Scored], reports: &[String], times: &[(String, f64)]) -> String {
    let board = Board::of(loops);
    let page = Scoreboard {
        title: "60 <loops>",
        introduction: "Made & counted.",
        board: &board,
        loops,
        reports,
        times,
        tool: "a tool",
    };
    page::html(&page).unwrap()
}

#[test]
fn the_page_is_sound_and_shows_every_part() {
    let loops = loops();
    let reports: Vec<String> = (0..loops.len()).map(|k| format!("r/{k}\".html")).collect();
    let text = page(&loops, &reports, &[("whole diagnosis".to_owned(), 1234.5)]);
    html::well_formed(&text);
    let tags = html::tags(&text);
    let count = |start: &str| tags.iter().filter(|tag| tag.starts_with(start)).count();
    assert_eq!(count("figure "), 3, "characteristic, kinds, reliability");
    assert_eq!(count("table data-sortable"), 1);
    assert_eq!(count("a href=\"./r/"), 60);
    assert!(text.contains("href=\"./r/7%22.html\""), "links cannot break out of their attribute");
    for part in [
        "Sticking valves found",
        "Undecided loops",
        "60 &lt;loops&gt;",
        "Made &amp; counted.",
        "loop &lt;7&gt;",
        "valve &amp; 3",
        "sticks, masked",
        "Thornhill's surrogate data *",
        "AUC of valves",
        "expected calibration error",
        "whole diagnosis",
        "external wave",
    ] {
        assert!(text.contains(part), "{part}");
    }
    let elsewhere = |tag: &&&str| tag.contains("src=") || tag.contains("=\"http");
    let named = |tag: &&&str| !tag.contains("xmlns");
    assert_eq!(tags.iter().filter(elsewhere).find(named), None, "nothing from elsewhere");
    assert_eq!(text, page(&loops, &reports, &[("whole diagnosis".to_owned(), 1234.5)]));
}

#[test]
fn what_is_not_known_is_not_shown() {
    let mut loops = loops();
    for each in &mut loops {
        (each.probability, each.s, each.truth.s, each.truth.j) = (None, None, None, None);
        each.truth.kind.clear();
        each.truth.member = None;
        each.methods.clear();
    }
    let text = page(&loops, &[], &[]);
    html::well_formed(&text);
    assert!(text.contains("No loop has a probability"));
    let tags = html::tags(&text);
    assert!(!tags.iter().any(|tag| tag.starts_with("a href") || tag.starts_with("figure ")));
    for part in [
        "By kind of loop",
        "Size of stiction",
        "Sticking valves found",
        "Undecided loops",
        "<h3>Time",
    ] {
        assert!(!text.contains(part), "{part}");
    }
    // Nothing at all is a page, too.
    html::well_formed(&page(&[], &[], &[]));
}

#[test]
fn tables_have_a_cell_for_every_column() {
    let board = Board::of(&loops());
    let name: page::Names = MethodRow::name;
    let mut tables = vec![
        page::decisions(&board, name),
        page::decisions_on_valves(&board, name),
        page::ranking(&board, name),
        page::times(&[("all".to_owned(), 1.0)]),
    ];
    tables.extend(page::by_kind(&board));
    tables.extend(page::methods_by_kind(&board, name));
    tables.extend(page::calibration(&board));
    tables.extend(page::quantification(&board));
    tables.extend(page::sureness(&board));
    tables.extend(page::found(&board));
    tables.extend(page::undecided(&board));
    assert_eq!(tables.len(), 10);
    for table in &tables {
        assert!(table.rows.iter().all(|row| row.len() == table.columns.len()), "{table:?}");
    }
    // The share of the visible sticking loops that are quantified, and the coverage of what was said.
    let row = &tables[7].rows[0];
    assert!(row[1].starts_with("100 %") && row[6].starts_with("100 %"), "{row:?}");
    // Every loop is in one band of either row of bands, and every undecided one in one row.
    let loops: Vec<(&str, usize)> =
        tables[8].rows.iter().map(|row| (&row[0][..], row[3].parse().unwrap())).collect();
    for by in ["nats", "slips"] {
        let of: Vec<usize> = loops.iter().filter(|row| row.0 == by).map(|row| row.1).collect();
        assert_eq!((of.len(), of.iter().sum::<usize>()), (6, 16), "{by}");
    }
    let held: Vec<_> = tables[9].rows.iter().map(|row| (&row[0][..], &row[1][..])).collect();
    assert!(held.contains(&("probability between", "50 %")), "{held:?}");
    assert!(held.last().is_some_and(|(by, _)| *by == "no evidence"), "{held:?}");
    assert!(page::has_valves(&board));
}
