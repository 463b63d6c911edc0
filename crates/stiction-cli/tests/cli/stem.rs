//! `stiction stem`.

use crate::{column, folder, read, rows, run, write};

#[test]
fn stem_lists_sets_and_laws() {
    let folder = folder("stem-list");
    let list = run(&folder, &["stem", "--list"]).quiet_success();
    let (sets, laws) = list.split_once("friction laws\n").expect("two parts");
    let names = |part: &str| -> Vec<String> {
        let entries =
            part.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
        entries.filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
    };
    assert_eq!(names(laws), ["classical", "karnopp", "dahl", "lugre", "gms", "armstrong"]);
    assert!(names(sets).len() >= 5, "{sets}");
    for set in names(sets) {
        let arguments =
            ["stem", "--parameters", &set, "--period", "2", "--amplitude", "1", "--json"];
        let json = run(&folder, &arguments).json();
        assert_eq!(json["set"], set.as_str());
    }
}

/// `S`, `J` follow from the forces: `S = (Fs + Fc) / (A dP)` of the signal, `J = (Fs - Fc) / (A dP)`.
#[test]
fn stem_tells_the_equivalent_bands() {
    let folder = folder("stem-json");
    let json = run(&folder, &["stem", "--parameters", "cts", "--json"]).json();
    let of = |path: &str| json.pointer(path).and_then(|v| v.as_f64()).expect("a number");
    let signal = of("/stem/area_m2") * (of("/stem/pressure_max_pa") - of("/stem/pressure_min_pa"));
    let (high, low) = (of("/friction/parameters/static_n"), of("/friction/parameters/coulomb_n"));
    let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-12);
    near(of("/equivalent/S_percent_of_signal"), 100.0 * (high + low) / signal);
    near(of("/equivalent/J_percent_of_signal"), 100.0 * (high - low) / signal);
    let spring = of("/stem/spring_n_per_m") * of("/stem/stroke_m");
    near(of("/equivalent/S_percent_of_stroke"), 100.0 * (high + low) / spring);
    near(of("/equivalent/J_percent_of_stroke"), 100.0 * (high - low) / spring);
}

#[test]
fn stem_writes_samples_and_events() {
    let folder = folder("stem-events");
    let arguments =
        ["stem", "--parameters", "cts-stribeck", "--period", "200", "--duration", "400"];
    let files = ["--json", "-o", "out.csv", "--events", "events.csv"];
    let json = run(&folder, &[&arguments[..], &files].concat()).json();
    let out = read(&folder, "out.csv");
    assert_eq!(
        rows(&out).0,
        ["t", "op", "pressure_pa", "vp", "position_m", "velocity_m_per_s", "friction_n"]
    );
    assert_eq!(column(&out, "t").len(), 4001);
    let vp = column(&out, "vp");
    assert!(vp.iter().all(|vp| (-1e-9..=100.0 + 1e-9).contains(vp)), "end stops hold");

    let events = read(&folder, "events.csv");
    let (header, all) = rows(&events);
    assert_eq!(header, ["t", "event", "direction", "vp", "position_m"]);
    let count = |kind: &str| all.iter().filter(|row| row[1] == kind).count() as u64;
    assert_eq!(json["slips"].as_u64(), Some(count("slip")));
    assert!(count("slip") > 10, "a staircase: {events}");
    let times = column(&events, "t");
    assert!(times.windows(2).all(|pair| pair[0] <= pair[1]));
}

#[test]
fn stem_follows_a_file() {
    let folder = folder("stem-input");
    write(&folder, "op.csv", "t,op\n0,50\n1,50\n3,90\n5,90\n");
    let arguments = ["stem", "--input", "op.csv", "--column", "op"];
    let out = run(&folder, &arguments).quiet_success();
    assert_eq!(column(&out, "t"), [0.0, 1.0, 3.0, 5.0]);
    assert_eq!(column(&out, "op"), [50.0, 50.0, 90.0, 90.0]);
    let vp = column(&out, "vp");
    assert_eq!(vp[0], vp[1]);
    assert!(vp[3] > vp[0] + 5.0, "{vp:?}");
}

#[test]
fn stem_takes_changes() {
    let folder = folder("stem-with");
    let json = run(
        &folder,
        &["stem", "--set", "coulomb_n=900", "--set", "mass_kg=2", "--set", "mass_kg=3", "--json"],
    )
    .json();
    assert_eq!(json["friction"]["parameters"]["coulomb_n"], 900.0);
    assert_eq!(json["stem"]["mass_kg"], 3.0, "the last counts");
}
