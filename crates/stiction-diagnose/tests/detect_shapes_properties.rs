//! What holds for every shape and correlation detector, whatever the numbers.

use proptest::prelude::*;
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
use stiction_diagnose::series;
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, NormalStream, Process, Signal, Wave};
use stiction_model::valve::{Assembly, Model, Valve};

fn detectors() -> Vec<Box<dyn Detector>> {
    vec![
        Box::new(Horch::default()),
        Box::new(HorchDensity::default()),
        Box::new(AreaRatio::default()),
        Box::new(CurveFit::default()),
        Box::new(RelayFit::default()),
        Box::new(SquareWave::default()),
        Box::new(Yamashita::default()),
        Box::new(Yamashita { follower: Follower::Vp, ..Yamashita::default() }),
        Box::new(YamashitaLevel::default()),
        Box::new(Kano::default()),
        Box::new(ValvePosition::default()),
    ]
}

fn detector(name: &str) -> Box<dyn Detector> {
    detectors().into_iter().find(|each| each.method().name == name).unwrap()
}

/// A loop under stiction or a sinusoidal load.
fn recorded(process: Process, kc: f64, ti: f64, s: f64, j: f64, load: f64, noise: f64) -> Segment {
    let model = Model::TwoPhase.build(Bands::from_s_j(s, j).unwrap()).unwrap();
    let mut simulated =
        ClosedLoop::new(Controller::pi(kc, ti).unwrap(), Assembly::new(model), process);
    simulated.sample_time = 0.2;
    simulated.samples = 3000;
    simulated.set_point = 5.0.into();
    let wave = Wave::Sine;
    simulated.load =
        vec![Signal::Periodic { wave, mean: 0.0, amplitude: load, period_s: 25.0, phase: 0.0 }];
    simulated.measurement = vec![Signal::Noise { sd: noise, tau_s: 0.0, seed: 5 }];
    let run = simulated.run().unwrap();
    let tail = |x: &[f64]| x[1000..].to_vec();
    Segment {
        from: 0.0,
        sample_time: 0.2,
        op: tail(&run.op),
        pv: Some(tail(&run.pv)),
        sp: Some(tail(&run.sp)),
        vp: Some(tail(&run.vp)),
        bridged: 0,
    }
}

fn flow(s: f64, j: f64, load: f64, noise: f64) -> Segment {
    recorded(Process::first_order(1.0, 1.0, 0.6).unwrap(), 0.3, 1.0, s, j, load, noise)
}

fn level(s: f64, j: f64, load: f64, noise: f64) -> Segment {
    recorded(Process::integrator(0.1, 0.4).unwrap(), 1.5, 20.0, s, j, load, noise)
}

/// Twice the median length of the PV's half waves, samples.
fn period(segment: &Segment) -> Option<f64> {
    let pv = segment.pv.as_ref()?;
    let lengths: Vec<f64> =
        series::half_waves(&series::centred(pv)).iter().map(|wave| wave.length()).collect();
    (!lengths.is_empty()).then(|| 2.0 * series::median(&lengths))
}

fn judge(name: &str, segment: &Segment, loop_type: LoopType) -> Finding {
    let finding = detector(name).judge(&Subject::new(segment, loop_type, period(segment)));
    println!("{name:16} {:16} {}", finding.decision.name(), finding.reason);
    finding
}

#[test]
fn a_sticky_flow_loop_is_found() {
    // Without noise the valve would creep to the set point and never stop.
    let sticky = flow(5.0, 3.0, 0.0, 0.01);
    for each in detectors() {
        judge(each.method().name, &sticky, LoopType::Flow);
    }
    for name in ["area-ratio", "curve-fit", "relay-fit", "yamashita", "yamashita-vp", "direct"] {
        assert_eq!(judge(name, &sticky, LoopType::Flow).decision, Decision::Sticks, "{name}");
    }
    for name in ["horch", "kano", "square-wave"] {
        let decision = judge(name, &sticky, LoopType::Flow).decision;
        assert!(decision != Decision::Abstains, "{name}");
    }
    for name in ["horch-density", "yamashita-level"] {
        assert_eq!(judge(name, &sticky, LoopType::Flow).decision, Decision::Abstains, "{name}");
    }
}

#[test]
fn a_disturbed_flow_loop_is_left_alone() {
    let disturbed = flow(0.0, 0.0, 3.0, 0.0);
    for each in detectors() {
        let finding = judge(each.method().name, &disturbed, LoopType::Flow);
        assert!(finding.decision != Decision::Sticks, "{}", finding.reason);
    }
}

