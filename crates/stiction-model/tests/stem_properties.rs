//! What must hold for any stem, whatever the input.

use proptest::prelude::*;
use stiction_model::Error;
use stiction_model::stem::friction::{
    Armstrong, Classical, Dahl, Gms, GmsElement, Karnopp, LAWS, LuGre,
};
use stiction_model::stem::{
    Event, EventKind, FrictionLaw, ParameterSet, PressureSignal, SETS, SlidingKind, Stem,
    StemParameters, StemStart, StemValve,
};
use stiction_model::valve::{Direction, Start, Valve};

fn cts() -> StemParameters {
    ParameterSet::named("cts").unwrap().stem
}

fn classical(static_n: f64, coulomb_n: f64, viscous: f64, stribeck: f64) -> FrictionLaw {
    FrictionLaw::Classical(Classical::new(static_n, coulomb_n, viscous, stribeck).unwrap())
}

/// Every law, with friction of the CTS valve and bristles to match.
fn laws() -> Vec<FrictionLaw> {
    let steady = Classical::new(1708.0, 1423.0, 612.9, 0.00254).unwrap();
    let element = |stiffness, share| GmsElement {
        stiffness_n_per_m: stiffness,
        damping_n_s_per_m: 500.0,
        share,
    };
    let elements = [element(6e6, 0.6), element(3e6, 0.3), element(1e6, 0.1)];
    let armstrong = Armstrong {
        presliding_n_per_m: 1e7,
        coulomb_n: 1423.0,
        viscous_n_s_per_m: 612.9,
        static_excess_n: 285.0,
        stribeck_m_per_s: 0.00254,
        memory_s: 0.01,
        rise_s: 2.0,
    };
    vec![
        classical(1708.0, 1423.0, 612.9, 0.0),
        classical(1708.0, 1423.0, 612.9, 0.00254),
        classical(1708.0, 1708.0, 612.9, 0.0),
        classical(0.0, 0.0, 0.0, 0.0),
        FrictionLaw::Karnopp(Karnopp::new(steady, 2e-4).unwrap()),
        FrictionLaw::Dahl(Dahl::new(1423.0, 1e7, 612.9).unwrap()),
        FrictionLaw::LuGre(LuGre::new(steady, 1e7, 2e3).unwrap()),
        FrictionLaw::Gms(Gms::new(steady, 5e3, &elements).unwrap()),
        FrictionLaw::Armstrong(armstrong),
    ]
}

fn signal(points: &[(f64, f64)]) -> PressureSignal {
    PressureSignal::from_points(points.to_vec()).unwrap()
}

/// A few strokes of different speeds, with a hold and a jump.
fn strokes() -> Vec<(f64, f64)> {
    let points = [(0.0, 0.0), (8.0, 6e4), (12.0, 6e4), (12.0, 4e4), (20.0, 1e4), (24.0, 5e4)];
    points.to_vec()
}

fn grid(end: f64, count: u32) -> Vec<f64> {
    (0..=count).map(|i| (end * f64::from(i) / f64::from(count)).min(end)).collect()
}

