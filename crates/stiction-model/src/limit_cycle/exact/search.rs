//! The end of a motion, and the orbits it leads to.

use super::super::Cycle;
use super::flow::{Event, Flow, Stem};
use super::growth::Growth;
use super::orbit::{Orbit, PATIENCE, Shooting, State, measure};
use super::plant::{Plant, STATES};
use super::{CycleOutcome, NoCycle, Trajectory};
use std::collections::VecDeque;

/// Largest number of slips of a motion.
const SLIPS: usize = 600;
/// Number of slips after which growth beyond friction is checked. Most motions have ended by then.
const GROWING: usize = 8;
/// Largest number of slips of a period, or of half of it.
const LONGEST: usize = 12;

/// The end of a motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum End {
    /// To the orbit of this index.
    Orbit(usize),
    /// To no cycle.
    Quiet(NoCycle),
    /// Not known.
    Unknown(String),
}

/// A slip of the motion.
#[derive(Debug, Clone, Copy)]
struct Slip {
    /// Multiplied by its sign so that the slip is upward.
    state: State,
    direction: f64,
    time: f64,
    clean: bool,
    /// Remaining steps of the flow.
    steps: usize,
}

/// How a motion creeps towards a cycle on which the stem never rests for a dead time, so that Newton's method has
/// no vector to work on.
///
/// There the stem is farther out at each slip, by a nearly constant share of the remaining distance. So the remaining
/// distance is known (Aitken's extrapolation), and the whole motion is enlarged by this distance. The errors of the
/// enlarged motion decay in the next slips.
#[derive(Debug, Default)]
struct Creep {
    /// Distances of the stem, the latest last.
    sizes: Vec<f64>,
}

impl Creep {
    /// Slips between one enlargement and the next.
    const PAUSE: usize = 8;

    /// Factor by which to enlarge the motion, with distance `size` at a slip.
    fn ahead(&mut self, size: f64, clean: bool) -> Option<f64> {
        if clean {
            self.sizes.clear();
        }
        self.sizes.push(size);
        let n = self.sizes.len();
        if n < Self::PAUSE {
            return None;
        }
        let gain = |k: usize| self.sizes[n - k] - self.sizes[n - k - 1];
        let (ratio, before) = (gain(1) / gain(2), gain(2) / gain(3));
        // Only approaches are shortened: with a ratio above 1 it would be a repelling orbit.
        let steady = (ratio - before).abs() < 0.2 * (1.0 - ratio);
        if !(ratio > 0.5 && ratio < 0.9999 && steady && gain(1).abs() > 1e-11 * size) {
            return None;
        }
        let missing = gain(1) * ratio / (1.0 - ratio);
        self.sizes.clear();
        Some((1.0 + missing / size).clamp(0.5, 2.0))
    }
}

/// An orbit and its cycle in units.
#[derive(Debug, Clone)]
pub(super) struct Found<'a> {
    /// `None` if the motion settled on the orbit but shooting does not apply.
    pub(super) orbit: Option<Orbit<'a>>,
    pub(super) cycle: Cycle,
    /// The motion on the orbit, with a slip due.
    begin: Flow<'a, f64>,
}

impl Found<'_> {
    /// One period of the cycle, `op_unit` percent to 1.
    pub(super) fn trajectory(&self, samples: usize, op_unit: f64) -> Option<Trajectory> {
        let mut flow = self.begin.clone();
        let period = self.cycle.period_s / flow.plant.time_s;
        flow.record(period / samples as f64);
        for _ in 0..self.cycle.slips {
            flow.slip();
            if flow.run_to_slip() != Event::Slips {
                return None;
            }
        }
        flow.recorded(op_unit)
    }
}

/// The known orbits of a loop.
#[derive(Debug)]
pub(super) struct Search<'a> {
    pub(super) plant: &'a Plant,
    pub(super) stem: Stem,
    pub(super) op_unit: f64,
    pub(super) found: Vec<Found<'a>>,
}

