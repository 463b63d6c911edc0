//! The course: its tasks, checked with right and wrong answers, and the table of a class.

use super::{Open, open};
use serde_json::{Value, json};
use std::path::Path;
use stiction_diagnose::diagnose::{DiagnoseOptions, diagnose};
use stiction_diagnose::recording::Recording;
use stiction_lab::Options;

fn lesson(lab: &Open, lesson: u32, class: u32) -> Value {
    lab.good("course/lesson", &json!({ "lesson": lesson, "class": class }))
}

/// The right answers to the questions of each lesson; of numbers with the accepted difference.
fn truth(lab: &Open, class: u32) -> Vec<Vec<(f64, Option<f64>)>> {
    let answers = lab.good("course/answers", &json!({ "class": class }));
    let of = |(k, each): (usize, &Value)| {
        let questions = lesson(lab, k as u32 + 1, class)["questions"].clone();
        let answer = |(answer, question): (&Value, &Value)| {
            let answer = answer.as_str().unwrap();
            let choices = question["choices"].as_array().unwrap();
            match choices.iter().position(|choice| choice == answer) {
                Some(choice) => (choice as f64, None),
                None => {
                    let (value, most) = answer.split_once(" (± ").unwrap();
                    let (value, unit) = value.split_once(' ').unwrap();
                    assert_eq!(question["unit"], unit);
                    let most = most.strip_suffix(')').unwrap().parse().unwrap();
                    (value.parse().unwrap(), Some(most))
                }
            }
        };
        let each = each["answers"].as_array().unwrap();
        each.iter().zip(questions.as_array().unwrap()).map(answer).collect()
    };
    answers.as_array().unwrap().iter().enumerate().map(of).collect()
}

fn check(lab: &Open, lesson: usize, class: u32, answers: &[Option<f64>]) -> (Vec<bool>, String) {
    let asked = json!({ "lesson": lesson, "class": class, "name": " Ada  Lovelace", "tries": 2, "answers": answers });
    let checked = lab.good("course/check", &asked);
    let right = checked["right"].as_array().unwrap().iter().map(|each| each == true).collect();
    (right, checked["line"].as_str().unwrap().to_owned())
}

#[test]
fn right_answers_are_accepted_and_wrong_ones_refused_in_every_lesson() {
    let lab = open(&Options::new("test"));
    for class in [1, 2, 77, 9999] {
        for (k, truth) in truth(&lab, class).iter().enumerate() {
            let shown = lesson(&lab, k as u32 + 1, class);
            let questions = shown["questions"].as_array().unwrap();
            assert!((3..=5).contains(&questions.len()) && questions.len() == truth.len());
            for question in questions {
                let numbers = question["choices"].as_array().unwrap().is_empty();
                assert!(numbers != question["unit"].as_str().unwrap().is_empty(), "{question}");
                assert!(question["ask"].as_str().unwrap().len() > 5, "{question}");
            }
            // Neither the page of a lesson nor a check shows the truth.
            let html = shown["html"].as_str().unwrap();
            assert!(html.starts_with("<h1>Lesson") && !html.contains("href"), "{html}");
            let all: Vec<Option<f64>> = truth.iter().map(|(value, _)| Some(*value)).collect();
            let (right, line) = check(&lab, k + 1, class, &all);
            assert!(right.iter().all(|right| *right), "{class} {k}: {right:?} {truth:?}");
            let table = lab.good("course/read", &json!({ "lines": line }));
            let row = &table["rows"][0];
            assert_eq!((&row["student"], &row["lesson"]), (&json!("Ada Lovelace"), &json!(k + 1)));
            assert_eq!((&row["class"], &row["tries"]), (&json!(class), &json!(2)));
            assert_eq!(row["right"], json!(right));
            for (q, (value, most)) in truth.iter().enumerate() {
                let of = |answer: Option<f64>| {
                    let mut answers = all.clone();
                    answers[q] = answer;
                    let (right, line) = check(&lab, k + 1, class, &answers);
                    let others = right.iter().enumerate().filter(|(other, _)| *other != q);
                    assert!(others.into_iter().all(|(_, right)| *right));
                    let table = lab.good("course/read", &json!({ "lines": line }));
                    assert_eq!(table["rows"][0]["right"], json!(right), "{line}");
                    right[q]
                };
                assert!(!of(None), "{class} {k} {q}");
                match most {
                    Some(most) => {
                        // The list of answers is rounded.
                        let (inside, outside) = (most - 0.01, most + 0.02);
                        assert!(of(Some(value + inside)) && of(Some(value - inside)), "{k} {q}");
                        assert!(
                            !of(Some(value + outside)) && !of(Some(value - outside)),
                            "{k} {q}"
                        );
                        assert!(!of(Some(f64::MAX)));
                    }
                    None => {
                        let choices = questions[q]["choices"].as_array().unwrap().len();
                        let right = (0..choices).filter(|choice| of(Some(*choice as f64)));
                        assert_eq!(right.collect::<Vec<_>>(), [*value as usize], "{k} {q}");
                    }
                }
            }
        }
    }
}

