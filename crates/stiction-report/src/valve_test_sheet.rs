//! The sheet of a valve test or a signature: one page to print and complete, also as a table.

use crate::sheet::Sheet;
use maud::{DOCTYPE, Markup, html};
use stiction_diagnose::spoken::{range, rough, time};
use stiction_diagnose::valve_test::{SignaturePlan, TestPlan};
use stiction_figure::page::head;

/// Number of rows for turns on the page, and fewest rows for the second part, whose sizes are written in by hand.
const TURNS: usize = 48;
const OF_PART_2: usize = 8;

/// The plan as a table with a row for each turn of the first part: the OP relative to u0, the longest hold, and two
/// empty columns. The completed columns are an input to [`stiction_diagnose::valve_test::read`].
///
/// # Errors
/// No error is known, because it writes to memory.
pub fn csv(plan: &TestPlan) -> std::io::Result<String> {
    let mut sheet = Sheet::new(["turn", "op_from_u0_percent", "hold_at_most_s", "time", "op"])?;
    for (k, turn) in plan.grow.iter().enumerate() {
        let cells = [format!("{}", k + 1), short(turn.op), format!("{:.0}", turn.hold_s)];
        sheet.row(cells.into_iter().chain([String::new(), String::new()]))?;
    }
    sheet.text()
}

/// The page: self-contained HTML for one sheet of A4.
pub fn html(plan: &TestPlan, tool: &str) -> String {
    let unit = plan.pv_unit.as_deref().map_or(String::new(), |unit| format!(" ({unit})"));
    let title = format!("Valve test of {}", plan.name);
    let half = plan.grow.len().div_ceil(2);
    let turn = |k: usize| (k < plan.grow.len()).then_some(k);
    let of_plan = (0..half).map(|k| [turn(k), turn(half + k)]);
    // Further turns of the size to which the PV responds.
    let further = vec![[None, None]; plan.each.div_ceil(2)];
    let part_1: Vec<[Option<usize>; 2]> = of_plan.chain(further).collect();
    let of_part_2 = TURNS.saturating_sub(plan.grow.len()).max(OF_PART_2);
    let part_2 = vec![[None, None]; of_part_2 / 2];
    let smaller = format!("{:.0}", 100.0 * (1.0 - plan.shrink_by));
    page(
        &title,
        &html! {
            p.blanks {
                (PEOPLE) "u0 (OP in manual) ________ % PV at start ________" (unit)
            }
            ol { @for text in &plan.instructions { li { (text) } } }
            h2 { "Part 1: growing turns" }
            (table("Turns of part 1", &unit, plan, &part_1))
            h2 { "Part 2: shrinking turns, each size " (smaller) " % smaller" }
            (table("Turns of part 2", &unit, plan, &part_2))
            p.foot {
                "Limits: PV " (range(plan.pv_low, plan.pv_high)) (unit)
                ", OP " (range(plan.op_low, plan.op_high))
                " %. The test ends after " (time(plan.total_s))
                " in manual. An answer is a PV change of " (rough(plan.answer)) (unit) ". " (tool)
            }
        },
    )
}

/// The ramps of a signature as a table.
///
/// # Errors
/// As for [`csv()`].
pub fn signature_csv(plan: &SignaturePlan) -> std::io::Result<String> {
    let mut sheet =
        Sheet::new(["ramp", "op_from_percent", "op_to_percent", "duration_s", "hold_s"])?;
    let starts = [plan.from_op].into_iter().chain(plan.ramps.iter().map(|ramp| ramp.to_op));
    for (k, (from, ramp)) in starts.zip(&plan.ramps).enumerate() {
        let numbers = [from, ramp.to_op, ramp.duration_s, ramp.hold_s].map(short);
        sheet.row([format!("{}", k + 1)].into_iter().chain(numbers))?;
    }
    sheet.text()
}

