//! Many at once gives what one at a time gives, to the bit.

use crate::common;

use common::{Input, KINDS, bits, follow, valve};
use proptest::prelude::*;
use stiction_model::closed_loop::{
    AntiWindup, ClosedLoop, Controller, DeadTime, Form, Handover, Process, Signal, Statistics,
    Wave, sweep,
};
use stiction_model::valve::lanes::{self, Laned};
use stiction_model::valve::{Direction, He, Model, Start, StemLag, TwoPhase};
use stiction_model::{Bands, Error};

fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// The positions of every candidate, by lanes.
fn by_lanes<M: Laned>(bands: &[Bands], start: Start, op: &[f64]) -> Vec<Vec<u64>> {
    let begin = |first| vec![vec![]; lanes::LANES.min(bands.len() - first)];
    lanes::run::<M, _>(bands, start, op, begin, |positions, at, vp| {
        for (l, positions) in positions.iter_mut().enumerate() {
            assert_eq!(positions.len(), at);
            positions.extend(vp.iter().map(|x| x[l].to_bits()));
        }
    })
    .unwrap()
    .concat()
}

/// The positions of every candidate, one valve at a time.
fn one_by_one<M: Laned>(
    new: fn(Bands) -> M,
    bands: &[Bands],
    start: Start,
    op: &[f64],
) -> Vec<Vec<u64>> {
    let one = |bands: &Bands| {
        let mut valve = new(*bands);
        valve.restart(start);
        bits(&follow(&mut valve, op))
    };
    bands.iter().map(one).collect()
}

/// Any S and J: none, some of either, more J than S.
fn any_bands() -> impl Strategy<Value = Bands> {
    (prop_oneof![Just(0.0), 0.0..8.0], prop_oneof![Just(0.0), 0.0..8.0])
        .prop_map(|(s, j)| Bands::from_s_j(s, j).unwrap())
}

fn any_start() -> impl Strategy<Value = Start> {
    (-5.0..5.0, -5.0..5.0, any::<bool>(), any::<bool>()).prop_map(|(position, op, up, moving)| {
        let direction = if up { Direction::Up } else { Direction::Down };
        Start { position, op, direction, moving }
    })
}

proptest! {
    #![proptest_config(cases(500))]

    #[test]
    fn lanes_are_the_scalar_models(
        bands in prop::collection::vec(any_bands(), 1..50),
        start in any_start(),
        (kind, seed) in (0..KINDS, any::<u64>()),
    ) {
        let op = Input::new(kind, seed, 200);
        prop_assert_eq!(
            by_lanes::<TwoPhase>(&bands, start, &op),
            one_by_one(TwoPhase::new, &bands, start, &op)
        );
        prop_assert_eq!(by_lanes::<He>(&bands, start, &op), one_by_one(He::new, &bands, start, &op));
    }
}

#[test]
fn lanes_refuse_bad_samples() {
    let bands = [Bands::NONE];
    let run = |start, op: &[f64]| {
        lanes::run::<He, _>(&bands, start, op, |_| (), |_, _, _| ()).unwrap_err()
    };
    let error = run(Start::default(), &[0.0, f64::NAN]);
    assert!(matches!(error, Error::NonFinite { index: 1, .. }), "{error}");
    let error = run(Start::at_rest(f64::INFINITY), &[0.0]);
    assert!(matches!(error, Error::Parameter { name: "start position", .. }), "{error}");
    let nothing = lanes::run::<He, _>(&[], Start::default(), &[0.0], |_| (), |_, _, _| ());
    assert!(nothing.unwrap().is_empty());
}

const SAMPLES: usize = 700;

/// Loops of all sorts: every model, order of process, kind of controller, delay and disturbance.
fn any_loop() -> impl Strategy<Value = ClosedLoop> {
    let valve = (prop::sample::select(Model::ALL.to_vec()), 0.0..6.0, 0.0..1.0, 0..5).prop_map(
        |(model, s, ratio, extra)| {
            let plain = valve(model, s, s * ratio);
            match extra {
                0 => plain.with_limits(-20.0, 20.0).unwrap(),
                1 => plain.with_lag(StemLag::new(0.3, 0.1).unwrap()),
                _ => plain,
            }
        },
    );
    let process = (0..6, 0.5..3.0, 1.0..9.0, prop_oneof![Just(1.0), Just(0.0), 0.0..3.0]).prop_map(
        |(kind, gain, tau, dead_time)| match kind {
            0 => Process::integrator(0.1 * gain, dead_time),
            1 => Process::second_order(gain, tau, 0.4 * tau, dead_time),
            2 => Process::transfer_function(&[gain, gain], &[tau, 3.0, 3.0, 1.0], dead_time),
            3 => Process::transfer_function(&[0.1, gain], &[tau, 1.0], dead_time),
            _ => Process::first_order(gain, tau, dead_time),
        },
    );
    let controller = (0..6, 0.2..1.0, 2.0..9.0).prop_map(|(kind, kc, ti)| {
        let pi = Controller::pi(kc, ti).unwrap();
        match kind {
            0 => Controller::pid(kc, ti, 0.4).unwrap(),
            1 => pi.with_form(Form::Velocity).with_limits(-20.0, 20.0, AntiWindup::None).unwrap(),
            2 => pi.with_limits(-9.0, 9.0, AntiWindup::BackCalculation(2.0)).unwrap(),
            3 => pi.with_handover(Handover::Bumpless),
            _ => pi,
        }
    });
    let around = (0..8, any::<u64>(), 0.0..6.0, any::<bool>());
    (valve, process, controller, around).prop_map(|(valve, process, controller, around)| {
        let (extra, seed, sp, exact) = around;
        let mut it = ClosedLoop::new(controller, valve, process.unwrap());
        it.samples = SAMPLES;
        it.set_point = Signal::Constant(sp);
        it.dead_time = if exact { DeadTime::Exact } else { DeadTime::Nearest };
        match extra {
            0 => it.measurement = vec![Signal::Noise { sd: 0.1, tau_s: 0.5, seed }, 0.2.into()],
            1 => it.load = vec![Signal::RandomWalk { sd_per_sqrt_s: 0.1, seed }],
            2 => (it.op_quantum, it.pv_quantum) = (0.1, 0.05),
            3 => (it.op_rest, it.pv_rest) = (40.0, 3.0),
            4 => {
                let (wave, mean, amplitude, period_s, phase) = (Wave::Ramp, sp, 2.0, 17.0, 0.1);
                it.set_point = Signal::Periodic { wave, mean, amplitude, period_s, phase };
            }
            _ => (),
        }
        it
    })
}

