//! `stiction schema`: describes the JSON of the other subcommands.

use crate::{
    bench, compensate, fit, fmu, inspect, limit_cycle, output, plant, simulate, stem, valve_test,
    what_if,
};
use anyhow::Result;
use clap::Parser;
use clap::builder::PossibleValuesParser;
use stiction_report::document::{self, schema_of};

/// The name of a document, and a function that writes its schema.
pub type Described = (&'static str, fn() -> String);

/// All documents with a schema.
pub const SCHEMAS: [Described; 27] = [
    ("diagnosis", document::schema),
    ("history", document::history_schema),
    ("plant-check", schema_of::<stiction_plant::summary::Checked>),
    ("plant-scan", schema_of::<stiction_plant::scan::Manifest>),
    ("plant-report", schema_of::<stiction_plant::report::Reported>),
    ("plant-orders", schema_of::<plant::OrdersOfWeek>),
    ("plant-status", schema_of::<stiction_plant::summary::Status>),
    ("inspect", schema_of::<inspect::Document>),
    ("bench", schema_of::<bench::Document>),
    ("bench-results", schema_of::<bench::ComparedDocument>),
    ("bench-networks", schema_of::<bench::NetworksDocument>),
    ("bench-tests", schema_of::<bench::TestsDocument>),
    ("fit", schema_of::<fit::Document>),
    ("prospects", schema_of::<what_if::FromRecording>),
    ("stem", schema_of::<stem::Document>),
    ("simulate", schema_of::<simulate::Document>),
    ("compensate", schema_of::<compensate::Document>),
    ("what-if", schema_of::<what_if::Document>),
    ("test-plan", schema_of::<valve_test::PlanDocument>),
    ("test-read", schema_of::<valve_test::ReadDocument>),
    ("test-compare", schema_of::<valve_test::CompareDocument>),
    ("signature-plan", schema_of::<valve_test::signature::PlanDocument>),
    ("signature-read", schema_of::<valve_test::signature::ReadDocument>),
    ("signature-compare", schema_of::<valve_test::signature::CompareDocument>),
    ("limit-cycle", schema_of::<limit_cycle::Report>),
    ("fmu-models", schema_of::<fmu::List>),
    ("fmu-variables", schema_of::<fmu::Variables>),
];

/// Print the JSON schema of the document that a subcommand prints with --json.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction schema diagnosis
  stiction schema history > history.schema.json")]
pub struct Args {
    /// The document
    #[arg(value_name = "DOCUMENT", value_parser = PossibleValuesParser::new(SCHEMAS.map(|(name, _)| name)))]
    document: String,
}

pub fn run(args: Args) -> Result<()> {
    let asked = SCHEMAS.iter().find(|(name, _)| *name == args.document);
    asked.map_or(Ok(()), |(_, schema)| output::line(schema()))
}
