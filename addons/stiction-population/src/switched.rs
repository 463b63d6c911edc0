//! A switched neighbour: a pump that starts and stops, or a block valve that opens and shuts.
//!
//! It changes its level at its own times, or when a vessel shared with this loop is full or empty.

use super::design::Design;
use super::draw::Draw;

/// A drawn switched neighbour.
#[derive(Debug, Clone)]
pub(super) struct Switched {
    course: Course,
    /// Effect at level 1: at the load, percent of OP, and at the PV, percent of span. One of these effects is 0.
    there: [f64; 2],
    /// Of the lag of its effect, a step.
    keep: f64,
    /// The step at which the record begins.
    warm_up: usize,
}

/// The source of its level, from 0 to 1.
#[derive(Debug, Clone)]
enum Course {
    /// The steps of its changes, and the level from then on.
    Timed(Vec<(usize, f64)>),
    /// A vessel that the neighbour empties and this loop fills, or the reverse.
    Vessel(Vessel),
}

/// A vessel with a constant outflow to the neighbour while it runs. Its contents are 0 when the neighbour stops and
/// 1 when it starts; flows are shares of that outflow.
#[derive(Debug, Clone)]
struct Vessel {
    /// Inflow while this loop is at rest.
    inflow: f64,
    /// Additional inflow per percent of this loop's flow.
    by_flow: f64,
    /// Whether the flow of this loop is its PV, or its valve position.
    of_pv: bool,
    /// Change of the contents per step for an inflow equal to the neighbour's outflow.
    rate: f64,
    /// Contents at the first step, and whether the neighbour runs.
    contents: f64,
    running: bool,
}

impl Switched {
    /// One whose changes are of lu(0.7, 4) activities.
    pub fn draw(design: &Design, draw: &mut Draw) -> Self {
        let step = design.step();
        let longest = (design.drawn() / 5.0).max(12.0 * design.pace);
        let dwell = draw.log(6.0 * design.pace, longest);
        let size = draw.sign() * (design.activity * draw.log(0.7, 4.0)).min(40.0);
        let at_pv = draw.chance(0.35);
        let lag = (design.response_time() * draw.log(0.02, 1.0)).min(dwell);
        let course = match draw.chance(0.5) {
            true => Course::Vessel(Vessel::draw(design, dwell / step, draw)),
            false => {
                let bounds = (3.0 * design.pace / step, longest / step);
                Course::Timed(changes(design.all_steps(), dwell / step, bounds, draw))
            }
        };
        let there = if at_pv { [0.0, size * design.gain] } else { [size, 0.0] };
        Self { course, there, keep: (-step / lag).exp(), warm_up: design.warm_up }
    }
}

impl Vessel {
    /// One in which the neighbour runs for about `dwell` steps at a time.
    fn draw(design: &Design, dwell: f64, draw: &mut Draw) -> Self {
        Self {
            inflow: draw.uniform(0.2, 0.8),
            by_flow: draw.sign() * draw.log(0.1, 1.0) / design.activity,
            of_pv: draw.chance(0.5),
            rate: 2.0 / dwell,
            contents: draw.unit(),
            running: draw.chance(0.5),
        }
    }

    /// The level of the neighbour after one more step.
    fn step(&mut self, flow: f64) -> f64 {
        // The inflow neither reverses nor exceeds the neighbour's outflow.
        let inflow = (self.inflow + self.by_flow * flow).clamp(0.05, 0.95);
        let level = f64::from(u8::from(self.running));
        self.contents += self.rate * (inflow - level);
        self.running = match self.running {
            true => self.contents > 0.0,
            false => self.contents >= 1.0,
        };
        f64::from(u8::from(self.running))
    }
}

