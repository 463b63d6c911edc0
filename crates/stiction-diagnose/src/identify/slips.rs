//! Whether the PV jumps when the valve of a model slips, and whether the OP travel before each slip is the same.

use crate::series::{mean, std};

/// The PV at the slips of the best model's valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slips {
    /// Slips a period.
    pub rate: f64,
    /// Concentration of the linear process's error at the slips. It is the logarithm of a ratio: share of the error's
    /// energy in the three samples at which each slip arrives, over the share of these samples in all samples.
    pub concentration: f64,
    /// Share of that energy that the sticking valve explains; negative if the sticking valve increases it.
    pub removed: f64,
    /// Steadiness of the PV's jumps; none for fewer than four reversals of the valve.
    pub steadiness: Option<Steadiness>,
}

/// Similarity of the moments at which the PV jumps after a reversal of the valve.
///
/// A jump is found without the valve's model: it is the largest error of the linear process within an eighth of a
/// period of the slip in the model. A sticking valve slips when the OP has travelled S, after any time. A load from
/// elsewhere comes at its own time, after any OP travel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steadiness {
    /// Coefficient of variation of the OP's travel since its last extreme.
    pub travel: f64,
    /// Coefficient of variation of the time between.
    pub time: f64,
    /// Standard deviation of the distance to the slips of the model, periods.
    pub jitter: f64,
}

impl Steadiness {
    /// Logarithm of the ratio of the variations of time and travel, each plus one percent, the limit of
    /// measurement. Large if travel is steadier.
    pub fn of_travel_over_time(&self) -> f64 {
        ((self.time + 0.01) / (self.travel + 0.01)).ln()
    }
}

/// Smallest number of reversals for a steadiness.
const FEWEST_REVERSALS: usize = 4;
/// Samples at which a slip arrives.
const ARRIVAL: usize = 3;
/// Largest distance of a jump from the slip of the model, periods.
const REACH: f64 = 0.125;
/// Distance back to the last extreme of the OP, periods.
const BACK: f64 = 0.75;

/// The motion of a valve.
pub(crate) struct Motion {
    /// Samples at which it began to move.
    pub slips: Vec<usize>,
    /// Samples at which the stem began to move in the opposite direction.
    pub reversals: Vec<usize>,
    /// Last direction, `+1` or `-1`, at every sample. Before the first motion it is the opposite of the first
    /// direction.
    pub direction: Vec<f64>,
}

impl Motion {
    /// For a valve at these positions.
    pub fn of(vp: &[f64]) -> Self {
        let (mut slips, mut reversals) = (vec![], vec![]);
        let mut direction = vec![0.0; vp.len()];
        let mut moving = false;
        for k in 1..vp.len() {
            let (dx, last) = (vp[k] - vp[k - 1], direction[k - 1]);
            direction[k] = last;
            if dx != 0.0 {
                direction[k] = dx.signum();
                let turns = last != 0.0 && direction[k] != last;
                if turns {
                    reversals.push(k);
                }
                if turns || !moving {
                    slips.push(k);
                }
            }
            moving = dx != 0.0;
        }
        if let Some(&first) = slips.first() {
            let before = -direction[first];
            direction[..first].fill(before);
        }
        Self { slips, reversals, direction }
    }
}

