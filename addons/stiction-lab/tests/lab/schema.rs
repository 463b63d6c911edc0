//! Files of the page that are made of what the crates declare.

use std::path::Path;

fn is_kept(file: &str, now: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("web").join(file);
    if std::env::var_os("STICTION_WRITE").is_some() {
        std::fs::write(&path, now).unwrap();
    }
    assert!(
        std::fs::read_to_string(path).unwrap() == now,
        "web/{file} is out of date; write it with STICTION_WRITE=1, and run npm run build"
    );
}

#[test]
fn the_schema_of_the_page_is_that_of_the_calls() {
    is_kept("schema.json", &format!("{:#}\n", stiction_lab::calls::schema()));
}

#[test]
fn the_colours_of_the_signals_in_the_schema_of_the_page_are_those_of_the_figures() {
    is_kept("src/signals.css", &stiction_figure::figure::signals_css());
}