#[test]
fn level_loops() {
    for noise in [0.0, 0.01] {
        let (sticky, disturbed) = (level(5.0, 3.0, 0.0, noise), level(0.0, 0.0, 3.0, noise));
        for name in ["curve-fit", "horch-density", "yamashita-level", "direct"] {
            let finding = judge(name, &sticky, LoopType::Level);
            assert_eq!(finding.decision, Decision::Sticks, "{name}");
            let finding = judge(name, &disturbed, LoopType::Level);
            // The position of an ideal valve is a copy of the OP, and no measurement.
            let expected =
                if name == "direct" { Decision::Abstains } else { Decision::DoesNotStick };
            assert_eq!(finding.decision, expected, "{name}");
        }
    }
    for name in ["horch", "area-ratio", "relay-fit", "square-wave", "yamashita"] {
        let finding = judge(name, &level(5.0, 3.0, 0.0, 0.0), LoopType::Level);
        assert_eq!(finding.decision, Decision::Abstains, "{name}");
    }
}

/// The canonical shapes, as OP and PV a quarter of a period apart.
#[test]
fn canonical_shapes_get_their_verdicts() {
    let segment = |pv: &dyn Fn(f64) -> f64, op: &dyn Fn(f64) -> f64| {
        let column =
            |f: &dyn Fn(f64) -> f64| (0..4000).map(|k| f((f64::from(k) + 0.3) / 161.31)).collect();
        let (op, pv): (Vec<f64>, Vec<f64>) = (column(op), column(pv));
        Segment {
            from: 0.0,
            sample_time: 1.0,
            op,
            pv: Some(pv),
            sp: Some(vec![0.0; 4000]),
            vp: None,
            bridged: 0,
        }
    };
    let sine = |p: f64| (std::f64::consts::TAU * p).sin();
    let triangle = |p: f64| 2.0 / std::f64::consts::PI * sine(p).asin();
    let square = |p: f64| sine(p).signum();
    let lag = |p: f64| {
        let (ratio, t) = (2.0, (2.0 * p).rem_euclid(1.0));
        let first = (1.0 - f64::exp(-ratio)) / (1.0 + f64::exp(-ratio));
        square(p) * (1.0 - (1.0 + first) * f64::exp(-ratio * t))
    };
    let quarter = |p: f64| triangle(p + 0.25);

    let loop_type = LoopType::Flow;
    let sticky = segment(&square, &quarter);
    for name in ["horch", "curve-fit", "square-wave", "yamashita"] {
        assert_eq!(judge(name, &sticky, loop_type).decision, Decision::Sticks, "{name}");
    }
    let lagging = segment(&lag, &quarter);
    for name in ["area-ratio", "relay-fit", "curve-fit"] {
        assert_eq!(judge(name, &lagging, loop_type).decision, Decision::Sticks, "{name}");
    }
    let smooth = segment(&sine, &|p: f64| -sine(p));
    for name in ["horch", "area-ratio", "curve-fit", "relay-fit", "square-wave", "yamashita"] {
        assert_eq!(judge(name, &smooth, loop_type).decision, Decision::DoesNotStick, "{name}");
    }
    let level = segment(&triangle, &quarter);
    let wave = segment(&sine, &sine);
    for name in ["curve-fit", "horch-density", "yamashita-level"] {
        let decision = |segment| judge(name, segment, LoopType::Level).decision;
        assert_eq!(decision(&level), Decision::Sticks, "{name}");
        assert_eq!(decision(&wave), Decision::DoesNotStick, "{name}");
    }
}

/// On the position of a valve with nothing but a dead band, method B finds it to its grid.
#[test]
fn kano_finds_a_dead_band() {
    let op: Vec<f64> = (0..5000)
        .map(|k| 50.0 + 8.0 * (f64::from(k) * 0.01).sin() + (f64::from(k) * 0.0234).sin())
        .collect();
    for (model, s, j) in [(Model::Play, 3.0, 0.0), (Model::Ideal, 0.0, 0.0)] {
        let mut valve: Assembly = model.build(Bands::from_s_j(s, j).unwrap()).unwrap().into();
        let mut vp = vec![0.0; op.len()];
        valve.run(&op, &mut vp).unwrap();
        let (op, vp) = (op[1000..].to_vec(), vp[1000..].to_vec());
        let segment = Segment {
            from: 0.0,
            sample_time: 1.0,
            op,
            pv: None,
            sp: None,
            vp: Some(vp),
            bridged: 0,
        };
        let subject = Subject::new(&segment, LoopType::Level, None);
        let found = Kano::default().run(&subject).unwrap();
        assert!((found.width - s).abs() < 0.05, "{}", found.width);
        assert!(found.explained > 0.999 && found.decision == Decision::Undecided);
        assert!(if s > 0.0 { found.statistic > 0.1 } else { found.statistic == 0.0 });
    }
}

