//! Loops of kinds that the verdict was not trained on: the examination after a training.
//!
//! A set of kinds is devised when the population that trains the verdict is final. It shares only random numbers, valve
//! models and the definition of visible stiction with the population, and is never used for training. It is measured
//! once. The findings improve the next population, and the next examination needs another set. Earlier sets are kept,
//! so that their loops can be measured again, although similar kinds are then in the population.
//!
//! Each kind has healthy loops and loops that stick, with the same process, controller and disturbances.
//!
//! ```text
//! Sketch ──> an ordinary loop ──┬──> play, healthy and sticking ──> Invented
//! kind   ──> Parts of its own ──┘
//! ```

mod adaptive_damping;
mod ageing_friction;
mod aliasing;
mod choked_flow;
mod fouling;
mod idle_nights;
mod knocker;
mod near_the_seat;
mod on_off_neighbour;
mod one_sided_booster;
mod one_sided_friction;
mod parts;
mod played;
mod predictive_controller;
mod recipe;
mod ringing_positioner;
mod scheduled_tuning;
mod sketch;
mod slugging;
mod soft_linkage;
mod sticking_float;
mod surge_control;
mod titration;
mod transport_by_flow;
mod two_controllers;
mod valve_trial;
mod valves_in_series;
mod winding_positioner;

pub use valve_trial::Unseen;

use super::draw::Draw;
use parts::Parts;
use sketch::Sketch;
use stiction_diagnose::recording::Recording;
use stiction_model::error::Result;
use stiction_model::named;

named! {
    /// A kind that is not in the population.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Invention {
        /// A positioner that rings: the stem follows with a resonance of damping 0.15 to 0.4.
        RingingPositioner = "ringing positioner",
        /// A predictive controller: a move every few samples, held in between, from an inaccurate model.
        PredictiveController = "predictive controller",
        /// A second valve in the same line, moved manually and by a different loop. It changes the gain.
        ValvesInSeries = "valves in series",
        /// A boiler or compressor that is switched on and off by the controlled pressure. The population has similar
        /// loops since version 5, [`LoopKind::SwitchedNeighbour`](super::LoopKind::SwitchedNeighbour).
        OnOffNeighbour = "on-off neighbour",
        /// A valve that sticks only near its seat, under a loop that reaches the seat.
        NearTheSeat = "near the seat",
        /// Pulsating flow, sampled slightly slower or faster than it pulsates: a slow beat in the PV.
        Aliasing = "aliased pulsation",
        /// A titration: the gain changes tenfold around the set point.
        Titration = "titration",
        /// A linkage with play and a soft spring behind the valve: the flow follows the stem late and softly.
        SoftLinkage = "soft linkage",
        /// A controller with two sets of tuning, for a valve whose gain changes near its operating point. Half of these
        /// controllers switch with a bump.
        ScheduledTuning = "scheduled tuning",
        /// Batches of one recipe: steps, ramps and holds of the set point, with a preset OP between batches.
        Recipe = "recipe",
        /// A choked flow: above a wandering opening, further opening hardly increases the flow.
        ChokedFlow = "choked flow",
        /// A temperature behind a pipe: with a larger flow, its effect is smaller and arrives sooner.
        TransportByFlow = "transport by flow",
        /// A surge controller: it opens at once, and closes slowly.
        SurgeControl = "surge control",
        /// A transmitter with more damping at small changes.
        AdaptiveDamping = "adaptive damping",
        /// A positioner with integral action: if the valve sticks it winds up until the stem slips.
        WindingPositioner = "winding positioner",
        /// A valve that jumps when it opens and slides when it closes.
        OneSidedFriction = "one-sided friction",
        /// A sensor that sticks: it holds its reading and slips.
        StickingFloat = "sticking float",
        /// A second controller of the same PV, whose transmitter reads slightly more or less.
        TwoControllers = "two controllers",
        /// Slugs from a riser: the process cycles while the valve is open far enough.
        Slugging = "slugging",
        /// A knocker that was left on: short pulses in the OP.
        Knocker = "knocker",
        /// A volume booster in one direction of the stroke; the other direction is slow.
        OneSidedBooster = "one-sided booster",
        /// A heat exchanger that fouls and is cleaned, under a daily load.
        Fouling = "fouling",
        /// A plant that runs by day: at night the valve has no effect and the OP rests.
        IdleNights = "idle nights",
        /// A valve that sticks more, the longer it rests.
        AgeingFriction = "ageing friction",
    }
}

impl Invention {
    /// The kinds of the first examination, for population 4.
    pub const FIRST: [Self; 8] = Self::ALL.as_chunks().0[0];

    /// The kinds of the second examination, for population 5.
    pub const SECOND: [Self; 8] = Self::ALL.as_chunks().0[1];

    /// The kinds of the third examination, for records of a week.
    pub const THIRD: [Self; 8] = Self::ALL.as_chunks().0[2];

    /// The loop of this kind and seed, healthy or sticking.
    ///
    /// # Errors
    /// None is known.
    pub fn simulate(self, seed: u64, sticks: bool) -> Result<Invented> {
        self.simulate_for(seed, sticks, 1.0)
    }

    /// Simulates a loop with `factor` times as many samples, and as many more steps of the load.
    ///
    /// # Errors
    /// None is known.
    pub fn simulate_for(self, seed: u64, sticks: bool, factor: f64) -> Result<Invented> {
        // A draw whose OP rests or is at a limit shows nothing.
        let mut again = 0;
        loop {
            let mut draw = Draw::of(&[0x1a5e, self as u64, seed, again]);
            let sketch = Sketch::draw(self, &mut draw).lasting(factor);
            let found = sketch.play(self, sticks)?;
            again += 1;
            // In the first set one may be valid and the other not: its loops stay those that were measured.
            let serves =
                found.serves && (Self::FIRST.contains(&self) || sketch.play(self, !sticks)?.serves);
            if again >= 60 || serves {
                return Ok(found);
            }
        }
    }

