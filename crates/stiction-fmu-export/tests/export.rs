//! What is in an FMU.

use std::io::{Cursor, Read};
use stiction_fmu::{Fmi, Fmu};
use stiction_fmu_export::{Library, of_scenario, write};
use stiction_io::Scenario;

fn file(bytes: &[u8], name: &str) -> Vec<u8> {
    let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut content = vec![];
    zip.by_name(name).unwrap().read_to_end(&mut content).unwrap();
    content
}

#[test]
fn an_fmu_holds_description_parameters_page_and_library() {
    let valve = Fmu::new("valve", "he").unwrap().with("S", 4.0).unwrap();
    for fmi in [Fmi::V2, Fmi::V3] {
        let libraries = Library::built_in();
        let bytes = write(&valve, fmi, &libraries).unwrap();
        assert_eq!(file(&bytes, "modelDescription.xml"), valve.xml(fmi).into_bytes());
        let json = String::from_utf8(file(&bytes, "resources/stiction.json")).unwrap();
        assert_eq!(Fmu::from_json(&json).unwrap(), valve);
        let page = String::from_utf8(file(&bytes, "documentation/index.html")).unwrap();
        assert!(valve.variables().iter().all(|v| page.contains(v.name)));
        for library in &libraries {
            let name = fmi.binary(&library.arch, &library.os).unwrap();
            assert_eq!(file(&bytes, &name), *library.bytes, "{name}");
        }
        // The same model, the same bytes.
        assert_eq!(write(&valve, fmi, &libraries).unwrap(), bytes);
    }
}

/// That of this platform first, then those that `STICTION_FMU_TARGETS` lists.
#[test]
fn libraries_are_of_the_platforms_asked_for() {
    let libraries = Library::built_in();
    let platforms: Vec<_> = libraries.iter().map(|l| (l.arch.as_str(), l.os.as_str())).collect();
    assert_eq!(platforms[0], (std::env::consts::ARCH, std::env::consts::OS));
    let further = option_env!("STICTION_FMU_TARGETS").unwrap_or_default();
    assert_eq!(further.contains("windows"), platforms.contains(&("x86_64", "windows")));
    for library in &libraries {
        let start: &[u8] = match library.os.as_str() {
            "linux" => b"\x7fELF",
            "windows" => b"MZ",
            _ => b"",
        };
        assert!(library.bytes.starts_with(start), "{}", library.os);
        // Nothing of the machine it was built on.
        for path in [env!("CARGO_MANIFEST_DIR"), "/.cargo/", "/.rustup/"] {
            let holds = library.bytes.windows(path.len()).any(|bytes| bytes == path.as_bytes());
            assert!(!holds, "{path} in the library for {}", library.os);
        }
    }
}

#[test]
fn libraries_without_a_place_are_refused() {
    let valve = Fmu::new("valve", "he").unwrap();
    let own = Library::built_in().swap_remove(0);
    let odd = Library { arch: "6502".to_owned(), ..own.clone() };
    assert!(write(&valve, Fmi::V2, &[odd]).unwrap_err().to_string().contains("6502"));
    let twice = write(&valve, Fmi::V2, &[own.clone(), own]).unwrap_err();
    assert!(twice.to_string().contains("two libraries"));
}

#[test]
fn a_scenario_becomes_a_loop_with_its_settings() {
    let set = ["valve.S=4".to_owned(), "controller.limits=[-50, 60]".to_owned()];
    let scenario = Scenario::open("paper/closed-loop", &set).unwrap();
    let fmu = of_scenario(&scenario).unwrap();
    let start =
        |name: &str| fmu.variables().iter().find(|v| v.name == name).and_then(|v| v.start).unwrap();
    for (name, value) in
        [("S", 4.0), ("J", 3.0), ("Kc", 1.1), ("Ti", 2.5), ("dead_time", 1.07), ("OP_high", 60.0)]
    {
        assert_eq!(start(name), value, "{name}");
    }
    for (name, set) in [
        ("paper/flow-cascade", ""),
        ("paper/open-loop-high", ""),
        ("paper/closed-loop", "controller.form=\"velocity\""),
    ] {
        let set: Vec<String> = [set.to_owned()].into_iter().filter(|s| !s.is_empty()).collect();
        let error = of_scenario(&Scenario::open(name, &set).unwrap()).unwrap_err().to_string();
        assert!(error.contains("closed loop") || error.contains("has no place"), "{error}");
    }
}
