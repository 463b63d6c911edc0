//! `stiction._core` provides the library's functions to the Python package, one file per part.
//!
//! Classes hold a state or a handle. Functions return dictionaries of plain values and NumPy arrays, which
//! `python/stiction` turns into typed results. Nothing is computed here.

mod arguments;
mod arrays;
mod bands;
mod bench;
mod closed_loop;
mod compensate;
mod detect;
mod diagnosis;
mod dict;
mod errors;
mod fit;
mod fmu;
mod identification;
mod limit_cycle;
mod long;
mod oscillation;
mod own;
mod plant;
mod plant_table;
mod pool;
mod population;
mod recordings;
mod schemas;
mod series;
mod stem;
mod table;
mod valve;
mod valve_test;
mod what_if;
mod whole;

/// The compiled part of the package `stiction`; use the package.
#[pyo3::pymodule(name = "_core")]
mod core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::{
        arrays::arrow_column,
        bands::Bands,
        bench::{
            BenchLoop, BenchResults, BenchSuite, bench_answer, bench_labelled, bench_read,
            bench_suite, bench_suites,
        },
        closed_loop::{
            Scenario, scenario_names, scenario_open, scenario_parse, signal, simulate, sweep,
        },
        compensate::{compare_compensators, compensate_loop, compensators},
        detect::{detect_stiction, detector_methods, method_evidence},
        diagnosis::{
            Diagnosed, diagnose_recordings, diagnoses_document, diagnoses_html, diagnoses_table,
            observations_combined, observations_repair,
        },
        fit::{Fitted, fit_recording},
        fmu::{Fmu, fmu_models},
        identification::{
            cycle_bands, evidence_features, evidence_of, fit_arx, fit_earx, fit_fopdt,
            fit_hammerstein, fit_valve_position, fit_valve_stem, verdict_provenance,
            weigh_evidence, weigh_hammerstein,
        },
        limit_cycle::{
            describing_function, describing_function_branch, frequency_response, lambda_tuning,
            least_amplitude, limit_cycle, limit_cycle_map, limit_cycle_member,
            limit_cycle_trajectory, load_step_iae, loop_parameters, retune, sensitivities, simc,
        },
        oscillation::oscillation_of,
        own::simulate_own,
        plant::{
            Plant, model_version, plant_check, plant_ddl, plant_demo, plant_groups,
            plant_keep_pairs, plant_most_that_counts, plant_pairs, plant_pairs_ddl,
            plant_pairs_schema, plant_propose, plant_ranking, plant_scan, plant_schema,
            plant_status, plant_take, plant_week, plant_windows,
        },
        population::{Loops, population_kinds, population_loops},
        recordings::{
            Recording, loop_types, read_recordings, recording_fitness, recording_kept,
            recording_renamed, recording_segments, recordings_of_arrow, recordings_of_columns,
        },
        schemas::result_schemas,
        series::{
            cycle_period, difference_of_means, half_waves, mann_kendall, reversals, swinging_door,
            zero_crossings,
        },
        stem::{Stem, StemValve, friction_laws, stem_sets},
        table::{ArrowTable, table_of},
        valve::{Valve, valve_models, valve_table},
        valve_test::{
            signature_planned, signature_read, signatures_compared, test_compared, test_planned,
            test_read,
        },
        what_if::what_if_loop,
        whole::write_whole,
    };

    #[pymodule_init]
    fn init(m: &Bound<'_, PyModule>) -> PyResult<()> {
        m.add("__version__", env!("CARGO_PKG_VERSION"))?;
        m.add("POPULATION_VERSION", stiction::population::VERSION)?;
        m.add("TRACE_STEP_S", stiction_plant::trace::STEP_S)?;
        // The package defines what is public.
        m.delattr("__all__")
    }
}
