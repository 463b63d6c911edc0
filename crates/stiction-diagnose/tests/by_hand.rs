//! Which alternating OP is a test by hand, and which is a slow controller.

use stiction_diagnose::diagnose::{Basis, VerdictClass};
use stiction_diagnose::recording::{ByHand, Mode, Modes, Recording};
use stiction_model::Bands;
use stiction_model::closed_loop::NormalStream;
use stiction_model::valve::{AnyModel, Model, Start, Valve};

/// Draws among a few values.
struct Draws(u64);

impl Draws {
    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695);
        all[(self.0 >> 33) as usize % all.len()]
    }
}

fn rounded(x: f64, to: f64) -> f64 {
    if to > 0.0 { (x / to).round() * to } else { x }
}

/// A process with a valve: a dead time and a lag in samples, a load and noise.
struct Plant {
    valve: AnyModel,
    late: std::collections::VecDeque<f64>,
    share: f64,
    load: (f64, f64),
    noise: f64,
    z: f64,
    draw: NormalStream,
}

impl Plant {
    fn draw(draws: &mut Draws, sticks: bool, seed: u64) -> Self {
        let s = if sticks { draws.of(&[0.5, 1.0, 2.0, 5.0]) } else { 0.0 };
        let mut valve = Model::TwoPhase.build(Bands::from_s_j(s, 0.5 * s).unwrap()).unwrap();
        valve.restart(Start::at_rest(50.0));
        Self {
            valve,
            late: vec![50.0; draws.of(&[0, 0, 1, 3])].into(),
            share: 1.0 - (-1.0 / draws.of(&[0.5f64, 1.0, 3.0, 6.0, 12.0])).exp(),
            load: (0.0, draws.of(&[0.0, 0.02, 0.1])),
            noise: draws.of(&[0.02, 0.05, 0.15, 0.5]),
            z: 50.0,
            draw: NormalStream::new(seed),
        }
    }

    fn step(&mut self, op: f64) -> f64 {
        self.late.push_back(self.valve.step(op));
        let x = self.late.pop_front().unwrap_or(50.0);
        self.load.0 = 0.99 * self.load.0 + self.load.1 * self.draw.draw();
        self.z += self.share * (x + self.load.0 - self.z);
        self.z + self.noise * self.draw.draw()
    }
}

/// A loop in automatic whose controller executes every 3 to 20 samples, tightly or very tightly tuned.
fn controlled(draws: &mut Draws, sticks: bool, seed: u64, resolutions: &[f64]) -> Recording {
    let mut plant = Plant::draw(draws, sticks, seed);
    let (kc, ti) = draws.of(&[(0.8, 20.0), (1.5, 60.0), (1.1, 30.0), (0.6, 10.0)]);
    let td = draws.of(&[0.0, 0.0, 0.0, 1.0]);
    let every = draws.of(&[3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20]);
    let (resolution, of_pv) = (draws.of(resolutions), draws.of(&[0.0, 0.0, 0.1]));
    let (samples, late) = (draws.of(&[600, 1200, 2400]), draws.of(&[true, false, false]));
    let (mut whole, mut out, mut e1, mut e2) = (50.0f64, 50.0, 0.0, 0.0);
    let (mut op, mut pv) = (vec![], vec![]);
    for k in 0..samples + 200 {
        let (last, y) = (out, rounded(plant.step(out), of_pv));
        if k % every == 0 {
            let (e, t) = (50.0 - y, every as f64);
            whole += kc * (e - e1 + t / ti * e + td / t * (e - 2.0 * e1 + e2));
            whole = whole.clamp(0.0, 100.0);
            (e2, e1, out) = (e1, e, rounded(whole, resolution));
        }
        op.push(if late { last } else { out });
        pv.push(y);
    }
    let sp = vec![50.0; samples];
    let sp = draws.of(&[true, false]).then_some(&*sp);
    Recording::regular("FIC1", 1.0, &op[200..], Some(&pv[200..]), sp).unwrap()
}

/// A test by hand: growing, then shrinking turns, also of other sizes and holds than planned.
fn tested(draws: &mut Draws, sticks: bool, seed: u64) -> Recording {
    let mut plant = Plant::draw(draws, sticks, seed);
    let (growing, shrinking) = (draws.of(&[5, 7, 9]), draws.of(&[3, 6, 9]));
    let (each, hold) = (draws.of(&[2, 2, 4]), draws.of(&[8, 12, 20, 30]));
    let (resolution, careless) = (draws.of(&[0.0, 0.01, 0.1, 0.5]), draws.of(&[true, false]));
    let top = 0.4 * 1.6f64.powi(growing);
    let sizes = (0..growing)
        .map(|k| 0.4 * 1.6f64.powi(k))
        .chain((0..shrinking).map(|k| top * 0.85f64.powi(k)));
    let wanders = |k: i32| 50.0 + 1.5 * (0.02 * f64::from(k)).sin();
    let mut op: Vec<f64> = (0..draws.of(&[0, 200])).map(wanders).collect();
    let mut up = true;
    for size in sizes {
        for _ in 0..each {
            let by = if careless { draws.of(&[0.7, 1.0, 1.0, 1.0, 1.3]) } else { 1.0 };
            let held = if careless { draws.of(&[0.5, 0.8, 1.0, 1.4]) } else { 1.0 };
            let half = 0.5 * by * if up { size } else { -size };
            let turn = rounded(50.0 + half, resolution);
            op.extend(vec![turn; (held * f64::from(hold)) as usize]);
            up = !up;
        }
    }
    let pv: Vec<f64> = op.iter().map(|u| plant.step(*u)).collect();
    Recording::regular("FIC1", 1.0, &op, Some(&pv), None).unwrap()
}

