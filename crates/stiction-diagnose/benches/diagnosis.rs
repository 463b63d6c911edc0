//! What a whole diagnosis takes: grid, fitness, oscillation, all detectors, key figures, verdict.
//!
//! The peer in the same run is the fast Fourier transform of the recording, without which no spectrum
//! or correlation can be had.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use stiction_diagnose::diagnose::{DiagnoseOptions, diagnose};
use stiction_diagnose::methods::{self, Subject};
use stiction_diagnose::recording::{LoopType, Recording};
use stiction_diagnose::series::{Spectrum, fft_length};
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Signal};
use stiction_model::valve::{Assembly, Model};

/// A sticking flow loop of `samples` samples, 5 s apart.
fn recording(samples: usize) -> Recording {
    let valve = Model::TwoPhase.build(Bands::from_s_j(4.0, 2.0).unwrap()).unwrap();
    let mut system = ClosedLoop::new(
        Controller::pi(0.45, 30.0).unwrap(),
        Assembly::new(valve),
        Process::first_order(1.2, 15.0, 5.0).unwrap(),
    );
    (system.sample_time, system.samples) = (5.0, samples);
    (system.op_rest, system.pv_rest, system.set_point) = (45.0, 60.0, 60.0.into());
    system.load = vec![Signal::RandomWalk { sd_per_sqrt_s: 0.01, seed: 1 }];
    system.measurement = vec![Signal::Noise { sd: 0.12, tau_s: 0.0, seed: 2 }];
    let run = system.run().unwrap();
    let mut recording =
        Recording::regular("FIC101", 5.0, &run.op, Some(&run.pv), Some(&run.sp)).unwrap();
    recording.loop_type = LoopType::Flow;
    recording
}

fn diagnosis(c: &mut Criterion) {
    let mut group = c.benchmark_group("diagnosis");
    group.sample_size(20);
    for samples in [2_000, 121_000] {
        let recording = recording(samples);
        group.bench_function(BenchmarkId::new("all", samples), |b| {
            b.iter(|| diagnose(black_box(&recording), &DiagnoseOptions::default()));
        });
        let pv = &recording.pv.as_ref().unwrap().values;
        group.bench_function(BenchmarkId::new("limit: one transform", samples), |b| {
            b.iter(|| Spectrum::of(black_box(pv), fft_length(samples)));
        });
        let found = diagnose(&recording, &DiagnoseOptions::default()).unwrap();
        for detector in methods::all() {
            let name = format!("{}/{samples}", detector.method().name);
            group.bench_function(name, |b| {
                let subject = found.subject().unwrap();
                b.iter(|| {
                    let subject = Subject::new(subject.segment, subject.loop_type, subject.period);
                    detector.judge(black_box(&subject))
                });
            });
        }
    }
}

criterion_group!(benches, diagnosis);
criterion_main!(benches);
