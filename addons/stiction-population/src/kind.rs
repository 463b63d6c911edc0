//! The kinds of loops, and their shares.

use super::Simulated;
use super::draw::Draw;
use super::member::{Scene, recorded};
use stiction_diagnose::recording::Recording;
use stiction_model::error::{Error, Result};
use stiction_model::named;

named! {
    /// The peculiarity of a simulated loop. Kinds with faulty valves come first.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum LoopKind {
        /// Its valve sticks and slips.
        Sticky = "sticky valve",
        /// It is the outer loop of a cascade, and the valve of the inner loop sticks. Its OP is the set point of the
        /// inner loop, so S and J refer to an OP that is not the recorded one.
        StickyBelow = "sticky valve below",
        /// Its valve does not move: seized in position, shut, or without power.
        Stuck = "stuck valve",
        /// None: load drift, steps, ramps, pulses and noise, as all loops have.
        Normal = "normal operation",
        /// A sine enters at the load or at the PV.
        Sine = "sine disturbance",
        /// Narrow-band noise enters at the load or at the PV.
        Irregular = "irregular oscillation",
        /// The controller's gain is near the ultimate one: the gain margin is 0.85 to 1.25.
        AggressiveTuning = "aggressive tuning",
        /// The transmitter resolves only a few levels of the PV, also for the controller.
        QuantisedPv = "quantised PV",
        /// A load exceeds the range of the OP.
        Saturation = "saturation",
        /// The transmitter has play, or the controller a gap.
        DeadZoneElsewhere = "dead zone elsewhere",
        /// The set point moves more than in other loops.
        SetPoint = "set-point changes",
        /// The process gain changes over the OP range of an oscillating load.
        ProcessNonlinearity = "process nonlinearity",
        /// A square, triangular, relaxation or slip-like wave enters at the load or at the PV, as from
        /// another sticking valve upstream.
        ExternalWave = "external wave",
        /// A load ramps and resets, repeatedly: fouling and backwash, batch dumps.
        RampAndReset = "ramp and reset",
        /// The historian compressed OP or PV by a swinging door, and drew straight lines between the kept samples.
        SwingingDoor = "swinging door",
        /// The valve of another loop sticks; its cycle arrives through the coupling, and this loop's controller acts
        /// back.
        StickingNeighbour = "sticking neighbour",
        /// A neighbour is switched on and off, or opens and shuts. Its effect jumps between two or three levels, at its
        /// own times or as a shared vessel fills and empties.
        SwitchedNeighbour = "switched neighbour",
        /// A load has a long memory: its power falls with a power of the frequency.
        LongMemory = "long memory",
        /// A load moves in one direction over the whole record; the OP follows it.
        OneWay = "one-way ramp",
    }
}

impl LoopKind {
    /// The kind of that name, in any case.
    ///
    /// # Errors
    /// If no kind has this name. The error lists the known names.
    pub fn by_name(name: &str) -> Result<Self> {
        let wanted = name.to_lowercase();
        let found = Self::ALL.into_iter().find(|kind| kind.name().to_lowercase() == wanted);
        found.ok_or_else(|| Error::UnknownName {
            family: "kind of loop",
            name: name.to_owned(),
            known: Self::ALL.map(Self::name).join(", "),
        })
    }

    /// Its share of the population.
    pub fn share(self) -> f64 {
        match self {
            Self::Sticky => 0.47,
            Self::StickyBelow => 0.03,
            Self::Stuck => 0.04,
            Self::Normal => 0.0775,
            Self::Irregular => 0.036,
            Self::SetPoint | Self::ExternalWave | Self::RampAndReset => 0.0315,
            Self::DeadZoneElsewhere
            | Self::Sine
            | Self::AggressiveTuning
            | Self::QuantisedPv
            | Self::Saturation
            | Self::SwingingDoor => 0.027,
            Self::ProcessNonlinearity | Self::StickingNeighbour | Self::SwitchedNeighbour => 0.0225,
            Self::LongMemory => 0.0135,
            Self::OneWay => 0.009,
        }
    }

