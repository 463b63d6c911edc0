//! Errors about a plant, in sentences.

/// Why a plant could not be read, scanned or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused.
    #[error("{path}: {source}")]
    File {
        /// The file or folder.
        path: String,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A plant file has mistakes. Each problem begins with its line.
    #[error("{origin}, {}", problems.join(&format!("\n{origin}, ")))]
    PlantFile {
        /// The file.
        origin: String,
        /// All mistakes, each with a remedy.
        problems: Vec<String>,
    },
    /// A file of the store was changed.
    #[error("{origin}: {message}")]
    Store {
        /// The file.
        origin: String,
        /// Fault and remedy.
        message: String,
    },
    /// Another process writes to the store.
    #[error("{path}: another scan of this plant is running; wait until it ends")]
    Locked {
        /// The file that is locked.
        path: String,
    },
    /// An option is invalid.
    #[error("{0}")]
    Option(String),
    /// The library refused.
    #[error(transparent)]
    Model(#[from] stiction_model::Error),
}

/// The result type of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of the operating system, with its path.
pub(crate) fn file(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Error + '_ {
    |source| Error::File { path: path.display().to_string(), source }
}

/// A fault in a file of the store.
pub(crate) fn store(path: &std::path::Path, message: impl std::fmt::Display) -> Error {
    Error::Store { origin: path.display().to_string(), message: message.to_string() }
}
