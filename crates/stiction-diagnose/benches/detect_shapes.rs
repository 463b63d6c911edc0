//! The shape and correlation detectors, each alone and all together.
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use stiction_diagnose::finding::{Decision, Finding};
use stiction_diagnose::methods::area_ratio::AreaRatio;
use stiction_diagnose::methods::curve_fit::CurveFit;
use stiction_diagnose::methods::horch::Horch;
use stiction_diagnose::methods::horch_density::HorchDensity;
use stiction_diagnose::methods::kano::Kano;
use stiction_diagnose::methods::relay_fit::RelayFit;
use stiction_diagnose::methods::square_wave::SquareWave;
use stiction_diagnose::methods::valve_position::ValvePosition;
use stiction_diagnose::methods::yamashita::{Follower, Yamashita};
use stiction_diagnose::methods::yamashita_level::YamashitaLevel;
use stiction_diagnose::methods::{Detector, Subject};
use stiction_diagnose::recording::{LoopType, Segment};
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Signal};
use stiction_model::valve::{Assembly, Model};

/// A sticky loop with noise; samples of 0.5 s.
fn sticky(process: Process, samples: usize) -> Segment {
    let model = Model::TwoPhase.build(Bands::from_s_j(5.0, 3.0).unwrap()).unwrap();
    let mut sticky =
        ClosedLoop::new(Controller::pi(1.1, 2.5).unwrap(), Assembly::new(model), process);
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
        vp: Some(run.vp),
        bridged: 0,
    }
}

fn detectors() -> Vec<(LoopType, Box<dyn Detector>)> {
    let vp = Yamashita { follower: Follower::Vp, ..Yamashita::default() };
    vec![
        (LoopType::Flow, Box::new(AreaRatio::default())),
        (LoopType::Flow, Box::new(CurveFit::default())),
        (LoopType::Flow, Box::new(Horch::default())),
        (LoopType::Level, Box::new(HorchDensity::default())),
        (LoopType::Flow, Box::new(Kano::default())),
        (LoopType::Flow, Box::new(RelayFit::default())),
        (LoopType::Flow, Box::new(SquareWave::default())),
        (LoopType::Flow, Box::new(ValvePosition::default())),
        (LoopType::Flow, Box::new(Yamashita::default())),
        (LoopType::Flow, Box::new(vp)),
        (LoopType::Level, Box::new(YamashitaLevel::default())),
    ]
}

fn shapes(c: &mut Criterion) {
    let process = Process::first_order(1.5, 5.93, 1.07).unwrap();
    for samples in [2_000, 121_000] {
        let segment = sticky(process.clone(), samples);
        let mut group = c.benchmark_group(format!("detect/shapes, {samples} samples"));
        group.throughput(Throughput::Elements(samples as u64)).sample_size(20);
        for (loop_type, each) in detectors() {
            let finding = each.judge(&Subject::new(&segment, loop_type, Some(36.0)));
            assert!(finding.decision != Decision::Abstains, "{}", finding.reason);
            group.bench_function(each.method().name, |b| {
                b.iter(|| each.judge(&Subject::new(black_box(&segment), loop_type, Some(36.0))));
            });
        }
        let all = detectors();
        group.bench_function("all", |b| {
            b.iter(|| {
                let judge = |(loop_type, each): &(LoopType, Box<dyn Detector>)| {
                    each.judge(&Subject::new(black_box(&segment), *loop_type, Some(36.0)))
                };
                all.iter().map(judge).collect::<Vec<Finding>>()
            });
        });
        group.finish();
    }
    // One half wave is a third of the recording.
    let slow: Vec<f64> = (0..121_000).map(|k| (f64::from(k) * 8e-5).sin()).collect();
    let fit = CurveFit::default();
    c.bench_function("detect/curve-fit, half waves of 39,000 samples", |b| {
        b.iter(|| fit.fit("OP", black_box(&slow)));
    });
}

criterion_group!(benches, shapes);
criterion_main!(benches);
