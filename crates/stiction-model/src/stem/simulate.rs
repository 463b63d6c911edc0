//! The simulation of a stem under a pressure.

use super::body::{Body, Recorder, State};
use super::bristle_motion::BristleMotion;
use super::equations::Equations;
use super::friction::{Dahl, FrictionLaw, GmsInUse, Karnopp, LuGre};
use super::parameters::{ParameterSet, StemParameters};
use super::pressure::{Drive, PressureSignal, Segment};
use super::response::{Response, StemStart};
use super::stick_slip::StickSlip;
use super::sticking_law::StickingLaw;
use crate::error::{Error, Result, all_finite, finite, require};

/// A valve stem: its parameters, its friction, and the solver tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stem {
    parameters: StemParameters,
    friction: FrictionLaw,
    tolerance: f64,
}

impl Stem {
    /// Default relative tolerance.
    pub const DEFAULT_TOLERANCE: f64 = 1e-8;

    /// A stem with this friction.
    ///
    /// # Errors
    /// If a parameter is out of range.
    pub fn new(parameters: StemParameters, friction: FrictionLaw) -> Result<Self> {
        let parameters = parameters.checked()?;
        if let FrictionLaw::Armstrong(law) = friction {
            law.checked()?;
        }
        Ok(Self { parameters, friction, tolerance: Self::DEFAULT_TOLERANCE })
    }

    /// The stem of the parameter set called `name`, one of [`super::SETS`].
    ///
    /// # Errors
    /// If there is no such set.
    pub fn named(name: &str) -> Result<Self> {
        let set = ParameterSet::named(name)?;
        Self::new(set.stem, set.friction)
    }

    /// This stem with a different tolerance, relative to the stroke and the size of each state. A larger tolerance is
    /// faster. Motion that is advanced by its exact flow does not depend on the tolerance.
    ///
    /// # Errors
    /// Unless it lies between 1e-12 and 1e-3.
    pub fn with_tolerance(self, tolerance: f64) -> Result<Self> {
        let sensible = (1e-12..=1e-3).contains(&tolerance);
        require("solver tolerance", tolerance, sensible, "between 1e-12 and 1e-3")?;
        Ok(Self { tolerance, ..self })
    }

    /// Stem and actuator.
    pub fn parameters(&self) -> &StemParameters {
        &self.parameters
    }

    /// Friction.
    pub fn friction(&self) -> &FrictionLaw {
        &self.friction
    }

    /// Relative tolerance of the solver.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Follows `pressure` from its first time to its last, with samples at `times_s`.
    ///
    /// Events do not depend on the sample times.
    ///
    /// # Errors
    /// If the start is not finite or lies beyond an end stop, the sample times are not ascending or not within the
    /// signal, or the solver cannot continue.
    pub fn simulate(
        &self,
        pressure: &PressureSignal,
        start: StemStart,
        times_s: &[f64],
    ) -> Result<Response> {
        all_finite("sample times", times_s)?;
        let ordered = times_s.windows(2).all(|w| w[0] <= w[1]);
        let within = times_s.first().is_none_or(|t| *t >= pressure.start_s())
            && times_s.last().is_none_or(|t| *t <= pressure.end_s());
        if !(ordered && within) {
            return Err(Error::Inconsistent(format!(
                "sample times must ascend between {} s and {} s, where the pressure is given",
                pressure.start_s(),
                pressure.end_s()
            )));
        }
        let mut run = Run::new(self, start, pressure.first_pa())?;
        let mut recorder = Recorder::new(times_s);
        for segment in pressure.segments() {
            run.advance(&segment, &mut recorder)?;
        }
        recorder.finish(run.state(pressure.end_s()));
        Ok(Response { samples: recorder.samples, events: recorder.events })
    }
}

/// A moving stem.
#[derive(Debug, Clone)]
pub(super) struct Run {
    motion: Motion,
    pub(super) lag_s: f64,
    pub(super) pressure_pa: f64,
}

#[derive(Debug, Clone)]
enum Motion {
    StickSlip(StickSlip),
    Dahl(BristleMotion<Dahl, 3>),
    LuGre(BristleMotion<LuGre, 3>),
    Gms(BristleMotion<GmsInUse, 5>),
}

