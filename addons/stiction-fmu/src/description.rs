//! `modelDescription.xml`, written from the table.

use std::fmt::Write;

use crate::fmu::Fmu;
use crate::variables::{Causality, Variability, Variable, VariableKind};

/// A version of the Functional Mock-up Interface. Both offer co-simulation, and model exchange of stems.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fmi {
    /// 2.0.
    V2,
    /// 3.0.
    V3,
}

impl Fmi {
    /// The path inside an FMU of the library for a platform, without name.
    fn platform(self, arch: &str, os: &str) -> Option<(String, &'static str)> {
        let (system, ending) = match os {
            "linux" => ("linux", "so"),
            "windows" => ("windows", "dll"),
            "macos" => ("darwin", "dylib"),
            _ => return None,
        };
        let platform = match self {
            Self::V3 if matches!(arch, "x86" | "x86_64" | "aarch64") => format!("{arch}-{system}"),
            Self::V2 => {
                let bits = match arch {
                    "x86_64" => "64",
                    "x86" => "32",
                    _ => return None,
                };
                let system = match system {
                    "windows" => "win",
                    other => other,
                };
                format!("{system}{bits}")
            }
            Self::V3 => return None,
        };
        Some((format!("binaries/{platform}"), ending))
    }
}

/// Units, their declared types, and their SI definition: factor, and exponents of kg, m, s.
const UNITS: [(&str, &str, f64, [i32; 3]); 15] = [
    ("%", "Percent", 0.01, [0, 0, 0]),
    ("%/s", "PercentRate", 0.01, [0, 0, -1]),
    ("1", "Ratio", 1.0, [0, 0, 0]),
    ("s", "Time", 1.0, [0, 0, 1]),
    ("m", "Length", 1.0, [0, 1, 0]),
    ("m2", "Area", 1.0, [0, 2, 0]),
    ("m/s", "Velocity", 1.0, [0, 1, -1]),
    ("m/s2", "Acceleration", 1.0, [0, 1, -2]),
    ("kg", "Mass", 1.0, [1, 0, 0]),
    ("N", "Force", 1.0, [1, 1, -2]),
    ("N/m", "Stiffness", 1.0, [1, 0, -2]),
    ("N/s", "ForceRate", 1.0, [1, 1, -3]),
    ("Pa", "Pressure", 1.0, [1, -1, -2]),
    ("Pa/s", "PressureRate", 1.0, [1, -1, -3]),
    ("N.s/m", "Damping", 1.0, [1, 0, -1]),
];

impl Fmu {
    /// The name of the library in the FMU, without ending: a C identifier, such as `stiction_valve_two_phase`. It
    /// contains model and law, because some importers distinguish libraries by this name alone.
    pub fn identifier(&self) -> String {
        format!("stiction_{}_{}", self.model(), self.law()).replace('-', "_")
    }

    /// The path inside the FMU of the library for a platform, given as Rust names it
    /// (`std::env::consts::ARCH` and `OS`), if FMI has a name for it.
    pub fn binary(&self, version: Fmi, arch: &str, os: &str) -> Option<String> {
        let (directory, ending) = version.platform(arch, os)?;
        Some(format!("{directory}/{}.{ending}", self.identifier()))
    }

    /// The text of `modelDescription.xml`, with `generated_s` in seconds after the beginning of 1970 in UTC, if it
    /// is given.
    pub fn xml(&self, version: Fmi, generated_s: Option<u64>) -> String {
        let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        // Writing to a string cannot fail.
        let _ = match version {
            Fmi::V2 => self.write_2(&mut xml, generated_s),
            Fmi::V3 => self.write_3(&mut xml, generated_s),
        };
        xml
    }

    /// Name in one line.
    pub fn title(&self) -> String {
        format!("stiction {} {}", self.model(), self.law())
    }

    /// Description in one line.
    pub fn summary(&self) -> String {
        let what = match self.model() {
            "valve" => "Sticking control valve, data-driven model",
            "stem" => "Stem of a control valve with friction",
            _ => "Control loop with a sticking valve, model",
        };
        format!("{what} {}", self.law())
    }

    /// States with the value references of their rates.
    fn states(&self) -> impl Iterator<Item = (u32, u32)> {
        let rates = self.variables().iter().zip(0..);
        rates.filter_map(|(v, rate)| v.rate_of.map(|state| (state, rate)))
    }

