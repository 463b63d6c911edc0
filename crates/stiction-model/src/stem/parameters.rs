//! Parameters of the stem and its actuator, and sets of them by name.

use super::Stem;
use super::friction::{Classical, FrictionLaw, Gms, GmsElement, Karnopp, LuGre};
use crate::error::{Error, Result, finite, non_negative, positive, require};

/// The stem, spring and actuator, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct StemParameters {
    /// Mass of the moving parts `M`, kg; above 0.
    pub mass_kg: f64,
    /// Spring constant `k`, N/m; above 0.
    pub spring_n_per_m: f64,
    /// Diaphragm area `Sa`, m2; above 0.
    pub area_m2: f64,
    /// Spring preload `Finit`, N: the force of the spring at position 0.
    pub preload_n: f64,
    /// Travel from closed (0) to open, m; above 0.
    pub stroke_m: f64,
    /// Air pressure at 0 % controller output, Pa.
    pub pressure_min_pa: f64,
    /// Air pressure at 100 % controller output, Pa; above the former.
    pub pressure_max_pa: f64,
    /// Time constant of the first-order lag between demanded and acting air pressure, s; 0 for
    /// none.
    pub air_lag_s: f64,
    /// Whether the stem is stopped at 0 and at the full stroke.
    pub end_stops: bool,
}

impl StemParameters {
    /// Every parameter by name, units in the names; `end_stops` is 1 for yes and 0 for no.
    pub fn values(&self) -> [(&'static str, f64); 9] {
        [
            ("mass_kg", self.mass_kg),
            ("spring_n_per_m", self.spring_n_per_m),
            ("area_m2", self.area_m2),
            ("preload_n", self.preload_n),
            ("stroke_m", self.stroke_m),
            ("pressure_min_pa", self.pressure_min_pa),
            ("pressure_max_pa", self.pressure_max_pa),
            ("air_lag_s", self.air_lag_s),
            ("end_stops", f64::from(u8::from(self.end_stops))),
        ]
    }

    /// These parameters from their [`values`](Self::values), in that order.
    pub fn from_values(values: [f64; 9]) -> Self {
        let [
            mass_kg,
            spring_n_per_m,
            area_m2,
            preload_n,
            stroke_m,
            pressure_min_pa,
            pressure_max_pa,
            air_lag_s,
            end_stops,
        ] = values;
        Self {
            mass_kg,
            spring_n_per_m,
            area_m2,
            preload_n,
            stroke_m,
            pressure_min_pa,
            pressure_max_pa,
            air_lag_s,
            end_stops: end_stops != 0.0,
        }
    }

    /// Returns these parameters if each is finite and in range.
    ///
    /// # Errors
    /// If a parameter is not finite or out of range.
    pub fn checked(self) -> Result<Self> {
        positive("mass", self.mass_kg)?;
        positive("spring constant", self.spring_n_per_m)?;
        positive("diaphragm area", self.area_m2)?;
        finite("spring preload", self.preload_n)?;
        positive("stroke", self.stroke_m)?;
        finite("pressure at 0 %", self.pressure_min_pa)?;
        let above = self.pressure_max_pa > self.pressure_min_pa;
        let allowed = format!("above the pressure at 0 %, {} Pa", self.pressure_min_pa);
        require("pressure at 100 %", self.pressure_max_pa, above, &allowed)?;
        non_negative("air lag", self.air_lag_s)?;
        Ok(self)
    }

    /// Air pressure demanded by a controller output, Pa. Not limited to 0-100 %.
    pub fn pressure_pa(&self, op_percent: f64) -> f64 {
        self.pressure_min_pa + op_percent / 100.0 * (self.pressure_max_pa - self.pressure_min_pa)
    }

    /// Pressure for an OP, limited to the pressure of the air supply.
    pub fn supplied_pa(&self, op_percent: f64, supply_pa: f64) -> f64 {
        self.pressure_pa(op_percent).min(supply_pa)
    }

    /// A position in percent of stroke.
    pub fn percent(&self, position_m: f64) -> f64 {
        100.0 * position_m / self.stroke_m
    }

    /// A percentage of stroke as a position, m.
    pub fn position_m(&self, percent: f64) -> f64 {
        percent / 100.0 * self.stroke_m
    }

    /// Net force on the stem without friction, N: `Sa p - k x - Finit`.
    pub fn net_force_n(&self, pressure_pa: f64, position_m: f64) -> f64 {
        self.area_m2 * pressure_pa - self.spring_n_per_m * position_m - self.preload_n
    }

    /// Balance of spring and pressure, m, between the end stops if there are any.
    pub fn balance_m(&self, pressure_pa: f64) -> f64 {
        let position_m = self.net_force_n(pressure_pa, 0.0) / self.spring_n_per_m;
        if self.end_stops { position_m.max(0.0).min(self.stroke_m) } else { position_m }
    }
}

/// A valve with a named set of parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterSet {
    /// Name, as a user writes it.
    pub name: &'static str,
    /// Description, in one line.
    pub summary: &'static str,
    /// Source of the numbers, and whether it was verified.
    pub source: &'static str,
    /// Stem and actuator.
    pub stem: StemParameters,
    /// Friction.
    pub friction: FrictionLaw,
}

