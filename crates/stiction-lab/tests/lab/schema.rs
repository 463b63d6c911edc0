//! The page's types are made of what the crate declares.

#[test]
fn the_schema_of_the_page_is_that_of_the_calls() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/web/schema.json");
    let now = format!("{:#}\n", stiction_lab::calls::schema());
    if std::env::var_os("STICTION_WRITE").is_some() {
        std::fs::write(path, &now).unwrap();
    }
    let kept = std::fs::read_to_string(path).unwrap();
    assert!(
        kept == now,
        "web/schema.json is of other calls; write it with STICTION_WRITE=1, and run npm run build"
    );
}
