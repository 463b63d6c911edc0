//! What can go wrong while reading and writing, in sentences.

/// Why something could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A scenario does not say what it should.
    #[error("{origin}, line {line}: {message}")]
    Scenario {
        /// The scenario's file or name.
        origin: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong and what would be right.
        message: String,
    },
    /// There is no built-in scenario of that name.
    #[error("there is no scenario file or built-in scenario \"{name}\"; built in are {known}")]
    UnknownScenario {
        /// The name that was asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// A `key=value` setting could not be applied, or several together.
    #[error("settings {}: {message}", settings.join(", "))]
    Setting {
        /// The settings as given.
        settings: Vec<String>,
        /// What is wrong and what would be right.
        message: String,
    },
    /// A mapping file does not say what it should.
    #[error("{origin}, line {line}: {message}")]
    Mapping {
        /// The mapping file.
        origin: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong and what would be right.
        message: String,
    },
    /// A file of overrides does not say what it should.
    #[error("{origin}, line {line}: {message}")]
    Overrides {
        /// The file.
        origin: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong and what would be right.
        message: String,
    },
    /// A table is not well formed.
    #[error("{origin}: {message}")]
    Table {
        /// The table's file.
        origin: String,
        /// What is wrong and what would be right.
        message: String,
    },
    /// No column of a table is known as the OP of a loop, so it may be no recording at all.
    #[error("{origin}: {message}")]
    NoOp {
        /// The table's file.
        origin: String,
        /// What it has instead, and what would be right if it is a recording.
        message: String,
    },
    /// A column of a table is not what it should be.
    #[error("{origin}, column \"{column}\": {message}")]
    Column {
        /// The table's file.
        origin: String,
        /// Name of the column.
        column: String,
        /// What is wrong and what would be right.
        message: String,
    },
    /// A cell of a table is not what it should be.
    #[error("{origin}, row {row}, column \"{column}\": {message}")]
    Cell {
        /// The table's file.
        origin: String,
        /// Row in the file, from 1; the header is row 1.
        row: usize,
        /// Name of the column.
        column: String,
        /// What is wrong and what would be right.
        message: String,
    },
}

/// The result type of this crate.
pub type Result<T> = std::result::Result<T, Error>;
