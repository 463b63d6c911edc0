//! Sharp corners of the cycles of control error and OP (HAW Hamburg).
//!
//! # What it measures
//! In a linear loop, OP and control error move along an ellipse. When a sticking valve slips, both reverse at once: the
//! cycle has two corners, one for each slip. Each cycle is compared with an ellipse. The parts around its outermost
//! points are reduced to the fewest points that describe them. Two straight arms and a corner are three points.
//!
//! # Assumptions
//! An oscillation of at least 16 samples per period whose cycles resemble ellipses; noise that averages
//! out within a 48th of a cycle.
//!
//! # Equations
//! * cycles: between upward crossings of zero of the error, limited to half to twice the frequency of the
//!   oscillation. Each is reduced to at most 48 means of equal duration, and long sides of the polygon through
//!   them, at jumps of a signal, are filled with points;
//! * similarity: one less the residual of the [`Ellipse`] fitted to the cycle;
//! * corner: in coordinates in which that ellipse is the unit circle, the points within 60° of the point farthest from
//!   the centre, and of the farthest on the other side. Douglas and Peucker's method keeps as few points as possible.
//!   No other point may be farther than the tolerance from the line through the kept points;
//! * sharp: three points. The arc of a circle has five: each half of it, 60°, bulges by
//!   `1 - cos 30° = 0.134` from its chord, and the tolerance is half of this;
//! * more than five points are noise; undecided if most corners are noise;
//! * share of sharp corners in the sharp and blunt corners of all similar cycles; magnitude: the mean width of the
//!   ellipses along the OP.
//!
//! # Parameters
//! | name | default | unit | source |
//! |---|---|---|---|
//! | similarity | 0.5 | | read in a user's guide |
//! | reach | 60 | ° | ours |
//! | tolerance | 0.067 | radii | ours, half of the arc's bulge |
//! | share | 0.5 | | ours |
//!
//! # Limits
//! A triangular or square disturbance makes corners without stiction, and a slow process rounds the corners of a
//! sticking valve. Noise can cover corners, and rarely creates them.
//!
//! # Deviations from the paper
//! No paper. A user's guide and the source of the tool were read. The steps of the method are these, but its details
//! are not:
//! * it cuts cycles at every second turning point of the smoothed OP, and compares images, not points;
//! * "50 %" is a distance of image moments of at most 0.5 from one of three fixed ellipses at 45°;
//! * it crops two opposite quarters of the image, and keeps points farther than 4 % of the contour's length;
//! * one of the two corners with three points suffices for a cycle; nothing is noise, and no share is decided on;
//! * its magnitude is our width of the ellipse, but in pixels over the difference of the axes.
//!
//! # References
//! HAW Hamburg, GitHub HAW-Process-Automation/Stiction-Analyser, user's guide and source (read); Douglas, Peucker,
//! Cartographica 10 (1973) 112-122 (not read).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::ellipse::Ellipse;
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{Direction, band_passed, mean, span, zero_crossings};

/// Similarity to an ellipse from which a cycle counts, as in the user's guide.
pub const SIMILARITY: f64 = 0.5;
/// Reach of a corner to either side of its outermost point, degrees; ours.
pub const REACH: f64 = 60.0;
/// Largest distance from a straight line, radii; ours: half of the arc's bulge.
pub const TOLERANCE: f64 = 0.067;
/// Share of sharp corners from which the valve sticks; ours.
pub const SHARE: f64 = 0.5;

/// Largest number of points that describe the arc of a circle; closed form, see the module.
const ARC: usize = 5;
/// Largest number of means in a cycle; ours.
const POINTS: usize = 48;
/// Fewest samples of a cycle; ours.
const FEWEST_SAMPLES: f64 = 16.0;
/// Fewest similar cycles; ours.
const FEWEST_CYCLES: usize = 3;
/// Most examined cycles, evenly spaced; ours, for speed.
const MOST_CYCLES: usize = 200;