    /// Whether the valve is at fault.
    pub(super) fn sticks(self) -> bool {
        matches!(self, Self::Sticky | Self::StickyBelow | Self::Stuck)
    }

    /// The kind at a number from 0 to 1 when the kinds lie side by side with their shares.
    pub fn at(mut place: f64) -> Self {
        for kind in Self::ALL {
            place -= kind.share();
            if place < 0.0 {
                return kind;
            }
        }
        Self::OneWay
    }

    /// The loop of this kind and seed.
    ///
    /// Loops of two kinds with the same seed have the same process, tuning, noise, load, set point and historian,
    /// unless the kind changes them, so that a sticky loop can be compared with its healthy siblings. A draw that shows
    /// nothing, or the wrong pattern (see `docs/population.md`), is repeated from the same seed and counted in
    /// [`Facts::redrawn`](super::Facts::redrawn).
    ///
    /// # Errors
    /// None is known. Possible reasons are 100 unsuccessful draws, or a setting out of its range.
    pub fn simulate(self, seed: u64) -> Result<Simulated> {
        self.simulate_for(seed, 1.0)
    }

    /// The loop of this kind and seed, recorded for `factor` times as many samples.
    ///
    /// Process, tuning, valve and historian are the same, and the cause continues. Loads, set-point changes and noise
    /// equal the shorter record during its length. After it, they are drawn again for every further length, from the
    /// same distributions. So a load does not drift away in a month. Intermittent sticking occurs in shares of the
    /// longer record.
    ///
    /// # Errors
    /// As [`simulate`](Self::simulate), and if `factor` is not from 0.1 to 10,000. It needs some 100 bytes of
    /// memory a step of the controller.
    pub fn simulate_for(self, seed: u64, factor: f64) -> Result<Simulated> {
        if !(0.1..=10_000.0).contains(&factor) {
            let rule = format!("{factor} times as many samples is not between 0.1 and 10,000");
            return Err(Error::Inconsistent(rule));
        }
        self.drawn(seed, factor, &mut |_, _| Ok(()))
    }

    /// The loop of this kind and seed, recorded without compression, averages and holds.
    ///
    /// # Errors
    /// As [`simulate`](Self::simulate).
    pub fn simulate_uncompressed(self, seed: u64) -> Result<Simulated> {
        let mut trend = None;
        let mut simulated = self.drawn(seed, 1.0, &mut |scene, _| {
            let played = scene.plant.play(scene.fittings)?;
            trend = Some(recorded(scene.design, &scene.design.historian.trend(), &played)?);
            Ok(())
        })?;
        if let Some(trend) = trend {
            let name = simulated.recording.name;
            simulated.recording = Recording { name, ..trend };
        }
        Ok(simulated)
    }

    fn drawn(
        self,
        seed: u64,
        factor: f64,
        then: &mut dyn FnMut(&Scene<'_>, &Simulated) -> Result<()>,
    ) -> Result<Simulated> {
        const DRAWS: u64 = 100;
        for redrawn in 0..DRAWS {
            let draw = &mut Draw::of(&[seed, redrawn]);
            if let Some(mut simulated) = super::member::simulate(self, draw, factor, None, then)? {
                simulated.truth.facts.redrawn = redrawn as usize;
                simulated.recording.name = format!("{} {seed}", self.name());
                return Ok(simulated);
            }
        }
        Err(Error::Inconsistent(format!("{} {seed}: none of {DRAWS} draws is valid", self.name())))
    }

    /// The sticky loop of this seed with a different S, percent of span. Loops of one seed differ only in S and J, with
    /// the same J/S. `None` if a draw would have to be repeated, because they would then differ.
    ///
    /// # Errors
    /// If S is not above 0 and at most 100 %.
    pub fn sticky_with_s(seed: u64, s: f64) -> Result<Option<Simulated>> {
        if !(s > 0.0 && s <= 100.0) {
            return Err(Error::Inconsistent(format!(
                "S is {s} %, but must be above 0 and at most 100 %"
            )));
        }
        let draw = &mut Draw::of(&[seed, 0]);
        super::member::simulate(Self::Sticky, draw, 1.0, Some(s), &mut |_, _| Ok(()))
    }
}