    /// Own parts.
    fn parts(self, sketch: &Sketch) -> Box<dyn Parts> {
        match self {
            Self::RingingPositioner => Box::new(ringing_positioner::RingingPositioner::of(sketch)),
            Self::PredictiveController => {
                Box::new(predictive_controller::PredictiveController::of(sketch))
            }
            Self::ValvesInSeries => Box::new(valves_in_series::ValvesInSeries::of(sketch)),
            Self::OnOffNeighbour => Box::new(on_off_neighbour::OnOffNeighbour::of(sketch)),
            Self::NearTheSeat => Box::new(near_the_seat::NearTheSeat),
            Self::Aliasing => Box::new(aliasing::Aliasing::of(sketch)),
            Self::Titration => Box::new(titration::Titration::of(sketch)),
            Self::SoftLinkage => Box::new(soft_linkage::SoftLinkage::of(sketch)),
            Self::ScheduledTuning => Box::new(scheduled_tuning::ScheduledTuning::of(sketch)),
            Self::Recipe => Box::new(recipe::Recipe::of(sketch)),
            Self::ChokedFlow => Box::new(choked_flow::ChokedFlow::of(sketch)),
            Self::TransportByFlow => Box::new(transport_by_flow::TransportByFlow::of(sketch)),
            Self::SurgeControl => Box::new(surge_control::SurgeControl::of(sketch)),
            Self::AdaptiveDamping => Box::new(adaptive_damping::AdaptiveDamping::of(sketch)),
            Self::WindingPositioner => Box::new(winding_positioner::WindingPositioner::of(sketch)),
            Self::OneSidedFriction => Box::new(one_sided_friction::OneSidedFriction::of(sketch)),
            Self::StickingFloat => Box::new(sticking_float::StickingFloat::of(sketch)),
            Self::TwoControllers => Box::new(two_controllers::TwoControllers::of(sketch)),
            Self::Slugging => Box::new(slugging::Slugging::of(sketch)),
            Self::Knocker => Box::new(knocker::Knocker::of(sketch)),
            Self::OneSidedBooster => Box::new(one_sided_booster::OneSidedBooster::of(sketch)),
            Self::Fouling => Box::new(fouling::Fouling::of(sketch)),
            Self::IdleNights => Box::new(idle_nights::IdleNights::of(sketch)),
            Self::AgeingFriction => Box::new(ageing_friction::AgeingFriction::of(sketch)),
        }
    }
}

/// A loop of such a kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Invented {
    /// The recording of a plant.
    pub recording: Recording,
    /// Whether the valve sticks.
    pub sticks: bool,
    /// Whether the record can show it, as in [`Truth::visible`](super::Truth::visible).
    pub visible: bool,
    /// Stick band plus dead band, percent of span; 0 for a healthy valve. For a positioner that winds up, between
    /// its output and the stem.
    pub s: f64,
    /// Slip jump.
    pub j: f64,
    serves: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_gives_loops_that_serve_and_depend_on_their_numbers_alone() {
        let mut seen = 0;
        for what in [Invention::FIRST, Invention::SECOND, Invention::THIRD].concat() {
            for seed in 0..20 {
                for sticks in [false, true] {
                    let made = what.simulate(seed, sticks).unwrap();
                    assert_eq!(made, what.simulate(seed, sticks).unwrap());
                    assert!(made.serves, "{} {seed} {sticks}", what.name());
                    assert!(made.sticks == sticks && (sticks || !made.visible && made.s == 0.0));
                    seen += usize::from(made.visible);
                }
            }
        }
        assert!(seen >= 200, "{seen} of 480 sticking loops are visible");
    }

    #[test]
    fn of_every_kind_since_the_second_set_many_sticking_loops_show_and_some_do_not() {
        for what in [Invention::SECOND, Invention::THIRD].concat() {
            let n = 200;
            let shows = |seed: &u64| what.simulate(*seed, true).unwrap().visible;
            let share = (0..n).filter(shows).count() as f64 / n as f64;
            println!("{}: {:.0} % visible", what.name(), 100.0 * share);
            assert!((0.4..0.9).contains(&share), "{}: {share}", what.name());
        }
    }

    #[test]
    fn twins_have_all_but_the_valve_in_common() {
        for what in [Invention::SECOND, Invention::THIRD].concat() {
            for seed in 0..20 {
                let [healthy, sticking] = [false, true].map(|sticks| {
                    let mut made = what.simulate(seed, sticks).unwrap().recording;
                    made.op.values.clear();
                    made.pv.as_mut().unwrap().values.clear();
                    made
                });
                assert_eq!(healthy, sticking, "{} {seed}", what.name());
                // A valve that sticks by next to nothing makes what a healthy one makes.
                let mut sketch = Sketch::draw(what, &mut Draw::of(&[seed]));
                (sketch.s, sketch.j) = (1e-9, 5e-10);
                let [healthy, sticking] =
                    [false, true].map(|sticks| sketch.play(what, sticks).unwrap().recording);
                let apart = |k: usize| (healthy.op.values[k] - sticking.op.values[k]).abs() > 1e-5;
                // A loop with a float that slips is chaotic: differences grow tenfold in some 30 samples.
                let alike = if what == Invention::StickingFloat { 150 } else { usize::MAX };
                let n = healthy.op.values.len().min(alike);
                assert!(!(0..n).any(apart), "{} {seed}", what.name());
            }
        }
    }
}
