//! Closed loops: one at a time, and many in a sweep.
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Signal, sweep};
use stiction_model::valve::{Assembly, Model};

/// The paper's loop with given stiction, statistics over `samples` of 0.1 s.
fn paper_loop(s: f64, j: f64, samples: usize) -> ClosedLoop {
    let model = Model::TwoPhase.build(Bands::from_s_j(s, j).unwrap()).unwrap();
    let mut sticky = ClosedLoop::new(
        Controller::pi(1.1, 2.5).unwrap(),
        Assembly::new(model),
        Process::first_order(1.5, 5.93, 1.07).unwrap(),
    );
    sticky.set_point = 5.0.into();
    sticky.samples = samples;
    sticky
}

/// What a page of straight code makes of the same loop, keeping nothing but the PV's range: the
/// peer of the scalar loop.
fn straight_code(samples: usize) -> (f64, f64) {
    let (kc, ti, gain, tau, ts, delay) = (1.1, 2.5, 1.5, 5.93, 0.1, 11);
    let (fs, fd) = (4.0, 1.0);
    let (ki, a) = (kc / ti * ts, f64::exp(-ts / tau));
    let b = gain * (1.0 - a);
    let mut past = vec![0.0; samples];
    let (mut y, mut integral, mut x, mut motion, mut before) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..samples {
        let e = 5.0 - y;
        integral += ki * e;
        let u = kc * e + integral;
        if motion * (u - before) > 0.0 {
            x = u - motion * fd;
        } else if f64::abs(u - x) > fs {
            motion = f64::signum(u - x);
            x = u - motion * fd;
        } else {
            motion = 0.0;
        }
        before = u;
        past[k] = x;
        (low, high) = (f64::min(low, y), f64::max(high, y));
        y = a * y + b * if k >= delay { past[k - delay] } else { 0.0 };
    }
    (low, high)
}

fn one_loop(c: &mut Criterion) {
    const SAMPLES: usize = 60_000;
    let plain = paper_loop(5.0, 3.0, SAMPLES);
    let mut noisy = plain.clone();
    noisy.measurement = vec![Signal::Noise { sd: 0.05, tau_s: 0.0, seed: 1 }];
    let mut group = c.benchmark_group("closed_loop/scalar");
    group.throughput(Throughput::Elements(SAMPLES as u64));
    group.bench_function("peer: straight code, PV range only", |b| {
        b.iter(|| straight_code(black_box(SAMPLES)));
    });
    group.bench_function("statistics", |b| b.iter(|| black_box(&plain).statistics().unwrap()));
    group.bench_function("every sample kept", |b| b.iter(|| black_box(&plain).run().unwrap()));
    group.bench_function("statistics, noisy", |b| {
        b.iter(|| black_box(&noisy).statistics().unwrap())
    });
    group.finish();
}

fn many_loops(c: &mut Criterion) {
    const SAMPLES: usize = 10_000;
    let grid = |count: usize| -> Vec<ClosedLoop> {
        (0..count)
            .map(|i| {
                let s = 1.0 + 9.0 * (i % 100) as f64 / 100.0;
                paper_loop(s, s * (i / 100) as f64 / count as f64 * 100.0, SAMPLES)
            })
            .collect()
    };
    let mut group = c.benchmark_group("closed_loop/sweep");
    group.sample_size(10);
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let loops = grid(10_000);
        group.throughput(Throughput::Elements((SAMPLES * loops.len()) as u64));
        group.bench_function(format!("10,000 loops of 10,000 samples, {threads} threads"), |b| {
            b.iter(|| pool.install(|| sweep(black_box(&loops)).unwrap()));
        });
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut loops = grid(1_000);
    for (seed, l) in loops.iter_mut().enumerate() {
        l.measurement = vec![Signal::Noise { sd: 0.05, tau_s: 0.0, seed: seed as u64 }];
    }
    group.throughput(Throughput::Elements((SAMPLES * loops.len()) as u64));
    group.bench_function("1,000 noisy loops, 1 thread", |b| {
        b.iter(|| pool.install(|| sweep(black_box(&loops)).unwrap()));
    });
    group.finish();
}

criterion_group!(benches, one_loop, many_loops);
criterion_main!(benches);