/// A signal of a loop of a lesson.
fn signal(shown: &Value, of: usize, name: &str) -> Vec<f64> {
    let signals = shown["trends"][of]["signals"].as_array().unwrap();
    let found = signals.iter().find(|each| each["name"] == name).unwrap();
    found["values"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn span(of: &[f64]) -> f64 {
    of.iter().copied().fold(f64::MIN, f64::max) - of.iter().copied().fold(f64::MAX, f64::min)
}

#[test]
fn what_a_student_measures_in_the_trends_is_accepted() {
    let lab = open(&Options::new("test"));
    for class in 1..=60 {
        let truth = truth(&lab, class);
        // The valve: from the last peak of the OP to the first movement of the VP.
        let shown = lesson(&lab, 1, class);
        let (op, vp) = (signal(&shown, 0, "OP"), signal(&shown, 0, "VP"));
        let peak = (1..op.len()).find(|k| op[*k] < op[k - 1] && op[*k] > 52.0).unwrap();
        let moves = (peak + 1..op.len()).find(|k| vp[*k] != vp[k - 1]).unwrap();
        let later = moves + 100;
        let measured = [op[peak - 1] - op[moves], vp[moves - 1] - vp[moves], vp[later] - op[later]];
        let (right, _) = check(&lab, 1, class, &measured.map(Some));
        assert_eq!(right, [true; 3], "{class}: {measured:?} {:?}", truth[0]);
        // The cycle: upward crossings of the middle of the OP, and the spans.
        let shown = lesson(&lab, 2, class);
        let (op, pv) = (signal(&shown, 0, "OP"), signal(&shown, 0, "PV"));
        let middle = op.iter().sum::<f64>() / op.len() as f64;
        // Noise makes no crossing of its own.
        let (mut below, mut crossings) = (false, Vec::<usize>::new());
        for (k, op) in op.iter().enumerate() {
            if below && *op > middle + 0.5 {
                crossings.push(k);
            }
            below = if (op - middle).abs() > 0.5 { *op < middle } else { below };
        }
        let cycles = crossings.len() - 1;
        let period = 0.2 * (crossings[cycles] - crossings[0]) as f64 / cycles as f64;
        let measured = [period, span(&pv), span(&op), 0.0];
        let (right, _) = check(&lab, 2, class, &measured.map(Some));
        assert_eq!(right, [true; 4], "{class}: {measured:?} {:?}", truth[1]);
        // Only these signals are sent: the valve position would show the answer.
        assert_eq!(shown["trends"][0]["signals"].as_array().unwrap().len(), 3);
    }
}

#[test]
fn the_stem_jumps_just_before_the_op_turns() {
    let lab = open(&Options::new("test"));
    let knobs = json!({ "loop": { "scenario": "lab/flow", "set": ["noise.sd=0"] } });
    let id = lab.good("live/begin", &knobs)["id"].clone();
    // At rest the loop does not cycle, so the stem begins J/2 off.
    let manual = json!({ "loop": knobs["loop"], "manual": 52.5 });
    lab.good("live/go", &json!({ "id": id, "from": 0, "samples": 100, "knobs": manual }));
    let go = json!({ "id": id, "from": 100, "samples": 5000, "knobs": knobs });
    let done = lab.good("live/go", &go);
    let of = |name: &str| -> Vec<f64> {
        done[name].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let (op, vp) = (of("op"), of("vp"));
    let slips = (2500..4500).filter(|k| (vp[*k] - vp[k - 1]).abs() > 1.0).collect::<Vec<_>>();
    assert!(slips.len() > 10);
    for k in slips {
        let before = op[k] - op[k - 1];
        let turns = (k..).find(|k| (op[k + 1] - op[*k]) * before < 0.0).unwrap();
        // 2 s of a cycle of 55 s.
        assert!(0.2 * (turns - k) as f64 <= 2.0, "{k} {turns}");
    }
}

/// The exact cycle of the loop that a lesson opens, with other settings.
fn exact(lab: &Open, room: &str, changes: &[String]) -> Option<Value> {
    let (scenario, set) = room.strip_prefix("loop?scenario=").unwrap().split_once("&set=").unwrap();
    let set: Vec<String> =
        set.split("&set=").map(str::to_owned).chain(changes.iter().cloned()).collect();
    let found = lab.good("cycle", &json!({ "scenario": scenario, "set": set }));
    let exact = found["cycles"].as_array().unwrap().iter().find(|each| each["method"] == "exact");
    exact.cloned()
}

#[test]
fn what_a_student_reads_in_the_rooms_is_accepted() {
    let lab = open(&Options::new("test"));
    for class in [1, 5, 400] {
        let truth = truth(&lab, class);
        let room = lesson(&lab, 3, class)["room"].as_str().unwrap().to_owned();
        let number = |key: &str| -> f64 {
            let (_, rest) = room.split_once(&format!("{key}=")).unwrap();
            rest.split('&').next().unwrap().parse().unwrap()
        };
        let twice = ["valve.S", "valve.J"].map(|key| format!("{key}={}", 2.0 * number(key)));
        let at = |changes: &[String]| exact(&lab, &room, changes);
        let period = |of: Option<Value>| of.unwrap()["period_s"].as_f64();
        let swing = |of: Option<Value>| of.unwrap()["half_pp"]["pv"].as_f64();
        let settles = at(&["valve.J=0".to_owned()]).is_none();
        let slower = period(at(&["controller.kc=0.25".to_owned()]));
        let read = [period(at(&[])), swing(at(&twice)), slower, Some(f64::from(u8::from(settles)))];
        assert_eq!(check(&lab, 3, class, &read).0, [true; 4], "{class}: {read:?} {:?}", truth[2]);
        // A cycle of twice the size has twice the swing, at the same period.
        assert!((swing(at(&twice)).unwrap() / swing(at(&[])).unwrap() - 2.0).abs() < 1e-6);

        let room = lesson(&lab, 6, class)["room"].as_str().unwrap().to_owned();
        let tuned = |kc: f64, ti: f64| {
            exact(&lab, &room, &[format!("controller.kc={kc}"), format!("controller.ti={ti}")])
        };
        let ti = truth[5][0].0;
        let half = swing(tuned(0.9, 0.3)).unwrap() / 2.0;
        assert!(swing(tuned(0.9, 1.02 * ti)).unwrap() < half, "{class}: {ti}");
        assert!(swing(tuned(0.9, ti / 1.02)).unwrap() > half, "{class}: {ti}");
        let read = [Some(ti), swing(tuned(0.1, 30.0)), Some(1.0), Some(2.0)];
        assert_eq!(check(&lab, 6, class, &read).0, [true; 4], "{class}: {read:?} {:?}", truth[5]);
        // The sliders of Kc and Ti reach from a tenth to ten times the values of the flow loop.
        for kc in [0.05, 0.2, 0.5, 0.9] {
            for ti in [1.0, 3.0, 10.0, 30.0] {
                assert!(tuned(kc, ti).is_some(), "{class}: no cycle at {kc}, {ti}");
            }
        }
    }
}

#[test]
fn each_class_has_four_causes_with_a_sticking_valve_among_them_and_a_valve_to_test() {
    let lab = open(&Options::new("test"));
    let mut places = std::collections::BTreeSet::new();
    for class in 1..=8 {
        let truth = truth(&lab, class);
        let causes: Vec<usize> = truth[3].iter().map(|(cause, _)| *cause as usize).collect();
        let different: std::collections::BTreeSet<&usize> = causes.iter().collect();
        assert!(different.len() == 4 && causes.contains(&0), "{causes:?}");
        // The diagnosis of what is shown agrees.
        let shown = lesson(&lab, 4, class);
        for (k, cause) in causes.iter().enumerate() {
            let (op, pv, sp) =
                (signal(&shown, k, "OP"), signal(&shown, k, "PV"), signal(&shown, k, "SP"));
            let time = &shown["trends"][k]["signals"][0]["time"];
            let step = time[1].as_f64().unwrap() - time[0].as_f64().unwrap();
            let recording = Recording::regular("A", step, &op, Some(&pv), Some(&sp)).unwrap();
            let class_of = diagnose(&recording, &DiagnoseOptions::default()).unwrap().verdict.class;
            let class_of = class_of.to_string();
            assert_eq!(class_of == "sticks", *cause == 0, "{class} {k} {cause}: {class_of}");
        }
        places.insert(causes.iter().position(|cause| *cause == 0));
        // The test of the lab finds what the check accepts.
        let valve =
            lab.good("exercise/reveal", &json!({ "seed": class, "sets": [], "until_s": 0.0 }));
        assert_eq!(lesson(&lab, 5, class)["room"], format!("exercise?seed={class}"));
        let sticks = valve["sticks"] == true;
        let s = if sticks { valve["S"].as_f64() } else { Some(0.0) };
        let read = [Some(f64::from(u8::from(!sticks))), s, Some(1.0)];
        assert_eq!(check(&lab, 5, class, &read).0, [true; 3], "{class}: {valve}");
    }
    assert!(places.len() > 2, "{places:?}");
}

#[test]
fn a_class_has_the_same_task_each_time_and_another_class_another() {
    let lab = open(&Options::new("test"));
    for k in 1..=6 {
        assert_eq!(lesson(&lab, k, 3).to_string(), lesson(&lab, k, 3).to_string());
        assert_ne!(lesson(&lab, k, 3), lesson(&lab, k, 4), "{k}");
    }
}

#[test]
fn the_table_of_a_class_refuses_typos_by_their_line() {
    let lab = open(&Options::new("test"));
    let line = |name: &str, lesson: usize, answers: &[Option<f64>]| {
        let asked =
            json!({ "lesson": lesson, "class": 12, "name": name, "tries": 1, "answers": answers });
        lab.good("course/check", &asked)["line"].as_str().unwrap().to_owned()
    };
    let zoe = line("Zoë Müller-Lüdenscheidt", 4, &[Some(0.0); 4]);
    let ben = line("ben", 6, &[None; 4]);
    let ben_first = line("Ben", 1, &[None; 3]);
    let lines = [
        zoe.clone(),
        String::new(),
        ben.to_lowercase().replace(',', "\t").replace('-', ""),
        zoe.replace("Müller", "Muller"),
        ben.replace("ben", ""),
        "ben".to_owned(),
        format!("  {ben_first} ;"),
        "=HYPERLINK(1), 00000-00000".to_owned(),
    ];
    let table = lab.good("course/read", &json!({ "lines": lines.join("\r\n") }));
    let rows: Vec<(&str, u64, usize)> = table["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| {
            let right = row["right"].as_array().unwrap().iter().filter(|each| **each == true);
            (row["student"].as_str().unwrap(), row["lesson"].as_u64().unwrap(), right.count())
        })
        .collect();
    assert_eq!(rows, [("Ben", 1, 0), ("ben", 6, 0), ("Zoë Müller-Lüdenscheidt", 4, 1)]);
    let refused: Vec<u64> = table["refused"]
        .as_array()
        .unwrap()
        .iter()
        .map(|each| each["line"].as_u64().unwrap())
        .collect();
    assert_eq!(refused, [4, 5, 6, 8], "{table}");
}

#[test]
fn what_cannot_be_is_refused_in_a_sentence() {
    let lab = open(&Options::new("test"));
    let answered = |lesson: u32, class: u32, name: &str, count: usize| json!({ "lesson": lesson, "class": class, "name": name, "tries": 1, "answers": vec![1.0; count] });
    let long = "x".repeat(100_001);
    for (name, asked, status, word) in [
        ("course/lesson", json!({ "lesson": 0, "class": 1 }), 404, "1 to 6"),
        ("course/lesson", json!({ "lesson": 7, "class": 1 }), 404, "1 to 6"),
        ("course/lesson", json!({ "lesson": 1, "class": 0 }), 400, "from 1 to 9999"),
        ("course/answers", json!({ "class": 10_000 }), 400, "from 1 to 9999"),
        ("course/check", answered(1, 10_000, "A", 3), 400, "from 1 to 9999"),
        ("course/check", answered(1, 1, " \t", 3), 400, "enter a name"),
        ("course/check", answered(1, 1, &"x".repeat(81), 3), 400, "enter a name"),
        ("course/check", answered(1, 1, "A", 2), 400, "3 questions, and 2 answers"),
        ("course/check", answered(9, 1, "A", 2), 404, "1 to 6"),
        ("course/read", json!({ "lines": long }), 400, "more than 100000"),
    ] {
        let (got, said) = lab.call(name, &asked);
        assert_eq!(got, status, "{name} {asked}: {said}");
        assert!(said["error"].as_str().unwrap().contains(word), "{word}: {said}");
    }
}

#[test]
fn the_answers_in_the_documents_are_those_of_the_first_class() {
    let lab = open(&Options::new("test"));
    let answers = lab.good("course/answers", &json!({ "class": 1 }));
    let mut list = String::from("\n");
    for (k, each) in answers.as_array().unwrap().iter().enumerate() {
        list += &format!("**{}. {}**\n\n", k + 1, each["title"].as_str().unwrap());
        for (k, answer) in each["answers"].as_array().unwrap().iter().enumerate() {
            list += &format!("{}. {}\n", k + 1, answer.as_str().unwrap());
        }
        list += "\n";
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/course/answers.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (head, rest) = page.split_once("<!-- answers -->\n").unwrap();
    let (_, tail) = rest.split_once("<!-- end -->").unwrap();
    let now = format!("{head}<!-- answers -->\n{list}<!-- end -->{tail}");
    if std::env::var_os("STICTION_WRITE").is_some() {
        std::fs::write(&path, &now).unwrap();
    }
    let page = std::fs::read_to_string(&path).unwrap();
    assert!(page == now, "docs/course/answers.md is out of date; write it with STICTION_WRITE=1");
}
