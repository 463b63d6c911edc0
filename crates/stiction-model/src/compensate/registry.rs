//! The compensators by name, with parameters from the known valve and loop.

use super::tuning::Figures;
use super::{
    Compensator, ConstantReinforcement, Correction, IntegralDeadZone, IntegralLimit, Knocker,
    Knowledge, ModifiedTwoMove, Moves, SixMove, Supervised, ThreeMove, TwoMove,
};
use crate::error::{Error, Result, require};

/// A method of compensation, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// [`Knocker`]
    Knocker,
    /// [`ConstantReinforcement`]
    ConstantReinforcement,
    /// [`TwoMove`]
    TwoMove,
    /// [`ModifiedTwoMove`]
    ModifiedTwoMove,
    /// [`ThreeMove`]
    ThreeMove,
    /// [`SixMove`]
    SixMove,
    /// [`IntegralDeadZone`]
    IntegralDeadZone,
    /// [`IntegralLimit`]
    IntegralLimit,
    /// [`Supervised`]; the automatic choice supervises a knocker.
    Supervised,
}

/// The description of a compensator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", schemars(rename = "Compensator"))]
pub struct Description {
    /// Name in commands.
    pub name: &'static str,
    /// Principle, in one line.
    pub summary: &'static str,
    /// Source of the compensator.
    pub citation: &'static str,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 9] = [
        Self::Knocker,
        Self::ConstantReinforcement,
        Self::TwoMove,
        Self::ModifiedTwoMove,
        Self::ThreeMove,
        Self::SixMove,
        Self::IntegralDeadZone,
        Self::IntegralLimit,
        Self::Supervised,
    ];

    /// The description of this method.
    pub fn describe(self) -> Description {
        let (name, summary, citation) = match self {
            Self::Knocker => (
                "knocker",
                "short pulses added in the direction of OP movement",
                "Hägglund, J. Process Control 12 (2002) 507",
            ),
            Self::ConstantReinforcement => (
                "constant-reinforcement",
                "a constant added in the direction of OP movement",
                "Ivan, Lakshminarayanan (2009)",
            ),
            Self::TwoMove => (
                "two-move",
                "moves away from the stuck position, then to the steady position, and holds",
                "Srinivasan, Rengaswamy, Comput. Chem. Eng. (2008)",
            ),
            Self::ModifiedTwoMove => (
                "modified-two-move",
                "repeats the two moves, with a target corrected by the control error",
                "Farenzena, Trierweiler (2010); the form is ours",
            ),
            Self::ThreeMove => (
                "three-move",
                "moves past the steady position on both sides, then to this position, and holds",
                "Wang (2013); the form is ours",
            ),
            Self::SixMove => (
                "six-move",
                "three moves, a check of the offset, three more moves, and a hold",
                "Wang (2013), Arifin (2018); the form is ours",
            ),
            Self::IntegralDeadZone => (
                "integral-dead-zone",
                "integral action frozen while the control error is small",
                "practice",
            ),
            Self::IntegralLimit => (
                "integral-limit",
                "integral action within a range around the steady OP",
                "practice",
            ),
            Self::Supervised => (
                "supervised",
                "a knocker that works only while the control error is large",
                "Cuadros et al. (2012); thresholds are ours",
            ),
        };
        Description { name, summary, citation }
    }

    /// The method called `name`, in any case.
    ///
    /// # Errors
    /// If no method has that name; the error lists the known ones.
    pub fn by_name(name: &str) -> Result<Self> {
        let wanted = name.trim().to_ascii_lowercase();
        Self::ALL.into_iter().find(|method| method.describe().name == wanted).ok_or_else(|| {
            Error::UnknownName {
                family: "compensator",
                name: name.to_owned(),
                known: Self::ALL.map(|method| method.describe().name).join(", "),
            }
        })
    }

    /// A compensator of this method with parameters from the known valve and loop.
    ///
    /// All rules are ours except for the published ranges. `W` is the dead time plus three time constants of the
    /// process (one if it integrates, because an error then only grows), `K` its response to a unit step after `W`.
    /// For an integrating or unknown process the time constant is the integral time of the controller. For an
    /// unknown process `K = 1/Kc`, because the gains of process and controller multiply to about 1 in a tuned loop.
    ///
    /// | method | rule | reason |
    /// |---|---|---|
    /// | knocker | `a = S/2`, 2 samples every 5 | from the middle of the band, half of S reaches its edge; width and period are in the published ranges |
    /// | constant reinforcement | `a = S/2` | a reversal then crosses half of the band at once; more would move a stem with `J = 0` too far |
    /// | moves | reach `1.5 (S + J)`, each held for one sample | `S + J = 2 fs` breaks the stem away from any position; half more allows for bands estimated a third too small. Raise the hold to the stroke time if it is known |
    /// | two-, three-, six-move | judged after `W`; periods must agree to `S/5` in the mean OP | a stem still wrong by `S/5` is better than the cycle, of about `0.6 S` |
    /// | six-, modified two-move | pace 0.5, zone `0.01 S K` and three deviations of the noise in the mean | stable for a gain wrong by a factor of up to 2 |
    /// | integral dead zone | `K max(J/2, S/10)` and three deviations of the noise | the stem stops at positions about J apart, one of which is within J/2 of the right one |
    /// | integral limit | `fs - (1 + Kc K) J/2` around the steady OP, but between `S/20` and `S/4`; the whole span if `S = 0` | a stem stuck `J/2` off its target meets an OP that the proportional part has moved by `Kc K J/2`; the rest up to the breakaway is left to the integral |
    /// | supervised knocker | wakes at `0.1 S K`, rests at three quarters of it after a fifth of the time constant, both with three deviations of the filtered noise | a tenth of S is far below the cycle's swing of the PV |
    ///
    /// # Errors
    /// If S, J or the noise is negative or not finite, or the sample time not positive.
    pub fn automatic(self, known: &Knowledge) -> Result<Box<dyn Compensator>> {
        self.with(known, &[])
    }

    /// As [`automatic`](Self::automatic), except for the given parameters, by their names in
    /// [`Compensator::parameters`].
    ///
    /// ```
    /// use stiction_model::closed_loop::Controller;
    /// use stiction_model::compensate::{Knowledge, Method};
    /// let known = Knowledge::new(5.0, Some(3.0), Controller::pi(1.1, 2.5)?, 0.1);
    /// let knocker = Method::Knocker.with(&known, &[("width", 1.0)])?;
    /// assert_eq!(knocker.parameters()[1].value, 1.0);
    /// assert_eq!(knocker.parameters()[0].value, 2.5);
    /// # Ok::<(), stiction_model::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`automatic`](Self::automatic), or if the method has no such parameter, or the value is invalid.
    pub fn with(self, known: &Knowledge, given: &[(&str, f64)]) -> Result<Box<dyn Compensator>> {
        let mut given = Given { given, asked: vec![] };
        let compensator = self.chosen(known, &mut given)?;
        given.all_are_known()?;
        Ok(compensator)
    }

    fn chosen(self, known: &Knowledge, given: &mut Given<'_>) -> Result<Box<dyn Compensator>> {
        let figures = Figures::of(known)?;
        let Figures { bands, sample_time, settle_s, memory, .. } = figures;
        let gain = figures.gain.abs();
        let automatic = Moves { hold_s: sample_time, ..Moves::new(bands) };
        let moves = |given: &mut Given<'_>| {
            let settle_s = given.or("settle", settle_s);
            Moves {
                steady_op: given.find("steady OP"),
                reach: given.or("reach", automatic.reach),
                hold_s: given.or("hold", automatic.hold_s),
                settle_s,
                memory_s: 4.0 * settle_s,
                ..automatic
            }
        };
        let correction = |given: &mut Given<'_>| Correction {
            gain: given.or("gain", figures.gain),
            memory: given.or("memory", memory),
            pace: given.or("pace", 0.5),
            zone: given.or("zone", 0.01 * bands.s() * gain + figures.noise_of_mean()),
        };
        let knocker = |given: &mut Given<'_>| {
            let usual = Knocker::default();
            Knocker {
                amplitude: given.or("amplitude", 0.5 * bands.s()),
                width: given.samples("width", usual.width)?,
                period: given.samples("period", usual.period)?,
            }
            .start()
        };
        match self {
            Self::Knocker => knocker(given),
            Self::ConstantReinforcement => {
                ConstantReinforcement { amplitude: given.or("amplitude", 0.5 * bands.s()) }.start()
            }
            Self::TwoMove => TwoMove { moves: moves(given) }.start(),
            Self::ThreeMove => ThreeMove { moves: moves(given) }.start(),
            Self::SixMove => SixMove { moves: moves(given), correction: correction(given) }.start(),
            Self::ModifiedTwoMove => {
                ModifiedTwoMove { moves: moves(given), correction: correction(given) }.start()
            }
            Self::IntegralDeadZone => {
                let half_a_slip = (0.5 * bands.j()).max(0.1 * bands.s());
                let zone = given.or("zone", gain * half_a_slip + 3.0 * known.noise_sd);
                IntegralDeadZone { zone }.start()
            }
            Self::IntegralLimit => {
                let loop_gain = (gain * known.controller.gains().0).abs();
                let left = bands.fs() - (1.0 + loop_gain) * 0.5 * bands.j();
                let nothing_sticks = bands.s() == 0.0;
                let half_width = if nothing_sticks {
                    IntegralLimit::SPAN
                } else {
                    left.max(0.05 * bands.s()).min(0.25 * bands.s())
                };
                IntegralLimit {
                    half_width: given.or("half-width", half_width),
                    steady_op: given.find("steady OP"),
                    agree: automatic.agree,
                    memory_s: 4.0 * settle_s,
                }
                .start()
            }
            Self::Supervised => {
                // Without stiction, a knocker without effect, which hardly ever rests.
                let wake = (0.1 * bands.s() * gain).max(f64::MIN_POSITIVE);
                let filter_s = given.or("filter", 5.0 * sample_time);
                // White noise of standard deviation 1 has about sqrt(Ts / 2 Tf) behind the filter.
                let left = (0.5 * sample_time / filter_s).sqrt().min(1.0);
                let noise = 3.0 * known.noise_sd * left;
                Supervised {
                    inner: knocker(given)?,
                    wake: given.or("wake", wake + noise),
                    quiet: given.or("quiet", 0.75 * wake + noise),
                    dwell_s: given.or("dwell", 0.2 * figures.lag_s),
                    filter_s,
                }
                .start()
            }
        }
    }
}

