//! A sticking valve weighed against one that follows.
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use stiction_diagnose::identify::hammerstein::{HammersteinOptions, weigh};
use stiction_diagnose::series::standardised;
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Signal};
use stiction_model::valve::{Assembly, Model};

/// OP and PV of the paper's loop, 50 samples a period.
fn recorded(samples: usize) -> (Vec<f64>, Vec<f64>) {
    let model = Model::TwoPhase.build(Bands::from_s_j(5.0, 3.0).unwrap()).unwrap();
    let mut plant = ClosedLoop::new(
        Controller::pi(1.1, 2.5).unwrap(),
        Assembly::new(model),
        Process::first_order(1.5, 5.93, 1.07).unwrap(),
    );
    plant.set_point = 5.0.into();
    (plant.sample_time, plant.samples) = (0.36, 200 + samples);
    plant.measurement = vec![Signal::Noise { sd: 0.05, tau_s: 0.0, seed: 1 }];
    let run = plant.run().unwrap();
    let of = |x: &[f64]| standardised(&x[200..]).unwrap();
    (of(&run.op), of(&run.pv))
}

fn weighing(c: &mut Criterion) {
    let options = HammersteinOptions::default();
    let mut group = c.benchmark_group("identify/weigh");
    for samples in [300, 1000, 2000] {
        let (op, pv) = recorded(samples);
        group.throughput(Throughput::Elements(samples as u64));
        group.bench_function(BenchmarkId::from_parameter(samples), |b| {
            b.iter(|| weigh(black_box(&op), &pv, 50.0, &options));
        });
    }
    group.finish();
}

criterion_group!(benches, weighing);
criterion_main!(benches);
