//! The parts of a loop against their closed forms, and the paper's claims about the whole.

use crate::common;

use common::{Input, bits, correlation, deviation, max_difference, mean, valve};
use stiction_model::Error;
use stiction_model::closed_loop::{
    AntiWindup, Cascade, ClosedLoop, Controller, DeadTime, DerivativeOn, Form, Handover, Manual,
    NormalStream, Process, Run, Signal, Wave, period, sweep,
};
use stiction_model::valve::{Assembly, Model};

fn ideal() -> Assembly {
    valve(Model::Ideal, 0.0, 0.0)
}

/// What `process` alone makes of `input`: the controller does nothing, the load is the input.
fn response(process: &Process, dead_time: DeadTime, ts: f64, input: &[f64]) -> Vec<f64> {
    let mut it = ClosedLoop::new(Controller::p(0.0).unwrap(), ideal(), process.clone());
    it.load = vec![Signal::Samples(input.to_vec())];
    it.dead_time = dead_time;
    it.sample_time = ts;
    it.samples = input.len();
    it.run().unwrap().pv
}

/// What `controller` alone answers to `sp` and `pv`: the process does nothing.
fn answer(controller: &Controller, ts: f64, sp: &[f64], pv: &[f64]) -> Vec<f64> {
    let nothing = Process::integrator(0.0, 0.0).unwrap();
    let mut it = ClosedLoop::new(controller.clone(), ideal(), nothing);
    it.set_point = Signal::Samples(sp.to_vec());
    it.measurement = vec![Signal::Samples(pv.to_vec())];
    it.sample_time = ts;
    it.samples = sp.len();
    it.run().unwrap().op
}

/// The paper's loop with a valve of `model`: 6,000 samples of 0.1 s, the set point stepping to 5.
fn paper_loop(model: Model, s: f64, j: f64) -> ClosedLoop {
    let mut it = ClosedLoop::new(
        Controller::pi(1.1, 2.5).unwrap(),
        valve(model, s, j),
        Process::first_order(1.5, 5.93, 1.07).unwrap(),
    );
    it.set_point = 5.0.into();
    it
}

mod manual {
    use super::*;

    /// The loop with two spells in manual, from 100 s to 120 s and from 200 s to 230 s.
    fn by_hand() -> ClosedLoop {
        let mut it = paper_loop(Model::TwoPhase, 5.0, 3.0);
        let change = Signal::Steps(vec![(100.0, 2.0), (110.0, -1.0), (200.0, 4.0)]);
        it.manual = [(100.0, 120.0), (200.0, 230.0)]
            .map(|(from_s, until_s)| Manual { from_s, until_s, change: change.clone() })
            .to_vec();
        it
    }

    #[test]
    fn the_output_is_the_last_one_and_the_change() {
        let (automatic, run) = (paper_loop(Model::TwoPhase, 5.0, 3.0).run(), by_hand().run());
        let (automatic, run) = (automatic.unwrap(), run.unwrap());
        assert_eq!(bits(&automatic.op[..1000]), bits(&run.op[..1000]));
        let before = run.op[999];
        assert!(run.op[1000..1100].iter().all(|op| *op == before + 2.0));
        assert!(run.op[1100..1200].iter().all(|op| *op == before - 1.0));
        assert!(run.op[2000..2300].iter().all(|op| *op == run.op[1999] + 4.0));
        let in_manual = (0..6000).filter(|k| by_hand().in_manual(*k)).count();
        assert_eq!(in_manual, 500);
    }

    /// 3 times 0.7 s is a little less than 2.1 s.
    #[test]
    fn it_begins_with_the_sample_of_its_time() {
        let mut it = by_hand();
        it.sample_time = 0.7;
        it.samples = 100;
        for k in 1..60 {
            let at = f64::from(k) * 7.0 / 10.0;
            it.manual = vec![Manual {
                from_s: at,
                until_s: f64::from(k + 2) * 7.0 / 10.0,
                change: Signal::step(0.0, 5.0, at),
            }];
            let own: Vec<usize> = (0..100).filter(|k| it.in_manual(*k)).collect();
            assert_eq!(own, [k as usize, k as usize + 1]);
            let run = it.run().unwrap();
            assert_eq!(run.op[k as usize], run.op[k as usize - 1] + 5.0);
        }
    }

    #[test]
    fn automatic_continues_without_a_bump() {
        let run = by_hand().run().unwrap();
        for k in [1200, 2300] {
            // One sample of the controller: the proportional part moves with the PV, the integral by the error.
            let error = run.sp[k] - run.pv[k];
            let next = run.op[k - 1] - 1.1 * (run.pv[k] - run.pv[k - 1]) + 1.1 / 2.5 * 0.1 * error;
            assert!((run.op[k] - next).abs() < 1e-9, "{} against {next}", run.op[k]);
        }
    }

