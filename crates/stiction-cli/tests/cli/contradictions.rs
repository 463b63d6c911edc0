//! No word of one command against that of another on the same recording; the shared rules are those of the pages.

use crate::diagnose::{samples, with_samples};
use crate::run;
use serde_json::Value;

const SAMPLES: [&str; 5] = [
    "FIC101-sticky",
    "FIC102-disturbed",
    "FIC103-aggressive",
    "FIC105-cascade",
    "LIC104-quantised",
];

fn rules() -> Value {
    let text = include_str!("../../../stiction-report/tests/contradictions.json");
    serde_json::from_str(text).expect("JSON")
}

/// The numbers of a text.
fn numbers(text: &str) -> Vec<f64> {
    text.split([' ', '(', ')']).filter_map(|word| word.parse().ok()).collect()
}

/// Slips of the pen, and numbers with more digits than an interval supports.
fn check_words(command: &str, said: &str, rules: &Value) {
    let sentence = said.split_whitespace().collect::<Vec<_>>().join(" ");
    for never in rules["never"].as_array().expect("a list") {
        let never = never.as_str().expect("a text");
        assert!(!sentence.contains(never), "{command}: {never:?} in {said}");
    }
    for plural in rules["plural"].as_array().expect("a list") {
        let one = format!(" 1 {}", plural.as_str().expect("a text"));
        assert!(!sentence.contains(&one), "{command}: {one} in {said}");
    }
    let long = |word: &&str| {
        let after = word.trim_end_matches(['.', ',', ';', ')']).split_once('.');
        after.is_some_and(|(_, digits)| {
            digits.trim_start_matches('0').len() > 5 && digits.bytes().all(|b| b.is_ascii_digit())
        })
    };
    assert_eq!(sentence.split(' ').find(long), None, "{command}: {said}");
}

#[test]
fn fit_what_if_and_history_agree_with_the_diagnosis() {
    let folder = with_samples("contradictions");
    let rules = rules();
    let largest = rules["largest_factor"].as_f64().expect("a number");
    let mut predicted = 0;
    for name in SAMPLES {
        let file = format!("{name}.csv");
        let verdict =
            run(&folder, &["diagnose", &file, "--json"]).json()["loops"][0]["verdict"].clone();
        let (grade, shown) = (verdict["grade"].as_str().expect("a grade"), &verdict["probability"]);

        // One window is the whole recording.
        let history = run(&folder, &["history", &file, "--json"]).json();
        let windows = history["valves"][0]["windows"].as_array().expect("windows").clone();
        if windows.len() == 1 {
            assert_eq!(windows[0]["grade"], grade, "{name}");
            let cannot = grade == "data cannot answer";
            assert_eq!(
                windows[0]["probability"] == Value::Null,
                cannot || shown.is_null(),
                "{name}"
            );
        }
        check_words("history", &run(&folder, &["history", &file]).quiet_success(), &rules);

        let fit = run(&folder, &["fit", &file]).quiet_success();
        check_words("fit", &fit, &rules);
        let flat = fit.split_whitespace().collect::<Vec<_>>().join(" ");
        let explains = flat.contains("The valve explains the swing");
        assert!(!(explains && flat.contains("probably follows its OP")), "{fit}");
        assert!(
            !(explains
                && ["fine", "no stiction visible", "too little to matter", "probably fine"]
                    .contains(&grade)),
            "{grade}: {fit}"
        );

        let what_if = run(&folder, &["what-if", &file]);
        if what_if.code != 0 {
            assert!(what_if.err.contains("no prediction"), "{}", what_if.err);
            continue;
        }
        predicted += 1;
        let said = what_if.quiet_success();
        check_words("what-if", &said, &rules);
        let advice = said.split("\nActions\n").nth(1).unwrap_or_default();
        let flat = advice.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(!(explains && flat.contains("does not explain the swing")), "{fit}\n{said}");
        for fall in flat.split("fall by ").skip(1) {
            let ends = numbers(fall.split('%').next().expect("a text"));
            assert!(ends.len() == 2 && 0.0 <= ends[0] && ends[0] <= ends[1], "{fall}");
        }
        let prospects = run(&folder, &["what-if", &file, "--json"]).json()["prospects"].clone();
        for action in prospects["actions"].as_array().expect("a list") {
            for ratio in ["pv_swing_ratio", "error_ratio"] {
                let of = |end: &str| action[ratio][end].as_f64().expect("a number");
                assert!(of("low") <= of("high") && of("high") <= largest, "{name}: {action}");
            }
        }
    }
    assert!(predicted > 0 && samples().is_dir());
}

/// Rounding is for people: a table has three digits, and no digit of a whole number is lost.
#[test]
fn cells_of_tables_have_three_digits() {
    let folder = with_samples("three-digits");
    run(&folder, &["plant", "demo", "--loops", "4", "--days", "2", "-o", "p"]).quiet_success();
    run(&folder, &["plant", "-C", "p", "scan"]).quiet_success();
    run(&folder, &["plant", "-C", "p", "report"]).quiet_success();
    let reports = folder.join("p/reports");
    let week =
        std::fs::read_dir(reports).expect("weeks").next().expect("a week").expect("it").path();
    let mut tables = vec![
        run(&folder, &["diagnose", "FIC101-sticky.csv", "--csv", "-"]).quiet_success(),
        run(&folder, &["history", "FIC101-sticky.csv", "--csv", "-"]).quiet_success(),
    ];
    for name in ["ranking.csv", "orders.csv", "work-orders.csv"] {
        tables.push(std::fs::read_to_string(week.join(name)).expect("a table"));
    }
    for table in tables {
        for cell in table.split([',', '\n']).filter(|cell| cell.parse::<f64>().is_ok()) {
            let (whole, part) = cell.split_once('.').unwrap_or((cell, ""));
            let digits =
                whole.trim_start_matches(['-', '0']).len() + part.trim_start_matches('0').len();
            assert!(part.is_empty() || digits <= 3 || part.contains('e'), "{cell} in {table}");
        }
    }
}
