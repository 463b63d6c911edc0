//! The page of the columns of tables, with the values of a gallery loop as examples.

use super::gallery::Shown;
use anyhow::{Context, Result};
use std::fmt::Write as _;
use stiction::population::LoopKind;
use stiction_docs::markdown::literal;
use stiction_docs::{Page, contents};
use stiction_report::table::{COLUMNS, Cells};

/// The page. Its first example is the first case of the gallery.
pub fn page(shown: &[Shown]) -> Result<Page> {
    let first = shown.first().context("no case")?;
    let mut text = format!(
        "# Columns of tables\n\n\
         ## One row per loop\n\n\
         `stiction diagnose --csv` writes these columns, and `stiction.summary_table` returns them as a table. The \
         example is {} of the [gallery]({}). Percentages are of span, times are in s, and the amplitude is in PV \
         units. Fields with the same name in the [document](schemas/diagnosis.html) have more details.\n\n\
         | column | content | {} |\n|---|---|---|\n",
        first.case.tag,
        contents::GALLERY,
        first.case.tag,
    );
    for column in COLUMNS {
        let kind = match column.cells {
            Cells::Texts(_) => "text",
            Cells::Numbers(_) => "number",
            Cells::Counts(_) => "whole number",
            Cells::Flags(_) => "true or false",
        };
        let cell = literal(&column.cells.text(&first.found()));
        let _ = writeln!(text, "| `{}` | {kind} | {cell} |", column.name);
    }
    let member = LoopKind::Sticky.simulate(1)?;
    text += "\n## One row per simulated loop\n\n\
        After the file, kind, S and J of each loop, `truth.csv` of `stiction population` lists the properties drawn for it. \
        The example is the sticky valve of seed 1. [Simulated loops](population.html) explains them.\n\n\
        | column | example |\n|---|---|\n";
    for (name, value) in member.truth.facts.entries() {
        let _ = writeln!(text, "| `{name}` | {} |", literal(&value.to_string()));
    }
    text += "\n## One row per sample\n\n\
        `stiction simulate -o` and `stiction population` write these columns, and `stiction diagnose` reads \
        them.\n\n\
        | column | unit | content |\n|---|---|---|\n\
        | `t` | s | time |\n\
        | `sp` | PV units | set point |\n\
        | `pv` | PV units | process value, as measured |\n\
        | `op` | % of span | controller output |\n\
        | `vp` | % of span | valve position |\n";
    Ok(Page::new(contents::COLUMNS, "Columns of tables", text))
}
