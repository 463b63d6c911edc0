//! `stiction override`, and what `stiction diagnose` makes of it.

use crate::diagnose::with_samples;
use crate::{Done, read, refuses, run, write};

const FILE: &str = "FIC101-sticky.csv";
const KEPT: &str = "stiction-overrides.toml";

fn overrule(folder: &std::path::Path, more: &[&str]) -> crate::Done {
    let arguments = [
        &["override", FILE, "--verdict", "does-not-stick", "--reason", "new packing, stroked"][..],
        &["--by", "J. Miller", "--entered", "2026-03-02"],
        more,
    ];
    run(folder, &arguments.concat())
}

#[test]
fn an_override_is_shown_with_the_verdict_everywhere() {
    let folder = with_samples("override-shown");
    let said = overrule(&folder, &[]).quiet_success();
    assert!(
        said.starts_with("FIC101-sticky does not stick, by override, for this recording"),
        "{said}"
    );
    let text = run(&folder, &["diagnose", FILE]).quiet_success();
    assert!(text.contains("verdict   STICKS"), "{text}");
    assert!(
        text.contains("override  Overruled by J. Miller on 2026-03-02: the valve does not stick"),
        "{text}"
    );
    let json = run(&folder, &["diagnose", FILE, "FIC102-disturbed.csv", "--json"]).json();
    let verdict = &json["loops"][0]["verdict"];
    assert_eq!(
        (&verdict["class"], &verdict["override"]["verdict"]),
        (&"sticks".into(), &"does not stick".into())
    );
    assert_eq!(verdict["override"]["kept_in"], KEPT);
    assert!(json["loops"][1]["verdict"]["override"].is_null());
    let csv = run(&folder, &["diagnose", FILE, "--csv", "-"]).quiet_success();
    assert!(csv.contains("does not stick,\"new packing, stroked\""), "{csv}");
    run(&folder, &["diagnose", FILE, "--report", "r.html"]);
    assert!(read(&folder, "r.html").contains("Overruled by J. Miller on 2026-03-02"));
    let brief = run(&folder, &["diagnose", FILE, "--brief"]).quiet_success();
    assert!(brief.ends_with("; override: does not stick\n"), "{brief}");
    let list = run(&folder, &["override", ".", "--list"]).quiet_success();
    assert!(list.starts_with("FIC101-sticky: does not stick (new packing, stroked); by"), "{list}");
}

#[test]
fn fail_on_counts_classes_and_overrides() {
    let folder = with_samples("override-fail-on");
    let code =
        |arguments: &[&str]| run(&folder, &[&["diagnose", FILE][..], arguments].concat()).code;
    assert_eq!(code(&["--fail-on", "sticks"]), 1);
    assert_eq!(code(&["--fail-on", "sticks", "--json"]), 1);
    assert_eq!(code(&["--fail-on", "sticks", "--csv", "-"]), 1);
    assert_eq!(code(&["--fail-on", "cannot-tell,does-not-respond"]), 0);
    assert_eq!(code(&["--fail-on", "cannot-tell", "--fail-on", "sticks"]), 1);
    assert_eq!(code(&["--fail-on", "sticks", "missing.csv"]), 2);
    overrule(&folder, &[]).quiet_success();
    let done = run(&folder, &["diagnose", FILE, "--fail-on", "sticks"]);
    assert_eq!(done.code, 0);
    assert!(
        done.err.contains(
            "--fail-on counts FIC101-sticky as \"does not stick\" because of an override"
        ),
        "{}",
        done.err
    );
    assert_eq!(code(&["--fail-on", "does-not-stick"]), 1);
}

#[test]
fn it_holds_for_that_recording_only_until_widened() {
    let folder = with_samples("override-scope");
    overrule(&folder, &[]).quiet_success();
    let changed = read(&folder, FILE) + "2400,60,60,45\n";
    write(&folder, FILE, changed);
    let text = run(&folder, &["diagnose", FILE]).quiet_success();
    assert!(!text.contains("Overruled") && text.contains("the file has changed since"), "{text}");
    // Entered again it replaces the old one, and comments stay.
    let kept = format!("# checked weekly\n{}", read(&folder, KEPT));
    write(&folder, KEPT, kept);
    overrule(&folder, &[]).quiet_success();
    let kept = read(&folder, KEPT);
    assert!(
        kept.starts_with("# checked weekly\n") && kept.matches("[[override]]").count() == 1,
        "{kept}"
    );
    assert!(run(&folder, &["diagnose", FILE]).quiet_success().contains("Overruled"));
    // For all recordings it needs an end, and recordings without dates are not covered.
    let refused = overrule(&folder, &["--all-recordings"]).refusal();
    assert!(refused.contains("--all-recordings needs --until"), "{refused}");
    let removed = run(&folder, &["override", FILE, "--loop", "FIC101-sticky", "--remove"]);
    assert!(removed.quiet_success().starts_with("removed 1 override of FIC101-sticky"));
    overrule(&folder, &["--all-recordings", "--until", "2026-12-31"]).quiet_success();
    let text = run(&folder, &["diagnose", FILE]).quiet_success();
    assert!(!text.contains("Overruled") && text.contains("has no dates"), "{text}");
    let refused =
        run(&folder, &["override", FILE, "--loop", "FIC101-sticky", "--remove"]).refusal();
    assert!(
        refused.contains("no override of FIC101-sticky matches these options; see --list"),
        "{refused}"
    );
}

#[test]
fn malformed_overrides_are_named_with_file_line_and_remedy() {
    let folder = with_samples("override-malformed");
    for (text, expected) in [
        (
            "[[override]]\nloop = \"A\"\nverdict = \"fine\"\n",
            "line 3: override.verdict: there is no verdict",
        ),
        ("[[override]]\nloop = \"A\"\n", "line 1: override.verdict: is missing; give the verdict"),
        ("\n[[overide]]\n", "line 2: unknown key \"overide\"; known here are override"),
        ("[[override\n", "line 1"),
    ] {
        write(&folder, KEPT, text);
        for command in [&["diagnose", FILE][..], &["override", FILE, "--list"]] {
            let Done { code, err, .. } = run(&folder, command);
            assert_eq!(code, 0, "{err}");
            assert!(err.contains(KEPT) && err.contains(expected), "{expected}: {err}");
            assert!(err.contains("does not apply until you correct or remove it"), "{err}");
        }
    }
    for (arguments, expected) in [
        (&["override", FILE][..], "--verdict"),
        (&["override", FILE, "--verdict", "sticks"], "--reason"),
        (
            &["override", FILE, "--verdict", "maybe", "--reason", "x"],
            "known are sticks, does not stick",
        ),
        (&["override", FILE, "--verdict", "sticks", "--reason", " "], "must not be empty"),
        (&["override", FILE, "--verdict", "sticks", "--reason", "x", "--until", "soon"], "--until"),
        (&["override", FILE, "--remove"], "--remove needs --loop"),
        (&["override", "no.csv", "--list"], "no.csv: no such file"),
        (&["diagnose", FILE, "--fail-on", "maybe"], "known are sticks, does not stick"),
    ] {
        let _ = std::fs::remove_file(folder.join(KEPT));
        refuses(&folder, arguments, expected);
    }
}
