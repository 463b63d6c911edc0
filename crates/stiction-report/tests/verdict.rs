//! How verdicts of every class and basis are told, with values made by hand.

use crate::html;

use html::well_formed;
use stiction_diagnose::diagnose::change::{Change, Event};
use stiction_diagnose::diagnose::{
    Alternative, Basis, Cause, Definition, DiagnoseOptions, Diagnosis, Estimate, FewSlips, Grade,
    Limit, Observation, Override, Stiction, Verdict, VerdictClass, Votes, Window, combine,
    diagnose, repair,
};
use stiction_diagnose::recording::PlantTime;
use stiction_diagnose::recording::Recording;
use stiction_diagnose::recording::fitness::Class;
use stiction_report::document::{Document, Loop, Point, Source, Valve, ValveHistory};
use stiction_report::report;
use stiction_report::words;

fn swinging() -> Diagnosis {
    let op: Vec<f64> = (0..1200).map(|k| 50.0 + 2.0 * (f64::from(k) * 0.1).sin()).collect();
    let pv: Vec<f64> = (0..1200).map(|k| 50.0 + (f64::from(k) * 0.1 - 0.8).sin()).collect();
    let mut recording =
        Recording::regular("FIC101", 1.0, &op, Some(&pv), Some(&[50.0; 1200])).unwrap();
    recording.start = Some(1.7e9);
    diagnose(&recording, &DiagnoseOptions::default()).unwrap()
}

fn verdict(class: VerdictClass, basis: Basis, probability: Option<f64>) -> Verdict {
    Verdict {
        class,
        basis,
        probability,
        votes: Votes { sticks: 3, does_not_stick: 1, undecided: 1, abstains: 1 },
        reasons: vec!["the PV has corners where the OP is a triangle".to_owned()],
        ..Verdict::default()
    }
}

fn estimate(value: f64, low: f64, high: f64) -> Option<Estimate> {
    Some(Estimate { value, low, high })
}

/// A diagnosis with everything that a trained model can say.
fn full() -> Diagnosis {
    let mut diagnosis = swinging();
    diagnosis.pv_unit = Some("m3/h".to_owned());
    diagnosis.verdict = Verdict {
        contradictions: vec!["the period is that of LIC104".to_owned()],
        alternatives: vec![
            Alternative {
                cause: Cause::ExternalOscillation,
                likelihood: 0.05,
                because: "no other loop of this period is known; look upstream".to_owned(),
            },
            Alternative {
                cause: Cause::AggressiveTuning,
                likelihood: 0.02,
                because: "the wave is no sine; halve the gain and see whether the period changes"
                    .to_owned(),
            },
        ],
        confirm: diagnosis.verdict.confirm,
        ..verdict(VerdictClass::Sticks, Basis::Evidence, Some(0.931))
    };
    diagnosis.stiction = Stiction {
        model: Some("the two-phase model".to_owned()),
        s: estimate(4.12, 3.41, 4.92),
        j: estimate(2.04, 1.2, 2.8),
        coverage: Some(0.9),
        why_not: None,
        definitions: vec![
            Definition {
                name: "apparent stiction",
                value: Some(3.6),
                unit: "% of span",
                meaning: "the width of the ellipse of PV over OP",
            },
            Definition { name: "ISA dead band", value: None, unit: "%", meaning: "needs a test" },
        ],
    };
    diagnosis.windows = (0..6)
        .map(|k| Window {
            from: 200.0 * f64::from(k),
            duration: 200.0,
            probability: 0.8 + 0.03 * f64::from(k),
            s: (k != 2).then_some(Estimate {
                value: 4.0 + 0.1 * f64::from(k),
                low: 3.0,
                high: 5.5,
            }),
            j: None,
            limit: (k != 3).then_some(1.2),
        })
        .collect();
    diagnosis
}

fn source() -> Source {
    Source { file: "FIC101.csv".to_owned(), sha256: "00ff".to_owned() }
}

fn person() -> Override {
    Override {
        verdict: VerdictClass::DoesNotStick,
        reason: "new packing, stroked by maintenance".to_owned(),
        by: Some("J. Miller".to_owned()),
        entered: Some("2026-03-02".to_owned()),
        scope: "this recording, FIC101.csv".to_owned(),
        kept_in: "stiction-overrides.toml".to_owned(),
    }
}

fn page(name: &str, html: &str) {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(folder.join(name), html).unwrap();
}