    /// Variables for an external solver to watch: value references.
    fn indicators(&self) -> impl Iterator<Item = u32> {
        let all = self.variables().iter().zip(0..);
        all.filter_map(|(v, reference)| v.indicates.then_some(reference))
    }

    /// Attributes of both versions about the origin of the FMU.
    fn write_origin(&self, xml: &mut String, generated_s: Option<u64>) -> std::fmt::Result {
        const VERSION: &str = env!("CARGO_PKG_VERSION");
        write!(
            xml,
            " description=\"{}\" author=\"The stiction developers\" version=\"{VERSION}\" \
             copyright=\"The stiction developers\" license=\"MIT OR Apache-2.0\" \
             generationTool=\"stiction {VERSION}\" variableNamingConvention=\"flat\"",
            self.summary(),
        )?;
        generated_s.map_or(Ok(()), |seconds| {
            write!(xml, " generationDateAndTime=\"{}\"", date_and_time(seconds))
        })
    }

    fn write_2(&self, xml: &mut String, generated_s: Option<u64>) -> std::fmt::Result {
        write!(
            xml,
            "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{}\" guid=\"{}\"",
            self.title(),
            self.token(),
        )?;
        self.write_origin(xml, generated_s)?;
        writeln!(xml, " numberOfEventIndicators=\"{}\">", self.indicators().count())?;
        let identifier = self.identifier();
        let common = "canBeInstantiatedOnlyOncePerProcess=\"false\" \
                      canNotUseMemoryManagementFunctions=\"true\" canGetAndSetFMUstate=\"true\" \
                      canSerializeFMUstate=\"true\"";
        if self.is_continuous() {
            writeln!(
                xml,
                "  <ModelExchange modelIdentifier=\"{identifier}\" \
                 completedIntegratorStepNotNeeded=\"true\" {common}/>"
            )?;
        }
        writeln!(
            xml,
            "  <CoSimulation modelIdentifier=\"{identifier}\" \
             canHandleVariableCommunicationStepSize=\"true\" canInterpolateInputs=\"false\" \
             maxOutputDerivativeOrder=\"0\" canRunAsynchronuously=\"false\" {common}/>"
        )?;
        self.write_variables(xml, Fmi::V2)?;
        let mut unknowns = |name: &str, indices: &[u32]| -> std::fmt::Result {
            if indices.is_empty() {
                return Ok(());
            }
            writeln!(xml, "    <{name}>")?;
            for index in indices {
                let on = match name {
                    "InitialUnknowns" => String::new(),
                    _ => self.dependencies(*index, 1),
                };
                writeln!(xml, "      <Unknown index=\"{}\"{on}/>", index + 1)?;
            }
            writeln!(xml, "    </{name}>")
        };
        let outputs: Vec<u32> = self.outputs().collect();
        unknowns("Outputs", &outputs)?;
        unknowns("Derivatives", &self.rates())?;
        unknowns("InitialUnknowns", &self.initial_unknowns())?;
        writeln!(xml, "  </ModelStructure>\n</fmiModelDescription>")
    }

    /// From the units to the last variable.
    fn write_variables(&self, xml: &mut String, version: Fmi) -> std::fmt::Result {
        self.write_units(xml, version)?;
        writeln!(
            xml,
            "  <LogCategories>\n    <Category name=\"logStatusError\"/>\n  </LogCategories>"
        )?;
        self.write_experiment(xml)?;
        writeln!(xml, "  <ModelVariables>")?;
        for (reference, variable) in self.variables().iter().enumerate() {
            self.write_variable(xml, reference, variable, version)?;
        }
        writeln!(xml, "  </ModelVariables>\n  <ModelStructure>")
    }

