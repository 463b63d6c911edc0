//! `docs/scenarios.md` says what the reader does.

use std::collections::BTreeSet;
use stiction_io::Scenario;

const PAGE: &str = include_str!("../../../docs/scenarios.md");

/// A row of one of the page's tables.
struct Row<'a> {
    key: &'a str,
    /// The value in TOML, if the default is one.
    default: Option<&'a str>,
    /// The kinds it belongs to, where there is such a column.
    kinds: Option<Vec<&'a str>>,
}

/// The rows below the heading `## title`.
fn documented(title: &str) -> Vec<Row<'static>> {
    let heading = format!("\n## {title}\n");
    let (_, part) = PAGE.split_once(&heading).unwrap_or_else(|| panic!("no heading {title}"));
    let part = part.split("\n## ").next().unwrap_or(part);
    let mut lines = part.lines().filter(|line| line.starts_with('|'));
    let has_kinds = lines.next().is_some_and(|header| header.contains("| of "));
    let row = |line: &'static str| {
        let cells: Vec<_> = line.split('|').map(str::trim).collect();
        let code = |cell: &'static str| cell.strip_prefix('`').and_then(|c| c.strip_suffix('`'));
        Row {
            key: code(cells[1]).unwrap_or_else(|| panic!("no key in {line}")),
            default: code(cells[3]),
            kinds: has_kinds.then(|| cells[4].split(", ").collect()),
        }
    };
    lines.skip(1).map(row).collect()
}

fn keys<'a>(rows: impl IntoIterator<Item = &'a Row<'a>>) -> BTreeSet<String> {
    rows.into_iter().map(|row| row.key.to_owned()).collect()
}

/// The keys that the reader says it knows when it meets one that it does not.
fn known(text: &str) -> BTreeSet<String> {
    let error = Scenario::parse(text, "test", None).expect_err("an unknown key").to_string();
    let (_, list) =
        error.split_once("known here are ").unwrap_or_else(|| panic!("{error}\n{text}"));
    list.split(", ").map(str::to_owned).collect()
}

/// `text` with `line` first in `table`; the table is added if need be.
fn with(text: &str, table: &str, line: &str) -> String {
    if table.is_empty() {
        return format!("{line}\n{text}");
    }
    if !text.contains(&format!("{table}\n")) {
        return format!("{text}\n{table}\n{line}\n");
    }
    text.replacen(&format!("{table}\n"), &format!("{table}\n{line}\n"), 1)
}

const CLOCK: &str = "sample_time = 0.1\nduration = 10\n";
const VALVE: &str = "[valve]\nS = 5\nJ = 2\n";
const PROCESS: &str = "[process]\ngain = 1\ntau = 2\n";
const MASTER: &str = "[master]\n[master.controller]\nkc = 1\n[master.process]\ngain = 1\ntau = 9\n";

fn control_loop(controller: &str, process: &str) -> String {
    format!("{CLOCK}{controller}{VALVE}{process}{MASTER}")
}

fn open_loop(valve: &str, signal: &str) -> String {
    format!("{CLOCK}[input]\n{signal}{valve}")
}

const ISA: &str = "[controller]\nkc = 1\nti = 2\nlimits = [-50, 50]\n";
const PARALLEL: &str = "[controller]\nkp = 1\n";
const INTEGRAL: &str = "[controller]\nki = 1\n";

/// A process of every type, with a key that has no place in it.
const PROCESSES: [(&str, &str, &str); 4] = [
    ("first-order", PROCESS, "tau2 = 1"),
    (
        "second-order",
        "[process]\ntype = \"second-order\"\ngain = 1\ntau = 2\ntau2 = 3\n",
        "num = [1]",
    ),
    ("integrator", "[process]\ntype = \"integrator\"\ngain = 1\n", "tau = 1"),
    (
        "transfer-function",
        "[process]\ntype = \"transfer-function\"\nnum = [1]\nden = [1, 2]\n",
        "gain = 1",
    ),
];

/// A signal of every kind that needs no file, with a key that has no place in it.
const SIGNALS: [(&str, &str, &str); 9] = [
    ("constant", "value = 1\n", "period = 1"),
    ("sine", "signal = \"sine\"\namplitude = 1\nperiod = 3\n", "value = 1"),
    ("ramp", "signal = \"ramp\"\namplitude = 1\nperiod = 3\n", "value = 1"),
    ("square", "signal = \"square\"\namplitude = 1\nperiod = 3\n", "value = 1"),
    ("steps", "signal = \"steps\"\nsteps = [[0, 1], [2, 3]]\n", "value = 1"),
    ("line", "signal = \"line\"\nslope = 1\n", "value = 1"),
    ("staircase", "signal = \"staircase\"\nstep = 1\ndwell = 2\n", "value = 1"),
    ("noise", "signal = \"noise\"\nsd = 1\n", "value = 1"),
    ("random-walk", "signal = \"random-walk\"\nsd = 1\n", "value = 1"),
];

