//! The page of the columns of tables, each with what stands in it for a loop of the gallery.

use super::gallery::Shown;
use anyhow::{Context, Result};
use std::fmt::Write as _;
use stiction::population::LoopKind;
use stiction_docs::markdown::literal;
use stiction_docs::{Page, contents};
use stiction_report::table::{COLUMNS, Cells};

/// The page; its first example is the first case of the gallery.
pub fn page(shown: &[Shown]) -> Result<Page> {
    let first = shown.first().context("no case")?;
    let mut text = format!(
        "# Columns of tables\n\n\
        ## One row a loop\n\n\
        What `stiction diagnose --csv` writes, and `stiction.summary_table` gives as a table; here for {} of the \
        [gallery]({}). Percentages are of span, times in s; the amplitude is in the units of the PV. Fields of the same \
        name in the [document](schemas/diagnosis.html) say more.\n\n\
        | column | holds | for {} |\n|---|---|---|\n",
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
    text += "\n## One row a simulated loop\n\n\
        What was drawn of each loop, in `truth.csv` of `stiction population`, after its file, kind, S and J; here for \
        the sticky valve of seed 1. [Simulated loops](population.html) tells what it means.\n\n\
        | column | for that loop |\n|---|---|\n";
    for (name, value) in member.truth.facts.entries() {
        let _ = writeln!(text, "| `{name}` | {} |", literal(&value));
    }
    text += "\n## One row a sample\n\n\
        What `stiction simulate -o` and `stiction population` write, and `stiction diagnose` reads.\n\n\
        | column | unit | what it is |\n|---|---|---|\n\
        | `t` | s | time |\n\
        | `sp` | units of the PV | set point |\n\
        | `pv` | its own | process value, as measured |\n\
        | `op` | % of span | controller output |\n\
        | `vp` | % of span | valve position |\n";
    Ok(Page::new(contents::COLUMNS, "Columns of tables", text))
}
