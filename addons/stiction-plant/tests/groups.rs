//! Loops that swing together: on networks whose truth is known, and from a demo plant to its groups.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::ops::ControlFlow;
use std::path::PathBuf;
use stiction_diagnose::recording::Recording;
use stiction_model::closed_loop::NormalStream;
use stiction_plant::groups::pairs::Pair;
use stiction_plant::groups::{self, GroupOptions, LoopOfWeek, Source};
use stiction_plant::plant_file::Plant;
use stiction_plant::report::Known;
use stiction_plant::trace::{Trace, TraceSignal};
use stiction_plant::trial::Trial;
use stiction_plant::{ScanOptions, Store, day, demo, scan, take};

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("groups-{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn sources_and_those_that_they_reach_are_found_and_others_are_not() {
    let trial = Trial::run(5, 4, 2, || {}).unwrap();
    assert!(trial.recall.n >= 3, "{trial:?}");
    assert!(5 * trial.recall.k >= 3 * trial.recall.n, "{trial:?}");
    assert!(20 * trial.false_pairs.k <= trial.false_pairs.n, "{trial:?}");
    assert_eq!(Trial::run(5, 1, 1, || {}).unwrap(), Trial::run(5, 1, 1, || {}).unwrap());
}

/// A swing whose period wanders about `period` samples, and then noise: each of the same numbers is the same.
fn swing(period: f64, seed: u64, n: usize) -> Vec<f64> {
    let mut draws = NormalStream::new(seed);
    let mut phase = 0.0;
    (0..n)
        .map(|_| {
            phase += std::f64::consts::TAU / period * (1.0 + 0.3 * draws.draw());
            f64::sin(phase)
        })
        .collect()
}

fn trace(name: &str, values: &[f64]) -> Trace {
    let recording = Recording::regular(name, 10.0, values, Some(values), None).unwrap();
    Trace::of(&recording, 0, 10 * values.len() as i64, TraceSignal::Error).unwrap()
}

/// Loops in threes that swing together, late and with noise, then loops of their own.
fn plant(threes: usize, alone: usize, n: usize) -> Vec<Trace> {
    let mut traces = vec![];
    for k in 0..threes + alone {
        let common = swing(20.0 + (k % 37) as f64, k as u64, n + 100);
        for member in 0..if k < threes { 3 } else { 1 } {
            let mut noise = NormalStream::new((1000 * k + member + 7) as u64);
            let late = 5 * member;
            let values: Vec<f64> = (0..n).map(|i| common[i + late] + 0.7 * noise.draw()).collect();
            traces.push(trace(&format!("L{k:04}-{member}"), &values));
        }
    }
    traces
}

#[test]
fn loops_of_equal_periods_are_no_group_unless_they_are_in_step() {
    let traces = plant(4, 40, 17_280);
    let probability = |name: &str| if name.ends_with("-1") { 0.9 } else { 0.1 };
    let loops: Vec<LoopOfWeek> = traces
        .iter()
        .map(|trace| LoopOfWeek {
            name: trace.name.clone(),
            probability: Some(probability(&trace.name)),
            period_s: None,
        })
        .collect();
    let options = GroupOptions::default();
    let upstream = BTreeMap::new();
    let found = groups::find(&traces, &loops, &upstream, &options);
    assert_eq!(found.len(), 4, "{found:#?}");
    for group in &found {
        assert_eq!((group.members.len(), group.source), (3, Source::Candidates), "{group:#?}");
        let first = &group.members[0];
        assert!(first.name.ends_with("-1") && first.candidate_rank == Some(1), "{group:#?}");
        let of: usize = first.name[1..5].parse().unwrap();
        let period = 10.0 * (20.0 + of as f64);
        assert!((group.period_s / period - 1.0).abs() < 0.1, "{} {period}", group.period_s);
    }
    // None of them is likely to stick.
    let healthy: Vec<LoopOfWeek> =
        loops.iter().map(|own| LoopOfWeek { probability: Some(0.01), ..own.clone() }).collect();
    let found = groups::find(&traces, &healthy, &upstream, &options);
    assert!(found.iter().all(|group| group.source == Source::NotRecorded));
    assert!(found.iter().flat_map(|group| &group.members).all(|m| m.candidate_rank.is_none()));
    // Where all are as likely, the plant's file decides.
    let told = BTreeMap::from([("L0000-1".to_owned(), vec!["L0000-2".to_owned()])]);
    let alike: Vec<LoopOfWeek> =
        loops.iter().map(|own| LoopOfWeek { probability: Some(0.5), ..own.clone() }).collect();
    let found = groups::find(&traces, &alike, &told, &options);
    let group = found.iter().find(|g| g.members.iter().any(|m| m.name == "L0000-1")).unwrap();
    let names: Vec<&str> = group.members.iter().map(|member| &*member.name).collect();
    assert_eq!((names[0], names[2]), ("L0000-2", "L0000-1"), "{group:#?}");
}

