//! Exact limit cycles.
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use stiction::Bands;
use stiction::closed_loop::{Controller, Process};
use stiction::limit_cycle::{ContinuousLoop, exact};
use stiction::valve::Model;

fn one_cycle(c: &mut Criterion) {
    let paper = |model, j| {
        ContinuousLoop::new(
            Controller::pi(1.1, 2.5).unwrap(),
            Process::first_order(1.5, 5.93, 1.07).unwrap(),
            model,
            Bands::from_s_j(5.0, j).unwrap(),
        )
    };
    let second_order = ContinuousLoop {
        controller: Controller::pid(1.0, 12.0, 1.5).unwrap(),
        process: Process::second_order(1.5, 8.0, 4.0, 2.0).unwrap(),
        ..paper(Model::TwoPhase, 3.0)
    };
    let mut group = c.benchmark_group("limit_cycle/exact");
    for (name, l) in [
        ("first order, J/S = 0.2", paper(Model::TwoPhase, 1.0)),
        ("first order, J/S = 0.6", paper(Model::TwoPhase, 3.0)),
        ("first order, J/S = 1", paper(Model::TwoPhase, 5.0)),
        ("first order, He", paper(Model::He, 3.0)),
        ("second order, PID", second_order),
    ] {
        group.bench_function(name, |b| b.iter(|| exact::cycle(black_box(&l)).unwrap()));
    }
    group.bench_function("first order, all cycles", |b| {
        let l = paper(Model::TwoPhase, 3.0);
        b.iter(|| exact::cycles(black_box(&l)).unwrap());
    });
    group.finish();
}

criterion_group!(benches, one_cycle);
criterion_main!(benches);
