//! Regularity against independent reference values: pure signals, simulated loops, recordings.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};
use stiction_diagnose::oscillation::{Regularity, analyse};
use stiction_diagnose::recording::{Grid, GridOptions, Recording, fitness};
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, Process};
use stiction_model::valve::{Assembly, Model};

type Test = Result<(), Box<dyn std::error::Error>>;

/// The reference used no more of a recording than this.
const REFERENCE_SAMPLES: usize = 20_000;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/detect").join(name)
}

fn references() -> Result<serde_json::Value, Box<dyn std::error::Error>> {
    Ok(serde_json::from_reader(std::fs::File::open(fixture("detectors.json"))?)?)
}

/// How far `found` is from `expected`, relative to it.
fn deviation(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

#[test]
fn pure_signals() -> Test {
    let references = references()?;
    // Eight periods of 200 samples, sampled half-way.
    let phase = |k: usize| TAU * (k as f64 + 0.5) / 200.0;
    let sine: Vec<f64> = (0..1600).map(|k| phase(k).sin()).collect();
    let triangle: Vec<f64> = (0..1600).map(|k| 2.0 / PI * phase(k).sin().asin()).collect();
    for (name, x) in [("sine", sine), ("triangle", triangle)] {
        let found = Regularity::of(&x).ok_or("it oscillates")?;
        let expected = |key: &str| references[name][key].as_f64().ok_or("a number");
        assert!(deviation(found.index, expected("acf_r")?) < 1e-6, "{name}: {}", found.index);
        assert!(deviation(found.period, expected("acf_period")?) < 1e-9, "{name}");
    }
    Ok(())
}

#[test]
fn simulated_loops() -> Test {
    let references = references()?;
    let file = std::fs::File::open(fixture("detector_scenarios.csv.gz"))?;
    let mut rows = csv::Reader::from_reader(flate2::read::GzDecoder::new(file));
    let mut scenarios: BTreeMap<String, (Vec<f64>, Vec<f64>)> = BTreeMap::new();
    for row in rows.deserialize() {
        let (name, t, _sp, _op, _mv, pv, _noisy): (String, f64, f64, f64, f64, f64, f64) = row?;
        let (times, values) = scenarios.entry(name).or_default();
        times.push(t);
        values.push(pv);
    }
    assert_eq!(scenarios.len(), 6);
    let mut worst: f64 = 0.0;
    for (name, (times, pv)) in scenarios {
        let sample_time = times[1] - times[0];
        let found = Regularity::of(&pv).ok_or("it oscillates")?;
        let expected = |key: &str| references["scenarios"][&name][key].as_f64().ok_or("a number");
        worst = worst.max(deviation(found.index, expected("acf_r")?));
        worst = worst.max(deviation(found.period * sample_time, expected("acf_period_s")?));
    }
    println!("largest relative deviation {worst:.1e}");
    assert!(worst < 1e-6);
    Ok(())
}

#[test]
fn recordings_of_plants() -> Test {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/isdb");
    if !data.is_dir() {
        println!("skipped: there are no recordings at {}", data.display());
        return Ok(());
    }
    let column = |name: &str, column: &str| -> Result<Vec<f64>, Box<dyn std::error::Error>> {
        let mut rows = csv::Reader::from_path(data.join(format!("{name}.csv")))?;
        let place = rows.headers()?.iter().position(|c| c == column).ok_or("a column")?;
        let values = rows.records().map(|row| Ok(row?[place].parse()?));
        values.collect()
    };
    let mut worst: f64 = 0.0;
    let mut compared = 0;
    for row in csv::Reader::from_path(fixture("isdb_oracle_indices.csv"))?.records() {
        let row = row?;
        for (signal, index, period) in [("op", 2, 3), ("pv", 6, 7)] {
            if row[index].is_empty() {
                continue;
            }
            let x = column(&row[0], signal)?;
            let found = Regularity::of(&x[..x.len().min(REFERENCE_SAMPLES)]);
            let (index, period): (f64, f64) = (row[index].parse()?, row[period].parse()?);
            compared += 1;
            match found {
                Some(found) => {
                    worst = worst.max(deviation(found.index, index));
                    worst = worst.max(deviation(found.period, period));
                    assert!(worst < 1e-6, "{} {signal}: {found:?}", &row[0]);
                }
                None => assert!(index.is_nan(), "{} {signal}", &row[0]),
            }
        }
    }
    println!("{compared} signals, largest relative deviation {worst:.1e}");
    assert_eq!(compared, 61);
    Ok(())
}

/// From a simulated loop over a recording and its grid to its period.
#[test]
fn a_sticky_loop_cycles_with_its_own_period() -> Test {
    let valve = Model::by_name("two-phase")?.build(Bands::from_s_j(5.0, 2.0)?)?;
    let mut sticky = ClosedLoop::new(
        Controller::pi(1.1, 2.5)?,
        Assembly::new(valve),
        Process::first_order(1.5, 5.93, 1.07)?,
    );
    sticky.set_point = 5.0.into();
    let run = sticky.run()?;
    let from = run.op.len() / 3;
    let sample_time = sticky.sample_time;
    let (op, pv) = (&run.op[from..], &run.pv[from..]);
    let recording = Recording::regular("sticky", sample_time, op, Some(pv), None)?;
    let grid = Grid::of(&recording, &GridOptions::default())?;
    let segment = grid.longest().ok_or("a segment")?;
    assert_eq!(segment.op, op);
    let expected = run.period_s().ok_or("it cycles")?;
    for signal in [op, pv] {
        let found = analyse(signal, sample_time);
        assert!(found.found && found.regularity.is_some_and(|r| r > 10.0), "{found:?}");
        assert!(deviation(found.period_s.ok_or("a period")?, expected) < 0.01);
        assert_eq!(found.episodes.len(), 1);
    }
    let period = expected / sample_time;
    let fitness = fitness::assess(&recording, &grid, segment, Some(period));
    println!("{:?}", fitness.reasons);
    assert!(fitness.class != fitness::Class::Unfit, "{:?}", fitness.reasons);
    Ok(())
}
