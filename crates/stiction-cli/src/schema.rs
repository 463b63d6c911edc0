//! `stiction schema`: what the JSON of the other subcommands holds.

use crate::output;
use anyhow::Result;
use clap::Parser;
use clap::builder::PossibleValuesParser;
use stiction_report::document;

/// What has a schema: its name, and what writes the schema.
const SCHEMAS: [(&str, fn() -> String); 2] =
    [("diagnosis", document::schema), ("history", document::history_schema)];

/// Print the JSON schema of what a subcommand prints with --json.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction schema diagnosis
  stiction schema history > history.schema.json")]
pub struct Args {
    /// The document that is described
    #[arg(value_name = "DOCUMENT", value_parser = PossibleValuesParser::new(SCHEMAS.map(|(name, _)| name)))]
    document: String,
}

pub fn run(args: Args) -> Result<()> {
    let asked = SCHEMAS.iter().find(|(name, _)| *name == args.document);
    asked.map_or(Ok(()), |(_, schema)| output::line(schema()))
}
