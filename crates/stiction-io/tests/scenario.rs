//! Scenarios: what any text and any setting come to.

use proptest::prelude::*;
use stiction_io::scenario::{System, built_in, built_in_text};
use stiction_io::{Error, Scenario};

const LOOP: &str = "sample_time = 0.1\nduration = 10\n[controller]\nkc = 1.1\nti = 2.5\n[valve]\n\
                    S = 5\nJ = 2\n[process]\ngain = 1.5\ntau = 5.93\ndelay = 1.07\n";

fn error(text: &str) -> String {
    Scenario::parse(text, "test.toml", None).expect_err("malformed").to_string()
}

#[test]
fn built_in_scenarios_are_well_formed_and_say_so() {
    let mut count = 0;
    for (name, title) in built_in() {
        assert!(!title.is_empty(), "{name}");
        let text = built_in_text(name).expect("it is built in");
        let scenario = Scenario::open(name, &[]).expect("well formed");
        assert_eq!(scenario, Scenario::parse(text, name, None).expect("well formed"));
        assert!(scenario.notes.is_empty(), "{name}: {:?}", scenario.notes);
        match &scenario.system {
            System::OpenLoop(system) => {
                assert_eq!(system.run().map(|run| run.vp.len()), { Ok(system.samples) })
            }
            System::ClosedLoop(system) => system.check().expect("in range"),
            System::Cascade(system) => system.check().expect("in range"),
        }
        count += 1;
    }
    assert_eq!(count, 18);
}

#[test]
fn settings_are_listed_with_their_units() {
    let text = "title = 'x'\nsample_time = 0.1 # s\nduration = 10\n[[load]]\nvalue = 1\n[[load]]\n\
                value = 2\n"
        .to_owned()
        + &LOOP["sample_time = 0.1\nduration = 10\n".len()..];
    let settings = Scenario::parse(&text, "test", None).expect("well formed").settings();
    let of = |key: &str| {
        let found = settings.iter().find(|(k, ..)| k == key);
        found.map(|(_, value, unit)| (value.as_str(), *unit))
    };
    assert_eq!(of("sample_time"), Some(("0.1", "s")));
    assert_eq!(of("valve.S"), Some(("5", "% of span")));
    assert_eq!(of("load.1.value"), Some(("2", "")));
    assert_eq!(of("title"), None, "it is shown by itself");
}

#[test]
fn tables_may_be_written_in_any_way_toml_has() {
    let dotted = "sample_time = 1e-1\nduration = 1_0\ncontroller = { kc = 1.1, ti = 2.5 }\n\
                  valve.S = 5.0\nvalve.J = 0x2\n[process]\n'gain' = 1.5\ntau = 5.93\ndelay = 1.07\n";
    let system = |text: &str| Scenario::parse(text, "test", None).expect("well formed").system;
    assert_eq!(system(dotted), system(LOOP));
    // A single table counts as a list of one.
    let load = |text: &str| system(&(LOOP.to_owned() + text));
    assert_eq!(load("[load]\nvalue = 1\n"), load("[[load]]\nvalue = 1\n"));
}

#[test]
fn errors_point_at_the_first_unknown_key() {
    let text = LOOP.replace("[valve]\n", "[valve]\nzeta = 1\nalpha = 2\n");
    assert!(error(&text).starts_with("test.toml, line 7: unknown key \"valve.zeta\""));
    // Lines with characters of several bytes count as lines.
    let text = "# größer als µ\n".to_owned() + &text;
    assert!(error(&text).starts_with("test.toml, line 8: unknown key \"valve.zeta\""));
    let text = text.replace('\n', "\r\n");
    assert!(error(&text).starts_with("test.toml, line 8: unknown key \"valve.zeta\""));
}

#[test]
fn what_the_library_refuses_is_pointed_at_where_the_key_is_known() {
    for (from, to, place) in [
        ("ti = 2.5", "ti = -1", "line 5: controller.ti: Ti is -1"),
        ("S = 5", "S = -1", "line 7: valve.S: S is -1"),
        ("S = 5", "S = 5\nlag = -1", "line 8: valve.lag: stem lag is -1"),
        ("S = 5", "S = 5\nrest_tolerance = -1", "line 8: valve.rest_tolerance: rest tolerance is"),
        ("tau = 5.93", "tau = 0", "line 9: [process]: process time constant is 0"),
    ] {
        let error = error(&LOOP.replace(from, to));
        assert!(error.starts_with(&format!("test.toml, {place}")), "{error}");
    }
}

