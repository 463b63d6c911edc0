//! `modelDescription.xml`, written from the table.

use std::fmt::Write;

use crate::fmu::Fmu;
use crate::variables::{Causality, Variability, Variable, VariableKind};

/// A version of the Functional Mock-up Interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fmi {
    /// 2.0: co-simulation, and model exchange of stems.
    V2,
    /// 3.0: co-simulation.
    V3,
}

/// The name of the library, without the ending that its platform gives it.
pub(crate) const IDENTIFIER: &str = "stiction";

impl Fmi {
    /// The path inside the FMU of the library for a platform, given as Rust names it
    /// (`std::env::consts::ARCH` and `OS`), if FMI has a name for it.
    pub fn binary(self, arch: &str, os: &str) -> Option<String> {
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
        Some(format!("binaries/{platform}/{IDENTIFIER}.{ending}"))
    }
}

/// Units, the declared types that have them, and what they are in terms of SI: factor, and exponents of kg, m, s.
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
    /// The text of `modelDescription.xml`.
    pub fn xml(&self, version: Fmi) -> String {
        let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        // Writing to a string cannot fail.
        let _ = match version {
            Fmi::V2 => self.write_2(&mut xml),
            Fmi::V3 => self.write_3(&mut xml),
        };
        xml
    }

    fn title(&self) -> String {
        format!("stiction {} {}", self.model(), self.law())
    }

    fn summary(&self) -> String {
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

    /// How many numbers a solver from outside watches.
    fn indicators(&self) -> usize {
        if self.is_continuous() { stiction_model::stem::MovingStem::GUARDS } else { 0 }
    }

    fn write_2(&self, xml: &mut String) -> std::fmt::Result {
        writeln!(
            xml,
            "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{}\" guid=\"{}\" \
             description=\"{}\" author=\"The stiction developers\" version=\"{}\" \
             license=\"MIT OR Apache-2.0\" generationTool=\"stiction {}\" \
             variableNamingConvention=\"flat\" numberOfEventIndicators=\"{}\">",
            self.title(),
            self.token(),
            self.summary(),
            env!("CARGO_PKG_VERSION"),
            env!("CARGO_PKG_VERSION"),
            self.indicators()
        )?;
        let common = "canBeInstantiatedOnlyOncePerProcess=\"false\" \
                      canNotUseMemoryManagementFunctions=\"true\" canGetAndSetFMUstate=\"true\" \
                      canSerializeFMUstate=\"true\"";
        if self.is_continuous() {
            writeln!(
                xml,
                "  <ModelExchange modelIdentifier=\"{IDENTIFIER}\" \
                 completedIntegratorStepNotNeeded=\"true\" {common}/>"
            )?;
        }
        writeln!(
            xml,
            "  <CoSimulation modelIdentifier=\"{IDENTIFIER}\" \
             canHandleVariableCommunicationStepSize=\"true\" canInterpolateInputs=\"false\" \
             maxOutputDerivativeOrder=\"0\" canRunAsynchronuously=\"false\" {common}/>"
        )?;
        self.write_units(xml, Fmi::V2)?;
        writeln!(
            xml,
            "  <LogCategories>\n    <Category name=\"logStatusError\"/>\n  </LogCategories>"
        )?;
        self.write_experiment(xml)?;
        writeln!(xml, "  <ModelVariables>")?;
        for (reference, variable) in self.variables().iter().enumerate() {
            self.write_variable_2(xml, reference, variable)?;
        }
        writeln!(xml, "  </ModelVariables>\n  <ModelStructure>")?;
        let mut unknowns = |name: &str, indices: &[u32]| -> std::fmt::Result {
            if indices.is_empty() {
                return Ok(());
            }
            writeln!(xml, "    <{name}>")?;
            for index in indices {
                let on = self.variables()[*index as usize].depends_on;
                write!(xml, "      <Unknown index=\"{}\"", index + 1)?;
                if let Some(on) = on.filter(|_| name != "InitialUnknowns") {
                    // Only in model exchange are there states to depend on.
                    let states = if self.is_continuous() { on } else { &[] };
                    let on: Vec<_> = states.iter().map(|state| (state + 1).to_string()).collect();
                    write!(xml, " dependencies=\"{}\"", on.join(" "))?;
                }
                writeln!(xml, "/>")?;
            }
            writeln!(xml, "    </{name}>")
        };
        let outputs: Vec<u32> = self.outputs().collect();
        let states: Vec<(u32, u32)> =
            if self.is_continuous() { self.states().collect() } else { vec![] };
        let rates: Vec<u32> = states.iter().map(|(_, rate)| *rate).collect();
        let mut initial: Vec<u32> = outputs.iter().chain(&rates).copied().collect();
        initial.extend(states.iter().map(|(state, _)| *state));
        initial.sort_unstable();
        initial.dedup();
        unknowns("Outputs", &outputs)?;
        unknowns("Derivatives", &rates)?;
        unknowns("InitialUnknowns", &initial)?;
        writeln!(xml, "  </ModelStructure>\n</fmiModelDescription>")
    }

    fn write_variable_2(
        &self,
        xml: &mut String,
        reference: usize,
        v: &Variable,
    ) -> std::fmt::Result {
        let kind = match v.kind {
            VariableKind::Float64 => "Real",
            VariableKind::Int32 => "Integer",
            VariableKind::Boolean => "Boolean",
        };
        write!(
            xml,
            "    <ScalarVariable name=\"{}\" valueReference=\"{reference}\" description=\"{}\" \
             causality=\"{}\" variability=\"{}\"{}>\n      <{kind}",
            v.name,
            v.description,
            causality(v),
            variability(v),
            initial(v),
        )?;
        write_attributes(xml, v, Fmi::V2)?;
        if self.is_continuous() {
            if let Some(state) = v.rate_of {
                write!(xml, " derivative=\"{}\"", state + 1)?;
            }
            if self.states().any(|(state, _)| state as usize == reference) {
                write!(xml, " reinit=\"true\"")?;
            }
        }
        writeln!(xml, "/>\n    </ScalarVariable>")
    }

    fn write_3(&self, xml: &mut String) -> std::fmt::Result {
        writeln!(
            xml,
            "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{}\" instantiationToken=\"{}\" \
             description=\"{}\" author=\"The stiction developers\" version=\"{}\" \
             license=\"MIT OR Apache-2.0\" generationTool=\"stiction {}\" \
             variableNamingConvention=\"flat\">",
            self.title(),
            self.token(),
            self.summary(),
            env!("CARGO_PKG_VERSION"),
            env!("CARGO_PKG_VERSION"),
        )?;
        writeln!(
            xml,
            "  <CoSimulation modelIdentifier=\"{IDENTIFIER}\" \
             canHandleVariableCommunicationStepSize=\"true\" \
             canBeInstantiatedOnlyOncePerProcess=\"false\" canGetAndSetFMUState=\"true\" \
             canSerializeFMUState=\"true\"/>"
        )?;
        self.write_units(xml, Fmi::V3)?;
        writeln!(
            xml,
            "  <LogCategories>\n    <Category name=\"logStatusError\"/>\n  </LogCategories>"
        )?;
        self.write_experiment(xml)?;
        writeln!(xml, "  <ModelVariables>")?;
        for (reference, v) in self.variables().iter().enumerate() {
            let kind = match v.kind {
                VariableKind::Float64 => "Float64",
                VariableKind::Int32 => "Int32",
                VariableKind::Boolean => "Boolean",
            };
            write!(
                xml,
                "    <{kind} name=\"{}\" valueReference=\"{reference}\" description=\"{}\" \
                 causality=\"{}\" variability=\"{}\"{}",
                v.name,
                v.description,
                causality(v),
                variability(v),
                initial(v)
            )?;
            write_attributes(xml, v, Fmi::V3)?;
            writeln!(xml, "/>")?;
        }
        writeln!(xml, "  </ModelVariables>\n  <ModelStructure>")?;
        for reference in self.outputs() {
            // There are no states in co-simulation to depend on.
            let on = self.variables()[reference as usize].depends_on.map(|_| " dependencies=\"\"");
            writeln!(
                xml,
                "    <Output valueReference=\"{reference}\"{}/>",
                on.unwrap_or_default()
            )?;
        }
        for reference in self.outputs() {
            writeln!(xml, "    <InitialUnknown valueReference=\"{reference}\"/>")?;
        }
        writeln!(xml, "  </ModelStructure>\n</fmiModelDescription>")
    }

    /// Value references of the outputs.
    fn outputs(&self) -> impl Iterator<Item = u32> {
        let outputs = self.variables().iter().zip(0..);
        outputs.filter_map(|(v, reference)| (v.causality == Causality::Output).then_some(reference))
    }

    /// The units that its variables have, and a type for each.
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
        // The type has the unit already. Some importers of 2.0 look here only; a strict one of 3.0, fmi-rs, knows
        // no such attribute of a variable.
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
