//! `stiction fmu`.

use crate::{folder, refuses, run};
use std::path::Path;

/// The names of the files in a zip, from its directory.
fn names(path: &Path) -> Vec<String> {
    let bytes = std::fs::read(path).expect("the FMU was written");
    let mut names = vec![];
    for at in 0..bytes.len().saturating_sub(46) {
        if bytes[at..].starts_with(b"PK\x01\x02") {
            let length = usize::from(u16::from_le_bytes([bytes[at + 28], bytes[at + 29]]));
            names.push(String::from_utf8_lossy(&bytes[at + 46..at + 46 + length]).into_owned());
        }
    }
    names
}

#[test]
fn fmu_tells_what_its_variables_are() {
    let folder = folder("fmu-variables");
    let table = run(&folder, &["fmu", "--model", "two-phase", "--S", "4", "--variables"]);
    assert_eq!(
        table.quiet_success(),
        "\
time             time                 s      Time
OP               input             50 %      Controller output, held over each step
VP               output               %      Valve position
stuck            output                      Whether the stem is stuck
slips            output                      Number of slips: starts of motion and reversals of the stem
S                tunable            4 %      Stick band plus dead band
J                tunable            2 %      Slip jump
K                tunable         1.99 1      Overshoot of a slip, 1 to 2; law he-wang only
rest_tolerance   parameter          0 %/s    OP speed at which a moving stem stops; law two-phase only
stem_lag         parameter          0 s      Time constant of the lag from the law to VP; 0 for no lag
limited          parameter      false        Whether OP and VP are limited
low              parameter          0 %      Lower limit of OP and VP, if they are limited
high             parameter        100 %      Upper limit of OP and VP, if they are limited
VP_start         parameter         50 %      Valve position and OP before the start
"
    );
    let json = run(&folder, &["fmu", "--stem", "lugre", "--variables", "--json"]).json();
    let of = |name: &str| {
        json.as_array().unwrap().iter().find(|v| v["name"] == name).expect("the variable").clone()
    };
    assert_eq!(of("supply")["unit"], "Pa");
    assert_eq!(of("VP")["start"], serde_json::Value::Null);
    assert_eq!(of("end_stops")["start"], true);
}

#[test]
fn everything_listed_can_be_exported() {
    let folder = folder("fmu-list");
    let list = run(&folder, &["fmu", "--list", "--json"]).json();
    let text = run(&folder, &["fmu", "--list"]).quiet_success();
    let models = list["models"].as_array().unwrap();
    assert_eq!(text.lines().count(), models.len() + 2);
    let own = format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS);
    assert_eq!(list["platforms"][0], own.as_str());
    assert!(text.lines().last().unwrap().contains(&own));
    for entry in models {
        let (model, law) = (entry["model"].as_str().unwrap(), entry["law"].as_str().unwrap());
        let law_of_valve = format!("valve.model=\"{law}\"");
        let chosen = match model {
            "valve" => vec!["--model", law],
            "stem" => vec!["--stem", law],
            _ => vec!["paper/closed-loop", "--set", &law_of_valve],
        };
        let path = folder.join("out.fmu");
        for (fmi, start) in [("2", "binaries/linux64/"), ("3", "binaries/x86_64-linux/")] {
            let _ = std::fs::remove_file(&path);
            let done =
                run(&folder, &[&["fmu"][..], &chosen, &["--fmi", fmi, "-o", "out.fmu"]].concat());
            assert_eq!((done.code, done.out.as_str()), (0, ""), "{model} {law}: {}", done.err);
            let names = names(&path);
            let count = |start: &str| names.iter().filter(|name| name.starts_with(start)).count();
            for file in [
                "modelDescription.xml",
                "resources/stiction.json",
                "documentation/index.html",
                "documentation/licenses/license.txt",
            ] {
                assert_eq!(count(file), 1, "{names:?}");
            }
            if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
                assert_eq!(count(start), 1, "{names:?}");
            }
        }
    }
}

/// The same model and date, the same bytes; another date, others.
#[test]
fn an_export_can_be_repeated() {
    let folder = folder("fmu-date");
    let bytes = |date: &str, file: &str| {
        let done = run(&folder, &["fmu", "--stem", "usp", "--date", date, "-o", file]);
        assert_eq!(done.code, 0, "{}", done.err);
        std::fs::read(folder.join(file)).unwrap()
    };
    let first = bytes("2026-03-01T00:00:00Z", "a.fmu");
    assert_eq!(first, bytes("2026-03-01T01:00:00+01:00", "b.fmu"));
    assert_ne!(first, bytes("2026-03-02T00:00:00Z", "c.fmu"));
}

#[test]
fn what_cannot_be_exported_is_refused_in_a_sentence() {
    let folder = folder("fmu-refused");
    for (arguments, words) in [
        (&["--model", "sticky", "-o", "x.fmu"][..], "two-phase"),
        (&["--model", "he", "--S", "-1", "-o", "x.fmu"], "S is -1"),
        (&["--model", "he", "--S", "NaN", "-o", "x.fmu"], "S is NaN"),
        (&["--stem", "butter", "-o", "x.fmu"], "known are classical"),
        (&["--stem", "lugre", "--S", "5", "-o", "x.fmu"], "cannot be used with"),
        (&["--stem", "lugre", "--set", "mass_kg", "-o", "x.fmu"], "NAME=VALUE"),
        (&["--stem", "lugre", "--set", "mass_kg=heavy", "-o", "x.fmu"], "not a number"),
        (&["--stem", "lugre", "--set", "mass_kg=-1", "-o", "x.fmu"], "mass is -1"),
        (&["--stem", "lugre", "--set", "VP=1", "-o", "x.fmu"], "VP is computed"),
        (&["paper/open-loop-high", "-o", "x.fmu"], "closed loop"),
        (&["paper/closed-lop", "-o", "x.fmu"], "paper/closed-loop"),
        (&["--model", "he", "--library", "win=x.dll", "-o", "x.fmu"], "ARCH-OS=FILE"),
        (&["--model", "he", "--library", "x86_64-windows=x.dll", "-o", "x.fmu"], "x.dll"),
        (&["--model", "he", "--date", "yesterday", "-o", "x.fmu"], "--date"),
        (&["--model", "he", "--date", "1960-01-01T00:00:00Z", "-o", "x.fmu"], "after 1970"),
        (&["--model", "he"], "--output"),
        (&["--model", "he", "--json", "-o", "x.fmu"], "--json needs --list or --variables"),
        (&["--model", "he", "-o", "no/such/x.fmu"], "x.fmu"),
    ] {
        refuses(&folder, &[&["fmu"], arguments].concat(), words);
    }
    assert!(!folder.join("x.fmu").exists());
}
