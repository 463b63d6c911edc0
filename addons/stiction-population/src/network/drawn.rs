//! Random draw of a network. `docs/population.md` describes the distributions.

use super::{
    Course, Design, Link, LinkKind, Network, NetworkLoop, NetworkPlan, Outside, ProcessKind, STEP_S,
};
use crate::design::Curve;
use crate::draw::Draw;
use stiction_diagnose::diagnose::HARMLESS;
use stiction_diagnose::recording::LoopType;
use stiction_model::closed_loop::{Signal, Wave};
use stiction_model::valve::Model;

/// Sample times of a historian, s.
const SAMPLE_TIMES: [f64; 6] = [5.0, 10.0, 15.0, 20.0, 30.0, 60.0];
/// Longest delay of a link, s.
const LATEST_S: f64 = 600.0;

/// The role of a loop in the network.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Alone,
    /// It writes the set point of the next loop.
    Above,
    /// The loop before it writes its set point, from this OP on; s is its response time.
    Below,
}

/// The plan of a seed.
pub fn plan(seed: u64) -> NetworkPlan {
    let draw = &mut Draw::of(&[seed, 0x4e70]);
    let loops = draw.log(5.0, 51.0) as usize;
    let coupled = draw.chance(0.75);
    let sources = draw.count(0, 3.min(loops / 3));
    let mut sticking = vec![];
    while sticking.len() < sources {
        let k = draw.count(0, loops - 1);
        if !sticking.contains(&k) {
            sticking.push(k);
        }
    }
    sticking.sort_unstable();
    let outside = draw.weighted([(0, 0.55), (1, 0.35), (2, 0.1)]);
    NetworkPlan { loops, sticking, outside, coupled }
}

/// The network of a validated plan.
pub fn network(seed: u64, plan: &NetworkPlan) -> Network {
    let draw = &mut Draw::of(&[seed, 0x4e71]);
    let n = plan.loops;
    let mut places = vec![Place::Alone; n];
    for k in 0..n.saturating_sub(1) {
        let has_valve = plan.sticking.contains(&k);
        if plan.coupled && places[k] == Place::Alone && draw.chance(0.12) && !has_valve {
            (places[k], places[k + 1]) = (Place::Above, Place::Below);
        }
    }
    let mut loops: Vec<NetworkLoop> = vec![];
    // From the last on: a loop above must wait for the one below.
    for k in (0..n).rev() {
        let sticks = plan.sticking.contains(&k);
        let below = (places[k] == Place::Above).then(|| loops.last()).flatten();
        let mut each = one(places[k], below, &mut draw.fork());
        if sticks {
            each.course = Course::Sticks;
        }
        each.below = (places[k] == Place::Above).then_some(k + 1);
        loops.push(each);
    }
    loops.reverse();
    let mut links = vec![];
    let mut outside = vec![];
    if plan.coupled {
        links = links_of(&loops, &places, &plan.sticking, draw);
    }
    for _ in 0..plan.outside {
        let most = if plan.coupled { 6 } else { 1 };
        outside.push(wave(n, most.min(n), draw));
    }
    Network { loops, links, outside }
}