/// An operator runs the loop of a good valve by hand, and moves the OP against a PV that is off.
fn run_by_hand(draws: &mut Draws, seed: u64) -> Recording {
    let mut plant = Plant::draw(draws, false, seed);
    let (every, off) = (draws.of(&[20, 40, 90]), draws.of(&[0.3, 0.6, 1.0]));
    let (mut u, mut op, mut pv) = (50.0, vec![], vec![]);
    for k in 0..1200 {
        let y = plant.step(u);
        op.push(u);
        pv.push(y);
        if k % every == 0 && (y - 50.0f64).abs() > off {
            u += rounded(0.7 * (50.0 - y), 0.1);
        }
    }
    let mut recording = Recording::regular("FIC1", 1.0, &op, Some(&pv), None).unwrap();
    let modes = vec![Mode::Automatic, Mode::Manual];
    recording.mode = Some(Modes { time: vec![0.0, 9.0], modes });
    recording
}

#[test]
fn a_good_valve_that_is_run_by_hand_is_not_accused() {
    let (mut draws, mut decided, mut accused) = (Draws(5), 0, 0);
    for seed in 0..60 {
        let verdict = crate::ramps::diagnosed(&run_by_hand(&mut draws, seed)).verdict;
        decided += u32::from(verdict.basis == Basis::ValveTest);
        accused += u32::from(
            verdict.basis == Basis::ValveTest && verdict.class != VerdictClass::DoesNotStick,
        );
    }
    println!("{decided} decided, {accused} accused");
    assert!(accused <= 1, "{accused} of 60");
}

/// The number of recordings in which a test is found by the OP alone, and by OP and PV.
fn found(all: impl Iterator<Item = Recording>) -> (usize, usize) {
    let found = |recording: &Recording| usize::from(ByHand::of(recording).is_some());
    all.fold((0, 0), |(by_op, by_both), recording| {
        let alone = Recording { pv: None, ..recording.clone() };
        (by_op + found(&alone), by_both + found(&recording))
    })
}

#[test]
fn slow_controllers_make_no_tests() {
    let mut draws = Draws(1);
    for (sticks, least) in [(false, 150), (true, 40)] {
        let loops = (0..600).map(|k| controlled(&mut draws, sticks, k, &FINE));
        let (by_op, by_both) = found(loops);
        assert!(by_op > least && by_both <= 3, "{sticks}: {by_op}, {by_both} of 600");
    }
}

/// Resolutions of an OP, percent.
const FINE: [f64; 5] = [0.0, 0.1, 0.1, 0.5, 1.0];
const COARSE: [f64; 3] = [2.0, 3.0, 5.0];

#[test]
fn coarse_controllers_make_no_staircases() {
    let mut draws = Draws(3);
    for sticks in [false, true] {
        let loops = (0..600).map(|k| controlled(&mut draws, sticks, k, &COARSE));
        let stairs = loops.filter(|of| ByHand::of(of).is_some_and(|found| found.is_staircase()));
        assert_eq!(stairs.count(), 0, "{sticks}");
    }
}

#[test]
fn staircases_by_a_stopwatch_are_found() {
    let mut draws = Draws(4);
    for (rungs, cycles) in [(3, 1), (3, 2), (4, 1), (4, 2), (6, 1)] {
        let made = (0..40).filter(|k| {
            let mut plant = Plant::draw(&mut draws, k % 2 == 0, *k);
            let (size, hold) = (draws.of(&[2.0, 3.0, 5.0]), draws.of(&[20, 40, 60]));
            let once = (0..rungs).chain((1..=rungs).rev());
            let levels = once.cycle().take(2 * cycles * rungs as usize).chain([0]);
            let op: Vec<f64> =
                levels.flat_map(|k| vec![50.0 + size * f64::from(k); hold]).collect();
            let pv: Vec<f64> = op.iter().map(|u| plant.step(*u)).collect();
            let recording = Recording::regular("FIC1", 1.0, &op, Some(&pv), None).unwrap();
            ByHand::of(&recording)
                .is_some_and(|by_hand| by_hand.turns() == levels_of(rungs, cycles))
        });
        assert_eq!(made.count(), 40, "{rungs} up and down, {cycles}");
    }
}

/// Held levels of a staircase.
fn levels_of(rungs: i32, cycles: usize) -> usize {
    2 * cycles * rungs as usize + 1
}

#[test]
fn tests_by_hand_are_found_as_often_as_by_the_op_alone() {
    let mut draws = Draws(2);
    for sticks in [false, true] {
        let (by_op, by_both) = found((0..150).map(|k| tested(&mut draws, sticks, k)));
        assert!(by_op > 140 && by_both + 1 >= by_op, "{sticks}: {by_op}, {by_both} of 150");
    }
}
