//! Cost of the physical stem per simulated segment, with a fixed-step peer and the errors of both.
//!
//! The peer is classical Runge-Kutta of order 4 at 10 us, a third of its stability limit on this
//! valve and the step of the published simulations. Errors are worst positions against the same
//! stem at a tolerance of 1e-12, as fractions of the stroke, printed once before timing.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use stiction_model::stem::friction::LuGre;
use stiction_model::stem::{
    FrictionLaw, ParameterSet, PressureSignal, Stem, StemParameters, StemStart, StemValve,
};
use stiction_model::valve::Valve;

const START: StemStart = StemStart { position_m: 0.0, pressure_pa: None, relaxed: true };

/// The named valve without end stops, as in the reference traces.
fn free(name: &str) -> Stem {
    let set = ParameterSet::named(name).unwrap();
    let parameters = StemParameters { end_stops: false, ..set.stem };
    Stem::new(parameters, set.friction).unwrap()
}

fn triangle(stem: &Stem, duration_s: f64) -> PressureSignal {
    let low = stem.parameters().pressure_pa(0.0);
    let high = stem.parameters().pressure_pa(100.0);
    let quarter = duration_s / 4.0;
    let points = [low, high, low, high, low];
    let points = points.iter().enumerate().map(|(i, p)| (i as f64 * quarter, *p)).collect();
    PressureSignal::from_points(points).unwrap()
}

fn sine_op(t: f64) -> f64 {
    50.0 - 40.0 * (std::f64::consts::TAU * t / 20.0).cos()
}

fn sine(stem: &Stem, duration_s: f64, spacing_s: f64) -> PressureSignal {
    let count = (duration_s / spacing_s).round() as usize;
    let point = |i: usize| {
        let t = i as f64 * spacing_s;
        (t, stem.parameters().pressure_pa(sine_op(t)))
    };
    PressureSignal::from_points((0..=count).map(point).collect()).unwrap()
}

fn times(duration_s: f64, spacing_s: f64) -> Vec<f64> {
    let count = (duration_s / spacing_s).round() as usize;
    (0..=count).map(|i| (i as f64 * spacing_s).min(duration_s)).collect()
}

fn positions(stem: &Stem, pressure: &PressureSignal, times: &[f64]) -> Vec<f64> {
    let response = stem.simulate(pressure, START, times).unwrap();
    response.samples.iter().map(|s| s.position_m).collect()
}

/// Runge-Kutta of order 4 at a fixed step on the LuGre stem, sampled every `every` steps.
fn runge_kutta(
    stem: &Stem,
    law: &LuGre,
    op: fn(f64) -> f64,
    steps: usize,
    every: usize,
) -> Vec<f64> {
    const STEP_S: f64 = 1e-5;
    let p = stem.parameters();
    let rate = |t: f64, y: [f64; 3]| {
        let [x, v, z] = y;
        let dz = v - v.abs() * z * law.stiffness_n_per_m() / law.steady().sliding_n(v);
        let friction = law.stiffness_n_per_m() * z
            + law.damping_n_s_per_m() * dz
            + law.steady().viscous_n_s_per_m() * v;
        [v, (p.net_force_n(p.pressure_pa(op(t)), x) - friction) / p.mass_kg, dz]
    };
    let ahead = |y: [f64; 3], k: [f64; 3], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    let mut y = [0.0; 3];
    let mut sampled = vec![y[0]];
    for step in 0..steps {
        let t = step as f64 * STEP_S;
        let k1 = rate(t, y);
        let k2 = rate(t + STEP_S / 2.0, ahead(y, k1, STEP_S / 2.0));
        let k3 = rate(t + STEP_S / 2.0, ahead(y, k2, STEP_S / 2.0));
        let k4 = rate(t + STEP_S, ahead(y, k3, STEP_S));
        let mean: [f64; 3] =
            std::array::from_fn(|i| (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0);
        y = ahead(y, mean, STEP_S);
        if (step + 1) % every == 0 {
            sampled.push(y[0]);
        }
    }
    sampled
}

fn worst(a: &[f64], b: &[f64], stroke_m: f64) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs() / stroke_m).fold(0.0, f64::max)
}

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("stem");
    group.sample_size(10).measurement_time(Duration::from_secs(3));

    let lugre = free("usp-lugre");
    let exact = lugre.with_tolerance(1e-12).unwrap();
    let stroke = lugre.parameters().stroke_m;
    let FrictionLaw::LuGre(law) = *lugre.friction() else { unreachable!() };

    for (name, pressure, duration) in [
        ("lugre usp, triangle 400 s", triangle(&lugre, 400.0), 400.0),
        ("lugre usp, sine 60 s", sine(&lugre, 60.0, 0.5), 60.0),
    ] {
        let times = times(duration, 0.25);
        let truth = positions(&exact, &pressure, &times);
        for tolerance in [1e-8, 1e-6] {
            let stem = lugre.with_tolerance(tolerance).unwrap();
            let error = worst(&positions(&stem, &pressure, &times), &truth, stroke);
            println!("{name}, tolerance {tolerance:e}: error {error:.1e} of stroke");
            group.bench_function(format!("{name}, tolerance {tolerance:e}"), |b| {
                b.iter(|| stem.simulate(black_box(&pressure), START, &times).unwrap());
            });
        }
    }

    // One simulated second of the peer; its input is the sine itself.
    let fine = sine(&lugre, 1.0, 1e-3);
    let truth = positions(&exact, &fine, &times(1.0, 0.25));
    let peer = || runge_kutta(&lugre, &law, sine_op, 100_000, 25_000);
    println!("peer, 1 s: error {:.1e} of stroke", worst(&peer(), &truth, stroke));
    group.bench_function("peer: lugre usp, Runge-Kutta at 10 us, sine 1 s", |b| b.iter(peer));

    for name in ["cts", "cts-stribeck", "usp", "usp-gms", "usp-graphite-lugre"] {
        let stem = free(name);
        let pressure = triangle(&stem, 400.0);
        let times = times(400.0, 0.25);
        let truth = positions(&stem.with_tolerance(1e-12).unwrap(), &pressure, &times);
        let error = worst(&positions(&stem, &pressure, &times), &truth, stem.parameters().stroke_m);
        println!("{name}, triangle 400 s: error {error:.1e} of stroke");
        group.bench_function(format!("{name}, triangle 400 s"), |b| {
            b.iter(|| stem.simulate(black_box(&pressure), START, &times).unwrap());
        });
    }

    for name in ["cts", "cts-stribeck", "usp-lugre"] {
        let valve = StemValve::new(Stem::named(name).unwrap(), 0.1).unwrap();
        let op: Vec<f64> = (0..600).map(|i| sine_op(f64::from(i) * 0.1)).collect();
        let mut vp = vec![0.0; op.len()];
        group.bench_function(format!("{name} as a valve, sine 60 s at 0.1 s"), |b| {
            b.iter_batched(
                || valve.clone(),
                |mut valve| valve.run(black_box(&op), &mut vp).unwrap(),
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
