//! The shape and correlation detectors against an independent implementation of the same formulas.

use crate::common;

use common::Table;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::PathBuf;
use stiction_diagnose::methods::{
    Subject, area_ratio::AreaRatio, curve_fit::CurveFit, horch::Horch, yamashita::Yamashita,
};
use stiction_diagnose::recording::{LoopType, Segment};

const TOLERANCE: f64 = 1e-6;

/// Largest relative difference by name.
#[derive(Default)]
struct Worst(BTreeMap<String, (f64, usize)>);

impl Worst {
    fn compare(&mut self, name: &str, what: &str, found: f64, expected: f64) {
        let difference = (found - expected).abs();
        let relative = if difference == 0.0 { 0.0 } else { difference / expected.abs() };
        assert!(relative <= TOLERANCE, "{what}: {name} is {found}, expected {expected}");
        let worst = self.0.entry(name.to_owned()).or_default();
        *worst = (worst.0.max(relative), worst.1 + 1);
    }

    fn print(&self) {
        for (name, (worst, count)) in &self.0 {
            println!("{name:16} {count:3} values, largest relative difference {worst:.1e}");
        }
    }
}

fn segment(op: &[f64], pv: &[f64], sp: Option<&[f64]>) -> Segment {
    Segment {
        from: 0.0,
        sample_time: 0.1,
        op: op.to_vec(),
        pv: Some(pv.to_vec()),
        sp: sp.map(<[f64]>::to_vec),
        vp: None,
        bridged: 0,
    }
}

fn reference() -> serde_json::Value {
    let path: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "tests/fixtures/detect/detectors.json"].iter().collect();
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn ratio_of(pv: &[f64]) -> f64 {
    let segment = segment(pv, pv, Some(&vec![0.0; pv.len()]));
    let subject = Subject::new(&segment, LoopType::Flow, None);
    AreaRatio::default().run(&subject).unwrap().statistic
}

/// The reference's signals: 300 s of period 20 s, sampled in the middle of every 0.1 s.
#[test]
fn canonical_waves() {
    let reference = reference();
    let phase: Vec<f64> =
        (0..3000).map(|k| 2.0 * PI * ((f64::from(k) + 0.5) * 0.1) / 20.0).collect();
    let sine: Vec<f64> = phase.iter().map(|w| w.sin()).collect();
    let triangle: Vec<f64> = sine.iter().map(|s| 2.0 / PI * s.asin()).collect();
    let fit = |x: &[f64]| CurveFit::default().fit("OP", x).unwrap();
    let mut worst = Worst::default();
    for (name, x) in [("sine", &sine), ("triangle", &triangle)] {
        let (found, expected) = (fit(x), &reference[name]);
        let number = |key: &str| expected[key].as_f64().unwrap();
        if name == "sine" {
            assert!(found.sine_mse < 1e-25 && found.statistic < 1e-25);
        } else {
            worst.compare("mse_sin", name, found.sine_mse, number("mse_sin"));
            worst.compare("he_SI", name, found.statistic, number("he_SI"));
        }
        worst.compare("mse_tri", name, found.triangle_mse, number("mse_tri"));
        // Each peak is two equal samples, of which rounding chooses one: so 1, give or take one in 32.
        let (ratio, expected) = (ratio_of(x), number("area_ratio"));
        println!("{name}: area ratio {ratio}, in the reference {expected}");
        assert!((ratio - expected).abs() < 0.08 && (ratio - 1.0).abs() < 0.04);
    }
    worst.print();
}

/// Square waves behind a lag, 400 samples a half period.
#[test]
fn square_waves_behind_a_lag() {
    let mut worst = Worst::default();
    for expected in reference()["rect_through_lag"].as_array().unwrap() {
        let number = |key: &str| expected[key].as_f64().unwrap();
        let ratio = number("h_over_tau");
        let first = (1.0 - (-ratio).exp()) / (1.0 + (-ratio).exp());
        let half = |k: usize| 1.0 - (1.0 + first) * (-ratio * k as f64 / 400.0).exp();
        let pv: Vec<f64> = (0..20 * 400)
            .map(|k| if k / 400 % 2 == 0 { half(k % 400) } else { -half(k % 400) })
            .collect();
        let what = format!("h/tau = {ratio}");
        worst.compare("R_numeric", &what, ratio_of(&pv), number("R_numeric"));
        let c = 2.0 / (1.0 + (-ratio).exp());
        let closed = (ratio - c.ln() - (c - 1.0)) / ((c - 1.0) - c.ln());
        worst.compare("R_closed", &what, closed, number("R_closed"));
        assert!((ratio_of(&pv) / closed - 1.0).abs() < 1e-4);
        let index = CurveFit::default().fit("PV", &pv).unwrap().statistic;
        worst.compare("he_SI_of_pv", &what, index, number("he_SI_of_pv"));
    }
    worst.print();
}

