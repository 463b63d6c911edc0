//! The input of detectors.

use crate::finding::{Abstention, Applies, Method, Needs};
use crate::identify::lagged_position::{self, Judgement};
use crate::recording::{Dynamics, LoopType, Segment};
use crate::series::{HalfWave, centred, half_waves, span};
use std::sync::OnceLock;

/// Source of the control error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorSource {
    /// SP less PV.
    SetPoint,
    /// Mean of the PV less the PV, without an SP. The error then includes movements of the set point.
    MeanPv,
}

/// The control error of a segment.
#[derive(Debug, Clone, PartialEq)]
pub struct ControlError {
    /// SP less PV, or its replacement, in units of the PV. Its mean is kept with an SP, else zero.
    pub values: Vec<f64>,
    /// Source.
    pub source: ErrorSource,
}

/// One segment of a recording with information about its loop; common intermediate results are computed once.
#[derive(Debug)]
pub struct Subject<'a> {
    /// The signals.
    pub segment: &'a Segment,
    /// The controlled quantity.
    pub loop_type: LoopType,
    /// Period of the dominant oscillation, in samples, if there is one.
    pub period: Option<f64>,
    error: OnceLock<Option<ControlError>>,
    error_half_waves: OnceLock<Vec<HalfWave>>,
    position: OnceLock<Result<Judgement, Abstention>>,
}

impl<'a> Subject<'a> {
    /// A segment to judge; `period` is in samples.
    pub fn new(segment: &'a Segment, loop_type: LoopType, period: Option<f64>) -> Self {
        Self {
            segment,
            loop_type,
            period,
            error: OnceLock::new(),
            error_half_waves: OnceLock::new(),
            position: OnceLock::new(),
        }
    }

    /// Why a method cannot be used here: a signal is missing or constant, or the loop is of another kind.
    /// Otherwise, the assumptions that could not be checked.
    pub fn check(&self, method: &Method) -> Result<Vec<String>, Abstention> {
        let abstain = |why: String| Err(Abstention(why));
        match (method.applies, self.loop_type.dynamics()) {
            (Applies::SelfRegulating, Dynamics::Integrating) => {
                return abstain(format!(
                    "made for self-regulating loops; this loop ({}) integrates",
                    self.loop_type.name()
                ));
            }
            (Applies::Integrating, Dynamics::SelfRegulating) => {
                return abstain(format!(
                    "made for integrating loops; this loop ({}) is self-regulating",
                    self.loop_type.name()
                ));
            }
            (Applies::Integrating, Dynamics::Unknown) => {
                return abstain(
                    "made for integrating loops, but the type of this loop is not known; specify the type"
                        .to_owned(),
                );
            }
            _ => {}
        }
        let missing = match method.needs {
            Needs::Op => None,
            Needs::OpAndPv | Needs::Error => self.segment.pv.is_none().then_some("PV"),
            Needs::OpAndVp => self.segment.vp.is_none().then_some("valve position"),
        };
        if let Some(missing) = missing {
            return abstain(format!("needs the {missing}, which is not recorded"));
        }
        if span(&self.segment.op) == 0.0 && method.needs != Needs::Error {
            return abstain("the OP never moves".to_owned());
        }
        if let Some(pv) = &self.segment.pv
            && matches!(method.needs, Needs::OpAndPv | Needs::Error)
            && span(pv) == 0.0
        {
            return abstain("the PV never moves".to_owned());
        }
        let mut caveats = vec![];
        if method.applies == Applies::SelfRegulating
            && self.loop_type.dynamics() == Dynamics::Unknown
        {
            caveats.push("the loop's type is not known; it is assumed self-regulating".to_owned());
        }
        if method.needs == Needs::Error
            && self.error().is_some_and(|error| error.source == ErrorSource::MeanPv)
        {
            caveats.push("no SP is recorded; the mean of the PV replaces it".to_owned());
        }
        Ok(caveats)
    }

    /// The control error; `None` without a PV.
    pub fn error(&self) -> Option<&ControlError> {
        self.error
            .get_or_init(|| {
                let pv = self.segment.pv.as_ref()?;
                Some(match &self.segment.sp {
                    Some(sp) => ControlError {
                        values: sp.iter().zip(pv).map(|(sp, pv)| sp - pv).collect(),
                        source: ErrorSource::SetPoint,
                    },
                    None => ControlError {
                        values: centred(pv).iter().map(|v| -v).collect(),
                        source: ErrorSource::MeanPv,
                    },
                })
            })
            .as_ref()
    }

    /// The half waves of the control error around its mean; empty without a PV.
    pub fn error_half_waves(&self) -> &[HalfWave] {
        self.error_half_waves.get_or_init(|| {
            self.error().map_or(vec![], |error| half_waves(&centred(&error.values)))
        })
    }

    /// The judgement from OP and measured valve position.
    ///
    /// # Errors
    /// As [`lagged_position::judge`]; and if no position is recorded.
    pub fn position(&self) -> Result<&Judgement, Abstention> {
        let Segment { op, pv, sp, vp, .. } = self.segment;
        let judge = || match vp {
            Some(vp) => {
                let moves = lagged_position::moves(op, pv.as_deref(), sp.as_deref());
                lagged_position::judge(op, vp, moves)
            }
            None => Err(Abstention("no valve position is recorded".to_owned())),
        };
        self.position.get_or_init(judge).as_ref().map_err(Clone::clone)
    }
}
