//! Valve models: one at a time, and many candidates together.
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use stiction::valve::{Model, Start, TwoPhase, Valve, lanes};
use stiction::{Bands, valve::He};

const SAMPLES: usize = 10_000;

/// A sine with drift: slides, stops, sticks and slips.
fn input() -> Vec<f64> {
    (0..SAMPLES)
        .map(|k| {
            let t = k as f64;
            50.0 + 12.0 * (t * 0.011).sin() + 3.0 * (t * 0.0037).sin()
        })
        .collect()
}

fn one_valve(c: &mut Criterion) {
    let op = input();
    let mut vp = vec![0.0; SAMPLES];
    let bands = Bands::from_s_j(5.0, 2.0).unwrap();
    let mut group = c.benchmark_group("valve/scalar");
    group.throughput(Throughput::Elements(SAMPLES as u64));
    for model in Model::ALL {
        let mut valve = model.build(bands).unwrap();
        group.bench_function(BenchmarkId::from_parameter(model.describe().name), |b| {
            b.iter(|| {
                valve.restart(Start::at_rest(50.0));
                valve.run(black_box(&op), &mut vp).unwrap();
                black_box(&mut vp);
            });
        });
    }
    group.finish();
}

/// Sixteen lanes of 2,000 samples fit the second-level cache, of 10,000 they do not.
fn many_candidates(c: &mut Criterion) {
    let bands: Vec<Bands> = (0..160)
        .map(|i| Bands::from_s_j(0.1 + 0.05 * i as f64, 0.02 * i as f64).unwrap())
        .collect();
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut group = c.benchmark_group("valve/lanes");
    for samples in [2_000, SAMPLES] {
        let op = &input()[..samples];
        group.throughput(Throughput::Elements((samples * bands.len()) as u64));
        let last = |_, vp: &[lanes::Lane]| vp[samples - 1];
        let start = Start::at_rest(50.0);
        let what = format!("160 candidates, {samples} samples, 1 thread");
        group.bench_function(format!("two-phase, {what}"), |b| {
            let run = || lanes::run::<TwoPhase, _>(black_box(&bands), start, op, last).unwrap();
            b.iter(|| one_thread.install(run));
        });
        group.bench_function(format!("he, {what}"), |b| {
            let run = || lanes::run::<He, _>(black_box(&bands), start, op, last).unwrap();
            b.iter(|| one_thread.install(run));
        });
    }
    group.finish();
}

criterion_group!(benches, one_valve, many_candidates);
criterion_main!(benches);
