//! Valve models: one at a time, and many candidates together.
use criterion::{Bencher, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Instant;
use stiction_model::valve::{Model, Start, TwoPhase, Valve, lanes};
use stiction_model::{Bands, valve::He};

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

/// Times `run` inside `pool`: entering it takes some 40 us, whatever is run.
fn within<R>(b: &mut Bencher<'_>, pool: &rayon::ThreadPool, run: impl Fn() -> R + Sync) {
    b.iter_custom(|times| {
        pool.install(|| {
            let begin = Instant::now();
            for _ in 0..times {
                black_box(run());
            }
            begin.elapsed()
        })
    });
}

/// The last positions of every candidate.
fn many_candidates(c: &mut Criterion) {
    let bands: Vec<Bands> = (0..160)
        .map(|i| Bands::from_s_j(0.1 + 0.05 * i as f64, 0.02 * i as f64).unwrap())
        .collect();
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut group = c.benchmark_group("valve/lanes");
    for samples in [2_000, SAMPLES] {
        let op = &input()[..samples];
        group.throughput(Throughput::Elements((samples * bands.len()) as u64));
        let begin = |_| lanes::Lane::splat(0.0);
        let last = |kept: &mut lanes::Lane, _, vp: &[lanes::Lane]| *kept = vp[vp.len() - 1];
        let start = Start::at_rest(50.0);
        let what = format!("160 candidates, {samples} samples, 1 thread");
        group.bench_function(format!("two-phase, {what}"), |b| {
            let run =
                || lanes::run::<TwoPhase, _>(black_box(&bands), start, op, begin, last).unwrap();
            within(b, &one_thread, run);
        });
        group.bench_function(format!("he, {what}"), |b| {
            let run = || lanes::run::<He, _>(black_box(&bands), start, op, begin, last).unwrap();
            within(b, &one_thread, run);
        });
    }
    group.finish();
}

criterion_group!(benches, one_valve, many_candidates);
criterion_main!(benches);
