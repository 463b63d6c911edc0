//! The descriptions say what the tables say.

use std::collections::{BTreeMap, BTreeSet};

use stiction_fmu::{Causality, Fmi, Fmu, VariableKind, models};

/// The tags of a document with their attributes, if it is well-formed.
fn tags(xml: &str) -> Vec<(String, Vec<(String, String)>)> {
    let body = xml.strip_prefix("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n").expect("a head");
    let (mut open, mut tags) = (vec![], vec![]);
    for piece in body.split('<').skip(1) {
        let (tag, rest) = piece.split_once('>').expect("a tag ends");
        assert!(rest.trim().is_empty(), "text outside of tags: {rest}");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name));
            continue;
        }
        let (tag, closed) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
        let (name, mut rest) = tag.split_once(' ').unwrap_or((tag, ""));
        let mut attributes: Vec<(String, String)> = vec![];
        while let Some((key, after)) = rest.trim_start().split_once("=\"") {
            let (value, after) = after.split_once('"').expect("a value ends");
            assert!(!value.contains(['&', '<']), "{value}");
            assert!(attributes.iter().all(|(k, _)| k != key), "{key} twice");
            attributes.push((key.to_owned(), value.to_owned()));
            rest = after;
        }
        assert!(rest.trim().is_empty(), "{rest}");
        if !closed {
            open.push(name.to_owned());
        }
        tags.push((name.to_owned(), attributes));
    }
    assert!(open.is_empty());
    tags
}

/// No OP reaches the VP without a step in between: no importer sees an algebraic loop.
#[test]
fn the_valve_position_depends_on_no_input() {
    for entry in models() {
        let fmu = Fmu::new(entry.model, entry.law).unwrap();
        let vp = fmu.variables().iter().position(|v| v.name == "VP").unwrap();
        let (two, three) = (fmu.xml(Fmi::V2, None), fmu.xml(Fmi::V3, None));
        let outputs = two.split("<Outputs>").nth(1).and_then(|xml| xml.split("</Outputs>").next());
        let known = match fmu.variables().iter().position(|v| v.name == "position") {
            Some(position) if fmu.is_continuous() => (position + 1).to_string(),
            _ => String::new(),
        };
        let expected = format!("<Unknown index=\"{}\" dependencies=\"{known}\"/>", vp + 1);
        assert!(outputs.unwrap().contains(&expected), "{} {}", entry.model, entry.law);
        // By value reference, which is one less.
        let known = known.parse::<usize>().map_or(String::new(), |index| (index - 1).to_string());
        let expected = format!("<Output valueReference=\"{vp}\" dependencies=\"{known}\"/>");
        assert!(three.contains(&expected), "{} {}", entry.model, entry.law);
        // At the start everything may depend on anything.
        assert!(!two.split("<InitialUnknowns>").nth(1).unwrap().contains("dependencies"));
    }
}

#[test]
fn descriptions_are_well_formed_and_say_what_the_table_says() {
    for entry in models() {
        let fmu = Fmu::new(entry.model, entry.law).unwrap();
        fmu.check().unwrap();
        for version in [Fmi::V2, Fmi::V3] {
            let tags = tags(&fmu.xml(version, None));
            let of = |name: &'static str| tags.iter().filter(move |(tag, _)| tag == name);
            let get = |attributes: &[(String, String)], key: &str| {
                attributes.iter().find(|(k, _)| k == key).map(|(_, value)| value.clone())
            };
            let token = if version == Fmi::V2 { "guid" } else { "instantiationToken" };
            assert_eq!(get(&tags[0].1, token), Some(fmu.token()));
            let units: BTreeSet<_> = of("Unit").map(|(_, a)| get(a, "name").unwrap()).collect();
            // In FMI 2.0 the unit of a declared type is in a tag of its own, which follows.
            let types: BTreeMap<_, _> = (0..tags.len())
                .filter(|i| ["SimpleType", "Float64Type"].contains(&&*tags[*i].0))
                .map(|i| {
                    let unit = &tags[if version == Fmi::V2 { i + 1 } else { i }].1;
                    (get(&tags[i].1, "name").unwrap(), get(unit, "unit").unwrap())
                })
                .collect();
            assert_eq!(types.len(), units.len());

            // In FMI 2.0 type and start are in a tag of their own, which follows.
            let typed = |i: usize| match version {
                Fmi::V2 => tags[i + 1].clone(),
                Fmi::V3 => tags[i].clone(),
            };
            let variables: Vec<usize> =
                (0..tags.len()).filter(|i| get(&tags[*i].1, "causality").is_some()).collect();
            assert_eq!(variables.len(), fmu.variables().len());
            for ((r, v), i) in fmu.variables().iter().enumerate().zip(variables) {
                let attributes = &tags[i].1;
                assert_eq!(get(attributes, "name").as_deref(), Some(v.name));
                assert_eq!(get(attributes, "valueReference"), Some(r.to_string()));
                let (kind, attributes) = typed(i);
                let expected = match (v.kind, version) {
                    (VariableKind::Float64, Fmi::V2) => "Real",
                    (VariableKind::Float64, Fmi::V3) => "Float64",
                    (VariableKind::Int32, Fmi::V2) => "Integer",
                    (VariableKind::Int32, Fmi::V3) => "Int32",
                    (VariableKind::Boolean, _) => "Boolean",
                };
                assert_eq!(kind, expected);
                let start = get(&attributes, "start").map(|start| match start.as_str() {
                    "true" => 1.0,
                    "false" => 0.0,
                    number => number.parse().unwrap(),
                });
                assert_eq!(start, v.start, "{}", v.name);
                let declared = get(&attributes, "declaredType");
                let unit = declared.map(|name| types[&name].clone()).unwrap_or_default();
                assert_eq!(unit, v.unit);
                if version == Fmi::V2 {
                    assert_eq!(get(&attributes, "unit").unwrap_or_default(), v.unit);
                }
                assert!(unit.is_empty() || units.contains(&unit), "{unit} is defined");
                assert!(!v.description.is_empty());
                if version == Fmi::V3 && fmu.is_continuous() {
                    let of = get(&attributes, "derivative").map(|of| of.parse().unwrap());
                    assert_eq!(of, v.rate_of, "{}", v.name);
                }
            }
            let outputs = fmu.variables().iter().filter(|v| v.causality == Causality::Output);
            if version == Fmi::V3 {
                assert_eq!(of("Output").count(), outputs.count());
                let indicators = fmu.variables().iter().filter(|v| v.indicates).count();
                assert_eq!(of("EventIndicator").count(), indicators);
            }
        }
    }
}