/// Given parameters, and the parameters of a method.
struct Given<'a> {
    given: &'a [(&'a str, f64)],
    asked: Vec<&'static str>,
}

impl Given<'_> {
    fn find(&mut self, name: &'static str) -> Option<f64> {
        self.asked.push(name);
        self.given.iter().find(|each| each.0 == name).map(|each| each.1)
    }

    fn or(&mut self, name: &'static str, automatic: f64) -> f64 {
        self.find(name).unwrap_or(automatic)
    }

    fn samples(&mut self, name: &'static str, automatic: usize) -> Result<usize> {
        let value = self.or(name, automatic as f64);
        let ok = (1.0..=1e9).contains(&value) && value.fract() == 0.0;
        Ok(require(name, value, ok, "a whole number of samples, at least 1")? as usize)
    }

    fn all_are_known(&self) -> Result<()> {
        match self.given.iter().find(|each| !self.asked.contains(&each.0)) {
            None => Ok(()),
            Some((name, _)) => Err(Error::UnknownName {
                family: "parameter of this compensator",
                name: (*name).to_owned(),
                known: self.asked.join(", "),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::Controller;

    #[test]
    fn every_method_is_described_and_found_by_its_name() {
        let controller = Controller::pi(1.0, 5.0).unwrap();
        let known = Knowledge::new(5.0, Some(2.0), controller, 0.1);
        for (i, method) in Method::ALL.into_iter().enumerate() {
            let description = method.describe();
            assert!(Method::ALL[..i].iter().all(|m| m.describe().name != description.name));
            for text in [description.name, description.summary, description.citation] {
                assert!(!text.trim().is_empty() && !text.contains("  "), "{text}");
            }
            assert_eq!(Method::by_name(&description.name.to_uppercase()).unwrap(), method);
            let compensator = method.automatic(&known).unwrap();
            assert_eq!(compensator.method(), method);
            let parameters = compensator.parameters();
            assert!(!parameters.is_empty() && parameters.iter().all(|p| p.value.is_finite()));
        }
        let error = Method::by_name("nonesuch").unwrap_err().to_string();
        assert!(error.contains("knocker"), "{error}");
    }
}