/// Changes of a neighbour within `n` steps, with their levels. Two or three levels occur, each with its own mean time
/// within the bounds. Times are exponential, or vary by at most a fifth (40 %).
fn changes(n: usize, dwell: f64, (least, most): (f64, f64), draw: &mut Draw) -> Vec<(usize, f64)> {
    let three = draw.chance(0.4);
    let mut levels = vec![0.0, 1.0];
    if three {
        levels.push(draw.uniform(0.3, 0.7));
    }
    let means = [0; 3].map(|_| (dwell * draw.log(0.3, 3.0)).clamp(least, most));
    let regular = draw.chance(0.4).then(|| draw.uniform(0.0, 0.2));
    let (mut now, mut at) = (draw.count(0, levels.len() - 1), 0.0);
    let mut changes = vec![];
    while at < n as f64 {
        changes.push((at as usize, levels[now]));
        at += means[now]
            * match regular {
                Some(vary) => 1.0 + vary * draw.uniform(-1.0, 1.0),
                None => -(1.0 - draw.unit()).ln(),
            };
        now = (now + draw.count(1, levels.len() - 1)) % levels.len();
    }
    changes
}

/// The simulated switched neighbour.
pub(super) struct SwitchedRun<'a> {
    design: &'a Switched,
    /// Vessel, if the neighbour has one.
    vessel: Option<Vessel>,
    /// The remaining changes.
    ahead: &'a [(usize, f64)],
    level: f64,
    arrived: f64,
    /// Number of level changes during the record.
    pub switches: usize,
}

impl<'a> SwitchedRun<'a> {
    /// At its first level, to which the loop is already adapted.
    pub fn new(design: &'a Switched) -> Self {
        let (vessel, ahead, level) = match &design.course {
            Course::Vessel(vessel) => {
                (Some(vessel.clone()), &[][..], f64::from(u8::from(vessel.running)))
            }
            Course::Timed(changes) => (None, &changes[..], changes.first().map_or(0.0, |c| c.1)),
        };
        Self { design, vessel, ahead, level, arrived: level, switches: 0 }
    }

    /// Addition to the load, percent of OP, and to the PV, percent of span, after step `k`; `valve` and `pv` are the
    /// deviations of this loop's valve and PV from rest, percent of OP.
    pub fn step(&mut self, k: usize, valve: f64, pv: f64) -> [f64; 2] {
        let before = self.level;
        if let Some(vessel) = &mut self.vessel {
            self.level = vessel.step(if vessel.of_pv { pv } else { valve });
        }
        while let [(at, level), later @ ..] = self.ahead
            && *at <= k
        {
            (self.level, self.ahead) = (*level, later);
        }
        self.switches += usize::from(self.level != before && k >= self.design.warm_up);
        let keep = self.design.keep;
        self.arrived = keep * self.arrived + (1.0 - keep) * self.level;
        self.design.there.map(|there| there * self.arrived)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_within_their_bounds_and_levels_differ() {
        let n = 200_000;
        let mut three = 0;
        for seed in 0..30 {
            let found = changes(n, 100.0, (30.0, 400.0), &mut Draw::of(&[seed]));
            let mean = n as f64 / found.len() as f64;
            assert!((25.0..450.0).contains(&mean), "{mean}");
            assert!(found.windows(2).all(|two| two[0].0 <= two[1].0 && two[0].1 != two[1].1));
            assert!(found.iter().all(|(_, level)| (0.0..=1.0).contains(level)));
            three += usize::from(found.iter().any(|(_, level)| *level > 0.0 && *level < 1.0));
        }
        assert!((4..22).contains(&three), "{three} of 30 have three levels");
    }

    #[test]
    fn a_vessel_fills_the_sooner_the_more_flows_in() {
        let changes = |flow: f64| {
            let mut vessel = Vessel {
                inflow: 0.5,
                by_flow: 0.1,
                of_pv: false,
                rate: 0.02,
                contents: 0.0,
                running: false,
            };
            (0..20_000).scan(0.0, move |last, _| {
                let level = vessel.step(flow);
                let changed = level != *last;
                *last = level;
                Some((level, changed))
            })
        };
        let share = |flow: f64| changes(flow).map(|(level, _)| level).sum::<f64>() / 20_000.0;
        assert!((share(0.0) - 0.5).abs() < 0.03 && (share(3.0) - 0.8).abs() < 0.03);
        // It fills for 100 steps and is emptied in 100, and never stops.
        let count = changes(0.0).filter(|(_, changed)| *changed).count();
        assert!((190..=200).contains(&count), "{count}");
        assert!(changes(-1000.0).filter(|(_, changed)| *changed).count() > 10);
    }
}