/// Statistics as bits.
fn fingerprint(s: &Statistics) -> [u64; 8] {
    [
        s.period_s.unwrap_or(-1.0),
        s.op_half_pp,
        s.vp_half_pp,
        s.pv_half_pp,
        s.error_mean,
        s.error_rms,
        s.error_abs,
        s.travel_per_s,
    ]
    .map(f64::to_bits)
}

fn swept(loops: &[ClosedLoop], threads: usize) -> Vec<[u64; 8]> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| sweep(loops)).unwrap().iter().map(fingerprint).collect()
}

proptest! {
    #![proptest_config(cases(60))]

    /// Loops of all sorts at once, in their order, on any number of threads.
    #[test]
    fn sweep_is_the_single_loops(loops in prop::collection::vec(any_loop(), 1..60)) {
        let single: Vec<_> =
            loops.iter().map(|l| fingerprint(&l.statistics().unwrap())).collect();
        prop_assert_eq!(&swept(&loops, 1), &single);
        prop_assert_eq!(&swept(&loops, 2), &single);
    }

    /// Loops alike but for S, J, gains and delays: they share blocks.
    #[test]
    fn sweep_is_the_single_loops_when_they_are_alike(
        he in any::<bool>(),
        each in prop::collection::vec((any_bands(), 0.3..1.2, 0.0..0.5), 1..60),
    ) {
        let model = if he { Model::He } else { Model::TwoPhase };
        let loops: Vec<ClosedLoop> = each
            .into_iter()
            .map(|(bands, kc, dead_time)| {
                let mut it = ClosedLoop::new(
                    Controller::pi(kc, 2.5).unwrap(),
                    model.build(bands).unwrap().into(),
                    Process::first_order(1.5, 5.93, dead_time).unwrap(),
                );
                it.set_point = 5.0.into();
                it.samples = SAMPLES;
                it
            })
            .collect();
        let single: Vec<_> =
            loops.iter().map(|l| fingerprint(&l.statistics().unwrap())).collect();
        prop_assert_eq!(&swept(&loops, 1), &single);
        prop_assert_eq!(&swept(&loops, 2), &single);
    }

    /// The statistics are what can be computed from the kept samples.
    #[test]
    fn statistics_are_those_of_the_run(it in any_loop()) {
        let (run, found) = (it.run().unwrap(), it.statistics().unwrap());
        prop_assert_eq!(found.op_half_pp, run.half_pp(&run.op));
        prop_assert_eq!(found.vp_half_pp, run.half_pp(&run.vp));
        prop_assert_eq!(found.pv_half_pp, run.half_pp(&run.pv));
        let last = SAMPLES / 2..;
        let errors: Vec<f64> =
            run.sp[last.clone()].iter().zip(&run.pv[last.clone()]).map(|(r, y)| r - y).collect();
        let mean = |f: fn(f64) -> f64| errors.iter().map(|e| f(*e)).sum::<f64>() / errors.len() as f64;
        let travel: f64 = run.vp[last].windows(2).map(|w| (w[1] - w[0]).abs()).sum();
        for (found, expected) in [
            (found.error_mean, mean(|e| e)),
            (found.error_rms, mean(|e| e * e).sqrt()),
            (found.error_abs, mean(f64::abs)),
            (found.travel_per_s, travel / (errors.len() as f64 * it.sample_time)),
        ] {
            prop_assert!((found - expected).abs() <= 1e-9 * (1.0 + expected.abs()));
        }
    }
}

#[test]
fn sweep_names_the_loop_it_refuses() {
    let good = ClosedLoop::new(
        Controller::p(1.0).unwrap(),
        valve(Model::TwoPhase, 1.0, 1.0),
        Process::integrator(1.0, 0.0).unwrap(),
    );
    let mut bad = good.clone();
    bad.op_quantum = -1.0;
    let error = sweep(&[good.clone(), good.clone(), bad]).unwrap_err();
    assert!(error.to_string().starts_with("loop 2: OP quantum is -1"), "{error}");
    let mut short = good.clone();
    short.samples = 10;
    let error = sweep(&[good, short]).unwrap_err();
    assert_eq!(error.to_string(), "a loop of the sweep has 10 samples, but 6000 are needed");
    assert!(sweep(&[]).unwrap().is_empty());
}
