//! Any text is a scenario or an error; a scenario that was read is one that runs.
#![no_main]

use libfuzzer_sys::fuzz_target;
use stiction_io::Scenario;
use stiction_io::scenario::System;

/// Longer runs only cost executions.
const MAX_SAMPLES: usize = 2_000;

fuzz_target!(|text: &str| {
    let Ok(scenario) = Scenario::parse(text, "fuzz.toml", None) else { return };
    scenario.settings();
    match &scenario.system {
        System::OpenLoop(system) if system.samples <= MAX_SAMPLES => {
            // A signal may still overflow, which only its samples tell.
            let _ = system.run();
        }
        System::ClosedLoop(system) if system.samples <= MAX_SAMPLES => {
            let run = system.run().expect("a checked loop runs");
            let _ = (run.period_s(), run.growth());
        }
        System::Cascade(system) if system.slave.samples <= MAX_SAMPLES => {
            system.run().expect("a checked cascade runs");
        }
        _ => {}
    }
});
