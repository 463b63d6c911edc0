//! The statistical detectors on short and long recordings of a noisy sticky loop.
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use stiction_diagnose::methods::{Subject, all};
use stiction_diagnose::recording::{LoopType, Segment};
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Signal};
use stiction_model::valve::{Assembly, Model};

/// `samples` of the paper's loop at one second.
fn recording(samples: usize) -> Segment {
    let model = Model::TwoPhase.build(Bands::from_s_j(5.0, 3.0).unwrap()).unwrap();
    let mut plant = ClosedLoop::new(
        Controller::pi(1.1, 2.5).unwrap(),
        Assembly::new(model),
        Process::first_order(1.5, 5.93, 1.07).unwrap(),
    );
    plant.set_point = 5.0.into();
    plant.samples = 10 * samples;
    plant.measurement = vec![Signal::Noise { sd: 0.02, tau_s: 0.0, seed: 1 }];
    let run = plant.run().unwrap();
    let every_tenth = |x: &[f64]| x.iter().step_by(10).copied().collect();
    Segment {
        from: 0.0,
        sample_time: 1.0,
        op: every_tenth(&run.op),
        pv: Some(every_tenth(&run.pv)),
        sp: Some(every_tenth(&run.sp)),
        vp: None,
        bridged: 0,
    }
}

fn detectors(c: &mut Criterion) {
    for samples in [2_000, 121_000] {
        let segment = recording(samples);
        let mut group = c.benchmark_group(format!("detect/{samples} samples"));
        group.throughput(Throughput::Elements(samples as u64));
        group.sample_size(10);
        group.warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
        for detector in all() {
            group.bench_function(detector.method().name, |b| {
                b.iter(|| {
                    let subject = Subject::new(black_box(&segment), LoopType::Flow, Some(18.0));
                    detector.judge(&subject)
                });
            });
        }
        group.bench_function("all", |b| {
            b.iter(|| {
                let subject = Subject::new(black_box(&segment), LoopType::Flow, Some(18.0));
                all().iter().map(|detector| detector.judge(&subject)).collect::<Vec<_>>()
            });
        });
        group.finish();
    }
}

criterion_group!(benches, detectors);
criterion_main!(benches);
