//! `docs/plant.md` tells the columns as they are declared.

use stiction_plant::WindowRow;
use stiction_plant::ranking::LoopRow;
use stiction_plant::table::{Column, Row};

#[test]
fn the_tables_of_columns_are_those_of_the_declarations() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/plant.md");
    let text = std::fs::read_to_string(path).unwrap();
    let table = |head: &str, columns: Vec<Column>| {
        let mut table = format!("| {head} | unit | type | meaning |\n|---|---|---|---|\n");
        for column in columns {
            let empty = if column.optional { ", may be empty" } else { "" };
            table += &format!(
                "| `{}` | {} | {}{empty} | {} |\n",
                column.name,
                column.unit,
                column.kind.name(),
                column.meaning
            );
        }
        assert!(text.contains(&table), "docs/plant.md should hold\n{table}");
    };
    table("column", WindowRow::columns());
    table("column of `ranking`", LoopRow::columns());
}
