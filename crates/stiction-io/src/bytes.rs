//! Bytes of files, devices and streams, some of which never end.

use crate::error::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Limit for reading a stream. A file has its own end.
const MOST: u64 = 1 << 30;

/// All bytes of the file at `path`.
///
/// # Errors
/// If the file cannot be read, or is a device or pipe that does not end within 1 GiB.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    let origin = path.display().to_string();
    let refused = |source| Error::File { path: origin.clone(), source };
    let file = File::open(path).map_err(refused)?;
    if !file.metadata().map_err(refused)?.is_file() {
        return of_stream(file, &origin);
    }
    std::fs::read(path).map_err(refused)
}

/// All bytes of a `stream`; `origin` is its name in errors.
///
/// # Errors
/// If the stream cannot be read, or does not end within 1 GiB.
pub fn of_stream(stream: impl Read, origin: &str) -> Result<Vec<u8>> {
    up_to(MOST, stream, origin)
}

fn up_to(most: u64, stream: impl Read, origin: &str) -> Result<Vec<u8>> {
    let mut bytes = vec![];
    stream
        .take(most + 1)
        .read_to_end(&mut bytes)
        .map_err(|source| Error::File { path: origin.to_owned(), source })?;
    if bytes.len() as u64 > most {
        let message = format!(
            "gives more than {} MiB and may never end; write its output to a file, and read the file",
            MOST >> 20
        );
        return Err(Error::Table { origin: origin.to_owned(), message });
    }
    Ok(bytes)
}

/// Bytes as text.
///
/// # Errors
/// If the bytes are not UTF-8. The error gives the line.
pub fn text(bytes: Vec<u8>, origin: &str) -> Result<String> {
    String::from_utf8(bytes).map_err(|e| Error::Table {
        origin: origin.to_owned(),
        message: format!(
            "line {} is not UTF-8 text; save the file in UTF-8",
            crate::fields::line_of(e.as_bytes(), e.utf8_error().valid_up_to())
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_never_ends_is_refused_and_all_else_read_to_its_end() {
        assert_eq!(up_to(4, &b"abcd"[..], "x").unwrap(), b"abcd");
        let refused = up_to(4, std::io::repeat(b'y'), "/dev/zero").unwrap_err().to_string();
        assert!(refused.starts_with("/dev/zero: gives more than") && refused.contains("to a file"));
        let missing = read(Path::new("no-such-file")).unwrap_err().to_string();
        assert!(missing.starts_with("no-such-file: "), "{missing}");
    }
}
