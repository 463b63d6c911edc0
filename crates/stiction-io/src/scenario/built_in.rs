//! The built-in scenarios.

macro_rules! built_in {
    ($($name:literal),+ $(,)?) => {
        /// Name and TOML text of every built-in scenario.
        pub const SCENARIOS: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../scenarios/", $name, ".toml")))),+];
    };
}

built_in!(
    "paper/open-loop-linear",
    "paper/open-loop-deadband",
    "paper/open-loop-stiction",
    "paper/open-loop-high",
    "paper/step-linear",
    "paper/step-stiction",
    "paper/closed-loop",
    "paper/flow-cascade",
    "choudhury/concentration",
    "choudhury/level",
    "samples/sticky-flow",
    "samples/disturbed-flow",
    "samples/aggressive-flow",
    "samples/quantised-level",
    "samples/cascade-slave",
    "lab/flow",
    "lab/level",
    "lab/temperature",
);