    fn write_variable(
        &self,
        xml: &mut String,
        reference: usize,
        v: &Variable,
        version: Fmi,
    ) -> std::fmt::Result {
        let kind = match (v.kind, version) {
            (VariableKind::Float64, Fmi::V2) => "Real",
            (VariableKind::Int32, Fmi::V2) => "Integer",
            (VariableKind::Float64, Fmi::V3) => "Float64",
            (VariableKind::Int32, Fmi::V3) => "Int32",
            (VariableKind::Boolean, _) => "Boolean",
        };
        // Before version 3 a variable is an element around that of its type, and counted from 1.
        let (element, inner, end, first) = match version {
            Fmi::V2 => {
                ("ScalarVariable", format!(">\n      <{kind}"), "\n    </ScalarVariable>", 1)
            }
            Fmi::V3 => (kind, String::new(), "", 0),
        };
        write!(
            xml,
            "    <{element} name=\"{}\" valueReference=\"{reference}\" description=\"{}\" \
             causality=\"{}\" variability=\"{}\"{}{inner}",
            v.name,
            v.description,
            causality(v),
            variability(v),
            initial(v),
        )?;
        write_attributes(xml, v, version)?;
        if self.is_continuous() {
            if let Some(state) = v.rate_of {
                write!(xml, " derivative=\"{}\"", state + first)?;
            }
            if self.states().any(|(state, _)| state as usize == reference) {
                write!(xml, " reinit=\"true\"")?;
            }
        }
        writeln!(xml, "/>{end}")
    }

    /// The states that a variable depends on, counted from `first`, as an attribute, if the variable declares them.
    fn dependencies(&self, reference: u32, first: u32) -> String {
        let Some(on) = self.variables()[reference as usize].depends_on else {
            return String::new();
        };
        // Only in model exchange are there states to depend on.
        let states = if self.is_continuous() { on } else { &[] };
        let on: Vec<_> = states.iter().map(|state| (state + first).to_string()).collect();
        format!(" dependencies=\"{}\"", on.join(" "))
    }

    /// The value references of the states' rates, in the order of the states.
    fn rates(&self) -> Vec<u32> {
        if self.is_continuous() { self.states().map(|(_, rate)| rate).collect() } else { vec![] }
    }

    /// Unknowns at the start: outputs, states and their rates.
    fn initial_unknowns(&self) -> Vec<u32> {
        let mut initial: Vec<u32> = self.outputs().chain(self.rates()).collect();
        if self.is_continuous() {
            initial.extend(self.states().map(|(state, _)| state));
        }
        initial.sort_unstable();
        initial.dedup();
        initial
    }

    fn write_3(&self, xml: &mut String, generated_s: Option<u64>) -> std::fmt::Result {
        write!(
            xml,
            "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{}\" instantiationToken=\"{}\"",
            self.title(),
            self.token(),
        )?;
        self.write_origin(xml, generated_s)?;
        writeln!(xml, ">")?;
        let identifier = self.identifier();
        let common = "canBeInstantiatedOnlyOncePerProcess=\"false\" \
                      canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"";
        if self.is_continuous() {
            writeln!(
                xml,
                "  <ModelExchange modelIdentifier=\"{identifier}\" \
                 needsCompletedIntegratorStep=\"false\" {common}/>"
            )?;
        }
        writeln!(
            xml,
            "  <CoSimulation modelIdentifier=\"{identifier}\" \
             canHandleVariableCommunicationStepSize=\"true\" {common}/>"
        )?;
        self.write_variables(xml, Fmi::V3)?;
        let outputs: Vec<u32> = self.outputs().collect();
        for (name, references) in
            [("Output", &outputs), ("ContinuousStateDerivative", &self.rates())]
        {
            for reference in references {
                let on = self.dependencies(*reference, 0);
                writeln!(xml, "    <{name} valueReference=\"{reference}\"{on}/>")?;
            }
        }
        for reference in self.initial_unknowns() {
            writeln!(xml, "    <InitialUnknown valueReference=\"{reference}\"/>")?;
        }
        for reference in self.indicators() {
            writeln!(xml, "    <EventIndicator valueReference=\"{reference}\"/>")?;
        }
        writeln!(xml, "  </ModelStructure>\n</fmiModelDescription>")
    }

    /// Value references of the outputs.
    fn outputs(&self) -> impl Iterator<Item = u32> {
        let outputs = self.variables().iter().zip(0..);
        outputs.filter_map(|(v, reference)| (v.causality == Causality::Output).then_some(reference))
    }

