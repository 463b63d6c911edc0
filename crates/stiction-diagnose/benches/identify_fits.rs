//! The published fits of a valve before a process, a process alone, and valve models behind a recorded
//! position.
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, diagnose};
use stiction_diagnose::fit::{FitOptions, fit, prospects};
use stiction_diagnose::identify::{controller, fopdt, position, process};
use stiction_diagnose::methods::model_fit::{jelali, karra_karim, lee, srinivasan};
use stiction_diagnose::recording::Recording;
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Run, Signal};
use stiction_model::valve::{Assembly, Model};

/// So many samples of the paper's loop, 50 a period.
fn recorded(samples: usize) -> Run {
    let model = Model::TwoPhase.build(Bands::from_s_j(5.0, 3.0).unwrap()).unwrap();
    let mut plant = ClosedLoop::new(
        Controller::pi(1.1, 2.5).unwrap(),
        Assembly::new(model),
        Process::first_order(1.5, 5.93, 1.07).unwrap(),
    );
    plant.set_point = 5.0.into();
    (plant.sample_time, plant.samples) = (0.36, samples);
    plant.measurement = vec![Signal::Noise { sd: 0.05, tau_s: 0.0, seed: 1 }];
    plant.run().unwrap()
}

fn fits(c: &mut Criterion) {
    let Run { op, pv, vp, .. } = recorded(1000);
    let period = Some(50.0);
    let mut group = c.benchmark_group("identify_fits");
    group.bench_function("srinivasan", |b| {
        b.iter(|| srinivasan::fit(black_box(&op), &pv, period, srinivasan::LEAST));
    });
    group.bench_function("lee", |b| b.iter(|| lee::fit(black_box(&op), &pv, period, lee::LEAST)));
    group.bench_function("jelali", |b| {
        b.iter(|| jelali::fit(black_box(&op), &pv, period, jelali::LEAST));
    });
    group.bench_function("karra-karim", |b| {
        b.iter(|| karra_karim::fit(black_box(&op), &pv, period, karra_karim::LEAST));
    });
    let options = fopdt::FopdtOptions::default();
    group.bench_function("fopdt", |b| b.iter(|| fopdt::fit(black_box(&op), &pv, 0.36, &options)));
    group.sample_size(20);
    group.bench_function("position", |b| b.iter(|| position::fit(black_box(&op), &vp)));
    group.finish();
}

/// The parts of a loop, and all of it, from 2,000 samples.
fn loops(c: &mut Criterion) {
    let Run { sp, op, pv, vp, .. } = recorded(2000);
    let recording = Recording::regular("", 0.36, &op, Some(&pv), Some(&sp)).unwrap();
    let asked = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let found = diagnose(&recording, &asked).unwrap();
    let segment = found.segment().unwrap();
    let mut group = c.benchmark_group("fit");
    group.sample_size(20);
    group.bench_function("controller", |b| b.iter(|| controller::fit(black_box(segment))));
    group.bench_function("process", |b| {
        b.iter(|| process::fit(black_box(&vp), &pv, 0.36, Some(1.0)));
    });
    let options = FitOptions::default();
    group.bench_function("loop, with 60 draws and their cycles", |b| {
        b.iter(|| fit(black_box(&found), &options));
    });
    let fitted = fit(&found, &options).unwrap();
    group.bench_function("prospects", |b| b.iter(|| prospects(black_box(&fitted))));
    group.finish();
}

criterion_group!(benches, fits, loops);
criterion_main!(benches);
