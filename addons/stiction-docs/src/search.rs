//! The index of the search. It has one row per part of a page, and is a script because a page on the disk may not load
//! data.

use crate::markdown::Rendered;

/// The file of the index.
pub(crate) const PATH: &str = "assets/search.js";

/// Page, heading, address and text of all parts.
pub(crate) fn index(pages: &[Rendered]) -> String {
    let rows: Vec<_> = pages
        .iter()
        .flat_map(|page| {
            page.parts.iter().map(move |part| {
                let address = match part.level {
                    1 => page.path.clone(),
                    _ => format!("{}#{}", page.path, part.anchor),
                };
                let text: Vec<&str> = part.text.split_whitespace().collect();
                serde_json::json!([page.title, part.heading, address, text.join(" ")])
            })
        })
        .collect();
    let rows: Vec<String> = rows.iter().map(ToString::to_string).collect();
    format!("window.searchIndex = [\n{}\n];\n", rows.join(",\n"))
}