#[test]
fn every_class_and_basis_has_its_words() {
    let mut diagnosis = full();
    use Basis::{Evidence, OpAlone, ValvePosition};
    use VerdictClass::{CannotTell, DoesNotRespond, DoesNotStick, Sticks};
    let band = "After a reversal the stem stands still until the OP has travelled about 4.1 % (3.4 to 4.9), then jumps by about 2 %.";
    for (class, basis, p, expected) in [
        (Sticks, Evidence, Some(0.931), format!("The valve most likely sticks (93 %). {band}")),
        (
            Sticks,
            ValvePosition,
            None,
            format!("The measured position shows that the valve sticks. {band}"),
        ),
        (
            DoesNotStick,
            ValvePosition,
            None,
            "The measured position shows that the valve follows the controller.".into(),
        ),
        (
            DoesNotStick,
            Evidence,
            Some(0.04),
            "The valve most likely does not stick (probability of sticking 4 %).".into(),
        ),
        (DoesNotRespond, Evidence, Some(0.2), "The valve does not respond: ".into()),
        (CannotTell, OpAlone, Some(0.95), "The pattern of the OP leaves open".into()),
        (CannotTell, OpAlone, None, "The pattern of the OP".into()),
        (
            CannotTell,
            Evidence,
            Some(0.5),
            "Whether the valve sticks is unclear: the probability is 50 %; ".into(),
        ),
        (
            CannotTell,
            Basis::None,
            None,
            "Whether the valve sticks is unclear: the PV has corners".into(),
        ),
    ] {
        diagnosis.verdict = verdict(class, basis, p);
        let text = words::verdict(&diagnosis);
        assert!(text.starts_with(&expected), "{class:?} {basis:?}: {text}");
        let open = class == CannotTell || basis == OpAlone;
        assert_eq!(words::what_would_answer(&diagnosis).is_some(), open, "{class:?} {basis:?}");
        let source = source();
        let html = report::html("tool", &[Loop::new(&source, &diagnosis)]).unwrap();
        well_formed(&html);
    }
    diagnosis.verdict = full().verdict;
    diagnosis.verdict.class = DoesNotStick;
    let text = words::verdict(&diagnosis);
    assert!(text.ends_with("is an external oscillation."), "{text}");
}

#[test]
fn a_report_tells_all_that_a_model_can_say() {
    let mut diagnosis = full();
    diagnosis.verdict.overruled = Some(person());
    let source = source();
    let html = report::html("tool", &[Loop::new(&source, &diagnosis)]).unwrap();
    well_formed(&html);
    page("verdict.html", &html);
    let mut rest = html.as_str();
    for wanted in [
        "The valve most likely sticks (93 %)",
        "Overruled by J. Miller on 2026-03-02: the valve does not stick (new packing",
        "Evidence for sticking",
        "The PV has corners where the OP is a triangle.",
        "Evidence against sticking",
        "Other possible causes",
        "sticking valve",
        "external oscillation",
        "The test",
        "<ol>",
        "Put the controller in manual. Note the OP (u0) and the PV.",
        "The turns of part 1, relative to u0.",
        "Over time",
        "Numbers of all 6 windows",
        "Data quality",
        "S and J, also by other definitions",
        "The intervals have a nominal coverage of 90 %.",
        "apparent stiction",
    ] {
        let at =
            rest.find(wanted).unwrap_or_else(|| panic!("\"{wanted}\" is missing or misplaced"));
        rest = &rest[at..];
    }
    assert!(!html.contains("NaN") && !html.contains("reliminary"));
}

#[test]
fn the_document_carries_all_of_it() {
    let mut diagnosis = full();
    diagnosis.verdict.overruled = Some(person());
    let source = source();
    let document = Document::new("t", vec![Loop::new(&source, &diagnosis)]);
    let json: serde_json::Value = serde_json::from_str(&document.json()).unwrap();
    let found = &json["loops"][0];
    assert_eq!(found["verdict"]["class"], "sticks", "the computed verdict is not replaced");
    assert_eq!(found["verdict"]["override"]["verdict"], "does not stick");
    assert_eq!(found["verdict"]["alternatives"][0]["cause"], "external oscillation");
    assert_eq!(found["verdict"]["confirm"]["each"], 2);
    assert_eq!(found["verdict"]["contradictions"][0], "the period is that of LIC104");
    assert_eq!(found["stiction"]["S"]["low"], 3.41);
    assert_eq!(found["stiction"]["coverage"], 0.9);
    assert_eq!(found["stiction"]["definitions"][1]["value"], serde_json::Value::Null);
    assert_eq!(found["windows"].as_array().unwrap().len(), 6);
    assert_eq!(found["windows"][2]["S"], serde_json::Value::Null);
    assert_eq!(found["windows"][2]["S_below"]["value"], 1.2);
    assert_eq!(found["windows"][3]["S_below"], serde_json::Value::Null);
}