static METHOD: Method = Method {
    name: "sharp-corner",
    title: "Sharp corners",
    source: "HAW Hamburg, Stiction Analyser, user's guide and program (read); details ours",
    statistic: "share of sharp corners",
    rule: "sticks if at least half (ours) of the outermost corners are sharp, in cycles that resemble an ellipse \
           by more than 50 %; undecided if noise covers most corners",
    applies: Applies::AnyLoop,
    decides: Decides::Stiction,
    needs: Needs::Error,
    family: Family::PhasePlot,
    explains_oscillation: true,
};

/// The method with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct SharpCorner {
    /// Similarity to an ellipse from which a cycle counts.
    pub similarity: f64,
    /// Reach of a corner to either side of its outermost point, degrees.
    pub reach: f64,
    /// Largest distance from a straight line, radii.
    pub tolerance: f64,
    /// Share of sharp corners from which the valve sticks.
    pub share: f64,
}

impl Default for SharpCorner {
    fn default() -> Self {
        Self { similarity: SIMILARITY, reach: REACH, tolerance: TOLERANCE, share: SHARE }
    }
}

/// One cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct SharpCornerCycle {
    /// First sample.
    pub first: usize,
    /// Index after the last sample.
    pub end: usize,
    /// OP, reduced, percent.
    pub op: Vec<f64>,
    /// Control error, reduced, in units of the PV.
    pub error: Vec<f64>,
    /// The ellipse through both.
    pub ellipse: Ellipse,
    /// Their similarity, at most 1.
    pub similarity: f64,
    /// The corners around the outermost point and the outermost on the other side: indices into the cycle of the
    /// points that describe them; three for a sharp one.
    pub corners: [Vec<usize>; 2],
}

/// The result of the method.
#[derive(Debug, Clone, PartialEq)]
pub struct SharpCornerResult {
    /// The cycles that resemble an ellipse.
    pub cycles: Vec<SharpCornerCycle>,
    /// Number of cycles examined.
    pub examined: usize,
    /// Number of corners that are not noise: described by at most five points.
    pub clear: usize,
    /// Share of sharp corners among these.
    pub share: f64,
    /// Mean width of the ellipses along the OP, percent.
    pub magnitude: f64,
    /// The decision.
    pub decision: Decision,
    /// Cautions.
    pub caveats: Vec<String>,
}

impl SharpCorner {
    /// Runs the method.
    ///
    /// # Errors
    /// If the method does not apply, no oscillation is found, or the oscillation is too fast for the sample time.
    pub fn run(&self, subject: &Subject<'_>) -> Result<SharpCornerResult, Abstention> {
        let caveats = subject.check(&METHOD)?;
        let abstain = |why: String| Err(Abstention(why));
        let Some(error) = subject.error() else {
            return abstain("needs the PV, which is not recorded".to_owned());
        };
        let op = &subject.segment.op;
        if span(op) == 0.0 {
            return abstain("the OP never moves".to_owned());
        }
        let Some(period) = subject.period else {
            return abstain("needs an oscillation".to_owned());
        };
        if !(period >= FEWEST_SAMPLES) {
            return abstain(format!(
                "needs {FEWEST_SAMPLES} samples per period; there are {period:.1}"
            ));
        }
        let filtered = band_passed(&error.values, 0.5 / period, 2.0 / period);
        let starts: Vec<usize> = zero_crossings(&filtered)
            .into_iter()
            .filter(|crossing| crossing.direction == Direction::Up)
            .map(|crossing| crossing.next)
            .collect();
        let all: Vec<(usize, usize)> = starts
            .windows(2)
            .map(|pair| (pair[0], pair[1]))
            .filter(|(first, end)| {
                let length = (end - first) as f64;
                length >= FEWEST_SAMPLES && (0.5..2.0).contains(&(length / period))
            })
            .collect();
        if all.len() < FEWEST_CYCLES {
            return abstain(format!(
                "needs at least {FEWEST_CYCLES} cycles; there are {}",
                all.len()
            ));
        }
        let examined = all.len().min(MOST_CYCLES);
        let cycles: Vec<SharpCornerCycle> = (0..examined)
            .map(|i| all[i * all.len() / examined])
            .filter_map(|(first, end)| self.cycle(first, end, op, &error.values))
            .collect();
        let points = || cycles.iter().flat_map(|cycle| &cycle.corners).map(Vec::len);
        let clear = points().filter(|n| *n <= ARC).count();
        let share = points().filter(|n| *n == 3).count() as f64 / clear.max(1) as f64;
        let decision = if cycles.len() < FEWEST_CYCLES || clear < cycles.len() {
            Decision::Undecided
        } else if share >= self.share {
            Decision::Sticks
        } else {
            Decision::DoesNotStick
        };
        let widths: Vec<f64> = cycles.iter().map(|cycle| cycle.ellipse.op_width()).collect();
        let magnitude = if widths.is_empty() { 0.0 } else { mean(&widths) };
        Ok(SharpCornerResult { cycles, examined, clear, share, magnitude, decision, caveats })
    }