impl Run {
    pub(super) fn new(stem: &Stem, start: StemStart, first_pa: f64) -> Result<Self> {
        let parameters = stem.parameters;
        let position_m = finite("start position", start.position_m)?;
        let inside = !parameters.end_stops || (0.0..=parameters.stroke_m).contains(&position_m);
        let allowed = format!("between the end stops at 0 and {} m", parameters.stroke_m);
        require("start position", position_m, inside, &allowed)?;
        let acting_pa = match start.pressure_pa {
            Some(acting_pa) if parameters.air_lag_s > 0.0 => finite("start pressure", acting_pa)?,
            _ => first_pa,
        };
        let drive = Drive::resting(acting_pa);
        let body = Body::new(&parameters, stem.tolerance);
        let balanced = !start.relaxed;
        let motion = match stem.friction {
            FrictionLaw::Classical(steady) => {
                let law = StickingLaw::Classical(Karnopp::new(steady, 0.0)?);
                Motion::StickSlip(StickSlip::new(body, law, position_m))
            }
            FrictionLaw::Karnopp(law) => {
                let law = StickingLaw::Classical(law);
                Motion::StickSlip(StickSlip::new(body, law, position_m))
            }
            FrictionLaw::Armstrong(law) => {
                let net_n = body.net_n(&drive, position_m);
                let law = StickingLaw::armstrong(law, position_m, net_n);
                Motion::StickSlip(StickSlip::new(body, law, position_m))
            }
            FrictionLaw::Dahl(law) => {
                Motion::Dahl(BristleMotion::new(body, law, position_m, &drive, balanced))
            }
            FrictionLaw::LuGre(law) => {
                Motion::LuGre(BristleMotion::new(body, law, position_m, &drive, balanced))
            }
            FrictionLaw::Gms(law) => {
                let law = GmsInUse::new(law);
                Motion::Gms(BristleMotion::new(body, law, position_m, &drive, balanced))
            }
        };
        Ok(Self { motion, lag_s: parameters.air_lag_s, pressure_pa: acting_pa })
    }

    pub(super) fn advance(&mut self, segment: &Segment, recorder: &mut Recorder<'_>) -> Result<()> {
        let drive = Drive::new(segment, self.lag_s, self.pressure_pa);
        let duration = segment.end_s - segment.start_s;
        match &mut self.motion {
            Motion::StickSlip(m) => m.advance(&drive, segment.start_s, duration, recorder)?,
            Motion::Dahl(m) => m.advance(&drive, segment.start_s, duration, recorder)?,
            Motion::LuGre(m) => m.advance(&drive, segment.start_s, duration, recorder)?,
            Motion::Gms(m) => m.advance(&drive, segment.start_s, duration, recorder)?,
        }
        self.pressure_pa = drive.pressure_pa + drive.rise(duration);
        Ok(())
    }

    pub(super) fn position_m(&self) -> f64 {
        match &self.motion {
            Motion::StickSlip(m) => m.position_m(),
            Motion::Dahl(m) => m.position_m(),
            Motion::LuGre(m) => m.position_m(),
            Motion::Gms(m) => m.position_m(),
        }
    }

    pub(super) fn state(&self, time_s: f64) -> State {
        let drive = Drive::resting(self.pressure_pa);
        match &self.motion {
            Motion::StickSlip(m) => m.state(&drive, time_s),
            Motion::Dahl(m) => m.state(&drive),
            Motion::LuGre(m) => m.state(&drive),
            Motion::Gms(m) => m.state(&drive),
        }
    }

    /// The motion as equations for an external solver.
    pub(super) fn equations(&self) -> &dyn Equations {
        match &self.motion {
            Motion::StickSlip(m) => m,
            Motion::Dahl(m) => m,
            Motion::LuGre(m) => m,
            Motion::Gms(m) => m,
        }
    }

    pub(super) fn equations_mut(&mut self) -> &mut dyn Equations {
        match &mut self.motion {
            Motion::StickSlip(m) => m,
            Motion::Dahl(m) => m,
            Motion::LuGre(m) => m,
            Motion::Gms(m) => m,
        }
    }
}
