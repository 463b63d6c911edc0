//! The physical stem: integrated over a step with the OP held, or by an external solver.

use stiction_model::stem::friction::{Armstrong, Dahl, LAWS};
use stiction_model::stem::{
    FrictionLaw, MovingStem, ParameterSet, SETS, Stem, StemParameters, StemStart,
};

use crate::model::{Continuous, FmuModel, Result, count};
use crate::variables::{MOVES, Numbers, Variable};

/// Value references.
const OP: usize = 1;
const SUPPLY: usize = 2;
const VP: usize = 3;
const MOVED: std::ops::Range<usize> = 4..6;
const POSITION: usize = 6;
const VELOCITY: usize = 7;
const FRICTION: usize = 8;
const PRESSURE: usize = 9;
const PARAMETERS: usize = 10;
const PRESSURE_MAX: usize = PARAMETERS + 6;
const AIR_LAG: usize = PARAMETERS + 7;
const TOLERANCE: usize = PARAMETERS + 9;
const RELAXED: usize = TOLERANCE + 1;
const VP_START: usize = TOLERANCE + 2;
/// The parameters of the friction law, followed by the rates.
const LAW: usize = TOLERANCE + 3;

/// Initial friction law: from a parameter set with that law, or else close to one.
pub(crate) fn preset(name: &str) -> Option<Result<(StemParameters, FrictionLaw)>> {
    let set = match name {
        "classical" => "cts",
        "karnopp" => "usp-graphite-karnopp",
        "lugre" => "usp-lugre",
        "gms" => "usp-gms",
        // The stem of the set usp; stiffness, memory and rise are this project's choice.
        "dahl" | "armstrong" => "usp",
        set => *SETS.iter().find(|known| **known == set)?,
    };
    let preset = || {
        let set = ParameterSet::named(set)?;
        let friction = match name {
            "dahl" => FrictionLaw::Dahl(Dahl::new(700.0, 2.6e7, 125_000.0)?),
            "armstrong" => FrictionLaw::Armstrong(
                Armstrong {
                    presliding_n_per_m: 2.6e7,
                    coulomb_n: 700.0,
                    viscous_n_s_per_m: 125_000.0,
                    static_excess_n: 80.0,
                    stribeck_m_per_s: 5e-4,
                    memory_s: 0.01,
                    rise_s: 1.0,
                }
                .checked()?,
            ),
            _ => set.friction,
        };
        Ok((set.stem, friction))
    };
    Some(preset().map_err(|e: stiction_model::Error| e.to_string()))
}

/// Unit and meaning of a friction parameter.
fn friction_parameter(name: &str) -> (&'static str, &'static str) {
    match name {
        "static_n" => ("N", "Static friction"),
        "coulomb_n" => ("N", "Coulomb friction"),
        "viscous_n_s_per_m" => ("N.s/m", "Viscous friction"),
        "stribeck_m_per_s" => ("m/s", "Stribeck velocity"),
        "band_m_per_s" => ("m/s", "Half width of the band of velocities that count as zero"),
        "stiffness_n_per_m" => ("N/m", "Stiffness of the bristles"),
        "damping_n_s_per_m" => ("N.s/m", "Damping of the bristles"),
        "attraction_n_per_s" => ("N/s", "Rate at which a slipping element nears the steady level"),
        "stiffness_1_n_per_m" => ("N/m", "Stiffness of the first element"),
        "stiffness_2_n_per_m" => ("N/m", "Stiffness of the second element"),
        "stiffness_3_n_per_m" => ("N/m", "Stiffness of the third element"),
        "damping_1_n_s_per_m" => ("N.s/m", "Damping of the first element"),
        "damping_2_n_s_per_m" => ("N.s/m", "Damping of the second element"),
        "damping_3_n_s_per_m" => ("N.s/m", "Damping of the third element"),
        "share_1" => ("1", "Share of the first element in the steady friction"),
        "share_2" => ("1", "Share of the second element in the steady friction"),
        "share_3" => ("1", "Share of the third element in the steady friction"),
        "presliding_n_per_m" => ("N/m", "Presliding stiffness"),
        "static_excess_n" => ("N", "Static less Coulomb friction after a long rest"),
        "memory_s" => ("s", "Frictional memory"),
        "rise_s" => ("s", "Rise time of static friction"),
        _ => ("", "Friction parameter"),
    }
}

