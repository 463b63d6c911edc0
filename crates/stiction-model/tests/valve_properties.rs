//! What must hold of the valve models for any input: equivalences, symmetries, bounds, and errors.

use crate::common;

use common::{
    Input, KINDS, bits, correlation, follow, max_difference, model_named, positions, valve,
};
use proptest::prelude::*;
use stiction_model::valve::{
    AnyModel, Assembly, Direction, HeWang, Ideal, Model, Play, Start, StemLag, Stenman, TwoPhase,
    Valve,
};
use stiction_model::{Bands, Error};

/// Kano's algorithm as published, in `us` and `d`: from rest at 0, last moved up.
fn kano_as_published(s: f64, j: f64, op: &[f64]) -> Vec<f64> {
    let fd = (s - j) / 2.0;
    let (mut x, mut d, mut us, mut moving) = (0.0, 1.0, fd, false);
    let (mut u_prev, mut du_prev) = (0.0, 0.0);
    op.iter()
        .map(|&u| {
            let du = u - u_prev;
            if du * du_prev <= 0.0 && moving {
                us = u_prev;
                moving = false;
            }
            if moving {
                x = u - d * fd;
            } else if -d * (u - us) > s {
                d = -d;
                x = u - d * fd;
                moving = true;
            } else if d * (u - us) > j {
                x = u - d * fd;
                moving = true;
            }
            (u_prev, du_prev) = (u, du);
            x
        })
        .collect()
}

/// Choudhury's revised flow chart as published: from rest at 0, last moved up.
fn choudhury_as_published(s: f64, j: f64, op: &[f64]) -> Vec<f64> {
    let sgn = |v: f64| if v == 0.0 { 0.0 } else { v.signum() };
    let (fs, fd) = ((s + j) / 2.0, (s - j) / 2.0);
    let (mut x, mut us, mut stuck) = (0.0, fd, true);
    let (mut u_prev, mut v_prev) = (0.0, 0.0);
    op.iter()
        .map(|&u| {
            let v = u - u_prev;
            if sgn(v) == sgn(v_prev) {
                if stuck {
                    let resumes = sgn(u - us) * sgn(us - x) == 1.0;
                    if if resumes { (u - us).abs() > j } else { (u - x).abs() > fs } {
                        stuck = false;
                        x = u - sgn(v) * fd;
                    }
                } else {
                    x = u - sgn(v) * fd;
                }
            } else {
                if !stuck {
                    us = u_prev;
                }
                stuck = v == 0.0 || (u - x).abs() <= fs;
                if !stuck {
                    x = u - sgn(v) * fd;
                }
            }
            (u_prev, v_prev) = (u, v);
            x
        })
        .collect()
}

const LENGTH: usize = 400;

/// Several thousand cases in all; each is a few microseconds.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

fn input() -> impl Strategy<Value = Input> {
    (0..KINDS, any::<u64>()).prop_map(|(kind, seed)| Input::new(kind, seed, LENGTH))
}

/// S and J, with J up to `most` times S. Random numbers: no input falls on a threshold.
fn s_j(most: f64) -> impl Strategy<Value = (f64, f64)> {
    (0.1..8.0, 0.001..most).prop_map(|(s, ratio)| (s, s * ratio))
}

/// The models that take S and J and answer at once.
const AT_ONCE: [Model; 4] = [Model::TwoPhase, Model::Kano, Model::Choudhury, Model::He];