#[test]
fn mistaken_columns_are_named_with_what_to_do() {
    let op: Vec<f64> = (0..1200).map(|k| 50.0 + 2.0 * (f64::from(k) * 0.1).sin()).collect();
    let recording = Recording::regular("FIC101", 1.0, &op, Some(&op), None).unwrap();
    let diagnosis = diagnose(&recording, &DiagnoseOptions::default()).unwrap();
    let mistaken = diagnosis.mistaken().expect("a copy is no PV");
    let text = words::verdict(&diagnosis);
    assert!(text.contains("are probably wrong") && text.contains(mistaken.name()), "{text}");
    let advice = words::what_would_answer(&diagnosis).unwrap();
    assert!(advice.contains("export") && !advice.contains("ten cycles"), "{advice}");
    let json = serde_json::to_value(&diagnosis).unwrap();
    assert_eq!(json["relation"]["mismatch"], mistaken.name());
    assert_eq!(json["relation"]["remedy"], mistaken.remedy());
    assert!(!json["relation"]["because"].as_str().unwrap().is_empty());
    // Where nothing is wrong, nothing is told.
    let json = serde_json::to_value(swinging()).unwrap();
    assert!(json["relation"].is_null() && json["no_response"].is_null(), "{json}");
}

#[test]
fn what_does_not_respond_has_its_faults() {
    let op: Vec<f64> = (0..720).map(|k| 5.0 + 75.0 * f64::from(k) / 719.0).collect();
    let recording =
        Recording::regular("FIC101", 10.0, &op, Some(&[0.0; 720]), Some(&[40.0; 720])).unwrap();
    let diagnosis = diagnose(&recording, &DiagnoseOptions::default()).unwrap();
    assert_eq!(diagnosis.verdict.class, VerdictClass::DoesNotRespond);
    let text = words::verdict(&diagnosis);
    assert!(text.contains("stays at its low end") && text.contains("line isolated"), "{text}");
    assert_eq!(words::what_would_answer(&diagnosis), None);
    let json = serde_json::to_value(&diagnosis).unwrap();
    let told = &json["no_response"];
    assert_eq!(told["silence"], "PV at its low end");
    assert_eq!((&told["decides"], &told["rest"]["error"]), (&true.into(), &40.0.into()));
    assert_eq!(told["rest"]["to_s"], 7200.0);
    assert_eq!(told["faults"].as_array().unwrap().len(), 4);
    let source = source();
    let html = report::html("tool", &[Loop::new(&source, &diagnosis)]).unwrap();
    well_formed(&html);
    for wanted in ["Possible faults", "air or signal lost", "measure air supply and current"] {
        assert!(html.contains(wanted), "{wanted}");
    }
}

#[test]
fn a_probability_that_decides_nothing_says_why() {
    let mut diagnosis = full();
    let why = "a valve that sticks predicts the PV better";
    for (p, wanted) in
        [(0.03, "is not cleared"), (0.96, "is not accused"), (0.5, "the probability is 50 %")]
    {
        diagnosis.verdict = verdict(VerdictClass::CannotTell, Basis::Evidence, Some(p));
        diagnosis.verdict.reasons.push(why.to_owned());
        let text = words::verdict(&diagnosis);
        assert!(text.contains(wanted) && text.contains(why), "{p}: {text}");
    }
}

#[test]
fn a_cleared_valve_has_its_limit() {
    let mut diagnosis = full();
    for basis in [Basis::Evidence, Basis::ValvePosition] {
        diagnosis.verdict = verdict(VerdictClass::DoesNotStick, basis, Some(0.03));
        let none = words::verdict(&diagnosis);
        assert!(none.contains("is unknown"), "{none}");
        diagnosis.verdict.s_below = Some(Limit { value: 0.81, confidence: 0.95 });
        let text = words::verdict(&diagnosis);
        assert!(text.contains("above 0.81 %") && text.contains("(95 % confidence)"), "{text}");
    }
}

#[test]
fn advice_fits_what_is_missing() {
    let mut diagnosis = full();
    diagnosis.verdict = verdict(VerdictClass::CannotTell, Basis::Evidence, Some(0.7));
    let advice = words::what_would_answer(&diagnosis).unwrap();
    // 19 cycles were seen.
    assert!(!advice.contains("ten cycles") && advice.contains("valve position"), "{advice}");
    diagnosis.few_slips = Some(FewSlips {
        seen: 2,
        needed: 8,
        step: 4.5,
        words: "looks stuck, with 2 slips of the 8 needed".to_owned(),
    });
    let advice = words::what_would_answer(&diagnosis).unwrap();
    assert!(
        advice.contains("test of the valve") && advice.contains("4.5 %, are seldom"),
        "{advice}"
    );
    let json = serde_json::to_value(&diagnosis).unwrap();
    assert_eq!((&json["few_slips"]["seen"], &json["few_slips"]["step"]), (&2.into(), &4.5.into()));
    // A position that was read is not asked for.
    diagnosis.verdict = verdict(VerdictClass::CannotTell, Basis::ValvePosition, None);
    diagnosis.verdict.reasons.push("a longer record would tell".to_owned());
    let advice = words::what_would_answer(&diagnosis).unwrap();
    assert_eq!(advice, "A longer record would tell.");
    let text = words::verdict(&diagnosis);
    assert!(
        text.ends_with(
            "measured position leaves open whether the valve sticks: the PV has corners where the OP is a triangle."
        ),
        "{text}"
    );
}

