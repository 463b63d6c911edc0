//! Friction laws: one law, one file.
//!
//! | name | law |
//! |---|---|
//! | `classical` | [`Classical`]: static, Coulomb, Stribeck, viscous |
//! | `karnopp` | [`Karnopp`]: classical with a zero-velocity band |
//! | `dahl` | [`Dahl`]: a spring that yields at the Coulomb level |
//! | `lugre` | [`LuGre`]: bristles with a Stribeck level and damping |
//! | `gms` | [`Gms`]: bristles in parallel, each sticking or slipping |
//! | `armstrong` | [`Armstrong`]: seven parameters, with memory and dwell |
//!
//! Friction is positive when it opposes upward motion, so the force balance subtracts it.

mod armstrong;
pub(crate) mod bristle;
mod classical;
mod dahl;
mod gms;
mod karnopp;
mod lugre;

pub use armstrong::Armstrong;
pub use classical::Classical;
pub use dahl::Dahl;
pub(crate) use gms::GmsInUse;
pub use gms::{Gms, GmsElement};
pub use karnopp::Karnopp;
pub use lugre::LuGre;

use crate::error::{Error, Result};

/// A friction law with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrictionLaw {
    /// Static, Coulomb, Stribeck and viscous friction.
    Classical(Classical),
    /// Classical with a zero-velocity band.
    Karnopp(Karnopp),
    /// A spring that yields at the Coulomb level.
    Dahl(Dahl),
    /// Bristles with a Stribeck level and damping.
    LuGre(LuGre),
    /// Bristles in parallel, each sticking or slipping.
    Gms(Gms),
    /// Seven parameters, with frictional memory and dwell time.
    Armstrong(Armstrong),
}

/// The description of a friction law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct LawEntry {
    /// Name of the law in commands.
    pub name: &'static str,
    /// Principle, in one line.
    pub summary: &'static str,
    /// Source of the law, cited from memory and not verified unless stated otherwise.
    pub source: &'static str,
    /// Names of the parameters, with units, in order.
    pub parameters: &'static [&'static str],
}

/// Every friction law. The journal papers are cited from memory.
pub const LAWS: [LawEntry; 6] = [
    LawEntry {
        name: "classical",
        summary: "static, Coulomb, Stribeck and viscous friction",
        source: "Stribeck curve as in public valve-estimation code of F. G. Marques (read)",
        parameters: &["static_n", "coulomb_n", "viscous_n_s_per_m", "stribeck_m_per_s"],
    },
    LawEntry {
        name: "karnopp",
        summary: "classical friction with a band of velocities that count as zero",
        source: "Karnopp, J. Dyn. Syst. Meas. Control 107 (1985) 100-103",
        parameters: &[
            "static_n",
            "coulomb_n",
            "viscous_n_s_per_m",
            "stribeck_m_per_s",
            "band_m_per_s",
        ],
    },
    LawEntry {
        name: "dahl",
        summary: "a spring that yields at the Coulomb level",
        source: "Dahl, Aerospace Corporation TOR-0158(3107-18)-1 (1968)",
        parameters: &["coulomb_n", "stiffness_n_per_m", "viscous_n_s_per_m"],
    },
    LawEntry {
        name: "lugre",
        summary: "bristles with a Stribeck level, stiffness and damping",
        source: "Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE TAC 40 (1995) 419-425",
        parameters: &[
            "static_n",
            "coulomb_n",
            "viscous_n_s_per_m",
            "stribeck_m_per_s",
            "stiffness_n_per_m",
            "damping_n_s_per_m",
        ],
    },
    LawEntry {
        name: "gms",
        summary: "three bristles in parallel, each sticking or slipping",
        source: "Al-Bender, Lampaert, Swevers, IEEE TAC 50 (2005) 1883-1887",
        parameters: &[
            "static_n",
            "coulomb_n",
            "viscous_n_s_per_m",
            "stribeck_m_per_s",
            "attraction_n_per_s",
            "stiffness_1_n_per_m",
            "damping_1_n_s_per_m",
            "share_1",
            "stiffness_2_n_per_m",
            "damping_2_n_s_per_m",
            "share_2",
            "stiffness_3_n_per_m",
            "damping_3_n_s_per_m",
            "share_3",
        ],
    },
    LawEntry {
        name: "armstrong",
        summary: "seven parameters, with frictional memory and rising static friction",
        source: "Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083-1138",
        parameters: &[
            "presliding_n_per_m",
            "coulomb_n",
            "viscous_n_s_per_m",
            "static_excess_n",
            "stribeck_m_per_s",
            "memory_s",
            "rise_s",
        ],
    },
];