proptest! {
    #![proptest_config(cases(2_000))]

    /// The theorem: one model under four names, and their published algorithms.
    #[test]
    fn two_phase_kano_and_choudhury_are_one_model(op in input(), (s, j) in s_j(1.0)) {
        let expected = bits(&positions(Model::TwoPhase, s, j, &op));
        prop_assert_eq!(bits(&positions(Model::Kano, s, j, &op)), expected.clone());
        prop_assert_eq!(bits(&positions(Model::Choudhury, s, j, &op)), expected.clone());
        prop_assert_eq!(bits(&kano_as_published(s, j, &op)), expected.clone());
        prop_assert_eq!(bits(&choudhury_as_published(s, j, &op)), expected);
    }

    /// Slips that overshoot the input keep two-phase and Kano together.
    #[test]
    fn two_phase_and_kano_are_one_model_with_overshoot(op in input(), (s, j) in s_j(3.0)) {
        let expected = bits(&positions(Model::TwoPhase, s, j, &op));
        prop_assert_eq!(bits(&positions(Model::Kano, s, j, &op)), expected.clone());
        prop_assert_eq!(bits(&kano_as_published(s, j, &op)), expected);
    }

    /// Our Choudhury is the published chart for J > S too, where the chart is a model of its own.
    #[test]
    fn choudhury_follows_its_chart_with_overshoot(op in input(), (s, j) in s_j(3.0)) {
        let expected = bits(&choudhury_as_published(s, j, &op));
        prop_assert_eq!(bits(&positions(Model::Choudhury, s, j, &op)), expected);
    }

    /// Without slip jump all are a pure dead band.
    #[test]
    fn without_jump_all_are_play(op in input(), s in 0.1..8.0) {
        let expected = bits(&positions(Model::Play, s, 0.0, &op));
        for model in AT_ONCE {
            prop_assert_eq!(bits(&positions(model, s, 0.0, &op)), expected.clone(), "{:?}", model);
        }
    }

    /// Without dead band He's model is Stenman's.
    #[test]
    fn without_dead_band_he_is_stenman(op in input(), s in 0.1..8.0) {
        let expected = bits(&positions(Model::Stenman, s, s, &op));
        prop_assert_eq!(bits(&positions(Model::He, s, s, &op)), expected);
    }

    /// Overshoot factor 1 is He's model, but for the order of its sums.
    #[test]
    fn without_overshoot_he_wang_is_he(op in input(), (s, j) in s_j(1.0)) {
        let mut he_wang = HeWang::new(Bands::from_s_j(s, j).unwrap(), 1.0).unwrap();
        let found = follow(&mut he_wang, &op);
        prop_assert!(max_difference(&found, &positions(Model::He, s, j, &op)) < 1e-10);
    }

    /// Without friction they are the identity.
    #[test]
    fn without_friction_all_are_ideal(op in input(), (s, j) in s_j(1.0)) {
        for model in [Model::Play, Model::Stenman].into_iter().chain(AT_ONCE) {
            let found = positions(model, 0.0, 0.0, &op);
            prop_assert_eq!(bits(&found), bits(&op), "{:?}", model);
        }
        prop_assert_eq!(bits(&positions(Model::Ideal, s, j, &op)), bits(&op));
    }

    /// The spring never holds more than the static friction.
    #[test]
    fn input_and_position_stay_within_the_static_band(op in input(), (s, j) in s_j(2.0)) {
        let fs = (s + j) / 2.0;
        for model in [Model::TwoPhase, Model::Kano, Model::He] {
            let apart = max_difference(&positions(model, s, j, &op), &op);
            prop_assert!(apart <= fs + 1e-12, "{model:?}: {apart} > {fs}");
        }
    }

    /// Input, S and J scaled alike scale the position: to the bit by powers of two.
    #[test]
    fn models_scale(op in input(), (s, j) in s_j(1.0), power in -20..20, factor in 0.1..10.0) {
        for model in Model::ALL {
            let plain = positions(model, s, j, &op);
            let scaled = |c: f64| {
                let op: Vec<f64> = op.iter().map(|u| c * u).collect();
                let expected: Vec<f64> = plain.iter().map(|x| c * x).collect();
                (positions(model, c * s, c * j, &op), expected)
            };
            let (found, expected) = scaled(2f64.powi(power));
            prop_assert_eq!(bits(&found), bits(&expected), "{:?}", model);
            let (found, expected) = scaled(factor);
            // The overshooting model sums its steps, and their rounding.
            let tolerance = if model == Model::HeWang { 1e-9 } else { 1e-12 };
            let size = op.iter().fold(1.0f64, |m, u| m.max((factor * u).abs()));
            prop_assert!(max_difference(&found, &expected) <= tolerance * size, "{model:?}");
        }
    }

    /// The mirrored input gives the mirrored position, from the mirrored start.
    #[test]
    fn models_are_odd(op in input(), (s, j) in s_j(3.0)) {
        let mirrored: Vec<f64> = op.iter().map(|u| -u).collect();
        for model in Model::ALL {
            // Two bands that every model takes.
            let j = if model == Model::HeWang { j / 3.0 } else { j };
            let mut upright = valve(model, s, j);
            let mut mirror = upright.clone();
            mirror.restart(Start { direction: Direction::Down, ..Start::at_rest(0.0) });
            let (a, b) = (follow(&mut upright, &op), follow(&mut mirror, &mirrored));
            prop_assert!(a.iter().zip(&b).all(|(a, b)| *a == -b), "{model:?}");
        }
    }

    /// How fast the input goes from one turning point to the next does not matter, as long as it
    /// never pauses: more samples on the way leave the old ones as they were.
    #[test]
    fn path_does_not_depend_on_the_rate(
        kind in prop::sample::select(vec![0u8, 2, 3]),
        seed in any::<u64>(),
        (s, j) in s_j(1.0),
        between in 1usize..4,
    ) {
        let op = Input::new(kind, seed, LENGTH);
        let mut fine = vec![];
        let mut before = 0.0;
        for u in op.iter() {
            let part = |i: usize| before + (u - before) * i as f64 / (between + 1) as f64;
            fine.extend((1..=between).map(part));
            fine.push(*u);
            before = *u;
        }
        for model in [Model::TwoPhase, Model::Kano, Model::Choudhury, Model::Play] {
            let found: Vec<f64> =
                positions(model, s, j, &fine).into_iter().skip(between).step_by(between + 1).collect();
            prop_assert_eq!(bits(&found), bits(&positions(model, s, j, &op)), "{:?}", model);
        }
        let found: Vec<f64> =
            positions(Model::TwoPhase, s, 2.0 * s, &fine).into_iter().skip(between).step_by(between + 1).collect();
        prop_assert_eq!(bits(&found), bits(&positions(Model::TwoPhase, s, 2.0 * s, &op)));
    }

    /// Sample by sample, all at once, and once more from the start: the same bits.
    #[test]
    fn run_is_its_steps_and_restart_forgets(
        op in input(),
        (s, j) in s_j(1.0),
        position in -5.0..5.0,
        moving in any::<bool>(),
    ) {
        let start = Start { moving, ..Start::at_rest(position) };
        for model in Model::ALL {
            let mut stepped = valve(model, s, j);
            stepped.restart(start);
            prop_assert_eq!(stepped.position(), position);
            let mut run = stepped.clone();
            let steps: Vec<f64> = op.iter().map(|u| stepped.step(*u)).collect();
            let whole = bits(&follow(&mut run, &op));
            prop_assert_eq!(bits(&steps), whole.clone(), "{:?}", model);
            prop_assert_eq!(run.position().to_bits(), *whole.last().unwrap());
            run.restart(start);
            prop_assert_eq!(bits(&follow(&mut run, &op)), whole, "{:?}", model);
        }
    }

    /// A rest tolerance of 0 is none; a large one stops the stem at every sample, which is He's
    /// model.
    #[test]
    fn rest_tolerance(op in input(), (s, j) in s_j(1.0)) {
        let plain = TwoPhase::new(Bands::from_s_j(s, j).unwrap());
        let with = |speed| plain.clone().with_rest_tolerance(speed, 0.1).unwrap();
        prop_assert_eq!(
            bits(&follow(&mut with(0.0), &op)),
            bits(&follow(&mut plain.clone(), &op))
        );
        prop_assert_eq!(bits(&follow(&mut with(1e9), &op)), bits(&positions(Model::He, s, j, &op)));
    }

    /// With limits neither the model's input nor the position leaves them.
    #[test]
    fn limits_hold(op in input(), (s, j) in s_j(2.0), low in -5.0..0.0, width in 0.1..10.0) {
        let high = low + width;
        let clipped: Vec<f64> = op.iter().map(|u| u.max(low).min(high)).collect();
        for model in [Model::TwoPhase, Model::Choudhury, Model::He, Model::Chen] {
            let mut limited = valve(model, s, j).with_limits(low, high).unwrap();
            let found = follow(&mut limited, &op);
            prop_assert!(found.iter().all(|x| (low..=high).contains(x)));
            let inside: Vec<f64> =
                positions(model, s, j, &clipped).iter().map(|x| x.max(low).min(high)).collect();
            prop_assert_eq!(bits(&found), bits(&inside), "{:?}", model);
        }
    }
}

