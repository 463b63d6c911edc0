//! What the report on diagnosed loops must have, and the figure of every method's evidence.

use crate::html;

use html::{data, well_formed};
use std::collections::BTreeSet;
use stiction_diagnose::diagnose::{DiagnoseOptions, Diagnosis, Grade, diagnose};
use stiction_diagnose::finding::Decision;
use stiction_diagnose::methods::{
    self, Detector, MethodId, Subject, damarla_regression::DamarlaRegression,
};
use stiction_diagnose::recording::{Channel, LoopType, Recording};
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Run, Signal};
use stiction_model::valve::{Assembly, Model};
use stiction_model::{Bands, Result};
use stiction_report::document::{Loop, Source};
use stiction_report::report::{self, Context, evidence};

const HOSTILE: &str = "</script><script>alert(1)</script> \"'&\u{0}<b>";

fn flow(samples: usize) -> Result<Run> {
    let mut flow = ClosedLoop::new(
        Controller::pi(1.1, 2.5)?,
        Assembly::new(Model::TwoPhase.build(Bands::from_s_j(5.0, 2.0)?)?),
        Process::first_order(1.5, 5.93, 1.07)?,
    );
    flow.sample_time = 0.5;
    flow.samples = samples;
    flow.set_point = 5.0.into();
    flow.measurement = vec![Signal::Noise { sd: 0.1, tau_s: 0.0, seed: 3 }];
    flow.run()
}

fn level(samples: usize) -> Result<Run> {
    let mut level = ClosedLoop::new(
        Controller::pi(0.4, 2.0)?,
        Assembly::new(Model::TwoPhase.build(Bands::from_s_j(5.0, 2.0)?)?),
        Process::integrator(1.0, 0.0)?,
    );
    level.sample_time = 0.1;
    level.samples = samples;
    level.set_point = 5.0.into();
    level.run()
}

/// What a plant would have recorded, on a scale on which OP has room.
fn recording(run: &Run, loop_type: LoopType) -> Recording {
    let op: Vec<f64> = run.op.iter().map(|v| v + 40.0).collect();
    let mut recording =
        Recording::regular("loop", run.sample_time, &op, Some(&run.pv), Some(&run.sp)).unwrap();
    let time = (0..run.vp.len()).map(|k| k as f64 * run.sample_time).collect();
    let vp = run.vp.iter().map(|v| v + 40.0).collect();
    recording.vp = Some(Channel::new("VP", time, vp).unwrap());
    recording.loop_type = loop_type;
    recording.start = Some(1.7e9);
    recording
}

fn diagnosed(run: &Run, loop_type: LoopType) -> Diagnosis {
    diagnose(&recording(run, loop_type), &DiagnoseOptions::default()).unwrap()
}

fn source(file: &str) -> Source {
    Source { file: file.to_owned(), sha256: "00ff".to_owned() }
}

/// The report on some loops that nobody overruled.
fn page(loops: &[(&Diagnosis, &Source)]) -> std::result::Result<String, stiction_report::Error> {
    let cases: Vec<Loop<'_>> =
        loops.iter().map(|(diagnosis, source)| Loop::new(source, diagnosis)).collect();
    report::html("stiction 9", &cases)
}

#[test]
fn every_method_has_a_figure_of_its_evidence() {
    let loops = [
        diagnosed(&flow(2_400).unwrap(), LoopType::Flow),
        diagnosed(&level(4_000).unwrap(), LoopType::Level),
    ];
    let mut missing: BTreeSet<&str> = MethodId::ALL.iter().map(|id| id.name()).collect();
    for diagnosis in &loops {
        let subject = diagnosis.subject().unwrap();
        let context = Context { start: diagnosis.start, ..Context::default() };
        for finding in &diagnosis.findings {
            let card = evidence::card(finding, Some(&subject), &context);
            assert_eq!(card.heading, finding.method.title);
            assert!(card.badge.is_some() && !card.sentence.is_empty());
            let Some(figure) = card.figure else { continue };
            assert_ne!(finding.decision, Decision::Abstains);
            assert!(!figure.caption.is_empty(), "{}", finding.method.name);
            for panel in &figure.panels {
                assert!(!panel.x_label.is_empty() && !panel.y_label.is_empty());
            }
            let live = figure.live("a").unwrap();
            assert!(live.data.len() < 80_000, "{}: {}", finding.method.name, live.data.len());
            missing.remove(finding.method.name);
        }
    }
    assert!(missing.is_empty(), "no figure for {missing:?}");
}

