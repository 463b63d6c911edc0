//! What can go wrong with a plant, in sentences.

/// Why a plant could not be read, scanned or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused.
    #[error("{path}: {source}")]
    File {
        /// The file or folder.
        path: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A plant file does not say what it should; each problem begins with its line.
    #[error("{origin}, {}", problems.join(&format!("\n{origin}, ")))]
    PlantFile {
        /// The file.
        origin: String,
        /// Everything that is wrong, each with what would be right.
        problems: Vec<String>,
    },
    /// A file of the store is not what the store wrote.
    #[error("{origin}: {message}")]
    Store {
        /// The file.
        origin: String,
        /// What is wrong and what would help.
        message: String,
    },
    /// Somebody else writes to the store.
    #[error("{path}: another scan of this plant is running; wait until it ends")]
    Locked {
        /// The file that is locked.
        path: String,
    },
    /// An option cannot be.
    #[error("{0}")]
    Option(String),
    /// The library refused.
    #[error(transparent)]
    Model(#[from] stiction_model::Error),
}

/// The result type of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// The operating system's refusal, with the path it is about.
pub(crate) fn file(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Error + '_ {
    |source| Error::File { path: path.display().to_string(), source }
}

/// What is wrong with a file of the store.
pub(crate) fn store(path: &std::path::Path, message: impl std::fmt::Display) -> Error {
    Error::Store { origin: path.display().to_string(), message: message.to_string() }
}