/// Importers that know a library by its name alone must not take one model for another.
#[test]
fn libraries_have_the_names_of_their_models() {
    let mut names = BTreeMap::new();
    for entry in models() {
        let fmu = Fmu::new(entry.model, entry.law).unwrap();
        let name = fmu.identifier();
        assert!(name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'), "{name}");
        // Parameter sets with a law in common have the library in common.
        assert_eq!(*names.entry(name.clone()).or_insert_with(|| fmu.token()), fmu.token());
        for version in [Fmi::V2, Fmi::V3] {
            let path = fmu.binary(version, "x86_64", "windows").unwrap();
            assert!(path.ends_with(&format!("/{name}.dll")), "{path}");
            let xml = fmu.xml(version, Some(86_400));
            assert!(xml.contains(&format!("modelIdentifier=\"{name}\"")));
            assert!(xml.contains("generationDateAndTime=\"1970-01-02T00:00:00Z\""));
            assert!(!fmu.xml(version, None).contains("generationDate"));
        }
    }
    let tokens: BTreeSet<_> = names.values().collect();
    assert_eq!(tokens.len(), names.len());
}

/// A model that is exported without any setting can be simulated: it starts at rest, and the supply opens it fully.
#[test]
fn defaults_rest_and_are_supplied() {
    for entry in models().into_iter().filter(|entry| entry.model != "loop") {
        let fmu = Fmu::new(entry.model, entry.law).unwrap();
        let vp = &fmu.follow(0.1, &[50.0; 200], &["VP"]).unwrap()[0];
        let far = vp.iter().map(|vp| (vp - 50.0).abs()).fold(0.0, f64::max);
        // Bristles yield by micrometres.
        assert!(far < 0.5, "{} {}: {far}", entry.model, entry.law);
        let start = |fmu: &Fmu, name: &str| {
            fmu.variables().iter().find(|v| v.name == name).and_then(|v| v.start).unwrap()
        };
        if entry.model == "stem" {
            let most = start(&fmu, "pressure_max_pa");
            assert!(start(&fmu, "supply") > most && start(&fmu, "supply") < 1.2 * most);
            let wider = fmu.clone().with("pressure_max_pa", 2.0 * most).unwrap();
            assert_eq!(start(&wider, "supply"), 2.0 * start(&fmu, "supply"));
            let poor = fmu.with("supply", most).unwrap().with("pressure_max_pa", 3.0 * most);
            assert_eq!(start(&poor.unwrap(), "supply"), most);
        }
    }
}

#[test]
fn names_are_unique_and_parameters_survive_their_file() {
    for entry in models() {
        let fmu = Fmu::new(entry.model, entry.law).unwrap();
        let names: BTreeSet<_> = fmu.variables().iter().map(|v| v.name).collect();
        assert_eq!(names.len(), fmu.variables().len());
        let other = fmu.settings().map(|v| v.name).fold(fmu.clone(), |fmu, name| {
            match fmu.variables().iter().find(|v| v.name == name).unwrap().kind {
                VariableKind::Float64 => fmu.with(name, 1.0 / 3.0).unwrap(),
                _ => fmu.with(name, 1.0).unwrap(),
            }
        });
        assert_eq!(Fmu::from_json(&fmu.json()).unwrap().json(), fmu.json());
        assert_eq!(Fmu::from_json(&other.json()).unwrap(), other);
        if entry.model != "stem" {
            // The lag of a stem adds a state; nothing else changes the token.
            assert_eq!(other.token(), fmu.token());
        }
    }
    let tokens: BTreeSet<_> = ["two-phase", "kano", "he"]
        .into_iter()
        .flat_map(|law| ["valve", "loop"].map(|model| Fmu::new(model, law).unwrap().token()))
        .collect();
    assert_eq!(tokens.len(), 6);
}

#[test]
fn what_is_unknown_is_answered_with_what_is_known() {
    let says = |found: Result<Fmu, String>, part: &str| {
        let why = found.unwrap_err();
        assert!(why.contains(part), "{why}");
    };
    says(Fmu::new("pump", "x"), "known are valve, stem, loop");
    says(Fmu::new("valve", "x"), "known are two-phase, choudhury");
    says(Fmu::new("stem", "x"), "known are classical, karnopp, dahl, lugre, gms, armstrong, cts");
    let valve = Fmu::new("valve", "kano").unwrap();
    says(valve.clone().with("s", 1.0), "known are OP, S, J, K");
    says(valve.clone().with("S", f64::NAN), "S is NaN, but must be a finite number");
    says(valve.with("limited", 0.5), "must be 1 (true) or 0 (false)");
}
