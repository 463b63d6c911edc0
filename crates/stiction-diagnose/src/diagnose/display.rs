//! Findings in one line of plain text.
//!
//! ```
//! use stiction_diagnose::diagnose::{Cause, Estimate, VerdictClass};
//!
//! let s = Estimate { value: 3.94, low: 2.8, high: 4.42 };
//! assert_eq!(format!("{}: {s}", VerdictClass::Sticks), "sticks: 3.9 (2.8 to 4.4)");
//! assert_eq!(Cause::StickingValve.to_string(), Cause::StickingValve.name());
//! ```

use super::{Basis, Cause, Diagnosis, Verdict, VerdictClass};
use crate::spoken::{percent, rough};
use std::fmt;

impl fmt::Display for VerdictClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl fmt::Display for Basis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The class, with the limit of a cleared valve, and the probability.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.class)?;
        if let (VerdictClass::DoesNotStick, Some(limit)) = (self.class, self.s_below) {
            write!(f, " by more than {} %", rough(limit.value))?;
        }
        match self.probability {
            Some(p) => write!(f, ", {}", percent(p)),
            None => Ok(()),
        }
    }
}

/// Tag, verdict, and S and J in percent of span where they are numbers.
impl fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.name, self.verdict)?;
        for (name, number) in [("S", self.stiction.s), ("J", self.stiction.j)] {
            if let Some(number) = number {
                write!(f, "; {name} {number} %")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::diagnose::{DiagnoseOptions, diagnose};
    use crate::recording::Recording;

    #[test]
    fn a_diagnosis_is_one_line() {
        let recording = Recording::regular("FIC7", 1.0, &[50.0; 400], None, None).unwrap();
        let found = diagnose(&recording, &DiagnoseOptions::default()).unwrap();
        assert_eq!(found.to_string(), "FIC7: cannot tell");
    }
}