/// Title of a table on the page, its header in TOML, and scenarios that have it.
fn tables() -> Vec<(&'static str, &'static str, Vec<String>)> {
    let isa = control_loop(ISA, PROCESS);
    let he_wang = VALVE.replace("[valve]\n", "[valve]\nmodel = \"he-wang\"\n");
    let processes = PROCESSES.map(|(_, text, _)| control_loop(ISA, text)).to_vec();
    let signals = SIGNALS.map(|(_, text, _)| open_loop(VALVE, text)).to_vec();
    vec![
        ("The scenario itself", "", vec![isa.clone()]),
        (
            "`[valve]`",
            "[valve]",
            vec![isa.clone(), control_loop(ISA, PROCESS).replace(VALVE, &he_wang)],
        ),
        (
            "`[controller]`, `[master.controller]`",
            "[controller]",
            vec![isa.clone(), control_loop(PARALLEL, PROCESS), control_loop(INTEGRAL, PROCESS)],
        ),
        ("`[process]`, `[master.process]`", "[process]", processes),
        ("`[operating_point]`", "[operating_point]", vec![isa.clone()]),
        ("`[resolution]`", "[resolution]", vec![isa.clone()]),
        ("`[noise]`, `[master.noise]`", "[noise]", vec![isa.clone() + "[noise]\nsd = 1\n"]),
        ("`[master]`", "[master]", vec![isa]),
        ("Signals", "[input]", signals),
    ]
}

#[test]
fn every_key_is_documented_and_no_other() {
    let mut documented_keys = 0;
    for (title, table, scenarios) in tables() {
        let rows = documented(title);
        documented_keys += rows.len();
        for text in &scenarios {
            assert_eq!(keys(&rows), known(&with(text, table, "no_such_key = 1")), "{title}");
        }
    }
    assert!(documented_keys > 70, "{documented_keys}");
    // The master's tables are those of the slave, and every signal is one.
    let isa = control_loop(ISA, PROCESS);
    for (title, table) in [
        ("`[controller]`, `[master.controller]`", "[master.controller]"),
        ("`[process]`, `[master.process]`", "[master.process]"),
        ("`[noise]`, `[master.noise]`", "[master.noise]"),
        ("Signals", "[set_point]"),
        ("Signals", "[[load]]"),
        ("Signals", "[[measurement]]"),
        ("Signals", "[master.set_point]"),
        ("Signals", "[[master.measurement]]"),
    ] {
        assert_eq!(
            keys(&documented(title)),
            known(&with(&isa, table, "no_such_key = 1")),
            "{table}"
        );
    }
}

#[test]
fn every_key_is_documented_for_the_kinds_that_have_it() {
    let of_kind = |rows: &[Row<'_>], kind: &str| {
        let belongs = |row: &&Row<'_>| {
            row.kinds.as_ref().is_some_and(|kinds| kinds.contains(&kind) || kinds == &["all"])
        };
        rows.iter().filter(belongs).map(|row| row.key.to_owned()).collect::<BTreeSet<_>>()
    };
    let rows = documented("`[process]`, `[master.process]`");
    for (kind, text, misplaced) in PROCESSES {
        let text = with(&control_loop(ISA, text), "[process]", misplaced);
        assert_eq!(of_kind(&rows, kind), known(&text), "{kind}");
    }
    let rows = documented("Signals");
    for (kind, text, misplaced) in SIGNALS {
        let text = with(&open_loop(VALVE, text), "[input]", misplaced);
        assert_eq!(of_kind(&rows, kind), known(&text), "{kind}");
    }
    assert_eq!(of_kind(&rows, "file"), ["column", "file", "signal"].map(str::to_owned).into());
}

/// A default that is written out makes no difference.
#[test]
fn defaults_are_as_documented() {
    let mut checked = 0;
    for (title, table, scenarios) in tables() {
        for Row { key, default, .. } in documented(title) {
            let Some(default) = default else { continue };
            let line = format!("{key} = {default}");
            let mut fits = 0;
            for text in &scenarios {
                let plain = Scenario::parse(text, "plain", None).expect("a well-formed scenario");
                // A key that is there already, or has no place in this kind, is refused.
                if let Ok(written) = Scenario::parse(&with(text, table, &line), "test", None) {
                    assert_eq!(
                        (plain.title, plain.system),
                        (written.title, written.system),
                        "{line}"
                    );
                    fits += 1;
                }
            }
            assert!(fits > 0, "{title}: {line} fits nowhere");
            checked += 1;
        }
    }
    assert!(checked > 25, "{checked}");
}

#[test]
fn examples_are_well_formed() {
    let examples: Vec<_> =
        PAGE.split("```toml\n").skip(1).filter_map(|part| part.split("```").next()).collect();
    assert_eq!(examples.len(), 3);
    for text in examples {
        let scenario = Scenario::parse(text, "docs/scenarios.md", None).expect("well formed");
        assert!(scenario.notes.is_empty());
    }
}