/// Choudhury's chart with J > S is another model than the rest.
#[test]
fn choudhury_differs_with_overshoot() {
    let differ = (0..200).filter(|seed| {
        let op = Input::new(0, *seed, LENGTH);
        positions(Model::Choudhury, 2.0, 5.0, &op) != positions(Model::TwoPhase, 2.0, 5.0, &op)
    });
    assert!(differ.count() > 50);
}

/// A pause does matter: the stem stops, and sets off again only J further on.
#[test]
fn a_pause_stops_the_stem() {
    let ramp = [2.0, 4.0, 6.0, 7.0, 8.0];
    let paused = [2.0, 4.0, 6.0, 6.0, 7.0, 8.0];
    let (s, j) = (4.0, 1.5);
    // fs = 2.75, fd = 1.25.
    assert_eq!(positions(Model::TwoPhase, s, j, &ramp), [0.0, 2.75, 4.75, 5.75, 6.75]);
    assert_eq!(positions(Model::TwoPhase, s, j, &paused), [0.0, 2.75, 4.75, 4.75, 4.75, 6.75]);
}

/// Chen's tree answers a reversal larger than S one sample late; the others at once.
#[test]
fn chen_is_late_at_large_reversals() {
    let op = [10.0, -10.0, -11.0];
    assert_eq!(positions(Model::TwoPhase, 4.0, 2.0, &op), [9.0, -9.0, -10.0]);
    assert_eq!(positions(Model::Chen, 4.0, 2.0, &op), [9.0, 9.0, -10.0]);
}