/// The deflections that are states of a law.
fn deflections(law: &str) -> &'static [(&'static str, &'static str)] {
    match law {
        "dahl" | "lugre" => &[("z", "der(z)")],
        "gms" => &[("z1", "der(z1)"), ("z2", "der(z2)"), ("z3", "der(z3)")],
        _ => &[],
    }
}

/// Whether an external solver can compute a stem with this law.
pub(crate) fn is_continuous(law: &str) -> bool {
    law != "armstrong"
}

/// The table of a stem.
pub(crate) fn variables(stem: &StemParameters, law: &FrictionLaw) -> Vec<Variable> {
    let p = Variable::parameter;
    let rate = "Rate of change of the position";
    let mut table = vec![
        Variable::TIME,
        Variable::input("OP", "%", 50.0, "Controller output"),
        // A parameter, because an importer may leave an unconnected input at 0.
        p(
            "supply",
            "Pa",
            enough_pa(stem.pressure_max_pa),
            "Pressure of the air supply, which limits the demanded pressure",
        )
        .tunable(),
        Variable::output("VP", "%", "Valve position").depends_on(&[POSITION as u32]),
    ];
    table.extend(MOVES);
    table.extend([
        Variable::output("position", "m", "Position of the stem, 0 closed")
            .depends_on(&[POSITION as u32]),
        Variable::output("velocity", "m/s", "Velocity of the stem").depends_on(&[VELOCITY as u32]),
        Variable::output("friction", "N", "Friction force, positive if it opposes upward motion"),
        Variable::output("pressure", "Pa", "Acting air pressure"),
        p("mass_kg", "kg", stem.mass_kg, "Mass of the moving parts"),
        p("spring_n_per_m", "N/m", stem.spring_n_per_m, "Spring constant"),
        p("area_m2", "m2", stem.area_m2, "Diaphragm area"),
        p("preload_n", "N", stem.preload_n, "Force of the spring at position 0"),
        p("stroke_m", "m", stem.stroke_m, "Travel from closed to open"),
        p("pressure_min_pa", "Pa", stem.pressure_min_pa, "Air pressure at 0 % OP"),
        p("pressure_max_pa", "Pa", stem.pressure_max_pa, "Air pressure at 100 % OP"),
        p("air_lag_s", "s", stem.air_lag_s, "Lag between demanded and acting pressure; 0 for none"),
        p(
            "end_stops",
            "",
            f64::from(u8::from(stem.end_stops)),
            "Whether the stem is stopped at 0 and at the full stroke",
        )
        .boolean(),
        p(
            "tolerance",
            "1",
            Stem::DEFAULT_TOLERANCE,
            "Relative tolerance of the built-in integrator",
        ),
        p("relaxed", "", 0.0, "Whether bristles start relaxed instead of carrying the net force")
            .boolean(),
        p("VP_start", "%", 50.0, "Valve position at the start"),
    ]);
    for (name, value) in law.values() {
        let (unit, description) = friction_parameter(name);
        table.push(p(name, unit, value, description));
    }
    table.push(
        Variable::local("der(position)", "m/s", rate)
            .rate_of(POSITION)
            .depends_on(&[VELOCITY as u32]),
    );
    table.push(
        Variable::local("der(velocity)", "m/s2", "Rate of change of the velocity")
            .rate_of(VELOCITY),
    );
    for (name, of) in deflections(law.name()) {
        let state = table.len();
        table.push(Variable::local(name, "m", "Deflection of bristles"));
        table.push(Variable::local(of, "m/s", "Rate of change of the deflection").rate_of(state));
    }
    table.push(Variable::local(PRESSURE_RATE, "Pa/s", "Rate of change of the acting pressure"));
    if is_continuous(law.name()) {
        table.extend(INDICATORS.map(|name| {
            Variable::local(name, "", "A change of sign is an event in model exchange").indicator()
        }));
    }
    mark_pressure(&mut table);
    table
}

const PRESSURE_RATE: &str = "der(pressure)";

/// The names of the event indicators.
const INDICATORS: [&str; MovingStem::GUARDS] =
    ["event_1", "event_2", "event_3", "event_4", "event_5", "event_6"];