#[test]
fn short_and_odd_loops_are_drawn() {
    let run = flow(1_200).unwrap();
    for samples in [1, 2, 30, 60, 100, 1_200] {
        let mut part = run.clone();
        for signal in [&mut part.op, &mut part.pv, &mut part.sp, &mut part.vp] {
            signal.truncate(samples);
        }
        let Ok(diagnosis) =
            diagnose(&recording(&part, LoopType::Unknown), &DiagnoseOptions::default())
        else {
            continue;
        };
        for period in [None, Some(0.0), Some(2.5), Some(30.0), Some(1e9), Some(f64::NAN)] {
            let Some(segment) = diagnosis.segment() else { continue };
            let subject = Subject::new(segment, LoopType::Unknown, period);
            for start in [None, Some(1e300), Some(f64::NAN)] {
                let context = Context { start, period_s: period, ..Context::default() };
                for detector in methods::all() {
                    let (name, finding) = (detector.method().name, detector.judge(&subject));
                    if let Some(figure) = evidence::figure(&finding, &subject, &context) {
                        let live = figure.live("a").unwrap();
                        assert!(!live.svg.contains("NaN"), "{name}");
                    }
                }
            }
        }
        page(&[(&diagnosis, &source("a.csv"))]).unwrap();
    }
}

#[test]
fn a_figure_is_drawn_from_what_was_looked_at() {
    let recording = recording(&flow(2_400).unwrap(), LoopType::Flow);
    let of = |evidence| {
        diagnose(&recording, &DiagnoseOptions { evidence, ..DiagnoseOptions::default() }).unwrap()
    };
    let (kept, bare) = (of(true), of(false));
    assert!(kept.findings.iter().any(|finding| finding.looked_at.is_some()));
    assert!(bare.findings.iter().all(|finding| finding.looked_at.is_none()));
    let source = source("a.csv");
    assert!(page(&[(&kept, &source)]).unwrap() == page(&[(&bare, &source)]).unwrap());

    // With parameters of its own it is drawn by them, or not at all.
    let (subject, context) = (kept.subject().unwrap(), Context::default());
    let twice = DamarlaRegression { eta: 2.5, ..DamarlaRegression::default() };
    let mut finding = twice.judge(&subject);
    let figure = evidence::figure(&finding, &subject, &context).unwrap();
    assert!(figure.caption.contains("at least 2.5 times"), "{}", figure.caption);
    finding.looked_at = None;
    assert!(evidence::figure(&finding, &subject, &context).is_none());
}

#[test]
fn a_report_says_everything_and_hostile_names_stay_text() {
    let mut diagnosis = diagnosed(&flow(2_400).unwrap(), LoopType::Flow);
    diagnosis.name = HOSTILE.to_owned();
    diagnosis.pv_unit = Some(HOSTILE.to_owned());
    diagnosis.notes.push(HOSTILE.to_owned());
    let html = page(&[(&diagnosis, &source(HOSTILE))]).unwrap();
    well_formed(&html);
    data(&html);
    assert!(!html.contains("<script>alert") && !html.contains("<b>") && !html.contains(HOSTILE));
    assert!(!html.contains("NaN"));
    for detector in methods::all() {
        let title = detector.method().title;
        assert!(html.contains(title), "{title}");
        for parameter in detector.parameters() {
            assert!(html.contains(&format!("{} = ", parameter.name)), "{}", parameter.name);
        }
    }
    for measure in &diagnosis.fitness.measures {
        assert!(html.contains(measure.id.name()));
    }
    for kpi in &diagnosis.kpis.numbers {
        assert!(html.contains(kpi.name));
    }
    for text in ["measured position", "stiction 9", "00ff", "2023-11-14", "slip jump"] {
        assert!(html.contains(text), "{text}");
    }
    for table in html.split("<table>").skip(1).map(|rest| rest.split("</table>").next().unwrap()) {
        let columns = table.matches("<th ").count();
        for row in table.split("<tr>").skip(2) {
            assert_eq!(row.matches("<td").count(), columns, "{row}");
        }
    }
    let addresses = html.matches("://").count();
    assert_eq!(addresses, html.matches("xmlns=\"http://www.w3.org/2000/svg\"").count());
    assert!(!html.contains(" src="));
}