impl<'a> Search<'a> {
    pub(super) fn new(plant: &'a Plant, stem: Stem, op_unit: f64) -> Self {
        Self { plant, stem, op_unit, found: vec![] }
    }

    /// Follows the motion that starts with the stem stuck at `position`.
    pub(super) fn follow(&mut self, state: State, position: f64) -> End {
        let mut flow = Flow::stuck(self.plant, self.stem, state, position, PATIENCE);
        let mut past: VecDeque<Slip> = VecDeque::with_capacity(2 * LONGEST + 2);
        let mut attempt = 2;
        let (mut size, mut falls) = (f64::INFINITY, 0);
        let mut growth = None;
        let mut creep = Creep::default();
        for n in 0..SLIPS {
            match flow.run_to_slip() {
                Event::Slips => {}
                Event::Rests { moving } => return End::Quiet(NoCycle::Rests { moving }),
                Event::Diverges => return End::Quiet(NoCycle::Diverges),
                Event::Exhausted => {
                    return End::Unknown(format!("the motion was not settled after {n} slips"));
                }
            }
            let direction = flow.direction;
            past.push_front(Slip {
                state: flow.state.map(|w| w * direction),
                direction,
                time: flow.time,
                clean: flow.is_clean(),
                steps: flow.steps,
            });
            past.truncate(2 * LONGEST + 2);

            if n == attempt {
                attempt += 1 + attempt / 3;
                if let Some(end) = self.shoot(&past) {
                    return end;
                }
            }
            if n > 8
                && let Some((lag, mirrored)) = self.settled(&past)
            {
                return self.keep_settled(flow, &past, lag, mirrored);
            }
            if n >= GROWING
                && growth
                    .get_or_insert_with(|| Growth::of(self.plant))
                    .as_ref()
                    .is_some_and(|growth| growth.is_certain(&flow))
            {
                return End::Quiet(NoCycle::Diverges);
            }
            if let Stem::Follows { .. } = self.stem
                && let Some(factor) = creep.ahead(flow.position.abs(), flow.is_clean())
            {
                flow.enlarge(factor);
            }
            // Without a slip jump the stroke may shrink to zero, ever more slowly.
            let now = flow.position.abs();
            if self.is_play() {
                let ratio = now / size;
                falls = if ratio < 0.9999 { falls + 1 } else { 0 };
                if now < 1e-2 && falls > 1 {
                    return End::Quiet(NoCycle::Decays { ratio });
                }
                size = now;
            }
            flow.slip();
        }
        End::Unknown(format!(
            "the motion neither settled nor came to rest in {SLIPS} slips, and a search from this motion found no nearby \
             orbit"
        ))
    }

    fn is_play(&self) -> bool {
        self.stem == Stem::Follows { fd: 1.0 }
    }

    /// Distance of two states.
    fn distance(&self, a: &State, b: &State) -> f64 {
        let (mut gap, mut size) = (0f64, 1f64);
        for i in 0..self.plant.order {
            gap = gap.max((a[i] - b[i]).abs());
            size = size.max(a[i].abs());
        }
        gap / size
    }

    /// Tries to find an orbit near the last slips; the end, if the motion approaches it.
    fn shoot(&mut self, past: &VecDeque<Slip>) -> Option<End> {
        let last = past[0];
        if !last.clean {
            return None;
        }
        let lags: Vec<(usize, f64)> = (1..past.len().min(LONGEST + 1))
            .filter(|k| past[*k].clean)
            .map(|k| (k, self.distance(&last.state, &past[k].state)))
            .collect();
        let nearest = lags.iter().map(|lag| lag.1).fold(f64::INFINITY, f64::min);
        let lag = lags.iter().find(|lag| lag.1 < 1.2 * nearest + 1e-9 && lag.1 < 0.7)?.0;
        let index = self.known(&last.state).map_or_else(
            || {
                let direction = last.direction * past[lag].direction;
                self.newton(&last.state, lag, direction, past[lag].steps - last.steps)
            },
            Some,
        )?;
        let orbit = self.found[index].orbit.as_ref()?;
        let near = self.distance(&last.state, &orbit.state) < 0.5;
        (near && orbit.is_stable()).then_some(End::Orbit(index))
    }