/// Makes the acting pressure a state if there is a lag, and only then.
fn mark_pressure(table: &mut [Variable]) {
    let lags = table[AIR_LAG].start.is_some_and(|lag| lag > 0.0);
    if let Some(rate) = table.iter_mut().find(|v| v.name == PRESSURE_RATE) {
        rate.rate_of = lags.then_some(PRESSURE as u32);
    }
}

/// Default supply pressure, which drives the valve fully open: a tenth above the pressure at 100 % OP, Pa.
fn enough_pa(pressure_max_pa: f64) -> f64 {
    pressure_max_pa + pressure_max_pa.abs() / 10.0
}

/// Settings that `before` changes by its start value: whether the pressure is a state, and a supply that was just
/// sufficient.
pub(crate) fn adapt(table: &mut [Variable], name: &str, before: Option<f64>) {
    mark_pressure(table);
    if name == table[PRESSURE_MAX].name && table[SUPPLY].start == before.map(enough_pa) {
        table[SUPPLY].start = table[PRESSURE_MAX].start.map(enough_pa);
    }
}

#[derive(Debug, Clone)]
pub(crate) struct StemModel {
    law: &'static str,
    /// Number of parameters of the law.
    count: usize,
    moving: Option<MovingStem>,
    parameters: StemParameters,
}

impl StemModel {
    pub(crate) fn new(parameters: StemParameters, law: &FrictionLaw) -> Self {
        Self { law: law.name(), count: law.values().len(), moving: None, parameters }
    }

    fn demand_pa(&self, values: &Numbers) -> f64 {
        self.parameters.supplied_pa(values[OP], values[SUPPLY])
    }

    /// Writes the outputs.
    fn show(&self, values: &mut Numbers) {
        let Some(moving) = &self.moving else { return };
        let now = moving.sample();
        values[VP] = self.parameters.percent(now.position_m);
        values[MOVED.start] = f64::from(u8::from(moving.is_stuck()));
        values[POSITION] = now.position_m;
        values[VELOCITY] = now.velocity_m_per_s;
        values[FRICTION] = now.friction_n;
        values[PRESSURE] = now.pressure_pa;
        let rates = moving.rates(self.demand_pa(values));
        let states = moving.states().unwrap_or_default();
        let locals = LAW + self.count;
        let lags = self.parameters.air_lag_s > 0.0;
        if is_continuous(self.law) {
            let indicators = locals + 3 + 2 * deflections(self.law).len();
            values[indicators..][..MovingStem::GUARDS].copy_from_slice(&self.indicators());
        }
        if let [_, acceleration, ..] = rates[..] {
            values[locals] = rates[0];
            values[locals + 1] = acceleration;
            let deflections = rates.len() - 2 - usize::from(lags);
            for i in 0..deflections {
                values[locals + 2 + 2 * i] = states[2 + i];
                values[locals + 3 + 2 * i] = rates[2 + i];
            }
            if let (true, Some(rate)) = (lags, rates.last()) {
                values[locals + 2 + 2 * deflections] = *rate;
            }
        } else {
            values[locals] = now.velocity_m_per_s;
            let net_n = self.parameters.net_force_n(now.pressure_pa, now.position_m);
            let moves = f64::from(u8::from(!moving.is_stuck()));
            values[locals + 1] = moves * (net_n - now.friction_n) / self.parameters.mass_kg;
        }
    }

    /// Counts the events since the last step.
    fn count_slips(&self, values: &mut Numbers) {
        let Some(moving) = &self.moving else { return };
        for _ in 0..moving.slips() {
            count(&mut values[MOVED]);
        }
    }
}

impl FmuModel for StemModel {
    fn restart(&mut self, values: &mut Numbers, time: f64) -> Result<()> {
        let of_stem = *values[PARAMETERS..].first_chunk::<9>().expect("the table has them");
        let parameters = StemParameters::from_values(of_stem);
        let begin = || {
            let friction = FrictionLaw::from_name(self.law, &values[LAW..LAW + self.count])?;
            let stem = Stem::new(parameters, friction)?.with_tolerance(values[TOLERANCE])?;
            let pressure_pa = parameters.supplied_pa(values[OP], values[SUPPLY]);
            let start = StemStart {
                relaxed: values[RELAXED] != 0.0,
                ..StemStart::at_rest(parameters.position_m(values[VP_START]))
            };
            MovingStem::new(&stem, start, pressure_pa, time)
        };
        self.moving = Some(begin().map_err(|e| e.to_string())?);
        self.parameters = parameters;
        values[MOVED].copy_from_slice(&[1.0, 0.0]);
        self.show(values);
        Ok(())
    }