    /// A cycle with its corners; `None` if it does not resemble an ellipse.
    fn cycle(
        &self,
        first: usize,
        end: usize,
        op: &[f64],
        error: &[f64],
    ) -> Option<SharpCornerCycle> {
        let (op, error) = filled(&reduced(&op[first..end]), &reduced(&error[first..end]));
        let ellipse = Ellipse::fit(&op, &error)?;
        let similarity = 1.0 - ellipse.residual;
        if !(similarity > self.similarity) {
            return None;
        }
        let circle: Vec<[f64; 2]> =
            op.iter().zip(&error).map(|(x, y)| ellipse.to_circle(*x, *y)).collect();
        let radius = |k: usize| circle[k][0].hypot(circle[k][1]);
        let outermost = |allowed: &dyn Fn(usize) -> bool| {
            (0..circle.len())
                .filter(|k| allowed(*k))
                .max_by(|a, b| radius(*a).total_cmp(&radius(*b)))
                .unwrap_or(0)
        };
        let apex = outermost(&|_| true);
        let [ax, ay] = circle[apex];
        // On the other side: at least 120° away.
        let other =
            outermost(&|k| ax * circle[k][0] + ay * circle[k][1] < -0.5 * radius(apex) * radius(k));
        let corners = [apex, other].map(|apex| self.corner(&circle, apex));
        Some(SharpCornerCycle { first, end, op, error, ellipse, similarity, corners })
    }

    /// The points that describe the cycle around the point `apex`.
    fn corner(&self, circle: &[[f64; 2]], apex: usize) -> Vec<usize> {
        let n = circle.len();
        let [ax, ay] = circle[apex];
        let inside = |k: usize| {
            let [x, y] = circle[k];
            (ax * y - ay * x).atan2(ax * x + ay * y).abs() <= self.reach.to_radians()
        };
        let count = |step: usize| (1..n / 2).take_while(|m| inside((apex + m * step) % n)).count();
        // One step back is n - 1 steps forward.
        let (ahead, back) = (count(1), count(n - 1));
        let crop: Vec<usize> = (0..=ahead + back).map(|m| (apex + n - back + m) % n).collect();
        let points: Vec<[f64; 2]> = crop.iter().map(|k| circle[*k]).collect();
        simplified(&points, self.tolerance).into_iter().map(|k| crop[k]).collect()
    }
}

