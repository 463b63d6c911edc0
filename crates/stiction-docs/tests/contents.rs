//! The contents hold every document of the repository, and the list of crates every crate.

use std::path::{Path, PathBuf};
use stiction_docs::contents::{FIGURES, pages};

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Files below a folder of the repository, from its top on.
fn below(folder: &str) -> Vec<String> {
    let mut found = vec![];
    for entry in std::fs::read_dir(top().join(folder)).expect("a folder") {
        let entry = entry.expect("an entry");
        let name = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() { found.extend(below(&name)) } else { found.push(name) }
    }
    found
}

#[test]
fn every_document_has_a_page() {
    let written: Vec<&str> =
        pages().filter_map(|page| page.written).map(|written| written.source).collect();
    for document in below("docs").iter().filter(|name| name.ends_with(".md")) {
        assert!(
            written.contains(&&**document),
            "{document} has no line in crates/stiction-docs/src/contents.rs"
        );
    }
}

#[test]
fn every_figure_of_the_documents_is_there() {
    let shown: Vec<String> = FIGURES.iter().map(|(path, _)| format!("docs/{path}")).collect();
    let mut there = below("docs/figures");
    there.sort();
    assert_eq!(shown, there);
}

#[test]
fn pages_have_places_of_their_own() {
    let mut places: Vec<&str> = pages().map(|page| page.path).collect();
    let count = places.len();
    places.sort();
    places.dedup();
    assert_eq!(places.len(), count);
}

#[test]
fn every_crate_is_listed_with_what_it_says_of_itself() {
    let list = include_str!("../../../docs/crates.md");
    for manifest in below("crates").iter().filter(|name| name.ends_with("/Cargo.toml")) {
        let text = std::fs::read_to_string(top().join(manifest)).expect("a manifest");
        let value = |key: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(&format!("{key} = \"")));
            line.and_then(|rest| rest.strip_suffix('"'))
                .expect("a name and a description")
                .to_owned()
        };
        let row = format!("| `{}` | {} |", value("name"), value("description"));
        assert!(list.lines().any(|line| line == row), "docs/crates.md lacks {row}");
    }
}
