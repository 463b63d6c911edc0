//! Exact limit cycles, and maps of them.
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use stiction_model::Bands;
use stiction_model::closed_loop::{Controller, Process};
use stiction_model::limit_cycle::map::{Axis, Map, Parameter};
use stiction_model::limit_cycle::{ContinuousLoop, Method, exact};
use stiction_model::valve::Model;

/// The paper's loop.
fn paper(model: Model, j: f64) -> ContinuousLoop {
    ContinuousLoop::new(
        Controller::pi(1.1, 2.5).unwrap(),
        Process::first_order(1.5, 5.93, 1.07).unwrap(),
        model,
        Bands::from_s_j(5.0, j).unwrap(),
    )
}

fn one_cycle(c: &mut Criterion) {
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

/// 200 by 200 points, on all threads.
fn maps(c: &mut Criterion) {
    let mut group = c.benchmark_group("limit_cycle/map");
    group.sample_size(10);
    let l = paper(Model::TwoPhase, 3.0);
    let axis = |parameter, from, to| Axis::even(parameter, from, to, 200).unwrap();
    for (name, x, y) in [
        ("S and J", axis(Parameter::S, 1.0, 10.0), axis(Parameter::J, 0.0, 6.0)),
        ("Kc and Ti", axis(Parameter::Kc, 0.1, 6.0), axis(Parameter::Ti, 0.5, 20.0)),
        (
            "J/S and theta/tau",
            axis(Parameter::JOverS, 0.0, 1.4),
            axis(Parameter::DeadTimeOverLag, 0.02, 2.0),
        ),
    ] {
        for method in [Method::Exact, Method::DescribingFunction] {
            group.bench_function(format!("{name}, {}", method.name()), |b| {
                b.iter(|| Map::of(black_box(&l), x.clone(), y.clone(), method).unwrap());
            });
        }
    }
    group.finish();
}

criterion_group!(benches, one_cycle, maps);
criterion_main!(benches);