#[test]
fn too_little_data_has_a_remedy_of_its_own() {
    let of = |samples: usize, moves: f64, pv: bool| {
        let wave = |k: usize| moves * (k as f64 * 0.3).sin();
        let op: Vec<f64> = (0..samples).map(|k| 50.0 + wave(k)).collect();
        let flow: Vec<f64> = (0..samples).map(|k| 30.0 + (k as f64 * 0.3 - 0.8).sin()).collect();
        let recording =
            Recording::regular("FIC101", 1.0, &op, pv.then_some(&flow[..]), None).unwrap();
        let diagnosis = diagnose(&recording, &DiagnoseOptions::default()).unwrap();
        words::what_would_answer(&diagnosis)
    };
    assert_eq!(of(25, 2.0, true).unwrap(), "Record at least 200 samples.");
    assert_eq!(of(400, 0.0, true).unwrap(), "Choose another time, in which the OP moves.");
    let alone = of(400, 2.0, false).unwrap();
    assert!(alone.starts_with("A recording with the PV"), "{alone}");
    assert!(alone.ends_with(", or a recorded valve position, may decide."), "{alone}");
}

#[test]
fn the_windows_since_the_last_change_count() {
    let mut diagnosis = full();
    diagnosis.verdict = verdict(VerdictClass::CannotTell, Basis::Evidence, Some(0.5));
    let event =
        |change, time| Event { change, time, interval: (time - 60.0, time + 60.0), found: time };
    diagnosis.evidence.as_mut().unwrap().changes = vec![
        event(Change::Gone, 300.0),
        event(Change::Returned, 600.0),
        event(Change::Worse, 900.0),
    ];
    let text = words::verdict(&diagnosis);
    let (before, after) = text.split_once(" Only the windows since then count. ").unwrap();
    assert!(
        before.contains("ceased to stick") && before.contains("began to stick again"),
        "{text}"
    );
    assert!(after.starts_with("S grew") && !after.contains("since then"), "{text}");
    // A position does not use the windows.
    diagnosis.verdict = verdict(VerdictClass::CannotTell, Basis::ValvePosition, None);
    assert!(!words::verdict(&diagnosis).contains("since then"));
}

#[test]
fn a_history_is_drawn_with_its_repair() {
    const DAY: f64 = 86_400.0;
    let start = 1.7e9;
    let seen = |k: usize| {
        let bad = k < 12;
        let s = if bad { 3.0 * (0.03 * k as f64).exp() } else { 0.5 + 0.02 * (k % 3) as f64 };
        Observation {
            grade: None,
            time: start + k as f64 * DAY,
            class: VerdictClass::CannotTell,
            probability: Some(if bad {
                0.9 - 0.01 * (k % 4) as f64
            } else {
                0.1 + 0.01 * (k % 3) as f64
            }),
            s: estimate(s, 0.8 * s, 1.3 * s),
            j: None,
            weight: 1.0,
            windows: 1.0,
            pool: None,
        }
    };
    let all: Vec<Observation> = (0..24).map(seen).collect();
    let repaired = repair(&all, start + 11.5 * DAY).unwrap();
    let windows = all.iter().map(|o| Point {
        file: "FIC101.csv".to_owned(),
        from_s: o.time,
        duration_s: DAY,
        class: VerdictClass::Sticks,
        grade: Grade::Sticks,
        basis: Basis::Evidence,
        probability: o.probability,
        fitness: Class::Fit,
        s: o.s,
        j: None,
    });
    let valve = Valve {
        name: "FIC101".to_owned(),
        sources: vec![source()],
        dated: true,
        plant_time: PlantTime::default(),
        windows: windows.collect(),
        combined: combine(&all[12..]).unwrap(),
        repair: Some(repaired),
    };
    let mut history = ValveHistory::new("tool", vec![valve]);
    let html = report::history_html(&history).unwrap();
    well_formed(&html);
    page("history.html", &html);
    for wanted in [
        "History of FIC101",
        "the repair worked",
        "12 of 12 windows since the repair count, with",
        "repair</text>",
        "2023-11-14",
        "<svg",
    ] {
        assert!(html.contains(wanted), "{wanted}");
    }
    // Without numbers, and without dates.
    let valve = &mut history.valves[0];
    (valve.dated, valve.repair) = (false, None);
    for window in &mut valve.windows {
        (window.probability, window.s) = (None, None);
    }
    let html = report::history_html(&history).unwrap();
    well_formed(&html);
    assert!(html.contains("there is no figure") && !html.contains("<svg"));
}