/// The overshoot factor multiplies the slip jump.
#[test]
fn he_wang_overshoots() {
    let mut valve = HeWang::new(Bands::from_s_j(5.0, 2.0).unwrap(), 1.5).unwrap();
    // e = 4 exceeds fs = 3.5; the jump to u - fd would be 2.5.
    assert_eq!(valve.step(4.0), 3.75);
    // Now e = -4.5, the other way: -4.5 + 1.5 = -3.
    assert_eq!(valve.step(-0.75), -0.75);
}

/// A bad sample is named, and leaves the valve where it was.
#[test]
fn bad_samples_are_refused() {
    for model in Model::ALL {
        let mut valve = valve(model, 2.0, 1.0);
        let error = valve.run(&[10.0, f64::NAN], &mut [0.0; 2]).unwrap_err();
        assert!(matches!(error, Error::NonFinite { signal: "op", index: 1, .. }), "{error}");
        let error = valve.run(&[10.0], &mut [0.0; 2]).unwrap_err();
        assert_eq!(error, Error::Length { name: "vp", found: 2, expected: 1 });
        assert_eq!(valve.position(), 0.0);
    }
}

/// A series at once is the series sample by sample, whatever stands around the model, and however long it is.
#[test]
fn a_run_is_its_steps() {
    let op = Input::new(0, 7, 1000);
    for model in Model::ALL {
        let bare = || valve(model, 3.0, 1.0);
        let limited = || bare().with_limits(-2.0, 2.0).unwrap();
        let lag = || StemLag::new(1.7, 0.1).unwrap();
        let surrounded = [bare(), limited(), bare().with_lag(lag()), limited().with_lag(lag())];
        for (mut at_once, len) in
            surrounded.into_iter().flat_map(|v| [0, 1, 255, 1000].map(|n| (v.clone(), n)))
        {
            let mut stepped = at_once.clone();
            let mut vp = vec![0.0; len];
            at_once.run(&op[..len], &mut vp).unwrap();
            assert_eq!(
                bits(&vp),
                bits(&op[..len].iter().map(|u| stepped.step(*u)).collect::<Vec<_>>())
            );
            assert_eq!(at_once, stepped);
        }
    }
}

/// The lag follows a step as a first-order system does, one sample behind.
#[test]
fn stem_lag_step_response() {
    let (tau, ts) = (1.7, 0.1);
    let mut lagged =
        Assembly::new(AnyModel::Ideal(Ideal::new())).with_lag(StemLag::new(tau, ts).unwrap());
    for k in 0..100 {
        let expected = 8.0 * (1.0 - (-k as f64 * ts / tau).exp());
        assert!((lagged.step(8.0) - expected).abs() < 1e-12);
    }
    lagged.restart(Start::at_rest(3.0));
    assert_eq!((lagged.position(), lagged.step(3.0)), (3.0, 3.0));

    // No lag passes the position through.
    let op = Input::new(0, 1, LENGTH);
    let mut unlagged = valve(Model::TwoPhase, 3.0, 1.0).with_lag(StemLag::new(0.0, ts).unwrap());
    assert_eq!(follow(&mut unlagged, &op), positions(Model::TwoPhase, 3.0, 1.0, &op));
}

