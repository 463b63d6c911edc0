//! `stiction figures`.

use crate::{command, folder, read};
use std::path::Path;

/// Name and bytes of every file the command writes on so many threads.
fn draw(folder: &Path, threads: &str) -> Vec<(String, Vec<u8>)> {
    let output = command(folder)
        .env("RAYON_NUM_THREADS", threads)
        .args(["figures", "--output", threads])
        .output()
        .expect("the command starts");
    assert!(output.status.success());
    assert!(output.stderr.is_empty(), "no progress bar where no one watches");
    let mut files: Vec<_> = std::fs::read_dir(folder.join(threads))
        .expect("the folder is made")
        .map(|entry| entry.expect("a file").path())
        .map(|path| {
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            (name, std::fs::read(path).expect("it can be read"))
        })
        .collect();
    files.sort();
    files
}

#[test]
fn figures_are_complete_and_the_same_on_any_number_of_threads() {
    let folder = folder("figures");
    let files = draw(&folder, "1");
    assert!(files == draw(&folder, "2"));

    let index = read(&folder, "1/index.html");
    assert!(index.starts_with("<!DOCTYPE html>") || index.starts_with("<!doctype html>"));
    assert!(!index.contains("http://") && !index.contains("https://"), "nothing from elsewhere");
    let named = |extension: &str| -> Vec<_> {
        files.iter().filter_map(|(name, _)| name.strip_suffix(extension)).collect()
    };
    assert_eq!(named(".svg"), named(".png"));
    assert_eq!(files.len(), 2 * named(".svg").len() + 1);
    // The paper's figures with a plot, by its own numbers.
    for number in [2, 3, 5, 6, 7, 8, 9, 10, 11, 13, 14, 15, 16, 17] {
        let start = format!("figure-{number:02}-");
        assert!(named(".svg").iter().any(|name| name.starts_with(&start)), "{start}");
    }
    for (name, bytes) in &files {
        if name.ends_with(".svg") {
            assert!(bytes.starts_with(b"<svg xmlns=\"http://www.w3.org/2000/svg\""), "{name}");
            assert!(bytes.trim_ascii_end().ends_with(b"</svg>"), "{name}");
            assert!(index.contains(name.as_str()), "{name} is shown");
        } else if name.ends_with(".png") {
            assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"), "{name}");
        }
    }
}