    /// The attracting orbit that has this state at its slip.
    fn known(&self, state: &State) -> Option<usize> {
        self.found.iter().position(|found| {
            found
                .orbit
                .as_ref()
                .is_some_and(|o| o.is_stable() && self.distance(state, &o.state) < 1e-4)
        })
    }

    /// The index of the orbit that Newton's method finds from `guess`, from which the motion took `steps` steps. A
    /// nearby orbit takes about as many, and a search that diverges takes more and more.
    pub(super) fn newton(
        &mut self,
        guess: &State,
        slips: usize,
        direction: f64,
        steps: usize,
    ) -> Option<usize> {
        let patience = (10 * steps + 100).min(PATIENCE);
        let map = Shooting { plant: self.plant, stem: self.stem, slips, direction, patience };
        let mut orbit = map.orbit(guess)?;
        // Its shortest period or half period.
        'shorter: for part in 1..slips {
            if slips.is_multiple_of(part) {
                for direction in [-1.0, 1.0] {
                    let map = Shooting { slips: part, direction, ..map };
                    let shorter = map.orbit(&orbit.state);
                    if let Some(o) =
                        shorter.filter(|o| self.distance(&o.state, &orbit.state) < 1e-7)
                    {
                        orbit = o;
                        break 'shorter;
                    }
                }
            }
        }
        let cycle = orbit.cycle(self.op_unit)?;
        let begin = Flow::slipping(self.plant, self.stem, orbit.state, PATIENCE);
        Some(self.keep(Found { orbit: Some(orbit), cycle, begin }))
    }

    /// Adds an orbit unless it is known, and returns its index.
    fn keep(&mut self, new: Found<'a>) -> usize {
        let same = |a: f64, b: f64| (a - b).abs() <= 1e-7 * a.abs().max(b.abs());
        let known = self.found.iter().position(|old| {
            let (a, b) = (&old.cycle, &new.cycle);
            same(a.period_s, b.period_s)
                && same(a.half_pp.op, b.half_pp.op)
                && same(a.half_pp.vp, b.half_pp.vp)
                && same(a.half_pp.pv, b.half_pp.pv)
        });
        known.unwrap_or_else(|| {
            self.found.push(new);
            self.found.len() - 1
        })
    }

    /// The lag after which the slips repeat, to rounding, and whether mirrored.
    fn settled(&self, past: &VecDeque<Slip>) -> Option<(usize, bool)> {
        const SAME: f64 = 1e-11;
        (1..=LONGEST).find_map(|lag| {
            if past.len() < 2 * lag + 1 {
                return None;
            }
            let mirrored = past[0].direction != past[lag].direction;
            let repeats = (0..=lag).all(|i| {
                let (a, b) = (&past[i], &past[i + lag]);
                self.distance(&a.state, &b.state) < SAME && (a.direction != b.direction) == mirrored
            });
            let times = (past[0].time - past[lag].time) - (past[lag].time - past[2 * lag].time);
            let moves = past[0].time - past[lag].time > 1e-9;
            (repeats && moves && times.abs() < 1e-9 * past[0].time).then_some((lag, mirrored))
        })
    }

    /// A motion that repeats itself although shooting has not found it.
    fn keep_settled(
        &mut self,
        mut flow: Flow<'a, f64>,
        past: &VecDeque<Slip>,
        lag: usize,
        mirrored: bool,
    ) -> End {
        if past[0].clean && past[lag].clean {
            let direction = if mirrored { -1.0 } else { 1.0 };
            if let Some(index) =
                self.newton(&past[0].state, lag, direction, past[lag].steps - past[0].steps)
            {
                return End::Orbit(index);
            }
        }
        let begin = flow.clone();
        flow.watch();
        for _ in 0..lag {
            flow.slip();
            if flow.run_to_slip() != Event::Slips {
                return End::Unknown(
                    "the slips of a motion repeated, but the next slip was missing".to_owned(),
                );
            }
        }
        let cycle = measure(self.plant, &flow, flow.time - begin.time, mirrored, self.op_unit);
        let Some(mut cycle) = cycle else {
            return End::Unknown("a motion that repeats itself could not be measured".to_owned());
        };
        cycle.slips = lag * if mirrored { 2 } else { 1 };
        End::Orbit(self.keep(Found { orbit: None, cycle, begin }))
    }

    /// The initial state that leads most loops to their cycle: the stem is stuck half a jump below the equilibrium, and
    /// everything else is at rest there.
    pub(super) fn first(&self) -> (State, f64) {
        let position = match self.stem {
            Stem::Follows { fd } if fd < 1.0 => -0.5 * (1.0 - fd),
            Stem::Follows { .. } => -0.5,
            Stem::Jumps { jump } => -0.5 * jump,
        };
        ([0.0; STATES], position)
    }

    /// Other initial states, from far within the friction bands to far outside: each state off its equilibrium, and
    /// the loop at rest elsewhere before its set point or load changes.
    pub(super) fn starts(&self) -> Vec<(State, f64)> {
        let (_, position) = self.first();
        let mut all = vec![];
        for size in [0.3, 1.0, 3.0, 10.0, 100.0] {
            for i in 0..self.plant.order {
                // One unit of OP for each state that affects the OP, one unit of the state for others.
                let unit = if self.plant.c[i] == 0.0 { 1.0 } else { 1.0 / self.plant.c[i].abs() };
                for sign in [1.0, -1.0] {
                    let mut state = [0.0; STATES];
                    state[i] = size * unit;
                    all.push((state, sign * position));
                }
            }
            for ahead in [-0.9, 0.0, 0.9] {
                all.push((self.plant.resting(-size, -size + ahead), -size));
            }
        }
        all
    }

    /// The end of a single motion, without other orbits met before.
    pub(super) fn only(mut self, end: End) -> CycleOutcome {
        match end {
            End::Orbit(index) => self.found = vec![self.found.swap_remove(index)],
            End::Quiet(_) | End::Unknown(_) => self.found.clear(),
        }
        self.outcome(vec![end])
    }

    /// The orbits met before, and `ends` of other motions, as an outcome.
    pub(super) fn outcome(self, ends: Vec<End>) -> CycleOutcome {
        let mut cycles: Vec<Cycle> = self.found.into_iter().map(|found| found.cycle).collect();
        cycles.sort_by(|a, b| b.stable.cmp(&a.stable).then(a.half_pp.op.total_cmp(&b.half_pp.op)));
        let mut beside: Vec<NoCycle> = vec![];
        let mut unknown = None;
        for end in ends {
            match end {
                End::Orbit(_) => {}
                End::Quiet(reason) => {
                    let kind = std::mem::discriminant(&reason);
                    if beside.iter().all(|known| std::mem::discriminant(known) != kind) {
                        beside.push(reason);
                    }
                }
                End::Unknown(reason) => unknown = Some(reason),
            }
        }
        match (cycles.is_empty(), beside.first(), unknown) {
            (false, _, unsettled) => CycleOutcome::Cycles { cycles, beside, unsettled },
            (true, _, Some(reason)) => CycleOutcome::NotFound { reason },
            (true, Some(_), None) => CycleOutcome::None { reasons: beside },
            (true, None, None) => {
                CycleOutcome::NotFound { reason: "no motion was followed".to_owned() }
            }
        }
    }
}
