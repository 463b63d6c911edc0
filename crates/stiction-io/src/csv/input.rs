//! The text of a file, read in pieces if the file is large.

use super::encoding::has_signature;
use crate::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

/// Bytes read at a time.
const CHUNK: usize = 4 << 20;

/// Text, of which more may follow in a file.
pub struct Input<'b> {
    /// The text that was read and is not used yet.
    pub text: Cow<'b, str>,
    rest: Option<Rest<'b>>,
}

struct Rest<'b> {
    reader: Box<dyn Read + 'b>,
    chunk: usize,
    /// The incomplete character at the end of the data.
    begun: Vec<u8>,
}

impl<'b> Input<'b> {
    /// A whole text.
    pub fn whole(text: Cow<'b, str>) -> Self {
        Self { text, rest: None }
    }

    /// Text in UTF-8, read `chunk` bytes at a time.
    pub fn parted(reader: impl Read + 'b, chunk: usize) -> Self {
        let rest = Rest { reader: Box::new(reader), chunk, begun: vec![] };
        Self { text: Cow::Owned(String::new()), rest: Some(rest) }
    }

    /// Whether more text may follow.
    pub fn goes_on(&self) -> bool {
        self.rest.is_some()
    }

    /// Drops the first bytes of the text, and reads on. A text of which nothing is dropped is doubled.
    ///
    /// # Errors
    /// If the file cannot be read, or is no longer UTF-8.
    pub fn pass(&mut self, bytes: usize) -> std::result::Result<(), String> {
        let Some(rest) = &mut self.rest else { return Ok(()) };
        let text = self.text.to_mut();
        text.drain(..bytes);
        let mut read = std::mem::take(&mut rest.begun);
        let most = rest.chunk.max(text.len()) as u64;
        let count = rest.reader.by_ref().take(most).read_to_end(&mut read);
        let count = count.map_err(|error| format!("cannot be read: {error}"))?;
        let valid = match std::str::from_utf8(&read) {
            Ok(all) => all,
            Err(e) if e.error_len().is_none() && count > 0 => {
                rest.begun = read.split_off(e.valid_up_to());
                std::str::from_utf8(&read).unwrap_or_default()
            }
            Err(_) => return Err("changed while it was read; read it again".to_owned()),
        };
        text.push_str(valid);
        if count == 0 {
            self.rest = None;
        }
        Ok(())
    }
}

/// A large file of text in UTF-8, and the SHA-256 of its bytes. `None` for any other file, which is read as a whole.
///
/// # Errors
/// If the file cannot be read.
pub fn large(path: &Path, least: u64) -> Result<Option<(Input<'static>, String)>> {
    let refused = |source| Error::File { path: path.display().to_string(), source };
    let mut file = File::open(path).map_err(refused)?;
    let about = file.metadata().map_err(refused)?;
    if !about.is_file() || about.len() < least {
        return Ok(None);
    }
    let (mut hasher, mut size, mut begun, mut is_first) = (Sha256::new(), 0, vec![], true);
    loop {
        let mut read = std::mem::take(&mut begun);
        let old = read.len();
        let count = file.by_ref().take(CHUNK as u64).read_to_end(&mut read).map_err(refused)?;
        hasher.update(&read[old..]);
        size += count as u64;
        if (is_first && has_signature(&read)) || read.contains(&0) {
            return Ok(None);
        }
        is_first = false;
        match std::str::from_utf8(&read) {
            Ok(_) => {}
            Err(e) if e.error_len().is_none() && count > 0 => {
                begun = read.split_off(e.valid_up_to())
            }
            Err(_) => return Ok(None),
        }
        if count == 0 {
            break;
        }
    }
    file.rewind().map_err(refused)?;
    let mut mark = [0; 3];
    let marked = file.read(&mut mark).map_err(refused)? == 3 && mark == *b"\xef\xbb\xbf";
    if !marked {
        file.rewind().map_err(refused)?;
    }
    // What is appended meanwhile does not belong to the file of this SHA-256.
    let input = Input::parted(file.take(size - 3 * u64::from(marked)), CHUNK);
    Ok(Some((input, format!("{:x}", hasher.finalize()))))
}