/// A [`FrictionLaw`] in a document.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
struct FrictionDocument {
    /// Name.
    law: &'static str,
    /// Parameters by name, SI units.
    parameters: std::collections::BTreeMap<&'static str, f64>,
}

#[cfg(feature = "serde")]
crate::written_as!(FrictionLaw, FrictionDocument);

#[cfg(feature = "serde")]
impl From<&FrictionLaw> for FrictionDocument {
    fn from(law: &FrictionLaw) -> Self {
        Self { law: law.name(), parameters: law.values().into_iter().collect() }
    }
}

impl FrictionLaw {
    /// The law called `name` with its parameters in the order of its [`LawEntry`].
    ///
    /// # Errors
    /// If no law has this name, the number of values is wrong, or a value is out of range.
    pub fn from_name(name: &str, values: &[f64]) -> Result<Self> {
        let entry = Self::entry(name)?;
        if values.len() != entry.parameters.len() {
            return Err(Error::Length {
                name: "friction parameters",
                found: values.len(),
                expected: entry.parameters.len(),
            });
        }
        let steady = || Classical::new(values[0], values[1], values[2], values[3]);
        Ok(match entry.name {
            "classical" => Self::Classical(steady()?),
            "karnopp" => Self::Karnopp(Karnopp::new(steady()?, values[4])?),
            "dahl" => Self::Dahl(Dahl::new(values[0], values[1], values[2])?),
            "lugre" => Self::LuGre(LuGre::new(steady()?, values[4], values[5])?),
            "gms" => {
                let element = |i: usize| GmsElement {
                    stiffness_n_per_m: values[i],
                    damping_n_s_per_m: values[i + 1],
                    share: values[i + 2],
                };
                let elements = [element(5), element(8), element(11)];
                Self::Gms(Gms::new(steady()?, values[4], &elements)?)
            }
            _ => Self::Armstrong(
                Armstrong {
                    presliding_n_per_m: values[0],
                    coulomb_n: values[1],
                    viscous_n_s_per_m: values[2],
                    static_excess_n: values[3],
                    stribeck_m_per_s: values[4],
                    memory_s: values[5],
                    rise_s: values[6],
                }
                .checked()?,
            ),
        })
    }