#[test]
fn pairs_of_blocks_give_the_same_groups() {
    let mut traces = plant(6, 20, 17_280);
    let loops: Vec<LoopOfWeek> = (0..5)
        .map(|k| LoopOfWeek {
            name: format!("L{k:04}-0"),
            probability: Some(0.8),
            period_s: Some(310.0),
        })
        .collect();
    let (upstream, options) = (BTreeMap::new(), GroupOptions::default());
    let expected = groups::find(&traces, &loops, &upstream, &options);
    assert_eq!(expected.len(), 6);
    // Three blocks, each with itself and with each other, of traces in another order.
    let span = groups::pairs::span(&traces);
    let all = traces.len();
    traces.reverse();
    let block = |of: usize| traces.iter().enumerate().filter(move |(k, _)| k % 3 == of);
    let mut pairs = vec![];
    for a in 0..3 {
        let own: Vec<Trace> = block(a).map(|(_, trace)| trace.clone()).collect();
        pairs.extend(groups::pairs::pairs(&own, &loops, &span, None));
        let names: BTreeSet<String> = own.iter().map(|trace| trace.name.clone()).collect();
        for b in 0..a {
            let both: Vec<Trace> =
                own.iter().chain(block(b).map(|(_, trace)| trace)).cloned().collect();
            pairs.extend(groups::pairs::pairs(&both, &loops, &span, Some(&names)));
        }
    }
    traces.reverse();
    let find = |pairs: &[Pair]| groups::find_of(pairs, &traces, &loops, &upstream, &options);
    assert_eq!(find(&pairs), Some(expected.clone()));
    // What cannot count is not needed.
    let before = pairs.len();
    loop {
        let most = groups::pairs::most_that_counts(pairs.len(), all, &options);
        let count = pairs.len();
        pairs.retain(|pair| pair.p <= most);
        if pairs.len() == count {
            break;
        }
    }
    assert!(pairs.len() < before && find(&pairs) == Some(expected), "{} of {before}", pairs.len());
    pairs[0].second = "unknown".to_owned();
    assert_eq!(find(&pairs), None);
}

#[test]
fn a_report_takes_pairs_only_of_the_traces_it_has() {
    let folder = folder("pairs");
    demo::write(&folder, 6, 2, 1, || {}).unwrap();
    let plant = Plant::read(&folder).unwrap();
    scan(&folder, &plant, &ScanOptions::default(), |_| ControlFlow::Continue(())).unwrap();
    let known = Known::without_groups(&folder, &plant, None).unwrap();
    let loops = known.loops_of_week(&plant);
    let (begin, end) = known.span(&plant);
    let traces = Store::of(&folder).traces(begin, end).unwrap();
    let find = || known.find_groups(&folder, &plant, &loops).unwrap();
    let expected = find();
    assert!(!expected.is_empty());
    let compared: BTreeSet<_> = traces
        .iter()
        .map(|of| (of.name.clone(), of.start, of.unit.to_bits(), of.digest()))
        .collect();
    let pairs = groups::pairs::pairs(&traces, &loops, &groups::pairs::span(&traces), None);
    known.keep_pairs(&folder, &plant, &pairs, &compared).unwrap();
    assert_eq!(find(), expected);
    // That they are taken is seen where they are wrong.
    known.keep_pairs(&folder, &plant, &[], &compared).unwrap();
    assert_eq!(find(), []);
    let others: BTreeSet<_> = compared.iter().skip(1).cloned().collect();
    let refused = known.keep_pairs(&folder, &plant, &pairs, &others).unwrap_err().to_string();
    assert!(refused.contains("have different windows, such as that of"), "{refused}");
    // Of a day more there are other traces.
    fs::remove_dir_all(folder.join(".stiction/runs")).unwrap();
    let fewer = &traces[1..];
    let rows = Store::of(&folder).rows().unwrap();
    take(&folder, &plant, &rows, fewer).unwrap();
    assert_eq!(find(), groups_of(fewer, &loops, &plant));
}

