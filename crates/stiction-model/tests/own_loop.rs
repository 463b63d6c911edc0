//! Loops with parts of one's own: the same bits as with the library's, and what only they can do.

use crate::common;

use common::valve;
use stiction_model::Error;
use stiction_model::closed_loop::{
    AntiWindup, ClosedLoop, Controller, Form, Own, OwnController, OwnProcess, Process, Run, Signal,
};
use stiction_model::stem::{Stem, StemValve};
use stiction_model::valve::{Model, Start, Valve};

fn paper() -> ClosedLoop {
    let process = Process::first_order(1.5, 5.93, 1.0).unwrap();
    let controller = Controller::pi(1.1, 2.5).unwrap();
    let mut plant = ClosedLoop::new(controller, valve(Model::He, 5.0, 3.0), process);
    plant.set_point = Signal::step(50.0, 55.0, 20.0);
    (plant.op_rest, plant.pv_rest) = (40.0, 50.0);
    plant.load = vec![1.5.into(), Signal::RandomWalk { sd_per_sqrt_s: 0.05, seed: 3 }];
    plant.measurement = vec![Signal::Noise { sd: 0.05, tau_s: 0.0, seed: 7 }];
    plant.samples = 2_017;
    plant
}

fn assert_same_bits(a: &Run, b: &Run) {
    let bits = |run: &Run| -> Vec<u64> {
        [&run.sp, &run.pv, &run.op, &run.vp].into_iter().flatten().map(|x| x.to_bits()).collect()
    };
    assert!(bits(a) == bits(b));
}

#[test]
fn without_parts_of_ones_own_it_is_the_loop_itself() {
    let pid = Controller::pid(1.1, 2.5, 0.4).unwrap();
    let limited = pid.clone().with_limits(30.0, 60.0, AntiWindup::BackCalculation(3.0)).unwrap();
    let velocity = Controller::pi(0.9, 3.0).unwrap().with_form(Form::Velocity);
    let processes = [
        Process::integrator(0.2, 0.55).unwrap(),
        Process::second_order(1.2, 5.0, 2.0, 1.23).unwrap(),
        Process::transfer_function(&[1.0, 1.0], &[2.0, 3.0, 4.0, 1.0], 0.0).unwrap(),
    ];
    for model in Model::ALL {
        for controller in [paper().controller, pid.clone(), limited.clone(), velocity.clone()] {
            for process in &processes {
                let mut plant = paper();
                plant.valve = valve(model, 5.0, 3.0);
                (plant.controller, plant.process) = (controller.clone(), process.clone());
                assert_same_bits(&plant.run_with(Own::default()).unwrap(), &plant.run().unwrap());
                (plant.op_quantum, plant.pv_quantum) = (0.1, 0.02);
                assert_same_bits(&plant.run_with(Own::default()).unwrap(), &plant.run().unwrap());
            }
        }
    }
}

/// He's model again.
struct MyValve {
    fs: f64,
    fd: f64,
    position: f64,
}

impl Valve for MyValve {
    fn step(&mut self, op: f64) -> f64 {
        let e = op - self.position;
        if e.abs() > self.fs {
            self.position = op - e.signum() * self.fd;
        }
        self.position
    }

    fn position(&self) -> f64 {
        self.position
    }

    fn restart(&mut self, start: Start) {
        self.position = start.position;
    }
}

/// PI control again.
#[derive(Default)]
struct MyController {
    ki_ts: f64,
    integral: f64,
}

impl OwnController for MyController {
    fn restart(&mut self, sample_time: f64, op: f64, _sp: f64, _pv: f64) {
        (self.ki_ts, self.integral) = (1.1 / 2.5 * sample_time, op);
    }

    fn step(&mut self, sp: f64, pv: f64) -> f64 {
        let e = sp - pv;
        self.integral += self.ki_ts * e;
        1.1 * e + self.integral
    }
}

/// The first-order process again, with its ten samples of dead time.
#[derive(Default)]
struct MyProcess {
    a: f64,
    pv: f64,
    delayed: std::collections::VecDeque<f64>,
}

impl OwnProcess for MyProcess {
    fn restart(&mut self, sample_time: f64) {
        *self = Self { a: (-sample_time / 5.93f64).exp(), pv: 0.0, delayed: [0.0; 10].into() };
    }

    fn output(&self) -> f64 {
        self.pv
    }

    fn advance(&mut self, input: f64) {
        self.delayed.push_back(input);
        let input = self.delayed.pop_front().unwrap();
        self.pv = self.a * self.pv + 1.5 * (1.0 - self.a) * input;
    }
}

#[test]
fn parts_that_repeat_the_librarys_give_the_same_bits() {
    let plant = paper();
    let expected = plant.run().unwrap();
    let mut mine = MyValve { fs: 4.0, fd: 1.0, position: f64::NAN };
    let (mut controller, mut process) = (MyController::default(), MyProcess::default());
    // A second run begins again.
    for _ in 0..2 {
        let valve = Own { valve: Some(&mut mine), ..Own::default() };
        assert_same_bits(&plant.run_with(valve).unwrap(), &expected);
        let control = Own { controller: Some(&mut controller), ..Own::default() };
        assert_same_bits(&plant.run_with(control).unwrap(), &expected);
        let process_alone = Own { process: Some(&mut process), ..Own::default() };
        assert_same_bits(&plant.run_with(process_alone).unwrap(), &expected);
        let all = Own {
            controller: Some(&mut controller),
            valve: Some(&mut mine),
            process: Some(&mut process),
        };
        assert_same_bits(&plant.run_with(all).unwrap(), &expected);
    }
}

#[test]
fn a_physical_stem_makes_a_loop_cycle() {
    let mut plant = paper();
    (plant.load, plant.measurement) = (vec![], vec![]);
    plant.samples = 3_000;
    let stem = Stem::named("cts-stribeck").unwrap();
    let mut valve = StemValve::new(stem, plant.sample_time).unwrap();
    let run = plant.run_with(Own { valve: Some(&mut valve), ..Own::default() }).unwrap();
    assert_eq!(valve.fault(), None);
    assert!(run.half_pp(&run.vp) > 0.3, "{}", run.half_pp(&run.vp));
    // The loop has asked nothing else of it than to follow the OP.
    valve.restart(Start::at_rest(plant.op_rest));
    let mut vp = vec![0.0; run.op.len()];
    valve.run(&run.op, &mut vp).unwrap();
    assert_eq!(vp, run.vp);
}

#[test]
fn it_can_be_cancelled() {
    let mut asked = 0;
    let goes_on = || {
        asked += 1;
        asked < 3
    };
    let cancelled = paper().run_with_progress(Own::default(), goes_on);
    assert_eq!(cancelled, Err(Error::Cancelled));
    assert_eq!(asked, 3);
    let mut wrong = paper();
    wrong.pv_quantum = -1.0;
    assert!(wrong.run_with(Own::default()).is_err());
}