#[test]
fn simulated_loops() {
    let table = Table::fixture("detect/detector_scenarios.csv.gz");
    let mut worst = Worst::default();
    for (name, expected) in reference()["scenarios"].as_object().unwrap() {
        let rows = table.rows(|row| table.text(row, "scenario") == name);
        let [sp, op, mv, pv] = ["sp", "op", "mv", "pv"].map(|c| table.column(&rows, c));
        let segment = segment(&op, &pv, Some(&sp));
        let subject = Subject::new(&segment, LoopType::Flow, None);
        let number = |key: &str| expected[key].as_f64().unwrap();
        for (key, signal, x) in [("he_SI_op", "OP", &op), ("he_SI_pv", "PV", &pv)] {
            let index = CurveFit::default().fit(signal, x).unwrap().statistic;
            worst.compare(key, name, index, number(key));
        }
        let ratio = AreaRatio::default().run(&subject).unwrap().statistic;
        worst.compare("area_ratio_e", name, ratio, number("area_ratio_e"));
        for (key, x) in [("yamashita_mv", &mv), ("yamashita_pv", &pv)] {
            let found = Yamashita::default().count(&op, x).unwrap();
            for (i, rho) in [found.statistic, found.rho2, found.rho3].into_iter().enumerate() {
                let expected = expected[key][i].as_f64().unwrap();
                worst.compare(&format!("{key}[{i}]"), name, rho, expected);
            }
        }
        let horch = Horch::default().run(&subject).unwrap();
        for (key, found) in [
            ("tau_l", horch.tau_left),
            ("tau_r", horch.tau_right),
            ("r0", horch.r0),
            ("ropt", horch.r_opt),
            ("dtau", horch.delta_tau),
            ("drho", horch.delta_rho),
        ] {
            worst.compare(key, name, found, expected["horch"][key].as_f64().unwrap());
        }
    }
    worst.print();
}

/// Recordings that are not part of the project; without them there is nothing to compare. The reference
/// looked at the first 20,000 samples of each.
#[test]
fn recorded_loops() {
    let folder: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "../../../shared/data/isdb"].iter().collect();
    if !folder.is_dir() {
        println!("skipped: there are no recordings");
        return;
    }
    let table = Table::fixture("detect/isdb_oracle_indices.csv");
    let mut worst = Worst::default();
    for row in 0..table.len() {
        let name = table.text(row, "loop");
        let mut reader = csv::Reader::from_path(folder.join(format!("{name}.csv"))).unwrap();
        let headers = reader.headers().unwrap().clone();
        let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let column = |wanted: &str| -> Option<Vec<f64>> {
            let at = headers.iter().position(|h| h == wanted)?;
            Some(records.iter().take(20_000).map(|r| r[at].parse().unwrap()).collect())
        };
        let expected = |key: &str| table.text(row, key).parse::<f64>().unwrap();
        let op = column("op").unwrap();
        let index = CurveFit::default().fit("OP", &op).map(|r| r.statistic);
        if expected("he_SI_op_raw").is_nan() {
            assert!(index.is_err());
        } else {
            worst.compare("he_SI_op_raw", name, index.unwrap(), expected("he_SI_op_raw"));
        }
        let Some(pv) = column("pv") else { continue };
        let segment = segment(&op, &pv, None);
        let subject = Subject::new(&segment, LoopType::Unknown, None);
        let index = CurveFit::default().fit("PV", &pv).unwrap().statistic;
        worst.compare("he_SI_pv_raw", name, index, expected("he_SI_pv_raw"));
        let ratio = AreaRatio::default().run(&subject).unwrap().statistic;
        worst.compare("area_ratio_pv", name, ratio, expected("area_ratio_pv"));
        let patterns = Yamashita::default().run(&subject).unwrap();
        for (key, rho) in
            [("rho1", patterns.statistic), ("rho2", patterns.rho2), ("rho3", patterns.rho3)]
        {
            worst.compare(key, name, rho, expected(key));
        }
        let horch = Horch::default().run(&subject).unwrap();
        worst.compare("horch_dtau", name, horch.delta_tau, expected("horch_dtau"));
        worst.compare("horch_drho", name, horch.delta_rho, expected("horch_drho"));
    }
    worst.print();
}
