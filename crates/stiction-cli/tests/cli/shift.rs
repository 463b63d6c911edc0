//! `stiction shift`.

use crate::{folder, run};

#[test]
fn recordings_are_compared_with_the_population() {
    let folder = folder("shift");
    run(&folder, &["population", "--n", "12", "--seed", "3", "-o", "loops"]).quiet_success();
    let args = ["shift", "loops/loop-00.csv", "loops/loop-01.csv", "--top", "5"];
    let text = run(&folder, &args).quiet_success();
    assert!(text.starts_with("2 recordings against "), "{text}");
    assert!(text.contains("feature") && text.contains("place"), "{text}");
    assert_eq!(text.lines().count(), 2 + 1 + 1 + 5, "{text}");
    assert_eq!(text, run(&folder, &args).quiet_success());
}