/// The page of a signature: self-contained HTML for one sheet of A4.
pub fn signature_html(plan: &SignaturePlan, tool: &str) -> String {
    let starts = [plan.from_op].into_iter().chain(plan.ramps.iter().map(|ramp| ramp.to_op));
    let heads = [
        "Ramp",
        "OP from (%)",
        "OP to (%)",
        "In",
        "Then hold",
        "Begun at",
        "Ended at",
        "VP at end (%)",
    ];
    page(
        &format!("Valve signature of {}", plan.name),
        &html! {
            p.blanks { (PEOPLE) "VP at start ________ %" }
            ol { @for text in &plan.instructions { li { (text) } } }
            h2 { "Ramps of the OP" }
            div.wide tabindex="0" role="region" aria-label="Ramps of the OP" {
                table {
                    thead { tr { @for head in heads { th { (head) } } } }
                    tbody {
                        @for (k, (from, ramp)) in starts.zip(&plan.ramps).enumerate() {
                            tr {
                                td { (k + 1) }
                                td { (rough(from)) }
                                td { (rough(ramp.to_op)) }
                                td { (time(ramp.duration_s)) }
                                td { (time(ramp.hold_s)) }
                                td {} td {} td {}
                            }
                        }
                    }
                }
            }
            p.foot { "All ramps take " (time(plan.total_s)) ". " (tool) }
        },
    )
}

const PEOPLE: &str =
    "Date ________________ Operator ________________ Agreed with ________________ ";

fn page(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (head(title, &[CSS]))
            body { main { h1 { (title) } (body) } }
        }
    };
    page.into_string()
}

/// Rows with two turns of the plan each, by their numbers; `None` for an empty row.
fn table(label: &str, unit: &str, plan: &TestPlan, rows: &[[Option<usize>; 2]]) -> Markup {
    let pv = format!("PV at end{unit}");
    let heads = ["Turn", "Size (%)", "OP (%)", "Hold at most", "Time", "OP set", &pv];
    let cells = |k: usize| {
        let turn = plan.grow[k];
        let sign = if turn.op < 0.0 { '−' } else { '+' };
        let half = turn.op.abs();
        [
            format!("{}", k + 1),
            rough(2.0 * half),
            format!("u0 {sign} {}", rough(half)),
            time(turn.hold_s),
        ]
    };
    html! {
        div.wide tabindex="0" role="region" aria-label=(label) {
            table {
                thead {
                    tr {
                        @for head in heads { th { (head) } }
                        td.gap {}
                        @for head in heads { th { (head) } }
                    }
                }
                tbody {
                    @for row in rows {
                        tr {
                            @for (side, turn) in row.iter().enumerate() {
                                @if side > 0 { td.gap {} }
                                @let filled = turn.map(cells).unwrap_or_default();
                                @for cell in &filled { td { (cell) } }
                                @for _ in filled.len()..heads.len() { td {} }
                            }
                        }
                    }
                }
            }
        }
    }
}

const CSS: &str = "
:root { color-scheme: light dark; --ink: #1c1c1e; --paper: #fff; --line: #767b84; }
@media screen and (prefers-color-scheme: dark) { :root { --ink: #e8e8ea; --paper: #17181b; --line: #8a9099; } }
* { box-sizing: border-box; }
body { margin: 0; color: var(--ink); background: var(--paper); font: 0.85rem/1.35 system-ui, 'Segoe UI', Arial, sans-serif; }
main { max-width: 60rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.3rem; margin: 0 0 .4rem; } h2 { font-size: 1rem; margin: .7rem 0 .2rem; }
ol { margin: .4rem 0; padding-left: 1.4rem; } li { margin: .15rem 0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; }
th, td { border: 1px solid var(--line); padding: .12rem .3rem; text-align: left; height: 1.35rem; white-space: nowrap; }
th { font-weight: 600; white-space: normal; } .gap { border: 0; padding: 0; width: .6rem; min-width: .6rem; }
tr:has(.gap) :nth-child(8n + 5) { width: 8.5%; } tr:has(.gap) :is(:nth-child(8n + 6), :nth-child(8n + 7)) { width: 6.5%; }
.blanks { line-height: 2; } .foot { margin-top: .5rem; }
@page { size: A4 portrait; margin: 9mm 10mm; }
@media print { body { font-size: 8.2pt; } main { padding: 0; max-width: none; } .wide { overflow: visible; }
  th, td { height: 4.9mm; padding: 0 1mm; } }
";

fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