    fn tune(&mut self, _values: &Numbers) -> Result<()> {
        Ok(())
    }

    fn step(&mut self, values: &mut Numbers, time: f64, step: f64) -> Result<()> {
        let demand_pa = self.demand_pa(values);
        let Some(moving) = &mut self.moving else { return Ok(()) };
        moving.hold(demand_pa, time + step).map_err(|e| e.to_string())?;
        if !moving.sample().position_m.is_finite() {
            return Err(format!("with OP = {} the VP is too large to compute", values[OP]));
        }
        self.count_slips(values);
        self.show(values);
        Ok(())
    }

    fn memory(&self) -> Vec<f64> {
        self.moving.iter().flat_map(MovingStem::memory).collect()
    }

    fn recall(&mut self, _values: &Numbers, memory: &[f64]) -> Result<()> {
        let Some(moving) = &mut self.moving else {
            return Err("this is not the state of a stem".to_owned());
        };
        moving.recall(memory).map_err(|e| e.to_string())
    }

    fn continuous(&mut self) -> Option<&mut dyn Continuous> {
        is_continuous(self.law).then_some(self)
    }

    fn copy(&self) -> Box<dyn FmuModel> {
        Box::new(self.clone())
    }
}

impl Continuous for StemModel {
    fn states(&self) -> Vec<f64> {
        self.moving.as_ref().and_then(MovingStem::states).unwrap_or_default()
    }

    /// A solver keeps the error of a state below its tolerance times the nominal. The relevant state is the position.
    /// The other nominals are errors with the same effect on the position.
    ///
    /// * Velocity: an error lasts for a step of the solver. With a nominal as small as the velocity of a slide (a
    ///   stroke in seconds), a solver resolves how a light and strongly damped stem approaches its speed. This takes
    ///   microseconds after every change of the input. CVode then takes steps of a tenth of a millisecond, and gives
    ///   up.
    /// * Deflection of bristles: it shifts the position like a force of their stiffness on the spring.
    fn nominals(&self, values: &Numbers) -> Vec<f64> {
        /// Step of a solver during a slide, s: this project's choice.
        const STEP_S: f64 = 0.02;
        let stem = &self.parameters;
        let entry = LAWS.iter().find(|entry| entry.name == self.law);
        let parameters = entry.map_or(&[][..], |entry| entry.parameters);
        let stiffnesses = parameters
            .iter()
            .zip(&values[LAW..])
            .filter(|(name, _)| name.starts_with("stiffness_"));
        let mut nominals = vec![stem.stroke_m, stem.stroke_m / STEP_S];
        nominals.extend(
            stiffnesses.map(|(_, stiffness)| stem.stroke_m * stem.spring_n_per_m / stiffness),
        );
        if stem.air_lag_s > 0.0 {
            nominals.push(stem.pressure_max_pa - stem.pressure_min_pa);
        }
        nominals
    }

    fn place(&mut self, values: &mut Numbers, time: f64, states: Option<&[f64]>) {
        let demand_pa = self.demand_pa(values);
        let Some(moving) = &mut self.moving else { return };
        moving.place(time, demand_pa, states.unwrap_or_default());
        self.show(values);
    }

    fn rates(&self, values: &Numbers) -> Vec<f64> {
        let demand_pa = self.demand_pa(values);
        self.moving.as_ref().map(|moving| moving.rates(demand_pa)).unwrap_or_default()
    }

    fn indicators(&self) -> Vec<f64> {
        let guards = self.moving.as_ref().map_or([1.0; MovingStem::GUARDS], MovingStem::guards);
        guards.map(|guard| if guard.is_finite() { guard } else { 1.0 }).to_vec()
    }

    fn pass_events(&mut self, values: &mut Numbers) -> Result<bool> {
        let Some(moving) = &mut self.moving else { return Ok(false) };
        let passed = moving.pass_events().map_err(|e| e.to_string())?;
        self.count_slips(values);
        self.show(values);
        Ok(passed)
    }
}
