//! What to do about a loop.

use crate::report::health::Health;
use stiction_diagnose::diagnose::{Cause, Grade, VerdictClass};
use stiction_model::{always_written_by_name, named};

/// The least likelihood of a cause other than stiction that leads to an action.
pub const LIKELY: f64 = 0.5;

named! {
    /// What to do about a loop, the most urgent first.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
    pub enum Action {
        /// Test the valve, and send it to the workshop.
        Repair = "repair",
        /// Tune the controller.
        Retune = "retune",
        /// The oscillation comes from elsewhere.
        LookUpstream = "look upstream",
        /// The data cannot answer.
        CheckData = "check data",
        /// Nothing.
        #[default]
        Leave = "leave",
    }
}

always_written_by_name!(Action);

impl Action {
    /// Letter on the map.
    pub fn letter(self) -> char {
        match self {
            Self::Repair => 'R',
            Self::Retune => 'T',
            Self::LookUpstream => 'U',
            Self::CheckData => 'D',
            Self::Leave => 'L',
        }
    }
}

/// What an action rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// The week's verdict in one word; empty without a verdict.
    pub grade: Option<Grade>,
    /// The conclusion of a person, which has precedence over the verdict and the test.
    pub overruled: Option<VerdictClass>,
    /// The result of the last test of the valve, which has precedence over the verdict.
    pub tested: Option<VerdictClass>,
    /// The health of the data.
    pub health: Health,
    /// Whether the loop oscillates in most of the last windows.
    pub oscillates: bool,
    /// The likeliest other cause with its likelihood.
    pub alternative: Option<(Cause, f64)>,
    /// Whether the loop swings with a loop whose valve is likely to stick, and is not the first candidate for the
    /// source.
    pub is_victim: bool,
}

impl Found {
    /// What to do.
    pub fn action(&self) -> Action {
        match self.overruled {
            Some(VerdictClass::Sticks | VerdictClass::DoesNotRespond) => return Action::Repair,
            Some(VerdictClass::DoesNotStick) => return self.without_stiction(),
            Some(VerdictClass::CannotTell) | None => {}
        }
        match self.tested {
            Some(VerdictClass::Sticks | VerdictClass::DoesNotRespond) => return Action::Repair,
            Some(VerdictClass::DoesNotStick) => return self.without_stiction(),
            Some(VerdictClass::CannotTell) | None => {}
        }
        match (self.health, self.grade) {
            (Health::NoData | Health::Errors | Health::Frozen | Health::Manual, _)
            | (_, None | Some(Grade::CannotAnswer)) => Action::CheckData,
            (_, Some(Grade::Sticks | Grade::ProbablySticks | Grade::DoesNotRespond)) => {
                Action::Repair
            }
            _ => self.without_stiction(),
        }
    }

    fn without_stiction(&self) -> Action {
        let cause = self.alternative.filter(|(_, likelihood)| *likelihood >= LIKELY);
        match cause.map(|(cause, _)| cause) {
            // What hardly swings has nothing to look for upstream, even if it moves in step with others.
            _ if !self.oscillates => Action::Leave,
            Some(Cause::AggressiveTuning | Cause::ProcessNonlinearity | Cause::Saturation) => {
                Action::Retune
            }
            Some(Cause::ExternalOscillation | Cause::ExternalWave | Cause::ResettingLoad) => {
                Action::LookUpstream
            }
            Some(Cause::Quantisation | Cause::DeadZoneElsewhere) => Action::CheckData,
            Some(Cause::NormalOperation | Cause::SetPointChanges) => Action::Leave,
            _ if self.is_victim => Action::LookUpstream,
            _ => Action::Leave,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_go_before_the_verdict_and_the_valve_before_other_causes() {
        let found = Found {
            grade: Some(Grade::Sticks),
            overruled: None,
            tested: None,
            health: Health::Good,
            oscillates: true,
            alternative: Some((Cause::AggressiveTuning, 0.7)),
            is_victim: false,
        };
        assert_eq!(found.action(), Action::Repair);
        let overruled = |verdict| Found { overruled: Some(verdict), ..found };
        assert_eq!(overruled(VerdictClass::DoesNotStick).action(), Action::Retune);
        assert_eq!(overruled(VerdictClass::CannotTell).action(), Action::Repair);
        let tested = |verdict| Found { tested: Some(verdict), ..found };
        assert_eq!(tested(VerdictClass::DoesNotStick).action(), Action::Retune);
        assert_eq!(tested(VerdictClass::CannotTell).action(), Action::Repair);
        let person =
            Found { overruled: Some(VerdictClass::Sticks), ..tested(VerdictClass::DoesNotStick) };
        assert_eq!(person.action(), Action::Repair);
        let fine = Found { grade: Some(Grade::Fine), ..tested(VerdictClass::Sticks) };
        assert_eq!(fine.action(), Action::Repair);
        let of = |grade| Found { grade: Some(grade), ..found };
        assert_eq!(of(Grade::Unclear).action(), Action::Retune);
        assert_eq!(Found { oscillates: false, ..of(Grade::Fine) }.action(), Action::Leave);
        assert_eq!(of(Grade::CannotAnswer).action(), Action::CheckData);
        let victim = Found { alternative: None, is_victim: true, ..of(Grade::Fine) };
        assert_eq!(victim.action(), Action::LookUpstream);
        assert_eq!(Found { oscillates: false, ..victim }.action(), Action::Leave);
        let normal = Some((Cause::NormalOperation, 0.6));
        assert_eq!(Found { alternative: normal, ..victim }.action(), Action::Leave);
        assert_eq!(Found { health: Health::Frozen, ..found }.action(), Action::CheckData);
    }
}