impl Slips {
    /// For a valve in `motion`, whose position acts after `delay` samples. `linear` and `sticky` are the errors of
    /// both processes from the sample `first` on.
    pub(super) fn of(
        motion: &Motion,
        op: &[f64],
        delay: usize,
        period: f64,
        first: usize,
        linear: &[f64],
        sticky: &[f64],
    ) -> Self {
        let mut arrives = vec![false; linear.len()];
        for &slip in &motion.slips {
            let from = (slip + delay).saturating_sub(first).min(arrives.len());
            let to = (slip + delay + ARRIVAL).saturating_sub(first).min(arrives.len());
            arrives[from..to].fill(true);
        }
        let energy = |e: &[f64]| -> f64 {
            e.iter().zip(&arrives).filter(|(_, a)| **a).map(|(e, _)| e * e).sum()
        };
        let all: f64 = linear.iter().map(|e| e * e).sum();
        let (before, after) = (energy(linear), energy(sticky));
        let share = arrives.iter().filter(|a| **a).count() as f64 / arrives.len() as f64;
        // If nothing arrives, or nothing remains to explain, both values are zero.
        let (concentration, removed) = if before > 0.0 {
            ((before / all / share).ln(), (1.0 - after / before).max(-1.0))
        } else {
            (0.0, 0.0)
        };
        Self {
            rate: motion.slips.len() as f64 * period / op.len() as f64,
            concentration,
            removed,
            steadiness: steadiness(motion, op, delay, period, first, linear),
        }
    }
}

fn steadiness(
    motion: &Motion,
    op: &[f64],
    delay: usize,
    period: f64,
    first: usize,
    error: &[f64],
) -> Option<Steadiness> {
    let reach = ((REACH * period) as usize).max(2);
    let (mut distances, mut times, mut travels) = (vec![], vec![], vec![]);
    for &slip in &motion.reversals {
        let expected = slip + delay;
        let (from, to) = ((expected.saturating_sub(reach)).max(first), expected + reach);
        if from >= to || to > op.len() {
            continue;
        }
        let size = |k: &usize| error[k - first].abs();
        let Some(struck) = (from..to).max_by(|a, b| size(a).total_cmp(&size(b))) else { continue };
        let left = struck.saturating_sub(delay);
        let since = &op[left.saturating_sub((BACK * period) as usize)..=left];
        let travel = |v: &f64| motion.direction[slip] * (op[left] - v);
        travels.push(since.iter().map(travel).fold(0.0, f64::max));
        times.push(struck as f64);
        distances.push(struck as f64 - expected as f64);
    }
    if travels.len() < FEWEST_REVERSALS {
        return None;
    }
    let between: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    let variation = |x: &[f64]| Some(std(x) / mean(x)).filter(|v| v.is_finite());
    Some(Steadiness {
        travel: variation(&travels)?,
        time: variation(&between)?,
        jitter: std(&distances) / period,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motion_is_distinguished_from_rest() {
        let motion = Motion::of(&[5.0, 5.0, 6.0, 7.0, 7.0, 8.0, 6.0, 6.0]);
        assert_eq!(motion.slips, [2, 5, 6]);
        assert_eq!(motion.reversals, [6]);
        assert_eq!(motion.direction, [-1.0, -1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0]);
        assert!(Motion::of(&[1.0; 4]).slips.is_empty());
    }

    #[test]
    fn equal_travel_in_unequal_times_is_steady() {
        // Ramps of one height and three slopes; struck when each has climbed by 10, at 2 later.
        let (mut op, mut error, mut vp) = (vec![], vec![], vec![]);
        let mut position = 0.0;
        for turn in 0..12 {
            let samples = [20, 25, 40][turn % 3];
            let up = turn % 2 == 0;
            for k in 0..samples {
                let way = 12.0 * k as f64 / samples as f64;
                op.push(if up { way } else { 12.0 - way });
                let slips = way >= 10.0 && 12.0 * (k as f64 - 1.0) / (samples as f64) < 10.0;
                if slips {
                    position = if up { 10.0 } else { 2.0 };
                }
                vp.push(position);
                error.push(if slips { 1.0 } else { 0.01 });
            }
        }
        error.rotate_right(2);
        let slips = Slips::of(&Motion::of(&vp), &op, 2, 56.0, 0, &error, &vec![0.01; error.len()]);
        let steadiness = slips.steadiness.unwrap();
        assert!(steadiness.travel < 0.03 && steadiness.time > 0.2, "{steadiness:?}");
        assert!(steadiness.jitter < 1e-12 && steadiness.of_travel_over_time() > 1.5);
        assert!(slips.removed > 0.99 && slips.concentration > 2.0, "{slips:?}");
    }
}
