//! What the lab knows while it runs.

use crate::paper::Paper;
use crate::{live, plant, recordings};
use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use stiction_io::ReadOptions;

/// What a lab is opened with.
#[derive(Debug, Clone)]
pub struct Options {
    /// The program, with its version, as results name it.
    pub tool: String,
    /// Recordings: files, or folders of them.
    pub files: Vec<PathBuf>,
    /// What the recordings hold; what can be recognised need not be said.
    pub reading: ReadOptions,
    /// The folder of a plant.
    pub plant: Option<PathBuf>,
    /// Draws the figures of the paper.
    pub paper: Paper,
    /// The address to listen on; of others than the loopback, anyone who knows the token can ask.
    pub host: IpAddr,
    /// The port; 0 for any that is free.
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

/// A lab: what its rooms hold.
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
    /// A lab with what was to be opened.
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
