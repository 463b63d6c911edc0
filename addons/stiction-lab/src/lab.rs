//! The state of a lab.

use crate::paper::Paper;
use crate::{live, plant, recordings};
use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use stiction_io::ReadOptions;

/// The options of a lab.
#[derive(Debug, Clone)]
pub struct Options {
    /// The program with its version, as in results.
    pub tool: String,
    /// Recordings: files, or folders of them.
    pub files: Vec<PathBuf>,
    /// How to read the recordings, as far as it cannot be recognised.
    pub reading: ReadOptions,
    /// The folder of a plant.
    pub plant: Option<PathBuf>,
    /// Draws the figures of the paper.
    pub paper: Paper,
    /// The address to listen on. Beyond the loopback, other machines can also connect, with the token.
    pub host: IpAddr,
    /// The port; 0 for any free one.
    pub port: u16,
}

impl Options {
    /// A lab on the loopback, on any free port, with nothing open.
    pub fn new(tool: impl Into<String>) -> Self {
        Self {
            tool: tool.into(),
            files: vec![],
            reading: ReadOptions::default(),
            plant: None,
            paper: Paper::default(),
            host: Ipv4Addr::LOCALHOST.into(),
            port: 0,
        }
    }
}

/// Locks the state of a room. After a panic it is used as it is.
pub(crate) fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A lab with its rooms.
#[derive(Debug)]
pub struct Lab {
    /// The program, with its version.
    pub(crate) tool: String,
    /// Draws the figures of the paper.
    pub(crate) paper: Paper,
    /// Loops that run.
    pub(crate) lives: live::Room,
    /// Recordings that are open.
    pub(crate) recordings: recordings::Room,
    /// The plant.
    pub(crate) plant: plant::Room,
}

impl Lab {
    /// A lab with these options.
    pub fn new(options: &Options) -> Self {
        Self {
            tool: options.tool.clone(),
            paper: options.paper.clone(),
            lives: live::Room::default(),
            recordings: recordings::Room::new(&options.files, &options.reading),
            plant: plant::Room::new(options.plant.clone()),
        }
    }
}