    /// The units of its variables, and a type for each.
    fn write_units(&self, xml: &mut String, version: Fmi) -> std::fmt::Result {
        let used =
            || UNITS.iter().filter(|(unit, ..)| self.variables().iter().any(|v| v.unit == *unit));
        writeln!(xml, "  <UnitDefinitions>")?;
        for (name, _, factor, exponents) in used() {
            write!(xml, "    <Unit name=\"{name}\">\n      <BaseUnit")?;
            for (base, exponent) in ["kg", "m", "s"].into_iter().zip(exponents) {
                if *exponent != 0 {
                    write!(xml, " {base}=\"{exponent}\"")?;
                }
            }
            if *factor != 1.0 {
                write!(xml, " factor=\"{factor}\"")?;
            }
            writeln!(xml, "/>\n    </Unit>")?;
        }
        writeln!(xml, "  </UnitDefinitions>\n  <TypeDefinitions>")?;
        for (unit, name, ..) in used() {
            match version {
                Fmi::V2 => writeln!(
                    xml,
                    "    <SimpleType name=\"{name}\">\n      <Real unit=\"{unit}\"/>\n    </SimpleType>"
                )?,
                Fmi::V3 => writeln!(xml, "    <Float64Type name=\"{name}\" unit=\"{unit}\"/>")?,
            }
        }
        writeln!(xml, "  </TypeDefinitions>")
    }

    /// A hundred seconds in steps of a tenth, or of the loop's own sample time.
    fn write_experiment(&self, xml: &mut String) -> std::fmt::Result {
        let own = self.variables().iter().find(|v| v.name == "sample_time").and_then(|v| v.start);
        let step = own.filter(|step| *step > 0.0).unwrap_or(0.1);
        writeln!(
            xml,
            "  <DefaultExperiment startTime=\"0\" stopTime=\"{}\" stepSize=\"{step}\"/>",
            1000.0 * step
        )
    }
}

/// A time in the form of XML, in UTC. The calendar is the Gregorian one, its years counted from March, so that a
/// leap day is the last day of a year.
fn date_and_time(seconds: u64) -> String {
    const DAY: u64 = 86_400;
    /// Days from 1 March of the year 0 to the beginning of 1970, and days in 400 years.
    const TO_1970: u64 = 719_468;
    const ERA: u64 = 146_097;
    let (days, rest) = (seconds / DAY + TO_1970, seconds % DAY);
    let (era, day) = (days / ERA, days % ERA);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (year, month) = (400 * era + year + month / 10, (month + 2) % 12 + 1);
    let (hour, minute, second) = (rest / 3_600, rest / 60 % 60, rest % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

fn causality(v: &Variable) -> &'static str {
    match v.causality {
        Causality::Independent => "independent",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Parameter => "parameter",
        Causality::Local => "local",
    }
}

fn variability(v: &Variable) -> &'static str {
    match v.variability {
        Variability::Continuous => "continuous",
        Variability::Discrete => "discrete",
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
    }
}

fn initial(v: &Variable) -> &'static str {
    match v.causality {
        Causality::Parameter => " initial=\"exact\"",
        Causality::Output | Causality::Local => " initial=\"calculated\"",
        Causality::Independent | Causality::Input => "",
    }
}

fn write_attributes(xml: &mut String, v: &Variable, version: Fmi) -> std::fmt::Result {
    let declared =
        UNITS.iter().find(|(unit, ..)| v.kind == VariableKind::Float64 && *unit == v.unit);
    if let Some((unit, name, ..)) = declared {
        write!(xml, " declaredType=\"{name}\"")?;
        // The type already has the unit. Some importers of 2.0 use only this attribute; fmi-rs, a strict importer
        // of 3.0, rejects it.
        if version == Fmi::V2 {
            write!(xml, " unit=\"{unit}\"")?;
        }
    }
    match (v.start, v.kind) {
        (None, _) => Ok(()),
        (Some(start), VariableKind::Boolean) => write!(xml, " start=\"{}\"", start != 0.0),
        (Some(start), _) => write!(xml, " start=\"{start}\""),
    }
}

#[cfg(test)]
mod tests {
    use super::date_and_time;

    /// Against `date --utc --date=@SECONDS`.
    #[test]
    fn moments_are_dates() {
        for (seconds, date) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_767_225_599, "2025-12-31T23:59:59Z"),
            (1_772_323_200, "2026-03-01T00:00:00Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(date_and_time(seconds), date);
        }
    }
}
