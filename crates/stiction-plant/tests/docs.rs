//! `docs/plant.md` tells the columns as they are declared.

use stiction_plant::WindowRow;

#[test]
fn the_table_of_columns_is_that_of_the_declaration() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/plant.md");
    let text = std::fs::read_to_string(path).unwrap();
    let mut table = "| column | unit | type | meaning |\n|---|---|---|---|\n".to_owned();
    for column in WindowRow::columns() {
        let empty = if column.optional { ", may be empty" } else { "" };
        table += &format!(
            "| `{}` | {} | {}{empty} | {} |\n",
            column.name, column.unit, column.kind, column.meaning
        );
    }
    assert!(text.contains(&table), "docs/plant.md should hold\n{table}");
}
