//! Describing functions, harmonic balance, and robust tunings.
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use stiction_model::Bands;
use stiction_model::closed_loop::{Controller, Process};
use stiction_model::limit_cycle::{
    ContinuousLoop, DescribingFunction, FrequencyResponse, harmonic_balance, tuning,
};
use stiction_model::valve::Model;

/// The paper's loop.
fn paper(model: Model) -> ContinuousLoop {
    ContinuousLoop::new(
        Controller::pi(1.1, 2.5).unwrap(),
        Process::first_order(1.5, 5.93, 1.07).unwrap(),
        model,
        Bands::from_s_j(5.0, 2.0).unwrap(),
    )
}

fn frequency_domain(c: &mut Criterion) {
    let mut group = c.benchmark_group("limit_cycle_df");
    let continuous = paper(Model::TwoPhase);
    let valve = DescribingFunction::new(continuous.model, continuous.bands).unwrap();
    group.bench_function("gain", |b| b.iter(|| valve.at(black_box(4.0))));
    group.bench_function("margins", |b| {
        b.iter(|| FrequencyResponse::of(black_box(&continuous)).map(|response| response.margins()));
    });
    group.bench_function("two-phase", |b| b.iter(|| harmonic_balance(black_box(&continuous))));
    let he = paper(Model::He);
    group.bench_function("he", |b| b.iter(|| harmonic_balance(black_box(&he))));
    let grid = tuning::TuningGrid::about(&continuous.controller, 5.0, 20).unwrap();
    group.sample_size(10);
    group.bench_function("least swing of 400 tunings", |b| {
        let cycle = tuning::by_describing_function;
        b.iter(|| tuning::least_swing(black_box(&continuous), &grid, 1.7, cycle));
    });
    group.finish();
}

criterion_group!(benches, frequency_domain);
criterion_main!(benches);