const CTS_SOURCE: &str = "the valve of Kayihan and Doyle as used by Choudhury, Thornhill and Shah, \
     Control Engineering Practice 13 (2005) 641-658; recalled, not verified";
const USP_SOURCE: &str = "header valve_models.h of the public valve_estimation code of \
     F. G. Marques (read); pressure signal without the 3.5714 s lag of its I/P converter";
const GRAPHITE_SOURCE: &str = "fit to a real valve with graphite packing, header valve_models.h of \
     the public valve_estimation code of F. G. Marques (read; the thesis itself was not)";

const CTS: StemParameters = StemParameters {
    mass_kg: 1.36,
    spring_n_per_m: 52_500.0,
    area_m2: 0.0645,
    preload_n: 0.0,
    stroke_m: 0.1016,
    pressure_min_pa: 0.0,
    pressure_max_pa: 68_948.0,
    air_lag_s: 0.0,
    end_stops: true,
};

const USP: StemParameters = StemParameters {
    mass_kg: 1.6,
    spring_n_per_m: 210_490.0,
    area_m2: 0.0445,
    preload_n: 2_550.0,
    stroke_m: 0.029,
    pressure_min_pa: 41_368.0,
    pressure_max_pa: 180_000.0,
    air_lag_s: 0.0,
    end_stops: true,
};

/// Names of the sets that [`ParameterSet::named`] knows.
pub const SETS: [&str; 8] = [
    "cts",
    "cts-stribeck",
    "usp",
    "usp-lugre",
    "usp-gms",
    "usp-graphite-karnopp",
    "usp-graphite-lugre",
    "lugre-textbook",
];

impl ParameterSet {
    /// The stem with the friction law called `friction` and with `changes` of parameters of stem and friction by name.
    /// The default law is the set's own law. The last change of a name counts. Parameters that the set's own law lacks
    /// come from the same valve's set for the requested law, if there is one.
    ///
    /// ```
    /// use stiction_model::stem::ParameterSet;
    /// let stem = ParameterSet::named("usp")?.stem_with(Some("lugre"), &[("coulomb_n", 650.0)])?;
    /// assert_eq!(stem.friction().coulomb_n(), 650.0);
    /// # Ok::<(), stiction_model::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::UnknownName`] if no such law or parameter exists, [`Error::Missing`] if the law has parameters that
    /// neither the set nor the changes give, or an error if a value is out of range.
    pub fn stem_with<N: AsRef<str>>(
        &self,
        friction: Option<&str>,
        changes: &[(N, f64)],
    ) -> Result<Stem> {
        let changed = |name: &str| {
            changes.iter().rev().find(|(n, _)| n.as_ref() == name).map(|(_, value)| *value)
        };
        let wanted = friction.unwrap_or(self.friction.name());
        let law = FrictionLaw::entry(wanted)?;
        let sibling = Self::named(&format!("{}-{wanted}", self.name)).ok();
        let mut inherited = self.friction.values();
        inherited.extend(sibling.map_or(vec![], |sibling| sibling.friction.values()));
        let mut values = vec![];
        let mut missing = vec![];
        for name in law.parameters {
            let inherited = inherited.iter().find(|(n, _)| n == name).map(|(_, value)| *value);
            match changed(name).or(inherited) {
                Some(value) => values.push(value),
                None => missing.push(*name),
            }
        }
        if !missing.is_empty() {
            return Err(Error::Missing { name: missing.join(", "), needed_by: law.name });
        }
        let friction = FrictionLaw::from_name(wanted, &values)?;
        let own = self.stem.values();
        let known = || own.iter().map(|(name, _)| *name).chain(law.parameters.iter().copied());
        if let Some((name, _)) = changes.iter().find(|(n, _)| known().all(|k| k != n.as_ref())) {
            return Err(Error::UnknownName {
                family: "stem parameter",
                name: name.as_ref().to_owned(),
                known: known().collect::<Vec<_>>().join(", "),
            });
        }
        let stem = own.map(|(name, value)| changed(name).unwrap_or(value));
        Stem::new(StemParameters::from_values(stem), friction)
    }