/// Draws a loop. A master loop waits for its slave loop `below`.
fn one(place: Place, below: Option<&NetworkLoop>, draw: &mut Draw) -> NetworkLoop {
    let process = match place {
        Place::Below => ProcessKind::FirstOrder,
        Place::Above => {
            draw.weighted([(ProcessKind::FirstOrder, 0.5), (ProcessKind::SecondOrder, 0.5)])
        }
        Place::Alone => draw.weighted([
            (ProcessKind::FirstOrder, 0.5),
            (ProcessKind::SecondOrder, 0.25),
            (ProcessKind::Integrating, 0.25),
        ]),
    };
    let fast = place == Place::Below
        || place == Place::Alone && process == ProcessKind::FirstOrder && draw.chance(0.7);
    let mut tau = match process {
        ProcessKind::Integrating => draw.log(200.0, 2000.0),
        _ if fast => draw.log(8.0, 60.0),
        _ => draw.log(60.0, 1200.0),
    };
    let mut dead_time = match process {
        ProcessKind::Integrating => draw.log(5.0, 60.0),
        _ => tau * draw.log(0.05, 0.8),
    };
    if let Some(below) = below {
        tau = tau.max(3.0 * (below.design.tau + below.design.dead_time));
        dead_time += below.design.dead_time;
    }
    let tau2 = if process == ProcessKind::SecondOrder { tau * draw.uniform(0.1, 0.6) } else { 0.0 };
    let waits_below = below.map_or(0.0, |below| 2.0 * (below.design.tau + below.design.dead_time));
    let waiting = dead_time + 0.5 * tau2 + STEP_S + waits_below;
    let gain = draw.log(0.4, 2.5) * draw.sign();
    let slowness = match process {
        ProcessKind::Integrating => draw.log(2.0, 20.0),
        _ => draw.log(0.6, 4.0),
    };
    let waits = waiting * (1.0 + slowness);
    // One in fifteen rings by its tuning.
    let hasty = if draw.chance(0.07) { 0.75 * (1.0 + slowness) } else { 1.0 };
    let kc = hasty * (tau + 0.5 * tau2) / (gain * waits);
    let ti = match process {
        ProcessKind::Integrating => 4.0 * waits,
        _ => (tau + 0.5 * tau2).min(4.0 * waits),
    } * draw.log(0.6, 1.6);
    let s = draw.log(2.0, 12.0);
    let at_most = (0.4 * waits).max(STEP_S);
    let sample_time_s = draw.one_of(SAMPLE_TIMES);
    let sample_time_s =
        SAMPLE_TIMES.into_iter().rev().find(|t| *t <= sample_time_s.min(at_most)).unwrap_or(STEP_S);
    let span = 10f64.powf(draw.uniform(0.0, 3.0));
    let noise_tau = if draw.chance(0.3) { draw.log(5.0, 60.0) } else { 0.0 };
    NetworkLoop {
        loop_type: match (process, fast) {
            (ProcessKind::Integrating, _) => LoopType::Level,
            (_, true) => LoopType::Flow,
            _ => draw.one_of([LoopType::Temperature, LoopType::Pressure]),
        },
        process,
        sample_time_s,
        model: draw.weighted([(Model::TwoPhase, 0.7), (Model::He, 0.3)]),
        s,
        j: s * draw.uniform(0.2, 1.0),
        course: Course::Healthy,
        manual: None,
        below: None,
        design: Design {
            gain,
            tau,
            tau2,
            dead_time,
            curve: match draw.unit() {
                place if place < 0.5 => Curve::Linear,
                place if place < 0.75 => {
                    Curve::Exponential { rate: draw.sign() * draw.log(0.003, 0.02) }
                }
                _ => Curve::Kinked { below: draw.log(0.75, 1.33), above: draw.log(0.75, 1.33) },
            },
            kc,
            ti,
            dead_band: if draw.chance(0.5) { draw.uniform(0.0, HARMLESS) } else { 0.0 },
            op_rest: draw.uniform(35.0, 65.0),
            pv_rest: draw.uniform(35.0, 65.0),
            load: Signal::Noise {
                sd: draw.log(0.2, 2.0),
                tau_s: draw.log(600.0, 20_000.0),
                seed: draw.seed(),
            },
            noise: Signal::Noise {
                sd: gain.abs() * draw.log(0.02, 0.4),
                tau_s: noise_tau,
                seed: draw.seed(),
            },
            moves: (place != Place::Below && draw.chance(0.25))
                .then(|| (draw.log(3600.0, 40_000.0), gain.abs() * draw.uniform(0.5, 4.0))),
            op_quantum: draw.one_of([0.0, 0.01, 0.1]),
            pv_quantum: draw.one_of([0.0, 0.01, 0.05]),
            pv_range: (if draw.chance(0.6) { 0.0 } else { span * draw.uniform(-0.5, 2.0) }, span),
            seed: draw.seed(),
        },
    }
}

fn links_of(
    loops: &[NetworkLoop],
    places: &[Place],
    sticking: &[usize],
    draw: &mut Draw,
) -> Vec<Link> {
    let n = loops.len();
    let mut links = vec![];
    for to in 1..n {
        // Material flows from unit to unit; some units are fed from elsewhere.
        if places[to] == Place::Below || !draw.chance(0.7) {
            continue;
        }
        let near = to.saturating_sub(4);
        // A sticking valve feeds more neighbours than others do, because these are the subject of the search.
        let feeds = sticking.iter().copied().rfind(|k| (near..to).contains(k));
        let from = match feeds {
            Some(source) if draw.chance(0.7) => source,
            _ => to - draw.count(1, to - near),
        };
        links.push(Link {
            from,
            to,
            kind: LinkKind::MassBalance,
            gain: draw.sign() * draw.log(0.4, 1.5),
            dead_s: draw.log(5.0, LATEST_S),
            lag_s: draw.log(5.0, 120.0),
        });
        if draw.chance(0.12) {
            links.push(Link {
                from: to,
                to: from,
                kind: LinkKind::Recycle,
                gain: draw.sign() * draw.log(0.05, 0.4),
                dead_s: draw.log(30.0, LATEST_S),
                lag_s: draw.log(200.0, 3000.0),
            });
        }
    }
    for _ in 0..draw.count(0, n / 8) {
        let first = draw.count(0, n - 1);
        let members: Vec<usize> = (first..(first + draw.count(2, 4)).min(n))
            .filter(|k| loops[*k].below.is_none())
            .collect();
        let gain = -draw.log(0.1, 0.5);
        for from in &members {
            for to in members.iter().filter(|to| *to != from) {
                let (dead_s, lag_s) = (STEP_S, draw.log(5.0, 30.0));
                links.push(Link {
                    from: *from,
                    to: *to,
                    kind: LinkKind::Header,
                    gain,
                    dead_s,
                    lag_s,
                });
            }
        }
    }
    links
}

/// A wave into up to `most` loops: a sine, a square or a triangle.
fn wave(n: usize, most: usize, draw: &mut Draw) -> Outside {
    let period_s = draw.log(200.0, 7200.0);
    let periodic = |wave: Wave, phase: f64| Signal::Periodic {
        wave,
        mean: 0.0,
        amplitude: 1.0,
        period_s,
        phase,
    };
    let phase = draw.unit();
    let wave = draw.one_of([Wave::Sine, Wave::Square, Wave::Ramp]);
    let mut into: Vec<(usize, f64)> = vec![];
    let wanted = draw.count(1.min(most), most);
    while into.len() < wanted {
        let k = draw.count(0, n - 1);
        if into.iter().all(|(other, _)| *other != k) {
            into.push((k, draw.sign() * draw.log(0.5, 4.0)));
        }
    }
    Outside { wave: periodic(wave, phase), period_s, into }
}