#[test]
fn loops_stand_in_their_rank_whatever_their_order() {
    let sticky = diagnosed(&flow(1_500).unwrap(), LoopType::Flow);
    let mut quiet = sticky.clone();
    quiet.name = "quiet".to_owned();
    quiet.verdict.class = stiction_diagnose::diagnose::VerdictClass::DoesNotStick;
    assert!(sticky.rank() < quiet.rank());
    let (a, b) = (source("a.csv"), source("b.csv"));
    let html = page(&[(&quiet, &a), (&sticky, &b)]).unwrap();
    assert_eq!(html, page(&[(&sticky, &b), (&quiet, &a)]).unwrap());
    let place = |text: &str| html.find(text).unwrap();
    assert!(place("href=\"#loop-1\">loop<") < place("href=\"#loop-2\">quiet<"));
    well_formed(&html);
}

#[test]
fn without_a_segment_there_is_a_report_all_the_same() {
    let mut recording = recording(&flow(300).unwrap(), LoopType::Flow);
    recording.mode = Some(stiction_diagnose::recording::Modes {
        time: vec![0.0],
        modes: vec![stiction_diagnose::recording::Mode::Manual],
    });
    let diagnosis = diagnose(&recording, &DiagnoseOptions::default()).unwrap();
    assert!(diagnosis.segment().is_none());
    let html = page(&[(&diagnosis, &source("a.csv"))]).unwrap();
    well_formed(&html);
    let all = format!("{} methods abstain", MethodId::ALL.len());
    assert!(html.contains("cannot answer") && html.contains(&all));
}

#[test]
fn long_recordings_make_small_reports() {
    let diagnosis = diagnosed(&flow(121_000).unwrap(), LoopType::Flow);
    let html = page(&[(&diagnosis, &source("a.csv"))]).unwrap();
    assert!(html.len() < 3_000_000, "{} bytes", html.len());
}

/// `pages/check.py` opens it in a browser.
#[test]
fn an_index_of_a_thousand_loops_is_light() {
    let loops: Vec<Diagnosis> = [600, 900, 1_200, 2_000, 3_000]
        .into_iter()
        .flat_map(|samples| {
            [
                diagnosed(&flow(samples).unwrap(), LoopType::Flow),
                diagnosed(&level(samples).unwrap(), LoopType::Level),
            ]
        })
        .collect();
    let many: Vec<Diagnosis> = (0..1_000)
        .map(|k| {
            let mut one = loops[k % loops.len()].clone();
            // Some valves were recorded several times.
            let valve = k - k % 9 / 8;
            one.name = format!("U{}-{}C{valve:04}", 1 + valve / 250, ["F", "L"][valve % 2]);
            one.verdict.grade = Grade::ALL[k % Grade::ALL.len()];
            one.verdict.probability = Some((k as f64 / 1_000.0).clamp(0.0, 1.0));
            one
        })
        .collect();
    let source = source("export of march.parquet");
    let found: Vec<Loop<'_>> = many.iter().map(|diagnosis| Loop::new(&source, diagnosis)).collect();
    let folder = report::Folder::new("tool", &found);
    let index = folder.index();
    assert_eq!(folder.len(), 1_000);
    assert!(index.len() < 1_500_000, "{} bytes", index.len());
    assert_eq!(index.matches("<tr data-grade").count(), 1_000);
    assert!(index.contains("data-later") && index.contains(&folder.path(999)));
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("index-of-1000.html");
    std::fs::write(path, index).unwrap();
    assert!(folder.page(3).unwrap().contains("href=\"./../index.html\""));
}
