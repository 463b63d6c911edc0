//! `stiction compensate`.

use crate::{assert_near, folder, no_loop_is_refused, paper, read, refuses, rows, run};

#[test]
fn all_compensators_or_one() {
    let folder = folder("compensate");
    let list = run(&folder, &["compensate", "--list"]).quiet_success();
    assert_eq!(list.lines().count(), 18);
    let all = run(&folder, &paper("compensate", &["--plot", "all.svg"])).quiet_success();
    assert!(all.contains("\nas it is                 1.10   1.10    1.25"), "{all}");
    assert_eq!(all.lines().skip(3).take_while(|line| !line.is_empty()).count(), 10);
    assert!(!read(&folder, "all.svg").contains("valve repaired"));

    let one = ["--method", "knocker", "--S", "4", "--J", "2", "--at", "100", "--plot", "one.svg"];
    let out = run(&folder, &paper("compensate", &one)).quiet_success();
    assert!(out.contains("\nknocker ") && out.contains("Chosen for S = 4.00 %, J"), "{out}");
    assert!(out.contains("\nParameters\n  amplitude "), "{out}");
    let svg = read(&folder, "one.svg");
    assert!(svg.contains("compensator on") && svg.contains("signal to the valve"));

    let mut json = one.to_vec();
    json.truncate(8);
    json.push("--json");
    let json = run(&folder, &paper("compensate", &json)).json();
    assert_near(&json["assumed"]["S"], 4.0, 0.0);
    assert_near(&json["protocol"]["on_s"], 100.0, 0.0);
    assert_eq!(json["methods"].as_array().expect("a list").len(), 2);
    let csv = run(&folder, &paper("compensate", &["--method", "two-move", "--csv", "-"]));
    assert_eq!(rows(&csv.quiet_success()).1.len(), 2 * 6);
}

#[test]
fn invalid_requests_are_refused() {
    let folder = folder("compensate-refused");
    no_loop_is_refused(&folder, "compensate");
    for (option, value, expected) in [
        ("--method", "nonesuch", "there is no compensator named \"nonesuch\"; known are knocker"),
        ("--S", "-1", "S"),
        ("--J", "nan", "J"),
        ("--at", "-5", "time before the compensator is on"),
        ("--at", "1e12", "samples"),
    ] {
        refuses(&folder, &paper("compensate", &[option, value]), expected);
    }
}
