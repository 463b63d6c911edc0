//! What is in an FMU.

use std::io::{Cursor, Read};
use stiction_fmu::{Fmi, Fmu, models};
use stiction_fmu_export::{Library, of_scenario, write};
use stiction_io::Scenario;

fn file(bytes: &[u8], name: &str) -> Vec<u8> {
    let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut content = vec![];
    zip.by_name(name).unwrap().read_to_end(&mut content).unwrap();
    content
}

#[test]
fn an_fmu_holds_all_that_belongs_to_it() {
    let valve = Fmu::new("valve", "he").unwrap().with("S", 4.0).unwrap();
    for fmi in [Fmi::V2, Fmi::V3] {
        let libraries = Library::own().unwrap();
        let moment = Some(1_772_323_200);
        let bytes = write(&valve, fmi, &libraries, moment).unwrap();
        assert_eq!(file(&bytes, "modelDescription.xml"), valve.xml(fmi, moment).into_bytes());
        let json = String::from_utf8(file(&bytes, "resources/stiction.json")).unwrap();
        assert_eq!(Fmu::from_json(&json).unwrap(), valve);
        let page = String::from_utf8(file(&bytes, "documentation/index.html")).unwrap();
        assert!(valve.variables().iter().all(|v| page.contains(v.name)));
        for library in &libraries {
            let name = valve.binary(fmi, &library.arch, &library.os).unwrap();
            assert_eq!(file(&bytes, &name), *library.bytes, "{name}");
        }
        // The same model and moment, the same bytes.
        assert_eq!(write(&valve, fmi, &libraries, moment).unwrap(), bytes);
        assert_ne!(write(&valve, fmi, &libraries, None).unwrap(), bytes);

        let (icon, terminals) =
            ("terminalsAndIcons/icon.png", "terminalsAndIcons/terminalsAndIcons.xml");
        let icon = if fmi == Fmi::V2 { "model.png" } else { icon };
        let png = file(&bytes, icon);
        assert!(png.starts_with(b"\x89PNG") && page.contains(icon));
        // Width and height of 256 pixels.
        assert_eq!(png[16..24], [0, 0, 1, 0, 0, 0, 1, 0]);
        if fmi == Fmi::V3 {
            assert!(file(&bytes, terminals).starts_with(b"<?xml"));
        }
        for (name, words) in [
            ("license.txt", "MIT OR Apache-2.0"),
            ("LICENSE-MIT.txt", "Permission is hereby granted"),
            ("LICENSE-APACHE.txt", "Version 2.0, January 2004"),
        ] {
            let text = file(&bytes, &format!("documentation/licenses/{name}"));
            assert!(String::from_utf8(text).unwrap().contains(words), "{name}");
        }
    }
}

/// That of this platform first, then those that `STICTION_FMU_TARGETS` lists.
#[test]
fn libraries_are_of_the_requested_platforms() {
    let libraries = Library::own().unwrap();
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

/// Every model has its own equations, source and picture.
#[test]
fn pages_say_what_the_model_does() {
    for entry in models() {
        let fmu = Fmu::new(entry.model, entry.law).unwrap();
        let bytes = write(&fmu, Fmi::V3, &[], None).unwrap();
        let page = String::from_utf8(file(&bytes, "documentation/index.html")).unwrap();
        let holds =
            |part: &str| assert!(page.contains(part), "{} {}: {part}", entry.model, entry.law);
        holds("<svg");
        holds("fmpy.simulate_fmu(");
        holds(match (entry.model, fmu.law()) {
            ("stem", "classical" | "karnopp") => "exp(-(v/vs)^2)] sgn v",
            ("stem", "lugre" | "dahl") => "F = s0 z",
            ("stem", "gms") => "element i slips",
            ("stem", "armstrong") => "presliding",
            ("loop", _) => "tau dy/dt",
            (_, "ideal") => "x = u",
            (_, "he-wang") => "x + K (u - x",
            (_, "play") => "limited to u - S/2",
            (_, "stenman") => "|u - x| &gt; J",
            _ => "|u - x| &gt; fs",
        });
        assert!(!page.contains("Source: ."), "{} {}", entry.model, entry.law);
        assert!(!page.contains("NaN"), "{} {}", entry.model, entry.law);
    }
}

#[test]
fn libraries_without_a_place_are_refused() {
    let valve = Fmu::new("valve", "he").unwrap();
    let own = Library::own().unwrap().swap_remove(0);
    let odd = Library { arch: "6502".to_owned(), ..own.clone() };
    assert!(write(&valve, Fmi::V2, &[odd], None).unwrap_err().to_string().contains("6502"));
    let twice = write(&valve, Fmi::V2, &[own.clone(), own.clone()], None).unwrap_err();
    assert!(twice.to_string().contains("two libraries"));

    // FMI 2.0 has no folder for ARM. A release holds its library all the same.
    let arm = Library { arch: "aarch64".to_owned(), os: "linux".to_owned(), ..own.clone() };
    let other = Library { arch: "x86_64".to_owned(), os: "windows".to_owned(), ..own };
    let both = [arm.clone(), other.clone()];
    let without = write(&valve, Fmi::V2, &both, None).unwrap();
    assert_eq!(without, write(&valve, Fmi::V2, std::slice::from_ref(&other), None).unwrap());
    assert!(write(&valve, Fmi::V3, &both, None).unwrap().len() > without.len());
    let asked = Library { given: true, ..arm.clone() };
    for refused in [vec![arm], vec![asked, other]] {
        assert!(
            write(&valve, Fmi::V2, &refused, None).unwrap_err().to_string().contains("aarch64")
        );
    }
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
        assert!(error.contains("closed loop") || error.contains("is not possible"), "{error}");
    }
}
