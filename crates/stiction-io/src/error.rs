//! Errors of reading and writing, in sentences.

/// Why something could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: String,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A scenario is not well formed.
    #[error("{origin}, line {line}: {message}")]
    Scenario {
        /// The scenario's file or name.
        origin: String,
        /// Line, from 1.
        line: usize,
        /// The fault and the remedy.
        message: String,
    },
    /// There is no built-in scenario of that name.
    #[error("there is no scenario file or built-in \"{name}\"; built-in scenarios are {known}")]
    UnknownScenario {
        /// The requested name.
        name: String,
        /// The known names.
        known: String,
    },
    /// A `key=value` setting, or several together, could not be applied.
    #[error("settings {}: {message}", settings.join(", "))]
    Setting {
        /// The settings as given.
        settings: Vec<String>,
        /// The fault and the remedy.
        message: String,
    },
    /// A mapping file is not well formed.
    #[error("{origin}, line {line}: {message}")]
    Mapping {
        /// The mapping file.
        origin: String,
        /// Line, from 1.
        line: usize,
        /// The fault and the remedy.
        message: String,
    },
    /// A file of overrides is not well formed.
    #[error("{origin}, line {line}: {message}")]
    Overrides {
        /// The file.
        origin: String,
        /// Line, from 1.
        line: usize,
        /// The fault and the remedy.
        message: String,
    },
    /// A table is not well formed.
    #[error("{origin}: {message}")]
    Table {
        /// The table's file.
        origin: String,
        /// The fault and the remedy.
        message: String,
    },
    /// No column of a table is known as the OP of a loop, so it may not be a recording.
    #[error("{origin}: {message}")]
    NoOp {
        /// The table's file.
        origin: String,
        /// What it has instead, and the remedy if it is a recording.
        message: String,
        /// Whether it has times, as a recording has and a list of tags has not.
        has_times: bool,
    },
    /// A column of a table is wrong.
    #[error("{origin}, column \"{column}\": {message}")]
    Column {
        /// The table's file.
        origin: String,
        /// Name of the column.
        column: String,
        /// The fault and the remedy.
        message: String,
    },
    /// A cell of a table is wrong.
    #[error("{origin}, row {row}, column \"{column}\": {message}")]
    Cell {
        /// The table's file.
        origin: String,
        /// Row in the file, from 1; the header is row 1.
        row: usize,
        /// Name of the column.
        column: String,
        /// The fault and the remedy.
        message: String,
    },
}

/// The result type of this crate.
pub type Result<T> = std::result::Result<T, Error>;