/// A trailing valve reaches its limits but for the dynamic band.
#[test]
fn limits_are_reached_but_for_the_dynamic_band() {
    let mut limited = valve(Model::TwoPhase, 6.0, 2.0).with_limits(0.0, 100.0).unwrap();
    assert_eq!(
        follow(&mut limited, &[60.0, 130.0, 140.0, 50.0, -5.0]),
        [58.0, 98.0, 98.0, 52.0, 2.0]
    );
}

#[test]
fn bands_convert_both_ways() {
    let bands = Bands::from_s_j(5.0, 3.0).unwrap();
    assert_eq!((bands.fs(), bands.fd()), (4.0, 1.0));
    assert_eq!(Bands::from_fs_fd(4.0, 1.0).unwrap(), bands);
    let overshooting = Bands::from_s_j(3.0, 5.0).unwrap();
    assert_eq!(overshooting.fd(), -1.0);
    assert_eq!(Bands::from_fs_fd(4.0, -1.0).unwrap(), overshooting);
}

/// What is refused, and with which sentence.
#[test]
fn invalid_parameters_are_refused() {
    let finite = "a finite number of at least 0";
    let mut table: Vec<(stiction_model::Result<()>, &str, &str)> = vec![];
    for bad in [-1.0, -1e-300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        table.push((Bands::from_s_j(bad, 1.0).map(drop), "S", finite));
        table.push((Bands::from_s_j(1.0, bad).map(drop), "J", finite));
        table.push((Bands::from_fs_fd(bad, 0.0).map(drop), "fs", finite));
        table.push((Play::new(bad).map(drop), "S", finite));
        table.push((Stenman::new(bad).map(drop), "d", finite));
        table.push((StemLag::new(bad, 0.1).map(drop), "stem lag", finite));
        table.push((StemLag::new(1.0, bad).map(drop), "sample time", "a finite number above 0"));
        let valve = TwoPhase::new(Bands::NONE);
        table.push((valve.with_rest_tolerance(bad, 0.1).map(drop), "rest tolerance", finite));
    }
    for bad in [1.5, -1.5, f64::NAN, f64::INFINITY] {
        table.push((Bands::from_fs_fd(1.0, bad).map(drop), "fd", "between -1 and fs = 1"));
    }
    let bands = Bands::from_s_j(2.0, 1.0).unwrap();
    for bad in [0.999, 2.001, -1.0, f64::NAN, f64::INFINITY] {
        table.push((HeWang::new(bands, bad).map(drop), "K", "between 1"));
    }
    table.push((StemLag::new(1.0, 0.0).map(drop), "sample time", "above 0"));
    let overshooting = Bands::from_s_j(2.0, 2.5).unwrap();
    table.push((HeWang::new(overshooting, 1.0).map(drop), "J", "at most S = 2"));
    table.push((Model::HeWang.build(overshooting).map(drop), "J", "at most S = 2"));

    for (result, name, allowed) in table {
        let error = result.unwrap_err();
        let Error::Parameter { name: found, value, .. } = &error else { panic!("{error}") };
        assert_eq!(*found, name, "{error}");
        let sentence = error.to_string();
        assert!(sentence.starts_with(&format!("{name} is {value}, but must be ")), "{sentence}");
        assert!(sentence.contains(allowed), "{sentence}");
    }
    for (low, high) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::NAN)] {
        let error = valve(Model::Ideal, 0.0, 0.0).with_limits(low, high).unwrap_err();
        assert!(error.to_string().contains("must be below the upper limit"), "{error}");
    }
}

#[test]
fn models_answer_to_their_names() {
    for model in Model::ALL {
        let description = model.describe();
        for name in [description.name].iter().chain(description.aliases) {
            assert_eq!(model_named(name), model);
            assert_eq!(model_named(&name.to_uppercase()), model);
        }
        assert!(!description.summary.is_empty() && !description.citation.is_empty());
    }
    let error = Model::by_name("coulomb").unwrap_err().to_string();
    for model in Model::ALL {
        assert!(error.contains(model.describe().name), "{error}");
    }
    assert!(error.contains("\"coulomb\""), "{error}");
}