/// Scales, offsets, the unit of time and, where the method does not care, the sign of the gain.
#[test]
fn units_make_no_difference() {
    let loops = [
        (LoopType::Flow, flow(5.0, 3.0, 0.0, 0.02)),
        (LoopType::Flow, flow(0.0, 0.0, 3.0, 0.02)),
        (LoopType::Level, level(5.0, 3.0, 0.0, 0.01)),
    ];
    for (loop_type, original) in loops {
        for (scale_pv, offset_pv, scale_op, offset_op, time) in [
            (7.0, 0.0, 1.0, 0.0, 1.0),
            (1e-3, 250.0, 1.0, 0.0, 60.0),
            (-2.5, 3.0, 1.0, 0.0, 1.0),
            (1.0, 0.0, 3.0, -20.0, 1.0 / 3600.0),
            (1e6, 1e5, 0.01, 50.0, 1e3),
        ] {
            let change = |x: &[f64], scale: f64, offset: f64| -> Vec<f64> {
                x.iter().map(|v| scale * v + offset).collect()
            };
            let mut changed = original.clone();
            changed.sample_time *= time;
            changed.op = change(&original.op, scale_op, offset_op);
            let pv = |x: &Option<Vec<f64>>| x.as_ref().map(|x| change(x, scale_pv, offset_pv));
            (changed.pv, changed.sp) = (pv(&original.pv), pv(&original.sp));
            changed.vp = original.vp.as_ref().map(|x| change(x, scale_op, offset_op));
            for each in detectors() {
                let name = each.method().name;
                // In percent, with a threshold in percent.
                if name == "direct" {
                    continue;
                }
                let before = each.judge(&Subject::new(&original, loop_type, period(&original)));
                let after = each.judge(&Subject::new(&changed, loop_type, period(&original)));
                // Patterns have signs: of a loop whose gain is negative they count other jumps, but
                // as many steps without an answer.
                assert_eq!(before.decision, after.decision, "{name}: {}", after.reason);
                match (before.statistic, after.statistic) {
                    (Some(a), Some(b)) => {
                        assert!((a - b).abs() < 1e-6 * a.abs().max(1.0), "{name}: {a} {b}");
                    }
                    (a, b) => assert_eq!(a, b, "{name}"),
                }
            }
        }
    }
}

fn everything_is_judged(segment: &Segment) {
    for loop_type in [LoopType::Flow, LoopType::Level, LoopType::Unknown] {
        for period in [None, Some(12.0), Some(0.0), Some(f64::NAN), Some(1e300), Some(-3.0)] {
            for each in detectors() {
                let finding = each.judge(&Subject::new(segment, loop_type, period));
                assert!(!finding.reason.is_empty());
                assert!(finding.statistic.is_none_or(f64::is_finite), "{}", finding.reason);
                assert_eq!(finding.decision == Decision::Abstains, finding.statistic.is_none());
            }
        }
    }
}

#[test]
fn nothing_panics_on_short_constant_or_extreme_signals() {
    let mut stream = NormalStream::new(3);
    let mut signals: Vec<Vec<f64>> = (0..=6)
        .flat_map(|n| {
            [
                vec![1.0; n],
                (0..n).map(|k| k as f64).collect(),
                (0..n).map(|k| (k % 2) as f64).collect(),
            ]
        })
        .collect();
    for scale in [1.0, 1e-320, 1e-160, 1e160, f64::MAX] {
        signals.push((0..60).map(|k| if k / 7 % 2 == 0 { scale } else { -scale }).collect());
        signals.push((0..200).map(|_| scale * (stream.draw() / 8.0).clamp(-1.0, 1.0)).collect());
        signals.push((0..200).map(|k| scale * (f64::from(k) * 0.3).sin()).collect());
        let mut spike = vec![0.0; 100];
        spike[50] = scale;
        signals.push(spike);
    }
    for x in &signals {
        for reversed in [false, true] {
            let mut y = x.clone();
            if reversed {
                y.reverse();
            }
            for (pv, sp, vp) in [(true, false, false), (true, true, true), (false, false, true)] {
                let some = |given: bool, x: &[f64]| given.then(|| x.to_vec());
                everything_is_judged(&Segment {
                    from: 0.0,
                    sample_time: 1.0,
                    op: x.clone(),
                    pv: some(pv, &y),
                    sp: some(sp, &vec![0.0; y.len()]),
                    vp: some(vp, &y),
                    bridged: 0,
                });
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn nothing_panics_on_anything(
        samples in prop::collection::vec(
            prop_oneof![Just((0.0, 0.0)), (-1.0..1.0, -1.0..1.0), (-3i8..3, -3i8..3).prop_map(
                |(a, b)| (f64::from(a), f64::from(b))
            ), any::<(f64, f64)>()],
            0..80,
        )
    ) {
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        let op: Vec<f64> = samples.iter().map(|s| finite(s.0)).collect();
        let pv: Vec<f64> = samples.iter().map(|s| finite(s.1)).collect();
        everything_is_judged(&Segment {
            from: 0.0,
            sample_time: 1.0,
            vp: Some(pv.clone()),
            sp: None,
            pv: Some(pv),
            op,
            bridged: 0,
        });
    }
}
