//! `stiction schema`.

use super::diagnose::{violations, with_samples};
use super::{folder, run};

#[test]
fn what_is_printed_is_as_its_schema_says() {
    let folder = with_samples("schema-history");
    let file = "FIC101-sticky.csv";
    for (document, arguments) in [
        ("diagnosis", &["diagnose", file, "--json"][..]),
        ("history", &["history", file, "--window", "5min", "--repair", "1200", "--json"]),
    ] {
        let schema = run(&folder, &["schema", document]).json();
        let json = run(&folder, arguments).json();
        assert_eq!(violations(&json, &schema, &schema, document), Vec::<String>::new());
    }
}

#[test]
fn a_schema_has_a_name() {
    let folder = folder("schema-names");
    let diagnosis = run(&folder, &["schema", "diagnosis"]).quiet_success();
    assert!(diagnosis == run(&folder, &["diagnose", "--schema"]).quiet_success());
    let refused = run(&folder, &["schema", "verdict"]).refusal();
    assert!(refused.contains("diagnosis") && refused.contains("history"), "{refused}");
}
