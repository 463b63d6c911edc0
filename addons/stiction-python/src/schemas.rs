//! The JSON schemas of results, from which `docs/python_api.py` makes Python's classes.

use pyo3::prelude::*;
use schemars::JsonSchema;
use stiction::diagnose::{History, Observation, Repair};
use stiction::fit::{Fit, Prospects};
use stiction::valve_test::{Comparison, Signature, SignaturePlan, TestReading};
use stiction_plant::{groups::Group, scan::Manifest, summary};
use stiction_report::document::{self, Loop};

/// The results with classes made from their schemas, which include the results within them.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its schema is used")]
struct Results {
    diagnosis: Loop<'static>,
    observation: Observation,
    history: History,
    repair: Repair,
    fit: Fit,
    prospects: Prospects,
    test: TestReading,
    comparison: Comparison,
    signature_plan: SignaturePlan,
    signature: Signature,
    check: summary::Checked,
    status: summary::Status,
    scan: Manifest,
    group: Group,
    compensator: stiction::compensate::Description,
    friction_law: stiction::stem::friction::LawEntry,
    fmu_model: stiction_fmu::ModelEntry,
    fmu_variable: stiction_fmu::Variable,
    parameter: stiction::Number,
    tuning: stiction::limit_cycle::tuning::Tuning,
    valve_model: stiction::valve::Description,
}

/// The schemas as one text of JSON.
#[pyfunction]
pub fn result_schemas() -> String {
    document::schema_of::<Results>()
}
