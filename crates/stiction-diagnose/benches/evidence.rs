//! What a window says about its valve: made ready, and all features but the model's.
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use stiction_diagnose::evidence::{Evidence, Prepared};
use stiction_diagnose::recording::Segment;
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Signal};
use stiction_model::valve::{Assembly, Model};

/// A sticky loop with noise that cycles every 40 samples or so.
fn sticky(samples: usize) -> Segment {
    let model = Model::TwoPhase.build(Bands::from_s_j(5.0, 3.0).unwrap()).unwrap();
    let mut sticky = ClosedLoop::new(
        Controller::pi(1.1, 2.5).unwrap(),
        Assembly::new(model),
        Process::first_order(1.5, 5.93, 1.07).unwrap(),
    );
    sticky.set_point = 5.0.into();
    sticky.sample_time = 0.5;
    sticky.samples = samples;
    sticky.measurement = vec![Signal::Noise { sd: 0.05, tau_s: 0.0, seed: 1 }];
    let run = sticky.run().unwrap();
    Segment {
        from: 0.0,
        sample_time: 0.5,
        op: run.op,
        pv: Some(run.pv),
        sp: Some(run.sp),
        vp: None,
        bridged: 0,
    }
}

fn evidence(c: &mut Criterion) {
    let mut group = c.benchmark_group("evidence");
    for samples in [1_000, 4_000] {
        let segment = sticky(samples);
        group.throughput(Throughput::Elements(samples as u64)).sample_size(30);
        group.bench_function(BenchmarkId::new("prepared", samples), |b| {
            b.iter(|| Prepared::of(black_box(&segment)).unwrap());
        });
        group.bench_function(BenchmarkId::new("all but the model", samples), |b| {
            b.iter(|| Evidence::of(black_box(&segment)).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, evidence);
criterion_main!(benches);
