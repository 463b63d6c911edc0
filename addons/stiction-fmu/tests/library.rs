//! The library's file: loaded as an importer loads it, on whatever system it is for.

use crate::common;
#[path = "common/library.rs"]
mod loaded;

use common::{Unpacked, wandering};
use loaded::{Importer, Library, Three, Two};
use stiction_fmu::{Fmu, models};

/// All functions of the standards, without their prefix.
const FMI_2: &str = "
    CancelStep CompletedIntegratorStep DeSerializeFMUstate DoStep EnterContinuousTimeMode EnterEventMode
    EnterInitializationMode ExitInitializationMode FreeFMUstate FreeInstance GetBoolean GetBooleanStatus
    GetContinuousStates GetDerivatives GetDirectionalDerivative GetEventIndicators GetFMUstate
    GetInteger GetIntegerStatus GetNominalsOfContinuousStates GetReal GetRealOutputDerivatives
    GetRealStatus GetStatus GetString GetStringStatus GetTypesPlatform GetVersion Instantiate
    NewDiscreteStates Reset SerializeFMUstate SerializedFMUstateSize SetBoolean SetContinuousStates
    SetDebugLogging SetFMUstate SetInteger SetReal SetRealInputDerivatives SetString SetTime
    SetupExperiment Terminate
";
const FMI_3: &str = "
    ActivateModelPartition CompletedIntegratorStep DeserializeFMUState DoStep EnterConfigurationMode
    EnterContinuousTimeMode EnterEventMode EnterInitializationMode EnterStepMode EvaluateDiscreteStates
    ExitConfigurationMode ExitInitializationMode FreeFMUState FreeInstance GetAdjointDerivative
    GetBinary GetBoolean GetClock GetContinuousStateDerivatives GetContinuousStates
    GetDirectionalDerivative GetEventIndicators GetFMUState GetFloat32 GetFloat64 GetInt16 GetInt32
    GetInt64 GetInt8 GetIntervalDecimal GetIntervalFraction GetNominalsOfContinuousStates
    GetNumberOfContinuousStates GetNumberOfEventIndicators GetNumberOfVariableDependencies
    GetOutputDerivatives GetShiftDecimal GetShiftFraction GetString GetUInt16 GetUInt32 GetUInt64
    GetUInt8 GetVariableDependencies GetVersion InstantiateCoSimulation InstantiateModelExchange
    InstantiateScheduledExecution Reset SerializeFMUState SerializedFMUStateSize SetBinary SetBoolean
    SetClock SetContinuousStates SetDebugLogging SetFMUState SetFloat32 SetFloat64 SetInt16 SetInt32
    SetInt64 SetInt8 SetIntervalDecimal SetIntervalFraction SetShiftDecimal SetShiftFraction SetString
    SetTime SetUInt16 SetUInt32 SetUInt64 SetUInt8 Terminate UpdateDiscreteStates
";

#[test]
fn every_function_is_there() {
    let library = Library::own();
    for (prefix, names) in [("fmi2", FMI_2), ("fmi3", FMI_3)] {
        for name in names.split_whitespace() {
            assert!(library.has(&format!("{prefix}{name}")), "{prefix}{name}");
        }
    }
    assert_eq!(library.text("fmi2GetVersion"), "2.0");
    assert_eq!(library.text("fmi2GetTypesPlatform"), "default");
    assert_eq!(library.text("fmi3GetVersion"), "3.0");
}

/// FNV-1a of the bits.
fn hash(values: &[f64]) -> u64 {
    values
        .iter()
        .flat_map(|value| value.to_bits().to_le_bytes())
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        })
}

fn followed(importer: &impl Importer, fmu: &Fmu, op: &[f64]) -> Vec<f64> {
    let unpacked = Unpacked::new(fmu);
    let instance = importer.start(&unpacked.directory, &fmu.token());
    let step = |(k, op): (usize, &f64)| importer.step(instance, 0.5 * k as f64, 0.5, *op);
    let vp = op.iter().enumerate().map(step).collect();
    importer.free(instance);
    vp
}

/// The bits of the VP are the same on all systems: no valve without a lag calls more than arithmetic.
#[test]
fn every_valve_gives_the_same_bits_on_every_system() {
    let library = Library::own();
    let op = wandering(2_000, 8);
    let mut all = vec![];
    for entry in models().into_iter().filter(|entry| entry.model == "valve") {
        let fmu = Fmu::new("valve", entry.law).unwrap();
        let fmu = [("VP_start", 0.0), ("S", 4.0), ("limited", 1.0), ("low", 46.0), ("high", 54.0)]
            .into_iter()
            .fold(fmu, |fmu, (name, value)| fmu.with(name, value).unwrap());
        let vp = followed(&Two::of(&library), &fmu, &op);
        assert_eq!(vp, followed(&Three::of(&library), &fmu, &op), "{}", entry.law);
        all.extend(vp);
    }
    assert_eq!(hash(&all), 10_268_600_137_546_105_385);
}