/// What a model says of S and J is so.
#[test]
fn models_use_the_parameters_they_say() {
    let op = Input::new(0, 7, LENGTH);
    for model in Model::ALL {
        let description = model.describe();
        let plain = positions(model, 4.0, 2.0, &op);
        assert_eq!(positions(model, 4.5, 2.0, &op) != plain, description.uses_s, "{model:?}");
        assert_eq!(positions(model, 4.0, 2.5, &op) != plain, description.uses_j, "{model:?}");
    }
}

/// The paper's four open-loop cases under a slow periodic ramp, 0.05 % a sample.
mod phase_plots {
    use super::*;

    fn ramp() -> Vec<f64> {
        let triangle = |k: usize| {
            let p = (k % 1200) as f64 / 1200.0;
            60.0 * if p < 0.25 {
                p
            } else if p < 0.75 {
                0.5 - p
            } else {
                p - 1.0
            }
        };
        (0..6000).map(triangle).collect()
    }

    /// Steps of the position, from one sample to the next, without those of rest.
    fn steps(vp: &[f64]) -> Vec<f64> {
        vp.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|step| *step > 0.0).collect()
    }

    /// (i) hardly any friction: a straight line.
    #[test]
    fn linear() {
        let bands = Bands::from_fs_fd(1e-4, 1e-4).unwrap();
        let vp = follow(&mut TwoPhase::new(bands), &ramp());
        assert!(max_difference(&vp, &ramp()) <= 1e-4 + 1e-12);
        assert!(correlation(&vp, &ramp()) > 0.999_999);
    }

    /// (ii) dead band alone: a parallelogram, S wide, without jumps.
    #[test]
    fn dead_band() {
        let (op, s) = (ramp(), 5.0);
        let vp = positions(Model::TwoPhase, s, 0.0, &op);
        assert!(steps(&vp).iter().all(|step| *step < 0.0501));
        for (k, w) in vp.windows(2).enumerate().skip(1200) {
            let u = op[k + 1];
            // On the flanks the position trails by S/2; between them it rests.
            let trailing = (u - w[1]).abs() - s / 2.0;
            assert!(w[1] == w[0] || trailing.abs() < 1e-12);
        }
        let width = op.iter().zip(&vp).map(|(u, x)| u - x).fold(0.0, f64::max)
            - op.iter().zip(&vp).map(|(u, x)| u - x).fold(0.0, f64::min);
        assert!((width - s).abs() < 1e-9);
    }

    /// (iii) stiction and dead band: at each turn a flat S wide, then a jump of J, then sliding.
    #[test]
    fn stiction() {
        let (op, s, j) = (ramp(), 5.0, 2.0);
        let vp = positions(Model::TwoPhase, s, j, &op);
        let (mut jumps, mut turn) = (0, 0);
        for k in 1200..6000 {
            // Turning points of the ramp, in samples.
            if (k % 1200) == 300 || (k % 1200) == 900 {
                turn = k;
            }
            let step = (vp[k] - vp[k - 1]).abs();
            if step > 0.0501 {
                jumps += 1;
                assert!((step - j).abs() < 0.0501, "jump of {step}");
                let flat = (op[k] - op[turn]).abs();
                assert!((flat - s).abs() < 0.0501, "flat of {flat}");
            }
        }
        assert_eq!(jumps, 8);
    }

    /// (iv) high stiction: almost nothing but jumps. In He's model the stem never slides, and climbs
    /// a staircase.
    #[test]
    fn high_stiction() {
        let (op, s, j) = (ramp(), 15.0, 14.0);
        let vp = positions(Model::TwoPhase, s, j, &op);
        let (jumps, slides): (Vec<f64>, Vec<f64>) = steps(&vp).iter().partition(|s| **s > 0.0501);
        assert!(jumps.iter().all(|step| (step - j).abs() < 0.1));
        assert!(jumps.iter().sum::<f64>() > slides.iter().sum::<f64>());

        let (s, j) = (5.0, 4.0);
        let stairs = steps(&positions(Model::He, s, j, &op));
        assert!(stairs.iter().all(|step| (step - j).abs() < 0.0501));
        assert!(stairs.len() > 40);
    }
}
