//! The events of a plant, as `stiction watch` writes them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use stiction_plant::Store;

/// The file of events, a line of JSON each, in the store.
const NAME: &str = "events.jsonl";
/// Number of bytes that are read at the end of the file.
const TAIL: u64 = 64 << 10;
/// Events that are shown.
const SHOWN: usize = 20;

/// An event of a loop.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Happened {
    /// Kind, such as `new sticking`.
    event: String,
    /// The tag of the loop.
    #[serde(rename = "loop")]
    name: String,
    /// When it was found, such as `2026-03-04T05:10:00+00:00`.
    at: String,
    /// A sentence.
    text: String,
}

/// The last events of the plant in `folder`, the newest first. Without a file, or with lines that cannot be read, there are fewer.
pub(super) fn last(folder: &Path) -> Vec<Happened> {
    let tail = || -> std::io::Result<Vec<u8>> {
        let mut file = File::open(Store::of(folder).path(NAME))?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(TAIL)))?;
        let mut bytes = vec![];
        file.take(TAIL).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let bytes = tail().unwrap_or_default();
    let lines = bytes.split(|byte| *byte == b'\n').rev();
    lines.filter_map(|line| serde_json::from_slice(line).ok()).take(SHOWN).collect()
}
