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
            "{document} has no line in addons/stiction-docs/src/contents.rs"
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
    let files = [below("crates"), below("addons")].concat();
    for manifest in files.iter().filter(|name| name.ends_with("/Cargo.toml")) {
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

/// Times such as `3 min 44 s`, `7 min` or `45 s`, and sizes such as `46 MB`, in a text.
fn times_and_sizes(text: &str) -> Vec<String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let number = |word: &str| word.parse::<f64>().is_ok();
    let unit = |word: &str| word.trim_end_matches([',', '.', ';', ':', ')']).to_owned();
    let mut found = vec![];
    let mut at = 0;
    while at + 1 < words.len() {
        let (first, of) = (words[at].trim_start_matches('('), unit(words[at + 1]));
        at += 1;
        if !number(first) || !["min", "s", "MB"].contains(&&*of) {
            continue;
        }
        let mut all = format!("{first} {of}");
        if of == "min" && words.get(at + 2).is_some_and(|word| unit(word) == "s") {
            all += &format!(" {} s", words[at + 1]);
            at += 2;
        }
        found.push(all);
    }
    found
}

#[test]
fn times_and_sizes_for_new_users_were_measured() {
    assert_eq!(
        times_and_sizes("takes 3 min 44 s (46 MB), or 7 min, on 2 cores; 12 s."),
        ["3 min 44 s", "46 MB", "7 min", "12 s"]
    );
    let read = |name: &str| std::fs::read_to_string(top().join(name)).expect("a document");
    let benchmarks = read("BENCHMARKS.md");
    let building = benchmarks.split_once("\n## Building").expect("a part on building").1;
    let building = building.split("\n## ").next().unwrap_or_default();
    let measured = times_and_sizes(&building.replace('|', " "));
    let mut all = 0;
    for name in ["README.md", "CONTRIBUTING.md", "docs/start.md", "python/README.md"] {
        let text = read(name);
        let of_building =
            |line: &&str| ["build", "wheel", "clone", "MB"].iter().any(|word| line.contains(word));
        for told in text.lines().filter(of_building).flat_map(times_and_sizes) {
            assert!(
                measured.contains(&told),
                "{name} says \"{told}\", which is not in the part Building of BENCHMARKS.md"
            );
            all += 1;
        }
    }
    assert!(all >= 2, "README and start.md say how long the first build takes");
}
