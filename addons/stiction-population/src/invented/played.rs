//! Simulation of a loop of a kind.

use super::parts::{Friction, Line, Parts, Pi};
use super::sketch::Sketch;
use super::{Invented, Invention};
use crate::draw::Draw;
use crate::plant::{Hand, Nobody};
use crate::visibility;
use stiction_diagnose::recording::Recording;
use stiction_diagnose::series::{max, min, std};
use stiction_model::closed_loop::NormalStream;
use stiction_model::error::Result;

impl Sketch {
    /// The simulated loop of a kind, with a sticking or a healthy valve.
    ///
    /// # Errors
    /// If the settings of a part are invalid.
    pub fn play(&self, what: Invention, sticks: bool) -> Result<Invented> {
        self.play_with(what.parts(self), sticks, &mut Nobody)
    }

    /// The simulated loop of these parts, with a manual source of the OP.
    ///
    /// # Errors
    /// If the settings of a part are invalid.
    pub fn play_with(
        &self,
        mut parts: Box<dyn Parts>,
        sticks: bool,
        hand: &mut dyn Hand,
    ) -> Result<Invented> {
        let warm_up = self.warm_up();
        let n = warm_up + self.recorded();
        let mut draws = NormalStream::new(self.seed);
        let mut events = Draw::of(&[self.seed]);
        let jumps: Vec<(usize, f64)> = (0..self.steps_of_load)
            .map(|_| (events.count(warm_up, n - 1), events.sign() * events.uniform(0.3, 1.5)))
            .collect();
        let mut pi = Pi::of(self, parts.steepest());
        let mut valve = Friction::of(self, sticks)?;
        let mut line = Line::of(self.dead);
        let (mut wander, mut y, mut lagged) = (0.0, 0.0, [0.0; 2]);
        let mut op_before = None;
        let [mut set_point, mut op, mut pv, mut stem] =
            [vec![], vec![], vec![], vec![]].map(|v: Vec<f64>| v);
        for k in 0..n {
            let sp = parts.set_point(k);
            let sensed = parts.sensed(k, y, self.gain.abs() * self.noise * draws.draw());
            let own = parts.op(k, &mut pi, sp - sensed);
            let before = op_before.unwrap_or(own);
            let held = hand.op(k, sensed, sp, before).map(|op| op.clamp(0.0, 100.0));
            if let Some(held) = held {
                pi.track(held, sp - sensed);
            }
            let u = held.unwrap_or(own);
            op_before = Some(u);
            let x = parts.stem(&mut valve, u);
            wander = self.load_keep * wander
                + (1.0 - self.load_keep.powi(2)).sqrt() * self.load * draws.draw();
            let jump: f64 =
                jumps.iter().filter(|(at, _)| *at <= k).map(|(_, by)| by * self.load).sum();
            let flow = parts.flow(k, x - self.rest);
            let load = wander + jump + parts.load(y);
            let mut through = parts.late(&mut line, self.gain * (flow + load));
            for (state, lag) in lagged.iter_mut().zip(self.lags) {
                *state += (through - *state) * (1.0 - (-1.0 / lag).exp());
                through = *state;
            }
            y = parts.pv(through);
            if k >= warm_up {
                set_point.push(sp);
                op.push(u);
                pv.push(sensed);
                stem.push(x);
            }
        }
        let last = |x: &[f64]| -> Vec<f64> {
            x.chunks_exact(self.steps).map(|sample| sample[self.steps - 1]).collect()
        };
        let [recorded_sp, recorded_op, recorded] = [&set_point, &op, &pv].map(|x| last(x));
        let slips = stem.windows(3).filter(|x| x[0] == x[1] && x[1] != x[2]).count();
        let gain = visibility::Observed {
            recorded: &recorded,
            pv: &pv,
            op: &op,
            stem: &stem,
            steps: self.steps,
            dead_time: self.dead as f64,
        }
        .gain();
        let at_end = op.iter().filter(|u| **u <= 0.0 || **u >= 100.0).count();
        let serves = op.iter().chain(&pv).all(|v| v.is_finite())
            && max(&op) - min(&op) > 0.3 * self.s
            && at_end < op.len() / 20
            && std(&pv) > 0.0
            && parts.shows();
        let (offset, unit) = self.unit;
        let [sp, pv] = [recorded_sp, recorded]
            .map(|x| -> Vec<f64> { x.iter().map(|v| offset + unit * v).collect() });
        let recording =
            Recording::regular("", self.sample_time, &recorded_op, Some(&pv), Some(&sp))?;
        let known = |v: f64| if sticks { v } else { 0.0 };
        let visible = sticks && slips > 0 && gain >= visibility::NATS;
        Ok(Invented { recording, sticks, visible, s: known(self.s), j: known(self.j), serves })
    }
}