/// The first two events that are not in order of time. A stem may leave an end stop at the very
/// moment it meets it, if the net force already pulls it away; all other events are apart.
fn disorder(events: &[Event]) -> Option<&[Event]> {
    events.windows(2).find(|w| {
        let rebound = (w[0].kind, w[1].kind) == (EventKind::EndStop, EventKind::Slip);
        !(w[0].time_s < w[1].time_s || rebound && w[0].time_s == w[1].time_s)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Between a stop and the next slip the stem does not move, and the net force stays within
    /// static friction; slips and stops take turns, in order of time.
    #[test]
    fn a_stuck_stem_stays(
        pressures in prop::collection::vec(0.0..69_000.0_f64, 2..7),
        gaps in prop::collection::vec(0.05..6.0_f64, 7),
        stribeck in prop_oneof![Just(0.0), 0.001..0.1_f64],
        viscous in 5.0..3000.0_f64,
        lag in prop_oneof![Just(0.0), 0.05..3.0_f64],
        held in any::<bool>(),
    ) {
        let parameters = StemParameters { air_lag_s: lag, ..cts() };
        let stem = Stem::new(parameters, classical(1708.0, 1423.0, viscous, stribeck)).unwrap();
        let mut time = 0.0;
        let mut points = vec![(0.0, 0.0)];
        for (pressure, gap) in pressures.iter().zip(&gaps) {
            let before = points[points.len() - 1].1;
            points.push((time, if held { *pressure } else { before }));
            time += gap;
            points.push((time, *pressure));
        }
        let times = grid(time, 500);
        let response = stem.simulate(&signal(&points), StemStart::at_rest(0.0), &times).unwrap();
        let events = &response.events;
        prop_assert_eq!(disorder(events), None);
        let mut at_rest_since = Some((0.0, 0.0));
        let mut next = 0;
        for sample in &response.samples {
            while next < events.len() && events[next].time_s <= sample.time_s {
                let event = events[next];
                match event.kind {
                    EventKind::Slip => {
                        prop_assert!(at_rest_since.is_some());
                        at_rest_since = None;
                    }
                    EventKind::Stop | EventKind::EndStop => {
                        prop_assert!(at_rest_since.is_none());
                        at_rest_since = Some((event.time_s, event.position_m));
                    }
                    EventKind::Reversal => prop_assert!(at_rest_since.is_none()),
                }
                next += 1;
            }
            let x = sample.position_m;
            prop_assert!((0.0..=parameters.stroke_m).contains(&x));
            if let Some((since, place)) = at_rest_since && since < sample.time_s {
                prop_assert_eq!(x, place);
                prop_assert_eq!(sample.velocity_m_per_s, 0.0);
                let net = parameters.net_force_n(sample.pressure_pa, x);
                let inside = x > 0.0 && x < parameters.stroke_m;
                prop_assert!(!inside || net.abs() <= 1708.0 * (1.0 + 1e-9), "{}", net);
            } else {
                // Friction takes energy out of a moving stem.
                let power = sample.friction_n * sample.velocity_m_per_s;
                prop_assert!(power > -1e-7, "{}", power);
            }
        }
    }

    /// Any law, driven hard into its end stops, keeps going: events in order, travel in bounds.
    #[test]
    fn no_law_chatters_or_fails(
        law in 0..laws().len(),
        pressures in prop::collection::vec(-3e4..1.2e5_f64, 2..6),
        gap in 0.02..4.0_f64,
        lag in prop_oneof![Just(0.0), 0.05..3.0_f64],
        held in any::<bool>(),
    ) {
        let law = laws()[law];
        let parameters = StemParameters { air_lag_s: lag, ..cts() };
        let stem = Stem::new(parameters, law).unwrap();
        let mut points = vec![(0.0, pressures[0])];
        for (i, pair) in pressures.windows(2).enumerate() {
            let time = gap * i as f64;
            points.push((time, if held { pair[1] } else { pair[0] }));
            points.push((time + gap, pair[1]));
        }
        let end = points[points.len() - 1].0;
        let response =
            stem.simulate(&signal(&points), StemStart::at_rest(0.03), &grid(end, 200)).unwrap();
        prop_assert_eq!(disorder(&response.events), None, "{:?}", law);
        for sample in &response.samples {
            prop_assert!((0.0..=parameters.stroke_m).contains(&sample.position_m));
            prop_assert!(sample.velocity_m_per_s.is_finite() && sample.friction_n.is_finite());
        }
    }

    /// Held samples, as a controller sends them: the driver and the simulation agree.
    #[test]
    fn the_valve_is_the_simulation(op in prop::collection::vec(0.0..100.0_f64, 1..12)) {
        let stem = Stem::new(cts(), laws()[1]).unwrap();
        let mut valve = StemValve::new(stem, 0.5).unwrap();
        let mut vp = vec![0.0; op.len()];
        valve.run(&op, &mut vp).unwrap();
        let times: Vec<f64> = (1..=op.len()).map(|i| 0.5 * i as f64).collect();
        let held = PressureSignal::held_op(&op, 0.5, stem.parameters()).unwrap();
        let response = stem.simulate(&held, StemStart::at_rest(0.0), &times).unwrap();
        for (sample, vp) in response.samples.iter().zip(&vp) {
            prop_assert!((stem.parameters().percent(sample.position_m) - vp).abs() < 1e-9);
        }
    }
}

#[test]
fn events_do_not_depend_on_the_sampling_grid() {
    for law in laws() {
        let stem = Stem::new(cts(), law).unwrap();
        let run = |count| {
            let times = grid(24.0, count);
            stem.simulate(&signal(&strokes()), StemStart::at_rest(0.0), &times).unwrap()
        };
        let (coarse, fine) = (run(7), run(7 * 300));
        assert_eq!(disorder(&fine.events), None, "{law:?}");
        assert_eq!(coarse.events, fine.events, "{}", law.name());
        for (a, b) in coarse.samples.iter().zip(fine.samples.iter().step_by(300)) {
            assert!((a.position_m - b.position_m).abs() < 1e-9);
        }
    }
}

#[test]
fn motion_does_not_depend_on_the_date() {
    const LATER_S: f64 = 4096.0;
    for law in laws() {
        let stem = Stem::new(cts(), law).unwrap();
        let times = grid(24.0, 96);
        let now = stem.simulate(&signal(&strokes()), StemStart::at_rest(0.0), &times).unwrap();
        let points: Vec<_> = strokes().iter().map(|(t, p)| (t + LATER_S, *p)).collect();
        let times: Vec<_> = times.iter().map(|t| t + LATER_S).collect();
        let later = stem.simulate(&signal(&points), StemStart::at_rest(0.0), &times).unwrap();
        assert_eq!(now.events.len(), later.events.len(), "{}", law.name());
        for (a, b) in now.events.iter().zip(&later.events) {
            assert_eq!(a.kind, b.kind);
            assert!((b.time_s - LATER_S - a.time_s).abs() < 1e-8, "{} {a:?} {b:?}", law.name());
        }
        for (a, b) in now.samples.iter().zip(&later.samples) {
            assert!((a.position_m - b.position_m).abs() < 1e-9, "{}", law.name());
        }
    }
}

#[test]
fn up_and_down_are_alike() {
    let parameters = StemParameters { end_stops: false, preload_n: 0.0, ..cts() };
    for law in laws() {
        let stem = Stem::new(parameters, law).unwrap();
        let run = |sign: f64| {
            let points: Vec<_> = strokes().iter().map(|(t, p)| (*t, sign * p)).collect();
            stem.simulate(&signal(&points), StemStart::at_rest(0.0), &grid(24.0, 96)).unwrap()
        };
        let (up, down) = (run(1.0), run(-1.0));
        assert_eq!(up.events.len(), down.events.len(), "{}", law.name());
        for (a, b) in up.events.iter().zip(&down.events) {
            assert!((a.time_s - b.time_s).abs() < 1e-9 && a.direction != b.direction);
        }
        for (a, b) in up.samples.iter().zip(&down.samples) {
            assert!((a.position_m + b.position_m).abs() < 1e-10, "{}", law.name());
        }
    }
}

#[test]
fn end_stops_are_met_and_left() {
    let points = [(0.0, 0.0), (10.0, 2e5), (15.0, 2e5), (25.0, -1e5), (30.0, 1e5)];
    for law in laws() {
        let stem = Stem::new(cts(), law).unwrap();
        let times = grid(30.0, 3000);
        let response = stem.simulate(&signal(&points), StemStart::at_rest(0.0), &times).unwrap();
        let stroke = cts().stroke_m;
        let met: Vec<_> = response.events.iter().filter(|e| e.kind == EventKind::EndStop).collect();
        // Without friction or with light bristles the stem may bounce off its rest at the bottom.
        assert!(met.len() >= 2, "{}: {met:?}", law.name());
        assert_eq!((met[0].direction, met[0].position_m), (Direction::Up, stroke));
        assert!(met.iter().any(|e| e.direction == Direction::Down && e.position_m == 0.0));
        for sample in &response.samples {
            let x = sample.position_m;
            assert!((-1e-12..=stroke + 1e-12).contains(&x), "{}: {x}", law.name());
        }
        assert_eq!(disorder(&response.events), None, "{law:?}");
        let at_top = response.samples.iter().find(|s| s.time_s == 12.0).unwrap();
        assert_eq!((at_top.position_m, at_top.velocity_m_per_s), (stroke, 0.0));
    }
}

#[test]
fn the_first_slip_covers_the_overshoot_times_the_jump() {
    let parameters = StemParameters { end_stops: false, ..cts() };
    // So slow a ramp that the input hardly moves during the slip.
    let ramp = signal(&[(0.0, 0.0), (10_000.0, 60_000.0)]);
    let mut worst = 0.0_f64;
    for z in [0.0, 0.003, 0.01, 0.03, 0.1, 0.2, 0.3, 0.5] {
        let viscous = 2.0 * z * (parameters.spring_n_per_m * parameters.mass_kg).sqrt();
        let stem = Stem::new(parameters, classical(1708.0, 1423.0, viscous, 0.0)).unwrap();
        let equivalent = stem.equivalent().unwrap();
        let response = stem.simulate(&ramp, StemStart::at_rest(0.0), &[]).unwrap();
        let jump = response.stops().next().unwrap().position_m;
        let theory = equivalent.overshoot * equivalent.j_m;
        println!("z = {z}: {jump:.6e} m, K J = {theory:.6e} m");
        worst = worst.max((jump / theory - 1.0).abs());
    }
    println!("worst {:.4} %", 100.0 * worst);
    assert!(worst < 0.002);
}

#[test]
fn the_friction_curve_decides_between_staircase_and_sliding() {
    let usp = ParameterSet::named("usp").unwrap();
    let parameters = StemParameters { end_stops: false, ..usp.stem };
    let ramp = signal(&[(0.0, 41_368.0), (100.0, 180_000.0)]);
    // Viscous friction in units of (Fs - Fc)/vs; the thresholds are 0.6382 and 0.8578.
    for (ratio, kind) in [
        (0.55, SlidingKind::Staircase),
        (0.62, SlidingKind::Staircase),
        (0.66, SlidingKind::Rippling),
        (0.80, SlidingKind::Rippling),
        (0.90, SlidingKind::Smooth),
    ] {
        let stem =
            Stem::new(parameters, classical(780.0, 700.0, ratio * 80.0 / 5e-4, 5e-4)).unwrap();
        assert_eq!(stem.equivalent().unwrap().sliding, kind, "{ratio}");
        let times: Vec<f64> = (0..2000).map(|i| 80.0 + 0.01 * f64::from(i)).collect();
        let response = stem.simulate(&ramp, StemStart::at_rest(0.0), &times).unwrap();
        let speeds = || response.samples.iter().map(|s| s.velocity_m_per_s);
        let ripple = speeds().fold(0.0, f64::max) / speeds().fold(f64::MAX, f64::min) - 1.0;
        let stops = response.stops().count();
        println!("{ratio}: {stops} stops, ripple {ripple:.3}");
        assert_eq!(stops > 0, kind == SlidingKind::Staircase, "{ratio}");
        assert_eq!(ripple > 0.01, kind != SlidingKind::Smooth, "{ratio}");
    }
}

#[test]
fn names_lead_to_laws_and_sets() {
    for name in SETS {
        let set = ParameterSet::named(name).unwrap();
        assert_eq!(set.name, name);
        assert!(!set.summary.is_empty() && !set.source.is_empty());
        Stem::named(name).unwrap().equivalent().unwrap();
    }
    let values: [&[f64]; 6] = [
        &[780.0, 700.0, 1e5, 5e-4],
        &[780.0, 700.0, 1e5, 5e-4, 1e-5],
        &[700.0, 2.6e7, 1e5],
        &[780.0, 700.0, 1e5, 5e-4, 2.6e7, 2e4],
        &[780.0, 700.0, 1e5, 5e-4, 20.0, 2.9e7, 2.9e3, 0.75, 1.5e7, 1.4e3, 0.2, 3e6, 4e3, 0.05],
        &[1e7, 700.0, 1e5, 80.0, 5e-4, 0.01, 1.0],
    ];
    for (entry, values) in LAWS.iter().zip(values) {
        let law = FrictionLaw::from_name(entry.name, values).unwrap();
        assert_eq!(law.name(), entry.name);
        assert_eq!((law.coulomb_n(), law.viscous_n_s_per_m()), (700.0, 1e5));
        let short = FrictionLaw::from_name(entry.name, &values[1..]);
        assert!(matches!(short, Err(Error::Length { .. })));
        for i in 0..values.len() {
            for bad in [f64::NAN, f64::INFINITY, -1.0] {
                let mut values = values.to_vec();
                values[i] = bad;
                let refused = FrictionLaw::from_name(entry.name, &values);
                assert!(matches!(refused, Err(Error::Parameter { .. })), "{} {i}", entry.name);
            }
        }
    }
    assert!(matches!(FrictionLaw::from_name("glue", &[]), Err(Error::UnknownName { .. })));
    assert!(matches!(ParameterSet::named("usb"), Err(Error::UnknownName { .. })));
}

#[test]
fn malformed_parameters_are_refused() {
    let good = cts();
    let law = laws()[0];
    type Change = fn(&mut StemParameters, f64);
    let changes: [(Change, &[f64]); 8] = [
        (|p, v| p.mass_kg = v, &[0.0, -1.0, f64::NAN, f64::INFINITY]),
        (|p, v| p.spring_n_per_m = v, &[0.0, -1.0, f64::NAN, f64::INFINITY]),
        (|p, v| p.area_m2 = v, &[0.0, -1.0, f64::NAN, f64::INFINITY]),
        (|p, v| p.preload_n = v, &[f64::NAN, f64::INFINITY]),
        (|p, v| p.stroke_m = v, &[0.0, -1.0, f64::NAN, f64::INFINITY]),
        (|p, v| p.pressure_min_pa = v, &[f64::NAN, f64::NEG_INFINITY, 68_948.0]),
        (|p, v| p.pressure_max_pa = v, &[0.0, -1.0, f64::NAN, f64::INFINITY]),
        (|p, v| p.air_lag_s = v, &[-1.0, f64::NAN, f64::INFINITY]),
    ];
    for (change, values) in changes {
        for value in values {
            let mut parameters = good;
            change(&mut parameters, *value);
            assert!(matches!(Stem::new(parameters, law), Err(Error::Parameter { .. })), "{value}");
        }
    }
    // Fc above Fs; a band below 0; Stribeck velocity 0 in LuGre; shares that do not sum to 1.
    assert!(Classical::new(1.0, 2.0, 0.0, 0.0).is_err());
    let steady = Classical::new(780.0, 700.0, 125_000.0, 5e-4).unwrap();
    assert!(Karnopp::new(steady, -1e-4).is_err() && Karnopp::new(steady, f64::NAN).is_err());
    let at_rest_only = Classical::new(780.0, 700.0, 125_000.0, 0.0).unwrap();
    assert!(LuGre::new(at_rest_only, 1e7, 1e3).is_err());
    let half = GmsElement { stiffness_n_per_m: 1e7, damping_n_s_per_m: 0.0, share: 0.5 };
    assert!(Gms::new(steady, 20.0, &[half]).is_err());
    assert!(Gms::new(steady, 20.0, &[half, half]).is_ok());
    assert!(Gms::new(steady, 20.0, &[]).is_err() && Gms::new(steady, 20.0, &[half; 4]).is_err());

    let stem = Stem::new(good, law).unwrap();
    for tolerance in [0.0, 1e-13, 0.1, f64::NAN] {
        assert!(stem.with_tolerance(tolerance).is_err());
    }
    for points in [
        vec![],
        vec![(0.0, 1.0)],
        vec![(0.0, 1.0), (0.0, 2.0)],
        vec![(1.0, 1.0), (0.0, 2.0)],
        vec![(0.0, f64::NAN), (1.0, 2.0)],
        vec![(0.0, 1.0), (f64::INFINITY, 2.0)],
    ] {
        assert!(PressureSignal::from_points(points).is_err());
    }
    assert!(PressureSignal::held_op(&[], 1.0, &good).is_err());
    assert!(PressureSignal::held_op(&[1.0, f64::NAN], 1.0, &good).is_err());
    assert!(PressureSignal::held_op(&[1.0], 0.0, &good).is_err());
    let ramp = signal(&[(0.0, 0.0), (1.0, 1e4)]);
    for times in [vec![-0.1], vec![1.1], vec![0.5, 0.4], vec![f64::NAN]] {
        assert!(stem.simulate(&ramp, StemStart::at_rest(0.0), &times).is_err());
    }
    for position in [f64::NAN, -0.01, 0.2] {
        assert!(stem.simulate(&ramp, StemStart::at_rest(position), &[]).is_err());
    }
    assert!(StemValve::new(stem, 0.0).is_err() && StemValve::new(stem, f64::NAN).is_err());
}

#[test]
fn a_valve_says_what_failed_and_begins_again() {
    let stem = Stem::new(cts(), laws()[1]).unwrap();
    let mut valve = StemValve::new(stem, 0.1).unwrap();
    let fresh: Vec<f64> = (0..50).map(|i| valve.step(2.0 * f64::from(i))).collect();
    assert!(fresh[49] > 20.0 && valve.fault().is_none());
    assert!(valve.step(f64::NAN).is_nan());
    assert!(valve.fault().is_some());
    assert!(valve.step(50.0).is_nan() && valve.position().is_nan());
    valve.restart(Start::default());
    assert!(valve.fault().is_none());
    let again: Vec<f64> = (0..50).map(|i| valve.step(2.0 * f64::from(i))).collect();
    assert_eq!(fresh, again);
    valve.restart(Start::at_rest(120.0));
    assert!(valve.fault().is_some() && valve.position().is_nan());
    valve.restart(Start::at_rest(50.0));
    assert_eq!(valve.step(50.0), 50.0);
}

#[test]
fn an_air_lag_delays_and_rounds_the_pressure() {
    let parameters = StemParameters { air_lag_s: 2.0, ..cts() };
    let stem = Stem::new(parameters, laws()[0]).unwrap();
    let step = signal(&[(0.0, 0.0), (0.0, 6e4), (10.0, 6e4)]);
    let start = StemStart { pressure_pa: Some(0.0), ..StemStart::at_rest(0.0) };
    let response = stem.simulate(&step, start, &[0.0, 2.0, 10.0]).unwrap();
    for sample in &response.samples {
        let expected = -6e4 * (-sample.time_s / 2.0).exp_m1();
        assert!((sample.pressure_pa - expected).abs() < 1e-9);
    }
    // Breaks away when Sa p = Fs.
    let slip = response.slips().next().unwrap().time_s;
    let expected = -2.0 * f64::ln_1p(-1708.0 / (0.0645 * 6e4));
    assert!((slip - expected).abs() < 1e-12);
}

/// Where sliding friction at the edge of Karnopp's band exceeds static friction, a stem just past
/// breakaway would fall back into the band; it must wait instead of chattering.
#[test]
fn a_wide_karnopp_band_does_not_chatter() {
    let usp = ParameterSet::named("usp").unwrap();
    let FrictionLaw::Classical(steady) = usp.friction else { unreachable!() };
    for band in [1e-6, 1e-4, 2e-4] {
        let law = FrictionLaw::Karnopp(Karnopp::new(steady, band).unwrap());
        let stem = Stem::new(usp.stem, law).unwrap();
        let triangle = signal(&[(0.0, 41_368.0), (20.0, 180_000.0), (40.0, 41_368.0)]);
        let response = stem.simulate(&triangle, StemStart::at_rest(0.0), &[]).unwrap();
        assert_eq!(disorder(&response.events), None);
        assert!(response.slips().count() <= 2, "{band}: {}", response.slips().count());
    }
}
