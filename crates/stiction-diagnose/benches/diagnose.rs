//! From a recording to its grid, its fitness, its oscillation and its numbers.
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use stiction_diagnose::diagnose::{KpiOptions, Kpis};
use stiction_diagnose::oscillation::{Regularity, analyse};
use stiction_diagnose::recording::{Grid, GridOptions, Recording, fitness};

/// A common export, and four months at a minute or a day and a half at a second.
const LENGTHS: [usize; 2] = [2_000, 121_000];

/// Cycles of 57.3 samples with noise and drift.
fn signal(n: usize, phase: f64) -> Vec<f64> {
    let mut noise = 1u32;
    (0..n)
        .map(|k| {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let t = k as f64;
            50.0 + 5.0 * (t / 57.3 * std::f64::consts::TAU + phase).sin()
                + 2.0 * (t / 5000.0).sin()
                + f64::from(noise >> 8) / f64::from(1 << 24)
        })
        .collect()
}

fn loop_of(n: usize) -> Recording {
    let sp = vec![50.0; n];
    Recording::regular("loop", 1.0, &signal(n, 0.5), Some(&signal(n, 0.0)), Some(&sp)).unwrap()
}

fn recordings(c: &mut Criterion) {
    let mut group = c.benchmark_group("recording");
    for n in LENGTHS {
        group.throughput(Throughput::Elements(n as u64));
        let regular = loop_of(n);
        let mut jittered = regular.clone();
        for time in [&mut jittered.op.time, &mut jittered.pv.as_mut().unwrap().time] {
            time.iter_mut().enumerate().for_each(|(k, t)| *t += 0.1 * ((k * 7) % 5) as f64);
        }
        let options = GridOptions::default();
        for (name, recording) in [("regular", &regular), ("jittered", &jittered)] {
            group.bench_function(BenchmarkId::new(format!("grid/{name}"), n), |b| {
                b.iter(|| Grid::of(black_box(recording), &options).unwrap());
            });
        }
        let grid = Grid::of(&regular, &options).unwrap();
        let segment = grid.longest().unwrap();
        group.bench_function(BenchmarkId::new("fitness", n), |b| {
            b.iter(|| fitness::assess(black_box(&regular), &grid, segment, Some(57.3)));
        });
        group.bench_function(BenchmarkId::new("kpis", n), |b| {
            b.iter(|| Kpis::of(black_box(&regular), &grid, segment, &KpiOptions::default()));
        });
    }
    group.finish();
}

fn oscillations(c: &mut Criterion) {
    let mut group = c.benchmark_group("oscillation");
    for n in LENGTHS {
        group.throughput(Throughput::Elements(n as u64));
        let x = signal(n, 0.0);
        group.bench_function(BenchmarkId::new("regularity", n), |b| {
            b.iter(|| Regularity::of(black_box(&x)));
        });
        group.bench_function(BenchmarkId::new("analyse", n), |b| {
            b.iter(|| analyse(black_box(&x), 1.0));
        });
    }
    group.finish();
}

criterion_group!(benches, recordings, oscillations);
criterion_main!(benches);
