//! The sheet of a valve test: one page to print and to fill in, and the same as a table.

use crate::sheet::Sheet;
use stiction_diagnose::spoken::{rough, time};
use stiction_diagnose::valve_test::TestPlan;

/// Lines of the second part that are printed: sizes are written in as they come.
const LINES_OF_PART_2: usize = 24;

/// The plan as a table with a row a turn of the first part: how far the OP goes from u0, how long it is held at most, and
/// two empty columns for what was done, which [`stiction_diagnose::valve_test::read`] is given.
///
/// # Errors
/// None is known: it is written to memory.
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
    let unit =
        plan.pv_unit.as_deref().map_or(String::new(), |unit| format!(" ({})", escaped(unit)));
    let list: String =
        plan.instructions.iter().map(|text| format!("<li>{}</li>\n", escaped(text))).collect();
    let half = plan.grow.len().div_ceil(2);
    let cell = |k: usize| match plan.grow.get(k) {
        Some(turn) => format!(
            "<td>{}</td><td>u0 {} {}</td><td>{}</td><td></td><td></td><td></td>",
            k + 1,
            if turn.op < 0.0 { "−" } else { "+" },
            rough(turn.op.abs()),
            time(turn.hold_s)
        ),
        None => "<td></td>".repeat(6),
    };
    let rows: String = (0..half)
        .map(|k| format!("<tr>{}<td class=gap></td>{}</tr>\n", cell(k), cell(half + k)))
        .collect();
    let head = format!(
        "<th>Turn</th><th>OP (%)</th><th>Hold at most</th><th>Time</th><th>OP set</th><th>PV at end{unit}</th>"
    );
    let open = "<td></td>".repeat(6);
    let part_2 = format!("<tr>{open}<td class=gap></td>{open}</tr>\n").repeat(LINES_OF_PART_2 / 2);
    let name = escaped(&plan.name);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>Valve test of {name}</title>\n<style>{CSS}</style></head>\n<body><main>\n\
         <h1>Valve test of {name}</h1>\n\
         <p class=blanks>Date ________________ Operator ________________ Agreed with ________________ \
         u0 (OP in manual) ________ % PV at start ________{unit}</p>\n<ol>\n{list}</ol>\n\
         <h2>Part 1: growing turns</h2>\n<div class=wide tabindex=0 role=region aria-label=\"Turns of part 1\">\
         <table><thead><tr>{head}<td class=gap></td>{head}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n\
         <h2>Part 2: shrinking turns, each size {:.0} % smaller</h2>\n\
         <div class=wide tabindex=0 role=region aria-label=\"Turns of part 2\">\
         <table><thead><tr>{head}<td class=gap></td>{head}</tr></thead>\n<tbody>\n{part_2}</tbody></table></div>\n\
         <p class=foot>Limits: PV {} to {}{unit}, OP {} to {} %. Part 1 takes at most {}. An answer is a move of the PV by \
         {}{unit}. {}</p>\n</main></body></html>\n",
        100.0 * (1.0 - plan.shrink_by),
        rough(plan.pv_low),
        rough(plan.pv_high),
        rough(plan.op_low),
        rough(plan.op_high),
        time(plan.total_s),
        rough(plan.answer),
        escaped(tool),
    )
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
th { font-weight: 600; } .gap { border: 0; padding: 0; width: .6rem; }
.blanks { line-height: 2; } .foot { margin-top: .5rem; }
@page { size: A4 portrait; margin: 9mm 10mm; }
@media print { body { font-size: 8.2pt; } main { padding: 0; max-width: none; } .wide { overflow: visible; }
  th, td { height: 4.9mm; padding: 0 1mm; } }
";

fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