    /// The set called `name`, one of [`SETS`].
    ///
    /// # Errors
    /// If no set has this name.
    pub fn named(name: &str) -> Result<Self> {
        let unknown = || Error::UnknownName {
            family: "stem parameter set",
            name: name.to_owned(),
            known: SETS.join(", "),
        };
        let name = *SETS.iter().find(|known| **known == name).ok_or_else(unknown)?;
        let usp_steady = Classical::new(780.0, 700.0, 125_000.0, 5e-4)?;
        let (summary, source, stem, friction) = match name {
            "cts" => (
                "4-inch stroke valve, static friction only at rest: slides after breakaway",
                CTS_SOURCE,
                CTS,
                FrictionLaw::Classical(Classical::new(1_708.0, 1_423.0, 612.9, 0.0)?),
            ),
            "cts-stribeck" => (
                "4-inch stroke valve with a Stribeck velocity of 0.1 inch/s (this project's choice): moves in steps",
                CTS_SOURCE,
                CTS,
                FrictionLaw::Classical(Classical::new(1_708.0, 1_423.0, 612.9, 0.00254)?),
            ),
            "usp" => (
                "29 mm stroke valve, classical friction",
                USP_SOURCE,
                USP,
                FrictionLaw::Classical(usp_steady),
            ),
            "usp-lugre" => (
                "29 mm stroke valve, LuGre friction",
                USP_SOURCE,
                USP,
                FrictionLaw::LuGre(LuGre::new(usp_steady, 2.6e7, 20_396.07805437114)?),
            ),
            "usp-gms" => (
                "29 mm stroke valve, three-element GMS friction (the source gives k3 twice, 3.12e6 \
                 and 3.12e7 N/m; the former is used)",
                USP_SOURCE,
                USP,
                FrictionLaw::Gms(Gms::new(
                    usp_steady,
                    20.0,
                    &[
                        GmsElement {
                            stiffness_n_per_m: 2.925e7,
                            damping_n_s_per_m: 2_910.9,
                            share: 0.75,
                        },
                        GmsElement {
                            stiffness_n_per_m: 1.56e7,
                            damping_n_s_per_m: 1_455.5,
                            share: 0.2,
                        },
                        GmsElement {
                            stiffness_n_per_m: 3.12e6,
                            damping_n_s_per_m: 4_366.4,
                            share: 0.05,
                        },
                    ],
                )?),
            ),
            "usp-graphite-karnopp" => (
                "29 mm stroke valve fitted to a real one, Karnopp friction without a band",
                GRAPHITE_SOURCE,
                StemParameters { spring_n_per_m: 206_941.0, preload_n: 2_571.4, ..USP },
                FrictionLaw::Karnopp(Karnopp::new(
                    Classical::new(942.4, 665.4, 70_501.0, 3.258e-3)?,
                    0.0,
                )?),
            ),
            "usp-graphite-lugre" => (
                "29 mm stroke valve fitted to a real one, LuGre friction",
                GRAPHITE_SOURCE,
                StemParameters { spring_n_per_m: 206_916.0, preload_n: 2_572.1, ..USP },
                FrictionLaw::LuGre(LuGre::new(
                    Classical::new(942.1, 669.9, 70_481.0, 3.221e-3)?,
                    1.038e9,
                    2.4417e5,
                )?),
            ),
            _ => (
                "1 kg mass on a 2 N/m spring with the textbook LuGre friction; the force in N is \
                 the pressure in Pa",
                "friction: Canudas de Wit et al., IEEE TAC 40 (1995) 419-425; recalled, not \
                 verified; spring and stroke are this project's",
                StemParameters {
                    mass_kg: 1.0,
                    spring_n_per_m: 2.0,
                    area_m2: 1.0,
                    preload_n: 0.0,
                    stroke_m: 1.0,
                    pressure_min_pa: 0.0,
                    pressure_max_pa: 2.0,
                    air_lag_s: 0.0,
                    end_stops: false,
                },
                FrictionLaw::LuGre(LuGre::textbook()),
            ),
        };
        Ok(Self { name, summary, source, stem, friction })
    }
}