#[test]
fn signals_from_files_need_a_folder() {
    let text = LOOP.to_owned() + "[set_point]\nsignal = 'file'\nfile = 'a.csv'\ncolumn = 'u'\n";
    assert!(
        error(&text).contains("line 15: set_point.file: only scenarios in files can read signals")
    );
}

/// Lines of scenarios, well formed or nearly so.
fn line() -> impl Strategy<Value = String> {
    let keys = "sample_time|duration|title|S|J|K|fs|model|lag|limits|kc|ti|td|kp|gain|tau|delay|type\
                |num|den|signal|value|steps|period|amplitude|sd|seed|every|op|pv|start|dwell|stairs";
    let tables = "(master\\.)?(valve|controller|process|input|set_point|noise|master|resolution)";
    let values = "-?[0-9]{1,3}(\\.[0-9])?|1e-?[0-9]{1,3}|nan|-inf|true|'kano'|'sine'|'steps'|'noise'\
                  |\\[1, 2\\]|\\[\\[0, 1\\], \\[2, 3\\]\\]|\\[\\]|\\{ value = 1 \\}";
    prop_oneof![
        4 => (keys, values).prop_map(|(key, value)| format!("{key} = {value}")),
        2 => tables.prop_map(|table| format!("[{table}]")),
        1 => Just("[[load]]".to_owned()),
        1 => "[\\[\\]a-zS=.\"'#é{} 0-9-]{0,12}",
    ]
}

/// An error must tell the line, and there must be such a line.
fn check_place(text: &str) -> Result<(), TestCaseError> {
    match Scenario::parse(text, "test.toml", None) {
        Err(Error::Scenario { line, message, .. }) => {
            prop_assert!((1..=text.matches('\n').count() + 1).contains(&line), "line {line}");
            prop_assert!(!message.is_empty());
        }
        Err(other) => prop_assert!(false, "{other}"),
        Ok(scenario) => {
            let printed = Scenario::parse(&scenario.text, "test.toml", None);
            prop_assert_eq!(printed.expect("what was read is read again"), scenario);
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn any_text_is_a_scenario_or_an_error_that_tells_the_line(text in "\\PC{0,80}|(?s:.{0,80})") {
        check_place(&text)?;
    }

    #[test]
    fn any_lines_are_a_scenario_or_an_error_that_tells_the_line(
        lines in prop::collection::vec(line(), 0..20), at in any::<prop::sample::Index>(),
    ) {
        check_place(&lines.join("\n"))?;
        // Also in the midst of a well-formed one.
        let mut text: Vec<_> = LOOP.lines().map(str::to_owned).collect();
        let at = at.index(text.len() + 1);
        text.splice(at..at, lines);
        check_place(&text.join("\n"))?;
    }

    #[test]
    fn any_setting_is_taken_or_refused_by_name(setting in "[a-zS.]{0,8}=?[0-9a-z\\[\\]\"{}, .-]{0,8}") {
        match Scenario::open("paper/flow-cascade", std::slice::from_ref(&setting)) {
            Ok(scenario) => check_place(&scenario.text)?,
            Err(error) => {
                let named = format!("settings {setting}: ");
                prop_assert!(error.to_string().starts_with(&named), "{error}");
            }
        }
    }

    /// What is set is what is there.
    #[test]
    fn a_set_number_reads_back_the_same(value in 1e-9..1e9f64) {
        let setting = format!("valve.S={value}");
        let scenario = Scenario::open("paper/closed-loop", &[setting]).expect("it fits");
        let plain = Scenario::open("paper/closed-loop", &["valve.S = 5".to_owned()]).expect("it fits");
        let found = scenario.settings().into_iter().find(|(key, ..)| key == "valve.S");
        let found = found.expect("it is there").1;
        prop_assert_eq!(found.parse::<f64>().expect("a number").to_bits(), value.to_bits());
        prop_assert_eq!(plain.system == scenario.system, value == 5.0);
    }
}
