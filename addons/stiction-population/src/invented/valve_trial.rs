//! Tests at loops of kinds that the verdict was not trained on, and at physical stems.

use super::parts::{Ordinary, Parts};
use super::sketch::Sketch;
use super::{Invented, Invention};
use crate::draw::Draw;
use crate::plant::{Hand, Nobody};
use crate::valve_trial::{Operator, Site, Tested, TestedValve, ToPlan};
use stiction_diagnose::recording::Recording;
use stiction_diagnose::valve_test::TestPlan;
use stiction_model::error::Result;

/// A loop that is not in the population.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unseen {
    /// Of an invented kind.
    Invented(Invention),
    /// An ordinary loop whose valve is a physical stem, which slides or moves in steps after a slip.
    PhysicalStem,
}

/// Parameter sets of physical stems.
const STEMS: [&str; 2] = ["cts", "cts-stribeck"];

impl Unseen {
    fn parts(self, sketch: &Sketch) -> Box<dyn Parts> {
        match self {
            Self::Invented(kind) => kind.parts(sketch),
            Self::PhysicalStem => Box::new(Ordinary),
        }
    }

    fn sketch(self, draw: &mut Draw) -> Sketch {
        match self {
            Self::Invented(kind) => Sketch::draw(kind, draw),
            Self::PhysicalStem => {
                let mut sketch = Sketch::draw(Invention::SurgeControl, draw);
                sketch.rest = draw.uniform(30.0, 70.0);
                sketch.physical = Some(draw.one_of(STEMS));
                sketch
            }
        }
    }

    /// The loop of this seed, healthy or sticking, recorded in operation and then tested, as
    /// [`LoopKind::tested`](crate::LoopKind::tested); `None` without a plan.
    ///
    /// # Errors
    /// None is known.
    pub fn tested(
        self,
        seed: u64,
        sticks: bool,
        longest: f64,
        operator: Operator,
        plan: &mut dyn FnMut(&Recording, ToPlan) -> Option<TestPlan>,
    ) -> Result<Option<Tested>> {
        for again in 0..60 {
            let stream = match self {
                Self::Invented(kind) => kind as u64,
                Self::PhysicalStem => 99,
            };
            let mut draw = Draw::of(&[0x7e57, stream, seed, again]);
            let mut sketch = self.sketch(&mut draw);
            let at_s = sketch.samples as f64 * sketch.sample_time;
            let operated = sketch.play_with(self.parts(&sketch), sticks, &mut Nobody)?;
            if !operated.serves {
                continue;
            }
            let first = sketch.warm_up() + sketch.recorded();
            sketch.samples = (sketch.samples as f64 * (1.0 + longest)) as usize;
            let played = |hand: &mut dyn Hand| -> Result<Invented> {
                sketch.play_with(self.parts(&sketch), sticks, hand)
            };
            let untested = played(&mut Nobody)?.recording;
            let (offset, unit) = sketch.unit;
            let site = Site {
                valve: TestedValve {
                    sticks,
                    bands: sticks.then_some((sketch.s, sketch.j)),
                    partly: sticks && self.partly(),
                    rises: sketch.gain > 0.0,
                    sample_time_s: sketch.sample_time,
                    response_s: (sketch.lags[0] + sketch.lags[1] + sketch.dead as f64 + 1.0)
                        * sketch.sample_time
                        / sketch.steps as f64,
                },
                first,
                warm_up: sketch.warm_up(),
                step: sketch.sample_time / sketch.steps as f64,
                pv_range: (offset, 100.0 * unit),
                pv_rest: 0.0,
                limits: (0.0, 100.0),
            };
            let of = [0x7e57 ^ stream, seed, again];
            let mut record = |hand: &mut dyn Hand| Ok(played(hand)?.recording);
            return site.tested(&untested, at_s, operator, of, plan, &mut record);
        }
        Ok(None)
    }

    /// Whether the valve sticks in a part of the stroke, in one direction or only after a rest, or the recorded OP is
    /// not the stem's input.
    fn partly(self) -> bool {
        use Invention as Kind;
        matches!(
            self,
            Self::Invented(
                Kind::NearTheSeat
                    | Kind::OneSidedFriction
                    | Kind::WindingPositioner
                    | Kind::AgeingFriction
            )
        )
    }
}