    #[test]
    fn it_stays_within_the_limits() {
        let mut it = by_hand();
        it.manual[1].change = 40.0.into();
        it.controller = it.controller.with_limits(0.0, 5.0, AntiWindup::Clamping).unwrap();
        let run = it.run().unwrap();
        assert!(run.op.iter().all(|op| (0.0..=5.0).contains(op)));
        assert!(run.op[2000..2300].contains(&5.0));
    }

    #[test]
    fn what_cannot_be_simulated_is_refused() {
        let refused = |change: fn(&mut ClosedLoop), expected: &str| {
            let mut it = by_hand();
            change(&mut it);
            let error = it.run().unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
            assert_eq!(error, it.check().unwrap_err().to_string());
        };
        refused(|it| it.manual[1].from_s = 110.0, "manual from is 110, but must be at least 120 s");
        refused(|it| it.manual[0].until_s = 90.0, "manual until is 90, but must be above");
        refused(|it| it.manual[0].from_s = f64::NAN, "begin of manual");
        refused(|it| it.manual[0].change = f64::NAN.into(), "signal value");
        let error = sweep(&[by_hand()]).unwrap_err().to_string();
        assert!(error.contains("number of periods in manual is 2, but must be 0 here"), "{error}");
    }
}

mod process {
    use super::*;

    /// A process's name, itself without dead time, and its unit step response.
    type Known = (&'static str, fn(f64) -> Process, fn(f64) -> f64);

    /// Time constants 1 to 8 s.
    fn eighth_order(dead_time: f64) -> Process {
        let mut den = vec![1.0];
        for tau in 1..=8 {
            let mut product = vec![0.0; den.len() + 1];
            for (i, c) in den.iter().enumerate() {
                product[i] += c * f64::from(tau);
                product[i + 1] += c;
            }
            den = product;
        }
        Process::transfer_function(&[1.0], &den, dead_time).unwrap()
    }

    const KNOWN: [Known; 6] = [
        (
            "first order",
            |theta| Process::first_order(1.5, 5.93, theta).unwrap(),
            |t| 1.5 * (1.0 - (-t / 5.93).exp()),
        ),
        (
            "second order",
            |theta| Process::second_order(2.0, 3.0, 0.5, theta).unwrap(),
            |t| 2.0 * (1.0 - (3.0 * (-t / 3.0).exp() - 0.5 * (-t / 0.5).exp()) / 2.5),
        ),
        ("integrator", |theta| Process::integrator(0.3, theta).unwrap(), |t| 0.3 * t),
        (
            "underdamped",
            |theta| Process::transfer_function(&[4.0], &[1.0, 0.8, 4.0], theta).unwrap(),
            |t| {
                let (decay, w) = (0.4, (4.0f64 - 0.16).sqrt());
                1.0 - (-decay * t).exp() * ((w * t).cos() + decay / w * (w * t).sin())
            },
        ),
        (
            "with feedthrough",
            |theta| Process::transfer_function(&[3.0, 4.0], &[1.0, 2.0], theta).unwrap(),
            |t| 2.0 + (-2.0 * t).exp(),
        ),
        ("order 8", eighth_order, |t| {
            let part = |i: i32| {
                let others = (1..=8).filter(|j| *j != i).map(|j| f64::from(i - j));
                let tau = f64::from(i);
                tau.powi(7) / others.product::<f64>() * (-t / tau).exp()
            };
            1.0 - (1..=8).map(part).sum::<f64>()
        }),
    ];

    /// Exact at every sample, for long and short samples, whole and fractional dead times.
    #[test]
    fn step_responses_are_exact() {
        let mut worst: f64 = 0.0;
        for (name, process, step) in KNOWN {
            for ts in [0.02, 0.1, 0.7, 3.0] {
                for dead_time in [0.0, 2.1, 1.07, 0.013] {
                    let found = response(&process(dead_time), DeadTime::Exact, ts, &[1.0; 200]);
                    for (k, y) in found.iter().enumerate() {
                        let t = k as f64 * ts - dead_time;
                        // The output is read just before the input changes it.
                        let expected = if t > 1e-9 { step(t) } else { 0.0 };
                        let error = (y - expected).abs();
                        assert!(error < 1e-9, "{name}, Ts = {ts}, {dead_time} s: {error:e}");
                        worst = worst.max(error);
                    }
                }
            }
        }
        println!("largest error: {worst:e}");
    }

    /// Any input, held over each sample: short samples tell the same as long ones.
    #[test]
    fn long_samples_tell_what_short_ones_do() {
        let coarse = Input::new(3, 5, 300);
        let fine: Vec<f64> = coarse.iter().flat_map(|v| [*v; 10]).collect();
        for (name, process, _) in KNOWN {
            let process = process(0.137);
            let expected: Vec<f64> =
                response(&process, DeadTime::Exact, 0.01, &fine).into_iter().step_by(10).collect();
            let found = response(&process, DeadTime::Exact, 0.1, &coarse);
            assert!(max_difference(&found, &expected) < 1e-9, "{name}");
        }
    }

    #[test]
    fn nearest_rounds_the_dead_time() {
        let input = Input::new(3, 6, 200);
        for (given, rounded) in [(1.07, 1.1), (1.04, 1.0), (0.04, 0.0)] {
            let process = |dead_time| Process::first_order(1.5, 5.93, dead_time).unwrap();
            assert_eq!(
                bits(&response(&process(given), DeadTime::Nearest, 0.1, &input)),
                bits(&response(&process(rounded), DeadTime::Exact, 0.1, &input))
            );
        }
    }

    #[test]
    fn first_order_is_its_transfer_function() {
        let input = Input::new(0, 7, 500);
        let direct = Process::first_order(1.5, 5.93, 1.07).unwrap();
        // Scaled, and with a leading zero in the numerator.
        let general = Process::transfer_function(&[0.0, 3.0], &[11.86, 2.0], 1.07).unwrap();
        let [a, b] = [direct, general].map(|p| response(&p, DeadTime::Exact, 0.1, &input));
        assert!(max_difference(&a, &b) < 1e-12);
    }
}

mod controller {
    use super::*;