    /// The law called `name`, as in [`LAWS`].
    ///
    /// # Errors
    /// If no law has this name.
    pub(in crate::stem) fn entry(name: &str) -> Result<&'static LawEntry> {
        LAWS.iter().find(|entry| entry.name == name).ok_or_else(|| Error::UnknownName {
            family: "friction law",
            name: name.to_owned(),
            known: LAWS.map(|entry| entry.name).join(", "),
        })
    }

    /// Name and value of every parameter, in the order of the law's [`LawEntry`].
    pub fn values(&self) -> Vec<(&'static str, f64)> {
        let mut values = match self.steady() {
            Some(law) => {
                let stribeck = law.stribeck_m_per_s();
                vec![law.static_n(), law.coulomb_n(), law.viscous_n_s_per_m(), stribeck]
            }
            None => vec![],
        };
        match self {
            Self::Classical(_) => {}
            Self::Karnopp(law) => values.push(law.band_m_per_s()),
            Self::Dahl(law) => {
                values.extend([law.coulomb_n(), law.stiffness_n_per_m(), law.viscous_n_s_per_m()]);
            }
            Self::LuGre(law) => {
                values.extend([law.stiffness_n_per_m(), law.damping_n_s_per_m()]);
            }
            Self::Gms(law) => {
                values.push(law.attraction_n_per_s());
                for element in law.elements() {
                    let GmsElement { stiffness_n_per_m, damping_n_s_per_m, share } = element;
                    values.extend([stiffness_n_per_m, damping_n_s_per_m, share]);
                }
            }
            Self::Armstrong(law) => values.extend([
                law.presliding_n_per_m,
                law.coulomb_n,
                law.viscous_n_s_per_m,
                law.static_excess_n,
                law.stribeck_m_per_s,
                law.memory_s,
                law.rise_s,
            ]),
        }
        let entry = LAWS.iter().find(|entry| entry.name == self.name());
        let names = entry.map_or(&[][..], |entry| entry.parameters);
        names.iter().copied().zip(values).collect()
    }

    /// Name of the law, as in [`LAWS`].
    pub fn name(&self) -> &'static str {
        match self {
            Self::Classical(_) => "classical",
            Self::Karnopp(_) => "karnopp",
            Self::Dahl(_) => "dahl",
            Self::LuGre(_) => "lugre",
            Self::Gms(_) => "gms",
            Self::Armstrong(_) => "armstrong",
        }
    }

    /// The steady Stribeck curve, if the law has one.
    fn steady(&self) -> Option<&Classical> {
        match self {
            Self::Classical(law) => Some(law),
            Self::Karnopp(law) => Some(law.steady()),
            Self::LuGre(law) => Some(law.steady()),
            Self::Gms(law) => Some(law.steady()),
            Self::Dahl(_) | Self::Armstrong(_) => None,
        }
    }

    /// Static friction after a long rest, N.
    pub fn static_n(&self) -> f64 {
        match self {
            Self::Dahl(law) => law.coulomb_n(),
            Self::Armstrong(law) => law.coulomb_n + law.static_excess_n,
            _ => self.steady().map_or(0.0, Classical::static_n),
        }
    }

    /// Coulomb friction, N.
    pub fn coulomb_n(&self) -> f64 {
        match self {
            Self::Dahl(law) => law.coulomb_n(),
            Self::Armstrong(law) => law.coulomb_n,
            _ => self.steady().map_or(0.0, Classical::coulomb_n),
        }
    }

    /// Viscous friction, N s/m.
    pub fn viscous_n_s_per_m(&self) -> f64 {
        match self {
            Self::Dahl(law) => law.viscous_n_s_per_m(),
            Self::Armstrong(law) => law.viscous_n_s_per_m,
            _ => self.steady().map_or(0.0, Classical::viscous_n_s_per_m),
        }
    }

    /// Steepest fall of steady friction with velocity, without the viscous part, N s/m. With at least this much
    /// viscous friction the total rises with velocity everywhere.
    ///
    /// `sqrt(2/e) (Fs - Fc)/vs` for the Stribeck curve (at `v = vs/sqrt 2`), `3 sqrt(3)/8 Fs,inf/vs`
    /// for Armstrong's, 0 for Dahl's, and infinite if static friction acts only at rest (`vs = 0`).
    pub fn steepest_fall_n_s_per_m(&self) -> f64 {
        self.fall_over_stribeck((2.0 / std::f64::consts::E).sqrt(), 0.375 * 3.0_f64.sqrt())
    }

    /// Steepest line from static friction down to the friction of motion, without the viscous part, N s/m. With at
    /// least this much viscous friction the total never falls below static friction.
    ///
    /// `0.6382 (Fs - Fc)/vs` for the Stribeck curve: the greatest `(1 - exp(-r^2))/r`, which is
    /// `2r/(1 + 2r^2)` at the root of `exp(r^2) = 1 + 2r^2`, `r^2 = 1.2564`. `Fs,inf/(2 vs)` for
    /// Armstrong's; otherwise as for [`Self::steepest_fall_n_s_per_m`].
    pub fn steepest_dip_n_s_per_m(&self) -> f64 {
        self.fall_over_stribeck(0.638_172_686_338_951_5, 0.5)
    }

    /// `(Fs - Fc)/vs` times a factor for the Stribeck curve or for Armstrong's.
    fn fall_over_stribeck(&self, stribeck: f64, armstrong: f64) -> f64 {
        let fall_n = self.static_n() - self.coulomb_n();
        if fall_n == 0.0 {
            return 0.0;
        }
        match self {
            Self::Armstrong(law) => armstrong * fall_n / law.stribeck_m_per_s,
            _ => stribeck * fall_n / self.steady().map_or(0.0, Classical::stribeck_m_per_s),
        }
    }

    /// Whether static friction acts only at rest, so that friction jumps at breakaway.
    pub fn static_only_at_rest(&self) -> bool {
        self.steepest_fall_n_s_per_m().is_infinite()
    }
}