fn groups_of(traces: &[Trace], loops: &[LoopOfWeek], plant: &Plant) -> Vec<groups::Group> {
    let upstream = plant.file.loops.iter().map(|(name, own)| (name.clone(), own.upstream.clone()));
    groups::find(traces, loops, &upstream.collect(), &GroupOptions::default())
}

#[test]
fn traces_of_a_scan_are_kept_small_and_find_the_demo_s_groups() {
    let folder = folder("demo");
    demo::write(&folder, 20, 2, 1, || {}).unwrap();
    let truth = fs::read_to_string(folder.join("truth.csv")).unwrap();
    for story in ["repaired", "begins", "dead", "manual", "more from day to day"] {
        assert!(truth.contains(story), "{truth}");
    }
    assert!(truth.contains("sticking neighbour"), "{truth}");
    let plant = Plant::read(&folder).unwrap();
    assert!(plant.file.loops.values().any(|facts| !facts.upstream.is_empty()));
    scan(&folder, &plant, &ScanOptions::default(), |_| ControlFlow::Continue(())).unwrap();
    let store = Store::of(&folder);
    let start = day::begin(demo::FIRST_DAY, &plant.zone) as i64;
    let traces = store.traces(start, start + 2 * 86_400).unwrap();
    let rows = store.rows().unwrap();
    let judged = rows.iter().filter(|row| row.samples.is_some()).count();
    assert!(judged >= 38 && traces.len() >= judged - 1, "{} {judged}", traces.len());
    assert_eq!(store.traces(start + 86_400, start + 2 * 86_400).unwrap().len() + 20, traces.len());
    let bytes: u64 = glob::glob(&format!("{}/.stiction/runs/*/traces-*", folder.display()))
        .unwrap()
        .map(|path| fs::metadata(path.unwrap()).unwrap().len())
        .sum();
    let days: i64 = traces.iter().map(|trace| trace.len() as i64).sum::<i64>() / 8640;
    println!("{} bytes a day", bytes / days as u64);
    assert!(bytes / days as u64 <= 20_000, "{} bytes a day", bytes / days as u64);
    let loops: Vec<LoopOfWeek> = rows
        .iter()
        .filter(|row| row.window_start == start)
        .map(|row| LoopOfWeek {
            name: row.name.clone(),
            probability: row.probability,
            period_s: row.period_s.filter(|_| row.oscillates == Some(true)),
        })
        .collect();
    let found = groups::find(&traces, &loops, &BTreeMap::new(), &GroupOptions::default());
    // Some loop that a valve reaches is in a group with it.
    let reached = truth.lines().skip(1).any(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        cells[10].split(' ').any(|source| {
            found.iter().any(|group| {
                let there = |name: &str| group.members.iter().any(|member| member.name == name);
                there(source) && there(cells[0])
            })
        })
    });
    assert!(reached, "{truth}\n{found:#?}");
}

#[test]
#[ignore = "takes a minute; prints how long a thousand loops take"]
fn a_thousand_loops() {
    let traces = plant(100, 700, 60_480);
    let started = std::time::Instant::now();
    let found = groups::find(&traces, &[], &BTreeMap::new(), &GroupOptions::default());
    println!("{} loops, {} groups, {:?}", traces.len(), found.len(), started.elapsed());
    assert!(found.len() >= 100);
}