    const TS: f64 = 0.1;

    fn signals() -> (Input, Input) {
        (Input::new(0, 1, 500), Input::new(0, 2, 500))
    }

    #[test]
    fn parallel_form_is_isa_form() {
        let (sp, pv) = signals();
        let isa = Controller::pid(2.0, 4.0, 0.5).unwrap();
        let parallel = Controller::parallel(2.0, 0.5, 1.0).unwrap().with_filter(0.05).unwrap();
        assert_eq!(isa.gains(), (2.0, 0.5, 1.0));
        assert_eq!(bits(&answer(&isa, TS, &sp, &pv)), bits(&answer(&parallel, TS, &sp, &pv)));
    }

    /// The textbook sums, sample by sample.
    #[test]
    fn positional_form_is_its_equation() {
        let (sp, pv) = signals();
        let (kp, ki, kd, tf, b) = (1.7, 0.4, 0.9, 0.2, 0.6);
        for (what, weight) in [(DerivativeOn::Pv, 0.0), (DerivativeOn::Error, 1.0)] {
            let controller = Controller::parallel(kp, ki, kd).unwrap();
            let controller = controller.with_filter(tf).unwrap().with_derivative_on(what);
            let controller = controller.with_set_point_weight(b).unwrap();
            let found = answer(&controller, TS, &sp, &pv);
            let (mut integral, mut derivative) = (0.0, 0.0);
            for k in 0..sp.len() {
                integral += ki * TS * (sp[k] - pv[k]);
                if k > 0 {
                    let change = weight * (sp[k] - sp[k - 1]) - (pv[k] - pv[k - 1]);
                    derivative = (tf * derivative + kd * change) / (tf + TS);
                }
                let expected = kp * (b * sp[k] - pv[k]) + integral + derivative;
                assert!((found[k] - expected).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn velocity_form_is_positional_form_without_limits() {
        let (sp, pv) = signals();
        for handover in [Handover::Cold, Handover::Bumpless] {
            let positional = Controller::pid(1.4, 3.0, 0.6).unwrap().with_handover(handover);
            let velocity = positional.clone().with_form(Form::Velocity);
            let [a, b] = [positional, velocity].map(|c| answer(&c, TS, &sp, &pv));
            assert!(max_difference(&a, &b) < 1e-9, "{handover:?}");
        }
    }

    /// On a ramp of the PV the filtered derivative approaches `-kd` times its slope as a
    /// first-order lag does.
    #[test]
    fn derivative_is_filtered() {
        let (kd, tf) = (2.0, 0.5);
        let controller = Controller::parallel(0.0, 0.0, kd).unwrap().with_filter(tf).unwrap();
        let pv: Vec<f64> = (0..100).map(|k| 0.3 * k as f64 * TS).collect();
        let found = answer(&controller, TS, &[0.0; 100], &pv);
        for (k, u) in found.iter().enumerate() {
            let expected = -kd * 0.3 * (1.0 - (tf / (tf + TS)).powi(k as i32));
            assert!((u - expected).abs() < 1e-12, "{k}: {u}");
        }
    }

    /// The first outputs after a start at an operating point with a control error.
    #[test]
    fn cold_start_kicks_and_bumpless_does_not() {
        let (kc, ti, error) = (1.1, 2.5, 4.0);
        let first = |handover, form| {
            let pi = Controller::pi(kc, ti).unwrap().with_handover(handover).with_form(form);
            let mut it = paper_loop(Model::Ideal, 0.0, 0.0);
            it.controller = pi;
            (it.op_rest, it.pv_rest, it.set_point) = (40.0, 60.0, Signal::Constant(60.0 + error));
            it.run().unwrap().op[0]
        };
        let slope = kc / ti * TS * error;
        for form in [Form::Positional, Form::Velocity] {
            let close = |found: f64, expected: f64| (found - expected).abs() < 1e-12;
            assert!(close(first(Handover::Cold, form), 40.0 + kc * error + slope));
            assert!(close(first(Handover::Bumpless, form), 40.0 + slope));
        }
    }

    /// A set point out of reach for 100 s, then one within reach: how long the PV takes to come
    /// down, s. The output must stay within its limits.
    fn recovery_s(controller: Controller) -> f64 {
        let mut it = paper_loop(Model::Ideal, 0.0, 0.0);
        it.controller = controller;
        it.set_point = Signal::step(20.0, 5.0, 100.0);
        let run = it.run().unwrap();
        assert!(run.op.iter().all(|u| (0.0..=10.0).contains(u)));
        assert!((run.pv[5999] - 5.0).abs() < 1e-3);
        let down = run.pv.iter().skip(1000).position(|y| *y < 6.0).unwrap();
        down as f64 * it.sample_time
    }

    #[test]
    fn anti_windup_recovers_faster() {
        let pi = |what| Controller::pi(1.1, 2.5).unwrap().with_limits(0.0, 10.0, what).unwrap();
        let wound_up = recovery_s(pi(AntiWindup::None));
        assert!(wound_up > 50.0, "{wound_up}");
        for quick in [
            pi(AntiWindup::Clamping),
            pi(AntiWindup::BackCalculation(2.5)),
            pi(AntiWindup::None).with_form(Form::Velocity),
        ] {
            let time = recovery_s(quick.clone());
            assert!(time < 15.0, "{quick:?}: {time}");
        }
    }

    /// Without integral action there is nothing to wind up, and nothing to drive back.
    #[test]
    fn proportional_control_is_only_clipped() {
        let (sp, pv) = signals();
        let clipped: Vec<f64> =
            sp.iter().zip(pv.iter()).map(|(r, y)| (1.5 * (r - y)).clamp(-5.0, 5.0)).collect();
        for what in [AntiWindup::None, AntiWindup::Clamping, AntiWindup::BackCalculation(1.0)] {
            let p = Controller::p(1.5).unwrap().with_limits(-5.0, 5.0, what).unwrap();
            assert_eq!(answer(&p, TS, &sp, &pv), clipped, "{what:?}");
        }
    }

    /// A negative gain answers the other way round, limits and all.
    #[test]
    fn direct_action_is_reverse_action_mirrored() {
        let (sp, pv) = signals();
        let mirrored = |signal: &[f64]| signal.iter().map(|v| -v).collect::<Vec<_>>();
        let pi = |kc, what| Controller::pi(kc, 3.0).unwrap().with_limits(-5.0, 5.0, what).unwrap();
        for what in [AntiWindup::None, AntiWindup::Clamping, AntiWindup::BackCalculation(1.0)] {
            let direct = answer(&pi(-1.5, what), TS, &sp, &pv);
            let reverse = answer(&pi(1.5, what), TS, &mirrored(&sp), &mirrored(&pv));
            assert_eq!(direct, reverse);
        }
    }
}

mod surroundings {
    use super::*;

    #[test]
    fn quantised_signals_are_multiples() {
        let mut it = paper_loop(Model::TwoPhase, 3.0, 1.0);
        (it.op_quantum, it.pv_quantum) = (0.25, 0.125);
        it.measurement = vec![Signal::Noise { sd: 0.2, tau_s: 0.0, seed: 3 }];
        let run = it.run().unwrap();
        assert!(run.op.iter().all(|u| u % 0.25 == 0.0));
        assert!(run.pv.iter().all(|y| y % 0.125 == 0.0));
        assert!(deviation(&run.op) > 0.25 && deviation(&run.pv) > 0.125);
    }

    /// A load is balanced by the controller: the valve moves by as much the other way.
    #[test]
    fn load_is_balanced() {
        let mut it = paper_loop(Model::Ideal, 0.0, 0.0);
        (it.op_rest, it.pv_rest, it.set_point) = (50.0, 20.0, Signal::Constant(20.0));
        it.load = vec![Signal::step(0.0, 3.0, 100.0), 1.0.into()];
        let run = it.run().unwrap();
        assert!((run.vp[999] - 49.0).abs() < 1e-6 && (run.vp[5999] - 46.0).abs() < 1e-6);
        assert!((run.pv[5999] - 20.0).abs() < 1e-6);
        assert!(run.pv[1000..1100].iter().any(|y| *y > 21.0));
    }

    fn cascade(model: Model, s: f64, j: f64) -> Cascade {
        let mut slave = paper_loop(model, s, j);
        slave.controller = Controller::pi(1.0, 1.5).unwrap();
        slave.process = Process::first_order(1.0, 1.5, 0.2).unwrap();
        (slave.op_rest, slave.pv_rest, slave.set_point) = (40.0, 30.0, Signal::Constant(30.0));
        Cascade {
            slave,
            controller: Controller::pi(1.2, 20.0).unwrap(),
            process: Process::first_order(2.0, 20.0, 1.0).unwrap(),
            set_point: Signal::step(70.0, 74.0, 10.0),
            measurement: vec![],
            pv_rest: 70.0,
            every: 5,
        }
    }

    #[test]
    fn cascade_settles_and_its_slave_follows() {
        let run = cascade(Model::Ideal, 0.0, 0.0).run().unwrap();
        assert_eq!((run.pv[0], run.slave.pv[0], run.slave.op[0]), (70.0, 30.0, 40.0));
        assert!((run.pv[5999] - 74.0).abs() < 1e-6);
        assert!((run.slave.pv[5999] - 32.0).abs() < 1e-6);
        // The master moves the slave's set point at every fifth sample, the slave comes after.
        let moves = |k: &usize| run.slave.sp[*k] != run.slave.sp[*k - 1];
        assert!((1..200).filter(moves).all(|k| k % 5 == 0));
        assert!((1..200).filter(moves).count() > 15);
        // A second or two later the slave's PV is where the master wants it.
        let behind = |from| max_difference(&run.slave.sp[from..], &run.slave.pv[from..]);
        assert!(behind(100) > 2.0 && behind(200) < 0.5 && behind(500) < 0.02);
        // A sticking valve makes both cycle.
        let sticky = cascade(Model::TwoPhase, 6.0, 4.0).run().unwrap();
        assert!(deviation(&sticky.pv[3000..]) > 0.01 && deviation(&sticky.slave.pv[3000..]) > 0.1);
    }

    /// Under a master that does nothing the slave is a loop of its own.
    #[test]
    fn slave_without_master_is_a_loop() {
        let mut it = cascade(Model::TwoPhase, 6.0, 4.0);
        it.controller = Controller::p(0.0).unwrap();
        it.slave.measurement = vec![Signal::Noise { sd: 0.1, tau_s: 0.0, seed: 4 }];
        it.slave.set_point = Signal::step(30.0, 35.0, 50.0);
        assert_eq!(it.run().unwrap().slave, it.slave.run().unwrap());
        it.every = 0;
        assert!(it.run().unwrap_err().to_string().contains("must be at least 1"));
    }
}

mod signals {
    use super::*;

    fn sampled(signal: Signal, ts: f64, n: usize) -> Vec<f64> {
        signal.sample(ts, n).unwrap()
    }

    fn periodic(wave: Wave, phase: f64) -> Signal {
        Signal::Periodic { wave, mean: 3.0, amplitude: 2.0, period_s: 8.0, phase }
    }

    #[test]
    fn signals_are_their_closed_forms() {
        let close = |a: Vec<f64>, b: &[f64]| assert!(max_difference(&a, b) < 1e-12, "{a:?}");
        close(sampled(2.5.into(), 1.0, 2), &[2.5, 2.5]);
        close(
            sampled(periodic(Wave::Ramp, 0.0), 1.0, 10),
            &[3.0, 4.0, 5.0, 4.0, 3.0, 2.0, 1.0, 2.0, 3.0, 4.0],
        );
        close(sampled(periodic(Wave::Ramp, 0.25), 1.0, 3), &[5.0, 4.0, 3.0]);
        let root = 2f64.sqrt();
        close(sampled(periodic(Wave::Sine, 0.0), 1.0, 5), &[3.0, 3.0 + root, 5.0, 3.0 + root, 3.0]);
        close(
            sampled(periodic(Wave::Square, 0.0), 1.0, 9),
            &[5.0, 5.0, 5.0, 5.0, 1.0, 1.0, 1.0, 1.0, 5.0],
        );
        close(sampled(Signal::step(1.0, 2.0, 0.3), 0.1, 5), &[1.0, 1.0, 1.0, 2.0, 2.0]);
        close(
            sampled(Signal::Steps(vec![(1.0, 5.0), (2.5, 6.0), (2.6, 7.0)]), 1.0, 5),
            &[5.0, 5.0, 5.0, 7.0, 7.0],
        );
        close(
            sampled(Signal::Line { start: 1.0, slope_per_s: -0.5, from_s: 2.0 }, 1.0, 5),
            &[1.0, 1.0, 1.0, 0.5, 0.0],
        );
        close(
            sampled(Signal::Staircase { start: 10.0, step: 2.0, dwell_s: 2.0, steps: 2 }, 1.0, 12),
            &[10.0, 10.0, 12.0, 12.0, 14.0, 14.0, 12.0, 12.0, 10.0, 10.0, 12.0, 12.0],
        );
        close(sampled(Signal::Samples(vec![1.0, 4.0, 2.0]), 1.0, 2), &[1.0, 4.0]);
    }

    /// Changes given at a whole number of samples fall on it, whatever the rounding of the times.
    #[test]
    fn changes_do_not_slip_by_a_sample() {
        for ts in [0.1, 0.01, 0.3, 0.7, 1.0 / 3.0, 0.05] {
            for half in [1, 3, 5, 7, 10] {
                let period_s = 2.0 * f64::from(half) * ts;
                let square = Signal::Periodic {
                    wave: Wave::Square,
                    mean: 0.0,
                    amplitude: 1.0,
                    period_s,
                    phase: 0.0,
                };
                let stairs = Signal::Staircase {
                    start: 0.0,
                    step: 1.0,
                    dwell_s: f64::from(half) * ts,
                    steps: 1,
                };
                for (signal, first) in [(square, 1.0), (stairs, 0.0)] {
                    let found = sampled(signal.clone(), ts, 5000);
                    for (k, v) in found.iter().enumerate() {
                        let even = (k / half as usize).is_multiple_of(2);
                        assert_eq!(*v == first, even, "{signal:?}, Ts = {ts}, sample {k}");
                    }
                }
            }
        }
    }

    #[test]
    fn noise_has_its_statistics() {
        let n = 200_000;
        let root = (n as f64).sqrt();
        let (ts, sd) = (0.1, 0.7);
        for tau_s in [0.0, 0.3, 2.0] {
            let noise = sampled(Signal::Noise { sd, tau_s, seed: 11 }, ts, n);
            let kept = if tau_s > 0.0 { (-ts / tau_s).exp() } else { 0.0 };
            // Correlated samples count for fewer.
            let fewer = ((1.0 + kept) / (1.0 - kept)).sqrt();
            assert!(mean(&noise).abs() < 4.0 * sd * fewer / root);
            assert!((deviation(&noise) / sd - 1.0).abs() < 4.0 * fewer / root);
            let next = correlation(&noise[1..], &noise[..n - 1]);
            assert!((next - kept).abs() < 4.0 * (1.0 - kept * kept).sqrt() / root, "{next}");
        }
        let walk = sampled(Signal::RandomWalk { sd_per_sqrt_s: 0.5, seed: 12 }, 0.25, n);
        assert_eq!(walk[0], 0.0);
        let steps: Vec<f64> = walk.windows(2).map(|w| w[1] - w[0]).collect();
        assert!((deviation(&steps) / 0.25 - 1.0).abs() < 4.0 / root);
    }

    #[test]
    fn streams_depend_on_their_seed_only() {
        let noise = |seed| bits(&sampled(Signal::Noise { sd: 1.0, tau_s: 0.0, seed }, 0.1, 100));
        assert_eq!(noise(1), noise(1));
        assert_ne!(noise(1), noise(2));
        // Version 1 of the stream: published results were made with these numbers.
        let mut stream = NormalStream::new(1);
        let first: Vec<f64> = (0..3).map(|_| stream.draw()).collect();
        assert_eq!(first, [0.8439986136221761, 0.7155607127305931, -1.9158714436187585]);

        let mut it = paper_loop(Model::TwoPhase, 3.0, 1.0);
        it.measurement = vec![Signal::Noise { sd: 0.1, tau_s: 1.0, seed: 5 }];
        assert_eq!(it.run().unwrap(), it.run().unwrap());
    }
}

mod periods {
    use super::*;

    #[test]
    fn period_of_a_sine_is_its_own() {
        let sine: Vec<f64> = (0..3000).map(|k| (k as f64 * 0.0731).sin() + 8.0).collect();
        let expected = std::f64::consts::TAU / 0.0731 * 0.1;
        let found = period(&sine, 0.1, 0.0).unwrap().unwrap();
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} against {expected}");
        assert_eq!(period(&sine[..150], 0.1, 0.0).unwrap(), None);

        // Noise makes more crossings; its band keeps them out.
        let noise = Signal::Noise { sd: 0.15, tau_s: 0.0, seed: 1 }.sample(0.1, 3000).unwrap();
        let noisy: Vec<f64> = sine.iter().zip(&noise).map(|(a, b)| a + b).collect();
        assert!(period(&noisy, 0.1, 0.0).unwrap().unwrap() < 0.9 * expected);
        let found = period(&noisy, 0.1, 0.45).unwrap().unwrap();
        assert!((found / expected - 1.0).abs() < 1e-2, "{found} against {expected}");
    }

    #[test]
    fn period_refuses_what_it_cannot_use() {
        assert!(period(&[], 0.1, 0.0).unwrap_err().to_string().contains("signal has 0 samples"));
        assert!(period(&[0.0, f64::NAN], 0.1, 0.0).is_err());
        assert!(period(&[0.0], 0.0, 0.0).unwrap_err().to_string().contains("sample time is 0"));
        assert!(period(&[0.0], 1.0, -0.1).unwrap_err().to_string().contains("noise band is -0.1"));
    }
}

/// What is refused, and a part of the sentence that says why.
#[test]
fn invalid_settings_are_refused() {
    let pi = || Controller::pi(1.0, 1.0).unwrap();
    let ten = || vec![1.0; 11];
    let number = |result: stiction_model::Result<Controller>| result.map(drop);
    let mut table: Vec<(stiction_model::Result<()>, &str)> = vec![
        (number(Controller::pi(1.0, 0.0)), "Ti is 0, but must be a finite number above 0"),
        (number(Controller::pid(1.0, 1.0, -1.0)), "Td is -1"),
        (number(Controller::parallel(1.0, f64::INFINITY, 0.0)), "Ki is inf"),
        (number(Controller::parallel(1.0, 0.0, f64::NAN)), "Kd is NaN"),
        (number(pi().with_filter(-0.1)), "derivative filter time is -0.1"),
        (number(pi().with_set_point_weight(f64::NAN)), "set-point weight is NaN"),
        (number(pi().with_limits(1.0, 1.0, AntiWindup::None)), "must be below the upper limit"),
        (number(pi().with_limits(f64::NAN, 1.0, AntiWindup::None)), "must be below"),
        (
            number(pi().with_limits(0.0, 1.0, AntiWindup::BackCalculation(0.0))),
            "tracking time is 0",
        ),
        (Process::first_order(1.0, 0.0, 0.0).map(drop), "process time constant is 0"),
        (Process::first_order(f64::NAN, 1.0, 0.0).map(drop), "process gain is NaN"),
        (Process::first_order(1.0, 1.0, -0.1).map(drop), "process dead time is -0.1"),
        (Process::second_order(1.0, 1.0, 0.0, 0.0).map(drop), "second process time constant is 0"),
        (Process::integrator(1.0, f64::INFINITY).map(drop), "process dead time is inf"),
        (Process::transfer_function(&[1.0], &[0.0, 1.0], 0.0).map(drop), "leading coefficient"),
        (Process::transfer_function(&[1.0], &[], 0.0).map(drop), "leading coefficient"),
        (Process::transfer_function(&[], &[1.0], 0.0).map(drop), "between 1 and 1"),
        (Process::transfer_function(&[1.0; 3], &[1.0; 2], 0.0).map(drop), "must be proper"),
        (Process::transfer_function(&[1.0], &ten(), 0.0).map(drop), "of order 10, but at most 8"),
        (
            Process::transfer_function(&[1.0], &[1.0, f64::NAN], 0.0).map(drop),
            "sample 1 of process denominator is NaN",
        ),
    ];
    let change = |f: fn(&mut ClosedLoop)| {
        let mut it = paper_loop(Model::TwoPhase, 2.0, 1.0);
        f(&mut it);
        let sentence = |error: Error| error.to_string();
        assert_eq!(
            it.run().map(drop).map_err(sentence),
            it.statistics().map(drop).map_err(sentence)
        );
        it.run().map(drop)
    };
    fn signal(it: &mut ClosedLoop, signal: Signal) {
        it.set_point = signal;
    }
    table.extend([
        (change(|l| l.sample_time = 0.0), "sample time is 0"),
        (change(|l| l.sample_time = f64::NAN), "sample time is NaN"),
        (change(|l| l.sample_time = 1e-8), "more than 10 million samples"),
        (change(|l| l.op_quantum = -1.0), "OP quantum is -1"),
        (change(|l| l.pv_quantum = f64::NAN), "PV quantum is NaN"),
        (change(|l| l.op_rest = f64::NAN), "operating point of the OP is NaN"),
        (change(|l| l.pv_rest = f64::INFINITY), "operating point of the PV is inf"),
        (change(|l| l.load = vec![f64::NAN.into()]), "signal value is NaN"),
        (
            change(|l| {
                l.process = Process::transfer_function(&[1.0], &[1.0, -1e5], 0.0).unwrap();
            }),
            "it overflows",
        ),
        (change(|l| signal(l, Signal::Steps(vec![]))), "at least one (time, value) pair"),
        (
            change(|l| signal(l, Signal::Steps(vec![(1.0, 0.0), (1.0, 2.0)]))),
            "must ascend, but 1 s follows 1 s",
        ),
        (change(|l| signal(l, Signal::Samples(vec![0.0; 5999]))), "signal has 5999 samples"),
        (change(|l| signal(l, Signal::Noise { sd: -1.0, tau_s: 0.0, seed: 0 })), "deviation is -1"),
        (change(|l| signal(l, Signal::Noise { sd: 1.0, tau_s: -1.0, seed: 0 })), "time is -1"),
        (
            change(|l| signal(l, Signal::RandomWalk { sd_per_sqrt_s: -1.0, seed: 0 })),
            "random walk standard deviation is -1",
        ),
        (
            change(|l| {
                signal(l, Signal::Staircase { start: 0.0, step: 1.0, dwell_s: 1.0, steps: 0 })
            }),
            "number of stairs is 0",
        ),
        (
            change(|l| {
                let (wave, mean, amplitude, period_s, phase) = (Wave::Sine, 0.0, 1.0, 0.0, 0.0);
                signal(l, Signal::Periodic { wave, mean, amplitude, period_s, phase });
            }),
            "signal period is 0",
        ),
    ]);
    for (result, part) in table {
        let error: Error = result.expect_err(part);
        assert!(error.to_string().contains(part), "{error} / {part}");
    }
}

/// No samples and one sample are no special case.
#[test]
fn short_runs_are_runs() {
    for samples in 0..5 {
        let mut it = paper_loop(Model::TwoPhase, 2.0, 1.0);
        it.samples = samples;
        let run = it.run().unwrap();
        assert_eq!(run.pv.len(), samples);
        assert_eq!(run.period_s(), None);
        assert_eq!(run.growth(), None);
        let statistics = it.statistics().unwrap();
        assert!(statistics.error_rms.is_finite() && statistics.travel_per_s.is_finite());
    }
}

/// What the paper says of its loop, in numbers.
mod paper {
    use super::*;

    fn cycle(s: f64, j: f64) -> Run {
        paper_loop(Model::TwoPhase, s, j).run().unwrap()
    }

    #[test]
    fn dead_band_alone_makes_no_cycle() {
        let run = cycle(5.0, 0.0);
        assert!(run.growth().unwrap() < 0.9);
        assert!(run.half_pp(&run.pv) < 0.2);
        assert!((cycle(5.0, 1.0).growth().unwrap() - 1.0).abs() < 0.01);
    }

    #[test]
    fn stronger_slip_jump_cycles_wider_and_faster() {
        let cycles: Vec<(f64, f64)> = (1..=7)
            .map(|j| cycle(5.0, f64::from(j)))
            .map(|run| (run.half_pp(&run.pv), run.period_s().unwrap()))
            .collect();
        assert!(cycles.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 > w[1].1), "{cycles:?}");
    }

    #[test]
    fn amplitude_is_proportional_to_stiction() {
        let (one, four) = (cycle(2.0, 1.0), cycle(8.0, 4.0));
        assert!((four.half_pp(&four.pv) / one.half_pp(&one.pv) / 4.0 - 1.0).abs() < 0.02);
        assert!((four.period_s().unwrap() / one.period_s().unwrap() - 1.0).abs() < 0.01);
    }

    /// Root-mean-square distance from the closest shape of the same mean, amplitude and phase,
    /// relative to the standard deviation; `shape` takes the phase in periods.
    fn misfit(signal: &[f64], period: f64, shape: fn(f64) -> f64) -> f64 {
        let best = (0..200)
            .map(|lead| {
                let at = |k: usize| shape((k as f64 / period + f64::from(lead) / 200.0).fract());
                let fitted: Vec<f64> = (0..signal.len()).map(at).collect();
                correlation(signal, &fitted)
            })
            .fold(0.0, f64::max);
        (1.0 - best * best).sqrt()
    }

    #[test]
    fn valve_is_rectangular_and_pv_triangular() {
        let square = |p: f64| if p < 0.5 { 1.0 } else { -1.0 };
        let triangle = |p: f64| if p < 0.5 { 4.0 * p - 1.0 } else { 3.0 - 4.0 * p };
        let sine = |p: f64| (std::f64::consts::TAU * p).sin();
        let run = cycle(5.0, 2.0);
        let period = run.period_s().unwrap() / run.sample_time;
        let (vp, pv) = (&run.vp[3000..], &run.pv[3000..]);
        let resting = vp.windows(2).filter(|w| w[0] == w[1]).count() as f64 / vp.len() as f64;
        assert!(resting > 0.6, "at rest {resting} of the time");
        assert!(misfit(vp, period, square) < misfit(vp, period, sine));
        assert!(misfit(vp, period, square) < misfit(vp, period, triangle));
        assert!(misfit(pv, period, triangle) < misfit(pv, period, square));
        assert!(misfit(pv, period, triangle) < 0.2, "{}", misfit(pv, period, triangle));
    }

    /// OP against PV: an open curve, neither a line (area 0) nor a rectangle, with turning points
    /// where the valve slips.
    #[test]
    fn op_over_pv_is_an_ellipse() {
        let run = cycle(5.0, 2.0);
        let samples = (run.period_s().unwrap() / run.sample_time).round() as usize;
        let (op, pv) = (&run.op[3000..=3000 + samples], &run.pv[3000..=3000 + samples]);
        let area: f64 =
            (0..samples).map(|k| (pv[k] * op[k + 1] - pv[k + 1] * op[k]) / 2.0).sum::<f64>().abs();
        let box_area = 4.0 * run.half_pp(&run.op) * run.half_pp(&run.pv);
        let share = area / box_area;
        assert!(share > 0.3 && share < std::f64::consts::FRAC_PI_4 + 0.05, "{share}");
        assert!(correlation(op, pv).abs() < 0.7, "{}", correlation(op, pv));
    }
}