impl Detector for SharpCorner {
    fn method(&self) -> &'static Method {
        &METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![
            Number::new("similarity", self.similarity, ""),
            Number::new("reach", self.reach, "°"),
            Number::new("tolerance", self.tolerance, "radii"),
            Number::new("share", self.share, ""),
        ]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let result = self.run(subject)?;
        let similar = result.cycles.len();
        let reason = if similar < FEWEST_CYCLES {
            format!("only {similar} of {} cycles resemble an ellipse", result.examined)
        } else if result.decision == Decision::Undecided {
            format!("only {} of {} corners are not covered by noise", result.clear, 2 * similar)
        } else {
            format!(
                "{:.0} % of {} clear corners of {similar} cycles are sharp (limit {:.0} %); the cycles are {:.3} % \
                 wide along the OP",
                100.0 * result.share,
                result.clear,
                100.0 * self.share,
                result.magnitude
            )
        };
        let numbers = vec![
            Number::new("share of sharp corners", result.share, ""),
            Number::new("clear corners", result.clear as f64, ""),
            Number::new("similar cycles", similar as f64, ""),
            Number::new("cycles", result.examined as f64, ""),
            Number::new("magnitude", result.magnitude, "%"),
        ];
        let finding =
            Finding::new(&METHOD, result.decision, result.share, self.share, reason, numbers);
        let caveats = result.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(result)), ..finding })
    }
}

/// The means of at most [`POINTS`] parts of equal duration.
fn reduced(x: &[f64]) -> Vec<f64> {
    let n = x.len().min(POINTS);
    (0..n).map(|i| mean(&x[i * x.len() / n..(i + 1) * x.len() / n])).collect()
}

/// The closed polygon through the points (`x`, `y`), with points added on its long sides so that none is longer
/// than a share of `1 / POINTS` of the whole, in ranges of either axis.
fn filled(x: &[f64], y: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (sx, sy) = (span(x), span(y));
    let sides: Vec<f64> = (0..x.len())
        .map(|k| {
            let next = (k + 1) % x.len();
            ((x[next] - x[k]) / sx).hypot((y[next] - y[k]) / sy)
        })
        .collect();
    let longest = sides.iter().sum::<f64>() / POINTS as f64;
    let mut points = (vec![], vec![]);
    for (k, side) in sides.iter().enumerate() {
        let next = (k + 1) % x.len();
        // A side is not longer than half the whole; NaN for signals that do not move gives one part.
        let parts = ((side / longest).ceil() as usize).clamp(1, POINTS);
        for part in 0..parts {
            let share = part as f64 / parts as f64;
            points.0.push(x[k] + share * (x[next] - x[k]));
            points.1.push(y[k] + share * (y[next] - y[k]));
        }
    }
    points
}

/// Indices of the points that Douglas and Peucker keep: the ends, and enough points that no other is farther than
/// `tolerance` from the segment between its kept neighbours.
fn simplified(points: &[[f64; 2]], tolerance: f64) -> Vec<usize> {
    let mut left = vec![0];
    let mut open = vec![(0, points.len().saturating_sub(1))];
    while let Some((a, b)) = open.pop() {
        let farthest = (a + 1..b)
            .map(|k| (distance(points[k], points[a], points[b]), k))
            .max_by(|x, y| x.0.total_cmp(&y.0));
        match farthest {
            Some((distance, k)) if distance > tolerance => open.extend([(k, b), (a, k)]),
            _ => left.push(b),
        }
    }
    left
}

/// Distance of `p` from the segment from `a` to `b`.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let ([dx, dy], [px, py]) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length = dx * dx + dy * dy;
    let place = if length > 0.0 { ((px * dx + py * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
    (px - place * dx).hypot(py - place * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_is_five_points_and_a_corner_three() {
        let arc: Vec<[f64; 2]> = (-30..=30)
            .map(|k| {
                let (s, c) = (f64::from(k) * std::f64::consts::FRAC_PI_3 / 30.0).sin_cos();
                [c, s]
            })
            .collect();
        assert_eq!(simplified(&arc, TOLERANCE).len(), 5);
        let corner: Vec<[f64; 2]> =
            (-30..=30).map(|k: i32| [-f64::from(k.abs()), f64::from(k)]).collect();
        assert_eq!(simplified(&corner, TOLERANCE), [0, 30, 60]);
        assert_eq!(simplified(&[[0.0, 0.0]], 1.0), [0, 0]);
    }
}
