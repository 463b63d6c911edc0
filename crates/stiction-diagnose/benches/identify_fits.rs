//! The published fits of a valve before a process, a process alone, and valve models behind a recorded
//! position.
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use stiction_diagnose::identify::{fopdt, jelali, karra_karim, lee, position, srinivasan};
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Run, Signal};
use stiction_model::valve::{Assembly, Model};

/// 1,000 samples of the paper's loop, 50 a period.
fn recorded() -> Run {
    let model = Model::TwoPhase.build(Bands::from_s_j(5.0, 3.0).unwrap()).unwrap();
    let mut plant = ClosedLoop::new(
        Controller::pi(1.1, 2.5).unwrap(),
        Assembly::new(model),
        Process::first_order(1.5, 5.93, 1.07).unwrap(),
    );
    plant.set_point = 5.0.into();
    (plant.sample_time, plant.samples) = (0.36, 1000);
    plant.measurement = vec![Signal::Noise { sd: 0.05, tau_s: 0.0, seed: 1 }];
    plant.run().unwrap()
}

fn fits(c: &mut Criterion) {
    let Run { op, pv, vp, .. } = recorded();
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
    let options = fopdt::Options::default();
    group.bench_function("fopdt", |b| b.iter(|| fopdt::fit(black_box(&op), &pv, 0.36, &options)));
    group.sample_size(20);
    group.bench_function("position", |b| b.iter(|| position::fit(black_box(&op), &vp)));
    group.finish();
}

criterion_group!(benches, fits);
criterion_main!(benches);
