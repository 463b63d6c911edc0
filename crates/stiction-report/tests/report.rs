//! What a report must have, whatever it is about.

use crate::html;

use html::{data, tags, well_formed};
use serde_json::Value;
use stiction_diagnose::diagnose::VerdictClass;
use stiction_diagnose::finding::Decision;
use stiction_diagnose::recording::{Mode, Modes, Segment};
use stiction_figure::{Figure, Panel, Scale, Series, Span, Strip};
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Run, Signal};
use stiction_model::valve::{Assembly, Model};
use stiction_model::{Bands, Result};
use stiction_report::document::Source;
use stiction_report::report::layout::{Badge, Block, Card, Fact, Report, Section, Table};
use stiction_report::report::views::{self, Context};

const HOSTILE: &str = "</script><script>alert(1)</script> \"'&\u{0}<b>";

fn sticky(samples: usize) -> Result<Run> {
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

fn segment(run: &Run, from: usize, to: usize) -> Segment {
    let part = |x: &[f64]| Some(x[from..to].to_vec());
    Segment {
        from: from as f64 * run.sample_time,
        sample_time: run.sample_time,
        op: run.op[from..to].to_vec(),
        pv: part(&run.pv),
        sp: part(&run.sp),
        vp: part(&run.vp),
        bridged: 0,
    }
}

fn report(samples: usize) -> Report {
    let run = sticky(samples).unwrap();
    let segments = [segment(&run, 0, samples / 4), segment(&run, samples / 3, samples)];
    let modes = Modes { time: vec![0.0, 100.0], modes: vec![Mode::Manual, Mode::Automatic] };
    let context = Context {
        start: Some(1.7e9),
        plant_time: None,
        pv_unit: Some(HOSTILE),
        modes: Some(&modes),
        period_s: None,
    };
    let table = Table::new(HOSTILE).words(HOSTILE).numbers("value", HOSTILE).row([HOSTILE, "1"]);
    let card = Card::new(HOSTILE, HOSTILE)
        .badge(Decision::Undecided)
        .caveat(HOSTILE)
        .table(table.clone())
        .figure(views::histograms(&segments[1], &context).unwrap());
    let mut section = Section::new(HOSTILE, Badge::from(VerdictClass::Sticks), HOSTILE)
        .reason(HOSTILE)
        .fact(Fact::new(HOSTILE, HOSTILE, HOSTILE))
        .heading(HOSTILE)
        .with(card)
        .with(Block::Details { summary: HOSTILE.into(), blocks: vec![table.into()] });
    let figures = views::all(&segments, 1, &context);
    assert_eq!(figures.len(), 5);
    for figure in figures {
        section = section.with(figure);
    }
    Report::new(HOSTILE, "stiction 0")
        .introduction(HOSTILE)
        .source(&Source { file: HOSTILE.into(), sha256: HOSTILE.into() })
        .with(section.clone())
        .with(section)
}

#[test]
fn the_document_is_well_formed() {
    let html = report(900).html().unwrap();
    let ids = well_formed(&html);
    assert!(ids.contains("loop-2") && html.contains("href=\"#loop-2\""));
}

#[test]
fn nothing_is_fetched() {
    let html = report(900).html().unwrap();
    let addresses = html.matches("://").count();
    assert_eq!(addresses, html.matches("xmlns=\"http://www.w3.org/2000/svg\"").count());
    for tag in tags(&html) {
        assert!(!tag.contains(" src=") && !tag.starts_with("link"), "{tag}");
        if let Some(reference) = tag.split("href=\"").nth(1) {
            assert!(reference.starts_with('#'), "{tag}");
        }
    }
    for word in ["@import", "fetch(", "XMLHttpRequest", "import(", "eval("] {
        assert!(!html.contains(word), "{word}");
    }
}

#[test]
fn hostile_names_stay_text() {
    let html = report(900).html().unwrap();
    assert!(!html.contains("alert(1)</script>") && !html.contains("<script>alert"));
    assert!(!html.contains("<b>") && !html.contains(HOSTILE));
    assert!(!html.contains("NaN") && !html.contains("Infinity,"));
    // One script is ours; the others are data.
    let scripts = tags(&html).iter().filter(|tag| tag.starts_with("script")).count();
    assert_eq!(scripts, 1 + data(&html).len());
}

#[test]
fn equal_reports_give_equal_bytes() {
    assert_eq!(report(900).html().unwrap(), report(900).html().unwrap());
}

#[test]
fn long_recordings_make_small_files() {
    let html = report(121_000).html().unwrap();
    // Two loops with eight figures each.
    assert!(html.len() < 3_000_000, "{} bytes", html.len());
    let run = sticky(121_000).unwrap();
    let trends = views::trends(&[segment(&run, 0, 121_000)], 0, &Context::default()).unwrap();
    assert!(trends.caption.contains("every extreme kept"));
}

/// The values of a packed list.
fn unpacked(list: &Value) -> Vec<f64> {
    let (from, step) = (list["from"].as_f64().unwrap(), list["step"].as_f64().unwrap_or(0.0));
    let mut sum = 0.0;
    if let Some(n) = list["n"].as_u64() {
        return (0..n).map(|i| from + step * i as f64).collect();
    }
    let whole = list["d"].as_array().unwrap().iter().map(|d| d.as_f64().unwrap());
    whole
        .map(|d| {
            sum += d;
            from + step * sum
        })
        .collect()
}

#[test]
fn a_script_finds_the_samples() {
    let run = sticky(4_000).unwrap();
    let trends = views::trends(&[segment(&run, 0, 4_000)], 0, &Context::default()).unwrap();
    let live = trends.live("a").unwrap();
    let data: Value = serde_json::from_str(&live.data).unwrap();
    let panels = data["panels"].as_array().unwrap();
    assert_eq!(panels.len(), 2);
    assert_eq!(live.svg.matches("class=\"panel\"").count(), 2);
    assert!(panels.iter().all(|p| p["group"] == "time"));
    let (upper, pv) = (&panels[0], &panels[0]["series"][0]);
    assert_eq!((&pv["name"], &pv["kind"]), (&Value::from("PV"), &Value::from("trend")));
    assert_eq!((&upper["x"]["name"], &upper["x"]["unit"]), (&"time".into(), &"min".into()));

    // Every sample that can be read is one of the recording, and the extremes are among them.
    let (x, y) = (unpacked(&pv["x"]), unpacked(&pv["y"]));
    assert_eq!(x.len(), y.len());
    let span = stiction_diagnose::series::span(&run.pv);
    for (minutes, value) in x.iter().zip(&y) {
        let k = (minutes * 60.0 / run.sample_time).round() as usize;
        assert!((run.pv[k] - value).abs() <= 1e-3 * span, "{k}");
    }
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * span;
    assert!(near(stiction_diagnose::series::max(&y), stiction_diagnose::series::max(&run.pv)));
    assert!(near(stiction_diagnose::series::min(&y), stiction_diagnose::series::min(&run.pv)));
}

#[test]
fn maps_tell_the_time() {
    let run = sticky(400).unwrap();
    let map = views::pv_op_map(&segment(&run, 0, 400), &Context::default()).unwrap();
    let data: Value = serde_json::from_str(&map.live("a").unwrap().data).unwrap();
    let path = &data["panels"][0]["series"][0];
    assert_eq!((&path["along"]["name"], &path["along"]["unit"]), (&"time".into(), &"s".into()));
    let times = unpacked(&path["along"]["values"]);
    assert_eq!(times.len(), unpacked(&path["x"]).len());
    assert!((times.last().unwrap() - 199.5).abs() < 0.1 && times.is_sorted());
}

#[test]
fn named_places_have_their_names() {
    let panel = Panel::new("pattern", "share (%)")
        .x_scale(Scale::Names(&["DS", "IS"]))
        .with(Series::bars("steps", [0.0, 1.0], [30.0, 70.0]));
    let live = Figure::new("").with(panel).live("a").unwrap();
    assert!(live.svg.contains(">DS<") && live.svg.contains(">IS<"));
    assert!(live.data.contains("\"names\":[\"DS\",\"IS\"]"));
}

#[test]
fn views_without_signals_are_left_out() {
    let run = sticky(500).unwrap();
    let mut bare = segment(&run, 0, 500);
    (bare.pv, bare.sp, bare.vp) = (None, None, None);
    let context = Context::default();
    assert_eq!(views::pv_op_map(&bare, &context), None);
    assert_eq!(views::op_pv_correlation(&bare, &context), None);
    assert_eq!(views::trends(&[bare.clone()], 0, &context).unwrap().panels.len(), 1);
    assert_eq!(views::all(&[bare.clone()], 0, &context).len(), 3);
    assert!(views::all(&[bare.clone()], 7, &context).is_empty());

    bare.op = vec![50.0; 500];
    bare.pv = Some(vec![1.0; 500]);
    assert_eq!(views::all(&[bare.clone()], 0, &context), vec![]);
    bare.op = vec![50.0];
    bare.pv = None;
    for figure in views::all(&[bare], 0, &context) {
        figure.live("a").unwrap();
    }
    assert_eq!(views::trends(&[], 0, &context), None);
}

#[test]
fn short_and_odd_segments_are_drawn() {
    let run = sticky(400).unwrap();
    for (from, to) in [(0, 1), (0, 2), (10, 13), (10, 26), (0, 400)] {
        for start in [None, Some(0.0), Some(1.7e9), Some(1e300), Some(f64::NAN)] {
            for period_s in [None, Some(0.0), Some(1e9), Some(1e-9), Some(f64::NAN)] {
                let context = Context { start, period_s, ..Context::default() };
                for figure in views::all(&[segment(&run, from, to)], 0, &context) {
                    let live = figure.live("a").unwrap();
                    assert!(!live.svg.contains("NaN") && !live.data.contains("NaN"));
                    serde_json::from_str::<Value>(&live.data).unwrap();
                }
            }
        }
    }
}

#[test]
fn live_pictures_show_what_plain_ones_show() {
    let t: Vec<f64> = (1..200).map(f64::from).collect();
    let panel = Panel::new("time (s)", "power")
        .with(Series::line("a", &t[..], &t[..]).breaks([50, 50, 900]))
        .with(Series::bars("b", &t[..], &t[..]))
        .x_scale(Scale::Log)
        .strip(Strip {
            name: "mode".into(),
            spans: vec![Span { from: 1.0, to: 100.0, word: "manual".into(), shade: 1.0 }],
        });
    let figure = Figure::new("title").with(panel.group("time"));
    let (plain, live) = (figure.svg().unwrap(), figure.live("x").unwrap().svg);
    for text in ["title", "time (s)", "power", "mode", "manual", ">100<"] {
        assert!(plain.contains(text) && live.contains(text), "{text}");
    }
    assert!(live.contains("<clipPath id=\"x-") && !plain.contains("class=\"moving\""));
    assert!(figure.png().is_ok());

    let zero = Panel::new("x", "y").with(Series::line("a", [0.0, 1.0], [1.0, 2.0]));
    assert!(Figure::new("").with(zero.x_scale(Scale::Log)).svg().is_err());
}
